//! Any bytes are a binary path set or an error: `cargo +nightly fuzz run path_binary`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use windfall_core::path::PathSet;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(set) = PathSet::read("fuzz", bytes) {
        // What is read is whole: it can be played, and written and read again.
        assert!(set.tables().samples.iter().all(|s| s.position.iter().all(|x| x.is_finite())));
        let again = PathSet::read("again", &set.to_bytes()).expect("what is written is read");
        assert_eq!(again.groups(), set.groups());
    }
});
