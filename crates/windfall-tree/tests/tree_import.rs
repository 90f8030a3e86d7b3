//! What glTF allows is read, and means the same however it is written.

mod common;

use common::{CARD, I8, I16, LEAVES, Model, U8, U16, U32, centers};
use serde_json::json;
use std::f32::consts::FRAC_PI_2;
use windfall_core::foliage::Leaf;
use windfall_core::glam::{Vec2, Vec3};
use windfall_core::material::{Bark, BarkPattern, Surface};
use windfall_core::tree::Tree;
use windfall_tree::{
    ImportOptions, Inspection, Species, export_glb, export_glb_in_prune_order, import,
};

/// The two cards of [`LEAVES`] where they are, whole and facing +Z.
#[track_caller]
fn assert_usual(tree: &Tree) {
    assert_eq!(centers(tree).len(), 2, "leaves");
    for (center, expected) in centers(tree).iter().zip([[0.5, 2.5, 0.0], [2.5, 2.5, 0.0]]) {
        let gap = Vec3::from(*center).distance(expected.into());
        assert!(gap < 1e-3, "{center:?}");
    }
    assert_eq!(tree.foliage.triangle_count(), 4);
    assert_eq!(tree.foliage.shapes.len(), 1);
    for leaf in &tree.foliage.leaves {
        let up = leaf.orientation * Vec3::Y;
        assert!(up.distance(Vec3::Z) < 1e-3, "upper side {up}");
        assert!((leaf.scale - 1.0).abs() < 1e-3);
    }
    for triangle in tree.foliage.shapes[0].indices.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|i| tree.foliage.shapes[0].positions[triangle[i] as usize]);
        assert!((b - a).cross(c - a).y > 0.0, "every triangle faces the upper side");
    }
}

#[test]
fn the_usual_tree() {
    let tree = Model::tree().import().unwrap();
    assert_usual(&tree);
    assert_eq!((tree.wood.vertices.len(), tree.wood_triangles()), (4, 2));
    assert_eq!(tree.wood.materials[0].name, "bark");
    assert_eq!(tree.foliage.materials[0].name, "default");
    assert!(tree.wood.vertices.iter().all(|v| v.normal == Vec3::Z), "normals are made");
    assert_eq!(tree.height(), 3.0);
    let inspection = Inspection::of(&tree);
    assert_eq!((inspection.leaves, inspection.shapes, inspection.vertices), (2, 1, 12));
    assert_eq!(inspection.crown_center, [1.5, 2.5, 0.0]);
}

#[test]
fn the_leaf_frame() {
    // A card twice as long (y) as wide; the trunk is at its lower end, so that is the petiole.
    let mut model = Model::tree();
    let long =
        model.floats(&[[-0.5, 2.0, 0.0], [0.5, 2.0, 0.0], [0.5, 4.0, 0.0], [-0.5, 4.0, 0.0]]);
    let indices = model.shorts(&[0, 1, 2, 0, 2, 3]);
    *model.leaves() = json!({ "attributes": { "POSITION": long }, "indices": indices });
    let tree = model.import().unwrap();
    let (leaf, shape) = (&tree.foliage.leaves[0], &tree.foliage.shapes[0]);
    assert!((leaf.orientation * Vec3::Z).distance(Vec3::Y) < 1e-6);
    assert!((leaf.orientation * Vec3::Y).distance(Vec3::Z) < 1e-6);
    assert!(shape.normals.iter().all(|n| n.distance(Vec3::Y) < 1e-6));
    assert!((shape.area() - 2.0).abs() < 1e-6);
    assert!(shape.positions[0].distance(Vec3::new(0.5, 0.0, -1.0)) < 1e-6, "{:?}", shape.positions);
    assert!((leaf.center - Vec3::new(0.0, 3.0, 0.0)).length() < 1e-6);
}

