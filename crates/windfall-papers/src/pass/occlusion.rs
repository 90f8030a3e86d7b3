//! Leaf occlusion (VB 5): leaves in the air that are not seen are skipped for some frames.
//!
//! Tested leaves are drawn once more over the finished picture, into nothing: fragments compare their depth to the
//! picture's and count pixels in the state of their leaf. The next frame reads there what to do with the leaf.

use super::{
    PassLayouts, Pipelines, VertexInput, cpu, draw_active, fill_pipeline, fragment, loaded,
    numbers, picture_target, vertex, vertex_buffer,
};
use crate::arena::BLOCK_SIZE;
use crate::buffers::{LeafBuffers, rows, texture};
use crate::options::{LeafOcclusion, PassOptions, Strategy};
use std::ops::Range;
use windfall_gpu::internals::layouts::{self, WRITE, buffer, entry};
use windfall_gpu::internals::{Module, Shaders, compose};
use windfall_gpu::{Recording, SceneTextures};

/// Decides what a frame does with each active leaf.
pub const UPDATE: Module = Module {
    name: "published-update-visibility",
    source: |settings| {
        let numbers = numbers();
        let text =
            [include_str!("../wgsl/visibility.wgsl"), include_str!("update_visibility.wgsl")];
        compose(settings, &[&numbers, text[0], text[1]])
    },
};

/// What is done with each leaf.
const ACTIONS: wgpu::TextureFormat = wgpu::TextureFormat::R8Uint;
/// Bytes behind the states: the numbers of tested and of skipped leaves.
pub const TALLY_BYTES: u64 = 8;

/// Pipelines of leaf occlusion for one strategy.
pub struct OcclusionPasses {
    update: wgpu::RenderPipeline,
    update_layout: wgpu::BindGroupLayout,
    drawn: Pipelines,
    /// Shows skipped leaves in the view of occlusion.
    skipped: Pipelines,
    drawn_layout: wgpu::BindGroupLayout,
    count: Pipelines,
    count_layout: wgpu::BindGroupLayout,
    /// Bound as group 2 if the strategy does not use it.
    nothing: Option<wgpu::BindGroup>,
}

/// The visibility states of a list of active leaves, and room for as many leaves as the list has.
pub struct Visibility {
    /// A state per leaf, then the tallies.
    pub states: wgpu::Buffer,
    actions: wgpu::TextureView,
    update_group: wgpu::BindGroup,
    drawn_group: wgpu::BindGroup,
    /// For the depth of the picture that was drawn last.
    count_group: Option<(wgpu::TextureView, wgpu::BindGroup)>,
}

