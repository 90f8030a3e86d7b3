//! The loose leaves of a forest, drawn by a published strategy.

pub use crate::active_leaves::LeafCounts;
use crate::buffers::{LeafBuffers, check_size, path_samples};
use crate::options::{ListOptions, Strategy};
use crate::pass::PublishedPasses;
use crate::pass::occlusion::TALLY_BYTES;
use crate::streams::Streams;
use std::sync::Arc;
use windfall_gpu::internals::Readback;
use windfall_gpu::{DebugView, Forest, Layer, LayerFrame, Recording, SceneTextures};

/// Why a forest's leaves cannot be drawn by a published strategy.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PublishedError {
    /// The renderer draws the forest's loose leaves too.
    #[error(
        "the forest keeps up to {capacity} loose leaves itself and they would be drawn twice: make it with \
         `Falls {{ capacity: 0, .. }}`"
    )]
    DrawnTwice {
        /// The forest's [`windfall_gpu::Falls::capacity`].
        capacity: u32,
    },
    /// The paths do not fit into one-dimensional textures.
    #[error(
        "the paths have {samples} samples, once for each of their continuity points; a one-dimensional texture has at most \
         {limit}: take fewer or shorter paths, or `PathData::Table`"
    )]
    LongPaths {
        /// Samples of all paths.
        samples: u32,
        /// The device's limit.
        limit: u32,
    },
    /// The lists do not fit on the device.
    #[error(
        "strategy {strategy} with {slots} leaves needs a {what} of {size}, the device has at most {limit}: set a lower \
         capacity"
    )]
    TooManyLeaves {
        /// The strategy.
        strategy: Strategy,
        /// Leaves in the air and on the ground.
        slots: u32,
        /// What would be too large.
        what: &'static str,
        /// Its size: bytes of a buffer, rows of a texture.
        size: u64,
        /// The device's limit.
        limit: u64,
    },
}

/// The leaves of a forest that the season has taken off their twigs, drawn by a published strategy into one view.
///
/// The forest must not draw them itself: its [`windfall_gpu::Falls::capacity`] is 0, everything else of its `Falls` is as for the
/// renderer's own compute path. Leaves that a program throws ([`Forest::throw`]) are drawn by the forest.
///
/// Follows every change of the forest; a change of trees, thrown leaves, wind or shedding rebuilds the lists. Drawn
/// with another forest than before, it starts anew for that. Any order of moments gives the same pictures, but for
/// leaf occlusion, which learns from one frame for the next.
///
/// It draws every loose leaf whatever share of its tree's leaves the view keeps: only the choice between full
/// and small shapes follows the view's detail.
pub struct PublishedFalls {
    passes: Arc<PublishedPasses>,
    options: ListOptions,
    /// The forest that `leaves` are of, and its revision.
    source: Option<(u64, u64)>,
    leaves: Option<LeafBuffers>,
}

impl PublishedFalls {
    /// For a forest. The lists are built by the first frame.
    ///
    /// # Errors
    ///
    /// [`PublishedError`], if the forest draws its loose leaves itself, or lists of `options.capacity` leaves or the
    /// paths would not fit on the device. If a forest outgrows the device later, fewer leaves are kept; none with paths
    /// that are too long.
    pub fn new(
        passes: &Arc<PublishedPasses>,
        forest: &Forest,
        options: ListOptions,
    ) -> Result<Self, PublishedError> {
        let capacity = forest.falls().capacity;
        if capacity > 0 {
            return Err(PublishedError::DrawnTwice { capacity });
        }
        if passes.options().one_dimensional() {
            let samples = path_samples(forest);
            let limit = passes.device.limits().max_texture_dimension_1d;
            if samples > limit {
                return Err(PublishedError::LongPaths { samples, limit });
            }
        }
        let streams = Streams::new(forest, options.capacity);
        let strategy = passes.strategy();
        check_size(&passes.device.limits(), &streams, strategy).map_err(
            |(what, size, limit)| {
                let slots = streams.slot_count;
                PublishedError::TooManyLeaves { strategy, slots, what, size, limit }
            },
        )?;
        Ok(Self { passes: Arc::clone(passes), options, source: None, leaves: None })
    }

    /// The strategy.
    pub fn strategy(&self) -> Strategy {
        self.passes.strategy()
    }

    /// How its lists are kept.
    pub fn options(&self) -> &ListOptions {
        &self.options
    }

