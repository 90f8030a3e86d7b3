//! Vertex animation textures of rigid leaves: a place and a rotation for each leaf and frame, for engines.
//!
//! Two textures of `columns` by `blocks * frames` texels hold leaf `i` in frame `f` (from 0) at column `i % columns`, row
//! `(i / columns) * frames + f`. The texel of the position is a place in the engine's axes and units, and in alpha 1 where
//! the leaf is shown and 0 where it is hidden; that of the rotation is a unit quaternion, real part in alpha. A mesh has
//! all leaves, each about its own centre; `TEXCOORD_1` is the texel of the leaf in frame 0, as a share of the texture.
//! A JSON file beside them says all of this ([`Vat::sidecar`]). The idea is that of the rigid bodies of SideFX Labs'
//! vertex animation textures; the layout is our own.

mod mesh;
pub mod paths;
mod texture;

pub use texture::{Texels, Which};

use crate::selection::Selection;
use crate::{ExportError, LeafState};
use glam::{Mat3, Quat, Vec3};
use serde_json::{Value, json};

/// Most columns and rows of a texture: what engines take.
pub const LARGEST: usize = 16_384;
/// Columns where there are many leaves.
const COLUMNS: usize = 8192;

/// An engine's axes and unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Engine {
    /// Metres, Y up, right-handed: as Windfall and glTF.
    #[default]
    Godot,
    /// Metres, Y up, left-handed: X is turned round, as glTF importers for Unity do it.
    Unity,
    /// Centimetres, Z up, left-handed: Y and Z change places, as Unreal's glTF importer does it.
    Unreal,
}

impl Engine {
    /// Their names on a command line.
    pub const NAMES: [&'static str; 3] = ["godot", "unity", "unreal"];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Godot => "godot",
            Self::Unity => "unity",
            Self::Unreal => "unreal",
        }
    }

    /// What turns a vector of Windfall's axes into one of the engine's.
    pub fn axes(self) -> Mat3 {
        match self {
            Self::Godot => Mat3::IDENTITY,
            Self::Unity => Mat3::from_diagonal(Vec3::new(-1.0, 1.0, 1.0)),
            Self::Unreal => Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::Y),
        }
    }

    /// Its units in a metre.
    pub fn units(self) -> f32 {
        if self == Self::Unreal { 100.0 } else { 1.0 }
    }

    /// A place, in its axes and units.
    pub fn place(self, place: Vec3) -> Vec3 {
        self.axes() * place * self.units()
    }

    /// A rotation, in its axes. Mirrored, it turns the other way about the mirrored axis.
    pub fn rotation(self, q: Quat) -> Quat {
        let axes = self.axes();
        let axis = axes * Vec3::new(q.x, q.y, q.z) * axes.determinant();
        Quat::from_xyzw(axis.x, axis.y, axis.z, q.w)
    }
}

impl std::str::FromStr for Engine {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "godot" => Ok(Self::Godot),
            "unity" => Ok(Self::Unity),
            "unreal" => Ok(Self::Unreal),
            _ => Err(format!("{name:?} is none of {}", Self::NAMES.join(", "))),
        }
    }
}

/// Example shaders for an engine: file names and texts. Unreal's is for a Custom node's include path.
pub fn shaders(engine: Engine) -> &'static [(&'static str, &'static str)] {
    const HLSL: (&str, &str) =
        ("windfall_vat.hlsl", include_str!("../../shaders/windfall_vat.hlsl"));
    match engine {
        Engine::Godot => {
            &[("windfall_leaves.gdshader", include_str!("../../shaders/windfall_leaves.gdshader"))]
        }
        Engine::Unity => &[
            HLSL,
            ("windfall_leaves.shader", include_str!("../../shaders/windfall_leaves.shader")),
        ],
        Engine::Unreal => &[HLSL],
    }
}

/// The decoder of [`paths`] for shaders: file name and text. Unity's and Unreal's is HLSL; Godot's language has none of
/// its own yet, so that it gets the WGSL to translate.
pub fn path_shader(engine: Engine) -> (&'static str, &'static str) {
    match engine {
        Engine::Godot => ("windfall_paths.wgsl", include_str!("../../shaders/windfall_paths.wgsl")),
        Engine::Unity | Engine::Unreal => {
            ("windfall_paths.hlsl", include_str!("../../shaders/windfall_paths.hlsl"))
        }
    }
}

/// The textures, mesh and sidecar of a selection.
pub struct Vat<'a> {
    selection: &'a Selection<'a>,
    engine: Engine,
    columns: usize,
    blocks: usize,
    /// Corners of the box of all centres, in the engine's axes and units. A texel of 16 bits is a share of it.
    low: Vec3,
    high: Vec3,
    /// Largest radius of a leaf, metres.
    radius: f32,
}

/// Names of the files beside the sidecar.
#[derive(Debug, Clone)]
pub struct Files {
    /// The texture of positions.
    pub position: String,
    /// The texture of rotations.
    pub rotation: String,
    /// The mesh.
    pub mesh: String,
}