#[test]
fn indices_of_every_kind_and_none() {
    let list = [0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7];
    let mut model = Model::tree();
    let bytes: Vec<u8> = list.iter().map(|&i: &u32| i as u8).collect();
    let accessor = model.accessor(&bytes, U8, "SCALAR", 12);
    model.leaves()["indices"] = json!(accessor);
    assert_usual(&model.import().unwrap());
    let bytes: Vec<u8> = list.iter().flat_map(|&i| i.to_le_bytes()).collect();
    let accessor = model.accessor(&bytes, U32, "SCALAR", 12);
    model.leaves()["indices"] = json!(accessor);
    assert_usual(&model.import().unwrap());

    let loose = list.map(|i| LEAVES[i as usize]);
    let accessor = model.floats(&loose);
    *model.leaves() = json!({ "attributes": { "POSITION": accessor } });
    assert_usual(&model.import().unwrap());
}

#[test]
fn strips_and_fans() {
    // The strip 0 1 3 2, two triangles without area, the strip 4 5 7 6.
    let mut model = Model::tree();
    let strip = model.shorts(&[0, 1, 3, 2, 2, 4, 4, 5, 7, 6]);
    model.leaves()["indices"] = json!(strip);
    model.leaves()["mode"] = json!(5);
    assert_usual(&model.import().unwrap());
    let mut model = Model::tree();
    let (one, two) = (model.shorts(&[0, 1, 2, 3]), model.shorts(&[4, 5, 6, 7]));
    let mut fan = model.leaves().clone();
    fan["mode"] = json!(6);
    fan["indices"] = json!(one);
    *model.leaves() = fan.clone();
    fan["indices"] = json!(two);
    model.json["meshes"][1]["primitives"].as_array_mut().unwrap().push(fan);
    assert_usual(&model.import().unwrap());
}

#[test]
fn points_and_lines_are_skipped() {
    let mut model = Model::tree();
    let mut lines = model.leaves().clone();
    lines["mode"] = json!(3);
    model.json["meshes"][1]["primitives"].as_array_mut().unwrap().push(lines);
    assert_usual(&model.import().unwrap());
}

#[test]
fn degenerate_triangles_are_dropped() {
    let mut model = Model::tree();
    let indices = model.shorts(&[0, 1, 2, 0, 2, 3, 1, 1, 2, 4, 5, 6, 4, 6, 7, 0, 0, 0]);
    model.leaves()["indices"] = json!(indices);
    assert_usual(&model.import().unwrap());
}

#[test]
fn sparse_accessors_replace_elements() {
    let mut model = Model::tree();
    let mut moved = LEAVES;
    moved[6] = [9.0, 9.0, 9.0];
    let base = model.floats(&moved);
    let bytes: Vec<u8> = LEAVES[6].iter().flat_map(|x| x.to_le_bytes()).collect();
    let (indices, values) = (model.view(&[6]), model.view(&bytes));
    model.json["accessors"][base]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": indices, "componentType": U8 },
        "values": { "bufferView": values },
    });
    model.leaves()["attributes"]["POSITION"] = json!(base);
    assert_usual(&model.import().unwrap());
}

#[test]
fn strides_and_offsets() {
    // Positions and texture coordinates interleaved, after four bytes of something else.
    let mut model = Model::tree();
    let mut bytes = vec![0xff; 4];
    for (position, uv) in LEAVES.iter().zip([CARD, CARD].concat()) {
        bytes.extend(position.iter().chain(&uv).flat_map(|x| x.to_le_bytes()));
    }
    let position = model.accessor(&bytes, 5126, "VEC3", 8);
    let view = model.json["accessors"][position]["bufferView"].clone();
    model.json["bufferViews"][view.as_u64().unwrap() as usize]["byteStride"] = json!(20);
    model.json["accessors"][position]["byteOffset"] = json!(4);
    let mut uv = model.json["accessors"][position].clone();
    uv["byteOffset"] = json!(16);
    uv["type"] = json!("VEC2");
    model.json["accessors"].as_array_mut().unwrap().push(uv);
    model.leaves()["attributes"] = json!({ "POSITION": position, "TEXCOORD_0": position + 1 });
    let tree = model.import().unwrap();
    assert_usual(&tree);
    let mut uvs = tree.foliage.shapes[0].uvs.clone();
    uvs.sort_by(|a, b| a.to_array().partial_cmp(&b.to_array()).unwrap());
    assert_eq!(uvs, [Vec2::ZERO, Vec2::Y, Vec2::X, Vec2::ONE]);
}

