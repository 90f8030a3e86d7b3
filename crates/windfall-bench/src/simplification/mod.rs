//! `windfall bench simplification`: what stochastic simplification and culling save, and the image
//! error that simplification makes (SFS 4.2, 5 and beyond).

mod culling;
mod fading;
mod frame_time;
mod image_error;
pub mod workload;

use crate::harness::Harness;
use crate::output::{create_folder, write_json, write_text};
use anyhow::bail;
use serde::Serialize;
use std::path::{Path, PathBuf};
use windfall_host::device::Gpu;
use windfall_host::image::parse_size;

/// Frames drawn before any is measured: pipelines compile.
const WARM_UP: u32 = 2;

/// Arguments of `windfall bench simplification`.
#[derive(clap::Args)]
pub struct Args {
    /// Parts to run: a (the paper's forest over h), b (culling), c (image error), d (smooth fading)
    #[arg(long, value_name = "abcd", default_value = "abcd")]
    parts: String,
    /// Measured frames of each kind
    #[arg(long, value_name = "N", default_value_t = 5)]
    frames: u32,
    /// Size of the picture of parts a and b
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "800x600")]
    size: (u32, u32),
    /// Vertices in the view of part a, millions
    #[arg(long, value_name = "M", default_value_t = 61.0)]
    vertices: f64,
    /// Values of h in part a; how much faster a frame is, is over the first of them
    #[arg(long, value_name = "H", value_delimiter = ',', default_values_t = frame_time::HS)]
    h: Vec<f32>,
    /// Most trees of part b
    #[arg(long, value_name = "N", default_value_t = 100_000)]
    most: u32,
    /// Trees of part c: species, or .glb and .gltf files; may be given again
    #[arg(long, value_name = "FILE|SPECIES", default_values = ["oak", "birch"])]
    tree: Vec<String>,
    /// Rescale the trees of part c to this height, metres
    #[arg(long, value_name = "M")]
    height: Option<f32>,
    /// Leaves of the species of part c; their own number where this is not given
    #[arg(long, value_name = "N")]
    leaves: Option<u32>,
    /// Levels of detail of part c
    #[arg(long, value_name = "SHARE", value_delimiter = ',', default_values_t = image_error::LAMBDAS)]
    lambda: Vec<f32>,
    /// Candidates of part c, by their names in its table; all where none is given
    #[arg(long, value_name = "NAME", value_delimiter = ';')]
    only: Vec<String>,
    /// Rows of the screen that the pictures of part c are parts of
    #[arg(long, value_name = "N", default_value_t = 720)]
    screen: u32,
    /// Sides from which the trees of part c are seen
    #[arg(long, value_name = "N", default_value_t = 2)]
    sides: u32,
    /// Save the pictures of part c, seen from the first side, into this folder
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,
    /// Also write the numbers to this file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Also draw the plots into this folder
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
}

#[derive(Serialize, Default)]
struct Report {
    adapter: String,
    size: (u32, u32),
    forest: Option<frame_time::FrameTimes>,
    culling: Option<culling::CullingReport>,
    errors: Option<image_error::Errors>,
    fades: Option<fading::Fades>,
}

/// Runs `windfall bench simplification`.
pub fn run(args: &Args) -> anyhow::Result<()> {
    if args.frames == 0 || args.parts.chars().any(|c| !"abcd".contains(c)) {
        bail!("--parts is of a, b, c and d, and --frames at least 1");
    }
    let mut gpu = Gpu::open()?;
    println!("{}, {}x{}", gpu.adapter, args.size.0, args.size.1);
    let harness = Harness::new(&gpu, args.size)?;
    let mut report = Report { adapter: gpu.adapter.clone(), size: args.size, ..Report::default() };
    if args.parts.contains('a') {
        let forest = frame_time::measure(args, &mut gpu, &harness)?;
        if let Some(folder) = &args.plots {
            create_folder(folder)?;
            write_text(&folder.join("simplification-forest.svg"), &forest.plot()?)?;
        }
        report.forest = Some(forest);
    }
    if args.parts.contains('b') {
        report.culling = Some(culling::measure(args, &mut gpu, &harness)?);
    }
    if args.parts.contains('c') {
        let errors = image_error::measure(args, &mut gpu, &harness.renderer)?;
        if let Some(folder) = &args.plots {
            create_folder(folder)?;
            for (tree, plot) in errors.plots()? {
                let stem = Path::new(&tree).file_stem().unwrap_or_default();
                let path = folder.join(format!("simplification-error-{}.svg", stem.display()));
                write_text(&path, &plot)?;
            }
        }
        report.errors = Some(errors);
    }
    if args.parts.contains('d') {
        report.fades = Some(fading::measure(&mut gpu, &harness.renderer)?);
    }
    if let Some(path) = &args.json {
        write_json(path, &report)?;
    }
    Ok(())
}
