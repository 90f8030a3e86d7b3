//! The strategies without compute: their layouts, and which pass each of them takes.

use super::draw::{Draw, DrawTarget};
use super::fragment_falls::FragmentFalls;
use super::litter::Litter;
use super::vertex_buffer_falls::VertexBufferFalls;
use super::vertex_falls::VertexFalls;
use super::{Shaders, compose};
use crate::falls::ShapeVertex;
use crate::listed::{ListedFalls, ListedShape, Posed};
use crate::model::GpuModel;
use wgpu_profiler::Scope;

/// Poses of leaves from tables in a texture.
const POSE: [&str; 5] = [
    include_str!("../../shaders/shared/texture_table.wgsl"),
    include_str!("../../shaders/shared/tables.wgsl"),
    include_str!("../../shaders/shared/pose.wgsl"),
    include_str!("../../shaders/shared/loose.wgsl"),
    include_str!("../../shaders/shared/listed.wgsl"),
];
const LEAVES: &str = include_str!("../../shaders/leaves.wgsl");

pub(crate) struct ListedPasses {
    pub(super) layouts: Layouts,
    vertex: VertexFalls,
    fragment: FragmentFalls,
    vertex_buffer: VertexBufferFalls,
    litter: Litter,
}

pub(super) struct Layouts {
    /// Uniforms and path tables.
    pub tables: wgpu::BindGroupLayout,
    /// The list as a texture.
    pub leaves: wgpu::BindGroupLayout,
    /// Posed leaves.
    pub posed: wgpu::BindGroupLayout,
}

/// Pipelines for leaves without and with holes, and for small ones.
pub(crate) struct Pipelines {
    pub solid: wgpu::RenderPipeline,
    pub masked: wgpu::RenderPipeline,
    pub small: wgpu::RenderPipeline,
}

impl Pipelines {
    /// Sets the pipeline for a region, and its model's bind group.
    pub fn set(&self, pass: &mut wgpu::RenderPass<'_>, models: &[GpuModel], shape: &ListedShape) {
        let part = &models[shape.model].leaves;
        pass.set_pipeline(match (shape.small, part.masked) {
            (true, _) => &self.small,
            (false, true) => &self.masked,
            (false, false) => &self.solid,
        });
        pass.set_bind_group(1, &part.bind_group, &[]);
    }
}

/// How a strategy finds vertices of leaves.
pub(super) struct Placing<'a> {
    /// WGSL that adds the vertex entry point `vertex` to those of the leaves' shader.
    pub source: &'a str,
    pub vertex: &'a str,
    /// Bind groups from the second on.
    pub groups: Vec<&'a wgpu::BindGroupLayout>,
    pub buffers: Vec<wgpu::VertexBufferLayout<'a>>,
    /// Whether it needs the functions that pose.
    pub posing: bool,
}

impl Placing<'_> {
    pub fn pipelines(
        &self,
        shaders: &Shaders<'_>,
        [solid, masked]: [Option<&str>; 2],
        target: DrawTarget,
        constants: &[(&str, f64)],
    ) -> Pipelines {
        let shared = if self.posing { POSE.join("\n") } else { String::new() };
        let source = [LEAVES, &shared, self.source].join("\n");
        let pipeline = |fragment, lit_once| {
            let constants = [constants, &[("lit_at_vertices", lit_once)]].concat();
            shaders.pipeline(&Draw {
                label: self.vertex,
                source: &source,
                groups: &self.groups,
                buffers: &self.buffers,
                cull: None,
                vertex: self.vertex,
                fragment,
                target,
                constants: &constants,
            })
        };
        let pictured = matches!(target, DrawTarget::Radiance | DrawTarget::Front);
        let plain = pipeline(solid, 0.0);
        Pipelines {
            masked: pipeline(masked, 0.0),
            small: if pictured { pipeline(Some("small"), 1.0) } else { plain.clone() },
            solid: plain,
        }
    }
}

/// Pipelines for the picture and for shadow maps.
pub(super) struct PictureAndShadow {
    picture: Pipelines,
    shadow: Pipelines,
}

impl PictureAndShadow {
    pub fn new(shaders: &Shaders<'_>, placing: &Placing<'_>) -> Self {
        let (colors, holes) = ([Some("solid"), Some("masked")], [None, Some("masked_shadow")]);
        Self {
            picture: placing.pipelines(shaders, colors, DrawTarget::Radiance, &[]),
            shadow: placing.pipelines(shaders, holes, DrawTarget::Shadow, &[]),
        }
    }

    pub fn of(&self, into: DrawTarget) -> &Pipelines {
        if into == DrawTarget::Shadow { &self.shadow } else { &self.picture }
    }
}

pub(super) const SHAPE: wgpu::VertexBufferLayout<'static> = ShapeVertex::LAYOUT;

