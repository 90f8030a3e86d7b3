//! Fall paths from files: glTF animations, tables in CSV, and JSON.
//!
//! Recorded, simulated elsewhere or drawn by hand: whatever gives positions and orientations over
//! time becomes a [`FallPath`] (VB 3.2). Times are seconds and must ascend. Keys at equal distances
//! (within 1%) are taken as they are; others are resampled. What is repaired, left out or looks wrong is said in
//! [`Imported::notes`]; what cannot be read is an [`InputError`] that names file, place and cause.
//!
//! # Tables (CSV and JSON)
//!
//! | columns | what |
//! |---|---|
//! | `time` or `t` | seconds (or [`ImportOptions::time_unit`]), ascending; or |
//! | `frame` or `frames` | frame number, ascending; needs [`ImportOptions::fps`] |
//! | `x`, `y`, `z` | position; also `tx`, `px`, `P[x]`, `P[0]`, `pos_x`, `position_x`, `loc_x`, `location_x`, `translateX` and the like |
//! | `qx`, `qy`, `qz`, `qw` | orientation as a unit quaternion; also `quat_x`, `orient_x`, `orientation_x`, `rotation_quaternion_x` and Houdini's `orient[0]` to `orient[3]` (x, y, z, w); or |
//! | `rx`, `ry`, `rz` | Euler angles in degrees: about X first, then Y, then Z, all fixed axes; also `rotateX` and the like |
//!
//! Case, brackets, dots, spaces and underscores in names do not matter. All columns of a kind must be named the same
//! way; the first way in this table counts, and every other column is left out with a note.
//!
//! # Animations (glTF)
//!
//! One animation ("take") is read; channels of two are never mixed. The motion of animated parents is combined with
//! the node's own. The path lasts from the first translation key to the last. It has the keys of the channel with the
//! most, evenly spaced ones first; all others are interpolated there, and held before their first and after their last
//! key (glTF 2.0, appendix C).

mod csv;
mod gltf;
mod json;
mod table;

use crate::fall_path;
use glam::{Quat, Vec3};
use windfall_core::path::analysis::angle;
use windfall_core::path::{FallPath, MAX_SAMPLES, MIN_SAMPLES, UNIT_TOLERANCE};
use windfall_core::{InputError, InputErrorKind};
pub use windfall_core::{Note, NoteCode};

/// The axis that points up in a file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Up {
    /// Y, as glTF prescribes and exporters deliver.
    #[default]
    Y,
    /// Z, as Blender and Houdini count inside. The leaf's own frame is turned along: its upper side
    /// is +Z in the file.
    Z,
}

/// What one unit of the times in a table is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum TimeUnit {
    /// Seconds.
    #[default]
    Seconds,
    /// Milliseconds.
    Milliseconds,
}

impl TimeUnit {
    /// Seconds for each unit.
    fn seconds(self) -> f64 {
        match self {
            Self::Seconds => 1.0,
            Self::Milliseconds => 1e-3,
        }
    }
}

/// How to read a file. Complete it with `..Default::default()`: more options may come.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportOptions {
    /// glTF: name of the animated node, or of one below an animated node. Needed if several are animated, unless
    /// each is the parent of the next: then the lowest is the leaf.
    pub node: Option<String>,
    /// glTF: name of the animation ("take") to read, or the number from 0 of one without a name. Default: the first
    /// that moves the node; a note names the others.
    pub animation: Option<String>,
    /// The axis that points up.
    pub up: Up,
    /// Metres for each unit of the file; above 0. 0.01 for centimetres.
    pub scale: f32,
    /// Tables: what times are in; seconds by default. glTF has seconds.
    pub time_unit: TimeUnit,
    /// Tables without a time column: frames per second of their frame numbers, above 0. No effect elsewhere.
    pub fps: Option<f32>,
    /// Samples per second to resample to; default: the keys' own rate if they are evenly spaced,
    /// otherwise 60 Hz.
    pub rate: Option<f32>,
    /// Name of the path; default: the file's.
    pub name: Option<String>,
}

impl Default for ImportOptions {
    fn default() -> Self {
        Self {
            node: None,
            animation: None,
            up: Up::Y,
            scale: 1.0,
            time_unit: TimeUnit::Seconds,
            fps: None,
            rate: None,
            name: None,
        }
    }
}

/// An imported path.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The path, analysed.
    pub path: FallPath,
    /// What was repaired, left out or looks wrong, in the order it was found.
    pub notes: Vec<Note>,
    /// Those of the notes that tell of repairs and of what was left out, as text without the file's name.
    pub repairs: Vec<String>,
}

