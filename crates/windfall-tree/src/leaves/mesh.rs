//! Triangles on their way from a file to the wood or to the leaves.

use glam::{Vec2, Vec3, Vec4};

/// An indexed triangle mesh; all attributes are as long as `positions`, or `leaves` is empty.
#[derive(Debug, Clone, Default)]
pub(crate) struct Mesh {
    pub positions: Vec<Vec3>,
    /// Unit normals; before [`Mesh::compact`], zero where the file has none.
    pub normals: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    /// The same for the vertices of one leaf, and of no other; empty where the file does not tell.
    pub leaves: Vec<Vec4>,
    pub indices: Vec<u32>,
}

impl Mesh {
    /// Twice the area of each triangle, along its normal.
    pub fn area_vectors(&self) -> impl Iterator<Item = Vec3> {
        self.indices.chunks_exact(3).map(|t| {
            let [a, b, c] = [t[0], t[1], t[2]].map(|i| self.positions[i as usize]);
            (b - a).cross(c - a)
        })
    }

    /// Only the vertices that `triangles` (corners of this mesh) use, in the order in which they
    /// are first used: equal pieces get equal indices, however their vertices were numbered.
    ///
    /// `new_index` is scratch space: as long as `positions`, and `u32::MAX` throughout, before and
    /// after.
    pub fn part(&self, triangles: &[u32], new_index: &mut [u32]) -> Self {
        let mut part = Self::default();
        for &corner in triangles {
            let i = corner as usize;
            if new_index[i] == u32::MAX {
                new_index[i] = part.positions.len() as u32;
                part.positions.push(self.positions[i]);
                part.normals.push(self.normals[i]);
                part.uvs.push(self.uvs[i]);
                part.leaves.extend(self.leaves.get(i));
            }
            part.indices.push(new_index[i]);
        }
        for &corner in triangles {
            new_index[corner as usize] = u32::MAX;
        }
        part
    }

    /// Only the vertices that a triangle uses, and a normal for each that has none: the mean of
    /// its triangles by area.
    pub fn compact(&self) -> Self {
        let mut mesh = self.part(&self.indices, &mut vec![u32::MAX; self.positions.len()]);
        if mesh.normals.contains(&Vec3::ZERO) {
            let made = mesh.face_normals();
            for (normal, made) in mesh.normals.iter_mut().zip(made) {
                if *normal == Vec3::ZERO {
                    *normal = made;
                }
            }
        }
        mesh
    }

    /// Unit normal of each vertex: the mean of its triangles by area.
    pub fn face_normals(&self) -> Vec<Vec3> {
        let mut normals = vec![Vec3::ZERO; self.positions.len()];
        for (triangle, area) in self.indices.chunks_exact(3).zip(self.area_vectors()) {
            for &corner in triangle {
                normals[corner as usize] += area;
            }
        }
        for normal in &mut normals {
            // In doubles: the square of a tiny triangle's area is below what a float holds.
            *normal = normal.as_dvec3().normalize_or(glam::DVec3::Y).as_vec3();
        }
        normals
    }
}
