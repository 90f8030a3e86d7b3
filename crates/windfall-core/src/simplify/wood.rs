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
    #[cfg(not(target_arch = "wasm32"))]
    quadrics::add(wood, &mut levels);
    levels
}

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
    const FEW: usize = 48;
    /// What a difference of 1 in a normal weighs against one of the mesh's extent in place.
    const NORMAL_WEIGHT: f32 = 0.02;

    pub fn add(wood: &Wood, levels: &mut Vec<WoodLevel>) {
        if wood.indices.is_empty() || wood.vertices.iter().any(|v| !v.position.is_finite()) {
            return;
        }
        let positions: Vec<[f32; 3]> =
            wood.vertices.iter().map(|v| v.position.to_array()).collect();
        let normals: Vec<f32> = wood.vertices.iter().flat_map(|v| v.normal.to_array()).collect();
        let bytes: &[u8] = bytemuck::cast_slice(&positions);
        let Ok(vertices) = VertexDataAdapter::new(bytes, size_of::<[f32; 3]>(), 0) else { return };
        let options = SimplifyOptions::Prune | SimplifyOptions::ErrorAbsolute;
        let free = vec![false; positions.len()];
        let mut count = wood.indices.len();
        while count > 3 * FEW {
            let target = (count as f32 * STEP) as usize / 3 * 3;
            // From the mesh itself each time: errors do not add up.
            let mut error = 0.0;
            let mut indices = meshopt::simplify_with_attributes_and_locks(
                &wood.indices,
                &vertices,
                &normals,
                &[NORMAL_WEIGHT; 3],
                size_of::<[f32; 3]>(),
                &free,
                target,
                f32::MAX,
                options,
                Some(&mut error),
            );
            let most = (count as f32 * LEAST_STEP) as usize;
            if indices.len() > most {
                break;
            }
            count = indices.len();
            let before = levels.last().map_or(0.0, |level| level.error);
            if indices.is_empty() {
                break;
            }
            indices.shrink_to_fit();
            levels.push(WoodLevel { indices, error: error.max(before.next_up()) });
        }
    }
}
