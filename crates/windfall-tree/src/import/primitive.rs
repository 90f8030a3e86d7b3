//! A primitive of a mesh, as triangles in the tree's space.

use super::container::way_out;
use super::document::Primitive;
use super::material::Look;
use super::sort::Found;
use super::{Reader, label};
use crate::leaves::Mesh;
use glam::{DMat4, DVec3, Vec2, Vec3, Vec4};
use windfall_core::InputError;
use windfall_core::InputErrorKind::{Malformed, NotFinite, OutOfRange, Unsupported};

/// Farthest a vertex may be from the origin, in units of the file: beyond, squares of areas
/// overflow.
const FARTHEST: f32 = 1e7;

/// A primitive in its own space, checked.
pub(super) struct Geometry {
    positions: Vec<Vec3>,
    /// As authored; empty if there are none.
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    /// Linear colours; empty if there are none.
    colors: Vec<Vec3>,
    /// Transforms of the vertices by a skin; empty without one.
    bent: Vec<DMat4>,
    leaves: Vec<Vec4>,
    indices: Vec<u32>,
    /// Distance between neighbouring values of a coordinate; 0 for floats.
    step: f32,
}

impl Geometry {
    /// The place of its first vertex, in the space that `transform` leads to.
    pub fn first(&self, transform: DMat4) -> Option<DVec3> {
        let first = self.positions.first()?.as_dvec3();
        let bent = self.bent.first().copied().unwrap_or(DMat4::IDENTITY);
        Some((transform * bent).transform_point3(first))
    }

    /// Whether a skin places it, whatever its node says.
    pub fn is_skinned(&self) -> bool {
        !self.bent.is_empty()
    }

