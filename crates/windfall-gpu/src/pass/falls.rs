//! Leaves in the air and on the ground, by compute: where they land, where they are, their draws.

use super::{
    Shaders, compose,
    draw::{Draw, DrawTarget},
};
use crate::falls::{GROUP, GpuFalls, List, ShapeVertex, TALLIES, THREADS};
use crate::forest::GpuForest;
use crate::shared::LooseLeaf;

pub(crate) struct Falls {
    pub layout: wgpu::BindGroupLayout,
    windows: wgpu::ComputePipeline,
    find: wgpu::ComputePipeline,
    land: wgpu::ComputePipeline,
    pose: wgpu::ComputePipeline,
    change: wgpu::ComputePipeline,
    solid: wgpu::RenderPipeline,
    masked: wgpu::RenderPipeline,
    /// Of leaves of a few pixels.
    small: wgpu::RenderPipeline,
    solid_shadow: wgpu::RenderPipeline,
    masked_shadow: wgpu::RenderPipeline,
}

const SHARED: [&str; 6] = [
    include_str!("../../shaders/shared/simplify.wgsl"),
    include_str!("../../shaders/shared/tables.wgsl"),
    include_str!("../../shaders/shared/shed.wgsl"),
    include_str!("../../shaders/shared/pose.wgsl"),
    include_str!("../../shaders/shared/loose.wgsl"),
    include_str!("../../shaders/shared/sight.wgsl"),
];

fn layout(device: &wgpu::Device, label: &str, writable: &[bool]) -> wgpu::BindGroupLayout {
    // Uniforms of the falls come first, then the tables; those of the lists of trees and the work last.
    let buffer =
        |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let uniform = buffer(wgpu::BufferBindingType::Uniform);
    let tables = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Uint,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let storage = |w: &bool| buffer(wgpu::BufferBindingType::Storage { read_only: !w });
    let entries: Vec<wgpu::BindGroupLayoutEntry> = [uniform, tables]
        .into_iter()
        .chain(writable.iter().map(storage))
        .chain([uniform, storage(&true)])
        .zip(0..)
        .map(|(ty, binding)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty,
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some(label),
        entries: &entries,
    })
}

/// Workgroups in a row of a dispatch: `ROW` in `shaders/falls.wgsl`.
const ROW: u32 = 32_768;

fn dispatch(pass: &mut wgpu::ComputePass<'_>, groups: u32) {
    pass.dispatch_workgroups(groups.min(ROW), groups.div_ceil(ROW), 1);
}

/// Posed leaves, an instance each.
pub(super) const LEAF: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: size_of::<LooseLeaf>() as u64,
    step_mode: wgpu::VertexStepMode::Instance,
    attributes: &wgpu::vertex_attr_array![
        3 => Float32x4, 4 => Snorm16x4, 5 => Unorm8x4, 6 => Uint32
    ],
};

/// A kernel of `shaders/falls.wgsl`, with leaf occlusion or without.
pub(super) fn kernel(
    shaders: &Shaders<'_>,
    layout: &wgpu::BindGroupLayout,
    label: &str,
    occlusion: bool,
) -> wgpu::ComputePipeline {
    let device = shaders.device;
    let falls = include_str!("../../shaders/falls.wgsl");
    let constants = format!("const TALLIES: u32 = {TALLIES}u;\nconst GROUP: u32 = {GROUP}u;\n");
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(
            compose(&[&SHARED[..], &[&constants, falls]].concat()).into(),
        ),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: &[Some(shaders.frame_layout), Some(layout)],
        immediate_size: 0,
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(label),
        layout: Some(&layout),
        module: &module,
        entry_point: Some(label),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants: &[("occlusion", f64::from(u8::from(occlusion)))],
            ..Default::default()
        },
        cache: None,
    })
}

impl Falls {
    pub fn new(shaders: &Shaders<'_>, part_layout: &wgpu::BindGroupLayout) -> Self {
        let device = shaders.device;
        let layout_falls = layout(device, "falls", &[false, false, false, false, true, true, true]);
        let compute = |label| kernel(shaders, &layout_falls, label, false);
        let draw = |label, fragment, target, lit_at_vertices| {
            shaders.pipeline(&Draw {
                label,
                source: include_str!("../../shaders/leaves.wgsl"),
                groups: &[part_layout],
                buffers: &[ShapeVertex::LAYOUT, LEAF],
                cull: None,
                vertex: "loose",
                fragment,
                target,
                constants: &[("lit_at_vertices", lit_at_vertices)],
            })
        };
        let radiance = DrawTarget::Radiance;
        Self {
            windows: compute("windows"),
            find: compute("find"),
            land: compute("land"),
            pose: compute("pose"),
            change: compute("change"),
            solid: draw("loose leaves", Some("solid"), radiance, 0.0),
            masked: draw("masked loose leaves", Some("masked"), radiance, 0.0),
            small: draw("small loose leaves", Some("small"), radiance, 1.0),
            solid_shadow: draw("loose leaf shadow", None, DrawTarget::Shadow, 0.0),
            masked_shadow: draw(
                "masked loose leaf shadow",
                Some("masked_shadow"),
                DrawTarget::Shadow,
                0.0,
            ),
            layout: layout_falls,
        }
    }

