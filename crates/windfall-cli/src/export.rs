//! `windfall export`: leaves and trees of a scene for other programs.

use crate::falling::read_paths;
use crate::loading;
use crate::planting::{self, PlantArgs, ThrowArgs};
use crate::render::{parse_frames, progress_bar, read_scene};
use anyhow::{Context, bail};
use glam::Vec3;
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;
use windfall_core::Note;
use windfall_export::vat::paths::PathTextures;
use windfall_export::vat::{Engine, Files, Texels, Vat, Which, path_shader, shaders};
use windfall_export::{Filter, Moments, Parts, Selection, Source, Thrown, gltf, table, usd};
use windfall_host::file::{AtomicFile, write_atomic};
use windfall_scenes::Stage;

/// Arguments of `windfall export`.
#[derive(clap::Args)]
pub struct Args {
    /// A scene file (.ron), or the name of a built-in scene
    #[arg(value_name = "SCENE", default_value = windfall_scenes::NAMES[0])]
    scene: String,
    /// Frames, first and last, or one number
    #[arg(long, value_name = "A-B", value_parser = parse_frames)]
    frames: Option<(u32, u32)>,
    /// Frames per second
    #[arg(long, value_name = "N")]
    fps: Option<f32>,
    /// What is exported: any of hanging, falling, landed, trees and ground, with commas
    #[arg(long, value_name = "PARTS")]
    only: Option<Parts>,
    /// Leaves that are in this box in one of the frames, and trees that reach into it: its low and high corner, metres
    #[arg(
        long,
        value_name = "X,Y,Z,X,Y,Z",
        value_parser = parse_box,
        allow_hyphen_values = true
    )]
    within: Option<(Vec3, Vec3)>,
    /// At most so many leaves: those that come nearest to the camera
    #[arg(long, value_name = "N")]
    most: Option<usize>,
    #[command(flatten)]
    plant: PlantArgs,
    #[command(flatten)]
    throw: ThrowArgs,
    /// Axes and unit of vertex animation textures: godot, unity or unreal
    #[arg(long, value_name = "NAME", default_value = "godot")]
    engine: Engine,
    /// Texels of vertex animation textures: exr (floats) or png (16 bits)
    #[arg(long, value_name = "KIND", default_value = "exr")]
    texels: TexelsArg,
    /// Textures of the fall paths and of some numbers for each leaf, instead of every pose: small, whatever the number of
    /// frames; gusts are smoothed
    #[arg(long)]
    paths: bool,
    /// Print one JSON object of what was exported
    #[arg(long)]
    json: bool,
    /// Where to: FILE.usda, FILE.usdc or FILE.usdz (these two by usdcat or Python's pxr), FILE.glb, FILE.csv,
    /// FILE.parquet, or FILE.json for vertex animation textures beside it
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum TexelsArg {
    Exr,
    Png,
}

fn parse_box(text: &str) -> Result<(Vec3, Vec3), String> {
    let numbers: Vec<f32> = text
        .split(',')
        .map(|n| n.trim().parse().ok().filter(|n: &f32| n.is_finite()))
        .collect::<Option<_>>()
        .unwrap_or_default();
    match *numbers {
        [x, y, z, x1, y1, z1] if x <= x1 && y <= y1 && z <= z1 => {
            Ok((Vec3::new(x, y, z), Vec3::new(x1, y1, z1)))
        }
        _ => {
            Err("a box is six numbers, its low corner and its high one: -5,0,-5,5,20,5".to_owned())
        }
    }
}

/// Most frames of a file.
const MOST_FRAMES: u32 = 1_000_000;

/// What `--json` prints.
#[derive(Serialize)]
struct Report {
    /// What was left out of the files that were read.
    notes: Vec<Note>,
    frames: u32,
    trees: usize,
    leaves: usize,
    leaves_moving: usize,
    hanging: Span,
    falling: Span,
    landed: Span,
    seconds: f64,
    ns_per_leaf_and_frame: f64,
    bytes: u64,
}

/// Leaves in the first frame, and in the last.
#[derive(Serialize, Default)]
struct Span {
    first: usize,
    last: usize,
}

