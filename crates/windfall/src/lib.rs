//! Forests that shed their leaves, in real time, on any GPU: the library of Windfall.
//!
//! Two crates under one name: the models (`windfall-core`: trees, forests, fall paths, wind; pure
//! CPU) and the renderer (`windfall-gpu`, on [`wgpu`]). It opens no window and no file and starts no
//! thread: the host owns the device, hands in bytes, and submits what was recorded.
//!
//! Units everywhere: metres, seconds, radians; Y is up, right-handed, as in glTF. Colour is linear.
//! Every picture is a pure function of the forest, its seeds and [`View`]: moments can be drawn in
//! any order.
//!
//! # From a tree to a picture
//!
//! ```no_run
//! use windfall::forest::{Placement, Terrain};
//! use windfall::glam::Vec3;
//! use windfall::tree::species::Species;
//! use windfall::wgpu_profiler::GpuProfiler;
//! use windfall::{Camera, Falls, GpuForest, Renderer, Target, View, wgpu};
//!
//! # fn host(device: &wgpu::Device, queue: &wgpu::Queue, profiler: &GpuProfiler,
//! #     picture: &wgpu::TextureView) {
//! // Once: two trees, a forest of 300 of them, and what draws it.
//! let trees = [Species::Birch.grow(1), Species::Oak.grow(2)];
//! let placement = Placement {
//!     trees: 300,
//!     spacing: 6.0,
//!     keep_out: Vec::new(),
//!     scale: (0.8, 1.2),
//!     season_spread: 0.1,
//!     seed: 7,
//! };
//! let forest = placement.place(Terrain::rolling(300.0, 2.0, 7), &[1.0, 1.0]);
//! let renderer = Renderer::new(device, wgpu::TextureFormat::Rgba8UnormSrgb);
//! let falls = Falls::default();
//! let gpu_forest = GpuForest::with_falls(device, queue, &renderer, &trees, &forest, &falls);
//! let canvas = renderer.canvas(device, 1280, 720);
//!
//! // Every frame: a view, recorded into the host's encoder.
//! let (eye, target) = (Vec3::new(0.0, 1.7, 40.0), Vec3::new(0.0, 6.0, 0.0));
//! let camera = Camera { eye, target, fov_y: 0.8, near: 0.1 };
//! let view = View { time: 3.0, ..View::new(camera) };
//! let mut encoder = device.create_command_encoder(&Default::default());
//! let target = Target { canvas: &canvas, picture };
//! let stats = renderer.render(queue, &mut encoder, profiler, &gpu_forest, &view, target);
//! queue.submit([encoder.finish()]);
//! println!("{} leaves on {} trees", stats.leaves_total, stats.trees);
//! # }
//! ```
//!
//! `examples/own_tree.rs` is a whole host: it reads a glTF tree and writes a PNG.
//!
//! # The device
//!
//! [`wgpu`] comes without backends, so that a program compiles only those it uses. A desktop
//! program adds to its `Cargo.toml`, with the version of [`wgpu`] here:
//!
//! ```toml
//! wgpu = { version = "29", default-features = false, features = ["vulkan", "metal", "dx12"] }
//! ```
#![deny(missing_docs)]

pub use windfall_core::{InputError, InputErrorKind, glam};
pub use windfall_core::{error, flight, foliage, forest, path, rng, shed, tree, wind};
pub use windfall_gpu::{
    Camera, Canvas, Capture, CountLeaves, DetachEvent, Elimination, EventError,
};
pub use windfall_gpu::{Falls, FrameStats};
pub use windfall_gpu::{GpuForest, LeafCounts, Renderer, Show, Sky, Strategy, Target, View};
pub use windfall_gpu::{model_bytes, wgpu, wgpu_profiler};
