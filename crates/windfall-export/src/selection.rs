//! Which leaves are exported, and where each of them is at a moment.

use crate::frame::{Filter, Kind, LeafId, LeafState, Moments, Source};
use glam::{DVec3, Quat, Vec3};
use std::collections::BTreeMap;
use windfall_core::foliage::season::withering;
use windfall_core::foliage::{Leaf, LeafShape};
use windfall_core::forest::Instance;
use windfall_core::path::{Fall, Landing, LeafFall, LeafPose, Phase, Variant, stack_height};
use windfall_core::shed::Shedding;
use windfall_core::tree::Tree;

/// A selected leaf.
#[derive(Debug, Clone, Copy)]
struct Selected {
    id: LeafId,
    detach: f64,
    landing: Landing,
}

/// Leaves of one kind that all move in the frames, or all do not.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Group {
    /// What they have in common.
    pub kind: Kind,
    /// Whether they do more than hang, or lie, in all frames alike.
    pub moves: bool,
    /// Which leaves of the selection they are.
    pub leaves: std::ops::Range<usize>,
}

/// The selected leaves: what is known of each before any frame. About 80 bytes a leaf.
pub struct Selection<'a> {
    source: &'a Source<'a>,
    fall: Fall<'a>,
    filter: Filter,
    moments: Moments,
    /// In the order of the groups, then of ids.
    leaves: Vec<Selected>,
    groups: Vec<Group>,
    models: Vec<ModelFacts>,
}

struct ModelFacts {
    path_group: u32,
    crown_extent: Vec3,
    thickness: Vec<f32>,
}

/// Half of the time between the two moments whose difference is a leaf's velocity, seconds.
const VELOCITY_STEP: f64 = 1.0 / 512.0;

impl<'a> Selection<'a> {
    /// Selects leaves. `eye` says where the camera is at a time; only [`Filter::most`] asks.
    pub fn new(
        source: &'a Source<'a>,
        moments: Moments,
        filter: Filter,
        eye: &dyn Fn(f64) -> DVec3,
    ) -> Self {
        let fall = Fall::new(
            source.paths,
            &source.forest.terrain,
            source.wind,
            source.variation.clone(),
            source.settings,
        );
        let facts = |tree: &Tree| ModelFacts {
            path_group: source.paths.group(&tree.name).unwrap_or(0),
            crown_extent: tree.foliage.crown_extent(),
            thickness: tree.foliage.shapes.iter().map(LeafShape::thickness).collect(),
        };
        let models = source.trees.iter().map(facts).collect();
        let mut selection =
            Self { source, fall, filter, moments, leaves: Vec::new(), groups: Vec::new(), models };
        let candidates = selection.candidates(eye);
        selection.arrange(candidates);
        selection
    }

    /// The leaves that the filter takes, each with the way in which it belongs to a group.
    fn candidates(&self, eye: &dyn Fn(f64) -> DVec3) -> Vec<((Kind, bool), Selected)> {
        let Self { source, filter, moments, .. } = self;
        let frames = || moments.frames().map(|f| moments.time(f));
        let eyes: Vec<Vec3> = match filter.most {
            Some(_) => frames().map(|time| eye(time).as_vec3()).collect(),
            None => Vec::new(),
        };
        let times: Vec<f64> = frames().collect();
        let mut thrown: BTreeMap<(u32, u32), f64> = BTreeMap::new();
        for event in &source.thrown {
            let time = thrown.entry((event.tree, event.leaf)).or_insert(f64::INFINITY);
            *time = time.min(event.time);
        }
        let rate = Shedding::gust_rate(&source.wind);
        let mut found: Vec<(f32, (Kind, bool), Selected)> = Vec::new();
        for (number, instance) in (0..).zip(&source.forest.instances) {
            let foliage = &source.trees[instance.model as usize].foliage;
            let count = foliage.leaves.len() as u32;
            let shed = source.shedding.tree(instance, count, &source.wind);
            let gone = source.shedding.detached(&shed, rate, moments.last_time());
            let mut consider = |index: u32| {
                let leaf = &foliage.leaves[index as usize];
                let season = source.shedding.detach_time(&shed, rate, leaf.shed_rank);
                let own = thrown.get(&(number, index)).copied();
                let detach = own.map_or(season, |own| season.min(own));
                let id = LeafId::new(number, index);
                if let Some((apart, moves, selected)) = self.consider(id, detach, &times, &eyes) {
                    let kind =
                        Kind { model: instance.model, shape: leaf.shape, material: leaf.material };
                    found.push((apart, (kind, moves), selected));
                }
            };
            if filter.parts.hanging {
                (0..count).for_each(&mut consider);
            } else {
                foliage.shed_order[..gone as usize].iter().copied().for_each(&mut consider);
                let of_tree = thrown.range((number, 0)..=(number, u32::MAX));
                for (&(_, index), _) in of_tree.filter(|((_, leaf), _)| *leaf < count) {
                    if foliage.leaves[index as usize].shed_rank >= gone {
                        consider(index);
                    }
                }
            }
            if let Some(most) = filter.most {
                // Room for as many again: each leaf is sorted out once in the mean.
                keep_nearest(&mut found, most, 2 * most + 1024);
            }
        }
        if let Some(most) = filter.most {
            keep_nearest(&mut found, most, most);
        }
        found.into_iter().map(|(_, group, selected)| (group, selected)).collect()
    }

