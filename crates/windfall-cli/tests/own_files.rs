//! Trees and paths of the user's own: how they are chosen, what is said of them, and what comes out for compositing.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::Place;
use common::model::Model;
use serde_json::{Value, json};

fn codes(object: &Value) -> Vec<&str> {
    object["notes"].as_array().unwrap().iter().map(|n| n["code"].as_str().unwrap()).collect()
}

/// A fall straight down, or 2 m aside for each metre down.
fn table(aside: f32, header: &str, step: f32) -> String {
    let rows = (0..120).map(|i| {
        let (time, down) = (i as f32 * step, i as f32 / 60.0);
        format!("{time},{},{},0,0,0,0,1\n", aside * down, -down)
    });
    format!("{header}\n{}", rows.collect::<String>())
}

#[test]
fn inspect_lists_primitives_and_draws_the_tree() {
    let place = Place::new();
    let text = place.succeed("tree inspect tiny.glb --picture tiny.png");
    assert!(
        text.contains("  0: wood (nothing says that it is leaves); node 1 \"trunk\""),
        "{text}"
    );
    assert!(
        text.contains("  1: leaves (node \"leaves\"); node 2 \"leaves\", mesh \"leaves\""),
        "{text}"
    );
    assert!(text.contains("x 0.00..3.00, y 2.00..3.00"), "{text}");
    let picture = image::load_from_memory(&place.read("tiny.png")).unwrap().into_rgb8();
    let count = |test: fn(&image::Rgb<u8>) -> bool| picture.pixels().filter(|p| test(p)).count();
    let leaves = count(|p| p[0] > 100 && p[2] < 40);
    let wood = count(|p| p[2] > p[0].saturating_add(30) && p[2] < 150);
    // Two cards of 1 m², a trunk of 0.2 by 2 m.
    assert!(leaves > 4 * wood && wood > 1000, "{leaves} {wood}");
    // The other way round.
    let object: Value = serde_json::from_str(
        &place.succeed("tree inspect tiny.glb --leaves 0 --wood leaves --json"),
    )
    .unwrap();
    assert_eq!((&object["leaves"], &object["wood_triangles"]), (&json!(1), &json!(4)));
    assert_eq!(object["primitives"][0]["taken_for"], "leaves");
    assert!(codes(&object).contains(&"one-leaf"), "{object}");
}

#[test]
fn notes_go_to_stderr_and_into_the_json() {
    let place = Place::new();
    let mut model = Model::tree();
    model.json["animations"] = json!([{}]);
    place.write("tiny.glb", model.glb());
    let run = place.run("render small.ron --json --out a.png");
    assert_eq!(run.code, Some(0), "{run:?}");
    assert!(run.stderr.contains("note[animation-left-out]: "), "{}", run.stderr);
    let object: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(codes(&object), ["animation-left-out"]);
    let run = place.run("simplify tiny.glb --lambda 0.5 --out half.glb");
    assert!(run.stderr.contains("note[animation-left-out]: "), "{}", run.stderr);
}

#[test]
fn axes_units_and_nodes_are_options_of_every_command() {
    let place = Place::new();
    for (options, height) in [
        ("--unit 2", 6.0),
        ("--up z", 0.0),
        ("--node 1 --leaves 0", 2.0),
        ("--unit 0.5 --height 4", 4.0),
    ] {
        let object: Value = serde_json::from_str(
            &place.succeed(&format!("tree inspect tiny.glb {options} --json")),
        )
        .unwrap();
        let got = object["height_m"].as_f64().unwrap();
        assert!((got - height).abs() < 1e-3, "{options}: {got}");
    }
    place.fail(
        1,
        "tree inspect tiny.glb --node nothing",
        &["no node is named \"nothing\"", "\"trunk\""],
    );
    place.fail(2, "render small.ron --node trunk --out a.png", &["--tree"]);
}