#[derive(Clone, Copy, PartialEq)]
enum Format {
    Csv,
    Parquet,
    Usd,
    Glb,
    Vat,
}

/// Runs `windfall export`.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let format = format_of(&args.out)?;
    if args.paths && format != Format::Vat {
        bail!("--paths: is for textures, --out FILE.json");
    }
    let (mut scene, folder, name) = read_scene(&args.scene)?;
    args.plant.apply(&mut scene)?;
    scene.fps = args.fps.unwrap_or(scene.fps);
    scene.check(&name)?;
    let mut notes = Vec::new();
    let cache = args.plant.cache.cache();
    let loaded = loading::load(&loading::sources(&scene, &folder), cache.as_ref())?;
    let mut stage = scene.place(planting::trees(&scene, loaded, &mut notes));
    stage.check(&name)?;
    notes.extend(read_paths(&scene, &folder, &mut stage)?);
    args.throw.apply(&mut stage)?;
    let (first, last) = args.frames.unwrap_or(match format {
        // A file of glTF is a moment, unless frames are asked for.
        Format::Glb => {
            let frame = (scene.time * f64::from(scene.fps)).max(0.0) as u32;
            (frame, frame)
        }
        Format::Csv | Format::Parquet | Format::Usd | Format::Vat => scene.frames,
    });
    if last - first >= MOST_FRAMES || last == u32::MAX {
        bail!(
            "--frames {first}-{last}: are more than {MOST_FRAMES} frames, or numbers beyond 4294967294"
        );
    }
    let moments = Moments { first, count: last - first + 1, fps: scene.fps };
    let source = source(&stage);
    let filter =
        Filter { parts: args.only.unwrap_or(Parts::ALL), within: args.within, most: args.most };
    let start = Instant::now();
    let terrain = &stage.forest.terrain;
    let selection =
        Selection::new(&source, moments, filter, &|time| scene.view(time, terrain).camera.eye);
    if selection.is_empty() && selection.trees().is_empty() && !filter.parts.ground {
        bail!("{name}: no leaf or tree is selected; --only, --within and --most leave nothing");
    }
    let bar = progress_bar(1000);
    let mut progress = |share: f32| bar.set_position((share * 1000.0) as u64);
    write(args, format, &selection, &mut progress)?;
    bar.finish_and_clear();
    let seconds = start.elapsed().as_secs_f64();
    let leaf_frames = selection.len() as f64 * f64::from(moments.count);
    let report = Report {
        frames: moments.count,
        trees: selection.trees().len(),
        leaves: selection.len(),
        leaves_moving: selection.groups().iter().filter(|g| g.moves).map(|g| g.leaves.len()).sum(),
        seconds,
        ns_per_leaf_and_frame: seconds * 1e9 / leaf_frames.max(1.0),
        notes,
        bytes: std::fs::metadata(&args.out).map_or(0, |m| m.len()),
        ..count(&selection)
    };
    eprintln!(
        "{} leaves, {} of which move, and {} trees in {} frames: {:.1} s, {:.0} ns a leaf and frame",
        report.leaves,
        report.leaves_moving,
        report.trees,
        report.frames,
        seconds,
        report.ns_per_leaf_and_frame
    );
    if args.json {
        writeln!(std::io::stdout(), "{}", serde_json::to_string_pretty(&report)?)?;
    }
    Ok(())
}

fn format_of(out: &Path) -> anyhow::Result<Format> {
    let shown = out.display();
    if out.is_dir() {
        bail!("--out {shown}: is a folder");
    }
    let extension = out.extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
    Ok(match extension.as_str() {
        "csv" => Format::Csv,
        "parquet" => Format::Parquet,
        "usda" | "usdc" | "usdz" => Format::Usd,
        "glb" => Format::Glb,
        "json" => Format::Vat,
        _ => bail!(
            "--out {shown}: the name must end in .usda, .usdc, .usdz, .glb, .csv, .parquet or .json"
        ),
    })
}

fn source(stage: &Stage) -> Source<'_> {
    let falls = &stage.falls;
    Source {
        trees: &stage.trees,
        forest: &stage.forest,
        paths: &falls.paths,
        shedding: falls.shedding,
        wind: falls.wind,
        variation: falls.variation.clone(),
        settings: falls.settings,
        season: stage.season,
        thrown: stage
            .events
            .iter()
            .map(|e| Thrown { tree: e.tree, leaf: e.leaf, time: e.time })
            .collect(),
    }
}

