//! Strategy `vertex` (VB 6, first): every vertex of a falling leaf finds its place.

use super::Shaders;
use super::listed::{Layouts, PictureAndShadow, Pipelines, Placing, SHAPE};
use crate::listed::ListedFalls;
use crate::model::GpuModel;
use crate::shared::FallingLeaf;

pub(crate) struct VertexFalls {
    pub(super) pipelines: PictureAndShadow,
}

impl VertexFalls {
    pub fn new(
        shaders: &Shaders<'_>,
        part_layout: &wgpu::BindGroupLayout,
        layouts: &Layouts,
    ) -> Self {
        Self { pipelines: PictureAndShadow::new(shaders, &Self::placing(part_layout, layouts)) }
    }

    pub fn placing<'a>(
        part_layout: &'a wgpu::BindGroupLayout,
        layouts: &'a Layouts,
    ) -> Placing<'a> {
        let leaf = wgpu::VertexBufferLayout {
            array_stride: size_of::<FallingLeaf>() as u64,
            step_mode: wgpu::VertexStepMode::Instance,
            attributes: &const {
                wgpu::vertex_attr_array![
                    3 => Float32x4, 4 => Float32x4, 5 => Float32x4, 6 => Uint32x4, 7 => Uint32x4
                ]
            },
        };
        Placing {
            source: include_str!("../../shaders/vertex_falls.wgsl"),
            vertex: "falling",
            groups: vec![part_layout, &layouts.tables],
            buffers: vec![SHAPE, leaf],
            posing: true,
        }
    }

    pub fn draw(
        pass: &mut wgpu::RenderPass<'_>,
        models: &[GpuModel],
        falls: &ListedFalls,
        pipelines: &Pipelines,
    ) {
        let list = &falls.roster.falling;
        pass.set_bind_group(2, &falls.tables_group, &[]);
        pass.set_vertex_buffer(1, list.buffer.slice(..));
        for (_, shape, leaves) in falls.draws(list) {
            pipelines.set(pass, models, shape);
            shape.buffers.set(pass);
            pass.draw_indexed(0..shape.buffers.index_count, 0, leaves);
        }
    }
}
