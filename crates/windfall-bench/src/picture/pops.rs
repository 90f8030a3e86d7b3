//! `windfall bench picture --pops`: whether anything pops on a walk past a tree.
//!
//! The camera walks from 60 m to 2 m past a single tree, in steps of 0.4% of the way that is left. What changes in a
//! step is the mean difference of its two pictures; it is compared with the median of the steps about it.

use crate::harness::{ImageTarget, PlantedView};
use crate::image::LinearImage;
use crate::statistics::Quartiles;
use anyhow::Context;
use glam::DVec3;
use std::path::Path;
use windfall_gpu::{Camera, DebugView, Renderer, View};
use windfall_host::device::Gpu;
use windfall_scenes::{Scene, Source, Stage, TreeEntry, named};
use windfall_tree::Species;

/// Metres to the trunk, at the first step and at the last.
const WAY: (f64, f64) = (60.0, 2.0);
/// What is left of it after a step.
const STEP: f64 = 0.996;
/// How far the way leads past the trunk, metres, and the height of the eyes.
const ASIDE: f64 = 1.5;
const EYES: f64 = 1.7;
/// Vertical field of view, radians.
const FOV: f32 = 0.9;
/// Steps on either side that a step is compared with.
const ABOUT: usize = 8;
/// Changes below this mean, in steps of 1/255 of a pixel, are none.
const NOTHING: f64 = 0.02;
/// What is watched: leaves with their light, then leaves and wood without.
const VIEWS: [(&str, DebugView); 2] =
    [("leaves", DebugView::Leaves), ("leaves and wood, unlit", DebugView::Parts)];

/// A tree by its species or file, alone on a plain.
pub fn scene(name: &str) -> anyhow::Result<(Scene, Stage)> {
    let mut scene = named("lone-oak").context("the scene is built in")?;
    let source = match name.parse::<Species>() {
        Ok(species) => Source::Species(species.name().to_owned()),
        Err(_) => Source::File(name.to_owned()),
    };
    scene.trees = vec![TreeEntry { variants: 1, ..TreeEntry::new(source) }];
    scene.scale = (1.0, 1.0);
    scene.terrain.relief = 0.0;
    scene.shedding = None;
    let stage = scene.build(|file, entry| -> anyhow::Result<_> {
        Ok(windfall_host::tree::read(Path::new(file), &entry.import_options())?.tree)
    })?;
    stage.check(name)?;
    Ok((scene, stage))
}

/// Metres to the trunk before each step, and after the last.
fn way() -> Vec<f64> {
    std::iter::successors(Some(WAY.0), |left| Some(left * STEP).filter(|left| *left > WAY.1))
        .collect()
}

fn view(scene: &Scene, stage: &Stage, left: f64, show: DebugView) -> View {
    let trunk = stage.forest.instances.first().map_or(DVec3::ZERO, |tree| tree.position.as_dvec3());
    let eye = trunk + DVec3::new(ASIDE, EYES, left);
    let camera = Camera::look_at(eye, eye + DVec3::new(0.0, 0.35, -1.0), FOV, 0.1);
    let mut view = View { camera, show, ..scene.view(scene.time, &stage.forest.terrain) };
    view.quality.sway = false;
    view
}

/// A step over the median of those about it.
fn outstanding(steps: &[f64]) -> Vec<f64> {
    let of = |i: usize| {
        let about = &steps[i.saturating_sub(ABOUT)..(i + ABOUT + 1).min(steps.len())];
        steps[i] / Quartiles::of(about).median.max(NOTHING)
    };
    (0..steps.len()).map(of).collect()
}

/// Walks past a tree, and prints the steps that stand out.
pub fn measure(
    gpu: &mut Gpu,
    renderer: &Renderer,
    planted: &mut PlantedView,
    (scene, stage): (&Scene, &Stage),
    size: (u32, u32),
) -> anyhow::Result<()> {
    let target = ImageTarget::new(gpu, renderer, size, 1)?;
    let way = way();
    for (name, show) in VIEWS {
        let mut before: Option<LinearImage> = None;
        let mut steps = Vec::new();
        for &left in &way {
            let view = view(scene, stage, left, show);
            let image = target.render(gpu, renderer, planted, (scene.time, &view))?;
            steps.extend(before.replace(image).zip(before.as_ref()).map(|(a, b)| a.difference(b)));
        }
        let ratios = outstanding(&steps);
        let above = ratios.iter().filter(|ratio| **ratio > 2.0).count();
        let most = (0..ratios.len()).max_by(|a, b| ratios[*a].total_cmp(&ratios[*b]));
        let most = most.context("a walk has steps")?;
        println!(
            "  {name:<24} {:>4} steps, {above} above twice the median about them; the largest is {:.2} times it, {:.1} m \
             away",
            steps.len(),
            ratios[most],
            way[most],
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_walk_ends_at_the_trunk_in_fine_steps() {
        let way = way();
        assert!(way.len() > 840 && way[0] == 60.0 && (2.0..2.01).contains(way.last().unwrap()));
    }

    #[test]
    fn one_step_that_stands_out_is_found() {
        let mut steps: Vec<f64> = (0..100).map(|i| 1.0 + 0.01 * f64::from(i)).collect();
        assert!(outstanding(&steps).iter().all(|ratio| (0.9..1.1).contains(ratio)));
        steps[50] *= 3.0;
        let ratios = outstanding(&steps);
        assert!(ratios[50] > 2.9 && ratios.iter().filter(|ratio| **ratio > 2.0).count() == 1);
    }
}
