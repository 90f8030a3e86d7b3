//! What the strategies without compute hold on the GPU: the CPU's lists and what is posed of them.

use crate::arena::{Arena, GRAIN, Region, Upload};
use crate::falls::{Falls, LeafRecords, Plan, ShapeBuffers, ShapeVertex, tables};
use crate::model::GpuModel;
use crate::pass::{ListedOcclusion, ListedPasses};
use crate::renderer::Renderer;
use crate::roster::{Roster, Tally};
use crate::shared::{FallFrame, FallingLeaf, Model, TreeList};
use crate::strategy::Strategy;
use glam::UVec4;
use wgpu::util::DeviceExt;
use windfall_core::foliage::LeafShape;
use windfall_core::forest::Forest;
use windfall_core::tree::Tree;

/// Texels in a row of the path tables: as `shaders/shared/tables.wgsl`.
const TABLE_WIDTH: u32 = 1024;
/// Texels of a leaf in the leaf texture.
const LEAF_TEXELS: u32 = 5;
/// Texels in a row of posed vertices: as `shaders/vertex_buffer_falls.wgsl`.
pub(crate) const VERTEX_WIDTH: u32 = 2048;
/// Bytes of a texel of every texture here but the tables.
const TEXEL: u64 = 16;

pub(crate) const PLACE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
pub(crate) const WORDS: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;

/// The falling and fallen leaves of a forest, listed by the CPU.
pub(crate) struct ListedFalls {
    pub strategy: Strategy,
    pub roster: Roster,
    /// For each region of the lists what its leaves are drawn with.
    shapes: Vec<ListedShape>,
    pub uniform: wgpu::Buffer,
    pub tables_group: wgpu::BindGroup,
    pub posed: Posed,
    pub occlusion: Option<ListedOcclusion>,
    frame: FallFrame,
    device: wgpu::Device,
}

/// What the leaves of a region are drawn with.
pub(crate) struct ListedShape {
    pub model: usize,
    /// Whether it is two triangles, for leaves that are lit once.
    pub small: bool,
    pub buffers: ShapeBuffers,
    pub vertex_count: u32,
    indices: Vec<u32>,
    /// Where its vertices are in the tables.
    table: u32,
}

impl ListedShape {
    /// Of a shape; its vertices are added to the tables.
    fn new(
        device: &wgpu::Device,
        model: usize,
        shape: &LeafShape,
        small: bool,
        tables: &mut Vec<UVec4>,
    ) -> Self {
        let table = tables.len() as u32;
        let vertex_count = shape.positions.len() as u32;
        let vertices = (0..shape.positions.len()).map(|i| ShapeVertex::new(shape, i));
        tables.extend(vertices.flat_map(|vertex| vertex.texels()));
        let buffers = ShapeBuffers::new(device, shape);
        Self { model, small, buffers, vertex_count, indices: shape.indices.clone(), table }
    }
}

/// What a pose pass writes.
#[expect(clippy::large_enum_variant, reason = "one of it in a forest")]
pub(crate) enum Posed {
    /// Nothing: the vertex shader poses.
    Nothing,
    /// Textures with a texel per leaf.
    Leaves(PosedLeaves),
    /// Textures with a texel per vertex, and what they are copied to.
    Vertices(PosedVertices),
}

pub(crate) struct PosedLeaves {
    pub source: LeafTexture,
    pub targets: [wgpu::TextureView; 2],
    pub draw_group: wgpu::BindGroup,
}

pub(crate) struct PosedVertices {
    pub source: LeafTexture,
    textures: [wgpu::Texture; 2],
    pub targets: [wgpu::TextureView; 2],
    pub buffers: [wgpu::Buffer; 2],
    /// For each region what the pose pass must know of it (four words).
    pub patches: wgpu::Buffer,
    /// First row of each region.
    rows: Vec<u32>,
    /// For each region the shape's indices, as often as there is room for leaves.
    pub indices: Vec<wgpu::Buffer>,
    counts: Vec<u32>,
}

/// The list as a texture.
pub(crate) struct LeafTexture {
    texture: wgpu::Texture,
    pub group: wgpu::BindGroup,
}

