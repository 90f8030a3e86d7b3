//! What Windfall's native programs share: a GPU device without a window, tree files, image files, skies.
//!
//! The libraries open no device and no file. The program `windfall` and its measurements
//! (`windfall-bench`) do both, through this crate; browsers have
//! its skies alone. It is a part of programs, so its errors are
//! `anyhow`'s: messages for the person at the command line.
#![deny(missing_docs)]

#[cfg(not(target_arch = "wasm32"))]
pub mod cache;
#[cfg(not(target_arch = "wasm32"))]
pub mod device;
#[cfg(not(target_arch = "wasm32"))]
pub mod file;
#[cfg(not(target_arch = "wasm32"))]
pub mod image;
#[cfg(not(target_arch = "wasm32"))]
pub mod memory;
pub mod sky;
#[cfg(not(target_arch = "wasm32"))]
pub mod tree;
