//! Leaves that have left their twigs, against the CPU reference of `windfall_core::path`.

use super::{Gpu, Watched};
use crate::base::shared::LooseLeaf;
use crate::{Camera, Falls, Forest, ForestError, Quality, TreeModel, TreePlace, View};
use glam::{DVec3, Quat, Vec3};
use std::collections::{HashMap, HashSet};
use windfall_core::foliage::Leaf;
use windfall_core::forest::{Forest as Placed, Placement, Terrain};
use windfall_core::path::{Edition, Fall, LeafFall, Phase, Variation, stack_height};
use windfall_core::rng::{hash, unit};
use windfall_core::shed::Shedding;
use windfall_core::simplify::Simplification;
use windfall_core::tree::Tree;
use windfall_core::wind::Wind;
use windfall_tree::Species;

/// A thrown leaf: tree, leaf, seconds.
type Thrown = (u32, u32, f64);

#[derive(Clone)]
struct Scene {
    trees: Vec<Tree>,
    placed: Placed,
    falls: Falls,
    thrown: Vec<Thrown>,
}

/// Two species on a hillside in a gusty wind; about a third of the leaves fall in 60 s.
fn scene(capacity: u32) -> Scene {
    let trees = vec![Species::Birch.grow(1), Species::Oak.grow(2)];
    let placement =
        Placement { trees: 4, spacing: 9.0, season_spread: 0.2, seed: 3, ..Placement::default() };
    let falls = Falls {
        wind: Wind::new(2.0, 0.8, 0.8, 7),
        shedding: Shedding { start: 0.0, duration: 180.0, ..Shedding::default() },
        capacity,
        ..Falls::default()
    };
    let placed = placement.place(Terrain::rolling(400.0, 12.0, 5), &[1.0, 1.0]);
    Scene { placed, trees, falls, thrown: Vec::new() }
}

impl Scene {
    fn at(&self, origin: DVec3) -> Watched {
        let Self { trees, placed, falls, thrown } = self;
        let mut watched = Watched::new(Gpu::get(), origin, trees, placed, falls.clone());
        for &(tree, leaf, time) in thrown {
            watched.forest.throw(watched.ids[tree as usize], leaf, time).unwrap();
        }
        watched
    }

    fn watched(&self) -> Watched {
        self.at(DVec3::ZERO)
    }
}

/// From far away, everything in view. The reference knows nothing of what the twig does before the leaf has
/// left it.
fn from_far(origin: DVec3) -> View {
    let eye = origin + DVec3::new(0.0, 1000.0, 3000.0);
    View {
        shadows: false,
        quality: Quality { sway: false, ..Quality::PLAIN },
        detail: Simplification::NONE,
        ..View::new(Camera::look_at(eye, origin, 1.0, 0.1))
    }
}

impl Watched {
    /// The loose leaves that a view of a moment draws, and how many are in the air and on the ground.
    fn leaves(&mut self, time: f64) -> (Vec<LooseLeaf>, [u32; 2]) {
        let gpu = Gpu::get();
        let view = from_far(self.forest.origin());
        self.draw(gpu, time, &view, (8, 8));
        self.drawn()
    }

    fn drawn(&self) -> (Vec<LooseLeaf>, [u32; 2]) {
        let gpu = Gpu::get();
        let loose = &self.buffers().loose;
        let counters = gpu.words(&loose.counters);
        let drawn: Vec<LooseLeaf> = bytemuck::pod_collect_to_vec(&gpu.read(&loose.drawn));
        let mut leaves = Vec::new();
        for (i, bin) in self.bins().iter().enumerate() {
            let [full, small] = [false, true].map(|small| {
                let at = loose.arguments_of(i, small) as usize / 4;
                (counters[at + 1] as usize, counters[at + 4] as usize)
            });
            let first = bin.first as usize;
            leaves.extend(&drawn[first..first + full.0]);
            leaves.extend(&drawn[first + small.1..first + small.1 + small.0]);
            assert_eq!(small.1 + small.0, bin.count as usize);
            assert!(full.0 + small.0 <= bin.count as usize);
        }
        let of_forest = gpu.words(&self.forest.buffers().unwrap().loose.counters);
        (leaves, [of_forest[0], of_forest[1]])
    }

    /// The same in an order that does not depend on that of threads.
    fn sorted(&mut self, time: f64) -> (Vec<LooseLeaf>, [u32; 2]) {
        let (mut leaves, tallies) = self.leaves(time);
        leaves.sort_by_key(|l| (l.position.to_array().map(f32::to_bits), l.look));
        (leaves, tallies)
    }

