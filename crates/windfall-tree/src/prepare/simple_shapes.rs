//! Leaf shapes in two triangles, for leaves a few pixels wide.

use super::visibility::sky;
use glam::Vec3;
use windfall_core::foliage::{Foliage, LeafShape};
use windfall_core::simplify::as_quad;

/// From which an outline is looked at: from the opposite one it is the same.
const DIRECTIONS: usize = 64;

/// Computes [`Foliage::simple_shapes`]: for each shape one of two triangles with the same mean projected area, about
/// the same centre. For simplified trees, where a leaf is a few pixels wide and its vertices are most of its cost.
/// `None` where a shape has holes, or would keep more than two thirds of its triangles.
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
    let growth = (silhouette(shape) / silhouette(&out)).sqrt();
    // What has lost most of its area was no blade: many small ones, or a crumpled one.
    let kept = growth.is_finite() && growth < 2.0;
    if !kept || 3 * out.indices.len() > 2 * shape.indices.len() {
        return None;
    }
    for position in &mut out.positions {
        *position *= growth;
    }
    Some(as_quad(&out).unwrap_or(out))
}

/// Area of a leaf's outline, square metres: the mean over all directions. Half the area of a flat leaf,
/// less of one that is folded or curled, since in part it hides itself.
///
/// In each direction what turns one side to it, or the other, whichever is more: of a fold the smaller part
/// lies before or behind the larger.
fn silhouette(shape: &LeafShape) -> f32 {
    let area = |d: Vec3| {
        let (mut sum, mut signed) = (0.0, 0.0);
        for t in shape.indices.chunks_exact(3) {
            let [a, b, c] = [t[0], t[1], t[2]].map(|i| shape.positions[i as usize]);
            let facing = (b - a).cross(c - a).dot(d) / 2.0;
            sum += facing.abs();
            signed += facing;
        }
        f32::midpoint(sum, signed.abs())
    };
    sky(DIRECTIONS).into_iter().map(area).sum::<f32>() / DIRECTIONS as f32
}

#[cfg(target_arch = "wasm32")]
fn collapsed(_: &LeafShape) -> Option<Vec<u32>> {
    None
}

#[cfg(not(target_arch = "wasm32"))]
fn collapsed(shape: &LeafShape) -> Option<Vec<u32>> {
    use meshopt::{SimplifyOptions, VertexDataAdapter};
    const TRIANGLES: usize = 2;
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
    use crate::Species;
    use glam::{Vec2, Vec3};

    #[test]
    fn leaves_of_each_species_keep_their_size_in_two_triangles() {
        for species in Species::ALL {
            let foliage = species.grow_with(1, 60).foliage;
            for (shape, simple) in foliage.shapes.iter().zip(simple_shapes(&foliage)) {
                let Some(simple) = simple else {
                    assert!(shape.indices.len() < 9, "{species}: {}", shape.indices.len() / 3);
                    continue;
                };
                assert_eq!((simple.positions.len(), simple.indices.len()), (4, 6), "{species}");
                // What hid itself of a folded or curled leaf is gone, or the two triangles hide more.
                let area = simple.area() / shape.area();
                assert!((0.9..1.05).contains(&area), "{species}: {area}");
                // The petiole, which is a third of a birch's leaf, is gone.
                let size = simple.radius() / shape.radius();
                assert!((0.5..1.3).contains(&size), "{species}: {size}");
                assert!(simple.normals.iter().all(|n| shape.normals.contains(n)));
            }
        }
    }

    #[test]
    fn an_outline_is_half_of_a_flat_leaf_and_a_quarter_of_a_closed_one() {
        // Two squares that share an edge, the second turned about it.
        let folded = |angle: f32| {
            let (sin, cos) = angle.sin_cos();
            let at = |x: f32, y: f32| {
                if x > 0.0 { Vec3::new(x * cos, x * sin, y) } else { Vec3::new(x, 0.0, y) }
            };
            LeafShape {
                positions: vec![
                    at(-1.0, 0.0),
                    at(0.0, 0.0),
                    at(1.0, 0.0),
                    at(-1.0, 1.0),
                    at(0.0, 1.0),
                    at(1.0, 1.0),
                ],
                indices: vec![0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4],
                ..LeafShape::default()
            }
        };
        // Of a right angle: from each of two opposite quarters of space the whole is seen, from the others the
        // larger half: 1/π (2 + √2) (the mean over an angle t of both sin t + cos t and the larger of them), of
        // which the mean cosine to the plane across the fold leaves π/4.
        let square = (2.0 + 2f32.sqrt()) / 4.0;
        for (angle, area) in
            [(0.0, 1.0), (std::f32::consts::PI, 0.5), (std::f32::consts::FRAC_PI_2, square)]
        {
            let found = silhouette(&folded(angle));
            assert!((found / area - 1.0).abs() < 0.02, "{angle}: {found} for {area}");
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
