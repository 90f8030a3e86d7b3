//! Which published method draws falling leaves.

use std::fmt;
use std::str::FromStr;
use windfall_gpu::UnknownName;

/// Where the pose of a falling leaf is computed: the three methods of P.-P. Vázquez and M. Balsa, "Rendering Falling
/// Leaves on Graphics Hardware", JVRB 5(2), 2008 (VB), section 6.
///
/// All give the picture of the renderer's own compute path. They need no compute shader: the list of active leaves is
/// kept on the CPU, which takes a few tens of microseconds for each leaf that detaches; a jump in time rebuilds the
/// list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Strategy {
    /// In the vertex shader, once per vertex (VB 6, first).
    Vertex,
    /// In a fragment shader, once per leaf, into textures that the vertex shader reads (VB 6.1).
    Fragment,
    /// In a fragment shader, once per leaf vertex, into textures that are copied to vertex buffers (VB 6.2).
    VertexBuffer,
}

impl Strategy {
    /// All of them, in the paper's order.
    pub const ALL: [Self; 3] = [Self::Vertex, Self::Fragment, Self::VertexBuffer];

    /// Its name on command lines and in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Vertex => "vertex",
            Self::Fragment => "fragment",
            Self::VertexBuffer => "vertex-buffer",
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

/// When a landed leaf leaves the list of active leaves and becomes static geometry (leaf elimination, VB 5). Pictures
/// do not depend on it, the time they take does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Elimination {
    /// Never: every detached leaf is posed in each frame, as in VB before section 5.
    Off,
    /// As in VB: each frame tests the leaves that were tested longest ago, from two seconds after they detached.
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
        let error = "cpu".parse::<Strategy>().unwrap_err().to_string();
        assert!(error.contains("\"cpu\"") && error.contains("vertex-buffer"), "{error}");
    }
}
