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

/// Pipelines for leaves without and with holes: of trees in full, which have no leaf that fades, and
/// of simplified trees.
struct Pipelines {
    near: [wgpu::RenderPipeline; 2],
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
        let pipeline =
            |far: bool, vertex, fragment: Option<&'static str>, alpha_to_coverage, target| {
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
                    constants: &[
                        ("far", f64::from(u8::from(far))),
                        ("lit", f64::from(u8::from(target == DrawTarget::Radiance))),
                    ],
                })
            };
        let (picture, map) = (DrawTarget::Radiance, DrawTarget::Shadow);
        Self {
            radiance: Pipelines {
                near: [
                    pipeline(false, "vertex", Some("solid"), false, picture),
                    pipeline(false, "vertex", Some("masked"), true, picture),
                ],
                by_size: [
                    pipeline(true, "vertex", Some("solid"), false, picture),
                    pipeline(true, "vertex", Some("masked"), true, picture),
                ],
                by_opacity: [
                    pipeline(true, "opaque_vertex", Some("solid_fade"), false, picture),
                    pipeline(true, "opaque_vertex", Some("masked_fade"), true, picture),
                ],
            },
            shadow: Pipelines {
                near: [
                    pipeline(false, "vertex", None, false, map),
                    pipeline(false, "vertex", Some("masked_shadow"), false, map),
                ],
                by_size: [
                    pipeline(true, "vertex", None, false, map),
                    pipeline(true, "vertex", Some("masked_shadow"), false, map),
                ],
                by_opacity: [
                    pipeline(true, "opaque_vertex", Some("fade_shadow"), false, map),
                    pipeline(true, "opaque_vertex", Some("fade_shadow"), false, map),
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
        let far = match fade {
            FadeBy::Size => &pipelines.by_size,
            FadeBy::Opacity => &pipelines.by_opacity,
        };
        for (pipelines, near) in [(&pipelines.near, true), (far, false)] {
            draw_parts(
                pass,
                forest,
                trees,
                |model| &model.leaves,
                |_, draws| {
                    let of_near = draws.0.end.min(draws.0.start + 1);
                    if near { draws.0.start..of_near } else { of_near..draws.0.end }
                },
                |pass, model| pass.set_pipeline(&pipelines[usize::from(model.leaves.masked)]),
            );
        }
    }
}
