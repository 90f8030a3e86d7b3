//! The lists of trees that are drawn: their tables on the GPU, and how a CPU makes the same lists.
//!
//! A model's leaves are drawn in parts, in prune order: [`WHOLE`] bounds a quarter of an octave
//! apart. A tree's *bucket* is the lowest bound that holds all leaves it is drawn with; one above all
//! holds trees that are so near that their leaves have outlines. Lists are
//! sorted by bucket, so that each part is one draw of a prefix of the model's trees, and the work
//! follows the leaves that are drawn, not the trees that there are. Wood has lists of its own: there a
//! bucket is a level of the simplified mesh, the finest the highest, drawn for a range of the list.

use crate::events::Thrown;
use crate::model::GpuModel;
use crate::pass::shadow::CASCADES;
use crate::shared::{Crown, CullFrame, TreeInstance, TreeList, TreeRecord};
use crate::view::{Culling, View};
use bytemuck::Zeroable;
use glam::{Mat3, Mat4, Vec2, Vec3};
use half::f16;
use std::f32::consts::PI;
use std::ops::Range;
use windfall_core::foliage::Holes;
use windfall_core::forest::{Forest, Frustum};
use windfall_core::shed::{Shedding, TreeShedding};
use windfall_core::simplify::{
    FadeRange, Level, Reduction, Seen, Shading, Simplification, Visibility,
};
use windfall_core::sway::farthest;

/// Buckets: the highest is that of leaves in their own shapes.
pub(crate) const BUCKETS: u32 = 50;
/// The bucket of the same that are lit at their vertices.
pub(crate) const AT_VERTICES: u32 = BUCKETS - 1;
/// The bucket of all leaves in simple shapes, the highest bound of parts.
pub(crate) const WHOLE: u32 = AT_VERTICES - 1;
/// Parts of all leaves, before those of simplified trees.
pub(crate) const WHOLE_PARTS: u32 = 3;
/// Bounds in a factor of two.
pub(crate) const OCTAVE: f32 = 4.0;
/// Trees of a block.
pub(crate) const BLOCK: u32 = 64;
/// What a frame is drawn for: the view and the shadow maps.
pub(crate) const VIEWS: usize = 1 + CASCADES;
/// Lists of a frame: those for leaves, then those for wood.
pub(crate) const LISTS: usize = 2 * VIEWS;
/// Most levels of wood.
pub(crate) const WOOD_LEVELS: usize = 16;
/// Leaves below which a part is not worth a draw of its own.
const FEW_LEAVES: u32 = 64;
/// Words that count, behind the arguments: two each for trees in view, their leaves, leaves by λ,
/// leaves on twigs, triangles.
pub(crate) const TALLIES: u64 = 10;

/// A part of a model that is drawn for the trees of some buckets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PartDraw {
    /// Lowest and highest bucket.
    pub buckets: (u32, u32),
    /// Indices of the part.
    pub indices: (u32, u32),
}

/// The bucket of a tree that is drawn with this share of its leaves, in simple shapes.
pub(crate) fn bucket_of(drawn: f32) -> u32 {
    let step = WHOLE as f32 + (OCTAVE * drawn.max(1e-9).log2()).ceil();
    step.clamp(1.0, WHOLE as f32) as u32
}

/// The bucket of a tree's leaves.
fn leaf_bucket(detail: &Simplification, level: &Level, seen: &Seen) -> u32 {
    if detail.simple(level, seen) {
        bucket_of(detail.drawn(level))
    } else if detail.lit_at_vertices(level, seen) {
        AT_VERTICES
    } else {
        BUCKETS
    }
}

/// The largest share of leaves that trees of a bucket are drawn with.
pub(crate) fn bucket_share(bucket: u32) -> f32 {
    ((bucket as f32 - WHOLE as f32) / OCTAVE).exp2().min(1.0)
}

