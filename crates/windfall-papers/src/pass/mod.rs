//! Pipelines of the published strategies: built once for a device, and only for what is asked for.
//!
//! Leaves are drawn by the renderer's own leaf shader; a strategy adds the vertex entry points that feed it.

pub mod cpu;
pub mod fragment;
pub mod litter;
pub mod occlusion;
pub mod vertex;
pub mod vertex_buffer;

use crate::arena::Arena;
use crate::arena::BLOCK_SIZE;
use crate::buffers::{LEAF_TEXELS, LeafBuffers, Posed, RegionShape, VERTEX_ROW};
use crate::options::{LandingSearch, PassOptions, Strategy};
use occlusion::OcclusionPasses;
use windfall_gpu::internals::layouts::{self, Layouts, UNIFORM};
use windfall_gpu::internals::{
    DEPTH, Depth, Draw, LEAVES, Module, RADIANCE, SAMPLES, SHADOW_TARGET, Settings, Shaders,
    Target, compose, text,
};

/// Every shader module of the strategies, to be listed and checked; those that a [`PublishedPasses`] uses are
/// compiled with it.
pub const MODULES: &[&Module] = &[
    &vertex::DRAW,
    &vertex::OCCLUSION,
    &vertex::DRAW_FROM_TEXTURES,
    &vertex::OCCLUSION_FROM_TEXTURES,
    &fragment::POSE,
    &fragment::DRAW,
    &fragment::OCCLUSION,
    &vertex_buffer::POSE,
    &vertex_buffer::DRAW,
    &vertex_buffer::OCCLUSION,
    &cpu::OCCLUSION,
    &litter::LITTER,
    &occlusion::UPDATE,
];

/// What the text of modules depends on: these passes draw into whole pictures alone.
const SETTINGS: Settings = Settings { samples: SAMPLES };

/// Poses of leaves from tables in a texture.
const POSE: [&str; 5] = pose_from(text::PATH_SAMPLES);
/// The same with paths in one-dimensional textures.
const POSE_FROM_TEXTURES: [&str; 5] = pose_from(include_str!("../wgsl/path_textures.wgsl"));

const fn pose_from(path_samples: &'static str) -> [&'static str; 5] {
    [include_str!("../wgsl/path_tables.wgsl"), text::TABLES, path_samples, text::POSE, text::LOOSE]
}
const ACTIVE_LEAF: &str = include_str!("../wgsl/active_leaf.wgsl");
/// What leaf occlusion adds to a module that draws.
const VISIBILITY: [&str; 3] = [
    include_str!("../wgsl/visibility.wgsl"),
    include_str!("count_pixels.wgsl"),
    include_str!("draw_visible.wgsl"),
];

/// Numbers that Rust and WGSL both know.
fn numbers() -> String {
    format!(
        "const BLOCK_SIZE: u32 = {BLOCK_SIZE}u;\nconst LEAF_TEXELS: u32 = {LEAF_TEXELS}u;\n\
         const VERTEX_ROW: u32 = {VERTEX_ROW}u;\n"
    )
}

/// The renderer's leaf module with more text.
fn with_leaves(settings: Settings, more: &[&[&str]]) -> String {
    [(LEAVES.source)(&settings), numbers(), more.concat().join("\n")].join("\n")
}

/// Shared text, what poses active leaves from a texture, and more.
fn with_leaf_texels(settings: Settings, more: &[&str]) -> String {
    let texels = include_str!("../wgsl/leaf_texels.wgsl");
    let numbers = numbers();
    compose(&settings, &[&POSE[..], &[ACTIVE_LEAF, &numbers, texels], more].concat())
}

/// The textures of a whole picture.
fn picture_target() -> Target {
    let depth = Some(Depth::nearest(DEPTH, true));
    Target { color: Some(RADIANCE), blend: false, depth, samples: SAMPLES }
}

