//! The lists of a forest's leaves on the GPU, and what is posed of them.

use crate::active_leaves::{ActiveLeaves, ListMoment, fall_of};
use crate::arena::{Arena, BLOCK_SIZE, Region, Upload};
use crate::look::{airborne_leaf, litter_leaf};
use crate::options::{ListOptions, Strategy};
use crate::pass::PublishedPasses;
use crate::pass::occlusion::Visibility;
use crate::shared::{FallingLeaf, LitterLeaf};
use crate::streams::Streams;
use glam::UVec4;
use wgpu::util::DeviceExt;
use windfall_core::foliage::LeafShape;
use windfall_gpu::internals::shared::{FallFrame, Model, TreeList};
use windfall_gpu::internals::{ShapeBuffers, ShapeVertex, table_view, tables};
use windfall_gpu::{Forest, Recording, TreeModel};

/// Texels of a leaf in the leaf texture.
pub const LEAF_TEXELS: u32 = size_of::<FallingLeaf>() as u32 / TEXEL_BYTES as u32;
/// Texels in a row of posed vertices.
pub const VERTEX_ROW: u32 = 2048;
/// Bytes of a texel of [`POSITIONS`] and [`WORDS`].
const TEXEL_BYTES: u64 = 16;

pub const POSITIONS: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
pub const WORDS: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;

/// The leaves of one forest that have left their twigs.
pub struct LeafBuffers {
    strategy: Strategy,
    pub lists: ActiveLeaves,
    /// What the leaves of each region are drawn with.
    shapes: Vec<RegionShape>,
    uniform: wgpu::Buffer,
    pub tables_group: wgpu::BindGroup,
    pub posed: Posed,
    pub visibility: Option<Visibility>,
    constants: FallFrame,
    device: wgpu::Device,
}

/// What the leaves of a region are drawn with.
pub struct RegionShape {
    pub model: TreeModel,
    shape: usize,
    /// Whether it is two triangles, for leaves that are lit once.
    pub small: bool,
    /// Index of its first vertex in the tables.
    table: u32,
}

impl RegionShape {
    fn geometry(&self) -> &LeafShape {
        let shape = &self.model.loose.shapes[self.shape];
        shape.small_geometry.as_ref().filter(|_| self.small).unwrap_or(&shape.geometry)
    }

    pub fn buffers(&self) -> &ShapeBuffers {
        let shape = &self.model.loose.shapes[self.shape];
        shape.small.as_ref().filter(|_| self.small).unwrap_or(&shape.full)
    }

    fn vertex_count(&self) -> u32 {
        self.geometry().positions.len() as u32
    }
}

/// What a pose pass writes.
#[expect(clippy::large_enum_variant, reason = "one per forest")]
pub enum Posed {
    /// Nothing: the vertex shader poses.
    Nothing,
    /// Textures with a texel per leaf.
    Leaves(PosedLeaves),
    /// Textures with a texel per vertex, and the buffers that they are copied to.
    Vertices(PosedVertices),
    /// A buffer of instances that the CPU fills in every frame.
    Uploaded(wgpu::Buffer),
}

pub struct PosedLeaves {
    pub source: LeafTexture,
    pub targets: [wgpu::TextureView; 2],
    pub draw_group: wgpu::BindGroup,
}

pub struct PosedVertices {
    pub source: LeafTexture,
    textures: [wgpu::Texture; 2],
    pub targets: [wgpu::TextureView; 2],
    pub buffers: [wgpu::Buffer; 2],
    /// Four words per region: `Region` of `pass/vertex_buffer.wgsl`.
    pub records: wgpu::Buffer,
    /// First row of each region.
    first_rows: Vec<u32>,
    /// For each region the shape's indices, repeated for as many leaves as it has room.
    pub indices: Vec<wgpu::Buffer>,
    /// Vertices of each region's shape.
    vertex_counts: Vec<u32>,
}

/// The list of active leaves as a texture.
pub struct LeafTexture {
    texture: wgpu::Texture,
    pub group: wgpu::BindGroup,
}

