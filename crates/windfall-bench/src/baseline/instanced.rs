//! Baseline of falling leaves: a compute kernel that only copies, and an instanced draw.

use super::{Attachments, bind_group, buffer, camera_group, shader_module};
use crate::harness::COLOR_FORMAT;
use glam::{Mat4, Quat, Vec3};
use std::time::Instant;
use windfall_core::foliage::LeafShape;
use windfall_core::rng::Rng;
use windfall_host::device::Gpu;

/// Bytes of an instance; the renderer's draw records are as large.
const INSTANCE_BYTES: u64 = 32;

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

/// Copies 32 bytes per leaf, and draws as many instances of one shape at random positions.
pub struct InstancedBaseline {
    copy: wgpu::ComputePipeline,
    copy_group: wgpu::BindGroup,
    draw: wgpu::RenderPipeline,
    draw_group: wgpu::BindGroup,
    instances: wgpu::Buffer,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    index_count: u32,
    instance_count: u32,
    attachments: Attachments,
}

/// Wall clock of each part from its first call to the end of its work, milliseconds.
pub struct InstancedTimes {
    pub copy_ms: f64,
    pub draw_ms: f64,
}

impl InstancedBaseline {
    /// `count` leaves in the box from `low` to `high`.
    pub fn new(
        gpu: &Gpu,
        count: u32,
        shape: &LeafShape,
        (low, high): (Vec3, Vec3),
        clip_from_world: Mat4,
        size: (u32, u32),
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
        let usage = wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::STORAGE;
        let instances = buffer(device, bytemuck::cast_slice(&records), usage);
        let copies = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("copies"),
            size: u64::from(count) * INSTANCE_BYTES,
            usage: wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        });
        let copy = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("copy"),
            layout: None,
            module: &shader_module(device, COPY),
            entry_point: Some("copy"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        let buffers = [
            wgpu::VertexBufferLayout {
                array_stride: 12,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x3],
            },
            wgpu::VertexBufferLayout {
                array_stride: INSTANCE_BYTES,
                step_mode: wgpu::VertexStepMode::Instance,
                attributes: &wgpu::vertex_attr_array![1 => Float32x4, 2 => Snorm16x4],
            },
        ];
        let draw = Attachments::pipeline(device, COLOR_FORMAT, DRAW, &buffers);
        let positions: Vec<f32> = shape.positions.iter().flat_map(Vec3::to_array).collect();
        let positions = bytemuck::cast_slice(&positions);
        let indices: &[u8] = bytemuck::cast_slice(&shape.indices);
        Self {
            copy_group: bind_group(device, &copy.get_bind_group_layout(0), &[&instances, &copies]),
            draw_group: camera_group(device, &draw, clip_from_world),
            copy,
            draw,
            instances,
            vertices: buffer(device, positions, wgpu::BufferUsages::VERTEX),
            indices: buffer(device, indices, wgpu::BufferUsages::INDEX),
            index_count: shape.indices.len() as u32,
            instance_count: count,
            attachments: Attachments::new(device, COLOR_FORMAT, size),
        }
    }

    /// Copies, then draws. The times are wall clock, because timestamps around a single pass are
    /// not reliable on every device.
    pub fn measure(&self, gpu: &Gpu) -> anyhow::Result<InstancedTimes> {
        let start = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.copy);
            pass.set_bind_group(0, &self.copy_group, &[]);
            pass.dispatch_workgroups(self.instance_count.div_ceil(64), 1, 1);
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        let copy_ms = start.elapsed().as_secs_f64() * 1e3;

        let start = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = self.attachments.begin_pass(&mut encoder);
            pass.set_pipeline(&self.draw);
            pass.set_bind_group(0, &self.draw_group, &[]);
            pass.set_vertex_buffer(0, self.vertices.slice(..));
            pass.set_vertex_buffer(1, self.instances.slice(..));
            pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..self.index_count, 0, 0..self.instance_count);
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        Ok(InstancedTimes { copy_ms, draw_ms: start.elapsed().as_secs_f64() * 1e3 })
    }
}
