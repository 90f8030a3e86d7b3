//! Leaves on their twigs.

use super::{
    Shaders,
    draw::{Draw, DrawTarget},
    draw_parts, tree_instances,
};
use crate::forest::{GpuForest, Visible};
use crate::model::LeafVertex;

pub(crate) struct Leaves {
    solid: wgpu::RenderPipeline,
    masked: wgpu::RenderPipeline,
    solid_shadow: wgpu::RenderPipeline,
    masked_shadow: wgpu::RenderPipeline,
}

impl Leaves {
    pub fn new(shaders: &Shaders<'_>, part_layout: &wgpu::BindGroupLayout) -> Self {
        let vertices = wgpu::VertexBufferLayout {
            array_stride: size_of::<LeafVertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &LeafVertex::ATTRIBUTES,
        };
        let pipeline = |label, fragment, alpha_to_coverage, target| {
            shaders.pipeline(&Draw {
                label,
                source: include_str!("../../shaders/leaves.wgsl"),
                groups: &[part_layout],
                buffers: &[vertices.clone(), tree_instances()],
                cull: None,
                vertex: "vertex",
                fragment,
                alpha_to_coverage,
                target,
            })
        };
        Self {
            solid: pipeline("leaves", Some("solid"), false, DrawTarget::Radiance),
            masked: pipeline("masked leaves", Some("masked"), true, DrawTarget::Radiance),
            solid_shadow: pipeline("leaf shadow", None, false, DrawTarget::Shadow),
            masked_shadow: pipeline(
                "masked leaf shadow",
                Some("masked_shadow"),
                false,
                DrawTarget::Shadow,
            ),
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

    pub fn draw_shadow(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        forest: &GpuForest,
        visible: &[Visible],
    ) {
        draw_parts(
            pass,
            forest,
            visible,
            |model| &model.leaves,
            &forest.models,
            |pass, part| {
                pass.set_pipeline(if part.masked {
                    &self.masked_shadow
                } else {
                    &self.solid_shadow
                });
            },
        );
    }
}
