//! Spheres that hold what is to be seen.

use glam::DVec3;
use windfall_core::forest::Instance;
use windfall_scenes::Stage;

/// Trees farther from the middle than this are no part of what is framed, metres.
const NEIGHBOURHOOD: f32 = 40.0;

/// The forest about its middle, or a single tree in full.
pub fn of_stage(stage: &Stage) -> Option<(DVec3, f64)> {
    let near = stage.forest.instances.iter().filter(|i| {
        i.position.x.hypot(i.position.z) < NEIGHBOURHOOD || stage.forest.instances.len() == 1
    });
    sphere(near.map(|instance| bounds(stage, instance)))
}

/// Corners of the box about a tree, turned any way.
fn bounds(stage: &Stage, instance: &Instance) -> (DVec3, DVec3) {
    let (low, high) = stage.trees[instance.model as usize].bounds();
    let (low, high) = ((low * instance.scale).as_dvec3(), (high * instance.scale).as_dvec3());
    let wide = [low.x, high.x, low.z, high.z].into_iter().map(f64::abs).fold(0.0, f64::max);
    let foot = instance.position.as_dvec3();
    (foot + DVec3::new(-wide, low.y, -wide), foot + DVec3::new(wide, high.y, wide))
}

fn sphere(boxes: impl Iterator<Item = (DVec3, DVec3)>) -> Option<(DVec3, f64)> {
    let (low, high) = boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))?;
    let half = (high - low) / 2.0;
    // Between the ball inside the box and the one about it: crowns have no corners.
    Some(((low + high) / 2.0, half.max_element().max(0.8 * half.length())))
}
