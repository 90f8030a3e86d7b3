//! Prune orders: which leaves a simplified tree keeps.

use super::nearest::Nearest;
use super::{measure_visibility, visible_areas};
use glam::Vec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use windfall_core::foliage::Foliage;
use windfall_core::rng::Rng;
use windfall_core::simplify::PruneOrder;

/// Neighbours that a leaf is held against in [`PruneOrder::BlueNoise`]: as many as touch a ball.
const NEIGHBORS: usize = 12;

/// Puts the leaves into a prune order and measures what they show in it ([`Foliage::visibility`]); the shed order
/// keeps to the same leaves. The result depends on the leaves, `order` and `seed`, and not on the order before.
///
/// For 100,000 leaves this takes about half a second, a third of it for the visibility.
pub fn set_prune_order(foliage: &mut Foliage, order: PruneOrder, seed: u32) {
    reorder(foliage, order, seed);
    measure_visibility(foliage);
}

/// [`set_prune_order`] without the measurement.
pub(super) fn reorder(foliage: &mut Foliage, order: PruneOrder, seed: u32) {
    foliage.leaves.sort_by_key(|leaf| leaf.shed_rank);
    Rng::new(seed).stream(1).shuffle(&mut foliage.leaves);
    match order {
        PruneOrder::Random => {}
        PruneOrder::Importance => {
            let seen = visible_areas(foliage);
            let mut indices: Vec<u32> = (0..foliage.leaves.len() as u32).collect();
            indices.sort_by(|&a, &b| seen[b as usize].total_cmp(&seen[a as usize]));
            permute(foliage, &indices);
        }
        PruneOrder::BlueNoise => {
            let centers: Vec<Vec3> = foliage.leaves.iter().map(|leaf| leaf.center).collect();
            permute(foliage, &blue_noise(&centers));
        }
    }
    for (i, leaf) in foliage.leaves.iter().enumerate() {
        foliage.shed_order[leaf.shed_rank as usize] = i as u32;
    }
}

fn permute(foliage: &mut Foliage, indices: &[u32]) {
    foliage.leaves = indices.iter().map(|&i| foliage.leaves[i as usize]).collect();
}

/// Indices of points in an order of which every prefix is spread as all of them are.
fn blue_noise(points: &[Vec3]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    let mut count = order.len();
    while count > 1 {
        halve(points, &mut order[..count]);
        count = count.div_ceil(2);
    }
    order
}

