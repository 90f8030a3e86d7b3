//! The program `windfall`: renders forests, inspects trees and fall paths.
//!
//! Data goes to stdout, everything else to stderr. Exit codes: 0 done, 1 failed, 2 wrong usage,
//! 3 no graphics adapter.

mod bake;
mod cache;
mod export;
mod falling;
mod farm;
mod framing;
mod linear;
mod loading;
mod output;
mod path;
mod planting;
mod reading;
mod render;
mod serve;
mod simplify;
mod tree;
mod verify;
#[cfg(feature = "view")]
mod view;

use anyhow::Context;
use clap::{CommandFactory, Parser, Subcommand};
use std::io::Write;
use std::process::ExitCode;
use tracing_subscriber::EnvFilter;
use windfall_host::device::NoAdapter;

/// Keeps memory that large arrays have given back for the next ones: fresh pages from the system take as long as the loading of
/// a tree itself.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

const EXAMPLES: &str = "\
Examples:
  windfall render --out autumn.png                     the default scene
  windfall render hillside --size 1920x1080 --out hill.png
  windfall render --tree my_oak.glb --height 18 --trees 60 --out oaks.png
  windfall render my.ron --frames 0-149 --fps 30 --out film.mp4
  windfall render lone-oak --json --out oak.png | jq .frames[0].leaves_total
  windfall tree inspect my_oak.glb
  windfall bake my_oak.glb --out my_oak.baked.glb      a tree that loads at once
  windfall simplify my_oak.glb --lambda 0.1 --out far_oak.glb
  windfall export my.ron --frames 0-99 --only falling --out leaves.usda
  windfall path simulate --species maple --seconds 8 --out maple.path

Environment: WGPU_BACKEND (vulkan, metal, dx12) and WGPU_ADAPTER_NAME choose the GPU,
RUST_LOG the log (info, debug), WINDFALL_CACHE_DIR the folder of the cache, NO_COLOR switches colours off.";

#[derive(Parser)]
#[command(
    name = "windfall",
    version,
    about = "Forests that shed their leaves, in real time, on any GPU",
    before_help = EXAMPLES,
    arg_required_else_help = true
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Render a scene to a picture or a film
    Render(Box<render::Args>),
    /// Walk through a forest, in a window
    #[cfg(feature = "view")]
    View(view::Args),
    /// Serve the viewer's page to browsers on this machine
    Serve(serve::Args),
    /// Write leaves and trees of a scene for other programs: USD, glTF, tables
    Export(Box<export::Args>),
    /// Write jobs for render farms, and join their frames
    Farm(farm::Args),
    /// Look into a tree file, or write a built-in species as one
    Tree(tree::Args),
    /// Prepare a tree once, and write it so that it loads at once
    Bake(bake::Args),
    /// Show or clear what the program keeps prepared
    Cache(cache::Args),
    /// Write a tree with a share of its leaves, for other programs
    Simplify(simplify::Args),
    /// Simulate, import, inspect and measure fall paths
    Path(path::Args),
    /// Hold flight, crowns, litter and leaf colours against published observations
    Verify(verify::Args),
    /// Measure what falling leaves cost on this machine's GPU
    Bench(Box<windfall_bench::Args>),
    /// List the built-in scenes
    Scenes {
        /// Print this scene as a file to start from
        #[arg(value_name = "NAME")]
        name: Option<String>,
    },
    /// Print a completion script for a shell
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
}

fn main() -> ExitCode {
    let color = std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty());
    let filter = EnvFilter::try_from_default_env()
        .unwrap_or_else(|_| EnvFilter::new("warn,wgpu_hal=error,wgpu_core=error,winit=error"));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_ansi(color && std::io::IsTerminal::is_terminal(&std::io::stderr()))
        .init();
    let result = match Cli::parse().command {
        Command::Render(args) => render::run(&args),
        #[cfg(feature = "view")]
        Command::View(args) => view::run(&args),
        Command::Serve(args) => serve::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Farm(args) => farm::run(&args),
        Command::Tree(args) => tree::run(&args),
        Command::Bake(args) => bake::run(&args),
        Command::Cache(args) => cache::run(&args),
        Command::Simplify(args) => simplify::run(&args),
        Command::Path(args) => path::run(args),
        Command::Verify(args) => verify::run(&args),
        Command::Bench(args) => windfall_bench::run(&args),
        Command::Scenes { name } => scenes(name.as_deref()),
        Command::Completions { shell } => completions(shell),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // A closed pipe (`windfall … | head`) is the reader's choice, not a failure.
            let root = error.root_cause();
            let kind = root
                .downcast_ref::<std::io::Error>()
                .map(std::io::Error::kind)
                .or_else(|| root.downcast_ref::<serde_json::Error>()?.io_error_kind());
            if kind == Some(std::io::ErrorKind::BrokenPipe) {
                return ExitCode::SUCCESS;
            }
            eprintln!("error: {error:#}");
            ExitCode::from(if error.is::<NoAdapter>() { 3 } else { 1 })
        }
    }
}

fn completions(shell: clap_complete::Shell) -> anyhow::Result<()> {
    // Into memory first: the generator panics where its reader stops listening.
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "windfall", &mut script);
    Ok(std::io::stdout().write_all(&script)?)
}

fn scenes(name: Option<&str>) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    if let Some(name) = name {
        let scene = windfall_scenes::named(name)
            .with_context(|| format!("no scene {name:?}; `windfall scenes` lists them"))?;
        writeln!(out, "{}", scene.to_ron())?;
        return Ok(());
    }
    for name in windfall_scenes::NAMES {
        let scene = windfall_scenes::named(name).context("a built-in scene")?;
        writeln!(out, "{name:<14} {}", scene.about)?;
    }
    Ok(())
}
