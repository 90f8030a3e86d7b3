//! `windfall bench falling`: what falling leaves cost (VB 6.3 and beyond).

use super::bare::Bare;
use super::plots::{self, Line};
use super::soak::{self, Soak};
use super::stand::{Easel, Measured};
use super::{Spread, line};
use crate::gpu::Gpu;
use crate::render::parse_size;
use anyhow::{Context, bail};
use glam::Vec3;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use windfall_core::forest::{Placement, Terrain};
use windfall_core::shed::Shedding;
use windfall_core::simplify::{Simplification, simple_shapes};
use windfall_core::tree::Tree;
use windfall_core::tree::species::Species;
use windfall_gpu::{Camera, Elimination, Falls, GpuForest, Quality, Strategy, View};
use windfall_scenes::Stage;

/// Frames drawn before any is measured: pipelines compile, lists are built.
const WARM_UP: u32 = 3;
/// Frames of the whole walk (VB: "more than 3000").
const WALK: f32 = 3000.0;

/// Arguments of `windfall bench falling`.
#[derive(clap::Args)]
pub struct Args {
    /// Parts to run: a (VB's scene, each strategy), b (a million leaves), c (cost against count)
    #[arg(long, value_name = "abc", default_value = "abc")]
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
    start: f32,
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
    soak: Option<Soak>,
}

#[derive(Serialize)]
struct StrategyRow {
    /// That it was measured with, in turns.
    strategy: String,
    name: String,
    wall_ms: Spread,
    gpu_ms: Spread,
    /// Against the frame of the same moment with as many leaves on the twigs, and no others.
    ratio: Spread,
    /// Against the frame of the same moment in which all leaves hang, as VB compare.
    ratio_to_full: Spread,
    /// Frames at the end over frames at the beginning, fifths of the run.
    drift: f64,
    /// Leaves in the air and on the ground in the last frame; of those, in the CPU's list.
    falling: u64,
    landed: u64,
    listed: u64,
    /// Of the last frame.
    tested: u32,
    skipped: u32,
    /// Medians of the passes on the GPU, milliseconds.
    passes_ms: BTreeMap<String, f64>,
    /// Milliseconds of each frame, wall clock.
    frames_ms: Vec<f64>,
}

#[derive(Serialize)]
struct Many {
    leaves: u64,
    copy_ms: Spread,
    pose_ms: Spread,
    /// Of the leaves that leave their twigs, settle or vanish.
    change_ms: Spread,
    pose_over_copy: f64,
    bare_draw_ms: Spread,
    /// The same leaves in the two triangles that small ones are drawn in.
    bare_simple_ms: Spread,
    frame_ms: Spread,
    frame_without_ms: Spread,
    leaves_over_bare_draw: f64,
    leaves_over_bare_simple: f64,
    slot_bytes: u32,
    draw_bytes: u32,
}

#[derive(Serialize)]
struct Counts {
    /// Leaves, pose pass, whole frame.
    points: Vec<(u64, f64, f64)>,
    pose_ns_per_leaf: f64,
    pose_r2: f64,
    frame_ns_per_leaf: f64,
    frame_r2: f64,
}

impl Args {
    /// When a frame of part a is, warming up included.
    fn seconds(&self, frame: u32) -> f32 {
        self.start + (frame * self.stride) as f32 / 30.0
    }
}

/// Runs `windfall bench falling`.
pub fn run(args: &Args) -> anyhow::Result<()> {
    if args.frames == 0 || args.parts.chars().any(|c| !"abc".contains(c)) {
        bail!("--parts is of a, b and c, and --frames at least 1");
    }
    let mut gpu = Gpu::open()?;
    println!("{}, {}x{}", gpu.adapter, args.size.0, args.size.1);
    let easel = Easel::new(&gpu, args.size);
    let mut report = Report { adapter: gpu.adapter.clone(), size: args.size, ..Report::default() };
    if args.parts.contains('a') {
        report.strategies = strategies(args, &mut gpu, &easel)?;
    }
    if args.parts.contains('b') {
        report.many = Some(many(args, &mut gpu, &easel)?);
    }
    if args.parts.contains('c') {
        report.counts = Some(counts(args, &mut gpu, &easel)?);
    }
    if args.soak > 0 {
        report.soak = Some(soak::run(args.soak, args.soak_leaves, &mut gpu)?);
    }
    if let Some(folder) = &args.plots {
        plot(folder, args, &report)?;
    }
    if let Some(path) = &args.json {
        let text = serde_json::to_string_pretty(&report)?;
        std::fs::write(path, text).with_context(|| format!("{}", path.display()))?;
    }
    Ok(())
}

