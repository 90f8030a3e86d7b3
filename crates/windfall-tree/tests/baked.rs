//! Baked trees: what is written is read back bit for bit, other programs can read it, and what is wrong is refused.
#![expect(clippy::unwrap_used, reason = "this is test code")]

mod common;

use common::{Model, png};
use serde_json::{Value, json};
use windfall_core::simplify::PruneOrder;
use windfall_core::tree::{Surface, Tree, Wood};
use windfall_core::{InputError, InputErrorKind, Note, NoteCode};
use windfall_tree::bake::{About, BakeError, EXTENSION, SourceHash, Viewers, reseal};
use windfall_tree::{
    BakedTree, GrowOptions, ImportOptions, LeafCount, Species, Up, bake, export_glb, import,
    prepare, survey,
};

fn about() -> About {
    let source = SourceHash::of_species(Species::Oak, 1, &GrowOptions::default());
    // As they come back: of the baked file.
    let notes = vec![Note::new(NoteCode::NoWood, "b.glb", "node 3", "no \"wood\" at all")];
    About { source, prune_order: Some((PruneOrder::BlueNoise, 5)), notes }
}

fn grown(species: Species) -> Tree {
    let prune_order = about().prune_order;
    let leaves = LeafCount::Exactly(300);
    species.grow_as(3, &GrowOptions { leaves, prune_order, ..GrowOptions::default() })
}

fn baked(tree: &Tree) -> Vec<u8> {
    bake(tree, &about(), Viewers::Everything).unwrap()
}

/// A tree of cards with a picture, whose wood has it too.
fn of_cards() -> Tree {
    let mut model = Model::tree();
    model.texture(&png());
    let texture = model.json["materials"][1]["pbrMetallicRoughness"].clone();
    model.json["materials"][0]["pbrMetallicRoughness"] = texture;
    model.import().unwrap()
}

/// Every bit of a tree: Rust prints of each float the digits that tell it from all others.
fn bits(tree: &Tree) -> (String, Vec<Vec<u8>>) {
    let materials = tree.wood.materials.iter().chain(&tree.foliage.materials);
    let images = materials.filter_map(|material| match &material.surface {
        Surface::Texture(image, _) => Some(image.rgba.clone()),
        _ => None,
    });
    (format!("{tree:?}"), images.collect())
}

#[test]
fn every_array_comes_back_bit_for_bit() {
    let bare = Tree { wood: Wood::default(), ..grown(Species::Birch) };
    let mut bare = bare;
    prepare(&mut bare);
    let trees = [
        grown(Species::Oak),
        grown(Species::Ginkgo),
        of_cards(),
        bare,
        Model::tree().import().unwrap(),
    ];
    for tree in &trees {
        for viewers in [Viewers::Everything, Viewers::Wood] {
            let bytes = bake(tree, &about(), viewers).unwrap();
            let read = BakedTree::read(&bytes, "b.glb").unwrap();
            assert!(bits(&read.tree) == bits(tree), "{}", tree.name);
            assert_eq!(read.about, about());
            assert_eq!(bake(&read.tree, &read.about, viewers).unwrap(), bytes);
        }
    }
    assert_eq!(bits(&trees[2]).1.len(), 2, "both have their picture");
}

fn is_baked(bytes: &[u8]) -> bool {
    survey(bytes, "s.glb").unwrap().baked
}

