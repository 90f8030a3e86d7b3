//! Leaves and trees of a forest, written for other programs.
//!
//! Every pose is that of the CPU reference ([`windfall_core::path::Fall`]) at the moment of a frame, so that any
//! machine writes the same bytes. Trees stand still: neither wood nor hanging leaves sway. Nothing here opens a file:
//! writers write to what the caller hands in, a frame at a time.
//!
//! | module | what it does |
//! |---|---|
//! | [`frame`] | what is exported, and a leaf in a frame |
//! | [`selection`] | which leaves are exported, and where each is at a moment |
//! | [`table`] | poses as a table, CSV or Parquet |
//! | [`gltf`] | glTF: animated nodes, or instances of one moment |
//! | [`usd`] | Universal Scene Description |
//! | [`vat`] | vertex animation textures |
//!
//! ```
//! use windfall_core::forest::{Placement, Terrain};
//! use windfall_core::glam::DVec3;
//! use windfall_core::path::{FallSettings, PathSet, Variation};
//! use windfall_core::{shed::Shedding, wind::Wind};
//! use windfall_export::{Filter, Moments, Selection, Source, usd};
//! # let mut birch = windfall_tree::Species::Birch.grow(1);
//! # birch.foliage.truncate(100);
//!
//! let trees = [birch];
//! let placement = Placement { trees: 2, ..Placement::default() };
//! let forest = placement.place(Terrain::flat(), &[1.0]);
//! let paths = PathSet::builtin();
//! let source = Source {
//!     trees: &trees,
//!     forest: &forest,
//!     paths: &paths,
//!     shedding: Shedding::default(),
//!     wind: Wind::new(1.2, 0.6, 0.6, 1),
//!     variation: Variation::default(),
//!     settings: FallSettings::default(),
//!     season: 0.6,
//!     thrown: Vec::new(),
//! };
//! let moments = Moments { first: 0, count: 24, fps: 24.0 };
//! let filter = Filter { parts: "falling,landed".parse()?, ..Filter::NONE };
//! let selection = Selection::new(&source, moments, filter, &|_| DVec3::ZERO);
//! let mut file = Vec::new();
//! usd::write_usda(&selection, "./textures", &mut file, &mut |_| ())?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![deny(missing_docs)]

pub mod frame;
pub mod gltf;
mod mesh;
pub mod selection;
mod shade;
pub mod table;
pub mod usd;
pub mod vat;

pub use frame::{Filter, LeafId, LeafState, Moments, Parts, Source, Thrown};
pub use selection::Selection;

use windfall_core::material::{Material, Surface};

/// Why nothing could be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The output cannot be written.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// A Parquet file cannot be written.
    #[error(transparent)]
    Parquet(#[from] parquet::errors::ParquetError),
    /// More leaves than the format is for.
    #[error(
        "{leaves} leaves are more than the {most} that {format} takes; --most {most} keeps the nearest"
    )]
    TooManyLeaves {
        /// Leaves selected.
        leaves: usize,
        /// Most of them.
        most: usize,
        /// What they were to be written as.
        format: &'static str,
    },
    /// More frames than a texture has rows.
    #[error("{0} frames are more than the 16384 rows that a texture may have")]
    TooManyFrames(u32),
    /// The file would be larger than the 4 GiB that a GLB may have.
    #[error(
        "the file would take {0} bytes; a GLB may have 4 GiB: fewer frames, or --most N, make it smaller"
    )]
    TooLarge(u64),
    /// Leaves that move have no moment to be still in.
    #[error("no leaf is selected: {0}")]
    Nothing(String),
    /// A picture could not be encoded.
    #[error("the picture of material \"{material}\" cannot be encoded: {cause}")]
    Picture {
        /// Name of the material.
        material: String,
        /// What the encoder says.
        cause: png::EncodingError,
    },
}

/// Linear colour of the ground, as other programs show it: bare soil.
const GROUND_COLOR: glam::Vec3 = glam::Vec3::new(0.16, 0.12, 0.07);

/// Linear colour of a material where nothing draws its texture or bark.
fn plain_color(material: &Material) -> glam::Vec3 {
    let own = match &material.surface {
        Surface::Bark(bark) => (bark.ridge + bark.groove) / 2.0,
        Surface::Plain | Surface::Texture(..) => glam::Vec3::ONE,
    };
    (material.base_color * own).clamp(glam::Vec3::ZERO, glam::Vec3::ONE)
}

/// Linear colour of leaves with a palette in the middle of the scene's season; white for others.
fn season_color(foliage: &windfall_core::foliage::Foliage, season: f32) -> glam::Vec3 {
    foliage.palette.as_ref().map_or(glam::Vec3::ONE, |palette| palette.color(season))
}

/// A tree's name without its folder and extension: it may be that of a file.
fn short_name(name: &str) -> &str {
    let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
    file.rsplit_once('.').map_or(file, |(stem, _)| stem)
}
