//! Leaves for crowns that are closed solids, as in low-poly trees.

use crate::leaves::{Mesh, Piece};
use glam::{Quat, Vec2, Vec3};
use windfall_core::rng::{hash, unit};

/// Area of all leaves over that of the solid's surface: enough to look closed from outside.
const COVER: f32 = 2.5;
/// Length of a leaf over the diagonal of its crown.
const LENGTH: f32 = 0.05;
/// Most leaves of a tree; with more surface, leaves are larger.
const MOST_LEAVES: f32 = 40_000.0;
/// Depth under the surface down to which leaves hang, over the diagonal of the crown.
const DEPTH: f32 = 0.12;
/// A leaf as long as one unit: petiole, left, tip, right.
const OUTLINE: [Vec3; 4] = [
    Vec3::new(0.0, 0.0, -0.5),
    Vec3::new(0.32, 0.05, -0.05),
    Vec3::new(0.0, 0.0, 0.5),
    Vec3::new(-0.32, 0.05, -0.05),
];
/// Area of [`OUTLINE`].
const AREA: f32 = 0.32;

/// A closed solid, and the material of its leaves.
pub(super) struct Crown {
    pub mesh: Mesh,
    pub slot: u32,
}

/// Gives `add` the leaves of all crowns: places over the surfaces by area, a little inside, facing outwards more or
/// less.
pub(super) fn scatter(crowns: &[Crown], seed: u32, mut add: impl FnMut(Piece, u32)) {
    let wanted = |crown: &Crown| {
        let length = LENGTH * diagonal(&crown.mesh);
        COVER * area(&crown.mesh) / (AREA * length * length).max(f32::MIN_POSITIVE)
    };
    let all: f32 = crowns.iter().map(wanted).sum();
    let share = (MOST_LEAVES / all.max(1.0)).min(1.0);
    let mut key = hash(seed, 0xc3a7);
    for crown in crowns {
        let count = (wanted(crown) * share).ceil() as u32;
        let length = LENGTH * diagonal(&crown.mesh) / share.sqrt();
        let mut sums = Vec::new();
        let mut sum = 0.0f32;
        for vector in crown.mesh.area_vectors() {
            sum += vector.length();
            sums.push(sum);
        }
        for i in 0..count {
            key = hash(key, i);
            let random = |counter| unit(hash(key, counter));
            // Strata along the surface: no clumps.
            let at = (i as f32 + random(0)) / count as f32 * sum;
            let triangle = sums.partition_point(|&s| s < at).min(sums.len() - 1);
            let corners = [0, 1, 2].map(|corner| {
                crown.mesh.positions[crown.mesh.indices[3 * triangle + corner] as usize]
            });
            let (mut u, mut v) = (random(1), random(2));
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let [a, b, c] = corners;
            let normal = (b - a).cross(c - a).normalize_or(Vec3::Y);
            let deep = random(3);
            let depth = deep * deep * DEPTH * diagonal(&crown.mesh);
            let place = a + (b - a) * u + (c - a) * v - normal * depth;
            let aside = Vec3::new(random(4), random(5), random(6)) * 2.0 - 1.0;
            let up = (normal + 0.8 * aside).normalize_or(normal);
            let turn = Quat::from_rotation_arc(Vec3::Y, up)
                * Quat::from_rotation_y(random(7) * std::f32::consts::TAU);
            let size = length * (0.8 + 0.4 * random(8));
            add(leaf(place, turn, size), crown.slot);
        }
    }
}

fn leaf(place: Vec3, turn: Quat, size: f32) -> Piece {
    let mut mesh = Mesh {
        positions: OUTLINE.map(|p| place + turn * p * size).to_vec(),
        uvs: vec![Vec2::ZERO; 4],
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Mesh::default()
    };
    mesh.normals = mesh.face_normals();
    Piece { mesh, places: vec![0, 1, 2, 3] }
}

fn area(mesh: &Mesh) -> f32 {
    mesh.area_vectors().map(Vec3::length).sum::<f32>() / 2.0
}

fn diagonal(mesh: &Mesh) -> f32 {
    let (low, high) = mesh.bounds();
    (high - low).length()
}
