//! Paths as people bring them: takes, carriers, buffers beside, and the tables of other programs. Each test is a row of
//! the table of cases, with a file made here.

mod common;

use common::{Channel, Take, csv, gltf, key, rotation, takes, times, translation};
use std::fmt::Write as _;
use windfall_core::glam::{Quat, Vec3};
use windfall_core::path::{FallPath, analysis};
use windfall_flight::{ImportOptions, Imported, NoteCode, TimeUnit, import, import_with};

const LEAF: &str = r#"{"name":"leaf"}"#;

fn read(file: &str, bytes: &[u8], options: &ImportOptions) -> Result<Imported, String> {
    import(file, bytes, options).map_err(|e| e.to_string())
}

fn plain() -> ImportOptions {
    ImportOptions::default()
}

fn notes(imported: &Imported) -> Vec<String> {
    imported.notes.iter().map(ToString::to_string).collect()
}

/// That a path is the fall of [`key`], at its own rate of 30 Hz.
fn assert_is_the_fall(path: &FallPath, samples: usize) {
    assert_eq!(path.positions().len(), samples);
    assert!((path.rate() - 30.0).abs() < 0.01, "{}", path.rate());
    for (i, (p, q)) in path.positions().iter().zip(path.orientations()).enumerate() {
        let expected = key(i).1 - key(0).1;
        assert!((*p - expected).length() < 1e-5, "sample {i}: {p} {expected}");
        assert!(analysis::angle(*q, key(i).2) < 2e-3, "sample {i}: {q}");
    }
}

/// A text with each line replaced.
fn each_line(text: &str, edit: impl FnMut(&str) -> String) -> String {
    text.lines().map(edit).collect::<Vec<_>>().concat()
}

/// A straight fall at `speed` metres per second, in the orientation `turn`.
fn straight(n: usize, speed: f32, turn: Quat) -> [(usize, Channel); 2] {
    let down = times(n).iter().flat_map(|t| [0.0, -speed * t, 0.0]).collect();
    let turns = (0..n).flat_map(|_| turn.to_array()).collect();
    [
        (0, Channel("translation", "LINEAR", times(n), down)),
        (0, Channel("rotation", "LINEAR", times(n), turns)),
    ]
}

#[test]
fn one_take_is_read_and_the_others_are_named() {
    let calm = Take(Some("calm"), straight(20, 0.5, Quat::IDENTITY).into());
    let storm = Take(Some("storm"), straight(20, 2.0, Quat::from_rotation_z(1.0)).into());
    let unnamed = Take(None, straight(20, 3.0, Quat::IDENTITY).into());
    let bytes = takes(LEAF, &[calm, storm, unnamed]);
    let speed_and_tilt = |imported: &Imported| {
        let tilt = analysis::angle(imported.path.orientations()[5], Quat::IDENTITY);
        (imported.path.descent(), tilt)
    };

    let first = read("takes.glb", &bytes, &plain()).unwrap();
    let (speed, tilt) = speed_and_tilt(&first);
    assert!((speed - 0.5).abs() < 1e-4 && tilt < 1e-3, "{speed} {tilt}");
    assert_eq!(
        notes(&first),
        [
            "note[other-takes]: takes.glb: node \"leaf\": is in 3 animations: calm is taken, choose with \
          --animation; the others are: storm, 2 (unnamed)"
        ]
    );

    let take = |name: &str| {
        read("takes.glb", &bytes, &ImportOptions { animation: Some(name.into()), ..plain() })
    };
    let second = take("storm").unwrap();
    let (speed, tilt) = speed_and_tilt(&second);
    assert!((speed - 2.0).abs() < 1e-4 && (tilt - 1.0).abs() < 1e-3, "{speed} {tilt}");
    assert!(second.notes.is_empty(), "{:?}", second.notes);
    assert!((take("2").unwrap().path.descent() - 3.0).abs() < 1e-4);
    // A number is for an animation without a name alone.
    assert_eq!(
        take("1").unwrap_err(),
        "takes.glb: animations: no animation is called \"1\"; there are: calm, storm, 2 (unnamed)"
    );
}

