//! The active-leaf list: the leaves that have left their twigs, kept by the CPU (VB 5).
//!
//! The lists are a function of the moment alone. Playing forward adds detached leaves and moves landed ones to the
//! litter; any other change of time, season or forest starts anew. Streams and slots are those of the renderer's
//! compute path, so that both keep the same leaves.

use crate::arena::Arena;
use crate::eye::{Eye, distance_to_segment};
use crate::look::{from_octahedral, from_snorm8, litter_leaf, ripeness, unpack_rotation};
use crate::options::{Elimination, LandingSearch, PassOptions, Strategy};
use crate::shared::{FallingLeaf, LitterLeaf};
use crate::streams::{Stream, Streams, turned, world_from_tree};
use glam::{Quat, Vec2, Vec3, Vec3Swizzles};
use half::f16;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::Range;
use windfall_core::path::{Fall, Landing, LeafFall};
use windfall_core::rng::{hash, unit};
use windfall_core::shed::Shedding;
use windfall_gpu::Forest;
use windfall_gpu::internals::packing::{octahedral, pack_rotation, snorm8};
use windfall_gpu::internals::shared::TreeList;

/// Seconds after the detachment from which on a leaf is tested for a landing (VB 5).
const LONG_ENOUGH: f32 = 2.0;
/// Factor on the time after which a leaf should have landed when it is tested: those that are slower than before are
/// seldom tested in vain.
const LATE: f32 = 1.25;
/// Shortest time between two tests of a leaf, seconds.
const AGAIN: f32 = 0.25;
/// Later than every time.
const NEVER: f32 = 1e30;

/// The list that has the leaf of a slot, and its index there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    Nowhere,
    Active(u32),
    Litter(u32),
}

#[derive(Debug, Clone, Copy)]
struct Slot {
    /// Entry of the stream; meaningless if `place` is nowhere.
    entry: u32,
    place: Place,
    landed: bool,
    /// Whether the leaf is drawn in two triangles.
    small: bool,
    /// Distance travelled by the eye at which `small` is decided again.
    recheck: f32,
}

const NO_LEAF: Slot =
    Slot { entry: 0, place: Place::Nowhere, landed: false, small: false, recheck: NEVER };

/// Pieces of a fall in each of which a leaf is either full or small.
const PIECES: usize = 8;

/// `recheck` of a leaf that is looked at in every frame.
const EVERY_FRAME: f32 = -1.0;

/// Where a leaf is during its fall: near a line in each piece of it.
struct Track {
    points: [Vec3; PIECES + 1],
    /// How far it may be from the line between the points of a piece, metres.
    reach: [f32; PIECES],
}

/// A fall whose end is known.
pub type KnownFall = Box<(LeafFall, Landing)>;

/// When a piece of a leaf's fall begins, seconds on the forest's clock.
fn piece_start(leaf: &FallingLeaf, piece: usize) -> f64 {
    f64::from(leaf.detach_time) + f64::from(leaf.landing.w) * (piece as f64 / PIECES as f64)
}

/// Something that is due for the leaf of an entry.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Due {
    /// Seconds on the forest's clock, or metres travelled by the eye.
    at: f64,
    stream: u32,
    entry: u32,
}

impl Eq for Due {}

impl PartialOrd for Due {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Due {
    /// The earliest is the greatest: heaps pop it first.
    fn cmp(&self, other: &Self) -> Ordering {
        other.at.total_cmp(&self.at).then(other.entry.cmp(&self.entry))
    }
}

/// Leaves that have left their twigs, and the work of the last frame on their lists.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LeafCounts {
    /// Leaves in the air.
    pub falling: u64,
    /// Leaves on the ground.
    pub landed: u64,
    /// Landed leaves that have left the list of active leaves.
    pub eliminated: u64,
    /// Leaves that elimination looked at in the last frame.
    pub checked: u64,
}

