//! The sky behind everything.

use crate::base::constants::LAND_SIDES;
use crate::base::layouts::Layouts;
use crate::base::pipeline::{Draw, Target};
use crate::base::wgsl::{Module, Shaders, compose};

/// The sky's module.
pub const SKY: Module =
    Module { name: "sky", source: |settings| compose(settings, &[include_str!("sky.wgsl")]) };

/// Rows of hills; one of trees stands before them.
const HILLS: u32 = 3;
/// Vertices of a row: walls of two triangles.
const WALLS: u32 = LAND_SIDES * 6;

/// Draws the sky, and the land beyond the terrain.
pub struct SkyDome {
    sky: wgpu::RenderPipeline,
    hills: wgpu::RenderPipeline,
    trees: wgpu::RenderPipeline,
}

impl SkyDome {
    pub fn new(shaders: &Shaders<'_>, layouts: &Layouts, target: Target) -> Self {
        let reversed =
            target.depth.is_none_or(|depth| depth.compare == wgpu::CompareFunction::GreaterEqual);
        let pipeline = |label, vertex, fragment, target| {
            shaders.pipeline(&Draw {
                label,
                module: &SKY,
                groups: &[&layouts.frame],
                buffers: &[],
                cull: None,
                vertex,
                fragment: Some(fragment),
                target,
                constants: &[("behind", if reversed { 0.0 } else { 1.0 })],
            })
        };
        let land = |label, fragment| pipeline(label, "land_vertex", fragment, target.blended());
        Self {
            sky: pipeline("sky", "vertex", "fragment", target),
            hills: land("distant hills", "distant_hills"),
            trees: land("distant trees", "distant_trees"),
        }
    }

    /// `land`: whether there is any beyond the terrain.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, land: bool) {
        pass.set_pipeline(&self.sky);
        pass.draw(0..3, 0..1);
        if land {
            pass.set_pipeline(&self.hills);
            pass.draw(0..WALLS, 0..HILLS);
            pass.set_pipeline(&self.trees);
            pass.draw(0..WALLS, HILLS..HILLS + 1);
        }
    }
}
