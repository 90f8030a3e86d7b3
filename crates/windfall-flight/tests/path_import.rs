//! Import: what is read, what is repaired, what is refused and how it is said.

mod common;

use common::{Channel, csv, glb, json, key, rotation, times, translation};
use std::fmt::Write as _;
use windfall_core::glam::{Quat, Vec3};
use windfall_core::path::{FallPath, PathSet, analysis};
use windfall_flight::{ImportOptions, Imported, Up, import, read_paths, to_ron};

fn read(file: &str, bytes: &[u8]) -> Result<Imported, String> {
    import(file, bytes, &ImportOptions::default()).map_err(|e| e.to_string())
}

fn assert_is_the_fall(path: &FallPath, tolerance: f32) {
    let first = key(0).1;
    for (i, (p, q)) in path.positions().iter().zip(path.orientations()).enumerate() {
        let t = i as f32 / path.rate() * 30.0;
        let (a, b) = (key(t as usize), key(t as usize + 1));
        let x = t.fract();
        let expected = a.1.lerp(b.1, x) - first;
        assert!((*p - expected).length() < tolerance, "sample {i}: {p} {expected}");
        assert!(analysis::angle(*q, a.2.slerp(b.2, x)) < tolerance * 10.0);
    }
}

#[test]
fn the_blender_export_is_read() {
    let bytes = include_bytes!("data/blender_fall_3.glb");
    let Imported { path, repairs, .. } = read("blender_fall_3.glb", bytes).unwrap();
    assert_eq!(path.name(), "blender_fall_3");
    assert_eq!(path.positions().len(), 150);
    assert!((path.rate() - 30.0).abs() < 0.01 && repairs.is_empty(), "{repairs:?}");
    // The file's last key.
    let last = path.positions()[149];
    assert!((last - Vec3::new(0.208_703_5, -1.219_068_2, -0.118_107_1)).length() < 1e-6);
    let q = Quat::from_xyzw(0.437_241, 0.035_281_8, 0.564_586, 0.699_155_3);
    assert!(analysis::angle(path.orientations()[149], q) < 1e-3);
    assert!(!path.analysis().joints.is_empty() && !path.analysis().starts.is_empty());
}

#[test]
fn csv_json_and_gltf_give_the_same_fall() {
    let from_csv = read("fall.csv", csv(200).as_bytes()).unwrap();
    assert!(from_csv.repairs.is_empty());
    assert_is_the_fall(&from_csv.path, 1e-5);

    let json = json(200);
    assert_is_the_fall(&read("fall.json", json.as_bytes()).unwrap().path, 1e-5);

    let bytes = glb(&[vec![translation(200), rotation(200)]]);
    assert_is_the_fall(&read("fall.glb", &bytes).unwrap().path, 1e-5);

    let options = ImportOptions { rate: Some(100.0), ..ImportOptions::default() };
    let resampled = import("fall.glb", &bytes, &options).unwrap().path;
    assert_eq!(resampled.positions().len(), 664);
    assert_is_the_fall(&resampled, 1e-5);
}

#[test]
fn paths_of_200_and_of_10000_samples_work() {
    for n in [200, 10_000] {
        let set = PathSet::new(vec![read("fall.csv", csv(n).as_bytes()).unwrap().path]).unwrap();
        assert_eq!(set.paths()[0].positions().len(), n);
        let again = PathSet::read("fall", &set.to_bytes()).unwrap();
        assert_eq!(again.paths()[0].positions(), set.paths()[0].positions());
        assert_eq!(again.paths()[0].analysis(), set.paths()[0].analysis());
        let again = read_paths("fall", to_ron(&set).as_bytes()).unwrap();
        assert_eq!(again.paths()[0].positions(), set.paths()[0].positions());
        assert_eq!(again.paths()[0].analysis(), set.paths()[0].analysis());
        // Binary sets are known by their first bytes.
        let again = read_paths("fall", &set.to_bytes()).unwrap();
        assert_eq!(again.paths()[0].positions(), set.paths()[0].positions());
    }
}

