//! Grass about the camera: found by compute, a tuft at a time, then drawn without instances.

use crate::base::constants::BLOCK;
use crate::base::layouts::Layouts;
use crate::base::pipeline::{Draw, Target};
use crate::base::wgsl::{Module, Settings, Shaders, compose, text};
use crate::scene::ground::GroundMesh;
use crate::view::grass::{BLADES, SIDE, TUFTS, ViewGrass};

fn module(settings: Settings, source: &str) -> String {
    let numbers = format!("const SIDE: u32 = {SIDE}u;\nconst BLADES: u32 = {BLADES}u;\n");
    compose(&settings, &[&numbers, text::HEIGHTS, include_str!("tuft.wgsl"), source])
}

/// Finds the grass of a view.
pub const FIND_GRASS: Module = Module {
    name: "find_grass",
    source: |settings| module(*settings, include_str!("find_grass.wgsl")),
};

/// Draws it.
pub const GRASS: Module =
    Module { name: "grass", source: |settings| module(*settings, include_str!("grass.wgsl")) };

/// Finds and draws grass.
pub struct Grass {
    find: wgpu::ComputePipeline,
    draw: wgpu::RenderPipeline,
}

impl Grass {
    pub fn new(shaders: &Shaders<'_>, layouts: &Layouts, target: Target) -> Self {
        let groups = |of| [&layouts.frame, &layouts.heights, of];
        Self {
            find: shaders.compute(&FIND_GRASS, "find", &groups(&layouts.find_grass), &[]),
            draw: shaders.pipeline(&Draw {
                label: "grass",
                module: &GRASS,
                groups: &groups(&layouts.grass),
                buffers: &[],
                cull: None,
                vertex: "vertex",
                fragment: Some("fragment"),
                target,
                constants: &[],
            }),
        }
    }

    /// Finds the grass of a view; group 0 is the frame's.
    pub fn find(
        &self,
        queue: &wgpu::Queue,
        pass: &mut wgpu::ComputePass<'_>,
        ground: &GroundMesh,
        grass: &ViewGrass,
    ) {
        // No vertex yet, one instance.
        queue.write_buffer(&grass.found, 0, bytemuck::bytes_of(&[0_u32, 1, 0, 0, 0]));
        pass.set_pipeline(&self.find);
        pass.set_bind_group(1, &ground.heights, &[]);
        pass.set_bind_group(2, &grass.find_group, &[]);
        pass.dispatch_workgroups(TUFTS / BLOCK, 1, 1);
    }

    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, ground: &GroundMesh, grass: &ViewGrass) {
        pass.set_pipeline(&self.draw);
        pass.set_bind_group(1, &ground.heights, &[]);
        pass.set_bind_group(2, &grass.draw_group, &[]);
        pass.draw_indirect(&grass.found, 0);
    }
}
