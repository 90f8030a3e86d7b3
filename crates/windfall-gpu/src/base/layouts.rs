//! Layouts of the bind groups that scenes and views make: the same on every device, so that what one
//! renderer of a device has uploaded, another can draw.

use crate::base::noise::Noise;

/// One binding: who sees it, and what it is.
pub fn entry(
    binding: u32,
    visibility: wgpu::ShaderStages,
    ty: wgpu::BindingType,
) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None }
}

/// A buffer.
pub fn buffer(ty: wgpu::BufferBindingType) -> wgpu::BindingType {
    wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }
}

/// A uniform buffer.
pub const UNIFORM: wgpu::BufferBindingType = wgpu::BufferBindingType::Uniform;
/// A storage buffer that shaders read.
pub const READ: wgpu::BufferBindingType = wgpu::BufferBindingType::Storage { read_only: true };
/// A storage buffer that they write.
pub const WRITE: wgpu::BufferBindingType = wgpu::BufferBindingType::Storage { read_only: false };

/// A texture.
pub fn texture(
    sample_type: wgpu::TextureSampleType,
    view_dimension: wgpu::TextureViewDimension,
) -> wgpu::BindingType {
    wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: false }
}

/// A layout with bindings from 0 on, all seen by the same stages.
pub fn layout(
    device: &wgpu::Device,
    label: &str,
    visibility: wgpu::ShaderStages,
    types: &[wgpu::BindingType],
) -> wgpu::BindGroupLayout {
    let entries: Vec<_> =
        (0..).zip(types).map(|(binding, &ty)| entry(binding, visibility, ty)).collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some(label),
        entries: &entries,
    })
}

/// A group with bindings from 0 on.
pub fn group(
    device: &wgpu::Device,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    resources: &[wgpu::BindingResource<'_>],
) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(resources)
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(label),
        layout,
        entries: &entries,
    })
}

/// The layouts.
pub struct Layouts {
    /// Group 0 of every pass: frame, shadow maps, sky, scripted detaches of the forest, noise.
    pub frame: wgpu::BindGroupLayout,
    /// A part of a tree model: model, surfaces, texture array, sampler.
    pub part: wgpu::BindGroupLayout,
    /// Heights of the terrain.
    pub heights: wgpu::BindGroupLayout,
    /// Tufts and blades of grass as they are found, and how many.
    pub find_grass: wgpu::BindGroupLayout,
    /// Tufts and blades as they are drawn.
    pub grass: wgpu::BindGroupLayout,
    /// What leaves fall by, and where they are.
    pub falls: wgpu::BindGroupLayout,
    /// What a view draws of them.
    pub gather: wgpu::BindGroupLayout,
    /// Lists of trees.
    pub cull: wgpu::BindGroupLayout,
    /// Which leaves of a list are drawn as quads.
    pub arrange_quads: wgpu::BindGroupLayout,
    /// What places and lights them.
    pub spread_quads: wgpu::BindGroupLayout,
    /// The occlusion pyramid and the clip space that it is of.
    pub pyramid: wgpu::BindGroupLayout,
    /// A level of the pyramid from the depth texture.
    pub pyramid_base: wgpu::BindGroupLayout,
    /// A level from the one below.
    pub pyramid_level: wgpu::BindGroupLayout,
    /// The light of a sky.
    pub sky_light: wgpu::BindGroupLayout,
    /// Radiance, to be tone mapped.
    pub radiance: wgpu::BindGroupLayout,
    /// What every group of [`Self::frame`] has.
    pub noise: Noise,
}

