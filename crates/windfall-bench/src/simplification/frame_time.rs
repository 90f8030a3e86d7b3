//! Part a: frame time over `h` in the paper's forest, and the cost of a leaf.

use super::workload::{
    LeafMesh, bisect, forest, lambda_total, paper_simplification, vertex_count, view_across,
    visible_trees, without_leaves,
};
use super::{Args, WARM_UP};
use crate::baseline::MeshBaseline;
use crate::harness::{Harness, PlantedView};
use crate::plot::{failed, register_font};
use crate::scenery::clip_from_world;
use crate::statistics::Quartiles;
use plotters::prelude::*;
use serde::Serialize;
use windfall_core::simplify::Simplification;
use windfall_gpu::{DebugView, View};
use windfall_host::device::Gpu;
use windfall_scenes::Stage;
use windfall_tree::species::papers10;

/// Values of `h` of SFS, figure 5.
pub const HS: [f32; 10] = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];

/// Results of part a.
#[derive(Serialize)]
pub struct FrameTimes {
    trees: usize,
    trees_in_view: usize,
    vertices_in_view: f64,
    d0: f32,
    rows: Vec<Row>,
    leaf: LeafCost,
}

#[derive(Serialize)]
struct Row {
    h: f32,
    lambda_total: f64,
    triangles: u64,
    wall_ms: Quartiles,
    faster: f64,
}

/// The value of a row in a plot.
type Value = fn(&Row) -> f64;

/// The cost of a drawn leaf.
#[derive(Serialize)]
struct LeafCost {
    h: f32,
    leaves: u64,
    with_ms: Quartiles,
    bald_ms: Quartiles,
    plain_ms: Quartiles,
    empty_ms: Quartiles,
    ours_ns: f64,
    plain_ns: f64,
    ratio: f64,
}

/// Runs part a: the paper's forest of up to 1,000 instances of ten models, and its figure 5.
pub fn measure(args: &Args, gpu: &mut Gpu, harness: &Harness) -> anyhow::Result<FrameTimes> {
    let stage = forest(papers10().to_vec(), 1000);
    let none = Simplification::NONE;
    let wanted = args.vertices * 1e6;
    let fov = bisect(0.05, 2.5, wanted, |fov| {
        vertex_count(&stage, &view_across(&stage, fov, none), args.size)
    });
    let view = |detail| view_across(&stage, fov, detail);
    let in_view = visible_trees(&stage, &view(none), args.size).len();
    let d0 = bisect(1.0, 400.0, 0.06, |d0| {
        lambda_total(&stage, &view(paper_simplification(0.7, d0)), args.size)
    });
    let vertices_in_view = vertex_count(&stage, &view(none), args.size);
    println!(
        "\n(a) {} trees of papers10, {in_view} in view with {:.1} M vertices; d0 = {d0:.1} m, so that \
         h = 0.7 draws 6% of the leaves; wall clock of {} frames, ms",
        stage.forest.instances.len(),
        vertices_in_view / 1e6,
        args.frames
    );
    let mut planted = harness.upload(gpu, &stage)?;
    let hs = &args.h;
    let mut walls: Vec<Vec<f64>> = vec![Vec::new(); hs.len()];
    let mut triangles = vec![0; hs.len()];
    for round in 0..WARM_UP + args.frames {
        for (i, &h) in hs.iter().enumerate() {
            // One frame is enough to warm up without simplification, which is the slowest.
            if h == 0.0 && round == 1 {
                continue;
            }
            let detail = if h == 0.0 { none } else { paper_simplification(h, d0) };
            let measured = harness.measure(gpu, &mut planted, (0.0, &view(detail)))?;
            triangles[i] = measured.counts.trees.triangles;
            if round >= WARM_UP {
                walls[i].push(measured.wall_ms);
            }
        }
    }
    println!(
        "{:>5}{:>10}{:>14}{:>36}{:>10}{:>9}",
        "h", "lambda", "triangles", "frame", "frames/s", "faster"
    );
    let full = Quartiles::of(&walls[0]).median;
    let rows: Vec<Row> = hs
        .iter()
        .enumerate()
        .map(|(i, &h)| {
            let wall_ms = Quartiles::of(&walls[i]);
            let lambda = if h == 0.0 {
                1.0
            } else {
                lambda_total(&stage, &view(paper_simplification(h, d0)), args.size)
            };
            let faster = full / wall_ms.median;
            println!(
                "{h:>5.1}{lambda:>10.4}{:>14}{wall_ms:>36}{:>10.2}{faster:>9.2}",
                triangles[i],
                1e3 / wall_ms.median
            );
            Row { h, lambda_total: lambda, triangles: triangles[i], wall_ms, faster }
        })
        .collect();
    let leaves_only = View { show: DebugView::Leaves, ..view(paper_simplification(0.7, d0)) };
    let leaf = LeafCost::measure(args, gpu, harness, (&stage, &mut planted), &leaves_only)?;
    Ok(FrameTimes {
        trees: stage.forest.instances.len(),
        trees_in_view: in_view,
        vertices_in_view,
        d0,
        rows,
        leaf,
    })
}

