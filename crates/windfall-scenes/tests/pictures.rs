//! The named scenes, small and with few trees, held against `references/*.png`.
//!
//! After a wanted change of the look: run `scripts/bless`, look at what changed, commit it.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use std::convert::Infallible;
use windfall_gpu::wgpu_profiler::{GpuProfiler, GpuProfilerSettings};
use windfall_gpu::{Capture, GpuForest, Quality, Renderer, Sky, Target, View};
use windfall_scenes::{NAMES, Scene, named};
use windfall_testing::{Mismatch, Snapshots, Tolerance, device};

const SIZE: (u32, u32) = (160, 90);
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

struct Studio {
    device: wgpu::Device,
    queue: wgpu::Queue,
    profiler: GpuProfiler,
    renderer: Renderer,
}

impl Studio {
    fn new() -> Self {
        let (device, queue) = device();
        let settings = GpuProfilerSettings { enable_timer_queries: false, ..Default::default() };
        Self {
            profiler: GpuProfiler::new(&device, settings).unwrap(),
            renderer: Renderer::new(&device, FORMAT),
            device,
            queue,
        }
    }

    fn paint(&self, scene: &Scene, change: impl Fn(View) -> View) -> Vec<u8> {
        let Ok(stage) = scene.build(|_, _| -> Result<_, Infallible> { unreachable!() });
        let Self { device, queue, profiler, renderer } = self;
        let (trees, falls) = (&stage.trees, &stage.falls);
        let forest = GpuForest::with_falls(device, queue, renderer, trees, &stage.forest, falls);
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: SIZE.0, height: SIZE.1, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let canvas = renderer.canvas(device, SIZE.0, SIZE.1);
        let picture = texture.create_view(&Default::default());
        let target = Target { canvas: &canvas, picture: &picture };
        let mut encoder = device.create_command_encoder(&Default::default());
        let view = change(scene.view(scene.time, &stage.forest.terrain));
        renderer.render(queue, &mut encoder, profiler, &forest, &view, target);
        let capture = Capture::encode(device, &mut encoder, &texture);
        queue.submit([encoder.finish()]);
        capture.map();
        device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        capture.take().unwrap().unwrap()
    }
}

/// A thousand trees would take minutes without a GPU; six show the same light. Of a wood seen from
/// afar six are nothing.
fn small(name: &str) -> Scene {
    let mut scene = named(name).unwrap();
    scene.count = scene.count.min(if name == "hillside" { 240 } else { 6 });
    scene
}

#[test]
fn the_named_scenes() {
    let studio = Studio::new();
    let references = Snapshots::of_crate(env!("CARGO_MANIFEST_DIR"));
    for name in NAMES {
        let rgba = studio.paint(&small(name), |view| view);
        references.assert(name, SIZE, &rgba, Tolerance::default());
    }
}

/// What the tolerance must not let pass: another sun, no shadows, the lowest quality.
#[test]
fn other_light_fails() {
    let studio = Studio::new();
    let folder = std::env::temp_dir().join(format!("windfall-other-light-{}", std::process::id()));
    let at = |bless| Snapshots::new(folder.join("references"), folder.join("failures"), bless);
    let scene = small("lone-oak");
    let tolerance = Tolerance::default();
    at(true).assert("light", SIZE, &studio.paint(&scene, |v| v), tolerance);
    at(false).assert("light", SIZE, &studio.paint(&scene, |v| v), tolerance);
    let fails = |what: &str, change: &dyn Fn(View) -> View| {
        let failed = at(false).check("light", SIZE, &studio.paint(&scene, change), tolerance);
        assert!(matches!(failed, Err(Mismatch::Different { .. })), "{what}: {failed:?}");
    };
    let sky = |v: View, azimuth: f32, stops: f32| {
        let (sun_azimuth, exposure) = (v.sky.sun_azimuth + azimuth, v.sky.exposure + stops);
        View { sky: Sky { sun_azimuth, exposure, ..v.sky }, ..v }
    };
    fails("another sun", &|v| sky(v, 0.6, 0.0));
    fails("a quarter stop", &|v| sky(v, 0.0, 0.25));
    fails("no shadows", &|v| View { shadows: false, ..v });
    fails("low quality", &|v| View { quality: Quality::LOW, ..v });
    std::fs::remove_dir_all(folder).unwrap();
}
