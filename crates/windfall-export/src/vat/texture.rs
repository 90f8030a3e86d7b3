//! The texels, row by row.

use super::Vat;
use crate::ExportError;
use exr::prelude::{
    Blocks, Compression, Encoding, Image, Layer, LayerAttributes, LineOrder, SpecificChannels,
    Vec2, WritableImage,
};
use glam::Vec4;
use std::io::{Seek, Write};

/// How a texel is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Texels {
    /// OpenEXR, four floats of 32 bits, not compressed.
    Exr,
    /// PNG, four numbers of 16 bits: positions as shares of the sidecar's `low` to `high`, quaternions of -1 to 1.
    Png,
}

/// Which of the two textures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Which {
    /// Places of leaves.
    Position,
    /// Their rotations.
    Rotation,
}

impl Vat<'_> {
    fn texel(&self, which: Which, column: usize, row: usize) -> Vec4 {
        let Some((leaf, frame)) = self.at(column, row) else {
            return match which {
                Which::Position => self.low.extend(0.0),
                Which::Rotation => Vec4::W,
            };
        };
        let state = self.state(leaf, frame);
        match which {
            Which::Position => {
                self.engine.place(state.position).extend(if state.shown { 1.0 } else { 0.0 })
            }
            Which::Rotation => Vec4::from(self.engine.rotation(state.orientation.normalize())),
        }
    }

    /// Writes a texture. `progress` is told the share that is done.
    ///
    /// # Errors
    ///
    /// The output cannot be written.
    pub fn write_texture(
        &self,
        which: Which,
        texels: Texels,
        out: &mut (impl Write + Seek),
        progress: &mut dyn FnMut(f32),
    ) -> Result<(), ExportError> {
        match texels {
            Texels::Exr => self.write_exr(which, out, progress),
            Texels::Png => self.write_png(which, out, progress),
        }
    }

    fn write_exr(
        &self,
        which: Which,
        out: &mut (impl Write + Seek),
        progress: &mut dyn FnMut(f32),
    ) -> Result<(), ExportError> {
        let name = match which {
            Which::Position => "position",
            Which::Rotation => "rotation",
        };
        write_exr(name, self.size(), |x, y| self.texel(which, x, y), out, progress)
    }

    fn write_png(
        &self,
        which: Which,
        out: &mut dyn Write,
        progress: &mut dyn FnMut(f32),
    ) -> Result<(), ExportError> {
        let io = |error| match error {
            png::EncodingError::IoError(error) => ExportError::Io(error),
            other => ExportError::Io(std::io::Error::other(other.to_string())),
        };
        let (width, height) = self.size();
        let mut encoder = png::Encoder::new(out, width as u32, height as u32);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Sixteen);
        // A script without a library can read it; and places hardly repeat.
        encoder.set_filter(png::Filter::NoFilter);
        let mut writer = encoder.write_header().map_err(io)?;
        let mut stream = writer.stream_writer().map_err(io)?;
        let (low, span) = match which {
            Which::Position => (self.low.extend(0.0), (self.high - self.low).extend(1.0)),
            Which::Rotation => (Vec4::NEG_ONE, Vec4::splat(2.0)),
        };
        // An axis along which all are at one place has no shares.
        let span = span.max(Vec4::splat(1e-9));
        let mut line = Vec::with_capacity(width * 8);
        for row in 0..height {
            line.clear();
            for column in 0..width {
                let share = (self.texel(which, column, row) - low) / span;
                let steps = (share.clamp(Vec4::ZERO, Vec4::ONE) * 65_535.0).round();
                line.extend(steps.to_array().iter().flat_map(|s| (*s as u16).to_be_bytes()));
            }
            stream.write_all(&line)?;
            progress((row + 1) as f32 / height as f32);
        }
        stream.finish().map_err(io)?;
        writer.finish().map_err(io)
    }
}

/// Writes an OpenEXR file of four floats a texel, asked for line by line.
pub fn write_exr(
    name: &str,
    size: (usize, usize),
    texel: impl Fn(usize, usize) -> Vec4 + Sync,
    out: &mut (impl Write + Seek),
    progress: &mut dyn FnMut(f32),
) -> Result<(), ExportError> {
    let texel = |at: Vec2<usize>| <(f32, f32, f32, f32)>::from(texel(at.x(), at.y()));
    // Any reader takes lines without compression; and places hardly repeat.
    let encoding = Encoding {
        compression: Compression::Uncompressed,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let channels = SpecificChannels::rgba(texel);
    let layer = Layer::new(size, LayerAttributes::named(name), encoding, channels);
    let image = Image::from_layer(layer);
    let write = image.write().non_parallel().on_progress(|share| progress(share as f32));
    write.to_buffered(out).map_err(|error| match error {
        exr::error::Error::Io(error) => ExportError::Io(error),
        other => ExportError::Io(std::io::Error::other(other.to_string())),
    })
}
