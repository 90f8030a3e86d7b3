//! Time and the camera's mode, below the picture.

use crate::app::Viewer;
use crate::state::camera::Mode;
use crate::state::clock;
use egui::{DragValue, Slider, Ui, WidgetType};

pub fn timeline(viewer: &mut Viewer, ui: &mut Ui) {
    ui.horizontal_wrapped(|ui| {
        if named(ui, "☰", "panel").on_hover_text("panel (M)").clicked() {
            viewer.panel = !viewer.panel;
        }
        for mode in Mode::ALL {
            let number = Mode::ALL.iter().position(|m| *m == mode).unwrap_or(0) + 1;
            let chosen = viewer.rig.mode == mode;
            let button = ui.selectable_label(chosen, mode.name());
            if button.on_hover_text(format!("key {number}")).clicked() {
                viewer.rig.mode = mode;
            }
        }
        ui.separator();
        if named(ui, "⏮", "to the first moment")
            .on_hover_text("to the first moment (Home)")
            .clicked()
        {
            viewer.clock.seek(0.0);
        }
        if named(ui, "◀", "a frame back").on_hover_text("a frame back (,)").clicked() {
            viewer.clock.step(-1.0);
        }
        let (sign, word) = if viewer.clock.playing { ("⏸", "pause") } else { ("▶", "play") };
        let button = ui.button(sign).on_hover_text(format!("{word} (space)"));
        button.widget_info(|| egui::WidgetInfo::labeled(WidgetType::Button, true, word));
        if button.clicked() {
            viewer.clock.playing = !viewer.clock.playing;
        }
        if named(ui, "▶|", "a frame on").on_hover_text("a frame on (.)").clicked() {
            viewer.clock.step(1.0);
        }
        let speed = DragValue::new(&mut viewer.clock.speed).range(-100.0..=100.0).speed(0.05);
        ui.add(speed.suffix("×").max_decimals(2)).on_hover_text("speed; below 0 backwards");
        let mut time = viewer.clock.time;
        let end = viewer.clock.end;
        let parse = |text: &str| clock::read(text);
        let field = DragValue::new(&mut time).range(0.0..=1e7).speed(0.1);
        let field = field.custom_formatter(|time, _| clock::text(time)).custom_parser(parse);
        let field = ui.add_sized([76.0, ui.spacing().interact_size.y], field);
        let field = field.on_hover_text("minutes and seconds, or seconds");
        field.widget_info(|| egui::WidgetInfo::labeled(WidgetType::DragValue, true, "moment"));
        if ui.available_size_before_wrap().x < 140.0 {
            ui.end_row();
        }
        ui.spacing_mut().slider_width = (ui.available_size_before_wrap().x - 12.0).max(80.0);
        let slider = Slider::new(&mut time, 0.0..=end).show_value(false).trailing_fill(true);
        let slider = ui.add(slider.clamping(egui::SliderClamping::Never));
        if slider.changed() || field.changed() {
            viewer.clock.playing = false;
            viewer.clock.seek(time);
        }
        slider.widget_info(|| egui::WidgetInfo::slider(true, time, "time"));
    });
}

/// A button with a sign, and its name for those who do not see it.
fn named(ui: &mut Ui, sign: &str, name: &str) -> egui::Response {
    let button = ui.button(sign);
    button.widget_info(|| egui::WidgetInfo::labeled(WidgetType::Button, true, name));
    button
}