#[test]
fn leaves_fall_by_the_users_path() {
    let place = Place::new();
    let header = "time,x,y,z,qx,qy,qz,qw";
    place.write("down.csv", table(0.0, header, 1.0 / 60.0));
    place.write("aside.csv", table(2.0, header, 1.0 / 60.0));
    place.write("frames.csv", table(0.0, &header.replace("time", "frame"), 1.0));
    let render = |options: &str, out: &str| {
        place.succeed(&format!("render small.ron --falling 40 --time 0.9 {options} --out {out}"));
        image::load_from_memory(&place.read(out)).unwrap().into_rgb8()
    };
    // The largest difference of a channel. Positions of all paths are kept on one grid, as fine as the longest path
    // allows: beside another path a leaf may lie elsewhere by a part of it.
    let apart = |a: &image::RgbImage, b: &image::RgbImage| {
        a.iter().zip(b.iter()).map(|(a, b)| a.abs_diff(*b)).max().unwrap()
    };
    let down = render("--path down.csv", "b.png");
    for (options, out, as_down) in [
        ("", "a.png", false),
        ("--path aside.csv", "c.png", false),
        ("--path tiny=down.csv --path aside.csv", "d.png", true),
        ("--path frames.csv --path-fps 60", "e.png", true),
        ("--path down.csv --variation paper-2008", "f.png", false),
        ("--path down.csv --soft-time 3", "g.png", false),
    ] {
        let apart = apart(&down, &render(options, out));
        assert!(if as_down { apart <= 2 } else { apart >= 40 }, "{options}: {apart}");
    }
    // The same from a scene.
    let scene = common::SCENE.replace("count: 4", "count: 4, paths: [(file: \"down.csv\")]");
    place.write("small.ron", scene);
    assert!(apart(&down, &render("", "h.png")) <= 2);
    place.fail(
        1,
        "render small.ron --path fir=down.csv --out x.png",
        &["no tree is \"fir\"", "tiny.glb"],
    );
    place.fail(1, "render small.ron --path frames.csv --out x.png", &["--fps"]);
    place.fail(2, "render small.ron --path down.csv --time-unit h --out x.png", &["s, ms"]);
}

#[test]
fn variations_of_a_path_are_drawn() {
    let place = Place::new();
    place.write("aside.csv", table(2.0, "time,x,y,z,qx,qy,qz,qw", 1.0 / 60.0));
    for (i, paper) in ["", "--paper 2007", "--paper 2008"].into_iter().enumerate() {
        place.succeed(&format!(
            "path inspect aside.csv --plot p{i}.svg --variations 12 --drop 5 {paper}"
        ));
        let svg = String::from_utf8(place.read(&format!("p{i}.svg"))).unwrap();
        assert!(svg.contains("12 leaves from 5 m"), "{svg:.300}");
    }
    assert_ne!(place.read("p1.svg"), place.read("p2.svg"));
    place.write("ms.csv", table(0.0, "time,x,y,z,qx,qy,qz,qw", 1000.0 / 60.0));
    place.fail(1, "path inspect ms.csv", &["--time-unit ms"]);
    let object: Value =
        serde_json::from_str(&place.succeed("path inspect ms.csv --time-unit ms --json")).unwrap();
    assert_eq!(object["paths"][0]["samples"], 120);
    assert!(object["notes"].is_array());
}

#[test]
fn a_clear_sky_has_straight_alpha() {
    let place = Place::new();
    let camera = "--camera 0,3,16 0,4,0 50 --trees 1";
    place.succeed(&format!("render small.ron {camera} --alpha --out clear.png"));
    place.succeed(&format!("render small.ron {camera} --out sky.png"));
    let clear = image::load_from_memory(&place.read("clear.png")).unwrap();
    assert_eq!(clear.color(), image::ColorType::Rgba8);
    let clear = clear.into_rgba8();
    assert_eq!(clear.get_pixel(2, 2)[3], 0, "the sky");
    assert_eq!(clear.get_pixel(48, 62)[3], 255, "the ground");
    assert!(clear.pixels().any(|p| (1..255).contains(&p[3])), "edges");
    // Where nothing is clear, the colours are those of the whole picture, but for filtering at edges and noise.
    let sky = image::load_from_memory(&place.read("sky.png")).unwrap().into_rgb8();
    for x in 0..96 {
        let (a, b) = (clear.get_pixel(x, 63), sky.get_pixel(x, 63));
        assert!((0..3).all(|c| a[c].abs_diff(b[c]) < 40), "{x}: {a:?} {b:?}");
    }
    place.fail(1, "render small.ron --alpha --out x.gif", &["has no alpha"]);
}

#[test]
fn an_exr_has_linear_colours_and_depth() {
    use exr::prelude::{ReadChannels, ReadLayers, read};
    let place = Place::new();
    place.succeed("render small.ron --camera 0,3,16 0,1,0 50 --trees 0 --out a.exr");
    place.succeed(
        "render small.ron --camera 0,3,16 0,1,0 50 --trees 0 --alpha --frames 0-1 --out f_%d.exr",
    );
    let read = |name: &str| {
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes();
        let image = image.from_file(place.path(name)).unwrap();
        let names: Vec<String> =
            image.layer_data.channel_data.list.iter().map(|c| c.name.to_string()).collect();
        assert_eq!(names, ["A", "B", "G", "R", "Z"]);
        image.layer_data
    };
    let value =
        |layer: &exr::prelude::Layer<exr::prelude::AnyChannels<exr::prelude::FlatSamples>>,
         channel: usize,
         x: usize,
         y: usize| {
            layer.channel_data.list[channel].sample_data.value_by_flat_index(y * 96 + x).to_f32()
        };
    let (whole, clear) = (read("a.exr"), read("f_0.exr"));
    assert!(place.files().contains(&"f_1.exr".to_owned()));
    assert_eq!((value(&whole, 0, 3, 0), value(&clear, 0, 3, 0)), (1.0, 0.0), "alpha of the sky");
    assert_eq!(
        (value(&whole, 0, 3, 63), value(&clear, 0, 3, 63)),
        (1.0, 1.0),
        "alpha of the ground"
    );
    assert!(value(&whole, 1, 3, 0) > 0.05 && value(&clear, 1, 3, 0) == 0.0, "blue of the sky");
    // Looking 7.1° down from 3 m, with the last row 24.6° below the middle: 3 m / tan(31.7°) away, along the ground.
    let (down, below) = (2.0f32.atan2(16.0), (25f32.to_radians().tan() * (63.0 / 64.0)).atan());
    let expected = 3.0 / (down + below).sin() * below.cos();
    let depth = value(&whole, 4, 48, 63);
    assert!((depth / expected - 1.0).abs() < 0.05, "{depth} for {expected}");
    assert!(value(&whole, 4, 3, 0) > 1e38, "the sky is far");
}

