//! Baselines for the renderer's cost: leaves copied, or drawn unlit in one color, and the least that a whole frame can
//! take.

mod floor;
mod instanced;
mod mesh;
mod submission;

pub use floor::Floor;
pub use instanced::InstancedBaseline;
pub use mesh::MeshBaseline;
pub use submission::{Submission, Submitted};

use glam::Mat4;
use wgpu::util::DeviceExt;

/// Attachments like the renderer's: four samples, resolved color, reversed depth.
struct Attachments {
    color: wgpu::TextureView,
    resolve: wgpu::TextureView,
    depth: wgpu::TextureView,
}

impl Attachments {
    const SAMPLES: u32 = 4;
    const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

    fn new(device: &wgpu::Device, color_format: wgpu::TextureFormat, size: (u32, u32)) -> Self {
        let texture = |format, samples| attachment(device, format, size, samples);
        Self {
            color: texture(color_format, Self::SAMPLES),
            resolve: texture(color_format, 1),
            depth: texture(Self::DEPTH_FORMAT, Self::SAMPLES),
        }
    }

    /// Begins a pass that clears the attachments.
    fn begin_pass<'e>(&self, encoder: &'e mut wgpu::CommandEncoder) -> wgpu::RenderPass<'e> {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("baseline"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.color,
                depth_slice: None,
                resolve_target: Some(&self.resolve),
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Discard,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        })
    }

    /// A pipeline for these attachments. `shader` has the entry points `vertex` and `fragment`.
    fn pipeline(
        device: &wgpu::Device,
        color_format: wgpu::TextureFormat,
        shader: &str,
        buffers: &[wgpu::VertexBufferLayout<'_>],
    ) -> wgpu::RenderPipeline {
        let module = shader_module(device, shader);
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("baseline"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers,
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: Self::DEPTH_FORMAT,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::GreaterEqual),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState { count: Self::SAMPLES, ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fragment"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(color_format.into())],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// A texture to draw into, and to read where it has colours.
fn attachment(
    device: &wgpu::Device,
    format: wgpu::TextureFormat,
    (width, height): (u32, u32),
    sample_count: u32,
) -> wgpu::TextureView {
    let drawn = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("baseline"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: if sample_count > 1 { drawn } else { drawn | wgpu::TextureUsages::COPY_SRC },
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn shader_module(device: &wgpu::Device, source: &str) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("baseline"),
        source: wgpu::ShaderSource::Wgsl(source.to_owned().into()),
    })
}

fn buffer(device: &wgpu::Device, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("baseline"),
        contents,
        usage,
    })
}

/// A bind group of whole buffers, bound from 0 on.
fn bind_group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    buffers: &[&wgpu::Buffer],
) -> wgpu::BindGroup {
    let entries: Vec<wgpu::BindGroupEntry<'_>> = buffers
        .iter()
        .enumerate()
        .map(|(i, buffer)| wgpu::BindGroupEntry {
            binding: i as u32,
            resource: buffer.as_entire_binding(),
        })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("baseline"),
        layout,
        entries: &entries,
    })
}

/// Group 0 of a draw: `clip_from_world` as a uniform.
fn camera_group(
    device: &wgpu::Device,
    pipeline: &wgpu::RenderPipeline,
    clip_from_world: Mat4,
) -> wgpu::BindGroup {
    let matrix = clip_from_world.to_cols_array();
    let camera = buffer(device, bytemuck::cast_slice(&matrix), wgpu::BufferUsages::UNIFORM);
    bind_group(device, &pipeline.get_bind_group_layout(0), &[&camera])
}
