//! Strategy `vertex-buffer` (VB 6.2): a fragment poses a vertex; its result is drawn as a vertex.

use super::{
    PassLayouts, Pipelines, VISIBILITY, VertexInput, fill_pipeline, loaded, with_leaf_texels,
    with_leaves,
};
use crate::buffers::{LeafBuffers, PosedVertices, VERTEX_ROW, WORDS};
use windfall_gpu::Recording;
use windfall_gpu::internals::{Module, Shaders};

const MIDDLE: &str = include_str!("../wgsl/packed_middle.wgsl");

/// Poses.
pub const POSE: Module = Module {
    name: "published-vertex-buffer",
    source: |settings| with_leaf_texels(*settings, &[MIDDLE, include_str!("vertex_buffer.wgsl")]),
};

/// Draws.
pub const DRAW: Module = Module {
    name: "published-vertex-buffer-draw",
    source: |settings| {
        with_leaves(*settings, &[&[MIDDLE, include_str!("vertex_buffer_draw.wgsl")]])
    },
};

/// Draws with leaf occlusion.
pub const OCCLUSION: Module = Module {
    name: "published-vertex-buffer-occlusion",
    source: |settings| {
        let entries =
            [include_str!("vertex_buffer_draw.wgsl"), include_str!("vertex_buffer_occlusion.wgsl")];
        with_leaves(*settings, &[&[MIDDLE], &VISIBILITY, &entries])
    },
};

pub(super) fn pose_pipeline(
    shaders: &Shaders<'_>,
    layouts: &PassLayouts,
    constants: &[(&str, f64)],
) -> wgpu::RenderPipeline {
    let region = wgpu::VertexBufferLayout {
        array_stride: 16,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![0 => Uint32x4],
    };
    let groups = [&layouts.frame, &layouts.leaves, &layouts.tables];
    fill_pipeline(shaders, (&POSE, "pose"), &groups, &[region], &[WORDS, WORDS], constants)
}

pub(super) fn input(layouts: &PassLayouts) -> VertexInput<'_> {
    let place = wgpu::VertexBufferLayout {
        array_stride: 16,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &const { wgpu::vertex_attr_array![0 => Float32x3, 1 => Snorm16x2] },
    };
    let rest = wgpu::VertexBufferLayout {
        array_stride: 16,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &const {
            wgpu::vertex_attr_array![2 => Unorm8x4, 3 => Uint32, 4 => Uint32, 5 => Uint32]
        },
    };
    VertexInput {
        module: &DRAW,
        vertex: "read_vertex",
        groups: vec![&layouts.frame, &layouts.part],
        buffers: vec![place, rest],
    }
}

pub(super) fn pose(
    recording: &mut Recording<'_>,
    (pipeline, frame): (&wgpu::RenderPipeline, &wgpu::BindGroup),
    leaves: &LeafBuffers,
    posed: &PosedVertices,
) {
    let list = &leaves.lists.active;
    let targets = posed.targets.each_ref().map(|view| Some(loaded(view)));
    let timing = recording.timing;
    timing.render_pass_into(recording.encoder, "pose", (&targets, None), |pass| {
        let pass = &mut *pass.pass;
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, frame, &[]);
        pass.set_bind_group(1, &posed.source.group, &[]);
        pass.set_bind_group(2, &leaves.tables_group, &[]);
        pass.set_vertex_buffer(0, posed.records.slice(..));
        for (region, first, count) in posed.rows(list) {
            pass.set_scissor_rect(0, first, VERTEX_ROW, count);
            pass.draw(0..3, region..region + 1);
        }
    });
    posed.copy(recording.encoder, list);
}

pub(super) fn draw(
    pass: &mut wgpu::RenderPass<'_>,
    leaves: &LeafBuffers,
    posed: &PosedVertices,
    pipelines: &Pipelines,
) {
    for (region, shape, range) in leaves.draws(&leaves.lists.active) {
        pipelines.set(pass, shape);
        let first = posed.offset(region);
        pass.set_vertex_buffer(0, posed.buffers[0].slice(first..));
        pass.set_vertex_buffer(1, posed.buffers[1].slice(first..));
        pass.set_index_buffer(posed.indices[region].slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..range.len() as u32 * shape.buffers().index_count, 0, 0..1);
    }
}
