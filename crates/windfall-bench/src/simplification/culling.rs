//! Part b: what culling saves, and what it costs over the number of trees.

use super::workload::{
    LeafMesh, all_trees, bisect, forest, opposite, paper_simplification, ring, view_across,
    view_from_middle, view_from_ring_center, visible_trees,
};
use super::{Args, WARM_UP};
use crate::baseline::MeshBaseline;
use crate::harness::{Harness, PlantedView, upload_models};
use crate::scenery::clip_from_world;
use crate::statistics::Quartiles;
use serde::Serialize;
use windfall_core::simplify::Simplification;
use windfall_core::tree::Tree;
use windfall_gpu::{Culling, View};
use windfall_host::device::Gpu;
use windfall_scenes::Stage;
use windfall_tree::Species;
use windfall_tree::species::papers10;

/// Size of the images of the ring of trees.
const RING_SIZE: (u32, u32) = (160, 120);

/// Results of part b.
#[derive(Serialize)]
pub struct CullingReport {
    trees: usize,
    in_view: usize,
    rows: Vec<CullRow>,
    /// Unsimplified, one frame each.
    full: Vec<CullRow>,
    away: Vec<CullRow>,
    /// A ring of trees of equal cost, and the frame without any of them.
    ring: Vec<CullRow>,
    ring_none_ms: Quartiles,
    ring_bare: CullingLimit,
    counts: Vec<CountRow>,
}

#[derive(Serialize)]
struct CullRow {
    culling: String,
    trees_drawn: u64,
    wall_ms: Quartiles,
    faster: f64,
    /// The same without the time of a frame that draws no tree, where that is known.
    trees_faster: Option<f64>,
}

/// The most that culling can save: the baseline draw of the leaves of all trees, and of the trees
/// in view.
#[derive(Serialize)]
struct CullingLimit {
    all_ms: Quartiles,
    in_view_ms: Quartiles,
    faster: f64,
}

