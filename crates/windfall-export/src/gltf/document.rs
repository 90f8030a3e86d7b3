//! The lists of a glTF document, and its container.

use crate::mesh::{Mesh, encode, picture};
use crate::selection::Selection;
use crate::{ExportError, plain_color};
use glam::Vec3;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::io::Write;
use windfall_core::material::Material;

const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;

/// Writes a GLB up to the contents of its binary chunk, whose length is a multiple of 4.
pub(crate) fn begin_glb(out: &mut dyn Write, json: &[u8], binary: u64) -> Result<(), ExportError> {
    let padded = json.len().next_multiple_of(4);
    let chunk = if binary == 0 { 0 } else { 8 + binary };
    let length = 12 + 8 + padded as u64 + chunk;
    let total = u32::try_from(length).map_err(|_| ExportError::TooLarge(length))?;
    out.write_all(b"glTF")?;
    for word in [2, total, padded as u32] {
        out.write_all(&word.to_le_bytes())?;
    }
    out.write_all(b"JSON")?;
    out.write_all(json)?;
    out.write_all(&b"   "[..padded - json.len()])?;
    if binary > 0 {
        out.write_all(&(binary as u32).to_le_bytes())?;
        out.write_all(b"BIN\0")?;
    }
    Ok(())
}

/// The lists of a document, and the part of its binary chunk that does not depend on frames.
#[derive(Default)]
pub(crate) struct Document {
    pub binary: Vec<u8>,
    /// Bytes of the binary chunk so far, those counted that are written later.
    pub length: u64,
    buffer_views: Vec<Value>,
    pub accessors: Vec<Value>,
    pub meshes: Vec<Value>,
    pub materials: Vec<Value>,
    textures: Vec<Value>,
    images: Vec<Value>,
    samplers: bool,
    pub nodes: Vec<Value>,
    pub animations: Vec<Value>,
    pub extensions: BTreeSet<&'static str>,
    pub required: BTreeSet<&'static str>,
}

