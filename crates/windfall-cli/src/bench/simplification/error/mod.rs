//! Part c: how far the picture of a simplified tree is from that of the whole one, supersampled.
//!
//! One tree on level ground, seen from several sides at the distance at which the default
//! simplification draws a share `λ` of its leaves, in pixels as large as those of a whole screen's
//! picture. The reference is the unsimplified tree at four times the resolution, averaged in linear
//! light; candidates are drawn once, with the renderer's own antialiasing, and one as the reference is,
//! whose error is that of simplification without that of too few samples.
//!
//! Coverage, luminance, colour and variance are those of leaves alone, without wood, ground and sky, and
//! of their radiance, filtered by one pixel's square: that is what simplification preserves. Behind them
//! stand luminance and variance of the finished picture, whose system gamma makes more of contrasts, and
//! takes means of single samples, so that leaves that differ less are darker too. FLIP and flicker are
//! those of the whole picture.

pub(in crate::bench) mod measure;
mod plot;
mod rival;

pub use measure::Film;

use super::Args;
use super::stands::seen;
use crate::gpu::Gpu;
use crate::tree::read_or_grow;
use anyhow::{Context, bail};
use glam::Vec3;
use measure::{Foliage, Linear};
use rival::{Rival, simplified};
use serde::Serialize;
use std::path::Path;
use windfall_core::foliage::LeafShape;
use windfall_core::forest::{Forest, Instance, Terrain};
use windfall_core::simplify::{
    FadeBy, Growth, PruneOrder, Reduction, Simplification, Visibility, simple_shapes,
};
use windfall_core::tree::Tree;
use windfall_core::tree::species::Species;
use windfall_gpu::{Camera, Falls, GpuForest, Renderer, Show, View};
use windfall_scenes::Stage;

/// Levels of detail that are compared.
pub const LAMBDAS: [f32; 5] = [0.5, 0.25, 0.1, 0.06, 0.03];
/// Samples of the reference, in a row of a pixel.
const SUPER: u32 = 4;
/// Frames of the camera's move.
const MOVE: u32 = 4;
/// Distance of the second table, at which levels are forced: that of the first level.
const NEAR: f32 = LAMBDAS[0];

/// Part c.
#[derive(Serialize)]
pub struct Errors {
    /// Rows of the screen that the pictures are parts of.
    screen: u32,
    sides: u32,
    rows: Vec<Row>,
}

/// A candidate against the reference.
#[derive(Serialize)]
struct Row {
    tree: String,
    /// From the camera to the tree's middle, metres.
    distance: f32,
    /// Where `λ` is not that of the distance.
    forced: bool,
    lambda: f32,
    candidate: &'static str,
    /// Share of the leaves, and their triangles, that are drawn.
    drawn: f32,
    leaf_triangles: usize,
    /// Over the reference's, less 1.
    coverage: f64,
    luminance: f64,
    color: [f32; 3],
    variance: f64,
    /// Luminance and variance of the finished picture.
    picture: [f64; 2],
    flip: f64,
    /// Mean difference of consecutive frames beyond the reference's, steps of 255.
    flicker: f64,
}

/// What stands in for the whole tree.
#[derive(Clone, Copy)]
struct Candidate {
    name: &'static str,
    model: Model,
    detail: Simplification,
    shadow_detail: Simplification,
    /// Samples in a row of a pixel: 1, or those of the reference.
    samples: u32,
}

#[derive(Clone, Copy, PartialEq)]
enum Model {
    Ordered(PruneOrder),
    /// The default order, survivors as equation 3 says.
    Equation3,
    Simplify,
    Sloppy,
}

/// The simplification that draws in a picture of the reference's size what `detail` draws in one of the
/// candidates'.
fn of_samples(detail: Simplification) -> Simplification {
    let growth = Growth { pixels: detail.growth.pixels * SUPER as f32, ..detail.growth };
    let contrast_pixels = detail.contrast_pixels.map(|pixels| pixels * SUPER as f32);
    let wood_pixels = detail.wood_pixels * SUPER as f32;
    Simplification { growth, contrast_pixels, wood_pixels, ..detail }
}

