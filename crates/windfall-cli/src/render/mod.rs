//! `windfall render`: a scene to a picture or a film.

mod pictures;

use crate::falling::{FallArgs, read_paths};
use crate::framing;
use crate::linear::{Linear, LinearOptions};
use crate::loading;
use crate::output::{Film, Output};
use crate::planting::{self, PlantArgs, ThrowArgs};
use crate::reading::{Switch, parse_switch};
use anyhow::{Context, bail};
use indicatif::{ProgressBar, ProgressStyle};
use pictures::{FrameReport, Pictures};
use serde::Serialize;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;
use std::time::Instant;
use windfall_core::Note;
use windfall_core::simplify::{PruneOrder, Reduction};
use windfall_gpu::{DebugView, Options, Renderer, View};
use windfall_host::device::{Gpu, run_jobs};
use windfall_host::image::{RgbaImage, parse_size};
use windfall_scenes::{
    CameraKey, Culling, Elimination, LandingSearch, Model, QualityPreset, Scene, Strategy,
    read_detail,
};

/// Arguments of `windfall render`.
#[derive(clap::Args)]
#[expect(clippy::struct_excessive_bools, reason = "switches of a command line")]
pub struct Args {
    /// A scene file (.ron), or the name of a built-in scene
    #[arg(value_name = "SCENE", default_value = windfall_scenes::NAMES[0])]
    scene: String,
    #[command(flatten)]
    plant: PlantArgs,
    #[command(flatten)]
    fall: FallArgs,
    /// Camera in place of the scene's: eye and target as X,HEIGHT,Z in metres, heights above the ground there, and
    /// vertical field of view in degrees
    #[arg(long, num_args = 3, value_names = ["EYE", "TARGET", "FOV"], allow_hyphen_values = true)]
    camera: Vec<String>,
    /// Size of the picture
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<(u32, u32)>,
    /// Moment of a still, seconds
    #[arg(long, value_name = "S", conflicts_with = "frames")]
    time: Option<f64>,
    /// Frames of a film, first and last
    #[arg(long, value_name = "A-B", value_parser = parse_frames)]
    frames: Option<(u32, u32)>,
    /// Frames per second
    #[arg(long, value_name = "N")]
    fps: Option<f32>,
    /// Where the poses of falling leaves are computed: vertex, fragment, vertex-buffer, cpu or compute
    #[arg(long, value_name = "NAME")]
    strategy: Option<Strategy>,
    /// Which leaves a simplified tree keeps: the first in this order: random, importance or
    /// blue-noise
    #[arg(long, value_name = "NAME")]
    prune_order: Option<PruneOrder>,
    /// When landed leaves become static geometry: off, progressive or scheduled (not for compute)
    #[arg(long, value_name = "NAME")]
    elimination: Option<Elimination>,
    /// Leaves that --elimination progressive tests in a frame
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    elimination_per_frame: Option<u32>,
    /// Who looks for the place where a leaf lands: ahead (the CPU, once) or in-shader (in every frame; not for
    /// compute and cpu)
    #[arg(long, value_name = "NAME")]
    landing_search: Option<LandingSearch>,
    /// Skip leaves in the air that are not seen, for some frames: on or off (not for compute)
    #[arg(long, value_name = "on|off", value_parser = parse_switch)]
    leaf_occlusion: Option<Switch>,
    /// What the picture may cost: low, medium or high
    #[arg(long, value_name = "NAME")]
    quality: Option<QualityPreset>,
    /// Hold this time per frame, milliseconds: shadows are drawn in turns, then pixels, leaves, relief and grass are
    /// given up, as much as this machine needs
    #[arg(long, value_name = "MS")]
    budget: Option<f32>,
    /// Whether leaves inside of crowns are darker under the sky: on or off; default: as the quality has it
    #[arg(long, value_name = "on|off", value_parser = parse_switch)]
    ambient_occlusion: Option<Switch>,
    /// Equirectangular picture of the sky, .hdr or .exr, as background and ambient light
    #[arg(long, value_name = "FILE")]
    sky: Option<String>,
    #[command(flatten)]
    throw: ThrowArgs,
    /// How trees are simplified, every option of the paper as in a scene's detail: 'fade: Opacity, smooth: true'. What
    /// it leaves out is as by default
    #[arg(long, value_name = "OPTIONS")]
    detail: Option<String>,
    /// Share of its size at which a tree is drawn with half of its leaves, 0 (all) to 0.99. Leaves grow to twice
    /// their length or four pixels at most (growth_factor, growth_pixels of --detail), and no fewer are drawn than that
    /// allows: above 0.7 a larger share changes little
    #[arg(long, value_name = "SHARE")]
    h: Option<f32>,
    /// Distance up to which trees are drawn in full, metres
    #[arg(long, value_name = "M", conflicts_with = "b0")]
    d0: Option<f32>,
    /// Pixels of its bounding sphere above which a tree is drawn in full, instead of --d0
    #[arg(long, value_name = "PIXELS")]
    b0: Option<f32>,
    /// Which trees are left out: off, clip-space, sphere or occlusion
    #[arg(long, value_name = "NAME")]
    culling: Option<Culling>,
    /// What colours mean: picture, or laps (of the leaves' paths; landed ones are pink),
    /// or detail (of the trees, red to blue), or occlusion (of leaves in the air: drawn green, tested
    /// blue, skipped red), or parts (leaves green, wood brown), normals, leaves, coverage, radiance, ids
    #[arg(long, value_name = "NAME", default_value_t)]
    view: DebugView,
    /// Print one JSON object of what was drawn and how long it took
    #[arg(long)]
    json: bool,
    /// Skip frames whose file is there (with a pattern such as frames_%05d.png)
    #[arg(long)]
    resume: bool,
    /// Also write which leaf is seen: channels id.leaf and id.tree of an .exr
    #[arg(long)]
    ids: bool,
    /// Leave the sky clear: straight alpha in .png, .apng and .exr
    #[arg(long)]
    alpha: bool,
    /// Print progress as lines that render farms read: `openjd_progress: 12.5`, percent
    #[arg(long)]
    progress_lines: bool,
    /// Where to: FILE.png, FILE.exr (linear, with depth), FILE.apng, FILE.gif, FILE.mp4, frames_%05d.png or .exr
    #[arg(long, value_name = "FILE")]
    out: String,
}

