//! `windfall farm`: jobs for render farms, and the film of their frames.
//!
//! A frame follows from scene, seed and time, so that tasks need nothing of each other. A task renders the frames of
//! its range that are not there yet (`render --resume`), so it can be killed and run again.

use crate::output::{Film, Output};
use crate::render::{parse_frames, read_scene};
use anyhow::{Context, bail};
use clap::CommandFactory;
use std::fmt::Write as _;
use std::io::Write;
use std::path::{Component, Path, PathBuf};
use windfall_host::file::write_atomic;
use windfall_host::image::RgbaImage;
use windfall_scenes::{Scene, Source};

/// Arguments of `windfall farm`.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(clap::Subcommand)]
enum Command {
    /// Write an Open Job Description template (2023-09): for AWS Deadline Cloud, and for `openjd run`
    Template(Job),
    /// Write a script for a job array of Slurm
    Slurm(Job),
    /// Join frames to a film: those that are there; missing ones are named
    Film(FilmArgs),
}

/// What is rendered.
#[derive(clap::Args)]
struct Job {
    /// A scene file (.ron), or the name of a built-in scene
    #[arg(value_name = "SCENE", default_value = windfall_scenes::NAMES[0])]
    scene: String,
    /// Frames, first and last; without it those of the scene
    #[arg(long, value_name = "A-B", value_parser = parse_frames)]
    frames: Option<(u32, u32)>,
    /// Frames per second
    #[arg(long, value_name = "N")]
    fps: Option<f32>,
    /// An option of `windfall render` and its values: the frames are rendered with each, into a folder of its own; may
    /// be given again for every combination
    #[arg(long, value_name = "OPTION=VALUE,...", value_parser = parse_sweep)]
    sweep: Vec<Sweep>,
    /// Frames that a task renders
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..))]
    frames_per_task: u32,
    /// Name of the film, in the folder of its frames: .mp4 (needs ffmpeg), .apng or .gif
    #[arg(long, value_name = "FILE", default_value = "film.mp4")]
    film: String,
    /// The program, as machines of the farm find it
    #[arg(long, value_name = "PATH", default_value = "windfall")]
    program: String,
    /// Folder of the frames, as machines of the farm find it
    #[arg(long, value_name = "FOLDER", default_value = "frames")]
    folder: String,
    /// File to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

#[derive(clap::Args)]
struct FilmArgs {
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

/// An option of `windfall render` and the values that it takes in turn.
#[derive(Debug, Clone, PartialEq)]
struct Sweep {
    option: String,
    values: Vec<String>,
}

fn parse_sweep(text: &str) -> Result<Sweep, String> {
    let (option, values) =
        text.split_once('=').ok_or("a sweep is OPTION=VALUE,..., such as h=0,0.5,0.7")?;
    let values: Vec<String> = values.split(',').map(|v| v.trim().to_owned()).collect();
    let plain = |v: &String| {
        !v.is_empty() && v.chars().all(|c| c.is_ascii_alphanumeric() || "-._".contains(c))
    };
    if let Some(bad) = values.iter().find(|v| !plain(v)) {
        return Err(format!("{bad:?}: a value has letters, digits, '.', '-' and '_' only"));
    }
    for (i, value) in values.iter().enumerate() {
        if values[..i].contains(value) {
            return Err(format!("{value} is there twice"));
        }
    }
    Ok(Sweep { option: option.trim_start_matches('-').to_owned(), values })
}

/// Options that the job sets itself.
const TAKEN: [&str; 5] = ["frames", "fps", "time", "out", "resume"];

impl Sweep {
    /// Asks the command line of `render` whether it takes these values.
    fn check(&self) -> anyhow::Result<()> {
        let Self { option, values } = self;
        let command = crate::Cli::command();
        let render = command.find_subcommand("render").context("render")?;
        let known = render.get_arguments().find(|a| a.get_long() == Some(option));
        if known.is_none_or(|a| !a.get_action().takes_values()) || TAKEN.contains(&option.as_str())
        {
            bail!("--sweep {option}: is no option of windfall render with values to sweep");
        }
        for value in values {
            let line = ["windfall", "render", &format!("--{option}={value}"), "--out", "f_%d.png"];
            let parsed = crate::Cli::command().try_get_matches_from(line);
            if let Err(error) = parsed
                && error.kind() != clap::error::ErrorKind::MissingRequiredArgument
            {
                let text = error.to_string();
                bail!(
                    "--sweep {}",
                    text.lines().next().unwrap_or("").trim_start_matches("error: ")
                );
            }
        }
        Ok(())
    }

