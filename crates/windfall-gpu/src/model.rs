//! One tree model on the GPU.

use crate::cull::{PartDraw, WOOD_LEVELS, leaf_parts, pack_halfs, wood_parts};
use crate::falls::{octahedral, snorm8};
use crate::shared::{Crown, Model, Surface};
use crate::texture::{TextureArray, smallest_piece};
use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3, Vec4};
use half::f16;
use wgpu::util::DeviceExt;
use windfall_core::foliage::{Foliage, Leaf, LeafShape, Palette};
use windfall_core::light::leaf;
use windfall_core::simplify::{Branch, SimpleWood, WoodLevel, as_quad, simple_shapes};
use windfall_core::tree::{self, BarkPattern, Material, Tree};

/// A vertex of the hanging leaves: 40 bytes. Everything of the leaf is repeated in its vertices,
/// since a vertex buffer is read several times faster than a storage buffer on the devices measured.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct LeafVertex {
    center: [f32; 3],
    leaf: u32,
    /// Relative to the centre; `w` is the ambient light that reaches the leaf.
    offset: [f16; 4],
    normal: [i8; 4],
    /// Octahedral, in the first two.
    bent_normal: [u8; 4],
    uv: [f16; 2],
    /// Material in the upper 8 bits, shed rank in the lower 24.
    material_shed: u32,
}

impl LeafVertex {
    pub const ATTRIBUTES: [wgpu::VertexAttribute; 7] = wgpu::vertex_attr_array![
        0 => Float32x3, 1 => Uint32, 2 => Float16x4, 3 => Snorm8x4, 4 => Snorm8x4,
        5 => Float16x2, 6 => Uint32,
    ];
}

/// Error from which on a level of wood is only seen from far away, metres: at half a pixel a pixel is a
/// decimetre wide there.
const COARSE_WOOD: f32 = 0.05;
/// Mean radius below which branches are twigs: in errors of a level, less than three pixels wide at the nearest, and
/// metres.
const TWIG: (f32, f32) = (2.5, 0.012);

/// A vertex of the wood: 32 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct WoodVertex {
    position: [f32; 3],
    normal: [i8; 4],
    uv: [f32; 2],
    material: u32,
    /// Its radius, and the error about which it vanishes.
    branch: [f16; 2],
}

impl WoodVertex {
    pub const ATTRIBUTES: [wgpu::VertexAttribute; 5] = wgpu::vertex_attr_array![
        0 => Float32x3, 1 => Snorm8x4, 2 => Float32x2, 3 => Uint32, 4 => Float16x2,
    ];
}

/// An indexed triangle list and what its surface needs.
pub(crate) struct Part {
    pub vertices: wgpu::Buffer,
    pub indices: wgpu::Buffer,
    pub bind_group: wgpu::BindGroup,
    /// Whether some texel of it is a hole.
    pub masked: bool,
    /// Whether it has pictures.
    pub pictures: bool,
}

/// A tree model in the GPU's memory.
pub(crate) struct GpuModel {
    pub wood: Part,
    pub leaves: Part,
    pub leaf_count: u32,
    /// Where small leaves can be drawn in two triangles.
    pub quads: Option<LeafQuads>,
    /// What the leaves are drawn in, in prune order, and the levels of the wood.
    pub leaf_parts: Vec<PartDraw>,
    pub wood_parts: Vec<PartDraw>,
    /// How many of them are of branches whose bark is seen, which come first, and then of twigs; the others
    /// are of wood far away.
    pub wood_kinds: [u32; 2],
    /// Whether the backs of its wood need not be drawn.
    pub outward: bool,
    /// What the simplification of its trees depends on; places and draws are not filled in.
    pub crown: Crown,
    pub uniform: Model,
}

/// The leaves of a model in two triangles each.
pub(crate) struct LeafQuads {
    /// First of four vertices for each leaf, in prune order: what [`crate::pass::quads`] draws.
    pub first: u32,
    /// For each shape its quad.
    pub shapes: Vec<LeafShape>,
}

