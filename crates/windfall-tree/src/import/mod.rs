//! Reads a tree from glTF 2.0, binary or JSON, strictly: what is wrong is refused with the file,
//! the place and the cause, and nothing is allocated that the file's size does not warrant.
//!
//! The steps: bytes → document and buffers (`container`), the node tree → primitives (`scene`),
//! leaves or wood (`sort`), accessors → triangles in the tree's space (`accessor`, `meshopt`, `primitive`, `skin`),
//! wood among the leaves and solid crowns (`pieces`, `crowns`), pieces → leaves → shapes (`build`, `crate::leaves`),
//! what the renderer needs ([`crate::prepare`]), and what looks wrong (`check`).

mod accessor;
mod build;
mod check;
pub(crate) mod container;
mod crowns;
pub(crate) mod document;
mod material;
#[cfg(not(target_arch = "wasm32"))]
mod meshopt;
mod name;
pub(crate) mod picture;
mod pieces;
mod primitive;
mod scene;
mod skin;
mod slots;
mod sort;

use crate::bake::{self, About, BakedTree};
use crate::prepare::{self, Stage, Watch};
use build::Built;
use document::Document;
use glam::Vec3;
use name::label;
use primitive::Geometry;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use windfall_core::InputErrorKind::{Empty, OutOfRange, Unsupported};
use windfall_core::material::Image;
use windfall_core::simplify::PruneOrder;
use windfall_core::tree::Tree;
use windfall_core::{InputError, InputErrorKind, Note, NoteCode};

pub use build::Part;
pub use container::{Survey, survey};
pub use sort::Use;

/// Triangles that a file may draw, over all its nodes: one mesh can be named by many.
const MOST_TRIANGLES: u64 = 1 << 24;

/// Primitives that a file may draw, over all its nodes: enough for a node per leaf.
const MOST_PRIMITIVES: usize = 1 << 20;

/// A foot nearer to the origin than this part of the tree's height stands where it should.
const FOOT_TOLERANCE: f64 = 0.02;

/// The axis that points up in a file.
#[derive(
    Debug, Clone, Copy, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize,
)]
pub enum Up {
    /// Y, as glTF prescribes.
    #[default]
    Y,
    /// Z, for files whose writer did not turn the model.
    Z,
}

/// How to read a tree. A *choice* is the name of a node, mesh or material (letter case and the way accents are
/// stored do not matter), or the number of a primitive as [`Part::number`] has it.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportOptions {
    /// Nodes to read, by name or number, with all that is below them; empty: the whole scene.
    pub node: Vec<String>,
    /// Choices that are leaves. Without `wood`, everything else is wood.
    pub leaves: Vec<String>,
    /// Choices that are wood. Without `leaves`, everything else is leaves; with both, everything else is left out.
    /// Both empty: leaves are what is named like leaves, or is alpha-masked.
    pub wood: Vec<String>,
    /// The axis that points up in the file.
    pub up: Up,
    /// Metres for each unit of the file, above 0; `None` takes the file's unit for a metre, as glTF does.
    pub unit: Option<f32>,
    /// Put the lowest point of wood and leaves on the ground, wherever the foot is.
    pub ground: bool,
    /// Whether colours of vertices multiply those of materials. Off for files whose colours are something else,
    /// such as weights of the wind. The default is on.
    pub vertex_colors: bool,
    /// Height to scale the tree to, metres, above 0; `None` keeps it.
    pub height: Option<f32>,
    /// Seed of the shed order, and of the prune order where `prune_order` gives none.
    pub seed: u32,
    /// Prune order and its seed; `None` is random, as the leaves are assembled. Chosen here, the crown is measured
    /// once; [`prepare::set_prune_order`] measures it again.
    pub prune_order: Option<(PruneOrder, u32)>,
}

impl Default for ImportOptions {
    fn default() -> Self {
        Self {
            node: Vec::new(),
            leaves: Vec::new(),
            wood: Vec::new(),
            up: Up::Y,
            unit: None,
            ground: false,
            vertex_colors: true,
            height: None,
            seed: 0,
            prune_order: None,
        }
    }
}

impl ImportOptions {
    /// The seed of prune orders for programs that have no reason for another: a tree that is baked with it need not be
    /// put in order again.
    pub const PRUNE_SEED: u32 = 5;

    /// The first option that says how a source is read, and not what becomes of its tree.
    fn of_source(&self) -> Option<&'static str> {
        let none = Self::default();
        [
            ("node", self.node != none.node),
            ("leaves", self.leaves != none.leaves),
            ("wood", self.wood != none.wood),
            ("up", self.up != none.up),
            ("unit", self.unit != none.unit),
            ("ground", self.ground != none.ground),
            ("vertex_colors", self.vertex_colors != none.vertex_colors),
        ]
        .into_iter()
        .find_map(|(name, given)| given.then_some(name))
    }
}

