//! `windfall bench falling`: what falling leaves cost (VB 6.3 and beyond).

mod million;
mod rest;
mod scaling;
mod soak;
mod strategies;
pub mod workload;

use crate::harness::Harness;
use crate::output::{create_folder, write_json, write_text};
use anyhow::bail;
use million::Many;
use rest::AtRest;
use scaling::Counts;
use serde::Serialize;
use soak::Soak;
use std::path::{Path, PathBuf};
use strategies::StrategyRow;
use windfall_host::device::Gpu;
use windfall_host::image::parse_size;
use windfall_scenes::Strategy;

/// Frames drawn before any is measured: pipelines compile, lists are built.
const WARM_UP: u32 = 3;

/// The passes that pose leaves: once a frame, and those in view into the list that is drawn.
const POSE_PASSES: [&str; 3] = ["pose", "select", "gather"];

/// Arguments of `windfall bench falling`.
#[derive(clap::Args)]
pub struct Args {
    /// Parts to run: a (VB's scene, each strategy), b (a million leaves in the air), c (cost against count), r (a million
    /// leaves at rest)
    ///
    /// Leaf occlusion of part a is for the strategies vertex, fragment and vertex-buffer: its row for
    /// compute is "-". The pose pass of parts b and c is three: one poses all leaves once a frame, two
    /// gather the leaves of a view.
    #[arg(long, value_name = "abcr", default_value = "abcr")]
    parts: String,
    /// Measured frames of each kind
    #[arg(long, value_name = "N", default_value_t = 15)]
    frames: u32,
    /// Frames of the walk of part a from one measured frame to the next
    #[arg(long, value_name = "N", default_value_t = 1)]
    stride: u32,
    /// Size of the picture
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "320x180")]
    size: (u32, u32),
    /// Leaves in the air in part a
    #[arg(long, value_name = "N", default_value_t = 12_000)]
    falling: u32,
    /// Leaves thrown each second in part a, from time 0 on, instead of --falling
    #[arg(long, value_name = "N", conflicts_with = "falling")]
    throw_rate: Option<f32>,
    /// Strategies of part a, with commas between them
    #[arg(long, value_name = "NAMES", value_delimiter = ',', default_values_t = [
        Strategy::Compute, Strategy::Vertex, Strategy::Fragment, Strategy::VertexBuffer,
    ])]
    strategies: Vec<Strategy>,
    /// Moment of the first measured frame in part a, seconds
    #[arg(long, value_name = "S", default_value_t = 8.0)]
    start: f64,
    /// Leaves of part b
    #[arg(long, value_name = "N", default_value_t = 1 << 20)]
    many: u32,
    /// Most leaves of part c
    #[arg(long, value_name = "N", default_value_t = 1 << 22)]
    most: u32,
    /// Frames of part d, continuous shedding; 0 leaves it out
    #[arg(long, value_name = "N", default_value_t = 0)]
    soak: u32,
    /// Leaves of each of the three trees of part d
    #[arg(long, value_name = "N", default_value_t = 4000)]
    soak_leaves: u32,
    /// Write plots of parts a and c (SVG) to this folder
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
    /// Also write the numbers to this file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Serialize, Default)]
struct Report {
    adapter: String,
    size: (u32, u32),
    strategies: Vec<StrategyRow>,
    many: Option<Many>,
    counts: Option<Counts>,
    at_rest: Option<AtRest>,
    soak: Option<Soak>,
}

/// Runs `windfall bench falling`.
pub fn run(args: &Args) -> anyhow::Result<()> {
    if args.frames == 0 || args.parts.chars().any(|c| !"abcr".contains(c)) {
        bail!("--parts is of a, b, c and r, and --frames at least 1");
    }
    let mut gpu = Gpu::open()?;
    println!("{}, {}x{}", gpu.adapter, args.size.0, args.size.1);
    let harness = Harness::new(&gpu, args.size)?;
    let mut report = Report { adapter: gpu.adapter.clone(), size: args.size, ..Report::default() };
    if args.parts.contains('a') {
        report.strategies = strategies::measure(args, &mut gpu, &harness)?;
    }
    if args.parts.contains('b') {
        report.many = Some(million::measure(args, &mut gpu, &harness)?);
    }
    if args.parts.contains('c') {
        report.counts = Some(scaling::measure(args, &mut gpu, &harness)?);
    }
    if args.parts.contains('r') {
        report.at_rest = Some(rest::measure(args, &mut gpu, &harness)?);
    }
    if args.soak > 0 {
        report.soak = Some(soak::measure(args.soak, args.soak_leaves, &mut gpu)?);
    }
    if let Some(folder) = &args.plots {
        write_plots(folder, args, &report)?;
    }
    if let Some(path) = &args.json {
        write_json(path, &report)?;
    }
    Ok(())
}

/// VB's figure 6 from part a, and the cost against the count from part c.
fn write_plots(folder: &Path, args: &Args, report: &Report) -> anyhow::Result<()> {
    create_folder(folder)?;
    for rows in report.strategies.chunk_by(|a, b| a.strategy == b.strategy) {
        let name = format!("walk-{}.svg", rows[0].strategy);
        write_text(&folder.join(name), &strategies::plot(rows, args)?)?;
    }
    if let Some(counts) = &report.counts {
        write_text(&folder.join("counts.svg"), &counts.plot()?)?;
    }
    Ok(())
}
