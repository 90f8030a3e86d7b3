//! Grass about the camera.

use crate::base::layouts::Layouts;
use crate::base::pipeline::{Draw, Target};
use crate::base::wgsl::{Module, Shaders, compose};
use crate::scene::ground::GroundMesh;

/// Cells along a side of the square about the camera, rings of such squares, and blades of a tuft.
const SIDE: u32 = 128;
const RINGS: u32 = 2;
const BLADES: u32 = 5;

/// The grass's module.
pub const GRASS: Module = Module {
    name: "grass",
    source: |settings| {
        let numbers = format!("const SIDE: u32 = {SIDE}u;\nconst BLADES: u32 = {BLADES}u;\n");
        compose(settings, &[&numbers, include_str!("grass.wgsl")])
    },
};

/// Draws grass.
pub struct Grass {
    pipeline: wgpu::RenderPipeline,
}

impl Grass {
    pub fn new(shaders: &Shaders<'_>, layouts: &Layouts, target: Target) -> Self {
        let pipeline = shaders.pipeline(&Draw {
            label: "grass",
            module: &GRASS,
            groups: &[&layouts.frame, &layouts.heights],
            buffers: &[],
            cull: None,
            vertex: "vertex",
            fragment: Some("fragment"),
            target,
            constants: &[],
        });
        Self { pipeline }
    }

    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, ground: &GroundMesh) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(1, &ground.heights, &[]);
        pass.draw(0..3 * BLADES, 0..RINGS * SIDE * SIDE);
    }
}
