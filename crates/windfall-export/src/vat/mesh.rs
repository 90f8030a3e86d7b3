//! The mesh of all leaves, each about its own centre.

use super::Vat;
use crate::frame::{Kind, LeafState};
use crate::gltf::{Document, begin_glb, put};
use crate::mesh::{leaf_material, shape_of};
use crate::selection::Selection;
use crate::{ExportError, short_name};
use glam::{Vec2, Vec3};
use serde_json::json;
use std::io::Write;
use std::ops::Range;

/// The leaves of each kind: those of a kind follow each other.
pub fn kinds(selection: &Selection<'_>) -> Vec<(Kind, Range<usize>)> {
    let chunks = selection.groups().chunk_by(|a, b| a.kind == b.kind);
    chunks.map(|of| (of[0].kind, of[0].leaves.start..of[of.len() - 1].leaves.end)).collect()
}

/// Where a leaf's first texel is, as a share of the texture's width and height.
type Address<'a> = &'a dyn Fn(usize) -> Vec2;

impl Vat<'_> {
    /// Writes the mesh as a GLB, in glTF's axes and metres: importers turn it as the textures are turned. A primitive a
    /// kind of leaf, with linear vertex colours.
    ///
    /// # Errors
    ///
    /// The output cannot be written; a file above 4 GiB; a picture whose size is not that of its pixels.
    pub fn write_mesh(
        &self,
        out: &mut dyn Write,
        progress: &mut dyn FnMut(f32),
    ) -> Result<(), ExportError> {
        write(self.selection, &|i| self.address(i), out, progress)
    }

    /// Share of the texture's width and height at which leaf `i` has its texel of frame 0, at its middle.
    pub fn address(&self, i: usize) -> Vec2 {
        let (width, height) = self.size();
        let (column, row) = (i % self.columns, i / self.columns * self.frames());
        Vec2::new((column as f32 + 0.5) / width as f32, (row as f32 + 0.5) / height as f32)
    }
}

/// Writes the mesh of a selection.
pub fn write(
    selection: &Selection<'_>,
    address: Address<'_>,
    out: &mut dyn Write,
    progress: &mut dyn FnMut(f32),
) -> Result<(), ExportError> {
    let source = selection.source();
    let kinds = kinds(selection);
    let mut document = Document::default();
    let mut materials = Vec::new();
    for (kind, _) in &kinds {
        let tree = &source.trees[kind.model as usize];
        let name = format!("{} leaf {} {}", short_name(&tree.name), kind.shape, kind.material);
        // Colours of leaves have the material's in them; of a picture they take light and dark.
        let material = tree.foliage.materials.get(kind.material as usize);
        let material = material.map(|m| leaf_material(&tree.foliage, m, Vec3::ONE));
        materials.push(document.leaf_material(&name, material.as_ref(), Vec3::ONE)?);
    }
    document.close_binary();
    let mut primitives = Vec::new();
    for ((kind, leaves), material) in kinds.iter().zip(materials) {
        let shape = shape_of(source, *kind);
        let vertices = shape.positions.len() * leaves.len();
        let (low, high) = local_bounds(selection, *kind, leaves);
        let positions = document.later(vertices, "VEC3", 3);
        document.bound(positions, low, high);
        let attributes = json!({
            "POSITION": positions,
            "NORMAL": document.later(vertices, "VEC3", 3),
            "TEXCOORD_0": document.later(vertices, "VEC2", 2),
            "TEXCOORD_1": document.later(vertices, "VEC2", 2),
            "COLOR_0": document.later(vertices, "VEC3", 3),
        });
        let indices = document.later_indices(shape.indices.len() * leaves.len());
        primitives
            .push(json!({ "attributes": attributes, "indices": indices, "material": material }));
    }
    document.meshes.push(json!({ "name": "leaves", "primitives": primitives }));
    document.nodes.push(json!({ "name": "leaves", "mesh": 0 }));
    let length = document.length;
    let binary = std::mem::take(&mut document.binary);
    begin_glb(out, &document.finish(&[0], selection), length)?;
    out.write_all(&binary)?;
    for (kind, leaves) in &kinds {
        write_kind(selection, (*kind, leaves), address, out)?;
        progress(leaves.end as f32 / selection.len() as f32);
    }
    Ok(())
}

/// A leaf in the first frame.
fn first(selection: &Selection<'_>, i: usize) -> LeafState {
    let moments = selection.moments();
    selection.state(i, moments.time(moments.first))
}

fn local_bounds(selection: &Selection<'_>, kind: Kind, leaves: &Range<usize>) -> (Vec3, Vec3) {
    let shape = shape_of(selection.source(), kind);
    let none = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (low, high) =
        shape.positions.iter().fold(none, |(low, high), &p| (low.min(p), high.max(p)));
    // Products of floats keep their order: these are the very numbers that are written.
    leaves.clone().fold(none, |(l, h), i| {
        let scale = first(selection, i).scale;
        (l.min(low * scale), h.max(high * scale))
    })
}

fn write_kind(
    selection: &Selection<'_>,
    (kind, leaves): (Kind, &Range<usize>),
    address: Address<'_>,
    out: &mut dyn Write,
) -> Result<(), ExportError> {
    let shape = shape_of(selection.source(), kind);
    let corners = shape.positions.len();
    for i in leaves.clone() {
        let scale = first(selection, i).scale;
        shape.positions.iter().try_for_each(|p| put(out, (*p * scale).to_array()))?;
    }
    for _ in leaves.clone() {
        let normals = shape.normals.iter().map(|n| n.normalize_or(Vec3::Y));
        normals.clone().try_for_each(|n| put(out, n.to_array()))?;
    }
    for _ in leaves.clone() {
        shape.uvs.iter().try_for_each(|uv| put(out, uv.to_array()))?;
    }
    for i in leaves.clone() {
        let address = address(i).to_array();
        (0..corners).try_for_each(|_| put(out, address))?;
    }
    for i in leaves.clone() {
        let color = first(selection, i).color.clamp(Vec3::ZERO, Vec3::ONE).to_array();
        (0..corners).try_for_each(|_| put(out, color))?;
    }
    for number in 0..leaves.len() {
        let first = (number * corners) as u32;
        for index in &shape.indices {
            out.write_all(&(first + index).to_le_bytes())?;
        }
    }
    Ok(())
}