    /// A leaf, if it is selected: its least distance from the eye, and whether it moves.
    fn consider(
        &self,
        id: LeafId,
        detach: f64,
        times: &[f64],
        eyes: &[Vec3],
    ) -> Option<(f32, bool, Selected)> {
        let end = *times.last()?;
        let (instance, leaf) = self.leaf(id);
        let fall = self.fall_of(instance, leaf, detach);
        let landing = if detach < end {
            self.fall.landing(&fall)
        } else {
            // It hangs in all frames.
            let (position, orientation) = (fall.origin, fall.twig_orientation);
            Landing { time: f32::INFINITY, position, orientation, settle: Quat::IDENTITY }
        };
        let selected = Selected { id, detach, landing };
        let parts = self.filter.parts;
        let phase = |time: f64| {
            let elapsed = (time - detach) as f32;
            match elapsed {
                _ if elapsed <= 0.0 => Phase::Hanging,
                _ if elapsed >= landing.time => Phase::Landed,
                _ => Phase::Falling { lap: 0 },
            }
        };
        let first = phase(times[0]);
        let moves =
            !(first == Phase::Hanging && phase(end) == Phase::Hanging) && first != Phase::Landed;
        if !moves && !parts.shows(first) {
            return None;
        }
        let (mut inside, mut nearest) = (false, f32::INFINITY);
        for (i, &time) in times.iter().enumerate() {
            let now = phase(time);
            if !parts.shows(now) {
                continue;
            }
            let place = match now {
                Phase::Hanging => fall.origin,
                Phase::Landed => landing.position,
                Phase::Falling { .. } => self.fall.pose(&fall, &landing, time).position,
            };
            if self.filter.holds(place) {
                inside = true;
                if let Some(eye) = eyes.get(i) {
                    nearest = nearest.min(eye.distance(place));
                } else {
                    break;
                }
            } else if !moves && eyes.is_empty() {
                break;
            }
        }
        inside.then_some((nearest, moves, selected))
    }

    fn arrange(&mut self, mut candidates: Vec<((Kind, bool), Selected)>) {
        candidates.sort_unstable_by_key(|(group, selected)| (*group, selected.id));
        for (i, ((kind, moves), _)) in candidates.iter().enumerate() {
            match self.groups.last_mut() {
                Some(group) if (group.kind, group.moves) == (*kind, *moves) => {
                    group.leaves.end = i + 1;
                }
                _ => self.groups.push(Group { kind: *kind, moves: *moves, leaves: i..i + 1 }),
            }
        }
        self.leaves = candidates.into_iter().map(|(_, selected)| selected).collect();
    }

    fn leaf(&self, id: LeafId) -> (&'a Instance, &'a Leaf) {
        let instance = &self.source.forest.instances[id.tree() as usize];
        let foliage = &self.source.trees[instance.model as usize].foliage;
        (instance, &foliage.leaves[id.leaf() as usize])
    }

    fn fall_of(&self, instance: &Instance, leaf: &Leaf, detach: f64) -> LeafFall {
        let group = self.models[instance.model as usize].path_group;
        LeafFall::of(instance, leaf, group, detach)
    }

    /// What is exported.
    pub fn source(&self) -> &'a Source<'a> {
        self.source
    }

    /// The filter.
    pub fn filter(&self) -> &Filter {
        &self.filter
    }

    /// The frames.
    pub fn moments(&self) -> Moments {
        self.moments
    }

    /// How many leaves are selected.
    pub fn len(&self) -> usize {
        self.leaves.len()
    }

    /// Whether no leaf is.
    pub fn is_empty(&self) -> bool {
        self.leaves.is_empty()
    }

    /// The leaves by kind, and by whether they move.
    pub fn groups(&self) -> &[Group] {
        &self.groups
    }

    /// Id of the `i`-th leaf of the selection.
    pub fn id(&self, i: usize) -> LeafId {
        self.leaves[i].id
    }

