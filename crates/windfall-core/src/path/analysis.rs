//! Where leaves may start on a path, and where playback may jump back (VB 4.2).
//!
//! VB jump where the displacement *increments* match. Here a joint may also turn everything that
//! follows about the vertical, so that two samples match when they look alike from *some* direction:
//! many more pairs do, and laps that turn do not carry a leaf ever further the same way. What gap is
//! left is blended away before the joint, in samples of the joint's own ([`super::tables`]).

use super::FallPath;
use crate::error::{InputError, InputErrorKind};
use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};
use std::f32::consts::TAU;

/// Most joints kept of a path.
pub const MAX_JOINTS: usize = 8;
/// Most starting points kept of a path.
pub const MAX_STARTS: usize = 32;

/// What is known of a path beside its samples.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Analysis {
    /// Samples at which a fall may begin: slow, and with the leaf roughly parallel to the ground
    /// (VB 4.2). In ascending order, at least one, all before the first joint's blend.
    pub starts: Vec<u32>,
    /// Jumps that keep a fall going, the best first; at least one.
    pub joints: Vec<Joint>,
}

/// A continuity point: on reaching sample `from`, playback goes on from sample `to`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// Sample that is left.
    pub from: u32,
    /// Sample that is entered, below `from`, at least 1.
    pub to: u32,
    /// Samples before `from` over which the motion fades into the one that leads to `to`.
    pub blend: u32,
    /// **Half** of the angle about +Y by which each lap is turned against the lap before, in units of
    /// 2⁻³² of a full turn. An integer, so that any number of laps is reduced to one turn exactly.
    pub half_turn: u32,
    /// How well the two samples match as they are.
    pub raw: Gap,
    /// What is left after blending, measured on the curve that is played.
    pub blended: Gap,
}

/// How far motion before a joint and after it are apart; zero is perfect.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Gap {
    /// Metres. Raw: difference of the increments to the next sample (VB's criterion).
    pub position: f32,
    /// Fraction of the path's mean speed.
    pub velocity: f32,
    /// Radians.
    pub orientation: f32,
    /// Fraction of the path's root-mean-square angular speed (of 1 rad/s if that is less).
    pub angular_velocity: f32,
}

impl Joint {
    /// Angle about +Y by which each lap is turned, radians in `-π..π`.
    pub fn turn(&self) -> f32 {
        self.half_turn.wrapping_mul(2) as i32 as f32 * (TAU / 4_294_967_296.0)
    }

    /// The same turn as a rotation.
    pub fn rotation(&self) -> Quat {
        Quat::from_rotation_y(self.turn())
    }
}

/// Motion at a sample, for matching.
struct Motion {
    v: Vec3,
    w: Vec3,
    /// Upper side's normal, Y component: does not change with a turn about Y.
    up: f32,
    q: Quat,
}

/// Mean speed and root-mean-square angular speed of a path, the measures of its gaps.
pub(crate) fn scales(path: &FallPath) -> (f32, f32) {
    let n = path.positions().len();
    let speed = (0..n).map(|i| path.velocity(i).length()).sum::<f32>() / n as f32;
    let spin = (0..n).map(|i| path.angular_velocity(i).length_squared()).sum::<f32>() / n as f32;
    (speed.max(1e-4), spin.sqrt().max(1.0))
}

/// Finds starting points and joints.
pub(crate) fn analyse(path: &FallPath) -> Result<Analysis, InputError> {
    let joints = find_joints(path)?;
    let first_blend = joints.iter().map(|j| j.from - j.blend).min().unwrap_or(1);
    let starts = find_starts(path, first_blend);
    let mut analysis = Analysis { starts, joints };
    super::tables::measure_joints(path, &mut analysis);
    Ok(analysis)
}

