//! A small glTF tree that tests bend and break.
#![allow(dead_code, reason = "every test file uses a part of it")]
#![expect(clippy::unwrap_used, reason = "this is test code")]

use serde_json::{Value, json};
use windfall_core::InputError;
use windfall_core::tree::Tree;
use windfall_tree::{Import, ImportOptions, import};

/// A document and its binary chunk.
#[derive(Clone)]
pub struct Model {
    pub json: Value,
    pub binary: Vec<u8>,
}

pub const TRUNK: [[f32; 3]; 4] =
    [[-0.1, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 2.0, 0.0], [-0.1, 2.0, 0.0]];

/// Two cards that do not touch, as wide as high.
///
/// ```text
///   3--2   7--6
///   | /|   | /|     y = 2..3
///   |/ |   |/ |
///   0--1   4--5
///  x=0..1  x=2..3
/// ```
pub const LEAVES: [[f32; 3]; 8] = [
    [0.0, 2.0, 0.0],
    [1.0, 2.0, 0.0],
    [1.0, 3.0, 0.0],
    [0.0, 3.0, 0.0],
    [2.0, 2.0, 0.0],
    [3.0, 2.0, 0.0],
    [3.0, 3.0, 0.0],
    [2.0, 3.0, 0.0],
];
pub const CARD: [[f32; 2]; 4] = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];

pub const F32: u32 = 5126;
pub const U32: u32 = 5125;
pub const U16: u32 = 5123;
pub const U8: u32 = 5121;
pub const I16: u32 = 5122;
pub const I8: u32 = 5120;

impl Model {
    /// A trunk (accessors 0, 1), and leaves (2, 3, texture coordinates 4): nodes "tree", "trunk",
    /// "leaves".
    pub fn tree() -> Self {
        let mut model = Self {
            json: json!({
                "asset": { "version": "2.0" },
                "scene": 0,
                "scenes": [{ "nodes": [0] }],
                "nodes": [
                    { "name": "tree", "children": [1, 2] },
                    { "name": "trunk", "mesh": 0 },
                    { "name": "leaves", "mesh": 1 },
                ],
                "meshes": [
                    { "name": "trunk", "primitives": [
                        { "attributes": { "POSITION": 0 }, "indices": 1, "material": 0 } ] },
                    { "name": "leaves", "primitives": [
                        { "attributes": { "POSITION": 2, "TEXCOORD_0": 4 }, "indices": 3 } ] },
                ],
                "materials": [{ "name": "bark" }],
                "accessors": [],
                "bufferViews": [],
                "buffers": [{ "byteLength": 0 }],
            }),
            binary: Vec::new(),
        };
        model.floats(&TRUNK);
        model.shorts(&[0, 1, 2, 0, 2, 3]);
        model.floats(&LEAVES);
        model.shorts(&[0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7]);
        model.floats(&[CARD, CARD].concat());
        model
    }

    /// Adds an accessor over bytes of its own; its index.
    pub fn accessor(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let view = self.view(bytes);
        let accessors = self.json["accessors"].as_array_mut().unwrap();
        accessors.push(json!({
            "bufferView": view, "componentType": component, "type": kind, "count": count,
        }));
        accessors.len() - 1
    }

    pub fn view(&mut self, bytes: &[u8]) -> usize {
        let views = self.json["bufferViews"].as_array_mut().unwrap();
        views.push(json!({
            "buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len(),
        }));
        let view = views.len() - 1;
        self.binary.extend(bytes);
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.json["buffers"][0]["byteLength"] = json!(self.binary.len());
        view
    }

    pub fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(&bytes, F32, &format!("VEC{N}"), values.len())
    }

    pub fn shorts(&mut self, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(&bytes, U16, "SCALAR", values.len())
    }

    /// The primitive of the leaves.
    pub fn leaves(&mut self) -> &mut Value {
        &mut self.json["meshes"][1]["primitives"][0]
    }

    /// Gives the leaves a material with a picture that is stored in the file.
    pub fn texture(&mut self, picture: &[u8]) {
        let view = self.view(picture);
        self.json["materials"] = json!([
            { "name": "bark" },
            {
                "name": "green",
                "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } },
                "alphaMode": "MASK",
            },
        ]);
        self.json["textures"] = json!([{ "source": 0 }]);
        self.json["images"] = json!([{ "bufferView": view, "mimeType": "image/png" }]);
        self.leaves()["material"] = json!(1);
    }

    /// The document and the binary chunk of a GLB.
    pub fn from_glb(bytes: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        let json = serde_json::from_slice(&bytes[20..20 + word(12)]).unwrap();
        Self { json, binary: bytes[20 + word(12) + 8..].to_vec() }
    }

    pub fn glb(&self) -> Vec<u8> {
        let mut json = self.json.to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let length = 12 + 8 + json.len() + 8 + self.binary.len();
        let word = |value: usize| (value as u32).to_le_bytes();
        [
            b"glTF".as_slice(),
            &word(2),
            &word(length),
            &word(json.len()),
            b"JSON",
            &json,
            &word(self.binary.len()),
            b"BIN\0",
            &self.binary,
        ]
        .concat()
    }

    pub fn import(&self) -> Result<Tree, InputError> {
        self.import_with(&ImportOptions::default())
    }

    pub fn import_with(&self, options: &ImportOptions) -> Result<Tree, InputError> {
        Ok(self.read_with(options)?.tree)
    }

    pub fn read(&self) -> Result<Import, InputError> {
        self.read_with(&ImportOptions::default())
    }

    pub fn read_with(&self, options: &ImportOptions) -> Result<Import, InputError> {
        import(&self.glb(), "tree.glb", options, &mut |_| Err("no such file".into()))
    }
}

/// A picture of 2 by 2 pixels, as a PNG.
pub fn png() -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbaImage::from_fn(2, 2, |x, y| image::Rgba([255 * x as u8, 255 * y as u8, 0, 255]))
        .write_to(&mut bytes, image::ImageFormat::Png)
        .unwrap();
    bytes.into_inner()
}

/// Centres of the leaves, sorted by x.
pub fn centers(tree: &Tree) -> Vec<[f32; 3]> {
    let mut centers: Vec<[f32; 3]> =
        tree.foliage.leaves.iter().map(|l| l.center.to_array()).collect();
    centers.sort_by(|a, b| a[0].total_cmp(&b[0]));
    centers
}
