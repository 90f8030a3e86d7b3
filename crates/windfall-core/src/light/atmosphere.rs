//! Sun and clear sky through a model of the Earth's atmosphere.
//!
//! S. Hillaire, "A Scalable and Production Ready Sky and Atmosphere Rendering Technique", EGSR 2020:
//! Rayleigh and Mie scattering and ozone, single scattering integrated along the view, all higher
//! orders by his isotropic approximation (equations 5 to 10). Evaluated on the CPU into a small
//! table, once for each height of the sun.

use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Irradiance of the sun outside of the atmosphere, in every channel: white.
pub const SOLAR: f32 = 13.5;

/// Radius of the ground, kilometres.
pub const GROUND: f32 = 6360.0;
/// Radius of the top of the air, kilometres.
pub const TOP: f32 = 6460.0;
/// Scattering by air at sea level, 1/km, at 680, 550 and 440 nm (Hillaire 2020, table 1).
pub const RAYLEIGH: Vec3 = Vec3::new(5.802e-3, 13.558e-3, 33.1e-3);
/// Height over which the air thins by a factor e, kilometres.
pub const RAYLEIGH_HEIGHT: f32 = 8.0;
/// Absorption by ozone at [`OZONE_HEIGHT`], 1/km.
pub const OZONE: Vec3 = Vec3::new(0.650e-3, 1.881e-3, 0.085e-3);
/// Height of the most ozone, kilometres.
pub const OZONE_HEIGHT: f32 = 25.0;
/// Distance above and below it at which there is none, kilometres.
pub const OZONE_REACH: f32 = 15.0;
/// Height over which haze thins by a factor e, kilometres.
pub const MIE_HEIGHT: f32 = 1.2;
/// Share of the haze's extinction that is scattering.
pub const MIE_ALBEDO: f32 = 0.9;
/// Asymmetry of the haze's phase function.
pub const MIE_FORWARD: f32 = 0.8;
/// Reflectance of the ground, for light that comes back from it.
pub const SOIL: f32 = 0.2;
/// Height of the observer, kilometres.
pub const EYE: f32 = 0.1;
/// Smallest sine of the sun's height above the horizon, for its own irradiance.
pub const LOWEST_SUN: f32 = 1e-3;
/// Smallest sine of a view's height above the horizon.
pub const LOWEST_VIEW: f32 = 1e-4;

/// Columns (cosines of the sun) and rows (heights) of the table of transmittance.
pub const TRANSMITTANCE_SIZE: [usize; 2] = [64, 24];
/// Steps of a ray of transmittance.
pub const TRANSMITTANCE_STEPS: u32 = 40;
/// Columns (cosines of the sun) and rows (heights) of the table of multiple scattering.
pub const MULTIPLE_SIZE: [usize; 2] = [20, 10];
/// Heights of the rays of multiple scattering, and azimuths at each.
pub const MULTIPLE_SQRT_RAYS: u32 = 6;
/// Steps of a ray of multiple scattering.
pub const MULTIPLE_STEPS: u32 = 16;
/// Smallest share of light that leaves the air at once, in the series of multiple scattering.
pub const MULTIPLE_LEAST: f32 = 0.05;
/// Steps of a ray of [`SkyTable`].
pub const SKY_STEPS: u32 = 32;

/// The air of a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Atmosphere {
    /// Optical depth of air and haze over that of air alone, `1..=10`: 2 is a clear day (the
    /// default), 5 hazy, 10 a thick haze.
    pub turbidity: f32,
}

impl Default for Atmosphere {
    fn default() -> Self {
        Self { turbidity: 2.0 }
    }
}

/// Scattering and extinction at a height, 1/km.
struct Medium {
    rayleigh: Vec3,
    mie: f32,
    extinction: Vec3,
}

impl Atmosphere {
    /// Extinction by haze at sea level, 1/km.
    pub fn haze(self) -> f32 {
        // Turbidity compares optical depths at 550 nm.
        let turbidity = if self.turbidity.is_nan() { 1.0 } else { self.turbidity.clamp(1.0, 10.0) };
        (turbidity - 1.0) * RAYLEIGH.y * RAYLEIGH_HEIGHT / MIE_HEIGHT
    }

    fn medium(self, height: f32) -> Medium {
        let rayleigh = RAYLEIGH * (-height / RAYLEIGH_HEIGHT).exp();
        let haze = self.haze() * (-height / MIE_HEIGHT).exp();
        let ozone = OZONE * (1.0 - (height - OZONE_HEIGHT).abs() / OZONE_REACH).max(0.0);
        Medium { rayleigh, mie: haze * MIE_ALBEDO, extinction: rayleigh + haze + ozone }
    }

