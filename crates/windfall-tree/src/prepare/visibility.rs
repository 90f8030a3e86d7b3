//! What is seen of a crown: depth renders of its leaves from outside, on the CPU.

use super::film::{Count, Film};
use super::sunlight;
use glam::Vec3;
use windfall_core::foliage::{Foliage, Leaf, LeafShape};
use windfall_core::material::Surface;
use windfall_core::simplify::{Visibility, area_scale};

/// Directions of the sky in which [`openness`] looks.
const SKY: usize = 32;
/// Fewer leaves than these are not measured: what a few show is chance.
pub(super) const FEW: usize = 16;

/// Measures [`Foliage::visibility`] in the prune order that the leaves have, by renders from five directions, three
/// of them at the horizon. About 40 ms for 10,000 leaves of ten triangles; 0.2 s for 5,000 textured cards, whose
/// sunlight is measured too.
pub fn visibility(foliage: &Foliage) -> Visibility {
    let all = foliage.leaves.len();
    let Some(film) = Film::around(foliage, 4.0) else { return Visibility::default() };
    let sides = few_sides();
    let (drawn, seen) = Count::sum(&film.count(foliage, all, 1.0, &sides));
    if seen == 0 {
        return Visibility::default();
    }
    let share = (drawn as f64 / all as f64 / seen as f64).min(1.0) as f32;
    // How much more than the whole crown a part of it covers: a logarithm, as all that follows.
    let excess = |count, growth| {
        let (_, part) = Count::sum(&film.count(foliage, count, growth, &sides));
        (part.max(1) as f32 / seen as f32).ln()
    };
    let mut disocclusion = Visibility::BY_CHANCE;
    let mut last = 0.0f32;
    for (factor, lambda) in disocclusion.iter_mut().zip(Visibility::MEASURED) {
        let count = (lambda * all as f32).round() as usize;
        if count < FEW {
            *factor = last.exp();
            continue;
        }
        let growth = area_scale(lambda, share).sqrt();
        // A secant, whose first step supposes that half of the area is hidden.
        let found = excess(count, growth);
        let first = (-2.0 * found).clamp(-1.5, 1.5);
        let left = excess(count, growth * (first / 2.0).exp());
        let slope = if first == 0.0 { 0.5 } else { ((left - found) / first).clamp(0.1, 1.0) };
        // As much more or less than the last as still leaves more area to fewer leaves.
        last = (first - left / slope).clamp(last - 0.9 * 4f32.ln(), last + 0.5 * 4f32.ln());
        *factor = last.exp();
    }
    let mut found = Visibility { share, disocclusion, ..Visibility::default() };
    if foliage.materials.iter().any(|m| matches!(m.surface, Surface::Texture(..))) {
        found.sunlight = sunlight::factors(foliage, &found);
    }
    found
}

/// Visible area of each leaf, square metres, in prune order: projected, not hidden by other leaves, the mean over
/// [`sides`].
pub fn visible_areas(foliage: &Foliage) -> Vec<f32> {
    let sides = sides();
    let Some(film) = Film::around(foliage, 1.0) else { return vec![0.0; foliage.leaves.len()] };
    let area = film.pixel_area() / sides.len() as f32;
    film.count(foliage, foliage.leaves.len(), 1.0, &sides)
        .iter()
        .map(|c| c.seen as f32 * area)
        .collect()
}

/// The part of each leaf's area that others do not hide, square metres, in prune order. Its own area and not
/// what is seen of it: from a few sides, leaves that face one of them would count for more.
pub(super) fn open_areas(foliage: &Foliage) -> Vec<f32> {
    let Some(film) = Film::around(foliage, 1.0) else { return vec![0.0; foliage.leaves.len()] };
    let count = film.count(foliage, foliage.leaves.len(), 1.0, &few_sides());
    let areas: Vec<f32> = foliage.shapes.iter().map(LeafShape::area).collect();
    let area = |leaf: &Leaf| leaf.scale * leaf.scale * areas[leaf.shape as usize];
    let leaves = foliage.leaves.iter().zip(seen_parts(&count));
    leaves.map(|(leaf, part)| area(leaf) * part).collect()
}

/// Of each leaf the part that is seen, `0..=1`. A leaf too small to be met by any sample is seen as much as
/// the others.
fn seen_parts(count: &[Count]) -> impl Iterator<Item = f32> {
    let (drawn, seen) = Count::sum(count);
    let mean = seen as f32 / drawn.max(1) as f32;
    count.iter().map(move |c| if c.drawn > 0 { c.seen as f32 / c.drawn as f32 } else { mean })
}

