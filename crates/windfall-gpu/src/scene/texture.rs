//! Texture arrays with mip maps that keep the coverage of alpha-masked leaves.

use windfall_core::tree::{Image, Material, Surface};

/// Alpha at which a texel of an uploaded texture becomes a hole, whatever the material's own.
const CUTOFF: f32 = 0.5;

/// Largest side of an uploaded texture; larger pictures are scaled down.
const LARGEST: u32 = 2048;

/// One level of a mip chain: linear colour, straight alpha.
#[derive(Clone)]
struct Level {
    width: usize,
    height: usize,
    texels: Vec<[f32; 4]>,
}

impl Level {
    fn from_image(image: &Image) -> Self {
        let texels = image
            .rgba
            .chunks_exact(4)
            .map(|p| [linear(p[0]), linear(p[1]), linear(p[2]), f32::from(p[3]) / 255.0])
            .collect();
        Self { width: image.width as usize, height: image.height as usize, texels }
    }

    /// Resamples with a box as wide as a target texel (or linearly, where it grows). Colour is
    /// weighted by alpha, so that what lies in the holes does not bleed into the leaf.
    fn resize(&self, width: usize, height: usize) -> Self {
        let mut texels = Vec::with_capacity(width * height);
        for y in 0..height {
            let rows = spans(y, height, self.height);
            for x in 0..width {
                let mut sum = [0.0; 4];
                let (mut plain, mut weight) = ([0.0; 3], 0.0);
                for &(j, wy) in &rows {
                    for &(i, wx) in &spans(x, width, self.width) {
                        let texel = self.texels[j * self.width + i];
                        let w = wx * wy;
                        for k in 0..3 {
                            sum[k] += texel[k] * texel[3] * w;
                            plain[k] += texel[k] * w;
                        }
                        sum[3] += texel[3] * w;
                        weight += w;
                    }
                }
                let alpha = sum[3];
                let color = |k: usize| {
                    if alpha > 1e-4 { sum[k] / alpha } else { plain[k] / weight }
                };
                texels.push([color(0), color(1), color(2), alpha / weight]);
            }
        }
        Self { width, height, texels }
    }

    /// Share of the picture that is drawn once alpha is multiplied by `scale`, in pixels as large as `pixel`
    /// texels and pieces as large as `piece` of the picture: as `mask_share` in `leaves.wgsl` finds it, alpha
    /// interpolated between texels. Averaged over `steps` by `steps` points between each four texels.
    fn coverage(&self, scale: f32, pixel: f32, piece: f32, steps: usize) -> f32 {
        let least = (0.5 * pixel / (self.width.max(self.height) as f32 * piece)).clamp(1e-3, 1.0);
        let alpha = |x: usize, y: usize| (self.texels[y * self.width + x][3] * scale).min(1.0);
        let points = || (0..steps).map(|i| (i as f32 + 0.5) / steps as f32);
        let mut drawn = 0.0f64;
        for y in 0..self.height {
            let below = (y + 1).min(self.height - 1);
            let mut row = 0.0;
            for x in 0..self.width {
                let right = (x + 1).min(self.width - 1);
                let [a, b, c, d] =
                    [(x, y), (right, y), (x, below), (right, below)].map(|(x, y)| alpha(x, y));
                let share = |alpha: f32, width: f32| {
                    ((alpha - CUTOFF) / width.max(least) + 0.5).clamp(0.0, 1.0)
                };
                if a == b && a == c && a == d {
                    row += share(a, 0.0) * (steps * steps) as f32;
                    continue;
                }
                for v in points() {
                    let (left, slope) = (a + (c - a) * v, b - a + (a - b - c + d) * v);
                    for u in points() {
                        let width = pixel * (slope.abs() + (c - a + (a - b - c + d) * u).abs());
                        row += share(left + slope * u, width);
                    }
                }
            }
            drawn += f64::from(row);
        }
        (drawn / (self.texels.len() * steps * steps) as f64) as f32
    }

    /// Scales alpha so that as much is drawn of the level, in pixels of its texels' size, as `coverage` says
    /// (Castaño 2010, "Computing alpha mipmaps").
    fn keep_coverage(&mut self, coverage: f32, piece: f32) {
        let steps = if self.texels.len() > 256 * 256 { 1 } else { 4 };
        let (mut low, mut high) = (0.0, 8.0);
        for _ in 0..14 {
            let middle = 0.5 * (low + high);
            if self.coverage(middle, 1.0, piece, steps) < coverage {
                low = middle;
            } else {
                high = middle;
            }
        }
        self.scale_alpha(high);
    }

    fn scale_alpha(&mut self, factor: f32) {
        for texel in &mut self.texels {
            texel[3] = (texel[3] * factor).min(1.0);
        }
    }

    fn bytes(&self) -> Vec<u8> {
        self.texels
            .iter()
            .flat_map(|t| {
                let alpha = (t[3] * 255.0 + 0.5) as u8;
                [srgb(t[0]), srgb(t[1]), srgb(t[2]), alpha]
            })
            .collect()
    }
}

