//! Levels of detail of the wood (SFS, 6): branches as far away as a pixel is wider than they are are
//! simplified as leaves are, fewer and wider; the shape of those that are left by meshoptimizer.

use glam::Vec3;
use std::collections::HashMap;
use windfall_core::simplify::{Branch, WoodLevel};
use windfall_core::tree::Wood;

/// Simplifies wood: computes [`Wood::levels`], [`Wood::branches`] and [`Wood::outward`] from the mesh.
///
/// In each level edges collapse where that changes shape, normals and seams of the bark the least
/// (M. Garland, P. Heckbert, "Surface Simplification Using Quadric Error Metrics", SIGGRAPH 1997,
/// as meshoptimizer has it). In browsers, where meshoptimizer is not built, the mesh itself is the
/// only level. Branches vanish evenly over the tree; the widest one never does.
pub fn prepare_wood(wood: &mut Wood) {
    let (branches, outward) = branches(wood);
    let mut levels = vec![WoodLevel { indices: wood.indices.clone(), error: 0.0 }];
    levels.extend(coarser(wood, &branches));
    (wood.levels, wood.branches, wood.outward) = (levels, branches, outward);
}

/// The branch of each vertex: what hangs together by the places of vertices. And whether they face
/// outward.
fn branches(wood: &Wood) -> (Vec<Branch>, bool) {
    let mut places: HashMap<[u32; 3], u32> = HashMap::new();
    let vertices = (0..).zip(&wood.vertices);
    let mut parent: Vec<u32> = vertices
        .map(|(i, v)| *places.entry(v.position.to_array().map(f32::to_bits)).or_insert(i))
        .collect();
    for t in wood.indices.chunks_exact(3) {
        let first = root(&mut parent, t[0]);
        for &corner in &t[1..] {
            let other = root(&mut parent, corner);
            parent[other.max(first) as usize] = other.min(first);
        }
    }
    let count = parent.len();
    let mut bounds = vec![(Vec3::INFINITY, Vec3::NEG_INFINITY); count];
    let mut areas = vec![0.0f32; count];
    // Of its surface what faces where its normals do, and the vector of all: nothing for what is closed,
    // little for an open tube, the whole for a sheet.
    let mut agree = vec![0.0f32; count];
    let mut sums = vec![Vec3::ZERO; count];
    for t in wood.indices.chunks_exact(3) {
        let [a, b, c] = [t[0], t[1], t[2]].map(|i| wood.vertices[i as usize]);
        let of = root(&mut parent, t[0]) as usize;
        let facing = 0.5 * (b.position - a.position).cross(c.position - a.position);
        let agrees = facing.dot(a.normal + b.normal + c.normal) >= 0.0;
        areas[of] += facing.length();
        agree[of] += if agrees { facing.length() } else { 0.0 };
        sums[of] += facing;
        for v in [a, b, c] {
            bounds[of] = (bounds[of].0.min(v.position), bounds[of].1.max(v.position));
        }
    }
    // Of a tube of this surface and this length.
    let radius = |i: usize| {
        let length = (bounds[i].1 - bounds[i].0).length();
        let radius = areas[i] / (2.0 * std::f32::consts::PI * length);
        if radius.is_finite() { radius } else { 0.0 }
    };
    let widest = (0..count).map(radius).fold(0.0, f32::max);
    let mut of_root = vec![Branch { radius: 0.0, vanishes: f32::MAX }; count];
    let mut number = 0.0f64;
    for i in 0..count {
        if areas[i] > 0.0 {
            // Branches that grow from one lie one after the other in a mesh, and multiples of the
            // golden ratio are spread as evenly as can be over each stretch of it.
            number += 0.618_033_988_75;
            let rank = number.fract() as f32;
            let radius = radius(i);
            let vanishes = if radius < widest { radius / rank.max(1e-4) } else { f32::MAX };
            of_root[i] = Branch { radius, vanishes };
        }
    }
    let outward = (0..count).filter(|&i| sums[i].length() < 0.5 * areas[i]).map(|i| agree[i]);
    let outward = outward.sum::<f32>() > 0.99 * areas.iter().sum::<f32>();
    ((0..count as u32).map(|i| of_root[root(&mut parent, i) as usize]).collect(), outward)
}

