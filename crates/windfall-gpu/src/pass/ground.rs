//! The terrain, out to the horizon.

use crate::base::layouts::Layouts;
use crate::base::pipeline::{Draw, Target};
use crate::base::wgsl::{Module, Shaders, compose, text};
use crate::scene::ground::{GroundMesh, Square, constants};
use crate::view::ground::GroundSquares;

/// The terrain's module.
pub const GROUND: Module = Module {
    name: "ground",
    source: |settings| {
        compose(settings, &[&constants(), text::HEIGHTS, include_str!("ground.wgsl")])
    },
};

/// Draws the terrain.
pub struct Ground {
    /// Without single dead leaves, and with them.
    pipelines: [wgpu::RenderPipeline; 2],
}

impl Ground {
    pub fn new(shaders: &Shaders<'_>, layouts: &Layouts, target: Target) -> Self {
        let squares = wgpu::VertexBufferLayout {
            array_stride: size_of::<Square>() as u64,
            step_mode: wgpu::VertexStepMode::Instance,
            attributes: &wgpu::vertex_attr_array![
                0 => Float32x2, 1 => Float32, 2 => Float32, 3 => Sint32x2
            ],
        };
        let pipeline = |detail: bool| {
            shaders.pipeline(&Draw {
                label: "ground",
                module: &GROUND,
                groups: &[&layouts.frame, &layouts.heights],
                buffers: std::slice::from_ref(&squares),
                cull: Some(wgpu::Face::Back),
                vertex: "vertex",
                fragment: Some("fragment"),
                target,
                constants: &[("detail", detail.into())],
            })
        };
        Self { pipelines: [false, true].map(pipeline) }
    }

    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        (mesh, squares): (&GroundMesh, &GroundSquares),
        detail: bool,
    ) {
        pass.set_pipeline(&self.pipelines[usize::from(detail)]);
        pass.set_bind_group(1, &mesh.heights, &[]);
        pass.set_vertex_buffer(0, squares.buffer.slice(..));
        pass.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint16);
        pass.draw_indexed(0..mesh.index_count, 0, 0..squares.count);
    }
}
