//! Mean shading of a crown, towards which leaves converge as fewer of them are drawn (SFS, 4.3.2).

use glam::{Mat3, Vec3};
use std::f32::consts::PI;

/// Means over the leaves of a crown that are visible from outside, weighted by their visible area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shading {
    /// [`crate::foliage::Leaf::ambient`] as a linear function of the leaf's place in the crown, fitted by least
    /// squares: [`Self::ambient_at`]. A far crown keeps its bright outside, its dark middle and its mean.
    pub ambient: Vec3,
    /// Mean of `n nᵀ` over the leaves' normals `n`: a third of the identity where normals are uniform over the
    /// sphere.
    pub normals: Mat3,
}

impl Default for Shading {
    /// Normals uniform over the sphere, no occlusion.
    fn default() -> Self {
        Self { ambient: Vec3::X, normals: Mat3::from_diagonal(Vec3::splat(1.0 / 3.0)) }
    }
}

impl Shading {
    /// Mean ambient light of leaves at a place of the crown, `0..=1`; the place is relative to the crown's centre, in
    /// half extents of the crown.
    pub fn ambient_at(&self, from_center: Vec3) -> f32 {
        self.ambient.dot(Self::place_in_crown(from_center)).clamp(0.0, 1.0)
    }

    /// Mean `|cos|` between the leaves' normals and a unit vector towards the light.
    ///
    /// Estimated from the mean square `q` as `q^(ln 2 / ln 3)`: exact where all leaves face the
    /// light (1), are edge on to it (0), or have normals uniform over the sphere (½).
    pub fn mean_cosine(&self, light: Vec3) -> f32 {
        light.dot(self.normals * light).clamp(0.0, 1.0).powf(Self::EXPONENT)
    }

    /// Mean cosines of the light on the visible leaves, lit on the viewer's side and lit from behind; for each leaf
    /// one of the two is 0. SFS, equation 5, uses `2/π` whatever the leaves and the light. `light` and `view` are unit
    /// vectors towards them.
    ///
    /// For normals uniform over the sphere, weighted by projected area, they are
    /// `2/(3π) (sin α + (π - α) cos α)` and `2/(3π) (sin α - α cos α)`, where `α` is the angle between
    /// light and view: Lambert's phase function of a sphere, and that of its far side shining through. Other
    /// distributions are treated as a stretched sphere: `α` is the angle after stretching, and both cosines are scaled
    /// by twice [`Self::mean_cosine`].
    pub fn mean_cosines(&self, light: Vec3, view: Vec3) -> [f32; 2] {
        let square = |a: Vec3, b: Vec3| a.dot(self.normals * b);
        let lengths = (square(light, light) * square(view, view)).sqrt();
        let cosine = (square(light, view) / lengths.max(1e-9)).clamp(-1.0, 1.0);
        let (angle, sine) = (cosine.acos(), (1.0 - cosine * cosine).sqrt());
        let scale = 4.0 / (3.0 * PI) * self.mean_cosine(light);
        [scale * (sine + (PI - angle) * cosine), scale * (sine - angle * cosine)]
    }

    /// Basis of the fit of [`Self::ambient`] at a place of the crown (relative to its centre, in half extents): 1, the
    /// distance from the centre, and the height.
    pub fn place_in_crown(from_center: Vec3) -> Vec3 {
        Vec3::new(1.0, from_center.length(), from_center.y)
    }

    /// `ln 2 / ln 3`.
    const EXPONENT: f32 = 0.630_929_75;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn leaves_that_lean_in_every_direction_have_the_cosines_that_sums_over_them_give() {
        let mut rng = Rng::new(5);
        let leaves: Vec<Vec3> = (0..100_000)
            .map(|_| Vec3::new(rng.normal(), rng.normal(), rng.normal()).normalize_or(Vec3::Y))
            .collect();
        let view = Vec3::Z;
        for angle in [0.0f32, 0.4, 1.2, 2.0, 3.1] {
            let light = Vec3::new(angle.sin(), 0.0, angle.cos());
            let (mut front, mut back, mut seen) = (0.0, 0.0, 0.0);
            for n in &leaves {
                let n = *n * n.dot(view).signum();
                seen += n.dot(view);
                front += n.dot(view) * n.dot(light).max(0.0);
                back += n.dot(view) * (-n.dot(light)).max(0.0);
            }
            let found = Shading::default().mean_cosines(light, view);
            assert!((found[0] - front / seen).abs() < 0.01, "{angle}: {found:?}");
            assert!((found[1] - back / seen).abs() < 0.01, "{angle}: {found:?}");
        }
    }

    #[test]
    fn leaves_of_no_crown_lean_in_every_direction() {
        assert!((Shading::default().mean_cosine(Vec3::X) - 0.5).abs() < 1e-6);
        assert_eq!(Shading::default().ambient_at(Vec3::splat(0.3)), 1.0);
    }
}