/// A tree that was read, and what there is to say about it.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Import {
    /// The tree, prepared for drawing.
    pub tree: Tree,
    /// What was left out, repaired, or looks wrong, by [`NoteCode`].
    pub notes: Vec<Note>,
    /// The primitives, and what each was taken for; none of a baked tree.
    pub parts: Vec<Part>,
    /// What a baked tree was made of; `None` of any other.
    pub baked: Option<About>,
}

impl From<Tree> for Import {
    /// A tree that comes from no file: there is nothing to say about it.
    fn from(tree: Tree) -> Self {
        Self { tree, notes: Vec::new(), parts: Vec::new(), baked: None }
    }
}

/// Fetches what a `.gltf` names outside itself: a relative path (percent signs decoded) to bytes, or
/// why there are none. Whether a path may leave the file's folder is for the caller to say.
pub type Resolve<'a> = dyn FnMut(&str) -> Result<Vec<u8>, String> + 'a;

/// Reads a tree from the bytes of a `.glb` or `.gltf`, and prepares it for drawing.
///
/// `file` is what errors call the file, and the tree's name. Read are: triangles, strips and fans,
/// indexed or not; every index and attribute type including `KHR_mesh_quantization`, sparse
/// accessors, `EXT_meshopt_compression` and `KHR_meshopt_compression` (not in browsers); instances
/// (`EXT_mesh_gpu_instancing`), skins as their joints stand, morph targets at their weights; base colours with their
/// pictures (PNG, JPEG, WebP), `KHR_texture_transform`, `KHR_materials_pbrSpecularGlossiness`, colours of vertices.
/// Of levels of detail (by name or `MSFT_lod`) the finest is read. What is left out, and what looks wrong, is in
/// [`Import::notes`].
///
/// **Leaves** are the primitives whose material is named like leaves or is alpha-masked (a blended
/// one is taken for masked), and those whose node or mesh is named so, unless materials already
/// tell the leaves of that mesh apart. Within them, each piece that hangs together through shared
/// edges is a leaf, or what [`super::export_glb`] has written as one (its attribute `_LEAF`), or each node where
/// nodes are the leaves. Where no wood is left, trunk and branches are found among the pieces. Leaves are scattered
/// over closed solids in place of these.
///
/// **Place**: a tree whose foot stands at the origin (within 2 % of its height) stays as authored;
/// any other is moved so that the middle of its lowest wood does.
///
/// **A baked tree** ([`mod@crate::bake`]) is recognised and read as it is, in a hundredth of the time, with the notes of when
/// it was baked. Another `height` scales what was baked: apart from rounding, that is the tree as it would be baked at that
/// height. Another `prune_order` than it has is applied, and without one it keeps its own; its shed order stays. Options
/// that say how a source is read are refused.
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
) -> Result<Import, InputError> {
    match import_watched(bytes, file, options, resolve, &mut prepare::unwatched)? {
        Some(import) => Ok(import),
        None => unreachable!("nothing stops it"),
    }
}

/// [`import`] that tells `watch` what it begins to do; `None` if that stops it.
///
/// # Errors
///
/// Those of [`import`].
pub fn import_watched(
    bytes: &[u8],
    file: &str,
    options: &ImportOptions,
    resolve: &mut Resolve<'_>,
    watch: &mut Watch<'_>,
) -> Result<Option<Import>, InputError> {
    if watch(Stage::Parse).is_break() {
        return Ok(None);
    }
    for (name, value) in [("height", options.height), ("unit", options.unit)] {
        if let Some(value) = value
            && !(value.is_finite() && value > 0.0)
        {
            let cause = format!("{value} m: a {name} is above 0");
            return Err(InputError::new(file, name, OutOfRange, cause));
        }
    }
    let (document, binary) = container::open(bytes, file)?;
    if document.is_baked() {
        let baked = bake::read(bytes, file, &document, binary)?;
        return adapt(baked, file, options, watch);
    }
    let mut parents = BTreeMap::new();
    for (index, node) in document.nodes.iter().enumerate() {
        for &child in &node.children {
            parents.entry(child).or_insert(index);
        }
    }
    let mut reader = Reader {
        file,
        document: &document,
        parents,
        binary,
        resolve,
        buffers: BTreeMap::new(),
        unpacked: BTreeMap::new(),
        images: BTreeMap::new(),
        geometries: BTreeMap::new(),
        notes: Vec::new(),
        unread: Unread::default(),
    };
    let mut found = reader.find(options)?;
    sort::sort(&mut found, options, &mut reader)?;
    let Some(built) = reader.build(&mut found, options, watch)? else { return Ok(None) };
    let Built { mut tree, mut parts, origin } = built;
    if tree.foliage.leaves.is_empty() {
        let why = "the leaves' triangles have no area";
        return Err(sort::no_leaves(&found, file, Empty, why));
    }
    reader.note_unread(&found);
    let (mut shift, mut factor) = (Vec3::ZERO, 1.0);
    let place = |tree: &mut Tree| {
        shift = stand(tree, origin, options.ground);
        if let Some(height) = options.height {
            let before = tree.height();
            tree.set_height(height);
            factor = if before > 0.0 { height / before } else { 1.0 };
        }
    };
    if prepare::finish(&mut tree, options.prune_order, place, watch).is_break() {
        return Ok(None);
    }
    for part in &mut parts {
        part.bounds = part.bounds.map(|corner| (corner + shift) * factor);
    }
    reader.note_implausible(&tree, &parts);
    if !prepare::SIMPLIFIES {
        let message = "this build has no meshoptimizer: the wood is drawn in full at any distance, and leaves \
                       with their outlines; `windfall bake` writes a tree that has both simplified";
        reader.note(NoteCode::WoodInFull, "", message);
    }
    let mut notes = reader.notes;
    notes.sort_by_key(|note| note.code);
    Ok(Some(Import { tree, notes, parts, baked: None }))
}

