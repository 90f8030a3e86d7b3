//! A primitive of a mesh, as triangles in the tree's space.

use super::document::Primitive;
use super::material::Look;
use super::{Reader, label};
use crate::leaves::Mesh;
use glam::{Mat4, Vec2, Vec3, Vec4};
use windfall_core::InputError;
use windfall_core::InputErrorKind::{Malformed, NotFinite, OutOfRange};

/// Farthest a vertex may be from the origin, in units of the file: beyond, squares of areas
/// overflow.
const FARTHEST: f32 = 1e7;

impl Reader<'_> {
    /// How many triangles a primitive draws; 0 for points and lines, which have no surface.
    pub fn triangle_count(&self, primitive: &Primitive, here: &str) -> Result<u64, InputError> {
        let corners = match (primitive.indices, primitive.attributes.get("POSITION")) {
            (Some(indices), _) => self.count(indices, &format!("{here}, indices"))?,
            (None, Some(&positions)) => self.count(positions, here)?,
            (None, None) => 0,
        };
        match primitive.mode {
            0..=3 => Ok(0),
            4 => Ok(corners / 3),
            5 | 6 => Ok(corners.saturating_sub(2)),
            mode => Err(self.error(here, Malformed, format!("mode {mode} is not known"))),
        }
    }

    /// The triangles of a primitive, moved by `world_from_node`: facing as authored, also where
    /// the transform mirrors; triangles without area are dropped, and so are vertices that no
    /// triangle uses.
    pub fn mesh(
        &mut self,
        primitive: &Primitive,
        look: &Look,
        world_from_node: Mat4,
        here: &str,
    ) -> Result<Mesh, InputError> {
        let Some(&positions) = primitive.attributes.get("POSITION") else {
            return Err(self.error(here, Malformed, "has no POSITION"));
        };
        let at = format!("{here}, POSITION");
        let mut positions: Vec<Vec3> =
            self.vectors::<3>(positions, &at)?.into_iter().map(Vec3::from).collect();
        for (i, position) in positions.iter_mut().enumerate() {
            if !position.is_finite() {
                let cause = format!("vertex {i} is at {position}");
                return Err(self.error(&at, NotFinite, cause));
            }
            let moved = world_from_node.transform_point3(*position);
            if !moved.is_finite() || moved.abs().max_element() > FARTHEST {
                let cause = format!("vertex {i}, moved by its node, is at {moved}: too far away");
                return Err(self.error(&at, OutOfRange, cause));
            }
            *position = moved;
        }

        let uvs = match primitive.attributes.get(&format!("TEXCOORD_{}", look.uv_set)) {
            None => vec![Vec2::ZERO; positions.len()],
            Some(&uvs) => {
                let at = format!("{here}, TEXCOORD_{}", look.uv_set);
                let uvs = self.vectors::<2>(uvs, &at)?;
                self.same_count(uvs.len(), positions.len(), &at)?;
                let uvs: Vec<Vec2> = uvs
                    .into_iter()
                    .map(|uv| look.uv_transform.transform_point2(uv.into()))
                    .collect();
                if let Some(i) = uvs.iter().position(|uv| !uv.is_finite()) {
                    return Err(self.error(&at, NotFinite, format!("vertex {i} has {}", uvs[i])));
                }
                uvs
            }
        };

        let mut indices = self.corners(primitive, positions.len(), here)?;
        let mirrored = world_from_node.determinant() < 0.0;
        if mirrored {
            for triangle in indices.chunks_exact_mut(3) {
                triangle.swap(1, 2);
            }
        }
        let indices = without_degenerate(&indices, &positions);

        let mut normals = vec![Vec3::ZERO; positions.len()];
        if let Some(&authored) = primitive.attributes.get("NORMAL") {
            let at = format!("{here}, NORMAL");
            let authored = self.vectors::<3>(authored, &at)?;
            self.same_count(authored.len(), positions.len(), &at)?;
            // The cofactor matrix: the inverse transpose times the determinant, and defined also
            // where that is zero. The determinant's sign is taken out again.
            let [x, y, z] =
                [world_from_node.x_axis, world_from_node.y_axis, world_from_node.z_axis]
                    .map(glam::Vec4::truncate);
            let sign = if mirrored { -1.0 } else { 1.0 };
            for (normal, n) in normals.iter_mut().zip(authored) {
                let n = y.cross(z) * n[0] + z.cross(x) * n[1] + x.cross(y) * n[2];
                // Forgiving: a normal that is none is made from the triangles below.
                *normal = (n * sign).try_normalize().unwrap_or(Vec3::ZERO);
            }
        }
        let leaves = self.leaves(primitive, positions.len(), here)?;
        Ok(Mesh { positions, normals, uvs, leaves, indices }.compact())
    }

    /// What [`crate::export_glb`] writes of each vertex's leaf. Attributes that begin with `_` are an
    /// application's own: one of another type is none of ours.
    fn leaves(
        &mut self,
        primitive: &Primitive,
        vertices: usize,
        here: &str,
    ) -> Result<Vec<Vec4>, InputError> {
        let at = format!("{here}, _LEAF");
        match primitive.attributes.get("_LEAF") {
            Some(&leaves) if self.is_vector(leaves, 4, &at)? => {
                let leaves = self.vectors::<4>(leaves, &at)?;
                self.same_count(leaves.len(), vertices, &at)?;
                Ok(leaves.into_iter().map(Vec4::from).collect())
            }
            _ => Ok(Vec::new()),
        }
    }

    fn same_count(&self, count: usize, positions: usize, at: &str) -> Result<(), InputError> {
        if count == positions {
            return Ok(());
        }
        Err(self.error(at, Malformed, format!("has {count} elements for {positions} positions")))
    }

    /// Triangle corners: strips and fans unrolled, every index in range.
    fn corners(
        &mut self,
        primitive: &Primitive,
        vertices: usize,
        here: &str,
    ) -> Result<Vec<u32>, InputError> {
        let list = match primitive.indices {
            None => (0..vertices as u32).collect(),
            Some(indices) => {
                let at = format!("{here}, indices");
                let list = self.indices(indices, &at)?;
                if let Some(i) = list.iter().position(|&index| index as usize >= vertices) {
                    let cause =
                        format!("index {i} is {}, but there are {vertices} vertices", list[i]);
                    return Err(self.error(&at, OutOfRange, cause));
                }
                list
            }
        };
        Ok(match primitive.mode {
            5 => list
                .windows(3)
                .enumerate()
                // Every other triangle of a strip is turned round.
                .flat_map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] })
                .collect(),
            6 => match list.split_first() {
                Some((&hub, rim)) => rim.windows(2).flat_map(|w| [hub, w[0], w[1]]).collect(),
                None => Vec::new(),
            },
            _ => {
                let whole = list.len() / 3 * 3;
                list[..whole].to_vec()
            }
        })
    }
}

/// The triangles that have an area that floats can tell from none.
fn without_degenerate(indices: &[u32], positions: &[Vec3]) -> Vec<u32> {
    let has_area = |t: &&[u32]| {
        let [a, b, c] = [t[0], t[1], t[2]].map(|i| positions[i as usize].as_dvec3());
        let (u, v) = (b - a, c - a);
        u.cross(v).length() > 1e-9 * u.length_squared().max(v.length_squared())
    };
    indices.chunks_exact(3).filter(has_area).flatten().copied().collect()
}

/// `mesh 1 "leaves", primitive 0`.
pub(super) fn place(mesh: usize, name: Option<&str>, primitive: usize) -> String {
    format!("{}, primitive {primitive}", label("mesh", mesh, name))
}
