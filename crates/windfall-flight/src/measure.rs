//! What is measured on simulated falls, to hold against measurements of real ones.

use super::leaf::{Flight, LeafBody, Plate};
use glam::DVec3;
use windfall_core::rng::Rng;

/// Figures of one fall.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FallFigures {
    /// Mean speed of descent, m/s.
    pub descent: f64,
    /// Mean horizontal speed, m/s.
    pub along: f64,
    /// Half-turns per second: half revolutions of a leaf that tumbles, swings from side to side of
    /// one that flutters. Both are one rise and fall of the tilt against the horizontal.
    pub half_turns: f64,
    /// Whether the leaf turned over and over.
    pub tumbles: bool,
    /// Where it was after the first metre (0.93 m), from where it was let go, metres.
    pub landing: DVec3,
}

/// Height of the measured falls, metres.
pub const HEIGHT: f64 = 0.93;

/// Lets a leaf fall and measures from `from` to `to` seconds.
pub fn fall(plate: &Plate, rng: &mut Rng, from: f64, to: f64) -> FallFigures {
    const RATE: f64 = 250.0;
    let flight = plate.fly(Flight::released(rng), DVec3::ZERO, to, RATE);
    figures(&flight, RATE, from)
}

/// Measures a flight recorded at `rate` hertz, from `from` seconds on.
pub fn figures(flight: &[Flight], rate: f64, from: f64) -> FallFigures {
    let begin = (from * rate) as usize;
    let part = &flight[begin..];
    let span = (part.len() - 1) as f64 / rate;
    let (mut passes, mut turns) = (0u32, 0u32);
    // A maximum of the tilt counts when it stands out by 0.15 rad on both sides.
    let (mut rising, mut extreme) = (true, 0.0f64);
    let mut along = 0.0;
    for w in part.windows(2) {
        let d = w[1].position - w[0].position;
        along += d.x.hypot(d.z);
        if w[0].up().y * w[1].up().y < 0.0 {
            passes += 1;
        }
        let tilt = w[1].up().y.abs().min(1.0).acos();
        if rising {
            extreme = extreme.max(tilt);
            if tilt < extreme - 0.15 {
                (rising, extreme) = (false, tilt);
                turns += 1;
            }
        } else {
            extreme = extreme.min(tilt);
            if tilt > extreme + 0.15 {
                (rising, extreme) = (true, tilt);
            }
        }
    }
    let landing = flight
        .iter()
        .find(|s| s.position.y < -HEIGHT)
        .or(flight.last())
        .map_or(DVec3::ZERO, |s| s.position);
    let half_turns = f64::from(turns) / span;
    FallFigures {
        descent: (part[0].position.y - part[part.len() - 1].position.y) / span,
        along: along / span,
        half_turns,
        tumbles: turns > 2 && 2 * passes > turns,
        landing,
    }
}

/// Means over many falls.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Row {
    /// Number of falls.
    pub falls: u32,
    /// Mean speed of descent, m/s.
    pub descent: f64,
    /// Mean horizontal speed, m/s.
    pub along: f64,
    /// Mean half-turns per second of the falls that flutter or tumble; 0 if none does.
    pub half_turns: f64,
    /// Share of falls that tumble.
    pub tumbling: f64,
    /// Standard deviation along an axis of the place after [`HEIGHT`], metres.
    pub scatter: f64,
}

/// Lets `falls` leaves fall, each released at rest in another orientation.
pub fn row(body: &LeafBody, falls: u32, seed: u32) -> Row {
    let plate = body.plate();
    let mut row = Row { falls, ..Row::default() };
    let (mut tumbling, mut turning, mut square) = (0u32, 0u32, 0.0);
    for i in 0..falls {
        let f = fall(&plate, &mut Rng::new(seed).stream(i), 1.0, 4.0);
        row.descent += f.descent;
        row.along += f.along;
        square += 0.5 * (f.landing.x.powi(2) + f.landing.z.powi(2));
        tumbling += u32::from(f.tumbles);
        if f.half_turns > 0.5 {
            turning += 1;
            row.half_turns += f.half_turns;
        }
    }
    let n = f64::from(falls.max(1));
    row.descent /= n;
    row.along /= n;
    row.scatter = (square / n).sqrt();
    row.half_turns /= f64::from(turning.max(1));
    row.tumbling = f64::from(tumbling) / n;
    row
}