    /// Whether its vertices have colours.
    pub fn is_colored(&self) -> bool {
        !self.colors.is_empty()
    }
}

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

    /// The triangles of a primitive in its own space, before any node places it. What [`Self::placed`] needs
    /// is read here once for all instances.
    pub fn geometry(
        &mut self,
        part: &Found<'_>,
        look: &Look,
        vertex_colors: bool,
    ) -> Result<Geometry, InputError> {
        let (primitive, here) = (part.primitive, &part.place);
        let Some(&accessor) = primitive.attributes.get("POSITION") else {
            return Err(self.error(here, Malformed, "has no POSITION"));
        };
        let at = format!("{here}, POSITION");
        if let Some(name) = primitive.extensions.keys().find(|name| name.contains("draco"))
            && self.is_empty(accessor, &at)?
        {
            let cause = format!("is packed with {name}, which is not supported{}", way_out(name));
            return Err(self.error(here, Unsupported, cause));
        }
        let mut positions: Vec<Vec3> =
            self.vectors::<3>(accessor, &at)?.into_iter().map(Vec3::from).collect();
        let morph = (primitive, part.weights);
        self.morph(&mut positions, "POSITION", morph, here)?;
        if let Some(i) = positions.iter().position(|position| !position.is_finite()) {
            let cause = format!("vertex {i} is at {}", positions[i]);
            return Err(self.error(&at, NotFinite, cause));
        }
        let count = positions.len();

        let uvs = match primitive.attributes.get(&format!("TEXCOORD_{}", look.uv_set)) {
            None => vec![Vec2::ZERO; count],
            Some(&uvs) => {
                let at = format!("{here}, TEXCOORD_{}", look.uv_set);
                let uvs = self.vectors::<2>(uvs, &at)?;
                self.same_count(uvs.len(), count, &at)?;
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
        let mut normals = Vec::new();
        if let Some(&authored) = primitive.attributes.get("NORMAL") {
            let at = format!("{here}, NORMAL");
            let authored = self.vectors::<3>(authored, &at)?;
            self.same_count(authored.len(), count, &at)?;
            normals = authored.into_iter().map(Vec3::from).collect();
            self.morph(&mut normals, "NORMAL", morph, here)?;
        }
        let mut colors = Vec::new();
        if let Some(&accessor) = primitive.attributes.get("COLOR_0").filter(|_| vertex_colors) {
            let at = format!("{here}, COLOR_0");
            let read = self.vectors_up_to::<4>(accessor, &at, 1.0)?;
            self.same_count(read.len(), count, &at)?;
            // Forgiving: what is no colour is none.
            let color = |c: [f32; 4]| {
                let color = Vec3::new(c[0], c[1], c[2]);
                if color.is_finite() { color.clamp(Vec3::ZERO, Vec3::ONE) } else { Vec3::ONE }
            };
            colors = read.into_iter().map(color).collect();
        }
        let skin = part.skin.filter(|_| primitive.attributes.contains_key("JOINTS_0"));
        let bent = match skin {
            Some(skin) => self.skinned(skin, primitive, count, here)?,
            None => Vec::new(),
        };
        Ok(Geometry {
            uvs,
            normals,
            colors,
            bent,
            leaves: self.leaves(primitive, count, here)?,
            indices: self.corners(primitive, count, here)?,
            step: self.step(accessor, &at)?,
            positions,
        })
    }

    /// The triangles of a primitive in the tree: facing as authored, also where the transform mirrors; triangles
    /// without area are dropped, and so are vertices that no triangle uses. `transform` is from the primitive
    /// to the tree, and `origin` is what the tree's own origin is there.
    pub fn placed(
        &self,
        geometry: &Geometry,
        transform: DMat4,
        origin: DVec3,
        here: &str,
    ) -> Result<Mesh, InputError> {
        let of_vertex = |i: usize| match geometry.bent.get(i) {
            Some(&bent) => transform * bent,
            None => transform,
        };
        let mut positions = Vec::with_capacity(geometry.positions.len());
        for (i, position) in geometry.positions.iter().enumerate() {
            let moved = (of_vertex(i).transform_point3(position.as_dvec3()) - origin).as_vec3();
            if !moved.is_finite() || moved.abs().max_element() > FARTHEST {
                let cause = format!("vertex {i}, moved by its node, is at {moved}: too far away");
                return Err(self.error(&format!("{here}, POSITION"), OutOfRange, cause));
            }
            positions.push(moved);
        }
        let mirrored = of_vertex(0).determinant() < 0.0;
        let mut indices = without_degenerate(&geometry.indices, &positions);
        if mirrored {
            for triangle in indices.chunks_exact_mut(3) {
                triangle.swap(1, 2);
            }
        }

        let mut normals = vec![Vec3::ZERO; positions.len()];
        let sign = if mirrored { -1.0 } else { 1.0 };
        // The cofactor matrix: the inverse transpose times the determinant, and defined also
        // where that is zero. The determinant's sign is taken out again.
        let cofactors = |m: DMat4| {
            let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis].map(glam::DVec4::truncate);
            [y.cross(z), z.cross(x), x.cross(y)]
        };
        let of_all = cofactors(transform);
        for (i, (normal, n)) in normals.iter_mut().zip(&geometry.normals).enumerate() {
            let [x, y, z] = geometry.bent.get(i).map_or(of_all, |_| cofactors(of_vertex(i)));
            let n = n.as_dvec3();
            let n = x * n.x + y * n.y + z * n.z;
            // Forgiving: a normal that is none is made from the triangles below.
            *normal = (n * sign).try_normalize().unwrap_or(DVec3::ZERO).as_vec3();
        }
        let matrix = of_vertex(0);
        let scale = [matrix.x_axis, matrix.y_axis, matrix.z_axis]
            .map(|axis| axis.truncate().length())
            .into_iter()
            .fold(0.0, f64::max);
        let mesh = Mesh {
            positions,
            normals,
            uvs: geometry.uvs.clone(),
            colors: geometry.colors.clone(),
            leaves: geometry.leaves.clone(),
            indices,
            step: geometry.step * scale as f32,
        };
        Ok(mesh.compact())
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

    pub fn same_count(&self, count: usize, positions: usize, at: &str) -> Result<(), InputError> {
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
    let has_area = |t: &[u32]| {
        let [a, b, c] = [t[0], t[1], t[2]].map(|i| positions[i as usize].as_dvec3());
        let (u, v) = (b - a, c - a);
        u.cross(v).length() > 1e-9 * u.length_squared().max(v.length_squared())
    };
    let mut left = Vec::with_capacity(indices.len());
    for triangle in indices.chunks_exact(3).filter(|t| has_area(t)) {
        left.extend_from_slice(triangle);
    }
    left
}

/// `mesh 1 "leaves", primitive 0`.
pub(super) fn place(mesh: usize, name: Option<&str>, primitive: usize) -> String {
    format!("{}, primitive {primitive}", label("mesh", mesh, name))
}
