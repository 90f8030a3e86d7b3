//! Line plots as SVG.

use anyhow::{Result, anyhow};
use plotters::prelude::*;

const SIZE: (u32, u32) = (1200, 600);
/// Width of the chart; the legend takes the rest.
const CHART_WIDTH: u32 = 860;

/// The error of a plot that could not be drawn, for `map_err`.
#[expect(clippy::needless_pass_by_value, reason = "the signature of map_err")]
pub fn failed<E: std::error::Error + Send + Sync>(error: DrawingAreaErrorKind<E>) -> anyhow::Error {
    anyhow!("cannot draw: {error}")
}

/// A named line.
pub struct Line {
    pub name: String,
    pub points: Vec<(f64, f64)>,
}

/// An SVG of lines over common axes, with a legend. With `log` both axes are logarithmic.
pub fn lines(title: &str, x: &str, y: &str, lines: &[Line], log: bool) -> Result<String> {
    let scale = |v: f64| if log { v.max(1e-9).log10() } else { v };
    let all = || lines.iter().flat_map(|l| &l.points).map(|&(x, y)| (scale(x), scale(y)));
    let bound = |get: fn((f64, f64)) -> f64, pick: fn(f64, f64) -> f64, none: f64| {
        all().map(get).reduce(pick).unwrap_or(none)
    };
    let (left, right) = (bound(|p| p.0, f64::min, 0.0), bound(|p| p.0, f64::max, 1.0));
    let (low, high) = (bound(|p| p.1, f64::min, 0.0), bound(|p| p.1, f64::max, 1.0));
    let low = if log { low } else { low.min(0.0) };
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        root.fill(&WHITE).map_err(failed)?;
        let (area, legend) = root.split_horizontally(CHART_WIDTH);
        let mut chart = ChartBuilder::on(&area)
            .caption(title, ("sans-serif", 18))
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(60)
            .build_cartesian_2d(left..right.max(left + 1e-9), low..(high * 1.05).max(low + 1e-9))
            .map_err(failed)?;
        let label =
            |v: &f64| if log { format!("{:.3}", 10f64.powf(*v)) } else { format!("{v:.1}") };
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .x_desc(x)
            .y_desc(y)
            .x_label_formatter(&label)
            .y_label_formatter(&label)
            .draw()
            .map_err(failed)?;
        for (i, line) in lines.iter().enumerate() {
            let color = Palette99::pick(i).to_rgba();
            let points = line.points.iter().map(|&(x, y)| (scale(x), scale(y)));
            chart.draw_series(LineSeries::new(points, color.stroke_width(2))).map_err(failed)?;
            let y = 48 + 20 * i as i32;
            let key = PathElement::new([(8, y), (30, y)], color.stroke_width(2));
            legend.draw(&key).map_err(failed)?;
            let name = Text::new(line.name.as_str(), (38, y - 6), ("sans-serif", 13));
            legend.draw(&name).map_err(failed)?;
        }
        root.present().map_err(failed)?;
    }
    Ok(svg)
}
