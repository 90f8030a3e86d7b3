//! Leaves thrown at a rate, for benchmarks and for pictures of a known number of leaves (VB 6.3).

use crate::Stage;
use windfall_core::path::{Fall, LeafFall};
use windfall_core::rng::{hash, unit};
use windfall_core::shed::Shedding;

/// Leaves whose falls are looked at to know how long falls take.
const PROBES: u32 = 1000;

impl Stage {
    /// Leaves of all trees.
    pub fn leaf_count(&self) -> u64 {
        let leaves = |model: u32| self.trees[model as usize].foliage.leaves.len() as u64;
        self.forest.instances.iter().map(|i| leaves(i.model)).sum()
    }

    /// Mean and longest time that leaves take from twig to ground, seconds: of a thousand leaves
    /// drawn by chance from the first `share` (`0..=1`) of each tree to fall. Those that fall first
    /// come from higher up.
    pub fn fall_times(&self, share: f32) -> (f32, f32) {
        let falls = &self.falls;
        let variation = falls.variation.clone();
        let ground = &self.forest.terrain;
        let fall = Fall::new(&falls.paths, ground, falls.wind, variation, falls.settings);
        let instances = &self.forest.instances;
        let (mut sum, mut longest, mut count) = (0.0, 0.0f32, 0u32);
        for probe in 0..PROBES {
            let draw = |counter: u32| unit(hash(probe, counter));
            let Some(instance) = instances.get((draw(1) * instances.len() as f32) as usize) else {
                break;
            };
            let tree = &self.trees[instance.model as usize];
            let foliage = &tree.foliage;
            let rank = (draw(2) * share * foliage.leaves.len() as f32) as usize;
            let Some(&index) = foliage.shed_order.get(rank) else {
                continue;
            };
            let leaf = &foliage.leaves[index as usize];
            let group = falls.group_of(&tree.name);
            let landing = fall.landing(&LeafFall::of(instance, leaf, group, 0.0));
            sum += landing.time;
            longest = longest.max(landing.time);
            count += 1;
        }
        (sum / count.max(1) as f32, longest)
    }

    /// Lets leaves fall at `rate` a second over the whole forest, evenly, from `start` seconds on
    /// until none is left.
    pub fn throw(&mut self, rate: f32, start: f64) {
        self.falls.shedding = self.thrown(rate, start);
    }

    /// The shedding of [`Stage::throw`].
    pub fn thrown(&self, rate: f32, start: f64) -> Shedding {
        let duration = (self.leaf_count() as f32 / rate.max(1e-6)).clamp(0.1, 1e7);
        Shedding { start, duration, peak: 0.0, tree_spread: 0.0, burst: 0.0 }
    }

    /// Keeps about `count` leaves in the air from time 0 on, as long as there are leaves; returns
    /// the rate, leaves a second.
    pub fn keep_falling(&mut self, count: u32) -> f32 {
        let (mut rate, mut share) = (0.0, 1.0);
        // Which leaves fall about time 0 depends on the rate, and that on how long those fall.
        for _ in 0..4 {
            let (mean, longest) = self.fall_times(share);
            rate = count as f32 / mean.max(0.1);
            self.throw(rate, f64::from(-longest));
            share = (2.0 * longest / self.falls.shedding.duration).min(1.0);
        }
        rate
    }
}

#[cfg(test)]
mod tests {
    use crate::{Stage, named};
    use std::convert::Infallible;

    #[test]
    fn as_many_leaves_are_in_the_air_as_were_asked_for() {
        let scene = named("lone-oak").unwrap();
        let mut stage: Stage =
            scene.build(|_, _| -> Result<_, Infallible> { unreachable!() }).unwrap();
        let rate = stage.keep_falling(500);
        let (mean, longest) = stage.fall_times(1.0);
        assert!((rate * mean / 500.0 - 1.0).abs() < 0.5, "{rate} leaves/s for {mean} s");
        assert!(longest >= mean);
        let s = stage.falls.shedding;
        assert!((stage.leaf_count() as f32 / s.duration - rate).abs() < rate * 0.01);
    }
}