    /// Its name as a parameter of a job: `throw-rate` is `ThrowRate`.
    fn parameter(&self) -> String {
        let words = self.option.split('-').map(|word| {
            let mut letters = word.chars();
            let first = letters.next().map(|c| c.to_ascii_uppercase());
            first.into_iter().chain(letters).collect::<String>()
        });
        words.collect()
    }
}

/// Runs `windfall farm`.
pub fn run(args: &Args) -> anyhow::Result<()> {
    match &args.command {
        Command::Template(job) => {
            let scene = job.checked()?;
            let text = job.template(&scene)?;
            write_atomic(&job.out, |file| Ok(file.write_all(text.as_bytes())?))
        }
        Command::Slurm(job) => {
            let scene = job.checked()?;
            let text = job.slurm(&scene);
            write_atomic(&job.out, |file| Ok(file.write_all(text.as_bytes())?))
        }
        Command::Film(args) => film(args),
    }
}

/// A string as YAML has it, between quotes.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// A string as a shell has it, between quotes.
fn shell(text: &str) -> String {
    format!("'{}'", text.replace('\'', r"'\''"))
}

impl Job {
    fn checked(&self) -> anyhow::Result<Scene> {
        let (mut scene, _, name) = read_scene(&self.scene)?;
        scene.fps = self.fps.unwrap_or(scene.fps);
        scene.check(&name)?;
        if let Some(frames) = self.frames {
            let (first, last) = scene.frames;
            if frames.0 < first || frames.1 > last {
                eprintln!(
                    "note: {name} has the frames {first}-{last}; those beyond repeat the ends"
                );
            }
            scene.frames = frames;
        }
        self.sweep.iter().try_for_each(Sweep::check)?;
        for (i, sweep) in self.sweep.iter().enumerate() {
            if self.sweep[..i].iter().any(|other| other.option == sweep.option) {
                bail!("--sweep {}: is there twice", sweep.option);
            }
        }
        match Output::parse(&self.film)? {
            Output::Mp4(_) | Output::Apng(_) | Output::Gif(_) => Ok(scene),
            _ => bail!("--film {}: is not .mp4, .apng or .gif", self.film),
        }
    }

    /// Whether the scene is a file, not a built-in one.
    fn is_file(&self) -> bool {
        windfall_scenes::named(&self.scene).is_none()
    }

    /// A path from the folder of the job's file: a template may only name what is below it.
    fn below(&self, path: &Path) -> anyhow::Result<String> {
        let folder = match self.out.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => std::path::absolute(folder)?,
            _ => std::env::current_dir()?,
        };
        let full = std::path::absolute(path)?;
        let inside = full
            .strip_prefix(&folder)
            .ok()
            .filter(|p| p.components().all(|part| matches!(part, Component::Normal(_))));
        let inside = inside.and_then(Path::to_str).with_context(|| {
            format!(
                "{}: is not below {}; write the template beside the scene, or above it",
                path.display(),
                folder.display()
            )
        })?;
        Ok(inside.to_owned())
    }

    /// Folder of a task's frames below that of the job; `value` gives a sweep's value.
    fn subfolder(&self, value: impl Fn(&Sweep) -> String) -> String {
        self.sweep.iter().fold(String::new(), |mut path, sweep| {
            let _ = write!(path, "/{}_{}", sweep.option, value(sweep));
            path
        })
    }

