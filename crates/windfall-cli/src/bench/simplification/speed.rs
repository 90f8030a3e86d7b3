//! Parts a and b: frame time over `h`, and culling.

use super::plain::Plain;
use super::stands::{
    across, all_trees, amid, away, bald, lambda_total, leaves_in_world, paper, plant, ring, seen,
    solve, vertices, within,
};
use super::{Args, WARM_UP};
use crate::bench::Spread;
use crate::bench::stand::Easel;
use crate::gpu::Gpu;
use anyhow::anyhow;
use plotters::prelude::*;
use serde::Serialize;
use windfall_core::simplify::Simplification;
use windfall_core::tree::Tree;
use windfall_core::tree::species::{Species, papers10};
use windfall_gpu::{Culling, GpuForest, Show, View};
use windfall_scenes::Stage;

/// Values of `h` of SFS, figure 5.
pub const HS: [f32; 10] = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];

/// The picture of part b's ring of trees.
const RING_SIZE: (u32, u32) = (160, 120);

/// Part a.
#[derive(Serialize)]
pub struct Forest {
    trees: usize,
    trees_in_view: usize,
    vertices_in_view: f64,
    d0: f32,
    rows: Vec<HRow>,
    leaf: LeafCost,
}

#[derive(Serialize)]
struct HRow {
    h: f32,
    lambda_total: f64,
    triangles: u64,
    wall_ms: Spread,
    faster: f64,
}

/// What is plotted of a row.
type OfRow = fn(&HRow) -> f64;

/// What a drawn leaf costs.
#[derive(Serialize)]
struct LeafCost {
    h: f32,
    leaves: u64,
    with_ms: Spread,
    bald_ms: Spread,
    plain_ms: Spread,
    empty_ms: Spread,
    ours_ns: f64,
    plain_ns: f64,
    ratio: f64,
}

