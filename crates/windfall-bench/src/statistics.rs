//! Medians, quartiles and straight lines through measured points.

use serde::{Deserialize, Serialize};

/// Median and quartiles.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Quartiles {
    /// A quarter of the values is below it.
    pub low: f64,
    /// Half of them.
    pub median: f64,
    /// Three quarters.
    pub high: f64,
}

impl Quartiles {
    /// Quartiles of `values` by linear interpolation; NaN if there are none.
    pub fn of(values: &[f64]) -> Self {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let x = share * (sorted.len().max(1) - 1) as f64;
            let i = x as usize;
            match (sorted.get(i), sorted.get(i + 1)) {
                (Some(a), Some(b)) => a + (b - a) * (x - i as f64),
                (Some(a), None) => *a,
                _ => f64::NAN,
            }
        };
        Self { low: at(0.25), median: at(0.5), high: at(0.75) }
    }
}

impl std::fmt::Display for Quartiles {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let text = format!("{:.2} ({:.2}..{:.2})", self.median, self.low, self.high);
        f.pad(&text)
    }
}

/// The straight line through points with the least sum of squared errors.
pub struct LinearFit {
    /// Rise for each step of one.
    pub slope: f64,
    /// Coefficient of determination, 1 for points on a line.
    pub r2: f64,
}

impl LinearFit {
    /// Through two or more points, not all above each other.
    pub fn of(points: &[(f64, f64)]) -> Self {
        let n = points.len() as f64;
        let mean = |get: fn(&(f64, f64)) -> f64| points.iter().map(get).sum::<f64>() / n;
        let (x, y) = (mean(|p| p.0), mean(|p| p.1));
        let sum = |get: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(get).sum::<f64>();
        let xx = sum(&|p| (p.0 - x) * (p.0 - x));
        let xy = sum(&|p| (p.0 - x) * (p.1 - y));
        let yy = sum(&|p| (p.1 - y) * (p.1 - y));
        let slope = xy / xx;
        Self { slope, r2: xy * xy / (xx * yy) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_quartiles_and_lines_of_known_points() {
        let q = Quartiles::of(&[5.0, 1.0, 3.0, 2.0, 4.0]);
        assert_eq!([q.low, q.median, q.high], [2.0, 3.0, 4.0]);
        assert!(Quartiles::of(&[]).median.is_nan());
        // y = 1 + 2x
        let fit = LinearFit::of(&[(0.0, 1.0), (1.0, 3.0), (3.0, 7.0)]);
        assert!((fit.slope - 2.0).abs() < 1e-12 && fit.r2 > 0.999_999);
        let noise = LinearFit::of(&[(0.0, 1.0), (1.0, -1.0), (2.0, 1.0), (3.0, -1.0)]);
        assert!(noise.r2 < 0.3);
    }
}
