//! Baseline of hanging leaves: the same triangles as one mesh in one draw.

use super::{Attachments, buffer, camera_group};
use glam::{Mat4, Vec3};
use std::time::Instant;
use windfall_host::device::Gpu;

/// Format of the renderer's radiance target.
const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

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

/// A mesh in world space with what draws it.
pub struct MeshBaseline {
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    index_count: u32,
    attachments: Attachments,
}

impl MeshBaseline {
    pub fn new(
        gpu: &Gpu,
        positions: &[Vec3],
        indices: &[u32],
        clip_from_world: Mat4,
        size: (u32, u32),
    ) -> Self {
        let device = &gpu.device;
        let buffers = [wgpu::VertexBufferLayout {
            array_stride: 12,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![0 => Float32x3],
        }];
        let pipeline = Attachments::pipeline(device, COLOR_FORMAT, DRAW, &buffers);
        let packed: Vec<f32> = positions.iter().flat_map(Vec3::to_array).collect();
        let packed = bytemuck::cast_slice(&packed);
        Self {
            group: camera_group(device, &pipeline, clip_from_world),
            pipeline,
            vertices: buffer(device, packed, wgpu::BufferUsages::VERTEX),
            indices: buffer(device, bytemuck::cast_slice(indices), wgpu::BufferUsages::INDEX),
            index_count: indices.len() as u32,
            attachments: Attachments::new(device, COLOR_FORMAT, size),
        }
    }

    /// Draws a frame with the first `share` of the triangles. Wall clock from the first call to the
    /// end of the work, milliseconds.
    pub fn measure(&self, gpu: &Gpu, share: f64) -> anyhow::Result<f64> {
        let start = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = self.attachments.begin_pass(&mut encoder);
            let count = (f64::from(self.index_count) * share) as u32 / 3 * 3;
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
