//! Where a leaf is at a time: closed form, whatever the time (VB 3.4, 3.5, 4.2).

use super::{Landing, PathSet, PathTables, Variant, Variation};
use crate::foliage::Leaf;
use crate::forest::{Instance, Terrain};
use crate::rng::hash;
use crate::wind::Wind;
use glam::{Quat, Vec3};
use std::f32::consts::TAU;

/// One leaf that falls or will.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeafFall {
    /// Centre of the leaf on its twig, in the world, metres.
    pub origin: Vec3,
    /// Unit rotation from the leaf's frame into the world's while it hangs.
    pub twig_orientation: Quat,
    /// Foot of its tree, metres: the gusts that carry the leaf are those there.
    pub tree: Vec3,
    /// What [`Variation::Hashed`] draws from: a hash of instance and leaf.
    pub seed: u32,
    /// Group of paths ([`PathSet::group`]) that it falls by.
    pub group: u32,
    /// Time at which it detaches, seconds.
    pub detach_time: f64,
}

impl LeafFall {
    /// The fall of a leaf of a tree by a group of paths.
    pub fn of(instance: &Instance, leaf: &Leaf, group: u32, detach_time: f64) -> Self {
        Self {
            origin: instance.world_from_tree(leaf.center),
            twig_orientation: instance.rotation() * leaf.orientation,
            tree: instance.position,
            seed: hash(instance.seed, leaf.shed_rank),
            group,
            detach_time,
        }
    }
}

/// What is the same for all falls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FallSettings {
    /// Drop over which the orientation eases from the twig's into the path's, metres (VB 3.5).
    /// Safe: 0.1 to 1; default 0.35. At most 0: at once.
    pub soft_drop: f32,
    /// Time over which the fall starts from rest, seconds. Safe: 0.2 to 1; default 0.3. At most 0:
    /// at once.
    pub soft_time: f32,
    /// Time before landing over which the orientation eases to lie on the ground, seconds. Safe: 0.1
    /// to 0.6; default 0.35. At most 0: at once.
    pub settle_time: f32,
    /// Most by which a leaf turns on the ground's normal while it settles, radians; default 0.6.
    pub settle_turn: f32,
    /// Time constant with which a leaf takes on the wind's speed, seconds. Safe: 0.1 to 1; default
    /// 0.4.
    pub wind_response: f32,
}

impl Default for FallSettings {
    fn default() -> Self {
        Self {
            soft_drop: 0.35,
            soft_time: 0.3,
            settle_time: 0.35,
            settle_turn: 0.6,
            wind_response: 0.4,
        }
    }
}

/// What a leaf is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// On its twig.
    Hanging,
    /// In the air; VB's Figure 5 colours leaves by the lap.
    Falling {
        /// Times that the path has been reused: 0 on the first pass.
        lap: u32,
    },
    /// On the ground, for good.
    Landed,
}

/// A leaf's place at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeafPose {
    /// Centre, in the world, metres.
    pub position: Vec3,
    /// Unit rotation from the leaf's frame into the world's.
    pub orientation: Quat,
    /// What it is doing.
    pub phase: Phase,
}

/// All that falls have in common: paths, ground, wind, variation.
#[derive(Debug, Clone)]
pub struct Fall<'a> {
    pub(crate) paths: &'a PathSet,
    pub(crate) terrain: &'a Terrain,
    pub(crate) wind: Wind,
    pub(crate) variation: Variation,
    pub(crate) settings: FallSettings,
    pub(crate) highest_ground: f32,
    pub(crate) steepest: f32,
}

/// A leaf on its path without ground and twig.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FreePose {
    /// From the origin, metres.
    pub displacement: Vec3,
    pub orientation: Quat,
    /// Orientation at the start.
    pub first: Quat,
    /// Distance by which it has dropped at most so far, metres: never decreases.
    pub drop: f32,
    pub lap: u32,
}

impl<'a> Fall<'a> {
    /// Brings together what falls have in common.
    pub fn new(
        paths: &'a PathSet,
        terrain: &'a Terrain,
        wind: Wind,
        variation: Variation,
        settings: FallSettings,
    ) -> Self {
        let (highest_ground, steepest) = (terrain.range().1, terrain.steepest());
        Self { paths, terrain, wind, variation, settings, highest_ground, steepest }
    }

    /// The ground.
    pub fn terrain(&self) -> &Terrain {
        self.terrain
    }

