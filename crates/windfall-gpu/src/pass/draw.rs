//! How a render pipeline is made.

use super::{Shaders, compose};
use crate::renderer::{DEPTH, RADIANCE, SAMPLES};

/// How a pipeline differs from the usual one.
pub(crate) struct Draw<'a> {
    pub label: &'a str,
    /// The WGSL of this pass; shared code is put before it.
    pub source: &'a str,
    pub groups: &'a [&'a wgpu::BindGroupLayout],
    pub buffers: &'a [wgpu::VertexBufferLayout<'a>],
    pub cull: Option<wgpu::Face>,
    /// Entry points.
    pub vertex: &'a str,
    pub fragment: Option<&'a str>,
    pub target: DrawTarget,
    /// Values of the shader's `override`s.
    pub constants: &'a [(&'a str, f64)],
}

/// What a pipeline draws into.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum DrawTarget {
    /// The multisampled radiance, with depth.
    Radiance,
    /// The multisampled radiance, before everything that is there.
    Front,
    /// The multisampled depth, which stays as it is: only the fragments' stores count.
    Stores,
    /// A shadow map: depth alone, 0 nearest to the sun.
    Shadow,
    /// A picture of this format, without depth.
    Picture(wgpu::TextureFormat),
}

impl Shaders<'_> {
    pub fn pipeline(&self, draw: &Draw<'_>) -> wgpu::RenderPipeline {
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(draw.label),
            source: wgpu::ShaderSource::Wgsl(
                compose(&[include_str!("../../shaders/shared/instance.wgsl"), draw.source]).into(),
            ),
        });
        let groups: Vec<Option<&wgpu::BindGroupLayout>> = std::iter::once(self.frame_layout)
            .chain(draw.groups.iter().copied())
            .map(Some)
            .collect();
        let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(draw.label),
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        let (color, depth) = match draw.target {
            DrawTarget::Radiance => (Some(RADIANCE), Some(wgpu::CompareFunction::GreaterEqual)),
            DrawTarget::Front => (Some(RADIANCE), Some(wgpu::CompareFunction::Always)),
            DrawTarget::Stores => (None, Some(wgpu::CompareFunction::Always)),
            DrawTarget::Shadow => (None, Some(wgpu::CompareFunction::LessEqual)),
            DrawTarget::Picture(format) => (Some(format), None),
        };
        let compilation_options =
            wgpu::PipelineCompilationOptions { constants: draw.constants, ..Default::default() };
        let targets: Vec<_> = color.map(|format| Some(format.into())).into_iter().collect();
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(draw.label),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(draw.vertex),
                compilation_options: compilation_options.clone(),
                buffers: draw.buffers,
            },
            primitive: wgpu::PrimitiveState { cull_mode: draw.cull, ..Default::default() },
            depth_stencil: depth.map(|compare| wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(compare != wgpu::CompareFunction::Always),
                depth_compare: Some(compare),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState {
                count: match draw.target {
                    DrawTarget::Radiance | DrawTarget::Front | DrawTarget::Stores => SAMPLES,
                    DrawTarget::Shadow | DrawTarget::Picture(_) => 1,
                },
                mask: !0,
                alpha_to_coverage_enabled: false,
            },
            fragment: draw.fragment.map(|entry_point| wgpu::FragmentState {
                module: &module,
                entry_point: Some(entry_point),
                compilation_options: compilation_options.clone(),
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}
