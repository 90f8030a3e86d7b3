//! Forests that shed their leaves, in real time, on any GPU: the library of Windfall.
//!
//! It opens no window and no file and starts no thread: the host owns the device, hands in bytes and an
//! encoder, and submits what was recorded.
//!
//! | crate | here | what it holds |
//! |---|---|---|
//! | `windfall-core` | [`forest`], [`foliage`], [`path`], [`shed`], [`simplify`], [`wind`], ... | what a host needs at run time: the models that the shaders mirror |
//! | `windfall-tree` | [`tree`] | trees before run time: glTF in and out, species, preparation |
//! | `windfall-flight` | [`flight`] | fall paths before run time: simulation, import, analysis |
//! | `windfall-gpu` | the root | the renderer: parts that a host composes |
//!
//! Units everywhere: metres, seconds, radians; Y is up, right-handed, as in glTF. Colour is linear.
//! World positions and times are double precision. Every picture is a pure function of the forest, its seeds,
//! the moment and the [`View`]: moments can be drawn in any order.
//!
//! # From a tree to a picture
//!
//! ```no_run
//! use windfall::forest::{Placement, Terrain};
//! use windfall::glam::DVec3;
//! use windfall::tree::Species;
//! use windfall::{
//!     Camera, Falls, Forest, Moment, Options, Picture, Recording, Renderer, TreeModel, View, wgpu,
//! };
//!
//! # fn host(device: &wgpu::Device, queue: &wgpu::Queue, output: &wgpu::TextureView)
//! # -> Result<(), Box<dyn std::error::Error>> {
//! // Once: pipelines, two tree models, a forest of 300 trees, and what one view of it keeps.
//! let renderer = Renderer::new(device, &Options::picture(wgpu::TextureFormat::Rgba8UnormSrgb))?;
//! let models = [
//!     TreeModel::new(device, queue, &Species::Birch.grow(1))?,
//!     TreeModel::new(device, queue, &Species::Oak.grow(2))?,
//! ];
//! let placement = Placement {
//!     trees: 300,
//!     spacing: 6.0,
//!     keep_out: Vec::new(),
//!     scale: (0.8, 1.2),
//!     season_spread: 0.1,
//!     seed: 7,
//! };
//! let placed = placement.place(Terrain::rolling(300.0, 2.0, 7), &[1.0, 1.0]);
//! let mut forest = Forest::new(device, DVec3::ZERO, placed.terrain.clone(), Falls::default())?;
//! let trees = forest.plant(&models, &placed.instances)?;
//! let mut view_state = renderer.view(&forest);
//! let targets = renderer.targets(1280, 720)?;
//!
//! // Every frame: the forest's moment, and a view of it, recorded into the host's encoder.
//! forest.throw(trees[3], 120, 4.5)?;
//! let (eye, target) = (DVec3::new(0.0, 1.7, 40.0), DVec3::new(0.0, 6.0, 0.0));
//! let view = View::new(Camera::look_at(eye, target, 0.8, 0.1));
//! let mut encoder = device.create_command_encoder(&Default::default());
//! let mut recording = Recording::new(queue, &mut encoder);
//! renderer.advance(&mut recording, &mut forest, Moment::of(12.0, &view))?;
//! let picture = Picture { targets: &targets, output, layers: &mut [] };
//! renderer.render(&mut recording, &forest, &mut view_state, &view, picture)?;
//! queue.submit([encoder.finish()]);
//! # Ok(())
//! # }
//! ```
//!
//! A host with passes of its own calls [`Renderer::prepare`] and [`Renderer::draw`] in place of
//! [`Renderer::render`]: `examples/host_pass.rs`. Several views in one submission: `examples/split_screen.rs`.
//!
//! # The device
//!
//! [`Requirements::of`] asks an adapter before anything is built. WebGPU's default limits and no optional
//! features are enough. [`wgpu`] comes without backends, so that a program compiles only those it uses. A desktop
//! program adds to its `Cargo.toml`, with the version of [`wgpu`] here:
//!
//! ```toml
//! wgpu = { version = "29", default-features = false, features = ["vulkan", "metal", "dx12"] }
//! ```
#![deny(missing_docs)]

pub use windfall_core::{
    InputError, InputErrorKind, Note, NoteCode, error, foliage, forest, glam, light, material,
    note, path, rng, shed, simplify, sway, wind,
};
pub use windfall_flight as flight;
#[cfg(feature = "profiler")]
pub use windfall_gpu::wgpu_profiler;
pub use windfall_gpu::{
    Camera, Capture, CountReadback, Counts, Culling, DebugView, DepthOnly, Falls, Forest,
    ForestError, ForestTotals, FrameBudget, HostCascade, HostLight, HostShadow, Job, Layer,
    LayerFrame, Layers, Light, ModelError, Moment, OcclusionSwitch, Options, Picture,
    PictureTargets, Projection, Quality, Recording, Renderer, RendererError, Requirements, Sky,
    SkyMap, SkyPicture, SkyPictureError, TimedPass, Timing, Trail, TreeCounts, TreeId, TreeModel,
    TreePlace, TurnedOff, UnknownName, Unsupported, View, ViewError, ViewState, model_bytes, wgpu,
};

/// Trees: what one is, and everything that happens before run time.
pub mod tree {
    pub use windfall_core::tree::*;
    pub use windfall_tree::*;
}