#[test]
fn the_importer_recognises_a_baked_tree_and_scales_it() {
    let tree = Tree { name: "b.glb".into(), ..grown(Species::Birch) };
    let bytes = baked(&tree);
    assert!(is_baked(&bytes) && !is_baked(&Model::tree().glb()));
    let read = |options: &ImportOptions| {
        import(&bytes, "b.glb", options, &mut |_| Err("nothing is outside".into())).map(|import| {
            assert_eq!(import.notes, about().notes);
            let order = options.prune_order.or(about().prune_order);
            assert_eq!(import.baked, Some(About { prune_order: order, ..about() }));
            import.tree
        })
    };
    let settled = ImportOptions { prune_order: about().prune_order, ..Default::default() };
    for options in [ImportOptions::default(), settled] {
        assert!(bits(&read(&options).unwrap()) == bits(&tree));
    }
    let high = read(&ImportOptions { height: Some(7.0), ..Default::default() }).unwrap();
    assert!((high.height() - 7.0).abs() < 1e-4, "{}", high.height());
    // Another order than the baked one is that of the tree from the source.
    let other = Some((PruneOrder::Importance, 9));
    let options = ImportOptions { prune_order: other, ..Default::default() };
    let mut expected = tree.clone();
    windfall_tree::set_prune_order(&mut expected.foliage, PruneOrder::Importance, 9);
    assert!(bits(&read(&options).unwrap()) == bits(&expected));
    assert_ne!(expected.foliage.leaves, tree.foliage.leaves);
    let none = ImportOptions::default;
    for (name, options) in [
        ("node", ImportOptions { node: vec!["0".into()], ..none() }),
        ("leaves", ImportOptions { leaves: vec!["Blatt".into()], ..none() }),
        ("wood", ImportOptions { wood: vec!["1".into()], ..none() }),
        ("up", ImportOptions { up: Up::Z, ..none() }),
        ("unit", ImportOptions { unit: Some(0.01), ..none() }),
        ("ground", ImportOptions { ground: true, ..none() }),
        ("vertex_colors", ImportOptions { vertex_colors: false, ..none() }),
    ] {
        let error = read(&options).unwrap_err();
        assert_eq!((error.kind, &*error.place), (InputErrorKind::Unsupported, name));
        assert!(error.to_string().starts_with("b.glb: "), "{error}");
    }
}

#[test]
fn a_baked_tree_is_scaled_as_its_source_would_be() {
    let source = export_glb(&grown(Species::Maple)).unwrap();
    let read = |bytes: &[u8], height| {
        let options =
            ImportOptions { height, prune_order: about().prune_order, ..Default::default() };
        import(bytes, "h.glb", &options, &mut |_| Err(String::new())).unwrap().tree
    };
    let usual = read(&source, None);
    let there = read(&source, Some(7.0));
    let scaled = read(&baked(&usual), Some(7.0));
    assert!((scaled.height() - 7.0).abs() < 1e-4 && (usual.height() - 7.0).abs() > 2.0);
    let (a, b) = (&there.foliage, &scaled.foliage);
    assert_eq!(a.leaves.len(), b.leaves.len());
    for (a, b) in a.leaves.iter().zip(&b.leaves) {
        assert_eq!((a.shed_rank, a.shape, a.ambient), (b.shed_rank, b.shape, b.ambient));
        assert!(a.center.abs_diff_eq(b.center, 1e-4) && (a.scale - b.scale).abs() < 1e-5);
    }
    assert_eq!((a.shading, &a.simple_shapes), (b.shading, &b.simple_shapes));
    let seen = |tree: &Tree| tree.foliage.visibility;
    assert!((seen(&there).share - seen(&scaled).share).abs() < 1e-3);
    // The finest level has the first error that is tried, at the height at which the tree was baked.
    let factor = 7.0 / usual.height();
    for (level, baked) in scaled.wood.levels.iter().zip(&usual.wood.levels) {
        assert_eq!(level.indices, baked.indices);
        assert!((level.error - baked.error * factor).abs() < 1e-6);
    }
}

/// A copy without the extension: what a program makes of it that does not know the extension.
fn without_extension(bytes: &[u8]) -> Vec<u8> {
    let mut model = Model::from_glb(bytes);
    let document = model.json.as_object_mut().unwrap();
    document.remove("extensions").unwrap();
    document.remove("extensionsUsed").unwrap();
    model.glb()
}

#[test]
fn other_programs_find_the_same_wood_and_leaves() {
    for tree in [grown(Species::Oak), of_cards()] {
        let bytes = baked(&tree);
        // The crate validates what it reads.
        let document = gltf::Gltf::from_slice(&bytes).unwrap();
        let names: Vec<&str> = document.meshes().filter_map(|mesh| mesh.name()).collect();
        assert_eq!(names, ["wood", "leaves"]);
        let plain = without_extension(&bytes);
        assert!(!is_baked(&plain));
        let read = |bytes: &[u8]| {
            import(bytes, "p.glb", &ImportOptions::default(), &mut |_| Err(String::new()))
                .unwrap()
                .tree
        };
        // As the plain export, which other tests compare with the tree.
        let (plain, exported) = (read(&plain), read(&export_glb(&tree).unwrap()));
        assert_eq!(plain.foliage.leaves, exported.foliage.leaves);
        assert_eq!(plain.foliage.leaves.len(), tree.foliage.leaves.len());
        assert_eq!(plain.wood.indices.len(), tree.wood.indices.len());
        assert_eq!(plain.height(), exported.height());
        let wood_only = bake(&tree, &about(), Viewers::Wood).unwrap();
        let document = gltf::Gltf::from_slice(&wood_only).unwrap();
        assert_eq!(document.meshes().len(), 1);
        assert!(wood_only.len() < bytes.len());
    }
}

