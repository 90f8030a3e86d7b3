//! The form that a leaf is drawn in, and how two triangles become a quad.

use super::Simplification;
use crate::foliage::LeafShape;

/// Leaves are lit at their vertices up to this many times [`Simplification::leaf_pixels`]: at 25 pixels only
/// veins and blotches are lost.
pub const LIT_AT_VERTICES: f32 = 2.5;

/// The form that a leaf is drawn in. It follows from the leaf's own length in the picture as it is drawn, grown and
/// faded, and from nothing that the leaves of a tree have in common: so leaves change form one by one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LeafForm {
    /// Its outline, lit in each pixel.
    Pixels,
    /// Its outline, lit at its vertices.
    Outline,
    /// Two triangles, lit once.
    Simple,
}

impl Simplification {
    /// The form of a leaf that is `pixels` long in the picture; `lit_in_pixels` is whether any is lit in each pixel.
    pub fn leaf_form(&self, pixels: f32, lit_in_pixels: bool) -> LeafForm {
        if pixels < self.leaf_pixels {
            LeafForm::Simple
        } else if pixels < self.lit_leaf_pixels(lit_in_pixels) {
            LeafForm::Outline
        } else {
            LeafForm::Pixels
        }
    }

    /// Length from which on leaves are lit in each pixel, pixels; infinite if none is.
    pub fn lit_leaf_pixels(&self, lit_in_pixels: bool) -> f32 {
        if lit_in_pixels { LIT_AT_VERTICES * self.leaf_pixels } else { f32::INFINITY }
    }
}

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
    fn the_form_of_a_leaf_follows_from_its_length() {
        let detail = Simplification { leaf_pixels: 8.0, ..Simplification::DEFAULT };
        let form = |pixels| detail.leaf_form(pixels, true);
        assert_eq!(
            [7.9, 8.0, 19.9].map(form),
            [LeafForm::Simple, LeafForm::Outline, LeafForm::Outline]
        );
        assert_eq!(
            (form(20.0), detail.leaf_form(20.0, false)),
            (LeafForm::Pixels, LeafForm::Outline)
        );
        assert_eq!(Simplification::NONE.leaf_form(0.1, true), LeafForm::Pixels);
    }

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
