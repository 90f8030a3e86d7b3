//! SFS, section 3.1: a tree's size in the picture from its distance, its bounding sphere and its bounding box.

use super::report::{Row, Table};
use super::simplified::{FIGURE_1, figure_5_scene};
use crate::scenery::clip_from_world;
use crate::simplification::workload::{bisect, paper_simplification, view_across, visible_trees};
use crate::statistics::Quartiles;
use glam::{Mat4, Vec3};
use std::f32::consts::PI;
use std::time::Instant;
use windfall_core::simplify::Seen;
use windfall_scenes::Stage;

/// Times that the sizes of all trees are found for a measurement.
const ROUNDS: u32 = 1000;

/// How the size of a tree is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Size {
    /// The square of one metre over the distance (equation 1).
    Distance,
    /// Area of the bounding sphere in the picture, pixels.
    Sphere,
    /// Area of the rectangle around the bounding box in the picture, pixels (3.1).
    Box,
}

impl Size {
    const ALL: [Self; 3] = [Self::Distance, Self::Sphere, Self::Box];

    fn name(self) -> &'static str {
        match self {
            Self::Distance => "distance",
            Self::Sphere => "bounding sphere",
            Self::Box => "bounding box",
        }
    }
}

/// Pixels of the rectangle around the projected corners of a box; all of the picture if one is behind the camera.
fn rectangle(clip_from_world: Mat4, corners: [Vec3; 8], (width, height): (u32, u32)) -> f32 {
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let pixels = width as f32 * height as f32;
    for corner in corners {
        let at = clip_from_world * corner.extend(1.0);
        if at.w <= 0.0 {
            return pixels;
        }
        let at = at.truncate() / at.w;
        (low, high) = (low.min(at), high.max(at));
    }
    // Clip space is two wide and two high.
    (high.x - low.x) * (high.y - low.y) * 0.25 * pixels
}

fn corners((low, high): (Vec3, Vec3)) -> [Vec3; 8] {
    std::array::from_fn(|i| {
        Vec3::from_array(std::array::from_fn(|k| if i >> k & 1 == 0 { low[k] } else { high[k] }))
    })
}

/// The trees of a view, and what their sizes are found from.
struct Trees<'a> {
    stage: &'a Stage,
    seen: Vec<(usize, Seen)>,
    bounds: Vec<(Vec3, Vec3)>,
    clip_from_world: Mat4,
    size: (u32, u32),
}

impl Trees<'_> {
    fn sizes(&self, by: Size) -> Vec<f32> {
        let of = |(i, seen): &(usize, Seen)| match by {
            Size::Distance => seen.distance.powi(-2),
            Size::Sphere => PI * (seen.radius * seen.pixels / seen.distance).powi(2),
            Size::Box => {
                let instance = &self.stage.forest.instances[*i];
                let corners = corners(self.bounds[instance.model as usize]);
                let corners = corners.map(|corner| instance.world_from_tree(corner));
                rectangle(self.clip_from_world, corners, self.size)
            }
        };
        self.seen.iter().map(of).collect()
    }

    /// Share of the leaves of all trees that is kept, with the levels of each.
    fn total(&self, lambdas: &[f32]) -> f64 {
        let (mut kept, mut all) = (0.0, 0.0);
        for ((i, _), lambda) in self.seen.iter().zip(lambdas) {
            let model = self.stage.forest.instances[*i].model as usize;
            let leaves = self.stage.trees[model].foliage.leaves.len() as f64;
            all += leaves;
            kept += leaves * f64::from(*lambda);
        }
        kept / f64::max(all, 1.0)
    }
}

/// Equation 2 with the size `full` at which trees are drawn in full.
fn levels(sizes: &[f32], full: f32, exponent: f32) -> Vec<f32> {
    sizes.iter().map(|b| (b / full).min(1.0).powf(exponent)).collect()
}

