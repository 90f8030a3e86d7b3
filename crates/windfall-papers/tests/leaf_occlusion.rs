//! Leaves in the air that are not seen are skipped, and none that is seen.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

use glam::{Vec2, Vec3};
use wgpu_profiler::{GpuProfiler, GpuProfilerSettings};
use windfall_core::forest::{Forest, Instance, Terrain};
use windfall_core::shed::Shedding;
use windfall_core::simplify::Simplification;
use windfall_core::tree::species::Species;
use windfall_core::tree::{Tree, WoodVertex};
use windfall_core::wind::Wind;
use windfall_gpu::{
    Camera, Canvas, Capture, CountLeaves, Elimination, Falls, FrameStats, GpuForest, LeafCounts,
    Quality, Renderer, Show, Strategy, Target, View, wgpu, wgpu_profiler,
};
use windfall_testing::{device, picture};

const SIZE: (u32, u32) = (640, 360);
const LEAVES: u32 = 240;

struct Studio {
    device: wgpu::Device,
    queue: wgpu::Queue,
    profiler: GpuProfiler,
    renderer: Renderer,
    texture: wgpu::Texture,
    canvas: Canvas,
}

struct Frame {
    rgba: Vec<u8>,
    stats: FrameStats,
    counts: LeafCounts,
}

impl Studio {
    fn open() -> Self {
        let (device, queue) = device();
        let settings = GpuProfilerSettings { enable_timer_queries: false, ..Default::default() };
        let texture = picture(&device, SIZE);
        let renderer = Renderer::new(&device, texture.format());
        Self {
            profiler: GpuProfiler::new(&device, settings).unwrap(),
            canvas: renderer.canvas(&device, SIZE.0, SIZE.1),
            renderer,
            texture,
            device,
            queue,
        }
    }

    fn forest(&self, strategy: Strategy, leaf_occlusion: bool) -> GpuForest {
        let (trees, forest, falls) = scene();
        let falls = Falls { strategy, leaf_occlusion, ..falls };
        GpuForest::with_falls(&self.device, &self.queue, &self.renderer, &trees, &forest, &falls)
    }

    fn paint(&self, forest: &GpuForest, view: &View) -> Frame {
        let Self { device, queue, profiler, renderer, texture, canvas } = self;
        let picture = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = device.create_command_encoder(&Default::default());
        let target = Target { canvas, picture: &picture };
        let stats = renderer.render(queue, &mut encoder, profiler, forest, view, target);
        let capture = Capture::encode(device, &mut encoder, texture);
        let count = CountLeaves::encode(device, &mut encoder, forest);
        queue.submit([encoder.finish()]);
        capture.map();
        count.map();
        device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        Frame {
            rgba: capture.take().unwrap().unwrap(),
            counts: count.take().unwrap().unwrap(),
            stats,
        }
    }
}

/// All leaves of a tree are in the air, behind a wall of wood 6 m from it towards +Z.
fn scene() -> (Vec<Tree>, Forest, Falls) {
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
    let trees = vec![Species::Maple.grow_with(3, LEAVES), wall];
    let stand = |z, model| Instance {
        model,
        position: Vec3::new(0.0, 0.0, z),
        yaw: 0.0,
        scale: 1.0,
        season_offset: 0.0,
        seed: 9,
    };
    let falls = Falls {
        shedding: Shedding { start: 0.0, duration: 0.4, peak: 0.0, tree_spread: 0.0, burst: 0.0 },
        wind: Wind::new(0.0, 0.0, 0.0, 1),
        elimination: Elimination::Scheduled,
        ..Falls::default()
    };
    let instances = vec![stand(0.0, 0), stand(6.0, 1)];
    (trees, Forest { terrain: Terrain::flat(), instances }, falls)
}

/// From before the wall, or from behind it.
fn view(before: bool) -> View {
    let eye = Vec3::new(0.0, 4.0, if before { 16.0 } else { -16.0 });
    let camera = Camera { eye, target: Vec3::new(0.0, 7.0, 0.0), fov_y: 1.1, near: 0.1 };
    let detail = Simplification::NONE;
    View { time: 1.0, shadows: false, quality: Quality::LOW, detail, ..View::new(camera) }
}

fn in_the_air(frame: &Frame) -> u32 {
    frame.counts.falling + frame.stats.leaves_falling as u32
}

