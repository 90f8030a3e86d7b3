//! Any bytes are a path set in RON or binary form, or an error: `cargo +nightly fuzz run path_ron`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use windfall_flight::{read_paths, to_ron};

fuzz_target!(|bytes: &[u8]| {
    if let Ok(set) = read_paths("fuzz", bytes) {
        // What is read is whole: it can be played, and written and read again.
        assert!(set.tables().samples.iter().all(|s| s.position.iter().all(|x| x.is_finite())));
        let again = read_paths("again", to_ron(&set).as_bytes()).expect("what is written is read");
        assert_eq!(again.groups(), set.groups());
    }
});
