//! Part a: VB's scene with each strategy, elimination and leaf occlusion, over a walk.

use super::workload::{grove, walkthrough};
use super::{Args, WARM_UP};
use crate::harness::{FrameMeasurement, Harness, upload_models};
use crate::plot::{Line, Plot};
use crate::statistics::Quartiles;
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::Arc;
use windfall_gpu::Falls;
use windfall_host::device::Gpu;
use windfall_papers::{
    Elimination, LeafOcclusion, ListOptions, PassOptions, PublishedFalls, PublishedPasses,
};
use windfall_scenes::{Stage, Strategy};

#[derive(Serialize)]
pub struct StrategyRow {
    /// The strategy whose configurations took turns with this one.
    pub strategy: String,
    name: String,
    wall_ms: Quartiles,
    gpu_ms: Quartiles,
    /// Over the frame of the same moment with the same leaves on the twigs and none detached.
    ratio: Quartiles,
    /// Over the frame of the same moment in which all leaves hang, as VB compare.
    ratio_to_full: Quartiles,
    /// `ratio` of the last fifth of the frames over that of the first fifth.
    drift: f64,
    /// Leaves in the air and on the ground in the last frame.
    falling: u64,
    landed: u64,
    /// Of those, leaves in the CPU's list.
    listed: u64,
    /// Leaf occlusion in the last frame.
    tested: u32,
    skipped: u32,
    /// Medians of the GPU passes, milliseconds.
    passes_ms: BTreeMap<String, f64>,
    /// Wall clock of each frame, milliseconds.
    frames_ms: Vec<f64>,
}

impl Args {
    /// The moment of a frame, counted from the first of the warm-up.
    fn seconds(&self, frame: u32) -> f64 {
        self.start + f64::from(frame * self.stride) / 30.0
    }
}

/// Runs part a.
pub fn measure(args: &Args, gpu: &mut Gpu, harness: &Harness) -> anyhow::Result<Vec<StrategyRow>> {
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
    print_columns(
        "",
        &["wall", "GPU", "cost", "over full", "drift", "listed", "tested", "skipped"],
    );
    let models = upload_models(gpu, &stage)?;
    // The same leaves on the twigs, and none that have left them; and trees that keep all leaves.
    let bare = Stage { falls: Falls { capacity: 0, ..stage.falls.clone() }, ..stage.clone() };
    let full = Stage { falls: Falls::none(), ..stage.clone() };
    let mut rows = Vec::new();
    // The strategies are measured one after the other, each in turns with its own references: with
    // many pipelines in use, a driver may evict some of them and compile them again in each frame.
    for &strategy in &args.strategies {
        let mut configurations = vec![
            ("none moving, none loose".to_owned(), harness.plant(gpu, &bare, &models)?),
            ("none moving, in full".to_owned(), harness.plant(gpu, &full, &models)?),
        ];
        if let Some(published) = strategy.published() {
            // Pipelines are built once for each of both.
            let passes = [false, true].map(|leaf_occlusion| {
                let supported = gpu.fragment_stores || !leaf_occlusion;
                let occlusion = leaf_occlusion.then(LeafOcclusion::default);
                let options = PassOptions { occlusion, ..PassOptions::new(published) };
                supported.then(|| PublishedPasses::new(&gpu.device, options))
            });
            let passes = passes.map(|passes| passes.map(Arc::new));
            for (elimination, leaf_occlusion) in OPTIONS {
                let Some(passes) = &passes[usize::from(leaf_occlusion)] else { continue };
                let options = ListOptions { capacity: stage.falls.capacity, elimination };
                let mut planted = harness.plant(gpu, &bare, &models)?;
                let layer = PublishedFalls::new(passes, &planted.stage.forest, options)?;
                planted.stage.published = Some(layer);
                let name = format!("{strategy}, elimination {elimination}");
                let name = if leaf_occlusion { name + ", occlusion" } else { name };
                configurations.push((name, planted));
            }
        } else {
            configurations.push((strategy.to_string(), harness.plant(gpu, &stage, &models)?));
        }
        let mut frames: Vec<Vec<_>> = configurations.iter().map(|_| Vec::new()).collect();
        for frame in 0..WARM_UP + args.frames {
            let seconds = args.seconds(frame);
            let view = walkthrough(&stage, seconds);
            for ((_, planted), measured) in configurations.iter_mut().zip(&mut frames) {
                if args.stride > 1 {
                    // The previous frame of the walk, so that the measured frame has the changes
                    // of one frame and not of `stride` frames.
                    let before = seconds - 1.0 / 30.0;
                    harness.measure(gpu, planted, (before, &walkthrough(&stage, before)))?;
                }
                let measurement = harness.measure(gpu, planted, (seconds, &view))?;
                if frame >= WARM_UP {
                    measured.push(measurement);
                }
            }
        }
        let [still, full] =
            [0, 1].map(|k| frames[k].iter().map(|m| m.wall_ms).collect::<Vec<f64>>());
        rows.extend(configurations.into_iter().zip(&frames).map(|((name, _), measured)| {
            StrategyRow::new(strategy, name, measured, [&still, &full])
        }));
        if strategy == Strategy::Compute {
            print_columns(&format!("{strategy}, occlusion"), &["-"; 8]);
        }
    }
    Ok(rows)
}

