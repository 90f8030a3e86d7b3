//! The HLSL is that of the WGSL.
use naga::back::hlsl;
use naga::valid::{Capabilities, ValidationFlags, Validator};

/// To write them anew after a change of the WGSL: WINDFALL_BLESS=1.
#[test]
fn the_hlsl_is_what_naga_makes_of_the_wgsl() {
    for name in ["windfall_vat", "windfall_paths"] {
        let stem = format!("{}/shaders/{name}", env!("CARGO_MANIFEST_DIR"));
        let wgsl = std::fs::read_to_string(format!("{stem}.wgsl")).unwrap();
        let module = naga::front::wgsl::parse_str(&wgsl).unwrap();
        let info = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module);
        let mut text = format!("// Generated from {name}.wgsl by naga: do not edit.\n\n");
        let (options, pipeline) = (hlsl::Options::default(), hlsl::PipelineOptions::default());
        let mut writer = hlsl::Writer::new(&mut text, &options, &pipeline);
        writer.write(&module, &info.unwrap(), None).unwrap();
        let functions = wgsl.lines().filter_map(|line| line.strip_prefix("fn "));
        for function in functions.filter_map(|line| line.split('(').next()) {
            assert!(text.contains(&format!(" {function}(")), "{function}: {text}");
        }
        let path = format!("{stem}.hlsl");
        if std::env::var_os("WINDFALL_BLESS").is_some() {
            std::fs::write(&path, &text).unwrap();
        }
        assert!(std::fs::read_to_string(&path).unwrap() == text, "{path} is not up to date");
    }
}
