//! From mouse, fingers and keys to what the camera does.

use crate::state::camera::{Hands, Mode};
use egui::{Key, Modifiers, PointerButton, Response, Ui};
use glam::{DVec2, DVec3};

/// Radians for each point that the mouse moves.
const TURN: f64 = 0.006;
/// Keys that walk, with their direction: right, up, ahead.
const WALK: [(Key, [f64; 3]); 10] = [
    (Key::W, [0.0, 0.0, 1.0]),
    (Key::ArrowUp, [0.0, 0.0, 1.0]),
    (Key::S, [0.0, 0.0, -1.0]),
    (Key::ArrowDown, [0.0, 0.0, -1.0]),
    (Key::A, [-1.0, 0.0, 0.0]),
    (Key::ArrowLeft, [-1.0, 0.0, 0.0]),
    (Key::D, [1.0, 0.0, 0.0]),
    (Key::ArrowRight, [1.0, 0.0, 0.0]),
    (Key::E, [0.0, 1.0, 0.0]),
    (Key::Q, [0.0, -1.0, 0.0]),
];

/// What hands do with the picture, shown as `response`, in this frame.
pub fn hands(ui: &Ui, response: &Response, mode: Mode) -> Hands {
    let mut hands = Hands::default();
    let shortcut = shortcut(ui, response.id.with("shortcut"));
    let typing = ui.memory(|memory| memory.focused().is_some_and(|id| id != response.id));
    ui.input(|input| {
        hands.elapsed = f64::from(input.stable_dt);
        hands.fast = input.modifiers.shift;
        if !typing && !shortcut {
            for (key, [right, up, ahead]) in WALK {
                if input.key_down(key) {
                    hands.step += DVec3::new(right, up, ahead);
                }
            }
            hands.step = hands.step.clamp(DVec3::NEG_ONE, DVec3::ONE);
        }
        // Fingers do not hover.
        let fingers = input.multi_touch().filter(|touch| response.rect.contains(touch.center_pos));
        if let Some(touch) = fingers {
            hands.zoom += f64::from(touch.zoom_delta.ln());
            let moved = touch.translation_delta / response.rect.height().max(1.0);
            hands.shift += DVec2::new(f64::from(moved.x), f64::from(moved.y));
        } else if response.hovered() || response.dragged() {
            hands.zoom += f64::from(input.smooth_scroll_delta.y) * 0.003;
            hands.zoom += f64::from(input.zoom_delta().ln());
        }
    });
    let moved = response.drag_delta();
    let moved = DVec2::new(f64::from(moved.x), f64::from(moved.y));
    let shifting = response.dragged_by(PointerButton::Middle)
        || response.dragged_by(PointerButton::Secondary) && mode == Mode::Orbit;
    if hands.zoom.is_finite() && ui.input(|i| i.multi_touch().is_some()) {
        // Two fingers do not turn.
    } else if shifting {
        hands.shift += moved / f64::from(response.rect.height().max(1.0));
    } else if response.dragged() {
        // The world follows the hand in orbit; the head follows it on foot.
        hands.turn = moved * if mode == Mode::Orbit { TURN } else { -TURN * 0.5 };
    }
    hands
}

/// Whether keys that walk are part of a shortcut, as S of Ctrl+S is: until all are let go, also when Ctrl is first.
fn shortcut(ui: &Ui, id: egui::Id) -> bool {
    let (command, walks) = ui
        .input(|input| (input.modifiers.command, WALK.iter().any(|(key, _)| input.key_down(*key))));
    ui.data_mut(|data| {
        let known = data.get_temp_mut_or_default::<bool>(id);
        *known = walks && (*known || command);
        *known
    })
}

/// What a key does beside walking.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// Play or pause.
    Play,
    /// A frame back.
    Back,
    /// A frame on.
    On,
    /// To the first moment.
    Start,
    /// Orbit.
    Orbit,
    /// Walk.
    Walk,
    /// Fly.
    Fly,
    /// Along the path.
    Path,
    /// See everything.
    Frame,
    /// Take back.
    Undo,
    /// Take again.
    Redo,
    /// Save the picture.
    Screenshot,
    /// Save the scene.
    Save,
    /// Open a file.
    Open,
    /// Show or hide the panel.
    Panel,
    /// Show or hide the keys.
    Help,
    /// Add the camera to the path.
    Record,
    /// Bookmark the camera.
    Bookmark,
    /// Close the window.
    Quit,
}