impl CullingLimit {
    fn measure(args: &Args, gpu: &Gpu, stage: &Stage, view: &View) -> anyhow::Result<Self> {
        let (width, height) = RING_SIZE;
        let clip_from_world = clip_from_world(&view.camera, width as f32 / height as f32);
        let trees = [all_trees(stage, view, height), visible_trees(stage, view, RING_SIZE)];
        let draws = trees.map(|trees| {
            let mesh = LeafMesh::new(stage, view, trees);
            MeshBaseline::new(gpu, &mesh.positions, &mesh.indices, clip_from_world, RING_SIZE)
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
        let [all_ms, in_view_ms] = times.map(|t| Quartiles::of(&t));
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
    cpu_ms: Quartiles,
    cull_gpu_ms: Quartiles,
    wall_ms: Quartiles,
}

/// Runs part b: a thousand trees with a tenth in view and with none, and the cost of culling over
/// the number of trees.
pub fn measure(args: &Args, gpu: &mut Gpu, harness: &Harness) -> anyhow::Result<CullingReport> {
    let stage = forest(papers10().to_vec(), 1000);
    let none = Simplification::NONE;
    let total = stage.forest.instances.len();
    let tenth = total as f64 * 0.1;
    let fov = bisect(0.02, 2.5, tenth, |fov| {
        visible_trees(&stage, &view_from_middle(fov, none), args.size).len() as f64
    });
    let half = paper_simplification(0.5, 30.0);
    let view = view_from_middle(fov, half);
    let in_view = visible_trees(&stage, &view, args.size).len();
    println!(
        "\n(b) {total} trees of papers10, {in_view} in view, h = 0.5, d0 = 30 m; wall clock of {} \
         frames, ms",
        args.frames
    );
    let mut planted = harness.upload(gpu, &stage)?;
    let rounds = WARM_UP + args.frames;
    let rows = cull_rows(gpu, harness, &mut planted, &view, &Culling::ALL, rounds, None)?;
    println!("the same, looking away: none in view");
    let away =
        cull_rows(gpu, harness, &mut planted, &opposite(&view), &Culling::ALL, rounds, None)?;
    println!("the first view unsimplified, a frame each");
    let full = View { detail: none, ..view.clone() };
    let cullings = [Culling::Off, Culling::Sphere];
    let full = cull_rows(gpu, harness, &mut planted, &full, &cullings, 1, None)?;
    drop((stage, planted));
    let (ring, ring_none_ms, ring_bare) = measure_ring(args, gpu, tenth)?;
    let counts = measure_counts(args, gpu, harness)?;
    Ok(CullingReport {
        trees: total,
        in_view,
        rows,
        full,
        away,
        ring,
        ring_none_ms,
        ring_bare,
        counts,
    })
}

/// A ring of a thousand trees, `trees_in_view` of which are in view. Without culling, trees out of
/// view cost as much as trees in view there: they are as far away, and in an image so small pixels
/// cost little. Returns the rows, the time of a frame that draws no tree, and the most that culling
/// can save.
fn measure_ring(
    args: &Args,
    gpu: &mut Gpu,
    trees_in_view: f64,
) -> anyhow::Result<(Vec<CullRow>, Quartiles, CullingLimit)> {
    let stage = ring(papers10().to_vec(), 1000);
    let harness = Harness::new(gpu, RING_SIZE)?;
    let half = paper_simplification(0.5, 30.0);
    let aside = |fov| view_from_ring_center(fov, false, half);
    let fov = bisect(0.02, 2.5, trees_in_view, |fov| {
        visible_trees(&stage, &aside(fov), RING_SIZE).len() as f64
    });
    println!(
        "trees all around, 100 m away, {} in view, {}x{}; in brackets without the frame that draws none",
        visible_trees(&stage, &aside(fov), RING_SIZE).len(),
        RING_SIZE.0,
        RING_SIZE.1
    );
    let mut planted = harness.upload(gpu, &stage)?;
    let rounds = WARM_UP + args.frames;
    let up = View { culling: Culling::Sphere, ..view_from_ring_center(fov, true, half) };
    let mut empty = Vec::new();
    for round in 0..rounds {
        let measured = harness.measure(gpu, &mut planted, (0.0, &up))?;
        if round >= WARM_UP {
            empty.push(measured.wall_ms);
        }
    }
    let none_ms = Quartiles::of(&empty);
    println!("{:>12}{:>8} trees{none_ms:>28}", "none", 0);
    let none = Some(none_ms.median);
    let rows = cull_rows(gpu, &harness, &mut planted, &aside(fov), &Culling::ALL, rounds, none)?;
    drop((planted, harness));
    let limit = CullingLimit::measure(args, gpu, &stage, &aside(fov))?;
    Ok((rows, none_ms, limit))
}

/// The cost of culling over the number of trees, of which a tenth or fewer are in view.
fn measure_counts(args: &Args, gpu: &mut Gpu, harness: &Harness) -> anyhow::Result<Vec<CountRow>> {
    println!("over the number of trees, small ones, a tenth of them in view or fewer");
    println!("{:>8}{:>9}{:>24}{:>24}{:>28}", "trees", "in view", "CPU", "culling, GPU", "frame");
    let half = paper_simplification(0.5, 30.0);
    let models: Vec<Tree> = Species::ALL.iter().map(|s| s.grow_with(1, 1000)).collect();
    let uploaded = upload_models(gpu, &forest(models.clone(), 0))?;
    let mut counts = Vec::new();
    let mut trees = 1000;
    while trees <= args.most {
        let stage = forest(models.clone(), trees);
        let mut planted = harness.plant(gpu, &stage, &uploaded)?;
        let view = view_across(&stage, 0.12, half);
        let (mut cpu, mut cull, mut wall, mut in_view) = (Vec::new(), Vec::new(), Vec::new(), 0);
        for round in 0..WARM_UP + 3 * args.frames {
            let measured = harness.measure(gpu, &mut planted, (0.0, &view))?;
            in_view = measured.counts.trees.visible;
            if round >= WARM_UP {
                cpu.push(measured.cpu_ms);
                cull.push(measured.passes_ms(&["cull"]));
                wall.push(measured.wall_ms);
            }
        }
        let [cpu_ms, cull_gpu_ms, wall_ms] = [&cpu, &cull, &wall].map(|v| Quartiles::of(v));
        println!("{trees:>8}{in_view:>9}{cpu_ms:>24}{cull_gpu_ms:>24}{wall_ms:>28}");
        counts.push(CountRow { trees, in_view, cpu_ms, cull_gpu_ms, wall_ms });
        trees *= 10;
    }
    Ok(counts)
}

/// Frames of one view with several kinds of culling in turns. `faster` is over the first of them.
fn cull_rows(
    gpu: &mut Gpu,
    harness: &Harness,
    planted: &mut PlantedView,
    view: &View,
    cullings: &[Culling],
    rounds: u32,
    none_ms: Option<f64>,
) -> anyhow::Result<Vec<CullRow>> {
    let mut walls: Vec<Vec<f64>> = vec![Vec::new(); cullings.len()];
    let mut drawn = vec![0; cullings.len()];
    for round in 0..rounds {
        for (i, &culling) in cullings.iter().enumerate() {
            let view = View { culling, ..view.clone() };
            let measured = harness.measure(gpu, planted, (0.0, &view))?;
            drawn[i] = measured.counts.trees.visible;
            if round >= WARM_UP || rounds == 1 {
                walls[i].push(measured.wall_ms);
            }
        }
    }
    let off = Quartiles::of(&walls[0]).median;
    let row = |(i, culling): (usize, &Culling)| {
        let wall_ms = Quartiles::of(&walls[i]);
        let faster = off / wall_ms.median;
        let trees_faster = none_ms.map(|none| (off - none) / (wall_ms.median - none));
        let of_trees = trees_faster.map_or(String::new(), |faster| format!(" ({faster:.2} x)"));
        println!("{culling:>12}{:>8} trees{wall_ms:>28}{faster:>9.2} x{of_trees}", drawn[i]);
        let culling = culling.to_string();
        CullRow { culling, trees_drawn: drawn[i], wall_ms, faster, trees_faster }
    };
    Ok(cullings.iter().enumerate().map(row).collect())
}
