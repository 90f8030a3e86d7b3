//! The light of the sky, computed on the GPU: the table of its radiance, the sun's irradiance and
//! the ambient light. A moving sun costs the CPU one small upload.
//!
//! The reference is [`windfall_core::light`], which explains the model and holds its numbers.
//! Drawing the sky, and lighting with it, is left to the passes that read the results.

use crate::base::layouts::Layouts;
use crate::base::shared::SkyUniform;
use crate::base::timing::Timing;
use crate::base::wgsl::{Module, Shaders};
use crate::scene::sky_map::PictureLight;
use crate::view::light::Sky;
use crate::view::sky::{AIR_BYTES, MULTIPLE_COUNT, SIDE, SkyInput, SkyState, TRANSMITTANCE_COUNT};
use glam::Vec3;
use windfall_core::light::Ambient;
use windfall_core::light::atmosphere::{
    EYE, GROUND, LOWEST_SUN, LOWEST_VIEW, MIE_ALBEDO, MIE_FORWARD, MIE_HEIGHT, MULTIPLE_LEAST,
    MULTIPLE_SIZE, MULTIPLE_SQRT_RAYS, MULTIPLE_STEPS, OZONE, OZONE_HEIGHT, OZONE_REACH, RAYLEIGH,
    RAYLEIGH_HEIGHT, SKY_STEPS, SOIL as GROUND_ALBEDO, SOLAR, TOP, TRANSMITTANCE_SIZE,
    TRANSMITTANCE_STEPS,
};

/// What the ground of a wood reflects.
pub const SOIL: Vec3 = Vec3::new(0.17, 0.115, 0.06);
/// Share of the sun that reaches it between the trees.
pub const SUNLIT: f32 = 0.5;

/// Share of each channel in the luminance of a colour (Rec. 709).
pub const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// The sky light's module: it stands by itself.
pub const SKY_LIGHT: Module = Module { name: "sky_light", source: |_| source() };

/// Invocations of a workgroup of the table of transmittance.
const BLOCK: u32 = 64;

// Invocations for the texels of a row also compute the steps of the row's rays.
const _: () = assert!(SKY_STEPS <= SIDE);
// No ring of directions is on the horizon.
const _: () = assert!(Ambient::RINGS.is_multiple_of(2));
// Default limits of WebGPU: invocations and memory of a workgroup.
const _: () = assert!(SIDE <= 256 && MULTIPLE_SQRT_RAYS.pow(2) <= 256);
const _: () = assert!((2 * Ambient::RINGS + 1) * 9 * 16 <= 16_384);

/// The whole shader module: structs and constants from Rust, then the pass's own text.
fn source() -> String {
    let floats = [
        ("EYE", EYE),
        ("GROUND", GROUND),
        ("GROUND_ALBEDO", GROUND_ALBEDO),
        ("LOWEST_SUN", LOWEST_SUN),
        ("LOWEST_VIEW", LOWEST_VIEW),
        ("MIE_ALBEDO", MIE_ALBEDO),
        ("MIE_FORWARD", MIE_FORWARD),
        ("MIE_HEIGHT", MIE_HEIGHT),
        ("MULTIPLE_LEAST", MULTIPLE_LEAST),
        ("OZONE_HEIGHT", OZONE_HEIGHT),
        ("OZONE_REACH", OZONE_REACH),
        ("PI", std::f32::consts::PI),
        ("RAYLEIGH_HEIGHT", RAYLEIGH_HEIGHT),
        ("SOLAR", SOLAR),
        ("SUNLIT", SUNLIT),
        ("TOP", TOP),
    ];
    let counts = [
        ("BLOCK", BLOCK),
        ("MULTIPLE_COLUMNS", MULTIPLE_SIZE[0] as u32),
        ("MULTIPLE_ROWS", MULTIPLE_SIZE[1] as u32),
        ("MULTIPLE_SQRT_RAYS", MULTIPLE_SQRT_RAYS),
        ("MULTIPLE_STEPS", MULTIPLE_STEPS),
        ("RINGS", Ambient::RINGS),
        ("SIDE", SIDE),
        ("SKY_STEPS", SKY_STEPS),
        ("TRANSMITTANCE_COLUMNS", TRANSMITTANCE_SIZE[0] as u32),
        ("TRANSMITTANCE_ROWS", TRANSMITTANCE_SIZE[1] as u32),
        ("TRANSMITTANCE_STEPS", TRANSMITTANCE_STEPS),
    ];
    let colors =
        [("LUMINANCE", LUMINANCE), ("OZONE", OZONE), ("RAYLEIGH", RAYLEIGH), ("SOIL", SOIL)];
    // Ambient light where the lower half has a radiance of 1 and the upper half none.
    let lower = Ambient::project(|d| if d.y > 0.0 { Vec3::ZERO } else { Vec3::ONE });
    let lists = [("FACTORS", Ambient::FACTORS), ("LOWER_HALF", lower.0.map(|c| c.x))];
    let list = |values: [f32; 9]| values.map(|v| format!("{v:?}")).join(", ");
    [
        SkyInput::wgsl(),
        SkyUniform::wgsl(),
        floats.map(|(name, v)| format!("const {name}: f32 = {v:?};\n")).concat(),
        counts.map(|(name, v)| format!("const {name}: u32 = {v}u;\n")).concat(),
        colors
            .map(|(name, c)| {
                format!("const {name} = vec3<f32>({:?}, {:?}, {:?});\n", c.x, c.y, c.z)
            })
            .concat(),
        lists
            .map(|(name, values)| format!("const {name} = array<f32, 9>({});\n", list(values)))
            .concat(),
        include_str!("sky_light.wgsl").to_owned(),
    ]
    .concat()
}

