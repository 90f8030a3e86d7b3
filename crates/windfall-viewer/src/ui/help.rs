//! The list of keys.

use crate::app::Viewer;
use crate::input::ACTIONS;

const HANDS: [(&str, &str); 8] = [
    ("drag", "turn around the target, or look about"),
    ("right drag, middle drag", "shift the view (orbit)"),
    ("wheel, two fingers", "nearer, farther"),
    ("W A S D, arrows", "move ahead, left, back, right"),
    ("Q, E", "down, up"),
    ("Shift", "faster"),
    ("click on a leaf", "it falls"),
    ("double click", "see everything"),
];

pub fn help(viewer: &mut Viewer, context: &egui::Context) {
    let mut open = viewer.help;
    let window = egui::Window::new("Keys").open(&mut open).collapsible(false);
    let middle = context.content_rect().center();
    window.pivot(egui::Align2::CENTER_CENTER).default_pos(middle).vscroll(true).show(
        context,
        |ui| {
            egui::Grid::new("keys").striped(true).num_columns(2).show(ui, |ui| {
                for (hand, does) in HANDS {
                    ui.strong(hand);
                    ui.label(does);
                    ui.end_row();
                }
                let mut known = Vec::new();
                for (modifiers, key, _, does) in ACTIONS {
                    if known.contains(&does) {
                        continue;
                    }
                    known.push(does);
                    let shortcut = egui::KeyboardShortcut::new(modifiers, key);
                    ui.strong(ui.ctx().format_shortcut(&shortcut));
                    ui.label(does);
                    ui.end_row();
                }
            });
        },
    );
    viewer.help = open;
}
