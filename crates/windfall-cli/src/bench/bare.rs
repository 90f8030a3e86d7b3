//! What poses and draws are measured against: a kernel that only copies, a draw without thought.

use super::stand::FORMAT;
use crate::gpu::Gpu;
use glam::{Mat4, Quat, Vec3};
use std::time::Instant;
use wgpu::util::DeviceExt;
use windfall_core::foliage::LeafShape;
use windfall_core::rng::Rng;

/// Bytes of a leaf, as it is drawn.
const LEAF: u64 = 32;

const COPY: &str = "
@group(0) @binding(0) var<storage, read> source: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read_write> copies: array<vec4<u32>>;
@compute @workgroup_size(64)
fn copy(@builtin(global_invocation_id) id: vec3<u32>) {
    copies[2u * id.x] = source[2u * id.x];
    copies[2u * id.x + 1u] = source[2u * id.x + 1u];
}";

const DRAW: &str = "
@group(0) @binding(0) var<uniform> clip_from_world: mat4x4<f32>;
@vertex
fn vertex(@location(0) at: vec3<f32>, @location(1) place: vec4<f32>, @location(2) q: vec4<f32>)
    -> @builtin(position) vec4<f32> {
    let t = 2.0 * cross(q.xyz, at);
    let turned = at + q.w * t + cross(q.xyz, t);
    return clip_from_world * vec4(place.xyz + turned * place.w, 1.0);
}
@fragment
fn fragment() -> @location(0) vec4<f32> {
    return vec4(0.8, 0.4, 0.1, 1.0);
}";

/// Copies 32 bytes for each leaf, and draws as many leaves of one shape at random places.
pub struct Bare {
    copy: wgpu::ComputePipeline,
    copy_group: wgpu::BindGroup,
    draw: wgpu::RenderPipeline,
    draw_group: wgpu::BindGroup,
    leaves: wgpu::Buffer,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    index_count: u32,
    count: u32,
    targets: [wgpu::TextureView; 3],
}

impl Bare {
    pub fn new(
        gpu: &Gpu,
        count: u32,
        shape: &LeafShape,
        (low, high): (Vec3, Vec3),
        clip_from_world: Mat4,
        (width, height): (u32, u32),
    ) -> Self {
        let device = &gpu.device;
        let mut rng = Rng::new(1);
        let mut records: Vec<[u32; 8]> = Vec::with_capacity(count as usize);
        for _ in 0..count {
            let at = low + (high - low) * Vec3::new(rng.unit(), rng.unit(), rng.unit());
            let turn = Quat::from_xyzw(rng.normal(), rng.normal(), rng.normal(), rng.normal());
            let q = turn.normalize().to_array().map(|c| u32::from((c * 32767.0) as i16 as u16));
            let [x, y, z] = at.to_array().map(f32::to_bits);
            let (xy, zw) = (q[0] | q[1] << 16, q[2] | q[3] << 16);
            records.push([x, y, z, 1.0f32.to_bits(), xy, zw, 0, 0]);
        }
        let bytes: Vec<u8> = records.iter().flatten().flat_map(|w| w.to_le_bytes()).collect();
        let leaves = init(device, &bytes, wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::STORAGE);
        let to = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("copies"),
            size: u64::from(count) * LEAF,
            usage: wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        });
        let module = |source: &str| {
            device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("bare"),
                source: wgpu::ShaderSource::Wgsl(source.to_owned().into()),
            })
        };
        let copy = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("copy"),
            layout: None,
            module: &module(COPY),
            entry_point: Some("copy"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        let draw_module = module(DRAW);
        let draw = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("bare draw"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &draw_module,
                entry_point: Some("vertex"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[
                    wgpu::VertexBufferLayout {
                        array_stride: 12,
                        step_mode: wgpu::VertexStepMode::Vertex,
                        attributes: &wgpu::vertex_attr_array![0 => Float32x3],
                    },
                    wgpu::VertexBufferLayout {
                        array_stride: LEAF,
                        step_mode: wgpu::VertexStepMode::Instance,
                        attributes: &wgpu::vertex_attr_array![1 => Float32x4, 2 => Snorm16x4],
                    },
                ],
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
                module: &draw_module,
                entry_point: Some("fragment"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let camera: Vec<u8> =
            clip_from_world.to_cols_array().iter().flat_map(|v| v.to_le_bytes()).collect();
        let camera = init(device, &camera, wgpu::BufferUsages::UNIFORM);
        let group = |layout: &wgpu::BindGroupLayout, buffers: &[&wgpu::Buffer]| {
            let entries: Vec<wgpu::BindGroupEntry<'_>> = buffers
                .iter()
                .enumerate()
                .map(|(i, buffer)| wgpu::BindGroupEntry {
                    binding: i as u32,
                    resource: buffer.as_entire_binding(),
                })
                .collect();
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("bare"),
                layout,
                entries: &entries,
            })
        };
        let texture = |format, sample_count| {
            device
                .create_texture(&wgpu::TextureDescriptor {
                    label: Some("bare"),
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
        let positions: Vec<u8> =
            shape.positions.iter().flat_map(Vec3::to_array).flat_map(f32::to_le_bytes).collect();
        let indices: Vec<u8> = shape.indices.iter().flat_map(|i| i.to_le_bytes()).collect();
        Self {
            copy_group: group(&copy.get_bind_group_layout(0), &[&leaves, &to]),
            draw_group: group(&draw.get_bind_group_layout(0), &[&camera]),
            copy,
            draw,
            leaves,
            vertices: init(device, &positions, wgpu::BufferUsages::VERTEX),
            indices: init(device, &indices, wgpu::BufferUsages::INDEX),
            index_count: shape.indices.len() as u32,
            count,
            targets: [
                texture(FORMAT, 4),
                texture(FORMAT, 1),
                texture(wgpu::TextureFormat::Depth32Float, 4),
            ],
        }
    }

    /// Milliseconds of the copy and of the draw, each from its first call to the end of the work:
    /// timestamps about a pass that stands alone are not to be trusted on every device.
    pub fn measure(&self, gpu: &Gpu) -> anyhow::Result<(f64, f64)> {
        let begin = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.copy);
            pass.set_bind_group(0, &self.copy_group, &[]);
            pass.dispatch_workgroups(self.count.div_ceil(64), 1, 1);
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        let copy = begin.elapsed().as_secs_f64() * 1e3;

        let start = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("bare draw"),
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
            pass.set_pipeline(&self.draw);
            pass.set_bind_group(0, &self.draw_group, &[]);
            pass.set_vertex_buffer(0, self.vertices.slice(..));
            pass.set_vertex_buffer(1, self.leaves.slice(..));
            pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..self.index_count, 0, 0..self.count);
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        Ok((copy, start.elapsed().as_secs_f64() * 1e3))
    }
}

fn init(device: &wgpu::Device, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("bare"),
        contents,
        usage,
    })
}
