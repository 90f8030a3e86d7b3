//! Levels of detail of the wood (SFS, 6): when branches vanish, and how wide the others are drawn.

/// One level of detail of the wood.
#[derive(Debug, Clone, PartialEq)]
pub struct WoodLevel {
    /// Triangles, three indices each into the vertices of the wood, which are moved by [`Branch::widening`].
    pub indices: Vec<u32>,
    /// Smallest error from which on the level may be drawn, metres: half the size of a pixel at its distance.
    pub error: f32,
}

/// A connected piece of the wood, such as a stem, limb or twig.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Branch {
    /// Mean radius, metres.
    pub radius: f32,
    /// The error about which it vanishes, metres.
    pub vanishes: f32,
}

/// Half the range of errors over which a branch vanishes, relative to [`Branch::vanishes`]: `R` of SFS, equation 6,
/// as a fraction of `λ`.
pub const WOOD_FADE: f32 = 0.2;

impl Branch {
    /// Displacement of the branch's vertices along their normals, metres, when the wood is drawn with an error of
    /// `error` metres, such as half a pixel: it makes the branch at least twice that wide, or shrinks it to nothing.
    ///
    /// Branches thinner than a pixel are drawn one pixel wide, and proportionally fewer of them: the stochastic
    /// simplification of Cook et al. 2007 (SFS, equations 3 and 6) for twigs. Without it they would
    /// all vanish at once, and bare trees would lose their crowns.
    pub fn widening(&self, error: f32) -> f32 {
        let left = ((1.0 + WOOD_FADE - error / self.vanishes) / (2.0 * WOOD_FADE)).clamp(0.0, 1.0);
        self.radius.max(error) * left - self.radius
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_branch_is_as_wide_as_a_pixel_until_it_vanishes() {
        let twig = Branch { radius: 0.004, vanishes: 0.02 };
        // Thicker than the error: as it is.
        assert_eq!(twig.widening(0.0), 0.0);
        assert_eq!(twig.widening(0.004), 0.0);
        // Thinner: as thick as the error, up to 0.8 of the error at which it vanishes.
        assert!((twig.radius + twig.widening(0.012) - 0.012).abs() < 1e-6);
        // Half of that about it, and nothing from 1.2 times on.
        assert!((twig.radius + twig.widening(0.02) - 0.01).abs() < 1e-6);
        assert_eq!(twig.radius + twig.widening(0.0241), 0.0);
        // The widest never vanishes.
        let trunk = Branch { radius: 0.3, vanishes: f32::MAX };
        assert!((trunk.radius + trunk.widening(5.0) - 5.0).abs() < 1e-5);
    }
}
