//! What goes on: rates, passes, leaves and triangles.

use crate::app::Viewer;
use crate::picture::Picture;
use crate::statistics::{Count, Statistics};
use egui::Ui;
use egui_plot::{Legend, Line, Plot, PlotPoints};

/// Lines of a plot: a name, and the value of a moment.
type Lines<'a> = &'a [(&'a str, fn(&Count) -> f64)];

pub fn plots(viewer: &mut Viewer, ui: &mut Ui) {
    let statistics = &viewer.statistics;
    let Some(picture) = &viewer.picture else { return };
    let size = picture.size().unwrap_or_default();
    ui.label(format!("{:.1} pictures/s of {} × {}", statistics.rate(), size.0, size.1));
    let counts = picture.latest;
    egui::Grid::new("counts").num_columns(2).show(ui, |ui| {
        let rows = [
            ("trees in view", counts.trees.visible),
            ("trees hidden, left out", counts.trees.hidden),
            ("leaves on twigs, drawn", counts.trees.leaves_hanging),
            ("leaves in the air", counts.falling),
            ("of these in view", counts.falling_drawn),
            ("leaves on the ground", counts.landed),
            ("triangles", counts.trees.triangles),
        ];
        for (name, count) in rows {
            ui.label(name);
            ui.monospace(grouped(count));
            ui.end_row();
        }
        ui.label("λ over all");
        ui.monospace(format!("{:.3}", counts.trees.lambda_total()));
        ui.end_row();
    });
    intervals(statistics, ui);
    plot(
        statistics,
        ui,
        "leaves over time, s",
        &[
            ("in the air", |c| c.counts.falling as f64),
            ("in view", |c| c.counts.falling_drawn as f64),
            ("landed", |c| c.counts.landed as f64),
            ("thrown", |c| (c.counts.falling + c.counts.landed) as f64),
        ],
    );
    plot(statistics, ui, "λ over time", &[("λ", |c| c.counts.trees.lambda_total())]);
    plot(
        statistics,
        ui,
        "triangles over time",
        &[("triangles", |c| c.counts.trees.triangles as f64)],
    );
    passes(picture, ui);
}

fn intervals(statistics: &Statistics, ui: &mut Ui) {
    let points: PlotPoints<'_> =
        statistics.intervals.iter().enumerate().map(|(i, ms)| [i as f64, *ms]).collect();
    ui.label("milliseconds between pictures");
    area("intervals", ui).include_y(0.0).show(ui, |plot| {
        plot.line(Line::new("ms", points));
    });
}

fn plot(statistics: &Statistics, ui: &mut Ui, title: &str, lines: Lines<'_>) {
    ui.label(title);
    area(title, ui)
        .legend(Legend::default().text_style(egui::TextStyle::Small))
        .include_y(0.0)
        .show(ui, |plot| {
            for (name, value) in lines {
                let points: PlotPoints<'_> =
                    statistics.counts.iter().map(|count| [count.time, value(count)]).collect();
                plot.line(Line::new(*name, points));
            }
        });
}

fn area<'a>(id: &str, ui: &Ui) -> Plot<'a> {
    Plot::new(id.to_owned())
        .height(110.0)
        .width((ui.available_width() - 40.0).clamp(60.0, 480.0))
        .allow_scroll(false)
        .allow_drag(false)
        .allow_zoom(false)
}

/// GPU time by pass.
fn passes(picture: &Picture, ui: &mut Ui) {
    if picture.passes.is_empty() {
        ui.weak("this GPU gives no time by pass");
        return;
    }
    ui.label("GPU milliseconds by pass");
    egui::Grid::new("passes").num_columns(2).striped(true).show(ui, |ui| {
        for (label, milliseconds) in &picture.passes {
            ui.label(label);
            ui.monospace(format!("{milliseconds:.2}"));
            ui.end_row();
        }
        let sum: f64 = picture.passes.iter().map(|pass| pass.1).sum();
        ui.strong("all");
        ui.monospace(format!("{sum:.2}"));
        ui.end_row();
    });
}

/// A number with its thousands apart.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}
