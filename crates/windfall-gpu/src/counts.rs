//! Numbers of a frame back from the GPU.

use crate::base::capture::Readback;
use crate::base::constants::{TALLIES, TREE_TALLIES, VIEW_TALLIES};
use crate::scene::falls::Counter;
use crate::scene::forest::Forest;
use crate::view::state::ViewState;

/// The trees of a view, as they were drawn.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct TreeCounts {
    /// Trees in view.
    pub visible: u64,
    /// Their leaves, wherever they are.
    pub leaves: u64,
    /// `Σ λN` over them.
    pub leaves_by_lambda: u64,
    /// Leaves drawn on their twigs. Exact for trees in full; of simplified ones the expected number,
    /// since prune order and shed order do not depend on each other. Thrown leaves
    /// are counted as if they hung until the season takes them.
    pub leaves_hanging: u64,
    /// Triangles of wood and leaves that were drawn, those of leaves that have left their twigs
    /// included.
    pub triangles: u64,
    /// Trees that others or the ground hide, and that were left out for it ([`crate::Culling::Occlusion`]).
    pub hidden: u64,
    /// `Σ λN` over them: as many leaves as they would have drawn.
    pub hidden_leaves_by_lambda: u64,
}

impl TreeCounts {
    /// Leaves drawn over leaves of the trees in view; 1 where there are none.
    pub fn lambda_total(&self) -> f64 {
        if self.leaves == 0 { 1.0 } else { self.leaves_by_lambda as f64 / self.leaves as f64 }
    }
}

/// Where the leaves of a frame were, and what a view drew.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Leaves in the air, of the whole forest.
    pub falling: u32,
    /// Leaves in the air that were in view and drawn.
    pub falling_drawn: u32,
    /// Leaves on the ground, of the whole forest.
    pub landed: u32,
    /// Leaves on the ground that were in view and drawn.
    pub landed_drawn: u32,
    /// The trees.
    pub trees: TreeCounts,
}

/// A frame's [`Counts`] on their way to the CPU; used as [`crate::Capture`] is.
pub struct CountReadback {
    readback: Readback,
}

impl CountReadback {
    /// Records the copy, after the view was recorded; `None` if it never was.
    pub fn encode(
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        forest: &Forest,
        view: &ViewState,
    ) -> Option<Self> {
        let (of_forest, of_view) = (forest.buffers()?, view.buffers.as_ref()?);
        let [all, drawn, trees] =
            [TALLIES, VIEW_TALLIES, TREE_TALLIES].map(|words| u64::from(words) * 4);
        let readback = Readback::new(device, all + drawn + trees);
        let to = &readback.buffer;
        encoder.copy_buffer_to_buffer(&of_forest.loose.counters, 0, to, 0, all);
        encoder.copy_buffer_to_buffer(&of_view.loose.counters, 0, to, all, drawn);
        let lists = &of_view.lists;
        let first = lists.tallies_offset();
        encoder.copy_buffer_to_buffer(&lists.arguments, first, to, all + drawn, trees);
        Some(Self { readback })
    }

    /// Asks for the numbers. To be called once, after the encoder was submitted.
    pub fn map(&self) {
        self.readback.map();
    }

    /// The numbers, once they are here.
    ///
    /// # Errors
    ///
    /// [`wgpu::BufferAsyncError`] if the buffer could not be mapped: the device was lost.
    pub fn take(&self) -> Option<Result<Counts, wgpu::BufferAsyncError>> {
        self.readback.take(|mapped| {
            let word = |i: u32| {
                let at = 4 * i as usize;
                bytemuck::pod_read_unaligned::<u32>(&mapped[at..at + 4])
            };
            let tree = |i: u32| {
                let at = TALLIES + VIEW_TALLIES + 2 * i;
                u64::from(word(at)) | u64::from(word(at + 1)) << 32
            };
            Counts {
                falling: word(Counter::InAir as u32),
                landed: word(Counter::OnGround as u32),
                falling_drawn: word(TALLIES),
                landed_drawn: word(TALLIES + 1),
                trees: TreeCounts {
                    visible: tree(0),
                    leaves: tree(1),
                    leaves_by_lambda: tree(2),
                    leaves_hanging: tree(3),
                    triangles: tree(4),
                    hidden: tree(5),
                    hidden_leaves_by_lambda: tree(6),
                },
            }
        })
    }
}
