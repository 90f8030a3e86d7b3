//! The renderer: a plain ordered list of passes.

use crate::cull::{CpuList, LISTS, VIEWS};
use crate::forest::{FrameStats, GpuForest, TreeCounts};
use crate::listed::ListedFalls;
use crate::model::part_layout;
use crate::pass::hiz::Pyramid;
use crate::pass::shadow::{self, CASCADES, Shadows};
use crate::pass::sky::{SkyLight, SkyPicture, sky_texture};
use crate::pass::{
    Cull, DrawTarget, Falls, Grass, Ground, HiZ, Leaves, ListedOcclusion, ListedPasses,
    ListedTrees, Quads, Shaders, SkyDome, ToneMap, Wood,
};
use crate::shared::{CullFrame, Frame, TreeList};
use crate::view::{Culling, Show, Sky, View};
use bytemuck::Zeroable;
use glam::{Vec3, Vec4};
use std::sync::{Mutex, PoisonError};
use wgpu_profiler::{GpuProfiler, OwningScope, Scope};
use windfall_core::forest::Frustum;
use windfall_core::light::SkyTable;
use windfall_core::simplify::FadeBy;
use windfall_core::wind::Wind;

/// Samples per pixel.
pub(crate) const SAMPLES: u32 = 4;
/// Radiance before tone mapping.
pub(crate) const RADIANCE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Depth: 1 at the near plane, 0 at infinity.
pub(crate) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Pipelines and layouts: made once for a device, the same for every forest and frame.
pub struct Renderer {
    pub(crate) part_layout: wgpu::BindGroupLayout,
    frame_layout: wgpu::BindGroupLayout,
    frame: FrameGroup,
    shadow_frames: [FrameGroup; CASCADES],
    shadows: Shadows,
    hiz: HiZ,
    pub(crate) cull: Cull,
    sky_table: wgpu::Texture,
    sky_sampler: wgpu::Sampler,
    sky_picture: Option<SkyPicture>,
    /// The light of the sky that was drawn last: what it takes to find depends on the sun alone.
    sky_light: Mutex<Option<(Sky, SkyLight)>>,
    ground: Ground,
    grass: Grass,
    wood: Wood,
    leaves: Leaves,
    pub(crate) quads: Quads,
    pub(crate) falls: Falls,
    pub(crate) listed: ListedPasses,
    sky: SkyDome,
    tone_map: ToneMap,
}

/// The uniforms of one camera.
struct FrameGroup {
    buffer: wgpu::Buffer,
    group: wgpu::BindGroup,
}

impl FrameGroup {
    fn new(
        device: &wgpu::Device,
        layout: &wgpu::BindGroupLayout,
        maps: &wgpu::TextureView,
        shadow_sampler: &wgpu::Sampler,
        skies: [&wgpu::TextureView; 2],
        sky_sampler: &wgpu::Sampler,
    ) -> Self {
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: size_of::<Frame>() as u64,
            usage: wgpu::BufferUsages::UNIFORM
                | wgpu::BufferUsages::COPY_DST
                | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let resources = [
            buffer.as_entire_binding(),
            wgpu::BindingResource::TextureView(maps),
            wgpu::BindingResource::Sampler(shadow_sampler),
            wgpu::BindingResource::TextureView(skies[0]),
            wgpu::BindingResource::TextureView(skies[1]),
            wgpu::BindingResource::Sampler(sky_sampler),
        ];
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout,
            entries: &entries,
        });
        Self { buffer, group }
    }
}

fn sky_entry(binding: u32) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT | wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        count: None,
    }
}

/// Fills in the wind.
pub(crate) fn describe_wind(frame: &mut Frame, wind: &Wind) {
    frame.gusts =
        wind.gusts.map(|g| Vec4::new(g.amplitude.x, g.amplitude.y, g.cycles as f32, g.phase));
    frame.wind_mean = wind.mean;
    frame.wind_travel = wind.travel;
    frame.wind_slowness = wind.slowness;
}

