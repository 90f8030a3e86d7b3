//! The colour of a leaf in autumn: how far each leaf is ahead of the scene's season.
//!
//! The reference for `base/wgsl/season.wgsl` of the renderer.

use super::{Foliage, Leaf};
use crate::forest::Instance;
use crate::rng::{hash, unit};
use glam::Vec3;
use std::f32::consts::TAU;

/// A leaf's place in autumn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeafSeason {
    /// Phase of the palette, `0..=1`.
    pub phase: f32,
    /// Factor on the leaf's colour, 0.82 to 1.18.
    pub brightness: f32,
}

/// How far a leaf is ahead of the scene's season by where it is: the top of the crown turns first, and branches,
/// patches of about half of the crown, have times of their own. `from_center` is the leaf's place from the crown's
/// centre in half crowns.
pub fn ripeness(season_offset: f32, tree_seed: u32, from_center: Vec3) -> f32 {
    let wave = |way: Vec3, draw: u32| {
        let turns = from_center.dot(way) + unit(hash(tree_seed, draw));
        (TAU * (turns - turns.floor())).sin()
    };
    let branch = 0.09 * wave(Vec3::new(0.83, 0.55, -0.61), 14)
        + 0.07 * wave(Vec3::new(-0.97, 1.13, 0.86), 15);
    season_offset + 0.12 * from_center.y + branch
}

/// Factor on the colour of a leaf that has lain on the ground for so many seconds: it withers over four minutes.
pub fn withering(since_landing: f32) -> Vec3 {
    Vec3::ONE.lerp(Vec3::new(0.62, 0.48, 0.42), (since_landing / 240.0).clamp(0.0, 1.0))
}

impl Foliage {
    /// Where a leaf of a tree is in autumn, in a scene of phase `season`. `extent` is [`Foliage::crown_extent`].
    pub fn season_of(
        &self,
        leaf: &Leaf,
        instance: &Instance,
        season: f32,
        extent: Vec3,
    ) -> LeafSeason {
        let key = hash(instance.seed, leaf.shed_rank);
        let from_center = (leaf.center - self.crown_center) / extent;
        let ripe = ripeness(instance.season_offset, instance.seed, from_center);
        let spread = self.palette.as_ref().map_or(0.0, |palette| palette.spread);
        let own = (unit(hash(key, 10)) + unit(hash(key, 12)) - 1.0) * spread;
        LeafSeason {
            phase: (season + ripe + own).clamp(0.0, 1.0),
            brightness: 0.82 + 0.36 * unit(hash(key, 11)),
        }
    }

    /// Linear colour that multiplies the colour of a leaf's material.
    pub fn season_color(&self, season: &LeafSeason) -> Vec3 {
        let color = self.palette.as_ref().map_or(Vec3::ONE, |palette| palette.color(season.phase));
        color * season.brightness
    }
}
