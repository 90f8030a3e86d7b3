//! glTF, read back by a reader of its own. `scripts/check-export` has the Khronos validator read it.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::{MOMENTS, Place, angle, reference, select};
use serde_json::Value;
use std::collections::BTreeSet;
use windfall_core::glam::{Quat, Vec3};
use windfall_export::{ExportError, Filter, LeafId, Moments, gltf};

struct File {
    json: Value,
    binary: Vec<u8>,
}

impl File {
    fn new(bytes: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!(word(8), bytes.len());
        let end = 20 + word(12);
        let json: Value = serde_json::from_slice(&bytes[20..end]).unwrap();
        assert_eq!(word(end), bytes.len() - end - 8);
        let binary = bytes[end + 8..].to_vec();
        assert_eq!(json["buffers"][0]["byteLength"], binary.len());
        Self { json, binary }
    }

    /// Floats of an accessor, `n` each.
    fn floats(&self, accessor: &Value, n: usize) -> Vec<Vec<f32>> {
        let accessor = &self.json["accessors"][accessor.as_u64().unwrap() as usize];
        let view = &self.json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let first = view["byteOffset"].as_u64().unwrap() as usize;
        let count = accessor["count"].as_u64().unwrap() as usize;
        let bytes = &self.binary[first..first + count * n * 4];
        assert_eq!(view["byteLength"], bytes.len());
        let all: Vec<f32> =
            bytes.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
        all.chunks(n).map(<[f32]>::to_vec).collect()
    }
}

fn write(moments: Moments, parts: &str) -> (Place, File) {
    let place = Place::new();
    let source = place.source();
    let filter = Filter { parts: parts.parse().unwrap(), ..Filter::NONE };
    let mut bytes = Vec::new();
    gltf::write_glb(&select(&source, moments, filter), &mut bytes, &mut |_| ()).unwrap();
    let file = File::new(&bytes);
    (place, file)
}

fn close(position: &[f32], rotation: &[f32], leaf: &common::Where) -> bool {
    Vec3::from_slice(position).distance(leaf.position) < 1e-5
        && angle(Quat::from_slice(rotation), leaf.orientation) < 0.01
}

#[test]
fn a_moment_has_an_instance_for_each_leaf() {
    let one = Moments { count: 1, ..MOMENTS };
    let (place, file) = write(one, "falling,landed,hanging,trees,ground");
    let expected = reference(&place.source(), one.time(one.first));
    let mut seen = BTreeSet::new();
    for node in file.json["nodes"].as_array().unwrap() {
        let attributes = &node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
        if attributes.is_null() {
            continue;
        }
        let of = |name: &str, n: usize| file.floats(&attributes[name], n);
        let (translations, rotations, scales) =
            (of("TRANSLATION", 3), of("ROTATION", 4), of("SCALE", 3));
        for (i, (tree, leaf)) in of("_TREE", 1).iter().zip(&of("_LEAF", 1)).enumerate() {
            let id = LeafId((tree[0] as u64) << 32 | leaf[0] as u64);
            assert!(close(&translations[i], &rotations[i], &expected[&id]), "{id}");
            assert_eq!(scales[i][0], expected[&id].scale);
            seen.insert(id);
        }
    }
    assert!(seen.iter().eq(expected.keys()));
    // Trees with levels, coarsest last.
    let tree = &file.json["nodes"].as_array().unwrap().iter();
    let tree = tree.clone().find(|n| n["name"] == "tree 0").unwrap();
    let ids = tree["extensions"]["MSFT_lod"]["ids"].as_array().unwrap();
    let coverage = tree["extras"]["MSFT_screencoverage"].as_array().unwrap();
    assert!(!ids.is_empty() && coverage.len() == ids.len() + 1);
}

#[test]
fn an_animation_moves_a_node_for_each_leaf() {
    let (place, file) = write(MOMENTS, "falling");
    let source = place.source();
    let frames: Vec<_> =
        MOMENTS.frames().map(|frame| reference(&source, MOMENTS.time(frame))).collect();
    let animation = &file.json["animations"][0];
    let times = file.floats(&animation["samplers"][0]["input"], 1);
    assert!(times.iter().zip(0..).all(|(t, i)| (t[0] - i as f32 / 6.0).abs() < 1e-5));
    let channels = animation["channels"].as_array().unwrap();
    assert!(channels.len() > 300 && channels.len() % 3 == 0);
    for of_leaf in channels.chunks(3) {
        let [t, r, s] = [(0, 3), (1, 4), (2, 3)].map(|(i, n)| {
            let sampler = of_leaf[i]["sampler"].as_u64().unwrap() as usize;
            file.floats(&animation["samplers"][sampler]["output"], n)
        });
        let node = of_leaf[0]["target"]["node"].as_u64().unwrap() as usize;
        let extras = &file.json["nodes"][node]["extras"];
        let id = extras["tree"].as_u64().unwrap() << 32 | extras["leaf"].as_u64().unwrap();
        for (frame, expected) in frames.iter().enumerate() {
            let leaf = &expected[&LeafId(id)];
            assert!(close(&t[frame], &r[frame], leaf), "{id} in frame {frame}");
            let size = if leaf.phase == "falling" { leaf.scale } else { 0.0 };
            assert_eq!(s[frame][0], size, "{id} in frame {frame}");
        }
    }
}

#[test]
fn an_animation_of_a_forest_is_refused() {
    let mut place = Place::new();
    place.forest.instances = [place.forest.instances[0]; 60].to_vec();
    let source = place.source();
    let selection = select(&source, MOMENTS, Filter::NONE);
    let error = gltf::write_glb(&selection, &mut Vec::new(), &mut |_| ()).unwrap_err();
    assert!(matches!(error, ExportError::TooManyLeaves { leaves: 24_000, .. }), "{error}");
    assert!(error.to_string().contains("--most 20000"), "{error}");
}
