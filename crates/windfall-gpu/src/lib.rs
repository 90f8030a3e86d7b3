//! The wgpu renderer of Windfall: parts that a host composes.
//!
//! It opens no window and no file, starts no thread and never blocks: the host owns the device,
//! hands in an encoder and render passes, and submits. The `windfall` crate's `examples/` folder has
//! whole hosts.
//!
//! | part | what it is |
//! |---|---|
//! | [`Requirements`] | what to ask an adapter for, and what is turned off on it |
//! | [`Renderer`] | pipelines for a device and a kind of target |
//! | [`TreeModel`] | a tree, uploaded once, shared by forests |
//! | [`Forest`] | trees on a terrain that shed their leaves; it may change at any time |
//! | [`ViewState`] | what one view of a forest keeps |
//! | [`View`] | what the host says of a view: camera, light, detail, quality |
//!
//! A frame: [`Renderer::advance`] brings each forest to a moment, [`Renderer::prepare`] records what a view
//! needs, [`Renderer::draw`] draws it in the host's render pass. [`Renderer::render`] is a whole picture of these
//! parts, with ground, sky and tone mapping.
#![deny(missing_docs)]

mod base;
mod counts;
mod frame;
mod pass;
mod renderer;
mod scene;
mod view;

#[doc(hidden)]
pub mod internals;

pub use base::capture::Capture;
pub use base::constants::DebugView;
pub use base::names::UnknownName;
pub use base::requirements::{Requirements, TurnedOff, Unsupported};
pub use base::timing::{TimedPass, Timing};
pub use counts::{CountReadback, Counts, TreeCounts};
pub use frame::{Layer, LayerFrame, Picture, Recording, SceneTextures};
pub use renderer::{DepthOnly, Job, Layers, Options, Renderer, RendererError};
pub use scene::falls::Falls;
pub use scene::forest::{Forest, ForestError, ForestTotals, Moment, TreeId, TreePlace};
pub use scene::model::{ModelError, TreeModel, model_bytes};
pub use scene::sky_map::{SkyMap, SkyPicture, SkyPictureError};
pub use view::budget::FrameBudget;
pub use view::camera::{Camera, Projection, ViewError};
pub use view::culling::Culling;
pub use view::description::{Trail, View};
pub use view::light::{HostCascade, HostLight, HostShadow, Light, Sky};
pub use view::occlusion::OcclusionSwitch;
pub use view::quality::Quality;
pub use view::state::ViewState;
pub use view::targets::PictureTargets;
pub use wgpu;
#[cfg(feature = "profiler")]
pub use wgpu_profiler;
