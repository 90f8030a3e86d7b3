//! What leaves the viewer: pictures, scenes, command lines, links.

use super::{Framing, Viewer};
use crate::picture::Pixels;
use crate::state::camera::Mode;
use crate::state::{command, link};
use windfall_scenes::{CameraKey, Scene, SheddingEntry};

impl Viewer {
    /// Adds the camera to the scene's path, at the moment that is shown. The first view of a recording replaces the
    /// scene's own path.
    pub(crate) fn record(&mut self) {
        let key = self.key();
        if !std::mem::replace(&mut self.recording, true) {
            self.settings.scene.camera.clear();
        }
        let keys = &mut self.settings.scene.camera;
        keys.retain(|known| (known.time - key.time).abs() > 1e-6);
        keys.push(key);
        keys.sort_by(|a, b| a.time.total_cmp(&b.time));
        let text = format!("{} views on the path; key 4 goes along it", keys.len());
        self.say(false, text);
    }

    /// The scene as it is shown: with the recorded path, or the camera where it stands.
    pub(crate) fn scene(&self) -> Scene {
        let mut scene = self.settings.scene.clone();
        scene.time = self.clock.time;
        if self.settings.quality.ambient_occlusion != scene.quality_of_view().ambient_occlusion {
            scene.ambient_occlusion = Some(self.settings.quality.ambient_occlusion);
        }
        if !self.recording && self.rig.mode != Mode::Path {
            scene.camera = vec![CameraKey { time: 0.0, ..self.key() }];
        }
        if let (Some(rate), Some(world)) = (self.settings.throw_rate, &self.world) {
            let thrown = world.stage.thrown(rate, 0.0);
            scene.shedding = Some(SheddingEntry {
                start: thrown.start,
                duration: thrown.duration,
                peak: thrown.peak,
                tree_spread: thrown.tree_spread,
                burst: thrown.burst,
            });
        }
        scene
    }

    /// A link to what is shown, without its address.
    pub(crate) fn link(&self) -> String {
        link::write(&self.settings, Some(self.key()))
    }

    /// Shows what a link says.
    pub(super) fn follow(&mut self, hash: &str) {
        match link::read(hash) {
            Ok((settings, camera)) => {
                self.clock.seek(settings.scene.time);
                self.clock.playing = false;
                self.framing = camera.map_or(Framing::Scene, Framing::At);
                if camera.is_some() {
                    self.rig.mode = Mode::Orbit;
                }
                self.base = settings.base();
                self.settings = settings;
            }
            Err(error) => self.say(true, error.to_string()),
        }
    }

    /// The command line that renders what is shown; whether it needs the scene saved as `scene.ron`.
    pub(crate) fn command(&self) -> (String, bool) {
        let (line, scene) = command::line(&self.settings, &self.key(), "scene.ron");
        (line, scene.is_some())
    }

    /// Saves the next picture.
    pub(crate) fn save_picture(&mut self) {
        let said = self.said.clone();
        self.screenshot.push(Box::new(move |pixels: Pixels| {
            let saved = png(&pixels).and_then(|bytes| give("windfall", "png", "image/png", &bytes));
            said.borrow_mut().push(saved);
        }));
    }

    /// Saves the scene: where its files are named relative to another folder, with their whole paths.
    pub(crate) fn save_scene(&mut self) {
        #[cfg(not(target_arch = "wasm32"))]
        let scene = if self.files.folder == std::path::Path::new("") {
            self.scene()
        } else {
            self.scene_for_all()
        };
        #[cfg(target_arch = "wasm32")]
        let scene = self.scene();
        let saved = give("scene", "ron", "text/plain", scene.to_ron().as_bytes());
        self.said.borrow_mut().push(saved);
    }

    /// The scene with whole paths of its files, for programs that run in another folder.
    #[cfg(not(target_arch = "wasm32"))]
    fn scene_for_all(&self) -> Scene {
        let mut scene = self.scene();
        let folder = std::env::current_dir().unwrap_or_default().join(&self.files.folder);
        scene.each_file(|name| *name = folder.join(&*name).to_string_lossy().into_owned());
        scene
    }

    /// Begins a film of the scene beside the window.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn make_film(&mut self) {
        let Some(program) = &self.program else { return };
        let scene = self.scene_for_all();
        // The window's pixels, not the fewer of a picture that moves. Encoders want even sides.
        let size = self.drawn.as_ref().map_or(scene.size, |drawn| drawn.wanted.2);
        let size = (size.0.max(2) & !1, size.1.max(2) & !1);
        match crate::film::Film::begin(program, &scene, size) {
            Ok(film) => self.film = Some(film),
            Err(error) => self.say(true, error),
        }
    }

    /// What was saved since the last frame.
    pub(super) fn heed(&mut self) {
        #[cfg(not(target_arch = "wasm32"))]
        if let Some(result) = self.film.as_mut().and_then(crate::film::Film::poll) {
            self.film = None;
            self.said.borrow_mut().push(result);
        }
        let said = self.said.take();
        for result in said {
            match result {
                Ok(name) => self.say(false, format!("saved {name}")),
                Err(error) => self.say(true, error),
            }
        }
    }
}

/// A PNG of pixels, without alpha.
///
/// # Errors
///
/// Never but for a lack of memory; in a sentence.
pub fn png(pixels: &Pixels) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, pixels.size.0, pixels.size.1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let rgb: Vec<u8> = pixels.rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
    let written = encoder.write_header().and_then(|mut writer| {
        writer.write_image_data(&rgb)?;
        writer.finish()
    });
    written.map_err(|error| error.to_string())?;
    Ok(bytes)
}

/// A file that is not there yet, in the folder where the program runs.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) fn free_path(stem: &str, ending: &str) -> Result<std::path::PathBuf, String> {
    (1..10_000)
        .map(|n| std::path::PathBuf::from(format!("{stem}-{n}.{ending}")))
        .find(|path| !path.exists())
        .ok_or_else(|| format!("{stem}-*.{ending}: there are too many"))
}

/// Writes a file that is not there yet into the folder where the program runs; its name.
#[cfg(not(target_arch = "wasm32"))]
fn give(stem: &str, ending: &str, _: &str, bytes: &[u8]) -> Result<String, String> {
    use std::io::Write;
    let path = free_path(stem, ending)?;
    windfall_host::file::write_atomic(&path, |file| Ok(file.write_all(bytes)?))
        .map_err(|error| format!("{error:#}"))?;
    Ok(path.display().to_string())
}

/// Lets the browser save a file.
#[cfg(target_arch = "wasm32")]
fn give(stem: &str, ending: &str, kind: &str, bytes: &[u8]) -> Result<String, String> {
    let name = format!("{stem}.{ending}");
    crate::web::download(&name, kind, bytes)?;
    Ok(name)
}
