//! Trees that commands draw or write: from the cache, or prepared now, with a progress bar.

use anyhow::Context;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use windfall_host::cache::TreeCache;
use windfall_host::tree::{TreeSource, load_all};
use windfall_scenes::{Model, Scene};
use windfall_tree::Import;
use windfall_tree::prepare::Stage;

/// Whether prepared trees are kept for the next time.
#[derive(clap::Args)]
pub struct CacheArgs {
    /// Prepare trees anew, and keep none for the next time
    #[arg(long)]
    no_cache: bool,
}

impl CacheArgs {
    /// The cache, if it is wanted and the user has one.
    pub fn cache(&self) -> Option<TreeCache> {
        if self.no_cache { None } else { TreeCache::of_user() }
    }
}

/// What the models of a scene are made of; its files are in `folder`.
pub fn sources(scene: &Scene, folder: &Path) -> Vec<TreeSource> {
    let source = |model| match model {
        Model::Species { species, seed, options } => TreeSource::Species { species, seed, options },
        Model::File { file, options } => TreeSource::File { path: folder.join(file), options },
    };
    scene.models().into_iter().map(source).collect()
}

/// Loads trees at the same time.
pub fn load(sources: &[TreeSource], cache: Option<&TreeCache>) -> anyhow::Result<Vec<Import>> {
    let progress = Progress::new(sources.len());
    let loaded = load_all(sources, cache, &|tree, stage| progress.begin(tree, stage))?;
    loaded.context("stopped")
}

/// A bar over the stages of some trees, on a terminal.
pub struct Progress {
    bar: ProgressBar,
    /// Stages that each tree is past.
    past: Vec<AtomicUsize>,
}

impl Progress {
    /// Of this many trees. It is drawn once something takes time.
    pub fn new(trees: usize) -> Self {
        let past = (0..trees).map(|_| AtomicUsize::new(0)).collect();
        if !std::io::stderr().is_terminal() {
            return Self { bar: ProgressBar::hidden(), past };
        }
        let bar = ProgressBar::new((trees * Stage::ALL.len()) as u64);
        let style = ProgressStyle::with_template("{bar:32} preparing trees: {msg}");
        if let Ok(style) = style {
            bar.set_style(style);
        }
        Self { bar, past }
    }

    /// A stage of a tree begins.
    pub fn begin(&self, tree: usize, stage: Stage) -> ControlFlow<()> {
        if stage > Stage::Parse {
            // Some stages come again; the bar does not go back.
            let number = Stage::ALL.iter().position(|&s| s == stage).unwrap_or_default();
            self.past[tree].fetch_max(number, Ordering::Relaxed);
            let past: usize = self.past.iter().map(|p| p.load(Ordering::Relaxed)).sum();
            self.bar.set_message(stage.name());
            self.bar.set_position(past as u64);
        }
        ControlFlow::Continue(())
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
