//! The built-in species: trees from a table of numbers and a seed.
//!
//! A compact generator in the manner of J. Weber and J. Penn, "Creation and Rendering of Realistic
//! Trees" (SIGGRAPH 95); [`Params`] says where it differs. The numbers of the [`table`] are our own.
//!
//! ```
//! use windfall_tree::Species;
//! let oak = "oak".parse::<Species>()?.grow(7);
//! assert!(oak.height() > 10.0);
//! # Ok::<(), windfall_tree::species::UnknownSpecies>(())
//! ```

mod leaf;
pub mod params;
mod stem;
pub mod table;
#[cfg(test)]
mod tests;

use crate::prepare::{self, Stage, Watch};
use glam::Vec3;
use params::Params;
use std::fmt;
use std::ops::ControlFlow;
use std::str::FromStr;
use windfall_core::foliage::{Foliage, LeafShape};
use windfall_core::material::{Material, Surface};
use windfall_core::rng::Rng;
use windfall_core::simplify::PruneOrder;
use windfall_core::tree::Tree;

/// A built-in species.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Species {
    /// *Quercus robur*: broad and gnarled, big limbs from low on; bronze and brown.
    Oak,
    /// *Acer platanoides*: a round dense crown; yellow, orange and red.
    Maple,
    /// *Betula pendula*: slender and white, fine twigs hang from rising limbs; yellow.
    Birch,
    /// *Fagus sylvatica*: tall and dense, smooth grey; copper.
    Beech,
    /// *Populus tremula*: a straight pale trunk with a narrow crown high up; golden yellow.
    Aspen,
    /// *Ginkgo biloba*: conical, with spurs along few rising limbs; clear gold.
    Ginkgo,
}

/// A name that no built-in species has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownSpecies(
    /// The name as given.
    pub String,
);

impl fmt::Display for UnknownSpecies {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = Species::ALL.map(Species::name).join(", ");
        write!(f, "no species is called \"{}\"; there are {names}", self.0)
    }
}

impl std::error::Error for UnknownSpecies {}

impl FromStr for Species {
    type Err = UnknownSpecies;

    /// The species of a name, in any case.
    fn from_str(name: &str) -> Result<Self, UnknownSpecies> {
        Self::ALL
            .into_iter()
            .find(|s| s.name().eq_ignore_ascii_case(name.trim()))
            .ok_or_else(|| UnknownSpecies(name.to_owned()))
    }
}

impl fmt::Display for Species {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// What other models need to know of a species' real leaf.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeafFacts {
    /// Length of the blade, metres.
    pub length: f32,
    /// Greatest width of the blade over its length.
    pub aspect: f32,
    /// One-sided area of the leaf with its petiole, square metres.
    pub area: f32,
    /// Dry mass per area, kg/m²: 0.051-0.089 by species.
    pub areal_density: f32,
}

impl Species {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Oak, Self::Maple, Self::Birch, Self::Beech, Self::Aspen, Self::Ginkgo];

    /// The common name in lower case, which [`FromStr`] reads.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Oak => "oak",
            Self::Maple => "maple",
            Self::Birch => "birch",
            Self::Beech => "beech",
            Self::Aspen => "aspen",
            Self::Ginkgo => "ginkgo",
        }
    }

    /// The numbers that the generator reads.
    pub fn params(self) -> Params {
        match self {
            Self::Oak => table::oak(),
            Self::Maple => table::maple(),
            Self::Birch => table::birch(),
            Self::Beech => table::beech(),
            Self::Aspen => table::aspen(),
            Self::Ginkgo => table::ginkgo(),
        }
    }

    /// A tree of this species for ordinary scenes: 60,000 to 160,000 vertices. The same seed gives
    /// the same tree.
    pub fn grow(self, seed: u32) -> Tree {
        grow(&self.params(), seed)
    }

    /// A tree of this species with as many leaves as bring [`Tree::vertex_count`] nearest to
    /// `vertices`. Wood is not simplified: below its own count the tree is bare.
    pub fn grow_to(self, seed: u32, vertices: usize) -> Tree {
        let leaves = LeafCount::ForVertices(vertices);
        self.grow_as(seed, &GrowOptions { leaves, ..GrowOptions::default() })
    }

    /// A tree of this species with `count` leaves, whose size makes up for their number
    /// ([`params::Leaves::enlarge_for`]).
    pub fn grow_with(self, seed: u32, count: u32) -> Tree {
        let leaves = LeafCount::Exactly(count);
        self.grow_as(seed, &GrowOptions { leaves, ..GrowOptions::default() })
    }

    /// A tree of this species as `options` say.
    pub fn grow_as(self, seed: u32, options: &GrowOptions) -> Tree {
        grow_as(&self.params(), seed, options)
    }

    /// Facts about the real leaf.
    pub fn leaf_facts(self) -> LeafFacts {
        let leaves = self.params().leaves;
        let blades = leaf::blades(&leaves, &Rng::new(0));
        let wide = leaves.outline.edge.iter().map(|e| e[0]).fold(0.0, f32::max);
        LeafFacts {
            length: leaves.length,
            aspect: 2.0 * wide,
            area: blades.iter().map(|b| b.shape.area()).sum::<f32>() / blades.len() as f32,
            areal_density: leaves.areal_density,
        }
    }
}

