//! Reads a tree from glTF 2.0, binary or JSON, strictly: what is wrong is refused with the file,
//! the place and the cause, and nothing is allocated that the file's size does not warrant.
//!
//! The steps: bytes → document and buffers (`container`), the node tree → primitives (here),
//! accessors → triangles in the tree's space (`accessor`, `meshopt`, `primitive`), leaves or wood
//! (`sort`), pieces → leaves → shapes (`crate::leaves`), and what the renderer needs ([`crate::prepare`]).

mod accessor;
mod container;
mod document;
mod material;
#[cfg(not(target_arch = "wasm32"))]
mod meshopt;
mod primitive;
mod sort;

use crate::leaves::{Shaper, pieces};
use crate::prepare;
use document::{Document, Node};
use glam::{Mat4, Quat, Vec3};
use sort::Found;
use std::borrow::Cow;
use std::collections::BTreeMap;
use windfall_core::InputErrorKind::{Empty, Malformed, OutOfRange};
use windfall_core::foliage::Foliage;
use windfall_core::material::{Image, Material};
use windfall_core::simplify::PruneOrder;
use windfall_core::tree::{Tree, Wood, WoodVertex};
use windfall_core::{InputError, InputErrorKind};

/// Triangles that a file may draw, over all its nodes: one mesh can be named by many.
const MOST_TRIANGLES: u64 = 1 << 24;

/// Primitives that a file may draw, over all its nodes: enough for a node per leaf.
const MOST_PRIMITIVES: usize = 1 << 20;

/// A foot nearer to the origin than this part of the tree's height stands where it should.
const FOOT_TOLERANCE: f32 = 0.02;

/// How to read a tree.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ImportOptions {
    /// Names of nodes, meshes or materials that are leaves (letter case is ignored); everything
    /// else is wood. Empty: leaves are what is named like leaves, or is alpha-masked.
    pub leaves: Vec<String>,
    /// Height to scale the tree to, metres, above 0; `None` takes the file's unit for a metre, as
    /// glTF does.
    pub height: Option<f32>,
    /// Seed of the shed order, and of the prune order where `prune_order` gives none.
    pub seed: u32,
    /// Prune order and its seed; `None` is random, as the leaves are assembled. Chosen here, the crown is measured
    /// once; [`prepare::set_prune_order`] measures it again.
    pub prune_order: Option<(PruneOrder, u32)>,
}

/// Fetches what a `.gltf` names outside itself: a relative path (percent signs decoded) to bytes, or
/// why there are none. Whether a path may leave the file's folder is for the caller to say.
pub type Resolve<'a> = dyn FnMut(&str) -> Result<Vec<u8>, String> + 'a;

/// Reads a tree from the bytes of a `.glb` or `.gltf`, and prepares it for drawing.
///
/// `file` is what errors call the file, and the tree's name. Read are: triangles, strips and fans,
/// indexed or not; every index and attribute type including `KHR_mesh_quantization`, sparse
/// accessors, `EXT_meshopt_compression` (not in browsers); base colours with their pictures (PNG,
/// JPEG, WebP) and `KHR_texture_transform`. Points and lines are skipped. Skins, morph targets,
/// cameras and lights are left out.
///
/// **Leaves** are the primitives whose material is named like leaves or is alpha-masked (a blended
/// one is taken for masked), and those whose node or mesh is named so, unless materials already
/// tell the leaves of that mesh apart. Within them, each piece that hangs together through shared
/// edges is a leaf, or what [`super::export_glb`] has written as one (its attribute `_LEAF`).
///
/// **Place**: a tree whose foot stands at the origin (within 2 % of its height) stays as authored;
/// any other is moved so that the middle of its lowest wood does.
///
/// # Errors
///
/// An [`InputError`] for anything malformed, missing, out of range, not finite, not supported, or
/// without triangles or leaves.
pub fn import(
    bytes: &[u8],
    file: &str,
    options: &ImportOptions,
    resolve: &mut Resolve<'_>,
) -> Result<Tree, InputError> {
    if let Some(height) = options.height
        && !(height.is_finite() && height > 0.0)
    {
        let cause = format!("{height} m: a height is above 0");
        return Err(InputError::new(file, "height", OutOfRange, cause));
    }
    let (document, binary) = container::open(bytes, file)?;
    let mut reader = Reader {
        file,
        document: &document,
        binary,
        resolve,
        buffers: BTreeMap::new(),
        unpacked: BTreeMap::new(),
        images: BTreeMap::new(),
    };
    let mut found = reader.find()?;
    sort::sort(&mut found, &options.leaves, file)?;
    let mut tree = reader.build(&found, options.seed)?;
    if tree.foliage.leaves.is_empty() {
        return Err(sort::no_leaves(&found, file, "the leaves' triangles have no area"));
    }
    prepare::finish(&mut tree, options.prune_order, |tree| {
        stand(tree);
        if let Some(height) = options.height {
            tree.set_height(height);
        }
    });
    Ok(tree)
}