    /// The posed leaves of all slots.
    fn posed(&self) -> Vec<LooseLeaf> {
        let posed = &self.forest.buffers().unwrap().loose.posed;
        bytemuck::pod_collect_to_vec(&Gpu::get().read(posed))
    }
}

fn unpack(leaf: &LooseLeaf) -> Quat {
    let part = |v: u32| f32::from(v as u16 as i16) / 32767.0;
    let [xy, zw] = [leaf.orientation_xy, leaf.orientation_zw];
    Quat::from_xyzw(part(xy), part(xy >> 16), part(zw), part(zw >> 16)).normalize()
}

/// Degrees between two rotations: by the chord, which is precise where the cosine is not. A rotation and its
/// negative are the same.
fn angle(a: Quat, b: Quat) -> f32 {
    let b = b.normalize();
    let chord = (a - b).length().min((a + b).length());
    (4.0 * (0.5 * chord).asin()).to_degrees()
}

/// What the CPU reference says of every leaf that has detached: pose as drawn, and whether it
/// is in the air. The forest stands at the world's origin.
fn reference(scene: &Scene, time: f64) -> Vec<(Vec3, Quat, bool)> {
    let Scene { trees, placed, falls, thrown } = scene;
    let fall = Fall::new(
        &falls.paths,
        &placed.terrain,
        falls.wind,
        falls.variation.clone(),
        falls.settings,
    );
    let rate = Shedding::gust_rate(&falls.wind);
    let mut out = Vec::new();
    for (number, instance) in (0..).zip(&placed.instances) {
        let tree = &trees[instance.model as usize];
        let foliage = &tree.foliage;
        let shed = falls.shedding.tree(instance, foliage.leaves.len() as u32, &falls.wind);
        for (rank, &index) in (0..).zip(&foliage.shed_order) {
            let leaf = &foliage.leaves[index as usize];
            // Times of thrown leaves are as exact as the GPU has them: single, from when the shedding begins.
            let start = if falls.shedding.start < 1e12 { falls.shedding.start } else { 0.0 };
            let detach = thrown
                .iter()
                .filter(|t| (t.0, t.1) == (number, index))
                .map(|t| start + f64::from((t.2 - start) as f32))
                .fold(falls.shedding.detach_time(&shed, rate, rank), f64::min);
            if detach > time {
                continue;
            }
            let leaf_fall = LeafFall::of(instance, leaf, falls.group_of(&tree.name), detach);
            let landing = fall.landing(&leaf_fall);
            // Drawn a little above the ground, by the leaf's own thickness and chance.
            let thickness = foliage.shapes[leaf.shape as usize].thickness();
            let stack = stack_height(&leaf_fall, leaf.scale * instance.scale, thickness);
            let pose = fall.drawn_pose(&leaf_fall, &landing, stack, time);
            out.push((pose.position, pose.orientation, pose.phase != Phase::Landed));
        }
    }
    out
}

/// Holds leaves against the reference: each within a distance in metres, and 0.1° (those that lie: `degrees`).
fn check(
    (leaves, tallies): &(Vec<LooseLeaf>, [u32; 2]),
    expected: &[(Vec3, Quat, bool)],
    tolerance: f32,
    degrees: Option<f32>,
) {
    let wrong = differing((leaves, *tallies), expected, tolerance, degrees);
    let (count, of) = (wrong.len(), expected.len());
    assert!(wrong.is_empty(), "{count} of {of}: {:?}", &wrong[..8.min(count)]);
}

/// A leaf of the reference: where it is, whether it is in the air, and how far off the nearest drawn one is.
type Differing = (Vec3, bool, Option<(f32, f32)>);