/// What the shaders need to know of a forest: its wind, the land about it, what its litter is.
fn describe_forest(frame: &mut Frame, forest: &GpuForest) {
    describe_wind(frame, &forest.wind);
    frame.backdrop = forest.ground.backdrop;
    // Late autumn's colours of all models; of those without a palette, brown.
    let late = |palette: &[Vec4; 8]| (palette[4] + palette[5] + palette[6]).truncate() / 3.0;
    let with_palette = forest.models.iter().filter(|m| m.uniform.palette_count > 0);
    let (sum, count) = with_palette
        .fold((Vec3::ZERO, 0.0), |(sum, n), m| (sum + late(&m.uniform.palette), n + 1.0));
    let brown = Vec3::new(0.33, 0.18, 0.05);
    frame.litter = (sum + brown) / (count + 1.0);
}

/// The textures between the passes, for one size of picture.
pub struct Canvas {
    width: u32,
    height: u32,
    depth: wgpu::TextureView,
    pyramid: Pyramid,
    radiance: wgpu::TextureView,
    tone_map_group: wgpu::BindGroup,
}

/// Where a frame goes.
#[derive(Clone, Copy)]
pub struct Target<'a> {
    /// The textures between the passes.
    pub canvas: &'a Canvas,
    /// The picture: of the canvas's size and the renderer's format, usage `RENDER_ATTACHMENT`.
    pub picture: &'a wgpu::TextureView,
}

impl Canvas {
    /// Pixels in a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Begins to draw against the finished depth, which stays as it is.
    fn begin_counting<'a>(
        &self,
        scope: &'a mut Scope<'_, wgpu::CommandEncoder>,
    ) -> OwningScope<'a, wgpu::RenderPass<'a>> {
        scope.scoped_render_pass(
            "count leaves",
            wgpu::RenderPassDescriptor {
                label: Some("count leaves"),
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &self.depth,
                    depth_ops: None,
                    stencil_ops: None,
                }),
                ..Default::default()
            },
        )
    }

    /// Begins to draw radiance with depth: from nothing or over what is there. Depth is kept where
    /// somebody will ask for it.
    fn begin<'a>(
        &self,
        scope: &'a mut Scope<'_, wgpu::CommandEncoder>,
        label: &str,
        first: bool,
        keep_depth: bool,
    ) -> OwningScope<'a, wgpu::RenderPass<'a>> {
        let store_depth = if keep_depth { wgpu::StoreOp::Store } else { wgpu::StoreOp::Discard };
        let color =
            if first { wgpu::LoadOp::Clear(wgpu::Color::BLACK) } else { wgpu::LoadOp::Load };
        let depth = if first { wgpu::LoadOp::Clear(0.0) } else { wgpu::LoadOp::Load };
        scope.scoped_render_pass(
            label,
            wgpu::RenderPassDescriptor {
                label: Some(label),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &self.radiance,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load: color, store: wgpu::StoreOp::Store },
                })],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &self.depth,
                    depth_ops: Some(wgpu::Operations { load: depth, store: store_depth }),
                    stencil_ops: None,
                }),
                ..Default::default()
            },
        )
    }
}

/// Leaves that the CPU lists, with leaf occlusion.
fn listed_occlusion(listed: Option<&ListedFalls>) -> Option<(&ListedFalls, &ListedOcclusion)> {
    listed.and_then(|listed| Some((listed, listed.occlusion.as_ref()?)))
}

/// What the frame's lists of trees are of.
fn tree_lists(
    view: &View,
    frame: &Frame,
    cascades: &[shadow::Cascade; CASCADES],
    height: u32,
) -> [TreeList; VIEWS] {
    let mut lists = [TreeList::zeroed(); VIEWS];
    lists[0] = TreeList::new(frame.clip_from_world, view, height, &view.detail, view.culling);
    for (list, cascade) in lists[1..].iter_mut().zip(cascades) {
        let detail = &view.shadow_detail;
        *list = TreeList::new(cascade.clip_from_world, view, height, detail, Culling::Sphere);
    }
    lists
}

