//! A forest that grows, sheds and changes: trees of uploaded models on a terrain.

use crate::base::layouts::Layouts;
use crate::base::shared::{FallFrame, Frame, TreeRecord};
use crate::scene::events::Scripted;
use crate::scene::falls::Falls;
use crate::scene::ground::GroundMesh;
use crate::scene::model::TreeModel;
use crate::scene::tables;
use bytemuck::Zeroable;
use glam::{DVec3, Vec3, Vec4};
use std::sync::atomic::{AtomicU64, Ordering};
use windfall_core::forest::{Instance, Terrain};
use windfall_core::shed::{Shedding, TreeShedding};
use windfall_core::wind::Wind;

mod upload;
pub(crate) use upload::ForestBuffers;

/// Largest distance of a tree from its forest's origin, metres: beyond, single precision would show.
const FARTHEST: f64 = 20_000.0;

/// Where a tree stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TreePlace {
    /// Its foot in the world, metres; within 20 km of the forest's origin.
    pub position: DVec3,
    /// Turn about Y, radians.
    pub yaw: f32,
    /// Factor on the model's size, above 0.
    pub scale: f32,
    /// Added to the forest's season, `-1..=1`: this tree is earlier or later than the others.
    pub season_offset: f32,
    /// Key of everything that is random about this tree.
    pub seed: u32,
}

impl TreePlace {
    /// An unturned tree of the model's size, in season.
    pub fn at(position: DVec3, seed: u32) -> Self {
        Self { position, yaw: 0.0, scale: 1.0, season_offset: 0.0, seed }
    }
}

/// A tree of a forest. Not reused: that of a removed tree stays invalid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TreeId {
    index: u32,
    generation: u32,
}

/// What a forest cannot do.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ForestError {
    /// The model is of another device.
    #[error("the tree model {name:?} was uploaded to another device than the forest's")]
    OtherDevice {
        /// The model.
        name: String,
    },
    /// There is no such tree (any more).
    #[error("{0:?} is not of this forest, or was removed")]
    NoSuchTree(TreeId),
    /// An instance refers to a model that is not there.
    #[error("instance {instance}: model {model} is not one of the {models}")]
    NoSuchModel {
        /// Index of the instance.
        instance: usize,
        /// What it refers to.
        model: u32,
        /// How many models there are.
        models: usize,
    },
    /// The tree has no such leaf.
    #[error("leaf {leaf} is not one of the {leaves} of the tree")]
    NoSuchLeaf {
        /// The leaf.
        leaf: u32,
        /// Leaves of the tree.
        leaves: u32,
    },
    /// A number is not finite, not above 0 where it must be, or too large.
    #[error("{what} is {value}; it must be {wanted}")]
    Number {
        /// Which number.
        what: &'static str,
        /// What it is.
        value: f64,
        /// What it must be.
        wanted: &'static str,
    },
    /// More leaves in the air and on the ground than a binding of the device holds.
    #[error(
        "{leaves} leaves in the air and on the ground are more than the {most} that the device binds"
    )]
    TooManyLeaves {
        /// Leaves that are wanted.
        leaves: u64,
        /// Leaves that fit.
        most: u64,
    },
    /// More trees than a binding of the device holds.
    #[error("{trees} trees are more than the {most} that the device binds")]
    TooManyTrees {
        /// Trees that are wanted.
        trees: u64,
        /// Trees that fit.
        most: u64,
    },
}

/// Numbers of a whole forest.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ForestTotals {
    /// Trees.
    pub trees: u64,
    /// Their leaves.
    pub leaves: u64,
    /// Their triangles, unsimplified.
    pub triangles: u64,
}

/// A tree, as the forest keeps it.
#[derive(Debug, Clone)]
struct Tree {
    generation: u32,
    model: usize,
    place: TreePlace,
    /// Its place among those of its model; known once it has one.
    slot: Option<u32>,
    /// Thrown leaves: leaf, and when it detaches, seconds on the forest's clock.
    thrown: Vec<(u32, f32)>,
    /// How many of them have a place in a stream.
    laid_out: usize,
}