/// The parts of a model's leaves: all of them in their own shapes, the same to be lit at their vertices, all
/// in simple ones, then those of simplified trees. `starts` has the first index of each leaf and the end of
/// the last, `simple_starts` those of the same leaves in few triangles. Where draws cannot begin in the
/// middle of a list, the last parts are for all trees, and the first are empty.
pub(crate) fn leaf_parts(
    starts: &[u32],
    simple_starts: &[u32],
    first_instance: bool,
) -> Vec<PartDraw> {
    let leaves = starts.len() as u32 - 1;
    if leaves == 0 {
        return Vec::new();
    }
    let all = |starts: &[u32]| {
        let count = starts[leaves as usize] - starts[0];
        (starts[0], if first_instance { count } else { 0 })
    };
    let mut parts = vec![
        PartDraw { buckets: (BUCKETS, BUCKETS), indices: all(starts) },
        PartDraw { buckets: (AT_VERTICES, AT_VERTICES), indices: all(starts) },
        PartDraw { buckets: (WHOLE, WHOLE), indices: all(simple_starts) },
    ];
    let high = if first_instance { WHOLE - 1 } else { BUCKETS };
    let (mut low, mut first) = (1, 0);
    for bucket in 1..=high {
        let end = (f64::from(bucket_share(bucket)) * f64::from(leaves)).ceil() as u32;
        if end - first >= FEW_LEAVES || (bucket == high && end > first) {
            let [a, b] = [first, end].map(|leaf| simple_starts[leaf as usize]);
            parts.push(PartDraw { buckets: (low, high), indices: (a, b - a) });
            (low, first) = (bucket + 1, end);
        }
    }
    parts
}

/// The bucket of a tree that is drawn with this level of its wood.
pub(crate) fn wood_bucket(level: u32) -> u32 {
    BUCKETS - level
}

/// Ranges of indices of levels of a model's wood.
pub(crate) fn wood_parts(levels: &[(u32, (u32, u32))]) -> Vec<PartDraw> {
    let parts = levels.iter().map(|&(level, indices)| {
        let bucket = wood_bucket(level);
        PartDraw { buckets: (bucket, bucket), indices }
    });
    parts.filter(|part| part.indices.1 > 0).collect()
}

impl TreeList {
    /// The trees of `clip_from_world` that are seen from the view's camera.
    pub(crate) fn new(
        clip_from_world: Mat4,
        view: &View,
        height: u32,
        detail: &Simplification,
        culling: Culling,
    ) -> Self {
        let (range_kind, range) = match detail.fade.range {
            FadeRange::Constant(c) => (0, c),
            FadeRange::Linear(c) => (1, c),
            FadeRange::Quadratic(c) => (2, c),
            FadeRange::Proportional(c) => (3, c),
        };
        let (by_area, reduction) = match detail.reduction {
            Reduction::Distance { d0 } => (0, d0 * d0),
            Reduction::ProjectedArea { b0 } => (1, PI / b0),
        };
        let flag = |on: bool| u32::from(on);
        Self {
            planes: Frustum::new(clip_from_world).planes(),
            clip_from_world,
            eye: view.camera.eye,
            pixels: view.camera.pixels(height),
            exponent: detail.exponent(),
            reduction,
            contrast_pixels: detail.contrast_pixels.unwrap_or(0.0),
            range_kind,
            range,
            growth_factor: if detail.area_preservation { detail.growth.factor } else { -1.0 },
            growth_pixels: detail.growth.pixels,
            flags: flag(detail.fade.full_at_one) | flag(detail.fade.early) << 1 | by_area << 2,
            culling: culling as u32,
            wood_pixels: detail.wood_pixels,
            leaf_pixels: detail.leaf_pixels,
            mean_cosine: detail.mean_cosine.unwrap_or(-1.0),
        }
    }
}

/// The trees of a forest and the tables that lists are made from.
pub(crate) struct Trees {
    pub crowns: Vec<Crown>,
    /// By model, each model's in whole blocks.
    pub records: Vec<TreeRecord>,
    /// For each model its leaf draws and its wood draws: ranges of all draws.
    pub draws: Vec<(Range<u32>, Range<u32>)>,
    pub parts: Vec<PartDraw>,
}

/// What a CPU finds of a list.
#[derive(Debug, Default)]
pub(crate) struct CpuList {
    /// Trees at their places; those of a model begin at [`Crown::tree_first`].
    pub placed: Vec<TreeInstance>,
    /// For each draw the trees of the model that it is for.
    pub instances: Vec<Range<u32>>,
    /// Trees, their leaves, leaves by λ, leaves on twigs, triangles.
    pub tallies: [u64; 5],
}

