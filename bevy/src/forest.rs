//! What an application spawns: forests, single trees, and what changes about them.

use crate::assets::{FallPaths, TreeModel};
use bevy::prelude::*;
use std::sync::Arc;
use windfall::Falls;
use windfall::forest::{Instance, Placement, Terrain};
use windfall::path::{FallSettings, Variation};
use windfall::rng::{hash, unit};
use windfall::shed::Shedding;
use windfall::wind::Wind;

/// A forest: trees on a terrain that shed their leaves, about the entity's place.
///
/// Of its [`GlobalTransform`] the translation counts: the up axis of a forest is the world's, and it is not scaled. It
/// may move at any time, at no cost; floating origins move it as they move everything else. Entities with
/// [`WindfallTree`] below it in the hierarchy are trees of it too.
///
/// A change of the component makes the forest anew. What changes from frame to frame has components of its own:
/// [`Season`], [`WindfallWind`].
#[derive(Component, Debug, Clone)]
#[require(Transform, Visibility, Season, WindfallWind, LeafBudget, PlantedTrees, ThrownLeaves)]
pub struct WindfallForest {
    /// The models; it is drawn once all are loaded.
    pub models: Vec<Handle<TreeModel>>,
    /// Where trees of them stand.
    pub trees: Trees,
    /// The ground that leaves land on, about the entity's place. It is not drawn: [`crate::ground_mesh`] makes a mesh
    /// of it.
    pub terrain: Arc<Terrain>,
    /// When leaves detach, in seconds of [`WindfallTime`].
    pub shedding: Shedding,
    /// What they fall by; `None`: the built-in paths.
    pub paths: Option<Handle<FallPaths>>,
    /// How falls on the same path differ.
    pub variation: Variation,
    /// How falls begin and end.
    pub settings: FallSettings,
}

/// Where the trees of a forest stand.
#[derive(Debug, Clone, PartialEq)]
pub enum Trees {
    /// At random, none closer than a spacing; models are equally frequent.
    Placed(Placement),
    /// Here, metres from the forest's place.
    At(Vec<Instance>),
}

impl Default for WindfallForest {
    /// No trees on level ground.
    fn default() -> Self {
        let Falls { shedding, variation, settings, .. } = Falls::default();
        Self {
            models: Vec::new(),
            trees: Trees::At(Vec::new()),
            terrain: Arc::new(Terrain::flat()),
            shedding,
            paths: None,
            variation,
            settings,
        }
    }
}

impl WindfallForest {
    /// `trees` trees of these models at random on level ground, `spacing` metres apart or more.
    pub fn scattered(models: Vec<Handle<TreeModel>>, trees: u32, spacing: f32) -> Self {
        let placement = Placement { trees, spacing, ..Placement::default() };
        Self { models, trees: Trees::Placed(placement), ..Self::default() }
    }

    /// Where the trees stand, or why they cannot.
    fn place(&self) -> Result<Vec<Instance>, String> {
        let models = self.models.len();
        match &self.trees {
            Trees::At(instances) => match instances.iter().position(|i| i.model as usize >= models)
            {
                Some(i) => {
                    let model = instances[i].model;
                    Err(format!("instance {i}: model {model} is not one of the {models}"))
                }
                None => Ok(instances.clone()),
            },
            Trees::Placed(placement) => {
                let Placement { trees, spacing, .. } = *placement;
                if trees > Placement::MOST {
                    let most = Placement::MOST;
                    Err(format!("{trees} trees are more than the {most} of a forest"))
                } else if !(spacing > 0.0 && spacing.is_finite()) {
                    Err(format!("a spacing of {spacing} m: it is above 0"))
                } else if models == 0 && trees > 0 {
                    Err("it has no models".to_owned())
                } else {
                    let terrain = Terrain::clone(&self.terrain);
                    Ok(placement.place(terrain, &vec![1.0; models]).instances)
                }
            }
        }
    }
}

