//! The renderer: a plain ordered list of passes.

use crate::forest::{FrameStats, GpuForest, Visible};
use crate::model::part_layout;
use crate::pass::shadow::{self, CASCADES, Shadows, Volume};
use crate::pass::{
    DrawTarget, Falls, Ground, Leaves, ListedPasses, Shaders, SkyDome, ToneMap, Wood,
};
use crate::shared::{Frame, TreeInstance};
use crate::view::View;
use std::sync::PoisonError;
use wgpu_profiler::GpuProfiler;
use windfall_core::forest::Frustum;

/// Samples per pixel.
pub(crate) const SAMPLES: u32 = 4;
/// Radiance before tone mapping.
pub(crate) const RADIANCE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Depth: 1 at the near plane, 0 at infinity.
pub(crate) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Pipelines and layouts: made once for a device, the same for every forest and frame.
pub struct Renderer {
    pub(crate) part_layout: wgpu::BindGroupLayout,
    frame: FrameGroup,
    shadow_frames: [FrameGroup; CASCADES],
    shadows: Shadows,
    ground: Ground,
    wood: Wood,
    leaves: Leaves,
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

/// The textures between the passes, for one size of picture.
pub struct Canvas {
    width: u32,
    height: u32,
    multisampled: wgpu::TextureView,
    depth: wgpu::TextureView,
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
}

impl Renderer {
    /// Builds every pipeline for pictures of `format`, which should be an sRGB format: the output
    /// is linear and the hardware encodes it.
    pub fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Self {
        let frame_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("frame"),
            entries: &[
                wgpu::BindGroupLayoutEntry {
                    binding: 0,
                    visibility: wgpu::ShaderStages::VERTEX_FRAGMENT | wgpu::ShaderStages::COMPUTE,
                    ty: wgpu::BindingType::Buffer {
                        ty: wgpu::BufferBindingType::Uniform,
                        has_dynamic_offset: false,
                        min_binding_size: None,
                    },
                    count: None,
                },
                wgpu::BindGroupLayoutEntry {
                    binding: 1,
                    visibility: wgpu::ShaderStages::FRAGMENT,
                    ty: wgpu::BindingType::Texture {
                        sample_type: wgpu::TextureSampleType::Depth,
                        view_dimension: wgpu::TextureViewDimension::D2Array,
                        multisampled: false,
                    },
                    count: None,
                },
                wgpu::BindGroupLayoutEntry {
                    binding: 2,
                    visibility: wgpu::ShaderStages::FRAGMENT,
                    ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison),
                    count: None,
                },
            ],
        });
        let shadows = Shadows::new(device);
        let frame_group = |maps: &wgpu::TextureView| {
            let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("frame"),
                size: size_of::<Frame>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("frame"),
                layout: &frame_layout,
                entries: &[
                    wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() },
                    wgpu::BindGroupEntry {
                        binding: 1,
                        resource: wgpu::BindingResource::TextureView(maps),
                    },
                    wgpu::BindGroupEntry {
                        binding: 2,
                        resource: wgpu::BindingResource::Sampler(&shadows.sampler),
                    },
                ],
            });
            FrameGroup { buffer, group }
        };
        let part_layout = part_layout(device);
        let shaders = Shaders { device, frame_layout: &frame_layout };
        Self {
            ground: Ground::new(&shaders),
            wood: Wood::new(&shaders, &part_layout),
            leaves: Leaves::new(&shaders, &part_layout),
            falls: Falls::new(&shaders, &part_layout),
            listed: ListedPasses::new(&shaders, &part_layout),
            sky: SkyDome::new(&shaders),
            tone_map: ToneMap::new(&shaders, format),
            part_layout,
            frame: frame_group(&shadows.view),
            // A map cannot be looked up while it is drawn.
            shadow_frames: std::array::from_fn(|_| frame_group(&shadows.nothing)),
            shadows,
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
        let none = wgpu::TextureUsages::empty();
        let radiance = texture("radiance", RADIANCE, 1, wgpu::TextureUsages::TEXTURE_BINDING);
        Canvas {
            width,
            height,
            multisampled: texture("multisampled radiance", RADIANCE, SAMPLES, none),
            depth: texture("depth", DEPTH, SAMPLES, none),
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
        let mut frame = view.frame(canvas.width, canvas.height);
        let cascades = shadow::cascades(view, canvas.width as f32 / canvas.height as f32);
        shadow::describe(&mut frame, &cascades, view.shadows);
        queue.write_buffer(&self.frame.buffer, 0, bytemuck::bytes_of(&frame));

        let mut trees = Vec::new();
        let frustum = Frustum::new(frame.clip_from_world);
        let visible = forest.cull(&Volume::View(&frustum), view.time, &mut trees);
        let in_view = trees.len() as u32;
        let mut stats = forest.stats(&visible);
        let casters: Vec<Vec<Visible>> = if view.shadows {
            cascades
                .iter()
                .map(|c| forest.cull(&Volume::Shadow(c), view.time, &mut trees))
                .collect()
        } else {
            Vec::new()
        };
        for (cascade, group) in cascades.iter().zip(&self.shadow_frames) {
            queue.write_buffer(&group.buffer, 0, bytemuck::bytes_of(&cascade.frame(&frame)));
        }
        queue.write_buffer(&forest.instances, 0, bytemuck::cast_slice(&trees));
        if forest.listed.is_some() {
            let hanging = |tree: &TreeInstance| u64::from(tree.leaf_count - tree.detached);
            stats.leaves_hanging = trees[..in_view as usize].iter().map(hanging).sum();
        }
        let trees = trees.len() as u32;
        let falls = &forest.falls;
        let fall_frame = falls.frame(&frustum, view, in_view, trees);
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
            let tally = listed.update(queue, encoder, &self.listed, view);
            stats.leaves_falling = tally.falling;
            stats.leaves_landed = tally.landed;
            stats.leaves_eliminated = tally.eliminated;
            stats.leaves_checked = tally.checked;
        }

        let mut scope = profiler.scope("frame", encoder);
        if let Some(listed) = &listed {
            self.listed.pose(&mut scope.scope("falls"), &self.frame.group, listed);
        } else {
            let mut pass = scope.scoped_compute_pass("detach");
            pass.set_bind_group(0, &self.frame.group, &[]);
            self.falls.detach(&mut pass, &forest.detach_group, trees);
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
        for (i, casters) in casters.iter().enumerate() {
            let mut pass = scope.scoped_render_pass(
                format!("shadow {i}"),
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
            self.wood.draw_shadow(&mut pass, forest, casters);
            self.leaves.draw_shadow(&mut pass, forest, casters);
            // What lies or falls farther away is too small to shade anything.
            if i < 2 {
                if let Some(listed) = &listed {
                    self.listed.draw(&mut pass, &forest.models, listed, DrawTarget::Shadow);
                } else {
                    self.falls.draw_shadow(&mut pass, forest);
                }
            }
        }
        {
            let mut pass = scope.scoped_render_pass(
                "forest",
                wgpu::RenderPassDescriptor {
                    label: Some("forest"),
                    color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                        view: &canvas.multisampled,
                        depth_slice: None,
                        resolve_target: Some(&canvas.radiance),
                        ops: wgpu::Operations {
                            load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                            store: wgpu::StoreOp::Discard,
                        },
                    })],
                    depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                        view: &canvas.depth,
                        depth_ops: Some(wgpu::Operations {
                            load: wgpu::LoadOp::Clear(0.0),
                            store: wgpu::StoreOp::Discard,
                        }),
                        stencil_ops: None,
                    }),
                    ..Default::default()
                },
            );
            pass.set_bind_group(0, &self.frame.group, &[]);
            self.wood.draw(&mut pass.scope("wood"), forest, &visible);
            self.leaves.draw(&mut pass.scope("leaves"), forest, &visible);
            if let Some(listed) = &listed {
                let mut pass = pass.scope("loose leaves");
                self.listed.draw(&mut pass, &forest.models, listed, DrawTarget::Radiance);
            } else {
                self.falls.draw(&mut pass.scope("loose leaves"), forest);
            }
            self.ground.draw(&mut pass.scope("ground"), &forest.ground);
            self.sky.draw(&mut pass.scope("sky"));
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