    /// The leaf's variant.
    pub fn variant(&self, leaf: &LeafFall) -> Variant {
        self.variation.of(leaf, self.paths)
    }

    /// Pose of the leaf at `time` seconds, given its [`Fall::landing`].
    ///
    /// A pure function of its arguments, continuous in time; its cost does not depend on it.
    pub fn pose(&self, leaf: &LeafFall, landing: &Landing, time: f64) -> LeafPose {
        let elapsed = (time - leaf.detach_time) as f32;
        if elapsed <= 0.0 {
            let (position, orientation) = (leaf.origin, leaf.twig_orientation);
            return LeafPose { position, orientation, phase: Phase::Hanging };
        }
        if elapsed >= landing.time {
            let (position, orientation) = (landing.position, landing.orientation);
            return LeafPose { position, orientation, phase: Phase::Landed };
        }
        let variant = self.variant(leaf);
        let mut pose = self.airborne(leaf, &variant, elapsed);
        let settle = self.settle_time(landing.time);
        let done = 1.0 - (landing.time - elapsed) / settle.max(f32::MIN_POSITIVE);
        if done > 0.0 {
            let turned =
                self.airborne(leaf, &variant, self.settling(landing.time, done)).orientation;
            pose.orientation = turned * Quat::IDENTITY.slerp(landing.settle, smooth(done));
        }
        pose
    }

    pub(crate) fn settle_time(&self, landing_time: f32) -> f32 {
        self.settings.settle_time.clamp(0.0, landing_time.max(0.0))
    }

    /// Time whose orientation a leaf has when it has settled by the fraction `done`: its own turning
    /// runs out evenly, so that a leaf that tumbles comes to rest, instead of being stopped.
    pub(crate) fn settling(&self, landing_time: f32, done: f32) -> f32 {
        let settle = self.settle_time(landing_time);
        landing_time - settle + settle * (done - 0.5 * done * done)
    }

    /// Pose `elapsed` seconds after the detachment, at least 0, as if there were no ground.
    pub fn airborne(&self, leaf: &LeafFall, variant: &Variant, elapsed: f32) -> LeafPose {
        let free = self.free(variant, elapsed);
        let blown = self.wind.displacement(
            leaf.tree,
            leaf.detach_time,
            elapsed,
            self.settings.wind_response,
        );
        let eased = self.eased(&free);
        // What turns the path's first orientation into the twig's is undone bit by bit. An
        // interpolation between the twig's and the momentary one would flip over whenever a
        // tumbling leaf passes the opposite of its twig's.
        let from_twig = free.first.conjugate() * leaf.twig_orientation;
        LeafPose {
            position: leaf.origin + free.displacement + blown,
            orientation: free.orientation * from_twig.slerp(Quat::IDENTITY, eased),
            phase: Phase::Falling { lap: free.lap },
        }
    }

    /// How far a leaf has left its twig's orientation for its path's, `elapsed` seconds after the detachment: 0 to 1.
    pub fn own_way(&self, variant: &Variant, elapsed: f32) -> f32 {
        self.eased(&self.free(variant, elapsed))
    }

    fn eased(&self, free: &FreePose) -> f32 {
        let soft = self.settings.soft_drop;
        if soft > 0.0 { smooth(free.drop / soft) } else { 1.0 }
    }

    /// Time on the path after `elapsed` seconds: it starts from rest and gains speed evenly over
    /// `soft_time`, so that it runs half of that late from then on.
    pub(crate) fn path_time(&self, variant: &Variant, elapsed: f32) -> f32 {
        let soft = self.settings.soft_time;
        let t = if elapsed < soft {
            elapsed * elapsed / (2.0 * soft)
        } else {
            elapsed - soft.max(0.0) * 0.5
        };
        t * variant.rate
    }

    /// Inverse of [`Fall::path_time`].
    pub(crate) fn elapsed(&self, variant: &Variant, path_time: f32) -> f32 {
        let (t, soft) = (path_time / variant.rate, self.settings.soft_time.max(0.0));
        if t < soft * 0.5 { (2.0 * soft * t).sqrt() } else { t + soft * 0.5 }
    }

