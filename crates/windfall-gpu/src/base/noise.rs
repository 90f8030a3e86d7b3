//! Noise in a texture, so that a pixel looks up what it would else add up.

use std::sync::atomic::{AtomicBool, Ordering};
use windfall_core::rng::{hash, unit};

/// Texels along a side.
pub const SIDE: usize = 1024;
/// Cells of the lattice of the lowest frequency along a side.
pub const CELLS: usize = 64;
/// Frequencies of fractal noise, each twice the one before and half as strong.
const OCTAVES: usize = 4;

/// A square that repeats in all directions. Red: fractal noise about 0.5; green: noise of one frequency, 0 to 1. Its
/// smaller levels are what a wide pixel has of it.
pub struct Noise {
    texture: wgpu::Texture,
    pub view: wgpu::TextureView,
    pub sampler: wgpu::Sampler,
    uploaded: AtomicBool,
}

impl Noise {
    /// The texture, empty.
    pub fn new(device: &wgpu::Device) -> Self {
        let side = SIDE as u32;
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("noise"),
            size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
            mip_level_count: side.ilog2() + 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rg8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("noise"),
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Nearest,
            ..Default::default()
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Self { texture, view, sampler, uploaded: AtomicBool::new(false) }
    }

    /// Fills it, once.
    pub fn upload(&self, queue: &wgpu::Queue) {
        if self.uploaded.swap(true, Ordering::Relaxed) {
            return;
        }
        let mut texels = texels();
        for level in 0..self.texture.mip_level_count() {
            let side = SIDE as u32 >> level;
            let bytes: Vec<u8> =
                texels.iter().flatten().map(|v| (v * 255.0).round() as u8).collect();
            queue.write_texture(
                wgpu::TexelCopyTextureInfo { mip_level: level, ..self.texture.as_image_copy() },
                &bytes,
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(2 * side),
                    rows_per_image: None,
                },
                wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
            );
            texels = halved(&texels, side as usize);
        }
    }
}

/// Adds noise on a lattice of so many cells a side to a channel, smooth between.
fn add(texels: &mut [[f32; 2]], channel: usize, cells: usize, amplitude: f32, seed: u32) {
    let values: Vec<f32> = (0..(cells * cells) as u32).map(|i| unit(hash(seed, i)) - 0.5).collect();
    let across = SIDE / cells;
    // The middles of texels, as shares of a cell.
    let weights: Vec<f32> = (0..across)
        .map(|i| (i as f32 + 0.5) / across as f32)
        .map(|f| f * f * (3.0 - 2.0 * f))
        .collect();
    for (y, row) in texels.chunks_exact_mut(SIDE).enumerate() {
        let (cell, s) = (y / across, weights[y % across]);
        let [above, below] =
            [cell, (cell + 1) % cells].map(|cell| &values[cell * cells..][..cells]);
        let at = |x: usize| above[x] + (below[x] - above[x]) * s;
        for (x, cell) in row.chunks_exact_mut(across).enumerate() {
            let (left, right) = (at(x), at((x + 1) % cells));
            for (texel, s) in cell.iter_mut().zip(&weights) {
                texel[channel] += amplitude * (left + (right - left) * s);
            }
        }
    }
}

fn texels() -> Vec<[f32; 2]> {
    let mut texels = vec![[0.5; 2]; SIDE * SIDE];
    for octave in 0..OCTAVES {
        add(&mut texels, 0, CELLS << octave, 0.5_f32.powi(octave as i32 + 1), octave as u32);
    }
    add(&mut texels, 1, CELLS, 1.0, OCTAVES as u32);
    texels
}

/// The means of four texels each.
fn halved(texels: &[[f32; 2]], side: usize) -> Vec<[f32; 2]> {
    let half = side / 2;
    let mean = |i: usize| {
        let first = 2 * (i / half * side + i % half);
        [0, 1].map(|c| {
            [0, 1, side, side + 1].iter().map(|next| texels[first + next][c]).sum::<f32>() / 4.0
        })
    };
    (0..half * half).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_about_a_half_repeats_and_fades() {
        let texels = texels();
        let of = |channel: usize| texels.iter().map(move |texel| texel[channel]);
        for channel in 0..2 {
            let mean = of(channel).sum::<f32>() / texels.len() as f32;
            assert!((mean - 0.5).abs() < 0.01, "{channel}: {mean}");
            assert!(of(channel).all(|v| (0.0..=1.0).contains(&v)));
        }
        // Over the edge it goes on: no larger step there than anywhere.
        let step = |a: usize, b: usize| (texels[a][0] - texels[b][0]).abs();
        let steps = |x: usize, next: usize| {
            (0..SIDE).map(|y| step(y * SIDE + x, y * SIDE + next)).fold(0.0, f32::max)
        };
        let inside = (0..SIDE - 1).map(|x| steps(x, x + 1)).fold(0.0, f32::max);
        assert!(steps(SIDE - 1, 0) <= inside, "{} {inside}", steps(SIDE - 1, 0));
        // Wide pixels see less and less of it.
        let spread = |texels: &[[f32; 2]]| {
            (texels.iter().map(|t| (t[0] - 0.5).powi(2)).sum::<f32>() / texels.len() as f32).sqrt()
        };
        let (mut level, mut side, mut before) = (texels.clone(), SIDE, spread(&texels));
        while side > 16 {
            level = halved(&level, side);
            side /= 2;
            let now = spread(&level);
            assert!(now < before, "{side}: {now} {before}");
            before = now;
        }
        assert!(before < 0.4 * spread(&texels), "{before}");
    }
}
