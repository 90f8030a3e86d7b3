//! Images in linear light, and differences between them.

use glam::Vec3;
use std::path::Path;
use windfall_host::image::RgbaImage;

/// An image in linear light, rows from the top.
pub struct LinearImage {
    width: u32,
    height: u32,
    pixels: Vec<Vec3>,
}

impl LinearImage {
    /// Decodes 8-bit sRGB with alpha, which is ignored.
    pub fn of(rgba: &[u8], (width, height): (u32, u32)) -> Self {
        let table: Vec<f32> = (0..=255u8).map(linear_from_srgb).collect();
        let pixel = |p: &[u8]| Vec3::from([p[0], p[1], p[2]].map(|v| table[usize::from(v)]));
        Self { width, height, pixels: rgba.chunks_exact(4).map(pixel).collect() }
    }

    #[cfg(test)]
    pub fn new((width, height): (u32, u32), pixels: Vec<Vec3>) -> Self {
        Self { width, height, pixels }
    }

    pub fn pixels(&self) -> &[Vec3] {
        &self.pixels
    }

    /// Means of squares of `n` by `n` pixels. Width and height are multiples of `n`.
    pub fn downsampled(&self, n: u32) -> Self {
        let (width, height) = (self.width / n, self.height / n);
        let mut pixels = vec![Vec3::ZERO; (width * height) as usize];
        for (i, &pixel) in self.pixels.iter().enumerate() {
            let (x, y) = (i as u32 % self.width / n, i as u32 / self.width / n);
            pixels[(y * width + x) as usize] += pixel / (n * n) as f32;
        }
        Self { width, height, pixels }
    }

    /// 8-bit sRGB, three bytes per pixel.
    fn encoded(&self) -> Vec<u8> {
        let bytes = |p: &Vec3| p.to_array().map(|v| srgb_from_linear(v).round() as u8);
        self.pixels.iter().flat_map(bytes).collect()
    }

    /// Writes a PNG file.
    pub fn save_png(&self, path: &Path) -> anyhow::Result<()> {
        let bytes = self.encoded();
        let rgba: Vec<u8> = bytes.chunks_exact(3).flat_map(|p| [p[0], p[1], p[2], 255]).collect();
        RgbaImage { width: self.width, height: self.height, rgba: &rgba }.save_png(path)
    }

    /// Mean absolute difference in sRGB, in steps of 1/255.
    pub fn difference(&self, other: &Self) -> f64 {
        self.pixel_differences(other).sum::<f64>() / self.pixels.len().max(1) as f64
    }

    /// The largest mean difference of a tile of `side` by `side` pixels, in steps of 1/255. Width
    /// and height are multiples of `side`.
    pub fn most_different_tile(&self, other: &Self, side: u32) -> f64 {
        let across = self.width / side;
        let mut sums = vec![0.0; (across * (self.height / side)) as usize];
        for (i, difference) in (0..).zip(self.pixel_differences(other)) {
            let (x, y) = (i % self.width / side, i / self.width / side);
            sums[(y * across + x) as usize] += difference;
        }
        sums.into_iter().fold(0.0, f64::max) / f64::from(side * side)
    }

    /// Mean absolute difference of the channels of each pixel, in steps of 1/255.
    fn pixel_differences(&self, other: &Self) -> impl Iterator<Item = f64> {
        self.pixels.iter().zip(&other.pixels).map(|(a, b)| {
            let [a, b] = [a, b].map(|v| v.to_array().map(srgb_from_linear));
            f64::from((a[0] - b[0]).abs() + (a[1] - b[1]).abs() + (a[2] - b[2]).abs()) / 3.0
        })
    }

    /// Mean FLIP error at FLIP's default of 67 pixels per degree.
    pub fn flip(&self, reference: &Self) -> f64 {
        let image = |i: &Self| nv_flip::FlipImageRgb8::with_data(i.width, i.height, &i.encoded());
        let errors =
            nv_flip::flip(image(reference), image(self), nv_flip::DEFAULT_PIXELS_PER_DEGREE);
        let errors = errors.to_vec();
        errors.iter().map(|&e| f64::from(e)).sum::<f64>() / errors.len().max(1) as f64
    }
}

fn linear_from_srgb(stored: u8) -> f32 {
    let v = f32::from(stored) / 255.0;
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// In `0..=255`, not rounded.
fn srgb_from_linear(v: f32) -> f32 {
    let v = v.clamp(0.0, 1.0);
    255.0 * if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_averaged_in_linear_light() {
        let rgba: Vec<u8> = [255u8, 0, 255, 0].iter().flat_map(|&v| [v, v, v, 255]).collect();
        let half = LinearImage::of(&rgba, (2, 2)).downsampled(2);
        assert_eq!(half.pixels, [Vec3::splat(0.5)]);
        assert_eq!(half.encoded(), [188; 3]);
        for stored in [0, 1, 10, 128, 255] {
            let again = srgb_from_linear(linear_from_srgb(stored));
            assert!((again - f32::from(stored)).abs() < 1e-3);
        }
    }

    #[test]
    fn a_change_of_one_pixel_shows_in_its_square() {
        let dark = vec![Vec3::ZERO; 8 * 4];
        let mut lit = dark.clone();
        lit[8 + 5] = Vec3::ONE;
        let [dark, lit] = [dark, lit].map(|pixels| LinearImage::new((8, 4), pixels));
        // One of sixteen pixels in the right half, one of 32 in the image.
        assert!((lit.most_different_tile(&dark, 4) - 255.0 / 16.0).abs() < 1e-3);
        assert!((lit.difference(&dark) - 255.0 / 32.0).abs() < 1e-3);
        assert_eq!(dark.most_different_tile(&dark, 4), 0.0);
    }

    #[test]
    fn the_same_picture_differs_by_nothing() {
        let ramp = |shift: f32| {
            let pixels = (0..900).map(|i| Vec3::splat(i as f32 / 900.0 + shift)).collect();
            LinearImage::new((30, 30), pixels)
        };
        let (a, b) = (ramp(0.0), ramp(0.05));
        assert_eq!((a.difference(&a), a.flip(&a)), (0.0, 0.0));
        assert!(b.difference(&a) > 3.0 && b.flip(&a) > 0.02);
    }
}
