//! Strategy `fragment` (VB 6.1): a fragment finds where a leaf is, its vertices look it up.

use super::Shaders;
use super::listed::{
    Layouts, PictureAndShadow, Pipelines, Placing, SHAPE, pose_pass, pose_pipeline,
};
use crate::arena::GRAIN;
use crate::listed::{ListedFalls, PLACE, PosedLeaves, WORDS, leaf_rows};
use crate::model::GpuModel;
use wgpu_profiler::Scope;

pub(crate) struct FragmentFalls {
    pose: wgpu::RenderPipeline,
    pub(super) pipelines: PictureAndShadow,
}

impl FragmentFalls {
    pub fn new(
        shaders: &Shaders<'_>,
        part_layout: &wgpu::BindGroupLayout,
        layouts: &Layouts,
    ) -> Self {
        let pose = include_str!("../../shaders/fragment_falls.wgsl");
        Self {
            pose: pose_pipeline(shaders, layouts, "fragment falls", pose, &[], [PLACE, WORDS]),
            pipelines: PictureAndShadow::new(shaders, &Self::placing(part_layout, layouts)),
        }
    }

    pub fn placing<'a>(
        part_layout: &'a wgpu::BindGroupLayout,
        layouts: &'a Layouts,
    ) -> Placing<'a> {
        Placing {
            source: include_str!("../../shaders/fragment_leaves.wgsl"),
            vertex: "looked_up",
            groups: vec![part_layout, &layouts.posed],
            buffers: vec![SHAPE],
            posing: false,
        }
    }

    pub fn pose(
        &self,
        scope: &mut Scope<'_, wgpu::CommandEncoder>,
        frame_group: &wgpu::BindGroup,
        falls: &ListedFalls,
        posed: &PosedLeaves,
    ) {
        let mut pass = pose_pass(scope, &posed.targets);
        pass.set_pipeline(&self.pose);
        pass.set_bind_group(0, frame_group, &[]);
        pass.set_bind_group(1, &posed.source.group, &[]);
        pass.set_bind_group(2, &falls.tables_group, &[]);
        for (first, rows) in leaf_rows(&falls.roster.falling) {
            pass.set_scissor_rect(0, first, GRAIN, rows);
            pass.draw(0..3, 0..1);
        }
    }

    pub fn draw(
        pass: &mut wgpu::RenderPass<'_>,
        models: &[GpuModel],
        falls: &ListedFalls,
        posed: &PosedLeaves,
        pipelines: &Pipelines,
    ) {
        pass.set_bind_group(2, &posed.draw_group, &[]);
        for (_, shape, leaves) in falls.draws(&falls.roster.falling) {
            pipelines.set(pass, models, shape);
            shape.buffers.set(pass);
            pass.draw_indexed(0..shape.buffers.index_count, 0, leaves);
        }
    }
}
