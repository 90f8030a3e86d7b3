//! The nodes of a document: what is drawn, where, and which of it is asked for.

use super::document::{Instancing, Node};
use super::name::{key, label, level, listed, quoted};
use super::sort::Found;
use super::{ImportOptions, MOST_PRIMITIVES, MOST_TRIANGLES, Reader, Up, primitive};
use glam::{DMat4, DQuat, DVec3};
use std::collections::{BTreeMap, BTreeSet};
use windfall_core::InputErrorKind::{Empty, Malformed, Missing, OutOfRange};
use windfall_core::{InputError, NoteCode};

/// A node on its way to be drawn: its index, the transform of its parent, and who names it.
type Step = (usize, DMat4, String);

impl<'a> Reader<'a> {
    /// Every primitive that draws triangles, with the transforms of each node that has it.
    pub fn find(&mut self, options: &ImportOptions) -> Result<Vec<Found<'a>>, InputError> {
        let document = self.document;
        let mut found = Vec::new();
        let (mut triangles, mut draws) = (0u64, 0usize);
        // A stack of its own: a document may nest deeper than the thread's.
        let mut stack = self.starts(options)?;
        stack.reverse();
        let lower: BTreeSet<usize> = document
            .nodes
            .iter()
            .filter_map(|node| node.extensions.levels.as_ref())
            .flat_map(|levels| levels.ids.iter().copied())
            .collect();
        let mut seen = vec![false; document.nodes.len()];
        let mut left_out = Vec::new();
        let chosen = !options.node.is_empty();
        let tops: Vec<usize> = stack.iter().map(|step| step.0).collect();
        let mut skipped = if chosen { BTreeSet::new() } else { self.lower_levels(&tops) };
        while let Some((index, world_from_parent, at)) = stack.pop() {
            let Some(node) = document.nodes.get(index) else {
                let cause = format!("names node {index}, but there are {}", document.nodes.len());
                return Err(self.error(&at, OutOfRange, cause));
            };
            let here = label("node", index, node.name.as_deref());
            if std::mem::replace(&mut seen[index], true) {
                // One node that is asked for may be a part of another.
                if chosen && at.is_empty() {
                    continue;
                }
                let cause = "is reached twice: nodes must form a tree, without cycles";
                return Err(self.error(&here, Malformed, cause));
            }
            let asked_for = chosen && at.is_empty();
            if !asked_for && (skipped.contains(&index) || lower.contains(&index)) {
                left_out.push(here);
                continue;
            }
            let world_from_node = world_from_parent * local(node);
            skipped.extend(self.lower_levels(&node.children));
            for &child in node.children.iter().rev() {
                stack.push((child, world_from_node, here.clone()));
            }
            let Some(mesh_index) = node.mesh else { continue };
            let Some(mesh) = document.meshes.get(mesh_index) else {
                let cause =
                    format!("names mesh {mesh_index}, but there are {}", document.meshes.len());
                return Err(self.error(&here, OutOfRange, cause));
            };
            let transforms = match &node.extensions.instancing {
                None => vec![world_from_node],
                Some(instancing) => self
                    .instances(instancing, &here)?
                    .into_iter()
                    .map(|node_from_instance| world_from_node * node_from_instance)
                    .collect(),
            };
            for (i, primitive) in mesh.primitives.iter().enumerate() {
                let place = primitive::place(mesh_index, mesh.name.as_deref(), i);
                let count = self.triangle_count(primitive, &place)?;
                let all = count.saturating_mul(transforms.len() as u64);
                triangles += all;
                if triangles > MOST_TRIANGLES {
                    let cause = format!(
                        "with its {all} triangles the file has more than {MOST_TRIANGLES}: \
                         too many for one tree"
                    );
                    return Err(self.error(&place, OutOfRange, cause));
                }
                draws += transforms.len();
                if draws > MOST_PRIMITIVES {
                    let cause = format!("the scene draws more than {MOST_PRIMITIVES} primitives");
                    return Err(self.error(&here, OutOfRange, cause));
                }
                if count == 0 {
                    self.unread.primitives.push(place);
                    continue;
                }
                let material = primitive.material.and_then(|m| document.materials.get(m));
                found.push(Found {
                    number: found.len(),
                    place,
                    node: node.name.as_deref(),
                    node_index: index,
                    mesh: mesh.name.as_deref(),
                    material: material.and_then(|m| m.name.as_deref()),
                    masked: material
                        .is_some_and(|m| matches!(m.alpha_mode.as_deref(), Some("MASK" | "BLEND"))),
                    triangles: count,
                    primitive,
                    key: (mesh_index, i),
                    transforms: transforms.clone(),
                    skin: node.skin,
                    weights: node.weights.as_deref().or(mesh.weights.as_deref()).unwrap_or(&[]),
                    use_as: None,
                    why: String::new(),
                });
            }
        }
        if !left_out.is_empty() {
            let message = format!(
                "levels of detail: the finest is read, left out are {}; --node NAME reads another",
                listed(&left_out)
            );
            self.note(NoteCode::LevelsLeftOut, "", message);
        }
        if found.is_empty() {
            let cause = "there are no triangles in its scene";
            return Err(self.error("", Empty, cause));
        }
        Ok(found)
    }

    /// Where to begin: at the nodes that are asked for, or at the top of the scene.
    fn starts(&self, options: &ImportOptions) -> Result<Vec<Step>, InputError> {
        let tree_from_world = tree_from_file(options);
        if options.node.is_empty() {
            let roots = self.roots()?.into_iter();
            return Ok(roots.map(|(root, at)| (root, tree_from_world, at)).collect());
        }
        let nodes = &self.document.nodes;
        let mut starts = Vec::new();
        for asked in &options.node {
            let asked_key = key(asked);
            let is = |name: &Option<String>| name.as_ref().is_some_and(|n| key(n) == asked_key);
            let mut chosen: Vec<usize> = (0..nodes.len()).filter(|&i| is(&nodes[i].name)).collect();
            if chosen.is_empty() {
                chosen.extend(asked.parse().ok().filter(|&i: &usize| i < nodes.len()));
            }
            if chosen.is_empty() {
                let names: Vec<String> = (nodes.iter().enumerate())
                    .filter(|(_, node)| node.mesh.is_some() || !node.children.is_empty())
                    .map(|(i, node)| label("node", i, node.name.as_deref()))
                    .collect();
                let cause = format!(
                    "no node is named {} or has that number; there are {}",
                    quoted(asked),
                    listed(&names)
                );
                return Err(self.error("", Missing, cause));
            }
            for index in chosen {
                let parent = self.parents.get(&index).copied();
                let world_from_parent =
                    parent.map_or(Ok(DMat4::IDENTITY), |parent| self.world_from(parent))?;
                starts.push((index, tree_from_world * world_from_parent, String::new()));
            }
        }
        Ok(starts)
    }

    /// The nodes at the top, and who names them: those of the default scene, else of the first,
    /// else all that are no one's children.
    fn roots(&self) -> Result<Vec<(usize, String)>, InputError> {
        let document = self.document;
        let index = document.scene.unwrap_or(0);
        if let Some(scene) = document.scenes.get(index) {
            let at = label("scene", index, scene.name.as_deref());
            return Ok(scene.nodes.iter().map(|&node| (node, at.clone())).collect());
        }
        if document.scene.is_some() {
            let cause = format!("names scene {index}, but there are {}", document.scenes.len());
            return Err(self.error("scene", OutOfRange, cause));
        }
        let roots = (0..document.nodes.len()).filter(|i| !self.parents.contains_key(i));
        Ok(roots.map(|root| (root, "nodes".to_string())).collect())
    }

    /// The transform of a node of the file, of all its parents too.
    pub fn world_from(&self, node: usize) -> Result<DMat4, InputError> {
        let nodes = &self.document.nodes;
        let (mut index, mut transform) = (node, DMat4::IDENTITY);
        for _ in 0..=nodes.len() {
            let Some(node) = nodes.get(index) else {
                let cause = format!("names node {index}, but there are {}", nodes.len());
                return Err(self.error("nodes", OutOfRange, cause));
            };
            transform = local(node) * transform;
            match self.parents.get(&index) {
                Some(&parent) => index = parent,
                None => return Ok(transform),
            }
        }
        let here = label("node", node, nodes[node].name.as_deref());
        Err(self.error(&here, Malformed, "is its own ancestor: nodes must form a tree"))
    }

    /// Those of some siblings that are the lower levels of detail of others, by their names:
    /// `Tree_LOD1` beside `Tree_LOD0` or beside `Tree`.
    fn lower_levels(&self, siblings: &[usize]) -> BTreeSet<usize> {
        let nodes = &self.document.nodes;
        let name = |index: usize| {
            let node = nodes.get(index)?;
            let mesh = || self.document.meshes.get(node.mesh?)?.name.as_deref();
            node.name.as_deref().or_else(mesh)
        };
        let mut levels: BTreeMap<String, Vec<(u32, usize)>> = BTreeMap::new();
        for &index in siblings {
            if let Some((base, level)) = name(index).and_then(level) {
                levels.entry(base).or_default().push((level, index));
            }
        }
        let mut lower = BTreeSet::new();
        for (base, mut levels) in levels {
            // A plain name is above all levels.
            let plain = siblings.iter().any(|&i| name(i).is_some_and(|n| key(n) == base));
            levels.sort_unstable();
            let best = if plain { None } else { levels.first().map(|first| first.0) };
            lower.extend(levels.iter().filter(|l| Some(l.0) != best).map(|l| l.1));
        }
        lower
    }

    /// The transforms of `EXT_mesh_gpu_instancing`.
    fn instances(&mut self, of: &Instancing, node: &str) -> Result<Vec<DMat4>, InputError> {
        let here = format!("{node}, EXT_mesh_gpu_instancing");
        let attribute = |name: &str| of.attributes.get(name).copied();
        let [moves, turns, sizes] = ["TRANSLATION", "ROTATION", "SCALE"].map(attribute);
        let mut counts = Vec::new();
        for accessor in [moves, turns, sizes].into_iter().flatten() {
            counts.push(self.count(accessor, &here)?);
        }
        let Some(&count) = counts.first() else { return Ok(vec![DMat4::IDENTITY]) };
        if counts.iter().any(|&other| other != count) {
            let cause = format!("its attributes have {counts:?} elements: as many each are needed");
            return Err(self.error(&here, Malformed, cause));
        }
        if count > MOST_PRIMITIVES as u64 {
            let cause = format!("{count} instances are more than {MOST_PRIMITIVES}");
            return Err(self.error(&here, OutOfRange, cause));
        }
        let count = count as usize;
        let vectors = |reader: &mut Self, accessor: Option<usize>, fill: f32| match accessor {
            Some(accessor) => reader.vectors::<3>(accessor, &here),
            None => Ok(vec![[fill; 3]; count]),
        };
        let moves = vectors(self, moves, 0.0)?;
        let sizes = vectors(self, sizes, 1.0)?;
        let turns = match turns {
            Some(accessor) => self.vectors::<4>(accessor, &here)?,
            None => vec![[0.0, 0.0, 0.0, 1.0]; count],
        };
        let transform = |((by, turn), size): (([f32; 3], [f32; 4]), [f32; 3])| {
            DMat4::from_scale_rotation_translation(
                size.map(f64::from).into(),
                rotation(turn.map(f64::from)),
                by.map(f64::from).into(),
            )
        };
        Ok(moves.into_iter().zip(turns).zip(sizes).map(transform).collect())
    }
}

/// From the axes and the unit of the file to metres, Y up.
pub(super) fn tree_from_file(options: &ImportOptions) -> DMat4 {
    let turn = match options.up {
        Up::Y => DQuat::IDENTITY,
        Up::Z => DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2),
    };
    let size = DVec3::splat(f64::from(options.unit.unwrap_or(1.0)));
    DMat4::from_scale_rotation_translation(size, turn, DVec3::ZERO)
}

fn local(node: &Node) -> DMat4 {
    if let Some(matrix) = &node.matrix {
        return DMat4::from_cols_array(matrix);
    }
    DMat4::from_scale_rotation_translation(
        node.scale.unwrap_or([1.0; 3]).into(),
        rotation(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0])),
        node.translation.unwrap_or([0.0; 3]).into(),
    )
}

/// Forgiving: writers round quaternions; one of no length at all is no rotation.
fn rotation(xyzw: [f64; 4]) -> DQuat {
    let rotation = DQuat::from_array(xyzw);
    if (1e-12..1e12).contains(&rotation.length_squared()) {
        rotation.normalize()
    } else {
        DQuat::IDENTITY
    }
}
