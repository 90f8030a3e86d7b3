//! What a forest needs so that its leaves can fall: tables, streams and slots on the GPU.
//!
//! The leaves of one shape on one tree, in shed order, are a *stream*. At any time the detached ones
//! are a prefix of it, and the last `keep` of those have a *slot* each: entry `j` is in slot
//! `j % keep`. A slot has all that the pose of its leaf needs while it flies, or while it lies (32 bytes):
//! when the leaf will land is searched for once. Slots of leaves that detach are filled as they do; where
//! time runs backwards all are filled anew, so that any time gives the same picture as playing up to it.

use crate::events::{DetachEvent, Thrown};
use crate::listed::table_view;
use crate::model::GpuModel;
use crate::pass::GpuOcclusion;
use crate::renderer::Renderer;
use crate::shared::{FallFrame, LeafRecord, LooseLeaf, Model, Stream};
use crate::strategy::{Elimination, Strategy};
use crate::view::View;
use bytemuck::{Pod, Zeroable};
use glam::{Quat, UVec4, Vec2, Vec3, Vec4};
use half::f16;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use wgpu::util::DeviceExt;
use windfall_core::foliage::LeafShape;
use windfall_core::forest::{Forest, Frustum};
use windfall_core::path::{FallSettings, Flight, PathSet, PathTables, Variation};
use windfall_core::shed::Shedding;
use windfall_core::tree::Tree;
use windfall_core::wind::Wind;

/// What is bound where there is nothing: as large as the largest element.
pub(crate) const EMPTY: &[u8] = &[0; size_of::<Model>()];

/// Threads of a workgroup.
pub(crate) const THREADS: u32 = 64;

/// Slots of a workgroup that poses them.
pub(crate) const GROUP: u32 = 256;
const _: () = assert!(GROUP == 4 * THREADS, "`pose` has four slots a thread");

/// Words after the indirect arguments that count leaves (`shaders/falls.wgsl`).
pub(crate) const TALLIES: usize = 12;

/// Distance from the camera within which leaves in the air cast shadows, metres.
const LOOSE_SHADOWS: f32 = 60.0;

/// How leaves fall in a forest.
#[derive(Debug, Clone)]
pub struct Falls {
    /// The paths.
    pub paths: PathSet,
    /// For each tree model the group of paths that its leaves fall by; models beyond the list use
    /// the first group.
    pub groups: Vec<u32>,
    /// When leaves detach.
    pub shedding: Shedding,
    /// What carries them.
    pub wind: Wind,
    /// How falls on the same path differ.
    pub variation: Variation,
    /// Start and end of falls.
    pub settings: FallSettings,
    /// Most leaves in the air and on the ground together: where there are more, those that have
    /// lain longest vanish. 68 bytes of device memory each, in buffers of 32, 32 and 4: the device's
    /// [`wgpu::Limits::max_storage_buffer_binding_size`] bounds it, at 4,194,304 where that is 128 MiB.
    /// Default 1,000,000.
    pub capacity: u32,
    /// Where poses are computed.
    pub strategy: Strategy,
    /// When landed leaves become static geometry.
    pub elimination: Elimination,
    /// Whether leaves in the air that are not seen are skipped (VB 5): one that showed fewer than
    /// three pixels is not drawn in the next three frames, then tested again; of those that are seen, a
    /// third is tested in each frame. What shadows they cast stays. Default false.
    ///
    /// The one thing that carries something from frame to frame that is not a function of scene, seed
    /// and time: a leaf that comes into sight may appear up to three frames late, and one that is too
    /// small to show three pixels comes and goes. Draw the forest by one camera alone. It needs a
    /// device with [`wgpu::DownlevelFlags::FRAGMENT_WRITABLE_STORAGE`], which all but OpenGL ES 3.0
    /// have, and 68 more bytes of device memory for each leaf of `capacity`. For the strategies without
    /// compute it is all leaves of the list of falling ones that are tested, landed ones included where
    /// [`Elimination`] leaves them there.
    pub leaf_occlusion: bool,
    /// Leaves that detach at a moment of their own, held beyond `capacity`. Those that
    /// [`Falls::check_events`] refuses are left out. Default none.
    pub events: Vec<DetachEvent>,
}