/// Ambient occlusion of each leaf, `0..=1`, in prune order: the part of its area, as seen from a sky of even
/// brightness on either side, that other leaves do not hide. From depth renders of the crown (P.-P. Vázquez and
/// M. Balsa, "Rendering Falling Leaves on Graphics Hardware", 2008, section 7.1); it becomes [`Leaf::ambient`]. About
/// 0.1 s for 10,000 leaves of ten triangles.
pub fn openness(foliage: &Foliage) -> Vec<f32> {
    let Some(film) = Film::around(foliage, 1.0) else {
        return vec![1.0; foliage.leaves.len()];
    };
    seen_parts(&film.count(foliage, foliage.leaves.len(), 1.0, &sky(SKY))).collect()
}

/// Unit directions from the crown to the cameras: eight at the horizon, four a third of the way up, one above. An
/// outline is the same from the opposite side.
pub fn sides() -> [Vec3; 13] {
    let ring = |turn: f32, height: f32| {
        let (sin, cos) = (turn * std::f32::consts::TAU).sin_cos();
        Vec3::new(cos, height, sin).normalize_or(Vec3::Y)
    };
    std::array::from_fn(|i| match i {
        0..8 => ring(i as f32 / 8.0, 0.0),
        8..12 => ring((i as f32 + 0.25) / 4.0, 0.577),
        _ => Vec3::Y,
    })
}

/// Some of [`sides`]: crowns are round enough for a few.
pub(super) fn few_sides() -> [Vec3; 5] {
    let sides = sides();
    [0, 3, 6, 9, 11].map(|i| sides[i])
}

