//! Jobs that make the world, and what a change of the settings asks of them.

use super::{Framing, Viewer};
use crate::load::{Before, Message, Request, World, change, start};
use crate::picture::Picture;
use crate::state::framing;
use crate::state::settings::{Settings, Work};
use eframe::egui_wgpu::RenderState;
use std::sync::mpsc::TryRecvError;
use std::sync::{Arc, PoisonError};

impl Viewer {
    /// Starts to make the world that the settings say; a job that runs is cancelled.
    pub(super) fn load(&mut self, render: &RenderState, context: &egui::Context) {
        let context = context.clone();
        let before = self.world.as_ref().map(|world| Before {
            stage: Arc::clone(&world.stage),
            models: world.planted.models.clone(),
            keys: world.keys.clone(),
        });
        self.job = Some(start(Request {
            settings: self.settings.clone(),
            files: self.files.clone(),
            device: render.device.clone(),
            queue: render.queue.clone(),
            before,
            renderer: self.picture.is_none(),
            wake: Box::new(move || context.request_repaint()),
        }));
        self.applied = self.settings.clone();
        self.progress = Some(("…".to_owned(), 0, 1));
        self.watched = self.watched_files();
    }

    /// Whether something is being loaded.
    pub(crate) fn is_loading(&self) -> bool {
        self.job.is_some()
    }

    /// Goes back to the world that is there.
    pub(crate) fn cancel(&mut self) {
        self.stop_loading();
        self.go_back();
        self.say(false, "cancelled");
    }

    fn stop_loading(&mut self) {
        self.job = None;
        self.progress = None;
    }

    fn go_back(&mut self) {
        if let Some((settings, files)) = self.good.clone() {
            self.applied = settings.clone();
            self.settings = settings;
            self.files = files;
            self.framing = Framing::Stay;
            self.watched = self.watched_files();
        }
    }

    /// What jobs have to say.
    pub(super) fn receive(&mut self, render: &RenderState) {
        loop {
            let Some(job) = &self.job else { return };
            match job.messages.try_recv() {
                Ok(Message::Renderer(renderer)) => {
                    self.picture = Some(Picture::new(*renderer, &render.device));
                }
                Ok(Message::Progress(what, done, of)) => self.progress = Some((what, done, of)),
                Ok(Message::World(world)) => {
                    let of = job.settings.clone();
                    self.stop_loading();
                    self.arrive(*world, of);
                }
                Ok(Message::Failed(error)) => {
                    self.stop_loading();
                    self.say(true, error);
                    self.go_back();
                }
                Err(TryRecvError::Empty) => return,
                Err(TryRecvError::Disconnected) => {
                    self.stop_loading();
                    self.say(true, "loading stopped; there may be too little memory");
                    self.go_back();
                }
            }
        }
    }

    /// A new world is there: it is shown from where it is to be seen.
    fn arrive(&mut self, world: World, of: Settings) {
        for note in &world.notes {
            self.say(false, note.to_string());
        }
        self.world = Some(world);
        self.status.lock().unwrap_or_else(PoisonError::into_inner).loads += 1;
        self.pace.forget();
        self.drawn = None;
        self.hover = None;
        if let Some(picture) = &mut self.picture {
            picture.forget();
        }
        // What was changed while it was loading is a change of the running world.
        if self.settings != of {
            self.applied = of.clone();
        }
        self.good = Some((of, self.files.clone()));
        self.take_place();
    }

    /// Puts the camera where it is to be in the world that is there.
    pub(super) fn take_place(&mut self) {
        match std::mem::replace(&mut self.framing, Framing::Stay) {
            Framing::Stay => {}
            Framing::At(key) => self.stand(&key),
            Framing::Scene => {
                if let Some(key) = self.settings.scene.camera.first().copied() {
                    self.stand(&key);
                }
            }
            Framing::Trees => self.frame_trees(),
        }
    }

    /// Looks at the trees near the middle so that they are seen in full.
    pub(crate) fn frame_trees(&mut self) {
        let sphere = self.world.as_ref().and_then(|world| framing::of_stage(&world.stage));
        let Some((middle, radius)) = sphere else { return };
        let size = self.picture.as_ref().and_then(Picture::size).unwrap_or((16, 10));
        let aspect = f64::from(size.0) / f64::from(size.1.max(1));
        self.rig.pitch = self.rig.pitch.clamp(-0.4, -0.05);
        self.rig.frame(middle, radius, aspect);
        let floor = self.ground()(self.rig.eye.x, self.rig.eye.z) + 0.5;
        if self.rig.eye.y < floor {
            let eye = glam::DVec3::new(self.rig.eye.x, floor, self.rig.eye.z);
            self.rig.look_at(eye, middle);
        }
    }

    /// Brings the world to what the settings have become in this frame, while a button of the mouse is `holding` a
    /// slider or not; whether it has to be made anew.
    pub(crate) fn changed(&mut self, before: &Settings, holding: bool) -> bool {
        if self.settings != *before && !std::mem::take(&mut self.undoing) {
            self.history.changed(before);
        }
        if !holding {
            self.history.settle();
        }
        if self.settings == self.applied && !self.reload {
            return false;
        }
        if let Err(error) = self.settings.scene.check("settings") {
            self.say(true, error.to_string());
            self.settings = before.clone();
            return false;
        }
        let work = if self.reload { Work::Grow } else { self.settings.work_from(&self.applied) };
        match work {
            Work::Draw | Work::Change => {
                self.applied = self.settings.clone();
                if self.job.is_none()
                    && let Some(world) = &mut self.world
                {
                    let changed = change(world, &self.settings);
                    self.good = Some((self.settings.clone(), self.files.clone()));
                    self.drawn = None;
                    if let Err(error) = changed {
                        self.say(true, error);
                    }
                }
            }
            // A slider that is being dragged asks for many.
            Work::Plant | Work::Grow if holding => {}
            Work::Plant | Work::Grow => {
                self.reload = false;
                return true;
            }
        }
        false
    }
}