/// Elimination and leaf occlusion (VB 6.3) that the published strategies are measured with.
const OPTIONS: [(Elimination, bool); 5] = [
    (Elimination::Scheduled, false),
    (Elimination::Scheduled, true),
    (Elimination::PROGRESSIVE, false),
    (Elimination::Off, false),
    (Elimination::Off, true),
];

/// Prints a line of the table.
fn print_columns(name: &str, columns: &[impl std::fmt::Display; 8]) {
    let [wall, on_gpu, cost, over_full, drift, listed, tested, skipped] = columns;
    println!(
        "{name:<48}{wall:>26}{on_gpu:>26}{cost:>18}{over_full:>18}{drift:>7}{listed:>8}{tested:>8}\
         {skipped:>8}"
    );
}

impl StrategyRow {
    /// Summarizes and prints `measured` frames. `still` and `full` are the wall clock of the
    /// references' frames of the same moments.
    fn new(
        strategy: Strategy,
        name: String,
        measured: &[FrameMeasurement],
        [still, full]: [&[f64]; 2],
    ) -> Self {
        let wall: Vec<f64> = measured.iter().map(|m| m.wall_ms).collect();
        let on_gpu: Vec<f64> =
            measured.iter().filter_map(|m| m.gpu_ms.get("frame").copied()).collect();
        let over = |of: &[f64]| wall.iter().zip(of).map(|(a, b)| a / b).collect::<Vec<f64>>();
        let ratios = over(still);
        let fifth = (ratios.len() / 5).max(1);
        let drift = Quartiles::of(&ratios[ratios.len() - fifth..]).median
            / Quartiles::of(&ratios[..fifth]).median;
        let last = &measured[measured.len() - 1];
        let counts = &last.counts;
        // Only the published strategies have a list on the CPU.
        let listed = match strategy {
            Strategy::Compute => 0,
            _ => counts.falling + counts.landed - counts.eliminated,
        };
        let row = Self {
            strategy: strategy.to_string(),
            name,
            wall_ms: Quartiles::of(&wall),
            gpu_ms: Quartiles::of(&on_gpu),
            ratio: Quartiles::of(&ratios),
            ratio_to_full: Quartiles::of(&over(full)),
            drift,
            falling: counts.falling,
            landed: counts.landed,
            listed,
            tested: counts.tested,
            skipped: counts.skipped,
            passes_ms: pass_medians(measured),
            frames_ms: wall,
        };
        let columns = [row.wall_ms, row.gpu_ms, row.ratio, row.ratio_to_full];
        let [wall, on_gpu, cost, over_full] = columns.map(|q| q.to_string());
        let drift = format!("{:.2}", row.drift);
        let [listed, tested, skipped] =
            [row.listed, row.tested.into(), row.skipped.into()].map(|n: u64| n.to_string());
        print_columns(&row.name, &[wall, on_gpu, cost, over_full, drift, listed, tested, skipped]);
        row
    }
}

/// Median time of each pass, milliseconds.
fn pass_medians(measured: &[FrameMeasurement]) -> BTreeMap<String, f64> {
    let names = measured.iter().flat_map(|m| m.gpu_ms.keys());
    let median = |name: &String| {
        let times: Vec<f64> = measured.iter().filter_map(|m| m.gpu_ms.get(name).copied()).collect();
        Quartiles::of(&times).median
    };
    names.map(|name| (name.clone(), median(name))).collect()
}

/// VB's figure 6: frame times over the walk, of the rows of one strategy.
pub fn plot(rows: &[StrategyRow], args: &Args) -> anyhow::Result<String> {
    let lines = rows.iter().map(|row| Line {
        name: row.name.clone(),
        points: row
            .frames_ms
            .iter()
            .enumerate()
            .map(|(i, &ms)| (args.seconds(WARM_UP + i as u32), ms))
            .collect(),
    });
    let title = format!("Frame cost over the walk, {}", rows[0].strategy);
    Plot { title, axes: ["s", "ms"], log: false, lines: lines.collect() }.svg()
}
