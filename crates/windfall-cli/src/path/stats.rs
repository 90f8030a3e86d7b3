//! `windfall path stats`: how varied and how real played falls are.

use super::numbers::{
    kolmogorov_smirnov, largest_correlation, mean_and_deviation, quantile, spectrum,
};
use anyhow::{Context, Result};
use std::io::Write;
use windfall_core::forest::Terrain;
use windfall_core::glam::{DVec3, Quat, Vec3};
use windfall_core::path::{Edition, Fall, FallSettings, LeafFall, PathSet, Variation};
use windfall_core::rng::{Rng, hash};
use windfall_core::wind::Wind;
use windfall_flight::{Flight, LeafBody, presets, simulated_path};

/// Rate of the tilt series, hertz, and their length: 4 s.
const RATE: f64 = 64.0;
const LENGTH: usize = 256;
/// The series begin when the leaf has left its twig behind.
const BEGIN: f64 = 1.5;
/// Series whose spectra are averaged, and pairs whose correlation is measured.
const SERIES: u32 = 400;
/// Longest lag: 1 s.
const LAG: usize = 64;

/// What is measured on a set of falls.
#[derive(Default)]
struct Falls {
    descent: Vec<f64>,
    drift: Vec<f64>,
    landing: Vec<f64>,
    tilts: Vec<Vec<f64>>,
    shared: Option<[f64; 2]>,
}

/// Leaves of one tree: a crown of 6 m width whose leaves hang 3 to 7 m above the ground, sorted by
/// place so that neighbours follow each other.
fn tree(leaves: u32, group: u32, seed: u32) -> Vec<LeafFall> {
    let mut rng = Rng::new(seed);
    let mut all: Vec<LeafFall> = (0..leaves)
        .map(|i| {
            let mut p = Vec3::splat(2.0);
            while p.length_squared() > 1.0 {
                p = Vec3::new(rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), rng.range(-1.0, 1.0));
            }
            let mut u = || rng.range(-1.0, 1.0);
            let q = Quat::from_xyzw(u(), u(), u(), u());
            LeafFall {
                origin: Vec3::new(p.x * 3.0, 5.0 + p.y * 2.0, p.z * 3.0),
                twig_orientation: q * (1.0 / q.length().max(1e-3)),
                tree: Vec3::ZERO,
                seed: hash(seed, i),
                group,
                detach_time: 0.0,
            }
        })
        .collect();
    // Boxes of 30 cm: leaves of one box are neighbours.
    let key = |l: &LeafFall| {
        let c = (l.origin / 0.3).floor();
        (c.x as i32, c.y as i32, c.z as i32)
    };
    all.sort_by_key(key);
    all
}

/// Runs the report.
pub fn run(leaves: u32, species: &str, seed: u32) -> Result<()> {
    let preset = presets::find(species).context("the species was checked")?;
    let builtin = PathSet::builtin();
    let group = builtin.group(species).context("every species has paths")?;
    // VB's setting: a single path of 200 samples, at a rate that can carry a leaf's turning.
    let single = PathSet::new(vec![simulated_path(
        species,
        &preset.body,
        199.0 / preset.rate,
        preset.rate,
        seed,
        16,
    )?])?;
    let mut out = std::io::stdout().lock();
    writeln!(
        out,
        "{leaves} leaves of one {species}, from 3 to 7 m, in calm air, against {leaves} direct \
         simulations from the same heights\n"
    )?;

    let direct = direct(&tree(leaves, 0, seed), &preset.body, seed);
    let hashed = Variation::default();
    let columns = [
        ("one path of 200 samples, hashed", &single, 0, hashed.clone()),
        ("one path of 200 samples, paper", &single, 0, Variation::Paper(Edition::Of2008)),
        ("default set, hashed", &builtin, group, hashed),
        ("default set, paper", &builtin, group, Variation::Paper(Edition::Of2008)),
    ];
    let sets: Vec<(&str, Falls)> = columns
        .into_iter()
        .map(|(name, set, group, variation)| {
            (name, played(&tree(leaves, group, seed), set, &variation))
        })
        .collect();
    report(&mut out, direct, sets)
}

