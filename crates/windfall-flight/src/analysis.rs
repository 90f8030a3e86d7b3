//! Finds where leaves may start on a path, and where playback may jump back (VB 4.2).
//!
//! VB jump where the displacement *increments* match. Here a joint may also turn everything that
//! follows about the vertical, so that two samples match when they look alike from *some* direction:
//! many more pairs do, and laps that turn do not carry a leaf ever further the same way. The remaining
//! gap is blended away before the joint, in samples of the joint's own ([`windfall_core::path::tables`]).

use glam::{Quat, Vec3};
use std::f32::consts::TAU;
use windfall_core::path::analysis::{MAX_JOINTS, MAX_STARTS, angle};
use windfall_core::path::{Analysis, FallPath, Gap, Joint, PathTables, Recording};
use windfall_core::{InputError, InputErrorKind};

/// Motion at a sample, for matching.
struct Motion {
    v: Vec3,
    w: Vec3,
    /// Upper side's normal, Y component: does not change with a turn about Y.
    up: f32,
    q: Quat,
}

/// Mean speed and root-mean-square angular speed of a path, the measures of its gaps.
fn scales(path: &Recording) -> (f32, f32) {
    let n = path.positions().len();
    let speed = (0..n).map(|i| path.velocity(i).length()).sum::<f32>() / n as f32;
    let spin = (0..n).map(|i| path.angular_velocity(i).length_squared()).sum::<f32>() / n as f32;
    (speed.max(1e-4), spin.sqrt().max(1.0))
}

/// Finds starting points and joints of a recording.
///
/// # Errors
///
/// If no part of it that could be repeated descends.
pub fn analyse(path: &Recording) -> Result<Analysis, InputError> {
    let joints = find_joints(path)?;
    let first_blend = joints.iter().map(|j| j.from - j.blend).min().unwrap_or(1);
    let starts = find_starts(path, first_blend);
    measure_joints(path, Analysis { starts, joints })
}

/// Checks samples taken `rate` times a second, repairs what can be repaired, and analyses them.
///
/// # Errors
///
/// What [`Recording::new`] refuses, and a path of which no part that could be repeated descends. The error's `file`
/// is `name`.
pub fn fall_path(
    name: impl Into<String>,
    rate: f32,
    positions: Vec<Vec3>,
    orientations: Vec<Quat>,
) -> Result<FallPath, InputError> {
    let recording = Recording::new(name, rate, positions, orientations)?;
    let analysis = analyse(&recording)?;
    FallPath::new(recording, analysis)
}

fn find_joints(path: &Recording) -> Result<Vec<Joint>, InputError> {
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

fn raw_gap(path: &Recording, from: usize, to: usize, half_turn: u32, speed: f32, spin: f32) -> Gap {
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

/// For paths that offer nothing better: the pair with the largest drop between them.
fn steepest_pair(path: &Recording) -> Result<(usize, usize), InputError> {
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

fn find_starts(path: &Recording, before: u32) -> Vec<u32> {
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

/// Measures what blending left of the gaps, on the curve itself.
fn measure_joints(path: &Recording, analysis: Analysis) -> Result<Analysis, InputError> {
    let tables = PathTables::of_path(&FallPath::new(path.clone(), analysis.clone())?);
    let mut analysis = analysis;
    let (speed, spin) = scales(path);
    let record = tables.paths[0];
    for (k, joint) in analysis.joints.iter_mut().enumerate() {
        let j = &tables.joints[k];
        let turn = joint.rotation();
        let [a, b] = [j.from, j.to].map(|u| tables.curve(&record, j, u as f32));
        let (v0, w0) = tables.motion(&record, j, j.from - 1, 1.0);
        let (v1, w1) = tables.motion(&record, j, j.to, 0.0);
        joint.blended = Gap {
            position: (a.position - (b.position + Vec3::from(j.lap))).length(),
            velocity: (v0 - turn * v1).length() * path.rate() / speed,
            orientation: angle(a.orientation, turn * b.orientation),
            angular_velocity: (w0 - turn * w1).length() * path.rate() / spin,
        };
    }
    Ok(analysis)
}
