//! One tree model on the GPU.

use crate::base::constants::WOOD_LEVELS;
use crate::base::layouts::{self, Layouts};
use crate::base::packing::{pack_halfs, snorm};
use crate::base::shared::{Crown, Model, Surface};
use crate::scene::leaf_mesh::{LeafMesh, LeafQuads, LeafVertex, leaf_lengths};
use crate::scene::loose_shapes::LooseShapes;
use crate::scene::parts::{PartDraw, leaf_parts, wood_parts};
use crate::scene::texture::{TextureArray, array_bytes, smallest_piece};
use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3, Vec4};
use half::f16;
use std::sync::Arc;
use wgpu::util::DeviceExt;
use windfall_core::foliage::Palette;
use windfall_core::light::leaf;
use windfall_core::simplify::{Branch, WoodLevel};
use windfall_core::tree::{self, BarkPattern, Material, Tree};

/// Error from which on a level of wood is only seen from far away, metres: at half a pixel a pixel is a
/// decimetre wide there.
const COARSE_WOOD: f32 = 0.05;
/// Mean radius below which branches are twigs: in errors of a level, less than three pixels wide at the nearest, and
/// metres.
const TWIG: (f32, f32) = (2.5, 0.012);
/// Leaves that a model may have: shed ranks have 24 bits, the highest is kept free.
const MOST_LEAVES: usize = (1 << 24) - 1;

/// A vertex of the wood: 32 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct WoodVertex {
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
pub struct Part {
    pub vertices: wgpu::Buffer,
    pub indices: wgpu::Buffer,
    pub bind_group: wgpu::BindGroup,
    /// Whether some texel of it is a hole.
    pub masked: bool,
    /// Whether it has textures.
    pub textured: bool,
}

/// A tree model in the GPU's memory: uploaded once, and drawn in any number of forests of its device.
///
/// Cheap to clone: clones are the same model.
#[derive(Clone)]
pub struct TreeModel {
    data: Arc<ModelData>,
}

impl std::ops::Deref for TreeModel {
    type Target = ModelData;

    fn deref(&self) -> &ModelData {
        &self.data
    }
}

impl std::fmt::Debug for TreeModel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "TreeModel({:?}, {} leaves)", self.name, self.leaf_count)
    }
}

impl PartialEq for TreeModel {
    /// Whether they are one model, not whether they look alike.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.data, &other.data)
    }
}

/// Why a tree cannot be uploaded.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// More leaves than shed ranks tell apart.
    #[error("tree {name:?}: {leaves} leaves are more than the {most} that a tree may have")]
    TooManyLeaves {
        /// The tree.
        name: String,
        /// Its leaves.
        leaves: usize,
        /// Most leaves of a tree.
        most: usize,
    },
    /// A mesh is larger than a buffer of the device may be.
    #[error("tree {name:?}: its {part} take {bytes} bytes, a buffer of the device holds {most}")]
    TooLarge {
        /// The tree.
        name: String,
        /// Leaves or wood.
        part: &'static str,
        /// Bytes of its vertices or indices.
        bytes: u64,
        /// [`wgpu::Limits::max_buffer_size`].
        most: u64,
    },
}

#[doc(hidden)]
pub struct ModelData {
    pub device: wgpu::Device,
    pub name: String,
    pub wood: Part,
    pub leaves: Part,
    pub leaf_count: u32,
    /// Triangles of wood and leaves, unsimplified.
    pub triangles: u64,
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
    pub loose: LooseShapes,
}

