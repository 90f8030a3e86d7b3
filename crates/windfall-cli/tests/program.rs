//! The program as a whole: exit codes, what goes where, help, scenes, trees, completions.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::Place;
use serde_json::Value;

#[test]
fn wrong_usage_ends_with_2() {
    let place = Place::new();
    for arguments in [
        "",
        "paint",
        "render",
        "render small.ron --out a.png --colour red",
        "render small.ron --out a.png --size large",
        "render small.ron --out a.png --trees -1",
        "render small.ron --out a_%d.png --frames 9-3",
        "render small.ron --out a.png --frames 1-1 --time 2",
        "tree export oak",
        "completions tcsh-of-old",
    ] {
        place.fail(2, arguments, &["--help"]);
    }
}

#[test]
fn no_adapter_ends_with_3() {
    let place = Place::new();
    let nowhere = "/nonexistent";
    place.fail_with(
        3,
        "render small.ron --out a.png",
        &[("VK_DRIVER_FILES", nowhere), ("VK_ICD_FILENAMES", nowhere), ("WGPU_BACKEND", "vulkan")],
        &["no graphics adapter", "mesa-vulkan-drivers"],
    );
    place.fail_with(
        3,
        "render small.ron --out a.png",
        &[("WGPU_ADAPTER_NAME", "Voodoo 2")],
        &["Voodoo 2", "there are"],
    );
    place.fail_with(
        3,
        "render small.ron --out a.png",
        &[("WGPU_BACKEND", "gl")],
        &["WGPU_BACKEND=gl", "vulkan, metal, dx12"],
    );
}

#[test]
fn help_opens_with_examples() {
    let place = Place::new();
    let help = place.succeed("--help");
    assert!(help.starts_with("Examples:\n  windfall render"), "{help}");
    assert!(place.succeed("render --help").contains("--frames <A-B>"));
    assert!(place.succeed("--version").starts_with("windfall "));
}

#[test]
fn no_color_wins() {
    let place = Place::new();
    let escape = "\u{1b}[";
    let colored = place.run_with("render", &[("CLICOLOR_FORCE", "1")]);
    assert!(colored.stderr.contains(escape), "{colored:?}");
    let plain = place.run_with("render", &[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")]);
    assert!(!plain.stderr.contains(escape), "{plain:?}");
    let logged = place.run_with(
        "render small.ron --frames 0-2 --out f_%d.png",
        &[("RUST_LOG", "info"), ("NO_COLOR", "1")],
    );
    assert!(logged.stderr.contains("adapter"), "{logged:?}");
    assert!(!logged.stderr.contains('\u{1b}'), "{logged:?}");
    assert_eq!(logged.stdout, "", "the log is no data");
}

#[test]
fn nothing_is_said_where_no_one_looks() {
    // No progress bar without a terminal, no log unless asked.
    let run = Place::new().run("render small.ron --frames 0-2 --out f_%d.png");
    assert_eq!((run.code, run.stdout.as_str(), run.stderr.as_str()), (Some(0), "", ""));
}

#[test]
fn scenes_are_listed_and_printed_as_files() {
    let place = Place::new();
    let list = place.succeed("scenes");
    assert_eq!(list.lines().count(), windfall_scenes::NAMES.len());
    for (line, name) in list.lines().zip(windfall_scenes::NAMES) {
        assert!(line.starts_with(name), "{line}");
        let printed = place.succeed(&format!("scenes {name}"));
        let scene = windfall_scenes::Scene::from_ron(&printed, name).unwrap();
        assert_eq!(Some(scene), windfall_scenes::named(name));
    }
    place.fail(1, "scenes atlantis", &["atlantis"]);
}

#[test]
fn completions_name_the_commands() {
    let place = Place::new();
    for shell in ["bash", "zsh", "fish"] {
        let script = place.succeed(&format!("completions {shell}"));
        assert!(script.contains("windfall") && script.contains("inspect"), "{shell}");
    }
}

#[test]
fn a_tree_is_inspected() {
    let place = Place::new();
    let tree: Value = serde_json::from_str(&place.succeed("tree inspect tiny.glb --json")).unwrap();
    for field in ["leaves", "leaf_triangles", "wood_triangles", "vertices", "height_m", "bytes_gpu"]
    {
        assert!(tree[field].is_number(), "{field}: {tree}");
    }
    assert_eq!(tree["crown_center"].as_array().unwrap().len(), 3);
    assert!(tree["textures"].is_array());
    assert_eq!([&tree["leaves"], &tree["leaf_triangles"], &tree["wood_triangles"]], [2, 4, 2]);
    assert_eq!(tree["height_m"], 3.0);
    let text = place.succeed("tree inspect tiny.glb");
    assert!(text.contains("leaves") && text.contains("height_m"), "{text}");
}

#[test]
fn a_species_is_exported_and_read_back() {
    let place = Place::new();
    assert_eq!(place.succeed("tree export ginkgo --seed 4 --out ginkgo.glb"), "");
    place.succeed("tree export ginkgo --seed 4 --out again.glb");
    assert_eq!(place.read("ginkgo.glb"), place.read("again.glb"));
    let read: Value =
        serde_json::from_str(&place.succeed("tree inspect ginkgo.glb --json")).unwrap();
    assert!(read["leaves"].as_u64().unwrap() > 1000, "{read}");
    assert!((5.0..40.0).contains(&read["height_m"].as_f64().unwrap()), "{read}");
}

#[cfg(unix)]
#[test]
fn a_reader_that_stops_listening_is_no_failure() {
    use std::process::{Command, Stdio};
    let place = Place::new();
    for arguments in [
        &["completions", "bash"][..],
        &["scenes", "autumn"],
        &["tree", "inspect", "tiny.glb", "--json"],
        &["render", "small.ron", "--json", "--out", "a.png"],
    ] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = Command::new(env!("CARGO_BIN_EXE_windfall"))
            .args(arguments)
            .current_dir(place.path(""))
            .env("XDG_RUNTIME_DIR", place.path(""))
            .stdout(writer)
            .stderr(Stdio::piped())
            .output()
            .unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success() && stderr.is_empty(), "{arguments:?}: {stderr}");
    }
}