/// Bind group layouts beside the renderer's own.
pub struct PassLayouts {
    /// Group 0 of every pass.
    frame: wgpu::BindGroupLayout,
    /// Group 1: a part of a tree model.
    part: wgpu::BindGroupLayout,
    /// Group 2: uniforms, path tables, and path data in one-dimensional textures, of a texel if nothing reads them.
    tables: wgpu::BindGroupLayout,
    /// Group 1 of pose passes: the list of active leaves as a texture.
    leaves: wgpu::BindGroupLayout,
    /// Group 2: posed leaves.
    posed: wgpu::BindGroupLayout,
    /// A group that a strategy does not use.
    nothing: wgpu::BindGroupLayout,
}

impl PassLayouts {
    fn new(device: &wgpu::Device) -> Self {
        let Layouts { frame, part, .. } = Layouts::new(device);
        let flat = wgpu::TextureViewDimension::D2;
        let words = layouts::texture(wgpu::TextureSampleType::Uint, flat);
        let floats = layouts::texture(wgpu::TextureSampleType::Float { filterable: false }, flat);
        let line = wgpu::TextureViewDimension::D1;
        let lines = layouts::texture(wgpu::TextureSampleType::Float { filterable: false }, line);
        let stages = wgpu::ShaderStages::VERTEX_FRAGMENT;
        let of = |label, types: &[_]| layouts::layout(device, label, stages, types);
        Self {
            frame,
            part,
            tables: of("path tables", &[layouts::buffer(UNIFORM), words, lines, lines]),
            leaves: of("active leaves", &[words]),
            posed: of("posed leaves", &[floats, words]),
            nothing: of("nothing", &[]),
        }
    }
}

/// How vertices of leaves reach the leaf shader.
struct VertexInput<'a> {
    module: &'a Module,
    /// The entry point.
    vertex: &'static str,
    /// Bind groups from the first on.
    groups: Vec<&'a wgpu::BindGroupLayout>,
    buffers: Vec<wgpu::VertexBufferLayout<'static>>,
}

/// Pipelines for full leaves without and with holes, and for small leaves.
pub struct Pipelines {
    solid: wgpu::RenderPipeline,
    masked: wgpu::RenderPipeline,
    small: wgpu::RenderPipeline,
}

impl Pipelines {
    fn new(
        shaders: &Shaders<'_>,
        input: &VertexInput<'_>,
        [solid, masked]: [Option<&str>; 2],
        target: Target,
        constants: &[(&str, f64)],
    ) -> Self {
        let pipeline = |fragment, lit_at_vertices: bool| {
            let lit = [("lit_at_vertices", f64::from(u8::from(lit_at_vertices)))];
            let constants = [constants, &lit].concat();
            shaders.pipeline(&Draw {
                label: input.vertex,
                module: input.module,
                groups: &input.groups,
                buffers: &input.buffers,
                cull: None,
                vertex: input.vertex,
                fragment,
                target,
                constants: &constants,
            })
        };
        let plain = pipeline(solid, false);
        Self {
            masked: pipeline(masked, false),
            small: if target.lit() { pipeline(Some("small"), true) } else { plain.clone() },
            solid: plain,
        }
    }

    /// Sets the pipeline for the leaves of a region, and the bind group of their model.
    fn set(&self, pass: &mut wgpu::RenderPass<'_>, shape: &RegionShape) {
        let part = &shape.model.leaves;
        pass.set_pipeline(match (shape.small, part.masked) {
            (true, _) => &self.small,
            (false, true) => &self.masked,
            (false, false) => &self.solid,
        });
        pass.set_bind_group(1, &part.bind_group, &[]);
    }
}

/// Pipelines for the picture and for its shadow maps.
struct PictureAndShadow {
    picture: Pipelines,
    shadow: Pipelines,
}

impl PictureAndShadow {
    fn new(shaders: &Shaders<'_>, input: &VertexInput<'_>, constants: &[(&str, f64)]) -> Self {
        let (colors, holes) = ([Some("solid"), Some("masked")], [None, Some("masked_shadow")]);
        Self {
            picture: Pipelines::new(shaders, input, colors, picture_target(), constants),
            shadow: Pipelines::new(shaders, input, holes, SHADOW_TARGET, constants),
        }
    }

