//! The level of detail of one tree: equations 1 to 6.

use super::{FadeRange, Reduction, Simplification};
use crate::foliage::Visibility;
use crate::material::Holes;

/// Samples of a pixel that leaves are drawn with.
const SAMPLES: f32 = 4.0;

/// How a tree is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level {
    /// Share of the leaves that the tree is drawn with, above 0, at most 1.
    pub lambda: f32,
    /// Half the range of ranks over which leaves fade.
    pub radius: f32,
    /// Factor on a leaf's length, at least 1: `√s`.
    pub growth: f32,
    /// `α`, what is left of the contrast between leaves: [`contrast`].
    pub contrast: f32,
}

impl Level {
    /// A tree in full.
    pub const FULL: Self = Self { lambda: 1.0, radius: 0.0, growth: 1.0, contrast: 1.0 };
}

/// A tree as a camera sees it: what its level of detail depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// From the camera to the tree's centre, metres.
    pub distance: f32,
    /// Pixels that a metre covers at a distance of one metre.
    pub pixels: f32,
    /// Radius of the tree's bounding sphere, metres.
    pub radius: f32,
    /// Mean length of a leaf of the tree, metres.
    pub leaf_length: f32,
    /// Lengths of its shortest and its longest leaf, metres.
    pub leaf_lengths: [f32; 2],
    /// Side of a square with a leaf's mean projected area, metres ([`Foliage::leaf_side`]).
    ///
    /// [`Foliage::leaf_side`]: crate::foliage::Foliage::leaf_side
    pub leaf_side: f32,
    /// The holes in it.
    pub holes: Holes,
    /// Visibility of its leaves.
    pub visibility: Visibility,
}

impl Simplification {
    /// The share of its size at which a tree is seen, at most 1.
    pub fn reduced_area(&self, seen: &Seen) -> f32 {
        let distance = seen.distance.max(1e-3);
        let b = match self.reduction {
            Reduction::Distance { d0 } => (d0 / distance).powi(2),
            Reduction::ProjectedArea { b0 } => {
                std::f32::consts::PI * (seen.radius * seen.pixels / distance).powi(2) / b0
            }
        };
        b.min(1.0)
    }

    /// `log_h ½`, the exponent of equation 2: 0 for `h = 0`.
    pub fn exponent(&self) -> f32 {
        if self.h <= 0.0 { 0.0 } else { 0.5f32.ln() / self.h.min(0.999).ln() }
    }

    /// How a tree is drawn that is seen so.
    pub fn level(&self, seen: &Seen) -> Level {
        let wanted = self.reduced_area(seen).powf(self.exponent());
        if wanted >= 1.0 {
            return Level::FULL;
        }
        let mut lambda = wanted;
        let mut growth = 1.0;
        if self.area_preservation {
            let size = seen.leaf_length * seen.pixels / seen.distance.max(1e-3);
            let most = self.growth.factor.max(self.growth.pixels / size.max(1e-9)).max(1.0);
            if seen.visibility.area_scale(wanted) > most * most {
                lambda = wanted.max(seen.visibility.share_for(most * most)).min(1.0);
            }
            growth = seen.visibility.area_scale(lambda).sqrt().min(most);
        }
        let contrast = self.contrast_pixels.map_or(lambda.sqrt(), |pixels| {
            let side = seen.leaf_side * seen.pixels / seen.distance.max(1e-3);
            contrast(lambda, side / pixels, seen.holes, SAMPLES * pixels * pixels)
        });
        Level { lambda, radius: self.radius(lambda), growth, contrast }
    }

    /// How far the wood of a tree that is seen so may be from its place, metres.
    pub fn wood_error(&self, seen: &Seen) -> f32 {
        self.wood_pixels * seen.distance / seen.pixels
    }

