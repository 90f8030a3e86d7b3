//! The table of the built-in species.
//!
//! Sizes of leaves and habits are those of the field guides; the angles and ratios were chosen by
//! eye against silhouettes of free-standing trees. Colours are sRGB in the table, linear inside.

#![expect(clippy::unreadable_literal, reason = "colours read as six digits")]

use super::params::{Leaves, Level, Outline, Params, Trunk, srgb};
use crate::foliage::Palette;
use crate::tree::{Bark, BarkPattern};

fn bark(ridge: u32, groove: u32, scale: f32, pattern: BarkPattern) -> Bark {
    Bark { ridge: srgb(ridge), groove: srgb(groove), scale, pattern }
}

/// Colours as pictures of leaves have them, which are exposed for leaves in the sun: a leaf reflects
/// somewhat less.
fn palette(stops: &[u32], spread: f32) -> Palette {
    Palette { stops: stops.iter().map(|&stop| srgb(stop) * 0.82).collect(), spread }
}

/// *Quercus robur*.
pub fn oak() -> Params {
    Params {
        name: "oak",
        trunk: Trunk {
            length: 7.8,
            vary: 0.08,
            radius: 0.36,
            taper: 0.6,
            wander: 8.0,
            lean: 2.5,
            flare: 0.8,
            mesh: [18, 16],
        },
        levels: &[
            Level {
                density: 2.8,
                from: 0.24,
                angle: [78.0, 30.0],
                length: [0.62, 0.74, 0.54],
                vary: 0.18,
                flat: 0.0,
                lift: [-0.1, 0.9],
                wander: 17.0,
                power: 1.5,
                taper: 0.75,
                mesh: [10, 8],
            },
            Level {
                density: 2.9,
                from: 0.3,
                angle: [60.0, 30.0],
                length: [0.42, 0.42, 0.2],
                vary: 0.3,
                flat: 0.3,
                lift: [0.0, 0.5],
                wander: 16.0,
                power: 1.35,
                taper: 0.8,
                mesh: [5, 4],
            },
            Level {
                density: 4.6,
                from: 0.15,
                angle: [55.0, 25.0],
                length: [0.32, 0.34, 0.22],
                vary: 0.3,
                flat: 0.3,
                lift: [0.1, 0.3],
                wander: 12.0,
                power: 1.6,
                taper: 0.5,
                mesh: [2, 3],
            },
        ],
        leaves: Leaves {
            count: 8600,
            length: 0.11,
            enlarge: 2.15,
            per_node: 1,
            petiole: 0.0,
            angle: 50.0,
            droop: 0.25,
            scatter: 0.5,
            areal_density: 0.080,
            outline: Outline {
                midrib: &[0.0, 1.0],
                edge: &[
                    [0.16, 0.2],
                    [0.1, 0.29],
                    [0.26, 0.4],
                    [0.28, 0.51],
                    [0.15, 0.6],
                    [0.3, 0.7],
                    [0.22, 0.92],
                ],
                fold: 14.0,
                curl: 25.0,
            },
        },
        bark: bark(0x7d7263, 0x3a332c, 0.11, BarkPattern::Furrowed),
        twig: srgb(0x5f5142),
        palette: palette(&[0x4c6b28, 0x7a7a2c, 0xa57b2a, 0xa6682a, 0x7e4a22], 0.45),
    }
}

/// *Acer platanoides*.
pub fn maple() -> Params {
    Params {
        name: "maple",
        trunk: Trunk {
            length: 9.4,
            vary: 0.08,
            radius: 0.27,
            taper: 0.7,
            wander: 4.0,
            lean: 2.0,
            flare: 0.5,
            mesh: [18, 14],
        },
        levels: &[
            Level {
                density: 3.4,
                from: 0.2,
                angle: [62.0, 15.0],
                length: [0.36, 0.52, 0.36],
                vary: 0.12,
                flat: 0.0,
                lift: [0.2, 0.6],
                wander: 9.0,
                power: 1.4,
                taper: 0.85,
                mesh: [9, 7],
            },
            Level {
                density: 3.4,
                from: 0.2,
                angle: [55.0, 30.0],
                length: [0.42, 0.42, 0.22],
                vary: 0.25,
                flat: 0.2,
                lift: [0.1, 0.5],
                wander: 9.0,
                power: 1.3,
                taper: 0.9,
                mesh: [4, 4],
            },
            Level {
                density: 4.0,
                from: 0.2,
                angle: [50.0, 25.0],
                length: [0.34, 0.36, 0.25],
                vary: 0.25,
                flat: 0.2,
                lift: [0.2, 0.3],
                wander: 8.0,
                power: 1.55,
                taper: 0.5,
                mesh: [1, 3],
            },
        ],
        leaves: Leaves {
            count: 8800,
            length: 0.12,
            enlarge: 1.9,
            per_node: 2,
            petiole: 0.5,
            angle: 60.0,
            droop: 0.4,
            scatter: 0.45,
            areal_density: 0.062,
            outline: Outline {
                midrib: &[0.12, 1.0],
                edge: &[
                    [0.15, 0.02],
                    [0.47, 0.1],
                    [0.36, 0.3],
                    [0.62, 0.6],
                    [0.26, 0.58],
                    [0.2, 0.76],
                ],
                fold: 10.0,
                curl: 22.0,
            },
        },
        bark: bark(0x7a7167, 0x4a433c, 0.07, BarkPattern::Plated),
        twig: srgb(0x5b4a3c),
        palette: palette(&[0x55782c, 0x9aa033, 0xe0b233, 0xe07a22, 0xc23d1d, 0x8c3a20], 0.45),
    }
}