/// Source texels under target texel `i` of `to`, with weights that sum to 1.
fn spans(i: usize, to: usize, from: usize) -> Vec<(usize, f32)> {
    let ratio = from as f32 / to as f32;
    if ratio <= 1.0 {
        let at = ((i as f32 + 0.5) * ratio - 0.5).clamp(0.0, (from - 1) as f32);
        let low = at as usize;
        let f = at - low as f32;
        return vec![(low, 1.0 - f), ((low + 1).min(from - 1), f)];
    }
    let (start, end) = (i as f32 * ratio, (i + 1) as f32 * ratio);
    (start as usize..(end.ceil() as usize).min(from))
        .map(|j| (j, (end.min((j + 1) as f32) - start.max(j as f32)) / ratio))
        .collect()
}

fn linear(byte: u8) -> f32 {
    let c = f32::from(byte) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

fn srgb(linear: f32) -> u8 {
    let c = linear.clamp(0.0, 1.0);
    let encoded = if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0 + 0.5) as u8
}

/// The pictures of a list of materials as one texture array.
pub(crate) struct TextureArray {
    pub view: wgpu::TextureView,
    pub sampler: wgpu::Sampler,
    /// For each material its layer, or `None`.
    pub layers: Vec<Option<u32>>,
    /// Mean luminance of the drawn texels over all layers; 1 without textures.
    pub luminance: f32,
}

impl TextureArray {
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, materials: &[Material]) -> Self {
        let most = device.limits().max_texture_dimension_2d.min(LARGEST);
        let mut layers = Vec::new();
        let mut images: Vec<(&Image, &Material)> = Vec::new();
        let mut repeat = false;
        for material in materials {
            layers.push(match &material.surface {
                Surface::Texture(image, repeats) => {
                    repeat |= repeats;
                    images.push((image, material));
                    Some(images.len() as u32 - 1)
                }
                Surface::Plain | Surface::Bark(_) => None,
            });
        }
        let (width, height) = array_size(materials, most);
        let levels = width.max(height).ilog2() + 1;
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("tree textures"),
            size: wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: images.len().max(1) as u32,
            },
            mip_level_count: levels,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8UnormSrgb,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let (mut luminance, mut drawn) = (0.0, 0.0);
        for (layer, (image, material)) in images.iter().enumerate() {
            let mask = material.alpha_cutoff.map(|cutoff| (cutoff, smallest_piece(material)));
            let mips = mip_chain(image, width as usize, height as usize, levels, mask);
            for t in &mips[0].texels {
                luminance += (0.2126 * t[0] + 0.7152 * t[1] + 0.0722 * t[2]) * t[3];
                drawn += t[3];
            }
            for (mip, level) in mips.iter().enumerate() {
                let data = level.bytes();
                queue.write_texture(
                    wgpu::TexelCopyTextureInfo {
                        texture: &texture,
                        mip_level: mip as u32,
                        origin: wgpu::Origin3d { x: 0, y: 0, z: layer as u32 },
                        aspect: wgpu::TextureAspect::All,
                    },
                    &data,
                    wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(4 * level.width as u32),
                        rows_per_image: None,
                    },
                    wgpu::Extent3d {
                        width: level.width as u32,
                        height: level.height as u32,
                        depth_or_array_layers: 1,
                    },
                );
            }
        }
        let address =
            if repeat { wgpu::AddressMode::Repeat } else { wgpu::AddressMode::ClampToEdge };
        Self {
            view: texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                ..Default::default()
            }),
            sampler: device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("tree textures"),
                address_mode_u: address,
                address_mode_v: address,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                ..Default::default()
            }),
            layers,
            luminance: if drawn > 0.0 { luminance / drawn } else { 1.0 },
        }
    }
}

/// [`Holes::piece`] of a material's picture, at least what `Surface::piece` may be.
///
/// [`Holes::piece`]: windfall_core::foliage::Holes::piece
pub(crate) fn smallest_piece(material: &Material) -> f32 {
    material.holes().piece.max(1e-3)
}

/// Size of the array that holds the pictures of `materials`, no side above `most`.
fn array_size(materials: &[Material], most: u32) -> (u32, u32) {
    materials.iter().fold((1, 1), |(width, height), material| match &material.surface {
        Surface::Texture(image, _) => {
            (width.max(image.width.min(most)), height.max(image.height.min(most)))
        }
        Surface::Plain | Surface::Bark(_) => (width, height),
    })
}

/// Bytes of the texture array of `materials` with its mip maps.
pub(crate) fn array_bytes(materials: &[Material]) -> u64 {
    let pictures = materials.iter().filter(|m| matches!(m.surface, Surface::Texture(..))).count();
    let (width, height) = array_size(materials, LARGEST);
    let texels: u64 = (0..=width.max(height).ilog2())
        .map(|level| u64::from((width >> level).max(1)) * u64::from((height >> level).max(1)))
        .sum();
    texels * 4 * pictures.max(1) as u64
}

