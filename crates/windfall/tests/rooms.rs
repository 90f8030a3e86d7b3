//! Dependencies point one way: between the crates, and between the folders of the renderer.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The crates, each of which may use those before it. Tests may use any.
const CRATES: [&str; 12] = [
    "windfall-core",
    "windfall-tree",
    "windfall-flight",
    "windfall-export",
    "windfall-gpu",
    "windfall-papers",
    "windfall",
    "windfall-scenes",
    "windfall-host",
    "windfall-viewer",
    "windfall-bench",
    "windfall-cli",
];
/// Pairs that the order would allow and that are not wanted.
const APART: [(&str, &str); 13] = [
    ("windfall-flight", "windfall-tree"),
    ("windfall-export", "windfall-tree"),
    ("windfall-export", "windfall-flight"),
    ("windfall-gpu", "windfall-tree"),
    ("windfall-gpu", "windfall-flight"),
    ("windfall-gpu", "windfall-export"),
    ("windfall-papers", "windfall-export"),
    ("windfall", "windfall-export"),
    ("windfall-papers", "windfall-tree"),
    ("windfall-papers", "windfall-flight"),
    ("windfall-scenes", "windfall"),
    ("windfall-viewer", "windfall"),
    ("windfall-bench", "windfall-viewer"),
];
/// The rooms of the renderer, each of which may use those before it. The pass that a file of the last two is of
/// comes first.
const ROOMS: [&str; 6] = ["base", "scene", "view", "pass", "renderer", "frame"];

fn crates() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

/// Dependencies of a manifest on the workspace's crates, without those of its tests.
fn dependencies(manifest: &str) -> BTreeSet<String> {
    let mut section = "";
    let mut found = BTreeSet::new();
    for line in manifest.lines() {
        if line.starts_with('[') {
            section = line;
        }
        let of_tests = section.contains("dev-dependencies");
        let name = line.split(['.', '=', ' ']).next().unwrap_or("");
        if section.contains("dependencies") && !of_tests && name.starts_with("windfall") {
            found.insert(name.to_owned());
        }
    }
    found
}

#[test]
fn crates_use_only_those_before_them() {
    let mut wrong = Vec::new();
    let place = |name: &str| CRATES.iter().position(|c| *c == name);
    for entry in std::fs::read_dir(crates()).unwrap() {
        let folder = entry.unwrap().path();
        let name = folder.file_name().unwrap().to_string_lossy().into_owned();
        if name == "windfall-testing" {
            continue;
        }
        let manifest = std::fs::read_to_string(folder.join("Cargo.toml")).unwrap();
        let Some(at) = place(&name) else {
            wrong.push(format!("{name} is not in the list of this test"));
            continue;
        };
        for dependency in dependencies(&manifest) {
            let before = place(&dependency).is_some_and(|place| place < at);
            if !before || APART.contains(&(name.as_str(), dependency.as_str())) {
                wrong.push(format!("{name} uses {dependency}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Rooms that a source names in `crate::room::` or `use super::super::room`.
fn named(source: &str) -> BTreeSet<&'static str> {
    let code: String = source
        .split("#[cfg(test)]\nmod tests {")
        .next()
        .unwrap_or("")
        .lines()
        .map(|line| line.split("//").next().unwrap_or(""))
        .collect::<Vec<_>>()
        .join("\n");
    ROOMS.into_iter().filter(|room| code.contains(&format!("crate::{room}::"))).collect()
}

fn sources(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, into);
        } else if path.extension().is_some_and(|e| e == "rs") {
            into.push(path);
        }
    }
}

#[test]
fn rooms_of_the_renderer_use_only_those_before_them() {
    let source = crates().join("windfall-gpu/src");
    let mut files = Vec::new();
    sources(&source, &mut files);
    let mut wrong = Vec::new();
    let mut seen: BTreeMap<usize, u32> = BTreeMap::new();
    for file in files {
        let inside = file.strip_prefix(&source).unwrap();
        let room = inside.iter().next().unwrap().to_string_lossy();
        let room = room.trim_end_matches(".rs");
        // Tests of passes draw whole frames; the list of the interface and of counts names all.
        if inside.starts_with("pass/tests") || ["lib", "internals", "counts"].contains(&room) {
            continue;
        }
        let at = ROOMS.iter().position(|r| *r == room);
        let at = at.unwrap_or_else(|| panic!("{room} is not in the list of this test"));
        *seen.entry(at).or_default() += 1;
        for used in named(&std::fs::read_to_string(&file).unwrap()) {
            let upward = ROOMS.iter().position(|r| *r == used).unwrap() > at;
            if upward {
                wrong.push(format!("{} uses {used}", inside.display()));
            }
        }
    }
    assert_eq!(seen.len(), ROOMS.len(), "every room has files: {seen:?}");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn what_points_upward_is_found() {
    assert_eq!(
        named("use crate::pass::wood;\n// crate::frame::x").into_iter().next(),
        Some("pass")
    );
    assert!(named("#[cfg(test)]\nmod tests {\nuse crate::frame::X;").is_empty());
    let manifest = "[dependencies]\nwindfall-gpu.workspace = true\nwindfall-tree = { path = \"x\" }\n\
                    [dev-dependencies]\nwindfall-scenes.workspace = true\n";
    let found: Vec<String> = dependencies(manifest).into_iter().collect();
    assert_eq!(found, ["windfall-gpu", "windfall-tree"]);
}