/// A moment of the lists.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ListMoment {
    /// Seconds on the forest's clock: since [`Forest::clock_start`].
    pub time: f64,
    /// Phase of autumn.
    pub season: f32,
}

/// The lists of active leaves and of litter.
pub struct ActiveLeaves {
    pub streams: Streams,
    elimination: Elimination,
    gust_rate: f32,
    /// The entries of each stream that are in a list.
    listed: Vec<Range<u32>>,
    slots: Vec<Slot>,
    /// By slot, of leaves in the air that can be small.
    tracks: Vec<Option<Box<Track>>>,
    pub active: Arena<FallingLeaf>,
    pub litter: Arena<LitterLeaf>,
    /// Of the leaves whose landing is known.
    landings: BinaryHeap<Due>,
    /// Leaves that progressive elimination has yet to test.
    waiting: BinaryHeap<Due>,
    /// Whether landings are searched when leaves detach.
    ahead: bool,
    /// By slot, the falls of active leaves, for who poses them on the CPU.
    pub falls: Option<Vec<Option<KnownFall>>>,
    eye: Eye,
    /// Distances travelled by the eye at which leaves may have become small or large.
    rechecks: BinaryHeap<Due>,
    /// Leaves that may become small or large at any time of a piece of their fall.
    undecided: Vec<Due>,
    /// When pieces of the falls of leaves begin.
    phases: BinaryHeap<Due>,
    landed: u64,
    checked: u64,
    moment: Option<ListMoment>,
}

impl ActiveLeaves {
    /// Empty lists for the streams of a forest.
    pub fn new(
        device: &wgpu::Device,
        streams: Streams,
        forest: &Forest,
        elimination: Elimination,
        passes: PassOptions,
    ) -> Self {
        let on_cpu = passes.strategy == Strategy::Cpu;
        let ahead = passes.landing == LandingSearch::Ahead
            || elimination == Elimination::Scheduled
            || on_cpu;
        let regions = 2 * streams.batches.len();
        Self {
            elimination,
            gust_rate: Shedding::gust_rate(forest.local_wind()),
            listed: vec![0..0; streams.all.len()],
            slots: vec![NO_LEAF; streams.slot_count as usize],
            tracks: (0..streams.slot_count).map(|_| None).collect(),
            falls: on_cpu.then(|| (0..streams.slot_count).map(|_| None).collect()),
            ahead,
            active: Arena::new(device, "active leaves", regions),
            litter: Arena::new(device, "litter", regions),
            streams,
            landings: BinaryHeap::new(),
            waiting: BinaryHeap::new(),
            eye: Eye::new(),
            rechecks: BinaryHeap::new(),
            undecided: Vec::new(),
            phases: BinaryHeap::new(),
            landed: 0,
            checked: 0,
            moment: None,
        }
    }

    /// Brings the lists to a moment, and sorts them by leaf size in a view.
    pub fn update(&mut self, forest: &Forest, moment: ListMoment, view: &TreeList) {
        // Stale entries of recycled leaves would pile up otherwise.
        let anew = self.eye.follow(view) || self.rechecks.len() > 4 * self.slots.len();
        let forward = self
            .moment
            .is_some_and(|before| moment.time >= before.time && moment.season == before.season);
        if !forward {
            self.clear();
        }
        self.moment = Some(moment);
        let undecided = std::mem::take(&mut self.undecided);
        self.collect_detached(forest, moment);
        self.eliminate(forest, moment);
        for due in undecided {
            if self.slot_of(&due).is_some_and(|slot| slot.recheck == EVERY_FRAME) {
                self.sort_by_size(due.stream, due.entry);
            }
        }
        if anew {
            self.rechecks.clear();
            self.undecided.clear();
            for s in 0..self.streams.all.len() {
                for entry in self.listed[s].clone() {
                    self.sort_by_size(s as u32, entry);
                }
            }
        }
        for due in until(&mut self.phases, moment.time) {
            if self.slot_of(&due).is_some() {
                self.sort_by_size(due.stream, due.entry);
            }
        }
        let travelled = f64::from(self.eye.travelled);
        for due in until(&mut self.rechecks, travelled) {
            if self.slot_of(&due).is_some_and(|slot| f64::from(slot.recheck) == due.at) {
                self.sort_by_size(due.stream, due.entry);
            }
        }
    }

