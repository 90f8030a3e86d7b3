//! `windfall path`: fall paths.

mod inspect;
mod numbers;
mod plot;
mod stats;
mod variations;
pub mod verify;

use crate::reading::{UpArg, print_notes};
use anyhow::{Context, Result, bail};
use clap::Subcommand;
use std::io::Write;
use std::path::{Path, PathBuf};
use windfall_core::Note;
use windfall_core::glam::DVec3;
use windfall_core::path::PathSet;
use windfall_flight::{
    ImportOptions, Imported, LeafBody, Up, builtin, import_with, presets, read_paths,
    simulated_path, to_ron,
};
use windfall_scenes::TimeUnit;

/// Arguments of `windfall path`.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Simulate the fall of a leaf and store it as a path
    Simulate(Simulate),
    /// Say what is in a path file: samples, speeds, starting points, continuity points
    Inspect {
        /// A path set (binary or RON), or anything that `import` reads; "builtin" for the built-in set
        file: PathBuf,
        /// Print JSON
        #[arg(long)]
        json: bool,
        /// Write a plot: from the side, from above, orientation over time, joints
        #[arg(long, value_name = "FILE.svg")]
        plot: Option<PathBuf>,
        /// Plot so many leaves on the path instead, each falling its own way (VB, Figure 3)
        #[arg(long, value_name = "N", default_value_t = 0, requires = "plot", value_parser = clap::value_parser!(u32).range(0..=200))]
        variations: u32,
        /// Height from which the leaves of --variations fall, metres
        #[arg(long, value_name = "M", default_value_t = 10.0, requires = "variations")]
        drop: f32,
        /// Vary them by the formulas of the paper's text of this year, 2007 or 2008
        #[arg(long, value_name = "YEAR", requires = "variations", value_parser = clap::value_parser!(u16).range(2007..=2008))]
        paper: Option<u16>,
        /// Which path of the set to plot
        #[arg(long, default_value_t = 0)]
        index: usize,
        #[command(flatten)]
        import: ImportArgs,
    },
    /// Hold the flight models against published figures
    Verify {
        /// Falls for each row of the second table
        #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(10..=100_000))]
        falls: u32,
    },
    /// Measure variety and realism of played falls against direct simulations
    Stats {
        /// Leaves of the tree, and direct simulations
        #[arg(long, default_value_t = 10_000, value_parser = clap::value_parser!(u32).range(100..=1_000_000))]
        leaves: u32,
        /// Species whose leaves fall
        #[arg(long, default_value = "birch", value_parser = species)]
        species: String,
        /// Random seed
        #[arg(long, default_value_t = 1)]
        seed: u32,
    },
    /// Turn a glTF animation, a CSV table or a JSON list into a path file
    Import {
        /// The file to read
        file: PathBuf,
        #[command(flatten)]
        import: ImportArgs,
        /// File to write: RON if it ends in .ron, otherwise binary
        #[arg(long)]
        out: PathBuf,
    },
}

#[derive(clap::Args)]
struct Simulate {
    /// A species with a preset
    #[arg(long, value_parser = species, conflicts_with_all = ["areal_density", "length", "width", "petiole", "builtin"])]
    species: Option<String>,
    /// Mass per area, g/m²
    #[arg(long, value_parser = positive, value_name = "G")]
    areal_density: Option<f64>,
    /// Length of the leaf, centimetres
    #[arg(long, value_parser = positive, value_name = "CM")]
    length: Option<f64>,
    /// Width of the leaf, centimetres
    #[arg(long, value_parser = positive, value_name = "CM")]
    width: Option<f64>,
    /// Offset of the centre of mass towards the petiole, in half lengths (0 to 0.8)
    #[arg(long, value_name = "SHARE")]
    petiole: Option<f64>,
    /// Simulate the whole built-in set
    #[arg(long)]
    builtin: bool,
    /// Duration, seconds
    #[arg(long, default_value_t = 6.0, value_parser = positive, value_name = "S")]
    seconds: f64,
    /// Samples per second; default: the species', or 60
    #[arg(long, value_parser = positive, value_name = "HZ")]
    rate: Option<f64>,
    /// Random seed
    #[arg(long, default_value_t = 1)]
    seed: u32,
    /// Falls drawn, of which the one with the best continuity points is kept
    #[arg(long, default_value_t = 16)]
    draws: u32,
    /// File to write: RON if it ends in .ron, otherwise binary
    #[arg(long)]
    out: PathBuf,
}

#[derive(clap::Args)]
struct ImportArgs {
    /// glTF: name of the animated node
    #[arg(long)]
    node: Option<String>,
    /// glTF: name of the animation ("take"), or its number from 0; default: the first that moves the node
    #[arg(long, value_name = "NAME")]
    animation: Option<String>,
    /// The axis that points up in the file
    #[arg(long, value_enum, default_value_t = UpArg::Y)]
    up: UpArg,
    /// Tables with frame numbers: frames per second
    #[arg(long, value_name = "N")]
    fps: Option<f32>,
    /// Tables: what times are in: s or ms
    #[arg(long, value_name = "UNIT", default_value = "s")]
    time_unit: TimeUnit,
    /// Metres for each unit of the file
    #[arg(long, default_value_t = 1.0)]
    scale: f32,
    /// Resample to so many samples per second
    #[arg(long, value_name = "HZ")]
    rate: Option<f32>,
    /// Name of the path; default: the file's
    #[arg(long)]
    name: Option<String>,
}

fn species(name: &str) -> Result<String, String> {
    let names = presets::ALL.map(|p| p.name).join(", ");
    presets::find(name).map(|p| p.name.to_owned()).ok_or(format!("known species: {names}"))
}

