//! `windfall farm template`: an Open Job Description template.

use super::{Job, Sweep};
use anyhow::Context;
use std::path::{Component, Path};
use windfall_scenes::{Scene, Source};

impl Job {
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

    pub fn template(&self, scene: &Scene) -> anyhow::Result<String> {
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
}

impl Sweep {
    /// Its name as a parameter of a job: `throw-rate` is `ThrowRate`.
    pub fn parameter(&self) -> String {
        let words = self.option.split('-').map(|word| {
            let mut letters = word.chars();
            let first = letters.next().map(|c| c.to_ascii_uppercase());
            first.into_iter().chain(letters).collect::<String>()
        });
        words.collect()
    }
}

/// A string as YAML has it, between quotes.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
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