impl Default for Falls {
    fn default() -> Self {
        Self {
            paths: PathSet::builtin(),
            groups: Vec::new(),
            shedding: Shedding::default(),
            wind: Wind::new(1.2, 0.6, 0.6, 1),
            variation: Variation::default(),
            settings: FallSettings::default(),
            capacity: 1_000_000,
            strategy: Strategy::default(),
            elimination: Elimination::default(),
            leaf_occlusion: false,
            events: Vec::new(),
        }
    }
}

impl Falls {
    /// Device memory of the state of a leaf in the air or on the ground with [`Strategy::Compute`], bytes: what
    /// lasts from frame to frame, two vectors a slot.
    pub const STATE_BYTES: u64 = 32;

    /// A still forest: no leaf ever falls.
    pub fn none() -> Self {
        Self { shedding: Shedding::never(), capacity: 0, ..Self::default() }
    }

    /// The group of paths for a tree: that of its name, where the paths have one.
    pub fn group_for(&self, tree: &Tree) -> u32 {
        self.paths.group(&tree.name).unwrap_or(0)
    }
}

/// A vertex of a leaf shape: 16 bytes.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct ShapeVertex {
    position: [f16; 4],
    normal: [i8; 4],
    uv: [f16; 2],
}

impl ShapeVertex {
    pub const LAYOUT: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
        array_stride: size_of::<Self>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &Self::ATTRIBUTES,
    };

    pub const ATTRIBUTES: [wgpu::VertexAttribute; 3] =
        wgpu::vertex_attr_array![0 => Float16x4, 1 => Snorm8x4, 2 => Float16x2];

    pub fn new(shape: &LeafShape, i: usize) -> Self {
        Self {
            position: shape.positions[i].extend(0.0).to_array().map(f16::from_f32),
            normal: crate::model::snorm(shape.normals[i]),
            uv: shape.uvs[i].to_array().map(f16::from_f32),
        }
    }

    /// As two vectors of a table: place and `u`, normal and `v`, as precise as the vertex itself.
    pub fn texels(&self) -> [UVec4; 2] {
        let [x, y, z, _] = self.position.map(f16::to_f32);
        let [u, v] = self.uv.map(f16::to_f32);
        let [nx, ny, nz, _] = self.normal.map(|n| f32::from(n) / 127.0);
        [words(Vec4::new(x, y, z, u)), words(Vec4::new(nx, ny, nz, v))]
    }
}

/// The vertices and indices of a leaf shape.
pub(crate) struct ShapeBuffers {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    pub index_count: u32,
}

impl ShapeBuffers {
    pub fn new(device: &wgpu::Device, shape: &LeafShape) -> Self {
        let init = |contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("leaf shape"),
                contents,
                usage,
            })
        };
        let vertices: Vec<ShapeVertex> =
            (0..shape.positions.len()).map(|i| ShapeVertex::new(shape, i)).collect();
        Self {
            vertices: init(bytemuck::cast_slice(&vertices), wgpu::BufferUsages::VERTEX),
            indices: init(bytemuck::cast_slice(&shape.indices), wgpu::BufferUsages::INDEX),
            index_count: shape.indices.len() as u32,
        }
    }

    pub fn set(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
    }
}

/// One draw: the loose leaves of one shape of one model.
pub(crate) struct Bin {
    pub model: usize,
    pub shape: ShapeBuffers,
    /// The shape in two triangles, for leaves of a few pixels.
    pub small: Option<ShapeBuffers>,
    /// First of its slots, and how many.
    pub first: u32,
    pub count: u32,
}

impl Bin {
    pub fn new(device: &wgpu::Device, trees: &[Tree], bin: &PlannedBin) -> Self {
        Self {
            model: bin.model,
            shape: ShapeBuffers::new(device, &trees[bin.model].foliage.shapes[bin.shape]),
            small: bin.simple.as_ref().map(|shape| ShapeBuffers::new(device, shape)),
            first: bin.first,
            count: bin.count,
        }
    }
}