/// Those leaves that are not as [`check`] wants them.
fn differing(
    (leaves, tallies): (&[LooseLeaf], [u32; 2]),
    expected: &[(Vec3, Quat, bool)],
    tolerance: f32,
    degrees: Option<f32>,
) -> Vec<Differing> {
    let in_air = expected.iter().filter(|e| e.2).count();
    assert_eq!(leaves.len(), expected.len());
    assert_eq!(tallies, [in_air, expected.len() - in_air].map(|n| n as u32));
    // Leaves come in any order: look each up by its place.
    let cell = |p: Vec3| (p * 50.0).floor().as_ivec3().to_array();
    let mut grid: HashMap<[i32; 3], Vec<&LooseLeaf>> = HashMap::new();
    for leaf in leaves {
        grid.entry(cell(leaf.position)).or_default().push(leaf);
    }
    let most = |falling| if falling { 0.1 } else { degrees.unwrap_or(0.1) };
    let mut wrong = Vec::new();
    for &(position, orientation, falling) in expected.iter().filter(|e| e.2 || degrees.is_some()) {
        let [x, y, z] = cell(position);
        let around = (-1..=1)
            .flat_map(|i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [x + i, y + j, z + k])));
        let near = around.filter_map(|c| grid.get(&c)).flatten();
        let apart = near
            .map(|leaf| (leaf.position.distance(position), angle(unpack(leaf), orientation)))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        match apart {
            Some((distance, angle)) if distance < tolerance && angle < most(falling) => {}
            _ => wrong.push((position, falling, apart)),
        }
    }
    wrong
}

#[test]
fn poses_are_those_of_the_reference() {
    let scene = scene(1_000_000);
    let expected = reference(&scene, 75.0);
    assert!(expected.len() > 10_000 && expected.iter().filter(|e| e.2).count() > 300);
    check(&scene.watched().leaves(75.0), &expected, 1e-3, Some(0.1));
}

#[test]
fn poses_of_the_papers_variation_are_those_of_the_reference() {
    let mut scene = scene(1_000_000);
    scene.falls.variation = Variation::Paper(Edition::Of2008);
    // Its rotation is of a product of up to 2e5 degrees, of which f32 tells 1/64 apart: over a way
    // of 10 m that is 3 mm, and horizontal scales go up to 3. Where so little decides which face
    // of a leaf lies up, only those in the air can be compared.
    check(&scene.watched().leaves(75.0), &reference(&scene, 75.0), 9e-3, None);
    // The larger factors of 2007 bring a leaf in a thousand to a step of its `mod`, where rounding decides
    // between a scale of 0 and 3, or between two starting points.
    scene.falls.variation = Variation::Paper(Edition::Of2007);
    let (leaves, tallies) = scene.watched().leaves(75.0);
    let expected = reference(&scene, 75.0);
    let wrong = differing((&leaves, tallies), &expected, 9e-3, None);
    assert!(wrong.len() * 1000 < expected.len(), "{} of {}", wrong.len(), expected.len());
}

/// Leaves of two of the trees, some of them when the season has taken them, some twice.
fn thrown(scene: &Scene) -> Vec<Thrown> {
    let of = |tree: u32, i: u32| {
        let model = scene.placed.instances[tree as usize].model as usize;
        let leaves = scene.trees[model].foliage.leaves.len() as f32;
        (tree, (unit(hash(tree, i)) * leaves) as u32, -10.0 + 0.3 * f64::from(i))
    };
    (0..400).flat_map(|i| [of(2, i), of(0, i), of(2, i / 2)]).collect()
}

#[test]
fn thrown_leaves_are_posed_as_the_reference_says() {
    let mut scene = scene(1_000_000);
    scene.thrown = thrown(&scene);
    check(&scene.watched().leaves(75.0), &reference(&scene, 75.0), 1e-3, Some(0.1));
    // In a forest that sheds none, they are all there is.
    scene.falls = Falls { shedding: Shedding::never(), capacity: 0, ..scene.falls };
    let expected = reference(&scene, 75.0);
    assert!(expected.len() > 500, "{}", expected.len());
    check(&scene.watched().leaves(75.0), &expected, 1e-3, Some(0.1));
}

