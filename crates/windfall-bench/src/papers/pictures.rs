//! Figures that are pictures: SFS 2; VB 2008 5 and 9.

use super::report::Figure;
use crate::falling::workload::{grove_of, walkthrough};
use crate::harness::{Harness, ImageTarget};
use crate::scenery::{edit_sky, single_tree};
use crate::simplification::workload::paper_simplification;
use glam::{DVec3, Mat4};
use std::path::Path;
use windfall_core::simplify::Simplification;
use windfall_core::tree::Tree;
use windfall_gpu::{Camera, DebugView, Projection, Quality, View};
use windfall_host::device::Gpu;
use windfall_scenes::Stage;
use windfall_tree::Species;

/// Half the side of the square that figure 2 shows, of the tree's extent.
const MARGIN: f32 = 0.55;

/// Draws all of them into `folder`/papers.
pub fn draw(gpu: &mut Gpu, folder: &Path, number: usize) -> anyhow::Result<Vec<Figure>> {
    println!("pictures");
    let mut figures = simplified(gpu, folder, number)?;
    figures.extend(falling(gpu, folder, number)?);
    Ok(figures)
}

/// A stage with one tree, an orthographic view of it, and half of what that shows, metres.
fn alone(tree: Tree) -> (Stage, View, f32) {
    let (low, high) = tree.bounds();
    let middle = (low + high) * 0.5;
    let half = MARGIN * (high - low).max_element();
    let stage = single_tree(tree);
    let target = middle.as_dvec3();
    let eye = target + DVec3::Z * f64::from(2.0 * half);
    // Depth is 1 near: the planes change places.
    let flat = Mat4::orthographic_rh(-half, half, -half, half, 4.0 * half, 0.0);
    let projection = Projection::Matrix(flat);
    let camera = Camera { projection, ..Camera::look_at(eye, target, 1.0, 1.0) };
    // The tree alone: no air, and nothing behind it.
    let quality = Quality { backdrop: false, ..Quality::HIGH };
    let mut view = View { shadows: false, quality, ..View::new(camera) };
    edit_sky(&mut view, |sky| sky.haze = 0.0);
    (stage, view, half)
}

/// SFS, figure 2: one model in full, and with a tenth of its leaves.
fn simplified(gpu: &mut Gpu, folder: &Path, number: usize) -> anyhow::Result<Vec<Figure>> {
    let size = (300, 300);
    let harness = Harness::new(gpu, size)?;
    let (stage, view, half) = alone(Species::Oak.grow_with(1, 20_000));
    let mut planted = harness.upload(gpu, &stage)?;
    let target = ImageTarget::new(gpu, &harness.renderer, size, 1)?;
    // With h = 1/2, lambda is the square of d0 over the distance from which a usual camera sees as much.
    let pixels = 0.5 * size.1 as f32 / half;
    let tenth = paper_simplification(0.5, Camera::USUAL_PIXELS / pixels * 0.1f32.sqrt());
    let no_contrast = Simplification { color_contrast: false, shading_contrast: false, ..tenth };
    let neither = Simplification { area_preservation: false, ..no_contrast };
    let mut figures = Vec::new();
    for (name, title, detail) in [
        ("full", "SFS, figure 2: in full", Simplification::NONE),
        ("neither", "SFS, figure 2: a tenth of the leaves, nothing preserved", neither),
        ("area", "SFS, figure 2: area preserved", no_contrast),
        ("both", "SFS, figure 2: area and contrast preserved", tenth),
    ] {
        let view = View { detail, ..view.clone() };
        let image = target.render(gpu, &harness.renderer, &mut planted, (0.0, &view))?;
        figures.push(Figure::save(&image, folder, &format!("figure2-{name}-{number}"), title)?);
    }
    Ok(figures)
}

/// VB 2008, figures 5 and 9: loops of the path in colours; ambient occlusion off and on.
fn falling(gpu: &mut Gpu, folder: &Path, number: usize) -> anyhow::Result<Vec<Figure>> {
    let size = (480, 270);
    let harness = Harness::new(gpu, size)?;
    let mut stage = grove_of(4, 3000);
    stage.keep_falling(3000);
    let mut planted = harness.upload(gpu, &stage)?;
    let target = ImageTarget::new(gpu, &harness.renderer, size, 1)?;
    let walk = View { quality: Quality::MEDIUM, ..walkthrough(&stage, 8.0) };
    let without = Quality { ambient_occlusion: false, ..Quality::MEDIUM };
    let mut figures = Vec::new();
    for (name, title, view) in [
        (
            "loops",
            "VB 2008, figure 5: a colour for each use of the path, pink on the ground",
            View { show: DebugView::Loops, ..walk.clone() },
        ),
        (
            "no-occlusion",
            "VB 2008, figure 9: without ambient occlusion",
            View { quality: without, ..walk.clone() },
        ),
        ("occlusion", "VB 2008, figure 9: with ambient occlusion", walk.clone()),
    ] {
        let image = target.render(gpu, &harness.renderer, &mut planted, (8.0, &view))?;
        figures.push(Figure::save(&image, folder, &format!("{name}-{number}"), title)?);
    }
    Ok(figures)
}