/// Layout of a part's bind group: model, surfaces, texture array, sampler, events of the forest.
pub(crate) fn part_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let buffer = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT | wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("part of a tree"),
        entries: &[
            buffer(0, wgpu::BufferBindingType::Uniform),
            buffer(1, wgpu::BufferBindingType::Storage { read_only: true }),
            buffer(4, wgpu::BufferBindingType::Storage { read_only: true }),
            wgpu::BindGroupLayoutEntry {
                binding: 2,
                visibility: wgpu::ShaderStages::FRAGMENT,
                ty: wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: true },
                    view_dimension: wgpu::TextureViewDimension::D2Array,
                    multisampled: false,
                },
                count: None,
            },
            wgpu::BindGroupLayoutEntry {
                binding: 3,
                visibility: wgpu::ShaderStages::FRAGMENT,
                ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
                count: None,
            },
        ],
    })
}

impl GpuModel {
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        layout: &wgpu::BindGroupLayout,
        tree: &Tree,
        events: &wgpu::Buffer,
    ) -> Self {
        // A draw that begins in the middle of a list is more than some devices can do.
        let first_instance = device.features().contains(wgpu::Features::INDIRECT_FIRST_INSTANCE);
        let leaf_mesh = LeafMesh::new(&tree.foliage, first_instance);
        let leaf_textures = TextureArray::new(device, queue, &tree.foliage.materials);
        let wood_textures = TextureArray::new(device, queue, &tree.wood.materials);
        let mut uniform = model_uniform(tree);
        uniform.texture_luminance = leaf_textures.luminance;
        let model = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some(&tree.name),
            contents: bytemuck::bytes_of(&uniform),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let part = |vertices: &[u8], indices: &[u32], materials: &[Material], array: &_| {
            part(device, layout, [&model, events], vertices, indices, materials, array)
        };
        let SimpleWood { mut levels, branches, outward } = SimpleWood::new(&tree.wood);
        let wood_vertices: Vec<WoodVertex> =
            tree.wood.vertices.iter().zip(&branches).map(|(v, &b)| wood_vertex(v, b)).collect();
        levels.truncate(if first_instance { WOOD_LEVELS } else { 1 });
        let (wood_indices, wood_draws) = wood_draws(&levels, &branches);
        let wood_parts = wood_draws.map(|draws| wood_parts(&draws));
        let wood = part(
            bytemuck::cast_slice(&wood_vertices),
            &wood_indices,
            &tree.wood.materials,
            &wood_textures,
        );
        let leaves = part(
            bytemuck::cast_slice(&leaf_mesh.vertices),
            &leaf_mesh.indices,
            &tree.foliage.materials,
            &leaf_textures,
        );
        Self {
            leaf_count: tree.foliage.leaves.len() as u32,
            quads: leaf_mesh.quads,
            leaf_parts: leaf_parts(&leaf_mesh.starts, &leaf_mesh.simple_starts, first_instance),
            wood_kinds: [0, 1].map(|kind| wood_parts[kind].len() as u32),
            wood_parts: wood_parts.concat(),
            outward,
            crown: crown(tree, &levels),
            wood,
            leaves,
            uniform,
        }
    }
}

/// Draws of wood: the level, its first index and their number.
type WoodDraws = Vec<(u32, (u32, u32))>;

/// The indices of all levels of the wood, and how they are drawn: branches near enough that their bark is
/// seen, the twigs of the same levels, and levels that are far away.
fn wood_draws(levels: &[WoodLevel], branches: &[Branch]) -> (Vec<u32>, [WoodDraws; 3]) {
    let mut indices: Vec<u32> = Vec::new();
    let mut draws = [const { Vec::new() }; 3];
    let mut add = |kind: usize, level: u32, triangles: &[u32]| {
        draws[kind].push((level, (indices.len() as u32, triangles.len() as u32)));
        indices.extend_from_slice(triangles);
    };
    for (i, level) in (0..).zip(levels) {
        if level.error >= COARSE_WOOD {
            add(2, i, &level.indices);
            continue;
        }
        let thin = (TWIG.0 * level.error).max(TWIG.1);
        let triangles = level.indices.as_chunks::<3>().0.iter();
        let (twigs, limbs): (Vec<[u32; 3]>, Vec<[u32; 3]>) =
            triangles.partition(|t| branches[t[0] as usize].radius < thin);
        add(0, i, limbs.as_flattened());
        add(1, i, twigs.as_flattened());
    }
    (indices, draws)
}