/// Lists of leaves that are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum List {
    /// All, but those of the others; small ones from its end.
    Plain = 0,
    /// Leaves that are tested for being seen. Like the next, with leaf occlusion alone.
    Tested = 1,
    /// Leaves that are skipped.
    Skipped = 2,
}

/// The falling and fallen leaves of a forest on the GPU.
pub(crate) struct GpuFalls {
    pub bins: Vec<Bin>,
    pub stream_count: u32,
    pub uniform: wgpu::Buffer,
    /// Lists of `slot_count` leaves each: see [`List`].
    pub drawn: wgpu::Buffer,
    pub counters: wgpu::Buffer,
    pub arguments: wgpu::Buffer,
    /// Indirect arguments of the search for landings, and of the poses of leaves that change.
    pub landings: wgpu::Buffer,
    pub bind_group: wgpu::BindGroup,
    pub frame: FallFrame,
    pub group_count: u32,
    pub occlusion: Option<GpuOcclusion>,
    /// Time and season that the slots are of, as bits: NaN at first.
    moment: AtomicU64,
}

impl GpuFalls {
    pub fn new(
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        renderer: &Renderer,
        trees: &[Tree],
        (gpu_models, models): (&[GpuModel], &[Model]),
        forest: &Forest,
        falls: &Falls,
        lists: &wgpu::Buffer,
    ) -> Self {
        let mut records = LeafRecords::new(trees);
        let mut plan = Plan::new(trees, &mut records, forest, falls);
        plan.simplify(gpu_models);
        let (tables, mut frame) = tables(falls, forest, models);
        frame.stream_count = plan.streams.len() as u32;
        frame.slot_count = plan.slot_count;
        frame.bin_count = plan.bins.len() as u32;
        frame.group_count = plan.groups.len() as u32;

        // A binding may not be smaller than one element.
        let storage = |label, contents: &[u8]| {
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
                usage: usage | wgpu::BufferUsages::STORAGE,
                mapped_at_creation: false,
            })
        };
        let slots = u64::from(plan.slot_count);
        let (leaf_lists, watched) = if falls.leaf_occlusion { (3, slots) } else { (1, 0) };
        let work_vectors = 4 * plan.streams.len() as u64 + slots / 4 + 1;
        // Fragments count in a binding of their own.
        let alignment = u64::from(device.limits().min_storage_buffer_offset_alignment.max(16));
        let sight_bytes = (work_vectors * 16).next_multiple_of(alignment);
        frame.sight_first = (sight_bytes / 16) as u32;
        let of_shaders = wgpu::BufferUsages::empty();
        let slot_buffer = empty("leaf slots", slots * Falls::STATE_BYTES, of_shaders);
        let work = empty("work on leaves", sight_bytes + watched * 4 + 16, of_shaders);
        let drawn = empty(
            "loose leaves",
            leaf_lists * slots * size_of::<LooseLeaf>() as u64,
            wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_SRC,
        );
        let words = 5 * (leaf_lists + 1) * plan.bins.len() as u64 + TALLIES as u64 + watched;
        let counters = empty(
            "leaf counters",
            words * 4,
            wgpu::BufferUsages::INDIRECT
                | wgpu::BufferUsages::VERTEX
                | wgpu::BufferUsages::COPY_DST
                | wgpu::BufferUsages::COPY_SRC,
        );
        let mut list = plan.groups.concat();
        list.extend_from_slice(&records.shed_lists);
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("fall"),
            size: size_of::<FallFrame>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let tables = table_view(device, queue, tables);
        let buffers = [
            &uniform,
            &storage("streams", bytemuck::cast_slice(&plan.streams)),
            &storage("shed lists", bytemuck::cast_slice(&list)),
            &storage("leaf records", bytemuck::cast_slice(&records.records)),
            &storage("models", bytemuck::cast_slice(models)),
            &slot_buffer,
            &drawn,
            &counters,
            lists,
            &work,
        ];
        let mut resources: Vec<_> = buffers.iter().map(|b| b.as_entire_binding()).collect();
        resources.insert(1, wgpu::BindingResource::TextureView(&tables));
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("falls"),
            layout: &renderer.falls.layout,
            entries: &entries,
        });
        let bins: Vec<Bin> = plan.bins.iter().map(|bin| Bin::new(device, trees, bin)).collect();
        let draws: Vec<u32> = plan
            .bins
            .iter()
            .flat_map(|bin| {
                [trees[bin.model].foliage.shapes[bin.shape].indices.len() as u32, 0, 0, 0, 0]
            })
            .collect();
        let mut tallies = [0; TALLIES];
        tallies[6] = 1;
        let small: Vec<u32> = plan.bins.iter().flat_map(|bin| [6, 0, 0, 0, bin.count]).collect();
        let others = draws.repeat(leaf_lists as usize - 1);
        let arguments = [&draws[..], &small, &tallies, &others].concat();
        let arguments = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("empty draws"),
            contents: bytemuck::cast_slice(&arguments),
            usage: wgpu::BufferUsages::COPY_SRC,
        });
        // Groups as counted by the shader, 1, 1; twice.
        let landings = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("landings to find"),
            contents: bytemuck::cast_slice(&[0u32, 1, 1, 0, 1, 1]),
            usage: wgpu::BufferUsages::INDIRECT | wgpu::BufferUsages::COPY_DST,
        });
        Self {
            landings,
            bins,
            stream_count: plan.streams.len() as u32,
            uniform,
            drawn,
            occlusion: falls.leaf_occlusion.then(|| {
                let sights = wgpu::BufferBinding {
                    buffer: &work,
                    offset: sight_bytes,
                    size: std::num::NonZero::new(watched * 4 + 16),
                };
                renderer.falls.occlusion(device, renderer, &sights)
            }),
            counters,
            arguments,
            bind_group,
            group_count: frame.group_count,
            frame,
            moment: AtomicU64::new(u64::MAX),
        }
    }

    /// Copies the number of workgroups that `land` needs to its indirect arguments.
    pub fn count_landings(&self, encoder: &mut wgpu::CommandEncoder) {
        self.copy_count(encoder, 5, 0);
    }

    /// Copies the number of workgroups that `change` needs to its indirect arguments.
    pub fn count_changes(&self, encoder: &mut wgpu::CommandEncoder) {
        self.copy_count(encoder, 8, 12);
    }

    fn copy_count(&self, encoder: &mut wgpu::CommandEncoder, tally: u64, to: u64) {
        let from = self.tallies_offset() + tally * 4;
        encoder.copy_buffer_to_buffer(&self.counters, from, &self.landings, to, 4);
    }

    /// Where a list's draws have their indirect arguments among the counters, bytes.
    pub fn arguments_of(&self, list: List, bin: usize) -> u64 {
        let bins = self.bins.len() as u64;
        let first = match list {
            List::Plain => 0,
            _ => 5 * bins * (list as u64 + 1) + TALLIES as u64,
        };
        (first + 5 * bin as u64) * 4
    }

    /// A list's leaves of a bin.
    pub fn leaves_of(&self, list: List, bin: &Bin) -> wgpu::BufferSlice<'_> {
        let size = size_of::<LooseLeaf>() as u64;
        let first = u64::from(self.frame.slot_count) * list as u64 + u64::from(bin.first);
        self.drawn.slice(first * size..(first + u64::from(bin.count)) * size)
    }

    /// Where the tallies of tested and of skipped leaves are among the counters, bytes.
    pub fn sight_tallies(&self) -> u64 {
        self.tallies_offset() + 40
    }

    /// Where the tallies are among the counters, bytes.
    pub fn tallies_offset(&self) -> u64 {
        10 * self.bins.len() as u64 * 4
    }

    /// Where the draw of a bin's small leaves has its indirect arguments, bytes.
    pub fn small_arguments(&self, bin: usize) -> u64 {
        5 * (self.bins.len() + bin) as u64 * 4
    }

    /// For each leaf of a bin that is tested its slot.
    pub fn tested_slots(&self, bin: &Bin) -> wgpu::BufferSlice<'_> {
        let first = 20 * self.bins.len() as u64 + TALLIES as u64 + u64::from(bin.first);
        self.counters.slice(first * 4..(first + u64::from(bin.count)) * 4)
    }

    /// The uniforms of a moment.
    pub fn frame(&self, frustum: &Frustum, view: &View) -> FallFrame {
        let (time, season) = (view.time.to_bits(), view.season.to_bits());
        let now = u64::from(time) << 32 | u64::from(season);
        let before = self.moment.swap(now, Ordering::Relaxed);
        let forward = view.time >= f32::from_bits((before >> 32) as u32);
        FallFrame {
            restart: u32::from(!forward),
            recolor: u32::from(forward && before as u32 != season),
            frustum: frustum.planes(),
            time: view.time,
            show: view.show as u32,
            shadow_reach: if view.shadows { LOOSE_SHADOWS } else { 0.0 },
            ..self.frame
        }
    }
}