/// The paper's forest: up to 1,000 instances of ten models, and its figure 5.
pub fn forest(args: &Args, gpu: &mut Gpu, easel: &Easel) -> anyhow::Result<Forest> {
    let stage = plant(papers10().to_vec(), 1000);
    let none = Simplification::NONE;
    let wanted = args.vertices * 1e6;
    let fov = solve(0.05, 2.5, wanted, |f| vertices(&stage, &across(&stage, f, none), args.size));
    let view = |detail| across(&stage, fov, detail);
    let in_view = seen(&stage, &view(none), args.size).len();
    let d0 = solve(1.0, 400.0, 0.06, |d0| lambda_total(&stage, &view(paper(0.7, d0)), args.size));
    let vertices_in_view = vertices(&stage, &view(none), args.size);
    println!(
        "\n(a) {} trees of papers10, {in_view} in view with {:.1} M vertices; d0 = {d0:.1} m, so that \
         h = 0.7 draws 6% of the leaves; wall clock of {} frames, ms",
        stage.forest.instances.len(),
        vertices_in_view / 1e6,
        args.frames
    );
    let forest = easel.forest(gpu, &stage, &stage.falls);
    let hs = &args.h;
    let mut walls: Vec<Vec<f64>> = vec![Vec::new(); hs.len()];
    let mut triangles = vec![0; hs.len()];
    for round in 0..WARM_UP + args.frames {
        for (i, &h) in hs.iter().enumerate() {
            // The slowest first frame says nothing: no need to warm up without simplification.
            if h == 0.0 && round == 1 {
                continue;
            }
            let detail = if h == 0.0 { none } else { paper(h, d0) };
            let measured = easel.frame(gpu, &forest, &view(detail))?;
            triangles[i] = measured.counts.trees.triangles;
            if round >= WARM_UP {
                walls[i].push(measured.wall);
            }
        }
    }
    println!(
        "{:>5}{:>10}{:>14}{:>36}{:>10}{:>9}",
        "h", "lambda", "triangles", "frame", "frames/s", "faster"
    );
    let full = Spread::of(&walls[0]).median;
    let rows: Vec<HRow> = hs
        .iter()
        .enumerate()
        .map(|(i, &h)| {
            let wall_ms = Spread::of(&walls[i]);
            let lambda =
                if h == 0.0 { 1.0 } else { lambda_total(&stage, &view(paper(h, d0)), args.size) };
            let faster = full / wall_ms.median;
            println!(
                "{h:>5.1}{lambda:>10.4}{:>14}{wall_ms:>36}{:>10.2}{faster:>9.2}",
                triangles[i],
                1e3 / wall_ms.median
            );
            HRow { h, lambda_total: lambda, triangles: triangles[i], wall_ms, faster }
        })
        .collect();

    // A leaf's own cost: leaves alone, as bare as the same triangles, which nothing else hides either.
    let alone = View { show: Show::Leaves, ..view(paper(0.7, d0)) };
    let (positions, indices, leaves) =
        leaves_in_world(&stage, &alone, seen(&stage, &alone, args.size));
    let aspect = args.size.0 as f32 / args.size.1 as f32;
    let clip = alone.camera.clip_from_world(aspect);
    let plain = Plain::new(gpu, &positions, &indices, clip, args.size);
    drop((positions, indices));
    let without = bald(&stage);
    let without = easel.forest(gpu, &without, &without.falls);
    let mut times: [Vec<f64>; 4] = Default::default();
    for round in 0..WARM_UP + 3 * args.frames {
        let of_round = [
            easel.frame(gpu, &forest, &alone)?.wall,
            easel.frame(gpu, &without, &alone)?.wall,
            plain.measure(gpu, 1.0)?,
            plain.measure(gpu, 0.0)?,
        ];
        if round >= WARM_UP {
            times.iter_mut().zip(of_round).for_each(|(all, time)| all.push(time));
        }
    }
    let [with_ms, bald_ms, plain_ms, empty_ms] = times.map(|t| Spread::of(&t));
    let per_leaf = |a: &Spread, b: &Spread| (a.median - b.median) * 1e6 / leaves.max(1) as f64;
    let (ours_ns, plain_ns) = (per_leaf(&with_ms, &bald_ms), per_leaf(&plain_ms, &empty_ms));
    let leaf = LeafCost {
        h: 0.7,
        leaves,
        with_ms,
        bald_ms,
        plain_ms,
        empty_ms,
        ours_ns,
        plain_ns,
        ratio: ours_ns / plain_ns,
    };
    println!("\n{leaves} leaves at h = 0.7; ms");
    println!("frame of the leaves alone          {with_ms}");
    println!("the same of the forest bald        {bald_ms}");
    println!("the leaves' triangles, bare draw   {plain_ms}");
    println!("nothing, the same targets          {empty_ms}");
    println!("a leaf: {ours_ns:.0} ns, bare {plain_ns:.0} ns: {:.2} x", leaf.ratio);
    Ok(Forest {
        trees: stage.forest.instances.len(),
        trees_in_view: in_view,
        vertices_in_view,
        d0,
        rows,
        leaf,
    })
}

impl Forest {
    /// SFS, figure 5: the total level of detail and frames per second over h.
    pub fn plot(&self) -> anyhow::Result<String> {
        let mut svg = String::new();
        {
            let failed = |e: &dyn std::fmt::Display| anyhow!("cannot draw: {e}");
            let root = SVGBackend::with_string(&mut svg, (900, 420)).into_drawing_area();
            root.fill(&WHITE).map_err(|e| failed(&e))?;
            let (left, right) = root.split_horizontally(450);
            let most = self.rows.iter().map(|r| 1e3 / r.wall_ms.median).fold(0.0, f64::max) * 1.05;
            let panels: [(_, &str, f64, OfRow); 2] = [
                (left, "total level of detail over h", 1.0, |r| r.lambda_total),
                (right, "frames per second over h", most, |r| 1e3 / r.wall_ms.median),
            ];
            for (area, caption, high, of) in panels {
                let mut chart = ChartBuilder::on(&area)
                    .caption(caption, ("sans-serif", 16))
                    .margin(12)
                    .x_label_area_size(30)
                    .y_label_area_size(50)
                    .build_cartesian_2d(0.0..0.9, 0.0..high)
                    .map_err(|e| failed(&e))?;
                chart.configure_mesh().light_line_style(WHITE).draw().map_err(|e| failed(&e))?;
                let points: Vec<(f64, f64)> =
                    self.rows.iter().map(|r| (f64::from(r.h), of(r))).collect();
                let color = RGBColor(190, 90, 20);
                chart
                    .draw_series(LineSeries::new(points.clone(), color.stroke_width(2)))
                    .map_err(|e| failed(&e))?;
                chart
                    .draw_series(points.iter().map(|&p| Circle::new(p, 3, color.filled())))
                    .map_err(|e| failed(&e))?;
            }
            root.present().map_err(|e| failed(&e))?;
        }
        Ok(svg)
    }
}