/// After ten days of running, in a season that began a minute ago and in one of twenty days.
#[test]
fn ten_days_do_not_show() {
    let days = 864_000.25;
    for (start, duration) in [(days - 75.0, 180.0), (0.0, 20.0 * 86_400.0)] {
        let mut scene = scene(1_000_000);
        scene.falls.shedding = Shedding { start, duration, ..scene.falls.shedding };
        // Two seconds after the next leaf has detached.
        let rate = Shedding::gust_rate(&scene.falls.wind);
        let next = scene.placed.instances.iter().flat_map(|instance| {
            let leaves = scene.trees[instance.model as usize].foliage.leaves.len() as u32;
            let Falls { shedding, wind, .. } = &scene.falls;
            let shed = shedding.tree(instance, leaves, wind);
            (0..leaves).map(move |rank| shedding.detach_time(&shed, rate, rank))
        });
        let now = next.filter(|t| *t > days).fold(f64::INFINITY, f64::min) + 2.0;
        let expected = reference(&scene, now);
        assert!(expected.iter().any(|e| e.2), "leaves are in the air");
        let mut watched = scene.watched();
        // The reference reduces the wind's time to steps of 0.06 ms: a leaf in thousands that lands on its edge
        // lies a little otherwise. In the long season detach times are 1/16 s apart, of which a GPU may take the
        // next: leaves that landed days ago lie where another gust took them.
        check(&watched.leaves(now), &expected, 3e-3, (start > 0.0).then_some(1.0));
        // A leaf in the air moves a little from frame to frame: no frame repeats, none jumps.
        let flying = |watched: &mut Watched, frame: u32| {
            watched.leaves(now + f64::from(frame) / 60.0);
            watched.posed()
        };
        let frames: Vec<Vec<LooseLeaf>> = (0..5).map(|frame| flying(&mut watched, frame)).collect();
        let mut moved = 0;
        for slot in 0..frames[0].len() {
            let in_air = |leaf: &LooseLeaf| leaf.scale > 0.0 && leaf.scale.to_bits() & 3 == 1;
            if !frames.iter().all(|frame| in_air(&frame[slot])) {
                continue;
            }
            let steps = frames.windows(2).map(|w| w[1][slot].position - w[0][slot].position);
            let steps: Vec<Vec3> = steps.collect();
            assert!(steps.iter().all(|s| s.length() > 1e-4 && s.length() < 0.2), "{steps:?}");
            assert!(steps.windows(2).all(|w| w[0].distance(w[1]) < 0.03), "{steps:?}");
            moved += 1;
        }
        assert!(moved > 0, "no leaf stayed in the air");
    }
}

/// 100 km from the world's origin the same leaves are at the same places, to a millimetre; the wind is that of the
/// world there.
#[test]
fn far_from_the_origin_nothing_shakes() {
    let mut calm = scene(1_000_000);
    calm.falls.wind = Wind::new(2.0, 0.8, 0.0, 7);
    calm.falls.shedding.burst = 0.0;
    let origin = DVec3::new(100_000.25, 50.0, -100_000.75);
    let expected = reference(&calm, 75.0);
    check(&calm.at(origin).leaves(75.0), &expected, 1e-3, Some(0.1));
    // Gusts come at another time: those of the reference with the phase of that place.
    let mut gusty = scene(1_000_000);
    let far = gusty.at(origin).sorted(75.0);
    let wind = &mut gusty.falls.wind;
    let along = f64::from(wind.travel.x) * origin.x + f64::from(wind.travel.y) * origin.z;
    for gust in &mut wind.gusts {
        let late = f64::from(gust.cycles) * along * f64::from(wind.slowness) / Wind::PERIOD;
        gust.phase = (f64::from(gust.phase) - late).rem_euclid(1.0) as f32;
    }
    check(&far, &reference(&gusty, 75.0), 1e-3, Some(0.1));
}

#[test]
fn any_order_of_moments_gives_the_same_leaves() {
    // Few slots, so that they are reused.
    let mut scene = scene(6_000);
    scene.thrown = thrown(&scene);
    let mut played = scene.watched();
    for step in 0..60 {
        played.leaves(f64::from(step));
    }
    let mut direct = scene.watched();
    let at_60 = played.sorted(60.0);
    assert!(at_60.0.len() > 4_000);
    assert!(at_60 == direct.sorted(60.0), "played and direct differ");
    direct.leaves(150.0);
    assert!(at_60 == direct.sorted(60.0), "backwards differs");
    assert!(at_60 != direct.sorted(60.5), "another time must differ");
}

#[test]
fn a_dropped_encoder_leaves_nothing_wrong_behind() {
    let gpu = Gpu::get();
    let scene = scene(6_000);
    let expected = scene.watched().sorted(60.0);
    let mut watched = scene.watched();
    let view = from_far(DVec3::ZERO);
    // Whatever was drawn before: slots hold leaves of that time, earlier or later than the dropped frame's.
    for (drawn, time, season) in [
        (5.0, 10.0, 0.5),
        (5.0, 70.0, 0.5),
        (90.0, 50.0, 0.5),
        (5.0, 50.0, 0.9),
        (5.0, 300.0, 0.5),
        (200.0, 20.0, 0.1),
    ] {
        watched.leaves(drawn);
        watched.forest.set_season(season).unwrap();
        drop(watched.record(gpu, time, &view, (8, 8)));
        watched.forest.set_season(0.5).unwrap();
        assert!(watched.sorted(60.0) == expected, "after a frame of {time} s that was dropped");
    }
}