/// All that are compared at the distance of a level.
fn candidates() -> Vec<Candidate> {
    let of = |name, detail| Candidate {
        name,
        model: Model::Ordered(PruneOrder::default()),
        detail,
        shadow_detail: View::SHADOW_DETAIL,
        samples: 1,
    };
    // A bound on growth would draw more leaves than the level says.
    let default = Simplification { growth: Growth::UNBOUNDED, ..Simplification::DEFAULT };
    let whole = Simplification { h: 0.0, ..default };
    let ordered =
        |order: PruneOrder| Candidate { model: Model::Ordered(order), ..of(order.name(), default) };
    let plain = Simplification { color_contrast: false, shading_contrast: false, ..default };
    let rival = |name, model| Candidate { model, shadow_detail: whole, ..of(name, whole) };
    vec![
        Candidate { shadow_detail: whole, ..of("unsimplified", Simplification::NONE) },
        ordered(PruneOrder::Random),
        ordered(PruneOrder::Importance),
        ordered(PruneOrder::BlueNoise),
        Candidate {
            shadow_detail: of_samples(View::SHADOW_DETAIL),
            samples: SUPER,
            ..of("blue-noise, 16 x", of_samples(default))
        },
        of("no area", Simplification { area_preservation: false, ..default }),
        of("no contrast", plain),
        of("no colour contrast", Simplification { color_contrast: false, ..default }),
        of("no shading contrast", Simplification { shading_contrast: false, ..default }),
        of("contrast of equation 4", Simplification { contrast_pixels: None, ..default }),
        of("cosine 1/2", Simplification { mean_cosine: Some(0.5), ..default }),
        of(
            "cosine 2/pi",
            Simplification { mean_cosine: Some(Simplification::PAPER_COSINE), ..default },
        ),
        Candidate { model: Model::Equation3, ..of("equation 3", default) },
        of("no area, no contrast", Simplification { area_preservation: false, ..plain }),
        of("opacity", {
            let fade = windfall_core::simplify::Fade { by: FadeBy::Opacity, ..default.fade };
            Simplification { fade, ..default }
        }),
        Candidate { shadow_detail: whole, ..of("shadows in full", default) },
        of("bounded growth", Simplification::DEFAULT),
        rival("meshopt simplify", Model::Simplify),
        rival("meshopt sloppy", Model::Sloppy),
    ]
}

/// Those that are compared at a nearer distance.
fn near_candidates() -> Vec<Candidate> {
    let all = candidates();
    let mut near: Vec<Candidate> = all
        .iter()
        .copied()
        .filter(|c| {
            matches!(c.name, "unsimplified" | "random" | "importance" | "blue-noise")
                || matches!(c.model, Model::Simplify | Model::Sloppy)
        })
        .collect();
    let bound = |name, growth| {
        let detail = Simplification { growth, ..Simplification::DEFAULT };
        Candidate { name, detail, ..all[1 + PruneOrder::default() as usize] }
    };
    near.extend([
        bound("growth 2, 4 px", Growth { factor: 2.0, pixels: 4.0 }),
        bound("growth 1.5, 4 px", Growth { factor: 1.5, pixels: 4.0 }),
        bound("growth 2, 8 px", Growth { factor: 2.0, pixels: 8.0 }),
        bound("growth 3, 4 px", Growth { factor: 3.0, pixels: 4.0 }),
    ]);
    near
}

/// A tree's models on the GPU, and where it is seen from.
struct Subject {
    stage: Stage,
    middle: Vec3,
    /// Half the side of a square that the tree fits in, from any side.
    reach: f32,
    orders: Vec<(Model, GpuForest)>,
}

impl Subject {
    fn new(gpu: &Gpu, renderer: &Renderer, tree: Tree) -> Self {
        let (low, high) = tree.bounds();
        let size = high - low;
        let middle = (low + high) / 2.0;
        let reach = 0.55 * size.y.max(size.x.hypot(size.z));
        let stage = alone(tree);
        let mut orders = Vec::new();
        for order in PruneOrder::ALL {
            let mut stage = stage.clone();
            stage.trees[0].foliage.set_prune_order(order, 1);
            orders.push((Model::Ordered(order), upload(gpu, renderer, &stage)));
            if order == PruneOrder::default() {
                stage.trees[0].foliage.visibility.disocclusion = Visibility::BY_CHANCE;
                orders.push((Model::Equation3, upload(gpu, renderer, &stage)));
            }
        }
        Self { stage, middle, reach, orders }
    }