/// Keys and what they do, with a word for people.
pub const ACTIONS: [(Modifiers, Key, Action, &str); 22] = [
    (Modifiers::NONE, Key::Space, Action::Play, "play, pause"),
    (Modifiers::NONE, Key::Comma, Action::Back, "one frame back"),
    (Modifiers::NONE, Key::Period, Action::On, "one frame on"),
    (Modifiers::NONE, Key::Home, Action::Start, "to the first moment"),
    (Modifiers::NONE, Key::Num1, Action::Orbit, "orbit"),
    (Modifiers::NONE, Key::Num2, Action::Walk, "walk"),
    (Modifiers::NONE, Key::Num3, Action::Fly, "fly"),
    (Modifiers::NONE, Key::Num4, Action::Path, "along the recorded path"),
    (Modifiers::NONE, Key::F, Action::Frame, "see everything"),
    (Modifiers::NONE, Key::R, Action::Record, "add this view to the path"),
    (Modifiers::NONE, Key::B, Action::Bookmark, "bookmark this view"),
    (Modifiers::NONE, Key::P, Action::Screenshot, "save the picture"),
    (Modifiers::NONE, Key::M, Action::Panel, "show or hide the panel"),
    (Modifiers::NONE, Key::F1, Action::Help, "show or hide this list"),
    (Modifiers::NONE, Key::H, Action::Help, "show or hide this list"),
    (Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Z, Action::Redo, "redo"),
    (Modifiers::COMMAND, Key::Z, Action::Undo, "undo"),
    (Modifiers::COMMAND, Key::Y, Action::Redo, "redo"),
    (Modifiers::COMMAND, Key::S, Action::Save, "save the scene"),
    (Modifiers::COMMAND, Key::O, Action::Open, "open a file"),
    (Modifiers::COMMAND, Key::Q, Action::Quit, "close the window"),
    (Modifiers::NONE, Key::Questionmark, Action::Help, "show or hide this list"),
];

/// Actions of the keys that were pressed, unless a text is being written.
pub fn actions(ui: &Ui) -> Vec<Action> {
    if ui.ctx().egui_wants_keyboard_input() {
        return Vec::new();
    }
    let take = |input: &mut egui::InputState| {
        ACTIONS
            .iter()
            .filter(|(modifiers, key, ..)| input.consume_key(*modifiers, *key))
            .map(|(_, _, action, _)| *action)
            .collect()
    };
    ui.input_mut(take)
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{Event, RawInput};

    /// Steps of a frame in which keys are pressed or let go while Ctrl is held or not.
    fn step(context: &egui::Context, ctrl: bool, keys: &[(Key, bool)]) -> DVec3 {
        let modifiers = if ctrl { Modifiers::COMMAND } else { Modifiers::NONE };
        let event = |&(key, pressed): &(Key, bool)| Event::Key {
            key,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers,
        };
        let events = keys.iter().map(event).collect();
        let input = RawInput { modifiers, events, ..RawInput::default() };
        let mut step = DVec3::ZERO;
        let _ = context.run_ui(input, |ui| {
            let response = ui.allocate_response(egui::vec2(9.0, 9.0), egui::Sense::drag());
            step = hands(ui, &response, Mode::Walk).step;
        });
        step
    }

    #[test]
    fn a_shortcut_does_not_walk() {
        let context = egui::Context::default();
        assert_eq!(step(&context, false, &[(Key::S, true)]), DVec3::NEG_Z);
        assert_eq!(step(&context, false, &[(Key::S, false)]), DVec3::ZERO);
        assert_eq!(step(&context, true, &[(Key::S, true)]), DVec3::ZERO);
        // Ctrl is let go before S.
        assert_eq!(step(&context, false, &[]), DVec3::ZERO);
        assert_eq!(step(&context, false, &[(Key::S, false)]), DVec3::ZERO);
        assert_eq!(step(&context, false, &[(Key::S, true)]), DVec3::NEG_Z);
    }
}