/// Samples of the paths of a forest as tables have them: a path's once for each of its continuity points.
pub fn path_samples(forest: &Forest) -> u32 {
    tables(forest.falls(), forest.local_wind(), forest.terrain(), &[]).1.low_table
}

/// Positions and orientations of samples as two one-dimensional textures (VB 3.3), of a texel at least. `grain` is the
/// unit of positions, metres.
fn path_textures(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    samples: &[UVec4],
    grain: f32,
) -> [wgpu::TextureView; 2] {
    // As path_samples.wgsl reads them: 21 bits of x and z, 22 of y.
    let position = |t: &UVec4| {
        let place = [t.x, t.x << 21 | (t.y & 0x7ff) << 10, t.y].map(|word| word as i32);
        [place[0] >> 11, place[1] >> 10, place[2] >> 11, 0].map(|whole| whole as f32 * grain)
    };
    let orientation = |t: &UVec4| {
        let part = |word: u32| (f32::from(word as u16 as i16) / 32767.0).max(-1.0);
        [part(t.z), part(t.z >> 16), part(t.w), part(t.w >> 16)]
    };
    let view = |label, texel: &dyn Fn(&UVec4) -> [f32; 4]| {
        let mut texels: Vec<[f32; 4]> = samples.iter().map(texel).collect();
        texels.resize(samples.len().max(1), [0.0; 4]);
        let texture = device.create_texture_with_data(
            queue,
            &wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d {
                    width: texels.len() as u32,
                    height: 1,
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D1,
                format: POSITIONS,
                usage: wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            },
            wgpu::util::TextureDataOrder::LayerMajor,
            bytemuck::cast_slice(&texels),
        );
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    };
    [view("path positions", &position), view("path orientations", &orientation)]
}