/// Phase of autumn of a forest, 0 late summer to 1 bare: the colours of its leaves. When they fall is
/// [`WindfallForest::shedding`]'s. May change in every frame.
#[derive(Component, Debug, Clone, Copy, PartialEq)]
pub struct Season(pub f32);

impl Default for Season {
    fn default() -> Self {
        Self(0.5)
    }
}

/// The wind of a forest: it sways its trees and carries its leaves. Leaves in the air and on the ground are where this
/// wind has taken them, so that a change moves them: set it where that is not seen, or have it gust by itself.
#[derive(Component, Debug, Clone, Copy, PartialEq)]
pub struct WindfallWind(pub Wind);

impl Default for WindfallWind {
    fn default() -> Self {
        Self(Falls::default().wind)
    }
}

/// Most leaves of a forest in the air and on the ground together, 68 bytes of GPU memory each, and 32 more for each
/// camera: where there are more, those that have lain longest vanish. Default 1,000,000. A change makes the forest anew.
#[derive(Component, Debug, Clone, Copy, PartialEq, Eq)]
pub struct LeafBudget(pub u32);

impl Default for LeafBudget {
    fn default() -> Self {
        Self(Falls::default().capacity)
    }
}

/// A tree by itself: it stands where its entity's [`GlobalTransform`] says, turned about Y and scaled evenly as that is,
/// and may move.
///
/// Below a [`WindfallForest`] in the hierarchy it is a tree of that forest, with its wind, season, shedding and ground.
/// Elsewhere it gets a forest of its own, with level ground at its foot, whose components ([`Season`], ...) are on the
/// same entity. Many trees belong into one forest: each forest has draws of its own.
#[derive(Component, Debug, Clone, PartialEq)]
#[require(Transform, Visibility)]
pub struct WindfallTree {
    /// The model.
    pub model: Handle<TreeModel>,
    /// Added to the forest's season, `-1..=1`.
    pub season_offset: f32,
    /// Key of everything that is random about this tree.
    pub seed: u32,
}

impl WindfallTree {
    /// A tree in season.
    pub fn new(model: Handle<TreeModel>, seed: u32) -> Self {
        Self { model, season_offset: 0.0, seed }
    }
}

/// The clock of all forests. It follows [`Time`], which is virtual: paused and scaled as that is. Set `seconds` to go
/// to any moment, earlier ones too: the picture is a function of it.
#[derive(Resource, Debug, Clone, Copy, PartialEq)]
pub struct WindfallTime {
    /// Seconds since the world began.
    pub seconds: f64,
    /// Factor on the speed of [`Time`]; below 0 leaves rise to their twigs.
    pub speed: f64,
}

impl Default for WindfallTime {
    fn default() -> Self {
        Self { seconds: 0.0, speed: 1.0 }
    }
}

/// Lets a leaf go: it falls, lands and lies as any other.
#[derive(Message, Debug, Clone, Copy, PartialEq)]
pub struct ThrowLeaf {
    /// An entity with [`WindfallTree`] or [`WindfallForest`].
    pub tree: Entity,
    /// Of a forest's own trees, which: an index into [`PlantedTrees::instances`]. Unused of a [`WindfallTree`].
    pub instance: u32,
    /// The leaf: an index into `Foliage::leaves` of the model.
    pub leaf: u32,
    /// When, seconds of [`WindfallTime`]; `None`: now.
    pub time: Option<f64>,
}

/// Shakes a tree: leaves that would be the next to fall do so now.
#[derive(Message, Debug, Clone, Copy, PartialEq)]
pub struct ShakeTree {
    /// An entity with [`WindfallTree`] or [`WindfallForest`].
    pub tree: Entity,
    /// Of a forest's own trees, which. Unused of a [`WindfallTree`].
    pub instance: u32,
    /// How many leaves.
    pub leaves: u32,
    /// Within how many seconds.
    pub seconds: f32,
    /// From when on, seconds of [`WindfallTime`]; `None`: now.
    pub time: Option<f64>,
}

