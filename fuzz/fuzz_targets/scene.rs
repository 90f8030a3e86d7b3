//! Any text is a scene or an error: `cargo +nightly fuzz run scene`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use windfall_scenes::Scene;

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Ok(scene) = Scene::from_ron(text, "fuzz") {
        // What is read is whole: it can be written, and reads back as the same scene.
        assert_eq!(Scene::from_ron(&scene.to_ron(), "again").as_ref(), Ok(&scene));
        assert!(scene.frame_time(u32::MAX).is_finite());
    }
});