    /// Lists the leaves that have newly detached.
    pub fn find(&self, pass: &mut wgpu::ComputePass<'_>, falls: &GpuFalls) {
        pass.set_bind_group(1, &falls.bind_group, &[]);
        pass.set_pipeline(&self.windows);
        pass.dispatch_workgroups(falls.stream_count.div_ceil(THREADS), 1, 1);
        pass.set_pipeline(&self.find);
        dispatch(pass, falls.stream_count);
    }

    /// Finds where they will land.
    pub fn land(&self, pass: &mut wgpu::ComputePass<'_>, falls: &GpuFalls) {
        pass.set_bind_group(1, &falls.bind_group, &[]);
        pass.set_pipeline(falls.occlusion.as_ref().map_or(&self.land, |o| &o.land));
        pass.dispatch_workgroups_indirect(&falls.landings, 0);
    }

    /// Poses the leaves that leave their twigs, settle, or vanish.
    pub fn change(&self, pass: &mut wgpu::ComputePass<'_>, falls: &GpuFalls) {
        pass.set_bind_group(1, &falls.bind_group, &[]);
        pass.set_pipeline(falls.occlusion.as_ref().map_or(&self.change, |o| &o.change));
        pass.dispatch_workgroups_indirect(&falls.landings, 12);
    }

    /// Poses the loose leaves that fly or lie, and gathers those in view.
    pub fn pose(&self, pass: &mut wgpu::ComputePass<'_>, falls: &GpuFalls) {
        pass.set_bind_group(1, &falls.bind_group, &[]);
        pass.set_pipeline(falls.occlusion.as_ref().map_or(&self.pose, |o| &o.pose));
        dispatch(pass, falls.group_count);
    }

    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, forest: &GpuForest) {
        let lists = [List::Plain, List::Tested];
        let lists = if forest.falls.occlusion.is_some() { &lists[..] } else { &lists[..1] };
        draw_lists(pass, forest, lists, &self.solid, &self.masked);
        draw_small(pass, forest, &self.small);
    }

    /// What the camera does not see may yet cast shadows.
    pub fn draw_shadow(&self, pass: &mut wgpu::RenderPass<'_>, forest: &GpuForest) {
        let lists = [List::Plain, List::Tested, List::Skipped];
        let lists = if forest.falls.occlusion.is_some() { &lists[..] } else { &lists[..1] };
        draw_lists(pass, forest, lists, &self.solid_shadow, &self.masked_shadow);
        draw_small(pass, forest, &self.solid_shadow);
    }
}

fn draw_small(
    pass: &mut wgpu::RenderPass<'_>,
    forest: &GpuForest,
    pipeline: &wgpu::RenderPipeline,
) {
    let falls = &forest.falls;
    pass.set_pipeline(pipeline);
    for (i, bin) in falls.bins.iter().enumerate() {
        let Some(shape) = &bin.small else { continue };
        pass.set_bind_group(1, &forest.models[bin.model].leaves.bind_group, &[]);
        shape.set(pass);
        pass.set_vertex_buffer(1, falls.leaves_of(List::Plain, bin));
        pass.draw_indexed_indirect(&falls.counters, falls.small_arguments(i));
    }
}

