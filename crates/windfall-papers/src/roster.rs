//! The leaves that have left their twigs, listed on the CPU (VB 5) for the strategies without
//! compute.
//!
//! A pure function of time, as everything: playing forward adds leaves and moves those that landed
//! to the litter; any other change of time begins anew. Streams and slots are those of
//! [`crate::falls`], so that the same leaves are kept as by [`crate::Strategy::Compute`].

use crate::arena::Arena;
use crate::eye::{Eye, from_segment};
use crate::falls::{Falls, LeafRecords, Plan, octahedral, pack_rotation, snorm8};
use crate::shared::{FallingLeaf, LeafRecord, LitterLeaf, Model, Stream, TreeList};
use crate::strategy::Elimination;
use glam::{Quat, Vec2, Vec3, Vec3Swizzles};
use half::f16;
use std::cmp::Ordering;
use std::collections::{BinaryHeap, VecDeque};
use std::ops::Range;
use windfall_core::forest::{Forest, Terrain};
use windfall_core::path::{Fall, LeafFall};
use windfall_core::rng::{hash, unit};
use windfall_core::shed::{Shedding, TreeShedding};

/// Seconds after which a leaf may have landed (VB 5).
const LONG_ENOUGH: f32 = 2.0;
/// Seconds until a leaf has let go of its twig: `LETTING_GO` in `shaders/shared/loose.wgsl`.
const LETTING_GO: f32 = 1.5;
/// Later than every time.
const NEVER: f32 = 1e30;

/// Where the leaf of a slot is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    Nowhere,
    Falling(u32),
    Litter(u32),
}

#[derive(Debug, Clone, Copy)]
struct Slot {
    /// Entry of the stream whose leaf it is, as long as `place` is somewhere.
    entry: u32,
    place: Place,
    landed: bool,
    /// Whether two triangles stand for the leaf.
    small: bool,
    /// How far from the straight line of its fall the leaf may be, metres.
    reach: f32,
    /// Way of the eye after which `small` is looked at again.
    look: f32,
}

const NO_LEAF: Slot =
    Slot { entry: 0, place: Place::Nowhere, landed: false, small: false, reach: 0.0, look: NEVER };

/// Something that happens to the leaf of an entry.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Due {
    time: f32,
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
    /// The earliest is the greatest, as a heap wants it.
    fn cmp(&self, other: &Self) -> Ordering {
        other.time.total_cmp(&self.time).then(other.entry.cmp(&self.entry))
    }
}

/// What the lists hold.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Tally {
    pub falling: u64,
    pub landed: u64,
    /// Landed leaves that have left the list of falling ones.
    pub eliminated: u64,
    /// Landings looked up for elimination in this update.
    pub checked: u64,
}

pub(crate) struct Roster {
    falls: Falls,
    terrain: Terrain,
    gust_rate: f32,
    plan: Plan,
    records: LeafRecords,
    models: Vec<Model>,
    /// For each stream the entries that are in a list.
    shown: Vec<Range<u32>>,
    slots: Vec<Slot>,
    pub falling: Arena<FallingLeaf>,
    pub litter: Arena<LitterLeaf>,
    landings: BinaryHeap<Due>,
    /// Leaves to be tested, those that began first in front; `time` is when they began.
    waiting: VecDeque<Due>,
    eye: Eye,
    /// When leaves may have become small or large in the view; `time` is the way of the eye.
    looks: BinaryHeap<Due>,
    /// When leaves have let go of their twigs.
    frees: BinaryHeap<Due>,
    landed: u64,
    checked: u64,
    /// Time and season that the lists are of.
    moment: Option<(f32, f32)>,
}

