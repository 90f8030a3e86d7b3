//! Files as users bring them: each kind is read whole, or a note or an error names what was not.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::{CARD, I16, LEAVES, Model, centers, png};
use serde_json::{Value, json};
use windfall_core::NoteCode;
use windfall_core::glam::{Quat, Vec3};
use windfall_core::material::Surface;
use windfall_tree::{Import, ImportOptions, Up, Use};

fn codes(read: &Import) -> Vec<&'static str> {
    read.notes.iter().map(|note| note.code.code()).collect()
}

fn has(read: &Import, code: NoteCode) -> bool {
    read.notes.iter().any(|note| note.code == code)
}

#[track_caller]
fn assert_noted(read: &Import, code: NoteCode, part: &str) {
    let note = read.notes.iter().find(|note| note.code == code);
    let note = note.unwrap_or_else(|| panic!("no note {code} among {:?}", codes(read)));
    assert!(note.message.contains(part), "{note}");
}

fn named(leaves: &[&str], wood: &[&str]) -> ImportOptions {
    let list = |names: &[&str]| names.iter().map(ToString::to_string).collect();
    ImportOptions { leaves: list(leaves), wood: list(wood), ..Default::default() }
}

fn png_of(width: u32, height: u32, texel: impl Fn(u32, u32) -> [u8; 4]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbaImage::from_fn(width, height, |x, y| image::Rgba(texel(x, y)))
        .write_to(&mut bytes, image::ImageFormat::Png)
        .unwrap();
    bytes.into_inner()
}

/// A square tube: the trunk of a tree, from the ground up.
fn tube(half: f32, height: f32) -> (Vec<[f32; 3]>, Vec<u16>) {
    let ring = |y: f32| [[-half, y, -half], [half, y, -half], [half, y, half], [-half, y, half]];
    let positions = [ring(0.0), ring(height)].concat();
    let side = |a: u16| [a, a + 4, (a + 1) % 4, (a + 1) % 4, a + 4, (a + 1) % 4 + 4];
    (positions, (0..4).flat_map(side).collect())
}

/// A tree like those that users bring: a trunk of 3 m, and cards of 0.2 m in rings around it, as primitives
/// of one mesh: 0 is the trunk, 1 the leaves. Accessors of the leaves: 2 positions, 3 indices, 4 texture coordinates.
fn grown(cards: usize) -> Model {
    let mut model = Model::tree();
    model.json["accessors"] = json!([]);
    model.json["bufferViews"] = json!([]);
    model.binary.clear();
    let (trunk, trunk_indices) = tube(0.1, 3.0);
    model.floats(&trunk);
    model.shorts(&trunk_indices);
    let mut positions = Vec::new();
    let mut indices = Vec::new();
    for i in 0..cards {
        let turn = Quat::from_rotation_y(i as f32 * 2.4) * Quat::from_rotation_z(0.3 * i as f32);
        let middle = Quat::from_rotation_y(i as f32 * 2.4)
            * Vec3::new(0.8, 2.0 + 1.5 * (i as f32 / cards as f32), 0.0);
        let corners = [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]];
        positions.extend(corners.map(|[x, z]| (middle + turn * Vec3::new(x, 0.0, z)).to_array()));
        indices.extend([0, 1, 2, 0, 2, 3].map(|corner| 4 * i as u16 + corner));
    }
    model.floats(&positions);
    model.shorts(&indices);
    model.floats(&CARD.repeat(cards));
    model
}

#[test]
fn the_plain_tree_has_nothing_to_be_noted() {
    let read = grown(40).read().unwrap();
    assert_eq!((read.tree.foliage.leaves.len(), read.tree.foliage.shapes.len()), (40, 1));
    assert_eq!(codes(&read), [""; 0]);
    let parts: Vec<_> = read.parts.iter().map(|p| (p.number, p.taken_for, p.triangles)).collect();
    assert_eq!(parts, [(0, Use::Wood, 8), (1, Use::Leaves, 80)]);
    assert!(read.parts[0].bounds[1].distance(Vec3::new(0.1, 3.0, 0.1)) < 1e-6);
}

