//! Files as assets, on a machine that draws nothing.

use bevy::asset::{AssetPlugin, LoadState};
use bevy::prelude::*;
use bevy_windfall::windfall::path::PathSet;
use bevy_windfall::windfall::tree::bake::{About, SourceHash, Viewers};
use bevy_windfall::windfall::tree::{GrowOptions, Species, bake, export_glb};
use bevy_windfall::{
    FallPaths, TreeModel, TreeSettings, WindfallForest, WindfallPlugin, WindfallScene,
};
use std::path::Path;

fn app(folder: &Path) -> App {
    let mut app = App::new();
    let file_path = folder.display().to_string();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin { file_path, ..default() },
        TransformPlugin,
        WindfallPlugin,
    ));
    app.finish();
    app.cleanup();
    app
}

/// Waits for an asset; what is wrong with it otherwise.
fn load<A: Asset + Clone>(app: &mut App, handle: &Handle<A>) -> Result<A, String> {
    for _ in 0..100_000 {
        app.update();
        let assets = app.world().resource::<AssetServer>();
        match assets.load_state(handle) {
            LoadState::Loaded => {
                return Ok(app
                    .world()
                    .resource::<Assets<A>>()
                    .get(handle)
                    .expect("it is loaded")
                    .clone());
            }
            LoadState::Failed(cause) => return Err(cause.to_string()),
            _ => std::thread::sleep(std::time::Duration::from_millis(1)),
        }
    }
    Err("it takes too long".to_owned())
}

#[test]
fn trees_paths_and_scenes_are_assets() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    let tree = Species::Birch.grow_with(2, 200);
    let source = SourceHash::of_species(Species::Birch, 2, &GrowOptions::default());
    let about = About { source, prune_order: None, notes: Vec::new() };
    let baked = bake(&tree, &about, Viewers::Everything).unwrap();
    put("birch.baked.glb", &baked);
    put("birch.glb", &export_glb(&tree).unwrap());
    put("half.glb", &baked[..baked.len() / 2]);
    put("own.paths", &PathSet::builtin().to_bytes());
    put("broken.paths", b"no paths");
    let scene = r#"(version: 1, trees: [(source: File("birch.baked.glb"))], count: 7, seed: 3,
        season: 0.7, paths: [(file: "own.paths")], events: [(tree: 2, leaf: 5, time: 4)],
        camera: [(eye: (0, 2, 20), target: (0, 4, 0))])"#;
    put("wood.windfall.ron", scene.as_bytes());
    put("bad.windfall.ron", scene.replace("leaf: 5", "leaf: 500").as_bytes());

    let mut app = app(folder.path());
    let assets = app.world().resource::<AssetServer>().clone();
    let loaded = load(&mut app, &assets.load::<TreeModel>("birch.baked.glb")).unwrap();
    assert_eq!(loaded.tree.foliage.leaves, tree.foliage.leaves, "what was baked");
    let scaled =
        assets.load_builder().with_settings(|tree: &mut TreeSettings| tree.height = Some(3.0));
    let plain = load(&mut app, &scaled.load::<TreeModel>("birch.glb")).unwrap();
    assert_eq!(plain.tree.foliage.leaves.len(), 200);
    assert!((plain.tree.height() - 3.0).abs() < 1e-3);
    let cause = load(&mut app, &assets.load::<TreeModel>("half.glb")).unwrap_err();
    assert!(cause.contains("half.glb"), "{cause}");
    let cause = load(&mut app, &assets.load::<TreeModel>("none.glb")).unwrap_err();
    assert!(cause.contains("none.glb"), "{cause}");

    let paths = load(&mut app, &assets.load::<FallPaths>("own.paths")).unwrap();
    assert_eq!(paths.0.paths().len(), PathSet::builtin().paths().len());
    let cause = load(&mut app, &assets.load::<FallPaths>("broken.paths")).unwrap_err();
    assert!(cause.contains("broken.paths"), "{cause}");

    let scene = load(&mut app, &assets.load::<WindfallScene>("wood.windfall.ron")).unwrap();
    let forest = app.world_mut().spawn(scene.forest()).id();
    app.update();
    let world = app.world();
    let planted = world.get::<bevy_windfall::PlantedTrees>(forest).unwrap();
    assert_eq!(planted.instances().len(), 7);
    assert_eq!(world.get::<bevy_windfall::Season>(forest).unwrap().0, 0.7);
    assert_eq!(world.get::<bevy_windfall::ThrownLeaves>(forest).unwrap().len(), 1);
    assert!(world.get::<WindfallForest>(forest).unwrap().paths.is_some());
    let eye = scene.camera(0.0);
    assert!((eye.translation.z - 20.0).abs() < 1e-3 && eye.forward().z < -0.9, "{eye:?}");
    let cause = load(&mut app, &assets.load::<WindfallScene>("bad.windfall.ron")).unwrap_err();
    assert!(cause.contains("bad.windfall.ron") && cause.contains("500"), "{cause}");
}

#[test]
fn a_forest_that_cannot_be_planted_has_no_trees_and_stops_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = app(folder.path());
    let bad = [
        WindfallForest::scattered(Vec::new(), 10, 5.0),
        WindfallForest::scattered(vec![Handle::default()], 10, f32::NAN),
        WindfallForest::scattered(vec![Handle::default()], u32::MAX, 5.0),
    ];
    for forest in bad {
        let forest = app.world_mut().spawn(forest).id();
        app.update();
        let planted = app.world().get::<bevy_windfall::PlantedTrees>(forest).unwrap();
        assert_eq!(planted.instances().len(), 0);
    }
}
