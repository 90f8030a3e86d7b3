//! SFS: figure 5 over h, and the comparisons of section 4.2.

use super::NamedPlot;
use super::report::{Row, Table};
use crate::harness::{Harness, PlantedView};
use crate::plot::{Line, Plot};
use crate::simplification::workload::{
    bisect, forest, lambda_total, paper_simplification, ring, vertex_count, view_across,
    view_from_ring_center, visible_trees,
};
use crate::statistics::Quartiles;
use windfall_core::simplify::Simplification;
use windfall_gpu::{Culling, View};
use windfall_host::device::Gpu;
use windfall_scenes::Stage;
use windfall_tree::species::papers10;

/// Vertices of the scene of figure 5 and of figure 1 in view, millions.
const FIGURE_5: f64 = 15.8;
/// The total level of detail of figure 1, at h = 0.7.
pub const FIGURE_1: f64 = 0.06;

/// All of its tables.
pub fn measure(
    gpu: &mut Gpu,
    quick: bool,
    number: usize,
    plots: &mut Vec<NamedPlot>,
) -> anyhow::Result<Vec<Table>> {
    Ok(vec![over_h(gpu, quick, number, plots)?, culling(gpu, quick)?])
}

fn frames_ms(
    gpu: &mut Gpu,
    harness: &Harness,
    planted: &mut PlantedView,
    view: &View,
    frames: u32,
) -> anyhow::Result<(Quartiles, u64)> {
    let (mut ms, mut drawn) = (Vec::new(), 0);
    for frame in 0..=frames {
        let measured = harness.measure(gpu, planted, (0.0, view))?;
        drawn = measured.counts.trees.visible;
        // Pipelines are compiled at the first.
        if frame > 0 {
            ms.push(measured.wall_ms);
        }
    }
    Ok((Quartiles::of(&ms), drawn))
}

/// The forest of figure 5, and the view of it.
pub struct Figure5 {
    pub stage: Stage,
    /// With which as many vertices are in view as the paper has, radians.
    pub fov: f32,
    /// With which h = 0.7 keeps what figure 1 does, metres.
    pub d0: f32,
}

/// Finds the view of figure 5 for pictures of a size.
pub fn figure_5_scene(size: (u32, u32)) -> Figure5 {
    let stage = forest(papers10().to_vec(), 1000);
    let fov = bisect(0.02, 2.5, FIGURE_5 * 1e6, |fov| {
        vertex_count(&stage, &view_across(&stage, fov, Simplification::NONE), size)
    });
    let d0 = bisect(1.0, 400.0, FIGURE_1, |d0| {
        lambda_total(&stage, &view_across(&stage, fov, paper_simplification(0.7, d0)), size)
    });
    Figure5 { stage, fov, d0 }
}

/// Figures 1, 3 and 5: total level of detail and frame rate over h.
fn over_h(
    gpu: &mut Gpu,
    quick: bool,
    number: usize,
    plots: &mut Vec<NamedPlot>,
) -> anyhow::Result<Table> {
    let size = if quick { (400, 300) } else { (800, 600) };
    let frames = if quick { 3 } else { 5 };
    println!("figure 5 of SFS");
    let harness = Harness::new(gpu, size)?;
    let Figure5 { stage, fov, d0 } = figure_5_scene(size);
    let none = Simplification::NONE;
    let mut planted = harness.upload(gpu, &stage)?;
    let mut rows = Vec::new();
    let (mut lambdas, mut rates) = (Vec::new(), Vec::new());
    let mut full = f64::NAN;
    let hs: &[f32] = if quick {
        &[0.0, 0.3, 0.5, 0.7, 0.9]
    } else {
        &[0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9]
    };
    for &h in hs {
        let detail = if h == 0.0 { none } else { paper_simplification(h, d0) };
        let view = view_across(&stage, fov, detail);
        let (ms, _) = frames_ms(gpu, &harness, &mut planted, &view, frames)?;
        if h == 0.0 {
            full = ms.median;
        }
        let lambda = if h == 0.0 { 1.0 } else { lambda_total(&stage, &view, size) };
        lambdas.push((f64::from(h), lambda));
        rates.push((f64::from(h), 1e3 / ms.median));
        rows.push(Row {
            name: format!("h = {h}"),
            ms,
            measured: Some(full / ms.median),
            printed: None,
            notes: format!("total lambda {lambda:.3}"),
        });
    }
    let file = format!("papers/over-h-{number}");
    let most = rates.iter().map(|r| r.1).fold(0.0, f64::max);
    let lines = vec![
        Line { name: "total lambda".into(), points: lambdas },
        Line {
            name: "frame rate, of the highest".into(),
            points: rates.iter().map(|r| (r.0, r.1 / most)).collect(),
        },
    ];
    let plot = Plot { title: "Figure 5: over h".into(), axes: ["h", ""], log: false, lines };
    plots.push((file.clone(), plot));
    let view = view_across(&stage, fov, none);
    Ok(Table {
        id: "sfs-figure5".into(),
        title: "SFS, figures 1 and 5: total level of detail and frame rate over h".into(),
        scene: format!(
            "{} trees of ten models, {:.1} million vertices in view, {}x{}; d0 = {d0:.0} m, so that h = 0.7 keeps 6%",
            stage.forest.instances.len(),
            vertex_count(&stage, &view, size) / 1e6,
            size.0,
            size.1
        ),
        ratio: "frame rate over that without simplification (h = 0)".into(),
        rows,
        remark: "The figure is a plot without numbers: detail falls and the frame rate rises with h, steeply in the \
                 middle, as here. Beyond h = 0.7 the trunks, the sky and the ground are what is left of a frame."
            .into(),
        plot: Some(file),
    })
}

