//! How a model is drawn in parts, by the LOD bins of its trees.
//!
//! A model's leaves are drawn in parts, in prune order: [`WHOLE`] bounds a quarter of an octave
//! apart. A tree's *bin* is the lowest bound that holds all leaves it is drawn with; one above all
//! holds trees that are so near that their leaves have outlines. Lists of trees are
//! sorted by bin, so that each part is one draw of a prefix of the model's trees, and the work
//! follows the leaves that are drawn, not the trees that there are. Wood has lists of its own: there a
//! bin is a level of the simplified mesh, the finest the highest, drawn for a range of the list.

use crate::base::constants::{AT_VERTICES, BUCKETS, OCTAVE, WHOLE};

/// Parts of all leaves, before those of simplified trees.
pub const WHOLE_PARTS: u32 = 3;
/// Leaves below which a part is not worth a draw of its own.
const FEW_LEAVES: u32 = 64;

/// A part of a model that is drawn for the trees of some buckets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PartDraw {
    /// Lowest and highest bucket.
    pub buckets: (u32, u32),
    /// Indices of the part.
    pub indices: (u32, u32),
}

/// The bin of a tree that is drawn with this share of its leaves, in simple shapes: the CPU reference of
/// `bucket_of` in `pass/cull.wgsl`.
#[cfg(test)]
pub fn bucket_of(drawn: f32) -> u32 {
    let step = WHOLE as f32 + (OCTAVE * drawn.max(1e-9).log2()).ceil();
    step.clamp(1.0, WHOLE as f32) as u32
}

/// The largest share of leaves that trees of a bucket are drawn with.
pub fn bucket_share(bucket: u32) -> f32 {
    ((bucket as f32 - WHOLE as f32) / OCTAVE).exp2().min(1.0)
}

/// The parts of a model's leaves: all of them in their own shapes, the same to be lit at their vertices, all
/// in simple ones, then those of simplified trees. `starts` has the first index of each leaf and the end of
/// the last, `simple_starts` those of the same leaves in few triangles. Where draws cannot begin in the
/// middle of a list, the last parts are for all trees, and the first are empty.
pub fn leaf_parts(starts: &[u32], simple_starts: &[u32], first_instance: bool) -> Vec<PartDraw> {
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
pub fn wood_bucket(level: u32) -> u32 {
    BUCKETS - level
}

/// Ranges of indices of levels of a model's wood.
pub fn wood_parts(levels: &[(u32, (u32, u32))]) -> Vec<PartDraw> {
    let parts = levels.iter().map(|&(level, indices)| {
        let bucket = wood_bucket(level);
        PartDraw { buckets: (bucket, bucket), indices }
    });
    parts.filter(|part| part.indices.1 > 0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use windfall_core::simplify::SIMPLE_BELOW;

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
}
