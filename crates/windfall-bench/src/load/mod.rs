//! `windfall bench load`: how long trees and scenes take until they are drawn, and how much memory.
//!
//! Every measurement is a process of its own, so that memory and caches are those of a fresh start. First frames are
//! those of `windfall render` itself, with an empty and with a full cache of trees and of the driver's shaders.

mod child;
mod tree;

use crate::output::write_json;
use crate::statistics::Quartiles;
use anyhow::{Context, bail};
use child::{Found, Task};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;
use windfall_host::image::parse_size;
use windfall_scenes::NAMES;

/// Arguments of `windfall bench load`.
#[derive(clap::Args)]
pub struct Args {
    /// Tree files (.glb or .gltf), species and scenes; a generated tree and all named scenes by default
    #[arg(value_name = "FILE|SPECIES|SCENE")]
    names: Vec<String>,
    /// Processes of each measurement
    #[arg(long, value_name = "N", default_value_t = 5)]
    runs: u32,
    /// Size of first frames
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "1280x720")]
    size: (u32, u32),
    /// Also write the numbers to this file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the generated tree to this file, and measure nothing
    #[arg(long, value_name = "FILE.glb", exclusive = true)]
    generate: Option<PathBuf>,
    /// Be one of the processes
    #[arg(long, hide = true, requires = "out")]
    task: Option<Task>,
    /// The baked file of such a process
    #[arg(long, hide = true)]
    out: Option<PathBuf>,
}

#[derive(Serialize)]
struct Report {
    size: (u32, u32),
    runs: u32,
    rows: Vec<Row>,
    goals: Vec<Goal>,
}

/// What was measured of one file or scene.
#[derive(Serialize)]
struct Row {
    name: String,
    /// Bytes of the tree file, and of the baked one.
    bytes: Option<u64>,
    baked_bytes: Option<u64>,
    leaves: Option<usize>,
    wood_triangles: Option<usize>,
    ms: BTreeMap<String, Quartiles>,
    /// Most memory, bytes.
    peak: BTreeMap<String, Quartiles>,
}

#[derive(Serialize)]
struct Goal {
    name: String,
    limit: String,
    most: f64,
    measured: f64,
    met: bool,
}

/// Runs `windfall bench load`.
pub fn run(args: &Args) -> anyhow::Result<()> {
    if let Some(path) = &args.generate {
        return std::fs::write(path, tree::large()?).with_context(|| format!("{}", path.display()));
    }
    if let (Some(task), Some(out)) = (args.task, &args.out) {
        let file = args.names.first().context("--task: of which file?")?;
        return child::be(task, Path::new(file), out);
    }
    if args.runs == 0 {
        bail!("--runs is at least 1");
    }
    let folder = tempfile::tempdir().context("no folder for temporary files")?;
    let mut names = args.names.clone();
    if names.is_empty() {
        let path = folder.path().join("generated.glb");
        std::fs::write(&path, tree::large()?).with_context(|| format!("{}", path.display()))?;
        names.push(path.to_str().context("a path in UTF-8")?.to_owned());
        names.extend(NAMES.map(str::to_owned));
    }
    let mut report =
        Report { size: args.size, runs: args.runs, rows: Vec::new(), goals: Vec::new() };
    for name in &names {
        let path = Path::new(name);
        let is_tree = path.extension().is_some_and(|e| e == "glb" || e == "gltf");
        let shown = if is_tree {
            path.file_name().unwrap_or_default().to_string_lossy().into_owned()
        } else {
            name.clone()
        };
        let mut row = Row::new(shown);
        if is_tree {
            of_tree(args, path, folder.path(), &mut row)?;
        }
        let scene = if is_tree || name.parse::<windfall_tree::Species>().is_ok() {
            vec!["--tree", name, "--trees", "1"]
        } else {
            vec![name.as_str()]
        };
        first_frames(args, &scene, folder.path(), &mut row)?;
        row.print();
        report.goals.extend(row.goals(NAMES.contains(&name.as_str())));
        report.rows.push(row);
    }
    println!("goals");
    for goal in &report.goals {
        let met = if goal.met { "met" } else { "missed" };
        println!("  {:<24} {:<46} {:>10.2}  {met}", goal.name, goal.limit, goal.measured);
    }
    match &args.json {
        Some(path) => write_json(path, &report),
        None => Ok(()),
    }
}

/// Reads, bakes and loads a file.
fn of_tree(args: &Args, path: &Path, folder: &Path, row: &mut Row) -> anyhow::Result<()> {
    let baked = folder.join("baked.glb");
    let size = |path: &Path| std::fs::metadata(path).map(|m| m.len()).ok();
    row.bytes = size(path);
    for task in [Task::Gltf, Task::Bake, Task::Baked] {
        let mut runs = Vec::new();
        for _ in 0..args.runs {
            match child::run(task, path, &baked) {
                Ok(found) => runs.push(found),
                // It reads less than Windfall does: extensions, and pictures beside.
                Err(error) if task == Task::Gltf => {
                    println!("{}: the gltf crate refuses it: {error:#}", row.name);
                    break;
                }
                Err(error) => return Err(error),
            }
        }
        if task == Task::Bake
            && let Some(found) = runs.last()
        {
            (row.leaves, row.wood_triangles) = (Some(found.leaves), Some(found.wood_triangles));
        }
        row.add(task, &runs);
    }
    row.baked_bytes = size(&baked);
    Ok(())
}

