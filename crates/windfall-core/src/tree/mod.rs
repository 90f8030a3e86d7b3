//! Tree models: wood and leaves, ready to be drawn.
//!
//! The crate `windfall-tree` makes them, from files or from built-in species, and prepares them for drawing.

pub use crate::material::{Bark, BarkPattern, Image, Material, Surface};

use crate::foliage::Foliage;
use crate::simplify::{Branch, WoodLevel};
use glam::{Vec2, Vec3};

/// A tree model. Metres, Y up; the trunk leaves the ground at the origin.
#[derive(Debug, Clone)]
pub struct Tree {
    /// Name of the species or of the file, for people.
    pub name: String,
    /// Trunk and branches.
    pub wood: Wood,
    /// The leaves.
    pub foliage: Foliage,
}

/// Trunk and branches: one indexed triangle mesh, with levels of detail if the tree has been prepared.
#[derive(Debug, Clone, Default)]
pub struct Wood {
    /// Vertices; every index refers to one of them.
    pub vertices: Vec<WoodVertex>,
    /// Triangles, three indices each, counter-clockwise from outside.
    pub indices: Vec<u32>,
    /// What the vertices' `material` refers to.
    pub materials: Vec<Material>,
    /// Levels of detail, finest first: the mesh itself with error 0, then each with at most 0.7 times the triangles of
    /// the one before it and a larger error, down to a few dozen. Empty if the tree has not been prepared: it is
    /// drawn in full.
    pub levels: Vec<WoodLevel>,
    /// The branch of each vertex; empty if the tree has not been prepared.
    pub branches: Vec<Branch>,
    /// Whether at least 99% of the surface are tubes that face outward, open ends or not, so that back faces are always
    /// hidden. Real exports have mixed winding, and sheets. `false` if the tree has not been prepared.
    pub outward: bool,
}

/// A vertex of the wood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WoodVertex {
    /// Position in the tree, metres.
    pub position: Vec3,
    /// Unit normal.
    pub normal: Vec3,
    /// Texture coordinates, texture transform applied. For [`Surface::Bark`]: metres around
    /// the branch at its foot, and along it.
    pub uv: Vec2,
    /// Index into [`Wood::materials`].
    pub material: u32,
}

impl Tree {
    /// Smallest box around wood and leaves, `(low, high)`; zero for a tree of nothing.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let wood = self.wood.vertices.iter().map(|v| v.position);
        let leaves = self.foliage.leaves.iter().flat_map(|leaf| {
            let shape = &self.foliage.shapes[leaf.shape as usize];
            shape.positions.iter().map(|&p| leaf.center + leaf.orientation * p * leaf.scale)
        });
        let (low, high) = wood
            .chain(leaves)
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        if low.x <= high.x { (low, high) } else { (Vec3::ZERO, Vec3::ZERO) }
    }

    /// Height from the ground to the top of [`Self::bounds`], metres.
    pub fn height(&self) -> f32 {
        self.bounds().1.y
    }

    /// Scales the whole tree about its foot so that its height becomes `height` metres.
    ///
    /// A tree without height stays as it is.
    pub fn set_height(&mut self, height: f32) {
        let now = self.height();
        if now > 0.0 && height > 0.0 {
            self.scale(height / now);
        }
    }

    /// Scales the whole tree about its foot, levels of detail included.
    pub fn scale(&mut self, factor: f32) {
        self.wood.scale(factor);
        self.foliage.scale(factor);
    }

    /// Moves the whole tree.
    pub fn translate(&mut self, by: Vec3) {
        for vertex in &mut self.wood.vertices {
            vertex.position += by;
        }
        self.foliage.translate(by);
    }

    /// Triangles of the wood.
    pub fn wood_triangles(&self) -> usize {
        self.wood.indices.len() / 3
    }

    /// Vertices of wood and leaves together, each leaf counted with its own.
    pub fn vertex_count(&self) -> usize {
        self.wood.vertices.len() + self.foliage.vertex_count()
    }
}

impl Wood {
    /// The wood as one of [`Wood::levels`] is drawn at that level's own error, without levels of its own.
    ///
    /// # Panics
    ///
    /// If there is no such level.
    pub fn baked(&self, level: usize) -> Self {
        let WoodLevel { indices, error } = &self.levels[level];
        let mut vertices = self.vertices.clone();
        for (vertex, branch) in vertices.iter_mut().zip(&self.branches) {
            vertex.position += vertex.normal * branch.widening(*error);
        }
        let materials = self.materials.clone();
        Self { vertices, indices: indices.clone(), materials, ..Self::default() }
    }

