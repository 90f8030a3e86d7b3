//! What sets one leaf's fall apart from another's on the same path (VB 4.1).

use super::{LeafFall, PathSet};
use crate::rng::{hash, unit};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;
use std::ops::Range;

/// How falls on the same paths differ.
#[derive(Debug, Clone, PartialEq)]
pub enum Variation {
    /// VB's own formulas of the leaf's position. Kept to reproduce
    /// the papers; they have defects: a scale is 0 at some positions and up to 3 at others, leaves on a
    /// plane `x = 0` all fall alike, and neighbours fall nearly alike.
    Paper(Edition),
    /// From the leaf's hash; none of those defects.
    Hashed(Hashed),
}

/// The text whose formulas [`Variation::Paper`] takes: rotation about Y in degrees, scales of X and Z, starting point.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Edition {
    /// VB 2007: `mod(x*y*z*17, 360)`, `mod(z*y*3, 3)` and `mod(x*y*3, 3)`, `mod(y*x*317, starts - 1)`.
    Of2007,
    /// VB 2008: `mod(x*y*z*37, 360)`, `mod(z*y, 3)` and `mod(x*y, 3)`, `mod(y*x*37, starts - 1)`. The default.
    #[default]
    Of2008,
}

impl Edition {
    /// The factors of rotation, scale and starting point under the `mod`.
    pub const fn factors(self) -> [f32; 3] {
        match self {
            Self::Of2007 => [17.0, 3.0, 317.0],
            Self::Of2008 => [37.0, 1.0, 37.0],
        }
    }
}

impl Default for Variation {
    fn default() -> Self {
        Self::Hashed(Hashed::default())
    }
}

/// Bounds of [`Variation::Hashed`]. The turn about Y is one of 256 over the circle, scale and rate one
/// of 32 each; the flight (path, starting point and joint) is uniform among those of the leaf's group.
#[derive(Debug, Clone, PartialEq)]
pub struct Hashed {
    /// Factor on horizontal displacements. Safe: `0.7..1.3`, the default.
    pub scale: Range<f32>,
    /// Playback rate. Safe: `0.95..1.05`, the default.
    pub rate: Range<f32>,
}

impl Default for Hashed {
    fn default() -> Self {
        Self { scale: 0.7..1.3, rate: 0.95..1.05 }
    }
}

/// One leaf's share of variety: constant over its whole fall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variant {
    /// Index into [`super::PathTables::paths`].
    pub path: u32,
    /// Index into [`super::PathTables::joints`].
    pub joint: u32,
    /// Sample at which the fall begins.
    pub start: u32,
    /// Turn of the whole fall about Y, radians.
    pub yaw: f32,
    /// Factors on the path's X and Z displacements, before the turn.
    pub scale: Vec2,
    /// Playback rate; 1 is as recorded.
    pub rate: f32,
    /// All of it in one number: from the lowest bit 14 bits of the flight
    /// ([`super::PathTables::flights`]), 8 of the turn, 5 of the scale, 5 of the rate. The paper's
    /// variation has only the flight here; the rest follows from the leaf's place.
    pub word: u32,
}

/// What a draw of a leaf's hash decides: its counter.
mod draw {
    pub const FLIGHT: u32 = 1;
    pub const REST: u32 = 2;
    pub const HEADING: u32 = 7;
}

/// A number in `0..n` from a number in `[0, 1)`.
fn pick(unit: f32, n: u32) -> u32 {
    ((unit * n as f32) as u32).min(n.saturating_sub(1))
}

/// GLSL's `mod`: never negative for positive `b`.
fn glsl_mod(a: f32, b: f32) -> f32 {
    a - b * (a / b).floor()
}

impl Variation {
    /// The variant of a leaf. A `group` that does not exist is taken as the first.
    pub fn of(&self, leaf: &LeafFall, paths: &PathSet) -> Variant {
        let tables = paths.tables();
        let flights = tables.group_flights.get(leaf.group as usize);
        let flights = flights.unwrap_or(&tables.group_flights[0]);
        match self {
            Self::Paper(edition) => {
                let [turn, size, first] = edition.factors();
                let Vec3 { x, y, z } = leaf.origin;
                let starts = (flights.plain.max(2) - 1) as f32;
                let start =
                    pick(glsl_mod(y * x * first, starts) / starts, flights.plain.max(2) - 1);
                let word = flights.first + start.min(flights.plain - 1);
                let flight = tables.flights[word as usize];
                Variant {
                    path: flight.path,
                    joint: flight.joint,
                    start: flight.start,
                    yaw: glsl_mod(x * y * z * turn, 360.0).to_radians(),
                    scale: Vec2::new(glsl_mod(z * y * size, 3.0), glsl_mod(x * y * size, 3.0)),
                    rate: 1.0,
                    word,
                }
            }
            Self::Hashed(bounds) => {
                let u = unit(hash(leaf.seed, draw::FLIGHT));
                let index = flights.first + pick(u, flights.count);
                let flight = tables.flights[index as usize];
                let word = index | hash(leaf.seed, draw::REST) << 14;
                let step = |low: u32, r: &Range<f32>| {
                    r.start + (r.end - r.start) * ((word >> low & 31) as f32 + 0.5) / 32.0
                };
                Variant {
                    path: flight.path,
                    joint: flight.joint,
                    start: flight.start,
                    yaw: (word >> 14 & 255) as f32 * (TAU / 256.0),
                    scale: Vec2::splat(step(22, &bounds.scale)),
                    rate: step(27, &bounds.rate),
                    word,
                }
            }
        }
    }

    /// Heading of the landed leaf against the one it arrived with, in `-1..1`.
    pub(crate) fn heading(leaf: &LeafFall) -> f32 {
        unit(hash(leaf.seed, draw::HEADING)) * 2.0 - 1.0
    }
}