/// Why lists of this size cannot be kept: what would be too large, what it would be, and the device's limit.
pub type TooLarge = (&'static str, u64, u64);

/// Whether the device holds the lists of these streams, however their leaves are distributed.
pub fn check_size(
    limits: &wgpu::Limits,
    streams: &Streams,
    strategy: Strategy,
) -> Result<(), TooLarge> {
    let most = |what, size: u64, limit: u64| {
        if size > limit { Err((what, size, limit)) } else { Ok(()) }
    };
    let (mut leaf_rows, mut vertex_rows) = (0, 0);
    for batch in &streams.batches {
        let shape = &streams.models[batch.model].loose.shapes[batch.shape];
        let full = &shape.geometry;
        // All leaves may have been full once and small once; regions grow by half.
        for geometry in [full, shape.small_geometry.as_ref().unwrap_or(full)] {
            let slots = u64::from(batch.slots);
            let room = (slots + slots / 2).next_multiple_of(BLOCK_SIZE.into());
            let room = room.max(BLOCK_SIZE.into());
            leaf_rows += room / u64::from(BLOCK_SIZE);
            vertex_rows += (room * geometry.positions.len() as u64).div_ceil(VERTEX_ROW.into());
            if strategy == Strategy::VertexBuffer {
                let bytes = room * geometry.indices.len() as u64 * 4;
                most("index buffer", bytes, limits.max_buffer_size)?;
            }
        }
    }
    let list_bytes = leaf_rows * u64::from(BLOCK_SIZE) * size_of::<FallingLeaf>() as u64;
    most("list of leaves", list_bytes, limits.max_buffer_size)?;
    let side = u64::from(limits.max_texture_dimension_2d);
    most("texture of leaves", leaf_rows, side)?;
    if strategy == Strategy::VertexBuffer {
        most("texture of vertices", vertex_rows, side)?;
        let bytes = vertex_rows * u64::from(VERTEX_ROW) * TEXEL_BYTES;
        most("buffer of vertices", bytes, limits.max_buffer_size)?;
    }
    Ok(())
}

impl LeafBuffers {
    /// Empty lists of a forest.
    pub fn new(
        queue: &wgpu::Queue,
        passes: &PublishedPasses,
        forest: &Forest,
        streams: Streams,
        options: &ListOptions,
    ) -> Self {
        let device = &passes.device;
        let models: Vec<Model> = streams.models.iter().map(|model| model.uniform).collect();
        let (mut table, constants) =
            tables(forest.falls(), forest.local_wind(), forest.terrain(), &models);
        let samples: &[UVec4] = if passes.options().one_dimensional() {
            &table[..constants.low_table as usize]
        } else {
            &[]
        };
        let paths = path_textures(device, queue, samples, constants.path_grain);
        let mut shapes = Vec::new();
        for batch in &streams.batches {
            for small in [false, true] {
                let model = streams.models[batch.model].clone();
                let table_first = table.len() as u32;
                let shape = RegionShape { model, shape: batch.shape, small, table: table_first };
                let geometry = shape.geometry();
                let vertices = (0..geometry.positions.len()).map(|i| ShapeVertex::new(geometry, i));
                table.extend(vertices.flat_map(|vertex| vertex.texels()));
                shapes.push(shape);
            }
        }
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("fall"),
            size: size_of::<FallFrame>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut out = Self {
            strategy: passes.strategy(),
            tables_group: passes.tables_group(&uniform, &table_view(device, queue, table), &paths),
            lists: ActiveLeaves::new(
                device,
                streams,
                forest,
                options.elimination,
                passes.options(),
            ),
            shapes,
            uniform,
            posed: Posed::Nothing,
            visibility: None,
            constants,
            device: device.clone(),
        };
        out.make_room(passes);
        out
    }

    /// Brings lists, buffers and textures to the forest's moment.
    pub fn update(
        &mut self,
        recording: &mut Recording<'_>,
        passes: &PublishedPasses,
        forest: &Forest,
        view: &TreeList,
    ) {
        let queue = recording.queue;
        let time = forest.moment().time - forest.clock_start();
        let moment = ListMoment { time, season: forest.season() };
        self.lists.update(forest, moment, view);
        let frame = forest.fall_frame(self.constants);
        queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&frame));
        self.lists.litter.upload(&self.device, queue, |_| {});
        let visibility = &self.visibility;
        let changed = self.lists.active.upload(&self.device, queue, |leaves| {
            if let Some(visibility) = visibility {
                visibility.forget(queue, leaves);
            }
        });
        if changed == Upload::All {
            self.make_room(passes);
        }
        // In every frame: an encoder may have been dropped.
        match &self.posed {
            Posed::Nothing => {}
            Posed::Uploaded(buffer) => pose_on_cpu(queue, buffer, &self.lists, forest, time),
            Posed::Leaves(PosedLeaves { source, .. })
            | Posed::Vertices(PosedVertices { source, .. }) => {
                source.fill(recording.encoder, &self.lists.active);
            }
        }
    }

    /// Makes textures and buffers as large as the list.
    fn make_room(&mut self, passes: &PublishedPasses) {
        let device = &self.device;
        let list = &self.lists.active;
        let leaf_rows = list.capacity().max(BLOCK_SIZE) / BLOCK_SIZE;
        self.visibility =
            passes.occlusion.as_ref().map(|occlusion| occlusion.visibility(device, leaf_rows));
        self.posed = match self.strategy {
            Strategy::Vertex => Posed::Nothing,
            Strategy::Fragment => {
                let target = |label, format| {
                    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT
                        | wgpu::TextureUsages::TEXTURE_BINDING;
                    texture(device, label, format, (BLOCK_SIZE, leaf_rows), usage)
                        .create_view(&wgpu::TextureViewDescriptor::default())
                };
                let targets = [target("leaf positions", POSITIONS), target("leaf looks", WORDS)];
                Posed::Leaves(PosedLeaves {
                    source: LeafTexture::new(passes, leaf_rows),
                    draw_group: passes.posed_group(&targets),
                    targets,
                })
            }
            Strategy::VertexBuffer => self.posed_vertices(passes, leaf_rows),
            Strategy::Cpu => Posed::Uploaded(device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("leaves posed by the CPU"),
                size: u64::from(leaf_rows * BLOCK_SIZE) * size_of::<LitterLeaf>() as u64,
                usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })),
        };
    }

    fn posed_vertices(&self, passes: &PublishedPasses, leaf_rows: u32) -> Posed {
        let device = &self.device;
        let mut first_rows = Vec::new();
        let mut height = 0;
        let mut records: Vec<[u32; 4]> = Vec::new();
        let mut indices = Vec::new();
        for (region, shape) in self.lists.active.regions.iter().zip(&self.shapes) {
            let vertices = shape.vertex_count();
            first_rows.push(height);
            let table = shape.table << 1 | u32::from(shape.small);
            records.push([height * VERTEX_ROW, vertices, region.first, table]);
            height += (region.capacity * vertices).div_ceil(VERTEX_ROW);
            let of_leaf = &shape.geometry().indices;
            let all: Vec<u32> = (0..region.capacity)
                .flat_map(|leaf| of_leaf.iter().map(move |i| leaf * vertices + i))
                .collect();
            indices.push(words_buffer(device, &all, wgpu::BufferUsages::INDEX));
        }
        let height = height.max(1);
        let textures = ["vertex positions", "vertex looks"].map(|label| {
            let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
            texture(device, label, WORDS, (VERTEX_ROW, height), usage)
        });
        let buffers = ["vertex positions", "vertex looks"].map(|label| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: u64::from(VERTEX_ROW) * u64::from(height) * TEXEL_BYTES,
                usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        });
        Posed::Vertices(PosedVertices {
            source: LeafTexture::new(passes, leaf_rows),
            targets: textures.each_ref().map(|t| t.create_view(&Default::default())),
            textures,
            buffers,
            records: words_buffer(device, &records.concat(), wgpu::BufferUsages::VERTEX),
            first_rows,
            indices,
            vertex_counts: self.shapes.iter().map(RegionShape::vertex_count).collect(),
        })
    }

    /// Draws of a list: region, what its leaves are drawn with, their range in the list's buffer.
    pub fn draws<'a, T: bytemuck::Pod>(
        &'a self,
        list: &'a Arena<T>,
    ) -> impl Iterator<Item = (usize, &'a RegionShape, std::ops::Range<u32>)> + 'a {
        let regions = self.shapes.iter().zip(&list.regions).enumerate();
        regions
            .filter(|(_, (_, region))| !region.items.is_empty())
            .map(|(i, (shape, region))| (i, shape, region.range()))
    }
}