impl Roster {
    pub fn new(
        device: &wgpu::Device,
        plan: Plan,
        records: LeafRecords,
        models: &[Model],
        forest: &Forest,
        falls: &Falls,
    ) -> Self {
        let regions = 2 * plan.bins.len();
        Self {
            falls: falls.clone(),
            terrain: forest.terrain.clone(),
            gust_rate: Shedding::gust_rate(&falls.wind),
            shown: vec![0..0; plan.streams.len()],
            slots: vec![NO_LEAF; plan.slot_count as usize],
            falling: Arena::new(device, "falling leaves", regions),
            litter: Arena::new(device, "litter", regions),
            plan,
            records,
            models: models.to_vec(),
            landings: BinaryHeap::new(),
            waiting: VecDeque::new(),
            eye: Eye::new(),
            looks: BinaryHeap::new(),
            frees: BinaryHeap::new(),
            landed: 0,
            checked: 0,
            moment: None,
        }
    }

    /// Brings the lists to a moment, and sorts them by what leaves are drawn with in a view.
    pub fn update(&mut self, time: f32, season: f32, view: &TreeList) {
        // Of leaves that vanish before the eye has gone so far, what was due stays until then.
        let anew = self.eye.follow(view) || self.looks.len() > 4 * self.slots.len();
        let forward = self.moment.is_some_and(|(t, s)| time >= t && s == season);
        if !forward {
            self.clear();
        }
        self.moment = Some((time, season));
        for s in 0..self.plan.streams.len() {
            self.advance(s, time, season);
        }
        self.eliminate(time, season);
        if anew {
            self.looks.clear();
            for s in 0..self.plan.streams.len() {
                for entry in self.shown[s].clone() {
                    self.look(s as u32, entry);
                }
            }
        }
        for due in until(&mut self.frees, time) {
            if self.slot_of(&due).is_some() {
                self.look(due.stream, due.entry);
            }
        }
        for due in until(&mut self.looks, self.eye.gone) {
            if self.slot_of(&due).is_some_and(|slot| slot.look == due.time) {
                self.look(due.stream, due.entry);
            }
        }
    }

    /// The slot of what is due, if its leaf has not vanished.
    fn slot_of(&self, due: &Due) -> Option<Slot> {
        let slot = self.slots[Self::slot(&self.plan.streams[due.stream as usize], due.entry)];
        (slot.entry == due.entry && slot.place != Place::Nowhere).then_some(slot)
    }

    pub fn tally(&self) -> Tally {
        let eliminated = self.litter.len();
        let all = self.falling.len() + eliminated;
        Tally { falling: all - self.landed, landed: self.landed, eliminated, checked: self.checked }
    }

    fn clear(&mut self) {
        self.falling.clear();
        self.litter.clear();
        self.shown.fill(0..0);
        self.slots.fill(NO_LEAF);
        self.landings.clear();
        self.waiting.clear();
        self.looks.clear();
        self.frees.clear();
        self.landed = 0;
    }

    /// Takes out the leaves of a stream that have vanished and adds those that have detached.
    fn advance(&mut self, s: usize, time: f32, season: f32) {
        let stream = self.plan.streams[s];
        let before = self.shown[s].clone();
        let end = self.detached(&stream, before.end, time);
        let start = end.saturating_sub(stream.keep);
        if end == before.end {
            return;
        }
        for entry in before.start..start.min(before.end) {
            self.remove(&stream, entry);
        }
        let falls = &self.falls;
        let variation = falls.variation.clone();
        let fall = Fall::new(&falls.paths, &self.terrain, falls.wind, variation, falls.settings);
        let fresh: Vec<(u32, FallingLeaf, f32)> = (start.max(before.end)..end)
            .map(|entry| {
                let (leaf, reach) = self.falling_leaf(&fall, &stream, entry);
                (entry, leaf, reach)
            })
            .collect();
        self.shown[s] = start..end;
        for (entry, leaf, reach) in fresh {
            let due = leaf.detach_time + leaf.landing.w;
            let landed = due <= time;
            let index = Self::slot(&stream, entry);
            // Large until it has been looked at.
            let region = region(&stream, false);
            let place = if landed && self.falls.elimination != Elimination::Off {
                let lying = litter_leaf(&leaf, &self.models[stream.model as usize], season);
                Place::Litter(self.litter.regions[region].push(lying, index as u32))
            } else {
                let at = self.falling.regions[region].push(leaf, index as u32);
                if let Elimination::Progressive { .. } = self.falls.elimination {
                    let time = leaf.detach_time;
                    self.waiting.push_back(Due { time, stream: s as u32, entry });
                }
                Place::Falling(at)
            };
            self.slots[index] = Slot { entry, place, landed, reach, ..NO_LEAF };
            self.look(s as u32, entry);
            let free = leaf.detach_time + LETTING_GO;
            if free > time {
                self.frees.push(Due { time: free, stream: s as u32, entry });
            }
            if landed {
                self.landed += 1;
            } else {
                self.landings.push(Due { time: due, stream: s as u32, entry });
            }
        }
    }

