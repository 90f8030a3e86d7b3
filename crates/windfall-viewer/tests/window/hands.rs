//! Mouse and keys of the X server, through xdotool.

use egui::Pos2;
use std::process::Command;

/// The window's identifier.
pub struct Hands {
    window: String,
}

fn xdotool(words: &[&str]) -> String {
    let output = Command::new("xdotool").args(words).output().expect("xdotool runs");
    assert!(output.status.success(), "xdotool {words:?}: {output:?}");
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

#[expect(clippy::unused_self, reason = "hands are on a window before they act")]
impl Hands {
    /// On the window of this title, which has the keyboard from now on.
    pub fn on(title: &str) -> Self {
        let found = xdotool(&["search", "--sync", "--onlyvisible", "--name", title]);
        let window = found.lines().next().expect("a window").to_owned();
        // There is no window manager that would do it.
        xdotool(&["windowfocus", "--sync", &window]);
        Self { window }
    }

    /// Presses keys together, as `ctrl+s`.
    pub fn key(&self, keys: &str) {
        xdotool(&["key", keys]);
    }

    pub fn key_down(&self, key: &str) {
        xdotool(&["keydown", key]);
    }

    pub fn key_up(&self, key: &str) {
        xdotool(&["keyup", key]);
    }

    pub fn write(&self, text: &str) {
        xdotool(&["type", "--delay", "8", text]);
    }

    pub fn point(&self, at: Pos2) {
        xdotool(&["mousemove", &at.x.round().to_string(), &at.y.round().to_string()]);
    }

    /// Presses a button: 1 left, 3 right; 4 turns the wheel away from the hand.
    pub fn press(&self, button: &str) {
        xdotool(&["mousedown", button]);
    }

    pub fn release(&self, button: &str) {
        xdotool(&["mouseup", button]);
    }

    pub fn resize(&self, width: u32, height: u32) {
        xdotool(&["windowsize", &self.window, &width.to_string(), &height.to_string()]);
    }
}
