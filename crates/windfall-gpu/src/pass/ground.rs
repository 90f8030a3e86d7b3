//! The terrain, out to the horizon.

use crate::base::layouts::Layouts;
use crate::base::pipeline::{Draw, Target};
use crate::base::wgsl::{Module, Shaders, compose};
use crate::scene::ground::{GroundMesh, GroundVertex};

/// The terrain's module.
pub const GROUND: Module =
    Module { name: "ground", source: |settings| compose(settings, &[include_str!("ground.wgsl")]) };

/// Draws the terrain.
pub struct Ground {
    /// Without single dead leaves, and with them.
    pipelines: [wgpu::RenderPipeline; 2],
}

impl Ground {
    pub fn new(shaders: &Shaders<'_>, layouts: &Layouts, target: Target) -> Self {
        let vertices = wgpu::VertexBufferLayout {
            array_stride: size_of::<GroundVertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3],
        };
        let pipeline = |detail: bool| {
            shaders.pipeline(&Draw {
                label: "ground",
                module: &GROUND,
                groups: &[&layouts.frame],
                buffers: std::slice::from_ref(&vertices),
                cull: Some(wgpu::Face::Back),
                vertex: "vertex",
                fragment: Some("fragment"),
                target,
                constants: &[("detail", detail.into())],
            })
        };
        Self { pipelines: [false, true].map(pipeline) }
    }

    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, mesh: &GroundMesh, detail: bool) {
        pass.set_pipeline(&self.pipelines[usize::from(detail)]);
        pass.set_vertex_buffer(0, mesh.vertices.slice(..));
        pass.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..mesh.index_count, 0, 0..1);
    }
}
