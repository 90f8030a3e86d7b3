//! A height field: the ground that trees stand on and leaves land on.
//!
//! Each cell is two triangles, the same that are drawn, so that a leaf lies on the visible ground
//! exactly.

use crate::rng::{hash, unit};
use glam::{Vec2, Vec3};

/// A square height field around the origin, two triangles a cell, level beyond its edge.
#[derive(Debug, Clone, PartialEq)]
pub struct Terrain {
    side: u32,
    cell: f32,
    heights: Vec<f32>,
}

impl Terrain {
    /// Level ground at height 0.
    pub fn flat() -> Self {
        Self { side: 2, cell: 1.0, heights: vec![0.0; 4] }
    }

    /// A height field of `side * side` samples, `cell` metres apart, centred on the origin; rows go
    /// from -Z to +Z, samples of a row from -X to +X.
    ///
    /// # Panics
    ///
    /// If `side < 2`, `cell` is not above 0, the count is not `side²`, or a height is not finite:
    /// a mistake of the caller's.
    pub fn new(side: u32, cell: f32, heights: Vec<f32>) -> Self {
        assert!(side >= 2 && cell > 0.0 && cell.is_finite(), "side {side}, cell {cell}");
        assert_eq!(heights.len(), (side * side) as usize, "a height field is square");
        assert!(heights.iter().all(|h| h.is_finite()), "heights must be finite");
        Self { side, cell, heights }
    }

    /// Rolling ground, `extent` metres across, hills up to about `relief` metres: four octaves of
    /// value noise, of 60 m and shorter. `relief = 0` is level.
    pub fn rolling(extent: f32, relief: f32, seed: u32) -> Self {
        if relief == 0.0 {
            return Self::flat();
        }
        let side = ((extent / 2.0).ceil() as u32 + 1).clamp(2, 1025);
        let cell = extent / (side - 1) as f32;
        let half = extent * 0.5;
        let heights = (0..side * side)
            .map(|i| {
                let at = Vec2::new((i % side) as f32, (i / side) as f32) * cell - half;
                let octave = |k: i32| {
                    let wavelength = 60.0 / 2.2f32.powi(k);
                    (value_noise(at / wavelength, hash(seed, k as u32)) - 0.5) * 0.36f32.powi(k)
                };
                relief * (0..4).map(octave).sum::<f32>()
            })
            .collect();
        Self::new(side, cell, heights)
    }

    /// An even slope: height `gradient · (x, z)`, over `extent` metres.
    pub fn slope(gradient: Vec2, extent: f32) -> Self {
        let half = extent * 0.5;
        let corner = |x: f32, z: f32| gradient.dot(Vec2::new(x, z) * half);
        let heights =
            vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0)];
        Self::new(2, extent, heights)
    }

    /// Samples along one side.
    pub fn side(&self) -> u32 {
        self.side
    }

    /// Distance between samples, metres.
    pub fn cell(&self) -> f32 {
        self.cell
    }

    /// All samples, row by row.
    pub fn heights(&self) -> &[f32] {
        &self.heights
    }

    /// Width and depth of the field, metres.
    pub fn extent(&self) -> f32 {
        self.cell * (self.side - 1) as f32
    }

    /// Lowest and highest height.
    pub fn range(&self) -> (f32, f32) {
        self.heights
            .iter()
            .fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), &y| (l.min(y), h.max(y)))
    }

    /// Height of the ground at `(x, z)`.
    pub fn height(&self, x: f32, z: f32) -> f32 {
        let patch = self.patch(x, z);
        patch.height + patch.gradient.dot(patch.offset)
    }

    /// Unit normal of the ground at `(x, z)`.
    pub fn normal(&self, x: f32, z: f32) -> Vec3 {
        let patch = self.patch(x, z);
        let slope = patch.gradient * patch.inside / self.cell;
        Vec3::new(-slope.x, 1.0, -slope.y).normalize_or(Vec3::Y)
    }

    /// Steepest slope anywhere on the field, metres of height per metre.
    pub fn steepest(&self) -> f32 {
        let side = self.side as usize;
        let mut steepest = 0.0f32;
        for z in 0..side - 1 {
            for x in 0..side - 1 {
                let [a, b, c, d] = [0, 1, side, side + 1].map(|o| self.heights[z * side + x + o]);
                let dx = (b - a).abs().max((d - c).abs());
                let dz = (c - a).abs().max((d - b).abs());
                steepest = steepest.max(Vec2::new(dx, dz).length());
            }
        }
        steepest / self.cell
    }

    /// The triangle under `(x, z)`. The cell's diagonal runs from (1, 0) to (0, 1).
    fn patch(&self, x: f32, z: f32) -> Patch {
        let last = (self.side - 1) as f32;
        let raw = Vec2::new(x, z) / self.cell + last * 0.5;
        let at = raw.clamp(Vec2::ZERO, Vec2::splat(last));
        let inside = Vec2::select(raw.cmpeq(at), Vec2::ONE, Vec2::ZERO);
        let low = at.floor().min(Vec2::splat(last - 1.0));
        let side = self.side as usize;
        let first = low.y as usize * side + low.x as usize;
        let [a, b, c, d] = [0, 1, side, side + 1].map(|offset| self.heights[first + offset]);
        let f = at - low;
        if f.x + f.y <= 1.0 {
            Patch { height: a, gradient: Vec2::new(b - a, c - a), offset: f, inside }
        } else {
            Patch { height: d, gradient: Vec2::new(d - c, d - b), offset: f - 1.0, inside }
        }
    }
}

