//! The render world: forests follow what was extracted, compute once a frame, and are drawn into each 3D camera.

mod forests;
mod light;
mod models;
mod renderers;
mod views;

use crate::WindfallStatus;
use crate::camera::{LeafDetail, WindfallAmbient};
use bevy::core_pipeline::core_3d::{main_opaque_pass_3d, main_transparent_pass_3d};
use bevy::core_pipeline::schedule::camera_driver;
use bevy::core_pipeline::{Core3d, Core3dSystems};
use bevy::pbr::{LATE_SHADOW_PASS, per_view_shadow_pass};
use bevy::prelude::*;
use bevy::render::extract_component::ExtractComponentPlugin;
use bevy::render::renderer::{RenderGraph, RenderGraphSystems};
use bevy::render::{ExtractSchedule, Render, RenderApp, RenderSystems};

pub(crate) fn build(app: &mut App) {
    app.add_plugins((
        ExtractComponentPlugin::<LeafDetail>::default(),
        ExtractComponentPlugin::<WindfallAmbient>::default(),
    ));
    let status = app.world().resource::<WindfallStatus>().clone();
    let Some(render_app) = app.get_sub_app_mut(RenderApp) else { return };
    render_app
        .insert_resource(status)
        .init_resource::<renderers::Renderers>()
        .init_resource::<models::Models>()
        .init_resource::<forests::RenderForests>()
        .add_systems(ExtractSchedule, (models::extract_models, forests::extract_forests))
        .add_systems(
            Render,
            (
                (views::want_renderers, forests::follow).in_set(RenderSystems::PrepareResources),
                (forests::forget_views, views::report).in_set(RenderSystems::Cleanup),
            ),
        )
        .add_systems(
            RenderGraph,
            views::advance.in_set(RenderGraphSystems::Render).before(camera_driver),
        )
        .add_systems(
            Core3d,
            (
                views::prepare
                    .after(per_view_shadow_pass::<LATE_SHADOW_PASS>)
                    .after(Core3dSystems::Prepass)
                    .before(Core3dSystems::MainPass),
                views::draw
                    .in_set(Core3dSystems::MainPass)
                    .after(main_opaque_pass_3d)
                    .before(bevy::pbr::main_transmissive_pass_3d)
                    .before(main_transparent_pass_3d),
            ),
        );
}
