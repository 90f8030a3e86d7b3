//! Files that are dropped, opened and watched.

use super::{Framing, Viewer};
use crate::files::{Files, Kind, kind};
use crate::load::read_paths;
use crate::state::clock::Clock;
use crate::state::settings::Settings;
use std::path::Path;
use std::sync::Arc;
use std::time::SystemTime;
use windfall_scenes::{PathEntry, Scene, Source, TreeEntry};

/// Seconds between looks at files on disk.
const WATCH: f64 = 1.0;

impl Viewer {
    /// Files that were dropped into the window.
    pub(super) fn take_dropped(&mut self, context: &egui::Context) {
        for file in context.input(|input| input.raw.dropped_files.clone()) {
            match (&file.path, file.bytes) {
                (Some(path), _) => self.open(&path.to_string_lossy(), None),
                (None, Some(bytes)) => self.open(&file.name, Some(bytes)),
                (None, None) => self.say(true, format!("{}: cannot be read", file.name)),
            }
        }
    }

    /// Opens a file: on disk, or bytes under a name. A file that cannot be read changes nothing.
    pub(crate) fn open(&mut self, name: &str, bytes: Option<Arc<[u8]>>) {
        let mut files = self.files.clone();
        let name = match bytes {
            Some(bytes) => {
                files.dropped.insert(name.to_owned(), bytes);
                name.to_owned()
            }
            // Whatever folder the scene is in.
            None => absolute(name),
        };
        if let Err(error) = self.try_open(&name, files) {
            self.say(true, error);
        }
    }

    fn try_open(&mut self, name: &str, files: Files) -> Result<(), String> {
        let kind = kind(name)?;
        let bytes = files.read(name)?;
        let scene = &mut self.settings.scene;
        match kind {
            Kind::Scene => {
                let text = std::str::from_utf8(&bytes).map_err(|e| format!("{name}: {e}"))?;
                let scene = Scene::from_ron(text, name).map_err(|e| e.to_string())?;
                let folder = Path::new(name).parent().unwrap_or(Path::new("")).to_owned();
                let playing = self.clock.playing;
                self.clock = Clock::new(scene.time, scene.frames.1, scene.fps);
                self.clock.playing = playing;
                self.settings = Settings::of(name, scene);
                self.base = self.settings.clone();
                self.files = Files { folder, ..files };
                (self.framing, self.recording) = (Framing::Scene, false);
                return Ok(());
            }
            Kind::Sky => {
                windfall_host::sky::parse(&bytes, name).map_err(|e| format!("{e:#}"))?;
                scene.sky.picture = Some(name.to_owned());
            }
            Kind::Path => {
                let entry = PathEntry::new(name);
                read_paths(&files, &entry)?;
                scene.paths = vec![entry];
            }
            Kind::Gltf if is_path(&files, name, &bytes) => scene.paths = vec![PathEntry::new(name)],
            Kind::Gltf => {
                let entry = TreeEntry::new(Source::File(name.to_owned()));
                if self.adding {
                    scene.trees.push(entry);
                } else {
                    scene.trees = vec![entry];
                    scene.spacing = None;
                    self.framing = Framing::Trees;
                }
            }
        }
        // The same name again is a newer file.
        self.reload |= self.files.dropped.contains_key(name);
        self.files = files;
        Ok(())
    }

    /// Files that the scene is made of, and when they were written.
    pub(super) fn watched_files(&self) -> Vec<(String, Option<SystemTime>)> {
        let scene = &self.settings.scene;
        let trees = scene.trees.iter().filter_map(|tree| match &tree.source {
            Source::File(name) => Some(name),
            Source::Species(_) => None,
        });
        let paths = scene.paths.iter().map(|path| &path.file);
        let names = trees.chain(paths).chain(&scene.sky.picture);
        names.map(|name| (name.clone(), self.files.modified(name))).collect()
    }

    /// Loads again what has changed on disk; `now` is the window's clock.
    pub(super) fn watch(&mut self, now: f64) {
        if now < self.watch_due || self.job.is_some() {
            return;
        }
        self.watch_due = now + WATCH;
        let files = self.watched_files();
        // A file that is being written may be gone for a moment.
        let changed = self
            .watched
            .iter()
            .zip(&files)
            .find(|(old, new)| old.0 == new.0 && old.1 != new.1 && new.1.is_some());
        if let Some((_, (name, _))) = changed {
            let text = format!("{name} has changed: it is loaded again");
            self.watched = files;
            self.reload = true;
            self.say(false, text);
        }
    }
}

/// Whether a glTF is a fall path: it has an animation, and reads as a path.
fn is_path(files: &Files, name: &str, bytes: &[u8]) -> bool {
    let word = b"\"animations\"";
    let animated = bytes.windows(word.len()).any(|window| window == word);
    animated && read_paths(files, &PathEntry::new(name)).is_ok()
}

fn absolute(name: &str) -> String {
    if cfg!(target_arch = "wasm32") {
        return name.to_owned();
    }
    std::path::absolute(name)
        .map_or_else(|_| name.to_owned(), |path| path.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::Start;

    fn viewer() -> Viewer {
        let start = Start::new(Settings::named("lone-oak").unwrap());
        Viewer::waiting(start, Default::default(), web_time::Instant::now())
    }

    fn open(viewer: &mut Viewer, name: &str, bytes: &[u8]) {
        viewer.open(name, Some(Arc::from(bytes)));
    }

    #[test]
    fn a_bad_file_shows_its_error_and_changes_nothing() {
        for (name, bytes) in [
            ("a.hdr", &b"#?RADIANCE\nand no more"[..]),
            ("a.csv", b"t,x\n0,zero\n"),
            ("a.ron", b"(version: 1, season: \"late\")"),
            ("a.ron", b"\xff"),
            ("a.doc", b""),
        ] {
            let mut viewer = viewer();
            let before = viewer.settings.clone();
            open(&mut viewer, name, bytes);
            let [line] = &viewer.lines[..] else { panic!("{name}: {}", viewer.lines.len()) };
            assert!(line.error && line.text.starts_with(name), "{}", line.text);
            assert!(viewer.settings == before && viewer.files.dropped.is_empty(), "{name}");
        }
    }

    #[test]
    fn each_kind_of_file_takes_its_place() {
        let mut viewer = viewer();
        let row = |i: u8| format!("{},0,-{i},0,0,0,0", 0.1 * f64::from(i));
        let rows: Vec<String> =
            std::iter::once("t,x,y,z,rx,ry,rz".to_owned()).chain((0..20).map(row)).collect();
        let path = rows.join("\n");
        open(&mut viewer, "fall.csv", path.as_bytes());
        open(&mut viewer, "mine.glb", b"read by a job");
        viewer.adding = true;
        open(&mut viewer, "other.glb", b"read by a job");
        let scene = &viewer.settings.scene;
        assert_eq!(
            scene.paths.len(),
            1,
            "{:?}",
            viewer.lines.iter().map(|l| &l.text).collect::<Vec<_>>()
        );
        assert_eq!(scene.trees.len(), 2);
        assert!(!viewer.reload && viewer.framing == Framing::Trees);
        viewer.adding = false;
        open(&mut viewer, "other.glb", b"a newer one");
        assert!(viewer.reload, "the scene is the same, the file is not");
        let mut saved = windfall_scenes::named("hillside").unwrap();
        saved.season = 0.9;
        open(&mut viewer, "saved.ron", saved.to_ron().as_bytes());
        assert_eq!(viewer.settings.scene, saved);
        assert_eq!(viewer.base.scene, saved);
    }
}
