//! The trees that are compared with the reference: variants of the simplification, and baselines.

use super::SUPERSAMPLING;
use super::meshopt_baseline::MeshoptBaseline;
use windfall_core::simplify::{Fade, FadeBy, Growth, PruneOrder, Simplification};
use windfall_gpu::View;

/// What is drawn instead of the full tree.
#[derive(Clone, Copy)]
pub struct Candidate {
    pub name: &'static str,
    pub model: Model,
    pub detail: Simplification,
    pub shadow_detail: Simplification,
    /// Samples in a row of a pixel: 1, or those of the reference.
    pub samples: u32,
}

/// The tree model that a candidate draws.
#[derive(Clone, Copy, PartialEq)]
pub enum Model {
    Ordered(PruneOrder),
    /// The default order, with leaves that grow as equation 3 says.
    Equation3,
    /// A tree whose leaves are simplified as one mesh, for each level anew.
    Meshopt(MeshoptBaseline),
}

/// The simplification that draws at the reference's resolution what `detail` draws at the
/// candidates'.
fn supersampled(detail: Simplification) -> Simplification {
    let growth = Growth { pixels: detail.growth.pixels * SUPERSAMPLING as f32, ..detail.growth };
    let contrast_pixels = detail.contrast_pixels.map(|pixels| pixels * SUPERSAMPLING as f32);
    let wood_pixels = detail.wood_pixels * SUPERSAMPLING as f32;
    Simplification { growth, contrast_pixels, wood_pixels, ..detail }
}

/// The candidates at the distance of a level.
pub fn candidates() -> Vec<Candidate> {
    let of = |name, detail| Candidate {
        name,
        model: Model::Ordered(PruneOrder::default()),
        detail,
        shadow_detail: View::SHADOW_DETAIL,
        samples: 1,
    };
    // A bound on growth would draw more leaves than the level says.
    let default = Simplification { growth: Growth::UNBOUNDED, ..Simplification::DEFAULT };
    let full = Simplification { h: 0.0, ..default };
    let ordered =
        |order: PruneOrder| Candidate { model: Model::Ordered(order), ..of(order.name(), default) };
    let no_contrast = Simplification { color_contrast: false, shading_contrast: false, ..default };
    let meshopt = |name, baseline| Candidate {
        model: Model::Meshopt(baseline),
        shadow_detail: full,
        ..of(name, full)
    };
    vec![
        Candidate { shadow_detail: full, ..of("unsimplified", Simplification::NONE) },
        ordered(PruneOrder::Random),
        ordered(PruneOrder::Importance),
        ordered(PruneOrder::BlueNoise),
        Candidate {
            shadow_detail: supersampled(View::SHADOW_DETAIL),
            samples: SUPERSAMPLING,
            ..of("blue-noise, 16 x", supersampled(default))
        },
        of("no area", Simplification { area_preservation: false, ..default }),
        of("no contrast", no_contrast),
        of("no colour contrast", Simplification { color_contrast: false, ..default }),
        of("no shading contrast", Simplification { shading_contrast: false, ..default }),
        of("contrast of equation 4", Simplification { contrast_pixels: None, ..default }),
        of("cosine 1/2", Simplification { mean_cosine: Some(0.5), ..default }),
        of(
            "cosine 2/pi",
            Simplification { mean_cosine: Some(Simplification::PAPER_COSINE), ..default },
        ),
        Candidate { model: Model::Equation3, ..of("equation 3", default) },
        of("no area, no contrast", Simplification { area_preservation: false, ..no_contrast }),
        of("opacity", {
            let fade = Fade { by: FadeBy::Opacity, ..default.fade };
            Simplification { fade, ..default }
        }),
        Candidate { shadow_detail: full, ..of("shadows in full", default) },
        of("bounded growth", Simplification::DEFAULT),
        meshopt("meshopt simplify", MeshoptBaseline::Simplify),
        meshopt("meshopt dilated", MeshoptBaseline::Dilated),
        meshopt("meshopt sloppy", MeshoptBaseline::Sloppy),
    ]
}

/// The candidates at a nearer distance.
pub fn near_candidates() -> Vec<Candidate> {
    let all = candidates();
    let mut near: Vec<Candidate> = all
        .iter()
        .copied()
        .filter(|c| {
            matches!(c.name, "unsimplified" | "random" | "importance" | "blue-noise")
                || matches!(c.model, Model::Meshopt(_))
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
