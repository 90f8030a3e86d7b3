//! Tables of measurements beside what the papers print: one model for the text, the numbers and their comparison.

use crate::image::LinearImage;
use crate::statistics::Quartiles;
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::path::Path;

/// All that a run has measured.
#[derive(Debug, Serialize, Deserialize)]
pub struct Report {
    /// Of the program.
    pub version: String,
    /// Whether it was the short run.
    pub quick: bool,
    pub adapters: Vec<AdapterReport>,
}

/// What was measured on one adapter.
#[derive(Debug, Serialize, Deserialize)]
pub struct AdapterReport {
    pub adapter: String,
    pub driver: String,
    pub tables: Vec<Table>,
    /// Figures that are pictures.
    #[serde(default)]
    pub figures: Vec<Figure>,
}

/// A picture beside the report.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Figure {
    pub title: String,
    /// The file, below the folder of the report.
    pub file: String,
}

impl Figure {
    /// Writes a picture as PNG.
    pub fn save(
        image: &LinearImage,
        folder: &Path,
        name: &str,
        title: &str,
    ) -> anyhow::Result<Self> {
        let file = format!("papers/{name}.png");
        image.save_png(&folder.join(&file))?;
        Ok(Self { title: title.to_owned(), file })
    }
}

/// A table or figure of a paper.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Table {
    /// Short and stable, for comparisons.
    pub id: String,
    pub title: String,
    /// What the numbers are of.
    pub scene: String,
    /// The ratio that the paper's claim rests on.
    pub ratio: String,
    pub rows: Vec<Row>,
    /// What agrees, what differs, and why.
    pub remark: String,
    /// A plot beside the report: its files without `.svg` and `.png`.
    pub plot: Option<String>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Row {
    pub name: String,
    /// Of a frame, milliseconds.
    pub ms: Quartiles,
    /// As [`Table::ratio`] says.
    pub measured: Option<f64>,
    /// The same from the numbers that the paper prints.
    pub printed: Option<f64>,
    /// What else was counted.
    pub notes: String,
}

impl Report {
    /// The whole report as Markdown.
    pub fn markdown(&self) -> String {
        let mut out = String::new();
        let run = if self.quick { "short run (`--quick`)" } else { "full run" };
        let _ = writeln!(
            out,
            "`windfall bench papers`, version {}, {run}. Times are medians (quartiles) of whole frames by the wall \
             clock. Absolute times of machines that are twenty years apart say little: each table compares the *ratio* \
             on which the paper's claim rests.\n",
            self.version
        );
        for adapter in &self.adapters {
            let _ = writeln!(out, "## {}\n\nDriver: {}\n", adapter.adapter, adapter.driver);
            for table in &adapter.tables {
                table.markdown(&mut out);
            }
            if !adapter.figures.is_empty() {
                out.push_str("### Figures that are pictures\n\n");
            }
            for Figure { title, file } in &adapter.figures {
                let _ = writeln!(out, "{title}:\n\n![{title}]({file})\n");
            }
        }
        out.truncate(out.trim_end().len());
        out.push('\n');
        out
    }
}

impl Table {
    fn markdown(&self, out: &mut String) {
        let _ = writeln!(out, "### {}\n\n{}. Ratio: {}.\n", self.title, self.scene, self.ratio);
        out.push_str("| | ms | ratio | printed | |\n|---|---|---|---|---|\n");
        for row in &self.rows {
            let number = |v: Option<f64>| v.map_or(String::new(), |v| format!("{v:.2}"));
            let (measured, printed) = (number(row.measured), number(row.printed));
            let _ = writeln!(
                out,
                "| {} | {} | {measured} | {printed} | {} |",
                row.name, row.ms, row.notes
            );
        }
        if let Some(plot) = &self.plot {
            let _ = writeln!(out, "\n![{}]({plot}.svg)", self.title);
        }
        let _ = writeln!(out, "\n{}\n", self.remark);
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// A report of one row.
    pub fn report(low: f64, median: f64, high: f64) -> Report {
        let row = Row {
            name: "vertex".into(),
            ms: Quartiles { low, median, high },
            measured: Some(0.25),
            printed: Some(0.125),
            notes: "7 leaves".into(),
        };
        let table = Table {
            id: "t".into(),
            title: "Table 1".into(),
            scene: "Trees".into(),
            ratio: "frame rate".into(),
            rows: vec![row],
            remark: "Agrees.".into(),
            plot: Some("papers/t".into()),
        };
        let figure = Figure { title: "Trees".into(), file: "papers/trees.png".into() };
        let adapter = AdapterReport {
            adapter: "A".into(),
            driver: "D 1".into(),
            tables: vec![table],
            figures: vec![figure],
        };
        Report { version: "1".into(), quick: true, adapters: vec![adapter] }
    }

    #[test]
    fn a_table_stands_beside_what_is_printed() {
        let text = report(1.0, 2.0, 3.0).markdown();
        for part in [
            "## A\n",
            "Driver: D 1",
            "| vertex | 2.00 (1.00..3.00) | 0.25 | 0.12 | 7 leaves |",
            "![Table 1](papers/t.svg)",
            "Agrees.",
            "Trees:\n\n![Trees](papers/trees.png)",
        ] {
            assert!(text.contains(part), "{part} in {text}");
        }
    }

    #[test]
    fn what_is_written_is_read_again() {
        let text = serde_json::to_string(&report(1.0, 2.0, 3.0)).unwrap();
        let read: Report = serde_json::from_str(&text).unwrap();
        assert_eq!(read.markdown(), report(1.0, 2.0, 3.0).markdown());
    }
}