/// A model of the forest, and what stands at its places.
struct Planted {
    model: TreeModel,
    path_group: u32,
    free: Vec<u32>,
    trees: u32,
}

/// A forest: trees on a terrain, whose leaves hang, fall and lie.
///
/// It may change at any time ([`Forest::insert`], [`Forest::throw`], ...); a change counts from the next
/// [`crate::Renderer::advance`] on. Everything else is a pure function of time.
///
/// World positions are double precision; the GPU sees places relative to the forest's origin. A world of
/// hundreds of kilometres has several forests.
pub struct Forest {
    pub(crate) device: wgpu::Device,
    pub(crate) layouts: Layouts,
    id: u64,
    origin: DVec3,
    terrain: Terrain,
    falls: Falls,
    /// The wind relative to the forest's origin.
    local_wind: Wind,
    season: f32,
    trees: Vec<Tree>,
    free: Vec<u32>,
    planted: Vec<Planted>,
    scripted: Scripted,
    scripted_changed: bool,
    /// Whether there is more than the buffers have room for.
    rebuild: bool,
    /// Trees without a place yet.
    homeless: Vec<usize>,
    /// Models and places that have changed.
    changed: Vec<(usize, u32)>,
    /// Trees of which more leaves have been thrown.
    thrown_changed: Vec<usize>,
    /// Streams for thrown leaves of each shape, by model.
    scripted_room: Vec<u32>,
    buffers: Option<ForestBuffers>,
    /// Counts rebuilds: views follow.
    structure: u64,
    generation: u32,
    /// Counts changes of trees, thrown leaves, wind and shedding.
    revision: u64,
    pub(crate) ground: GroundMesh,
    /// The moment that was recorded last.
    pub(crate) moment: Moment,
    /// The latest that was recorded since all slots were filled anew: they may hold what had detached by then.
    latest: f64,
    /// Linear colour of its litter.
    pub(crate) litter: Vec3,
    /// The moment's uniforms, and the structure that they are of.
    pub(crate) moment_group: Option<(u64, MomentGroup)>,
}

/// The uniforms of a moment, for passes that have no view.
pub(crate) struct MomentGroup {
    pub buffer: wgpu::Buffer,
    pub group: wgpu::BindGroup,
}

/// A moment of a forest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Seconds since the world began; any order of moments gives the same pictures.
    pub time: f64,
    /// Whether trees sway in the wind.
    pub sway: bool,
    /// Whether leaves are coloured by the loops of their path ([`crate::DebugView::Loops`]).
    pub color_loops: bool,
}

impl Moment {
    /// A moment of swaying trees in their own colours.
    pub fn at(time: f64) -> Self {
        Self { time, sway: true, color_loops: false }
    }
}

/// The model of a tree that was removed.
const GONE: usize = usize::MAX;

static NEXT_ID: AtomicU64 = AtomicU64::new(1);

fn check(
    what: &'static str,
    value: f64,
    good: bool,
    wanted: &'static str,
) -> Result<(), ForestError> {
    if good { Ok(()) } else { Err(ForestError::Number { what, value, wanted }) }
}

impl Forest {
    /// A forest without trees on a terrain about `origin`.
    ///
    /// # Errors
    ///
    /// [`ForestError::Number`] if the origin is not finite.
    pub fn new(
        device: &wgpu::Device,
        origin: DVec3,
        terrain: Terrain,
        falls: Falls,
    ) -> Result<Self, ForestError> {
        check("the origin's length", origin.length(), origin.is_finite(), "finite")?;
        let layouts = Layouts::new(device);
        Ok(Self {
            ground: GroundMesh::new(device, &layouts.heights, &terrain),
            local_wind: wind_at(&falls.wind, origin),
            layouts,
            device: device.clone(),
            id: NEXT_ID.fetch_add(1, Ordering::Relaxed),
            origin,
            terrain,
            falls,
            season: 0.5,
            trees: Vec::new(),
            free: Vec::new(),
            planted: Vec::new(),
            scripted: Scripted::default(),
            scripted_changed: true,
            rebuild: true,
            homeless: Vec::new(),
            changed: Vec::new(),
            thrown_changed: Vec::new(),
            scripted_room: Vec::new(),
            buffers: None,
            structure: 0,
            generation: 1,
            revision: 0,
            moment: Moment::at(0.0),
            latest: f64::NEG_INFINITY,
            litter: Vec3::ZERO,
            moment_group: None,
        })
    }

