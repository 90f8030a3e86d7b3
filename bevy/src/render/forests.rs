//! Forests in the render world: what the application wants of each, and the forest on the GPU that follows.

use crate::assets::{FallPaths, TreeModel};
use crate::forest::{
    LeafBudget, PlantedTrees, Season, Thrown, ThrownLeaves, TreeKey, WindfallForest, WindfallTime,
    WindfallTree, WindfallWind, forest_of, instance_of,
};
use crate::render::models::Models;
use bevy::camera::visibility::RenderLayers;
use bevy::ecs::entity::EntityHashMap;
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use bevy::render::Extract;
use bevy::render::renderer::RenderDevice;
use bevy::render::view::RetainedViewEntity;
use std::sync::Arc;
use windfall::forest::{Instance, Terrain};
use windfall::glam::DVec3;
use windfall::path::{FallSettings, PathSet, Variation};
use windfall::shed::Shedding;
use windfall::wind::Wind;
use windfall::{Falls, Forest, ForestError, TreeId, TreeModel as Uploaded, TreePlace, ViewState};

/// All forests, by the entity in the main world.
#[derive(Resource, Default)]
pub(crate) struct RenderForests {
    pub of: EntityHashMap<RenderForest>,
    /// The moment of the frame, seconds.
    pub time: f64,
    /// Counts frames.
    pub frame: u64,
}

/// What a forest is made of; where it changes the forest is made anew.
#[derive(Clone, PartialEq)]
struct Plan {
    version: u64,
    budget: u32,
    paths: Option<AssetId<FallPaths>>,
}

/// What the application wants of a forest.
pub(crate) struct Wanted {
    plan: Plan,
    instances: Arc<Vec<Instance>>,
    models: Vec<AssetId<TreeModel>>,
    terrain: Arc<Terrain>,
    shedding: Shedding,
    variation: Variation,
    settings: FallSettings,
    season: f32,
    wind: Wind,
    thrown: Vec<Thrown>,
    /// Trees by themselves: entity, model and place.
    trees: EntityHashMap<(AssetId<TreeModel>, Instance)>,
    /// Where it is in Bevy's world.
    pub origin: DVec3,
    pub visible: bool,
    pub layers: RenderLayers,
}

/// A forest on the GPU.
pub(crate) struct Live {
    pub forest: Forest,
    plan: Plan,
    paths_version: u64,
    models: Vec<Uploaded>,
    planted: Vec<TreeId>,
    trees: EntityHashMap<(TreeId, Uploaded, Instance)>,
    wind: Wind,
    /// How many of the thrown leaves it knows.
    thrown: usize,
    pub views: HashMap<RetainedViewEntity, SeenBy>,
}

/// What one camera, or one cascade of a light, keeps of a forest.
pub(crate) struct SeenBy {
    pub state: ViewState,
    pub frame: u64,
}

pub(crate) struct RenderForest {
    pub wanted: Wanted,
    pub live: Option<Live>,
    /// What went wrong last, so that it is said once.
    failed: Option<ForestError>,
}

impl RenderForest {
    /// Whether it is there as it is wanted.
    pub fn is_ready(&self) -> bool {
        let Some(live) = &self.live else { return self.failed.is_some() };
        live.plan == self.wanted.plan && live.trees.len() == self.wanted.trees.len()
    }

    pub fn fail(&mut self, entity: Entity, cause: ForestError) {
        if self.failed.as_ref() != Some(&cause) {
            error!("forest {entity}: {cause}");
            self.failed = Some(cause);
        }
    }

