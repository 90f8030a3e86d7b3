//! The application: one frame after another, in a window or on a page.

mod complaints;
mod files;
mod finish;
mod frame;
mod loading;
mod out;
mod pace;
mod shared;

#[cfg(not(target_arch = "wasm32"))]
pub(crate) use out::free_path;
pub use out::png;
pub use pace::{Purpose, USUAL as USUAL_BUDGET};
pub use shared::{Ask, Asked, Line, Shared, Start, Status, WithPixels};

use crate::files::Files;
use crate::input::{self, Action};
use crate::load::{Job, World};
use crate::picture::Picture;
use crate::state::camera::{Mode, Rig};
use crate::state::clock::Clock;
use crate::state::history::History;
use crate::state::settings::Settings;
use crate::statistics::Statistics;
use crate::ui;
use std::cell::RefCell;
use std::rc::Rc;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use windfall_gpu::View;
use windfall_scenes::CameraKey;

/// What is shown first where pictures are drawn by the processor: the default scene takes a third of a second there.
const LIGHT_SCENE: &str = "lone-oak";

/// The viewer.
#[expect(clippy::struct_excessive_bools, reason = "each is a state of its own")]
pub struct Viewer {
    pub(crate) settings: Settings,
    /// The settings to go back to: those of the scene as it was read.
    pub(crate) base: Settings,
    /// The settings that the world has.
    applied: Settings,
    pub(crate) history: History,
    pub(crate) clock: Clock,
    pub(crate) rig: Rig,
    pub(crate) bookmarks: Vec<CameraKey>,
    pub(crate) files: Files,
    pub(crate) adding: bool,
    pub(crate) world: Option<World>,
    pub(crate) picture: Option<Picture>,
    job: Option<Job>,
    /// What the job does: what, how many are there, of how many.
    pub(crate) progress: Option<(String, usize, usize)>,
    /// What the camera shows once the world is there.
    framing: Framing,
    pub(crate) lines: Vec<Line>,
    pub(crate) statistics: Statistics,
    /// The settings and files of the last world that came.
    good: Option<(Settings, Files)>,
    /// Whether the change of this frame is a step back.
    undoing: bool,
    /// Whether files are to be read again.
    reload: bool,
    /// Whether the scene's path is the user's.
    pub(crate) recording: bool,
    /// Address of the page, before the hash of links; empty in a window.
    pub(crate) page: String,
    /// What the GPU complained of.
    complaints: Arc<Mutex<Vec<String>>>,
    /// How many of these have been said.
    complained: usize,
    /// What was saved, or why not.
    said: Rc<RefCell<Vec<Result<String, String>>>>,
    pub(crate) pace: pace::Pace,
    /// Where occlusion culling is asked for, it is used while it pays.
    pub(crate) occlusion: windfall_gpu::OcclusionSwitch,
    pub(crate) panel: bool,
    pub(crate) help: bool,
    pub(crate) path_box: Option<String>,
    asked: Asked,
    status: Arc<Mutex<Status>>,
    screenshot: Vec<WithPixels>,
    /// The program that renders films, and a film that is being made.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) program: Option<std::path::PathBuf>,
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) film: Option<crate::film::Film>,
    drawn: Option<Drawn>,
    watched: Vec<(String, Option<std::time::SystemTime>)>,
    watch_due: f64,
    frames: Option<u64>,
    quits: bool,
    timings: bool,
    started: web_time::Instant,
    /// When the link was written.
    linked: web_time::Instant,
    first: Option<Duration>,
    /// Where the pointer was when its leaf was looked for, and that leaf in words.
    pub(crate) hover: Option<(egui::Pos2, Option<String>)>,
}

/// The last picture.
struct Drawn {
    /// The view that was wanted, its moment and size.
    wanted: (View, f64, (u32, u32)),
    /// Whether it is as good as it gets, and if not, what it was drawn for.
    full: bool,
    purpose: Purpose,
    at: web_time::Instant,
}