    fn of(&self, shadow: bool) -> &Pipelines {
        if shadow { &self.shadow } else { &self.picture }
    }
}

/// A pipeline that fills textures, a fragment for each leaf or vertex.
fn fill_pipeline(
    shaders: &Shaders<'_>,
    (module, fragment): (&Module, &str),
    groups: &[&wgpu::BindGroupLayout],
    buffers: &[wgpu::VertexBufferLayout<'_>],
    formats: &[wgpu::TextureFormat],
    constants: &[(&str, f64)],
) -> wgpu::RenderPipeline {
    let device = shaders.device;
    let groups: Vec<Option<&wgpu::BindGroupLayout>> = groups.iter().copied().map(Some).collect();
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(module.name),
        bind_group_layouts: &groups,
        immediate_size: 0,
    });
    let targets: Vec<Option<wgpu::ColorTargetState>> =
        formats.iter().map(|&format| Some(format.into())).collect();
    let compiled = shaders.module(module);
    let options = wgpu::PipelineCompilationOptions::default();
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(module.name),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &compiled,
            entry_point: Some("cover"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers,
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &compiled,
            entry_point: Some(fragment),
            compilation_options: wgpu::PipelineCompilationOptions { constants, ..options },
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// An attachment that keeps what is there.
fn loaded(view: &wgpu::TextureView) -> wgpu::RenderPassColorAttachment<'_> {
    wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
    }
}

/// The pipelines of one strategy for a device, for any number of forests and views.
pub struct PublishedPasses {
    pub(crate) device: wgpu::Device,
    pub(crate) layouts: PassLayouts,
    options: PassOptions,
    /// Absent for [`Strategy::Vertex`], which poses while it draws, and for [`Strategy::Cpu`].
    pose: Option<wgpu::RenderPipeline>,
    falling: PictureAndShadow,
    litter: PictureAndShadow,
    pub(crate) occlusion: Option<OcclusionPasses>,
}

impl PublishedPasses {
    /// Builds the pipelines of a strategy. They draw into whole pictures ([`windfall_gpu::Layers::picture`]) and their
    /// shadow maps. It takes a second or two: at load time, never inside a frame.
    pub fn new(device: &wgpu::Device, options: PassOptions) -> Self {
        let PassOptions { strategy, landing, occlusion, .. } = options;
        let layouts = PassLayouts::new(device);
        let shaders = Shaders::new(device, SETTINGS);
        let search = f64::from(u8::from(landing == LandingSearch::InShader));
        let search = [("search_landing", search)];
        let input = match strategy {
            Strategy::Vertex => vertex::input(&layouts, options.one_dimensional()),
            Strategy::Fragment => fragment::input(&layouts),
            Strategy::VertexBuffer => vertex_buffer::input(&layouts),
            Strategy::Cpu => litter::input(&layouts),
        };
        // The others pose before they draw.
        let drawn: &[_] = if strategy == Strategy::Vertex { &search } else { &[] };
        Self {
            pose: match strategy {
                Strategy::Vertex | Strategy::Cpu => None,
                Strategy::Fragment => Some(fragment::pose_pipeline(&shaders, &layouts, &search)),
                Strategy::VertexBuffer => {
                    Some(vertex_buffer::pose_pipeline(&shaders, &layouts, &search))
                }
            },
            falling: PictureAndShadow::new(&shaders, &input, drawn),
            litter: PictureAndShadow::new(&shaders, &litter::input(&layouts), &[]),
            occlusion: occlusion.map(|occlusion| {
                let of = (options, occlusion.clamped());
                OcclusionPasses::new(&shaders, &layouts, of, &input, drawn)
            }),
            options,
            device: device.clone(),
            layouts,
        }
    }

    /// The strategy.
    pub fn strategy(&self) -> Strategy {
        self.options.strategy
    }

