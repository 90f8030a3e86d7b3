//! Mean shading of a crown's visible leaves, towards which simplified trees converge.

use super::visibility::open_areas;
use glam::{Mat3, Vec3};
use windfall_core::foliage::{Foliage, Shading};

/// Measures [`Foliage::shading`]: looks at the crown from five directions. Reads [`Leaf::ambient`].
///
/// [`Leaf::ambient`]: windfall_core::foliage::Leaf::ambient
pub fn shading(foliage: &Foliage) -> Shading {
    let shares = open_areas(foliage);
    let square = |v: Vec3| Mat3::from_cols(v * v.x, v * v.y, v * v.z);
    let extent = foliage.crown_extent();
    let mut normals = Mat3::ZERO;
    let (mut squares, mut products) = (Mat3::ZERO, Vec3::ZERO);
    for (leaf, &share) in foliage.leaves.iter().zip(&shares) {
        normals += square(leaf.orientation * Vec3::Y) * share;
        let place = Shading::place_in_crown((leaf.center - foliage.crown_center) / extent);
        squares += square(place) * share;
        products += place * (share * leaf.ambient);
    }
    let sum: f32 = shares.iter().sum();
    // A ridge: slopes of leaves that lie at one depth are 0, and the mean is exact all the same.
    let squares = squares + Mat3::from_diagonal(Vec3::new(0.0, 1e-4, 1e-4) * sum);
    let ambient = squares.inverse() * products;
    // Not `sum < …`: what is not a number is of no use either.
    if !(sum > 0.0 && normals.is_finite() && ambient.is_finite()) {
        return Shading::default();
    }
    Shading { ambient, normals: normals * (1.0 / sum) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Species;
    use glam::Quat;
    use std::f32::consts::PI;
    use windfall_core::foliage::Leaf;

    fn crown(turn: impl Fn(u32) -> Quat) -> Foliage {
        let mut foliage = Species::Birch.grow_with(1, 400).foliage;
        for (i, leaf) in (0..).zip(&mut foliage.leaves) {
            leaf.orientation = turn(i);
        }
        foliage
    }

    #[test]
    fn leaves_that_lie_flat_face_a_light_above_and_not_one_at_the_side() {
        let flat = shading(&crown(|i| Quat::from_rotation_y(i as f32)));
        assert!((flat.mean_cosine(Vec3::Y) - 1.0).abs() < 1e-4);
        assert!(flat.mean_cosine(Vec3::X) < 1e-3);
        // Half of each: in truth (1 + 0) / 2 both ways; the estimate is 0.65.
        let upright = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
        let both = shading(&crown(|i| if i % 2 == 0 { Quat::IDENTITY } else { upright }));
        assert!((0.4..0.75).contains(&both.mean_cosine(Vec3::Y)), "{both:?}");
    }

    #[test]
    fn the_mean_of_a_species_is_that_of_its_visible_leaves() {
        for species in [Species::Oak, Species::Birch, Species::Maple] {
            let foliage = species.grow_with(1, 3000).foliage;
            let of_crown = shading(&foliage);
            let seen = super::super::visible_areas(&foliage);
            let sum: f32 = seen.iter().sum();
            for light in [Vec3::Y, Vec3::new(0.6, 0.8, 0.0), Vec3::new(0.0, 0.3, 0.954)] {
                let cosines = foliage.leaves.iter().zip(&seen);
                let exact = cosines
                    .map(|(l, s)| s * (l.orientation * Vec3::Y).dot(light).abs())
                    .sum::<f32>()
                    / sum;
                let found = of_crown.mean_cosine(light);
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
                let found = of_crown.mean_cosines(light, view).into_iter().zip(sides);
                apart += found.map(|(found, sum)| (found - sum / facing).abs()).sum::<f32>();
                count += 1;
            }
            assert!(apart < 0.03 * count as f32, "{species}: {}", apart / count as f32);
            let mean = |of: &dyn Fn(&Leaf) -> f32| {
                foliage.leaves.iter().zip(&seen).map(|(l, s)| of(l) * s).sum::<f32>() / sum
            };
            let extent = foliage.crown_extent();
            let found = |l: &Leaf| of_crown.ambient_at((l.center - foliage.crown_center) / extent);
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
        let of_crown = shading(&foliage);
        assert!((of_crown.ambient - Vec3::new(0.2, 0.3, 0.1)).length() < 0.02, "{of_crown:?}");
        // At one place, their mean.
        for (i, leaf) in (0..).zip(&mut foliage.leaves) {
            leaf.center = center;
            leaf.ambient = if i % 2 == 0 { 0.4 } else { 0.6 };
        }
        let found = shading(&foliage).ambient_at(Vec3::ZERO);
        assert!((found - 0.5).abs() < 0.11, "{found}");
    }

    #[test]
    fn nothing_and_poison_give_even_leaves() {
        assert_eq!(shading(&Foliage::default()), Shading::default());
        let poison = shading(&crown(|_| Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0)));
        assert!(poison.mean_cosine(Vec3::Y).is_finite());
    }
}
