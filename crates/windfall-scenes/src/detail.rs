//! How a scene says how its trees are simplified.

use crate::Scene;
use serde::{Deserialize, Serialize};
use windfall_core::simplify::{Fade, FadeBy, FadeRange, Growth, Reduction, Simplification};
use windfall_core::{InputError, InputErrorKind};
use windfall_gpu::View;

/// How trees are simplified: see [`Simplification`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[expect(clippy::struct_excessive_bools, reason = "each is a switch of its own in the file")]
pub struct DetailEntry {
    /// Share of its size at which a tree is drawn with half of its leaves, 0 to 0.99; 0 draws all.
    pub h: f32,
    /// Distance up to which trees are drawn in full.
    pub d0: f32,
    /// Pixels of the bounding sphere above which trees are drawn in full, instead of `d0`.
    pub b0: Option<f32>,
    /// Whether the leaves that are left grow.
    pub area_preservation: bool,
    /// Factor on a leaf's length that is always allowed; `None`: any.
    pub growth_factor: Option<f32>,
    /// Pixels up to which a leaf may grow by any factor.
    pub growth_pixels: f32,
    /// Whether colours draw together.
    pub color_contrast: bool,
    /// Whether shading draws together.
    pub shading_contrast: bool,
    /// The mean cosine towards which it does; `None`: that of the tree's own leaves.
    pub mean_cosine: Option<f32>,
    /// Side of the squares of pixels that are seen as one; `None`: contrasts as in the paper.
    pub contrast_pixels: Option<f32>,
    /// What fades.
    pub fade: FadeEntry,
    /// Half the range of ranks over which leaves fade.
    pub fade_range: FadeRangeEntry,
    /// Whether that is at most `1 - λ`.
    pub full_at_one: bool,
    /// Whether leaves are gone at rank `λ` already.
    pub early: bool,
    /// Whether the fade eases in and out.
    pub smooth: bool,
    /// Pixels by which the surface of simplified wood may be off; 0 keeps it as it is.
    pub wood_pixels: f32,
    /// Pixels below which leaves are drawn in two triangles; 0 keeps the outlines of trees in full.
    pub leaf_pixels: f32,
}

/// What fades: see [`FadeBy`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum FadeEntry {
    /// A leaf's area.
    Size,
    /// Its coverage.
    Opacity,
}

/// See [`FadeRange`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum FadeRangeEntry {
    /// `c`
    Constant(f32),
    /// `c (1 - λ)`
    Linear(f32),
    /// `c (1 - λ)²`
    Quadratic(f32),
    /// `c λ`
    Proportional(f32),
}

impl Default for DetailEntry {
    fn default() -> Self {
        Self::of(&Simplification::DEFAULT)
    }
}

impl DetailEntry {
    /// The default for what casts shadows.
    pub fn shadow() -> Self {
        Self::of(&View::SHADOW_DETAIL)
    }

    fn of(detail: &Simplification) -> Self {
        let (d0, b0) = match detail.reduction {
            Reduction::Distance { d0 } => (d0, None),
            Reduction::ProjectedArea { b0 } => (30.0, Some(b0)),
        };
        let growth = detail.growth;
        Self {
            h: detail.h,
            d0,
            b0,
            area_preservation: detail.area_preservation,
            growth_factor: growth.factor.is_finite().then_some(growth.factor),
            growth_pixels: growth.pixels,
            color_contrast: detail.color_contrast,
            shading_contrast: detail.shading_contrast,
            mean_cosine: detail.mean_cosine,
            contrast_pixels: detail.contrast_pixels,
            fade: match detail.fade.by {
                FadeBy::Size => FadeEntry::Size,
                FadeBy::Opacity => FadeEntry::Opacity,
            },
            fade_range: match detail.fade.range {
                FadeRange::Constant(c) => FadeRangeEntry::Constant(c),
                FadeRange::Linear(c) => FadeRangeEntry::Linear(c),
                FadeRange::Quadratic(c) => FadeRangeEntry::Quadratic(c),
                FadeRange::Proportional(c) => FadeRangeEntry::Proportional(c),
            },
            full_at_one: detail.fade.full_at_one,
            early: detail.fade.early,
            smooth: detail.fade.smooth,
            wood_pixels: detail.wood_pixels,
            leaf_pixels: detail.leaf_pixels,
        }
    }

