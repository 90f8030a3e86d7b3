//! `windfall verify`: what the models give beside what was observed.

use crate::path::verify::{table, tables};
use anyhow::{Result, ensure};
use std::io::Write;
use windfall_bench::statistics::{LinearFit, Quartiles};
use windfall_core::forest::{Instance, Terrain};
use windfall_core::glam::Vec3;
use windfall_core::light::leaf::diffuse;
use windfall_core::path::{Fall, FallSettings, LeafFall, PathSet, Variation};
use windfall_core::rng::{hash, unit};
use windfall_core::tree::Tree;
use windfall_core::wind::Wind;
use windfall_flight::verify::Check;
use windfall_flight::{measure, presets};
use windfall_tree::Species;

/// Arguments of `windfall verify`.
#[derive(clap::Args)]
pub struct Args {
    /// Simulated falls of each disc and species
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(10..=100_000))]
    falls: u32,
}

/// Seconds over which leaves detach: many gusts.
const SPREAD: f32 = 1000.0;
/// A light wind, m/s.
const LIGHT_WIND: f32 = 2.0;
/// Winds of a whole autumn: of every heading, up to [`LIGHT_WIND`].
const WINDS: u32 = 32;

/// Prints all tables. Any figure outside of its range is an error.
pub fn run(args: &Args) -> Result<()> {
    let mut out = std::io::stdout().lock();
    let (card, discs) = tables(&mut out, args.falls)?;
    let mut off = card + discs;
    for (title, rows) in [
        (
            "Leaves that settle in still air: root of 7.4 times the mass per area (mean drop-in speed of dry leaves); \
             each within 25%",
            settling(args.falls),
        ),
        (
            "Inclination of the leaves of deciduous crowns, mean 41 degrees; each within 25%",
            inclination(),
        ),
        (
            "Luminance that leaves pass over what they reflect, and the most of both together (PROSPECT-D); \
             each within 25%",
            colors(),
        ),
        (
            "Litter of one tree: maple in winds of every heading up to 2 m/s, birch in a wind of 2 m/s",
            litter(),
        ),
    ] {
        writeln!(out, "\n{title}\n")?;
        table(&mut out, &rows)?;
        off += rows.iter().filter(|row| !row.holds()).count();
    }
    ensure!(off == 0, "{off} figures are outside of their range");
    Ok(())
}

fn near(what: String, published: f64, tolerance: f64, value: f64) -> Check {
    let margin = published * tolerance;
    let range = (published - margin, published + margin);
    Check { what, published: format!("{published:.2} ±{:.0}%", tolerance * 100.0), range, value }
}

fn settling(falls: u32) -> Vec<Check> {
    let leaves = presets::ALL.iter().filter(|preset| preset.name != "samara");
    let of = |preset: &presets::Preset| {
        let row = measure::row(&preset.body, falls, 1);
        let published = (7.4 * preset.body.areal_density).sqrt();
        near(format!("{}: descent, m/s", preset.name), published, 0.25, row.descent)
    };
    leaves.map(of).collect()
}

/// Mean angle between leaves and the horizontal, degrees, by area.
fn mean_inclination(tree: &Tree) -> f64 {
    let foliage = &tree.foliage;
    let (mut sum, mut area) = (0.0, 0.0);
    for leaf in &foliage.leaves {
        let share = f64::from(foliage.shapes[leaf.shape as usize].area() * leaf.scale * leaf.scale);
        let up = (leaf.orientation * Vec3::Y).y.abs().min(1.0);
        sum += share * f64::from(up.acos().to_degrees());
        area += share;
    }
    sum / f64::max(area, 1e-12)
}

fn inclination() -> Vec<Check> {
    let species = [Species::Oak, Species::Maple, Species::Birch, Species::Beech];
    let of = |species: Species| {
        let value = mean_inclination(&species.grow_with(1, 2000));
        near(format!("{species}: mean inclination, degrees"), 41.0, 0.25, value)
    };
    species.into_iter().map(of).collect()
}

fn colors() -> Vec<Check> {
    let luminance = |color: Vec3| f64::from(color.dot(Vec3::new(0.2126, 0.7152, 0.0722)));
    let stop = |species: Species, last: bool| {
        let stops = species.params().palette.stops;
        stops[if last { stops.len() - 1 } else { 0 }]
    };
    let maple = Species::Maple.params().palette.stops;
    let birch = Species::Birch.params().palette.stops;
    let leaves = [
        ("green", stop(Species::Oak, false), 0.76),
        ("yellow", birch[birch.len() / 2], 0.78),
        ("red", maple[maple.len() - 2], 0.55),
        ("brown", stop(Species::Oak, true), 0.41),
    ];
    let mut rows: Vec<Check> = leaves
        .iter()
        .map(|&(name, color, published)| {
            let (reflected, passed) = diffuse(color);
            let value = luminance(passed) / luminance(reflected);
            near(format!("{name}: passed over reflected"), published, 0.25, value)
        })
        .collect();
    let both = |color: Vec3| {
        let (reflected, passed) = diffuse(color);
        f64::from((reflected + passed).max_element())
    };
    let all = Species::ALL.iter().flat_map(|species| species.params().palette.stops);
    rows.push(Check {
        what: "all palettes: most of both together".into(),
        published: "at most 0.95".into(),
        range: (0.0, 0.95),
        value: all.map(both).fold(0.0, f64::max),
    });
    rows
}

