//! Part c: the image error of a simplified tree against the full tree, supersampled.
//!
//! One tree on level ground is seen from several sides, at the distance at which the default
//! simplification draws a share `λ` of its leaves, with pixels as large as those of a full screen.
//! The reference is the unsimplified tree at four times the resolution, averaged in linear light.
//! Candidates are drawn once with the renderer's own antialiasing. One is drawn like the reference:
//! its error is that of simplification without the error of too few samples.
//!
//! Coverage, luminance, color and variance are those of leaves alone, without wood, ground and sky,
//! and of their radiance with a box filter of one pixel, because that is what simplification
//! preserves. Luminance and variance of the final image follow. Tone mapping increases its contrast
//! and is applied to single samples, so leaves that differ less are also darker there. FLIP and
//! flicker are those of the final image.

mod candidates;
mod leaf_statistics;
mod meshopt_baseline;
mod plot;

use super::Args;
use super::workload::{mean_form, visible_trees};
use crate::harness::{ImageTarget, PlantedView};
use crate::image::LinearImage;
use crate::scenery::{edit_sky, single_tree};
use anyhow::bail;
use candidates::{Candidate, Model, candidates, near_candidates};
use glam::Vec3;
use leaf_statistics::LeafStatistics;
use meshopt_baseline::simplified;
use serde::Serialize;
use std::path::Path;
use windfall_core::foliage::{Foliage, LeafShape};
use windfall_core::simplify::{
    Growth, LeafForm, PruneOrder, Reduction, Simplification, Visibility,
};
use windfall_core::tree::Tree;
use windfall_gpu::{Camera, DebugView, Renderer, View};
use windfall_host::device::Gpu;
use windfall_host::tree::read_or_grow;
use windfall_scenes::Stage;
use windfall_tree::ImportOptions;
use windfall_tree::{Species, set_prune_order};

/// Levels of detail that are compared.
pub const LAMBDAS: [f32; 5] = [0.5, 0.25, 0.1, 0.06, 0.03];
/// Samples of the reference in a row of a pixel; as many rows.
const SUPERSAMPLING: u32 = 4;
/// Frames of the camera's motion, for flicker.
const MOTION_FRAMES: u32 = 4;
/// The level at whose distance the second table forces the lower levels: the first.
const NEAR_LAMBDA: f32 = LAMBDAS[0];

/// Results of part c.
#[derive(Serialize)]
pub struct Errors {
    /// Rows of pixels of the screen that the images are parts of.
    screen: u32,
    /// Directions from which each tree is seen.
    sides: u32,
    rows: Vec<Row>,
}

/// A candidate against the reference.
#[derive(Serialize)]
struct Row {
    tree: String,
    /// From the camera to the tree's middle, metres.
    distance: f32,
    /// Whether `lambda` differs from the level of the distance.
    forced: bool,
    lambda: f32,
    candidate: &'static str,
    /// Share of the leaves that is drawn.
    drawn: f32,
    /// Their triangles.
    leaf_triangles: usize,
    /// Relative errors against the reference: value over the reference's, less 1.
    coverage: f64,
    luminance: f64,
    color: [f32; 3],
    variance: f64,
    /// Relative errors of luminance and variance of the final image.
    picture: [f64; 2],
    flip: f64,
    /// Mean difference of consecutive frames less the reference's, in steps of 1/255.
    flicker: f64,
}

/// A tree to compare.
struct Subject {
    stage: Stage,
    middle: Vec3,
    /// Half the side of a square that the tree fits in from any side, metres.
    half_extent: f32,
}

/// A tree's models on the GPU. The first is for candidates that are not listed.
struct Models(Vec<(Model, PlantedView)>);

impl Models {
    fn new(gpu: &Gpu, renderer: &Renderer, subject: &Subject) -> anyhow::Result<Self> {
        let mut models = Vec::new();
        for order in PruneOrder::ALL {
            let mut stage = subject.stage.clone();
            set_prune_order(&mut stage.trees[0].foliage, order, 1);
            models.push((Model::Ordered(order), PlantedView::upload(gpu, renderer, &stage)?));
            if order == PruneOrder::default() {
                stage.trees[0].foliage.visibility.disocclusion = Visibility::BY_CHANCE;
                models.push((Model::Equation3, PlantedView::upload(gpu, renderer, &stage)?));
            }
        }
        Ok(Self(models))
    }

    fn get(&mut self, model: Model) -> &mut PlantedView {
        let found = self.0.iter().position(|(m, _)| *m == model);
        &mut self.0[found.unwrap_or(0)].1
    }
}

