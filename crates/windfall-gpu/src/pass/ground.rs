//! The terrain, out to the horizon.

use super::{
    Shaders,
    draw::{Draw, DrawTarget},
};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use wgpu::util::DeviceExt;
use windfall_core::forest::Terrain;

/// How far the ground goes on beyond the terrain's edge, metres.
const HORIZON: f32 = 6000.0;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct GroundVertex {
    position: [f32; 3],
    normal: [f32; 3],
}

pub(crate) struct Ground {
    pipeline: wgpu::RenderPipeline,
}

/// The terrain's triangles.
pub(crate) struct GroundMesh {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    index_count: u32,
}

impl GroundMesh {
    /// The same two triangles a cell as [`Terrain`], with one more ring of cells around them that
    /// reaches to the horizon, level along its axis as the terrain is there.
    pub fn new(device: &wgpu::Device, terrain: &Terrain) -> Self {
        let inner = terrain.side();
        let side = inner + 2;
        let half = terrain.extent() * 0.5;
        let place = |i: u32| match i {
            0 => -half - HORIZON,
            i if i == side - 1 => half + HORIZON,
            i => (i - 1) as f32 * terrain.cell() - half,
        };
        let height = |i: u32, j: u32| {
            let clamp = |v: u32| (v.clamp(1, inner) - 1) as usize;
            terrain.heights()[clamp(j) * inner as usize + clamp(i)]
        };
        let mut vertices = Vec::with_capacity((side * side) as usize);
        for j in 0..side {
            for i in 0..side {
                let (west, east) = (i.saturating_sub(1), (i + 1).min(side - 1));
                let (north, south) = (j.saturating_sub(1), (j + 1).min(side - 1));
                let dx = (height(east, j) - height(west, j)) / (place(east) - place(west));
                let dz = (height(i, south) - height(i, north)) / (place(south) - place(north));
                vertices.push(GroundVertex {
                    position: [place(i), height(i, j), place(j)],
                    normal: Vec3::new(-dx, 1.0, -dz).normalize_or(Vec3::Y).to_array(),
                });
            }
        }
        let mut indices = Vec::with_capacity(((side - 1) * (side - 1) * 6) as usize);
        for j in 0..side - 1 {
            for i in 0..side - 1 {
                let a = j * side + i;
                let (b, c, d) = (a + 1, a + side, a + side + 1);
                indices.extend_from_slice(&[a, c, b, b, c, d]);
            }
        }
        let init = |label, contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some(label),
                contents,
                usage,
            })
        };
        Self {
            vertices: init(
                "ground vertices",
                bytemuck::cast_slice(&vertices),
                wgpu::BufferUsages::VERTEX,
            ),
            indices: init(
                "ground indices",
                bytemuck::cast_slice(&indices),
                wgpu::BufferUsages::INDEX,
            ),
            index_count: indices.len() as u32,
        }
    }
}

impl Ground {
    pub fn new(shaders: &Shaders<'_>) -> Self {
        let vertices = wgpu::VertexBufferLayout {
            array_stride: size_of::<GroundVertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3],
        };
        Self {
            pipeline: shaders.pipeline(&Draw {
                label: "ground",
                source: include_str!("../../shaders/ground.wgsl"),
                groups: &[],
                buffers: &[vertices],
                cull: Some(wgpu::Face::Back),
                vertex: "vertex",
                fragment: Some("fragment"),
                alpha_to_coverage: false,
                target: DrawTarget::Radiance,
            }),
        }
    }

    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, mesh: &GroundMesh) {
        pass.set_pipeline(&self.pipeline);
        pass.set_vertex_buffer(0, mesh.vertices.slice(..));
        pass.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..mesh.index_count, 0, 0..1);
    }
}
