//! The panel: everything that can be set.

use super::plots::plots;
use super::report::report;
use super::values::slider;
use super::{controls, drawing};
use crate::app::{USUAL_BUDGET, Viewer};
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
        let mut budget = viewer.pace.milliseconds();
        let of_scene = viewer.base.scene.budget.unwrap_or(USUAL_BUDGET);
        let about = ("frame budget, ms", "longest time of a picture while things move; 0: none");
        if slider(ui, about, &mut budget, of_scene, 0.0..=200.0, |s| s.max_decimals(0)) {
            viewer.pace.set_milliseconds(budget);
        }
        ui.weak(format!("given up for it: {:.0} %", viewer.pace.saving() * 100.0));
        let of_camera = viewer.base.scene.camera.first().map_or(50.0, |key| key.fov);
        let about = ("field of view, °", "from the lower to the upper edge");
        slider(ui, about, &mut viewer.rig.fov, of_camera, 10.0..=110.0, |s| s);
        // Set once the hand is off: letters that grow under it would carry the slider away.
        let mut zoom = ui.ctx().zoom_factor();
        ui.horizontal_wrapped(|ui| {
            let slider = ui.add(egui::Slider::new(&mut zoom, 0.5..=3.0));
            slider.clone().labelled_by(ui.label("size of letters").id);
            if slider.drag_stopped() {
                ui.ctx().set_zoom_factor(zoom);
            }
        });
        ui.horizontal_wrapped(|ui| {
            let mut theme = ui.ctx().options(|options| options.theme_preference);
            theme_buttons(ui, &mut theme);
            ui.ctx().set_theme(theme);
        });
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

/// egui's own are in a row that does not wrap.
fn theme_buttons(ui: &mut Ui, theme: &mut egui::ThemePreference) {
    use egui::ThemePreference::{Dark, Light, System};
    for (choice, label) in [(System, "💻 System"), (Dark, "🌙 Dark"), (Light, "☀ Light")] {
        ui.selectable_value(theme, choice, label);
    }
}