#[test]
fn z_up_and_centimetres_are_turned_and_scaled() {
    // In a file with Z up, a leaf sinks along -Z; its upper side is +Z, its tip +Y is the far side.
    let mut text = String::from("time,x,y,z,rx,ry,rz\n");
    for i in 0..100 {
        writeln!(text, "{},{},{},{},0,0,90", i as f32 * 0.02, i, 2 * i, -3 * i).unwrap();
    }
    let options = ImportOptions { up: Up::Z, scale: 0.01, ..ImportOptions::default() };
    let path = import("fall.csv", text.as_bytes(), &options).unwrap().path;
    let last = path.positions()[99];
    assert!((last - Vec3::new(0.99, -2.97, -1.98)).length() < 1e-5, "{last}");
    // A quarter turn about the file's up axis is one about ours.
    let turn = Quat::from_rotation_y(90f32.to_radians());
    assert!(analysis::angle(path.orientations()[50], turn) < 1e-3);
}

#[test]
fn euler_angles_turn_about_x_first() {
    let mut text = String::from("t;x;y;z;rx;ry;rz;note\n");
    for i in 0..20 {
        writeln!(text, "{};0;{};0;30;40;50;{i}", i as f32 * 0.1, -0.07 * i as f32).unwrap();
    }
    let Imported { path, repairs, .. } = read("fall.csv", text.as_bytes()).unwrap();
    let [x, y, z] = [30.0f32, 40.0, 50.0].map(f32::to_radians);
    let expected = Quat::from_rotation_z(z) * Quat::from_rotation_y(y) * Quat::from_rotation_x(x);
    assert!(analysis::angle(path.orientations()[3], expected) < 1e-3);
    assert_eq!(repairs, ["left out: columns note"]);
}

#[test]
fn cubic_splines_and_steps_are_resampled() {
    // A parabola is its own cubic: y = -t², slope -2t, keys at uneven times.
    let keys: Vec<f32> = vec![0.0, 0.1, 0.3, 0.4, 0.8, 1.0, 1.5, 1.6, 2.0];
    let spline = keys.iter().flat_map(|t| {
        let slope = [0.0, -2.0 * t, 0.0];
        [slope, [0.0, -t * t, 0.0], slope].concat()
    });
    let turns = keys.iter().flat_map(|t| Quat::from_rotation_y(0.5 * t).to_array());
    let bytes = glb(&[vec![
        Channel("translation", "CUBICSPLINE", keys.clone(), spline.collect()),
        Channel("rotation", "STEP", keys.clone(), turns.collect()),
    ]]);
    let Imported { path, repairs, .. } = read("spline.glb", &bytes).unwrap();
    assert_eq!(repairs, ["keys are unevenly spaced: resampled to 60 Hz"]);
    for (i, p) in path.positions().iter().enumerate() {
        let t = i as f32 / 60.0;
        assert!((p.y + t * t).abs() < 1e-5, "{t}: {}", p.y);
    }
    // At 0.7 s the key of 0.4 s still holds.
    let held = Quat::from_rotation_y(0.2);
    assert!(analysis::angle(path.orientations()[42], held) < 1e-3);
}

