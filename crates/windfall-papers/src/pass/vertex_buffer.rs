//! Strategy `vertex-buffer` (VB 6.2): a fragment finds where a vertex is; what it writes is drawn.

use super::Shaders;
use super::listed::{Layouts, PictureAndShadow, Pipelines, Placing, pose_pass, pose_pipeline};
use crate::listed::{ListedFalls, PosedVertices, WORDS};
use crate::model::GpuModel;
use wgpu_profiler::Scope;

pub(crate) struct VertexBufferFalls {
    pose: wgpu::RenderPipeline,
    pub(super) pipelines: PictureAndShadow,
}

impl VertexBufferFalls {
    pub fn new(
        shaders: &Shaders<'_>,
        part_layout: &wgpu::BindGroupLayout,
        layouts: &Layouts,
    ) -> Self {
        let patch = wgpu::VertexBufferLayout {
            array_stride: 16,
            step_mode: wgpu::VertexStepMode::Instance,
            attributes: &wgpu::vertex_attr_array![0 => Uint32x4],
        };
        let pose = concat!(
            include_str!("../../shaders/shared/placed.wgsl"),
            include_str!("../../shaders/vertex_buffer_falls.wgsl")
        );
        Self {
            pose: pose_pipeline(
                shaders,
                layouts,
                "vertex buffer falls",
                pose,
                &[patch],
                [WORDS, WORDS],
            ),
            pipelines: PictureAndShadow::new(shaders, &Self::placing(part_layout)),
        }
    }

    pub fn placing(part_layout: &wgpu::BindGroupLayout) -> Placing<'_> {
        let place = wgpu::VertexBufferLayout {
            array_stride: 16,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &const { wgpu::vertex_attr_array![0 => Float32x3, 1 => Snorm16x2] },
        };
        let look = wgpu::VertexBufferLayout {
            array_stride: 16,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &const {
                wgpu::vertex_attr_array![2 => Unorm8x4, 3 => Uint32, 4 => Uint32, 5 => Uint32]
            },
        };
        Placing {
            source: concat!(
                include_str!("../../shaders/shared/placed.wgsl"),
                include_str!("../../shaders/vertex_buffer_leaves.wgsl")
            ),
            vertex: "placed",
            groups: vec![part_layout],
            buffers: vec![place, look],
            posing: false,
        }
    }

    pub fn pose(
        &self,
        scope: &mut Scope<'_, wgpu::CommandEncoder>,
        frame_group: &wgpu::BindGroup,
        falls: &ListedFalls,
        posed: &PosedVertices,
    ) {
        let list = &falls.roster.falling;
        {
            let mut pass = pose_pass(scope, &posed.targets);
            pass.set_pipeline(&self.pose);
            pass.set_bind_group(0, frame_group, &[]);
            pass.set_bind_group(1, &posed.source.group, &[]);
            pass.set_bind_group(2, &falls.tables_group, &[]);
            pass.set_vertex_buffer(0, posed.patches.slice(..));
            for (region, first, rows) in posed.rows(list) {
                pass.set_scissor_rect(0, first, crate::listed::VERTEX_WIDTH, rows);
                pass.draw(0..3, region..region + 1);
            }
        }
        posed.copy(&mut scope.scope("copy"), list);
    }

    pub fn draw(
        pass: &mut wgpu::RenderPass<'_>,
        models: &[GpuModel],
        falls: &ListedFalls,
        posed: &PosedVertices,
        pipelines: &Pipelines,
    ) {
        for (region, shape, leaves) in falls.draws(&falls.roster.falling) {
            pipelines.set(pass, models, shape);
            let first = posed.offset(region);
            pass.set_vertex_buffer(0, posed.buffers[0].slice(first..));
            pass.set_vertex_buffer(1, posed.buffers[1].slice(first..));
            pass.set_index_buffer(posed.indices[region].slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..leaves.len() as u32 * shape.buffers.index_count, 0, 0..1);
        }
    }
}