    fn template(&self, scene: &Scene) -> anyhow::Result<String> {
        let (first, last) = scene.frames;
        let mut text = String::new();
        let mut line = |line: &str| {
            text.push_str(line);
            text.push('\n');
        };
        line("specificationVersion: jobtemplate-2023-09");
        line("extensions: [TASK_CHUNKING]");
        line(&format!("name: {}", quoted(&format!("Windfall {}", self.title()))));
        line("description: |");
        line(
            "  Frames of a forest that sheds its leaves, and their film. Every frame follows from scene, seed and time;",
        );
        line("  tasks skip frames that are there, so a task that was stopped can run again.");
        line("parameterDefinitions:");
        if self.is_file() {
            let scene_file = Path::new(&self.scene);
            line(&path_parameter("Scene", &self.below(scene_file)?, "FILE", "IN"));
            let folder = scene_file.parent().unwrap_or(Path::new(""));
            let trees = scene.trees.iter().filter_map(|tree| match &tree.source {
                Source::File(file) => Some(file),
                Source::Species(_) => None,
            });
            // What the scene names has to travel with it.
            for (i, file) in trees.chain(&scene.sky.picture).enumerate() {
                let inside = self.below(&folder.join(file))?;
                line(&path_parameter(&format!("SceneFile{}", i + 1), &inside, "FILE", "IN"));
            }
        } else {
            line(&parameter("Scene", "STRING", &quoted(&self.scene)));
        }
        line(&path_parameter("OutputDir", &self.folder, "DIRECTORY", "OUT"));
        line(&parameter("Frames", "STRING", &quoted(&format!("{first}-{last}"))));
        line(&parameter("FramesPerTask", "INT", &self.frames_per_task.to_string()));
        line(&parameter("Film", "STRING", &quoted(&self.film)));
        line(&parameter("Windfall", "STRING", &quoted(&self.program)));
        line("steps:");
        line("- name: Render");
        line("  parameterSpace:");
        line("    taskParameterDefinitions:");
        line("    - name: Frame");
        line("      type: CHUNK[INT]");
        line("      range: \"{{Param.Frames}}\"");
        line("      chunks:");
        line("        defaultTaskCount: \"{{Param.FramesPerTask}}\"");
        line("        rangeConstraint: CONTIGUOUS");
        self.sweep_parameters().iter().for_each(|l| line(l));
        let here = self.subfolder(|sweep| format!("{{{{Task.Param.{}}}}}", sweep.parameter()));
        let pattern = format!("{{{{Param.OutputDir}}}}{here}/frame_%05d.png");
        let mut render: Vec<String> =
            ["render", "{{Param.Scene}}", "--frames", "{{Task.Param.Frame}}"]
                .map(Into::into)
                .into();
        for sweep in &self.sweep {
            render.push(format!("--{}={{{{Task.Param.{}}}}}", sweep.option, sweep.parameter()));
        }
        let fps = format!("--fps={}", scene.fps);
        for argument in [fps.as_str(), "--resume", "--progress-lines", "--out", &pattern] {
            render.push(argument.to_owned());
        }
        action(&mut line, &render);
        line("- name: Film");
        line("  dependencies:");
        line("  - dependsOn: Render");
        if !self.sweep.is_empty() {
            line("  parameterSpace:");
            line("    taskParameterDefinitions:");
            self.sweep_parameters().iter().for_each(|l| line(l));
        }
        let film = format!("{{{{Param.OutputDir}}}}{here}/{{{{Param.Film}}}}");
        let join = ["farm", "film", &pattern, "--frames", "{{Param.Frames}}", &fps, "--out", &film];
        action(&mut line, &join.map(str::to_owned));
        Ok(text)
    }

    fn title(&self) -> String {
        let stem = Path::new(&self.scene).file_stem().and_then(|s| s.to_str());
        stem.unwrap_or("scene").chars().take(100).collect()
    }

    fn sweep_parameters(&self) -> Vec<String> {
        let of = |sweep: &Sweep| {
            let values: Vec<String> = sweep.values.iter().map(|v| quoted(v)).collect();
            [
                format!("    - name: {}", sweep.parameter()),
                "      type: STRING".to_owned(),
                format!("      range: [{}]", values.join(", ")),
            ]
        };
        self.sweep.iter().flat_map(of).collect()
    }

