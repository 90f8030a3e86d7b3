//! What hosts may ask for: targets of every kind, devices with the least that there is, and mistakes.

use super::{Gpu, Watched};
use crate::{
    Camera, Capture, CountReadback, Culling, DepthOnly, Falls, Forest, ForestError, HostCascade,
    HostLight, HostShadow, Light, Moment, Options, Picture, Projection, Recording, Renderer,
    RendererError, TreeCounts, TreeModel, TreePlace, View, ViewError, ViewState,
};
use glam::{DMat4, DVec3, Mat4, Vec3, Vec4};
use half::f16;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use windfall_core::forest::{Forest as Placed, Placement, Terrain};
use windfall_core::shed::Shedding;
use windfall_core::simplify::{Reduction, Simplification};
use windfall_tree::Species;

const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
const HDR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// What the device with the least has complained of.
static COMPLAINTS: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// A device as every browser has it, and a renderer of pictures: one for all tests. It keeps what nobody has asked
/// for of its errors.
fn least() -> &'static Gpu {
    static LEAST: OnceLock<Gpu> = OnceLock::new();
    LEAST.get_or_init(|| {
        let (device, queue) = windfall_testing::default_device();
        device.on_uncaptured_error(Arc::new(|error: wgpu::Error| {
            let mut complaints = COMPLAINTS.lock().unwrap_or_else(PoisonError::into_inner);
            complaints.push(error.to_string());
        }));
        let options = Options::picture(wgpu::TextureFormat::Rgba8UnormSrgb);
        Gpu { renderer: Renderer::new(&device, &options).unwrap(), device, queue }
    })
}

/// Fails if the device with the least has had an error.
fn no_complaints() {
    least().device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    let complaints = COMPLAINTS.lock().unwrap_or_else(PoisonError::into_inner);
    assert!(complaints.is_empty(), "{complaints:?}");
}

/// Trees of two species, some of their leaves in the air and on the ground.
pub(super) fn glade() -> (Vec<windfall_core::tree::Tree>, Placed, Falls) {
    let trees = vec![Species::Birch.grow_with(1, 1500), Species::Maple.grow_with(2, 1500)];
    let placement = Placement { trees: 9, spacing: 6.0, seed: 5, ..Placement::default() };
    let placed = placement.place(Terrain::rolling(100.0, 1.0, 4), &[1.0; 2]);
    let shedding = Shedding { start: 0.0, duration: 120.0, ..Shedding::default() };
    (trees, placed, Falls { shedding, capacity: 20_000, ..Falls::default() })
}

fn watched(gpu: &Gpu) -> Watched {
    let (trees, placed, falls) = glade();
    Watched::new(gpu, DVec3::ZERO, &trees, &placed, falls)
}

/// Draws two frames of whole pictures and returns the second, with the trees in it.
pub(super) fn picture(
    gpu: &Gpu,
    watched: &mut Watched,
    view: &View,
    size: (u32, u32),
) -> (Vec<u8>, TreeCounts) {
    let targets = gpu.renderer.targets(size.0, size.1).unwrap();
    let texture = windfall_testing::picture(&gpu.device, size);
    let Watched { forest, state, .. } = watched;
    let mut out = None;
    for _ in 0..2 {
        let output = &texture.create_view(&Default::default());
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut recording = Recording::new(&gpu.queue, &mut encoder);
        gpu.renderer.advance(&mut recording, forest, Moment::of(60.0, view)).unwrap();
        let picture = Picture { targets: &targets, output, layers: &mut [] };
        gpu.renderer.render(&mut recording, forest, state, view, picture).unwrap();
        let counts = CountReadback::encode(&gpu.device, &mut encoder, forest, state).unwrap();
        let capture = Capture::encode(&gpu.device, &mut encoder, &texture);
        gpu.queue.submit([encoder.finish()]);
        counts.map();
        capture.map();
        let rgba = windfall_testing::wait(&gpu.device, || capture.take()).unwrap();
        let counts = windfall_testing::wait(&gpu.device, || counts.take()).unwrap();
        out = Some((rgba, counts.trees));
    }
    out.unwrap()
}

