//! Small leaves as quads: placed and lit by compute, once a leaf, then drawn all together.
//!
//! A leaf of a few pixels costs more before its pixels than in them: what its vertices have in common
//! is found four times, and on some devices vertices are shaded by few threads or an instance at a time.
//! Here a compute pass writes their corners in clip space, with their radiance, and one draw without
//! instances takes them from there.

use crate::base::constants::{BATCH, DRAW_WORDS, SIMPLE};
use crate::base::layouts::Layouts;
use crate::base::pipeline::{Draw, Target};
use crate::base::wgsl::{Module, Shaders, compose, text};
use crate::scene::forest::ForestBuffers;
use crate::view::quads::{CORNER, HangingQuads, QuadBuffers};
use wgpu::util::DeviceExt;

/// Settles which leaves are quads.
pub const ARRANGE_QUADS: Module = Module {
    name: "arrange_quads",
    source: |_| [&crate::base::constants::numbers(), include_str!("arrange_quads.wgsl")].concat(),
};

/// Places and lights them.
pub const HANGING_QUADS: Module = Module {
    name: "hanging_quads",
    source: |settings| {
        let sources = [
            text::INSTANCE,
            include_str!("leaves.wgsl"),
            text::QUADS,
            include_str!("hanging_quads.wgsl"),
        ];
        compose(settings, &sources)
    },
};

/// Draws them.
pub const QUADS: Module = Module {
    name: "quads",
    source: |settings| compose(settings, &[text::QUADS, include_str!("quads.wgsl")]),
};

/// Pipelines that arrange and spread quads, whatever leaves they are of.
pub struct Quads {
    arrange: wgpu::ComputePipeline,
    spread_hanging: wgpu::ComputePipeline,
}

impl Quads {
    pub fn new(shaders: &Shaders<'_>, layouts: &Layouts) -> Self {
        let groups = [&layouts.frame, &layouts.part, &layouts.spread_quads];
        Self {
            arrange: shaders.compute(&ARRANGE_QUADS, "arrange", &[&layouts.arrange_quads], &[]),
            spread_hanging: {
                let constants = [
                    ("form", SIMPLE.into()),
                    ("lit", 1.0),
                    ("lit_at_vertices", 1.0),
                    ("reach_at_vertices", 1.0),
                ];
                shaders.compute(&HANGING_QUADS, "spread", &groups, &constants)
            },
        }
    }

    /// Settles which leaves of the view's trees are drawn as quads, once their lists are made.
    pub fn arrange(&self, pass: &mut wgpu::ComputePass<'_>, quads: &HangingQuads) {
        pass.set_pipeline(&self.arrange);
        pass.set_bind_group(0, &quads.arrange_group, &[]);
        pass.dispatch_workgroups(1, 1, 1);
    }

    /// Places and lights them; group 0 is the frame's. After the shadow maps, which it looks up.
    pub fn spread(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        forest: &ForestBuffers,
        quads: &HangingQuads,
    ) {
        pass.set_pipeline(&self.spread_hanging);
        for (i, (model, group)) in (0..).zip(&quads.models) {
            pass.set_bind_group(1, &forest.models[*model].0.leaves.bind_group, &[]);
            pass.set_bind_group(2, group, &[]);
            let words = u64::from(DRAW_WORDS * quads.buffers.draws) + 3 * i;
            pass.dispatch_workgroups_indirect(&quads.buffers.arguments, words * 4);
        }
    }
}

/// Draws quads into one kind of target.
pub struct DrawQuads {
    pipeline: wgpu::RenderPipeline,
    /// The triangles of a batch.
    indices: wgpu::Buffer,
}

impl DrawQuads {
    /// Pipelines for a target with colours, or one of depth alone.
    pub fn new(shaders: &Shaders<'_>, layouts: &Layouts, target: Target) -> Self {
        let indices: Vec<u16> = (0..BATCH)
            .flat_map(|quad| [0, 1, 2, 0, 2, 3].map(|corner| (4 * quad + corner) as u16))
            .collect();
        Self {
            pipeline: shaders.pipeline(&Draw {
                label: "quads",
                module: &QUADS,
                groups: &[&layouts.frame],
                buffers: &[wgpu::VertexBufferLayout {
                    array_stride: CORNER,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: &wgpu::vertex_attr_array![0 => Uint32x4],
                }],
                cull: None,
                vertex: "vertex",
                fragment: target.lit().then_some("fragment"),
                target,
                constants: &[],
            }),
            indices: shaders.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("triangles of quads"),
                contents: bytemuck::cast_slice(&indices),
                usage: wgpu::BufferUsages::INDEX,
            }),
        }
    }

    /// Draws what was spread.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, quads: &HangingQuads) {
        let QuadBuffers { corners, arguments, draws } = &quads.buffers;
        pass.set_pipeline(&self.pipeline);
        pass.set_vertex_buffer(0, corners.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint16);
        pass.multi_draw_indexed_indirect(arguments, 0, *draws);
    }
}
