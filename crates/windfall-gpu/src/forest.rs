//! A forest in the GPU's memory.

use crate::cull::{CpuList, Trees};
use crate::events::Thrown;
use crate::falls::{Falls, GpuFalls};
use crate::listed::ListedFalls;
use crate::model::GpuModel;
use crate::pass::cull::{Cull, GpuLists};
use crate::pass::ground::GroundMesh;
use crate::pass::quads::HangingQuads;
use crate::renderer::Renderer;
use crate::shared::{Crown, Model, TreeList, TreeRecord};
use crate::strategy::Strategy;
use crate::view::View;
use glam::{Vec3, Vec3Swizzles};
use std::sync::Mutex;
use wgpu::util::DeviceExt;
use windfall_core::forest::Forest;
use windfall_core::shed::Shedding;
use windfall_core::simplify::Simplification;
use windfall_core::tree::Tree;
use windfall_core::wind::Wind;

/// [`TreeInstance`] as a vertex buffer.
pub(crate) const TREE_ATTRIBUTES: [wgpu::VertexAttribute; 4] =
    wgpu::vertex_attr_array![8 => Float32x4, 9 => Float32x4, 10 => Float32x4, 11 => Uint32x4];

/// Most leaves on the twigs that are drawn as quads, 64 bytes each. What there is more of is drawn as it was.
const MOST_QUADS: u32 = 1 << 20;

/// A forest uploaded once and drawn in many frames.
pub struct GpuForest {
    pub(crate) models: Vec<GpuModel>,
    pub(crate) ground: GroundMesh,
    pub(crate) trees: Trees,
    pub(crate) lists: GpuLists,
    /// Far leaves that the compute strategy draws as quads.
    pub(crate) quads: Option<HangingQuads>,
    pub(crate) falls: GpuFalls,
    /// The leaves of a strategy without compute; `falls` is then empty.
    pub(crate) listed: Option<Mutex<ListedFalls>>,
    shedding: Shedding,
    gust_rate: f32,
    pub(crate) wind: Wind,
    totals: FrameStats,
}

/// What a frame held and drew.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FrameStats {
    /// Trees of the forest.
    pub trees: u64,
    /// Leaves of all trees.
    pub leaves_total: u64,
    /// Triangles of all trees, unsimplified.
    pub triangles_full: u64,
    /// What was drawn; 0 for [`Strategy::Compute`], which counts on the GPU.
    pub drawn: TreeCounts,
    /// Leaves in the air; 0 for [`Strategy::Compute`], which counts on the GPU.
    pub leaves_falling: u64,
    /// Leaves on the ground; 0 for [`Strategy::Compute`].
    pub leaves_landed: u64,
    /// Of those, leaves that have become static geometry; 0 for [`Strategy::Compute`].
    pub leaves_eliminated: u64,
    /// Leaves looked at in this frame to see whether they have landed; 0 for
    /// [`Strategy::Compute`].
    pub leaves_checked: u64,
}

/// The trees of a frame, as they were drawn.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct TreeCounts {
    /// Trees in view.
    pub visible: u64,
    /// Their leaves, wherever they are.
    pub leaves: u64,
    /// `Σ λN` over them.
    pub leaves_by_lambda: u64,
    /// Leaves drawn on their twigs. Exact for trees in full; of simplified ones the expected number,
    /// since prune order and shed order do not depend on each other. Leaves of
    /// [`Falls::events`] are counted as if they hung until the season takes them.
    pub leaves_hanging: u64,
    /// Triangles of wood and leaves that were drawn, those of leaves that have left their twigs
    /// included.
    pub triangles: u64,
}

impl TreeCounts {
    /// Leaves drawn over leaves of the trees in view; 1 where there are none.
    pub fn lambda_total(&self) -> f64 {
        if self.leaves == 0 { 1.0 } else { self.leaves_by_lambda as f64 / self.leaves as f64 }
    }

    pub(crate) fn of(tallies: [u64; 5]) -> Self {
        let [visible, leaves, leaves_by_lambda, leaves_hanging, triangles] = tallies;
        Self { visible, leaves, leaves_by_lambda, leaves_hanging, triangles }
    }
}

