//! From triangles to leaves: cuts a mesh into leaf elements, and finds the shapes that they share.

mod correspondence;
mod fit;
mod mesh;
mod pieces;
mod shapes;

pub(crate) use mesh::Mesh;
pub(crate) use pieces::{Piece, Pieces};
pub(crate) use shapes::Shaper;
