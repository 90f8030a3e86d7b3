//! What a view keeps of its sky's light on the GPU.

use crate::base::layouts::{self, Layouts};
use crate::base::shared::SkyUniform;
use crate::gpu_struct;
use crate::scene::sky_map::PictureLight;
use crate::view::light::Sky;
use glam::{Vec2, Vec4};
use windfall_core::light::atmosphere::{MULTIPLE_SIZE, TRANSMITTANCE_SIZE};
use windfall_core::light::{Atmosphere, SkyTable};

/// Texels of the table of transmittance.
pub const TRANSMITTANCE_COUNT: u32 = (TRANSMITTANCE_SIZE[0] * TRANSMITTANCE_SIZE[1]) as u32;
/// Texels of the table of multiple scattering.
pub const MULTIPLE_COUNT: u32 = (MULTIPLE_SIZE[0] * MULTIPLE_SIZE[1]) as u32;
/// Texels along a side of the table of radiance.
pub const SIDE: u32 = SkyTable::SIDE as u32;
/// Bytes of [`SkyInput::air`].
pub const AIR_BYTES: u64 = size_of::<Vec4>() as u64;
/// The three tables: in WGSL an element of `array<vec3<f32>>` is 16 bytes.
const TABLE_BYTES: u64 = 16 * (TRANSMITTANCE_COUNT + MULTIPLE_COUNT + SIDE * SIDE) as u64;

gpu_struct! {
    /// Uniforms of the pass.
    pub struct SkyInput {
        /// [`PictureLight::ambient`]; zero without a picture.
        pub picture: [Vec4; 9],
        /// Extinction by haze at sea level, 1/km; sine and cosine of the sun's elevation; 1.
        pub air: Vec4,
        /// Unit vector along X and Z towards the sun.
        pub heading: Vec2,
        /// [`PictureLight::mean`]; 0 without a picture.
        pub picture_mean: f32,
        /// Unused.
        pub padding: f32,
    }
}

impl SkyInput {
    pub fn new(sky: &Sky, picture: Option<&PictureLight>) -> Self {
        let finite = |angle: f32| if angle.is_finite() { angle } else { 0.0 };
        let (sin_azimuth, cos_azimuth) = finite(sky.sun_azimuth).sin_cos();
        let elevation = finite(sky.sun_elevation);
        let (sin, cos) = elevation.max(0.0).sin_cos();
        let heading = Vec2::new(sin_azimuth, cos_azimuth) * elevation.cos();
        let haze = Atmosphere { turbidity: sky.turbidity }.haze();
        Self {
            picture: picture.map_or([Vec4::ZERO; 9], |p| p.ambient.map(|c| c.extend(0.0))),
            air: Vec4::new(haze, sin, cos, 1.0),
            heading: heading.normalize_or(Vec2::Y),
            picture_mean: picture.map_or(0.0, |p| p.mean),
            padding: 0.0,
        }
    }
}

/// The light of one sky: all zero until the first `SkyLightPass::record`.
pub struct SkyState {
    pub input: wgpu::Buffer,
    /// [`SkyTable`] in half floats.
    pub table: wgpu::TextureView,
    /// [`SkyInput::air`] that the tables were computed from.
    pub made_for: wgpu::Buffer,
    pub group: wgpu::BindGroup,
    /// A [`SkyUniform`]; can be copied from.
    pub light: wgpu::Buffer,
}

impl SkyState {
    pub fn new(device: &wgpu::Device, layouts: &Layouts) -> Self {
        let buffer = |label, size, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let input = buffer(
            "sky input",
            size_of::<SkyInput>() as u64,
            wgpu::BufferUsages::UNIFORM
                | wgpu::BufferUsages::COPY_DST
                | wgpu::BufferUsages::COPY_SRC,
        );
        let made_for = buffer(
            "sky tables' air",
            AIR_BYTES,
            wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
        );
        let tables = buffer("sky tables", TABLE_BYTES, wgpu::BufferUsages::STORAGE);
        let light = buffer(
            "sky light",
            size_of::<SkyUniform>() as u64,
            wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        );
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("sky table"),
            size: wgpu::Extent3d { width: SIDE, height: SIDE, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba16Float,
            usage: wgpu::TextureUsages::STORAGE_BINDING
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let table = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let group = layouts::group(
            device,
            "sky light",
            &layouts.sky_light,
            &[
                input.as_entire_binding(),
                made_for.as_entire_binding(),
                tables.as_entire_binding(),
                wgpu::BindingResource::TextureView(&table),
                light.as_entire_binding(),
            ],
        );
        Self { input, table, made_for, group, light }
    }
}
