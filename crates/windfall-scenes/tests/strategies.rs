//! The four strategies give the same picture, whatever was drawn before.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use std::convert::Infallible;
use windfall_core::shed::Shedding;
use windfall_gpu::wgpu_profiler::{GpuProfiler, GpuProfilerSettings};
use windfall_gpu::{
    Capture, DetachEvent, Elimination, Falls, GpuForest, Renderer, Show, Strategy, Target, View,
};
use windfall_scenes::{Scene, Source, Stage, TreeEntry, named};

const SIZE: (u32, u32) = (256, 144);
/// Largest mean FLIP error of two pictures that are the same.
const SAME: f32 = 0.005;

struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    profiler: GpuProfiler,
    renderer: Renderer,
}

impl Gpu {
    fn open() -> Self {
        let (device, queue) = windfall_testing::device();
        let settings = GpuProfilerSettings { enable_timer_queries: false, ..Default::default() };
        Self {
            profiler: GpuProfiler::new(&device, settings).unwrap(),
            renderer: Renderer::new(&device, wgpu::TextureFormat::Rgba8UnormSrgb),
            device,
            queue,
        }
    }

    fn forest(&self, stage: &Stage, strategy: Strategy, elimination: Elimination) -> GpuForest {
        let falls = windfall_gpu::Falls { strategy, elimination, ..stage.falls.clone() };
        GpuForest::with_falls(
            &self.device,
            &self.queue,
            &self.renderer,
            &stage.trees,
            &stage.forest,
            &falls,
        )
    }

    fn paint(&self, forest: &GpuForest, view: &View) -> Picture {
        let texture = windfall_testing::picture(&self.device, SIZE);
        let picture = texture.create_view(&Default::default());
        let canvas = self.renderer.canvas(&self.device, SIZE.0, SIZE.1);
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let target = Target { canvas: &canvas, picture: &picture };
        let stats =
            self.renderer.render(&self.queue, &mut encoder, &self.profiler, forest, view, target);
        let capture = Capture::encode(&self.device, &mut encoder, &texture);
        self.queue.submit([encoder.finish()]);
        capture.map();
        self.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        let rgba = capture.take().unwrap().unwrap();
        let rgb = rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
        Picture { rgb, falling: stats.leaves_falling, eliminated: stats.leaves_eliminated }
    }
}

struct Picture {
    rgb: Vec<u8>,
    falling: u64,
    eliminated: u64,
}

/// Mean FLIP error, 0 for equal pictures to 1.
fn difference(a: &Picture, b: &Picture) -> f32 {
    let image = |p: &Picture| nv_flip::FlipImageRgb8::with_data(SIZE.0, SIZE.1, &p.rgb);
    let error = nv_flip::flip(image(a), image(b), nv_flip::DEFAULT_PIXELS_PER_DEGREE);
    nv_flip::FlipPool::from_image(&error).mean()
}

/// Three trees on a slope, in the wind, that shed so fast that many leaves fall and lie.
fn scene() -> (Scene, Stage) {
    let mut scene = named("autumn").unwrap();
    let entry =
        |name: &str| TreeEntry { variants: 1, ..TreeEntry::new(Source::Species(name.to_owned())) };
    scene.trees = vec![entry("birch"), entry("maple")];
    scene.count = 3;
    scene.terrain.relief = 0.0;
    scene.terrain.slope = (0.1, -0.05);
    scene.spacing = Some(5.0);
    scene.keep_out = vec![];
    scene.camera.truncate(1);
    scene.camera[0].eye = (3.0, 3.0, 16.0);
    scene.camera[0].target = (0.0, 3.0, 0.0);
    scene.loose_leaves = 9000;
    let mut stage = scene.build(|_, _| -> Result<_, Infallible> { unreachable!() }).unwrap();
    stage.keep_falling(2500);
    (scene, stage)
}

/// The same trees, which shed nothing of themselves: every leaf of the first and every third of the
/// others is thrown, a second after the other of a hundred.
fn thrown() -> (Scene, Stage) {
    let (scene, mut stage) = scene();
    stage.falls.shedding = Shedding::never();
    let events = (0..).zip(&stage.forest.instances).flat_map(|(instance, planted)| {
        let leaves = stage.trees[planted.model as usize].foliage.leaves.len() as u32;
        let step = if instance == 0 { 1 } else { 3 };
        (0..leaves).step_by(step).map(move |leaf| DetachEvent {
            instance,
            leaf,
            time: 1.0 + (leaf % 100) as f32 / 100.0,
        })
    });
    stage.falls.events = events.collect();
    (scene, stage)
}

