//! `windfall farm film`: the frames that are there, joined.

use crate::output::{Film, Output};
use crate::render::parse_frames;
use anyhow::{Context, bail};
use std::path::{Path, PathBuf};
use windfall_host::image::RgbaImage;

/// Arguments of `windfall farm film`.
#[derive(clap::Args)]
pub struct Args {
    /// The frames: a pattern such as frames/frame_%05d.png
    #[arg(value_name = "PATTERN")]
    pattern: String,
    /// Frames, first and last
    #[arg(long, value_name = "A-B", value_parser = parse_frames)]
    frames: (u32, u32),
    /// Frames per second
    #[arg(long, value_name = "N", default_value_t = 30.0)]
    fps: f32,
    /// Where to: FILE.mp4, FILE.apng or FILE.gif
    #[arg(long, value_name = "FILE")]
    out: String,
}

/// Joins frames to a film.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let Args { pattern, frames: (first, last), fps, out } = args;
    let frames = Output::parse(pattern)?;
    if !matches!(frames, Output::Frames { .. }) {
        bail!("{pattern}: is not a pattern such as frame_%05d.png");
    }
    if !(*fps > 0.0 && fps.is_finite()) {
        bail!("--fps {fps}: is not above 0");
    }
    let output = Output::parse(out)?;
    let all = || (*first..=*last).filter_map(|frame| Some((frame, frames.frame_path(frame)?)));
    let there: Vec<(u32, PathBuf)> = all().filter(|(_, path)| path.is_file()).collect();
    let missing: Vec<u32> = all().filter(|(_, path)| !path.is_file()).map(|f| f.0).collect();
    let Some((_, start)) = there.first() else {
        bail!("{pattern}: none of the frames {first}-{last} is there");
    };
    let (width, height, _) = read_frame(start)?;
    let Some(mut film) = Film::begin(&output, (width, height), there.len() as u32, *fps, false)?
    else {
        bail!("--out {out}: is not .mp4, .apng or .gif");
    };
    for (_, path) in &there {
        let (w, h, rgba) = read_frame(path)?;
        if (w, h) != (width, height) {
            bail!("{}: is {w}x{h}, and {} is {width}x{height}", path.display(), start.display());
        }
        film.add(&RgbaImage { width, height, rgba: &rgba })?;
    }
    film.finish()?;
    if !missing.is_empty() {
        let of = u64::from(last - first) + 1;
        eprintln!("note: {} of {of} frames are missing: {}", missing.len(), ranges(&missing));
    }
    Ok(())
}

/// Numbers in rising order, as `4, 7-9`.
fn ranges(numbers: &[u32]) -> String {
    let mut runs: Vec<(u32, u32)> = Vec::new();
    for &number in numbers {
        match runs.last_mut() {
            Some(run) if run.1 + 1 == number => run.1 = number,
            _ => runs.push((number, number)),
        }
    }
    let text = |(a, b): (u32, u32)| if a == b { a.to_string() } else { format!("{a}-{b}") };
    runs.into_iter().map(text).collect::<Vec<_>>().join(", ")
}

/// Width, height and RGBA of a frame.
fn read_frame(path: &Path) -> anyhow::Result<(u32, u32, Vec<u8>)> {
    let cannot = || format!("{}: cannot be read", path.display());
    let file = std::fs::File::open(path).with_context(cannot)?;
    let mut decoder = png::Decoder::new(std::io::BufReader::new(file));
    decoder.set_transformations(png::Transformations::ALPHA | png::Transformations::STRIP_16);
    let mut reader = decoder.read_info().with_context(cannot)?;
    let size = reader.output_buffer_size().with_context(cannot)?;
    let mut rgba = vec![0; size];
    let info = reader.next_frame(&mut rgba).with_context(cannot)?;
    rgba.truncate(info.buffer_size());
    if info.color_type != png::ColorType::Rgba {
        bail!("{}: is not in colour", path.display());
    }
    Ok((info.width, info.height, rgba))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_follow_each_other_are_ranges() {
        assert_eq!(ranges(&[4, 7, 8, 9, 11]), "4, 7-9, 11");
        assert_eq!(ranges(&[0]), "0");
    }
}
