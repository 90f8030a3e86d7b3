//! Bad input: an error that names the file, the place and the cause, status 1, no panic, no output.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::model::{Model, png};
use common::{Place, SCENE};
use serde_json::json;

#[test]
fn bad_tree_files_are_named_with_the_cause() {
    let place = Place::new();
    let valid = Model::tree().glb();
    place.write("empty.glb", "");
    place.write("garbage.glb", [0x5a; 300]);
    place.write("truncated.glb", &valid[..valid.len() / 2]);
    std::fs::create_dir(place.path("folder.glb")).unwrap();
    let edited = |name: &str, edit: &dyn Fn(&mut Model)| {
        let mut model = Model::tree();
        edit(&mut model);
        place.write(name, model.glb());
    };
    edited("no-buffer.glb", &|m| m.json["buffers"][0]["uri"] = json!("gone.bin"));
    edited("no-image.glb", &|m| {
        m.texture(&png());
        m.json["images"] = json!([{ "uri": "gone.png" }]);
    });
    edited("outside.glb", &|m| {
        // The second accessor is the trunk's index list; its first index follows four positions.
        m.binary[48..50].copy_from_slice(&999_u16.to_le_bytes());
    });
    edited("nan.glb", &|m| m.binary[0..4].copy_from_slice(&f32::NAN.to_le_bytes()));
    edited("infinite.glb", &|m| m.binary[0..4].copy_from_slice(&f32::INFINITY.to_le_bytes()));
    edited("no-triangles.glb", &|m| {
        for mesh in 0..2 {
            m.json["meshes"][mesh]["primitives"][0]["mode"] = json!(0);
        }
    });
    edited("no-leaves.glb", &|m| {
        m.json["nodes"][2]["name"] = json!("canopy");
        m.json["meshes"][1]["name"] = json!("canopy");
    });
    edited("extension.glb", &|m| {
        m.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    });
    let cases: [(&str, &[&str]); 13] = [
        ("empty.glb", &["empty"]),
        ("garbage.glb", &[]),
        ("truncated.glb", &[]),
        ("folder.glb", &["folder"]),
        ("missing.glb", &["cannot be read"]),
        ("no-buffer.glb", &["gone.bin"]),
        ("no-image.glb", &["gone.png"]),
        ("outside.glb", &["999"]),
        ("nan.glb", &["NaN"]),
        ("infinite.glb", &["inf"]),
        ("no-triangles.glb", &["triangle"]),
        ("no-leaves.glb", &["canopy", "--leaves"]),
        ("extension.glb", &["KHR_draco_mesh_compression"]),
    ];
    for (file, words) in cases {
        let words = [&[file], words].concat();
        place.fail(1, &format!("tree inspect {file}"), &words);
        place.fail(1, &format!("tree inspect {file} --json"), &words);
        place.fail(1, &format!("render small.ron --tree {file} --out out.png"), &words);
        place.write("bad.ron", SCENE.replace("tiny.glb", file));
        place.fail(1, "render bad.ron --frames 0-3 --out out.gif", &words);
        std::fs::remove_file(place.path("bad.ron")).unwrap();
    }
    // The way out that the error names.
    place.succeed("tree inspect no-leaves.glb --leaves canopy");
}