    /// What they were built for.
    pub fn options(&self) -> PassOptions {
        self.options
    }

    /// Whether leaves in the air that are not seen are skipped.
    pub fn leaf_occlusion(&self) -> bool {
        self.occlusion.is_some()
    }

    pub(crate) fn tables_group(
        &self,
        uniform: &wgpu::Buffer,
        tables: &wgpu::TextureView,
        paths: &[wgpu::TextureView; 2],
    ) -> wgpu::BindGroup {
        let [tables, positions, orientations] =
            [tables, &paths[0], &paths[1]].map(wgpu::BindingResource::TextureView);
        let resources = [uniform.as_entire_binding(), tables, positions, orientations];
        layouts::group(&self.device, "path tables", &self.layouts.tables, &resources)
    }

    pub(crate) fn leaves_group(&self, list: &wgpu::TextureView) -> wgpu::BindGroup {
        let list = wgpu::BindingResource::TextureView(list);
        layouts::group(&self.device, "active leaves", &self.layouts.leaves, &[list])
    }

    pub(crate) fn posed_group(&self, targets: &[wgpu::TextureView; 2]) -> wgpu::BindGroup {
        let views = targets.each_ref().map(wgpu::BindingResource::TextureView);
        layouts::group(&self.device, "posed leaves", &self.layouts.posed, &views)
    }

    /// Poses the active leaves, if the strategy does that before they are drawn.
    pub(crate) fn pose(
        &self,
        recording: &mut windfall_gpu::Recording<'_>,
        frame: &wgpu::BindGroup,
        leaves: &LeafBuffers,
    ) {
        let Some(pipeline) = &self.pose else { return };
        match &leaves.posed {
            Posed::Nothing | Posed::Uploaded(_) => {}
            Posed::Leaves(posed) => fragment::pose(recording, (pipeline, frame), leaves, posed),
            Posed::Vertices(posed) => {
                vertex_buffer::pose(recording, (pipeline, frame), leaves, posed);
            }
        }
    }

    /// Draws active leaves and litter into the picture or a shadow map.
    pub(crate) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, leaves: &LeafBuffers, shadow: bool) {
        let visible = leaves.visibility.as_ref().filter(|_| !shadow);
        match (&self.occlusion, visible) {
            (Some(occlusion), Some(visible)) => occlusion.draw(pass, leaves, visible),
            _ => draw_active(pass, leaves, self.falling.of(shadow)),
        }
        let litter = &leaves.lists.litter;
        draw_list(pass, leaves, (litter, &litter.buffer), self.litter.of(shadow));
    }
}

/// Draws the active leaves as the strategy has posed them.
fn draw_active(pass: &mut wgpu::RenderPass<'_>, leaves: &LeafBuffers, pipelines: &Pipelines) {
    match &leaves.posed {
        Posed::Nothing => {
            let list = &leaves.lists.active;
            draw_list(pass, leaves, (list, &list.buffer), pipelines);
        }
        Posed::Uploaded(buffer) => {
            draw_list(pass, leaves, (&leaves.lists.active, buffer), pipelines);
        }
        Posed::Leaves(posed) => fragment::draw(pass, leaves, posed, pipelines),
        Posed::Vertices(posed) => vertex_buffer::draw(pass, leaves, posed, pipelines),
    }
}

/// Draws a list whose elements are instances, out of a buffer that is laid out as the list's own.
fn draw_list<T: bytemuck::Pod>(
    pass: &mut wgpu::RenderPass<'_>,
    leaves: &LeafBuffers,
    (list, buffer): (&Arena<T>, &wgpu::Buffer),
    pipelines: &Pipelines,
) {
    pass.set_bind_group(2, &leaves.tables_group, &[]);
    for (_, shape, range) in leaves.draws(list) {
        pipelines.set(pass, shape);
        shape.buffers().set(pass);
        pass.set_vertex_buffer(1, buffer.slice(..));
        pass.draw_indexed(0..shape.buffers().index_count, 0, range);
    }
}
