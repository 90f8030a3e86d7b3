//! Several paths as flat arrays, the same for playback here and on a GPU.
//!
//! All samples stand in one list: those of the first path, then for each of its joints the *tail*,
//! the samples that lead into the joint; then the next path's. (VB keep their continuity information
//! "at the end of the texture" as well.) A fall that uses joint `j` reads sample `i` from the path
//! while `i < j.blend_start`, and from the tail of `j` from there on ([`PathTables::index`]).

use super::{FallPath, Joint, format};
use crate::error::{InputError, InputErrorKind};
use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec3};

/// One sample, 32 bytes: two texels.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Sample {
    /// Displacement from the path's first sample, metres.
    pub position: [f32; 3],
    /// Lower bound of the curve's height up to this sample, metres; never increases.
    pub low: f32,
    /// Unit rotation from the leaf's frame into the world's: x, y, z, w.
    pub orientation: [f32; 4],
}

/// Where a path's data stand, 32 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct PathRecord {
    /// Index of the first sample in [`PathTables::samples`].
    pub first_sample: u32,
    /// Index of the first starting point in [`PathTables::starts`].
    pub first_start: u32,
    /// Number of starting points, at least 1.
    pub start_count: u32,
    /// Index of the first joint in [`PathTables::joints`].
    pub first_joint: u32,
    /// Number of joints, at least 1.
    pub joint_count: u32,
    /// Samples per second.
    pub rate: f32,
    /// Upper bound of the downward speed, metres per second.
    pub fastest_down: f32,
    /// Upper bound of the horizontal speed, metres per second.
    pub fastest_along: f32,
}

/// A joint, 32 bytes. See [`Joint`].
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct JointRecord {
    /// Displacement of one lap, `path[from] - path[to]`, metres; Y is below 0.
    pub lap: [f32; 3],
    /// Half of the turn about Y of each lap, in 2⁻³² turns.
    pub half_turn: u32,
    /// Sample that is left.
    pub from: u32,
    /// Sample that is entered.
    pub to: u32,
    /// First sample that is read from the tail.
    pub blend_start: u32,
    /// Index in [`PathTables::samples`] of the tail's first sample.
    pub tail: u32,
}

/// A way to fall: a path, the joint that it laps by, and where it begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Flight {
    /// Index into [`PathTables::paths`].
    pub path: u32,
    /// Index into [`PathTables::joints`].
    pub joint: u32,
    /// Sample at which the fall begins.
    pub start: u32,
}

/// The flights of a group: a range of [`PathTables::flights`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GroupFlights {
    /// Index of the first.
    pub first: u32,
    /// How many, at least 1.
    pub count: u32,
    /// How many of the first path and its first joint, at least 1: they stand in front.
    pub plain: u32,
}

/// Flat arrays of a [`PathSet`], ready for upload.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PathTables {
    /// What positions of samples are multiples of, metres: a power of two, so that a sample packed
    /// into whole numbers of 21 bits is the same sample. 0: they are as the path has them.
    pub grain: f32,
    /// All samples: orientations are multiples of 1/32767.
    pub samples: Vec<Sample>,
    /// Starting points, as sample numbers of their path.
    pub starts: Vec<u32>,
    /// All joints.
    pub joints: Vec<JointRecord>,
    /// One record for each path.
    pub paths: Vec<PathRecord>,
    /// For each group, index of its first path and number of paths.
    pub groups: Vec<[u32; 2]>,
    /// The ways to fall, group by group: every joint of a path with every starting point, evenly
    /// thinned out where a path's share of [`MAX_FLIGHTS`] is less.
    pub flights: Vec<Flight>,
    /// For each group its flights.
    pub group_flights: Vec<GroupFlights>,
}

/// Most flights of a set, so that a number of 14 bits names one; and most paths.
pub const MAX_FLIGHTS: u32 = 1 << 14;