/// The leaves of all models, and their shed order by shape.
pub(crate) struct LeafRecords {
    pub records: Vec<LeafRecord>,
    /// For each model the index of its first record.
    pub first: Vec<u32>,
    pub shed_lists: Vec<u32>,
    /// For each model and shape, where its shed list begins and how long it is. [`Plan::new`] adds
    /// lists of its own.
    pub lists: Vec<Vec<(u32, u32)>>,
}

impl LeafRecords {
    pub fn new(trees: &[Tree]) -> Self {
        let mut out = Self {
            records: Vec::new(),
            first: Vec::new(),
            shed_lists: Vec::new(),
            lists: Vec::new(),
        };
        for tree in trees {
            let foliage = &tree.foliage;
            out.first.push(out.records.len() as u32);
            out.records.extend(foliage.leaves.iter().map(|leaf| {
                let [orientation_xy, orientation_zw] = pack_rotation(leaf.orientation);
                let bent = octahedral(leaf.bent_normal);
                LeafRecord {
                    center: leaf.center,
                    scale: leaf.scale,
                    orientation_xy,
                    orientation_zw,
                    rank: leaf.shed_rank,
                    look: u32::from_le_bytes([
                        leaf.material as u8,
                        (leaf.ambient.clamp(0.0, 1.0) * 255.0).round() as u8,
                        snorm8(bent.x),
                        snorm8(bent.y),
                    ]),
                }
            }));
            let lists = (0..foliage.shapes.len() as u32).map(|shape| {
                let begin = out.shed_lists.len();
                out.shed_lists.extend(
                    foliage
                        .shed_order
                        .iter()
                        .filter(|&&leaf| foliage.leaves[leaf as usize].shape == shape),
                );
                (begin as u32, (out.shed_lists.len() - begin) as u32)
            });
            let lists = lists.collect();
            out.lists.push(lists);
        }
        out
    }

