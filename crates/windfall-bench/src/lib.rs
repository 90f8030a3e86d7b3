//! Measurements of Windfall on the adapter at hand: loading, falling leaves, image effects, simplification.
//!
//! The configurations of a comparison run in one process and take turns frame by frame, so that
//! changes of clock speed and temperature affect all of them alike. Results are medians and
//! quartiles on stdout, and the same numbers as JSON where asked for.
//!
//! `windfall bench` on the command line parses [`Args`] and calls [`run`].
#![deny(missing_docs)]

mod baseline;
mod falling;
mod harness;
mod image;
mod load;
mod output;
mod papers;
mod picture;
mod plot;
mod realtime;
mod scenery;
mod simplification;
pub mod statistics;

pub use plot::register_font as register_plot_font;

/// Arguments of `windfall bench`.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    benchmark: Benchmark,
}

#[derive(clap::Subcommand)]
enum Benchmark {
    /// Falling leaves: strategies over a walkthrough, a million leaves, cost against count
    Falling(falling::Args),
    /// What got slower from one report of `bench papers` to another
    Compare(papers::compare::Args),
    /// The tables and figures of the papers, beside what they print
    Papers(papers::Args),
    /// What it takes until trees and scenes are drawn: time by stage, memory, first frames
    Load(load::Args),
    /// Presets of quality and single effects, over the named scenes
    Picture(picture::Args),
    /// Whole frames of a walk, beside the least that a frame can take
    Realtime(realtime::Args),
    /// Simplified forests: time over h, culling
    Simplification(simplification::Args),
}

/// Runs `windfall bench`: prints the measurements, and writes the files that `args` name.
///
/// # Errors
///
/// There is no adapter ([`windfall_host::device::NoAdapter`]) or it fails, arguments are out of
/// range, or a file cannot be read or written.
pub fn run(args: &Args) -> anyhow::Result<()> {
    match &args.benchmark {
        Benchmark::Falling(args) => falling::run(args),
        Benchmark::Compare(args) => papers::compare::run(args),
        Benchmark::Papers(args) => papers::run(args),
        Benchmark::Load(args) => load::run(args),
        Benchmark::Picture(args) => picture::run(args),
        Benchmark::Realtime(args) => realtime::run(args),
        Benchmark::Simplification(args) => simplification::run(args),
    }
}
