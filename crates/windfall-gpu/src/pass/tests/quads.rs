//! Quads of small leaves against the meshes that they stand for.

use super::hosts::{apart, blocks};
use super::{Gpu, Watched};
use crate::base::constants::DRAW_WORDS;
use crate::view::quads::HangingQuads;
use crate::{Camera, Capture, Falls, View};
use glam::DVec3;
use windfall_core::forest::{Placement, Terrain};
use windfall_tree::Species;

const SIZE: (u32, u32) = (256, 144);

/// Near trees, trees of small leaves and simplified ones: with quads, with room for some of them,
/// and without.
#[test]
fn quads_show_what_the_leaves_would() {
    let gpu = Gpu::get();
    let trees = [Species::Birch, Species::Maple].map(|s| s.grow_with(1, 2000));
    let placement = Placement {
        trees: 60,
        spacing: 7.0,
        scale: (0.7, 1.3),
        season_spread: 0.2,
        seed: 11,
        ..Placement::default()
    };
    let placed = placement.place(Terrain::rolling(200.0, 3.0, 2), &[1.0, 2.0]);
    let mut watched = Watched::new(gpu, DVec3::ZERO, &trees, &placed, Falls::default());
    let camera = Camera::look_at(DVec3::new(2.0, 7.0, 34.0), DVec3::new(0.0, 3.0, 0.0), 0.9, 0.1);
    let view = View::new(camera);
    watched.draw(gpu, 20.0, &view, (8, 8));
    let mut shots = Vec::new();
    for most in [1 << 20, 40_000, 0] {
        let forest = &watched.forest;
        let quads = HangingQuads::new(
            &gpu.device,
            &forest.layouts,
            forest.buffers().unwrap(),
            &watched.buffers().lists,
            most,
        );
        watched.state.buffers.as_mut().unwrap().quads = quads;
        let (mut encoder, texture) = watched.record(gpu, 20.0, &view, SIZE);
        let capture = Capture::encode(&gpu.device, &mut encoder, &texture);
        gpu.queue.submit([encoder.finish()]);
        capture.map();
        let quads = watched.buffers().quads.as_ref().map_or(0, |quads| {
            let words = gpu.words(&quads.buffers.arguments);
            let draws = words[..(DRAW_WORDS * quads.buffers.draws) as usize].chunks(5);
            draws.map(|draw| draw[0] / 6).sum::<u32>()
        });
        shots.push((quads, windfall_testing::wait(&gpu.device, || capture.take()).unwrap()));
    }
    let [(all, with), (some, partly), (none, without)] = &shots[..] else { unreachable!() };
    assert!(*all > 20_000 && (1..=40_000).contains(some) && *none == 0, "{all} {some} {none}");
    for picture in [with, partly] {
        // A quad has the mean light of its corners, a mesh what lies between them: where a shadow's edge crosses a leaf
        // its pixels differ, as many brighter as darker. Squares of many leaves do not, but for what is left of that.
        let squares = [picture, without].map(|p| blocks(p, SIZE.0 as usize, 16));
        let (pixels, squares) = (apart(picture, without), apart(&squares[0], &squares[1]));
        assert!(pixels < 0.15 && squares < 0.1, "of 255, pixels {pixels}, squares {squares}");
    }
}
