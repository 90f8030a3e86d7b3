//! The sky behind everything, and its light: the table of the model, the host's picture, the ambient
//! light of either.

use super::{
    Shaders,
    draw::{Draw, DrawTarget},
};
use crate::view::Sky;
use glam::{Vec2, Vec3};
use half::f16;
use windfall_core::light::{Ambient, Atmosphere, SkyTable};

/// What the ground of a wood reflects.
const SOIL: Vec3 = Vec3::new(0.17, 0.115, 0.06);
/// Share of the sun that reaches it between the trees.
const SUNLIT: f32 = 0.5;
/// Radiance of a picture's texel over the mean above which it is taken as the sun, which shines by
/// itself.
const SUN_TEXEL: f32 = 20.0;

pub(crate) struct SkyDome {
    pipeline: wgpu::RenderPipeline,
}

impl SkyDome {
    pub fn new(shaders: &Shaders<'_>) -> Self {
        Self {
            pipeline: shaders.pipeline(&Draw {
                label: "sky",
                source: include_str!("../../shaders/sky.wgsl"),
                groups: &[],
                buffers: &[],
                cull: None,
                vertex: "vertex",
                fragment: Some("fragment"),
                target: DrawTarget::Radiance,
                constants: &[],
            }),
        }
    }

    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_pipeline(&self.pipeline);
        pass.draw(0..3, 0..1);
    }
}

/// A picture of the whole sky, as a host reads it from a `.hdr` or `.exr` file.
#[derive(Debug, Clone, PartialEq)]
pub struct SkyPicture {
    width: u32,
    height: u32,
    radiance: Vec<Vec3>,
    /// Mean luminance of the upper half without the sun.
    mean: f32,
}

/// Why numbers are no [`SkyPicture`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SkyPictureError {
    /// Sides or number of texels do not fit.
    #[error(
        "{width}x{height} is no equirectangular picture: twice as wide as high, 2 to 8192 texels wide"
    )]
    Size {
        /// Texels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A number is negative, infinite or not a number.
    #[error("texel {index} is {value}; radiance is finite and not negative")]
    Value {
        /// Its index, row by row.
        index: usize,
        /// What it holds.
        value: String,
    },
    /// Nothing shines.
    #[error("the upper half is black")]
    Dark,
}

impl SkyPicture {
    /// Equirectangular linear radiance in any unit, row by row from the zenith down, +Z in the
    /// middle of a row and +X a quarter of the width right of it.
    ///
    /// # Errors
    ///
    /// If it is not twice as wide as high (up to 8192 wide), a number is not finite or below 0, or
    /// its upper half is black.
    pub fn new(width: u32, height: u32, radiance: Vec<Vec3>) -> Result<Self, SkyPictureError> {
        let fits = width == 2 * height && (2..=8192).contains(&width);
        if !fits || radiance.len() as u64 != u64::from(width) * u64::from(height) {
            return Err(SkyPictureError::Size { width, height });
        }
        let odd = |c: &Vec3| !c.is_finite() || c.min_element() < 0.0;
        if let Some(index) = radiance.iter().position(odd) {
            return Err(SkyPictureError::Value { index, value: radiance[index].to_string() });
        }
        let mut picture = Self { width, height, radiance, mean: f32::INFINITY };
        // A picture may hold the sun as bright as it is, which outshines the sky: what it adds to the
        // mean goes round by round.
        for _ in 0..24 {
            let before = picture.mean;
            picture.mean = picture.mean_below(before * SUN_TEXEL);
            if picture.mean > 0.99 * before {
                break;
            }
        }
        if picture.mean <= 0.0 { Err(SkyPictureError::Dark) } else { Ok(picture) }
    }

    /// Mean luminance of the upper half by solid angle, no texel's above `most`.
    fn mean_below(&self, most: f32) -> f32 {
        // Of many bright texels the sum is beyond what an f32 holds to the last dim one.
        let (mut sum, mut weight) = (0.0, 0.0);
        for y in 0..self.height.div_ceil(2) {
            let solid =
                (std::f64::consts::PI * (f64::from(y) + 0.5) / f64::from(self.height)).sin();
            for x in 0..self.width {
                sum += f64::from(luminance(self.texel(x, y)).min(most)) * solid;
                weight += solid;
            }
        }
        (sum / weight) as f32
    }

    fn texel(&self, x: u32, y: u32) -> Vec3 {
        self.radiance[(y * self.width + x % self.width) as usize]
    }

    /// The sky's own light: what is brighter than [`SUN_TEXEL`] means is the sun's.
    fn towards(&self, direction: Vec3, most: f32) -> Vec3 {
        let turn = 0.5 + direction.x.atan2(direction.z) / std::f32::consts::TAU;
        let x = (turn * self.width as f32) as u32;
        let y = direction.y.clamp(-1.0, 1.0).acos() / std::f32::consts::PI * self.height as f32;
        let color = self.texel(x, (y as u32).min(self.height - 1));
        color * (most / luminance(color).max(most))
    }

