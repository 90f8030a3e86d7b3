//! Flight simulation: where the built-in fall paths come from.
//!
//! [`card`] is the published two-dimensional model of a falling card: it verifies the integrator and
//! the terms that both models share. [`leaf`] is a leaf with six degrees of freedom; [`presets`]
//! are leaves of the built-in species; [`measure`] holds simulated falls against measured ones.

pub mod card;
pub mod leaf;
pub mod measure;
pub mod presets;
pub mod verify;

pub use leaf::{Flight, LeafBody, fall_path};