    /// Brings the forest on the GPU to what is wanted, as far as models are there.
    fn follow(&mut self, device: &RenderDevice, models: &Models) -> Result<(), ForestError> {
        if self.live.is_none() && self.failed.is_some() {
            // It would fail again.
            return Ok(());
        }
        let wanted = &self.wanted;
        let uploaded: Option<Vec<Uploaded>> =
            wanted.models.iter().map(|id| models.model(*id).cloned()).collect();
        let paths = match wanted.plan.paths {
            None => Some((0, None)),
            Some(id) => models.paths(id).map(|(version, paths)| (version, Some(paths))),
        };
        if let (Some(uploaded), Some((version, paths))) = (uploaded, paths) {
            let same = self.live.as_ref().is_some_and(|live| {
                live.plan == wanted.plan
                    && live.paths_version == version
                    && live.models == uploaded
                    && live.thrown <= wanted.thrown.len()
            });
            if !same {
                self.live = None;
                self.live = Some(Live::new(wanted, device, uploaded, (version, paths))?);
            }
        }
        match &mut self.live {
            Some(live) => live.follow(wanted, models),
            None => Ok(()),
        }
    }
}

impl Live {
    fn new(
        wanted: &Wanted,
        device: &RenderDevice,
        models: Vec<Uploaded>,
        (paths_version, paths): (u64, Option<&PathSet>),
    ) -> Result<Self, ForestError> {
        let falls = Falls {
            paths: paths.cloned().unwrap_or_else(PathSet::builtin),
            shedding: wanted.shedding,
            wind: wanted.wind,
            variation: wanted.variation.clone(),
            settings: wanted.settings,
            capacity: wanted.plan.budget,
        };
        let terrain = Terrain::clone(&wanted.terrain);
        // About an origin of its own: cameras are brought there, wherever Bevy's world has it.
        let mut forest = Forest::new(device.wgpu_device(), DVec3::ZERO, terrain, falls)?;
        let planted = forest.plant(&models, &wanted.instances)?;
        Ok(Self {
            forest,
            plan: wanted.plan.clone(),
            paths_version,
            models,
            planted,
            trees: EntityHashMap::default(),
            wind: wanted.wind,
            thrown: 0,
            views: HashMap::default(),
        })
    }

    fn follow(&mut self, wanted: &Wanted, models: &Models) -> Result<(), ForestError> {
        if self.forest.season() != wanted.season.clamp(0.0, 1.0) {
            self.forest.set_season(wanted.season)?;
        }
        if self.wind != wanted.wind {
            self.wind = wanted.wind;
            self.forest.set_wind(wanted.wind);
        }
        let gone = self.trees.extract_if(|entity, (_, model, instance)| {
            !wanted.trees.get(entity).is_some_and(|(id, wanted)| {
                let key = |i: &Instance| (i.seed, i.season_offset.to_bits());
                models.model(*id) == Some(&*model) && key(wanted) == key(instance)
            })
        });
        for (_, (id, _, _)) in gone.collect::<Vec<_>>() {
            self.forest.remove(id)?;
        }
        for (&entity, (id, instance)) in &wanted.trees {
            let position = instance.position.as_dvec3();
            match self.trees.get_mut(&entity) {
                Some((_, _, at)) if at == instance => {}
                Some((tree, _, at)) => {
                    self.forest.set_transform(*tree, position, instance.yaw, instance.scale)?;
                    *at = *instance;
                }
                None => {
                    let Some(model) = models.model(*id) else { continue };
                    let place = TreePlace {
                        position,
                        yaw: instance.yaw,
                        scale: instance.scale,
                        season_offset: instance.season_offset,
                        seed: instance.seed,
                    };
                    let tree = self.forest.insert(model, place)?;
                    // It may have been another model before: what was thrown of that is thrown of this.
                    self.thrown = 0;
                    self.trees.insert(entity, (tree, model.clone(), *instance));
                }
            }
        }
        while let Some(thrown) = wanted.thrown.get(self.thrown) {
            let tree = match thrown.tree {
                TreeKey::Instance(index) => self.planted.get(index as usize),
                TreeKey::Entity(entity) => match self.trees.get(&entity) {
                    Some((tree, _, _)) => Some(tree),
                    // It will come.
                    None if wanted.trees.contains_key(&entity) => break,
                    None => None,
                },
            };
            self.thrown += 1;
            // Leaves of trees that are gone are gone with them.
            if let Some(tree) = tree {
                self.forest.throw(*tree, thrown.leaf, thrown.time)?;
            }
        }
        Ok(())
    }
}