    /// The stream of a tree of which some leaves are thrown at these times, without them, and that
    /// of those leaves alone.
    fn split(&mut self, stream: &Stream, times: &BTreeMap<u32, f32>) -> [Stream; 2] {
        let (first, count) = (stream.list_first as usize, stream.list_count as usize);
        let list = self.shed_lists[first..first + count].to_vec();
        let (mut thrown, rest): (Vec<u32>, Vec<u32>) =
            list.into_iter().partition(|leaf| times.contains_key(leaf));
        if thrown.is_empty() {
            return [*stream, Stream { keep: 0, ..*stream }];
        }
        thrown.sort_by(|a, b| times[a].total_cmp(&times[b]).then(a.cmp(b)));
        let mut add = |leaves: &[u32]| {
            let first = self.shed_lists.len() as u32;
            self.shed_lists.extend(leaves);
            (first, leaves.len() as u32)
        };
        let (list_first, list_count) = add(&rest);
        let keep = stream.keep.min(list_count);
        let rest = Stream { list_first, list_count, keep, ..*stream };
        let (list_first, keep) = add(&thrown);
        add(&thrown.iter().map(|leaf| times[leaf].to_bits()).collect::<Vec<u32>>());
        [rest, Stream { list_first, list_count: keep, keep, thrown: 1, ..*stream }]
    }
}

