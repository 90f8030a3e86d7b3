//! Replays the corpus of the fuzz target `tree_import`: a tree or an error, never a panic.

mod common;

use common::{Model, U32, png};
use serde_json::json;
use std::path::{Path, PathBuf};
use windfall_tree::{ImportOptions, export_glb, import};

fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus/tree_import")
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
        let outside = &mut |_: &str| Ok(vec![0; 256]);
        match import(&bytes, &name, &ImportOptions::default(), outside) {
            Ok(read_tree) => {
                let tree = read_tree.tree;
                assert!(tree.height().is_finite(), "{name}");
                export_glb(&tree).unwrap();
                read += 1;
            }
            Err(error) => {
                assert!(error.to_string().starts_with(&*name), "{error}");
                refused += 1;
            }
        }
    }
    assert!(read >= 3 && refused >= 5, "{read} read, {refused} refused");
}

/// Writes the seeds anew: `cargo test -p windfall-tree --test tree_corpus -- --ignored`.
#[test]
#[ignore = "writes files"]
fn write_the_seeds() {
    let write = |name: &str, bytes: &[u8]| std::fs::write(corpus().join(name), bytes).unwrap();
    let edited = |name: &str, edit: &dyn Fn(&mut Model)| {
        let mut model = Model::tree();
        edit(&mut model);
        write(name, &model.glb());
    };
    let valid = Model::tree().glb();
    write("valid.glb", &valid);
    write("empty.glb", b"");
    write("truncated.glb", &valid[..valid.len() / 2]);
    write("header.glb", &valid[..12]);
    write("garbage.bin", &[0xa5, 0x00, 0xff, 0x67, 0x6c, 0x54, 0x46]);
    write("document.gltf", Model::tree().json.to_string().as_bytes());
    edited("picture.glb", &|m| m.texture(&png()));
    edited("instances.glb", &|m| {
        let moves = m.floats(&[[0.0f32, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 2.0, 1.0]]);
        m.json["nodes"][2]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] =
            json!({ "TRANSLATION": moves });
    });
    edited("skin.glb", &|m| {
        let joints = m.accessor(&[0; 32], common::U8, "VEC4", 8);
        let weights = m.floats(&[[1.0f32, 0.0, 0.0, 0.0]; 8]);
        m.leaves()["attributes"]["JOINTS_0"] = json!(joints);
        m.leaves()["attributes"]["WEIGHTS_0"] = json!(weights);
        m.json["skins"] = json!([{ "joints": [1] }]);
        m.json["nodes"][2]["skin"] = json!(0);
    });
    edited("colors.glb", &|m| {
        let colors = m.floats(&[[0.5f32, 0.25, 0.0]; 8]);
        m.leaves()["attributes"]["COLOR_0"] = json!(colors);
        m.leaves()["targets"] = json!([{ "POSITION": 2 }]);
        m.json["nodes"][2]["weights"] = json!([0.5]);
        m.json["nodes"][0]["extensions"]["MSFT_lod"]["ids"] = json!([9]);
    });
    edited("broken-picture.glb", &|m| m.texture(&png()[..40]));
    edited("outside.glb", &|m| m.json["buffers"][0]["uri"] = json!("trunk.bin"));
    edited("huge-count.glb", &|m| m.json["accessors"][2]["count"] = json!(u64::MAX));
    edited("cycle.glb", &|m| m.json["nodes"][2]["children"] = json!([0]));
    edited("strip.glb", &|m| m.leaves()["mode"] = json!(5));
    edited("draco.glb", &|m| {
        m.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    });
    edited("poison.glb", &|m| m.binary[0..4].copy_from_slice(&f32::NAN.to_le_bytes()));
    edited("sparse.glb", &|m| {
        let (indices, values) = (m.view(&[6]), m.view(&[0; 12]));
        m.json["accessors"][2]["sparse"] = json!({
            "count": 1,
            "indices": { "bufferView": indices, "componentType": 5121 },
            "values": { "bufferView": values },
        });
    });
    edited("packed.glb", &|m| {
        let list = [0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7];
        let view = m.view(&meshopt::encode_index_buffer(&list, 8).unwrap());
        let mut source = m.json["bufferViews"][view].clone();
        source["mode"] = json!("TRIANGLES");
        source["byteStride"] = json!(4);
        source["count"] = json!(12);
        m.json["bufferViews"][view]["extensions"] = json!({ "EXT_meshopt_compression": source });
        m.json["accessors"][3]["bufferView"] = json!(view);
        m.json["accessors"][3]["componentType"] = json!(U32);
    });
    edited("transform.glb", &|m| {
        m.texture(&png());
        m.json["nodes"][0]["matrix"] = json!([-2, 0, 0, 0, 0, 0, 3, 0, 0, 1, 0, 0, 5, 6, 7, 1]);
        m.json["materials"][1]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] =
            json!({ "KHR_texture_transform": { "rotation": 1.0, "scale": [2.0, 3.0] } });
    });
}