#[test]
fn channels_of_two_takes_are_never_mixed() {
    // The fall is in one take, a turn in the other.
    let [down, turns] = straight(20, 0.5, Quat::from_rotation_z(1.0));
    let bytes = takes(LEAF, &[Take(Some("turn"), vec![turns]), Take(Some("fall"), vec![down])]);
    let imported = read("f.glb", &bytes, &plain()).unwrap();
    assert!(analysis::angle(imported.path.orientations()[5], Quat::IDENTITY) < 1e-3);
    assert_eq!(
        imported.notes.iter().map(|n| n.code).collect::<Vec<_>>(),
        [NoteCode::OtherTakes, NoteCode::NoRotation]
    );
    let turn = ImportOptions { animation: Some("turn".into()), ..plain() };
    assert_eq!(
        read("f.glb", &bytes, &turn).unwrap_err(),
        "f.glb: node \"leaf\": no translation channel"
    );
}

#[test]
fn turns_above_90_degrees_between_keys_are_noted_with_their_time() {
    // 210 degrees a key is told from 150 the other way by nothing.
    let spin = |degrees: f32, interpolation: &'static str| {
        let turns = (0..20)
            .flat_map(|i| Quat::from_rotation_y((degrees * i as f32).to_radians()).to_array());
        let turns = Channel("rotation", interpolation, times(20), turns.collect());
        let [down, _] = straight(20, 0.5, Quat::IDENTITY);
        let bytes = takes(LEAF, &[Take(None, vec![down, (0, turns)])]);
        notes(&read("fast.glb", &bytes, &plain()).unwrap())
    };
    assert_eq!(
        spin(210.0, "LINEAR"),
        [
            "note[fast-turn]: fast.glb: node \"leaf\": turns by 150° from 0.000 s to 0.033 s, and 18 more times \
          above 90°: between keys the shorter way round is taken; export more keys per second"
        ]
    );
    // At the threshold, and where steps are meant, there is nothing to say.
    assert!(spin(90.0, "LINEAR").is_empty());
    assert!(spin(210.0, "STEP").is_empty());

    let mut table = String::from("t,x,y,z,rx,ry,rz\n");
    for i in 0..20 {
        let turn = if i < 10 { 0 } else { 120 };
        writeln!(table, "{},0,{},0,0,{turn},0", i as f32 * 0.1, -0.1 * i as f32).unwrap();
    }
    assert_eq!(
        notes(&read("fast.csv", table.as_bytes(), &plain()).unwrap()),
        [
            "note[fast-turn]: fast.csv: turns by 120° from 0.900 s to 1.000 s: between keys the shorter way round is \
          taken; export more keys per second"
        ]
    );
}

#[test]
fn a_buffer_beside_is_fetched() {
    let take = Take(None, vec![(0, translation(20)), (0, rotation(20))]);
    let (json, bin) = gltf(LEAF, &[take], Some("my%20fall.bin"));
    let mut asked = Vec::new();
    let imported = import_with("sep.gltf", json.as_bytes(), &plain(), &mut |path| {
        asked.push(path.to_owned());
        Ok(bin.clone())
    });
    assert_is_the_fall(&imported.unwrap().path, 20);
    assert_eq!(asked, ["my fall.bin"]);

    let with = |json: &str, found: Result<&[u8], &str>| {
        let found = found.map(<[u8]>::to_vec).map_err(str::to_owned);
        import_with("sep.gltf", json.as_bytes(), &plain(), &mut |_| found.clone())
            .map_err(|e| e.to_string())
            .unwrap_err()
    };
    assert_eq!(
        with(&json, Err("no such file")),
        "sep.gltf: buffer 0: \"my fall.bin\": no such file"
    );
    assert_eq!(with(&json, Ok(&bin[..9])), "sep.gltf: buffer 0: 9 bytes of 720");
    assert_eq!(
        with(&json.replace("my%20fall.bin", "https://a.b/c.bin"), Ok(&bin)),
        "sep.gltf: buffer 0: \"https://a.b/c.bin\" is not a relative path; nothing is fetched elsewhere"
    );
    assert_eq!(
        with(&json.replace("my%20", "my%ff"), Ok(&bin)),
        "sep.gltf: buffer 0: \"my%fffall.bin\" is not a URI: its percent signs are no UTF-8"
    );
    assert_eq!(
        read("sep.gltf", json.as_bytes(), &plain()).unwrap_err(),
        "sep.gltf: buffer 0: \"my%20fall.bin\" is another file; export as .glb, with buffers inside"
    );
}

