//! A stage on a device: uploaded, planted, its events thrown; its pictures and their counts.

use crate::{Elimination, LandingSearch, Stage, Strategy};
use glam::DVec3;
use std::sync::Arc;
use windfall_gpu::wgpu;
use windfall_gpu::{
    CountReadback, Falls, Forest, ForestError, Layer, ModelError, Moment, Picture, PictureTargets,
    Recording, Renderer, TreeCounts, TreeId, TreeModel, View, ViewError, ViewState,
};
use windfall_papers::{
    ListOptions, OcclusionReadback, PassOptions, PublishedError, PublishedFalls, PublishedPasses,
};

/// A stage in the memory of a GPU, for one view.
pub struct PlantedStage {
    /// The tree models, in the order of [`Stage::trees`].
    pub models: Vec<TreeModel>,
    /// The forest about the origin of the world, in its season, with the scene's events thrown.
    pub forest: Forest,
    /// Its trees, in the order of the stage's instances.
    pub trees: Vec<TreeId>,
    /// What draws its loose leaves in place of the renderer, unless they are [`Strategy::Compute`]'s.
    pub published: Option<PublishedFalls>,
}

/// Why a stage cannot be uploaded or drawn.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StageError {
    /// A model is too large.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The device does not hold the forest.
    #[error(transparent)]
    Forest(#[from] ForestError),
    /// The device does not hold the lists of a published strategy.
    #[error(transparent)]
    Published(#[from] PublishedError),
    /// The view cannot be drawn.
    #[error(transparent)]
    View(#[from] ViewError),
    /// An event is of a tree or leaf that there is not. [`Stage::check`] says it with the file's name.
    #[error("events[{index}]: {cause}")]
    Event {
        /// Its index in [`Stage::events`].
        index: usize,
        /// What is wrong with it.
        cause: String,
    },
}

impl Stage {
    /// Uploads the trees, plants them and throws the leaves of the events. Builds the pipelines of a
    /// published strategy, which takes a second or two.
    ///
    /// # Errors
    ///
    /// Trees or a forest that the device cannot hold; events of trees or leaves that there are not.
    pub fn upload(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<PlantedStage, StageError> {
        let upload = |tree| TreeModel::new(device, queue, tree);
        let models = self.trees.iter().map(upload).collect::<Result<_, _>>()?;
        self.plant(device, models)
    }

    /// [`Stage::upload`] with models that have been uploaded before: those of [`Stage::trees`], in order.
    ///
    /// # Errors
    ///
    /// Those of [`Stage::upload`]; models of another device, or fewer than the stage has trees.
    pub fn plant(
        &self,
        device: &wgpu::Device,
        models: Vec<TreeModel>,
    ) -> Result<PlantedStage, StageError> {
        let strategy = self.strategy.published();
        let mut falls = self.falls.clone();
        if strategy.is_some() {
            // The layer draws them.
            falls = Falls { capacity: 0, ..falls };
        }
        let terrain = self.forest.terrain.clone();
        let mut forest = Forest::new(device, DVec3::ZERO, terrain, falls)?;
        let trees = forest.plant(&models, &self.forest.instances)?;
        forest.set_season(self.season)?;
        for (index, event) in self.events.iter().enumerate() {
            let refused = |cause| StageError::Event { index, cause };
            self.check_event(event).map_err(refused)?;
            let thrown = forest.throw(trees[event.tree as usize], event.leaf, event.time);
            thrown.map_err(|error| refused(error.to_string()))?;
        }
        let published = strategy.map(|strategy| {
            let landing = self.landing_search.published();
            let occlusion = self.leaf_occlusion;
            let options = PassOptions { landing, occlusion, ..PassOptions::new(strategy) };
            let passes = PublishedPasses::new(device, options);
            let elimination = self.elimination.published(self.elimination_per_frame);
            let options = ListOptions { capacity: self.falls.capacity, elimination };
            PublishedFalls::new(&Arc::new(passes), &forest, options)
        });
        Ok(PlantedStage { published: published.transpose()?, models, forest, trees })
    }
}

impl PlantedStage {
    /// Records the forest's moment `time`, seconds, and a whole picture of it.
    ///
    /// # Errors
    ///
    /// [`StageError::Forest`] and [`StageError::View`], as [`Renderer::advance`] and [`Renderer::render`].
    pub fn render(
        &mut self,
        renderer: &Renderer,
        recording: &mut Recording<'_>,
        state: &mut ViewState,
        moment: (f64, &View),
        target: (&PictureTargets, &wgpu::TextureView),
    ) -> Result<(), StageError> {
        self.render_with(renderer, recording, state, moment, target, Vec::new())
    }

    /// [`PlantedStage::render`] with layers of the caller's, after the stage's own.
    ///
    /// # Errors
    ///
    /// Those of [`PlantedStage::render`].
    pub fn render_with(
        &mut self,
        renderer: &Renderer,
        recording: &mut Recording<'_>,
        state: &mut ViewState,
        (time, view): (f64, &View),
        (targets, output): (&PictureTargets, &wgpu::TextureView),
        others: Vec<&mut dyn Layer>,
    ) -> Result<(), StageError> {
        renderer.advance(recording, &mut self.forest, Moment::of(time, view))?;
        let mut layers: Vec<&mut dyn Layer> = Vec::new();
        layers.extend(self.published.as_mut().map(|falls| falls as &mut dyn Layer));
        layers.extend(others.into_iter().map(|layer| layer as &mut dyn Layer));
        let picture = Picture { targets, output, layers: &mut layers };
        Ok(renderer.render(recording, &self.forest, state, view, picture)?)
    }

    /// Records the copy of a frame's counts, after [`PlantedStage::render`]; `None` if nothing was drawn.
    pub fn count(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        state: &ViewState,
    ) -> Option<StageReadback> {
        let counts = CountReadback::encode(device, encoder, &self.forest, state)?;
        let published = self.published.as_ref();
        Some(StageReadback {
            counts,
            lists: published.map(PublishedFalls::counts).unwrap_or_default(),
            occlusion: published.and_then(|falls| falls.count_occlusion(encoder)),
        })
    }
}

/// Leaves and trees of a frame, whatever draws the loose leaves.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StageCounts {
    /// The trees.
    pub trees: TreeCounts,
    /// Leaves in the air, of the whole forest.
    pub falling: u64,
    /// Leaves in the air that were drawn. The published strategies draw those too that are not in view.
    pub falling_drawn: u64,
    /// Leaves on the ground, of the whole forest.
    pub landed: u64,
    /// Landed leaves that a published strategy takes for static geometry.
    pub eliminated: u64,
    /// Leaves that elimination looked at in this frame.
    pub checked: u64,
    /// Leaves that leaf occlusion drew and tested.
    pub tested: u32,
    /// Leaves that leaf occlusion did not draw.
    pub skipped: u32,
}

/// A frame's [`StageCounts`] on their way to the CPU; used as [`windfall_gpu::Capture`] is.
pub struct StageReadback {
    counts: CountReadback,
    lists: windfall_papers::LeafCounts,
    occlusion: Option<OcclusionReadback>,
}

impl StageReadback {
    /// Asks for the numbers. To be called once, after the encoder was submitted.
    pub fn map(&self) {
        self.counts.map();
        if let Some(occlusion) = &self.occlusion {
            occlusion.map();
        }
    }

    /// The numbers, once they are here; once.
    ///
    /// # Errors
    ///
    /// [`wgpu::BufferAsyncError`] if a buffer could not be mapped: the device was lost.
    pub fn take(&self) -> Option<Result<StageCounts, wgpu::BufferAsyncError>> {
        let occlusion = match &self.occlusion {
            Some(occlusion) => occlusion.take()?,
            None => Ok(Default::default()),
        };
        let counts = self.counts.take()?;
        let lists = self.lists;
        Some(counts.and_then(|counts| {
            let occlusion = occlusion?;
            let listed_drawn = lists.falling.saturating_sub(u64::from(occlusion.skipped));
            Ok(StageCounts {
                trees: counts.trees,
                falling: u64::from(counts.falling) + lists.falling,
                falling_drawn: u64::from(counts.falling_drawn) + listed_drawn,
                landed: u64::from(counts.landed) + lists.landed,
                eliminated: lists.eliminated,
                checked: lists.checked,
                tested: occlusion.tested,
                skipped: occlusion.skipped,
            })
        }))
    }
}

impl Strategy {
    /// The published strategy of this name; `None` for [`Strategy::Compute`], which is the renderer's own.
    pub fn published(self) -> Option<windfall_papers::Strategy> {
        match self {
            Self::Vertex => Some(windfall_papers::Strategy::Vertex),
            Self::Fragment => Some(windfall_papers::Strategy::Fragment),
            Self::VertexBuffer => Some(windfall_papers::Strategy::VertexBuffer),
            Self::Cpu => Some(windfall_papers::Strategy::Cpu),
            Self::Compute => None,
        }
    }
}

impl LandingSearch {
    /// As the published strategies take it.
    pub fn published(self) -> windfall_papers::LandingSearch {
        match self {
            Self::Ahead => windfall_papers::LandingSearch::Ahead,
            Self::InShader => windfall_papers::LandingSearch::InShader,
        }
    }
}

impl Elimination {
    /// As the published strategies take it: [`Elimination::Progressive`] tests `per_frame` leaves in a
    /// frame.
    pub fn published(self, per_frame: u32) -> windfall_papers::Elimination {
        match self {
            Self::Off => windfall_papers::Elimination::Off,
            Self::Progressive => windfall_papers::Elimination::Progressive { per_frame },
            Self::Scheduled => windfall_papers::Elimination::Scheduled,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::named;

    #[test]
    fn choices_have_the_names_and_defaults_of_what_they_choose() {
        for strategy in Strategy::ALL {
            let name = strategy.published().map_or("compute", |s| s.name());
            assert_eq!(strategy.name(), name);
        }
        for elimination in Elimination::ALL {
            assert_eq!(elimination.name(), elimination.published(7).name());
        }
        let published = |elimination: Elimination| {
            elimination.published(named("autumn").unwrap().elimination_per_frame)
        };
        assert_eq!(published(Elimination::default()), windfall_papers::Elimination::default());
        let progressive = published(Elimination::Progressive);
        assert_eq!(progressive, windfall_papers::Elimination::PROGRESSIVE);
    }
}