/// The whole mip chain of an image, first level at the given size.
///
/// With a mask, its cut-off and the size of its pieces, alpha is rescaled so that the cut-off becomes [`CUTOFF`],
/// and every level draws as much of the picture as the first does from nearby.
fn mip_chain(
    image: &Image,
    width: usize,
    height: usize,
    levels: u32,
    mask: Option<(f32, f32)>,
) -> Vec<Level> {
    let mut first = Level::from_image(image);
    if (first.width, first.height) != (width, height) {
        first = first.resize(width, height);
    }
    if let Some((cutoff, _)) = mask {
        first.scale_alpha(CUTOFF / cutoff.max(1e-3));
    }
    let mut chain = vec![first];
    for _ in 1..levels {
        let last = &chain[chain.len() - 1];
        chain.push(last.resize((last.width / 2).max(1), (last.height / 2).max(1)));
    }
    if let Some((_, piece)) = mask {
        let coverage = chain[0].coverage(1.0, 0.0, piece, 2);
        for level in &mut chain[1..] {
            level.keep_coverage(coverage, piece);
        }
    }
    chain
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Thin diagonal strokes: the shape that plain mip maps lose first.
    fn strokes(size: u32) -> Image {
        let rgba = (0..size * size)
            .flat_map(|i| {
                let (x, y) = (i % size, i / size);
                let alpha = if (x + y) % 8 < 2 { 255 } else { 0 };
                [40, 200, 30, alpha]
            })
            .collect();
        Image { width: size, height: size, rgba }
    }

    #[test]
    fn every_level_keeps_the_coverage_of_the_first() {
        // As large as the strokes are, and as if they were one piece, which pixels only cut.
        for (piece, levels) in [(2.0 / 64.0, 7), (1.0, 3)] {
            let chain = mip_chain(&strokes(64), 64, 64, 7, Some((0.5, piece)));
            let wanted = chain[0].coverage(1.0, 0.0, piece, 8);
            // Two texels of eight, less what interpolation rounds off.
            assert!((0.22..0.26).contains(&wanted), "{wanted}");
            for level in &chain[1..levels] {
                let got = level.coverage(1.0, 1.0, piece, 8);
                assert!((got / wanted - 1.0).abs() < 0.02, "{piece}, {}: {got}", level.width);
            }
        }
        // Without the correction strokes that are cut are gone at once.
        let plain = mip_chain(&strokes(64), 64, 64, 7, None);
        assert!(plain[3].coverage(1.0, 1.0, 1.0, 8) < 0.01);
    }

    #[test]
    fn coverage_is_what_the_shader_draws() {
        let level = |alpha: [f32; 4]| Level {
            width: 4,
            height: 1,
            texels: alpha.map(|a| [0.0, 0.0, 0.0, a]).to_vec(),
        };
        // Alpha falls from 1 to 0 over the pixel between two texels.
        let steep = level([1.0, 1.0, 0.0, 0.0]);
        assert!((steep.coverage(1.0, 1.0, 1.0, 64) - 1.5 / 4.0).abs() < 1e-3);
        // Half as steep, from nearby: it ends where alpha is a half.
        let slanting = level([1.0, 0.5, 0.0, 0.0]);
        assert!((slanting.coverage(1.0, 1e-3, 1.0, 64) - 1.0 / 4.0).abs() < 1e-2);
        assert!((slanting.coverage(2.0, 1e-3, 1.0, 64) - 1.5 / 4.0).abs() < 1e-2);
        // Pieces smaller than a pixel: alpha itself.
        let even = level([0.3; 4]);
        assert!((even.coverage(1.0, 1.0, 0.1, 4) - 0.3).abs() < 1e-6);
        assert_eq!(even.coverage(1.0, 1.0, 1.0, 4), 0.0);
    }

    #[test]
    fn a_cut_off_becomes_one_half() {
        let image = Image { width: 2, height: 1, rgba: vec![0, 0, 0, 90, 0, 0, 0, 60] };
        let chain = mip_chain(&image, 2, 1, 1, Some((0.3, 0.5)));
        // 90/255 = 0.353 is above 0.3, 60/255 = 0.235 below.
        assert!(chain[0].texels[0][3] > 0.5 && chain[0].texels[1][3] < 0.5);
    }

    #[test]
    fn colour_in_the_holes_does_not_bleed_into_the_leaf() {
        // A red leaf texel beside a black hole.
        let image = Image { width: 2, height: 1, rgba: vec![255, 0, 0, 255, 0, 0, 0, 0] };
        let small = Level::from_image(&image).resize(1, 1);
        assert_eq!(small.texels[0], [1.0, 0.0, 0.0, 0.5]);
    }

    #[test]
    fn srgb_round_trips_every_byte() {
        for byte in 0..=255u8 {
            assert_eq!(srgb(linear(byte)), byte);
        }
    }

    #[test]
    fn resizing_keeps_the_mean() {
        let level = Level::from_image(&strokes(30));
        let mean = |l: &Level| l.texels.iter().map(|t| t[3]).sum::<f32>() / l.texels.len() as f32;
        for size in [7, 15, 21] {
            assert!((mean(&level.resize(size, size)) - mean(&level)).abs() < 1e-4);
        }
    }
}
