//! What looks wrong about a tree that was read, and what of its file was not used.

use super::container::{is_read, way_out};
use super::name::listed;
use super::sort::{Found, Use};
use super::{Part, Reader};
use glam::Vec3;
use std::collections::{BTreeMap, BTreeSet};
use windfall_core::NoteCode;
use windfall_core::tree::Tree;

/// Heights that trees and bushes have, metres.
const HEIGHTS: std::ops::RangeInclusive<f32> = 0.5..=120.0;
/// Width over height above which a tree may lie on its side.
const WIDE: f32 = 1.25;

impl Reader<'_> {
    /// Notes what the file has that was not used.
    pub fn note_unread(&mut self, found: &[Found<'_>]) {
        let document = self.document;
        let skins = found
            .iter()
            .filter(|f| f.skin.is_some() && !f.primitive.attributes.contains_key("JOINTS_0"));
        let skins: Vec<String> = skins.map(|f| f.place.clone()).collect();
        for name in document.extensions_used.iter().filter(|name| !is_read(name)) {
            let message = format!(
                "{name} is not read; the tree is what the file is without it{}",
                way_out(name)
            );
            self.note(NoteCode::ExtensionLeftOut, "extensionsUsed", message);
        }
        if !skins.is_empty() {
            let message = format!("no vertex names a joint of the skin: {}", listed(&skins));
            self.note(NoteCode::AttributeLeftOut, "", message);
        }
        let unread = std::mem::take(&mut self.unread);
        if !unread.attributes.is_empty() {
            let names: Vec<String> = unread.attributes.into_iter().collect();
            let message = format!("attributes of vertices that are not used: {}", listed(&names));
            self.note(NoteCode::AttributeLeftOut, "", message);
        }
        if !unread.textures.is_empty() {
            let names: Vec<String> = unread
                .textures
                .into_iter()
                .map(|(material, list)| format!("{material}: {list}"))
                .collect();
            let message =
                format!("only pictures of the base colour are used, not {}", listed(&names));
            self.note(NoteCode::TextureLeftOut, "", message);
        }
        if !unread.primitives.is_empty() {
            let message = format!("points, lines or nothing: {}", listed(&unread.primitives));
            self.note(NoteCode::PrimitiveLeftOut, "", message);
        }
        let animations = document.animations.len();
        if animations > 0 {
            let message = format!(
                "{animations} animations are not played: the tree stands as its nodes and joints do"
            );
            self.note(NoteCode::AnimationLeftOut, "", message);
        }
    }

    /// Notes what a tree seldom is.
    pub fn note_implausible(&mut self, tree: &Tree, parts: &[Part]) {
        let (low, high) = tree.bounds();
        let size = high - low;
        let wide = size.x.max(size.z);
        let leaves = &tree.foliage.leaves;
        if leaves.len() == 1 {
            let message = "there is one leaf: perhaps instances were not realised at export (Blender: Realize Instances, \
                           or Make Instances Real)";
            self.note(NoteCode::OneLeaf, "", message);
        }
        if tree.wood.indices.is_empty() {
            let message = "no wood is left: everything falls; --leaves or --wood says which primitives are which";
            self.note(NoteCode::NoWood, "", message);
        }
        let longest = leaves
            .iter()
            .map(|leaf| 2.0 * leaf.scale * tree.foliage.shapes[leaf.shape as usize].radius())
            .fold(0.0, f32::max);
        if longest > 0.5 * size.y && leaves.len() > 1 {
            let message = format!(
                "a leaf is {longest:.2} m long, the tree {:.2} m high: perhaps it is a part of the wood; `windfall tree \
                 inspect` lists the primitives",
                size.y
            );
            self.note(NoteCode::TallLeaf, "", message);
        }
        if !HEIGHTS.contains(&size.y) {
            let message = format!(
                "is {:.2} m high; --unit says what a unit of the file is (0.01 for centimetres), --height M rescales \
                 the tree",
                size.y
            );
            self.note(NoteCode::HeightUnusual, "", message);
        }
        let several = self.several_trees(parts, low.y + 0.1 * size.y);
        if wide > WIDE * size.y {
            let message = format!(
                "is {wide:.2} m wide and {:.2} m high: perhaps it lies on its side (--up z) or is more than one tree \
                 (--node NAME)",
                size.y
            );
            self.note(NoteCode::WiderThanTall, "", message);
        }
        if several.len() > 1 {
            let message = format!(
                "{} nodes have wood and leaves of their own: {}; --node NAME reads one of them",
                several.len(),
                listed(&several)
            );
            self.note(NoteCode::SeveralTrees, "", message);
        }
        let ground: Vec<String> =
            parts.iter().filter(|p| is_ground(p, low, size)).map(name).collect();
        if !ground.is_empty() {
            let message = format!(
                "looks like ground, and was taken for wood: {}; --node, or --leaves and --wood, leave it out",
                listed(&ground)
            );
            self.note(NoteCode::GroundPlane, "", message);
        }
    }

    /// The lowest nodes that have both wood, down to below `foot`, and leaves.
    fn several_trees(&self, parts: &[Part], foot: f32) -> Vec<String> {
        let mut has: BTreeMap<usize, (bool, bool)> = BTreeMap::new();
        for part in parts {
            let mut node = Some(part.node);
            let mut steps = 0;
            while let Some(index) = node.filter(|_| steps <= self.document.nodes.len()) {
                let entry = has.entry(index).or_default();
                entry.0 |= part.taken_for == Use::Leaves;
                entry.1 |= part.taken_for == Use::Wood && part.bounds[0].y < foot;
                node = self.parents.get(&index).copied();
                steps += 1;
            }
        }
        let trees: BTreeSet<usize> =
            has.iter().filter(|(_, both)| **both == (true, true)).map(|(i, _)| *i).collect();
        let lowest = trees.iter().filter(|&&tree| {
            self.document.nodes[tree].children.iter().all(|child| !trees.contains(child))
        });
        lowest
            .map(|&index| super::label("node", index, self.document.nodes[index].name.as_deref()))
            .collect()
    }
}

/// Whether a part is flat, wide, and at the foot of the tree.
fn is_ground(part: &Part, low: Vec3, size: Vec3) -> bool {
    let [from, to] = part.bounds;
    let own = to - from;
    let wide = own.x.min(own.z);
    part.taken_for == Use::Wood
        && wide > 0.3 * size.x.min(size.z)
        && own.y < 0.03 * wide
        && from.y < low.y + 0.05 * size.y
}

fn name(part: &Part) -> String {
    super::label("primitive", part.number, part.node_name.as_deref().or(part.mesh_name.as_deref()))
}