#[test]
fn a_change_of_season_gives_the_leaves_of_that_season() {
    let scene = scene(6_000);
    let leaves = |watched: &mut Watched, time, season| {
        watched.forest.set_season(season).unwrap();
        watched.sorted(time).0
    };
    let (mut changed, mut direct) = (scene.watched(), scene.watched());
    let before = leaves(&mut changed, 50.0, 0.2);
    let after = leaves(&mut changed, 50.0, 0.8);
    assert!(after == leaves(&mut direct, 50.0, 0.8));
    assert!(after != before);
    // The colours stay when time goes on.
    leaves(&mut changed, 50.1, 0.8);
    assert!(leaves(&mut changed, 50.2, 0.8) == leaves(&mut direct, 50.2, 0.8));
}

/// A running forest is changed in every way: after each change its leaves are those of a forest that was made so.
#[test]
fn a_changed_forest_is_as_one_that_was_made_so() {
    let gpu = Gpu::get();
    let whole = scene(200_000);
    let mut part = whole.clone();
    let last = part.placed.instances.pop().unwrap();
    let mut running = part.watched();
    // Slots for as many leaves of each tree as the whole forest has.
    running.leaves(30.0);
    let place = TreePlace {
        position: last.position.as_dvec3(),
        yaw: last.yaw,
        scale: last.scale,
        season_offset: last.season_offset,
        seed: last.seed,
    };
    let model = running.models[last.model as usize].clone();
    let id = running.forest.insert(&model, place).unwrap();
    assert!(running.sorted(60.0) == whole.watched().sorted(60.0), "inserted");
    // Now there is room: a tree comes and goes without the others' leaves being touched.
    let before = running.posed();
    let elsewhere = DVec3::new(30.0, 0.0, 5.0);
    let other = running.forest.insert(&model, TreePlace::at(elsewhere, 77)).unwrap();
    let with = running.sorted(60.0).0.len();
    let after = running.posed();
    assert_eq!(before.len(), after.len(), "there was room");
    let there = |leaf: &LooseLeaf| leaf.scale > 0.0;
    let touched = before.iter().zip(&after).filter(|(b, a)| there(b) && b != a).count();
    assert_eq!(touched, 0);
    running.forest.remove(other).unwrap();
    assert!(running.sorted(60.0) == whole.watched().sorted(60.0), "removed");
    assert!(with > running.sorted(60.0).0.len(), "it had leaves in the air");

    // Moved, and thrown leaves with it.
    let moved = DVec3::new(25.0, 0.0, 25.0);
    let mut elsewhere = whole.clone();
    let instance = elsewhere.placed.instances.last_mut().unwrap();
    (instance.position, instance.yaw, instance.scale) = (moved.as_vec3(), 1.0, 1.3);
    elsewhere.thrown = (0..40).map(|leaf| (3, leaf, 35.0)).collect();
    for leaf in 0..40 {
        running.forest.throw(id, leaf, 35.0).unwrap();
    }
    running.leaves(45.0);
    running.forest.set_transform(id, moved, 1.0, 1.3).unwrap();
    assert!(running.sorted(60.0) == elsewhere.watched().sorted(60.0), "moved");

    // Another wind, another season of shedding.
    elsewhere.falls.wind = Wind::new(4.0, 2.0, 0.5, 9);
    running.forest.set_wind(elsewhere.falls.wind);
    assert!(running.sorted(60.0) == elsewhere.watched().sorted(60.0), "wind");
    elsewhere.falls.shedding.start = 20.0;
    running.forest.set_shedding(elsewhere.falls.shedding);
    assert!(running.sorted(60.0) == elsewhere.watched().sorted(60.0), "shedding");

    // Leaves that are thrown one after the other, many more than there was room for.
    for i in 0..200u32 {
        let event = (3, 100 + 3 * i, 40.0 + 0.1 * f64::from(i));
        elsewhere.thrown.push(event);
        running.forest.throw(id, event.1, event.2).unwrap();
        if i % 20 == 0 {
            running.leaves(40.0 + 0.1 * f64::from(i));
        }
    }
    assert!(running.sorted(62.0) == elsewhere.watched().sorted(62.0), "thrown");
    assert!(TreeModel::new(&gpu.device, &gpu.queue, &whole.trees[0]).unwrap() != model);
}

