//! Path tables, terrain and colours as one list of vectors, and the constants of a forest's falls.

use crate::base::constants::{MODEL_HEAD, PALETTE, TABLE_WIDTH};
use crate::base::packing::{pack_rotation, words};
use crate::base::shared::{FallFrame, Model};
use crate::scene::falls::Falls;
use bytemuck::Zeroable;
use glam::{Quat, UVec4, Vec3, Vec4};
use windfall_core::forest::Terrain;
use windfall_core::path::{Edition, FallSettings, Flight, PathTables, Variation};
use windfall_core::shed::Shedding;
use windfall_core::wind::Wind;

// What is pushed for each model below.
const _: () = assert!(MODEL_HEAD == 3 && PALETTE == 8);

/// Path tables and terrain as vectors (`base/wgsl/tables.wgsl`), and the frame's constants.
pub fn tables(
    falls: &Falls,
    wind: &Wind,
    terrain: &Terrain,
    models: &[Model],
) -> (Vec<UVec4>, FallFrame) {
    let mut frame = FallFrame::zeroed();
    let mut out = flights(falls, &mut frame);
    frame.ground_table = push_scalars(&mut out, terrain.heights());
    frame.model_table = out.len() as u32;
    for model in models {
        let head = [
            UVec4::new(model.palette_count, model.palette_spread.to_bits(), 0, 0),
            words(model.crown_center.extend(0.0)),
            words(model.crown_extent.extend(0.0)),
        ];
        out.extend(head);
        out.extend(model.palette.map(words));
    }

    describe_wind(&mut frame, wind, 0.0);
    describe_shedding(&mut frame, &falls.shedding);
    let settings = &falls.settings;
    frame.wind_response = settings.wind_response;
    frame.soft_drop = settings.soft_drop;
    frame.soft_time = settings.soft_time;
    frame.settle_time = settings.settle_time;
    frame.settle_turn = settings.settle_turn;
    match &falls.variation {
        Variation::Paper(Edition::Of2008) => frame.paper_variation = 1,
        Variation::Paper(Edition::Of2007) => frame.paper_variation = 2,
        Variation::Hashed(bounds) => {
            (frame.scale_low, frame.scale_high) = (bounds.scale.start, bounds.scale.end);
            (frame.rate_low, frame.rate_high) = (bounds.rate.start, bounds.rate.end);
        }
    }
    frame.ground_side = terrain.side();
    frame.ground_cell = terrain.cell();
    frame.ground_highest = terrain.range().1;
    frame.ground_steepest = terrain.steepest();
    (out, frame)
}

/// Four numbers a vector; returns where they begin.
fn push_scalars(out: &mut Vec<UVec4>, values: &[f32]) -> u32 {
    let first = out.len() as u32;
    out.extend(values.chunks(4).map(|c| {
        let mut v = [0.0; 4];
        v[..c.len()].copy_from_slice(c);
        words(Vec4::from(v))
    }));
    first
}

