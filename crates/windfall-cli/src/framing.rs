//! Cameras for trees that a scene was not made for.

use windfall_core::glam::DVec3;
use windfall_scenes::{Capsule, Scene, Stage};

/// Height of the trees that the built-in scenes are made for, metres.
const USUAL: f32 = 12.0;
/// Trees that are as high as these times the usual ones fit without a change.
const FITTING: std::ops::RangeInclusive<f32> = 0.5..=2.0;
/// Part of the picture that a single tree fills.
const FILL: f64 = 0.92;

/// Scales the camera's way, trails and clearings of a scene to the trees that were read, by their heights, where these are much smaller or
/// larger than those that the scene was made for.
pub fn fit_to_trees(scene: &mut Scene, heights: &[f32]) {
    if heights.is_empty() {
        return;
    }
    let mean = heights.iter().sum::<f32>() / heights.len() as f32;
    let factor = mean / USUAL;
    if FITTING.contains(&factor) || !(factor > 0.0 && factor.is_finite()) {
        return;
    }
    let by = f64::from(factor);
    for key in &mut scene.camera {
        for place in [&mut key.eye, &mut key.target] {
            *place = (place.0 * by, place.1 * by, place.2 * by);
        }
    }
    let strips: [&mut Vec<Capsule>; 2] = [&mut scene.keep_out, &mut scene.trails];
    for strip in strips.into_iter().flatten() {
        strip.from = (strip.from.0 * by, strip.from.1 * by);
        strip.to = (strip.to.0 * by, strip.to.1 * by);
        strip.radius *= factor;
    }
}

/// Looks at the only tree of a stage, from the side that the scene looks from, so that it fills the picture.
pub fn look_at_tree(scene: &mut Scene, stage: &Stage) {
    let Some(placed) = stage.forest.instances.first() else { return };
    let (low, high) = stage.trees[placed.model as usize].bounds();
    let (low, high) = ((low * placed.scale).as_dvec3(), (high * placed.scale).as_dvec3());
    let Some(key) = scene.camera.first().copied() else { return };
    // Turned about its foot, the tree is as wide as its farthest corner.
    let wide = [low.x, high.x, low.z, high.z].into_iter().map(f64::abs).fold(0.0, f64::max);
    let foot = placed.position.as_dvec3();
    let target = DVec3::new(foot.x, f64::midpoint(low.y, high.y), foot.z);
    let from = DVec3::new(key.eye.0 - key.target.0, 0.0, key.eye.2 - key.target.2);
    let from = from.try_normalize().unwrap_or(DVec3::Z);
    let (width, height) = (f64::from(scene.size.0), f64::from(scene.size.1));
    let half = f64::from(key.fov).to_radians() / 2.0;
    let across = (half.tan() * width / height).min(1e3);
    let away = ((high.y - low.y) / 2.0 / half.tan()).max(wide / across) / FILL + 0.5 * wide;
    let eye = target + from * away;
    // A little above the ground at the least; heights in a scene are above the ground.
    let eye_height = target.y.max(0.05 * high.y);
    scene.camera.truncate(1);
    scene.camera[0].eye = (eye.x, eye_height, eye.z);
    scene.camera[0].target = (target.x, target.y, target.z);
}
