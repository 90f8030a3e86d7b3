//! The files that `--out` names: images and films, written whole or not at all.

use anyhow::{Context, bail};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use windfall_host::file::AtomicFile;
use windfall_host::image::RgbaImage;

/// What `--out` asks for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Output {
    Png(PathBuf),
    Apng(PathBuf),
    Gif(PathBuf),
    Mp4(PathBuf),
    Exr(PathBuf),
    /// A PNG or EXR per frame: what stands before the number, its width, what stands after.
    Frames {
        before: String,
        digits: usize,
        after: String,
    },
}

impl Output {
    /// Reads `FILE.png`, `.apng`, `.gif`, `.mp4`, or a pattern such as `frames_%05d.png`.
    pub fn parse(text: &str) -> anyhow::Result<Self> {
        if let Some((before, rest)) = text.split_once('%') {
            let end = rest.find('d').with_context(|| {
                format!("--out {text}: a pattern needs %d or %05d for the frame's number")
            })?;
            let digits = match &rest[..end] {
                "" => 1,
                digits => digits
                    .parse()
                    .ok()
                    .filter(|d| (1..=12).contains(d))
                    .with_context(|| format!("--out {text}: %{digits}d is not %d or %05d"))?,
            };
            let after = rest[end + 1..].to_owned();
            if after.contains('%') {
                bail!("--out {text}: a pattern has one number");
            }
            if ![".png", ".exr"].iter().any(|end| after.to_lowercase().ends_with(end)) {
                bail!("--out {text}: frames are written as .png or .exr");
            }
            return Ok(Self::Frames { before: before.to_owned(), digits, after });
        }
        let path = PathBuf::from(text);
        if path.is_dir() {
            bail!("--out {text}: is a folder");
        }
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
        Ok(match extension.as_str() {
            "png" => Self::Png(path),
            "apng" => Self::Apng(path),
            "gif" => Self::Gif(path),
            "mp4" => Self::Mp4(path),
            "exr" => Self::Exr(path),
            _ => bail!("--out {text}: the name must end in .png, .exr, .apng, .gif or .mp4"),
        })
    }

    /// The file of a frame, where each has one.
    pub fn frame_path(&self, frame: u32) -> Option<PathBuf> {
        match self {
            Self::Frames { before, digits, after } => {
                Some(PathBuf::from(format!("{before}{frame:0digits$}{after}")))
            }
            _ => None,
        }
    }
}

impl Output {
    /// Whether frames are EXR files: linear radiance and depth.
    pub fn is_exr(&self) -> bool {
        match self {
            Self::Exr(_) => true,
            Self::Frames { after, .. } => after.to_lowercase().ends_with(".exr"),
            _ => false,
        }
    }

    /// Whether a clear sky can be written.
    pub fn has_alpha(&self) -> bool {
        matches!(self, Self::Png(_) | Self::Apng(_) | Self::Exr(_) | Self::Frames { .. })
    }
}

/// A film on its way to one file.
pub enum Film {
    Apng { writer: Box<png::Writer<File>>, alpha: bool, file: AtomicFile },
    Gif { encoder: Box<gif::Encoder<BufWriter<File>>>, delay: u16, file: AtomicFile },
    Mp4 { ffmpeg: Child, file: AtomicFile },
}

