//! Leaves: the blade's geometry from its outline, and where leaves grow on the twigs.

use super::params::{Leaves, Outline};
use super::stem::{GOLDEN, Stem, sideways};
use glam::{Mat3, Quat, Vec2, Vec3};
use std::f32::consts::TAU;
use windfall_core::foliage::{Leaf, LeafShape};
use windfall_core::rng::Rng;

/// Shapes per species: enough that neighbours differ.
const VARIANTS: u32 = 4;
/// Half the width of a petiole at the twig, in lengths of the blade.
const PETIOLE: f32 = 0.014;

/// A leaf shape, and the point of it that sits on the twig.
pub(super) struct Blade {
    pub shape: LeafShape,
    stalk: Vec3,
}

/// The shapes that all leaves of a species share, one blade length long.
pub(super) fn blades(leaves: &Leaves, rng: &Rng) -> Vec<Blade> {
    (0..VARIANTS).map(|i| blade(leaves, &mut rng.stream(i))).collect()
}

fn blade(leaves: &Leaves, rng: &mut Rng) -> Blade {
    let Outline { midrib, edge, fold, curl } = leaves.outline;
    let mid = midrib.len();
    // The flat leaf: midrib, right edge, left edge, and the petiole's two corners at the twig.
    let mut flat: Vec<Vec2> = midrib.iter().map(|&z| Vec2::new(0.0, z)).collect();
    flat.extend(edge.iter().map(|&[x, z]| Vec2::new(x, z)));
    flat.extend(edge.iter().map(|&[x, z]| Vec2::new(-x, z)));
    let blade_points = mid + 2 * edge.len();
    if leaves.petiole > 0.0 {
        let far = midrib[0] - leaves.petiole;
        flat.extend([Vec2::new(PETIOLE, far), Vec2::new(-PETIOLE, far)]);
    }

    let half: Vec<u32> = (mid..mid + edge.len()).chain((0..mid).rev()).map(|i| i as u32).collect();
    let right = triangulate(&flat, &half);
    let mirror = |i: u32| if i < mid as u32 { i } else { i + edge.len() as u32 };
    let left = right.iter().map(|&[a, b, c]| [mirror(a), mirror(c), mirror(b)]);
    let mut triangles: Vec<[u32; 3]> = right.iter().copied().chain(left).collect();
    if leaves.petiole > 0.0 {
        triangles.push([blade_points as u32, blade_points as u32 + 1, 0]);
    }
    for t in &mut triangles {
        let [a, b, c] = t.map(|i| flat[i as usize]);
        // With X to the right and Z ahead, the upper side (+Y) sees this sign counter-clockwise.
        if (b - a).perp_dot(c - a) > 0.0 {
            t.swap(1, 2);
        }
    }

    let fold = fold.to_radians() * rng.range(0.5, 1.5);
    let curl = curl.to_radians() * rng.range(0.3, 1.7);
    let sickle = rng.range(-0.07, 0.07);
    let wide = rng.range(0.92, 1.08);
    let mut positions: Vec<Vec3> = flat
        .iter()
        .enumerate()
        .map(|(i, p)| {
            let wave = if (mid..blade_points).contains(&i) { rng.range(-0.03, 0.03) } else { 0.0 };
            let bend = curl * p.y;
            let along = if curl.abs() > 1e-3 { bend.sin() / curl } else { p.y };
            let drop = if curl.abs() > 1e-3 { (1.0 - bend.cos()) / curl } else { 0.0 };
            let side = p.x * wide;
            Vec3::new(
                side * fold.cos() + sickle * p.y * p.y,
                side.abs() * fold.sin() - drop + wave,
                along,
            ) * leaves.length
        })
        .collect();

    let (mut area, mut center) = (0.0, Vec3::ZERO);
    let mut normals = vec![Vec3::ZERO; positions.len()];
    for &t in &triangles {
        let [a, b, c] = t.map(|i| positions[i as usize]);
        let face = (b - a).cross(c - a);
        area += face.length();
        center += (a + b + c) / 3.0 * face.length();
        for i in t {
            normals[i as usize] += face;
        }
    }
    center /= area;
    for p in &mut positions {
        *p -= center;
    }
    for n in &mut normals {
        *n = n.normalize_or(Vec3::Y);
    }

    let width = edge.iter().map(|e| e[0]).fold(0.0, f32::max).max(1e-3);
    let outline = || midrib.iter().copied().chain(edge.iter().map(|e| e[1]));
    let low = outline().fold(f32::INFINITY, f32::min);
    let high = outline().fold(f32::NEG_INFINITY, f32::max);
    let uvs = flat
        .iter()
        .map(|p| Vec2::new(0.5 + 0.5 * p.x / width, ((p.y - low) / (high - low)).max(0.0)))
        .collect();
    let stalk = match positions[blade_points..] {
        [a, b] => (a + b) * 0.5,
        _ => positions[0],
    };
    let indices = triangles.into_iter().flatten().collect();
    Blade { shape: LeafShape { positions, normals, uvs, indices }, stalk }
}

