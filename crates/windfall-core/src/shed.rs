//! When leaves detach: a closed form of shed rank, tree and season.
//!
//! The leaves of a tree fall in shed order. A leaf's *fraction* is its shed rank, plus a random part
//! of one, over the tree's leaves; its detach time is a rising function of that. So the leaves that
//! have fallen by a time are a prefix of the shed order, found by bisection, and any moment can be
//! asked for without those before it.
//!
//! Times of the clock are `f64`. Single precision sees only what the shaders compute: seconds after
//! [`Shedding::start`], which are as precise after ten days as after ten seconds.

use crate::forest::Instance;
use crate::rng::{hash, unit};
use crate::wind::Wind;
use glam::Vec3Swizzles;
use std::f32::consts::TAU;

/// How a forest sheds its leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shedding {
    /// When the first leaf of a tree without season offset detaches, seconds of the clock.
    pub start: f64,
    /// Time from a tree's first leaf to its last, seconds, above 0.
    pub duration: f32,
    /// How much leaves gather in the middle of that time: 0 is even, at most [`Shedding::MOST`].
    pub peak: f32,
    /// Seconds by which a tree of season offset 1 is early.
    pub tree_spread: f32,
    /// How much leaves gather in gusts: 0 is not at all, at most [`Shedding::MOST`].
    pub burst: f32,
}

/// What a tree's detach times depend on beside [`Shedding`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TreeShedding {
    /// Seconds by which the tree is late.
    pub delay: f32,
    /// Phase of the strongest gust at the tree at [`Shedding::start`], `[0, 1)` turns, a quarter ahead.
    pub gust_phase: f32,
    /// Key of the tree.
    pub seed: u32,
    /// Leaves of the tree.
    pub leaves: u32,
}

impl Default for Shedding {
    /// Leaves fall for ten minutes from 30 s before the scene begins, so that some are in the air at
    /// once.
    fn default() -> Self {
        Self { start: -30.0, duration: 600.0, peak: 0.3, tree_spread: 120.0, burst: 0.6 }
    }
}

impl Shedding {
    /// Largest `peak` and `burst`: above, times would no longer rise with the rank.
    pub const MOST: f32 = 0.95;

    /// No leaf ever falls: the shedding starts in 10³⁷ seconds, a number that `f32` can hold as well.
    pub fn never() -> Self {
        Self { start: f64::from(f32::MAX / 4.0), ..Self::default() }
    }

    /// A tree's part in it. Gusts that cross the forest shake the tree when they are there.
    pub fn tree(&self, instance: &Instance, leaves: u32, wind: &Wind) -> TreeShedding {
        let gust = &wind.gusts[0];
        let late = wind.travel.dot(instance.position.xz()) * wind.slowness;
        let phase = gust.phase - gust.cycles as f32 * late / Wind::PERIOD as f32 + 0.25;
        // Turns up to the start, of which whole ones do not count: in double precision, or they would cost the
        // digits that tell where in the gust the shedding starts.
        let turns = f64::from(gust.cycles) * self.start.rem_euclid(Wind::PERIOD) / Wind::PERIOD;
        let phase = phase + turns.fract() as f32;
        TreeShedding {
            delay: -instance.season_offset * self.tree_spread,
            gust_phase: phase - phase.floor(),
            seed: instance.seed,
            leaves,
        }
    }

    /// Gusts per second that [`Shedding::burst`] follows.
    pub fn gust_rate(wind: &Wind) -> f32 {
        wind.gusts[0].cycles as f32 / Wind::PERIOD as f32
    }

    /// Seconds after [`Shedding::start`] at which the leaf of shed rank `rank` detaches: what the shaders compute.
    /// Rises with the rank; below 0 for the first leaves of an early tree.
    pub fn detach_after_start(&self, tree: &TreeShedding, gust_rate: f32, rank: u32) -> f32 {
        let jitter = unit(hash(tree.seed ^ JITTER, rank));
        let x = (rank as f32 + jitter) / tree.leaves.max(1) as f32;
        let eased = x + self.peak / TAU * (TAU * x).sin();
        let even = tree.delay + self.duration * eased;
        let turns = gust_rate * even + tree.gust_phase;
        even + self.burst / (TAU * gust_rate) * (TAU * (turns - turns.floor())).sin()
    }

    /// Time of the clock at which the leaf of shed rank `rank` detaches, seconds: [`Shedding::start`] plus
    /// [`Shedding::detach_after_start`]. Rises with the rank.
    pub fn detach_time(&self, tree: &TreeShedding, gust_rate: f32, rank: u32) -> f64 {
        self.start + f64::from(self.detach_after_start(tree, gust_rate, rank))
    }

