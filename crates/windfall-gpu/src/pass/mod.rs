//! One file per pass: an immutable struct with its pipelines, and a `draw`.

pub(crate) mod ground;
mod leaves;
mod sky;
mod tone_map;
mod wood;

pub(crate) use ground::Ground;
pub(crate) use leaves::Leaves;
pub(crate) use sky::SkyDome;
pub(crate) use tone_map::ToneMap;
pub(crate) use wood::Wood;

use crate::forest::TreeInstance;
use crate::renderer::{DEPTH, RADIANCE, SAMPLES};
use crate::shared::{Frame, Model, Surface};

/// What every pass needs to make its pipelines.
pub(crate) struct Shaders<'a> {
    pub device: &'a wgpu::Device,
    pub frame_layout: &'a wgpu::BindGroupLayout,
}

/// How a pipeline differs from the usual one.
pub(crate) struct Draw<'a> {
    pub label: &'a str,
    /// The WGSL of this pass; shared code is put before it.
    pub source: &'a str,
    pub groups: &'a [&'a wgpu::BindGroupLayout],
    pub buffers: &'a [wgpu::VertexBufferLayout<'a>],
    pub cull: Option<wgpu::Face>,
    /// Fragment entry point.
    pub fragment: &'a str,
    pub alpha_to_coverage: bool,
    /// Colour target without depth and multisampling, or the multisampled radiance with depth.
    pub target: Option<wgpu::TextureFormat>,
}

impl Shaders<'_> {
    pub fn pipeline(&self, draw: &Draw<'_>) -> wgpu::RenderPipeline {
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(draw.label),
            source: wgpu::ShaderSource::Wgsl(compose(draw.source).into()),
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
        let forest = draw.target.is_none();
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(draw.label),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: draw.buffers,
            },
            primitive: wgpu::PrimitiveState { cull_mode: draw.cull, ..Default::default() },
            depth_stencil: forest.then(|| wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::GreaterEqual),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState {
                count: if forest { SAMPLES } else { 1 },
                mask: !0,
                alpha_to_coverage_enabled: draw.alpha_to_coverage,
            },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(draw.fragment),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(draw.target.unwrap_or(RADIANCE).into())],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// Shared declarations and functions, then the pass's own.
fn compose(source: &str) -> String {
    [
        &Frame::wgsl(),
        &Model::wgsl(),
        &Surface::wgsl(),
        include_str!("../../shaders/shared/frame.wgsl"),
        include_str!("../../shaders/shared/hash.wgsl"),
        include_str!("../../shaders/shared/light.wgsl"),
        include_str!("../../shaders/shared/instance.wgsl"),
        source,
    ]
    .join("\n")
}

/// The instance-step buffer of trees.
fn tree_instances() -> wgpu::VertexBufferLayout<'static> {
    wgpu::VertexBufferLayout {
        array_stride: size_of::<TreeInstance>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &TreeInstance::ATTRIBUTES,
    }
}

/// Draws one part of every visible tree.
fn draw_parts<'a>(
    pass: &mut wgpu::RenderPass<'_>,
    forest: &crate::GpuForest,
    visible: &[crate::forest::Visible],
    part: impl Fn(&'a crate::model::GpuModel) -> &'a crate::model::Part,
    models: &'a [crate::model::GpuModel],
    mut before: impl FnMut(&mut wgpu::RenderPass<'_>, &crate::model::Part),
) {
    pass.set_vertex_buffer(1, forest.instances.slice(..));
    for (model, range) in models.iter().zip(visible) {
        let part = part(model);
        if range.is_empty() || part.index_count == 0 {
            continue;
        }
        before(pass, part);
        pass.set_bind_group(1, &part.bind_group, &[]);
        pass.set_vertex_buffer(0, part.vertices.slice(..));
        pass.set_index_buffer(part.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..part.index_count, 0, range.clone());
    }
}
