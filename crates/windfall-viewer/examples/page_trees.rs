//! Bakes the species of named scenes, or of all, for the viewer's page: `page_trees FOLDER [SCENE]...`. scripts/web runs it.
//!
//! The folder gets a file for each tree and `index.json`, a list of their names.

use anyhow::Context;
use std::ops::ControlFlow;
use std::path::PathBuf;
use windfall_host::tree::TreeSource;
use windfall_scenes::Model;
use windfall_tree::bake::{Viewers, bake};

fn main() -> anyhow::Result<()> {
    let mut words = std::env::args().skip(1);
    let folder = PathBuf::from(words.next().context("page_trees FOLDER [SCENE]...")?);
    std::fs::create_dir_all(&folder)?;
    let mut names = std::collections::BTreeSet::new();
    let mut scenes: Vec<String> = words.collect();
    if scenes.is_empty() {
        scenes = windfall_scenes::NAMES.map(str::to_owned).to_vec();
    }
    for name in scenes {
        let scene = windfall_scenes::named(&name).with_context(|| format!("no scene: {name}"))?;
        for model in scene.models() {
            let Model::Species { species, seed, options } = model else { continue };
            let name = windfall_viewer::load::baked_name(species, seed, &options);
            let source = TreeSource::Species { species, seed, options };
            let prepared = source.prepare(&mut |_| ControlFlow::Continue(()))?;
            let (import, about) = prepared.context("stopped")?;
            let bytes = bake(&import.tree, &about, Viewers::Wood)?;
            std::fs::write(folder.join(format!("{name}.glb")), bytes)?;
            names.insert(name);
        }
    }
    std::fs::write(folder.join("index.json"), serde_json::to_vec(&names)?)?;
    Ok(())
}