    /// Share of the light that passes from `radius` to the top of the air, at a cosine with the
    /// vertical; nothing where the ground is in the way.
    fn transmittance(self, radius: f32, cosine: f32) -> Vec3 {
        if ground_ahead(radius, cosine) {
            return Vec3::ZERO;
        }
        let length = distance_to(TOP, radius, cosine);
        let mut depth = Vec3::ZERO;
        let mut before = 0.0;
        for i in 0..TRANSMITTANCE_STEPS {
            // Steps grow along the way: the air is dense at its beginning.
            let after = length * ((i + 1) as f32 / TRANSMITTANCE_STEPS as f32).powi(2);
            let (height, _) = along(radius, cosine, 0.5 * (before + after));
            depth += self.medium(height).extinction * (after - before);
            before = after;
        }
        (-depth).exp()
    }

    /// The sky at a height of the sun, radians; below the horizon it is taken as 0.
    pub fn sky(self, elevation: f32) -> SkyTable {
        SkyTable::new(self, elevation.max(0.0))
    }
}

fn ground_ahead(radius: f32, cosine: f32) -> bool {
    cosine < 0.0 && radius * radius * (cosine * cosine - 1.0) + GROUND * GROUND > 0.0
}

/// Way from inside a sphere to it, kilometres.
fn distance_to(sphere: f32, radius: f32, cosine: f32) -> f32 {
    let root = (radius * radius * (cosine * cosine - 1.0) + sphere * sphere).max(0.0).sqrt();
    (root - radius * cosine).max(0.0)
}

/// Height and cosine with the vertical after `distance` kilometres.
fn along(radius: f32, cosine: f32, distance: f32) -> (f32, f32) {
    let r = (radius * radius + distance * distance + 2.0 * radius * cosine * distance).sqrt();
    ((r - GROUND).max(0.0), (radius * cosine + distance) / r)
}

/// Bilinear table over height (rows) and the sun's cosine (columns).
struct Table {
    values: Vec<Vec3>,
    columns: usize,
    rows: usize,
}

impl Table {
    fn new([columns, rows]: [usize; 2], value: impl Fn(f32, f32) -> Vec3) -> Self {
        let mut values = Vec::with_capacity(columns * rows);
        for j in 0..rows {
            let h = (j as f32 / (rows - 1) as f32).powi(2) * (TOP - GROUND);
            for i in 0..columns {
                // Denser about the horizon.
                let s = 2.0 * i as f32 / (columns - 1) as f32 - 1.0;
                values.push(value(h, s * s.abs()));
            }
        }
        Self { values, columns, rows }
    }

    fn at(&self, height: f32, cosine: f32) -> Vec3 {
        let s = cosine.abs().sqrt().copysign(cosine);
        let x = (0.5 * s + 0.5) * (self.columns - 1) as f32;
        let y = (height / (TOP - GROUND)).clamp(0.0, 1.0).sqrt() * (self.rows - 1) as f32;
        let (i, j) = ((x as usize).min(self.columns - 2), (y as usize).min(self.rows - 2));
        let (fx, fy) = (x - i as f32, y - j as f32);
        let row = |j: usize| {
            let first = j * self.columns + i;
            self.values[first].lerp(self.values[first + 1], fx)
        };
        row(j).lerp(row(j + 1), fy)
    }
}

/// What scattering a ray through the air needs.
struct Scattering {
    air: Atmosphere,
    sun: Table,
}

/// Light scattered into a ray.
struct Scattered {
    /// Radiance for a sun of irradiance 1.
    radiance: Vec3,
    /// Share of radiance 1 from everywhere that is scattered into the ray.
    share: Vec3,
}