/// Fetches a buffer that a `.gltf` names outside itself: a relative path (percent signs decoded) to bytes, or
/// why there are none. Whether a path may leave the file's folder is for the caller to say.
pub type Resolve<'a> = dyn FnMut(&str) -> Result<Vec<u8>, String> + 'a;

/// Imports a fall path whose file holds all of it: [`import_with`], but files beside are refused.
///
/// # Errors
///
/// Those of [`import_with`].
pub fn import(file: &str, bytes: &[u8], options: &ImportOptions) -> Result<Imported, InputError> {
    read(file, bytes, options, None)
}

/// Imports a fall path. The form is told from the bytes, not from the name: glTF (binary, or JSON
/// with `"asset"`), JSON, otherwise CSV. `file` is its name for messages; `resolve` fetches the buffers that lie
/// beside a `.gltf`.
///
/// # Errors
///
/// Bytes that are of no known form, a missing column, channel, animation or file beside, several animated nodes
/// without a name, fewer than [`MIN_SAMPLES`] keys, times that do not ascend or whose rate no path can have, a NaN, a
/// quaternion more than 5% from unit length, and whatever [`fall_path`] refuses.
pub fn import_with(
    file: &str,
    bytes: &[u8],
    options: &ImportOptions,
    resolve: &mut Resolve<'_>,
) -> Result<Imported, InputError> {
    read(file, bytes, options, Some(resolve))
}

fn read(
    file: &str,
    bytes: &[u8],
    options: &ImportOptions,
    resolve: Option<&mut Resolve<'_>>,
) -> Result<Imported, InputError> {
    if !(options.scale > 0.0 && options.scale.is_finite()) {
        let cause = format!("scale {} must be above 0", options.scale);
        return Err(InputError::new(file, "options", InputErrorKind::OutOfRange, cause));
    }
    if let Some(rate) = options.rate
        && !(1.0..=10_000.0).contains(&rate)
    {
        let cause = format!("rate {rate} Hz is outside 1..=10000");
        return Err(InputError::new(file, "options", InputErrorKind::OutOfRange, cause));
    }
    if let Some(fps) = options.fps
        && !(fps > 0.0 && fps.is_finite())
    {
        let cause = format!("{fps} frames per second must be above 0");
        return Err(InputError::new(file, "options", InputErrorKind::OutOfRange, cause));
    }
    let mut notes = Notes { file, list: Vec::new() };
    let text = bytes.trim_ascii_start();
    let mut motion = if bytes.starts_with(b"glTF") {
        gltf::read(file, bytes, options, resolve, &mut notes)?
    } else if text.starts_with(b"{") || text.starts_with(b"[") {
        let value: serde_json::Value = serde_json::from_slice(bytes).map_err(|e| {
            let place = format!("line {}, column {}", e.line(), e.column());
            InputError::new(file, place, InputErrorKind::Malformed, format!("not JSON: {e}"))
        })?;
        if value.get("asset").is_some() {
            gltf::read(file, bytes, options, resolve, &mut notes)?
        } else {
            table::read(file, &json::read(file, &value)?, options, &mut notes)?
        }
    } else {
        table::read(file, &csv::read(file, bytes)?, options, &mut notes)?
    };
    for p in &mut motion.positions {
        *p *= options.scale;
    }
    if options.up == Up::Z {
        for (p, q) in motion.positions.iter_mut().zip(&mut motion.orientations) {
            *p = Vec3::new(p.x, p.z, -p.y);
            *q = Quat::from_xyzw(q.x, q.z, -q.y, q.w);
        }
    }
    let name = options.name.clone().unwrap_or_else(|| {
        let base = file.rsplit(['/', '\\']).next().unwrap_or(file);
        base.split('.').next().filter(|n| !n.is_empty()).unwrap_or("path").to_owned()
    });
    let path = fall_path(name, motion.rate, motion.positions, motion.orientations)
        .map_err(|e| InputError { file: file.into(), ..e })?;
    let notes = notes.list;
    let looks_wrong = |code| matches!(code, NoteCode::FastTurn | NoteCode::ParentMotion);
    let repairs = notes
        .iter()
        .filter(|n| !looks_wrong(n.code))
        .map(|n| {
            if n.place.is_empty() {
                n.message.clone()
            } else {
                format!("{} {}", n.place, n.message)
            }
        })
        .collect();
    Ok(Imported { path, notes, repairs })
}

/// Collects the notes on a file.
struct Notes<'a> {
    file: &'a str,
    list: Vec<Note>,
}

