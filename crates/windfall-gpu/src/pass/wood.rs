//! Trunks and branches.

use super::{Shaders, draw::Draw, draw_parts, tree_instances};
use crate::forest::{GpuForest, Visible};
use crate::model::WoodVertex;

pub(crate) struct Wood {
    pipeline: wgpu::RenderPipeline,
}

impl Wood {
    pub fn new(shaders: &Shaders<'_>, part_layout: &wgpu::BindGroupLayout) -> Self {
        let vertices = wgpu::VertexBufferLayout {
            array_stride: size_of::<WoodVertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &WoodVertex::ATTRIBUTES,
        };
        Self {
            pipeline: shaders.pipeline(&Draw {
                label: "wood",
                source: include_str!("../../shaders/wood.wgsl"),
                groups: &[part_layout],
                buffers: &[vertices, tree_instances()],
                // Real exports have open tubes and mixed winding: both sides are drawn.
                cull: None,
                vertex: "vertex",
                fragment: "fragment",
                alpha_to_coverage: false,
                target: None,
            }),
        }
    }

    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, forest: &GpuForest, visible: &[Visible]) {
        pass.set_pipeline(&self.pipeline);
        draw_parts(pass, forest, visible, |model| &model.wood, &forest.models, |_, _| {});
    }
}
