//! Many leaves on one path, each falling its own way (VB 2008, Figure 3).

use super::plot::{Area, even_axes, failed};
use anyhow::{Result, bail};
use plotters::prelude::*;
use windfall_core::forest::Terrain;
use windfall_core::glam::{Quat, Vec2, Vec3};
use windfall_core::path::{Edition, Fall, FallPath, FallSettings, LeafFall, PathSet, Variation};
use windfall_core::rng::{hash, unit};
use windfall_core::wind::Wind;

/// Seconds between the points of a line.
const STEP: f64 = 1.0 / 60.0;

/// SVG of `count` leaves that fall by `path` from `drop` metres, from the side and from above, 1200 by 900. Each begins
/// at the origin of the plot; their places on the twigs, which the papers' formulas need, are within a metre of each
/// other.
pub fn draw(path: &FallPath, count: u32, drop: f32, paper: Option<u16>) -> Result<String> {
    if !(0.1..=1000.0).contains(&drop) {
        bail!("--drop {drop}: is not 0.1 to 1000 metres");
    }
    let variation = match paper {
        None => Variation::default(),
        Some(2007) => Variation::Paper(Edition::Of2007),
        Some(_) => Variation::Paper(Edition::Of2008),
    };
    let set = PathSet::new(vec![path.clone()])?;
    let settings = FallSettings::default();
    let (wind, ground) = (Wind::new(0.0, 0.0, 0.0, 1), Terrain::flat());
    let fall = Fall::new(&set, &ground, wind, variation, settings);
    let lines: Vec<Vec<Vec3>> = (0..count)
        .map(|i| {
            let place = |axis| unit(hash(0x3f19, 3 * i + axis)) * 2.0 - 1.0;
            let leaf = LeafFall {
                origin: Vec3::new(place(0), drop, place(2)),
                twig_orientation: Quat::IDENTITY,
                tree: Vec3::ZERO,
                seed: hash(7, i),
                group: 0,
                detach_time: 0.0,
            };
            let landing = fall.landing(&leaf);
            let steps = (f64::from(landing.time.min(600.0)) / STEP) as usize;
            (0..=steps)
                .map(|k| fall.pose(&leaf, &landing, k as f64 * STEP).position - leaf.origin)
                .collect()
        })
        .collect();
    windfall_bench::register_plot_font()?;
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (1200, 900)).into_drawing_area();
        root.fill(&WHITE).map_err(failed)?;
        let how = paper.map_or("hashed".to_owned(), |year| format!("the paper's of {year}"));
        let title = format!("{}: {count} leaves from {drop} m, variation {how}", path.name());
        let root = root.titled(&title, ("sans-serif", 22)).map_err(failed)?;
        let (left, right) = root.split_horizontally(600);
        view(&lines, &left, "from the side: X over height, metres", |p| Vec2::new(p.x, p.y))?;
        view(&lines, &right, "from above: X over -Z, metres", |p| Vec2::new(p.x, -p.z))?;
        root.present().map_err(failed)?;
    }
    Ok(svg)
}

fn view(
    lines: &[Vec<Vec3>],
    area: &Area<'_>,
    caption: &str,
    flat: impl Fn(Vec3) -> Vec2 + Clone,
) -> Result<()> {
    let all = lines.iter().flatten().map(|&p| flat(p));
    let (mut chart, _) = even_axes(area, caption, all)?;
    chart.configure_mesh().light_line_style(WHITE).draw().map_err(failed)?;
    for (i, line) in lines.iter().enumerate() {
        let color = Palette99::pick(i);
        let points = line.iter().map(|&p| flat(p)).map(|p| (p.x, p.y));
        chart.draw_series(LineSeries::new(points, color.stroke_width(1))).map_err(failed)?;
    }
    Ok(())
}