    /// How many leaves have detached by `time`: those of lower shed rank.
    pub fn detached(&self, tree: &TreeShedding, gust_rate: f32, time: f64) -> u32 {
        let elapsed = time - self.start;
        let (mut low, mut high) = (0, tree.leaves);
        while low < high {
            let middle = u32::midpoint(low, high);
            if f64::from(self.detach_after_start(tree, gust_rate, middle)) <= elapsed {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        low
    }
}

/// Keeps the jitter's draws apart from the tree's others.
const JITTER: u32 = 0x7e1e_a5ed;

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn tree(x: f32, shedding: &Shedding, wind: &Wind) -> TreeShedding {
        let instance = Instance {
            model: 0,
            position: Vec3::new(x, 0.0, 0.0),
            yaw: 0.0,
            scale: 1.0,
            season_offset: 0.1,
            seed: 5,
        };
        shedding.tree(&instance, 20_000, wind)
    }

    #[test]
    fn detach_times_rise_with_the_rank_at_the_extremes() {
        let wind = Wind::new(4.0, 0.0, 0.8, 1);
        let shedding =
            Shedding { peak: Shedding::MOST, burst: Shedding::MOST, ..Shedding::default() };
        let tree = tree(30.0, &shedding, &wind);
        let rate = Shedding::gust_rate(&wind);
        let times: Vec<f64> =
            (0..tree.leaves).map(|r| shedding.detach_time(&tree, rate, r)).collect();
        assert!(times.is_sorted());
        assert!((times[0] - (-30.0 - 12.0)).abs() < 8.0, "{}", times[0]);
        let last = times[times.len() - 1];
        assert!((last - 558.0).abs() < 8.0, "{last}");
    }

    #[test]
    fn the_detached_are_a_prefix_of_the_shed_order() {
        let wind = Wind::new(4.0, 0.0, 0.8, 1);
        let shedding = Shedding::default();
        let tree = tree(0.0, &shedding, &wind);
        let rate = Shedding::gust_rate(&wind);
        for time in [-1e6, 0.0, 100.0, 313.7, 1e6] {
            let has =
                |&r: &u32| f64::from(shedding.detach_after_start(&tree, rate, r)) <= time + 30.0;
            let counted = (0..tree.leaves).filter(has).count();
            assert_eq!(shedding.detached(&tree, rate, time), counted as u32);
        }
        assert_eq!(Shedding::never().detached(&tree, rate, 1e9), 0);
    }

    #[test]
    fn most_leaves_detach_while_the_gust_is_at_the_tree() {
        let wind = Wind::new(4.0, 0.0, 1.0, 1);
        let shedding = Shedding { peak: 0.0, burst: 0.9, ..Shedding::default() };
        let rate = Shedding::gust_rate(&wind);
        for x in [0.0, 50.0] {
            let tree = tree(x, &shedding, &wind);
            let gust = |t: f32| {
                let g = &wind.gusts[0];
                let late = wind.travel.x * x * wind.slowness;
                (TAU * (g.cycles as f32 * (t - late) / 1024.0 + g.phase)).sin()
            };
            let strong = (0..tree.leaves)
                .filter(|&r| gust(shedding.detach_time(&tree, rate, r) as f32) > 0.0)
                .count();
            assert!(strong * 10 > tree.leaves as usize * 7, "{strong} of {}", tree.leaves);
        }
    }

    #[test]
    fn a_shedding_that_starts_ten_days_later_is_the_same() {
        let wind = Wind::new(4.0, 0.3, 0.9, 2);
        let early = Shedding { burst: 0.9, ..Shedding::default() };
        // 844 periods of the wind; the gusts are where they were.
        let late = Shedding { start: early.start + 844.0 * Wind::PERIOD, ..early };
        assert!(late.start > 864_000.0);
        let rate = Shedding::gust_rate(&wind);
        let [a, b] = [&early, &late].map(|s| tree(30.0, s, &wind));
        assert_eq!(a, b);
        for rank in (0..a.leaves).step_by(97) {
            let [soon, then] =
                [(&early, &a), (&late, &b)].map(|(s, t)| s.detach_time(t, rate, rank));
            // To what `f64` tells apart at 864,000 s.
            assert!((then - late.start - (soon - early.start)).abs() < 1e-9, "{rank}");
            // Leaves follow each other within some hundredths of a second: none is early or late.
            assert_eq!(late.detached(&b, rate, then), early.detached(&a, rate, soon));
        }
    }

    #[test]
    fn gusts_do_not_care_when_the_shedding_starts() {
        let wind = Wind::new(4.0, 0.0, 1.0, 1);
        let gust = |t: f64| {
            let g = &wind.gusts[0];
            (std::f64::consts::TAU * (f64::from(g.cycles) * t / 1024.0 + f64::from(g.phase))).sin()
        };
        for start in [-30.0, 0.0, 7.3, 864_011.7] {
            let shedding = Shedding { start, peak: 0.0, burst: 0.9, ..Shedding::default() };
            let (tree, rate) = (tree(0.0, &shedding, &wind), Shedding::gust_rate(&wind));
            let times = (0..tree.leaves).map(|r| shedding.detach_time(&tree, rate, r));
            let strong = times.filter(|&t| gust(t) > 0.0).count();
            assert!(strong * 10 > tree.leaves as usize * 7, "{start}: {strong} of {}", tree.leaves);
        }
    }
}