/// A pipeline that fills two textures, a texel for each leaf or vertex.
pub(super) fn pose_pipeline(
    shaders: &Shaders<'_>,
    layouts: &Layouts,
    label: &str,
    source: &str,
    buffers: &[wgpu::VertexBufferLayout<'_>],
    formats: [wgpu::TextureFormat; 2],
) -> wgpu::RenderPipeline {
    let device = shaders.device;
    let texels = include_str!("../../shaders/shared/leaf_texels.wgsl");
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(compose(&[&POSE.join("\n"), texels, source]).into()),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: &[
            Some(shaders.frame_layout),
            Some(&layouts.leaves),
            Some(&layouts.tables),
        ],
        immediate_size: 0,
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(label),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("cover"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers,
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("pose"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &formats.map(|format| Some(format.into())),
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// A pass that fills two textures.
pub(super) fn pose_pass<'a>(
    scope: &'a mut Scope<'_, wgpu::CommandEncoder>,
    targets: &[wgpu::TextureView; 2],
) -> wgpu_profiler::OwningScope<'a, wgpu::RenderPass<'a>> {
    let attachments = targets.each_ref().map(|view| {
        Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
        })
    });
    scope.scoped_render_pass(
        "pose",
        wgpu::RenderPassDescriptor {
            label: Some("pose"),
            color_attachments: &attachments,
            ..Default::default()
        },
    )
}

fn texture_entry(binding: u32, sample_type: wgpu::TextureSampleType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        count: None,
    }
}

const FLOATS: wgpu::TextureSampleType = wgpu::TextureSampleType::Float { filterable: false };

impl Layouts {
    fn new(device: &wgpu::Device) -> Self {
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries,
            })
        };
        let uniform = wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let words = wgpu::TextureSampleType::Uint;
        Self {
            tables: layout("tables", &[uniform, texture_entry(1, words)]),
            leaves: layout("leaf list", &[texture_entry(0, words)]),
            posed: layout("posed leaves", &[texture_entry(0, FLOATS), texture_entry(1, words)]),
        }
    }
}

impl ListedPasses {
    pub fn new(shaders: &Shaders<'_>, part_layout: &wgpu::BindGroupLayout) -> Self {
        let layouts = Layouts::new(shaders.device);
        Self {
            vertex: VertexFalls::new(shaders, part_layout, &layouts),
            fragment: FragmentFalls::new(shaders, part_layout, &layouts),
            vertex_buffer: VertexBufferFalls::new(shaders, part_layout, &layouts),
            litter: Litter::new(shaders, part_layout, &layouts),
            layouts,
        }
    }

    pub fn tables_group(
        &self,
        device: &wgpu::Device,
        uniform: &wgpu::Buffer,
        tables: &wgpu::TextureView,
    ) -> wgpu::BindGroup {
        let uniform = uniform.as_entire_binding();
        let tables = wgpu::BindingResource::TextureView(tables);
        group(device, &self.layouts.tables, [uniform, tables])
    }

    pub fn leaf_group(&self, device: &wgpu::Device, list: &wgpu::TextureView) -> wgpu::BindGroup {
        group(device, &self.layouts.leaves, [wgpu::BindingResource::TextureView(list)])
    }

    pub fn posed_group(
        &self,
        device: &wgpu::Device,
        targets: &[wgpu::TextureView; 2],
    ) -> wgpu::BindGroup {
        let views = targets.each_ref().map(wgpu::BindingResource::TextureView);
        group(device, &self.layouts.posed, views)
    }

    /// Poses the listed leaves, where the strategy does that before they are drawn.
    pub fn pose(
        &self,
        scope: &mut Scope<'_, wgpu::CommandEncoder>,
        frame_group: &wgpu::BindGroup,
        falls: &ListedFalls,
    ) {
        match &falls.posed {
            Posed::Nothing => {}
            Posed::Leaves(posed) => self.fragment.pose(scope, frame_group, falls, posed),
            Posed::Vertices(posed) => self.vertex_buffer.pose(scope, frame_group, falls, posed),
        }
    }

    /// Draws falling leaves and litter.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        models: &[GpuModel],
        falls: &ListedFalls,
        into: DrawTarget,
    ) {
        let occlusion = falls.occlusion.as_ref().filter(|_| into == DrawTarget::Radiance);
        let pipelines = match (occlusion, &falls.posed) {
            (Some(occlusion), _) => occlusion.set_shown(pass),
            (None, Posed::Nothing) => self.vertex.pipelines.of(into),
            (None, Posed::Leaves(_)) => self.fragment.pipelines.of(into),
            (None, Posed::Vertices(_)) => self.vertex_buffer.pipelines.of(into),
        };
        draw_falling(pass, models, falls, pipelines);
        self.litter.draw(pass, models, falls, into);
    }
}

/// Draws the listed leaves, as the strategy has placed them.
pub(super) fn draw_falling(
    pass: &mut wgpu::RenderPass<'_>,
    models: &[GpuModel],
    falls: &ListedFalls,
    pipelines: &Pipelines,
) {
    match &falls.posed {
        Posed::Nothing => VertexFalls::draw(pass, models, falls, pipelines),
        Posed::Leaves(posed) => FragmentFalls::draw(pass, models, falls, posed, pipelines),
        Posed::Vertices(posed) => VertexBufferFalls::draw(pass, models, falls, posed, pipelines),
    }
}

fn group<const N: usize>(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resources: [wgpu::BindingResource<'_>; N],
) -> wgpu::BindGroup {
    let mut binding = 0;
    let entries = resources.map(|resource| {
        binding += 1;
        wgpu::BindGroupEntry { binding: binding - 1, resource }
    });
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("listed leaves"),
        layout,
        entries: &entries,
    })
}