fn root(parent: &mut [u32], mut at: u32) -> u32 {
    while parent[at as usize] != at {
        let next = parent[parent[at as usize] as usize];
        parent[at as usize] = next;
        at = next;
    }
    at
}

#[cfg(target_arch = "wasm32")]
fn coarser(_: &Wood, _: &[Branch]) -> Vec<WoodLevel> {
    Vec::new()
}

#[cfg(not(target_arch = "wasm32"))]
use quadrics::coarser;

#[cfg(not(target_arch = "wasm32"))]
mod quadrics {
    use crate::parallel;
    use glam::Vec3;
    use meshopt::{SimplifyOptions, VertexDataAdapter};
    use windfall_core::simplify::{Branch, WOOD_FADE, WoodLevel};
    use windfall_core::tree::Wood;

    /// The smallest error that is tried, metres, and what the next one is over it.
    const FIRST: f32 = 0.002;
    const STEP: f32 = 1.2;
    /// Errors that are tried together: the first of them say whether the rest is needed.
    const AT_ONCE: usize = if cfg!(feature = "parallel") { 8 } else { 1 };
    /// Triangles of a level over those of the one before it, at most.
    const LEAST_STEP: f32 = 0.7;
    /// The fewest triangles that are still simplified.
    const FEW: usize = 24;
    /// What a difference of 1 in a normal weighs against one of the mesh's extent in place.
    const NORMAL_WEIGHT: f32 = 0.02;

    pub fn coarser(wood: &Wood, branches: &[Branch]) -> Vec<WoodLevel> {
        let mut levels: Vec<WoodLevel> = Vec::new();
        if wood.vertices.iter().any(|v| !v.position.is_finite()) {
            return levels;
        }
        let extent = wood.vertices.iter().map(|v| v.position.length()).fold(0.0, f32::max);
        // The last has a pixel half as large as the tree.
        let errors: Vec<f32> = std::iter::successors(Some(FIRST), |error| Some(error * STEP))
            .take_while(|&error| error < 0.25 * extent)
            .collect();
        let mut count = wood.indices.len();
        for errors in errors.chunks(AT_ONCE) {
            let tried = parallel::map(errors, |&error| simplified(wood, branches, error));
            for (indices, &error) in tried.into_iter().zip(errors) {
                let Some(indices) = indices.filter(|_| count > 3 * FEW) else { return levels };
                if indices.len() as f32 <= count as f32 * LEAST_STEP {
                    count = indices.len();
                    levels.push(WoodLevel { indices, error });
                }
            }
        }
        levels
    }

