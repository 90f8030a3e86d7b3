//! Replays the corpus of the fuzz target `baked_tree`: a tree or an error, never a panic.

mod common;

use common::{Model, png};
use serde_json::json;
use std::path::{Path, PathBuf};
use windfall_tree::bake::{About, EXTENSION, SourceHash, Viewers, reseal};
use windfall_tree::{BakedTree, ImportOptions, bake};

fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus/baked_tree")
}

#[test]
fn the_corpus_is_read_or_refused() {
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(corpus()).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(files.len() >= 10, "the corpus is there");
    let (mut read, mut refused) = (0, 0);
    for path in &files {
        let name = path.file_name().unwrap().to_string_lossy();
        let bytes = std::fs::read(path).unwrap();
        let mut sealed = bytes.clone();
        reseal(&mut sealed);
        for bytes in [bytes, sealed] {
            match BakedTree::read(&bytes, &name) {
                Ok(baked) => {
                    assert!(baked.tree.height().is_finite(), "{name}");
                    bake(&baked.tree, &baked.about, Viewers::Everything).unwrap();
                    read += 1;
                }
                Err(error) => {
                    assert!(error.to_string().starts_with(&*name), "{error}");
                    refused += 1;
                }
            }
        }
    }
    assert!(read >= 4 && refused >= 10, "{read} read, {refused} refused");
}

#[test]
fn no_word_of_a_file_makes_it_fail_in_another_way() {
    let seed = std::fs::read(corpus().join("picture.glb")).unwrap();
    for word in [u32::MAX, 0, 0x7f80_0000, 0x7fc0_0001, 0x0001_0000] {
        for at in (20..seed.len() - 4).step_by(4) {
            let mut bytes = seed.clone();
            bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
            reseal(&mut bytes);
            if let Ok(baked) = BakedTree::read(&bytes, "a.glb") {
                assert!(baked.tree.height().is_finite());
                bake(&baked.tree, &baked.about, Viewers::Everything).unwrap();
            }
        }
    }
}

/// Writes the seeds anew: `cargo test -p windfall-tree --test baked_corpus -- --ignored`.
#[test]
#[ignore = "writes files"]
fn write_the_seeds() {
    let write = |name: &str, bytes: &[u8]| std::fs::write(corpus().join(name), bytes).unwrap();
    let source = SourceHash::of_file(b"a seed", &[], &ImportOptions::default());
    let about = About { source, prune_order: None, notes: Vec::new() };
    let baked =
        |model: &Model| bake(&model.import().unwrap(), &about, Viewers::Everything).unwrap();
    let edited = |name: &str, edit: &dyn Fn(&mut Model)| {
        let mut model = Model::tree();
        model.texture(&png());
        let mut model = Model::from_glb(&baked(&model));
        edit(&mut model);
        let mut bytes = model.glb();
        reseal(&mut bytes);
        write(name, &bytes);
    };
    let plain = baked(&Model::tree());
    write("plain.glb", &plain);
    write("empty.glb", b"");
    write("truncated.glb", &plain[..plain.len() / 2]);
    write("header.glb", &plain[..20]);
    let mut damaged = plain.clone();
    let last = damaged.len() - 4;
    damaged[last] ^= 0xff;
    write("damaged.glb", &damaged);
    write("not-baked.glb", &Model::tree().glb());
    edited("picture.glb", &|_| {});
    edited("newer.glb", &|m| m.json["extensions"][EXTENSION]["version"] = json!(2));
    edited("no-version.glb", &|m| m.json["extensions"][EXTENSION] = json!({}));
    edited("lost.glb", &|m| m.json["extensions"] = json!({}));
    edited("outside.glb", &|m| m.json["bufferViews"][3]["byteOffset"] = json!(u64::MAX));
    edited("huge.glb", &|m| m.json["bufferViews"][3]["byteLength"] = json!(u64::MAX));
    edited("shuffled.glb", &|m| m.json["bufferViews"].as_array_mut().unwrap().rotate_left(1));
    edited("poison.glb", &|m| {
        let middle = m.binary.len() / 2;
        m.binary[middle..].fill(0xff);
    });
    edited("zeros.glb", &|m| m.binary.fill(0));
    edited("no-binary.glb", &|m| m.binary.clear());
}