impl OcclusionPasses {
    pub(super) fn new(
        shaders: &Shaders<'_>,
        layouts: &PassLayouts,
        (passes, options): (PassOptions, LeafOcclusion),
        input: &VertexInput<'_>,
        constants: &[(&str, f64)],
    ) -> Self {
        let device = shaders.device;
        let module = match passes.strategy {
            Strategy::Vertex if passes.one_dimensional() => &vertex::OCCLUSION_FROM_TEXTURES,
            Strategy::Vertex => &vertex::OCCLUSION,
            Strategy::Fragment => &fragment::OCCLUSION,
            Strategy::VertexBuffer => &vertex_buffer::OCCLUSION,
            Strategy::Cpu => &cpu::OCCLUSION,
        };
        let flat = wgpu::TextureViewDimension::D2;
        let actions = layouts::texture(wgpu::TextureSampleType::Uint, flat);
        let depth = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Depth,
            view_dimension: flat,
            multisampled: true,
        };
        let (of_vertex, of_fragment) = (wgpu::ShaderStages::VERTEX, wgpu::ShaderStages::FRAGMENT);
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries,
            })
        };
        let update_layout = layout("leaf states", &[entry(0, of_fragment, buffer(WRITE))]);
        let drawn_layout = layout("actions on leaves", &[entry(0, of_vertex, actions)]);
        let count_layout = layout(
            "counted pixels",
            &[
                entry(0, of_vertex, actions),
                entry(1, of_fragment, buffer(WRITE)),
                entry(2, of_fragment, depth),
            ],
        );
        let with = |vertex, layout| {
            let mut groups = input.groups.clone();
            groups.resize(3, &layouts.nothing);
            groups.push(layout);
            VertexInput { module, vertex, groups, buffers: input.buffers.clone() }
        };
        let drawn = with("drawn", &drawn_layout);
        let colors = [Some("solid"), Some("masked")];
        let target = picture_target();
        let drawing = |target, skipped: bool| {
            let constants = [constants, &[("skipped", f64::from(u8::from(skipped)))]].concat();
            Pipelines::new(shaders, &drawn, colors, target, &constants)
        };
        let rules = [
            ("one_in", f64::from(options.one_in)),
            ("skipped_frames", f64::from(options.skip)),
            ("enough_pixels", f64::from(options.pixels)),
        ];
        let counts = [Some("count_solid"), Some("count_masked")];
        Self {
            update: fill_pipeline(
                shaders,
                (&UPDATE, "update"),
                &[&layouts.frame, &update_layout],
                &[],
                &[ACTIONS],
                &rules,
            ),
            drawn: drawing(target, false),
            skipped: drawing(target.front(), true),
            count: Pipelines::new(
                shaders,
                &with("tested", &count_layout),
                counts,
                target.stores(),
                &[constants, &rules].concat(),
            ),
            nothing: (input.groups.len() < 3)
                .then(|| layouts::group(device, "nothing", &layouts.nothing, &[])),
            update_layout,
            drawn_layout,
            count_layout,
        }
    }

    /// Room for rows of active leaves; nothing is known of any leaf.
    pub fn visibility(&self, device: &wgpu::Device, rows: u32) -> Visibility {
        let states = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("leaf states"),
            size: u64::from(rows) * u64::from(BLOCK_SIZE) * 4 + TALLY_BYTES,
            usage: wgpu::BufferUsages::STORAGE
                | wgpu::BufferUsages::COPY_SRC
                | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
        let actions = texture(device, "actions on leaves", ACTIONS, (BLOCK_SIZE, rows), usage)
            .create_view(&wgpu::TextureViewDescriptor::default());
        let group = |layout, resource| layouts::group(device, "visibility", layout, &[resource]);
        Visibility {
            update_group: group(&self.update_layout, states.as_entire_binding()),
            drawn_group: group(&self.drawn_layout, wgpu::BindingResource::TextureView(&actions)),
            count_group: None,
            states,
            actions,
        }
    }

    /// Decides what the frame does with each active leaf.
    pub fn update(
        &self,
        recording: &mut Recording<'_>,
        frame: &wgpu::BindGroup,
        (leaves, visibility): (&LeafBuffers, &Visibility),
    ) {
        let list = &leaves.lists.active;
        let tallies = visibility.states.size() - TALLY_BYTES;
        recording.encoder.clear_buffer(&visibility.states, tallies, None);
        let targets = [Some(loaded(&visibility.actions))];
        let timing = recording.timing;
        timing.render_pass_into(recording.encoder, "update visibility", (&targets, None), |pass| {
            let pass = &mut *pass.pass;
            pass.set_pipeline(&self.update);
            pass.set_bind_group(0, frame, &[]);
            pass.set_bind_group(1, &visibility.update_group, &[]);
            let used = list.regions.iter().filter(|region| !region.items.is_empty());
            for (region, (first, count)) in used.zip(rows(list)) {
                // Leaves alone: the last row may be part empty.
                let last = region.items.len() as u32 - (count - 1) * BLOCK_SIZE;
                let (full, end) = (count - 1, first + count - 1);
                for (y, width, height) in [(first, BLOCK_SIZE, full), (end, last, 1)] {
                    if height > 0 {
                        pass.set_scissor_rect(0, y, width, height);
                        pass.draw(0..3, 0..1);
                    }
                }
            }
        });
    }

    /// Draws the active leaves that are not skipped.
    pub(super) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        leaves: &LeafBuffers,
        visibility: &Visibility,
    ) {
        pass.set_bind_group(3, &visibility.drawn_group, &[]);
        self.set_nothing(pass);
        draw_active(pass, leaves, &self.drawn);
    }

    fn set_nothing(&self, pass: &mut wgpu::RenderPass<'_>) {
        if let Some(nothing) = &self.nothing {
            pass.set_bind_group(2, nothing, &[]);
        }
    }

    /// Counts the visible pixels of tested leaves; `show` draws the skipped ones over the picture.
    pub fn count(
        &self,
        recording: &mut Recording<'_>,
        frame: &wgpu::BindGroup,
        (leaves, visibility): (&LeafBuffers, &Visibility),
        scene: &SceneTextures<'_>,
        show: bool,
    ) {
        let Some((_, count_group)) = &visibility.count_group else { return };
        let depth = Some(wgpu::RenderPassDepthStencilAttachment {
            view: scene.depth,
            depth_ops: None,
            stencil_ops: None,
        });
        let timing = recording.timing;
        timing.render_pass_into(recording.encoder, "count pixels", (&[], depth), |pass| {
            let pass = &mut *pass.pass;
            pass.set_bind_group(0, frame, &[]);
            pass.set_bind_group(3, count_group, &[]);
            self.set_nothing(pass);
            draw_active(pass, leaves, &self.count);
        });
        if !show {
            return;
        }
        let depth = Some(wgpu::RenderPassDepthStencilAttachment {
            view: scene.depth,
            depth_ops: None,
            stencil_ops: None,
        });
        let colors = [Some(loaded(scene.radiance))];
        timing.render_pass_into(recording.encoder, "skipped leaves", (&colors, depth), |pass| {
            let pass = &mut *pass.pass;
            pass.set_bind_group(0, frame, &[]);
            pass.set_bind_group(3, &visibility.drawn_group, &[]);
            self.set_nothing(pass);
            draw_active(pass, leaves, &self.skipped);
        });
    }
}

impl Visibility {
    /// Forgets a range of leaves: others have their indices now.
    pub fn forget(&self, queue: &wgpu::Queue, leaves: Range<u32>) {
        let unknown = vec![0u32; leaves.len()];
        let at = u64::from(leaves.start) * 4;
        queue.write_buffer(&self.states, at, bytemuck::cast_slice(&unknown));
    }

    /// Binds the depth of the picture that is drawn.
    pub fn bind_depth(
        &mut self,
        device: &wgpu::Device,
        passes: &OcclusionPasses,
        depth: &wgpu::TextureView,
    ) {
        if self.count_group.as_ref().is_some_and(|(of, _)| of == depth) {
            return;
        }
        let resources = [
            wgpu::BindingResource::TextureView(&self.actions),
            self.states.as_entire_binding(),
            wgpu::BindingResource::TextureView(depth),
        ];
        let group = layouts::group(device, "counted pixels", &passes.count_layout, &resources);
        self.count_group = Some((depth.clone(), group));
    }
}
