//! SFS, section 4.2: immediate mode, vertex arrays and buffers.

use super::report::{Row, Table};
use crate::baseline::{Submission, Submitted};
use crate::scenery::clip_from_world;
use crate::statistics::Quartiles;
use glam::DVec3;
use windfall_gpu::Camera;
use windfall_host::device::Gpu;
use windfall_tree::Species;

/// Frame rates over immediate mode that the paper prints.
const ARRAYS: f64 = 4.5;
const BUFFERS: f64 = 5.1;

/// One tree, handed to the GPU in each way in turn.
pub fn table(gpu: &Gpu, quick: bool) -> anyhow::Result<Table> {
    let (size, leaves, frames) =
        if quick { ((320, 240), 8000, 5) } else { ((800, 600), 20_000, 15) };
    println!("section 4.2 of SFS: immediate mode and buffers");
    let tree = Species::Oak.grow_with(1, leaves);
    let (low, high) = tree.bounds();
    let middle = (0.5 * (low + high)).as_dvec3();
    let eye = middle + DVec3::Z * f64::from(1.6 * (high - low).max_element());
    let camera = Camera::look_at(eye, middle, 0.7, 0.1);
    let matrix = clip_from_world(&camera, size.0 as f32 / size.1 as f32);
    let submitted = Submitted::new(gpu, &tree, matrix, size);
    let mut times: [Vec<f64>; Submission::ALL.len()] = Default::default();
    for frame in 0..frames + 2 {
        for (way, times) in Submission::ALL.into_iter().zip(&mut times) {
            let ms = submitted.measure(gpu, way)?;
            // Pipelines are compiled at the first.
            if frame >= 2 {
                times.push(ms);
            }
        }
    }
    let immediate = Quartiles::of(&times[0]).median;
    let rows = Submission::ALL.into_iter().zip(&times).map(|(way, times)| {
        let ms = Quartiles::of(times);
        let (name, printed) = match way {
            Submission::Immediate => ("immediate: a write and a draw for each leaf", Some(1.0)),
            Submission::Arrays => ("arrays: all is written in each frame", Some(ARRAYS)),
            Submission::Buffers => ("buffers that stay", Some(BUFFERS)),
            Submission::Instances => ("buffers with a record a leaf (ours)", None),
        };
        Row {
            name: name.into(),
            ms,
            measured: Some(immediate / ms.median),
            printed,
            notes: String::new(),
        }
    });
    Ok(Table {
        id: "sfs-4.2-submission".into(),
        title: "SFS, section 4.2: immediate mode, vertex arrays, vertex buffers".into(),
        scene: format!(
            "The leaves of one oak, {:.1} million vertices with normals, texture coordinates and colours, unlit, {}x{}",
            submitted.vertices() as f64 / 1e6,
            size.0,
            size.1
        ),
        ratio: "frame rate over immediate mode".into(),
        rows: rows.collect(),
        remark: "OpenGL's immediate mode is gone from today's interfaces; here each leaf is written and drawn by calls of \
                 its own, where OpenGL had a call for each vertex. What is saved is work of the CPU between the calls. A \
                 software adapter draws on that CPU, so that drawing takes most of each frame and the ratios are smaller \
                 than the paper's wherever the rows are close; instances add a rotation for each vertex and save memory: a \
                 record of 32 bytes for a leaf instead of its vertices."
            .into(),
        plot: None,
    })
}
