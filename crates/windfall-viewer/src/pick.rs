//! The leaf under the pointer: on its twig, or in the air.

use glam::{DVec3, Vec3};
use windfall_core::path::{Fall, LeafFall, Phase};
use windfall_core::shed::Shedding;
use windfall_gpu::Falls;
use windfall_scenes::{EventEntry, Stage};

/// Longest that a leaf is looked for in the air, seconds after it detached.
const LONGEST_FALL: f64 = 60.0;
/// A leaf this near to the pointer is under it, pixels: leaves sway.
const NEAR: f32 = 5.0;

/// A ray through a pixel.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    /// Where it begins.
    pub eye: DVec3,
    /// Unit vector along it.
    pub along: DVec3,
    /// Size of a pixel at a distance of one metre, metres.
    pub pixel: f64,
}

/// A leaf under the pointer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Index of its tree.
    pub tree: usize,
    /// Its index on it, in prune order.
    pub leaf: u32,
    /// Distance along the ray, metres.
    pub distance: f32,
    /// What it is doing.
    pub phase: Phase,
    /// When it detaches, seconds.
    pub detach: f64,
}

/// The nearest leaf along a ray at a moment. `thrown` are leaves that detach at a moment of their own.
pub fn leaf(
    stage: &Stage,
    falls: &Falls,
    thrown: &[EventEntry],
    time: f64,
    ray: &Ray,
) -> Option<Hit> {
    let fall = Fall::new(
        &falls.paths,
        &stage.forest.terrain,
        falls.wind,
        falls.variation.clone(),
        falls.settings,
    );
    let (eye, along) = (ray.eye.as_vec3(), ray.along.as_vec3());
    let mut nearest: Option<Hit> = None;
    for (tree, instance) in stage.forest.instances.iter().enumerate() {
        let model = &stage.trees[instance.model as usize];
        let foliage = &model.foliage;
        let (low, high) = model.bounds();
        let middle = instance.position + Vec3::Y * (0.5 * (low.y + high.y) * instance.scale);
        // Leaves that fall drift away from their crown.
        let radius = 0.5 * (high - low).length() * instance.scale + 8.0;
        let ahead = (middle - eye).dot(along);
        let aside = (middle - eye - along * ahead).length();
        if aside > radius || ahead < -radius || nearest.is_some_and(|n| ahead - radius > n.distance)
        {
            continue;
        }
        let shed = falls.shedding.tree(instance, foliage.leaves.len() as u32, &falls.wind);
        let gusts = Shedding::gust_rate(&falls.wind);
        let gone = falls.shedding.detached(&shed, gusts, time);
        let landed = falls.shedding.detached(&shed, gusts, time - LONGEST_FALL);
        let group = falls.group_of(&model.name);
        let own = |leaf: u32| {
            let events = thrown.iter().filter(|e| e.tree as usize == tree && e.leaf == leaf);
            events.map(|e| e.time).min_by(f64::total_cmp)
        };
        for (index, leaf) in foliage.leaves.iter().enumerate() {
            // By the season those of lower rank have gone; a search for few.
            if leaf.shed_rank < landed {
                continue;
            }
            let index = index as u32;
            let early = if thrown.is_empty() { None } else { own(index) };
            let is_gone = leaf.shed_rank < gone || early.is_some_and(|early| early <= time);
            let mut place = instance.world_from_tree(leaf.center);
            let mut phase = Phase::Hanging;
            let mut detach = f64::INFINITY;
            if is_gone {
                let season = falls.shedding.detach_time(&shed, gusts, leaf.shed_rank);
                detach = early.map_or(season, |early| early.min(season));
                let of = LeafFall::of(instance, leaf, group, detach);
                let pose = fall.pose(&of, &fall.landing(&of), time);
                (place, phase) = (pose.position, pose.phase);
                if phase == Phase::Landed {
                    continue;
                }
            }
            let ahead = (place - eye).dot(along);
            if ahead < 0.1 || nearest.is_some_and(|n| ahead >= n.distance) {
                continue;
            }
            let size = 0.04 * leaf.scale.min(4.0) * instance.scale;
            let reach = size.max(NEAR * ray.pixel as f32 * ahead);
            if (place - eye - along * ahead).length_squared() < reach * reach {
                nearest = Some(Hit { tree, leaf: index, distance: ahead, phase, detach });
            }
        }
    }
    // Only the one that is shown needs to know when it will fall.
    nearest.map(|hit| match hit.phase {
        Phase::Hanging => Hit { detach: detach_time(stage, falls, &hit), ..hit },
        _ => hit,
    })
}

