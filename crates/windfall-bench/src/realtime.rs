//! `windfall bench realtime`: whole frames of a walk, beside the least that a frame of that size can take.
//!
//! Frames are timed by the wall clock, from the first call to the end of all work on the GPU: where passes overlap or
//! the driver defers work, timestamps do not add up.

pub use crate::baseline::Floor;
use crate::harness::Harness;
use crate::output::write_json;
use crate::statistics::Quartiles;
use anyhow::{Context, bail};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;
use windfall_gpu::{FrameBudget, OcclusionSwitch, Quality, View};
use windfall_host::device::Gpu;
use windfall_host::image::parse_size;
use windfall_scenes::{NAMES, Scene, Source, Stage, named};

/// Seconds between frames of the walk.
const STEP: f64 = 1.0 / 30.0;
/// Speed of the walk on top of the scene's own motion, metres per second.
const SPEED: f64 = 0.5;
/// Frames in which each shadow map is drawn, as in the viewer.
const SHADOW_PERIOD: u32 = 8;
/// Frames that are drawn first and not measured: pipelines compile.
const WARM: u32 = 3;
/// The same where occlusion culling is tried first.
const WARM_OCCLUSION: u32 = 10;
/// Seconds in which a budget has to settle before frames are measured.
const SETTLING: f64 = 2.0;
/// The name of a meadow without trees.
const EMPTY: &str = "empty";

/// Arguments of `windfall bench realtime`.
#[derive(clap::Args)]
pub struct Args {
    /// Scenes to measure, by name or file, and `empty`, a meadow without trees; all that are built in by default
    #[arg(value_name = "SCENE")]
    scenes: Vec<String>,
    /// Size of the picture
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "640x360")]
    size: (u32, u32),
    /// Quality: low, medium or high; may be given again
    #[arg(long, value_name = "NAME", default_values = ["low", "high"])]
    quality: Vec<Quality>,
    /// Measured frames
    #[arg(long, value_name = "N", default_value_t = 9)]
    frames: u32,
    /// Without shadows
    #[arg(long)]
    no_shadows: bool,
    /// Hold this time per frame, milliseconds: the view gives up what it may
    #[arg(long, value_name = "MS", value_parser = parse_budget)]
    budget: Option<f32>,
    /// Also write the numbers to this file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Serialize)]
struct Report {
    adapter: String,
    size: (u32, u32),
    scenes: Vec<Row>,
}

#[derive(Serialize)]
struct Row {
    name: String,
    quality: &'static str,
    /// A frame of the walk.
    frame_ms: Quartiles,
    /// Clear, bare draw and tone map of the same size, measured in turns with the frames.
    floor_ms: Quartiles,
    /// The frame over the floor.
    ratio: Quartiles,
    /// From the stage on the CPU to the end of its first frame.
    first_frame_ms: f64,
    /// Triangles that the last frame drew, which the floor draws too.
    triangles: u64,
    /// With a budget: how much of what may be given up is, 0 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    saving: Option<f32>,
}

/// Reads a time per frame.
fn parse_budget(text: &str) -> Result<f32, String> {
    let ms: Option<f32> = text.parse().ok().filter(|ms| (0.1..=10_000.0).contains(ms));
    ms.ok_or_else(|| "is not 0.1 to 10000 milliseconds".to_owned())
}

/// A scene by name or file, with its stage.
fn read(name: &str) -> anyhow::Result<(Scene, Stage)> {
    let folder = Path::new(name).parent().unwrap_or(Path::new("")).to_owned();
    let scene = if name == EMPTY {
        let mut scene = named("lone-oak").context("the scene is built in")?;
        scene.count = 0;
        scene
    } else if let Some(scene) = named(name) {
        scene
    } else {
        let text = std::fs::read_to_string(name)
            .with_context(|| format!("{name}: no built-in scene, and no file that can be read"))?;
        Scene::from_ron(&text, name)?
    };
    let stage = scene.build(|file, entry| -> anyhow::Result<_> {
        debug_assert!(matches!(entry.source, Source::File(_)));
        Ok(windfall_host::tree::read(&folder.join(file), &entry.import_options())?.tree)
    })?;
    stage.check(name)?;
    Ok((scene, stage))
}

/// Time and view of a frame of the walk. The camera goes ahead.
fn step(scene: &Scene, stage: &Stage, frame: u32, quality: Quality, shadows: bool) -> (f64, View) {
    let since = f64::from(frame) * STEP;
    let time = scene.time + since;
    let mut view = scene.view(time, &stage.forest.terrain);
    view.camera.eye += view.camera.forward().as_dvec3() * (SPEED * since);
    view.quality = quality;
    view.shadows &= shadows;
    view.shadow_period = SHADOW_PERIOD;
    (time, view)
}