#[test]
fn odd_animations_are_repaired_aloud_or_refused() {
    let n = 50;
    let repaired = read("a.glb", &glb(&[vec![translation(n)]])).unwrap();
    assert_eq!(
        repaired.repairs,
        ["node \"leaf0\" has no rotation channel: it keeps its own rotation"]
    );

    let scale = Channel("scale", "LINEAR", times(n), vec![2.0; 3 * n]);
    let repaired = read("a.glb", &glb(&[vec![translation(n), rotation(n), scale]])).unwrap();
    assert_eq!(
        repaired.repairs,
        ["node \"leaf0\" has a scale channel: left out, leaves keep their size"]
    );
    assert_is_the_fall(&repaired.path, 1e-5);

    let two = glb(&[vec![translation(n), rotation(n)], vec![translation(n)]]);
    assert_eq!(
        read("a.glb", &two).unwrap_err(),
        "a.glb: animations: 2 nodes are animated; name one with --node: leaf0, leaf1"
    );
    let named = |node: &str| {
        let options = ImportOptions { node: Some(node.into()), ..ImportOptions::default() };
        import("a.glb", &two, &options).map_err(|e| e.to_string())
    };
    assert!(named("leaf1").is_ok());
    assert_eq!(
        named("tree").unwrap_err(),
        "a.glb: animations: no animated node is called \"tree\"; animated are: leaf0, leaf1"
    );
    assert_eq!(
        read("a.glb", &glb(&[vec![translation(1), rotation(1)]])).unwrap_err(),
        "a.glb: node \"leaf0\", translation: 1 key; a fall path needs at least 8"
    );
    assert_eq!(
        read("a.glb", &glb(&[vec![rotation(n)]])).unwrap_err(),
        "a.glb: node \"leaf0\": no translation channel"
    );
    assert_eq!(
        read("a.glb", &glb(&[vec![]])).unwrap_err(),
        "a.glb: animations: no node is animated: there is no path in it"
    );
    let mut backwards = translation(n);
    backwards.2.swap(20, 21);
    assert_eq!(
        read("a.glb", &glb(&[vec![backwards, rotation(n)]])).unwrap_err(),
        "a.glb: node \"leaf0\", translation key 21: times must ascend, but 0.6666667 s follows 0.7 s"
            .replace("0.6666667", "0.6666666865348816")
            .replace("0.7 s", "0.699999988079071 s")
    );
    let mut hole = translation(n);
    hole.3[31] = f32::NAN;
    assert_eq!(
        read("a.glb", &glb(&[vec![hole, rotation(n)]])).unwrap_err(),
        "a.glb: node \"leaf0\", translation key 10: NaN or infinite"
    );
    let mut long = rotation(n);
    long.3[40..44].copy_from_slice(&[0.9, 0.0, 0.0, 0.9]);
    assert_eq!(
        read("a.glb", &glb(&[vec![translation(n), long]])).unwrap_err(),
        "a.glb: node \"leaf0\", rotation key 10: quaternion of length 1.273 is too far from unit length"
    );
    // A slightly long quaternion is repaired.
    let mut nearly = rotation(n);
    nearly.3[40..44].iter_mut().for_each(|v| *v *= 1.03);
    assert_is_the_fall(&read("a.glb", &glb(&[vec![translation(n), nearly]])).unwrap().path, 1e-5);
}

