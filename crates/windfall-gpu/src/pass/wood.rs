//! Trunks and branches.

use super::{
    DrawRanges, ListedTrees, Shaders,
    draw::{Draw, DrawTarget},
    draw_parts, tree_instances,
};
use crate::forest::GpuForest;
use crate::model::{GpuModel, WoodVertex};

/// Pipelines of fine levels and of coarse ones.
pub(crate) struct Wood {
    radiance: [wgpu::RenderPipeline; 2],
    shadow: [wgpu::RenderPipeline; 2],
}

impl Wood {
    pub fn new(shaders: &Shaders<'_>, part_layout: &wgpu::BindGroupLayout) -> Self {
        let vertices = wgpu::VertexBufferLayout {
            array_stride: size_of::<WoodVertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &WoodVertex::ATTRIBUTES,
        };
        let pipeline = |far: bool, label, fragment, target| {
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
                constants: &[("far", f64::from(u8::from(far)))],
            })
        };
        Self {
            radiance: [false, true]
                .map(|far| pipeline(far, "wood", Some("fragment"), DrawTarget::Radiance)),
            shadow: [false, true].map(|far| pipeline(far, "wood shadow", None, DrawTarget::Shadow)),
        }
    }

    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        forest: &GpuForest,
        trees: ListedTrees<'_>,
        into: DrawTarget,
    ) {
        let [near, far] = if into == DrawTarget::Shadow { &self.shadow } else { &self.radiance };
        pass.set_pipeline(near);
        let levels = |model: &GpuModel, of: &DrawRanges| of.1.start..of.1.start + model.fine_wood;
        draw_parts(pass, forest, trees, |model| &model.wood, levels, |_, _| {});
        pass.set_pipeline(far);
        let levels = |model: &GpuModel, of: &DrawRanges| of.1.start + model.fine_wood..of.1.end;
        draw_parts(pass, forest, trees, |model| &model.wood, levels, |_, _| {});
    }
}
