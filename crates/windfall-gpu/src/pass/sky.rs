//! The sky behind everything.

use super::{
    Shaders,
    draw::{Draw, DrawTarget},
};

pub(crate) struct SkyDome {
    pipeline: wgpu::RenderPipeline,
}

impl SkyDome {
    pub fn new(shaders: &Shaders<'_>) -> Self {
        Self {
            pipeline: shaders.pipeline(&Draw {
                label: "sky",
                source: include_str!("../../shaders/sky.wgsl"),
                groups: &[],
                buffers: &[],
                cull: None,
                vertex: "vertex",
                fragment: Some("fragment"),
                alpha_to_coverage: false,
                target: DrawTarget::Radiance,
            }),
        }
    }

    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_pipeline(&self.pipeline);
        pass.draw(0..3, 0..1);
    }
}
