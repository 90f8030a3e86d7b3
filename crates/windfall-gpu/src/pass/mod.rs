//! One stem per pass: `X.rs` has its pipelines and records it, `X.wgsl` beside it is its shader.

pub(crate) mod cull;
pub(crate) mod falls;
pub(crate) mod gather;
pub(crate) mod grass;
pub(crate) mod ground;
pub(crate) mod hiz;
pub(crate) mod leaves;
pub(crate) mod quads;
pub(crate) mod sky;
pub(crate) mod sky_light;
#[cfg(test)]
mod tests;
pub(crate) mod tone_map;
pub(crate) mod wood;

use crate::base::constants::{BLOCK, DRAW_WORDS};
use crate::base::shared::TreeInstance;
use crate::base::wgsl::Module;
use crate::scene::forest::ForestBuffers;
use crate::scene::model::{ModelData, Part};
use crate::scene::trees::DrawRanges;
use crate::view::lists::TreeLists;
use std::ops::Range;

/// Every module.
pub const MODULES: &[&Module] = &[
    &cull::CULL,
    &falls::FALLS,
    &gather::GATHER,
    &grass::FIND_GRASS,
    &grass::GRASS,
    &ground::GROUND,
    &hiz::HIZ,
    &leaves::LEAVES,
    &quads::ARRANGE_QUADS,
    &quads::HANGING_QUADS,
    &quads::QUADS,
    &sky::SKY,
    &sky_light::SKY_LIGHT,
    &tone_map::TONE_MAP,
    &wood::WOOD,
];

/// [`TreeInstance`] as a vertex buffer.
const TREE_ATTRIBUTES: [wgpu::VertexAttribute; 4] =
    wgpu::vertex_attr_array![8 => Float32x4, 9 => Float32x4, 10 => Float32x4, 11 => Uint32x4];

/// The instance-step buffer of trees.
fn tree_instances() -> wgpu::VertexBufferLayout<'static> {
    wgpu::VertexBufferLayout {
        array_stride: size_of::<TreeInstance>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &TREE_ATTRIBUTES,
    }
}

/// Draws leaves or wood of a list of trees.
fn draw_parts(
    pass: &mut wgpu::RenderPass<'_>,
    forest: &ForestBuffers,
    (lists, list): (&TreeLists, usize),
    part: impl Fn(&ModelData) -> &Part,
    draws: impl Fn(&ModelData, &DrawRanges) -> Range<u32>,
    mut before: impl FnMut(&mut wgpu::RenderPass<'_>, &ModelData),
) {
    let size = size_of::<TreeInstance>() as u64;
    let tables = &forest.tables;
    let list_first = list as u64 * tables.records.len() as u64;
    let all_draws = tables.parts.len() as u64;
    for (i, (model, _)) in forest.models.iter().enumerate() {
        let crown = &tables.crowns[i];
        let draws = draws(model, &tables.draws[i]);
        if draws.is_empty() || crown.block_count == 0 {
            continue;
        }
        let part = part(model);
        before(pass, model);
        pass.set_bind_group(1, &part.bind_group, &[]);
        pass.set_vertex_buffer(0, part.vertices.slice(..));
        let first = (list_first + u64::from(crown.tree_first)) * size;
        let bytes = u64::from(crown.block_count * BLOCK) * size;
        pass.set_vertex_buffer(1, lists.placed.slice(first..first + bytes));
        pass.set_index_buffer(part.indices.slice(..), wgpu::IndexFormat::Uint32);
        let first = (list as u64 * all_draws + u64::from(draws.start)) * u64::from(DRAW_WORDS) * 4;
        pass.multi_draw_indexed_indirect(&lists.arguments, first, draws.end - draws.start);
    }
}
