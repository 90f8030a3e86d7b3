//! When leaves detach: a closed form of shed rank, tree and season.
//!
//! The leaves of a tree fall in shed order. A leaf's *fraction* is its shed rank, plus a random part
//! of one, over the tree's leaves; its detach time is a rising function of that. So the leaves that
//! have fallen by a time are a prefix of the shed order, found by bisection, and any moment can be
//! asked for without those before it.

use crate::forest::Instance;
use crate::rng::{hash, unit};
use crate::wind::Wind;
use glam::Vec3Swizzles;
use std::f32::consts::TAU;

/// How a forest sheds its leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shedding {
    /// When the first leaf of a tree without season offset detaches, seconds.
    pub start: f32,
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
    /// Phase of the strongest gust at the tree at time 0, turns, a quarter ahead.
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

    /// No leaf ever falls.
    pub fn never() -> Self {
        Self { start: f32::MAX / 4.0, ..Self::default() }
    }

    /// A tree's part in it. Gusts that cross the forest shake the tree when they are there.
    pub fn tree(&self, instance: &Instance, leaves: u32, wind: &Wind) -> TreeShedding {
        let gust = &wind.gusts[0];
        let late = wind.travel.dot(instance.position.xz()) * wind.slowness;
        let phase = gust.phase - gust.cycles as f32 * late / Wind::PERIOD as f32 + 0.25;
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

    /// Time at which the leaf of shed rank `rank` detaches, seconds. Rises with the rank.
    pub fn detach_time(&self, tree: &TreeShedding, gust_rate: f32, rank: u32) -> f32 {
        let jitter = unit(hash(tree.seed ^ JITTER, rank));
        let x = (rank as f32 + jitter) / tree.leaves.max(1) as f32;
        let eased = x + self.peak / TAU * (TAU * x).sin();
        let even = self.start + tree.delay + self.duration * eased;
        let turns = gust_rate * even + tree.gust_phase;
        even + self.burst / (TAU * gust_rate) * (TAU * (turns - turns.floor())).sin()
    }

    /// How many leaves have detached by `time`: those of lower shed rank.
    pub fn detached(&self, tree: &TreeShedding, gust_rate: f32, time: f32) -> u32 {
        let (mut low, mut high) = (0, tree.leaves);
        while low < high {
            let middle = u32::midpoint(low, high);
            if self.detach_time(tree, gust_rate, middle) <= time {
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
        let times: Vec<f32> =
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
            let counted =
                (0..tree.leaves).filter(|&r| shedding.detach_time(&tree, rate, r) <= time).count();
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
                .filter(|&r| gust(shedding.detach_time(&tree, rate, r)) > 0.0)
                .count();
            assert!(strong * 10 > tree.leaves as usize * 7, "{strong} of {}", tree.leaves);
        }
    }
}
