//! Where trees stand: the terrain and the instances on it.

pub mod terrain;

pub use terrain::Terrain;
