//! What a host of Windfall needs at run time: data types, and the closed-form models that the shaders mirror.
//!
//! Nothing here opens a window, a file or a thread, or reads a clock. Trees and fall paths come prepared from the
//! crates `windfall-tree` and `windfall-flight`. The shaders of `windfall-gpu` are tested against this crate:
//! whatever both compute, this crate is the reference for.
//!
//! Units everywhere: metres, seconds, radians; Y is up, right-handed, as in glTF. Colour is linear.
//!
//! Modules, each of which imports only from those above it:
//!
//! | module | what it holds |
//! |---|---|
//! | [`error`] | one error type for everything that is read |
//! | [`note`] | remarks on what was read |
//! | [`rng`] | the counter-based hash shared with the shaders |
//! | [`wind`] | wind whose displacement is known in closed form |
//! | [`sway`] | how trees move in the wind |
//! | [`light`] | sky and sun, ambient light, scattering by a leaf |
//! | [`forest`] | terrain and the trees that stand on it |
//! | [`shed`] | when leaves detach |
//! | [`material`] | how surfaces look |
//! | [`foliage`] | the leaves of a tree: elements, shapes, prune order, shed order, colour in autumn |
//! | [`path`] | fall paths: storage, playback, landing |
//! | [`simplify`] | how many leaves of a distant tree are drawn, and what makes up for the others |
//! | [`tree`] | a tree model: wood and leaves |
#![deny(missing_docs)]

pub mod error;
pub mod foliage;
pub mod forest;
pub mod light;
pub mod material;
pub mod note;
pub mod path;
pub mod rng;
pub mod shed;
pub mod simplify;
pub mod sway;
pub mod tree;
pub mod wind;

pub use error::{InputError, InputErrorKind};
pub use glam;
pub use note::{Note, NoteCode};
