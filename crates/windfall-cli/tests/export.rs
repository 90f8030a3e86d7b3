//! `windfall export` and `windfall farm`, as their users run them.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::Place;
use serde_json::Value;
use std::process::Command;

/// Trees that shed at once, in a place of its own.
fn shedding() -> Place {
    let place = Place::new();
    let scene =
        common::SCENE.replace("count: 4,", "count: 4, shedding: Some((start: -6, duration: 12)),");
    place.write("small.ron", scene);
    place
}

/// What the GPU has in the air and on the ground is what is exported.
#[test]
fn as_many_leaves_are_exported_as_are_drawn() {
    let place = shedding();
    let printed = place.succeed("render small.ron --trees 600 --frames 8-8 --json --out f_%d.png");
    let drawn: Value = serde_json::from_str(&printed).unwrap();
    let drawn = &drawn["frames"][0];
    let printed = place.succeed("export small.ron --trees 600 --frames 8 --json --out all.csv");
    let exported: Value = serde_json::from_str(&printed).unwrap();
    let number = |value: &Value| value.as_u64().unwrap();
    let (falling, landed) = (&exported["falling"]["first"], &exported["landed"]["first"]);
    assert!(number(falling) > 0 && number(landed) > 0, "{exported}");
    assert_eq!(falling, &drawn["leaves_falling"]);
    assert_eq!(landed, &drawn["leaves_landed"]);
    let all = number(falling) + number(landed) + number(&exported["hanging"]["first"]);
    assert_eq!(all, number(&drawn["leaves_total"]));
    let table = String::from_utf8(place.read("all.csv")).unwrap();
    assert_eq!(table.lines().count() as u64, 1 + all);
    assert_eq!(exported["bytes"], table.len());
}

#[test]
fn every_format_is_written_whole_and_the_same_again() {
    let place = shedding();
    for (options, files) in [
        ("--frames 4-8 --out a.usda", vec!["a.usda"]),
        ("--frames 4-8 --out a.csv", vec!["a.csv"]),
        ("--frames 4 --tree tiny.glb --height 3 --palette oak --out t.parquet", vec!["t.parquet"]),
        ("--frames 4-8 --only falling --out a.glb", vec!["a.glb"]),
        (
            "--frames 4-8 --engine unity --texels png --out v.json",
            vec!["v.glb", "v.json", "v_position.png", "v_rotation.png", "windfall_vat.hlsl"],
        ),
        (
            "--frames 4-8 --paths --engine unreal --out p.json",
            vec!["p.glb", "p.json", "p_paths.exr", "p_leaves.exr", "windfall_paths.hlsl"],
        ),
    ] {
        place.succeed(&format!("export small.ron {options}"));
        let first: Vec<Vec<u8>> = files.iter().map(|f| place.read(f)).collect();
        assert!(first.iter().all(|bytes| bytes.len() > 100), "{options}");
        place.succeed(&format!("export small.ron {options}"));
        assert!(first.iter().zip(&files).all(|(was, f)| *was == place.read(f)), "{options}");
    }
}

#[test]
fn what_cannot_be_exported_is_refused() {
    let place = shedding();
    for (code, options, words) in [
        (1, "--paths --out a.usda", "is for textures"),
        (1, "--frames 0-4294967295 --out a.csv", "more than 1000000 frames"),
        (1, "--tree none.glb --out a.csv", "none.glb: cannot be read"),
        (1, "--out a.fbx", "must end in .usda"),
        (2, "--only fallen --out a.usda", "\"fallen\" is none of hanging"),
        (2, "--within 1,2,3 --out a.usda", "six numbers"),
        (2, "--within 5,0,0,1,1,1 --out a.usda", "low corner"),
        (2, "--engine cryengine --out a.json", "none of godot, unity, unreal"),
        (1, "--only falling --most 0 --out a.csv", "no leaf or tree is selected"),
        (1, "--only trees --frames 0-1 --out a.json", "no leaf is selected"),
    ] {
        place.fail(code, &format!("export small.ron {options}"), &[words]);
    }
}

