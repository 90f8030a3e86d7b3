//! What a viewer does at a frame's begin and end: what came from the GPU, what is known outside, when the next frame is.

use super::Viewer;
use crate::picture::Picture;
use eframe::egui_wgpu::RenderState;
use std::sync::{Arc, PoisonError};
use std::time::Duration;

impl Viewer {
    /// Takes what has come back from the GPU.
    pub(super) fn collect(&mut self, render: &RenderState) {
        let Some(picture) = &mut self.picture else { return };
        let came = picture.collect(render);
        if let Some(seconds) = came.took {
            self.pace.took(seconds);
        }
        if let Some(time) = came.counted {
            self.statistics.count(time, &picture.latest);
            self.occlusion.counted(&picture.latest.trees);
        }
        if let Some(pixels) = came.pixels
            && !self.screenshot.is_empty()
        {
            self.screenshot.remove(0)(pixels);
        }
    }

    pub(super) fn finish(&mut self, context: &egui::Context) {
        // The last one that was begun may not be done.
        let begun = self.picture.as_ref().map_or(0, |picture| picture.frames);
        let done = begun - u64::from(self.is_busy());
        if self.first.is_none() && done > 0 {
            self.first = Some(self.started.elapsed());
            self.report("first picture");
        }
        if !self.quits && self.frames.is_some_and(|frames| done >= frames) {
            self.report("last picture");
            self.quits = true;
        }
        if self.quits {
            context.send_viewport_cmd(egui::ViewportCommand::Close);
        }
        self.publish(context);
        let unfinished = self.drawn.as_ref().is_some_and(|drawn| !drawn.full);
        let waiting =
            self.job.is_some() || self.is_busy() || unfinished || !self.screenshot.is_empty();
        if self.clock.playing || self.frames.is_some() || self.world.is_none() {
            context.request_repaint();
        } else if waiting {
            context.request_repaint_after(Duration::from_millis(15));
        } else {
            // For files that change on disk, and for what is asked from outside.
            context.request_repaint_after(Duration::from_millis(500));
        }
    }

    fn publish(&mut self, context: &egui::Context) {
        let status = Arc::clone(&self.status);
        let mut status = status.lock().unwrap_or_else(PoisonError::into_inner);
        status.context.get_or_insert_with(|| context.clone());
        status.loading = self.job.is_some() || self.picture.is_none();
        status.pictures = self.picture.as_ref().map_or(0, |picture| picture.frames);
        status.time = self.clock.time;
        // While time runs, few times a second are enough.
        if !self.clock.playing || self.linked.elapsed() > Duration::from_millis(250) {
            status.link = self.link();
            self.linked = web_time::Instant::now();
        }
    }

    fn is_busy(&self) -> bool {
        self.picture.as_ref().is_some_and(Picture::is_busy)
    }

    fn report(&self, what: &str) {
        if !self.timings {
            return;
        }
        let drawn = self.picture.as_ref().map_or(0, |picture| picture.frames);
        let size = self.picture.as_ref().and_then(Picture::size).unwrap_or_default();
        let fps = self.statistics.rate();
        eprintln!(
            "{what}: {:.2} s after the start; {drawn} pictures of {}x{}; {fps:.1} pictures/s; budget {:.0} ms, given up \
             {:.0} %; longest from frame to frame of the window while loading {:.0} ms",
            self.started.elapsed().as_secs_f64(),
            size.0,
            size.1,
            self.pace.milliseconds(),
            self.pace.saving() * 100.0,
            self.statistics.slowest_loading * 1e3,
        );
        let passes = self.picture.iter().flat_map(|picture| &picture.passes);
        let passes: Vec<String> = passes.map(|(name, ms)| format!("{name} {ms:.1}")).collect();
        if !passes.is_empty() {
            eprintln!("  GPU milliseconds of a picture: {}", passes.join(", "));
        }
    }
}
