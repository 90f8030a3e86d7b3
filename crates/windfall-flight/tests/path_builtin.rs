//! The built-in paths are what the command makes.

use windfall_core::path::{Analysis, PathSet, analysis};
use windfall_flight::{analyse, builtin, presets};

/// Writes the asset without the program: `cargo test --release -p windfall-flight --test path_builtin -- --ignored`.
#[test]
#[ignore = "writes the asset"]
fn regenerate() {
    let mut paths = Vec::new();
    for preset in &presets::ALL {
        for i in 0..builtin::PER_SPECIES {
            paths.push(builtin::simulate(preset, i).unwrap());
        }
    }
    let bytes = PathSet::new(paths).unwrap().to_bytes();
    println!("{} bytes", bytes.len());
    std::fs::write(
        concat!(env!("CARGO_MANIFEST_DIR"), "/../windfall-core/assets/paths.bin"),
        bytes,
    )
    .unwrap();
}

#[test]
fn every_preset_has_its_paths() {
    let set = PathSet::builtin();
    for preset in &presets::ALL {
        let group = set.group(preset.name).unwrap();
        assert_eq!(set.tables().groups[group as usize][1], builtin::PER_SPECIES);
    }
}

/// Simulates one path again. Its beginning must be the asset's to a micrometre or two; later the
/// last digits of another processor's sines may have grown, for falls are chaotic.
#[test]
fn the_asset_is_what_the_command_makes() {
    let set = PathSet::builtin();
    let preset = presets::find("samara").unwrap();
    let again = builtin::simulate(preset, 0).unwrap();
    let stored =
        &set.paths()[set.tables().groups[set.group("samara").unwrap() as usize][0] as usize];
    assert_eq!(stored.rate(), again.rate());
    assert_eq!(stored.positions().len(), again.positions().len());
    for i in 0..60 {
        assert!((stored.positions()[i] - again.positions()[i]).length() < 1e-4, "sample {i}");
        assert!(analysis::angle(stored.orientations()[i], again.orientations()[i]) < 1e-3);
    }
}

/// The stored orientations are rounded, so joints that match about as well as others may be others; what holds is
/// that the stored analysis is as good as a new one.
#[test]
fn the_asset_is_analysed_as_paths_are_today() {
    for path in PathSet::builtin().paths() {
        let again = analyse(path.recording()).unwrap();
        let stored = path.analysis();
        let worst = |a: &Analysis| a.joints.iter().map(|j| j.raw.velocity).fold(0.0, f32::max);
        assert!(worst(&again) < worst(stored) + 0.1, "{}: {again:?}", path.name());
        assert_eq!(again.joints.len(), stored.joints.len(), "{}", path.name());
    }
}
