//! The leaves of a tree model as one mesh.

use crate::base::constants::LEAF_VERTEX_WORDS;
use crate::base::packing::{octahedral, snorm, snorm8};
use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};
use half::f16;
use windfall_core::foliage::{Foliage, Leaf, LeafShape};
use windfall_core::simplify::as_quad;
use windfall_core::tree::{Material, Surface};

/// A vertex of the hanging leaves: 40 bytes. Everything of the leaf is repeated in its vertices,
/// since a vertex buffer is read several times faster than a storage buffer on the devices measured.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct LeafVertex {
    center: [f32; 3],
    leaf: u32,
    /// Relative to the centre; `w` is the ambient light that reaches the leaf.
    offset: [f16; 4],
    normal: [i8; 4],
    /// Octahedral, in the first two; then the leaf's length, relative to that of the longest.
    bent_normal: [u8; 4],
    uv: [f16; 2],
    /// Material in the upper 8 bits, shed rank in the lower 24.
    material_shed: u32,
}

impl LeafVertex {
    pub const ATTRIBUTES: [wgpu::VertexAttribute; 7] = wgpu::vertex_attr_array![
        0 => Float32x3, 1 => Uint32, 2 => Float16x4, 3 => Snorm8x4, 4 => Snorm8x4,
        5 => Float16x2, 6 => Uint32,
    ];
}

const _: () = assert!(size_of::<LeafVertex>() == 4 * LEAF_VERTEX_WORDS as usize);

/// The leaves of a model in two triangles each.
pub struct LeafQuads {
    /// First of four vertices for each leaf, in prune order: what `pass::quads` draws.
    pub first: u32,
    /// For each shape its quad.
    pub shapes: Vec<LeafShape>,
}

/// The leaves of a tree as a mesh.
pub struct LeafMesh {
    pub vertices: Vec<LeafVertex>,
    pub indices: Vec<u32>,
    /// In prune order the first index of each leaf, and the end of the last.
    pub starts: Vec<u32>,
    /// The same of the leaves in few triangles, for simplified trees.
    pub simple_starts: Vec<u32>,
    /// Those if they are quads of four vertices each, without pictures.
    pub quads: Option<LeafQuads>,
}

impl LeafMesh {
    pub fn new(foliage: &Foliage) -> Self {
        let mut mesh = Self {
            vertices: Vec::with_capacity(foliage.vertex_count()),
            indices: Vec::with_capacity(foliage.triangle_count() * 3),
            starts: Vec::new(),
            simple_starts: Vec::new(),
            quads: None,
        };
        let simple = &foliage.simple_shapes[..];
        let longest = leaf_lengths(foliage).y;
        let lengths: Vec<f32> =
            foliage.shapes.iter().map(|shape| 2.0 * shape.radius() / longest).collect();
        let mut firsts = Vec::with_capacity(foliage.leaves.len());
        for (i, leaf) in (0..).zip(&foliage.leaves) {
            mesh.starts.push(mesh.indices.len() as u32);
            firsts.push(mesh.vertices.len() as u32);
            let shape = &foliage.shapes[leaf.shape as usize];
            mesh.add((i, leaf), shape, lengths[leaf.shape as usize]);
        }
        mesh.starts.push(mesh.indices.len() as u32);
        if let Some(shapes) = quads(foliage, simple) {
            let first = mesh.vertices.len() as u32;
            for (i, leaf) in (0..).zip(&foliage.leaves) {
                mesh.simple_starts.push(mesh.indices.len() as u32);
                mesh.add((i, leaf), &shapes[leaf.shape as usize], lengths[leaf.shape as usize]);
            }
            mesh.simple_starts.push(mesh.indices.len() as u32);
            mesh.quads = Some(LeafQuads { first, shapes });
            return mesh;
        }
        if simple.iter().all(Option::is_none) {
            mesh.simple_starts.clone_from(&mesh.starts);
            return mesh;
        }
        for (i, leaf) in (0..).zip(&foliage.leaves) {
            mesh.simple_starts.push(mesh.indices.len() as u32);
            if let Some(shape) = &simple[leaf.shape as usize] {
                mesh.add((i, leaf), shape, lengths[leaf.shape as usize]);
            } else {
                let shape = &foliage.shapes[leaf.shape as usize];
                let first = firsts[i as usize];
                mesh.indices.extend(shape.indices.iter().map(|&index| first + index));
            }
        }
        mesh.simple_starts.push(mesh.indices.len() as u32);
        mesh
    }