/// Poses the active leaves on the CPU and uploads them (VB 6.3).
fn pose_on_cpu(
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
    lists: &ActiveLeaves,
    forest: &Forest,
    time: f64,
) {
    let Some(falls) = &lists.falls else { return };
    let fall = fall_of(forest);
    let mut posed: Vec<LitterLeaf> = Vec::new();
    for (i, region) in lists.active.regions.iter().enumerate() {
        let batch = &lists.streams.batches[i / 2];
        let model = &lists.streams.models[batch.model].uniform;
        posed.clear();
        posed.extend(region.items.iter().zip(&region.owners).map(|(leaf, &slot)| {
            let landing = f64::from(leaf.detach_time) + f64::from(leaf.landing.w);
            match falls[slot as usize].as_deref().filter(|_| time < landing) {
                Some((of, end)) => airborne_leaf((leaf, model), (&fall, of, end), forest, time),
                None => litter_leaf(leaf, model, forest.season()),
            }
        }));
        if !posed.is_empty() {
            let at = u64::from(region.first) * size_of::<LitterLeaf>() as u64;
            queue.write_buffer(buffer, at, bytemuck::cast_slice(&posed));
        }
    }
}

impl LeafTexture {
    fn new(passes: &PublishedPasses, rows: u32) -> Self {
        let usage = wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::TEXTURE_BINDING;
        let size = (BLOCK_SIZE * LEAF_TEXELS, rows);
        let texture = texture(&passes.device, "active leaves", WORDS, size, usage);
        let group = passes.leaves_group(&texture.create_view(&Default::default()));
        Self { texture, group }
    }

