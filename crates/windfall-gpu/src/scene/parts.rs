//! How a model is drawn in parts, by the LOD bins of its trees.
//!
//! A model's leaves are drawn in parts, in prune order: [`BUCKETS`] bounds a quarter of an octave
//! apart. A tree's *bin* is the lowest bound that holds all leaves it is drawn with. Lists of trees are
//! sorted by bin, so that each part is one draw of a prefix of the model's trees, and the work
//! follows the leaves that are drawn, not the trees that there are. There is a list for each form of leaves; a tree
//! may be in several, and each of its leaves is drawn with one. Wood has lists of its own: there a
//! bin is a level of the simplified mesh, the finest the highest, drawn for a range of the list.

use crate::base::constants::{BUCKETS, OCTAVE, OUTLINES, SIMPLE, WOOD};

/// Leaves below which a part is not worth a draw of its own.
const FEW_LEAVES: u32 = 64;
/// Bins of a part of outlines: few trees are near enough to have them.
const COARSE: u32 = OCTAVE as u32;

/// A part of a model that is drawn for the trees of some buckets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PartDraw {
    /// The kind of lists that it is drawn for; outlines also where they are lit in pixels.
    pub kind: u32,
    /// Lowest and highest bucket.
    pub buckets: (u32, u32),
    /// Indices of the part.
    pub indices: (u32, u32),
}

/// The bin of a tree that is drawn with this share of its leaves: the CPU reference of
/// `bucket_of` in `pass/cull.wgsl`.
#[cfg(test)]
pub fn bucket_of(drawn: f32) -> u32 {
    let step = BUCKETS as f32 + (OCTAVE * drawn.max(1e-9).log2()).ceil();
    step.clamp(1.0, BUCKETS as f32) as u32
}

/// The largest share of leaves that trees of a bucket are drawn with.
pub fn bucket_share(bucket: u32) -> f32 {
    ((bucket as f32 - BUCKETS as f32) / OCTAVE).exp2().min(1.0)
}

/// The parts of a model's leaves: outlines, then simple shapes. `starts` has the first index of each leaf's outline
/// and the end of the last, `simple_starts` those of the same leaves in few triangles.
pub fn leaf_parts(starts: &[u32], simple_starts: &[u32]) -> Vec<PartDraw> {
    let mut parts = prefixes(OUTLINES, COARSE, starts);
    parts.extend(prefixes(SIMPLE, 1, simple_starts));
    parts
}

/// Parts of so many bins each, every one of which continues the one before.
fn prefixes(kind: u32, step: u32, starts: &[u32]) -> Vec<PartDraw> {
    let leaves = starts.len() as u32 - 1;
    let mut parts = Vec::new();
    let (mut low, mut first) = (1, 0);
    for bucket in (1..=BUCKETS).filter(|bucket| bucket % step == 0) {
        let end = (f64::from(bucket_share(bucket)) * f64::from(leaves)).ceil() as u32;
        if end - first >= FEW_LEAVES || (bucket == BUCKETS && end > first) {
            let [a, b] = [first, end].map(|leaf| starts[leaf as usize]);
            parts.push(PartDraw { kind, buckets: (low, BUCKETS), indices: (a, b - a) });
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
        PartDraw { kind: WOOD, buckets: (bucket, bucket), indices }
    });
    parts.filter(|part| part.indices.1 > 0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buckets_hold_what_is_drawn_and_little_more() {
        for drawn in [1.0, 0.999, 0.5, 0.3, 0.06, 0.001, 1e-5, 0.0, f32::NAN] {
            let bucket = bucket_of(drawn);
            assert!((1..=BUCKETS).contains(&bucket), "{drawn}: {bucket}");
            if drawn > bucket_share(1) {
                let share = bucket_share(bucket);
                assert!(share >= drawn * 0.9999 && share < drawn * 1.19, "{drawn}: {share}");
            }
        }
    }

    #[test]
    fn parts_of_a_kind_are_each_leaf_once() {
        for leaves in [0u32, 1, 63, 64, 65, 1000, 20_000] {
            // Leaves of three and six indices in turn; behind them the same leaves of two triangles each.
            let starts: Vec<u32> = (0..=leaves).map(|i| i / 2 * 9 + i % 2 * 3).collect();
            let simple: Vec<u32> = (0..=leaves).map(|i| starts[leaves as usize] + 6 * i).collect();
            let parts = leaf_parts(&starts, &simple);
            for (kind, starts) in [(OUTLINES, &starts), (SIMPLE, &simple)] {
                let of_kind = || parts.iter().filter(|part| part.kind == kind);
                let (mut end, mut low) = (starts[0], 0);
                for part in of_kind() {
                    assert_eq!(part.indices.0, end, "{leaves}: {parts:?}");
                    assert!(
                        part.indices.1 > 0 && part.buckets.0 > low && part.buckets.1 == BUCKETS
                    );
                    (end, low) = (part.indices.0 + part.indices.1, part.buckets.0);
                }
                assert_eq!(end, starts[leaves as usize]);
                // Trees of any bucket are drawn with the leaves that they need.
                for bucket in 1..=BUCKETS {
                    let drawn: u32 =
                        of_kind().filter(|p| p.buckets.0 <= bucket).map(|p| p.indices.1).sum();
                    let needed = (f64::from(bucket_share(bucket)) * f64::from(leaves)) as usize;
                    assert!(drawn >= starts[needed] - starts[0], "{leaves}, bucket {bucket}");
                }
            }
        }
    }

    #[test]
    fn each_level_of_wood_has_a_bucket() {
        let parts = wood_parts(&[(0, (0, 3000)), (1, (3000, 1500)), (2, (4500, 300))]);
        assert_eq!(parts.len(), 3);
        assert_eq!(parts[2], PartDraw { kind: WOOD, buckets: (46, 46), indices: (4500, 300) });
        assert_eq!(wood_parts(&[(0, (0, 0))]), []);
    }
}
