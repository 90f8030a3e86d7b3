//! Leaf occlusion (VB 5): leaves in the air that are not seen are skipped for some frames.
//!
//! Tested leaves are drawn once more over the finished picture, into nothing: fragments compare their
//! depth to what is there and count in a word of their leaf's. The next frame finds there what to do with
//! it: in the pose kernel, or in a fragment per leaf for the strategies without compute. All this is made
//! for a forest that wants it alone.

use super::draw::{Draw, DrawTarget};
use super::falls::{Falls, LEAF, draw_lists, kernel};
use super::fragment_falls::FragmentFalls;
use super::listed::{ListedPasses, Pipelines, Placing, draw_falling};
use super::vertex_buffer_falls::VertexBufferFalls;
use super::vertex_falls::VertexFalls;
use super::{Shaders, compose};
use crate::arena::{Arena, GRAIN};
use crate::falls::{List, ShapeVertex};
use crate::forest::GpuForest;
use crate::listed::{ListedFalls, leaf_rows};
use crate::model::GpuModel;
use crate::renderer::Renderer;
use crate::shared::FallingLeaf;
use crate::strategy::Strategy;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};
use wgpu_profiler::Scope;

const LEAVES: &str = include_str!("../../shaders/leaves.wgsl");
const SIGHT: &str = include_str!("../../shaders/shared/sight.wgsl");
const COUNT: &str = include_str!("../../shaders/leaf_occlusion.wgsl");
const DOINGS: wgpu::TextureFormat = wgpu::TextureFormat::R8Uint;

/// What counts pixels, and what shows skipped leaves in the view of occlusion.
pub(crate) struct Counter {
    count: Pipelines,
    skipped: Pipelines,
    layout: wgpu::BindGroupLayout,
    /// For the group that a strategy does not use.
    nothing: Option<wgpu::BindGroup>,
    /// For the depth of the canvas that was drawn on last.
    group: Mutex<Option<(wgpu::TextureView, wgpu::BindGroup)>>,
    device: wgpu::Device,
}

/// Leaf occlusion with compute.
pub(crate) struct GpuOcclusion {
    pub land: wgpu::ComputePipeline,
    pub pose: wgpu::ComputePipeline,
    pub change: wgpu::ComputePipeline,
    counter: Counter,
    sights: (wgpu::Buffer, u64, Option<wgpu::BufferSize>),
}

/// Leaf occlusion of leaves that the CPU lists.
pub(crate) struct ListedOcclusion {
    watch: wgpu::RenderPipeline,
    watch_layout: wgpu::BindGroupLayout,
    shown: Pipelines,
    shown_layout: wgpu::BindGroupLayout,
    counter: Counter,
    room: Room,
}

/// What is as large as the list.
struct Room {
    /// A word a leaf, then the tallies.
    sights: wgpu::Buffer,
    /// What is to be done with each leaf.
    doings: wgpu::TextureView,
    watch_group: wgpu::BindGroup,
    shown_group: wgpu::BindGroup,
}

fn entry(
    binding: u32,
    stages: wgpu::ShaderStages,
    ty: wgpu::BindingType,
) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry { binding, visibility: stages, ty, count: None }
}

fn words(binding: u32) -> wgpu::BindGroupLayoutEntry {
    let ty = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Storage { read_only: false },
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    entry(binding, wgpu::ShaderStages::FRAGMENT, ty)
}

fn texture(
    binding: u32,
    stages: wgpu::ShaderStages,
    sample_type: wgpu::TextureSampleType,
    multisampled: bool,
) -> wgpu::BindGroupLayoutEntry {
    let view_dimension = wgpu::TextureViewDimension::D2;
    entry(binding, stages, wgpu::BindingType::Texture { sample_type, view_dimension, multisampled })
}

fn doings(binding: u32) -> wgpu::BindGroupLayoutEntry {
    texture(binding, wgpu::ShaderStages::VERTEX, wgpu::TextureSampleType::Uint, false)
}

fn layout(
    device: &wgpu::Device,
    label: &str,
    entries: &[wgpu::BindGroupLayoutEntry],
) -> wgpu::BindGroupLayout {
    device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
}

