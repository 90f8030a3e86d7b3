//! Triangles on their way from a file to the wood or to the leaves.

use glam::{Vec2, Vec3, Vec4};

/// An indexed triangle mesh; all attributes are as long as `positions`, but `colors` and `leaves` may be empty.
#[derive(Debug, Clone, Default)]
pub(crate) struct Mesh {
    pub positions: Vec<Vec3>,
    /// Unit normals; before [`Mesh::compact`], zero where the file has none.
    pub normals: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    /// Linear colours; empty where the file has none.
    pub colors: Vec<Vec3>,
    /// The same for the vertices of one leaf, and of no other; empty where the file does not tell.
    pub leaves: Vec<Vec4>,
    pub indices: Vec<u32>,
    /// Distance between neighbouring values of a coordinate, as the file stores them; 0 for floats.
    pub step: f32,
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
        let mut part = Self { step: self.step, ..Self::default() };
        for &corner in triangles {
            let i = corner as usize;
            if new_index[i] == u32::MAX {
                new_index[i] = part.positions.len() as u32;
                part.positions.push(self.positions[i]);
                part.normals.push(self.normals[i]);
                part.uvs.push(self.uvs[i]);
                part.colors.extend(self.colors.get(i));
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

    /// Adds the triangles of another mesh; either both have colours, and leaves, or neither has.
    pub fn append(&mut self, other: Self) {
        let base = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.normals.extend(other.normals);
        self.uvs.extend(other.uvs);
        self.colors.extend(other.colors);
        self.leaves.extend(other.leaves);
        self.indices.extend(other.indices.iter().map(|i| base + i));
        self.step = self.step.max(other.step);
    }

    /// Mean colour of some triangles, or of all: by area. White without colours.
    pub fn mean_color(&self, triangles: &[u32]) -> Vec3 {
        let (mut sum, mut all) = (Vec3::ZERO, 0.0);
        for t in triangles.chunks_exact(3) {
            let [a, b, c] = [t[0], t[1], t[2]].map(|i| i as usize);
            let Some(&[x, y, z]) = [a, b, c]
                .map(|i| self.colors.get(i).copied())
                .into_iter()
                .collect::<Option<Vec<_>>>()
                .as_deref()
            else {
                return Vec3::ONE;
            };
            let p = [a, b, c].map(|i| self.positions[i]);
            let area = (p[1] - p[0]).cross(p[2] - p[0]).length();
            sum += (x + y + z) * (area / 3.0);
            all += area;
        }
        if all > 0.0 { sum / all } else { Vec3::ONE }
    }

    /// Smallest box around it.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.positions
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)))
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
