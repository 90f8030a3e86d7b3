//! What a camera may say about forests.

use bevy::prelude::*;
use bevy::render::extract_component::ExtractComponent;
use windfall::light::Ambient;
use windfall::simplify::Simplification;
use windfall::{Culling, Quality, View};

/// How a camera sees forests: how trees are simplified with distance, and which effects they have. A camera without it
/// sees them by the defaults.
#[derive(Component, ExtractComponent, Debug, Clone, Copy, PartialEq)]
pub struct LeafDetail {
    /// How trees are simplified; `h = 0.5` and `d0` of some metres are usual.
    pub detail: Simplification,
    /// How those are simplified that cast shadows.
    pub shadow_detail: Simplification,
    /// Effects of leaves and wood; what it says of shadow maps, ground and sky is Bevy's here.
    pub quality: Quality,
    /// Whether trees out of view are left out.
    pub culling: Culling,
}

impl Default for LeafDetail {
    fn default() -> Self {
        Self {
            detail: Simplification::default(),
            shadow_detail: View::SHADOW_DETAIL,
            quality: Quality::MEDIUM,
            culling: Culling::Sphere,
        }
    }
}

/// Ambient light of a camera's leaves by direction, added to Bevy's even ambient light: irradiance over π in cd/m², as
/// [`AmbientLight`]'s brightness. It stands for environment maps, which are not read.
///
/// ```
/// # use bevy::math::Vec3;
/// # use bevy_windfall::WindfallAmbient;
/// # use bevy_windfall::windfall::light::Ambient;
/// // Blue from above, brown from below.
/// let sky = WindfallAmbient(Ambient::project(|towards| {
///     Vec3::new(0.25, 0.2, 0.15).lerp(Vec3::new(0.6, 0.8, 1.0), 0.5 + 0.5 * towards.y) * 3000.0
/// }));
/// ```
#[derive(Component, ExtractComponent, Debug, Clone, Copy, PartialEq)]
pub struct WindfallAmbient(pub Ambient);
