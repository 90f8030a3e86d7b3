//! Eliminated leaves: static geometry (VB 5).

use super::{POSE, PassLayouts, Pipelines, VertexInput, with_leaves};
use crate::buffers::LeafBuffers;
use crate::shared::LitterLeaf;
use windfall_gpu::internals::{Module, ShapeVertex};

/// Draws.
pub const LITTER: Module = Module {
    name: "published-litter",
    source: |settings| with_leaves(*settings, &[&POSE, &[include_str!("litter.wgsl")]]),
};

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

pub(super) fn draw(pass: &mut wgpu::RenderPass<'_>, leaves: &LeafBuffers, pipelines: &Pipelines) {
    let list = &leaves.lists.litter;
    pass.set_bind_group(2, &leaves.tables_group, &[]);
    for (_, shape, range) in leaves.draws(list) {
        pipelines.set(pass, shape);
        shape.buffers().set(pass);
        pass.set_vertex_buffer(1, list.buffer.slice(..));
        pass.draw_indexed(0..shape.buffers().index_count, 0, range);
    }
}
