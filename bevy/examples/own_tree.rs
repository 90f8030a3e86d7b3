//! A tree from a file: `birch.baked.glb` of the assets folder, or another one, baked or not.
//!
//!     cargo run --release --example own_tree
//!     OWN_TREE=my_oak.glb cargo run --release --example own_tree

mod common;
mod headless;

use bevy::prelude::*;
use bevy_windfall::{Season, TreeModel, WindfallForest, WindfallTree};
use common::{dull, eyes, light};

pub(crate) fn build(app: &mut App) {
    app.add_systems(Startup, setup).add_systems(Update, tell);
}

#[derive(Resource)]
struct Own(Handle<TreeModel>);

fn setup(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let file = std::env::var("OWN_TREE").unwrap_or_else(|_| "birch.baked.glb".to_owned());
    let model: Handle<TreeModel> = assets.load(file);
    // A forest by hand: each tree is an entity, stands where its transform says, and can move.
    commands.spawn((WindfallForest::default(), Season(0.6))).with_children(|forest| {
        for (i, x) in (0..).zip([-9.0, -3.5, 2.0, 8.0]) {
            let tree = WindfallTree::new(model.clone(), i + 1);
            let place = Transform::from_xyz(x, 0.0, -2.0 * (i % 2) as f32)
                .with_rotation(Quat::from_rotation_y(i as f32 * 1.7))
                .with_scale(Vec3::splat(1.0 - 0.12 * i as f32));
            forest.spawn((tree, place));
        }
    });
    commands.insert_resource(Own(model));
    let floor = Plane3d::default().mesh().size(200.0, 200.0).build();
    commands.spawn(dull((&mut meshes, &mut materials), floor, Color::srgb(0.33, 0.37, 0.2)));
    let camera = Transform::from_xyz(0.0, 3.0, 22.0).looking_at(Vec3::new(0.0, 6.0, 0.0), Vec3::Y);
    commands.spawn((eyes(), camera));
    light(&mut commands);
}

/// Says once what was read, or what is wrong with the file.
fn tell(
    own: Res<Own>,
    assets: Res<AssetServer>,
    models: Res<Assets<TreeModel>>,
    mut told: Local<bool>,
) {
    if *told {
        return;
    }
    if let Some(model) = models.get(&own.0) {
        *told = true;
        let leaves = model.tree.foliage.leaves.len();
        println!("{}: {leaves} leaves, {:.1} m high", model.tree.name, model.tree.height());
        model.notes.iter().for_each(|note| println!("{note}"));
    } else if let bevy::asset::LoadState::Failed(cause) = assets.load_state(&own.0) {
        *told = true;
        eprintln!("{cause}");
    }
}

#[allow(dead_code, reason = "the test of the picture has a main of its own")]
fn main() {
    headless::main(build, 20.0);
}
