//! What the viewer knows, without a window: settings, their undo, camera, clock, links.

pub mod camera;
pub mod clock;
pub mod command;
pub mod framing;
pub mod history;
pub mod link;
pub mod settings;