fn positive(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if value > 0.0 && value.is_finite() { Ok(value) } else { Err("must be above 0".into()) }
}

impl ImportArgs {
    fn options(&self) -> ImportOptions {
        ImportOptions {
            node: self.node.clone(),
            animation: self.animation.clone(),
            up: match self.up {
                UpArg::Y => Up::Y,
                UpArg::Z => Up::Z,
            },
            fps: self.fps,
            time_unit: time_unit(self.time_unit),
            scale: self.scale,
            rate: self.rate,
            name: self.name.clone(),
        }
    }
}

/// Runs `windfall path`.
///
/// # Errors
///
/// Files that cannot be read or written, and whatever the models refuse.
pub fn run(args: Args) -> Result<()> {
    match args.command {
        Command::Simulate(simulate) => run_simulate(&simulate),
        Command::Inspect { file, json, plot, variations, drop, paper, index, import } => {
            let (set, notes) = load(&file, &import.options())?;
            inspect::print(&set, &notes, json)?;
            if let Some(out) = plot {
                let Some(path) = set.paths().get(index) else {
                    bail!("--index {index}: the set has {} paths", set.paths().len());
                };
                let svg = match variations {
                    0 => plot::draw(path)?,
                    count => variations::draw(path, count, drop, paper)?,
                };
                write(&out, svg.as_bytes())?;
                eprintln!("plot of path {index} written to {}", out.display());
            }
            Ok(())
        }
        Command::Verify { falls } => verify::run(falls),
        Command::Stats { leaves, species, seed } => stats::run(leaves, &species, seed),
        Command::Import { file, import: args, out } => {
            let imported = import_file(&file, &args.options())?;
            print_notes(&imported.notes);
            save(&out, &PathSet::new(vec![imported.path])?)
        }
    }
}

fn run_simulate(args: &Simulate) -> Result<()> {
    let mut paths = Vec::new();
    if args.builtin {
        for preset in &presets::ALL {
            for i in 0..builtin::PER_SPECIES {
                paths.push(builtin::simulate(preset, i)?);
            }
        }
    } else {
        let (name, body, rate) = match args.species.as_deref().and_then(presets::find) {
            Some(preset) => (preset.name, preset.body, preset.rate),
            None => ("leaf", described(args)?, 60.0),
        };
        let rate = args.rate.unwrap_or(rate);
        paths.push(simulated_path(name, &body, args.seconds, rate, args.seed, args.draws)?);
    }
    let set = PathSet::new(paths)?;
    save(&args.out, &set)
}

fn described(args: &Simulate) -> Result<LeafBody> {
    let Some(density) = args.areal_density else {
        bail!("name a --species, or describe a leaf with --areal-density, --length and --width");
    };
    let length = args.length.context("--length is needed with --areal-density")?;
    let width = args.width.context("--width is needed with --areal-density")?;
    let petiole = args.petiole.unwrap_or(0.05);
    if !(0.0..=0.8).contains(&petiole) {
        bail!("--petiole {petiole}: 0 to 0.8 half lengths");
    }
    let half = length / 200.0;
    Ok(LeafBody {
        half_length: half,
        half_width: width / 200.0,
        offset: DVec3::new(0.0, 0.0, -petiole * half),
        ..LeafBody::disc(1.0, density / 1000.0)
    })
}

/// Reads a path set, or imports a path; its notes go to stderr.
pub fn load(file: &Path, options: &ImportOptions) -> Result<(PathSet, Vec<Note>)> {
    if file == Path::new("builtin") {
        return Ok((PathSet::builtin(), Vec::new()));
    }
    let bytes = read(file)?;
    // RON of ours begins with a parenthesis; no form that is imported does.
    if bytes.starts_with(b"WFPATHS") || bytes.trim_ascii_start().starts_with(b"(") {
        return Ok((read_paths(&file.display().to_string(), &bytes)?, Vec::new()));
    }
    let imported = import_file(file, options)?;
    print_notes(&imported.notes);
    Ok((PathSet::new(vec![imported.path])?, imported.notes))
}

fn import_file(file: &Path, options: &ImportOptions) -> Result<Imported> {
    let bytes = read(file)?;
    let folder = file.parent().unwrap_or(Path::new("")).to_owned();
    let mut resolve = |uri: &str| {
        let beside = folder.join(uri);
        std::fs::read(&beside).map_err(|e| format!("{}: {e}", beside.display()))
    };
    Ok(import_with(&file.display().to_string(), &bytes, options, &mut resolve)?)
}

/// What the importer calls a unit of time.
pub fn time_unit(unit: TimeUnit) -> windfall_flight::TimeUnit {
    match unit {
        TimeUnit::Seconds => windfall_flight::TimeUnit::Seconds,
        TimeUnit::Milliseconds => windfall_flight::TimeUnit::Milliseconds,
    }
}

fn read(file: &Path) -> Result<Vec<u8>> {
    std::fs::read(file).with_context(|| format!("cannot read {}", file.display()))
}

fn save(out: &Path, set: &PathSet) -> Result<()> {
    if out.extension().is_some_and(|e| e == "ron") {
        write(out, to_ron(set).as_bytes())?;
    } else {
        write(out, &set.to_bytes())?;
    }
    inspect::print(set, &[], false)?;
    eprintln!("written to {}", out.display());
    Ok(())
}

fn write(out: &Path, bytes: &[u8]) -> Result<()> {
    windfall_host::file::write_atomic(out, |file| Ok(file.write_all(bytes)?))
}