pub(crate) fn parse_frames(text: &str) -> Result<(u32, u32), String> {
    let ends = text
        .split_once('-')
        .or(Some((text, text)))
        .and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    match ends {
        Some((first, last)) if first <= last => Ok((first, last)),
        _ => Err("frames are FIRST-LAST, such as 0-149, or one number".to_owned()),
    }
}

/// What `--json` prints.
#[derive(Serialize)]
struct Report {
    adapter: String,
    size: (u32, u32),
    /// What there is to say about the files that were read.
    notes: Vec<Note>,
    startup_ms: Startup,
    /// Most memory that the program had, where the system tells it.
    peak_bytes: Option<u64>,
    frames: Vec<FrameReport>,
}

/// Milliseconds up to the first frame.
#[derive(Serialize, Default)]
struct Startup {
    /// Opening the adapter.
    device: f64,
    /// Shader modules and pipelines, while the trees load.
    pipelines: f64,
    /// Loading the trees, on threads of their own.
    trees: f64,
    /// Planting the forest, uploading it, and pipelines of a published strategy.
    upload: f64,
    /// Drawing the first frame and reading it back.
    frame: f64,
    /// From the program's start to the pixels of the first frame.
    total: f64,
}

/// Runs `windfall render`.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let start = Instant::now();
    let since = |moment: Instant| moment.elapsed().as_secs_f64() * 1e3;
    let mut startup = Startup::default();
    let output = Output::parse(&args.out)?;
    let (scene, folder, name) = read_scene(&args.scene)?;
    let mut scene = args.apply(scene, &name)?;
    let moments = args.moments(&scene, &output)?;
    if args.resume && !matches!(output, Output::Frames { .. }) {
        bail!("--resume needs a pattern such as --out frames_%05d.png");
    }
    if args.alpha && !output.has_alpha() {
        bail!("--alpha: --out {} has no alpha; .png, .apng and .exr have", args.out);
    }
    if args.ids && !output.is_exr() {
        bail!("--ids: --out {} has no place for them; .exr has", args.out);
    }
    if scene.budget.is_some() && output.is_exr() {
        eprintln!("note: an .exr is always drawn at full resolution, whatever the budget");
    }
    if args.ids && scene.strategy != Strategy::Compute {
        bail!("--ids: the strategy {} does not tell leaves apart; compute does", scene.strategy);
    }
    // Trees load while the pipelines compile.
    let sources = loading::sources(&scene, &folder);
    let cache = args.plant.cache.cache();
    let loading = std::thread::spawn(move || {
        let loaded = loading::load(&sources, cache.as_ref())?;
        Ok((loaded, since(start)))
    });
    let opening = Instant::now();
    let mut gpu = Gpu::open()?;
    startup.device = since(opening);
    let largest = gpu.device.limits().max_texture_dimension_2d;
    if scene.size.0.max(scene.size.1) > largest {
        bail!(
            "size: {}x{} is beyond what {} can draw: {largest} pixels a side",
            scene.size.0,
            scene.size.1,
            gpu.adapter
        );
    }
    if scene.leaf_occlusion && scene.strategy == Strategy::Compute {
        eprintln!(
            "note: leaf_occlusion is for the strategies vertex, fragment, vertex-buffer and cpu; compute \
             draws every leaf in view"
        );
    } else if scene.leaf_occlusion && !gpu.fragment_stores {
        bail!(
            "leaf_occlusion: {} lets no fragment write to buffers, which counts what is seen; \
             --leaf-occlusion off draws all leaves",
            gpu.adapter
        );
    }
    let options = Options::picture(pictures::FORMAT);
    let new_renderer = || Renderer::new_with(&gpu.device, &options, &run_jobs);
    let compiling = Instant::now();
    let (renderer, (loaded, trees_ms)) = if loading.is_finished() {
        // What cannot be read is said at once.
        let loaded = join(loading)?;
        (new_renderer()?, loaded)
    } else {
        let renderer = new_renderer()?;
        startup.pipelines = since(compiling);
        (renderer, join(loading)?)
    };
    if startup.pipelines == 0.0 {
        startup.pipelines = since(compiling);
    }
    startup.trees = trees_ms;
    let mut notes = Vec::new();
    let trees = planting::trees(&scene, loaded, &mut notes);
    let framed = !args.plant.tree.is_empty() && args.camera.is_empty();
    if framed {
        let models = scene.models();
        let read =
            models.iter().zip(&trees).filter(|(model, _)| matches!(model, Model::File { .. }));
        let heights: Vec<f32> = read.map(|(_, tree)| tree.height()).collect();
        framing::fit_to_trees(&mut scene, &heights);
    }
    let uploading = Instant::now();
    let mut stage = scene.place(trees);
    if framed && stage.forest.instances.len() == 1 {
        framing::look_at_tree(&mut scene, &stage);
    }
    stage.check(&name)?;
    notes.extend(read_paths(&scene, &folder, &mut stage)?);
    args.throw.apply(&mut stage)?;
    let sky = scene
        .sky
        .picture
        .as_ref()
        .map(|f| windfall_host::sky::read(&folder.join(f)))
        .transpose()?;
    let kept = LinearOptions { clear: args.alpha, ids: args.ids };
    let linear = output.is_exr().then(|| Linear::new(&gpu.device, scene.size, kept));
    let mut pictures = Pictures::new(&gpu, renderer, &stage, scene.size, (sky.as_ref(), linear))?;
    pictures.hold(scene.budget);
    gpu.check()?;
    startup.upload = since(uploading);
    let mut film = Film::begin(&output, scene.size, moments.len() as u32, scene.fps, args.alpha)?;
    let progress = progress_bar(moments.len() as u64);
    let mut reports = Vec::new();
    for (done, &(frame, time)) in moments.iter().enumerate() {
        if args.progress_lines {
            eprintln!("openjd_status: frame {frame}");
            eprintln!("openjd_progress: {:.1}", 100.0 * done as f32 / moments.len() as f32);
        }
        let path = output.frame_path(frame);
        if args.resume && path.as_ref().is_some_and(|p| p.exists()) {
            progress.inc(1);
            continue;
        }
        let view = View {
            show: args.view,
            transparent_sky: args.alpha,
            ..scene.view(time, &stage.forest.terrain)
        };
        if reports.is_empty() && scene.budget.is_some() {
            pictures.settle(&mut gpu, &view, time)?;
        }
        let drawing = Instant::now();
        let (rgba, linear, report) = pictures.draw(&mut gpu, view, (frame, time))?;
        if reports.is_empty() {
            (startup.frame, startup.total) = (since(drawing), since(start));
        }
        let image = RgbaImage { width: scene.size.0, height: scene.size.1, rgba: &rgba };
        let file = match &output {
            Output::Png(path) | Output::Exr(path) => Some(path.clone()),
            _ => path,
        };
        match (&mut film, linear, file) {
            (Some(film), ..) => film.add(&image)?,
            (_, Some(linear), Some(path)) => linear.save_exr(&path)?,
            (_, None, Some(path)) if args.alpha => image.save_png_with_alpha(&path)?,
            (_, None, Some(path)) => image.save_png(&path)?,
            _ => {}
        }
        reports.push(report);
        progress.inc(1);
    }
    if let Some(film) = film {
        film.finish()?;
    }
    if args.progress_lines {
        eprintln!("openjd_progress: 100.0");
    }
    progress.finish_and_clear();
    if args.json {
        let report = Report {
            adapter: gpu.adapter,
            size: scene.size,
            notes,
            startup_ms: startup,
            peak_bytes: windfall_host::memory::peak(),
            frames: reports,
        };
        writeln!(std::io::stdout(), "{}", serde_json::to_string_pretty(&report)?)?;
    }
    Ok(())
}