    /// Where its terrain's middle lies in the world.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Its ground, about the origin.
    pub fn terrain(&self) -> &Terrain {
        &self.terrain
    }

    /// How its leaves fall.
    pub fn falls(&self) -> &Falls {
        &self.falls
    }

    /// Phase of autumn, 0 late summer to 1 bare.
    pub fn season(&self) -> f32 {
        self.season
    }

    /// Trees, leaves and triangles.
    pub fn totals(&self) -> ForestTotals {
        self.planted.iter().fold(ForestTotals::default(), |sum, planted| {
            let trees = u64::from(planted.trees);
            ForestTotals {
                trees: sum.trees + trees,
                leaves: sum.leaves + trees * u64::from(planted.model.leaf_count),
                triangles: sum.triangles + trees * planted.model.triangles,
            }
        })
    }

    /// Its trees, in the order in which they were planted.
    pub fn trees(&self) -> impl Iterator<Item = (TreeId, &TreeModel, &TreePlace)> {
        (0..).zip(&self.trees).filter(|(_, tree)| tree.model != GONE).map(|(index, tree)| {
            let id = TreeId { index, generation: tree.generation };
            (id, &self.planted[tree.model].model, &tree.place)
        })
    }

    /// Plants trees of models, placed about the forest's origin ([`windfall_core::forest::Placement`]).
    ///
    /// # Errors
    ///
    /// Those of [`Forest::insert`], and [`ForestError::NoSuchModel`]; no tree is planted then.
    pub fn plant(
        &mut self,
        models: &[TreeModel],
        instances: &[Instance],
    ) -> Result<Vec<TreeId>, ForestError> {
        let place = |instance: &Instance| TreePlace {
            position: self.origin + instance.position.as_dvec3(),
            yaw: instance.yaw,
            scale: instance.scale,
            season_offset: instance.season_offset,
            seed: instance.seed,
        };
        let mut places = Vec::with_capacity(instances.len());
        for (i, instance) in instances.iter().enumerate() {
            let Some(model) = models.get(instance.model as usize) else {
                let model = instance.model;
                return Err(ForestError::NoSuchModel { instance: i, model, models: models.len() });
            };
            let place = place(instance);
            self.check_place(&place)?;
            places.push((model, place));
        }
        for model in models {
            self.planted(model)?;
        }
        places.into_iter().map(|(model, place)| self.insert(model, place)).collect()
    }

    /// Plants a tree.
    ///
    /// # Errors
    ///
    /// A model of another device, and numbers that are not finite or out of range.
    pub fn insert(&mut self, model: &TreeModel, place: TreePlace) -> Result<TreeId, ForestError> {
        self.check_place(&place)?;
        let model = self.planted(model)?;
        self.planted[model].trees += 1;
        let tree =
            Tree { generation: 0, model, place, slot: None, thrown: Vec::new(), laid_out: 0 };
        let index = if let Some(index) = self.free.pop() {
            let generation = self.trees[index as usize].generation + 1;
            self.trees[index as usize] = Tree { generation, ..tree };
            index
        } else {
            self.trees.push(tree);
            self.trees.len() as u32 - 1
        };
        self.homeless.push(index as usize);
        self.revision += 1;
        Ok(TreeId { index, generation: self.trees[index as usize].generation })
    }

    /// Removes a tree with its leaves, wherever they are.
    ///
    /// # Errors
    ///
    /// [`ForestError::NoSuchTree`].
    pub fn remove(&mut self, tree: TreeId) -> Result<(), ForestError> {
        let index = self.find(tree)?;
        let Tree { model, slot, .. } = self.trees[index];
        self.revision += 1;
        self.planted[model].trees -= 1;
        self.clear_thrown(index);
        if let (Some(buffers), Some(place)) = (&mut self.buffers, slot) {
            buffers.set_place(model, place, None);
            self.planted[model].free.push(place);
            self.changed.push((model, place));
        }
        self.trees[index].model = GONE;
        self.trees[index].thrown.clear();
        self.free.push(tree.index);
        Ok(())
    }

