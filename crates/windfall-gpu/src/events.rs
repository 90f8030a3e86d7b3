//! Leaves that a program throws: detached at a moment of its own choice, beside the season.
//!
//! Such a leaf is taken out of its tree's streams and put in one that has its detach times written
//! down ([`crate::falls`]). On the twig it is found by searching the events of its tree, a binary tree
//! that only the vertices of such a tree walk through.

use crate::falls::Falls;
use glam::UVec4;
use std::collections::{BTreeMap, BTreeSet};
use windfall_core::forest::Forest;
use windfall_core::shed::Shedding;
use windfall_core::tree::Tree;

/// A leaf that detaches at a moment of the program's choice. It falls, lands and lies as any other.
///
/// The earliest of a leaf's events counts, and none that comes when the season has taken the leaf.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DetachEvent {
    /// Index of the tree in [`Forest::instances`].
    pub instance: u32,
    /// Index of the leaf in the model's `Foliage::leaves`: in prune order.
    pub leaf: u32,
    /// When, seconds since the scene began; finite.
    pub time: f32,
}

/// An event that cannot be.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("events[{index}]: {cause}")]
pub struct EventError {
    /// Its index in [`Falls::events`].
    pub index: usize,
    /// What is wrong with it.
    pub cause: String,
}

impl Falls {
    /// Most trees that [`Falls::events`] may be of. Events of one tree: any number.
    pub const EVENT_TREES: usize = 255;

    /// Checks the events against what they speak of.
    ///
    /// # Errors
    ///
    /// The first event of a tree or leaf that there is not, of a time that is not finite, or of more
    /// than [`Falls::EVENT_TREES`] trees.
    pub fn check_events(&self, trees: &[Tree], forest: &Forest) -> Result<(), EventError> {
        let mut known = BTreeSet::new();
        for (index, event) in self.events.iter().enumerate() {
            check(event, trees, forest, &mut known).map_err(|cause| EventError { index, cause })?;
        }
        Ok(())
    }
}

/// Checks an event; `known` are the trees of those before it.
fn check(
    event: &DetachEvent,
    trees: &[Tree],
    forest: &Forest,
    known: &mut BTreeSet<u32>,
) -> Result<(), String> {
    let DetachEvent { instance, leaf, time } = *event;
    let Some(tree) = forest.instances.get(instance as usize) else {
        let count = forest.instances.len();
        return Err(format!("tree {instance} is not one of the {count} of the forest, from 0"));
    };
    let count = trees.get(tree.model as usize).map_or(0, |t| t.foliage.leaves.len());
    if leaf as usize >= count {
        return Err(format!("leaf {leaf} is not one of the {count} of tree {instance}, from 0"));
    }
    if !time.is_finite() {
        return Err(format!("time {time} is not finite"));
    }
    if known.len() == Falls::EVENT_TREES && !known.contains(&instance) {
        let most = Falls::EVENT_TREES;
        return Err(format!("tree {instance} is one too many: events may be of {most} trees"));
    }
    known.insert(instance);
    Ok(())
}

/// The leaves of each tree that are thrown before the season takes them.
#[derive(Default)]
pub(crate) struct Thrown {
    /// By index of the instance: leaves and times, by leaf.
    trees: BTreeMap<u32, BTreeMap<u32, f32>>,
}

impl Thrown {
    /// Events that [`Falls::check_events`] refuses are left out.
    pub fn new(trees: &[Tree], forest: &Forest, falls: &Falls) -> Self {
        let mut known = BTreeSet::new();
        let mut out = Self::default();
        let rate = Shedding::gust_rate(&falls.wind);
        for event in &falls.events {
            if check(event, trees, forest, &mut known).is_err() {
                continue;
            }
            let instance = &forest.instances[event.instance as usize];
            let foliage = &trees[instance.model as usize].foliage;
            let shed = falls.shedding.tree(instance, foliage.leaves.len() as u32, &falls.wind);
            let rank = foliage.leaves[event.leaf as usize].shed_rank;
            if event.time < falls.shedding.detach_time(&shed, rate, rank) {
                let leaves = out.trees.entry(event.instance).or_default();
                let time = leaves.entry(event.leaf).or_insert(event.time);
                *time = time.min(event.time);
            }
        }
        out
    }

    /// Leaves of a tree that are thrown, and when.
    pub fn of(&self, instance: u32) -> Option<&BTreeMap<u32, f32>> {
        self.trees.get(&instance)
    }

    /// Where the search for an event of this tree begins in [`Thrown::nodes`]; 0 for a tree without.
    /// At most [`Falls::EVENT_TREES`].
    pub fn root(&self, instance: u32) -> u32 {
        match self.trees.keys().position(|&i| i == instance) {
            Some(at) => at as u32 + 1,
            None => 0,
        }
    }

    /// A binary tree of events for each tree: leaf, time, nodes of the leaves below and above. Roots
    /// come first, from 1; node 0 stands for none.
    pub fn nodes(&self) -> Vec<UVec4> {
        let mut nodes = vec![UVec4::ZERO; 1 + self.trees.len()];
        for (at, leaves) in self.trees.values().enumerate() {
            let sorted: Vec<(u32, f32)> =
                leaves.iter().map(|(&leaf, &time)| (leaf, time)).collect();
            fill(&mut nodes, at + 1, &sorted);
        }
        nodes
    }
}