#[test]
fn a_single_tree_fills_the_picture() {
    let place = Place::new();
    for height in [1.5, 9.0, 60.0] {
        place.succeed(&format!("render autumn --tree birch --trees 1 --height {height} --size 96x96 --alpha --out {height}.png"));
        let picture =
            image::load_from_memory(&place.read(&format!("{height}.png"))).unwrap().into_rgba8();
        let rows: Vec<u32> =
            (0..96).filter(|&y| (0..96).any(|x| picture.get_pixel(x, y)[3] > 128)).collect();
        assert!((2..25).contains(&rows[0]), "{height} m: from row {}", rows[0]);
    }
    place.fail(1, "render small.ron --camera 0,1 0,1,2 50 --out x.png", &["X,HEIGHT,Z"]);
    place.fail(
        1,
        "render small.ron --camera 0,1,2 0,1,2 50 --out x.png",
        &["eye and target are the same"],
    );
}

#[test]
fn an_exr_tells_which_leaf_is_seen() {
    use exr::prelude::{ReadChannels, ReadLayers, read};
    let place = Place::new();
    // Four trees of two leaves; the second leaf of the third tree is thrown.
    let events = common::SCENE.replace(
        "camera:",
        "spacing: Some(5), shedding: None, wind: (speed: 0), events: [(tree: 2, leaf: 1, time: 0.05)], camera:",
    );
    place.write("events.ron", events);
    place.succeed("render events.ron --camera 0,4,26 0,2,0 50 --ids --frames 0-9 --out f_%d.exr");
    // By leaf and tree, counted from 1: pixels, and the sum of their rows.
    let seen = |name: &str| {
        let image = read().no_deep_data().largest_resolution_level().all_channels();
        let image = image.first_valid_layer().all_attributes().from_file(place.path(name)).unwrap();
        let channel = |name: &str| {
            let list = &image.layer_data.channel_data.list;
            let found = list.iter().find(|c| c.name.to_string() == name).unwrap();
            found.sample_data.values_as_f32().collect::<Vec<f32>>()
        };
        let (leaves, trees, depths) = (channel("id.leaf"), channel("id.tree"), channel("Z"));
        let mut found = std::collections::BTreeMap::new();
        for (i, ((leaf, tree), depth)) in leaves.iter().zip(&trees).zip(&depths).enumerate() {
            assert_eq!(*leaf > 0.0, *tree > 0.0, "a leaf has a tree");
            if *leaf > 0.0 {
                assert!(*depth < 100.0, "a leaf is before the sky");
                let sum: &mut (u32, usize) = found.entry((*tree as u32, *leaf as u32)).or_default();
                *sum = (sum.0 + 1, sum.1 + i / 96);
            }
        }
        found
    };
    let (before, after) = (seen("f_0.exr"), seen("f_9.exr"));
    let all = [(1, 1), (1, 2), (2, 1), (2, 2), (3, 1), (3, 2), (4, 1), (4, 2)];
    // One may be behind another.
    assert!(before.len() >= 6 && before.keys().all(|id| all.contains(id)), "{before:?}");
    let row = |of: &(u32, usize)| of.1 as f32 / of.0 as f32;
    for &id in before.keys() {
        let now = after.get(&id).unwrap_or_else(|| panic!("{id:?} is gone: {after:?}"));
        let fallen = row(now) - row(&before[&id]);
        if id == (3, 2) {
            assert!(fallen > 1.0, "{id:?} by {fallen} rows");
        } else {
            assert!(fallen.abs() < 0.5, "{id:?} by {fallen} rows");
        }
    }
    let run = place.run("render small.ron --ids --out a.png");
    assert!(run.code != Some(0) && run.stderr.contains("--ids"), "{run:?}");
    let run = place.run("render small.ron --ids --strategy vertex --out a.exr");
    assert!(run.code != Some(0) && run.stderr.contains("vertex"), "{run:?}");
}
