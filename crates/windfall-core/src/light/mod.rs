//! Light: the sky and the sun by a published model, ambient light as spherical harmonics, and what a
//! leaf does to light. The shaders' own [`leaf`] and [`ambient`] are held against this module.
//!
//! Radiance has no absolute unit: outside of the atmosphere the sun's irradiance is
//! [`atmosphere::SOLAR`] in every channel.

pub mod ambient;
pub mod atmosphere;
pub mod leaf;

pub use ambient::Ambient;
pub use atmosphere::{Atmosphere, SkyTable};
