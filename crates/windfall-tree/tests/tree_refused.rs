//! Bad trees: each is refused with the file, the place and the cause, without a panic.

mod common;

use common::{CARD, LEAVES, Model, U32};
use proptest::prelude::*;
use serde_json::json;
use windfall_core::{InputError, InputErrorKind as Kind};
use windfall_tree::{ImportOptions, import};

fn refused(bytes: &[u8]) -> InputError {
    import(bytes, "tree.glb", &ImportOptions::default(), &mut |_| Err("no such file".into()))
        .map(|read| read.tree)
        .expect_err("this is to be refused")
}

/// The model is refused, of this kind, with these parts in its message.
#[track_caller]
fn assert_refused(model: &Model, kind: Kind, parts: &[&str]) {
    let error = refused(&model.glb());
    let message = error.to_string();
    assert_eq!(error.kind, kind, "{message}");
    assert!(message.starts_with("tree.glb: "), "{message}");
    for part in parts {
        assert!(message.contains(part), "{message:?} lacks {part:?}");
    }
}

#[test]
fn the_whole_model_is_read() {
    assert_eq!(Model::tree().import().unwrap().foliage.leaves.len(), 2);
}

#[test]
fn empty_and_foreign_files() {
    let error = refused(b"");
    assert_eq!(error.kind, Kind::Empty);
    assert_eq!(error.to_string(), "tree.glb: the file is empty (0 bytes)");
    for garbage in [b"\0\0\0\0".as_slice(), b"PK\x03\x04", b"glT", b"# a text"] {
        let error = refused(garbage);
        assert_eq!(error.kind, Kind::Malformed);
        assert!(error.cause.contains("neither a binary glTF"), "{error}");
    }
    assert!(refused(b"{").to_string().contains("JSON: not a glTF document: EOF"));
    assert!(refused(b"{}").to_string().contains("no version"));
    // Nested deeper than the JSON reader goes: no stack overflow.
    let deep = format!("{{\"asset\":{}", "[".repeat(100_000));
    assert_eq!(refused(deep.as_bytes()).kind, Kind::Malformed);
}

#[test]
fn every_truncation() {
    let bytes = Model::tree().glb();
    for length in 0..bytes.len() {
        let error = refused(&bytes[..length]);
        if length >= 12 {
            let cause = format!("truncated: {length} bytes of the {} announced", bytes.len());
            assert_eq!(error.to_string(), format!("tree.glb: GLB header: {cause}"));
        }
    }
}

