//! `windfall bench picture --crawl`: how restless edges are while the camera moves.
//!
//! What is smaller than a pixel comes and goes from frame to frame. The change from each frame to the
//! next, over the change between frames of 16 times the pixels that were averaged: 1 is as calm as
//! those are.

use super::simplification::error::measure::{Film, Linear};
use crate::gpu::Gpu;
use glam::Vec3;
use windfall_gpu::{GpuForest, Renderer, View};
use windfall_scenes::{Scene, Stage};

/// Pixels along a side of the squares that are averaged.
const SUPERSAMPLED: u32 = 4;
/// Seconds between frames.
const STEP: f32 = 1.0 / 30.0;
/// Seconds of the first frame.
const START: f32 = 2.0;
/// Metres per second at which the camera walks, beside what the scene has it do.
const WALK: f32 = 0.5;

/// The scene at a frame, from a camera that walks towards what it looks at.
fn view(scene: &Scene, stage: &Stage, frame: u32) -> View {
    let since = frame as f32 * STEP;
    let mut view = scene.view(START + since, &stage.forest.terrain);
    let ahead = (view.camera.target - view.camera.eye).normalize_or(Vec3::Z);
    view.camera.eye += ahead * (WALK * since);
    view
}

/// Mean change from a picture to the next.
fn change(pictures: &[Linear]) -> f64 {
    let changes = pictures.windows(2).map(|pair| pair[0].difference(&pair[1]));
    changes.sum::<f64>() / pictures.len().saturating_sub(1).max(1) as f64
}

/// The change between `frames` frames over that of supersampled ones.
pub fn measure(
    gpu: &mut Gpu,
    renderer: &Renderer,
    forest: &GpuForest,
    (scene, stage): (&Scene, &Stage),
    size: (u32, u32),
    frames: u32,
) -> anyhow::Result<f64> {
    let [plain, calm] = [1, SUPERSAMPLED].map(|reduce| {
        let film = Film::new(gpu, renderer, size, reduce);
        let shots = (0..frames).map(|i| film.shoot(gpu, renderer, forest, &view(scene, stage, i)));
        shots.collect::<anyhow::Result<Vec<_>>>().map(|pictures| change(&pictures))
    });
    Ok(plain? / calm?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    #[test]
    fn the_camera_walks_in_every_scene() {
        for name in windfall_scenes::NAMES {
            let mut scene = windfall_scenes::named(name).unwrap();
            scene.count = 1;
            let built = scene.build(|file, _| -> Result<_, Infallible> { unreachable!("{file}") });
            let Ok(stage) = built;
            let [a, b] = [0, 30].map(|frame| view(&scene, &stage, frame).camera.eye);
            assert!((0.4..4.0).contains(&a.distance(b)), "{name}: {a} {b}");
        }
    }

    /// Grey by a step of the stored picture, then by two, is 1.5 steps a frame.
    #[test]
    fn change_is_the_mean_over_pairs_of_frames() {
        let grey = |v: u8| Linear::of(&[v, v, v, 255], (1, 1));
        let change = change(&[100, 101, 103].map(grey));
        assert!((change - 1.5).abs() < 1e-3, "{change}");
    }
}