impl Scattering {
    /// Along a ray from `height`; `cosine` with the vertical, `sun` the sun's there, `towards` the
    /// cosine between ray and sun. `multiple` gives what is scattered more than once; without it
    /// the phase functions are isotropic, as the approximation wants.
    fn ray(
        &self,
        height: f32,
        cosine: f32,
        sun: f32,
        towards: f32,
        steps: u32,
        multiple: Option<&Table>,
    ) -> Scattered {
        let radius = GROUND + height;
        let ground = ground_ahead(radius, cosine);
        let length = if ground {
            radius * -cosine
                - (radius * radius * (cosine * cosine - 1.0) + GROUND * GROUND).max(0.0).sqrt()
        } else {
            distance_to(TOP, radius, cosine)
        };
        let isotropic = 1.0 / (4.0 * PI);
        let (rayleigh_phase, mie_phase) = match multiple {
            None => (isotropic, isotropic),
            Some(_) => (3.0 / (16.0 * PI) * (1.0 + towards * towards), cornette_shanks(towards)),
        };
        let mut out = Scattered { radiance: Vec3::ZERO, share: Vec3::ZERO };
        let mut through = Vec3::ONE;
        let mut before = 0.0;
        for i in 0..steps {
            let after = length * ((i + 1) as f32 / steps as f32).powi(2);
            let middle = 0.5 * (before + after);
            let (h, _) = along(radius, cosine, middle);
            // The sun's direction is fixed, the vertical turns: cosine with the vertical there.
            let sun_there = ((radius * sun + middle * towards) / (GROUND + h)).clamp(-1.0, 1.0);
            let medium = self.air.medium(h);
            let lit = self.sun.at(h, sun_there);
            let mut source = (medium.rayleigh * rayleigh_phase + medium.mie * mie_phase) * lit;
            let scattering = medium.rayleigh + medium.mie;
            if let Some(multiple) = multiple {
                source += scattering * multiple.at(h, sun_there);
            }
            let step = (-medium.extinction * (after - before)).exp();
            // The integral over the step with constant medium (Hillaire 2015).
            let weight = through * (1.0 - step) / medium.extinction.max(Vec3::splat(1e-9));
            out.radiance += weight * source;
            out.share += weight * scattering;
            through *= step;
            before = after;
        }
        if ground {
            let up = ((radius * sun + length * towards) / GROUND).clamp(-1.0, 1.0);
            out.radiance += through * self.sun.at(0.0, up) * (up.max(0.0) * SOIL / PI);
        }
        out
    }

    /// All orders above the first, as radiance for a sun of irradiance 1 (equations 5 to 10).
    fn multiple(&self) -> Table {
        const SQRT_RAYS: u32 = MULTIPLE_SQRT_RAYS;
        Table::new(MULTIPLE_SIZE, |height, sun| {
            let (mut second, mut share) = (Vec3::ZERO, Vec3::ZERO);
            let across = (1.0 - sun * sun).max(0.0).sqrt();
            for i in 0..SQRT_RAYS {
                let y = 1.0 - (2 * i + 1) as f32 / SQRT_RAYS as f32;
                let flat = (1.0 - y * y).sqrt();
                for j in 0..SQRT_RAYS {
                    // Half of the circle: it is symmetric.
                    let x = (PI * (j as f32 + 0.5) / SQRT_RAYS as f32).cos();
                    let ray =
                        self.ray(height, y, sun, y * sun + flat * across * x, MULTIPLE_STEPS, None);
                    second += ray.radiance;
                    share += ray.share;
                }
            }
            let rays = (SQRT_RAYS * SQRT_RAYS) as f32;
            second / rays / (1.0 - share / rays).max(Vec3::splat(MULTIPLE_LEAST))
        })
    }
}

fn cornette_shanks(cosine: f32) -> f32 {
    let g = MIE_FORWARD;
    let below = (1.0 + g * g - 2.0 * g * cosine).powf(1.5);
    3.0 / (8.0 * PI) * (1.0 - g * g) * (1.0 + cosine * cosine) / ((2.0 + g * g) * below)
}

/// Radiance of the sky over the upper half for one height of the sun.
///
/// Columns are the sine of half the azimuth from the sun, rows the square root of the sine of the
/// height: both are fine where the sky changes most.
#[derive(Debug, Clone, PartialEq)]
pub struct SkyTable {
    /// Row by row from the horizon up, [`SkyTable::SIDE`] squared.
    pub radiance: Vec<Vec3>,
    /// Irradiance of the sun on a surface that faces it.
    pub sun: Vec3,
}

impl SkyTable {
    /// Columns and rows.
    pub const SIDE: usize = 64;

    fn new(air: Atmosphere, elevation: f32) -> Self {
        let side = Self::SIDE;
        let transmitted =
            Table::new(TRANSMITTANCE_SIZE, |h, cosine| air.transmittance(GROUND + h, cosine));
        let scattering = Scattering { air, sun: transmitted };
        let multiple = scattering.multiple();
        let (sin, cos) = elevation.sin_cos();
        let mut radiance = Vec::with_capacity(side * side);
        for j in 0..side {
            let v = j as f32 / (side - 1) as f32;
            let y = (v * v).clamp(LOWEST_VIEW, 1.0);
            let flat = (1.0 - y * y).max(0.0).sqrt();
            for i in 0..side {
                let u = i as f32 / (side - 1) as f32;
                let towards = (y * sin + flat * cos * (1.0 - 2.0 * u * u)).clamp(-1.0, 1.0);
                let ray = scattering.ray(EYE, y, sin, towards, SKY_STEPS, Some(&multiple));
                radiance.push(ray.radiance * SOLAR);
            }
        }
        let sun = air.transmittance(GROUND + EYE, sin.max(LOWEST_SUN)) * SOLAR;
        Self { radiance, sun }
    }

