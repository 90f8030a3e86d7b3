//! `windfall bench`: measurements in one process, interleaved, on the adapter at hand.

mod bare;
mod crawl;
mod falling;
mod picture;
mod plots;
mod simplification;
mod soak;
mod stand;

use serde::Serialize;

/// Arguments of `windfall bench`.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    /// Falling leaves: strategies over a walkthrough, a million leaves, cost against count
    Falling(falling::Args),
    /// Presets of quality and single effects, over the named scenes
    Picture(picture::Args),
    /// Simplified forests: time over h, culling
    Simplification(simplification::Args),
}

/// Runs `windfall bench`.
pub fn run(args: &Args) -> anyhow::Result<()> {
    match &args.what {
        What::Falling(args) => falling::run(args),
        What::Picture(args) => picture::run(args),
        What::Simplification(args) => simplification::run(args),
    }
}

/// Median and quartiles.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Spread {
    low: f64,
    median: f64,
    high: f64,
}

impl Spread {
    /// Of `values`, by linear interpolation; NaN for none.
    fn of(values: &[f64]) -> Self {
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

impl std::fmt::Display for Spread {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let text = format!("{:.2} ({:.2}..{:.2})", self.median, self.low, self.high);
        f.pad(&text)
    }
}

/// The straight line nearest to points by least squares: value at 0, slope, and R².
fn line(points: &[(f64, f64)]) -> (f64, f64, f64) {
    let n = points.len() as f64;
    let mean = |get: fn(&(f64, f64)) -> f64| points.iter().map(get).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let sum = |get: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(get).sum::<f64>();
    let xx = sum(&|p| (p.0 - x) * (p.0 - x));
    let xy = sum(&|p| (p.0 - x) * (p.1 - y));
    let yy = sum(&|p| (p.1 - y) * (p.1 - y));
    let slope = xy / xx;
    (y - slope * x, slope, xy * xy / (xx * yy))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_quartiles_and_lines_of_known_points() {
        let s = Spread::of(&[5.0, 1.0, 3.0, 2.0, 4.0]);
        assert_eq!([s.low, s.median, s.high], [2.0, 3.0, 4.0]);
        assert!(Spread::of(&[]).median.is_nan());
        let (start, slope, r2) = line(&[(0.0, 1.0), (1.0, 3.0), (3.0, 7.0)]);
        assert!((start - 1.0).abs() < 1e-12 && (slope - 2.0).abs() < 1e-12 && r2 > 0.999_999);
    }
}