/// Part b.
#[derive(Serialize)]
pub struct Cullings {
    trees: usize,
    in_view: usize,
    rows: Vec<CullRow>,
    /// A frame each, unsimplified.
    full: Vec<CullRow>,
    away: Vec<CullRow>,
    /// Trees that all cost alike, and the frame in which none is drawn.
    ring: Vec<CullRow>,
    ring_none_ms: Spread,
    ring_bare: BareCulling,
    counts: Vec<CountRow>,
}

#[derive(Serialize)]
struct CullRow {
    culling: String,
    trees_drawn: u64,
    wall_ms: Spread,
    faster: f64,
    /// The same without the time of a frame that draws no tree, where that is known.
    trees_faster: Option<f64>,
}

/// What culling can save at most where the same triangles are drawn without a thought: leaves of all
/// trees, and of those in view.
#[derive(Serialize)]
struct BareCulling {
    all_ms: Spread,
    in_view_ms: Spread,
    faster: f64,
}

impl BareCulling {
    fn measure(args: &Args, gpu: &Gpu, stage: &Stage, view: &View) -> anyhow::Result<Self> {
        let (width, height) = RING_SIZE;
        let clip = view.camera.clip_from_world(width as f32 / height as f32);
        let trees = [all_trees(stage, view, height), seen(stage, view, RING_SIZE)];
        let draws = trees.map(|trees| {
            let (positions, indices, _) = leaves_in_world(stage, view, trees);
            Plain::new(gpu, &positions, &indices, clip, RING_SIZE)
        });
        let mut times: [Vec<f64>; 2] = Default::default();
        for round in 0..WARM_UP + args.frames {
            for (draw, times) in draws.iter().zip(&mut times) {
                let time = draw.measure(gpu, 1.0)?;
                if round >= WARM_UP {
                    times.push(time);
                }
            }
        }
        let [all_ms, in_view_ms] = times.map(|t| Spread::of(&t));
        let faster = all_ms.median / in_view_ms.median;
        println!(
            "bare draws of the same leaves: all {all_ms}, in view {in_view_ms}: {faster:.2} x"
        );
        Ok(Self { all_ms, in_view_ms, faster })
    }
}

#[derive(Serialize)]
struct CountRow {
    trees: u32,
    in_view: u64,
    cpu_ms: Spread,
    cull_gpu_ms: Spread,
    wall_ms: Spread,
}