impl Renderer {
    /// Builds every pipeline for pictures of `format`, which should be an sRGB format: the output
    /// is linear and the hardware encodes it.
    pub fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Self {
        let everywhere = wgpu::ShaderStages::VERTEX_FRAGMENT | wgpu::ShaderStages::COMPUTE;
        let frame_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("frame"),
            entries: &[
                wgpu::BindGroupLayoutEntry {
                    binding: 0,
                    visibility: everywhere,
                    ty: wgpu::BindingType::Buffer {
                        ty: wgpu::BufferBindingType::Uniform,
                        has_dynamic_offset: false,
                        min_binding_size: None,
                    },
                    count: None,
                },
                wgpu::BindGroupLayoutEntry {
                    binding: 1,
                    visibility: everywhere,
                    ty: wgpu::BindingType::Texture {
                        sample_type: wgpu::TextureSampleType::Depth,
                        view_dimension: wgpu::TextureViewDimension::D2Array,
                        multisampled: false,
                    },
                    count: None,
                },
                wgpu::BindGroupLayoutEntry {
                    binding: 2,
                    visibility: everywhere,
                    ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison),
                    count: None,
                },
                sky_entry(3),
                sky_entry(4),
                wgpu::BindGroupLayoutEntry {
                    binding: 5,
                    visibility: everywhere,
                    ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
                    count: None,
                },
            ],
        });
        let shadows = Shadows::new(device);
        let side = SkyTable::SIDE as u32;
        let sky_table = sky_texture(device, "sky table", side, side);
        let sky_sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("sky"),
            address_mode_u: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let no_picture =
            sky_texture(device, "no sky picture", 1, 1).create_view(&Default::default());
        let sky = sky_table.create_view(&Default::default());
        let frame_group = |maps| {
            FrameGroup::new(
                device,
                &frame_layout,
                maps,
                &shadows.sampler,
                [&sky, &no_picture],
                &sky_sampler,
            )
        };
        let part_layout = part_layout(device);
        let shaders = Shaders { device, frame_layout: &frame_layout };
        let hiz = HiZ::new(&shaders);
        Self {
            cull: Cull::new(&shaders, &hiz),
            hiz,
            ground: Ground::new(&shaders),
            grass: Grass::new(&shaders),
            wood: Wood::new(&shaders, &part_layout),
            leaves: Leaves::new(&shaders, &part_layout),
            quads: Quads::new(&shaders, &part_layout),
            falls: Falls::new(&shaders, &part_layout),
            listed: ListedPasses::new(&shaders, &part_layout),
            sky: SkyDome::new(&shaders),
            tone_map: ToneMap::new(&shaders, format),
            part_layout,
            frame: frame_group(&shadows.view),
            // A map cannot be looked up while it is drawn.
            shadow_frames: std::array::from_fn(|_| frame_group(&shadows.nothing)),
            shadows,
            sky_picture: None,
            sky_light: Mutex::new(None),
            frame_layout,
            sky_table,
            sky_sampler,
        }
    }

    /// Takes a picture of the sky as background and ambient light from now on, scaled to the
    /// brightness that the model's sky has at that height of the sun. The sun itself stays the
    /// view's: point it to where the picture has its own.
    pub fn set_sky(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, picture: SkyPicture) {
        let table = self.sky_table.create_view(&Default::default());
        let skies = [&table, &picture.upload(device, queue)];
        let (layout, sampler) = (&self.frame_layout, &self.shadows.sampler);
        self.frame =
            FrameGroup::new(device, layout, &self.shadows.view, sampler, skies, &self.sky_sampler);
        self.sky_picture = Some(picture);
        *self.sky_light.get_mut().unwrap_or_else(PoisonError::into_inner) = None;
    }

    /// What pipelines are made of.
    pub(crate) fn shaders<'a>(&'a self, device: &'a wgpu::Device) -> Shaders<'a> {
        Shaders { device, frame_layout: &self.frame_layout }
    }

    pub(crate) fn grass_layout(&self) -> &wgpu::BindGroupLayout {
        &self.grass.layout
    }

    /// The light of a sky, and its table on the GPU.
    fn sky_light(&self, queue: &wgpu::Queue, sky: &Sky) -> SkyLight {
        let key = Sky { haze: 0.0, exposure: 0.0, clouds: 0.0, ..*sky };
        let mut last = self.sky_light.lock().unwrap_or_else(PoisonError::into_inner);
        match &*last {
            Some((known, light)) if *known == key => light.clone(),
            _ => {
                let light = SkyLight::new(sky, self.sky_picture.as_ref());
                light.write(queue, &self.sky_table);
                *last = Some((key, light.clone()));
                light
            }
        }
    }

    /// Textures for pictures of `width` × `height` pixels, both at least 1 and within the device's
    /// `max_texture_dimension_2d`.
    pub fn canvas(&self, device: &wgpu::Device, width: u32, height: u32) -> Canvas {
        let texture = |label, format, sample_count, usage| {
            device
                .create_texture(&wgpu::TextureDescriptor {
                    label: Some(label),
                    size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                    mip_level_count: 1,
                    sample_count,
                    dimension: wgpu::TextureDimension::D2,
                    format,
                    usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                    view_formats: &[],
                })
                .create_view(&wgpu::TextureViewDescriptor::default())
        };
        let radiance = texture("radiance", RADIANCE, SAMPLES, wgpu::TextureUsages::TEXTURE_BINDING);
        let depth = texture("depth", DEPTH, SAMPLES, wgpu::TextureUsages::TEXTURE_BINDING);
        Canvas {
            width,
            height,
            pyramid: self.hiz.pyramid(device, &depth, (width, height)),
            depth,
            tone_map_group: self.tone_map.bind_group(device, &radiance),
            radiance,
        }
    }

    /// Records one frame into `encoder`.
    ///
    /// Writes the frame's uniforms through `queue`: submit the encoder before the next call.
    pub fn render(
        &self,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        profiler: &GpuProfiler,
        forest: &GpuForest,
        view: &View,
        target: Target<'_>,
    ) -> FrameStats {
        let Target { canvas, picture } = target;
        let light = self.sky_light(queue, &view.sky);
        let picture_sky = self.sky_picture.is_some();
        let mut frame = view.frame(canvas.width, canvas.height, &light, picture_sky);
        describe_forest(&mut frame, forest);
        let cascades = shadow::cascades(view, canvas.width as f32 / canvas.height as f32);
        shadow::describe(&mut frame, &cascades, view.shadows);
        queue.write_buffer(&self.frame.buffer, 0, bytemuck::bytes_of(&frame));

        for (cascade, group) in cascades.iter().zip(&self.shadow_frames) {
            let frame = cascade.frame(&frame, &view.shadow_detail);
            queue.write_buffer(&group.buffer, 0, bytemuck::bytes_of(&frame));
        }
        let lists = tree_lists(view, &frame, &cascades, canvas.height);
        let views = if view.shadows { VIEWS } else { 1 };
        let details = |i: usize| if i == 0 { &view.detail } else { &view.shadow_detail };
        let mut stats = forest.stats();
        let gpu = &forest.lists;
        let on_cpu: Option<Vec<CpuList>> = forest.listed.is_some().then(|| {
            let list = |i: usize| match i % VIEWS {
                view_index if view_index < views => {
                    let (list, detail) = (&lists[view_index], details(view_index));
                    forest.list_on_cpu(list, i >= VIEWS, detail, view)
                }
                _ => CpuList::default(),
            };
            (0..LISTS).map(list).collect()
        });
        if let Some(on_cpu) = &on_cpu {
            let bytes = gpu.placed.size() / LISTS as u64;
            for (i, list) in on_cpu.iter().enumerate() {
                let placed: &[u8] = bytemuck::cast_slice(&list.placed);
                queue.write_buffer(&gpu.placed, i as u64 * bytes, placed);
            }
            stats.drawn = TreeCounts::of(on_cpu[0].tallies);
            stats.drawn.triangles += on_cpu[VIEWS].tallies[4];
        } else {
            let cull = CullFrame {
                top_level: canvas.pyramid.top_level(),
                wind_speed: forest.wind_speed(view),
                ..forest.trees.frame(&lists, view, (canvas.width, canvas.height))
            };
            queue.write_buffer(&gpu.uniform, 0, bytemuck::bytes_of(&cull));
            encoder.clear_buffer(&gpu.arguments, gpu.tallies_offset(), None);
        }
        let occlusion = view.culling == Culling::Occlusion && on_cpu.is_none();
        let leaves = |view: usize| ListedTrees::new(view, on_cpu.as_deref());
        let wood = |view: usize| ListedTrees::new(view + VIEWS, on_cpu.as_deref());
        let falls = &forest.falls;
        let fall_frame = falls.frame(&Frustum::new(frame.clip_from_world), view);
        queue.write_buffer(&falls.uniform, 0, bytemuck::bytes_of(&fall_frame));
        encoder.copy_buffer_to_buffer(
            &falls.arguments,
            0,
            &falls.counters,
            0,
            falls.arguments.size(),
        );

        // Another thread that draws the same forest at the same time is a mistake of the host's; a
        // panic of it leaves lists that the next change of time rebuilds.
        let mut listed =
            forest.listed.as_ref().map(|l| l.lock().unwrap_or_else(PoisonError::into_inner));
        if let Some(listed) = &mut listed {
            let tally = listed.update(queue, encoder, &self.listed, view, &lists[0]);
            stats.leaves_falling = tally.falling;
            stats.leaves_landed = tally.landed;
            stats.leaves_eliminated = tally.eliminated;
            stats.leaves_checked = tally.checked;
        }

        let listed = listed.as_deref();
        // Quads are opaque.
        let by_size = view.detail.fade.by == FadeBy::Size;
        let quads = forest.quads.as_ref().filter(|_| by_size);
        let watched = falls.occlusion.is_some() || listed_occlusion(listed).is_some();
        let mut scope = profiler.scope("frame", encoder);
        if let Some(listed) = listed {
            let mut scope = scope.scope("falls");
            if let Some(occlusion) = &listed.occlusion {
                let tallies = (&falls.counters, falls.sight_tallies());
                occlusion.watch(&mut scope, &self.frame.group, &listed.roster.falling, tallies);
            }
            self.listed.pose(&mut scope, &self.frame.group, listed);
        } else {
            let mut pass = scope.scoped_compute_pass("cull");
            pass.set_bind_group(0, &self.frame.group, &[]);
            self.cull.make(&mut pass, gpu, &canvas.pyramid, views as u32);
            if let Some(quads) = quads {
                self.quads.arrange_hanging(&mut pass, quads);
            }
            drop(pass);
            let mut pass = scope.scoped_compute_pass("find");
            pass.set_bind_group(0, &self.frame.group, &[]);
            self.falls.find(&mut pass, falls);
            drop(pass);
            falls.count_landings(scope.recorder);
            let mut pass = scope.scoped_compute_pass("falls");
            pass.set_bind_group(0, &self.frame.group, &[]);
            self.falls.land(&mut pass.scope("land"), falls);
            self.falls.pose(&mut pass.scope("pose"), falls);
            drop(pass);
            falls.count_changes(scope.recorder);
            let mut pass = scope.scoped_compute_pass("change");
            pass.set_bind_group(0, &self.frame.group, &[]);
            self.falls.change(&mut pass, falls);
        }
        for (i, cascade) in cascades.iter().enumerate().take(views - 1) {
            let mut pass = scope.scoped_render_pass(
                "shadows",
                wgpu::RenderPassDescriptor {
                    label: Some("shadow"),
                    depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                        view: &self.shadows.layers[i],
                        depth_ops: Some(wgpu::Operations {
                            load: wgpu::LoadOp::Clear(1.0),
                            store: wgpu::StoreOp::Store,
                        }),
                        stencil_ops: None,
                    }),
                    ..Default::default()
                },
            );
            pass.set_bind_group(0, &self.shadow_frames[i].group, &[]);
            let size = cascade.size as f32;
            pass.set_viewport(0.0, 0.0, size, size, 0.0, 1.0);
            self.wood.draw(&mut pass, forest, wood(i + 1), DrawTarget::Shadow);
            self.leaves.draw(&mut pass, forest, leaves(i + 1), view, DrawTarget::Shadow);
            // What lies or falls farther away is too small to shade anything.
            if i < 2 {
                if let Some(listed) = listed {
                    self.listed.draw(&mut pass, &forest.models, listed, DrawTarget::Shadow);
                } else {
                    self.falls.draw_shadow(&mut pass, forest);
                }
            }
        }
        let spread = |scope: &mut Scope<'_, wgpu::CommandEncoder>| {
            if let Some(quads) = quads {
                let mut pass = scope.scoped_compute_pass("spread");
                pass.set_bind_group(0, &self.frame.group, &[]);
                self.quads.spread_hanging(&mut pass, forest, quads);
            }
        };
        spread(&mut scope);
        let draw_leaves = |pass: &mut wgpu::RenderPass<'_>| {
            self.leaves.draw(pass, forest, leaves(0), view, DrawTarget::Radiance);
            if let Some(quads) = quads {
                self.quads.draw(pass, quads);
            }
        };
        let alone = view.show.leaves_alone();
        if occlusion {
            // What the frame before did not hide, and the ground, hide the rest of this frame.
            {
                let mut pass = canvas.begin(&mut scope, "visible before", true, true);
                pass.set_bind_group(0, &self.frame.group, &[]);
                if !alone {
                    self.wood.draw(&mut pass.scope("wood"), forest, wood(0), DrawTarget::Radiance);
                }
                draw_leaves(&mut pass.scope("leaves"));
                if !alone {
                    self.ground.draw(&mut pass.scope("ground"), &forest.ground);
                }
            }
            let mut pass = scope.scoped_compute_pass("pyramid");
            self.hiz.build(&mut pass, &canvas.pyramid);
            drop(pass);
            canvas.pyramid.remember(scope.recorder, &self.frame.buffer);
            let mut pass = scope.scoped_compute_pass("cull again");
            pass.set_bind_group(0, &self.frame.group, &[]);
            self.cull.make_hidden(&mut pass, gpu, &canvas.pyramid);
            if let Some(quads) = quads {
                self.quads.arrange_hanging(&mut pass, quads);
            }
            drop(pass);
            spread(&mut scope);
        }
        {
            let mut pass = canvas.begin(&mut scope, "forest", !occlusion, watched);
            pass.set_bind_group(0, &self.frame.group, &[]);
            if !alone {
                self.wood.draw(&mut pass.scope("wood"), forest, wood(0), DrawTarget::Radiance);
            }
            draw_leaves(&mut pass.scope("leaves"));
            if let Some(listed) = listed {
                let mut pass = pass.scope("loose leaves");
                self.listed.draw(&mut pass, &forest.models, listed, DrawTarget::Radiance);
            } else {
                self.falls.draw(&mut pass.scope("loose leaves"), forest);
            }
            if view.quality.grass && !alone {
                self.grass.draw(&mut pass.scope("grass"), &forest.ground);
            }
            if !occlusion && !alone {
                self.ground.draw(&mut pass.scope("ground"), &forest.ground);
            }
            if !alone {
                self.sky.draw(&mut pass.scope("sky"));
            }
            if view.show == Show::Occlusion {
                if let Some((listed, occlusion)) = listed_occlusion(listed) {
                    occlusion.show_skipped(&mut pass, &forest.models, listed);
                } else if let Some(occlusion) = &falls.occlusion {
                    occlusion.show_skipped(&mut pass, forest);
                }
            }
        }
        if watched {
            let mut pass = canvas.begin_counting(&mut scope);
            pass.set_bind_group(0, &self.frame.group, &[]);
            if let Some((listed, occlusion)) = listed_occlusion(listed) {
                occlusion.count(&mut pass, &forest.models, listed, &canvas.depth);
            } else if let Some(occlusion) = &falls.occlusion {
                occlusion.count(&mut pass, forest, &canvas.depth);
            }
        }
        let mut pass = scope.scoped_render_pass(
            "tone map",
            wgpu::RenderPassDescriptor {
                label: Some("tone map"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: picture,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                ..Default::default()
            },
        );
        pass.set_bind_group(0, &self.frame.group, &[]);
        self.tone_map.draw(&mut pass, &canvas.tone_map_group);
        stats
    }
}