    fn slot(stream: &Stream, entry: u32) -> usize {
        (stream.slot_first + entry % stream.keep) as usize
    }

    fn record(&self, stream: &Stream, entry: u32) -> &LeafRecord {
        let leaf = self.records.shed_lists[(stream.list_first + entry) as usize];
        &self.records.records[(stream.leaf_first + leaf) as usize]
    }

    fn detach_time(&self, stream: &Stream, entry: u32) -> f32 {
        if stream.thrown == 1 {
            let at = stream.list_first + stream.list_count + entry;
            return f32::from_bits(self.records.shed_lists[at as usize]);
        }
        let tree = TreeShedding {
            delay: stream.delay,
            gust_phase: stream.gust_phase,
            seed: stream.seed,
            leaves: stream.leaf_count,
        };
        let rank = self.record(stream, entry).rank;
        self.falls.shedding.detach_time(&tree, self.gust_rate, rank)
    }

    /// Entries of a stream that have detached by `time`; `least` of them are known to have.
    fn detached(&self, stream: &Stream, least: u32, time: f32) -> u32 {
        let gone = |entry: u32| self.detach_time(stream, entry) <= time;
        // Few or none since the last frame: look ahead in steps that double.
        let (mut low, mut step) = (least, 1);
        while low < stream.list_count && gone((low + step - 1).min(stream.list_count - 1)) {
            low = (low + step).min(stream.list_count);
            step *= 2;
        }
        let mut high = (low + step - 1).min(stream.list_count);
        while low < high {
            let middle = u32::midpoint(low, high);
            if gone(middle) { low = middle + 1 } else { high = middle }
        }
        low
    }

