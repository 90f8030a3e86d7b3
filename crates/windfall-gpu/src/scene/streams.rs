//! Streams of leaves, their slots, and the draws that they belong to.
//!
//! A forest has places for so many trees of each model, and every place of a model has the same streams, slots
//! and workgroups: what a tree at a place needs is found by arithmetic, and a tree that comes or goes changes
//! nothing of the others. Thrown leaves have streams of their own, each of one tree, taken from a pool that each
//! draw has.

use crate::base::constants::GROUP;
use crate::base::shared::{Stream, TreeRecord};
use crate::scene::falls::Bin;
use crate::scene::model::TreeModel;
use bytemuck::Zeroable;

/// Leaves of a stream of thrown leaves.
pub const SCRIPTED_ROOM: u32 = 32;

/// The shed lists of a model's shape, and where its places have their streams.
#[derive(Debug, Clone, Copy)]
struct ShapePlan {
    list_count: u32,
    /// Slots of a place; 0 where no leaf of it falls by itself.
    keep: u32,
    stream_first: u32,
    /// First stream, slot, group and word of the list of the pool for thrown leaves.
    pool: Pool,
}

#[derive(Debug, Clone, Copy, Default)]
struct Pool {
    streams: u32,
    stream_first: u32,
    list_first: u32,
    /// Streams of it that are in use.
    used: u32,
}

/// All streams of a forest.
pub struct Streams {
    pub all: Vec<Stream>,
    pub bins: Vec<Bin>,
    /// For each workgroup of [`GROUP`] slots its stream, and the first of them there.
    pub groups: Vec<[u32; 2]>,
    pub slot_count: u32,
    /// Leaves in shed order by model and shape; then the leaves and times of thrown ones.
    pub shed_lists: Vec<u32>,
    /// By model, then by shape.
    plans: Vec<Vec<ShapePlan>>,
}

/// What is planned for a model.
#[derive(Debug, Clone, Copy)]
pub struct Room {
    /// Places for trees.
    pub places: u32,
    /// Streams for thrown leaves, for each shape.
    pub scripted: u32,
    /// Group of paths.
    pub path_group: u32,
}

impl Streams {
    /// Streams of models with such room; `share` of the leaves of a tree have a slot.
    pub fn new(models: &[(TreeModel, Room)], share: f64) -> Self {
        let mut out = Self {
            all: Vec::new(),
            bins: Vec::new(),
            groups: Vec::new(),
            slot_count: 0,
            shed_lists: Vec::new(),
            plans: Vec::new(),
        };
        let mut leaf_first = 0;
        for (m, (model, room)) in models.iter().enumerate() {
            let plans = (0..model.loose.shapes.len())
                .map(|s| out.plan(m, model, s, room, (leaf_first, share)))
                .collect();
            out.plans.push(plans);
            leaf_first += model.leaf_count;
        }
        out
    }

    fn plan(
        &mut self,
        m: usize,
        model: &TreeModel,
        s: usize,
        room: &Room,
        (leaf_first, share): (u32, f64),
    ) -> ShapePlan {
        let shape = &model.loose.shapes[s];
        let list_first = self.shed_lists.len() as u32;
        let list_count = shape.shed_order.len() as u32;
        self.shed_lists.extend(&shape.shed_order);
        let keep = (f64::from(list_count) * share).ceil() as u32;
        let bin = self.bins.len() as u32;
        let first = self.slot_count;
        let empty = Stream {
            leaf_count: model.leaf_count,
            model: m as u32,
            bin,
            path_group: room.path_group,
            leaf_first,
            bin_first: first,
            thickness: shape.thickness,
            radius: shape.radius,
            simple: u32::from(shape.small.is_some()),
            ..Stream::zeroed()
        };
        let stream_first = self.all.len() as u32;
        if keep > 0 {
            for _ in 0..room.places {
                self.push(Stream { list_first, keep, ..empty });
            }
        }
        let mut pool = Pool {
            streams: if list_count > 0 { room.scripted } else { 0 },
            stream_first: self.all.len() as u32,
            list_first: self.shed_lists.len() as u32,
            used: 0,
        };
        for i in 0..pool.streams {
            // The leaves, then their times: so many words each.
            let list_first = pool.list_first + 2 * SCRIPTED_ROOM * i;
            self.push(Stream { list_first, keep: SCRIPTED_ROOM, thrown: 1, ..empty });
        }
        self.shed_lists
            .resize(self.shed_lists.len() + (2 * SCRIPTED_ROOM * pool.streams) as usize, 0);
        if self.slot_count > first {
            let count = self.slot_count - first;
            self.bins.push(Bin { model: m, shape: s, first, count });
        } else {
            pool.streams = 0;
        }
        ShapePlan { list_count, keep, stream_first, pool }
    }

