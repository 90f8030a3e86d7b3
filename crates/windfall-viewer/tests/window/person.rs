//! Who sits in front of the window: eyes, hands, and patience.

use crate::eyes::{Eyes, Widget};
use crate::hands::Hands;
use crate::{inputs, steps};
use egui::accesskit::Role;
use egui::{ColorImage, Context, Pos2, Rect};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use windfall_scenes::Scene;
use windfall_viewer::app::{Shared, Start, Status};
use windfall_viewer::native;
use windfall_viewer::state::settings::Settings;

/// Size of the window.
pub const SIZE: (u32, u32) = (660, 720);
const PATIENCE: Duration = Duration::from_mins(1);

/// Opens the window, and lets somebody do all steps with it.
pub fn window() {
    inputs::write(Path::new("."));
    let shared = Shared::default();
    let eyes = Eyes::default();
    let person =
        Person { eyes: eyes.clone(), status: Arc::clone(&shared.1), hands: None, saved: 0 };
    let acts = std::thread::spawn(move || {
        let all = std::panic::AssertUnwindSafe(|| steps::all(person));
        if std::panic::catch_unwind(all).is_err() {
            std::process::exit(1);
        }
    });
    let start = Start { playing: false, ..Start::new(Settings::named("lone-oak").unwrap()) };
    let watch = move |context: &Context| {
        context.set_theme(egui::Theme::Dark);
        context.add_plugin(eyes);
    };
    native::run_with(start, (SIZE.0 as f32, SIZE.1 as f32), shared, watch).unwrap();
    // It closed because the last step asked it to.
    acts.join().unwrap();
}

pub struct Person {
    eyes: Eyes,
    status: Arc<Mutex<Status>>,
    hands: Option<Hands>,
    saved: u32,
}

impl Person {
    pub fn hands(&mut self) -> &Hands {
        self.hands.get_or_insert_with(|| Hands::on("Windfall"))
    }

    /// Does something with the hands, and waits until the window has seen it: what falls together in one frame of a
    /// slow machine is another gesture.
    fn act(&mut self, act: impl FnOnce(&Hands)) {
        act(self.hands());
        self.frames();
    }

    /// Presses keys together, as `ctrl+s`.
    pub fn key(&mut self, keys: &str) {
        self.act(|hands| hands.key(keys));
    }

    /// Holds a key down.
    pub fn hold(&mut self, key: &str, time: Duration) {
        self.act(|hands| hands.key_down(key));
        std::thread::sleep(time);
        self.act(|hands| hands.key_up(key));
    }

    pub fn write(&mut self, text: &str) {
        self.act(|hands| hands.write(text));
    }

    pub fn click_at(&mut self, at: Pos2) {
        self.act(|hands| hands.point(at));
        self.act(|hands| hands.press("1"));
        self.act(|hands| hands.release("1"));
    }

    /// Drags with a button: 1 left, 3 right.
    pub fn drag(&mut self, button: &str, from: Pos2, to: Pos2) {
        self.act(|hands| hands.point(from));
        self.act(|hands| hands.press(button));
        self.act(|hands| hands.point(from.lerp(to, 0.5)));
        self.act(|hands| hands.point(to));
        self.act(|hands| hands.release(button));
    }

    pub fn status<T>(&self, get: impl FnOnce(&Status) -> T) -> T {
        get(&self.status.lock().unwrap())
    }