#[test]
fn motion_of_parents_is_combined() {
    // carrier (moves) > still (turned a quarter about Y, 2 m along X) > leaf (turns about its X).
    let nodes = r#"{"name":"leaf"},{"name":"carrier","children":[2]},
        {"name":"still","children":[0],"translation":[2,0,0],"rotation":[0,0.70710678,0,0.70710678]}"#;
    let turns = (0..20).flat_map(|i| Quat::from_rotation_x(0.1 * i as f32).to_array()).collect();
    let turns = || (0, Channel("rotation", "LINEAR", times(20), Clone::clone(&turns)));
    let carrier = |channel: Channel| (1, channel);
    let bytes = takes(
        nodes,
        &[Take(Some("fall"), vec![carrier(translation(20)), carrier(rotation(20)), turns()])],
    );
    let imported = read("carrier.glb", &bytes, &plain()).unwrap();
    let quarter = Quat::from_rotation_y(90f32.to_radians());
    let place = |i: usize| key(i).1 + key(i).2 * Vec3::new(2.0, 0.0, 0.0);
    for (i, (p, q)) in
        imported.path.positions().iter().zip(imported.path.orientations()).enumerate()
    {
        let expected = place(i) - place(0);
        assert!((*p - expected).length() < 1e-5, "sample {i}: {p} {expected}");
        let turn = key(i).2 * quarter * Quat::from_rotation_x(0.1 * i as f32);
        assert!(analysis::angle(*q, turn) < 2e-3, "sample {i}: {q} {turn}");
    }
    assert_eq!(
        notes(&imported),
        [
            "note[parent-motion]: carrier.glb: node \"leaf\": the motion of its animated parents is combined with its own: \
          node \"carrier\""
        ]
    );

    // A node that moves with its parent alone, by name; and the parent by itself.
    let named = |name: &str| ImportOptions { node: Some(name.into()), ..plain() };
    let still = read("carrier.glb", &bytes, &named("still")).unwrap();
    assert!((still.path.positions()[19] - (place(19) - place(0))).length() < 1e-5);
    let alone = read("carrier.glb", &bytes, &named("carrier")).unwrap();
    assert_is_the_fall(&alone.path, 20);
    assert!(alone.notes.is_empty(), "{:?}", alone.notes);

    // A scale of the parent counts for what is below it.
    let grown = Channel("scale", "LINEAR", vec![0.0, 1.0], vec![3.0; 6]);
    let bytes =
        takes(nodes, &[Take(None, vec![carrier(translation(20)), carrier(grown), turns()])]);
    let scaled = read("carrier.glb", &bytes, &plain()).unwrap();
    assert!((scaled.path.positions()[19] - (key(19).1 - key(0).1)).length() < 1e-5);

    let flat = Channel("scale", "LINEAR", vec![0.0, 1.0], vec![0.0; 6]);
    let bytes = takes(nodes, &[Take(None, vec![carrier(translation(20)), carrier(flat), turns()])]);
    assert_eq!(
        read("carrier.glb", &bytes, &plain()).unwrap_err(),
        "carrier.glb: nodes: the transform of a parent is not finite or flattens everything"
    );
}

