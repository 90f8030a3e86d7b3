//! How a forest is looked at: the camera, the light, what it may cost, and what one view keeps on the GPU.

pub(crate) mod budget;
pub(crate) mod camera;
pub(crate) mod cascades;
pub(crate) mod culling;
pub(crate) mod description;
pub(crate) mod grass;
pub(crate) mod ground;
pub(crate) mod light;
pub(crate) mod lists;
pub(crate) mod occlusion;
pub(crate) mod pyramid;
pub(crate) mod quads;
pub(crate) mod quality;
pub(crate) mod shadow_turns;
pub(crate) mod sky;
pub(crate) mod state;
pub(crate) mod targets;