#[test]
fn gpu_instances_are_leaves() {
    let mut model = grown(1);
    let moves: Vec<[f32; 3]> = (0..30).map(|i| [0.0, 0.02 * i as f32, 0.1 * i as f32]).collect();
    let moves = model.floats(&moves);
    let sizes = model.floats(&[[1.5f32; 3]; 30]);
    let half: Vec<u8> =
        [[0i16, 23170, 0, 23170]; 30].iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    let turns = model.accessor(&half, I16, "VEC4", 30);
    model.json["accessors"][turns]["normalized"] = json!(true);
    model.json["nodes"][2]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] =
        json!({ "TRANSLATION": moves, "ROTATION": turns, "SCALE": sizes });
    model.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    let read = model.read().unwrap();
    assert_eq!((read.tree.foliage.leaves.len(), read.tree.foliage.shapes.len()), (30, 1));
    assert_eq!((read.parts[1].instances, read.parts[1].triangles), (30, 60));
    // The card's middle (0.8, 2, 0), half as large again and turned by a quarter about Y.
    let first =
        read.tree.foliage.leaves.iter().map(|l| l.center).min_by(|a, b| a.z.total_cmp(&b.z));
    assert!(first.unwrap().distance(Vec3::new(0.0, 3.0, -1.2)) < 1e-3, "{first:?}");
    // As many of each.
    model.json["accessors"][turns]["count"] = json!(7);
    let error = model.read().unwrap_err().to_string();
    assert!(error.contains("EXT_mesh_gpu_instancing: its attributes have [30, 7, 30]"), "{error}");
}

#[test]
fn a_single_leaf_is_noted() {
    assert_noted(&grown(1).read().unwrap(), NoteCode::OneLeaf, "instances were not realised");
}

#[test]
fn joints_place_a_skinned_tree() {
    let plain = grown(12).read().unwrap();
    // In centimetres, Z up; the node of the mesh would put it elsewhere, but its joints count.
    let mut model = grown(12);
    for (mesh, (positions, count)) in [(0, 8), (2, 48)].into_iter().enumerate() {
        let view = model.json["accessors"][positions]["bufferView"].as_u64().unwrap();
        let at = model.json["bufferViews"][view as usize]["byteOffset"].as_u64().unwrap() as usize;
        for vertex in 0..count {
            let at = at + 12 * vertex;
            let p: Vec<f32> = (0..3)
                .map(|i| {
                    f32::from_le_bytes(model.binary[at + 4 * i..at + 4 * i + 4].try_into().unwrap())
                })
                .collect();
            for (i, value) in [p[0], -p[2], p[1]].into_iter().enumerate() {
                model.binary[at + 4 * i..at + 4 * i + 4]
                    .copy_from_slice(&(100.0 * value).to_le_bytes());
            }
        }
        let joints = model.accessor(&vec![0u8; 4 * count], common::U8, "VEC4", count);
        let weights = model.floats(&vec![[0.5f32, 0.0, 0.0, 0.0]; count]);
        let attributes = &mut model.json["meshes"][mesh]["primitives"][0]["attributes"];
        attributes["JOINTS_0"] = json!(joints);
        attributes["WEIGHTS_0"] = json!(weights);
        model.json["nodes"][mesh + 1]["skin"] = json!(0);
        model.json["nodes"][mesh + 1]["translation"] = json!([700.0, 0.0, 0.0]);
    }
    let half = 0.5f64.sqrt();
    let nodes = model.json["nodes"].as_array_mut().unwrap();
    nodes.push(json!({ "name": "armature", "children": [4], "rotation": [-half, 0, 0, half], "scale": [0.01, 0.01, 0.01] }));
    nodes.push(json!({ "name": "bone", "translation": [0, 0, 50] }));
    model.json["scenes"][0]["nodes"] = json!([0, 3]);
    let mut inverse = [0.0f32; 16];
    (inverse[0], inverse[5], inverse[10], inverse[14], inverse[15]) = (1.0, 1.0, 1.0, -50.0, 1.0);
    let bytes: Vec<u8> = inverse.iter().flat_map(|v| v.to_le_bytes()).collect();
    let inverse = model.accessor(&bytes, common::F32, "MAT4", 1);
    model.json["skins"] = json!([{ "joints": [4], "inverseBindMatrices": inverse }]);
    let read = model.read().unwrap();
    for (a, b) in centers(&read.tree).iter().zip(centers(&plain.tree)) {
        assert!(Vec3::from(*a).distance(b.into()) < 1e-4, "{a:?} {b:?}");
    }
    assert!(!has(&read, NoteCode::AttributeLeftOut), "{:?}", codes(&read));
    model.json["skins"][0]["joints"] = json!([9]);
    assert!(model.read().unwrap_err().to_string().contains("names node 9"));
}

