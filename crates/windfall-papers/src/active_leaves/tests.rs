//! Lists of leaves against the falls that they are of.

use super::*;
use bytemuck::Zeroable;
use glam::DVec3;
use windfall_core::forest::{Placement, Terrain};
use windfall_gpu::{Falls, TreeModel};
use windfall_tree::Species;

/// Which listed leaves are small, by slot.
fn small(lists: &ActiveLeaves) -> Vec<Option<bool>> {
    let of = |slot: &Slot| (slot.place != Place::Nowhere).then_some(slot.small);
    lists.slots.iter().map(of).collect()
}

/// Leaves fall while the eye moves among them, near and far: earlier views make no difference, and the regions
/// have what the slots say.
#[test]
fn leaves_are_small_or_large_by_the_view_alone() {
    let (device, queue) = windfall_testing::device();
    let model = TreeModel::new(&device, &queue, &Species::Maple.grow_with(1, 300)).unwrap();
    let placement = Placement {
        trees: 3,
        spacing: 8.0,
        keep_out: Vec::new(),
        scale: (0.8, 1.2),
        season_spread: 0.2,
        seed: 3,
    };
    let placed = placement.place(Terrain::rolling(200.0, 4.0, 5), &[1.0]);
    let shedding = Shedding { start: 0.0, duration: 60.0, ..Shedding::default() };
    let falls = Falls { shedding, capacity: 0, ..Falls::default() };
    let mut forest = Forest::new(&device, DVec3::ZERO, placed.terrain, falls).unwrap();
    forest.plant(&[model], &placed.instances).unwrap();
    let at = |frame: u32| ListMoment { time: 0.3 * f64::from(frame), season: 0.5 };
    let passes = PassOptions::new(Strategy::Vertex);
    for elimination in Elimination::ALL {
        // Some vanish.
        let lists =
            || ActiveLeaves::new(&device, Streams::new(&forest, 150), &forest, elimination, passes);
        let mut played = lists();
        let mut seen = [0; 2];
        for frame in 0..200u32 {
            let draw = |key| unit(hash(frame / 20, key));
            // Another place every 20 frames, sometimes another size of the image.
            let eye = Vec3::new(30.0 * draw(1) - 15.0, 1.7, 30.0 * draw(2) - 15.0)
                + Vec3::X * (0.1 * (frame % 20) as f32);
            let pixels = if draw(3) > 0.7 { 200.0 } else { 120.0 };
            let view = TreeList { eye, pixels, leaf_pixels: 10.0, ..TreeList::zeroed() };
            played.update(&forest, at(frame), &view);
            if frame % 3 == 0 {
                let mut fresh = lists();
                fresh.update(&forest, at(frame), &view);
                assert!(small(&played) == small(&fresh), "{elimination}, frame {frame}");
            }
            let count = |small| {
                let of = |region: usize| {
                    played.active.regions[region].items.len()
                        + played.litter.regions[region].items.len()
                };
                (usize::from(small)..played.active.regions.len()).step_by(2).map(of).sum()
            };
            for (i, is_small) in [(0, false), (1, true)] {
                let listed: usize = count(is_small);
                let slots = small(&played).iter().filter(|s| **s == Some(is_small)).count();
                assert_eq!(listed, slots, "{elimination}, frame {frame}");
                seen[i] += listed;
            }
        }
        // Queues stay bounded while the eye rests.
        let mut still = lists();
        let view = TreeList { pixels: 120.0, leaf_pixels: 10.0, ..TreeList::zeroed() };
        for frame in 0..200u32 {
            still.update(&forest, at(frame), &view);
            assert!(still.rechecks.len() <= 5 * still.slots.len(), "frame {frame}");
        }
        // And while time goes back and forth.
        for _ in 0..40 {
            still.update(&forest, at(66), &view);
            still.update(&forest, at(65), &view);
            assert!(still.phases.len() <= PIECES * still.slots.len(), "{elimination}");
        }
        assert!(seen[0] > 3000 && seen[1] > 5000, "{seen:?} large and small leaves");
    }
}