    /// Copies the rows in use.
    fn fill(&self, encoder: &mut wgpu::CommandEncoder, list: &Arena<FallingLeaf>) {
        for (first, count) in rows(list) {
            let row_bytes = BLOCK_SIZE * size_of::<FallingLeaf>() as u32;
            encoder.copy_buffer_to_texture(
                wgpu::TexelCopyBufferInfo {
                    buffer: &list.buffer,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: u64::from(first) * u64::from(row_bytes),
                        bytes_per_row: Some(row_bytes),
                        rows_per_image: None,
                    },
                },
                wgpu::TexelCopyTextureInfo {
                    origin: wgpu::Origin3d { x: 0, y: first, z: 0 },
                    ..self.texture.as_image_copy()
                },
                wgpu::Extent3d {
                    width: BLOCK_SIZE * LEAF_TEXELS,
                    height: count,
                    depth_or_array_layers: 1,
                },
            );
        }
    }
}

/// First row and rows in use of each region that has leaves, [`BLOCK_SIZE`] leaves a row.
pub fn rows(list: &Arena<FallingLeaf>) -> impl Iterator<Item = (u32, u32)> + '_ {
    list.regions
        .iter()
        .filter(|region| !region.items.is_empty())
        .map(|region| (region.first / BLOCK_SIZE, (region.items.len() as u32).div_ceil(BLOCK_SIZE)))
}

impl PosedVertices {
    /// For each region that has leaves: its index, first row and rows in use.
    pub fn rows<'a>(
        &'a self,
        list: &'a Arena<FallingLeaf>,
    ) -> impl Iterator<Item = (u32, u32, u32)> + 'a {
        let used = |region: &Region<FallingLeaf>, i: usize| {
            (region.items.len() as u32 * self.vertex_counts[i]).div_ceil(VERTEX_ROW)
        };
        list.regions
            .iter()
            .enumerate()
            .filter(|(_, region)| !region.items.is_empty())
            .map(move |(i, region)| (i as u32, self.first_rows[i], used(region, i)))
    }

    /// Copies what was posed to the vertex buffers.
    pub fn copy(&self, encoder: &mut wgpu::CommandEncoder, list: &Arena<FallingLeaf>) {
        let row_bytes = VERTEX_ROW * TEXEL_BYTES as u32;
        for (_, first, count) in self.rows(list) {
            for (texture, buffer) in self.textures.iter().zip(&self.buffers) {
                encoder.copy_texture_to_buffer(
                    wgpu::TexelCopyTextureInfo {
                        origin: wgpu::Origin3d { x: 0, y: first, z: 0 },
                        ..texture.as_image_copy()
                    },
                    wgpu::TexelCopyBufferInfo {
                        buffer,
                        layout: wgpu::TexelCopyBufferLayout {
                            offset: u64::from(first) * u64::from(row_bytes),
                            bytes_per_row: Some(row_bytes),
                            rows_per_image: None,
                        },
                    },
                    wgpu::Extent3d { width: VERTEX_ROW, height: count, depth_or_array_layers: 1 },
                );
            }
        }
    }

    /// Where a region's vertices begin in the buffers, bytes.
    pub fn offset(&self, region: usize) -> u64 {
        u64::from(self.first_rows[region]) * u64::from(VERTEX_ROW) * TEXEL_BYTES
    }
}

fn words_buffer(device: &wgpu::Device, words: &[u32], usage: wgpu::BufferUsages) -> wgpu::Buffer {
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("leaf words"),
        contents: if words.is_empty() { &[0; 16] } else { bytemuck::cast_slice(words) },
        usage,
    })
}

pub fn texture(
    device: &wgpu::Device,
    label: &str,
    format: wgpu::TextureFormat,
    (width, height): (u32, u32),
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}