#[test]
fn chunks_that_lie() {
    let mut bytes = Model::tree().glb();
    bytes[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    let error = refused(&bytes);
    assert!(
        error.to_string().contains("GLB chunk: truncated: the chunk at byte 12 says 4294967295")
    );
    let mut bytes = Model::tree().glb();
    bytes[16..20].copy_from_slice(b"NOSJ");
    assert!(refused(&bytes).to_string().contains("there is no JSON chunk"));
    let mut bytes = Model::tree().glb();
    bytes[4] = 1;
    assert!(refused(&bytes).to_string().contains("GLB header: version 1; 2 is supported"));
}

#[test]
fn versions_and_extensions_are_refused_by_name() {
    let mut model = Model::tree();
    model.json["asset"]["version"] = json!("3.1");
    assert_refused(&model, Kind::Unsupported, &["asset: ", "\"3.1\" is not supported"]);
    for name in ["KHR_draco_mesh_compression", "EXT_nonsense"] {
        let mut model = Model::tree();
        model.json["extensionsRequired"] = json!(["KHR_mesh_quantization", name]);
        assert_refused(&model, Kind::Unsupported, &["extensionsRequired: ", name]);
        model.json["extensionsRequired"] = json!([]);
        model.json["extensionsUsed"] = json!([name, "KHR_materials_specular"]);
        model.import().expect("what is only used is not needed");
    }
}

#[test]
fn missing_buffers_and_pictures() {
    let mut model = Model::tree();
    model.json["buffers"][0]["uri"] = json!("oak%20bark.bin");
    assert_refused(&model, Kind::Missing, &["buffer 0: \"oak bark.bin\": no such file"]);
    model.json["buffers"][0]["uri"] = json!("https://example.org/a.bin");
    assert_refused(&model, Kind::Unsupported, &["buffer 0: ", "not a relative path"]);
    model.json["buffers"][0]["uri"] = json!("data:application/octet-stream;base64,AAAA");
    assert_refused(&model, Kind::OutOfRange, &["buffer 0: announces", "its data has 3"]);
    model.json["buffers"] = json!([{ "byteLength": 4 }, { "byteLength": 4 }]);
    model.json["bufferViews"][2]["buffer"] = json!(1);
    model.json["bufferViews"][2]["byteOffset"] = json!(0);
    model.json["bufferViews"][0]["buffer"] = json!(1);
    assert_refused(&model, Kind::Missing, &["buffer 1: has neither a URI nor a binary chunk"]);

    let mut model = Model::tree();
    model.texture(&common::png());
    model.json["images"] = json!([{ "uri": "leaf.png" }]);
    assert_refused(&model, Kind::Missing, &["image 0: \"leaf.png\": no such file"]);
    model.json["images"] = json!([{}]);
    assert_refused(&model, Kind::Malformed, &["image 0: has neither a URI nor a buffer view"]);
}

#[test]
fn pictures_that_cannot_be_decoded() {
    let png = common::png();
    for picture in [b"not a picture".as_slice(), &png[..png.len() / 2], b""] {
        let mut model = Model::tree();
        model.texture(picture);
        model.json["images"][0]["name"] = json!("oak leaf");
        let parts = ["image 0 \"oak leaf\": the picture cannot be decoded: "];
        assert_refused(&model, Kind::Malformed, &parts);
    }
    // A header that announces 60000 by 60000 pixels: refused before they are allocated.
    let mut huge = png;
    huge[16..24].copy_from_slice(&[0, 0, 0xea, 0x60, 0, 0, 0xea, 0x60]);
    let mut model = Model::tree();
    model.texture(&huge);
    assert_refused(&model, Kind::Malformed, &["image 0", "cannot be decoded"]);
}

#[test]
fn accessors_beyond_their_data() {
    let leaves = "mesh 1 \"leaves\", primitive 0, POSITION, accessor 2";
    for count in [9, u64::from(u32::MAX), 1 << 40, u64::MAX] {
        let mut model = Model::tree();
        model.json["accessors"][2]["count"] = json!(count);
        let cause =
            format!("{count} elements, 12 bytes apart from byte 0, do not fit the 96 bytes");
        assert_refused(&model, Kind::OutOfRange, &[leaves, &cause]);
        // Unindexed, the count is a count of triangles.
        model.leaves().as_object_mut().unwrap().remove("indices");
        assert_eq!(refused(&model.glb()).kind, Kind::OutOfRange);
    }
    for offset in [1, 96, u64::MAX - 3] {
        let mut model = Model::tree();
        model.json["accessors"][2]["byteOffset"] = json!(offset);
        assert_refused(&model, Kind::OutOfRange, &[leaves, "do not fit the 96 bytes"]);
    }
    for (key, value) in
        [("byteLength", u64::MAX), ("byteOffset", u64::MAX), ("byteLength", 1 << 20)]
    {
        let mut model = Model::tree();
        model.json["bufferViews"][2][key] = json!(value);
        assert_refused(
            &model,
            Kind::OutOfRange,
            &[leaves, "buffer view 2: ", "do not fit buffer 0"],
        );
    }
    let mut model = Model::tree();
    model.json["bufferViews"][2]["byteStride"] = json!(8);
    assert_refused(&model, Kind::OutOfRange, &[leaves, "a stride of 8 bytes for elements of 12"]);
    model.json["bufferViews"][2]["byteStride"] = json!(0);
    assert_refused(&model, Kind::OutOfRange, &[leaves, "byteStride is out of range"]);
    let mut model = Model::tree();
    model.json["accessors"][2].as_object_mut().unwrap().remove("bufferView");
    model.json["accessors"][2]["count"] = json!(1u64 << 32);
    assert_refused(
        &model,
        Kind::OutOfRange,
        &[leaves, "4294967296 elements without a buffer view"],
    );
}

#[test]
fn accessors_of_the_wrong_type() {
    let mut model = Model::tree();
    model.json["accessors"][2]["type"] = json!("VEC2");
    assert_refused(&model, Kind::Malformed, &["accessor 2: its type is \"VEC2\"; VEC3 is needed"]);
    let mut model = Model::tree();
    model.json["accessors"][2]["componentType"] = json!(5130);
    assert_refused(&model, Kind::Malformed, &["accessor 2: component type 5130 is unknown"]);
    let mut model = Model::tree();
    model.json["accessors"][3]["componentType"] = json!(5122);
    assert_refused(&model, Kind::Malformed, &["indices, accessor 3: component type 5122 is not"]);
    let mut model = Model::tree();
    let short = model.floats(&CARD);
    model.leaves()["attributes"]["TEXCOORD_0"] = json!(short);
    assert_refused(&model, Kind::Malformed, &["TEXCOORD_0: has 4 elements for 8 positions"]);
    let mut model = Model::tree();
    model.leaves()["attributes"] = json!({ "NORMAL": 2 });
    assert_refused(&model, Kind::Malformed, &["mesh 1 \"leaves\", primitive 0: has no POSITION"]);
    let mut model = Model::tree();
    model.leaves()["mode"] = json!(7);
    assert_refused(&model, Kind::Malformed, &["primitive 0: mode 7 is not known"]);
}

#[test]
fn indices_that_point_nowhere() {
    for bad in [8, 255, u32::MAX] {
        let mut model = Model::tree();
        let bytes: Vec<u8> = [0, 1, bad].iter().flat_map(|i: &u32| i.to_le_bytes()).collect();
        let indices = model.accessor(&bytes, U32, "SCALAR", 3);
        model.leaves()["indices"] = json!(indices);
        let cause = format!("index 2 is {bad}, but there are 8 vertices");
        let place = "mesh 1 \"leaves\", primitive 0, indices: ";
        assert_refused(&model, Kind::OutOfRange, &[place, &cause]);
    }
    let places = [
        ("/meshes/1/primitives/0/indices", "accessor 99"),
        ("/meshes/1/primitives/0/attributes/POSITION", "accessor 99"),
        ("/meshes/1/primitives/0/material", "material 99"),
        ("/accessors/2/bufferView", "buffer view 99"),
        ("/bufferViews/2/buffer", "buffer 99"),
        ("/nodes/2/mesh", "mesh 99"),
        ("/nodes/0/children/1", "node 99"),
        ("/scenes/0/nodes/0", "node 99"),
        ("/scene", "scene 99"),
        ("/textures/0/source", "image 99"),
        ("/materials/1/pbrMetallicRoughness/baseColorTexture/index", "texture 99"),
        ("/images/0/bufferView", "buffer view 99"),
    ];
    for (pointer, named) in places {
        let mut model = Model::tree();
        model.texture(&common::png());
        if pointer.ends_with("material") {
            model.leaves()["material"] = json!(1);
        }
        *model.json.pointer_mut(pointer).unwrap() = json!(99);
        assert_refused(&model, Kind::OutOfRange, &[&format!("names {named}, but there")]);
    }
}

#[test]
fn poison_positions() {
    for (value, text) in [(f32::NAN, "NaN"), (f32::INFINITY, "inf"), (f32::NEG_INFINITY, "-inf")] {
        for axis in 0..3 {
            let mut positions = LEAVES;
            positions[5][axis] = value;
            let mut model = Model::tree();
            let accessor = model.floats(&positions);
            model.leaves()["attributes"]["POSITION"] = json!(accessor);
            let place = "mesh 1 \"leaves\", primitive 0, POSITION: vertex 5 is at ";
            assert_refused(&model, Kind::NotFinite, &[place, text]);
        }
    }
    let mut coordinates = [CARD, CARD].concat();
    coordinates[3][1] = f32::NAN;
    let mut model = Model::tree();
    let accessor = model.floats(&coordinates);
    model.leaves()["attributes"]["TEXCOORD_0"] = json!(accessor);
    assert_refused(&model, Kind::NotFinite, &["TEXCOORD_0: vertex 3 has"]);
    // Finite, and yet too far: in the file, or through its node.
    let mut model = Model::tree();
    let mut positions = LEAVES;
    positions[1][2] = f32::MAX;
    let accessor = model.floats(&positions);
    model.leaves()["attributes"]["POSITION"] = json!(accessor);
    assert_refused(&model, Kind::OutOfRange, &["POSITION: vertex 1, moved by its node"]);
    let mut model = Model::tree();
    model.json["nodes"][0]["scale"] = json!([1e30, 1e30, 1e30]);
    assert_refused(&model, Kind::OutOfRange, &["moved by its node", "too far away"]);
}

#[test]
fn tiny_and_huge_trees_are_read() {
    // Denormal squares, and the largest that is allowed.
    for scale in [1e-15, 1e-9, 1e-3, 1e6] {
        let mut model = Model::tree();
        model.json["nodes"][0]["scale"] = json!([scale, scale, scale]);
        let tree = model.import().unwrap();
        assert_eq!(tree.foliage.leaves.len(), 2, "{scale}");
        assert!((tree.height() / (3.0 * scale as f32) - 1.0).abs() < 1e-5, "{scale}");
        for leaf in &tree.foliage.leaves {
            assert!(leaf.center.is_finite() && leaf.orientation.is_normalized(), "{scale}");
        }
    }
}

#[test]
fn no_triangles() {
    let mut model = Model::tree();
    model.json["scenes"][0]["nodes"] = json!([]);
    assert_refused(&model, Kind::Empty, &["there are no triangles in its scene"]);
    let mut model = Model::tree();
    for mesh in 0..2 {
        model.json["meshes"][mesh]["primitives"][0]["mode"] = json!(1);
    }
    assert_refused(&model, Kind::Empty, &["there are no triangles in its scene"]);
}

#[test]
fn no_leaves_lists_what_there_is() {
    let mut model = Model::tree();
    model.json["nodes"][2]["name"] = json!("crown");
    model.json["meshes"][1]["name"] = json!("Mesh.001");
    let error = refused(&model.glb());
    assert_eq!(error.kind, Kind::Empty);
    assert_eq!(
        error.to_string(),
        "tree.glb: no leaves: nothing is named like leaves, and no material is alpha-masked. \
         The primitives are:\n  \
         0: node \"trunk\", mesh \"trunk\", material \"bark\": 2 triangles\n  \
         1: node \"crown\", mesh \"Mesh.001\", material (unnamed): 4 triangles\n\
         Say which of them are leaves with --leaves NAME: the name of a node, mesh or material, or the \
         number of a primitive."
    );
    let named = |name: &str| ImportOptions { leaves: vec![name.into()], ..Default::default() };
    for name in ["crown", "CROWN", "mesh.001", "1"] {
        assert_eq!(model.import_with(&named(name)).unwrap().foliage.leaves.len(), 2);
    }
    let error = model.import_with(&named("krone")).unwrap_err();
    assert!(error.cause.contains("named \"krone\". The primitives are:"), "{error}");
    // All leaves in one line: no area.
    let mut model = Model::tree();
    let line = model.floats(&[[0.0, 1.0, 0.0]; 8]);
    model.leaves()["attributes"]["POSITION"] = json!(line);
    assert_refused(&model, Kind::Empty, &["no leaves: the leaves' triangles have no area"]);
}

#[test]
fn cycles_and_shared_nodes() {
    for (pointer, child) in [("/nodes/2/children", 0), ("/nodes/0/children", 0)] {
        let mut model = Model::tree();
        let (parent, _) = pointer.rsplit_once('/').unwrap();
        model.json.pointer_mut(parent).unwrap()["children"] = json!([1, 2, child]);
        assert_refused(&model, Kind::Malformed, &["is reached twice: nodes must form a tree"]);
    }
    let mut model = Model::tree();
    model.json["nodes"][0]["children"] = json!([1, 2, 2]);
    assert_refused(&model, Kind::Malformed, &["node 2 \"leaves\": is reached twice"]);
}

#[test]
fn a_deep_chain_of_nodes_needs_no_stack() {
    let depth = 100_000;
    let mut model = Model::tree();
    let nodes = model.json["nodes"].as_array_mut().unwrap();
    nodes[0]["children"] = json!([3]);
    for i in 3..depth {
        nodes.push(json!({ "children": [i + 1] }));
    }
    nodes.push(json!({ "children": [1, 2] }));
    assert_eq!(model.import().unwrap().foliage.leaves.len(), 2);
}

#[test]
fn one_mesh_named_by_very_many_nodes_is_bounded() {
    let mut model = Model::tree();
    model.json["accessors"][3]["count"] = json!(3_000_000);
    for _ in 0..20 {
        let index = model.json["nodes"].as_array().unwrap().len();
        model.json["nodes"].as_array_mut().unwrap().push(json!({ "mesh": 1 }));
        model.json["nodes"][0]["children"].as_array_mut().unwrap().push(json!(index));
    }
    assert_refused(&model, Kind::OutOfRange, &["more than 16777216: too many for one tree"]);
}

#[test]
fn absurd_heights() {
    for height in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let options = ImportOptions { height: Some(height), ..Default::default() };
        let error = Model::tree().import_with(&options).unwrap_err();
        assert_eq!((error.place.as_str(), error.kind), ("height", Kind::OutOfRange));
    }
}

