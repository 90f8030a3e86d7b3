//! One picture of the forest in the window: camera, view, drawing.

use super::Viewer;
use crate::state::camera::Mode;
use eframe::egui_wgpu::RenderState;
use windfall_core::forest::Terrain;
use windfall_gpu::{Camera, View};

/// Nearest distance that is drawn, metres.
const NEAR: f32 = 0.1;

impl Viewer {
    /// The view of this moment.
    pub(crate) fn view(&self, terrain: &Terrain) -> View {
        let scene = &self.settings.scene;
        let view = scene.view(self.clock.time, terrain);
        let camera = if self.rig.mode == Mode::Path {
            view.camera
        } else {
            let (eye, target) = (self.rig.eye, self.rig.target());
            Camera::look_at(eye, target, self.rig.fov.to_radians(), NEAR)
        };
        View { camera, show: self.settings.show, quality: self.settings.quality, ..view }
    }

    /// Draws a picture of `size` pixels if there is something new to see and the last one is done.
    pub(crate) fn draw(&mut self, render: &RenderState, size: (u32, u32)) {
        let Some(world) = &self.world else { return };
        let view = self.view(&world.stage.forest.terrain);
        if self.rig.mode == Mode::Path {
            let eye = view.camera.eye;
            let to = view.camera.forward().as_dvec3() * self.rig.distance;
            self.rig.look_at(eye, eye + to);
        }
        let now = (view, self.clock.time, size);
        let (Some(world), Some(picture)) = (&mut self.world, &mut self.picture) else { return };
        let capture = !self.screenshot.is_empty();
        let new = self.drawn.as_ref() != Some(&now) || self.frames.is_some() || capture;
        if picture.is_busy() || !new {
            return;
        }
        let drawn = picture.draw(render, world, (self.clock.time, &now.0), size, capture);
        self.drawn = Some(now);
        match drawn {
            Ok(()) => self.statistics.drew(),
            Err(error) => self.say(true, error),
        }
    }
}
