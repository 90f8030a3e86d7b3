//! `windfall render`: the same bytes again, films, what it prints.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::Place;
use serde_json::Value;

#[test]
fn the_same_command_twice_gives_the_same_bytes() {
    let place = Place::new();
    place.succeed("render small.ron --time 0.4 --out a.png");
    place.succeed("render small.ron --time 0.4 --out b.png");
    assert_eq!(place.read("a.png"), place.read("b.png"));
    // And what should change the picture does.
    for (name, change) in
        [("seed", "--seed 4"), ("time", "--time 0.9"), ("trees", "--trees 9"), ("height", "")]
    {
        let change = if name == "height" { "--tree tiny.glb --height 9" } else { change };
        let time = if name == "time" { "" } else { "--time 0.4" };
        place.succeed(&format!("render small.ron {time} {change} --out {name}.png"));
        assert_ne!(place.read("a.png"), place.read(&format!("{name}.png")), "{name}");
    }
}

#[test]
fn a_built_in_species_is_the_same_twice() {
    let place = Place::new();
    for name in ["a.png", "b.png"] {
        place.succeed(&format!(
            "render small.ron --tree birch --trees 2 --seed 5 --size 48x32 --out {name}"
        ));
    }
    assert_eq!(place.read("a.png"), place.read("b.png"));
}

#[test]
fn a_frame_is_the_same_alone_and_among_others() {
    let place = Place::new();
    place.succeed("render small.ron --frames 0-9 --out all_%03d.png");
    place.succeed("render small.ron --frames 7-7 --out alone.png");
    place.succeed("render small.ron --frames 7-7 --out one_%d.png");
    assert_eq!(place.read("all_007.png"), place.read("alone.png"));
    assert_eq!(place.read("all_007.png"), place.read("one_7.png"));
    assert_ne!(place.read("all_007.png"), place.read("all_008.png"), "the camera moves");
    assert_eq!(place.files().iter().filter(|f| f.starts_with("all_")).count(), 10);
}

#[test]
fn frames_outside_the_scene_are_its_first_and_last() {
    let place = Place::new();
    place.succeed("render small.ron --frames 9-11 --out f_%d.png");
    assert_eq!(place.read("f_9.png"), place.read("f_11.png"));
}

#[test]
fn resume_draws_what_is_missing_and_nothing_else() {
    let place = Place::new();
    place.succeed("render small.ron --frames 0-2 --out f_%d.png");
    let drawn = place.read("f_2.png");
    place.write("f_1.png", "kept as it is");
    std::fs::remove_file(place.path("f_2.png")).unwrap();
    let printed = place.succeed("render small.ron --frames 0-2 --out f_%d.png --resume --json");
    assert_eq!(place.read("f_1.png"), b"kept as it is");
    assert_eq!(place.read("f_2.png"), drawn);
    let report: Value = serde_json::from_str(&printed).unwrap();
    assert_eq!(report["frames"].as_array().unwrap().len(), 1);
    place.fail(1, "render small.ron --resume --out one.png", &["--resume needs a pattern"]);
}

#[test]
fn an_animated_png_has_every_frame() {
    let place = Place::new();
    place.succeed("render small.ron --frames 2-6 --fps 10 --out film.apng");
    let file = std::fs::File::open(place.path("film.apng")).unwrap();
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
    assert_eq!(reader.info().animation_control.unwrap().num_frames, 5);
    let mut frame = vec![0; reader.output_buffer_size().unwrap()];
    for _ in 0..5 {
        let info = reader.next_frame(&mut frame).unwrap();
        assert_eq!((info.width, info.height), (96, 64));
    }
    let control = reader.info().frame_control.unwrap();
    assert_eq!((control.delay_num, control.delay_den), (1, 10));
    assert!(reader.next_frame(&mut frame).is_err(), "there is no sixth");
}

#[test]
fn a_gif_has_every_frame() {
    let place = Place::new();
    place.succeed("render small.ron --frames 2-6 --fps 10 --out film.gif");
    let file = std::fs::File::open(place.path("film.gif")).unwrap();
    let mut decoder = gif::DecodeOptions::new().read_info(file).unwrap();
    assert_eq!((decoder.width(), decoder.height()), (96, 64));
    let mut delays = Vec::new();
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        delays.push(frame.delay);
    }
    assert_eq!(delays, [10; 5]);
}

#[test]
fn mp4_without_ffmpeg_says_so_and_leaves_nothing() {
    let place = Place::new();
    place.fail_with(
        1,
        "render small.ron --frames 0-1 --out film.mp4",
        &[("PATH", "")],
        &["film.mp4", "ffmpeg", "not on the path", ".apng"],
    );
}

/// A stand-in for ffmpeg: reads everything, then does as told.
#[cfg(unix)]
fn with_ffmpeg(place: &Place, ending: &str) -> String {
    use std::os::unix::fs::PermissionsExt;
    std::fs::create_dir(place.path("bin")).unwrap();
    let script = "#!/bin/sh\nfor last; do :; done\nsize=$(wc -c)\n";
    place.write("bin/ffmpeg", format!("{script}{ending}\n"));
    let mode = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(place.path("bin/ffmpeg"), mode).unwrap();
    format!("{}:/usr/bin:/bin", place.path("bin").display())
}

