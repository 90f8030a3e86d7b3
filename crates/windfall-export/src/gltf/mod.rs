//! glTF 2.0, as one binary file (`.glb`).
//!
//! Leaves of many frames are a node each, with an animation of translation, rotation and scale: for some thousands of
//! leaves. Leaves of one frame are `EXT_mesh_gpu_instancing` nodes, one for each shape, material, model and shade:
//! for any number. Trees have the levels of their wood by `MSFT_lod`. Leaves share the colours of a few shades; instances
//! have their own in an attribute `_COLOR` too.
//!
//! The document goes first, and it says where everything will be; then leaf after leaf is written, and none is kept.

mod document;

pub(crate) use document::{Document, begin_glb, put};

use crate::ExportError;
use crate::frame::{Kind, LeafState};
use crate::mesh::{Mesh, leaf_material};
use crate::selection::{Group, Selection};
use crate::shade::Shades;
use crate::{GROUND_COLOR, season_color, short_name};
use glam::{Quat, Vec3};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::io::Write;

/// Most leaves of an animation: each is a node with three channels.
pub const MOST_ANIMATED: usize = 20_000;

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

impl Document {
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
