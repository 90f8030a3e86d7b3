//! Levels of detail of the wood (SFS, 6): its mesh in ever fewer triangles, by meshoptimizer.

use crate::tree::Wood;

/// One level of detail of the wood.
#[derive(Debug, Clone, PartialEq)]
pub struct WoodLevel {
    /// Triangles, three indices each into [`Wood::vertices`].
    pub indices: Vec<u32>,
    /// How far the surface may be from the wood's own, metres, and how wide a twig may be that is
    /// gone.
    pub error: f32,
}

/// Levels of detail of the wood, finest first: the mesh itself with error 0, then each with at most
/// 0.7 times the triangles of the one before it and a larger error, down to a few dozen. Indices
/// refer to the wood's vertices as they are.
///
/// Edges collapse where that changes shape, normals and seams of the bark the least, and parts that
/// hang together by themselves, such as twigs, vanish once they are smaller than the error (M.
/// Garland, P. Heckbert, "Surface Simplification Using Quadric Error Metrics", SIGGRAPH 1997, as
/// meshoptimizer has it). In browsers, where meshoptimizer is not built, the mesh itself is the only
/// level.
pub fn wood_levels(wood: &Wood) -> Vec<WoodLevel> {
    let mut levels = vec![WoodLevel { indices: wood.indices.clone(), error: 0.0 }];
    levels.extend(coarser(wood));
    levels
}

#[cfg(target_arch = "wasm32")]
fn coarser(_: &Wood) -> Vec<WoodLevel> {
    Vec::new()
}

#[cfg(not(target_arch = "wasm32"))]
use quadrics::coarser;

impl WoodLevel {
    /// The coarsest of `levels` whose error is at most `error` metres; the finest if none is.
    ///
    /// # Panics
    ///
    /// If there is no level.
    pub fn within(levels: &[Self], error: f32) -> &Self {
        &levels[levels.partition_point(|level| level.error <= error).max(1) - 1]
    }
}

#[cfg(not(target_arch = "wasm32"))]
mod quadrics {
    use super::WoodLevel;
    use crate::tree::Wood;
    use meshopt::{SimplifyOptions, VertexDataAdapter};

    /// Triangles of a level over those of the one before it, as asked for and at most.
    const STEP: f32 = 0.6;
    const LEAST_STEP: f32 = 0.7;
    /// The fewest triangles that are still simplified.
    const FEW: usize = 24;
    /// What a difference of 1 in a normal weighs against one of the mesh's extent in place.
    const NORMAL_WEIGHT: f32 = 0.02;

    pub fn coarser(wood: &Wood) -> Vec<WoodLevel> {
        let mut levels: Vec<WoodLevel> = Vec::new();
        let positions: Vec<[f32; 3]> =
            wood.vertices.iter().map(|v| v.position.to_array()).collect();
        let normals: Vec<f32> = wood.vertices.iter().flat_map(|v| v.normal.to_array()).collect();
        let bytes: &[u8] = bytemuck::cast_slice(&positions);
        let Ok(vertices) = VertexDataAdapter::new(bytes, size_of::<[f32; 3]>(), 0) else {
            return levels;
        };
        let options = SimplifyOptions::Prune | SimplifyOptions::ErrorAbsolute;
        let free = vec![false; positions.len()];
        let mut count = wood.indices.len();
        while count > 3 * FEW {
            let mut error = 0.0;
            // Always from the mesh itself: errors that add up would be overestimated.
            let indices = meshopt::simplify_with_attributes_and_locks(
                &wood.indices,
                &vertices,
                &normals,
                &[NORMAL_WEIGHT; 3],
                size_of::<[f32; 3]>(),
                &free,
                (count as f32 * STEP) as usize / 3 * 3,
                f32::MAX,
                options,
                Some(&mut error),
            );
            if indices.is_empty() || indices.len() as f32 > count as f32 * LEAST_STEP {
                break;
            }
            count = indices.len();
            let finer = levels.last().map_or(0.0, |level| level.error);
            levels.push(WoodLevel { indices, error: error.max(finer.next_up()) });
        }
        levels
    }
}

#[cfg(all(test, not(target_arch = "wasm32")))]
mod tests {
    use super::*;
    use crate::tree::WoodVertex;
    use crate::tree::species::Species;
    use glam::{Vec2, Vec3};
    use std::f32::consts::TAU;

    /// Adds a tube of `rings` rings of `around` quads along +Y, its seam split.
    fn tube(wood: &mut Wood, foot: Vec3, radius: f32, length: f32, rings: u32, around: u32) {
        let base = wood.vertices.len() as u32;
        for ring in 0..=rings {
            for side in 0..=around {
                let uv = Vec2::new(side as f32 / around as f32, ring as f32 / rings as f32);
                let (sin, cos) = (uv.x * TAU).sin_cos();
                let normal = Vec3::new(cos, 0.0, sin);
                let position = foot + normal * radius + Vec3::Y * uv.y * length;
                wood.vertices.push(WoodVertex { position, normal, uv, material: 0 });
            }
        }
        for ring in 0..rings {
            for side in 0..around {
                let a = base + ring * (around + 1) + side;
                let b = a + around + 1;
                wood.indices.extend([a, b, a + 1, a + 1, b, b + 1]);
            }
        }
    }

