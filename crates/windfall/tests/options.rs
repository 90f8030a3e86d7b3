//! Everything that a host can choose is built through `windfall::` alone, and a frame of it is drawn.

use std::f32::consts::PI;
use windfall::foliage::{Foliage, Leaf, LeafShape, Palette};
use windfall::forest::{Instance, KeepOut, Placement, Terrain};
use windfall::glam::{DMat4, DVec3, Mat4, Quat, Vec2, Vec3};
use windfall::light::Ambient;
use windfall::material::{Bark, BarkPattern, Image, Material, Surface};
use windfall::path::{FallSettings, Hashed, PathSet, Variation};
use windfall::shed::Shedding;
use windfall::simplify::{Fade, FadeBy, FadeRange, Growth, PruneOrder, Reduction, Simplification};
use windfall::tree::{
    GrowOptions, ImportOptions, LeafCount, Species, Tree, Wood, WoodVertex, prepare,
    prepare_in_order,
};
use windfall::wind::Wind;
use windfall::{
    Camera, Capture, CountReadback, Culling, DebugView, DepthOnly, Falls, Forest, FrameBudget,
    HostCascade, HostLight, HostShadow, Layers, Light, Moment, Options, Picture, Projection,
    Quality, Recording, Renderer, Requirements, Sky, SkyMap, SkyPicture, Timing, Trail, TreeModel,
    TreePlace, View, wgpu,
};

const SIZE: (u32, u32) = (64, 36);

/// A tree by hand: a trunk and two leaves.
fn tree() -> Tree {
    let material = |surface| Material {
        name: "by hand".into(),
        base_color: Vec3::splat(0.5),
        roughness: 0.8,
        alpha_cutoff: None,
        surface,
    };
    let bark = Bark {
        ridge: Vec3::splat(0.3),
        groove: Vec3::splat(0.1),
        scale: 0.2,
        pattern: BarkPattern::Furrowed,
    };
    let vertex = |x: f32, y: f32| WoodVertex {
        position: Vec3::new(x, y, 0.0),
        normal: Vec3::Z,
        uv: Vec2::new(x, y),
        material: 0,
    };
    let wood = Wood {
        vertices: vec![vertex(-0.2, 0.0), vertex(0.2, 0.0), vertex(0.0, 4.0)],
        indices: vec![0, 1, 2],
        materials: vec![material(Surface::Bark(bark))],
        ..Wood::default()
    };
    let shape = LeafShape {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Z],
        normals: vec![Vec3::Y; 3],
        uvs: vec![Vec2::ZERO, Vec2::X, Vec2::Y],
        indices: vec![0, 2, 1],
    };
    let leaf = |y: f32| Leaf {
        center: Vec3::new(0.0, y, 0.0),
        orientation: Quat::IDENTITY,
        scale: 0.5,
        shape: 0,
        material: 0,
        bent_normal: Vec3::Y,
        ambient: 1.0,
        shed_rank: 0,
    };
    let image = Image { width: 1, height: 1, rgba: vec![90, 120, 40, 255] };
    let leaves = material(Surface::Texture(image, false));
    let palette = Palette { stops: vec![Vec3::ONE, Vec3::new(0.8, 0.4, 0.1)], spread: 0.2 };
    let foliage =
        Foliage::assemble(vec![leaf(3.0), leaf(4.0)], vec![shape], vec![leaves], Some(palette), 1);
    let mut tree = Tree { name: "by hand".into(), wood, foliage };
    prepare(&mut tree);
    tree
}

fn simplifications() -> Vec<Simplification> {
    let fades = [
        FadeRange::Constant(0.1),
        FadeRange::Linear(0.1),
        FadeRange::Quadratic(0.2),
        FadeRange::Proportional(0.2),
    ];
    let reductions = [Reduction::Distance { d0: 5.0 }, Reduction::ProjectedArea { b0: 4000.0 }];
    let mut all = vec![Simplification::DEFAULT, Simplification::NONE];
    for (range, reduction) in fades.into_iter().zip(reductions.into_iter().cycle()) {
        for by in [FadeBy::Size, FadeBy::Opacity] {
            all.push(Simplification {
                reduction,
                h: 0.7,
                area_preservation: by == FadeBy::Size,
                growth: Growth { factor: 3.0, pixels: 8.0 },
                color_contrast: false,
                shading_contrast: false,
                mean_cosine: Some(Simplification::PAPER_COSINE),
                contrast_pixels: None,
                fade: Fade { by, range, full_at_one: false, early: true, smooth: true },
                wood_pixels: 1.0,
                leaf_pixels: 6.0,
            });
        }
    }
    all
}

