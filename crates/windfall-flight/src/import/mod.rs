//! Fall paths from files: glTF animations, tables in CSV, and JSON.
//!
//! Recorded, simulated elsewhere or drawn by hand: whatever gives positions and orientations over
//! time becomes a [`FallPath`] (VB 3.2). Times are seconds and must ascend. Keys at equal distances
//! (within 1%) are taken as they are; others are resampled. What is repaired is said in
//! [`Imported::repairs`]; what cannot be is an [`InputError`] that names file, place and cause.

mod csv;
mod gltf;
mod json;

use crate::fall_path;
use glam::{EulerRot, Quat, Vec3};
use windfall_core::path::{FallPath, MAX_SAMPLES, MIN_SAMPLES, UNIT_TOLERANCE};
use windfall_core::{InputError, InputErrorKind};

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

/// How to read a file.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportOptions {
    /// glTF: name of the animated node. Needed if several are.
    pub node: Option<String>,
    /// The axis that points up.
    pub up: Up,
    /// Metres for each unit of the file; above 0. 0.01 for centimetres.
    pub scale: f32,
    /// Samples per second to resample to; default: the keys' own rate if they are evenly spaced,
    /// otherwise 60 Hz.
    pub rate: Option<f32>,
    /// Name of the path; default: the file's.
    pub name: Option<String>,
}

impl Default for ImportOptions {
    fn default() -> Self {
        Self { node: None, up: Up::Y, scale: 1.0, rate: None, name: None }
    }
}

/// An imported path.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The path, analysed.
    pub path: FallPath,
    /// What was repaired or left out, for people.
    pub repairs: Vec<String>,
}

/// Imports a fall path. The form is told from the bytes, not from the name: glTF (binary, or JSON
/// with `"asset"`), JSON, otherwise CSV.
///
/// # Errors
///
/// Bytes that are of no known form, a missing column or channel, several animated nodes without a
/// name, fewer than [`MIN_SAMPLES`] keys, times that do not ascend, a NaN, a quaternion more than 5%
/// from unit length, and whatever [`fall_path`] refuses.
pub fn import(file: &str, bytes: &[u8], options: &ImportOptions) -> Result<Imported, InputError> {
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
    let mut repairs = Vec::new();
    let text = bytes.trim_ascii_start();
    let mut motion = if bytes.starts_with(b"glTF") {
        gltf::read(file, bytes, options, &mut repairs)?
    } else if text.starts_with(b"{") || text.starts_with(b"[") {
        let value: serde_json::Value = serde_json::from_slice(bytes).map_err(|e| {
            let place = format!("line {}, column {}", e.line(), e.column());
            InputError::new(file, place, InputErrorKind::Malformed, format!("not JSON: {e}"))
        })?;
        if value.get("asset").is_some() {
            gltf::read(file, bytes, options, &mut repairs)?
        } else {
            table(file, &json::read(file, &value)?, options.rate, &mut repairs)?
        }
    } else {
        table(file, &csv::read(file, bytes)?, options.rate, &mut repairs)?
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
    Ok(Imported { path, repairs })
}

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

/// Refuses too few keys, and times that are not numbers or do not ascend.
fn check_times(
    file: &str,
    times: &[f64],
    place: impl Fn(usize) -> String,
) -> Result<(), InputError> {
    if times.len() < MIN_SAMPLES {
        let keys = if times.len() == 1 { "key" } else { "keys" };
        let cause = format!("{} {keys}; a fall path needs at least {MIN_SAMPLES}", times.len());
        return Err(InputError::new(file, "", InputErrorKind::Empty, cause));
    }
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

/// The key at or before `t`, and how far `t` is to the next, `0..=1`. At least two keys.
fn locate(times: &[f64], t: f64) -> (usize, f32) {
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

/// A table with named columns.
///
/// | column | what |
/// |---|---|
/// | `time` or `t` | seconds, ascending |
/// | `x`, `y`, `z` | position |
/// | `qx`, `qy`, `qz`, `qw` | orientation as a unit quaternion, or |
/// | `rx`, `ry`, `rz` | Euler angles in degrees: about X first, then Y, then Z, all fixed axes |
///
/// Case does not matter; other columns are left out.
struct Table {
    columns: Vec<String>,
    rows: Vec<Vec<f64>>,
    /// Where each row stands.
    places: Vec<String>,
}

fn table(
    file: &str,
    table: &Table,
    rate: Option<f32>,
    repairs: &mut Vec<String>,
) -> Result<Motion, InputError> {
    let find = |names: &[&str]| table.columns.iter().position(|c| names.contains(&c.as_str()));
    let need = |names: &[&str]| {
        find(names).ok_or_else(|| {
            let cause = format!("no column \"{}\"", names[0]);
            InputError::new(file, "header", InputErrorKind::Missing, cause)
        })
    };
    let time = need(&["time", "t"])?;
    let xyz = [need(&["x"])?, need(&["y"])?, need(&["z"])?];
    let quaternion = [find(&["qx"]), find(&["qy"]), find(&["qz"]), find(&["qw"])];
    let euler = [find(&["rx"]), find(&["ry"]), find(&["rz"])];
    let mut used = vec![time];
    used.extend(xyz);
    used.extend(quaternion.iter().chain(&euler).flatten());
    let unused: Vec<&str> = (0..table.columns.len())
        .filter(|i| !used.contains(i))
        .map(|i| table.columns[i].as_str())
        .collect();
    if !unused.is_empty() {
        repairs.push(format!("left out: columns {}", unused.join(", ")));
    }

    let times: Vec<f64> = table.rows.iter().map(|r| r[time]).collect();
    check_times(file, &times, |i| table.places[i].clone())?;
    let (mut positions, mut orientations) = (Vec::new(), Vec::new());
    for (row, place) in table.rows.iter().zip(&table.places) {
        let at = |i: usize| row[i] as f32;
        let p = Vec3::from(xyz.map(at));
        if !p.is_finite() {
            let cause = "position is NaN or infinite";
            return Err(InputError::new(file, place, InputErrorKind::NotFinite, cause));
        }
        positions.push(p);
        let q = match (quaternion, euler) {
            ([Some(x), Some(y), Some(z), Some(w)], _) => {
                Quat::from_xyzw(at(x), at(y), at(z), at(w))
            }
            (_, [Some(x), Some(y), Some(z)]) => {
                let [x, y, z] = [x, y, z].map(|i| row[i].to_radians() as f32);
                Quat::from_euler(EulerRot::ZYX, z, y, x)
            }
            _ => {
                let cause = "no orientation: columns qx, qy, qz, qw or rx, ry, rz (degrees)";
                return Err(InputError::new(file, "header", InputErrorKind::Missing, cause));
            }
        };
        orientations.push(unit(file, place.clone(), q)?);
    }
    let (rate, at) = sample_times(file, &times, rate)?;
    let sampled: (Vec<Vec3>, Vec<Quat>) = at
        .iter()
        .map(|&t| {
            let (i, x) = locate(&times, t);
            (positions[i].lerp(positions[i + 1], x), orientations[i].slerp(orientations[i + 1], x))
        })
        .unzip();
    Ok(Motion { rate: rate as f32, positions: sampled.0, orientations: sampled.1 })
}
