//! Scene files of Windfall as assets.

use crate::assets::{FallPaths, LoadError, TreeModel, read, read_tree};
use crate::forest::{
    LeafBudget, PlantedTrees, Season, Thrown, ThrownLeaves, TreeKey, Trees, WindfallForest,
    WindfallWind,
};
use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext};
use bevy::math::{EulerRot, Quat, Vec3};
use bevy::prelude::*;
use bevy::tasks::AsyncComputeTaskPool;
use std::sync::Arc;
use windfall::flight::read_paths;
use windfall::tree::Tree;
use windfall::{InputError, InputErrorKind};
use windfall_scenes::{Model, Scene};

/// A scene file ([the format](https://docs.rs/windfall-scenes)), with its trees grown or read and placed.
///
/// ```no_run
/// # use bevy::prelude::*;
/// # use bevy_windfall::WindfallScene;
/// # fn spawn(mut commands: Commands, scenes: Res<Assets<WindfallScene>>, handle: Handle<WindfallScene>) {
/// if let Some(scene) = scenes.get(&handle) {
///     commands.spawn(scene.forest());
///     commands.spawn((Camera3d::default(), scene.camera(0.0)));
///     commands.spawn((DirectionalLight::default(), scene.sun()));
/// }
/// # }
/// ```
#[derive(Asset, TypePath, Debug, Clone)]
pub struct WindfallScene {
    /// The file, as it was read.
    pub scene: Scene,
    #[dependency]
    models: Vec<Handle<TreeModel>>,
    #[dependency]
    paths: Option<Handle<FallPaths>>,
    forest: WindfallForest,
    others: (Season, WindfallWind, LeafBudget, ThrownLeaves),
}

impl WindfallScene {
    /// The scene's forest, with its season, wind, budget and events, to spawn.
    pub fn forest(&self) -> impl Bundle + use<> {
        let (season, wind, budget, thrown) = self.others.clone();
        (self.forest.clone(), season, wind, budget, thrown, PlantedTrees::default())
    }

    /// The scene's camera at a time, seconds, about the forest's place.
    pub fn camera(&self, time: f64) -> Transform {
        let camera = self.scene.view(time, &self.forest.terrain).camera;
        Transform::from_translation(camera.eye.as_vec3()).with_rotation(camera.rotation)
    }

    /// The scene's sun, for a [`DirectionalLight`].
    pub fn sun(&self) -> Transform {
        let (azimuth, elevation) = (self.scene.sky.azimuth, self.scene.sky.elevation);
        let (yaw, pitch) = (azimuth.to_radians(), elevation.to_radians());
        // A light shines along its -Z: at no azimuth it comes from +Z.
        Transform::from_rotation(Quat::from_euler(EulerRot::YXZ, yaw, -pitch, 0.0))
            .with_translation(Vec3::Y)
    }
}

/// Loads [`WindfallScene`]s (`.windfall.ron`). Paths of a scene have to be path sets.
#[derive(Debug, Default, TypePath)]
pub struct SceneLoader;

impl AssetLoader for SceneLoader {
    type Asset = WindfallScene;
    type Settings = ();
    type Error = LoadError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _settings: &(),
        context: &mut LoadContext<'_>,
    ) -> Result<WindfallScene, LoadError> {
        let file = context.path().to_string();
        let bytes = read(reader, &file).await?;
        let text = String::from_utf8(bytes).map_err(|_| {
            InputError::new(&file, "", InputErrorKind::Malformed, "is not text in UTF-8")
        })?;
        let scene = Scene::from_ron(&text, &file)?;
        let mut trees: Vec<Tree> = Vec::new();
        for model in scene.models() {
            trees.push(match model {
                Model::Species { species, seed, options } => {
                    let grow = async move { species.grow_as(seed, &options) };
                    AsyncComputeTaskPool::get().spawn(grow).await
                }
                Model::File { file: name, options } => {
                    let bytes = beside(context, name).await?;
                    let read = read_tree(bytes, name.to_owned(), options, context).await?;
                    Arc::unwrap_or_clone(read.tree)
                }
            });
        }
        let mut lists = Vec::new();
        for entry in &scene.paths {
            let bytes = beside(context, &entry.file).await?;
            let set = read_paths(&entry.file, &bytes)?;
            lists.push((entry.trees.clone(), set.paths().to_vec()));
        }
        let mut stage = scene.place(trees);
        stage.check(&file)?;
        let mut paths = None;
        if !lists.is_empty() {
            stage.fall_by(lists)?;
            let set = FallPaths(stage.falls.paths.clone());
            paths = Some(context.add_labeled_asset("Paths".to_owned(), set));
        }
        let mut models = Vec::new();
        for (i, tree) in stage.trees.into_iter().enumerate() {
            models.push(context.add_labeled_asset(format!("Model{i}"), TreeModel::from(tree)));
        }
        let thrown = stage.events.iter().map(|event| Thrown {
            tree: TreeKey::Instance(event.tree),
            leaf: event.leaf,
            time: event.time,
        });
        let falls = stage.falls;
        Ok(WindfallScene {
            others: (
                Season(stage.season),
                WindfallWind(falls.wind),
                LeafBudget(falls.capacity),
                ThrownLeaves { leaves: thrown.collect() },
            ),
            forest: WindfallForest {
                models: models.clone(),
                trees: Trees::At(stage.forest.instances),
                terrain: Arc::new(stage.forest.terrain),
                shedding: falls.shedding,
                paths: paths.clone(),
                variation: falls.variation,
                settings: falls.settings,
            },
            models,
            paths,
            scene,
        })
    }

    fn extensions(&self) -> &[&str] {
        &["windfall.ron"]
    }
}

/// The bytes of a file that a scene names.
async fn beside(context: &mut LoadContext<'_>, name: &str) -> Result<Vec<u8>, LoadError> {
    let failed = |cause: String| LoadError::Read { file: name.to_owned(), cause };
    let path = context.path().resolve_embed_str(name).map_err(|e| failed(e.to_string()))?;
    context.read_asset_bytes(path).await.map_err(|e| failed(e.to_string()))
}