#[test]
fn thrown_leaves_are_the_same_by_every_strategy_and_in_any_order_of_moments() {
    let gpu = Gpu::open();
    let (scene, stage) = thrown();
    let view = |t| scene.view(t, &stage.forest.terrain);
    let forests = Strategy::ALL.map(|s| gpu.forest(&stage, s, Elimination::Scheduled));
    let hanging = gpu.paint(&forests[3], &view(0.9));
    // In the air, all on the ground, and back again.
    for time in [2.5, 60.0, 1.4] {
        let pictures = forests.each_ref().map(|forest| gpu.paint(forest, &view(time)));
        let direct =
            gpu.paint(&gpu.forest(&stage, Strategy::Compute, Elimination::Off), &view(time));
        let played = difference(&direct, &pictures[3]);
        assert!(played < 0.001, "{played} at {time} s");
        for (strategy, picture) in Strategy::ALL.iter().zip(&pictures) {
            let error = difference(&direct, picture);
            println!("{time} s: {strategy} differs by {error:.6}");
            assert!(error < SAME, "{strategy} differs by {error} at {time} s");
        }
        let moved = difference(&direct, &hanging);
        println!("{time} s: from hanging leaves {moved:.6}");
        assert!(moved > 2.0 * SAME, "{moved}");
    }
    for forest in &forests {
        assert!(difference(&gpu.paint(forest, &view(0.9)), &hanging) < SAME);
    }
}

#[test]
fn a_tree_whose_leaves_were_all_thrown_is_bare() {
    let gpu = Gpu::open();
    let (mut scene, mut stage) = thrown();
    scene.count = 1;
    stage.forest.instances.truncate(1);
    stage.falls.events.retain(|event| event.instance == 0);
    // From the foot up into the crown, past what lies on the ground.
    let foot = stage.forest.instances[0].position;
    scene.camera[0].eye = (foot.x + 2.0, 1.0, foot.z + 2.0);
    scene.camera[0].target = (foot.x, 6.0, foot.z);
    let view = |t| scene.view(t, &stage.forest.terrain);
    let mut bare = stage.clone();
    bare.falls = Falls { capacity: 0, events: Vec::new(), ..bare.falls };
    bare.falls.shedding = Shedding { start: -1e4, duration: 1.0, ..Shedding::default() };
    let [bare, full] = [(&bare, 60.0), (&stage, 0.9)].map(|(stage, t)| {
        gpu.paint(&gpu.forest(stage, Strategy::Compute, Elimination::Off), &view(t))
    });
    let leaves = difference(&bare, &full);
    assert!(leaves > 0.1, "the leaves change the picture by {leaves}");
    for strategy in Strategy::ALL {
        let forest = gpu.forest(&stage, strategy, Elimination::Off);
        let picture = gpu.paint(&forest, &view(60.0));
        let error = difference(&bare, &picture);
        println!("{strategy}: {error:.6}");
        assert!(error < 0.001, "{strategy} differs by {error}");
    }
}

#[test]
fn strategies_agree_at_any_time() {
    let gpu = Gpu::open();
    let (scene, stage) = scene();
    let forests = Strategy::ALL.map(|s| gpu.forest(&stage, s, Elimination::Scheduled));
    let still = gpu.forest(
        &Stage { falls: windfall_gpu::Falls::none(), ..stage.clone() },
        Strategy::Compute,
        Elimination::Off,
    );
    // The second time is past the capacity: the oldest leaves have vanished. The third goes back.
    for (time, show) in [(2.0, Show::Picture), (29.5, Show::Picture), (1.0, Show::Laps)] {
        let view = |t| View { show, ..scene.view(t, &stage.forest.terrain) };
        let pictures = forests.each_ref().map(|forest| gpu.paint(forest, &view(time)));
        let reference = &pictures[3];
        for (strategy, picture) in Strategy::ALL.iter().zip(&pictures).take(3) {
            let error = difference(reference, picture);
            println!("{time} s: {strategy} and compute differ by {error:.6}");
            assert!(error < SAME, "{strategy} differs by {error} at {time} s");
            assert!(picture.falling > 500, "{} leaves in the air", picture.falling);
        }
        // The check can fail: leaves half a second on, and a forest whose leaves hang.
        let later = difference(reference, &gpu.paint(&forests[3], &view(time + 0.5)));
        let hanging = difference(reference, &gpu.paint(&still, &view(time)));
        println!("{time} s: half a second later {later:.6}, no leaf fallen {hanging:.6}");
        assert!(later > 2.0 * SAME && hanging > 2.0 * SAME, "{later} {hanging}");
    }
}

#[test]
fn elimination_and_what_was_drawn_before_make_no_difference() {
    let gpu = Gpu::open();
    let (scene, stage) = scene();
    let view = |t| scene.view(t, &stage.forest.terrain);
    let direct = gpu.paint(&gpu.forest(&stage, Strategy::Vertex, Elimination::Off), &view(6.0));
    assert_eq!(direct.eliminated, 0);
    for elimination in Elimination::ALL {
        let forest = gpu.forest(&stage, Strategy::Vertex, elimination);
        // Forwards, back, and forwards again, with leaves that are small and large in the view.
        let seen = [(0.0, 16.0), (0.1, 60.0), (9.0, 3.0), (5.0, 16.0), (5.5, 1.0), (5.53, 40.0)];
        for (time, away) in seen {
            let mut scene = scene.clone();
            scene.camera[0].eye.2 = away;
            gpu.paint(&forest, &scene.view(time, &stage.forest.terrain));
        }
        let picture = gpu.paint(&forest, &view(6.0));
        assert_eq!(picture.falling, direct.falling, "{elimination}");
        assert_eq!(picture.eliminated > 0, elimination != Elimination::Off, "{elimination}");
        // The order of leaves in a list may decide between two at the same depth.
        let error = difference(&direct, &picture);
        println!("elimination {elimination}: {error:.6}");
        assert!(error < 0.001, "{elimination} differs by {error}");
    }
}
