//! Tables with named columns, from whatever form they had.

use super::{
    ImportOptions, Motion, NoteCode, Notes, TimeUnit, check_times, locate, sample_times, too_few,
    unit,
};
use glam::{EulerRot, Quat, Vec3};
use windfall_core::path::MIN_SAMPLES;
use windfall_core::{InputError, InputErrorKind};

/// Numbers under named columns; the module [`super`] says which are read.
pub(super) struct Table {
    /// Names as they are written.
    pub columns: Vec<String>,
    pub rows: Vec<Vec<f64>>,
    /// Where each row stands.
    pub places: Vec<String>,
}

/// What the columns of a position may be called before `x`, `y` and `z`; the first that is there counts.
const POSITION: [&str; 9] =
    ["", "t", "p", "pos", "position", "loc", "location", "translate", "translation"];
/// The same before `x`, `y`, `z` and `w` of a quaternion.
const QUATERNION: [&str; 6] =
    ["q", "quat", "quaternion", "orient", "orientation", "rotationquaternion"];
/// The same before `x`, `y` and `z` of Euler angles in degrees.
const EULER: [&str; 2] = ["r", "rotate"];
/// Names before a number from 0 (Houdini): `P[0]`, `orient[3]`, in the order x, y, z, w.
const NUMBERED: [&str; 2] = ["p", "orient"];

/// The letters and digits of a name: `P[x]`, `p.x` and `P_x` are `px`.
fn plain(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// Columns of a table by their plain names.
struct Names(Vec<String>);

impl Names {
    fn find(&self, name: &str) -> Option<usize> {
        self.0.iter().position(|c| c == name)
    }

    /// The columns of a vector, all named the same way.
    fn vector<const N: usize>(&self, prefixes: &[&str]) -> Option<[usize; N]> {
        prefixes.iter().find_map(|prefix| {
            let letters = ["x", "y", "z", "w"];
            let by_letter = || self.all(|i| format!("{prefix}{}", letters[i]));
            let by_number = || self.all(|i| format!("{prefix}{i}"));
            by_letter().or_else(|| NUMBERED.contains(prefix).then(by_number).flatten())
        })
    }

    fn all<const N: usize>(&self, name: impl Fn(usize) -> String) -> Option<[usize; N]> {
        let mut found = [0; N];
        for (i, column) in found.iter_mut().enumerate() {
            *column = self.find(&name(i))?;
        }
        Some(found)
    }
}

pub(super) fn read(
    file: &str,
    table: &Table,
    options: &ImportOptions,
    notes: &mut Notes<'_>,
) -> Result<Motion, InputError> {
    let names = Names(table.columns.iter().map(|c| plain(c)).collect());
    let missing = |cause: String| {
        let cause = format!("{cause}; columns are: {}", table.columns.join(", "));
        InputError::new(file, "header", InputErrorKind::Missing, cause)
    };
    let time = ["time", "t"].iter().find_map(|n| names.find(n));
    let frame = ["frame", "frames"].iter().find_map(|n| names.find(n));
    let (time, seconds) = match (time, frame, options.fps) {
        (Some(column), _, _) => (column, options.time_unit.seconds()),
        (None, Some(column), Some(fps)) => (column, 1.0 / f64::from(fps)),
        (None, Some(column), None) => {
            let name = &table.columns[column];
            let cause = format!(
                "no column \"time\", but \"{name}\": give the frames per second with --fps"
            );
            return Err(missing(cause));
        }
        (None, None, _) => return Err(missing("no column \"time\"".into())),
    };
    let xyz: [usize; 3] = names.vector(&POSITION).ok_or_else(|| {
        let letters = ["x", "y", "z"];
        // The kind of which the table has a part.
        let part = POSITION
            .iter()
            .find(|p| letters.iter().any(|l| names.find(&format!("{p}{l}")).is_some()))
            .unwrap_or(&"");
        let name = letters
            .map(|l| format!("{part}{l}"))
            .into_iter()
            .find(|name| names.find(name).is_none())
            .unwrap_or_default();
        missing(format!("no column \"{name}\""))
    })?;
    let quaternion: Option<[usize; 4]> = names.vector(&QUATERNION);
    let euler: Option<[usize; 3]> = names.vector(&EULER);
    let mut used = vec![time];
    used.extend(xyz);
    used.extend(quaternion.into_iter().flatten());
    used.extend(euler.into_iter().flatten());
    let unused: Vec<&str> = (0..table.columns.len())
        .filter(|i| !used.contains(i))
        .map(|i| table.columns[i].as_str())
        .collect();
    if !unused.is_empty() {
        let message = format!("left out: columns {}", unused.join(", "));
        notes.add(NoteCode::ColumnsLeftOut, "", message);
    }

    let times: Vec<f64> = table.rows.iter().map(|r| r[time] * seconds).collect();
    if times.len() < MIN_SAMPLES {
        return Err(too_few(file, "", times.len()));
    }
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
            (Some(columns), _) => Quat::from_array(columns.map(at)),
            (None, Some(columns)) => {
                let [x, y, z] = columns.map(|i| row[i].to_radians() as f32);
                Quat::from_euler(EulerRot::ZYX, z, y, x)
            }
            (None, None) => {
                let cause = "no orientation: columns qx, qy, qz, qw or rx, ry, rz (degrees)";
                return Err(missing(cause.into()));
            }
        };
        orientations.push(unit(file, place.clone(), q)?);
    }
    notes.fast_turns("", times.iter().copied().zip(orientations.iter().copied()));
    let (rate, at) = sample(file, table, &times, options)?;
    let sampled: (Vec<Vec3>, Vec<Quat>) = at
        .iter()
        .map(|&t| {
            let (i, x) = locate(&times, t);
            (positions[i].lerp(positions[i + 1], x), orientations[i].slerp(orientations[i + 1], x))
        })
        .unzip();
    Ok(Motion { rate: rate as f32, positions: sampled.0, orientations: sampled.1 })
}

/// Rate and times to sample at; where no path can have that rate, the error asks for the unit of the times.
fn sample(
    file: &str,
    table: &Table,
    times: &[f64],
    options: &ImportOptions,
) -> Result<(f64, Vec<f64>), InputError> {
    let mean = (times.len() - 1) as f64 / (times[times.len() - 1] - times[0]);
    let place = || format!("{} to {}", table.places[0], table.places[times.len() - 1]);
    // Two digits, however small.
    let hertz = if mean >= 0.01 { format!("{mean:.2}") } else { format!("{mean:.1e}") };
    let question = match options.time_unit {
        TimeUnit::Seconds if mean < 1.0 => "are times in milliseconds? Then give --time-unit ms",
        TimeUnit::Milliseconds if mean > 10_000.0 => {
            "are times in seconds? Then leave out --time-unit ms"
        }
        _ => return sample_times(file, times, options.rate),
    };
    let refuse = |cause: String| InputError::new(file, place(), InputErrorKind::OutOfRange, cause);
    let sampled = sample_times(file, times, options.rate)
        .map_err(|e| refuse(format!("rate {hertz} Hz: {question} ({})", e.cause)))?;
    if (1.0..=10_000.0).contains(&sampled.0) {
        return Ok(sampled);
    }
    Err(refuse(format!("rate {hertz} Hz: {question} (1 to 10000 Hz can be read)")))
}