/// A driver that made shaders anew in every frame grew by 400 MiB in a thousand.
#[test]
fn memory_does_not_grow_with_frames() {
    let place = Place::new();
    place.succeed("bench falling --parts= --soak 300 --soak-leaves 100 --json soak.json");
    let report: Value = serde_json::from_slice(&place.read("soak.json")).unwrap();
    let soak = &report["soak"];
    assert_eq!((&soak["leaves"], &soak["kept"]), (&300.into(), &25.into()));
    if let Some(growth) = soak["growth_mib"].as_array() {
        assert!(growth[0].as_f64().unwrap() < 50.0, "{growth:?}");
    }
}

/// The rows that are off are those that the error counts; each row says what its numbers do.
#[test]
fn verify_fails_where_figures_are_off() {
    let run = Place::new().run("verify --falls 10");
    let (mut off, mut judged) = (0, 0);
    for line in run.stdout.lines() {
        let holds = line.trim_end().ends_with(" ok");
        if !holds && !line.contains(" off by ") {
            continue;
        }
        off += usize::from(!holds);
        // "0.77 ±25%     0.7249  ok"
        let words: Vec<&str> = line.split_whitespace().collect();
        let Some(at) = words.iter().position(|word| word.starts_with('±')) else { continue };
        let number = |word: &str| word.trim_matches(['±', '%']).parse::<f64>().unwrap();
        let [published, tolerance, value] = [at - 1, at, at + 1].map(|i| number(words[i]));
        let apart = (value / published - 1.0).abs() - tolerance / 100.0;
        // Published figures are printed rounded.
        if apart.abs() > 0.02 {
            judged += 1;
            assert_eq!(apart < 0.0, holds, "{line}");
        }
    }
    assert!(judged > 10, "{}", run.stdout);
    let told = format!("{off} figures are outside of their range");
    assert_eq!(run.code, Some(i32::from(off > 0)), "{}", run.stderr);
    assert!(off == 0 || run.stderr.contains(&told), "{off} off: {}", run.stderr);
}
