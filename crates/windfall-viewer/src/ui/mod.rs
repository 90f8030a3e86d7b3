//! What is around the picture: panel, timeline, plots, help.

mod controls;
mod drawing;
mod help;
mod panel;
mod plots;
mod report;
#[cfg(test)]
mod tests;
mod timeline;
mod values;

use crate::app::Viewer;
use crate::input::hands;
use crate::state::camera::Mode;
use eframe::egui_wgpu::RenderState;
use egui::{Align2, CentralPanel, Color32, Panel, RichText, Sense, Ui};
use std::time::Duration;

pub use panel::panel;

/// How long a note stays; an error stays until somebody takes it away.
const NOTED: Duration = Duration::from_secs(12);

/// How widgets look.
pub fn style(context: &egui::Context) {
    context.options_mut(|options| options.theme_preference = egui::ThemePreference::System);
    context.all_styles_mut(|style| {
        style.spacing.slider_width = 130.0;
        style.spacing.item_spacing.y = 4.0;
    });
}

/// One frame of the window.
pub fn show(viewer: &mut Viewer, ui: &mut Ui, render: &RenderState) {
    Panel::bottom("timeline").show(ui, |ui| timeline::timeline(viewer, ui));
    if viewer.panel {
        let most = (0.6 * ui.available_width()).clamp(120.0, 520.0);
        let panel_of = Panel::left("panel").default_size(most.min(330.0));
        panel_of.size_range(most.min(240.0)..=most).show(ui, |ui| {
            egui::ScrollArea::both().auto_shrink(false).show(ui, |ui| panel(viewer, ui));
        });
    }
    CentralPanel::no_frame().show(ui, |ui| forest(viewer, ui, render));
    help::help(viewer, ui.ctx());
    path_box(viewer, ui.ctx());
}

/// The picture, and what is written over it.
fn forest(viewer: &mut Viewer, ui: &mut Ui, render: &RenderState) {
    let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
    let name = if viewer.is_loading() { "the forest, loading" } else { "the forest" };
    response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Image, true, name));
    if response.clicked() || response.drag_started() {
        ui.memory_mut(|memory| {
            if let Some(id) = memory.focused() {
                memory.surrender_focus(id);
            }
        });
    }
    if response.double_clicked() {
        viewer.frame_trees();
    }
    let hands = hands(ui, &response, viewer.rig.mode);
    let moved = crate::state::camera::Hands {
        elapsed: hands.elapsed,
        fast: hands.fast,
        ..Default::default()
    };
    if hands != moved {
        if viewer.rig.mode == Mode::Path {
            viewer.rig.mode = Mode::Orbit;
        }
        let ground = viewer.ground();
        viewer.rig.update(&hands, ground);
        ui.ctx().request_repaint();
    }
    let points = ui.ctx().pixels_per_point();
    let largest = render.device.limits().max_texture_dimension_2d;
    let side = |length: f32| ((length * points).round() as u32).min(largest);
    let size = (side(rect.width()), side(rect.height()));
    let painter = ui.painter_at(rect);
    // A window of nothing has no picture.
    if size.0 > 0 && size.1 > 0 {
        viewer.draw(render, size);
    }
    let whole = egui::Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
    match viewer.picture.as_ref().and_then(crate::picture::Picture::id) {
        Some(id) => {
            painter.image(id, rect, whole, Color32::WHITE);
        }
        None => {
            painter.rect_filled(rect, 0.0, Color32::from_rgb(150, 170, 190));
        }
    }
    loading(viewer, ui, rect);
    lines(viewer, ui, rect);
    leaves(viewer, &response, size);
}

