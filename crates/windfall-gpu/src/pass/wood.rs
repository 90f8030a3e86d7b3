//! Trunks and branches.

use super::{draw_parts, tree_instances};
use crate::base::layouts::Layouts;
use crate::base::pipeline::{Draw, Target};
use crate::base::wgsl::{Module, Shaders, compose, text};
use crate::scene::forest::ForestBuffers;
use crate::scene::model::{ModelData, WoodVertex};
use crate::scene::trees::DrawRanges;
use crate::view::lists::TreeLists;

/// The wood's module.
pub const WOOD: Module = Module {
    name: "wood",
    source: |settings| compose(settings, &[text::INSTANCE, include_str!("wood.wgsl")]),
};

/// Pipelines of branches whose bark is seen, of twigs and of wood far away; each for wood of which both
/// sides are drawn, since real exports have open tubes and mixed winding, and for wood that faces outward.
pub struct Wood {
    pipelines: [[wgpu::RenderPipeline; 2]; 3],
}

impl Wood {
    /// Pipelines for a target with colours, or one of depth alone.
    pub fn new(shaders: &Shaders<'_>, layouts: &Layouts, target: Target) -> Self {
        let vertices = wgpu::VertexBufferLayout {
            array_stride: size_of::<WoodVertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &WoodVertex::ATTRIBUTES,
        };
        let pipeline = |(far, plain): (bool, bool), outward: bool| {
            shaders.pipeline(&Draw {
                label: if target.lit() { "wood" } else { "wood shadow" },
                module: &WOOD,
                groups: &[&layouts.frame, &layouts.part],
                buffers: &[vertices.clone(), tree_instances()],
                cull: outward.then_some(wgpu::Face::Back),
                vertex: "vertex",
                fragment: target.lit().then_some("fragment"),
                target,
                constants: &[("far", far.into()), ("plain", plain.into())],
            })
        };
        let kinds = [(false, false), (false, true), (true, true)];
        Self { pipelines: kinds.map(|kind| [false, true].map(|outward| pipeline(kind, outward))) }
    }

    /// Draws the wood of a list of trees.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        forest: &ForestBuffers,
        (lists, list): (&TreeLists, usize),
    ) {
        for (pipelines, kind) in self.pipelines.iter().zip(0..) {
            let levels = |model: &ModelData, of: &DrawRanges| {
                let twigs = of.wood.start + model.wood_kinds[0];
                let far = twigs + model.wood_kinds[1];
                [of.wood.start..twigs, twigs..far, far..of.wood.end][kind].clone()
            };
            draw_parts(
                pass,
                forest,
                (lists, list),
                |model| &model.wood,
                levels,
                |pass, model| {
                    pass.set_pipeline(&pipelines[usize::from(model.outward)]);
                },
            );
        }
    }
}