#[test]
fn a_parent_whose_motion_is_in_another_take_is_named() {
    let nodes = r#"{"name":"leaf"},{"name":"carrier","children":[0]}"#;
    let turn = Take(Some("turn"), vec![(0, rotation(20))]);
    let bytes = takes(nodes, &[turn, Take(Some("move"), vec![(1, translation(20))])]);
    let turn = ImportOptions { animation: Some("turn".into()), ..plain() };
    assert_eq!(
        read("carrier.glb", &bytes, &turn).unwrap_err(),
        "carrier.glb: node \"leaf\": no translation channel; its parent, node \"carrier\", is moved by another animation, \
         move: bake both into one"
    );
    let leaf = ImportOptions { node: Some("leaf".into()), ..plain() };
    let circle = r#"{"name":"leaf","children":[1]},{"name":"carrier","children":[0]}"#;
    let both = Take(None, vec![(0, rotation(20)), (1, translation(20))]);
    assert_eq!(
        read("circle.glb", &takes(circle, &[both]), &leaf).unwrap_err(),
        "circle.glb: node \"leaf\": it is among its own parents"
    );
    // One node more than may move above a leaf.
    let chain: Vec<String> = (0..66).map(|i| format!(r#"{{"children":[{}]}}"#, i + 1)).collect();
    let chain = format!("{},{LEAF}", chain.join(","));
    let all = Take(None, (0..67).map(|i| (i, translation(8))).collect());
    assert_eq!(
        read("deep.glb", &takes(&chain, &[all]), &leaf).unwrap_err(),
        "deep.glb: node \"leaf\": 66 of its parents are animated; bake the motion into one node"
    );
}

#[test]
fn rotations_with_fewer_keys_are_interpolated() {
    let with = |keys: Vec<f32>, angles: &[f32]| {
        let turns = angles.iter().flat_map(|&a| Quat::from_rotation_y(a).to_array()).collect();
        let turns = Channel("rotation", "LINEAR", keys, turns);
        let bytes = takes(LEAF, &[Take(None, vec![(0, translation(31)), (0, turns)])]);
        read("few.glb", &bytes, &plain())
    };
    let angles = |imported: &Imported| {
        assert_eq!(imported.path.positions().len(), 31);
        assert!((imported.path.rate() - 30.0).abs() < 0.01);
        let angle = |i: usize| analysis::angle(imported.path.orientations()[i], Quat::IDENTITY);
        [angle(0), angle(15), angle(30)]
    };
    let close = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2e-3);

    // Two keys from 0 to 1 s; at half time half the turn.
    let two = with(vec![0.0, 1.0], &[0.0, 1.0]).unwrap();
    assert!(close(angles(&two), [0.0, 0.5, 1.0]), "{:?}", angles(&two));
    assert!(two.notes.is_empty(), "{:?}", two.notes);
    // One key is a rotation that stays.
    let one = with(vec![0.0], &[0.7]).unwrap();
    assert!(close(angles(&one), [0.7; 3]), "{:?}", angles(&one));
    assert!(one.notes.is_empty(), "{:?}", one.notes);
    // Keys of the middle alone: held before and after.
    let middle = with(vec![0.25, 0.75], &[0.2, 0.6]).unwrap();
    assert!(close(angles(&middle), [0.2, 0.4, 0.6]), "{:?}", angles(&middle));
    assert_eq!(
        notes(&middle),
        [
            "note[rotation-held]: few.glb: node \"leaf\": has rotation keys from 0.250 s to 0.750 s only: the first and \
          last are held from 0.000 s to 1.000 s"
        ]
    );
    assert_eq!(
        with(vec![2.0, 3.0], &[0.0, 1.0]).unwrap_err(),
        "few.glb: node \"leaf\": translation and rotation have no time in common"
    );
    assert_eq!(with(vec![], &[]).unwrap_err(), "few.glb: accessor 2: reaches beyond its buffer");
}

#[test]
fn decimal_commas_are_read() {
    let table = csv(20).replace(',', ";").replace('.', ",");
    assert!(table.contains("0,033333335;"));
    assert_is_the_fall(&read("f.csv", table.as_bytes(), &plain()).unwrap().path, 20);
    let tabs = table.replace(';', "\t");
    assert_is_the_fall(&read("f.tsv", tabs.as_bytes(), &plain()).unwrap().path, 20);

    // Quoted, they may stand between commas.
    let quoted = each_line(&csv(20), |line| {
        format!("\"{}\"\n", line.replace(',', "\",\"").replace('.', ","))
    });
    assert_is_the_fall(&read("f.csv", quoted.as_bytes(), &plain()).unwrap().path, 20);

    let refused = |table: String| read("f.csv", table.as_bytes(), &plain()).unwrap_err();
    // A thousand is not one: the signs of a file are the same throughout.
    let header = "t;x;y;z;qx;qy;qz;qw\n";
    assert_eq!(
        refused(format!("{header}0.5;0;0;0;0;0;0;1\n1,000;0;0;0;0;0;0;1\n")),
        "f.csv: line 3: \"1,000\" has a decimal ',', line 2 has '.'"
    );
    assert_eq!(
        refused(format!("{header}1,000.5;0;0;0;0;0;0;1\n")),
        "f.csv: line 2: \"1,000.5\" is no number"
    );
    assert_eq!(
        refused(table.replace(';', ",")),
        "f.csv: line 2: 11 fields under 8 columns: if decimals are commas, separate columns by semicolons"
    );
}

#[test]
fn quoted_fields_are_read() {
    let quoted = each_line(&csv(20), |line| format!("\"{}\"\r\n", line.replace(',', "\", \"")));
    assert_is_the_fall(&read("f.csv", quoted.as_bytes(), &plain()).unwrap().path, 20);

    // A separator, a quote and a line break in a name are none outside of it; lines are counted as they stand.
    let name = "t,x,y,z,rx,ry,rz,\"a;\"\"b\"\"\nc\"\n";
    let mut rows = String::new();
    for i in 0..20 {
        writeln!(rows, "{i},0,-{i},0,0,0,0,5").unwrap();
    }
    let imported = read("f.csv", format!("{name}{rows}").as_bytes(), &plain()).unwrap();
    assert_eq!(notes(&imported), ["note[columns-left-out]: f.csv: left out: columns a;\"b\"\nc"]);
    let refused =
        |row: &str| read("f.csv", format!("{name}{row}\n").as_bytes(), &plain()).unwrap_err();
    assert_eq!(refused("\"0\",\"b\""), "f.csv: line 3: \"b\" is no number");
    assert_eq!(refused("\"0\",\"1"), "f.csv: line 3: a quote that is not closed");
    assert_eq!(refused("\"0\"1,2"), "f.csv: line 3: text behind a closing quote");
}

/// The rows of [`csv`] with a frame number from 1 for the time.
fn frames(header: &str) -> String {
    let mut frame = 0;
    each_line(&csv(20), |line| {
        frame += 1;
        let rest = line.split_once(',').map_or("", |parts| parts.1);
        if frame == 1 { format!("{header}\n") } else { format!("{},{rest}\n", frame - 1) }
    })
}

#[test]
fn frame_numbers_and_the_names_of_other_programs_are_read() {
    let fps = ImportOptions { fps: Some(30.0), ..plain() };
    for header in [
        "frame,P[x],P[y],P[z],orient[0],orient[1],orient[2],orient[3]",
        "frame,P[0],P[1],P[2],orient.x,orient.y,orient.z,orient.w",
        "Frame,tx,ty,tz,qx,qy,qz,qw",
        "FRAMES,location_x,location_y,location_z,rotation_quaternion_x,rotation_quaternion_y,\
         rotation_quaternion_z,rotation_quaternion_w",
        "frame,translateX,translateY,translateZ,quat X,quat Y,quat Z,quat W",
    ] {
        let imported = read("f.csv", frames(header).as_bytes(), &fps).unwrap();
        assert_is_the_fall(&imported.path, 20);
        assert!(imported.notes.is_empty(), "{header}: {:?}", imported.notes);
    }
    let header = "Frame,tx,ty,tz,qx,qy,qz,qw";
    assert_eq!(
        read("f.csv", frames(header).as_bytes(), &plain()).unwrap_err(),
        "f.csv: header: no column \"time\", but \"Frame\": give the frames per second with --fps; columns are: \
         Frame, tx, ty, tz, qx, qy, qz, qw"
    );
    assert_eq!(
        read("f.csv", frames("n,tx,ty,tz,qx,qy,qz,qw").as_bytes(), &fps).unwrap_err(),
        "f.csv: header: no column \"time\"; columns are: n, tx, ty, tz, qx, qy, qz, qw"
    );
    assert_eq!(
        read("f.csv", frames("frame,tx,ty,x,qx,qy,qz,qw").as_bytes(), &fps).unwrap_err(),
        "f.csv: header: no column \"y\"; columns are: frame, tx, ty, x, qx, qy, qz, qw"
    );
    // Times count more than frames, and plain names more than others.
    let both = each_line(&csv(20), |line| {
        if line.starts_with("time") {
            format!(
                "{line},frame,tx,ty,tz
"
            )
        } else {
            format!(
                "{line},0,0,0,0
"
            )
        }
    });
    let imported = read("f.csv", both.as_bytes(), &fps).unwrap();
    assert_is_the_fall(&imported.path, 20);
    assert_eq!(imported.repairs, ["left out: columns frame, tx, ty, tz"]);

    // JSON has the same names.
    let rows = frames(header)
        .lines()
        .skip(1)
        .map(|line| {
            let fields =
                header.split(',').zip(line.split(',')).map(|(k, v)| format!("\"{k}\":{v}"));
            format!("{{{}}}", fields.collect::<Vec<_>>().join(","))
        })
        .collect::<Vec<_>>();
    let json = format!("[{}]", rows.join(","));
    assert_is_the_fall(&read("f.json", json.as_bytes(), &fps).unwrap().path, 20);

    for fps in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let options = ImportOptions { fps: Some(fps), ..plain() };
        assert_eq!(
            read("f.csv", frames(header).as_bytes(), &options).unwrap_err(),
            format!("f.csv: options: {fps} frames per second must be above 0")
        );
    }
}