    /// The tree from one of `sides`, at a moment of the camera's move: a quarter of a pixel to the
    /// side and a five hundredth of the way ahead in each frame.
    fn view(&self, place: &Place, side: u32, sides: u32, frame: u32) -> View {
        let (sin, cos) = (std::f32::consts::TAU * side as f32 / sides as f32).sin_cos();
        let away = Vec3::new(sin, 0.0, cos);
        let step = frame as f32;
        let aside = Vec3::new(cos, 0.0, -sin) * (0.25 * step * place.distance / place.pixels);
        let eye = self.middle + away * place.distance * (1.0 - 0.002 * step) + aside;
        let camera = Camera {
            eye,
            target: eye - away,
            fov_y: 2.0 * (0.5 * place.size.1 as f32 / place.pixels).atan(),
            near: 0.1,
        };
        View { season: 0.55, ..View::new(camera) }
    }
}

/// Where a tree is looked at from.
struct Place {
    distance: f32,
    /// Pixels that a metre covers at a metre.
    pixels: f32,
    size: (u32, u32),
}

impl Place {
    fn new(subject: &Subject, distance: f32, screen: u32) -> Self {
        // Of a field of view of 45 degrees.
        let pixels = screen as f32 / (2.0 * 22.5f32.to_radians().tan());
        let side = (2.0 * subject.reach * pixels / distance).ceil().clamp(48.0, 640.0) as u32;
        Self { distance, pixels, size: (side.next_multiple_of(8), side.next_multiple_of(8)) }
    }
}

/// What is held against the reference.
struct Seen {
    pictures: Vec<Linear>,
    /// Of the radiance, and of the picture.
    radiance: Foliage,
    picture: Foliage,
    /// Mean difference of consecutive frames.
    flicker: f64,
}

/// Runs part c.
pub fn errors(args: &Args, gpu: &mut Gpu, renderer: &Renderer) -> anyhow::Result<Errors> {
    if args.lambda.iter().any(|l| !(*l > 1e-4 && *l <= 1.0)) {
        bail!("--lambda is above 0.0001 and at most 1");
    }
    if args.sides == 0 || !(64..=4320).contains(&args.screen) {
        bail!("--sides is at least 1, and --screen 64 to 4320");
    }
    let mut errors = Errors { screen: args.screen, sides: args.sides, rows: Vec::new() };
    for name in &args.tree {
        let tree = match (name.parse::<Species>(), args.leaves) {
            (Ok(species), Some(leaves)) => species.grow_with(1, leaves),
            _ => read_or_grow(name, 1, &[], args.height)?,
        };
        if tree.foliage.leaves.is_empty() {
            bail!("{name}: has no leaves");
        }
        let subject = Subject::new(gpu, renderer, tree);
        let bench = Bench { args, renderer, subject: &subject, name };
        println!(
            "\n(c) {name}, {} leaves: each level at its distance",
            subject.stage.trees[0].foliage.leaves.len()
        );
        for &lambda in &args.lambda {
            let place = Place::new(&subject, distance_of(lambda), args.screen);
            let rows = bench.rows(gpu, &place, &[(lambda, false)], &candidates())?;
            errors.rows.extend(rows);
        }
        println!("\n(c) {name}: levels forced at the distance of {NEAR}");
        let place = Place::new(&subject, distance_of(NEAR), args.screen);
        let forced = args.lambda.iter().filter(|l| **l < NEAR);
        let forced: Vec<_> = forced.map(|lambda| (*lambda, true)).collect();
        errors.rows.extend(bench.rows(gpu, &place, &forced, &near_candidates())?);
    }
    Ok(errors)
}

/// Triangles of all leaves with simple shapes.
fn simple_triangle_count(foliage: &windfall_core::foliage::Foliage) -> usize {
    let triangles = |shape: &LeafShape| shape.indices.len() / 3;
    let simple = simple_shapes(foliage);
    let of = |shape: usize| triangles(simple[shape].as_ref().unwrap_or(&foliage.shapes[shape]));
    foliage.leaves.iter().map(|leaf| of(leaf.shape as usize)).sum()
}

