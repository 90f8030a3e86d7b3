//! Writes a tree as plain glTF 2.0, for any other program.

use glam::{Vec2, Vec3, Vec4};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::Cursor;
use windfall_core::foliage::{Leaf, Palette};
use windfall_core::material::{Image, Material, Surface};
use windfall_core::tree::Tree;

/// Phase of the season at which a palette is exported: well into autumn, before the browns.
const PHASE: f32 = 0.6;
pub(crate) const ARRAY_BUFFER: u32 = 34962;
pub(crate) const ELEMENT_ARRAY_BUFFER: u32 = 34963;
pub(crate) const FLOAT: u32 = 5126;
pub(crate) const UNSIGNED_INT: u32 = 5125;

/// Why a tree could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The file would be larger than the 4 GiB that a GLB may have.
    #[error("the tree takes {0} bytes; a GLB may have 4 GiB")]
    TooLarge(u64),
    /// A picture could not be encoded: its size and its pixels disagree.
    #[error("the picture of material \"{material}\" cannot be encoded: {cause}")]
    Picture {
        /// Name of the material.
        material: String,
        /// What the encoder says.
        cause: image::ImageError,
    },
}

/// Writes a tree as a GLB: a node `wood` and a node `leaves`, their materials named so too, every
/// leaf with its own vertices. A vertex attribute `_LEAF` (four floats) holds the leaf's centre, about
/// which it grows, and its rank in prune order from 0 to 1, over which it fades: by that
/// [`crate::import()`] reads the same leaves back.
///
/// What glTF has no word for is put plainly: bark drawn by the shader becomes the mean of its two
/// colours, and a palette its colour at phase 0.6.
///
/// # Errors
///
/// [`ExportError`]: larger than 4 GiB, or a picture whose size is not that of its pixels.
///
/// # Panics
///
/// If an index of the tree refers to nothing.
pub fn export_glb(tree: &Tree) -> Result<Vec<u8>, ExportError> {
    write(tree, false)
}

/// [`export_glb`] for programs that simplify leaves themselves: they draw a prefix of the indices.
///
/// In each primitive of `leaves` the leaves are in prune order, as many indices each (triangles
/// without area fill up the shorter ones), and its `extras` say
///
/// | field | |
/// |---|---|
/// | `leaves` | their number `N` |
/// | `indicesPerLeaf` | indices of each: the first `round(λ N)` times as many draw a share `λ` |
/// | `visibleShare` | `r` of equation 3 |
/// | `disocclusion` | the factors on its `s`: [`windfall_core::simplify::Visibility::disocclusion`] |
///
/// # Errors
///
/// As [`export_glb`].
///
/// # Panics
///
/// As [`export_glb`].
pub fn export_glb_in_prune_order(tree: &Tree) -> Result<Vec<u8>, ExportError> {
    write(tree, true)
}

fn write(tree: &Tree, in_prune_order: bool) -> Result<Vec<u8>, ExportError> {
    let mut writer = Writer::default();
    let mut nodes = Vec::new();

    let wood = (0..tree.wood.materials.len() as u32).map(|material| {
        let mut part = Part::default();
        let mut new_index = vec![u32::MAX; tree.wood.vertices.len()];
        for triangle in tree.wood.indices.chunks_exact(3) {
            if tree.wood.vertices[triangle[0] as usize].material != material {
                continue;
            }
            for &corner in triangle {
                let slot = &mut new_index[corner as usize];
                if *slot == u32::MAX {
                    let vertex = &tree.wood.vertices[corner as usize];
                    *slot = part.positions.len() as u32;
                    part.push(vertex.position, vertex.normal, vertex.uv);
                }
                part.indices.push(*slot);
            }
        }
        part
    });
    writer.mesh("wood", &mut nodes, wood, &tree.wood.materials, None)?;

    writer.leaves(tree, &mut nodes, in_prune_order)?;
    writer.finish(&tree.name, &nodes, None)
}

/// The vertices of one primitive.
#[derive(Default)]
struct Part {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    indices: Vec<u32>,
    /// Centre and rank of each vertex's leaf; empty for wood.
    leaves: Vec<Vec4>,
    extras: Option<Value>,
}

impl Part {
    fn push(&mut self, position: Vec3, normal: Vec3, uv: Vec2) {
        self.positions.push(position);
        self.normals.push(normal);
        self.uvs.push(uv);
    }
}

/// The lists of a document that grows, and its binary chunk.
#[derive(Default)]
pub(crate) struct Writer {
    binary: Vec<u8>,
    pub buffer_views: Vec<Value>,
    pub accessors: Vec<Value>,
    pub meshes: Vec<Value>,
    materials: Vec<Value>,
    textures: Vec<Value>,
    images: Vec<Value>,
    /// Images by the hash of their pixels: equal ones are written once.
    known_images: BTreeMap<[u8; 32], usize>,
}

