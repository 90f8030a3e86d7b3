//! How leaves fall, and the state of those that have left their twigs.
//!
//! The leaves of one shape on one tree, in shed order, are a *stream* (`super::streams`). At any time the
//! detached ones are a prefix of it, and the last `keep` of those have a *slot* each: entry `j` is in slot
//! `j % keep`. A slot has all that the pose of its leaf needs while it flies, or while it lies (32 bytes),
//! and the leaf as it was posed (32 bytes): when the leaf will land is searched for once. Slots of leaves
//! that detach are filled as they do; where time runs backwards all are filled anew, so that any time gives
//! the same picture as playing up to it. What slots hold is known to the GPU alone: a frame that was
//! recorded and never submitted has not happened.

use crate::base::constants::{DRAW_WORDS, TALLIES, VIEW_TALLIES, WINDOW};
use crate::base::layouts::{self, Layouts};
use crate::base::shared::{FallFrame, LooseLeaf, Model};
use crate::scene::events::Scripted;
use crate::scene::forest::ForestError;
use crate::scene::model::TreeModel;
use crate::scene::streams::Streams;
use crate::scene::tables;
use wgpu::util::DeviceExt;
use windfall_core::forest::Terrain;
use windfall_core::path::{FallSettings, PathSet, Variation};
use windfall_core::shed::Shedding;
use windfall_core::wind::Wind;

/// Distance from the camera within which leaves in the air cast shadows, metres.
pub const LOOSE_SHADOWS: f32 = 60.0;

/// How leaves fall in a forest.
#[derive(Debug, Clone)]
pub struct Falls {
    /// The paths. A tree's leaves fall by the group of its model's name, or by the first group.
    pub paths: PathSet,
    /// When leaves detach.
    pub shedding: Shedding,
    /// What carries them, and sways the trees.
    pub wind: Wind,
    /// How falls on the same path differ.
    pub variation: Variation,
    /// Start and end of falls.
    pub settings: FallSettings,
    /// Most leaves in the air and on the ground together: where there are more, those that have
    /// lain longest vanish. 68 bytes of device memory each, and 32 more for each view of the forest:
    /// [`wgpu::Limits::max_storage_buffer_binding_size`] bounds it, at 4,194,304 where that is 128 MiB.
    /// Default 1,000,000.
    pub capacity: u32,
}

impl Default for Falls {
    fn default() -> Self {
        Self {
            paths: PathSet::builtin(),
            shedding: Shedding::default(),
            wind: Wind::new(1.2, 0.6, 0.6, 1),
            variation: Variation::default(),
            settings: FallSettings::default(),
            capacity: 1_000_000,
        }
    }
}

impl Falls {
    /// Device memory of what lasts of a leaf in the air or on the ground from frame to frame, bytes: two
    /// vectors, and the leaf as it was posed.
    pub const STATE_BYTES: u64 = SLOT_BYTES + size_of::<LooseLeaf>() as u64;

    /// A still forest: no leaf falls by itself. [`crate::Forest::throw`] works.
    pub fn none() -> Self {
        Self { shedding: Shedding::never(), capacity: 0, ..Self::default() }
    }

    /// The group of paths for a tree of this name.
    pub fn group_of(&self, name: &str) -> u32 {
        self.paths.group(name).unwrap_or(0)
    }
}

/// Bytes of a slot.
const SLOT_BYTES: u64 = 32;

/// Stands in for an empty buffer: zeros of the largest element.
pub const EMPTY: &[u8] = &[0; size_of::<Model>()];

/// Words of the forest's counters.
#[derive(Debug, Clone, Copy)]
pub enum Counter {
    /// Leaves in the air.
    InAir = 0,
    /// Leaves on the ground.
    OnGround = 1,
    /// Workgroups that find landings; before it, how many slots they have to fill.
    LandingGroups = 3,
    /// Workgroups that pose leaves that change; before it, how many leaves those are.
    ChangeGroups = 5,
    /// Workgroups in a row that pose groups of slots, and rows; before them, how many groups those are.
    AwakeGroups = 7,
    /// The same of groups that come to rest.
    CalmGroups = 10,
}