/// A document that is being read, and what has been loaded of it.
struct Reader<'a> {
    file: &'a str,
    document: &'a Document,
    binary: Option<&'a [u8]>,
    resolve: &'a mut Resolve<'a>,
    buffers: BTreeMap<usize, Cow<'a, [u8]>>,
    unpacked: BTreeMap<usize, Vec<u8>>,
    images: BTreeMap<usize, Image>,
}

impl<'a> Reader<'a> {
    fn error(&self, place: &str, kind: InputErrorKind, cause: impl Into<String>) -> InputError {
        InputError::new(self.file, place, kind, cause)
    }

    /// Every primitive that draws triangles, once for each node that has it.
    fn find(&self) -> Result<Vec<Found<'a>>, InputError> {
        let document = self.document;
        let mut found = Vec::new();
        let mut triangles = 0;
        // A stack of its own: a document may nest deeper than the thread's.
        let mut stack: Vec<(usize, Mat4, String)> =
            self.roots()?.into_iter().rev().map(|(root, at)| (root, Mat4::IDENTITY, at)).collect();
        let mut seen = vec![false; document.nodes.len()];
        while let Some((index, world_from_parent, at)) = stack.pop() {
            let Some(node) = document.nodes.get(index) else {
                let cause = format!("names node {index}, but there are {}", document.nodes.len());
                return Err(self.error(&at, OutOfRange, cause));
            };
            let here = label("node", index, node.name.as_deref());
            if std::mem::replace(&mut seen[index], true) {
                let cause = "is reached twice: nodes must form a tree, without cycles";
                return Err(self.error(&here, Malformed, cause));
            }
            let world_from_node = world_from_parent * local(node);
            for &child in node.children.iter().rev() {
                stack.push((child, world_from_node, here.clone()));
            }
            let Some(mesh_index) = node.mesh else { continue };
            let Some(mesh) = document.meshes.get(mesh_index) else {
                let cause =
                    format!("names mesh {mesh_index}, but there are {}", document.meshes.len());
                return Err(self.error(&here, OutOfRange, cause));
            };
            for (i, primitive) in mesh.primitives.iter().enumerate() {
                let place = primitive::place(mesh_index, mesh.name.as_deref(), i);
                let count = self.triangle_count(primitive, &place)?;
                triangles += count;
                if triangles > MOST_TRIANGLES {
                    let cause = format!(
                        "with its {count} triangles the file has more than {MOST_TRIANGLES}: \
                         too many for one tree"
                    );
                    return Err(self.error(&place, OutOfRange, cause));
                }
                if found.len() >= MOST_PRIMITIVES {
                    let cause = format!("the scene draws more than {MOST_PRIMITIVES} primitives");
                    return Err(self.error(&here, OutOfRange, cause));
                }
                if count > 0 {
                    let material = primitive.material.and_then(|m| document.materials.get(m));
                    found.push(Found {
                        place,
                        node: node.name.as_deref(),
                        node_index: index,
                        mesh: mesh.name.as_deref(),
                        material: material.and_then(|m| m.name.as_deref()),
                        masked: material.is_some_and(|m| {
                            matches!(m.alpha_mode.as_deref(), Some("MASK" | "BLEND"))
                        }),
                        triangles: count,
                        primitive,
                        world_from_node,
                        leaves: false,
                    });
                }
            }
        }
        if found.is_empty() {
            let cause = "there are no triangles in its scene";
            return Err(self.error("", Empty, cause));
        }
        Ok(found)
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
        let mut is_child = vec![false; document.nodes.len()];
        for &child in document.nodes.iter().flat_map(|node| &node.children) {
            if let Some(flag) = is_child.get_mut(child) {
                *flag = true;
            }
        }
        let roots = (0..document.nodes.len()).filter(|&i| !is_child[i]);
        Ok(roots.map(|root| (root, "nodes".to_string())).collect())
    }

    fn build(&mut self, found: &[Found<'_>], seed: u32) -> Result<Tree, InputError> {
        let mut wood = Wood::default();
        let mut shaper = Shaper::default();
        let mut leaf_materials = Vec::new();
        // By material in the file and by use: a material may dress both wood and leaves.
        let mut known: BTreeMap<(Option<usize>, bool), (u32, material::Look)> = BTreeMap::new();
        for part in found {
            let key = (part.primitive.material, part.leaves);
            let (slot, look) = if let Some(known) = known.get(&key) {
                known.clone()
            } else {
                let look = self.look(part.primitive.material, &part.place)?;
                let list: &mut Vec<Material> =
                    if part.leaves { &mut leaf_materials } else { &mut wood.materials };
                list.push(look.material.clone());
                let entry = (list.len() as u32 - 1, look);
                known.insert(key, entry.clone());
                entry
            };
            let mesh = self.mesh(part.primitive, &look, part.world_from_node, &part.place)?;
            if part.leaves {
                for piece in pieces(&mesh) {
                    shaper.add(piece, slot);
                }
            } else {
                let base = wood.vertices.len() as u32;
                wood.indices.extend(mesh.indices.iter().map(|i| base + i));
                let vertices = mesh.positions.iter().zip(&mesh.normals).zip(&mesh.uvs);
                wood.vertices.extend(vertices.map(|((&position, &normal), &uv)| WoodVertex {
                    position,
                    normal,
                    uv,
                    material: slot,
                }));
            }
        }
        let positions: Vec<Vec3> = wood.vertices.iter().map(|v| v.position).collect();
        let (leaves, shapes) = shaper.finish(&positions);
        let foliage = Foliage::assemble(leaves, shapes, leaf_materials, None, seed);
        Ok(Tree { name: self.file.to_string(), wood, foliage })
    }
}