#[test]
fn quantized_attributes() {
    // Positions as integers (a node scales them back), by type: a step per unit, and its range.
    for (component, normalized, scale) in [
        (I8, false, 1.0),
        (U8, false, 1.0),
        (I16, false, 1.0),
        (U16, false, 1.0),
        (I8, true, 127.0),
        (U8, true, 255.0),
        (I16, true, 32767.0),
        (U16, true, 65535.0),
    ] {
        let mut model = Model::tree();
        let wide = component == I16 || component == U16;
        let bytes: Vec<u8> = LEAVES
            .iter()
            .flat_map(|p| [p[0], p[1], p[2], 0.0])
            .flat_map(|x| if wide { (x as u16).to_le_bytes().to_vec() } else { vec![x as u8] })
            .collect();
        let accessor = model.accessor(&bytes, component, "VEC3", 8);
        model.json["accessors"][accessor]["normalized"] = json!(normalized);
        let view = model.json["accessors"][accessor]["bufferView"].as_u64().unwrap() as usize;
        model.json["bufferViews"][view]["byteStride"] = json!(if wide { 8 } else { 4 });
        model.leaves()["attributes"]["POSITION"] = json!(accessor);
        model.json["nodes"][2]["scale"] = json!([scale, scale, scale]);
        model.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        assert_usual(&model.import().unwrap());
    }
    // The specification's edge: -128 is -1, as -127 is.
    let mut model = Model::tree();
    let normals = model.accessor(&[0, 0, 0x81, 0].repeat(4), I8, "VEC3", 4);
    let view = model.json["accessors"][normals]["bufferView"].as_u64().unwrap() as usize;
    model.json["bufferViews"][view]["byteStride"] = json!(4);
    model.json["accessors"][normals]["normalized"] = json!(true);
    model.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    assert!(model.import().unwrap().wood.vertices.iter().all(|v| v.normal == Vec3::NEG_Z));
}