/// Position on the curve of one path, before any variation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// Displacement from the path's first sample, metres.
    pub position: Vec3,
    /// Unit rotation from the leaf's frame into the world's.
    pub orientation: Quat,
    /// Lower bound of the height so far, metres.
    pub low: f32,
}

impl PathTables {
    /// The tables of one path, its positions as they are ([`Self::grain`] 0). They have no groups and no flights:
    /// for measuring the path's curve.
    pub fn of_path(path: &FallPath) -> Self {
        let mut tables = Self::default();
        tables.push(path);
        tables
    }

    fn push(&mut self, path: &FallPath) {
        let first_sample = self.samples.len() as u32;
        let positions: Vec<Vec3> = path.positions().iter().map(|p| self.snapped(*p)).collect();
        let heights: Vec<f32> = positions.iter().map(|p| p.y).collect();
        let mut low = 0.0f32;
        for (i, (p, q)) in positions.iter().zip(path.orientations()).enumerate() {
            if i > 0 {
                low = low.min(lowest(&heights, i - 1));
            }
            let (position, orientation) = (p.to_array(), packable(*q));
            self.samples.push(Sample { position, low, orientation });
        }
        let (first_start, first_joint) = (self.starts.len() as u32, self.joints.len() as u32);
        self.starts.extend_from_slice(&path.analysis().starts);
        for joint in &path.analysis().joints {
            let tail = self.samples.len() as u32;
            self.push_tail(path, &positions, first_sample, joint);
            let (from, to) = (joint.from as usize, joint.to as usize);
            self.joints.push(JointRecord {
                lap: (positions[from] - positions[to]).to_array(),
                half_turn: joint.half_turn,
                from: joint.from,
                to: joint.to,
                blend_start: joint.from - joint.blend,
                tail,
            });
        }
        // The slope of a Catmull-Rom cubic is at most twice the largest chord it is made of:
        // 3/2 of its own and 1/4 of the tangent at either end.
        let (mut down, mut along) = (0.0f32, 0.0f32);
        let mut measure = |samples: &[Sample], before: Option<&Sample>| {
            for (a, b) in
                before.into_iter().chain(samples).zip(samples.iter().skip(before.map_or(1, |_| 0)))
            {
                let step = Vec3::from(b.position) - Vec3::from(a.position);
                down = down.max(-step.y);
                along = along.max(step.with_y(0.0).length());
            }
        };
        let main = &self.samples[first_sample as usize..][..path.positions().len()];
        measure(main, None);
        for joint in &self.joints[first_joint as usize..] {
            let length = (joint.from + 2 - joint.blend_start) as usize;
            let tail = &self.samples[joint.tail as usize..][..length];
            measure(tail, Some(&main[joint.blend_start as usize - 1]));
        }
        self.paths.push(PathRecord {
            first_sample,
            first_start,
            start_count: path.analysis().starts.len() as u32,
            first_joint,
            joint_count: path.analysis().joints.len() as u32,
            rate: path.rate(),
            fastest_down: (down * 2.0 * path.rate()).max(1e-3),
            fastest_along: along * 2.0 * path.rate(),
        });
    }

    /// The smallest grain for which twice these displacements are below 2²⁰ grains.
    fn set_grain(&mut self, paths: &[FallPath]) {
        let sizes = paths.iter().flat_map(FallPath::positions).map(|p| p.abs().max_element());
        let largest = sizes.fold(1e-3, f32::max);
        self.grain = (2.0 * largest / ((1 << 20) - 2) as f32).log2().ceil().exp2();
    }

    fn snapped(&self, p: Vec3) -> Vec3 {
        if self.grain > 0.0 { (p / self.grain).round() * self.grain } else { p }
    }

