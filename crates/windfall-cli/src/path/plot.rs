//! A path as a picture: from the side, from above, orientation over time, joints.

use anyhow::{Result, anyhow};
use plotters::coord::types::RangedCoordf32;
use plotters::prelude::*;
use windfall_core::glam::{Vec2, Vec3};
use windfall_core::path::FallPath;

const INK: RGBColor = RGBColor(40, 60, 90);
const LEAF: RGBColor = RGBColor(200, 110, 30);
const START: RGBColor = RGBColor(40, 150, 60);
const FROM: RGBColor = RGBColor(200, 30, 60);
const TO: RGBColor = RGBColor(40, 90, 210);

/// SVG of a path, 1200 by 900.
pub fn draw(path: &FallPath) -> Result<String> {
    windfall_bench::register_plot_font()?;
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (1200, 900)).into_drawing_area();
        root.fill(&WHITE).map_err(failed)?;
        let title = format!(
            "{}: {} samples at {} Hz, {:.2} m in {:.2} s",
            path.name(),
            path.positions().len(),
            path.rate(),
            path.drop(),
            path.duration()
        );
        let root = root.titled(&title, ("sans-serif", 22)).map_err(failed)?;
        let (left, right) = root.split_horizontally(480);
        let (above, over_time) = right.split_vertically(430);
        view(path, &left, "from the side: X over height, metres", |p| Vec2::new(p.x, p.y))?;
        // Seen from above, Z points down the page.
        view(path, &above, "from above: X over -Z, metres", |p| Vec2::new(p.x, -p.z))?;
        orientation(path, &over_time)?;
        root.present().map_err(failed)?;
    }
    Ok(svg)
}

#[expect(clippy::needless_pass_by_value, reason = "the signature of map_err")]
pub(super) fn failed<E: std::error::Error + Send + Sync>(
    error: DrawingAreaErrorKind<E>,
) -> anyhow::Error {
    anyhow!("cannot draw: {error}")
}

pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;
type Axes<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf32, RangedCoordf32>>;

/// Axes of one scale about some points, and half of what they span.
pub(super) fn even_axes<'a, 'b>(
    area: &'a Area<'b>,
    caption: &str,
    points: impl Iterator<Item = Vec2> + Clone,
) -> Result<(Axes<'a, 'b>, Vec2)> {
    let low = points.clone().reduce(Vec2::min).unwrap_or_default();
    let high = points.reduce(Vec2::max).unwrap_or_default();
    let (w, h) = area.dim_in_pixel();
    let room = Vec2::new(w as f32 - 80.0, h as f32 - 90.0);
    let scale = ((high - low) * 1.1 / room).max_element().max(1e-6);
    let (middle, half) = ((low + high) * 0.5, room * scale * 0.5);
    let chart = ChartBuilder::on(area)
        .caption(caption, ("sans-serif", 15))
        .margin(10)
        .x_label_area_size(30)
        .y_label_area_size(50)
        .build_cartesian_2d(
            middle.x - half.x..middle.x + half.x,
            middle.y - half.y..middle.y + half.y,
        )
        .map_err(failed)?;
    Ok((chart, half))
}

/// The trajectory in a projection, at the same scale along both axes, with leaves seen as strokes
/// along their width, and the marks of starting points and joints.
fn view(path: &FallPath, area: &Area, caption: &str, flat: impl Fn(Vec3) -> Vec2) -> Result<()> {
    let points: Vec<Vec2> = path.positions().iter().map(|&p| flat(p)).collect();
    let (mut chart, half) = even_axes(area, caption, points.iter().copied())?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .x_labels(6)
        .y_labels(12)
        .draw()
        .map_err(failed)?;
    // Some 60 leaves: chords of their width and of their length, projected.
    let step = (points.len() / 60).max(1);
    let size = half.max_element() * 0.06;
    for i in (0..points.len()).step_by(step) {
        let q = path.orientations()[i];
        for (axis, share) in [(Vec3::X, 0.6), (Vec3::Z, 1.0)] {
            let arm = flat(q * axis) * size * share;
            let ends = [points[i] - arm, points[i] + arm].map(|p| (p.x, p.y));
            chart.draw_series(LineSeries::new(ends, LEAF.mix(0.6))).map_err(failed)?;
        }
    }
    let line = points.iter().map(|p| (p.x, p.y));
    chart.draw_series(LineSeries::new(line, INK.stroke_width(2))).map_err(failed)?;
    let mut marks = |samples: Vec<u32>, color: RGBColor, radius: i32| {
        let dots = samples.into_iter().filter_map(|i| points.get(i as usize));
        chart
            .draw_series(dots.map(|p| Circle::new((p.x, p.y), radius, color.filled())))
            .map(|_| ())
            .map_err(failed)
    };
    let analysis = path.analysis();
    marks(analysis.starts.clone(), START, 4)?;
    marks(analysis.joints.iter().map(|j| j.from).collect(), FROM, 5)?;
    marks(analysis.joints.iter().map(|j| j.to).collect(), TO, 5)?;
    Ok(())
}

/// Tilt of the leaf against the ground, and heading of its tip, over time; a bar for each joint.
fn orientation(path: &FallPath, area: &Area) -> Result<()> {
    let mut chart = ChartBuilder::on(area)
        .caption(
            "tilt (dark) and heading of the tip (orange), degrees over seconds; joints below",
            ("sans-serif", 15),
        )
        .margin(10)
        .x_label_area_size(30)
        .y_label_area_size(50)
        .build_cartesian_2d(0.0..path.duration(), -260.0f32..190.0)
        .map_err(failed)?;
    chart.configure_mesh().light_line_style(WHITE).y_labels(10).draw().map_err(failed)?;
    let time = |i: u32| i as f32 / path.rate();
    let mut tilt = Vec::new();
    let mut heading: Vec<Vec<(f32, f32)>> = vec![Vec::new()];
    for (i, q) in path.orientations().iter().enumerate() {
        let (up, tip) = (*q * Vec3::Y, *q * Vec3::Z);
        tilt.push((time(i as u32), up.y.clamp(-1.0, 1.0).acos().to_degrees()));
        let angle = tip.x.atan2(tip.z).to_degrees();
        let part = heading.len() - 1;
        // No stroke across the page where the heading goes through 180 degrees.
        if heading[part].last().is_some_and(|last| (last.1 - angle).abs() > 180.0) {
            heading.push(Vec::new());
        }
        let part = heading.len() - 1;
        heading[part].push((time(i as u32), angle));
    }
    for part in heading {
        chart.draw_series(LineSeries::new(part, LEAF)).map_err(failed)?;
    }
    chart.draw_series(LineSeries::new(tilt, INK)).map_err(failed)?;
    for (k, j) in path.analysis().joints.iter().enumerate() {
        let y = -195.0 - 7.0 * k as f32;
        let (from, to) = (time(j.from), time(j.to));
        chart.draw_series(LineSeries::new([(to, y), (from, y)], INK.mix(0.5))).map_err(failed)?;
        let ends = [(to, TO), (from, FROM)];
        chart
            .draw_series(ends.map(|(x, color)| Circle::new((x, y), 4, color.filled())))
            .map_err(failed)?;
    }
    let starts = path.analysis().starts.iter();
    chart
        .draw_series(starts.map(|&s| Circle::new((time(s), -187.0), 3, START.filled())))
        .map_err(failed)?;
    Ok(())
}
