//! The forests and views of parts a and b, and what a view sees of a forest.

use crate::scenery::{clip_from_world, pixels, stage};
use glam::{DVec3, Quat, Vec3};
use windfall_core::foliage::{Foliage, Holes};
use windfall_core::forest::{Forest, Frustum, Instance, Placement, Terrain};
use windfall_core::simplify::{Growth, LeafForm, Level, Reduction, Seen, Simplification};
use windfall_core::tree::Tree;
use windfall_gpu::{Camera, Falls, Quality, View};
use windfall_scenes::Stage;

/// A forest of `models` on level ground, with touching crowns.
pub fn forest(models: Vec<Tree>, trees: u32) -> Stage {
    let placement = Placement {
        trees,
        spacing: 7.0,
        keep_out: Vec::new(),
        scale: (0.8, 1.2),
        season_spread: 0.12,
        seed: 17,
    };
    let forest = placement.place(Terrain::flat(), &vec![1.0; models.len()]);
    stage(models, forest, Falls::none())
}

/// The same forest without its leaves.
pub fn without_leaves(stage: &Stage) -> Stage {
    let mut stage = stage.clone();
    for tree in &mut stage.trees {
        tree.foliage = Foliage {
            materials: tree.foliage.materials.clone(),
            crown_center: tree.foliage.crown_center,
            ..Foliage::default()
        };
    }
    stage
}

/// A ring of trees of `models` around the origin, evenly distributed, 95 to 105 m away, so that
/// trees in view and trees out of view are simplified alike. Crowns overlap, which costs nothing.
pub fn ring(models: Vec<Tree>, trees: u32) -> Stage {
    let golden = std::f32::consts::PI * (3.0 - 5.0f32.sqrt());
    let count = models.len() as u32;
    let instances = (0..trees).map(|i| {
        let (sin, cos) = (golden * i as f32).sin_cos();
        let distance = 95.0 + 10.0 * (i as f32 + 0.5) / trees as f32;
        Instance {
            model: i % count,
            position: Vec3::new(sin, 0.0, cos) * distance,
            yaw: i as f32,
            scale: 1.0,
            season_offset: 0.0,
            seed: i,
        }
    });
    let forest = Forest { terrain: Terrain::flat(), instances: instances.collect() };
    stage(models, forest, Falls::none())
}

/// Without shadows and at the lowest quality, so that most of a frame's cost is leaves and culling.
fn view(eye: DVec3, target: DVec3, fov_y: f32, detail: Simplification) -> View {
    let camera = Camera::look_at(eye, target, fov_y, 0.1);
    View { shadows: false, quality: Quality::PLAIN, detail, ..View::new(camera) }
}

/// From the edge of the forest across it, from a height of 5 m.
pub fn view_across(stage: &Stage, fov_y: f32, detail: Simplification) -> View {
    let edge = stage.forest.instances.iter().map(|i| i.position.length()).fold(1.0, f32::max);
    let eye = DVec3::new(0.0, 5.0, f64::from(edge + 12.0));
    view(eye, DVec3::new(0.0, 5.0, 0.0), fov_y, detail)
}

/// From above the middle of the forest, where trees out of view are as near as trees in view.
pub fn view_from_middle(fov_y: f32, detail: Simplification) -> View {
    view(DVec3::new(0.0, 30.0, 0.0), DVec3::new(0.0, 10.0, -60.0), fov_y, detail)
}

/// From the middle of a ring of trees to one side; or with `up` to the sky, without a tree in view.
pub fn view_from_ring_center(fov_y: f32, up: bool, detail: Simplification) -> View {
    let eye = DVec3::new(0.0, 6.0, 0.0);
    view(eye, eye + if up { DVec3::Y } else { DVec3::NEG_Z }, fov_y, detail)
}

/// The view in the opposite direction.
pub fn opposite(view: &View) -> View {
    let camera = view.camera;
    let rotation = camera.rotation * Quat::from_rotation_y(std::f32::consts::PI);
    View { camera: Camera { rotation, ..camera }, ..view.clone() }
}

/// The paper's simplification: leaves grow as equation 3 says, without a bound.
pub fn paper_simplification(h: f32, d0: f32) -> Simplification {
    Simplification {
        reduction: Reduction::Distance { d0 },
        h,
        growth: Growth::UNBOUNDED,
        ..Simplification::DEFAULT
    }
}

/// The trees in a view: indices of the instances, and how they are seen.
pub fn visible_trees(
    stage: &Stage,
    view: &View,
    (width, height): (u32, u32),
) -> Vec<(usize, Seen)> {
    let frustum = Frustum::new(clip_from_world(&view.camera, width as f32 / height as f32));
    let mut trees = all_trees(stage, view, height);
    trees.retain(|(i, seen)| {
        let instance = &stage.forest.instances[*i];
        let (low, high) = stage.trees[instance.model as usize].bounds();
        frustum.sees_sphere(instance.world_from_tree((low + high) * 0.5), seen.radius)
    });
    trees
}