    fn list_flights(&mut self) {
        let most = MAX_FLIGHTS / self.paths.len() as u32;
        for &[first_path, count] in &self.groups {
            let first = self.flights.len() as u32;
            let mut plain = 0;
            for path in first_path..first_path + count {
                let record = &self.paths[path as usize];
                let all = record.joint_count * record.start_count;
                let kept = all.min(most);
                for i in (0..kept).map(|i| (u64::from(i) * u64::from(all) / u64::from(kept)) as u32)
                {
                    let joint = record.first_joint + i / record.start_count;
                    let start = self.starts[(record.first_start + i % record.start_count) as usize];
                    self.flights.push(Flight { path, joint, start });
                    plain += u32::from(path == first_path && joint == record.first_joint);
                }
            }
            let count = self.flights.len() as u32 - first;
            self.group_flights.push(GroupFlights { first, count, plain });
        }
    }

    /// The samples `from - blend ..= from + 1` on the way into a joint.
    ///
    /// They fade from the path's own into those that lead to `to`, turned by the joint and shifted so
    /// that the two meet at `from`: the lap's displacement stays `path[from] - path[to]`. The last
    /// three are entirely the continuation's, so that the cubic through them has the same velocity
    /// and angular velocity on both sides of the jump.
    fn push_tail(&mut self, path: &FallPath, positions: &[Vec3], first_sample: u32, joint: &Joint) {
        let orientations = path.orientations();
        let (from, to, blend) = (joint.from as usize, joint.to as usize, joint.blend as usize);
        let turn = joint.rotation();
        let offset = positions[from] - turn * positions[to];
        let before = first_sample as usize + from - blend - 1;
        let mut previous = Quat::from_array(self.samples[before].orientation);
        let own = |i: usize| i.min(positions.len() - 1);
        // From each sample's own orientation to the continuation's, found backwards from the joint, where
        // the two are near: what is between them may grow past half a turn and has to stay the same way
        // round, or the leaf would flip over in one sample.
        let mut to_continuation: Vec<Quat> = Vec::with_capacity(blend + 2);
        for i in (from - blend..=from + 1).rev() {
            let between = turn * orientations[to + i - from] * orientations[own(i)].conjugate();
            let after = to_continuation.last().copied().unwrap_or(Quat::IDENTITY);
            to_continuation.push(if between.dot(after) < 0.0 { -between } else { between });
        }
        for i in from - blend..=from + 1 {
            let x = (i + blend - from) as f32 / (blend - 1).max(1) as f32;
            let w = if i + 1 >= from { 1.0 } else { x * x * (3.0 - 2.0 * x) };
            let c = to + i - from; // at least 0: blend <= to
            let own = own(i);
            let position = self.snapped(positions[own].lerp(offset + turn * positions[c], w));
            let between = to_continuation[from + 1 - i];
            let mut orientation = (part_of(between, w) * orientations[own]).normalize();
            if orientation.dot(previous) < 0.0 {
                orientation = -orientation;
            }
            previous = orientation;
            self.samples.push(Sample {
                position: position.to_array(),
                low: 0.0,
                orientation: packable(orientation),
            });
        }
        // Heights as this fall reads them: two samples of the path, then the tail.
        let tail = self.samples.len() - (blend + 2);
        let context = before.saturating_sub(1).max(first_sample as usize)..=before;
        let lead = context.clone().count();
        let heights: Vec<f32> =
            context.chain(tail..self.samples.len()).map(|i| self.samples[i].position[1]).collect();
        let mut low = self.samples[before].low;
        // The curve into the path's own last sample already bends towards the tail.
        if lead == 2 {
            low = low.min(lowest(&heights, 0));
        }
        for k in 0..blend + 2 {
            low = low.min(lowest(&heights, lead - 1 + k));
            self.samples[tail + k].low = low;
        }
    }

    /// Index in [`PathTables::samples`] of sample `i` of a path, for a fall that uses `joint`;
    /// `i` may be up to `joint.from + 1`.
    pub fn index(path: &PathRecord, joint: &JointRecord, i: u32) -> usize {
        (if i < joint.blend_start {
            path.first_sample + i
        } else {
            joint.tail + i - joint.blend_start
        }) as usize
    }

