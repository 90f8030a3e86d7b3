//! Any bytes are a picture of the sky, or an error: `cargo +nightly fuzz run sky`.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    for name in ["fuzz.hdr", "fuzz.exr"] {
        let _ = windfall_host::sky::parse(bytes, name);
    }
});
