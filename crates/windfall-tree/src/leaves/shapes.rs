//! Leaves that are the same up to rotation, size and place share one shape.

use super::correspondence::Walk;
use super::fit::{Similarity, fit};
use super::mesh::Mesh;
use super::pieces::Piece;
use glam::{DVec3, Mat3, Quat, Vec3};
use std::collections::{BTreeMap, HashMap};
use windfall_core::foliage::{Leaf, LeafShape};

/// Largest distance between a vertex and its place in the shared shape, as part of the piece's
/// radius.
const TOLERANCE: f32 = 0.005;
/// Most of the same where a file stores coordinates in coarse steps: beyond, leaves would look alike that are not.
const MOST_NOISE: f32 = 0.2;
/// Largest difference of texture coordinates within one shape: a texel or two.
const UV_TOLERANCE: f32 = 1.0 / 1024.0;
/// Shapes that a piece is compared with, the likeliest first, before it gets one of its own: bounds the time that a
/// crown of unequal leaves takes.
const MOST_TRIALS: usize = 64;
/// Leaves of a shape that are asked on which side the twig is.
const VOTERS: usize = 16;

/// Turns pieces into leaves, and collects their shapes.
#[derive(Default)]
pub(crate) struct Shaper {
    leaves: Vec<Leaf>,
    shapes: Vec<LeafShape>,
    /// The first piece of each shape.
    models: Vec<Model>,
    /// Shapes by how many triangles and places they have, then by a number that rotation and size do not change.
    index: HashMap<(usize, usize), BTreeMap<u32, Vec<u32>>>,
}

/// The piece that a shape was made from, and the shape's frame in it.
struct Model {
    walk: Walk,
    frame: Frame,
    /// Distance between neighbouring values of its coordinates.
    step: f32,
}

/// Where a shape stands in the tree.
#[derive(Clone, Copy)]
struct Frame {
    center: Vec3,
    orientation: Quat,
}

impl Shaper {
    /// Adds one piece as a leaf of `material`.
    pub fn add(&mut self, piece: &Piece, material: u32) {
        let walk = Walk::of(piece);
        let middle = walk.middle;
        let (shape, orientation, scale, center) = if let Some((
            shape,
            Similarity { rotation, scale },
        )) = self.find(&walk, piece.mesh.step)
        {
            let Model { walk, frame, .. } = &self.models[shape as usize];
            let center = middle + rotation * (frame.center - walk.middle) * scale;
            (shape, rotation * frame.orientation, scale, center)
        } else {
            let shape = self.shapes.len() as u32;
            let frame = Frame::of(&piece.mesh);
            let trials = self.index.entry(walk.size()).or_default();
            trials.entry(walk.invariant().to_bits()).or_default().push(shape);
            self.shapes.push(frame.shape(&piece.mesh));
            self.models.push(Model { walk, frame, step: piece.mesh.step });
            (shape, frame.orientation, 1.0, frame.center)
        };
        self.leaves.push(Leaf {
            center,
            orientation: orientation.normalize(),
            scale,
            shape,
            material,
            bent_normal: orientation * Vec3::Y,
            ambient: 1.0,
            shed_rank: 0,
        });
    }

    /// The leaves and their shapes, +Z pointing away from the wood.
    pub fn finish(mut self, wood: &[Vec3]) -> (Vec<Leaf>, Vec<LeafShape>) {
        let turn = self.turned(wood);
        let half_turn = Quat::from_rotation_y(std::f32::consts::PI);
        for leaf in &mut self.leaves {
            if turn[leaf.shape as usize] {
                leaf.orientation = (leaf.orientation * half_turn).normalize();
            }
        }
        for (shape, _) in self.shapes.iter_mut().zip(turn).filter(|(_, turn)| *turn) {
            for vector in shape.positions.iter_mut().chain(&mut shape.normals) {
                *vector = Vec3::new(-vector.x, vector.y, -vector.z);
            }
        }
        (self.leaves, self.shapes)
    }

    fn find(&self, walk: &Walk, step: f32) -> Option<(u32, Similarity)> {
        let radius = walk.radius();
        let trials = self.index.get(&walk.size())?;
        // As stored, each coordinate is off by half a step at most, in the piece and in its model.
        let noise = |model: &Model| 3f32.sqrt() * 0.5 * (step + model.step);
        let most = (TOLERANCE + 3f32.sqrt() * step / radius.max(f32::MIN_POSITIVE)).min(MOST_NOISE);
        let number = walk.invariant();
        // Positive floats are ordered as their bits are.
        let [low, middle, high] = [number - 4.0 * most, number, number + 4.0 * most]
            .map(|number| number.max(0.0).to_bits());
        let above = trials.range(middle..=high).flat_map(|(_, shapes)| shapes);
        let below = trials.range(low..middle).rev().flat_map(|(_, shapes)| shapes);
        let mut likely: Vec<u32> =
            above.take(MOST_TRIALS).chain(below.take(MOST_TRIALS)).copied().collect();
        let away = |shape: &u32| (self.models[*shape as usize].walk.invariant() - number).abs();
        likely.sort_by(|a, b| away(a).total_cmp(&away(b)));
        likely.into_iter().take(MOST_TRIALS).find_map(|shape| {
            let model = &self.models[shape as usize];
            let tolerance = (TOLERANCE * radius + noise(model)).min(MOST_NOISE * radius);
            model.walk.find(walk, UV_TOLERANCE, 6.0 * most, |places| {
                let to: Vec<Vec3> = places.iter().map(|&i| walk.points[i as usize]).collect();
                let fit = fit(&model.walk.points, model.walk.middle, &to, walk.middle)?;
                let close = model.walk.points.iter().zip(&to).all(|(&a, &b)| {
                    let placed = fit.rotation * (a - model.walk.middle) * fit.scale;
                    placed.distance(b - walk.middle) <= tolerance
                });
                close.then_some((shape, fit))
            })
        })
    }

