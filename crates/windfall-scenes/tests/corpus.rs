//! Replays the corpus of the fuzz target `scene`, as it is and bent: a scene or an error, never a
//! panic.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

use std::path::{Path, PathBuf};
use windfall_core::rng::Rng;
use windfall_core::simplify::{
    Fade, FadeBy, FadeRange, Growth, PruneOrder, Reduction, Simplification,
};
use windfall_scenes::{
    Culling, Elimination, QualityPreset, Scene, Strategy, TimeUnit, VariationEntry,
};
use windfall_tree::Up;

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
    let expected = [
        "escaped-culling.ron",
        "every-option.ron",
        "full.ron",
        "old-detail.ron",
        "raw-string.ron",
        "small.ron",
    ];
    assert_eq!(good, expected);
}

fn scene(file: &str) -> Scene {
    let (_, bytes) = corpus().into_iter().find(|(name, _)| name == file).unwrap();
    Scene::from_ron(std::str::from_utf8(&bytes).unwrap(), file).unwrap()
}

#[test]
fn every_option_is_read_as_it_stands_in_the_file() {
    let scene = scene("every-option.ron");
    assert_eq!(scene.strategy, Strategy::VertexBuffer);
    assert_eq!(scene.prune_order, PruneOrder::Importance);
    assert_eq!(scene.elimination, Elimination::Progressive);
    assert_eq!((scene.elimination_per_frame, scene.leaf_occlusion), (12, true));
    assert_eq!((scene.culling, scene.quality), (Culling::ClipSpace, QualityPreset::Low));
    assert_eq!((scene.time, scene.events[0].time), (864_000.001, 864_000.002));
    assert_eq!(scene.keep_out[0].from, (-99_999.000_1, 1.0));
    assert_eq!(scene.camera[0].eye, (99_999.000_2, 1.0, 2.0));
    assert_eq!(scene.camera[0].target, (3.0, 4.0, 99_999.000_3));
    assert_eq!((scene.trees[0].up, scene.trees[0].unit), (Up::Z, Some(0.5)));
    assert_eq!(
        (scene.paths[0].time_unit, scene.paths[0].fps),
        (TimeUnit::Milliseconds, Some(24.0))
    );
    assert_eq!((scene.variation, scene.fall.settle_turn), (VariationEntry::Paper(2007), 90.0));
    let detail = Simplification {
        reduction: Reduction::ProjectedArea { b0: 900.0 },
        h: 0.7,
        area_preservation: false,
        growth: Growth { factor: f32::INFINITY, pixels: 3.0 },
        color_contrast: false,
        shading_contrast: false,
        mean_cosine: Some(0.63),
        contrast_pixels: None,
        fade: Fade {
            by: FadeBy::Opacity,
            range: FadeRange::Quadratic(0.1),
            full_at_one: false,
            early: true,
            smooth: true,
        },
        wood_pixels: 2.0,
        leaf_pixels: 9.0,
    };
    assert_eq!(scene.detail, detail);
    let shadow_detail = Simplification {
        reduction: Reduction::Distance { d0: 12.0 },
        h: 0.6,
        growth: Growth { factor: 1.75, pixels: f32::INFINITY },
        mean_cosine: Some(0.5),
        contrast_pixels: Some(2.0),
        fade: Fade { range: FadeRange::Constant(0.1), ..detail.fade },
        wood_pixels: 0.0,
        leaf_pixels: 6.0,
        ..detail
    };
    assert_eq!(scene.shadow_detail, shadow_detail);
}

/// An option that is new has to be in `every-option.ron`, with another value than by default.
#[test]
fn every_option_survives_writing_and_reading() {
    let every = scene("every-option.ron");
    let written = every.to_ron();
    assert_eq!(Scene::from_ron(&written, "again"), Ok(every));
    // Nor is any of its values what a scene has that leaves it out.
    let by_default = scene("small.ron").to_ron();
    let values = |text: &str| -> Vec<String> {
        let value = |line: &&str| line.contains(": ") && !line.ends_with(['(', '[']);
        text.lines().filter(value).map(str::to_owned).collect()
    };
    let by_default = values(&by_default);
    let values = values(&written);
    assert!(values.len() > 80, "{written}");
    let same: Vec<&String> = values.iter().filter(|line| by_default.contains(line)).collect();
    assert_eq!(same, ["    version: 1,"]);
}

/// Files that were written before the options had their present types.
#[test]
fn old_spellings_are_read() {
    let old = scene("old-detail.ron");
    let reduction = Reduction::ProjectedArea { b0: 900.0 };
    let growth = Growth { factor: f32::INFINITY, ..Growth::default() };
    let fade = Fade { range: FadeRange::Constant(0.1), ..Fade::default() };
    assert_eq!(old.detail, Simplification { reduction, growth, fade, ..Simplification::DEFAULT });
    let escaped = scene("escaped-culling.ron");
    assert_eq!((escaped.culling, escaped.quality), (Culling::Sphere, QualityPreset::Medium));
}

#[test]
fn bent_scenes_are_read_or_refused() {
    let mut rng = Rng::new(1);
    let corpus = corpus();
    let below = |rng: &mut Rng, end: usize| ((rng.unit() * end as f32) as usize).min(end - 1);
    let mut good = 0;
    for (name, bytes) in corpus.iter().filter(|f| (1..3000).contains(&f.1.len())) {
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
