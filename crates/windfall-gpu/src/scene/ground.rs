//! The terrain's triangles, out to the horizon.

use crate::base::layouts;
use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};
use wgpu::util::DeviceExt;
use windfall_core::forest::Terrain;

/// How far the ground goes on beyond the terrain's edge, metres.
const HORIZON: f32 = 6000.0;
/// How far from the terrain's middle the land of the backdrop begins: its half, this much more, and
/// not nearer than [`NEAREST_BACKDROP`], metres.
const MEADOW: f32 = 40.0;
const NEAREST_BACKDROP: f32 = 140.0;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct GroundVertex {
    position: [f32; 3],
    normal: [f32; 3],
}

/// The terrain's triangles.
pub struct GroundMesh {
    pub vertices: wgpu::Buffer,
    pub indices: wgpu::Buffer,
    pub index_count: u32,
    /// The heights, for the grass.
    pub heights: wgpu::BindGroup,
    /// `Frame::backdrop`.
    pub backdrop: Vec4,
}

impl GroundMesh {
    /// The same two triangles a cell as [`Terrain`], with one more ring of cells around them that
    /// reaches to the horizon, level along its axis as the terrain is there.
    pub fn new(device: &wgpu::Device, heights: &wgpu::BindGroupLayout, terrain: &Terrain) -> Self {
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
        let table: Vec<f32> = [inner as f32, terrain.cell()]
            .into_iter()
            .chain(terrain.heights().iter().copied())
            .collect();
        let table =
            init("terrain heights", bytemuck::cast_slice(&table), wgpu::BufferUsages::STORAGE);
        Self {
            heights: layouts::group(
                device,
                "terrain heights",
                heights,
                &[table.as_entire_binding()],
            ),
            backdrop: backdrop(terrain),
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

/// The plane nearest to the terrain's rim, and the distance at which the backdrop stands on it.
fn backdrop(terrain: &Terrain) -> Vec4 {
    const PLACES: u32 = 64;
    let radius = (terrain.extent() * 0.5 + MEADOW).max(NEAREST_BACKDROP);
    let mut plane = Vec3::ZERO;
    for i in 0..PLACES {
        let (sin, cos) = (std::f32::consts::TAU * i as f32 / PLACES as f32).sin_cos();
        let height = terrain.height(radius * cos, radius * sin);
        // Least squares over a circle: the mean, and twice the first waves.
        plane += Vec3::new(1.0, 2.0 * cos / radius, 2.0 * sin / radius) * height;
    }
    (plane / PLACES as f32).extend(radius)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    #[test]
    fn the_backdrop_stands_on_the_rim_of_the_terrain() {
        assert_eq!(backdrop(&Terrain::flat()), Vec4::new(0.0, 0.0, 0.0, NEAREST_BACKDROP));
        // A slope of 0.1 over 400 m, level beyond: between 0.08 and 0.1 at the rim.
        let plane = backdrop(&Terrain::slope(Vec2::new(0.0, -0.1), 400.0));
        assert!(plane.x.abs() < 1e-3 && plane.y.abs() < 1e-4, "{plane}");
        assert!((-0.1..-0.08).contains(&plane.z), "{plane}");
        assert_eq!(plane.w, 240.0);
    }
}