#[test]
fn bad_scene_files_are_named_with_the_place() {
    let place = Place::new();
    place.write("empty.ron", "");
    place.write("garbage.ron", [0xff, 0xfe, 0x00, 0x9c]);
    std::fs::create_dir(place.path("folder.ron")).unwrap();
    place.write("unknown.ron", SCENE.replace("count: 4", "count: 4, clouds: 3"));
    place.write("version.ron", SCENE.replace("version: 1", "version: 9"));
    place.write("nan.ron", SCENE.replace("fps: 10", "fps: NaN"));
    place.write("species.ron", SCENE.replace("File(\"tiny.glb\")", "Species(\"pine\")"));
    place.write("truncated.ron", &SCENE[..SCENE.len() / 2]);
    let event = "count: 4, events: [(tree: 1, leaf: 0, time: 1), (tree: 4, leaf: 0, time: 1)]";
    place.write("event.ron", SCENE.replace("count: 4", event));
    place.write("leaf.ron", SCENE.replace("count: 4", &event.replace("leaf: 0", "leaf: 99999")));
    let cases: [(&str, &[&str]); 11] = [
        ("empty.ron", &["line 1"]),
        ("garbage.ron", &["UTF-8"]),
        ("folder.ron", &["folder"]),
        ("missing.ron", &["cannot be read"]),
        ("unknown.ron", &["line 2", "clouds"]),
        ("version.ron", &["version 9", "version 1"]),
        ("nan.ron", &["fps", "NaN"]),
        ("species.ron", &["trees[0].source", "pine", "birch"]),
        ("truncated.ron", &["line"]),
        ("event.ron", &["events[1]", "tree 4 is not one of the 4"]),
        ("leaf.ron", &["events[0]", "leaf 99999"]),
    ];
    for (file, words) in cases {
        place.fail(1, &format!("render {file} --out out.png"), &[&[file], words].concat());
    }
    place.fail(1, "render no-such-scene --out out.png", &["no-such-scene", "windfall scenes"]);
}

#[test]
fn reports_are_compared_and_what_got_slower_is_an_error() {
    let place = Place::new();
    let report = |low: f64, quick: bool| {
        let ms = json!({ "low": low, "median": 1.1 * low, "high": 1.2 * low });
        let row =
            json!({ "name": "vertex", "ms": ms, "measured": 0.5, "printed": null, "notes": "" });
        let table = json!({ "id": "walk", "title": "", "scene": "", "ratio": "", "rows": [row],
            "remark": "", "plot": null });
        let adapter = json!({ "adapter": "A", "driver": "", "tables": [table] });
        json!({ "version": "1", "quick": quick, "adapters": [adapter] }).to_string()
    };
    place.write("before.json", report(10.0, true));
    place.write("near.json", report(10.5, true));
    place.write("slow.json", report(15.0, true));
    place.write("full.json", report(10.0, false));
    place.write("other.json", "{}");
    let printed = place.succeed("bench compare before.json near.json");
    assert!(printed.contains("1 rows, 0 slower"), "{printed}");
    let slow = place.run("bench compare before.json slow.json");
    assert_eq!(slow.code, Some(1), "{slow:?}");
    assert!(slow.stdout.contains("slower  1.50 x  A: walk: vertex"), "{slow:?}");
    assert!(slow.stderr.contains("1 of 1 got slower"), "{slow:?}");
    place.fail(1, "bench compare before.json full.json", &["short run", "full run"]);
    place.fail(1, "bench compare before.json other.json", &["other.json", "not a report"]);
    place.fail(1, "bench compare before.json none.json", &["none.json"]);
}

#[test]
fn leaf_occlusion_is_on_or_off_and_its_view_needs_it() {
    let place = Place::new();
    place.fail(2, "render small.ron --leaf-occlusion maybe --out out.png", &["neither on nor off"]);
    let words = ["--view occlusion", "--leaf-occlusion on"];
    place.fail(1, "render small.ron --view occlusion --out out.png", &words);
    place.fail(1, "render small.ron --view occlusion --leaf-occlusion on --out out.png", &words);
}

#[test]
fn numbers_out_of_range_are_refused_with_the_range() {
    let place = Place::new();
    for (arguments, words) in [
        ("--size 0x0", ["size", "0x0"]),
        ("--size 64x0", ["size", "64x0"]),
        ("--size 1000000x16", ["size", "16384"]),
        ("--size 4294967295x4294967295", ["size", "16384"]),
        ("--trees 1000000", ["1000000", "100000"]),
        ("--fps 0", ["fps", "0"]),
        ("--fps nan", ["fps", "NaN"]),
        ("--time inf", ["time", "inf"]),
        ("--season 2", ["season", "2"]),
        ("--tree tiny.glb --height 0", ["height", "0"]),
        ("--tree tiny.glb --height nan", ["height", "NaN"]),
        ("--tree tiny.glb --palette pine", ["palette", "pine"]),
    ] {
        place.fail(1, &format!("render small.ron {arguments} --out out.png"), &words);
    }
}