fn group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resources: &[(u32, wgpu::BindingResource<'_>)],
) -> wgpu::BindGroup {
    let entries: Vec<_> = resources
        .iter()
        .map(|(binding, resource)| wgpu::BindGroupEntry {
            binding: *binding,
            resource: resource.clone(),
        })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("leaf occlusion"),
        layout,
        entries: &entries,
    })
}

fn count_layout(device: &wgpu::Device, listed: bool) -> wgpu::BindGroupLayout {
    let depth = wgpu::TextureSampleType::Depth;
    let mut entries = vec![words(1), texture(2, wgpu::ShaderStages::FRAGMENT, depth, true)];
    if listed {
        entries.push(doings(0));
    }
    layout(device, "counted leaves", &entries)
}

impl Counter {
    /// The bind group of the count: words of the leaves, and depth.
    fn set(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        depth: &wgpu::TextureView,
        sights: wgpu::BindingResource<'_>,
        doings: Option<&wgpu::TextureView>,
    ) {
        let mut last = self.group.lock().unwrap_or_else(PoisonError::into_inner);
        let of_depth = |(view, group): &(wgpu::TextureView, wgpu::BindGroup)| {
            (view == depth).then(|| group.clone())
        };
        let found = last.as_ref().and_then(of_depth).unwrap_or_else(|| {
            let mut resources = vec![(1, sights), (2, wgpu::BindingResource::TextureView(depth))];
            resources.extend(doings.map(|d| (0, wgpu::BindingResource::TextureView(d))));
            group(&self.device, &self.layout, &resources)
        });
        pass.set_bind_group(3, &found, &[]);
        *last = Some((depth.clone(), found));
        self.set_nothing(pass);
    }

    fn set_nothing(&self, pass: &mut wgpu::RenderPass<'_>) {
        if let Some(nothing) = &self.nothing {
            pass.set_bind_group(2, nothing, &[]);
        }
    }
}

impl Falls {
    /// What leaf occlusion needs; `sights` is a word for each slot.
    pub fn occlusion(
        &self,
        device: &wgpu::Device,
        renderer: &Renderer,
        sights: &wgpu::BufferBinding<'_>,
    ) -> GpuOcclusion {
        let shaders = &renderer.shaders(device);
        let count = count_layout(device, false);
        let nothing = layout(device, "nothing", &[]);
        let source =
            [LEAVES, SIGHT, COUNT, include_str!("../../shaders/compute_occlusion.wgsl")].join("\n");
        let part = &renderer.part_layout;
        let slot = wgpu::VertexBufferLayout {
            array_stride: 4,
            step_mode: wgpu::VertexStepMode::Instance,
            attributes: &wgpu::vertex_attr_array![7 => Uint32],
        };
        let (groups, buffers) = ([part, &nothing, &count], [ShapeVertex::LAYOUT, LEAF, slot]);
        let pipeline = |vertex, fragment, target| {
            let counts = target == DrawTarget::Stores;
            shaders.pipeline(&Draw {
                label: fragment,
                source: &source,
                groups: if counts { &groups } else { &groups[..1] },
                buffers: if counts { &buffers } else { &buffers[..2] },
                cull: None,
                vertex,
                fragment: Some(fragment),
                target,
                constants: &[],
            })
        };
        // Watched leaves are not drawn in two triangles.
        let pipelines = |vertex, [solid, masked]: [&'static str; 2], target| {
            let solid = pipeline(vertex, solid, target);
            Pipelines { small: solid.clone(), solid, masked: pipeline(vertex, masked, target) }
        };
        let kernel = |label| kernel(shaders, &self.layout, label, true);
        GpuOcclusion {
            land: kernel("land"),
            pose: kernel("pose"),
            change: kernel("change"),
            counter: Counter {
                count: pipelines(
                    "loose_counted",
                    ["count_solid", "count_masked"],
                    DrawTarget::Stores,
                ),
                skipped: pipelines("loose", ["solid", "masked"], DrawTarget::Front),
                nothing: Some(group(device, &nothing, &[])),
                layout: count,
                group: Mutex::default(),
                device: device.clone(),
            },
            sights: (sights.buffer.clone(), sights.offset, sights.size),
        }
    }
}

