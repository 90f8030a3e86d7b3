//! The active-leaf list: the leaves that have left their twigs, kept by the CPU (VB 5).
//!
//! The lists are a function of the moment alone. Playing forward adds detached leaves and moves landed ones to the
//! litter; any other change of time, season or forest starts anew. Streams and slots are those of the renderer's
//! compute path, so that both keep the same leaves.

use crate::arena::Arena;
use crate::eye::{Eye, distance_to_segment};
use crate::options::Elimination;
use crate::shared::{FallingLeaf, LitterLeaf};
use crate::streams::{Stream, Streams, turned, world_from_tree};
use glam::{Quat, Vec2, Vec3, Vec3Swizzles};
use half::f16;
use std::cmp::Ordering;
use std::collections::{BinaryHeap, VecDeque};
use std::ops::Range;
use windfall_core::path::{Fall, LeafFall};
use windfall_core::rng::{hash, unit};
use windfall_core::shed::Shedding;
use windfall_gpu::Forest;
use windfall_gpu::internals::packing::{octahedral, pack_rotation, snorm8};
use windfall_gpu::internals::shared::{Model, TreeList};

/// Seconds after the detachment from which on a leaf is tested for a landing (VB 5).
const LONG_ENOUGH: f64 = 2.0;
/// Seconds over which the twig's motion goes out of a leaf; `LETTING_GO` of the shaders.
const LETTING_GO: f32 = 1.5;
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
    landings: BinaryHeap<Due>,
    /// Leaves that elimination has yet to test, in the order in which it does; `at` is when they detached.
    waiting: VecDeque<Due>,
    eye: Eye,
    /// Distances travelled by the eye at which leaves may have become small or large.
    rechecks: BinaryHeap<Due>,
    /// Leaves that may become small or large at any time of a piece of their fall.
    undecided: Vec<Due>,
    /// When leaves have let go of their twigs, and when pieces of their falls begin.
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
    ) -> Self {
        let regions = 2 * streams.batches.len();
        Self {
            elimination,
            gust_rate: Shedding::gust_rate(forest.local_wind()),
            listed: vec![0..0; streams.all.len()],
            slots: vec![NO_LEAF; streams.slot_count as usize],
            tracks: (0..streams.slot_count).map(|_| None).collect(),
            active: Arena::new(device, "active leaves", regions),
            litter: Arena::new(device, "litter", regions),
            streams,
            landings: BinaryHeap::new(),
            waiting: VecDeque::new(),
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
        self.eliminate(moment);
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
        self.landings.clear();
        self.waiting.clear();
        self.rechecks.clear();
        self.undecided.clear();
        self.phases.clear();
        self.landed = 0;
    }

    /// Removes the leaves that have vanished and adds those that have detached.
    fn collect_detached(&mut self, forest: &Forest, moment: ListMoment) {
        let falls = forest.falls();
        let settings = falls.settings;
        let fall = |wind| {
            let variation = falls.variation.clone();
            Fall::new(&falls.paths, forest.terrain(), wind, variation, settings)
        };
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
            let fall = made.get_or_insert_with(|| fall(*forest.local_wind()));
            for entry in start.max(before.end)..end {
                let detach_time = self.detach_time(forest, &stream, entry);
                // A program let it detach before: the forest draws it.
                let scripted = self.streams.scripted_time(&stream, entry);
                if scripted.is_none_or(|time| time >= detach_time) {
                    let (leaf, track) = self.falling_leaf(forest, fall, &stream, entry, moment);
                    self.tracks[stream.slot(entry)] = track;
                    self.add(s as u32, entry, leaf, moment);
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
            let at = self.active.regions[region].push(leaf, index as u32);
            if let Elimination::Progressive { .. } = self.elimination {
                self.waiting.push_back(due(leaf.detach_time.into()));
            }
            Place::Active(at)
        };
        self.slots[index] = Slot { entry, place, landed, ..NO_LEAF };
        self.sort_by_size(s, entry);
        if self.streams.can_be_small(&self.streams.all[s as usize]) {
            let release = f64::from(leaf.detach_time + LETTING_GO);
            let pieces = (1..PIECES).map(|piece| piece_start(&leaf, piece));
            let phases = pieces.chain([release]).filter(|&at| at > moment.time);
            self.phases.extend(phases.map(due));
        }
        if landed {
            self.landed += 1;
        } else {
            self.landings.push(due(landing));
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

    /// The leaf of an entry, and its track if it is in the air and can be small.
    fn falling_leaf(
        &self,
        forest: &Forest,
        fall: &Fall<'_>,
        stream: &Stream,
        entry: u32,
        moment: ListMoment,
    ) -> (FallingLeaf, Option<Box<Track>>) {
        let (tree, record) = (&stream.tree, self.streams.record(stream, entry));
        let model = &self.streams.model(stream).uniform;
        let own = unpack_rotation([record.orientation_xy, record.orientation_zw]);
        let detach_time = self.detach_time(forest, stream, entry);
        let leaf_fall = LeafFall {
            origin: world_from_tree(tree, record.center),
            twig_orientation: Quat::from_rotation_y(tree.sin_yaw.atan2(tree.cos_yaw)) * own,
            tree: tree.position,
            seed: hash(tree.seed, record.rank),
            group: stream.path_group,
            // The wind is on the world's clock.
            detach_time: forest.clock_start() + f64::from(detach_time),
        };
        let landing = fall.landing(&leaf_fall);
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
        let track = (in_air && self.streams.can_be_small(stream)).then(|| {
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
        (leaf, track)
    }

    /// Moves the leaf of an entry to the region of its size in the view.
    fn sort_by_size(&mut self, s: u32, entry: u32) {
        let stream = self.streams.all[s as usize].clone();
        if !self.streams.can_be_small(&stream) {
            return;
        }
        let index = stream.slot(entry);
        let slot = self.slots[index];
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
                // Until it has let go it looks like the leaves on its tree.
                let released = f64::from(leaf.detach_time + LETTING_GO) <= now;
                let crown = &self.streams.model(&stream).crown;
                let tree =
                    if released { NEVER } else { self.eye.margin_of_tree(&stream.tree, crown) };
                (at, margin.min(tree), steady)
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
    fn eliminate(&mut self, moment: ListMoment) {
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
        for _ in 0..self.waiting.len().min(per_frame as usize) {
            let ready = |due: &&Due| due.at + LONG_ENOUGH <= moment.time;
            let Some(&due) = self.waiting.front().filter(ready) else {
                break;
            };
            self.waiting.pop_front();
            self.checked += 1;
            match self.slot_of(&due) {
                Some(slot) if slot.landed => self.move_to_litter(due, moment.season),
                Some(_) => self.waiting.push_back(due),
                None => {}
            }
        }
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
        self.sort_by_size(due.stream, due.entry);
    }
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

/// A landed leaf before it withers: the CPU reference of `loose_leaf` in the renderer's `loose.wgsl`.
fn litter_leaf(leaf: &FallingLeaf, model: &Model, season: f32) -> LitterLeaf {
    let up = unpack_rotation([leaf.lying_xy, leaf.lying_zw]) * Vec3::Y;
    let up = if up.y < 0.0 { -up } else { up };
    let color = (season_color(leaf, model, season) * 0.5).max(Vec3::ZERO).map(f32::sqrt);
    let [r, g, b] = color.to_array().map(unorm8);
    let [material, _, bent_x, bent_y] = leaf.look.to_le_bytes();
    let [scale, stack] =
        [leaf.scale_stack, leaf.scale_stack >> 16].map(|half| f16::from_bits(half as u16).to_f32());
    LitterLeaf {
        position: leaf.landing.truncate() + up * stack,
        scale,
        orientation_xy: leaf.lying_xy,
        orientation_zw: leaf.lying_zw,
        color: u32::from_le_bytes([r, g, b, unorm8(0.9)]),
        look: u32::from_le_bytes([material, bent_x, bent_y, 255]),
        landed_time: leaf.detach_time + leaf.landing.w,
        vanish_time: leaf.vanish_time,
        padding0: 0,
        padding1: 0,
    }
}

/// The CPU reference of `ripeness` and `branch_ripeness` in the renderer's `season.wgsl`.
fn ripeness(season_offset: f32, seed: u32, from_center: Vec3) -> f32 {
    let wave = |direction: Vec3, draw: u32| {
        let turns = from_center.dot(direction) + unit(hash(seed, draw));
        (std::f32::consts::TAU * (turns - turns.floor())).sin()
    };
    let branch = 0.09 * wave(Vec3::new(0.83, 0.55, -0.61), 14)
        + 0.07 * wave(Vec3::new(-0.97, 1.13, 0.86), 15);
    season_offset + 0.12 * from_center.y + branch
}

/// The CPU reference of `season_color` in the renderer's `loose.wgsl`.
fn season_color(leaf: &FallingLeaf, model: &Model, season: f32) -> Vec3 {
    let u = |draw: u32| unit(hash(leaf.seed, draw));
    let own = (u(10) + u(12) - 1.0) * model.palette_spread;
    let phase = (season + leaf.ripe + own).clamp(0.0, 1.0);
    let brightness = Vec3::splat(0.82 + 0.36 * u(11));
    if model.palette_count < 2 {
        return brightness;
    }
    let x = phase * (model.palette_count - 1) as f32;
    let i = (x as u32).min(model.palette_count - 2) as usize;
    brightness * model.palette[i].lerp(model.palette[i + 1], x - i as f32).truncate()
}

fn unorm8(v: f32) -> u8 {
    (v.clamp(0.0, 1.0) * 255.0).round() as u8
}

fn from_snorm8(byte: u8) -> f32 {
    (f32::from(byte as i8) / 127.0).max(-1.0)
}

fn unpack_rotation([xy, zw]: [u32; 2]) -> Quat {
    let low = |v: u32| f32::from(v as u16 as i16) / 32767.0;
    let q = Quat::from_xyzw(low(xy), low(xy >> 16), low(zw), low(zw >> 16));
    if q.length_squared() > 0.0 { q.normalize() } else { Quat::IDENTITY }
}

/// The inverse of [`octahedral`].
fn from_octahedral(p: Vec2) -> Vec3 {
    let y = 1.0 - p.x.abs() - p.y.abs();
    let t = (-y).max(0.0);
    let fold = |v: f32| v + if v >= 0.0 { -t } else { t };
    Vec3::new(fold(p.x), y, fold(p.y)).normalize_or(Vec3::Y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use glam::DVec3;
    use windfall_core::forest::{Placement, Terrain};
    use windfall_gpu::internals::text;
    use windfall_gpu::{Falls, TreeModel};
    use windfall_tree::Species;

    /// Which listed leaves are small, by slot.
    fn small(lists: &ActiveLeaves) -> Vec<Option<bool>> {
        let of = |slot: &Slot| (slot.place != Place::Nowhere).then_some(slot.small);
        lists.slots.iter().map(of).collect()
    }

    #[test]
    fn leaves_let_go_as_in_the_shaders() {
        assert!(text::LOOSE.contains(&format!("const LETTING_GO: f32 = {LETTING_GO:?};")));
    }

    /// Leaves fall while the eye moves among them, near and far: earlier views make no difference, and the regions
    /// have what the slots say.
    #[test]
    fn leaves_are_small_or_large_by_the_view_alone() {
        let (device, queue) = windfall_testing::device();
        let model = TreeModel::new(&device, &queue, &Species::Maple.grow_with(1, 300)).unwrap();
        let placement = Placement {
            trees: 3,
            spacing: 8.0,
            keep_out: Vec::new(),
            scale: (0.8, 1.2),
            season_spread: 0.2,
            seed: 3,
        };
        let placed = placement.place(Terrain::rolling(200.0, 4.0, 5), &[1.0]);
        let shedding = Shedding { start: 0.0, duration: 60.0, ..Shedding::default() };
        let falls = Falls { shedding, capacity: 0, ..Falls::default() };
        let mut forest = Forest::new(&device, DVec3::ZERO, placed.terrain, falls).unwrap();
        forest.plant(&[model], &placed.instances).unwrap();
        let at = |frame: u32| ListMoment { time: 0.3 * f64::from(frame), season: 0.5 };
        for elimination in Elimination::ALL {
            // Some vanish.
            let lists =
                || ActiveLeaves::new(&device, Streams::new(&forest, 150), &forest, elimination);
            let mut played = lists();
            let mut seen = [0; 2];
            for frame in 0..200u32 {
                let draw = |key| unit(hash(frame / 20, key));
                // Another place every 20 frames, sometimes another size of the image.
                let eye = Vec3::new(30.0 * draw(1) - 15.0, 1.7, 30.0 * draw(2) - 15.0)
                    + Vec3::X * (0.1 * (frame % 20) as f32);
                let pixels = if draw(3) > 0.7 { 200.0 } else { 120.0 };
                let view = TreeList { eye, pixels, leaf_pixels: 10.0, ..TreeList::zeroed() };
                played.update(&forest, at(frame), &view);
                if frame % 3 == 0 {
                    let mut fresh = lists();
                    fresh.update(&forest, at(frame), &view);
                    assert!(small(&played) == small(&fresh), "{elimination}, frame {frame}");
                }
                let count = |small| {
                    let of = |region: usize| {
                        played.active.regions[region].items.len()
                            + played.litter.regions[region].items.len()
                    };
                    (usize::from(small)..played.active.regions.len()).step_by(2).map(of).sum()
                };
                for (i, is_small) in [(0, false), (1, true)] {
                    let listed: usize = count(is_small);
                    let slots = small(&played).iter().filter(|s| **s == Some(is_small)).count();
                    assert_eq!(listed, slots, "{elimination}, frame {frame}");
                    seen[i] += listed;
                }
            }
            // Queues stay bounded while the eye rests.
            let mut still = lists();
            let view = TreeList { pixels: 120.0, leaf_pixels: 10.0, ..TreeList::zeroed() };
            for frame in 0..200u32 {
                still.update(&forest, at(frame), &view);
                assert!(still.rechecks.len() <= 5 * still.slots.len(), "frame {frame}");
            }
            // And while time goes back and forth.
            for _ in 0..40 {
                still.update(&forest, at(66), &view);
                still.update(&forest, at(65), &view);
                assert!(still.phases.len() <= PIECES * still.slots.len(), "{elimination}");
            }
            assert!(seen[0] > 5000 && seen[1] > 5000, "{seen:?} large and small leaves");
        }
    }
}
