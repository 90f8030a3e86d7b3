//! Leaves that a program throws: detached at a moment of its own choice, beside the season.
//!
//! Such a leaf is left out of its tree's streams and put in one that has its detach times written
//! down ([`super::streams`]). On the twig, and where a stream leaves it out, shaders find it in a hash table.

use glam::{UVec4, Vec3};
use std::collections::BTreeMap;
use windfall_core::rng::hash;

/// The leaves that a program has thrown.
#[derive(Default)]
pub struct Scripted {
    /// By tree ([`scripted_key`]) and leaf: when, seconds since the shedding began.
    leaves: BTreeMap<(u32, u32), f32>,
}

/// What tells a tree from all others; the shader's is in `base/wgsl/frame.wgsl`.
pub fn scripted_key(seed: u32, position: Vec3) -> u32 {
    position.to_array().iter().fold(seed, |key, v| hash(key, v.to_bits()))
}

impl Scripted {
    /// Adds a leaf; the earliest of its times counts.
    pub fn insert(&mut self, tree: u32, leaf: u32, time: f32) {
        let known = self.leaves.entry((tree, leaf)).or_insert(time);
        *known = known.min(time);
    }

    /// Takes the leaves of a tree out.
    pub fn remove_tree(&mut self, tree: u32) {
        self.leaves.retain(|&(of, _), _| of != tree);
    }

    /// The table: its size less one, then its places ([`UVec4::ZERO`] where there is none), at most half full.
    pub fn table(&self) -> Vec<UVec4> {
        let size = (2 * self.leaves.len()).next_power_of_two().max(2);
        let mask = size as u32 - 1;
        let mut table = vec![UVec4::ZERO; 1 + size];
        table[0].x = mask;
        for (&(tree, leaf), &time) in &self.leaves {
            let mut at = hash(tree, leaf) & mask;
            while table[1 + at as usize].w != 0 {
                at = (at + 1) & mask;
            }
            table[1 + at as usize] = UVec4::new(tree, leaf, time.to_bits(), 1);
        }
        table
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The CPU reference of `scripted_detach` in `base/wgsl/frame.wgsl`.
    fn find(table: &[UVec4], tree: u32, leaf: u32) -> Option<f32> {
        let mask = table[0].x;
        let mut at = hash(tree, leaf) & mask;
        loop {
            let entry = table[1 + at as usize];
            if entry.w == 0 {
                return None;
            }
            if (entry.x, entry.y) == (tree, leaf) {
                return Some(f32::from_bits(entry.z));
            }
            at = (at + 1) & mask;
        }
    }

    #[test]
    fn leaves_are_found_by_tree_and_leaf_and_the_earliest_time_counts() {
        let mut scripted = Scripted::default();
        assert_eq!(find(&scripted.table(), 1, 1), None);
        for i in 0..1000u32 {
            // Every third leaf of two trees, in no order, twice.
            let leaf = (i * 7919 % 1000) * 3;
            for tree in [77, 5] {
                scripted.insert(tree, leaf, (leaf + tree) as f32);
                scripted.insert(tree, leaf, (leaf + tree + 1) as f32);
            }
        }
        let table = scripted.table();
        assert_eq!(table.len(), 1 + 4096);
        for leaf in 0..3000 {
            for tree in [5, 77, 78] {
                let expected = (leaf % 3 == 0 && tree != 78).then_some((leaf + tree) as f32);
                assert_eq!(find(&table, tree, leaf), expected, "leaf {leaf} of {tree}");
            }
        }
    }

    #[test]
    fn trees_at_other_places_have_other_keys() {
        let at = |x: f32| scripted_key(9, Vec3::new(x, 0.0, 1.0));
        assert!(at(1.0) != at(2.0) && at(1.0) == at(1.0));
    }
}
