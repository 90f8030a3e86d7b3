//! What Windfall's native programs share: a GPU device without a window, tree files, image files, skies.
//!
//! The libraries open no device and no file. The program `windfall` and its measurements
//! (`windfall-bench`) do both, through this crate. It is a part of programs, so its errors are
//! `anyhow`'s: messages for the person at the command line.
#![deny(missing_docs)]

pub mod cache;
pub mod device;
pub mod file;
pub mod image;
pub mod memory;
pub mod sky;
pub mod tree;
