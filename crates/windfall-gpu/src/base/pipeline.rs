//! How a render pipeline is made.

use super::wgsl::{Module, Shaders};

/// How a pipeline differs from the usual one.
pub struct Draw<'a> {
    /// Its name, for people.
    pub label: &'a str,
    /// The module of its entry points.
    pub module: &'a Module,
    /// All its groups.
    pub groups: &'a [&'a wgpu::BindGroupLayout],
    /// Its vertex buffers.
    pub buffers: &'a [wgpu::VertexBufferLayout<'a>],
    /// Which faces are not drawn.
    pub cull: Option<wgpu::Face>,
    /// Entry points.
    pub vertex: &'a str,
    /// `None` draws depth alone.
    pub fragment: Option<&'a str>,
    /// What it draws into.
    pub target: Target,
    /// Values of the shader's `override`s.
    pub constants: &'a [(&'a str, f64)],
}

/// What a pipeline draws into.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// The colours, if any.
    pub color: Option<wgpu::TextureFormat>,
    /// Whether colours are mixed with those that are there by their alpha, which stays.
    pub blend: bool,
    /// The depth, if any.
    pub depth: Option<Depth>,
    /// Samples of a pixel.
    pub samples: u32,
}

/// How a pipeline uses depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Depth {
    /// Its format.
    pub format: wgpu::TextureFormat,
    /// What passes.
    pub compare: wgpu::CompareFunction,
    /// Whether what passes is written.
    pub write: bool,
    /// Whether what lies before the near plane or behind the far one is drawn there.
    pub unclipped: bool,
}

impl Depth {
    /// Depth of what is nearest, written.
    pub fn nearest(format: wgpu::TextureFormat, reversed: bool) -> Self {
        let compare = if reversed {
            wgpu::CompareFunction::GreaterEqual
        } else {
            wgpu::CompareFunction::LessEqual
        };
        Self { format, compare, write: true, unclipped: false }
    }

    /// The same texture, drawn over and left as it is.
    pub fn ignored(self) -> Self {
        Self { compare: wgpu::CompareFunction::Always, write: false, ..self }
    }
}

impl Target {
    /// The same target where only fragments' stores count.
    pub fn stores(self) -> Self {
        Self { color: None, depth: self.depth.map(Depth::ignored), ..self }
    }

    /// The same target, before everything that is there.
    pub fn front(self) -> Self {
        Self { depth: self.depth.map(Depth::ignored), ..self }
    }

    /// The same target, mixed with what is there.
    pub fn blended(self) -> Self {
        Self { blend: true, ..self }
    }

    /// Whether there are colours.
    pub fn lit(&self) -> bool {
        self.color.is_some()
    }
}

impl Shaders<'_> {
    /// Makes a render pipeline.
    pub fn pipeline(&self, draw: &Draw<'_>) -> wgpu::RenderPipeline {
        let module = self.module(draw.module);
        let groups: Vec<Option<&wgpu::BindGroupLayout>> =
            draw.groups.iter().copied().map(Some).collect();
        let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(draw.label),
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        let compilation_options =
            wgpu::PipelineCompilationOptions { constants: draw.constants, ..Default::default() };
        let blend = draw.target.blend.then_some(wgpu::BlendState {
            color: wgpu::BlendComponent {
                src_factor: wgpu::BlendFactor::SrcAlpha,
                dst_factor: wgpu::BlendFactor::OneMinusSrcAlpha,
                operation: wgpu::BlendOperation::Add,
            },
            alpha: wgpu::BlendComponent {
                src_factor: wgpu::BlendFactor::Zero,
                dst_factor: wgpu::BlendFactor::One,
                operation: wgpu::BlendOperation::Add,
            },
        });
        let write_mask = wgpu::ColorWrites::ALL;
        let color = |format| Some(wgpu::ColorTargetState { format, blend, write_mask });
        let targets: Vec<_> = draw.target.color.map(color).into_iter().collect();
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(draw.label),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(draw.vertex),
                compilation_options: compilation_options.clone(),
                buffers: draw.buffers,
            },
            primitive: wgpu::PrimitiveState {
                cull_mode: draw.cull,
                unclipped_depth: draw.target.depth.is_some_and(|depth| depth.unclipped),
                ..Default::default()
            },
            depth_stencil: draw.target.depth.map(|depth| wgpu::DepthStencilState {
                format: depth.format,
                depth_write_enabled: Some(depth.write),
                depth_compare: Some(depth.compare),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState {
                count: draw.target.samples,
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
