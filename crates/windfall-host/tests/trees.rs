//! Trees that programs load: from bytes or files, through a cache, on threads, and stopped on the way.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use windfall_host::cache::TreeCache;
use windfall_host::tree::{TreeSource, go_on, load_all};
use windfall_tree::bake::Viewers;
use windfall_tree::prepare::Stage;
use windfall_tree::{
    GrowOptions, Import, ImportOptions, LeafCount, Species, bake, export_glb, prepare_in_order,
};

fn species(seed: u32) -> TreeSource {
    let options = GrowOptions { leaves: LeafCount::Exactly(60), ..GrowOptions::default() };
    TreeSource::Species { species: Species::Aspen, seed, options }
}

/// A `.gltf` whose buffer is a file beside it, and that file.
fn in_two() -> (Vec<u8>, Vec<u8>) {
    let glb = export_glb(&Species::Birch.grow_with(1, 60)).unwrap();
    let json = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let text = String::from_utf8(glb[20..20 + json].to_vec()).unwrap();
    let named = text.replacen("\"buffers\":[{", "\"buffers\":[{\"uri\":\"the%20leaves.bin\",", 1);
    assert_ne!(named, text);
    (named.into_bytes(), glb[28 + json..].to_vec())
}

fn load(source: &TreeSource, cache: Option<&TreeCache>) -> Import {
    source.load(cache, &mut go_on).unwrap().unwrap()
}

fn all(import: &Import) -> String {
    format!("{:?} {:?}", import.tree, import.notes)
}

#[test]
fn bytes_and_files_are_the_same_tree_with_and_without_a_cache() {
    let folder = tempfile::tempdir().unwrap();
    let cache = TreeCache::at(folder.path().join("cache"), TreeCache::MOST_BYTES);
    let (document, buffer) = in_two();
    let path = folder.path().join("birch.gltf");
    std::fs::write(&path, &document).unwrap();
    let options = ImportOptions { height: Some(9.0), ..ImportOptions::default() };
    let name = path.display().to_string();
    let file = TreeSource::File { path, options: options.clone() };
    // What it names is not there.
    let error = file.load(Some(&cache), &mut go_on).unwrap_err().to_string();
    assert!(error.contains("birch.gltf: ") && error.contains("the leaves.bin"), "{error}");
    assert!(cache.trees().unwrap().is_empty());
    std::fs::write(folder.path().join("the leaves.bin"), &buffer).unwrap();
    let alone = load(&file, None);
    assert_eq!((&alone.tree.name, alone.tree.foliage.leaves.len()), (&name, 60));
    assert_eq!(all(&load(&file, Some(&cache))), all(&alone));
    assert_eq!(cache.trees().unwrap().len(), 1);
    assert_eq!(all(&load(&file, Some(&cache))), all(&alone));
    // The same bytes are in the cache, whatever they are called.
    let outside = BTreeMap::from([("the leaves.bin".to_owned(), buffer.clone())]);
    let bytes = TreeSource::Bytes { name: "b".into(), bytes: document.clone(), outside, options };
    let read = load(&bytes, Some(&cache));
    assert_eq!(read.tree.name, "b");
    assert!(read.notes.iter().all(|note| note.file == "b"));
    assert_eq!(cache.trees().unwrap().len(), 1);
    assert_eq!(read.tree.foliage.leaves, alone.tree.foliage.leaves);
    // Another buffer is another tree.
    let mut other = buffer;
    let last = other.len() - 1;
    other.truncate(last - last % 4);
    std::fs::write(folder.path().join("the leaves.bin"), &other).unwrap();
    assert!(file.load(Some(&cache), &mut go_on).is_err(), "it is not taken from the cache");
}

#[test]
fn a_baked_tree_is_read_as_it_is_and_not_kept_twice() {
    let folder = tempfile::tempdir().unwrap();
    let cache = TreeCache::at(folder.path().join("cache"), TreeCache::MOST_BYTES);
    let (import, about) = species(1).prepare(&mut go_on).unwrap().unwrap();
    let bytes = bake(&import.tree, &about, Viewers::Everything).unwrap();
    let path = folder.path().join("aspen.glb");
    std::fs::write(&path, bytes).unwrap();
    let read = load(&TreeSource::File { path, options: ImportOptions::default() }, Some(&cache));
    assert_eq!(read.baked, Some(about));
    assert_eq!(read.tree.foliage.leaves, import.tree.foliage.leaves);
    assert!(cache.trees().unwrap().is_empty());
}

#[test]
fn trees_come_in_their_order_with_the_first_error() {
    let sources = [3, 1, 2, 3].map(species);
    let told = AtomicUsize::new(0);
    let trees = load_all(&sources, None, &|tree, _| {
        told.fetch_or(1 << tree, Ordering::Relaxed);
        ControlFlow::Continue(())
    });
    let trees = trees.unwrap().unwrap();
    assert_eq!(told.into_inner(), 0b1111);
    for (tree, source) in trees.iter().zip(&sources) {
        assert_eq!(all(tree), all(&load(source, None)));
    }
    assert!(load_all(&[], None, &|_, _| ControlFlow::Continue(())).unwrap().unwrap().is_empty());
    let file =
        |name: &str| TreeSource::File { path: name.into(), options: ImportOptions::default() };
    let sources = [species(1), file("first.glb"), file("second.glb"), species(2)];
    let error = load_all(&sources, None, &|_, _| ControlFlow::Continue(())).unwrap_err();
    assert!(error.to_string().starts_with("first.glb: "), "{error}");
}

#[test]
fn loading_stops_where_it_is_told_to() {
    let folder = tempfile::tempdir().unwrap();
    let cache = TreeCache::at(folder.path().to_owned(), TreeCache::MOST_BYTES);
    let mut tree = Species::Birch.grow_with(1, 60);
    prepare_in_order(&mut tree, windfall_core::simplify::PruneOrder::Random, 1);
    let file = TreeSource::Bytes {
        name: "birch".into(),
        bytes: export_glb(&tree).unwrap(),
        outside: BTreeMap::new(),
        options: ImportOptions {
            prune_order: Some((windfall_core::simplify::PruneOrder::Importance, 1)),
            ..ImportOptions::default()
        },
    };
    for source in [species(1), file] {
        let ordered = matches!(source, TreeSource::Bytes { .. });
        for last in Stage::ALL.into_iter().filter(|&stage| ordered || stage != Stage::Order) {
            let mut seen = Vec::new();
            let stopped = source.load(Some(&cache), &mut |stage| {
                seen.push(stage);
                if stage == last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            });
            assert!(stopped.unwrap().is_none(), "{last:?}");
            assert_eq!(seen.last(), Some(&last));
            assert_eq!(seen.iter().filter(|&&stage| stage == last).count(), 1);
        }
        assert!(cache.trees().unwrap().is_empty(), "nothing half prepared is kept");
    }
    let stopped = load_all(&[1, 2, 3].map(species), Some(&cache), &|tree, stage| {
        if (tree, stage) == (1, Stage::Wood) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    assert!(stopped.unwrap().is_none());
}
