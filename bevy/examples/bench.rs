//! What a forest costs in Bevy: beside the same frame drawn by Windfall alone, and beside particles of `bevy_hanabi`, as many as
//! there are leaves off their twigs. Medians of whole frames, each waited for.
//!
//!     cargo run --release --example bench

mod common;
mod headless;

use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::renderer::RenderDevice;
use bevy_hanabi::prelude::*;
use bevy_windfall::windfall::forest::{Placement, Terrain};
use bevy_windfall::windfall::glam::{DVec3, Mat4};
use bevy_windfall::windfall::shed::Shedding;
use bevy_windfall::windfall::tree::Species;
use bevy_windfall::windfall::{
    self, Camera as Eye, Culling, Falls, Forest, HostLight, Light, Moment, Options, Projection,
    Recording, Renderer, View, wgpu,
};
use bevy_windfall::{
    LeafDetail, PlantedTrees, TreeModel, Trees, WindfallForest, WindfallTime, WindfallWind,
};
use headless::Headless;
use std::time::Instant;

const SIZE: UVec2 = UVec2::new(640, 360);
const TIME: f64 = 60.0;
const FRAMES: (u32, u32) = (4, 15);

fn placement() -> Placement {
    Placement { trees: 40, spacing: 6.0, seed: 3, ..default() }
}

fn shedding(moving: bool) -> Shedding {
    if moving { Shedding { start: 0.0, duration: 120.0, ..default() } } else { Shedding::never() }
}

fn eye() -> Transform {
    Transform::from_xyz(0.0, 2.2, 34.0).looking_at(Vec3::new(0.0, 6.0, 0.0), Vec3::Y)
}

/// Median of the frames' times, milliseconds.
fn median(mut frame: impl FnMut(f64)) -> f64 {
    let mut times = Vec::new();
    for i in 0..FRAMES.0 + FRAMES.1 {
        let begin = Instant::now();
        frame(TIME + f64::from(i) / 60.0);
        if i >= FRAMES.0 {
            times.push(begin.elapsed().as_secs_f64() * 1e3);
        }
    }
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn in_bevy(build: impl FnOnce(&mut App)) -> (f64, Headless) {
    let mut headless = Headless::new(SIZE, |app| {
        app.add_plugins(HanabiPlugin);
        let world = app.world_mut();
        let detail = LeafDetail { culling: Culling::Sphere, ..default() };
        world.spawn((common::eyes(), eye(), detail));
        world.spawn((
            DirectionalLight { illuminance: 9_000.0, ..default() },
            Transform::from_xyz(5.0, 6.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
        ));
        build(app);
    });
    headless.settle(TIME);
    let time = median(|time| {
        headless.app.world_mut().resource_mut::<WindfallTime>().seconds = time;
        headless.app.update();
        let device = headless.app.sub_app(RenderApp).world().resource::<RenderDevice>();
        let _ = device.wgpu_device().poll(wgpu::PollType::wait_indefinitely());
    });
    (time, headless)
}

fn plant(app: &mut App, model: &TreeModel, moving: bool) {
    let world = app.world_mut();
    let model = world.resource_mut::<Assets<TreeModel>>().add(model.clone());
    world.spawn(WindfallForest {
        models: vec![model],
        trees: Trees::Placed(placement()),
        shedding: shedding(moving),
        ..default()
    });
}

/// The same forest in a target of the same kind, by the library alone.
fn alone(model: &TreeModel) -> f64 {
    let (device, queue) = windfall_testing::device();
    let format = wgpu::TextureFormat::Rgba16Float;
    let depth_format = wgpu::TextureFormat::Depth32Float;
    let options = Options { samples: 4, ..Options::foliage(format, depth_format) };
    let renderer = Renderer::new(&device, &options).expect("a renderer");
    let model = windfall::TreeModel::new(&device, &queue, &model.tree).expect("a model");
    let placed = placement().place(Terrain::flat(), &[1.0]);
    let falls = Falls { shedding: shedding(true), ..default() };
    let mut forest = Forest::new(&device, DVec3::ZERO, placed.terrain, falls).expect("a forest");
    forest.plant(&[model], &placed.instances).expect("trees");
    let mut state = renderer.view(&forest);
    let texture = |format, samples| {
        let size = wgpu::Extent3d { width: SIZE.x, height: SIZE.y, depth_or_array_layers: 1 };
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size,
            mip_level_count: 1,
            sample_count: samples,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        texture.create_view(&default())
    };
    let (color, resolved, depth) =
        (texture(format, 4), texture(format, 1), texture(depth_format, 4));
    let aspect = SIZE.x as f32 / SIZE.y as f32;
    // Bevy's default camera.
    let projection =
        Mat4::perspective_infinite_reverse_rh(std::f32::consts::FRAC_PI_4, aspect, 0.1);
    let camera = Eye {
        eye: eye().translation.as_dvec3(),
        rotation: eye().rotation,
        projection: Projection::Matrix(projection),
    };
    let detail = LeafDetail::default();
    let sun = Vec3::new(5.0, 6.0, 4.0).normalize_or(Vec3::Y);
    let view = View {
        light: Light::Host(HostLight::new(sun, Vec3::splat(9.0), Vec3::splat(0.5))),
        detail: detail.detail,
        quality: detail.quality,
        culling: detail.culling,
        ..View::new(camera)
    };
    median(|time| {
        let mut encoder = device.create_command_encoder(&default());
        let mut recording = Recording::new(&queue, &mut encoder);
        renderer.advance(&mut recording, &mut forest, Moment::at(time)).expect("a moment");
        let size = (SIZE.x, SIZE.y);
        renderer.prepare(&mut recording, &forest, &mut state, &view, size).expect("a view");
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &color,
                    depth_slice: None,
                    resolve_target: Some(&resolved),
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &depth,
                    depth_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(0.0),
                        store: wgpu::StoreOp::Store,
                    }),
                    stencil_ops: None,
                }),
                ..default()
            });
            renderer.draw(&mut pass, &forest, &state).expect("a picture");
        }
        queue.submit([encoder.finish()]);
        let _ = device.poll(wgpu::PollType::wait_indefinitely());
    })
}