impl ListedFalls {
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        renderer: &Renderer,
        trees: &[Tree],
        (gpu_models, models): (&[GpuModel], &[Model]),
        forest: &Forest,
        falls: &Falls,
    ) -> Self {
        let mut records = LeafRecords::new(trees);
        let mut plan = Plan::new(trees, &mut records, forest, falls);
        plan.simplify(gpu_models);
        let (mut table, frame) = tables(falls, forest, models);
        let mut shapes = Vec::new();
        for bin in &plan.bins {
            let shape = &trees[bin.model].foliage.shapes[bin.shape];
            let small = bin.simple.as_ref().unwrap_or(shape);
            for (shape, small) in [(shape, false), (small, true)] {
                shapes.push(ListedShape::new(device, bin.model, shape, small, &mut table));
            }
        }
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("fall"),
            size: size_of::<FallFrame>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let passes = &renderer.listed;
        let tables_group = passes.tables_group(device, &uniform, &table_view(device, queue, table));
        let roster = Roster::new(device, plan, records, models, forest, falls);
        let mut out = Self {
            strategy: falls.strategy,
            roster,
            shapes,
            uniform,
            tables_group,
            posed: Posed::Nothing,
            occlusion: falls
                .leaf_occlusion
                .then(|| passes.occlusion(device, renderer, falls.strategy, 1)),
            frame,
            device: device.clone(),
        };
        out.make_room(passes);
        out
    }

    /// Brings lists, buffers and textures to a moment; `list` is how the view simplifies trees.
    pub fn update(
        &mut self,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        passes: &ListedPasses,
        view: &crate::View,
        list: &TreeList,
    ) -> Tally {
        self.roster.update(view.time, view.season, list);
        let frame = FallFrame { time: view.time, show: view.show as u32, ..self.frame };
        queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&frame));
        self.roster.litter.upload(&self.device, queue, |_| {});
        let occlusion = &self.occlusion;
        let changed = self.roster.falling.upload(&self.device, queue, |places| {
            if let Some(occlusion) = occlusion {
                occlusion.forget(queue, places);
            }
        });
        if changed == Upload::All {
            self.make_room(passes);
        }
        let source = match &self.posed {
            Posed::Nothing => None,
            Posed::Leaves(posed) => Some(&posed.source),
            Posed::Vertices(posed) => Some(&posed.source),
        };
        if let Some(source) = source.filter(|_| changed != Upload::Nothing) {
            source.fill(encoder, &self.roster.falling);
        }
        self.roster.tally()
    }

    /// Textures and buffers as large as the list's.
    fn make_room(&mut self, passes: &ListedPasses) {
        let device = &self.device;
        let falling = &self.roster.falling;
        let leaf_rows = falling.capacity().max(GRAIN) / GRAIN;
        if let Some(occlusion) = &mut self.occlusion {
            occlusion.make_room(device, leaf_rows);
        }
        self.posed = match self.strategy {
            Strategy::Vertex | Strategy::Compute => Posed::Nothing,
            Strategy::Fragment => {
                let target = |label, format| {
                    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT
                        | wgpu::TextureUsages::TEXTURE_BINDING;
                    texture(device, label, format, GRAIN, leaf_rows, usage)
                        .create_view(&wgpu::TextureViewDescriptor::default())
                };
                let targets = [target("leaf places", PLACE), target("leaf looks", WORDS)];
                Posed::Leaves(PosedLeaves {
                    source: LeafTexture::new(device, passes, leaf_rows),
                    draw_group: passes.posed_group(device, &targets),
                    targets,
                })
            }
            Strategy::VertexBuffer => {
                let mut rows = Vec::new();
                let mut height = 0;
                let mut patches: Vec<[u32; 4]> = Vec::new();
                let mut indices = Vec::new();
                for (region, shape) in falling.regions.iter().zip(&self.shapes) {
                    let vertices = shape.vertex_count;
                    rows.push(height);
                    let table = shape.table << 1 | u32::from(shape.small);
                    patches.push([height * VERTEX_WIDTH, vertices, region.first, table]);
                    height += (region.capacity * vertices).div_ceil(VERTEX_WIDTH);
                    let all: Vec<u32> = (0..region.capacity)
                        .flat_map(|leaf| shape.indices.iter().map(move |i| leaf * vertices + i))
                        .collect();
                    indices.push(init(device, &all, wgpu::BufferUsages::INDEX));
                }
                let height = height.max(1);
                let textures = ["vertex places", "vertex looks"].map(|label| {
                    let usage =
                        wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
                    texture(device, label, WORDS, VERTEX_WIDTH, height, usage)
                });
                let buffers = ["placed vertices", "looks of vertices"].map(|label| {
                    device.create_buffer(&wgpu::BufferDescriptor {
                        label: Some(label),
                        size: u64::from(VERTEX_WIDTH) * u64::from(height) * TEXEL,
                        usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
                        mapped_at_creation: false,
                    })
                });
                Posed::Vertices(PosedVertices {
                    source: LeafTexture::new(device, passes, leaf_rows),
                    targets: textures.each_ref().map(|t| t.create_view(&Default::default())),
                    textures,
                    buffers,
                    patches: init(device, &patches.concat(), wgpu::BufferUsages::VERTEX),
                    rows,
                    indices,
                    counts: self.shapes.iter().map(|s| s.vertex_count).collect(),
                })
            }
        };
    }

    /// Draws of a list: region, what its leaves are drawn with, their places in the list.
    pub fn draws<'a, T>(
        &'a self,
        arena: &'a Arena<T>,
    ) -> impl Iterator<Item = (usize, &'a ListedShape, std::ops::Range<u32>)> + 'a
    where
        T: bytemuck::Pod,
    {
        let regions = self.shapes.iter().zip(&arena.regions).enumerate();
        regions
            .filter(|(_, (_, region))| !region.items.is_empty())
            .map(|(i, (shape, region))| (i, shape, region.range()))
    }
}