#[test]
fn morph_targets_move_by_their_weights() {
    let mut model = Model::tree();
    let up = model.floats(&[[0.0f32, 1.0, 0.0]; 8]);
    model.leaves()["targets"] = json!([{ "POSITION": up }, { "POSITION": up }]);
    model.json["meshes"][1]["weights"] = json!([0.25, 0.0]);
    assert_eq!(centers(&model.import().unwrap())[0], [0.5, 2.75, 0.0]);
    model.json["nodes"][2]["weights"] = json!([0.0, 2.0]);
    assert_eq!(centers(&model.import().unwrap())[0], [0.5, 4.5, 0.0]);
}

#[test]
fn the_finest_level_of_detail_is_read() {
    let mut model = grown(20);
    model.json["nodes"] = json!([
        { "name": "Tree_LOD1", "children": [1] }, { "name": "coarse", "mesh": 1 },
        { "name": "Tree_LOD0", "children": [3, 4] },
        { "name": "trunk", "mesh": 0 }, { "name": "leaves", "mesh": 1 },
    ]);
    model.json["scenes"][0]["nodes"] = json!([0, 2]);
    let read = model.read().unwrap();
    assert_eq!(read.tree.foliage.leaves.len(), 20);
    assert_noted(&read, NoteCode::LevelsLeftOut, "node 0 \"Tree_LOD1\"");
    // Asked for by name.
    let options = ImportOptions { node: vec!["tree_lod1".into()], ..named(&["coarse"], &[]) };
    let read = model.read_with(&options).unwrap();
    assert_eq!((read.tree.foliage.leaves.len(), read.parts.len()), (20, 1));
    // By the extension, under names that say nothing.
    model.json["nodes"][0]["name"] = json!("far");
    model.json["nodes"][2]["name"] = json!("near");
    assert_eq!(model.read().unwrap().tree.foliage.leaves.len(), 40);
    model.json["nodes"][2]["extensions"]["MSFT_lod"]["ids"] = json!([0]);
    let read = model.read().unwrap();
    assert_eq!(read.tree.foliage.leaves.len(), 20);
    assert_noted(&read, NoteCode::LevelsLeftOut, "node 0 \"far\"");
}

#[test]
fn vertices_have_colours_unless_they_are_something_else() {
    let mut model = Model::tree();
    let (green, red) = ([0.0f32, 0.5, 0.0], [1.0f32, 0.0, 0.0]);
    let colors = model.floats(&[green, green, green, green, red, red, red, red]);
    model.leaves()["attributes"]["COLOR_0"] = json!(colors);
    // Of the trunk's two triangles one is brown.
    let brown = model.floats(&[[0.2f32, 0.1, 0.0, 1.0]; 4]);
    model.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(brown);
    let read = model.read().unwrap();
    assert_noted(&read, NoteCode::VertexColors, "--vertex-colors off");
    let foliage = &read.tree.foliage;
    assert_eq!((foliage.materials.len(), foliage.shapes.len()), (2, 1));
    for leaf in &foliage.leaves {
        let color = foliage.materials[leaf.material as usize].base_color;
        let expected = if leaf.center.x < 1.5 { green } else { red };
        assert!(color.distance(expected.into()) < 5e-3, "{color}");
    }
    assert!(read.tree.wood.materials[0].base_color.distance(Vec3::new(0.2, 0.1, 0.0)) < 5e-3);
    let options = ImportOptions { vertex_colors: false, ..Default::default() };
    let read = model.read_with(&options).unwrap();
    assert_eq!(read.tree.foliage.materials.len(), 1);
    assert_noted(&read, NoteCode::AttributeLeftOut, "COLOR_0");
}