/// VB's Figure 6 from part a, and the cost against the count from part c.
fn plot(folder: &Path, args: &Args, report: &Report) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("{}", folder.display()))?;
    let write = |name: &str, svg: String| {
        let path = folder.join(name);
        std::fs::write(&path, svg).with_context(|| format!("{}", path.display()))
    };
    for rows in report.strategies.chunk_by(|a, b| a.strategy == b.strategy) {
        let lines = rows.iter().map(|row| Line {
            name: row.name.clone(),
            points: row
                .frames_ms
                .iter()
                .enumerate()
                .map(|(i, &ms)| (f64::from(args.seconds(WARM_UP + i as u32)), ms))
                .collect(),
        });
        let strategy = &rows[0].strategy;
        let title = format!("Frame cost over the walk, {strategy}");
        let svg = plots::lines(&title, "s", "ms", &lines.collect::<Vec<_>>(), false)?;
        write(&format!("walk-{strategy}.svg"), svg)?;
    }
    if let Some(counts) = &report.counts {
        let line = |name: &str, get: fn(&(u64, f64, f64)) -> f64| Line {
            name: name.to_owned(),
            points: counts.points.iter().map(|p| (p.0 as f64, get(p))).collect(),
        };
        let lines = [line("pose pass", |p| p.1), line("whole frame", |p| p.2)];
        let title = "Cost against leaves in the air, logarithmic";
        write("counts.svg", plots::lines(title, "leaves", "ms", &lines, true)?)?;
    }
    Ok(())
}

/// Seven trees, 800 thousand triangles (VB 6.3).
fn grove() -> Stage {
    let species: [Species; 4] = [Species::Maple, Species::Oak, Species::Birch, Species::Beech];
    let trees: Vec<Tree> = species.iter().map(|s| s.grow_with(1, 7400)).collect();
    let placement = Placement {
        trees: 7,
        spacing: 7.0,
        keep_out: Vec::new(),
        scale: (0.9, 1.1),
        season_spread: 0.1,
        seed: 5,
    };
    let weights = vec![1.0; trees.len()];
    let mut falls = Falls::default();
    falls.groups = trees.iter().map(|t| falls.group_for(t)).collect();
    let forest = placement.place(Terrain::rolling(200.0, 2.0, 3), &weights);
    Stage { trees, forest, falls }
}

fn view(eye: Vec3, target: Vec3, time: f32) -> View {
    View {
        time,
        season: 0.55,
        meadow: 0.5,
        trails: Default::default(),
        shadows: false,
        // All leaves, as they are drawn by default: small ones in two triangles.
        detail: Simplification { h: 0.0, wood_pixels: 0.0, ..Simplification::DEFAULT },
        quality: Quality::LOW,
        ..View::new(Camera { eye, target, fov_y: 0.9, near: 0.1 })
    }
}

/// Once around the trees in [`WALK`] frames, thirty a second.
fn walk(stage: &Stage, time: f32) -> View {
    let angle = time * 30.0 / WALK * std::f32::consts::TAU;
    let (x, z) = (21.0 * angle.sin(), 21.0 * angle.cos());
    let eye = Vec3::new(x, stage.forest.terrain.height(x, z) + 1.7, z);
    view(eye, Vec3::new(0.0, 5.5, 0.0), time)
}

/// Medians of the passes.
fn medians(measured: &[Measured]) -> BTreeMap<String, f64> {
    let names = measured.iter().flat_map(|m| m.gpu.keys());
    let median = |name: &String| {
        let times: Vec<f64> = measured.iter().filter_map(|m| m.gpu.get(name).copied()).collect();
        Spread::of(&times).median
    };
    names.map(|name| (name.clone(), median(name))).collect()
}

/// What a strategy is measured with: elimination, and leaf occlusion (VB 6.3).
fn kinds_of(strategy: Strategy, occlusion: bool) -> Vec<(Elimination, bool)> {
    let mut kinds = match strategy {
        Strategy::Compute => vec![(Elimination::Scheduled, false), (Elimination::Scheduled, true)],
        _ => vec![
            (Elimination::Scheduled, false),
            (Elimination::Scheduled, true),
            (Elimination::PROGRESSIVE, false),
            (Elimination::Off, false),
            (Elimination::Off, true),
        ],
    };
    kinds.retain(|&(_, needs)| occlusion || !needs);
    kinds
}

