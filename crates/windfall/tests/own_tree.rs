//! Runs the example `own_tree` and looks at its picture.

#[path = "../examples/own_tree.rs"]
#[expect(dead_code, reason = "the test calls render, not main")]
mod own_tree;

use image::Rgb;
use windfall::tree::export_glb;
use windfall::tree::species::Species;

#[test]
fn a_tree_file_becomes_a_forest_between_sky_and_ground() {
    let folder = tempfile::tempdir().unwrap();
    let (tree, picture) = (folder.path().join("birch.glb"), folder.path().join("birches.png"));
    std::fs::write(&tree, export_glb(&Species::Birch.grow(1)).unwrap()).unwrap();
    own_tree::render(&tree, &picture).unwrap();

    let picture = image::open(&picture).unwrap().to_rgb8();
    let share = |rows: std::ops::Range<u32>, is: fn(&Rgb<u8>) -> bool| {
        let pixels = rows.len() as f32 * picture.width() as f32;
        let rows = rows.flat_map(|y| (0..picture.width()).map(move |x| (x, y)));
        rows.filter(|&(x, y)| is(picture.get_pixel(x, y))).count() as f32 / pixels
    };
    let height = picture.height();
    // Blue at least as strong as red, and bright: sky. Red over blue: earth, litter and autumn.
    let sky = share(0..height / 20, |p| p[2] >= p[0] && p[2] > 90);
    let ground = share(height * 19 / 20..height, |p| p[0] >= p[2] && p[1] < 220);
    let leaves =
        share(height / 3..height * 2 / 3, |p| i32::from(p[0].max(p[1])) > 60 + i32::from(p[2]));
    assert!(sky > 0.3, "sky {sky}");
    assert!(ground > 0.7, "ground {ground}");
    assert!(leaves > 0.1, "leaves {leaves}");
    assert!(leaves < 0.98, "leaves and nothing else: {leaves}");
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