#[test]
fn specular_and_glossiness_have_a_diffuse_picture() {
    let mut model = Model::tree();
    model.texture(&png());
    let info = model.json["materials"][1]["pbrMetallicRoughness"]["baseColorTexture"].clone();
    model.json["materials"][1]["pbrMetallicRoughness"] = Value::Null;
    model.json["materials"][1].as_object_mut().unwrap().remove("pbrMetallicRoughness");
    model.json["materials"][1]["extensions"]["KHR_materials_pbrSpecularGlossiness"] = json!({ "diffuseTexture": info, "diffuseFactor": [0.5, 0.5, 0.5, 1.0], "glossinessFactor": 0.25 });
    model.json["extensionsUsed"] = json!(["KHR_materials_pbrSpecularGlossiness"]);
    let read = model.read().unwrap();
    let material = &read.tree.foliage.materials[0];
    assert!(matches!(material.surface, Surface::Texture(..)));
    assert_eq!((material.base_color, material.roughness), (Vec3::splat(0.5), 0.75));
    assert!(!has(&read, NoteCode::ExtensionLeftOut));
}

#[test]
fn a_soft_blend_becomes_a_mask_that_leaves_something() {
    let mut model = Model::tree();
    model.texture(&png_of(8, 8, |x, _| [60, 120, 40, if x < 4 { 110 } else { 0 }]));
    model.json["materials"][1]["alphaMode"] = json!("BLEND");
    let read = model.read().unwrap();
    assert_noted(&read, NoteCode::BlendAsMask, "below 0.22");
    assert_eq!(read.tree.foliage.materials[0].holes().solid, 0.5);
    // A mask is the author's word, even where nothing is left of the leaves.
    model.json["materials"][1]["alphaMode"] = json!("MASK");
    let read = model.read().unwrap();
    assert_noted(&read, NoteCode::MaskLeavesNothing, "nothing of it is drawn");
}

#[test]
fn trunk_and_leaves_in_one_atlas_are_parted() {
    let mut model = grown(40);
    let (trunk, trunk_indices) = tube(0.1, 3.0);
    let cards = model.json["accessors"][2].clone();
    let view = cards["bufferView"].as_u64().unwrap() as usize;
    let at = model.json["bufferViews"][view]["byteOffset"].as_u64().unwrap() as usize;
    let mut positions: Vec<[f32; 3]> = model.binary[at..at + 40 * 48]
        .chunks_exact(12)
        .map(|p| [0, 4, 8].map(|i| f32::from_le_bytes(p[i..i + 4].try_into().unwrap())))
        .collect();
    let mut indices: Vec<u16> =
        (0..40u16).flat_map(|i| [0, 1, 2, 0, 2, 3].map(|corner| 4 * i + corner)).collect();
    indices.extend(trunk_indices.iter().map(|i| i + 160));
    positions.extend(trunk);
    let positions = model.floats(&positions);
    let indices = model.shorts(&indices);
    let uvs = model.floats(&[CARD.repeat(40), vec![[0.1, 0.1]; 8]].concat());
    model.texture(&png_of(8, 8, |x, y| [90, 90, 30, if (x + y) % 8 < 6 { 255 } else { 0 }]));
    *model.leaves() = json!({
        "attributes": { "POSITION": positions, "TEXCOORD_0": uvs }, "indices": indices, "material": 1,
    });
    model.json["nodes"][0]["children"] = json!([2]);
    let read = model.read().unwrap();
    assert_eq!((read.tree.foliage.leaves.len(), read.tree.wood_triangles()), (40, 8));
    assert_noted(&read, NoteCode::WoodByPiece, "1 pieces");
    assert!(read.parts[0].why.contains("1 of its 41 pieces are wood"), "{}", read.parts[0].why);
    // Without a trunk there is no wood to find.
    let mut model = grown(40);
    model.json["nodes"][0]["children"] = json!([2]);
    let read = model.read().unwrap();
    assert_eq!(read.tree.foliage.leaves.len(), 40);
    assert_noted(&read, NoteCode::NoWood, "everything falls");
}

#[test]
fn axes_and_units_can_be_given() {
    let plain = grown(12).read().unwrap();
    let mut model = grown(12);
    let half = 0.5f64.sqrt();
    model.json["nodes"][0]["rotation"] = json!([half, 0, 0, half]);
    model.json["nodes"][0]["scale"] = json!([100, 100, 100]);
    let read = model.read().unwrap();
    assert_noted(&read, NoteCode::WiderThanTall, "--up z");
    assert_noted(&read, NoteCode::HeightUnusual, "--unit");
    let options = ImportOptions { up: Up::Z, unit: Some(0.01), ..Default::default() };
    let read = model.read_with(&options).unwrap();
    assert_eq!(codes(&read), [""; 0]);
    for (a, b) in centers(&read.tree).iter().zip(centers(&plain.tree)) {
        assert!(Vec3::from(*a).distance(b.into()) < 1e-4, "{a:?} {b:?}");
    }
    let options = ImportOptions { unit: Some(0.0), ..Default::default() };
    assert!(model.read_with(&options).unwrap_err().to_string().contains("a unit is above 0"));
}

