//! The wgpu renderer of Windfall.
//!
//! It opens no window and no file, starts no thread and never blocks: the host owns the device,
//! hands in an encoder and a target, and submits. The `windfall` crate's `examples/` folder has a
//! whole host.
#![deny(missing_docs)]

mod arena;
mod capture;
mod cull;
mod events;
mod eye;
mod falls;
mod forest;
mod listed;
mod model;
mod pass;
mod quality;
mod renderer;
mod roster;
#[doc(hidden)]
pub mod shared;
mod strategy;
mod texture;
mod view;

pub use capture::{Capture, CountLeaves, LeafCounts};
pub use events::{DetachEvent, EventError};
pub use falls::Falls;
pub use forest::{FrameStats, GpuForest, TreeCounts};
pub use model::model_bytes;
pub use pass::sky::{SkyPicture, SkyPictureError};
pub use quality::Quality;
pub use renderer::{Canvas, Renderer, Target};
pub use strategy::{Elimination, Strategy, UnknownName};
pub use view::{Camera, Culling, Show, Sky, Trail, View};
pub use wgpu;
pub use wgpu_profiler;