fn strategies(args: &Args, gpu: &mut Gpu, easel: &Easel) -> anyhow::Result<Vec<StrategyRow>> {
    let mut stage = grove();
    let rate = match args.throw_rate {
        Some(rate) => {
            stage.throw(rate, 0.0);
            rate
        }
        None => stage.keep_falling(args.falling),
    };
    println!("\n(a) {} leaves of 7 trees, {rate:.0} thrown a second", stage.leaf_count());
    println!(
        "{} frames of each from {} s on, in turns; medians (quartiles), ms; wall clock from the \
         first call to the end of the GPU's work, and timestamps",
        args.frames, args.start
    );
    println!(
        "cost: over the same trees with the same leaves on their twigs and none that have left them; \
         over full: over trees that keep all their leaves"
    );
    println!(
        "{:<48}{:>26}{:>26}{:>18}{:>18}{:>7}{:>8}{:>8}{:>8}",
        "", "wall", "GPU", "cost", "over full", "drift", "listed", "tested", "skipped"
    );
    let mut rows = Vec::new();
    // One strategy after the other, each beside the trees alone: the more pipelines are in use at a
    // time, the more of them a driver may drop and make again in each frame.
    for &strategy in &args.strategies {
        // The trees alone, as bare as they are, and in full; drawn as this strategy draws trees: those
        // without compute list them on the CPU, and light each vertex of a hanging leaf.
        let bare = Falls { capacity: 0, strategy, ..stage.falls.clone() };
        let full = Falls { strategy, ..Falls::none() };
        let mut kinds: Vec<(String, GpuForest)> = vec![
            ("none moving, none loose".to_owned(), easel.forest(gpu, &stage, &bare)),
            ("none moving, in full".to_owned(), easel.forest(gpu, &stage, &full)),
        ];
        for (elimination, leaf_occlusion) in kinds_of(strategy, gpu.fragment_stores) {
            let falls = Falls { strategy, elimination, leaf_occlusion, ..stage.falls.clone() };
            let name = match strategy {
                Strategy::Compute => strategy.to_string(),
                _ => format!("{strategy}, elimination {elimination}"),
            };
            let name = if leaf_occlusion { name + ", occlusion" } else { name };
            kinds.push((name, easel.forest(gpu, &stage, &falls)));
        }
        let mut frames: Vec<Vec<_>> = kinds.iter().map(|_| Vec::new()).collect();
        for frame in 0..WARM_UP + args.frames {
            let seconds = args.seconds(frame);
            let view = walk(&stage, seconds);
            for (kind, measured) in kinds.iter().zip(&mut frames) {
                if args.stride > 1 {
                    // As much has changed since as from one frame of the walk to the next.
                    easel.frame(gpu, &kind.1, &walk(&stage, seconds - 1.0 / 30.0))?;
                }
                let result = easel.frame(gpu, &kind.1, &view)?;
                if frame >= WARM_UP {
                    measured.push(result);
                }
            }
        }
        let [still, full] = [0, 1].map(|k| frames[k].iter().map(|m| m.wall).collect::<Vec<f64>>());
        rows.extend(
            kinds.into_iter().zip(&frames).map(|(kind, measured)| {
                StrategyRow::new(strategy, kind.0, measured, [&still, &full])
            }),
        );
    }
    Ok(rows)
}

