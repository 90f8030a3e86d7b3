//! When leaves are drawn with simple shapes, and how two triangles become a quad.

use crate::foliage::LeafShape;

/// Trees drawn with a smaller share of their leaves than this, fading ones included, use simple shapes at any size:
/// `2^-1/4`, the first step between LOD bins.
pub const SIMPLE_BELOW: f32 = 0.840_896_4;

/// Leaves are lit at their vertices up to this many times [`super::Simplification::leaf_pixels`]: at 25 pixels only
/// veins and blotches are lost.
pub const LIT_AT_VERTICES: f32 = 2.5;

/// Distance from a simplified leaf's centre at which its shadow is sampled, relative to the distance of its corners.
/// A survivor stands for many leaves, so it takes the mean shadow of a larger part of the crown.
pub const SHADE_SPREAD: f32 = 2.5;

/// Reorders a shape of one triangle, or of two that share an edge, into four vertices whose triangles are 0, 1, 2 and
/// 0, 2, 3. A single triangle repeats its last vertex. `None` for any other shape.
pub fn as_quad(shape: &LeafShape) -> Option<LeafShape> {
    let [a, b, c, d] = match *shape.indices.as_slice() {
        [a, b, c] => [a, b, c, c],
        [a, b, c, d, e, f] => {
            let (first, second) = ([a, b, c], [d, e, f]);
            let alone = |of: [u32; 3], other: [u32; 3]| {
                let mut rest = (0..3).filter(|&i| !other.contains(&of[i]));
                rest.next().filter(|_| rest.next().is_none())
            };
            let apex = alone(first, second)?;
            let far = second[alone(second, first)?];
            [first[(apex + 2) % 3], first[apex], first[(apex + 1) % 3], far]
        }
        _ => return None,
    };
    let corners = [a, b, c, d].map(|i| i as usize);
    Some(LeafShape {
        positions: corners.map(|i| shape.positions[i]).to_vec(),
        normals: corners.map(|i| shape.normals[i]).to_vec(),
        uvs: corners.map(|i| shape.uvs[i]).to_vec(),
        indices: vec![0, 1, 2, 0, 2, 3],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};

    #[test]
    fn quads_have_the_triangles_of_their_shapes() {
        let place = |i: u32| Vec3::new((i * i) as f32, i as f32, (i % 3) as f32);
        let shape = |indices: &[u32]| LeafShape {
            positions: (0..6).map(place).collect(),
            normals: (0..6).map(|i| place(i) + Vec3::Y).collect(),
            uvs: (0..6).map(|i| Vec2::splat(i as f32)).collect(),
            indices: indices.to_vec(),
        };
        let triangles = |shape: &LeafShape| {
            let mut corners: Vec<[u32; 3]> = Vec::new();
            for triangle in shape.indices.chunks(3) {
                let mut of = [0, 1, 2].map(|i| shape.uvs[triangle[i] as usize].x as u32);
                of.sort_unstable();
                corners.push(of);
            }
            corners.sort_unstable();
            corners
        };
        let two = [[5, 1, 2, 1, 2, 3], [1, 2, 3, 4, 2, 1], [0, 1, 2, 2, 3, 0], [2, 3, 5, 0, 5, 2]];
        for indices in two {
            let shape = shape(&indices);
            let quad = as_quad(&shape).unwrap();
            assert_eq!(quad.indices, [0, 1, 2, 0, 2, 3]);
            assert_eq!(triangles(&quad), triangles(&shape), "{indices:?}");
            for (i, uv) in quad.uvs.iter().enumerate() {
                assert_eq!(quad.positions[i], place(uv.x as u32));
                assert_eq!(quad.normals[i], place(uv.x as u32) + Vec3::Y);
            }
        }
        let one = as_quad(&shape(&[4, 0, 2])).unwrap();
        assert_eq!(one.uvs.iter().map(|uv| uv.x).collect::<Vec<_>>(), [4.0, 0.0, 2.0, 2.0]);
        let none: [&[u32]; 4] =
            [&[], &[0, 1, 2, 3, 4, 5], &[0, 1, 2, 2, 3, 4], &[0, 1, 2, 2, 1, 0]];
        assert!(none.iter().all(|indices| as_quad(&shape(indices)).is_none()));
    }
}