impl Notes<'_> {
    fn add(&mut self, code: NoteCode, place: &str, message: impl Into<String>) {
        self.list.push(Note::new(code, self.file, place, message));
    }

    /// Notes turns from one key to the next that are above 90 degrees. `keys` are times in seconds and the unit
    /// rotations there.
    fn fast_turns(&mut self, place: &str, keys: impl Iterator<Item = (f64, Quat)>) {
        let mut fast: Option<(f64, f64, f32)> = None;
        let mut more = 0;
        let mut previous: Option<(f64, Quat)> = None;
        for (t, q) in keys {
            if let Some((before, p)) = previous {
                let turn = angle(p, q).to_degrees();
                if turn > FAST_TURN {
                    match fast {
                        None => fast = Some((before, t, turn)),
                        Some(_) => more += 1,
                    }
                }
            }
            previous = Some((t, q));
        }
        if let Some((from, to, turn)) = fast {
            let others = match more {
                0 => String::new(),
                1 => ", and once more above 90°".to_owned(),
                _ => format!(", and {more} more times above 90°"),
            };
            let message = format!(
                "turns by {turn:.0}° from {from:.3} s to {to:.3} s{others}: between keys the shorter way round is \
                 taken; export more keys per second"
            );
            self.add(NoteCode::FastTurn, place, message);
        }
    }
}

/// Turns from key to key above this are noted, degrees.
const FAST_TURN: f32 = 90.001;

/// Evenly sampled motion, in the file's axes and units.
struct Motion {
    rate: f32,
    positions: Vec<Vec3>,
    orientations: Vec<Quat>,
}

/// The rate of evenly spaced times, if they are: within 1% of the mean distance.
fn even_rate(times: &[f64]) -> Option<f64> {
    let span = times.last()? - times.first()?;
    let mean = span / (times.len() - 1) as f64;
    times.windows(2).all(|w| ((w[1] - w[0]) - mean).abs() <= 0.01 * mean).then_some(1.0 / mean)
}

/// That so many keys are too few.
fn too_few(file: &str, place: &str, keys: usize) -> InputError {
    let word = if keys == 1 { "key" } else { "keys" };
    let cause = format!("{keys} {word}; a fall path needs at least {MIN_SAMPLES}");
    InputError::new(file, place, InputErrorKind::Empty, cause)
}

/// Refuses times that are not numbers or do not ascend.
fn check_times(
    file: &str,
    times: &[f64],
    place: impl Fn(usize) -> String,
) -> Result<(), InputError> {
    for (i, t) in times.iter().enumerate() {
        if !t.is_finite() {
            let cause = "time is NaN or infinite";
            return Err(InputError::new(file, place(i), InputErrorKind::NotFinite, cause));
        }
        if i > 0 && *t <= times[i - 1] {
            let cause = format!("times must ascend, but {t} s follows {} s", times[i - 1]);
            return Err(InputError::new(file, place(i), InputErrorKind::OutOfRange, cause));
        }
    }
    Ok(())
}

/// Times to sample at: the keys' own, or evenly from the first to the last.
fn sample_times(
    file: &str,
    times: &[f64],
    options_rate: Option<f32>,
) -> Result<(f64, Vec<f64>), InputError> {
    let (first, span) = (times[0], times[times.len() - 1] - times[0]);
    if options_rate.is_none()
        && let Some(rate) = even_rate(times)
    {
        return Ok((rate, times.to_vec()));
    }
    let rate = options_rate.map_or(60.0, f64::from);
    let count = (span * rate * (1.0 + 1e-9)).floor() + 1.0;
    if count > MAX_SAMPLES as f64 {
        let cause = format!("{span} s at {rate} Hz are more than {MAX_SAMPLES} samples");
        return Err(InputError::new(file, "", InputErrorKind::OutOfRange, cause));
    }
    Ok((rate, (0..count as u32).map(|i| first + f64::from(i) / rate).collect()))
}

/// The key at or before `t`, and how far `t` is to the next, `0..=1`; 0 of a single key.
fn locate(times: &[f64], t: f64) -> (usize, f32) {
    if times.len() < 2 {
        return (0, 0.0);
    }
    let i = times.partition_point(|&k| k <= t).clamp(1, times.len() - 1) - 1;
    (i, ((t - times[i]) / (times[i + 1] - times[i])).clamp(0.0, 1.0) as f32)
}

/// A quaternion of a file, brought to unit length if it is near.
fn unit(file: &str, place: String, q: Quat) -> Result<Quat, InputError> {
    let length = q.length();
    if !length.is_finite() {
        let cause = "quaternion is NaN or infinite";
        return Err(InputError::new(file, place, InputErrorKind::NotFinite, cause));
    }
    if (length - 1.0).abs() > UNIT_TOLERANCE {
        let cause = format!("quaternion of length {length:.3} is too far from unit length");
        return Err(InputError::new(file, place, InputErrorKind::OutOfRange, cause));
    }
    Ok(q * (1.0 / length))
}
