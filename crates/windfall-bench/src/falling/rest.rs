//! Part r: a million leaves on the ground, out of view and in view, against the same forest without them and against a
//! plain instanced draw of as many.

use super::workload::{extent, overview, shower};
use super::{Args, WARM_UP};
use crate::baseline::InstancedBaseline;
use crate::harness::{Harness, upload_models};
use crate::scenery::clip_from_world;
use crate::statistics::Quartiles;
use glam::{DVec3, Vec3};
use serde::Serialize;
use windfall_gpu::{Camera, Falls, View};
use windfall_host::device::Gpu;
use windfall_scenes::Stage;

/// Moment of the first frame, seconds: the last leaf landed and withered long before.
const TIME: f64 = 900.0;
/// Frames in which leaves come to rest after a seek.
const SETTLE: u32 = 4;

#[derive(Serialize)]
pub struct AtRest {
    leaves: u64,
    away_ms: Quartiles,
    away_without_ms: Quartiles,
    /// Median over frames of what a frame took more with the leaves than the one without that followed it.
    away_more_ms: Quartiles,
    towards_ms: Quartiles,
    towards_without_ms: Quartiles,
    towards_more_ms: Quartiles,
    bare_draw_ms: Quartiles,
    leaves_over_bare_draw: f64,
}

/// Runs part r.
pub fn measure(args: &Args, gpu: &mut Gpu, harness: &Harness) -> anyhow::Result<AtRest> {
    let stage = shower(args.many);
    let models = upload_models(gpu, &stage)?;
    let mut lying = harness.plant(gpu, &stage, &models)?;
    let bare = Stage { falls: Falls { capacity: 0, ..stage.falls.clone() }, ..stage.clone() };
    let mut without = harness.plant(gpu, &bare, &models)?;
    let towards = overview(&stage);
    let eye = towards.camera.eye;
    let away = View {
        camera: Camera::look_at(eye, eye + DVec3::new(0.0, 0.0, 10.0), 0.9, 0.1),
        ..towards.clone()
    };
    let far = extent(&stage, 4.0);
    let bounds = (Vec3::new(-far, 0.0, -far), Vec3::new(far, 0.1, far));
    let aspect = args.size.0 as f32 / args.size.1 as f32;
    let count = stage.leaf_count() as u32;
    // As leaves of a few pixels are drawn.
    let foliage = &stage.trees[0].foliage;
    let simple = foliage.simple_shapes.first().and_then(Option::as_ref);
    let shape = simple.unwrap_or(&foliage.shapes[0]);
    let clip = clip_from_world(&towards.camera, aspect);
    let baseline = InstancedBaseline::new(gpu, count, shape, bounds, clip, args.size);
    let mut pair = |view: &View| -> anyhow::Result<[Quartiles; 3]> {
        let (mut with, mut rest, mut more) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..WARM_UP + SETTLE + args.frames {
            let time = TIME + f64::from(i) / 30.0;
            let a = harness.measure(gpu, &mut lying, (time, view))?.wall_ms;
            let b = harness.measure(gpu, &mut without, (time, view))?.wall_ms;
            if i >= WARM_UP + SETTLE {
                with.push(a);
                rest.push(b);
                more.push(a - b);
            }
        }
        Ok([&with, &rest, &more].map(|v| Quartiles::of(v)))
    };
    let [away_ms, away_without_ms, away_more_ms] = pair(&away)?;
    let [towards_ms, towards_without_ms, towards_more_ms] = pair(&towards)?;
    let mut draws = Vec::new();
    for i in 0..WARM_UP + args.frames {
        let draw = baseline.measure(gpu)?.draw_ms;
        if i >= WARM_UP {
            draws.push(draw);
        }
    }
    let bare_draw_ms = Quartiles::of(&draws);
    let leaves_over_bare_draw = towards_more_ms.median / bare_draw_ms.median;
    println!(
        "\n(r) {count} leaves at rest on the ground, compute; medians (quartiles) of {} frames, ms",
        args.frames
    );
    println!("frame, looking away                      {away_ms}");
    println!("the same without those leaves            {away_without_ms}");
    println!("more, frame by frame                     {away_more_ms}   (goal 1)");
    println!("frame, looking at them                   {towards_ms}");
    println!("the same without those leaves            {towards_without_ms}");
    println!("more, frame by frame                     {towards_more_ms}");
    println!("bare instanced draw, two triangles each  {bare_draw_ms}");
    println!("the leaves' part over the bare draw      {leaves_over_bare_draw:.2}   (goal 1.3)");
    Ok(AtRest {
        leaves: u64::from(count),
        away_ms,
        away_without_ms,
        away_more_ms,
        towards_ms,
        towards_without_ms,
        towards_more_ms,
        bare_draw_ms,
        leaves_over_bare_draw,
    })
}