#[test]
fn the_lowest_point_can_stand_on_the_ground() {
    let mut model = Model::tree();
    model.json["nodes"][2]["translation"] = json!([0.0, -2.5, 0.0]);
    assert!((model.import().unwrap().bounds().0.y + 0.5).abs() < 1e-5);
    let options = ImportOptions { ground: true, ..Default::default() };
    assert_eq!(model.import_with(&options).unwrap().bounds().0.y, 0.0);
}

#[test]
fn one_tree_of_a_pack_can_be_read() {
    let mut model = grown(20);
    let wide = model.floats(&[[-9.0f32, 0.0, -9.0], [9.0, 0.0, -9.0], [9.0, 0.0, 9.0]]);
    let meshes = model.json["meshes"].as_array_mut().unwrap();
    meshes.push(json!({ "primitives": [{ "attributes": { "POSITION": wide } }] }));
    model.json["nodes"] = json!([
        { "name": "Tree_1", "children": [2, 3] },
        { "name": "Tree_2", "children": [4, 5], "translation": [6, 0, 0] },
        { "mesh": 0 }, { "mesh": 1 }, { "mesh": 0 }, { "mesh": 1 }, { "name": "Plane", "mesh": 2 },
    ]);
    model.json["scenes"][0]["nodes"] = json!([0, 1, 6]);
    let read = model.read().unwrap();
    assert_eq!(read.tree.foliage.leaves.len(), 40);
    assert_noted(&read, NoteCode::SeveralTrees, "node 0 \"Tree_1\", node 1 \"Tree_2\"");
    assert_noted(&read, NoteCode::GroundPlane, "\"Plane\"");
    assert_noted(&read, NoteCode::WiderThanTall, "more than one tree");
    for node in ["tree_2", "1"] {
        let options = ImportOptions { node: vec![node.into()], ..Default::default() };
        let read = model.read_with(&options).unwrap();
        assert_eq!((read.tree.foliage.leaves.len(), codes(&read).len()), (20, 0));
        assert!(read.tree.bounds().0.x > -1.5, "its own foot is at the origin");
    }
    let options = ImportOptions { node: vec!["Tree_9".into()], ..Default::default() };
    let error = model.read_with(&options).unwrap_err().to_string();
    assert!(error.contains("\"Tree_9\"") && error.contains("node 1 \"Tree_2\""), "{error}");
}

#[test]
fn a_place_far_from_the_origin_costs_no_precision() {
    let plain = grown(20).read().unwrap();
    for place in [[0.0, 5e5, 0.0], [3_912_345.678, 212.5, 5_412_000.125]] {
        let mut model = grown(20);
        model.json["nodes"][0]["translation"] = json!(place);
        let read = model.read().unwrap();
        assert_eq!((read.tree.foliage.shapes.len(), codes(&read).len()), (1, 0));
        assert_eq!(read.tree.wood_triangles(), 8);
        for (a, b) in centers(&read.tree).iter().zip(centers(&plain.tree)) {
            assert!(Vec3::from(*a).distance(b.into()) < 1e-5, "{a:?} {b:?}");
        }
    }
    // A large tree at the origin stays as it was authored.
    let mut model = grown(20);
    model.json["nodes"][0]["scale"] = json!([5000, 5000, 5000]);
    model.json["nodes"][0]["translation"] = json!([0, 60, 0]);
    assert_eq!(model.import().unwrap().bounds().0.y, 60.0);
}