    /// Leaves of the frame that was recorded last, of the whole forest; none before the first.
    pub fn counts(&self) -> LeafCounts {
        self.leaves.as_ref().map_or_else(LeafCounts::default, |leaves| leaves.lists.counts())
    }

    /// Records a copy of the numbers of tested and skipped leaves, after the picture was recorded; `None` without leaf
    /// occlusion.
    pub fn count_occlusion(&self, encoder: &mut wgpu::CommandEncoder) -> Option<OcclusionReadback> {
        let states = &self.leaves.as_ref()?.visibility.as_ref()?.states;
        let readback = Readback::new(&self.passes.device, TALLY_BYTES);
        let from = states.size() - TALLY_BYTES;
        encoder.copy_buffer_to_buffer(states, from, &readback.buffer, 0, TALLY_BYTES);
        Some(OcclusionReadback { readback })
    }

    /// Rebuilds the lists if the forest is another one or has changed.
    fn sync(&mut self, queue: &wgpu::Queue, forest: &Forest) {
        let source = forest.revision();
        if self.source == Some(source) && self.leaves.is_some() {
            return;
        }
        let limits = self.passes.device.limits();
        let mut capacity = self.options.capacity;
        if self.passes.options().one_dimensional()
            && path_samples(forest) > limits.max_texture_dimension_1d
        {
            capacity = 0;
        }
        let mut streams = Streams::new(forest, capacity);
        while capacity > 0 && check_size(&limits, &streams, self.passes.strategy()).is_err() {
            capacity /= 2;
            streams = Streams::new(forest, capacity);
        }
        self.leaves = Some(LeafBuffers::new(queue, &self.passes, forest, streams, &self.options));
        self.source = Some(source);
    }
}

impl Layer for PublishedFalls {
    fn prepare(&mut self, recording: &mut Recording<'_>, frame: &LayerFrame<'_>) {
        self.sync(recording.queue, frame.forest);
        let Some(leaves) = &mut self.leaves else { return };
        leaves.update(recording, &self.passes, frame.forest, frame.tree_list());
        if let (Some(occlusion), Some(visibility)) = (&self.passes.occlusion, &leaves.visibility) {
            occlusion.update(recording, frame.group, (leaves, visibility));
        }
        self.passes.pose(recording, frame.group, leaves);
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, _: &LayerFrame<'_>) {
        if let Some(leaves) = &self.leaves {
            self.passes.draw(pass, leaves, false);
        }
    }

    fn draw_shadow(&self, pass: &mut wgpu::RenderPass<'_>, _: &LayerFrame<'_>, _: usize) {
        if let Some(leaves) = &self.leaves {
            self.passes.draw(pass, leaves, true);
        }
    }

    fn finish(
        &mut self,
        recording: &mut Recording<'_>,
        frame: &LayerFrame<'_>,
        scene: &SceneTextures<'_>,
    ) {
        let (Some(leaves), Some(occlusion)) = (&mut self.leaves, &self.passes.occlusion) else {
            return;
        };
        if let Some(visibility) = &mut leaves.visibility {
            visibility.bind_depth(&self.passes.device, occlusion, scene.depth);
        }
        if let Some(visibility) = &leaves.visibility {
            let show = frame.view.show == DebugView::Occlusion;
            occlusion.count(recording, frame.group, (leaves, visibility), scene, show);
        }
    }

    fn reads_depth(&self) -> bool {
        self.passes.leaf_occlusion()
    }
}

/// What leaf occlusion did with the leaves in the air in a frame. All others were drawn untested.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct OcclusionCounts {
    /// Leaves that were drawn, and their pixels counted.
    pub tested: u32,
    /// Leaves that were not drawn.
    pub skipped: u32,
}

/// A frame's [`OcclusionCounts`] on their way to the CPU; used as [`windfall_gpu::Capture`] is.
pub struct OcclusionReadback {
    readback: Readback,
}

impl OcclusionReadback {
    /// Asks for the numbers. To be called once, after the encoder was submitted.
    pub fn map(&self) {
        self.readback.map();
    }

    /// The numbers, once they are here.
    ///
    /// # Errors
    ///
    /// [`wgpu::BufferAsyncError`] if the buffer could not be mapped: the device was lost.
    pub fn take(&self) -> Option<Result<OcclusionCounts, wgpu::BufferAsyncError>> {
        self.readback.take(|mapped| {
            let word = |i: usize| bytemuck::pod_read_unaligned::<u32>(&mapped[4 * i..4 * i + 4]);
            OcclusionCounts { tested: word(0), skipped: word(1) }
        })
    }
}
