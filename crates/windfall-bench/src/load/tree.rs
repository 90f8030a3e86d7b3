//! The tree that is measured where no file is named: as large as trees that are made for film.

use anyhow::Context;
use windfall_tree::species::grow_as;
use windfall_tree::species::params::Level;
use windfall_tree::{GrowOptions, LeafCount, Species, export_glb};

/// Its leaves.
pub const LEAVES: u32 = 43_000;

/// Segments of the wood, along and around, over those of the built-in oak: about 600,000 triangles.
const FINER: [[u32; 2]; 3] = [[4, 3], [3, 3], [5, 3]];

/// A binary glTF of an oak with [`LEAVES`] cards and about 600,000 triangles of wood, the same on every machine.
pub fn large() -> anyhow::Result<Vec<u8>> {
    let mut params = Species::Oak.params();
    params.name = "large oak";
    let levels = params.levels.iter().zip(FINER);
    let levels: Vec<Level> = levels
        .map(|(&level, [along, around])| Level {
            mesh: [level.mesh[0] * along, level.mesh[1] * around],
            ..level
        })
        .collect();
    params.levels = levels.leak();
    let options = GrowOptions { leaves: LeafCount::Exactly(LEAVES), ..GrowOptions::default() };
    let mut tree = grow_as(&params, 7, &options);
    // Cards, as the leaves of large trees are.
    let cards = tree.foliage.simple_shapes.clone().into_iter();
    tree.foliage.shapes = cards.collect::<Option<_>>().context("leaves without a card")?;
    Ok(export_glb(&tree)?)
}
