//! Stems: how trunk, limbs, branches and twigs grow, and their skin.

use super::params::{Level, Params, Trunk};
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::{PI, TAU};
use windfall_core::rng::Rng;
use windfall_core::tree::{Wood, WoodVertex};

/// The trunk starts this deep in the ground, metres, so that it floats on no slope.
const DEPTH: f32 = 0.35;
/// Branches level out where they would come lower than this above the trunk's foot, metres.
const CLEARANCE: f32 = 1.8;
/// The golden angle: successive stems shade each other least.
pub(super) const GOLDEN: f32 = 2.399_963_2;
/// Radius of the thinnest stem, metres: thinner ones would shimmer on any screen.
const THINNEST: f32 = 0.003;
/// Greatest radius of a stem over its parent's there: with the collar it still hides its open foot.
const STOUTEST: f32 = 0.68;
/// Stems whose foot is thinner than this radius, metres, have no bark yet.
const BARE: f32 = 0.03;

/// One stem: its axis, and its radius at every point of it.
pub(super) struct Stem {
    pub points: Vec<Vec3>,
    pub radii: Vec<f32>,
    pub length: f32,
    /// Root flare, as the trunk's; 0 for all others.
    flare: f32,
    sides: u32,
    /// 0 for the trunk.
    pub level: usize,
}

/// A place on a stem.
pub(super) struct Place {
    pub point: Vec3,
    pub heading: Vec3,
    pub radius: f32,
}

impl Stem {
    /// The place at a share `0..=1` of the length.
    pub fn at(&self, share: f32) -> Place {
        // Points are evenly spaced in length but for the trunk's foot, hence the search.
        let last = self.points.len() - 1;
        let target = share.clamp(0.0, 1.0) * self.length;
        let mut walked = 0.0;
        for i in 0..last {
            let step = self.points[i + 1] - self.points[i];
            let long = step.length();
            if walked + long >= target || i + 1 == last {
                let t = ((target - walked) / long.max(1e-6)).clamp(0.0, 1.0);
                return Place {
                    point: self.points[i] + step * t,
                    heading: step.normalize_or(Vec3::Y),
                    radius: self.radii[i] + (self.radii[i + 1] - self.radii[i]) * t,
                };
            }
            walked += long;
        }
        Place { point: self.points[last], heading: Vec3::Y, radius: self.radii[last] }
    }
}

/// Grows all stems of a tree: the trunk first, each parent before its children.
pub(super) fn grow(params: &Params, rng: &Rng) -> Vec<Stem> {
    let mut stems = vec![trunk(&params.trunk, &mut rng.stream(0))];
    let mut parents = 0..1;
    for (i, level) in params.levels.iter().enumerate() {
        let first = stems.len();
        for parent in parents {
            let mut rng = rng.stream(1 + parent as u32);
            let children = bear(&stems[parent], level, i + 1, &mut rng);
            stems.extend(children);
        }
        parents = first..stems.len();
    }
    stems
}

fn trunk(trunk: &Trunk, rng: &mut Rng) -> Stem {
    let size = 1.0 + trunk.vary * rng.range(-1.0, 1.0);
    let length = trunk.length * size + DEPTH;
    let lean = trunk.lean.to_radians() * rng.normal().clamp(-2.0, 2.0);
    let azimuth = rng.range(0.0, TAU);
    let start = Vec3::new(azimuth.cos() * lean, 1.0, azimuth.sin() * lean).normalize_or(Vec3::Y);
    let segments = trunk.mesh[0].max(1);
    let share = |i: u32| share(i as f32 / segments as f32, 0.7);
    let steps: Vec<f32> = (0..segments).map(|i| (share(i + 1) - share(i)) * length).collect();
    let points =
        wander(Vec3::NEG_Y * DEPTH, start, &steps, [0.35, 0.35], trunk.wander, f32::MIN, rng);
    let radii = (0..=segments)
        .map(|i| trunk.radius * size * tapered(share(i), trunk.taper))
        .map(|r| r.max(THINNEST))
        .collect();
    Stem { points, radii, length, flare: trunk.flare, sides: trunk.mesh[1].max(3), level: 0 }
}

/// Where along a stem the ring at a share of all rings lies: closer at the foot, where the stem
/// swells, the more so the greater `crowding`, `0..1`.
fn share(t: f32, crowding: f32) -> f32 {
    crowding * t * t + (1.0 - crowding) * t
}

