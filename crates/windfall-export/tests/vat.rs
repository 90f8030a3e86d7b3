//! Vertex animation textures, decoded. `scripts/check-export` decodes them in Python too.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::{MOMENTS, Place, angle, reference, select};
use serde_json::Value;
use std::io::Cursor;
use windfall_core::glam::{Mat3, Quat, Vec3, Vec4};
use windfall_export::vat::{Engine, Files, Texels, Vat, Which};
use windfall_export::{Filter, LeafId};

const ENGINES: [Engine; 3] = [Engine::Godot, Engine::Unity, Engine::Unreal];

/// The texels of a texture, as an image reader has them.
fn read(bytes: &[u8], texels: Texels) -> (usize, Vec<Vec4>) {
    let format = match texels {
        Texels::Exr => image::ImageFormat::OpenExr,
        Texels::Png => image::ImageFormat::Png,
    };
    let image = image::load_from_memory_with_format(bytes, format).unwrap();
    let width = image.width() as usize;
    let texels = match image {
        image::DynamicImage::ImageRgba32F(image) => {
            image.pixels().map(|p| Vec4::from(p.0)).collect()
        }
        image::DynamicImage::ImageRgba16(image) => {
            image.pixels().map(|p| Vec4::from(p.0.map(f32::from)) / 65_535.0).collect()
        }
        other => panic!("{:?}", other.color()),
    };
    (width, texels)
}

fn vector(value: &Value) -> Vec3 {
    Vec3::from([0, 1, 2].map(|i| value[i].as_f64().unwrap() as f32))
}

fn files() -> Files {
    Files { position: "p".into(), rotation: "r".into(), mesh: "m.glb".into() }
}

#[test]
fn texels_are_the_poses_of_the_reference_in_each_engines_axes() {
    let place = Place::new();
    let source = place.source();
    let filter = Filter { parts: "falling".parse().unwrap(), ..Filter::NONE };
    let selection = select(&source, MOMENTS, filter);
    for engine in ENGINES {
        let vat = Vat::new(&selection, engine, &mut |_| ()).unwrap();
        for texels in [Texels::Exr, Texels::Png] {
            let texture = |which| {
                let mut out = Cursor::new(Vec::new());
                vat.write_texture(which, texels, &mut out, &mut |_| ()).unwrap();
                read(out.get_ref(), texels)
            };
            let ((width, positions), (_, rotations)) =
                (texture(Which::Position), texture(Which::Rotation));
            let facts: Value = serde_json::from_slice(&vat.sidecar(texels, &files())).unwrap();
            assert_eq!((width, positions.len()), (vat.size().0, vat.size().0 * vat.size().1));
            // By the sidecar alone, as an engine would.
            let axes = [0, 1, 2].map(|row| vector(&facts["axes"][row]));
            let windfall = Mat3::from_cols_array_2d(&axes.map(|a| a.to_array()));
            let unit = facts["unitsPerMetre"].as_f64().unwrap() as f32;
            let (low, high) =
                (vector(&facts["position"]["low"]), vector(&facts["position"]["high"]));
            let [from, to] =
                ["low", "high"].map(|end| facts["rotation"][end].as_f64().unwrap() as f32);
            let (columns, frames) =
                (facts["columns"].as_u64().unwrap() as usize, MOMENTS.count as usize);
            for frame in [0, 31, frames - 1] {
                let expected = reference(&source, MOMENTS.time(MOMENTS.first + frame as u32));
                for (i, id) in facts["ids"].as_array().unwrap().iter().enumerate() {
                    let leaf = &expected[&LeafId(id.as_u64().unwrap())];
                    let at = (i / columns * frames + frame) * width + i % columns;
                    let texel = positions[at];
                    let position = windfall * (low + texel.truncate() * (high - low)) / unit;
                    let off = position.distance(leaf.position);
                    assert!(off < 1e-3, "{engine:?} {texels:?}: {off} m");
                    assert_eq!(texel.w == 1.0, leaf.phase == "falling");
                    let q = rotations[at] * (to - from) + from;
                    // The rotation as a matrix, from the engine's axes to ours.
                    let turned = windfall
                        * Mat3::from_quat(Quat::from_vec4(q).normalize())
                        * windfall.transpose();
                    let off = angle(Quat::from_mat3(&turned), leaf.orientation);
                    assert!(off < 0.1, "{engine:?} {texels:?}: {off} degrees");
                }
            }
            let (least, most) = (vector(&facts["bounds"]["low"]), vector(&facts["bounds"]["high"]));
            assert!(least.cmplt(most).all());
        }
        assert!(vat.rounding() < 5e-4, "{}", vat.rounding());
    }
}

#[test]
fn a_mesh_has_every_leaf_at_its_texel() {
    let place = Place::new();
    let source = place.source();
    let selection = select(&source, MOMENTS, Filter::NONE);
    let vat = Vat::new(&selection, Engine::Godot, &mut |_| ()).unwrap();
    let mut bytes = Vec::new();
    vat.write_mesh(&mut bytes, &mut |_| ()).unwrap();
    let end = 20 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let json: Value = serde_json::from_slice(&bytes[20..end]).unwrap();
    assert_eq!(json["buffers"][0]["byteLength"], bytes.len() - end - 8);
    let primitives = json["meshes"][0]["primitives"].as_array().unwrap();
    let facts: Value = serde_json::from_slice(&vat.sidecar(Texels::Exr, &files())).unwrap();
    let mut leaves = 0;
    for (primitive, of) in primitives.iter().zip(facts["meshes"].as_array().unwrap()) {
        let view = |name: &str| {
            let accessor =
                &json["accessors"][primitive["attributes"][name].as_u64().unwrap() as usize];
            let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
            let first = end + 8 + view["byteOffset"].as_u64().unwrap() as usize;
            let length = view["byteLength"].as_u64().unwrap() as usize;
            let floats = bytes[first..first + length].chunks(4);
            floats.map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect::<Vec<f32>>()
        };
        let count = of["leaves"].as_u64().unwrap() as usize;
        let addresses = view("TEXCOORD_1");
        let corners = addresses.len() / 2 / count;
        assert_eq!(view("POSITION").len(), count * corners * 3);
        for leaf in 0..count {
            let i = of["firstLeaf"].as_u64().unwrap() as usize + leaf;
            let at = leaf * corners * 2;
            assert_eq!(addresses[at..at + 2], vat.address(i).to_array());
        }
        leaves += count;
    }
    assert_eq!(leaves, selection.len());
}

#[test]
fn too_many_frames_or_no_leaf_are_refused() {
    let place = Place::new();
    let source = place.source();
    let none = Filter { most: Some(0), ..Filter::NONE };
    let selection = select(&source, MOMENTS, none);
    let error = Vat::new(&selection, Engine::Godot, &mut |_| ()).err().unwrap().to_string();
    assert!(error.contains("no leaf is selected"), "{error}");
    let long = windfall_export::Moments { count: 20_000, ..MOMENTS };
    let one = Filter { parts: "landed".parse().unwrap(), most: Some(1), ..Filter::NONE };
    let selection = select(&source, long, one);
    let error = Vat::new(&selection, Engine::Godot, &mut |_| ()).err().unwrap().to_string();
    assert!(error.contains("20000 frames"), "{error}");
}
