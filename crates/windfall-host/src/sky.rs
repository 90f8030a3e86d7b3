//! Pictures of the sky from files.

use ::image::{ImageFormat, ImageReader, Limits};
use anyhow::{Context, bail};
use std::io::Cursor;
use std::path::Path;
use windfall_core::glam::Vec3;
use windfall_gpu::SkyPicture;

/// Most bytes that a decoder may take: 8192 x 4096 texels of four floats, and as much again.
const MOST_BYTES: u64 = 1 << 30;

/// Reads an equirectangular `.hdr` or `.exr` file.
///
/// # Errors
///
/// Those of [`parse`], or the file cannot be read.
pub fn read(path: &Path) -> anyhow::Result<SkyPicture> {
    let name = path.display().to_string();
    let bytes = std::fs::read(path).with_context(|| format!("{name}: cannot be read"))?;
    parse(&bytes, &name)
}

/// Reads the bytes of an equirectangular `.hdr` or `.exr` file; `name` tells which, and is named in errors.
///
/// # Errors
///
/// Another ending of the name, bytes that are not of that format, a picture of more than about 8192 x 4096 texels,
/// or one that is no sky ([`SkyPicture::new`]).
pub fn parse(bytes: &[u8], name: &str) -> anyhow::Result<SkyPicture> {
    let ending = Path::new(name).extension().and_then(|e| e.to_str()).map(str::to_lowercase);
    let format = match ending.as_deref() {
        Some("hdr") => ImageFormat::Hdr,
        Some("exr") => ImageFormat::OpenExr,
        _ => bail!("{name}: a picture of the sky is a .hdr or .exr file"),
    };
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(MOST_BYTES);
    reader.limits(limits);
    let image = reader.decode().with_context(|| format!("{name}: is damaged"))?.into_rgb32f();
    let (width, height) = image.dimensions();
    // What an unset channel or a filter's overshoot leaves below zero is no light.
    let radiance = image.pixels().map(|p| Vec3::from(p.0).max(Vec3::ZERO)).collect();
    SkyPicture::new(width, height, radiance).with_context(|| name.to_owned())
}
