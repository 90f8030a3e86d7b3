//! `windfall simplify`: files with a share of a tree's leaves.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::Place;
use serde_json::Value;

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// The JSON document of a .glb file.
fn document(bytes: &[u8]) -> Value {
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).unwrap()
}

#[test]
fn a_share_of_the_leaves_is_kept_and_grows() {
    let place = Place::new();
    let report = json(
        &place
            .succeed("simplify ginkgo --lambda 0.1 --prune-order blue-noise --out few.glb --json"),
    );
    let number = |field: &str| report[field].as_f64().unwrap();
    assert!((number("leaves") / number("leaves_full") - 0.1).abs() < 1e-3, "{report}");
    assert!((number("leaf_triangles") / number("leaf_triangles_full") - 0.1).abs() < 0.01);
    // Ten times the area, but that few of them hide each other: as much as lies between a quarter and a
    // sixteenth of the leaves.
    let factor = |i: usize| report["disocclusion"][i].as_f64().unwrap();
    let at = 10f64.log(4.0) - 1.0;
    let area = 10.0 * (factor(0) * (1.0 - at) + factor(1) * at);
    assert!((number("growth").powi(2) / area - 1.0).abs() < 0.01, "{report}");
    assert!(factor(1) < 0.9, "{report}");
    let wood = number("wood_triangles") / number("wood_triangles_full");
    assert!((0.07..0.14).contains(&wood), "{report}");
    assert!(number("wood_error_m") > 0.0);
    let read = json(&place.succeed("tree inspect few.glb --json"));
    assert_eq!(read["leaf_triangles"], report["leaf_triangles"]);
    assert_eq!(read["wood_triangles"], report["wood_triangles"]);

    let plain = "--no-area-preservation --wood full --json";
    let report = json(&place.succeed(&format!("simplify ginkgo --lambda 0.1 --out b.glb {plain}")));
    assert_eq!([&report["growth"], &report["wood_error_m"]], [1.0, 0.0]);
    assert_eq!(report["wood_triangles"], report["wood_triangles_full"]);
    place.succeed("simplify ginkgo --lambda 0.1 --wood none --out c.glb");
    assert_eq!(json(&place.succeed("tree inspect c.glb --json"))["wood_triangles"], 0);
    assert_ne!(place.read("b.glb"), place.read("c.glb"));
}

#[test]
fn survivors_cover_what_they_make_up_for() {
    let place = Place::new();
    let report = json(&place.succeed("simplify tiny.glb --lambda 0.5 --out half.glb --json"));
    // Two cards side by side: r = ½ about, and s = (1 - ½²)/½ = 1½.
    let r = report["visible_share"].as_f64().unwrap();
    let growth = report["growth"].as_f64().unwrap();
    assert!((0.45..0.55).contains(&r), "{report}");
    assert!((growth * growth - (2.0 - r)).abs() < 1e-3, "{report}");
    // It grows about its centre, 2.5 m up.
    let read = json(&place.succeed("tree inspect half.glb --json"));
    assert_eq!(read["leaves"], 1);
    assert!((read["height_m"].as_f64().unwrap() - 2.5 - 0.5 * growth).abs() < 1e-3, "{read}");
}

#[test]
fn all_leaves_in_order_can_be_drawn_by_prefix() {
    let place = Place::new();
    place.succeed("simplify birch --all-in-order --prune-order blue-noise --out all.glb");
    let bytes = place.read("all.glb");
    let document = document(&bytes);
    let leaves = &document["meshes"][1]["primitives"][0];
    let number = |value: &Value| value.as_u64().unwrap() as usize;
    let accessor = |value: &Value| &document["accessors"][number(value)];
    let extras = &leaves["extras"];
    let (count, each) = (number(&extras["leaves"]), number(&extras["indicesPerLeaf"]));
    assert!((0.0..1.0).contains(&extras["visibleShare"].as_f64().unwrap()), "{extras}");
    let indices = accessor(&leaves["indices"]);
    assert_eq!(number(&indices["count"]), count * each);

    // Every leaf's indices refer to vertices of its own rank.
    let json_length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let word = |accessor: &Value, word: usize| -> [u8; 4] {
        let view = &document["bufferViews"][number(&accessor["bufferView"])];
        let at = 28 + json_length + number(&view["byteOffset"]) + 4 * word;
        bytes[at..at + 4].try_into().unwrap()
    };
    let of_leaf = accessor(&leaves["attributes"]["_LEAF"]);
    for leaf in [0, 1, count / 2, count - 1] {
        for i in leaf * each..(leaf + 1) * each {
            let vertex = u32::from_le_bytes(word(indices, i)) as usize;
            let rank = f32::from_le_bytes(word(of_leaf, 4 * vertex + 3));
            assert!((rank - leaf as f32 / count as f32).abs() < 1e-6, "{leaf}: {rank}");
        }
    }
    place.succeed("tree inspect all.glb");
}

#[test]
fn the_same_command_writes_the_same_bytes() {
    let place = Place::new();
    for order in ["random", "importance", "blue-noise"] {
        for out in ["a.glb", "b.glb"] {
            place
                .succeed(&format!("simplify aspen --lambda 0.2 --prune-order {order} --out {out}"));
        }
        assert_eq!(place.read("a.glb"), place.read("b.glb"), "{order}");
    }
}

#[test]
fn what_cannot_be_simplified_is_said() {
    let place = Place::new();
    for (arguments, words) in [
        ("tiny.glb --lambda 0 --out a.glb", ["--lambda 0", "above 0"]),
        ("tiny.glb --lambda 1.5 --out a.glb", ["--lambda 1.5", "at most 1"]),
        ("tiny.glb --lambda nan --out a.glb", ["--lambda NaN", "share"]),
        ("tiny.glb --lambda 0.5 --out ./tiny.glb", ["tiny.glb", "read"]),
        ("tiny.glb --lambda 0.5 --out a.obj", ["a.obj", ".glb"]),
        ("missing.glb --lambda 0.5 --out a.glb", ["missing.glb", "cannot be read"]),
        ("small.ron --lambda 0.5 --out a.glb", ["small.ron", ""]),
        ("oak --lambda 0.5 --height 0 --out a.glb", ["height", "0.01"]),
    ] {
        place.fail(1, &format!("simplify {arguments}"), &words);
    }
    for arguments in [
        "tiny.glb --out a.glb",
        "tiny.glb --lambda 0.5",
        "tiny.glb --lambda 0.5 --prune-order pink --out a.glb",
        "tiny.glb --lambda 0.5 --all-in-order --out a.glb",
        "tiny.glb --lambda 0.5 --wood some --out a.glb",
    ] {
        place.fail(2, &format!("simplify {arguments}"), &["--help"]);
    }
}
