//! The forests and views of parts a, b and c.

use crate::scenery::stage;
use glam::Vec3;
use windfall_core::forest::{Placement, Terrain};
use windfall_core::shed::Shedding;
use windfall_core::simplify::Simplification;
use windfall_core::tree::Tree;
use windfall_gpu::{Camera, Falls, Quality, View};
use windfall_scenes::Stage;
use windfall_tree::Species;

/// Frames of the whole walk, 30 per second (VB: "more than 3000").
const WALK_FRAMES: f32 = 3000.0;

/// Seven trees with about a million triangles; VB 6.3 has 800 thousand.
pub fn grove() -> Stage {
    grove_of(7, 7400)
}

/// A grove of some trees of four species with `leaves` leaves each.
pub fn grove_of(trees: u32, leaves: u32) -> Stage {
    let count = trees;
    let species: [Species; 4] = [Species::Maple, Species::Oak, Species::Birch, Species::Beech];
    let trees: Vec<Tree> = species.iter().map(|s| s.grow_with(1, leaves)).collect();
    let placement = Placement {
        trees: count,
        spacing: 7.0,
        keep_out: Vec::new(),
        scale: (0.9, 1.1),
        season_spread: 0.1,
        seed: 5,
    };
    let weights = vec![1.0; trees.len()];
    let forest = placement.place(Terrain::rolling(200.0, 2.0, 3), &weights);
    stage(trees, forest, Falls::default())
}

/// The view at a moment of a walk once around the grove in [`WALK_FRAMES`].
pub fn walkthrough(stage: &Stage, time: f64) -> View {
    let angle = time as f32 * 30.0 / WALK_FRAMES * std::f32::consts::TAU;
    let (x, z) = (21.0 * angle.sin(), 21.0 * angle.cos());
    let eye = Vec3::new(x, stage.forest.terrain.height(x, z) + 1.7, z);
    view(eye, Vec3::new(0.0, 5.5, 0.0))
}

/// `count` leaves of one shape. They detach between four and two seconds before time 0, so that
/// nearly all of them are in the air at time 0.
pub fn shower(count: u32) -> Stage {
    let of_tree = count.min(1 << 16);
    let trees = vec![Species::Beech.grow_with(3, of_tree)];
    let placement = Placement {
        trees: (count / of_tree).max(1),
        spacing: 6.0,
        keep_out: Vec::new(),
        scale: (1.0, 1.0),
        season_spread: 0.0,
        seed: 7,
    };
    let falls = Falls {
        shedding: Shedding { start: -4.0, duration: 2.0, peak: 0.0, tree_spread: 0.0, burst: 0.0 },
        capacity: count,
        ..Falls::default()
    };
    stage(trees, placement.place(Terrain::flat(), &[1.0]), falls)
}

/// A view of the whole shower.
pub fn overview(stage: &Stage) -> View {
    view(Vec3::new(0.0, 12.0, 1.6 * extent(stage, 0.0) + 24.0), Vec3::new(0.0, 6.0, 0.0))
}

/// Distance of the outermost tree from the origin, at least `least`.
pub fn extent(stage: &Stage, least: f32) -> f32 {
    stage.forest.instances.iter().map(|i| i.position.length()).fold(least, f32::max)
}

fn view(eye: Vec3, target: Vec3) -> View {
    View {
        meadow: 0.5,
        trails: Default::default(),
        shadows: false,
        // All leaves; small ones have two triangles, as by default.
        detail: Simplification { h: 0.0, wood_pixels: 0.0, ..Simplification::DEFAULT },
        quality: Quality::PLAIN,
        ..View::new(Camera::look_at(eye.as_dvec3(), target.as_dvec3(), 0.9, 0.1))
    }
}
