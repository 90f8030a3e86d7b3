//! A whole host: reads a glTF tree, plants forty of it, and renders a PNG without a window.
//!
//!     cargo run --release --example own_tree -- my_tree.glb forest.png
use anyhow::Context;
use pollster::block_on;
use std::path::Path;
use windfall::forest::{KeepOut, Placement, Terrain};
use windfall::glam::{DVec3, Vec2};
use windfall::tree::{ImportOptions, import};
use windfall::{Camera, Capture, Falls, Forest, Moment, Options, Picture};
use windfall::{Recording, Renderer, Requirements, TreeModel, View, wgpu};

const SIZE: wgpu::Extent3d = wgpu::Extent3d { width: 960, height: 540, depth_or_array_layers: 1 };

pub(crate) fn render(tree: &Path, picture: &Path) -> anyhow::Result<()> {
    let (name, bytes) = (tree.display().to_string(), std::fs::read(tree));
    let mut beside = |f: &str| std::fs::read(tree.with_file_name(f)).map_err(|e| e.to_string());
    let options = ImportOptions { height: Some(12.0), ..Default::default() };
    let tree = import(&bytes.with_context(|| name.clone())?, &name, &options, &mut beside)?.tree;
    // The device is the host's.
    let options = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    let adapter = block_on(wgpu::Instance::new(options).request_adapter(&Default::default()))?;
    let needs = Requirements::of(&adapter)?;
    let (device, queue) = block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: needs.features,
        required_limits: needs.limits,
        ..Default::default()
    }))?;
    let texture = Capture::texture(&device, SIZE, wgpu::TextureFormat::Rgba8UnormSrgb);
    // Once per device, per tree, per forest, per view, per size of picture.
    let renderer = Renderer::new(&device, &Options::picture(texture.format()))?;
    let model = TreeModel::new(&device, &queue, &tree)?;
    let glade = KeepOut { from: Vec2::ZERO, to: Vec2::new(0.0, 34.0), radius: 7.0 };
    let placement = Placement { trees: 40, keep_out: vec![glade], ..Default::default() };
    let placed = placement.place(Terrain::rolling(300.0, 2.0, 7), &[1.0]);
    let mut forest = Forest::new(&device, DVec3::ZERO, placed.terrain, Falls::default())?;
    forest.plant(&[model], &placed.instances)?;
    let mut state = renderer.view(&forest);
    let targets = renderer.targets(SIZE.width, SIZE.height)?;
    // Every frame: the forest's moment, a picture of it, and here its way back.
    let (eye, target) = (DVec3::new(0.0, 4.0, 34.0), DVec3::new(0.0, 5.0, 0.0));
    let view = View::new(Camera::look_at(eye, target, 0.9, 0.1));
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut recording = Recording::new(&queue, &mut encoder);
    renderer.advance(&mut recording, &mut forest, Moment::of(20.0, &view))?;
    let output = &texture.create_view(&Default::default());
    let frame = Picture { targets: &targets, output, layers: &mut [] };
    renderer.render(&mut recording, &forest, &mut state, &view, frame)?;
    let capture = Capture::encode(&device, &mut encoder, &texture);
    queue.submit([encoder.finish()]);
    capture.map();
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let rgba = capture.take().context("the picture did not arrive")??;
    Ok(image::save_buffer(picture, &rgba, SIZE.width, SIZE.height, image::ColorType::Rgba8)?)
}

fn main() -> anyhow::Result<()> {
    let path = |n| std::env::args_os().nth(n).context("usage: own_tree TREE.glb PICTURE.png");
    render(path(1)?.as_ref(), path(2)?.as_ref())
}