impl Layouts {
    /// All of them.
    pub fn new(device: &wgpu::Device) -> Self {
        use wgpu::{SamplerBindingType, ShaderStages, TextureSampleType, TextureViewDimension};
        let floats = TextureSampleType::Float { filterable: true };
        let unfiltered = TextureSampleType::Float { filterable: false };
        let (flat, array) = (TextureViewDimension::D2, TextureViewDimension::D2Array);
        let everywhere = ShaderStages::VERTEX_FRAGMENT | ShaderStages::COMPUTE;
        let compute = ShaderStages::COMPUTE;
        let sampler = wgpu::BindingType::Sampler;
        let table = texture(TextureSampleType::Uint, flat);
        let level = wgpu::BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::WriteOnly,
            format: wgpu::TextureFormat::R32Float,
            view_dimension: flat,
        };
        let buffers = |types: &[wgpu::BufferBindingType]| -> Vec<wgpu::BindingType> {
            types.iter().map(|&ty| buffer(ty)).collect()
        };
        let of = |label, visibility, types: &[wgpu::BindingType]| {
            layout(device, label, visibility, types)
        };
        let multisampled = |sample_type| wgpu::BindingType::Texture {
            sample_type,
            view_dimension: flat,
            multisampled: true,
        };
        let with_entries = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries,
            })
        };
        Self {
            frame: with_entries(
                "frame",
                &[
                    entry(0, everywhere, buffer(UNIFORM)),
                    entry(1, everywhere, texture(TextureSampleType::Depth, array)),
                    entry(2, everywhere, sampler(SamplerBindingType::Comparison)),
                    entry(3, everywhere, texture(floats, flat)),
                    entry(4, everywhere, texture(floats, flat)),
                    entry(5, everywhere, sampler(SamplerBindingType::Filtering)),
                    entry(6, ShaderStages::VERTEX | compute, buffer(READ)),
                    entry(7, everywhere, texture(floats, flat)),
                    entry(8, everywhere, sampler(SamplerBindingType::Filtering)),
                ],
            ),
            part: Self::part(device),
            heights: of("terrain heights", ShaderStages::VERTEX | compute, &buffers(&[READ])),
            find_grass: of("find grass", compute, &buffers(&[WRITE, WRITE, WRITE])),
            grass: of("grass", ShaderStages::VERTEX, &buffers(&[READ, READ])),
            falls: of(
                "falls",
                compute,
                &[
                    &[buffer(UNIFORM), table][..],
                    &buffers(&[READ, READ, READ, WRITE, WRITE, WRITE, WRITE]),
                ]
                .concat(),
            ),
            gather: of(
                "loose leaves of a view",
                compute,
                &buffers(&[UNIFORM, UNIFORM, READ, READ, READ, READ, READ, WRITE, WRITE]),
            ),
            cull: of(
                "cull",
                compute,
                &buffers(&[UNIFORM, UNIFORM, READ, READ, READ, WRITE, WRITE, WRITE, WRITE]),
            ),
            arrange_quads: of("arranged quads", compute, &buffers(&[READ, WRITE, WRITE, WRITE])),
            spread_quads: of(
                "quads of hanging leaves",
                compute,
                &buffers(&[UNIFORM, READ, READ, READ, WRITE]),
            ),
            pyramid: of(
                "occlusion pyramid",
                compute,
                &[texture(unfiltered, flat), buffer(UNIFORM)],
            ),
            pyramid_base: with_entries(
                "depth",
                &[
                    entry(0, compute, multisampled(TextureSampleType::Depth)),
                    entry(2, compute, level),
                ],
            ),
            pyramid_level: with_entries(
                "level of the pyramid",
                &[entry(1, compute, texture(unfiltered, flat)), entry(2, compute, level)],
            ),
            sky_light: of(
                "sky light",
                compute,
                &[
                    buffer(UNIFORM),
                    buffer(READ),
                    buffer(WRITE),
                    wgpu::BindingType::StorageTexture {
                        access: wgpu::StorageTextureAccess::WriteOnly,
                        format: wgpu::TextureFormat::Rgba16Float,
                        view_dimension: flat,
                    },
                    buffer(WRITE),
                ],
            ),
            radiance: of("tone map", ShaderStages::FRAGMENT, &[multisampled(unfiltered)]),
            noise: Noise::new(device),
        }
    }
    /// [`Layouts::part`].
    pub fn part(device: &wgpu::Device) -> wgpu::BindGroupLayout {
        use wgpu::ShaderStages;
        let everywhere = ShaderStages::VERTEX_FRAGMENT | ShaderStages::COMPUTE;
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("part of a tree"),
            entries: &[
                entry(0, everywhere, buffer(UNIFORM)),
                entry(1, everywhere, buffer(READ)),
                entry(
                    2,
                    ShaderStages::FRAGMENT,
                    texture(
                        wgpu::TextureSampleType::Float { filterable: true },
                        wgpu::TextureViewDimension::D2Array,
                    ),
                ),
                entry(
                    3,
                    ShaderStages::FRAGMENT,
                    wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
                ),
            ],
        })
    }
}
