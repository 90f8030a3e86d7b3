//! When and how a leaf comes to lie on the ground (VB 3.5).

use super::playback::{Fall, smooth};
use super::{LeafFall, LeafPose, PathTables, Variant, Variation};
use crate::rng::{hash, unit};
use glam::{Quat, Vec3};

/// End of a fall: derived data, kept with the leaf so that a pose need not search for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Landing {
    /// Seconds after the detachment.
    pub time: f32,
    /// Centre of the leaf on the ground, metres.
    pub position: Vec3,
    /// Unit rotation of the leaf on the ground: along the ground, either face up.
    pub orientation: Quat,
    /// What turns the orientation that the leaf has slowed down to into [`Landing::orientation`]:
    /// applied bit by bit while it settles.
    pub settle: Quat,
}

/// Most steps of the search. Leaves need some 20 on level ground and below 100 on hills; paths that
/// dart about and hardly come down, thousands.
const MAX_STEPS: u32 = 1 << 18;
/// Depth by which a leaf may graze the ground for a moment and go on falling, metres: it lets the
/// search end.
const GRAZE: f32 = 2e-3;

impl Fall<'_> {
    /// Finds where the leaf's centre first meets the ground below it.
    ///
    /// A binary search in the running minimum of the path's height gives the first moment at which
    /// the leaf is as low as the highest ground: before, it cannot land. From there the height above
    /// the ground under the leaf, over the largest speed at which it can shrink, is a time that can
    /// safely be skipped: few steps lead to the ground, and none past it. A leaf that begins below the
    /// ground has landed at time 0.
    pub fn landing(&self, leaf: &LeafFall) -> Landing {
        let variant = self.variant(leaf);
        let record = &self.paths.tables().paths[variant.path as usize];
        let along = record.fastest_along * variant.scale.abs().max_element() * variant.rate
            + self.wind.fastest();
        let closing = record.fastest_down * variant.rate + self.steepest * along;
        let clearance = |t: f32| {
            let p = self.airborne(leaf, &variant, t).position;
            p.y - self.terrain.height(p.x, p.z)
        };

        let mut t = self
            .elapsed(&variant, self.first_time_at(&variant, leaf.origin.y - self.highest_ground));
        let mut height = clearance(t);
        let mut above = if height > 0.0 { t } else { 0.0 };
        for _ in 0..MAX_STEPS {
            if height <= 0.0 {
                break;
            }
            above = t;
            // From far up, the smallest step is what `f32` still tells apart.
            t += ((height + GRAZE) / closing).max(t * 1e-6);
            height = clearance(t);
        }
        if height <= 0.0 && clearance(0.0) > 0.0 {
            let mut below = t;
            for _ in 0..20 {
                let middle = 0.5 * (above + below);
                if clearance(middle) > 0.0 { above = middle } else { below = middle }
            }
            t = below;
        } else if clearance(0.0) <= 0.0 {
            t = 0.0;
        }
        let place = self.airborne(leaf, &variant, t).position;
        let ground = self.terrain.height(place.x, place.z);
        let normal = self.terrain.normal(place.x, place.z);
        let heading = Variation::heading(leaf) * self.settings.settle_turn;
        let arriving = self.airborne(leaf, &variant, self.settling(t, 1.0)).orientation;
        let orientation = lie_down(arriving, normal, heading);
        Landing {
            time: t,
            position: place.with_y(ground),
            orientation,
            settle: arriving.conjugate() * orientation,
        }
    }

    /// Time on the path at which the leaf may first have dropped by `drop` metres: never too late.
    fn first_time_at(&self, variant: &Variant, drop: f32) -> f32 {
        let tables = self.paths.tables();
        let path = &tables.paths[variant.path as usize];
        let joint = &tables.joints[variant.joint as usize];
        let at = |i: u32| &tables.samples[PathTables::index(path, joint, i)];
        let begin = at(variant.start).position[1];
        let lowest = at(joint.from).low;
        // Heights of lap k are the path's plus k laps': the first lap that reaches the level.
        let level = begin - drop;
        let k = ((level - lowest) / joint.lap[1]).ceil().max(0.0);
        let in_lap = level - k * joint.lap[1];
        let (mut low, mut high) =
            if k == 0.0 { (variant.start, joint.from) } else { (joint.to, joint.from) };
        while low < high {
            let middle = u32::midpoint(low, high);
            if at(middle).low <= in_lap { high = middle } else { low = middle + 1 }
        }
        let laps = k * (joint.from - joint.to) as f32;
        // A cubic may dip below its samples: begin a sample early.
        let samples = laps + low as f32 - variant.start as f32 - 1.0;
        samples.max(0.0) / path.rate
    }
}

/// Height above the ground at which a leaf lies, metres: leaves stand a little apart, so that none flickers in another.
/// `scale` is that of leaf and tree together, `thickness` [`crate::foliage::LeafShape::thickness`].
pub fn stack_height(leaf: &LeafFall, scale: f32, thickness: f32) -> f32 {
    scale * thickness + 0.002 + 0.012 * unit(hash(leaf.seed, 13))
}

impl Fall<'_> {
    /// [`Fall::pose`] as it is drawn where trees do not sway: the leaf comes to lie `stack` metres
    /// ([`stack_height`]) above the ground.
    pub fn drawn_pose(
        &self,
        leaf: &LeafFall,
        landing: &Landing,
        stack: f32,
        time: f64,
    ) -> LeafPose {
        let mut pose = self.pose(leaf, landing, time);
        let left = landing.time - (time - leaf.detach_time) as f32;
        let settle = self.settle_time(landing.time).max(f32::MIN_POSITIVE);
        let up = landing.orientation * Vec3::Y;
        let up = if up.y < 0.0 { -up } else { up };
        pose.position += up * (stack * smooth(1.0 - left / settle));
        pose
    }
}

/// The orientation nearest to `q` in which the leaf lies along the ground, whichever face is up,
/// then turned by `heading` radians about the ground's normal.
fn lie_down(q: Quat, normal: Vec3, heading: f32) -> Quat {
    let up = q * Vec3::Y;
    let up = if up.dot(normal) < 0.0 { -up } else { up };
    (Quat::from_axis_angle(normal, heading) * Quat::from_rotation_arc(up, normal) * q).normalize()
}
