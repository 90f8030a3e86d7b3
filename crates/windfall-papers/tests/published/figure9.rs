//! VB 2008, figure 9: ambient occlusion of leaves, off and on.

use crate::harness::HARNESS;
use crate::strategies::{scene, shot};
use windfall_papers::{ListOptions, Strategy};

/// In crowns in full leaf, without shadows: leaves inside are darker, and none is lighter.
#[test]
fn ambient_occlusion_darkens_leaves_inside_of_crowns() {
    let scene = scene();
    let passes = HARNESS.passes(Strategy::Vertex, false);
    let mut stage = scene.published(passes, ListOptions::default());
    let mut shot = shot(-13.0);
    shot.view.shadows = false;
    let with = stage.paint(&shot);
    shot.view.quality.ambient_occlusion = false;
    let without = stage.paint(&shot);
    let light = |p: &[u8]| p[..3].iter().map(|&c| i32::from(c)).sum::<i32>();
    let pixels = || with.chunks_exact(4).zip(without.chunks_exact(4));
    let count =
        |test: &dyn Fn(i32) -> bool| pixels().filter(|(a, b)| test(light(b) - light(a))).count();
    let all = pixels().count();
    let (darkened, lightened) = (count(&|by| by > 12), count(&|by| by < -3));
    println!("of {all} pixels {darkened} are darker with it, {lightened} lighter");
    assert!(darkened > all / 50, "{darkened} of {all}");
    assert!(lightened < all / 1000, "{lightened} of {all}");
}
