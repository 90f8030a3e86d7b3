//! Mouse and keys of the X server, through xdotool.

use egui::Pos2;
use std::process::Command;
use std::time::Duration;

/// The window's identifier.
pub struct Hands {
    window: String,
}

fn xdotool(words: &[&str]) -> String {
    let output = Command::new("xdotool").args(words).output().expect("xdotool runs");
    assert!(output.status.success(), "xdotool {words:?}: {output:?}");
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

fn rest() {
    std::thread::sleep(Duration::from_millis(60));
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
        rest();
    }

    /// Holds a key down.
    pub fn hold(&self, key: &str, time: Duration) {
        xdotool(&["keydown", key]);
        std::thread::sleep(time);
        xdotool(&["keyup", key]);
        rest();
    }

    pub fn write(&self, text: &str) {
        xdotool(&["type", "--delay", "8", text]);
        rest();
    }

    pub fn point(&self, at: Pos2) {
        xdotool(&["mousemove", &at.x.round().to_string(), &at.y.round().to_string()]);
        rest();
    }

    pub fn click(&self, at: Pos2) {
        self.point(at);
        xdotool(&["mousedown", "1"]);
        // A finger is not faster.
        rest();
        xdotool(&["mouseup", "1"]);
        rest();
    }

    /// Drags with a button: 1 left, 3 right.
    pub fn drag(&self, button: &str, from: Pos2, to: Pos2) {
        self.point(from);
        xdotool(&["mousedown", button]);
        rest();
        self.point(from.lerp(to, 0.5));
        self.point(to);
        xdotool(&["mouseup", button]);
        rest();
    }

    /// Turns the wheel: 4 away from the hand, 5 towards it.
    pub fn wheel(&self, button: &str, at: Pos2) {
        self.point(at);
        xdotool(&["click", "--repeat", "3", button]);
        rest();
    }

    pub fn resize(&self, width: u32, height: u32) {
        xdotool(&["windowsize", &self.window, &width.to_string(), &height.to_string()]);
    }
}
