//! A small forest, and where its leaves are by the CPU reference alone.
#![allow(dead_code, reason = "every test file uses a part of it")]

use std::collections::BTreeMap;
use windfall_core::forest::{Forest, Placement, Terrain};
use windfall_core::glam::{DVec3, Quat, Vec3};
use windfall_core::path::{Fall, FallSettings, LeafFall, PathSet, Phase, Variation, stack_height};
use windfall_core::shed::Shedding;
use windfall_core::tree::Tree;
use windfall_core::wind::Wind;
use windfall_export::{Filter, LeafId, Moments, Selection, Source, Thrown};
use windfall_tree::{GrowOptions, Species};

pub struct Place {
    pub trees: Vec<Tree>,
    pub forest: Forest,
    pub paths: PathSet,
    pub thrown: Vec<Thrown>,
}

/// Ten seconds of frames in which leaves detach, fall and land.
pub const MOMENTS: Moments = Moments { first: 120, count: 60, fps: 6.0 };

impl Place {
    /// Three small trees of two species on a hillside; some leaves of the first are thrown.
    pub fn new() -> Self {
        let grow = |species: Species, seed: u32| {
            let options = GrowOptions { height: Some(5.0), ..GrowOptions::default() };
            let mut tree = species.grow_as(seed, &options);
            tree.foliage.truncate(400);
            tree
        };
        let trees = vec![grow(Species::Birch, 1), grow(Species::Oak, 2)];
        let placement = Placement { trees: 3, spacing: 5.0, seed: 4, ..Placement::default() };
        let forest = placement.place(Terrain::rolling(100.0, 3.0, 5), &[1.0, 1.0]);
        let thrown =
            (0..20).map(|i| Thrown { tree: 0, leaf: i * 7, time: 15.0 + f64::from(i) }).collect();
        Self { trees, forest, paths: PathSet::builtin(), thrown }
    }

    pub fn source(&self) -> Source<'_> {
        Source {
            trees: &self.trees,
            forest: &self.forest,
            paths: &self.paths,
            shedding: Shedding { start: 0.0, duration: 60.0, ..Shedding::default() },
            wind: Wind::new(2.0, 0.8, 0.8, 7),
            variation: Variation::default(),
            settings: FallSettings::default(),
            season: 0.6,
            thrown: self.thrown.clone(),
        }
    }
}

pub fn select<'a>(source: &'a Source<'a>, moments: Moments, filter: Filter) -> Selection<'a> {
    Selection::new(source, moments, filter, &|_| DVec3::new(0.0, 1.0, 20.0))
}

/// Where a leaf is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Where {
    pub phase: &'static str,
    pub position: Vec3,
    pub orientation: Quat,
    pub scale: f32,
}

/// All leaves of a forest at a time, found one by one without a selection.
pub fn reference(source: &Source<'_>, time: f64) -> BTreeMap<LeafId, Where> {
    let fall = Fall::new(
        source.paths,
        &source.forest.terrain,
        source.wind,
        source.variation.clone(),
        source.settings,
    );
    let rate = Shedding::gust_rate(&source.wind);
    let mut out = BTreeMap::new();
    for (number, instance) in (0u32..).zip(&source.forest.instances) {
        let tree = &source.trees[instance.model as usize];
        let count = tree.foliage.leaves.len() as u32;
        let shed = source.shedding.tree(instance, count, &source.wind);
        for (index, leaf) in (0u32..).zip(&tree.foliage.leaves) {
            let own = source.thrown.iter().filter(|t| (t.tree, t.leaf) == (number, index));
            let detach = own
                .map(|t| t.time)
                .fold(source.shedding.detach_time(&shed, rate, leaf.shed_rank), f64::min);
            let group = source.paths.group(&tree.name).unwrap_or(0);
            let leaf_fall = LeafFall::of(instance, leaf, group, detach);
            let landing = fall.landing(&leaf_fall);
            let scale = leaf.scale * instance.scale;
            let thickness = tree.foliage.shapes[leaf.shape as usize].thickness();
            let stack = stack_height(&leaf_fall, scale, thickness);
            let pose = fall.drawn_pose(&leaf_fall, &landing, stack, time);
            let phase = match pose.phase {
                Phase::Hanging => "hanging",
                Phase::Falling { .. } => "falling",
                Phase::Landed => "landed",
            };
            let (position, orientation) = (pose.position, pose.orientation);
            let id = LeafId(u64::from(number) << 32 | u64::from(index));
            out.insert(id, Where { phase, position, orientation, scale });
        }
    }
    out
}

/// Degrees between two rotations.
pub fn angle(a: Quat, b: Quat) -> f32 {
    let (a, b) = (a.normalize(), b.normalize());
    let chord = (a - b).length().min((a + b).length());
    (4.0 * (0.5 * chord).asin()).to_degrees()
}