fn refused(bytes: &[u8]) -> InputError {
    import(bytes, "c.glb", &ImportOptions::default(), &mut |_| Err(String::new())).unwrap_err()
}

#[test]
fn a_truncated_or_damaged_file_is_refused() {
    let bytes = baked(&of_cards());
    for length in (0..bytes.len()).step_by(7) {
        refused(&bytes[..length]);
    }
    for at in (0..bytes.len()).step_by(3) {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x10;
        refused(&damaged);
    }
    let mut damaged = bytes.clone();
    let last = damaged.len() - 5;
    damaged[last] ^= 1;
    let error = refused(&damaged);
    assert_eq!((error.kind, &*error.place), (InputErrorKind::Malformed, EXTENSION));
    assert!(error.to_string().starts_with("c.glb: ") && error.cause.contains("damaged"), "{error}");
}

/// An edit of the extension, or of the binary chunk.
type Edit<'a> = &'a dyn Fn(&mut Value, &mut Vec<u8>);

/// The error for a file that was changed and given the right digest.
fn edited(tree: &Tree, edit: Edit<'_>) -> InputError {
    let mut model = Model::from_glb(&baked(tree));
    let mut extension = model.json["extensions"][EXTENSION].take();
    edit(&mut extension, &mut model.binary);
    model.json["extensions"][EXTENSION] = extension;
    let mut bytes = model.glb();
    reseal(&mut bytes);
    refused(&bytes)
}

