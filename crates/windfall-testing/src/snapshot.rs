//! Pictures held against committed references by FLIP.
//!
//! FLIP (Andersson et al., "FLIP: A Difference Evaluator for Alternating Images", 2020) gives each
//! pixel an error of 0 to 1 as a person sees it who flips between two pictures.

use image::RgbImage;
use std::fmt;
use std::path::{Path, PathBuf};

/// Set to `1`, references are written instead of compared.
const BLESS: &str = "WINDFALL_BLESS";

/// How far a picture may be from its reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Largest mean error over the picture, `0..=1`: bounds what is off everywhere, such as light.
    pub mean: f32,
    /// Largest error of all but the worst hundredth of the pixels, `0..=1`: bounds what is off in
    /// one place, such as a missing tree, which a mean over much sky would hide.
    pub percentile_99: f32,
}

impl Default for Tolerance {
    /// For pictures of the same setup by different drivers.
    ///
    /// References come from Mesa's lavapipe. Another version or driver rounds interpolated values,
    /// `exp` and `sin` in the last bits, resolves an edge with a sample more or less, and picks
    /// mip levels a fraction apart: single pixels along leaf edges then differ clearly (the
    /// percentile), the picture as a whole does not (the mean). The same driver gives 0 for both.
    fn default() -> Self {
        Self { mean: 0.015, percentile_99: 0.25 }
    }
}

/// References in one folder, and where to put what does not match them.
#[derive(Debug, Clone)]
pub struct Snapshots {
    references: PathBuf,
    failures: PathBuf,
    bless: bool,
}

/// Why a picture is not its reference.
#[derive(Debug)]
pub enum Mismatch {
    /// There is no reference.
    Missing(PathBuf),
    /// The reference cannot be read, or a file cannot be written.
    File(PathBuf, String),
    /// Sizes differ: the picture's and the reference's.
    Size((u32, u32), (u32, u32)),
    /// The error is beyond the tolerance.
    Different {
        /// Mean error.
        mean: f32,
        /// 99th percentile of the error.
        percentile_99: f32,
        /// What was allowed.
        tolerance: Tolerance,
        /// The picture that was drawn.
        actual: PathBuf,
        /// Errors as colours, black for none.
        difference: PathBuf,
    },
}

impl fmt::Display for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing(path) => write!(
                f,
                "no reference {}; look at the picture, then write it with {BLESS}=1",
                path.display()
            ),
            Self::File(path, cause) => write!(f, "{}: {cause}", path.display()),
            Self::Size(actual, reference) => {
                write!(f, "the picture is {actual:?} and its reference {reference:?}")
            }
            Self::Different { mean, percentile_99, tolerance, actual, difference } => write!(
                f,
                "FLIP mean {mean:.4} (allowed {:.4}), 99th percentile {percentile_99:.4} (allowed \
                 {:.4}); see {} and {}",
                tolerance.mean,
                tolerance.percentile_99,
                actual.display(),
                difference.display()
            ),
        }
    }
}

impl std::error::Error for Mismatch {}

impl Snapshots {
    /// The references `tests/references/*.png` of the crate whose `CARGO_MANIFEST_DIR` is given;
    /// what does not match goes to `snapshots/` in the target folder. `WINDFALL_BLESS=1` writes
    /// references.
    pub fn of_crate(manifest_dir: &str) -> Self {
        let target = std::env::var_os("CARGO_TARGET_DIR")
            .map_or_else(|| Path::new(manifest_dir).join("../../target"), PathBuf::from);
        Self {
            references: Path::new(manifest_dir).join("tests/references"),
            failures: target.join("snapshots"),
            bless: std::env::var(BLESS).is_ok_and(|v| v == "1"),
        }
    }

    /// References and failures in the given folders.
    pub fn new(references: PathBuf, failures: PathBuf, bless: bool) -> Self {
        Self { references, failures, bless }
    }

