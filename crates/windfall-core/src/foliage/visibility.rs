//! What a crown shows of its leaves, and by how much survivors must grow to make up for the others.
//!
//! The numbers are measured when a tree is prepared (crate `windfall-tree`); here is what simplification
//! computes from them. SFS: S. Fichtner, "GPU Based Stochastic Foliage Simplification".

/// Measured visibility of the leaves of a crown, for simplification.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Visibility {
    /// `r` of SFS, equation 3: the mean projected area of one leaf over the projected area of the
    /// crown, `0..=1`. 1 for a single leaf, and for leaves that each hide all others; 0 for a
    /// crown without leaves or extent.
    ///
    /// SFS (6) estimates the numerator as `2/π` of the leaf's area, the mean of a cosine over
    /// *angles*. Over directions in space the mean is `½`, and real leaves differ from both: here both
    /// areas are counted in the same renders.
    pub share: f32,
    /// Factors on `s` of equation 3, above 0 and mostly below 1, that make a quarter, a sixteenth and a 64th of
    /// the leaves cover as much as the whole crown does.
    ///
    /// Equation 3 assumes that leaves are scattered at random. In real crowns they stand in
    /// clusters with gaps between, into which survivors grow; and a prune order that spreads survivors, or
    /// puts the outermost first, makes them overlap less. Measured in the prune order that
    /// the leaves have, down to 16 leaves; below that, the last factor is kept.
    pub disocclusion: [f32; 3],
    /// Factors on the sunlight of survivors, `½..=1`, that give the visible ones the same mean sunlight as the visible
    /// part of the whole crown, at a quarter, a sixteenth and a 64th of the leaves.
    ///
    /// Leaves shade each other. A survivor stands for many leaves that are partly in shade, but reaches beyond them
    /// into the light itself: the more so, the larger leaves are compared with their crown. 1 where
    /// leaves have no textures: those are lit once, by the mean of their corners, which was measured to be right.
    pub sunlight: [f32; 3],
}

impl Default for Visibility {
    /// Nothing to see.
    fn default() -> Self {
        Self { share: 0.0, disocclusion: Self::BY_CHANCE, sunlight: Self::BY_CHANCE }
    }
}

impl Visibility {
    /// Shares of the leaves at which the factors are measured.
    pub const MEASURED: [f32; 3] = [1.0 / 4.0, 1.0 / 16.0, 1.0 / 64.0];
    /// [`Self::disocclusion`] of leaves that are scattered at random; also the neutral [`Self::sunlight`].
    pub const BY_CHANCE: [f32; 3] = [1.0; 3];

    /// A factor at `lambda`, interpolated linearly in its logarithm.
    fn factor([a, b, c]: [f32; 3], lambda: f32) -> f32 {
        let quarters = -0.5 * lambda.log2();
        let step = |i: f32| (quarters - i).clamp(0.0, 1.0);
        1.0 + step(0.0) * (a - 1.0) + step(1.0) * (b - a) + step(2.0) * (c - b)
    }

    /// Factor on the area of survivors when the share `lambda` of the leaves is drawn, at least 1:
    /// [`area_scale`] corrected for this crown.
    pub fn area_scale(&self, lambda: f32) -> f32 {
        (area_scale(lambda, self.share) * Self::factor(self.disocclusion, lambda)).max(1.0)
    }

    /// Inverse of [`Self::area_scale`]: the `λ` at which it is `s`, at most 1; 0 if it never is.
    pub fn share_for(&self, s: f32) -> f32 {
        let mut lambda = 1.0f32;
        // Each round leaves less than 0.9 of the error, mostly a fifth.
        for _ in 0..24 {
            let next = share_for(s / Self::factor(self.disocclusion, lambda), self.share);
            if next <= 0.0 {
                return 0.0;
            }
            lambda = next;
        }
        lambda
    }
}

/// `s` of equation 3: factor on the area of survivors when the share `lambda` of the leaves is drawn and one leaf
/// shows the share `r` of the crown's visible area. 1 for `λ = 1`; at most `1/r`.
pub fn area_scale(lambda: f32, r: f32) -> f32 {
    let (lambda, r) = (f64::from(lambda), f64::from(r.clamp(1e-9, 0.999)));
    (-((-r).ln_1p() / lambda).exp_m1() / r) as f32
}

/// Inverse of [`area_scale`]: the `λ` at which it is `s`, at most 1; 0 if it never is.
pub fn share_for(s: f32, r: f32) -> f32 {
    let (s, r) = (f64::from(s), f64::from(r.clamp(1e-9, 0.999)));
    if s * r >= 1.0 {
        return 0.0;
    }
    ((-r).ln_1p() / (-r * s).ln_1p()).min(1.0) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_of_area_and_its_inverse_agree() {
        for share in [1e-4, 0.01] {
            let falling = |by: f32| [1, 2, 3].map(|i| 4f32.powf(-by * i as f32));
            let flat = [0.7, 0.6, 0.65];
            for disocclusion in
                [falling(-0.3), Visibility::BY_CHANCE, falling(0.2), falling(0.6), flat]
            {
                let seen = Visibility { share, disocclusion, ..Visibility::default() };
                assert_eq!(seen.area_scale(1.0), 1.0);
                for lambda in [0.9, 0.5, 0.1, 0.05] {
                    let back = seen.share_for(seen.area_scale(lambda));
                    assert!((back / lambda - 1.0).abs() < 2e-3, "{seen:?} {lambda}: {back}");
                }
            }
        }
        assert_eq!(Visibility { share: 0.1, ..Visibility::default() }.share_for(20.0), 0.0);
    }

    #[test]
    fn visible_area_is_preserved() {
        // Elements that cover r of the whole at random leave (1-r)^N of it uncovered; a share λ of
        // them, s as large, must leave as much: (1 - s r)^(λ N) = (1 - r)^N.
        for r in [1e-5, 1e-3, 0.05] {
            for lambda in [1.0, 0.5, 0.06, 0.01] {
                let s = f64::from(area_scale(lambda, r));
                let r = f64::from(r);
                let kept = (-s * r).ln_1p() * f64::from(lambda);
                assert!((kept / (-r).ln_1p() - 1.0).abs() < 1e-3, "{r} {lambda}: {s}");
                assert!((share_for(s as f32, r as f32) / lambda - 1.0).abs() < 1e-3);
            }
        }
        assert!((area_scale(1.0, 1e-4) - 1.0).abs() < 1e-6);
        assert_eq!(share_for(1000.0, 0.01), 0.0);
    }
}
