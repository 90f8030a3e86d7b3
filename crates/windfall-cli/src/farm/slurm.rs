//! `windfall farm slurm`: a script for a job array.

use super::Job;
use windfall_scenes::Scene;

impl Job {
    pub fn slurm(&self, scene: &Scene) -> String {
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

/// A string as a shell has it, between quotes.
fn shell(text: &str) -> String {
    format!("'{}'", text.replace('\'', r"'\''"))
}

/// A name without what a line of options cannot have.
fn word(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' }).collect()
}