/// Bytes of GPU memory that a tree model takes: buffers and textures with their mip maps.
pub fn model_bytes(tree: &Tree) -> u64 {
    let foliage = &tree.foliage;
    let leaves = LeafMesh::new(foliage, true);
    let buffers = leaves.vertices.len() * size_of::<LeafVertex>()
        + tree.wood.vertices.len() * size_of::<WoodVertex>()
        + (leaves.indices.len() + tree.wood.indices.len()) * size_of::<u32>()
        + size_of::<Model>();
    buffers as u64
        + crate::texture::array_bytes(&foliage.materials)
        + crate::texture::array_bytes(&tree.wood.materials)
}

fn part(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    [model, events]: [&wgpu::Buffer; 2],
    vertices: &[u8],
    indices: &[u32],
    materials: &[Material],
    array: &TextureArray,
) -> Part {
    let init = |label, contents: &[u8], usage| {
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some(label),
            contents,
            usage,
        })
    };
    let mut surfaces: Vec<Surface> =
        materials.iter().zip(&array.layers).map(|(m, &layer)| surface(m, layer)).collect();
    if surfaces.is_empty() {
        surfaces.push(Surface::zeroed()); // a binding may not be empty
    }
    let surfaces = init("surfaces", bytemuck::cast_slice(&surfaces), wgpu::BufferUsages::STORAGE);
    let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("part of a tree"),
        layout,
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: model.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: surfaces.as_entire_binding() },
            wgpu::BindGroupEntry {
                binding: 2,
                resource: wgpu::BindingResource::TextureView(&array.view),
            },
            wgpu::BindGroupEntry {
                binding: 3,
                resource: wgpu::BindingResource::Sampler(&array.sampler),
            },
            wgpu::BindGroupEntry { binding: 4, resource: events.as_entire_binding() },
        ],
    });
    Part {
        vertices: init(
            "vertices",
            vertices,
            wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::STORAGE,
        ),
        indices: init("indices", bytemuck::cast_slice(indices), wgpu::BufferUsages::INDEX),
        bind_group,
        masked: materials.iter().any(|m| m.alpha_cutoff.is_some()),
        pictures: array.layers.iter().any(Option::is_some),
    }
}

fn surface(material: &Material, layer: Option<u32>) -> Surface {
    let (ridge, groove, scale, pattern) = match material.surface {
        tree::Surface::Bark(bark) => {
            let pattern = match bark.pattern {
                BarkPattern::Smooth => 1,
                BarkPattern::Furrowed => 2,
                BarkPattern::Plated => 3,
                BarkPattern::Papery => 4,
            };
            (bark.ridge, bark.groove, bark.scale, pattern)
        }
        tree::Surface::Plain | tree::Surface::Texture(..) => (Vec3::ONE, Vec3::ONE, 1.0, 0),
    };
    Surface {
        base_color: material.base_color,
        layer: layer.map_or(-1, |l| l as i32),
        ridge,
        pattern,
        groove,
        scale,
        roughness: material.roughness,
        piece: material.alpha_cutoff.map_or(0.0, |_| smallest_piece(material)),
        padding: Vec2::ZERO,
    }
}

fn model_uniform(tree: &Tree) -> Model {
    let foliage = &tree.foliage;
    let mut palette = [Vec4::ONE; 8];
    if let Some(colors) = &foliage.palette {
        // Resample to the shader's table, so that any number of stops will do.
        for (i, color) in palette.iter_mut().enumerate() {
            *color = colors.color(i as f32 / 7.0).extend(1.0);
        }
    }
    Model {
        palette,
        mean_palette: foliage.palette.as_ref().map_or([Vec4::ONE; 8], mean_palette),
        crown_center: foliage.crown_center,
        palette_count: if foliage.palette.is_some() { palette.len() as u32 } else { 0 },
        crown_extent: foliage.crown_extent(),
        palette_spread: foliage.palette.as_ref().map_or(0.0, |p| p.spread),
        ambient: foliage.shading.ambient,
        texture_luminance: 1.0,
        sunlight: foliage.visibility.sunlight.into(),
        leaf_count: foliage.leaves.len() as u32,
        crown: Crown::zeroed(),
    }
}

