//! Leaves on their twigs.

use super::{Shaders, draw::Draw, draw_parts, tree_instances};
use crate::forest::{GpuForest, Visible};
use crate::model::LeafVertex;

pub(crate) struct Leaves {
    solid: wgpu::RenderPipeline,
    masked: wgpu::RenderPipeline,
}

impl Leaves {
    pub fn new(shaders: &Shaders<'_>, part_layout: &wgpu::BindGroupLayout) -> Self {
        let vertices = wgpu::VertexBufferLayout {
            array_stride: size_of::<LeafVertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &LeafVertex::ATTRIBUTES,
        };
        let pipeline = |label, fragment, alpha_to_coverage| {
            shaders.pipeline(&Draw {
                label,
                source: include_str!("../../shaders/leaves.wgsl"),
                groups: &[part_layout],
                buffers: &[vertices.clone(), tree_instances()],
                cull: None,
                vertex: "vertex",
                fragment,
                alpha_to_coverage,
                target: None,
            })
        };
        Self {
            solid: pipeline("leaves", "solid", false),
            masked: pipeline("masked leaves", "masked", true),
        }
    }

    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, forest: &GpuForest, visible: &[Visible]) {
        draw_parts(
            pass,
            forest,
            visible,
            |model| &model.leaves,
            &forest.models,
            |pass, part| {
                pass.set_pipeline(if part.masked { &self.masked } else { &self.solid });
            },
        );
    }
}