impl Trees {
    pub fn new(
        models: &[GpuModel],
        forest: &Forest,
        falls: &crate::Falls,
        thrown: &Thrown,
    ) -> Self {
        let mut out =
            Self { crowns: Vec::new(), records: Vec::new(), draws: Vec::new(), parts: Vec::new() };
        for (index, model) in models.iter().enumerate() {
            let first = out.records.len() as u32;
            let instances = (0..).zip(&forest.instances);
            let of_model = instances.filter(|(_, instance)| instance.model as usize == index);
            out.records.extend(of_model.map(|(at, instance)| {
                let shed = falls.shedding.tree(instance, model.leaf_count, &falls.wind);
                let (sin_yaw, cos_yaw) = instance.yaw.sin_cos();
                TreeRecord {
                    position: instance.position,
                    scale: instance.scale,
                    cos_yaw,
                    sin_yaw,
                    season_offset: instance.season_offset,
                    delay: shed.delay,
                    gust_phase: shed.gust_phase,
                    seed: instance.seed,
                    model: index as u32,
                    events: thrown.root(at),
                }
            }));
            let nothing = TreeRecord { model: u32::MAX, ..TreeRecord::zeroed() };
            out.records.resize(out.records.len().next_multiple_of(BLOCK as usize), nothing);
            let draw_first = out.parts.len() as u32;
            out.parts.extend(&model.leaf_parts);
            let wood_first = out.parts.len() as u32;
            out.parts.extend(&model.wood_parts);
            let end = out.parts.len() as u32;
            out.draws.push((draw_first..wood_first, wood_first..end));
            out.crowns.push(Crown {
                tree_first: first,
                draw_first,
                draw_count: end - draw_first,
                leaf_draws: wood_first - draw_first,
                block_count: (out.records.len() as u32 - first) / BLOCK,
                ..model.crown
            });
        }
        out
    }

    /// The frame's numbers.
    pub fn frame(&self, lists: &[TreeList; VIEWS], view: &View, size: (u32, u32)) -> CullFrame {
        CullFrame {
            lists: *lists,
            near: view.camera.near,
            width: size.0 as f32,
            height: size.1 as f32,
            tree_count: self.records.len() as u32,
            model_count: self.crowns.len() as u32,
            draw_count: self.parts.len() as u32,
            top_level: 0,
            wind_speed: 0.0,
        }
    }

    /// Makes a list as the GPU does: the same trees in the same places. Of the wind it takes a bound of the
    /// speed, and the velocity.
    pub fn list_on_cpu(
        &self,
        list: &TreeList,
        wood: bool,
        detail: &Simplification,
        detached: impl Fn(&TreeRecord, u32) -> u32,
        wind: &(f32, impl Fn(Vec3) -> Vec2),
        sun: Vec3,
    ) -> CpuList {
        let (wind_speed, wind_at) = wind;
        let frustum = Frustum::new(list.clip_from_world);
        let mut out = CpuList {
            placed: vec![TreeInstance::zeroed(); self.records.len()],
            ..CpuList::default()
        };
        for crown in &self.crowns {
            let first = crown.tree_first as usize;
            let records = &self.records[first..first + (crown.block_count * BLOCK) as usize];
            let mut sorted: Vec<(u32, Level, &TreeRecord)> = Vec::new();
            for tree in records.iter().filter(|tree| tree.model != u32::MAX) {
                let center = tree.world_from_tree(crown.center);
                let seen = crown.seen(tree, list, center);
                let mut level = detail.level(&seen);
                let margin = crown.margin(tree.scale, level.growth, *wind_speed);
                let in_view = match list.culling {
                    0 => true,
                    1 => list.sees_box(tree, crown, margin),
                    _ => frustum.sees_sphere(center, crown.radius * tree.scale + margin),
                };
                if in_view {
                    let bucket = if wood {
                        level.growth = detail.wood_error(&seen) / tree.scale;
                        wood_bucket(crown.wood_level(level.growth))
                    } else {
                        leaf_bucket(detail, &level, &seen)
                    };
                    sorted.push((bucket, level, tree));
                }
            }
            sorted.sort_by_key(|tree| std::cmp::Reverse(tree.0));
            for (at, (_, level, tree)) in sorted.iter().enumerate() {
                let detached = detached(tree, crown.leaf_count);
                out.placed[first + at] = TreeInstance {
                    position: tree.position,
                    scale: tree.scale,
                    cos_yaw: tree.cos_yaw,
                    sin_yaw: tree.sin_yaw,
                    season_offset: tree.season_offset,
                    lambda: level.lambda,
                    fade_end: level.lambda + if list.flags & 2 != 0 { 0.0 } else { level.radius },
                    fade_slope: 0.5 / level.radius.max(1e-9),
                    growth: level.growth,
                    contrast: level.contrast,
                    seed: tree.seed,
                    detached: detached | tree.events << 24,
                    wind: pack_halfs(wind_at(tree.position)),
                    mean_cosines: pack_halfs(match detail.mean_cosine {
                        Some(mean) => Vec2::splat(0.5 * mean),
                        None => crown.mean_cosines(tree, sun, list.eye),
                    }),
                };
                let leaves = crown.leaf_count as f32;
                let hanging = 1.0 - detached as f32 / leaves.max(1.0);
                let drawn = detail.drawn(level) * leaves * hanging;
                out.tallies[0] += 1;
                out.tallies[1] += u64::from(crown.leaf_count);
                out.tallies[2] += (level.lambda * leaves + 0.5) as u64;
                out.tallies[3] += (drawn + 0.5) as u64;
            }
            for draw in 0..crown.draw_count {
                let part = &self.parts[(crown.draw_first + draw) as usize];
                let from = |bucket: u32| sorted.partition_point(|t| t.0 >= bucket) as u32;
                let of_list = (draw >= crown.leaf_draws) == wood;
                let range = from(part.buckets.1 + 1)..from(part.buckets.0);
                let range = if of_list { range } else { 0..0 };
                out.tallies[4] += u64::from(part.indices.1 / 3) * range.len() as u64;
                out.instances.push(range);
            }
        }
        out
    }
}