    /// Moves a tree with its leaves, those on the ground included: where they are follows from where it stands.
    ///
    /// # Errors
    ///
    /// [`ForestError::NoSuchTree`], and numbers that are not finite or out of range.
    pub fn set_transform(
        &mut self,
        tree: TreeId,
        position: DVec3,
        yaw: f32,
        scale: f32,
    ) -> Result<(), ForestError> {
        let index = self.find(tree)?;
        let place = TreePlace { position, yaw, scale, ..self.trees[index].place };
        self.check_place(&place)?;
        self.clear_thrown(index);
        self.revision += 1;
        self.trees[index].place = place;
        self.place_again(index);
        Ok(())
    }

    /// Throws a leaf: it detaches at `time` (seconds since the world began), falls, lands and lies as any other.
    /// The earliest of a leaf's times counts, and none that comes when the season has taken the leaf.
    /// `leaf` is its index in the model's `Foliage::leaves`: in prune order.
    ///
    /// # Errors
    ///
    /// [`ForestError::NoSuchTree`], [`ForestError::NoSuchLeaf`], a time that is not finite.
    pub fn throw(&mut self, tree: TreeId, leaf: u32, time: f64) -> Result<(), ForestError> {
        let index = self.find(tree)?;
        let model = self.trees[index].model;
        let leaves = self.planted[model].model.leaf_count;
        if leaf >= leaves {
            return Err(ForestError::NoSuchLeaf { leaf, leaves });
        }
        check("the time", time, time.is_finite(), "finite")?;
        let time = (time - self.epoch()) as f32;
        match self.trees[index].thrown.iter_mut().find(|(known, _)| *known == leaf) {
            Some((_, known)) if *known <= time => return Ok(()),
            Some((_, known)) => {
                *known = time;
                self.clear_thrown(index);
            }
            None => self.trees[index].thrown.push((leaf, time)),
        }
        self.thrown_changed.push(index);
        self.revision += 1;
        Ok(())
    }

    /// Sets the phase of autumn, 0 late summer to 1 bare; leaves change their colours.
    ///
    /// # Errors
    ///
    /// If it is not finite.
    pub fn set_season(&mut self, season: f32) -> Result<(), ForestError> {
        check("the season", season.into(), season.is_finite(), "finite, from 0 to 1")?;
        self.season = season.clamp(0.0, 1.0);
        Ok(())
    }

    /// Sets the wind. Leaves in the air and on the ground are where this wind has taken them.
    pub fn set_wind(&mut self, wind: Wind) {
        self.falls.wind = wind;
        self.local_wind = wind_at(&wind, self.origin);
        self.reseason();
    }

    /// Sets when leaves detach.
    pub fn set_shedding(&mut self, shedding: Shedding) {
        let before = self.epoch();
        self.falls.shedding = shedding;
        // Times of thrown leaves stay where they are on the world's clock.
        let later = (before - self.epoch()) as f32;
        for tree in &mut self.trees {
            tree.thrown.iter_mut().for_each(|(_, time)| *time += later);
        }
        self.scripted = Scripted::default();
        self.scripted_changed = true;
        self.reseason();
    }

    /// Bytes of GPU memory of its trees and leaves, without its models and views.
    pub fn bytes(&self) -> u64 {
        let Some(buffers) = &self.buffers else { return 0 };
        let loose = &buffers.loose;
        let slots = u64::from(loose.streams.slot_count) * (Falls::STATE_BYTES + 4);
        slots
            + [&buffers.tree_buffer, &buffers.model_buffer, &buffers.part_buffer]
                .iter()
                .map(|b| b.size())
                .sum::<u64>()
            + loose.stream_buffer.size()
            + loose.list_buffer.size()
    }