    /// The triangles that are left with an error; `None` if none are.
    ///
    /// Always from the mesh itself: errors that add up would be overestimated.
    fn simplified(wood: &Wood, branches: &[Branch], error: f32) -> Option<Vec<u32>> {
        let vertices = wood.vertices.iter().zip(branches);
        // As wide as a branch is before it fades: one that is nearly nothing would collapse.
        let moved: Vec<Vec3> = vertices
            .map(|(v, b)| v.position + v.normal * (b.radius.max(error) - b.radius))
            .collect();
        // Vertices of branches that have vanished are left out, except those that bound the tree: normals weigh
        // against its extent.
        let mut new_index = vec![u32::MAX; moved.len()];
        let is_left = |branch: &Branch| branch.vanishes * (1.0 + WOOD_FADE) > error;
        let left = || wood.indices.chunks_exact(3).filter(|t| is_left(&branches[t[0] as usize]));
        for &corner in left().flatten() {
            new_index[corner as usize] = 0;
        }
        for axis in 0..3 {
            let along = |a: &&Vec3, b: &&Vec3| a[axis].total_cmp(&b[axis]);
            let ends = [moved.iter().min_by(along), moved.iter().max_by(along)];
            for end in ends.into_iter().flatten() {
                if let Some(at) = moved.iter().position(|p| p[axis] == end[axis]) {
                    new_index[at] = 0;
                }
            }
        }
        let (mut positions, mut normals, mut old_index) = (Vec::new(), Vec::new(), Vec::new());
        for (old, new) in new_index.iter_mut().enumerate().filter(|(_, new)| **new == 0) {
            *new = old_index.len() as u32;
            old_index.push(old as u32);
            positions.push(moved[old].to_array());
            normals.extend(wood.vertices[old].normal.to_array());
        }
        let left: Vec<u32> = left().flatten().map(|&corner| new_index[corner as usize]).collect();
        let bytes: &[u8] = bytemuck::cast_slice(&positions);
        let vertices = VertexDataAdapter::new(bytes, size_of::<[f32; 3]>(), 0).ok()?;
        let mut indices = meshopt::simplify_with_attributes_and_locks(
            &left,
            &vertices,
            &normals,
            &[NORMAL_WEIGHT; 3],
            size_of::<[f32; 3]>(),
            &vec![false; positions.len()],
            0,
            error,
            SimplifyOptions::ErrorAbsolute,
            None,
        );
        for index in &mut indices {
            *index = old_index[*index as usize];
        }
        (!indices.is_empty()).then_some(indices)
    }
}

#[cfg(all(test, not(target_arch = "wasm32")))]
mod tests {
    use super::*;
    use crate::Species;
    use glam::{Vec2, Vec3};
    use std::f32::consts::TAU;
    use windfall_core::tree::WoodVertex;