    /// Adds a leaf in a shape; `length` is that of its own shape at scale 1, relative to the longest leaf.
    fn add(&mut self, (index, leaf): (u32, &Leaf), shape: &LeafShape, length: f32) {
        let first = self.vertices.len() as u32;
        self.indices.extend(shape.indices.iter().map(|&index| first + index));
        let [x, y] = octahedral(leaf.bent_normal).to_array().map(snorm8);
        let bent_normal = [x, y, snorm8(length * leaf.scale), 0];
        for ((&position, &normal), &uv) in
            shape.positions.iter().zip(&shape.normals).zip(&shape.uvs)
        {
            let offset = leaf.orientation * position * leaf.scale;
            self.vertices.push(LeafVertex {
                center: leaf.center.to_array(),
                leaf: index,
                offset: offset.extend(leaf.ambient).to_array().map(f16::from_f32),
                normal: snorm(leaf.orientation * normal),
                bent_normal,
                uv: uv.to_array().map(f16::from_f32),
                material_shed: leaf.material << 24 | (leaf.shed_rank & 0x00ff_ffff),
            });
        }
    }
}

/// The shapes of leaves without pictures as quads, each with the mean normal of its leaf, if every one has
/// few enough triangles for that; `simple` are [`Foliage::simple_shapes`], nothing in a tree that was not prepared.
fn quads(foliage: &Foliage, simple: &[Option<LeafShape>]) -> Option<Vec<LeafShape>> {
    let plain =
        |m: &Material| m.alpha_cutoff.is_none() && !matches!(m.surface, Surface::Texture(..));
    if simple.is_empty() || !foliage.materials.iter().all(plain) {
        return None;
    }
    let shapes = foliage.shapes.iter().zip(simple);
    let quad = |(shape, simple): (&LeafShape, &Option<LeafShape>)| {
        let mut quad = as_quad(simple.as_ref().unwrap_or(shape))?;
        quad.normals.fill(mean_normal(shape));
        Some(quad)
    };
    shapes.map(quad).collect()
}

/// The mean of a leaf's normals over its area: the shorter, the more it is curved. 1 long for none.
fn mean_normal(shape: &LeafShape) -> Vec3 {
    let (mut sum, mut area) = (Vec3::ZERO, 0.0);
    for t in shape.indices.chunks_exact(3) {
        let t = [t[0], t[1], t[2]].map(|i| i as usize);
        let [a, b, c] = t.map(|i| shape.positions[i]);
        let part = (b - a).cross(c - a).length();
        sum += part / 3.0 * t.iter().map(|&i| shape.normals[i]).sum::<Vec3>();
        area += part;
    }
    if area > 0.0 && sum.is_finite() { sum / area } else { Vec3::Y }
}

/// Lengths of the shortest and of the longest leaf, metres, a little apart: half floats do not narrow them.
pub fn leaf_lengths(foliage: &Foliage) -> Vec2 {
    let [shortest, longest] = foliage.leaf_lengths();
    Vec2::new(shortest * 0.999, longest * 1.001)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_normal_of_a_fold_is_as_long_as_it_is_open() {
        // Halves of one square metre and of two, that lean to either side by 0.5.
        let (sin, cos) = 0.5f32.sin_cos();
        let at = |x: f32, z: f32| Vec3::new(x * cos, x.abs() * sin, z);
        let (left, right) = (Vec3::new(sin, cos, 0.0), Vec3::new(-sin, cos, 0.0));
        let shape = LeafShape {
            positions: [
                (-1.0, 0.0),
                (0.0, 0.0),
                (-1.0, 1.0),
                (0.0, 1.0),
                (0.0, 0.0),
                (2.0, 0.0),
                (0.0, 1.0),
                (2.0, 1.0),
            ]
            .map(|(x, z)| at(x, z))
            .to_vec(),
            normals: [[left; 4], [right; 4]].concat(),
            uvs: vec![glam::Vec2::ZERO; 8],
            indices: vec![0, 1, 2, 2, 1, 3, 4, 5, 6, 6, 5, 7],
        };
        let expected = (left + 2.0 * right) / 3.0;
        assert!(mean_normal(&shape).distance(expected) < 1e-6, "{}", mean_normal(&shape));
        assert!((expected.length() - 0.892).abs() < 1e-3);
        assert_eq!(mean_normal(&LeafShape::default()), Vec3::Y);
    }
}
