//! Lists of the trees that a view and its shadow maps draw: made by `pass::cull`.

use crate::base::constants::{BLOCK, BUCKETS, DRAW_WORDS, LISTS, TREE_TALLIES, VIEWS};
use crate::base::layouts::{self, Layouts};
use crate::base::shared::{CullFrame, TreeInstance, TreeList};
use crate::scene::falls::{LOOSE_SHADOWS, zeros};
use crate::scene::forest::ForestBuffers;
use crate::view::camera::Eye;
use crate::view::cascades::{Cascade, detail_of};
use crate::view::culling::Culling;
use crate::view::description::View;
use bytemuck::Zeroable;
use glam::{Mat4, Vec4};
use std::f32::consts::PI;
use windfall_core::forest::Frustum;
use windfall_core::simplify::{FadeRange, Reduction, Simplification};

impl TreeList {
    /// The trees of `clip_from_world` that are seen from the view's camera.
    pub fn new(
        clip_from_world: Mat4,
        eye: &Eye,
        detail: &Simplification,
        culling: Culling,
        lit_in_pixels: bool,
    ) -> Self {
        let (range_kind, range) = match detail.fade.range {
            FadeRange::Constant(c) => (0, c),
            FadeRange::Linear(c) => (1, c),
            FadeRange::Quadratic(c) => (2, c),
            FadeRange::Proportional(c) => (3, c),
        };
        let (by_area, reduction) = match detail.reduction {
            // What counts is how far a usual camera would be to see as much.
            Reduction::Distance { d0 } => (0, (d0 / eye.distance_scale).powi(2)),
            Reduction::ProjectedArea { b0 } => (1, PI / b0),
        };
        let flag = |on: bool| u32::from(on);
        Self {
            planes: Frustum::new(clip_from_world).planes(),
            clip_from_world,
            eye: eye.position,
            pixels: eye.pixels,
            exponent: detail.exponent(),
            reduction,
            contrast_pixels: detail.contrast_pixels.unwrap_or(0.0),
            range_kind,
            range,
            growth_factor: if detail.area_preservation { detail.growth.factor } else { -1.0 },
            growth_pixels: detail.growth.pixels,
            flags: flag(detail.fade.full_at_one)
                | flag(detail.fade.early) << 1
                | by_area << 2
                | flag(lit_in_pixels) << 3,
            culling: culling as u32,
            wood_pixels: detail.wood_pixels,
            leaf_pixels: detail.leaf_pixels,
            mean_cosine: detail.mean_cosine.unwrap_or(-1.0),
        }
    }
}

/// What the lists of a view are of.
pub fn cull_frame(
    view: &View,
    eye: &Eye,
    cascades: &[Cascade],
    buffers: &ForestBuffers,
    wind_speed: f32,
) -> CullFrame {
    let mut lists = [TreeList::zeroed(); VIEWS as usize];
    let culling = match view.culling {
        Culling::Occlusion if !centred(eye.clip_from_world) => Culling::Sphere,
        culling => culling,
    };
    let lit_in_pixels = view.quality.pixel_lighting;
    // What stands before the near plane of a map of the sun casts shadows too.
    let sides =
        if eye.orthographic { without_depth(eye.clip_from_world) } else { eye.clip_from_world };
    lists[0] = TreeList::new(sides, eye, &view.detail, culling, lit_in_pixels);
    for (i, (list, cascade)) in lists[1..].iter_mut().zip(cascades).enumerate() {
        let detail = detail_of(i, &view.shadow_detail);
        *list = TreeList::new(cascade.clip_from_world, eye, &detail, Culling::Sphere, false);
    }
    let tables = &buffers.tables;
    CullFrame {
        lists,
        near: eye.near,
        width: eye.width as f32,
        height: eye.height as f32,
        tree_count: tables.records.len() as u32,
        model_count: tables.crowns.len() as u32,
        draw_count: tables.parts.len() as u32,
        top_level: 0,
        wind_speed,
        shadow_reach: if cascades.is_empty() { 0.0 } else { LOOSE_SHADOWS },
        ..CullFrame::zeroed()
    }
}

/// Whether a view is what the kernel finds hidden trees for: in perspective, with the axis through the middle of the
/// picture and the far plane at infinity. Others are culled by spheres.
fn centred(clip_from_world: Mat4) -> bool {
    let forward = clip_from_world.row(3).truncate();
    let across = [0, 1, 2].map(|row| clip_from_world.row(row).truncate().dot(forward).abs());
    forward.length_squared() > 0.5 && across.iter().all(|share| *share < 1e-4)
}

/// A clip space in which nothing is too near.
fn without_depth(clip_from_world: Mat4) -> Mat4 {
    Mat4::from_diagonal(Vec4::new(1.0, 1.0, 0.0, 1.0)) * clip_from_world
}

/// The lists of one view of a forest on the GPU.
pub struct TreeLists {
    pub uniform: wgpu::Buffer,
    /// Indirect arguments by list and draw, then the tallies.
    pub arguments: wgpu::Buffer,
    /// Trees by list and place: an instance-step vertex buffer.
    pub placed: wgpu::Buffer,
    pub group: wgpu::BindGroup,
    pub blocks: u32,
    pub models: u32,
    draws: u64,
}

impl TreeLists {
    pub fn new(device: &wgpu::Device, layouts: &Layouts, buffers: &ForestBuffers) -> Self {
        let tables = &buffers.tables;
        let (lists, places) = (u64::from(LISTS), tables.records.len() as u64);
        let (blocks, draws) = (places / u64::from(BLOCK), tables.parts.len() as u64);
        let buckets = (blocks + tables.crowns.len() as u64) * u64::from(BUCKETS);
        let none = wgpu::BufferUsages::empty();
        let words = lists * draws * u64::from(DRAW_WORDS) + u64::from(TREE_TALLIES);
        let arguments = zeros(
            device,
            "tree draws",
            words * 4,
            wgpu::BufferUsages::INDIRECT | wgpu::BufferUsages::COPY_SRC,
        );
        let placed = zeros(
            device,
            "trees to draw",
            lists * places * size_of::<TreeInstance>() as u64,
            wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_SRC,
        );
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("lists of trees"),
            size: size_of::<CullFrame>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let group = layouts::group(
            device,
            "cull",
            &layouts.cull,
            &[
                uniform.as_entire_binding(),
                buffers.loose.uniform.as_entire_binding(),
                buffers.tree_buffer.as_entire_binding(),
                buffers.model_buffer.as_entire_binding(),
                buffers.part_buffer.as_entire_binding(),
                zeros(device, "tree buckets", lists * places * 4, none).as_entire_binding(),
                zeros(device, "trees of buckets", lists * buckets * 4, none).as_entire_binding(),
                arguments.as_entire_binding(),
                placed.as_entire_binding(),
            ],
        );
        Self {
            uniform,
            arguments,
            placed,
            group,
            blocks: blocks as u32,
            models: tables.crowns.len() as u32,
            draws,
        }
    }

    /// Where the tallies are in the arguments, bytes.
    pub fn tallies_offset(&self) -> u64 {
        u64::from(LISTS) * self.draws * u64::from(DRAW_WORDS) * 4
    }
}
