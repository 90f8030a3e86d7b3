//! Fall paths: how a leaf moves from its twig to the ground.
//!
//! One short path serves any number of leaves, each with a fall of its own and of any length
//! (P.-P. Vázquez and M. Balsa, "Rendering Falling Leaves on Graphics Hardware", JVRB 5(2), 2008,
//! sections 3 and 4; **VB** below). A [`FallPath`] is a [`Recording`] with its [`Analysis`], which says where
//! leaves may start on it and where playback may jump back; the crate `windfall-flight` simulates, imports and
//! analyses them. A [`PathSet`] lays several out in flat [`tables`] for playback here and on a GPU; and [`Fall`]
//! gives the pose of a leaf at any time, in constant time.
//!
//! ```
//! use windfall_core::path::{Fall, FallSettings, LeafFall, PathSet, Variation};
//! use windfall_core::{forest::Terrain, glam::{Quat, Vec3}, wind::Wind};
//!
//! let paths = PathSet::builtin();
//! let ground = Terrain::flat();
//! let fall = Fall::new(
//!     &paths, &ground, Wind::calm(), Variation::default(), FallSettings::default());
//! let leaf = LeafFall {
//!     origin: Vec3::new(0.0, 12.0, 0.0),
//!     twig_orientation: Quat::IDENTITY,
//!     tree: Vec3::ZERO,
//!     seed: 7,
//!     group: paths.group("birch").unwrap_or(0),
//!     detach_time: 3.0,
//! };
//! let landing = fall.landing(&leaf); // once per leaf
//! let now = fall.pose(&leaf, &landing, 5.5);
//! assert!(now.position.y > 0.0 && now.position.y < 12.0);
//! ```

pub mod analysis;
pub mod format;
pub mod landing;
pub mod playback;
pub mod tables;
pub mod variation;

pub use analysis::{Analysis, Gap, Joint};
pub use landing::{Landing, stack_height};
pub use playback::{Fall, FallSettings, LeafFall, LeafPose, Phase};
pub use tables::{
    Flight, GroupFlights, JointRecord, MAX_FLIGHTS, PathRecord, PathSet, PathTables, Sample,
};
pub use variation::{Edition, Hashed, Variant, Variation};

use crate::error::{InputError, InputErrorKind};
use glam::{Quat, Vec3};

/// Fewest samples of a path.
pub const MIN_SAMPLES: usize = 8;
/// Most samples of a path.
pub const MAX_SAMPLES: usize = 1 << 20;
/// A quaternion whose length is further than this from 1 is refused, not repaired.
pub const UNIT_TOLERANCE: f32 = 0.05;
/// A path must come down by at least this share of the way it goes; leaves come down by half of it.
pub const MIN_DESCENT: f32 = 0.02;

/// Displacement and orientation of a falling leaf at a fixed rate, checked and repaired.
///
/// The first displacement is zero (VB 3.3). Orientations turn the leaf's frame (+Y upper side,
/// +Z petiole to tip) into the world's; each has a positive dot product with the one before, so
/// that they can be interpolated as they are.
///
/// **Rate.** A paper disc of 4.5 cm turns at up to 46 rad/s: 200 samples over 10 s, VB's setting,
/// turn it by more than half a turn from one sample to the next and show something else. Store
/// leaves at 60 Hz or more (44° a sample for that disc), samaras at 120 Hz.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    name: String,
    rate: f32,
    positions: Vec<Vec3>,
    orientations: Vec<Quat>,
}

/// A [`Recording`] with its [`Analysis`]: a path that leaves can fall by, for any time.
#[derive(Debug, Clone, PartialEq)]
pub struct FallPath {
    recording: Recording,
    analysis: Analysis,
}

impl Recording {
    /// Checks samples taken `rate` times a second, and repairs what can be repaired.
    ///
    /// Repairs: positions are taken relative to the first; quaternions within 5% of unit length are
    /// normalised and brought to the same hemisphere.
    ///
    /// # Errors
    ///
    /// Fewer than [`MIN_SAMPLES`] or more than [`MAX_SAMPLES`] samples, different counts, a rate
    /// outside `1..=10000` Hz, a NaN or infinity, a displacement beyond 10 km, a quaternion further
    /// from unit length, or a path that ends less than a millimetre or less than [`MIN_DESCENT`] of its
    /// way below its start. The error's `file` is `name`.
    pub fn new(
        name: impl Into<String>,
        rate: f32,
        mut positions: Vec<Vec3>,
        mut orientations: Vec<Quat>,
    ) -> Result<Self, InputError> {
        use InputErrorKind::{Empty, Malformed, NotFinite, OutOfRange};
        let name = name.into();
        let refuse = |place: String, kind, cause: String| {
            Err(InputError::new(name.clone(), place, kind, cause))
        };
        let n = positions.len();
        if n < MIN_SAMPLES {
            let cause = format!("{n} samples; a fall path needs at least {MIN_SAMPLES}");
            return refuse(String::new(), Empty, cause);
        }
        if n > MAX_SAMPLES {
            return refuse(
                String::new(),
                OutOfRange,
                format!("{n} samples; the limit is {MAX_SAMPLES}"),
            );
        }
        if orientations.len() != n {
            let cause = format!("{n} positions but {} orientations", orientations.len());
            return refuse(String::new(), Malformed, cause);
        }
        if !(1.0..=10_000.0).contains(&rate) {
            return refuse(
                String::new(),
                OutOfRange,
                format!("rate {rate} Hz is outside 1..=10000"),
            );
        }
        let first = positions[0];
        for (i, (p, q)) in positions.iter_mut().zip(&mut orientations).enumerate() {
            if !p.is_finite() || !q.is_finite() {
                return refuse(
                    format!("sample {i}"),
                    NotFinite,
                    "position or orientation is NaN or infinite".into(),
                );
            }
            *p -= first;
            if p.abs().max_element() > 10_000.0 {
                return refuse(
                    format!("sample {i}"),
                    OutOfRange,
                    format!("displacement {p} is beyond 10 km"),
                );
            }
            let length = q.length();
            if (length - 1.0).abs() > UNIT_TOLERANCE {
                return refuse(
                    format!("sample {i}"),
                    OutOfRange,
                    format!("quaternion of length {length:.3} is too far from unit length"),
                );
            }
            *q *= 1.0 / length;
        }
        for i in 1..n {
            if orientations[i].dot(orientations[i - 1]) < 0.0 {
                orientations[i] = -orientations[i];
            }
        }
        let drop = -positions[n - 1].y;
        if drop < 1e-3 {
            let cause = format!(
                "the path does not descend: it ends {:.4} m above its start (is another axis up?)",
                -drop
            );
            return refuse(String::new(), OutOfRange, cause);
        }
        // A leaf that hardly comes down would fly for hours, and the search for its landing as long.
        let way: f32 = positions.windows(2).map(|w| (w[1] - w[0]).length()).sum();
        if drop < MIN_DESCENT * way {
            let cause = format!(
                "the path does not descend: it ends {drop:.4} m below its start after a way of {way:.2} m; \
                 at least {}% are needed",
                MIN_DESCENT * 100.0
            );
            return refuse(String::new(), OutOfRange, cause);
        }
        Ok(Self { name, rate, positions, orientations })
    }