/// Mean difference of two pictures, of 255.
pub(super) fn apart(a: &[u8], b: &[u8]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / a.len() as f64
}

/// Means of a picture over squares of so many pixels.
pub(super) fn blocks(rgba: &[u8], width: usize, side: usize) -> Vec<u8> {
    let height = rgba.len() / 4 / width;
    let mut out = Vec::new();
    for y in (0..height).step_by(side) {
        for x in (0..width).step_by(side) {
            for channel in 0..3 {
                let at = |i: usize| 4 * ((y + i / side) * width + x + i % side) + channel;
                let sum: u32 = (0..side * side).map(|i| u32::from(rgba[at(i)])).sum();
                out.push((sum / (side * side) as u32) as u8);
            }
        }
    }
    out
}

fn from(eye: DVec3) -> View {
    View::new(Camera::look_at(eye, DVec3::Y * 4.0, 0.8, 0.1))
}

/// WebGPU's default limits and no feature: everything is drawn, wood and small leaves in full.
#[test]
fn a_device_of_webgpus_defaults_draws_everything() {
    let (all, few) = (Gpu::get(), least());
    assert!(all.device.features().contains(wgpu::Features::INDIRECT_FIRST_INSTANCE));
    assert_eq!(few.device.limits(), wgpu::Limits::default());
    assert_eq!(few.device.features(), wgpu::Features::empty());
    let (mut on_all, mut on_few) = (watched(all), watched(few));
    for culling in Culling::ALL {
        let near = View { culling, ..from(DVec3::new(0.0, 3.0, 24.0)) };
        let [(a, _), (b, _)] = [(all, &mut on_all), (few, &mut on_few)]
            .map(|(gpu, watched)| picture(gpu, watched, &near, (96, 54)));
        no_complaints();
        // Leaf by leaf they differ: one sways where the other flutters, too.
        let [a, blocks] = [&a, &b].map(|rgba| blocks(rgba, 96, 6));
        assert!(
            apart(&a, &blocks) < 6.0,
            "{culling}: pictures differ by {} of 255",
            apart(&a, &blocks)
        );
        assert!(b.chunks(4).any(|p| p[..3] != b[..3]), "{culling}");
    }
    // In full, each tree has all triangles that it has.
    let none = Simplification::NONE;
    let full = View { detail: none, culling: Culling::Off, ..from(DVec3::new(0.0, 3.0, 24.0)) };
    let (_, counts) = picture(few, &mut on_few, &full, (96, 54));
    assert_eq!(counts.triangles, on_few.forest.totals().triangles);
    // Far away the wood stays as it is; the leaves become fewer.
    let far = View { culling: Culling::Off, ..from(DVec3::new(0.0, 30.0, 400.0)) };
    let (trees, placed, _) = glade();
    let wood: u64 = placed
        .instances
        .iter()
        .map(|instance| trees[instance.model as usize].wood.indices.len() as u64 / 3)
        .sum();
    let (_, on_all) = picture(all, &mut on_all, &far, (96, 54));
    let (_, on_few) = picture(few, &mut on_few, &far, (96, 54));
    assert!(on_all.triangles < wood && on_few.triangles > wood, "{on_all:?} {on_few:?} {wood}");
    assert_eq!(on_few.leaves_by_lambda, on_all.leaves_by_lambda);
    no_complaints();
}

/// What a host's pass has after foliage was drawn: linear colours with the share that is covered, and the depth
/// that its map has.
pub(super) struct HostPass {
    pub colors: Vec<[f32; 4]>,
    pub depth: Vec<f32>,
}

