//! What cameras see, pixel by pixel.

#[path = "../examples/headless/mod.rs"]
mod headless;

use bevy::camera::Hdr;
use bevy::prelude::*;
use bevy_windfall::windfall::tree::{Species, Tree};
use bevy_windfall::{TreeModel, WindfallForest, WindfallTree};
use headless::Headless;
use std::sync::{Arc, OnceLock};

/// A maple of 600 leaves, some 7 m high.
fn maple() -> TreeModel {
    static MAPLE: OnceLock<Arc<Tree>> = OnceLock::new();
    let tree = MAPLE.get_or_init(|| Arc::new(Species::Maple.grow_with(3, 600))).clone();
    TreeModel { tree, notes: Vec::new() }
}

const SIZE: UVec2 = UVec2::new(160, 120);

fn scene(app: &mut App) {
    let model = app.world_mut().resource_mut::<Assets<TreeModel>>().add(maple());
    let world = app.world_mut();
    world.spawn(WindfallTree::new(model, 1));
    world.spawn((
        DirectionalLight { illuminance: 10_000.0, shadow_maps_enabled: true, ..default() },
        Transform::from_xyz(3.0, 5.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    let eye = Transform::from_xyz(0.0, 5.0, 18.0).looking_at(Vec3::new(0.0, 4.0, 0.0), Vec3::Y);
    world.spawn((Camera3d::default(), eye, Hdr, Msaa::Off));
    let mesh = world.resource_mut::<Assets<Mesh>>().add(Plane3d::default().mesh().size(60.0, 60.0));
    let grey = Color::srgb(0.5, 0.45, 0.4);
    let material = world.resource_mut::<Assets<StandardMaterial>>().add(grey);
    world.spawn((Mesh3d(mesh), MeshMaterial3d(material)));
}

#[test]
fn a_tree_stands_there() {
    let mut headless = Headless::new(SIZE, scene);
    let image = headless.picture(20.0);
    image.try_into_dynamic().unwrap().to_rgb8().save("/tmp/bv/a.png").unwrap();
    let _ = WindfallForest::default();
}
