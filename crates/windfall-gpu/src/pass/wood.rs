//! Trunks and branches.

use super::{
    ListedTrees, Shaders,
    draw::{Draw, DrawTarget},
    draw_parts, tree_instances,
};
use crate::forest::GpuForest;
use crate::model::WoodVertex;

pub(crate) struct Wood {
    pipeline: wgpu::RenderPipeline,
    shadow: wgpu::RenderPipeline,
}

impl Wood {
    pub fn new(shaders: &Shaders<'_>, part_layout: &wgpu::BindGroupLayout) -> Self {
        let vertices = wgpu::VertexBufferLayout {
            array_stride: size_of::<WoodVertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &WoodVertex::ATTRIBUTES,
        };
        let pipeline = |label, fragment, target| {
            shaders.pipeline(&Draw {
                label,
                source: include_str!("../../shaders/wood.wgsl"),
                groups: &[part_layout],
                buffers: &[vertices.clone(), tree_instances()],
                // Real exports have open tubes and mixed winding: both sides are drawn.
                cull: None,
                vertex: "vertex",
                fragment,
                alpha_to_coverage: false,
                target,
                constants: &[],
            })
        };
        Self {
            pipeline: pipeline("wood", Some("fragment"), DrawTarget::Radiance),
            shadow: pipeline("wood shadow", None, DrawTarget::Shadow),
        }
    }

    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        forest: &GpuForest,
        trees: ListedTrees<'_>,
        into: DrawTarget,
    ) {
        pass.set_pipeline(if into == DrawTarget::Shadow { &self.shadow } else { &self.pipeline });
        draw_parts(pass, forest, trees, |model| &model.wood, |draws| draws.1.clone(), |_, _| {});
    }
}
