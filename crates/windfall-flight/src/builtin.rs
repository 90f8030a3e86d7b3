//! Simulates the paths that come with the library ([`windfall_core::path::PathSet::builtin`]).

use crate::presets::Preset;
use crate::simulated_path;
use windfall_core::InputError;
use windfall_core::path::FallPath;
use windfall_core::rng::hash;

/// Number of built-in paths of each species.
pub const PER_SPECIES: u32 = 2;
/// Falls drawn for each, of which the one with the best joints is kept.
const DRAWS: u32 = 32;
/// Samples of each, less one.
const SAMPLES: f64 = 390.0;

/// Simulates the `index`-th built-in path of a species, as it was for the asset.
///
/// # Errors
///
/// As [`simulated_path`]; none for the presets of this crate.
pub fn simulate(preset: &Preset, index: u32) -> Result<FallPath, InputError> {
    let seed = preset.name.bytes().fold(index, |h, b| hash(h, u32::from(b)));
    simulated_path(preset.name, &preset.body, SAMPLES / preset.rate, preset.rate, seed, DRAWS)
}