/// Pipelines that compute the light of skies.
pub struct SkyLightPass {
    /// In the order in which they run, each with its number of workgroups.
    steps: [(wgpu::ComputePipeline, u32); 4],
}

impl SkyLightPass {
    pub fn new(shaders: &Shaders<'_>, layouts: &Layouts) -> Self {
        let steps = [
            ("transmittance", TRANSMITTANCE_COUNT.div_ceil(BLOCK)),
            ("multiple", MULTIPLE_COUNT),
            ("radiance", SIDE),
            ("project", 1),
        ];
        let pipeline = |entry| shaders.compute(&SKY_LIGHT, entry, &[&layouts.sky_light], &[]);
        Self { steps: steps.map(|(entry, groups)| (pipeline(entry), groups)) }
    }

    /// Records the computation of a sky's light. A picture replaces the model's radiance, scaled to
    /// the model's brightness; the sun and the table stay the model's.
    ///
    /// The GPU skips tables that are already those of this air and elevation. It compares with what
    /// it last computed, so an encoder that is dropped leaves nothing stale. Of several calls for
    /// one state in a submission the last one's sky counts for all.
    pub fn record(
        &self,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        timing: Timing<'_>,
        state: &SkyState,
        (sky, picture): (&Sky, Option<&PictureLight>),
    ) {
        queue.write_buffer(&state.input, 0, bytemuck::bytes_of(&SkyInput::new(sky, picture)));
        timing.compute_pass(encoder, "sky light", |pass| {
            pass.set_bind_group(0, &state.group, &[]);
            for (pipeline, groups) in &self.steps {
                pass.set_pipeline(pipeline);
                pass.dispatch_workgroups(*groups, 1, 1);
            }
        });
        let air = std::mem::offset_of!(SkyInput, air) as u64;
        encoder.copy_buffer_to_buffer(&state.input, air, &state.made_for, 0, AIR_BYTES);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::wgsl::Settings;
    use glam::Vec2;
    use half::f16;
    use std::f32::consts::{FRAC_1_PI, FRAC_PI_2};
    use windfall_core::light::{Atmosphere, SkyTable};

    /// A picture with colours that differ by direction and reach below the horizon.
    fn picture(d: Vec3) -> Vec3 {
        Vec3::new(20.0 + 9.0 * d.x, 40.0 + 30.0 * d.y * d.z, 90.0 - 40.0 * d.z) * d.y.abs().sqrt()
    }
    const PICTURE_MEAN: f32 = 28.0;

    fn luminance(c: Vec3) -> f32 {
        c.dot(LUMINANCE)
    }

    /// What the CPU's model gives, by definition: the table and the light.
    fn reference(sky: &Sky, with_picture: bool) -> (SkyTable, SkyUniform) {
        let table = Atmosphere { turbidity: sky.turbidity }.sky(sky.sun_elevation);
        let heading = Vec2::from_angle(FRAC_PI_2 - sky.sun_azimuth);
        let model = |d: Vec3| table.towards(d, heading);
        let project = |above: &dyn Fn(Vec3) -> Vec3, below: Vec3| {
            Ambient::project(|d| if d.y > 0.0 { above(d) } else { below })
        };
        let scale = if with_picture {
            luminance(project(&model, Vec3::ZERO).irradiance(Vec3::Y)) / PICTURE_MEAN
        } else {
            1.0
        };
        let above = |d: Vec3| if with_picture { picture(d) * scale } else { model(d) };
        let sun = table.sun * (sky.sun_elevation.sin() * SUNLIT * FRAC_1_PI);
        let arriving = project(&above, Vec3::ZERO).irradiance(Vec3::Y) + sun;
        let ambient = project(&above, SOIL * arriving).0.map(|c| c.extend(0.0));
        let light = SkyUniform { ambient, sun_color: table.sun, sky_scale: scale };
        (table, light)
    }

    struct Gpu {
        device: wgpu::Device,
        queue: wgpu::Queue,
        pass: SkyLightPass,
        state: SkyState,
    }

    impl Gpu {
        fn new() -> Self {
            let (device, queue) = windfall_testing::device();
            let layouts = Layouts::new(&device);
            let shaders = Shaders::new(&device, Settings { samples: 4 });
            let pass = SkyLightPass::new(&shaders, &layouts);
            let state = SkyState::new(&device, &layouts);
            Self { device, queue, pass, state }
        }

        fn record(&self, sky: &Sky, with_picture: bool) -> wgpu::CommandBuffer {
            let upper = |d: Vec3| if d.y > 0.0 { picture(d) } else { Vec3::ZERO };
            let light = PictureLight { ambient: Ambient::project(upper).0, mean: PICTURE_MEAN };
            let picture = with_picture.then_some(&light);
            let mut encoder = self.device.create_command_encoder(&Default::default());
            self.pass.record(&self.queue, &mut encoder, Timing::NONE, &self.state, (sky, picture));
            encoder.finish()
        }

        /// The table and the light.
        fn compute(&self, sky: &Sky, with_picture: bool) -> (Vec<Vec3>, SkyUniform) {
            self.queue.submit([self.record(sky, with_picture)]);
            let light = windfall_testing::read(&self.device, &self.queue, &self.state.light);
            (self.table(), bytemuck::pod_read_unaligned(&light))
        }

        fn table(&self) -> Vec<Vec3> {
            // Rows of 512 bytes are aligned for copies.
            let bytes_per_row = 8 * SIDE;
            let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("texels"),
                size: u64::from(bytes_per_row * SIDE),
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            });
            let mut encoder = self.device.create_command_encoder(&Default::default());
            encoder.copy_texture_to_buffer(
                self.state.table.texture().as_image_copy(),
                wgpu::TexelCopyBufferInfo {
                    buffer: &buffer,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(bytes_per_row),
                        rows_per_image: None,
                    },
                },
                self.state.table.texture().size(),
            );
            self.queue.submit([encoder.finish()]);
            let bytes = windfall_testing::read(&self.device, &self.queue, &buffer);
            let halves = bytes.chunks_exact(2).map(|b| f16::from_le_bytes([b[0], b[1]]).to_f32());
            let halves: Vec<f32> = halves.collect();
            halves.chunks_exact(4).map(|c| Vec3::new(c[0], c[1], c[2])).collect()
        }
    }

    /// Holds what the GPU computed against the CPU.
    ///
    /// The CPU takes heights from squares of radii in f32, up to half a metre off, in haze that
    /// thins by a factor e over 1200 m: its optical depths are off by up to 1e-4, and radiance
    /// follows. (Computed in f64, the sun confirms the shader to 1e-6 of the depth.) The table is
    /// in half floats on top, which drivers may truncate.
    fn assert_agrees(gpu: &Gpu, sky: &Sky, with_picture: bool) {
        const DEPTH: f32 = 2e-4;
        const LIGHT: f32 = 3e-4;
        const TEXEL: f32 = 1.0 / 1024.0 + 4e-4;
        let (table, light) = gpu.compute(sky, with_picture);
        let (expected_table, expected) = reference(sky, with_picture);
        let of = format!("{sky:?}, picture: {with_picture}");
        // Optical depths, since a low sun is so dim that only these are well conditioned.
        let depth = |sun: Vec3| -(sun / SOLAR).map(f32::ln);
        let (sun, expected_sun) = (depth(light.sun_color), depth(expected.sun_color));
        assert!(
            ((sun - expected_sun) / expected_sun).abs().max_element() < DEPTH,
            "{of}: {sun} {expected_sun}"
        );
        let scale = light.sky_scale / expected.sky_scale;
        assert!((scale - 1.0).abs() < LIGHT, "{of}: scale {scale}");
        let even = expected.ambient[0].max_element();
        for (i, (got, expected)) in light.ambient.iter().zip(expected.ambient).enumerate() {
            let off = (got - expected).abs().max_element() / even;
            assert!(off < LIGHT, "{of}: coefficient {i}: {got} {expected}");
        }
        assert_eq!(table.len(), expected_table.radiance.len());
        for (i, (&got, &expected)) in table.iter().zip(&expected_table.radiance).enumerate() {
            let off = ((got - expected) / expected).abs().max_element();
            assert!(off < TEXEL, "{of}: texel {i}: {got} {expected}");
        }
    }

    #[test]
    fn the_light_of_the_sky_agrees_with_the_cpu() {
        let gpu = Gpu::new();
        for turbidity in [1.0, 2.2, 6.0] {
            for sun_elevation in [0.0, 0.02, 0.1, 0.55, 1.0, FRAC_PI_2] {
                let sky = Sky { sun_azimuth: 0.7, sun_elevation, turbidity, ..Sky::default() };
                // The second and third of each leave the tables as they are.
                assert_agrees(&gpu, &sky, false);
                assert_agrees(&gpu, &sky, true);
                assert_agrees(&gpu, &Sky { sun_azimuth: -2.0, ..sky }, false);
            }
        }
    }

    #[test]
    fn a_dropped_encoder_leaves_nothing_stale() {
        let gpu = Gpu::new();
        let noon = Sky { sun_azimuth: 0.0, sun_elevation: 1.0, turbidity: 2.0, ..Sky::default() };
        let evening =
            Sky { sun_azimuth: 1.5, sun_elevation: 0.1, turbidity: 4.0, ..Sky::default() };
        drop(gpu.record(&noon, false));
        assert_agrees(&gpu, &noon, false);
        drop(gpu.record(&evening, false));
        assert_agrees(&gpu, &evening, false);
        drop(gpu.record(&noon, true));
        assert_agrees(&gpu, &evening, false);
    }

    #[test]
    fn odd_skies_are_those_at_the_limits() {
        let gpu = Gpu::new();
        let least = Sky { sun_azimuth: 0.0, sun_elevation: 0.0, turbidity: 1.0, ..Sky::default() };
        let noon = Sky { sun_azimuth: 0.0, sun_elevation: 1.0, turbidity: 2.0, ..Sky::default() };
        let light = |sky: &Sky| {
            // Nothing is left of the sky before.
            gpu.compute(&noon, false);
            gpu.compute(sky, false)
        };
        let expected = light(&least);
        for odd in [f32::NAN, f32::NEG_INFINITY, -1.0] {
            assert_eq!(light(&Sky { sun_elevation: odd, ..least }), expected, "{odd}");
            assert_eq!(light(&Sky { turbidity: odd, ..least }), expected, "{odd}");
        }
        for odd in [f32::NAN, f32::INFINITY] {
            assert_eq!(light(&Sky { sun_azimuth: odd, ..least }), expected, "{odd}");
            assert_eq!(light(&Sky { sun_elevation: odd, ..least }), expected, "{odd}");
        }
        let hazy = Sky { turbidity: 10.0, ..least };
        assert_eq!(light(&Sky { turbidity: f32::INFINITY, ..least }), light(&hazy));
    }
}