impl HostPass {
    /// Draws foliage as a host of these options does, with the sun behind the camera.
    pub fn draw(
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        renderer: &Renderer,
        (forest, state): (&mut Forest, &mut ViewState),
        view: &View,
        size: (u32, u32),
    ) -> Self {
        let &Options { color_format, reversed_depth, samples, depth_only, .. } = renderer.options();
        let texture = |format, sample_count| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some("host"),
                size: wgpu::Extent3d { width: size.0, height: size.1, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            })
        };
        let only = depth_only.unwrap();
        let (color, map) = (texture(color_format, 1), texture(only.format, 1));
        let whole = color.create_view(&Default::default());
        let sampled = texture(color_format, samples).create_view(&Default::default());
        let depth = texture(DEPTH, samples).create_view(&Default::default());
        let of_map = map.create_view(&Default::default());
        let attachment = |view, reversed: bool| wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(if reversed { 0.0 } else { 1.0 }),
                store: wgpu::StoreOp::Store,
            }),
            stencil_ops: None,
        };
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut recording = Recording::new(queue, &mut encoder);
        renderer.advance(&mut recording, forest, Moment::of(60.0, view)).unwrap();
        renderer.prepare(&mut recording, forest, state, view, size).unwrap();
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: if samples > 1 { &sampled } else { &whole },
                    depth_slice: None,
                    resolve_target: (samples > 1).then_some(&whole),
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                depth_stencil_attachment: Some(attachment(&depth, reversed_depth)),
                ..Default::default()
            });
            renderer.draw(&mut pass, forest, state).unwrap();
        }
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                depth_stencil_attachment: Some(attachment(&of_map, only.reversed)),
                ..Default::default()
            });
            renderer.draw_depth(&mut pass, forest, state).unwrap();
        }
        let capture = Capture::encode(device, &mut encoder, &color);
        let row = (4 * size.0).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("depth"),
            size: u64::from(row * size.1),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        encoder.copy_texture_to_buffer(
            map.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row),
                    rows_per_image: None,
                },
            },
            map.size(),
        );
        queue.submit([encoder.finish()]);
        capture.map();
        let words: Vec<f32> =
            bytemuck::pod_collect_to_vec(&windfall_testing::read(device, queue, &buffer));
        let rows = words.chunks(row as usize / 4);
        let bytes = windfall_testing::wait(device, || capture.take()).unwrap();
        let colors = match color_format {
            HDR => bytes
                .chunks(8)
                .map(|p| [0, 2, 4, 6].map(|i| f16::from_le_bytes([p[i], p[i + 1]]).to_f32()))
                .collect(),
            _ => bytes.chunks(4).map(|p| linear(color_format, p)).collect(),
        };
        Self { colors, depth: rows.flat_map(|row| &row[..size.0 as usize]).copied().collect() }
    }

    /// Share of the picture that is covered.
    pub fn coverage(&self) -> f32 {
        self.colors.iter().map(|c| c[3]).sum::<f32>() / self.colors.len() as f32
    }

    /// Share of the picture where one is covered and the other is not; mean difference of their colours.
    pub fn apart(&self, other: &Self) -> (f32, f32) {
        let of = |channels: std::ops::Range<usize>| {
            let pairs = self.colors.iter().zip(&other.colors);
            let sum: f32 = pairs
                .flat_map(|(a, b)| {
                    channels.clone().map(move |i| (a[i].min(1.0) - b[i].min(1.0)).abs())
                })
                .sum();
            sum / (self.colors.len() * channels.len()) as f32
        };
        (of(3..4), of(0..3))
    }
}

/// A pixel of bytes, linear.
fn linear(format: wgpu::TextureFormat, pixel: &[u8]) -> [f32; 4] {
    let bgra = format == wgpu::TextureFormat::Bgra8UnormSrgb;
    let channel = |i: usize| {
        let v = f32::from(pixel[i]) / 255.0;
        match v {
            v if i == 3 || !format.is_srgb() => v,
            v if v <= 0.04045 => v / 12.92,
            v => ((v + 0.055) / 1.055).powf(2.4),
        }
    };
    let [a, b] = if bgra { [2, 0] } else { [0, 2] };
    [channel(a), channel(1), channel(b), channel(3)]
}

