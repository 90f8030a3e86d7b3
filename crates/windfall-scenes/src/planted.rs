//! A stage on a device: uploaded, planted, its events thrown.

use crate::Stage;
use glam::DVec3;
use windfall_gpu::wgpu;
use windfall_gpu::{Forest, ForestError, ModelError, TreeId, TreeModel};

/// A stage in the memory of a GPU.
pub struct PlantedStage {
    /// The tree models, in the order of [`Stage::trees`].
    pub models: Vec<TreeModel>,
    /// The forest about the origin of the world, in its season, with the scene's events thrown.
    pub forest: Forest,
    /// Its trees, in the order of the stage's instances.
    pub trees: Vec<TreeId>,
}

/// Why a stage cannot be uploaded.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlantError {
    /// A model is too large.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The forest has no place for its trees.
    #[error(transparent)]
    Forest(#[from] ForestError),
    /// An event is of no tree or leaf that there is: [`Stage::check`] says it with the file's name.
    #[error("events[{index}]: {cause}")]
    Event {
        /// Its index in [`Stage::events`].
        index: usize,
        /// What is wrong with it.
        cause: String,
    },
}

impl Stage {
    /// Uploads the trees, plants them and throws the leaves of the events.
    ///
    /// # Errors
    ///
    /// Trees or a forest that the device cannot hold; events of trees or leaves that there are not.
    pub fn upload(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<PlantedStage, PlantError> {
        let models = self
            .trees
            .iter()
            .map(|tree| TreeModel::new(device, queue, tree))
            .collect::<Result<Vec<_>, _>>()?;
        self.plant(device, models)
    }

    /// [`Stage::upload`] with models that are uploaded already: those of another stage of the same trees.
    ///
    /// # Errors
    ///
    /// Those of [`Stage::upload`], and models of another device, or fewer than the stage has.
    pub fn plant(
        &self,
        device: &wgpu::Device,
        models: Vec<TreeModel>,
    ) -> Result<PlantedStage, PlantError> {
        let terrain = self.forest.terrain.clone();
        let mut forest = Forest::new(device, DVec3::ZERO, terrain, self.falls.clone())?;
        let trees = forest.plant(&models, &self.forest.instances)?;
        forest.set_season(self.season)?;
        for (index, event) in self.events.iter().enumerate() {
            let refused = |cause| PlantError::Event { index, cause };
            self.check_event(event).map_err(refused)?;
            let thrown = forest.throw(trees[event.tree as usize], event.leaf, event.time);
            thrown.map_err(|error| refused(error.to_string()))?;
        }
        Ok(PlantedStage { models, forest, trees })
    }
}