/// Where the camera goes when a world has come.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Framing {
    /// It stays.
    Stay,
    /// There; heights of keys are above the ground of the new world.
    At(CameraKey),
    /// Where the scene has it.
    Scene,
    /// Where it sees the trees.
    Trees,
}

impl Viewer {
    /// A viewer on eframe's device. It begins to load.
    ///
    /// # Errors
    ///
    /// eframe draws by something else than wgpu.
    pub fn new(
        context: &eframe::CreationContext<'_>,
        start: Start,
        shared: Shared,
        started: web_time::Instant,
    ) -> Result<Self, String> {
        let render = context.wgpu_render_state.as_ref().ok_or("the window is not wgpu's")?;
        ui::style(&context.egui_ctx);
        let chosen = start.chosen;
        let mut viewer = Self::waiting(start, shared, started);
        viewer.pace.start(render);
        viewer.listen(&render.device);
        if !chosen
            && viewer.pace.is_software()
            && let Some(settings) = Settings::named(LIGHT_SCENE)
        {
            viewer.choose(settings);
            viewer.applied = viewer.settings.clone();
        }
        viewer.load(render, &context.egui_ctx);
        Ok(viewer)
    }

    /// A viewer that does not load yet.
    pub fn waiting(start: Start, (asked, status): Shared, started: web_time::Instant) -> Self {
        let scene = &start.settings.scene;
        let mut clock = Clock::new(scene.time, scene.frames.1, scene.fps);
        clock.playing = start.playing;
        let key = start.camera.or_else(|| scene.camera.first().copied());
        let rig = key.map_or_else(
            || Rig::new(glam::DVec3::new(0.0, 1.7, 30.0), glam::DVec3::new(0.0, 5.0, 0.0), 50.0),
            |key| Rig::of_key(&key, |_, _| 0.0),
        );
        let framing = start.camera.map_or(Framing::Scene, Framing::At);
        let mut viewer = Self {
            base: start.settings.base(),
            applied: start.settings.clone(),
            history: History::default(),
            clock,
            rig,
            bookmarks: start.camera.into_iter().collect(),
            files: start.files,
            adding: false,
            world: None,
            picture: None,
            job: None,
            progress: None,
            framing,
            lines: Vec::new(),
            statistics: Statistics::default(),
            good: None,
            undoing: false,
            reload: false,
            recording: false,
            page: crate::page_address(),
            complaints: Arc::default(),
            complained: 0,
            said: Rc::default(),
            pace: pace::Pace::new(start.budget.or(scene.budget).unwrap_or(USUAL_BUDGET)),
            occlusion: windfall_gpu::OcclusionSwitch::default(),
            panel: start.panel,
            help: false,
            path_box: None,
            asked,
            status,
            screenshot: Vec::new(),
            #[cfg(not(target_arch = "wasm32"))]
            program: start.program,
            #[cfg(not(target_arch = "wasm32"))]
            film: None,
            drawn: None,
            watched: Vec::new(),
            watch_due: 0.0,
            frames: start.frames,
            quits: false,
            timings: start.timings,
            started,
            linked: started,
            first: None,
            hover: None,
            settings: start.settings,
        };
        for file in start.open {
            viewer.open(&file, None);
        }
        viewer
    }

    /// Says something to the user.
    pub(crate) fn say(&mut self, error: bool, text: impl Into<String>) {
        let text = text.into();
        #[cfg(not(target_arch = "wasm32"))]
        if error {
            tracing::warn!("{text}");
        }
        let mut status = self.status.lock().unwrap_or_else(PoisonError::into_inner);
        if error { &mut status.errors } else { &mut status.notes }.push(text.clone());
        drop(status);
        self.lines.push(Line { error, text, at: web_time::Instant::now() });
        if self.lines.len() > 100 {
            self.lines.remove(0);
        }
    }

    /// Height of the ground at x and z.
    pub(crate) fn ground(&self) -> impl Fn(f64, f64) -> f64 + use<> {
        let stage = self.world.as_ref().map(|world| Arc::clone(&world.stage));
        move |x, z| {
            stage.as_ref().map_or(0.0, |s| f64::from(s.forest.terrain.height(x as f32, z as f32)))
        }
    }

