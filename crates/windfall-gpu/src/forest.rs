//! A forest in the GPU's memory.

use crate::falls::{Falls, GpuFalls};
use crate::listed::ListedFalls;
use crate::model::GpuModel;
use crate::pass::ground::GroundMesh;
use crate::pass::shadow::{CASCADES, Volume};
use crate::renderer::Renderer;
use crate::shared::{Model, TreeInstance};
use crate::strategy::Strategy;
use glam::Vec3;
use std::sync::Mutex;
use windfall_core::forest::{Forest, Instance};
use windfall_core::shed::{Shedding, TreeShedding};
use windfall_core::tree::Tree;
use windfall_core::wind::Wind;

/// [`TreeInstance`] as a vertex buffer.
pub(crate) const TREE_ATTRIBUTES: [wgpu::VertexAttribute; 3] =
    wgpu::vertex_attr_array![8 => Float32x4, 9 => Float32x4, 10 => Uint32x2];

fn tree_instance(instance: &Instance, shed: &TreeShedding) -> TreeInstance {
    let (sin_yaw, cos_yaw) = instance.yaw.sin_cos();
    TreeInstance {
        position: instance.position,
        scale: instance.scale,
        cos_yaw,
        sin_yaw,
        season_offset: instance.season_offset,
        lambda: 1.0,
        seed: instance.seed,
        detached: 0,
        delay: shed.delay,
        gust_phase: shed.gust_phase,
        leaf_count: shed.leaves,
        padding0: 0,
        padding1: 0,
        padding2: 0,
    }
}

/// Trees of one model that are drawn in a frame: a range of the instance buffer.
pub(crate) type Visible = std::ops::Range<u32>;

/// A forest uploaded once and drawn in many frames.
pub struct GpuForest {
    pub(crate) models: Vec<GpuModel>,
    pub(crate) ground: GroundMesh,
    pub(crate) instances: wgpu::Buffer,
    pub(crate) falls: GpuFalls,
    /// The leaves of a strategy without compute; `falls` is then empty.
    pub(crate) listed: Option<Mutex<ListedFalls>>,
    shedding: Shedding,
    gust_rate: f32,
    pub(crate) wind: Wind,
    pub(crate) detach_group: wgpu::BindGroup,
    /// Trees by model, with their bounding spheres.
    trees: Vec<Vec<(TreeInstance, Vec3, f32)>>,
    wood_triangles: Vec<u64>,
    leaf_triangles: Vec<u64>,
}

/// What a frame held and drew.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FrameStats {
    /// Trees of the forest.
    pub trees: u64,
    /// Trees whose bounding sphere touches the view.
    pub trees_visible: u64,
    /// Leaves of all trees.
    pub leaves_total: u64,
    /// Leaves of the visible trees, wherever they are.
    pub leaves_visible: u64,
    /// Triangles of all trees, unsimplified.
    pub triangles_full: u64,
    /// Triangles of the trees in view.
    pub triangles_drawn: u64,
    /// Leaves on the twigs of the visible trees; 0 for [`Strategy::Compute`], which counts on the
    /// GPU.
    pub leaves_hanging: u64,
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

    /// Uploads `forest` whose leaves fall.
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
        let models: Vec<GpuModel> = trees
            .iter()
            .map(|tree| GpuModel::new(device, queue, &renderer.part_layout, tree))
            .collect();
        let mut by_model: Vec<Vec<(TreeInstance, Vec3, f32)>> = vec![Vec::new(); models.len()];
        for instance in &forest.instances {
            let model = &models[instance.model as usize];
            by_model[instance.model as usize].push((
                tree_instance(
                    instance,
                    &falls.shedding.tree(instance, model.leaf_count, &falls.wind),
                ),
                instance.world_from_tree(model.center),
                model.radius * instance.scale,
            ));
        }
        let instances = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("visible trees"),
            // Once for the view and once for each shadow map.
            size: (forest.instances.len().max(1) * size_of::<TreeInstance>() * (1 + CASCADES))
                as u64,
            usage: wgpu::BufferUsages::VERTEX
                | wgpu::BufferUsages::STORAGE
                | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let uniforms: Vec<Model> = models.iter().map(|m| m.uniform).collect();
        let wind = falls.wind;
        let (shedding, gust_rate) = (falls.shedding, Shedding::gust_rate(&falls.wind));
        let listed = (falls.strategy != Strategy::Compute).then(|| {
            let passes = &renderer.listed;
            ListedFalls::new(device, queue, passes, trees, &uniforms, forest, falls)
        });
        let on_gpu = if listed.is_some() { &Falls::none() } else { falls };
        let falls = GpuFalls::new(device, &renderer.falls.layout, trees, &uniforms, forest, on_gpu);
        let detach_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("detach"),
            layout: &renderer.falls.detach_layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: falls.uniform.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: instances.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 2, resource: falls.counters.as_entire_binding() },
            ],
        });
        Self {
            falls,
            listed: listed.map(Mutex::new),
            wind,
            shedding,
            gust_rate,
            detach_group,
            ground: GroundMesh::new(device, renderer.grass_layout(), &forest.terrain),
            instances,
            trees: by_model,
            wood_triangles: trees.iter().map(|t| t.wood_triangles() as u64).collect(),
            leaf_triangles: trees.iter().map(|t| t.foliage.triangle_count() as u64).collect(),
            models,
        }
    }

    /// Appends the trees that a volume holds to `trees`; per model their range. How many leaves
    /// have left them by `time` is found here where no compute pass does it.
    pub(crate) fn cull(
        &self,
        volume: &Volume<'_>,
        time: f32,
        trees: &mut Vec<TreeInstance>,
    ) -> Vec<Visible> {
        let ranges = self.trees.iter().map(|model| {
            let first = trees.len() as u32;
            let inside = model.iter().filter(|(_, center, radius)| volume.holds(*center, *radius));
            trees.extend(inside.map(|tree| match self.listed {
                Some(_) => TreeInstance { detached: self.detached(&tree.0, time), ..tree.0 },
                None => tree.0,
            }));
            first..trees.len() as u32
        });
        ranges.collect()
    }

    /// What a frame holds that draws these trees.
    pub(crate) fn stats(&self, visible: &[Visible]) -> FrameStats {
        let mut stats = FrameStats::default();
        for (m, (trees, range)) in self.trees.iter().zip(visible).enumerate() {
            let (all, drawn) = (trees.len() as u64, range.len() as u64);
            let leaves = u64::from(self.models[m].leaf_count);
            let triangles = self.wood_triangles[m] + self.leaf_triangles[m];
            stats.trees += all;
            stats.trees_visible += drawn;
            stats.leaves_total += all * leaves;
            stats.leaves_visible += drawn * leaves;
            stats.triangles_full += all * triangles;
            stats.triangles_drawn += drawn * triangles;
        }
        stats
    }

    /// Leaves that have left a tree by `time`.
    fn detached(&self, tree: &TreeInstance, time: f32) -> u32 {
        let tree = TreeShedding {
            delay: tree.delay,
            gust_phase: tree.gust_phase,
            seed: tree.seed,
            leaves: tree.leaf_count,
        };
        self.shedding.detached(&tree, self.gust_rate, time)
    }
}
