//! `windfall bench picture`: what the presets of quality and single effects cost.
//!
//! Effects inside a shader have no timestamps of their own, and drivers that work by tiles give none
//! worth having to a draw inside a pass either: each effect is switched off by itself, frame by frame
//! in turn with the whole picture, and what a frame takes less is its row.

use super::Spread;
use super::crawl;
use super::stand::{Easel, Measured};
use crate::gpu::Gpu;
use crate::render::parse_size;
use anyhow::{Context, bail};
use serde::Serialize;
use std::collections::BTreeSet;
use std::convert::Infallible;
use std::path::PathBuf;
use windfall_gpu::{Quality, Sky, View};
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
    /// Measure each effect of the highest preset too, by switching it off
    #[arg(long)]
    effects: bool,
    /// Measure instead how restless edges are: the change from frame to frame over that of
    /// supersampled frames, while the camera walks
    #[arg(long, conflicts_with_all = ["effects", "json"])]
    crawl: bool,
    /// Also write the numbers to this file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Serialize)]
struct Report {
    adapter: String,
    size: (u32, u32),
    /// Whether the times are the GPU's own; else they are wall times of whole frames.
    timestamps: bool,
    rows: Vec<Row>,
}

#[derive(Serialize)]
struct Row {
    scene: String,
    part: Part,
    name: String,
    /// Of a frame; of a pass in it; of what an effect adds to it.
    gpu_ms: Spread,
    /// Of a preset over the lowest of the same round; of a pass or an effect its share of the frame.
    ratio: Spread,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum Part {
    Preset,
    /// By timestamps, at the highest preset.
    Pass,
    /// By switching it off, at the highest preset.
    Effect,
}

/// A change of the view that switches an effect off.
type Switch = fn(&mut View);

/// Each effect of the highest preset, with its switch.
const EFFECTS: [(&str, Switch); 18] = [
    ("shadows", |v| v.shadows = false),
    ("shadow maps of 2048, not 1024", |v| v.quality.shadow_size = 1024),
    ("12 shadow samples, not 4", |v| (v.quality.shadow_taps, v.quality.penumbrae) = (4, false)),
    ("penumbrae", |v| v.quality.penumbrae = false),
    ("sway", |v| v.quality.sway = false),
    ("lighting of leaves in pixels", |v| v.quality.pixel_lighting = false),
    ("veins", |v| v.quality.veins = false),
    ("gloss", |v| v.quality.gloss = false),
    ("transmission", |v| v.quality.transmission = false),
    ("openness", |v| v.quality.openness = false),
    ("ground detail", |v| v.quality.ground_detail = false),
    ("bark relief", |v| v.quality.bark_relief = false),
    ("grass", |v| v.quality.grass = false),
    ("backdrop", |v| v.quality.backdrop = false),
    ("reconstruction", |v| v.quality.reconstruction = false),
    ("aerial perspective", |v| v.sky.haze = 0.0),
    ("clouds", |v| v.sky.clouds = 0.0),
    ("all of them", |v| {
        let Sky { haze, clouds, .. } = &mut v.sky;
        (*haze, *clouds, v.shadows, v.quality) = (0.0, 0.0, false, BARE);
    }),
];

/// Without any effect.
const BARE: Quality = Quality {
    shadow_size: 256,
    shadow_taps: 1,
    sway: false,
    transmission: false,
    openness: false,
    backdrop: false,
    ..Quality::LOW
};

/// The views of a round: each preset, then the highest without each effect.
fn kinds(view: &View, effects: bool) -> Vec<View> {
    let presets = Quality::PRESETS.map(|(_, quality)| View { quality, ..*view });
    let switched = EFFECTS.map(|(_, switch)| {
        let mut view = View { quality: Quality::HIGH, ..*view };
        switch(&mut view);
        view
    });
    presets.into_iter().chain(switched.into_iter().filter(|_| effects)).collect()
}

/// Milliseconds on the GPU; without its timestamps those until it was done.
fn time(frame: &Measured) -> f64 {
    frame.gpu.get("frame").copied().unwrap_or(frame.wall)
}

/// The rows of a scene from its rounds, each as [`kinds`] has them.
fn rows(scene: &str, rounds: &[Vec<Measured>]) -> Vec<Row> {
    let column = |value: &dyn Fn(&[Measured]) -> f64| {
        Spread::of(&rounds.iter().map(|round| value(round)).collect::<Vec<_>>())
    };
    let row = |part, name: &str, gpu_ms: &dyn Fn(&[Measured]) -> f64, over: usize| Row {
        scene: scene.to_owned(),
        part,
        name: name.to_owned(),
        gpu_ms: column(gpu_ms),
        ratio: column(&|round| gpu_ms(round) / time(&round[over])),
    };
    let presets = Quality::PRESETS.len();
    let high = presets - 1;
    let mut rows = Vec::new();
    for (i, (name, _)) in Quality::PRESETS.iter().enumerate() {
        rows.push(row(Part::Preset, name, &|round| time(&round[i]), 0));
    }
    let passes: BTreeSet<&str> =
        rounds.iter().flat_map(|r| r[high].gpu.keys()).map(String::as_str).collect();
    for name in passes.into_iter().filter(|name| *name != "frame") {
        let pass = |round: &[Measured]| round[high].gpu.get(name).copied().unwrap_or(f64::NAN);
        rows.push(row(Part::Pass, name, &pass, high));
    }
    let measured = rounds.first().map_or(0, Vec::len);
    for (i, (name, _)) in (presets..measured).zip(EFFECTS) {
        let saved = |round: &[Measured]| time(&round[high]) - time(&round[i]);
        rows.push(row(Part::Effect, name, &saved, high));
    }
    rows
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
    let mut all = Vec::new();
    let mut timestamps = false;
    for name in names {
        let scene = named(name).with_context(|| format!("{name}: no built-in scene"))?;
        let built = scene.build(|file, _| -> Result<_, Infallible> {
            unreachable!("built-in scenes have no files: {file}")
        });
        let Ok(stage) = built;
        let forest = easel.forest(&gpu, &stage, &stage.falls);
        if args.crawl {
            let of = (&scene, &stage);
            let frames = args.frames + 1;
            let crawl = crawl::measure(&mut gpu, &easel.renderer, &forest, of, args.size, frames)?;
            println!("{name}: {crawl:.2}");
            continue;
        }
        let kinds = kinds(&scene.view(scene.time, &stage.forest.terrain), args.effects);
        let mut rounds = Vec::new();
        // In the first round pipelines compile: it is not measured.
        for round in 0..=args.frames {
            let frames = kinds.iter().map(|view| easel.frame(&mut gpu, &forest, view));
            let frames = frames.collect::<anyhow::Result<Vec<_>>>()?;
            timestamps |= frames.iter().any(|f| f.gpu.contains_key("frame"));
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
        let text = serde_json::to_string_pretty(&report)?;
        std::fs::write(path, text).with_context(|| format!("{}", path.display()))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use std::collections::BTreeMap;
    use windfall_gpu::Camera;

    fn view() -> View {
        let (eye, target) = (Vec3::ZERO, Vec3::X);
        View::new(Camera { eye, target, fov_y: 1.0, near: 0.1 })
    }

    /// A new field of [`Quality`] does not compile here until it has its switch.
    #[test]
    fn each_effect_of_the_highest_preset_has_a_row() {
        let mut off = view();
        // All but the last, which is all of them.
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
            penumbrae,
            sway,
            pixel_lighting,
            veins,
            gloss,
            transmission,
            openness,
            ground_detail,
            bark_relief,
            grass,
            backdrop,
            reconstruction,
        } = off.quality;
        assert!(shadow_size < high.shadow_size && shadow_taps < high.shadow_taps);
        let on =
            [penumbrae, sway, pixel_lighting, veins, gloss, transmission, openness, ground_detail];
        let also = [bark_relief, grass, backdrop, reconstruction];
        assert!(!on.contains(&true) && !also.contains(&true));
        assert!(!off.shadows && off.sky.haze == 0.0 && off.sky.clouds == 0.0);
    }

    #[test]
    fn an_effect_costs_what_a_frame_takes_less_without_it() {
        let frame = |ms: f64| Measured {
            wall: 99.0,
            cpu: 1.0,
            gpu: BTreeMap::from([("frame".to_owned(), ms), ("sky".to_owned(), 0.1 * ms)]),
            stats: Default::default(),
            counts: Default::default(),
        };
        let kinds = kinds(&view(), true).len();
        let rounds: Vec<Vec<Measured>> = [10.0, 20.0, 60.0]
            .map(|high| {
                let without = (0..kinds - 3).map(|i| frame(high - i as f64));
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