pub(super) fn draw_lists(
    pass: &mut wgpu::RenderPass<'_>,
    forest: &GpuForest,
    lists: &[List],
    solid: &wgpu::RenderPipeline,
    masked: &wgpu::RenderPipeline,
) {
    let falls = &forest.falls;
    for (i, bin) in falls.bins.iter().enumerate() {
        let part = &forest.models[bin.model].leaves;
        pass.set_pipeline(if part.masked { masked } else { solid });
        pass.set_bind_group(1, &part.bind_group, &[]);
        bin.shape.set(pass);
        for &list in lists {
            pass.set_vertex_buffer(1, falls.leaves_of(list, bin));
            if list == List::Tested {
                pass.set_vertex_buffer(2, falls.tested_slots(bin));
            }
            pass.draw_indexed_indirect(&falls.counters, falls.arguments_of(list, i));
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::shared::LooseLeaf;
    use crate::{Camera, DetachEvent, Falls, GpuForest, Renderer, Target, View};
    use glam::{Quat, Vec3};
    use std::collections::HashMap;
    use wgpu_profiler::{GpuProfiler, GpuProfilerSettings};
    use windfall_core::forest::{Forest, Placement, Terrain};
    use windfall_core::path::{Fall, LeafFall, Phase};
    use windfall_core::rng::{hash, unit};
    use windfall_core::shed::Shedding;
    use windfall_core::simplify::Simplification;
    use windfall_core::tree::Tree;
    use windfall_core::tree::species::Species;
    use windfall_core::wind::Wind;

    struct Scene {
        trees: Vec<Tree>,
        forest: Forest,
        falls: Falls,
    }

    /// Two species on a hillside in a gusty wind; about a third of the leaves fall in 60 s.
    fn scene(capacity: u32) -> Scene {
        let trees = vec![Species::Birch.grow(1), Species::Oak.grow(2)];
        let placement = Placement {
            trees: 4,
            spacing: 9.0,
            keep_out: Vec::new(),
            scale: (0.8, 1.2),
            season_spread: 0.2,
            seed: 3,
        };
        let slope = Terrain::rolling(400.0, 12.0, 5);
        let mut falls = Falls {
            wind: Wind::new(2.0, 0.8, 0.8, 7),
            shedding: Shedding { start: 0.0, duration: 180.0, ..Shedding::default() },
            capacity,
            ..Falls::default()
        };
        falls.groups = trees.iter().map(|t| falls.group_for(t)).collect();
        Scene { forest: placement.place(slope, &[1.0, 1.0]), trees, falls }
    }

    struct Gpu {
        device: wgpu::Device,
        queue: wgpu::Queue,
        renderer: Renderer,
        forest: GpuForest,
    }

    impl Gpu {
        fn new(scene: &Scene) -> Self {
            let (device, queue) = windfall_testing::device();
            let renderer = Renderer::new(&device, wgpu::TextureFormat::Rgba8UnormSrgb);
            let forest = GpuForest::with_falls(
                &device,
                &queue,
                &renderer,
                &scene.trees,
                &scene.forest,
                &scene.falls,
            );
            Self { device, queue, renderer, forest }
        }

        /// Renders a moment from far away, everything in view; the loose leaves, and the tallies.
        fn loose_leaves(&self, time: f32) -> (Vec<LooseLeaf>, [u32; 5]) {
            self.leaves_of(time, 0.5)
        }

        fn leaves_of(&self, time: f32, season: f32) -> (Vec<LooseLeaf>, [u32; 5]) {
            let Self { device, queue, renderer, forest } = self;
            let canvas = renderer.canvas(device, 8, 8);
            let texture = windfall_testing::picture(device, (8, 8));
            let picture = texture.create_view(&Default::default());
            let camera = Camera {
                eye: Vec3::new(0.0, 1000.0, 3000.0),
                target: Vec3::ZERO,
                fov_y: 1.0,
                near: 0.1,
            };
            // The reference knows nothing of what the twig does before the leaf has left it.
            let quality = crate::Quality { sway: false, ..crate::Quality::LOW };
            let detail = Simplification::NONE;
            let view = View { time, season, shadows: false, quality, detail, ..View::new(camera) };
            let profiler = GpuProfiler::new(
                device,
                GpuProfilerSettings { enable_timer_queries: false, ..Default::default() },
            )
            .unwrap();
            let mut encoder = device.create_command_encoder(&Default::default());
            let target = Target { canvas: &canvas, picture: &picture };
            renderer.render(queue, &mut encoder, &profiler, forest, &view, target);
            queue.submit([encoder.finish()]);
            let counters = windfall_testing::read(device, queue, &forest.falls.counters);
            let counters: &[u32] = bytemuck::cast_slice(&counters);
            let drawn = windfall_testing::read(device, queue, &forest.falls.drawn);
            let drawn: &[LooseLeaf] = bytemuck::cast_slice(&drawn);
            let mut leaves = Vec::new();
            let bins = forest.falls.bins.len();
            for (i, bin) in forest.falls.bins.iter().enumerate() {
                let first = bin.first as usize;
                leaves.extend(&drawn[first..first + counters[5 * i + 1] as usize]);
                let [_, small, _, _, at] = counters[5 * (bins + i)..][..5] else { continue };
                leaves.extend(&drawn[first + at as usize..][..small as usize]);
                assert_eq!(at + small, bin.count);
                assert!(counters[5 * i + 1] + small <= bin.count);
            }
            let tallies = &counters[10 * bins..][..5];
            (leaves, tallies.try_into().unwrap())
        }
    }

    fn unpack(leaf: &LooseLeaf) -> Quat {
        let part = |v: u32| f32::from(v as u16 as i16) / 32767.0;
        let [xy, zw] = [leaf.orientation_xy, leaf.orientation_zw];
        Quat::from_xyzw(part(xy), part(xy >> 16), part(zw), part(zw >> 16)).normalize()
    }

    /// What the CPU reference says of every leaf that has detached: pose as drawn, and whether it
    /// is in the air.
    fn reference(scene: &Scene, time: f32) -> Vec<(Vec3, Quat, bool)> {
        let Scene { trees, forest, falls } = scene;
        let fall = Fall::new(
            &falls.paths,
            &forest.terrain,
            falls.wind,
            falls.variation.clone(),
            falls.settings,
        );
        let rate = Shedding::gust_rate(&falls.wind);
        let mut out = Vec::new();
        for (number, instance) in (0..).zip(&forest.instances) {
            let foliage = &trees[instance.model as usize].foliage;
            let shed = falls.shedding.tree(instance, foliage.leaves.len() as u32, &falls.wind);
            for (rank, &index) in (0..).zip(&foliage.shed_order) {
                let leaf = &foliage.leaves[index as usize];
                let seed = hash(instance.seed, rank);
                let events = falls.events.iter();
                let detach = events
                    .filter(|e| (e.instance, e.leaf) == (number, index))
                    .map(|e| e.time)
                    .fold(falls.shedding.detach_time(&shed, rate, rank), f32::min);
                if detach > time {
                    continue;
                }
                let leaf_fall = LeafFall {
                    origin: instance.world_from_tree(leaf.center),
                    twig_orientation: instance.rotation() * leaf.orientation,
                    tree: instance.position,
                    seed,
                    group: falls.groups[instance.model as usize],
                    detach_time: f64::from(detach),
                };
                let landing = fall.landing(&leaf_fall);
                let pose = fall.pose(&leaf_fall, &landing, f64::from(time));
                // Drawn a little above the ground, by the leaf's own thickness and chance.
                let shape = &foliage.shapes[leaf.shape as usize];
                let thickness = shape.positions.iter().map(|p| p.y.abs()).fold(0.0, f32::max);
                let stack =
                    leaf.scale * instance.scale * thickness + 0.002 + 0.012 * unit(hash(seed, 13));
                let left = landing.time - (time - detach);
                let settle = falls.settings.settle_time.min(landing.time);
                let x = (1.0 - left / settle.max(1e-30)).clamp(0.0, 1.0);
                let up = landing.orientation * Vec3::Y;
                let up = if up.y < 0.0 { -up } else { up };
                let position = pose.position + up * stack * x * x * (3.0 - 2.0 * x);
                out.push((position, pose.orientation, pose.phase != Phase::Landed));
            }
        }
        out
    }

    #[test]
    fn poses_are_those_of_the_reference() {
        check_poses(&scene(1_000_000), 1e-3, true);
    }

    #[test]
    fn poses_of_the_papers_variation_are_those_of_the_reference() {
        let mut scene = scene(1_000_000);
        scene.falls.variation = windfall_core::path::Variation::Paper;
        // Its rotation is of a product of up to 2e5 degrees, of which f32 tells 1/64 apart: over a way
        // of 10 m that is 3 mm, and horizontal scales go up to 3. Where so little decides which face
        // of a leaf lies up, only those in the air can be compared.
        check_poses(&scene, 9e-3, false);
    }

    fn check_poses(scene: &Scene, tolerance: f32, lying_too: bool) {
        let gpu = Gpu::new(scene);
        let time = 75.0;
        let (leaves, tallies) = gpu.loose_leaves(time);
        let expected = reference(scene, time);
        assert!(expected.len() > 10_000, "{} leaves", expected.len());
        let in_air = expected.iter().filter(|e| e.2).count();
        assert!(in_air > 300, "{in_air} in the air");
        assert_eq!(leaves.len(), expected.len());
        assert_eq!([tallies[0], tallies[2]], [in_air, expected.len() - in_air].map(|n| n as u32));

        // Leaves come in any order: look each up by its place.
        let cell = |p: Vec3| (p * 50.0).floor().as_ivec3().to_array();
        let mut grid: HashMap<[i32; 3], Vec<&LooseLeaf>> = HashMap::new();
        for leaf in &leaves {
            grid.entry(cell(leaf.position)).or_default().push(leaf);
        }
        let mut wrong = Vec::new();
        for &(position, orientation, falling) in expected.iter().filter(|e| e.2 || lying_too) {
            let [x, y, z] = cell(position);
            let around = (-1..=1).flat_map(|i| {
                (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [x + i, y + j, z + k]))
            });
            let near = around.filter_map(|c| grid.get(&c)).flatten();
            let apart = near
                .map(|leaf| {
                    let angle = unpack(leaf).angle_between(orientation).to_degrees();
                    // A rotation and its negative are the same.
                    (leaf.position.distance(position), angle.min(360.0 - angle))
                })
                .min_by(|a, b| a.0.total_cmp(&b.0));
            match apart {
                Some((distance, angle)) if distance < tolerance && angle < 0.1 => {}
                _ => wrong.push((position, falling, apart)),
            }
        }
        assert!(
            wrong.is_empty(),
            "{} of {}: {:?}",
            wrong.len(),
            expected.len(),
            &wrong[..8.min(wrong.len())]
        );
    }

    /// Leaves of two of the trees, some of them when the season has taken them, some twice.
    fn events(scene: &Scene) -> Vec<DetachEvent> {
        let of = |instance: u32, i: u32| {
            let model = scene.forest.instances[instance as usize].model as usize;
            let leaves = scene.trees[model].foliage.leaves.len() as f32;
            let leaf = (unit(hash(instance, i)) * leaves) as u32;
            DetachEvent { instance, leaf, time: -10.0 + 0.3 * i as f32 }
        };
        (0..400).flat_map(|i| [of(2, i), of(0, i), of(2, i / 2)]).collect()
    }

    #[test]
    fn thrown_leaves_are_posed_as_the_reference_says() {
        let mut scene = scene(1_000_000);
        scene.falls.events = events(&scene);
        check_poses(&scene, 1e-3, true);
        // In a forest that sheds none, they are all there is.
        scene.falls = Falls { shedding: Shedding::never(), capacity: 0, ..scene.falls };
        let expected = reference(&scene, 75.0);
        let (leaves, tallies) = Gpu::new(&scene).loose_leaves(75.0);
        assert!(expected.len() > 500, "{}", expected.len());
        assert_eq!(leaves.len(), expected.len());
        assert_eq!(tallies[0] as usize, expected.iter().filter(|e| e.2).count());
        assert_eq!((tallies[0] + tallies[2]) as usize, expected.len());
    }

    #[test]
    fn any_order_of_moments_gives_the_same_leaves() {
        let sorted = |(mut leaves, tallies): (Vec<LooseLeaf>, _)| {
            leaves.sort_by_key(|l| l.position.to_array().map(f32::to_bits));
            (leaves, tallies)
        };
        // Few slots, so that they are reused.
        let mut scene = scene(6_000);
        scene.falls.events = events(&scene);
        let played = Gpu::new(&scene);
        for step in 0..60 {
            played.loose_leaves(step as f32);
        }
        let direct = Gpu::new(&scene);
        let at_60 = sorted(played.loose_leaves(60.0));
        assert!(at_60.0.len() > 4_000);
        assert!(at_60 == sorted(direct.loose_leaves(60.0)), "played and direct differ");
        direct.loose_leaves(150.0);
        let back = sorted(direct.loose_leaves(60.0));
        assert!(at_60 == back, "backwards differs");
        assert!(at_60 != sorted(direct.loose_leaves(60.5)), "another time must differ");
    }

    #[test]
    fn a_change_of_season_gives_the_leaves_of_that_season() {
        let sorted = |(mut leaves, _): (Vec<LooseLeaf>, _)| {
            leaves.sort_by_key(|l| l.position.to_array().map(f32::to_bits));
            leaves
        };
        let scene = scene(6_000);
        let (changed, direct) = (Gpu::new(&scene), Gpu::new(&scene));
        let before = sorted(changed.leaves_of(50.0, 0.2));
        let after = sorted(changed.leaves_of(50.0, 0.8));
        assert!(after == sorted(direct.leaves_of(50.0, 0.8)));
        assert!(after != before);
        // The colours stay when time goes on.
        changed.leaves_of(50.1, 0.8);
        assert!(sorted(changed.leaves_of(50.2, 0.8)) == sorted(direct.leaves_of(50.2, 0.8)));
    }
}
