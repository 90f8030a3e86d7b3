//! Part c: cost against the number of leaves in the air.

use super::workload::{overview, shower};
use super::{Args, POSE_PASSES, WARM_UP};
use crate::harness::Harness;
use crate::plot::{Line, Plot};
use crate::statistics::{LinearFit, Quartiles};
use serde::Serialize;
use windfall_host::device::Gpu;

/// Bytes of a leaf in each of the largest bindings.
const BINDING_BYTES: u64 = 32;

#[derive(Serialize)]
pub struct Counts {
    /// Leaves, and milliseconds of the passes that pose and of the whole frame.
    points: Vec<(u64, f64, f64)>,
    pose_ns_per_leaf: f64,
    pose_r2: f64,
    frame_ns_per_leaf: f64,
    frame_r2: f64,
}

/// Runs part c.
pub fn measure(args: &Args, gpu: &mut Gpu, harness: &Harness) -> anyhow::Result<Counts> {
    println!("\n(c) cost against count, compute; medians of {} frames", args.frames);
    println!("{:>10}{:>14}{:>16}", "leaves", "pose, GPU ms", "frame, wall ms");
    let mut points = Vec::new();
    // The adapter's largest storage binding bounds the number of leaves; whole trees only.
    let limit = gpu.device.limits().max_storage_buffer_binding_size;
    let most = args.most.min(((limit / BINDING_BYTES) >> 16 << 16) as u32);
    let mut count = 1 << 10;
    while count <= most {
        let stage = shower(count);
        let mut planted = harness.upload(gpu, &stage)?;
        let view = overview(&stage);
        let (mut pose, mut frame) = (Vec::new(), Vec::new());
        for i in 0..WARM_UP + args.frames {
            let measured = harness.measure(gpu, &mut planted, (0.0, &view))?;
            if i >= WARM_UP {
                pose.push(measured.passes_ms(&POSE_PASSES));
                frame.push(measured.wall_ms);
            }
        }
        let (pose, frame) = (Quartiles::of(&pose).median, Quartiles::of(&frame).median);
        println!("{count:>10}{pose:>14.3}{frame:>16.2}");
        points.push((u64::from(count), pose, frame));
        count = if count < most { most.min(count * 4) } else { u32::MAX };
    }
    let per_leaf = |get: fn(&(u64, f64, f64)) -> f64| {
        let xy: Vec<(f64, f64)> = points.iter().map(|p| (p.0 as f64, get(p))).collect();
        let LinearFit { slope, r2 } = LinearFit::of(&xy);
        (slope * 1e6, r2)
    };
    let ((pose_ns, pose_r2), (frame_ns, frame_r2)) = (per_leaf(|p| p.1), per_leaf(|p| p.2));
    println!(
        "pose: {pose_ns:.1} ns a leaf (R2 {pose_r2:.4}); frame: {frame_ns:.1} ns (R2 {frame_r2:.4})"
    );
    Ok(Counts { points, pose_ns_per_leaf: pose_ns, pose_r2, frame_ns_per_leaf: frame_ns, frame_r2 })
}

impl Counts {
    /// Both times over the number of leaves.
    pub fn plot(&self) -> anyhow::Result<String> {
        let line = |name: &str, get: fn(&(u64, f64, f64)) -> f64| Line {
            name: name.to_owned(),
            points: self.points.iter().map(|p| (p.0 as f64, get(p))).collect(),
        };
        let plot = Plot {
            title: "Cost against leaves in the air, logarithmic".into(),
            axes: ["leaves", "ms"],
            log: true,
            lines: vec![line("pose pass", |p| p.1), line("whole frame", |p| p.2)],
        };
        plot.svg()
    }
}
