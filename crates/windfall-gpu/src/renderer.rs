//! The renderer: a plain ordered list of passes.

use crate::forest::{FrameStats, GpuForest};
use crate::model::part_layout;
use crate::pass::{Falls, Ground, Leaves, ListedPasses, Shaders, SkyDome, ToneMap, Wood};
use crate::shared::Frame;
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
    frame: wgpu::Buffer,
    frame_group: wgpu::BindGroup,
    ground: Ground,
    wood: Wood,
    leaves: Leaves,
    pub(crate) falls: Falls,
    pub(crate) listed: ListedPasses,
    sky: SkyDome,
    tone_map: ToneMap,
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
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::VERTEX_FRAGMENT | wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            }],
        });
        let frame = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: size_of::<Frame>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let frame_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout: &frame_layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: frame.as_entire_binding() }],
        });
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
            frame,
            frame_group,
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
        let frame = view.frame(canvas.width, canvas.height);
        queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&frame));
        let (visible, mut stats) =
            forest.cull(queue, &Frustum::new(frame.clip_from_world), view.time);
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

        let trees = visible.last().map_or(0, |range| range.end);
        let falls = &forest.falls;
        let fall_frame = falls.frame(frame.clip_from_world, view, trees);
        queue.write_buffer(&falls.uniform, 0, bytemuck::bytes_of(&fall_frame));
        encoder.copy_buffer_to_buffer(
            &falls.arguments,
            0,
            &falls.counters,
            0,
            falls.arguments.size(),
        );

        let mut scope = profiler.scope("frame", encoder);
        if let Some(listed) = &listed {
            self.listed.pose(&mut scope.scope("falls"), &self.frame_group, listed);
        } else {
            let mut pass = scope.scoped_compute_pass("falls");
            pass.set_bind_group(0, &self.frame_group, &[]);
            self.falls.detach(&mut pass.scope("detach"), &forest.detach_group, trees);
            self.falls.land(&mut pass.scope("land"), falls);
            self.falls.pose(&mut pass.scope("pose"), falls);
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
            pass.set_bind_group(0, &self.frame_group, &[]);
            self.wood.draw(&mut pass.scope("wood"), forest, &visible);
            self.leaves.draw(&mut pass.scope("leaves"), forest, &visible);
            if let Some(listed) = &listed {
                self.listed.draw(&mut pass.scope("loose leaves"), &forest.models, listed);
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
        pass.set_bind_group(0, &self.frame_group, &[]);
        self.tone_map.draw(&mut pass, &canvas.tone_map_group);
        stats
    }
}
