//! `windfall bench picture`: the cost of the quality presets and of single effects.
//!
//! Effects inside a shader have no timestamps, and those of draws inside a pass are meaningless on
//! tiled GPUs. So each effect is switched off by itself, in turns with the full frame. Its cost is
//! the difference of the frame times.

mod crawl;
mod pops;

use crate::harness::{FrameMeasurement, Harness};
use crate::output::write_json;
use crate::scenery::edit_sky;
use crate::statistics::Quartiles;
use anyhow::{Context, bail};
use serde::Serialize;
use std::collections::BTreeSet;
use std::convert::Infallible;
use std::path::PathBuf;
use windfall_gpu::{Quality, View};
use windfall_host::device::Gpu;
use windfall_host::image::parse_size;
use windfall_scenes::{NAMES, named};
use windfall_tree::Species;

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
    #[arg(default_value_if("pops", "true", "320x180"))]
    size: (u32, u32),
    /// Measure each effect of the highest preset too, by switching it off
    #[arg(long)]
    effects: bool,
    /// Measure instead how restless edges are: the change from frame to frame over that of
    /// supersampled frames, while the camera walks
    #[arg(long, conflicts_with_all = ["effects", "json"])]
    crawl: bool,
    /// Measure instead whether anything pops on a walk from 60 m to 2 m past a single tree; scenes are then species, or
    /// files of trees. 320x180 unless --size says otherwise
    #[arg(long, conflicts_with_all = ["effects", "json", "crawl"])]
    pops: bool,
    /// Also write the numbers to this file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Serialize)]
struct Report {
    adapter: String,
    size: (u32, u32),
    /// Whether the times are GPU timestamps; otherwise they are wall clock of whole frames.
    timestamps: bool,
    rows: Vec<Row>,
}

