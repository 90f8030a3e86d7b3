//! Baseline: leaves simplified as one mesh by meshoptimizer, drawn by the same renderer.

use anyhow::Context;
use glam::{Quat, Vec3};
use meshopt::{SimplifyOptions, VertexDataAdapter};
use std::collections::HashSet;
use windfall_core::foliage::LeafShape;
use windfall_core::tree::Tree;
use windfall_tree::prepare::simple_shapes;

/// The method of meshoptimizer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshoptBaseline {
    /// `simplify` collapses the edges that change the surface least. It also removes components
    /// smaller than the error: without that, few triangles are out of reach.
    Simplify,
    /// `simplify` in steps that halve the triangles, after each of which open borders grow outwards until the area is
    /// what it was: `simplify_dilate_borders` of meshoptimizer's `clusterlod.h` ("most useful for foliage"), which the
    /// crate has but refuses to run. Here all leaves are one group.
    Dilated,
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
    let target = 3 * triangles;
    let indices = match baseline {
        MeshoptBaseline::Simplify => simplify(&positions, &indices, target, false)?,
        MeshoptBaseline::Sloppy => simplify(&positions, &indices, target, true)?,
        MeshoptBaseline::Dilated => {
            while indices.len() > target {
                let half = (indices.len() / 6 * 3).max(target);
                let fewer = simplify(&positions, &indices, half, false)?;
                dilate(&mut positions, &indices, &fewer);
                if fewer.len() == indices.len() {
                    break;
                }
                indices = fewer;
            }
            indices
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

/// Indices of at most about `target` corners.
fn simplify(
    positions: &[Vec3],
    indices: &[u32],
    target: usize,
    sloppy: bool,
) -> anyhow::Result<Vec<u32>> {
    let flat: Vec<[f32; 3]> = positions.iter().map(Vec3::to_array).collect();
    let bytes: &[u8] = bytemuck::cast_slice(&flat);
    let vertices =
        VertexDataAdapter::new(bytes, size_of::<[f32; 3]>(), 0).context("a mesh of leaves")?;
    let options = SimplifyOptions::Prune | SimplifyOptions::ErrorAbsolute;
    Ok(if sloppy {
        meshopt::simplify_sloppy(indices, &vertices, target, f32::MAX, None)
    } else {
        meshopt::simplify(indices, &vertices, target, f32::MAX, options, None)
    })
}

fn area(positions: &[Vec3], indices: &[u32]) -> f32 {
    let of = |t: &[u32]| {
        let [a, b, c] = [t[0], t[1], t[2]].map(|i| positions[i as usize]);
        0.5 * (b - a).cross(c - a).length()
    };
    indices.chunks_exact(3).map(of).sum()
}

/// Moves the open borders of the triangles `after` outwards, along their planes, by the area that they lack to
/// `before` over their length. Nothing moves if there is no such area, or if it is more than three quarters.
fn dilate(positions: &mut [Vec3], before: &[u32], after: &[u32]) {
    let [old, new] = [before, after].map(|indices| area(positions, indices));
    if new >= old || new < 0.25 * old {
        return;
    }
    let edges = |triangle: &[u32]| {
        let [a, b, c] = [triangle[0], triangle[1], triangle[2]];
        [[a, b, c], [b, c, a], [c, a, b]]
    };
    let known: HashSet<[u32; 2]> =
        after.chunks_exact(3).flat_map(edges).map(|[a, b, _]| [a, b]).collect();
    let mut outward = vec![(Vec3::ZERO, 0.0); positions.len()];
    let mut perimeter = 0.0;
    for [a, b, c] in after.chunks_exact(3).flat_map(edges) {
        if known.contains(&[b, a]) {
            continue;
        }
        let [pa, pb, pc] = [a, b, c].map(|i| positions[i as usize]);
        let length = pa.distance(pb);
        let normal = (pa - pc).reject_from(pb - pa).normalize_or_zero();
        for end in [a, b] {
            let (sum, weight) = &mut outward[end as usize];
            *sum += normal * length;
            *weight += length;
        }
        perimeter += length;
    }
    let distance = (old - new) / perimeter.max(f32::MIN_POSITIVE);
    for (position, (sum, weight)) in positions.iter_mut().zip(outward) {
        if weight > 0.0 {
            let mean = sum / weight;
            // Over the length of the mean once to make it one long, once for the mitre.
            *position += mean * distance / mean.length_squared().max(0.15);
        }
    }
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
        for baseline in
            [MeshoptBaseline::Simplify, MeshoptBaseline::Dilated, MeshoptBaseline::Sloppy]
        {
            let few = simplified(&tree, baseline, all / 10).unwrap();
            let count = few.foliage.triangle_count();
            assert!(count <= all / 10 && count > all / 30, "{count} of {all}");
            let (a, b) = few.bounds();
            let beyond = if baseline == MeshoptBaseline::Dilated { 0.3 } else { 1e-3 };
            assert!(a.cmpge(low - beyond).all() && b.cmple(high + beyond).all());
        }
        // With all of the triangles, the surface stays the same.
        let whole = simplified(&tree, MeshoptBaseline::Simplify, all).unwrap();
        let area = |tree: &Tree| -> f32 {
            let leaves = tree.foliage.leaves.iter();
            leaves.map(|l| l.scale * l.scale * tree.foliage.shapes[l.shape as usize].area()).sum()
        };
        assert!((area(&whole) / area(&tree) - 1.0).abs() < 0.01);
        let [lean, dilated] = [MeshoptBaseline::Simplify, MeshoptBaseline::Dilated]
            .map(|baseline| area(&simplified(&tree, baseline, all / 4).unwrap()) / area(&tree));
        // Borders give back most of the area that is lost without them.
        assert!(lean < 0.9 && (1.0 - dilated).abs() < 0.4 * (1.0 - lean), "{lean} {dilated}");
    }

    /// A square of two triangles that lacks half of its area: its sides move by that over their length.
    #[test]
    fn borders_grow_by_the_area_that_is_missing() {
        let square = |side: f32| {
            [[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]].map(|[x, y]| Vec3::new(x, y, 0.0))
        };
        let mut positions = [square(2.0), square(1.4)].concat();
        let corners = |first: u32| [0, 1, 2, 0, 2, 3].map(|i| first + i);
        dilate(&mut positions, &corners(0), &corners(4));
        let grown = area(&positions, &corners(4));
        // (4 - 1.96) / 5.6 on each side, and the corners beyond it.
        let expected = (1.4 + 2.0 * 2.04 / 5.6f32).powi(2);
        assert!((grown - expected).abs() < 0.01, "{grown} {expected}");
        assert_eq!(positions[..4], square(2.0));
    }
}
