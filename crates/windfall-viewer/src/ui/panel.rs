//! The panel: everything that can be set.

use super::plots::plots;
use super::report::report;
use super::{controls, drawing};
use crate::app::Viewer;
use crate::state::settings::Settings;
use egui::{CollapsingHeader, Ui};

/// What is in a section of the panel: the settings, and those to go back to.
type Section = fn(&mut Ui, &mut Settings, &Settings);

pub fn panel(viewer: &mut Viewer, ui: &mut Ui) {
    // With large letters in a small window the boxes for numbers come first.
    ui.spacing_mut().slider_width = (ui.available_width() - 190.0).clamp(40.0, 130.0);
    ui.horizontal_wrapped(|ui| {
        let mut chosen = None;
        egui::ComboBox::from_label("scene").selected_text(short(&viewer.settings.name)).show_ui(
            ui,
            |ui| {
                for name in windfall_scenes::NAMES {
                    if ui.selectable_label(viewer.settings.name == name, name).clicked() {
                        chosen = Settings::named(name);
                    }
                }
            },
        );
        if let Some(settings) = chosen {
            viewer.choose(settings);
        }
        if ui.button("Open…").clicked() {
            viewer.path_box = Some(String::new());
        }
        let undo = ui.add_enabled(viewer.history.can_undo(), egui::Button::new("Undo"));
        if undo.on_hover_text("Ctrl+Z").clicked() {
            viewer.act(crate::input::Action::Undo);
        }
        let redo = ui.add_enabled(viewer.history.can_redo(), egui::Button::new("Redo"));
        if redo.on_hover_text("Ctrl+Shift+Z").clicked() {
            viewer.act(crate::input::Action::Redo);
        }
    });
    let base = &viewer.base;
    let settings = &mut viewer.settings;
    let sections: [(&str, bool, Section); 7] = [
        ("Trees", true, controls::trees),
        ("Season and leaves", true, controls::season),
        ("Wind", false, controls::wind),
        ("Sky", false, controls::sky),
        ("Simplification", false, drawing::detail),
        ("Method", false, drawing::method),
        ("Effects", false, drawing::effects),
    ];
    for (title, open, section) in sections {
        CollapsingHeader::new(title).default_open(open).show(ui, |ui| section(ui, settings, base));
    }
    CollapsingHeader::new("View").show(ui, |ui| {
        drawing::view(ui, settings);
        ui.horizontal(|ui| {
            let mut budget = viewer.pace.milliseconds();
            let slider = egui::Slider::new(&mut budget, 0.0..=200.0).suffix(" ms");
            let slider = ui.add(slider.max_decimals(0).text("frame budget"));
            if slider
                .on_hover_text("longest time of a picture while things move; 0: none")
                .changed()
            {
                viewer.pace.set_milliseconds(budget);
            }
        });
        ui.horizontal(|ui| {
            ui.weak(format!("given up for it: {:.0} %", viewer.pace.saving() * 100.0));
        });
        ui.add(egui::Slider::new(&mut viewer.rig.fov, 10.0..=110.0).text("field of view, °"));
        let mut zoom = ui.ctx().zoom_factor();
        if ui.add(egui::Slider::new(&mut zoom, 0.5..=3.0).text("size of letters")).drag_stopped() {
            ui.ctx().set_zoom_factor(zoom);
        }
        egui::widgets::global_theme_preference_buttons(ui);
    });
    CollapsingHeader::new("Pictures, links, paths").show(ui, |ui| report(viewer, ui));
    CollapsingHeader::new("What goes on").show(ui, |ui| plots(viewer, ui));
    if ui.button("Keys").on_hover_text("F1").clicked() {
        viewer.help = !viewer.help;
    }
}

/// The name of a file without its folder.
fn short(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or(name)
}
