//! Leaves once they have left their twigs: their shapes, and what each leaf needs.
//!
//! A forest has a draw, slots and work for each shape. Trees whose leaves are all unlike would have thousands: leaves
//! that have let go are then drawn in a few of the shapes, each leaf in one like its own and in its own size.

use crate::base::packing::{octahedral, pack_rotation, snorm, snorm8};
use crate::base::shared::LeafRecord;
use crate::scene::leaf_mesh::LeafQuads;
use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec4};
use half::f16;
use wgpu::util::DeviceExt;
use windfall_core::foliage::{Foliage, LeafShape};

/// Most shapes of the loose leaves of a model.
const MOST_SHAPES: usize = 32;

/// What a model's leaves need once they have left their twigs.
pub struct LooseShapes {
    /// A leaf each.
    pub records: Vec<LeafRecord>,
    /// Of each leaf the index of its shape.
    pub shape_of: Vec<u32>,
    pub shapes: Vec<LooseShape>,
}

/// A shape of loose leaves.
pub struct LooseShape {
    /// Its leaves in shed order.
    pub shed_order: Vec<u32>,
    /// Extent above and below its middle, metres at scale 1.
    pub thickness: f32,
    /// Its radius, metres at scale 1.
    pub radius: f32,
    pub full: ShapeBuffers,
    /// The shape in two triangles, for leaves of a few pixels.
    pub small: Option<ShapeBuffers>,
    pub geometry: LeafShape,
    pub small_geometry: Option<LeafShape>,
}

impl LooseShapes {
    /// Of a model's leaves; `quads`: their shapes in two triangles.
    pub fn new(device: &wgpu::Device, foliage: &Foliage, quads: Option<&LeafQuads>) -> Self {
        let kinds = kinds(foliage);
        let kind_of = |leaf: &windfall_core::foliage::Leaf| kinds.of_shape[leaf.shape as usize];
        let record = |leaf: &windfall_core::foliage::Leaf| {
            let [orientation_xy, orientation_zw] = pack_rotation(leaf.orientation);
            let bent = octahedral(leaf.bent_normal);
            LeafRecord {
                center: leaf.center,
                scale: leaf.scale * kinds.size_of_shape[leaf.shape as usize],
                orientation_xy,
                orientation_zw,
                rank: leaf.shed_rank,
                look: u32::from_le_bytes([
                    leaf.material as u8,
                    (leaf.ambient.clamp(0.0, 1.0) * 255.0).round() as u8,
                    snorm8(bent.x),
                    snorm8(bent.y),
                ]),
            }
        };
        let mut shed_orders = vec![Vec::new(); kinds.shapes.len()];
        for &leaf in &foliage.shed_order {
            shed_orders[kind_of(&foliage.leaves[leaf as usize]) as usize].push(leaf);
        }
        let shape = |(&index, shed_order): (&u32, Vec<u32>)| {
            let shape = &foliage.shapes[index as usize];
            let small = quads.map(|quads| quads.shapes[index as usize].clone());
            LooseShape {
                shed_order,
                thickness: shape.thickness(),
                radius: shape.radius(),
                full: ShapeBuffers::new(device, shape),
                small: small.as_ref().map(|small| ShapeBuffers::new(device, small)),
                geometry: shape.clone(),
                small_geometry: small,
            }
        };
        Self {
            records: foliage.leaves.iter().map(record).collect(),
            shape_of: foliage.leaves.iter().map(kind_of).collect(),
            shapes: kinds.shapes.iter().zip(shed_orders).map(shape).collect(),
        }
    }
}

/// A vertex of a leaf shape: 16 bytes.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct ShapeVertex {
    position: [f16; 4],
    normal: [i8; 4],
    uv: [f16; 2],
}

