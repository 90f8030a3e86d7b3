//! Runs the examples and holds their pictures against references.
#![expect(clippy::duplicate_mod, reason = "each example has its own copy of what they share")]

#[path = "../examples/host_pass.rs"]
#[expect(dead_code, reason = "the test calls render, not main")]
mod host_pass;
#[path = "../examples/own_tree.rs"]
#[expect(dead_code, reason = "the test calls render, not main")]
mod own_tree;
#[path = "../examples/split_screen.rs"]
#[expect(dead_code, reason = "the test calls render, not main")]
mod split_screen;

use windfall::tree::{Species, export_glb};
use windfall_testing::{Snapshots, Tolerance};

const SIZE: (u32, u32) = (320, 180);

fn compare(name: &str, size: (u32, u32), rgba: &[u8]) {
    Snapshots::of_crate(env!("CARGO_MANIFEST_DIR")).assert(name, size, rgba, Tolerance::default());
}

#[test]
fn a_host_draws_foliage_into_its_own_passes() {
    let picture = host_pass::render(SIZE).unwrap();
    compare("host_pass", SIZE, &picture);
}

#[test]
fn two_views_of_two_forests_are_drawn_in_one_submission() {
    compare("split_screen", SIZE, &split_screen::render(SIZE).unwrap());
}

#[test]
fn a_tree_file_becomes_a_forest() {
    let folder = tempfile::tempdir().unwrap();
    let (tree, picture) = (folder.path().join("birch.glb"), folder.path().join("birches.png"));
    std::fs::write(&tree, export_glb(&Species::Birch.grow(1)).unwrap()).unwrap();
    own_tree::render(&tree, &picture).unwrap();
    let picture = image::open(&picture).unwrap();
    let small = picture.resize_exact(SIZE.0, SIZE.1, image::imageops::FilterType::Triangle);
    compare("own_tree", SIZE, &small.to_rgba8());
}

#[test]
fn a_file_that_is_no_tree_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let tree = folder.path().join("stone.glb");
    std::fs::write(&tree, "a stone").unwrap();
    let error = own_tree::render(&tree, &folder.path().join("never.png")).unwrap_err();
    assert!(error.to_string().contains("stone.glb"), "{error:#}");
    assert!(!folder.path().join("never.png").exists());
}