    /// The curve at sample `u`, `0..=joint.from`, on the way to `joint`: a Catmull-Rom cubic through
    /// the displacements, and through the quaternions as four numbers, brought back to unit length.
    /// Both have continuous first derivatives.
    pub fn curve(&self, path: &PathRecord, joint: &JointRecord, u: f32) -> CurvePoint {
        let i = (u as u32).min(joint.from - 1);
        let x = u - i as f32;
        let s = self.around(path, joint, i);
        let (position, orientation) = combine(&s, weights(x));
        CurvePoint {
            position: Vec3::from(s[1].position) + position,
            orientation: orientation * (1.0 / orientation.length().max(1e-3)),
            low: s[1].low + (s[2].low - s[1].low) * x,
        }
    }

    /// Samples `i - 1` to `i + 2`, the first repeated at the path's beginning.
    fn around(&self, path: &PathRecord, joint: &JointRecord, i: u32) -> [&Sample; 4] {
        [i.saturating_sub(1), i, i + 1, i + 2].map(|i| &self.samples[Self::index(path, joint, i)])
    }

    /// Velocity (metres) and angular velocity (radians, about the world's axes) of the curve, per sample, between
    /// samples `i` and `i + 1` at `x` in `0..=1`.
    pub fn motion(&self, path: &PathRecord, joint: &JointRecord, i: u32, x: f32) -> (Vec3, Vec3) {
        let s = self.around(path, joint, i);
        let (_, q) = combine(&s, weights(x));
        let (v, dq) = combine(&s, weight_rates(x));
        let spin = (dq * q.conjugate()).xyz() * (2.0 / q.length_squared().max(1e-6));
        (v, spin)
    }
}

/// A part of a rotation, the way round that its quaternion's sign says: of up to a whole turn.
fn part_of(q: Quat, part: f32) -> Quat {
    let sine = q.xyz().length();
    let half = sine.atan2(q.w) * part;
    Quat::from_vec4((q.xyz() * (half.sin() / sine.max(1e-9))).extend(half.cos()))
}

/// A rotation as multiples of 1/32767.
fn packable(q: Quat) -> [f32; 4] {
    q.to_array().map(|c| (c * 32767.0).round() / 32767.0)
}

/// Weighted sums of four samples: displacement from the second, and quaternion.
fn combine(s: &[&Sample; 4], w: [f32; 4]) -> (Vec3, Quat) {
    // From the nearer sample: no digits are lost to the size of the displacement.
    let near = Vec3::from(s[1].position);
    let p = |k: usize| (Vec3::from(s[k].position) - near) * w[k];
    let q = |k: usize| Quat::from_array(s[k].orientation) * w[k];
    (p(0) + p(2) + p(3), q(0) + q(1) + q(2) + q(3))
}

/// Lower bound of the cubic's height between samples `i` and `i + 1`: the lowest control point of its
/// Bézier form.
fn lowest(heights: &[f32], i: usize) -> f32 {
    let last = heights.len() - 1;
    let h = |k: usize| heights[k.min(last)];
    let (a, b, c, d) = (h(i.saturating_sub(1)), h(i), h(i + 1), h(i + 2));
    b.min(c).min(b + (c - a) / 6.0).min(c - (d - b) / 6.0)
}

/// Weights of four successive samples in the Catmull-Rom cubic between the middle two.
fn weights(x: f32) -> [f32; 4] {
    let (x2, x3) = (x * x, x * x * x);
    [
        0.5 * (-x + 2.0 * x2 - x3),
        0.5 * (2.0 - 5.0 * x2 + 3.0 * x3),
        0.5 * (x + 4.0 * x2 - 3.0 * x3),
        0.5 * (x3 - x2),
    ]
}