/// All trees of a stage, in view or not: indices of the instances, and how they would be seen.
pub fn all_trees(stage: &Stage, view: &View, height: u32) -> Vec<(usize, Seen)> {
    let models: Vec<(Vec3, f32, f32, [f32; 2], f32, Holes)> = stage
        .trees
        .iter()
        .map(|tree| {
            let (low, high) = tree.bounds();
            let foliage = &tree.foliage;
            let radius = (high - low).length() * 0.5;
            let (length, side) = (foliage.leaf_length(), foliage.leaf_side());
            let lengths = foliage.leaf_lengths();
            ((low + high) * 0.5, radius, length, lengths, side, foliage.holes())
        })
        .collect();
    let (eye, pixels) = (view.camera.eye.as_vec3(), pixels(&view.camera, height));
    let instances = stage.forest.instances.iter().enumerate();
    instances
        .map(|(i, instance)| {
            let (center, radius, leaf_length, leaf_lengths, leaf_side, holes) =
                models[instance.model as usize];
            let center = instance.world_from_tree(center);
            let foliage = &stage.trees[instance.model as usize].foliage;
            let seen = Seen {
                distance: center.distance(eye),
                pixels,
                radius: radius * instance.scale,
                leaf_length: leaf_length * instance.scale,
                leaf_lengths: leaf_lengths.map(|length| length * instance.scale),
                leaf_side: leaf_side * instance.scale,
                holes,
                visibility: foliage.visibility,
            };
            (i, seen)
        })
        .collect()
}

/// The form of a leaf of mean length in the middle of a tree.
pub fn mean_form(detail: &Simplification, level: &Level, seen: &Seen) -> LeafForm {
    let pixels = seen.leaf_length * level.growth * seen.pixels / seen.distance.max(1e-3);
    detail.leaf_form(pixels, true)
}

/// Vertices of the trees in a view, unsimplified.
pub fn vertex_count(stage: &Stage, view: &View, size: (u32, u32)) -> f64 {
    let of = |i: usize| stage.trees[stage.forest.instances[i].model as usize].vertex_count() as f64;
    visible_trees(stage, view, size).iter().map(|(i, _)| of(*i)).sum()
}

/// `Σ λN / Σ N` over the trees in a view.
pub fn lambda_total(stage: &Stage, view: &View, size: (u32, u32)) -> f64 {
    let (mut kept, mut all) = (0.0, 0.0);
    for (i, seen) in visible_trees(stage, view, size) {
        let model = stage.forest.instances[i].model as usize;
        let leaves = stage.trees[model].foliage.leaves.len() as f64;
        all += leaves;
        kept += leaves * f64::from(view.detail.level(&seen).lambda);
    }
    kept / f64::max(all, 1.0)
}

/// The argument between `low` and `high` at which the rising function `f` has a value, by
/// bisection.
pub fn bisect(mut low: f32, mut high: f32, value: f64, f: impl Fn(f32) -> f64) -> f32 {
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if f(middle) < value { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Leaves as one mesh in world space.
pub struct LeafMesh {
    pub positions: Vec<Vec3>,
    pub indices: Vec<u32>,
    /// Leaves in the mesh.
    pub leaves: u64,
}

impl LeafMesh {
    /// The leaves that the renderer draws of `trees` in `view`, with the same shapes and sizes.
    pub fn new(stage: &Stage, view: &View, trees: Vec<(usize, Seen)>) -> Self {
        let (mut positions, mut indices, mut leaves) = (Vec::new(), Vec::new(), 0);
        for (i, seen) in trees {
            let instance = &stage.forest.instances[i];
            let foliage = &stage.trees[instance.model as usize].foliage;
            let level: Level = view.detail.level(&seen);
            let rotation = instance.rotation();
            for (rank, leaf) in foliage.leaves.iter().enumerate() {
                let rank = rank as f32 / foliage.leaves.len() as f32;
                let visible = view.detail.visible(&level, rank);
                if visible <= 0.0 {
                    if rank > level.lambda + level.radius {
                        break;
                    }
                    continue;
                }
                leaves += 1;
                let far = mean_form(&view.detail, &level, &seen) == LeafForm::Simple;
                let simple = foliage.simple_shapes[leaf.shape as usize].as_ref();
                let shape = &foliage.shapes[leaf.shape as usize];
                let shape = simple.filter(|_| far).unwrap_or(shape);
                let first = positions.len() as u32;
                let grown = leaf.scale * level.growth * visible.sqrt();
                positions.extend(shape.positions.iter().map(|&p| {
                    let in_tree = leaf.center + leaf.orientation * p * grown;
                    instance.position + rotation * in_tree * instance.scale
                }));
                indices.extend(shape.indices.iter().map(|i| first + i));
            }
        }
        Self { positions, indices, leaves }
    }
}