/// Puts that half of `indices` to the front which is spread best, in the old order, and behind it
/// the others, so that the first of them fill its gaps all over.
fn halve(points: &[Vec3], indices: &mut [u32]) {
    let found = Nearest::new(indices.iter().map(|&i| points[i as usize])).all::<NEIGHBORS>();
    // How far the neighbourhood of each reaches.
    let reach: Vec<f32> =
        found.iter().map(|f| f.iter().last().map_or(0.0, |(far, _)| far.sqrt())).collect();
    let mut pairs: Vec<(u32, u32, f32)> = Vec::with_capacity(found.len() * NEIGHBORS);
    for (i, found) in found.iter().enumerate() {
        for (squared, j) in found.iter() {
            let both = 0.5 * (reach[i] + reach[j as usize]);
            let near = if both > 0.0 { 1.0 - squared.sqrt() / both } else { 1.0 };
            if near > 0.0 {
                // Yuksel's weight, with his exponent of 8.
                let weight = near.powi(8);
                pairs.push((i as u32, j, weight));
                pairs.push((j, i as u32, weight));
            }
        }
    }
    // Most pairs are there from both sides.
    pairs.sort_unstable_by_key(|&(i, j, _)| (i, j));
    pairs.dedup_by_key(|&mut (i, j, _)| (i, j));
    let mut starts = vec![0; indices.len() + 1];
    let mut crowding = vec![0.0f32; indices.len()];
    for &(i, _, weight) in &pairs {
        starts[i as usize + 1] += 1;
        crowding[i as usize] += weight;
    }
    for i in 0..indices.len() {
        starts[i + 1] += starts[i];
    }

    let mut heap: BinaryHeap<Crowded> =
        crowding.iter().zip(0..).map(|(&crowding, index)| Crowded { crowding, index }).collect();
    // Of each pair of neighbours one goes: every part of the crown loses half.
    let mut places: Vec<(Vec3, u32)> =
        indices.iter().map(|&i| points[i as usize]).zip(0..).collect();
    pair_up(&mut places);
    let mut partner: Vec<u32> = (0..indices.len() as u32).collect();
    let mut turn = vec![0; indices.len()];
    for (number, pair) in places.chunks(2).enumerate() {
        let [first, last] = [pair[0].1, pair[pair.len() - 1].1];
        partner[first as usize] = last;
        partner[last as usize] = first;
        // Bits of the pair's place, last first: pairs whose turns follow each other lie far apart.
        let place = (number as u64) << 33;
        turn[first as usize] = ((place / indices.len() as u64) as u32).reverse_bits();
        turn[last as usize] = turn[first as usize];
    }
    let mut settled = vec![false; indices.len()];
    let mut gone = Vec::with_capacity(indices.len() / 2);
    while let Some(Crowded { crowding: was, index }) = heap.pop() {
        let i = index as usize;
        if settled[i] || partner[i] == index {
            continue;
        }
        // Crowding only falls: what is out of date comes back where it belongs.
        if crowding[i] < was {
            heap.push(Crowded { crowding: crowding[i], index });
            continue;
        }
        settled[i] = true;
        settled[partner[i] as usize] = true;
        gone.push(i);
        for &(_, j, weight) in &pairs[starts[i]..starts[i + 1]] {
            crowding[j as usize] -= weight;
        }
    }
    gone.sort_unstable_by_key(|&i| (turn[i], i));
    let mut stays = vec![true; indices.len()];
    for &i in &gone {
        stays[i] = false;
    }
    let old = indices.to_vec();
    let kept = (0..old.len()).filter(|&i| stays[i]);
    for (slot, i) in indices.iter_mut().zip(kept.chain(gone.iter().copied())) {
        *slot = old[i];
    }
}

/// Orders places so that each two of them in turn are near each other, and so are each four, each
/// eight and so on: by halves along the longest side, of an even number.
fn pair_up(places: &mut [(Vec3, u32)]) {
    if places.len() <= 2 {
        return;
    }
    let (low, high) = places
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(p.0), h.max(p.0)));
    let axis = (high - low).max_position();
    let middle = (places.len() / 2).next_multiple_of(2);
    places.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]));
    let (below, above) = places.split_at_mut(middle);
    pair_up(below);
    pair_up(above);
}

/// A point by how near its neighbours are; the most crowded is the largest.
struct Crowded {
    crowding: f32,
    index: u32,
}

impl Ord for Crowded {
    fn cmp(&self, other: &Self) -> Ordering {
        self.crowding.total_cmp(&other.crowding).then(self.index.cmp(&other.index))
    }
}

impl PartialOrd for Crowded {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Crowded {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Crowded {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Species;

    /// Mean and least distance to the nearest neighbour.
    fn spacing(points: &[Vec3]) -> (f32, f32) {
        let found = Nearest::new(points.iter().copied()).all::<1>();
        let distances = found.iter().flat_map(|f| f.iter().map(|(squared, _)| squared.sqrt()));
        let (sum, least) =
            distances.fold((0.0, f32::INFINITY), |(sum, least), d| (sum + d, d.min(least)));
        (sum / points.len() as f32, least)
    }

