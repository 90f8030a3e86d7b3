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

/// Pipelines of branches whose bark is seen, of twigs and of wood far away; each for wood of which both
/// sides are drawn, since real exports have open tubes and mixed winding, and for wood that faces outward.
type Pipelines = [[wgpu::RenderPipeline; 2]; 3];

impl Wood {
    pub fn new(shaders: &Shaders<'_>, part_layout: &wgpu::BindGroupLayout) -> Self {
        let vertices = wgpu::VertexBufferLayout {
            array_stride: size_of::<WoodVertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &WoodVertex::ATTRIBUTES,
        };
        let pipeline = |(far, plain): (bool, bool), outward: bool, label, fragment, target| {
            shaders.pipeline(&Draw {
                label,
                source: include_str!("../../shaders/wood.wgsl"),
                groups: &[part_layout],
                buffers: &[vertices.clone(), tree_instances()],
                cull: outward.then_some(wgpu::Face::Back),
                vertex: "vertex",
                fragment,
                target,
                constants: &[("far", far.into()), ("plain", plain.into())],
            })
        };
        let pipelines = |label, fragment, target| {
            [(false, false), (false, true), (true, true)]
                .map(|kind| [false, true].map(|o| pipeline(kind, o, label, fragment, target)))
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
        for (pipelines, kind) in pipelines.iter().zip(0..) {
            let levels = |model: &GpuModel, of: &DrawRanges| {
                let twigs = of.1.start + model.wood_kinds[0];
                let far = twigs + model.wood_kinds[1];
                [of.1.start..twigs, twigs..far, far..of.1.end][kind].clone()
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