impl Stream {
    /// A direction of the model in the world.
    pub(crate) fn turned(&self, v: Vec3) -> Vec3 {
        let (c, s) = (self.cos_yaw, self.sin_yaw);
        Vec3::new(c * v.x + s * v.z, v.y, c * v.z - s * v.x)
    }

    /// A place of the model in the world.
    pub(crate) fn place(&self, v: Vec3) -> Vec3 {
        self.position + self.turned(v) * self.scale
    }
}

pub(crate) struct PlannedBin {
    pub model: usize,
    pub shape: usize,
    pub first: u32,
    pub count: u32,
    /// Its shape in two triangles.
    pub simple: Option<LeafShape>,
}

/// Streams, bins and slots of a forest.
pub(crate) struct Plan {
    pub streams: Vec<Stream>,
    pub bins: Vec<PlannedBin>,
    /// For each workgroup of [`GROUP`] slots its stream, and the first of them there.
    pub groups: Vec<[u32; 2]>,
    pub slot_count: u32,
}

impl Plan {
    pub fn new(trees: &[Tree], records: &mut LeafRecords, forest: &Forest, falls: &Falls) -> Self {
        let mut plan =
            Self { streams: Vec::new(), bins: Vec::new(), groups: Vec::new(), slot_count: 0 };
        let leaves = |m: usize| trees[m].foliage.leaves.len() as u64;
        let total: u64 = forest.instances.iter().map(|i| leaves(i.model as usize)).sum();
        // Every stream keeps the same share of its leaves.
        let share = (f64::from(falls.capacity) / total.max(1) as f64).min(1.0);
        let thrown = Thrown::new(trees, forest, falls);
        for (model, tree) in trees.iter().enumerate() {
            for (shape, (list_first, list_count)) in
                records.lists[model].clone().into_iter().enumerate()
            {
                let keep = (f64::from(list_count) * share).ceil() as u32;
                let geometry = &tree.foliage.shapes[shape];
                let first = plan.slot_count;
                let bin = plan.bins.len() as u32;
                for (index, instance) in forest.instances.iter().enumerate() {
                    if instance.model as usize != model {
                        continue;
                    }
                    let leaf_count = tree.foliage.leaves.len() as u32;
                    let shed = falls.shedding.tree(instance, leaf_count, &falls.wind);
                    let (sin_yaw, cos_yaw) = instance.yaw.sin_cos();
                    let stream = Stream {
                        position: instance.position,
                        scale: instance.scale,
                        cos_yaw,
                        sin_yaw,
                        season_offset: instance.season_offset,
                        seed: instance.seed,
                        delay: shed.delay,
                        gust_phase: shed.gust_phase,
                        leaf_count,
                        model: model as u32,
                        list_first,
                        list_count,
                        slot_first: 0,
                        keep,
                        bin,
                        path_group: falls.groups.get(model).copied().unwrap_or(0),
                        leaf_first: records.first[model],
                        bin_first: first,
                        thickness: geometry.positions.iter().map(|p| p.y.abs()).fold(0.0, f32::max),
                        radius: geometry.radius(),
                        thrown: 0,
                        simple: 0,
                    };
                    if let Some(times) = thrown.of(index as u32) {
                        let [rest, thrown] = records.split(&stream, times);
                        plan.push(rest);
                        plan.push(thrown);
                    } else {
                        plan.push(stream);
                    }
                }
                if plan.slot_count > first {
                    plan.bins.push(PlannedBin {
                        model,
                        shape,
                        first,
                        count: plan.slot_count - first,
                        simple: None,
                    });
                }
            }
        }
        plan
    }

