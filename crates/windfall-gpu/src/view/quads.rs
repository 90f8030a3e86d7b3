//! Leaves on the twigs of a view that are drawn as quads: their buffers.

use crate::base::constants::BATCH;
use crate::base::layouts::{self, Layouts};
use crate::base::shared::TreeInstance;
use crate::scene::forest::ForestBuffers;
use crate::scene::leaf_mesh::LeafQuads;
use crate::scene::parts::WHOLE_PARTS;
use crate::view::lists::TreeLists;
use std::ops::Range;
use wgpu::util::DeviceExt;

/// Bytes of a corner.
pub const CORNER: u64 = 16;

/// The buffers of quads and of the arguments that draw them.
pub struct QuadBuffers {
    pub corners: wgpu::Buffer,
    pub arguments: wgpu::Buffer,
    pub draws: u32,
}

impl QuadBuffers {
    /// Room for so many quads; behind the arguments of their draws `words` more.
    fn new(device: &wgpu::Device, room: u32, words: u32) -> Self {
        let draws = room.div_ceil(BATCH);
        let buffer = |label, size, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage: usage | wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            })
        };
        Self {
            corners: buffer("quads", u64::from(room) * 4 * CORNER, wgpu::BufferUsages::VERTEX),
            arguments: buffer(
                "draws of quads",
                u64::from(5 * draws + words) * 4,
                wgpu::BufferUsages::INDIRECT,
            ),
            draws,
        }
    }
}

/// The quads of the leaves on the twigs of a view.
pub struct HangingQuads {
    pub buffers: QuadBuffers,
    pub arrange_group: wgpu::BindGroup,
    /// Models with quads; of each the groups for those pipelines.
    pub models: Vec<(usize, [wgpu::BindGroup; 2])>,
}

impl HangingQuads {
    /// Room for the leaves of a forest's far trees, of `most` at a time; `None` where none can be drawn
    /// as quads.
    pub fn new(
        device: &wgpu::Device,
        layouts: &Layouts,
        forest: &ForestBuffers,
        lists: &TreeLists,
        most: u32,
    ) -> Option<Self> {
        let limit = device.limits().max_storage_buffer_binding_size;
        let fits = |buffer: &wgpu::Buffer| buffer.size() <= limit;
        let trees = &forest.tables;
        // The trees of the view come first in what all lists have placed.
        let of_view = trees.records.len() as u64 * size_of::<TreeInstance>() as u64;
        let mut facts = vec![[0; 4]; 1 + trees.parts.len()];
        let mut ranges = Vec::new();
        let mut all = 0;
        for (m, ((model, places), crown)) in forest.models.iter().zip(&trees.crowns).enumerate() {
            let quads = model.quads.as_ref().filter(|_| fits(&model.leaves.vertices));
            let Some(&LeafQuads { first, .. }) = quads else {
                continue;
            };
            // The first parts are those of near trees; the next, that of trees whose leaves are small, has
            // all leaves, the others have them by and by.
            let Range { start, end } = trees.draws[m].0.clone();
            let instances = *places as usize;
            let whole = start + WHOLE_PARTS - 1;
            if end <= whole || instances == 0 {
                continue;
            }
            let all_leaves = trees.parts[whole as usize].indices;
            for draw in whole..end {
                let (at, count) = trees.parts[draw as usize].indices;
                let corner = first + 4 * ((at - all_leaves.0) / 6);
                facts[1 + draw as usize] = [count / 6, corner, crown.tree_first, 0];
            }
            all += u64::from(all_leaves.1 / 6) * instances as u64;
            ranges.push((m, [[whole, 1, 0, 0], [whole + 1, end - whole - 1, 0, 0]]));
        }
        let room = all.min(u64::from(most)).min(limit / (4 * CORNER)) as u32;
        if room == 0 || of_view > limit {
            return None;
        }
        let buffers = QuadBuffers::new(device, room, 6 * ranges.len() as u32);
        facts[0] = [trees.parts.len() as u32, 2 * ranges.len() as u32, room, buffers.draws];
        facts.extend(ranges.iter().flat_map(|(_, ranges)| *ranges));
        let init = |contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("parts in quads"),
                contents,
                usage,
            })
        };
        let facts = init(bytemuck::cast_slice(&facts), wgpu::BufferUsages::STORAGE);
        let parts = vec![[0u32; 4]; trees.parts.len() + 1];
        let parts = init(bytemuck::cast_slice(&parts), wgpu::BufferUsages::STORAGE);
        let arrange_group = layouts::group(
            device,
            "arranged quads",
            &layouts.arrange_quads,
            &[&facts, &lists.arguments, &parts, &buffers.arguments].map(|b| b.as_entire_binding()),
        );
        let of_model = |(m, ranges): (usize, [[u32; 4]; 2])| {
            let groups = ranges.map(|range| {
                let range = init(bytemuck::cast_slice(&range), wgpu::BufferUsages::UNIFORM);
                let vertices = &forest.models[m].0.leaves.vertices;
                let resources = [&range, vertices, &lists.placed, &parts, &buffers.corners];
                layouts::group(
                    device,
                    "quads of a model",
                    &layouts.spread_quads,
                    &resources.map(|b| b.as_entire_binding()),
                )
            });
            (m, groups)
        };
        let models = ranges.into_iter().map(of_model).collect();
        Some(Self { buffers, arrange_group, models })
    }

    /// Bytes of their buffers.
    pub fn bytes(&self) -> u64 {
        self.buffers.corners.size() + self.buffers.arguments.size()
    }
}
