//! Rows of the panel: a value, its slider with a box for numbers, and the way back to what it was.

use egui::{Response, Slider, Ui};
use std::ops::RangeInclusive;

/// A row: label, slider, and a button that brings `default` back where the value is another.
pub fn slider<T: egui::emath::Numeric>(
    ui: &mut Ui,
    (label, about): (&str, &str),
    value: &mut T,
    default: T,
    range: RangeInclusive<T>,
    change: impl FnOnce(Slider<'_>) -> Slider<'_>,
) -> bool {
    let mut changed = false;
    ui.horizontal_wrapped(|ui| {
        let slider = Slider::new(value, range).clamping(egui::SliderClamping::Edits);
        let slider = ui.add(change(slider.smart_aim(true)));
        let text = ui.label(label).on_hover_text(about);
        let slider = slider.labelled_by(text.id).on_hover_text(about);
        changed = slider.changed();
        if value.to_f64() != default.to_f64() && back(ui, label).clicked() {
            *value = default;
            changed = true;
        }
    });
    changed
}

/// A row with a switch.
pub fn switch(ui: &mut Ui, label: &str, value: &mut bool, default: bool) {
    ui.horizontal_wrapped(|ui| {
        ui.checkbox(value, label);
        if *value != default && back(ui, label).clicked() {
            *value = default;
        }
    });
}

/// A row with a choice of names.
pub fn choice<T: PartialEq + Copy>(
    ui: &mut Ui,
    label: &str,
    value: &mut T,
    default: T,
    all: &[T],
    name: impl Fn(T) -> String,
) {
    ui.horizontal_wrapped(|ui| {
        let box_of = egui::ComboBox::from_id_salt(label).selected_text(name(*value));
        let chosen = box_of.show_ui(ui, |ui| {
            for &one in all {
                ui.selectable_value(value, one, name(one));
            }
        });
        let text = ui.label(label);
        chosen.response.labelled_by(text.id);
        if *value != default && back(ui, label).clicked() {
            *value = default;
        }
    });
}

fn back(ui: &mut Ui, label: &str) -> Response {
    let button = ui.small_button("⟲").on_hover_text(format!("{label}: back to the scene's value"));
    let name = format!("reset {label}");
    button.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, &name));
    button
}
