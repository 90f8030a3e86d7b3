//! Leaves on their twigs.

use super::{
    ListedTrees, Shaders,
    draw::{Draw, DrawTarget},
    draw_parts, tree_instances,
};
use crate::forest::GpuForest;
use crate::model::LeafVertex;
use windfall_core::simplify::FadeBy;

pub(crate) struct Leaves {
    radiance: Pipelines,
    shadow: Pipelines,
}

/// Pipelines for leaves without and with holes.
struct Pipelines {
    by_size: [wgpu::RenderPipeline; 2],
    by_opacity: [wgpu::RenderPipeline; 2],
}

impl Leaves {
    pub fn new(shaders: &Shaders<'_>, part_layout: &wgpu::BindGroupLayout) -> Self {
        let vertices = wgpu::VertexBufferLayout {
            array_stride: size_of::<LeafVertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &LeafVertex::ATTRIBUTES,
        };
        let pipeline = |vertex, fragment: Option<&'static str>, alpha_to_coverage, target| {
            shaders.pipeline(&Draw {
                label: fragment.unwrap_or("leaf shadow"),
                source: include_str!("../../shaders/leaves.wgsl"),
                groups: &[part_layout],
                buffers: &[vertices.clone(), tree_instances()],
                cull: None,
                vertex,
                fragment,
                alpha_to_coverage,
                target,
            })
        };
        let (picture, map) = (DrawTarget::Radiance, DrawTarget::Shadow);
        Self {
            radiance: Pipelines {
                by_size: [
                    pipeline("vertex", Some("solid"), false, picture),
                    pipeline("vertex", Some("masked"), true, picture),
                ],
                by_opacity: [
                    pipeline("opaque_vertex", Some("solid_fade"), false, picture),
                    pipeline("opaque_vertex", Some("masked_fade"), true, picture),
                ],
            },
            shadow: Pipelines {
                by_size: [
                    pipeline("vertex", None, false, map),
                    pipeline("vertex", Some("masked_shadow"), false, map),
                ],
                by_opacity: [
                    pipeline("opaque_vertex", Some("fade_shadow"), false, map),
                    pipeline("opaque_vertex", Some("fade_shadow"), false, map),
                ],
            },
        }
    }

    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        forest: &GpuForest,
        trees: ListedTrees<'_>,
        fade: FadeBy,
        into: DrawTarget,
    ) {
        let pipelines = if into == DrawTarget::Shadow { &self.shadow } else { &self.radiance };
        let pipelines = match fade {
            FadeBy::Size => &pipelines.by_size,
            FadeBy::Opacity => &pipelines.by_opacity,
        };
        draw_parts(
            pass,
            forest,
            trees,
            |model| &model.leaves,
            |draws| draws.0.clone(),
            |pass, part| pass.set_pipeline(&pipelines[usize::from(part.masked)]),
        );
    }
}