#[test]
fn a_node_may_be_one_leaf_of_several_pieces() {
    let mut model = grown(2);
    // A blade, and a stalk that touches it nowhere.
    let blade = [[-0.1f32, 0.1, 0.0], [0.1, 0.1, 0.0], [0.0, 0.4, 0.0]];
    let stalk = [[0.0f32, 0.0, 0.0], [0.01, 0.0, 0.0], [0.0, 0.09, 0.0]];
    let leaf = model.floats(&[blade, stalk].concat());
    *model.leaves() = json!({ "attributes": { "POSITION": leaf } });
    let mut nodes = vec![json!({ "name": "trunk", "mesh": 0 })];
    for i in 0..30 {
        let place = [0.3 * (i % 5) as f32 - 0.6, 1.0 + 0.06 * i as f32, 0.2 * (i % 7) as f32];
        nodes.push(json!({ "name": format!("leaf.{i:03}"), "mesh": 1, "translation": place }));
    }
    model.json["scenes"][0]["nodes"] = (0..nodes.len()).collect();
    model.json["nodes"] = json!(nodes);
    let read = model.read().unwrap();
    assert_eq!((read.tree.foliage.leaves.len(), read.tree.foliage.shapes.len()), (30, 1));
    assert_noted(&read, NoteCode::NodesAsLeaves, "30 nodes");
    // A few nodes are branches with their leaves.
    model.json["scenes"][0]["nodes"] = (0..6).collect();
    assert_eq!(model.read().unwrap().tree.foliage.leaves.len(), 10);
}

#[test]
fn leaves_and_wood_are_chosen_by_name_or_number() {
    let mut model = grown(20);
    for list in ["nodes", "meshes", "materials"] {
        for entry in model.json[list].as_array_mut().unwrap() {
            entry.as_object_mut().unwrap().remove("name");
        }
    }
    let error = model.read().unwrap_err().to_string();
    assert!(error.contains("  1: node (unnamed), mesh (unnamed)"), "{error}");
    assert!(error.contains("or the number of a primitive"), "{error}");
    for options in [named(&["1"], &[]), named(&[], &["0"]), named(&["1"], &["0"])] {
        let read = model.read_with(&options).unwrap();
        assert_eq!((read.tree.foliage.leaves.len(), read.tree.wood_triangles()), (20, 8));
    }
    // A name in decomposed letters is found as it is typed, and printed as it reads.
    model.json["nodes"][2]["name"] = json!("Bla\u{308}tter");
    let error = model.read().unwrap_err().to_string();
    assert!(error.contains("node \"Blätter\""), "{error}");
    let read = model.read_with(&named(&["BLÄTTER"], &[])).unwrap();
    assert_eq!(read.tree.foliage.leaves.len(), 20);
    assert_eq!(read.parts[1].node_name.as_deref(), Some("Blätter"));
    // What is in neither list is left out.
    model.json["nodes"][0]["children"] = json!([1, 2, 3]);
    model.json["nodes"].as_array_mut().unwrap().push(json!({ "name": "fence", "mesh": 0 }));
    let read = model.read_with(&named(&["1"], &["0"])).unwrap();
    assert_eq!((read.tree.wood_triangles(), read.parts[2].taken_for), (8, Use::LeftOut));
    assert_noted(&read, NoteCode::PrimitiveLeftOut, "primitive 2");
}

#[test]
fn colour_in_the_holes_is_that_of_the_leaf() {
    let leaf = |under: [u8; 3]| {
        let mut model = Model::tree();
        model.texture(&png_of(16, 16, |x, y| {
            let inside = (4..12).contains(&x) && (4..12).contains(&y);
            if inside { [70, 130, 40, 255] } else { [under[0], under[1], under[2], 0] }
        }));
        model.read().unwrap().tree.foliage.materials[0].surface.clone()
    };
    let (Surface::Texture(white, _), Surface::Texture(same, _)) =
        (leaf([255; 3]), leaf([70, 130, 40]))
    else {
        panic!("pictures")
    };
    assert!(white == same);
}

