//! A walk through a forest: a character, boxes that stand before and behind trees, and leaves that fall on all of it.
//! W, A, S and D walk and turn.
//!
//!     cargo run --release --example forest
//!     cargo run --release --example forest -- --screenshot forest.png

mod common;
mod headless;

use bevy::prelude::*;
use bevy_windfall::windfall::forest::{KeepOut, Placement, Terrain};
use bevy_windfall::windfall::tree::Species;
use bevy_windfall::{Season, Trees, WindfallForest, ground_mesh};
use common::{dull, eyes, grow, light};
use std::sync::Arc;

#[derive(Component)]
struct Walker;

/// The ground, for feet.
#[derive(Resource)]
struct Ground(Arc<Terrain>);

pub(crate) fn build(app: &mut App) {
    app.add_systems(Startup, setup).add_systems(Update, walk);
}

fn setup(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let terrain = Arc::new(Terrain::rolling(240.0, 2.0, 5));
    let models = [(Species::Maple, 1), (Species::Birch, 2), (Species::Oak, 3)]
        .map(|(species, seed)| grow(&assets, species, seed, 3000));
    let path = KeepOut { from: Vec2::new(0.0, -40.0), to: Vec2::new(0.0, 24.0), radius: 3.0 };
    let placement =
        Placement { trees: 90, spacing: 5.0, keep_out: vec![path], seed: 4, ..default() };
    commands.spawn((
        WindfallForest {
            models: models.to_vec(),
            trees: Trees::Placed(placement),
            terrain: terrain.clone(),
            ..default()
        },
        Season(0.6),
    ));
    let mut spawn = |mesh: Mesh, color, at: Transform| {
        commands.spawn((dull((&mut meshes, &mut materials), mesh, color), at)).id()
    };
    spawn(ground_mesh(&terrain, 240.0), Color::srgb(0.36, 0.29, 0.19), Transform::IDENTITY);
    let stone = Color::srgb(0.55, 0.55, 0.53);
    for (x, z, size) in [(-3.2, 9.0, 1.6), (3.4, 4.0, 2.2), (-4.5, -6.0, 2.8), (5.0, -14.0, 3.0)] {
        let at = Vec3::new(x, terrain.height(x, z) + 0.4 * size, z);
        let turn = Quat::from_rotation_y(x + z);
        let mesh = Cuboid::from_length(size).into();
        spawn(mesh, stone, Transform::from_translation(at).with_rotation(turn));
    }
    let at = Vec3::new(0.0, terrain.height(0.0, 12.0) + 0.9, 12.0);
    let coat = Color::srgb(0.1, 0.22, 0.5);
    let walker = spawn(Capsule3d::new(0.3, 1.2).into(), coat, Transform::from_translation(at));
    let over_the_shoulder = Transform::from_xyz(1.2, 1.5, 6.0);
    let camera = over_the_shoulder.looking_at(Vec3::new(0.0, 1.6, -10.0), Vec3::Y);
    commands.entity(walker).insert(Walker).with_child((eyes(), camera));
    commands.insert_resource(Ground(terrain));
    light(&mut commands);
}

fn walk(
    keys: Res<ButtonInput<KeyCode>>,
    time: Res<Time>,
    ground: Res<Ground>,
    mut walkers: Query<&mut Transform, With<Walker>>,
) {
    let axis = |more, less| {
        f32::from(u8::from(keys.pressed(more))) - f32::from(u8::from(keys.pressed(less)))
    };
    for mut walker in &mut walkers {
        walker.rotate_y(1.5 * axis(KeyCode::KeyA, KeyCode::KeyD) * time.delta_secs());
        let step =
            walker.forward() * (3.0 * axis(KeyCode::KeyW, KeyCode::KeyS) * time.delta_secs());
        walker.translation += step;
        let Vec3 { x, z, .. } = walker.translation;
        walker.translation.y = ground.0.height(x, z) + 0.9;
    }
}

#[allow(dead_code, reason = "the test of the picture has a main of its own")]
fn main() {
    headless::main(build, 40.0);
}
