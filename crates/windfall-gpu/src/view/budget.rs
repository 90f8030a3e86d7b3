//! A frame-time budget: what a view gives up so that frames take as long as they should.

use crate::view::description::View;
use windfall_core::simplify::{Reduction, Simplification};

/// Frames whose mean is taken for the time of a frame: maps of shadows have their turns within as many.
const WINDOW: usize = 8;
/// Frames after which the mean is believed where the time is nearly right.
const FEW: usize = 4;
/// Logarithm of the time over the target from which on one frame is enough to act.
const FAR_OFF: f32 = 0.5;
/// Change of the saving for a frame that takes `e` times too long: all of what there is to save makes frames some 10
/// to 50 times shorter, so that this is well below what would ring.
const GAIN: f32 = 0.15;
/// The same where the time is nearly right.
const FINE_GAIN: f32 = 0.05;
/// Largest change in a frame.
const STEP: f32 = 0.3;
/// Relative error that is left alone.
const DEADBAND: f32 = 0.04;

/// Savings at which one thing has been given up and the next begins: shadows in turns, half of the resolution, leaves and
/// wood, more of the resolution, effects.
const SHADOWS: f32 = 0.08;
const RESOLUTION: f32 = 0.3;
const DETAIL: f32 = 0.85;
const COARSE: f32 = 0.95;
/// Steps in which the trees of shadow maps are simplified.
const SHADOW_STEPS: f32 = 4.0;

/// Holds a time per frame by what a view costs, in the order in which it harms the picture least: shadow maps are drawn
/// in turns, fewer pixels are shaded, trees are simplified (`h`, `d0`, the growth of leaves, outlines, wood), then relief and grass go.
///
/// It changes a copy of the view ([`FrameBudget::apply`]): what the program sets is what is drawn where time allows. A
/// pure function of the times it is given: the clock is the caller's, GPU time where there is any, or the time from
/// frame to frame.
///
/// ```
/// # use windfall_gpu::{Camera, FrameBudget, View};
/// # use glam::DVec3;
/// let mut budget = FrameBudget::new(0.016);
/// let wanted = View::new(Camera::look_at(DVec3::ZERO, DVec3::X, 0.9, 0.1));
/// for _ in 0..60 {
///     let mut view = wanted.clone();
///     budget.apply(&mut view);
///     // Draw the view; it took 30 ms whatever was saved.
///     budget.frame(0.030);
/// }
/// assert!(budget.saving() > 0.5);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct FrameBudget {
    /// Time that a frame should take, seconds, above 0.
    pub target: f32,
    saving: f32,
    times: [f32; WINDOW],
    count: usize,
}

impl FrameBudget {
    /// A budget of `target` seconds a frame, with nothing saved yet.
    pub fn new(target: f32) -> Self {
        Self { target, saving: 0.0, times: [0.0; WINDOW], count: 0 }
    }

    /// How much of what may be given up is, 0 to 1.
    pub fn saving(&self) -> f32 {
        self.saving
    }

    /// Takes note of a frame that took `seconds`. A time that is not a positive number is not counted.
    pub fn frame(&mut self, seconds: f32) {
        if !(seconds > 0.0 && seconds.is_finite() && self.target > 0.0) {
            return;
        }
        self.times[self.count % WINDOW] = seconds;
        self.count += 1;
        let known = self.count.min(WINDOW);
        let mean = self.times[..known].iter().sum::<f32>() / known as f32;
        let error = (mean / self.target).ln();
        if error.abs() > FAR_OFF {
            self.saving = (self.saving + (GAIN * error).clamp(-STEP, STEP)).clamp(0.0, 1.0);
            // What was measured before tells nothing of what comes.
            self.count = 0;
        } else if known >= FEW && error.abs() > DEADBAND {
            let step = FINE_GAIN * error * (error.abs() / FAR_OFF).max(0.25);
            self.saving = (self.saving + step).clamp(0.0, 1.0);
        }
    }

    /// Changes a view to one that costs so much less. With nothing saved it stays as it is.
    pub fn apply(&self, view: &mut View) {
        let s = self.saving;
        // How far a part of the way has been gone.
        let part = |from: f32, to: f32| ((s - from) / (to - from)).clamp(0.0, 1.0);
        let turns = (4.0 * part(0.0, SHADOWS)).exp2() as u32;
        view.shadow_period = view.shadow_period.max(turns);
        view.quality.resolution = view.quality.drawn_resolution()
            * 0.5f32.powf(part(SHADOWS, RESOLUTION))
            * 0.6f32.powf(part(DETAIL, COARSE));
        let fewer = part(RESOLUTION, DETAIL);
        if fewer > 0.0 {
            simplify(&mut view.detail, fewer);
            // In steps: maps of another detail are all drawn anew.
            simplify(&mut view.shadow_detail, (SHADOW_STEPS * fewer).ceil() / SHADOW_STEPS);
        }
        let effects = part(COARSE, 1.0);
        view.quality.bark_relief &= effects < 0.25;
        view.quality.grass &= effects < 0.5;
        view.quality.ground_detail &= effects < 0.75;
    }
}