impl StrategyRow {
    /// Of measured frames, and those of the same moments in which no leaf moves; prints it.
    fn new(
        strategy: Strategy,
        name: String,
        measured: &[Measured],
        [still, full]: [&[f64]; 2],
    ) -> Self {
        let wall: Vec<f64> = measured.iter().map(|m| m.wall).collect();
        let on_gpu: Vec<f64> =
            measured.iter().filter_map(|m| m.gpu.get("frame").copied()).collect();
        let over = |of: &[f64]| wall.iter().zip(of).map(|(a, b)| a / b).collect::<Vec<f64>>();
        let ratios = over(still);
        let fifth = (ratios.len() / 5).max(1);
        let drift = Spread::of(&ratios[ratios.len() - fifth..]).median
            / Spread::of(&ratios[..fifth]).median;
        let last = &measured[measured.len() - 1];
        let (stats, counts) = (&last.stats, &last.counts);
        let row = Self {
            strategy: strategy.to_string(),
            name,
            wall_ms: Spread::of(&wall),
            gpu_ms: Spread::of(&on_gpu),
            ratio: Spread::of(&ratios),
            ratio_to_full: Spread::of(&over(full)),
            drift,
            falling: stats.leaves_falling + u64::from(counts.falling),
            landed: stats.leaves_landed + u64::from(counts.landed),
            listed: stats.leaves_falling + stats.leaves_landed - stats.leaves_eliminated,
            tested: counts.tested,
            skipped: counts.skipped,
            passes_ms: medians(measured),
            frames_ms: wall,
        };
        println!(
            "{:<48}{:>26}{:>26}{:>18}{:>18}{:>7.2}{:>8}{:>8}{:>8}",
            row.name,
            row.wall_ms,
            row.gpu_ms,
            row.ratio,
            row.ratio_to_full,
            row.drift,
            row.listed,
            row.tested,
            row.skipped
        );
        row
    }
}

/// `count` leaves of one shape, thrown between four and two seconds before time 0: nearly all in the air.
fn shower(count: u32) -> Stage {
    let of_tree = count.min(1 << 16);
    let trees = vec![Species::Beech.grow_with(3, of_tree)];
    let placement = Placement {
        trees: (count / of_tree).max(1),
        spacing: 6.0,
        keep_out: Vec::new(),
        scale: (1.0, 1.0),
        season_spread: 0.0,
        seed: 7,
    };
    let mut falls = Falls {
        shedding: Shedding { start: -4.0, duration: 2.0, peak: 0.0, tree_spread: 0.0, burst: 0.0 },
        capacity: count,
        ..Falls::default()
    };
    falls.groups = trees.iter().map(|t| falls.group_for(t)).collect();
    Stage { forest: placement.place(Terrain::flat(), &[1.0]), trees, falls }
}

/// A view of the whole shower.
fn overview(stage: &Stage, time: f32) -> View {
    let far = stage.forest.instances.iter().map(|i| i.position.length()).fold(0.0, f32::max);
    view(Vec3::new(0.0, 12.0, 1.6 * far + 24.0), Vec3::new(0.0, 6.0, 0.0), time)
}

