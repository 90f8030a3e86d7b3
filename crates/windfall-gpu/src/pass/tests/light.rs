//! The shaders' light and motion against `windfall-core`: the shipped functions, run
//! over buffers.

use crate::base::shared::{Frame, SkyUniform};
use crate::base::wgsl::{Settings, compose};
use crate::view::light::Sky;
use bytemuck::Zeroable;
use glam::{Quat, Vec2, Vec3, Vec4};
use half::f16;
use wgpu::util::DeviceExt;
use windfall_core::foliage::season::ripeness;
use windfall_core::foliage::{Foliage, Leaf, Palette};
use windfall_core::forest::Instance;
use windfall_core::light::{Ambient, Atmosphere, SkyTable, leaf};
use windfall_core::rng::Rng;
use windfall_core::simplify::{Branch, Shading};
use windfall_core::sway;
use windfall_core::wind::Wind;

/// A sky's light by the CPU.
struct Light {
    table: SkyTable,
    ambient: Ambient,
}

fn light() -> Light {
    let sky = Sky::default();
    let table = Atmosphere { turbidity: sky.turbidity }.sky(sky.sun_elevation);
    let sun = sky.sun_direction();
    let heading = Vec2::new(sun.x, sun.z).normalize_or(Vec2::Y);
    let above = |d: Vec3| if d.y > 0.0 { table.towards(d, heading) } else { Vec3::splat(0.1) };
    Light { ambient: Ambient::project(above), table }
}

/// The frame at a time in seconds.
fn frame(time: f64, wind: &Wind, light: &Light) -> Frame {
    let mut frame = Frame::zeroed();
    let uniform = SkyUniform {
        ambient: light.ambient.0.map(|c| c.extend(0.0)),
        sun_color: light.table.sun,
        sky_scale: 1.0,
    };
    frame.ambient = uniform.ambient;
    frame.sun_color = uniform.sun_color;
    frame.sun_direction = Sky::default().sun_direction();
    frame.season = 0.5;
    frame.sway = 1.0;
    frame.exposure = 1.0;
    frame.time = Wind::reduced(time);
    frame.gusts =
        wind.gusts.map(|g| Vec4::new(g.amplitude.x, g.amplitude.y, g.cycles as f32, g.phase));
    frame.wind_mean = wind.mean;
    frame.wind_travel = wind.travel;
    frame.wind_slowness = wind.slowness;
    frame
}

