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
use windfall_gpu::{Camera, Falls, Quality, View};
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
}

/// Three small trees that shed from the first frame to the last, thirty frames a second. A twelfth of
/// their leaves is kept: so many have fallen after a tenth of the frames, and slots are used again and
/// again. The wind carries the leaves past the camera, which has the trees in its back: the frame is
/// the leaves'.
fn stage(frames: u32) -> Stage {
    let trees = vec![Species::Birch.grow_with(1, 4000)];
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
        capacity: 1000,
        ..Falls::default()
    };
    falls.groups = trees.iter().map(|t| falls.group_for(t)).collect();
    Stage { forest: placement.place(Terrain::flat(), &[1.0]), trees, falls }
}

pub fn run(frames: u32, gpu: &mut Gpu) -> anyhow::Result<Soak> {
    let stage = stage(frames);
    let easel = Easel::new(gpu, (64, 36));
    let forest = easel.forest(gpu, &stage, &stage.falls);
    let mut wall = Vec::with_capacity(frames as usize);
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
        wall.push(easel.frame(gpu, &forest, &view)?.wall);
        if frame == frames / 10 {
            early = resident_mib();
        }
    }
    // Once the slots are full, frames should cost the same for ever.
    let wall = &wall[wall.len() / 10..];
    let fifth = (wall.len() / 5).max(1).min(wall.len());
    let (first, last) = (Spread::of(&wall[..fifth]), Spread::of(&wall[wall.len() - fifth..]));
    let soak = Soak {
        frames,
        leaves: stage.leaf_count(),
        kept: stage.falls.capacity,
        first_fifth_ms: first,
        last_fifth_ms: last,
        drift: last.median / first.median,
        memory_mib: early.zip(resident_mib()).map(|(a, b)| [a, b]),
    };
    println!(
        "\n(d) {frames} frames of continuous shedding, compute, 64x36; {} leaves, {} kept",
        soak.leaves, soak.kept
    );
    println!("first fifth after a tenth of them, ms     {first}");
    println!("last fifth                               {last}   {:.3} x", soak.drift);
    match soak.memory_mib {
        Some([a, b]) => println!("memory after a tenth, at the end, MiB    {a:.1}, {b:.1}"),
        None => println!("memory: not known on this system"),
    }
    Ok(soak)
}

fn resident_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:"))?;
    let kib: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib / 1024.0)
}
