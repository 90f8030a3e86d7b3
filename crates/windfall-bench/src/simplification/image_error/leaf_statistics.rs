//! Statistics of the leaf pixels of an image.

use crate::image::LinearImage;
use glam::{DVec3, Vec3};

/// Coverage, color and contrast of leaves, however many they are.
#[derive(Debug, Clone, Copy)]
pub struct LeafStatistics {
    /// Pixels that leaves cover.
    pub covered: f64,
    /// Mean linear color of these pixels.
    pub color: Vec3,
    /// Mean luminance of these pixels.
    pub luminance: f64,
    /// Variance of their luminance.
    pub variance: f64,
}

impl LeafStatistics {
    /// Statistics of an image of leaves alone on black. `coverage` is the share of each pixel that
    /// leaves cover.
    pub fn of(leaves: &LinearImage, coverage: &LinearImage) -> Self {
        let pixels = || leaves.pixels().iter().zip(coverage.pixels().iter().map(|c| c.x));
        let covered: f64 = pixels().map(|(_, share)| f64::from(share)).sum();
        let color = pixels().map(|(c, _)| c.as_dvec3()).sum::<DVec3>() / covered.max(1e-9);
        let mean = f64::from(luminance(color.as_vec3()));
        let variance = pixels()
            .filter(|(_, share)| *share > 1e-3)
            .map(|(c, share)| f64::from(share) * (f64::from(luminance(*c) / share) - mean).powi(2))
            .sum::<f64>()
            / covered.max(1e-9);
        Self { covered, color: color.as_vec3(), luminance: mean, variance }
    }

    /// The mean of several images, weighted by their coverage.
    pub fn mean(images: &[Self]) -> Self {
        let covered: f64 = images.iter().map(|s| s.covered).sum();
        let mean = |of: &dyn Fn(&Self) -> f64| {
            images.iter().map(|s| s.covered * of(s)).sum::<f64>() / covered.max(1e-9)
        };
        let color = [0, 1, 2].map(|c| mean(&|s| f64::from(s.color[c])) as f32);
        Self {
            covered,
            color: color.into(),
            luminance: mean(&|s| s.luminance),
            variance: mean(&|s| s.variance),
        }
    }
}

/// Relative luminance of linear color (Rec. 709).
fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_covered_pixels_count_by_half() {
        let grey = |v: &[f32]| {
            LinearImage::new((v.len() as u32, 1), v.iter().map(|&v| Vec3::splat(v)).collect())
        };
        // Two pixels of 0.2 and 0.6, and half a pixel of 0.4, on black.
        let leaves = LeafStatistics::of(&grey(&[0.2, 0.6, 0.2, 0.0]), &grey(&[1.0, 1.0, 0.5, 0.0]));
        assert!((leaves.covered - 2.5).abs() < 1e-6);
        assert!((leaves.luminance - 0.4).abs() < 1e-6);
        assert!((leaves.variance - 0.08 / 2.5).abs() < 1e-6, "{leaves:?}");
    }
}
