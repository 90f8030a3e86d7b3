//! How much of the sky a leaf sees through the crown.

use crate::foliage::{Leaf, LeafShape};
use glam::{UVec3, Vec3};

/// Edge of a cell of the crown, metres.
const CELL: f32 = 0.45;
/// Leaves at random angles show half their area to any direction.
const PROJECTED: f32 = 0.5;
/// The sky, in eight directions of equal weight about: two rings of four.
const SKY: [Vec3; 8] = [
    Vec3::new(0.5, 0.866, 0.0),
    Vec3::new(-0.5, 0.866, 0.0),
    Vec3::new(0.0, 0.866, 0.5),
    Vec3::new(0.0, 0.866, -0.5),
    Vec3::new(0.64, 0.423, 0.64),
    Vec3::new(-0.64, 0.423, 0.64),
    Vec3::new(-0.64, 0.423, -0.64),
    Vec3::new(0.64, 0.423, -0.64),
];

/// Sets every leaf's `ambient` (Vázquez & Balsa 2008, section 7.1): the mean over the sky of what
/// the crown lets through, by Beer and Lambert's law over the leaf area in a grid of cells.
pub(super) fn ambient(leaves: &mut [Leaf], shapes: &[LeafShape]) {
    let low = leaves.iter().fold(Vec3::INFINITY, |m, l| m.min(l.center)) - CELL;
    let high = leaves.iter().fold(Vec3::NEG_INFINITY, |m, l| m.max(l.center)) + CELL;
    if !low.is_finite() || !high.is_finite() {
        return;
    }
    let size = ((high - low) / CELL).ceil().as_uvec3();
    let index = |p: Vec3| {
        let cell = (p - low) / CELL;
        let inside = cell.cmpge(Vec3::ZERO).all() && cell.cmplt(size.as_vec3()).all();
        let UVec3 { x, y, z } = cell.as_uvec3();
        inside.then_some(((y * size.z + z) * size.x + x) as usize)
    };
    let mut area = vec![0.0f32; (size.x * size.y * size.z) as usize];
    for leaf in &*leaves {
        if let Some(i) = index(leaf.center) {
            area[i] += shapes[leaf.shape as usize].area() * leaf.scale * leaf.scale;
        }
    }
    let per_cell = PROJECTED / (CELL * CELL);
    for leaf in leaves {
        let seen: f32 = SKY
            .iter()
            .map(|&way| {
                // The leaf's own cell is half behind it.
                let mut depth = index(leaf.center).map_or(0.0, |i| 0.5 * area[i]);
                let mut point = leaf.center + way * CELL;
                while let Some(i) = index(point) {
                    depth += area[i];
                    point += way * CELL;
                }
                (-depth * per_cell).exp()
            })
            .sum();
        leaf.ambient = (seen / SKY.len() as f32).clamp(0.0, 1.0);
    }
}