/// *Betula pendula*.
pub fn birch() -> Params {
    Params {
        name: "birch",
        trunk: Trunk {
            length: 13.2,
            vary: 0.1,
            radius: 0.15,
            taper: 0.85,
            wander: 4.0,
            lean: 3.0,
            flare: 0.4,
            mesh: [18, 12],
        },
        levels: &[
            Level {
                density: 3.4,
                from: 0.2,
                angle: [52.0, 28.0],
                length: [0.16, 0.18, 0.06],
                vary: 0.22,
                flat: 0.0,
                lift: [0.5, -1.0],
                wander: 7.0,
                power: 1.25,
                taper: 0.9,
                mesh: [8, 5],
            },
            Level {
                density: 4.4,
                from: 0.2,
                angle: [55.0, 35.0],
                length: [0.4, 0.42, 0.3],
                vary: 0.3,
                flat: 0.3,
                lift: [-0.2, -2.0],
                wander: 8.0,
                power: 1.2,
                taper: 0.8,
                mesh: [4, 3],
            },
            Level {
                density: 2.6,
                from: 0.2,
                angle: [40.0, 25.0],
                length: [0.7, 0.7, 0.6],
                vary: 0.4,
                flat: 0.2,
                lift: [-1.0, -4.0],
                wander: 5.0,
                power: 1.2,
                taper: 0.5,
                mesh: [4, 3],
            },
        ],
        leaves: Leaves {
            count: 10_200,
            length: 0.055,
            enlarge: 2.2,
            per_node: 1,
            petiole: 0.4,
            angle: 50.0,
            droop: 0.65,
            scatter: 0.6,
            areal_density: 0.070,
            outline: Outline {
                midrib: &[0.0, 1.0],
                edge: &[[0.3, 0.08], [0.41, 0.28], [0.31, 0.36], [0.31, 0.48], [0.13, 0.7]],
                fold: 12.0,
                curl: 25.0,
            },
        },
        bark: bark(0xe4dfd4, 0x33302d, 0.16, BarkPattern::Papery),
        twig: srgb(0x4e3a33),
        palette: palette(&[0x5e7f2f, 0x9aa637, 0xdcbf3a, 0xe3b02e, 0xb98a35], 0.4),
    }
}

/// *Fagus sylvatica*.
pub fn beech() -> Params {
    Params {
        name: "beech",
        trunk: Trunk {
            length: 13.0,
            vary: 0.07,
            radius: 0.27,
            taper: 0.75,
            wander: 3.0,
            lean: 1.5,
            flare: 0.6,
            mesh: [18, 14],
        },
        levels: &[
            Level {
                density: 3.7,
                from: 0.17,
                angle: [68.0, 20.0],
                length: [0.24, 0.33, 0.21],
                vary: 0.15,
                flat: 0.0,
                lift: [0.3, 0.3],
                wander: 8.0,
                power: 1.45,
                taper: 0.85,
                mesh: [9, 6],
            },
            Level {
                density: 3.2,
                from: 0.2,
                angle: [55.0, 35.0],
                length: [0.42, 0.4, 0.2],
                vary: 0.25,
                flat: 0.5,
                lift: [0.1, 0.0],
                wander: 8.0,
                power: 1.3,
                taper: 0.9,
                mesh: [4, 4],
            },
            Level {
                density: 4.0,
                from: 0.15,
                angle: [50.0, 30.0],
                length: [0.36, 0.36, 0.25],
                vary: 0.25,
                flat: 0.5,
                lift: [0.0, -0.2],
                wander: 8.0,
                power: 1.55,
                taper: 0.5,
                mesh: [1, 3],
            },
        ],
        leaves: Leaves {
            count: 15_000,
            length: 0.075,
            enlarge: 2.2,
            per_node: 1,
            petiole: 0.0,
            angle: 50.0,
            droop: 0.35,
            scatter: 0.5,
            areal_density: 0.065,
            outline: Outline {
                midrib: &[0.0, 0.5, 1.0],
                edge: &[[0.24, 0.18], [0.33, 0.45], [0.22, 0.78]],
                fold: 14.0,
                curl: 18.0,
            },
        },
        bark: bark(0x8c8b84, 0x6c6a63, 0.25, BarkPattern::Smooth),
        twig: srgb(0x5c4b40),
        palette: palette(&[0x4f7029, 0x9a922e, 0xc98a2c, 0xb8602a, 0x7f4526], 0.4),
    }
}