/// Slots may hold leaves of a later time than that of a frame which was never submitted: what is thrown in between is
/// taken out of them all the same.
#[test]
fn a_leaf_that_is_thrown_in_a_dropped_frame_is_there_once() {
    let gpu = Gpu::get();
    let mut scene = scene(200_000);
    let (tree, first) = (3, 0);
    scene.thrown = vec![(tree, first, 10.0)];
    let mut watched = scene.watched();
    watched.leaves(100.0);
    // A leaf that the season has taken by then, and had not when it is thrown.
    let instance = &scene.placed.instances[tree as usize];
    let foliage = &scene.trees[instance.model as usize].foliage;
    let Falls { shedding, wind, .. } = &scene.falls;
    let shed = shedding.tree(instance, foliage.leaves.len() as u32, wind);
    let taken = |rank| shedding.detach_time(&shed, Shedding::gust_rate(wind), rank);
    let rank = (0..shed.leaves).find(|&rank| taken(rank) > 70.0).unwrap();
    assert!(taken(rank) < 90.0);
    let leaf = foliage.shed_order[rank as usize];
    scene.thrown.push((tree, leaf, 40.0));
    watched.forest.throw(watched.ids[tree as usize], leaf, 40.0).unwrap();
    drop(watched.record(gpu, 50.0, &from_far(DVec3::ZERO), (8, 8)));
    assert!(watched.sorted(100.5) == scene.watched().sorted(100.5));
}

/// Models are uploaded once, and a forest of none of its trees is a forest.
#[test]
fn trees_come_and_go_with_the_models_that_there_are() {
    let gpu = Gpu::get();
    let scene = scene(6_000);
    let mut watched = scene.watched();
    let expected = watched.sorted(60.0);
    // Trees that came and went before anybody saw them.
    let models = watched.models.clone();
    let passing = watched.forest.insert(&models[0], TreePlace::at(DVec3::X, 5)).unwrap();
    watched.forest.throw(passing, 0, 5.0).unwrap();
    watched.forest.remove(passing).unwrap();
    assert!(watched.sorted(60.0) == expected, "passing");
    assert_eq!(watched.forest.models().count(), models.len());
    let ids = watched.ids.clone();
    for &id in &ids {
        watched.forest.remove(id).unwrap();
    }
    assert_eq!(watched.sorted(60.0), (Vec::new(), [0, 0]));
    assert_eq!(watched.forest.totals(), crate::ForestTotals::default());
    watched.ids = watched.forest.plant(&models, &scene.placed.instances).unwrap();
    assert!(watched.ids.iter().all(|id| !ids.contains(id)));
    assert!(watched.sorted(60.0) == expected, "planted again");
    // The same models in another forest; their buffers are the same.
    let of = |watched: &Watched| {
        let models = watched.forest.buffers().unwrap().models.iter();
        models.map(|(model, _)| model.leaves.vertices.clone()).collect::<Vec<_>>()
    };
    let falls = scene.falls.clone();
    let mut other = Watched::of_models(gpu, DVec3::ZERO, models, &scene.placed, falls);
    assert!(other.sorted(60.0) == expected, "another forest");
    assert_eq!(of(&other), of(&watched));
}