    /// Scales the wood about the origin.
    fn scale(&mut self, factor: f32) {
        for vertex in &mut self.vertices {
            vertex.position *= factor;
        }
        for level in &mut self.levels {
            level.error *= factor;
        }
        for branch in &mut self.branches {
            branch.radius *= factor;
            // The widest never vanishes, at any size.
            if branch.vanishes < f32::MAX {
                branch.vanishes *= factor;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foliage::{Leaf, LeafShape};
    use glam::Quat;

    /// A trunk of one triangle, 2 m high, and a leaf at its top.
    fn tree() -> Tree {
        let vertex = |x: f32, y: f32| WoodVertex {
            position: Vec3::new(x, y, 0.0),
            normal: Vec3::Z,
            uv: Vec2::ZERO,
            material: 0,
        };
        let wood = Wood {
            vertices: vec![vertex(-0.1, 0.0), vertex(0.1, 0.0), vertex(0.0, 2.0)],
            indices: vec![0, 1, 2],
            levels: vec![
                WoodLevel { indices: vec![0, 1, 2], error: 0.0 },
                WoodLevel { indices: vec![0, 1, 2], error: 0.05 },
            ],
            branches: vec![
                Branch { radius: 0.1, vanishes: f32::MAX },
                Branch { radius: 0.01, vanishes: 0.04 },
                Branch { radius: 0.02, vanishes: 0.8 },
            ],
            ..Wood::default()
        };
        let leaf = Leaf {
            center: Vec3::Y * 2.0,
            orientation: Quat::IDENTITY,
            scale: 1.0,
            shape: 0,
            material: 0,
            bent_normal: Vec3::Y,
            ambient: 1.0,
            shed_rank: 0,
        };
        let shape = LeafShape {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Z],
            normals: vec![Vec3::Y; 3],
            uvs: vec![Vec2::ZERO; 3],
            indices: vec![0, 2, 1],
        };
        let mut foliage = Foliage::assemble(vec![leaf], vec![shape.clone()], Vec::new(), None, 1);
        foliage.simple_shapes = vec![Some(shape)];
        Tree { name: "a".into(), wood, foliage }
    }

    #[test]
    fn a_scaled_tree_has_scaled_levels_of_detail() {
        let (was, mut tree) = (tree(), tree());
        tree.set_height(6.0);
        assert!((tree.height() - 6.0).abs() < 1e-5);
        assert_eq!(tree.wood.vertices[2].position, Vec3::new(0.0, 6.0, 0.0));
        assert_eq!(tree.wood.levels[1].error, was.wood.levels[1].error * 3.0);
        assert_eq!(tree.wood.branches[2].radius, was.wood.branches[2].radius * 3.0);
        assert_eq!(tree.wood.branches[2].vanishes, was.wood.branches[2].vanishes * 3.0);
        assert_eq!(tree.wood.branches[0].vanishes, f32::MAX, "still never");
        // Shapes are in units of their own: the leaf's scale has grown.
        assert_eq!(tree.foliage.simple_shapes, was.foliage.simple_shapes);
        assert_eq!(tree.foliage.leaves[0].scale, 3.0);
        // What is drawn from three times as far away is three times what was.
        for (a, b) in tree.wood.branches.iter().zip(&was.wood.branches) {
            assert!((a.widening(0.15) - 3.0 * b.widening(0.05)).abs() < 1e-5);
        }
    }

    #[test]
    fn a_level_is_baked_as_it_is_drawn() {
        let wood = tree().wood;
        let own = wood.baked(0);
        assert!(own.indices == wood.indices && own.vertices == wood.vertices);
        // At 5 cm the trunk stays, the first twig is gone and the second is as wide as that.
        let moved: Vec<f32> = (wood.baked(1).vertices.iter().zip(&wood.vertices))
            .map(|(baked, own)| baked.position.z - own.position.z)
            .collect();
        for (moved, expected) in moved.iter().zip([0.0, -0.01, 0.03]) {
            assert!((moved - expected).abs() < 1e-6, "{moved} for {expected}");
        }
    }
}