impl Subject {
    fn new(tree: Tree) -> Self {
        let (low, high) = tree.bounds();
        let size = high - low;
        let middle = (low + high) / 2.0;
        let half_extent = 0.55 * size.y.max(size.x.hypot(size.z));
        Self { stage: single_tree(tree), middle, half_extent }
    }

    /// The tree from one of `sides`, at a frame of the camera's motion: a quarter of a pixel to the
    /// side and 1/500 of the distance ahead per frame.
    fn view(&self, viewpoint: &Viewpoint, side: u32, sides: u32, frame: u32) -> View {
        let (sin, cos) = (std::f32::consts::TAU * side as f32 / sides as f32).sin_cos();
        let away = Vec3::new(sin, 0.0, cos);
        let step = frame as f32;
        let aside =
            Vec3::new(cos, 0.0, -sin) * (0.25 * step * viewpoint.distance / viewpoint.pixels);
        let eye = self.middle + away * viewpoint.distance * (1.0 - 0.002 * step) + aside;
        let fov_y = 2.0 * (0.5 * viewpoint.size.1 as f32 / viewpoint.pixels).atan();
        View::new(Camera::look_at(eye.as_dvec3(), (eye - away).as_dvec3(), fov_y, 0.1))
    }
}

/// Distance of the camera and resolution of its images.
struct Viewpoint {
    /// From the camera to the middle of the tree, metres.
    distance: f32,
    /// Pixels that 1 m covers at a distance of 1 m.
    pixels: f32,
    size: (u32, u32),
}

impl Viewpoint {
    fn new(subject: &Subject, distance: f32, screen: u32) -> Self {
        // The screen has a vertical field of view of 45 degrees.
        let pixels = screen as f32 / (2.0 * 22.5f32.to_radians().tan());
        let side = (2.0 * subject.half_extent * pixels / distance).ceil().clamp(48.0, 640.0) as u32;
        Self { distance, pixels, size: (side.next_multiple_of(8), side.next_multiple_of(8)) }
    }
}

/// What is compared with the reference.
struct Measured {
    /// One from each side.
    images: Vec<LinearImage>,
    /// Leaves of the radiance.
    radiance: LeafStatistics,
    /// Leaves of the final image.
    picture: LeafStatistics,
    /// Mean difference of consecutive frames, in steps of 1/255.
    flicker: f64,
}

/// Runs part c.
pub fn measure(args: &Args, gpu: &mut Gpu, renderer: &Renderer) -> anyhow::Result<Errors> {
    if args.lambda.iter().any(|l| !(*l > 1e-4 && *l <= 1.0)) {
        bail!("--lambda is above 0.0001 and at most 1");
    }
    if args.sides == 0 || !(64..=4320).contains(&args.screen) {
        bail!("--sides is at least 1, and --screen 64 to 4320");
    }
    let mut errors = Errors { screen: args.screen, sides: args.sides, rows: Vec::new() };
    for name in &args.tree {
        let tree = if let (Ok(species), Some(leaves)) = (name.parse::<Species>(), args.leaves) {
            species.grow_with(1, leaves)
        } else {
            let options = ImportOptions { height: args.height, ..ImportOptions::default() };
            read_or_grow(name, 1, &options)?.tree
        };
        if tree.foliage.leaves.is_empty() {
            bail!("{name}: has no leaves");
        }
        let subject = Subject::new(tree);
        let mut models = Models::new(gpu, renderer, &subject)?;
        let comparison = Comparison { args, renderer, subject: &subject, name };
        println!(
            "\n(c) {name}, {} leaves: each level at its distance",
            subject.stage.trees[0].foliage.leaves.len()
        );
        for &lambda in &args.lambda {
            let viewpoint = Viewpoint::new(&subject, distance_of(lambda), args.screen);
            let rows =
                comparison.rows(gpu, &mut models, &viewpoint, &[(lambda, false)], &candidates())?;
            errors.rows.extend(rows);
        }
        println!("\n(c) {name}: levels forced at the distance of {NEAR_LAMBDA}");
        let viewpoint = Viewpoint::new(&subject, distance_of(NEAR_LAMBDA), args.screen);
        let forced = args.lambda.iter().filter(|l| **l < NEAR_LAMBDA);
        let forced: Vec<_> = forced.map(|lambda| (*lambda, true)).collect();
        let near = near_candidates();
        errors.rows.extend(comparison.rows(gpu, &mut models, &viewpoint, &forced, &near)?);
    }
    Ok(errors)
}

/// Triangles of all leaves in their simple shapes.
fn simple_triangle_count(foliage: &Foliage) -> usize {
    let triangles = |shape: &LeafShape| shape.indices.len() / 3;
    let simple = |shape: usize| foliage.simple_shapes[shape].as_ref();
    let of = |shape: usize| triangles(simple(shape).unwrap_or(&foliage.shapes[shape]));
    foliage.leaves.iter().map(|leaf| of(leaf.shape as usize)).sum()
}