/// The trees of figure 5 by all sizes, with as many leaves in all.
pub fn table(quick: bool) -> Table {
    println!("section 3.1 of SFS");
    let size = if quick { (400, 300) } else { (800, 600) };
    let scene = figure_5_scene(size);
    let detail = paper_simplification(0.7, scene.d0);
    let view = view_across(&scene.stage, scene.fov, detail);
    let trees = Trees {
        seen: visible_trees(&scene.stage, &view, size),
        bounds: scene.stage.trees.iter().map(windfall_core::tree::Tree::bounds).collect(),
        clip_from_world: clip_from_world(&view.camera, size.0 as f32 / size.1 as f32),
        stage: &scene.stage,
        size,
    };
    let exponent = detail.exponent();
    let mut times: [Vec<f64>; 3] = Default::default();
    for _ in 0..if quick { 5 } else { 15 } {
        for (by, times) in Size::ALL.into_iter().zip(&mut times) {
            let start = Instant::now();
            for _ in 0..ROUNDS {
                std::hint::black_box(trees.sizes(by));
            }
            times.push(start.elapsed().as_secs_f64() * 1e3);
        }
    }
    let by_distance = levels(&trees.sizes(Size::Distance), scene.d0.powi(-2), exponent);
    let first = Quartiles::of(&times[0]).median;
    let rows = Size::ALL.into_iter().zip(&times).map(|(by, times)| {
        let sizes = trees.sizes(by);
        // Larger where more is kept: one over the size at which trees are in full.
        let most = sizes.iter().copied().fold(f32::MIN_POSITIVE, f32::max);
        let scale = bisect(1e-3, 1e4, FIGURE_1, |scale| {
            trees.total(&levels(&sizes, most / scale, exponent))
        });
        let lambdas = levels(&sizes, most / scale, exponent);
        let apart: Vec<f64> = lambdas
            .iter()
            .zip(&by_distance)
            .map(|(a, b)| f64::from((a / b).max(b / a)) - 1.0)
            .collect();
        let most_apart = apart.iter().copied().fold(0.0, f64::max);
        let ms = Quartiles::of(times);
        Row {
            name: by.name().into(),
            ms,
            measured: Some(ms.median / first),
            printed: None,
            notes: format!(
                "total lambda {:.3}; a tree's differs from that by distance by {:.0}% (median), {:.0}% at most",
                trees.total(&lambdas),
                100.0 * Quartiles::of(&apart).median,
                100.0 * most_apart
            ),
        }
    });
    Table {
        id: "sfs-3.1".into(),
        title: "SFS, section 3.1: B from the distance, the bounding sphere and the bounding box".into(),
        scene: format!(
            "The {} trees in view of figure 5, h = 0.7, sizes of full trees such that the total level of detail is 0.06; \
             times are of the CPU for all trees, {ROUNDS} times",
            trees.seen.len()
        ),
        ratio: "time over that by distance".into(),
        rows: rows.collect(),
        remark: "\"Since the computation of a bounding box area in pixels is more complex\", SFS takes the distance; so do \
                 we by default, and the sphere's area where tree models differ in size. Sizes of these trees differ, which \
                 the distance does not know; with h = 0.7 the level follows b to a power of nearly two, so that a tree's \
                 level is easily twice as high by its area. What the box costs more is small beside a frame; it grows and \
                 shrinks as a tree turns about its trunk, though the crown in view does not. The renderer has the distance \
                 and the sphere alone."
            .into(),
        plot: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube of two metres, ten metres away: its near side is a fifth of half the picture's height.
    #[test]
    fn a_box_covers_what_its_near_side_does() {
        let projection =
            Mat4::perspective_infinite_reverse_rh(std::f32::consts::FRAC_PI_2, 2.0, 0.1);
        let at = |z: f32| corners((Vec3::new(-1.0, -1.0, z - 1.0), Vec3::new(1.0, 1.0, z + 1.0)));
        let pixels = rectangle(projection, at(-11.0), (200, 100));
        assert!((pixels - 10.0 * 10.0).abs() < 0.01, "{pixels}");
        assert_eq!(rectangle(projection, at(0.5), (200, 100)), 20_000.0);
        // Equation 2: half of the leaves at b = h.
        let exponent = paper_simplification(0.7, 1.0).exponent();
        assert!((levels(&[0.7, 9.0], 1.0, exponent)[0] - 0.5).abs() < 1e-6);
    }
}
