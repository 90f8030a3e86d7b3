//! The leaves of a forest in the order in which they detach.
//!
//! The leaves of one shape on one tree, in shed order, are a *stream*, as in `windfall_gpu::scene::streams`. The
//! detached ones are a prefix of it, of which the last `keep` are drawn: entry `j` has slot `j % keep`.

use glam::Vec3;
use std::collections::BTreeMap;
use windfall_core::shed::TreeShedding;
use windfall_gpu::internals::shared::{LeafRecord, TreeRecord};
use windfall_gpu::{Forest, TreeModel};

/// The leaves of one shape on one tree.
#[derive(Debug, Clone)]
pub struct Stream {
    pub tree: TreeRecord,
    /// Index into [`Streams::batches`].
    pub batch: u32,
    pub path_group: u32,
    /// Leaves of this shape.
    pub count: u32,
    /// First slot.
    pub slot_first: u32,
    /// Slots, at least 1.
    pub keep: u32,
    /// Index into [`Streams::scripted`].
    scripted: Option<u32>,
}

/// A draw: the leaves of one shape of one model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Batch {
    pub model: usize,
    pub shape: usize,
    /// Slots of its streams.
    pub slots: u32,
}

/// All streams of a forest.
pub struct Streams {
    pub models: Vec<TreeModel>,
    pub batches: Vec<Batch>,
    pub all: Vec<Stream>,
    pub slot_count: u32,
    /// When scripted leaves detach, by leaf.
    scripted: Vec<BTreeMap<u32, f32>>,
}

impl Streams {
    /// The streams of a forest in which each keeps the same share of its leaves: `capacity` in all, rounded up for
    /// each stream.
    pub fn new(forest: &Forest, capacity: u32) -> Self {
        let models: Vec<TreeModel> = forest.models().cloned().collect();
        let leaves = forest.totals().leaves;
        let share = (f64::from(capacity) / leaves.max(1) as f64).min(1.0);
        let groups: Vec<u32> =
            models.iter().map(|model| forest.falls().group_of(model.name())).collect();
        let mut batches = Vec::new();
        let mut first_batch = Vec::new();
        for (m, model) in models.iter().enumerate() {
            first_batch.push(batches.len());
            let shapes = 0..model.loose.shapes.len();
            batches.extend(shapes.map(|shape| Batch { model: m, shape, slots: 0 }));
        }
        let mut out =
            Self { models, batches, all: Vec::new(), slot_count: 0, scripted: Vec::new() };
        for (tree, thrown) in forest.tree_records() {
            let scripted = (!thrown.is_empty()).then(|| {
                out.scripted.push(thrown.iter().copied().collect());
                out.scripted.len() as u32 - 1
            });
            let model = tree.model as usize;
            for (s, shape) in out.models[model].loose.shapes.iter().enumerate() {
                let count = shape.shed_order.len() as u32;
                let keep = (f64::from(count) * share).ceil() as u32;
                if keep == 0 {
                    continue;
                }
                let batch = first_batch[model] + s;
                out.batches[batch].slots += keep;
                out.all.push(Stream {
                    tree,
                    batch: batch as u32,
                    path_group: groups[model],
                    count,
                    slot_first: out.slot_count,
                    keep,
                    scripted,
                });
                out.slot_count += keep;
            }
        }
        out
    }

    /// The model of a stream's tree.
    pub fn model(&self, stream: &Stream) -> &TreeModel {
        &self.models[stream.tree.model as usize]
    }

    /// Index in the model of the leaf of an entry.
    fn leaf(&self, stream: &Stream, entry: u32) -> u32 {
        let Batch { model, shape, .. } = self.batches[stream.batch as usize];
        self.models[model].loose.shapes[shape].shed_order[entry as usize]
    }

    /// The leaf of an entry.
    pub fn record(&self, stream: &Stream, entry: u32) -> &LeafRecord {
        &self.model(stream).loose.records[self.leaf(stream, entry) as usize]
    }

    /// When a program lets the leaf of an entry detach, seconds on the forest's clock, if it does.
    pub fn scripted_time(&self, stream: &Stream, entry: u32) -> Option<f32> {
        let leaves = &self.scripted[stream.scripted? as usize];
        leaves.get(&self.leaf(stream, entry)).copied()
    }

    /// Radius of a stream's shape, metres at scale 1.
    pub fn radius(&self, stream: &Stream) -> f32 {
        let Batch { model, shape, .. } = self.batches[stream.batch as usize];
        self.models[model].loose.shapes[shape].radius
    }

    /// Half the thickness of a stream's shape, metres at scale 1.
    pub fn thickness(&self, stream: &Stream) -> f32 {
        let Batch { model, shape, .. } = self.batches[stream.batch as usize];
        self.models[model].loose.shapes[shape].thickness
    }

    /// Whether a stream's shape has a version in two triangles.
    pub fn can_be_small(&self, stream: &Stream) -> bool {
        let Batch { model, shape, .. } = self.batches[stream.batch as usize];
        self.models[model].loose.shapes[shape].small.is_some()
    }

    /// What a stream's detach times depend on.
    pub fn shedding(&self, stream: &Stream) -> TreeShedding {
        TreeShedding {
            delay: stream.tree.delay,
            gust_phase: stream.tree.gust_phase,
            seed: stream.tree.seed,
            leaves: self.model(stream).leaf_count(),
        }
    }
}

impl Stream {
    /// The slot of an entry.
    pub fn slot(&self, entry: u32) -> usize {
        (self.slot_first + entry % self.keep) as usize
    }

    /// The region of the lists that has its leaves: each batch has one for full and one for small leaves.
    pub fn region(&self, small: bool) -> usize {
        2 * self.batch as usize + usize::from(small)
    }
}

/// A direction of the tree in the world.
pub fn turned(tree: &TreeRecord, v: Vec3) -> Vec3 {
    let (s, c) = (tree.sin_yaw, tree.cos_yaw);
    Vec3::new(c * v.x + s * v.z, v.y, c * v.z - s * v.x)
}

/// A point of the tree in the world.
pub fn world_from_tree(tree: &TreeRecord, v: Vec3) -> Vec3 {
    tree.position + turned(tree, v) * tree.scale
}