type ForestQuery = (
    Entity,
    Ref<'static, WindfallForest>,
    &'static PlantedTrees,
    &'static ThrownLeaves,
    (&'static Season, &'static WindfallWind, &'static LeafBudget),
    (&'static GlobalTransform, &'static InheritedVisibility, Option<&'static RenderLayers>),
);

/// Takes down what the application wants.
pub(crate) fn extract_forests(
    mut render: ResMut<RenderForests>,
    clock: Extract<Res<WindfallTime>>,
    forests: Extract<Query<ForestQuery>>,
    trees: Extract<Query<(Entity, &WindfallTree, &GlobalTransform)>>,
    parents: Extract<Query<&ChildOf>>,
) {
    render.time = clock.seconds;
    render.frame += 1;
    render.of.retain(|entity, _| forests.contains(*entity));
    for (entity, forest, planted, thrown, (season, wind, budget), (place, visible, layers)) in
        &forests
    {
        let plan = Plan {
            version: planted.version,
            budget: budget.0,
            paths: forest.paths.as_ref().map(Handle::id),
        };
        let render = render.of.entry(entity).or_insert_with(|| RenderForest {
            wanted: Wanted {
                plan: Plan { version: u64::MAX, ..plan.clone() },
                instances: Arc::default(),
                models: Vec::new(),
                terrain: forest.terrain.clone(),
                shedding: forest.shedding,
                variation: forest.variation.clone(),
                settings: forest.settings,
                season: season.0,
                wind: wind.0,
                thrown: Vec::new(),
                trees: EntityHashMap::default(),
                origin: DVec3::ZERO,
                visible: true,
                layers: RenderLayers::default(),
            },
            live: None,
            failed: None,
        });
        let wanted = &mut render.wanted;
        if wanted.plan != plan {
            wanted.instances = planted.instances.clone();
            wanted.models = forest.models.iter().map(Handle::id).collect();
            wanted.terrain = forest.terrain.clone();
            wanted.shedding = forest.shedding;
            wanted.variation = forest.variation.clone();
            wanted.settings = forest.settings;
            wanted.plan = plan;
            render.failed = None;
        }
        wanted.season = season.0;
        wanted.wind = wind.0;
        if thrown.leaves.len() < wanted.thrown.len() {
            wanted.thrown.clear();
        }
        wanted.thrown.extend_from_slice(&thrown.leaves[wanted.thrown.len()..]);
        wanted.origin = place.translation().as_dvec3();
        wanted.visible = visible.get();
        wanted.layers = layers.cloned().unwrap_or_default();
        wanted.trees.clear();
    }
    for (entity, tree, place) in &trees {
        let Some(forest) = forest_of(entity, &forests, &parents) else { continue };
        let Some(of) = render.of.get_mut(&forest) else { continue };
        let instance = instance_of(tree, place, of.wanted.origin.as_vec3());
        of.wanted.trees.insert(entity, (tree.model.id(), instance));
    }
}

/// Makes and changes forests on the GPU.
pub(crate) fn follow(
    mut forests: ResMut<RenderForests>,
    mut models: ResMut<Models>,
    device: Res<RenderDevice>,
) {
    models.poll();
    for (&entity, forest) in &mut forests.of {
        if let Err(cause) = forest.follow(&device, &models) {
            forest.fail(entity, cause);
        }
    }
}

/// Forgets cameras and lights that saw nothing in this frame.
pub(crate) fn forget_views(mut forests: ResMut<RenderForests>) {
    let frame = forests.frame;
    for live in forests.of.values_mut().filter_map(|forest| forest.live.as_mut()) {
        live.views.retain(|_, seen| seen.frame == frame);
    }
}
