//! What is to be seen in the window: widgets by what screen readers are told, and its pixels.

use egui::accesskit::{Node, NodeId, Role, TreeUpdate};
use egui::{ColorImage, Context, Event, FullOutput, Pos2, RawInput, Rect, Ui, ViewportCommand};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

/// A widget.
#[derive(Debug, Clone)]
pub struct Widget {
    pub role: Role,
    /// What it is called.
    pub name: String,
    pub rect: Rect,
    pub enabled: bool,
}

/// What was seen last.
#[derive(Default)]
pub struct Seen {
    pub widgets: Vec<Widget>,
    /// Frames of the window.
    pub frames: u64,
    /// Whether pixels are wanted.
    pub look: bool,
    pub pixels: Option<Arc<ColorImage>>,
    pub copied: Option<String>,
}

/// Shared by the window and who drives it.
#[derive(Clone, Default)]
pub struct Eyes(pub Arc<Mutex<Seen>>);

impl egui::Plugin for Eyes {
    fn debug_name(&self) -> &'static str {
        "eyes"
    }

    fn on_begin_pass(&mut self, ui: &mut Ui) {
        let context = ui.ctx();
        context.enable_accesskit();
        let mut seen = self.0.lock().unwrap();
        if std::mem::take(&mut seen.look) {
            context.send_viewport_cmd(ViewportCommand::Screenshot(egui::UserData::default()));
        }
    }

    fn input_hook(&mut self, _: &Context, input: &mut RawInput) {
        for event in &input.events {
            if let Event::Screenshot { image, .. } = event {
                self.0.lock().unwrap().pixels = Some(Arc::clone(image));
            }
        }
    }

    fn output_hook(&mut self, context: &Context, output: &mut FullOutput) {
        let mut seen = self.0.lock().unwrap();
        seen.frames += 1;
        if let Some(update) = &output.platform_output.accesskit_update {
            seen.widgets = widgets(update, context.pixels_per_point());
        }
        for command in &output.platform_output.commands {
            if let egui::OutputCommand::CopyText(text) = command {
                seen.copied = Some(text.clone());
            }
        }
    }
}

/// Widgets with their places in pixels.
fn widgets(update: &TreeUpdate, scale: f32) -> Vec<Widget> {
    let nodes: BTreeMap<NodeId, &Node> =
        update.nodes.iter().map(|(id, node)| (*id, node)).collect();
    let text =
        |node: &Node| node.label().or_else(|| node.value()).map(str::to_owned).unwrap_or_default();
    let of = |node: &&Node| {
        let bounds = node.bounds()?;
        let mut name = node.label().map(str::to_owned).unwrap_or_default();
        for label in node.labelled_by() {
            name = nodes.get(label).map(|label| text(label)).unwrap_or(name);
        }
        Some(Widget {
            role: node.role(),
            name: if node.role() == Role::Label { text(node) } else { name },
            rect: Rect::from_min_max(
                Pos2::new(bounds.x0 as f32, bounds.y0 as f32) * scale,
                Pos2::new(bounds.x1 as f32, bounds.y1 as f32) * scale,
            ),
            enabled: !node.is_disabled(),
        })
    };
    update.nodes.iter().map(|(_, node)| node).filter_map(|node| of(&node)).collect()
}
