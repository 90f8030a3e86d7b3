//! A film of the scene: `windfall render` makes it, beside the window.

use crate::state::command;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use windfall_scenes::Scene;

/// Begins a line of progress: percent follow, as render farms read them.
const PROGRESS: &str = "openjd_progress:";

/// A film that is being made. Dropped, it is given up and leaves nothing behind.
pub struct Film {
    child: Child,
    lines: Receiver<String>,
    /// Where the film and its scene are until it is whole.
    folder: tempfile::TempDir,
    ending: &'static str,
    /// The last line that is no progress.
    last: String,
    /// Share of the frames that are done.
    pub share: f32,
}

impl Film {
    /// Begins a film of `scene`, whose files have whole paths: along its path or as long as its own film, with
    /// `size` pixels, into the folder where the program runs. `program` is `windfall`.
    ///
    /// # Errors
    ///
    /// The program does not run, or the folder cannot be written to; in a sentence.
    pub fn begin(program: &Path, scene: &Scene, size: (u32, u32)) -> Result<Self, String> {
        let folder = tempfile::Builder::new().prefix(".windfall-film-").tempdir_in(".");
        let folder = folder.map_err(|error| format!("cannot write here: {error}"))?;
        let file = folder.path().join("scene.ron");
        std::fs::write(&file, scene.to_ron())
            .map_err(|error| format!("cannot write here: {error}"))?;
        let ending = if has_ffmpeg() { "mp4" } else { "apng" };
        let out = folder.path().join("film").with_extension(ending);
        let mut child = Command::new(program)
            .args(command::film_words(scene, &file.to_string_lossy(), &out.to_string_lossy()))
            .args(["--size", &format!("{}x{}", size.0, size.1), "--progress-lines"])
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| format!("{}: {error}", program.display()))?;
        let (send, lines) = channel();
        if let Some(stream) = child.stderr.take() {
            std::thread::spawn(move || {
                for line in BufReader::new(stream).lines().map_while(Result::ok) {
                    if send.send(line).is_err() {
                        break;
                    }
                }
            });
        }
        Ok(Self { child, lines, folder, ending, last: String::new(), share: 0.0 })
    }

    /// The film's file once it is whole, or what went wrong; nothing while it is being made.
    pub fn poll(&mut self) -> Option<Result<String, String>> {
        loop {
            match self.lines.try_recv() {
                Ok(line) => self.read(&line),
                Err(TryRecvError::Empty) => return None,
                // The program has ended, or is about to.
                Err(TryRecvError::Disconnected) => break,
            }
        }
        let ended = self.child.wait().map_err(|error| error.to_string());
        Some(ended.and_then(|status| {
            if status.success() {
                return self.keep();
            }
            Err(format!("no film: {}", self.last.trim_start_matches("error: ")))
        }))
    }

    fn read(&mut self, line: &str) {
        match line.strip_prefix(PROGRESS).map(|percent| percent.trim().parse::<f32>()) {
            Some(Ok(percent)) => self.share = percent / 100.0,
            _ if line.trim().is_empty() || line.starts_with("openjd_") => {}
            _ => line.clone_into(&mut self.last),
        }
    }

    /// Gives the film a name that no file has.
    fn keep(&self) -> Result<String, String> {
        let made = self.folder.path().join("film").with_extension(self.ending);
        let path = crate::app::free_path("film", self.ending)?;
        std::fs::rename(made, &path).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(path.display().to_string())
    }
}

impl Drop for Film {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn has_ffmpeg() -> bool {
    let version =
        Command::new("ffmpeg").arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    version.is_ok_and(|status| status.success())
}

#[cfg(unix)]
#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;
    use std::path::PathBuf;
    use std::time::{Duration, Instant};

    /// A program in place of `windfall`: shell, with the film's file as `$out`.
    fn program(folder: &Path, text: &str) -> PathBuf {
        let path = folder.join("windfall");
        let find = r#"while [ $# -gt 0 ]; do if [ "$1" = --out ]; then out=$2; fi; shift; done"#;
        std::fs::write(&path, format!("#!/bin/sh\n{find}\n{text}\n")).unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        path
    }

    fn ended(film: &mut Film) -> Result<String, String> {
        let begin = Instant::now();
        loop {
            if let Some(result) = film.poll() {
                return result;
            }
            assert!(begin.elapsed() < Duration::from_secs(30));
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    #[test]
    fn a_film_comes_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let scene = windfall_scenes::named("lone-oak").unwrap();
        let begin =
            |text: &str| Film::begin(&program(folder.path(), text), &scene, (64, 36)).unwrap();
        let mut film = begin("echo openjd_progress: 50.0 >&2; echo made >\"$out\"");
        let name = ended(&mut film).unwrap();
        assert_eq!((std::fs::read_to_string(&name).unwrap().as_str(), film.share), ("made\n", 0.5));
        std::fs::remove_file(&name).unwrap();
        let mut film = begin("echo half >\"$out\"; echo error: the tree is gone >&2; exit 1");
        assert_eq!(ended(&mut film).unwrap_err(), "no film: the tree is gone");
        // Given up while it is made.
        let film = begin("echo half >\"$out\"; exec sleep 60");
        let made = film.folder.path().to_owned();
        assert!(made.join("scene.ron").exists());
        drop(film);
        assert!(!made.exists());
        assert!(Film::begin(Path::new("/no/such/program"), &scene, (64, 36)).is_err());
    }
}