/// Checks an analysis that was read from a file.
pub(crate) fn check(path: &FallPath, analysis: &Analysis) -> Result<(), InputError> {
    let n = path.positions().len() as u32;
    let refuse = |place: String, cause: &str| {
        Err(InputError::new(path.name(), place, InputErrorKind::OutOfRange, cause))
    };
    if analysis.starts.is_empty() || analysis.joints.is_empty() {
        return refuse(String::new(), "a path needs a starting point and a continuity point");
    }
    for (i, j) in analysis.joints.iter().enumerate() {
        let place = || format!("continuity point {i}");
        if j.to < 1 || j.from <= j.to || j.from >= n {
            return refuse(place(), "must lead from a sample of the path to an earlier one");
        }
        if j.blend < 1 || j.blend > j.to || j.blend >= j.from - j.to {
            return refuse(place(), "blends over more samples than there are");
        }
        if path.positions()[j.from as usize].y >= path.positions()[j.to as usize].y {
            return refuse(place(), "does not descend from lap to lap");
        }
        let gaps = [j.raw, j.blended];
        if gaps
            .iter()
            .any(|g| !(g.position + g.velocity + g.orientation + g.angular_velocity).is_finite())
        {
            return refuse(place(), "a gap is NaN or infinite");
        }
    }
    let first_blend = analysis.joints.iter().map(|j| j.from - j.blend).min().unwrap_or(0);
    if analysis.starts.windows(2).any(|w| w[0] >= w[1])
        || analysis.starts.last().is_some_and(|&s| s >= first_blend)
    {
        let cause = "must ascend and lie before the first continuity point's blend";
        return refuse("starting points".into(), cause);
    }
    Ok(())
}

fn find_joints(path: &FallPath) -> Result<Vec<Joint>, InputError> {
    let (positions, rate) = (path.positions(), path.rate());
    let n = positions.len();
    let (speed, spin) = scales(path);
    let motion: Vec<Motion> = (0..n)
        .map(|i| Motion {
            v: path.velocity(i),
            w: path.angular_velocity(i),
            up: (path.orientations()[i] * Vec3::Y).y,
            q: path.orientations()[i],
        })
        .collect();
    let shortest = (n * 7 / 20).max(4);
    let descent = path.drop() / (n - 1) as f32;
    // Long paths offer pairs in plenty: look at no more than some thousand samples of each half.
    let stride = n.div_ceil(6000);

    // (score, from, to), the best of each `to`: nearby pairs are alike.
    let mut candidates: Vec<(f32, usize, usize)> = Vec::new();
    for to in (1..n / 2).step_by(stride) {
        let mut best: Option<(f32, usize)> = None;
        let c = &motion[to];
        for from in ((n / 2).max(to + shortest)..n - 1).step_by(stride) {
            let f = &motion[from];
            // Whatever a turn about Y cannot mend, first: cheap, and it excludes nearly all pairs.
            let quick = ((c.up - f.up) * 4.0).powi(2)
                + ((c.v.y - f.v.y) * 4.0 / speed).powi(2)
                + ((c.w.y - f.w.y) * 4.0 / spin).powi(2);
            if best.is_some_and(|(s, _)| quick >= s) {
                continue;
            }
            if positions[to].y - positions[from].y < 0.5 * descent * (from - to) as f32 {
                continue;
            }
            let score = score(&motion[from], &motion[to], speed, spin);
            if best.is_none_or(|(s, _)| score < s) {
                best = Some((score, from));
            }
        }
        candidates.extend(best.map(|(score, from)| (score, from, to)));
    }
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0));

    let apart = ((rate * 0.15) as usize).max(1);
    let mut chosen: Vec<(f32, usize, usize)> = Vec::new();
    for candidate in candidates {
        let (score, from, to) = candidate;
        // A joint much worse than the best is worth less than the variety it would give.
        let worse = chosen.first().is_some_and(|best| score > 0.3 + 2.0 * best.0);
        if chosen.len() == MAX_JOINTS || worse {
            break;
        }
        if chosen.iter().all(|c| c.1.abs_diff(from) + c.2.abs_diff(to) >= apart) {
            chosen.push(candidate);
        }
    }
    if chosen.is_empty() {
        let (from, to) = steepest_pair(path)?;
        chosen.push((score(&motion[from], &motion[to], speed, spin), from, to));
    }
    Ok(chosen
        .into_iter()
        .map(|(score, from, to)| {
            let (f, c) = (&motion[from], &motion[to]);
            let half_turn = half_turn(f.q, c.q);
            // The larger the gap, the longer the blend: 0.08 to 0.33 s.
            let wanted = rate * (0.08 + 0.25 * score.min(1.0));
            let blend = (wanted.round() as usize).clamp(1, to.min(from - to - 1)) as u32;
            let raw = raw_gap(path, from, to, half_turn, speed, spin);
            let (from, to) = (from as u32, to as u32);
            Joint { from, to, blend, half_turn, raw, blended: raw }
        })
        .collect())
}

