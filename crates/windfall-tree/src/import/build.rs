//! From the primitives of a file to wood, leaves and shapes.

use super::crowns::{self, Crown};
use super::material::Look;
use super::name::composed;
use super::pieces::{Verdict, judge, nodes_are_leaves};
use super::primitive::Geometry;
use super::scene::tree_from_file;
use super::slots::Slots;
use super::sort::{Found, Use};
use super::{FAR, ImportOptions, Reader};
use crate::leaves::{Mesh, Pieces, Shaper};
use crate::prepare::{Stage, Watch};
use glam::{DVec3, Vec3};
use std::collections::HashMap;
use std::fmt::Write;
use std::rc::Rc;
use windfall_core::foliage::Foliage;
use windfall_core::tree::{Tree, Wood, WoodVertex};
use windfall_core::{InputError, NoteCode};

/// A primitive of the file, and what it was taken for.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct Part {
    /// Its number, by which [`ImportOptions::leaves`] and [`ImportOptions::wood`] choose it.
    pub number: usize,
    /// Number of the node that draws it.
    pub node: usize,
    /// Name of the node.
    pub node_name: Option<String>,
    /// Name of the mesh.
    pub mesh_name: Option<String>,
    /// Name of the material.
    pub material_name: Option<String>,
    /// Triangles, over all instances.
    pub triangles: u64,
    /// How often the node draws it.
    pub instances: usize,
    /// Lowest and highest corner in the tree as it was read, metres.
    pub bounds: [Vec3; 2],
    /// What it was taken for.
    pub taken_for: Use,
    /// Why.
    pub why: String,
}

/// A tree before it stands, and its parts.
pub(super) struct Built {
    pub tree: Tree,
    pub parts: Vec<Part>,
    /// Where the tree's origin is in the file, so far.
    pub origin: DVec3,
}

impl<'a> Reader<'a> {
    /// `None` if `watch` stops it.
    pub fn build(
        &mut self,
        found: &mut [Found<'a>],
        options: &ImportOptions,
        watch: &mut Watch<'_>,
    ) -> Result<Option<Built>, InputError> {
        let mut slots = Slots::default();
        let mut read = Vec::with_capacity(found.len());
        let mut colored = Vec::new();
        for part in found.iter().filter(|part| !part.is(Use::LeftOut)) {
            let look = slots.look(self, part.primitive.material, &part.place)?;
            let geometry = self.shared(part, &look, options.vertex_colors)?;
            if geometry.is_colored() {
                colored.push(part.place.clone());
            }
            read.push((part.number, geometry));
        }
        if !colored.is_empty() {
            let message = "colours of vertices multiply those of materials; if they are something else, such as \
                           weights of the wind, --vertex-colors off ignores them";
            self.note(NoteCode::VertexColors, "", message);
        }
        // A place far from the origin is taken off before anything is rounded to floats.
        let transform = |part: &Found<'_>, geometry: &Geometry, i: usize| {
            if geometry.is_skinned() { tree_from_file(options) } else { part.transforms[i] }
        };
        let first = read.first().and_then(|(i, g)| g.first(transform(&found[*i], g, 0)));
        let origin = first.filter(|p| p.is_finite() && p.length() > FAR).unwrap_or(DVec3::ZERO);

        let mut wood: Vec<(usize, Mesh)> = Vec::new();
        let mut leaves: Vec<(usize, Pieces)> = Vec::new();
        let mut parts: Vec<Part> = found.iter().map(part_of).collect();
        let joined = nodes_are_leaves(self, found, &read)?;
        for (number, geometry) in &read {
            let part = &found[*number];
            let stage = if part.is(Use::Leaves) { Stage::Leaves } else { Stage::Parse };
            if watch(stage).is_break() {
                return Ok(None);
            }
            let (mut wooden, mut leafy) = (Mesh::default(), Pieces::default());
            for i in 0..part.transforms.len() {
                let transform = transform(part, geometry, i);
                let mesh = self.placed(geometry, transform, origin, &part.place)?;
                match (part.is(Use::Leaves), joined.contains(number)) {
                    (false, _) => wooden.append(mesh),
                    (true, true) => leafy.append(Pieces::whole(mesh)),
                    (true, false) => leafy.append(Pieces::cut(mesh)),
                }
            }
            if part.is(Use::Leaves) {
                parts[*number].bounds = leafy.mesh.bounds().into();
                leaves.push((*number, leafy));
            } else {
                parts[*number].bounds = wooden.bounds().into();
                wood.push((*number, wooden));
            }
        }
        if watch(Stage::Leaves).is_break() {
            return Ok(None);
        }
        let verdicts = judge(self, found, &leaves, &wood, &slots, options);
        for ((number, pieces), verdicts) in leaves.iter().zip(&verdicts) {
            let mut count = |verdict, what: &str| {
                let count = verdicts.iter().filter(|v| **v == verdict).count();
                if count > 0 {
                    let of = pieces.len();
                    let _ = write!(parts[*number].why, "; {count} of its {of} pieces {what}");
                }
            };
            count(Verdict::Wood, "are wood by their shape");
            count(Verdict::Crown, "are closed solids, strewn with leaves");
        }
        let mut tree = assemble(found, slots, &wood, (&leaves, &verdicts), options);
        tree.name = self.file.to_string();
        Ok(Some(Built { tree, parts, origin }))
    }