/// Runs `body`, WGSL that makes of `a` (two vectors) the vector `out`, for every input.
fn run(frame: &Frame, light: &Light, more: &str, body: &str, inputs: &[[Vec4; 4]]) -> Vec<Vec4> {
    let (device, queue) = windfall_testing::device();
    let kernel = format!(
        "@group(1) @binding(0) var<storage, read> inputs: array<array<vec4<f32>, 4>>;
        @group(1) @binding(1) var<storage, read_write> outputs: array<vec4<f32>>;
        @compute @workgroup_size(64)
        fn kernel(@builtin(global_invocation_id) id: vec3<u32>) {{
            if id.x >= arrayLength(&inputs) {{ return; }}
            let a = inputs[id.x];
            var out = vec4(0.0);
            {body}
            // Keeps the frame in the layout whatever the body needs of it.
            out.w += frame.time * 0.0 + textureSampleLevel(sky_table, sky_sampler, vec2(0.5), 0.0).r * 0.0;
            outputs[id.x] = out;
        }}"
    );
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("light test"),
        source: wgpu::ShaderSource::Wgsl(
            compose(&Settings { samples: 4 }, &[more, &kernel]).into(),
        ),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("light test"),
        layout: None,
        module: &module,
        entry_point: Some("kernel"),
        compilation_options: Default::default(),
        cache: None,
    });
    let uniform = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: None,
        contents: bytemuck::bytes_of(frame),
        usage: wgpu::BufferUsages::UNIFORM,
    });
    let input = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: None,
        contents: bytemuck::cast_slice(inputs),
        usage: wgpu::BufferUsages::STORAGE,
    });
    let size = inputs.len() as u64 * 16;
    let output = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    let side = SkyTable::SIDE as u32;
    let sky_texture = |label, side| {
        device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba16Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        })
    };
    let table = sky_texture("sky table", side);
    let texels: Vec<[f16; 4]> =
        light.table.radiance.iter().map(|c| c.extend(1.0).to_array().map(f16::from_f32)).collect();
    queue.write_texture(
        table.as_image_copy(),
        bytemuck::cast_slice(&texels),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(8 * side),
            rows_per_image: None,
        },
        table.size(),
    );
    let table = table.create_view(&Default::default());
    let (picture_view, sampler);
    let picture = sky_texture("no picture", 1);
    picture_view = picture.create_view(&Default::default());
    sampler = device.create_sampler(&wgpu::SamplerDescriptor {
        address_mode_u: wgpu::AddressMode::Repeat,
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    });
    let mut entries = vec![
        wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() },
        wgpu::BindGroupEntry { binding: 3, resource: wgpu::BindingResource::TextureView(&table) },
        wgpu::BindGroupEntry { binding: 5, resource: wgpu::BindingResource::Sampler(&sampler) },
    ];
    if body.contains("sky_radiance") {
        let resource = wgpu::BindingResource::TextureView(&picture_view);
        entries.push(wgpu::BindGroupEntry { binding: 4, resource });
    }
    let group = |index, entries: &[wgpu::BindGroupEntry<'_>]| {
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(index),
            entries,
        })
    };
    let groups = [
        group(0, &entries),
        group(
            1,
            &[
                wgpu::BindGroupEntry { binding: 0, resource: input.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: output.as_entire_binding() },
            ],
        ),
    ];
    let mut encoder = device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &groups[0], &[]);
        pass.set_bind_group(1, &groups[1], &[]);
        pass.dispatch_workgroups((inputs.len() as u32).div_ceil(64), 1, 1);
    }
    queue.submit([encoder.finish()]);
    bytemuck::pod_collect_to_vec(&windfall_testing::read(&device, &queue, &output))
}

fn unit_vector(rng: &mut Rng) -> Vec3 {
    Vec3::new(rng.normal(), rng.normal(), rng.normal()).normalize_or(Vec3::Y)
}

#[test]
fn leaves_scatter_as_on_the_cpu() {
    let mut rng = Rng::new(1);
    let inputs: Vec<[Vec4; 4]> = (0..4096)
        .map(|_| {
            let (light, view) = (unit_vector(&mut rng), unit_vector(&mut rng));
            let normal = unit_vector(&mut rng);
            let normal = if normal.dot(view) < 0.0 { -normal } else { normal };
            let color = Vec3::new(rng.unit(), rng.unit(), rng.unit()) * 1.3;
            let volume = rng.range(-1.0, 1.0);
            [color.extend(volume), normal.extend(0.3), light.extend(0.0), view.extend(0.0)]
        })
        .collect();
    let light = light();
    let body = "let facing = dot(a[1].xyz, a[2].xyz);
        let n_v = max(dot(a[1].xyz, a[3].xyz), 1e-3);
        out = vec4(leaf_body(leaf_diffuse(a[0].rgb), max(facing, 0.0), max(-facing, 0.0), a[0].w, a[1].w, n_v)
            + leaf_gloss(a[1].xyz, facing, a[2].xyz, a[3].xyz), 0.0);";
    let got = run(&frame(0.0, &Wind::calm(), &light), &light, "", body, &inputs);
    for (i, out) in inputs.iter().zip(got) {
        let [color, normal, light, view] = i.map(Vec4::truncate);
        let want = leaf::scatter(color, normal, normal.dot(light), i[0].w, i[1].w, light, view);
        let off = (out.truncate() - want).abs().max_element();
        assert!(off <= 1e-3 * want.max_element().max(0.1), "{i:?}: {out} for {want}");
    }
}