#[derive(Serialize)]
struct Row {
    scene: String,
    part: Part,
    name: String,
    /// The time of a preset's frame, of a pass, or of an effect.
    gpu_ms: Quartiles,
    /// A preset over the lowest preset of the same round; a pass or an effect over the full frame.
    ratio: Quartiles,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum Part {
    Preset,
    /// A pass of the highest preset, by timestamps.
    Pass,
    /// An effect of the highest preset, by switching it off.
    Effect,
}

/// Switches an effect of a view off.
type Switch = fn(&mut View);

/// The effects of the highest preset and their switches.
const EFFECTS: [(&str, Switch); 19] = [
    ("shadows", |v| v.shadows = false),
    ("shadow maps of 2048, not 1024", |v| v.quality.shadow_size = 1024),
    ("12 shadow samples, not 4", |v| (v.quality.shadow_taps, v.quality.soft_shadows) = (4, false)),
    ("penumbrae", |v| v.quality.soft_shadows = false),
    ("sway", |v| v.quality.sway = false),
    ("lighting of leaves in pixels", |v| v.quality.pixel_lighting = false),
    ("veins", |v| v.quality.veins = false),
    ("gloss", |v| v.quality.gloss = false),
    ("transmission", |v| v.quality.transmission = false),
    ("openness", |v| v.quality.ambient_occlusion = false),
    ("ground detail", |v| v.quality.ground_detail = false),
    ("bark relief", |v| v.quality.bark_relief = false),
    ("grass", |v| v.quality.grass = false),
    ("backdrop", |v| v.quality.backdrop = false),
    ("reconstruction", |v| v.quality.resolve_filter = false),
    ("full resolution, not half", |v| v.quality.resolution = 0.5),
    ("aerial perspective", |v| edit_sky(v, |sky| sky.haze = 0.0)),
    ("clouds", |v| edit_sky(v, |sky| sky.clouds = 0.0)),
    ("all of them", |v| {
        edit_sky(v, |sky| (sky.haze, sky.clouds) = (0.0, 0.0));
        (v.shadows, v.quality) = (false, NO_EFFECTS);
    }),
];

/// The lowest preset without the effects that it still has.
const NO_EFFECTS: Quality = Quality {
    shadow_size: 256,
    shadow_taps: 1,
    sway: false,
    transmission: false,
    ambient_occlusion: false,
    backdrop: false,
    ..Quality::PLAIN
};

/// The views of a round: each preset, then the highest preset without each effect.
fn variants(view: &View, effects: bool) -> Vec<View> {
    let presets = Quality::PRESETS.map(|(_, quality)| View { quality, ..view.clone() });
    let switched = EFFECTS.map(|(_, switch)| {
        let mut view = View { quality: Quality::HIGH, ..view.clone() };
        switch(&mut view);
        view
    });
    presets.into_iter().chain(switched.into_iter().filter(|_| effects)).collect()
}

/// Milliseconds by GPU timestamps; by the wall clock without them.
fn frame_ms(frame: &FrameMeasurement) -> f64 {
    frame.gpu_ms.get("frame").copied().unwrap_or(frame.wall_ms)
}

/// The rows of a scene. Each round has the frames of [`variants`], in that order.
fn rows(scene: &str, rounds: &[Vec<FrameMeasurement>]) -> Vec<Row> {
    let column = |value: &dyn Fn(&[FrameMeasurement]) -> f64| {
        Quartiles::of(&rounds.iter().map(|round| value(round)).collect::<Vec<_>>())
    };
    let row = |part, name: &str, gpu_ms: &dyn Fn(&[FrameMeasurement]) -> f64, over: usize| Row {
        scene: scene.to_owned(),
        part,
        name: name.to_owned(),
        gpu_ms: column(gpu_ms),
        ratio: column(&|round| gpu_ms(round) / frame_ms(&round[over])),
    };
    let presets = Quality::PRESETS.len();
    let high = presets - 1;
    let mut rows = Vec::new();
    for (i, (name, _)) in Quality::PRESETS.iter().enumerate() {
        rows.push(row(Part::Preset, name, &|round| frame_ms(&round[i]), 0));
    }
    let passes: BTreeSet<&str> =
        rounds.iter().flat_map(|r| r[high].gpu_ms.keys()).map(String::as_str).collect();
    for name in passes.into_iter().filter(|name| *name != "frame") {
        let pass =
            |round: &[FrameMeasurement]| round[high].gpu_ms.get(name).copied().unwrap_or(f64::NAN);
        rows.push(row(Part::Pass, name, &pass, high));
    }
    let measured = rounds.first().map_or(0, Vec::len);
    for (i, (name, _)) in (presets..measured).zip(EFFECTS) {
        let saved = |round: &[FrameMeasurement]| frame_ms(&round[high]) - frame_ms(&round[i]);
        rows.push(row(Part::Effect, name, &saved, high));
    }
    rows
}

/// Runs `windfall bench picture`.
pub fn run(args: &Args) -> anyhow::Result<()> {
    if args.frames == 0 {
        bail!("--frames is at least 1");
    }
    let names: Vec<&str> = if args.scenes.is_empty() && args.pops {
        Species::ALL.iter().map(|species| species.name()).collect()
    } else if args.scenes.is_empty() {
        NAMES.to_vec()
    } else {
        args.scenes.iter().map(String::as_str).collect()
    };
    let mut gpu = Gpu::open()?;
    println!("{}, {}x{}", gpu.adapter, args.size.0, args.size.1);
    let harness = Harness::new(&gpu, args.size)?;
    let mut all = Vec::new();
    let mut timestamps = false;
    for name in names {
        if args.pops {
            println!("{name}");
            let (scene, stage) = pops::scene(name)?;
            let mut planted = harness.upload(&gpu, &stage)?;
            let of = (&scene, &stage);
            pops::measure(&mut gpu, &harness.renderer, &mut planted, of, args.size)?;
            continue;
        }
        let scene = named(name).with_context(|| format!("{name}: no built-in scene"))?;
        let built = scene.build(|file, _| -> Result<_, Infallible> {
            unreachable!("built-in scenes have no files: {file}")
        });
        let Ok(stage) = built;
        let mut planted = harness.upload(&gpu, &stage)?;
        if args.crawl {
            let frames = args.frames + 1;
            let crawl = crawl::measure(
                &mut gpu,
                &harness.renderer,
                &mut planted,
                (&scene, &stage),
                args.size,
                frames,
            )?;
            println!("{name}: {crawl:.2}");
            continue;
        }
        let variants = variants(&scene.view(scene.time, &stage.forest.terrain), args.effects);
        let mut rounds = Vec::new();
        // Pipelines compile in the first round, which is not measured.
        for round in 0..=args.frames {
            let frames = variants
                .iter()
                .map(|view| harness.measure(&mut gpu, &mut planted, (scene.time, view)));
            let frames = frames.collect::<anyhow::Result<Vec<_>>>()?;
            timestamps |= frames.iter().any(|f| f.gpu_ms.contains_key("frame"));
            if round > 0 {
                rounds.push(frames);
            }
        }
        println!("{name}: ms on the GPU, median (quartiles)");
        let mut part = None;
        for row in rows(name, &rounds) {
            if part.replace(row.part) != Some(row.part) {
                println!(
                    "  {}",
                    match row.part {
                        Part::Preset => "frame of a preset, and over low",
                        Part::Pass => "passes of high by timestamps, and share of the frame",
                        Part::Effect => "effects of high by switching them off, and share",
                    }
                );
            }
            println!("    {:<30} {:>30} {:>24}", row.name, row.gpu_ms, row.ratio);
            all.push(row);
        }
    }
    if let Some(path) = &args.json {
        let report =
            Report { adapter: gpu.adapter.clone(), size: args.size, timestamps, rows: all };
        write_json(path, &report)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use std::collections::BTreeMap;
    use windfall_gpu::{Camera, Light};

    fn view() -> View {
        View::new(Camera::look_at(DVec3::ZERO, DVec3::X, 1.0, 0.1))
    }

    /// This does not compile with a new field of [`Quality`] until the field has a switch.
    #[test]
    fn each_effect_of_the_highest_preset_has_a_row() {
        let mut off = view();
        // All but the last, which switches all of them off.
        for (_, switch) in &EFFECTS[..EFFECTS.len() - 1] {
            let mut one = view();
            switch(&mut one);
            assert!(one != view(), "a switch changes nothing");
            switch(&mut off);
        }
        let high = Quality::HIGH;
        let Quality {
            shadow_size,
            shadow_taps,
            soft_shadows,
            sway,
            pixel_lighting,
            veins,
            gloss,
            transmission,
            ambient_occlusion,
            ground_detail,
            bark_relief,
            grass,
            backdrop,
            resolve_filter,
            resolution,
        } = off.quality;
        assert!(shadow_size < high.shadow_size && shadow_taps < high.shadow_taps);
        assert!(resolution < high.resolution);
        let on = [soft_shadows, sway, pixel_lighting, veins, gloss, transmission];
        let also = [ambient_occlusion, ground_detail, bark_relief, grass, backdrop, resolve_filter];
        assert!(!on.contains(&true) && !also.contains(&true));
        let Light::Sky(sky, None) = off.light else { panic!("{:?}", off.light) };
        assert!(!off.shadows && sky.haze == 0.0 && sky.clouds == 0.0);
    }

    #[test]
    fn an_effect_costs_what_a_frame_takes_less_without_it() {
        let frame = |ms: f64| FrameMeasurement {
            wall_ms: 99.0,
            cpu_ms: 1.0,
            gpu_ms: BTreeMap::from([("frame".to_owned(), ms), ("sky".to_owned(), 0.1 * ms)]),
            counts: Default::default(),
        };
        let variants = variants(&view(), true).len();
        let rounds: Vec<Vec<FrameMeasurement>> = [10.0, 20.0, 60.0]
            .map(|high| {
                let without = (0..variants - 3).map(|i| frame(high - i as f64));
                [5.0, 8.0, high].map(frame).into_iter().chain(without).collect()
            })
            .into();
        let rows = rows("s", &rounds);
        let of = |part| rows.iter().filter(move |r| r.part == part).collect::<Vec<_>>();
        assert_eq!(of(Part::Preset)[2].gpu_ms.median, 20.0);
        assert_eq!(of(Part::Preset)[2].ratio.median, 4.0);
        let passes = of(Part::Pass);
        assert_eq!((passes.len(), passes[0].name.as_str()), (1, "sky"));
        assert!((passes[0].ratio.median - 0.1).abs() < 1e-9);
        let effects = of(Part::Effect);
        assert_eq!(effects.len(), EFFECTS.len());
        assert_eq!((effects[3].gpu_ms.low, effects[3].gpu_ms.high), (3.0, 3.0));
        assert_eq!(effects[3].ratio.median, 0.15);
    }
}