    /// Bounds of the lengths in the picture of the leaves of a tree that is seen so, pixels: of the shortest at its
    /// far side, 0 while it fades, and of the longest at its near side.
    pub fn leaf_range(&self, level: &Level, seen: &Seen) -> [f32; 2] {
        let far = seen.distance + seen.radius;
        let near = (seen.distance - seen.radius).max(1e-3);
        let pixels = level.growth * seen.pixels;
        let shortest = if level.lambda < 1.0 { 0.0 } else { seen.leaf_lengths[0] };
        [shortest * pixels / far.max(1e-3), seen.leaf_lengths[1] * pixels / near]
    }

    /// `R` for a level of detail.
    pub fn radius(&self, lambda: f32) -> f32 {
        let radius = match self.fade.range {
            FadeRange::Constant(c) => c,
            FadeRange::Linear(c) => c * (1.0 - lambda),
            FadeRange::Quadratic(c) => c * (1.0 - lambda) * (1.0 - lambda),
            FadeRange::Proportional(c) => c * lambda,
        };
        if self.fade.full_at_one { radius.min(1.0 - lambda) } else { radius }
    }

    /// Share of the leaves that are drawn at all, at most 1: those that are partly faded included.
    pub fn drawn(&self, level: &Level) -> f32 {
        let beyond = if self.fade.early { 0.0 } else { level.radius };
        (level.lambda + beyond).min(1.0)
    }

    /// How much of a leaf is seen, `0..=1`, by its rank, `0..1` (SFS, equation 6).
    pub fn visible(&self, level: &Level, rank: f32) -> f32 {
        let last = level.lambda + if self.fade.early { 0.0 } else { level.radius };
        let f = if level.radius > 0.0 {
            ((last - rank) / (2.0 * level.radius)).clamp(0.0, 1.0)
        } else if rank < last {
            1.0
        } else {
            0.0
        };
        if self.fade.smooth { f * f * (3.0 - 2.0 * f) } else { f }
    }
}

/// `α` of equation 4, `0..=1`: what is left of the contrast between leaves of which the share `lambda` is
/// drawn, and each of the whole tree's shows in the mean as much as a square of `side` pixels.
///
/// SFS takes `√λ`: the mean over a pixel of a share `λ` of the leaves, each with an area of `1/λ` times its own,
/// has `1/λ` times the variance. So it is of leaves that are much smaller than a pixel. Of those that are as
/// large, a pixel has few before and after: their contrast stays. Between, it is the root of what a pixel's mean
/// leaves of the variance ([`variance_left`]) before over what it leaves after.
///
/// Through holes in cards other cards are seen: their contrast is that of the pieces between, but for the share of
/// a card that is there, which is of one card all over.
///
/// A pixel of few `samples` leaves more of it than its mean would. A whole tree is drawn with that noise; the
/// farther a tree is simplified, the more of it is taken off as well. Not of what has holes: pictures are filtered,
/// and whole trees of such cards have no more variance than with many samples.
pub fn contrast(lambda: f32, side: f32, holes: Holes, samples: f32) -> f32 {
    let variance = |side: f32| {
        let piece = variance_left((side * holes.piece).max(1e-3));
        piece + holes.solid * (variance_left(side.max(1e-3)) - piece)
    };
    let left = variance(side / lambda.sqrt());
    let noise = holes.solid * (1.0 - left) * (1.0 - lambda) / samples;
    (variance(side) / (left + noise)).sqrt()
}

/// What is left of a variance between leaves in the means over pixels, `0..=1`, where leaves are squares of
/// `side` pixels.
///
/// Two points have the same leaf with a probability that falls to 0 over the side, along and across alike; it is
/// the mean of that over all pairs of points in a pixel.
pub fn variance_left(side: f32) -> f32 {
    let along = if side < 1.0 { side * (1.0 - side / 3.0) } else { 1.0 - 1.0 / (3.0 * side) };
    along * along
}

#[cfg(test)]
mod tests {
    use super::super::{Fade, Growth};
    use super::*;

    fn seen(distance: f32) -> Seen {
        let visibility = Visibility { share: 1e-4, ..Visibility::default() };
        Seen {
            distance,
            pixels: 600.0,
            radius: 5.0,
            leaf_length: 0.08,
            leaf_lengths: [0.04, 0.1],
            leaf_side: 0.03,
            holes: Holes::NONE,
            visibility,
        }
    }