impl ShapeVertex {
    /// As a vertex buffer.
    pub const LAYOUT: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
        array_stride: size_of::<Self>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &Self::ATTRIBUTES,
    };

    /// Position, normal, texture coordinates.
    pub const ATTRIBUTES: [wgpu::VertexAttribute; 3] =
        wgpu::vertex_attr_array![0 => Float16x4, 1 => Snorm8x4, 2 => Float16x2];

    /// Vertex `i` of a shape.
    pub fn new(shape: &LeafShape, i: usize) -> Self {
        Self {
            position: shape.positions[i].extend(0.0).to_array().map(f16::from_f32),
            normal: snorm(shape.normals[i]),
            uv: shape.uvs[i].to_array().map(f16::from_f32),
        }
    }

    /// As two vectors of a table: place and `u`, normal and `v`, as precise as the vertex itself.
    pub fn texels(&self) -> [glam::UVec4; 2] {
        let [x, y, z, _] = self.position.map(f16::to_f32);
        let [u, v] = self.uv.map(f16::to_f32);
        let [nx, ny, nz, _] = self.normal.map(|n| f32::from(n) / 127.0);
        [
            crate::base::packing::words(Vec4::new(x, y, z, u)),
            crate::base::packing::words(Vec4::new(nx, ny, nz, v)),
        ]
    }
}

/// The vertices and indices of a leaf shape.
pub struct ShapeBuffers {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    /// Indices, three a triangle.
    pub index_count: u32,
}

impl ShapeBuffers {
    /// Uploads a shape.
    pub fn new(device: &wgpu::Device, shape: &LeafShape) -> Self {
        let init = |contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("leaf shape"),
                contents,
                usage,
            })
        };
        let vertices: Vec<ShapeVertex> =
            (0..shape.positions.len()).map(|i| ShapeVertex::new(shape, i)).collect();
        Self {
            vertices: init(bytemuck::cast_slice(&vertices), wgpu::BufferUsages::VERTEX),
            indices: init(bytemuck::cast_slice(&shape.indices), wgpu::BufferUsages::INDEX),
            index_count: shape.indices.len() as u32,
        }
    }

    /// Sets vertex buffer 0 and the index buffer.
    pub fn set(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
    }
}

/// Which shapes stand for which.
struct Kinds {
    /// Shapes of the foliage that are drawn.
    shapes: Vec<u32>,
    /// Of each shape of the foliage the index in `shapes` of the one that stands for it.
    of_shape: Vec<u32>,
    /// Of each the factor by which that one is drawn larger.
    size_of_shape: Vec<f32>,
}

/// All shapes, or, where there are more than [`MOST_SHAPES`], some that stand for all: the shapes are cut in two where
/// they differ most, time and again, and of each part the one nearest to its mean is drawn.
fn kinds(foliage: &Foliage) -> Kinds {
    let count = foliage.shapes.len();
    let mut kinds = Kinds {
        shapes: (0..count as u32).collect(),
        of_shape: (0..count as u32).collect(),
        size_of_shape: vec![1.0; count],
    };
    if count <= MOST_SHAPES {
        return kinds;
    }
    let forms: Vec<Form> = foliage.shapes.iter().map(form).collect();
    let mut parts: Vec<Vec<u32>> = vec![kinds.shapes.clone()];
    while parts.len() < MOST_SHAPES {
        // The part that is spread widest, and along what.
        let spreads = parts.iter().enumerate().map(|(i, part)| {
            let (axis, spread) = widest(&forms, part);
            (spread * part.len() as f32, i, axis)
        });
        let Some((spread, i, axis)) = spreads.max_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        if spread <= 0.0 {
            break;
        }
        let mut part = std::mem::take(&mut parts[i]);
        let middle = part.len() / 2;
        part.select_nth_unstable_by(middle, |&a, &b| {
            let along = |shape: u32| forms[shape as usize][axis];
            along(a).total_cmp(&along(b)).then(a.cmp(&b))
        });
        parts.push(part.split_off(middle));
        parts[i] = part;
    }
    kinds.shapes.clear();
    for (kind, part) in (0..).zip(&parts) {
        let mean = mean(&forms, part);
        let away = |shape: &u32| {
            let form = &forms[*shape as usize];
            form.iter().zip(mean).map(|(x, m)| (x - m) * (x - m)).sum::<f32>()
        };
        let Some(&chosen) = part.iter().min_by(|a, b| away(a).total_cmp(&away(b)).then(a.cmp(b)))
        else {
            continue;
        };
        kinds.shapes.push(chosen);
        let radius = foliage.shapes[chosen as usize].radius().max(f32::MIN_POSITIVE);
        for &shape in part {
            kinds.of_shape[shape as usize] = kind;
            kinds.size_of_shape[shape as usize] = foliage.shapes[shape as usize].radius() / radius;
        }
    }
    kinds
}

/// What tells shapes apart, whatever their size: how far they reach along their axes, as parts of their radius, and the
/// part of the picture that they show.
type Form = [f32; 10];

