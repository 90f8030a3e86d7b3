//! Pictures, and how far they are from each other.

use crate::bench::stand::FORMAT;
use crate::gpu::Gpu;
use crate::output::Picture;
use anyhow::Context;
use glam::Vec3;
use std::path::Path;
use windfall_gpu::{Canvas, Capture, GpuForest, Renderer, Target, View};

/// A picture in linear light, rows from the top.
pub struct Linear {
    width: u32,
    height: u32,
    pixels: Vec<Vec3>,
}

impl Linear {
    pub fn of(rgba: &[u8], (width, height): (u32, u32)) -> Self {
        let table: Vec<f32> = (0..=255u8).map(linear).collect();
        let pixel = |p: &[u8]| Vec3::from([p[0], p[1], p[2]].map(|v| table[usize::from(v)]));
        Self { width, height, pixels: rgba.chunks_exact(4).map(pixel).collect() }
    }

    /// Means of squares of `n` by `n` pixels; sides are multiples of `n`.
    fn reduced(&self, n: u32) -> Self {
        let (width, height) = (self.width / n, self.height / n);
        let mut pixels = vec![Vec3::ZERO; (width * height) as usize];
        for (i, &pixel) in self.pixels.iter().enumerate() {
            let (x, y) = (i as u32 % self.width / n, i as u32 / self.width / n);
            pixels[(y * width + x) as usize] += pixel / (n * n) as f32;
        }
        Self { width, height, pixels }
    }

    /// As it is stored, three bytes a pixel.
    fn encoded(&self) -> Vec<u8> {
        self.pixels.iter().flat_map(|p| p.to_array().map(|v| encoded(v).round() as u8)).collect()
    }

    /// Writes a PNG.
    pub fn save_png(&self, path: &Path) -> anyhow::Result<()> {
        let bytes = self.encoded();
        let rgba: Vec<u8> = bytes.chunks_exact(3).flat_map(|p| [p[0], p[1], p[2], 255]).collect();
        Picture { width: self.width, height: self.height, rgba: &rgba }.save_png(path)
    }

    /// Mean difference, in steps of a stored picture.
    pub fn difference(&self, other: &Self) -> f64 {
        self.steps(other).sum::<f64>() / self.pixels.len().max(1) as f64
    }

    /// The largest mean difference over squares of `side` pixels, steps of a stored picture; sides of the
    /// picture are multiples of it.
    pub fn most_different_tile(&self, other: &Self, side: u32) -> f64 {
        let across = self.width / side;
        let mut sums = vec![0.0; (across * (self.height / side)) as usize];
        for (i, steps) in (0..).zip(self.steps(other)) {
            let (x, y) = (i % self.width / side, i / self.width / side);
            sums[(y * across + x) as usize] += steps;
        }
        sums.into_iter().fold(0.0, f64::max) / f64::from(side * side)
    }

    /// The difference of each pixel.
    fn steps(&self, other: &Self) -> impl Iterator<Item = f64> {
        self.pixels.iter().zip(&other.pixels).map(|(a, b)| {
            let [a, b] = [a, b].map(|v| v.to_array().map(encoded));
            f64::from((a[0] - b[0]).abs() + (a[1] - b[1]).abs() + (a[2] - b[2]).abs()) / 3.0
        })
    }

    /// Mean FLIP error, as a person sees it at 67 pixels a degree.
    pub fn flip(&self, reference: &Self) -> f64 {
        let image = |i: &Self| nv_flip::FlipImageRgb8::with_data(i.width, i.height, &i.encoded());
        let errors =
            nv_flip::flip(image(reference), image(self), nv_flip::DEFAULT_PIXELS_PER_DEGREE);
        let errors = errors.to_vec();
        errors.iter().map(|&e| f64::from(e)).sum::<f64>() / errors.len().max(1) as f64
    }

    #[cfg(test)]
    fn new((width, height): (u32, u32), pixels: Vec<Vec3>) -> Self {
        Self { width, height, pixels }
    }
}

