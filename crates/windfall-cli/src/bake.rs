//! `windfall bake`: a tree that loads without being prepared again.

use crate::loading::Progress;
use crate::reading::{ReadArgs, print_notes};
use crate::simplify::same_file;
use anyhow::{Context, bail};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;
use windfall_core::Note;
use windfall_core::simplify::PruneOrder;
use windfall_host::file::write_atomic;
use windfall_host::tree::TreeSource;
use windfall_tree::bake::{About, Viewers};
use windfall_tree::prepare::Stage;
use windfall_tree::{BakedTree, Import, ImportOptions, bake};

/// Arguments of `windfall bake`.
#[derive(clap::Args)]
pub struct Args {
    /// A .glb or .gltf file, or the name of a species
    #[arg(value_name = "FILE|SPECIES")]
    tree: String,
    #[command(flatten)]
    read: Box<ReadArgs>,
    /// What is wood: as for --leaves
    #[arg(long, value_name = "NAME|N")]
    wood: Vec<String>,
    /// Prune order of the leaves: random, importance or blue-noise. A scene with another one reorders them as it loads
    #[arg(long, value_name = "NAME", default_value_t)]
    prune_order: PruneOrder,
    /// Key of everything random, of a species
    #[arg(long, default_value_t = 0)]
    seed: u32,
    /// Bake again and compare with the file that is there, which stays as it is; without one, it is written first
    #[arg(long)]
    verify: bool,
    /// Print one JSON object of what was baked
    #[arg(long)]
    json: bool,
    /// File to write
    #[arg(long, value_name = "FILE.glb")]
    out: PathBuf,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Report {
    name: String,
    leaves: usize,
    leaf_triangles: usize,
    wood_triangles: usize,
    /// Triangles of each level of the wood.
    wood_levels: Vec<usize>,
    prune_order: PruneOrder,
    /// Hash of the source and of the options.
    source: String,
    bytes: usize,
    /// Whether the file at `--out` is what the source gives; `null` without `--verify`.
    verified: Option<bool>,
    seconds: f64,
    /// Seconds of each stage, and of writing.
    stages: BTreeMap<&'static str, f64>,
    notes: Vec<Note>,
}

/// A tree that was baked.
struct Baked {
    import: Import,
    about: About,
    bytes: Vec<u8>,
    seconds: f64,
    stages: BTreeMap<&'static str, f64>,
}

/// Runs `windfall bake`.
pub fn run(args: &Args) -> anyhow::Result<()> {
    if same_file(Path::new(&args.tree), &args.out) {
        bail!("--out {}: is the file that is read", args.out.display());
    }
    if args.out.is_dir() {
        bail!("--out {}: is a folder", args.out.display());
    }
    if !args.out.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb")) {
        bail!("--out {}: is not a .glb file", args.out.display());
    }
    let random = args.prune_order == PruneOrder::Random;
    let options = ImportOptions {
        prune_order: (!random).then_some((args.prune_order, ImportOptions::PRUNE_SEED)),
        ..args.read.options(&args.wood)
    };
    let source = TreeSource::named(&args.tree, args.seed, options)?;
    let mut baked = bake_once(&source)?;
    print_notes(&baked.import.notes);
    let there = args.out.exists();
    if !(args.verify && there) {
        write_atomic(&args.out, |file| Ok(file.write_all(&baked.bytes)?))?;
    }
    if args.verify {
        if !there {
            baked = bake_once(&source)?;
        }
        compare(&args.out, &baked)?;
    }
    let tree = &baked.import.tree;
    let levels: Vec<usize> = tree.wood.levels.iter().map(|level| level.indices.len() / 3).collect();
    let report = Report {
        name: tree.name.clone(),
        leaves: tree.foliage.leaves.len(),
        leaf_triangles: tree.foliage.triangle_count(),
        wood_triangles: tree.wood_triangles(),
        wood_levels: levels,
        prune_order: args.prune_order,
        source: baked.about.source.to_string(),
        bytes: baked.bytes.len(),
        verified: args.verify.then_some(true),
        seconds: baked.seconds,
        stages: baked.stages,
        notes: baked.about.notes,
    };
    eprintln!(
        "{}{}: {} leaves, {} triangles of wood in {} levels, {} bytes, {:.1} s",
        args.out.display(),
        if args.verify { " is what the source gives" } else { "" },
        report.leaves,
        report.wood_triangles,
        report.wood_levels.len(),
        report.bytes,
        report.seconds
    );
    if args.json {
        writeln!(std::io::stdout(), "{}", serde_json::to_string_pretty(&report)?)?;
    }
    Ok(())
}

fn bake_once(source: &TreeSource) -> anyhow::Result<Baked> {
    let progress = Progress::new(1);
    let start = Instant::now();
    let mut stages = BTreeMap::new();
    let mut running: Option<(&'static str, Instant)> = None;
    let mut switch = |to: Option<&'static str>| {
        let now = Instant::now();
        let before = std::mem::replace(&mut running, to.map(|name| (name, now)));
        if let Some((name, since)) = before {
            *stages.entry(name).or_insert(0.0) += (now - since).as_secs_f64();
        }
    };
    let prepared = source.prepare(&mut |stage: Stage| {
        switch(Some(stage.name()));
        progress.begin(0, stage)
    })?;
    let (mut import, about) = prepared.context("stopped")?;
    switch(Some("write"));
    // The bytes depend on the file, and not on where it lies.
    if let TreeSource::File { path, .. } = source
        && let Some(name) = path.file_name()
    {
        import.tree.name = name.to_string_lossy().into_owned();
    }
    let bytes = bake(&import.tree, &about, Viewers::Everything)?;
    switch(None);
    let seconds = start.elapsed().as_secs_f64();
    Ok(Baked { import, about, bytes, seconds, stages })
}

/// Compares a tree that was baked now with the file that is there.
fn compare(path: &Path, baked: &Baked) -> anyhow::Result<()> {
    let shown = path.display();
    let there = std::fs::read(path).with_context(|| format!("{shown}: cannot be read"))?;
    if there == baked.bytes {
        return Ok(());
    }
    let read = BakedTree::read(&there, &shown.to_string())?;
    if read.about.source != baked.about.source {
        bail!("{shown}: was baked of another source, or with other options");
    }
    let same = there.iter().zip(&baked.bytes).take_while(|(a, b)| a == b).count();
    bail!(
        "{shown}: is of this source, but baked now it has {} bytes for {}, and the first that differs is \
         byte {same}: another version of the program has baked it",
        baked.bytes.len(),
        there.len()
    );
}