#[test]
fn milliseconds_are_read_and_suspected() {
    let mut table = String::from("time,x,y,z,qx,qy,qz,qw\n");
    for i in 0..20 {
        let (t, p, q) = key(i);
        writeln!(table, "{},{},{},{},{},{},{},{}", t * 1e3, p.x, p.y, p.z, q.x, q.y, q.z, q.w)
            .unwrap();
    }
    let milliseconds = ImportOptions { time_unit: TimeUnit::Milliseconds, ..plain() };
    assert_is_the_fall(&read("f.csv", table.as_bytes(), &milliseconds).unwrap().path, 20);
    assert_eq!(
        read("f.csv", table.as_bytes(), &plain()).unwrap_err(),
        "f.csv: line 2 to line 21: rate 0.03 Hz: are times in milliseconds? Then give --time-unit ms \
         (1 to 10000 Hz can be read)"
    );
    // Uneven ones would be resampled to 60 Hz, to more samples than there may be.
    let uneven = table.replacen("\n0,", "\n-1e6,", 1);
    assert_eq!(
        read("f.csv", uneven.as_bytes(), &plain()).unwrap_err(),
        "f.csv: line 2 to line 21: rate 1.9e-5 Hz: are times in milliseconds? Then give --time-unit ms \
         (1000633.3333 s at 60 Hz are more than 1048576 samples)"
    );
    // Seconds as milliseconds: 0.000633 s for 19 distances.
    assert_eq!(
        read("f.csv", csv(20).as_bytes(), &milliseconds).unwrap_err(),
        "f.csv: line 2 to line 21: rate 30000.00 Hz: are times in seconds? Then leave out --time-unit ms \
         (1 to 10000 Hz can be read)"
    );
}

#[test]
fn notes_have_stable_codes() {
    let codes = NoteCode::ALL.map(NoteCode::code);
    for (i, code) in codes.iter().enumerate() {
        assert!(code.bytes().all(|b| b.is_ascii_lowercase() || b == b'-'), "{code}");
        assert!(!codes[..i].contains(code), "{code} twice");
    }
}
