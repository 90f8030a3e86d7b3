//! What the host says of a frame: camera, time, sky.

use crate::pass::sky::SkyLight;
use crate::quality::Quality;
use crate::shared::Frame;
use crate::strategy::UnknownName;
use glam::{Mat4, Vec2, Vec3, Vec4};
use windfall_core::simplify::{Reduction, Simplification};

/// A pinhole camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Where it stands, metres.
    pub eye: Vec3,
    /// What it looks at; must differ from `eye`.
    pub target: Vec3,
    /// Vertical field of view, radians, above 0 and below π.
    pub fov_y: f32,
    /// Nearest distance that is drawn, metres, above 0. There is no farthest.
    pub near: f32,
}

impl Camera {
    /// Clip space of this camera for a picture of `aspect` = width / height: right-handed, depth 1
    /// at `near` falling to 0 at infinity.
    pub fn clip_from_world(&self, aspect: f32) -> Mat4 {
        let forward = (self.target - self.eye).normalize_or(Vec3::NEG_Z);
        // Straight up or down, "up" is no guide: take north.
        let up = if forward.y.abs() > 0.999 { Vec3::NEG_Z } else { Vec3::Y };
        Mat4::perspective_infinite_reverse_rh(self.fov_y, aspect, self.near)
            * Mat4::look_to_rh(self.eye, forward, up)
    }

    /// Pixels that a metre covers at a distance of one metre, in a picture of `height` rows.
    pub fn pixels(&self, height: u32) -> f32 {
        height as f32 / (2.0 * (self.fov_y * 0.5).tan())
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

/// A trodden path on the ground, straight between two places.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Trail {
    /// One end: x and z, metres.
    pub from: Vec2,
    /// The other end.
    pub to: Vec2,
    /// Half of its width, metres; 0, the default, is no path.
    pub radius: f32,
}

/// Everything that changes from frame to frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// Light and air.
    pub sky: Sky,
    /// Seconds since the scene began; any order of moments gives the same pictures.
    pub time: f32,
    /// Phase of autumn, 0 late summer to 1 bare.
    pub season: f32,
    /// What grows on the ground: 0 bare of grass, 0.5 litter and grass in patches, 1 a meadow.
    pub meadow: f32,
    /// Paths that feet have kept bare.
    pub trails: [Trail; 4],
    /// Whether the sun casts shadows.
    pub shadows: bool,
    /// What colours mean.
    pub show: Show,
    /// How trees are simplified.
    pub detail: Simplification,
    /// How those are simplified that cast shadows; distances are from the camera.
    pub shadow_detail: Simplification,
    /// Which trees are left out.
    pub culling: Culling,
    /// What the picture may cost.
    pub quality: Quality,
}

/// Which trees are left out of the picture. None of them is ever seen in it: the picture is the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Culling {
    /// None.
    Off = 0,
    /// Those whose bounding box is outside of clip space: for comparison (SFS, 4.2).
    ClipSpace = 1,
    /// Those whose bounding sphere is outside of the view (SFS, 4.2).
    #[default]
    Sphere = 2,
    /// Those too that hide behind others and the ground, by a pyramid of the depth of the frame
    /// before, and a second pass for those that it hid and that of this frame does not. The
    /// strategies without compute leave out no more than `Sphere`.
    Occlusion = 3,
}

impl Culling {
    /// Each of them.
    pub const ALL: [Self; 4] = [Self::Off, Self::ClipSpace, Self::Sphere, Self::Occlusion];

    /// Its name on command lines and in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::ClipSpace => "clip-space",
            Self::Sphere => "sphere",
            Self::Occlusion => "occlusion",
        }
    }
}

impl std::fmt::Display for Culling {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

impl std::str::FromStr for Culling {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        Self::ALL
            .into_iter()
            .find(|c| c.name() == name)
            .ok_or_else(|| UnknownName::new("culling", name, &Self::ALL.map(Self::name)))
    }
}