/// Two numbers as `unpack2x16float` has them.
pub(crate) fn pack_halfs(v: Vec2) -> u32 {
    let [x, y] = v.to_array().map(|v| u32::from(f16::from_f32(v).to_bits()));
    x | y << 16
}

impl Crown {
    /// Of the sun on the leaves of a tree that is looked at from `eye`.
    fn mean_cosines(&self, tree: &TreeRecord, sun: Vec3, eye: Vec3) -> Vec2 {
        let [s, p] = [self.normal_squares, self.normal_products * 0.5];
        let normals = Mat3::from_cols(
            Vec3::new(s.x, p.x, p.z),
            Vec3::new(p.x, s.y, p.y),
            Vec3::new(p.z, p.y, s.z),
        );
        let view = (eye - tree.world_from_tree(self.center)).normalize_or(Vec3::Y);
        let [light, view] = [sun, view].map(|v| tree.turned_back(v));
        Shading { normals, ..Shading::default() }.mean_cosines(light, view).into()
    }

    /// The coarsest level of wood within an error, metres.
    fn wood_level(&self, error: f32) -> u32 {
        let mut level = 1;
        while level < self.wood_levels
            && self.wood_errors[level as usize / 4][level as usize % 4] <= error
        {
            level += 1;
        }
        level - 1
    }

    /// How far leaves of a tree may be beyond its bounds, metres: as they have grown, and by the wind.
    fn margin(&self, scale: f32, growth: f32, wind_speed: f32) -> f32 {
        (growth - 1.0) * self.leaf_length * scale + farthest(wind_speed, 2.0 * self.radius * scale)
    }

    fn seen(&self, tree: &TreeRecord, list: &TreeList, center: Vec3) -> Seen {
        let [solid, piece] = [0, 16].map(|shift| f16::from_bits((self.holes >> shift) as u16));
        Seen {
            distance: center.distance(list.eye),
            pixels: list.pixels,
            radius: self.radius * tree.scale,
            leaf_length: self.leaf_length * tree.scale,
            leaf_side: self.leaf_side * tree.scale,
            holes: Holes { solid: solid.to_f32(), piece: piece.to_f32() },
            visibility: Visibility {
                share: self.visible_share,
                disocclusion: self.disocclusion.to_array(),
                ..Visibility::default()
            },
        }
    }
}

