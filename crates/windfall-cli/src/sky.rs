//! Pictures of the sky from files.

use anyhow::{Context, bail};
use glam::Vec3;
use image::{ImageFormat, ImageReader, Limits};
use std::path::Path;
use windfall_gpu::SkyPicture;

/// Most bytes that a decoder may take: 8192 x 4096 texels of four floats, and as much again.
const MOST_BYTES: u64 = 1 << 30;

/// Reads an equirectangular `.hdr` or `.exr` file.
pub fn read(path: &Path) -> anyhow::Result<SkyPicture> {
    let name = path.display();
    let format = match path.extension().and_then(|e| e.to_str()).map(str::to_lowercase).as_deref() {
        Some("hdr") => ImageFormat::Hdr,
        Some("exr") => ImageFormat::OpenExr,
        _ => bail!("{name}: a picture of the sky is a .hdr or .exr file"),
    };
    let file = std::fs::File::open(path).with_context(|| format!("{name}: cannot be read"))?;
    let mut reader = ImageReader::with_format(std::io::BufReader::new(file), format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(MOST_BYTES);
    reader.limits(limits);
    let image = reader.decode().with_context(|| format!("{name}: is damaged"))?.into_rgb32f();
    let (width, height) = image.dimensions();
    // What an unset channel or a filter's overshoot leaves below zero is no light.
    let radiance = image.pixels().map(|p| Vec3::from(p.0).max(Vec3::ZERO)).collect();
    SkyPicture::new(width, height, radiance).with_context(|| name.to_string())
}
