//! The published strategies of falling leaves (P.-P. Vázquez and M. Balsa, "Rendering Falling Leaves on Graphics
//! Hardware", JVRB 5(2), 2008), kept to reproduce the paper and to compare with the renderer's own compute path.
//!
//! | VB | here |
//! |---|---|
//! | section 5, leaf elimination | [`Elimination`] |
//! | section 5, search of the landing in the shader | [`LandingSearch`] |
//! | section 5, leaf occlusion | [`LeafOcclusion`], [`OcclusionCounts`] |
//! | section 6, vertex and fragment shaders, vertex buffers, the CPU | [`Strategy`] |
//!
//! A strategy is a [`windfall_gpu::Layer`] of a whole picture. The forest must not draw its loose leaves itself:
//!
//! ```no_run
//! # use std::sync::Arc;
//! # use windfall_gpu::{Falls, Forest, Picture, PictureTargets, Recording, Renderer, View, ViewState, wgpu};
//! # use windfall_papers::{ListOptions, PassOptions, PublishedFalls, PublishedPasses, Strategy};
//! # fn frame(device: &wgpu::Device, renderer: &Renderer, falls: Falls, targets: &PictureTargets,
//! #     output: &wgpu::TextureView, view: &View, state: &mut ViewState, recording: &mut Recording<'_>,
//! #     terrain: windfall_core::forest::Terrain) -> Result<(), Box<dyn std::error::Error>> {
//! // Once.
//! let passes = Arc::new(PublishedPasses::new(device, PassOptions::new(Strategy::Fragment)));
//! let capacity = falls.capacity;
//! let falls = Falls { capacity: 0, ..falls };
//! let mut forest = Forest::new(device, glam::DVec3::ZERO, terrain, falls)?;
//! // forest.plant(...)
//! let options = ListOptions { capacity, ..ListOptions::default() };
//! let mut leaves = PublishedFalls::new(&passes, &forest, options)?;
//! // In each frame.
//! renderer.advance(recording, &mut forest, windfall_gpu::Moment::of(12.5, view))?;
//! let picture = Picture { targets, output, layers: &mut [&mut leaves] };
//! renderer.render(recording, &forest, state, view, picture)?;
//! println!("{:?}", leaves.counts());
//! # Ok(())
//! # }
//! ```
#![deny(missing_docs)]

mod active_leaves;
mod arena;
mod buffers;
mod eye;
mod layer;
mod look;
mod options;
mod pass;
mod shared;
mod streams;

pub use layer::{LeafCounts, OcclusionCounts, OcclusionReadback, PublishedError, PublishedFalls};
pub use options::{
    Elimination, LandingSearch, LeafOcclusion, ListOptions, PassOptions, PathData, Strategy,
};
pub use pass::{MODULES, PublishedPasses};