/// Cuts a simple polygon into triangles by clipping ears, always the one with the widest corner
/// (the least sliver).
fn triangulate(points: &[Vec2], polygon: &[u32]) -> Vec<[u32; 3]> {
    let at = |i: u32| points[i as usize];
    let turn = |a: u32, b: u32, c: u32| (at(b) - at(a)).perp_dot(at(c) - at(a));
    let mut ring = polygon.to_vec();
    let mut triangles = Vec::new();
    while ring.len() >= 3 {
        let n = ring.len();
        let corner = |k: usize| [ring[(k + n - 1) % n], ring[k], ring[(k + 1) % n]];
        let quality = |k: usize| {
            let [a, b, c] = corner(k);
            let twice = turn(a, b, c);
            let inside = |&p: &u32| {
                ![a, b, c].contains(&p)
                    && turn(a, b, p) >= 0.0
                    && turn(b, c, p) >= 0.0
                    && turn(c, a, p) >= 0.0
            };
            if twice <= 1e-5 || ring.iter().any(inside) {
                return f32::NEG_INFINITY;
            }
            let longest = [(a, b), (b, c), (c, a)]
                .map(|(p, q)| at(p).distance_squared(at(q)))
                .into_iter()
                .fold(0.0, f32::max);
            twice / longest
        };
        let Some(ear) = (0..n).max_by(|&a, &b| quality(a).total_cmp(&quality(b))) else { break };
        if quality(ear) == f32::NEG_INFINITY {
            break;
        }
        triangles.push(corner(ear));
        ring.remove(ear);
    }
    triangles
}

/// Puts `count` leaves on the twigs: evenly over their length, a little denser towards the tips.
///
/// `bent_normal` is the leaf's own normal and `ambient` 1, for others to finish.
pub(super) fn place(
    leaves: &Leaves,
    count: u32,
    blades: &[Blade],
    stems: &[Stem],
    rng: &mut Rng,
) -> Vec<Leaf> {
    let last = stems.iter().map(|s| s.level).max().unwrap_or(0);
    // The last level bears along its length, the one before it towards its tip.
    let twigs: Vec<(&Stem, f32, f32)> = stems
        .iter()
        .filter(|s| s.level + 1 >= last && s.level > 0)
        .map(|s| (s, if s.level == last { 0.12 } else { 0.6 }))
        .map(|(s, from)| (s, from, s.length * (1.0 - from)))
        .collect();
    let total: f32 = twigs.iter().map(|t| t.2).sum();
    let middle = twigs.iter().map(|t| t.0.at(1.0).point).sum::<Vec3>() / twigs.len().max(1) as f32;
    let scale = leaves.enlarge_for(count);
    let nodes = count.div_ceil(leaves.per_node);
    let mut placed = Vec::with_capacity(count as usize);
    let (mut twig, mut passed) = (0, 0.0);
    for node in 0..nodes {
        let target = (node as f32 + rng.unit()) / nodes as f32 * total;
        while twig + 1 < twigs.len() && passed + twigs[twig].2 < target {
            passed += twigs[twig].2;
            twig += 1;
        }
        let Some(&(stem, from, bearing)) = twigs.get(twig) else { break };
        let share = ((target - passed) / bearing).clamp(0.0, 1.0).powf(0.75);
        let spot = stem.at(from + (1.0 - from) * share);
        let outward = (spot.point - middle).normalize_or(Vec3::Y);
        let turn = node as f32 * GOLDEN;
        for j in 0..leaves.per_node.min(count - placed.len() as u32) {
            let azimuth = turn + TAU * j as f32 / leaves.per_node as f32 + rng.range(-0.4, 0.4);
            let flat = if leaves.per_node == 1 { 0.4 } else { 0.0 };
            let side = sideways(spot.heading, azimuth, flat, node % 2 == 0);
            let angle = leaves.angle.to_radians() * rng.range(0.6, 1.3);
            let free = spot.heading * angle.cos() + side * angle.sin();
            let scatter = Vec3::new(rng.normal(), rng.normal(), rng.normal());
            let tip = free.lerp(Vec3::NEG_Y, leaves.droop * rng.range(0.6, 1.2)) + scatter * 0.12;
            let tip = tip.normalize_or(free);
            let scatter = Vec3::new(rng.normal(), rng.normal(), rng.normal());
            let light = Vec3::Y + outward * 1.2 + scatter * leaves.scatter;
            let up = (light - tip * light.dot(tip)).normalize_or(tip.any_orthonormal_vector());
            let orientation = Quat::from_mat3(&Mat3::from_cols(up.cross(tip), up, tip)).normalize();
            let shape = rng.below(blades.len() as u32);
            let size = scale * rng.range(0.75, 1.2);
            placed.push(Leaf {
                center: spot.point - orientation * (blades[shape as usize].stalk * size),
                orientation,
                scale: size,
                shape,
                material: 0,
                bent_normal: up,
                ambient: 1.0,
                shed_rank: 0,
            });
        }
    }
    placed
}