impl Writer {
    /// Writes the leaves, each with its own vertices, as a mesh `leaves` with a primitive per material.
    pub fn leaves(
        &mut self,
        tree: &Tree,
        nodes: &mut Vec<Value>,
        in_prune_order: bool,
    ) -> Result<(), ExportError> {
        let foliage = &tree.foliage;
        let leaves = (0..foliage.materials.len() as u32).map(|material| {
            let mut part = Part::default();
            let of_material = || foliage.leaves.iter().filter(|leaf| leaf.material == material);
            let shape = |leaf: &Leaf| &foliage.shapes[leaf.shape as usize];
            let count = of_material().count();
            let most = of_material().map(|leaf| shape(leaf).indices.len()).max().unwrap_or(0);
            for (i, leaf) in of_material().enumerate() {
                let shape = shape(leaf);
                let base = part.positions.len() as u32;
                part.indices.extend(shape.indices.iter().map(|i| base + i));
                for ((&p, &n), &uv) in shape.positions.iter().zip(&shape.normals).zip(&shape.uvs) {
                    let position = leaf.center + leaf.orientation * p * leaf.scale;
                    part.push(position, leaf.orientation * n, uv);
                }
                let rank = i as f32 / count as f32;
                part.leaves.resize(part.positions.len(), leaf.center.extend(rank));
                if in_prune_order {
                    part.indices.resize((i + 1) * most, base);
                }
            }
            if in_prune_order {
                part.extras = Some(json!({
                    "leaves": count,
                    "indicesPerLeaf": most,
                    "visibleShare": foliage.visibility.share,
                    "disocclusion": foliage.visibility.disocclusion,
                }));
            }
            part
        });
        self.mesh("leaves", nodes, leaves, &foliage.materials, foliage.palette.as_ref())
    }

    /// Writes a mesh with a primitive per material that is used, and a node for it.
    fn mesh(
        &mut self,
        name: &str,
        nodes: &mut Vec<Value>,
        parts: impl Iterator<Item = Part>,
        materials: &[Material],
        palette: Option<&Palette>,
    ) -> Result<(), ExportError> {
        let mut primitives = Vec::new();
        for (material, part) in materials.iter().zip(parts) {
            if part.indices.is_empty() {
                continue;
            }
            let number = primitives.len() + 1;
            let label = if number == 1 { name.to_string() } else { format!("{name} {number}") };
            let material = self.material(&label, material, palette)?;
            let (low, high) = part
                .positions
                .iter()
                .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
            let count = part.positions.len();
            let positions = self.accessor(&part.positions, ARRAY_BUFFER, FLOAT, "VEC3", count);
            self.accessors[positions]["min"] = json!(low.to_array());
            self.accessors[positions]["max"] = json!(high.to_array());
            let normals = self.accessor(&part.normals, ARRAY_BUFFER, FLOAT, "VEC3", count);
            let uvs = self.accessor(&part.uvs, ARRAY_BUFFER, FLOAT, "VEC2", count);
            let indices = self.accessor(
                &part.indices,
                ELEMENT_ARRAY_BUFFER,
                UNSIGNED_INT,
                "SCALAR",
                part.indices.len(),
            );
            let mut primitive = json!({
                "attributes": { "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs },
                "indices": indices,
                "material": material,
            });
            if !part.leaves.is_empty() {
                let leaves = self.accessor(&part.leaves, ARRAY_BUFFER, FLOAT, "VEC4", count);
                primitive["attributes"]["_LEAF"] = json!(leaves);
            }
            if let Some(extras) = part.extras {
                primitive["extras"] = extras;
            }
            primitives.push(primitive);
        }
        if !primitives.is_empty() {
            nodes.push(json!({ "name": name, "mesh": self.meshes.len() }));
            self.meshes.push(json!({ "name": name, "primitives": primitives }));
        }
        Ok(())
    }

    pub fn material(
        &mut self,
        name: &str,
        material: &Material,
        palette: Option<&Palette>,
    ) -> Result<usize, ExportError> {
        let mut color = material.base_color;
        if let Some(palette) = palette {
            color *= palette.color(PHASE);
        }
        let mut pbr = json!({ "metallicFactor": 0, "roughnessFactor": material.roughness });
        match &material.surface {
            Surface::Plain => {}
            Surface::Bark(bark) => color *= (bark.ridge + bark.groove) / 2.0,
            Surface::Texture(image, repeat) => {
                let source = self.image(image, &material.name)?;
                self.textures.push(json!({ "source": source, "sampler": usize::from(!repeat) }));
                pbr["baseColorTexture"] = json!({ "index": self.textures.len() - 1 });
            }
        }
        pbr["baseColorFactor"] = json!(color.clamp(Vec3::ZERO, Vec3::ONE).extend(1.0).to_array());
        let mut entry = json!({ "name": name, "pbrMetallicRoughness": pbr });
        if let Some(cutoff) = material.alpha_cutoff {
            entry["alphaMode"] = json!("MASK");
            entry["alphaCutoff"] = json!(cutoff);
        }
        if name.starts_with("leaves") {
            entry["doubleSided"] = json!(true);
        }
        self.materials.push(entry);
        Ok(self.materials.len() - 1)
    }

    /// Writes an image as PNG, unless it is there already; its index. `material` is what errors name.
    pub fn image(&mut self, image: &Image, material: &str) -> Result<usize, ExportError> {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&image.width.to_le_bytes()).update(&image.height.to_le_bytes());
        let hash = *hasher.update(&image.rgba).finalize().as_bytes();
        if let Some(&known) = self.known_images.get(&hash) {
            return Ok(known);
        }
        let failed = |cause| ExportError::Picture { material: material.to_owned(), cause };
        let png = png(image).map_err(failed)?;
        let view = self.view(&png, None);
        self.images.push(json!({ "mimeType": "image/png", "bufferView": view }));
        self.known_images.insert(hash, self.images.len() - 1);
        Ok(self.images.len() - 1)
    }

