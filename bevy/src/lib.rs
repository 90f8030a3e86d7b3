#![doc = include_str!("../README.md")]
#![deny(missing_docs)]

mod assets;
mod camera;
mod forest;
mod ground;
mod near;
mod render;
mod scene;
mod status;

pub use assets::{FallPaths, LoadError, PathLoader, TreeLoader, TreeModel, TreeSettings};
pub use camera::{LeafDetail, WindfallAmbient};
pub use forest::{
    LeafBudget, PlantedTrees, Season, ShakeTree, ThrowLeaf, ThrownLeaves, Trees, WindfallForest,
    WindfallTime, WindfallTree, WindfallWind,
};
pub use ground::ground_mesh;
pub use near::{LeavesNear, NearLeaf};
pub use scene::{SceneLoader, WindfallScene};
pub use status::WindfallStatus;
/// The library of Windfall, without Bevy.
pub use windfall;
/// Scene files.
pub use windfall_scenes;

use bevy::app::{App, First, Plugin, PostUpdate};
use bevy::asset::AssetApp;
use bevy::prelude::{IntoScheduleConfigs, TransformSystems};
use bevy::time::TimeSystems;

/// Draws forests with every 3D camera. Add it after Bevy's `DefaultPlugins`.
#[derive(Debug, Default, Clone, Copy)]
pub struct WindfallPlugin;

impl Plugin for WindfallPlugin {
    fn build(&self, app: &mut App) {
        app.init_asset::<TreeModel>()
            .init_asset::<FallPaths>()
            .init_asset_loader::<TreeLoader>()
            .init_asset::<WindfallScene>()
            .init_asset_loader::<PathLoader>()
            .init_asset_loader::<SceneLoader>()
            .init_resource::<WindfallTime>()
            .init_resource::<WindfallStatus>()
            .add_message::<ThrowLeaf>()
            .add_message::<ShakeTree>()
            .add_systems(First, forest::advance_clock.after(TimeSystems))
            .add_systems(
                PostUpdate,
                (
                    (forest::shelter_lone_trees, forest::plant).chain(),
                    forest::throw.after(forest::plant).after(TransformSystems::Propagate),
                ),
            );
        render::build(app);
    }
}