/// Means of a palette over the leaves' own times, which are the sums of two even draws, and their own
/// brightness (`season_of` in `shaders/shared/season.wgsl`): of what they reflect, since no leaf sends out
/// more than falls in, however bright its colour.
fn mean_palette(palette: &Palette) -> [Vec4; 8] {
    const DRAWS: i32 = 16;
    const BRIGHTNESS: [f32; 3] = [0.88, 1.0, 1.12];
    let spread = palette.spread;
    std::array::from_fn(|i| {
        let phase = i as f32 / 7.0 * (1.0 + 2.0 * spread) - spread;
        let mut sum = Vec3::ZERO;
        for draw in 0..DRAWS * DRAWS {
            let own = (draw / DRAWS + draw % DRAWS + 1) as f32 / DRAWS as f32 - 1.0;
            let color = palette.color(phase + own * spread);
            sum += BRIGHTNESS.map(|b| leaf::diffuse(color * b).0).iter().sum::<Vec3>();
        }
        (sum / (3 * DRAWS * DRAWS) as f32).extend(1.0)
    })
}

pub(crate) fn snorm(v: Vec3) -> [i8; 4] {
    let scaled = (v.clamp(Vec3::NEG_ONE, Vec3::ONE) * 127.0).round();
    [scaled.x as i8, scaled.y as i8, scaled.z as i8, 0]
}

fn wood_vertex(vertex: &tree::WoodVertex, branch: Branch) -> WoodVertex {
    WoodVertex {
        position: vertex.position.to_array(),
        normal: snorm(vertex.normal),
        uv: vertex.uv.to_array(),
        material: vertex.material,
        branch: [branch.radius, branch.vanishes.min(f16::MAX.to_f32())].map(f16::from_f32),
    }
}

fn crown(tree: &Tree, levels: &[WoodLevel]) -> Crown {
    let mut wood_errors = [Vec4::ZERO; 4];
    for (i, level) in levels.iter().enumerate() {
        wood_errors[i / 4][i % 4] = level.error;
    }
    let (low, high) = tree.bounds();
    let foliage = &tree.foliage;
    let share = foliage.visibility.share.clamp(1e-9, 0.999);
    let normals = foliage.shading.normals;
    let holes = foliage.holes();
    Crown {
        center: (low + high) * 0.5,
        radius: (high - low).length() * 0.5,
        half_size: (high - low) * 0.5,
        leaf_length: foliage.leaf_length(),
        leaf_side: foliage.leaf_side(),
        holes: pack_halfs(Vec2::new(holes.solid, holes.piece)),
        visible_share: share,
        disocclusion: foliage.visibility.disocclusion.into(),
        log_hidden: (-share).ln_1p(),
        leaf_count: foliage.leaves.len() as u32,
        wood_levels: levels.len() as u32,
        wood_errors,
        normal_squares: Vec3::new(normals.x_axis.x, normals.y_axis.y, normals.z_axis.z),
        normal_products: 2.0 * Vec3::new(normals.x_axis.y, normals.y_axis.z, normals.z_axis.x),
        ..Crown::zeroed()
    }
}

/// The leaves of a tree as a mesh.
struct LeafMesh {
    vertices: Vec<LeafVertex>,
    indices: Vec<u32>,
    /// In prune order the first index of each leaf, and the end of the last.
    starts: Vec<u32>,
    /// The same of the leaves in few triangles, for simplified trees.
    simple_starts: Vec<u32>,
    /// Those if they are quads of four vertices each, without pictures.
    quads: Option<LeafQuads>,
}

