//! Leaves on their twigs.

use super::{draw_parts, tree_instances};
use crate::base::constants::{OUTLINES, PIXELS, SIMPLE, VIEWS};
use crate::base::layouts::Layouts;
use crate::base::pipeline::{Draw, Target};
use crate::base::wgsl::{Module, Shaders, compose, text};
use crate::scene::forest::ForestBuffers;
use crate::scene::leaf_mesh::LeafVertex;
use crate::scene::model::Part;
use crate::view::lists::TreeLists;
use windfall_core::simplify::FadeBy;

/// The module of leaves, on their twigs and loose.
pub const LEAVES: Module = Module {
    name: "leaves",
    source: |settings| compose(settings, &[text::INSTANCE, include_str!("leaves.wgsl")]),
};

/// Pipelines by form, for leaves that fade by size and by opacity.
pub struct Leaves {
    by_size: [Kinds; 3],
    by_opacity: [Kinds; 3],
}

/// Pipelines for leaves without textures, with textures, and with holes in them.
type Kinds = [wgpu::RenderPipeline; 3];

fn kind(part: &Part) -> usize {
    if part.masked { 2 } else { usize::from(part.textured) }
}

/// The forms of leaves: a list of trees for each.
const FORMS: [u32; 3] = [PIXELS, OUTLINES, SIMPLE]; // nearest first

impl Leaves {
    /// Pipelines for a target with colours, or one of depth alone.
    pub fn new(shaders: &Shaders<'_>, layouts: &Layouts, target: Target) -> Self {
        let vertices = wgpu::VertexBufferLayout {
            array_stride: size_of::<LeafVertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &LeafVertex::ATTRIBUTES,
        };
        let lit = target.lit();
        let pipeline = |form: u32, plain: bool, vertex, fragment: Option<&'static str>| {
            // Leaves with pictures are lit in pixels always.
            let at_vertices = lit && plain && form == SIMPLE;
            let outlines = vertex == "outline";
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
                    ("form", form.into()),
                    ("lit_at_vertices", (at_vertices || outlines).into()),
                    ("outlines", outlines.into()),
                    ("reach_at_vertices", (form == SIMPLE || form == OUTLINES && !plain).into()),
                    ("lit", lit.into()),
                ],
            })
        };
        let kinds = |form, vertex, solid, masked| {
            let textured = pipeline(form, false, vertex, solid);
            let plain = match form {
                _ if !lit => textured.clone(),
                OUTLINES if vertex == "vertex" => {
                    pipeline(form, true, "outline", Some("lit_outline"))
                }
                _ => pipeline(form, true, vertex, solid),
            };
            [plain, textured, pipeline(form, false, vertex, masked)]
        };
        if !lit {
            let fade = Some("fade_shadow");
            return Self {
                by_size: FORMS.map(|form| kinds(form, "vertex", None, Some("masked_shadow"))),
                by_opacity: FORMS.map(|form| kinds(form, "opaque_vertex", fade, fade)),
            };
        }
        let (fade, masked) = (Some("solid_fade"), Some("masked_fade"));
        Self {
            by_size: FORMS.map(|form| kinds(form, "vertex", Some("solid"), Some("masked"))),
            by_opacity: FORMS.map(|form| kinds(form, "opaque_vertex", fade, masked)),
        }
    }

    /// Draws the leaves of the trees of a view, 0 for the camera's.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        forest: &ForestBuffers,
        (lists, view): (&TreeLists, usize),
        fade: FadeBy,
    ) {
        let forms = match fade {
            FadeBy::Size => &self.by_size,
            FadeBy::Opacity => &self.by_opacity,
        };
        for (form, pipelines) in FORMS.into_iter().zip(forms) {
            if form == PIXELS && view > 0 {
                continue; // shadows have no light
            }
            let list = (form * VIEWS) as usize + view;
            draw_parts(
                pass,
                forest,
                (lists, list),
                |model| &model.leaves,
                |_, draws| {
                    if form == SIMPLE { draws.simple.clone() } else { draws.outlines.clone() }
                },
                |pass, model| pass.set_pipeline(&pipelines[kind(&model.leaves)]),
            );
        }
    }
}
