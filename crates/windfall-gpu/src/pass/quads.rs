//! Small leaves as quads: placed and lit by compute, once a leaf, then drawn all together.
//!
//! A leaf of a few pixels costs more before its pixels than in them: what its vertices have in common
//! is found four times, and on some devices vertices are shaded by few threads or an instance at a time.
//! Here a compute pass writes their corners in clip space, with their radiance, and one draw without
//! instances takes them from there.

use super::{
    Shaders, compose,
    draw::{Draw, DrawTarget},
};
use crate::cull::WHOLE_PARTS;
use crate::forest::GpuForest;
use crate::model::LeafQuads;
use crate::shared::TreeInstance;
use std::ops::Range;
use wgpu::util::DeviceExt;

/// Quads of a draw: as many as indices of 16 bits reach.
const BATCH: u32 = 1 << 14;
/// Bytes of a corner.
const CORNER: u64 = 16;

/// The buffers of quads and of the arguments that draw them.
pub(crate) struct QuadBuffers {
    corners: wgpu::Buffer,
    arguments: wgpu::Buffer,
    draws: u32,
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

/// Pipelines of quads, whatever leaves they are of.
pub(crate) struct Quads {
    arrange: wgpu::ComputePipeline,
    /// Of trees whose leaves are small, and of simplified trees.
    spread_hanging: [wgpu::ComputePipeline; 2],
    draw: wgpu::RenderPipeline,
    /// The triangles of a batch.
    indices: wgpu::Buffer,
    arrange_layout: wgpu::BindGroupLayout,
    hanging_layout: wgpu::BindGroupLayout,
}

/// The quads of the leaves on the twigs of a forest.
pub(crate) struct HangingQuads {
    buffers: QuadBuffers,
    arrange_group: wgpu::BindGroup,
    /// Models with quads; of each the groups for those pipelines.
    models: Vec<(usize, [wgpu::BindGroup; 2])>,
}

fn layout(
    device: &wgpu::Device,
    label: &str,
    types: &[wgpu::BufferBindingType],
) -> wgpu::BindGroupLayout {
    let entries: Vec<wgpu::BindGroupLayoutEntry> = (0..)
        .zip(types)
        .map(|(binding, &ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some(label),
        entries: &entries,
    })
}

fn group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    buffers: &[&wgpu::Buffer],
) -> wgpu::BindGroup {
    let entries: Vec<wgpu::BindGroupEntry<'_>> = (0..)
        .zip(buffers)
        .map(|(binding, buffer)| wgpu::BindGroupEntry {
            binding,
            resource: buffer.as_entire_binding(),
        })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("quads"),
        layout,
        entries: &entries,
    })
}

fn compute(
    device: &wgpu::Device,
    entry: &str,
    source: &str,
    groups: &[&wgpu::BindGroupLayout],
    constants: &[(&str, f64)],
) -> wgpu::ComputePipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(entry),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let groups: Vec<Option<&wgpu::BindGroupLayout>> = groups.iter().copied().map(Some).collect();
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(entry),
        bind_group_layouts: &groups,
        immediate_size: 0,
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: Some(&layout),
        module: &module,
        entry_point: Some(entry),
        compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
        cache: None,
    })
}