/// A host's sun behind the camera, as bright as fits into 8 bits.
pub(super) fn host_light() -> Light {
    let sun = Vec3::new(0.3, 0.6, 0.7).normalize_or_zero();
    Light::Host(HostLight::new(sun, Vec3::splat(1.5), Vec3::splat(0.3)))
}

/// Targets of every kind show the same foliage, nearest leaves in front, and so do maps of depth.
#[test]
fn every_kind_of_target_shows_the_same_foliage() {
    let gpu = least();
    let (device, size) = (&gpu.device, (128, 72));
    let mut watched = watched(gpu);
    let only = |reversed| Some(DepthOnly { format: DEPTH, reversed, samples: 1, unclipped: false });
    let foliage = |format, reversed_depth, samples| Options {
        reversed_depth,
        samples,
        depth_only: only(reversed_depth),
        ..Options::foliage(format, DEPTH)
    };
    let kinds = [
        foliage(HDR, true, 1),
        foliage(HDR, false, 1),
        foliage(wgpu::TextureFormat::Rgba8Unorm, true, 4),
        foliage(wgpu::TextureFormat::Bgra8UnormSrgb, false, 4),
    ];
    let camera = Camera::look_at(DVec3::new(0.0, 3.0, 24.0), DVec3::Y * 4.0, 0.8, 0.1);
    let aspect = size.0 as f32 / size.1 as f32;
    let mut passes: Vec<HostPass> = Vec::new();
    for options in kinds {
        let projection = if options.reversed_depth {
            camera.projection
        } else {
            Projection::Matrix(Mat4::perspective_rh(0.8, aspect, 0.1, 200.0))
        };
        let view = View { light: host_light(), ..View::new(Camera { projection, ..camera }) };
        let renderer = Renderer::new(device, &options).unwrap();
        let mut state = renderer.view(&watched.forest);
        let of = (device, &gpu.queue);
        let pass = HostPass::draw(of, &renderer, (&mut watched.forest, &mut state), &view, size);
        let cleared = if options.reversed_depth { 0.0 } else { 1.0 };
        // Depth of a sample in the middle of the pixel: there wherever all of it is covered.
        let covered = pass.colors.iter().zip(&pass.depth);
        let missing = covered.filter(|(c, depth)| c[3] == 1.0 && **depth == cleared).count();
        let share = missing as f32 / pass.depth.len() as f32;
        assert!(
            share < if options.samples > 1 { 0.015 } else { 0.002 },
            "{options:?}: {missing} pixels are covered, and have no depth"
        );
        let coverage = pass.coverage();
        assert!((0.1..0.9).contains(&coverage), "{options:?}: {coverage}");
        passes.push(pass);
    }
    // Two with a sample a pixel and two with four; between those pairs, leaf by leaf, edges differ.
    for (pair, most) in [([0, 1], 0.002), ([2, 3], 0.006)] {
        let (coverage, colors) = passes[pair[0]].apart(&passes[pair[1]]);
        assert!(coverage < most && colors < most, "{pair:?}: {coverage} {colors}");
    }
    let mean = |pass: &HostPass| pass.colors.iter().map(|c| Vec4::from(*c)).sum::<Vec4>();
    let (one, four) = (mean(&passes[0]), mean(&passes[2]));
    assert!((one - four).abs().max_element() < 0.04 * one.max_element(), "{one} {four}");
    no_complaints();
}