/// Puts the foot of the trunk at the origin, if it is not about there.
fn stand(tree: &mut Tree) {
    let (low, high) = tree.bounds();
    let height = high.y - low.y;
    let ground = tree.wood.vertices.iter().map(|v| v.position.y).fold(f32::INFINITY, f32::min);
    let (foot_low, foot_high) = tree
        .wood
        .vertices
        .iter()
        .map(|v| v.position)
        .filter(|p| p.y <= ground + 0.01 * height)
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    // A tree without wood has no foot to stand on.
    if foot_low.x > foot_high.x {
        return;
    }
    let foot = ((foot_low + foot_high) / 2.0).with_y(ground);
    if foot.length() > FOOT_TOLERANCE * height {
        tree.translate(-foot);
    }
}

/// `node 3 "Tree"`, or `node 3`. Names from files are shortened and kept on one line.
fn label(kind: &str, index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) if !name.is_empty() => format!("{kind} {index} {}", quoted(name)),
        _ => format!("{kind} {index}"),
    }
}

/// A name in quotes, control characters escaped, at most 60 characters of it.
fn quoted(name: &str) -> String {
    let short: String = name.chars().take(60).collect();
    let dots = if short.len() < name.len() { "…" } else { "" };
    format!("{:?}", short + dots)
}

fn local(node: &Node) -> Mat4 {
    if let Some(matrix) = &node.matrix {
        return Mat4::from_cols_array(matrix);
    }
    let rotation = Quat::from_array(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
    // Forgiving: writers round quaternions; one of no length at all is no rotation.
    let rotation = if (1e-12..1e12).contains(&rotation.length_squared()) {
        rotation.normalize()
    } else {
        Quat::IDENTITY
    };
    Mat4::from_scale_rotation_translation(
        node.scale.unwrap_or([1.0; 3]).into(),
        rotation,
        node.translation.unwrap_or([0.0; 3]).into(),
    )
}