/// One draw: the loose leaves of one shape of one model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bin {
    pub model: usize,
    pub shape: usize,
    /// First of its slots, and how many.
    pub first: u32,
    pub count: u32,
}

/// The loose leaves of a forest on the GPU.
pub struct LooseState {
    pub streams: Streams,
    /// Constants; the moment's numbers are filled in when it is written.
    pub frame: FallFrame,
    pub uniform: wgpu::Buffer,
    pub stream_buffer: wgpu::Buffer,
    pub list_buffer: wgpu::Buffer,
    pub work: wgpu::Buffer,
    pub posed: wgpu::Buffer,
    pub counters: wgpu::Buffer,
    /// Indirect arguments of the search for landings, of the poses of leaves that change, of the poses of groups of
    /// slots, and of those that come to rest.
    pub indirect: wgpu::Buffer,
    pub group: wgpu::BindGroup,
    /// What the counters of a view begin with.
    pub empty_draws: wgpu::Buffer,
    /// Words of a view's counters.
    pub view_words: u64,
}

/// A buffer with contents; never empty, since a binding may not be smaller than one element.
pub fn storage(
    device: &wgpu::Device,
    label: &str,
    contents: &[u8],
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    let contents = if contents.is_empty() { EMPTY } else { contents };
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some(label),
        contents,
        usage: usage | wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
    })
}