#[test]
fn sparse_accessors_that_lie() {
    for (key, value, part) in [
        ("/sparse/count", json!(9), "sparse: replaces 9 of 8 elements"),
        ("/sparse/indices/bufferView", json!(99), "names buffer view 99"),
        ("/sparse/values/byteOffset", json!(7), "do not fit"),
    ] {
        let mut model = Model::tree();
        let indices = model.view(&[200, 0, 0, 0]);
        let values = model.view(&[0; 12]);
        model.json["accessors"][2]["sparse"] = json!({
            "count": 1,
            "indices": { "bufferView": indices, "componentType": 5121 },
            "values": { "bufferView": values },
        });
        assert_refused(&model, Kind::OutOfRange, &["sparse: replaces element 200 of 8"]);
        *model.json["accessors"][2].pointer_mut(key).unwrap_or(&mut json!(0)) = value.clone();
        if key.ends_with("byteOffset") {
            model.json["accessors"][2]["sparse"]["values"]["byteOffset"] = value;
            model.json["accessors"][2]["sparse"]["indices"]["byteOffset"] = json!(1);
        }
        assert_refused(&model, Kind::OutOfRange, &[part]);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

    /// Whatever bytes change and wherever the file ends: a tree or an error, and no panic.
    #[test]
    fn damage_never_panics(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..8),
        cut in prop::option::weighted(0.2, any::<prop::sample::Index>()),
    ) {
        let mut model = Model::tree();
        model.texture(&common::png());
        let mut bytes = model.glb();
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        let _ = import(&bytes, "tree.glb", &ImportOptions::default(), &mut |_| Err("none".into()));
    }
}
