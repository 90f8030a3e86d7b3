//! `windfall bench picture --crawl`: temporal aliasing of edges while the camera moves.
//!
//! Details below a pixel appear and vanish from frame to frame. The measure is the difference of
//! consecutive frames over that of supersampled frames with 16 samples per pixel. It is 1 for
//! frames as stable as those.

use crate::harness::{ImageTarget, PlantedView};
use crate::image::LinearImage;
use windfall_gpu::{Renderer, View};
use windfall_host::device::Gpu;
use windfall_scenes::{Scene, Stage};

/// Samples in a row of a pixel of the reference; as many rows.
const SUPERSAMPLING: u32 = 4;
/// Seconds between frames.
const STEP: f64 = 1.0 / 30.0;
/// Seconds of the first frame.
const START: f64 = 2.0;
/// Speed of the camera on top of the scene's own motion, metres per second.
const WALK_SPEED: f64 = 0.5;

/// Time and view of a frame. The camera walks towards its target.
fn view(scene: &Scene, stage: &Stage, frame: u32) -> (f64, View) {
    let since = f64::from(frame) * STEP;
    let mut view = scene.view(START + since, &stage.forest.terrain);
    view.camera.eye += view.camera.forward().as_dvec3() * (WALK_SPEED * since);
    (START + since, view)
}

/// Mean difference of consecutive images.
fn mean_change(images: &[LinearImage]) -> f64 {
    let changes = images.windows(2).map(|pair| pair[0].difference(&pair[1]));
    changes.sum::<f64>() / images.len().saturating_sub(1).max(1) as f64
}

/// Mean change of `frames` frames over that of the same frames supersampled.
pub fn measure(
    gpu: &mut Gpu,
    renderer: &Renderer,
    planted: &mut PlantedView,
    (scene, stage): (&Scene, &Stage),
    size: (u32, u32),
    frames: u32,
) -> anyhow::Result<f64> {
    let mut change = |supersampling| -> anyhow::Result<f64> {
        let target = ImageTarget::new(gpu, renderer, size, supersampling)?;
        let images = (0..frames).map(|frame| {
            let (time, view) = view(scene, stage, frame);
            target.render(gpu, renderer, planted, (time, &view))
        });
        Ok(mean_change(&images.collect::<anyhow::Result<Vec<_>>>()?))
    };
    Ok(change(1)? / change(SUPERSAMPLING)?)
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
            let [a, b] = [0, 30].map(|frame| view(&scene, &stage, frame).1.camera.eye);
            assert!((0.4..4.0).contains(&a.distance(b)), "{name}: {a} {b}");
        }
    }

    /// Differences of one step and of two steps: 1.5 steps per frame.
    #[test]
    fn change_is_the_mean_over_pairs_of_frames() {
        let grey = |v: u8| LinearImage::of(&[v, v, v, 255], (1, 1));
        let change = mean_change(&[100, 101, 103].map(grey));
        assert!((change - 1.5).abs() < 1e-3, "{change}");
    }
}
