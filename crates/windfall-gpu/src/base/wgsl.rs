//! Composed shader modules: shared declarations, constants of Rust, and the pass's own text.

use crate::base::shared::{
    Crown, CullFrame, FallFrame, Frame, LeafRecord, LooseLeaf, Model, SkyUniform, Stream, Surface,
    TreeInstance, TreeList, TreeRecord,
};
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};
use windfall_core::path::Edition;
use windfall_core::simplify::{LIT_AT_VERTICES, SHADE_SPREAD};

/// Shared functions, by what they are of. A module that uses tables declares them itself.
pub mod text {
    /// How a tree is drawn at its distance.
    pub const SIMPLIFY: &str = include_str!("wgsl/simplify.wgsl");
    /// Path tables and terrain in a texture.
    pub const TABLES: &str = include_str!("wgsl/tables.wgsl");
    /// Samples of paths in that texture.
    pub const PATH_SAMPLES: &str = include_str!("wgsl/path_samples.wgsl");
    /// When leaves detach.
    pub const SHED: &str = include_str!("wgsl/shed.wgsl");
    /// Where a falling leaf is.
    pub const POSE: &str = include_str!("wgsl/pose.wgsl");
    /// A leaf that has left its twig, as it is drawn.
    pub const LOOSE: &str = include_str!("wgsl/loose.wgsl");
    /// Groups of slots at rest.
    pub const REST: &str = include_str!("wgsl/rest.wgsl");
    /// The instance-step vertex buffer of trees.
    pub const INSTANCE: &str = include_str!("wgsl/instance.wgsl");
    /// Heights of the terrain.
    pub const HEIGHTS: &str = include_str!("wgsl/heights.wgsl");
    /// Corners of quads.
    pub const QUADS: &str = include_str!("wgsl/quads.wgsl");
}

/// Functions of every module.
const SHARED: [&str; 8] = [
    include_str!("wgsl/frame.wgsl"),
    include_str!("wgsl/hash.wgsl"),
    include_str!("wgsl/light.wgsl"),
    include_str!("wgsl/leaf_light.wgsl"),
    include_str!("wgsl/sway.wgsl"),
    include_str!("wgsl/season.wgsl"),
    include_str!("wgsl/branch.wgsl"),
    include_str!("wgsl/measured.wgsl"),
];

/// What the text of modules depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Samples of a pixel that foliage is drawn into: 1 or 4.
    pub samples: u32,
}

/// Shared declarations, constants and functions, then `sources`.
pub fn compose(settings: &Settings, sources: &[&str]) -> String {
    let structs = [
        Frame::wgsl(),
        Model::wgsl(),
        Crown::wgsl(),
        Surface::wgsl(),
        TreeInstance::wgsl(),
        TreeRecord::wgsl(),
        TreeList::wgsl(),
        CullFrame::wgsl(),
        FallFrame::wgsl(),
        Stream::wgsl(),
        LeafRecord::wgsl(),
        LooseLeaf::wgsl(),
        SkyUniform::wgsl(),
    ];
    let numbers = format!(
        "const LIT_AT_VERTICES: f32 = {LIT_AT_VERTICES:?};\n\
         const SHADE_SPREAD: f32 = {SHADE_SPREAD:?};\n\
         const SAMPLES: u32 = {}u;\n",
        settings.samples,
    );
    let factors = |name: &str, edition: Edition| {
        let [turn, size, start] = edition.factors();
        format!("const {name} = vec3<f32>({turn:?}, {size:?}, {start:?});\n")
    };
    let papers = factors("PAPER_2007", Edition::Of2007) + &factors("PAPER_2008", Edition::Of2008);
    let constants = [
        numbers,
        papers,
        crate::base::constants::effects(),
        crate::base::constants::debug_views(),
        crate::base::constants::numbers(),
    ]
    .concat();
    [structs.concat(), constants, SHARED.join("\n"), sources.join("\n")].join("\n")
}

/// A shader module that can be composed.
pub struct Module {
    /// Its name, for people and files.
    pub name: &'static str,
    /// Its text.
    pub source: fn(&Settings) -> String,
}

/// The modules of a device, each compiled once.
pub struct Shaders<'a> {
    /// The device.
    pub device: &'a wgpu::Device,
    /// What the text depends on.
    pub settings: Settings,
    compiled: Mutex<HashMap<&'static str, wgpu::ShaderModule>>,
}

impl<'a> Shaders<'a> {
    /// None is compiled yet.
    pub fn new(device: &'a wgpu::Device, settings: Settings) -> Self {
        Self { device, settings, compiled: Mutex::default() }
    }

    /// The module, compiled at its first use.
    pub fn module(&self, module: &Module) -> wgpu::ShaderModule {
        let mut compiled = self.compiled.lock().unwrap_or_else(PoisonError::into_inner);
        let of_device = compiled.entry(module.name).or_insert_with(|| {
            self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(module.name),
                source: wgpu::ShaderSource::Wgsl((module.source)(&self.settings).into()),
            })
        });
        of_device.clone()
    }

    /// A compute pipeline; `entry` is also its label.
    pub fn compute(
        &self,
        module: &Module,
        entry: &str,
        groups: &[&wgpu::BindGroupLayout],
        constants: &[(&str, f64)],
    ) -> wgpu::ComputePipeline {
        let groups: Vec<Option<&wgpu::BindGroupLayout>> =
            groups.iter().copied().map(Some).collect();
        let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(entry),
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: Some(&layout),
            module: &self.module(module),
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants,
                ..Default::default()
            },
            cache: None,
        })
    }
}
