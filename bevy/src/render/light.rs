//! Light of Bevy's scene, as Windfall takes it.

use crate::camera::WindfallAmbient;
use bevy::camera::visibility::RenderLayers;
use bevy::light::{AmbientLight, GlobalAmbientLight};
use bevy::math::Vec3;
use bevy::pbr::{
    DistanceFog, ExtractedDirectionalLight, FogFalloff, LightEntity, ViewLightEntities,
    ViewShadowBindings,
};
use bevy::prelude::*;
use bevy::render::render_resource::{TextureViewDescriptor, TextureViewDimension};
use bevy::render::view::ExtractedView;
use windfall::glam::{DMat4, DVec3};
use windfall::light::Ambient;
use windfall::{HostCascade, HostLight, HostShadow};

/// Cascades of a shadow map that leaves receive shadows from.
const MOST_CASCADES: usize = 3;

/// A directional light in the render world.
pub(crate) type Sun<'a> = (Entity, &'a ExtractedDirectionalLight, &'a RenderLayers);

/// The sun of a camera: of its directional lights the brightest, those with shadows first.
pub(crate) fn sun_of<'a>(
    lights: impl Iterator<Item = Sun<'a>>,
    layers: &RenderLayers,
) -> Option<(Entity, &'a ExtractedDirectionalLight)> {
    let brightness = |light: &ExtractedDirectionalLight| irradiance(light).max_element();
    lights
        .filter(|(_, _, of_light)| of_light.intersects(layers))
        .map(|(entity, light, _)| (entity, light))
        .max_by(|(a, left), (b, right)| {
            let shadows = left.shadow_maps_enabled.cmp(&right.shadow_maps_enabled);
            shadows.then(brightness(left).total_cmp(&brightness(right))).then(a.cmp(b))
        })
}

fn irradiance(light: &ExtractedDirectionalLight) -> Vec3 {
    light.color.to_vec3() * light.illuminance
}

/// What lights a camera's picture beside its sun.
pub(crate) struct Surroundings<'a> {
    /// [`ExtractedCamera::exposure`](bevy::render::camera::ExtractedCamera).
    pub exposure: f32,
    pub global: &'a GlobalAmbientLight,
    pub own: Option<&'a AmbientLight>,
    pub harmonics: Option<&'a WindfallAmbient>,
    pub fog: Option<&'a DistanceFog>,
}

/// The light of a camera's picture, in the unit of its target. Shadows are of a world without an offset.
pub(crate) fn host_light(
    sun: Option<&ExtractedDirectionalLight>,
    surroundings: &Surroundings<'_>,
    shadow: Option<HostShadow>,
) -> HostLight {
    let Surroundings { exposure, global, own, harmonics, fog } = *surroundings;
    let mut ambient = Ambient(harmonics.map_or([Vec3::ZERO; 9], |of| of.0.0));
    let (color, brightness) =
        own.map_or((global.color, global.brightness), |own| (own.color, own.brightness));
    ambient.0[0] += color.to_linear().to_vec3() * brightness;
    ambient.0.iter_mut().for_each(|of| *of *= exposure);
    HostLight {
        sun_direction: sun.map_or(Vec3::Y, |sun| sun.transform.back().as_vec3()),
        sun: sun.map_or(Vec3::ZERO, |sun| irradiance(sun) * exposure),
        ambient,
        shadow,
        haze: match fog.map(|fog| &fog.falloff) {
            Some(FogFalloff::Exponential { density }) => *density,
            _ => 0.0,
        },
    }
}

/// The shadow map of the camera's sun: the first cascades of Bevy's.
pub(crate) fn shadow_of<'a>(
    sun: (Entity, &ExtractedDirectionalLight),
    lights: &ViewLightEntities,
    maps: &ViewShadowBindings,
    view_of: impl Fn(Entity) -> Option<(&'a LightEntity, &'a ExtractedView)>,
) -> Option<HostShadow> {
    let (entity, light) = sun;
    let is_of_sun = |of: &Entity| {
        view_of(*of).is_some_and(|(of, _)| {
            matches!(of, LightEntity::Directional { light_entity, .. } if *light_entity == entity)
        })
    };
    // A light's cascades are layers of one texture, in the order of the camera's list.
    let first = lights.lights.iter().position(is_of_sun)?;
    let cascades: Vec<HostCascade> = lights.lights[first..]
        .iter()
        .take_while(|of| is_of_sun(of))
        .take(MOST_CASCADES)
        .zip(&light.cascade_shadow_config.bounds)
        .filter_map(|(of, &end)| {
            let (_, view) = view_of(*of)?;
            let clip_from_world = clip_from_world(view);
            // Orthographic: a row's length is what a metre takes of the half width.
            let half_width = 1.0 / clip_from_world.row(0).truncate().length();
            let texel = (2.0 * half_width / f64::from(view.viewport.z.max(1))) as f32;
            Some(HostCascade { clip_from_world, end, texel })
        })
        .collect();
    let view = if first == 0 {
        wgpu_view(&maps.directional_light_depth_texture_view)
    } else {
        wgpu_view(&maps.directional_light_depth_texture.create_view(&TextureViewDescriptor {
            dimension: Some(TextureViewDimension::D2Array),
            base_array_layer: first as u32,
            ..Default::default()
        }))
    };
    (!cascades.is_empty()).then_some(HostShadow { view, cascades, reversed: true })
}

fn wgpu_view(view: &bevy::render::render_resource::TextureView) -> windfall::wgpu::TextureView {
    windfall::wgpu::TextureView::clone(view)
}

fn clip_from_world(view: &ExtractedView) -> DMat4 {
    let clip = view
        .clip_from_world
        .unwrap_or_else(|| view.clip_from_view * view.world_from_view.to_matrix().inverse());
    clip.as_dmat4()
}

/// The same shadow map about a forest's origin.
pub(crate) fn about(mut light: HostLight, origin: DVec3) -> HostLight {
    if let Some(shadow) = &mut light.shadow {
        for cascade in &mut shadow.cascades {
            cascade.clip_from_world *= DMat4::from_translation(origin);
        }
    }
    light
}