fn detach_time(stage: &Stage, falls: &Falls, hit: &Hit) -> f64 {
    let instance = &stage.forest.instances[hit.tree];
    let foliage = &stage.trees[instance.model as usize].foliage;
    let shed = falls.shedding.tree(instance, foliage.leaves.len() as u32, &falls.wind);
    let rank = foliage.leaves[hit.leaf as usize].shed_rank;
    falls.shedding.detach_time(&shed, Shedding::gust_rate(&falls.wind), rank)
}

/// A leaf in words.
pub fn text(stage: &Stage, hit: &Hit, time: f64) -> String {
    let instance = &stage.forest.instances[hit.tree];
    let name = &stage.trees[instance.model as usize].name;
    let name = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let age = match hit.phase {
        Phase::Hanging if hit.detach > 1e9 => "hangs".to_owned(),
        Phase::Hanging => format!("hangs for {:.1} s more; click: it falls", hit.detach - time),
        Phase::Falling { .. } => format!("has been falling for {:.1} s", time - hit.detach),
        Phase::Landed => "lies on the ground".to_owned(),
    };
    format!("{name}, tree {}, leaf {}\n{age}", hit.tree, hit.leaf)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    fn stage() -> Stage {
        let mut scene = windfall_scenes::named("lone-oak").unwrap();
        scene.count = 1;
        scene.build(|_, _| -> Result<_, Infallible> { unreachable!() }).unwrap()
    }

    #[test]
    fn a_leaf_is_found_on_its_twig_and_in_the_air() {
        let stage = stage();
        let falls = Falls { shedding: Shedding::never(), ..stage.falls.clone() };
        let instance = &stage.forest.instances[0];
        let leaves = &stage.trees[0].foliage.leaves;
        // The outermost leaf towards +X is not hidden by others from there.
        let far = |i: &usize| instance.world_from_tree(leaves[*i].center).x;
        let outer = (0..leaves.len()).max_by(|a, b| far(a).total_cmp(&far(b))).unwrap();
        let place = instance.world_from_tree(leaves[outer].center).as_dvec3();
        let eye = place + DVec3::X * 5.0;
        let ray = Ray { eye, along: DVec3::NEG_X, pixel: 1e-4 };
        let hit = leaf(&stage, &falls, &[], 3.0, &ray).unwrap();
        assert_eq!((hit.tree, hit.leaf, hit.phase), (0, outer as u32, Phase::Hanging));
        assert!((hit.distance - 5.0).abs() < 1e-3);
        assert!(text(&stage, &hit, 3.0).ends_with("hangs"));
        // Thrown, it is no longer there, and found where it falls.
        let event = EventEntry { tree: 0, leaf: outer as u32, time: 2.0 };
        let gone = leaf(&stage, &falls, &[event], 3.0, &ray);
        assert!(gone.is_none_or(|hit| hit.leaf != outer as u32));
        let fall = Fall::new(
            &falls.paths,
            &stage.forest.terrain,
            falls.wind,
            falls.variation.clone(),
            falls.settings,
        );
        let group = falls.group_of(&stage.trees[0].name);
        let of = LeafFall::of(instance, &leaves[outer], group, 2.0);
        let now = fall.pose(&of, &fall.landing(&of), 3.0).position.as_dvec3();
        let ray = Ray { eye: now + DVec3::X * 2.0, ..ray };
        let hit = leaf(&stage, &falls, &[event], 3.0, &ray).unwrap();
        assert_eq!(hit.leaf, outer as u32);
        assert!((hit.detach - 2.0).abs() < 1e-9 && matches!(hit.phase, Phase::Falling { .. }));
        // Nothing is there in the sky.
        let up = Ray { eye: DVec3::Y * 60.0, along: DVec3::Y, pixel: 1e-3 };
        assert_eq!(leaf(&stage, &falls, &[], 3.0, &up), None);
    }
}