    /// Takes the models' shapes of two triangles. There are none on devices where a draw cannot begin in the
    /// middle of a list, as those of small leaves do.
    pub fn simplify(&mut self, models: &[GpuModel]) {
        for bin in &mut self.bins {
            let quads = models[bin.model].quads.as_ref();
            bin.simple = quads.map(|quads| quads.shapes[bin.shape].clone());
        }
        for stream in &mut self.streams {
            stream.simple = u32::from(self.bins[stream.bin as usize].simple.is_some());
        }
    }

    /// Adds a stream with its slots, unless it has none.
    fn push(&mut self, stream: Stream) {
        if stream.keep == 0 {
            return;
        }
        let index = self.streams.len() as u32;
        self.streams.push(Stream { slot_first: self.slot_count, ..stream });
        let firsts = (0..stream.keep).step_by(GROUP as usize);
        self.groups.extend(firsts.map(|first| [index, first]));
        self.slot_count += stream.keep;
    }
}

pub(crate) fn words(v: Vec4) -> UVec4 {
    UVec4::from_array(v.to_array().map(f32::to_bits))
}

/// Path tables and terrain as vectors (`shaders/shared/tables.wgsl`), and the frame's constants.
pub(crate) fn tables(falls: &Falls, forest: &Forest, models: &[Model]) -> (Vec<UVec4>, FallFrame) {
    let terrain = &forest.terrain;
    let mut frame = FallFrame::zeroed();
    let mut out = flights(falls, &mut frame);
    frame.ground_table = push_scalars(&mut out, terrain.heights());
    frame.model_table = out.len() as u32;
    for model in models {
        out.push(UVec4::new(model.palette_count, model.palette_spread.to_bits(), 0, 0));
        out.extend(model.palette.map(words));
    }

    for (gust, into) in falls.wind.gusts.iter().zip(&mut frame.gusts) {
        *into = Vec4::new(gust.amplitude.x, gust.amplitude.y, gust.cycles as f32, gust.phase);
    }
    frame.wind_mean = falls.wind.mean;
    frame.wind_travel = falls.wind.travel;
    frame.wind_slowness = falls.wind.slowness;
    frame.wind_fastest = falls.wind.fastest();
    let settings = &falls.settings;
    frame.wind_response = settings.wind_response;
    frame.soft_drop = settings.soft_drop;
    frame.soft_time = settings.soft_time;
    frame.settle_time = settings.settle_time;
    frame.settle_turn = settings.settle_turn;
    match &falls.variation {
        Variation::Paper => frame.paper_variation = 1,
        Variation::Hashed(bounds) => {
            (frame.scale_low, frame.scale_high) = (bounds.scale.start, bounds.scale.end);
            (frame.rate_low, frame.rate_high) = (bounds.rate.start, bounds.rate.end);
        }
    }
    frame.ground_side = terrain.side();
    frame.ground_cell = terrain.cell();
    frame.ground_highest = terrain.range().1;
    frame.ground_steepest = terrain.steepest();
    frame.shed_start = falls.shedding.start;
    frame.shed_duration = falls.shedding.duration;
    frame.shed_peak = falls.shedding.peak;
    frame.shed_burst = falls.shedding.burst;
    frame.gust_rate = Shedding::gust_rate(&falls.wind);
    (out, frame)
}

/// Four numbers a vector; returns where they begin.
fn push_scalars(out: &mut Vec<UVec4>, values: &[f32]) -> u32 {
    let first = out.len() as u32;
    out.extend(values.chunks(4).map(|c| {
        let mut v = [0.0; 4];
        v[..c.len()].copy_from_slice(c);
        words(Vec4::from(v))
    }));
    first
}