impl<'a> Vat<'a> {
    /// Lays out the textures. Goes through all frames once, for the box of all positions; `progress` is told the share
    /// that is done.
    ///
    /// # Errors
    ///
    /// No leaf is selected, or more leaves or frames than fit into a texture of [`LARGEST`] rows.
    pub fn new(
        selection: &'a Selection<'a>,
        engine: Engine,
        progress: &mut dyn FnMut(f32),
    ) -> Result<Self, ExportError> {
        let (leaves, frames) = (selection.len(), selection.moments().count as usize);
        if leaves == 0 {
            return Err(ExportError::Nothing("a texture needs leaves".to_owned()));
        }
        if frames > LARGEST {
            return Err(ExportError::TooManyFrames(selection.moments().count));
        }
        let columns = leaves.min(COLUMNS);
        let blocks = leaves.div_ceil(columns);
        if blocks * frames > LARGEST {
            let most = LARGEST / frames * COLUMNS;
            return Err(ExportError::TooManyLeaves { leaves, most, format: "a texture" });
        }
        let mut vat = Self {
            selection,
            engine,
            columns,
            blocks,
            low: Vec3::INFINITY,
            high: Vec3::NEG_INFINITY,
            radius: 0.0,
        };
        for group in selection.groups() {
            let shape = crate::mesh::shape_of(selection.source(), group.kind);
            for i in group.leaves.clone() {
                let frames = if group.moves { frames } else { 1 };
                for frame in 0..frames {
                    let state = vat.state(i, frame);
                    let place = engine.place(state.position);
                    (vat.low, vat.high) = (vat.low.min(place), vat.high.max(place));
                    vat.radius = vat.radius.max(shape.radius() * state.scale);
                }
            }
            progress(group.leaves.end as f32 / leaves as f32);
        }
        Ok(vat)
    }

    /// Where leaf `i` is in a frame, from 0.
    fn state(&self, i: usize, frame: usize) -> LeafState {
        let moments = self.selection.moments();
        self.selection.state(i, moments.time(moments.first + frame as u32))
    }

    fn frames(&self) -> usize {
        self.selection.moments().count as usize
    }

    /// Width and height of a texture.
    pub fn size(&self) -> (usize, usize) {
        (self.columns, self.blocks * self.frames())
    }

    /// The leaf and the frame, from 0, of a texel; `None` where the last row of leaves is not full.
    fn at(&self, column: usize, row: usize) -> Option<(usize, usize)> {
        let leaf = row / self.frames() * self.columns + column;
        (leaf < self.selection.len()).then_some((leaf, row % self.frames()))
    }

    /// Largest error of a position that is stored in 16 bits, metres: half of a step along each axis.
    pub fn rounding(&self) -> f32 {
        0.5 * ((self.high - self.low) / 65_535.0).length() / self.engine.units()
    }

    /// What an engine has to know, as JSON.
    pub fn sidecar(&self, texels: Texels, files: &Files) -> Vec<u8> {
        let moments = self.selection.moments();
        let source = self.selection.source();
        let axes = self.engine.axes().transpose();
        let reach = self.radius * self.engine.units();
        let (width, height) = self.size();
        // Floats mean what they are, numbers of 16 bits a share.
        let (encoding, low, high, turn) = match texels {
            Texels::Exr => ("float32", Vec3::ZERO, Vec3::ONE, [0, 1]),
            Texels::Png => ("unorm16", self.low, self.high, [-1, 1]),
        };
        let meshes: Vec<Value> = mesh::kinds(self.selection)
            .iter()
            .map(|(kind, leaves)| {
                json!({
                    "tree": crate::short_name(&source.trees[kind.model as usize].name),
                    "shape": kind.shape, "firstLeaf": leaves.start, "leaves": leaves.len(),
                })
            })
            .collect();
        let all = || 0..self.selection.len();
        let document = json!({
            "format": "windfall-vat",
            "version": 1,
            "engine": self.engine.name(),
            "axes": [axes.x_axis.to_array(), axes.y_axis.to_array(), axes.z_axis.to_array()],
            "unitsPerMetre": self.engine.units(),
            "firstFrame": moments.first,
            "frames": moments.count,
            "fps": moments.fps,
            "leaves": self.selection.len(),
            "columns": self.columns,
            "blocks": self.blocks,
            "width": width,
            "height": height,
            "encoding": encoding,
            "position": {
                "file": files.position, "low": low.to_array(), "high": high.to_array(),
            },
            "rotation": { "file": files.rotation, "low": turn[0], "high": turn[1] },
            "bounds": {
                "low": (self.low - reach).to_array(), "high": (self.high + reach).to_array(),
            },
            "mesh": files.mesh,
            "meshes": meshes,
            "ids": all().map(|i| self.selection.id(i).0).collect::<Vec<_>>(),
            "scales": all().map(|i| self.state(i, 0).scale).collect::<Vec<_>>(),
        });
        document.to_string().into_bytes()
    }
}