    /// The slot of what is due; `None` if its leaf has vanished.
    fn slot_of(&self, due: &Due) -> Option<Slot> {
        let slot = self.slots[self.streams.all[due.stream as usize].slot(due.entry)];
        (slot.entry == due.entry && slot.place != Place::Nowhere).then_some(slot)
    }

    /// Leaves in the lists.
    pub fn counts(&self) -> LeafCounts {
        let eliminated = self.litter.len();
        let all = self.active.len() + eliminated;
        LeafCounts {
            falling: all - self.landed,
            landed: self.landed,
            eliminated,
            checked: self.checked,
        }
    }

    fn clear(&mut self) {
        self.active.clear();
        self.litter.clear();
        self.listed.fill(0..0);
        self.slots.fill(NO_LEAF);
        self.tracks.fill_with(|| None);
        if let Some(falls) = &mut self.falls {
            falls.fill_with(|| None);
        }
        self.landings.clear();
        self.waiting.clear();
        self.rechecks.clear();
        self.undecided.clear();
        self.phases.clear();
        self.landed = 0;
    }

    /// Removes the leaves that have vanished and adds those that have detached.
    fn collect_detached(&mut self, forest: &Forest, moment: ListMoment) {
        // Made once, and only if needed: it goes over the whole terrain.
        let mut made = None;
        for s in 0..self.streams.all.len() {
            let stream = self.streams.all[s].clone();
            let before = self.listed[s].clone();
            let end = self.detached(forest, &stream, before.end, moment.time);
            if end == before.end {
                continue;
            }
            let start = end.saturating_sub(stream.keep);
            for entry in before.start..start.min(before.end) {
                self.remove(&stream, entry);
            }
            self.listed[s] = start..end;
            let fall = made.get_or_insert_with(|| fall_of(forest));
            for entry in start.max(before.end)..end {
                let detach_time = self.detach_time(forest, &stream, entry);
                // A program let it detach before: the forest draws it.
                let scripted = self.streams.scripted_time(&stream, entry);
                if scripted.is_none_or(|time| time >= detach_time) {
                    let (leaf, track, of) = self.falling_leaf(forest, fall, &stream, entry, moment);
                    let slot = stream.slot(entry);
                    self.tracks[slot] = track;
                    self.add(s as u32, entry, leaf, moment);
                    if matches!(self.slots[slot].place, Place::Active(_)) {
                        self.track_fall(s as u32, entry, fall, (leaf.detach_time, of));
                    }
                }
            }
        }
    }

    fn add(&mut self, s: u32, entry: u32, leaf: FallingLeaf, moment: ListMoment) {
        let stream = &self.streams.all[s as usize];
        let landing = f64::from(leaf.detach_time) + f64::from(leaf.landing.w);
        let landed = landing <= moment.time;
        let index = stream.slot(entry);
        let due = |at| Due { at, stream: s, entry };
        // Full until its size is known.
        let region = stream.region(false);
        let place = if landed && self.elimination != Elimination::Off {
            let model = &self.streams.model(stream).uniform;
            let lying = litter_leaf(&leaf, model, moment.season);
            Place::Litter(self.litter.regions[region].push(lying, index as u32))
        } else {
            Place::Active(self.active.regions[region].push(leaf, index as u32))
        };
        self.slots[index] = Slot { entry, place, landed, ..NO_LEAF };
        self.sort_by_size(s, entry);
        if self.ahead && self.streams.can_be_small(&self.streams.all[s as usize]) {
            let phases = (1..PIECES).map(|piece| piece_start(&leaf, piece));
            self.phases.extend(phases.filter(|&at| at > moment.time).map(due));
        }
        if landed {
            self.landed += 1;
        } else if self.ahead {
            self.landings.push(due(landing));
        }
    }