/// Share of the foot's radius that is left at a share of the length.
fn tapered(share: f32, exponent: f32) -> f32 {
    (1.0 - share).max(0.0).powf(exponent)
}

/// The children of a stem.
fn bear(parent: &Stem, level: &Level, depth: usize, rng: &mut Rng) -> Vec<Stem> {
    let bearing = parent.length * (1.0 - level.from);
    let count = (bearing * level.density + rng.unit()).floor().max(2.0);
    let turn = rng.range(0.0, TAU);
    (0..count as u32)
        .map(|i| {
            let along = (i as f32 + 0.5 + 0.35 * rng.range(-1.0, 1.0)) / count;
            // The last child continues the parent, whose tip would be bare otherwise.
            let along = if i + 1 == count as u32 { 1.0 - 0.1 * rng.unit() / count } else { along };
            let place = parent.at(level.from + (1.0 - level.from) * along);
            let mut varied = || 1.0 + level.vary * rng.range(-1.0, 1.0);
            let angle = lerp(level.angle[0], level.angle[1], along).to_radians() * varied();
            let length = profile(level.length, along) * parent.length * varied();
            let azimuth = turn + GOLDEN * i as f32 + 0.5 * rng.range(-1.0, 1.0);
            let out = sideways(place.heading, azimuth, level.flat, i % 2 == 0);
            let heading = place.heading * angle.cos() + out * angle.sin();
            let radius = parent.radii[0] * (length / parent.length).powf(level.power);
            let radius = radius.min(place.radius * STOUTEST).max(THINNEST);
            let length = length.max(0.08);
            let collar = |s: f32| 0.3 * (-(s - place.radius).max(0.0) / (2.0 * radius)).exp();
            let steps = level.mesh[0].max(1);
            let share = |i: u32| share(i as f32 / steps as f32, 0.4);
            let walk: Vec<f32> = (0..steps).map(|i| (share(i + 1) - share(i)) * length).collect();
            Stem {
                points: wander(
                    place.point,
                    heading,
                    &walk,
                    level.lift,
                    level.wander,
                    CLEARANCE,
                    rng,
                ),
                // A stem is wider where it leaves its parent.
                radii: (0..=steps)
                    .map(|i| tapered(share(i), level.taper) + collar(share(i) * length))
                    .map(|r| (r * radius).max(THINNEST * 0.7))
                    .collect(),
                length,
                flare: 0.0,
                sides: level.mesh[1].max(3),
                level: depth,
            }
        })
        .collect()
}

/// A unit vector square to `heading`: at `azimuth` around it, or flattened to left and right.
pub(super) fn sideways(heading: Vec3, azimuth: f32, flat: f32, left: bool) -> Vec3 {
    let side = heading.cross(Vec3::Y).try_normalize().unwrap_or(Vec3::X);
    let up = side.cross(heading);
    let (sin, cos) = azimuth.sin_cos();
    let around = side * cos + up * sin;
    let hand = if left { side } else { -side };
    around.lerp(hand, flat).try_normalize().unwrap_or(hand)
}

/// A path of steps that follows its heading, turns with the tropism, and wobbles.
///
/// Where it would come below `clearance` metres it levels out.
fn wander(
    foot: Vec3,
    heading: Vec3,
    steps: &[f32],
    lift: [f32; 2],
    degrees: f32,
    clearance: f32,
    rng: &mut Rng,
) -> Vec<Vec3> {
    let count = steps.len() as f32;
    let mean = steps.iter().sum::<f32>() / count;
    let (mut point, mut heading, mut wobble) = (foot, heading, Vec3::ZERO);
    let mut points = vec![foot];
    for (i, &step) in steps.iter().enumerate() {
        let t = i as f32 / count;
        if i > 0 {
            heading += Vec3::Y * (lerp(lift[0], lift[1], t) / count);
            let kick = Vec3::new(rng.normal(), rng.normal(), rng.normal()).clamp_length_max(2.2);
            // A mean-reverting walk (Ornstein & Uhlenbeck): kinks, but no straying.
            wobble = wobble * 0.55 + kick * (degrees.to_radians() * 0.6 * (step / mean).sqrt());
        }
        if point.y < clearance && heading.y < 0.0 {
            heading.y *= 0.3;
        }
        heading = heading.normalize_or(Vec3::Y);
        let across = wobble - heading * wobble.dot(heading);
        point += (heading + across).normalize_or(heading) * step;
        points.push(point);
    }
    points
}