    /// The geometry of a primitive, read once for all nodes that have it.
    fn shared(
        &mut self,
        part: &Found<'_>,
        look: &Look,
        vertex_colors: bool,
    ) -> Result<Rc<Geometry>, InputError> {
        for name in part.primitive.attributes.keys() {
            let uvs = format!("TEXCOORD_{}", look.uv_set);
            let skin = part.skin.is_some()
                && (name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_"));
            let read = matches!(name.as_str(), "POSITION" | "NORMAL" | "_LEAF" | "TEXCOORD_0")
                || *name == uvs
                || skin
                || (name == "COLOR_0" && vertex_colors);
            if !read {
                self.unread.attributes.insert(name.clone());
            }
        }
        // Skins and weights of morph targets are the node's.
        if part.skin.is_some() || !part.primitive.targets.is_empty() {
            return Ok(Rc::new(self.geometry(part, look, vertex_colors)?));
        }
        if let Some(known) = self.geometries.get(&part.key) {
            return Ok(known.clone());
        }
        let geometry = Rc::new(self.geometry(part, look, vertex_colors)?);
        self.geometries.insert(part.key, geometry.clone());
        Ok(geometry)
    }
}

fn part_of(found: &Found<'_>) -> Part {
    Part {
        number: found.number,
        node: found.node_index,
        node_name: found.node.map(composed),
        mesh_name: found.mesh.map(composed),
        material_name: found.material.map(composed),
        triangles: found.triangles * found.transforms.len() as u64,
        instances: found.transforms.len(),
        bounds: [Vec3::ZERO; 2],
        taken_for: found.use_as.unwrap_or(Use::LeftOut),
        why: found.why.clone(),
    }
}

fn assemble(
    found: &[Found<'_>],
    mut slots: Slots,
    wood: &[(usize, Mesh)],
    (leaves, verdicts): (&[(usize, Pieces)], &[Vec<Verdict>]),
    options: &ImportOptions,
) -> Tree {
    let material = |number: usize| found[number].primitive.material;
    for (number, mesh) in wood.iter().filter(|(_, mesh)| !mesh.colors.is_empty()) {
        for triangle in mesh.indices.chunks_exact(3) {
            slots.announce((material(*number), false), mesh.mean_color(triangle));
        }
    }
    for ((number, pieces), verdicts) in leaves.iter().zip(verdicts) {
        for (i, verdict) in verdicts.iter().enumerate() {
            if !pieces.mesh.colors.is_empty() {
                let leafy = *verdict == Verdict::Leaf;
                let color = pieces.mesh.mean_color(pieces.corners(i));
                slots.announce((material(*number), leafy), color);
            }
        }
    }

    let mut made = Wood::default();
    for (number, mesh) in wood {
        add_wood(&mut made, mesh, &mesh.indices, |color| {
            slots.slot((material(*number), false), color)
        });
    }
    let mut shaper = Shaper::default();
    let mut crowns = Vec::new();
    for ((number, pieces), verdicts) in leaves.iter().zip(verdicts) {
        let mut scratch = pieces.scratch();
        for (i, verdict) in verdicts.iter().enumerate() {
            let corners = pieces.corners(i);
            match verdict {
                Verdict::Leaf => {
                    let color = pieces.mesh.mean_color(corners);
                    let slot = slots.slot((material(*number), true), color);
                    shaper.add(&pieces.piece(i, &mut scratch), slot);
                }
                Verdict::Wood => add_wood(&mut made, &pieces.mesh, corners, |color| {
                    slots.slot((material(*number), false), color)
                }),
                Verdict::Crown => {
                    let mesh = pieces.piece(i, &mut scratch).mesh;
                    let color = slots.mean_color(material(*number), &mesh);
                    let slot = slots.plain(material(*number), color);
                    crowns.push(Crown { mesh, slot });
                }
            }
        }
    }
    crowns::scatter(&crowns, options.seed, |leaf, slot| shaper.add(&leaf, slot));
    made.materials = slots.wood;
    let positions: Vec<Vec3> = made.vertices.iter().map(|v| v.position).collect();
    let (leaves, shapes) = shaper.finish(&positions);
    let foliage = Foliage::assemble(leaves, shapes, slots.leaves, None, options.seed);
    Tree { name: String::new(), wood: made, foliage }
}

/// Adds triangles of a mesh to the wood, each with the material of its colour.
fn add_wood(wood: &mut Wood, mesh: &Mesh, corners: &[u32], mut slot: impl FnMut(Vec3) -> u32) {
    let mut known: HashMap<(u32, u32), u32> = HashMap::new();
    let plain = mesh.colors.is_empty().then(|| slot(Vec3::ONE));
    for triangle in corners.chunks_exact(3) {
        let material = plain.unwrap_or_else(|| slot(mesh.mean_color(triangle)));
        for &corner in triangle {
            let next = wood.vertices.len() as u32;
            let index = *known.entry((corner, material)).or_insert(next);
            if index == next {
                let i = corner as usize;
                wood.vertices.push(WoodVertex {
                    position: mesh.positions[i],
                    normal: mesh.normals[i],
                    uv: mesh.uvs[i],
                    material,
                });
            }
            wood.indices.push(index);
        }
    }
}
