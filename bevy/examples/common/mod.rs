//! What the examples share: trees, light, ground.
#![allow(dead_code, reason = "each example uses a part")]

use bevy::camera::Hdr;
use bevy::light::{CascadeShadowConfigBuilder, GlobalAmbientLight};
use bevy::prelude::*;
use bevy_windfall::windfall::light::Ambient;
use bevy_windfall::windfall::tree::Species;
use bevy_windfall::{TreeModel, WindfallAmbient};
use std::convert::Infallible;

pub const SKY: Color = Color::srgb(0.62, 0.74, 0.86);

/// A model that grows in the background.
pub fn grow(assets: &AssetServer, species: Species, seed: u32, leaves: u32) -> Handle<TreeModel> {
    assets.add_async(async move { Ok::<_, Infallible>(TreeModel::grow(species, seed, leaves)) })
}

/// A sun with shadows of three cascades, which are as many as leaves receive, and some light from all around.
pub fn light(commands: &mut Commands) {
    commands.insert_resource(ClearColor(SKY));
    commands.insert_resource(GlobalAmbientLight { brightness: 700.0, ..default() });
    let cascades = CascadeShadowConfigBuilder {
        num_cascades: 3,
        first_cascade_far_bound: 12.0,
        maximum_distance: 90.0,
        ..default()
    };
    commands.spawn((
        DirectionalLight {
            illuminance: 9_000.0,
            color: Color::srgb(1.0, 0.94, 0.84),
            shadow_maps_enabled: true,
            ..default()
        },
        cascades.build(),
        Transform::from_xyz(5.0, 6.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

/// What a camera needs: a target with a range, edges without steps, a sky that lights leaves.
pub fn eyes() -> impl Bundle {
    let sky = Ambient::project(|towards| {
        let ground = Vec3::new(0.16, 0.13, 0.09);
        ground.lerp(Vec3::new(0.55, 0.7, 0.95), 0.5 + 0.5 * towards.y) * 250.0
    });
    (Camera3d::default(), Hdr, Msaa::Sample4, WindfallAmbient(sky))
}

/// A mesh in one dull colour.
pub fn dull(
    (meshes, materials): (&mut Assets<Mesh>, &mut Assets<StandardMaterial>),
    mesh: Mesh,
    color: Color,
) -> impl Bundle {
    let (mesh, material) = (meshes.add(mesh), materials.add(dull_material(color)));
    (Mesh3d(mesh), MeshMaterial3d(material))
}

fn dull_material(color: Color) -> StandardMaterial {
    StandardMaterial { base_color: color, perceptual_roughness: 1.0, reflectance: 0.1, ..default() }
}
