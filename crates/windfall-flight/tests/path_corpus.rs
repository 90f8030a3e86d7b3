//! Replays the corpora of the fuzz targets `path_ron`, `path_csv`, `path_json` and `path_gltf`: a path or an error,
//! never a panic.
#![expect(clippy::unwrap_used, reason = "this is test code")]

mod common;

use common::{Channel, Take, csv, glb, gltf, json, rotation, takes, times, translation};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use windfall_core::InputError;
use windfall_core::path::PathSet;
use windfall_flight::{ImportOptions, TimeUnit, import, import_with, read_paths, to_ron};

fn corpus(target: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus").join(target)
}

/// The set that bytes are, as the target reads them.
fn read(target: &str, name: &str, bytes: &[u8]) -> Result<PathSet, InputError> {
    if target == "path_ron" {
        return read_paths(name, bytes);
    }
    PathSet::new(vec![import(name, bytes, &ImportOptions::default())?.path])
}

/// Reads bytes with every option that the target leaves out: a path or an error.
fn read_otherwise(target: &str, name: &str, bytes: &[u8]) {
    if target == "path_ron" {
        return;
    }
    let options = ImportOptions {
        animation: Some("storm".into()),
        fps: Some(30.0),
        time_unit: TimeUnit::Milliseconds,
        rate: Some(50.0),
        ..ImportOptions::default()
    };
    let beside = gltf(LEAF, &[fall("calm")], None).1;
    let _ = import_with(name, bytes, &options, &mut |_| Ok(beside.clone()));
}

const LEAF: &str = r#"{"name":"leaf"}"#;

fn fall(name: &'static str) -> Take {
    Take(Some(name), vec![(0, translation(20)), (0, rotation(20))])
}

/// Reads every file of a corpus, and each with a bit of every byte flipped.
fn replay(target: &str, least_read: u32, least_refused: u32) {
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(corpus(target)).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    let (mut read_whole, mut refused) = (0, 0);
    for path in &files {
        let name = path.file_name().unwrap().to_string_lossy();
        let bytes = std::fs::read(path).unwrap();
        match read(target, &name, &bytes) {
            Ok(set) => {
                read_paths("again", to_ron(&set).as_bytes()).unwrap();
                read_whole += 1;
            }
            Err(error) => {
                assert!(error.to_string().starts_with(&*name), "{error}");
                refused += 1;
            }
        }
        read_otherwise(target, &name, &bytes);
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 1 << (at % 8);
            let _ = read(target, &name, &damaged);
            read_otherwise(target, &name, &damaged);
        }
    }
    let counts = format!("{target}: {read_whole} read, {refused} refused");
    assert!(read_whole >= least_read && refused >= least_refused, "{counts}");
}

#[test]
fn path_sets_in_ron_are_read_or_refused() {
    replay("path_ron", 2, 5);
}

#[test]
fn tables_in_csv_are_read_or_refused() {
    replay("path_csv", 6, 11);
}

#[test]
fn tables_in_json_are_read_or_refused() {
    replay("path_json", 4, 8);
}

#[test]
fn animations_in_gltf_are_read_or_refused() {
    replay("path_gltf", 10, 6);
}

