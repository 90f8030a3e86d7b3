//! Ways to hand a tree's leaves to the GPU, as SFS 4.2 compares them.
//!
//! OpenGL's immediate mode and vertex arrays are gone; what they did is not: a call for each small piece of geometry,
//! whose data the driver copies; one call, whose data it copies; and data that the GPU keeps.

use super::{Attachments, buffer, camera_group};
use crate::harness::COLOR_FORMAT;
use glam::{Mat4, Quat, Vec2, Vec3};
use std::ops::Range;
use std::time::Instant;
use windfall_core::tree::Tree;
use windfall_host::device::Gpu;

/// How leaves reach the GPU.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Submission {
    /// Each leaf's corners are written and drawn by calls of their own (OpenGL: immediate mode).
    Immediate,
    /// All corners are written in each frame and drawn by one call (OpenGL: vertex arrays).
    Arrays,
    /// Buffers that stay on the GPU, drawn by one call (OpenGL: vertex buffer objects).
    Buffers,
    /// Buffers with a record for each leaf, drawn by a call for each shape: what the renderer does.
    Instances,
}

impl Submission {
    pub const ALL: [Self; 4] = [Self::Immediate, Self::Arrays, Self::Buffers, Self::Instances];
}

/// A corner of a triangle, with what SFS gives each vertex.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Corner {
    position: Vec3,
    normal: Vec3,
    uv: Vec2,
    color: u32,
}

/// A leaf as an instance.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Place {
    center: Vec3,
    scale: f32,
    orientation: Quat,
}

/// The instances of a shape.
struct Shape {
    corners: Range<u32>,
    instances: Range<u32>,
}

const VERTEX: &str = "
@group(0) @binding(0) var<uniform> clip_from_world: mat4x4<f32>;
struct Shaded {
    @builtin(position) clip: vec4<f32>,
    @location(0) color: vec3<f32>,
}
fn shaded(at: vec3<f32>, normal: vec3<f32>, uv: vec2<f32>, color: vec4<f32>) -> Shaded {
    let light = 0.5 + 0.5 * abs(normal.y);
    return Shaded(clip_from_world * vec4(at, 1.0), color.rgb * light * (0.8 + 0.2 * uv.y));
}
@fragment
fn fragment(in: Shaded) -> @location(0) vec4<f32> {
    return vec4(in.color, 1.0);
}";

const CORNERS: &str = "
@vertex
fn vertex(@location(0) at: vec3<f32>, @location(1) normal: vec3<f32>, @location(2) uv: vec2<f32>,
    @location(3) color: vec4<f32>) -> Shaded {
    return shaded(at, normal, uv, color);
}";

const INSTANCES: &str = "
fn turned(q: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
    let t = 2.0 * cross(q.xyz, v);
    return v + q.w * t + cross(q.xyz, t);
}
@vertex
fn vertex(@location(0) at: vec3<f32>, @location(1) normal: vec3<f32>, @location(2) uv: vec2<f32>,
    @location(3) color: vec4<f32>, @location(4) place: vec4<f32>, @location(5) q: vec4<f32>) -> Shaded {
    return shaded(place.xyz + turned(q, at) * place.w, turned(q, normal), uv, color);
}";

/// The leaves of one tree, ready for each [`Submission`].
pub struct Submitted {
    corners: Vec<Corner>,
    /// Corners of each leaf, in the order of the leaves.
    leaves: Vec<Range<u32>>,
    shapes: Vec<Shape>,
    /// Filled anew in each frame, and once.
    streamed: wgpu::Buffer,
    kept: wgpu::Buffer,
    of_shapes: wgpu::Buffer,
    places: wgpu::Buffer,
    plain: (wgpu::RenderPipeline, wgpu::BindGroup),
    instanced: (wgpu::RenderPipeline, wgpu::BindGroup),
    attachments: Attachments,
}

impl Submitted {
    pub fn new(gpu: &Gpu, tree: &Tree, clip_from_world: Mat4, size: (u32, u32)) -> Self {
        let device = &gpu.device;
        let foliage = &tree.foliage;
        let (mut corners, mut leaves) = (Vec::new(), Vec::new());
        for leaf in &foliage.leaves {
            let first = corners.len() as u32;
            corners.extend(shape_corners(tree, leaf.shape).map(|corner| Corner {
                position: leaf.center + leaf.orientation * corner.position * leaf.scale,
                normal: leaf.orientation * corner.normal,
                ..corner
            }));
            leaves.push(first..corners.len() as u32);
        }
        let (mut of_shapes, mut places, mut shapes) = (Vec::new(), Vec::new(), Vec::new());
        for shape in 0..foliage.shapes.len() as u32 {
            let first = [of_shapes.len() as u32, places.len() as u32];
            of_shapes.extend(shape_corners(tree, shape));
            places.extend(foliage.leaves.iter().filter(|leaf| leaf.shape == shape).map(|leaf| {
                Place { center: leaf.center, scale: leaf.scale, orientation: leaf.orientation }
            }));
            shapes.push(Shape {
                corners: first[0]..of_shapes.len() as u32,
                instances: first[1]..places.len() as u32,
            });
        }
        let corner = wgpu::VertexBufferLayout {
            array_stride: size_of::<Corner>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![
                0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Unorm8x4
            ],
        };
        let place = wgpu::VertexBufferLayout {
            array_stride: size_of::<Place>() as u64,
            step_mode: wgpu::VertexStepMode::Instance,
            attributes: &wgpu::vertex_attr_array![4 => Float32x4, 5 => Float32x4],
        };
        let with_camera = |entry: &str, buffers: &[_]| {
            let shader = [VERTEX, entry].concat();
            let pipeline = Attachments::pipeline(device, COLOR_FORMAT, &shader, buffers);
            let group = camera_group(device, &pipeline, clip_from_world);
            (pipeline, group)
        };
        let usage = wgpu::BufferUsages::VERTEX;
        Self {
            streamed: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("streamed corners"),
                size: size_of_val(corners.as_slice()) as u64,
                usage: usage | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            kept: buffer(device, bytemuck::cast_slice(&corners), usage),
            of_shapes: buffer(device, bytemuck::cast_slice(&of_shapes), usage),
            places: buffer(device, bytemuck::cast_slice(&places), usage),
            plain: with_camera(CORNERS, std::slice::from_ref(&corner)),
            instanced: with_camera(INSTANCES, &[corner, place]),
            attachments: Attachments::new(device, COLOR_FORMAT, size),
            corners,
            leaves,
            shapes,
        }
    }