fn form(shape: &LeafShape) -> Form {
    let radius = shape.radius().max(f32::MIN_POSITIVE);
    let place = |p: &glam::Vec3| *p / radius;
    let places = || shape.positions.iter().map(place);
    let [low, high] = [places().reduce(glam::Vec3::min), places().reduce(glam::Vec3::max)]
        .map(Option::unwrap_or_default);
    let uvs = || shape.uvs.iter().copied();
    let [first, last] =
        [uvs().reduce(Vec2::min), uvs().reduce(Vec2::max)].map(Option::unwrap_or_default);
    [low.x, low.y, low.z, high.x, high.y, high.z, first.x, first.y, last.x, last.y]
}

fn mean(forms: &[Form], part: &[u32]) -> Form {
    std::array::from_fn(|axis| {
        let sum: f32 = part.iter().map(|&shape| forms[shape as usize][axis]).sum();
        sum / part.len().max(1) as f32
    })
}

/// The axis along which a part is spread widest, and its variance.
fn widest(forms: &[Form], part: &[u32]) -> (usize, f32) {
    let mean = mean(forms, part);
    let variance = |axis: usize| {
        let away = part.iter().map(|&shape| forms[shape as usize][axis] - mean[axis]);
        away.map(|x| x * x).sum::<f32>() / part.len().max(1) as f32
    };
    let axes = (0..mean.len()).map(|axis| (axis, variance(axis)));
    axes.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Quat, Vec3};
    use windfall_core::foliage::Leaf;

    /// A card so wide and so long, in metres, with a part of a picture.
    fn card(width: f32, length: f32, u: f32) -> LeafShape {
        let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)];
        LeafShape {
            positions: corners.map(|(x, z)| Vec3::new(x * width, 0.0, z * length)).into(),
            normals: vec![Vec3::Y; 4],
            uvs: corners.map(|(x, z)| Vec2::new(u + 0.1 * x, 0.5 + z)).into(),
            indices: vec![0, 2, 1, 0, 3, 2],
        }
    }

    fn foliage(shapes: Vec<LeafShape>) -> Foliage {
        let leaf = |shape| Leaf {
            center: Vec3::Y,
            orientation: Quat::IDENTITY,
            scale: 1.0,
            shape,
            material: 0,
            bent_normal: Vec3::Y,
            ambient: 1.0,
            shed_rank: 0,
        };
        let leaves = (0..shapes.len() as u32).map(leaf).collect();
        Foliage { shapes, leaves, ..Foliage::default() }
    }

    #[test]
    fn few_shapes_stand_for_themselves() {
        let few = (1..=MOST_SHAPES).map(|i| card(0.01 * i as f32, 0.1, 0.0)).collect();
        let kinds = kinds(&foliage(few));
        assert_eq!(kinds.of_shape, (0..MOST_SHAPES as u32).collect::<Vec<_>>());
        assert!(kinds.size_of_shape.iter().all(|&size| size == 1.0));
    }

    #[test]
    fn some_shapes_stand_for_many_like_them() {
        // Narrow and wide ones with two pictures, in sizes from 1 to 11.
        let shapes: Vec<LeafShape> = (0..1000)
            .map(|i| {
                let size = 0.01 * (1.0 + 0.01 * i as f32);
                let width = if i % 2 == 0 { 0.2 } else { 0.9 } + 1e-4 * (i % 7) as f32;
                card(width * size, size, if i % 4 < 2 { 0.25 } else { 0.75 })
            })
            .collect();
        let foliage = foliage(shapes);
        let kinds = kinds(&foliage);
        assert!(kinds.shapes.len() <= MOST_SHAPES, "{}", kinds.shapes.len());
        for (i, shape) in foliage.shapes.iter().enumerate() {
            let drawn = &foliage.shapes[kinds.shapes[kinds.of_shape[i] as usize] as usize];
            let size = kinds.size_of_shape[i];
            assert!((drawn.radius() * size / shape.radius() - 1.0).abs() < 1e-5, "size of {i}");
            for (a, b) in drawn.positions.iter().zip(&shape.positions) {
                assert!(a.distance(*b / size) < 0.01 * drawn.radius(), "form of {i}");
            }
            assert!((drawn.uvs[0].x - shape.uvs[0].x).abs() < 0.01, "picture of {i}");
        }
    }
}