    /// For each shape, whether its long axis points to the wood instead of away from it.
    fn turned(&self, wood: &[Vec3]) -> Vec<bool> {
        let mut radii: Vec<f32> = self
            .leaves
            .iter()
            .map(|leaf| leaf.scale * self.shapes[leaf.shape as usize].radius())
            .collect();
        if radii.is_empty() {
            return Vec::new();
        }
        let middle = radii.len() / 2;
        let (_, &mut typical, _) = radii.select_nth_unstable_by(middle, f32::total_cmp);
        let twigs = Points::new(wood, 2.0 * typical);
        let crown = self.leaves.iter().map(|l| l.center / self.leaves.len() as f32).sum::<Vec3>();
        let ends: Vec<[Vec3; 2]> = self.shapes.iter().map(ends).collect();
        let mut votes = vec![0.0f32; self.shapes.len()];
        let mut voters = vec![0; self.shapes.len()];
        for leaf in &self.leaves {
            let shape = leaf.shape as usize;
            if voters[shape] >= VOTERS {
                continue;
            }
            voters[shape] += 1;
            let [back, front] =
                ends[shape].map(|end| leaf.center + leaf.orientation * end * leaf.scale);
            votes[shape] += match (twigs.distance(back), twigs.distance(front)) {
                (None, None) => 0.01 * (front - back).dot(leaf.center - crown).signum(),
                (back, front) => {
                    let far = 2.0 * typical;
                    (front.unwrap_or(far) - back.unwrap_or(far)) / far
                }
            };
        }
        votes.iter().map(|&vote| vote < 0.0).collect()
    }
}

/// The middles of a shape's two ends along Z.
fn ends(shape: &LeafShape) -> [Vec3; 2] {
    let (low, high) = shape
        .positions
        .iter()
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), p| (l.min(p.z), h.max(p.z)));
    let margin = (high - low) * 0.05;
    let middle = |chosen: &dyn Fn(f32) -> bool| {
        let chosen: Vec<Vec3> = shape.positions.iter().copied().filter(|p| chosen(p.z)).collect();
        mean(&chosen)
    };
    [middle(&|z| z <= low + margin), middle(&|z| z >= high - margin)]
}

fn mean(points: &[Vec3]) -> Vec3 {
    points.iter().sum::<Vec3>() / points.len().max(1) as f32
}

impl Frame {
    /// The leaf frame of a piece, up to the sign of Z.
    fn of(piece: &Mesh) -> Self {
        let areas: Vec<Vec3> = piece.area_vectors().collect();
        let total: f32 = areas.iter().map(|a| a.length()).sum::<f32>().max(f32::MIN_POSITIVE);
        let corners = |i: usize| {
            let t = &piece.indices[3 * i..3 * i + 3];
            [t[0], t[1], t[2]].map(|corner| piece.positions[corner as usize])
        };
        let center: Vec3 = areas
            .iter()
            .enumerate()
            .map(|(i, area)| corners(i).iter().sum::<Vec3>() / 3.0 * (area.length() / total))
            .sum();
        let mut up: Vec3 = areas.iter().sum();
        if up.length() < 0.1 * total {
            // Sides that cancel, as in a closed body or with separate back faces: take the largest.
            up = areas
                .iter()
                .copied()
                .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))
                .unwrap_or(Vec3::Y);
        }
        let up = up.as_dvec3().normalize_or(DVec3::Y).as_vec3();
        let (a, b) = up.any_orthonormal_pair();

        // Second moments of area in the plane across `up`.
        let (mut aa, mut ab, mut bb) = (0.0, 0.0, 0.0);
        for (i, area) in areas.iter().enumerate() {
            let flat =
                corners(i).map(|p| glam::Vec2::new((p - center).dot(a), (p - center).dot(b)));
            let sum: glam::Vec2 = flat.iter().sum();
            let weight = area.length() / total;
            for v in flat.into_iter().chain([sum]) {
                aa += weight * v.x * v.x;
                ab += weight * v.x * v.y;
                bb += weight * v.y * v.y;
            }
        }
        let angle = 0.5 * (2.0 * ab).atan2(aa - bb);
        let elongation = ((aa - bb) * 0.5).hypot(ab) / ((aa + bb) * 0.5).max(f32::MIN_POSITIVE);
        let mut long = a * angle.cos() + b * angle.sin();
        if elongation < 0.05 {
            // As wide as long: leaf pictures stand upright.
            let upright = upright(piece);
            long = (upright - up * upright.dot(up)).try_normalize().unwrap_or(long);
        }
        let axes = Mat3::from_cols(up.cross(long), up, long);
        Self { center, orientation: Quat::from_mat3(&axes).normalize() }
    }

    fn shape(&self, piece: &Mesh) -> LeafShape {
        let back = self.orientation.inverse();
        // Normals that were bent for shading would be wrong on every other leaf of the shape.
        let own = piece.face_normals();
        let plain = piece.normals.iter().zip(&own).all(|(n, own)| n.dot(*own) > 0.5);
        let normals = if plain { &piece.normals } else { &own };
        LeafShape {
            positions: piece.positions.iter().map(|&p| back * (p - self.center)).collect(),
            normals: normals.iter().map(|&n| (back * n).normalize_or(Vec3::Y)).collect(),
            uvs: piece.uvs.clone(),
            indices: piece.indices.clone(),
        }
    }
}

