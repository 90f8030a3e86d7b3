//! Leaf shapes in few triangles: all that a leaf needs whose outline is a few pixels wide.

use crate::foliage::{Foliage, LeafShape};

/// Triangles of a simple shape.
const TRIANGLES: usize = 2;

/// Trees of which a smaller share of the leaves is drawn than this, those that fade included, are drawn
/// with simple shapes: `2^-1/4`, the first step of the lists that trees are drawn in.
pub const SIMPLE_BELOW: f32 = 0.840_896_4;

/// For each shape of a foliage one of two triangles, of the same area about the same centre, for trees
/// so far away that they are simplified: there a leaf is a few pixels wide, and its vertices are most
/// of what it costs. `None` where a shape has holes, or would not come down to two thirds of its
/// triangles.
///
/// Edges collapse where that changes the outline the least (M. Garland, P. Heckbert, "Surface
/// Simplification Using Quadric Error Metrics", SIGGRAPH 1997, as meshoptimizer has it). In browsers,
/// where meshoptimizer is not built, there are none.
pub fn simple_shapes(foliage: &Foliage) -> Vec<Option<LeafShape>> {
    let mut holes = vec![false; foliage.shapes.len()];
    for leaf in &foliage.leaves {
        let material = foliage.materials.get(leaf.material as usize);
        holes[leaf.shape as usize] |= material.is_some_and(|m| m.alpha_cutoff.is_some());
    }
    let shapes = foliage.shapes.iter().zip(holes);
    shapes.map(|(shape, holes)| if holes { None } else { simple_shape(shape) }).collect()
}

/// Vertices keep their normals and texture coordinates.
fn simple_shape(shape: &LeafShape) -> Option<LeafShape> {
    let indices = collapsed(shape)?;
    let mut out = LeafShape::default();
    let mut new = vec![u32::MAX; shape.positions.len()];
    for old in indices.into_iter().map(|i| i as usize) {
        if new[old] == u32::MAX {
            new[old] = out.positions.len() as u32;
            out.positions.push(shape.positions[old]);
            out.normals.push(shape.normals[old]);
            out.uvs.push(shape.uvs[old]);
        }
        out.indices.push(new[old]);
    }
    let growth = (shape.area() / out.area()).sqrt();
    // What has lost most of its area was no blade: many small ones, or a crumpled one.
    let kept = growth.is_finite() && growth < 2.0;
    if !kept || 3 * out.indices.len() > 2 * shape.indices.len() {
        return None;
    }
    for position in &mut out.positions {
        *position *= growth;
    }
    Some(out)
}

#[cfg(target_arch = "wasm32")]
fn collapsed(_: &LeafShape) -> Option<Vec<u32>> {
    None
}

#[cfg(not(target_arch = "wasm32"))]
fn collapsed(shape: &LeafShape) -> Option<Vec<u32>> {
    use meshopt::{SimplifyOptions, VertexDataAdapter};
    let positions: Vec<[f32; 3]> = shape.positions.iter().map(glam::Vec3::to_array).collect();
    let bytes: &[u8] = bytemuck::cast_slice(&positions);
    if shape.indices.len() <= 3 * TRIANGLES {
        return None; // meshoptimizer takes it for a mistake to ask for more than there is
    }
    let vertices = VertexDataAdapter::new(bytes, size_of::<[f32; 3]>(), 0).ok()?;
    let none = SimplifyOptions::empty();
    Some(meshopt::simplify(&shape.indices, &vertices, 3 * TRIANGLES, f32::MAX, none, None))
}

#[cfg(all(test, not(target_arch = "wasm32")))]
mod tests {
    use super::*;
    use crate::tree::species::Species;
    use glam::{Vec2, Vec3};

    #[test]
    fn leaves_of_each_species_keep_their_area_and_size_in_two_triangles() {
        for species in Species::ALL {
            let foliage = species.grow_with(1, 60).foliage;
            for (shape, simple) in foliage.shapes.iter().zip(simple_shapes(&foliage)) {
                let Some(simple) = simple else {
                    assert!(shape.indices.len() < 9, "{species}: {}", shape.indices.len() / 3);
                    continue;
                };
                assert_eq!((simple.positions.len(), simple.indices.len()), (4, 6), "{species}");
                assert!((simple.area() / shape.area() - 1.0).abs() < 1e-5);
                // The petiole, which is a third of a birch's leaf, is gone.
                let size = simple.radius() / shape.radius();
                assert!((0.5..1.3).contains(&size), "{species}: {size}");
                assert!(simple.normals.iter().all(|n| shape.normals.contains(n)));
            }
        }
    }

    #[test]
    fn shapes_with_holes_quads_and_poison_stay_as_they_are() {
        let mut foliage = Species::Maple.grow_with(1, 60).foliage;
        foliage.materials[0].alpha_cutoff = Some(0.5);
        assert!(simple_shapes(&foliage).iter().all(Option::is_none));
        foliage.materials[0].alpha_cutoff = None;
        assert!(simple_shapes(&foliage).iter().all(Option::is_some));
        let quad = LeafShape {
            positions: [(0, 0), (1, 0), (1, 1), (0, 1)]
                .map(|(x, z)| Vec3::new(x as f32, 0.0, z as f32))
                .to_vec(),
            normals: vec![Vec3::Y; 4],
            uvs: vec![Vec2::ZERO; 4],
            indices: vec![0, 2, 1, 0, 3, 2],
        };
        assert_eq!(simple_shape(&quad), None);
        for bad in [Vec3::NAN, Vec3::INFINITY] {
            let mut shape = foliage.shapes[0].clone();
            shape.positions[3] = bad;
            if let Some(simple) = simple_shape(&shape) {
                assert!(simple.positions.iter().all(|p| p.is_finite()));
            }
        }
        let point = LeafShape { positions: vec![Vec3::ZERO; 4], ..quad };
        assert_eq!(simple_shape(&point), None);
        assert_eq!(simple_shape(&LeafShape::default()), None);
    }
}