fn lerp(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// The parabola through three values at 0, ½ and 1.
fn profile(v: [f32; 3], t: f32) -> f32 {
    let middle = 2.0 * v[1] - 0.5 * (v[0] + v[2]);
    ((1.0 - t) * (1.0 - t) * v[0] + 2.0 * t * (1.0 - t) * middle + t * t * v[2]).max(0.0)
}

/// The skin of all stems. Material 0 is bark, material 1 twigs.
pub(super) fn mesh(stems: &[Stem]) -> Wood {
    let mut wood = Wood::default();
    for stem in stems {
        skin(stem, &mut wood);
    }
    wood
}

/// A tube of rings about the stem's axis that ends in a point; open at its hidden foot.
fn skin(stem: &Stem, wood: &mut Wood) {
    let rings = stem.points.len() - 1;
    let sides = stem.sides as usize;
    let base = wood.vertices.len() as u32;
    let material = u32::from(stem.level > 0 && stem.radii[0] < BARE);
    let tangent = |i: usize| {
        let before = stem.points[i.max(1)] - stem.points[i.max(1) - 1];
        let after = stem.points[(i + 1).min(rings)] - stem.points[i.min(rings - 1)];
        (before.normalize_or_zero() + after.normalize_or_zero()).normalize_or(Vec3::Y)
    };
    // Frames are carried along with the least turn, so that the skin does not twist.
    let mut across = tangent(0).any_orthonormal_vector();
    let mut heading = tangent(0);
    let mut grid = Vec::with_capacity(rings * sides);
    for i in 0..rings {
        across = Quat::from_rotation_arc(heading, tangent(i)) * across;
        heading = tangent(i);
        across = (across - heading * across.dot(heading)).normalize_or(Vec3::X);
        let other = across.cross(heading);
        for j in 0..sides {
            let angle = TAU * j as f32 / sides as f32;
            let swell = stem.flare * foot(stem.points[i].y, angle);
            let out = across * angle.cos() - other * angle.sin();
            grid.push(stem.points[i] + out * stem.radii[i] * (1.0 + swell));
        }
    }
    let tip = stem.points[rings];
    // Metres around and along; another stretch of the bark for each stem.
    let girth = TAU * stem.radii[0] * (1.0 + 0.4 * stem.flare);
    let mut along = 3.0 * (base as f32 * 0.618_034).fract();
    for i in 0..rings {
        if i > 0 {
            along += stem.points[i].distance(stem.points[i - 1]);
        }
        for column in 0..=sides {
            let j = column % sides;
            let at = |i: usize, j: usize| grid[i * sides + j % sides];
            let around = at(i, j + 1) - at(i, j + sides - 1);
            let next = if i + 1 < rings { at(i + 1, j) } else { tip };
            let rise = next - at(i.saturating_sub(1), j);
            wood.vertices.push(WoodVertex {
                position: at(i, j),
                normal: around
                    .cross(rise)
                    .try_normalize()
                    .unwrap_or_else(|| (at(i, j) - stem.points[i]).normalize_or(Vec3::Y)),
                uv: Vec2::new(girth * column as f32 / sides as f32, along),
                material,
            });
        }
    }
    along += tip.distance(stem.points[rings - 1]);
    wood.vertices.push(WoodVertex {
        position: tip,
        normal: tangent(rings),
        uv: Vec2::new(girth * 0.5, along),
        material,
    });
    let row = sides as u32 + 1;
    let end = base + rings as u32 * row;
    for i in 0..rings as u32 {
        for j in 0..sides as u32 {
            let a = base + i * row + j;
            if i + 1 < rings as u32 {
                wood.indices.extend([a, a + 1, a + row, a + 1, a + row + 1, a + row]);
            } else {
                wood.indices.extend([a, a + 1, end]);
            }
        }
    }
}

/// Swelling of the trunk's foot: wide at the ground, with a few roots.
fn foot(height: f32, angle: f32) -> f32 {
    let roots = 1.0 + 0.22 * (5.0 * angle).cos() + 0.12 * (3.0 * angle + PI / 3.0).sin();
    roots * (-(height + DEPTH).max(0.0) / 0.45).exp() * 1.6
}