impl Film {
    /// Begins a film of `frames` frames; `None` where the output is not one file of many frames.
    pub fn begin(
        output: &Output,
        (width, height): (u32, u32),
        frames: u32,
        fps: f32,
        alpha: bool,
    ) -> anyhow::Result<Option<Self>> {
        Ok(Some(match output {
            Output::Png(_) | Output::Exr(_) | Output::Frames { .. } => return Ok(None),
            Output::Apng(path) => {
                let file = AtomicFile::create(path)?;
                let mut encoder = png::Encoder::new(file.reopen()?, width, height);
                encoder.set_color(if alpha { png::ColorType::Rgba } else { png::ColorType::Rgb });
                encoder.set_animated(frames, 0)?;
                let (numerator, denominator) = frame_delay(fps);
                encoder.set_frame_delay(numerator, denominator)?;
                let writer = Box::new(encoder.write_header()?);
                Self::Apng { writer, alpha, file }
            }
            Output::Gif(path) => {
                let (Ok(w), Ok(h)) = (u16::try_from(width), u16::try_from(height)) else {
                    bail!("a GIF is at most 65535 pixels wide and high, not {width}x{height}");
                };
                let file = AtomicFile::create(path)?;
                let target = BufWriter::new(file.reopen()?);
                let mut encoder = gif::Encoder::new(target, w, h, &[])?;
                encoder.set_repeat(gif::Repeat::Infinite)?;
                // GIF counts in hundredths; most players take less than two for ten.
                let delay = (100.0 / fps).round().max(2.0) as u16;
                Self::Gif { encoder: Box::new(encoder), delay, file }
            }
            Output::Mp4(path) => {
                if width % 2 == 1 || height % 2 == 1 {
                    bail!("an MP4 needs even width and height, not {width}x{height}");
                }
                let file = AtomicFile::create(path)?;
                let ffmpeg = Command::new("ffmpeg")
                    .args(["-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgba"])
                    .args(["-s", &format!("{width}x{height}"), "-r", &fps.to_string()])
                    // Players take HD for BT.709: convert to it, and say so.
                    .args(["-i", "-", "-vf", "scale=out_color_matrix=bt709:out_range=tv"])
                    .args(["-c:v", "libx264", "-pix_fmt", "yuv420p", "-color_range", "tv"])
                    .args(["-colorspace", "bt709", "-color_primaries", "bt709"])
                    .args(["-color_trc", "bt709"])
                    .args(["-crf", "17", "-movflags", "+faststart", "-f", "mp4"])
                    .arg(file.temporary_path())
                    .stdin(Stdio::piped())
                    .stdout(Stdio::null())
                    .spawn()
                    .with_context(|| {
                        format!(
                            "{} needs the program ffmpeg, which is not on the path; install it, \
                             or write .apng, .gif or frames_%05d.png",
                            path.display()
                        )
                    })?;
                Self::Mp4 { ffmpeg, file }
            }
        }))
    }

    /// Adds a frame.
    pub fn add(&mut self, image: &RgbaImage<'_>) -> anyhow::Result<()> {
        match self {
            Self::Apng { writer, alpha: true, .. } => writer.write_image_data(image.rgba)?,
            Self::Apng { writer, .. } => writer.write_image_data(&image.rgb())?,
            Self::Gif { encoder, delay, .. } => {
                let mut rgba = image.rgba.to_vec();
                let (width, height) = (image.width as u16, image.height as u16);
                let mut frame = gif::Frame::from_rgba_speed(width, height, &mut rgba, 10);
                frame.delay = *delay;
                encoder.write_frame(&frame)?;
            }
            Self::Mp4 { ffmpeg, file } => {
                let stdin = ffmpeg.stdin.as_mut().context("ffmpeg takes no input")?;
                stdin.write_all(image.rgba).map_err(|e| {
                    anyhow::anyhow!("ffmpeg stopped writing {}: {e}", file.path().display())
                })?;
            }
        }
        Ok(())
    }

    /// Ends the film and puts it in its place.
    pub fn finish(self) -> anyhow::Result<()> {
        match self {
            Self::Apng { writer, file, .. } => {
                writer.finish()?;
                file.commit()
            }
            Self::Gif { encoder, file, .. } => {
                encoder.into_inner()?.flush()?;
                file.commit()
            }
            Self::Mp4 { mut ffmpeg, file } => {
                drop(ffmpeg.stdin.take());
                let status = ffmpeg.wait().context("ffmpeg")?;
                if !status.success() {
                    bail!("ffmpeg could not write {} ({status})", file.path().display());
                }
                file.commit()
            }
        }
    }
}

/// Seconds per frame as a fraction of 16-bit numbers.
fn frame_delay(fps: f32) -> (u16, u16) {
    if fps.fract() == 0.0 && fps <= 60_000.0 {
        (1, fps as u16)
    } else {
        ((1000.0 / fps).round().clamp(1.0, 60_000.0) as u16, 1000)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_are_told_apart_by_their_names() {
        assert_eq!(Output::parse("a/b.PNG").unwrap(), Output::Png("a/b.PNG".into()));
        assert_eq!(Output::parse("x.apng").unwrap(), Output::Apng("x.apng".into()));
        let frames = Output::parse("f_%05d.png").unwrap();
        assert_eq!(frames.frame_path(42), Some("f_00042.png".into()));
        assert_eq!(Output::parse("f%d.png").unwrap().frame_path(7), Some("f7.png".into()));
        for (text, message) in [
            ("a.bmp", "must end in"),
            ("f_%05d.gif", "written as .png or .exr"),
            ("f_%0x.png", "%d or %05d"),
            ("f_%d_%d.png", "one number"),
            ("f_%99d.png", "%99d"),
            ("/", "folder"),
        ] {
            let error = Output::parse(text).unwrap_err().to_string();
            assert!(error.contains(message), "{text}: {error}");
        }
    }

    #[test]
    fn frame_delays_are_exact_for_whole_rates() {
        assert_eq!([30.0, 12.5, 0.5].map(frame_delay), [(1, 30), (80, 1000), (2000, 1000)]);
    }
}
