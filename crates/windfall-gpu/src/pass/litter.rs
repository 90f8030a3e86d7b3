//! Leaves that lie for good, for the strategies without compute: static geometry (VB 5).

use super::Shaders;
use super::draw::DrawTarget;
use super::listed::{Layouts, Pair, SHAPE, set_shape};
use crate::listed::ListedFalls;
use crate::model::GpuModel;
use crate::shared::LitterLeaf;

pub(crate) struct Litter {
    pipelines: Pair,
}

impl Litter {
    pub fn new(
        shaders: &Shaders<'_>,
        part_layout: &wgpu::BindGroupLayout,
        layouts: &Layouts,
    ) -> Self {
        let leaf = wgpu::VertexBufferLayout {
            array_stride: size_of::<LitterLeaf>() as u64,
            step_mode: wgpu::VertexStepMode::Instance,
            attributes: &wgpu::vertex_attr_array![
                3 => Float32x4, 4 => Snorm16x4, 5 => Unorm8x4, 6 => Uint32, 7 => Float32x2
            ],
        };
        let source = include_str!("../../shaders/litter.wgsl");
        let groups = [part_layout, &layouts.tables];
        Self { pipelines: Pair::new(shaders, source, "lying", &groups, &[SHAPE, leaf], true) }
    }

    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        models: &[GpuModel],
        falls: &ListedFalls,
        into: DrawTarget,
    ) {
        let list = &falls.roster.litter;
        pass.set_bind_group(2, &falls.tables_group, &[]);
        pass.set_vertex_buffer(1, list.buffer.slice(..));
        for (bin, leaves, indices) in falls.draws(list) {
            self.pipelines.set(pass, models, bin, into);
            set_shape(pass, bin);
            pass.draw_indexed(0..indices, 0, leaves);
        }
    }
}
