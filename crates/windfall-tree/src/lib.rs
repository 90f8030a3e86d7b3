//! Trees before run time: glTF in and out, the built-in species, and what the renderer needs of each.
//!
//! Every tree that [`import()`] or a [`Species`] gives is prepared for drawing ([`mod@prepare`]): the renderer measures
//! and simplifies nothing. Nothing here opens a file; readers take bytes and writers give bytes.
//!
//! | module | what it holds |
//! |---|---|
//! | [`import()`] | trees from glTF 2.0, checked strictly |
//! | [`export_glb`] | trees as plain glTF 2.0 |
//! | [`mod@bake`] | prepared trees in files that load without preparing them again |
//! | [`Inspection`] | the figures of a tree |
//! | [`species`] | the built-in species |
//! | [`mod@prepare`] | visibility, shading, prune orders, simple shapes, levels of the wood |
#![deny(missing_docs)]

pub mod bake;
mod export;
mod import;
mod inspect;
mod leaves;
mod parallel;
pub mod prepare;
pub mod species;

pub use bake::{BakedTree, bake};
pub use export::{ExportError, export_glb, export_glb_in_prune_order};
pub use import::{
    Import, ImportOptions, Part, Resolve, Survey, Up, Use, import, import_watched, survey,
};
pub use inspect::{Inspection, TextureInspection};
pub use prepare::{prepare, prepare_in_order, set_prune_order};
pub use species::{GrowOptions, LeafCount, Species};
