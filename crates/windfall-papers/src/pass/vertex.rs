//! Strategy `vertex` (VB 6, first): every vertex of an active leaf poses the leaf.

use super::{
    ACTIVE_LEAF, POSE, POSE_FROM_TEXTURES, PassLayouts, VISIBILITY, VertexInput, with_leaves,
};
use crate::shared::FallingLeaf;
use windfall_gpu::internals::{Module, ShapeVertex};

/// Draws.
pub const DRAW: Module = Module {
    name: "published-vertex",
    source: |settings| {
        with_leaves(*settings, &[&POSE, &[ACTIVE_LEAF, include_str!("vertex.wgsl")]])
    },
};

/// Draws with leaf occlusion.
pub const OCCLUSION: Module = Module {
    name: "published-vertex-occlusion",
    source: |settings| {
        let entries = [include_str!("vertex.wgsl"), include_str!("vertex_occlusion.wgsl")];
        with_leaves(*settings, &[&POSE, &[ACTIVE_LEAF], &VISIBILITY, &entries])
    },
};

/// Draws, with paths in one-dimensional textures.
pub const DRAW_FROM_TEXTURES: Module = Module {
    name: "published-vertex-textures",
    source: |settings| {
        with_leaves(*settings, &[&POSE_FROM_TEXTURES, &[ACTIVE_LEAF, include_str!("vertex.wgsl")]])
    },
};

/// The same with leaf occlusion.
pub const OCCLUSION_FROM_TEXTURES: Module = Module {
    name: "published-vertex-textures-occlusion",
    source: |settings| {
        let entries = [include_str!("vertex.wgsl"), include_str!("vertex_occlusion.wgsl")];
        with_leaves(*settings, &[&POSE_FROM_TEXTURES, &[ACTIVE_LEAF], &VISIBILITY, &entries])
    },
};

pub(super) fn input(layouts: &PassLayouts, one_dimensional: bool) -> VertexInput<'_> {
    let leaf = wgpu::VertexBufferLayout {
        array_stride: size_of::<FallingLeaf>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &const {
            wgpu::vertex_attr_array![
                3 => Float32x4, 4 => Float32x4, 5 => Float32x4, 6 => Uint32x4, 7 => Uint32x4
            ]
        },
    };
    VertexInput {
        module: if one_dimensional { &DRAW_FROM_TEXTURES } else { &DRAW },
        vertex: "falling",
        groups: vec![&layouts.frame, &layouts.part, &layouts.tables],
        buffers: vec![ShapeVertex::LAYOUT, leaf],
    }
}
