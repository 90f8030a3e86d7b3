//! One picture of the forest in the window: camera, view, drawing.

use super::pace::Purpose;
use super::{Drawn, Viewer};
use crate::pick::{self, Hit, Ray};
use crate::state::camera::Mode;
use eframe::egui_wgpu::RenderState;
use std::time::Duration;
use windfall_core::forest::Terrain;
use windfall_core::path::Phase;
use windfall_gpu::{Camera, View};
use windfall_scenes::EventEntry;

/// Nearest distance that is drawn, metres.
const NEAR: f32 = 0.1;
/// How long a view stands before its shadows are drawn anew, and on a GPU the whole of it in full.
const SETTLED: Duration = Duration::from_millis(250);
/// How much longer before a software adapter draws it in full, which may take seconds.
const RESTED: Duration = Duration::from_millis(1500);

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
        let wanted = (view, self.clock.time, size);
        let (Some(world), Some(picture)) = (&mut self.world, &mut self.picture) else { return };
        if picture.is_busy() {
            return;
        }
        // One that is to be kept waits for what is being loaded.
        let capture = !self.screenshot.is_empty() && self.job.is_none();
        let same = self.drawn.as_ref().filter(|drawn| drawn.wanted == wanted);
        let purpose = match same {
            _ if capture => Purpose::Kept,
            Some(_) if self.frames.is_some() => Purpose::Moving,
            Some(drawn) if drawn.full => return,
            Some(drawn) if drawn.purpose == Purpose::Moving => {
                if drawn.at.elapsed() < SETTLED {
                    return;
                }
                Purpose::Still
            }
            Some(drawn) if drawn.at.elapsed() < RESTED => return,
            Some(_) => Purpose::Kept,
            None => Purpose::Moving,
        };
        let mut view = wanted.0.clone();
        let full = self.pace.apply(&mut view, purpose);
        self.occlusion.apply(&mut view);
        let size = self.pace.pixels(size, purpose);
        let drawn = picture.draw(render, world, (self.clock.time, &view), size, (purpose, capture));
        self.drawn = Some(Drawn { wanted, full, purpose, at: web_time::Instant::now() });
        match drawn {
            Ok(()) => self.statistics.drew(),
            Err(error) => self.say(true, error),
        }
    }

    /// The leaf at a place in the picture: parts of its width and height, from the upper left.
    pub(crate) fn leaf_at(&self, place: (f32, f32), (width, height): (u32, u32)) -> Option<Hit> {
        let world = self.world.as_ref()?;
        let forward = self.rig.forward();
        let right = forward.cross(glam::DVec3::Y).normalize();
        let half = (f64::from(self.rig.fov).to_radians() / 2.0).tan();
        let aspect = f64::from(width) / f64::from(height.max(1));
        let x = (2.0 * f64::from(place.0) - 1.0) * half * aspect;
        let y = (1.0 - 2.0 * f64::from(place.1)) * half;
        let along = (forward + right * x + right.cross(forward) * y).normalize();
        let pixel = 2.0 * half / f64::from(height.max(1));
        let ray = Ray { eye: self.rig.eye, along, pixel };
        let events = &self.settings.scene.events;
        pick::leaf(&world.stage, world.planted.forest.falls(), events, self.clock.time, &ray)
    }

    /// What is under the pointer, in words.
    pub(crate) fn describe(&self, hit: &Hit) -> Option<String> {
        Some(pick::text(&self.world.as_ref()?.stage, hit, self.clock.time))
    }

    /// Throws the leaf, if it hangs.
    pub(crate) fn throw(&mut self, hit: &Hit) {
        if hit.phase == Phase::Hanging {
            let (tree, leaf) = (hit.tree as u32, hit.leaf);
            self.settings.scene.events.push(EventEntry { tree, leaf, time: self.clock.time });
            self.say(false, format!("leaf {leaf} of tree {tree} falls"));
        }
    }
}