    fn slurm(&self, scene: &Scene) -> String {
        let (first, last) = scene.frames;
        let chunks = (u64::from(last - first) + 1).div_ceil(u64::from(self.frames_per_task));
        let combinations: u64 = self.sweep.iter().map(|s| s.values.len() as u64).product();
        let mut text = String::new();
        let mut line = |line: &str| {
            text.push_str(line);
            text.push('\n');
        };
        line("#!/bin/bash");
        line(
            "# Written by windfall farm slurm. Submit it, and the film after it whatever became of the tasks:",
        );
        line(
            "#   job=$(sbatch --parsable THIS) && sbatch --dependency=afterany:$job --array=0 THIS film",
        );
        line("# A task that was stopped can be submitted again: frames that are there are kept.");
        line(&format!("#SBATCH --job-name=windfall-{}", word(&self.title())));
        line(&format!("#SBATCH --array=0-{}", chunks * combinations - 1));
        line("#SBATCH --requeue");
        line("set -euo pipefail");
        line(&format!("windfall=${{WINDFALL:-{}}}", shell(&self.program)));
        line(&format!("folder=${{WINDFALL_FOLDER:-{}}}", shell(&self.folder)));
        line(&format!("first={first} last={last} each={} chunks={chunks}", self.frames_per_task));
        line("render() { # frames");
        line("    local task=$((SLURM_ARRAY_TASK_ID / chunks)) path=$folder options=()");
        self.slurm_sweep(&mut line, "    ");
        line(&format!(
            "    \"$windfall\" render {} --fps={} --frames \"$1\" --resume \"${{options[@]}}\" --out \"$path/frame_%05d.png\"",
            shell(&self.scene),
            scene.fps
        ));
        line("}");
        line("film() { # task");
        line("    local task=$1 path=$folder options=()");
        self.slurm_sweep(&mut line, "    ");
        line(&format!(
            "    \"$windfall\" farm film \"$path/frame_%05d.png\" --frames \"$first-$last\" --fps={} --out \"$path/{}\"",
            scene.fps,
            self.film.replace(['"', '$', '`', '\\'], "_")
        ));
        line("}");
        line("if [ \"${1:-}\" = film ]; then");
        line(&format!("    for ((i = 0; i < {combinations}; i++)); do film \"$i\"; done"));
        line("else");
        line("    begin=$((first + SLURM_ARRAY_TASK_ID % chunks * each))");
        line("    end=$((begin + each - 1 < last ? begin + each - 1 : last))");
        line("    render \"$begin-$end\"");
        line("fi");
        text
    }

    /// Lines that take a task's values of the sweeps.
    fn slurm_sweep(&self, line: &mut impl FnMut(&str), indent: &str) {
        for sweep in &self.sweep {
            let (option, values) = (&sweep.option, sweep.values.join(" "));
            line(&format!("{indent}local values=({values})"));
            line(&format!("{indent}local value=${{values[task % ${{#values[@]}}]}}"));
            line(&format!("{indent}task=$((task / ${{#values[@]}}))"));
            line(&format!("{indent}path+=/{option}_$value options+=(--{option}=$value)"));
        }
    }
}

/// A name without what a line of options cannot have.
fn word(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' }).collect()
}

fn parameter(name: &str, kind: &str, default: &str) -> String {
    format!("- name: {name}\n  type: {kind}\n  default: {default}")
}

fn path_parameter(name: &str, default: &str, object: &str, flow: &str) -> String {
    let start = parameter(name, "PATH", &quoted(default));
    format!("{start}\n  objectType: {object}\n  dataFlow: {flow}")
}

/// The action of a step: the program with these arguments.
fn action(line: &mut impl FnMut(&str), arguments: &[String]) {
    line("  script:");
    line("    actions:");
    line("      onRun:");
    line("        command: \"{{Param.Windfall}}\"");
    line("        args:");
    for argument in arguments {
        line(&format!("        - {}", quoted(argument)));
    }
}

/// Joins frames to a film.
fn film(args: &FilmArgs) -> anyhow::Result<()> {
    let FilmArgs { pattern, frames: (first, last), fps, out } = args;
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
    let Some(mut film) = Film::begin(&output, (width, height), there.len() as u32, *fps)? else {
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
        let of = last - first + 1;
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
    fn sweeps_are_options_of_render_with_values_that_it_takes() {
        let sweep = parse_sweep("h=0,0.5,0.7").unwrap();
        assert_eq!((sweep.option.as_str(), sweep.values.len()), ("h", 3));
        assert!(sweep.check().is_ok());
        assert_eq!(parse_sweep("throw-rate=1").unwrap().parameter(), "ThrowRate");
        for (text, message) in [
            ("heights=1", "no option of windfall render"),
            ("json=1", "no option of windfall render"),
            ("out=a.png", "no option of windfall render"),
            ("strategy=vertex,cpu", "cpu"),
            ("seed=1,x", "invalid value 'x'"),
        ] {
            let error = parse_sweep(text).unwrap().check().unwrap_err().to_string();
            assert!(error.contains(message), "{text}: {error}");
        }
        for text in ["h", "h=", "h=1,,2", "h=1,1", "h=$(x)"] {
            assert!(parse_sweep(text).is_err(), "{text}");
        }
    }

    #[test]
    fn numbers_that_follow_each_other_are_ranges() {
        assert_eq!(ranges(&[4, 7, 8, 9, 11]), "4, 7-9, 11");
        assert_eq!(ranges(&[0]), "0");
    }
}
