//! What a view draws of the leaves that have left their twigs.

use crate::base::constants::BLOCK;
use crate::base::layouts::Layouts;
use crate::base::pipeline::{Draw, Target};
use crate::base::shared::LooseLeaf;
use crate::base::wgsl::{Module, Shaders, compose, text};
use crate::pass::leaves::LEAVES;
use crate::scene::falls::LooseState;
use crate::scene::forest::ForestBuffers;
use crate::scene::loose_shapes::ShapeVertex;
use crate::view::state::LooseView;

/// The module that gathers.
pub const GATHER: Module = Module {
    name: "gather",
    source: |settings| {
        compose(settings, &[text::SIMPLIFY, text::REST, include_str!("gather.wgsl")])
    },
};

/// Posed leaves, an instance each.
pub const LEAF: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: size_of::<LooseLeaf>() as u64,
    step_mode: wgpu::VertexStepMode::Instance,
    attributes: &wgpu::vertex_attr_array![
        3 => Float32x4, 4 => Snorm16x4, 5 => Unorm8x4, 6 => Uint32
    ],
};

/// Gathers loose leaves for a view.
pub struct Gather {
    levels: wgpu::ComputePipeline,
    select: wgpu::ComputePipeline,
    leaves: wgpu::ComputePipeline,
}

impl Gather {
    pub fn new(shaders: &Shaders<'_>, layouts: &Layouts) -> Self {
        let groups = [&layouts.frame, &layouts.gather];
        Self {
            levels: shaders.compute(&GATHER, "levels", &groups, &[]),
            select: shaders.compute(&GATHER, "select_groups", &groups, &[]),
            leaves: shaders.compute(&GATHER, "gather", &groups, &[]),
        }
    }

    /// Finds how streams are drawn, and which groups of slots may have leaves in view.
    pub fn select(&self, pass: &mut wgpu::ComputePass<'_>, loose: &LooseState, view: &LooseView) {
        pass.set_bind_group(1, &view.group, &[]);
        pass.set_pipeline(&self.levels);
        pass.dispatch_workgroups((loose.streams.all.len() as u32).div_ceil(BLOCK), 1, 1);
        pass.set_pipeline(&self.select);
        pass.dispatch_workgroups((loose.streams.groups.len() as u32).div_ceil(BLOCK), 1, 1);
    }

    /// Gathers the leaves in view from the groups that were selected.
    pub fn run(&self, pass: &mut wgpu::ComputePass<'_>, view: &LooseView) {
        pass.set_bind_group(1, &view.group, &[]);
        pass.set_pipeline(&self.leaves);
        pass.dispatch_workgroups_indirect(&view.indirect, 0);
    }
}

/// Pipelines that draw loose leaves into one kind of target.
pub struct LooseLeaves {
    solid: wgpu::RenderPipeline,
    masked: wgpu::RenderPipeline,
    /// Of leaves of a few pixels.
    small: wgpu::RenderPipeline,
}

impl LooseLeaves {
    pub fn new(shaders: &Shaders<'_>, layouts: &Layouts, target: Target) -> Self {
        let lit = target.lit();
        let draw = |label, fragment, lit_at_vertices: bool| {
            shaders.pipeline(&Draw {
                label,
                module: &LEAVES,
                groups: &[&layouts.frame, &layouts.part],
                buffers: &[ShapeVertex::LAYOUT, LEAF],
                cull: None,
                vertex: "loose",
                fragment,
                target,
                constants: &[("lit_at_vertices", lit_at_vertices.into())],
            })
        };
        let solid = draw("loose leaves", lit.then_some("solid"), false);
        Self {
            masked: draw(
                "masked loose leaves",
                Some(if lit { "masked" } else { "masked_shadow" }),
                false,
            ),
            small: if lit {
                draw("small loose leaves", Some("small"), true)
            } else {
                solid.clone()
            },
            solid,
        }
    }

    /// Draws what a view has gathered.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, forest: &ForestBuffers, view: &LooseView) {
        for (i, bin) in forest.loose.streams.bins.iter().enumerate() {
            let part = &forest.models[bin.model].0.leaves;
            pass.set_pipeline(if part.masked { &self.masked } else { &self.solid });
            pass.set_bind_group(1, &part.bind_group, &[]);
            forest.models[bin.model].0.loose.shapes[bin.shape].full.set(pass);
            pass.set_vertex_buffer(1, view.leaves_of(bin));
            pass.draw_indexed_indirect(&view.counters, view.arguments_of(i, false));
        }
        pass.set_pipeline(&self.small);
        for (i, bin) in forest.loose.streams.bins.iter().enumerate() {
            let model = &forest.models[bin.model].0;
            let Some(shape) = &model.loose.shapes[bin.shape].small else { continue };
            pass.set_bind_group(1, &model.leaves.bind_group, &[]);
            shape.set(pass);
            pass.set_vertex_buffer(1, view.leaves_of(bin));
            pass.draw_indexed_indirect(&view.counters, view.arguments_of(i, true));
        }
    }
}
