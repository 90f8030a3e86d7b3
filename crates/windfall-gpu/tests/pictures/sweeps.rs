//! Nothing pops: whatever moves by a little, the picture changes by a little.

use super::*;
use windfall_core::simplify::{Fade, FadeBy, Reduction};

/// How far a step may stand out from those about it. Steps of leaves that fade, and of a camera that moves, differ by
/// some tenths among themselves; a change of all leaves of a tree at once was 5 to 40 times its neighbours.
const MOST: f64 = 2.0;
/// Steps on either side that a step is compared with.
const ABOUT: usize = 8;

/// One tree, 13 m from the eye, leaves alone.
fn alone(tree: Tree) -> (Mutex<Scene>, Shot) {
    let (low, high) = tree.bounds();
    let (trees, forest) = lone(tree);
    let target = ((low + high) * 0.5).as_dvec3();
    let camera = Camera::look_at(target + DVec3::new(0.0, 0.0, 13.0), target, 0.12, 0.1);
    let mut view = View { show: DebugView::Leaves, shadows: false, ..View::new(camera) };
    view.quality.sway = false;
    (upload(&trees, &forest, &Falls::none()), Shot { time: 0.0, season: 0.4, view })
}

/// Mean change of a channel in each step, of 255.
fn steps(scene: &Mutex<Scene>, shots: impl Iterator<Item = Shot>) -> Vec<f64> {
    let targets = targets();
    let mut before: Option<Vec<u8>> = None;
    let mut steps = Vec::new();
    for shot in shots {
        let picture = paint_on(&targets, scene, &shot);
        if let Some(before) = before.replace(picture.clone()) {
            let sum: u64 = before.iter().zip(&picture).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
            steps.push(sum as f64 / picture.len() as f64);
        }
    }
    steps
}

/// The step that stands out most, and by how much.
fn worst(steps: &[f64]) -> (usize, f64) {
    let ratio = |i: usize| {
        let mut about = steps[i.saturating_sub(ABOUT)..(i + ABOUT + 1).min(steps.len())].to_vec();
        about.sort_by(f64::total_cmp);
        steps[i] / about[about.len() / 2].max(1e-3)
    };
    let ratios = (0..steps.len()).map(|i| (i, ratio(i)));
    ratios.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
}

fn calm(what: &str, steps: &[f64]) {
    let (step, ratio) = worst(steps);
    let mean = steps.iter().sum::<f64>() / steps.len() as f64;
    assert!(mean > 0.005, "{what}: nothing changes, {mean}");
    assert!(ratio < MOST, "{what}: step {step} changes {ratio:.1} times as much as its neighbours: {steps:.3?}");
}

fn trees() -> Vec<(String, Tree)> {
    let mut trees: Vec<(String, Tree)> = [Species::Oak, Species::Birch, Species::Maple]
        .map(|species| (species.to_string(), species.grow_with(1, 3000)))
        .into();
    for (_, tree) in &mut trees {
        prepare(tree);
    }
    trees.push(("cards".to_owned(), masked()));
    trees
}

#[test]
fn nothing_pops_when_detail_changes() {
    for (name, tree) in trees() {
        let (scene, shot) = alone(tree);
        for by in [FadeBy::Size, FadeBy::Opacity] {
            let with = |d0: f32, h: f32| {
                let mut shot = shot.clone();
                shot.view.detail = Simplification {
                    reduction: Reduction::Distance { d0 },
                    h,
                    fade: Fade { by, ..Fade::default() },
                    ..Simplification::DEFAULT
                };
                shot
            };
            // Through the share of 0.84, and about that of a half.
            let d0 = (0..40).map(|i| with(11.2 * 1.004f32.powi(i), 0.5));
            calm(&format!("{name}, {by:?}, d0"), &steps(&scene, d0));
            let h = (0..30).map(|i| with(11.5, 0.4 * 1.004f32.powi(i)));
            calm(&format!("{name}, {by:?}, h"), &steps(&scene, h));
        }
    }
}

#[test]
fn nothing_pops_when_the_camera_comes_nearer() {
    for (name, tree) in trees() {
        let (scene, shot) = alone(tree);
        for shadows in [false, true] {
            let dolly = (0..60).map(|i| {
                let mut shot = shot.clone();
                let away = 22.0 * 0.98f64.powi(i);
                let camera = &mut shot.view.camera;
                let target = camera.eye - DVec3::new(0.0, 0.0, 13.0);
                *camera = Camera::look_at(target + DVec3::new(0.0, 0.0, away), target, 0.35, 0.1);
                shot.view.detail.reduction = Reduction::Distance { d0: 12.0 };
                shot.view.shadow_detail = shot.view.detail;
                shot.view.shadows = shadows;
                shot
            });
            calm(&format!("{name}, shadows {shadows}"), &steps(&scene, dolly));
        }
    }
}