/// Writes the seeds anew: `cargo test -p windfall-flight --test path_corpus -- --ignored`.
#[test]
#[ignore = "writes files"]
fn write_the_seeds() {
    let write = |target: &str, name: &str, bytes: &[u8]| {
        std::fs::create_dir_all(corpus(target)).unwrap();
        std::fs::write(corpus(target).join(name), bytes).unwrap();
    };
    let table = csv(20);
    let set = read("path_csv", "fall.csv", table.as_bytes()).unwrap();

    let ron = to_ron(&set);
    write("path_ron", "valid.ron", ron.as_bytes());
    write("path_ron", "valid.bin", &set.to_bytes());
    write("path_ron", "empty.ron", b"");
    write("path_ron", "no-paths.ron", b"(version: 1, paths: [])");
    write("path_ron", "version.ron", ron.replace("version: 1", "version: 7").as_bytes());
    write("path_ron", "unknown-field.ron", ron.replace("rate:", "pace:").as_bytes());
    write("path_ron", "poison.ron", ron.replacen("0.0", "NaN", 1).as_bytes());
    write("path_ron", "truncated.ron", &ron.as_bytes()[..ron.len() / 2]);
    write("path_ron", "not-utf8.ron", &[0xff, 0xfe, 0x00]);

    let line = |i: usize| table.lines().nth(i).unwrap();
    write("path_csv", "valid.csv", table.as_bytes());
    let euler = (0..20).fold("# degrees\nT;X;Y;Z;RX;RY;RZ;more\n\n".to_string(), |text, i| {
        format!("{text}{};0;{};0;{};0;0;1\n", f64::from(i) * 0.1, f64::from(-i), i * 9)
    });
    write("path_csv", "euler.csv", euler.as_bytes());
    write("path_csv", "empty.csv", b"");
    write("path_csv", "header.csv", line(0).as_bytes());
    write("path_csv", "no-orientation.csv", b"t,x,y,z\n0,0,0,0\n1,0,-1,0\n");
    write("path_csv", "words.csv", table.replacen(line(5), "a,b,c,d,e,f,g,h", 1).as_bytes());
    write("path_csv", "poison.csv", table.replacen(line(5), "0.1,NaN,0,0,0,0,0,1", 1).as_bytes());
    write("path_csv", "backwards.csv", table.replacen(line(5), line(3), 1).as_bytes());
    let far = "1e9,0,-1,0,0,0,0,1\n";
    write("path_csv", "too-long.csv", format!("{table}{far}").as_bytes());
    write("path_csv", "upwards.csv", table.replace(",-", ",").as_bytes());

    let commas = table.replace(',', ";").replace('.', ",");
    write("path_csv", "decimal-commas.csv", commas.as_bytes());
    write("path_csv", "mixed-decimals.csv", commas.replacen("0,0", "0.0", 1).as_bytes());
    let mut quoted = String::new();
    for line in table.lines() {
        write!(quoted, "\"{}\"\r\n", line.replace(',', "\",\"")).unwrap();
    }
    write("path_csv", "quoted.csv", quoted.as_bytes());
    write("path_csv", "open-quote.csv", &quoted.as_bytes()[..quoted.len() - 3]);
    write("path_csv", "behind-quote.csv", quoted.replacen("\",", "\"1,", 12).as_bytes());
    let named = table.replacen("time,", "\"a,\"\"b\"\"\nc\",time,", 1).replace("\n0", "\n7,0");
    write("path_csv", "quoted-name.csv", named.as_bytes());
    let houdini = "frame,P[x],P[y],P[z],orient[0],orient[1],orient[2],orient[3]";
    write("path_csv", "frames.csv", table.replacen(line(0), houdini, 1).as_bytes());
    let names = houdini.replace("frame", "time");
    write("path_csv", "names.csv", table.replacen(line(0), &names, 1).as_bytes());
    let mut slow = String::from("t,x,y,z,rx,ry,rz\n");
    for i in 0..20 {
        writeln!(slow, "{},0,-{i},0,0,0,0", i * 17).unwrap();
    }
    write("path_csv", "milliseconds.csv", slow.as_bytes());

    let samples = json(20);
    let list = samples.trim_start_matches("{\"samples\":").trim_end_matches('}');
    write("path_json", "valid.json", samples.as_bytes());
    write("path_json", "list.json", list.as_bytes());
    write("path_json", "empty.json", b"[]");
    write("path_json", "truncated.json", &samples.as_bytes()[..samples.len() / 2]);
    write("path_json", "other.json", b"{\"samples\": {\"t\": [0, 1]}}");
    write("path_json", "missing.json", samples.replacen("\"x\"", "\"a\"", 2).as_bytes());
    write("path_json", "gltf.json", b"{\"asset\": {\"version\": \"2.0\"}, \"animations\": []}");
    write("path_json", "huge.json", samples.replacen("\"t\":0", "\"t\":-1e300", 1).as_bytes());

    write("path_json", "frames.json", samples.replace("\"t\"", "\"frame\"").as_bytes());
    let names = samples.replace("\"x\"", "\"P[x]\"");
    let names = names.replace("\"y\"", "\"P[y]\"").replace("\"z\"", "\"P[z]\"");
    write("path_json", "names.json", names.as_bytes());
    let (beside, bin) = gltf(LEAF, &[fall("storm")], Some("fall.bin"));
    write("path_json", "beside.gltf", beside.as_bytes());
    let inside = format!("data:application/octet-stream;base64,{}", base64(&bin));
    write("path_json", "inside.gltf", beside.replace("fall.bin", &inside).as_bytes());
    write("path_json", "elsewhere.gltf", beside.replace("fall.bin", "http://a/b").as_bytes());

    write("path_gltf", "takes.glb", &takes(LEAF, &[fall("calm"), fall("storm")]));
    let nodes = r#"{"name":"leaf"},{"name":"carrier","children":[0]}"#;
    let carried = vec![(1, translation(20)), (1, rotation(5)), (0, rotation(20))];
    write("path_gltf", "carrier.glb", &takes(nodes, &[Take(Some("storm"), carried)]));
    let parts = [Take(None, vec![(0, rotation(20))]), Take(None, vec![(1, translation(20))])];
    write("path_gltf", "carrier-takes.glb", &takes(nodes, &parts));
    let circle = r#"{"name":"leaf","children":[1]},{"name":"carrier","children":[0]}"#;
    write("path_gltf", "circle.glb", &takes(circle, &[fall("storm")]));
    let still = Channel("rotation", "LINEAR", vec![0.0], vec![0.0, 0.0, 0.0, 1.0]);
    let still = vec![(0, translation(20)), (0, still)];
    write("path_gltf", "one-rotation.glb", &takes(LEAF, &[Take(None, still)]));
    let spin = (0..20).flat_map(|i| [0.0, [1.0, 0.0][i % 2], 0.0, [0.0, 1.0][i % 2]]).collect();
    let spin = Channel("rotation", "LINEAR", times(20), spin);
    write(
        "path_gltf",
        "fast.glb",
        &takes(LEAF, &[Take(None, vec![(0, translation(20)), (0, spin)])]),
    );

    let both = || vec![translation(20), rotation(20)];
    let valid = glb(&[both()]);
    write("path_gltf", "valid.glb", &valid);
    let step = vec![Channel("translation", "STEP", times(20), translation(20).3), rotation(20)];
    write("path_gltf", "step.glb", &glb(&[step]));
    let tripled = |channel: &Channel, width: usize| {
        let chunks = channel.3.chunks(width);
        chunks
            .flat_map(|value| [vec![0.0; width], value.to_vec(), vec![0.0; width]].concat())
            .collect()
    };
    let spline = [translation(20), rotation(20)].map(|channel| {
        let width = if channel.0 == "rotation" { 4 } else { 3 };
        let values = tripled(&channel, width);
        Channel(channel.0, "CUBICSPLINE", times(20), values)
    });
    write("path_gltf", "spline.glb", &glb(&[spline.into()]));
    write("path_gltf", "two-nodes.glb", &glb(&[both(), both()]));
    write("path_gltf", "no-rotation.glb", &glb(&[vec![translation(20)]]));
    write("path_gltf", "few-values.glb", &glb(&[vec![translation(20), rotation(5)]]));
    write("path_gltf", "header.glb", &valid[..12]);
    write("path_gltf", "truncated.glb", &valid[..valid.len() / 2]);
    let mut poison = valid.clone();
    let end = poison.len();
    poison[end - 4..].copy_from_slice(&f32::NAN.to_le_bytes());
    write("path_gltf", "poison.glb", &poison);
    let target = br#""node":0,"path""#;
    let at = valid.windows(target.len()).position(|window| window == target).unwrap();
    let mut nowhere = valid.clone();
    nowhere[at + 7] = b'8';
    write("path_gltf", "no-node.glb", &nowhere);
}

fn base64(bytes: &[u8]) -> String {
    let digits = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let three = |c: &[u8]| c.iter().fold(0, |word, &b| word << 8 | usize::from(b));
    // Buffers are of whole words of four bytes, and here of whole threes too.
    bytes
        .chunks_exact(3)
        .flat_map(|c| [18, 12, 6, 0].map(|shift| char::from(digits[three(c) >> shift & 63])))
        .collect()
}
