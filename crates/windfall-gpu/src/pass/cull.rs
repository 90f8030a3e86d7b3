//! Makes the lists of trees that are drawn: which, in which detail, and the arguments of their draws.

use super::hiz::{HiZ, Pyramid};
use super::{Shaders, compose};
use crate::cull::{AT_VERTICES, BLOCK, BUCKETS, LISTS, OCTAVE, TALLIES, Trees, WHOLE};
use crate::falls::EMPTY;
use crate::shared::{CullFrame, Model, TreeInstance};
use wgpu::util::DeviceExt;

pub(crate) struct Cull {
    layout: wgpu::BindGroupLayout,
    classify: wgpu::ComputePipeline,
    reclassify: wgpu::ComputePipeline,
    arrange: wgpu::ComputePipeline,
    place: wgpu::ComputePipeline,
}

/// The lists of one forest on the GPU.
pub(crate) struct GpuLists {
    pub uniform: wgpu::Buffer,
    /// Indirect arguments by list and draw, then the tallies.
    pub arguments: wgpu::Buffer,
    /// Trees by list and place: an instance-step vertex buffer.
    pub placed: wgpu::Buffer,
    group: wgpu::BindGroup,
    blocks: u32,
    models: u32,
    draws: u64,
}

impl Cull {
    pub fn new(shaders: &Shaders<'_>, hiz: &HiZ) -> Self {
        let device = shaders.device;
        let uniform = wgpu::BufferBindingType::Uniform;
        let storage = |read_only| wgpu::BufferBindingType::Storage { read_only };
        let types = [uniform; 2]
            .into_iter()
            .chain([storage(true); 3])
            .chain([storage(false); 4])
            .enumerate();
        let entries: Vec<wgpu::BindGroupLayoutEntry> = types
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
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("cull"),
            entries: &entries,
        });
        let constants = format!(
            "const BUCKETS: u32 = {BUCKETS}u;\nconst OCTAVE: f32 = {OCTAVE:?};\n\
             const LISTS: u32 = {LISTS}u;\nconst WHOLE: u32 = {WHOLE}u;\n\
             const AT_VERTICES: u32 = {AT_VERTICES}u;\n"
        );
        let source = compose(&[
            &constants,
            include_str!("../../shaders/shared/shed.wgsl"),
            include_str!("../../shaders/shared/simplify.wgsl"),
            include_str!("../../shaders/cull.wgsl"),
        ]);
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("cull"),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("cull"),
            bind_group_layouts: &[Some(shaders.frame_layout), Some(&layout), Some(&hiz.layout)],
            immediate_size: 0,
        });
        let pipeline = |entry| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        Self {
            classify: pipeline("classify"),
            reclassify: pipeline("reclassify"),
            arrange: pipeline("arrange"),
            place: pipeline("place"),
            layout,
        }
    }

    /// The uniforms of a forest's lists.
    pub fn uniform(device: &wgpu::Device) -> wgpu::Buffer {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("lists of trees"),
            size: size_of::<CullFrame>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    }

    /// The tables of a forest; `fall` are the uniforms of its falls.
    pub fn lists(
        &self,
        device: &wgpu::Device,
        trees: &Trees,
        models: &[Model],
        uniform: wgpu::Buffer,
        fall: &wgpu::Buffer,
    ) -> GpuLists {
        // A binding may not be smaller than one element.
        let init = |label, contents: &[u8]| {
            let contents = if contents.is_empty() { EMPTY } else { contents };
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some(label),
                contents,
                usage: wgpu::BufferUsages::STORAGE,
            })
        };
        let empty = |label, size: u64, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: size.max(EMPTY.len() as u64),
                usage: wgpu::BufferUsages::STORAGE | usage,
                mapped_at_creation: false,
            })
        };
        let parts: Vec<[u32; 4]> = trees
            .parts
            .iter()
            .map(|p| [p.buckets.0, p.buckets.1, p.indices.1, p.indices.0])
            .collect();
        let (lists, places) = (LISTS as u64, trees.records.len() as u64);
        let (blocks, draws) = (places / u64::from(BLOCK), trees.parts.len() as u64);
        let buckets = (blocks + trees.crowns.len() as u64) * u64::from(BUCKETS);
        let none = wgpu::BufferUsages::empty();
        let arguments = empty(
            "tree draws",
            (lists * draws * 5 + TALLIES) * 4,
            wgpu::BufferUsages::INDIRECT
                | wgpu::BufferUsages::COPY_DST
                | wgpu::BufferUsages::COPY_SRC,
        );
        let placed = empty(
            "trees to draw",
            lists * places * size_of::<TreeInstance>() as u64,
            wgpu::BufferUsages::VERTEX
                | wgpu::BufferUsages::COPY_DST
                | wgpu::BufferUsages::COPY_SRC,
        );
        let buffers = [
            &uniform,
            fall,
            &init("trees", bytemuck::cast_slice(&trees.records)),
            &init("models", bytemuck::cast_slice(models)),
            &init("parts", bytemuck::cast_slice(&parts)),
            &empty("tree buckets", lists * places * 4, none),
            &empty("trees of buckets", lists * buckets * 4, none),
            &arguments,
            &placed,
        ];
        let entries: Vec<wgpu::BindGroupEntry<'_>> = buffers
            .iter()
            .enumerate()
            .map(|(i, buffer)| wgpu::BindGroupEntry {
                binding: i as u32,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("cull"),
            layout: &self.layout,
            entries: &entries,
        });
        GpuLists {
            uniform,
            arguments,
            placed,
            group,
            blocks: blocks as u32,
            models: trees.crowns.len() as u32,
            draws,
        }
    }

    /// Makes the lists of the first `views` of [`CullFrame::lists`].
    pub fn make(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        gpu: &GpuLists,
        pyramid: &Pyramid,
        views: u32,
    ) {
        self.run(pass, gpu, pyramid, &self.classify, views);
    }

    /// Makes the lists of the view anew, of the trees that the pyramid of the frame before hid and that
    /// of this frame does not. For a [`CullFrame::view_count`] of 1.
    pub fn make_hidden(&self, pass: &mut wgpu::ComputePass<'_>, gpu: &GpuLists, pyramid: &Pyramid) {
        self.run(pass, gpu, pyramid, &self.reclassify, 1);
    }

    fn run(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        gpu: &GpuLists,
        pyramid: &Pyramid,
        classify: &wgpu::ComputePipeline,
        views: u32,
    ) {
        let lists = 2 * views;
        if gpu.blocks == 0 {
            return;
        }
        pass.set_bind_group(1, &gpu.group, &[]);
        pass.set_bind_group(2, &pyramid.group, &[]);
        pass.set_pipeline(classify);
        pass.dispatch_workgroups(gpu.blocks, lists, 1);
        pass.set_pipeline(&self.arrange);
        pass.dispatch_workgroups(gpu.models, lists, 1);
        pass.set_pipeline(&self.place);
        pass.dispatch_workgroups(gpu.blocks, lists, 1);
    }
}

impl GpuLists {
    /// Where the tallies are in the arguments, bytes.
    pub fn tallies_offset(&self) -> u64 {
        LISTS as u64 * self.draws * 20
    }
}
