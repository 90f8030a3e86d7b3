//! What goes wrong on the GPU, said to the user.

use super::Viewer;
use std::sync::{Arc, Mutex, PoisonError};

impl Viewer {
    /// Takes note of what goes wrong on the GPU, in place of a crash: the scene can still be saved.
    pub(super) fn listen(&self, device: &wgpu::Device) {
        let take = |complaints: &Arc<Mutex<Vec<String>>>, text: String| {
            let mut complaints = complaints.lock().unwrap_or_else(PoisonError::into_inner);
            // What goes wrong in one frame goes wrong in each.
            if complaints.len() < 4 && !complaints.contains(&text) {
                complaints.push(text);
            }
        };
        let of_errors = Arc::clone(&self.complaints);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            take(&of_errors, format!("the GPU refuses: {error}"));
        }));
        let of_loss = Arc::clone(&self.complaints);
        device.set_device_lost_callback(move |reason, why| {
            if reason != wgpu::DeviceLostReason::Destroyed {
                let text =
                    format!("the GPU is lost ({why}): save the scene and start the viewer anew");
                take(&of_loss, text);
            }
        });
    }

    /// Says what the GPU complained of, each thing once.
    pub(super) fn complain(&mut self) {
        let complaints = self.complaints.lock().unwrap_or_else(PoisonError::into_inner).clone();
        for text in complaints.into_iter().skip(self.complained) {
            self.complained += 1;
            self.say(true, text);
        }
    }
}