/// Runs `work` over the leaves on all cores, in order.
fn parallel<T: Send>(leaves: &[LeafFall], work: impl Fn(usize, &LeafFall) -> T + Sync) -> Vec<T> {
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let part = leaves.len().div_ceil(threads).max(1);
    let work = &work;
    std::thread::scope(|scope| {
        let handles: Vec<_> = leaves
            .chunks(part)
            .enumerate()
            .map(|(k, chunk)| {
                scope.spawn(move || {
                    let each = chunk.iter().enumerate().map(|(i, l)| work(k * part + i, l));
                    each.collect::<Vec<T>>()
                })
            })
            .collect();
        handles.into_iter().flat_map(|h| h.join().unwrap_or_default()).collect()
    })
}

fn collect(each: Vec<(f64, Vec3, Option<Vec<f64>>)>) -> Falls {
    let mut falls = Falls::default();
    for (descent, landing, tilt) in each {
        falls.descent.push(descent);
        falls.drift.push(f64::from(landing.with_y(0.0).length()));
        falls.landing.push(f64::from(landing.x));
        falls.tilts.extend(tilt);
    }
    falls
}

fn direct(leaves: &[LeafFall], body: &LeafBody, seed: u32) -> Falls {
    let plate = body.plate();
    collect(parallel(leaves, |i, leaf| {
        let height = f64::from(leaf.origin.y);
        let mut state = Flight::released(&mut Rng::new(seed ^ 0xd1ec).stream(i as u32));
        let wants_tilt = i < SERIES as usize;
        let dt = 1.0 / (RATE * 8.0);
        let (mut steps, mut tilt) = (0u32, Vec::new());
        while state.position.y > -height || (wants_tilt && tilt.len() < LENGTH) {
            if wants_tilt && steps.is_multiple_of(8) && f64::from(steps) * dt >= BEGIN {
                tilt.push(state.up().y.clamp(-1.0, 1.0).acos());
            }
            state = plate.step(&state, DVec3::ZERO, dt);
            steps += 1;
        }
        tilt.truncate(LENGTH);
        (height / (f64::from(steps) * dt), state.position.as_vec3(), wants_tilt.then_some(tilt))
    }))
}

fn played(leaves: &[LeafFall], paths: &PathSet, variation: &Variation) -> Falls {
    let ground = Terrain::flat();
    let fall = Fall::new(paths, &ground, Wind::calm(), variation.clone(), FallSettings::default());
    let mut falls = collect(parallel(leaves, |i, leaf| {
        let landing = fall.landing(leaf);
        let tilt = (i < SERIES as usize).then(|| {
            let variant = fall.variant(leaf);
            let up = |k: usize| {
                let t = BEGIN + k as f64 / RATE;
                (fall.airborne(leaf, &variant, t as f32).orientation * Vec3::Y).y
            };
            (0..LENGTH).map(|k| f64::from(up(k).clamp(-1.0, 1.0).acos())).collect()
        });
        let speed = f64::from(leaf.origin.y) / f64::from(landing.time);
        (speed, landing.position - leaf.origin, tilt)
    }));
    falls.shared = Some([0.01, 1.0].map(|degrees| shared(leaves, &fall, degrees)));
    falls
}

/// Share of leaves for which there is another with the same path and start, and a yaw nearer than
/// `degrees`.
fn shared(leaves: &[LeafFall], fall: &Fall, degrees: f32) -> f64 {
    let mut keys: Vec<(u32, u32, f32)> = leaves
        .iter()
        .map(|l| {
            let v = fall.variant(l);
            (v.path, v.start, v.yaw.to_degrees())
        })
        .collect();
    keys.sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
    let near = |a: &(u32, u32, f32), b: &(u32, u32, f32)| {
        a.0 == b.0 && a.1 == b.1 && (a.2 - b.2).abs() < degrees
    };
    let n = keys.len();
    let count = (0..n)
        .filter(|&i| {
            (i > 0 && near(&keys[i - 1], &keys[i])) || (i + 1 < n && near(&keys[i], &keys[i + 1]))
        })
        .count();
    count as f64 / n as f64
}

fn mean_spectrum(tilts: &[Vec<f64>]) -> Vec<f64> {
    let mut sum = vec![0.0; LENGTH / 2 - 1];
    for tilt in tilts {
        for (s, p) in sum.iter_mut().zip(spectrum(tilt)) {
            *s += p / tilts.len() as f64;
        }
    }
    sum
}