/// 500 leaves a second for half a minute, 20 tests in each of 30 frames a second, whoever knows the landings.
#[test]
fn progressive_elimination_keeps_up_with_500_leaves_a_second() {
    let (device, queue) = windfall_testing::device();
    let model = TreeModel::new(&device, &queue, &Species::Birch.grow_with(1, 5000)).unwrap();
    let placement = Placement {
        trees: 3,
        spacing: 6.0,
        keep_out: Vec::new(),
        scale: (0.9, 1.1),
        season_spread: 0.0,
        seed: 3,
    };
    let placed = placement.place(Terrain::rolling(200.0, 2.0, 5), &[1.0]);
    let shedding = Shedding { start: 0.0, duration: 30.0, peak: 0.0, tree_spread: 0.0, burst: 0.0 };
    let falls = Falls { shedding, capacity: 0, ..Falls::default() };
    let mut forest = Forest::new(&device, DVec3::ZERO, placed.terrain, falls).unwrap();
    forest.plant(&[model], &placed.instances).unwrap();
    let view = TreeList { pixels: 120.0, leaf_pixels: 10.0, ..TreeList::zeroed() };
    for landing in [LandingSearch::Ahead, LandingSearch::InShader] {
        let passes = PassOptions { landing, ..PassOptions::new(Strategy::Fragment) };
        let streams = Streams::new(&forest, 15_000);
        let mut lists =
            ActiveLeaves::new(&device, streams, &forest, Elimination::PROGRESSIVE, passes);
        let all = Streams::new(&forest, 15_000);
        let ahead = PassOptions::new(Strategy::Fragment);
        let mut known = ActiveLeaves::new(&device, all, &forest, Elimination::Scheduled, ahead);
        for frame in 0..750 {
            let moment = ListMoment { time: f64::from(frame) / 30.0, season: 0.5 };
            lists.update(&forest, moment, &view);
            known.update(&forest, moment, &view);
        }
        let (counts, truth) = (lists.counts(), known.counts());
        println!("{landing:?}: {counts:?}, {truth:?}");
        assert_eq!(counts.falling + counts.landed, truth.falling + truth.landed);
        // Falls take some ten seconds: those who landed in the last quarter of it may wait, and none that is due
        // for longer than a second.
        let late = truth.landed - counts.eliminated;
        let overdue = lists.waiting.iter().filter(|due| due.at < 24.0).count();
        println!("{late} late, {overdue} overdue");
        assert!(late < 1500 && truth.landed > 7000, "{landing:?}: {late} lie unseen");
        assert_eq!(overdue, 0, "{landing:?}");
    }
}

/// VB 5: a leaf lies from the moment at which its path meets the ground, and not before.
#[test]
fn a_leaf_in_the_list_lands_when_its_path_meets_the_ground() {
    let (device, queue) = windfall_testing::device();
    let model = TreeModel::new(&device, &queue, &Species::Birch.grow_with(1, 300)).unwrap();
    let shedding = Shedding { start: 0.0, duration: 1.0, ..Shedding::default() };
    let falls = Falls { shedding, capacity: 0, ..Falls::default() };
    let mut forest = Forest::new(&device, DVec3::ZERO, Terrain::flat(), falls).unwrap();
    let alone = [windfall_core::forest::Instance::alone(0, 1)];
    forest.plant(&[model], &alone).unwrap();
    let passes =
        PassOptions { landing: LandingSearch::InShader, ..PassOptions::new(Strategy::Vertex) };
    let streams = Streams::new(&forest, 300);
    let mut lists = ActiveLeaves::new(&device, streams, &forest, Elimination::PROGRESSIVE, passes);
    let view = TreeList { pixels: 120.0, leaf_pixels: 10.0, ..TreeList::zeroed() };
    // All have left their twigs, and none is tested yet.
    lists.update(&forest, ListMoment { time: 1.5, season: 0.5 }, &view);
    let fall = fall_of(&forest);
    let mut landed = 0;
    for (s, stream) in lists.streams.all.clone().iter().enumerate() {
        for entry in lists.listed[s].clone() {
            let of = lists.leaf_fall(&forest, stream, entry);
            let landing = fall.landing(&of);
            let due = Due { at: 0.0, stream: s as u32, entry };
            for early in [0.5 * landing.time, landing.time - 0.05] {
                assert!(!lists.land(&fall, &of, &due, early), "{early} of {}", landing.time);
            }
            assert_eq!(lists.counts().landed, landed);
            assert!(lists.land(&fall, &of, &due, landing.time + 0.5), "{}", landing.time);
            landed += 1;
            let Place::Active(at) = lists.slots[stream.slot(entry)].place else { unreachable!() };
            let leaf = &lists.active.regions[stream.region(false)].items[at as usize];
            assert_eq!(leaf.landing, landing.position.extend(landing.time));
        }
    }
    assert!(landed > 200 && lists.counts().landed == landed, "{landed}");
}
