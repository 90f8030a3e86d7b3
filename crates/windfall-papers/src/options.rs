//! Which published method draws falling leaves.

use std::fmt;
use std::str::FromStr;
use windfall_gpu::UnknownName;

/// Where the pose of a falling leaf is computed: the three methods of P.-P. Vázquez and M. Balsa, "Rendering Falling
/// Leaves on Graphics Hardware", JVRB 5(2), 2008 (VB), section 6.
///
/// All give the picture of the renderer's own compute path. They need no compute shader: the list of active leaves is
/// kept on the CPU, which takes a few tens of microseconds for each leaf that detaches ([`LandingSearch::Ahead`]); a
/// jump in time rebuilds the list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Strategy {
    /// In the vertex shader, once per vertex (VB 6, first).
    Vertex,
    /// In a fragment shader, once per leaf, into textures that the vertex shader reads (VB 6.1).
    Fragment,
    /// In a fragment shader, once per leaf vertex, into textures that are copied to vertex buffers (VB 6.2).
    VertexBuffer,
    /// On the CPU, once per leaf, uploaded in every frame: what VB 6.3 compares with.
    Cpu,
}

impl Strategy {
    /// All of them, in the paper's order.
    pub const ALL: [Self; 4] = [Self::Vertex, Self::Fragment, Self::VertexBuffer, Self::Cpu];

    /// Its name on command lines and in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Vertex => "vertex",
            Self::Fragment => "fragment",
            Self::VertexBuffer => "vertex-buffer",
            Self::Cpu => "cpu",
        }
    }
}

impl fmt::Display for Strategy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Strategy {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        Self::ALL
            .into_iter()
            .find(|s| s.name() == name)
            .ok_or_else(|| UnknownName::new("strategy", name, &Self::ALL.map(Self::name)))
    }
}

/// Who looks for the place where a leaf lands. Pictures do not depend on it, the time they take does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum LandingSearch {
    /// The CPU, once, when the leaf detaches. The default.
    #[default]
    Ahead,
    /// As in VB 5: the shader, in every frame, for every active leaf that may have reached the ground; a leaf costs
    /// more once it lies, until it is eliminated. Leaves that lie count as falling until then, and none of those in the
    /// air is drawn in two triangles. [`Elimination::Scheduled`] and [`Strategy::Cpu`] search ahead all the same.
    InShader,
}

/// Where [`Strategy::Vertex`] reads the samples of paths; the other strategies read [`PathData::Table`]. Pictures do not
/// depend on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum PathData {
    /// With all other tables in one two-dimensional texture, a texel of whole numbers for each sample. The default.
    #[default]
    Table,
    /// As in VB 3.3: in two one-dimensional textures, positions and orientations, a texel of `f32` for each sample. Paths
    /// may have as many samples together as such a texture texels, 8192 on most devices; a path counts once for each of
    /// its continuity points. The built-in set has more. Orientations are quaternions; VB has angles.
    OneDimensional,
}

/// Leaves in the air that are not seen are skipped for some frames (leaf occlusion, VB 5).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LeafOcclusion {
    /// One of so many leaves that are seen is tested in a frame, 1 to 8. VB 2008: a third of the leaves, so 3, the
    /// default; half of them in its figures.
    pub one_in: u32,
    /// Frames for which a leaf that is not seen is skipped, 1 to 7. VB: 2 to 4; default 3.
    pub skip: u32,
    /// Pixels from which on a leaf is seen, 1 to 1000. VB 2008: 3, the default.
    pub pixels: u32,
}

impl Default for LeafOcclusion {
    fn default() -> Self {
        Self { one_in: 3, skip: 3, pixels: 3 }
    }
}

impl LeafOcclusion {
    /// The nearest that the shaders can do.
    pub(crate) fn clamped(self) -> Self {
        Self {
            one_in: self.one_in.clamp(1, 8),
            skip: self.skip.clamp(1, 7),
            pixels: self.pixels.clamp(1, 1000),
        }
    }
}

/// What the pipelines of a strategy are built for: [`crate::PublishedPasses::new`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PassOptions {
    /// Where poses are computed.
    pub strategy: Strategy,
    /// Who looks for landings.
    pub landing: LandingSearch,
    /// Where samples of paths are read.
    pub paths: PathData,
    /// Leaf occlusion, if leaves are skipped. It needs fragment shaders that store.
    pub occlusion: Option<LeafOcclusion>,
}

impl PassOptions {
    /// Whether samples of paths are read from one-dimensional textures.
    pub(crate) fn one_dimensional(self) -> bool {
        self.strategy == Strategy::Vertex && self.paths == PathData::OneDimensional
    }

    /// A strategy with landings searched ahead, without leaf occlusion.
    pub fn new(strategy: Strategy) -> Self {
        Self { strategy, landing: LandingSearch::Ahead, paths: PathData::Table, occlusion: None }
    }
}

/// When a landed leaf leaves the list of active leaves and becomes static geometry (leaf elimination, VB 5). Pictures
/// do not depend on it, the time they take does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Elimination {
    /// Never: every detached leaf is posed in each frame, as in VB before section 5.
    Off,
    /// As in VB: each frame tests some leaves on the CPU, those first that have been due longest. A leaf is due two
    /// seconds after it detached (VB), or when it should have come down as fast as in these two seconds, if that is
    /// later; one that is still in the air is due again when it should have come down as fast as so far.
    Progressive {
        /// Leaves tested in a frame; VB: 10 to 20.
        per_frame: u32,
    },
    /// At the moment of landing, which is known from the start. The default.
    #[default]
    Scheduled,
}

impl Elimination {
    /// VB's, with 20 leaves a frame.
    pub const PROGRESSIVE: Self = Self::Progressive { per_frame: 20 };
    /// One of each kind.
    pub const ALL: [Self; 3] = [Self::Off, Self::PROGRESSIVE, Self::Scheduled];

    /// Its name on command lines and in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Progressive { .. } => "progressive",
            Self::Scheduled => "scheduled",
        }
    }
}

impl fmt::Display for Elimination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Elimination {
    type Err = UnknownName;

    /// `progressive` tests 20 leaves a frame.
    fn from_str(name: &str) -> Result<Self, UnknownName> {
        Self::ALL
            .into_iter()
            .find(|e| e.name() == name)
            .ok_or_else(|| UnknownName::new("elimination", name, &Self::ALL.map(Self::name)))
    }
}

/// How the lists of leaves are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ListOptions {
    /// Most leaves in the air and on the ground together, as [`windfall_gpu::Falls::capacity`]: beyond it those that
    /// have lain longest vanish. Default 1,000,000.
    pub capacity: u32,
    /// When landed leaves become static geometry.
    pub elimination: Elimination,
}

impl Default for ListOptions {
    fn default() -> Self {
        let capacity = windfall_gpu::Falls::default().capacity;
        Self { capacity, elimination: Elimination::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
        for strategy in Strategy::ALL {
            assert_eq!(strategy.to_string().parse(), Ok(strategy));
        }
        for elimination in Elimination::ALL {
            assert_eq!(elimination.to_string().parse(), Ok(elimination));
        }
        let error = "gpu".parse::<Strategy>().unwrap_err().to_string();
        assert!(error.contains("\"gpu\"") && error.contains("vertex-buffer"), "{error}");
    }
}
