//! Runs the program in a folder of its own.
#![allow(dead_code, reason = "every test file uses a part of it")]

#[path = "../../../windfall-tree/tests/common/mod.rs"]
pub mod model;

use model::Model;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// A small scene of a small tree.
pub const SCENE: &str = r#"(
    version: 1, seed: 3, size: (96, 64), frames: (0, 9), fps: 10, count: 4,
    trees: [(source: File("tiny.glb"), height: Some(6))],
    camera: [
        (time: 0, eye: (0, 2, 16), target: (0, 3, 0)),
        (time: 1, eye: (4, 2, 14), target: (0, 3, 0)),
    ],
)"#;

/// A folder with `tiny.glb` and `small.ron`, where the program runs.
pub struct Place {
    folder: TempDir,
    /// Of the cache, which is never the user's.
    cache: TempDir,
}

/// What a run of the program gave.
#[derive(Debug)]
pub struct Run {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Place {
    pub fn new() -> Self {
        let [folder, cache] = [(); 2].map(|()| tempfile::tempdir().unwrap());
        let place = Self { folder, cache };
        place.write("tiny.glb", Model::tree().glb());
        place.write("small.ron", SCENE);
        place
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), bytes).unwrap();
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// The folder of the program's cache.
    pub fn cache(&self) -> &Path {
        self.cache.path()
    }

    /// Names of all files, hidden ones too, sorted.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<String> =
            entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Runs the program with arguments separated by spaces.
    pub fn run(&self, arguments: &str) -> Run {
        self.run_with(arguments, &[])
    }

    /// Runs the program with more in its environment.
    pub fn run_with(&self, arguments: &str, environment: &[(&str, &str)]) -> Run {
        let output = Command::new(env!("CARGO_BIN_EXE_windfall"))
            .args(arguments.split_whitespace())
            .current_dir(self.folder.path())
            .env("XDG_RUNTIME_DIR", self.folder.path())
            .env("WINDFALL_CACHE_DIR", self.cache.path())
            .env_remove("RUST_LOG")
            .env_remove("NO_COLOR")
            .env_remove("CLICOLOR_FORCE")
            .envs(environment.iter().copied())
            .output()
            .unwrap();
        let run = Run {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        };
        assert!(!run.stderr.contains("panicked"), "{arguments}: {run:?}");
        run
    }

    /// Runs the program, which must succeed; its standard output.
    pub fn succeed(&self, arguments: &str) -> String {
        let run = self.run(arguments);
        assert_eq!(run.code, Some(0), "{arguments}: {run:?}");
        run.stdout
    }

    /// Runs the program, which must fail with this code, print nothing on standard output, say all
    /// of `words` on standard error, and leave no file; the message.
    pub fn fail(&self, code: i32, arguments: &str, words: &[&str]) -> String {
        self.fail_with(code, arguments, &[], words)
    }

    /// [`Self::fail`] with more in the environment.
    pub fn fail_with(
        &self,
        code: i32,
        arguments: &str,
        environment: &[(&str, &str)],
        words: &[&str],
    ) -> String {
        let before = self.files();
        let run = self.run_with(arguments, environment);
        assert_eq!(run.code, Some(code), "{arguments}: {run:?}");
        assert_eq!(run.stdout, "", "{arguments}");
        for word in words {
            assert!(run.stderr.contains(word), "{arguments}: no {word:?} in {}", run.stderr);
        }
        assert_eq!(self.files(), before, "{arguments} left a file");
        run.stderr
    }
}