    fn paper(h: f32) -> Simplification {
        Simplification {
            reduction: Reduction::Distance { d0: 20.0 },
            h,
            growth: Growth::UNBOUNDED,
            ..Simplification::default()
        }
    }

    #[test]
    fn h_is_the_reduction_at_which_half_of_the_leaves_are_drawn() {
        for h in [0.2, 0.5, 0.7, 0.9] {
            // b = (20/d)² = h.
            let level = paper(h).level(&seen(20.0 / h.sqrt()));
            assert!((level.lambda - 0.5).abs() < 1e-4, "{h}: {level:?}");
        }
    }

    #[test]
    fn the_lengths_of_leaves_are_bounded_by_the_crown() {
        // 600 pixels a metre at one metre, a crown of 5 m, leaves of 4 to 10 cm.
        let full = Simplification { h: 0.0, ..Simplification::default() };
        let [low, high] = full.leaf_range(&Level::FULL, &seen(15.0));
        assert!((low - 0.04 * 600.0 / 20.0).abs() < 1e-4 && (high - 6.0).abs() < 1e-4);
        // Grown by half; some that fade are as small as they like.
        let grown = Level { lambda: 0.5, growth: 1.5, ..Level::FULL };
        let [low, high] = full.leaf_range(&grown, &seen(15.0));
        assert!(low == 0.0 && (high - 9.0).abs() < 1e-4);
        assert!(full.leaf_range(&Level::FULL, &seen(1.0))[1] > 1e4);
    }

    #[test]
    fn nothing_is_simplified_within_d0_nor_at_h_0() {
        assert_eq!(paper(0.7).level(&seen(20.0)), Level::FULL);
        assert_eq!(paper(0.7).level(&seen(0.0)), Level::FULL);
        assert_eq!(paper(0.0).level(&seen(1e5)), Level::FULL);
        assert!(paper(0.7).level(&seen(20.01)).lambda < 1.0);
    }

    #[test]
    fn a_half_gives_the_reduction_itself() {
        let level = paper(0.5).level(&seen(80.0));
        assert!((level.lambda - 1.0 / 16.0).abs() < 1e-6, "{level:?}");
    }

    #[test]
    fn contrast_goes_with_what_a_pixel_averages() {
        // Leaves much smaller than a pixel: that of SFS. As large as several: all of it.
        for lambda in [0.5, 0.06, 0.01] {
            assert!((contrast(lambda, 1e-3, Holes::NONE, 1e9) / lambda.sqrt() - 1.0).abs() < 0.01);
            assert!(contrast(lambda, 20.0, Holes::NONE, 4.0) > 0.97);
        }
        assert_eq!(contrast(1.0, 0.3, Holes::NONE, 4.0), 1.0);
        // Leaves of 0.225 pixels, then of 0.9: 0.0433 of the variance is left, then 0.3969, and in the mean of four
        // samples 0.5383. In squares of 2 by 2 pixels 0.0117, then 0.1463, of sixteen samples 0.1963.
        let of = |contrast_pixels| {
            Simplification { contrast_pixels, ..paper(0.5) }.level(&seen(80.0)).contrast
        };
        assert!((contrast(1.0 / 16.0, 0.225, Holes::NONE, 1e9) - 0.3303).abs() < 1e-3);
        assert!((of(None) - 0.25).abs() < 1e-6);
        assert!((of(Some(1.0)) - 0.2837).abs() < 1e-3);
        assert!((of(Some(2.0)) - 0.2443).abs() < 1e-3, "{}", of(Some(2.0)));

        // Cards of 8 pixels of which half is there, in pieces of 0.4: 0.9184 and 0.1202, then 0.9793 and 0.6267.
        let holes = Holes { solid: 0.5, piece: 0.05 };
        assert!((contrast(1.0 / 16.0, 8.0, holes, 1e9) - 0.8042).abs() < 1e-3);
        // 0.8030 of it is left, and half of the noise of four samples.
        assert!((contrast(1.0 / 16.0, 8.0, holes, 4.0) - 0.7929).abs() < 1e-3);
        let whole = Holes { solid: 1.0, ..holes };
        assert_eq!(contrast(0.1, 3.0, whole, 4.0), contrast(0.1, 3.0, Holes::NONE, 4.0));

        // Squares of chance values, one beside the other, anywhere over a pixel of 60 points a side.
        for side in [0.2f32, 0.7, 1.0, 2.5] {
            let (mut sum, mut squares, rounds) = (0.0, 0.0, 3000);
            for round in 0..rounds {
                let draw = |i: u32| crate::rng::unit(crate::rng::hash(round, i));
                let start = [draw(0), draw(1)].map(|u| u * side);
                let cell = |i: u32, start: f32| ((start + (i as f32 + 0.5) / 60.0) / side) as u32;
                let value =
                    |x: u32, y: u32| draw(2 + 64 * cell(x, start[0]) + cell(y, start[1])) - 0.5;
                let all: f32 = (0..3600).map(|i| value(i % 60, i / 60)).sum();
                sum += all / 3600.0;
                squares += (all / 3600.0).powi(2);
            }
            let rounds = rounds as f32;
            let variance = 12.0 * (squares / rounds - (sum / rounds).powi(2));
            assert!((variance / variance_left(side) - 1.0).abs() < 0.1, "{side}: {variance}");
        }
    }