    /// The leaf of an entry, and how far from the straight line of its fall it may be, metres.
    fn falling_leaf(&self, fall: &Fall<'_>, stream: &Stream, entry: u32) -> (FallingLeaf, f32) {
        let record = self.record(stream, entry);
        let model = &self.models[stream.model as usize];
        let own = unpack_rotation([record.orientation_xy, record.orientation_zw]);
        let detach_time = self.detach_time(stream, entry);
        let leaf_fall = LeafFall {
            origin: stream.place(record.center),
            twig_orientation: Quat::from_rotation_y(stream.sin_yaw.atan2(stream.cos_yaw)) * own,
            tree: stream.position,
            seed: hash(stream.seed, record.rank),
            group: stream.path_group,
            detach_time: f64::from(detach_time),
        };
        let landing = fall.landing(&leaf_fall);
        let scale = record.scale * stream.scale;
        let stack = scale * stream.thickness + 0.002 + 0.012 * unit(hash(leaf_fall.seed, 13));
        let wind = &self.falls.wind;
        let next = entry + stream.keep;
        let from_center = (record.center - model.crown_center) / model.crown_extent;
        let [material, ambient, bent_x, bent_y] = record.look.to_le_bytes();
        let bent = from_octahedral(Vec2::new(from_snorm8(bent_x), from_snorm8(bent_y)));
        let bent = octahedral(stream.turned(bent));
        let [twig_xy, twig_zw] = pack_rotation(leaf_fall.twig_orientation);
        let [lying_xy, lying_zw] = pack_rotation(landing.orientation);
        let from_line = |i: i32| {
            let time = leaf_fall.detach_time + f64::from(landing.time) * f64::from(i) / 8.0;
            let place = fall.pose(&leaf_fall, &landing, time).position;
            from_segment(place, leaf_fall.origin, landing.position)
        };
        let can_be_small = self.plan.bins[stream.bin as usize].simple.is_some();
        let reach = if can_be_small { (1..8).map(from_line).fold(0.0, f32::max) } else { 0.0 };
        let leaf = FallingLeaf {
            origin: leaf_fall.origin,
            detach_time,
            landing: landing.position.extend(landing.time),
            late: wind.travel.dot(stream.position.xz()) * wind.slowness,
            model: stream.model as f32,
            vanish_time: if next < stream.list_count {
                self.detach_time(stream, next)
            } else {
                NEVER
            },
            ripe: ripeness(stream.season_offset, stream.seed, from_center),
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
        (leaf, reach)
    }

    /// Puts the leaf of an entry where those of its size in the view are.
    fn look(&mut self, s: u32, entry: u32) {
        let stream = self.plan.streams[s as usize];
        if self.plan.bins[stream.bin as usize].simple.is_none() {
            return;
        }
        let index = Self::slot(&stream, entry);
        let slot = self.slots[index];
        let length = 2.0 * stream.radius * stream.scale * self.record(&stream, entry).scale;
        let now = self.moment.map_or(0.0, |(time, _)| time);
        let (before, margin) = match slot.place {
            Place::Nowhere => return,
            Place::Falling(at) => {
                let leaf = &self.falling.regions[region(&stream, slot.small)].items[at as usize];
                let end = leaf.landing.truncate();
                let (line, reach) =
                    if slot.landed { ((end, end), 0.0) } else { ((leaf.origin, end), slot.reach) };
                let margin = self.eye.margin(length, line, reach);
                let crown = &self.models[stream.model as usize].crown;
                // As its tree's leaves hang, so it lets go.
                let free = leaf.detach_time + LETTING_GO <= now;
                let tree = if free { NEVER } else { self.eye.margin_of_tree(&stream, crown) };
                (at, margin.min(tree))
            }
            Place::Litter(at) => {
                let leaf = &self.litter.regions[region(&stream, slot.small)].items[at as usize];
                (at, self.eye.margin(length, (leaf.position, leaf.position), 0.0))
            }
        };
        let small = margin > 0.0;
        let look = self.eye.gone + margin.abs();
        if small != slot.small {
            let [from, to] = [slot.small, small].map(|small| region(&stream, small));
            match &mut self.slots[index].place {
                Place::Nowhere => {}
                Place::Falling(at) => {
                    let leaf = self.falling.regions[from].items[before as usize];
                    *at = self.falling.regions[to].push(leaf, index as u32);
                }
                Place::Litter(at) => {
                    let leaf = self.litter.regions[from].items[before as usize];
                    *at = self.litter.regions[to].push(leaf, index as u32);
                }
            }
            self.take_out(from, slot.place);
        }
        let slot = &mut self.slots[index];
        (slot.small, slot.look) = (small, look);
        if look.is_finite() {
            self.looks.push(Due { time: look, stream: s, entry });
        }
    }

    fn remove(&mut self, stream: &Stream, entry: u32) {
        let index = Self::slot(stream, entry);
        let slot = self.slots[index];
        if slot.landed {
            self.landed -= 1;
        }
        self.slots[index] = NO_LEAF;
        self.take_out(region(stream, slot.small), slot.place);
    }

    /// Takes a leaf out of a region's list; the last takes its place.
    fn take_out(&mut self, region: usize, place: Place) {
        let moved = match place {
            Place::Nowhere => None,
            Place::Falling(at) => self.falling.regions[region].swap_remove(at),
            Place::Litter(at) => self.litter.regions[region].swap_remove(at),
        };
        if let Some(moved) = moved {
            self.slots[moved as usize].place = place;
        }
    }

    /// Counts what has landed, and moves it to the litter as [`Elimination`] says.
    fn eliminate(&mut self, time: f32, season: f32) {
        self.checked = 0;
        for due in until(&mut self.landings, time) {
            if self.slot_of(&due).is_none() {
                continue;
            }
            let index = Self::slot(&self.plan.streams[due.stream as usize], due.entry);
            self.slots[index].landed = true;
            self.landed += 1;
            if self.falls.elimination == Elimination::Scheduled {
                self.checked += 1;
                self.lay_down(due, season);
            } else {
                self.look(due.stream, due.entry);
            }
        }
        let Elimination::Progressive { per_frame } = self.falls.elimination else {
            return;
        };
        for _ in 0..self.waiting.len().min(per_frame as usize) {
            let ready = |due: &&Due| due.time + LONG_ENOUGH <= time;
            let Some(&due) = self.waiting.front().filter(ready) else {
                break;
            };
            self.waiting.pop_front();
            self.checked += 1;
            match self.slot_of(&due) {
                Some(slot) if slot.landed => self.lay_down(due, season),
                Some(_) => self.waiting.push_back(due), // in its turn again
                None => {}
            }
        }
    }

    /// From the list of falling leaves to the litter.
    fn lay_down(&mut self, due: Due, season: f32) {
        let stream = self.plan.streams[due.stream as usize];
        let index = Self::slot(&stream, due.entry);
        let slot = self.slots[index];
        let Place::Falling(at) = slot.place else {
            return;
        };
        let region = region(&stream, slot.small);
        let leaf = self.falling.regions[region].items[at as usize];
        self.take_out(region, slot.place);
        let lying = litter_leaf(&leaf, &self.models[stream.model as usize], season);
        let at = self.litter.regions[region].push(lying, index as u32);
        self.slots[index].place = Place::Litter(at);
        self.look(due.stream, due.entry);
    }
}

/// Takes out what is due by `time`.
fn until(heap: &mut BinaryHeap<Due>, time: f32) -> Vec<Due> {
    let mut due = Vec::new();
    while let Some(next) = heap.peek().filter(|due| due.time <= time) {
        due.push(*next);
        heap.pop();
    }
    due
}

/// Where the lists have the leaves of a stream: for each bin first those with outlines, then small ones.
fn region(stream: &Stream, small: bool) -> usize {
    2 * stream.bin as usize + usize::from(small)
}

/// The twin of `loose_leaf` in `shaders/shared/loose.wgsl` for a leaf that lies, before it withers.
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

/// The twin of `ripeness` and `branch_ripeness` in `shaders/shared/season.wgsl`.
pub(crate) fn ripeness(season_offset: f32, seed: u32, from_center: Vec3) -> f32 {
    let wave = |way: Vec3, draw: u32| {
        let turns = from_center.dot(way) + unit(hash(seed, draw));
        (std::f32::consts::TAU * (turns - turns.floor())).sin()
    };
    let branch = 0.09 * wave(Vec3::new(0.83, 0.55, -0.61), 14)
        + 0.07 * wave(Vec3::new(-0.97, 1.13, 0.86), 15);
    season_offset + 0.12 * from_center.y + branch
}

/// The twin of `season_color` in `shaders/shared/loose.wgsl`.
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
    use crate::shared::Crown;
    use bytemuck::Zeroable;
    use windfall_core::forest::Placement;
    use windfall_core::tree::species::Species;