/// Times `windfall render`, with empty and with full caches.
fn first_frames(args: &Args, scene: &[&str], folder: &Path, row: &mut Row) -> anyhow::Result<()> {
    let program = std::env::current_exe().context("the program does not know itself")?;
    let picture = folder.join("frame.png");
    let (trees, shaders) = (folder.join("trees"), folder.join("shaders"));
    let mut all: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    let mut peaks: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for _ in 0..args.runs {
        for cache in [&trees, &shaders] {
            if cache.exists() {
                std::fs::remove_dir_all(cache).with_context(|| format!("{}", cache.display()))?;
            }
            std::fs::create_dir_all(cache).with_context(|| format!("{}", cache.display()))?;
        }
        for kind in ["cold", "warm"] {
            let start = Instant::now();
            let output = Command::new(&program)
                .arg("render")
                .args(scene)
                .args(["--json", "--size", &format!("{}x{}", args.size.0, args.size.1), "--out"])
                .arg(&picture)
                .env("WINDFALL_CACHE_DIR", &trees)
                .env("MESA_SHADER_CACHE_DIR", &shaders)
                .env("XDG_CACHE_HOME", &shaders)
                .output()
                .context("the program cannot be started")?;
            let wall = start.elapsed().as_secs_f64() * 1e3;
            if !output.status.success() {
                bail!("{}", String::from_utf8_lossy(&output.stderr).trim());
            }
            let report: serde_json::Value = serde_json::from_slice(&output.stdout)?;
            let mut add = |what: &str, value: f64| {
                all.entry(format!("{kind}: {what}")).or_default().push(value);
            };
            for (part, ms) in report["startup_ms"].as_object().into_iter().flatten() {
                let name = if part == "total" { "first frame" } else { part.as_str() };
                add(name, ms.as_f64().unwrap_or(f64::NAN));
            }
            let drawing = report["frames"][0]["gpu_ms"]["frame"].as_f64();
            if let Some(ms) = drawing {
                add("of that drawing, by timestamps", ms);
            }
            add("whole program, with the file", wall);
            if let Some(peak) = report["peak_bytes"].as_f64() {
                peaks.entry(format!("{kind} render")).or_default().push(peak);
            }
        }
    }
    let quartiles = |values: BTreeMap<String, Vec<f64>>| {
        values.into_iter().map(|(name, values)| (name, Quartiles::of(&values)))
    };
    row.ms.extend(quartiles(all));
    row.peak.extend(quartiles(peaks));
    Ok(())
}

impl Row {
    fn new(name: String) -> Self {
        Self {
            name,
            bytes: None,
            baked_bytes: None,
            leaves: None,
            wood_triangles: None,
            ms: BTreeMap::new(),
            peak: BTreeMap::new(),
        }
    }

    /// Adds the runs of a task.
    fn add(&mut self, task: Task, runs: &[Found]) {
        let Some(first) = runs.first() else { return };
        for name in first.ms.keys() {
            let values: Vec<f64> =
                runs.iter().filter_map(|run| run.ms.get(name)).copied().collect();
            self.ms.insert(name.clone(), Quartiles::of(&values));
        }
        let name = match task {
            Task::Gltf => "gltf crate",
            Task::Bake => "bake",
            Task::Baked => "load baked",
        };
        let mut add = |name: &str, peak: fn(&Found) -> Option<u64>| {
            let values: Vec<f64> = runs.iter().filter_map(peak).map(|peak| peak as f64).collect();
            if !values.is_empty() {
                self.peak.insert(name.to_owned(), Quartiles::of(&values));
            }
        };
        add(name, |found| found.peak);
        add("load and upload baked", |found| found.peak_uploaded);
    }

    fn print(&self) {
        let megabytes = |bytes: f64| format!("{:.1} MB", bytes / 1e6);
        print!("{}", self.name);
        if let (Some(bytes), Some(leaves), Some(triangles)) =
            (self.bytes, self.leaves, self.wood_triangles)
        {
            let bytes = megabytes(bytes as f64);
            print!(": {bytes}, {leaves} leaves, {triangles} triangles of wood");
        }
        if let Some(bytes) = self.baked_bytes {
            print!(", baked {}", megabytes(bytes as f64));
        }
        println!("\n  ms, median (quartiles)");
        for (name, value) in &self.ms {
            println!("    {name:<40} {value:>30}");
        }
        println!("  most memory, median");
        for (name, value) in &self.peak {
            println!("    {name:<40} {:>30}", megabytes(value.median));
        }
    }

    /// How it stands to the goals.
    fn goals(&self, named_scene: bool) -> Vec<Goal> {
        let ms = |name: &str| self.ms.get(name).map(|value| value.median);
        let mut goals = Vec::new();
        let mut add = |limit: &str, most: f64, measured: Option<f64>| {
            if let Some(measured) = measured {
                let (name, limit) = (self.name.clone(), limit.to_owned());
                goals.push(Goal { name, limit, most, measured, met: measured <= most });
            }
        };
        let parse = ms("parse").zip(ms("gltf crate"));
        add("parse: at most 2 x the gltf crate", 2.0, parse.map(|(own, other)| own / other));
        let parse = ms("parse").zip(ms("gltf crate, with its arrays"));
        let over = parse.map(|(own, other)| own / other);
        add("parse: at most 2 x that crate with its arrays", 2.0, over);
        add("bake: at most 5000 ms", 5000.0, ms("bake"));
        add("baked, ready to draw: at most 100 ms", 100.0, ms("ready to draw"));
        let peak = self.peak.get("load baked").zip(self.baked_bytes);
        let over = peak.map(|(peak, bytes)| peak.median / bytes as f64);
        add("memory to load baked: at most 3 x the file", 3.0, over);
        if named_scene {
            add("first frame, warm: at most 2000 ms", 2000.0, ms("warm: first frame"));
            add("first frame, cold: at most 8000 ms", 8000.0, ms("cold: first frame"));
        }
        goals
    }
}
