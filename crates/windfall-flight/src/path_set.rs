//! Path sets as RON: text that holds what the binary form does, under the field names of [`Analysis`].

use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};
use windfall_core::path::format::{MAGIC, VERSION};
use windfall_core::path::{Analysis, FallPath, PathSet, Recording};
use windfall_core::{InputError, InputErrorKind};

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileForm {
    version: u32,
    paths: Vec<PathForm>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PathForm {
    name: String,
    rate: f32,
    positions: Vec<[f32; 3]>,
    orientations: Vec<[f32; 4]>,
    analysis: Analysis,
}

/// Reads a path set in binary or RON form; `file` is its name for messages.
///
/// # Errors
///
/// Bytes that are of neither form, of another version, truncated or followed by more; and
/// whatever [`Recording::new`] and [`FallPath::new`] refuse.
pub fn read_paths(file: &str, bytes: &[u8]) -> Result<PathSet, InputError> {
    if bytes.starts_with(MAGIC) {
        return PathSet::read(file, bytes);
    }
    PathSet::new(read_ron(file, bytes)?).map_err(|e| InputError { file: file.into(), ..e })
}

fn named(file: &str, index: usize, error: InputError) -> InputError {
    let place = if error.place.is_empty() { String::new() } else { format!(", {}", error.place) };
    InputError { file: file.into(), place: format!("path {index}{place}"), ..error }
}

fn read_ron(file: &str, bytes: &[u8]) -> Result<Vec<FallPath>, InputError> {
    let malformed = |place: String, cause: String| {
        InputError::new(file, place, InputErrorKind::Malformed, cause)
    };
    let text = std::str::from_utf8(bytes).map_err(|_| {
        malformed(String::new(), "neither a binary path set nor text in UTF-8".into())
    })?;
    let form: FileForm = ron::from_str(text)
        .map_err(|e| malformed(e.span.to_string(), format!("not a path set in RON: {}", e.code)))?;
    check_version(file, form.version)?;
    form.paths
        .into_iter()
        .enumerate()
        .map(|(i, p)| {
            let positions = p.positions.into_iter().map(Vec3::from).collect();
            let orientations = p.orientations.into_iter().map(Quat::from_array).collect();
            Recording::new(p.name, p.rate, positions, orientations)
                .and_then(|recording| FallPath::new(recording, p.analysis))
                .map_err(|e| named(file, i, e))
        })
        .collect()
}

fn check_version(file: &str, version: u32) -> Result<(), InputError> {
    if version == VERSION {
        return Ok(());
    }
    let cause = format!("version {version}; this program reads version {VERSION}");
    Err(InputError::new(file, "", InputErrorKind::Unsupported, cause))
}

/// A path set in RON form, for people and version control.
pub fn to_ron(set: &PathSet) -> String {
    let paths = set
        .paths()
        .iter()
        .map(|p| PathForm {
            name: p.name().into(),
            rate: p.rate(),
            positions: p.positions().iter().map(Vec3::to_array).collect(),
            orientations: p.orientations().iter().map(|q| q.to_array()).collect(),
            analysis: p.analysis().clone(),
        })
        .collect();
    let form = FileForm { version: VERSION, paths };
    // Plain numbers and strings: nothing in there that RON cannot write.
    ron::ser::to_string_pretty(&form, ron::ser::PrettyConfig::new().depth_limit(3))
        .unwrap_or_default()
}
