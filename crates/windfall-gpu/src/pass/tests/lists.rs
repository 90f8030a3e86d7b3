//! Lists of trees against a CPU reference: which trees, in which detail, and the arguments of their draws.

use super::{Gpu, Watched};
use crate::base::constants::{
    BLOCK, DRAW_WORDS, KINDS, LISTS, OUTLINES, PIXELS, SIMPLE, TREE_TALLIES, VIEWS, WOOD,
};
use crate::base::packing::pack_halfs;
use crate::base::shared::{Crown, TreeInstance, TreeList, TreeRecord};
use crate::scene::parts::{bucket_of, wood_bucket};
use crate::scene::trees::TreeTables;
use crate::{Camera, Culling, Falls, Light, View};
use bytemuck::Zeroable;
use glam::{DVec3, Mat3, Vec2, Vec3, Vec3Swizzles};
use half::f16;
use std::collections::HashMap;
use std::ops::Range;
use windfall_core::foliage::Holes;
use windfall_core::forest::{Frustum, Placement, Terrain};
use windfall_core::shed::{Shedding, TreeShedding};
use windfall_core::simplify::{
    Fade, FadeBy, FadeRange, Growth, Level, Reduction, Seen, Shading, Simplification, Visibility,
};
use windfall_core::sway::farthest;
use windfall_tree::Species;

/// Whether a tree may have leaves of a kind.
fn has_some(kind: u32, detail: &Simplification, level: &Level, seen: &Seen) -> bool {
    let [low, high] = detail.leaf_range(level, seen);
    let lit = detail.lit_leaf_pixels(true);
    match kind {
        PIXELS => high >= lit,
        OUTLINES => high >= detail.leaf_pixels && low < lit,
        SIMPLE => low < detail.leaf_pixels,
        _ => true,
    }
}

/// What a CPU finds of a list.
#[derive(Debug, Default)]
struct CpuList {
    /// Trees at their places; those of a model begin at [`Crown::tree_first`].
    pub placed: Vec<TreeInstance>,
    /// For each draw the trees of the model that it is for.
    pub instances: Vec<Range<u32>>,
    /// Trees, their leaves, leaves by λ, leaves on twigs, triangles.
    pub tallies: [u64; 5],
}