/// As many quads of a leaf's size, where the forest stands, that sink and tumble for ever.
fn particles(app: &mut App, count: u32) {
    let writer = ExprWriter::new();
    let place = SetPositionSphereModifier {
        center: writer.lit(Vec3::new(0.0, 5.0, 0.0)).expr(),
        radius: writer.lit(24.0).expr(),
        dimension: ShapeDimension::Volume,
    };
    let sink = SetAttributeModifier::new(
        Attribute::VELOCITY,
        writer.lit(Vec3::new(0.3, -0.8, 0.1)).expr(),
    );
    let lifetime = SetAttributeModifier::new(Attribute::LIFETIME, writer.lit(1e6).expr());
    let effect =
        EffectAsset::new(count, SpawnerSettings::once((count as f32).into()), writer.finish())
            .with_alpha_mode(bevy_hanabi::AlphaMode::Opaque)
            .init(place)
            .init(sink)
            .init(lifetime)
            .render(OrientModifier::new(OrientMode::AlongVelocity))
            .render(SetSizeModifier { size: Vec3::splat(0.1).into() })
            .render(SetColorModifier::new(Vec4::new(0.8, 0.4, 0.1, 1.0)));
    let world = app.world_mut();
    let effect = world.resource_mut::<Assets<EffectAsset>>().add(effect);
    world.spawn(ParticleEffect::new(effect));
}

fn main() {
    let model = TreeModel::grow(Species::Maple, 3, 3000);
    println!("{} x {} pixels, 4 samples, 40 trees of 3000 leaves", SIZE.x, SIZE.y);
    let alone = alone(&model);
    println!("Windfall alone                        {alone:7.1} ms");
    let (empty, _) = in_bevy(|_| {});
    println!("Bevy without a forest                 {empty:7.1} ms");
    let (moving, mut headless) = in_bevy(|app| plant(app, &model, true));
    println!("Bevy with the forest                  {moving:7.1} ms");
    println!("  the forest in Bevy over Windfall    {:7.2}", (moving - empty) / alone);
    let loose = loose(headless.app.world_mut());
    drop(headless);
    let (still, _) = in_bevy(|app| plant(app, &model, false));
    println!("Bevy, no leaf moves                   {still:7.1} ms");
    let (hanabi, _) = in_bevy(|app| {
        plant(app, &model, false);
        particles(app, loose);
    });
    println!("Bevy, no leaf moves, {loose:6} particles {hanabi:7.1} ms");
    println!("  {loose} leaves of Windfall          {:7.1} ms", moving - still);
    println!("  {loose} particles of bevy_hanabi    {:7.1} ms", hanabi - still);
}

/// Leaves off their twigs in the middle of what is measured.
fn loose(world: &mut World) -> u32 {
    let mut count = 0;
    let mut forests = world.query::<(&WindfallForest, &PlantedTrees, &WindfallWind)>();
    for (forest, planted, WindfallWind(wind)) in forests.iter(world) {
        for instance in planted.instances() {
            let shed = forest.shedding.tree(instance, 3000, wind);
            count += forest.shedding.detached(&shed, Shedding::gust_rate(wind), TIME + 0.2);
        }
    }
    count
}
