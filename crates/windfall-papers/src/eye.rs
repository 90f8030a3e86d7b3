//! From how far away a leaf is so small that two triangles may stand for it.

use crate::shared::{Crown, Stream, TreeList};
use glam::Vec3;

/// Metres after which the way is counted anew: the sum stays precise.
const LONG_WAY: f32 = 1000.0;

/// The eye of the view, and how far it has gone.
///
/// A leaf's [`margin`](Eye::margin) changes by no more than the eye moves: until the eye has gone as far as
/// the margin is wide, the leaf need not be looked at again.
pub(crate) struct Eye {
    at: Vec3,
    /// Distance at which a leaf one metre long is as long as one in two triangles may be, metres; infinite
    /// where all leaves have their outlines.
    per_metre: f32,
    /// How far it has gone, metres.
    pub gone: f32,
}

impl Eye {
    /// One that knows of no view yet.
    pub fn new() -> Self {
        Self { at: Vec3::ZERO, per_metre: f32::INFINITY, gone: f32::INFINITY }
    }

    /// Goes to where the view has it. Returns whether margins from before mean nothing now.
    pub fn follow(&mut self, view: &TreeList) -> bool {
        let per_metre = view.pixels / view.leaf_pixels;
        let gone = self.gone + self.at.distance(view.eye);
        let anew = per_metre != self.per_metre || gone >= LONG_WAY;
        *self = Self { at: view.eye, per_metre, gone: if anew { 0.0 } else { gone } };
        anew
    }

    /// How much nearer the eye may come before a leaf has to be drawn with its outline, metres: negative
    /// where it is too near. The leaf, of this length in metres, is somewhere about the line from `from` to
    /// `to`, no farther from it than `reach` metres.
    pub fn margin(&self, length: f32, (from, to): (Vec3, Vec3), reach: f32) -> f32 {
        from_segment(self.at, from, to) - reach - length * self.per_metre
    }

    /// The same of the leaves on the tree of a stream.
    pub fn margin_of_tree(&self, stream: &Stream, crown: &Crown) -> f32 {
        let near = (crown.radius + crown.leaf_length * self.per_metre) * stream.scale;
        self.at.distance(stream.place(crown.center)) - near
    }
}

/// Distance of a point from the line between two others.
pub(crate) fn from_segment(point: Vec3, from: Vec3, to: Vec3) -> f32 {
    let along = to - from;
    let t = (point - from).dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
    point.distance(from + along * t.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn distances_from_a_line_end_with_it() {
        let (a, b) = (Vec3::ZERO, Vec3::new(0.0, 4.0, 0.0));
        assert_eq!(from_segment(Vec3::new(3.0, 2.0, 0.0), a, b), 3.0);
        assert_eq!(from_segment(Vec3::new(3.0, 8.0, 0.0), a, b), 5.0);
        assert_eq!(from_segment(Vec3::new(0.0, -2.0, 0.0), a, b), 2.0);
        assert_eq!(from_segment(Vec3::new(3.0, 4.0, 0.0), a, a), 5.0);
    }

    #[test]
    fn a_margin_is_the_way_to_the_first_leaf_that_is_too_long() {
        let list = |eye, pixels| TreeList { eye, pixels, leaf_pixels: 10.0, ..TreeList::zeroed() };
        let mut eye = Eye::new();
        assert!(eye.follow(&list(Vec3::new(0.0, 0.0, 50.0), 500.0)), "nothing is known");
        let stream = Stream { scale: 2.0, cos_yaw: 1.0, ..Stream::zeroed() };
        let crown = Crown { radius: 3.0, leaf_length: 0.1, ..Crown::zeroed() };
        let place = Vec3::new(0.0, 0.0, 40.0);
        // 0.1 m are 10 pixels at 5 m.
        assert_eq!(eye.margin(0.1, (place, place), 1.0), 50.0 - 40.0 - 1.0 - 5.0);
        // Those on the tree are twice as long, the nearest of them 6 m from its middle.
        assert_eq!(eye.margin_of_tree(&stream, &crown), 50.0 - 6.0 - 10.0);
        assert!(!eye.follow(&list(Vec3::new(0.0, 0.0, 47.0), 500.0)));
        assert_eq!(eye.gone, 3.0);
        assert_eq!(eye.margin(0.1, (place, place), 1.0), 1.0);
        assert!(eye.follow(&list(Vec3::new(0.0, 0.0, 47.0), 600.0)), "zoomed");
        assert!(eye.follow(&TreeList { leaf_pixels: 0.0, ..list(Vec3::ZERO, 600.0) }));
        assert_eq!(eye.margin(0.1, (place, place), 1.0), f32::NEG_INFINITY);
    }
}
