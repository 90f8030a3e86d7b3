//! The limit: the same triangles from one vertex buffer, drawn without a thought.

use crate::gpu::Gpu;
use glam::{Mat4, Vec3};
use std::time::Instant;
use wgpu::util::DeviceExt;

const DRAW: &str = "
@group(0) @binding(0) var<uniform> clip_from_world: mat4x4<f32>;
@vertex
fn vertex(@location(0) at: vec3<f32>) -> @builtin(position) vec4<f32> {
    return clip_from_world * vec4(at, 1.0);
}
@fragment
fn fragment() -> @location(0) vec4<f32> {
    return vec4(0.8, 0.4, 0.1, 1.0);
}";

/// A mesh in world space and what draws it: into the same kind of target as the renderer's.
pub struct Plain {
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    count: u32,
    targets: [wgpu::TextureView; 3],
}

impl Plain {
    pub fn new(
        gpu: &Gpu,
        positions: &[Vec3],
        indices: &[u32],
        clip_from_world: Mat4,
        (width, height): (u32, u32),
    ) -> Self {
        let device = &gpu.device;
        let init = |contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("plain"),
                contents,
                usage,
            })
        };
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("plain"),
            source: wgpu::ShaderSource::Wgsl(DRAW.into()),
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("plain"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[wgpu::VertexBufferLayout {
                    array_stride: 12,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: &wgpu::vertex_attr_array![0 => Float32x3],
                }],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: wgpu::TextureFormat::Depth32Float,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::GreaterEqual),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState { count: 4, ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fragment"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(wgpu::TextureFormat::Rgba16Float.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let matrix = clip_from_world.to_cols_array();
        let camera = init(bytemuck::cast_slice(&matrix), wgpu::BufferUsages::UNIFORM);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("plain"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: camera.as_entire_binding() }],
        });
        let texture = |format, sample_count| {
            device
                .create_texture(&wgpu::TextureDescriptor {
                    label: Some("plain"),
                    size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                    mip_level_count: 1,
                    sample_count,
                    dimension: wgpu::TextureDimension::D2,
                    format,
                    usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
                    view_formats: &[],
                })
                .create_view(&wgpu::TextureViewDescriptor::default())
        };
        let radiance = wgpu::TextureFormat::Rgba16Float;
        let packed: Vec<f32> = positions.iter().flat_map(Vec3::to_array).collect();
        Self {
            group,
            vertices: init(bytemuck::cast_slice(&packed), wgpu::BufferUsages::VERTEX),
            indices: init(bytemuck::cast_slice(indices), wgpu::BufferUsages::INDEX),
            count: indices.len() as u32,
            targets: [
                texture(radiance, 4),
                texture(radiance, 1),
                texture(wgpu::TextureFormat::Depth32Float, 4),
            ],
            pipeline,
        }
    }

    /// Milliseconds of a frame with the first `share` of the triangles, from the first call to the
    /// end of the work.
    pub fn measure(&self, gpu: &Gpu, share: f64) -> anyhow::Result<f64> {
        let start = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("plain"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &self.targets[0],
                    depth_slice: None,
                    resolve_target: Some(&self.targets[1]),
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Discard,
                    },
                })],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &self.targets[2],
                    depth_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(0.0),
                        store: wgpu::StoreOp::Discard,
                    }),
                    stencil_ops: None,
                }),
                ..Default::default()
            });
            let count = (f64::from(self.count) * share) as u32 / 3 * 3;
            if count > 0 {
                pass.set_pipeline(&self.pipeline);
                pass.set_bind_group(0, &self.group, &[]);
                pass.set_vertex_buffer(0, self.vertices.slice(..));
                pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
                pass.draw_indexed(0..count, 0, 0..1);
            }
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        Ok(start.elapsed().as_secs_f64() * 1e3)
    }
}