fn many(args: &Args, gpu: &mut Gpu, easel: &Easel) -> anyhow::Result<Many> {
    let stage = shower(args.many);
    let falling = easel.forest(gpu, &stage, &stage.falls);
    // The same bare trees without the leaves that have left them.
    let without = easel.forest(gpu, &stage, &Falls { capacity: 0, ..stage.falls.clone() });
    let view = overview(&stage, 0.0);
    let far = stage.forest.instances.iter().map(|i| i.position.length()).fold(4.0, f32::max);
    let bounds = (Vec3::new(-far, 0.0, -far), Vec3::new(far, 14.0, far));
    let aspect = args.size.0 as f32 / args.size.1 as f32;
    let count = stage.leaf_count() as u32;
    let clip = view.camera.clip_from_world(aspect);
    let foliage = &stage.trees[0].foliage;
    let simple = simple_shapes(foliage).into_iter().next().flatten();
    let simple = simple.context("the species' leaf has no simple shape")?;
    let [bare, bare_simple] = [&foliage.shapes[0], &simple]
        .map(|shape| Bare::new(gpu, count, shape, bounds, clip, args.size));
    let (mut copy, mut pose, mut change) = (Vec::new(), Vec::new(), Vec::new());
    let (mut draw, mut draw_simple) = (Vec::new(), Vec::new());
    let (mut frame, mut rest) = (Vec::new(), Vec::new());
    for i in 0..WARM_UP + args.frames {
        let (copied, drawn) = bare.measure(gpu)?;
        let (_, drawn_simple) = bare_simple.measure(gpu)?;
        let whole = easel.frame(gpu, &falling, &view)?;
        let bald = easel.frame(gpu, &without, &view)?;
        if i >= WARM_UP {
            copy.push(copied);
            draw.push(drawn);
            draw_simple.push(drawn_simple);
            pose.push(whole.gpu.get("pose").copied().unwrap_or(f64::NAN));
            change.push(whole.gpu.get("change").copied().unwrap_or(f64::NAN));
            frame.push(whole.wall);
            rest.push(bald.wall);
        }
    }
    let [copy_ms, pose_ms, change_ms, bare_draw_ms, bare_simple_ms] =
        [&copy, &pose, &change, &draw, &draw_simple].map(|v| Spread::of(v));
    let [frame_ms, frame_without_ms] = [&frame, &rest].map(|v| Spread::of(v));
    let of_leaves = frame_ms.median - frame_without_ms.median;
    let many = Many {
        leaves: u64::from(count),
        pose_over_copy: (pose_ms.median + change_ms.median) / copy_ms.median,
        leaves_over_bare_draw: of_leaves / bare_draw_ms.median,
        leaves_over_bare_simple: of_leaves / bare_simple_ms.median,
        copy_ms,
        pose_ms,
        change_ms,
        bare_draw_ms,
        bare_simple_ms,
        frame_ms,
        frame_without_ms,
        slot_bytes: Falls::STATE_BYTES as u32,
        draw_bytes: 32,
    };
    println!(
        "\n(b) {} leaves in the air, compute; medians (quartiles) of {} frames, ms",
        count, args.frames
    );
    println!("copy of 32 bytes a leaf, wall clock      {}", many.copy_ms);
    println!(
        "pose pass, GPU clock                     {}   with the next {:.2} x copy",
        many.pose_ms, many.pose_over_copy
    );
    println!("pass of leaves that change, GPU clock    {}", many.change_ms);
    println!("bare instanced draw, wall clock          {}", many.bare_draw_ms);
    println!("the same in two triangles a leaf         {}", many.bare_simple_ms);
    println!("whole frame, wall clock                  {}", many.frame_ms);
    println!("the same frame without those leaves      {}", many.frame_without_ms);
    println!(
        "the leaves' part over the bare draws     {:.2}, {:.2}",
        many.leaves_over_bare_draw, many.leaves_over_bare_simple
    );
    println!(
        "memory a leaf: {} bytes of state; of a frame 4 to list it if it changes, 32 to draw it",
        Falls::STATE_BYTES
    );
    Ok(many)
}

fn counts(args: &Args, gpu: &mut Gpu, easel: &Easel) -> anyhow::Result<Counts> {
    println!("\n(c) cost against count, compute; medians of {} frames", args.frames);
    println!("{:>10}{:>14}{:>16}", "leaves", "pose, GPU ms", "frame, wall ms");
    let mut points = Vec::new();
    // Where the adapter binds no buffer of so many slots, as many as it does, in whole trees.
    let limit = gpu.device.limits().max_storage_buffer_binding_size;
    let most = args.most.min(((limit / Falls::STATE_BYTES) >> 16 << 16) as u32);
    let mut count = 1 << 10;
    while count <= most {
        let stage = shower(count);
        let forest = easel.forest(gpu, &stage, &stage.falls);
        let view = overview(&stage, 0.0);
        let (mut pose, mut frame) = (Vec::new(), Vec::new());
        for i in 0..WARM_UP + args.frames {
            let measured = easel.frame(gpu, &forest, &view)?;
            if i >= WARM_UP {
                pose.push(measured.gpu.get("pose").copied().unwrap_or(f64::NAN));
                frame.push(measured.wall);
            }
        }
        let (pose, frame) = (Spread::of(&pose).median, Spread::of(&frame).median);
        println!("{count:>10}{pose:>14.3}{frame:>16.2}");
        points.push((u64::from(count), pose, frame));
        count = if count < most { most.min(count * 4) } else { u32::MAX };
    }
    let of = |get: fn(&(u64, f64, f64)) -> f64| {
        let xy: Vec<(f64, f64)> = points.iter().map(|p| (p.0 as f64, get(p))).collect();
        let (_, slope, r2) = line(&xy);
        (slope * 1e6, r2)
    };
    let ((pose_ns, pose_r2), (frame_ns, frame_r2)) = (of(|p| p.1), of(|p| p.2));
    println!(
        "pose: {pose_ns:.1} ns a leaf (R2 {pose_r2:.4}); frame: {frame_ns:.1} ns (R2 {frame_r2:.4})"
    );
    Ok(Counts { points, pose_ns_per_leaf: pose_ns, pose_r2, frame_ns_per_leaf: frame_ns, frame_r2 })
}