/// How many leaves a tree is grown with.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum LeafCount {
    /// As many as the species has ([`params::Leaves::count`]).
    #[default]
    Usual,
    /// This many, whose size makes up for their number ([`params::Leaves::enlarge_for`]).
    Exactly(u32),
    /// As many as bring [`Tree::vertex_count`] nearest to this. Wood is not simplified: below its own count the tree
    /// is bare.
    ForVertices(usize),
}

/// How to grow a tree.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct GrowOptions {
    /// How many leaves it has.
    pub leaves: LeafCount,
    /// Height to scale the tree to, metres, above 0; `None` leaves it as it grew.
    pub height: Option<f32>,
    /// Prune order and its seed; `None` is random, as the leaves are assembled. Chosen here, the crown is measured
    /// once; [`prepare::set_prune_order`] measures it again.
    pub prune_order: Option<(PruneOrder, u32)>,
}

/// Grows a tree with the usual number of leaves and prepares it for drawing. The same parameters and seed give the
/// same tree.
pub fn grow(params: &Params, seed: u32) -> Tree {
    grow_as(params, seed, &GrowOptions::default())
}

/// Mean vertices of the ten tree models of Fichtner, "Stochastic foliage simplification",
/// section 5.
pub const PAPER_VERTICES: usize = 157_368;

/// Ten models of [`PAPER_VERTICES`] vertices each (to half a leaf), for comparison with Fichtner's.
pub fn papers10() -> [Tree; 10] {
    use Species::{Aspen, Beech, Birch, Ginkgo, Maple, Oak};
    let models = [Oak, Oak, Maple, Maple, Birch, Birch, Beech, Beech, Aspen, Ginkgo];
    let mut seed = 0;
    models.map(|species| {
        seed += 1;
        species.grow_to(seed, PAPER_VERTICES)
    })
}

/// Grows a tree as `options` say and prepares it for drawing. The same arguments give the same tree.
pub fn grow_as(params: &Params, seed: u32, options: &GrowOptions) -> Tree {
    match grow_under(params, seed, options, &mut prepare::unwatched) {
        ControlFlow::Continue(tree) => tree,
        ControlFlow::Break(()) => unreachable!("nothing stops it"),
    }
}

/// [`grow_as`] that tells `watch` what it begins to do; `None` if that stops it.
pub fn grow_watched(
    params: &Params,
    seed: u32,
    options: &GrowOptions,
    watch: &mut Watch<'_>,
) -> Option<Tree> {
    grow_under(params, seed, options, watch).continue_value()
}

fn grow_under(
    params: &Params,
    seed: u32,
    options: &GrowOptions,
    watch: &mut Watch<'_>,
) -> ControlFlow<(), Tree> {
    watch(Stage::Parse)?;
    let mut tree = unprepared(params, seed, options.leaves, watch)?;
    let place = |tree: &mut Tree| {
        if let Some(height) = options.height {
            tree.set_height(height);
        }
    };
    prepare::finish(&mut tree, options.prune_order, place, watch)?;
    ControlFlow::Continue(tree)
}

fn unprepared(
    params: &Params,
    seed: u32,
    leaves: LeafCount,
    watch: &mut Watch<'_>,
) -> ControlFlow<(), Tree> {
    let rng = Rng::new(seed).stream(0x7ee5);
    let stems = stem::grow(params, &rng.stream(1));
    let mut wood = stem::mesh(&stems);
    wood.materials = vec![
        Material {
            name: format!("{} bark", params.name),
            base_color: Vec3::ONE,
            roughness: 0.9,
            alpha_cutoff: None,
            surface: Surface::Bark(params.bark),
        },
        Material {
            name: format!("{} twig", params.name),
            base_color: params.twig,
            roughness: 0.8,
            alpha_cutoff: None,
            surface: Surface::Plain,
        },
    ];
    watch(Stage::Leaves)?;
    let blades = leaf::blades(&params.leaves, &rng.stream(2));
    let count = match leaves {
        LeafCount::Usual => params.leaves.count,
        LeafCount::Exactly(count) => count,
        LeafCount::ForVertices(vertices) => {
            let leaf = blades[0].shape.positions.len();
            ((vertices.saturating_sub(wood.vertices.len()) + leaf / 2) / leaf.max(1)) as u32
        }
    };
    let leaves = leaf::place(&params.leaves, count, &blades, &stems, &mut rng.stream(3));
    let shapes: Vec<LeafShape> = blades.into_iter().map(|b| b.shape).collect();
    let material = Material {
        name: format!("{} leaf", params.name),
        base_color: Vec3::ONE,
        roughness: 0.6,
        alpha_cutoff: None,
        surface: Surface::Plain,
    };
    let palette = Some(params.palette.clone());
    let foliage = Foliage::assemble(leaves, shapes, vec![material], palette, seed);
    ControlFlow::Continue(Tree { name: params.name.to_owned(), wood, foliage })
}
