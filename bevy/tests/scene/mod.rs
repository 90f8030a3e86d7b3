//! A tree, a sun and a camera, and how their pictures are read.
#![allow(dead_code, reason = "each test file uses a part")]

#[path = "../../examples/headless/mod.rs"]
pub mod headless;

use bevy::camera::Hdr;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use bevy_windfall::windfall::shed::Shedding;
use bevy_windfall::windfall::tree::{Species, Tree};
use bevy_windfall::{LeafBudget, TreeModel, WindfallForest, WindfallTree};
use headless::Headless;
use std::sync::{Arc, OnceLock};

pub const SIZE: UVec2 = UVec2::new(160, 120);
pub const MAGENTA: Color = Color::srgb(1.0, 0.0, 1.0);

/// A maple of 600 leaves, some 10 m high.
pub fn maple() -> TreeModel {
    static MAPLE: OnceLock<Arc<Tree>> = OnceLock::new();
    let tree = MAPLE.get_or_init(|| Arc::new(Species::Maple.grow_with(3, 600))).clone();
    TreeModel { tree, notes: Vec::new() }
}

pub fn model(world: &mut World) -> Handle<TreeModel> {
    world.resource_mut::<Assets<TreeModel>>().add(maple())
}

/// A tree that sheds nothing, at the origin.
pub fn still_tree(world: &mut World) -> Entity {
    let model = model(world);
    let forest = WindfallForest { shedding: Shedding::never(), ..default() };
    world.spawn((WindfallTree::new(model, 1), forest, LeafBudget(20_000))).id()
}

pub fn eye() -> Transform {
    Transform::from_xyz(0.0, 5.0, 18.0).looking_at(Vec3::new(0.0, 5.0, 0.0), Vec3::Y)
}

/// A camera whose colours no tone curve changes.
pub fn camera(world: &mut World) -> Entity {
    world.spawn((Camera3d::default(), eye(), Hdr, Msaa::Off, Tonemapping::None)).id()
}

pub fn sun(world: &mut World) -> Entity {
    let light = DirectionalLight { illuminance: 9_000.0, shadow_maps_enabled: true, ..default() };
    let place = Transform::from_xyz(3.0, 5.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y);
    world.spawn((light, place)).id()
}

/// A box in one colour, whatever the light.
pub fn flat_box(world: &mut World, size: Vec3, at: Vec3, color: Color) -> Entity {
    let mesh = world.resource_mut::<Assets<Mesh>>().add(Cuboid::from_size(size));
    let material = StandardMaterial { base_color: color, unlit: true, ..default() };
    let material = world.resource_mut::<Assets<StandardMaterial>>().add(material);
    world.spawn((Mesh3d(mesh), MeshMaterial3d(material), Transform::from_translation(at))).id()
}

/// A white floor in the light, `size` metres across.
pub fn floor(world: &mut World, size: f32) -> Entity {
    let mesh = world.resource_mut::<Assets<Mesh>>().add(Plane3d::default().mesh().size(size, size));
    let material = StandardMaterial { perceptual_roughness: 1.0, reflectance: 0.0, ..default() };
    let material = world.resource_mut::<Assets<StandardMaterial>>().add(material);
    world.spawn((Mesh3d(mesh), MeshMaterial3d(material))).id()
}

/// An application with these in it.
pub fn app(build: impl FnOnce(&mut World)) -> Headless {
    Headless::new(SIZE, |app| build(app.world_mut()))
}

/// The pixels at `time`, four bytes each.
pub fn pixels(headless: &mut Headless, time: f64) -> Vec<[u8; 4]> {
    let image = headless.picture(time);
    let bytes = image.data.expect("a screenshot has its data");
    bytes.chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect()
}

/// Share of the pixels of `a` and `b` that differ by more than `most` in a channel.
pub fn apart(a: &[[u8; 4]], b: &[[u8; 4]], most: u8) -> f32 {
    let differ = |(a, b): (&[u8; 4], &[u8; 4])| (0..3).any(|i| a[i].abs_diff(b[i]) > most);
    a.iter().zip(b).filter(|of| differ(*of)).count() as f32 / a.len() as f32
}

pub fn is_magenta(p: &[u8; 4]) -> bool {
    p[0] > 250 && p[1] < 5 && p[2] > 250
}

/// Mean of a channel in sRGB bytes, in a window of the picture: left, top, width, height in pixels.
pub fn mean(pixels: &[[u8; 4]], channel: usize, window: [usize; 4]) -> f32 {
    let [left, top, width, height] = window;
    let rows = top..top + height;
    let all = rows.flat_map(|y| (left..left + width).map(move |x| (x, y)));
    let sum: f32 = all.map(|(x, y)| f32::from(pixels[y * SIZE.x as usize + x][channel])).sum();
    sum / (width * height) as f32
}