    /// Waits until something is so.
    pub fn wait(&self, what: &str, is_so: impl Fn(&Self) -> bool) {
        let start = Instant::now();
        while !is_so(self) {
            // One that rests draws only twice a second.
            if let Some(context) = self.status(|s| s.context.clone()) {
                context.request_repaint();
            }
            let status = self.status(Status::json);
            assert!(start.elapsed() < PATIENCE, "{what}: {status}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Waits for two more frames of the window.
    pub fn frames(&self) {
        let frames = |person: &Self| person.eyes.0.lock().unwrap().frames;
        let before = frames(self);
        self.wait("frames", |person| frames(person) >= before + 2);
    }

    /// Waits until all is loaded.
    pub fn settle(&self) {
        self.frames();
        self.wait("loaded", |person| person.status(|s| !s.loading && s.pictures > 0));
    }

    pub fn widgets(&self) -> Vec<Widget> {
        self.eyes.0.lock().unwrap().widgets.clone()
    }

    pub fn find(&self, name: &str) -> Option<Widget> {
        let shown = |w: &Widget| w.name == name && w.rect.is_positive();
        self.widgets().into_iter().find(shown)
    }

    /// The widget of this name; it has to come.
    pub fn widget(&self, name: &str) -> Widget {
        self.frames();
        self.wait(name, |person| person.find(name).is_some());
        self.find(name).unwrap()
    }

    pub fn click(&mut self, name: &str) {
        let at = self.widget(name).rect.center();
        self.click_at(at);
    }

    /// Opens or closes a section of the panel, by its triangle.
    pub fn section(&mut self, name: &str) {
        let at = self.widget(name).rect.left_center() + egui::vec2(12.0, 0.0);
        self.click_at(at);
        // It unfolds.
        std::thread::sleep(Duration::from_millis(250));
        self.frames();
    }

    /// The slider in the row of a label.
    pub fn slider(&self, label: &str) -> Widget {
        let row = self.widget(label).rect.center().y;
        let of_row = |w: &Widget| w.role == Role::Slider && (w.rect.center().y - row).abs() < 6.0;
        self.widgets().into_iter().find(of_row).unwrap_or_else(|| panic!("no slider: {label}"))
    }

    /// Clicks at a part of a slider's length.
    pub fn set(&mut self, label: &str, part: f32) {
        let rect = self.slider(label).rect;
        let at = Pos2::new(rect.left() + part * rect.width(), rect.center().y);
        self.click_at(at);
    }

    /// Where the forest is.
    pub fn forest(&self) -> Rect {
        let forest = |w: &Widget| w.role == Role::Image && w.name.starts_with("the forest");
        self.widgets().into_iter().find(forest).expect("the forest").rect
    }

    /// Presses keys after which something is written; its name.
    fn save(&mut self, keys: &str) -> PathBuf {
        let notes = self.status(|s| s.notes.len());
        self.key(keys);
        self.wait("saved", |person| person.status(|s| s.notes.len() > notes));
        let note = self.status(|s| s.notes.last().cloned()).unwrap();
        self.saved += 1;
        note.strip_prefix("saved ").unwrap_or_else(|| panic!("{note}")).into()
    }

    /// The scene, as Ctrl+S writes it.
    pub fn scene(&mut self) -> Scene {
        let path = self.save("ctrl+s");
        Scene::from_ron(&std::fs::read_to_string(path).unwrap(), "saved").unwrap()
    }

    /// The picture, as P writes it.
    pub fn picture(&mut self) -> image::RgbImage {
        image::open(self.save("p")).unwrap().to_rgb8()
    }

    /// The window's pixels.
    pub fn look(&self) -> Arc<ColorImage> {
        self.frames();
        {
            let mut seen = self.eyes.0.lock().unwrap();
            (seen.pixels, seen.look) = (None, true);
        }
        self.wait("pixels", |person| person.eyes.0.lock().unwrap().pixels.is_some());
        self.eyes.0.lock().unwrap().pixels.clone().unwrap()
    }

    /// Puts the window's pixels into the folder that `WINDFALL_LOOK` names, for somebody to look at.
    pub fn show(&self, name: &str) {
        let Some(folder) = std::env::var_os("WINDFALL_LOOK") else { return };
        let pixels = self.look();
        let [width, height] = pixels.size.map(|side| side as u32);
        let path = Path::new(&folder).join(format!("{name}.png"));
        image::save_buffer(path, pixels.as_raw(), width, height, image::ColorType::Rgba8).unwrap();
    }

    pub fn copied(&self) -> Option<String> {
        self.eyes.0.lock().unwrap().copied.take()
    }

    /// Opens a file by its name, as Ctrl+O does.
    pub fn open(&mut self, name: &str) {
        self.key("ctrl+o");
        self.widget("Open");
        self.frames();
        self.write(name);
        self.key("Return");
        self.wait("the box closes", |person| person.find("Open").is_none());
        self.settle();
    }

    pub fn errors(&self) -> Vec<String> {
        self.status(|s| s.errors.clone())
    }
}