impl TreeModel {
    /// Uploads a tree.
    ///
    /// On a device without [`wgpu::Features::INDIRECT_FIRST_INSTANCE`] wood is not simplified, and leaves that have
    /// let go keep their outlines however small.
    ///
    /// # Errors
    ///
    /// [`ModelError`], if the tree is larger than the device or a shed rank can hold.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        tree: &Tree,
    ) -> Result<Self, ModelError> {
        let leaves = tree.foliage.leaves.len();
        if leaves > MOST_LEAVES {
            let name = tree.name.clone();
            return Err(ModelError::TooManyLeaves { name, leaves, most: MOST_LEAVES });
        }
        // A draw that begins in the middle of a list is more than some devices can do.
        let first_instance = device.features().contains(wgpu::Features::INDIRECT_FIRST_INSTANCE);
        let leaf_mesh = LeafMesh::new(&tree.foliage);
        let whole = [WoodLevel { indices: tree.wood.indices.clone(), error: 0.0 }];
        let levels = match &tree.wood.levels[..] {
            [] => &whole[..],
            levels if first_instance => &levels[..levels.len().min(WOOD_LEVELS as usize)],
            levels => &levels[..1],
        };
        let branches = branches(&tree.wood);
        let wood_vertices: Vec<WoodVertex> =
            tree.wood.vertices.iter().zip(&branches).map(|(v, &b)| wood_vertex(v, b)).collect();
        let (wood_indices, wood_draws) = wood_draws(levels, &branches);
        let most = device.limits().max_buffer_size;
        for (part, bytes) in [
            ("leaves", bytemuck::cast_slice::<_, u8>(&leaf_mesh.vertices).len()),
            ("leaves", bytemuck::cast_slice::<_, u8>(&leaf_mesh.indices).len()),
            ("branches", bytemuck::cast_slice::<_, u8>(&wood_vertices).len()),
            ("branches", bytemuck::cast_slice::<_, u8>(&wood_indices).len()),
        ] {
            let bytes = bytes as u64;
            if bytes > most {
                return Err(ModelError::TooLarge { name: tree.name.clone(), part, bytes, most });
            }
        }
        let leaf_textures = TextureArray::new(device, queue, &tree.foliage.materials);
        let wood_textures = TextureArray::new(device, queue, &tree.wood.materials);
        let crown = crown(tree, levels);
        let mut uniform = model_uniform(tree, crown);
        uniform.texture_luminance = leaf_textures.luminance;
        let model = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some(&tree.name),
            contents: bytemuck::bytes_of(&uniform),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let layout = Layouts::part(device);
        let part = |vertices: &[u8], indices: &[u32], materials: &[Material], array: &_| {
            part(device, &layout, &model, vertices, indices, materials, array)
        };
        let wood_parts = wood_draws.map(|draws| wood_parts(&draws));
        // Small leaves in the air lie at the end of a list.
        let small = leaf_mesh.quads.as_ref().filter(|_| first_instance);
        let loose = LooseShapes::new(device, &tree.foliage, small);
        let data = ModelData {
            name: tree.name.clone(),
            leaf_count: leaves as u32,
            triangles: (tree.wood_triangles() + tree.foliage.triangle_count()) as u64,
            leaf_parts: leaf_parts(&leaf_mesh.starts, &leaf_mesh.simple_starts),
            wood_kinds: [0, 1].map(|kind| wood_parts[kind].len() as u32),
            wood_parts: wood_parts.concat(),
            outward: tree.wood.outward,
            crown,
            wood: part(
                bytemuck::cast_slice(&wood_vertices),
                &wood_indices,
                &tree.wood.materials,
                &wood_textures,
            ),
            leaves: part(
                bytemuck::cast_slice(&leaf_mesh.vertices),
                &leaf_mesh.indices,
                &tree.foliage.materials,
                &leaf_textures,
            ),
            quads: leaf_mesh.quads,
            uniform,
            loose,
            device: device.clone(),
        };
        Ok(Self { data: Arc::new(data) })
    }

    /// Name of the tree.
    pub fn name(&self) -> &str {
        &self.data.name
    }

    /// Its leaves.
    pub fn leaf_count(&self) -> u32 {
        self.data.leaf_count
    }
}

/// One for each vertex; thick ones for wood that was not prepared.
fn branches(wood: &tree::Wood) -> Vec<Branch> {
    if wood.branches.len() == wood.vertices.len() {
        return wood.branches.clone();
    }
    vec![Branch { radius: 1.0, vanishes: f32::MAX }; wood.vertices.len()]
}

/// Bytes of GPU memory that a tree model takes: buffers and textures with their mip maps.
pub fn model_bytes(tree: &Tree) -> u64 {
    let foliage = &tree.foliage;
    let leaves = LeafMesh::new(foliage);
    let buffers = leaves.vertices.len() * size_of::<LeafVertex>()
        + tree.wood.vertices.len() * size_of::<WoodVertex>()
        + (leaves.indices.len() + tree.wood.indices.len()) * size_of::<u32>()
        + size_of::<Model>();
    buffers as u64 + array_bytes(&foliage.materials) + array_bytes(&tree.wood.materials)
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

fn part(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    model: &wgpu::Buffer,
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
    let bind_group = layouts::group(
        device,
        "part of a tree",
        layout,
        &[
            model.as_entire_binding(),
            surfaces.as_entire_binding(),
            wgpu::BindingResource::TextureView(&array.view),
            wgpu::BindingResource::Sampler(&array.sampler),
        ],
    );
    Part {
        vertices: init(
            "vertices",
            vertices,
            wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::STORAGE,
        ),
        indices: init("indices", bytemuck::cast_slice(indices), wgpu::BufferUsages::INDEX),
        bind_group,
        masked: materials.iter().any(|m| m.alpha_cutoff.is_some()),
        textured: array.layers.iter().any(Option::is_some),
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

fn model_uniform(tree: &Tree, crown: Crown) -> Model {
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
        crown,
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
        leaf_lengths: pack_halfs(leaf_lengths(foliage)),
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
