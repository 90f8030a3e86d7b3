//! Which trees a view leaves out.

use crate::base::names::UnknownName;

/// Which trees are left out of the picture. None of them is ever seen in it: the picture is the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Culling {
    /// None.
    Off = 0,
    /// Those whose bounding box is outside of clip space: for comparison (SFS, 4.2).
    ClipSpace = 1,
    /// Those whose bounding sphere is outside of the view (SFS, 4.2).
    #[default]
    Sphere = 2,
    /// Those too that hide behind others and the ground, by a pyramid of the depth of the frame
    /// before, and a second pass for those that it hid and that of this frame does not. In whole pictures alone: views
    /// of a host's pass leave out no more than `Sphere`.
    Occlusion = 3,
}

impl Culling {
    /// Each of them.
    pub const ALL: [Self; 4] = [Self::Off, Self::ClipSpace, Self::Sphere, Self::Occlusion];

    /// Its name on command lines and in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::ClipSpace => "clip-space",
            Self::Sphere => "sphere",
            Self::Occlusion => "occlusion",
        }
    }
}

impl std::fmt::Display for Culling {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

impl std::str::FromStr for Culling {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        Self::ALL
            .into_iter()
            .find(|c| c.name() == name)
            .ok_or_else(|| UnknownName::new("culling", name, &Self::ALL.map(Self::name)))
    }
}
