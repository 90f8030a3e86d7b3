//! What a leaf does to light.
//!
//! A thin two-sided scatterer: diffuse reflection and diffuse transmission, as measured leaves are
//! modelled (Jacquemoud & Baret, "PROSPECT", Remote Sensing of Environment 34, 1990: what leaves pass
//! in the visible is somewhat less than what they reflect, and passed the pigments more often), under
//! a waxy surface with microfacet gloss (Walter et al., "Microfacet Models for Refraction", EGSR
//! 2007; Fresnel by Schlick 1994). It never sends out more than falls in: see the tests here and of
//! the shader.

use glam::Vec3;
use std::f32::consts::PI;

/// Reflectance of the wax at normal incidence: refractive index 1.45.
pub const WAX: f32 = 0.034;
/// Roughness of the wax, squared (GGX's α).
pub const ALPHA: f32 = 0.25;
/// Most that a leaf sends on of what enters it.
const MOST: f32 = 0.95;
/// Transmittance of a white leaf over its reflectance.
const PASSED: f32 = 0.8;

/// Reflectance and transmittance of a leaf of this colour, linear, each channel `0..`; together at
/// most 0.95.
pub fn diffuse(color: Vec3) -> (Vec3, Vec3) {
    let tint = color / color.max_element().max(1e-3);
    let through = color * tint * PASSED;
    let keep = (MOST / (color + through).max_element().max(MOST)).min(1.0);
    (color * keep, through * keep)
}

/// Schlick's Fresnel reflectance.
pub fn fresnel(cosine: f32) -> f32 {
    WAX + (1.0 - WAX) * (1.0 - cosine).clamp(0.0, 1.0).powi(5)
}

/// Radiance towards `view` per irradiance on a surface that faces the light.
///
/// `normal` is on the viewer's side, `facing` its cosine with the light, `light` and `view` unit
/// vectors away from the leaf. `volume` is the cosine of the bent normal with the light, and `bend`
/// its share of the diffuse reflection, `0..=1`.
pub fn scatter(
    color: Vec3,
    normal: Vec3,
    facing: f32,
    volume: f32,
    bend: f32,
    light: Vec3,
    view: Vec3,
) -> Vec3 {
    let (reflected, passed) = diffuse(color);
    let n_v = normal.dot(view).max(1e-3);
    let front = facing.max(0.0) * (1.0 - bend) + volume.max(0.0) * bend;
    let body = (reflected * front + passed * (-facing).max(0.0)) * ((1.0 - fresnel(n_v)) / PI);
    if facing <= 0.0 {
        return body;
    }
    let half = (light + view).normalize_or(normal);
    let n_h = normal.dot(half).clamp(0.0, 1.0);
    let a2 = ALPHA * ALPHA;
    let d = n_h * n_h * (a2 - 1.0) + 1.0;
    // The distribution times Smith's visibility as Hammon approximates it (GDC 2017).
    let visibility = 0.5 / (2.0 * facing * n_v * (1.0 - ALPHA) + (facing + n_v) * ALPHA);
    let gloss = a2 / (PI * d * d) * visibility * fresnel(view.dot(half).max(0.0)) * facing;
    body + Vec3::splat(gloss)
}

/// What the wax of leaves that lean in every direction alike, each seen by its projected area, sends towards
/// `view` in the mean, as [`scatter`] has it: what is left of glints that are smaller than a pixel.
///
/// Of mirrors it is Fresnel's reflectance over `4π`, whatever the angle; rough wax hides and shades some of it
/// where the light comes from behind the leaves. Within a tenth of the sum while that is not nearly so.
pub fn mean_gloss(light: Vec3, view: Vec3) -> f32 {
    let cosine = view.dot((light + view).normalize_or_zero()).max(0.0);
    fresnel(cosine) / (4.0 * PI) * 2.16 * cosine / (1.0 + cosine)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn glints_of_many_leaves_have_the_mean_gloss() {
        let view = Vec3::Z;
        for degrees in [0.0f32, 30.0, 60.0, 90.0, 120.0] {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let light = Vec3::new(sine, 0.0, cosine);
            let mut rng = Rng::new(4);
            let (mut sum, mut seen) = (0.0, 0.0);
            for _ in 0..400_000 {
                let v = Vec3::new(rng.normal(), rng.normal(), rng.normal()).normalize_or(Vec3::Z);
                let normal = v * v.dot(view).signum();
                let facing = normal.dot(light);
                seen += normal.dot(view);
                sum +=
                    normal.dot(view) * scatter(Vec3::ZERO, normal, facing, 0.0, 0.0, light, view).x;
            }
            let ratio = mean_gloss(light, view) / (sum / seen);
            assert!((ratio - 1.0).abs() < 0.1, "{degrees}: {ratio}");
        }
    }

    /// A furnace: light of radiance 1 from everywhere. Sums over 200,000 directions, for colours up
    /// to and beyond white and views from straight on to grazing.
    #[test]
    fn no_leaf_sends_out_more_than_falls_in() {
        let normal = Vec3::Y;
        for color in [Vec3::splat(1.0), Vec3::splat(1.3), Vec3::new(0.9, 0.6, 0.05)] {
            for n_v in [1.0f32, 0.7, 0.4, 0.2, 0.05] {
                let view = Vec3::new((1.0 - n_v * n_v).sqrt(), n_v, 0.0);
                let bent = Vec3::new(0.6, 0.64, 0.48);
                let mut rng = Rng::new(3);
                let mut sum = Vec3::ZERO;
                let count = 200_000;
                for _ in 0..count {
                    let v = Vec3::new(rng.normal(), rng.normal(), rng.normal());
                    let light = v.normalize_or(Vec3::Y);
                    let (facing, volume) = (normal.dot(light), bent.dot(light));
                    sum += scatter(color, normal, facing, volume, 0.35, light, view);
                }
                let out = sum * (4.0 * PI / count as f32);
                assert!(out.max_element() <= 1.0, "{color} at {n_v}: {out}");
                assert!(out.max_element() > 0.3, "{color} at {n_v}: {out}");
            }
        }
    }

    #[test]
    fn a_leaf_against_the_sun_glows_in_a_deeper_colour() {
        let color = Vec3::new(0.7, 0.45, 0.05);
        let (reflected, passed) = diffuse(color);
        assert!(passed.z / passed.x < reflected.z / reflected.x * 0.5);
        assert!(passed.x > 0.5 * reflected.x);
    }
}
