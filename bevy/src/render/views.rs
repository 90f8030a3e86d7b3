//! A frame: the forests' moment, what each camera needs, shadows into Bevy's cascades, leaves into Bevy's targets.

use crate::WindfallStatus;
use crate::camera::{LeafDetail, WindfallAmbient};
use crate::render::forests::{RenderForest, RenderForests, SeenBy};
use crate::render::light::{Surroundings, about, host_light, shadow_of, sun_of};
use crate::render::models::Models;
use crate::render::renderers::{Kind, Renderers};
use bevy::camera::MainPassResolutionOverride;
use bevy::camera::visibility::RenderLayers;
use bevy::light::{AmbientLight, GlobalAmbientLight};
use bevy::pbr::{
    DistanceFog, ExtractedDirectionalLight, LightEntity, ShadowView, ViewLightEntities,
    ViewShadowBindings,
};
use bevy::prelude::*;
use bevy::render::camera::{ExtractedCamera, TemporalJitter};
use bevy::render::render_resource::{RenderPassDescriptor, StoreOp};
use bevy::render::renderer::{RenderContext, RenderDevice, RenderQueue, ViewQuery};
use bevy::render::view::{ExtractedView, RetainedViewEntity, ViewDepthTexture, ViewTarget};
use windfall::{
    Camera, HostLight, Light, Moment, Projection, Recording, Renderer, View, ViewError, wgpu,
};

/// The kind of a camera's target; `None` has samples that Windfall does not draw with.
fn kind_of(target: wgpu::TextureFormat, msaa: Option<&Msaa>) -> Option<Kind> {
    let samples = msaa.map_or(1, Msaa::samples);
    matches!(samples, 1 | 4).then_some((target, samples))
}

/// Asks for the renderers of all 3D cameras, while there are forests.
pub(crate) fn want_renderers(
    mut renderers: ResMut<Renderers>,
    forests: Res<RenderForests>,
    device: Res<RenderDevice>,
    cameras: Query<(&ExtractedView, Option<&Msaa>), With<Camera3d>>,
    mut told: Local<bool>,
) {
    renderers.poll();
    if forests.of.is_empty() {
        return;
    }
    for (view, msaa) in &cameras {
        match kind_of(view.target_format, msaa) {
            Some(kind) => renderers.want(kind, &device),
            None if !*told => {
                *told = true;
                warn!("cameras with Msaa::Sample2 or Sample8 show no foliage: use Off or Sample4");
            }
            None => {}
        }
    }
}

/// What is the same for all cameras: leaves detach, fall and land.
pub(crate) fn advance(
    mut forests: ResMut<RenderForests>,
    renderers: Res<Renderers>,
    queue: Res<RenderQueue>,
    mut context: RenderContext,
) {
    let Some(renderer) = renderers.any() else { return };
    let moment = Moment::at(forests.time);
    for (&entity, forest) in &mut forests.of {
        let Some(live) = &mut forest.live else { continue };
        let mut recording = Recording::new(&queue, context.command_encoder());
        if let Err(cause) = renderer.advance(&mut recording, &mut live.forest, moment) {
            forest.fail(entity, cause);
        }
    }
}