/// Samples, their lows, flights and groups (`base/wgsl/tables.wgsl`).
fn flights(falls: &Falls, frame: &mut FallFrame) -> Vec<UVec4> {
    let paths = falls.paths.tables();
    frame.path_grain = paths.grain;
    let mut out: Vec<UVec4> = Vec::new();
    let mut lows: Vec<f32> = Vec::new();
    let mut first_sample = vec![0; paths.joints.len()];
    for path in &paths.paths {
        for j in path.first_joint..path.first_joint + path.joint_count {
            let joint = &paths.joints[j as usize];
            let from = Vec3::from(paths.samples[PathTables::index(path, joint, joint.to)].position);
            first_sample[j as usize] = out.len() as u32;
            for i in 0..joint.from + 2 {
                let sample = &paths.samples[PathTables::index(path, joint, i)];
                let at = Vec3::from(sample.position) - from;
                let [x, y, z] = at.to_array().map(|v| (v / paths.grain).round() as i32 as u32);
                let [xy, zw] = pack_rotation(Quat::from_array(sample.orientation));
                out.push(UVec4::new(x << 11 | (y >> 11 & 0x7ff), z << 11 | (y & 0x7ff), xy, zw));
                lows.push(sample.low - from.y);
            }
        }
    }
    frame.low_table = push_scalars(&mut out, &lows);
    frame.flight_table = out.len() as u32;
    for flight in &paths.flights {
        let path = &paths.paths[flight.path as usize];
        let joint = &paths.joints[flight.joint as usize];
        let sample = |i| &paths.samples[PathTables::index(path, joint, i)];
        let [begin, to] = [flight.start, joint.to].map(|i| Vec3::from(sample(i).position));
        // A turn of which the sine is 0 would be divided by: next to it is near enough.
        let h = joint.half_turn + u32::from(joint.half_turn << 1 == 0);
        let (s, c) = (f64::from(h) * std::f64::consts::TAU / 4_294_967_296.0).sin_cos();
        let [x, y, z] = joint.lap.map(f64::from);
        let lap = [(x * c - z * s) / s, y, (z * c + x * s) / s].map(|v| v as f32);
        let first = first_sample[flight.joint as usize];
        let soft = soft_samples(paths, flight, &falls.settings).min(NEVER_SOFT_LEFT);
        out.push(UVec4::new(first, flight.start | soft << 20, joint.from, joint.to));
        out.push(words(Vec3::from(lap).extend(path.rate)));
        out.push(UVec4 { w: h, ..words((to - begin).extend(0.0)) });
        let lows = [sample(flight.start).low, sample(joint.from).low].map(|low| low - to.y);
        out.push(words(Vec4::new(lows[0], lows[1], path.fastest_down, path.fastest_along)));
    }
    frame.group_table = out.len() as u32;
    out.extend(paths.group_flights.iter().map(|g| UVec4::new(g.first, g.count, g.plain, 0)));
    out
}

/// As many samples: a flight is taken to be near its twig for ever.
const NEVER_SOFT_LEFT: u32 = 0xfff;

/// Samples after which a flight has dropped far enough to have left the twig's orientation behind.
fn soft_samples(paths: &PathTables, flight: &Flight, settings: &FallSettings) -> u32 {
    let path = &paths.paths[flight.path as usize];
    let joint = &paths.joints[flight.joint as usize];
    let low = |i| paths.samples[PathTables::index(path, joint, i)].low;
    let level = low(flight.start) - settings.soft_drop.max(0.0);
    let samples = (flight.start..=joint.from).position(|i| low(i) <= level);
    samples.map_or(NEVER_SOFT_LEFT, |n| n as u32)
}

/// When leaves detach.
pub fn describe_shedding(frame: &mut FallFrame, shedding: &Shedding) {
    frame.shed_duration = shedding.duration;
    frame.shed_peak = shedding.peak;
    frame.shed_burst = shedding.burst;
}

/// The wind as falls have it, whose times begin with the shedding.
pub fn describe_wind(frame: &mut FallFrame, wind: &Wind, start: f64) {
    let part = start.rem_euclid(Wind::PERIOD) / Wind::PERIOD;
    for (gust, into) in wind.gusts.iter().zip(&mut frame.gusts) {
        let phase = f64::from(gust.phase) + f64::from(gust.cycles) * part;
        let phase = phase.rem_euclid(1.0) as f32;
        *into = Vec4::new(gust.amplitude.x, gust.amplitude.y, gust.cycles as f32, phase);
    }
    frame.wind_mean = wind.mean;
    frame.wind_travel = wind.travel;
    frame.wind_slowness = wind.slowness;
    frame.wind_fastest = wind.fastest();
    frame.gust_rate = Shedding::gust_rate(wind);
}

/// The tables as a texture.
pub fn table_view(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    mut table: Vec<UVec4>,
) -> wgpu::TextureView {
    let rows = (table.len() as u32).div_ceil(TABLE_WIDTH).max(1);
    table.resize((rows * TABLE_WIDTH) as usize, UVec4::ZERO);
    let size = wgpu::Extent3d { width: TABLE_WIDTH, height: rows, depth_or_array_layers: 1 };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("path tables"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Uint,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    queue.write_texture(
        texture.as_image_copy(),
        bytemuck::cast_slice(&table),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(TABLE_WIDTH * size_of::<UVec4>() as u32),
            rows_per_image: None,
        },
        size,
    );
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