/// A baked tree as `options` want it.
fn adapt(
    baked: BakedTree,
    file: &str,
    options: &ImportOptions,
    watch: &mut Watch<'_>,
) -> Result<Option<Import>, InputError> {
    let BakedTree { mut tree, mut about } = baked;
    if let Some(name) = options.of_source() {
        let cause =
            "the file is a baked tree, in which this is settled: give the option when it is baked";
        return Err(InputError::new(file, name, Unsupported, cause));
    }
    if let Some(height) = options.height
        && (tree.height() - height).abs() > 1e-5 * height
    {
        tree.set_height(height);
    }
    if let Some((order, seed)) = options.prune_order
        && about.prune_order != Some((order, seed))
    {
        if watch(Stage::Order).is_break() {
            return Ok(None);
        }
        prepare::set_prune_order(&mut tree.foliage, order, seed);
        about.prune_order = options.prune_order;
    }
    file.clone_into(&mut tree.name);
    Ok(Some(Import { tree, notes: about.notes.clone(), parts: Vec::new(), baked: Some(about) }))
}

/// A document that is being read, and what has been loaded of it.
struct Reader<'a> {
    file: &'a str,
    document: &'a Document,
    /// The parent of each node that has one.
    parents: BTreeMap<usize, usize>,
    binary: Option<&'a [u8]>,
    resolve: &'a mut Resolve<'a>,
    buffers: BTreeMap<usize, Cow<'a, [u8]>>,
    unpacked: BTreeMap<usize, Vec<u8>>,
    images: BTreeMap<usize, Image>,
    /// Primitives that several nodes may draw, by mesh and number.
    geometries: BTreeMap<(usize, usize), Rc<Geometry>>,
    notes: Vec<Note>,
    unread: Unread,
}

/// What was met and not used.
#[derive(Default)]
struct Unread {
    /// Primitives without triangles.
    primitives: Vec<String>,
    attributes: BTreeSet<String>,
    /// Materials, and which of their textures.
    textures: Vec<(String, String)>,
}

impl Reader<'_> {
    fn error(&self, place: &str, kind: InputErrorKind, cause: impl Into<String>) -> InputError {
        InputError::new(self.file, place, kind, cause)
    }

    fn note(&mut self, code: NoteCode, place: &str, message: impl Into<String>) {
        let note = Note::new(code, self.file, place, message);
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }
}

/// Puts the foot of the trunk at the origin, if it is not about there, and says by how much the tree was moved.
/// `origin` is where the tree's origin is in the file.
fn stand(tree: &mut Tree, origin: glam::DVec3, on_lowest: bool) -> Vec3 {
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
    let has_foot = foot_low.x <= foot_high.x;
    let foot =
        if has_foot { ((foot_low + foot_high) / 2.0).with_y(ground) } else { (low + high) / 2.0 };
    let foot = if on_lowest || !has_foot { foot.with_y(low.y) } else { foot };
    let in_file = foot.as_dvec3() + origin;
    // A tree without wood has no foot to stand on: it stays, unless it is far away.
    let far = if has_foot { FOOT_TOLERANCE * f64::from(height) } else { FAR };
    let shift = if on_lowest || in_file.length() > far { -foot } else { origin.as_vec3() };
    if shift != Vec3::ZERO {
        tree.translate(shift);
    }
    shift
}

/// Distance from the origin beyond which floats are too coarse for leaves, in units of the file.
const FAR: f64 = 4096.0;
