//! Strategy `fragment` (VB 6.1): a fragment poses a leaf, its vertices read the pose.

use super::{
    PassLayouts, Pipelines, VISIBILITY, VertexInput, fill_pipeline, loaded, with_leaf_texels,
    with_leaves,
};
use crate::arena::BLOCK_SIZE;
use crate::buffers::{LeafBuffers, POSITIONS, PosedLeaves, WORDS, rows};
use windfall_gpu::Recording;
use windfall_gpu::internals::{Module, Shaders, ShapeVertex};

/// Poses.
pub const POSE: Module = Module {
    name: "published-fragment",
    source: |settings| with_leaf_texels(*settings, &[include_str!("fragment.wgsl")]),
};

/// Draws.
pub const DRAW: Module = Module {
    name: "published-fragment-draw",
    source: |settings| with_leaves(*settings, &[&[include_str!("fragment_draw.wgsl")]]),
};

/// Draws with leaf occlusion.
pub const OCCLUSION: Module = Module {
    name: "published-fragment-occlusion",
    source: |settings| {
        let entries = [include_str!("fragment_draw.wgsl"), include_str!("fragment_occlusion.wgsl")];
        with_leaves(*settings, &[&VISIBILITY, &entries])
    },
};

pub(super) fn pose_pipeline(
    shaders: &Shaders<'_>,
    layouts: &PassLayouts,
    constants: &[(&str, f64)],
) -> wgpu::RenderPipeline {
    let groups = [&layouts.frame, &layouts.leaves, &layouts.tables];
    fill_pipeline(shaders, (&POSE, "pose"), &groups, &[], &[POSITIONS, WORDS], constants)
}

pub(super) fn input(layouts: &PassLayouts) -> VertexInput<'_> {
    VertexInput {
        module: &DRAW,
        vertex: "read_pose",
        groups: vec![&layouts.frame, &layouts.part, &layouts.posed],
        buffers: vec![ShapeVertex::LAYOUT],
    }
}

pub(super) fn pose(
    recording: &mut Recording<'_>,
    (pipeline, frame): (&wgpu::RenderPipeline, &wgpu::BindGroup),
    leaves: &LeafBuffers,
    posed: &PosedLeaves,
) {
    let targets = posed.targets.each_ref().map(|view| Some(loaded(view)));
    let timing = recording.timing;
    timing.render_pass_into(recording.encoder, "pose", (&targets, None), |pass| {
        let pass = &mut *pass.pass;
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, frame, &[]);
        pass.set_bind_group(1, &posed.source.group, &[]);
        pass.set_bind_group(2, &leaves.tables_group, &[]);
        for (first, count) in rows(&leaves.lists.active) {
            pass.set_scissor_rect(0, first, BLOCK_SIZE, count);
            pass.draw(0..3, 0..1);
        }
    });
}

pub(super) fn draw(
    pass: &mut wgpu::RenderPass<'_>,
    leaves: &LeafBuffers,
    posed: &PosedLeaves,
    pipelines: &Pipelines,
) {
    pass.set_bind_group(2, &posed.draw_group, &[]);
    for (_, shape, range) in leaves.draws(&leaves.lists.active) {
        pipelines.set(pass, shape);
        shape.buffers().set(pass);
        pass.draw_indexed(0..shape.buffers().index_count, 0, range);
    }
}
