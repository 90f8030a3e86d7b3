//! Two players: one in late summer, one in autumn. Each camera has half of the window, and a render layer with a forest
//! of its own, of the same models.
//!
//!     cargo run --release --example split_screen

mod common;
mod headless;

use bevy::camera::Viewport;
use bevy::camera::visibility::RenderLayers;
use bevy::prelude::*;
use bevy_windfall::windfall::tree::Species;
use bevy_windfall::{Season, WindfallForest};
use common::{dull, eyes, grow, light};

/// Which half of the window a camera has.
#[derive(Component)]
struct Half(u32);

pub(crate) fn build(app: &mut App) {
    app.add_systems(Startup, setup)
        .add_systems(PostStartup, light_both)
        .add_systems(PreUpdate, halve);
}

fn setup(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let models = [Species::Beech, Species::Aspen].map(|species| grow(&assets, species, 2, 2500));
    for (half, season) in [(0, 0.1), (1, 0.75)] {
        let layer = RenderLayers::layer(half as usize + 1);
        let forest = WindfallForest::scattered(models.to_vec(), 24, 6.0);
        commands.spawn((forest, Season(season), layer.clone()));
        let eye = Transform::from_xyz(half as f32 * 8.0, 2.2, 30.0);
        let camera = eye.looking_at(Vec3::new(0.0, 6.0, 0.0), Vec3::Y);
        // The second keeps what the first has drawn.
        let clear_color =
            if half == 0 { ClearColorConfig::Default } else { ClearColorConfig::None };
        let order = half as isize;
        commands.spawn((
            eyes(),
            camera,
            layer,
            Half(half),
            Camera { order, clear_color, ..default() },
        ));
    }
    let floor = Plane3d::default().mesh().size(300.0, 300.0).build();
    let floor = dull((&mut meshes, &mut materials), floor, Color::srgb(0.4, 0.31, 0.2));
    commands.spawn((floor, RenderLayers::from_layers(&[1, 2])));
    light(&mut commands);
}

/// The sun shines in all layers.
fn light_both(mut commands: Commands, suns: Query<Entity, With<DirectionalLight>>) {
    for sun in &suns {
        commands.entity(sun).insert(RenderLayers::from_layers(&[1, 2]));
    }
}

fn halve(mut cameras: Query<(&mut Camera, &Half)>) {
    for (mut camera, half) in &mut cameras {
        let Some(size) = camera.physical_target_size() else { continue };
        let physical_size = UVec2::new(size.x / 2, size.y);
        let physical_position = UVec2::new(half.0 * physical_size.x, 0);
        if camera.viewport.as_ref().is_none_or(|of| of.physical_size != physical_size) {
            camera.viewport = Some(Viewport { physical_position, physical_size, ..default() });
        }
    }
}

#[allow(dead_code, reason = "the test of the picture has a main of its own")]
fn main() {
    headless::main(build, 30.0);
}