impl LeafMesh {
    fn new(foliage: &Foliage, simplify: bool) -> Self {
        let mut mesh = Self {
            vertices: Vec::with_capacity(foliage.vertex_count()),
            indices: Vec::with_capacity(foliage.triangle_count() * 3),
            starts: Vec::new(),
            simple_starts: Vec::new(),
            quads: None,
        };
        let simple = if simplify { simple_shapes(foliage) } else { Vec::new() };
        let mut firsts = Vec::with_capacity(foliage.leaves.len());
        for (i, leaf) in (0..).zip(&foliage.leaves) {
            mesh.starts.push(mesh.indices.len() as u32);
            firsts.push(mesh.vertices.len() as u32);
            let shape = &foliage.shapes[leaf.shape as usize];
            mesh.add(i, leaf, shape);
        }
        mesh.starts.push(mesh.indices.len() as u32);
        if let Some(shapes) = quads(foliage, &simple) {
            let first = mesh.vertices.len() as u32;
            for (i, leaf) in (0..).zip(&foliage.leaves) {
                mesh.simple_starts.push(mesh.indices.len() as u32);
                mesh.add(i, leaf, &shapes[leaf.shape as usize]);
            }
            mesh.simple_starts.push(mesh.indices.len() as u32);
            mesh.quads = Some(LeafQuads { first, shapes });
            return mesh;
        }
        if simple.iter().all(Option::is_none) {
            mesh.simple_starts.clone_from(&mesh.starts);
            return mesh;
        }
        for (i, leaf) in (0..).zip(&foliage.leaves) {
            mesh.simple_starts.push(mesh.indices.len() as u32);
            if let Some(shape) = &simple[leaf.shape as usize] {
                mesh.add(i, leaf, shape);
            } else {
                let shape = &foliage.shapes[leaf.shape as usize];
                let first = firsts[i as usize];
                mesh.indices.extend(shape.indices.iter().map(|&index| first + index));
            }
        }
        mesh.simple_starts.push(mesh.indices.len() as u32);
        mesh
    }

    fn add(&mut self, index: u32, leaf: &Leaf, shape: &LeafShape) {
        let first = self.vertices.len() as u32;
        self.indices.extend(shape.indices.iter().map(|&index| first + index));
        let [x, y] = octahedral(leaf.bent_normal).to_array().map(snorm8);
        let bent_normal = [x, y, 0, 0];
        for ((&position, &normal), &uv) in
            shape.positions.iter().zip(&shape.normals).zip(&shape.uvs)
        {
            let offset = leaf.orientation * position * leaf.scale;
            self.vertices.push(LeafVertex {
                center: leaf.center.to_array(),
                leaf: index,
                offset: offset.extend(leaf.ambient).to_array().map(f16::from_f32),
                normal: snorm(leaf.orientation * normal),
                bent_normal,
                uv: uv.to_array().map(f16::from_f32),
                material_shed: leaf.material << 24 | (leaf.shed_rank & 0x00ff_ffff),
            });
        }
    }
}

/// The shapes of leaves without pictures as quads, each with the mean normal of its leaf, if every one has
/// few enough triangles for that; `simple` are what [`simple_shapes`] has found, nothing where there is
/// nothing to find.
fn quads(foliage: &Foliage, simple: &[Option<LeafShape>]) -> Option<Vec<LeafShape>> {
    let plain =
        |m: &Material| m.alpha_cutoff.is_none() && !matches!(m.surface, tree::Surface::Texture(..));
    if simple.is_empty() || !foliage.materials.iter().all(plain) {
        return None;
    }
    let shapes = foliage.shapes.iter().zip(simple);
    let quad = |(shape, simple): (&LeafShape, &Option<LeafShape>)| {
        let mut quad = as_quad(simple.as_ref().unwrap_or(shape))?;
        quad.normals.fill(mean_normal(shape));
        Some(quad)
    };
    shapes.map(quad).collect()
}

