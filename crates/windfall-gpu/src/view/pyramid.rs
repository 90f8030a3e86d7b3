//! The occlusion pyramid: the farthest depth of ever larger squares of a picture.

use crate::base::layouts::{self, Layouts};
use crate::base::shared::Frame;

/// The pyramid of one picture. A texel of level `n` is `2^(n+1)` pixels wide.
pub struct Pyramid {
    /// For each level what builds it, and its groups of eight by eight.
    pub levels: Vec<(wgpu::BindGroup, (u32, u32))>,
    seen_from_world: wgpu::Buffer,
    pub group: wgpu::BindGroup,
}

impl Pyramid {
    /// The pyramid of a multisampled depth texture. It begins empty: nothing is hidden.
    pub fn new(
        device: &wgpu::Device,
        layouts: &Layouts,
        depth: &wgpu::TextureView,
        (width, height): (u32, u32),
    ) -> Self {
        // Powers of two, so that a texel of any level is a whole number of texels below it.
        let size = |pixels: u32| pixels.div_ceil(2).next_power_of_two();
        let (width, height) = (size(width), size(height));
        let count = width.max(height).ilog2() + 1;
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("occlusion pyramid"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: count,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::R32Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::STORAGE_BINDING,
            view_formats: &[],
        });
        let view = |level| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                base_mip_level: level,
                mip_level_count: Some(1),
                ..Default::default()
            })
        };
        let levels = (0..count).map(|level| {
            let (layout, binding, from) = match level.checked_sub(1) {
                None => (&layouts.pyramid_base, 0, depth.clone()),
                Some(below) => (&layouts.pyramid_level, 1, view(below)),
            };
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("level of the pyramid"),
                layout,
                entries: &[
                    wgpu::BindGroupEntry {
                        binding,
                        resource: wgpu::BindingResource::TextureView(&from),
                    },
                    wgpu::BindGroupEntry {
                        binding: 2,
                        resource: wgpu::BindingResource::TextureView(&view(level)),
                    },
                ],
            });
            let groups = |side: u32| (side >> level).max(1).div_ceil(8);
            (group, (groups(width), groups(height)))
        });
        let levels = levels.collect();
        let seen_from_world = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("what the pyramid shows"),
            size: size_of::<glam::Mat4>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let all = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let group = layouts::group(
            device,
            "occlusion pyramid",
            &layouts.pyramid,
            &[wgpu::BindingResource::TextureView(&all), seen_from_world.as_entire_binding()],
        );
        Self { levels, seen_from_world, group }
    }

    /// The level that is one texel.
    pub fn top_level(&self) -> u32 {
        self.levels.len() as u32 - 1
    }

    /// Remembers that the pyramid is of this frame, of whose uniforms it keeps the clip space.
    pub fn remember(&self, encoder: &mut wgpu::CommandEncoder, frame: &wgpu::Buffer) {
        let size = self.seen_from_world.size();
        let at = std::mem::offset_of!(Frame, clip_from_world) as u64;
        encoder.copy_buffer_to_buffer(frame, at, &self.seen_from_world, 0, size);
    }
}
