//! The modules of this crate import each other downwards only: no circle, whatever is added.
#![expect(clippy::unwrap_used, reason = "this is test code")]

use std::collections::BTreeSet;
use std::path::Path;

/// From the bottom up, as in the table of `lib.rs`.
const LAYERS: [&str; 13] = [
    "error", "note", "rng", "wind", "sway", "light", "forest", "shed", "material", "foliage",
    "path", "simplify", "tree",
];

/// All code of a module, its unit tests included, comments left out.
fn code(path: &Path) -> String {
    if path.is_dir() {
        let entries = std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path());
        return entries.map(|path| code(&path)).collect();
    }
    let text = std::fs::read_to_string(path).unwrap();
    let code = |line: &&str| !line.trim_start().starts_with("//");
    text.lines().filter(code).flat_map(|line| [line, "\n"]).collect()
}

#[test]
fn modules_import_only_what_is_below_them() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let found: BTreeSet<String> = std::fs::read_dir(&src)
        .unwrap()
        .map(|entry| entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
        .filter(|name| name != "lib")
        .collect();
    assert_eq!(found, LAYERS.iter().map(ToString::to_string).collect(), "every module has a layer");
    for (i, module) in LAYERS.iter().enumerate() {
        let file = src.join(format!("{module}.rs"));
        let code = code(&if file.is_file() { file } else { src.join(module) });
        for (at, _) in code.match_indices("crate::") {
            let rest = &code[at + "crate::".len()..];
            let name: String =
                rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            // `crate::{…}` and what `lib.rs` re-exports would hide an import from this test.
            let layer = LAYERS.iter().position(|layer| *layer == name);
            assert!(layer.is_some_and(|layer| layer <= i), "{module} imports crate::{name}");
        }
    }
}
