//! What the adapter can do at best, in the same run: the floor under the other tables.

use super::report::{Row, Table};
use crate::baseline::{Floor, InstancedBaseline};
use crate::falling::workload::{overview, shower};
use crate::harness::COLOR_FORMAT;
use crate::scenery::clip_from_world;
use crate::statistics::Quartiles;
use anyhow::Context;
use glam::Vec3;
use std::time::Instant;
use windfall_gpu::Capture;
use windfall_host::device::Gpu;

/// Leaves of the copy kernel and of the bare draw.
const LEAVES: u32 = 1 << 16;
/// Triangles of the trees of VB's walk.
const TRIANGLES: u64 = 800_000;

/// Bare draws, a copy, and a readback.
pub fn measure(gpu: &Gpu, quick: bool) -> anyhow::Result<Table> {
    let (size, frames) = if quick { ((320, 180), 5) } else { ((640, 360), 15) };
    println!("limits of the adapter");
    let stage = shower(LEAVES);
    let view = overview(&stage);
    let matrix = clip_from_world(&view.camera, size.0 as f32 / size.1 as f32);
    let shape = &stage.trees[0].foliage.shapes[0];
    let bounds = (Vec3::new(-4.0, 0.0, -4.0), Vec3::new(4.0, 14.0, 4.0));
    let leaves = InstancedBaseline::new(gpu, LEAVES, shape, bounds, matrix, size);
    let floors = [0, TRIANGLES].map(|triangles| Floor::new(gpu, size, triangles));
    let picture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d { width: size.0, height: size.1, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: COLOR_FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let mut times: [Vec<f64>; 5] = Default::default();
    for frame in 0..frames + 2 {
        let bare = leaves.measure(gpu)?;
        let start = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let capture = Capture::encode(&gpu.device, &mut encoder, &picture);
        gpu.queue.submit([encoder.finish()]);
        capture.map();
        gpu.wait()?;
        capture.take().context("the picture did not arrive")??;
        let readback = start.elapsed().as_secs_f64() * 1e3;
        let all = [
            floors[0].measure(gpu)?,
            floors[1].measure(gpu)?,
            bare.copy_ms,
            bare.draw_ms,
            readback,
        ];
        // Pipelines are compiled at the first.
        if frame >= 2 {
            times.iter_mut().zip(all).for_each(|(times, time)| times.push(time));
        }
    }
    let names = [
        "clear and tone map of four samples".to_owned(),
        format!("the same with {}K bare triangles", TRIANGLES / 1000),
        format!("copy kernel, 32 bytes for each of {LEAVES} leaves"),
        format!("bare draw of {LEAVES} leaves of {} triangles", shape.indices.len() / 3),
        "readback of a picture".to_owned(),
    ];
    let rows = names.into_iter().zip(times).map(|(name, times)| Row {
        name,
        ms: Quartiles::of(&times),
        measured: None,
        printed: None,
        notes: String::new(),
    });
    Ok(Table {
        id: "limits".into(),
        title: "Limits of the adapter".into(),
        scene: format!("The least work of each kind at {}x{}, in the same run", size.0, size.1),
        ratio: "none".into(),
        rows: rows.collect(),
        remark: "What the kinds of work of which the frames below are made cost alone, with the least that does them. \
                 The bare triangles cover the picture twice and are all in view; those of the walk's trees are smaller, \
                 and many are out of view, hidden or drawn in a simpler form."
            .into(),
        plot: None,
    })
}
