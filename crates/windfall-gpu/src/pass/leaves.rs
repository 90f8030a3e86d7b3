//! Leaves on their twigs.

use super::{draw_parts, tree_instances};
use crate::base::layouts::Layouts;
use crate::base::pipeline::{Draw, Target};
use crate::base::wgsl::{Module, Shaders, compose, text};
use crate::scene::forest::ForestBuffers;
use crate::scene::leaf_mesh::LeafVertex;
use crate::scene::model::Part;
use crate::scene::parts::WHOLE_PARTS;
use crate::view::lists::TreeLists;
use windfall_core::simplify::FadeBy;

/// The module of leaves, on their twigs and loose.
pub const LEAVES: Module = Module {
    name: "leaves",
    source: |settings| compose(settings, &[text::INSTANCE, include_str!("leaves.wgsl")]),
};

/// Pipelines of trees that are near, the second where quality has no lighting in pixels, of those less near,
/// whose leaves are lit at their vertices, of those whose leaves are small, and of simplified trees.
pub struct Leaves {
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

/// Pipelines for leaves without textures, with textures, and with holes in them.
type Kinds = [wgpu::RenderPipeline; 3];

fn kind(part: &Part) -> usize {
    if part.masked { 2 } else { usize::from(part.textured) }
}

/// What leaves are drawn with.
#[derive(Debug, Clone, Copy)]
pub struct LeafStyle {
    /// How they fade.
    pub fade: FadeBy,
    /// Whether large ones are lit in each pixel.
    pub pixel_lighting: bool,
}

impl Leaves {
    /// Pipelines for a target with colours, or one of depth alone.
    pub fn new(shaders: &Shaders<'_>, layouts: &Layouts, target: Target) -> Self {
        let vertices = wgpu::VertexBufferLayout {
            array_stride: size_of::<LeafVertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &LeafVertex::ATTRIBUTES,
        };
        let pipeline = |far: bool, lit: Lit, vertex, fragment: Option<&'static str>| {
            shaders.pipeline(&Draw {
                label: fragment.unwrap_or("leaf shadow"),
                module: &LEAVES,
                groups: &[&layouts.frame, &layouts.part],
                buffers: &[vertices.clone(), tree_instances()],
                cull: None,
                vertex,
                fragment,
                target,
                constants: &[
                    ("far", far.into()),
                    ("lit_at_vertices", (lit != Lit::InPixels).into()),
                    ("outlines", lit.outlines().into()),
                    ("midribs", (lit == Lit::WithMidribs).into()),
                    ("lit", target.lit().into()),
                ],
            })
        };
        let kinds = |far, vertex, solid, masked| {
            let textured = pipeline(far, Lit::InPixels, vertex, solid);
            let plain = if far && target.lit() {
                pipeline(far, Lit::Once, vertex, solid)
            } else {
                textured.clone()
            };
            [plain, textured, pipeline(far, Lit::InPixels, vertex, masked)]
        };
        if !target.lit() {
            let near = kinds(false, "vertex", None, Some("masked_shadow"));
            let fade = Some("fade_shadow");
            return Self {
                with_midribs: near.clone(),
                at_vertices: near.clone(),
                small: near.clone(),
                near,
                by_size: kinds(true, "vertex", None, Some("masked_shadow")),
                by_opacity: kinds(true, "opaque_vertex", fade, fade),
            };
        }
        let near = kinds(false, "vertex", Some("solid"), Some("masked"));
        let [with_midribs, at_vertices, small] = [Lit::WithMidribs, Lit::AtVertices, Lit::Once]
            .map(|lit| {
                let mut kinds = near.clone();
                let (vertex, fragment) =
                    if lit.outlines() { ("outline", "lit_outline") } else { ("vertex", "solid") };
                kinds[0] = pipeline(false, lit, vertex, Some(fragment));
                kinds
            });
        Self {
            near,
            with_midribs,
            at_vertices,
            small,
            by_size: kinds(true, "vertex", Some("solid"), Some("masked")),
            by_opacity: kinds(true, "opaque_vertex", Some("solid_fade"), Some("masked_fade")),
        }
    }

    /// Draws the leaves of a list of trees.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        forest: &ForestBuffers,
        (lists, list): (&TreeLists, usize),
        style: LeafStyle,
    ) {
        let far = match style.fade {
            FadeBy::Size => &self.by_size,
            FadeBy::Opacity => &self.by_opacity,
        };
        let near = if style.pixel_lighting { &self.near } else { &self.with_midribs };
        for (pipelines, parts) in [
            (near, 0..1),
            (&self.at_vertices, 1..2),
            (&self.small, 2..WHOLE_PARTS),
            (far, WHOLE_PARTS..u32::MAX),
        ] {
            draw_parts(
                pass,
                forest,
                (lists, list),
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
