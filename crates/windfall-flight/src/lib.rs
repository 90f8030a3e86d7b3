//! Fall paths before run time: simulated, imported, analysed, and as text.
//!
//! A fall path is a short recording of a falling leaf that serves any number of leaves (`windfall_core::path`). It
//! comes from a file ([`import()`]), from raw samples ([`fall_path`]) or from the flight simulation
//! ([`simulated_path`]); [`analyse`] finds where leaves may start on it and where playback may jump back.
//!
//! | module | what it holds |
//! |---|---|
//! | [`analysis`] | starting points and joints of a recording |
//! | [`mod@import`] | paths from CSV, JSON and glTF animations |
//! | [`read_paths`], [`to_ron`] | path sets in binary and RON form |
//! | [`leaf`] | a leaf with six degrees of freedom |
//! | [`presets`] | leaves of the built-in species |
//! | [`builtin`] | simulates the paths that come with the library |
//! | [`card`] | the published two-dimensional model of a falling card, which verifies the integrator and the terms that both models share |
//! | [`measure`], [`verify`] | figures of simulated falls against published ones |
#![deny(missing_docs)]

pub mod analysis;
pub mod builtin;
pub mod card;
pub mod import;
pub mod leaf;
pub mod measure;
mod path_set;
pub mod presets;
pub mod verify;

pub use analysis::{analyse, fall_path};
pub use import::{
    ImportOptions, Imported, Note, NoteCode, Resolve, TimeUnit, Up, import, import_with,
};
pub use leaf::{Flight, LeafBody, simulated_path};
pub use path_set::{read_paths, to_ron};
