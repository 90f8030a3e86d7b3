//! What the host says of a view.

use crate::base::constants::{DebugView, Effect};
use crate::base::shared::Frame;
use crate::view::camera::{Camera, Eye};
use crate::view::culling::Culling;
use crate::view::light::Light;
use crate::view::quality::Quality;
use glam::{DVec3, Vec2, Vec4};
use windfall_core::simplify::{Reduction, Simplification};

/// A trodden path on the ground, straight between two places.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Trail {
    /// One end: x and z, metres from the forest's origin.
    pub from: Vec2,
    /// The other end.
    pub to: Vec2,
    /// Half of its width, metres; 0, the default, is no path.
    pub radius: f32,
}

/// One view of a forest: everything that may change from frame to frame, and that is of the view alone.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// Light and air.
    pub light: Light,
    /// What grows on the ground: 0 bare of grass, 0.5 litter and grass in patches, 1 a meadow.
    pub meadow: f32,
    /// Paths that feet have kept bare.
    pub trails: [Trail; 4],
    /// Whether a whole picture ([`crate::Renderer::render`]) is clear where the sky would be: straight alpha, what is
    /// drawn there free of the sky's colour.
    pub transparent_sky: bool,
    /// Whether the sun casts shadows: those of [`crate::Layers::shadows`], or the host's.
    pub shadows: bool,
    /// What colours mean.
    pub show: DebugView,
    /// How trees are simplified.
    pub detail: Simplification,
    /// How those are simplified that cast shadows; distances are from the camera.
    pub shadow_detail: Simplification,
    /// Frames in which each of Windfall's own shadow maps is drawn at least once, the nearest four times as often as the
    /// farthest; 1, the default, draws all of them in each frame, which then depends on nothing before. In between
    /// shadows lag behind the wind and behind leaves that fall, by so many frames: 4 to 16 are for real time.
    pub shadow_period: u32,
    /// Which trees are left out.
    pub culling: Culling,
    /// What the picture may cost.
    pub quality: Quality,
}

impl View {
    /// A camera's view under the default sky, with shadows, simplified as is the default.
    pub fn new(camera: Camera) -> Self {
        Self {
            camera,
            light: Light::default(),
            meadow: 0.4,
            trails: [Trail::default(); 4],
            transparent_sky: false,
            shadows: true,
            show: DebugView::Final,
            detail: Simplification::default(),
            shadow_detail: Self::SHADOW_DETAIL,
            shadow_period: 1,
            culling: Culling::default(),
            quality: Quality::default(),
        }
    }

    /// The default of `shadow_detail`: shadows are softer than what casts them.
    pub const SHADOW_DETAIL: Simplification =
        Simplification { reduction: Reduction::Distance { d0: 15.0 }, ..Simplification::DEFAULT };

    /// Fills in what the view has of the frame's uniforms.
    pub(crate) fn describe(&self, frame: &mut Frame, eye: &Eye, origin: DVec3) {
        frame.clip_from_world = eye.clip_from_world;
        frame.world_from_clip = eye.clip_from_world.inverse();
        frame.shadow_texels = Vec4::ONE;
        frame.eye = eye.position;
        frame.depth_from_w = eye.depth_from_w;
        frame.orthographic = u32::from(eye.orthographic);
        frame.trails = self.trails.map(|t| t.from.extend(t.to.x).extend(t.to.y));
        frame.trail_widths = Vec4::from(self.trails.map(|t| t.radius.max(0.0)));
        frame.width = eye.width as f32;
        frame.height = eye.height as f32;
        frame.effects = self.quality.effects() | Effect::TransparentSky.bit(self.transparent_sky);
        frame.shadow_taps = self.quality.shadow_taps.clamp(1, 16);
        frame.resolution = self.quality.drawn_resolution();
        frame.pixels = eye.pixels;
        frame.leaf_pixels = self.detail.leaf_pixels;
        frame.lit_leaf_pixels =
            self.detail.lit_leaf_pixels(self.quality.pixel_lighting).min(f32::MAX);
        frame.grassy = 0.7 * (self.meadow - 0.5);
        frame.show = self.show as u32;
        frame.fade_smooth = u32::from(self.detail.fade.smooth);
        frame.contrasts =
            u32::from(self.detail.color_contrast) | u32::from(self.detail.shading_contrast) << 1;
        match &self.light {
            Light::Sky(sky, map) => {
                frame.sun_direction = sky.sun_direction();
                frame.haze = sky.haze;
                frame.clouds = sky.clouds;
                frame.exposure = sky.exposure.exp2();
                frame.effects |= Effect::SkyPicture.bit(map.is_some());
            }
            Light::Host(light) => light.describe(frame, self.shadows, origin),
        }
        if eye.orthographic {
            // The eye is far behind the view.
            frame.haze = 0.0;
        }
    }
}