#[test]
fn packed_buffer_views() {
    // What gltfpack -cc writes: packed attributes and indices over a fallback buffer without data.
    let mut model = Model::tree();
    let positions: Vec<[f32; 3]> = LEAVES.to_vec();
    let exponential = meshopt::encode_filter_exp(&positions, 15, meshopt::EncodeExpMode::Separate);
    let normals = meshopt::encode_filter_oct::<i8>(&[[0.0, 0.0, 1.0, 0.0]; 8], 8);
    let list = [0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7];
    let plain = meshopt::encode_vertex_buffer(&positions).unwrap();
    let filtered = meshopt::encode_vertex_buffer(&exponential).unwrap();
    let normals = meshopt::encode_vertex_buffer(&normals).unwrap();
    let triangles = meshopt::encode_index_buffer(&list, 8).unwrap();
    let sequence = meshopt::encode_index_sequence(&list, 8).unwrap();
    model.json["buffers"].as_array_mut().unwrap().push(json!({
        "byteLength": 1000, "extensions": { "EXT_meshopt_compression": { "fallback": true } },
    }));
    model.json["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
    let mut packed = |data: &[u8], mode: &str, filter: &str, stride: usize, count: usize, kind| {
        let view = model.view(data);
        let mut source = model.json["bufferViews"][view].clone();
        source["mode"] = json!(mode);
        source["filter"] = json!(filter);
        source["byteStride"] = json!(stride);
        source["count"] = json!(count);
        model.json["bufferViews"][view] = json!({
            "buffer": 1, "byteLength": stride * count,
            "extensions": { "EXT_meshopt_compression": source },
        });
        let (component, kind): (u32, &str) = kind;
        let accessors = model.json["accessors"].as_array_mut().unwrap();
        accessors.push(json!({
            "bufferView": view, "componentType": component, "type": kind, "count": count,
            "normalized": component == I8,
        }));
        accessors.len() - 1
    };
    let (vec3, index32, index16) = ((5126, "VEC3"), (U32, "SCALAR"), (U16, "SCALAR"));
    let positions = [
        packed(&plain, "ATTRIBUTES", "NONE", 12, 8, vec3),
        packed(&filtered, "ATTRIBUTES", "EXPONENTIAL", 12, 8, vec3),
    ];
    let normals = packed(&normals, "ATTRIBUTES", "OCTAHEDRAL", 4, 8, (I8, "VEC3"));
    let indices = [
        packed(&triangles, "TRIANGLES", "NONE", 4, 12, index32),
        packed(&triangles, "TRIANGLES", "NONE", 2, 12, index16),
        packed(&sequence, "INDICES", "NONE", 4, 12, index32),
        packed(&sequence, "INDICES", "NONE", 2, 12, index16),
    ];
    for position in positions {
        for index in indices {
            *model.leaves() = json!({
                "attributes": { "POSITION": position, "NORMAL": normals }, "indices": index,
            });
            assert_usual(&model.import().unwrap());
        }
    }
    // Damage is an error with the view's name, whatever it hits.
    let view = model.json["accessors"][positions[0]]["bufferView"].as_u64().unwrap() as usize;
    *model.leaves() = json!({ "attributes": { "POSITION": positions[0] }, "indices": indices[0] });
    for (key, value, part) in [
        ("count", json!(1u64 << 40), "elements cannot be in"),
        ("count", json!(3000), "the packed data is damaged"),
        ("byteStride", json!(13), "stride 13: a multiple of 4"),
        ("mode", json!("BAGS"), "meshopt mode \"BAGS\" is not known"),
        ("filter", json!("SEPIA"), "filter \"SEPIA\" with stride 12 is not known"),
        ("byteLength", json!(8), "the packed data is damaged"),
    ] {
        let mut bad = model.clone();
        bad.json["bufferViews"][view]["extensions"]["EXT_meshopt_compression"][key] = value;
        let error = bad.import().unwrap_err().to_string();
        assert!(error.contains(&format!("buffer view {view}: ")), "{error}");
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn node_transforms() {
    // The leaves node as a matrix, and as its parts: twice as large, turned about x, moved.
    let mut parts = Model::tree();
    let half = (FRAC_PI_2 / 2.0).sin();
    parts.json["nodes"][2]["translation"] = json!([0.0, 10.0, 0.0]);
    parts.json["nodes"][2]["rotation"] = json!([half, 0.0, 0.0, half]);
    parts.json["nodes"][2]["scale"] = json!([2.0, 2.0, 2.0]);
    let mut matrix = Model::tree();
    matrix.json["nodes"][2]["matrix"] = json!([2, 0, 0, 0, 0, 0, 2, 0, 0, -2, 0, 0, 0, 10, 0, 1]);
    for model in [parts, matrix] {
        let tree = model.import().unwrap();
        for (center, expected) in centers(&tree).iter().zip([[1.0, 10.0, 5.0], [5.0, 10.0, 5.0]]) {
            assert!(Vec3::from(*center).distance(expected.into()) < 1e-5, "{center:?}");
        }
        for leaf in &tree.foliage.leaves {
            assert!((leaf.orientation * Vec3::Y).distance(Vec3::NEG_Y) < 1e-5);
        }
    }
}

#[test]
fn a_mirrored_node_keeps_the_upper_side() {
    let mut model = Model::tree();
    let normals = model.floats(&[[0.0, 0.0, 1.0]; 4]);
    model.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    model.json["nodes"][0]["scale"] = json!([-1.0, 1.0, 1.0]);
    let tree = model.import().unwrap();
    assert_eq!(centers(&tree).iter().map(|c| c[0]).collect::<Vec<_>>(), [-2.5, -0.5]);
    for leaf in &tree.foliage.leaves {
        assert!((leaf.orientation * Vec3::Y).distance(Vec3::Z) < 1e-6);
    }
    let [a, b, c] = [0, 1, 2].map(|i| tree.wood.vertices[tree.wood.indices[i] as usize].position);
    assert!((b - a).cross(c - a).z > 0.0, "wound as it faces");
    assert!(tree.wood.vertices.iter().all(|v| v.normal == Vec3::Z), "lit as it faces");
}

#[test]
fn one_mesh_of_several_nodes_is_one_shape() {
    let mut model = Model::tree();
    for i in 0..10 {
        let nodes = model.json["nodes"].as_array_mut().unwrap();
        let angle = i as f32 * 0.3;
        nodes.push(json!({
            "name": format!("leaf {i}"), "mesh": 1,
            "translation": [0.0, 0.0, i + 1],
            "rotation": [0.0, angle.sin(), 0.0, angle.cos()],
            "scale": [1.0 + angle, 1.0 + angle, 1.0 + angle],
        }));
        let index = nodes.len() - 1;
        model.json["nodes"][0]["children"].as_array_mut().unwrap().push(json!(index));
    }
    let tree = model.import().unwrap();
    assert_eq!((tree.foliage.leaves.len(), tree.foliage.shapes.len()), (22, 1));
    let largest = tree.foliage.leaves.iter().map(|l| l.scale).fold(0.0, f32::max);
    let smallest = tree.foliage.leaves.iter().map(|l| l.scale).fold(9.0, f32::min);
    assert!((largest / smallest - 3.7).abs() < 1e-3, "{smallest} {largest}");
}

#[test]
fn leaves_of_other_proportions_or_pictures_get_shapes_of_their_own() {
    let mut model = Model::tree();
    let mut wide = LEAVES;
    wide[5][0] += 0.5;
    wide[6][0] += 0.5;
    let accessor = model.floats(&wide);
    model.leaves()["attributes"]["POSITION"] = json!(accessor);
    assert_eq!(model.import().unwrap().foliage.shapes.len(), 2);
    let mut model = Model::tree();
    let halved = model.floats(&[CARD, CARD.map(|[u, v]| [u / 2.0, v])].concat());
    model.leaves()["attributes"]["TEXCOORD_0"] = json!(halved);
    assert_eq!(model.import().unwrap().foliage.shapes.len(), 2);
}

#[test]
fn scenes_are_chosen() {
    // The default scene, else the first, else the nodes that are no one's children.
    let mut model = Model::tree();
    model.json["scenes"] = json!([{ "nodes": [1] }, { "nodes": [0] }]);
    model.json["scene"] = json!(1);
    assert_usual(&model.import().unwrap());
    model.json["scenes"] = json!([{ "nodes": [0] }, { "nodes": [1] }]);
    model.json.as_object_mut().unwrap().remove("scene");
    assert_usual(&model.import().unwrap());
    model.json.as_object_mut().unwrap().remove("scenes");
    assert_usual(&model.import().unwrap());
}

#[test]
fn json_with_buffers_inside_and_outside() {
    let model = Model::tree();
    let mut outside = model.json.clone();
    outside["buffers"][0]["uri"] = json!("oak%20tree.bin");
    let mut asked = Vec::new();
    let mut resolve = |path: &str| {
        asked.push(path.to_string());
        Ok(model.binary.clone())
    };
    let options = ImportOptions::default();
    let text = format!("\u{feff} {outside}");
    assert_usual(&import(text.as_bytes(), "tree.gltf", &options, &mut resolve).unwrap().tree);
    assert_eq!(asked, ["oak tree.bin"], "asked once, percent signs decoded");

    let digits = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let base64: String = model
        .binary
        .chunks(3)
        .flat_map(|c| {
            let word = c.iter().fold(0u32, |w, &b| w << 8 | u32::from(b)) << (8 * (3 - c.len()));
            (0..=c.len()).map(move |i| digits[(word >> (18 - 6 * i)) as usize & 63] as char)
        })
        .collect();
    let mut inside = model.json.clone();
    inside["buffers"][0]["uri"] = json!(format!("data:application/gltf-buffer;base64,{base64}"));
    let text = inside.to_string();
    let none = &mut |_: &str| Err("nothing is outside".to_string());
    assert_usual(&import(text.as_bytes(), "tree.gltf", &options, none).unwrap().tree);
}

#[test]
fn pictures_and_their_transforms() {
    let mut model = Model::tree();
    model.texture(&common::png());
    model.json["materials"][1]["pbrMetallicRoughness"] = json!({
        "baseColorFactor": [0.5, 0.25, 1.0, 0.8],
        "roughnessFactor": 0.75,
        "baseColorTexture": { "index": 0, "texCoord": 7, "extensions": {
            "KHR_texture_transform": {
                "offset": [0.25, 0.5], "rotation": FRAC_PI_2, "scale": [2.0, 3.0], "texCoord": 0,
            },
        } },
    });
    model.json["materials"][1]["alphaCutoff"] = json!(0.4);
    model.json["samplers"] = json!([{ "wrapS": 33071, "wrapT": 33071 }]);
    let tree = model.import().unwrap();
    let material = &tree.foliage.materials[0];
    assert_eq!(material.base_color, Vec3::new(0.5, 0.25, 1.0));
    assert_eq!((material.roughness, material.alpha_cutoff), (0.75, Some(0.5)));
    let Surface::Texture(image, repeat) = &material.surface else { panic!("a picture") };
    assert_eq!((image.width, image.height, image.rgba[4]), (2, 2, 255));
    assert!(repeat, "without a sampler, pictures repeat");
    // Scale, then a quarter turn counter-clockwise to the eye (v points down), then the offset:
    // (u, v) -> (3v, -2u) + (0.25, 0.5).
    let expected = CARD.map(|[u, v]| Vec2::new(3.0 * v + 0.25, -2.0 * u + 0.5));
    for (uv, expected) in tree.foliage.shapes[0].uvs.iter().zip(expected) {
        assert!(uv.distance(expected) < 1e-6, "{uv} {expected}");
    }
    model.json["textures"][0]["sampler"] = json!(0);
    let tree = model.import().unwrap();
    assert!(matches!(tree.foliage.materials[0].surface, Surface::Texture(_, false)));
}

#[test]
fn leaves_are_told_by_material_then_by_name() {
    // One mesh with two materials under a node named like leaves: the material tells.
    let mut model = Model::tree();
    let trunk = model.json["meshes"][0]["primitives"][0].clone();
    model.json["meshes"][1]["primitives"].as_array_mut().unwrap().push(trunk);
    model.texture(&common::png());
    let tree = model.import().unwrap();
    assert_eq!((tree.foliage.leaves.len(), tree.wood_triangles()), (2, 4));
    // Masked bark is bark.
    model.json["materials"][0]["alphaMode"] = json!("MASK");
    assert_eq!(model.import().unwrap().foliage.leaves.len(), 2);
    // The user's word is above all.
    let options = ImportOptions { leaves: vec!["bark".into()], ..Default::default() };
    let tree = model.import_with(&options).unwrap();
    assert_eq!((tree.foliage.leaves.len(), tree.wood_triangles()), (2, 4));
    assert!(tree.foliage.materials[0].name == "bark");
}

#[test]
fn the_foot_comes_to_the_origin() {
    let mut model = Model::tree();
    model.json["nodes"][0]["translation"] = json!([30.0, -7.0, 4.0]);
    let options = ImportOptions { height: Some(6.0), ..Default::default() };
    let tree = model.import_with(&options).unwrap();
    let (low, high) = tree.bounds();
    assert!(low.distance(Vec3::new(-0.2, 0.0, 0.0)) < 1e-4, "{low}");
    assert!(high.distance(Vec3::new(6.0, 6.0, 0.0)) < 1e-4, "{high}");
    assert!(tree.foliage.crown_center.distance(Vec3::new(3.0, 5.0, 0.0)) < 1e-4);
    // Nearly there is there: nothing moves.
    let mut model = Model::tree();
    model.json["nodes"][0]["translation"] = json!([0.0, 0.03, 0.0]);
    assert_eq!(model.import().unwrap().bounds().0.y, 0.03);
}

#[test]
fn export_keeps_what_matters() {
    let mut model = Model::tree();
    model.texture(&common::png());
    let mut tree = model.import().unwrap();
    let (ridge, groove) = (Vec3::new(0.4, 0.2, 0.0), Vec3::new(0.0, 0.2, 0.2));
    tree.wood.materials[0].surface =
        Surface::Bark(Bark { ridge, groove, scale: 0.1, pattern: BarkPattern::Furrowed });
    tree.wood.materials[0].name = "leafy bark".into();
    let glb = export_glb(&tree).unwrap();
    gltf::Gltf::from_slice(&glb).expect("another reader finds it valid");
    let back = import(&glb, "back.glb", &ImportOptions::default(), &mut |_| Err("none".into()))
        .unwrap()
        .tree;
    assert_usual(&back);
    assert_eq!(back.wood.vertices, tree.wood.vertices);
    assert_eq!(back.wood.indices, tree.wood.indices);
    assert!(back.wood.materials[0].base_color.distance(Vec3::new(0.2, 0.2, 0.1)) < 1e-6);
    let [was, is] = [&tree, &back].map(|t| &t.foliage.materials[0]);
    assert_eq!(was.alpha_cutoff, is.alpha_cutoff);
    let (Surface::Texture(was, _), Surface::Texture(is, true)) = (&was.surface, &is.surface) else {
        panic!("a picture that repeats")
    };
    assert!(was == is, "the same pixels");
}

/// Also where a petiole only touches its blade.
#[test]
fn every_species_comes_back_with_its_leaves() {
    for species in Species::ALL {
        let tree = species.grow_with(2, 60);
        for glb in [export_glb(&tree).unwrap(), export_glb_in_prune_order(&tree).unwrap()] {
            let options = ImportOptions::default();
            let back =
                import(&glb, "back.glb", &options, &mut |_| Err("none".into())).unwrap().tree;
            let areas = |tree: &Tree| {
                let area =
                    |l: &Leaf| l.scale * l.scale * tree.foliage.shapes[l.shape as usize].area();
                let mut areas: Vec<f32> = tree.foliage.leaves.iter().map(area).collect();
                areas.sort_by(f32::total_cmp);
                areas
            };
            let (was, is) = (areas(&tree), areas(&back));
            assert_eq!(was.len(), is.len(), "leaves of {species}");
            for (a, b) in was.iter().zip(&is) {
                assert!((a - b).abs() < 1e-3 * a, "{species}: a leaf of {a} m2 comes back as {b}");
            }
        }
    }
}

/// An attribute of another program that has the same name.
#[test]
fn leaves_are_not_told_by_a_number() {
    let mut model = Model::tree();
    let uvs = &mut model.json["meshes"][1]["primitives"][0]["attributes"];
    uvs["_LEAF"] = uvs["TEXCOORD_0"].clone();
    assert_usual(&model.import().unwrap());
}
