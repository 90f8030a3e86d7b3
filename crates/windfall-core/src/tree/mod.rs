//! Tree models: wood and leaves, from a file or from a built-in species.

mod export;
mod import;
mod inspect;
pub mod species;

pub use export::{ExportError, export_glb, export_glb_in_prune_order};
pub use import::{ImportOptions, Resolve, import};
pub use inspect::{Inspection, TextureInspection};

use crate::foliage::Foliage;
use glam::{Vec2, Vec3};

/// A tree model. Metres, Y up; the trunk leaves the ground at the origin.
#[derive(Debug, Clone)]
pub struct Tree {
    /// Name of the species or of the file, for people.
    pub name: String,
    /// Trunk and branches.
    pub wood: Wood,
    /// The leaves.
    pub foliage: Foliage,
}

/// Trunk and branches: one indexed triangle mesh.
#[derive(Debug, Clone, Default)]
pub struct Wood {
    /// Vertices; every index refers to one of them.
    pub vertices: Vec<WoodVertex>,
    /// Triangles, three indices each, counter-clockwise from outside.
    pub indices: Vec<u32>,
    /// What the vertices' `material` refers to.
    pub materials: Vec<Material>,
}

/// A vertex of the wood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WoodVertex {
    /// Position in the tree, metres.
    pub position: Vec3,
    /// Unit normal.
    pub normal: Vec3,
    /// Texture coordinates, texture transform applied. For [`Surface::Bark`]: metres around
    /// the branch at its foot, and along it.
    pub uv: Vec2,
    /// Index into [`Wood::materials`].
    pub material: u32,
}

/// How a surface looks.
#[derive(Debug, Clone)]
pub struct Material {
    /// Name in the file, or of the species.
    pub name: String,
    /// Linear colour that multiplies the surface's own, `0..=1`.
    pub base_color: Vec3,
    /// Roughness, `0..=1`.
    pub roughness: f32,
    /// Texels whose alpha is below this are holes; `None` draws every texel.
    pub alpha_cutoff: Option<f32>,
    /// Where the colour comes from.
    pub surface: Surface,
}

/// Where a surface's colour comes from.
#[derive(Debug, Clone)]
pub enum Surface {
    /// The material's base colour alone.
    Plain,
    /// A picture, repeated (`true`) or clamped (`false`) beyond its edges.
    Texture(Image, bool),
    /// Bark, drawn by the shader.
    Bark(Bark),
}

/// Bark without a picture: two colours and a pattern that the shader draws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bark {
    /// Linear colour of the ridges.
    pub ridge: Vec3,
    /// Linear colour of the grooves, scars or lenticels.
    pub groove: Vec3,
    /// Size of the pattern along the branch, metres.
    pub scale: f32,
    /// The pattern.
    pub pattern: BarkPattern,
}

/// The pattern of a bark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BarkPattern {
    /// Nearly even: beech.
    Smooth,
    /// Long vertical furrows: oak, ginkgo.
    Furrowed,
    /// Scales and plates: maple.
    Plated,
    /// Pale paper with dark horizontal lenticels and scars: birch, aspen.
    Papery,
}

/// A picture: rows from the top, four bytes a pixel, sRGB colour with straight alpha.
#[derive(Clone, PartialEq, Eq)]
pub struct Image {
    /// Pixels in a row; at least 1.
    pub width: u32,
    /// Rows; at least 1.
    pub height: u32,
    /// `width * height * 4` bytes.
    pub rgba: Vec<u8>,
}

impl std::fmt::Debug for Image {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Image({}x{})", self.width, self.height)
    }
}

impl Tree {
    /// Smallest box around wood and leaves, `(low, high)`; zero for a tree of nothing.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let wood = self.wood.vertices.iter().map(|v| v.position);
        let leaves = self.foliage.leaves.iter().flat_map(|leaf| {
            let shape = &self.foliage.shapes[leaf.shape as usize];
            shape.positions.iter().map(|&p| leaf.center + leaf.orientation * p * leaf.scale)
        });
        let (low, high) = wood
            .chain(leaves)
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        if low.x <= high.x { (low, high) } else { (Vec3::ZERO, Vec3::ZERO) }
    }

    /// Height from the ground to the top of [`Self::bounds`], metres.
    pub fn height(&self) -> f32 {
        self.bounds().1.y
    }

    /// Scales the whole tree about its foot so that its height becomes `height` metres.
    ///
    /// A tree without height stays as it is.
    pub fn set_height(&mut self, height: f32) {
        let now = self.height();
        if now > 0.0 && height > 0.0 {
            self.scale(height / now);
        }
    }

    /// Scales the whole tree about its foot.
    pub fn scale(&mut self, factor: f32) {
        for vertex in &mut self.wood.vertices {
            vertex.position *= factor;
        }
        self.foliage.scale_positions(factor);
    }

    /// Moves the whole tree.
    pub fn translate(&mut self, by: Vec3) {
        for vertex in &mut self.wood.vertices {
            vertex.position += by;
        }
        self.foliage.translate(by);
    }

    /// Triangles of the wood.
    pub fn wood_triangles(&self) -> usize {
        self.wood.indices.len() / 3
    }

    /// Vertices of wood and leaves together, each leaf counted with its own.
    pub fn vertex_count(&self) -> usize {
        self.wood.vertices.len() + self.foliage.vertex_count()
    }
}
