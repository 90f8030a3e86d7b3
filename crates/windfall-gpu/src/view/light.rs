//! Where light comes from: Windfall's own sky, or the host.

use crate::base::constants::CASCADES;
use crate::base::shared::{Frame, SkyUniform};
use crate::scene::sky_map::SkyMap;
use glam::{DMat4, DVec3, Mat4, Vec3, Vec4};
use windfall_core::light::Ambient;

/// Light and air of a view.
#[derive(Debug, Clone, PartialEq)]
pub enum Light {
    /// Windfall's own sun and sky, with a picture of the sky as background and ambient light if there is one.
    Sky(Sky, Option<SkyMap>),
    /// The host's.
    Host(HostLight),
}

impl Default for Light {
    /// A clear day.
    fn default() -> Self {
        Self::Sky(Sky::default(), None)
    }
}

impl From<Sky> for Light {
    fn from(sky: Sky) -> Self {
        Self::Sky(sky, None)
    }
}

impl Light {
    /// Unit vector towards the sun.
    pub fn sun_direction(&self) -> Vec3 {
        match self {
            Self::Sky(sky, _) => sky.sun_direction(),
            Self::Host(light) => light.sun_direction.normalize_or(Vec3::Y),
        }
    }
}

/// The light of a host's own scene.
#[derive(Debug, Clone, PartialEq)]
pub struct HostLight {
    /// Unit vector towards the sun, or the moon.
    pub sun_direction: Vec3,
    /// Its irradiance on a surface that faces it, linear, in the unit in which the host's target has radiance.
    pub sun: Vec3,
    /// Irradiance from all around, over π, by the normal: harmonics of order 2 ([`Ambient`]).
    pub ambient: Ambient,
    /// The host's shadow map of that sun; `None`: Windfall's own with [`crate::Layers::shadows`], else none.
    pub shadow: Option<HostShadow>,
    /// Extinction of the air, 1/m: what is far away takes the colour of the ambient light. 0, the safe value, is
    /// none; hosts add their own fog afterwards, from depth.
    pub haze: f32,
}

/// A shadow map of the host's, with up to three cascades.
#[derive(Debug, Clone, PartialEq)]
pub struct HostShadow {
    /// The maps: a depth texture with a layer for each cascade, viewed as an array, usage `TEXTURE_BINDING`.
    pub view: wgpu::TextureView,
    /// The cascades, nearest first; one to three. Orthographic.
    pub cascades: Vec<HostCascade>,
    /// Whether depth is 1 nearest to the sun.
    pub reversed: bool,
}

/// One cascade of a host's shadow map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HostCascade {
    /// Clip space of the map from the world. Where it ends, the map's texels end.
    pub clip_from_world: DMat4,
    /// Distance from the camera up to which the cascade is used, metres.
    pub end: f32,
    /// Size of a texel, metres.
    pub texel: f32,
}

impl HostLight {
    /// A sun and an even ambient light, without shadows.
    pub fn new(sun_direction: Vec3, sun: Vec3, ambient: Vec3) -> Self {
        let mut harmonics = [Vec3::ZERO; 9];
        harmonics[0] = ambient;
        Self { sun_direction, sun, ambient: Ambient(harmonics), shadow: None, haze: 0.0 }
    }

    pub(crate) fn describe(&self, frame: &mut Frame, shadows: bool, origin: DVec3) {
        frame.sun_direction = self.sun_direction.normalize_or(Vec3::Y);
        frame.haze = self.haze;
        frame.exposure = 1.0;
        let SkyUniform { ambient, sun_color, sky_scale } = self.uniform();
        (frame.ambient, frame.sun_color, frame.sky_scale) = (ambient, sun_color, sky_scale);
        let Some(shadow) = &self.shadow else { return };
        let Some(last) = shadow.cascades.last() else { return };
        let cascade = |i: usize| shadow.cascades.get(i).unwrap_or(last);
        let world_from_local = DMat4::from_translation(origin);
        let matrix = |i: usize| -> Mat4 {
            let clip = (cascade(i).clip_from_world * world_from_local).as_mat4();
            // Depth is 0 nearest to the sun for all that computes with it.
            let flip = Mat4::from_cols(
                Vec4::X,
                Vec4::Y,
                Vec4::new(0.0, 0.0, -1.0, 0.0),
                Vec4::new(0.0, 0.0, 1.0, 1.0),
            );
            if shadow.reversed { flip * clip } else { clip }
        };
        frame.shadow_from_world = std::array::from_fn(matrix);
        let ends: [f32; CASCADES as usize] = std::array::from_fn(|i| cascade(i).end);
        let texels: [f32; CASCADES as usize] = std::array::from_fn(|i| cascade(i).texel);
        frame.shadow_ends = Vec3::from(ends).extend(f32::from(u8::from(shadows)));
        frame.shadow_texels = Vec3::from(texels).extend(1.0);
        frame.shadow_reversed = u32::from(shadow.reversed);
    }

    pub(crate) fn uniform(&self) -> SkyUniform {
        SkyUniform {
            ambient: self.ambient.0.map(|c| c.extend(0.0)),
            sun_color: self.sun,
            sky_scale: 1.0,
        }
    }
}

/// Light of the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sky {
    /// Direction of the sun seen from above: 0 is +Z, a quarter turn is +X. Radians.
    pub sun_azimuth: f32,
    /// Height of the sun over the horizon, radians, `0..=π/2`.
    pub sun_elevation: f32,
    /// Haze over clear air high above, `1..=10`: 2 is a clear day, 5 hazy
    /// ([`windfall_core::light::Atmosphere`]).
    pub turbidity: f32,
    /// Extinction of the air near the ground, 1/m; 0 is clear, 0.002 a hazy morning.
    pub haze: f32,
    /// Share of the sky that thin clouds cover, `0..=1`.
    pub clouds: f32,
    /// Exposure in stops; 0 is the default.
    pub exposure: f32,
}

impl Default for Sky {
    fn default() -> Self {
        Self {
            sun_azimuth: 0.7,
            sun_elevation: 0.55,
            turbidity: 2.2,
            haze: 0.0008,
            clouds: 0.35,
            exposure: 0.0,
        }
    }
}

impl Sky {
    /// Unit vector towards the sun.
    pub fn sun_direction(&self) -> Vec3 {
        let (sin_a, cos_a) = self.sun_azimuth.sin_cos();
        let (sin_e, cos_e) = self.sun_elevation.sin_cos();
        Vec3::new(cos_e * sin_a, sin_e, cos_e * cos_a)
    }
}