/// A triangle of the height field.
struct Patch {
    /// Height of the corner that `offset` is measured from.
    height: f32,
    /// Rise along x and z over one cell.
    gradient: Vec2,
    /// Place relative to the corner, in cells.
    offset: Vec2,
    /// For each axis 1 inside the field and 0 beyond its edge, where the ground is level.
    inside: Vec2,
}

/// Smooth noise in `[0, 1)` with a lattice of 1, hashed by integers.
fn value_noise(at: Vec2, seed: u32) -> f32 {
    let cell = at.floor();
    let f = at - cell;
    let s = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let corner = |dx: i32, dz: i32| {
        unit(hash(hash(seed, (cell.x as i32 + dx) as u32), (cell.y as i32 + dz) as u32))
    };
    let near = corner(0, 0) + (corner(1, 0) - corner(0, 0)) * s.x;
    let far = corner(0, 1) + (corner(1, 1) - corner(0, 1)) * s.x;
    near + (far - near) * s.y
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slope_has_its_height_and_normal_everywhere() {
        let ground = Terrain::slope(Vec2::new(0.5, -0.25), 100.0);
        for (x, z) in [(0.0, 0.0), (10.0, -7.0), (-49.9, 49.9)] {
            assert!((ground.height(x, z) - (0.5 * x - 0.25 * z)).abs() < 1e-4);
            let normal = Vec3::new(-0.5, 1.0, 0.25).normalize_or_zero();
            assert!((ground.normal(x, z) - normal).length() < 1e-5);
        }
        assert!((ground.steepest() - 0.3125f32.sqrt()).abs() < 1e-5);
    }

    #[test]
    fn beyond_the_edge_the_ground_goes_on_level() {
        let ground = Terrain::slope(Vec2::new(0.5, 0.0), 100.0);
        assert_eq!(ground.height(50.0, 0.0), ground.height(5000.0, 0.0));
        assert_eq!(ground.normal(5000.0, 0.0), Vec3::Y);
    }

    #[test]
    fn normals_match_finite_differences_on_rolling_ground() {
        let ground = Terrain::rolling(200.0, 6.0, 3);
        let e = 1e-2;
        for i in 0..500 {
            let (x, z) = (unit(hash(1, i)) * 180.0 - 90.0, unit(hash(2, i)) * 180.0 - 90.0);
            let cell = |v: f32| ((v / ground.cell()) + 1000.0).fract();
            let (fx, fz) = (cell(x - ground.extent() * 0.5), cell(z - ground.extent() * 0.5));
            let on_diagonal = (fx + fz - 1.0).abs() < 0.02;
            if [fx, fz].iter().any(|f| !(0.02..0.98).contains(f)) || on_diagonal {
                continue; // the slope is not continuous across triangles
            }
            let dx = (ground.height(x + e, z) - ground.height(x - e, z)) / (2.0 * e);
            let dz = (ground.height(x, z + e) - ground.height(x, z - e)) / (2.0 * e);
            let normal = Vec3::new(-dx, 1.0, -dz).normalize_or_zero();
            assert!((ground.normal(x, z) - normal).length() < 5e-3);
        }
        let (low, high) = ground.range();
        assert!(low < -0.5 && high > 0.5 && high - low < 12.0, "{low}..{high}");
    }
}
