//! Leaves in the air that are not seen are skipped, and none that is seen.

use crate::harness::{HARNESS, SIZE, Scene, Shot, Stage, camera, upload};
use glam::{DVec3, Vec2, Vec3};
use std::sync::Arc;
use windfall_core::forest::Terrain;
use windfall_core::shed::Shedding;
use windfall_core::simplify::Simplification;
use windfall_core::tree::WoodVertex;
use windfall_core::wind::Wind;
use windfall_gpu::{DebugView, Falls, Quality, TreePlace, View};
use windfall_papers::{
    LeafOcclusion, ListOptions, OcclusionCounts, PassOptions, PublishedPasses, Strategy,
};
use windfall_tree::{Species, prepare};

const LEAVES: u32 = 240;

struct Frame {
    rgba: Vec<u8>,
    occlusion: OcclusionCounts,
    in_air: u32,
}

/// All leaves of a tree are in the air, behind a wall of wood 6 m from it towards +Z.
fn scene() -> Scene {
    let mut wall = Species::Birch.grow_with(1, 0);
    wall.wood.vertices = [(-20.0, 0.0), (20.0, 0.0), (20.0, 30.0), (-20.0, 30.0)]
        .map(|(x, y)| WoodVertex {
            position: Vec3::new(x, y, 0.0),
            normal: Vec3::Z,
            uv: Vec2::new(x, y),
            material: 0,
        })
        .to_vec();
    wall.wood.indices = vec![0, 1, 2, 0, 2, 3];
    prepare(&mut wall);
    let stand = |model, z| (model, TreePlace::at(DVec3::new(0.0, 0.0, z), 9));
    Scene {
        models: vec![upload(&Species::Maple.grow_with(3, LEAVES)), upload(&wall)],
        terrain: Terrain::flat(),
        origin: DVec3::ZERO,
        places: vec![stand(0, 0.0), stand(1, 6.0)],
        falls: Falls {
            shedding: Shedding {
                start: 0.0,
                duration: 0.4,
                peak: 0.0,
                tree_spread: 0.0,
                burst: 0.0,
            },
            wind: Wind::calm(),
            ..Falls::default()
        },
    }
}

fn stage(scene: &Scene, strategy: Strategy, leaf_occlusion: bool) -> Stage {
    scene.published(HARNESS.passes(strategy, leaf_occlusion), ListOptions::default())
}

/// From before the wall, or from behind it.
fn shot(before: bool, show: DebugView) -> Shot {
    let camera = camera([0.0, 4.0, if before { 16.0 } else { -16.0 }], [0.0, 7.0, 0.0]);
    let detail = Simplification::NONE;
    let view = View::new(camera);
    let view = View { shadows: false, quality: Quality::PLAIN, detail, show, ..view };
    Shot { time: 1.0, season: 0.5, view }
}

fn paint(stage: &mut Stage, shot: &Shot) -> Frame {
    let (rgba, readback) = stage
        .paint_with(shot, |stage, encoder| stage.leaves.as_ref().unwrap().count_occlusion(encoder));
    let occlusion = readback.map_or_else(OcclusionCounts::default, |readback| {
        readback.map();
        windfall_testing::wait(&HARNESS.device, || readback.take()).unwrap()
    });
    let in_air = stage.leaves.as_ref().unwrap().counts().falling as u32;
    Frame { rgba, occlusion, in_air }
}

#[test]
fn leaves_behind_a_wall_are_tested_in_turns_and_skipped() {
    let scene = scene();
    for strategy in Strategy::ALL {
        let mut stage = self::stage(&scene, strategy, true);
        let shot = shot(true, DebugView::Final);
        let frames: Vec<Frame> = (0..9).map(|_| paint(&mut stage, &shot)).collect();
        let air = frames[0].in_air;
        assert!(air > 100, "{strategy}: {air} leaves in the air");
        let tested: Vec<u32> = frames.iter().map(|f| f.occlusion.tested).collect();
        let skipped: Vec<u32> = frames.iter().map(|f| f.occlusion.skipped).collect();
        // Each third is tested, skipped for three frames, and tested again.
        let [a, b, c] = [tested[0], tested[1], tested[2]];
        assert_eq!(a + b + c, air, "{strategy}");
        assert!([a, b, c].iter().all(|&n| n.abs_diff(air / 3) < air / 8), "{strategy}: {tested:?}");
        assert_eq!(tested, [a, b, c, 0, a, b, c, 0, a], "{strategy}");
        let expected = [0, a, a + b, air, b + c, c + a, a + b, air, b + c];
        assert_eq!(skipped, expected, "{strategy}");
        let plain = paint(&mut self::stage(&scene, strategy, false), &shot);
        assert_eq!(plain.occlusion, OcclusionCounts::default());
        assert!(frames.iter().all(|f| f.rgba == plain.rgba), "{strategy}: the wall hides them all");
    }
}

