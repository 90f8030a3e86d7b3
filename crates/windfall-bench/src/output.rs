//! Reports and plots to files.

use anyhow::Context;
use serde::Serialize;
use std::path::Path;

/// Writes a report as indented JSON.
pub fn write_json(path: &Path, report: &impl Serialize) -> anyhow::Result<()> {
    write_text(path, &serde_json::to_string_pretty(report)?)
}

/// Writes a text file.
pub fn write_text(path: &Path, text: &str) -> anyhow::Result<()> {
    std::fs::write(path, text).with_context(|| format!("{}", path.display()))
}

/// Creates a folder and its parents if they are missing.
pub fn create_folder(folder: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("{}", folder.display()))
}