/// Section 4.2: culling.
fn culling(gpu: &mut Gpu, quick: bool) -> anyhow::Result<Table> {
    let (size, trees, frames) = if quick { ((160, 120), 300, 3) } else { ((160, 120), 1000, 9) };
    println!("section 4.2 of SFS");
    let harness = Harness::new(gpu, size)?;
    let stage = ring(papers10().to_vec(), trees);
    let half = paper_simplification(0.5, 30.0);
    let aside = |fov| view_from_ring_center(fov, false, half);
    let fov = bisect(0.02, 2.5, f64::from(trees) * 0.1, |fov| {
        visible_trees(&stage, &aside(fov), size).len() as f64
    });
    let mut planted = harness.upload(gpu, &stage)?;
    let mut rows = Vec::new();
    let mut off = f64::NAN;
    for culling in [Culling::Off, Culling::ClipSpace, Culling::Sphere] {
        let view = View { culling, ..aside(fov) };
        let (ms, drawn) = frames_ms(gpu, &harness, &mut planted, &view, frames)?;
        if culling == Culling::Off {
            off = ms.median;
        }
        rows.push(Row {
            name: format!("a tenth in view, culling {culling}"),
            ms,
            measured: Some(off / ms.median),
            printed: Some(if culling == Culling::Off { 1.0 } else { 7.0 }),
            notes: format!("{drawn} trees drawn"),
        });
    }
    let mut all = Vec::new();
    for culling in [Culling::Sphere, Culling::ClipSpace] {
        let view = View { culling, ..view_from_ring_center(fov, true, half) };
        all.push((culling, frames_ms(gpu, &harness, &mut planted, &view, frames)?));
    }
    let sphere = all[0].1.0.median;
    rows.extend(all.into_iter().map(|(culling, (ms, drawn))| Row {
        name: format!("none in view, culling {culling}"),
        ms,
        measured: Some(sphere / ms.median),
        printed: Some(if culling == Culling::Sphere { 1.0 } else { 0.27 }),
        notes: format!("{drawn} trees drawn"),
    }));
    Ok(Table {
        id: "sfs-4.2".into(),
        title: "SFS, section 4.2: culling".into(),
        scene: format!("A ring of {trees} trees 100 m away, h = 0.5, {}x{}", size.0, size.1),
        ratio: "frame rate over that without culling; with none in view, over that of bounding spheres".into(),
        rows,
        remark: "The paper's factor is 7 with a tenth in view; what is left of a frame without trees (sky, ground, tone \
                 map) bounds it here. With none in view the paper's clip-space test took nearly four times as long: its \
                 CPU tested tree by tree. Here a compute shader tests all trees at once, and both tests vanish beside \
                 the rest of the frame."
            .into(),
        plot: None,
    })
}
