//! Pictures that are shaded in fewer pixels than they have.

use super::*;
use windfall_gpu::Quality;

/// The same place with the same edges, up to the whole picture.
#[test]
fn a_picture_that_is_shaded_in_fewer_pixels_keeps_its_edges() {
    let (trees, forest) = glade();
    let scene = upload(&trees, &forest, &Falls::none());
    let mut shot = view([0.0, 3.0, 30.0], [0.0, 5.0, 0.0]);
    shot.view.quality = Quality { sway: false, ..Quality::PLAIN };
    let whole = paint(&scene, &shot);
    let apart = |picture: &[u8]| {
        let sum: u64 = whole.iter().zip(picture).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
        sum as f64 / whole.len() as f64
    };
    let mut before = 0.0;
    for resolution in [1.0, 0.9, 0.7, 0.5, 0.25] {
        shot.view.quality.resolution = resolution;
        let apart = apart(&paint(&scene, &shot));
        assert!(apart >= before, "{resolution}: {apart} of 255, {before} in more pixels");
        // Leaves of a pixel fall between samples, wherever those are: it was 8.0, 9.0, 10.6 and 15.7, and with two of
        // the samples in each other's place 8.6, 9.7, 11.5 and 16.3.
        let most = match resolution {
            1.0 => 0.0,
            r if r >= 0.9 => 8.3,
            r if r >= 0.7 => 9.3,
            r if r >= 0.5 => 11.1,
            _ => 16.0,
        };
        assert!(apart <= most, "{resolution}: {apart} of 255");
        before = apart;
    }
    // What is no number, or beyond what may be, is the nearest that may.
    for (odd, like) in [(f32::NAN, 1.0), (3.0, 1.0), (0.0, 0.25)] {
        let [odd, like] = [odd, like].map(|resolution| {
            shot.view.quality.resolution = resolution;
            paint(&scene, &shot)
        });
        assert!(odd == like);
    }
}
