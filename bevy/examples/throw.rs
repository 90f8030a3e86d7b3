//! Leaves as things of a game: space shakes the tree, and rings show where the leaves near the player will land.
//!
//!     cargo run --release --example throw

mod common;
mod headless;

use bevy::prelude::*;
use bevy_windfall::windfall::shed::Shedding;
use bevy_windfall::windfall::tree::Species;
use bevy_windfall::windfall::wind::Wind;
use bevy_windfall::{
    LeavesNear, Season, ShakeTree, TreeModel, WindfallForest, WindfallTime, WindfallTree,
    WindfallWind,
};
use common::{dull, eyes, grow, light};

#[derive(Component)]
struct Player;

/// The mark where a leaf will land.
#[derive(Component)]
struct Mark;

const MARKS: usize = 40;

pub(crate) fn build(app: &mut App) {
    app.add_systems(Startup, setup).add_systems(Update, (shake, mark));
}

fn setup(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let tree = WindfallTree::new(grow(&assets, Species::Oak, 4, 4000), 1);
    // Nothing falls by itself.
    let still = WindfallForest { shedding: Shedding::never(), ..default() };
    let breeze = WindfallWind(Wind::new(0.3, 0.6, 0.5, 1));
    commands.spawn((tree, still, Season(0.55), breeze));
    let mut spawn = |mesh: Mesh, color, at: Transform| {
        commands.spawn((dull((&mut meshes, &mut materials), mesh, color), at)).id()
    };
    let floor = Plane3d::default().mesh().size(200.0, 200.0).build();
    spawn(floor, Color::srgb(0.36, 0.4, 0.22), Transform::IDENTITY);
    let coat = Color::srgb(0.6, 0.1, 0.1);
    let player = spawn(Capsule3d::new(0.3, 1.2).into(), coat, Transform::from_xyz(2.0, 0.9, 3.0));
    commands.entity(player).insert(Player);
    for _ in 0..MARKS {
        let ring = dull((&mut meshes, &mut materials), Torus::new(0.12, 0.18).into(), Color::WHITE);
        commands.spawn((ring, Mark, Visibility::Hidden));
    }
    let camera = Transform::from_xyz(0.0, 3.5, 16.0).looking_at(Vec3::new(0.0, 4.0, 0.0), Vec3::Y);
    commands.spawn((eyes(), camera));
    light(&mut commands);
}

fn shake(
    keys: Res<ButtonInput<KeyCode>>,
    models: Res<Assets<TreeModel>>,
    clock: Res<WindfallTime>,
    trees: Query<(Entity, &WindfallTree)>,
    mut shakes: MessageWriter<ShakeTree>,
    mut begun: Local<bool>,
) {
    for (tree, of) in &trees {
        let of_tree = ShakeTree { tree, instance: 0, leaves: 1200, seconds: 4.0, time: None };
        if keys.just_pressed(KeyCode::Space) {
            shakes.write(of_tree);
        }
        // As soon as the tree is there, it has been shaken some seconds ago.
        if !*begun && models.contains(&of.model) {
            *begun = true;
            shakes.write(ShakeTree { time: Some(clock.seconds - 4.0), ..of_tree });
        }
    }
}

fn mark(
    mut near: LeavesNear,
    players: Query<&Transform, (With<Player>, Without<Mark>)>,
    mut marks: Query<(&mut Transform, &mut Visibility), With<Mark>>,
) {
    let Ok(player) = players.single() else { return };
    let mut leaves = near.find(player.translation, 4.0);
    leaves.sort_by(|a, b| a.landing.total_cmp(&b.landing));
    let mut leaves = leaves.into_iter();
    for (mut place, mut visible) in &mut marks {
        *visible = match leaves.next() {
            Some(leaf) => {
                place.translation = leaf.landing_place + Vec3::Y * 0.03;
                Visibility::Visible
            }
            None => Visibility::Hidden,
        };
    }
}

#[allow(dead_code, reason = "the test of the picture has a main of its own")]
fn main() {
    headless::main(build, 10.0);
}
