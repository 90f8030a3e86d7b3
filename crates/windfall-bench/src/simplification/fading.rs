//! Part d: whether trees gain detail smoothly as the camera comes nearer.

use crate::harness::{ImageTarget, PlantedView};
use crate::scenery;
use glam::{DVec3, Vec2};
use serde::Serialize;
use windfall_core::forest::{KeepOut, Placement, Terrain};
use windfall_core::simplify::{Fade, FadeRange, Growth, Reduction, Simplification};
use windfall_gpu::{Camera, Falls, Quality, Renderer, View};
use windfall_host::device::Gpu;
use windfall_tree::Species;

const FRAMES: u32 = 300;
const SIZE: (u32, u32) = (192, 128);
/// Motion of the dolly, metres per frame.
const STEP: f32 = 0.1;
/// Relative change of distance per frame with a still camera, so that all levels of a dolly are
/// passed.
const COARSE: f32 = 2.5e-3;
/// The same, so that one or two leaves appear at a time.
const FINE: f32 = 1e-5;
/// Side of the tiles in which changes are found, pixels. A tile shows one branch or a few leaves.
const TILE: u32 = 16;
/// Half the length of the camera's lane, metres.
const LANE: f32 = 45.0;

/// Results of part d.
#[derive(Serialize)]
pub struct Fades {
    frames: u32,
    trees: usize,
    rows: Vec<Row>,
}

#[derive(Serialize)]
struct Row {
    name: &'static str,
    median: f64,
    most: f64,
    /// The frame before the largest change.
    at: usize,
    /// The same for the tile that changes most.
    tile_median: f64,
    tile_most: f64,
    /// Mean difference of each frame from the previous one, in steps of 1/255.
    differences: Vec<f64>,
}

/// How the camera moves.
#[derive(Clone, Copy)]
enum Motion {
    /// Down the lane, [`STEP`] per frame.
    Dolly,
    /// Not at all. Trees are simplified as if their distance shrank by this share in each frame, so
    /// that only simplification changes the image.
    Still(f32),
}

/// The simplification that gives trees the detail of `detail` at a distance smaller by `factor`.
fn nearer(detail: Simplification, factor: f32) -> Simplification {
    let reduction = match detail.reduction {
        Reduction::Distance { d0 } => Reduction::Distance { d0: d0 * factor },
        Reduction::ProjectedArea { b0 } => Reduction::ProjectedArea { b0: b0 / (factor * factor) },
    };
    let growth = Growth { pixels: detail.growth.pixels / factor, ..detail.growth };
    Simplification { reduction, growth, wood_pixels: detail.wood_pixels / factor, ..detail }
}

/// Runs part d: a dolly down a lane in a forest, in which trees go from simplified to full detail.
///
/// The row without simplification has the changes of the camera's motion alone, and those without
/// fading have leaves that appear at once. Most of a dolly's changes are the camera's, so the other
/// rows have a still camera.
pub fn measure(gpu: &mut Gpu, renderer: &Renderer) -> anyhow::Result<Fades> {
    let models = vec![Species::Oak.grow_with(1, 3000), Species::Birch.grow_with(2, 3000)];
    let lane = KeepOut { from: Vec2::new(0.0, LANE), to: Vec2::new(0.0, -LANE), radius: 6.0 };
    let placement = Placement {
        trees: 60,
        spacing: 7.0,
        keep_out: vec![lane],
        scale: (0.8, 1.2),
        season_spread: 0.12,
        seed: 17,
    };
    let forest = placement.place(Terrain::flat(), &[1.0, 1.0]);
    let stage = scenery::stage(models, forest, Falls::none());
    let mut planted = PlantedView::upload(gpu, renderer, &stage)?;
    let target = ImageTarget::new(gpu, renderer, SIZE, 1)?;
    let trees = stage.forest.instances.len();
    println!(
        "\n(d) {trees} trees, a dolly of {FRAMES} frames over {:.0} m, or a still camera and trees \
         simplified as if they came nearer, {}x{}; difference of consecutive frames, in the mean and in \
         the square of {TILE} pixels that changes most",
        STEP * FRAMES as f32,
        SIZE.0,
        SIZE.1
    );
    let sudden = Fade { range: FadeRange::Constant(0.0), ..Fade::default() };
    let default = Simplification::DEFAULT;
    let sudden = Simplification { fade: sudden, ..default };
    let configurations = [
        ("dolly, simplified", default, Motion::Dolly),
        ("dolly, in full", Simplification::NONE, Motion::Dolly),
        ("dolly, without fading", sudden, Motion::Dolly),
        ("still, coarse", default, Motion::Still(COARSE)),
        ("still, coarse, without fading", sudden, Motion::Still(COARSE)),
        (
            "still, coarse, leaves alone",
            Simplification { wood_pixels: 0.0, ..default },
            Motion::Still(COARSE),
        ),
        ("still, fine", default, Motion::Still(FINE)),
        ("still, fine, without fading", sudden, Motion::Still(FINE)),
    ];
    let mut rows = Vec::new();
    for (name, detail, motion) in configurations {
        let mut last = None;
        let (mut differences, mut tiles) = (Vec::new(), Vec::new());
        for frame in 0..FRAMES {
            let (z, factor) = match motion {
                Motion::Dolly => (LANE - STEP * frame as f32, 1.0),
                Motion::Still(step) => (LANE, (step * frame as f32).exp()),
            };
            let eye = DVec3::new(0.0, 3.0, f64::from(z));
            let camera =
                Camera::look_at(eye, eye + DVec3::new(0.0, 2.0, -30.0), 40f32.to_radians(), 0.1);
            let quality = Quality { sway: false, ..Quality::PLAIN };
            let view = View { quality, ..View::new(camera) };
            let shadow_detail = nearer(view.shadow_detail, factor);
            let view = View { detail: nearer(detail, factor), shadow_detail, ..view };
            let image = target.render(gpu, renderer, &mut planted, (0.0, &view))?;
            if let Some(last) = &last {
                differences.push(image.difference(last));
                tiles.push(image.most_different_tile(last, TILE));
            }
            last = Some(image);
        }
        let (median, most) = median_and_most(&differences);
        let (tile_median, tile_most) = median_and_most(&tiles);
        let at = differences.iter().position(|&d| d == most).unwrap_or(0);
        println!(
            "{name:<30} median {median:.4}, most {most:.4} ({:.2} x) after frame {at:>3}; square: median \
             {tile_median:.3}, most {tile_most:.3} ({:.2} x)",
            most / median,
            tile_most / tile_median
        );
        rows.push(Row { name, median, most, at, tile_median, tile_most, differences });
    }
    Ok(Fades { frames: FRAMES, trees, rows })
}

fn median_and_most(of: &[f64]) -> (f64, f64) {
    let mut sorted = of.to_vec();
    sorted.sort_by(f64::total_cmp);
    (sorted[sorted.len() / 2], sorted[sorted.len() - 1])
}