impl GpuForest {
    /// Uploads `forest`, whose instances refer to `trees` by index. No leaf falls.
    ///
    /// # Panics
    ///
    /// If an instance refers to a model that is not in `trees`.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        renderer: &Renderer,
        trees: &[Tree],
        forest: &Forest,
    ) -> Self {
        Self::with_falls(device, queue, renderer, trees, forest, &Falls::none())
    }

    /// Uploads `forest` whose leaves fall. On a device without
    /// [`wgpu::Features::INDIRECT_FIRST_INSTANCE`] wood is not simplified, and the leaves of distant
    /// trees are shaded as finely as those of near ones.
    ///
    /// # Panics
    ///
    /// If an instance refers to a model that is not in `trees`.
    pub fn with_falls(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        renderer: &Renderer,
        trees: &[Tree],
        forest: &Forest,
        falls: &Falls,
    ) -> Self {
        let thrown = Thrown::new(trees, forest, falls);
        let events = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("events"),
            contents: bytemuck::cast_slice(&thrown.nodes()),
            usage: wgpu::BufferUsages::STORAGE,
        });
        let models: Vec<GpuModel> = trees
            .iter()
            .map(|tree| GpuModel::new(device, queue, &renderer.part_layout, tree, &events))
            .collect();
        let gpu_trees = Trees::new(&models, forest, falls, &thrown);
        let with_crown =
            |(model, crown): (&GpuModel, &Crown)| Model { crown: *crown, ..model.uniform };
        let uniforms: Vec<Model> = models.iter().zip(&gpu_trees.crowns).map(with_crown).collect();
        let list_uniform = Cull::uniform(device);
        let wind = falls.wind;
        let (shedding, gust_rate) = (falls.shedding, Shedding::gust_rate(&falls.wind));
        let listed = (falls.strategy != Strategy::Compute).then(|| {
            let models = (&models[..], &uniforms[..]);
            ListedFalls::new(device, queue, renderer, trees, models, forest, falls)
        });
        let on_gpu = if listed.is_some() { &Falls::none() } else { falls };
        let falls = GpuFalls::new(
            (device, queue),
            renderer,
            trees,
            (&models, &uniforms),
            forest,
            on_gpu,
            &list_uniform,
        );
        let lists =
            renderer.cull.lists(device, &gpu_trees, &uniforms, list_uniform, &falls.uniform);
        let mut totals = FrameStats::default();
        for instance in &forest.instances {
            let tree = &trees[instance.model as usize];
            totals.trees += 1;
            totals.leaves_total += tree.foliage.leaves.len() as u64;
            totals.triangles_full += (tree.wood_triangles() + tree.foliage.triangle_count()) as u64;
        }
        let mut out = Self {
            falls,
            quads: None,
            listed: listed.map(Mutex::new),
            wind,
            shedding,
            gust_rate,
            ground: GroundMesh::new(device, renderer.grass_layout(), &forest.terrain),
            trees: gpu_trees,
            lists,
            totals,
            models,
        };
        if out.listed.is_none() {
            out.quads = renderer.quads.hanging(device, &out, MOST_QUADS);
        }
        out
    }

    /// Numbers that do not change from frame to frame; the others are 0.
    pub(crate) fn stats(&self) -> FrameStats {
        self.totals
    }

    /// A bound of the speed of the wind that moves the trees, m/s.
    pub(crate) fn wind_speed(&self, view: &View) -> f32 {
        if view.quality.sway { self.wind.fastest() } else { 0.0 }
    }

    /// Makes a list on the CPU, for leaves or for wood.
    pub(crate) fn list_on_cpu(
        &self,
        list: &TreeList,
        wood: bool,
        detail: &Simplification,
        view: &View,
    ) -> CpuList {
        let detached = |tree: &TreeRecord, leaves: u32| {
            tree.detached(&self.shedding, self.gust_rate, leaves, view.time)
        };
        let velocity = |at: Vec3| self.wind.velocity(at, f64::from(view.time)).xz();
        let wind = &(self.wind_speed(view), velocity);
        let sun = view.sky.sun_direction();
        self.trees.list_on_cpu(list, wood, detail, detached, wind, sun)
    }
}
