//! Part d: whether trees change smoothly as the camera comes nearer.

use super::error::Film;
use crate::gpu::Gpu;
use glam::{Vec2, Vec3};
use serde::Serialize;
use windfall_core::forest::{KeepOut, Placement, Terrain};
use windfall_core::simplify::{Fade, FadeRange, Simplification};
use windfall_core::tree::species::Species;
use windfall_gpu::{Camera, Falls, GpuForest, Quality, Renderer, View};

const FRAMES: u32 = 300;
const SIZE: (u32, u32) = (192, 128);
/// Metres a frame.
const STEP: f32 = 0.1;
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
    /// Mean difference of each frame from the one before it, steps of 255.
    differences: Vec<f64>,
}

/// A dolly down a lane in a forest, a tenth of a metre a frame: trees come from beyond the distance at
/// which they are simplified into full detail. The same without simplification says what the move
/// itself changes, and with leaves that appear at once what fading is for.
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
        "\n(d) {trees} trees, a dolly of {FRAMES} frames over {:.0} m, {}x{}; difference of \
         consecutive frames",
        STEP * FRAMES as f32,
        SIZE.0,
        SIZE.1
    );
    let sudden = Fade { range: FadeRange::Constant(0.0), ..Fade::default() };
    let kinds = [
        ("simplified", Simplification::DEFAULT),
        ("in full", Simplification::NONE),
        ("without fading", Simplification { fade: sudden, ..Simplification::DEFAULT }),
    ];
    let mut rows = Vec::new();
    for (name, detail) in kinds {
        let mut last = None;
        let mut differences = Vec::new();
        for frame in 0..FRAMES {
            let z = LANE - STEP * frame as f32;
            let camera = Camera {
                eye: Vec3::new(0.0, 3.0, z),
                target: Vec3::new(0.0, 5.0, z - 30.0),
                fov_y: 40f32.to_radians(),
                near: 0.1,
            };
            let quality = Quality { sway: false, ..Quality::LOW };
            let view = View { season: 0.55, quality, detail, ..View::new(camera) };
            let picture = film.shoot(gpu, renderer, &on_gpu, &view)?;
            if let Some(last) = &last {
                differences.push(picture.difference(last));
            }
            last = Some(picture);
        }
        let mut sorted = differences.clone();
        sorted.sort_by(f64::total_cmp);
        let (median, most) = (sorted[sorted.len() / 2], sorted[sorted.len() - 1]);
        let at = differences.iter().position(|&d| d == most).unwrap_or(0);
        println!(
            "{name:<16} median {median:.3}, most {most:.3} ({:.2} x) after frame {at}",
            most / median
        );
        rows.push(FadeRow { name, median, most, at, differences });
    }
    Ok(Fades { frames: FRAMES, trees, rows })
}