    /// The camera as a key of a scene, at the moment that is shown.
    pub(crate) fn key(&self) -> CameraKey {
        self.rig.key(self.clock.time, self.ground())
    }

    /// Puts the camera where a key has it.
    pub(crate) fn stand(&mut self, key: &CameraKey) {
        let (mode, height) = (self.rig.mode, self.rig.eye_height);
        self.rig = Rig { mode, eye_height: height, ..Rig::of_key(key, self.ground()) };
    }

    pub(crate) fn act(&mut self, action: Action) {
        match action {
            Action::Play => self.clock.playing = !self.clock.playing,
            Action::Back => self.clock.step(-1.0),
            Action::On => self.clock.step(1.0),
            Action::Start => self.clock.seek(0.0),
            Action::Orbit => self.rig.mode = Mode::Orbit,
            Action::Walk => {
                self.rig.mode = Mode::Walk;
                self.rig.eye_height = 1.7;
            }
            Action::Fly => self.rig.mode = Mode::Fly,
            Action::Path => self.rig.mode = Mode::Path,
            Action::Frame => self.frame_trees(),
            Action::Undo => {
                self.undoing = true;
                self.history.undo(&mut self.settings);
            }
            Action::Redo => {
                self.undoing = true;
                self.history.redo(&mut self.settings);
            }
            Action::Screenshot => self.save_picture(),
            Action::Save => self.save_scene(),
            Action::Open => self.path_box = Some(String::new()),
            Action::Panel => self.panel = !self.panel,
            Action::Help => self.help = !self.help,
            Action::Record => self.record(),
            Action::Bookmark => self.bookmarks.push(self.key()),
            Action::Quit => self.quits = true,
        }
    }

    /// Shows another scene.
    pub(crate) fn choose(&mut self, settings: Settings) {
        let (playing, scene) = (self.clock.playing, &settings.scene);
        self.clock = Clock::new(scene.time, scene.frames.1, scene.fps);
        self.clock.playing = playing;
        (self.framing, self.recording) = (Framing::Scene, false);
        if let Some(milliseconds) = scene.budget {
            self.pace.set_milliseconds(milliseconds);
        }
        self.base = settings.clone();
        self.settings = settings;
    }

    /// What was asked from outside since the last frame.
    fn answer(&mut self) {
        let asked = std::mem::take(&mut *self.asked.borrow_mut());
        for ask in asked {
            match ask {
                Ask::Link(hash) => self.follow(&hash),
                Ask::Seek(time) => {
                    self.clock.playing = false;
                    self.clock.seek(time);
                }
                Ask::Play(play) => self.clock.playing = play,
                Ask::Open(name, bytes) => self.open(&name, Some(bytes)),
                Ask::Screenshot(with) => self.screenshot.push(with),
            }
        }
    }
}

impl eframe::App for Viewer {
    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        let Some(render) = frame.wgpu_render_state().cloned() else { return };
        let before = self.settings.clone();
        if self.job.is_some() {
            self.statistics.loads();
        } else {
            self.statistics.last_loading = None;
        }
        self.answer();
        self.collect(&render);
        self.receive(&render);
        self.heed();
        self.complain();
        self.take_dropped(ui.ctx());
        for action in input::actions(ui) {
            self.act(action);
        }
        self.clock.advance(f64::from(ui.input(|i| i.unstable_dt)));
        let holding = ui.input(|input| input.pointer.any_down());
        // What was asked for is in the picture of this frame, unless it has to be loaded.
        if self.changed(&before, holding) {
            self.load(&render, ui.ctx());
        }
        if self.job.is_none() && self.world.is_some() {
            self.take_place();
        }
        let before = self.settings.clone();
        ui::show(self, ui, &render);
        if self.changed(&before, holding) {
            self.load(&render, ui.ctx());
        }
        self.watch(ui.input(|i| i.time));
        self.finish(ui.ctx());
    }

    #[cfg(target_arch = "wasm32")]
    fn as_any_mut(&mut self) -> Option<&mut dyn std::any::Any> {
        Some(self)
    }
}