impl LeafCost {
    /// Compares the leaves of `view`, which shows leaves only, with their triangles as one mesh.
    /// Nothing hides either of them.
    fn measure(
        args: &Args,
        gpu: &mut Gpu,
        harness: &Harness,
        (stage, planted): (&Stage, &mut PlantedView),
        view: &View,
    ) -> anyhow::Result<Self> {
        let mesh = LeafMesh::new(stage, view, visible_trees(stage, view, args.size));
        let leaves = mesh.leaves;
        let aspect = args.size.0 as f32 / args.size.1 as f32;
        let clip_from_world = clip_from_world(&view.camera, aspect);
        let baseline =
            MeshBaseline::new(gpu, &mesh.positions, &mesh.indices, clip_from_world, args.size);
        drop(mesh);
        let leafless = without_leaves(stage);
        let mut leafless = harness.upload(gpu, &leafless)?;
        let mut times: [Vec<f64>; 4] = Default::default();
        for round in 0..WARM_UP + 3 * args.frames {
            let of_round = [
                harness.measure(gpu, planted, (0.0, view))?.wall_ms,
                harness.measure(gpu, &mut leafless, (0.0, view))?.wall_ms,
                baseline.measure(gpu, 1.0)?,
                baseline.measure(gpu, 0.0)?,
            ];
            if round >= WARM_UP {
                times.iter_mut().zip(of_round).for_each(|(all, time)| all.push(time));
            }
        }
        let [with_ms, bald_ms, plain_ms, empty_ms] = times.map(|t| Quartiles::of(&t));
        let per_leaf =
            |a: &Quartiles, b: &Quartiles| (a.median - b.median) * 1e6 / leaves.max(1) as f64;
        let (ours_ns, plain_ns) = (per_leaf(&with_ms, &bald_ms), per_leaf(&plain_ms, &empty_ms));
        let ratio = ours_ns / plain_ns;
        println!("\n{leaves} leaves at h = 0.7; ms");
        println!("frame of the leaves alone          {with_ms}");
        println!("the same of the forest bald        {bald_ms}");
        println!("the leaves' triangles, bare draw   {plain_ms}");
        println!("nothing, the same targets          {empty_ms}");
        println!("a leaf: {ours_ns:.0} ns, bare {plain_ns:.0} ns: {ratio:.2} x");
        Ok(Self { h: 0.7, leaves, with_ms, bald_ms, plain_ms, empty_ms, ours_ns, plain_ns, ratio })
    }
}

impl FrameTimes {
    /// SFS, figure 5: the total level of detail and frames per second over h.
    pub fn plot(&self) -> anyhow::Result<String> {
        register_font()?;
        let mut svg = String::new();
        {
            let root = SVGBackend::with_string(&mut svg, (900, 420)).into_drawing_area();
            root.fill(&WHITE).map_err(failed)?;
            let (left, right) = root.split_horizontally(450);
            let most = self.rows.iter().map(|r| 1e3 / r.wall_ms.median).fold(0.0, f64::max) * 1.05;
            let panels: [(_, &str, f64, Value); 2] = [
                (left, "total level of detail over h", 1.0, |r| r.lambda_total),
                (right, "frames per second over h", most, |r| 1e3 / r.wall_ms.median),
            ];
            for (area, caption, high, value) in panels {
                let mut chart = ChartBuilder::on(&area)
                    .caption(caption, ("sans-serif", 16))
                    .margin(12)
                    .x_label_area_size(30)
                    .y_label_area_size(50)
                    .build_cartesian_2d(0.0..0.9, 0.0..high)
                    .map_err(failed)?;
                chart.configure_mesh().light_line_style(WHITE).draw().map_err(failed)?;
                let points: Vec<(f64, f64)> =
                    self.rows.iter().map(|r| (f64::from(r.h), value(r))).collect();
                let color = RGBColor(190, 90, 20);
                let line = LineSeries::new(points.clone(), color.stroke_width(2));
                chart.draw_series(line).map_err(failed)?;
                let dots = points.iter().map(|&p| Circle::new(p, 3, color.filled()));
                chart.draw_series(dots).map_err(failed)?;
            }
            root.present().map_err(failed)?;
        }
        Ok(svg)
    }
}