#[test]
fn newer_versions_and_what_is_none_are_named() {
    use InputErrorKind::{Malformed, Unsupported};
    let tree = of_cards();
    let cases: [(Edit<'_>, InputErrorKind, &str); 8] = [
        (&|e, _| e["version"] = json!(2), Unsupported, "newer"),
        (&|e, _| e["version"] = json!(0), Unsupported, "no format version 0"),
        (&|e, _| e["version"] = json!("1"), Malformed, "no version"),
        (&|e, _| *e = json!(7), Malformed, "no version"),
        (&|e, _| e["leaf"] = json!(1), Malformed, "unknown field `leaf`"),
        (&|e, _| e["source"] = json!("0x"), Malformed, "source"),
        (&|e, _| e["notes"][0]["code"] = json!("none"), Malformed, "no note has the code"),
        (&|e, _| *e = json!({ "version": 1 }), Malformed, "missing field"),
    ];
    for (edit, kind, cause) in cases {
        let error = edited(&tree, edit);
        assert_eq!((error.kind, &*error.place), (kind, EXTENSION), "{error}");
        assert!(error.cause.contains(cause), "{error}");
    }
}

#[test]
fn what_does_not_fit_together_is_refused_with_its_place() {
    let tree = of_cards();
    let put = |binary: &mut Vec<u8>, view: &Value, views: &[usize], word: usize, value: [u8; 4]| {
        let at = views[view.as_u64().unwrap() as usize] + 4 * word;
        binary[at..at + 4].copy_from_slice(&value);
    };
    let views: Vec<usize> = Model::from_glb(&baked(&tree)).json["bufferViews"]
        .as_array()
        .unwrap()
        .iter()
        .map(|view| view["byteOffset"].as_u64().unwrap_or(0) as usize)
        .collect();
    let nan = f32::NAN.to_le_bytes();
    let many = 99u32.to_le_bytes();
    let cases: [(Edit<'_>, &str, &str); 18] = [
        (&|e, b| put(b, &e["leaves"]["records"], &views, 0, nan), "leaves", "leaf 0"),
        (
            &|e, b| put(b, &e["leaves"]["records"], &views, 3, 0f32.to_le_bytes()),
            "leaves",
            "leaf 0",
        ),
        (
            &|e, b| put(b, &e["leaves"]["records"], &views, 5, 3f32.to_le_bytes()),
            "leaves",
            "leaf 0",
        ),
        (&|e, b| put(b, &e["leaves"]["records"], &views, 12, many), "leaves", "shape 99 of"),
        (&|e, b| put(b, &e["leaves"]["records"], &views, 13, many), "leaves", "material 99 of"),
        (&|e, b| put(b, &e["leaves"]["records"], &views, 14, many), "leaves", "shed rank 99"),
        (&|e, b| put(b, &e["wood"]["vertices"], &views, 1, nan), "wood", "vertex 0"),
        (&|e, b| put(b, &e["wood"]["indices"], &views, 4, many), "wood", "index 4 is 99"),
        (&|e, b| put(b, &e["wood"]["branches"], &views, 0, nan), "wood", "vertex 0"),
        (
            &|e, b| put(b, &e["leaves"]["shapes"]["counts"], &views, 0, many),
            "leaves, shapes",
            "shape 0 has 99 vertices",
        ),
        (
            &|e, b| put(b, &e["leaves"]["shapes"]["counts"], &views, 0, [255; 4]),
            "leaves, shapes",
            "shape 0 is not there",
        ),
        (
            &|e, b| put(b, &e["leaves"]["shapes"]["indices"], &views, 0, many),
            "leaves, shape 0",
            "index 0 is 99",
        ),
        (&|e, _| e["leaves"]["records"] = json!(99), "leaves", "names buffer view 99"),
        (
            &|e, _| e["leaves"]["records"] = e["wood"]["branches"].clone(),
            "leaves",
            "no multiple of 60",
        ),
        (&|e, _| e["wood"]["materials"] = json!([]), "wood", "material 0 of 0"),
        (
            &|e, _| e["wood"]["materials"][0]["surface"]["texture"]["image"] = json!(5),
            "wood, material 0, image 5",
            "there are 1 images",
        ),
        (
            &|e, _| e["leaves"]["materials"][0]["roughness"] = json!(2),
            "leaves, material 0",
            "roughness",
        ),
        (&|e, _| e["leaves"]["visibility"]["share"] = json!(-1), "leaves, visibility", "share"),
    ];
    for (i, (edit, place, cause)) in cases.into_iter().enumerate() {
        let error = edited(&tree, edit);
        assert_eq!(error.place, format!("{EXTENSION}, {place}"), "{i}: {error}");
        assert!(error.cause.contains(cause), "{i}: {error}");
    }
    // Without an edit it is read.
    let model = Model::from_glb(&baked(&tree));
    let mut bytes = model.glb();
    reseal(&mut bytes);
    assert!(BakedTree::read(&bytes, "").is_ok());
}

#[test]
fn views_outside_the_binary_chunk_are_refused() {
    let tree = of_cards();
    for (field, value, cause) in [
        ("byteOffset", json!(u64::MAX), "do not fit"),
        ("byteLength", json!(1 << 30), "do not fit"),
        ("buffer", json!(1), "not in the binary chunk"),
    ] {
        let mut model = Model::from_glb(&baked(&tree));
        let view = model.json["extensions"][EXTENSION]["leaves"]["records"].as_u64().unwrap();
        model.json["bufferViews"][view as usize][field] = value;
        let mut bytes = model.glb();
        reseal(&mut bytes);
        let error = refused(&bytes);
        assert_eq!(error.place, format!("{EXTENSION}, leaves"), "{error}");
        assert!(error.cause.contains(cause), "{error}");
    }
}

#[test]
fn only_whole_trees_are_baked() {
    let tree = grown(Species::Beech);
    let fault = |edit: &dyn Fn(&mut Tree)| {
        let mut tree = tree.clone();
        edit(&mut tree);
        bake(&tree, &about(), Viewers::Everything).unwrap_err()
    };
    for edit in [&(|t: &mut Tree| t.wood.levels.clear()) as &dyn Fn(&mut Tree), &|t: &mut Tree| {
        t.foliage.simple_shapes.clear();
    }] {
        assert!(matches!(fault(edit), BakeError::NotPrepared { .. }));
    }
    let error = fault(&|t| t.foliage.leaves[7].center.x = f32::NAN);
    assert!(matches!(&error, BakeError::Unfit { place, .. } if place == "leaves"), "{error}");
    assert!(error.to_string().contains("leaf 7"), "{error}");
}

/// In the workspace the feature is on: the programs want it.
#[cfg(feature = "parallel")]
#[test]
fn the_bytes_are_the_same_for_any_number_of_threads() {
    let cards = || {
        let mut model = Model::tree();
        model.texture(&png());
        model.import().unwrap()
    };
    let bytes = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| [grown(Species::Oak), cards()].map(|tree| baked(&tree)))
    };
    let one = bytes(1);
    for threads in [2, 3, 7] {
        assert!(bytes(threads) == one, "{threads}");
    }
}