/// Simplifies trees more, 0 not at all to 1 as far as is sensible.
fn simplify(detail: &mut Simplification, part: f32) {
    detail.h += (0.9 - detail.h).max(0.0) * part;
    if let Reduction::Distance { d0 } = &mut detail.reduction {
        *d0 *= 0.1f32.powf(part);
    }
    detail.wood_pixels = detail.wood_pixels.max(0.25) * 6.0f32.powf(part);
    detail.leaf_pixels = detail.leaf_pixels.max(4.0) * 6.0f32.powf(part);
    // Fewer leaves need larger ones.
    detail.growth.factor *= 2.0f32.powf(part);
    detail.growth.pixels *= 2.0f32.powf(part);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::camera::Camera;
    use crate::view::quality::Quality;
    use glam::DVec3;
    use windfall_core::rng::Rng;

    /// Frames that take a fixed time and one that falls with what is saved, the logarithm evenly; maps have their
    /// turns in every fourth.
    struct Plant {
        fixed: f32,
        all: f32,
        range: f32,
        noise: f32,
        rng: Rng,
        frame: u32,
    }

    impl Plant {
        fn new(fixed: f32, all: f32, range: f32) -> Self {
            Self { fixed, all, range, noise: 0.0, rng: Rng::new(3), frame: 0 }
        }

        fn time(&self, saving: f32) -> f32 {
            self.fixed + self.all * self.range.powf(-saving)
        }

        fn run(&mut self, budget: &mut FrameBudget, frames: u32) -> Vec<f32> {
            let course = (0..frames).map(|_| {
                self.frame += 1;
                let turn = if self.frame.is_multiple_of(4) { 1.3 } else { 0.9 };
                let noise = 1.0 + self.noise * self.rng.normal().clamp(-3.0, 3.0);
                budget.frame(self.time(budget.saving()) * turn * noise);
                budget.saving()
            });
            course.collect()
        }
    }

    #[test]
    fn the_target_is_met_within_a_few_frames_from_far_away_and_kept() {
        for (fixed, all, range) in
            [(0.01, 1.3, 30.0), (0.02, 0.3, 10.0), (0.0, 2.5, 50.0), (0.03, 0.6, 20.0)]
        {
            let mut plant = Plant::new(fixed, all, range);
            let mut budget = FrameBudget::new(0.1);
            plant.run(&mut budget, 12);
            let near = plant.time(budget.saving()) / 0.1;
            assert!((0.6..1.7).contains(&near), "{all}: {near} after twelve frames");
            plant.run(&mut budget, 60);
            let course = plant.run(&mut budget, 100);
            let time = plant.time(budget.saving()) / 0.1;
            assert!((0.85..1.15).contains(&time), "{all}: {time}");
            let (low, high) =
                course.iter().fold((1.0f32, 0.0f32), |(a, b), s| (a.min(*s), b.max(*s)));
            assert!(high - low < 0.02, "{all}: saving goes from {low} to {high}");
        }
    }

    #[test]
    fn noise_moves_little_and_a_lighter_scene_gets_everything_back() {
        let mut plant = Plant { noise: 0.1, ..Plant::new(0.01, 0.8, 30.0) };
        let mut budget = FrameBudget::new(0.1);
        plant.run(&mut budget, 200);
        let course = plant.run(&mut budget, 300);
        let (low, high) = course.iter().fold((1.0f32, 0.0f32), |(a, b), s| (a.min(*s), b.max(*s)));
        assert!(high - low < 0.06, "saving goes from {low} to {high}");
        Plant::new(0.001, 0.02, 30.0).run(&mut budget, 60);
        assert_eq!(budget.saving(), 0.0);
    }

    #[test]
    fn what_is_given_up_only_grows_and_nothing_is_at_first() {
        let wanted = View {
            quality: Quality::HIGH,
            ..View::new(Camera::look_at(DVec3::ZERO, DVec3::X, 1.0, 0.1))
        };
        let mut view = wanted.clone();
        FrameBudget::new(0.1).apply(&mut view);
        assert!(view == wanted);
        let mut before = wanted.clone();
        for i in 0..=100 {
            let budget = FrameBudget { saving: i as f32 / 100.0, ..FrameBudget::new(0.1) };
            let mut view = wanted.clone();
            budget.apply(&mut view);
            let (a, b) = (&before, &view);
            assert!(b.shadow_period >= a.shadow_period && b.detail.h >= a.detail.h);
            assert!(b.quality.resolution <= a.quality.resolution);
            assert!(b.detail.wood_pixels >= a.detail.wood_pixels);
            assert!(b.detail.growth.pixels >= a.detail.growth.pixels);
            // No step that is seen: but for the effects at the end.
            assert!(b.quality.resolution > 0.95 * a.quality.resolution, "{i}");
            assert!(b.detail.h - a.detail.h < 0.02, "{i}");
            before = view;
        }
        let off = before.quality;
        assert!(!(off.grass || off.bark_relief || off.ground_detail) && off.resolution >= 0.25);
    }

    #[test]
    fn what_is_no_time_is_not_counted() {
        let mut budget = FrameBudget::new(0.1);
        for time in [f32::NAN, f32::INFINITY, 0.0, -1.0] {
            budget.frame(time);
        }
        assert_eq!(budget, FrameBudget::new(0.1));
        let mut never = FrameBudget::new(f32::NAN);
        never.frame(0.01);
        assert_eq!(never.saving(), 0.0);
    }
}
