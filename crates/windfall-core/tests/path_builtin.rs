//! The built-in paths: what they promise, and that they are what the command makes.

use windfall_core::flight::presets;
use windfall_core::path::{PathSet, builtin};

/// Writes the asset, for want of the program: `cargo test --test path_builtin -- --ignored`.
#[test]
#[ignore = "writes the asset"]
fn regenerate() {
    let mut paths = Vec::new();
    for preset in &presets::ALL {
        for i in 0..builtin::PER_SPECIES {
            paths.push(builtin::simulate(preset, i).unwrap());
        }
    }
    for p in &paths {
        let a = p.analysis();
        let j = &a.joints[0];
        println!(
            "{:8} descent {:.2} starts {} joints {} raw v {:.3} q {:.3} w {:.3} blended {:?} blend {}",
            p.name(),
            p.descent(),
            a.starts.len(),
            a.joints.len(),
            j.raw.velocity,
            j.raw.orientation,
            j.raw.angular_velocity,
            j.blended,
            j.blend
        );
    }
    let bytes = PathSet::new(paths).unwrap().to_bytes();
    println!("{} bytes", bytes.len());
    std::fs::write(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/paths.bin"), bytes).unwrap();
}
