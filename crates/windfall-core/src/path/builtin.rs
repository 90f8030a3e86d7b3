//! The paths that come with the library.

use super::{FallPath, PathSet};
use crate::error::InputError;
use crate::flight::fall_path;
use crate::flight::presets::Preset;
use crate::rng::hash;

/// Made by `windfall path simulate --builtin --out crates/windfall-core/assets/paths.bin`; a test
/// simulates one of them again.
const BYTES: &[u8] = include_bytes!("../../assets/paths.bin");

/// Number of built-in paths of each species.
pub const PER_SPECIES: u32 = 2;
/// Falls drawn for each, of which the one with the best joints is kept.
const DRAWS: u32 = 32;
/// Samples of each, less one.
const SAMPLES: f64 = 390.0;

pub(super) fn load() -> PathSet {
    match PathSet::read("built-in paths", BYTES) {
        Ok(set) => set,
        Err(error) => unreachable!("the asset is tested: {error}"),
    }
}

/// Simulates the `index`-th built-in path of a species, as it was for the asset.
///
/// # Errors
///
/// As [`fall_path`]; none for the presets of this crate.
pub fn simulate(preset: &Preset, index: u32) -> Result<FallPath, InputError> {
    let seed = preset.name.bytes().fold(index, |h, b| hash(h, u32::from(b)));
    fall_path(preset.name, &preset.body, SAMPLES / preset.rate, preset.rate, seed, DRAWS)
}
