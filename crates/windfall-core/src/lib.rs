//! The models of Windfall, on the CPU: trees and their leaves, fall paths, flight, wind, forests.
//!
//! Nothing here opens a window, a file or a thread; readers take bytes and writers give bytes. The
//! shaders of `windfall-gpu` are held against this crate: every function that they share with it is
//! the reference there.
//!
//! Units everywhere: metres, seconds, radians; Y is up, right-handed, as in glTF. Colour is linear.
//!
//! | room | what it holds |
//! |---|---|
//! | [`tree`] | a tree model: wood, leaves, materials; glTF in and out; the built-in species |
//! | [`foliage`] | the leaves of a tree: elements, shapes, prune order, shed order |
//! | [`forest`] | terrain and the instances that stand on it |
//! | [`light`] | sky and sun, ambient light, the leaf's scattering |
//! | [`path`] | fall paths: import, analysis, playback |
//! | [`flight`] | flight simulation: where built-in paths come from |
//! | [`wind`] | wind whose displacement is known in closed form |
//! | [`shed`] | when leaves detach |
//! | [`simplify`] | how many leaves of a distant tree are drawn, and what makes up for the others |
//! | [`sway`] | how trees move in the wind |
//! | [`rng`] | the counter-based hash shared with the shaders |
#![deny(missing_docs)]

pub mod error;
pub mod flight;
pub mod foliage;
pub mod forest;
pub mod light;
pub mod path;
pub mod rng;
pub mod shed;
pub mod simplify;
pub mod sway;
pub mod tree;
pub mod wind;

pub use error::{InputError, InputErrorKind};
pub use glam;