#[test]
fn what_cannot_be_is_refused() {
    let scene = scene(1_000);
    let mut watched = scene.watched();
    let (id, model) = (watched.ids[0], watched.models[0].clone());
    let forest: &mut Forest = &mut watched.forest;
    let good = TreePlace::at(DVec3::ZERO, 1);
    for bad in [
        TreePlace { position: DVec3::NAN, ..good },
        TreePlace { position: DVec3::X * 3e4, ..good },
        TreePlace { yaw: f32::INFINITY, ..good },
        TreePlace { scale: 0.0, ..good },
        TreePlace { season_offset: f32::NAN, ..good },
    ] {
        assert!(matches!(forest.insert(&model, bad), Err(ForestError::Number { .. })), "{bad:?}");
        if bad.season_offset == 0.0 {
            let moved = forest.set_transform(id, bad.position, bad.yaw, bad.scale);
            assert!(matches!(moved, Err(ForestError::Number { .. })), "{bad:?}");
        }
    }
    assert!(matches!(forest.throw(id, 1 << 30, 0.0), Err(ForestError::NoSuchLeaf { .. })));
    assert!(matches!(forest.throw(id, 0, f64::NAN), Err(ForestError::Number { .. })));
    assert!(matches!(forest.set_season(f32::NAN), Err(ForestError::Number { .. })));
    forest.remove(id).unwrap();
    assert_eq!(forest.remove(id), Err(ForestError::NoSuchTree(id)));
    assert_eq!(forest.throw(id, 0, 0.0), Err(ForestError::NoSuchTree(id)));
    // Its place is taken by another; the old name stays invalid.
    let new = forest.insert(&model, good).unwrap();
    assert!(new != id && forest.set_transform(id, DVec3::ZERO, 0.0, 1.0).is_err());
    let (device, queue) = windfall_testing::default_device();
    let foreign = TreeModel::new(&device, &queue, &scene.trees[0]).unwrap();
    assert!(matches!(forest.insert(&foreign, good), Err(ForestError::OtherDevice { .. })));

    // More leaves than a binding of the device holds: no forest, and no lost device.
    let most = device.limits().max_storage_buffer_binding_size / 32;
    let falls = Falls { capacity: u32::MAX, ..scene.falls.clone() };
    let mut large = Forest::new(&device, DVec3::ZERO, Terrain::flat(), falls).unwrap();
    let leaves = u64::from(foreign.leaf_count());
    for i in 0..=most / leaves {
        large.insert(&foreign, TreePlace::at(DVec3::X * (i % 100) as f64, i as u32)).unwrap();
    }
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut recording = crate::Recording::new(&queue, &mut encoder);
    let options = crate::Options::picture(wgpu::TextureFormat::Rgba8UnormSrgb);
    let renderer = crate::Renderer::new(&device, &options).unwrap();
    let moment = crate::Moment::at(0.0);
    let refused = renderer.advance(&mut recording, &mut large, moment);
    assert!(matches!(refused, Err(ForestError::TooManyLeaves { .. })), "{refused:?}");
}

/// At λ of about 0.2, half-way through the season: each leaf that is drawn of a tree is either on its twig or off
/// it, and none of those is missing.
#[test]
fn no_leaf_is_twice_or_lost_in_a_simplified_tree() {
    let gpu = Gpu::get();
    let mut scene = scene(1_000_000);
    scene.placed.instances.truncate(1);
    // Some are thrown besides, whether they are drawn or not.
    scene.thrown = (0..400).map(|i| (0, 11 * i, 60.0 + 0.05 * f64::from(i))).collect();
    let tree = &scene.trees[scene.placed.instances[0].model as usize];
    let leaves = tree.foliage.leaves.len() as f32;
    let eye = DVec3::new(0.0, 6.0, 100.0);
    let detail = Simplification {
        reduction: windfall_core::simplify::Reduction::Distance { d0: 45.0 },
        fade: windfall_core::simplify::Fade {
            range: windfall_core::simplify::FadeRange::Constant(0.0),
            ..Simplification::DEFAULT.fade
        },
        growth: windfall_core::simplify::Growth::UNBOUNDED,
        ..Simplification::DEFAULT
    };
    let view = View { detail, ..View::new(Camera::look_at(eye, DVec3::Y * 5.0, 1.2, 0.1)) };
    let mut watched = scene.watched();
    watched.draw(gpu, 90.0, &view, (64, 36));
    let lists = &watched.buffers().lists;
    let placed: Vec<crate::base::shared::TreeInstance> =
        bytemuck::pod_collect_to_vec(&gpu.read(&lists.placed));
    let (lambda, detached) = (placed[0].lambda, placed[0].detached & 0xff_ffff);
    assert!((0.1..0.4).contains(&lambda), "{lambda}");
    let gone = detached as f32 / leaves;
    assert!((0.3..0.7).contains(&gone), "{gone}");
    // Leaves of the prefix, by whether they have left.
    let kept = (0..).zip(tree.foliage.leaves.iter().take((lambda * leaves).floor() as usize));
    let thrown: HashSet<u32> = scene.thrown.iter().map(|t| t.1).collect();
    let (off, on): (Vec<(u32, &Leaf)>, Vec<_>) =
        kept.partition(|(i, leaf)| leaf.shed_rank < detached || thrown.contains(i));
    let drawn = watched.drawn().0.len();
    // One leaf more or less where λN is no whole number.
    assert!(
        drawn.abs_diff(off.len()) <= 1,
        "{drawn} loose leaves are drawn, {} have left",
        off.len()
    );
    assert!(!on.is_empty() && off.len() > 100);
    // All leaves on the twigs are quads here: those of leaves that have left have no area.
    let quads = &watched.buffers().quads.as_ref().unwrap().buffers;
    let words = gpu.words(&quads.arguments);
    let count: u32 = words.chunks(5).take(quads.draws as usize).map(|draw| draw[0] / 6).sum();
    assert!(count as usize >= on.len() + off.len(), "{count} quads");
    let corners = gpu.words(&quads.corners);
    let hanging =
        corners.chunks(16).take(count as usize).filter(|quad| quad[..4] != [0; 4]).count();
    assert!(hanging.abs_diff(on.len()) <= 1, "{hanging} leaves hang, {} should", on.len());
}