/// The leaves of a selection by what they do.
fn count(selection: &Selection<'_>) -> Report {
    let moments = selection.moments();
    let mut report = Report {
        notes: Vec::new(),
        frames: 0,
        trees: 0,
        leaves: 0,
        leaves_moving: 0,
        hanging: Span::default(),
        falling: Span::default(),
        landed: Span::default(),
        seconds: 0.0,
        ns_per_leaf_and_frame: 0.0,
        bytes: 0,
    };
    for (frame, last) in [(moments.first, false), (moments.frames().end - 1, true)] {
        for leaf in selection.at(moments.time(frame)) {
            let span = match table::name(leaf.phase) {
                "hanging" => &mut report.hanging,
                "falling" => &mut report.falling,
                _ => &mut report.landed,
            };
            *if last { &mut span.last } else { &mut span.first } += 1;
        }
    }
    report
}

fn write(
    args: &Args,
    format: Format,
    selection: &Selection<'_>,
    progress: &mut dyn FnMut(f32),
) -> anyhow::Result<()> {
    let out = &args.out;
    match format {
        Format::Csv => write_atomic(out, |file| {
            table::write_csv(selection, file, progress)?;
            Ok(())
        }),
        Format::Parquet => write_atomic(out, |file| {
            table::write_parquet(selection, file, progress)?;
            Ok(())
        }),
        Format::Glb => write_atomic(out, |file| Ok(gltf::write_glb(selection, file, progress)?)),
        Format::Usd => write_usd(out, selection, progress),
        Format::Vat if args.paths => write_paths(args, selection, progress),
        Format::Vat => write_vat(args, selection, progress),
    }
}

/// The name of a sidecar without its extension, for the files beside it, and their folder.
fn stem_and_folder(out: &Path) -> anyhow::Result<(&str, &Path)> {
    let stem = out.file_stem().and_then(|s| s.to_str()).context("--out: not UTF-8")?;
    Ok((stem, out.parent().unwrap_or(Path::new(""))))
}

/// Writes textures of paths and of leaves, the mesh and the shader; the sidecar last.
fn write_paths(
    args: &Args,
    selection: &Selection<'_>,
    progress: &mut dyn FnMut(f32),
) -> anyhow::Result<()> {
    let (stem, beside) = stem_and_folder(&args.out)?;
    let textures = PathTextures::new(selection, args.engine)?;
    let [paths, leaves] = ["paths", "leaves"].map(|part| format!("{stem}_{part}.exr"));
    let mesh = format!("{stem}.glb");
    write_atomic(&beside.join(&paths), |file| Ok(textures.write_paths(file)?))?;
    write_atomic(&beside.join(&leaves), |file| {
        Ok(textures.write_leaves(file, &mut |share| progress(share / 2.0))?)
    })?;
    write_atomic(&beside.join(&mesh), |file| {
        Ok(textures.write_mesh(file, &mut |share| progress(0.5 + share / 2.0))?)
    })?;
    let (name, text) = path_shader(args.engine);
    write_atomic(&beside.join(name), |file| Ok(file.write_all(text.as_bytes())?))?;
    write_atomic(&args.out, |file| Ok(file.write_all(&textures.sidecar(&paths, &leaves, &mesh))?))
}