fn quality_name(quality: Quality) -> &'static str {
    Quality::PRESETS.iter().find(|(_, preset)| *preset == quality).map_or("other", |(name, _)| name)
}

/// Runs `windfall bench realtime`.
pub fn run(args: &Args) -> anyhow::Result<()> {
    if args.frames == 0 {
        bail!("--frames is at least 1");
    }
    let names: Vec<&str> = if args.scenes.is_empty() {
        std::iter::once(EMPTY).chain(NAMES).collect()
    } else {
        args.scenes.iter().map(String::as_str).collect()
    };
    let mut gpu = Gpu::open()?;
    println!("{}, {}x{}", gpu.adapter, args.size.0, args.size.1);
    println!("milliseconds, median (quartiles)");
    println!(
        "{:<22} {:<7} {:>28} {:>24} {:>20} {:>12}",
        "scene", "quality", "frame", "floor", "frame / floor", "first frame"
    );
    let harness = Harness::new(&gpu, args.size)?;
    let mut scenes = Vec::new();
    for name in names {
        let (scene, stage) = read(name)?;
        for &quality in &args.quality {
            let start = Instant::now();
            let mut planted = harness.upload(&gpu, &stage)?;
            let mut floor: Option<Floor> = None;
            let (mut frames, mut floors) = (Vec::new(), Vec::new());
            let (mut first_frame_ms, mut triangles) = (0.0, 0);
            let mut budget = args.budget.map(|ms| FrameBudget::new(ms * 1e-3));
            let mut occlusion = OcclusionSwitch::default();
            let tries = scene.culling == windfall_scenes::Culling::Occlusion;
            let warm = if tries { WARM_OCCLUSION } else { WARM };
            let (mut frame, mut settling) = (0, 0.0);
            while frames.len() < args.frames as usize {
                let (time, mut view) = step(&scene, &stage, frame, quality, !args.no_shadows);
                if let Some(budget) = &budget {
                    budget.apply(&mut view);
                }
                occlusion.apply(&mut view);
                let measured = harness.measure(&mut gpu, &mut planted, (time, &view))?;
                occlusion.counted(&measured.counts.trees);
                if frame > 0
                    && let Some(budget) = &mut budget
                {
                    budget.frame(measured.wall_ms as f32 * 1e-3);
                    settling += measured.wall_ms * 1e-3;
                }
                if frame == 0 {
                    first_frame_ms = start.elapsed().as_secs_f64() * 1e3;
                }
                triangles = measured.counts.trees.triangles;
                frame += 1;
                if frame < warm || budget.is_some() && settling < SETTLING {
                    continue;
                }
                let floor = if let Some(floor) = &floor {
                    floor
                } else {
                    let new = floor.insert(Floor::new(&gpu, args.size, triangles));
                    // Its pipeline compiles in a first frame.
                    new.measure(&gpu)?;
                    new
                };
                let bare = floor.measure(&gpu)?;
                frames.push(measured.wall_ms);
                floors.push(bare);
            }
            let ratios: Vec<f64> = frames.iter().zip(&floors).map(|(a, b)| a / b).collect();
            let row = Row {
                name: name.to_owned(),
                quality: quality_name(quality),
                frame_ms: Quartiles::of(&frames),
                floor_ms: Quartiles::of(&floors),
                ratio: Quartiles::of(&ratios),
                first_frame_ms,
                triangles,
                saving: budget.as_ref().map(FrameBudget::saving),
            };
            println!(
                "{:<22} {:<7} {:>28} {:>24} {:>20} {:>12.0}",
                row.name, row.quality, row.frame_ms, row.floor_ms, row.ratio, row.first_frame_ms
            );
            if tries {
                println!(
                    "    occlusion culling is {}",
                    if occlusion.is_on() { "kept: it pays" } else { "off: it does not pay" }
                );
            }
            if let Some(saving) = row.saving {
                println!(
                    "    saves {saving:.2} of what may be given up, {SETTLING} s after it began"
                );
            }
            scenes.push(row);
        }
    }
    if let Some(path) = &args.json {
        write_json(path, &Report { adapter: gpu.adapter.clone(), size: args.size, scenes })?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_walk_goes_on_and_a_meadow_has_no_trees() {
        let (scene, stage) = read(EMPTY).unwrap();
        assert!(stage.forest.instances.is_empty());
        let at = |frame| step(&scene, &stage, frame, Quality::LOW, true);
        let ((a, first), (b, last)) = (at(0), at(30));
        assert!((b - a - 1.0).abs() < 1e-9);
        assert!((first.camera.eye.distance(last.camera.eye) - SPEED).abs() < 0.1);
        assert!(read("no such scene").is_err());
    }
}