/// A furnace of radiance 1 from everywhere, summed in the shader over 20,000 directions of a
/// spherical Fibonacci lattice, for colours up to and beyond white and views to grazing.
#[test]
fn a_leaf_in_a_white_furnace_gains_nothing() {
    let bent = Vec3::new(0.6, 0.64, 0.48);
    let mut inputs = Vec::new();
    for color in [Vec3::ONE, Vec3::splat(1.3), Vec3::new(0.9, 0.5, 0.04), Vec3::ZERO] {
        for n_v in [1.0f32, 0.8, 0.5, 0.25, 0.1, 0.03] {
            let view = Vec3::new((1.0 - n_v * n_v).sqrt(), n_v, 0.0);
            inputs.push([color.extend(0.0), Vec4::Y, bent.extend(0.0), view.extend(0.0)]);
        }
    }
    let body = "let n = 20000u;
        for (var i = 0u; i < n; i++) {
            let y = 1.0 - (2.0 * f32(i) + 1.0) / f32(n);
            let turn = 2.0 * PI * fract(f32(i) * 0.61803399);
            let l = vec3(sqrt(1.0 - y * y) * cos(turn), y, sqrt(1.0 - y * y) * sin(turn));
            let facing = dot(a[1].xyz, l);
            let n_v = max(dot(a[1].xyz, a[3].xyz), 1e-3);
            let body = leaf_body(leaf_diffuse(a[0].rgb), max(facing, 0.0), max(-facing, 0.0), dot(a[2].xyz, l), 0.3, n_v);
            out += vec4(body + leaf_gloss(a[1].xyz, facing, l, a[3].xyz), 0.0);
        }
        out *= 4.0 * PI / f32(n);";
    let light = light();
    let got = run(&frame(0.0, &Wind::calm(), &light), &light, "", body, &inputs);
    for (i, out) in inputs.iter().zip(got) {
        let out = out.truncate();
        assert!(out.max_element() <= 1.0, "{} seen at {}: {out}", i[0], i[3].y);
        // Straight on, white leaves send nearly everything on, and black ones their gloss alone.
        if i[3].y == 1.0 {
            let want = if i[0].x > 0.0 { 0.88..1.0 } else { 0.0..0.1 };
            assert!(want.contains(&out.x), "{}: {out}", i[0]);
        }
    }
}

#[test]
fn ambient_light_is_that_of_the_harmonics_on_both_sides() {
    let mut rng = Rng::new(2);
    let light = light();
    let inputs: Vec<[Vec4; 4]> = (0..256).map(|_| [unit_vector(&mut rng).extend(0.0); 4]).collect();
    let frame = frame(0.0, &Wind::calm(), &light);
    for (side, body) in [
        (1.0, "out = vec4(ambient_two_sided(a[0].xyz).front, 0.0);"),
        (-1.0, "out = vec4(ambient_two_sided(a[0].xyz).back, 0.0);"),
    ] {
        for (i, out) in inputs.iter().zip(run(&frame, &light, "", body, &inputs)) {
            let want = light.ambient.irradiance(i[0].truncate() * side);
            assert!((out.truncate() - want).length() < 1e-4, "{}: {out} for {want}", i[0]);
        }
    }
}

#[test]
fn the_sky_is_that_of_the_table() {
    let mut rng = Rng::new(3);
    let sky = Sky::default();
    let light = light();
    let table = Atmosphere { turbidity: sky.turbidity }.sky(sky.sun_elevation);
    let sun = sky.sun_direction();
    let heading = Vec2::new(sun.x, sun.z).normalize_or(Vec2::Y);
    let inputs: Vec<[Vec4; 4]> = (0..512).map(|_| [unit_vector(&mut rng).extend(0.0); 4]).collect();
    let frame = frame(0.0, &Wind::calm(), &light);
    let body = "out = vec4(sky_radiance(a[0].xyz), 0.0);";
    for (i, out) in inputs.iter().zip(run(&frame, &light, "", body, &inputs)) {
        let want = table.towards(i[0].truncate(), heading);
        // Half floats, and eighths of a texel's 256th.
        let off = (out.truncate() - want).abs().max_element();
        assert!(off < 0.02 * want.max_element() + 1e-3, "{}: {out} for {want}", i[0]);
    }
}