    /// The forest, and a number that changes with its trees, thrown leaves, wind or shedding: for layers that
    /// pose leaves themselves.
    #[doc(hidden)]
    pub fn revision(&self) -> (u64, u64) {
        (self.id, self.revision)
    }

    /// The wind relative to the forest's origin.
    #[doc(hidden)]
    pub fn local_wind(&self) -> &Wind {
        &self.local_wind
    }

    /// The moment that was recorded last.
    #[doc(hidden)]
    pub fn moment(&self) -> Moment {
        self.moment
    }

    /// When the clock of detach times is 0, seconds since the world began.
    #[doc(hidden)]
    pub fn clock_start(&self) -> f64 {
        self.epoch()
    }

    /// Its models; [`TreeRecord::model`] is an index into them.
    #[doc(hidden)]
    pub fn models(&self) -> impl Iterator<Item = &TreeModel> {
        self.planted.iter().map(|planted| &planted.model)
    }

    /// Each tree, and its thrown leaves: leaf, and when it detaches, seconds on the clock of detach times.
    #[doc(hidden)]
    pub fn tree_records(&self) -> impl Iterator<Item = (TreeRecord, &[(u32, f32)])> {
        let standing = (0..self.trees.len()).filter(|&index| self.trees[index].model != GONE);
        standing.map(|index| (self.record(index), &self.trees[index].thrown[..]))
    }

    pub(crate) fn id(&self) -> u64 {
        self.id
    }

    pub(crate) fn structure(&self) -> u64 {
        self.structure
    }

    pub(crate) fn wind(&self) -> &Wind {
        &self.local_wind
    }

    /// What is on the GPU; there after the first [`Forest::begin`].
    pub(crate) fn buffers(&self) -> Option<&ForestBuffers> {
        self.buffers.as_ref()
    }
}

impl Forest {
    /// The model's index; it joins the forest if it is new.
    fn planted(&mut self, model: &TreeModel) -> Result<usize, ForestError> {
        if model.device != self.device {
            return Err(ForestError::OtherDevice { name: model.name().to_owned() });
        }
        if let Some(index) = self.planted.iter().position(|p| p.model == *model) {
            return Ok(index);
        }
        self.rebuild = true;
        let path_group = self.falls.group_of(model.name());
        let model = model.clone();
        self.planted.push(Planted { model, path_group, free: Vec::new(), trees: 0 });
        Ok(self.planted.len() - 1)
    }

    fn check_place(&self, place: &TreePlace) -> Result<(), ForestError> {
        let away = (place.position - self.origin).length();
        check(
            "a tree's distance from the forest's origin",
            away,
            away <= FARTHEST,
            "finite, at most 20000 m",
        )?;
        check("a tree's yaw", place.yaw.into(), place.yaw.is_finite(), "finite")?;
        let scale = place.scale;
        check("a tree's scale", scale.into(), scale.is_finite() && scale > 0.0, "above 0")?;
        let season = place.season_offset;
        check("a tree's season offset", season.into(), season.is_finite(), "finite")
    }

    fn find(&self, tree: TreeId) -> Result<usize, ForestError> {
        match self.trees.get(tree.index as usize) {
            Some(known) if known.generation == tree.generation && known.model != GONE => {
                Ok(tree.index as usize)
            }
            _ => Err(ForestError::NoSuchTree(tree)),
        }
    }

    /// When the clock of the leaves is 0: when the shedding begins, or the world does where it never does.
    fn epoch(&self) -> f64 {
        let start = self.falls.shedding.start;
        if start.abs() < 1e12 { start } else { 0.0 }
    }

    /// Times of the leaves' clock as two numbers.
    pub(crate) fn clock(&self, time: f64) -> [f32; 2] {
        crate::base::packing::split_time(time - self.epoch())
    }

    fn detach_time(&self, record: &TreeRecord, leaves: u32, rank: u32) -> f32 {
        let shed = TreeShedding {
            delay: record.delay,
            gust_phase: record.gust_phase,
            seed: record.seed,
            leaves,
        };
        let shedding = &self.falls.shedding;
        let start = (shedding.start - self.epoch()) as f32;
        start + shedding.detach_after_start(&shed, Shedding::gust_rate(&self.local_wind), rank)
    }