    /// Adds a stream with its slots; it is empty until a tree stands at its place.
    fn push(&mut self, stream: Stream) {
        let index = self.all.len() as u32;
        let group_first = self.groups.len() as u32;
        self.all.push(Stream { slot_first: self.slot_count, group_first, ..stream });
        let firsts = (0..stream.keep).step_by(GROUP as usize);
        self.groups.extend(firsts.map(|first| [index, first]));
        self.slot_count += stream.keep;
    }

    /// The streams of a place.
    pub fn of_place(&self, model: usize, place: u32) -> impl Iterator<Item = u32> + '_ {
        let planned = self.plans[model].iter().filter(|plan| plan.keep > 0);
        planned.map(move |plan| plan.stream_first + place)
    }

    /// Puts a tree at a place, or (`None`) takes it away.
    pub fn set_place(&mut self, model: usize, place: u32, tree: Option<&TreeRecord>) {
        for plan in &self.plans[model] {
            if plan.keep == 0 {
                continue;
            }
            let stream = &mut self.all[(plan.stream_first + place) as usize];
            match tree {
                Some(tree) => {
                    *stream = Stream { list_count: plan.list_count, ..of_tree(*stream, tree) };
                }
                None => stream.list_count = 0,
            }
        }
    }

    /// Adds a thrown leaf of a tree. Returns the stream that has it; `None` where the pool has no room.
    pub fn throw(
        &mut self,
        (model, shape): (usize, usize),
        tree: &TreeRecord,
        leaf: u32,
        time: f32,
    ) -> Option<u32> {
        let pool = self.plans[model][shape].pool;
        let used = pool.stream_first..pool.stream_first + pool.used;
        let of_tree_and_free = |i: &u32| {
            let s = &self.all[*i as usize];
            s.position == tree.position && s.seed == tree.seed && s.list_count < SCRIPTED_ROOM
        };
        let empty = |i: &u32| self.all[*i as usize].list_count == 0;
        let index = if let Some(index) = used.clone().find(of_tree_and_free) {
            index
        } else {
            let free = used.clone().find(empty);
            let index = free.or_else(|| (pool.used < pool.streams).then_some(used.end))?;
            self.plans[model][shape].pool.used += u32::from(index == used.end);
            let stream = &mut self.all[index as usize];
            *stream = Stream { list_count: 0, ..of_tree(*stream, tree) };
            index
        };
        let stream = &self.all[index as usize];
        let (first, count) = (stream.list_first as usize, stream.list_count as usize);
        // The times stand right behind the leaves: both move as the list grows.
        let list = &self.shed_lists[first..first + 2 * count];
        let mut entries: Vec<(f32, u32)> =
            (0..count).map(|i| (f32::from_bits(list[count + i]), list[i])).collect();
        let at = entries.partition_point(|e| *e <= (time, leaf));
        entries.insert(at, (time, leaf));
        for (i, (time, leaf)) in entries.iter().enumerate() {
            self.shed_lists[first + i] = *leaf;
            self.shed_lists[first + count + 1 + i] = time.to_bits();
        }
        self.all[index as usize].list_count += 1;
        Some(index)
    }

    /// Takes the thrown leaves of a tree away; returns their streams.
    pub fn clear_thrown(&mut self, model: usize, tree: &TreeRecord) -> Vec<u32> {
        let mut cleared = Vec::new();
        for plan in &self.plans[model] {
            for i in plan.pool.stream_first..plan.pool.stream_first + plan.pool.used {
                let stream = &mut self.all[i as usize];
                if stream.position == tree.position && stream.seed == tree.seed {
                    stream.list_count = 0;
                    cleared.push(i);
                }
            }
        }
        cleared
    }

    /// Words of the shed lists that a stream of thrown leaves has.
    pub fn words_of(&self, stream: u32) -> std::ops::Range<u32> {
        let first = self.all[stream as usize].list_first;
        first..first + 2 * SCRIPTED_ROOM
    }
}

/// A stream as that of a tree.
fn of_tree(stream: Stream, tree: &TreeRecord) -> Stream {
    Stream {
        position: tree.position,
        scale: tree.scale,
        cos_yaw: tree.cos_yaw,
        sin_yaw: tree.sin_yaw,
        season_offset: tree.season_offset,
        seed: tree.seed,
        delay: tree.delay,
        gust_phase: tree.gust_phase,
        events: tree.index_events & 1,
        tree: tree.index_events >> 1,
        ..stream
    }
}
