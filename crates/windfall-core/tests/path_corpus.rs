//! Replays the corpus of the fuzz target `path_binary`: a path set or an error, never a panic.
#![expect(clippy::unwrap_used, reason = "this is test code")]

use std::path::{Path, PathBuf};
use windfall_core::glam::{Quat, Vec3};
use windfall_core::path::{Analysis, FallPath, Gap, Joint, PathSet, Recording};

fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus/path_binary")
}

#[test]
fn the_corpus_is_read_or_refused() {
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(corpus()).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    let (mut read, mut refused) = (0, 0);
    for path in &files {
        let name = path.file_name().unwrap().to_string_lossy();
        match PathSet::read(&name, &std::fs::read(path).unwrap()) {
            Ok(set) => {
                PathSet::read("again", &set.to_bytes()).unwrap();
                read += 1;
            }
            Err(error) => {
                assert!(error.to_string().starts_with(&*name), "{error}");
                refused += 1;
            }
        }
    }
    assert!(read >= 2 && refused >= 6, "{read} read, {refused} refused");
}

fn path(name: &str, samples: usize) -> FallPath {
    let at = |i: usize| Vec3::new(0.01, -0.02, 0.0) * i as f32;
    let positions = (0..samples).map(at).collect();
    let recording = Recording::new(name, 30.0, positions, vec![Quat::IDENTITY; samples]).unwrap();
    let joint = Joint {
        from: samples as u32 - 2,
        to: 2,
        blend: 2,
        half_turn: 1 << 28,
        raw: Gap::default(),
        blended: Gap::default(),
    };
    FallPath::new(recording, Analysis { starts: vec![0, 1], joints: vec![joint] }).unwrap()
}

/// Writes the seeds anew: `cargo test -p windfall-core --test path_corpus -- --ignored`.
#[test]
#[ignore = "writes files"]
fn write_the_seeds() {
    std::fs::create_dir_all(corpus()).unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(corpus().join(name), bytes).unwrap();
    let valid = PathSet::new(vec![path("glider", 10)]).unwrap().to_bytes();
    write("valid.bin", &valid);
    let two = PathSet::new(vec![path("a", 10), path("b", 8), path("a", 12)]).unwrap();
    write("groups.bin", &two.to_bytes());
    write("empty.bin", b"");
    write("magic.bin", &valid[..8]);
    write("truncated.bin", &valid[..valid.len() / 2]);
    // From the start: magic 8, version 4, count 4, length of the name 4, "glider" 6, rate 4, counts 12, samples.
    let edited = |name: &str, at: usize, with: [u8; 4]| {
        let mut bytes = valid.clone();
        bytes[at..at + 4].copy_from_slice(&with);
        write(name, &bytes);
    };
    edited("version.bin", 8, 2u32.to_le_bytes());
    edited("no-paths.bin", 12, 0u32.to_le_bytes());
    edited("huge-name.bin", 16, u32::MAX.to_le_bytes());
    edited("name-not-utf8.bin", 20, [0xff; 4]);
    edited("rate.bin", 26, f32::NAN.to_le_bytes());
    edited("huge-count.bin", 30, u32::MAX.to_le_bytes());
    edited("poison.bin", 42, f32::INFINITY.to_le_bytes());
    edited("joint.bin", valid.len() - 48, u32::MAX.to_le_bytes());
}
