//! Options of the commands that plant a scene: its trees, and leaves that are thrown.

use crate::loading::CacheArgs;
use crate::reading::{ReadArgs, print_notes};
use anyhow::{Context, bail};
use windfall_core::Note;
use windfall_core::simplify::PruneOrder;
use windfall_core::tree::Tree;
use windfall_scenes::{Scene, Source, Stage, TreeEntry};
use windfall_tree::{Import, ImportOptions, Species, set_prune_order};

/// Trees in place of the scene's.
#[derive(clap::Args)]
pub struct PlantArgs {
    /// Plant this instead of the scene's trees: a .glb or .gltf file, or a species; may be given
    /// again
    #[arg(long = "tree", value_name = "FILE|SPECIES")]
    pub tree: Vec<String>,
    /// Number of trees
    #[arg(long, value_name = "N")]
    trees: Option<u32>,
    #[command(flatten)]
    read: ReadArgs,
    #[command(flatten)]
    pub cache: CacheArgs,
    /// What is wood in the --tree files: as for --leaves
    #[arg(long, value_name = "NAME|N", requires = "tree")]
    wood: Vec<String>,
    /// Species whose autumn colours the leaves of the --tree files take
    #[arg(long, value_name = "SPECIES", requires = "tree")]
    palette: Option<String>,
    /// Phase of autumn, 0 late summer to 1 bare
    #[arg(long, value_name = "PHASE")]
    season: Option<f32>,
    /// Key of everything random
    #[arg(long, value_name = "N")]
    seed: Option<u32>,
}

/// Leaves that fall beside those that the season sheds.
#[derive(clap::Args)]
pub struct ThrowArgs {
    /// Let this many leaves fall each second, from time 0 on
    #[arg(long, value_name = "N")]
    throw_rate: Option<f32>,
    /// Keep about this many leaves in the air
    #[arg(long, value_name = "N", conflicts_with = "throw_rate")]
    falling: Option<u32>,
}

impl PlantArgs {
    /// Puts what the command line says in place of what the scene says.
    pub fn apply(&self, scene: &mut Scene) -> anyhow::Result<()> {
        if !self.tree.is_empty() {
            scene.trees =
                self.tree.iter().map(|name| self.entry(name)).collect::<Result<_, _>>()?;
            scene.spacing = None;
        }
        scene.count = self.trees.unwrap_or(scene.count);
        scene.season = self.season.unwrap_or(scene.season);
        scene.seed = self.seed.unwrap_or(scene.seed);
        Ok(())
    }

    /// What `--tree` names: a species, or a file.
    fn entry(&self, name: &str) -> anyhow::Result<TreeEntry> {
        let source = if name.parse::<Species>().is_ok() {
            Source::Species(name.to_owned())
        } else {
            // Relative to where the user stands, whatever folder the scene is in.
            let path = std::path::absolute(name).with_context(|| format!("--tree {name}"))?;
            Source::File(path.to_str().with_context(|| format!("--tree {name}: not UTF-8"))?.into())
        };
        Ok(TreeEntry {
            height: self.read.height,
            node: self.read.node.clone(),
            leaves: self.read.leaves.clone(),
            wood: self.wood.clone(),
            up: self.read.up.into(),
            unit: self.read.unit,
            ground: self.read.ground,
            vertex_colors: self.read.vertex_colors,
            palette: self.palette.clone(),
            ..TreeEntry::new(source)
        })
    }
}

impl ThrowArgs {
    /// Throws leaves of a stage.
    pub fn apply(&self, stage: &mut Stage) -> anyhow::Result<()> {
        if let Some(rate) = self.throw_rate {
            if !(rate > 0.0 && rate.is_finite()) {
                bail!("--throw-rate {rate}: is not above 0");
            }
            stage.throw(rate, 0.0);
        }
        if let Some(count) = self.falling {
            stage.keep_falling(count);
        }
        Ok(())
    }
}

/// The trees of a scene as they were loaded, in its prune order. Their notes go to stderr and to `notes`.
pub fn trees(scene: &Scene, loaded: Vec<Import>, notes: &mut Vec<Note>) -> Vec<Tree> {
    let of_scene = |import: Import| {
        print_notes(&import.notes);
        notes.extend(import.notes);
        let mut tree = import.tree;
        // A baked tree comes in its own order, where none is asked for.
        let order = import.baked.and_then(|about| about.prune_order);
        if scene.prune_order == PruneOrder::Random
            && order.is_some_and(|(order, _)| order != PruneOrder::Random)
        {
            set_prune_order(&mut tree.foliage, scene.prune_order, ImportOptions::PRUNE_SEED);
        }
        tree
    };
    loaded.into_iter().map(of_scene).collect()
}