/// A thousand trees with a tenth in view and with none; the CPU's part over the number of trees.
pub fn culling(args: &Args, gpu: &mut Gpu, easel: &Easel) -> anyhow::Result<Cullings> {
    let stage = plant(papers10().to_vec(), 1000);
    let none = Simplification::NONE;
    let total = stage.forest.instances.len();
    let tenth = total as f64 * 0.1;
    let fov = solve(0.02, 2.5, tenth, |f| seen(&stage, &amid(f, none), args.size).len() as f64);
    let half = paper(0.5, 30.0);
    let view = amid(fov, half);
    let in_view = seen(&stage, &view, args.size).len();
    println!(
        "\n(b) {total} trees of papers10, {in_view} in view, h = 0.5, d0 = 30 m; wall clock of {} \
         frames, ms",
        args.frames
    );
    let forest = easel.forest(gpu, &stage, &stage.falls);
    let rounds = WARM_UP + args.frames;
    let rows = cull_rows(gpu, easel, &forest, &view, &Culling::ALL, rounds, None)?;
    println!("the same, looking away: none in view");
    let away = cull_rows(gpu, easel, &forest, &away(&view), &Culling::ALL, rounds, None)?;
    println!("the first view unsimplified, a frame each");
    let full = View { detail: none, ..view };
    let full = cull_rows(gpu, easel, &forest, &full, &[Culling::Off, Culling::Sphere], 1, None)?;
    drop(forest);

    // What a tree out of view costs shows where it costs as much as one in view: as far away, and in a
    // picture so small that pixels cost little.
    let stage = ring(papers10().to_vec(), 1000);
    let small = Easel::new(gpu, RING_SIZE);
    let aside = |f| within(f, false, half);
    let fov = solve(0.02, 2.5, tenth, |f| seen(&stage, &aside(f), RING_SIZE).len() as f64);
    println!(
        "trees all around, 100 m away, {} in view, {}x{}; in brackets without the frame that draws none",
        seen(&stage, &aside(fov), RING_SIZE).len(),
        RING_SIZE.0,
        RING_SIZE.1
    );
    let forest = small.forest(gpu, &stage, &stage.falls);
    let up = View { culling: Culling::Sphere, ..within(fov, true, half) };
    let mut empty = Vec::new();
    for round in 0..rounds {
        let measured = small.frame(gpu, &forest, &up)?;
        if round >= WARM_UP {
            empty.push(measured.wall);
        }
    }
    let ring_none_ms = Spread::of(&empty);
    println!("{:>12}{:>8} trees{ring_none_ms:>28}", "none", 0);
    let none_ms = Some(ring_none_ms.median);
    let ring = cull_rows(gpu, &small, &forest, &aside(fov), &Culling::ALL, rounds, none_ms)?;
    drop((forest, small));
    let ring_bare = BareCulling::measure(args, gpu, &stage, &aside(fov))?;

    println!("over the number of trees, small ones, a tenth of them in view or fewer");
    println!("{:>8}{:>9}{:>24}{:>24}{:>28}", "trees", "in view", "CPU", "culling, GPU", "frame");
    let models: Vec<Tree> = Species::ALL.iter().map(|s| s.grow_with(1, 1000)).collect();
    let mut counts = Vec::new();
    let mut trees = 1000;
    while trees <= args.most {
        let stage = plant(models.clone(), trees);
        let forest = easel.forest(gpu, &stage, &stage.falls);
        let view = across(&stage, 0.12, half);
        let (mut cpu, mut cull, mut wall, mut seen) = (Vec::new(), Vec::new(), Vec::new(), 0);
        for round in 0..WARM_UP + 3 * args.frames {
            let measured = easel.frame(gpu, &forest, &view)?;
            seen = measured.counts.trees.visible;
            if round >= WARM_UP {
                cpu.push(measured.cpu);
                cull.push(measured.gpu.get("cull").copied().unwrap_or(f64::NAN));
                wall.push(measured.wall);
            }
        }
        let [cpu_ms, cull_gpu_ms, wall_ms] = [&cpu, &cull, &wall].map(|v| Spread::of(v));
        println!("{trees:>8}{seen:>9}{cpu_ms:>24}{cull_gpu_ms:>24}{wall_ms:>28}");
        counts.push(CountRow { trees, in_view: seen, cpu_ms, cull_gpu_ms, wall_ms });
        trees *= 10;
    }
    Ok(Cullings { trees: total, in_view, rows, full, away, ring, ring_none_ms, ring_bare, counts })
}

/// Frames of one view with some kinds of culling, in turn; how much faster they are, is over the first.
fn cull_rows(
    gpu: &mut Gpu,
    easel: &Easel,
    forest: &GpuForest,
    view: &View,
    cullings: &[Culling],
    rounds: u32,
    none_ms: Option<f64>,
) -> anyhow::Result<Vec<CullRow>> {
    let mut walls: Vec<Vec<f64>> = vec![Vec::new(); cullings.len()];
    let mut drawn = vec![0; cullings.len()];
    for round in 0..rounds {
        for (i, &culling) in cullings.iter().enumerate() {
            let measured = easel.frame(gpu, forest, &View { culling, ..*view })?;
            drawn[i] = measured.counts.trees.visible;
            if round >= WARM_UP || rounds == 1 {
                walls[i].push(measured.wall);
            }
        }
    }
    let off = Spread::of(&walls[0]).median;
    let row = |(i, culling): (usize, &Culling)| {
        let wall_ms = Spread::of(&walls[i]);
        let faster = off / wall_ms.median;
        let trees_faster = none_ms.map(|none| (off - none) / (wall_ms.median - none));
        let of_trees = trees_faster.map_or(String::new(), |faster| format!(" ({faster:.2} x)"));
        println!("{culling:>12}{:>8} trees{wall_ms:>28}{faster:>9.2} x{of_trees}", drawn[i]);
        let culling = culling.to_string();
        CullRow { culling, trees_drawn: drawn[i], wall_ms, faster, trees_faster }
    };
    Ok(cullings.iter().enumerate().map(row).collect())
}
