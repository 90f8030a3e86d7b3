//! Eliminated leaves: static geometry (VB 5).

use super::{POSE, PassLayouts, VertexInput, with_leaves};
use crate::shared::LitterLeaf;
use windfall_gpu::internals::{Module, ShapeVertex};

/// Draws.
pub const LITTER: Module = Module {
    name: "published-litter",
    source: |settings| with_leaves(*settings, &[&POSE, &[ENTRIES]]),
};

pub(super) const ENTRIES: &str = include_str!("litter.wgsl");

pub(super) fn input(layouts: &PassLayouts) -> VertexInput<'_> {
    let leaf = wgpu::VertexBufferLayout {
        array_stride: size_of::<LitterLeaf>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &const {
            wgpu::vertex_attr_array![
                3 => Float32x4, 4 => Snorm16x4, 5 => Unorm8x4, 6 => Uint32, 7 => Float32x2
            ]
        },
    };
    VertexInput {
        module: &LITTER,
        vertex: "lying",
        groups: vec![&layouts.frame, &layouts.part, &layouts.tables],
        buffers: vec![ShapeVertex::LAYOUT, leaf],
    }
}
