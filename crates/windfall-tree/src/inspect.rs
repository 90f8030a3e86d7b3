//! What there is to know about a tree at a glance.

use serde::Serialize;
use windfall_core::material::{Material, Surface};
use windfall_core::tree::Tree;

/// The figures of a tree.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Inspection {
    /// Name of the species or of the file.
    pub name: String,
    /// Leaf elements.
    pub leaves: usize,
    /// Shapes that the leaves share.
    pub shapes: usize,
    /// Triangles of all leaves.
    pub leaf_triangles: usize,
    /// Triangles of trunk and branches.
    pub wood_triangles: usize,
    /// Vertices of wood and leaves, each leaf counted with its own.
    pub vertices: usize,
    /// Height from the ground to the top, metres.
    pub height_m: f32,
    /// Mean of the leaves' centres, metres.
    pub crown_center: [f32; 3],
    /// The pictures, those of the wood first.
    pub textures: Vec<TextureInspection>,
}

/// A picture of a tree.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct TextureInspection {
    /// Name of the material that it colours.
    pub material: String,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Inspection {
    /// Counts and measures a tree.
    pub fn of(tree: &Tree) -> Self {
        let foliage = &tree.foliage;
        let texture = |material: &Material| match &material.surface {
            Surface::Texture(image, _) => Some(TextureInspection {
                material: material.name.clone(),
                width: image.width,
                height: image.height,
            }),
            Surface::Plain | Surface::Bark(_) => None,
        };
        Self {
            name: tree.name.clone(),
            leaves: foliage.leaves.len(),
            shapes: foliage.shapes.len(),
            leaf_triangles: foliage.triangle_count(),
            wood_triangles: tree.wood_triangles(),
            vertices: tree.vertex_count(),
            height_m: tree.height(),
            crown_center: foliage.crown_center.to_array(),
            textures: tree
                .wood
                .materials
                .iter()
                .chain(&foliage.materials)
                .filter_map(texture)
                .collect(),
        }
    }
}