    fn area(wood: &Wood, level: &WoodLevel) -> f32 {
        let triangles = level.indices.chunks_exact(3);
        let double = triangles.map(|t| {
            let [a, b, c] = [t[0], t[1], t[2]].map(|i| wood.vertices[i as usize].position);
            (b - a).cross(c - a).length()
        });
        double.sum::<f32>() / 2.0
    }

    #[test]
    fn levels_go_down_in_small_steps_from_the_mesh_itself() {
        for species in [Species::Oak, Species::Birch] {
            let wood = species.grow(1).wood;
            let levels = wood_levels(&wood);
            assert_eq!(levels[0], WoodLevel { indices: wood.indices.clone(), error: 0.0 });
            assert!(levels.len() > 8, "{species}: {}", levels.len());
            for pair in levels.windows(2) {
                assert!(pair[1].error > pair[0].error);
                assert!(pair[1].indices.len() as f32 <= 0.7 * pair[0].indices.len() as f32);
                assert!(pair[1].indices.iter().all(|&i| (i as usize) < wood.vertices.len()));
            }
            let last = &levels[levels.len() - 1];
            assert!(last.indices.len() < 3 * 100, "{species}: {}", last.indices.len());
            assert!(last.error < 1.0, "{species}: {}", last.error);
        }
    }

    #[test]
    fn a_straight_tube_keeps_its_surface_in_a_tenth_of_the_triangles() {
        let mut wood = Wood::default();
        tube(&mut wood, Vec3::ZERO, 0.2, 5.0, 60, 12);
        let levels = wood_levels(&wood);
        let coarse = levels.iter().find(|l| l.indices.len() * 10 <= wood.indices.len()).unwrap();
        assert!(coarse.error < 0.03, "{}", coarse.error);
        let kept = area(&wood, coarse) / area(&wood, &levels[0]);
        assert!((0.9..1.05).contains(&kept), "{kept}");
        let tops = coarse.indices.iter().map(|&i| wood.vertices[i as usize].position.y);
        let (low, high) = tops.fold((9.0f32, -9.0f32), |(l, h), y| (l.min(y), h.max(y)));
        assert!(low < 0.05 && high > 4.95, "{low} to {high}");
    }

    #[test]
    fn twigs_vanish_before_the_trunk_does() {
        let mut wood = Wood::default();
        tube(&mut wood, Vec3::ZERO, 0.3, 6.0, 40, 12);
        // Gnarled, so that it needs its triangles.
        for vertex in &mut wood.vertices {
            vertex.position += vertex.normal * 0.15 * (3.0 * vertex.position.y).sin();
        }
        let trunk = wood.vertices.len() as u32;
        for i in 0..6 {
            tube(&mut wood, Vec3::new(1.0, i as f32, 0.0), 0.004, 0.05, 4, 6);
        }
        let levels = wood_levels(&wood);
        let bare = levels.iter().find(|l| l.indices.iter().all(|&i| i < trunk));
        let bare = bare.map(|level| (level.error, level.indices.len() / 3));
        assert!(bare.is_some_and(|(error, count)| error < 0.06 && count > 20), "{bare:?}");
    }

    #[test]
    fn the_coarsest_level_within_an_error_is_chosen() {
        let level = |error| WoodLevel { indices: vec![], error };
        let levels = [level(0.0), level(0.01), level(0.05)];
        for (error, chosen) in [(0.0, 0.0), (0.009, 0.0), (0.01, 0.01), (0.04, 0.01), (9.0, 0.05)] {
            assert_eq!(WoodLevel::within(&levels, error).error, chosen, "{error}");
        }
        assert_eq!(WoodLevel::within(&levels, -1.0).error, 0.0);
        assert_eq!(WoodLevel::within(&levels, f32::NAN).error, 0.0);
    }

    #[test]
    fn poison_is_one_level() {
        assert_eq!(wood_levels(&Wood::default()).len(), 1);
        for bad in [Vec3::NAN, Vec3::INFINITY] {
            let mut wood = Wood::default();
            tube(&mut wood, Vec3::ZERO, 0.3, 6.0, 40, 12);
            wood.vertices[7].position = bad;
            assert_eq!(wood_levels(&wood).len(), 1);
        }
        let mut point = Wood::default();
        tube(&mut point, Vec3::ONE, 0.0, 0.0, 40, 12);
        for level in wood_levels(&point) {
            assert!(level.error.is_finite() && level.indices.len().is_multiple_of(3));
        }
    }
}