    /// Holds a picture (rows from the top, sRGB, four bytes a pixel, alpha ignored) against the
    /// reference of this name.
    ///
    /// # Errors
    ///
    /// [`Mismatch`]; the picture and the difference are then in the failures' folder.
    ///
    /// # Panics
    ///
    /// If `rgba` is not `width * height * 4` bytes.
    pub fn check(
        &self,
        name: &str,
        (width, height): (u32, u32),
        rgba: &[u8],
        tolerance: Tolerance,
    ) -> Result<(), Mismatch> {
        assert_eq!(rgba.len(), width as usize * height as usize * 4, "{name}");
        let rgb = rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
        let actual = RgbImage::from_raw(width, height, rgb).expect("three bytes a pixel");
        let path = self.references.join(format!("{name}.png"));
        if self.bless {
            return save(&actual, &path);
        }
        if !path.exists() {
            save(&actual, &self.failures.join(format!("{name}.actual.png")))?;
            return Err(Mismatch::Missing(path));
        }
        let reference =
            image::open(&path).map_err(|e| Mismatch::File(path, e.to_string()))?.to_rgb8();
        if reference.dimensions() != actual.dimensions() {
            return Err(Mismatch::Size(actual.dimensions(), reference.dimensions()));
        }
        let flip_image = |i: &RgbImage| nv_flip::FlipImageRgb8::with_data(width, height, i);
        let errors = nv_flip::flip(
            flip_image(&reference),
            flip_image(&actual),
            nv_flip::DEFAULT_PIXELS_PER_DEGREE,
        );
        // Exact: the crate's own percentile is that of a histogram.
        let mut sorted = errors.to_vec();
        sorted.sort_by(f32::total_cmp);
        let mean = sorted.iter().sum::<f32>() / sorted.len().max(1) as f32;
        let percentile_99 = sorted.get(sorted.len() * 99 / 100).copied().unwrap_or(0.0);
        // Not `mean > …`: an error that is not a number is a difference.
        if mean <= tolerance.mean && percentile_99 <= tolerance.percentile_99 {
            return Ok(());
        }
        let seen = errors.apply_color_lut(&nv_flip::magma_lut()).to_vec();
        let seen = RgbImage::from_raw(width, height, seen).expect("three bytes a pixel");
        let actual_path = self.failures.join(format!("{name}.actual.png"));
        let difference = self.failures.join(format!("{name}.difference.png"));
        save(&actual, &actual_path)?;
        save(&seen, &difference)?;
        Err(Mismatch::Different { mean, percentile_99, tolerance, actual: actual_path, difference })
    }

    /// [`Self::check`] as an assertion.
    ///
    /// # Panics
    ///
    /// If the picture is not its reference.
    pub fn assert(&self, name: &str, size: (u32, u32), rgba: &[u8], tolerance: Tolerance) {
        if let Err(mismatch) = self.check(name, size, rgba, tolerance) {
            panic!("picture {name}: {mismatch}");
        }
    }
}

fn save(image: &RgbImage, path: &Path) -> Result<(), Mismatch> {
    let fail = |e: String| Mismatch::File(path.to_owned(), e);
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|e| fail(e.to_string()))?;
    }
    image.save(path).map_err(|e| fail(e.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (u32, u32) = (40, 30);

    /// A sky over a ground, with a tree of this width.
    fn picture(tree: u32) -> Vec<u8> {
        image::RgbaImage::from_fn(SIZE.0, SIZE.1, |x, y| {
            let trunk = x.abs_diff(20) < tree && y > 5;
            image::Rgba(match (trunk, y) {
                (true, _) => [60, 40, 20, 255],
                (_, 0..20) => [150, 190, 230, 255],
                _ => [120, 90, 50, 255],
            })
        })
        .into_raw()
    }

    fn folders() -> (tempfile::TempDir, Snapshots, Snapshots) {
        let folder = tempfile::tempdir().unwrap();
        let at = |bless| {
            Snapshots::new(folder.path().join("references"), folder.path().join("failures"), bless)
        };
        let (blessing, comparing) = (at(true), at(false));
        (folder, blessing, comparing)
    }

    #[test]
    fn the_same_picture_passes_without_tolerance() {
        let (_folder, blessing, comparing) = folders();
        blessing.assert("tree", SIZE, &picture(4), Tolerance::default());
        let exact = Tolerance { mean: 0.0, percentile_99: 0.0 };
        comparing.assert("tree", SIZE, &picture(4), exact);
    }

    #[test]
    fn a_missing_reference_fails_and_is_not_written() {
        let (folder, _, comparing) = folders();
        let failed = comparing.check("tree", SIZE, &picture(4), Tolerance::default());
        assert!(matches!(failed, Err(Mismatch::Missing(_))), "{failed:?}");
        assert!(!folder.path().join("references/tree.png").exists());
        assert!(folder.path().join("failures/tree.actual.png").exists());
    }

    #[test]
    fn a_missing_tree_fails_by_the_percentile_and_leaves_pictures() {
        let (_folder, blessing, comparing) = folders();
        blessing.assert("tree", SIZE, &picture(1), Tolerance::default());
        // One column of forty: the mean alone would let it pass.
        let loose = Tolerance { mean: 0.5, ..Tolerance::default() };
        match comparing.check("tree", SIZE, &picture(0), loose) {
            Err(Mismatch::Different { percentile_99, actual, difference, .. }) => {
                assert!(percentile_99 > loose.percentile_99);
                assert!(actual.exists() && difference.exists());
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn light_that_is_off_everywhere_fails_by_the_mean() {
        let (_folder, blessing, comparing) = folders();
        blessing.assert("tree", SIZE, &picture(4), Tolerance::default());
        let darker: Vec<u8> = picture(4).iter().map(|&v| v - v / 8).collect();
        let loose = Tolerance { percentile_99: 1.0, ..Tolerance::default() };
        let failed = comparing.check("tree", SIZE, &darker, loose);
        assert!(matches!(failed, Err(Mismatch::Different { .. })), "{failed:?}");
    }

    #[test]
    fn another_size_fails() {
        let (_folder, blessing, comparing) = folders();
        blessing.assert("tree", SIZE, &picture(4), Tolerance::default());
        let failed = comparing.check("tree", (30, 40), &picture(4), Tolerance::default());
        assert!(matches!(failed, Err(Mismatch::Size((30, 40), SIZE))), "{failed:?}");
    }
}
