//! Prepares a tree for drawing: measures its crown and simplifies its wood, so that the renderer computes nothing.
//!
//! [`prepare`] computes
//!
//! | what | from |
//! |---|---|
//! | [`Leaf::ambient`] | [`openness`] |
//! | [`Foliage::shading`] | [`shading`] |
//! | [`Foliage::simple_shapes`] | [`simple_shapes`] |
//! | [`Foliage::visibility`] | [`visibility`], in the prune order that the leaves have |
//! | [`Wood::levels`], [`Wood::branches`], [`Wood::outward`] | [`prepare_wood`] |
//!
//! Trees that this crate imports or grows are prepared already. A tree assembled by hand ([`Foliage::assemble`]) is
//! drawn in full until it is prepared. After editing leaves or wood, prepare the tree again; after moving or scaling
//! it, there is no need.
//!
//! [`Leaf::ambient`]: windfall_core::foliage::Leaf::ambient
//! [`Wood::levels`]: windfall_core::tree::Wood::levels
//! [`Wood::branches`]: windfall_core::tree::Wood::branches
//! [`Wood::outward`]: windfall_core::tree::Wood::outward

mod film;
mod nearest;
mod order;
mod shading;
mod simple_shapes;
mod sunlight;
mod visibility;
mod wood;

pub use order::set_prune_order;
pub use shading::shading;
pub use simple_shapes::simple_shapes;
pub use visibility::{openness, sides, visibility, visible_areas};
pub use wood::prepare_wood;

use std::ops::ControlFlow;
use windfall_core::foliage::Foliage;
use windfall_core::simplify::PruneOrder;
use windfall_core::tree::Tree;

/// Whether meshes can be simplified: not in browsers, where meshoptimizer (C++) is not built, and no crate in Rust keeps
/// seams and normals as it does.
pub const SIMPLIFIES: bool = cfg!(not(target_arch = "wasm32"));

/// What is being done to a tree: the stages, in their order. Some come again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Stage {
    /// The file is read, or the stems are grown.
    Parse,
    /// Leaves are found, or placed.
    Leaves,
    /// The crown is looked at: visibility, ambient occlusion, mean shading.
    Visibility,
    /// Leaf shapes in two triangles.
    Shapes,
    /// The leaves are put into their prune order.
    Order,
    /// Branches, and levels of the wood.
    Wood,
}

impl Stage {
    /// All of them, in their order.
    pub const ALL: [Self; 6] =
        [Self::Parse, Self::Leaves, Self::Visibility, Self::Shapes, Self::Order, Self::Wood];

    /// Its name for people.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Parse => "parse",
            Self::Leaves => "leaves",
            Self::Visibility => "visibility",
            Self::Shapes => "shapes",
            Self::Order => "order",
            Self::Wood => "wood",
        }
    }
}

/// Is told when a stage begins, and says whether to go on: for progress bars, measurements, and to stop what nobody
/// waits for any more.
pub type Watch<'a> = dyn FnMut(Stage) -> ControlFlow<()> + 'a;

/// A [`Watch`] that looks away.
pub(crate) fn unwatched(_: Stage) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Prepares a tree in the prune order that its leaves have.
pub fn prepare(tree: &mut Tree) {
    let _ = finish(tree, None, |_| {}, &mut unwatched);
}

/// Prepares a tree and puts its leaves into a prune order: [`prepare`] and [`set_prune_order`], with the visibility
/// measured once.
pub fn prepare_in_order(tree: &mut Tree, order: PruneOrder, seed: u32) {
    let _ = finish(tree, Some((order, seed)), |_| {}, &mut unwatched);
}

