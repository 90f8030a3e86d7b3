//! Tree models on the GPU: uploaded on tasks, as assets come, change and go.

use crate::assets::{FallPaths, TreeModel};
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use bevy::render::Extract;
use bevy::render::renderer::{RenderDevice, RenderQueue};
use bevy::tasks::{AsyncComputeTaskPool, Task, block_on};
use std::sync::Arc;
use windfall::path::PathSet;
use windfall::tree::Tree;
use windfall::{ModelError, TreeModel as Uploaded};

/// A model: what is drawn now, and what is being uploaded in its place.
#[derive(Default)]
struct Model {
    ready: Option<Uploaded>,
    task: Option<Task<Result<Uploaded, ModelError>>>,
}

/// Models and path sets in the render world, by asset.
#[derive(Resource, Default)]
pub(crate) struct Models {
    models: HashMap<AssetId<TreeModel>, Model>,
    /// Each with how often it has changed.
    paths: HashMap<AssetId<FallPaths>, (u64, PathSet)>,
    changes: u64,
}

impl Models {
    pub fn model(&self, id: AssetId<TreeModel>) -> Option<&Uploaded> {
        self.models.get(&id)?.ready.as_ref()
    }

    pub fn paths(&self, id: AssetId<FallPaths>) -> Option<(u64, &PathSet)> {
        self.paths.get(&id).map(|(version, paths)| (*version, paths))
    }

    /// How many are being uploaded.
    pub fn waiting(&self) -> usize {
        self.models.values().filter(|model| model.task.is_some()).count()
    }

    /// Takes what has been uploaded.
    pub fn poll(&mut self) {
        for model in self.models.values_mut() {
            let Some(task) = model.task.take_if(|task| task.is_finished()) else { continue };
            match block_on(task) {
                Ok(uploaded) => model.ready = Some(uploaded),
                Err(cause) => error!("no tree is drawn of a model: {cause}"),
            }
        }
    }

    fn upload(
        &mut self,
        id: AssetId<TreeModel>,
        tree: &Arc<Tree>,
        on: (&RenderDevice, &RenderQueue),
    ) {
        let (device, queue, tree) = (on.0.wgpu_device().clone(), on.1.clone(), tree.clone());
        let upload = async move { Uploaded::new(&device, &queue, &tree) };
        self.models.entry(id).or_default().task = Some(AsyncComputeTaskPool::get().spawn(upload));
    }
}

pub(crate) fn extract_models(
    mut models: ResMut<Models>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
    mut tree_events: Extract<MessageReader<AssetEvent<TreeModel>>>,
    trees: Extract<Res<Assets<TreeModel>>>,
    mut path_events: Extract<MessageReader<AssetEvent<FallPaths>>>,
    paths: Extract<Res<Assets<FallPaths>>>,
) {
    for event in tree_events.read() {
        match *event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                if let Some(model) = trees.get(id) {
                    models.upload(id, &model.tree, (&device, &queue));
                }
            }
            AssetEvent::Removed { id } => {
                models.models.remove(&id);
            }
            AssetEvent::Unused { .. } | AssetEvent::LoadedWithDependencies { .. } => {}
        }
    }
    for event in path_events.read() {
        match *event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                if let Some(FallPaths(set)) = paths.get(id) {
                    models.changes += 1;
                    let version = models.changes;
                    models.paths.insert(id, (version, set.clone()));
                }
            }
            AssetEvent::Removed { id } => {
                models.paths.remove(&id);
            }
            AssetEvent::Unused { .. } | AssetEvent::LoadedWithDependencies { .. } => {}
        }
    }
}