#[test]
fn every_option_is_built_through_the_facade() {
    let (device, queue) = windfall_testing::device();
    let models = [
        tree(),
        Species::Birch.grow_as(
            3,
            &GrowOptions {
                leaves: LeafCount::Exactly(300),
                height: Some(6.0),
                prune_order: Some((PruneOrder::Importance, 1)),
            },
        ),
    ]
    .map(|tree| TreeModel::new(&device, &queue, &tree).unwrap());
    assert_eq!(ImportOptions::default().height, None);
    let mut ordered = Species::Aspen.grow_with(1, 200);
    for order in PruneOrder::ALL {
        prepare_in_order(&mut ordered, order, 1);
    }
    let keep_out = vec![KeepOut { from: Vec2::ZERO, to: Vec2::Y, radius: 3.0 }];
    let placed = Placement { trees: 6, keep_out, ..Placement::default() }
        .place(Terrain::rolling(100.0, 1.0, 2), &[1.0, 2.0]);
    let hashed = Hashed::default();
    let falls = Falls {
        paths: PathSet::builtin(),
        shedding: Shedding { start: 0.0, duration: 60.0, ..Shedding::default() },
        wind: Wind::new(2.0, 0.3, 0.5, 1),
        variation: Variation::Hashed(hashed),
        settings: FallSettings::default(),
        capacity: 10_000,
    };
    let origin = DVec3::new(5_000.0, 10.0, -3_000.0);
    let mut forest = Forest::new(&device, origin, placed.terrain.clone(), falls).unwrap();
    let planted: Vec<Instance> = placed.instances;
    let trees = forest.plant(&models, &planted).unwrap();
    let place = TreePlace { yaw: PI, ..TreePlace::at(origin + DVec3::X * 4.0, 7) };
    let new = forest.insert(&models[0], place).unwrap();
    forest.throw(new, 1, 2.0).unwrap();
    forest.set_transform(trees[0], origin + DVec3::Z, 0.1, 1.5).unwrap();
    forest.remove(trees[1]).unwrap();
    forest.set_season(0.7).unwrap();
    forest.set_wind(Wind::calm());
    forest.set_shedding(Shedding::default());
    assert_eq!(forest.totals().trees, planted.len() as u64);

    let picture = wgpu::TextureFormat::Rgba8UnormSrgb;
    let renderer = Renderer::new(&device, &Options::picture(picture)).unwrap();
    let texture = windfall_testing::picture(&device, SIZE);
    let targets = renderer.targets(SIZE.0, SIZE.1).unwrap();
    let mut state = renderer.view(&forest);
    let radiance = vec![Vec3::ONE; 8 * 4];
    let map = SkyMap::new(&device, &queue, &SkyPicture::new(8, 4, radiance).unwrap());
    let camera = Camera::look_at(
        origin + DVec3::new(0.0, 3.0, 20.0),
        origin + DVec3::new(0.0, 3.0, 0.0),
        0.8,
        0.1,
    );
    let sky = Sky { sun_elevation: 0.4, ..Sky::default() };
    let host = HostLight {
        ambient: Ambient([Vec3::splat(0.1); 9]),
        ..HostLight::new(Vec3::Y, Vec3::ONE, Vec3::splat(0.3))
    };
    let mut views = vec![
        View { light: Light::Sky(sky, Some(map)), ..View::new(camera) },
        View { light: Light::Host(host.clone()), ..View::new(camera) },
    ];
    views.extend(simplifications().into_iter().map(|detail| View {
        detail,
        shadow_detail: detail,
        meadow: 0.9,
        trails: [Trail { from: Vec2::ZERO, to: Vec2::Y, radius: 1.0 }; 4],
        ..View::new(camera)
    }));
    views.extend(Culling::ALL.map(|culling| View { culling, ..View::new(camera) }));
    views.extend(Quality::PRESETS.map(|(_, quality)| View { quality, ..View::new(camera) }));
    views.extend(DebugView::ALL.iter().map(|&show| View { show, ..View::new(camera) }));
    for (i, view) in views.iter().enumerate() {
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut recording =
            Recording { queue: &queue, encoder: &mut encoder, timing: Timing::NONE };
        let moment = Moment { time: 30.0 + i as f64, ..Moment::of(0.0, view) };
        renderer.advance(&mut recording, &mut forest, moment).unwrap();
        let output = &texture.create_view(&Default::default());
        let frame = Picture { targets: &targets, output, layers: &mut [] };
        renderer.render(&mut recording, &forest, &mut state, view, frame).unwrap();
        let counts = CountReadback::encode(&device, &mut encoder, &forest, &state).unwrap();
        let capture = Capture::encode(&device, &mut encoder, &texture);
        queue.submit([encoder.finish()]);
        counts.map();
        capture.map();
        let counts = windfall_testing::wait(&device, || counts.take()).unwrap();
        assert!(counts.trees.visible > 0, "view {i}");
        let rgba = windfall_testing::wait(&device, || capture.take()).unwrap();
        assert!(rgba.chunks(4).any(|p| p[..3] != rgba[..3]), "view {i} shows one colour alone");
    }
    let mut budget = FrameBudget::new(0.02);
    budget.frame(0.03);
    budget.apply(&mut View::new(Camera::look_at(DVec3::ZERO, DVec3::X, 0.9, 0.1)));
}

