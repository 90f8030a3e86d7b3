//! What a viewer shares with who starts it and who looks on.

use crate::files::Files;
use crate::picture::Pixels;
use crate::state::settings::Settings;
use std::cell::RefCell;
use std::rc::Rc;
use std::sync::{Arc, Mutex};
use windfall_scenes::CameraKey;

/// How the viewer starts.
#[derive(Debug, Clone)]
#[expect(clippy::struct_excessive_bools, reason = "each is an option of its own")]
pub struct Start {
    /// What is shown.
    pub settings: Settings,
    /// Whether somebody chose that; if not, a software adapter shows a scene that it can move.
    pub chosen: bool,
    /// Where the camera stands in place of the scene's.
    pub camera: Option<CameraKey>,
    /// Files of the scene.
    pub files: Files,
    /// Files to open beside it.
    pub open: Vec<String>,
    /// Pictures after which the window closes by itself.
    pub frames: Option<u64>,
    /// Whether to print how long things took.
    pub timings: bool,
    /// Whether the panel is shown.
    pub panel: bool,
    /// Whether time runs from the start.
    pub playing: bool,
    /// Time that a picture is to take at most, milliseconds; 0 gives up nothing for it. `None`: the scene's, or 40.
    pub budget: Option<f32>,
    /// The program `windfall`, which renders films; without it only their command line is given.
    pub program: Option<std::path::PathBuf>,
}

impl Start {
    /// Shows settings.
    pub fn new(settings: Settings) -> Self {
        Self {
            settings,
            chosen: true,
            camera: None,
            files: Files::default(),
            open: Vec::new(),
            frames: None,
            timings: false,
            panel: true,
            playing: true,
            budget: None,
            program: None,
        }
    }
}

/// A line for people.
pub struct Line {
    /// Whether it is an error.
    pub error: bool,
    /// What it says.
    pub text: String,
    /// When it was said.
    pub at: web_time::Instant,
}

/// What somebody outside asks of the viewer: a page's JavaScript, or a test.
pub enum Ask {
    /// Shows what a link says.
    Link(String),
    /// Goes to a moment.
    Seek(f64),
    /// Plays or stands.
    Play(bool),
    /// Opens a file.
    Open(String, Arc<[u8]>),
    /// Gives the next picture's pixels.
    Screenshot(WithPixels),
}

/// What is done with a picture.
pub type WithPixels = Box<dyn FnOnce(Pixels)>;

/// What is asked from outside.
pub type Asked = Rc<RefCell<Vec<Ask>>>;

/// What a viewer shares with what is outside.
pub type Shared = (Asked, Arc<Mutex<Status>>);

/// What is known outside.
#[derive(Debug, Default)]
pub struct Status {
    /// What wakes the viewer.
    pub context: Option<egui::Context>,
    /// Whether something is being loaded.
    pub loading: bool,
    /// Pictures drawn.
    pub pictures: u64,
    /// Times that something was loaded.
    pub loads: u64,
    /// The moment that is shown.
    pub time: f64,
    /// The hash of a link to what is shown.
    pub link: String,
    /// Errors that were said.
    pub errors: Vec<String>,
    /// What else was said.
    pub notes: Vec<String>,
}

impl Status {
    /// As JSON.
    pub fn json(&self) -> String {
        let Self { loading, pictures, loads, time, errors, notes, .. } = self;
        serde_json::json!({
            "loading": loading, "pictures": pictures, "loads": loads, "time": time, "errors": errors, "notes": notes,
        })
        .to_string()
    }
}
