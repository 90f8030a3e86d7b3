//! How falling leaves are computed, and what is spared.

use std::fmt;
use std::str::FromStr;

/// Where the pose of a falling leaf is computed. All give the same picture.
///
/// The first three are those of P.-P. Vázquez and M. Balsa, "Rendering Falling Leaves on Graphics
/// Hardware", JVRB 5(2), 2008, section 6. They need no compute shader: the list of falling leaves is
/// kept on the CPU, which costs it a few tens of microseconds for each leaf that detaches, and a seek
/// rebuilds the list. Small leaves are listed apart: where the eye jumps, every leaf is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Strategy {
    /// In the vertex shader, once per vertex.
    Vertex,
    /// In a fragment shader, once per leaf, into textures that the vertex shader reads.
    Fragment,
    /// In a fragment shader, once per leaf vertex, into textures that are copied to a vertex buffer.
    VertexBuffer,
    /// In a compute shader, with the list of leaves and their landings there too. The default.
    #[default]
    Compute,
}

impl Strategy {
    /// All of them, in the order of the paper, then `Compute`.
    pub const ALL: [Self; 4] = [Self::Vertex, Self::Fragment, Self::VertexBuffer, Self::Compute];

    /// Its name on command lines and in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Vertex => "vertex",
            Self::Fragment => "fragment",
            Self::VertexBuffer => "vertex-buffer",
            Self::Compute => "compute",
        }
    }
}

impl fmt::Display for Strategy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A name that is none of a list.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{kind} {name:?} is not known; there are: {known}")]
pub struct UnknownName {
    kind: &'static str,
    name: String,
    known: String,
}

impl UnknownName {
    pub(crate) fn new(kind: &'static str, name: &str, known: &[&str]) -> Self {
        Self { kind, name: name.to_owned(), known: known.join(", ") }
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

/// When a leaf that has landed leaves the list of falling leaves and becomes static geometry (VB 5).
/// [`Strategy::Compute`] keeps both in one list and takes no notice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Elimination {
    /// Never: every leaf that was thrown is computed in each frame, as in VB before section 5.
    Off,
    /// As in VB: each frame tests the leaves that have waited longest, of those that began to fall
    /// at least two seconds ago.
    Progressive {
        /// Leaves that are tested in a frame; VB: 10 to 20.
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
