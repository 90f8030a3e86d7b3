//! Baked trees: a prepared tree in a file that loads without preparing it again.
//!
//! A baked tree is a binary glTF. Any viewer shows its wood and its leaves; Windfall reads its own arrays, which stand
//! beside them under the extension [`EXTENSION`] of the file's root. [`bake()`] writes one, and [`crate::import()`]
//! recognises one by itself; [`BakedTree::read`] reads nothing else. Every array comes back bit for bit.
//!
//! | member of the extension | what it holds |
//! |---|---|
//! | `version` | [`VERSION`] |
//! | `digest` | hash (BLAKE3) of the whole file, in which these 64 characters are `0`: a damaged file is refused |
//! | `source` | hash of what was baked and with which options: [`SourceHash`] |
//! | `pruneOrder` | the prune order and its seed, if it is known |
//! | `notes` | what there was to say about the source, without its name |
//! | `name` | the tree's name |
//! | `wood`, `leaves` | small values, and the buffer views of the arrays (the module `format` says which) |
//!
//! Views of the extension lie in the binary chunk, little-endian, without padding between elements.

mod check;
mod digest;
mod format;
mod read;
mod records;
mod source;
mod write;

pub(crate) use read::read;
pub use source::SourceHash;
pub use write::{Viewers, bake};

use crate::export::ExportError;
use windfall_core::Note;
use windfall_core::simplify::PruneOrder;
use windfall_core::tree::Tree;

/// Name of the glTF extension.
pub const EXTENSION: &str = "WINDFALL_baked_tree";

/// The version of the format that is written, and the only one that is read.
pub const VERSION: u32 = 1;

/// A fingerprint of the code that prepares trees: what another build has prepared may differ. For the keys of caches.
pub const PREPARATION: &str = env!("WINDFALL_PREPARATION");

/// Puts the right digest into a file that was changed: for tests and fuzz targets, which look behind it.
#[doc(hidden)]
pub fn reseal(bytes: &mut [u8]) {
    digest::reseal(bytes);
}

/// A tree that was read from a baked file.
#[derive(Debug, Clone)]
pub struct BakedTree {
    /// The tree, as it was baked.
    pub tree: Tree,
    /// What it was made of.
    pub about: About,
}

/// Where a baked tree comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct About {
    /// Hash of the source and of the options.
    pub source: SourceHash,
    /// The prune order of its leaves and the seed of that; `None`: random, as the leaves were assembled.
    pub prune_order: Option<(PruneOrder, u32)>,
    /// What there was to say about the source ([`crate::Import::notes`]). The file does not keep the source's name: read
    /// back, the notes are of the baked file.
    pub notes: Vec<Note>,
}

/// Why a tree could not be baked.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BakeError {
    /// Something that [`crate::prepare()`] computes is missing.
    #[error("the tree has not been prepared: it has no {missing}")]
    NotPrepared {
        /// What is missing.
        missing: &'static str,
    },
    /// A value that no reader would take: not finite, or out of range.
    #[error("{place}: {cause}")]
    Unfit {
        /// Which part of the tree.
        place: String,
        /// What is wrong with it.
        cause: String,
    },
    /// The file cannot be written.
    #[error(transparent)]
    Export(#[from] ExportError),
}