    /// Vertices that are drawn in a frame.
    pub fn vertices(&self) -> usize {
        self.corners.len()
    }

    /// Draws a frame. Wall clock from the first call to the end of the work, milliseconds.
    pub fn measure(&self, gpu: &Gpu, submission: Submission) -> anyhow::Result<f64> {
        let start = Instant::now();
        match submission {
            Submission::Immediate => {
                for leaf in &self.leaves {
                    self.write(gpu, leaf.clone());
                }
            }
            Submission::Arrays => self.write(gpu, 0..self.corners.len() as u32),
            Submission::Buffers | Submission::Instances => {}
        }
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = self.attachments.begin_pass(&mut encoder);
            let (pipeline, group) =
                if submission == Submission::Instances { &self.instanced } else { &self.plain };
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, group, &[]);
            match submission {
                Submission::Immediate => {
                    pass.set_vertex_buffer(0, self.streamed.slice(..));
                    for leaf in &self.leaves {
                        pass.draw(leaf.clone(), 0..1);
                    }
                }
                Submission::Arrays | Submission::Buffers => {
                    let arrays = submission == Submission::Arrays;
                    let from = if arrays { &self.streamed } else { &self.kept };
                    pass.set_vertex_buffer(0, from.slice(..));
                    pass.draw(0..self.corners.len() as u32, 0..1);
                }
                Submission::Instances => {
                    pass.set_vertex_buffer(0, self.of_shapes.slice(..));
                    pass.set_vertex_buffer(1, self.places.slice(..));
                    for shape in &self.shapes {
                        pass.draw(shape.corners.clone(), shape.instances.clone());
                    }
                }
            }
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        Ok(start.elapsed().as_secs_f64() * 1e3)
    }

    fn write(&self, gpu: &Gpu, range: Range<u32>) {
        let at = u64::from(range.start) * size_of::<Corner>() as u64;
        let corners = &self.corners[range.start as usize..range.end as usize];
        gpu.queue.write_buffer(&self.streamed, at, bytemuck::cast_slice(corners));
    }
}

/// The corners of a shape's triangles, in the leaf's own frame.
fn shape_corners(tree: &Tree, shape: u32) -> impl Iterator<Item = Corner> + '_ {
    let shape = &tree.foliage.shapes[shape as usize];
    shape.indices.iter().map(|&i| {
        let i = i as usize;
        let (position, normal, uv) = (shape.positions[i], shape.normals[i], shape.uvs[i]);
        Corner { position, normal, uv, color: 0xff20_60a0 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use windfall_gpu::Capture;
    use windfall_tree::Species;

    #[test]
    fn all_ways_draw_the_same_picture() {
        let gpu = Gpu::open().unwrap();
        let tree = Species::Birch.grow_with(1, 300);
        let (low, high) = tree.bounds();
        let middle = 0.5 * (low + high);
        let half = (high - low).max_element();
        let camera = Mat4::orthographic_rh(-half, half, -half, half, 2.0 * half, 0.0);
        let view = Mat4::look_to_rh(middle + Vec3::Z * half, Vec3::NEG_Z, Vec3::Y);
        let submitted = Submitted::new(&gpu, &tree, camera * view, (128, 128));
        assert_eq!(submitted.vertices(), 3 * tree.foliage.triangle_count());
        let pictures = Submission::ALL.map(|way| {
            submitted.measure(&gpu, way).unwrap();
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            let texture = submitted.attachments.resolve.texture();
            let capture = Capture::encode(&gpu.device, &mut encoder, texture);
            gpu.queue.submit([encoder.finish()]);
            capture.map();
            gpu.wait().unwrap();
            capture.take().unwrap().unwrap()
        });
        let lit = |picture: &[u8]| picture.chunks_exact(4).filter(|p| p[0] > 0).count();
        assert!(lit(&pictures[0]) > 100, "{}", lit(&pictures[0]));
        for (way, picture) in Submission::ALL.into_iter().zip(&pictures) {
            // Instances round their corners otherwise.
            let apart = pictures[0].iter().zip(picture).filter(|(a, b)| a.abs_diff(**b) > 8);
            let share = apart.count() as f64 / lit(&pictures[0]) as f64;
            assert!(share < 0.01, "{way:?}: {share}");
        }
    }
}