#[test]
fn a_film_is_of_the_frames_that_are_there_and_names_the_others() {
    let place = Place::new();
    place.succeed("render small.ron --frames 0-5 --out f/frame_%05d.png");
    for frame in [1, 3, 4] {
        std::fs::remove_file(place.path(&format!("f/frame_0000{frame}.png"))).unwrap();
    }
    let line = "farm film f/frame_%05d.png --frames 0-6 --fps 10 --out film.apng";
    let run = place.run(line);
    assert_eq!(run.code, Some(0), "{run:?}");
    assert!(run.stderr.contains("4 of 7 frames are missing: 1, 3-4, 6"), "{run:?}");
    let file = std::fs::File::open(place.path("film.apng")).unwrap();
    let reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
    assert_eq!(reader.info().animation_control.unwrap().num_frames, 3);
    place.fail(1, "farm film g_%d.png --frames 0-6 --out film2.apng", &["none of the frames 0-6"]);
    place.write("f/frame_00001.png", "half");
    place.fail(1, &line.replace("film.apng", "other.apng"), &["frame_00001.png: cannot be read"]);
}

#[test]
fn progress_is_told_in_lines() {
    let place = Place::new();
    let run = place.run("render small.ron --frames 0-1 --progress-lines --out f_%d.png");
    for line in ["openjd_progress: 0.0\n", "openjd_progress: 50.0\n", "openjd_progress: 100.0\n"] {
        assert!(run.stderr.contains(line), "{line}: {run:?}");
    }
}

/// The script as Slurm runs it: task after task, then the film. `scripts/check-export` runs the template.
#[test]
fn tasks_of_an_array_give_the_frames_of_one_run() {
    let place = Place::new();
    place.succeed("render small.ron --frames 0-7 --fps 10 --out one/frame_%05d.png");
    place.succeed(
        "farm slurm small.ron --frames 0-7 --fps 10 --frames-per-task 3 --sweep trees=2,4 \
         --sweep seed=3 --film film.apng --out job.sh",
    );
    let script = String::from_utf8(place.read("job.sh")).unwrap();
    assert!(script.contains("#SBATCH --array=0-5\n"), "{script}");
    let run = |task: u32, arguments: &[&str]| {
        let run = Command::new("bash")
            .arg(place.path("job.sh"))
            .args(arguments)
            .current_dir(place.path(""))
            .env("WINDFALL", env!("CARGO_BIN_EXE_windfall"))
            .env("XDG_RUNTIME_DIR", place.path(""))
            .env("SLURM_ARRAY_TASK_ID", task.to_string())
            .output()
            .unwrap();
        assert!(run.status.success(), "{run:?}");
    };
    (0..6).for_each(|task| run(task, &[]));
    run(0, &["film"]);
    for frame in 0..=7 {
        let [one, task] = ["one", "frames/trees_4/seed_3"]
            .map(|folder| place.read(&format!("{folder}/frame_{frame:05}.png")));
        assert!(one == task, "frame {frame}");
    }
    for trees in [2, 4] {
        assert!(place.path(&format!("frames/trees_{trees}/seed_3/film.apng")).is_file());
    }
}

#[test]
fn a_template_has_every_file_that_the_scene_names() {
    let place = Place::new();
    std::fs::create_dir(place.path("jobs")).unwrap();
    place.succeed(
        "farm template small.ron --frames 0-23 --frames-per-task 6 --sweep h=0,0.5 --out job.yaml",
    );
    let template = String::from_utf8(place.read("job.yaml")).unwrap();
    for line in [
        "extensions: [TASK_CHUNKING]\n",
        "  default: \"small.ron\"\n",
        "  default: \"tiny.glb\"\n",
        "  default: \"0-23\"\n",
        "      range: [\"0\", \"0.5\"]\n",
        "        - \"{{Param.OutputDir}}/h_{{Task.Param.H}}/frame_%05d.png\"\n",
    ] {
        assert!(template.contains(line), "{line}: {template}");
    }
    place.fail(1, "farm template small.ron --out jobs/job.yaml", &["small.ron", "is not below"]);
    place.fail(
        1,
        "farm template small.ron --sweep hh=1 --out j.yaml",
        &["no option of windfall render"],
    );
    place.fail(
        1,
        "farm template small.ron --film a.png --out j.yaml",
        &["not .mp4, .apng or .gif"],
    );
}