    /// Variance, over cells of the crown, of the leaves of the first `share` about the same share of
    /// the cell's; 1 for leaves that are picked by chance and few.
    fn variance(all: &[Vec3], share: f32) -> f32 {
        let (low, high) = all
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
        let cell = |p: Vec3| ((p - low) / (high - low) * 3.999).as_uvec3();
        let mut counts = vec![[0.0f32; 2]; 64];
        let few = (all.len() as f32 * share) as usize;
        for (i, &p) in all.iter().enumerate() {
            let at = cell(p);
            let counts = &mut counts[(at.x + 4 * at.y + 16 * at.z) as usize];
            counts[0] += 1.0;
            counts[1] += if i < few { 1.0 } else { 0.0 };
        }
        let squares: f32 = counts.iter().map(|[all, few]| (few - share * all).powi(2)).sum();
        squares / few as f32
    }

    fn centers(foliage: &Foliage) -> Vec<Vec3> {
        foliage.leaves.iter().map(|leaf| leaf.center).collect()
    }

    #[test]
    fn prefixes_of_blue_noise_are_spread_more_evenly_than_random_ones() {
        let mut foliage = Species::Birch.grow_with(5, 6000).foliage;
        let random = centers(&foliage);
        set_prune_order(&mut foliage, PruneOrder::BlueNoise, 5);
        let blue = centers(&foliage);
        // At halvings of the crown and between them.
        for share in [0.04, 0.0625, 0.18, 0.25, 0.35, 0.5] {
            let few = (6000.0 * share) as usize;
            let [(random_mean, random_least), (blue_mean, blue_least)] =
                [&random, &blue].map(|points| spacing(&points[..few]));
            assert!(blue_mean > 1.2 * random_mean, "{share}: {blue_mean} {random_mean}");
            assert!(blue_least > 2.0 * random_least, "{share}: {blue_least} {random_least}");
            let [random, blue] = [&random, &blue].map(|points| variance(points, share));
            assert!(blue < 0.7 * random, "{share}: {blue} {random}");
        }
    }

    #[test]
    fn the_leaves_and_their_shed_order_stay_the_same() {
        let was = Species::Ginkgo.grow_with(2, 500).foliage;
        for order in PruneOrder::ALL {
            let mut foliage = was.clone();
            set_prune_order(&mut foliage, order, 9);
            assert_ne!(centers(&foliage), centers(&was), "{order}");
            for rank in 0..500 {
                let [a, b] = [&was, &foliage].map(|f| f.leaves[f.shed_order[rank] as usize]);
                assert_eq!(a, b);
                assert_eq!(a.shed_rank, rank as u32);
            }
            // Whatever the order was before.
            let mut again = was.clone();
            set_prune_order(&mut again, PruneOrder::Importance, 3);
            set_prune_order(&mut again, order, 9);
            assert_eq!(again.leaves, foliage.leaves);
        }
    }

    #[test]
    fn the_most_visible_come_first() {
        let mut foliage = Species::Beech.grow_with(1, 3000).foliage;
        set_prune_order(&mut foliage, PruneOrder::Importance, 1);
        let seen = visible_areas(&foliage);
        assert!(seen.is_sorted_by(|a, b| a >= b));
        assert!(seen[100] > 2.0 * seen[2000], "{} {}", seen[100], seen[2000]);
    }

    #[test]
    fn poison_is_ordered_too() {
        let line: Vec<Vec3> = (0..40).map(|i| Vec3::X * i as f32).collect();
        let mixed = [vec![Vec3::NAN; 30], vec![Vec3::INFINITY; 3], line].concat();
        for points in [
            vec![],
            vec![Vec3::ONE],
            vec![Vec3::ONE, Vec3::ZERO],
            vec![Vec3::ONE; 3],
            vec![Vec3::ONE; 5000],
            vec![Vec3::splat(f32::MAX); 9],
            mixed,
        ] {
            let mut order = blue_noise(&points);
            order.sort_unstable();
            assert!(order.iter().copied().eq(0..points.len() as u32));
        }
        let mut nothing = Foliage::default();
        for order in PruneOrder::ALL {
            set_prune_order(&mut nothing, order, 1);
        }
    }
}