/// Direction in which `v` falls, upwards in the picture; zero without texture coordinates.
fn upright(piece: &Mesh) -> Vec3 {
    piece
        .indices
        .chunks_exact(3)
        .map(|t| {
            let [a, b, c] = [t[0], t[1], t[2]].map(|i| i as usize);
            let [p, q] = [b, c].map(|i| piece.positions[i] - piece.positions[a]);
            let [s, t] = [b, c].map(|i| piece.uvs[i] - piece.uvs[a]);
            // p = s.x U + s.y V and q = t.x U + t.y V, solved for V times the determinant squared.
            (p * t.x - q * s.x) * s.perp_dot(t)
        })
        .sum()
}

/// Points in a grid of cells, for the distance to the nearest.
struct Points<'a> {
    cell: f32,
    all: &'a [Vec3],
    cells: HashMap<[i32; 3], Vec<u32>>,
}

impl<'a> Points<'a> {
    fn new(points: &'a [Vec3], cell: f32) -> Self {
        let cell = cell.max(f32::MIN_POSITIVE);
        let mut cells: HashMap<[i32; 3], Vec<u32>> = HashMap::new();
        for (i, &point) in points.iter().enumerate() {
            cells.entry(Self::home(point, cell)).or_default().push(i as u32);
        }
        Self { cell, all: points, cells }
    }

    fn home(point: Vec3, cell: f32) -> [i32; 3] {
        (point / cell).floor().to_array().map(|x| x as i32)
    }

    /// Distance to the nearest point, of those within about one cell.
    fn distance(&self, from: Vec3) -> Option<f32> {
        let home = Self::home(from, self.cell);
        (0..27)
            .filter_map(|n| {
                let cell = [n % 3, n / 3 % 3, n / 9];
                self.cells.get(&std::array::from_fn(|i| home[i].saturating_add(cell[i] - 1)))
            })
            .flatten()
            .map(|&i| self.all[i as usize].distance_squared(from))
            .min_by(f32::total_cmp)
            .map(f32::sqrt)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::leaves::Pieces;
    use glam::{EulerRot, Vec2};

    #[test]
    fn leaves_of_many_shapes_find_their_own() {
        // Crooked quads, thousands of which are nearly as long as wide: each shape twice, turned and in two sizes.
        let shapes = 600;
        let mut mesh = Mesh::default();
        for i in 0..2 * shapes {
            let shape = (i % shapes) as f32;
            let bend = |corner: f32| {
                0.2 * ((shape * 12.9898 + corner * 78.233).sin() * 43_758.547).fract()
            };
            let turn = Quat::from_euler(EulerRot::XYZ, 0.7 * i as f32, 1.3 * i as f32, 0.2);
            let first = mesh.positions.len() as u32;
            for (n, (x, z)) in (0..).zip([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]) {
                let corner = Vec3::new(x + bend(n as f32), bend(n as f32 + 4.0), z);
                let size = 0.05 * (1.0 + (i / shapes) as f32);
                mesh.positions.push(turn * corner * size + Vec3::X * i as f32);
                mesh.normals.push(turn * Vec3::Y);
                mesh.uvs.push(Vec2::new(x, z));
            }
            mesh.indices.extend([0, 2, 1, 0, 3, 2].map(|corner| first + corner));
        }
        let pieces = Pieces::cut(mesh);
        let mut scratch = pieces.scratch();
        let mut shaper = Shaper::default();
        for i in 0..pieces.len() {
            shaper.add(&pieces.piece(i, &mut scratch), 0);
        }
        let (leaves, found) = shaper.finish(&[]);
        // A few are alike by chance.
        assert!(leaves.len() == 2 * shapes && found.len() > shapes - 10, "{}", found.len());
        let missed = (0..shapes).filter(|&i| leaves[i].shape != leaves[i + shapes].shape).count();
        assert_eq!(missed, 0, "of {shapes}");
    }
}
