//! How much a picture may cost while things move.

use eframe::egui_wgpu::RenderState;
use windfall_gpu::{FrameBudget, View};

/// Time that a picture is to take at most, milliseconds, if the user sets no other: 25 pictures a second.
pub const USUAL: f32 = 40.0;

/// Pixels for each of the window's, along a side, where all else is given up.
const COARSE: f32 = 0.6;

/// Holds the time of pictures. Each that is drawn with something given up is drawn again once all stands still.
pub struct Pace {
    budget: FrameBudget,
    /// Whether the budget is used.
    on: bool,
    /// Whether pictures are drawn by the processor: full ones take seconds, in which the window would hang.
    software: bool,
    /// Whether all is given up and it is not enough: then there are fewer pixels than the window has.
    coarse: bool,
    /// Pictures of this world; the first compiles pipelines, and tells nothing.
    drawn: u32,
}

/// What a picture is drawn for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// To be seen while things move.
    Moving,
    /// To be seen when they have just come to rest.
    Still,
    /// To be kept, or seen for long.
    Kept,
}

impl Pace {
    /// A budget of `milliseconds` a picture; 0 gives up nothing.
    pub fn new(milliseconds: f32) -> Self {
        let mut pace = Self {
            budget: FrameBudget::new(USUAL * 1e-3),
            on: true,
            software: false,
            coarse: false,
            drawn: 0,
        };
        pace.set_milliseconds(milliseconds);
        pace
    }

    /// Starts on a device: a software one with nearly everything given up, as it will need.
    pub fn start(&mut self, render: &RenderState) {
        self.software = render.adapter.get_info().device_type == wgpu::DeviceType::Cpu;
        if self.software {
            for _ in 0..4 {
                self.budget.frame(self.budget.target * 20.0);
            }
            self.coarse = true;
        }
    }

    /// Whether pictures are drawn by the processor.
    pub fn is_software(&self) -> bool {
        self.software
    }

    /// Another world is shown.
    pub fn forget(&mut self) {
        self.drawn = 0;
    }

    /// The budget, milliseconds; 0 if there is none.
    pub fn milliseconds(&self) -> f32 {
        if self.on { self.budget.target * 1e3 } else { 0.0 }
    }

    /// Sets the budget, milliseconds; 0 gives up nothing.
    pub fn set_milliseconds(&mut self, milliseconds: f32) {
        self.on = milliseconds > 0.0;
        if self.on {
            self.budget.target = milliseconds * 1e-3;
        }
    }

    /// How much of what may be given up is, 0 to 1.
    pub fn saving(&self) -> f32 {
        if self.on { self.budget.saving() } else { 0.0 }
    }

    /// The view that is drawn, and whether it is in full.
    pub fn apply(&self, view: &mut View, purpose: Purpose) -> bool {
        let wanted = view.clone();
        match purpose {
            _ if !self.on => {}
            Purpose::Kept => {}
            Purpose::Still if !self.software => {}
            Purpose::Still => {
                self.budget.apply(view);
                view.shadow_period = wanted.shadow_period;
            }
            Purpose::Moving => self.budget.apply(view),
        }
        *view == wanted
    }

    /// Pixels of a picture for the window's `size`.
    pub fn pixels(&self, size: (u32, u32), purpose: Purpose) -> (u32, u32) {
        if self.on && self.coarse && self.software && purpose == Purpose::Moving {
            let part = |side: u32| (side as f32 * COARSE).ceil() as u32;
            (part(size.0), part(size.1))
        } else {
            size
        }
    }

    /// A picture that was drawn to be seen while things move took so long, seconds.
    pub fn took(&mut self, seconds: f32) {
        self.drawn += 1;
        if self.on && self.drawn > 1 {
            self.budget.frame(seconds);
            // Between the two, as it is: a change back and forth would be seen.
            let saving = self.budget.saving();
            self.coarse = saving >= 1.0 || self.coarse && saving > 0.85;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use windfall_gpu::Camera;

    fn slow() -> (Pace, View) {
        let mut pace = Pace::new(USUAL);
        for _ in 0..10 {
            pace.took(1.0);
        }
        (pace, View::new(Camera::look_at(DVec3::ZERO, DVec3::X, 1.0, 0.1)))
    }

    #[test]
    fn what_moves_costs_less_and_what_stands_or_is_kept_is_in_full() {
        let (pace, wanted) = slow();
        let drawn = |purpose| {
            let mut view = wanted.clone();
            let full = pace.apply(&mut view, purpose);
            (view, full)
        };
        let (moving, full) = drawn(Purpose::Moving);
        assert!(!full && moving.quality.resolution < 1.0);
        assert!(drawn(Purpose::Still) == (wanted.clone(), true));
        assert!(drawn(Purpose::Kept) == (wanted.clone(), true));
    }

    #[test]
    fn without_a_budget_all_is_in_full() {
        let (mut pace, wanted) = slow();
        pace.set_milliseconds(0.0);
        assert_eq!((pace.milliseconds(), pace.saving()), (0.0, 0.0));
        let mut view = wanted.clone();
        assert!(pace.apply(&mut view, Purpose::Moving) && view == wanted);
        pace.set_milliseconds(100.0);
        assert_eq!(pace.milliseconds(), 100.0);
    }

    #[test]
    fn the_first_picture_of_a_world_tells_nothing() {
        let mut pace = Pace::new(USUAL);
        pace.took(9.0);
        assert_eq!(pace.saving(), 0.0);
        pace.took(9.0);
        assert!(pace.saving() > 0.0);
    }

    #[test]
    fn software_that_stands_still_has_new_shadows_before_a_full_picture() {
        let (mut pace, wanted) = slow();
        pace.software = true;
        let mut view = wanted.clone();
        assert!(!pace.apply(&mut view, Purpose::Still));
        assert!(view.quality.resolution < 1.0 && view.shadow_period == 1);
        let mut view = wanted.clone();
        assert!(pace.apply(&mut view, Purpose::Kept) && view == wanted);
        // With everything given up, and as slow as before, there are fewer pixels while things move.
        assert_eq!(pace.pixels((100, 50), Purpose::Moving), (61, 31));
        assert_eq!(pace.pixels((100, 50), Purpose::Still), (100, 50));
        for _ in 0..200 {
            pace.took(0.001);
        }
        assert_eq!(pace.pixels((100, 50), Purpose::Moving), (100, 50));
    }
}