#[cfg(unix)]
#[test]
fn mp4_goes_through_ffmpeg() {
    let place = Place::new();
    let path = with_ffmpeg(&place, r#"echo "$size" > "$last""#);
    let run =
        place.run_with("render small.ron --frames 0-2 --out film.mp4", &[("PATH", path.as_str())]);
    assert_eq!(run.code, Some(0), "{run:?}");
    let bytes = String::from_utf8(place.read("film.mp4")).unwrap();
    assert_eq!(bytes.trim(), (3 * 96 * 64 * 4).to_string());
}

#[cfg(unix)]
#[test]
fn an_ffmpeg_that_fails_leaves_nothing() {
    let place = Place::new();
    let path = with_ffmpeg(&place, r#"echo half > "$last"; exit 1"#);
    place.fail_with(
        1,
        "render small.ron --frames 0-2 --out film.mp4",
        &[("PATH", path.as_str())],
        &["ffmpeg could not write film.mp4"],
    );
}

#[test]
fn json_has_every_field_and_counts_add_up() {
    let place = Place::new();
    let printed = place.succeed("render small.ron --frames 3-4 --json --out f_%d.png");
    let report: Value = serde_json::from_str(&printed).unwrap();
    assert!(report["adapter"].as_str().is_some_and(|a| !a.is_empty()));
    assert_eq!(report["size"], serde_json::json!([96, 64]));
    let frames = report["frames"].as_array().unwrap();
    assert_eq!(frames.len(), 2);
    for (frame, number) in frames.iter().zip([3, 4]) {
        for field in [
            "frame",
            "time",
            "trees",
            "trees_visible",
            "trees_hidden",
            "leaves_total",
            "leaves_hanging_drawn",
            "leaves_falling",
            "leaves_falling_drawn",
            "leaves_landed",
            "leaves_eliminated",
            "leaves_checked",
            "leaves_tested",
            "leaves_skipped",
            "triangles_full",
            "triangles_drawn",
            "lambda_total",
            "cpu_ms",
        ] {
            assert!(frame[field].is_number(), "{field}: {frame}");
        }
        assert!(frame["gpu_ms"].is_object());
        assert_eq!(frame["frame"], number);
        assert!((frame["time"].as_f64().unwrap() - f64::from(number) / 10.0).abs() < 1e-6);
        // Four trees of two leaves; a tree is 2 triangles of wood and 4 of leaves.
        assert_eq!([&frame["trees"], &frame["leaves_total"]], [4, 8]);
        assert_eq!(frame["triangles_full"], 24);
    }
}

#[test]
fn the_work_of_published_strategies_is_reported() {
    let place = Place::new();
    let frame = |strategy: &str| {
        let run = place.run(&format!(
            "render lone-oak --size 48x32 --strategy {strategy} --leaf-occlusion on --json --out a.png"
        ));
        assert_eq!(run.code, Some(0), "{run:?}");
        let report: Value = serde_json::from_str(&run.stdout).unwrap();
        (report["frames"][0].clone(), run.stderr)
    };
    let (vertex, said) = frame("vertex");
    assert_eq!(said, "");
    assert!(vertex["leaves_tested"].as_u64().unwrap() > 100, "{vertex}");
    assert_eq!(vertex["leaves_eliminated"], vertex["leaves_landed"]);
    let (compute, said) = frame("compute");
    assert!(said.starts_with("note: leaf_occlusion is for the strategies vertex"), "{said}");
    for field in ["leaves_eliminated", "leaves_checked", "leaves_tested", "leaves_skipped"] {
        assert_eq!(compute[field], 0, "{field}");
    }
    // What does not depend on the strategy.
    for field in
        ["trees", "leaves_total", "leaves_hanging_drawn", "leaves_falling", "leaves_landed"]
    {
        assert_eq!(vertex[field], compute[field], "{field}");
    }
    assert!(compute["leaves_falling"].as_u64().unwrap() > 100, "{compute}");
}

#[test]
fn an_empty_forest_renders() {
    let place = Place::new();
    let printed = place.succeed("render small.ron --trees 0 --json --out empty.png");
    let report: Value = serde_json::from_str(&printed).unwrap();
    assert_eq!(report["frames"][0]["trees"], 0);
    assert_eq!(image::open(place.path("empty.png")).unwrap().to_rgb8().dimensions(), (96, 64));
}

#[test]
fn folders_on_the_way_to_the_output_are_made() {
    let place = Place::new();
    place.succeed("render small.ron --out new/and/deep.png");
    assert!(place.path("new/and/deep.png").exists());
    let left: Vec<_> = std::fs::read_dir(place.path("new/and")).unwrap().collect();
    assert_eq!(left.len(), 1, "nothing beside it");
}

#[test]
fn a_budget_gives_up_what_it_has_to_and_no_more() {
    let place = Place::new();
    let saving = |budget: &str, file: &str| {
        let text = place.succeed(&format!("render small.ron{budget} --json --out {file}"));
        let object: Value = serde_json::from_str(&text).unwrap();
        object["frames"][0]["saving"].as_f64()
    };
    assert_eq!(saving("", "plain.png"), None);
    // More than any machine needs: nothing is given up, and the picture is the same.
    assert_eq!(saving(" --budget 10000", "held.png"), Some(0.0));
    assert!(place.read("plain.png") == place.read("held.png"));
    // Less than any has.
    assert!(saving(" --budget 0.1", "least.png").unwrap() > 0.9);
    assert!(place.read("plain.png") != place.read("least.png"));
    let run = place.run("render small.ron --budget 0.01 --out a.png");
    assert!(run.code != Some(0) && run.stderr.contains("budget"), "{run:?}");
}
