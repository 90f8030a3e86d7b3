//! What the other rooms stand on: structs shared with WGSL, composed shader modules, layouts of bind
//! groups, pipelines, the way back from the GPU. Nothing here knows of a forest or a frame.

pub(crate) mod capture;
pub mod constants;
pub mod layouts;
pub(crate) mod names;
pub mod noise;
pub mod packing;
pub mod pipeline;
pub(crate) mod requirements;
pub mod shared;
pub(crate) mod timing;
pub mod wgsl;