impl Document {
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view = json!({
            "buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len(),
        });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.binary.extend(bytes);
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.buffer_views.push(view);
        self.buffer_views.len() - 1
    }

    pub fn accessor<T: bytemuck::NoUninit>(
        &mut self,
        data: &[T],
        target: u32,
        component: u32,
        kind: &str,
    ) -> usize {
        let view = self.view(bytemuck::cast_slice(data), Some(target));
        self.accessors.push(json!({
            "bufferView": view, "componentType": component, "count": data.len(), "type": kind,
        }));
        self.accessors.len() - 1
    }

    /// An accessor of floats that are written later.
    pub fn later(&mut self, count: usize, kind: &str, floats: usize) -> usize {
        let bytes = (count * floats * 4) as u64;
        self.buffer_views
            .push(json!({ "buffer": 0, "byteOffset": self.length, "byteLength": bytes }));
        self.length += bytes;
        self.accessors.push(json!({
            "bufferView": self.buffer_views.len() - 1, "componentType": FLOAT, "count": count, "type": kind,
        }));
        self.accessors.len() - 1
    }

    /// An accessor of indices that are written later.
    pub fn later_indices(&mut self, count: usize) -> usize {
        let accessor = self.later(count, "SCALAR", 1);
        self.accessors[accessor]["componentType"] = json!(UNSIGNED_INT);
        accessor
    }

    /// Says the bounds of an accessor.
    pub fn bound(&mut self, accessor: usize, low: Vec3, high: Vec3) {
        self.accessors[accessor]["min"] = json!(low.to_array());
        self.accessors[accessor]["max"] = json!(high.to_array());
    }

    /// A primitive of a mesh.
    pub fn primitive(&mut self, mesh: &Mesh, material: usize) -> Value {
        let (low, high) = mesh.bounds();
        let positions = self.accessor(&mesh.positions, ARRAY_BUFFER, FLOAT, "VEC3");
        self.bound(positions, low, high);
        let normals: Vec<Vec3> = mesh.normals.iter().map(|n| n.normalize_or(Vec3::Y)).collect();
        let normals = self.accessor(&normals, ARRAY_BUFFER, FLOAT, "VEC3");
        let mut attributes = json!({ "POSITION": positions, "NORMAL": normals });
        if !mesh.uvs.is_empty() {
            let uvs = self.accessor(&mesh.uvs, ARRAY_BUFFER, FLOAT, "VEC2");
            attributes["TEXCOORD_0"] = json!(uvs);
        }
        let indices = self.accessor(&mesh.indices, ELEMENT_ARRAY_BUFFER, UNSIGNED_INT, "SCALAR");
        json!({ "attributes": attributes, "indices": indices, "material": material })
    }

    /// A material; `color` multiplies its own.
    pub fn material(
        &mut self,
        name: &str,
        material: &Material,
        color: Vec3,
        both_sides: bool,
    ) -> Result<usize, ExportError> {
        let color = (plain_color(material) * color).clamp(Vec3::ZERO, Vec3::ONE);
        let mut pbr = json!({
            "metallicFactor": 0,
            "roughnessFactor": material.roughness,
            "baseColorFactor": color.extend(1.0).to_array(),
        });
        if let Some((image, repeat)) = picture(material) {
            let png = encode(material, image)?;
            let view = self.view(&png, None);
            self.textures
                .push(json!({ "source": self.images.len(), "sampler": usize::from(!repeat) }));
            self.images.push(json!({ "mimeType": "image/png", "bufferView": view }));
            self.samplers = true;
            pbr["baseColorTexture"] = json!({ "index": self.textures.len() - 1 });
        }
        let mut entry = json!({ "name": name, "pbrMetallicRoughness": pbr });
        if let Some(cutoff) = material.alpha_cutoff {
            entry["alphaMode"] = json!("MASK");
            entry["alphaCutoff"] = json!(cutoff);
        }
        if both_sides {
            entry["doubleSided"] = json!(true);
        }
        self.materials.push(entry);
        Ok(self.materials.len() - 1)
    }

    /// A material for leaves whose `color` has the material's in it; white where their vertices have it.
    pub fn leaf_material(
        &mut self,
        name: &str,
        material: Option<&Material>,
        color: Vec3,
    ) -> Result<usize, ExportError> {
        let Some(material) = material else {
            self.materials.push(json!({ "name": name, "doubleSided": true }));
            return Ok(self.materials.len() - 1);
        };
        let white = Material { base_color: Vec3::ONE, ..material.clone() };
        self.material(name, &white, color, true)
    }

    pub fn node(&mut self, node: Value) -> usize {
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    pub fn finish(self, roots: &[usize], selection: &Selection<'_>) -> Vec<u8> {
        let moments = selection.moments();
        let mut document = json!({
            "asset": {
                "version": "2.0",
                "generator": "Windfall",
                "extras": { "firstFrame": moments.first, "frames": moments.count, "fps": moments.fps },
            },
            "scene": 0,
            "scenes": [{ "name": "forest" }],
        });
        // The specification wants no empty lists.
        if !roots.is_empty() {
            document["scenes"][0]["nodes"] = json!(roots);
        }
        if self.length > 0 {
            document["buffers"] = json!([{ "byteLength": self.length }]);
        }
        if self.samplers {
            // 10497 repeats, 33071 clamps; textures refer to them by this order.
            document["samplers"] = json!([10497, 33071].map(|wrap| json!({
                "magFilter": 9729, "minFilter": 9987, "wrapS": wrap, "wrapT": wrap,
            })));
        }
        for (key, list) in [
            ("nodes", self.nodes),
            ("meshes", self.meshes),
            ("materials", self.materials),
            ("textures", self.textures),
            ("images", self.images),
            ("accessors", self.accessors),
            ("bufferViews", self.buffer_views),
            ("animations", self.animations),
        ] {
            if !list.is_empty() {
                document[key] = Value::Array(list);
            }
        }
        for (key, names) in
            [("extensionsUsed", &self.extensions), ("extensionsRequired", &self.required)]
        {
            if !names.is_empty() {
                document[key] = json!(names);
            }
        }
        document.to_string().into_bytes()
    }

    /// Says that the binary chunk is as long as it is now.
    pub fn close_binary(&mut self) {
        self.length = self.binary.len() as u64;
    }
}

pub(crate) fn put<const N: usize>(out: &mut dyn Write, values: [f32; N]) -> std::io::Result<()> {
    out.write_all(bytemuck::cast_slice(&values.map(f32::to_le_bytes)))
}
