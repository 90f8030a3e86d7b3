//! glTF 2.0, as one binary file (`.glb`).
//!
//! Leaves of many frames are a node each, with an animation of translation, rotation and scale: for some thousands of
//! leaves. Leaves of one frame are `EXT_mesh_gpu_instancing` nodes, one for each shape, material, model and shade:
//! for any number. Trees have the levels of their wood by `MSFT_lod`. Leaves share the colours of a few shades; instances
//! have their own in an attribute `_COLOR` too.
//!
//! The document goes first, and it says where everything will be; then leaf after leaf is written, and none is kept.

use crate::ExportError;
use crate::frame::{Group, Kind, LeafState, Selection};
use crate::mesh::{Mesh, encode, leaf_material, picture};
use crate::shade::Shades;
use crate::{GROUND_COLOR, plain_color, season_color, short_name};
use glam::{Quat, Vec3};
use serde_json::{Value, json};
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use windfall_core::material::Material;

/// Most leaves of an animation: each is a node with three channels.
pub const MOST_ANIMATED: usize = 20_000;

const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
/// Share of the screen's height below which the first level of a wood gives way to the next; each next one at half.
const FIRST_COVERAGE: f32 = 0.5;

/// Writes the selection: an animation, or where there is one frame, its moment. `progress` is told the share that is
/// done.
///
/// # Errors
///
/// The output cannot be written; more than [`MOST_ANIMATED`] leaves to animate; a file above 4 GiB; a picture whose size
/// is not that of its pixels.
pub fn write_glb(
    selection: &Selection<'_>,
    out: &mut dyn Write,
    progress: &mut dyn FnMut(f32),
) -> Result<(), ExportError> {
    let animated = selection.moments().count > 1;
    if animated && selection.len() > MOST_ANIMATED {
        return Err(ExportError::TooManyLeaves {
            leaves: selection.len(),
            most: MOST_ANIMATED,
            format: "an animation in glTF",
        });
    }
    let mut document = Document::default();
    let mut roots = Vec::new();
    if selection.filter().parts.ground {
        roots.push(document.ground(selection));
    }
    document.trees(selection, &mut roots)?;
    let leaves = document.leaf_meshes(selection)?;
    // What follows the meshes in the binary chunk is computed as it is written.
    let fixed = document.binary.len() as u64;
    document.length = fixed;
    if animated {
        document.animation(selection, &leaves, &mut roots);
    } else {
        document.instances(selection, &leaves, &mut roots);
    }
    let length = document.length;
    let binary = std::mem::take(&mut document.binary);
    let json = document.finish(&roots, selection);
    begin_glb(out, &json, length)?;
    out.write_all(&binary)?;
    if animated {
        write_animation(selection, out, progress)?;
    } else {
        write_instances(selection, &leaves, out, progress)?;
    }
    Ok(())
}

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
    accessors: Vec<Value>,
    pub meshes: Vec<Value>,
    materials: Vec<Value>,
    textures: Vec<Value>,
    images: Vec<Value>,
    samplers: bool,
    pub nodes: Vec<Value>,
    animations: Vec<Value>,
    extensions: BTreeSet<&'static str>,
    required: BTreeSet<&'static str>,
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

    fn accessor<T: bytemuck::NoUninit>(
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
    fn primitive(&mut self, mesh: &Mesh, material: usize) -> Value {
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
    fn material(
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

    fn node(&mut self, node: Value) -> usize {
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    fn ground(&mut self, selection: &Selection<'_>) -> usize {
        self.materials.push(json!({
            "name": "ground",
            "pbrMetallicRoughness": {
                "baseColorFactor": GROUND_COLOR.extend(1.0).to_array(),
                "metallicFactor": 0,
                "roughnessFactor": 1,
            },
        }));
        let material = self.materials.len() - 1;
        let primitive = self.primitive(&Mesh::of_ground(selection.source()), material);
        self.meshes.push(json!({ "name": "ground", "primitives": [primitive] }));
        self.node(json!({ "name": "ground", "mesh": self.meshes.len() - 1 }))
    }

    /// The trees: a node each, with one for every further level of its wood.
    fn trees(
        &mut self,
        selection: &Selection<'_>,
        roots: &mut Vec<usize>,
    ) -> Result<(), ExportError> {
        let source = selection.source();
        // Meshes of the levels of each model, finest first.
        let mut levels: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for number in selection.trees() {
            let instance = &source.forest.instances[number as usize];
            let model = instance.model;
            let meshes = match levels.entry(model) {
                Entry::Occupied(known) => known.get().clone(),
                Entry::Vacant(new) => new.insert(self.wood_levels(selection, model)?).clone(),
            };
            let place = json!({
                "translation": instance.position.to_array(),
                "rotation": instance.rotation().normalize().to_array(),
                "scale": Vec3::splat(instance.scale).to_array(),
            });
            let mut nodes = Vec::new();
            for (level, mesh) in meshes.iter().enumerate() {
                let mut node = place.clone();
                node["mesh"] = json!(mesh);
                node["name"] = json!(match level {
                    0 => format!("tree {number}"),
                    level => format!("tree {number} level {level}"),
                });
                nodes.push(self.node(node));
            }
            let Some((&first, rest)) = nodes.split_first() else { continue };
            if !rest.is_empty() {
                self.extensions.insert("MSFT_lod");
                let coverage = |level: usize| FIRST_COVERAGE * 0.5f32.powi(level as i32);
                let mut coverages: Vec<f32> = (0..rest.len()).map(coverage).collect();
                coverages.push(0.0);
                self.nodes[first]["extensions"] = json!({ "MSFT_lod": { "ids": rest } });
                self.nodes[first]["extras"] = json!({ "MSFT_screencoverage": coverages });
            }
            roots.push(first);
        }
        Ok(())
    }

    fn wood_levels(
        &mut self,
        selection: &Selection<'_>,
        model: u32,
    ) -> Result<Vec<usize>, ExportError> {
        let tree = &selection.source().trees[model as usize];
        let wood = &tree.wood;
        let mut materials = Vec::new();
        for (i, material) in wood.materials.iter().enumerate() {
            let name = format!("{} wood {i}", short_name(&tree.name));
            materials.push(self.material(&name, material, Vec3::ONE, false)?);
        }
        let mut meshes = Vec::new();
        for level in 0..wood.levels.len().max(1) {
            let baked;
            let at_level = if level == 0 {
                wood
            } else {
                baked = wood.baked(level);
                &baked
            };
            let parts = Mesh::of_wood(at_level);
            if parts.is_empty() {
                continue;
            }
            let primitives: Vec<Value> =
                parts.iter().map(|(m, part)| self.primitive(part, materials[*m])).collect();
            let name = format!("{} wood level {level}", short_name(&tree.name));
            self.meshes.push(json!({ "name": name, "primitives": primitives }));
            meshes.push(self.meshes.len() - 1);
        }
        Ok(meshes)
    }

    /// A mesh for each shade of each group, with the geometry of its kind.
    fn leaf_meshes(&mut self, selection: &Selection<'_>) -> Result<Vec<Leaves>, ExportError> {
        let source = selection.source();
        let moments = selection.moments();
        let mut shapes: BTreeMap<Kind, Value> = BTreeMap::new();
        let mut out = Vec::new();
        for group in selection.groups() {
            let Kind { model, shape, material } = group.kind;
            let tree = &source.trees[model as usize];
            let primitive = match shapes.entry(group.kind) {
                Entry::Occupied(known) => known.get().clone(),
                Entry::Vacant(new) => {
                    let mesh = Mesh::of_leaf(&tree.foliage.shapes[shape as usize]);
                    new.insert(self.primitive(&mesh, 0)).clone()
                }
            };
            let shades = Shades::of(selection, group, moments.time(moments.first));
            let mut meshes = Vec::new();
            for (i, color) in shades.colors.iter().enumerate() {
                let short = short_name(&tree.name);
                let name = format!("{short} leaf {shape} {material} shade {i}");
                let material = tree.foliage.materials.get(material as usize);
                let material = match (material, color) {
                    (Some(material), None) => {
                        let color = season_color(&tree.foliage, source.season);
                        let material = leaf_material(&tree.foliage, material, color);
                        self.material(&name, &material, Vec3::ONE, true)?
                    }
                    (material, color) => {
                        self.leaf_material(&name, material, color.unwrap_or(Vec3::ONE))?
                    }
                };
                let mut primitive = primitive.clone();
                primitive["material"] = json!(material);
                self.meshes.push(json!({ "name": name, "primitives": [primitive] }));
                meshes.push(self.meshes.len() - 1);
            }
            out.push(Leaves { shades, meshes });
        }
        Ok(out)
    }

    /// Nodes with instances, one a shade: attributes in the order of [`write_instances`].
    fn instances(&mut self, selection: &Selection<'_>, leaves: &[Leaves], roots: &mut Vec<usize>) {
        for (group, leaves) in selection.groups().iter().zip(leaves) {
            for (shade, mesh) in (0..).zip(&leaves.meshes) {
                let count = shown(selection, group, (&leaves.shades, shade)).count();
                if count == 0 {
                    continue;
                }
                self.extensions.insert("EXT_mesh_gpu_instancing");
                self.required.insert("EXT_mesh_gpu_instancing");
                let attributes = json!({
                    "TRANSLATION": self.later(count, "VEC3", 3),
                    "ROTATION": self.later(count, "VEC4", 4),
                    "SCALE": self.later(count, "VEC3", 3),
                    "_COLOR": self.later(count, "VEC3", 3),
                    "_TREE": self.later(count, "SCALAR", 1),
                    "_LEAF": self.later(count, "SCALAR", 1),
                });
                let name = &self.meshes[*mesh]["name"];
                let node = json!({
                    "name": name,
                    "mesh": mesh,
                    "extensions": { "EXT_mesh_gpu_instancing": { "attributes": attributes } },
                });
                roots.push(self.node(node));
            }
        }
    }

    /// A node a leaf, and their channels in the order of [`write_animation`].
    fn animation(&mut self, selection: &Selection<'_>, leaves: &[Leaves], roots: &mut Vec<usize>) {
        let moments = selection.moments();
        let frames = moments.count as usize;
        let first = moments.time(moments.first);
        let times = self.later(frames, "SCALAR", 1);
        let last = moments.time(moments.frames().end - 1) - first;
        self.accessors[times]["min"] = json!([0.0]);
        self.accessors[times]["max"] = json!([last as f32]);
        let (mut samplers, mut channels) = (Vec::new(), Vec::new());
        for (group, leaves) in selection.groups().iter().zip(leaves) {
            for i in group.leaves.clone() {
                let state = selection.state(i, first);
                let node = self.node(json!({
                    "name": format!("leaf {}", state.id),
                    "mesh": leaves.meshes[leaves.shades.index(&state) as usize],
                    "translation": state.position.to_array(),
                    "rotation": state.orientation.to_array(),
                    "scale": Vec3::splat(state.scale).to_array(),
                    "extras": { "tree": state.id.tree(), "leaf": state.id.leaf() },
                }));
                roots.push(node);
                if !group.moves {
                    continue;
                }
                for (path, kind, floats) in
                    [("translation", "VEC3", 3), ("rotation", "VEC4", 4), ("scale", "VEC3", 3)]
                {
                    let output = self.later(frames, kind, floats);
                    // A leaf that is hidden has the size 0.
                    let way = if path == "scale" { "STEP" } else { "LINEAR" };
                    channels.push(json!({
                        "sampler": samplers.len(), "target": { "node": node, "path": path },
                    }));
                    samplers
                        .push(json!({ "input": times, "output": output, "interpolation": way }));
                }
            }
        }
        if !channels.is_empty() {
            self.animations.push(json!({
                "name": "falling leaves", "channels": channels, "samplers": samplers,
            }));
        }
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

/// Shades of a group of leaves, and their meshes.
struct Leaves {
    shades: Shades,
    meshes: Vec<usize>,
}

/// The leaves of a shade of a group that are shown in the first frame.
fn shown<'a>(
    selection: &'a Selection<'_>,
    group: &Group,
    (shades, shade): (&'a Shades, u32),
) -> impl Iterator<Item = LeafState> + use<'a> {
    let moments = selection.moments();
    let time = moments.time(moments.first);
    group
        .leaves
        .clone()
        .map(move |i| selection.state(i, time))
        .filter(move |s| s.shown && shades.index(s) == shade)
}

pub(crate) fn put<const N: usize>(out: &mut dyn Write, values: [f32; N]) -> std::io::Result<()> {
    out.write_all(bytemuck::cast_slice(&values.map(f32::to_le_bytes)))
}

fn write_instances(
    selection: &Selection<'_>,
    leaves: &[Leaves],
    out: &mut dyn Write,
    progress: &mut dyn FnMut(f32),
) -> Result<(), ExportError> {
    let groups = selection.groups();
    for (i, (group, leaves)) in groups.iter().zip(leaves).enumerate() {
        for shade in 0..leaves.meshes.len() as u32 {
            let all = || shown(selection, group, (&leaves.shades, shade));
            all().try_for_each(|s| put(out, s.position.to_array()))?;
            all().try_for_each(|s| put(out, s.orientation.normalize().to_array()))?;
            all().try_for_each(|s| put(out, [s.scale; 3]))?;
            all().try_for_each(|s| put(out, s.color.to_array()))?;
            all().try_for_each(|s| put(out, [s.id.tree() as f32]))?;
            all().try_for_each(|s| put(out, [s.id.leaf() as f32]))?;
        }
        progress((i + 1) as f32 / groups.len() as f32);
    }
    Ok(())
}

fn write_animation(
    selection: &Selection<'_>,
    out: &mut dyn Write,
    progress: &mut dyn FnMut(f32),
) -> Result<(), ExportError> {
    let moments = selection.moments();
    let first = moments.time(moments.first);
    let times = || moments.frames().map(|frame| moments.time(frame));
    times().try_for_each(|time| put(out, [(time - first) as f32]))?;
    for group in selection.groups().iter().filter(|group| group.moves) {
        for i in group.leaves.clone() {
            let states = || times().map(|time| selection.state(i, time));
            states().try_for_each(|s| put(out, s.position.to_array()))?;
            let mut before = Quat::IDENTITY;
            for state in states() {
                // The nearer of the two quaternions of a rotation: some readers take the longer way else.
                let q = state.orientation.normalize();
                before = if before.dot(q) < 0.0 { -q } else { q };
                put(out, before.to_array())?;
            }
            states().try_for_each(|s| put(out, [if s.shown { s.scale } else { 0.0 }; 3]))?;
            progress((i + 1) as f32 / selection.len() as f32);
        }
    }
    Ok(())
}
