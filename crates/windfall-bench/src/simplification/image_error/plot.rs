//! Plots of the errors over the level of detail.

use super::{Errors, LAMBDAS, Row};
use crate::plot::{failed, register_font};
use plotters::prelude::*;

/// The candidates in the plots, and their colors.
const LINES: [(&str, RGBColor); 8] = [
    ("random", RGBColor(190, 90, 20)),
    ("importance", RGBColor(150, 40, 120)),
    ("blue-noise", RGBColor(20, 120, 60)),
    ("no area", RGBColor(120, 120, 120)),
    ("no contrast", RGBColor(200, 160, 20)),
    ("meshopt simplify", RGBColor(40, 90, 190)),
    ("meshopt dilated", RGBColor(130, 60, 190)),
    ("meshopt sloppy", RGBColor(70, 170, 210)),
];

type Measure = fn(&Row) -> f64;

/// Panels: caption, measure, and end of the axis; 0 for an axis that fits the values.
const PANELS: [(&str, Measure, f64); 4] = [
    ("coverage, % off", |r| 100.0 * r.coverage, 40.0),
    ("luminance, % off", |r| 100.0 * r.luminance, 20.0),
    ("variance, % off", |r| 100.0 * r.variance, 150.0),
    ("FLIP", |r| r.flip, 0.0),
];

impl Errors {
    /// Names and SVGs of the trees, with each level at its own distance.
    pub fn plots(&self) -> anyhow::Result<Vec<(String, String)>> {
        let mut names: Vec<&str> = self.rows.iter().map(|r| r.tree.as_str()).collect();
        names.dedup();
        names.iter().map(|name| Ok(((*name).to_owned(), self.plot(name)?))).collect()
    }

    fn plot(&self, tree: &str) -> anyhow::Result<String> {
        let rows: Vec<&Row> = self.rows.iter().filter(|r| r.tree == tree && !r.forced).collect();
        register_font()?;
        let mut svg = String::new();
        {
            let root = SVGBackend::with_string(&mut svg, (1000, 760)).into_drawing_area();
            root.fill(&WHITE).map_err(failed)?;
            let areas = root.split_evenly((2, 2));
            for (area, (caption, measure, most)) in areas.iter().zip(PANELS) {
                let (low, high) = if most > 0.0 {
                    (-most, most)
                } else {
                    (0.0, rows.iter().map(|r| measure(r)).fold(0.0, f64::max) * 1.1)
                };
                let mut chart = ChartBuilder::on(area)
                    .caption(caption, ("sans-serif", 16))
                    .margin(12)
                    .x_label_area_size(34)
                    .y_label_area_size(50)
                    .build_cartesian_2d(
                        (f64::from(LAMBDAS[4]) * 0.9..f64::from(LAMBDAS[0]) * 1.1).log_scale(),
                        low..high,
                    )
                    .map_err(failed)?;
                chart
                    .configure_mesh()
                    .light_line_style(WHITE)
                    .x_labels(4)
                    .x_label_formatter(&|x| format!("{x:.2}"))
                    .x_desc("share of leaves drawn")
                    .draw()
                    .map_err(failed)?;
                for (name, color) in LINES {
                    let points: Vec<(f64, f64)> = rows
                        .iter()
                        .filter(|r| r.candidate == name)
                        .map(|r| (f64::from(r.lambda), measure(r).clamp(low, high)))
                        .collect();
                    chart
                        .draw_series(LineSeries::new(points, color.stroke_width(2)))
                        .map_err(failed)?
                        .label(name)
                        .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color));
                }
                if most == 0.0 {
                    chart
                        .configure_series_labels()
                        .background_style(WHITE.mix(0.8))
                        .position(SeriesLabelPosition::LowerRight)
                        .draw()
                        .map_err(failed)?;
                }
            }
            root.present().map_err(failed)?;
        }
        Ok(svg)
    }
}