/// The CPU reference of `pass/cull.wgsl`: the same trees in the same places. `wind` is (maximum speed, velocity).
fn list_on_cpu(
    tables: &TreeTables,
    list: &TreeList,
    kind: u32,
    detail: &Simplification,
    detached: impl Fn(&TreeRecord, u32) -> u32,
    wind: &(f32, impl Fn(Vec3) -> Vec2),
    sun: Vec3,
) -> CpuList {
    let (wind_speed, wind_at) = wind;
    let frustum = Frustum::new(list.clip_from_world);
    let mut out = CpuList {
        placed: vec![TreeInstance::zeroed(); tables.records.len()],
        ..CpuList::default()
    };
    for crown in &tables.crowns {
        let first = crown.tree_first as usize;
        let records = &tables.records[first..first + (crown.block_count * BLOCK) as usize];
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
            if in_view && has_some(kind, detail, &level, &seen) {
                let bucket = if kind == WOOD {
                    level.growth = detail.wood_error(&seen) / tree.scale;
                    wood_bucket(crown.wood_level(level.growth))
                } else {
                    bucket_of(detail.drawn(&level))
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
                detached: detached | (tree.index_events & 1) << 24,
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
            let part = &tables.parts[(crown.draw_first + draw) as usize];
            let from = |bucket: u32| sorted.partition_point(|t| t.0 >= bucket) as u32;
            let of_list = part.kind == if kind == PIXELS { OUTLINES } else { kind };
            let range = from(part.buckets.1 + 1)..from(part.buckets.0);
            let range = if of_list { range } else { 0..0 };
            out.tallies[4] += u64::from(part.indices.1 / 3) * range.len() as u64;
            out.instances.push(range);
        }
    }
    out
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
            leaf_lengths: [0, 16].map(|shift| {
                f16::from_bits((self.leaf_lengths >> shift) as u16).to_f32() * tree.scale
            }),
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
    /// A direction of the world in the tree.
    fn turned_back(&self, v: Vec3) -> Vec3 {
        let (c, s) = (self.cos_yaw, self.sin_yaw);
        Vec3::new(c * v.x - s * v.z, v.y, c * v.z + s * v.x)
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

/// Every way of simplifying and culling, from the middle of a forest.
#[test]
fn the_gpu_makes_the_lists_of_the_cpu() {
    let gpu = Gpu::get();
    let trees = [Species::Birch, Species::Oak].map(|s| s.grow_with(1, 300));
    let placement = Placement {
        trees: 300,
        spacing: 7.0,
        scale: (0.7, 1.3),
        season_spread: 0.2,
        seed: 11,
        ..Placement::default()
    };
    let placed = placement.place(Terrain::rolling(500.0, 6.0, 2), &[1.0, 2.0]);
    let mut watched = Watched::new(gpu, DVec3::ZERO, &trees, &placed, Falls::default());
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
    let camera = Camera::look_at(DVec3::new(5.0, 9.0, 30.0), DVec3::ZERO, 0.9, 0.1);
    let eye = camera.eye(DVec3::ZERO, (64, 48)).unwrap();
    let (mut simplified, mut in_lists) = (0, [0; KINDS as usize]);
    for detail in [Simplification::DEFAULT, near, by_area, Simplification::NONE] {
        for culling in [Culling::Off, Culling::ClipSpace, Culling::Sphere] {
            let view = View { detail, culling, ..View::new(camera) };
            // Draws of leaves that have become quads are emptied.
            watched.without_quads(gpu, &view);
            watched.draw(gpu, 120.0, &view, (64, 48));
            let (forest, lists) = (&watched.forest, &watched.state.buffers.as_ref().unwrap().lists);
            let tables = &forest.buffers().unwrap().tables;
            let on_gpu: Vec<TreeInstance> = bytemuck::pod_collect_to_vec(&gpu.read(&lists.placed));
            let words: Vec<u32> = bytemuck::pod_collect_to_vec(&gpu.read(&lists.arguments));
            let list = TreeList::new(eye.clip_from_world, &eye, &detail, culling, true);
            let (wind, shedding) = (*forest.wind(), forest.falls().shedding);
            let rate = Shedding::gust_rate(&wind);
            let detached = |tree: &TreeRecord, leaves: u32| {
                let of = TreeShedding {
                    delay: tree.delay,
                    gust_phase: tree.gust_phase,
                    seed: tree.seed,
                    leaves,
                };
                shedding.detached(&of, rate, 120.0)
            };
            let wind = &(wind.fastest(), |at: Vec3| wind.velocity(at, 120.0).xz());
            let Light::Sky(sky, _) = &view.light else { unreachable!() };
            let mut tallies = [0; 5];
            for kind in 0..KINDS {
                let on_cpu =
                    list_on_cpu(tables, &list, kind, &detail, detached, wind, sky.sun_direction());
                in_lists[kind as usize] += on_cpu.tallies[0];
                let index = (kind * VIEWS) as usize;
                let (places, draws) = (tables.records.len(), tables.parts.len());
                let on_gpu = &on_gpu[index * places..(index + 1) * places];
                let words = &words[5 * index * draws..5 * (index + 1) * draws];
                simplified += compare(tables, &on_cpu, kind, on_gpu, words);
                let triangles = tallies[4] + on_cpu.tallies[4];
                tallies = on_cpu.tallies;
                tallies[4] = triangles;
            }
            assert!(tallies[0] > 50);
            let first = (LISTS * DRAW_WORDS) as usize * tables.parts.len();
            let counted = |i: usize| {
                let at = first + 2 * i;
                u64::from(words[at]) | u64::from(words[at + 1]) << 32
            };
            // Behind them are hidden trees.
            assert_eq!(TREE_TALLIES, 14);
            for (i, &wanted) in tallies.iter().enumerate() {
                let apart = counted(i).abs_diff(wanted) as f64 / wanted as f64;
                assert!(apart < 5e-3, "tally {i}: {} for {wanted}", counted(i));
            }
        }
    }
    assert!(simplified > 300, "{simplified}");
    assert!(in_lists.iter().all(|&trees| trees > 5), "{in_lists:?}");
}

fn unpack_halfs(v: u32) -> Vec2 {
    Vec2::new(f16::from_bits(v as u16).into(), f16::from_bits((v >> 16) as u16).into())
}

/// Holds a list of the GPU against the CPU's; how many of its trees are simplified.
fn compare(
    tables: &TreeTables,
    on_cpu: &CpuList,
    kind: u32,
    on_gpu: &[TreeInstance],
    words: &[u32],
) -> u32 {
    let mut simplified = 0;
    for (m, crown) in tables.crowns.iter().enumerate() {
        let ranges = tables.draws[m].clone();
        let draws = match kind {
            WOOD => ranges.wood,
            SIMPLE => ranges.simple,
            _ => ranges.outlines,
        };
        let mut count = 0;
        for i in draws.start as usize..draws.end as usize {
            let range = &on_cpu.instances[i];
            let [indices, instances, first, _, begin] =
                [0, 1, 2, 3, 4].map(|word| words[5 * i + word]);
            assert_eq!((first, indices), tables.parts[i].indices);
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
                    && unpack_halfs(tree.mean_cosines).distance(unpack_halfs(wanted.mean_cosines))
                        < 0.01
                    && unpack_halfs(tree.wind).distance(unpack_halfs(wanted.wind)) < 0.01,
                "{tree:?}\nis not\n{wanted:?}"
            );
            simplified += u32::from(tree.lambda < 1.0 && tree.growth > 1.0);
        }
        if kind != WOOD {
            let buckets = on_gpu[first..first + count].iter().map(|t| bucket_of(t.fade_end));
            assert!(buckets.rev().is_sorted(), "the more detailed first");
        }
    }
    simplified
}
