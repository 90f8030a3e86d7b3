//! From radiance, sample by sample, to the picture.

use super::{
    Shaders,
    draw::{Draw, DrawTarget},
};

pub(crate) struct ToneMap {
    pipeline: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
}

impl ToneMap {
    pub fn new(shaders: &Shaders<'_>, format: wgpu::TextureFormat) -> Self {
        let layout = shaders.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("tone map"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::FRAGMENT,
                ty: wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: false },
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: true,
                },
                count: None,
            }],
        });
        let pipeline = shaders.pipeline(&Draw {
            label: "tone map",
            source: include_str!("../../shaders/tone_map.wgsl"),
            groups: &[&layout],
            buffers: &[],
            cull: None,
            vertex: "vertex",
            fragment: Some("fragment"),
            target: DrawTarget::Picture(format),
            constants: &[],
        });
        Self { pipeline, layout }
    }

    pub fn bind_group(
        &self,
        device: &wgpu::Device,
        radiance: &wgpu::TextureView,
    ) -> wgpu::BindGroup {
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("tone map"),
            layout: &self.layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(radiance),
            }],
        })
    }

    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, group: &wgpu::BindGroup) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(1, group, &[]);
        pass.draw(0..3, 0..1);
    }
}