impl Quads {
    pub fn new(shaders: &Shaders<'_>, part_layout: &wgpu::BindGroupLayout) -> Self {
        let device = shaders.device;
        let uniform = wgpu::BufferBindingType::Uniform;
        let [read, write] =
            [true, false].map(|read_only| wgpu::BufferBindingType::Storage { read_only });
        let arrange_layout = layout(device, "arranged quads", &[read, write, write, write]);
        let hanging_layout =
            layout(device, "quads of hanging leaves", &[uniform, read, read, read, write]);
        let batch = format!("const BATCH: u32 = {BATCH}u;\n");
        let corners = include_str!("../../shaders/shared/quads.wgsl");
        let hanging = compose(&[
            include_str!("../../shaders/shared/instance.wgsl"),
            include_str!("../../shaders/leaves.wgsl"),
            corners,
            include_str!("../../shaders/hanging_quads.wgsl"),
        ]);
        let indices: Vec<u16> = (0..BATCH)
            .flat_map(|quad| [0, 1, 2, 0, 2, 3].map(|corner| (4 * quad + corner) as u16))
            .collect();
        Self {
            arrange: compute(
                device,
                "arrange",
                &[&batch, include_str!("../../shaders/arrange_quads.wgsl")].concat(),
                &[&arrange_layout],
                &[],
            ),
            spread_hanging: [0.0, 1.0].map(|far| {
                compute(
                    device,
                    "spread",
                    &hanging,
                    &[shaders.frame_layout, part_layout, &hanging_layout],
                    &[("far", far), ("lit", 1.0), ("lit_at_vertices", 1.0)],
                )
            }),
            draw: shaders.pipeline(&Draw {
                label: "quads",
                source: &[corners, include_str!("../../shaders/quads.wgsl")].join("\n"),
                groups: &[],
                buffers: &[wgpu::VertexBufferLayout {
                    array_stride: CORNER,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: &wgpu::vertex_attr_array![0 => Uint32x4],
                }],
                cull: None,
                vertex: "vertex",
                fragment: Some("fragment"),
                target: DrawTarget::Radiance,
                constants: &[],
            }),
            indices: device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("triangles of quads"),
                contents: bytemuck::cast_slice(&indices),
                usage: wgpu::BufferUsages::INDEX,
            }),
            arrange_layout,
            hanging_layout,
        }
    }

    /// Room for the leaves of a forest's far trees, of `most` at a time; `None` where none can be drawn
    /// as quads.
    pub fn hanging(
        &self,
        device: &wgpu::Device,
        forest: &GpuForest,
        most: u32,
    ) -> Option<HangingQuads> {
        let limit = device.limits().max_storage_buffer_binding_size;
        let fits = |buffer: &wgpu::Buffer| buffer.size() <= limit;
        let trees = &forest.trees;
        // The trees of the view come first in what all lists have placed.
        let of_view = trees.records.len() as u64 * size_of::<TreeInstance>() as u64;
        let mut facts = vec![[0; 4]; 1 + trees.parts.len()];
        let mut ranges = Vec::new();
        let mut all = 0;
        for (m, (model, crown)) in forest.models.iter().zip(&trees.crowns).enumerate() {
            let quads = model.quads.as_ref().filter(|_| fits(&model.leaves.vertices));
            let Some(&LeafQuads { first, .. }) = quads else {
                continue;
            };
            // The first parts are those of near trees; the next, that of trees whose leaves are small, has
            // all leaves, the others have them by and by.
            let Range { start, end } = trees.draws[m].0.clone();
            let instances = trees.records.iter().filter(|r| r.model == m as u32).count();
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
        let lists = &forest.lists;
        let arrange_group = group(
            device,
            &self.arrange_layout,
            &[&facts, &lists.arguments, &parts, &buffers.arguments],
        );
        let of_model = |(m, ranges): (usize, [[u32; 4]; 2])| {
            let groups = ranges.map(|range| {
                let range = init(bytemuck::cast_slice(&range), wgpu::BufferUsages::UNIFORM);
                let vertices = &forest.models[m].leaves.vertices;
                let resources = [&range, vertices, &lists.placed, &parts, &buffers.corners];
                group(device, &self.hanging_layout, &resources)
            });
            (m, groups)
        };
        let models = ranges.into_iter().map(of_model).collect();
        Some(HangingQuads { buffers, arrange_group, models })
    }

    /// Settles which leaves of the view's trees are drawn as quads, once their lists are made.
    pub fn arrange_hanging(&self, pass: &mut wgpu::ComputePass<'_>, quads: &HangingQuads) {
        pass.set_pipeline(&self.arrange);
        pass.set_bind_group(0, &quads.arrange_group, &[]);
        pass.dispatch_workgroups(1, 1, 1);
    }

    /// Places and lights them; group 0 is the frame's. After the shadow maps, which it looks up.
    pub fn spread_hanging(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        forest: &GpuForest,
        quads: &HangingQuads,
    ) {
        for (k, pipeline) in (0..).zip(&self.spread_hanging) {
            pass.set_pipeline(pipeline);
            for (i, (model, groups)) in (0..).zip(&quads.models) {
                pass.set_bind_group(1, &forest.models[*model].leaves.bind_group, &[]);
                pass.set_bind_group(2, &groups[k as usize], &[]);
                let words = 5 * u64::from(quads.buffers.draws) + 3 * (2 * i + k);
                pass.dispatch_workgroups_indirect(&quads.buffers.arguments, words * 4);
            }
        }
    }

    /// Draws what was spread.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, quads: &HangingQuads) {
        let QuadBuffers { corners, arguments, draws } = &quads.buffers;
        pass.set_pipeline(&self.draw);
        pass.set_vertex_buffer(0, corners.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint16);
        pass.multi_draw_indexed_indirect(arguments, 0, *draws);
    }
}

