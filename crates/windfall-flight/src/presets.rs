//! Leaves of the built-in species, as far as their flight is concerned.

use super::leaf::{Air, LeafBody};
use glam::DVec3;

/// A named leaf.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preset {
    /// Name of the species, and of its group in the built-in path set.
    pub name: &'static str,
    /// What one sees.
    pub habit: &'static str,
    /// The leaf.
    pub body: LeafBody,
    /// Rate at which its falls are stored, hertz.
    pub rate: f64,
}

/// Sizes in centimetres, mass per area in g/m²; offset of the centre of mass in half lengths.
const fn leaf(
    density: f64,
    length: f64,
    width: f64,
    petiole: f64,
    cup: f64,
    twist: f64,
    air: Air,
) -> LeafBody {
    LeafBody {
        areal_density: density / 1000.0,
        half_length: length / 200.0,
        half_width: width / 200.0,
        offset: DVec3::new(0.0, 0.0, -petiole * length / 200.0),
        cup,
        twist,
        air,
    }
}

/// All presets. Masses per area and sizes are usual ones of dry leaves in autumn; curl and the effect
/// of the petiole are set so that each falls as its `habit` says, which a test measures.
pub const ALL: [Preset; 8] = [
    Preset {
        name: "oak",
        habit: "tumbles broadly and glides",
        body: leaf(80.0, 11.0, 6.5, 0.06, 0.1, 0.05, Air::STANDARD),
        rate: 60.0,
    },
    Preset {
        name: "maple",
        habit: "flutters and glides",
        body: leaf(62.0, 11.0, 12.0, 0.16, 0.15, 0.03, Air::FLUTTERING),
        rate: 60.0,
    },
    Preset {
        name: "birch",
        habit: "tumbles fast",
        body: leaf(70.0, 5.0, 3.6, 0.03, 0.05, 0.05, Air::STANDARD),
        rate: 60.0,
    },
    Preset {
        name: "beech",
        habit: "tumbles",
        body: leaf(65.0, 8.0, 5.0, 0.04, 0.08, 0.05, Air::STANDARD),
        rate: 60.0,
    },
    Preset {
        name: "aspen",
        habit: "flutters fast",
        body: leaf(75.0, 5.0, 5.0, 0.1, 0.08, 0.05, Air { damping: 0.3, ..Air::FLUTTERING }),
        rate: 60.0,
    },
    Preset {
        name: "ginkgo",
        habit: "tumbles in a spiral",
        body: leaf(85.0, 5.5, 7.5, 0.12, 0.12, 0.12, Air::STANDARD),
        rate: 60.0,
    },
    Preset {
        name: "ash",
        habit: "tumbles about its long axis",
        body: leaf(70.0, 8.0, 2.8, 0.02, 0.05, 0.08, Air::STANDARD),
        rate: 60.0,
    },
    Preset { name: "samara", habit: "spins", body: samara(), rate: 120.0 },
];

/// A nut at the end of a wing whose leading edge is thickened: the centre of mass lies well towards
/// the nut and ahead of the wing's middle, and the panels' own speeds make it autorotate; no term
/// drives the spin. It comes down faster (1.4 m/s) and turns slower (50 rad/s) than a maple's does
/// (about 1 m/s, 80 to 100 rad/s): an elliptic wing of even chord is not as good.
const fn samara() -> LeafBody {
    LeafBody {
        areal_density: 0.18,
        half_length: 0.018,
        half_width: 0.006,
        offset: DVec3::new(0.0018, 0.0, -0.008),
        cup: 0.0,
        twist: 0.0,
        air: Air::WING,
    }
}

/// The preset called `name`.
pub fn find(name: &str) -> Option<&'static Preset> {
    ALL.iter().find(|p| p.name == name)
}