/// Derivatives of [`weights`].
fn weight_rates(x: f32) -> [f32; 4] {
    let x2 = x * x;
    [
        0.5 * (-1.0 + 4.0 * x - 3.0 * x2),
        0.5 * (-10.0 * x + 9.0 * x2),
        0.5 * (1.0 + 8.0 * x - 9.0 * x2),
        0.5 * (3.0 * x2 - 2.0 * x),
    ]
}

/// Paths that leaves fall by, in named groups: a group for each species, or one for all.
#[derive(Debug, Clone, PartialEq)]
pub struct PathSet {
    paths: Vec<FallPath>,
    groups: Vec<String>,
    tables: PathTables,
}

impl PathSet {
    /// A set of paths; those of the same name form a group, in the order of first appearance.
    ///
    /// # Errors
    ///
    /// If there are no paths, or more than [`MAX_FLIGHTS`].
    pub fn new(paths: Vec<FallPath>) -> Result<Self, InputError> {
        let mut groups: Vec<String> = Vec::new();
        let mut members: Vec<Vec<FallPath>> = Vec::new();
        for path in paths {
            if let Some(i) = groups.iter().position(|g| g == path.name()) {
                members[i].push(path);
            } else {
                groups.push(path.name().into());
                members.push(vec![path]);
            }
        }
        if groups.is_empty() {
            let cause = "a path set needs at least one path";
            return Err(InputError::new("path set", "", InputErrorKind::Empty, cause));
        }
        let count: usize = members.iter().map(Vec::len).sum();
        if count > MAX_FLIGHTS as usize {
            let cause = format!("{count} paths; the limit is {MAX_FLIGHTS}");
            return Err(InputError::new("path set", "", InputErrorKind::OutOfRange, cause));
        }
        let mut tables = PathTables::default();
        let mut first = 0;
        for group in &members {
            tables.groups.push([first, group.len() as u32]);
            first += group.len() as u32;
        }
        let sorted: Vec<FallPath> = members.into_iter().flatten().collect();
        tables.set_grain(&sorted);
        for path in &sorted {
            tables.push(path);
        }
        tables.list_flights();
        Ok(Self { paths: sorted, groups, tables })
    }

    /// The paths that come with the library: a group for each built-in species, and `"ash"` and `"samara"`. Simulated
    /// by `windfall-flight` once and kept in the binary (about 140 KB).
    pub fn builtin() -> Self {
        /// Made by `windfall path simulate --builtin --out crates/windfall-core/assets/paths.bin`; a test of
        /// `windfall-flight` simulates one of them again.
        const BYTES: &[u8] = include_bytes!("../../assets/paths.bin");
        match Self::read("built-in paths", BYTES) {
            Ok(set) => set,
            Err(error) => unreachable!("the asset is tested: {error}"),
        }
    }

    /// Number of the group called `name`.
    pub fn group(&self, name: &str) -> Option<u32> {
        self.groups.iter().position(|g| g == name).map(|i| i as u32)
    }

    /// Names of the groups.
    pub fn groups(&self) -> &[String] {
        &self.groups
    }

    /// All paths, group by group.
    pub fn paths(&self) -> &[FallPath] {
        &self.paths
    }

    /// The paths as flat arrays.
    pub fn tables(&self) -> &PathTables {
        &self.tables
    }

    /// Reads a path set in binary form; `file` is its name for messages. `windfall_flight::read_paths` reads RON as
    /// well.
    ///
    /// # Errors
    ///
    /// Bytes that are not a binary path set, of another version, truncated or followed by more; and
    /// whatever [`super::Recording::new`] and [`FallPath::new`] refuse.
    pub fn read(file: &str, bytes: &[u8]) -> Result<Self, InputError> {
        format::read(file, bytes)
    }

    /// The binary form: little-endian, orientations to 1/32767. See [`mod@format`].
    pub fn to_bytes(&self) -> Vec<u8> {
        format::to_bytes(self)
    }
}
