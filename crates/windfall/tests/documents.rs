//! The documents at the root say what is there.

use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn read(name: &str) -> String {
    std::fs::read_to_string(root().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

#[test]
fn the_architecture_names_every_dependency_and_room() {
    let (manifest, text) = (read("Cargo.toml"), read("ARCHITECTURE.md"));
    let table = manifest.split("[workspace.dependencies]").nth(1).unwrap();
    let table = table.split("\n[").next().unwrap();
    let names = table.lines().filter_map(|line| line.split_once(" = ")).map(|(name, _)| name);
    let missing: Vec<&str> =
        names.clone().filter(|name| !text.contains(&format!("{name}`"))).collect();
    assert!(names.count() > 20, "the table was found");
    assert!(missing.is_empty(), "not in ARCHITECTURE.md: {missing:?}");
    for entry in std::fs::read_dir(root().join("crates")).unwrap() {
        let room = format!("`crates/{}`", entry.unwrap().file_name().to_string_lossy());
        assert!(text.contains(&room), "{room} is not in ARCHITECTURE.md");
    }
}

#[test]
fn the_readme_links_to_files_that_exist() {
    let text = read("README.md");
    let links: Vec<&str> = text
        .split("](")
        .skip(1)
        .filter_map(|rest| rest.split(')').next())
        .filter(|link| !link.starts_with("http") && !link.starts_with('#'))
        .collect();
    assert!(links.len() >= 5, "{links:?}");
    for link in links {
        assert!(root().join(link).exists(), "README.md: {link}");
    }
}

#[test]
fn every_code_of_a_note_has_its_advice() {
    let text = read("docs/notes.md");
    for code in windfall_core::NoteCode::ALL {
        let row = text.lines().find(|line| line.starts_with(&format!("| `{code}` |")));
        let cells = row.unwrap_or_else(|| panic!("{code} is not in docs/notes.md")).split('|');
        assert!(cells.filter(|cell| cell.trim().len() > 5).count() >= 3, "{code} has no advice");
    }
    let rows = text.lines().filter(|line| line.starts_with("| `")).count();
    assert_eq!(rows, windfall_core::NoteCode::ALL.len(), "codes that there are not");
}

#[test]
fn the_scene_in_the_documents_reads() {
    // Indented by four, from the line "(" to the line ")".
    let text = read("docs/scenes.md");
    let scene = text.split("\n    (\n").nth(1).and_then(|t| t.split("\n    )\n").next()).unwrap();
    windfall_scenes::Scene::from_ron(&format!("(\n{scene}\n)"), "docs/scenes.md").unwrap();
}
