//! Baked trees, and the cache of trees: the same pictures, whatever a tree comes from.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::model::{Model, png};
use common::{Place, SCENE};
use serde_json::{Value, json};
use std::process::Command;

/// A tree with a picture and something to note.
fn noted() -> Vec<u8> {
    let mut model = Model::tree();
    model.texture(&png());
    model.json["animations"] = json!([{}]);
    model.glb()
}

fn object(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// The names of the cache's trees.
fn cached(place: &Place) -> Vec<String> {
    let names = std::fs::read_dir(place.cache()).unwrap();
    let mut names: Vec<String> =
        names.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_baked_tree_draws_the_picture_of_its_source() {
    let place = Place::new();
    place.write("tiny.glb", noted());
    let baked = place.run("bake tiny.glb --height 6 --out tiny.baked.glb --json");
    assert_eq!(baked.code, Some(0), "{baked:?}");
    assert!(baked.stderr.contains("note[animation-left-out]: tiny.glb: "), "{}", baked.stderr);
    let report = object(&baked.stdout);
    assert_eq!((&report["leaves"], &report["verified"]), (&json!(2), &Value::Null));
    assert_eq!(report["bytes"], place.read("tiny.baked.glb").len());
    // In a scene, which asks for the height too, and on the command line; no cache helps.
    place.write("baked.ron", SCENE.replace("tiny.glb", "tiny.baked.glb"));
    for (name, of_source, of_baked) in [
        ("scene", "small.ron", "baked.ron"),
        ("tree", "small.ron --tree tiny.glb --height 6", "small.ron --tree tiny.baked.glb"),
        ("order", "small.ron --prune-order random", "baked.ron --prune-order random"),
    ] {
        place.succeed(&format!("render {of_source} --no-cache --falling 9 --out a-{name}.png"));
        place.succeed(&format!("render {of_baked} --no-cache --falling 9 --out b-{name}.png"));
        let [a, b] = ["a", "b"].map(|which| place.read(&format!("{which}-{name}.png")));
        assert!(a == b, "{name}");
    }
    assert_eq!(cached(&place), [""; 0]);
    for scene in ["small", "baked"] {
        place.succeed(&format!("export {scene}.ron --frames 0-2 --out {scene}.csv"));
    }
    assert_eq!(place.read("small.csv"), place.read("baked.csv"));
    // Its notes come back under its own name.
    let inspected = place.run("tree inspect tiny.baked.glb --json");
    assert!(
        inspected.stderr.contains("note[animation-left-out]: tiny.baked.glb: "),
        "{inspected:?}"
    );
    let inspected = object(&inspected.stdout);
    assert_eq!(inspected["baked"]["source"], report["source"]);
    assert_eq!(inspected["baked"]["prune_order"], "blue-noise");
    assert!((inspected["height_m"].as_f64().unwrap() - 6.0).abs() < 1e-3);
    assert!(place.succeed("tree inspect tiny.baked.glb").contains("baked"));
    assert!(!place.succeed("tree inspect tiny.glb").contains("baked"));
    place.succeed("simplify tiny.baked.glb --lambda 0.5 --out half.glb");
    place.fail(
        1,
        "tree inspect tiny.baked.glb --up z",
        &["tiny.baked.glb: up: ", "is a baked tree"],
    );
}

#[test]
fn baking_is_verified_against_the_file_that_is_there() {
    let place = Place::new();
    std::fs::create_dir(place.path("other")).unwrap();
    place.succeed("bake tiny.glb --out a.glb");
    // The folder of the source is no part of it.
    place.write("other/tiny.glb", Model::tree().glb());
    assert!(
        place.run("bake other/tiny.glb --out a.glb --verify").stderr.contains("is what the source")
    );
    let fresh = object(&place.succeed("bake tiny.glb --verify --out b.glb --json"));
    assert_eq!(fresh["verified"], true);
    assert!(place.read("a.glb") == place.read("b.glb"));
    let before = place.read("a.glb");
    let fails = |arguments: &str, words: &[&str]| place.fail(1, arguments, words);
    fails("bake tiny.glb --height 9 --out a.glb --verify", &["a.glb: ", "other options"]);
    fails("bake birch --out a.glb --verify", &["a.glb: ", "another source"]);
    let mut damaged = before.clone();
    let last = damaged.len() - 5;
    damaged[last] ^= 1;
    place.write("a.glb", &damaged);
    fails("bake tiny.glb --out a.glb --verify", &["a.glb: ", "damaged"]);
    assert!(place.read("a.glb") == damaged, "it stays");
    // As a program would have baked it that names trees otherwise.
    let mut named = before;
    while let Some(at) = named.windows(8).position(|word| word == b"tiny.glb") {
        named[at] = b'T';
    }
    windfall_tree::bake::reseal(&mut named);
    place.write("a.glb", &named);
    fails("bake tiny.glb --out a.glb --verify", &["a.glb: is of this source", "another version"]);
    fails("bake tiny.glb --out tiny.glb", &["the file that is read"]);
    fails("bake tiny.glb --out a.png", &["is not a .glb file"]);
    fails("bake tiny.glb --out other", &["is a folder"]);
    fails("bake gone.glb --out c.glb", &["gone.glb: cannot be read"]);
    fails("bake tiny.glb --up z --height 0 --out c.glb", &["--height 0"]);
}

#[test]
fn a_tree_from_the_cache_is_the_tree() {
    let place = Place::new();
    place.write("tiny.glb", noted());
    let info = [("RUST_LOG", "info")];
    let render = |options: &str, out: &str| {
        let run = place.run_with(
            &format!("render small.ron --tree tiny.glb --tree aspen --size 48x32 {options} --json --out {out}"),
            &info,
        );
        assert_eq!(run.code, Some(0), "{run:?}");
        // The notes are shown and listed each time.
        assert!(run.stderr.contains("note[animation-left-out]: "), "{}", run.stderr);
        assert_eq!(object(&run.stdout)["notes"].as_array().unwrap().len(), 1, "{run:?}");
        let said = |text: &str| run.stderr.matches(text).count();
        (place.read(out), said("baked a tree into the cache"), said("a baked tree from the cache"))
    };
    let none = render("--no-cache", "none.png");
    assert_eq!((none.1, none.2, cached(&place).len()), (0, 0, 0));
    // A file, and two variants of a species.
    let cold = render("", "cold.png");
    assert_eq!((cold.1, cold.2, cached(&place).len()), (3, 0, 3));
    let warm = render("", "warm.png");
    assert_eq!((warm.1, warm.2), (0, 3));
    assert!(none.0 == cold.0 && cold.0 == warm.0);
    // Other options, and other bytes, are other trees.
    assert_eq!(render("--height 7", "height.png").1, 3);
    place.write("tiny.glb", [noted(), b"\n".to_vec()].concat());
    let changed = render("", "changed.png");
    assert_eq!((changed.1, changed.2), (1, 2));
    assert!(changed.0 == cold.0);
    // Damaged, it is baked again.
    for name in cached(&place) {
        std::fs::write(place.cache().join(name), b"glTF").unwrap();
    }
    let mended = render("", "mended.png");
    assert_eq!((mended.1, mended.2), (3, 0));
    assert!(mended.0 == cold.0);
}

#[test]
fn the_cache_is_shown_and_cleared() {
    let place = Place::new();
    std::fs::remove_dir(place.cache()).unwrap();
    let shown = object(&place.succeed("cache --json"));
    assert_eq!(shown["folder"].as_str().unwrap(), place.cache().to_str().unwrap());
    assert_eq!((&shown["bytes"], &shown["trees"]), (&json!(0), &json!([])));
    place.succeed("simplify tiny.glb --lambda 1 --out a.glb");
    std::fs::write(place.cache().join("mine.glb"), b"mine").unwrap();
    let shown = object(&place.succeed("cache --json"));
    assert_eq!(shown["trees"].as_array().unwrap().len(), 1);
    assert_eq!(shown["bytes"], shown["trees"][0]["bytes"]);
    let text = place.succeed("cache");
    assert!(text.contains("trees   1") && text.contains("of at most 1073.7 MB"), "{text}");
    assert!(place.succeed("cache clear").starts_with("removed 1 trees"));
    assert_eq!(cached(&place), ["mine.glb"]);
    let cleared = object(&place.succeed("cache clear --json"));
    assert_eq!(cleared["removed"]["trees"], 0);
}

#[test]
fn two_programs_that_bake_the_same_tree_leave_one_good_file() {
    let place = Place::new();
    place.succeed("simplify birch --lambda 1 --no-cache --out alone.glb");
    let start = |out: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_windfall"));
        command.args(["simplify", "birch", "--lambda", "1", "--out", out]);
        command.current_dir(place.path(".")).env("WINDFALL_CACHE_DIR", place.cache());
        command.spawn().unwrap()
    };
    let programs = ["a.glb", "b.glb", "c.glb"].map(start);
    for mut program in programs {
        assert!(program.wait().unwrap().success());
    }
    assert_eq!(cached(&place).len(), 1, "one tree, and no temporary file");
    let used = place.run_with("simplify birch --lambda 1 --out d.glb", &[("RUST_LOG", "info")]);
    assert!(used.stderr.contains("a baked tree from the cache"), "{}", used.stderr);
    for name in ["a.glb", "b.glb", "c.glb", "d.glb"] {
        assert!(place.read(name) == place.read("alone.glb"), "{name}");
    }
}

#[test]
fn a_cache_that_cannot_be_written_costs_a_warning_and_not_the_picture() {
    let place = Place::new();
    let render = "render small.ron --tree aspen --tree birch --size 48x32";
    place.succeed(&format!("{render} --no-cache --out good.png"));
    let good = place.read("good.png");
    let warned = |stderr: &str| stderr.matches("the tree cache is not used").count();
    // A folder that cannot be made.
    let folder = place.path("small.ron").join("trees");
    let folder = [("WINDFALL_CACHE_DIR", folder.to_str().unwrap())];
    let run = place.run_with(&format!("{render} --out a.png"), &folder);
    assert_eq!((run.code, warned(&run.stderr)), (Some(0), 1), "{run:?}");
    assert!(place.read("a.png") == good);
    assert!(!run.stderr.contains("which cannot be read"), "{run:?}");
    let run = place.run_with("cache", &folder);
    assert_eq!(run.code, Some(1), "{run:?}");
    // No room: files may have 64 blocks of 512 or 1024 bytes, which the picture takes and no tree does.
    if cfg!(unix) {
        let script = format!("trap '' XFSZ; ulimit -f 64; exec \"$0\" {render} --out b.png");
        let output = Command::new("sh")
            .args(["-c", &script, env!("CARGO_BIN_EXE_windfall")])
            .current_dir(place.path("."))
            .env("XDG_RUNTIME_DIR", place.path("."))
            .env("WINDFALL_CACHE_DIR", place.cache())
            .env_remove("RUST_LOG")
            .output()
            .unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{stderr}");
        assert_eq!(warned(&stderr), 1, "{stderr}");
        assert!(place.read("b.png") == good);
        assert_eq!(cached(&place), [""; 0], "nothing half written stays");
    }
}
