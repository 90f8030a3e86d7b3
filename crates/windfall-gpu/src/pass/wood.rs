//! Trunks and branches.

use super::{
    DrawRanges, ListedTrees, Shaders,
    draw::{Draw, DrawTarget},
    draw_parts, tree_instances,
};
use crate::forest::GpuForest;
use crate::model::{GpuModel, WoodVertex};

pub(crate) struct Wood {
    radiance: Pipelines,
    shadow: Pipelines,
}

/// Pipelines of fine levels and of coarse ones; each for wood of which both sides are drawn, since real
/// exports have open tubes and mixed winding, and for wood that faces outward.
type Pipelines = [[wgpu::RenderPipeline; 2]; 2];

impl Wood {
    pub fn new(shaders: &Shaders<'_>, part_layout: &wgpu::BindGroupLayout) -> Self {
        let vertices = wgpu::VertexBufferLayout {
            array_stride: size_of::<WoodVertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &WoodVertex::ATTRIBUTES,
        };
        let pipeline = |far: bool, outward: bool, label, fragment, target| {
            shaders.pipeline(&Draw {
                label,
                source: include_str!("../../shaders/wood.wgsl"),
                groups: &[part_layout],
                buffers: &[vertices.clone(), tree_instances()],
                cull: outward.then_some(wgpu::Face::Back),
                vertex: "vertex",
                fragment,
                alpha_to_coverage: false,
                target,
                constants: &[("far", f64::from(u8::from(far)))],
            })
        };
        let pipelines = |label, fragment, target| {
            [false, true].map(|far| {
                [false, true].map(|outward| pipeline(far, outward, label, fragment, target))
            })
        };
        Self {
            radiance: pipelines("wood", Some("fragment"), DrawTarget::Radiance),
            shadow: pipelines("wood shadow", None, DrawTarget::Shadow),
        }
    }

    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        forest: &GpuForest,
        trees: ListedTrees<'_>,
        into: DrawTarget,
    ) {
        let pipelines = if into == DrawTarget::Shadow { &self.shadow } else { &self.radiance };
        for (pipelines, far) in pipelines.iter().zip([false, true]) {
            let levels = |model: &GpuModel, of: &DrawRanges| {
                let coarse = of.1.start + model.fine_wood;
                if far { coarse..of.1.end } else { of.1.start..coarse }
            };
            draw_parts(
                pass,
                forest,
                trees,
                |model| &model.wood,
                levels,
                |pass, model| {
                    pass.set_pipeline(&pipelines[usize::from(model.outward)]);
                },
            );
        }
    }
}
