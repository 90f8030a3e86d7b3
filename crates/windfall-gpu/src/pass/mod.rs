//! One file per pass: an immutable struct with its pipelines, and a `draw`.

mod draw;
mod falls;
mod fragment_falls;
mod grass;
pub(crate) mod ground;
mod leaves;
#[cfg(test)]
mod light_tests;
mod listed;
mod litter;
pub(crate) mod shadow;
pub(crate) mod sky;
mod tone_map;
mod vertex_buffer_falls;
mod vertex_falls;
mod wood;

pub(crate) use draw::DrawTarget;
pub(crate) use falls::Falls;
pub(crate) use grass::Grass;
pub(crate) use ground::Ground;
pub(crate) use leaves::Leaves;
pub(crate) use listed::ListedPasses;
pub(crate) use sky::SkyDome;
pub(crate) use tone_map::ToneMap;
pub(crate) use wood::Wood;

use crate::shared::{
    FallFrame, FallingLeaf, Frame, LeafRecord, LitterLeaf, LooseLeaf, Model, Stream, Surface,
    TreeInstance,
};

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
    ];
    [structs.concat(), shared.join("\n"), sources.join("\n")].join("\n")
}

/// The instance-step buffer of trees.
fn tree_instances() -> wgpu::VertexBufferLayout<'static> {
    wgpu::VertexBufferLayout {
        array_stride: size_of::<TreeInstance>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &crate::forest::TREE_ATTRIBUTES,
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
