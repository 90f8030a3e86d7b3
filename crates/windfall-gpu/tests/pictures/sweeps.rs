//! Nothing pops: whatever moves by a little, the picture changes by a little.

use super::*;
use windfall_core::simplify::{Fade, FadeBy, Reduction};

/// How many times its neighbours a step may change.
const MOST: f64 = 2.0;
/// Steps on either side that a step is compared with.
const ABOUT: usize = 8;
/// Pixels of the small picture that change with one leaf, and how many leaves may change in a step by chance: forms
/// change leaf by leaf. All leaves of a tree at once were a quarter of the picture.
const LEAF: f64 = 60.0;
const BY_CHANCE: f64 = 3.0;

/// One tree, 13 m from the eye, leaves alone, which are some ten pixels long.
fn alone(tree: Tree) -> (Mutex<Scene>, Shot) {
    let (low, high) = tree.bounds();
    let leaf = f64::from(tree.foliage.leaf_length());
    let (trees, forest) = lone(tree);
    let target = ((low + high) * 0.5).as_dvec3();
    let fov = (leaf / 13.0 * 90.0 / 11.0) as f32;
    let camera = Camera::look_at(target + DVec3::new(0.0, 0.0, 13.0), target, fov, 0.1);
    let mut view = View { show: DebugView::Leaves, shadows: false, ..View::new(camera) };
    view.quality.sway = false;
    (upload(&trees, &forest, &Falls::none()), Shot { time: 0.0, season: 0.4, view })
}

/// How many pixels change visibly in each step.
fn steps(scene: &Mutex<Scene>, shots: impl Iterator<Item = Shot>) -> Vec<f64> {
    let targets = targets();
    let mut before: Option<Vec<u8>> = None;
    let mut steps = Vec::new();
    for shot in shots {
        let picture = paint_on(&targets, scene, &shot);
        if let Some(before) = before.replace(picture.clone()) {
            let pixels = before.chunks(4).zip(picture.chunks(4));
            let changed =
                |(a, b): &(&[u8], &[u8])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 8);
            steps.push(pixels.filter(changed).count() as f64);
        }
    }
    steps
}

/// No step stands out from those about it.
fn calm(what: &str, steps: &[f64]) {
    assert!(steps.iter().sum::<f64>() > 10.0, "{what}: nothing changes");
    for (i, step) in steps.iter().enumerate() {
        let mut about = steps[i.saturating_sub(ABOUT)..(i + ABOUT + 1).min(steps.len())].to_vec();
        about.sort_by(f64::total_cmp);
        let most = MOST * about[about.len() / 2] + BY_CHANCE * LEAF;
        assert!(*step < most, "{what}: step {i} changes {step} pixels, at most {most}: {steps:?}");
    }
}

fn trees() -> Vec<(String, Tree)> {
    let mut trees: Vec<(String, Tree)> = [Species::Oak, Species::Maple]
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
            // Through a share of 0.84, where all leaves of a tree changed form once.
            let d0 = (0..26).map(|i| with(10.8 * 1.004f32.powi(i), 0.5));
            calm(&format!("{name}, {by:?}, d0"), &steps(&scene, d0));
            let h = (0..16).map(|i| with(11.0, 0.49 * 1.004f32.powi(i)));
            calm(&format!("{name}, {by:?}, h"), &steps(&scene, h));
        }
    }
}

#[test]
fn nothing_pops_when_the_camera_comes_nearer() {
    for (name, tree) in trees() {
        let (scene, shot) = alone(tree);
        for shadows in [false, true] {
            let dolly = (0..30).map(|i| {
                let mut shot = shot.clone();
                let away = 13.6 * 0.996f64.powi(i);
                let camera = &mut shot.view.camera;
                let target = camera.eye - DVec3::new(0.0, 0.0, 13.0);
                let Projection::Perspective { fov_y, .. } = camera.projection else {
                    unreachable!()
                };
                *camera = Camera::look_at(target + DVec3::new(0.0, 0.0, away), target, fov_y, 0.1);
                shot.view.detail.reduction = Reduction::Distance { d0: 12.0 };
                shot.view.shadow_detail = shot.view.detail;
                shot.view.shadows = shadows;
                shot
            });
            calm(&format!("{name}, shadows {shadows}"), &steps(&scene, dolly));
        }
    }
}

/// A walk from 60 m to 2 m past a tree, of which short pieces are watched in fine steps: no piece has a step that
/// stands out.
#[test]
fn nothing_pops_on_the_way_past_a_tree() {
    let species = Species::ALL.iter().map(|species| {
        let mut tree = species.grow_with(1, 1500);
        prepare(&mut tree);
        (species.to_string(), tree)
    });
    for (name, tree) in species.chain([("cards".to_owned(), masked())]) {
        let (scene, shot) = alone(tree);
        let Projection::Perspective { fov_y, .. } = shot.view.camera.projection else {
            unreachable!()
        };
        let target = shot.view.camera.eye - DVec3::new(0.0, 0.0, 13.0);
        for from in [60.0, 32.0, 17.0, 9.0, 4.0, 2.1] {
            let way = (0..14).map(|i| {
                let mut shot = shot.clone();
                let away = from * 0.999f64.powi(i);
                // Past the trunk, looking ahead.
                let eye = target + DVec3::new(0.3, 0.0, away);
                shot.view.camera =
                    Camera::look_at(eye, eye - DVec3::new(0.0, 0.0, 10.0), fov_y, 0.1);
                shot
            });
            calm(&format!("{name} from {from} m"), &steps(&scene, way));
        }
    }
}
