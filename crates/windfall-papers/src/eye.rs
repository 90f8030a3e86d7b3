//! From which distance on a leaf is small enough for two triangles.

use glam::Vec3;
use windfall_gpu::internals::shared::TreeList;

/// Distance travelled after which the count restarts, metres: keeps the sum precise.
const LONGEST_TRAVEL: f32 = 1000.0;

/// The eye of the view, and how far it has travelled.
///
/// The [`margin`](Eye::margin) of a leaf at rest changes by no more than the eye moves: the leaf is not looked at again until the
/// eye has travelled as far as the margin.
pub struct Eye {
    at: Vec3,
    /// Distance at which a leaf one metre long may be drawn in two triangles, metres; infinite where none may.
    per_metre: f32,
    /// Distance travelled, metres.
    pub travelled: f32,
}

impl Eye {
    /// Before the first view.
    pub fn new() -> Self {
        Self { at: Vec3::ZERO, per_metre: f32::INFINITY, travelled: f32::INFINITY }
    }

    /// Moves to the eye of a view. Returns whether earlier margins are void.
    pub fn follow(&mut self, view: &TreeList) -> bool {
        let per_metre = view.pixels / view.leaf_pixels;
        let travelled = self.travelled + self.at.distance(view.eye);
        // Not so for a distance that is not a number.
        let valid = per_metre == self.per_metre && travelled < LONGEST_TRAVEL;
        let travelled = if valid { travelled } else { 0.0 };
        *self = Self { at: view.eye, per_metre, travelled };
        !valid
    }

    /// How much nearer the eye may come before a leaf, `length` metres long, needs its full shape, metres: negative if
    /// it is too near.
    pub fn margin(&self, length: f32, leaf: Vec3) -> f32 {
        self.at.distance(leaf) - length * self.per_metre
    }

    /// The same for a leaf somewhere within `reach` metres of the line from `from` to `to`.
    pub fn margin_of_segment(&self, length: f32, (from, to): (Vec3, Vec3), reach: f32) -> f32 {
        distance_to_segment(self.at, from, to) - reach - length * self.per_metre
    }
}

/// Distance of a point from the line segment between two others.
pub fn distance_to_segment(point: Vec3, from: Vec3, to: Vec3) -> f32 {
    let along = to - from;
    let t = (point - from).dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
    point.distance(from + along * t.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn distances_from_a_segment_end_with_it() {
        let (a, b) = (Vec3::ZERO, Vec3::new(0.0, 4.0, 0.0));
        assert_eq!(distance_to_segment(Vec3::new(3.0, 2.0, 0.0), a, b), 3.0);
        assert_eq!(distance_to_segment(Vec3::new(3.0, 8.0, 0.0), a, b), 5.0);
        assert_eq!(distance_to_segment(Vec3::new(0.0, -2.0, 0.0), a, b), 2.0);
        assert_eq!(distance_to_segment(Vec3::new(3.0, 4.0, 0.0), a, a), 5.0);
    }

    #[test]
    fn a_margin_is_the_distance_to_the_first_leaf_that_is_too_long() {
        let list = |eye, pixels| TreeList { eye, pixels, leaf_pixels: 10.0, ..TreeList::zeroed() };
        let mut eye = Eye::new();
        assert!(eye.follow(&list(Vec3::new(0.0, 0.0, 50.0), 500.0)), "there was no view");
        let place = Vec3::new(0.0, 0.0, 40.0);
        // 0.1 m are 10 pixels at 5 m.
        assert_eq!(eye.margin_of_segment(0.1, (place, place), 1.0), 50.0 - 40.0 - 1.0 - 5.0);
        assert!(!eye.follow(&list(Vec3::new(0.0, 0.0, 47.0), 500.0)));
        assert_eq!(eye.travelled, 3.0);
        assert_eq!(eye.margin(0.1, place), 2.0);
        assert!(eye.follow(&list(Vec3::new(0.0, 0.0, 47.0), 600.0)), "zoomed");
        assert!(eye.follow(&TreeList { leaf_pixels: 0.0, ..list(Vec3::ZERO, 600.0) }));
        assert_eq!(eye.margin(0.1, place), f32::NEG_INFINITY);
    }
}