    /// Name of the path, for people and for [`PathSet::group`].
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Samples per second, hertz.
    pub fn rate(&self) -> f32 {
        self.rate
    }

    /// Displacements from the first sample, metres; the first is zero.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// Unit rotations from the leaf's frame into the world's, as many as positions.
    pub fn orientations(&self) -> &[Quat] {
        &self.orientations
    }

    /// Time from the first sample to the last, seconds.
    pub fn duration(&self) -> f32 {
        (self.positions.len() - 1) as f32 / self.rate
    }

    /// Height from the first sample down to the last, metres; above 0.
    pub fn drop(&self) -> f32 {
        -self.positions[self.positions.len() - 1].y
    }

    /// Mean speed of descent, metres per second.
    pub fn descent(&self) -> f32 {
        self.drop() / self.duration()
    }

    /// Velocity at sample `i` by central differences (one-sided at the ends), metres per second.
    pub fn velocity(&self, i: usize) -> Vec3 {
        let (a, b) = self.around(i);
        (self.positions[b] - self.positions[a]) * (self.rate / (b - a) as f32)
    }

    /// Angular velocity at sample `i` in the world's frame: the mean of the turns from the sample
    /// before and to the one after, radians per second.
    pub fn angular_velocity(&self, i: usize) -> Vec3 {
        let (a, b) = self.around(i);
        let turns: Vec3 = (a..b)
            .map(|k| (self.orientations[k + 1] * self.orientations[k].conjugate()).to_scaled_axis())
            .sum();
        turns * (self.rate / (b - a) as f32)
    }

    fn around(&self, i: usize) -> (usize, usize) {
        (i.saturating_sub(1), (i + 1).min(self.positions.len() - 1))
    }
}

impl FallPath {
    /// Puts a recording and its analysis together.
    ///
    /// # Errors
    ///
    /// An analysis that is not of this recording: without starting points or joints, or with one that lies outside
    /// of it, blends over more samples than there are, or does not descend. The error's `file` is the recording's
    /// name.
    pub fn new(recording: Recording, analysis: Analysis) -> Result<Self, InputError> {
        analysis::check(&recording, &analysis)?;
        Ok(Self { recording, analysis })
    }

    /// The samples.
    pub fn recording(&self) -> &Recording {
        &self.recording
    }

    /// Starting points and joints.
    pub fn analysis(&self) -> &Analysis {
        &self.analysis
    }

    /// Name of the path, for people and for [`PathSet::group`].
    pub fn name(&self) -> &str {
        self.recording.name()
    }

    /// The same path under another name.
    pub fn renamed(mut self, name: impl Into<String>) -> Self {
        self.recording.name = name.into();
        self
    }

    /// [`Recording::rate`].
    pub fn rate(&self) -> f32 {
        self.recording.rate()
    }

    /// [`Recording::positions`].
    pub fn positions(&self) -> &[Vec3] {
        self.recording.positions()
    }

    /// [`Recording::orientations`].
    pub fn orientations(&self) -> &[Quat] {
        self.recording.orientations()
    }

    /// [`Recording::duration`].
    pub fn duration(&self) -> f32 {
        self.recording.duration()
    }

    /// [`Recording::drop`].
    pub fn drop(&self) -> f32 {
        self.recording.drop()
    }

    /// [`Recording::descent`].
    pub fn descent(&self) -> f32 {
        self.recording.descent()
    }

    /// [`Recording::velocity`].
    pub fn velocity(&self, i: usize) -> Vec3 {
        self.recording.velocity(i)
    }

    /// [`Recording::angular_velocity`].
    pub fn angular_velocity(&self, i: usize) -> Vec3 {
        self.recording.angular_velocity(i)
    }
}