    /// Keeps what is needed of the fall of an active leaf.
    fn track_fall(
        &mut self,
        s: u32,
        entry: u32,
        fall: &Fall<'_>,
        (detach_time, known): (f32, (LeafFall, Option<Landing>)),
    ) {
        let (of, landing) = known;
        if let Elimination::Progressive { .. } = self.elimination {
            let first = expected_landing(fall, &of, LONG_ENOUGH).max(LONG_ENOUGH);
            let at = f64::from(detach_time) + f64::from(first);
            self.waiting.push(Due { at, stream: s, entry });
        }
        if let (Some(falls), Some(landing)) = (&mut self.falls, landing) {
            falls[self.streams.all[s as usize].slot(entry)] = Some(Box::new((of, landing)));
        }
    }

    /// When the season lets the leaf of an entry detach, seconds on the forest's clock.
    fn detach_time(&self, forest: &Forest, stream: &Stream, entry: u32) -> f32 {
        let shedding = &forest.falls().shedding;
        let rank = self.streams.record(stream, entry).rank;
        let tree = self.streams.shedding(stream);
        let start = (shedding.start - forest.clock_start()) as f32;
        start + shedding.detach_after_start(&tree, self.gust_rate, rank)
    }

    /// Entries of a stream that have detached by `time`, if at least `least` have.
    fn detached(&self, forest: &Forest, stream: &Stream, least: u32, time: f64) -> u32 {
        let gone = |entry: u32| f64::from(self.detach_time(forest, stream, entry)) <= time;
        // Usually few or none since the last frame: search in steps that double.
        let (mut low, mut step) = (least, 1);
        while low < stream.count && gone((low + step - 1).min(stream.count - 1)) {
            low = (low + step).min(stream.count);
            step *= 2;
        }
        let mut high = (low + step - 1).min(stream.count);
        while low < high {
            let middle = u32::midpoint(low, high);
            if gone(middle) { low = middle + 1 } else { high = middle }
        }
        low
    }

    /// The leaf of an entry, its track if it is in the air and can be small, and its fall.
    fn falling_leaf(
        &self,
        forest: &Forest,
        fall: &Fall<'_>,
        stream: &Stream,
        entry: u32,
        moment: ListMoment,
    ) -> (FallingLeaf, Option<Box<Track>>, (LeafFall, Option<Landing>)) {
        let (tree, record) = (&stream.tree, self.streams.record(stream, entry));
        let model = &self.streams.model(stream).uniform;
        let detach_time = self.detach_time(forest, stream, entry);
        let leaf_fall = self.leaf_fall(forest, stream, entry);
        let known = self.ahead.then(|| fall.landing(&leaf_fall));
        let nowhere = Landing {
            time: NEVER,
            position: Vec3::ZERO,
            orientation: Quat::IDENTITY,
            settle: Quat::IDENTITY,
        };
        let landing = known.unwrap_or(nowhere);
        let scale = record.scale * tree.scale;
        let thickness = self.streams.thickness(stream);
        let stack = scale * thickness + 0.002 + 0.012 * unit(hash(leaf_fall.seed, 13));
        let wind = forest.local_wind();
        let next = entry + stream.keep;
        let from_center = (record.center - model.crown_center) / model.crown_extent;
        let [material, ambient, bent_x, bent_y] = record.look.to_le_bytes();
        let bent = from_octahedral(Vec2::new(from_snorm8(bent_x), from_snorm8(bent_y)));
        let bent = octahedral(turned(tree, bent));
        let [twig_xy, twig_zw] = pack_rotation(leaf_fall.twig_orientation);
        let [lying_xy, lying_zw] = pack_rotation(landing.orientation);
        let landing_time = f64::from(detach_time) + f64::from(landing.time);
        let in_air = landing_time > moment.time;
        let track = (self.ahead && in_air && self.streams.can_be_small(stream)).then(|| {
            let at = |piece: f64| {
                let elapsed = f64::from(landing.time) * piece / PIECES as f64;
                fall.pose(&leaf_fall, &landing, leaf_fall.detach_time + elapsed).position
            };
            let points = std::array::from_fn(|i| at(i as f64));
            let reach = |i: usize| {
                let middle = at(i as f64 + 0.5);
                // What swings to the middle may swing a little farther beside it.
                1.5 * distance_to_segment(middle, points[i], points[i + 1])
            };
            Box::new(Track { reach: std::array::from_fn(reach), points })
        });
        let leaf = FallingLeaf {
            origin: leaf_fall.origin,
            detach_time,
            landing: landing.position.extend(landing.time),
            late: wind.travel.dot(tree.position.xz()) * wind.slowness,
            model: tree.model as f32,
            vanish_time: if next < stream.count {
                self.detach_time(forest, stream, next)
            } else {
                NEVER
            },
            ripe: ripeness(tree.season_offset, tree.seed, from_center),
            twig_xy,
            twig_zw,
            lying_xy,
            lying_zw,
            seed: leaf_fall.seed,
            look: u32::from_le_bytes([material, ambient, snorm8(bent.x), snorm8(bent.y)]),
            variant: fall.variant(&leaf_fall).word,
            scale_stack: u32::from(f16::from_f32(scale).to_bits())
                | u32::from(f16::from_f32(stack).to_bits()) << 16,
        };
        (leaf, track, (leaf_fall, known))
    }