/// The leaf under the pointer: in words, and thrown where it is clicked.
fn leaves(viewer: &mut Viewer, response: &egui::Response, size: (u32, u32)) {
    let rect = response.rect;
    let place = |at: egui::Pos2| {
        let at = (at - rect.min) / rect.size();
        (at.x, at.y)
    };
    if response.clicked()
        && let Some(at) = response.interact_pointer_pos()
        && let Some(hit) = viewer.leaf_at(place(at), size)
    {
        viewer.throw(&hit);
    }
    let still = response.ctx.input(|input| input.pointer.time_since_last_movement() > 0.3);
    let Some(at) = response.hover_pos().filter(|_| still && !response.dragged()) else {
        viewer.hover = None;
        return;
    };
    // Looked for once where the pointer rests.
    if viewer.hover.as_ref().is_none_or(|(known, _)| *known != at) {
        let hit = viewer.leaf_at(place(at), size);
        viewer.hover = Some((at, hit.and_then(|hit| viewer.describe(&hit))));
    }
    if let Some((_, Some(text))) = &viewer.hover {
        response.clone().on_hover_text_at_pointer(text);
    }
}

/// How far loading has come, over the picture.
fn loading(viewer: &mut Viewer, ui: &Ui, rect: egui::Rect) {
    let Some((what, done, of)) = viewer.progress.clone() else { return };
    let area = egui::Area::new("loading".into())
        .pivot(Align2::CENTER_CENTER)
        .fixed_pos(rect.center())
        .order(egui::Order::Foreground);
    area.show(ui.ctx(), |ui| {
        egui::Frame::popup(ui.style()).show(ui, |ui| {
            ui.set_width(260.0);
            ui.label(format!("Loading {what}"));
            let share = done as f32 / of.max(1) as f32;
            ui.add(egui::ProgressBar::new(share).text(format!("{done} of {of}")));
            if viewer.world.is_some() && ui.button("Cancel").clicked() {
                viewer.cancel();
            }
        });
    });
}

/// What was said last, over the picture.
fn lines(viewer: &mut Viewer, ui: &Ui, rect: egui::Rect) {
    viewer.lines.retain(|line| line.error || line.at.elapsed() < NOTED);
    if viewer.lines.is_empty() {
        return;
    }
    let area = egui::Area::new("lines".into())
        .pivot(Align2::LEFT_BOTTOM)
        .fixed_pos(rect.left_bottom() + egui::vec2(8.0, -8.0))
        .order(egui::Order::Foreground);
    area.show(ui.ctx(), |ui| {
        egui::Frame::popup(ui.style()).show(ui, |ui| {
            ui.set_max_width((rect.width() - 40.0).clamp(100.0, 620.0));
            let first = viewer.lines.len().saturating_sub(4);
            for line in &viewer.lines[first..] {
                let text = RichText::new(&line.text);
                let text = if line.error { text.color(ui.visuals().error_fg_color) } else { text };
                ui.add(egui::Label::new(text).wrap());
            }
            if ui.small_button("Clear").clicked() {
                viewer.lines.clear();
            }
        });
    });
}

/// Where a file's name is written.
fn path_box(viewer: &mut Viewer, context: &egui::Context) {
    let Some(mut path) = viewer.path_box.take() else { return };
    let (mut open, mut go) = (true, false);
    egui::Window::new("Open a file")
        .open(&mut open)
        .collapsible(false)
        .anchor(Align2::CENTER_CENTER, egui::Vec2::ZERO)
        .show(context, |ui| {
            ui.label("A scene, tree, fall path or picture of the sky. Files may be dropped too.");
            let field = ui.add(egui::TextEdit::singleline(&mut path).desired_width(420.0));
            if !field.has_focus() && !field.lost_focus() {
                field.request_focus();
            }
            go = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
            ui.checkbox(&mut viewer.adding, "add trees to those that are there");
            go |= ui.button("Open").clicked();
        });
    let away = context.input(|input| input.key_pressed(egui::Key::Escape));
    if go && !path.trim().is_empty() {
        viewer.open(path.trim(), None);
    } else if open && !away && !go {
        viewer.path_box = Some(path);
    }
}