/// Mistakes of a host have typed errors; the device never hears of them.
#[test]
fn mistakes_never_reach_the_device() {
    let gpu = least();
    let Gpu { device, queue, renderer } = gpu;
    let host = Renderer::new(device, &Options::foliage(HDR, DEPTH)).unwrap();
    let (mut a, b) = (watched(gpu), watched(gpu));
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut recording = Recording::new(queue, &mut encoder);
    let view = from(DVec3::new(0.0, 3.0, 24.0));
    let size = (16, 9);

    // Renderers and targets.
    let options = Options::foliage(HDR, DEPTH);
    let kinds = [
        Options { samples: 2, ..options },
        Options { color_format: DEPTH, ..options },
        Options { depth_format: HDR, ..options },
        Options {
            depth_only: Some(DepthOnly {
                format: HDR,
                reversed: true,
                samples: 1,
                unclipped: false,
            }),
            ..options
        },
        Options {
            depth_only: Some(DepthOnly {
                format: DEPTH,
                reversed: true,
                samples: 3,
                unclipped: false,
            }),
            ..options
        },
        // The device was made without features.
        Options {
            depth_only: Some(DepthOnly {
                format: DEPTH,
                reversed: true,
                samples: 1,
                unclipped: true,
            }),
            ..options
        },
    ];
    for options in kinds {
        let refused = Renderer::new(device, &options).err();
        let typed = matches!(
            refused,
            Some(
                RendererError::Samples { .. }
                    | RendererError::Format { .. }
                    | RendererError::Unclipped
            )
        );
        assert!(typed, "{options:?}: {refused:?}");
    }
    for (size, error) in [
        ((0, 5), ViewError::Empty { width: 0, height: 5 }),
        ((5, 0), ViewError::Empty { width: 5, height: 0 }),
        ((9000, 5), ViewError::TooWide { width: 9000, height: 5, most: 8192 }),
    ] {
        assert_eq!(renderer.targets(size.0, size.1).err(), Some(error));
    }

    // Moments.
    assert!(Forest::new(device, DVec3::INFINITY, Terrain::flat(), Falls::none()).is_err());
    let before = host.prepare(&mut recording, &a.forest, &mut a.state, &view, size);
    assert_eq!(before, Err(ViewError::NotAdvanced));
    for time in [f64::NAN, f64::INFINITY] {
        let refused = host.advance(&mut recording, &mut a.forest, Moment::at(time));
        assert!(matches!(refused, Err(ForestError::Number { .. })), "{refused:?}");
    }
    let refused = Gpu::get().renderer.advance(&mut recording, &mut a.forest, Moment::at(0.0));
    assert!(matches!(refused, Err(ForestError::OtherDevice { .. })), "{refused:?}");
    host.advance(&mut recording, &mut a.forest, Moment::at(60.0)).unwrap();

    // Views.
    let mut prepare =
        |view: &View, size| host.prepare(&mut recording, &a.forest, &mut a.state, view, size);
    assert_eq!(prepare(&view, (0, 9)), Err(ViewError::Empty { width: 0, height: 9 }));
    let of_matrix = |matrix| {
        let projection = Projection::Matrix(matrix);
        View { camera: Camera { projection, ..view.camera }, ..view.clone() }
    };
    for matrix in [Mat4::NAN, Mat4::ZERO, Mat4::IDENTITY * f32::INFINITY] {
        let refused = prepare(&of_matrix(matrix), size);
        assert!(matches!(refused, Err(ViewError::Camera { .. })), "{refused:?}");
    }
    let map = crate::view::state::Placeholders::new(device).maps;
    for cascades in [0, 4] {
        let cascade = HostCascade { clip_from_world: DMat4::IDENTITY, end: 1.0, texel: 0.1 };
        let shadow =
            HostShadow { view: map.clone(), cascades: vec![cascade; cascades], reversed: false };
        let light =
            HostLight { shadow: Some(shadow), ..HostLight::new(Vec3::Y, Vec3::ONE, Vec3::ONE) };
        let refused = prepare(&View { light: Light::Host(light), ..view.clone() }, size);
        assert_eq!(refused, Err(ViewError::Cascades { cascades }));
    }
    assert_eq!(
        host.prepare(&mut recording, &b.forest, &mut a.state, &view, size),
        Err(ViewError::OtherForest)
    );

    // What is drawn is what was prepared.
    let targets = renderer.targets(size.0, size.1).unwrap();
    let output = &windfall_testing::picture(device, size).create_view(&Default::default());
    let picture = Picture { targets: &targets, output, layers: &mut [] };
    let mut recording = Recording::new(queue, &mut encoder);
    let refused = host.render(&mut recording, &a.forest, &mut a.state, &view, picture);
    assert!(matches!(refused, Err(ViewError::NoLayer { .. })), "{refused:?}");
    let mut other = watched(gpu);
    host.advance(&mut recording, &mut other.forest, Moment::at(60.0)).unwrap();
    let never = host.view(&a.forest);
    let mut state = host.view(&a.forest);
    host.prepare(&mut recording, &a.forest, &mut state, &view, size).unwrap();
    // A model that it had no room for: its lists are other ones now.
    let mut grown = watched(gpu);
    let mut outgrown = host.view(&grown.forest);
    host.advance(&mut recording, &mut grown.forest, Moment::at(60.0)).unwrap();
    host.prepare(&mut recording, &grown.forest, &mut outgrown, &view, size).unwrap();
    let new = TreeModel::new(device, queue, &Species::Oak.grow_with(1, 9000)).unwrap();
    for i in 0..70 {
        grown.forest.insert(&new, TreePlace::at(DVec3::X * f64::from(i), i)).unwrap();
    }
    host.advance(&mut recording, &mut grown.forest, Moment::at(60.0)).unwrap();
    let color = Capture::texture(
        device,
        wgpu::Extent3d { width: size.0, height: size.1, depth_or_array_layers: 1 },
        HDR,
    );
    let depth = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: color.size(),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: DEPTH,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &color.create_view(&Default::default()),
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations::default(),
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth.create_view(&Default::default()),
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        let pass = &mut pass;
        assert_eq!(host.draw(pass, &a.forest, &never), Err(ViewError::NotAdvanced));
        assert_eq!(host.draw(pass, &other.forest, &state), Err(ViewError::OtherForest));
        assert_eq!(host.draw(pass, &grown.forest, &outgrown), Err(ViewError::NotPrepared));
        for refused in [
            renderer.draw(pass, &a.forest, &state),
            renderer.draw_depth(pass, &a.forest, &state),
            host.draw_depth(pass, &a.forest, &state),
        ] {
            assert!(matches!(refused, Err(ViewError::NoLayer { .. })), "{refused:?}");
        }
        host.draw(pass, &a.forest, &state).unwrap();
    }
    queue.submit([encoder.finish()]);
    no_complaints();
}