    /// What the models take.
    pub fn simplification(&self) -> Simplification {
        Simplification {
            reduction: match self.b0 {
                Some(b0) => Reduction::ProjectedArea { b0 },
                None => Reduction::Distance { d0: self.d0 },
            },
            h: self.h,
            area_preservation: self.area_preservation,
            growth: Growth {
                factor: self.growth_factor.unwrap_or(f32::INFINITY),
                pixels: self.growth_pixels,
            },
            color_contrast: self.color_contrast,
            shading_contrast: self.shading_contrast,
            mean_cosine: self.mean_cosine,
            contrast_pixels: self.contrast_pixels,
            fade: Fade {
                by: match self.fade {
                    FadeEntry::Size => FadeBy::Size,
                    FadeEntry::Opacity => FadeBy::Opacity,
                },
                range: match self.fade_range {
                    FadeRangeEntry::Constant(c) => FadeRange::Constant(c),
                    FadeRangeEntry::Linear(c) => FadeRange::Linear(c),
                    FadeRangeEntry::Quadratic(c) => FadeRange::Quadratic(c),
                    FadeRangeEntry::Proportional(c) => FadeRange::Proportional(c),
                },
                full_at_one: self.full_at_one,
                early: self.early,
                smooth: self.smooth,
            },
            wood_pixels: self.wood_pixels,
            leaf_pixels: self.leaf_pixels,
        }
    }

    fn check(&self, file: &str, field: &str) -> Result<(), InputError> {
        let range = match self.fade_range {
            FadeRangeEntry::Constant(c)
            | FadeRangeEntry::Linear(c)
            | FadeRangeEntry::Quadratic(c)
            | FadeRangeEntry::Proportional(c) => c,
        };
        let numbers = [
            ("h", self.h, 0.0, 0.99),
            ("d0", self.d0, 0.01, 1e6),
            ("b0", self.b0.unwrap_or(1.0), 0.01, 1e9),
            ("growth_factor", self.growth_factor.unwrap_or(1.0), 1.0, 1e6),
            ("growth_pixels", self.growth_pixels, 0.0, 1e6),
            ("mean_cosine", self.mean_cosine.unwrap_or(0.5), 0.0, 1.0),
            ("contrast_pixels", self.contrast_pixels.unwrap_or(1.0), 0.01, 1000.0),
            ("fade_range", range, 0.0, 1.0),
            ("wood_pixels", self.wood_pixels, 0.0, 1000.0),
            ("leaf_pixels", self.leaf_pixels, 0.0, 1000.0),
        ];
        for (name, value, low, high) in numbers {
            // A NaN is in no range.
            if !(low..=high).contains(&value) {
                let (place, cause) =
                    (format!("{field}.{name}"), format!("{value} is not within {low} to {high}"));
                return Err(InputError::new(file, place, InputErrorKind::OutOfRange, cause));
            }
        }
        Ok(())
    }
}

impl Scene {
    pub(crate) fn check_detail(&self, file: &str) -> Result<(), InputError> {
        self.detail.check(file, "detail")?;
        self.shadow_detail.check(file, "shadow_detail")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_entry_is_what_it_was_made_of() {
        let other = Simplification {
            reduction: Reduction::ProjectedArea { b0: 900.0 },
            h: 0.7,
            area_preservation: false,
            growth: Growth { factor: f32::INFINITY, pixels: 3.0 },
            color_contrast: false,
            shading_contrast: false,
            mean_cosine: Some(Simplification::PAPER_COSINE),
            contrast_pixels: None,
            fade: Fade {
                by: FadeBy::Opacity,
                range: FadeRange::Quadratic(0.1),
                full_at_one: false,
                early: true,
                smooth: true,
            },
            wood_pixels: 2.0,
            leaf_pixels: 9.0,
        };
        for detail in [Simplification::DEFAULT, View::SHADOW_DETAIL, other] {
            assert_eq!(DetailEntry::of(&detail).simplification(), detail);
        }
    }
}