/// *Populus tremula*.
pub fn aspen() -> Params {
    Params {
        name: "aspen",
        trunk: Trunk {
            length: 14.5,
            vary: 0.1,
            radius: 0.16,
            taper: 0.75,
            wander: 2.5,
            lean: 1.5,
            flare: 0.25,
            mesh: [18, 12],
        },
        levels: &[
            Level {
                density: 4.0,
                from: 0.36,
                angle: [70.0, 30.0],
                length: [0.12, 0.15, 0.06],
                vary: 0.18,
                flat: 0.0,
                lift: [0.2, 0.6],
                wander: 9.0,
                power: 1.15,
                taper: 0.9,
                mesh: [7, 5],
            },
            Level {
                density: 4.4,
                from: 0.2,
                angle: [60.0, 35.0],
                length: [0.42, 0.42, 0.3],
                vary: 0.3,
                flat: 0.2,
                lift: [0.1, 0.4],
                wander: 9.0,
                power: 1.1,
                taper: 0.9,
                mesh: [4, 3],
            },
            Level {
                density: 5.0,
                from: 0.2,
                angle: [55.0, 30.0],
                length: [0.42, 0.42, 0.35],
                vary: 0.3,
                flat: 0.2,
                lift: [0.0, 0.2],
                wander: 8.0,
                power: 1.3,
                taper: 0.5,
                mesh: [1, 3],
            },
        ],
        leaves: Leaves {
            count: 10500,
            length: 0.05,
            enlarge: 2.1,
            per_node: 1,
            petiole: 0.8,
            angle: 60.0,
            droop: 0.6,
            scatter: 0.8,
            areal_density: 0.075,
            outline: Outline {
                midrib: &[0.0, 1.0],
                edge: &[[0.34, 0.06], [0.51, 0.34], [0.45, 0.64], [0.2, 0.9]],
                fold: 8.0,
                curl: 14.0,
            },
        },
        bark: bark(0xc9c7b2, 0x3d3c36, 0.3, BarkPattern::Papery),
        twig: srgb(0x6a5a48),
        palette: palette(&[0x668538, 0xa8ad3a, 0xe8c22f, 0xeaa827, 0xb8832f], 0.35),
    }
}

/// *Ginkgo biloba*.
pub fn ginkgo() -> Params {
    Params {
        name: "ginkgo",
        trunk: Trunk {
            length: 12.6,
            vary: 0.08,
            radius: 0.22,
            taper: 0.8,
            wander: 2.5,
            lean: 1.0,
            flare: 0.35,
            mesh: [18, 12],
        },
        levels: &[
            Level {
                density: 3.0,
                from: 0.15,
                angle: [62.0, 38.0],
                length: [0.28, 0.23, 0.07],
                vary: 0.2,
                flat: 0.0,
                lift: [0.1, 0.5],
                wander: 7.0,
                power: 1.2,
                taper: 0.85,
                mesh: [9, 6],
            },
            Level {
                density: 2.8,
                from: 0.15,
                angle: [50.0, 35.0],
                length: [0.32, 0.34, 0.25],
                vary: 0.35,
                flat: 0.2,
                lift: [0.2, 0.5],
                wander: 7.0,
                power: 1.1,
                taper: 0.9,
                mesh: [5, 4],
            },
            Level {
                density: 3.0,
                from: 0.15,
                angle: [60.0, 45.0],
                length: [0.3, 0.3, 0.3],
                vary: 0.4,
                flat: 0.2,
                lift: [0.2, 0.4],
                wander: 6.0,
                power: 1.45,
                taper: 0.5,
                mesh: [1, 3],
            },
        ],
        leaves: Leaves {
            count: 9400,
            length: 0.065,
            enlarge: 2.0,
            per_node: 4,
            petiole: 0.75,
            angle: 60.0,
            droop: 0.35,
            scatter: 0.6,
            areal_density: 0.085,
            outline: Outline {
                midrib: &[0.0, 0.66],
                edge: &[[0.3, 0.3], [0.66, 0.52], [0.56, 0.8], [0.32, 0.97], [0.09, 1.0]],
                fold: 10.0,
                curl: 18.0,
            },
        },
        bark: bark(0x857a6c, 0x4a4138, 0.1, BarkPattern::Furrowed),
        twig: srgb(0x6e6154),
        palette: palette(&[0x6c8c3a, 0xa9b23c, 0xe6c935, 0xf2c42c, 0xd3a93c], 0.3),
    }
}
