//! Part d: whether trees change smoothly as the camera comes nearer.

use super::error::Film;
use super::stands::plant;
use crate::gpu::Gpu;
use glam::Vec3;
use serde::Serialize;
use windfall_core::tree::species::Species;
use windfall_gpu::{Camera, Falls, GpuForest, Quality, Renderer, View};

const FRAMES: u32 = 300;
const SIZE: (u32, u32) = (192, 128);
/// Metres a frame.
const STEP: f32 = 0.1;

/// Part d.
#[derive(Serialize)]
pub struct Fades {
    frames: u32,
    median: f64,
    most: f64,
    /// The frame after which most changed, and how far the camera had come.
    at: usize,
    at_m: f32,
    /// Mean difference of each frame from the one before it, steps of 255.
    differences: Vec<f64>,
}

/// A dolly past the edge of a forest, a tenth of a metre a frame.
pub fn fades(gpu: &mut Gpu, renderer: &Renderer) -> anyhow::Result<Fades> {
    let models = vec![Species::Oak.grow_with(1, 3000), Species::Birch.grow_with(2, 3000)];
    let stage = plant(models, 12);
    let edge = stage.forest.instances.iter().map(|i| i.position.length()).fold(1.0, f32::max);
    let falls = Falls::none();
    let forest = GpuForest::with_falls(
        &gpu.device,
        &gpu.queue,
        renderer,
        &stage.trees,
        &stage.forest,
        &falls,
    );
    let film = Film::new(gpu, renderer, SIZE, 1);
    let start = edge + 75.0;
    println!(
        "\n(d) {} trees, a dolly of {FRAMES} frames from {:.0} m to {:.0} m before them, {}x{}",
        stage.forest.instances.len(),
        start - edge,
        start - edge - STEP * FRAMES as f32,
        SIZE.0,
        SIZE.1
    );
    let mut last = None;
    let mut differences = Vec::new();
    for frame in 0..FRAMES {
        let eye = Vec3::new(3.0, 3.0, start - STEP * frame as f32);
        let camera =
            Camera { eye, target: Vec3::new(0.0, 6.0, 0.0), fov_y: 40f32.to_radians(), near: 0.1 };
        let view = View { season: 0.55, quality: Quality::LOW, ..View::new(camera) };
        let picture = film.shoot(gpu, renderer, &forest, &view)?;
        if let Some(last) = &last {
            differences.push(picture.difference(last));
        }
        last = Some(picture);
    }
    let mut sorted = differences.clone();
    sorted.sort_by(f64::total_cmp);
    let (median, most) = (sorted[sorted.len() / 2], sorted[sorted.len() - 1]);
    let at = differences.iter().position(|&d| d == most).unwrap_or(0);
    let at_m = STEP * at as f32;
    println!(
        "difference of consecutive frames: median {median:.3}, most {most:.3} ({:.2} x) after frame {at}, {at_m:.1} m",
        most / median
    );
    Ok(Fades { frames: FRAMES, median, most, at, at_m, differences })
}
