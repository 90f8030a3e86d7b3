//! `windfall bench picture`: what the presets of quality and single effects cost.

use super::Spread;
use super::stand::Easel;
use crate::gpu::Gpu;
use crate::render::parse_size;
use anyhow::{Context, bail};
use serde::Serialize;
use std::convert::Infallible;
use std::path::PathBuf;
use windfall_gpu::{Quality, View};
use windfall_scenes::{NAMES, named};

/// Arguments of `windfall bench picture`.
#[derive(clap::Args)]
pub struct Args {
    /// Scenes to measure; all that are built in by default
    #[arg(value_name = "SCENE")]
    scenes: Vec<String>,
    /// Measured frames of each kind
    #[arg(long, value_name = "N", default_value_t = 5)]
    frames: u32,
    /// Size of the picture
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "1280x720")]
    size: (u32, u32),
    /// Measure what each effect adds to the lowest preset too
    #[arg(long)]
    effects: bool,
    /// Also write the numbers to this file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Serialize)]
struct Report {
    adapter: String,
    size: (u32, u32),
    rows: Vec<Row>,
}

#[derive(Serialize)]
struct Row {
    scene: String,
    kind: &'static str,
    wall_ms: Spread,
    /// Over the lowest preset of the same round.
    over_low: Spread,
}

/// The presets; then the lowest with one effect of the highest each.
fn kinds(effects: bool) -> Vec<(&'static str, Quality)> {
    let low = Quality::LOW;
    let mut kinds = Quality::PRESETS.to_vec();
    if effects {
        kinds.extend([
            ("no sway", Quality { sway: false, ..low }),
            ("no backdrop", Quality { backdrop: false, ..low }),
            ("larger shadow maps", Quality { shadow_size: 2048, ..low }),
            ("more shadow samples", Quality { shadow_taps: 12, ..low }),
            ("penumbrae", Quality { shadow_taps: 12, penumbrae: true, ..low }),
            ("veins", Quality { veins: true, ..low }),
            ("gloss", Quality { gloss: true, ..low }),
            ("ground detail", Quality { ground_detail: true, ..low }),
            ("bark relief", Quality { bark_relief: true, ..low }),
            ("grass", Quality { grass: true, ..low }),
        ]);
    }
    kinds
}

/// Runs `windfall bench picture`.
pub fn run(args: &Args) -> anyhow::Result<()> {
    if args.frames == 0 {
        bail!("--frames is at least 1");
    }
    let names: Vec<&str> = if args.scenes.is_empty() {
        NAMES.to_vec()
    } else {
        args.scenes.iter().map(String::as_str).collect()
    };
    let mut gpu = Gpu::open()?;
    println!("{}, {}x{}", gpu.adapter, args.size.0, args.size.1);
    let easel = Easel::new(&gpu, args.size);
    let kinds = kinds(args.effects);
    let mut rows = Vec::new();
    for name in names {
        let scene = named(name).with_context(|| format!("{name}: no built-in scene"))?;
        let built = scene.build(|file, _| -> Result<_, Infallible> {
            unreachable!("built-in scenes have no files: {file}")
        });
        let Ok(stage) = built;
        let forest = easel.forest(&gpu, &stage, &stage.falls);
        let mut walls: Vec<Vec<f64>> = vec![Vec::new(); kinds.len()];
        // In the first round pipelines compile: it is not measured.
        for round in 0..=args.frames {
            for ((_, quality), walls) in kinds.iter().zip(&mut walls) {
                let view = scene.view(scene.time, &stage.forest.terrain);
                let view = View { quality: *quality, ..view };
                let frame = easel.frame(&mut gpu, &forest, &view)?;
                if round > 0 {
                    walls.push(frame.wall);
                }
            }
        }
        println!("{name}: wall time of a frame in ms, median (quartiles), and over low");
        for ((kind, _), times) in kinds.iter().zip(&walls) {
            let ratios: Vec<f64> = times.iter().zip(&walls[0]).map(|(a, b)| a / b).collect();
            let (wall_ms, over_low) = (Spread::of(times), Spread::of(&ratios));
            println!("  {kind:<20} {wall_ms:>28} {over_low:>24}");
            rows.push(Row { scene: name.to_owned(), kind, wall_ms, over_low });
        }
    }
    if let Some(path) = &args.json {
        let report = Report { adapter: gpu.adapter.clone(), size: args.size, rows };
        let text = serde_json::to_string_pretty(&report)?;
        std::fs::write(path, text).with_context(|| format!("{}", path.display()))?;
    }
    Ok(())
}
