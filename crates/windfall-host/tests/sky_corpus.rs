//! Replays the corpus of the fuzz target `sky`: a picture of the sky or an error that names the file, never a panic.
#![expect(clippy::unwrap_used, reason = "this is test code")]

use image::{DynamicImage, ImageFormat, Rgb32FImage};
use std::io::Cursor;
use std::path::{Path, PathBuf};
use windfall_host::sky::parse;

fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus/sky")
}

fn file(width: u32, height: u32, format: ImageFormat) -> Vec<u8> {
    let sky = Rgb32FImage::from_fn(width, height, |x, y| image::Rgb([x as f32, y as f32, 0.5]));
    let mut bytes = Cursor::new(Vec::new());
    DynamicImage::from(sky).write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// Whole files, and what damages them.
fn seeds() -> Vec<(String, Vec<u8>)> {
    let mut seeds = Vec::new();
    for (ending, format) in [("hdr", ImageFormat::Hdr), ("exr", ImageFormat::OpenExr)] {
        let whole = file(8, 4, format);
        let mut flipped = whole.clone();
        flipped[whole.len() / 2] ^= 0x7f;
        seeds.push((format!("short.{ending}"), whole[..whole.len() - 9].to_vec()));
        seeds.push((format!("head.{ending}"), whole[..12].to_vec()));
        seeds.push((format!("flipped.{ending}"), flipped));
        seeds.push((format!("square.{ending}"), file(4, 4, format)));
        seeds.push((format!("whole.{ending}"), whole));
    }
    seeds.push((
        "huge.hdr".into(),
        b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2000000 +X 4000000\n".to_vec(),
    ));
    seeds
}

#[test]
fn the_corpus_is_read_or_refused() {
    let mut read = Vec::new();
    for entry in std::fs::read_dir(corpus()).unwrap() {
        let path = entry.unwrap().path();
        let bytes = std::fs::read(&path).unwrap();
        let own = path.file_name().unwrap().to_str().unwrap();
        for name in [own, "other.hdr", "other.exr"] {
            match parse(&bytes, name) {
                Ok(_) if name == own => read.push(own.to_owned()),
                Ok(_) => {}
                Err(error) => assert!(format!("{error:#}").contains(name), "{own}: {error:#}"),
            }
        }
    }
    for whole in ["whole.hdr", "whole.exr"] {
        assert!(read.iter().any(|name| name == whole), "{whole} is a sky: {read:?}");
    }
    for damaged in ["short.hdr", "short.exr", "head.hdr", "head.exr", "huge.hdr"] {
        assert!(read.iter().all(|name| name != damaged), "{damaged} is no sky: {read:?}");
    }
    assert!(parse(&[], "sky.png").unwrap_err().to_string().contains("sky.png"));
}

/// Writes the seeds anew: `cargo test -p windfall-host --test sky_corpus -- --ignored`.
#[test]
#[ignore = "writes files of the repository"]
fn write_the_seeds() {
    std::fs::create_dir_all(corpus()).unwrap();
    for (name, bytes) in seeds() {
        std::fs::write(corpus().join(name), bytes).unwrap();
    }
}
