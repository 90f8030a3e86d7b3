//! Part d: whether trees change smoothly as the camera comes nearer.

use super::error::Film;
use crate::gpu::Gpu;
use glam::{Vec2, Vec3};
use serde::Serialize;
use windfall_core::forest::{KeepOut, Placement, Terrain};
use windfall_core::simplify::{Fade, FadeRange, Growth, Reduction, Simplification};
use windfall_core::tree::species::Species;
use windfall_gpu::{Camera, Falls, GpuForest, Quality, Renderer, View};

const FRAMES: u32 = 300;
const SIZE: (u32, u32) = (192, 128);
/// Metres a frame of the dolly.
const STEP: f32 = 0.1;
/// Part by which trees come nearer in a frame in which the camera stands still: all of a dolly's levels
/// are passed, or a leaf or two come at a time.
const COARSE: f32 = 2.5e-3;
const FINE: f32 = 1e-5;
/// Side of the squares in which a change is looked for, pixels: as small as one branch or a few leaves.
const TILE: u32 = 16;
/// Half the length of the lane that the camera takes, metres.
const LANE: f32 = 45.0;

/// Part d.
#[derive(Serialize)]
pub struct Fades {
    frames: u32,
    trees: usize,
    rows: Vec<FadeRow>,
}

#[derive(Serialize)]
struct FadeRow {
    name: &'static str,
    median: f64,
    most: f64,
    /// The frame after which most changed.
    at: usize,
    /// The same of the square of pixels that changes most.
    tile_median: f64,
    tile_most: f64,
    /// Mean difference of each frame from the one before it, steps of 255.
    differences: Vec<f64>,
}

/// How the camera moves.
#[derive(Clone, Copy)]
enum Motion {
    /// Down the lane, [`STEP`] a frame.
    Dolly,
    /// Not at all: trees are simplified as if they came nearer by this part in each frame. All that
    /// changes is what simplification changes.
    Still(f32),
}

/// `detail` as it is for trees that are nearer by a factor.
fn nearer(detail: Simplification, factor: f32) -> Simplification {
    let reduction = match detail.reduction {
        Reduction::Distance { d0 } => Reduction::Distance { d0: d0 * factor },
        Reduction::ProjectedArea { b0 } => Reduction::ProjectedArea { b0: b0 / (factor * factor) },
    };
    let growth = Growth { pixels: detail.growth.pixels / factor, ..detail.growth };
    Simplification { reduction, growth, wood_pixels: detail.wood_pixels / factor, ..detail }
}

/// A dolly down a lane in a forest, a tenth of a metre a frame: trees come from beyond the distance at
/// which they are simplified into full detail. The same without simplification says what the move
/// itself changes, and with leaves that appear at once what fading is for. Most of it is the camera's own
/// move: the other rows have a camera that stands still.
pub fn fades(gpu: &mut Gpu, renderer: &Renderer) -> anyhow::Result<Fades> {
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
    let falls = Falls::none();
    let on_gpu = GpuForest::with_falls(&gpu.device, &gpu.queue, renderer, &models, &forest, &falls);
    let film = Film::new(gpu, renderer, SIZE, 1);
    let trees = forest.instances.len();
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
    let kinds = [
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
    for (name, detail, motion) in kinds {
        let mut last = None;
        let (mut differences, mut tiles) = (Vec::new(), Vec::new());
        for frame in 0..FRAMES {
            let (z, factor) = match motion {
                Motion::Dolly => (LANE - STEP * frame as f32, 1.0),
                Motion::Still(step) => (LANE, (step * frame as f32).exp()),
            };
            let camera = Camera {
                eye: Vec3::new(0.0, 3.0, z),
                target: Vec3::new(0.0, 5.0, z - 30.0),
                fov_y: 40f32.to_radians(),
                near: 0.1,
            };
            let quality = Quality { sway: false, ..Quality::LOW };
            let view = View { season: 0.55, quality, ..View::new(camera) };
            let shadow_detail = nearer(view.shadow_detail, factor);
            let view = View { detail: nearer(detail, factor), shadow_detail, ..view };
            let picture = film.shoot(gpu, renderer, &on_gpu, &view)?;
            if let Some(last) = &last {
                differences.push(picture.difference(last));
                tiles.push(picture.most_different_tile(last, TILE));
            }
            last = Some(picture);
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
        rows.push(FadeRow { name, median, most, at, tile_median, tile_most, differences });
    }
    Ok(Fades { frames: FRAMES, trees, rows })
}

fn median_and_most(of: &[f64]) -> (f64, f64) {
    let mut sorted = of.to_vec();
    sorted.sort_by(f64::total_cmp);
    (sorted[sorted.len() / 2], sorted[sorted.len() - 1])
}