    fn record(&self, index: usize) -> TreeRecord {
        let Tree { model, place, thrown, .. } = &self.trees[index];
        let instance = Instance {
            model: 0,
            position: (place.position - self.origin).as_vec3(),
            yaw: place.yaw,
            scale: place.scale,
            season_offset: place.season_offset,
            seed: place.seed,
        };
        let leaves = self.planted[*model].model.leaf_count;
        let shed = self.falls.shedding.tree(&instance, leaves, &self.local_wind);
        let (sin_yaw, cos_yaw) = instance.yaw.sin_cos();
        TreeRecord {
            position: instance.position,
            scale: instance.scale,
            cos_yaw,
            sin_yaw,
            season_offset: instance.season_offset,
            delay: shed.delay,
            gust_phase: shed.gust_phase,
            seed: instance.seed,
            model: *model as u32,
            index_events: 2 * index as u32 + u32::from(!thrown.is_empty()),
        }
    }

    /// Wind or shedding are other ones: every tree sheds at other times, every leaf lies elsewhere.
    fn reseason(&mut self) {
        self.generation += 1;
        self.latest = self.moment.time;
        self.revision += 1;
        let Some(buffers) = &mut self.buffers else { return };
        let frame = &mut buffers.loose.frame;
        tables::describe_wind(frame, &self.local_wind, 0.0);
        tables::describe_shedding(frame, &self.falls.shedding);
        for index in 0..self.trees.len() {
            if self.trees[index].model != GONE {
                self.place_again(index);
            }
        }
    }

    /// The leaves' uniforms of the moment, from their constants.
    #[doc(hidden)]
    pub fn fall_frame(&self, constants: FallFrame) -> FallFrame {
        let Moment { time, color_loops, .. } = self.moment;
        let [high, low] = self.clock(time);
        let mut frame = constants;
        let epoch = self.epoch();
        tables::describe_wind(&mut frame, &self.local_wind, epoch);
        FallFrame {
            time: high,
            time_low: low,
            clock: Wind::reduced(time - epoch),
            shed_start: (self.falls.shedding.start - epoch) as f32,
            generation: self.generation,
            color_loops: u32::from(color_loops),
            ..frame
        }
    }

    /// Fills in what every pass knows of the forest's moment.
    pub(crate) fn describe(&self, frame: &mut Frame) {
        let wind = &self.local_wind;
        let Moment { time, sway, .. } = self.moment;
        frame.gusts =
            wind.gusts.map(|g| Vec4::new(g.amplitude.x, g.amplitude.y, g.cycles as f32, g.phase));
        frame.wind_mean = wind.mean;
        frame.wind_travel = wind.travel;
        frame.wind_slowness = wind.slowness;
        frame.time = Wind::reduced(time);
        frame.cloud_drift = (wind.mean.as_dvec2() * time * 0.002).as_vec2();
        [frame.shed_time, frame.shed_time_low] = self.clock(time);
        frame.season = self.season;
        frame.sway = f32::from(u8::from(sway));
        frame.backdrop = self.ground.backdrop;
        frame.litter = self.litter;
    }

    /// The forest's moment for passes that have no view.
    pub(crate) fn frame(&self) -> Frame {
        let mut frame = Frame::zeroed();
        self.describe(&mut frame);
        frame
    }
}

/// A wind seen from another origin: its gusts come there at other times.
fn wind_at(wind: &Wind, origin: DVec3) -> Wind {
    let along = f64::from(wind.travel.x) * origin.x + f64::from(wind.travel.y) * origin.z;
    let late = along * f64::from(wind.slowness) / Wind::PERIOD;
    let mut local = *wind;
    for gust in &mut local.gusts {
        let phase = f64::from(gust.phase) - f64::from(gust.cycles) * late;
        gust.phase = phase.rem_euclid(1.0) as f32;
    }
    if late == 0.0 { *wind } else { local }
}
