//! A scene gives the same picture whatever its strategy, elimination and earlier frames.
//!
//! What the published strategies do by themselves, `windfall-papers` tests.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use std::convert::Infallible;
use windfall_core::shed::Shedding;
use windfall_gpu::{Capture, DebugView, Options, Recording, Renderer, View, ViewState};
use windfall_scenes::{
    Elimination, EventEntry, PlantedStage, Scene, Source, Stage, StageCounts, Strategy, TreeEntry,
    named,
};

const SIZE: (u32, u32) = (256, 144);
/// Largest mean FLIP error of two pictures that are the same.
const SAME: f32 = 0.005;

struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    renderer: Renderer,
}

/// A forest and its view.
struct Planted {
    stage: PlantedStage,
    state: ViewState,
}

struct Shot {
    rgb: Vec<u8>,
    counts: StageCounts,
}

impl Gpu {
    fn open() -> Self {
        let (device, queue) = windfall_testing::device();
        let options = Options::picture(wgpu::TextureFormat::Rgba8UnormSrgb);
        Self { renderer: Renderer::new(&device, &options).unwrap(), device, queue }
    }

    fn plant(&self, stage: &Stage, strategy: Strategy, elimination: Elimination) -> Planted {
        let stage = Stage { strategy, elimination, ..stage.clone() };
        let stage = stage.upload(&self.device, &self.queue).unwrap();
        Planted { state: self.renderer.view(&stage.forest), stage }
    }

    fn shoot(&self, planted: &mut Planted, time: f64, view: &View) -> Shot {
        let texture = windfall_testing::picture(&self.device, SIZE);
        let output = texture.create_view(&Default::default());
        let targets = self.renderer.targets(SIZE.0, SIZE.1).unwrap();
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let mut recording = Recording::new(&self.queue, &mut encoder);
        let Planted { stage, state } = planted;
        let to = (&targets, &output);
        stage.render(&self.renderer, &mut recording, state, (time, view), to).unwrap();
        let capture = Capture::encode(&self.device, &mut encoder, &texture);
        let counts = stage.count(&self.device, &mut encoder, state).unwrap();
        self.queue.submit([encoder.finish()]);
        capture.map();
        counts.map();
        let rgba = windfall_testing::wait(&self.device, || capture.take()).unwrap();
        let counts = windfall_testing::wait(&self.device, || counts.take()).unwrap();
        let rgb = rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
        Shot { rgb, counts }
    }
}

