//! Ambient light as spherical harmonics of the second order (Ramamoorthi & Hanrahan, "An Efficient
//! Representation for Irradiance Environment Maps", SIGGRAPH 2001).

use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// Irradiance over π by the surface's normal: nine colours, each times its polynomial of
/// [`Ambient::basis`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ambient(pub [Vec3; 9]);

impl Ambient {
    /// Rings of equal height of the directions of [`Ambient::project`]; each has twice as many
    /// directions as there are rings.
    pub const RINGS: u32 = 24;

    /// Squares of the harmonics' constants, times the cosine's share of each order: π, 2π/3, π/4;
    /// over π. What [`Ambient::project`] multiplies the integrals of radiance times
    /// [`Ambient::basis`] by.
    pub const FACTORS: [f32; 9] = {
        let (first, second) = (3.0 / (4.0 * PI) * (2.0 / 3.0), 15.0 / (4.0 * PI) * 0.25);
        let zonal = 5.0 / (16.0 * PI) * 0.25;
        [1.0 / (4.0 * PI), first, first, first, second, second, zonal, second, second * 0.25]
    };

    /// 1, y, z, x, xy, yz, 3z² - 1, xz, x² - y² of a unit vector; the constants of the harmonics are
    /// in the colours.
    pub fn basis(n: Vec3) -> [f32; 9] {
        [
            1.0,
            n.y,
            n.z,
            n.x,
            n.x * n.y,
            n.y * n.z,
            3.0 * n.z * n.z - 1.0,
            n.x * n.z,
            n.x * n.x - n.y * n.y,
        ]
    }

    /// Of surroundings with this radiance towards each direction, by the midpoint rule over 24 x 48
    /// equal solid angles.
    pub fn project(radiance: impl Fn(Vec3) -> Vec3) -> Self {
        let mut sums = [Vec3::ZERO; 9];
        let solid_angle = 4.0 * PI / (2 * Self::RINGS * Self::RINGS) as f32;
        for i in 0..Self::RINGS {
            let y = 1.0 - (2 * i + 1) as f32 / Self::RINGS as f32;
            let across = (1.0 - y * y).max(0.0).sqrt();
            for j in 0..2 * Self::RINGS {
                let (sin, cos) = (TAU * (j as f32 + 0.5) / (2 * Self::RINGS) as f32).sin_cos();
                let direction = Vec3::new(across * cos, y, across * sin);
                let light = radiance(direction) * solid_angle;
                for (sum, b) in sums.iter_mut().zip(Self::basis(direction)) {
                    *sum += light * b;
                }
            }
        }
        for (sum, factor) in sums.iter_mut().zip(Self::FACTORS) {
            *sum *= factor;
        }
        Self(sums)
    }

    /// Irradiance over π on a surface with this unit normal.
    pub fn irradiance(&self, normal: Vec3) -> Vec3 {
        self.0.iter().zip(Self::basis(normal)).map(|(c, b)| *c * b).sum::<Vec3>().max(Vec3::ZERO)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WAYS: [Vec3; 4] =
        [Vec3::Y, Vec3::NEG_Y, Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.48, -0.6, 0.64)];

    #[test]
    fn even_light_is_the_same_on_every_surface() {
        let ambient = Ambient::project(|_| Vec3::new(1.0, 2.0, 3.0));
        for way in WAYS {
            let off = ambient.irradiance(way) - Vec3::new(1.0, 2.0, 3.0);
            assert!(off.length() < 0.01, "{way}: {off}");
        }
    }

    /// Smooth surroundings of order two are exact: the integral of L(w) max(n·w, 0) / π is
    /// 1 + 2/3 a·n + (1/4) (3 (b·n)² - 1) / 2 for L = 1 + a·w + (3 (b·w)² - 1) / 2.
    #[test]
    fn smooth_light_is_exact() {
        let (a, b) = (Vec3::new(0.2, 0.5, -0.3), Vec3::new(0.6, -0.64, 0.48));
        let order2 = |w: Vec3| (3.0 * b.dot(w).powi(2) - 1.0) * 0.5;
        let ambient = Ambient::project(|w| Vec3::splat(1.0 + a.dot(w) + order2(w)));
        for way in WAYS {
            let exact = 1.0 + 2.0 / 3.0 * a.dot(way) + 0.25 * order2(way);
            let got = ambient.irradiance(way).x;
            assert!((got - exact).abs() < 0.01, "{way}: {got} for {exact}");
        }
    }
}