    #[test]
    fn growth_is_bounded_by_drawing_more_leaves() {
        let mut s = Simplification { growth: Growth { factor: 2.0, pixels: 4.0 }, ..paper(0.5) };
        // At 80 m a leaf of 8 cm is 0.6 pixels: it may grow to four, and needs a factor of 4 only.
        let far = s.level(&seen(80.0));
        assert!((far.lambda - 1.0 / 16.0).abs() < 1e-6 && far.growth > 3.9, "{far:?}");
        // At full detail up to 1 m, a leaf at 10 m is 4.8 pixels: it may grow by 2.
        s.reduction = Reduction::Distance { d0: 1.0 };
        let near = s.level(&seen(10.0));
        assert!((near.growth - 2.0).abs() < 1e-3 && near.lambda > 0.2, "{near:?}");
    }

    #[test]
    fn the_sum_of_what_is_seen_is_lambda() {
        let n = 10_000;
        let ranges = [
            FadeRange::Constant(0.1),
            FadeRange::Linear(0.1),
            FadeRange::Quadratic(0.1),
            FadeRange::Proportional(0.3),
        ];
        for range in ranges {
            for smooth in [false, true] {
                let fade = Fade { range, smooth, ..Fade::default() };
                let s = Simplification { fade, ..paper(0.5) };
                // From b = 1/4 on, no range is cut off at either end.
                for distance in [25.0, 30.0, 40.0] {
                    let level = s.level(&seen(distance));
                    let sum: f32 = (0..n).map(|i| s.visible(&level, i as f32 / n as f32)).sum();
                    let share = sum / n as f32;
                    assert!((share - level.lambda).abs() < 2e-3, "{fade:?} {level:?}: {share}");
                    let beyond = s.drawn(&level) + 1e-6;
                    assert_eq!(s.visible(&level, beyond), 0.0);
                }
            }
        }
        let full = Simplification::default().visible(&Level::FULL, 0.999_999);
        assert_eq!(full, 1.0);
    }

    #[test]
    fn early_fades_are_gone_at_lambda() {
        let fade = Fade { early: true, ..Fade::default() };
        let s = Simplification { fade, ..paper(0.5) };
        let level = s.level(&seen(40.0));
        assert_eq!(s.visible(&level, level.lambda), 0.0);
        assert_eq!(s.drawn(&level), level.lambda);
        assert!(s.visible(&level, level.lambda - 2.0 * level.radius) >= 1.0 - 1e-5);
    }
}