/// The mean of a leaf's normals over its area: the shorter, the more it is curved. 1 long for none.
fn mean_normal(shape: &LeafShape) -> Vec3 {
    let (mut sum, mut area) = (Vec3::ZERO, 0.0);
    for t in shape.indices.chunks_exact(3) {
        let t = [t[0], t[1], t[2]].map(|i| i as usize);
        let [a, b, c] = t.map(|i| shape.positions[i]);
        let part = (b - a).cross(c - a).length();
        sum += part / 3.0 * t.iter().map(|&i| shape.normals[i]).sum::<Vec3>();
        area += part;
    }
    if area > 0.0 && sum.is_finite() { sum / area } else { Vec3::Y }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_triangle_of_a_level_is_drawn_once_as_thick_as_it_is() {
        let branches: Vec<Branch> =
            [0.2, 0.02, 0.01].map(|radius| [Branch { radius, vanishes: 1.0 }; 3]).concat();
        // Of the finest level only the thinnest is a twig, of one with an error of 1 cm the second too.
        let levels: Vec<WoodLevel> = [0.0, 0.01, 0.06]
            .map(|error| WoodLevel { indices: vec![6, 7, 8, 0, 1, 2, 3, 4, 5], error })
            .to_vec();
        let (indices, [limbs, twigs, far]) = wood_draws(&levels, &branches);
        let first = |draws: &WoodDraws| -> Vec<(u32, Vec<u32>)> {
            let of = |&(level, (first, count)): &(u32, (u32, u32))| {
                let range = &indices[first as usize..(first + count) as usize];
                (level, range.iter().step_by(3).copied().collect())
            };
            draws.iter().map(of).collect()
        };
        assert_eq!(first(&limbs), [(0, vec![0, 3]), (1, vec![0])]);
        assert_eq!(first(&twigs), [(0, vec![6]), (1, vec![6, 3])]);
        assert_eq!(first(&far), [(2, vec![6, 0, 3])]);
        assert_eq!(indices.len(), 27);
    }

    #[test]
    fn the_mean_normal_of_a_fold_is_as_long_as_it_is_open() {
        // Halves of one square metre and of two, that lean to either side by 0.5.
        let (sin, cos) = 0.5f32.sin_cos();
        let at = |x: f32, z: f32| Vec3::new(x * cos, x.abs() * sin, z);
        let (left, right) = (Vec3::new(sin, cos, 0.0), Vec3::new(-sin, cos, 0.0));
        let shape = LeafShape {
            positions: [
                (-1.0, 0.0),
                (0.0, 0.0),
                (-1.0, 1.0),
                (0.0, 1.0),
                (0.0, 0.0),
                (2.0, 0.0),
                (0.0, 1.0),
                (2.0, 1.0),
            ]
            .map(|(x, z)| at(x, z))
            .to_vec(),
            normals: [[left; 4], [right; 4]].concat(),
            uvs: vec![glam::Vec2::ZERO; 8],
            indices: vec![0, 1, 2, 2, 1, 3, 4, 5, 6, 6, 5, 7],
        };
        let expected = (left + 2.0 * right) / 3.0;
        assert!(mean_normal(&shape).distance(expected) < 1e-6, "{}", mean_normal(&shape));
        assert!((expected.length() - 0.892).abs() < 1e-3);
        assert_eq!(mean_normal(&LeafShape::default()), Vec3::Y);
    }

    #[test]
    fn a_mean_palette_is_the_palette_blurred_by_the_leaves_own_times() {
        let dark = Vec3::new(0.1, 0.05, 0.0);
        let stops = vec![dark, Vec3::new(0.3, 0.2, 0.0)];
        let at = |means: [Vec4; 8], i: usize| means[i].truncate();
        let sharp = mean_palette(&Palette { stops: stops.clone(), spread: 0.0 });
        for (i, mean) in sharp.iter().enumerate() {
            let color = stops[0].lerp(stops[1], i as f32 / 7.0);
            assert!(mean.truncate().distance(color) < 1e-4, "{i}: {mean} for {color}");
        }
        // Ends at -0.4 and 1.4, where every leaf has the first and the last colour. The third entry is at
        // phase x = 0.1143; leaves that are at less than 0 have the first colour, which adds the mean of
        // what they are below: (0.4 - x)^3 / (6 * 0.4^2) = 0.0243.
        let blurred = mean_palette(&Palette { stops: stops.clone(), spread: 0.4 });
        assert!(at(blurred, 0).distance(dark) < 1e-3 && at(blurred, 7).distance(stops[1]) < 1e-3);
        let expected = dark.lerp(stops[1], 0.1143 + 0.0243);
        assert!(at(blurred, 2).distance(expected) < 2e-3, "{} for {expected}", blurred[2]);
        // Brighter than a leaf can send out: the mean is of what it does.
        let bright = mean_palette(&Palette { stops: vec![Vec3::splat(2.0)], spread: 0.0 });
        assert!(at(bright, 3).max_element() < 0.97, "{}", bright[3]);
    }
}
