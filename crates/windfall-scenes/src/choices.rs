//! Choices that a scene names: one table of names serves scene files, command lines and messages.
//!
//! What each of them means to the renderer, `stage.rs` says.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::str::FromStr;

/// A name that is none of a choice's.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{choice} {name:?} is not known; there are: {}", .known.join(", "))]
pub struct UnknownChoice {
    /// What is chosen: the field of the scene.
    pub choice: &'static str,
    /// The name as given.
    pub name: String,
    /// The names that there are.
    pub known: &'static [&'static str],
}

/// Enums whose values have names. `$choice` is the scene's field, for messages.
macro_rules! choices {
    ($(
        $(#[$about:meta])*
        $choice:literal => $Choice:ident {
            $($(#[$note:meta])* $Value:ident = $name:literal,)+
        }
    )+) => {$(
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
        pub enum $Choice {
            $($(#[$note])* $Value,)+
        }

        impl $Choice {
            /// Each of them, in the order of [`Self::NAMES`].
            pub const ALL: [Self; [$($name),+].len()] = [$(Self::$Value),+];
            /// Their names in scene files and on command lines.
            pub const NAMES: &'static [&'static str] = &[$($name),+];

            /// Its name in scene files and on command lines.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$Value => $name,)+
                }
            }
        }

        impl fmt::Display for $Choice {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.pad(self.name())
            }
        }

        impl FromStr for $Choice {
            type Err = UnknownChoice;

            fn from_str(name: &str) -> Result<Self, UnknownChoice> {
                match name {
                    $($name => Ok(Self::$Value),)+
                    _ => Err(UnknownChoice {
                        choice: $choice,
                        name: name.to_owned(),
                        known: Self::NAMES,
                    }),
                }
            }
        }

        impl Serialize for $Choice {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(self.name())
            }
        }

        impl<'de> Deserialize<'de> for $Choice {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
            }
        }
    )+};
}

choices! {
    /// Where the poses of falling leaves are computed. All give the same picture.
    ///
    /// The first three are those of P.-P. Vázquez and M. Balsa, "Rendering Falling Leaves on
    /// Graphics Hardware" (VB), JVRB 5(2), 2008, section 6.
    "strategy" => Strategy {
        /// In the vertex shader, once per vertex.
        Vertex = "vertex",
        /// In a fragment shader, once per leaf.
        Fragment = "fragment",
        /// In a fragment shader, once per leaf vertex, into a vertex buffer.
        VertexBuffer = "vertex-buffer",
        /// On the CPU, once per leaf, uploaded in every frame.
        Cpu = "cpu",
        /// In a compute shader. The default.
        #[default]
        Compute = "compute",
    }

    /// When landed leaves become static geometry (VB 5). [`Strategy::Compute`] ignores it.
    "elimination" => Elimination {
        /// Never.
        Off = "off",
        /// As in VB: each frame tests the leaves that have waited longest, as many as
        /// [`Scene::elimination_per_frame`](crate::Scene::elimination_per_frame).
        Progressive = "progressive",
        /// At the moment of landing, which is known from the start. The default.
        #[default]
        Scheduled = "scheduled",
    }

    /// Who looks for the place where a leaf lands (VB 5). The picture is the same.
    "landing_search" => LandingSearch {
        /// The CPU, once, when the leaf detaches. The default.
        #[default]
        Ahead = "ahead",
        /// As in VB: the shader, in every frame.
        InShader = "in-shader",
    }

    /// Which trees are left out because they are not seen. The picture is the same.
    "culling" => Culling {
        /// None.
        Off = "off",
        /// Those whose bounding box is outside of clip space: for comparison (SFS, 4.2).
        ClipSpace = "clip-space",
        /// Those whose bounding sphere is outside of the view (SFS, 4.2). The default.
        #[default]
        Sphere = "sphere",
        /// Those too that hide behind other trees and the ground.
        Occlusion = "occlusion",
    }

    /// What the times of a table of a fall path are in.
    "time_unit" => TimeUnit {
        /// Seconds. The default.
        #[default]
        Seconds = "s",
        /// Milliseconds.
        Milliseconds = "ms",
    }

    /// A preset of what the picture may cost.
    "quality" => QualityPreset {
        /// For weak devices, and for measurements of something else.
        Low = "low",
        /// Between the two.
        Medium = "medium",
        /// Every effect. The default.
        #[default]
        High = "high",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is written here is in the files of users: none of it may change.
    #[test]
    fn names_are_those_that_files_have() {
        assert_eq!(Strategy::NAMES, ["vertex", "fragment", "vertex-buffer", "cpu", "compute"]);
        assert_eq!(Elimination::NAMES, ["off", "progressive", "scheduled"]);
        assert_eq!(Culling::NAMES, ["off", "clip-space", "sphere", "occlusion"]);
        assert_eq!(QualityPreset::NAMES, ["low", "medium", "high"]);
        assert_eq!("vertex-buffer".parse(), Ok(Strategy::VertexBuffer));
        assert_eq!("progressive".parse(), Ok(Elimination::Progressive));
        assert_eq!("clip-space".parse(), Ok(Culling::ClipSpace));
        assert_eq!("medium".parse(), Ok(QualityPreset::Medium));
        assert_eq!(format!("{:>10}|", Culling::Occlusion), " occlusion|");
    }

    #[test]
    fn an_unknown_name_is_refused_with_those_that_there_are() {
        let message = |error: UnknownChoice| error.to_string();
        assert_eq!(
            "gpu".parse::<Strategy>().map_err(message),
            Err("strategy \"gpu\" is not known; there are: \
                 vertex, fragment, vertex-buffer, cpu, compute"
                .to_owned())
        );
        // Names are exact: neither case nor space is forgiven, nor the name of another choice.
        for name in ["Low", " low", "low ", "", "sphere", "lo\u{0}w"] {
            let error = name.parse::<QualityPreset>().unwrap_err();
            assert_eq!((error.choice, error.name.as_str()), ("quality", name));
            assert_eq!(error.known, ["low", "medium", "high"]);
        }
    }
}
