//! What is known of a fall path beside its samples: where leaves may start on it, and where playback may jump back
//! (VB 4.2). The crate `windfall-flight` finds it.

use super::Recording;
use crate::error::{InputError, InputErrorKind};
use glam::Quat;
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

/// Checks an analysis against the recording that it is of.
pub(super) fn check(path: &Recording, analysis: &Analysis) -> Result<(), InputError> {
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

/// Angle of the rotation between two orientations, radians; exact for small angles too.
pub fn angle(a: Quat, b: Quat) -> f32 {
    let r = a * b.conjugate();
    2.0 * r.xyz().length().atan2(r.w.abs())
}