/// `count` directions that share the sky's half sphere evenly: a spiral by the golden angle.
pub(super) fn sky(count: usize) -> Vec<Vec3> {
    let golden = std::f32::consts::PI * (3.0 - 5.0f32.sqrt());
    (0..count)
        .map(|i| {
            let height = (i as f32 + 0.5) / count as f32;
            let radius = (1.0 - height * height).sqrt();
            let (sin, cos) = (golden * i as f32).sin_cos();
            Vec3::new(radius * cos, height, radius * sin)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Species;
    use crate::prepare::{set_prune_order, simple_shapes};
    use glam::{Quat, Vec2};
    use windfall_core::material::{Image, Material};
    use windfall_core::simplify::PruneOrder;

    /// Squares of one metre, upright, facing +Z.
    fn squares(centers: &[Vec3]) -> Foliage {
        let [a, b, c, d] = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)];
        let shape = LeafShape {
            positions: [a, b, c, d].map(|(x, z)| Vec3::new(x, 0.0, z)).to_vec(),
            normals: vec![Vec3::Y; 4],
            uvs: [a, b, c, d].map(|(x, z)| Vec2::new(x + 0.5, z + 0.5)).to_vec(),
            indices: vec![0, 2, 1, 0, 3, 2],
        };
        let leaves = centers
            .iter()
            .map(|&center| Leaf {
                center,
                orientation: Quat::from_rotation_x(std::f32::consts::FRAC_PI_2),
                scale: 1.0,
                shape: 0,
                material: 0,
                bent_normal: Vec3::Z,
                ambient: 1.0,
                shed_rank: 0,
            })
            .collect();
        Foliage { leaves, shapes: vec![shape], ..Foliage::default() }
    }

    #[test]
    fn crowns_cover_as_much_with_leaves_of_two_triangles() {
        for species in [Species::Oak, Species::Birch, Species::Maple] {
            let whole = species.grow_with(1, 4000).foliage;
            let mut simple = whole.clone();
            for (shape, simple) in simple.shapes.iter_mut().zip(simple_shapes(&whole)) {
                *shape = simple.unwrap();
            }
            let film = Film::around(&whole, 1.5).unwrap();
            let covered = |of: &Foliage| Count::sum(&film.count(of, 4000, 1.0, &sides())).1 as f32;
            let off = covered(&simple) / covered(&whole) - 1.0;
            // Shapes of the same area cover 1 to 2.4% more.
            assert!(off.abs() < 0.009, "{species}: {off}");
        }
    }

    #[test]
    fn a_single_leaf_is_the_whole_crown() {
        let leaf = squares(&[Vec3::new(3.0, 5.0, -2.0)]);
        assert_eq!(visibility(&leaf).share, 1.0);
        let seen = visible_areas(&leaf)[0];
        // The mean of |cos| over the sides: (2 + 4 cos 45°)/8 of eight, four of cos 30° (cos 45°),
        // and an edge.
        let ring = 2.0 + 4.0 * 0.5f32.sqrt();
        let up = 4.0 * 0.5f32.sqrt() / (1.0f32 + 0.577 * 0.577).sqrt();
        let expected = (ring + up) / 13.0;
        assert!((seen - expected).abs() < 0.03, "{seen} {expected}");
    }

    #[test]
    fn two_leaves_side_by_side_are_half_of_it_each() {
        // One above the other: neither hides the other, from the sides nor from above.
        let share = visibility(&squares(&[Vec3::ZERO, Vec3::new(0.0, 4.0, 0.0)])).share;
        assert!((share - 0.5).abs() < 1e-3, "{share}");
    }

    #[test]
    fn leaves_that_hide_each_other_are_the_whole_crown_each() {
        // A stack a millimetre deep.
        let stack: Vec<Vec3> = (0..20).map(|i| Vec3::Z * 5e-5 * i as f32).collect();
        let foliage = squares(&stack);
        let share = visibility(&foliage).share;
        assert!(share > 0.97, "{share}");
        let seen = visible_areas(&foliage);
        // Looked at from both sides, those outside are seen alone.
        let hidden: f32 = seen[1..19].iter().sum();
        assert!(hidden < 0.03 * (seen[0] + seen[19]), "{seen:?}");
    }

    #[test]
    fn holes_are_not_seen() {
        // The left quarter of the picture is there.
        let rgba = [255, 255, 255, 255].iter().chain(&[0; 12]).copied().collect();
        let masked = |cutoff| Material {
            name: String::new(),
            base_color: Vec3::ONE,
            roughness: 1.0,
            alpha_cutoff: cutoff,
            surface: Surface::Texture(Image { width: 4, height: 1, rgba }, false),
        };
        let mut foliage = squares(&[Vec3::ZERO]);
        let whole = visible_areas(&foliage)[0];
        foliage.materials = vec![masked(Some(0.5))];
        let seen = visible_areas(&foliage)[0];
        assert!((seen / whole - 0.25).abs() < 0.02, "{seen} {whole}");
        assert_eq!(visibility(&foliage).share, 1.0);
    }

    #[test]
    fn a_leaf_under_a_roof_sees_less_of_the_sky() {
        let mut foliage =
            squares(&[Vec3::ZERO, Vec3::new(0.0, 0.4, 0.0), Vec3::new(9.0, 0.0, 0.0)]);
        for leaf in &mut foliage.leaves {
            leaf.orientation = Quat::IDENTITY;
        }
        foliage.leaves[1].scale = 3.0;
        let [under, roof, beside] = openness(&foliage)[..] else { panic!() };
        assert!(under < 0.25, "{under}");
        assert!(roof > 0.99 && beside > 0.95, "{roof} {beside}");
        // Beside a wall, half of it.
        foliage.leaves[1] = Leaf { scale: 60.0, ..squares(&[Vec3::new(0.0, 0.0, 0.51)]).leaves[0] };
        let wall = openness(&foliage)[0];
        assert!((0.4..0.6).contains(&wall), "{wall}");
    }

    #[test]
    fn survivors_cover_what_the_whole_crown_does() {
        for order in PruneOrder::ALL {
            let mut foliage = Species::Aspen.grow_with(3, 4000).foliage;
            set_prune_order(&mut foliage, order, 3);
            let whole: f32 = visible_areas(&foliage).iter().sum();
            let seen = visibility(&foliage);
            for (lambda, tolerance) in [(0.5, 0.07), (0.25, 0.02), (0.1, 0.03), (0.03, 0.06)] {
                let mut few = foliage.clone();
                few.truncate((lambda * 4000.0) as usize);
                let covered = |scale: f32| {
                    let mut few = few.clone();
                    few.leaves.iter_mut().for_each(|leaf| leaf.scale *= scale.sqrt());
                    visible_areas(&few).iter().sum::<f32>() / whole
                };
                let part = covered(seen.area_scale(lambda));
                assert!((part - 1.0).abs() < tolerance, "{order} {lambda}: {part}");
                // Equation 3 alone has them cover more.
                assert!(covered(area_scale(lambda, seen.share)) > part, "{order} {lambda}");
            }
        }
    }

    #[test]
    fn poison_is_invisible() {
        assert_eq!(visibility(&Foliage::default()).share, 0.0);
        assert!(openness(&Foliage::default()).is_empty());
        let nowhere = [Vec3::NAN, Vec3::INFINITY, Vec3::splat(f32::MAX)];
        for center in nowhere {
            let foliage = squares(&[center, Vec3::ZERO]);
            assert!(visibility(&foliage).share.is_finite());
            assert!(visible_areas(&foliage).iter().all(|area| area.is_finite()));
            assert!(openness(&foliage).iter().all(|o| (0.0..=1.0).contains(o)));
        }
        let mut point = squares(&[Vec3::ZERO; 3]);
        for leaf in &mut point.leaves {
            leaf.scale = 0.0;
        }
        assert_eq!(visibility(&point).share, 0.0);
        assert_eq!(openness(&point), [1.0; 3]);
        point.leaves[1].scale = f32::NAN;
        point.leaves[2].scale = 1.0;
        assert_eq!(visibility(&point).share, 0.0);
    }
}