    pub(crate) fn upload(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> wgpu::TextureView {
        let most = self.mean * SUN_TEXEL * 4.0;
        let texture = sky_texture(device, "sky picture", self.width, self.height);
        let bright = |c: &Vec3| *c * (most / c.max_element().max(most));
        let texels: Vec<Vec3> = self.radiance.iter().map(bright).collect();
        write(queue, &texture, self.width, &texels);
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    }
}

fn luminance(c: Vec3) -> f32 {
    c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// A texture of 16-bit floats for [`write`].
pub(crate) fn sky_texture(
    device: &wgpu::Device,
    label: &str,
    width: u32,
    height: u32,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

fn write(queue: &wgpu::Queue, texture: &wgpu::Texture, width: u32, texels: &[Vec3]) {
    // The largest half float: what is brighter would be infinite.
    let half = |c: &Vec3| c.min(Vec3::splat(65_000.0)).extend(1.0).to_array().map(f16::from_f32);
    let bytes: Vec<[f16; 4]> = texels.iter().map(half).collect();
    queue.write_texture(
        texture.as_image_copy(),
        bytemuck::cast_slice(&bytes),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(8 * width),
            rows_per_image: None,
        },
        texture.size(),
    );
}

/// The light of a sky.
#[derive(Debug, Clone)]
pub(crate) struct SkyLight {
    table: SkyTable,
    /// Irradiance of the sun on a surface that faces it.
    pub sun: Vec3,
    pub ambient: Ambient,
    /// Factor on the picture.
    pub scale: f32,
}

impl SkyLight {
    /// Of the model, or of a picture, which is scaled to the brightness that the model has.
    pub fn new(sky: &Sky, picture: Option<&SkyPicture>) -> Self {
        let atmosphere = Atmosphere { turbidity: sky.turbidity };
        let table = atmosphere.sky(sky.sun_elevation);
        let sun = sky.sun_direction();
        let heading = Vec2::new(sun.x, sun.z).normalize_or(Vec2::Y);
        let half = |direction: Vec3| table.towards(direction, heading);
        let scale = picture.map_or(1.0, |p| {
            let upper = Ambient::project(|d| if d.y > 0.0 { half(d) } else { Vec3::ZERO });
            luminance(upper.irradiance(Vec3::Y)) / p.mean
        });
        let above = |direction: Vec3| match picture {
            None => half(direction),
            Some(p) => p.towards(direction, p.mean * SUN_TEXEL) * scale,
        };
        let upper = Ambient::project(|d| if d.y > 0.0 { above(d) } else { Vec3::ZERO });
        let arriving = upper.irradiance(Vec3::Y)
            + table.sun * (sun.y.max(0.0) * SUNLIT * std::f32::consts::FRAC_1_PI);
        let bounce = SOIL * arriving;
        Self {
            ambient: Ambient::project(|d| if d.y > 0.0 { above(d) } else { bounce }),
            sun: table.sun,
            table,
            scale,
        }
    }

    pub fn write(&self, queue: &wgpu::Queue, texture: &wgpu::Texture) {
        write(queue, texture, SkyTable::SIDE as u32, &self.table.radiance);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn even(color: Vec3) -> SkyPicture {
        SkyPicture::new(64, 32, vec![color; 64 * 32]).unwrap()
    }

    #[test]
    fn pictures_that_are_none_are_refused() {
        let error = |w, h, texels: Vec<Vec3>| SkyPicture::new(w, h, texels).unwrap_err();
        assert!(matches!(error(4, 4, vec![Vec3::ONE; 16]), SkyPictureError::Size { .. }));
        assert!(matches!(error(4, 2, vec![Vec3::ONE; 7]), SkyPictureError::Size { .. }));
        assert!(matches!(error(0, 0, Vec::new()), SkyPictureError::Size { .. }));
        assert_eq!(error(4, 2, vec![Vec3::ZERO; 8]), SkyPictureError::Dark);
        for value in [f32::NAN, f32::INFINITY, -1.0] {
            let mut texels = vec![Vec3::ONE; 8];
            texels[5].y = value;
            assert!(matches!(error(4, 2, texels), SkyPictureError::Value { index: 5, .. }));
        }
    }

    #[test]
    fn a_picture_lights_with_its_colour_and_the_models_brightness() {
        let sky = Sky::default();
        let model = SkyLight::new(&sky, None);
        let blue = SkyLight::new(&sky, Some(&even(Vec3::new(20.0, 40.0, 90.0))));
        let up = blue.ambient.irradiance(Vec3::Y);
        assert!((up.z / up.x - 4.5).abs() < 0.2, "{up}");
        let of_model = luminance(model.ambient.irradiance(Vec3::Y));
        assert!((luminance(up) / of_model - 1.0).abs() < 0.02, "{up} {of_model}");
        assert_eq!(model.sun, blue.sun);
    }

    #[test]
    fn a_sun_in_the_picture_does_not_darken_its_sky() {
        let blue = Vec3::new(20.0, 40.0, 90.0);
        let mut texels = vec![blue; 512 * 256];
        // Two texels of a sun that gives ten times what the sky does.
        texels[64 * 512 + 100] = blue * 3e5;
        texels[64 * 512 + 101] = blue * 3e5;
        let sunny = SkyPicture::new(512, 256, texels).unwrap();
        let up = |p| SkyLight::new(&Sky::default(), Some(p)).ambient.irradiance(Vec3::Y);
        let (with, without) = (up(&sunny), up(&even(blue)));
        assert!((with - without).length() < 0.02 * without.length(), "{with} {without}");
    }

    #[test]
    fn directions_are_where_the_picture_has_them() {
        // Brighter about +X, a quarter right of the middle.
        let texels = (0..64 * 32)
            .map(|i| Vec3::splat(if (44..52).contains(&(i % 64)) { 3.0 } else { 0.5 }))
            .collect();
        let picture = SkyPicture::new(64, 32, texels).unwrap();
        let light = SkyLight::new(&Sky::default(), Some(&picture)).ambient;
        assert!(light.irradiance(Vec3::X).x > 1.2 * light.irradiance(Vec3::NEG_X).x);
    }
}
