//! `windfall farm`: jobs for render farms, and the film of their frames.
//!
//! A frame follows from scene, seed and time, so that tasks need nothing of each other. A task renders the frames of
//! its range that are not there yet (`render --resume`), so it can be killed and run again.

mod film;
mod slurm;
mod template;

use crate::output::Output;
use crate::render::{parse_frames, read_scene};
use anyhow::{Context, bail};
use clap::CommandFactory;
use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};
use windfall_host::file::write_atomic;
use windfall_scenes::Scene;

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
    Film(film::Args),
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
        Command::Film(args) => film::run(args),
    }
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

    /// Folder of a task's frames below that of the job; `value` gives a sweep's value.
    fn subfolder(&self, value: impl Fn(&Sweep) -> String) -> String {
        self.sweep.iter().fold(String::new(), |mut path, sweep| {
            let _ = write!(path, "/{}_{}", sweep.option, value(sweep));
            path
        })
    }

    fn title(&self) -> String {
        let stem = Path::new(&self.scene).file_stem().and_then(|s| s.to_str());
        stem.unwrap_or("scene").chars().take(100).collect()
    }
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
            ("strategy=vertex,gpu", "gpu"),
            ("seed=1,x", "invalid value 'x'"),
        ] {
            let error = parse_sweep(text).unwrap().check().unwrap_err().to_string();
            assert!(error.contains(message), "{text}: {error}");
        }
        for text in ["h", "h=", "h=1,,2", "h=1,1", "h=$(x)"] {
            assert!(parse_sweep(text).is_err(), "{text}");
        }
    }
}
