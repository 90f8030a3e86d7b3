//! Shadow maps that are drawn in turns: one that is not drawn in a frame is the one of its last turn.

use crate::view::camera::Eye;
use crate::view::cascades::{CASCADES, Cascade, cascades};
use glam::{DVec3, Vec3};
use windfall_core::simplify::Simplification;

/// How much farther than the view maps reach that are kept for some frames.
const MARGIN: f32 = 1.25;
/// How far the sun may turn before all maps are drawn anew: the cosine of a tenth of a degree.
const SUN_TURN: f32 = 0.999_998_5;
/// How far the clock may jump, seconds.
const JUMP: f64 = 0.5;

/// What a map shows beside the place that it covers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shown {
    /// The forest's structure.
    pub structure: u64,
    /// What maps are relative to.
    pub origin: DVec3,
    /// How the trees in it are simplified.
    pub detail: Simplification,
    /// Texels along a side.
    pub size: u32,
}

/// A map and when it was drawn.
#[derive(Clone, Copy)]
struct Drawn {
    cascade: Cascade,
    sun: Vec3,
    time: f64,
    frame: u64,
    shown: Shown,
}

/// The maps of a view as they are in their textures.
#[derive(Default)]
pub struct ShadowTurns {
    frame: u64,
    drawn: [Option<Drawn>; CASCADES],
}

impl ShadowTurns {
    /// The cascades of a frame, and which of them are to be drawn. In `period` frames each is drawn at least once: the
    /// nearest four times as often as the farthest.
    pub fn next(
        &mut self,
        eye: &Eye,
        (sun, time): (Vec3, f64),
        period: u32,
        shown: Shown,
    ) -> ([Cascade; CASCADES], [bool; CASCADES]) {
        let margin = if period > 1 { MARGIN } else { 1.0 };
        let fresh = cascades(eye, sun, shown.size, margin);
        let needed = cascades(eye, sun, shown.size, 1.0);
        self.frame += 1;
        let mut draw = [true; CASCADES];
        for (i, slot) in self.drawn.iter_mut().enumerate() {
            let every = u64::from(period >> (CASCADES - 1 - i)).max(1);
            let keeps = |drawn: &Drawn| {
                // Frames of one row have their turns one after the other.
                let turn = (self.frame + i as u64).is_multiple_of(every);
                !turn
                    && self.frame - drawn.frame < every
                    && drawn.shown == shown
                    && drawn.sun.dot(sun) > SUN_TURN
                    && (drawn.time - time).abs() < JUMP
                    && drawn.cascade.holds(&needed[i])
            };
            draw[i] = !slot.as_ref().is_some_and(keeps);
            if draw[i] {
                let frame = self.frame;
                *slot = Some(Drawn { cascade: fresh[i], sun, time, frame, shown });
            }
        }
        let kept = std::array::from_fn(|i| self.drawn[i].map_or(fresh[i], |drawn| drawn.cascade));
        (kept, draw)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::camera::Camera;

    const SHOWN: Shown =
        Shown { structure: 1, origin: DVec3::ZERO, detail: Simplification::DEFAULT, size: 1024 };
    const SUN: Vec3 = Vec3::new(0.6, 0.8, 0.0);

    fn eye(x: f64) -> Eye {
        let at = DVec3::new(x, 1.7, 0.0);
        Camera::look_at(at, at - DVec3::Z, 0.9, 0.1).eye(DVec3::ZERO, (160, 90)).unwrap()
    }

    #[test]
    fn each_map_has_its_turn_and_few_have_it_at_once() {
        let mut turns = ShadowTurns::default();
        let mut count = [0; CASCADES];
        for frame in 0..33 {
            let (_, draw) = turns.next(&eye(0.0), (SUN, 0.01 * f64::from(frame)), 8, SHOWN);
            if frame == 0 {
                assert_eq!(draw, [true; CASCADES]);
                continue;
            }
            assert!(draw.iter().filter(|d| **d).count() <= 2, "{frame}: {draw:?}");
            for (count, draw) in count.iter_mut().zip(draw) {
                *count += u32::from(draw);
            }
        }
        assert_eq!(count, [16, 8, 4]);
    }

    #[test]
    fn with_a_period_of_one_all_are_drawn_where_the_view_asks_for_them() {
        let mut turns = ShadowTurns::default();
        for x in [0.0, 0.3, 0.3] {
            let (maps, draw) = turns.next(&eye(x), (SUN, 0.0), 1, SHOWN);
            assert_eq!(draw, [true; CASCADES]);
            let wanted = cascades(&eye(x), SUN, 1024, 1.0);
            assert!(maps.iter().zip(&wanted).all(|(a, b)| a.clip_from_world == b.clip_from_world));
        }
    }

    #[test]
    fn what_a_map_does_not_show_is_drawn_anew_at_once() {
        let changed = |sun: Vec3, time: f64, x: f64, shown: Shown| {
            let mut turns = ShadowTurns::default();
            turns.next(&eye(0.0), (SUN, 0.0), 64, SHOWN);
            turns.next(&eye(x), (sun, time), 64, shown).1
        };
        assert_eq!(changed(SUN, 0.01, 0.0, SHOWN), [false; CASCADES]);
        let sun = Vec3::new(0.6, 0.79, 0.01).normalize_or_zero();
        assert_eq!(changed(sun, 0.01, 0.0, SHOWN), [true; CASCADES]);
        assert_eq!(changed(SUN, 9.0, 0.0, SHOWN), [true; CASCADES]);
        for shown in [Shown { structure: 2, ..SHOWN }, Shown { size: 512, ..SHOWN }] {
            assert_eq!(changed(SUN, 0.01, 0.0, shown), [true; CASCADES]);
        }
        // A walk soon leaves the nearest map, and not the others.
        assert_eq!(changed(SUN, 0.01, 0.1, SHOWN), [false; CASCADES]);
        assert_eq!(changed(SUN, 0.01, 4.0, SHOWN), [true, false, false]);
    }
}
