//! Part b: a million leaves in the air, against a copy kernel and a plain instanced draw.

use super::workload::{extent, overview, shower};
use super::{Args, POSE_PASSES, WARM_UP};
use crate::baseline::InstancedBaseline;
use crate::harness::{Harness, upload_models};
use crate::scenery::clip_from_world;
use crate::statistics::Quartiles;
use anyhow::Context;
use glam::Vec3;
use serde::Serialize;
use windfall_gpu::Falls;
use windfall_host::device::Gpu;
use windfall_scenes::Stage;

#[derive(Serialize)]
pub struct Many {
    leaves: u64,
    copy_ms: Quartiles,
    /// Posing of all leaves, once a frame, and gathering of those in view.
    pose_ms: Quartiles,
    /// The pass for leaves that detach, land or vanish in the frame.
    change_ms: Quartiles,
    pose_over_copy: f64,
    bare_draw_ms: Quartiles,
    /// The baseline draw with the two-triangle shape of small leaves.
    bare_simple_ms: Quartiles,
    frame_ms: Quartiles,
    frame_without_ms: Quartiles,
    leaves_over_bare_draw: f64,
    leaves_over_bare_simple: f64,
    slot_bytes: u32,
    draw_bytes: u32,
}

/// Runs part b.
pub fn measure(args: &Args, gpu: &mut Gpu, harness: &Harness) -> anyhow::Result<Many> {
    let stage = shower(args.many);
    let models = upload_models(gpu, &stage)?;
    let mut falling = harness.plant(gpu, &stage, &models)?;
    // The same trees without the detached leaves.
    let bare = Stage { falls: Falls { capacity: 0, ..stage.falls.clone() }, ..stage.clone() };
    let mut without = harness.plant(gpu, &bare, &models)?;
    let view = overview(&stage);
    let far = extent(&stage, 4.0);
    let bounds = (Vec3::new(-far, 0.0, -far), Vec3::new(far, 14.0, far));
    let aspect = args.size.0 as f32 / args.size.1 as f32;
    let count = stage.leaf_count() as u32;
    let clip_from_world = clip_from_world(&view.camera, aspect);
    let foliage = &stage.trees[0].foliage;
    let simple = foliage.simple_shapes.first().and_then(Option::as_ref);
    let simple = simple.context("the species' leaf has no simple shape")?;
    let [baseline, baseline_simple] = [&foliage.shapes[0], simple]
        .map(|shape| InstancedBaseline::new(gpu, count, shape, bounds, clip_from_world, args.size));
    let (mut copy, mut pose, mut change) = (Vec::new(), Vec::new(), Vec::new());
    let (mut draw, mut draw_simple) = (Vec::new(), Vec::new());
    let (mut frame, mut rest) = (Vec::new(), Vec::new());
    for i in 0..WARM_UP + args.frames {
        let full_shape = baseline.measure(gpu)?;
        let simple_shape = baseline_simple.measure(gpu)?;
        let with_leaves = harness.measure(gpu, &mut falling, (0.0, &view))?;
        let without_leaves = harness.measure(gpu, &mut without, (0.0, &view))?;
        if i >= WARM_UP {
            copy.push(full_shape.copy_ms);
            draw.push(full_shape.draw_ms);
            draw_simple.push(simple_shape.draw_ms);
            pose.push(with_leaves.passes_ms(&POSE_PASSES));
            change.push(with_leaves.passes_ms(&["change"]));
            frame.push(with_leaves.wall_ms);
            rest.push(without_leaves.wall_ms);
        }
    }
    let [copy_ms, pose_ms, change_ms, bare_draw_ms, bare_simple_ms] =
        [&copy, &pose, &change, &draw, &draw_simple].map(|v| Quartiles::of(v));
    let [frame_ms, frame_without_ms] = [&frame, &rest].map(|v| Quartiles::of(v));
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