/// Writes the textures, the mesh and the shaders; the sidecar last, when all that it names is there.
fn write_vat(
    args: &Args,
    selection: &Selection<'_>,
    progress: &mut dyn FnMut(f32),
) -> anyhow::Result<()> {
    let (stem, beside) = stem_and_folder(&args.out)?;
    let (texels, extension) = match args.texels {
        TexelsArg::Exr => (Texels::Exr, "exr"),
        TexelsArg::Png => (Texels::Png, "png"),
    };
    let files = Files {
        position: format!("{stem}_position.{extension}"),
        rotation: format!("{stem}_rotation.{extension}"),
        mesh: format!("{stem}.glb"),
    };
    // A quarter each for the box, the textures and the mesh.
    let mut part = |number: u8, share: f32| progress((f32::from(number) + share) / 4.0);
    let vat = Vat::new(selection, args.engine, &mut |share| part(0, share))?;
    if texels == Texels::Png && vat.rounding() > 1e-3 {
        eprintln!(
            "note: 16 bits round positions to {:.1} mm here; --texels exr, --within or --most is finer",
            vat.rounding() * 1e3
        );
    }
    for (number, which, name) in
        [(1, Which::Position, &files.position), (2, Which::Rotation, &files.rotation)]
    {
        write_atomic(&beside.join(name), |file| {
            Ok(vat.write_texture(which, texels, file, &mut |share| part(number, share))?)
        })?;
    }
    write_atomic(&beside.join(&files.mesh), |file| {
        Ok(vat.write_mesh(file, &mut |share| part(3, share))?)
    })?;
    for (name, text) in shaders(args.engine) {
        write_atomic(&beside.join(name), |file| Ok(file.write_all(text.as_bytes())?))?;
    }
    write_atomic(&args.out, |file| Ok(file.write_all(&vat.sidecar(texels, &files))?))
}

/// Writes a `.usda` and its textures; other kinds of USD are made of it.
fn write_usd(
    out: &Path,
    selection: &Selection<'_>,
    progress: &mut dyn FnMut(f32),
) -> anyhow::Result<()> {
    let stem = out.file_stem().and_then(|s| s.to_str()).context("--out: not UTF-8")?;
    let folder = format!("{stem}_textures");
    let beside = out.parent().unwrap_or(Path::new(""));
    for (name, bytes) in usd::textures(selection)? {
        write_atomic(&beside.join(&folder).join(name), |file| Ok(file.write_all(&bytes)?))?;
    }
    let text = |file: &mut dyn Write, progress: &mut dyn FnMut(f32)| {
        usd::write_usda(selection, &format!("./{folder}"), file, progress)
    };
    if out.extension().is_some_and(|e| e.eq_ignore_ascii_case("usda")) {
        return write_atomic(out, |file| Ok(text(file, progress)?));
    }
    // The text has to lie beside its textures while it is converted.
    let source = AtomicFile::create(&out.with_extension("usda"))?;
    let mut file = std::io::BufWriter::new(source.reopen()?);
    text(&mut file, progress)?;
    file.flush()?;
    let target = AtomicFile::create(out)?;
    convert(source.temporary_path(), target.temporary_path(), &format!("{stem}.usda"))
        .with_context(|| format!("cannot write {}", out.display()))?;
    target.commit()
}

/// What Python runs to convert a stage. A package has its textures inside.
const CONVERT: &str = "import sys
from pxr import Usd, UsdUtils
source, target, name = sys.argv[1:]
if target.endswith('.usdz'):
    sys.exit(not UsdUtils.CreateNewUsdzPackage(source, target, name))
sys.exit(not Usd.Stage.Open(source).Export(target))";

/// Converts a stage by OpenUSD's Python module, or by its `usdcat` and `usdzip`. `name` is that of a package's stage.
fn convert(source: &Path, target: &Path, name: &str) -> anyhow::Result<()> {
    let package = target.extension().is_some_and(|e| e.eq_ignore_ascii_case("usdz"));
    let mut tool = Command::new(if package { "usdzip" } else { "usdcat" });
    if package {
        tool.arg("--asset").arg(source).arg(target);
    } else {
        tool.arg(source).arg("--out").arg(target);
    }
    let mut python = Command::new("python3");
    python.args(["-c", CONVERT]).arg(source).arg(target).arg(name);
    for mut command in [python, tool] {
        match command.stdout(std::process::Stdio::null()).output() {
            Ok(done) if done.status.success() => return Ok(()),
            Ok(done) => {
                let said = String::from_utf8_lossy(&done.stderr);
                let last = said.lines().last().unwrap_or("");
                if !last.contains("No module named") {
                    bail!("{} failed: {last}", command.get_program().display());
                }
            }
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
            Err(error) => return Err(error).context(command.get_program().display().to_string()),
        }
    }
    bail!(
        "needs OpenUSD's usdcat and usdzip on the path, or its Python module (pip install usd-core); \
         .usda needs neither"
    )
}