#[test]
fn what_is_packed_is_read_or_the_way_out_is_told() {
    let mut model = Model::tree();
    let packed = meshopt::encode_vertex_buffer(&LEAVES).unwrap();
    let view = model.view(&packed);
    let mut source = model.json["bufferViews"][view].clone();
    (source["mode"], source["byteStride"], source["count"]) =
        (json!("ATTRIBUTES"), json!(12), json!(8));
    model.json["bufferViews"][view] = json!({
        "buffer": 1, "byteLength": 96, "extensions": { "KHR_meshopt_compression": source },
    });
    model.json["buffers"].as_array_mut().unwrap().push(json!({ "byteLength": 96 }));
    model.json["accessors"][2]["bufferView"] = json!(view);
    model.json["extensionsRequired"] = json!(["KHR_meshopt_compression"]);
    assert_eq!(model.read().unwrap().tree.foliage.leaves.len(), 2);

    for (extension, way) in
        [("KHR_draco_mesh_compression", "copy in.glb"), ("KHR_texture_basisu", "ktxdecompress")]
    {
        let mut model = Model::tree();
        model.json["extensionsRequired"] = json!([extension]);
        let error = model.read().unwrap_err().to_string();
        assert!(error.contains(extension) && error.contains(way), "{error}");
    }
    // Used, not required, and without a picture that can be read.
    let mut model = Model::tree();
    model.texture(&png());
    model.json["textures"] = json!([{ "extensions": { "KHR_texture_basisu": { "source": 0 } } }]);
    assert!(model.read().unwrap_err().to_string().contains("ktxdecompress"));
    // Packed, though the list of extensions does not say so.
    let mut model = Model::tree();
    model.json["accessors"][2].as_object_mut().unwrap().remove("bufferView");
    model.leaves()["extensions"]["KHR_draco_mesh_compression"] = json!({ "bufferView": 2 });
    let error = model.read().unwrap_err().to_string();
    assert!(error.contains("packed with KHR_draco_mesh_compression"), "{error}");
}

/// A folded leaf: six corners and a midrib, not the same from any two sides.
const BLADE: [[f32; 3]; 6] = [
    [0.0, 0.0, -0.5],
    [0.25, 0.05, -0.1],
    [0.2, 0.06, 0.25],
    [0.0, 0.0, 0.5],
    [-0.28, 0.05, 0.05],
    [0.0, 0.0, 0.1],
];
const BLADE_TRIANGLES: [[u16; 3]; 5] = [[0, 1, 5], [1, 2, 5], [2, 3, 5], [5, 3, 4], [0, 5, 4]];

/// Leaves as `gltfpack` leaves them: in steps, each with its vertices and triangles in an order of its own.
fn quantized(count: usize, step: f32) -> Model {
    let mut model = grown(1);
    let mut numbers: Vec<u8> = Vec::new();
    let mut indices: Vec<u16> = Vec::new();
    for i in 0..count {
        let turn = Quat::from_rotation_y(i as f32 * 2.4)
            * Quat::from_rotation_x(i as f32 * 0.7)
            * Quat::from_rotation_z(i as f32);
        let middle = Vec3::new(
            0.7 * (i as f32).sin(),
            1.0 + 2.0 * i as f32 / count as f32,
            0.7 * (i as f32).cos(),
        );
        for vertex in 0..6 {
            let p = middle + turn * Vec3::from(BLADE[(vertex + i) % 6]) * 0.2;
            let stored = ((p + 4.0) / step).round().to_array().map(|x| x as u16);
            numbers.extend(stored.iter().flat_map(|x| x.to_le_bytes()));
            numbers.extend([0, 0]);
        }
        for t in 0..5 {
            let corners = BLADE_TRIANGLES[(t + 2 * i) % 5];
            for corner in 0..3 {
                let vertex = usize::from(corners[(corner + i) % 3]);
                indices.push((6 * i + (vertex + 6 - i % 6) % 6) as u16);
            }
        }
    }
    let positions = model.accessor(&numbers, common::U16, "VEC3", 6 * count);
    let view = model.json["accessors"][positions]["bufferView"].as_u64().unwrap() as usize;
    model.json["bufferViews"][view]["byteStride"] = json!(8);
    let indices = model.shorts(&indices);
    *model.leaves() = json!({ "attributes": { "POSITION": positions }, "indices": indices });
    model.json["nodes"][2]["scale"] = json!([step, step, step]);
    model.json["nodes"][2]["translation"] = json!([-4, -4, -4]);
    model
}

#[test]
fn equal_leaves_stay_equal_within_the_step_of_quantization() {
    // A leaf of 0.2 m: fine steps, those of 14 bits over 30 m, and coarse ones.
    for step in [0.0002, 0.002, 0.004] {
        let foliage = quantized(200, step).read().unwrap().tree.foliage;
        assert_eq!((foliage.leaves.len(), foliage.shapes.len()), (200, 1), "{step}");
        for leaf in &foliage.leaves {
            assert!((leaf.scale - 1.0).abs() < 0.1, "{}", leaf.scale);
        }
    }
}

