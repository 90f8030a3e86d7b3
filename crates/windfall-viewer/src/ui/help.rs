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
    egui::Window::new("Keys").open(&mut open).collapsible(false).show(context, |ui| {
        egui::Grid::new("keys").striped(true).num_columns(2).show(ui, |ui| {
            for (hand, does) in HANDS {
                ui.strong(hand);
                ui.label(does);
                ui.end_row();
            }
            let mut before = "";
            for (modifiers, key, _, does) in ACTIONS {
                if does == before {
                    continue;
                }
                before = does;
                let shortcut = egui::KeyboardShortcut::new(modifiers, key);
                ui.strong(ui.ctx().format_shortcut(&shortcut));
                ui.label(does);
                ui.end_row();
            }
        });
    });
    viewer.help = open;
}
