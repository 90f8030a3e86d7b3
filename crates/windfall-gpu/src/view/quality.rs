//! What a picture may cost.

use crate::base::constants::Effect;
use crate::base::names::UnknownName;

/// Effects, each by itself; three presets.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::struct_excessive_bools, reason = "effects that are on or off, each by itself")]
pub struct Quality {
    /// Texels along a side of a shadow map, 256 to 2048.
    pub shadow_size: u32,
    /// Samples of a shadow map at a pixel of the ground, 1 to 16; trees take fewer.
    pub shadow_taps: u32,
    /// Whether shadows soften with the distance of what casts them.
    pub soft_shadows: bool,
    /// Whether trees move in the wind.
    pub sway: bool,
    /// Whether large leaves on twigs are lit in each pixel. If not, they are lit at their vertices, as
    /// less large ones always are, and have midribs, but neither veins nor blotches. Leaves with
    /// pictures are lit in pixels always.
    pub pixel_lighting: bool,
    /// Whether near leaves that are lit in pixels have veins and blotches.
    pub veins: bool,
    /// Whether leaves are glossy.
    pub gloss: bool,
    /// Whether light from behind shines through leaves.
    pub transmission: bool,
    /// Whether leaves deep in a crown are darker: each knows how open to the sky it is.
    pub ambient_occlusion: bool,
    /// Whether single dead leaves show on the near ground.
    pub ground_detail: bool,
    /// Whether bark has relief.
    pub bark_relief: bool,
    /// Whether grass grows about the camera.
    pub grass: bool,
    /// Whether woods and hills stand beyond the terrain.
    pub backdrop: bool,
    /// Whether pixels are filtered from samples of their neighbours too: softer edges that crawl less.
    pub resolve_filter: bool,
    /// Of a whole picture, the part of its width and height in which its pixels are shaded, 0.25 to 1. Each has four
    /// samples, which are spread over the pixels of the picture: at 0.5 edges are as many and light is four times
    /// cheaper. Below 1 nothing is culled by occlusion, and no filter of samples is used.
    pub resolution: f32,
}

impl Quality {
    /// For software adapters and old laptops.
    pub const LOW: Self = Self {
        shadow_size: 1024,
        shadow_taps: 4,
        soft_shadows: false,
        sway: true,
        pixel_lighting: false,
        veins: false,
        gloss: false,
        transmission: true,
        ambient_occlusion: true,
        ground_detail: false,
        bark_relief: false,
        grass: false,
        backdrop: true,
        resolve_filter: false,
        resolution: 0.5,
    };
    /// The lowest preset in full resolution: for measurements of something else.
    pub const PLAIN: Self = Self { resolution: 1.0, ..Self::LOW };
    /// Between the two.
    pub const MEDIUM: Self = Self {
        shadow_size: 2048,
        shadow_taps: 8,
        pixel_lighting: true,
        veins: true,
        gloss: true,
        ground_detail: true,
        resolve_filter: true,
        ..Self::PLAIN
    };
    /// Everything; the default.
    pub const HIGH: Self = Self {
        shadow_taps: 12,
        soft_shadows: true,
        bark_relief: true,
        grass: true,
        ..Self::MEDIUM
    };
    /// The presets, cheapest first, with their names on command lines and in scenes.
    pub const PRESETS: [(&'static str, Self); 3] =
        [("low", Self::LOW), ("medium", Self::MEDIUM), ("high", Self::HIGH)];

    /// `resolution` within its bounds.
    pub(crate) fn drawn_resolution(&self) -> f32 {
        if self.resolution < 1.0 { self.resolution.max(0.25) } else { 1.0 }
    }

    /// Bits for the shaders.
    pub(crate) fn effects(&self) -> u32 {
        use Effect::{
            AmbientOcclusion, Backdrop, BarkRelief, Gloss, ResolveFilter, SoftShadows,
            Transmission, Veins,
        };
        [
            (SoftShadows, self.soft_shadows),
            (Veins, self.veins),
            (BarkRelief, self.bark_relief),
            (Backdrop, self.backdrop),
            (Gloss, self.gloss),
            (Transmission, self.transmission),
            (AmbientOcclusion, self.ambient_occlusion),
            (ResolveFilter, self.resolve_filter),
        ]
        .iter()
        .map(|&(effect, on)| effect.bit(on))
        .sum()
    }
}

impl Default for Quality {
    fn default() -> Self {
        Self::HIGH
    }
}

impl std::str::FromStr for Quality {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        Self::PRESETS
            .iter()
            .find(|(preset, _)| *preset == name)
            .map(|(_, quality)| *quality)
            .ok_or_else(|| UnknownName::new("quality", name, &Self::PRESETS.map(|p| p.0)))
    }
}
