//! What a species is made of: the numbers that the generator reads.
//!
//! The scheme is Weber & Penn's ("Creation and Rendering of Realistic Trees", SIGGRAPH 95): a tree
//! is a hierarchy of stems, and each level of it has angles, lengths, curvature and taper of its
//! own. Three things differ. Lengths along the parent are given at three places instead of by a
//! named shape function, so that the silhouette can be read off the table; stems are spaced per
//! metre, so that a short parent bears few; and curvature is a tropism plus a wandering that
//! returns to its heading, which makes limbs gnarled without letting them stray.

use glam::Vec3;
use windfall_core::foliage::Palette;
use windfall_core::material::Bark;

/// A species, or any other tree that the generator can grow.
#[derive(Debug, Clone, PartialEq)]
pub struct Params {
    /// Name that the tree carries.
    pub name: &'static str,
    /// The trunk.
    pub trunk: Trunk,
    /// Limbs, branches and twigs: what the trunk bears, what that bears, and so on. Two to four.
    pub levels: &'static [Level],
    /// The leaves, which the last level bears.
    pub leaves: Leaves,
    /// Bark of trunk and limbs.
    pub bark: Bark,
    /// Linear colour of stems too thin for bark.
    pub twig: Vec3,
    /// Colours through autumn.
    pub palette: Palette,
}

/// The trunk: a stem that starts in the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trunk {
    /// Length above the ground, metres. The crown reaches higher where limbs rise past the end.
    pub length: f32,
    /// Share by which length and girth vary from tree to tree, `0..1`.
    pub vary: f32,
    /// Radius above the root flare, metres.
    pub radius: f32,
    /// Exponent of the taper: 1 is a cone, less keeps the trunk stout for longer, above 0.
    pub taper: f32,
    /// Deviation of the trunk from its heading, degrees.
    pub wander: f32,
    /// Lean from the vertical, degrees, standard deviation.
    pub lean: f32,
    /// Root flare: share by which the foot is wider, 0 and up.
    pub flare: f32,
    /// Segments along and around; at least 1 and 3.
    pub mesh: [u32; 2],
}

/// One level of stems.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level {
    /// Stems per metre of the part of the parent that bears them.
    pub density: f32,
    /// Where on the parent the first stem grows, as a share of the parent's length, `0..1`.
    pub from: f32,
    /// Angle from the parent's axis at the first and at the last stem, degrees.
    pub angle: [f32; 2],
    /// Length at the first stem, half way and at the last, as shares of the parent's length.
    pub length: [f32; 3],
    /// Share by which angle and length vary from stem to stem, `0..1`.
    pub vary: f32,
    /// How far stems lie to the left and right of their parent (1) rather than all around it (0).
    pub flat: f32,
    /// Tropism at the foot and at the tip: radians by which a level stem would turn upwards along
    /// its length; negative droops.
    pub lift: [f32; 2],
    /// Deviation from the heading, degrees: how gnarled a stem is.
    pub wander: f32,
    /// Exponent of the radius over the length, relative to the parent's (Weber & Penn's
    /// `RatioPower`).
    pub power: f32,
    /// Exponent of the taper, as [`Trunk::taper`].
    pub taper: f32,
    /// Segments along and around; at least 1 and 3.
    pub mesh: [u32; 2],
}

/// The leaves of a species.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leaves {
    /// How many an ordinary model has.
    pub count: u32,
    /// Length of the blade of a real leaf, metres.
    pub length: f32,
    /// Factor on the length at `count` leaves: real trees have ten times as many, and the crown
    /// must close all the same. Other counts keep the area (see [`Self::enlarge_for`]).
    pub enlarge: f32,
    /// Leaves at one node of the twig: 1 alternate, 2 opposite, more on spurs.
    pub per_node: u32,
    /// Petiole in lengths of the blade; 0 draws none.
    pub petiole: f32,
    /// Angle between leaf and twig, degrees.
    pub angle: f32,
    /// How much the tip turns to the ground, 0 not at all, 1 hangs.
    pub droop: f32,
    /// Scatter of the upper side's direction about the light's, as a share of it.
    pub scatter: f32,
    /// Dry mass per area, kg/m².
    pub areal_density: f32,
    /// The right half of the blade's outline.
    pub outline: Outline,
}

/// The right half of a leaf, in lengths of the blade; the left half mirrors it.
///
/// `x` is the distance from the midrib and `z` runs along it to the tip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outline {
    /// Places on the midrib: first where the petiole joins, last the end of the midrib.
    pub midrib: &'static [f32],
    /// Points `[x, z]` of the edge from petiole to tip, without the midrib's ends; `x > 0`.
    pub edge: &'static [[f32; 2]],
    /// Angle by which each half is folded up from flat, degrees.
    pub fold: f32,
    /// Angle by which the blade bends down from petiole to tip, degrees.
    pub curl: f32,
}

impl Leaves {
    /// Factor on the real length at which `count` leaves cover what [`Self::count`] enlarged ones
    /// do. Never below 1: beyond that the crown gets denser instead.
    pub fn enlarge_for(&self, count: u32) -> f32 {
        (self.enlarge * (self.count as f32 / count.max(1) as f32).sqrt()).clamp(1.0, 4.0)
    }
}

/// Linear light from a colour of sRGB, `0xRRGGBB`; the exact transfer function of IEC 61966-2-1.
pub fn srgb(hex: u32) -> Vec3 {
    let channel = |shift: u32| {
        let c = ((hex >> shift) & 0xff) as f32 / 255.0;
        if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    };
    Vec3::new(channel(16), channel(8), channel(0))
}