    /// The path alone, endless: start, laps, variation.
    ///
    /// In lap `k` the path is turned by `k` times the joint's turn, and begins where lap `k - 1` left
    /// it. The displacement of all laps before is a geometric series of turns of one lap's:
    /// `sum of R^j D, j = 0..k`, which for half turn `h` is `sin(k h) / sin(h)` times `D` turned by
    /// `(k - 1) h`. Angles are integers in 2⁻³² turns: exact for any number of laps.
    pub(crate) fn free(&self, variant: &Variant, elapsed: f32) -> FreePose {
        let tables = self.paths.tables();
        let path = &tables.paths[variant.path as usize];
        let joint = &tables.joints[variant.joint as usize];
        let start = &tables.samples[(path.first_sample + variant.start) as usize];
        let begin = Vec3::from(start.position);
        let end = &tables.samples[PathTables::index(path, joint, joint.from)];
        let lap = Vec3::from(joint.lap);

        let u = variant.start as f32 + self.path_time(variant, elapsed) * path.rate;
        let beyond = u - joint.from as f32;
        let (mut k, mut local, mut before) = (0u32, u, begin);
        if beyond >= 0.0 {
            let length = (joint.from - joint.to) as f32;
            // The quotient may round up to the next lap: then the remainder is below 0.
            let full = (beyond / length) as u32;
            let rest = (beyond - full as f32 * length).clamp(0.0, length);
            k = full + 1;
            local = joint.to as f32 + rest;
            before = Vec3::from(tables.samples[(path.first_sample + joint.to) as usize].position);
        }
        let point = tables.curve(path, joint, local);
        let h = joint.half_turn;
        let (sin, cos) = sin_cos(k.wrapping_mul(h));
        let sum = if h == 0 {
            lap * k as f32
        } else {
            let (sin_h, cos_h) = sin_cos(h);
            // Sine and cosine of (k - 1) h.
            let (s, c) = (sin * cos_h - cos * sin_h, cos * cos_h + sin * sin_h);
            let ratio = sin / sin_h;
            Vec3::new(
                (lap.x * c + lap.z * s) * ratio,
                lap.y * k as f32,
                (lap.z * c - lap.x * s) * ratio,
            )
        };
        // A turn by 2 k h about Y: the quaternion has the sine and cosine of half of it.
        let turn = Quat::from_xyzw(0.0, sin, 0.0, cos);
        let mut d = (before - begin) + sum + turn * (point.position - before);
        let drop = if k == 0 {
            start.low - point.low
        } else {
            start.low - end.low - lap.y * beyond / (joint.from - joint.to) as f32
        };
        d.x *= variant.scale.x;
        d.z *= variant.scale.y;
        let yaw = Quat::from_rotation_y(variant.yaw);
        FreePose {
            displacement: yaw * d,
            orientation: yaw * turn * point.orientation,
            first: yaw * Quat::from_array(start.orientation).normalize(),
            drop,
            lap: k,
        }
    }
}

/// Hermite step from 0 at 0 to 1 at 1.
pub(crate) fn smooth(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Sine and cosine of an angle in 2⁻³² turns, to 4e-7, without branches: the nearest quarter turn is
/// split off exactly, the rest is a short series. The same on every machine, and in WGSL.
fn sin_cos(turns: u32) -> (f32, f32) {
    let quarter = turns.wrapping_add(1 << 29) >> 30;
    let x = turns.wrapping_sub(quarter << 30) as i32 as f32 * (TAU / 4_294_967_296.0);
    let x2 = x * x;
    let sin = x * (1.0 - x2 * (1.0 / 6.0 - x2 * (1.0 / 120.0 - x2 * (1.0 / 5040.0))));
    let cos = 1.0 - x2 * (0.5 - x2 * (1.0 / 24.0 - x2 * (1.0 / 720.0 - x2 * (1.0 / 40320.0))));
    let (s, c) = if quarter & 1 == 0 { (sin, cos) } else { (cos, -sin) };
    if quarter & 2 == 0 { (s, c) } else { (-s, -c) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_of_integer_angles_are_those_of_their_radians() {
        for i in 0..10_000u32 {
            let turns = i.wrapping_mul(0x9e37_79b9);
            let exact = f64::from(turns) * std::f64::consts::TAU / 4_294_967_296.0;
            let (s, c) = sin_cos(turns);
            assert!((f64::from(s) - exact.sin()).abs() < 4e-7, "{turns}");
            assert!((f64::from(c) - exact.cos()).abs() < 4e-7, "{turns}");
        }
        assert_eq!([0, 1 << 30, 1 << 31].map(sin_cos), [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0)]);
    }
}