/// Makes node `at` that of the middle leaf, with the others below it.
fn fill(nodes: &mut Vec<UVec4>, at: usize, leaves: &[(u32, f32)]) {
    let middle = leaves.len() / 2;
    let (leaf, time) = leaves[middle];
    let [low, high] = [&leaves[..middle], &leaves[middle + 1..]].map(|half| {
        if half.is_empty() {
            return 0;
        }
        let child = nodes.len();
        nodes.push(UVec4::ZERO);
        fill(nodes, child, half);
        child as u32
    });
    nodes[at] = UVec4::new(leaf, time.to_bits(), low, high);
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use windfall_core::forest::{Instance, Terrain};
    use windfall_core::tree::species::Species;

    fn forest(count: u32) -> Forest {
        let instance = |seed| Instance {
            model: 0,
            position: Vec3::ZERO,
            yaw: 0.0,
            scale: 1.0,
            season_offset: 0.0,
            seed,
        };
        Forest { terrain: Terrain::flat(), instances: (0..count).map(instance).collect() }
    }

    fn still(events: Vec<DetachEvent>) -> Falls {
        Falls { events, ..Falls::none() }
    }

    /// The twin of `thrown` in `shaders/leaves.wgsl`.
    fn time_of(nodes: &[UVec4], root: u32, leaf: u32) -> Option<f32> {
        let mut at = root;
        while at > 0 {
            let node = nodes[at as usize];
            if node.x == leaf {
                return Some(f32::from_bits(node.y));
            }
            at = if leaf < node.x { node.z } else { node.w };
        }
        None
    }

    #[test]
    fn events_are_found_by_tree_and_leaf_and_the_earliest_counts() {
        let trees = [Species::Birch.grow(1)];
        let leaves = trees[0].foliage.leaves.len() as u32;
        let mut events = Vec::new();
        for instance in [4, 1] {
            // Every third leaf, in no order, twice.
            for i in 0..leaves / 3 {
                let leaf = (i * 7919 % (leaves / 3)) * 3;
                let time = (leaf + instance) as f32;
                events.push(DetachEvent { instance, leaf, time });
                events.push(DetachEvent { instance, leaf, time: time + 1.0 });
            }
        }
        let thrown = Thrown::new(&trees, &forest(6), &still(events));
        let nodes = thrown.nodes();
        assert_eq!([0, 1, 4].map(|i| thrown.root(i)), [0, 1, 2]);
        for instance in [1, 4] {
            for leaf in 0..leaves {
                let expected =
                    (leaf % 3 == 0 && leaf / 3 < leaves / 3).then_some((leaf + instance) as f32);
                let found = time_of(&nodes, thrown.root(instance), leaf);
                assert_eq!(found, expected, "leaf {leaf} of tree {instance}");
            }
        }
    }

    #[test]
    fn an_event_after_the_season_took_the_leaf_is_none() {
        let trees = [Species::Birch.grow(1)];
        let forest = forest(1);
        let mut falls = Falls::default();
        let count = trees[0].foliage.leaves.len() as u32;
        let shed = falls.shedding.tree(&forest.instances[0], count, &falls.wind);
        let rate = Shedding::gust_rate(&falls.wind);
        let rank = trees[0].foliage.leaves[9].shed_rank;
        let season = falls.shedding.detach_time(&shed, rate, rank);
        for (early, there) in [(0.1, true), (0.0, false), (-0.1, false)] {
            let time = season - early;
            falls.events = vec![DetachEvent { instance: 0, leaf: 9, time }];
            let thrown = Thrown::new(&trees, &forest, &falls);
            assert_eq!(thrown.of(0).is_some(), there, "{early} s early");
            assert_eq!(thrown.root(0), u32::from(there));
        }
    }

    #[test]
    fn events_that_cannot_be_are_named_and_left_out() {
        let trees = [Species::Birch.grow(1)];
        let good = DetachEvent { instance: 0, leaf: 5, time: 1.0 };
        let count = trees[0].foliage.leaves.len() as u32;
        let cases = [
            (DetachEvent { instance: 3, ..good }, "events[1]: tree 3 is not one of the 3"),
            (DetachEvent { leaf: count, ..good }, "events[1]: leaf"),
            (DetachEvent { time: f32::NAN, ..good }, "events[1]: time NaN"),
            (DetachEvent { time: f32::INFINITY, ..good }, "events[1]: time inf"),
        ];
        for (bad, message) in cases {
            let falls = still(vec![good, bad]);
            let error = falls.check_events(&trees, &forest(3)).unwrap_err().to_string();
            assert!(error.starts_with(message), "{error}");
            let thrown = Thrown::new(&trees, &forest(3), &falls);
            assert_eq!(thrown.of(0), Some(&BTreeMap::from([(5, 1.0)])));
            assert_eq!(thrown.trees.len(), 1);
        }
    }

    #[test]
    fn events_of_too_many_trees_are_refused() {
        let trees = [Species::Birch.grow(1)];
        let forest = forest(300);
        let of = |instance| DetachEvent { instance, leaf: 0, time: 0.0 };
        let mut falls = still((0..255).map(of).collect());
        falls.events.push(of(7));
        assert_eq!(falls.check_events(&trees, &forest), Ok(()));
        falls.events.push(of(255));
        assert_eq!(falls.check_events(&trees, &forest).unwrap_err().index, 256);
        let thrown = Thrown::new(&trees, &forest, &falls);
        assert_eq!([thrown.root(254), thrown.root(255)], [255, 0]);
    }
}
