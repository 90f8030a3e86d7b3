//! Leaves on their twigs.

use super::{
    ListedTrees, Shaders,
    draw::{Draw, DrawTarget},
    draw_parts, tree_instances,
};
use crate::cull::WHOLE_PARTS;
use crate::forest::GpuForest;
use crate::model::{LeafVertex, Part};
use crate::view::View;
use windfall_core::simplify::FadeBy;

pub(crate) struct Leaves {
    radiance: Pipelines,
    shadow: Pipelines,
}

/// Pipelines of trees that are near, the second where quality has no lighting in pixels, of those less near,
/// whose leaves are lit at their vertices, of those whose leaves are small, and of simplified trees.
struct Pipelines {
    near: Kinds,
    with_midribs: Kinds,
    at_vertices: Kinds,
    small: Kinds,
    by_size: Kinds,
    by_opacity: Kinds,
}

/// Where leaves are lit.
#[derive(Clone, Copy, PartialEq)]
enum Lit {
    InPixels,
    AtVertices,
    /// The same, large enough to have midribs.
    WithMidribs,
    Once,
}

impl Lit {
    /// Whether each vertex is lit for itself.
    fn outlines(self) -> bool {
        matches!(self, Self::AtVertices | Self::WithMidribs)
    }
}

/// Pipelines for leaves without pictures, with pictures, and with holes in them.
type Kinds = [wgpu::RenderPipeline; 3];

fn kind(part: &Part) -> usize {
    if part.masked { 2 } else { usize::from(part.pictures) }
}

impl Leaves {
    pub fn new(shaders: &Shaders<'_>, part_layout: &wgpu::BindGroupLayout) -> Self {
        let vertices = wgpu::VertexBufferLayout {
            array_stride: size_of::<LeafVertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &LeafVertex::ATTRIBUTES,
        };
        let pipeline = |far: bool, lit: Lit, vertex, fragment: Option<&'static str>, target| {
            shaders.pipeline(&Draw {
                label: fragment.unwrap_or("leaf shadow"),
                source: include_str!("../../shaders/leaves.wgsl"),
                groups: &[part_layout],
                buffers: &[vertices.clone(), tree_instances()],
                cull: None,
                vertex,
                fragment,
                target,
                constants: &[
                    ("far", f64::from(u8::from(far))),
                    ("lit_at_vertices", (lit != Lit::InPixels).into()),
                    ("outlines", lit.outlines().into()),
                    ("midribs", (lit == Lit::WithMidribs).into()),
                    ("lit", f64::from(u8::from(target == DrawTarget::Radiance))),
                ],
            })
        };
        let kinds = |far, vertex, solid, masked, target| {
            let radiance = target == DrawTarget::Radiance;
            let with_pictures = pipeline(far, Lit::InPixels, vertex, solid, target);
            let plain = if far && radiance {
                pipeline(far, Lit::Once, vertex, solid, target)
            } else {
                with_pictures.clone()
            };
            [plain, with_pictures, pipeline(far, Lit::InPixels, vertex, masked, target)]
        };
        let near = kinds(false, "vertex", Some("solid"), Some("masked"), DrawTarget::Radiance);
        let near_shadow = kinds(false, "vertex", None, Some("masked_shadow"), DrawTarget::Shadow);
        let [with_midribs, at_vertices, small] = [Lit::WithMidribs, Lit::AtVertices, Lit::Once]
            .map(|lit| {
                let mut kinds = near.clone();
                let (vertex, fragment) =
                    if lit.outlines() { ("outline", "lit_outline") } else { ("vertex", "solid") };
                kinds[0] = pipeline(false, lit, vertex, Some(fragment), DrawTarget::Radiance);
                kinds
            });
        let (picture, map) = (DrawTarget::Radiance, DrawTarget::Shadow);
        let fade = Some("fade_shadow");
        Self {
            radiance: Pipelines {
                near,
                with_midribs,
                at_vertices,
                small,
                by_size: kinds(true, "vertex", Some("solid"), Some("masked"), picture),
                by_opacity: kinds(
                    true,
                    "opaque_vertex",
                    Some("solid_fade"),
                    Some("masked_fade"),
                    picture,
                ),
            },
            shadow: Pipelines {
                with_midribs: near_shadow.clone(),
                at_vertices: near_shadow.clone(),
                small: near_shadow.clone(),
                near: near_shadow,
                by_size: kinds(true, "vertex", None, Some("masked_shadow"), map),
                by_opacity: kinds(true, "opaque_vertex", fade, fade, map),
            },
        }
    }

    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        forest: &GpuForest,
        trees: ListedTrees<'_>,
        view: &View,
        into: DrawTarget,
    ) {
        let (pipelines, detail) = if into == DrawTarget::Shadow {
            (&self.shadow, &view.shadow_detail)
        } else {
            (&self.radiance, &view.detail)
        };
        let far = match detail.fade.by {
            FadeBy::Size => &pipelines.by_size,
            FadeBy::Opacity => &pipelines.by_opacity,
        };
        let near =
            if view.quality.pixel_lighting { &pipelines.near } else { &pipelines.with_midribs };
        for (pipelines, parts) in [
            (near, 0..1),
            (&pipelines.at_vertices, 1..2),
            (&pipelines.small, 2..WHOLE_PARTS),
            (far, WHOLE_PARTS..u32::MAX),
        ] {
            draw_parts(
                pass,
                forest,
                trees,
                |model| &model.leaves,
                |_, draws| {
                    let at = |part: u32| draws.0.end.min(draws.0.start.saturating_add(part));
                    at(parts.start)..at(parts.end)
                },
                |pass, model| pass.set_pipeline(&pipelines[kind(&model.leaves)]),
            );
        }
    }
}
