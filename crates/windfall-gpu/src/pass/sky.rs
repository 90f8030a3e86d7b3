//! The sky behind everything.

use crate::base::layouts::Layouts;
use crate::base::pipeline::{Draw, Target};
use crate::base::wgsl::{Module, Shaders, compose};

/// The sky's module.
pub const SKY: Module =
    Module { name: "sky", source: |settings| compose(settings, &[include_str!("sky.wgsl")]) };

/// Draws the sky.
pub struct SkyDome {
    pipeline: wgpu::RenderPipeline,
}

impl SkyDome {
    pub fn new(shaders: &Shaders<'_>, layouts: &Layouts, target: Target) -> Self {
        Self {
            pipeline: shaders.pipeline(&Draw {
                label: "sky",
                module: &SKY,
                groups: &[&layouts.frame],
                buffers: &[],
                cull: None,
                vertex: "vertex",
                fragment: Some("fragment"),
                target,
                constants: &[],
            }),
        }
    }

    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_pipeline(&self.pipeline);
        pass.draw(0..3, 0..1);
    }
}
