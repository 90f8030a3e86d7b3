//! The forests and views of the bench.

use glam::Vec3;
use windfall_core::foliage::{Foliage, Holes};
use windfall_core::forest::{Forest, Frustum, Instance, Placement, Terrain};
use windfall_core::simplify::{Growth, Level, Reduction, Seen, Simplification, simple_shapes};
use windfall_core::tree::Tree;
use windfall_gpu::{Camera, Falls, Quality, View};
use windfall_scenes::Stage;

/// Trees of `models` on level ground, crowns touching.
pub fn plant(models: Vec<Tree>, trees: u32) -> Stage {
    let placement = Placement {
        trees,
        spacing: 7.0,
        keep_out: Vec::new(),
        scale: (0.8, 1.2),
        season_spread: 0.12,
        seed: 17,
    };
    let forest = placement.place(Terrain::flat(), &vec![1.0; models.len()]);
    Stage { trees: models, forest, falls: Falls::none() }
}

/// The same forest without its leaves.
pub fn bald(stage: &Stage) -> Stage {
    let mut bald = stage.clone();
    for tree in &mut bald.trees {
        tree.foliage = Foliage {
            materials: tree.foliage.materials.clone(),
            crown_center: tree.foliage.crown_center,
            ..Foliage::default()
        };
    }
    bald
}

/// Trees of `models` all around the middle, as many to each side, 95 to 105 m away: culled or not, all
/// are simplified alike. Crowns stand in each other, which costs nothing.
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
    Stage { trees: models, forest, falls: Falls::none() }
}

/// From the middle of a ring of trees to the side, or straight up, where none are.
pub fn within(fov_y: f32, up: bool, detail: Simplification) -> View {
    let eye = Vec3::new(0.0, 6.0, 0.0);
    let target = eye + if up { Vec3::Y } else { Vec3::NEG_Z };
    let camera = Camera { eye, target, fov_y, near: 0.1 };
    View { shadows: false, quality: Quality::LOW, detail, season: 0.55, ..View::new(camera) }
}

/// From the edge of the forest across it, at three times a man's height; unsimplified, without
/// shadows and at the lowest quality: leaves and their culling alone.
pub fn across(stage: &Stage, fov_y: f32, detail: Simplification) -> View {
    let edge = stage.forest.instances.iter().map(|i| i.position.length()).fold(1.0, f32::max);
    let camera = Camera {
        eye: Vec3::new(0.0, 5.0, edge + 12.0),
        target: Vec3::new(0.0, 5.0, 0.0),
        fov_y,
        near: 0.1,
    };
    View { shadows: false, quality: Quality::LOW, detail, season: 0.55, ..View::new(camera) }
}

/// From over the middle of the forest, where trees out of the view are as near as those in it.
pub fn amid(fov_y: f32, detail: Simplification) -> View {
    let camera = Camera {
        eye: Vec3::new(0.0, 30.0, 0.0),
        target: Vec3::new(0.0, 10.0, -60.0),
        fov_y,
        near: 0.1,
    };
    View { shadows: false, quality: Quality::LOW, detail, season: 0.55, ..View::new(camera) }
}

/// The paper's simplification: survivors grow as equation 3 says, whatever it takes.
pub fn paper(h: f32, d0: f32) -> Simplification {
    Simplification {
        reduction: Reduction::Distance { d0 },
        h,
        growth: Growth::UNBOUNDED,
        ..Simplification::DEFAULT
    }
}

/// The trees of a view: index of the instance, and how it is seen.
pub fn seen(stage: &Stage, view: &View, (width, height): (u32, u32)) -> Vec<(usize, Seen)> {
    let frustum = Frustum::new(view.camera.clip_from_world(width as f32 / height as f32));
    let mut trees = all_trees(stage, view, height);
    trees.retain(|(i, seen)| {
        let instance = &stage.forest.instances[*i];
        let (low, high) = stage.trees[instance.model as usize].bounds();
        frustum.sees_sphere(instance.world_from_tree((low + high) * 0.5), seen.radius)
    });
    trees
}

/// All trees of a stage, as they would be seen.
pub fn all_trees(stage: &Stage, view: &View, height: u32) -> Vec<(usize, Seen)> {
    let bounds: Vec<(Vec3, f32, f32, f32, Holes)> = stage
        .trees
        .iter()
        .map(|tree| {
            let (low, high) = tree.bounds();
            let foliage = &tree.foliage;
            let radius = (high - low).length() * 0.5;
            let (length, side) = (foliage.leaf_length(), foliage.leaf_side());
            ((low + high) * 0.5, radius, length, side, foliage.holes())
        })
        .collect();
    let instances = stage.forest.instances.iter().enumerate();
    instances
        .map(|(i, instance)| {
            let (center, radius, leaf_length, leaf_side, holes) = bounds[instance.model as usize];
            let center = instance.world_from_tree(center);
            let foliage = &stage.trees[instance.model as usize].foliage;
            let seen = Seen {
                distance: center.distance(view.camera.eye),
                pixels: view.camera.pixels(height),
                radius: radius * instance.scale,
                leaf_length: leaf_length * instance.scale,
                leaf_side: leaf_side * instance.scale,
                holes,
                visibility: foliage.visibility,
            };
            (i, seen)
        })
        .collect()
}

/// Vertices of the trees of a view, unsimplified.
pub fn vertices(stage: &Stage, view: &View, size: (u32, u32)) -> f64 {
    let of = |i: usize| stage.trees[stage.forest.instances[i].model as usize].vertex_count() as f64;
    seen(stage, view, size).iter().map(|(i, _)| of(*i)).sum()
}

/// `Σ λN / Σ N` over the trees of a view.
pub fn lambda_total(stage: &Stage, view: &View, size: (u32, u32)) -> f64 {
    let (mut kept, mut all) = (0.0, 0.0);
    for (i, seen) in seen(stage, view, size) {
        let model = stage.forest.instances[i].model as usize;
        let leaves = stage.trees[model].foliage.leaves.len() as f64;
        all += leaves;
        kept += leaves * f64::from(view.detail.level(&seen).lambda);
    }
    kept / f64::max(all, 1.0)
}

/// The argument between `low` and `high` at which a rising function has a value.
pub fn solve(mut low: f32, mut high: f32, value: f64, f: impl Fn(f32) -> f64) -> f32 {
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if f(middle) < value { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// The leaves of some trees as one mesh in world space: what a bare draw is given; and how many they are.
pub fn leaves_in_world(
    stage: &Stage,
    view: &View,
    trees: Vec<(usize, Seen)>,
) -> (Vec<Vec3>, Vec<u32>, u64) {
    let (mut positions, mut indices, mut leaves) = (Vec::new(), Vec::new(), 0);
    let simple: Vec<_> = stage.trees.iter().map(|tree| simple_shapes(&tree.foliage)).collect();
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
            let far = view.detail.simple(&level, &seen);
            let simple = simple[instance.model as usize][leaf.shape as usize].as_ref();
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
    (positions, indices, leaves)
}

/// The view in the opposite direction.
pub fn away(view: &View) -> View {
    let camera = view.camera;
    let target = camera.eye * 2.0 - camera.target;
    View { camera: Camera { target, ..camera }, ..*view }
}
