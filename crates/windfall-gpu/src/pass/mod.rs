//! One file per pass: an immutable struct with its pipelines, and a `draw`.

pub(crate) mod cull;
mod draw;
mod falls;
mod fragment_falls;
mod grass;
pub(crate) mod ground;
pub(crate) mod hiz;
mod leaf_occlusion;
mod leaves;
mod listed;
mod litter;
pub(crate) mod quads;
pub(crate) mod shadow;
pub(crate) mod sky;
#[cfg(test)]
mod tests;
mod tone_map;
mod vertex_buffer_falls;
mod vertex_falls;
mod wood;

pub(crate) use cull::Cull;
pub(crate) use draw::DrawTarget;
pub(crate) use falls::Falls;
pub(crate) use grass::Grass;
pub(crate) use ground::Ground;
pub(crate) use hiz::HiZ;
pub(crate) use leaf_occlusion::{GpuOcclusion, ListedOcclusion};
pub(crate) use leaves::Leaves;
pub(crate) use listed::ListedPasses;
pub(crate) use quads::Quads;
pub(crate) use sky::SkyDome;
pub(crate) use tone_map::ToneMap;
pub(crate) use wood::Wood;

use crate::cull::CpuList;
use crate::shared::{
    Crown, CullFrame, FallFrame, FallingLeaf, Frame, LeafRecord, LitterLeaf, LooseLeaf, Model,
    Stream, Surface, TreeInstance, TreeList, TreeRecord,
};
use std::ops::Range;
use windfall_core::simplify::{LIT_AT_VERTICES, SHADE_SPREAD, SIMPLE_BELOW};

/// What every pass needs to make its pipelines.
pub(crate) struct Shaders<'a> {
    pub device: &'a wgpu::Device,
    pub frame_layout: &'a wgpu::BindGroupLayout,
}

/// Shared declarations and functions, then the pass's own.
fn compose(sources: &[&str]) -> String {
    let structs = [
        Frame::wgsl(),
        Model::wgsl(),
        Surface::wgsl(),
        TreeInstance::wgsl(),
        TreeRecord::wgsl(),
        Crown::wgsl(),
        TreeList::wgsl(),
        CullFrame::wgsl(),
        FallFrame::wgsl(),
        Stream::wgsl(),
        LeafRecord::wgsl(),
        LooseLeaf::wgsl(),
        FallingLeaf::wgsl(),
        LitterLeaf::wgsl(),
    ];
    let shared = [
        include_str!("../../shaders/shared/frame.wgsl"),
        include_str!("../../shaders/shared/hash.wgsl"),
        include_str!("../../shaders/shared/light.wgsl"),
        include_str!("../../shaders/shared/leaf_light.wgsl"),
        include_str!("../../shaders/shared/sway.wgsl"),
        include_str!("../../shaders/shared/season.wgsl"),
        include_str!("../../shaders/shared/branch.wgsl"),
        include_str!("../../shaders/shared/measured.wgsl"),
    ];
    let constants = format!(
        "const SIMPLE_BELOW: f32 = {SIMPLE_BELOW:?};\n\
         const LIT_AT_VERTICES: f32 = {LIT_AT_VERTICES:?};\n\
         const SHADE_SPREAD: f32 = {SHADE_SPREAD:?};\n"
    );
    [structs.concat(), constants, shared.join("\n"), sources.join("\n")].join("\n")
}

/// The instance-step buffer of trees.
fn tree_instances() -> wgpu::VertexBufferLayout<'static> {
    wgpu::VertexBufferLayout {
        array_stride: size_of::<TreeInstance>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &crate::forest::TREE_ATTRIBUTES,
    }
}

/// A list of trees, to be drawn from.
#[derive(Clone, Copy)]
pub(crate) struct ListedTrees<'a> {
    /// Which of the frame's lists.
    pub index: usize,
    /// What the CPU knows of it; `None` if the GPU made it.
    pub on_cpu: Option<&'a CpuList>,
}

impl<'a> ListedTrees<'a> {
    pub fn new(index: usize, on_cpu: Option<&'a [CpuList]>) -> Self {
        Self { index, on_cpu: on_cpu.map(|lists| &lists[index]) }
    }
}

/// A model's draws of leaves and of wood.
type DrawRanges = (Range<u32>, Range<u32>);

/// Draws leaves or wood of a list of trees.
fn draw_parts<'a>(
    pass: &mut wgpu::RenderPass<'_>,
    forest: &'a crate::GpuForest,
    trees: ListedTrees<'_>,
    part: impl Fn(&'a crate::model::GpuModel) -> &'a crate::model::Part,
    draws: impl Fn(&crate::model::GpuModel, &DrawRanges) -> Range<u32>,
    mut before: impl FnMut(&mut wgpu::RenderPass<'_>, &crate::model::GpuModel),
) {
    let size = size_of::<TreeInstance>() as u64;
    let list_first = trees.index as u64 * forest.trees.records.len() as u64;
    let all_draws = forest.trees.parts.len() as u64;
    for (i, model) in forest.models.iter().enumerate() {
        let crown = &forest.trees.crowns[i];
        let draws = draws(model, &forest.trees.draws[i]);
        if draws.is_empty() || crown.block_count == 0 {
            continue;
        }
        let part = part(model);
        before(pass, model);
        pass.set_bind_group(1, &part.bind_group, &[]);
        pass.set_vertex_buffer(0, part.vertices.slice(..));
        let first = (list_first + u64::from(crown.tree_first)) * size;
        let bytes = u64::from(crown.block_count * crate::cull::BLOCK) * size;
        pass.set_vertex_buffer(1, forest.lists.placed.slice(first..first + bytes));
        pass.set_index_buffer(part.indices.slice(..), wgpu::IndexFormat::Uint32);
        if let Some(list) = trees.on_cpu {
            for draw in draws {
                let instances = list.instances[draw as usize].clone();
                if !instances.is_empty() {
                    let (first, count) = forest.trees.parts[draw as usize].indices;
                    pass.draw_indexed(first..first + count, 0, instances);
                }
            }
        } else {
            let first = (trees.index as u64 * all_draws + u64::from(draws.start)) * 20;
            let count = draws.end - draws.start;
            pass.multi_draw_indexed_indirect(&forest.lists.arguments, first, count);
        }
    }
}
