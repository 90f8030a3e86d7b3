//! Statistics of samples and series.

/// Two-sample Kolmogorov-Smirnov test: the largest distance between the two distributions, and the
/// probability of one as large if they were the same (asymptotic; Press et al., Numerical Recipes).
pub fn kolmogorov_smirnov(a: &mut [f64], b: &mut [f64]) -> (f64, f64) {
    a.sort_by(f64::total_cmp);
    b.sort_by(f64::total_cmp);
    let (mut i, mut j, mut largest) = (0, 0, 0.0f64);
    let (n, m) = (a.len() as f64, b.len() as f64);
    while i < a.len() && j < b.len() {
        let x = a[i].min(b[j]);
        while i < a.len() && a[i] <= x {
            i += 1;
        }
        while j < b.len() && b[j] <= x {
            j += 1;
        }
        largest = largest.max((i as f64 / n - j as f64 / m).abs());
    }
    let root = (n * m / (n + m)).sqrt();
    let lambda = (root + 0.12 + 0.11 / root) * largest;
    let mut p = 0.0;
    for k in 1..=100 {
        let term = (-2.0 * lambda * lambda * f64::from(k * k)).exp();
        p += if k % 2 == 1 { 2.0 * term } else { -2.0 * term };
    }
    (largest, if lambda < 0.2 { 1.0 } else { p.clamp(0.0, 1.0) })
}

/// Mean and standard deviation.
pub fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt())
}

/// Value below which the fraction `q` of the sorted values lies.
pub fn quantile(sorted: &[f64], q: f64) -> f64 {
    let i = (q * (sorted.len().saturating_sub(1)) as f64).round() as usize;
    sorted.get(i).copied().unwrap_or(f64::NAN)
}

/// Power of a series at the frequencies 1, 2, … cycles in its length, with a Hann window, mean
/// removed; sums to 1.
pub fn spectrum(series: &[f64]) -> Vec<f64> {
    let n = series.len();
    let mean = series.iter().sum::<f64>() / n as f64;
    let turn = std::f64::consts::TAU / n as f64;
    let windowed: Vec<f64> = series
        .iter()
        .enumerate()
        .map(|(i, v)| (v - mean) * (0.5 - 0.5 * (turn * i as f64).cos()))
        .collect();
    let mut power: Vec<f64> = (1..n / 2)
        .map(|k| {
            let (mut re, mut im) = (0.0, 0.0);
            for (i, v) in windowed.iter().enumerate() {
                let (s, c) = (turn * (i * k % n) as f64).sin_cos();
                re += v * c;
                im += v * s;
            }
            re * re + im * im
        })
        .collect();
    let sum = power.iter().sum::<f64>().max(1e-30);
    for p in &mut power {
        *p /= sum;
    }
    power
}

/// Largest correlation of two series of equal length over lags up to `most` samples either way.
pub fn largest_correlation(a: &[f64], b: &[f64], most: usize) -> f64 {
    let at = |a: &[f64], b: &[f64]| {
        let ((ma, sa), (mb, sb)) = (mean_and_deviation(a), mean_and_deviation(b));
        let product: f64 = a.iter().zip(b).map(|(x, y)| (x - ma) * (y - mb)).sum();
        product / (a.len() as f64 * (sa * sb).max(1e-12))
    };
    (0..=most)
        .flat_map(|lag| {
            let n = a.len() - lag;
            [at(&a[lag..], &b[..n]), at(&a[..n], &b[lag..])]
        })
        .fold(f64::NEG_INFINITY, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_distributions_pass_and_shifted_ones_do_not() {
        let uniform = |n: usize, shift: f64| -> Vec<f64> {
            (0..n).map(|i| (i as f64 * 0.618_033_988_75).fract() + shift).collect()
        };
        let (d, p) = kolmogorov_smirnov(&mut uniform(1000, 0.0), &mut uniform(900, 0.0));
        assert!(d < 0.01 && p > 0.99, "{d} {p}");
        let (d, p) = kolmogorov_smirnov(&mut uniform(1000, 0.0), &mut uniform(900, 0.2));
        assert!((d - 0.2).abs() < 0.01 && p < 1e-6, "{d} {p}");
    }

    #[test]
    fn a_sine_has_one_line_and_finds_itself_at_its_lag() {
        let wave = |shift: f64| -> Vec<f64> {
            (0..128).map(|i| (0.0491 * 10.0 * f64::from(i) + shift).sin()).collect()
        };
        let power = spectrum(&wave(0.0));
        let peak = power.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).unwrap().0 + 1;
        assert_eq!(peak, 10);
        assert!(largest_correlation(&wave(0.0), &wave(2.0), 16) > 0.98);
    }
}
