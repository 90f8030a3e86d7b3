//! Leaves in the air and on the ground, by compute: where they land, where they are, their draws.

use super::{Shaders, compose, draw::Draw};
use crate::falls::{GROUP, GpuFalls, ShapeVertex};
use crate::forest::GpuForest;
use crate::shared::LooseLeaf;

pub(crate) struct Falls {
    pub layout: wgpu::BindGroupLayout,
    pub detach_layout: wgpu::BindGroupLayout,
    detach: wgpu::ComputePipeline,
    windows: wgpu::ComputePipeline,
    land: wgpu::ComputePipeline,
    pose: wgpu::ComputePipeline,
    solid: wgpu::RenderPipeline,
    masked: wgpu::RenderPipeline,
}

const SHARED: [&str; 4] = [
    include_str!("../../shaders/shared/tables.wgsl"),
    include_str!("../../shaders/shared/shed.wgsl"),
    include_str!("../../shaders/shared/pose.wgsl"),
    include_str!("../../shaders/shared/loose.wgsl"),
];

fn layout(device: &wgpu::Device, label: &str, writable: &[bool]) -> wgpu::BindGroupLayout {
    // The uniforms come first.
    let entries: Vec<wgpu::BindGroupLayoutEntry> =
        std::iter::once(wgpu::BufferBindingType::Uniform)
            .chain(writable.iter().map(|w| wgpu::BufferBindingType::Storage { read_only: !w }))
            .enumerate()
            .map(|(i, ty)| wgpu::BindGroupLayoutEntry {
                binding: i as u32,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Buffer {
                    ty,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            })
            .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some(label),
        entries: &entries,
    })
}

impl Falls {
    pub fn new(shaders: &Shaders<'_>, part_layout: &wgpu::BindGroupLayout) -> Self {
        let device = shaders.device;
        let layout_falls =
            layout(device, "falls", &[false, false, false, false, false, true, true, true]);
        let detach_layout = layout(device, "detach", &[true]);
        let compute = |label: &str, source: &str, shared: &[&str], group: &_| {
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl(compose(&[shared, &[source]].concat()).into()),
            });
            let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(label),
                bind_group_layouts: &[Some(shaders.frame_layout), Some(group)],
                immediate_size: 0,
            });
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(label),
                layout: Some(&layout),
                module: &module,
                entry_point: Some(label),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        let falls = include_str!("../../shaders/falls.wgsl");
        let detach = include_str!("../../shaders/detach.wgsl");
        let leaf = wgpu::VertexBufferLayout {
            array_stride: size_of::<LooseLeaf>() as u64,
            step_mode: wgpu::VertexStepMode::Instance,
            attributes: &wgpu::vertex_attr_array![
                3 => Float32x4, 4 => Snorm16x4, 5 => Unorm8x4, 6 => Uint32
            ],
        };
        let draw = |label, fragment, alpha_to_coverage| {
            shaders.pipeline(&Draw {
                label,
                source: include_str!("../../shaders/leaves.wgsl"),
                groups: &[part_layout],
                buffers: &[ShapeVertex::LAYOUT, leaf.clone()],
                cull: None,
                vertex: "loose",
                fragment,
                alpha_to_coverage,
                target: None,
            })
        };
        Self {
            detach: compute("detach", detach, &SHARED[1..2], &detach_layout),
            windows: compute("windows", falls, &SHARED, &layout_falls),
            land: compute("land", falls, &SHARED, &layout_falls),
            pose: compute("pose", falls, &SHARED, &layout_falls),
            solid: draw("loose leaves", "solid", false),
            masked: draw("masked loose leaves", "masked", true),
            layout: layout_falls,
            detach_layout,
        }
    }

    /// Counts the leaves that have left the visible trees.
    pub fn detach(&self, pass: &mut wgpu::ComputePass<'_>, group: &wgpu::BindGroup, visible: u32) {
        pass.set_pipeline(&self.detach);
        pass.set_bind_group(1, group, &[]);
        pass.dispatch_workgroups(visible.div_ceil(GROUP), 1, 1);
    }

    /// Finds landings of newly detached leaves.
    pub fn land(&self, pass: &mut wgpu::ComputePass<'_>, falls: &GpuFalls) {
        pass.set_bind_group(1, &falls.bind_group, &[]);
        pass.set_pipeline(&self.windows);
        pass.dispatch_workgroups(falls.stream_count.div_ceil(GROUP), 1, 1);
        pass.set_pipeline(&self.land);
        pass.dispatch_workgroups(falls.slot_count.div_ceil(GROUP), 1, 1);
    }

    /// Poses the loose leaves and gathers those in view.
    pub fn pose(&self, pass: &mut wgpu::ComputePass<'_>, falls: &GpuFalls) {
        pass.set_bind_group(1, &falls.bind_group, &[]);
        pass.set_pipeline(&self.pose);
        pass.dispatch_workgroups(falls.slot_count.div_ceil(GROUP), 1, 1);
    }

    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, forest: &GpuForest) {
        let falls = &forest.falls;
        for (i, bin) in falls.bins.iter().enumerate() {
            let part = &forest.models[bin.model].leaves;
            pass.set_pipeline(if part.masked { &self.masked } else { &self.solid });
            pass.set_bind_group(1, &part.bind_group, &[]);
            pass.set_vertex_buffer(0, bin.vertices.slice(..));
            let size = size_of::<LooseLeaf>() as u64;
            let first = u64::from(bin.first) * size;
            pass.set_vertex_buffer(
                1,
                falls.drawn.slice(first..first + u64::from(bin.count) * size),
            );
            pass.set_index_buffer(bin.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed_indirect(&falls.counters, i as u64 * 20);
        }
    }
}
