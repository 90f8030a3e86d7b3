//! Strategy `cpu` (VB 6.3): the CPU poses leaves and uploads them; they are drawn as the litter is ([`super::litter`]).

use super::litter::ENTRIES;
use super::{POSE, VISIBILITY, with_leaves};
use windfall_gpu::internals::Module;

/// Draws with leaf occlusion.
pub const OCCLUSION: Module = Module {
    name: "published-cpu-occlusion",
    source: |settings| {
        let entries = [ENTRIES, include_str!("cpu_occlusion.wgsl")];
        with_leaves(*settings, &[&POSE, &VISIBILITY, &entries])
    },
};