/// Distances from the trunk at which leaves of a tree land, metres, with their heights on the twig as shares of the
/// tree's.
fn landings(tree: &Tree, winds: &[Wind]) -> Vec<(f64, f32)> {
    let paths = PathSet::builtin();
    let ground = Terrain::flat();
    let settings = FallSettings::default();
    let fall = |wind| Fall::new(&paths, &ground, wind, Variation::default(), settings);
    let falls: Vec<Fall<'_>> = winds.iter().map(|&wind| fall(wind)).collect();
    let group = paths.group(&tree.name).unwrap_or(0);
    let instance = Instance::alone(0, 1);
    let height = tree.bounds().1.y;
    let leaves = (0..).zip(&tree.foliage.leaves);
    leaves
        .map(|(i, leaf)| {
            let detach = f64::from(SPREAD * unit(hash(0x11f7, i)));
            let fall = &falls[i as usize % falls.len()];
            let landing = fall.landing(&LeafFall::of(&instance, leaf, group, detach));
            (f64::from(landing.position.with_y(0.0).length()), leaf.center.y / height)
        })
        .collect()
}

fn litter() -> Vec<Check> {
    let within = |what: &str, published: &str, range: (f64, f64), value: f64| Check {
        what: what.into(),
        published: published.into(),
        range,
        value,
    };
    let maple = Species::Maple.grow_with(1, 20_000);
    let wind = |speed: f32, heading: f32| Wind::new(speed, heading, 0.6, 1);
    let all: Vec<Wind> = (0..WINDS)
        .map(|i| {
            let heading = std::f32::consts::TAU * i as f32 / WINDS as f32;
            wind(LIGHT_WIND * unit(hash(0x317d, i)), heading)
        })
        .collect();
    let far = landings(&maple, &all);
    // Leaves on each square metre of rings two metres wide that have ten or more.
    let rings = (0..30u32).filter_map(|ring| {
        let (from, to) = (f64::from(2 * ring), f64::from(2 * ring + 2));
        let count = far.iter().filter(|(d, _)| (from..to).contains(d)).count();
        let area = std::f64::consts::PI * (to * to - from * from);
        (count >= 10).then(|| (0.5 * (from + to), (count as f64 / area).log10()))
    });
    let height = f64::from(maple.bounds().1.y);
    let share = far.iter().filter(|(d, _)| *d <= height).count() as f64 / far.len() as f64;
    // No willow is built in; a birch has leaves as light and as narrow.
    let birch = landings(&Species::Birch.grow_with(1, 5000), &[wind(LIGHT_WIND, 0.3)]);
    let of = |from: f32, to: f32| {
        let some = birch.iter().filter(|l| (from..to).contains(&l.1)).map(|l| l.0);
        Quartiles::of(&some.collect::<Vec<_>>()).median
    };
    vec![
        within(
            "maple: log10 of leaves per area over distance, r2",
            "above 0.9",
            (0.9, 1.0),
            LinearFit::of(&rings.collect::<Vec<_>>()).r2,
        ),
        within("maple: share within its height", "most", (0.5, 1.0), share),
        within(
            "birch for willow: upper third lands at, m",
            "15 to 25",
            (15.0, 25.0),
            of(2.0 / 3.0, 1.1),
        ),
        within("birch for willow: lower third lands at, m", "5 to 15", (5.0, 15.0), of(0.0, 0.45)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_off_is_told_and_what_holds_is_not() {
        let check = near("x".into(), 2.0, 0.25, 2.6);
        assert!(!check.holds() && (check.off() - 0.1).abs() < 1e-9);
        assert!(near("x".into(), 2.0, 0.25, 1.6).holds());
    }

    #[test]
    fn inclinations_are_means_over_the_area() {
        let mut tree = Species::Birch.grow_with(1, 200);
        for leaf in &mut tree.foliage.leaves {
            leaf.orientation = windfall_core::glam::Quat::from_rotation_z(0.5);
        }
        assert!((mean_inclination(&tree) - 0.5f64.to_degrees()).abs() < 0.01);
    }
}