/// 16384² pixels are within most devices' limits, and take 14 GB.
#[cfg(target_os = "linux")]
#[test]
fn too_little_memory_is_said() {
    let place = Place::new();
    // A software device has the memory that the process has: 6 GB here.
    let program = env!("CARGO_BIN_EXE_windfall");
    let output = std::process::Command::new("sh")
        .args(["-c", "ulimit -v 6000000; exec \"$@\"", "sh", program])
        .args(["render", "small.ron", "--trees", "0", "--size", "16384x16384", "--out", "a.png"])
        .current_dir(place.path(""))
        .env("XDG_RUNTIME_DIR", place.path(""))
        .output()
        .unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    // A graphics card with its own 16 GB may well draw it.
    if !output.status.success() {
        assert_eq!(output.status.code(), Some(1), "{stderr}");
        assert!(stderr.contains("too little memory"), "{stderr}");
        assert!(!place.path("a.png").exists());
    }
}

#[test]
fn bad_outputs_are_refused() {
    let place = Place::new();
    std::fs::create_dir(place.path("folder.png")).unwrap();
    for (out, word) in [
        ("out.bmp", ".png"),
        ("folder.png", "folder"),
        ("f_%05d.gif", ".png"),
        ("f_%q.png", "%05d"),
        ("tiny.glb/out.png", "tiny.glb"),
    ] {
        place.fail(1, &format!("render small.ron --out {out}"), &[word]);
    }
    place.fail(1, "render small.ron --frames 0-3 --out one.png", &["4 pictures", "%05d"]);
    place.fail(1, "render small.ron --size 33x32 --out odd.mp4", &["even"]);
    place.fail(1, "tree export pine --out pine.glb", &["pine", "birch"]);
}

/// A Radiance picture of even light: four bytes a texel, mantissas and their exponent.
fn hdr(width: u32, height: u32, texel: [u8; 4]) -> Vec<u8> {
    let head = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n");
    let texels = texel.repeat((width * height) as usize);
    [head.into_bytes(), texels].concat()
}

#[test]
fn bad_skies_and_qualities_are_named_with_the_cause() {
    let place = Place::new();
    place.write("even.hdr", hdr(4, 2, [40, 80, 160, 130]));
    place.write("square.hdr", hdr(4, 4, [40, 80, 160, 130]));
    place.write("dark.hdr", hdr(4, 2, [0; 4]));
    place.write("garbage.hdr", [0x5a; 300]);
    place.write("garbage.exr", [0x5a; 300]);
    place.write("truncated.hdr", &hdr(4, 2, [40, 80, 160, 130])[..60]);
    place.write("sky.png", png());
    let cases: [(&str, &[&str]); 7] = [
        ("square.hdr", &["4x4", "twice as wide as high"]),
        ("dark.hdr", &["black"]),
        ("garbage.hdr", &["damaged"]),
        ("garbage.exr", &["damaged"]),
        ("truncated.hdr", &["damaged"]),
        ("sky.png", &[".hdr or .exr"]),
        ("missing.hdr", &["cannot be read"]),
    ];
    for (file, words) in cases {
        let words = [&[file], words].concat();
        place.fail(1, &format!("render small.ron --sky {file} --out out.png"), &words);
    }
    place.fail(2, "render small.ron --quality best --out out.png", &["quality", "best", "medium"]);
    place.succeed("render small.ron --sky even.hdr --quality low --out sky.png");
    place.succeed("render small.ron --quality low --out model.png");
    assert_ne!(place.read("sky.png"), place.read("model.png"));
}
