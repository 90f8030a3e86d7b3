//! `windfall cache`: the trees that the program keeps prepared.

use anyhow::Context;
use serde::Serialize;
use std::io::Write;
use std::path::PathBuf;
use std::time::SystemTime;
use windfall_host::cache::TreeCache;

/// Arguments of `windfall cache`.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Option<Command>,
    /// Print one JSON object
    #[arg(long, global = true)]
    json: bool,
}

#[derive(clap::Subcommand)]
enum Command {
    /// Remove all trees of the cache
    Clear,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Report {
    folder: PathBuf,
    most_bytes: u64,
    bytes: u64,
    /// The most recently used first.
    trees: Vec<Entry>,
    #[serde(skip_serializing_if = "Option::is_none")]
    removed: Option<Removed>,
}

#[derive(Serialize)]
struct Entry {
    file: PathBuf,
    bytes: u64,
    /// Seconds since it was last used.
    unused_for: u64,
}

#[derive(Serialize)]
struct Removed {
    trees: usize,
    bytes: u64,
}

/// Runs `windfall cache`.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let cache = TreeCache::of_user()
        .context("this user has no cache folder; WINDFALL_CACHE_DIR names one")?;
    let shown = || cache.folder().display().to_string();
    let removed = match args.command {
        Some(Command::Clear) => {
            let (trees, bytes) = cache.clear().with_context(shown)?;
            Some(Removed { trees, bytes })
        }
        None => None,
    };
    let now = SystemTime::now();
    let trees = cache.trees().with_context(shown)?.into_iter().map(|tree| Entry {
        file: tree.path,
        bytes: tree.bytes,
        unused_for: now.duration_since(tree.used).map_or(0, |age| age.as_secs()),
    });
    let trees: Vec<Entry> = trees.collect();
    let report = Report {
        folder: cache.folder().to_owned(),
        most_bytes: cache.most_bytes(),
        bytes: trees.iter().map(|tree| tree.bytes).sum(),
        trees,
        removed,
    };
    let mut out = std::io::stdout().lock();
    if args.json {
        writeln!(out, "{}", serde_json::to_string_pretty(&report)?)?;
        return Ok(());
    }
    if let Some(removed) = report.removed {
        writeln!(out, "removed {} trees, {}", removed.trees, size(removed.bytes))?;
        return Ok(());
    }
    writeln!(out, "folder  {}", report.folder.display())?;
    writeln!(out, "size    {} of at most {}", size(report.bytes), size(report.most_bytes))?;
    writeln!(out, "trees   {}", report.trees.len())?;
    for tree in &report.trees {
        let name = tree.file.file_name().unwrap_or_default().to_string_lossy();
        writeln!(out, "  {name}  {:>9}  used {} ago", size(tree.bytes), age(tree.unused_for))?;
    }
    Ok(())
}

/// Bytes for people.
fn size(bytes: u64) -> String {
    if bytes < 1_000_000 {
        format!("{:.1} kB", bytes as f64 / 1e3)
    } else {
        format!("{:.1} MB", bytes as f64 / 1e6)
    }
}

/// Seconds for people.
fn age(seconds: u64) -> String {
    match seconds {
        0..120 => format!("{seconds} s"),
        120..7200 => format!("{} min", seconds / 60),
        7200..172_800 => format!("{} h", seconds / 3600),
        _ => format!("{} days", seconds / 86_400),
    }
}