#[test]
fn a_host_of_every_kind_has_a_renderer() {
    let (device, queue) = windfall_testing::device();
    let depth = wgpu::TextureFormat::Depth32Float;
    let formats = [
        wgpu::TextureFormat::Rgba16Float,
        wgpu::TextureFormat::Bgra8UnormSrgb,
        wgpu::TextureFormat::Rgba8Unorm,
    ];
    let mut forest = Forest::new(&device, DVec3::ZERO, Terrain::flat(), Falls::none()).unwrap();
    let model = TreeModel::new(&device, &queue, &tree()).unwrap();
    forest.insert(&model, TreePlace::at(DVec3::ZERO, 1)).unwrap();
    for (i, color_format) in formats.into_iter().enumerate() {
        let (samples, reversed_depth) = ([1, 4, 1][i], i != 1);
        let depth_only = Some(DepthOnly {
            format: depth,
            reversed: !reversed_depth,
            samples: 1,
            unclipped: false,
        });
        let layers = Layers { shadows: i == 2, ground: i > 0, sky: i == 2, ..Layers::FOLIAGE };
        let options = Options {
            samples,
            reversed_depth,
            depth_only,
            layers,
            ..Options::foliage(color_format, depth)
        };
        let renderer = Renderer::new(&device, &options).unwrap();
        let mut state = renderer.view(&forest);
        let projection = Projection::Matrix(Mat4::perspective_rh(0.8, 16.0 / 9.0, 0.1, 100.0));
        let camera = Camera {
            projection,
            ..Camera::look_at(DVec3::new(0.0, 2.0, 12.0), DVec3::new(0.0, 2.0, 0.0), 0.8, 0.1)
        };
        let map = device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: 4, height: 4, depth_or_array_layers: 3 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: depth,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let cascade = HostCascade { clip_from_world: DMat4::IDENTITY, end: 10.0, texel: 0.1 };
        let shadow = HostShadow {
            view: map.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                ..Default::default()
            }),
            cascades: vec![cascade; i + 1],
            reversed: i == 0,
        };
        let light = HostLight {
            shadow: Some(shadow),
            ..HostLight::new(Vec3::Y, Vec3::ONE, Vec3::splat(0.2))
        };
        let view = View { light: Light::Host(light), ..View::new(camera) };
        let texture = |format, samples| {
            device
                .create_texture(&wgpu::TextureDescriptor {
                    label: None,
                    size: wgpu::Extent3d { width: 64, height: 36, depth_or_array_layers: 1 },
                    mip_level_count: 1,
                    sample_count: samples,
                    dimension: wgpu::TextureDimension::D2,
                    format,
                    usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
                    view_formats: &[],
                })
                .create_view(&Default::default())
        };
        let attachment = |view, load| wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(load),
                store: wgpu::StoreOp::Store,
            }),
            stencil_ops: None,
        };
        let (color, of_color, alone) =
            (texture(color_format, samples), texture(depth, samples), texture(depth, 1));
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut recording = Recording::new(&queue, &mut encoder);
        renderer.advance(&mut recording, &mut forest, Moment::at(1.0)).unwrap();
        renderer.prepare(&mut recording, &forest, &mut state, &view, SIZE).unwrap();
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &color,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations::default(),
                })],
                depth_stencil_attachment: Some(attachment(
                    &of_color,
                    if reversed_depth { 0.0 } else { 1.0 },
                )),
                ..Default::default()
            });
            renderer.draw(&mut pass, &forest, &state).unwrap();
        }
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                depth_stencil_attachment: Some(attachment(&alone, 0.0)),
                ..Default::default()
            });
            renderer.draw_depth(&mut pass, &forest, &state).unwrap();
        }
        queue.submit([encoder.finish()]);
        device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    }
}

/// What an adapter offers is asked before anything is built.
#[test]
fn the_adapter_says_what_it_lacks() {
    let adapter = windfall_testing::adapter();
    let needs = Requirements::of(&adapter).unwrap();
    for off in &needs.off {
        assert!(off.to_string().contains("no "), "{off}");
    }
    assert!(adapter.features().contains(needs.features));
}