#[test]
fn how_many_are_tested_how_long_skipped_and_what_is_seen_are_options() {
    let scene = scene();
    for strategy in Strategy::ALL {
        let with = |one_in, skip, pixels| {
            let occlusion = Some(LeafOcclusion { one_in, skip, pixels });
            let options = PassOptions { occlusion, ..PassOptions::new(strategy) };
            let passes = Arc::new(PublishedPasses::new(&HARNESS.device, options));
            scene.published(&passes, ListOptions::default())
        };
        let counts = |stage: &mut Stage, before, frames: u32| -> Vec<[u32; 2]> {
            let shot = shot(before, DebugView::Final);
            let frames = (0..frames).map(|_| paint(stage, &shot).occlusion);
            frames.map(|o| [o.tested, o.skipped]).collect()
        };
        // Behind the wall: half of the leaves in each frame, skipped for two, then for four.
        for skip in [2, 4] {
            let seen = counts(&mut with(2, skip, 3), true, 2 * skip + 2);
            let [first, air] = [seen[0][0], seen[0][0] + seen[1][0]];
            assert!(first.abs_diff(air / 2) < air / 8, "{strategy}: {seen:?}");
            let second = air - first;
            // The halves in turns; each is skipped, and tested again.
            let tested = |i: u32| match i % (skip + 1) {
                0 => first,
                1 => second,
                _ => 0,
            };
            for (i, &[now, _]) in (0..).zip(&seen) {
                assert_eq!(now, tested(i), "{strategy}, {skip}, frame {i}: {seen:?}");
            }
        }
        // No leaf is a thousand pixels large.
        let few = counts(&mut with(1, 3, 3), false, 2);
        let all = counts(&mut with(1, 3, 1000), false, 2);
        assert!(few[1][1] < few[0][0] / 4 && all[1] == [0, all[0][0]], "{few:?} {all:?}");
    }
}

#[test]
fn a_third_of_the_leaves_that_are_seen_is_tested_in_each_frame() {
    let scene = scene();
    for strategy in Strategy::ALL {
        let mut stage = self::stage(&scene, strategy, true);
        for i in 0..8 {
            let frame = paint(&mut stage, &shot(false, DebugView::Final));
            let OcclusionCounts { tested, skipped } = frame.occlusion;
            let air = frame.in_air;
            println!("{strategy}, frame {i}: {tested} tested, {skipped} skipped of {air}");
            // A few hide behind others or the wood, or stand edge on.
            assert!(skipped < air / 4, "{strategy}: {skipped} of {air}");
            assert!(tested.abs_diff(air / 3) < air / 8, "{strategy}, frame {i}: {tested} of {air}");
        }
    }
}

#[test]
fn leaves_that_come_into_view_are_there_within_four_frames() {
    let scene = scene();
    let [before, behind] = [true, false].map(|before| shot(before, DebugView::Final));
    for strategy in Strategy::ALL {
        let plain = paint(&mut self::stage(&scene, strategy, false), &behind);
        let mut stage = self::stage(&scene, strategy, true);
        for _ in 0..8 {
            paint(&mut stage, &before);
        }
        let others = |frame: &Frame| {
            frame.rgba.chunks(4).zip(plain.rgba.chunks(4)).filter(|(a, b)| a != b).count()
        };
        let frames: Vec<usize> = (0..5).map(|_| others(&paint(&mut stage, &behind))).collect();
        println!("{strategy}: pixels of leaves that are missing {frames:?}");
        // Every leaf was skipped in the frame before; what stays away shows fewer than three pixels.
        assert!(frames[0] > 200 && frames[4] < 40, "{strategy}: {frames:?}");
    }
}

#[test]
fn the_view_of_occlusion_shows_what_is_done_with_leaves() {
    let scene = scene();
    // Pixels in which a channel stands out: red, green, blue.
    let colors = |frame: &Frame| {
        let stands_out = |p: &[u8], i: usize| {
            (0..3).all(|k| k == i || i32::from(p[i]) > 2 * i32::from(p[k]) + 20)
        };
        [0, 1, 2].map(|i| frame.rgba.chunks(4).filter(|p| stands_out(p, i)).count())
    };
    for strategy in Strategy::ALL {
        let mut stage = self::stage(&scene, strategy, true);
        let [before, behind] = [true, false].map(|before| shot(before, DebugView::Occlusion));
        let hidden: Vec<_> = (0..5).map(|_| colors(&paint(&mut stage, &before))).collect();
        let seen: Vec<_> = (0..8).map(|_| colors(&paint(&mut stage, &behind))).collect();
        println!("{strategy}: red, green, blue {hidden:?}, {seen:?}");
        // Skipped leaves are drawn before the wall, all of them in the fourth frame.
        assert!(hidden[3][0] > 150 && hidden[0][0] < 5, "{strategy}: {hidden:?}");
        assert!(hidden.iter().all(|h| h[1] < 5 && h[2] < 5), "{strategy}: {hidden:?}");
        let [red, green, blue] = seen[7];
        assert!(red < 100 && blue > 50 && green > blue, "{strategy}: {seen:?}");
    }
    assert_eq!(SIZE, (256, 144), "the numbers of pixels above are for this size");
}