    /// Place in the table of a direction, both `0..=1`; `heading` is the unit direction of the sun
    /// along X and Z. Directions below the horizon are at it.
    pub fn place(direction: Vec3, heading: Vec2) -> Vec2 {
        let flat = Vec2::new(direction.x, direction.z).normalize_or(heading);
        Vec2::new(
            (0.5 - 0.5 * flat.dot(heading)).clamp(0.0, 1.0).sqrt(),
            direction.y.clamp(0.0, 1.0).sqrt(),
        )
    }

    /// Radiance towards a direction of the upper half.
    pub fn towards(&self, direction: Vec3, heading: Vec2) -> Vec3 {
        let side = Self::SIDE;
        let at = Self::place(direction, heading) * (side - 1) as f32;
        let (i, j) = ((at.x as usize).min(side - 2), (at.y as usize).min(side - 2));
        let (fx, fy) = (at.x - i as f32, at.y - j as f32);
        let row = |j: usize| self.radiance[j * side + i].lerp(self.radiance[j * side + i + 1], fx);
        row(j).lerp(row(j + 1), fy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sky(degrees: f32, turbidity: f32) -> SkyTable {
        Atmosphere { turbidity }.sky(degrees.to_radians())
    }

    fn luminance(c: Vec3) -> f32 {
        c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
    }

    /// Irradiance of the sky on level ground.
    fn diffuse(sky: &SkyTable) -> f32 {
        let ambient = crate::light::Ambient::project(|d| {
            if d.y > 0.0 { sky.towards(d, Vec2::X) } else { Vec3::ZERO }
        });
        luminance(ambient.irradiance(Vec3::Y)) * PI
    }

    /// Measured under clear skies: at 60° the direct beam is 0.65 to 0.85 of that outside of the
    /// air, and 8 to 22 % of the light on level ground comes from the sky; at 10° a third or more.
    #[test]
    fn sun_and_sky_share_the_light_as_measured() {
        let high = sky(60.0, 2.0);
        let beam = luminance(high.sun) / SOLAR;
        assert!((0.65..0.85).contains(&beam), "{beam}");
        let share = |s: &SkyTable, elevation: f32| {
            let direct = luminance(s.sun) * elevation.to_radians().sin();
            diffuse(s) / (diffuse(s) + direct)
        };
        let at_60 = share(&high, 60.0);
        assert!((0.08..0.22).contains(&at_60), "{at_60}");
        let low = sky(10.0, 2.0);
        assert!((0.3..0.7).contains(&share(&low, 10.0)), "{}", share(&low, 10.0));
    }

    #[test]
    fn no_more_light_arrives_than_the_sun_sends() {
        for (degrees, turbidity) in [(90.0, 1.0), (60.0, 2.0), (30.0, 5.0), (5.0, 10.0)] {
            let s = sky(degrees, turbidity);
            let sin = f32::to_radians(degrees).sin();
            let all = diffuse(&s) + luminance(s.sun) * sin;
            assert!(all < SOLAR * sin, "{degrees}, {turbidity}: {all} of {}", SOLAR * sin);
        }
    }

    #[test]
    fn the_zenith_is_blue_the_horizon_pale_and_a_low_sun_red() {
        let s = sky(35.0, 2.0);
        let zenith = s.towards(Vec3::Y, Vec2::X);
        let horizon = s.towards(Vec3::new(-1.0, 0.02, 0.0), Vec2::X);
        assert!(zenith.z > 2.0 * zenith.x, "{zenith}");
        assert!(luminance(horizon) > 1.5 * luminance(zenith), "{horizon} {zenith}");
        assert!(horizon.z / horizon.x < 0.7 * zenith.z / zenith.x);
        let evening = sky(3.0, 2.0).sun;
        assert!(evening.x > 3.0 * evening.z, "{evening}");
    }

    #[test]
    fn haze_brightens_the_sky_about_the_sun() {
        let towards_sun = Vec3::new(0.80, 0.6, 0.0);
        let (clear, hazy) = (sky(33.0, 1.5), sky(33.0, 6.0));
        assert!(
            luminance(hazy.towards(towards_sun, Vec2::X))
                > 2.0 * luminance(clear.towards(towards_sun, Vec2::X))
        );
        assert!(luminance(hazy.sun) < luminance(clear.sun));
    }

    #[test]
    fn odd_suns_and_airs_are_finite() {
        for (elevation, turbidity) in [(-1.0, f32::NAN), (0.0, 0.0), (2.0, 1e9), (f32::NAN, 2.0)] {
            let s = Atmosphere { turbidity }.sky(elevation);
            assert!(
                s.radiance.iter().chain([&s.sun]).all(|c| c.is_finite() && c.min_element() >= 0.0)
            );
        }
    }
}