/// Largest correlations of neighbours, sorted.
fn correlations(tilts: &[Vec<f64>]) -> Vec<f64> {
    let mut all: Vec<f64> =
        tilts.windows(2).map(|w| largest_correlation(&w[0], &w[1], LAG)).collect();
    all.sort_by(f64::total_cmp);
    all
}

fn report(out: &mut impl Write, mut direct: Falls, sets: Vec<(&str, Falls)>) -> Result<()> {
    let reference = mean_spectrum(&direct.tilts);
    let independent = correlations(&direct.tilts);
    let cycles = |power: &[f64]| {
        let peak = power.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |p| p.0);
        let middle: f64 = power.iter().enumerate().map(|(k, p)| (k + 1) as f64 * p).sum();
        [(peak + 1) as f64, middle].map(|c| c * RATE / LENGTH as f64)
    };
    let line = |name: &str, falls: &Falls| {
        let figures = [&falls.descent, &falls.drift, &falls.landing]
            .map(|v| mean_and_deviation(v))
            .map(|(m, s)| format!("{m:.2} ± {s:.2}"));
        format!("{name:<34} {:>14} {:>14} {:>14}", figures[0], figures[1], figures[2])
    };
    writeln!(
        out,
        "{:<34} {:>14} {:>14} {:>14}",
        "mean ± deviation", "descent m/s", "drift m", "landing x m"
    )?;
    writeln!(out, "{}", line("direct simulations", &direct))?;
    for (name, falls) in &sets {
        writeln!(out, "{}", line(name, falls))?;
    }

    writeln!(
        out,
        "\nTwo-sample Kolmogorov-Smirnov distance to the direct simulations, D (p):\n{:<34} {:>14} {:>14} {:>14}",
        "", "descent", "drift", "landing x"
    )?;
    let mut sets = sets;
    for (name, falls) in &mut sets {
        let pairs = [
            (&mut direct.descent, &mut falls.descent),
            (&mut direct.drift, &mut falls.drift),
            (&mut direct.landing, &mut falls.landing),
        ];
        let tests = pairs.map(|(a, b)| {
            let (d, p) = kolmogorov_smirnov(a, b);
            format!("{d:.3} ({p:.2})")
        });
        writeln!(out, "{name:<34} {:>14} {:>14} {:>14}", tests[0], tests[1], tests[2])?;
    }

    writeln!(
        out,
        "\nSpectrum of the tilt, mean of {SERIES} leaves over 4 s:\n{:<34} {:>14} {:>14} {:>14}",
        "", "peak Hz", "centroid Hz", "overlap"
    )?;
    let [peak, centroid] = cycles(&reference);
    writeln!(out, "{:<34} {peak:>14.2} {centroid:>14.2} {:>14}", "direct simulations", "")?;
    for (name, falls) in &sets {
        let power = mean_spectrum(&falls.tilts);
        let [peak, centroid] = cycles(&power);
        let overlap: f64 = power.iter().zip(&reference).map(|(a, b)| a.min(*b)).sum();
        writeln!(out, "{name:<34} {peak:>14.2} {centroid:>14.2} {overlap:>14.2}")?;
    }

    writeln!(
        out,
        "\nLargest correlation of tilt over lags to 1 s, between neighbours ({} pairs):\n{:<34} {:>14} {:>14} {:>14}",
        SERIES - 1,
        "",
        "median",
        "95%",
        "above 0.98"
    )?;
    let mut correlation = |name: &str, sorted: &[f64]| {
        let above = sorted.iter().filter(|c| **c > 0.98).count() as f64 / sorted.len() as f64;
        let (m, h) = (quantile(sorted, 0.5), quantile(sorted, 0.95));
        writeln!(out, "{name:<34} {m:>14.3} {h:>14.3} {:>13.1}%", above * 100.0)
    };
    correlation("independent simulations", &independent)?;
    for (name, falls) in &sets {
        correlation(name, &correlations(&falls.tilts))?;
    }

    writeln!(
        out,
        "\nLeaves for which another has the same path and start, and a yaw within:\n{:<34} {:>14} {:>14}",
        "", "0.01 deg", "1 deg"
    )?;
    for (name, falls) in &sets {
        if let Some([close, near]) = falls.shared {
            writeln!(out, "{name:<34} {:>13.1}% {:>13.1}%", close * 100.0, near * 100.0)?;
        }
    }
    Ok(())
}
