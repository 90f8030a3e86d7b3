//! From radiance, sample by sample, to the picture.

use crate::base::layouts::Layouts;
use crate::base::pipeline::{Draw, Target};
use crate::base::wgsl::{Module, Shaders, compose};

/// The tone map's module.
pub const TONE_MAP: Module = Module {
    name: "tone_map",
    source: |settings| compose(settings, &[include_str!("tone_map.wgsl")]),
};

/// Tone maps.
pub struct ToneMap {
    whole: wgpu::RenderPipeline,
    enlarged: wgpu::RenderPipeline,
}

impl ToneMap {
    pub fn new(shaders: &Shaders<'_>, layouts: &Layouts, format: wgpu::TextureFormat) -> Self {
        let pipeline = |fragment| {
            shaders.pipeline(&Draw {
                label: "tone map",
                module: &TONE_MAP,
                groups: &[&layouts.frame, &layouts.radiance],
                buffers: &[],
                cull: None,
                vertex: "vertex",
                fragment: Some(fragment),
                target: Target { color: Some(format), blend: false, depth: None, samples: 1 },
                constants: &[],
            })
        };
        Self { whole: pipeline("fragment"), enlarged: pipeline("enlarged") }
    }

    /// Draws the picture; `radiance` is the group of what was drawn, in which part of the width and height.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        radiance: &wgpu::BindGroup,
        resolution: f32,
    ) {
        pass.set_pipeline(if resolution < 1.0 { &self.enlarged } else { &self.whole });
        pass.set_bind_group(1, radiance, &[]);
        pass.draw(0..3, 0..1);
    }
}
