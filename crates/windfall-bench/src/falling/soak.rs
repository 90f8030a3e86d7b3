//! Part d, a soak test: whether frames become slower or memory grows while leaves fall for long.

use crate::harness::{Harness, PlantedView, upload_models};
use crate::scenery;
use crate::statistics::Quartiles;
use glam::DVec3;
use serde::Serialize;
use windfall_core::forest::{Placement, Terrain};
use windfall_core::shed::Shedding;
use windfall_core::wind::Wind;
use windfall_gpu::{Camera, Falls, Quality, View};
use windfall_host::device::Gpu;
use windfall_scenes::Stage;
use windfall_tree::Species;

#[derive(Serialize)]
pub struct Soak {
    frames: u32,
    /// Leaves of the trees.
    leaves: u64,
    /// The most leaves in the air and on the ground together.
    kept: u32,
    first_fifth_ms: Quartiles,
    last_fifth_ms: Quartiles,
    /// Median of the last fifth over that of the first.
    drift: f64,
    /// Resident memory of the process after the first tenth and at the end, MiB. Linux only.
    memory_mib: Option<[f64; 2]>,
    /// Growth of resident memory per thousand frames after the first tenth, MiB: with falling
    /// leaves, and without.
    growth_mib: Option<[f64; 2]>,
    /// GPU timestamps of the first and the last fifth.
    gpu_ms: [Quartiles; 2],
    /// Wall clock of the first and the last fifth without falling leaves, of a tenth as many
    /// frames.
    still_ms: [Quartiles; 2],
}

/// Three small trees of `leaves` leaves each that shed during all `frames`, 30 per second.
///
/// A twelfth of the leaves is kept, so that after a tenth of the frames every new leaf reuses a
/// slot. The camera has the trees behind it and the wind carries the leaves past it, so that
/// falling leaves are most of a frame's cost.
fn stage(frames: u32, leaves: u32) -> Stage {
    let trees = vec![Species::Birch.grow_with(1, leaves)];
    let placement = Placement {
        trees: 3,
        spacing: 5.0,
        keep_out: Vec::new(),
        scale: (0.9, 1.1),
        season_spread: 0.0,
        seed: 5,
    };
    let duration = frames as f32 / 30.0;
    let falls = Falls {
        shedding: Shedding { start: 0.0, duration, peak: 0.0, tree_spread: 0.0, burst: 0.5 },
        wind: Wind::new(5.0, 0.0, 0.5, 1),
        capacity: (leaves / 4).max(1),
        ..Falls::default()
    };
    scenery::stage(trees, placement.place(Terrain::flat(), &[1.0]), falls)
}

/// Frame times of a run, milliseconds, and resident memory after its first tenth and at its end.
struct Run {
    wall_ms: Vec<f64>,
    gpu_ms: Vec<f64>,
    memory_mib: Option<[f64; 2]>,
}

impl Run {
    fn measure(
        gpu: &mut Gpu,
        harness: &Harness,
        planted: &mut PlantedView,
        frames: u32,
    ) -> anyhow::Result<Self> {
        let (mut wall_ms, mut gpu_ms) = (Vec::new(), Vec::new());
        let mut early = None;
        let (eye, target) = (DVec3::new(14.0, 2.5, 0.0), DVec3::new(40.0, 1.0, 0.0));
        let camera = Camera::look_at(eye, target, 0.9, 0.1);
        let view = View { shadows: false, quality: Quality::PLAIN, ..View::new(camera) };
        for frame in 0..frames {
            let measured = harness.measure(gpu, planted, (f64::from(frame) / 30.0, &view))?;
            wall_ms.push(measured.wall_ms);
            gpu_ms.push(measured.passes_ms(&["frame"]));
            if frame == frames / 10 {
                early = resident_mib();
            }
        }
        let memory_mib = early.zip(resident_mib()).map(|(a, b)| [a, b]);
        Ok(Self { wall_ms, gpu_ms, memory_mib })
    }

    /// Growth of resident memory per thousand frames, MiB.
    fn growth(&self) -> Option<f64> {
        let [early, late] = self.memory_mib?;
        Some((late - early) / (0.9e-3 * self.wall_ms.len() as f64))
    }

    /// The first and the last fifth of the frames after the first tenth. All slots are in use then,
    /// so frames should cost the same.
    fn fifths(times: &[f64]) -> [Quartiles; 2] {
        let times = &times[times.len() / 10..];
        let fifth = (times.len() / 5).max(1).min(times.len());
        [Quartiles::of(&times[..fifth]), Quartiles::of(&times[times.len() - fifth..])]
    }
}

/// Runs part d: `frames` frames of three trees of `leaves` leaves.
pub fn measure(frames: u32, leaves: u32, gpu: &mut Gpu) -> anyhow::Result<Soak> {
    let stage = stage(frames, leaves);
    let harness = Harness::new(gpu, (64, 36))?;
    let models = upload_models(gpu, &stage)?;
    let still = Stage { falls: Falls::none(), ..stage.clone() };
    let mut still = harness.plant(gpu, &still, &models)?;
    let still = Run::measure(gpu, &harness, &mut still, (frames / 10).max(1))?;
    let mut planted = harness.plant(gpu, &stage, &models)?;
    let run = Run::measure(gpu, &harness, &mut planted, frames)?;
    let [first, last] = Run::fifths(&run.wall_ms);
    let gpu_ms = Run::fifths(&run.gpu_ms);
    let still_ms = Run::fifths(&still.wall_ms);
    let soak = Soak {
        frames,
        leaves: stage.leaf_count(),
        kept: stage.falls.capacity,
        first_fifth_ms: first,
        last_fifth_ms: last,
        drift: last.median / first.median,
        memory_mib: run.memory_mib,
        growth_mib: run.growth().zip(still.growth()).map(|(a, b)| [a, b]),
        gpu_ms,
        still_ms,
    };
    println!(
        "\n(d) {frames} frames of continuous shedding, compute, 64x36; {} leaves, {} kept",
        soak.leaves, soak.kept
    );
    println!("first fifth after a tenth of them, ms     {first}");
    println!("last fifth                               {last}   {:.3} x", soak.drift);
    let [first, last] = gpu_ms;
    println!("on the GPU, first fifth                  {first}");
    println!(
        "last fifth                               {last}   {:.3} x",
        last.median / first.median
    );
    let [first, last] = still_ms;
    println!("no leaf falling, first fifth             {first}");
    println!(
        "last fifth                               {last}   {:.3} x",
        last.median / first.median
    );
    match (soak.memory_mib, soak.growth_mib) {
        (Some([a, b]), Some([run, still])) => {
            println!("memory after a tenth, at the end, MiB    {a:.1}, {b:.1}");
            println!(
                "growth in a thousand frames, MiB         {run:.1}; {still:.1} where no leaf falls"
            );
        }
        _ => println!("memory: not known on this system"),
    }
    Ok(soak)
}

/// Resident memory of this process, MiB, where `/proc` says it.
fn resident_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:"))?;
    let kib: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib / 1024.0)
}
