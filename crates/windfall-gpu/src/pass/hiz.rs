//! The occlusion pyramid: the farthest depth of ever larger squares of a picture.

use super::Shaders;
use crate::shared::Frame;

/// Builds pyramids.
pub(crate) struct HiZ {
    base_layout: wgpu::BindGroupLayout,
    reduce_layout: wgpu::BindGroupLayout,
    /// Of what looks a pyramid up: the pyramid and the clip space that it is of.
    pub layout: wgpu::BindGroupLayout,
    base: wgpu::ComputePipeline,
    reduce: wgpu::ComputePipeline,
}

/// The pyramid of one canvas. A texel of level `n` is `2^(n+1)` pixels wide.
pub(crate) struct Pyramid {
    /// For each level what builds it, and its groups of eight by eight.
    levels: Vec<(wgpu::BindGroup, (u32, u32))>,
    seen_from_world: wgpu::Buffer,
    pub group: wgpu::BindGroup,
}

impl HiZ {
    pub fn new(shaders: &Shaders<'_>) -> Self {
        let device = shaders.device;
        let texture = |binding, sample_type, multisampled| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Texture {
                sample_type,
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled,
            },
            count: None,
        };
        let floats = wgpu::TextureSampleType::Float { filterable: false };
        let level = wgpu::BindGroupLayoutEntry {
            binding: 2,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::StorageTexture {
                access: wgpu::StorageTextureAccess::WriteOnly,
                format: wgpu::TextureFormat::R32Float,
                view_dimension: wgpu::TextureViewDimension::D2,
            },
            count: None,
        };
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries,
            })
        };
        let base_layout =
            layout("depth", &[texture(0, wgpu::TextureSampleType::Depth, true), level]);
        let reduce_layout = layout("level of the pyramid", &[texture(1, floats, false), level]);
        let seen = wgpu::BindGroupLayoutEntry {
            binding: 1,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("occlusion pyramid"),
            source: wgpu::ShaderSource::Wgsl(include_str!("../../shaders/hiz.wgsl").into()),
        });
        let pipeline = |entry, group: &wgpu::BindGroupLayout| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: Some(&device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                    label: Some(entry),
                    bind_group_layouts: &[Some(group)],
                    immediate_size: 0,
                })),
                module: &module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        Self {
            base: pipeline("base", &base_layout),
            reduce: pipeline("reduce", &reduce_layout),
            layout: layout("occlusion pyramid", &[texture(0, floats, false), seen]),
            base_layout,
            reduce_layout,
        }
    }

    /// The pyramid of a multisampled depth texture. It begins empty: nothing is hidden.
    pub fn pyramid(
        &self,
        device: &wgpu::Device,
        depth: &wgpu::TextureView,
        (width, height): (u32, u32),
    ) -> Pyramid {
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
                None => (&self.base_layout, 0, depth.clone()),
                Some(below) => (&self.reduce_layout, 1, view(below)),
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
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("occlusion pyramid"),
            layout: &self.layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&all),
                },
                wgpu::BindGroupEntry { binding: 1, resource: seen_from_world.as_entire_binding() },
            ],
        });
        Pyramid { levels, seen_from_world, group }
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

impl Pyramid {
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