/// Waits for the trees.
fn join<T>(loading: JoinHandle<anyhow::Result<T>>) -> anyhow::Result<T> {
    loading.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

/// A built-in scene by name, or a file: with its folder and its name in errors.
pub(crate) fn read_scene(name: &str) -> anyhow::Result<(Scene, PathBuf, String)> {
    if let Some(scene) = windfall_scenes::named(name) {
        return Ok((scene, PathBuf::new(), name.to_owned()));
    }
    let path = Path::new(name);
    if path.is_dir() {
        bail!("{name}: is a folder, not a scene");
    }
    if !path.exists() && path.extension().is_none() {
        bail!("{name}: no built-in scene and no file of this name; `windfall scenes` lists scenes");
    }
    let text = std::fs::read_to_string(path).with_context(|| format!("{name}: cannot be read"))?;
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    Ok((Scene::from_ron(&text, name)?, folder, name.to_owned()))
}

impl Args {
    /// The scene with what the command line says instead.
    fn apply(&self, mut scene: Scene, file: &str) -> anyhow::Result<Scene> {
        self.plant.apply(&mut scene)?;
        scene.size = self.size.unwrap_or(scene.size);
        scene.time = self.time.unwrap_or(scene.time);
        scene.fps = self.fps.unwrap_or(scene.fps);
        scene.strategy = self.strategy.unwrap_or(scene.strategy);
        scene.quality = self.quality.unwrap_or(scene.quality);
        scene.budget = self.budget.or(scene.budget);
        if let Some(sky) = &self.sky {
            // Relative to where the user stands, whatever folder the scene is in.
            let path = std::path::absolute(sky).with_context(|| format!("--sky {sky}"))?;
            let path = path.to_str().with_context(|| format!("--sky {sky}: not UTF-8"))?;
            scene.sky.picture = Some(path.to_owned());
        }
        scene.prune_order = self.prune_order.unwrap_or(scene.prune_order);
        scene.elimination = self.elimination.unwrap_or(scene.elimination);
        scene.elimination_per_frame =
            self.elimination_per_frame.unwrap_or(scene.elimination_per_frame);
        scene.landing_search = self.landing_search.unwrap_or(scene.landing_search);
        scene.ambient_occlusion = self.ambient_occlusion.or(scene.ambient_occlusion);
        scene.leaf_occlusion = self.leaf_occlusion.unwrap_or(scene.leaf_occlusion);
        let occlusion = scene.leaf_occlusion && scene.strategy != Strategy::Compute;
        if self.view == DebugView::Occlusion && !occlusion {
            bail!(
                "--view occlusion: shows leaf occlusion; add --leaf-occlusion on, and --strategy vertex, \
                 fragment or vertex-buffer"
            );
        }
        if let [eye, target, fov] = self.camera.as_slice() {
            scene.camera = vec![camera_key(eye, target, fov)?];
        }
        scene.culling = self.culling.unwrap_or(scene.culling);
        if let Some(detail) = &self.detail {
            scene.detail = read_detail(detail, "--detail")?;
        }
        scene.detail.h = self.h.unwrap_or(scene.detail.h);
        if let Some(d0) = self.d0 {
            scene.detail.reduction = Reduction::Distance { d0 };
        }
        if let Some(b0) = self.b0 {
            scene.detail.reduction = Reduction::ProjectedArea { b0 };
        }
        self.fall.apply(&mut scene)?;
        scene.check(file)?;
        Ok(scene)
    }

    /// The frames to draw and their moments.
    fn moments(&self, scene: &Scene, output: &Output) -> anyhow::Result<Vec<(u32, f64)>> {
        let film = !matches!(output, Output::Png(_) | Output::Exr(_));
        Ok(match self.frames {
            Some((first, last)) if !film && first != last => {
                bail!(
                    "--frames {first}-{last} are {} pictures and --out {} is one; \
                     use a pattern such as frames_%05d.png",
                    u64::from(last - first) + 1,
                    self.out
                )
            }
            Some((first, last)) => (first..=last).map(|f| (f, scene.frame_time(f))).collect(),
            None if film => {
                (scene.frames.0..=scene.frames.1).map(|f| (f, scene.frame_time(f))).collect()
            }
            None => vec![((scene.time * f64::from(scene.fps)).max(0.0) as u32, scene.time)],
        })
    }
}

/// A camera that stands still.
fn camera_key(eye: &str, target: &str, fov: &str) -> anyhow::Result<CameraKey> {
    let place = |text: &str| -> Option<(f64, f64, f64)> {
        let mut numbers = text.split(',').map(|part| part.trim().parse().ok());
        let place = (numbers.next()??, numbers.next()??, numbers.next()??);
        numbers.next().is_none().then_some(place)
    };
    let point = |text: &str| {
        place(text)
            .with_context(|| format!("--camera {text}: a place is X,HEIGHT,Z, such as 0,1.7,20"))
    };
    let degrees = fov.parse();
    let fov =
        degrees.ok().with_context(|| format!("--camera {fov}: the last is an angle, degrees"))?;
    Ok(CameraKey { time: 0.0, eye: point(eye)?, target: point(target)?, fov })
}

pub(crate) fn progress_bar(frames: u64) -> ProgressBar {
    if frames < 2 || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(frames);
    if let Ok(style) = ProgressStyle::with_template("{bar:32} {pos}/{len} frames, {eta} left") {
        bar.set_style(style);
    }
    bar
}
