//! What is exported, and a leaf in a frame.

use glam::{Quat, Vec3};
use std::fmt;
use std::str::FromStr;
use windfall_core::forest::Forest;
use windfall_core::path::{FallSettings, PathSet, Phase, Variation};
use windfall_core::shed::Shedding;
use windfall_core::tree::Tree;
use windfall_core::wind::Wind;

/// A forest and how its leaves fall.
#[derive(Debug, Clone)]
pub struct Source<'a> {
    /// The tree models.
    pub trees: &'a [Tree],
    /// The terrain and the trees on it.
    pub forest: &'a Forest,
    /// The paths. A tree's leaves fall by the group of its model's name, or by the first group.
    pub paths: &'a PathSet,
    /// When leaves detach.
    pub shedding: Shedding,
    /// What carries them.
    pub wind: Wind,
    /// How falls on the same path differ.
    pub variation: Variation,
    /// Start and end of falls.
    pub settings: FallSettings,
    /// Phase of autumn, 0 late summer to 1 bare.
    pub season: f32,
    /// Leaves that detach at a moment of their own. Trees and leaves that there are not are left out.
    pub thrown: Vec<Thrown>,
}

/// A leaf that detaches at a moment of its own, beside the season.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thrown {
    /// Index of the tree.
    pub tree: u32,
    /// Index of the leaf in prune order.
    pub leaf: u32,
    /// When, seconds; the earliest counts, and no time after the season has taken the leaf.
    pub time: f64,
}

/// The frames of an export: `count` of them from `first` on, `fps` a second. Frame `n` is the moment `n / fps`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments {
    /// Number of the first frame.
    pub first: u32,
    /// How many; at least 1.
    pub count: u32,
    /// Frames a second, above 0.
    pub fps: f32,
}

impl Moments {
    /// Numbers of the frames.
    pub fn frames(&self) -> std::ops::Range<u32> {
        self.first..self.first + self.count
    }

    /// Moment of a frame, seconds.
    pub fn time(&self, frame: u32) -> f64 {
        f64::from(frame) / f64::from(self.fps)
    }

    pub(crate) fn last_time(&self) -> f64 {
        self.time(self.first + self.count.max(1) - 1)
    }
}

/// What is exported.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "each is a part of its own")]
pub struct Parts {
    /// Leaves on their twigs.
    pub hanging: bool,
    /// Leaves in the air.
    pub falling: bool,
    /// Leaves on the ground.
    pub landed: bool,
    /// Trunks and branches.
    pub trees: bool,
    /// The terrain.
    pub ground: bool,
}

impl Parts {
    /// Everything.
    pub const ALL: Self =
        Self { hanging: true, falling: true, landed: true, trees: true, ground: true };
    /// Their names on a command line.
    pub const NAMES: [&'static str; 5] = ["hanging", "falling", "landed", "trees", "ground"];

    /// Whether leaves of this phase are exported.
    pub fn shows(self, phase: Phase) -> bool {
        match phase {
            Phase::Hanging => self.hanging,
            Phase::Falling { .. } => self.falling,
            Phase::Landed => self.landed,
        }
    }
}

impl FromStr for Parts {
    type Err = String;

    /// Reads names between commas.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut parts =
            Self { hanging: false, falling: false, landed: false, trees: false, ground: false };
        for name in text.split(',') {
            *match name.trim() {
                "hanging" => &mut parts.hanging,
                "falling" => &mut parts.falling,
                "landed" => &mut parts.landed,
                "trees" => &mut parts.trees,
                "ground" => &mut parts.ground,
                _ => {
                    return Err(format!("{name:?} is none of {}", Self::NAMES.join(", ")));
                }
            } = true;
        }
        Ok(parts)
    }
}

/// Which leaves are exported.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Filter {
    /// By what they are doing. A leaf that is doing so in one of the frames is selected; in the others it is hidden.
    pub parts: Parts,
    /// Those whose centre is in this box, low and high corner, in one of the frames in which they are not hidden.
    pub within: Option<(Vec3, Vec3)>,
    /// At most so many: those that come nearest to the eye while they are not hidden.
    pub most: Option<usize>,
}

impl Filter {
    /// Everything.
    pub const NONE: Self = Self { parts: Parts::ALL, within: None, most: None };

    pub(crate) fn holds(&self, place: Vec3) -> bool {
        self.within.is_none_or(|(low, high)| place.cmpge(low).all() && place.cmple(high).all())
    }
}

/// What tells a leaf from all others of the forest, on its twig, in the air and on the ground: 2³² times the index of
/// its tree plus its index in prune order. Below 2⁴⁹, so that `f64` holds it too.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LeafId(pub u64);

impl LeafId {
    pub(crate) fn new(tree: u32, leaf: u32) -> Self {
        Self(u64::from(tree) << 32 | u64::from(leaf))
    }

    /// Index of the tree.
    pub fn tree(self) -> u32 {
        (self.0 >> 32) as u32
    }

    /// Index of the leaf in prune order.
    pub fn leaf(self) -> u32 {
        self.0 as u32
    }
}

impl fmt::Display for LeafId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// A leaf in a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeafState {
    /// Which leaf.
    pub id: LeafId,
    /// What it is doing.
    pub phase: Phase,
    /// Whether the filter shows leaves that are doing so.
    pub shown: bool,
    /// Centre, in the world, metres.
    pub position: Vec3,
    /// Unit rotation from the leaf's frame into the world's.
    pub orientation: Quat,
    /// Factor on the coordinates of its shape.
    pub scale: f32,
    /// Linear colour that multiplies the material's texture.
    pub color: Vec3,
    /// Phase of autumn, `0..=1`.
    pub season: f32,
}

/// Leaves that share geometry and material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Kind {
    /// Index of the tree model.
    pub model: u32,
    /// Index of the shape.
    pub shape: u32,
    /// Index of the material.
    pub material: u32,
}