/// Where the default simplification has a level.
fn distance_of(lambda: f32) -> f32 {
    let Reduction::Distance { d0 } = Simplification::DEFAULT.reduction else { return 30.0 };
    d0 / lambda.powf(0.5 / Simplification::DEFAULT.exponent())
}

struct Bench<'a> {
    args: &'a Args,
    renderer: &'a Renderer,
    subject: &'a Subject,
    name: &'a str,
}

impl Bench<'_> {
    /// Rows for some levels at one place.
    fn rows(
        &self,
        gpu: &mut Gpu,
        place: &Place,
        levels: &[(f32, bool)],
        candidates: &[Candidate],
    ) -> anyhow::Result<Vec<Row>> {
        let subject = self.subject;
        let whole = self.forest(Model::Ordered(PruneOrder::default()));
        let nothing = Candidate {
            detail: Simplification::NONE,
            shadow_detail: Simplification::NONE,
            samples: SUPER,
            ..candidates[0]
        };
        let films = [1, SUPER].map(|samples| Film::new(gpu, self.renderer, place.size, samples));
        let reference = self.look(gpu, &films, whole, place, &nothing)?;
        self.save(place, "reference", &reference.pictures[0])?;
        let mut rows = Vec::new();
        println!(
            "{:.0} m, {}x{}\n{:>7}  {:<21}{:>8}{:>10}{:>10}{:>10}{:>9}{:>10} |{:>10}{:>10} |{:>8}{:>9}",
            place.distance,
            place.size.0,
            place.size.1,
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
                    let factor = (lambda / NEAR).sqrt();
                    for detail in [&mut candidate.detail, &mut candidate.shadow_detail] {
                        if let Reduction::Distance { d0 } = &mut detail.reduction {
                            *d0 *= factor;
                        }
                    }
                }
                let (drawn, triangles) = self.drawn(place, &candidate);
                let own = match candidate.model {
                    Model::Simplify | Model::Sloppy => {
                        // As many triangles as the default draws at this level.
                        let plain = Candidate {
                            model: Model::Ordered(PruneOrder::default()),
                            detail: Simplification {
                                h: Simplification::DEFAULT.h,
                                growth: Growth::UNBOUNDED,
                                ..candidate.detail
                            },
                            ..candidate
                        };
                        let (_, target) = self.drawn(place, &plain);
                        let how = if candidate.model == Model::Simplify {
                            Rival::Simplify
                        } else {
                            Rival::Sloppy
                        };
                        let tree = simplified(&subject.stage.trees[0], how, target)?;
                        let count = tree.foliage.triangle_count();
                        Some((upload(gpu, self.renderer, &alone(tree)), count))
                    }
                    _ => None,
                };
                let (forest, triangles) = match &own {
                    Some((forest, count)) => (forest, *count),
                    None => (self.forest(candidate.model), triangles),
                };
                let seen = self.look(gpu, &films, forest, place, &candidate)?;
                let over = |a: f64, b: f64| a / b.max(1e-12) - 1.0;
                let (total, of_reference) = (seen.radiance, reference.radiance);
                let flips = seen.pictures.iter().zip(&reference.pictures).map(|(a, b)| a.flip(b));
                let row = Row {
                    tree: self.name.to_owned(),
                    distance: place.distance,
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
                        over(seen.picture.luminance, reference.picture.luminance),
                        over(seen.picture.variance, reference.picture.variance),
                    ],
                    flip: flips.sum::<f64>() / seen.pictures.len() as f64,
                    flicker: seen.flicker - reference.flicker,
                };
                row.print();
                let name = format!("{lambda}-{}", candidate.name);
                self.save(place, &name, &seen.pictures[0])?;
                rows.push(row);
            }
        }
        Ok(rows)
    }

    /// Saves a picture, where pictures are wanted.
    fn save(&self, place: &Place, name: &str, picture: &Linear) -> anyhow::Result<()> {
        let Some(folder) = &self.args.pictures else { return Ok(()) };
        std::fs::create_dir_all(folder).with_context(|| format!("{}", folder.display()))?;
        let stem = Path::new(self.name).file_stem().unwrap_or_default().display();
        let name = name.replace([' ', ',', '/'], "-");
        picture.save_png(&folder.join(format!("{stem}-{:.0}m-{name}.png", place.distance)))
    }

    fn forest(&self, model: Model) -> &GpuForest {
        let found = self.subject.orders.iter().find(|(m, _)| *m == model);
        &found.unwrap_or(&self.subject.orders[0]).1
    }

    /// Share of the leaves that are drawn, those that fade included, and their triangles.
    fn drawn(&self, place: &Place, candidate: &Candidate) -> (f32, usize) {
        let stage = &self.subject.stage;
        let view = self.subject.view(place, 0, 1, 0);
        let detail = &candidate.detail;
        let (share, simple) =
            seen(stage, &view, place.size).first().map_or((1.0, false), |(_, seen)| {
                let level = detail.level(seen);
                (detail.drawn(&level), detail.simple(&level, seen))
            });
        let foliage = &stage.trees[0].foliage;
        let all = if simple { simple_triangle_count(foliage) } else { foliage.triangle_count() };
        (share, (share * all as f32).round() as usize)
    }

    fn look(
        &self,
        gpu: &mut Gpu,
        films: &[Film; 2],
        forest: &GpuForest,
        place: &Place,
        candidate: &Candidate,
    ) -> anyhow::Result<Seen> {
        let sides = self.args.sides;
        let film = &films[usize::from(candidate.samples > 1)];
        let mut shoot = |side, frame, show, filter| {
            let mut view = View {
                show,
                detail: candidate.detail,
                shadow_detail: candidate.shadow_detail,
                ..self.subject.view(place, side, sides, frame)
            };
            // Leaves and what they cover must be filtered alike.
            view.quality.reconstruction &= filter;
            if matches!(show, Show::Leaves | Show::Radiance) {
                // Below the bend of the tone curve and the end of the stored range.
                view.sky.exposure -= 2.0;
            }
            film.shoot(gpu, self.renderer, forest, &view)
        };
        let (mut pictures, mut radiance, mut picture) = (Vec::new(), Vec::new(), Vec::new());
        for side in 0..sides {
            pictures.push(shoot(side, 0, Show::Picture, true)?);
            for (of, show, filter) in
                [(&mut radiance, Show::Radiance, false), (&mut picture, Show::Leaves, true)]
            {
                let leaves = shoot(side, 0, show, filter)?;
                of.push(Foliage::of(&leaves, &shoot(side, 0, Show::Coverage, filter)?));
            }
        }
        let mut flicker = 0.0;
        let mut last = shoot(0, 0, Show::Picture, true)?;
        for frame in 1..MOVE {
            let next = shoot(0, frame, Show::Picture, true)?;
            flicker += next.difference(&last) / f64::from(MOVE - 1);
            last = next;
        }
        let [radiance, picture] = [radiance, picture].map(|of| Foliage::mean(&of));
        Ok(Seen { pictures, radiance, picture, flicker })
    }
}

