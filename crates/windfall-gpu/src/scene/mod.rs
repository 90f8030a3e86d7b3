//! What is drawn: tree models, and the forests of them, with the state of their leaves.

pub(crate) mod events;
pub(crate) mod falls;
pub(crate) mod forest;
pub(crate) mod ground;
pub(crate) mod leaf_mesh;
pub(crate) mod loose_shapes;
pub(crate) mod model;
pub(crate) mod parts;
pub(crate) mod sky_map;
pub(crate) mod streams;
pub(crate) mod tables;
pub(crate) mod texture;
pub(crate) mod trees;
