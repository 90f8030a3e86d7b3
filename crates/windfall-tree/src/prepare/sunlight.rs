//! Mean sunlight on the visible leaves of a crown, whole and simplified, by shadow maps on the CPU.

use super::film::{Film, Shadow};
use super::simple_shapes;
use super::visibility::few_sides;
use crate::parallel;
use glam::Vec3;
use std::borrow::Cow;
use windfall_core::foliage::{Foliage, LeafShape};
use windfall_core::simplify::{SHADE_SPREAD, Visibility};

/// Unit vectors towards the sun: 25 degrees high, and 50.
const SUNS: [Vec3; 2] = [Vec3::new(0.748, 0.423, 0.512), Vec3::new(-0.642, 0.766, 0.022)];

/// [`Visibility::sunlight`], given the rest of the crown's visibility.
pub(super) fn factors(foliage: &Foliage, seen: &Visibility) -> [f32; 3] {
    let Some(film) = Film::finest(foliage, 4.0) else { return Visibility::BY_CHANCE };
    let shapes = far_shapes(foliage);
    let whole = of_points(foliage, &film);
    let mut last = 1.0;
    Visibility::MEASURED.map(|lambda| {
        let count = (lambda * foliage.leaves.len() as f32).round() as usize;
        if count >= super::visibility::FEW {
            let growth = seen.area_scale(lambda).sqrt();
            let survivors = of_leaves(foliage, &shapes, &film, count, growth);
            if survivors > 0.0 && whole > 0.0 {
                last = (whole / survivors).clamp(0.5, 1.0);
            }
        }
        last
    })
}

/// Share of what is seen of the crown that lies in the sun, each point by itself.
fn of_points(foliage: &Foliage, film: &Film) -> f32 {
    let shadows = shadows(foliage, film, foliage.leaves.len(), 1.0);
    let sides = parallel::map(&few_sides(), |&side| {
        let points = film.seen_points(foliage, side);
        let lit: usize = points.iter().map(|&point| lit_by(&shadows, point)).sum();
        (lit, points.len() * shadows.len())
    });
    let (lit, all) = sides.iter().fold((0, 0), |(lit, all), side| (lit + side.0, all + side.1));
    lit as f32 / all.max(1) as f32
}

/// The same of the first `count` leaves, grown by `growth`, each lit in the mean of its corners as far leaves are
/// (`far_reach` in `leaves.wgsl`).
fn of_leaves(
    foliage: &Foliage,
    shapes: &[LeafShape],
    film: &Film,
    count: usize,
    growth: f32,
) -> f32 {
    let shadows = shadows(foliage, film, count, growth);
    let seen = film.count(foliage, count, growth, &few_sides());
    let (mut lit, mut all) = (0.0, 0.0);
    for (leaf, seen) in foliage.leaves.iter().zip(&seen) {
        let corners = &shapes[leaf.shape as usize].positions;
        let reach = leaf.scale * growth * SHADE_SPREAD;
        let of_corner =
            |&corner: &Vec3| lit_by(&shadows, leaf.center + leaf.orientation * corner * reach);
        let of_leaf: usize = corners.iter().map(of_corner).sum();
        lit += seen.seen as f32 * of_leaf as f32 / corners.len().max(1) as f32;
        all += seen.seen as f32 * shadows.len() as f32;
    }
    lit / f32::max(all, 1.0)
}

/// The shapes that far leaves are drawn with: the simple ones where they exist, computed here for an unprepared
/// foliage.
fn far_shapes(foliage: &Foliage) -> Vec<LeafShape> {
    let simple = if foliage.simple_shapes.is_empty() {
        Cow::Owned(simple_shapes(foliage))
    } else {
        Cow::Borrowed(&foliage.simple_shapes)
    };
    let pairs = simple.iter().zip(&foliage.shapes);
    pairs.map(|(simple, shape)| simple.as_ref().unwrap_or(shape).clone()).collect()
}

fn shadows(foliage: &Foliage, film: &Film, count: usize, growth: f32) -> Vec<Shadow> {
    parallel::map(&SUNS, |&sun| film.shadow(foliage, count, growth, sun))
}

/// How many of the suns reach a point.
fn lit_by(shadows: &[Shadow], point: Vec3) -> usize {
    shadows.iter().filter(|shadow| shadow.lit(point)).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Species;
    use crate::prepare::visibility;
    use windfall_core::foliage::Leaf;
    use windfall_core::material::{Image, Surface};

    #[test]
    fn a_leaf_by_itself_lies_in_the_sun_and_one_under_a_roof_does_not() {
        let mut foliage = Species::Birch.grow_with(1, 400).foliage;
        let lit = |foliage: &Foliage| {
            let film = Film::finest(foliage, 1.0).unwrap();
            let shadows = shadows(foliage, &film, foliage.leaves.len(), 1.0);
            lit_by(&shadows, foliage.leaves[0].center)
        };
        let alone = Leaf { center: Vec3::ZERO, ..foliage.leaves[0] };
        foliage.leaves = vec![alone, Leaf { center: Vec3::X * 40.0, ..alone }];
        assert_eq!(lit(&foliage), 2);
        // Towards the first of the suns, then towards both; far above it, and two pixels of 18 cm.
        for (roofs, height, left) in [(1, 8.0, 1), (2, 8.0, 0), (2, 0.4, 0)] {
            let mut roofed = foliage.clone();
            for sun in &SUNS[..roofs] {
                let scale = 60.0 * alone.scale;
                let orientation = glam::Quat::from_rotation_arc(Vec3::Y, *sun);
                roofed.leaves.push(Leaf { center: *sun * height, scale, orientation, ..alone });
            }
            assert_eq!(lit(&roofed), left, "{roofs} {height}");
        }
    }

    #[test]
    fn fewer_and_larger_leaves_find_more_light_than_small_ones() {
        let seen = |leaves| {
            let mut foliage = Species::Maple.grow_with(1, leaves).foliage;
            assert_eq!(foliage.visibility.sunlight, Visibility::BY_CHANCE);
            let image = Image { width: 1, height: 1, rgba: vec![255; 4] };
            foliage.materials[0].surface = Surface::Texture(image, false);
            visibility(&foliage).sunlight
        };
        let [few, many] = [1000, 8000].map(seen);
        // The fewer are left, the more each of them has too much.
        assert!(few.is_sorted_by(|a, b| a >= b), "{few:?}");
        assert!(few[1] < 0.95, "{few:?}");
        assert!(many[1] > few[1], "{many:?} {few:?}");
    }
}