fn linear(stored: u8) -> f32 {
    let v = f32::from(stored) / 255.0;
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// In steps, `0..=255`.
fn encoded(v: f32) -> f32 {
    let v = v.clamp(0.0, 1.0);
    255.0 * if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// What leaves look like, however many they are.
#[derive(Debug, Clone, Copy)]
pub struct Foliage {
    /// Pixels that leaves cover.
    pub covered: f64,
    /// Mean linear colour of what they cover.
    pub color: Vec3,
    /// Mean of its luminance, and its variance over pixels.
    pub luminance: f64,
    pub variance: f64,
}

impl Foliage {
    /// Of leaves alone on black, and what of each pixel they cover.
    pub fn of(leaves: &Linear, coverage: &Linear) -> Self {
        let pixels = || leaves.pixels.iter().zip(coverage.pixels.iter().map(|c| c.x));
        let covered: f64 = pixels().map(|(_, part)| f64::from(part)).sum();
        let color = pixels().map(|(c, _)| c.as_dvec3()).sum::<glam::DVec3>() / covered.max(1e-9);
        let mean = f64::from(luminance(color.as_vec3()));
        let variance = pixels()
            .filter(|(_, part)| *part > 1e-3)
            .map(|(c, part)| f64::from(part) * (f64::from(luminance(*c) / part) - mean).powi(2))
            .sum::<f64>()
            / covered.max(1e-9);
        Self { covered, color: color.as_vec3(), luminance: mean, variance }
    }

    /// Of several sides, each as much as it covers.
    pub fn mean(sides: &[Self]) -> Self {
        let covered: f64 = sides.iter().map(|f| f.covered).sum();
        let mean = |of: &dyn Fn(&Self) -> f64| {
            sides.iter().map(|f| f.covered * of(f)).sum::<f64>() / covered.max(1e-9)
        };
        let color = [0, 1, 2].map(|c| mean(&|f| f64::from(f.color[c])) as f32);
        Self {
            covered,
            color: color.into(),
            luminance: mean(&|f| f.luminance),
            variance: mean(&|f| f.variance),
        }
    }
}

/// What pictures of one size are drawn on.
pub struct Film {
    size: (u32, u32),
    /// Side of the squares of pixels that are averaged.
    reduce: u32,
    canvas: Canvas,
    texture: wgpu::Texture,
}

impl Film {
    /// Pictures of `size`, drawn `reduce` times as wide and high.
    pub fn new(gpu: &Gpu, renderer: &Renderer, size: (u32, u32), reduce: u32) -> Self {
        let size = (size.0 * reduce, size.1 * reduce);
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d { width: size.0, height: size.1, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let canvas = renderer.canvas(&gpu.device, size.0, size.1);
        Self { size, reduce, canvas, texture }
    }

    /// Draws a picture and waits for it.
    pub fn shoot(
        &self,
        gpu: &mut Gpu,
        renderer: &Renderer,
        forest: &GpuForest,
        view: &View,
    ) -> anyhow::Result<Linear> {
        let picture = self.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let target = Target { canvas: &self.canvas, picture: &picture };
        renderer.render(&gpu.queue, &mut encoder, &gpu.profiler, forest, view, target);
        let capture = Capture::encode(&gpu.device, &mut encoder, &self.texture);
        gpu.profiler.resolve_queries(&mut encoder);
        gpu.queue.submit([encoder.finish()]);
        gpu.profiler.end_frame().context("timers")?;
        capture.map();
        gpu.wait()?;
        gpu.check()?;
        gpu.pass_times();
        let rgba = capture.take().context("the picture did not arrive")??;
        Ok(Linear::of(&rgba, self.size).reduced(self.reduce))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_averaged_in_linear_light() {
        let rgba: Vec<u8> = [255u8, 0, 255, 0].iter().flat_map(|&v| [v, v, v, 255]).collect();
        let half = Linear::of(&rgba, (2, 2)).reduced(2);
        assert_eq!(half.pixels, [Vec3::splat(0.5)]);
        assert_eq!(half.encoded(), [188; 3]);
        for stored in [0, 1, 10, 128, 255] {
            assert!((encoded(linear(stored)) - f32::from(stored)).abs() < 1e-3);
        }
    }

    #[test]
    fn half_covered_pixels_count_by_half() {
        let grey = |v: &[f32]| {
            Linear::new((v.len() as u32, 1), v.iter().map(|&v| Vec3::splat(v)).collect())
        };
        // Two pixels of 0.2 and 0.6, and half a pixel of 0.4, on black.
        let leaves = Foliage::of(&grey(&[0.2, 0.6, 0.2, 0.0]), &grey(&[1.0, 1.0, 0.5, 0.0]));
        assert!((leaves.covered - 2.5).abs() < 1e-6);
        assert!((leaves.luminance - 0.4).abs() < 1e-6);
        assert!((leaves.variance - 0.08 / 2.5).abs() < 1e-6, "{leaves:?}");
    }

    #[test]
    fn a_change_of_one_pixel_shows_in_its_square() {
        let dark = vec![Vec3::ZERO; 8 * 4];
        let mut lit = dark.clone();
        lit[8 + 5] = Vec3::ONE;
        let [dark, lit] = [dark, lit].map(|pixels| Linear::new((8, 4), pixels));
        // One of sixteen in the right half, one of 32 in all.
        assert!((lit.most_different_tile(&dark, 4) - 255.0 / 16.0).abs() < 1e-3);
        assert!((lit.difference(&dark) - 255.0 / 32.0).abs() < 1e-3);
        assert_eq!(dark.most_different_tile(&dark, 4), 0.0);
    }

    #[test]
    fn the_same_picture_differs_by_nothing() {
        let ramp = |shift: f32| {
            let pixels = (0..900).map(|i| Vec3::splat(i as f32 / 900.0 + shift)).collect();
            Linear::new((30, 30), pixels)
        };
        let (a, b) = (ramp(0.0), ramp(0.05));
        assert_eq!((a.difference(&a), a.flip(&a)), (0.0, 0.0));
        assert!(b.difference(&a) > 3.0 && b.flip(&a) > 0.02);
    }
}