#[test]
fn leaves_behind_a_wall_are_tested_in_turns_and_skipped() {
    let studio = Studio::open();
    for strategy in Strategy::ALL {
        let forest = studio.forest(strategy, true);
        let frames: Vec<Frame> = (0..9).map(|_| studio.paint(&forest, &view(true))).collect();
        let air = in_the_air(&frames[0]);
        assert!(air > 100, "{strategy}: {air} leaves in the air");
        let tested: Vec<u32> = frames.iter().map(|f| f.counts.tested).collect();
        let skipped: Vec<u32> = frames.iter().map(|f| f.counts.skipped).collect();
        // Each third is tested, skipped for three frames, and tested again.
        let [a, b, c] = [tested[0], tested[1], tested[2]];
        assert_eq!(a + b + c, air, "{strategy}");
        assert!([a, b, c].iter().all(|&n| n.abs_diff(air / 3) < air / 8), "{strategy}: {tested:?}");
        assert_eq!(tested, [a, b, c, 0, a, b, c, 0, a], "{strategy}");
        let expected = [0, a, a + b, air, b + c, c + a, a + b, air, b + c];
        assert_eq!(skipped, expected, "{strategy}");
        for frame in frames.iter().filter(|_| strategy == Strategy::Compute) {
            assert_eq!(frame.counts.falling_drawn + frame.counts.skipped, air);
        }
        let plain = studio.paint(&studio.forest(strategy, false), &view(true));
        assert_eq!([plain.counts.tested, plain.counts.skipped], [0, 0]);
        assert!(frames.iter().all(|f| f.rgba == plain.rgba), "{strategy}: the wall hides them all");
    }
}

#[test]
fn a_third_of_the_leaves_that_are_seen_is_tested_in_each_frame() {
    let studio = Studio::open();
    for strategy in Strategy::ALL {
        let forest = studio.forest(strategy, true);
        for i in 0..8 {
            let frame = studio.paint(&forest, &view(false));
            let (air, tested) = (in_the_air(&frame), frame.counts.tested);
            // A few hide behind others or the wood, or stand edge on.
            assert!(frame.counts.skipped < air / 6, "{strategy}: {:?}", frame.counts);
            assert!(tested.abs_diff(air / 3) < air / 8, "{strategy}, frame {i}: {tested} of {air}");
        }
    }
}

#[test]
fn leaves_that_come_into_sight_are_there_within_four_frames() {
    let studio = Studio::open();
    for strategy in Strategy::ALL {
        let plain = studio.paint(&studio.forest(strategy, false), &view(false));
        let forest = studio.forest(strategy, true);
        for _ in 0..8 {
            studio.paint(&forest, &view(true));
        }
        let others = |frame: &Frame| {
            frame.rgba.chunks(4).zip(plain.rgba.chunks(4)).filter(|(a, b)| a != b).count()
        };
        let frames: Vec<usize> =
            (0..5).map(|_| others(&studio.paint(&forest, &view(false)))).collect();
        println!("{strategy}: pixels of leaves that are missing {frames:?}");
        // Every leaf was skipped in the frame before; what stays away shows fewer than three pixels.
        assert!(frames[0] > 1000 && frames[4] < 60, "{strategy}: {frames:?}");
    }
}

#[test]
fn the_view_of_occlusion_shows_what_is_done_with_leaves() {
    let studio = Studio::open();
    // Pixels in which a channel stands out: red, green, blue.
    let colors = |frame: &Frame| {
        let stands_out = |p: &[u8], i: usize| {
            (0..3).all(|k| k == i || i32::from(p[i]) > 2 * i32::from(p[k]) + 20)
        };
        [0, 1, 2].map(|i| frame.rgba.chunks(4).filter(|p| stands_out(p, i)).count())
    };
    for strategy in Strategy::ALL {
        let forest = studio.forest(strategy, true);
        let view = |before| View { show: Show::Occlusion, ..view(before) };
        let hidden: Vec<_> = (0..5).map(|_| colors(&studio.paint(&forest, &view(true)))).collect();
        let seen: Vec<_> = (0..8).map(|_| colors(&studio.paint(&forest, &view(false)))).collect();
        println!("{strategy}: red, green, blue {hidden:?}, {seen:?}");
        // Skipped leaves are drawn before the wall, all of them in the fourth frame.
        assert!(hidden[3][0] > 1000 && hidden[0][0] < 20, "{strategy}: {hidden:?}");
        assert!(hidden.iter().all(|h| h[1] < 20 && h[2] < 20), "{strategy}: {hidden:?}");
        let [red, green, blue] = seen[7];
        assert!(red < 200 && blue > 300 && green > blue, "{strategy}: {seen:?}");
    }
}
