//! The host's picture of the whole sky.

use glam::Vec3;
use half::f16;
use windfall_core::light::Ambient;

/// Radiance of a picture's texel over the mean above which it is taken as the sun, which shines by
/// itself.
const SUN_TEXEL: f32 = 20.0;

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

    fn upload(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> wgpu::TextureView {
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
pub fn sky_texture(device: &wgpu::Device, label: &str, width: u32, height: u32) -> wgpu::Texture {
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

/// A [`SkyPicture`] on the GPU, to be given to views. Cheap to clone.
#[derive(Debug, Clone)]
pub struct SkyMap {
    pub(crate) view: wgpu::TextureView,
    pub(crate) light: PictureLight,
}

impl PartialEq for SkyMap {
    /// Whether they are one picture, not whether they look alike.
    fn eq(&self, other: &Self) -> bool {
        self.view == other.view
    }
}

/// What the sky's light needs of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PictureLight {
    /// Harmonics of its upper half without the sun, as it is: [`Ambient`].
    pub ambient: [Vec3; 9],
    /// Mean luminance of the upper half without the sun.
    pub mean: f32,
}

impl SkyMap {
    /// Uploads a picture. It is drawn, and lights, at the brightness that the model's sky has at the same height
    /// of the sun. The sun itself stays the view's: point it to where the picture has its own.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, picture: &SkyPicture) -> Self {
        Self { view: picture.upload(device, queue), light: picture.light() }
    }
}

impl SkyPicture {
    fn light(&self) -> PictureLight {
        let upper = |d: Vec3| {
            if d.y > 0.0 { self.towards(d, self.mean * SUN_TEXEL) } else { Vec3::ZERO }
        };
        PictureLight { ambient: Ambient::project(upper).0, mean: self.mean }
    }
}