/// Samples, their lows, flights and groups (`shaders/shared/tables.wgsl`).
fn flights(falls: &Falls, frame: &mut FallFrame) -> Vec<UVec4> {
    let paths = falls.paths.tables();
    frame.path_grain = paths.grain;
    let mut out: Vec<UVec4> = Vec::new();
    let mut lows: Vec<f32> = Vec::new();
    let mut first_sample = vec![0; paths.joints.len()];
    for path in &paths.paths {
        for j in path.first_joint..path.first_joint + path.joint_count {
            let joint = &paths.joints[j as usize];
            let from = Vec3::from(paths.samples[PathTables::index(path, joint, joint.to)].position);
            first_sample[j as usize] = out.len() as u32;
            for i in 0..joint.from + 2 {
                let sample = &paths.samples[PathTables::index(path, joint, i)];
                let at = Vec3::from(sample.position) - from;
                let [x, y, z] = at.to_array().map(|v| (v / paths.grain).round() as i32 as u32);
                let [xy, zw] = pack_rotation(Quat::from_array(sample.orientation));
                out.push(UVec4::new(x << 11 | (y >> 11 & 0x7ff), z << 11 | (y & 0x7ff), xy, zw));
                lows.push(sample.low - from.y);
            }
        }
    }
    frame.low_table = push_scalars(&mut out, &lows);
    frame.flight_table = out.len() as u32;
    for flight in &paths.flights {
        let path = &paths.paths[flight.path as usize];
        let joint = &paths.joints[flight.joint as usize];
        let sample = |i| &paths.samples[PathTables::index(path, joint, i)];
        let [begin, to] = [flight.start, joint.to].map(|i| Vec3::from(sample(i).position));
        // A turn of which the sine is 0 would be divided by: next to it is near enough.
        let h = joint.half_turn + u32::from(joint.half_turn << 1 == 0);
        let (s, c) = (f64::from(h) * std::f64::consts::TAU / 4_294_967_296.0).sin_cos();
        let [x, y, z] = joint.lap.map(f64::from);
        let lap = [(x * c - z * s) / s, y, (z * c + x * s) / s].map(|v| v as f32);
        let first = first_sample[flight.joint as usize];
        let soft = soft_samples(paths, flight, &falls.settings).min(NEVER_SOFT_LEFT);
        out.push(UVec4::new(first, flight.start | soft << 20, joint.from, joint.to));
        out.push(words(Vec3::from(lap).extend(path.rate)));
        out.push(UVec4 { w: h, ..words((to - begin).extend(0.0)) });
        let lows = [sample(flight.start).low, sample(joint.from).low].map(|low| low - to.y);
        out.push(words(Vec4::new(lows[0], lows[1], path.fastest_down, path.fastest_along)));
    }
    frame.group_table = out.len() as u32;
    out.extend(paths.group_flights.iter().map(|g| UVec4::new(g.first, g.count, g.plain, 0)));
    out
}

/// As many samples: a flight is taken to be near its twig for ever.
const NEVER_SOFT_LEFT: u32 = 0xfff;

/// Samples after which a flight has dropped far enough to have left the twig's orientation behind.
fn soft_samples(paths: &PathTables, flight: &Flight, settings: &FallSettings) -> u32 {
    let path = &paths.paths[flight.path as usize];
    let joint = &paths.joints[flight.joint as usize];
    let low = |i| paths.samples[PathTables::index(path, joint, i)].low;
    let level = low(flight.start) - settings.soft_drop.max(0.0);
    let samples = (flight.start..=joint.from).position(|i| low(i) <= level);
    samples.map_or(NEVER_SOFT_LEFT, |n| n as u32)
}

pub(crate) fn pack_rotation(q: Quat) -> [u32; 2] {
    let [x, y, z, w] = q.to_array().map(snorm16);
    [x | y << 16, z | w << 16]
}

fn snorm16(v: f32) -> u32 {
    u32::from((v.clamp(-1.0, 1.0) * 32767.0).round() as i16 as u16)
}

pub(crate) fn snorm8(v: f32) -> u8 {
    (v.clamp(-1.0, 1.0) * 127.0).round() as i8 as u8
}

/// A unit vector as a point of the square -1..1; the twin is in `shaders/shared/season.wgsl`.
pub(crate) fn octahedral(n: Vec3) -> Vec2 {
    let p = Vec2::new(n.x, n.z) / (n.x.abs() + n.y.abs() + n.z.abs()).max(f32::MIN_POSITIVE);
    if n.y >= 0.0 {
        return p;
    }
    let sign = |v: f32| if v >= 0.0 { 1.0 } else { -1.0 };
    Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y))
}