type Seen = (
    &'static ExtractedView,
    &'static ExtractedCamera,
    &'static ViewTarget,
    Option<&'static Msaa>,
    Option<&'static RenderLayers>,
    (Option<&'static ViewLightEntities>, Option<&'static ViewShadowBindings>),
    (Option<&'static AmbientLight>, Option<&'static WindfallAmbient>, Option<&'static DistanceFog>),
    (Option<&'static LeafDetail>, Option<&'static TemporalJitter>),
    Option<&'static MainPassResolutionOverride>,
);

/// Draws shadows into the cascades of a camera, and prepares what it sees.
pub(crate) fn prepare(
    view: ViewQuery<Seen>,
    mut forests: ResMut<RenderForests>,
    renderers: Res<Renderers>,
    queue: Res<RenderQueue>,
    global: Option<Res<GlobalAmbientLight>>,
    suns: Query<(Entity, &ExtractedDirectionalLight, &RenderLayers)>,
    cascades: Query<(&LightEntity, &ExtractedView, &ShadowView, Option<&RenderLayers>)>,
    mut context: RenderContext,
) {
    let (view, camera, target, msaa, layers, (lights, maps), ambient, (detail, jitter), smaller) =
        view.into_inner();
    let Some(renderer) =
        kind_of(target.main_texture_format(), msaa).and_then(|kind| renderers.get(kind))
    else {
        return;
    };
    let layers = layers.cloned().unwrap_or_default();
    let detail = detail.copied().unwrap_or_default();
    let frame = forests.frame;
    let mut seen: Vec<&mut RenderForest> =
        forests.of.values_mut().filter(|forest| is_seen(forest, &layers)).collect();
    if seen.is_empty() {
        return;
    }
    for &entity in lights.map_or(&[][..], |of| &of.lights) {
        let Ok((_, cascade, map, of_light)) = cascades.get(entity) else { continue };
        let of_light = of_light.cloned().unwrap_or_default();
        let mut recording = Recording::new(&queue, context.command_encoder());
        cast(renderer, &mut recording, &mut seen, (cascade, map, &of_light), (frame, &detail));
    }
    let sun = sun_of(suns.iter(), &layers);
    let shadow = match (sun, lights, maps) {
        (Some(sun), Some(lights), Some(maps)) if sun.1.shadow_maps_enabled => {
            let view_of = |e| cascades.get(e).ok().map(|(of, view, _, _)| (of, view));
            shadow_of(sun, lights, maps, view_of)
        }
        _ => None,
    };
    let (own, harmonics, fog) = ambient;
    let none = GlobalAmbientLight::NONE;
    let global = global.as_deref().unwrap_or(&none);
    let surroundings = Surroundings { exposure: camera.exposure, global, own, harmonics, fog };
    let light = host_light(sun.map(|(_, light)| light), &surroundings, shadow);

    let size = smaller.map_or(UVec2::new(view.viewport.z, view.viewport.w), |smaller| smaller.0);
    let mut projection = view.clip_from_view;
    if let Some(jitter) = jitter {
        jitter.jitter_projection(&mut projection, size.as_vec2());
    }
    for forest in seen {
        let origin = forest.wanted.origin;
        let Some(live) = &mut forest.live else { continue };
        let seen_by = live
            .views
            .entry(view.retained_view_entity)
            .or_insert_with(|| SeenBy { state: renderer.view(&live.forest), frame });
        seen_by.frame = frame;
        let of = View {
            light: Light::Host(about(light.clone(), origin)),
            detail: detail.detail,
            quality: detail.quality,
            culling: detail.culling,
            ..View::new(camera_of(view, projection, origin))
        };
        let mut recording = Recording::new(&queue, context.command_encoder());
        let size = (size.x, size.y);
        tell(renderer.prepare(&mut recording, &live.forest, &mut seen_by.state, &of, size));
    }
}

/// Draws the forests' depth into one cascade of a light.
fn cast(
    renderer: &Renderer,
    recording: &mut Recording<'_>,
    seen: &mut [&mut RenderForest],
    (cascade, map, layers): (&ExtractedView, &ShadowView, &RenderLayers),
    (frame, detail): (u64, &LeafDetail),
) {
    // The light does not matter: depth alone is drawn.
    let dark = HostLight::new(Vec3::Y, Vec3::ZERO, Vec3::ZERO);
    let size = (cascade.viewport.z, cascade.viewport.w);
    let key = cascade.retained_view_entity;
    let mut drawn = false;
    for forest in seen.iter_mut().filter(|forest| forest.wanted.layers.intersects(layers)) {
        let origin = forest.wanted.origin;
        let Some(live) = &mut forest.live else { continue };
        let seen_by = live
            .views
            .entry(key)
            .or_insert_with(|| SeenBy { state: renderer.view(&live.forest), frame });
        let of = View {
            light: Light::Host(dark.clone()),
            detail: detail.shadow_detail,
            quality: detail.quality,
            ..View::new(camera_of(cascade, cascade.clip_from_view, origin))
        };
        let prepared = renderer.prepare(recording, &live.forest, &mut seen_by.state, &of, size);
        seen_by.frame = frame;
        drawn |= prepared.is_ok();
        tell(prepared);
    }
    if !drawn {
        return;
    }
    let mut pass = recording.encoder.begin_render_pass(&RenderPassDescriptor {
        label: Some("windfall shadows"),
        color_attachments: &[],
        depth_stencil_attachment: Some(map.depth_attachment.get_attachment(StoreOp::Store)),
        ..Default::default()
    });
    for forest in seen.iter().filter(|forest| forest.wanted.layers.intersects(layers)) {
        draw_one(forest, key, frame, |live, state| {
            renderer.draw_depth(&mut pass, &live.forest, state)
        });
    }
}

/// Draws leaves and wood behind what is transparent.
pub(crate) fn draw(
    view: ViewQuery<(
        &ExtractedView,
        &ExtractedCamera,
        &ViewTarget,
        &ViewDepthTexture,
        Option<&Msaa>,
        Option<&RenderLayers>,
        Option<&MainPassResolutionOverride>,
    )>,
    forests: Res<RenderForests>,
    renderers: Res<Renderers>,
    mut context: RenderContext,
) {
    let (view, camera, target, depth, msaa, layers, smaller) = view.into_inner();
    let Some(renderer) =
        kind_of(target.main_texture_format(), msaa).and_then(|kind| renderers.get(kind))
    else {
        return;
    };
    let layers = layers.cloned().unwrap_or_default();
    let key = view.retained_view_entity;
    let frame = forests.frame;
    let prepared = |forest: &RenderForest| {
        let seen_by = forest.live.as_ref().and_then(|live| live.views.get(&key));
        seen_by.is_some_and(|seen_by| seen_by.frame == frame)
    };
    let seen = || forests.of.values().filter(|of| is_seen(of, &layers) && prepared(of));
    if seen().next().is_none() {
        return;
    }
    let mut pass = context.command_encoder().begin_render_pass(&RenderPassDescriptor {
        label: Some("windfall"),
        color_attachments: &[Some(target.get_color_attachment())],
        depth_stencil_attachment: Some(depth.get_attachment(StoreOp::Store)),
        ..Default::default()
    });
    if let Some(at) =
        bevy::camera::Viewport::from_viewport_and_override(camera.viewport.as_ref(), smaller)
    {
        let (from, size) = (at.physical_position.as_vec2(), at.physical_size.as_vec2());
        pass.set_viewport(from.x, from.y, size.x, size.y, at.depth.start, at.depth.end);
    }
    for forest in seen() {
        draw_one(forest, key, frame, |live, state| renderer.draw(&mut pass, &live.forest, state));
    }
}

fn draw_one(
    forest: &RenderForest,
    key: RetainedViewEntity,
    frame: u64,
    draw: impl FnOnce(&super::forests::Live, &windfall::ViewState) -> Result<(), ViewError>,
) {
    let Some(live) = &forest.live else { return };
    if let Some(seen_by) = live.views.get(&key).filter(|seen_by| seen_by.frame == frame) {
        tell(draw(live, &seen_by.state));
    }
}

fn is_seen(forest: &RenderForest, layers: &RenderLayers) -> bool {
    forest.wanted.visible && forest.live.is_some() && forest.wanted.layers.intersects(layers)
}

/// A camera or light of Bevy's, about a forest's origin.
fn camera_of(view: &ExtractedView, projection: Mat4, origin: windfall::glam::DVec3) -> Camera {
    Camera {
        eye: view.world_from_view.translation().as_dvec3() - origin,
        rotation: view.world_from_view.rotation().normalize(),
        projection: Projection::Matrix(projection),
    }
}

/// Says what is wrong with a view, and goes on.
fn tell(done: Result<(), ViewError>) {
    match done {
        // A forest without any tree yet.
        Ok(()) | Err(ViewError::NotAdvanced) => {}
        Err(cause) => warn_once!("a view of a forest is not drawn: {cause}"),
    }
}

/// Tells the application how far everything is.
pub(crate) fn report(
    status: Res<WindfallStatus>,
    forests: Res<RenderForests>,
    renderers: Res<Renderers>,
    models: Res<Models>,
) {
    let missing = forests.of.values().filter(|forest| !forest.is_ready()).count();
    let waiting = renderers.waiting() + models.waiting() + missing;
    let live = || forests.of.values().filter_map(|forest| forest.live.as_ref());
    let bytes = live().map(|live| live.forest.bytes()).sum();
    status.set(waiting, live().count(), live().map(|live| live.views.len()).sum(), bytes);
}