impl TreeRecord {
    pub(crate) fn world_from_tree(&self, v: Vec3) -> Vec3 {
        let (c, s) = (self.cos_yaw, self.sin_yaw);
        let turned = Vec3::new(c * v.x + s * v.z, v.y, c * v.z - s * v.x);
        self.position + turned * self.scale
    }

    /// A direction of the world in the tree.
    fn turned_back(&self, v: Vec3) -> Vec3 {
        let (c, s) = (self.cos_yaw, self.sin_yaw);
        Vec3::new(c * v.x - s * v.z, v.y, c * v.z + s * v.x)
    }

    /// What its detach times depend on.
    pub(crate) fn shedding(&self, leaves: u32) -> TreeShedding {
        TreeShedding { delay: self.delay, gust_phase: self.gust_phase, seed: self.seed, leaves }
    }

    /// Leaves that have left the tree by `time`.
    pub(crate) fn detached(
        &self,
        shedding: &Shedding,
        gust_rate: f32,
        leaves: u32,
        time: f32,
    ) -> u32 {
        shedding.detached(&self.shedding(leaves), gust_rate, time)
    }
}

impl TreeList {
    /// Whether no plane of clip space has the whole bounding box outside (SFS, 4.2).
    fn sees_box(&self, tree: &TreeRecord, crown: &Crown, margin: f32) -> bool {
        let half_size = crown.half_size + margin / tree.scale;
        let corners = (0..8).map(|corner| {
            let side =
                Vec3::new((corner & 1) as f32, (corner >> 1 & 1) as f32, (corner >> 2) as f32)
                    * 2.0
                    - 1.0;
            let at = tree.world_from_tree(crown.center + side * half_size);
            self.clip_from_world * at.extend(1.0)
        });
        let mut outside = [0; 5];
        for at in corners {
            let planes = [at.x < -at.w, at.x > at.w, at.y < -at.w, at.y > at.w, at.z > at.w];
            for (count, out) in outside.iter_mut().zip(planes) {
                *count += u32::from(out);
            }
        }
        outside.iter().all(|&count| count < 8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Camera, Falls, GpuForest, Renderer, Target};
    use std::collections::HashMap;
    use wgpu_profiler::{GpuProfiler, GpuProfilerSettings};
    use windfall_core::forest::{Placement, Terrain};
    use windfall_core::simplify::{Fade, FadeBy, Growth, SIMPLE_BELOW};
    use windfall_core::tree::Tree;
    use windfall_core::tree::species::Species;

    #[test]
    fn buckets_hold_what_is_drawn_and_little_more() {
        for drawn in [1.0, 0.999, 0.5, 0.3, 0.06, 0.001, 1e-5, 0.0, f32::NAN] {
            let bucket = bucket_of(drawn);
            assert!((1..=WHOLE).contains(&bucket), "{drawn}: {bucket}");
            if drawn > bucket_share(1) {
                let share = bucket_share(bucket);
                assert!(share >= drawn * 0.9999 && share < drawn * 1.19, "{drawn}: {share}");
            }
        }
    }

    #[test]
    fn simple_shapes_begin_with_the_first_step() {
        assert_eq!(bucket_of(0.9999 * SIMPLE_BELOW), WHOLE - 1);
        assert_eq!(bucket_of(1.0001 * SIMPLE_BELOW), WHOLE);
    }

    #[test]
    fn parts_are_each_leaf_once() {
        for leaves in [0u32, 1, 63, 64, 65, 1000, 20_000] {
            // Leaves of three and six indices in turn.
            let starts: Vec<u32> = (0..=leaves).map(|i| i / 2 * 9 + i % 2 * 3).collect();
            // Behind them the same leaves of two triangles each.
            let simple: Vec<u32> = (0..=leaves).map(|i| starts[leaves as usize] + 6 * i).collect();
            for (first_instance, starts) in [(true, &simple), (false, &starts)] {
                let parts = leaf_parts(&starts[..], starts, first_instance);
                let high = if first_instance { WHOLE - 1 } else { BUCKETS };
                let mut end = starts[0];
                let mut low = 0;
                for part in parts.iter().skip(WHOLE_PARTS as usize) {
                    assert_eq!(part.indices.0, end, "{leaves}: {parts:?}");
                    assert!(part.indices.1 > 0 && part.buckets.0 > low && part.buckets.1 == high);
                    (end, low) = (part.indices.0 + part.indices.1, part.buckets.0);
                }
                let most = (f64::from(bucket_share(high)) * f64::from(leaves)).ceil() as usize;
                assert_eq!(end, starts[most]);
            }
            let parts = leaf_parts(&starts, &simple, true);
            let all = [starts[leaves as usize], starts[leaves as usize], 6 * leaves];
            let whole = parts.iter().take(3).zip(all);
            assert!(whole.clone().all(|(part, all)| part.indices.1 == all), "{parts:?}");
            assert_eq!(whole.count(), if leaves > 0 { 3 } else { 0 });
            // Trees of any bucket are drawn with the leaves that they need.
            for bucket in 1..WHOLE {
                let drawn: u32 = parts[3.min(parts.len())..]
                    .iter()
                    .filter(|p| p.buckets.0 <= bucket)
                    .map(|p| p.indices.1)
                    .sum();
                let needed = (f64::from(bucket_share(bucket)) * f64::from(leaves)).floor() as usize;
                let least = if needed >= 64 { 6 * needed as u32 } else { 0 };
                assert!(drawn >= least, "{leaves} leaves, bucket {bucket}: {drawn} of {least}");
            }
        }
    }

    #[test]
    fn each_level_of_wood_has_a_bucket() {
        let parts = wood_parts(&[(0, (0, 3000)), (1, (3000, 1500)), (2, (4500, 300))]);
        assert_eq!(parts.len(), 3);
        assert_eq!(parts[2], PartDraw { buckets: (48, 48), indices: (4500, 300) });
        assert_eq!(wood_parts(&[(0, (0, 0))]), []);
    }

    /// Every way of simplifying and culling, from the middle of a forest.
    #[test]
    fn the_gpu_makes_the_lists_of_the_cpu() {
        let (device, queue) = windfall_testing::device();
        let settings = GpuProfilerSettings { enable_timer_queries: false, ..Default::default() };
        let profiler = GpuProfiler::new(&device, settings).unwrap();
        let picture = windfall_testing::picture(&device, (64, 48));
        let renderer = Renderer::new(&device, picture.format());
        let canvas = renderer.canvas(&device, 64, 48);
        let trees: Vec<Tree> =
            [Species::Birch, Species::Oak].iter().map(|s| s.grow_with(1, 300)).collect();
        let placement = Placement {
            trees: 300,
            spacing: 7.0,
            keep_out: Vec::new(),
            scale: (0.7, 1.3),
            season_spread: 0.2,
            seed: 11,
        };
        let placed = placement.place(Terrain::rolling(500.0, 6.0, 2), &[1.0, 2.0]);
        let mut forest =
            GpuForest::with_falls(&device, &queue, &renderer, &trees, &placed, &Falls::default());
        // Draws of leaves that have become quads are emptied.
        forest.quads = None;
        let near = Simplification {
            reduction: Reduction::Distance { d0: 12.0 },
            h: 0.6,
            growth: Growth::UNBOUNDED,
            fade: Fade { range: FadeRange::Linear(0.1), early: true, ..Fade::default() },
            ..Simplification::DEFAULT
        };
        let by_area = Simplification {
            reduction: Reduction::ProjectedArea { b0: 2000.0 },
            color_contrast: false,
            contrast_pixels: None,
            fade: Fade { by: FadeBy::Opacity, full_at_one: false, ..Fade::default() },
            ..near
        };
        let camera =
            Camera { eye: Vec3::new(5.0, 9.0, 30.0), target: Vec3::ZERO, fov_y: 0.9, near: 0.1 };
        let mut simplified = 0;
        for detail in [Simplification::DEFAULT, near, by_area, Simplification::NONE] {
            for culling in [Culling::Off, Culling::ClipSpace, Culling::Sphere] {
                let view = View { detail, culling, time: 120.0, ..View::new(camera) };
                let mut encoder = device.create_command_encoder(&Default::default());
                let picture = picture.create_view(&Default::default());
                let target = Target { canvas: &canvas, picture: &picture };
                renderer.render(&queue, &mut encoder, &profiler, &forest, &view, target);
                queue.submit([encoder.finish()]);
                let read = |buffer| windfall_testing::read(&device, &queue, buffer);
                let on_gpu: Vec<TreeInstance> =
                    bytemuck::pod_collect_to_vec(&read(&forest.lists.placed));
                let words: Vec<u32> = bytemuck::pod_collect_to_vec(&read(&forest.lists.arguments));

                let clip_from_world = camera.clip_from_world(64.0 / 48.0);
                let list = TreeList::new(clip_from_world, &view, 48, &detail, culling);
                let mut tallies = [0; 5];
                for wood in [false, true] {
                    let on_cpu = forest.list_on_cpu(&list, wood, &detail, &view);
                    assert!(on_cpu.tallies[0] > 50);
                    let index = if wood { VIEWS } else { 0 };
                    let (places, draws) = (forest.trees.records.len(), forest.trees.parts.len());
                    let on_gpu = &on_gpu[index * places..(index + 1) * places];
                    let words = &words[5 * index * draws..5 * (index + 1) * draws];
                    simplified += compare(&forest, &on_cpu, wood, on_gpu, words);
                    if wood {
                        tallies[4] += on_cpu.tallies[4];
                    } else {
                        tallies = on_cpu.tallies;
                    }
                }
                let counted = |i: usize| {
                    let at = words.len() - TALLIES as usize + 2 * i;
                    u64::from(words[at]) | u64::from(words[at + 1]) << 32
                };
                for (i, &wanted) in tallies.iter().enumerate() {
                    let apart = counted(i).abs_diff(wanted) as f64 / wanted as f64;
                    assert!(apart < 5e-3, "tally {i}: {} for {wanted}", counted(i));
                }
            }
        }
        assert!(simplified > 300, "{simplified}");
    }

    fn unpack_halfs(v: u32) -> Vec2 {
        Vec2::new(f16::from_bits(v as u16).into(), f16::from_bits((v >> 16) as u16).into())
    }

    /// Holds a list of the GPU against the CPU's; how many of its trees are simplified.
    fn compare(
        forest: &GpuForest,
        on_cpu: &CpuList,
        wood: bool,
        on_gpu: &[TreeInstance],
        words: &[u32],
    ) -> u32 {
        let mut simplified = 0;
        for (m, crown) in forest.trees.crowns.iter().enumerate() {
            let (leaf_draws, wood_draws) = forest.trees.draws[m].clone();
            let draws = if wood { wood_draws } else { leaf_draws };
            let mut count = 0;
            for i in draws.start as usize..draws.end as usize {
                let range = &on_cpu.instances[i];
                let [indices, instances, first, _, begin] =
                    [0, 1, 2, 3, 4].map(|word| words[5 * i + word]);
                assert_eq!((first, indices), forest.trees.parts[i].indices);
                // A tree at the bound of two buckets may be in either.
                let [a, b] = [begin.abs_diff(range.start), instances.abs_diff(range.len() as u32)];
                assert!(a <= 1 && b <= 1, "draw {i}: {begin} {instances}, not {range:?}");
                count = count.max(range.end as usize);
            }
            let first = crown.tree_first as usize;
            let expected: HashMap<u32, &TreeInstance> =
                on_cpu.placed[first..first + count].iter().map(|t| (t.seed, t)).collect();
            for tree in &on_gpu[first..first + count] {
                let wanted = expected[&tree.seed];
                let near = |a: f32, b: f32| (a - b).abs() <= 1e-4 + 2e-3 * b.abs();
                assert!(
                    near(tree.lambda, wanted.lambda)
                        && near(tree.fade_end, wanted.fade_end)
                        && near(tree.fade_slope, wanted.fade_slope)
                        && near(tree.growth, wanted.growth)
                        && near(tree.contrast, wanted.contrast)
                        && tree.detached.abs_diff(wanted.detached) <= 1
                        && unpack_halfs(tree.mean_cosines)
                            .distance(unpack_halfs(wanted.mean_cosines))
                            < 0.01
                        && unpack_halfs(tree.wind).distance(unpack_halfs(wanted.wind)) < 0.01,
                    "{tree:?}\nis not\n{wanted:?}"
                );
                simplified += u32::from(tree.lambda < 1.0 && tree.growth > 1.0);
            }
            if !wood {
                let buckets = on_gpu[first..first + count].iter().map(|t| bucket_of(t.fade_end));
                assert!(buckets.rev().is_sorted(), "the more detailed first");
            }
        }
        simplified
    }
}
