//! Elements of the arrays, as their bytes lie in the file.

use super::format;
use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec2, Vec3};
use windfall_core::foliage::{Leaf, LeafShape};
use windfall_core::material::BarkPattern;
use windfall_core::simplify::Branch;
use windfall_core::tree::WoodVertex;

/// Vertices of a simple shape that is not there: the shape itself is drawn.
const NO_SHAPE: u32 = u32::MAX;

/// A leaf: 60 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct LeafRecord {
    center: [f32; 3],
    scale: f32,
    orientation: [f32; 4],
    bent_normal: [f32; 3],
    ambient: f32,
    shape: u32,
    material: u32,
    shed_rank: u32,
}

impl From<&Leaf> for LeafRecord {
    fn from(leaf: &Leaf) -> Self {
        Self {
            center: leaf.center.to_array(),
            scale: leaf.scale,
            orientation: leaf.orientation.to_array(),
            bent_normal: leaf.bent_normal.to_array(),
            ambient: leaf.ambient,
            shape: leaf.shape,
            material: leaf.material,
            shed_rank: leaf.shed_rank,
        }
    }
}

impl From<LeafRecord> for Leaf {
    fn from(record: LeafRecord) -> Self {
        Self {
            center: Vec3::from_array(record.center),
            scale: record.scale,
            orientation: Quat::from_array(record.orientation),
            bent_normal: Vec3::from_array(record.bent_normal),
            ambient: record.ambient,
            shape: record.shape,
            material: record.material,
            shed_rank: record.shed_rank,
        }
    }
}

/// A vertex of the wood: 36 bytes. Position, normal and texture coordinates are accessors of the mesh too.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct WoodVertexRecord {
    position: [f32; 3],
    normal: [f32; 3],
    uv: [f32; 2],
    material: u32,
}

impl From<&WoodVertex> for WoodVertexRecord {
    fn from(vertex: &WoodVertex) -> Self {
        Self {
            position: vertex.position.to_array(),
            normal: vertex.normal.to_array(),
            uv: vertex.uv.to_array(),
            material: vertex.material,
        }
    }
}

impl From<WoodVertexRecord> for WoodVertex {
    fn from(record: WoodVertexRecord) -> Self {
        Self {
            position: Vec3::from_array(record.position),
            normal: Vec3::from_array(record.normal),
            uv: Vec2::from_array(record.uv),
            material: record.material,
        }
    }
}

/// The branch of a vertex: 8 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct BranchRecord {
    radius: f32,
    vanishes: f32,
}

impl From<&Branch> for BranchRecord {
    fn from(branch: &Branch) -> Self {
        Self { radius: branch.radius, vanishes: branch.vanishes }
    }
}

impl From<BranchRecord> for Branch {
    fn from(record: BranchRecord) -> Self {
        Self { radius: record.radius, vanishes: record.vanishes }
    }
}

/// A leaf shape: how many of the vertices and indices are its own.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct ShapeRecord {
    vertices: u32,
    indices: u32,
}

/// A vertex of a leaf shape: 32 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct ShapeVertexRecord {
    position: [f32; 3],
    normal: [f32; 3],
    uv: [f32; 2],
}

/// Leaf shapes, one after the other.
#[derive(Debug, Default)]
pub(super) struct ShapeArrays {
    pub counts: Vec<ShapeRecord>,
    pub vertices: Vec<ShapeVertexRecord>,
    pub indices: Vec<u32>,
}

impl ShapeArrays {
    /// Shapes to arrays.
    pub fn of<'a>(shapes: impl Iterator<Item = Option<&'a LeafShape>>) -> Self {
        let mut arrays = Self::default();
        for shape in shapes {
            let Some(shape) = shape else {
                arrays.counts.push(ShapeRecord { vertices: NO_SHAPE, indices: 0 });
                continue;
            };
            arrays.counts.push(ShapeRecord {
                vertices: shape.positions.len() as u32,
                indices: shape.indices.len() as u32,
            });
            let vertices = shape.positions.iter().zip(&shape.normals).zip(&shape.uvs);
            arrays.vertices.extend(vertices.map(|((position, normal), uv)| ShapeVertexRecord {
                position: position.to_array(),
                normal: normal.to_array(),
                uv: uv.to_array(),
            }));
            arrays.indices.extend(&shape.indices);
        }
        arrays
    }

    /// Arrays to shapes; what is wrong with them if they do not fit each other.
    pub fn shapes(&self) -> Result<Vec<Option<LeafShape>>, String> {
        let (mut vertices, mut indices) = (&self.vertices[..], &self.indices[..]);
        let mut shapes = Vec::with_capacity(self.counts.len());
        for (i, count) in self.counts.iter().enumerate() {
            let none = count.vertices == NO_SHAPE;
            let own = if none { 0 } else { count.vertices as usize };
            let (Some((own_vertices, left)), Some((own_indices, left_indices))) =
                (vertices.split_at_checked(own), indices.split_at_checked(count.indices as usize))
            else {
                return Err(format!(
                    "shape {i} has {own} vertices and {} indices, {} and {} are left",
                    count.indices,
                    vertices.len(),
                    indices.len()
                ));
            };
            (vertices, indices) = (left, left_indices);
            if none && !own_indices.is_empty() {
                return Err(format!("shape {i} is not there, but has {} indices", count.indices));
            }
            shapes.push((!none).then(|| LeafShape {
                positions: own_vertices.iter().map(|v| Vec3::from_array(v.position)).collect(),
                normals: own_vertices.iter().map(|v| Vec3::from_array(v.normal)).collect(),
                uvs: own_vertices.iter().map(|v| Vec2::from_array(v.uv)).collect(),
                indices: own_indices.to_vec(),
            }));
        }
        if !(vertices.is_empty() && indices.is_empty()) {
            let (v, i) = (vertices.len(), indices.len());
            return Err(format!("{v} vertices and {i} indices are of no shape"));
        }
        Ok(shapes)
    }
}

impl From<BarkPattern> for format::Pattern {
    fn from(pattern: BarkPattern) -> Self {
        match pattern {
            BarkPattern::Smooth => Self::Smooth,
            BarkPattern::Furrowed => Self::Furrowed,
            BarkPattern::Plated => Self::Plated,
            BarkPattern::Papery => Self::Papery,
        }
    }
}

impl From<format::Pattern> for BarkPattern {
    fn from(pattern: format::Pattern) -> Self {
        match pattern {
            format::Pattern::Smooth => Self::Smooth,
            format::Pattern::Furrowed => Self::Furrowed,
            format::Pattern::Plated => Self::Plated,
            format::Pattern::Papery => Self::Papery,
        }
    }
}
