//! Stochastic simplification: how many leaves of a tree are drawn, and what makes up for the others.
//!
//! S. Fichtner, "GPU Based Stochastic Foliage Simplification" (SFS), after R. L. Cook et al.,
//! "Stochastic Simplification of Aggregate Detail", SIGGRAPH 2007. A tree far away draws the first
//! `λN` of its `N` leaves in prune order, larger and with less contrast. [`Simplification::level`] is
//! the reference for the shaders.

mod level;
mod order;
mod shape;
mod wood;

pub use crate::foliage::{Shading, Visibility, area_scale, share_for};
pub use level::{Level, Seen, contrast, variance_left};
pub use order::{PruneOrder, UnknownPruneOrder};
pub use shape::{LIT_AT_VERTICES, LeafForm, SHADE_SPREAD, as_quad};
pub use wood::{Branch, WOOD_FADE, WoodLevel};

use serde::{Deserialize, Serialize};

/// How foliage is simplified.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Simplification {
    /// Where the share `b` of a tree's size in the picture comes from.
    pub reduction: Reduction,
    /// The `b` at which half of the leaves are drawn (SFS, equation 2), `0..1`. 0 draws all of them
    /// at any distance; ½ gives `λ = b`; above ½ leaves grow in the picture as the tree shrinks.
    pub h: f32,
    /// Whether survivors grow (SFS, equation 3).
    pub area_preservation: bool,
    /// How far they may.
    pub growth: Growth,
    /// Whether colours draw together towards the tree's mean (SFS, equation 4).
    pub color_contrast: bool,
    /// Whether shading draws together towards its mean (SFS, 4.3.2).
    pub shading_contrast: bool,
    /// The mean of the cosine between a leaf and the light, `0..=1`, towards which shading draws
    /// together, half of the leaves lit from the viewer's side. `None`, the default, is what each
    /// tree's own leaves have in the light and the view ([`Shading::mean_cosines`]);
    /// [`Simplification::PAPER_COSINE`] is the mean of SFS.
    pub mean_cosine: Option<f32>,
    /// Side of the squares of pixels that are seen as one, pixels, above 0: contrasts are drawn together by as
    /// much as their means are ([`contrast`]). 1, the default, for pictures that are shown as they are drawn; 2
    /// for one that is halved before. `None` is SFS's equation 4, `√λ`, whatever the size of leaves.
    pub contrast_pixels: Option<f32>,
    /// How leaves appear and vanish.
    pub fade: Fade,
    /// How far the surface of simplified wood may be from its place in the picture, pixels; 0 keeps
    /// the wood as it is. Branches thinner than twice that are drawn as wide, and fewer
    /// ([`Branch::widening`]): at half a pixel no change is seen.
    pub wood_pixels: f32,
    /// Length in the picture, as it is drawn, below which a leaf is drawn in two triangles and lit once, pixels; up
    /// to [`LIT_AT_VERTICES`] times the length its outline is lit at its vertices, beyond in each pixel
    /// ([`LeafForm`]). 0 draws all outlines, lit in pixels, at any distance. Safe: 6 to 10.
    pub leaf_pixels: f32,
}

/// How the share `b` of a tree's size in the picture is found (SFS, 3.1).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Reduction {
    /// `b = d0²/d²`, equation 1.
    Distance {
        /// Distance up to which trees are drawn in full, metres, above 0.
        d0: f32,
    },
    /// `b = B/B0`, the area of the tree's bounding sphere in the picture.
    ProjectedArea {
        /// Pixels above which trees are drawn in full, above 0.
        b0: f32,
    },
}

/// A bound on the growth of leaves, so that none is seen as a balloon. Where a tree would need more,
/// more of its leaves are drawn instead.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Growth {
    /// Factor on a leaf's length that is always allowed, at least 1; infinity sets no bound.
    pub factor: f32,
    /// Size in the picture up to which a leaf may grow by any factor, pixels.
    pub pixels: f32,
}

/// How leaves appear and vanish as `λ` changes (SFS, equation 6 and 4.3.3).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Fade {
    /// What fades.
    pub by: FadeBy,
    /// `R`, half the range of ranks over which leaves fade.
    pub range: FadeRange,
    /// Whether `R` is at most `1 - λ`, so that a tree in full has no leaf that is partly faded.
    pub full_at_one: bool,
    /// Whether leaves are gone at rank `λ` instead of `λ + R`: fewer leaves are drawn, and the tree
    /// is thinner than it should be.
    pub early: bool,
    /// Whether the fade eases in and out instead of going straight.
    pub smooth: bool,
}

/// What fades.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum FadeBy {
    /// The leaf's area.
    Size,
    /// Its coverage: a hashed share of samples, the same whatever is drawn first.
    Opacity,
}

/// `R` as a function of `λ` (SFS, 4.3.3), with its constant.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum FadeRange {
    /// `R = c`, as in Cook et al. with `c = 0.1`.
    Constant(f32),
    /// `R = c (1 - λ)`.
    Linear(f32),
    /// `R = c (1 - λ)²`.
    Quadratic(f32),
    /// `R = c λ`.
    Proportional(f32),
}

impl Simplification {
    /// `E(cos)` of SFS, equation 5: the mean over angles.
    pub const PAPER_COSINE: f32 = std::f32::consts::FRAC_2_PI;

    /// Full up to 30 m, then as many leaves as the tree has pixels.
    pub const DEFAULT: Self = Self {
        reduction: Reduction::Distance { d0: 30.0 },
        h: 0.5,
        area_preservation: true,
        growth: Growth { factor: 2.0, pixels: 4.0 },
        color_contrast: true,
        shading_contrast: true,
        mean_cosine: None,
        contrast_pixels: Some(1.0),
        fade: Fade {
            by: FadeBy::Size,
            range: FadeRange::Proportional(0.2),
            full_at_one: true,
            early: false,
            smooth: false,
        },
        wood_pixels: 0.5,
        leaf_pixels: 10.0,
    };

    /// Nothing is simplified.
    pub const NONE: Self = Self { h: 0.0, wood_pixels: 0.0, leaf_pixels: 0.0, ..Self::DEFAULT };
}

impl Default for Simplification {
    /// [`Simplification::DEFAULT`].
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Growth {
    /// Leaves grow as equation 3 says.
    pub const UNBOUNDED: Self = Self { factor: f32::INFINITY, pixels: f32::INFINITY };
}

impl Default for Growth {
    fn default() -> Self {
        Simplification::DEFAULT.growth
    }
}

impl Default for Fade {
    /// That of SFS: `R` a fraction of `λ`, 0 at `λ = 1`; by size.
    fn default() -> Self {
        Simplification::DEFAULT.fade
    }
}