/// How badly two samples match, about 1 where it begins to show; turned as suits them best.
fn score(f: &Motion, c: &Motion, speed: f32, spin: f32) -> f32 {
    let (turn, swing) = turn_between(f.q, c.q);
    let rotation = Quat::from_rotation_y(turn);
    (swing * 4.0).powi(2)
        + ((rotation * c.v - f.v).length() * 4.0 / speed).powi(2)
        + ((rotation * c.w - f.w).length() * 4.0 / spin).powi(2)
}

/// The turn about Y that brings `c` nearest to `f`, and the angle that then remains: the twist and
/// the swing of the rotation between them.
fn turn_between(f: Quat, c: Quat) -> (f32, f32) {
    let r = f * c.conjugate();
    let twist = (r.y * r.y + r.w * r.w).sqrt();
    // A leaf upside down against the other has no best turn; none will do.
    let turn = if twist < 1e-6 { 0.0 } else { 2.0 * r.y.atan2(r.w) };
    (turn, 2.0 * twist.min(1.0).acos())
}

fn half_turn(f: Quat, c: Quat) -> u32 {
    let mut turn = turn_between(f, c).0.rem_euclid(TAU);
    if turn > TAU * 0.5 {
        turn -= TAU;
    }
    // The sum over laps divides by the sine of half the turn: none is better than next to none.
    if turn.abs() < 0.02 {
        return 0;
    }
    (f64::from(turn) / f64::from(TAU) * 0.5 * 4_294_967_296.0).round() as i64 as u32
}

fn raw_gap(path: &FallPath, from: usize, to: usize, half_turn: u32, speed: f32, spin: f32) -> Gap {
    let joint =
        Joint { from: 0, to: 0, blend: 0, half_turn, raw: Gap::default(), blended: Gap::default() };
    let turn = joint.rotation();
    let last = path.positions().len() - 1;
    let step = |i: usize| path.positions()[(i + 1).min(last)] - path.positions()[i.min(last - 1)];
    Gap {
        position: (step(from) - turn * step(to)).length(),
        velocity: (path.velocity(from) - turn * path.velocity(to)).length() / speed,
        orientation: angle(path.orientations()[from], turn * path.orientations()[to]),
        angular_velocity: (path.angular_velocity(from) - turn * path.angular_velocity(to)).length()
            / spin,
    }
}

/// Angle of the rotation between two orientations, radians; exact for small angles too.
pub fn angle(a: Quat, b: Quat) -> f32 {
    let r = a * b.conjugate();
    2.0 * r.xyz().length().atan2(r.w.abs())
}

/// For paths that offer nothing better: the pair with the largest drop between them.
fn steepest_pair(path: &FallPath) -> Result<(usize, usize), InputError> {
    let y = |i: usize| path.positions()[i].y;
    let n = path.positions().len();
    let mut highest = 1;
    let mut best = (0.0, 0, 0);
    for from in 5..n {
        if y(from - 4) > y(highest) {
            highest = from - 4;
        }
        let drop = y(highest) - y(from);
        if drop > best.0 {
            best = (drop, from, highest);
        }
    }
    if best.0 < 1e-3 {
        let cause = "the path does not descend: no part of it that could be repeated ends lower \
                     than it begins";
        return Err(InputError::new(path.name(), "", InputErrorKind::OutOfRange, cause));
    }
    Ok((best.1, best.2))
}

fn find_starts(path: &FallPath, before: u32) -> Vec<u32> {
    let speed = scales(path).0;
    // Slow: below the mean, or as good as it where the speed hardly changes; level: within 40 degrees, either face up.
    let cost = |i: u32| {
        let up = (path.orientations()[i as usize] * Vec3::Y).y.abs().min(1.0);
        let (tilt, v) = (up.acos(), path.velocity(i as usize).length());
        (v / speed + tilt, v <= 1.02 * speed && tilt <= 0.7)
    };
    // A start late in the path would leave little of it before the first jump.
    let end = (before / 2).max(1).min(before);
    let mut wanted: Vec<(f32, u32)> =
        (0..end).filter_map(|i| Some(cost(i)).filter(|c| c.1).map(|c| (c.0, i))).collect();
    wanted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let apart = ((path.rate() * 0.05) as u32).max(1);
    let mut starts: Vec<u32> = Vec::new();
    for (_, i) in wanted {
        if starts.len() < MAX_STARTS && starts.iter().all(|s| s.abs_diff(i) >= apart) {
            starts.push(i);
        }
    }
    if starts.is_empty() {
        starts.push((0..end).min_by(|&a, &b| cost(a).0.total_cmp(&cost(b).0)).unwrap_or(0));
    }
    starts.sort_unstable();
    starts
}
