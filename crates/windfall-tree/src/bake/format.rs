//! The extension as it stands in the JSON of a file.
//!
//! A `View` is the index of a buffer view, and `None` an array without elements: glTF has no empty views.

use serde::{Deserialize, Serialize};
use windfall_core::NoteCode;
use windfall_core::simplify::PruneOrder;

pub(super) type View = Option<usize>;

#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub(super) struct Extension {
    pub version: u32,
    pub digest: String,
    pub source: String,
    pub prune_order: Option<Order>,
    pub notes: Vec<Remark>,
    pub name: String,
    pub wood: Wood,
    pub leaves: Leaves,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub(super) struct Order {
    pub name: PruneOrder,
    pub seed: u32,
}

/// A note on the source, without its name.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub(super) struct Remark {
    pub code: NoteCode,
    pub place: String,
    pub message: String,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub(super) struct Wood {
    /// [`super::records::WoodVertexRecord`]; the mesh that viewers show refers to it too.
    pub vertices: View,
    /// `u32`, three a triangle.
    pub indices: View,
    /// [`super::records::BranchRecord`], one a vertex.
    pub branches: View,
    /// The levels after the first, which is the mesh itself.
    pub levels: Vec<Level>,
    pub materials: Vec<Material>,
    pub outward: bool,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub(super) struct Level {
    /// `u32`, three a triangle.
    pub indices: View,
    pub error: f32,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub(super) struct Leaves {
    /// [`super::records::LeafRecord`], in prune order.
    pub records: View,
    pub shapes: Shapes,
    pub simple_shapes: Shapes,
    pub materials: Vec<Material>,
    pub palette: Option<Palette>,
    pub crown_center: [f32; 3],
    pub visibility: Visibility,
    pub shading: Shading,
}

/// Leaf shapes, one after the other.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub(super) struct Shapes {
    /// [`super::records::ShapeRecord`], one a shape.
    pub counts: View,
    /// [`super::records::ShapeVertexRecord`] of all shapes.
    pub vertices: View,
    /// `u32` of all shapes, each from 0.
    pub indices: View,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub(super) struct Material {
    pub name: String,
    pub base_color: [f32; 3],
    pub roughness: f32,
    pub alpha_cutoff: Option<f32>,
    pub surface: Surface,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", rename_all_fields = "camelCase", deny_unknown_fields)]
pub(super) enum Surface {
    Plain,
    Texture {
        /// Index of an image of the document.
        image: usize,
        repeat: bool,
    },
    Bark {
        ridge: [f32; 3],
        groove: [f32; 3],
        scale: f32,
        pattern: Pattern,
    },
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) enum Pattern {
    Smooth,
    Furrowed,
    Plated,
    Papery,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub(super) struct Palette {
    pub stops: Vec<[f32; 3]>,
    pub spread: f32,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub(super) struct Visibility {
    pub share: f32,
    pub disocclusion: [f32; 3],
    pub sunlight: [f32; 3],
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub(super) struct Shading {
    pub ambient: [f32; 3],
    /// Column by column.
    pub normals: [f32; 9],
}