/// A forest that has outgrown the device says so, and is drawn again when it has shrunk.
#[test]
fn a_forest_that_outgrows_the_device_can_shrink_again() {
    let gpu = least();
    let mut watched = watched(gpu);
    let view = View {
        detail: Simplification {
            reduction: Reduction::Distance { d0: 5.0 },
            ..Simplification::DEFAULT
        },
        ..from(DVec3::new(0.0, 3.0, 24.0))
    };
    let (before, _) = picture(gpu, &mut watched, &view, (32, 18));
    let model = watched.models[0].clone();
    let most = wgpu::Limits::default().max_storage_buffer_binding_size / (8 * 64);
    let place = TreePlace::at(DVec3::X * 40.0, 1);
    let more: Vec<_> = (0..=most).map(|_| watched.forest.insert(&model, place).unwrap()).collect();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut recording = Recording::new(&gpu.queue, &mut encoder);
    let refused = gpu.renderer.advance(&mut recording, &mut watched.forest, Moment::at(60.0));
    assert!(matches!(refused, Err(ForestError::TooManyTrees { .. })), "{refused:?}");
    for tree in more {
        watched.forest.remove(tree).unwrap();
    }
    let (after, _) = picture(gpu, &mut watched, &view, (32, 18));
    assert!(before == after, "{}", apart(&before, &after));
    no_complaints();
}