#[test]
fn trees_sway_as_on_the_cpu() {
    let mut rng = Rng::new(4);
    let light = light();
    let wind = Wind::new(5.0, 0.8, 0.8, 3);
    for time in [0.0, 12.34, 3000.5, -7.25, 864_000.3] {
        let inputs: Vec<[Vec4; 4]> = (0..512)
            .map(|_| {
                let rest = Vec3::new(
                    rng.range(-90.0, 90.0),
                    rng.range(-2.0, 20.0),
                    rng.range(-90.0, 90.0),
                );
                [rest.extend(rng.range(-3.0, 3.0)); 4]
            })
            .collect();
        let body = "out = vec4(sway(a[0].xyz, a[0].w), 0.0);";
        for (i, out) in
            inputs.iter().zip(run(&frame(time, &wind, &light), &light, "", body, &inputs))
        {
            let want = sway::offset(&wind, i[0].truncate(), i[0].w, time);
            // The shader's sine is good to a thousandth; the whole motion is some decimetres.
            assert!(
                (out.truncate() - want).length() < 3e-3,
                "{} at {time}: {out} for {want}",
                i[0]
            );
        }
    }
}

#[test]
fn leaves_flutter_as_on_the_cpu() {
    let mut rng = Rng::new(5);
    let light = light();
    let wind = Wind::new(6.0, 0.8, 0.8, 3);
    for time in [0.0, 41.7, 2999.5, 864_000.3] {
        let inputs: Vec<[Vec4; 4]> = (0..256)
            .map(|_| [(unit_vector(&mut rng) * rng.range(0.0, 60.0)).extend(rng.unit()); 4])
            .collect();
        let frame = frame(time, &wind, &light);
        let got = run(&frame, &light, "", "out = flutter(a[0].xyz, 1.0);", &inputs);
        let half = run(&frame, &light, "", "out = flutter(a[0].xyz, 0.5);", &inputs);
        let none = run(&frame, &light, "", "out = flutter(a[0].xyz, 0.0);", &inputs);
        let mut most = 0.0f32;
        for (i, ((out, half), none)) in inputs.iter().zip(got.iter().zip(half).zip(none)) {
            let want = sway::flutter(&wind, i[0].truncate(), time);
            let [out, half] = [*out, half].map(|q| Quat::from_vec4(q).normalize());
            let off = out.angle_between(want);
            assert!(off < 3e-3, "{} at {time}: {off} rad", i[0]);
            let [whole, part] = [out, half].map(|q| q.angle_between(Quat::IDENTITY));
            assert!(part < 0.52 * whole + 2e-3, "{part} of {whole}");
            assert!(none.truncate().length() < 1e-6);
            most = most.max(whole);
        }
        assert!((0.1..1.0).contains(&most), "{most}");
    }
}

/// Branches of a tree, and trees, differ in season by a few hundredths of the autumn; in the mean by none.
#[test]
fn branches_have_their_time_as_on_the_cpu() {
    let mut rng = Rng::new(6);
    let light = light();
    let inputs: Vec<[Vec4; 4]> = (0..2048)
        .map(|_| [(unit_vector(&mut rng) * rng.unit()).extend(rng.below(1000) as f32); 4])
        .collect();
    let body = "let seed = u32(a[0].w);
        out.x = ripeness(0.07, a[0].y) + branch_ripeness(seed, a[0].xyz);";
    let got = run(&frame(0.0, &Wind::calm(), &light), &light, "", body, &inputs);
    let mut sum = 0.0;
    for (i, out) in inputs.iter().zip(&got) {
        let want = ripeness(0.07, i[0].w as u32, i[0].truncate());
        assert!((out.x - want).abs() < 1e-3, "{}: {} for {want}", i[0], out.x);
        sum += want - 0.07 - 0.12 * i[0].y;
    }
    assert!((sum / got.len() as f32).abs() < 0.01, "{sum}");
    let spread = got.iter().map(|o| (o.x - 0.07).abs()).fold(0.0, f32::max);
    assert!((0.1..0.3).contains(&spread), "{spread}");
}

