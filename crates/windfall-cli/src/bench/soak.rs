//! Continuous shedding for many frames: whether frames become slower or memory grows.

use super::Spread;
use super::stand::Easel;
use crate::gpu::Gpu;
use glam::Vec3;
use serde::Serialize;
use windfall_core::forest::{Placement, Terrain};
use windfall_core::shed::Shedding;
use windfall_core::tree::species::Species;
use windfall_core::wind::Wind;
use windfall_gpu::{Camera, Falls, GpuForest, Quality, View};
use windfall_scenes::Stage;

#[derive(Serialize)]
pub struct Soak {
    frames: u32,
    /// Leaves of the trees, and how many may be in the air or lie at a time.
    leaves: u64,
    kept: u32,
    first_fifth_ms: Spread,
    last_fifth_ms: Spread,
    drift: f64,
    /// Resident memory of the process after the first tenth and at the end, MiB, where the system
    /// says.
    memory_mib: Option<[f64; 2]>,
    /// Growth of it in a thousand frames, MiB: from the first tenth on, and where no leaf falls.
    growth_mib: Option<[f64; 2]>,
    /// As `first_fifth_ms` and `last_fifth_ms`, timestamps of the frame on the GPU.
    gpu_ms: [Spread; 2],
    /// Fifths by the wall clock of a tenth as many frames of the same forest, before, from which no leaf
    /// falls.
    still_ms: [Spread; 2],
}

/// Three small trees of so many leaves each that shed from the first frame to the last, thirty frames a
/// second. A twelfth of their leaves is kept: so many have fallen after a tenth of the frames, and slots are used again and
/// again. The wind carries the leaves past the camera, which has the trees in its back: the frame is
/// the leaves'.
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
    let mut falls = Falls {
        shedding: Shedding { start: 0.0, duration, peak: 0.0, tree_spread: 0.0, burst: 0.5 },
        wind: Wind::new(5.0, 0.0, 0.5, 1),
        capacity: (leaves / 4).max(1),
        ..Falls::default()
    };
    falls.groups = trees.iter().map(|t| falls.group_for(t)).collect();
    Stage { forest: placement.place(Terrain::flat(), &[1.0]), trees, falls }
}

/// What a run of frames took: milliseconds by the wall clock and on the GPU, and the memory after the
/// first tenth and at its end.
struct Run {
    wall: Vec<f64>,
    gpu: Vec<f64>,
    memory_mib: Option<[f64; 2]>,
}

impl Run {
    fn new(gpu: &mut Gpu, easel: &Easel, forest: &GpuForest, frames: u32) -> anyhow::Result<Self> {
        let (mut wall, mut on_gpu) = (Vec::new(), Vec::new());
        let mut early = None;
        for frame in 0..frames {
            let camera = Camera {
                eye: Vec3::new(14.0, 2.5, 0.0),
                target: Vec3::new(40.0, 1.0, 0.0),
                fov_y: 0.9,
                near: 0.1,
            };
            let view = View {
                time: frame as f32 / 30.0,
                season: 0.55,
                shadows: false,
                quality: Quality::LOW,
                ..View::new(camera)
            };
            let measured = easel.frame(gpu, forest, &view)?;
            wall.push(measured.wall);
            on_gpu.push(measured.gpu.get("frame").copied().unwrap_or(f64::NAN));
            if frame == frames / 10 {
                early = resident_mib();
            }
        }
        Ok(Self { wall, gpu: on_gpu, memory_mib: early.zip(resident_mib()).map(|(a, b)| [a, b]) })
    }

    /// MiB in a thousand frames.
    fn growth(&self) -> Option<f64> {
        let [early, late] = self.memory_mib?;
        Some((late - early) / (0.9e-3 * self.wall.len() as f64))
    }

    /// Once the slots are full, frames should cost the same for ever: the first and the last fifth of
    /// what follows the first tenth.
    fn fifths(times: &[f64]) -> [Spread; 2] {
        let times = &times[times.len() / 10..];
        let fifth = (times.len() / 5).max(1).min(times.len());
        [Spread::of(&times[..fifth]), Spread::of(&times[times.len() - fifth..])]
    }
}

pub fn run(frames: u32, leaves: u32, gpu: &mut Gpu) -> anyhow::Result<Soak> {
    let stage = stage(frames, leaves);
    let easel = Easel::new(gpu, (64, 36));
    let still = easel.forest(gpu, &stage, &Falls::none());
    let still = Run::new(gpu, &easel, &still, (frames / 10).max(1))?;
    let forest = easel.forest(gpu, &stage, &stage.falls);
    let run = Run::new(gpu, &easel, &forest, frames)?;
    let [first, last] = Run::fifths(&run.wall);
    let gpu_ms = Run::fifths(&run.gpu);
    let still_ms = Run::fifths(&still.wall);
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

fn resident_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:"))?;
    let kib: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib / 1024.0)
}