/// Prepares a tree in a prune order with its seed, or in the order that its leaves have; `place` moves and scales it.
///
/// What does not depend on the prune order is measured before the leaves are reordered or moved. Rounding, and the
/// winner among leaves at the same depth, depend on both; a tree's shading must not. A tree that `watch` stops is half
/// prepared.
pub(crate) fn finish(
    tree: &mut Tree,
    order: Option<(PruneOrder, u32)>,
    place: impl FnOnce(&mut Tree),
    watch: &mut Watch<'_>,
) -> ControlFlow<()> {
    watch(Stage::Visibility)?;
    let foliage = &mut tree.foliage;
    let open = openness(foliage);
    for (leaf, open) in foliage.leaves.iter_mut().zip(open) {
        leaf.ambient = open;
    }
    foliage.shading = shading(foliage);
    watch(Stage::Shapes)?;
    foliage.simple_shapes = simple_shapes(foliage);
    if order.is_none() {
        watch(Stage::Visibility)?;
        measure_visibility(foliage);
    }
    place(tree);
    if let Some((order, seed)) = order {
        watch(Stage::Order)?;
        order::reorder(&mut tree.foliage, order, seed);
        watch(Stage::Visibility)?;
        measure_visibility(&mut tree.foliage);
    }
    watch(Stage::Wood)?;
    prepare_wood(&mut tree.wood);
    ControlFlow::Continue(())
}

fn measure_visibility(foliage: &mut Foliage) {
    foliage.visibility = visibility(foliage);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Species;
    use windfall_core::foliage::Foliage;
    use windfall_core::simplify::{Shading, Visibility};
    use windfall_core::tree::Wood;

    /// A birch as it was before it was prepared.
    fn bare() -> Tree {
        let tree = Species::Birch.grow_with(2, 600);
        let Foliage { leaves, shapes, materials, palette, .. } = tree.foliage;
        let foliage = Foliage::assemble(leaves, shapes, materials, palette, 8);
        let Wood { vertices, indices, materials, .. } = tree.wood;
        let wood = Wood { vertices, indices, materials, ..Wood::default() };
        Tree { wood, foliage, ..tree }
    }

    #[test]
    fn a_prepared_tree_has_all_that_the_renderer_draws_from() {
        let mut tree = bare();
        let foliage = &tree.foliage;
        assert_eq!((foliage.visibility, foliage.shading), <(Visibility, Shading)>::default());
        assert!(foliage.simple_shapes.is_empty() && tree.wood.levels.is_empty());
        prepare(&mut tree);
        let foliage = &tree.foliage;
        assert_eq!(foliage.visibility, visibility(foliage));
        assert_eq!(foliage.shading, shading(foliage));
        assert_eq!(foliage.simple_shapes, simple_shapes(foliage));
        assert_eq!(foliage.simple_shapes.len(), foliage.shapes.len());
        let ambient: Vec<f32> = foliage.leaves.iter().map(|leaf| leaf.ambient).collect();
        assert_eq!(ambient, openness(foliage));
        assert_eq!(tree.wood.branches.len(), tree.wood.vertices.len());
        assert_eq!(tree.wood.levels[0].indices, tree.wood.indices);
        assert!(tree.wood.outward);
    }

    #[test]
    fn a_tree_that_is_prepared_again_stays_as_it_is() {
        let mut tree = bare();
        prepare_in_order(&mut tree, PruneOrder::BlueNoise, 3);
        let once = tree.clone();
        prepare(&mut tree);
        assert_eq!(tree.foliage.visibility, once.foliage.visibility);
        assert_eq!(tree.foliage.simple_shapes, once.foliage.simple_shapes);
        assert_eq!(tree.wood.levels, once.wood.levels);
        assert_eq!(tree.wood.branches, once.wood.branches);
    }

    #[test]
    fn the_visibility_is_that_of_the_prune_order() {
        let mut tree = bare();
        prepare(&mut tree);
        let random = tree.foliage.visibility;
        prepare_in_order(&mut tree, PruneOrder::Importance, 3);
        assert_eq!(tree.foliage.visibility, visibility(&tree.foliage));
        // Those that are seen most come first: they cover more, and need to grow less.
        assert!(tree.foliage.visibility.disocclusion[0] < random.disocclusion[0]);
    }

    #[test]
    fn nothing_is_prepared_without_a_panic() {
        let (wood, foliage) = (Wood::default(), Foliage::default());
        let mut tree = Tree { name: String::new(), wood, foliage };
        for order in PruneOrder::ALL {
            prepare_in_order(&mut tree, order, 1);
        }
        assert_eq!(tree.wood.levels.len(), 1);
    }
}