/// Groups of slots that were posed in the last frame.
fn awake(watched: &Watched) -> u32 {
    Gpu::get().words(&watched.forest.buffers().unwrap().loose.counters)[6]
}

fn sorted((mut leaves, tallies): (Vec<LooseLeaf>, [u32; 2])) -> (Vec<LooseLeaf>, [u32; 2]) {
    leaves.sort_by_key(|l| (l.position.to_array().map(f32::to_bits), l.look));
    (leaves, tallies)
}

#[test]
fn leaves_at_rest_cost_nothing_and_stay_where_they_lie() {
    let gpu = Gpu::get();
    let mut scene = scene(1_000_000);
    scene.placed.instances.truncate(2);
    scene.falls.shedding = Shedding { duration: 60.0, ..scene.falls.shedding };
    let mut watched = scene.watched();
    let at_first = watched.sorted(500.0);
    assert!(awake(&watched) > 20, "{}", awake(&watched));
    for frame in 1..5 {
        assert_eq!(watched.sorted(500.0 + 0.1 * f64::from(frame)), at_first, "frame {frame}");
    }
    assert_eq!(awake(&watched), 0);
    // Some of them from close by, and none from where they are behind.
    let place = scene.placed.instances[0].position.as_dvec3();
    for (target, most) in [(place, at_first.0.len() * 9 / 10), (place + DVec3::Y * 1e4, 0)] {
        let eye = place + DVec3::new(3.0, 8.0, 0.0);
        let near = View { camera: Camera::look_at(eye, target, 1.2, 0.1), ..from_far(DVec3::ZERO) };
        watched.draw(gpu, 501.0, &near, (8, 8));
        let (rest, tallies) = sorted(watched.drawn());
        let mut fresh = scene.watched();
        fresh.draw(gpu, 501.0, &near, (8, 8));
        assert_eq!((&rest, tallies), (&sorted(fresh.drawn()).0, at_first.1));
        assert!(rest.len() <= most && (rest.len() > 100 || most == 0), "{}", rest.len());
    }
    // Time runs backwards; a leaf is thrown that lies at rest later; the season is another one.
    assert_eq!(watched.sorted(75.0), scene.watched().sorted(75.0));
    watched.leaves(500.0);
    watched.leaves(500.1);
    watched.forest.throw(watched.ids[0], 7, 20.0).unwrap();
    scene.thrown = vec![(0, 7, 20.0)];
    for time in [500.2, 500.3, 500.4] {
        assert_eq!(watched.sorted(time), scene.watched().sorted(time), "{time}");
    }
    scene.falls.wind = Wind::new(3.0, 0.2, 0.8, 7);
    watched.forest.set_wind(scene.falls.wind);
    for time in [500.42, 500.44, 500.46] {
        assert_eq!(watched.sorted(time), scene.watched().sorted(time), "{time}");
    }
    watched.forest.remove(watched.ids[1]).unwrap();
    scene.placed.instances.truncate(1);
    for time in [500.5, 500.6] {
        assert_eq!(watched.sorted(time), scene.watched().sorted(time), "{time}");
    }
}

#[test]
fn leaves_at_rest_make_room_for_others() {
    let mut scene = scene(16_000);
    scene.falls.shedding = Shedding { duration: 200_000.0, ..scene.falls.shedding };
    let mut watched = scene.watched();
    let (mut fewest, mut most) = (u32::MAX, 0);
    for i in 0..30 {
        let time = 60_000.0 + 1500.0 * f64::from(i);
        let leaves = watched.sorted(time);
        (fewest, most) = (fewest.min(awake(&watched)), most.max(awake(&watched)));
        if i % 3 == 2 {
            assert_eq!(leaves, scene.watched().sorted(time), "{time}");
        }
    }
    assert!(0 < fewest && 2 * fewest < most, "{fewest} {most}");
}
