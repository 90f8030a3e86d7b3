//! Replays the corpus of the fuzz target `scene`, as it is and bent: a scene or an error, never a
//! panic.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

use std::path::{Path, PathBuf};
use windfall_core::rng::Rng;
use windfall_scenes::Scene;

fn corpus() -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus/scene");
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(files.len() >= 20, "the corpus is there");
    let read = |path: PathBuf| {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        (name, std::fs::read(path).unwrap())
    };
    files.into_iter().map(read).collect()
}

/// What the fuzz target does; whether the bytes were a scene.
fn read(name: &str, bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return false };
    match Scene::from_ron(text, name) {
        Ok(scene) => {
            assert_eq!(Scene::from_ron(&scene.to_ron(), "again").as_ref(), Ok(&scene), "{name}");
            assert!(scene.frame_time(u32::MAX).is_finite());
            true
        }
        Err(error) => {
            assert!(error.to_string().starts_with(name), "{error}");
            assert!(error.to_string().len() > name.len() + 8, "no cause: {error}");
            false
        }
    }
}

#[test]
fn the_corpus_is_read_or_refused() {
    let good: Vec<String> =
        corpus().into_iter().filter(|(name, bytes)| read(name, bytes)).map(|f| f.0).collect();
    assert_eq!(good, ["full.ron", "raw-string.ron", "small.ron"]);
}

#[test]
fn bent_scenes_are_read_or_refused() {
    let mut rng = Rng::new(1);
    let corpus = corpus();
    let below = |rng: &mut Rng, end: usize| ((rng.unit() * end as f32) as usize).min(end - 1);
    let mut good = 0;
    for (name, bytes) in corpus.iter().filter(|f| (1..2000).contains(&f.1.len())) {
        for _ in 0..400 {
            let mut bent = bytes.clone();
            let at = below(&mut rng, bent.len());
            match below(&mut rng, 6) {
                0 => bent.truncate(at),
                1 => bent.insert(at, b"0123456789-.e"[below(&mut rng, 13)]),
                // A piece of another scene.
                2 => {
                    let other = &corpus[below(&mut rng, corpus.len())].1;
                    let from = below(&mut rng, other.len().max(1)).min(other.len());
                    let to = (from + 20).min(other.len());
                    bent.splice(at..at, other[from..to].iter().copied());
                }
                3 => bent[at] = b"()[]\",: "[below(&mut rng, 8)],
                // Other numbers, of the same length.
                _ => {
                    for byte in bent.iter_mut().filter(|b| b.is_ascii_digit()).skip(at % 20).take(2)
                    {
                        *byte = b'0' + below(&mut rng, 10) as u8;
                    }
                }
            }
            good += usize::from(read(name, &bent));
        }
    }
    assert!(good > 100, "{good}: bent too far to test what is read");
}
