//! Line plots, as SVG and as PNG.

use anyhow::{Result, anyhow};
use plotters::coord::Shift;
use plotters::prelude::*;
use std::path::Path;
use std::sync::OnceLock;
use windfall_host::image::RgbaImage;

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

/// Tells `plotters` which font to measure and draw letters with: before any plot, as SVG too.
///
/// # Errors
///
/// The font that is built in cannot be read.
pub fn register_font() -> Result<()> {
    static DONE: OnceLock<bool> = OnceLock::new();
    let done = DONE.get_or_init(|| {
        let font = epaint_default_fonts::UBUNTU_LIGHT;
        plotters::style::register_font("sans-serif", FontStyle::Normal, font).is_ok()
    });
    anyhow::ensure!(*done, "the font of plots cannot be read");
    Ok(())
}

/// Lines over common axes, with a legend.
pub struct Plot {
    pub title: String,
    /// What the axes are.
    pub axes: [&'static str; 2],
    /// Whether both axes are logarithmic.
    pub log: bool,
    pub lines: Vec<Line>,
}

impl Plot {
    /// The plot as SVG.
    pub fn svg(&self) -> Result<String> {
        let mut svg = String::new();
        self.draw(&SVGBackend::with_string(&mut svg, SIZE).into_drawing_area())?;
        Ok(svg)
    }

    /// Writes the plot as PNG.
    pub fn save_png(&self, path: &Path) -> Result<()> {
        let mut rgb = vec![0; (SIZE.0 * SIZE.1 * 3) as usize];
        self.draw(&BitMapBackend::with_buffer(&mut rgb, SIZE).into_drawing_area())?;
        let rgba: Vec<u8> = rgb.chunks_exact(3).flat_map(|p| [p[0], p[1], p[2], 255]).collect();
        RgbaImage { width: SIZE.0, height: SIZE.1, rgba: &rgba }.save_png(path)
    }

    fn draw<B>(&self, root: &DrawingArea<B, Shift>) -> Result<()>
    where
        B: DrawingBackend<ErrorType: 'static>,
    {
        register_font()?;
        let log = self.log;
        let scale = |v: f64| if log { v.max(1e-9).log10() } else { v };
        let all = || self.lines.iter().flat_map(|l| &l.points).map(|&(x, y)| (scale(x), scale(y)));
        let bound = |get: fn((f64, f64)) -> f64, pick: fn(f64, f64) -> f64, none: f64| {
            all().map(get).reduce(pick).unwrap_or(none)
        };
        let (left, right) = (bound(|p| p.0, f64::min, 0.0), bound(|p| p.0, f64::max, 1.0));
        let (low, high) = (bound(|p| p.1, f64::min, 0.0), bound(|p| p.1, f64::max, 1.0));
        let low = if log { low } else { low.min(0.0) };
        root.fill(&WHITE).map_err(failed)?;
        let (area, legend) = root.split_horizontally(CHART_WIDTH);
        let mut chart = ChartBuilder::on(&area)
            .caption(&self.title, ("sans-serif", 18))
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
            .x_desc(self.axes[0])
            .y_desc(self.axes[1])
            .x_label_formatter(&label)
            .y_label_formatter(&label)
            .draw()
            .map_err(failed)?;
        for (i, line) in self.lines.iter().enumerate() {
            let color = Palette99::pick(i).to_rgba();
            let points = line.points.iter().map(|&(x, y)| (scale(x), scale(y)));
            chart.draw_series(LineSeries::new(points, color.stroke_width(2))).map_err(failed)?;
            let y = 48 + 20 * i as i32;
            let key = PathElement::new([(8, y), (30, y)], color.stroke_width(2));
            legend.draw(&key).map_err(failed)?;
            let name = Text::new(line.name.as_str(), (38, y - 6), ("sans-serif", 13));
            legend.draw(&name).map_err(failed)?;
        }
        root.present().map_err(failed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;
    use std::io::BufReader;

    #[test]
    fn a_plot_is_written_as_svg_and_as_png() {
        let line = |name: &str, y: f64| Line {
            name: name.into(),
            points: vec![(0.0, y), (1.0, 2.0 * y), (2.0, y)],
        };
        let plot =
            |lines| Plot { title: "Leaves".into(), axes: ["frame", "leaves"], log: false, lines };
        let svg = plot(vec![line("thrown", 3.0)]).svg().unwrap();
        assert!(svg.contains("<svg") && svg.contains("thrown") && svg.contains("polyline"));

        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("plot.png");
        let read = |lines| {
            plot(lines).save_png(&file).unwrap();
            let mut reader =
                png::Decoder::new(BufReader::new(File::open(&file).unwrap())).read_info().unwrap();
            let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
            let info = reader.next_frame(&mut rgb).unwrap();
            assert_eq!((info.width, info.height), SIZE);
            rgb
        };
        let dark = |rgb: &[u8]| rgb.chunks_exact(3).filter(|p| p[1] < 128).count();
        let (bare, drawn) = (read(Vec::new()), read(vec![line("thrown", 3.0)]));
        // Title, axes and their labels, and then a line and its name.
        assert!(dark(&bare) > 1000 && dark(&drawn) > dark(&bare) + 100);
    }
}
