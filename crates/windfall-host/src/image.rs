//! Image sizes on the command line, and PNG files.

use crate::file::write_atomic;
use std::path::Path;

/// Reads an image size such as `1280x720`: width and height, pixels.
///
/// # Errors
///
/// A sentence for the command line if the text has another form.
pub fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let sides =
        text.split_once(['x', 'X']).and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    sides.ok_or_else(|| "a size is WIDTHxHEIGHT, such as 1280x720".to_owned())
}

/// A borrowed image: 8-bit sRGB with alpha, rows from the top.
#[derive(Debug, Clone, Copy)]
pub struct RgbaImage<'a> {
    /// Pixels of a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Four bytes per pixel.
    pub rgba: &'a [u8],
}

impl RgbaImage<'_> {
    /// The image without alpha, three bytes per pixel.
    pub fn rgb(&self) -> Vec<u8> {
        self.rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect()
    }

    /// Writes a PNG file without alpha, whole or not at all.
    ///
    /// # Errors
    ///
    /// The file cannot be written, or `rgba` is not `width * height` pixels.
    pub fn save_png(&self, path: &Path) -> anyhow::Result<()> {
        self.write_png(path, png::ColorType::Rgb, &self.rgb())
    }

    /// Writes a PNG file with its alpha, whole or not at all.
    ///
    /// # Errors
    ///
    /// As [`Self::save_png`].
    pub fn save_png_with_alpha(&self, path: &Path) -> anyhow::Result<()> {
        self.write_png(path, png::ColorType::Rgba, self.rgba)
    }

    fn write_png(&self, path: &Path, color: png::ColorType, data: &[u8]) -> anyhow::Result<()> {
        write_atomic(path, |file| {
            let mut encoder = png::Encoder::new(file, self.width, self.height);
            encoder.set_color(color);
            encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
            let mut writer = encoder.write_header()?;
            writer.write_image_data(data)?;
            writer.finish()?;
            Ok(())
        })
    }
}
