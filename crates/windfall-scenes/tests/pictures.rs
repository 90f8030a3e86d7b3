//! The named scenes, small and with few trees, held against `references/*.png`.
//!
//! After a wanted change of the look: run `scripts/bless`, look at what changed, commit it.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use std::convert::Infallible;
use windfall_gpu::{Capture, Light, Options, Quality, Recording, Renderer, Sky, View};
use windfall_scenes::{NAMES, Scene, named};
use windfall_testing::{Mismatch, Snapshots, Tolerance, default_device, device, picture};

const SIZE: (u32, u32) = (160, 90);

struct Harness {
    device: wgpu::Device,
    queue: wgpu::Queue,
    renderer: Renderer,
}

impl Harness {
    fn new((device, queue): (wgpu::Device, wgpu::Queue)) -> Self {
        let options = Options::picture(wgpu::TextureFormat::Rgba8UnormSrgb);
        Self { renderer: Renderer::new(&device, &options).unwrap(), device, queue }
    }

    fn render(&self, scene: &Scene, change: impl Fn(View) -> View) -> Vec<u8> {
        let Ok(stage) = scene.build(|_, _| -> Result<_, Infallible> { unreachable!() });
        let Self { device, queue, renderer } = self;
        let mut planted = stage.upload(device, queue).unwrap();
        let texture = picture(device, SIZE);
        let output = texture.create_view(&Default::default());
        let targets = renderer.targets(SIZE.0, SIZE.1).unwrap();
        let mut state = renderer.view(&planted.forest);
        let view = change(scene.view(scene.time, &stage.forest.terrain));
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut recording = Recording::new(queue, &mut encoder);
        let (at, to) = ((scene.time, &view), (&targets, &output));
        planted.render(renderer, &mut recording, &mut state, at, to).unwrap();
        let capture = Capture::encode(device, &mut encoder, &texture);
        queue.submit([encoder.finish()]);
        capture.map();
        windfall_testing::wait(device, || capture.take()).unwrap()
    }
}

/// A thousand trees would take minutes without a GPU; six show the same light. Of a wood seen from
/// afar six are nothing.
fn small(name: &str) -> Scene {
    let mut scene = named(name).unwrap();
    scene.count = scene.count.min(if name == "hillside" { 240 } else { 6 });
    scene
}

/// Means of red, green and blue over squares of ten pixels.
fn squares(rgba: &[u8]) -> Vec<f64> {
    let (width, height) = (SIZE.0 as usize, SIZE.1 as usize);
    let mut means = vec![0.0; width / 10 * (height / 10) * 3];
    for (i, pixel) in rgba.chunks(4).enumerate() {
        let square = i / width / 10 * (width / 10) + i % width / 10;
        for channel in 0..3 {
            means[3 * square + channel] += f64::from(pixel[channel]) / 100.0;
        }
    }
    means
}

/// What every browser has draws every named scene. Leaf by leaf it differs from a device that can begin a draw
/// within a list, which draws far wood and small leaves in fewer triangles: so squares are compared.
#[test]
fn a_device_of_default_limits_draws_the_named_scenes() {
    let [full, least] = [device(), default_device()].map(Harness::new);
    for name in NAMES {
        let scene = small(name);
        let [a, b] = [&full, &least].map(|harness| squares(&harness.render(&scene, |view| view)));
        let apart = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).sum::<f64>() / a.len() as f64;
        assert!(apart < 5.0, "{name}: squares are {apart} of 255 apart");
    }
}

#[test]
fn the_named_scenes() {
    let harness = Harness::new(device());
    let references = Snapshots::of_crate(env!("CARGO_MANIFEST_DIR"));
    for name in NAMES {
        let rgba = harness.render(&small(name), |view| view);
        references.assert(name, SIZE, &rgba, Tolerance::default());
    }
}

/// What the tolerance must not let pass: another sun, no shadows, the lowest quality.
#[test]
fn other_light_fails() {
    let harness = Harness::new(device());
    let folder = std::env::temp_dir().join(format!("windfall-other-light-{}", std::process::id()));
    let at = |bless| Snapshots::new(folder.join("references"), folder.join("failures"), bless);
    let scene = small("lone-oak");
    let tolerance = Tolerance::default();
    at(true).assert("light", SIZE, &harness.render(&scene, |v| v), tolerance);
    at(false).assert("light", SIZE, &harness.render(&scene, |v| v), tolerance);
    let fails = |what: &str, change: &dyn Fn(View) -> View| {
        let failed = at(false).check("light", SIZE, &harness.render(&scene, change), tolerance);
        assert!(matches!(failed, Err(Mismatch::Different { .. })), "{what}: {failed:?}");
    };
    let sky = |v: View, azimuth: f32, stops: f32| {
        let Light::Sky(sky, None) = v.light else { panic!("{v:?}") };
        let (sun_azimuth, exposure) = (sky.sun_azimuth + azimuth, sky.exposure + stops);
        View { light: Sky { sun_azimuth, exposure, ..sky }.into(), ..v }
    };
    fails("another sun", &|v| sky(v, 0.6, 0.0));
    fails("a quarter stop", &|v| sky(v, 0.0, 0.25));
    fails("no shadows", &|v| View { shadows: false, ..v });
    fails("low quality", &|v| View { quality: Quality::LOW, ..v });
    std::fs::remove_dir_all(folder).unwrap();
}