/// The trees that a [`WindfallForest`] has planted.
#[derive(Component, Debug, Clone, Default)]
pub struct PlantedTrees {
    pub(crate) instances: Arc<Vec<Instance>>,
    /// Counts how often the forest was made anew.
    pub(crate) version: u64,
}

impl PlantedTrees {
    /// Where they stand, metres from the forest's place.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }
}

/// The leaves of a forest that were thrown, by [`ThrowLeaf`] and [`ShakeTree`].
#[derive(Component, Debug, Clone, Default)]
pub struct ThrownLeaves {
    pub(crate) leaves: Vec<Thrown>,
}

impl ThrownLeaves {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.leaves.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.leaves.is_empty()
    }

    /// Puts all of them back on their twigs.
    pub fn clear(&mut self) {
        self.leaves.clear();
    }
}

/// A tree of a forest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum TreeKey {
    Instance(u32),
    Entity(Entity),
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Thrown {
    pub tree: TreeKey,
    pub leaf: u32,
    pub time: f64,
}

pub(crate) fn advance_clock(time: Res<Time>, mut clock: ResMut<WindfallTime>) {
    let step = time.delta_secs_f64() * clock.speed;
    if step != 0.0 {
        clock.seconds += step;
    }
}

/// Trees outside of forests get one.
pub(crate) fn shelter_lone_trees(
    mut commands: Commands,
    trees: Query<Entity, Added<WindfallTree>>,
    forests: Query<(), With<WindfallForest>>,
    parents: Query<&ChildOf>,
) {
    for tree in &trees {
        if forest_of(tree, &forests, &parents).is_none() {
            commands.entity(tree).insert(WindfallForest::default());
        }
    }
}

/// The forest that a tree stands in: the nearest one at or above it.
pub(crate) fn forest_of<D: bevy::ecs::query::QueryData, F: bevy::ecs::query::QueryFilter>(
    tree: Entity,
    forests: &Query<D, F>,
    parents: &Query<&ChildOf>,
) -> Option<Entity> {
    std::iter::once(tree).chain(parents.iter_ancestors(tree)).find(|e| forests.contains(*e))
}

pub(crate) fn plant(
    mut forests: Query<(NameOrEntity, &WindfallForest, &mut PlantedTrees), Changed<WindfallForest>>,
) {
    for (name, forest, mut planted) in &mut forests {
        planted.version += 1;
        planted.instances = Arc::new(forest.place().unwrap_or_else(|cause| {
            error!("forest {name}: {cause}; it has no trees of its own");
            Vec::new()
        }));
    }
}

/// A tree by an entity and an index, as messages have it.
struct Found<'a> {
    forest: Entity,
    key: TreeKey,
    model: &'a Handle<TreeModel>,
    instance: Instance,
}