/// Phase and brightness of leaves, as leaves in the air have them and those on their twigs.
#[test]
fn leaves_have_their_season_as_on_the_cpu() {
    let mut rng = Rng::new(7);
    let light = light();
    let spread = 0.4;
    let inputs: Vec<[Vec4; 4]> = (0..2048)
        .map(|_| {
            let rank = Vec4::splat(rng.below(20_000) as f32);
            let center = (unit_vector(&mut rng) * rng.unit()).extend(rng.below(1000) as f32);
            [center, rank, rank, rank]
        })
        .collect();
    let body = "let seed = u32(a[0].w);
        let ripe = 0.07 + branch_ripeness(seed, a[0].xyz);
        let hangs = leaf_season(seed, ripe, u32(a[1].x), a[0].y, 0.4);
        let falls = season_of(hash(seed, u32(a[1].x)), ripeness(ripe, a[0].y), 0.4);
        out = vec4(hangs.phase, hangs.brightness, falls.phase, falls.brightness);";
    let frame = frame(0.0, &Wind::calm(), &light);
    let got = run(&frame, &light, "", body, &inputs);
    let palette = Palette { stops: vec![Vec3::ONE], spread };
    let foliage = Foliage { palette: Some(palette), ..Foliage::default() };
    for (i, out) in inputs.iter().zip(&got) {
        let leaf = Leaf {
            center: i[0].truncate(),
            orientation: Quat::IDENTITY,
            scale: 1.0,
            shape: 0,
            material: 0,
            bent_normal: Vec3::Y,
            ambient: 1.0,
            shed_rank: i[1].x as u32,
        };
        let instance = Instance {
            model: 0,
            position: Vec3::ZERO,
            yaw: 0.0,
            scale: 1.0,
            season_offset: 0.07,
            seed: i[0].w as u32,
        };
        let want = foliage.season_of(&leaf, &instance, frame.season, Vec3::ONE);
        for (phase, brightness) in [(out.x, out.y), (out.z, out.w)] {
            assert!((phase - want.phase).abs() < 1e-3, "{phase} for {want:?}");
            assert!((brightness - want.brightness).abs() < 1e-5, "{brightness} for {want:?}");
        }
    }
}

/// Dim light passes the curve as it is; above 0.62 it is drawn together. Peak 1 by hand: d = 0.38, new peak
/// 1 - 0.38² / (1 + 0.38 - 0.62) = 0.81, and of grey nothing else changes. Of pure red g = 1 - 1 / (0.06 · 0.19 + 1)
/// = 0.01127 goes to white: green and blue are 0.81 g = 0.00913.
#[test]
fn the_curve_is_khronos_neutral_without_its_toe() {
    let light = light();
    let grey = |v: f32| [Vec4::new(v, v, v, 0.0); 4];
    let mut inputs = vec![grey(0.3), grey(0.62), grey(1.0), [Vec4::X; 4]];
    inputs.extend((0..200).map(|i| grey(i as f32 * 0.1)));
    let source = include_str!("../tone_map.wgsl");
    let frame = frame(0.0, &Wind::calm(), &light);
    let got = run(&frame, &light, source, "out = vec4(neutral(a[0].rgb), 0.0);", &inputs);
    let near = |got: Vec4, want: Vec3| {
        assert!((got.truncate() - want).abs().max_element() < 1e-4, "{got} for {want}");
    };
    near(got[0], Vec3::splat(0.3));
    near(got[1], Vec3::splat(0.62));
    near(got[2], Vec3::splat(0.81));
    near(got[3], Vec3::new(0.81, 0.00913, 0.00913));
    assert!(got[4..].windows(2).all(|w| w[0].x < w[1].x && w[1].x < 1.0), "it rises below 1");
}

#[test]
fn branches_widen_as_on_the_cpu() {
    let mut rng = Rng::new(12);
    let branches: Vec<(Branch, f32)> = (0..1000)
        .map(|_| {
            let radius = 0.3 * rng.unit() * rng.unit();
            let branch = Branch { radius, vanishes: radius / rng.range(0.01, 1.0) };
            (branch, branch.vanishes * rng.range(0.0, 1.5))
        })
        .chain([(Branch { radius: 0.5, vanishes: f32::MAX }, 7.0)])
        .collect();
    let inputs: Vec<[Vec4; 4]> = branches
        .iter()
        .map(|(b, error)| [Vec4::new(b.radius, b.vanishes, *error, 0.0); 4])
        .collect();
    let light = light();
    let body = "out.x = widening(a[0].xy, a[0].z);";
    let outputs = run(&frame(0.0, &Wind::calm(), &light), &light, "", body, &inputs);
    for ((branch, error), out) in branches.iter().zip(outputs) {
        let expected = branch.widening(*error);
        assert!((out.x - expected).abs() < 1e-5, "{branch:?} {error}: {} for {expected}", out.x);
    }
}