impl Row {
    fn print(&self) {
        let off =
            self.color.iter().fold(0.0f32, |most, c| if c.abs() > most.abs() { *c } else { most });
        println!(
            "{:>7}  {:<21}{:>8.4}{:>10}{:>+9.1}%{:>+9.1}%{:>+8.1}%{:>+9.1}% |{:>+9.1}%{:>+9.1}% |{:>8.4}{:>9.3}",
            self.lambda,
            self.candidate,
            self.drawn,
            self.leaf_triangles,
            100.0 * self.coverage,
            100.0 * self.luminance,
            100.0 * off,
            100.0 * self.variance,
            100.0 * self.picture[0],
            100.0 * self.picture[1],
            self.flip,
            self.flicker
        );
    }
}

/// One tree on level ground.
fn alone(tree: Tree) -> Stage {
    let instance = Instance {
        model: 0,
        position: Vec3::ZERO,
        yaw: 0.0,
        scale: 1.0,
        season_offset: 0.0,
        seed: 1,
    };
    let forest = Forest { terrain: Terrain::flat(), instances: vec![instance] };
    Stage { trees: vec![tree], forest, falls: Falls::none() }
}

fn upload(gpu: &Gpu, renderer: &Renderer, stage: &Stage) -> GpuForest {
    let falls = &stage.falls;
    GpuForest::with_falls(&gpu.device, &gpu.queue, renderer, &stage.trees, &stage.forest, falls)
}
