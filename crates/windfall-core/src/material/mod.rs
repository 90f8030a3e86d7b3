//! Materials: how the surface of wood or of a leaf looks.

mod mask;

pub use mask::{Holes, Mask};

use glam::Vec3;

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
    /// A texture, repeated (`true`) or clamped (`false`) beyond its edges.
    Texture(Image, bool),
    /// Bark, drawn by the shader.
    Bark(Bark),
}

/// Bark without a texture: two colours and a pattern that the shader draws.
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

/// An image: rows from the top, four bytes a pixel, sRGB colour with straight alpha.
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