#[test]
fn ambient_light_falls_off_in_the_crown_as_on_the_cpu() {
    let mut rng = Rng::new(13);
    let shading = Shading { ambient: Vec3::new(0.3, 0.35, 0.2), ..Shading::default() };
    let places: Vec<Vec3> = (0..500)
        .map(|_| Vec3::new(rng.range(-2.0, 2.0), rng.range(-2.0, 2.0), rng.range(-2.0, 2.0)))
        .collect();
    let inputs: Vec<[Vec4; 4]> = places
        .iter()
        .map(|p| [shading.ambient.extend(0.0), p.extend(0.0), Vec4::ZERO, Vec4::ZERO])
        .collect();
    let light = light();
    let body = "out.x = ambient_at(a[0].xyz, a[1].xyz);";
    let outputs = run(&frame(0.0, &Wind::calm(), &light), &light, "", body, &inputs);
    for (place, out) in places.iter().zip(outputs) {
        let expected = shading.ambient_at(*place);
        assert!((out.x - expected).abs() < 1e-5, "{place}: {} for {expected}", out.x);
    }
    assert!(places.iter().any(|p| shading.ambient_at(*p) == 1.0), "some are at the bound");
}

#[test]
fn what_is_chosen_is_the_share_in_the_mean() {
    let shares = [0.0f32, 0.03, 0.3, 0.5, 0.72, 0.97, 1.0];
    let chances = 1000;
    let inputs: Vec<[Vec4; 4]> = shares
        .iter()
        .flat_map(|&share| (0..chances).map(move |i| (share, (i as f32 + 0.5) / chances as f32)))
        .map(|(share, chance)| [Vec4::new(share, chance, 0.0, 0.0); 4])
        .collect();
    let light = light();
    let body = "out.x = chosen(a[0].x, a[0].y);";
    let outputs = run(&frame(0.0, &Wind::calm(), &light), &light, "", body, &inputs);
    for (share, of_share) in shares.iter().zip(outputs.chunks(chances)) {
        let mean = of_share.iter().map(|out| out.x).sum::<f32>() / chances as f32;
        assert!((mean - share).abs() < 2e-4, "{share}: {mean}");
        let whole = of_share.iter().filter(|out| out.x == 0.0 || out.x == 1.0).count();
        assert!(whole >= 7 * chances / 8, "{share}: {whole}");
    }
}

/// The grey of a card is what it was, a stop more is 1.2 stops more, and red to green to blue is as in
/// the scene.
#[test]
fn a_picture_has_the_contrast_of_the_system_gamma_and_the_hues_of_the_scene() {
    let light = light();
    let grey = Vec4::new(0.18, 0.18, 0.18, 0.0);
    let red = Vec4::new(0.5, 0.1, 0.02, 0.0);
    let inputs = [grey, grey * 2.0, red, red * 2.0, Vec4::ZERO].map(|v| [v; 4]);
    let source = include_str!("../tone_map.wgsl");
    let frame = frame(0.0, &Wind::calm(), &light);
    let got = run(&frame, &light, source, "out = vec4(system(a[0].rgb), 0.0);", &inputs);
    let gain = 2.0f32.powf(1.2);
    assert!(got[0].abs_diff_eq(grey, 1e-4), "{}", got[0]);
    for [once, stop] in [[got[0], got[1]], [got[2], got[3]]] {
        assert!(stop.abs_diff_eq(once * gain, 1e-3), "{once} {stop}");
    }
    assert!((got[2] / got[2].x).abs_diff_eq(red / red.x, 1e-3), "{}", got[2]);
    assert_eq!(got[4], Vec4::ZERO);
}
