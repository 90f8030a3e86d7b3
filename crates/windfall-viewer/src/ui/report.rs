//! What leaves the viewer: buttons of the panel.

use crate::app::Viewer;
use egui::Ui;

pub fn report(viewer: &mut Viewer, ui: &mut Ui) {
    ui.horizontal_wrapped(|ui| {
        if ui.button("Save the picture").on_hover_text("P").clicked() {
            viewer.save_picture();
        }
        if ui.button("Save the scene").clicked() {
            viewer.save_scene();
        }
        if ui.button("Copy a link").clicked() {
            let link = format!("{}#{}", viewer.page, viewer.link());
            ui.ctx().copy_text(link.clone());
            viewer.say(false, format!("copied {link}"));
        }
        if ui.button("Copy the command line").clicked() {
            let (line, file) = viewer.command();
            ui.ctx().copy_text(line.clone());
            let hint = if file { " (save the scene as scene.ron for it)" } else { "" };
            viewer.say(false, format!("copied {line}{hint}"));
        }
        #[cfg(not(target_arch = "wasm32"))]
        if viewer.program.is_some() && viewer.film.is_none() {
            let film = ui.button("Make a film");
            let about =
                "along the recorded path, of the window's size and in full, beside the window";
            if film.on_hover_text(about).clicked() {
                viewer.make_film();
            }
        }
        let film = ui.button("Copy the command line of a film");
        if film.on_hover_text("along the recorded path").clicked() {
            let line = crate::state::command::film(&viewer.scene(), "scene.ron");
            ui.ctx().copy_text(line.clone());
            viewer.say(false, format!("copied {line} (save the scene as scene.ron for it)"));
        }
    });
    #[cfg(not(target_arch = "wasm32"))]
    if let Some(film) = &viewer.film {
        ui.add(egui::ProgressBar::new(film.share).text("film").desired_width(120.0));
        if ui.button("Give the film up").clicked() {
            viewer.film = None;
        }
    }
    ui.separator();
    ui.horizontal_wrapped(|ui| {
        if ui.button("Bookmark this view").on_hover_text("B").clicked() {
            let key = viewer.key();
            viewer.bookmarks.push(key);
        }
        let mut go = None;
        let mut remove = None;
        for (i, key) in viewer.bookmarks.iter().enumerate() {
            let button = ui.button(format!("{}", i + 1));
            let button = button.on_hover_text("click: go there; right click: forget");
            if button.clicked() {
                go = Some(*key);
            }
            if button.secondary_clicked() {
                remove = Some(i);
            }
        }
        if let Some(key) = go {
            viewer.stand(&key);
            viewer.clock.seek(key.time);
        }
        if let Some(i) = remove {
            viewer.bookmarks.remove(i);
        }
    });
    ui.horizontal_wrapped(|ui| {
        if ui.button("Add this view to the path").on_hover_text("R").clicked() {
            viewer.record();
        }
        let keys = viewer.settings.scene.camera.len();
        let text = if viewer.recording { "recorded" } else { "of the scene" };
        ui.label(format!("path {text}: {keys} views"));
    });
}
