//! Builds occlusion pyramids.

use crate::base::layouts::Layouts;
use crate::base::wgsl::{Module, Shaders};
use crate::view::pyramid::Pyramid;

/// The pyramid's module.
pub const HIZ: Module = Module {
    name: "hiz",
    source: |settings| {
        format!("const SAMPLES: u32 = {}u;\n{}", settings.samples, include_str!("hiz.wgsl"))
    },
};

/// Builds pyramids.
pub struct HiZ {
    base: wgpu::ComputePipeline,
    reduce: wgpu::ComputePipeline,
}

impl HiZ {
    pub fn new(shaders: &Shaders<'_>, layouts: &Layouts) -> Self {
        Self {
            base: shaders.compute(&HIZ, "base", &[&layouts.pyramid_base], &[]),
            reduce: shaders.compute(&HIZ, "reduce", &[&layouts.pyramid_level], &[]),
        }
    }

    /// Builds every level from the depth texture.
    pub fn build(&self, pass: &mut wgpu::ComputePass<'_>, pyramid: &Pyramid) {
        for (level, (group, (x, y))) in pyramid.levels.iter().enumerate() {
            pass.set_pipeline(if level == 0 { &self.base } else { &self.reduce });
            pass.set_bind_group(0, group, &[]);
            pass.dispatch_workgroups(*x, *y, 1);
        }
    }
}
