//! Options of `windfall render` that say how leaves fall: their paths, and what sets falls on one path apart.

use crate::path;
use crate::reading::UpArg;
use anyhow::{Context, bail};
use std::path::Path;
use windfall_core::Note;
use windfall_flight::{ImportOptions, Up};
use windfall_scenes::{PathEntry, Scene, Stage, TimeUnit, VariationEntry};

/// How leaves fall.
#[derive(clap::Args)]
pub struct FallArgs {
    /// Let leaves fall by this file: a glTF animation, a CSV or JSON table, a path set. TREE=FILE is for one species or
    /// tree file. May be given again
    #[arg(long = "path", value_name = "[TREE=]FILE")]
    paths: Vec<String>,
    /// Animation ("take") of the --path files
    #[arg(long, value_name = "NAME", requires = "paths")]
    animation: Option<String>,
    /// Animated node of the --path files
    #[arg(long, value_name = "NAME", requires = "paths")]
    path_node: Option<String>,
    /// Axis that points up in the --path files: y or z
    #[arg(long, value_name = "AXIS", value_enum, default_value_t = UpArg::Y, hide_possible_values = true, requires = "paths")]
    path_up: UpArg,
    /// Metres for each unit of the --path files
    #[arg(long, value_name = "M", default_value_t = 1.0, requires = "paths")]
    path_scale: f32,
    /// Frames per second of --path tables with frame numbers
    #[arg(long, value_name = "N", requires = "paths")]
    path_fps: Option<f32>,
    /// What times in --path tables are in: s or ms
    #[arg(long, value_name = "UNIT", default_value = "s", requires = "paths")]
    time_unit: TimeUnit,
    /// How falls on one path differ: hashed, paper-2008 or paper-2007
    #[arg(long, value_name = "NAME", value_parser = variation)]
    variation: Option<VariationEntry>,
    /// Drop over which a leaf eases from its twig's orientation into its path's, metres
    #[arg(long, value_name = "M")]
    soft_drop: Option<f32>,
    /// Time over which a fall starts from rest, seconds
    #[arg(long, value_name = "S")]
    soft_time: Option<f32>,
    /// Time before landing over which a leaf eases to lie on the ground, seconds
    #[arg(long, value_name = "S")]
    settle_time: Option<f32>,
    /// Most by which a leaf turns while it settles, degrees
    #[arg(long, value_name = "DEG")]
    settle_turn: Option<f32>,
    /// Time constant with which a leaf takes on the wind's speed, seconds
    #[arg(long, value_name = "S")]
    wind_response: Option<f32>,
}

fn variation(text: &str) -> Result<VariationEntry, String> {
    match text {
        "hashed" => Ok(VariationEntry::default()),
        "paper-2008" => Ok(VariationEntry::Paper(2008)),
        "paper-2007" => Ok(VariationEntry::Paper(2007)),
        _ => Err("there are: hashed, paper-2008, paper-2007".to_owned()),
    }
}

impl FallArgs {
    /// Puts what the command line says in place of what the scene says.
    pub fn apply(&self, scene: &mut Scene) -> anyhow::Result<()> {
        if !self.paths.is_empty() {
            scene.paths =
                self.paths.iter().map(|text| self.entry(text)).collect::<Result<_, _>>()?;
        }
        scene.variation = self.variation.unwrap_or(scene.variation);
        let fall = &mut scene.fall;
        fall.soft_drop = self.soft_drop.unwrap_or(fall.soft_drop);
        fall.soft_time = self.soft_time.unwrap_or(fall.soft_time);
        fall.settle_time = self.settle_time.unwrap_or(fall.settle_time);
        fall.settle_turn = self.settle_turn.unwrap_or(fall.settle_turn);
        fall.wind_response = self.wind_response.unwrap_or(fall.wind_response);
        Ok(())
    }

    fn entry(&self, text: &str) -> anyhow::Result<PathEntry> {
        let (tree, file) = match text.split_once('=') {
            Some((tree, file)) if !Path::new(text).exists() => (Some(tree), file),
            _ => (None, text),
        };
        if file.is_empty() || tree == Some("") {
            bail!("--path {text}: is neither FILE nor TREE=FILE");
        }
        // Relative to where the user stands, whatever folder the scene is in.
        let path = std::path::absolute(file).with_context(|| format!("--path {text}"))?;
        let path = path.to_str().with_context(|| format!("--path {text}: not UTF-8"))?;
        Ok(PathEntry {
            trees: tree.map(str::to_owned).into_iter().collect(),
            node: self.path_node.clone(),
            animation: self.animation.clone(),
            up: self.path_up.into(),
            scale: self.path_scale,
            fps: self.path_fps,
            time_unit: self.time_unit,
            ..PathEntry::new(path)
        })
    }
}

/// Reads the paths of a scene, relative to `folder`, and lets the leaves of its stage fall by them.
pub fn read_paths(scene: &Scene, folder: &Path, stage: &mut Stage) -> anyhow::Result<Vec<Note>> {
    let mut notes = Vec::new();
    let mut lists = Vec::new();
    for entry in &scene.paths {
        let options = ImportOptions {
            node: entry.node.clone(),
            animation: entry.animation.clone(),
            up: match entry.up {
                windfall_tree::Up::Y => Up::Y,
                windfall_tree::Up::Z => Up::Z,
            },
            scale: entry.scale,
            time_unit: path::time_unit(entry.time_unit),
            fps: entry.fps,
            rate: entry.rate,
            ..ImportOptions::default()
        };
        let (set, of_file) = path::load(&folder.join(&entry.file), &options)?;
        notes.extend(of_file);
        lists.push((entry.trees.clone(), set.paths().to_vec()));
    }
    if !lists.is_empty() {
        stage.fall_by(lists)?;
    }
    Ok(notes)
}