/// A crown of a low-poly tree: a box.
#[test]
fn solid_crowns_become_leaves_over_their_surface() {
    let mut model = grown(1);
    let corner = |i: usize| {
        let side = |axis: usize| if i >> axis & 1 == 1 { 1.0 } else { -1.0 };
        [side(0), 3.0 + side(1), side(2)]
    };
    let positions = model.floats(&(0..8).map(corner).collect::<Vec<_>>());
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let indices =
        quads.iter().flat_map(|q| [q[0], q[1], q[2], q[0], q[2], q[3]]).collect::<Vec<u16>>();
    let indices = model.shorts(&indices);
    *model.leaves() =
        json!({ "attributes": { "POSITION": positions }, "indices": indices, "material": 1 });
    model.json["materials"] = json!([{ "name": "bark" }, { "pbrMetallicRoughness": { "baseColorFactor": [0.2, 0.5, 0.1, 1.0] } }]);
    let read = model.read().unwrap();
    assert_noted(&read, NoteCode::SolidCrowns, "1 closed solids");
    let foliage = &read.tree.foliage;
    assert!((1000..=40_000).contains(&foliage.leaves.len()), "{}", foliage.leaves.len());
    assert_eq!((foliage.shapes.len(), foliage.materials.len()), (1, 1));
    assert!(foliage.materials[0].base_color.distance(Vec3::new(0.2, 0.5, 0.1)) < 0.03);
    for leaf in &foliage.leaves {
        let inside = leaf.center - Vec3::Y * 3.0;
        assert!(inside.abs().max_element() < 1.1, "within the crown: {}", leaf.center);
        assert!(inside.abs().max_element() > 0.4, "near its surface: {}", leaf.center);
        assert!(leaf.scale * foliage.shapes[0].radius() < 0.3);
    }
    let deep =
        |l: &&windfall_core::foliage::Leaf| (l.center - Vec3::Y * 3.0).abs().max_element() < 0.9;
    let deep = foliage.leaves.iter().filter(deep).count();
    assert!(deep * 10 > foliage.leaves.len(), "{deep} leaves below the surface");
    let covered: f32 =
        foliage.leaves.iter().map(|l| l.scale * l.scale * foliage.shapes[0].area()).sum();
    assert!((1.5..4.0).contains(&(covered / 24.0)), "{covered} m2 over 24");
    // Kept whole where the user says that it is wood.
    let read = model.read_with(&named(&[], &["trunk", "leaves"])).unwrap_err();
    assert!(read.to_string().contains("no leaves"), "{read}");
}

#[test]
fn what_is_not_used_is_noted() {
    let mut model = Model::tree();
    model.texture(&png());
    let tangents = model.floats(&[[1.0f32, 0.0, 0.0, 1.0]; 8]);
    model.leaves()["attributes"]["TANGENT"] = json!(tangents);
    model.json["materials"][1]["normalTexture"] = json!({ "index": 0 });
    model.json["extensionsUsed"] = json!(["KHR_materials_transmission", "KHR_mesh_quantization"]);
    model.json["animations"] = json!([{ "channels": [], "samplers": [] }]);
    let points = json!({ "attributes": { "POSITION": 2 }, "mode": 0 });
    model.json["meshes"][1]["primitives"].as_array_mut().unwrap().push(points);
    let read = model.read().unwrap();
    for (code, part) in [
        (NoteCode::AnimationLeftOut, "1 animations"),
        (NoteCode::AttributeLeftOut, "TANGENT"),
        (NoteCode::ExtensionLeftOut, "KHR_materials_transmission"),
        (NoteCode::PrimitiveLeftOut, "mesh 1 \"leaves\", primitive 1"),
        (NoteCode::TextureLeftOut, "material 1 \"green\": normalTexture"),
    ] {
        assert_noted(&read, code, part);
    }
    assert!(!read.notes.iter().any(|note| note.message.contains("KHR_mesh_quantization")));
}

#[test]
fn a_leaf_as_long_as_the_tree_is_noted() {
    let mut model = grown(20);
    let quad = [[1.0f32, 0.5, 0.0], [1.4, 0.5, 0.0], [1.4, 3.4, 0.0], [1.0, 3.4, 0.0]];
    let positions = model.floats(&quad);
    let indices = model.shorts(&[0, 1, 2, 0, 2, 3]);
    let primitives = model.json["meshes"][1]["primitives"].as_array_mut().unwrap();
    primitives.push(json!({ "attributes": { "POSITION": positions }, "indices": indices }));
    assert_noted(&model.read().unwrap(), NoteCode::TallLeaf, "m long");
}
