//! Where trees stand: the terrain and the instances on it.

mod frustum;
mod placement;
pub mod terrain;

pub use frustum::Frustum;
pub use placement::{KeepOut, Placement};
pub use terrain::Terrain;

use glam::{Quat, Vec3};

/// Trees on a terrain.
#[derive(Debug, Clone)]
pub struct Forest {
    /// The ground.
    pub terrain: Terrain,
    /// The trees.
    pub instances: Vec<Instance>,
}

/// One tree of the forest: a model at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instance {
    /// Index of the tree model.
    pub model: u32,
    /// Foot of the tree in the world, metres.
    pub position: Vec3,
    /// Turn about Y, radians.
    pub yaw: f32,
    /// Factor on the model's size, above 0.
    pub scale: f32,
    /// Added to the scene's season, `-1..=1`: this tree is earlier or later than the others.
    pub season_offset: f32,
    /// Key of everything that is random about this tree.
    pub seed: u32,
}

impl Instance {
    /// A tree at the origin as its model is: neither turned nor scaled.
    pub fn alone(model: u32, seed: u32) -> Self {
        Self { model, position: Vec3::ZERO, yaw: 0.0, scale: 1.0, season_offset: 0.0, seed }
    }

    /// A point of the tree model in the world.
    pub fn world_from_tree(&self, point: Vec3) -> Vec3 {
        self.position + self.rotation() * point * self.scale
    }

    /// Turn of the tree.
    pub fn rotation(&self) -> Quat {
        Quat::from_rotation_y(self.yaw)
    }
}
