//! Leaves that lie for good, for the strategies without compute: static geometry (VB 5).

use super::Shaders;
use super::draw::DrawTarget;
use super::listed::{Layouts, PictureAndShadow, Placing, SHAPE};
use crate::listed::ListedFalls;
use crate::model::GpuModel;
use crate::shared::LitterLeaf;

pub(crate) struct Litter {
    pipelines: PictureAndShadow,
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
        let placing = Placing {
            source: include_str!("../../shaders/litter.wgsl"),
            vertex: "lying",
            groups: vec![part_layout, &layouts.tables],
            buffers: vec![SHAPE, leaf],
            posing: true,
        };
        Self { pipelines: PictureAndShadow::new(shaders, &placing) }
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
        for (_, shape, leaves) in falls.draws(list) {
            self.pipelines.of(into).set(pass, models, shape);
            shape.buffers.set(pass);
            pass.draw_indexed(0..shape.buffers.index_count, 0, leaves);
        }
    }
}