/// The distance at which the default simplification has a level, metres.
fn distance_of(lambda: f32) -> f32 {
    let Reduction::Distance { d0 } = Simplification::DEFAULT.reduction else { return 30.0 };
    d0 / lambda.powf(0.5 / Simplification::DEFAULT.exponent())
}

/// Compares candidates with the reference, for one tree.
struct Comparison<'a> {
    args: &'a Args,
    renderer: &'a Renderer,
    subject: &'a Subject,
    name: &'a str,
}

impl Comparison<'_> {
    /// Rows of some levels at one distance; with `true` a level is forced.
    fn rows(
        &self,
        gpu: &mut Gpu,
        models: &mut Models,
        viewpoint: &Viewpoint,
        levels: &[(f32, bool)],
        candidates: &[Candidate],
    ) -> anyhow::Result<Vec<Row>> {
        let subject = self.subject;
        let full = Model::Ordered(PruneOrder::default());
        let unsimplified = Candidate {
            detail: Simplification::NONE,
            shadow_detail: Simplification::NONE,
            samples: SUPERSAMPLING,
            ..candidates[0]
        };
        let target = |samples| ImageTarget::new(gpu, self.renderer, viewpoint.size, samples);
        let targets = [target(1)?, target(SUPERSAMPLING)?];
        let reference = self.measure(gpu, &targets, models.get(full), viewpoint, &unsimplified)?;
        self.save(viewpoint, "reference", &reference.images[0])?;
        let mut rows = Vec::new();
        println!(
            "{:.0} m, {}x{}\n{:>7}  {:<21}{:>8}{:>10}{:>10}{:>10}{:>9}{:>10} |{:>10}{:>10} |{:>8}{:>9}",
            viewpoint.distance,
            viewpoint.size.0,
            viewpoint.size.1,
            "lambda",
            "candidate",
            "drawn",
            "triangles",
            "coverage",
            "luminance",
            "colour",
            "variance",
            "luminance",
            "variance",
            "FLIP",
            "flicker"
        );
        for &(lambda, forced) in levels {
            let wanted = |c: &&Candidate| {
                self.args.only.is_empty() || self.args.only.iter().any(|name| name == c.name)
            };
            for candidate in candidates.iter().filter(wanted) {
                let mut candidate = *candidate;
                if forced {
                    let factor = (lambda / NEAR_LAMBDA).sqrt();
                    for detail in [&mut candidate.detail, &mut candidate.shadow_detail] {
                        if let Reduction::Distance { d0 } = &mut detail.reduction {
                            *d0 *= factor;
                        }
                    }
                }
                let (drawn, triangles) = self.drawn(viewpoint, &candidate);
                let mut baseline = match candidate.model {
                    Model::Meshopt(baseline) => {
                        // As many triangles as the default simplification draws at this level.
                        let default = Candidate {
                            model: Model::Ordered(PruneOrder::default()),
                            detail: Simplification {
                                h: Simplification::DEFAULT.h,
                                growth: Growth::UNBOUNDED,
                                ..candidate.detail
                            },
                            ..candidate
                        };
                        let (_, target) = self.drawn(viewpoint, &default);
                        let tree = simplified(&subject.stage.trees[0], baseline, target)?;
                        let count = tree.foliage.triangle_count();
                        let stage = single_tree(tree);
                        Some((PlantedView::upload(gpu, self.renderer, &stage)?, count))
                    }
                    _ => None,
                };
                let (planted, triangles) = match &mut baseline {
                    Some((planted, count)) => (planted, *count),
                    None => (models.get(candidate.model), triangles),
                };
                let measured = self.measure(gpu, &targets, planted, viewpoint, &candidate)?;
                let over = |a: f64, b: f64| a / b.max(1e-12) - 1.0;
                let (total, of_reference) = (measured.radiance, reference.radiance);
                let flips = measured.images.iter().zip(&reference.images).map(|(a, b)| a.flip(b));
                let row = Row {
                    tree: self.name.to_owned(),
                    distance: viewpoint.distance,
                    forced,
                    lambda,
                    candidate: candidate.name,
                    drawn,
                    leaf_triangles: triangles,
                    coverage: over(total.covered, of_reference.covered),
                    luminance: over(total.luminance, of_reference.luminance),
                    color: ((total.color / of_reference.color.max(Vec3::splat(1e-9))) - 1.0)
                        .to_array(),
                    variance: over(total.variance, of_reference.variance),
                    picture: [
                        over(measured.picture.luminance, reference.picture.luminance),
                        over(measured.picture.variance, reference.picture.variance),
                    ],
                    flip: flips.sum::<f64>() / measured.images.len() as f64,
                    flicker: measured.flicker - reference.flicker,
                };
                row.print();
                let name = format!("{lambda}-{}", candidate.name);
                self.save(viewpoint, &name, &measured.images[0])?;
                rows.push(row);
            }
        }
        Ok(rows)
    }

    /// Writes an image as PNG if the arguments name a folder for images.
    fn save(&self, viewpoint: &Viewpoint, name: &str, image: &LinearImage) -> anyhow::Result<()> {
        let Some(folder) = &self.args.pictures else { return Ok(()) };
        let stem = Path::new(self.name).file_stem().unwrap_or_default().display();
        let name = name.replace([' ', ',', '/'], "-");
        image.save_png(&folder.join(format!("{stem}-{:.0}m-{name}.png", viewpoint.distance)))
    }

    /// Share of the leaves that is drawn, with those that fade, and their triangles.
    fn drawn(&self, viewpoint: &Viewpoint, candidate: &Candidate) -> (f32, usize) {
        let stage = &self.subject.stage;
        let view = self.subject.view(viewpoint, 0, 1, 0);
        let detail = &candidate.detail;
        let (share, simple) = visible_trees(stage, &view, viewpoint.size).first().map_or(
            (1.0, false),
            |(_, seen)| {
                let level = detail.level(seen);
                (detail.drawn(&level), mean_form(detail, &level, seen) == LeafForm::Simple)
            },
        );
        let foliage = &stage.trees[0].foliage;
        let all = if simple { simple_triangle_count(foliage) } else { foliage.triangle_count() };
        (share, (share * all as f32).round() as usize)
    }

    /// Draws a candidate from all sides and during the camera's motion. `targets` are without and
    /// with supersampling.
    fn measure(
        &self,
        gpu: &mut Gpu,
        targets: &[ImageTarget; 2],
        planted: &mut PlantedView,
        viewpoint: &Viewpoint,
        candidate: &Candidate,
    ) -> anyhow::Result<Measured> {
        let sides = self.args.sides;
        let target = &targets[usize::from(candidate.samples > 1)];
        let mut render = |side, frame, show, filter| {
            let mut view = View {
                show,
                detail: candidate.detail,
                shadow_detail: candidate.shadow_detail,
                ..self.subject.view(viewpoint, side, sides, frame)
            };
            // Leaves and their coverage need the same filter.
            view.quality.resolve_filter &= filter;
            if matches!(show, DebugView::Leaves | DebugView::Radiance) {
                // Keeps the values in the linear part of the tone curve and below 255.
                edit_sky(&mut view, |sky| sky.exposure -= 2.0);
            }
            target.render(gpu, self.renderer, planted, (0.0, &view))
        };
        let (mut images, mut radiance, mut picture) = (Vec::new(), Vec::new(), Vec::new());
        for side in 0..sides {
            images.push(render(side, 0, DebugView::Final, true)?);
            for (of, show, filter) in [
                (&mut radiance, DebugView::Radiance, false),
                (&mut picture, DebugView::Leaves, true),
            ] {
                let leaves = render(side, 0, show, filter)?;
                let coverage = render(side, 0, DebugView::Coverage, filter)?;
                of.push(LeafStatistics::of(&leaves, &coverage));
            }
        }
        let mut flicker = 0.0;
        let mut last = render(0, 0, DebugView::Final, true)?;
        for frame in 1..MOTION_FRAMES {
            let next = render(0, frame, DebugView::Final, true)?;
            flicker += next.difference(&last) / f64::from(MOTION_FRAMES - 1);
            last = next;
        }
        let [radiance, picture] = [radiance, picture].map(|of| LeafStatistics::mean(&of));
        Ok(Measured { images, radiance, picture, flicker })
    }
}

impl Row {
    fn print(&self) {
        let color =
            self.color.iter().fold(0.0f32, |most, c| if c.abs() > most.abs() { *c } else { most });
        println!(
            "{:>7}  {:<21}{:>8.4}{:>10}{:>+9.1}%{:>+9.1}%{:>+8.1}%{:>+9.1}% |{:>+9.1}%{:>+9.1}% |{:>8.4}{:>9.3}",
            self.lambda,
            self.candidate,
            self.drawn,
            self.leaf_triangles,
            100.0 * self.coverage,
            100.0 * self.luminance,
            100.0 * color,
            100.0 * self.variance,
            100.0 * self.picture[0],
            100.0 * self.picture[1],
            self.flip,
            self.flicker
        );
    }
}
