//! The examples' pictures against their references. `WINDFALL_BLESS=1` writes these anew.

mod scene;

#[path = "../examples/forest.rs"]
mod forest;
#[path = "../examples/own_tree.rs"]
mod own_tree;
#[path = "../examples/season_slider.rs"]
mod season_slider;
#[path = "../examples/split_screen.rs"]
mod split_screen;
#[path = "../examples/throw.rs"]
mod throw;

use bevy::prelude::*;
use scene::headless::Headless;
use windfall_testing::{Snapshots, Tolerance};

fn check(name: &str, build: impl FnOnce(&mut App), time: f64) {
    let size = UVec2::new(320, 180);
    let image = Headless::new(size, build).picture(time);
    let bytes = image.data.expect("a screenshot has its data");
    let references = Snapshots::of_crate(env!("CARGO_MANIFEST_DIR"));
    references.assert(name, (size.x, size.y), &bytes, Tolerance::default());
}

#[test]
fn a_walk_through_a_forest() {
    check("forest", forest::build, 40.0);
}

#[test]
fn six_species_in_autumn() {
    check("season_slider", season_slider::build, 20.0);
}

#[test]
fn two_players() {
    check("split_screen", split_screen::build, 30.0);
}

#[test]
fn a_shaken_tree() {
    check("throw", throw::build, 10.0);
}

#[test]
fn a_tree_from_a_file() {
    check("own_tree", own_tree::build, 20.0);
}
