//! What the shading of a crown's leaves draws together towards as fewer of them are drawn (SFS, 4.3.2).

use super::visible::open_areas;
use crate::foliage::Foliage;
use glam::{Mat3, Vec3};
use std::f32::consts::PI;

/// Means over the leaves of a crown that are seen from outside, each leaf by the part of its area that others do
/// not hide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shading {
    /// [`crate::foliage::Leaf::ambient`] over the leaf's place in the crown, by least squares:
    /// [`Self::ambient_at`]. A far crown keeps its light side and its dark middle, and the mean.
    pub ambient: Vec3,
    /// Mean of `n nᵀ` of the leaves' normals `n`: a third of the identity where they lean in every
    /// direction alike.
    pub normals: Mat3,
}

impl Default for Shading {
    /// Leaves that lean in every direction alike, in the open.
    fn default() -> Self {
        Self { ambient: Vec3::X, normals: Mat3::from_diagonal(Vec3::splat(1.0 / 3.0)) }
    }
}

impl Shading {
    /// Looks at a crown from five directions.
    pub fn of(foliage: &Foliage) -> Self {
        let shares = open_areas(foliage);
        let square = |v: Vec3| Mat3::from_cols(v * v.x, v * v.y, v * v.z);
        let extent = foliage.crown_extent();
        let mut normals = Mat3::ZERO;
        let (mut squares, mut products) = (Mat3::ZERO, Vec3::ZERO);
        for (leaf, &share) in foliage.leaves.iter().zip(&shares) {
            normals += square(leaf.orientation * Vec3::Y) * share;
            let place = place_in_crown((leaf.center - foliage.crown_center) / extent);
            squares += square(place) * share;
            products += place * (share * leaf.ambient);
        }
        let sum: f32 = shares.iter().sum();
        // A ridge: slopes of leaves that lie at one depth are 0, and the mean is exact all the same.
        let squares = squares + Mat3::from_diagonal(Vec3::new(0.0, 1e-4, 1e-4) * sum);
        let ambient = squares.inverse() * products;
        // Not `sum < …`: what is not a number is of no use either.
        if !(sum > 0.0 && normals.is_finite() && ambient.is_finite()) {
            return Self::default();
        }
        Self { ambient, normals: normals * (1.0 / sum) }
    }

    /// What leaves at a place of the crown have of the ambient light in the mean, `0..=1`; the place is
    /// from the crown's centre, in half extents of the crown.
    pub fn ambient_at(&self, from_center: Vec3) -> f32 {
        self.ambient.dot(place_in_crown(from_center)).clamp(0.0, 1.0)
    }

    /// `E(|cos|)` between the leaves and a unit vector towards the light, over all of them.
    ///
    /// From the mean of the square, `q`, as `q^(ln 2 / ln 3)`: exact where all leaves lie across the
    /// light (1), along it (0), or in every direction alike (½).
    pub fn mean_cosine(&self, light: Vec3) -> f32 {
        light.dot(self.normals * light).clamp(0.0, 1.0).powf(Self::EXPONENT)
    }

    /// What SFS, equation 5, takes for `2/π` whatever the leaves and the light: the mean cosines of
    /// the light on the leaves that are seen, on the viewer's side and from behind; of each leaf one is
    /// 0. `light` and `view` are unit vectors towards them.
    ///
    /// Of leaves that lean in every direction alike, each seen by its projected area, they are
    /// `2/(3π) (sin α + (π - α) cos α)` and `2/(3π) (sin α - α cos α)`, where `α` is the angle between
    /// light and view: of a sphere, the one is Lambert's phase function, the other that of its far side
    /// shining through. Leaves that lean otherwise are taken for such leaves stretched: `α` is the angle after
    /// that, and they have as much more or less as [`Self::mean_cosine`] is over or under ½.
    pub fn mean_cosines(&self, light: Vec3, view: Vec3) -> [f32; 2] {
        let square = |a: Vec3, b: Vec3| a.dot(self.normals * b);
        let lengths = (square(light, light) * square(view, view)).sqrt();
        let cosine = (square(light, view) / lengths.max(1e-9)).clamp(-1.0, 1.0);
        let (angle, sine) = (cosine.acos(), (1.0 - cosine * cosine).sqrt());
        let scale = 4.0 / (3.0 * PI) * self.mean_cosine(light);
        [scale * (sine + (PI - angle) * cosine), scale * (sine - angle * cosine)]
    }

    /// `ln 2 / ln 3`.
    const EXPONENT: f32 = 0.630_929_75;
}

