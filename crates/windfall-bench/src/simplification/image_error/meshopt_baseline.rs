//! Baseline: leaves simplified as one mesh by meshoptimizer, drawn by the same renderer.

use anyhow::Context;
use glam::{Quat, Vec3};
use meshopt::{SimplifyOptions, VertexDataAdapter};
use windfall_core::foliage::LeafShape;
use windfall_core::tree::Tree;
use windfall_tree::prepare::simple_shapes;

/// The method of meshoptimizer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshoptBaseline {
    /// `simplify` collapses the edges that change the surface least. It also removes components
    /// smaller than the error: without that, few triangles are out of reach.
    Simplify,
    /// `simplify_sloppy` merges the vertices in each cell of a grid, across leaves.
    Sloppy,
}

/// `tree` with at most about `triangles` leaf triangles.
///
/// Leaves keep their order, color and light. A triangle belongs to the leaf of its first corner.
pub fn simplified(
    tree: &Tree,
    baseline: MeshoptBaseline,
    triangles: usize,
) -> anyhow::Result<Tree> {
    let foliage = &tree.foliage;
    let (mut positions, mut normals, mut uvs, mut owners) = (vec![], vec![], vec![], vec![]);
    let mut indices: Vec<u32> = Vec::new();
    for (i, leaf) in foliage.leaves.iter().enumerate() {
        let shape = &foliage.shapes[leaf.shape as usize];
        let first = positions.len() as u32;
        positions.extend(
            shape.positions.iter().map(|&p| leaf.center + leaf.orientation * p * leaf.scale),
        );
        normals.extend(shape.normals.iter().map(|&n| leaf.orientation * n));
        uvs.extend_from_slice(&shape.uvs);
        owners.resize(positions.len(), i);
        indices.extend(shape.indices.iter().map(|i| first + i));
    }
    let flat: Vec<[f32; 3]> = positions.iter().map(Vec3::to_array).collect();
    let bytes: &[u8] = bytemuck::cast_slice(&flat);
    let vertices =
        VertexDataAdapter::new(bytes, size_of::<[f32; 3]>(), 0).context("a mesh of leaves")?;
    let target = 3 * triangles;
    let indices = match baseline {
        MeshoptBaseline::Simplify => {
            let options = SimplifyOptions::Prune | SimplifyOptions::ErrorAbsolute;
            meshopt::simplify(&indices, &vertices, target, f32::MAX, options, None)
        }
        MeshoptBaseline::Sloppy => {
            meshopt::simplify_sloppy(&indices, &vertices, target, f32::MAX, None)
        }
    };
    let mut out = tree.clone();
    out.foliage.shapes = vec![LeafShape::default(); foliage.leaves.len()];
    for triangle in indices.chunks_exact(3) {
        let owner = owners[triangle[0] as usize];
        let shape = &mut out.foliage.shapes[owner];
        for &corner in triangle {
            let corner = corner as usize;
            shape.indices.push(shape.positions.len() as u32);
            shape.positions.push(positions[corner] - foliage.leaves[owner].center);
            shape.normals.push(normals[corner]);
            shape.uvs.push(uvs[corner]);
        }
    }
    for (leaf, shape) in out.foliage.leaves.iter_mut().zip(0..) {
        (leaf.shape, leaf.scale, leaf.orientation) = (shape, 1.0, Quat::IDENTITY);
    }
    out.foliage.simple_shapes = simple_shapes(&out.foliage);
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use windfall_tree::Species;

    #[test]
    fn baselines_have_as_many_triangles_and_lie_where_the_leaves_are() {
        let tree = Species::Birch.grow_with(1, 500);
        let all = tree.foliage.triangle_count();
        let (low, high) = tree.bounds();
        for baseline in [MeshoptBaseline::Simplify, MeshoptBaseline::Sloppy] {
            let few = simplified(&tree, baseline, all / 10).unwrap();
            let count = few.foliage.triangle_count();
            assert!(count <= all / 10 && count > all / 30, "{count} of {all}");
            let (a, b) = few.bounds();
            assert!(a.cmpge(low - 1e-3).all() && b.cmple(high + 1e-3).all());
        }
        // With all of the triangles, the surface stays the same.
        let whole = simplified(&tree, MeshoptBaseline::Simplify, all).unwrap();
        let area = |tree: &Tree| -> f32 {
            let leaves = tree.foliage.leaves.iter();
            leaves.map(|l| l.scale * l.scale * tree.foliage.shapes[l.shape as usize].area()).sum()
        };
        assert!((area(&whole) / area(&tree) - 1.0).abs() < 0.01);
    }
}