/// All of these were panics of the `gltf` crate once.
#[test]
fn channels_that_point_nowhere_or_to_other_types_are_refused() {
    let valid = glb(&[vec![translation(20), rotation(20)]]);
    let replaced = |from: &str, to: &str| {
        let text = from.as_bytes();
        let at = valid.windows(text.len()).rposition(|window| window == text).unwrap();
        let mut bytes = valid.clone();
        bytes[at..at + text.len()].copy_from_slice(to.as_bytes());
        read("f.glb", &bytes).unwrap_err()
    };
    assert_eq!(
        replaced(r#""target":{"node":0"#, r#""target":{"node":7"#),
        "f.glb: animation 0, channel 1: names node 7, but there are 1"
    );
    assert_eq!(
        replaced(r#""path":"rotation""#, r#""path":"rotatiom""#),
        "f.glb: animation 0, channel 1: its target path is not known"
    );
    let mut short = valid.clone();
    short[8..12].copy_from_slice(&11u32.to_le_bytes());
    assert_eq!(
        read("f.glb", &short).unwrap_err(),
        "f.glb: not a valid glTF file: 11 bytes are less than its header"
    );
    // The last of four accessors holds the rotations, the third their times.
    assert_eq!(
        replaced(r#""type":"VEC4""#, r#""type":"VEC2""#),
        "f.glb: accessor 3: is of type Vec2 of F32; Vec4 of F32 is needed"
    );
    assert_eq!(
        replaced(r#"5126,"count":20,"type":"SCALAR""#, r#"5125,"count":20,"type":"SCALAR""#),
        "f.glb: accessor 2: is of type Scalar of U32; Scalar of F32 is needed"
    );
}

#[test]
fn bad_tables_are_refused_with_their_line() {
    let refused = |text: &str, message: &str| {
        assert_eq!(read("f.csv", text.as_bytes()).unwrap_err(), message, "{text}");
    };
    refused(&csv(7), "f.csv: 7 keys; a fall path needs at least 8");
    refused("", "f.csv: no header line");
    refused("time,x,y\n0,0,0\n", "f.csv: header: no column \"z\"; columns are: time, x, y");
    refused(
        "time,x,y,z\n0,0,0,0\n.1,0,0,0\n.2,0,0,0\n.3,0,0,0\n.4,0,0,0\n.5,0,0,0\n.6,0,0,0\n.7,0,0,0",
        "f.csv: header: no orientation: columns qx, qy, qz, qw or rx, ry, rz (degrees); columns are: time, x, y, z",
    );
    let edited = |line: usize, new: &str| {
        let text = csv(20);
        let mut lines: Vec<&str> = text.lines().collect();
        lines[line - 1] = new;
        lines.join("\n")
    };
    refused(&edited(5, "abc,0,0,0,0,0,0,1"), "f.csv: line 5: \"abc\" is no number");
    refused(&edited(5, "0.1,0,0"), "f.csv: line 5: 3 fields under 8 columns");
    refused(&edited(5, "0.1,0,NaN,0,0,0,0,1"), "f.csv: line 5: position is NaN or infinite");
    refused(&edited(5, "0.1,0,0,0,0,0,inf,1"), "f.csv: line 5: quaternion is NaN or infinite");
    refused(
        &edited(5, "0.1,0,0,0,0,0,0,0.5"),
        "f.csv: line 5: quaternion of length 0.500 is too far from unit length",
    );
    refused(
        &edited(5, "0.01,0,0,0,0,0,0,1"),
        "f.csv: line 5: times must ascend, but 0.01 s follows 0.06666667 s",
    );
    let mut rising = String::from("t,x,y,z,rx,ry,rz\n");
    for i in 0..20 {
        writeln!(rising, "{},0,{},0,0,0,0", i as f32 * 0.1, 0.1 * i as f32).unwrap();
    }
    refused(
        &rising,
        "f.csv: the path does not descend: it ends 1.9000 m above its start (is another axis up?)",
    );
    let mut darting = String::from("t,x,y,z,rx,ry,rz\n");
    for i in 0..21 {
        writeln!(darting, "{},{},{},0,0,0,0", i as f32 * 0.1, i % 2, -0.01 * i as f32).unwrap();
    }
    refused(
        &darting,
        "f.csv: the path does not descend: it ends 0.2000 m below its start after a way of 20.00 m; \
         at least 2% are needed",
    );
    assert_eq!(
        read("f.json", b"[{\"t\":0,\"x\":1},{\"t\":1}]").unwrap_err(),
        "f.json: sample 1: \"x\" is missing or no number"
    );
    assert!(
        read("f.json", b"[{\"t\":0,")
            .unwrap_err()
            .starts_with("f.json: line 1, column 8: not JSON")
    );
}

#[test]
fn bad_path_sets_in_ron_are_refused() {
    let set = PathSet::new(vec![read("fall.csv", csv(100).as_bytes()).unwrap().path]).unwrap();
    let text = to_ron(&set);
    let message = |text: &str| read_paths("set", text.as_bytes()).unwrap_err().to_string();
    assert_eq!(
        message(&text.replacen("version: 1", "version: 2", 1)),
        "set: version 2; this program reads version 1"
    );
    assert!(message("(version: 1").starts_with("set: 1:"), "{}", message("(version: 1"));
    assert!(message(&text.replacen("rate", "rat", 1)).contains("not a path set in RON"));
    let (before, after) = text.split_once("rate: ").unwrap();
    let (_, after) = after.split_once(',').unwrap();
    assert_eq!(
        message(&format!("{before}rate: 1e9,{after}")),
        "set: path 0: rate 1000000000 Hz is outside 1..=10000"
    );
    assert_eq!(
        read_paths("set", &[0xff, 0xfe]).unwrap_err().to_string(),
        "set: neither a binary path set nor text in UTF-8"
    );
    assert_eq!(message("(version: 1, paths: [])"), "set: a path set needs at least one path");
}