/// A buffer of zeros.
pub fn zeros(
    device: &wgpu::Device,
    label: &str,
    size: u64,
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: size.max(EMPTY.len() as u64).next_multiple_of(16),
        usage: usage | wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

impl LooseState {
    pub fn new(
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        layouts: &Layouts,
        models: &[(TreeModel, u32)],
        uniforms: &[Model],
        streams: Streams,
        (falls, wind): (&Falls, &Wind),
        terrain: &Terrain,
    ) -> Result<Self, ForestError> {
        let slots = u64::from(streams.slot_count);
        let most = device.limits().max_storage_buffer_binding_size;
        if slots * SLOT_BYTES > most {
            return Err(ForestError::TooManyLeaves { leaves: slots, most: most / SLOT_BYTES });
        }
        let (tables, mut frame) = tables::tables(falls, wind, terrain, uniforms);
        frame.stream_count = streams.all.len() as u32;
        frame.slot_count = streams.slot_count;
        frame.bin_count = streams.bins.len() as u32;
        frame.group_count = streams.groups.len() as u32;
        let records: Vec<_> =
            models.iter().flat_map(|(model, _)| model.loose.records.iter().copied()).collect();
        let mut list = streams.groups.concat();
        list.extend_from_slice(&streams.shed_lists);
        let none = wgpu::BufferUsages::empty();
        let stream_buffer = storage(device, "streams", bytemuck::cast_slice(&streams.all), none);
        let list_buffer = storage(device, "shed lists", bytemuck::cast_slice(&list), none);
        let leaves = storage(device, "leaf records", bytemuck::cast_slice(&records), none);
        let slot_buffer = zeros(device, "leaf slots", slots * SLOT_BYTES, none);
        let posed = zeros(
            device,
            "posed leaves",
            slots * size_of::<LooseLeaf>() as u64,
            wgpu::BufferUsages::COPY_SRC,
        );
        let windows = u64::from(WINDOW) * streams.all.len() as u64;
        let groups = streams.groups.len() as u64;
        let of_groups = 2 * groups + 2 * groups.div_ceil(4);
        let work =
            zeros(device, "work on leaves", (windows + slots.div_ceil(4) + of_groups) * 16, none);
        let counters =
            zeros(device, "leaf counters", u64::from(TALLIES) * 4, wgpu::BufferUsages::COPY_SRC);
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("fall"),
            size: size_of::<FallFrame>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let tables = tables::table_view(device, queue, tables);
        let group = layouts::group(
            device,
            "falls",
            &layouts.falls,
            &[
                uniform.as_entire_binding(),
                wgpu::BindingResource::TextureView(&tables),
                stream_buffer.as_entire_binding(),
                list_buffer.as_entire_binding(),
                leaves.as_entire_binding(),
                slot_buffer.as_entire_binding(),
                posed.as_entire_binding(),
                work.as_entire_binding(),
                counters.as_entire_binding(),
            ],
        );
        // Groups as counted by the shader, 1, 1, twice; groups, rows, 1, twice.
        let indirect = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("leaves to see to"),
            contents: bytemuck::cast_slice(&[0u32, 1, 1, 0, 1, 1, 0, 0, 1, 0, 0, 1]),
            usage: wgpu::BufferUsages::INDIRECT | wgpu::BufferUsages::COPY_DST,
        });
        let empty_draws = empty_draws(device, models, &streams.bins);
        let view_words = u64::from(VIEW_TALLIES)
            + 2 * u64::from(DRAW_WORDS) * streams.bins.len() as u64
            + 2 * streams.all.len() as u64
            + groups;
        Ok(Self {
            streams,
            frame,
            uniform,
            stream_buffer,
            list_buffer,
            work,
            posed,
            counters,
            indirect,
            group,
            empty_draws,
            view_words,
        })
    }

    /// Copies a number of workgroups to its indirect arguments.
    pub fn copy_count(&self, encoder: &mut wgpu::CommandEncoder, counter: Counter) {
        let (to, size) = match counter {
            Counter::ChangeGroups => (12, 4),
            Counter::AwakeGroups => (24, 8),
            Counter::CalmGroups => (36, 8),
            _ => (0, 4),
        };
        encoder.copy_buffer_to_buffer(&self.counters, counter as u64 * 4, &self.indirect, to, size);
    }

    /// Says that the slots of a stream hold nothing of use.
    pub fn forget(&self, queue: &wgpu::Queue, stream: u32) {
        let state = u64::from(WINDOW) * u64::from(stream) + 4;
        queue.write_buffer(&self.work, state * 16 + 8, bytemuck::bytes_of(&0u32));
    }

    /// Writes a stream that has changed.
    pub fn write_stream(&self, queue: &wgpu::Queue, stream: u32) {
        let record = &self.streams.all[stream as usize];
        let size = size_of_val(record) as u64;
        let at = u64::from(stream) * size;
        queue.write_buffer(&self.stream_buffer, at, bytemuck::bytes_of(record));
    }

    /// Writes a range of the shed lists that has changed.
    pub fn write_list(&self, queue: &wgpu::Queue, range: std::ops::Range<u32>) {
        let first = 2 * self.streams.groups.len() as u64 + u64::from(range.start);
        let words = &self.streams.shed_lists[range.start as usize..range.end as usize];
        queue.write_buffer(&self.list_buffer, first * 4, bytemuck::cast_slice(words));
    }
}

/// Tallies and indirect arguments as a view's counters begin: nothing is drawn yet.
fn empty_draws(device: &wgpu::Device, models: &[(TreeModel, u32)], bins: &[Bin]) -> wgpu::Buffer {
    let mut words = vec![0u32; VIEW_TALLIES as usize];
    let full =
        |bin: &Bin| [models[bin.model].0.loose.shapes[bin.shape].full.index_count, 0, 0, 0, 0];
    words.extend(bins.iter().flat_map(full));
    words.extend(bins.iter().flat_map(|bin| [6, 0, 0, 0, bin.count]));
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("empty draws"),
        contents: bytemuck::cast_slice(&words),
        usage: wgpu::BufferUsages::COPY_SRC,
    })
}

/// The hash table of thrown leaves, as shaders read it.
pub fn scripted_buffer(device: &wgpu::Device, scripted: &Scripted) -> wgpu::Buffer {
    storage(
        device,
        "scripted detaches",
        bytemuck::cast_slice(&scripted.table()),
        wgpu::BufferUsages::empty(),
    )
}
