//! Two cameras and two forests in one submission, from one tree model that was uploaded once: a maple wood in its
//! autumn on the left, the same trees in late summer 100 km away on the right.
//!
//!     cargo run --release --example split_screen -- split_screen.png

mod headless;

use headless::{device, save, texture, tone_mapped};
use std::path::Path;
use windfall::forest::{KeepOut, Placement, Terrain};
use windfall::glam::{DVec3, Vec2};
use windfall::shed::Shedding;
use windfall::tree::Species;
use windfall::{
    Camera, Capture, Falls, Forest, Layers, Moment, Options, Recording, Renderer, TreeModel, View,
    wgpu,
};

const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
const HDR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// Renders both halves; `size` in pixels.
pub(crate) fn render(size: (u32, u32)) -> anyhow::Result<Vec<u8>> {
    let (device, queue) = device()?;
    let (width, height) = size;
    let multisampled = texture(&device, HDR, size, 4).create_view(&Default::default());
    let depth = texture(&device, DEPTH, size, 4).create_view(&Default::default());
    let color = texture(&device, HDR, size, 1);

    // Foliage with its own shadows, ground and sky, but into the host's pass and without a tone curve.
    let layers = Layers { shadows: true, ground: true, sky: true, ..Layers::FOLIAGE };
    let options = Options { samples: 4, layers, ..Options::foliage(HDR, DEPTH) };
    let renderer = Renderer::new(&device, &options)?;
    let maple = TreeModel::new(&device, &queue, &Species::Maple.grow_with(2, 3000))?;
    let far = DVec3::new(100_000.0, 0.0, -100_000.0);
    let glade = KeepOut { from: Vec2::ZERO, to: Vec2::new(0.0, 22.0), radius: 4.0 };
    // Ten days after the world began, leaves have been falling for four minutes.
    let now = 864_000.0;
    let shedding = Shedding { start: now - 240.0, ..Shedding::default() };
    let falls = Falls { shedding, ..Falls::default() };
    let mut halves = Vec::new();
    for (origin, season, seed) in [(DVec3::ZERO, 0.75, 1), (far, 0.05, 2)] {
        let placement = Placement { trees: 24, keep_out: vec![glade], seed, ..Default::default() };
        let placed = placement.place(Terrain::rolling(200.0, 2.0, seed), &[1.0]);
        let mut forest = Forest::new(&device, origin, placed.terrain, falls.clone())?;
        forest.plant(std::slice::from_ref(&maple), &placed.instances)?;
        forest.set_season(season)?;
        let eye = origin + DVec3::new(0.0, 2.2, 22.0);
        let camera = Camera::look_at(eye, origin + DVec3::new(0.0, 4.0, 0.0), 0.9, 0.1);
        halves.push((renderer.view(&forest), View::new(camera), forest));
    }

    // One encoder and one pass for all.
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut recording = Recording::new(&queue, &mut encoder);
    for (state, view, forest) in &mut halves {
        renderer.advance(&mut recording, forest, Moment::of(now, view))?;
        renderer.prepare(&mut recording, forest, state, view, (width / 2, height))?;
    }
    {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &multisampled,
                depth_slice: None,
                resolve_target: Some(&color.create_view(&Default::default())),
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Discard,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        for (i, (state, _, forest)) in halves.iter().enumerate() {
            let half = width as f32 * 0.5;
            pass.set_viewport(i as f32 * half, 0.0, half, height as f32, 0.0, 1.0);
            renderer.draw(&mut pass, forest, state)?;
        }
    }
    let capture = Capture::encode(&device, &mut encoder, &color);
    queue.submit([encoder.finish()]);
    tone_mapped(&device, &capture)
}

fn main() -> anyhow::Result<()> {
    let path = std::env::args_os().nth(1).unwrap_or("split_screen.png".into());
    let size = (960, 540);
    save(Path::new(&path), &render(size)?, size)
}