    fn accessor<T: bytemuck::NoUninit>(
        &mut self,
        data: &[T],
        target: u32,
        component: u32,
        kind: &str,
        count: usize,
    ) -> usize {
        let view = self.view(bytemuck::cast_slice(data), Some(target));
        self.accessors.push(json!({
            "bufferView": view, "componentType": component, "count": count, "type": kind,
        }));
        self.accessors.len() - 1
    }

    pub fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
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

    /// Takes room for so many bytes at once: growing would copy what is there, again and again.
    pub fn reserve(&mut self, bytes: usize) {
        self.binary.reserve(bytes);
    }

    /// The file, with an extension of its root if there is one: name and content.
    pub fn finish(
        self,
        name: &str,
        nodes: &[Value],
        extension: Option<(&str, Value)>,
    ) -> Result<Vec<u8>, ExportError> {
        let mut all = nodes.to_vec();
        let children: Vec<usize> = (0..nodes.len()).collect();
        let mut root = json!({ "name": name });
        let mut document = json!({
            "asset": { "version": "2.0", "generator": "Windfall" },
            "scene": 0,
            "scenes": [{ "nodes": [nodes.len()] }],
        });
        // The specification wants no empty lists.
        if !children.is_empty() {
            root["children"] = json!(children);
        }
        all.push(root);
        if let Some((name, content)) = extension {
            document["extensionsUsed"] = json!([name]);
            document["extensions"] = json!({ name: content });
        }
        if !self.binary.is_empty() {
            document["buffers"] = json!([{ "byteLength": self.binary.len() }]);
        }
        if !self.textures.is_empty() {
            // 10497 repeats, 33071 clamps; textures refer to them by this order.
            document["samplers"] = json!([10497, 33071].map(|wrap| json!({
                "magFilter": 9729, "minFilter": 9987, "wrapS": wrap, "wrapT": wrap,
            })));
        }
        for (key, list) in [
            ("nodes", all),
            ("meshes", self.meshes),
            ("materials", self.materials),
            ("textures", self.textures),
            ("images", self.images),
            ("accessors", self.accessors),
            ("bufferViews", self.buffer_views),
        ] {
            if !list.is_empty() {
                document[key] = Value::Array(list);
            }
        }
        glb(document.to_string().into_bytes(), &self.binary)
    }
}

fn png(image: &Image) -> Result<Vec<u8>, image::ImageError> {
    let mut bytes = Cursor::new(Vec::new());
    image::write_buffer_with_format(
        &mut bytes,
        &image.rgba,
        image.width,
        image.height,
        image::ExtendedColorType::Rgba8,
        image::ImageFormat::Png,
    )?;
    Ok(bytes.into_inner())
}

/// Puts a document and its binary chunk (a multiple of 4 bytes) into a GLB.
fn glb(mut json: Vec<u8>, binary: &[u8]) -> Result<Vec<u8>, ExportError> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let chunks: &[(&[u8; 4], &[u8])] = if binary.is_empty() {
        &[(b"JSON", &json)]
    } else {
        &[(b"JSON", &json), (b"BIN\0", binary)]
    };
    let length = 12 + chunks.iter().map(|(_, data)| 8 + data.len() as u64).sum::<u64>();
    let total = u32::try_from(length).map_err(|_| ExportError::TooLarge(length))?;
    let mut bytes = Vec::with_capacity(length as usize);
    bytes.extend(b"glTF");
    bytes.extend(2u32.to_le_bytes());
    bytes.extend(total.to_le_bytes());
    for (kind, data) in chunks {
        bytes.extend((data.len() as u32).to_le_bytes());
        bytes.extend(*kind);
        bytes.extend(*data);
    }
    Ok(bytes)
}
