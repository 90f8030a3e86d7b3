//! What `windfall-papers`, tests and tools build on: not part of the interface, may change at any time.
#![allow(missing_docs, reason = "not part of the interface")]

pub use crate::base::capture::Readback;
pub use crate::base::constants;
pub use crate::base::layouts;
pub use crate::base::packing;
pub use crate::base::pipeline::{Depth, Draw, Target};
pub use crate::base::shared::{self, WgslType};
pub use crate::base::wgsl::{Module, Settings, Shaders, compose, text};
pub use crate::pass::MODULES;
pub use crate::pass::leaves::LEAVES;
pub use crate::scene::falls::{EMPTY, storage, zeros};
pub use crate::scene::loose_shapes::{ShapeBuffers, ShapeVertex};
pub use crate::scene::tables::{table_view, tables};
pub use crate::view::cascades::TARGET as SHADOW_TARGET;
pub use crate::view::targets::{DEPTH, RADIANCE, SAMPLES};