impl GpuOcclusion {
    pub fn count(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        forest: &GpuForest,
        depth: &wgpu::TextureView,
    ) {
        let (buffer, offset, size) = &self.sights;
        let sights = wgpu::BufferBinding { buffer, offset: *offset, size: *size };
        self.counter.set(pass, depth, wgpu::BindingResource::Buffer(sights), None);
        let pair = &self.counter.count;
        draw_lists(pass, forest, &[List::Tested], &pair.solid, &pair.masked);
    }

    /// Draws the leaves that are skipped over the picture.
    pub fn show_skipped(&self, pass: &mut wgpu::RenderPass<'_>, forest: &GpuForest) {
        let pair = &self.counter.skipped;
        draw_lists(pass, forest, &[List::Skipped], &pair.solid, &pair.masked);
    }
}

impl ListedPasses {
    /// What leaf occlusion needs, with room for rows of the list.
    pub fn occlusion(
        &self,
        device: &wgpu::Device,
        renderer: &Renderer,
        strategy: Strategy,
        rows: u32,
    ) -> ListedOcclusion {
        let shaders = &renderer.shaders(device);
        let part = &renderer.part_layout;
        let (placing, entries) = match strategy {
            Strategy::Vertex | Strategy::Compute => (
                VertexFalls::placing(part, &self.layouts),
                include_str!("../../shaders/vertex_occlusion.wgsl"),
            ),
            Strategy::Fragment => (
                FragmentFalls::placing(part, &self.layouts),
                include_str!("../../shaders/fragment_occlusion.wgsl"),
            ),
            Strategy::VertexBuffer => (
                VertexBufferFalls::placing(part),
                include_str!("../../shaders/vertex_buffer_occlusion.wgsl"),
            ),
        };
        let shown_layout = layout(device, "watched leaves", &[doings(0)]);
        let count = count_layout(device, true);
        let nothing = layout(device, "nothing", &[]);
        let looking = include_str!("../../shaders/listed_occlusion.wgsl");
        let source = [SIGHT, COUNT, looking, placing.source, entries].join("\n");
        let with = |vertex, layout| {
            let mut groups = placing.groups.clone();
            groups.resize(2, &nothing);
            groups.push(layout);
            Placing { source: &source, vertex, groups, buffers: placing.buffers.clone(), ..placing }
        };
        let watched = with("watched", &shown_layout);
        let colors = [Some("solid"), Some("masked")];
        let pair = |target, skipped| {
            watched.pipelines(shaders, colors, target, &[("skipped", f64::from(u8::from(skipped)))])
        };
        let counts = [Some("count_solid"), Some("count_masked")];
        let watch_layout = layout(device, "sights", &[words(0)]);
        ListedOcclusion {
            watch: watch_pipeline(shaders, &watch_layout),
            shown: pair(DrawTarget::Radiance, false),
            room: Room::new(device, &watch_layout, &shown_layout, rows),
            counter: Counter {
                count: with("tested", &count).pipelines(shaders, counts, DrawTarget::Stores, &[]),
                skipped: pair(DrawTarget::Front, true),
                nothing: (placing.groups.len() < 2).then(|| group(device, &nothing, &[])),
                layout: count,
                group: Mutex::default(),
                device: device.clone(),
            },
            watch_layout,
            shown_layout,
        }
    }
}