    /// How the leaf of an entry falls.
    fn leaf_fall(&self, forest: &Forest, stream: &Stream, entry: u32) -> LeafFall {
        let (tree, record) = (&stream.tree, self.streams.record(stream, entry));
        let own = unpack_rotation([record.orientation_xy, record.orientation_zw]);
        let detach_time = self.detach_time(forest, stream, entry);
        LeafFall {
            origin: world_from_tree(tree, record.center),
            twig_orientation: Quat::from_rotation_y(tree.sin_yaw.atan2(tree.cos_yaw)) * own,
            tree: tree.position,
            seed: hash(tree.seed, record.rank),
            group: stream.path_group,
            // The wind is on the world's clock.
            detach_time: forest.clock_start() + f64::from(detach_time),
        }
    }

    /// Moves the leaf of an entry to the region of its size in the view.
    fn sort_by_size(&mut self, s: u32, entry: u32) {
        let stream = self.streams.all[s as usize].clone();
        if !self.streams.can_be_small(&stream) {
            return;
        }
        let index = stream.slot(entry);
        let slot = self.slots[index];
        if !self.ahead && matches!(slot.place, Place::Active(_)) {
            // Where it is, only the shader knows.
            return;
        }
        let own_scale = self.streams.record(&stream, entry).scale;
        let length = 2.0 * self.streams.radius(&stream) * stream.tree.scale * own_scale;
        let now = self.moment.map_or(0.0, |moment| moment.time);
        let (before, margin, steady) = match slot.place {
            Place::Nowhere => return,
            Place::Active(at) => {
                let leaf = &self.active.regions[stream.region(slot.small)].items[at as usize];
                let (margin, steady) = match &self.tracks[index] {
                    Some(track) if !slot.landed => self.margin_in_air(leaf, track, length, now),
                    _ => (self.eye.margin(length, leaf.landing.truncate()), true),
                };
                (at, margin, steady)
            }
            Place::Litter(at) => {
                let leaf = &self.litter.regions[stream.region(slot.small)].items[at as usize];
                (at, self.eye.margin(length, leaf.position), true)
            }
        };
        let small = margin > 0.0;
        let recheck = if steady { self.eye.travelled + margin.abs() } else { EVERY_FRAME };
        if small != slot.small {
            let [from, to] = [slot.small, small].map(|small| stream.region(small));
            match &mut self.slots[index].place {
                Place::Nowhere => {}
                Place::Active(at) => {
                    let leaf = self.active.regions[from].items[before as usize];
                    *at = self.active.regions[to].push(leaf, index as u32);
                }
                Place::Litter(at) => {
                    let leaf = self.litter.regions[from].items[before as usize];
                    *at = self.litter.regions[to].push(leaf, index as u32);
                }
            }
            self.take_out(from, slot.place);
        }
        let slot = &mut self.slots[index];
        (slot.small, slot.recheck) = (small, recheck);
        let due = Due { at: recheck.into(), stream: s, entry };
        if !steady {
            self.undecided.push(due);
        } else if recheck.is_finite() {
            self.rechecks.push(due);
        }
    }

