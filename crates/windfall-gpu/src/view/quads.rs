//! Leaves on the twigs of a view that are drawn as quads: their buffers.

use crate::base::constants::BATCH;
use crate::base::layouts::{self, Layouts};
use crate::base::shared::TreeInstance;
use crate::scene::forest::ForestBuffers;
use crate::scene::leaf_mesh::LeafQuads;
use crate::view::lists::TreeLists;
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
    /// Models with quads, and their groups.
    pub models: Vec<(usize, wgpu::BindGroup)>,
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
        // The list of the view comes first in what all lists have placed.
        let of_view = trees.records.len() as u64 * size_of::<TreeInstance>() as u64;
        let mut facts = vec![[0; 4]; 1 + trees.parts.len()];
        let mut ranges = Vec::new();
        let mut all = 0;
        for (m, ((model, places), crown)) in forest.models.iter().zip(&trees.crowns).enumerate() {
            let quads = model.quads.as_ref().filter(|_| fits(&model.leaves.vertices));
            let Some(&LeafQuads { first, .. }) = quads else {
                continue;
            };
            let draws = trees.draws[m].simple.clone();
            let instances = *places as usize;
            if draws.is_empty() || instances == 0 {
                continue;
            }
            let (first_index, mut leaves) = (trees.parts[draws.start as usize].indices.0, 0);
            for draw in draws.clone() {
                let (at, count) = trees.parts[draw as usize].indices;
                let corner = first + 4 * ((at - first_index) / 6);
                facts[1 + draw as usize] = [count / 6, corner, crown.tree_first, 0];
                leaves += u64::from(count / 6);
            }
            all += leaves * instances as u64;
            ranges.push((m, [draws.start, draws.end - draws.start, 0, 0]));
        }
        let room = all.min(u64::from(most)).min(limit / (4 * CORNER)) as u32;
        if room == 0 || of_view > limit {
            return None;
        }
        let buffers = QuadBuffers::new(device, room, 3 * ranges.len() as u32);
        facts[0] = [trees.parts.len() as u32, ranges.len() as u32, room, buffers.draws];
        facts.extend(ranges.iter().map(|(_, range)| *range));
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
        let of_model = |(m, range): (usize, [u32; 4])| {
            let range = init(bytemuck::cast_slice(&range), wgpu::BufferUsages::UNIFORM);
            let vertices = &forest.models[m].0.leaves.vertices;
            let resources = [&range, vertices, &lists.placed, &parts, &buffers.corners];
            let group = layouts::group(
                device,
                "quads of a model",
                &layouts.spread_quads,
                &resources.map(|b| b.as_entire_binding()),
            );
            (m, group)
        };
        let models = ranges.into_iter().map(of_model).collect();
        Some(Self { buffers, arrange_group, models })
    }

    /// Bytes of their buffers.
    pub fn bytes(&self) -> u64 {
        self.buffers.corners.size() + self.buffers.arguments.size()
    }
}