/// What colours mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Show {
    /// The picture.
    #[default]
    Picture = 0,
    /// Leaves in the air by the lap of their path, those that lie in pink (VB Figure 5).
    Laps = 1,
    /// How far trees are simplified: red in full, through yellow and green to blue at λ = 1/256.
    Detail = 2,
    /// Leaves alone, on black.
    Leaves = 3,
    /// What leaves cover: white on black, neither lit nor tone mapped.
    Coverage = 4,
    /// What leaf occlusion does with leaves in the air: those that are drawn in green, those that are
    /// tested in blue, those that are skipped in red, before everything. The picture for a forest without
    /// [`crate::Falls::leaf_occlusion`].
    Occlusion = 5,
    /// The radiance of leaves alone, on black, times the exposure: linear up to 1, not tone mapped.
    Radiance = 6,
}

impl Show {
    /// Each of them.
    pub const ALL: [Self; 7] = [
        Self::Picture,
        Self::Laps,
        Self::Detail,
        Self::Leaves,
        Self::Coverage,
        Self::Occlusion,
        Self::Radiance,
    ];

    /// Its name on command lines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Picture => "picture",
            Self::Laps => "laps",
            Self::Detail => "detail",
            Self::Leaves => "leaves",
            Self::Coverage => "coverage",
            Self::Occlusion => "occlusion",
            Self::Radiance => "radiance",
        }
    }

    /// Whether nothing but leaves is drawn.
    pub(crate) fn leaves_alone(self) -> bool {
        matches!(self, Self::Leaves | Self::Coverage | Self::Radiance)
    }
}

impl std::fmt::Display for Show {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

impl std::str::FromStr for Show {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        Self::ALL
            .into_iter()
            .find(|s| s.name() == name)
            .ok_or_else(|| UnknownName::new("view", name, &Self::ALL.map(Self::name)))
    }
}

impl View {
    /// A camera's view at time 0 in mid-autumn, under the default sky, with shadows, simplified
    /// as is the default.
    pub fn new(camera: Camera) -> Self {
        Self {
            camera,
            sky: Sky::default(),
            time: 0.0,
            season: 0.5,
            meadow: 0.4,
            trails: [Trail::default(); 4],
            shadows: true,
            show: Show::Picture,
            detail: Simplification::default(),
            shadow_detail: Self::SHADOW_DETAIL,
            culling: Culling::default(),
            quality: Quality::default(),
        }
    }

    /// The default of `shadow_detail`: shadows are softer than what casts them.
    pub const SHADOW_DETAIL: Simplification =
        Simplification { reduction: Reduction::Distance { d0: 15.0 }, ..Simplification::DEFAULT };

    /// The frame's uniforms, but for what the forest and the shadow maps add.
    pub(crate) fn frame(&self, width: u32, height: u32, light: &SkyLight, picture: bool) -> Frame {
        let clip_from_world = self.camera.clip_from_world(width as f32 / height as f32);
        Frame {
            unread: Vec4::ZERO,
            clip_from_world,
            world_from_clip: clip_from_world.inverse(),
            shadow_from_world: [Mat4::IDENTITY; 3],
            shadow_ends: Vec4::ZERO,
            shadow_texels: Vec4::ONE,
            eye: self.camera.eye,
            time: self.time,
            sun_direction: self.sky.sun_direction(),
            season: self.season,
            sun_color: light.sun,
            haze: self.sky.haze,
            ambient: light.ambient.0.map(|c| c.extend(0.0)),
            gusts: [Vec4::ZERO; 4],
            wind_mean: Vec2::ZERO,
            wind_travel: Vec2::ZERO,
            backdrop: Vec4::ZERO,
            trails: self.trails.map(|t| t.from.extend(t.to.x).extend(t.to.y)),
            trail_widths: Vec4::from(self.trails.map(|t| t.radius.max(0.0))),
            litter: Vec3::ZERO,
            exposure: self.sky.exposure.exp2(),
            width: width as f32,
            height: height as f32,
            wind_slowness: 0.0,
            sway: f32::from(u8::from(self.quality.sway)),
            effects: self.quality.effects(picture),
            shadow_taps: self.quality.shadow_taps.clamp(1, 16),
            sky_scale: light.scale,
            clouds: self.sky.clouds,
            grassy: 0.7 * (self.meadow - 0.5),
            show: self.show as u32,
            fade_smooth: u32::from(self.detail.fade.smooth),
            contrasts: u32::from(self.detail.color_contrast)
                | u32::from(self.detail.shading_contrast) << 1,
        }
    }
}