impl LeafTexture {
    fn new(device: &wgpu::Device, passes: &ListedPasses, rows: u32) -> Self {
        let usage = wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::TEXTURE_BINDING;
        let texture = texture(device, "leaf list", WORDS, GRAIN * LEAF_TEXELS, rows, usage);
        let group = passes.leaf_group(device, &texture.create_view(&Default::default()));
        Self { texture, group }
    }

    /// Copies the rows in use.
    fn fill(&self, encoder: &mut wgpu::CommandEncoder, list: &Arena<FallingLeaf>) {
        for (first, rows) in leaf_rows(list) {
            let row_bytes = GRAIN * size_of::<FallingLeaf>() as u32;
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
                    width: GRAIN * LEAF_TEXELS,
                    height: rows,
                    depth_or_array_layers: 1,
                },
            );
        }
    }
}

/// First row and rows in use of each region, at [`GRAIN`] leaves a row.
pub(crate) fn leaf_rows(list: &Arena<FallingLeaf>) -> impl Iterator<Item = (u32, u32)> + '_ {
    list.regions
        .iter()
        .filter(|region| !region.items.is_empty())
        .map(|region| (region.first / GRAIN, (region.items.len() as u32).div_ceil(GRAIN)))
}

impl PosedVertices {
    /// For each region with leaves: its index, first row and rows in use.
    pub fn rows<'a>(
        &'a self,
        list: &'a Arena<FallingLeaf>,
    ) -> impl Iterator<Item = (u32, u32, u32)> + 'a {
        let used = |region: &Region<FallingLeaf>, i: usize| {
            (region.items.len() as u32 * self.counts[i]).div_ceil(VERTEX_WIDTH)
        };
        list.regions
            .iter()
            .enumerate()
            .filter(|(_, region)| !region.items.is_empty())
            .map(move |(i, region)| (i as u32, self.rows[i], used(region, i)))
    }

    /// Copies what was posed to the vertex buffers.
    pub fn copy(&self, encoder: &mut wgpu::CommandEncoder, list: &Arena<FallingLeaf>) {
        for (_, first, rows) in self.rows(list) {
            for (texture, buffer) in self.textures.iter().zip(&self.buffers) {
                let row_bytes = VERTEX_WIDTH * TEXEL as u32;
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
                    wgpu::Extent3d { width: VERTEX_WIDTH, height: rows, depth_or_array_layers: 1 },
                );
            }
        }
    }

    /// Where a region's vertices begin in the buffers, bytes.
    pub fn offset(&self, region: usize) -> u64 {
        u64::from(self.rows[region]) * u64::from(VERTEX_WIDTH) * TEXEL
    }
}

fn init(device: &wgpu::Device, words: &[u32], usage: wgpu::BufferUsages) -> wgpu::Buffer {
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("leaf words"),
        contents: if words.is_empty() { &[0; 16] } else { bytemuck::cast_slice(words) },
        usage,
    })
}

pub(crate) fn texture(
    device: &wgpu::Device,
    label: &str,
    format: wgpu::TextureFormat,
    width: u32,
    height: u32,
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

/// The tables as a texture.
pub(crate) fn table_view(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    mut table: Vec<UVec4>,
) -> wgpu::TextureView {
    table.resize(table.len().max(1).next_multiple_of(TABLE_WIDTH as usize), UVec4::ZERO);
    let rows = table.len() as u32 / TABLE_WIDTH;
    let usage = wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::TEXTURE_BINDING;
    let texture = texture(device, "path tables", WORDS, TABLE_WIDTH, rows, usage);
    queue.write_texture(
        texture.as_image_copy(),
        bytemuck::cast_slice(&table),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(TABLE_WIDTH * TEXEL as u32),
            rows_per_image: None,
        },
        texture.size(),
    );
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
