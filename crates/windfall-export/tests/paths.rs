//! Path textures, played by the shader that ships.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::{MOMENTS, Place, angle, reference, select};
use std::io::Cursor;
use wgpu::util::DeviceExt;
use windfall_core::glam::{Quat, Vec4};
use windfall_core::wind::Wind;
use windfall_export::Filter;
use windfall_export::vat::Engine;
use windfall_export::vat::paths::{PathTextures, TEXELS};

/// The texels of an OpenEXR file, and its width.
fn read(bytes: &[u8]) -> (usize, Vec<Vec4>) {
    let image = image::load_from_memory_with_format(bytes, image::ImageFormat::OpenExr).unwrap();
    let image = image.to_rgba32f();
    (image.width() as usize, image.pixels().map(|p| Vec4::from(p.0)).collect())
}

/// What a shader makes of it: textures as storage buffers, sampled between texels by hand.
const KERNEL: &str = "
@group(0) @binding(0) var<storage, read> paths: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> leaves: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> poses: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> facts: array<f32>; // time, width, rate, soft drop, soft time, settle, response

fn sampled(row: u32, seconds: f32) -> vec4<f32> {
    let width = u32(facts[1]);
    let at = min(seconds * facts[2], facts[1] - 1.001);
    let i = u32(at);
    let a = paths[row * width + i];
    let b = paths[row * width + i + 1u];
    return mix(a, b, at - f32(i));
}

@compute @workgroup_size(64)
fn kernel(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&leaves) / 6u { return; }
    let l = id.x * 6u;
    let elapsed = facts[0] - leaves[l].w;
    let times = windfall_path_times(elapsed, leaves[l + 1u], leaves[l + 4u], facts[4], facts[5]);
    let row = 2u * u32(leaves[l + 5u].z);
    let along = sampled(row, times.x);
    let turning = sampled(row, times.y);
    let on_path = normalize(sampled(row + 1u, times.y));
    poses[2u * id.x] = vec4(windfall_path_place(elapsed, leaves[l], leaves[l + 1u], leaves[l + 4u],
        leaves[l + 5u], along.xyz, times.z, facts[6]), 0.0);
    poses[2u * id.x + 1u] = windfall_path_rotation(leaves[l + 2u], leaves[l + 3u], leaves[l + 4u], on_path,
        turning.w, facts[3], times.z);
}
";

fn play(paths: &[Vec4], leaves: &[Vec4], facts: [f32; 7]) -> Vec<Vec4> {
    let (device, queue) = windfall_testing::device();
    let source = format!("{}{KERNEL}", include_str!("../shaders/windfall_paths.wgsl"));
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: Some("kernel"),
        compilation_options: Default::default(),
        cache: None,
    });
    let buffer = |contents: &[u8]| {
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        })
    };
    let count = leaves.len() / TEXELS;
    let buffers = [
        buffer(bytemuck::cast_slice(paths)),
        buffer(bytemuck::cast_slice(leaves)),
        buffer(&vec![0; count * 32]),
        buffer(bytemuck::cast_slice(&facts)),
    ];
    let entries: Vec<_> = (0..)
        .zip(&buffers)
        .map(|(binding, b)| wgpu::BindGroupEntry { binding, resource: b.as_entire_binding() })
        .collect();
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups(count.div_ceil(64) as u32, 1, 1);
    drop(pass);
    queue.submit([encoder.finish()]);
    bytemuck::pod_collect_to_vec(&windfall_testing::read(&device, &queue, &buffers[2]))
}

/// Largest errors of leaves that hang, fall and lie: metres and degrees.
fn errors(wind: Wind) -> [(f32, f32); 3] {
    let place = Place::new();
    let mut source = place.source();
    source.wind = wind;
    let selection = select(&source, MOMENTS, Filter::NONE);
    let textures = PathTextures::new(&selection, Engine::Godot).unwrap();
    let (mut paths, mut leaves) = (Cursor::new(Vec::new()), Cursor::new(Vec::new()));
    textures.write_paths(&mut paths).unwrap();
    textures.write_leaves(&mut leaves, &mut |_| ()).unwrap();
    let (width, paths) = read(paths.get_ref());
    let (columns, texels) = read(leaves.get_ref());
    let of_leaf = |i: usize| {
        let first = i / columns * TEXELS * columns + i % columns;
        (0..TEXELS).map(move |k| first + k * columns)
    };
    let leaves: Vec<Vec4> =
        (0..selection.len()).flat_map(|i| of_leaf(i).map(|at| texels[at])).collect();
    let facts: serde_json::Value =
        serde_json::from_slice(&textures.sidecar("p", "l", "m")).unwrap();
    let number = |name: &str| facts[name].as_f64().unwrap() as f32;
    let mut worst = [(0.0f32, 0.0f32); 3];
    for frame in [MOMENTS.first, MOMENTS.first + 20, MOMENTS.first + MOMENTS.count - 1] {
        let seconds = (MOMENTS.time(frame) - MOMENTS.time(MOMENTS.first)) as f32;
        let poses = play(
            &paths,
            &leaves,
            [
                seconds,
                width as f32,
                number("samplesPerSecond"),
                number("softDrop"),
                number("softTime"),
                number("settleTime"),
                number("windResponse"),
            ],
        );
        let expected = reference(&source, MOMENTS.time(frame));
        for i in 0..selection.len() {
            let leaf = &expected[&selection.id(i)];
            let off = poses[2 * i].truncate().distance(leaf.position);
            let turned = angle(Quat::from_vec4(poses[2 * i + 1]), leaf.orientation);
            let of =
                ["hanging", "falling", "landed"].iter().position(|p| *p == leaf.phase).unwrap();
            worst[of] = (worst[of].0.max(off), worst[of].1.max(turned));
        }
    }
    worst
}

#[test]
fn in_a_steady_wind_leaves_are_where_the_reference_has_them() {
    let [hanging, falling, landed] = errors(Wind::new(2.0, 0.8, 0.0, 7));
    println!("{hanging:?} {falling:?} {landed:?}");
    assert!(hanging.0 < 1e-3 && hanging.1 < 0.1, "{hanging:?}");
    // Between samples, 1/120 s apart, the path is a line.
    assert!(falling.0 < 0.01 && falling.1 < 2.0, "{falling:?}");
    // Lifted straight up, not along the ground's normal.
    assert!(landed.0 < 0.01 && landed.1 < 2.0, "{landed:?}");
}

#[test]
fn gusts_are_smoothed_on_the_way_and_not_at_its_ends() {
    let [hanging, falling, landed] = errors(Wind::new(2.0, 0.8, 0.8, 7));
    println!("{hanging:?} {falling:?} {landed:?}");
    assert!(hanging.0 < 1e-3 && landed.0 < 0.01, "{hanging:?} {landed:?}");
    assert!((0.02..1.0).contains(&falling.0) && falling.1 < 2.0, "{falling:?}");
}
