//! Any bytes are a fall path in JSON or glTF JSON, or an error: `cargo +nightly fuzz run path_json`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use windfall_core::path::PathSet;
use windfall_flight::{ImportOptions, import};

fuzz_target!(|bytes: &[u8]| {
    let text = bytes.trim_ascii_start();
    // The form is told from the first bytes: the other forms have targets of their own.
    if !(text.starts_with(b"{") || text.starts_with(b"[")) {
        return;
    }
    if let Ok(imported) = import("fuzz", bytes, &ImportOptions::default()) {
        // What is read is whole: it can be played.
        let set = PathSet::new(vec![imported.path]).expect("one path is a set");
        assert!(set.tables().samples.iter().all(|s| s.position.iter().all(|x| x.is_finite())));
    }
});