fn watch_pipeline(shaders: &Shaders<'_>, layout: &wgpu::BindGroupLayout) -> wgpu::RenderPipeline {
    let device = shaders.device;
    let source = include_str!("../../shaders/watch.wgsl");
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("watch"),
        source: wgpu::ShaderSource::Wgsl(compose(&[SIGHT, source]).into()),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("watch"),
        bind_group_layouts: &[Some(shaders.frame_layout), Some(layout)],
        immediate_size: 0,
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("watch"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("cover"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("watch"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(DOINGS.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Leaves tested and leaves skipped, bytes.
const TALLIES: u64 = 8;

impl Room {
    fn new(
        device: &wgpu::Device,
        watch_layout: &wgpu::BindGroupLayout,
        shown_layout: &wgpu::BindGroupLayout,
        rows: u32,
    ) -> Self {
        let usage = wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        let sights = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("sights"),
            size: u64::from(rows) * u64::from(GRAIN) * 4 + TALLIES,
            usage: wgpu::BufferUsages::STORAGE | usage,
            mapped_at_creation: false,
        });
        let doings = crate::listed::texture(
            device,
            "what is done with leaves",
            DOINGS,
            GRAIN,
            rows,
            wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        )
        .create_view(&wgpu::TextureViewDescriptor::default());
        let looked_up = wgpu::BindingResource::TextureView(&doings);
        Self {
            watch_group: group(device, watch_layout, &[(0, sights.as_entire_binding())]),
            shown_group: group(device, shown_layout, &[(0, looked_up)]),
            sights,
            doings,
        }
    }
}

impl ListedOcclusion {
    /// Makes room for rows of the list; nothing is known of any leaf.
    pub fn make_room(&mut self, device: &wgpu::Device, rows: u32) {
        self.room = Room::new(device, &self.watch_layout, &self.shown_layout, rows);
        *self.counter.group.get_mut().unwrap_or_else(PoisonError::into_inner) = None;
    }

    /// Other leaves are in these places.
    pub fn forget(&self, queue: &wgpu::Queue, places: Range<u32>) {
        let nothing = vec![0u32; places.len()];
        let bytes = bytemuck::cast_slice(&nothing);
        queue.write_buffer(&self.room.sights, u64::from(places.start) * 4, bytes);
    }

    /// Finds what is to be done with each leaf of the list, and writes how many are tested and skipped
    /// to `tallies`.
    pub fn watch(
        &self,
        scope: &mut Scope<'_, wgpu::CommandEncoder>,
        frame_group: &wgpu::BindGroup,
        list: &Arena<FallingLeaf>,
        (tallies, offset): (&wgpu::Buffer, u64),
    ) {
        let sights = &self.room.sights;
        let from = sights.size() - TALLIES;
        scope.recorder.clear_buffer(sights, from, None);
        {
            let mut pass = scope.scoped_render_pass(
                "watch",
                wgpu::RenderPassDescriptor {
                    label: Some("watch"),
                    color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                        view: &self.room.doings,
                        depth_slice: None,
                        resolve_target: None,
                        ops: wgpu::Operations {
                            load: wgpu::LoadOp::Load,
                            store: wgpu::StoreOp::Store,
                        },
                    })],
                    ..Default::default()
                },
            );
            pass.set_pipeline(&self.watch);
            pass.set_bind_group(0, frame_group, &[]);
            pass.set_bind_group(1, &self.room.watch_group, &[]);
            for (region, (first, rows)) in
                list.regions.iter().filter(|r| !r.items.is_empty()).zip(leaf_rows(list))
            {
                // Leaves alone: the last row need not be full.
                let last = region.items.len() as u32 - (rows - 1) * GRAIN;
                for (y, width, height) in [(first, GRAIN, rows - 1), (first + rows - 1, last, 1)] {
                    if height > 0 {
                        pass.set_scissor_rect(0, y, width, height);
                        pass.draw(0..3, 0..1);
                    }
                }
            }
        }
        scope.recorder.copy_buffer_to_buffer(sights, from, tallies, offset, TALLIES);
    }

    /// Sets what the leaves that are not skipped are drawn with, and returns the pipelines.
    pub fn set_shown(&self, pass: &mut wgpu::RenderPass<'_>) -> &Pipelines {
        pass.set_bind_group(3, &self.room.shown_group, &[]);
        self.counter.set_nothing(pass);
        &self.shown
    }

    pub fn count(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        models: &[GpuModel],
        falls: &ListedFalls,
        depth: &wgpu::TextureView,
    ) {
        let sights = self.room.sights.as_entire_binding();
        self.counter.set(pass, depth, sights, Some(&self.room.doings));
        draw_falling(pass, models, falls, &self.counter.count);
    }

    /// Draws the leaves that are skipped over the picture.
    pub fn show_skipped(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        models: &[GpuModel],
        falls: &ListedFalls,
    ) {
        self.set_shown(pass);
        draw_falling(pass, models, falls, &self.counter.skipped);
    }
}