pub(crate) fn throw(
    clock: Res<WindfallTime>,
    models: Res<Assets<TreeModel>>,
    mut throws: MessageReader<ThrowLeaf>,
    mut shakes: MessageReader<ShakeTree>,
    forests: Query<(&WindfallForest, &PlantedTrees, &WindfallWind, &GlobalTransform)>,
    trees: Query<(&WindfallTree, &GlobalTransform)>,
    parents: Query<&ChildOf>,
    mut thrown: Query<&mut ThrownLeaves>,
) {
    let find = |tree: Entity, index: u32| -> Result<Found<'_>, String> {
        if let Ok((of, place)) = trees.get(tree) {
            let forest = forest_of(tree, &forests, &parents)
                .ok_or_else(|| format!("tree {tree} stands in no forest yet"))?;
            let origin = forests.get(forest).map_or(Vec3::ZERO, |(_, _, _, at)| at.translation());
            let instance = instance_of(of, place, origin);
            return Ok(Found { forest, key: TreeKey::Entity(tree), model: &of.model, instance });
        }
        let (forest, planted, _, _) = forests
            .get(tree)
            .map_err(|_| format!("entity {tree} is neither a WindfallForest nor a WindfallTree"))?;
        let instances = planted.instances();
        let instance = *instances.get(index as usize).ok_or_else(|| {
            format!("tree {index} is not one of the {} of forest {tree}", instances.len())
        })?;
        let model = &forest.models[instance.model as usize];
        Ok(Found { forest: tree, key: TreeKey::Instance(index), model, instance })
    };
    let leaves_of = |found: &Found<'_>| {
        models.get(found.model).ok_or_else(|| "the tree's model is not loaded yet".to_owned())
    };
    for &ThrowLeaf { tree, instance, leaf, time } in throws.read() {
        let made = find(tree, instance).and_then(|found| {
            let count = leaves_of(&found)?.tree.foliage.leaves.len();
            if leaf as usize >= count {
                return Err(format!("leaf {leaf} is not one of the {count} of the tree"));
            }
            let time = time.unwrap_or(clock.seconds);
            if !time.is_finite() {
                return Err(format!("a leaf at {time} s: a time is finite"));
            }
            Ok((found.forest, Thrown { tree: found.key, leaf, time }))
        });
        match made {
            Ok((forest, leaf)) => {
                if let Ok(mut thrown) = thrown.get_mut(forest) {
                    thrown.leaves.push(leaf);
                }
            }
            Err(cause) => warn!("no leaf is thrown: {cause}"),
        }
    }
    for &ShakeTree { tree, instance, leaves, seconds, time } in shakes.read() {
        let from = time.unwrap_or(clock.seconds);
        let made = find(tree, instance).and_then(|found| {
            let foliage = &leaves_of(&found)?.tree.foliage;
            let Ok((forest, _, wind, _)) = forests.get(found.forest) else {
                return Err("its forest is not there yet".to_owned());
            };
            if !(from.is_finite() && seconds.is_finite()) {
                return Err(format!("from {from} s on within {seconds} s: both are finite"));
            }
            let count = foliage.leaves.len() as u32;
            let shed = forest.shedding.tree(&found.instance, count, &wind.0);
            let rate = Shedding::gust_rate(&wind.0);
            let gone = forest.shedding.detached(&shed, rate, from) as usize;
            Ok((found, &foliage.shed_order[gone..]))
        });
        match made {
            Ok((found, hanging)) => {
                let Ok(mut thrown) = thrown.get_mut(found.forest) else { continue };
                // Those that were shaken off before hang no more.
                let gone: std::collections::HashSet<u32> = thrown
                    .leaves
                    .iter()
                    .filter(|t| t.tree == found.key && t.time <= from + f64::from(seconds))
                    .map(|t| t.leaf)
                    .collect();
                let next = hanging.iter().filter(|leaf| !gone.contains(*leaf));
                for &leaf in next.take(leaves as usize) {
                    let late = unit(hash(found.instance.seed ^ SHAKEN, leaf)) * seconds.max(0.0);
                    let time = from + f64::from(late);
                    thrown.leaves.push(Thrown { tree: found.key, leaf, time });
                }
            }
            Err(cause) => warn!("no tree is shaken: {cause}"),
        }
    }
}

/// Keeps the draws of a shake apart from the tree's others.
const SHAKEN: u32 = 0x5a4e_0001;

/// A tree by itself as an instance, metres from its forest's place.
pub(crate) fn instance_of(tree: &WindfallTree, place: &GlobalTransform, origin: Vec3) -> Instance {
    let (scale, rotation, position) = place.to_scale_rotation_translation();
    let ahead = rotation * Vec3::Z;
    Instance {
        model: 0,
        position: position - origin,
        yaw: ahead.x.atan2(ahead.z),
        scale: scale.y.abs(),
        season_offset: tree.season_offset,
        seed: tree.seed,
    }
}
