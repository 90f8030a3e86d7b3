//! Leaves in the air near a point: for games and sound.

use crate::assets::{FallPaths, TreeModel};
use crate::forest::{
    PlantedTrees, ThrownLeaves, TreeKey, WindfallForest, WindfallTime, WindfallTree, WindfallWind,
    forest_of, instance_of,
};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use std::collections::HashMap;
use windfall::forest::Instance;
use windfall::path::{Fall, LeafFall, PathSet, Phase};
use windfall::shed::Shedding;
use windfall::tree::Tree;

/// A leaf in the air.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearLeaf {
    /// The [`WindfallTree`], or the forest of an instance.
    pub tree: Entity,
    /// Of a forest's own trees, which.
    pub instance: u32,
    /// The leaf: an index into `Foliage::leaves` of the model.
    pub leaf: u32,
    /// Its middle in Bevy's world, metres.
    pub position: Vec3,
    /// Its orientation in the world.
    pub rotation: Quat,
    /// Seconds until it lands.
    pub landing: f32,
    /// Where it will land.
    pub landing_place: Vec3,
}

/// Asks for leaves in the air. The answer is computed on the CPU by the model that the shaders mirror, for the trees
/// whose leaves may be near: some microseconds a leaf in the air. Sway, which moves leaves that have just detached by
/// centimetres, is not in it.
#[derive(SystemParam)]
pub struct LeavesNear<'w, 's> {
    clock: Res<'w, WindfallTime>,
    models: Res<'w, Assets<TreeModel>>,
    paths: Res<'w, Assets<FallPaths>>,
    forests: Query<
        'w,
        's,
        (
            Entity,
            &'static WindfallForest,
            &'static PlantedTrees,
            &'static ThrownLeaves,
            &'static WindfallWind,
            &'static GlobalTransform,
        ),
    >,
    trees: Query<'w, 's, (Entity, &'static WindfallTree, &'static GlobalTransform)>,
    parents: Query<'w, 's, &'static ChildOf>,
    builtin: Local<'s, Option<PathSet>>,
}

/// Speed of the leaves' own flight along the ground, metres per second: more than paths have.
const GLIDE: f32 = 1.0;
/// Rate of the slowest playback of a path over its own.
const SLOWEST: f32 = 0.8;

impl LeavesNear<'_, '_> {
    /// The leaves in the air within `radius` metres of a point of Bevy's world, in no order.
    pub fn find(&mut self, point: Vec3, radius: f32) -> Vec<NearLeaf> {
        let mut found = Vec::new();
        let now = self.clock.seconds;
        let builtin = self.builtin.get_or_insert_with(PathSet::builtin);
        for (entity, forest, planted, thrown, wind, place) in &self.forests {
            let paths = match &forest.paths {
                None => &*builtin,
                Some(handle) => match self.paths.get(handle) {
                    Some(FallPaths(paths)) => paths,
                    None => continue,
                },
            };
            let origin = place.translation();
            let fall = Fall::new(
                paths,
                &forest.terrain,
                wind.0,
                forest.variation.clone(),
                forest.settings,
            );
            let descent = paths.paths().iter().map(|p| p.descent()).fold(f32::INFINITY, f32::min);
            let rate = Shedding::gust_rate(&wind.0);
            let mut of_trees: HashMap<TreeKey, Vec<(u32, f64)>> = HashMap::new();
            for leaf in thrown.leaves.iter().filter(|leaf| leaf.time <= now) {
                of_trees.entry(leaf.tree).or_default().push((leaf.leaf, leaf.time));
            }
            let mut search = |key: TreeKey, instance: &Instance, tree: &Tree| {
                let (low, high) = tree.bounds();
                let ground = forest.terrain.range().0;
                let drop = instance.position.y + high.y * instance.scale - ground;
                // The longest that a leaf of it is in the air, and how far it comes meanwhile.
                let longest = drop.max(0.0) / (SLOWEST * descent).max(0.05) + 3.0;
                let crown = (high - low).length() * instance.scale;
                let reach = radius + crown + longest * (wind.0.fastest() + GLIDE);
                if point.xz().distance((origin + instance.position).xz()) > reach {
                    return;
                }
                let foliage = &tree.foliage;
                let group = paths.group(&tree.name).unwrap_or(0);
                let shed = forest.shedding.tree(instance, foliage.leaves.len() as u32, &wind.0);
                let gone = forest.shedding.detached(&shed, rate, now) as usize;
                let by_season = foliage.shed_order[..gone].iter().rev().map(|&leaf| {
                    let rank = foliage.leaves[leaf as usize].shed_rank;
                    (leaf, forest.shedding.detach_time(&shed, rate, rank))
                });
                let by_season = by_season.take_while(|(_, time)| now - time < f64::from(longest));
                let own = of_trees.get(&key).map_or(&[][..], Vec::as_slice);
                let earlier = |leaf: u32, time: f64| own.iter().any(|o| o.0 == leaf && o.1 < time);
                let by_throw = own.iter().copied().filter(|&(leaf, time)| {
                    let rank = foliage.leaves[leaf as usize].shed_rank;
                    time < forest.shedding.detach_time(&shed, rate, rank) && !earlier(leaf, time)
                });
                for (leaf, time) in by_season.filter(|(l, t)| !earlier(*l, *t)).chain(by_throw) {
                    let falling =
                        LeafFall::of(instance, &foliage.leaves[leaf as usize], group, time);
                    let landing = fall.landing(&falling);
                    let pose = fall.pose(&falling, &landing, now);
                    let position = origin + pose.position;
                    if matches!(pose.phase, Phase::Falling { .. })
                        && position.distance(point) <= radius
                    {
                        let (tree, instance) = match key {
                            TreeKey::Instance(index) => (entity, index),
                            TreeKey::Entity(tree) => (tree, 0),
                        };
                        found.push(NearLeaf {
                            tree,
                            instance,
                            leaf,
                            position,
                            rotation: pose.orientation,
                            landing: landing.time - (now - time) as f32,
                            landing_place: origin + landing.position,
                        });
                    }
                }
            };
            for (index, instance) in (0..).zip(planted.instances()) {
                let model = forest.models.get(instance.model as usize);
                if let Some(model) = model.and_then(|model| self.models.get(model)) {
                    search(TreeKey::Instance(index), instance, &model.tree);
                }
            }
            for (tree, of, place) in &self.trees {
                if forest_of(tree, &self.forests, &self.parents) != Some(entity) {
                    continue;
                }
                if let Some(model) = self.models.get(&of.model) {
                    search(TreeKey::Entity(tree), &instance_of(of, place, origin), &model.tree);
                }
            }
        }
        found
    }
}
