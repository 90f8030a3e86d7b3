//! The least that a frame can take: targets of the renderer's kind are cleared, as many triangles drawn in one colour,
//! and the four samples of each pixel tone mapped.

use super::{Attachments, attachment, buffer, shader_module};
use crate::harness::COLOR_FORMAT;
use glam::Vec2;
use std::time::Instant;
use windfall_core::rng::Rng;
use windfall_host::device::Gpu;

const SHADER: &str = "
@vertex
fn vertex(@location(0) at: vec2<f32>) -> @builtin(position) vec4<f32> {
    return vec4(at, 0.5, 1.0);
}
@fragment
fn fragment() -> @location(0) vec4<f32> {
    return vec4(0.8, 0.4, 0.1, 1.0);
}
@group(0) @binding(0) var radiance: texture_multisampled_2d<f32>;
@vertex
fn whole(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return vec4(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}
@fragment
fn tone_map(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    var sum = vec3(0.0);
    for (var i = 0; i < 4; i++) {
        let color = textureLoad(radiance, vec2<i32>(at.xy), i).rgb;
        sum += color / (1.0 + color);
    }
    return vec4(0.25 * sum, 1.0);
}";

/// Format of the renderer's radiance target.
const RADIANCE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// How often all triangles together would cover the picture.
const LAYERS: f32 = 2.0;

/// What draws the floor.
pub struct Floor {
    draw: wgpu::RenderPipeline,
    tone_map: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
    corners: wgpu::Buffer,
    count: u32,
    radiance: wgpu::TextureView,
    depth: wgpu::TextureView,
    output: wgpu::TextureView,
}

impl Floor {
    /// For pictures of a size with so many triangles, spread over it at random.
    pub fn new(gpu: &Gpu, size: (u32, u32), triangles: u64) -> Self {
        let device = &gpu.device;
        let corners = [wgpu::VertexBufferLayout {
            array_stride: 8,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![0 => Float32x2],
        }];
        let module = shader_module(device, SHADER);
        let tone_map = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("floor"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("whole"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("tone_map"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(COLOR_FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let radiance = attachment(device, RADIANCE, size, Attachments::SAMPLES);
        let vertices = triangles_over_the_picture(triangles, size.0 as f32 / size.1 as f32);
        Self {
            draw: Attachments::pipeline(device, RADIANCE, SHADER, &corners),
            group: device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("floor"),
                layout: &tone_map.get_bind_group_layout(0),
                entries: &[wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&radiance),
                }],
            }),
            tone_map,
            count: vertices.len() as u32,
            corners: buffer(device, bytemuck::cast_slice(&vertices), wgpu::BufferUsages::VERTEX),
            radiance,
            depth: attachment(device, Attachments::DEPTH_FORMAT, size, Attachments::SAMPLES),
            output: attachment(device, COLOR_FORMAT, size, 1),
        }
    }

    /// Draws a frame. Wall clock from the first call to the end of the work, milliseconds.
    pub fn measure(&self, gpu: &Gpu) -> anyhow::Result<f64> {
        let start = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let color = |view, store| {
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store },
            })
        };
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[color(&self.radiance, wgpu::StoreOp::Store)],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &self.depth,
                    depth_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(0.0),
                        store: wgpu::StoreOp::Discard,
                    }),
                    stencil_ops: None,
                }),
                ..Default::default()
            });
            if self.count > 0 {
                pass.set_pipeline(&self.draw);
                pass.set_vertex_buffer(0, self.corners.slice(..));
                pass.draw(0..self.count, 0..1);
            }
        }
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[color(&self.output, wgpu::StoreOp::Store)],
                ..Default::default()
            });
            pass.set_pipeline(&self.tone_map);
            pass.set_bind_group(0, &self.group, &[]);
            pass.draw(0..3, 0..1);
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        Ok(start.elapsed().as_secs_f64() * 1e3)
    }
}

/// Corners of equal triangles in clip space, which together cover the picture [`LAYERS`] times; never none.
fn triangles_over_the_picture(count: u64, aspect: f32) -> Vec<Vec2> {
    let count = count.max(1);
    let side = Vec2::new(1.0, aspect) * (8.0 * LAYERS / (count as f32 * aspect)).sqrt();
    let mut rng = Rng::new(1);
    let triangle = |_| {
        let at = Vec2::new(rng.range(-1.0, 1.0), rng.range(-1.0, 1.0));
        [at, at + side * Vec2::X, at + side * Vec2::Y]
    };
    (0..count).flat_map(triangle).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_cover_the_picture_as_often_as_is_said() {
        for count in [1, 1000, 54_321] {
            let corners = triangles_over_the_picture(count, 1.5);
            assert_eq!(corners.len() as u64, 3 * count);
            let area = |t: &[Vec2]| 0.5 * (t[1] - t[0]).perp_dot(t[2] - t[0]).abs();
            let sum: f32 = corners.chunks(3).map(area).sum();
            assert!((sum / 4.0 - LAYERS).abs() < 1e-2 * LAYERS, "{count}: {sum}");
        }
    }
}
