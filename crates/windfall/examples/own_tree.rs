//! A whole host: reads a glTF tree, plants forty of it, and renders a PNG without a window.
//!
//!     cargo run --release --example own_tree -- my_tree.glb forest.png

use anyhow::Context;
use pollster::block_on;
use std::path::{Path, PathBuf};
use windfall::forest::{KeepOut, Placement, Terrain};
use windfall::glam::{Vec2, Vec3};
use windfall::tree::{ImportOptions, export_glb, import, species::Species};
use windfall::wgpu_profiler::{GpuProfiler, GpuProfilerSettings};
use windfall::{Camera, Capture, Falls, GpuForest, Renderer, Target, View, wgpu};

const SIZE: wgpu::Extent3d = wgpu::Extent3d { width: 960, height: 540, depth_or_array_layers: 1 };

/// Renders a forest of the tree in `tree` to the PNG `picture`.
///
/// # Errors
///
/// A file that is no tree, no adapter, or a picture that cannot be written.
pub fn render(tree: &Path, picture: &Path) -> anyhow::Result<()> {
    // The tree. The library opens no file: what a .gltf names beside itself is asked for here.
    let folder = tree.parent().unwrap_or(Path::new(""));
    let mut beside = |name: &str| std::fs::read(folder.join(name)).map_err(|e| e.to_string());
    let options = ImportOptions { height: Some(12.0), ..Default::default() };
    let bytes = std::fs::read(tree).with_context(|| tree.display().to_string())?;
    let tree = import(&bytes, &tree.display().to_string(), &options, &mut beside)?;

    // The forest, with room for the camera.
    let (eye, target) = (Vec3::new(0.0, 4.0, 34.0), Vec3::new(0.0, 5.0, 0.0));
    let glade = KeepOut { from: Vec2::ZERO, to: Vec2::new(eye.x, eye.z), radius: 7.0 };
    let forest = Placement {
        trees: 40,
        spacing: 5.0,
        keep_out: vec![glade],
        scale: (0.8, 1.2),
        season_spread: 0.1,
        seed: 7,
    }
    .place(Terrain::rolling(300.0, 2.0, 7), &[1.0]);

    // The device is the host's.
    let instance =
        wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter = block_on(instance.request_adapter(&Default::default()))?;
    let (device, queue) = block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        // With it, distant wood is drawn in fewer triangles.
        required_features: adapter.features() & wgpu::Features::INDIRECT_FIRST_INSTANCE,
        required_limits: adapter.limits(),
        ..Default::default()
    }))?;
    let settings = GpuProfilerSettings { enable_timer_queries: false, ..Default::default() };
    let profiler = GpuProfiler::new(&device, settings)?;
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: SIZE,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });

    // Once per device, per forest, per size of picture.
    let renderer = Renderer::new(&device, texture.format());
    let falls = Falls::default();
    let gpu_forest = GpuForest::with_falls(&device, &queue, &renderer, &[tree], &forest, &falls);
    let canvas = renderer.canvas(&device, SIZE.width, SIZE.height);

    // A frame, and its way back.
    let camera = Camera { eye, target, fov_y: 0.9, near: 0.1 };
    let view = View { time: 20.0, ..View::new(camera) };
    let mut encoder = device.create_command_encoder(&Default::default());
    let target = Target { canvas: &canvas, picture: &texture.create_view(&Default::default()) };
    let stats = renderer.render(&queue, &mut encoder, &profiler, &gpu_forest, &view, target);
    let capture = Capture::encode(&device, &mut encoder, &texture);
    queue.submit([encoder.finish()]);
    capture.map();
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let rgba = capture.take().context("the picture did not arrive")??;
    image::save_buffer(picture, &rgba, SIZE.width, SIZE.height, image::ColorType::Rgba8)?;
    println!("{}: {} trees, {} leaves", picture.display(), stats.trees, stats.leaves_total);
    Ok(())
}

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let folder = tempfile::tempdir()?;
    let tree = if let Some(tree) = arguments.next() {
        tree
    } else {
        // No tree of one's own: a built-in birch takes the same way.
        let birch = folder.path().join("birch.glb");
        std::fs::write(&birch, export_glb(&Species::Birch.grow(1))?)?;
        birch
    };
    render(&tree, &arguments.next().unwrap_or("own_tree.png".into()))
}
