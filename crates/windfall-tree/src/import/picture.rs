//! Pictures: decoding, the threshold of blended ones, and colour in the holes.

use std::io::Cursor;
use windfall_core::material::{Image, Surface};

/// Widest and highest picture that is decoded, pixels; what a GPU of today takes.
const LARGEST_SIDE: u32 = 8192;

/// Decodes a PNG, JPEG or WebP.
pub(crate) fn decode(bytes: &[u8]) -> Result<Image, ::image::ImageError> {
    let mut reader = ::image::ImageReader::new(Cursor::new(bytes)).with_guessed_format()?;
    let mut limits = ::image::Limits::default();
    limits.max_image_width = Some(LARGEST_SIDE);
    limits.max_image_height = Some(LARGEST_SIDE);
    reader.limits(limits);
    let picture = reader.decode()?.into_rgba8();
    let (width, height) = picture.dimensions();
    Ok(Image { width, height, rgba: picture.into_raw() })
}

/// The alpha below which a blended picture is taken for a hole: half of what its most opaque hundredth has, among
/// the texels that are not quite clear.
pub(super) fn blend_threshold(surface: &Surface) -> f32 {
    let Surface::Texture(image, _) = surface else { return 0.5 };
    let mut counts = [0usize; 256];
    for texel in image.rgba.chunks_exact(4) {
        counts[texel[3] as usize] += 1;
    }
    let seen: usize = counts[1..].iter().sum();
    let mut above = 0;
    for alpha in (1..256).rev() {
        above += counts[alpha];
        if above * 100 >= seen.max(1) {
            return (alpha as f32 * 0.5).max(1.0) / 255.0;
        }
    }
    0.5
}

/// Gives texels in the holes of a mask the colours around them, so that filtering a texture draws no fringe of
/// what exporters leave there, often white or black.
///
/// Pull and push (Gortler et al. 1996, "The Lumigraph"): means weighted by alpha over ever larger squares, from
/// which holes are filled.
pub(super) fn fill_holes(image: &mut Image, cutoff: f32) {
    let cutoff = (cutoff * 255.0).max(1.0);
    if image.rgba.chunks_exact(4).all(|texel| f32::from(texel[3]) >= cutoff) {
        return;
    }
    let weighted = |t: &[u8]| {
        let share = (f32::from(t[3]) / cutoff).min(1.0);
        // Nearly clear texels have rounded colours.
        let share = share * share;
        [f32::from(t[0]) * share, f32::from(t[1]) * share, f32::from(t[2]) * share, share]
    };
    // The image itself stays in bytes: as floats, large ones would take a gigabyte.
    let width = image.width as usize;
    let rows = image.rgba.chunks_exact(4 * width).map(|row| row.chunks_exact(4).map(weighted));
    let mut levels = vec![Level::halved(width, image.height as usize, rows)];
    while let Some(last) = levels.last().filter(|level| level.width > 1 || level.height > 1) {
        let rows = last.texels.chunks_exact(last.width).map(|row| row.iter().copied());
        levels.push(Level::halved(last.width, last.height, rows));
    }
    for i in (0..levels.len() - 1).rev() {
        let (fine, coarse) = levels.split_at_mut(i + 1);
        fine[i].fill(&coarse[0]);
    }
    for (i, texel) in image.rgba.chunks_exact_mut(4).enumerate() {
        let mut color = weighted(texel);
        mix(&mut color, levels[0].above(i % width, i / width));
        if f32::from(texel[3]) < cutoff && color[3] > 0.0 {
            for (byte, value) in texel.iter_mut().zip(&color[..3]) {
                *byte = value.round() as u8;
            }
        }
    }
}

/// Colours times their weights, and the weights, `0..=1`.
struct Level {
    width: usize,
    height: usize,
    texels: Vec<[f32; 4]>,
}

impl Level {
    /// Sums of two by two texels each, brought back to a weight of 1 at most.
    fn halved(
        width: usize,
        height: usize,
        rows: impl Iterator<Item = impl Iterator<Item = [f32; 4]>>,
    ) -> Self {
        let half = (width.div_ceil(2), height.div_ceil(2));
        let mut texels = vec![[0.0; 4]; half.0 * half.1];
        for (y, row) in rows.enumerate() {
            for (x, texel) in row.enumerate() {
                let sum = &mut texels[y / 2 * half.0 + x / 2];
                for (sum, value) in sum.iter_mut().zip(texel) {
                    *sum += value;
                }
            }
        }
        for texel in texels.iter_mut().filter(|texel| texel[3] > 1.0) {
            let weight = texel[3];
            for value in texel {
                *value /= weight;
            }
        }
        Self { width: half.0, height: half.1, texels }
    }

    /// The texel over a place in the level that this one was halved from.
    fn above(&self, x: usize, y: usize) -> [f32; 4] {
        self.texels[y / 2 * self.width + x / 2]
    }

    fn fill(&mut self, coarse: &Self) {
        for y in 0..self.height {
            for x in 0..self.width {
                mix(&mut self.texels[y * self.width + x], coarse.above(x, y));
            }
        }
    }
}

/// Fills up the weight of a texel with the colour around it.
fn mix(texel: &mut [f32; 4], around: [f32; 4]) {
    let missing = 1.0 - texel[3];
    if missing > 0.0 && around[3] > 0.0 {
        for (value, around) in texel.iter_mut().zip(around.map(|v| v / around[3])) {
            *value += around * missing;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: u32, texels: &[[u8; 4]]) -> Image {
        Image { width, height: texels.len() as u32 / width, rgba: texels.concat() }
    }

    #[test]
    fn holes_take_the_colour_around_them() {
        let (leaf, white) = ([40, 90, 20, 255], [255, 255, 255, 0]);
        let mut mixed = image(4, &[leaf, white, white, white, white, white, white, white]);
        fill_holes(&mut mixed, 0.5);
        for texel in mixed.rgba.chunks_exact(4) {
            assert_eq!(texel[..3], leaf[..3]);
        }
        let alphas: Vec<u8> = mixed.rgba.chunks_exact(4).map(|t| t[3]).collect();
        assert_eq!(alphas, [255, 0, 0, 0, 0, 0, 0, 0], "holes stay holes");
        // Nothing is there to take a colour from.
        let mut clear = image(2, &[white, white]);
        fill_holes(&mut clear, 0.5);
        assert!(clear == image(2, &[white, white]));
    }

    #[test]
    fn a_blended_picture_is_cut_at_half_of_what_it_has() {
        let threshold = |alpha: &[u8]| {
            let texels: Vec<[u8; 4]> = alpha.iter().map(|&a| [9, 9, 9, a]).collect();
            (blend_threshold(&Surface::Texture(image(alpha.len() as u32, &texels), false)) * 255.0)
                .round()
        };
        assert_eq!(threshold(&[0, 30, 110, 110]), 55.0);
        assert_eq!(threshold(&[0, 255, 255, 7]), 128.0);
        assert_eq!(threshold(&[1, 1]), 1.0);
        assert_eq!((blend_threshold(&Surface::Plain), threshold(&[0, 0])), (0.5, 128.0));
    }
}