    /// [`Eye::margin`] of a leaf in the air, and whether it keeps its sign for the rest of the piece of its fall.
    fn margin_in_air(
        &self,
        leaf: &FallingLeaf,
        track: &Track,
        length: f32,
        now: f64,
    ) -> (f32, bool) {
        let begun = |&piece: &usize| piece_start(leaf, piece) <= now;
        let piece = (1..PIECES).filter(begun).count();
        let (from, to) = (track.points[piece], track.points[piece + 1]);
        let reach = track.reach[piece];
        let nearest = self.eye.margin_of_segment(length, (from, to), reach);
        if nearest > 0.0 {
            return (nearest, true);
        }
        let farthest = [from, to].map(|at| self.eye.margin(length, at));
        let farthest = farthest[0].max(farthest[1]) + reach;
        if farthest < 0.0 {
            return (farthest, true);
        }
        let (start, end) = (piece_start(leaf, piece), piece_start(leaf, piece + 1));
        let along = ((now - start) / (end - start).max(1e-9)).clamp(0.0, 1.0) as f32;
        (self.eye.margin(length, from.lerp(to, along)), false)
    }

    fn remove(&mut self, stream: &Stream, entry: u32) {
        let index = stream.slot(entry);
        let slot = self.slots[index];
        if slot.landed {
            self.landed -= 1;
        }
        self.slots[index] = NO_LEAF;
        self.tracks[index] = None;
        if let Some(falls) = &mut self.falls {
            falls[index] = None;
        }
        self.take_out(stream.region(slot.small), slot.place);
    }

    /// Removes a leaf from a region's list; the last takes its index.
    fn take_out(&mut self, region: usize, place: Place) {
        let moved = match place {
            Place::Nowhere => None,
            Place::Active(at) => self.active.regions[region].swap_remove(at),
            Place::Litter(at) => self.litter.regions[region].swap_remove(at),
        };
        if let Some(moved) = moved {
            self.slots[moved as usize].place = place;
        }
    }

    /// Counts the leaves that have landed, and moves them to the litter as [`Elimination`] says.
    fn eliminate(&mut self, forest: &Forest, moment: ListMoment) {
        self.checked = 0;
        for due in until(&mut self.landings, moment.time) {
            if self.slot_of(&due).is_none() {
                continue;
            }
            let index = self.streams.all[due.stream as usize].slot(due.entry);
            self.slots[index].landed = true;
            self.tracks[index] = None;
            self.landed += 1;
            if self.elimination == Elimination::Scheduled {
                self.checked += 1;
                self.move_to_litter(due, moment.season);
            } else {
                self.sort_by_size(due.stream, due.entry);
            }
        }
        let Elimination::Progressive { per_frame } = self.elimination else {
            return;
        };
        let mut made = None;
        while self.checked < u64::from(per_frame) {
            let Some(due) = self.waiting.peek().copied().filter(|due| due.at <= moment.time) else {
                break;
            };
            self.waiting.pop();
            let Some(slot) = self.slot_of(&due) else { continue };
            self.checked += 1;
            let fall = made.get_or_insert_with(|| fall_of(forest));
            let stream = self.streams.all[due.stream as usize].clone();
            let of = self.leaf_fall(forest, &stream, due.entry);
            let detach_time = self.detach_time(forest, &stream, due.entry);
            let elapsed = (moment.time - f64::from(detach_time)) as f32;
            let landed = if self.ahead { slot.landed } else { self.land(fall, &of, &due, elapsed) };
            if landed {
                self.move_to_litter(due, moment.season);
                continue;
            }
            let next = expected_landing(fall, &of, elapsed).max(elapsed + AGAIN);
            self.waiting.push(Due { at: f64::from(detach_time) + f64::from(next), ..due });
        }
    }