    fn prepared(mut wood: Wood) -> Wood {
        prepare_wood(&mut wood);
        wood
    }

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
            let levels = prepared(wood.clone()).levels;
            assert_eq!(levels[0], WoodLevel { indices: wood.indices.clone(), error: 0.0 });
            assert!(levels.len() > 8, "{species}: {}", levels.len());
            for pair in levels.windows(2) {
                assert!(pair[1].error > pair[0].error);
                assert!(pair[1].indices.len() as f32 <= 0.7 * pair[0].indices.len() as f32);
                assert!(pair[1].indices.iter().all(|&i| (i as usize) < wood.vertices.len()));
            }
            let last = &levels[levels.len() - 1];
            assert!(last.indices.len() < 3 * 100, "{species}: {}", last.indices.len());
            assert!(last.error < 1.25, "{species}: {}", last.error);
        }
    }

    #[test]
    fn a_straight_tube_keeps_its_surface_in_a_tenth_of_the_triangles() {
        let mut wood = Wood::default();
        tube(&mut wood, Vec3::ZERO, 0.2, 5.0, 60, 12);
        let levels = prepared(wood.clone()).levels;
        let coarse = levels.iter().find(|l| l.indices.len() * 10 <= wood.indices.len()).unwrap();
        assert!(coarse.error < 0.03, "{}", coarse.error);
        let kept = area(&wood, coarse) / area(&wood, &levels[0]);
        assert!((0.9..1.05).contains(&kept), "{kept}");
        let tops = coarse.indices.iter().map(|&i| wood.vertices[i as usize].position.y);
        let (low, high) = tops.fold((9.0f32, -9.0f32), |(l, h), y| (l.min(y), h.max(y)));
        assert!(low < 0.05 && high > 4.95, "{low} to {high}");
    }

    /// A trunk of 30 cm and `twigs` of 4 mm, in which the trunk comes first.
    fn bush(twigs: u32) -> Wood {
        let mut wood = Wood::default();
        tube(&mut wood, Vec3::ZERO, 0.3, 6.0, 40, 12);
        for i in 0..twigs {
            let foot = Vec3::new(1.0 + (i % 16) as f32, (i / 16) as f32, 0.0);
            tube(&mut wood, foot, 0.004, 0.5, 2, 6);
        }
        wood
    }

    #[test]
    fn thin_branches_are_as_wide_as_a_pixel_and_as_many_fewer() {
        let wood = bush(512);
        let simple = prepared(wood.clone());
        let trunk = 41 * 13;
        let twigs: Vec<Branch> = simple.branches[trunk..].iter().step_by(3 * 7).copied().collect();
        assert_eq!(twigs.len(), 512);
        // The surface of a tube of six sides is 0.95 times that of a round one.
        for twig in &twigs {
            assert!((0.0036..0.004).contains(&twig.radius), "{twig:?}");
        }
        // Widths over the branches' own, in sum; an error of 3.4 radii and more, of which 5 to 150 are left.
        for error in [0.013, 0.05, 0.1] {
            let drawn = |b: &Branch| b.radius + b.widening(error);
            let sum = twigs.iter().map(drawn).sum::<f32>();
            let own = twigs.iter().map(|b| b.radius).sum::<f32>();
            assert!((sum / own - 1.0).abs() < 0.06, "{error}: {sum} for {own}");
            let left = twigs.iter().filter(|b| drawn(b) > 0.0).count() as f32;
            let expected = 512.0 * twigs[0].radius / error;
            assert!((0.9..1.35).contains(&(left / expected)), "{error}: {left} for {expected}");
        }
        // Nothing moves where wood is drawn as it is, and little before twigs are as thin as a pixel.
        assert!(twigs.iter().all(|b| b.widening(0.0) == 0.0));
        let early = twigs.iter().map(|b| b.widening(0.003)).sum::<f32>();
        assert!(early.abs() < 0.03 * 512.0 * 0.004, "{early}");
        let wide = simple.branches[0];
        assert!((wide.radius - 0.3).abs() < 0.02 && wide.widening(5.0) + wide.radius == 5.0);
    }

    #[test]
    fn tubes_face_outward_and_sheets_do_not() {
        let mut wood = bush(16);
        assert!(prepared(wood.clone()).outward);
        for species in Species::ALL {
            assert!(species.grow(1).wood.outward, "{species}");
        }
        let mut inside_out = wood.clone();
        inside_out.indices.chunks_exact_mut(3).for_each(|t| t.swap(1, 2));
        assert!(!prepared(inside_out).outward);
        // A sheet as large as the twigs' surface.
        let first = wood.vertices.len() as u32;
        for corner in [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y] {
            let position = 3.0 + 0.5 * corner.extend(0.0);
            let vertex = WoodVertex { position, normal: Vec3::Z, uv: corner, material: 0 };
            wood.vertices.push(vertex);
        }
        wood.indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
        assert!(!prepared(wood.clone()).outward);
    }

    #[test]
    fn levels_hold_the_branches_that_are_left_and_no_others() {
        let wood = bush(512);
        let simple = prepared(wood.clone());
        assert!(simple.levels.len() > 4, "{}", simple.levels.len());
        for level in &simple.levels[1..] {
            let mut held = vec![false; wood.vertices.len()];
            level.indices.iter().for_each(|&i| held[i as usize] = true);
            for (range, branch) in
                (0..512).map(|i| 533 + 21 * i).map(|at| (at..at + 21, simple.branches[at]))
            {
                let left = branch.radius + branch.widening(level.error) > 0.0;
                assert_eq!(held[range].contains(&true), left, "{branch:?} at {}", level.error);
            }
        }
    }

    #[test]
    fn poison_is_one_level() {
        assert_eq!(prepared(Wood::default()).levels.len(), 1);
        for bad in [Vec3::NAN, Vec3::INFINITY] {
            let mut wood = Wood::default();
            tube(&mut wood, Vec3::ZERO, 0.3, 6.0, 40, 12);
            wood.vertices[7].position = bad;
            assert_eq!(prepared(wood.clone()).levels.len(), 1);
        }
        let mut point = Wood::default();
        tube(&mut point, Vec3::ONE, 0.0, 0.0, 40, 12);
        for level in prepared(point).levels {
            assert!(level.error.is_finite() && level.indices.len().is_multiple_of(3));
        }
    }
}