    /// Which listed leaves are small, by slot.
    fn small(roster: &Roster) -> Vec<Option<bool>> {
        let of = |slot: &Slot| (slot.place != Place::Nowhere).then_some(slot.small);
        roster.slots.iter().map(of).collect()
    }

    /// Leaves fall while the eye goes about among them, near and far: what it has seen before makes no
    /// difference, and the regions have what the slots say.
    #[test]
    fn leaves_are_small_or_large_by_the_view_alone() {
        let (device, _) = windfall_testing::device();
        let trees = [Species::Maple.grow_with(1, 300)];
        let placement = Placement {
            trees: 3,
            spacing: 8.0,
            keep_out: Vec::new(),
            scale: (0.8, 1.2),
            season_spread: 0.2,
            seed: 3,
        };
        let forest = placement.place(Terrain::rolling(200.0, 4.0, 5), &[1.0]);
        let crown = Crown {
            center: Vec3::new(0.0, 6.0, 0.0),
            radius: 9.0,
            leaf_length: 0.15,
            leaf_side: 0.06,
            ..Crown::zeroed()
        };
        let model = Model { crown, crown_extent: Vec3::splat(4.0), ..Model::zeroed() };
        let shedding = Shedding { start: 0.0, duration: 60.0, ..Shedding::default() };
        for elimination in Elimination::ALL {
            // Some vanish.
            let falls = Falls { shedding, elimination, capacity: 150, ..Falls::default() };
            let roster = || {
                let mut records = LeafRecords::new(&trees);
                let mut plan = Plan::new(&trees, &mut records, &forest, &falls);
                for bin in &mut plan.bins {
                    bin.simple = Some(trees[0].foliage.shapes[bin.shape].clone());
                }
                Roster::new(&device, plan, records, &[model], &forest, &falls)
            };
            let mut walked = roster();
            let mut seen = [0; 2];
            for frame in 0..200u32 {
                let draw = |key| unit(hash(frame / 20, key));
                // To a place of its own in each second, at times another size of the picture.
                let eye = Vec3::new(30.0 * draw(1) - 15.0, 1.7, 30.0 * draw(2) - 15.0)
                    + Vec3::X * (0.1 * (frame % 20) as f32);
                let pixels = if draw(3) > 0.7 { 200.0 } else { 120.0 };
                let view = TreeList { eye, pixels, leaf_pixels: 10.0, ..TreeList::zeroed() };
                let time = 0.3 * frame as f32;
                walked.update(time, 0.5, &view);
                if frame % 3 == 0 {
                    let mut fresh = roster();
                    fresh.update(time, 0.5, &view);
                    assert!(small(&walked) == small(&fresh), "{elimination}, frame {frame}");
                }
                let count = |small| {
                    let of = |region: usize| {
                        walked.falling.regions[region].items.len()
                            + walked.litter.regions[region].items.len()
                    };
                    (usize::from(small)..walked.falling.regions.len()).step_by(2).map(of).sum()
                };
                for (i, is_small) in [(0, false), (1, true)] {
                    let listed: usize = count(is_small);
                    let slots = small(&walked).iter().filter(|s| **s == Some(is_small)).count();
                    assert_eq!(listed, slots, "{elimination}, frame {frame}");
                    seen[i] += listed;
                }
            }
            // What is due later does not pile up where the eye stays.
            let mut still = roster();
            let view = TreeList { pixels: 120.0, leaf_pixels: 10.0, ..TreeList::zeroed() };
            for frame in 0..200u32 {
                still.update(0.3 * frame as f32, 0.5, &view);
                assert!(still.looks.len() <= 5 * still.slots.len(), "frame {frame}");
            }
            // Nor where time goes to and fro.
            for _ in 0..40 {
                still.update(20.0, 0.5, &view);
                still.update(19.9, 0.5, &view);
                assert!(still.frees.len() <= still.slots.len(), "{elimination}");
            }
            assert!(seen[0] > 5000 && seen[1] > 5000, "{seen:?} large and small leaves");
        }
    }
}