    /// Whether a leaf whose landing is not known has landed; then it lies (VB 5: "the correct position is computed on
    /// the CPU, and if they lie on the floor, their position is updated").
    fn land(&mut self, fall: &Fall<'_>, of: &LeafFall, due: &Due, elapsed: f32) -> bool {
        if height(fall, of, elapsed) > 0.0 {
            return false;
        }
        let landing = fall.landing(of);
        if landing.time > elapsed {
            return false;
        }
        let stream = &self.streams.all[due.stream as usize];
        let index = stream.slot(due.entry);
        let slot = &mut self.slots[index];
        if let Place::Active(at) = slot.place {
            slot.landed = true;
            self.landed += 1;
            let leaf = &mut self.active.regions[stream.region(slot.small)].items[at as usize];
            leaf.landing = landing.position.extend(landing.time);
            [leaf.lying_xy, leaf.lying_zw] = pack_rotation(landing.orientation);
        }
        true
    }

    /// Moves a leaf from the active list to the litter.
    fn move_to_litter(&mut self, due: Due, season: f32) {
        let stream = self.streams.all[due.stream as usize].clone();
        let index = stream.slot(due.entry);
        let slot = self.slots[index];
        let Place::Active(at) = slot.place else {
            return;
        };
        let region = stream.region(slot.small);
        let leaf = self.active.regions[region].items[at as usize];
        self.take_out(region, slot.place);
        let lying = litter_leaf(&leaf, &self.streams.model(&stream).uniform, season);
        let at = self.litter.regions[region].push(lying, index as u32);
        self.slots[index].place = Place::Litter(at);
        if let Some(falls) = &mut self.falls {
            falls[index] = None;
        }
        self.sort_by_size(due.stream, due.entry);
    }
}

/// All that the falls of a forest have in common.
pub fn fall_of(forest: &Forest) -> Fall<'_> {
    let falls = forest.falls();
    let variation = falls.variation.clone();
    Fall::new(&falls.paths, forest.terrain(), *forest.local_wind(), variation, falls.settings)
}

/// Height of a leaf over the ground, metres, as if it fell through that.
fn height(fall: &Fall<'_>, of: &LeafFall, elapsed: f32) -> f32 {
    let at = fall.airborne(of, &fall.variant(of), elapsed).position;
    at.y - fall.terrain().height(at.x, at.z)
}

/// Seconds after the detachment by which a leaf should have landed that goes on falling as fast as in the first
/// `elapsed` seconds.
fn expected_landing(fall: &Fall<'_>, of: &LeafFall, elapsed: f32) -> f32 {
    let at = fall.airborne(of, &fall.variant(of), elapsed).position;
    let left = (at.y - fall.terrain().height(at.x, at.z)).max(0.0);
    let speed = ((of.origin.y - at.y) / elapsed.max(1e-3)).max(0.05);
    elapsed + left / speed * LATE
}

/// Pops what is due by a time or distance.
fn until(heap: &mut BinaryHeap<Due>, limit: f64) -> Vec<Due> {
    let mut due = Vec::new();
    while let Some(next) = heap.peek().filter(|due| due.at <= limit) {
        due.push(*next);
        heap.pop();
    }
    due
}

#[cfg(test)]
mod tests;
