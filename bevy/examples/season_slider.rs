//! Six species, and a slider for the phase of autumn: the arrow keys, or the mouse while its left button is down.
//!
//!     cargo run --release --example season_slider

mod common;
mod headless;

use bevy::prelude::*;
use bevy_windfall::windfall::forest::Instance;
use bevy_windfall::windfall::shed::Shedding;
use bevy_windfall::windfall::tree::Species;
use bevy_windfall::{Season, Trees, WindfallForest};
use common::{dull, eyes, grow, light};

/// The knob of the slider, which is a ball on a beam.
#[derive(Component)]
struct Knob;

/// Half of the beam's length, metres.
const HALF: f32 = 8.0;

pub(crate) fn build(app: &mut App) {
    app.add_systems(Startup, setup).add_systems(Update, slide);
}

fn setup(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let models = Species::ALL.map(|species| grow(&assets, species, 7, 3000));
    let instance = |i: u32| Instance {
        model: i,
        position: Vec3::new((i as f32 - 2.5) * 7.0, 0.0, (i % 2) as f32 * -4.0),
        yaw: i as f32,
        scale: 1.0,
        season_offset: 0.0,
        seed: i + 1,
    };
    commands.spawn((
        WindfallForest {
            models: models.to_vec(),
            trees: Trees::At((0..6).map(instance).collect()),
            // Some leaves are in the air, whatever the season.
            shedding: Shedding { start: -60.0, duration: 1200.0, ..default() },
            ..default()
        },
        Season(0.7),
    ));
    let mut spawn = |mesh: Mesh, color, at: Transform| {
        commands.spawn((dull((&mut meshes, &mut materials), mesh, color), at)).id()
    };
    let floor = Plane3d::default().mesh().size(200.0, 200.0).build();
    spawn(floor, Color::srgb(0.3, 0.34, 0.16), Transform::IDENTITY);
    let beam = Cuboid::new(2.0 * HALF, 0.15, 0.15).into();
    spawn(beam, Color::srgb(0.2, 0.16, 0.12), Transform::from_xyz(0.0, 0.7, 12.0));
    let knob = Sphere::new(0.5).into();
    let knob = spawn(knob, Color::srgb(0.85, 0.3, 0.1), Transform::from_xyz(0.0, 0.7, 12.0));
    commands.entity(knob).insert(Knob);
    let camera = Transform::from_xyz(0.0, 5.0, 30.0).looking_at(Vec3::new(0.0, 6.0, 0.0), Vec3::Y);
    commands.spawn((eyes(), camera));
    light(&mut commands);
}

fn slide(
    keys: Res<ButtonInput<KeyCode>>,
    buttons: Res<ButtonInput<MouseButton>>,
    windows: Query<&Window>,
    time: Res<Time>,
    mut forests: Query<&mut Season>,
    mut knobs: Query<&mut Transform, With<Knob>>,
) {
    for mut season in &mut forests {
        if keys.pressed(KeyCode::ArrowRight) {
            season.0 += 0.3 * time.delta_secs();
        }
        if keys.pressed(KeyCode::ArrowLeft) {
            season.0 -= 0.3 * time.delta_secs();
        }
        if let Ok(window) = windows.single()
            && let Some(at) = window.cursor_position()
            && buttons.pressed(MouseButton::Left)
        {
            season.0 = at.x / window.width();
        }
        season.0 = season.0.clamp(0.0, 1.0);
        for mut knob in &mut knobs {
            knob.translation.x = (2.0 * season.0 - 1.0) * HALF;
        }
    }
}

#[allow(dead_code, reason = "the test of the picture has a main of its own")]
fn main() {
    headless::main(build, 20.0);
}