/// Mean FLIP error, 0 for equal pictures to 1.
fn difference(a: &Shot, b: &Shot) -> f32 {
    let image = |shot: &Shot| nv_flip::FlipImageRgb8::with_data(SIZE.0, SIZE.1, &shot.rgb);
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

#[test]
fn strategies_agree_at_any_time() {
    let gpu = Gpu::open();
    let (scene, stage) = scene();
    let mut forests = Strategy::ALL.map(|s| gpu.plant(&stage, s, Elimination::Scheduled));
    let bare = Stage { falls: windfall_gpu::Falls::none(), ..stage.clone() };
    let mut still = gpu.plant(&bare, Strategy::Compute, Elimination::Scheduled);
    // The second time is past the capacity: the oldest leaves have vanished. The third goes back.
    for (time, show) in [(2.0, DebugView::Final), (29.5, DebugView::Final), (1.0, DebugView::Loops)]
    {
        let view = View { show, ..scene.view(time, &stage.forest.terrain) };
        let shots = forests.each_mut().map(|forest| gpu.shoot(forest, time, &view));
        let (reference, published) = shots.split_last().unwrap();
        assert_eq!(reference.counts.eliminated, 0);
        for (strategy, shot) in Strategy::ALL.iter().zip(published) {
            let error = difference(reference, shot);
            println!("{time} s: {strategy} and compute differ by {error:.6}");
            assert!(error < SAME, "{strategy} differs by {error} at {time} s");
            let (counts, expected) = (shot.counts, reference.counts);
            assert!(counts.falling > 500, "{} leaves in the air", counts.falling);
            assert_eq!((counts.falling, counts.landed), (expected.falling, expected.landed));
            assert_eq!(counts.eliminated, counts.landed, "{strategy}");
            assert_eq!(counts.trees, expected.trees, "{strategy}");
        }
        // The check can fail: leaves half a second on, and a forest whose leaves hang.
        let later =
            difference(reference, &gpu.shoot(forests.last_mut().unwrap(), time + 0.5, &view));
        let hanging = difference(reference, &gpu.shoot(&mut still, time, &view));
        println!("{time} s: half a second later {later:.6}, no leaf fallen {hanging:.6}");
        assert!(later > 2.0 * SAME && hanging > 2.0 * SAME, "{later} {hanging}");
    }
}

#[test]
fn the_elimination_of_a_scene_is_used_and_makes_no_difference() {
    let gpu = Gpu::open();
    let (scene, mut stage) = scene();
    let view = |time| scene.view(time, &stage.forest.terrain);
    let mut off = gpu.plant(&stage, Strategy::Vertex, Elimination::Off);
    let direct = gpu.shoot(&mut off, 6.0, &view(6.0));
    assert_eq!((direct.counts.eliminated, direct.counts.checked), (0, 0));
    stage.elimination_per_frame = 12;
    for elimination in [Elimination::Progressive, Elimination::Scheduled] {
        let mut forest = gpu.plant(&stage, Strategy::Vertex, elimination);
        let before = [0.0, 0.1, 9.0, 5.9]
            .map(|time| gpu.shoot(&mut forest, time, &view(time)).counts.checked);
        let shot = gpu.shoot(&mut forest, 6.0, &view(6.0));
        assert_eq!(shot.counts.falling, direct.counts.falling, "{elimination}");
        assert!(shot.counts.eliminated > 0, "{elimination}");
        if elimination == Elimination::Progressive {
            // As many as there may be where more are due.
            assert_eq!(before.iter().max(), Some(&12), "{before:?}");
        }
        // The order of leaves in a list may decide between two at the same depth.
        let error = difference(&direct, &shot);
        assert!(error < 0.001, "{elimination} differs by {error}");
    }
}

#[test]
fn leaf_occlusion_is_used_where_it_is_chosen() {
    let gpu = Gpu::open();
    let (scene, mut stage) = scene();
    let view = scene.view(2.0, &stage.forest.terrain);
    for chosen in [false, true] {
        stage.leaf_occlusion = chosen.then(windfall_papers::LeafOcclusion::default);
        let mut forest = gpu.plant(&stage, Strategy::Vertex, Elimination::Scheduled);
        let counts = gpu.shoot(&mut forest, 2.0, &view).counts;
        assert_eq!(counts.tested > 0, chosen, "{counts:?}");
    }
}

/// The same trees, which shed nothing of themselves: every leaf of the first and every third of the
/// others is thrown, a second after the other of a hundred.
#[test]
fn leaves_of_events_are_the_same_by_every_strategy_and_in_any_order_of_moments() {
    let gpu = Gpu::open();
    let (scene, mut stage) = scene();
    stage.falls.shedding = Shedding::never();
    let events = (0..).zip(&stage.forest.instances).flat_map(|(tree, planted)| {
        let leaves = stage.trees[planted.model as usize].foliage.leaves.len() as u32;
        let step = if tree == 0 { 1 } else { 3 };
        let time = |leaf: u32| 1.0 + f64::from(leaf % 100) / 100.0;
        (0..leaves).step_by(step).map(move |leaf| EventEntry { tree, leaf, time: time(leaf) })
    });
    stage.events = events.collect();
    stage.check("s.ron").unwrap();
    let view = |t| scene.view(t, &stage.forest.terrain);
    let mut forests = Strategy::ALL.map(|s| gpu.plant(&stage, s, Elimination::Scheduled));
    let hanging = gpu.shoot(&mut forests[3], 0.9, &view(0.9));
    // In the air, all on the ground, and back again.
    for time in [2.5, 60.0, 1.4] {
        let shots = forests.each_mut().map(|forest| gpu.shoot(forest, time, &view(time)));
        let mut fresh = gpu.plant(&stage, Strategy::Compute, Elimination::Scheduled);
        let direct = gpu.shoot(&mut fresh, time, &view(time));
        assert!(direct.counts.falling + direct.counts.landed > 3000, "{:?}", direct.counts);
        for (strategy, shot) in Strategy::ALL.iter().zip(&shots) {
            let error = difference(&direct, shot);
            println!("{time} s: {strategy} differs by {error:.6}");
            assert!(error < 0.001, "{strategy} differs by {error} at {time} s");
            assert_eq!(shot.counts.falling, direct.counts.falling, "{strategy} at {time} s");
        }
        let moved = difference(&direct, &hanging);
        assert!(moved > 2.0 * SAME, "{moved}");
    }
    for forest in &mut forests {
        assert!(difference(&gpu.shoot(forest, 0.9, &view(0.9)), &hanging) < SAME);
    }
}