    /// Where the `i`-th leaf of the selection is at `time`, seconds, and its scale.
    fn pose(&self, i: usize, time: f64) -> (LeafPose, f32) {
        let Selected { id, detach, landing } = &self.leaves[i];
        let (instance, leaf) = self.leaf(*id);
        let fall = self.fall_of(instance, leaf, *detach);
        let scale = leaf.scale * instance.scale;
        let thickness = self.models[instance.model as usize].thickness[leaf.shape as usize];
        let stack = stack_height(&fall, scale, thickness);
        (self.fall.drawn_pose(&fall, landing, stack, time), scale)
    }

    /// The fall of the `i`-th leaf of the selection, its landing and its variant.
    pub(crate) fn fall_facts(&self, i: usize) -> (LeafFall, Landing, Variant) {
        let Selected { id, detach, landing } = &self.leaves[i];
        let (instance, leaf) = self.leaf(*id);
        let fall = self.fall_of(instance, leaf, *detach);
        (fall, *landing, self.fall.variant(&fall))
    }

    /// Height over the ground at which the `i`-th leaf of the selection lies, metres.
    pub(crate) fn lift(&self, i: usize) -> f32 {
        let Selected { id, detach, .. } = &self.leaves[i];
        let (instance, leaf) = self.leaf(*id);
        let fall = self.fall_of(instance, leaf, *detach);
        let thickness = self.models[instance.model as usize].thickness[leaf.shape as usize];
        stack_height(&fall, leaf.scale * instance.scale, thickness)
    }

    /// The `i`-th leaf of the selection at `time`, seconds.
    pub fn state(&self, i: usize, time: f64) -> LeafState {
        let (pose, scale) = self.pose(i, time);
        let Selected { id, detach, landing } = &self.leaves[i];
        let (instance, leaf) = self.leaf(*id);
        let extent = self.models[instance.model as usize].crown_extent;
        let foliage = &self.source.trees[instance.model as usize].foliage;
        let season = foliage.season_of(leaf, instance, self.source.season, extent);
        let mut color = foliage.season_color(&season);
        // A palette takes the place of the material's colour.
        if foliage.palette.is_none()
            && let Some(material) = foliage.materials.get(leaf.material as usize)
        {
            color *= material.base_color;
        }
        if pose.phase == Phase::Landed {
            color *= withering((time - detach) as f32 - landing.time);
        }
        LeafState {
            id: *id,
            phase: pose.phase,
            shown: self.filter.parts.shows(pose.phase),
            position: pose.position,
            orientation: pose.orientation,
            scale,
            color,
            season: season.phase,
        }
    }

    /// Velocity of the `i`-th leaf at `time`, metres a second; 0 unless it is in the air.
    pub fn velocity(&self, i: usize, time: f64) -> Vec3 {
        if !matches!(self.pose(i, time).0.phase, Phase::Falling { .. }) {
            return Vec3::ZERO;
        }
        let [before, after] =
            [-VELOCITY_STEP, VELOCITY_STEP].map(|step| self.pose(i, time + step).0.position);
        (after - before) / (2.0 * VELOCITY_STEP) as f32
    }

    /// The leaves that are shown at `time`, seconds.
    pub fn at(&self, time: f64) -> impl Iterator<Item = LeafState> + '_ {
        (0..self.leaves.len()).map(move |i| self.state(i, time)).filter(|leaf| leaf.shown)
    }

    /// Indices of the trees that are exported: all, or those that reach into the box.
    pub fn trees(&self) -> Vec<u32> {
        if !self.filter.parts.trees {
            return Vec::new();
        }
        let bounds: Vec<(Vec3, Vec3)> = self.source.trees.iter().map(Tree::bounds).collect();
        let reaches = |instance: &Instance| {
            let (low, high) = bounds[instance.model as usize];
            // Whatever way the tree is turned.
            let reach = Vec3::new(low.x, 0.0, low.z).abs().max(high.abs()).with_y(0.0).length();
            let at = instance.position;
            let low = at + Vec3::new(-reach, low.y, -reach) * instance.scale;
            let high = at + Vec3::new(reach, high.y, reach) * instance.scale;
            self.filter.within.is_none_or(|w| low.cmple(w.1).all() && high.cmpge(w.0).all())
        };
        let all = (0..).zip(&self.source.forest.instances);
        all.filter(|(_, instance)| reaches(instance)).map(|(number, _)| number).collect()
    }
}

/// Drops all but the `most` nearest where there are more than `room`; of equally near ones those of lower id stay.
fn keep_nearest(found: &mut Vec<(f32, (Kind, bool), Selected)>, most: usize, room: usize) {
    if found.len() <= room || found.len() <= most {
        return;
    }
    if most > 0 {
        found
            .select_nth_unstable_by(most - 1, |a, b| a.0.total_cmp(&b.0).then(a.2.id.cmp(&b.2.id)));
    }
    found.truncate(most);
}