#[cfg(test)]
mod tests {
    use crate::{Camera, Capture, Falls, GpuForest, Renderer, Target, View};
    use glam::Vec3;
    use wgpu_profiler::{GpuProfiler, GpuProfilerSettings};
    use windfall_core::forest::{Placement, Terrain};
    use windfall_core::simplify::Simplification;
    use windfall_core::tree::Tree;
    use windfall_core::tree::species::Species;

    const SIZE: (u32, u32) = (256, 144);

    /// Near trees, trees of small leaves and simplified ones: with quads, with room for some of them,
    /// and without.
    #[test]
    fn quads_show_what_the_leaves_would() {
        let (device, queue) = windfall_testing::device();
        let settings = GpuProfilerSettings { enable_timer_queries: false, ..Default::default() };
        let profiler = GpuProfiler::new(&device, settings).unwrap();
        let picture = windfall_testing::picture(&device, SIZE);
        let renderer = Renderer::new(&device, picture.format());
        let canvas = renderer.canvas(&device, SIZE.0, SIZE.1);
        let trees: Vec<Tree> =
            [Species::Birch, Species::Maple].iter().map(|s| s.grow_with(1, 2000)).collect();
        let placement = Placement {
            trees: 60,
            spacing: 7.0,
            keep_out: Vec::new(),
            scale: (0.7, 1.3),
            season_spread: 0.2,
            seed: 11,
        };
        let placed = placement.place(Terrain::rolling(200.0, 3.0, 2), &[1.0, 2.0]);
        let mut forest =
            GpuForest::with_falls(&device, &queue, &renderer, &trees, &placed, &Falls::default());
        let camera =
            Camera { eye: Vec3::new(2.0, 7.0, 34.0), target: Vec3::Y * 3.0, fov_y: 0.9, near: 0.1 };
        let view = View { time: 20.0, detail: Simplification::DEFAULT, ..View::new(camera) };
        let mut shots = Vec::new();
        for most in [1 << 20, 40_000, 0] {
            forest.quads = renderer.quads.hanging(&device, &forest, most);
            let mut encoder = device.create_command_encoder(&Default::default());
            let target =
                Target { canvas: &canvas, picture: &picture.create_view(&Default::default()) };
            renderer.render(&queue, &mut encoder, &profiler, &forest, &view, target);
            let capture = Capture::encode(&device, &mut encoder, &picture);
            queue.submit([encoder.finish()]);
            capture.map();
            let quads = forest.quads.as_ref().map_or(0, |quads| {
                let words = windfall_testing::read(&device, &queue, &quads.buffers.arguments);
                let words: Vec<u32> = bytemuck::pod_collect_to_vec(&words);
                let draws = words[..5 * quads.buffers.draws as usize].chunks(5);
                draws.map(|draw| draw[0] / 6).sum::<u32>()
            });
            device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
            shots.push((quads, capture.take().unwrap().unwrap()));
        }
        let [(all, with), (some, partly), (none, without)] = &shots[..] else { unreachable!() };
        assert!(*all > 20_000 && (1..=40_000).contains(some) && *none == 0, "{all} {some} {none}");
        for picture in [with, partly] {
            let apart = picture.iter().zip(without).map(|(&a, &b)| u64::from(a.abs_diff(b)));
            let mean = apart.clone().sum::<u64>() as f64 / without.len() as f64;
            // Radiance has nine bits there, and eleven in the target.
            assert!(mean < 0.1, "pictures differ by {mean} of 255, at most {:?}", apart.max());
        }
    }
}
