//! `windfall view`: walk through a forest, in a window.

use windfall_host::image::parse_size;
use windfall_viewer::native;

/// Arguments of `windfall view`.
#[derive(clap::Args)]
pub struct Args {
    /// A built-in scene, a scene file (.ron) or a link of the viewer's; trees (.glb, .gltf), fall paths (.glb, .csv,
    /// .json, .path) and a picture of the sky (.hdr, .exr) to see in it
    #[arg(value_name = "SCENE|TREE|PATH|SKY")]
    files: Vec<String>,
    /// Size of the window
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "1280x800")]
    size: (u32, u32),
    /// Close the window by itself after so many pictures
    #[arg(long, value_name = "N")]
    frames: Option<u64>,
    /// Print how long it takes until the first picture and between pictures
    #[arg(long)]
    timings: bool,
    /// Start without the panel
    #[arg(long)]
    no_panel: bool,
    /// Start with time standing still
    #[arg(long)]
    paused: bool,
    /// Time that a picture is to take at most while things move, milliseconds; 0 gives up nothing for it. Without it, the
    /// scene's budget, or 40
    #[arg(long, value_name = "MS")]
    budget: Option<f32>,
}

/// Runs `windfall view`.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let mut start = native::start(&args.files)?;
    start.frames = args.frames;
    start.timings = args.timings;
    start.panel = !args.no_panel;
    start.playing &= !args.paused;
    start.budget = args.budget;
    start.program = std::env::current_exe().ok();
    native::run(start, (args.size.0 as f32, args.size.1 as f32))
}
