//! The nearest neighbours of points in space: a balanced k-d tree in one array.

use glam::Vec3;

/// Ranges as short as this are searched one by one.
const BUCKET: usize = 8;

/// Points, each in the middle of its range, with those before it below it along an axis.
pub(super) struct Nearest {
    /// Points and their numbers.
    points: Vec<(Vec3, u32)>,
    /// The axis that splits the range of which this is the middle.
    axes: Vec<u8>,
}

/// Up to `K` neighbours, nearest first: squared distance and number.
#[derive(Clone, Copy)]
pub(super) struct Found<const K: usize> {
    list: [(f32, u32); K],
    len: usize,
}

impl<const K: usize> Found<K> {
    pub fn iter(&self) -> impl Iterator<Item = (f32, u32)> {
        self.list.iter().copied().take(self.len)
    }

    fn bound(&self) -> f32 {
        if self.len < K { f32::INFINITY } else { self.list[K - 1].0 }
    }

    fn offer(&mut self, distance: f32, number: u32) {
        // A distance that is not a number is never below.
        if distance < self.bound() {
            let mut at = self.len.min(K - 1);
            while at > 0 && self.list[at - 1].0 > distance {
                self.list[at] = self.list[at - 1];
                at -= 1;
            }
            self.list[at] = (distance, number);
            self.len = (self.len + 1).min(K);
        }
    }
}

impl Nearest {
    pub fn new(points: impl Iterator<Item = Vec3>) -> Self {
        let mut points: Vec<(Vec3, u32)> = points.zip(0..).collect();
        let mut axes = vec![0; points.len()];
        split(&mut points, &mut axes);
        Self { points, axes }
    }

    /// The `K` nearest neighbours of every point, by its number.
    pub fn all<const K: usize>(&self) -> Vec<Found<K>> {
        let none = Found { list: [(0.0, 0); K], len: 0 };
        let mut all = vec![none; self.points.len()];
        for &(point, number) in &self.points {
            let found = &mut all[number as usize];
            self.search(0, self.points.len(), point, number, found);
        }
        all
    }

    fn search<const K: usize>(
        &self,
        low: usize,
        high: usize,
        from: Vec3,
        own: u32,
        found: &mut Found<K>,
    ) {
        let offer = |range: &[(Vec3, u32)], found: &mut Found<K>| {
            for &(point, number) in range {
                if number != own {
                    found.offer(point.distance_squared(from), number);
                }
            }
        };
        if high - low <= BUCKET {
            return offer(&self.points[low..high], found);
        }
        let middle = low.midpoint(high);
        let axis = usize::from(self.axes[middle]);
        let beyond = from[axis] - self.points[middle].0[axis];
        let [near, far] = if beyond < 0.0 {
            [(low, middle), (middle + 1, high)]
        } else {
            [(middle + 1, high), (low, middle)]
        };
        self.search(near.0, near.1, from, own, found);
        offer(&self.points[middle..=middle], found);
        if beyond * beyond < found.bound() {
            self.search(far.0, far.1, from, own, found);
        }
    }
}

fn split(points: &mut [(Vec3, u32)], axes: &mut [u8]) {
    if points.len() <= BUCKET {
        return;
    }
    let (low, high) = points
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(p.0), h.max(p.0)));
    let axis = (high - low).max_position();
    let middle = points.len() / 2;
    points.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]));
    axes[middle] = axis as u8;
    let (below, above) = points.split_at_mut(middle);
    let (axes_below, axes_above) = axes.split_at_mut(middle);
    split(below, axes_below);
    split(&mut above[1..], &mut axes_above[1..]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use windfall_core::rng::Rng;

    #[test]
    fn neighbours_are_those_of_a_search_through_all() {
        let mut rng = Rng::new(3);
        let mut points: Vec<Vec3> =
            (0..300).map(|_| Vec3::new(rng.unit(), rng.unit(), 0.1 * rng.unit())).collect();
        points.extend([points[0]; 20]);
        let found = Nearest::new(points.iter().copied()).all::<5>();
        for (i, found) in found.iter().enumerate() {
            let mut all: Vec<f32> = points.iter().map(|p| p.distance_squared(points[i])).collect();
            all.remove(i);
            all.sort_by(f32::total_cmp);
            let distances: Vec<f32> = found.iter().map(|(distance, _)| distance).collect();
            assert_eq!(distances, all[..5]);
            assert!(found.iter().all(|(d, j)| {
                j as usize != i && points[j as usize].distance_squared(points[i]) == d
            }));
        }
    }

    #[test]
    fn few_points_have_few_neighbours() {
        assert!(Nearest::new([].into_iter()).all::<3>().is_empty());
        let one = Nearest::new([Vec3::ZERO].into_iter()).all::<3>();
        assert_eq!(one[0].iter().count(), 0);
        let poison = Nearest::new([Vec3::NAN, Vec3::ZERO, Vec3::ONE].into_iter()).all::<3>();
        let counts: Vec<usize> = poison.iter().map(|found| found.iter().count()).collect();
        assert_eq!(counts, [0, 1, 1]);
    }
}