/// What ambient light depends on: the depth in the crown, and the height.
fn place_in_crown(from_center: Vec3) -> Vec3 {
    Vec3::new(1.0, from_center.length(), from_center.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foliage::Leaf;
    use crate::rng::Rng;
    use crate::tree::species::Species;
    use glam::Quat;

    fn crown(turn: impl Fn(u32) -> Quat) -> Foliage {
        let mut foliage = Species::Birch.grow_with(1, 400).foliage;
        for (i, leaf) in (0..).zip(&mut foliage.leaves) {
            leaf.orientation = turn(i);
        }
        foliage
    }

    #[test]
    fn leaves_that_lie_flat_face_a_light_above_and_not_one_at_the_side() {
        let flat = Shading::of(&crown(|i| Quat::from_rotation_y(i as f32)));
        assert!((flat.mean_cosine(Vec3::Y) - 1.0).abs() < 1e-4);
        assert!(flat.mean_cosine(Vec3::X) < 1e-3);
        // Half of each: in truth (1 + 0) / 2 both ways; the estimate is 0.65.
        let upright = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
        let both = Shading::of(&crown(|i| if i % 2 == 0 { Quat::IDENTITY } else { upright }));
        assert!((0.4..0.75).contains(&both.mean_cosine(Vec3::Y)), "{both:?}");
    }

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
    fn the_mean_of_a_species_is_that_of_its_visible_leaves() {
        for species in [Species::Oak, Species::Birch, Species::Maple] {
            let foliage = species.grow_with(1, 3000).foliage;
            let shading = Shading::of(&foliage);
            let seen = super::super::visible_areas(&foliage);
            let sum: f32 = seen.iter().sum();
            for light in [Vec3::Y, Vec3::new(0.6, 0.8, 0.0), Vec3::new(0.0, 0.3, 0.954)] {
                let cosines = foliage.leaves.iter().zip(&seen);
                let exact = cosines
                    .map(|(l, s)| s * (l.orientation * Vec3::Y).dot(light).abs())
                    .sum::<f32>()
                    / sum;
                let found = shading.mean_cosine(light);
                assert!((found / exact - 1.0).abs() < 0.1, "{species} {light}: {found}, {exact}");
            }
            // On the viewer's side, and from behind, whatever the light: 0.03 of cosines that are 0.5 together.
            let (mut apart, mut count) = (0.0, 0);
            for (height, turn) in
                [0.15f32, 0.6, 1.2].into_iter().flat_map(|h| (0..8).map(move |t| (h, t)))
            {
                let (sin, cos) = (turn as f32 / 8.0 * 2.0 * PI).sin_cos();
                let light = Vec3::new(sin * height.cos(), height.sin(), cos * height.cos());
                let view = Vec3::new(0.0, 0.15, 1.0).normalize_or(Vec3::Z);
                let (mut sides, mut facing) = ([0.0; 2], 0.0);
                for (leaf, s) in foliage.leaves.iter().zip(&seen) {
                    let normal = leaf.orientation * Vec3::Y;
                    let area = s * normal.dot(view).abs();
                    let cosine = normal.dot(light) * normal.dot(view).signum();
                    facing += area;
                    sides[usize::from(cosine < 0.0)] += area * cosine.abs();
                }
                let found = shading.mean_cosines(light, view).into_iter().zip(sides);
                apart += found.map(|(found, sum)| (found - sum / facing).abs()).sum::<f32>();
                count += 1;
            }
            assert!(apart < 0.03 * count as f32, "{species}: {}", apart / count as f32);
            let mean = |of: &dyn Fn(&Leaf) -> f32| {
                foliage.leaves.iter().zip(&seen).map(|(l, s)| of(l) * s).sum::<f32>() / sum
            };
            let extent = foliage.crown_extent();
            let found = |l: &Leaf| shading.ambient_at((l.center - foliage.crown_center) / extent);
            let (ambient, whole) = (mean(&|l| l.ambient), mean(&found));
            assert!((whole / ambient - 1.0).abs() < 0.03, "{species}: {whole}, {ambient}");
            // Its slopes say something: what is left of the spread is less.
            let spread = mean(&|l| (l.ambient - ambient).powi(2));
            let left = mean(&|l| (l.ambient - found(l)).powi(2));
            assert!(left < 0.9 * spread, "{species}: {left} of {spread}");
        }
    }

    #[test]
    fn ambient_light_that_falls_off_evenly_with_depth_is_found_as_it_is() {
        let mut foliage = Species::Birch.grow_with(1, 2000).foliage;
        let (center, extent) = (foliage.crown_center, foliage.crown_extent());
        for leaf in &mut foliage.leaves {
            let place = (leaf.center - center) / extent;
            leaf.ambient = 0.2 + 0.3 * place.length() + 0.1 * place.y;
        }
        let shading = Shading::of(&foliage);
        assert!((shading.ambient - Vec3::new(0.2, 0.3, 0.1)).length() < 0.02, "{shading:?}");
        // At one place, their mean.
        for (i, leaf) in (0..).zip(&mut foliage.leaves) {
            leaf.center = center;
            leaf.ambient = if i % 2 == 0 { 0.4 } else { 0.6 };
        }
        let found = Shading::of(&foliage).ambient_at(Vec3::ZERO);
        assert!((found - 0.5).abs() < 0.11, "{found}");
    }

    #[test]
    fn nothing_and_poison_give_even_leaves() {
        assert_eq!(Shading::of(&Foliage::default()), Shading::default());
        assert!((Shading::default().mean_cosine(Vec3::X) - 0.5).abs() < 1e-6);
        let poison = Shading::of(&crown(|_| Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0)));
        assert!(poison.mean_cosine(Vec3::Y).is_finite());
    }
}
