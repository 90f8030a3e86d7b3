//! The HLSL is that of the WGSL.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

use naga::back::hlsl;
use naga::valid::{Capabilities, ValidationFlags, Validator};

const ABOUT: &str = "// Leaves from vertex animation textures, generated from windfall_vat.wgsl by naga: do not edit.\n\n";

/// To write it anew after a change of the WGSL: WINDFALL_BLESS=1.
#[test]
fn the_hlsl_is_what_naga_makes_of_the_wgsl() {
    let wgsl = include_str!("../shaders/windfall_vat.wgsl");
    let module = naga::front::wgsl::parse_str(wgsl).unwrap();
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module);
    let mut text = ABOUT.to_owned();
    let options = hlsl::Options::default();
    let pipeline = hlsl::PipelineOptions::default();
    hlsl::Writer::new(&mut text, &options, &pipeline).write(&module, &info.unwrap(), None).unwrap();
    for function in ["decode", "frames", "texel", "rotate", "between", "vertex"] {
        assert!(text.contains(&format!(" windfall_{function}(")), "{function}: {text}");
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/windfall_vat.hlsl");
    if std::env::var_os("WINDFALL_BLESS").is_some() {
        std::fs::write(path, &text).unwrap();
    }
    assert!(std::fs::read_to_string(path).unwrap() == text, "{path} is not up to date");
}
