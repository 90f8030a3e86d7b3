//! The binary form of path sets, little-endian throughout:
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `"WFPATHS"` and a zero |
//! | u32 | version, 1 |
//! | u32 | number of paths |
//!
//! and for each path
//!
//! | bytes | what |
//! |---|---|
//! | u32, n | length of the name, the name in UTF-8 |
//! | f32 | rate, hertz |
//! | u32, u32, u32 | number of samples, starting points, joints |
//! | 3 × f32 each | displacements, metres |
//! | 4 × i16 each | quaternions x, y, z, w, in units of 1/32767 |
//! | u32 each | starting points |
//! | 4 × u32, 8 × f32 each | joints: from, to, blend, half turn; gaps raw and blended |

use super::analysis::{Gap, Joint};
use super::{Analysis, FallPath, MAX_SAMPLES, PathSet, Recording};
use crate::error::{InputError, InputErrorKind};
use glam::{Quat, Vec3};

/// What a binary path set begins with.
pub const MAGIC: &[u8; 8] = b"WFPATHS\0";
/// The version that is read and written.
pub const VERSION: u32 = 1;

pub(super) fn read(file: &str, bytes: &[u8]) -> Result<PathSet, InputError> {
    let Some(rest) = bytes.strip_prefix(MAGIC) else {
        let cause = "not a binary path set: it would begin with \"WFPATHS\"";
        return Err(InputError::new(file, "", InputErrorKind::Malformed, cause));
    };
    PathSet::new(read_paths(file, rest)?).map_err(|e| InputError { file: file.into(), ..e })
}

fn named(file: &str, index: usize, error: InputError) -> InputError {
    let place = if error.place.is_empty() { String::new() } else { format!(", {}", error.place) };
    InputError { file: file.into(), place: format!("path {index}{place}"), ..error }
}

fn check_version(file: &str, version: u32) -> Result<(), InputError> {
    if version == VERSION {
        return Ok(());
    }
    let cause = format!("version {version}; this program reads version {VERSION}");
    Err(InputError::new(file, "", InputErrorKind::Unsupported, cause))
}

/// Reads little-endian numbers from the front of a slice.
struct Reader<'a> {
    file: &'a str,
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    fn bytes(&mut self, n: usize) -> Result<&'a [u8], InputError> {
        let Some((head, rest)) = self.rest.split_at_checked(n) else {
            let cause = format!("truncated: {n} bytes wanted, {} left", self.rest.len());
            return Err(InputError::new(self.file, "", InputErrorKind::Malformed, cause));
        };
        self.rest = rest;
        Ok(head)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], InputError> {
        let mut out = [0; N];
        out.copy_from_slice(self.bytes(N)?);
        Ok(out)
    }

    fn u32(&mut self) -> Result<u32, InputError> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    fn f32(&mut self) -> Result<f32, InputError> {
        Ok(f32::from_le_bytes(self.array()?))
    }

    fn i16(&mut self) -> Result<i16, InputError> {
        Ok(i16::from_le_bytes(self.array()?))
    }

    /// A count of things of `size` bytes each, all of which must be there: nothing is allocated for
    /// a number that the file only claims.
    fn count(&mut self, size: usize, what: &str) -> Result<usize, InputError> {
        let n = self.u32()? as usize;
        if n > MAX_SAMPLES || n.saturating_mul(size) > self.rest.len() {
            let cause = format!("claims {n} {what}, more than the file holds");
            return Err(InputError::new(self.file, "", InputErrorKind::OutOfRange, cause));
        }
        Ok(n)
    }
}

fn read_paths(file: &str, bytes: &[u8]) -> Result<Vec<FallPath>, InputError> {
    let mut r = Reader { file, rest: bytes };
    check_version(file, r.u32()?)?;
    let count = r.count(20, "paths")?;
    let mut paths = Vec::with_capacity(count);
    for i in 0..count {
        let length = r.count(1, "bytes of name")?;
        let name = String::from_utf8(r.bytes(length)?.to_vec()).map_err(|_| {
            let cause = "the name is not UTF-8";
            InputError::new(file, format!("path {i}"), InputErrorKind::Malformed, cause)
        })?;
        let rate = r.f32()?;
        let samples = r.count(20, "samples")?;
        let starts = r.count(4, "starting points")?;
        let joints = r.count(48, "continuity points")?;
        let mut positions = Vec::with_capacity(samples);
        for _ in 0..samples {
            positions.push(Vec3::new(r.f32()?, r.f32()?, r.f32()?));
        }
        let mut orientations = Vec::with_capacity(samples);
        for _ in 0..samples {
            let q = [r.i16()?, r.i16()?, r.i16()?, r.i16()?];
            orientations.push(Quat::from_array(q.map(|v| f32::from(v) / 32767.0)));
        }
        let mut analysis = Analysis::default();
        for _ in 0..starts {
            analysis.starts.push(r.u32()?);
        }
        for _ in 0..joints {
            let [from, to, blend, half_turn] = [r.u32()?, r.u32()?, r.u32()?, r.u32()?];
            let mut gaps = [Gap::default(); 2];
            for gap in &mut gaps {
                gap.position = r.f32()?;
                gap.velocity = r.f32()?;
                gap.orientation = r.f32()?;
                gap.angular_velocity = r.f32()?;
            }
            let [raw, blended] = gaps;
            analysis.joints.push(Joint { from, to, blend, half_turn, raw, blended });
        }
        paths.push(
            Recording::new(name, rate, positions, orientations)
                .and_then(|recording| FallPath::new(recording, analysis))
                .map_err(|e| named(file, i, e))?,
        );
    }
    if !r.rest.is_empty() {
        let cause = format!("{} bytes after the end", r.rest.len());
        return Err(InputError::new(file, "", InputErrorKind::Malformed, cause));
    }
    Ok(paths)
}

pub(super) fn to_bytes(set: &PathSet) -> Vec<u8> {
    let mut out = MAGIC.to_vec();
    let u32s = |out: &mut Vec<u8>, values: &[u32]| {
        for v in values {
            out.extend_from_slice(&v.to_le_bytes());
        }
    };
    let f32s = |out: &mut Vec<u8>, values: &[f32]| {
        for v in values {
            out.extend_from_slice(&v.to_le_bytes());
        }
    };
    u32s(&mut out, &[VERSION, set.paths().len() as u32]);
    for path in set.paths() {
        let analysis = path.analysis();
        u32s(&mut out, &[path.name().len() as u32]);
        out.extend_from_slice(path.name().as_bytes());
        f32s(&mut out, &[path.rate()]);
        let counts = [path.positions().len(), analysis.starts.len(), analysis.joints.len()];
        u32s(&mut out, &counts.map(|n| n as u32));
        for p in path.positions() {
            f32s(&mut out, &p.to_array());
        }
        for q in path.orientations() {
            for v in q.to_array() {
                out.extend_from_slice(&((v * 32767.0).round() as i16).to_le_bytes());
            }
        }
        u32s(&mut out, &analysis.starts);
        for j in &analysis.joints {
            u32s(&mut out, &[j.from, j.to, j.blend, j.half_turn]);
            for g in [j.raw, j.blended] {
                f32s(&mut out, &[g.position, g.velocity, g.orientation, g.angular_velocity]);
            }
        }
    }
    out
}
