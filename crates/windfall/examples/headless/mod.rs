//! What the examples of hosts share: a device, and a picture of what they drew.
#![allow(dead_code, reason = "not every example uses all of it")]

use anyhow::Context;
use half::f16;
use pollster::block_on;
use std::path::Path;
use windfall::{Capture, Requirements, wgpu};

/// The first adapter's device, and its queue.
pub fn device() -> anyhow::Result<(wgpu::Device, wgpu::Queue)> {
    let instance =
        wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter = block_on(instance.request_adapter(&Default::default()))?;
    let needs = Requirements::of(&adapter)?;
    Ok(block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: needs.features,
        required_limits: needs.limits,
        ..Default::default()
    }))?)
}

/// A texture of `format` to draw into, to sample from, and to copy from.
pub fn texture(
    device: &wgpu::Device,
    format: wgpu::TextureFormat,
    (width, height): (u32, u32),
    samples: u32,
) -> wgpu::Texture {
    let copied =
        if samples == 1 { wgpu::TextureUsages::COPY_SRC } else { wgpu::TextureUsages::empty() };
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("the host's"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | copied,
        view_formats: &[],
    })
}

/// Radiance that was drawn, as a picture: a plain curve, as every host has its own.
pub fn tone_mapped(device: &wgpu::Device, capture: &Capture) -> anyhow::Result<Vec<u8>> {
    capture.map();
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let bytes = capture.take().context("the picture did not arrive")??;
    let byte = |i: usize, half: &[u8]| {
        let radiance = f16::from_le_bytes([half[0], half[1]]).to_f32();
        let shown = (radiance / (1.0 + 0.6 * radiance)).clamp(0.0, 1.0).powf(1.0 / 2.2);
        if i % 4 == 3 { 255 } else { (255.0 * shown).round() as u8 }
    };
    Ok(bytes.chunks_exact(2).enumerate().map(|(i, half)| byte(i, half)).collect())
}

/// Writes a PNG.
pub fn save(path: &Path, rgba: &[u8], (width, height): (u32, u32)) -> anyhow::Result<()> {
    Ok(image::save_buffer(path, rgba, width, height, image::ColorType::Rgba8)?)
}
