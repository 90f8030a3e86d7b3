//! A frame-time budget: moves `h`, and `d0` where it may, so that frames take as long as they should.

use super::{Reduction, Simplification};

/// Frames whose median is taken for the frame's time: up to three that stick out are not seen.
const WINDOW: usize = 7;
/// Change of the exponent of equation 2 for a frame that takes `e` times too long. The logarithm of
/// what is drawn falls by the mean of `-ln b` for each unit of the exponent, some ½ to 3 in forests:
/// a loop gain of 0.03 to 0.2 a frame, and a delay of the median and of a timer queried a few frames
/// late still leaves it far from ringing, which begins at 0.3.
const GAIN: f32 = 0.06;
/// The same for the logarithm of `d0`, which has up to thirteen units of effect at `h = 0.9`.
const D0_GAIN: f32 = 0.008;
/// Relative error of the time that is left alone.
const DEADBAND: f32 = 0.02;
/// Below this one answers are weaker: there, it may be noise.
const DOUBT: f32 = 0.2;

/// A controller of the level of detail by the time that frames take.
///
/// It keeps nothing but the last times: what it moves is in the [`Simplification`], so that it does
/// not wind up where the target cannot be met, and goes on from whatever a program sets. A pure
/// function of the times it is given: the clock is the caller's.
///
/// ```
/// use windfall_core::simplify::{FrameBudget, Simplification};
/// let (mut budget, mut simplification) = (FrameBudget::new(0.016), Simplification::default());
/// for _ in 0..60 {
///     // Frames that take 30 ms whatever is done: simplified as far as is allowed.
///     budget.frame(&mut simplification, 0.030);
/// }
/// assert!(simplification.h > 0.7);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct FrameBudget {
    /// Time that a frame should take, seconds, above 0.
    pub target: f32,
    /// Smallest and largest `h`, within `0..1`.
    pub h: (f32, f32),
    /// Largest change of `h` in a frame; that of `d0` is the same part of it.
    pub step: f32,
    /// Smallest and largest `d0`, metres; `None` leaves it as it is. It is moved only where `h` has
    /// come to its end, and back before `h` is, and only for [`Reduction::Distance`].
    pub d0: Option<(f32, f32)>,
    times: [f32; WINDOW],
    count: usize,
}

impl FrameBudget {
    /// A budget of `target` seconds a frame: `h` from 0 to 0.9 in steps of at most 0.01, `d0` fixed.
    pub fn new(target: f32) -> Self {
        Self { target, h: (0.0, 0.9), step: 0.01, d0: None, times: [0.0; WINDOW], count: 0 }
    }

    /// Takes note of a frame that took `seconds`, and moves `simplification` for the next one. A
    /// time that is not a positive number is not counted.
    pub fn frame(&mut self, simplification: &mut Simplification, seconds: f32) {
        if !(seconds > 0.0 && seconds.is_finite() && self.target > 0.0) {
            return;
        }
        self.times[self.count % WINDOW] = seconds;
        self.count += 1;
        let error = (self.median() / self.target).ln();
        if error.abs() < DEADBAND {
            return;
        }
        let error = error * (error.abs() / DOUBT).min(1.0);
        let (low, high) = (self.h.0.max(0.0), self.h.1.min(0.99));
        let h = simplification.h;
        if let (Some((near, far)), Reduction::Distance { d0 }) =
            (self.d0, &mut simplification.reduction)
            && if error > 0.0 { h >= high } else { *d0 < far }
        {
            *d0 = (*d0 * (-D0_GAIN * error).clamp(-self.step, self.step).exp()).clamp(near, far);
            return;
        }
        let exponent = (simplification.exponent() + GAIN * error).max(0.0);
        let wanted = if exponent > 0.0 { 0.5f32.powf(1.0 / exponent) } else { 0.0 };
        simplification.h = wanted.clamp(h - self.step, h + self.step).clamp(low, high);
    }

    fn median(&self) -> f32 {
        let mut known = self.times;
        let known = &mut known[..self.count.min(WINDOW)];
        known.sort_by(f32::total_cmp);
        known[known.len() / 2]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    /// Frames that take a fixed time and one for each leaf of trees at distances of 10 m to `far`,
    /// as many in each ring of equal area, measured `late` frames later.
    struct Plant {
        fixed: f32,
        all: f32,
        far: f32,
        noise: f32,
        late: usize,
        rng: Rng,
        waiting: Vec<f32>,
    }

    impl Plant {
        fn new(fixed: f32, all: f32) -> Self {
            let (far, noise, late) = (200.0, 0.0, 2);
            Self { fixed, all, far, noise, late, rng: Rng::new(7), waiting: Vec::new() }
        }

        fn true_time(&self, s: &Simplification) -> f32 {
            let Reduction::Distance { d0 } = s.reduction else { panic!() };
            let lambda = |i: i32| {
                let distance = (i as f32 / 100.0).sqrt() * self.far;
                (d0 / distance.max(10.0)).powi(2).min(1.0).powf(s.exponent())
            };
            self.fixed + self.all * (0..100).map(lambda).sum::<f32>() / 100.0
        }

        fn time(&mut self, s: &Simplification) -> f32 {
            let noise = 1.0 + self.noise * self.rng.normal().clamp(-3.0, 3.0);
            self.waiting.push(self.true_time(s) * noise);
            self.waiting[self.waiting.len().saturating_sub(1 + self.late)]
        }

        /// The course of `h` over some frames.
        fn run(
            &mut self,
            budget: &mut FrameBudget,
            s: &mut Simplification,
            frames: u32,
        ) -> Vec<f32> {
            let mut course = vec![s.h];
            for _ in 0..frames {
                let time = self.time(s);
                budget.frame(s, time);
                assert!((s.h - course[course.len() - 1]).abs() <= budget.step + 1e-6);
                assert!((0.0..=0.9).contains(&s.h));
                course.push(s.h);
            }
            course
        }
    }

    fn turns(course: &[f32]) -> usize {
        let steps = course.windows(2).map(|w| w[1] - w[0]).filter(|d| *d != 0.0);
        let signs: Vec<bool> = steps.map(|d| d > 0.0).collect();
        signs.windows(2).filter(|w| w[0] != w[1]).count()
    }

    fn start(h: f32) -> Simplification {
        Simplification { h, ..Simplification::default() }
    }

    #[test]
    fn the_target_is_met_from_either_side_without_swinging() {
        for (fixed, all) in [(0.002, 0.1), (0.002, 0.03), (0.008, 0.04), (0.001, 0.2)] {
            for h in [0.0, 0.3, 0.6, 0.9] {
                for late in [0, 3] {
                    let (mut budget, mut s) = (FrameBudget::new(0.016), start(h));
                    let mut plant = Plant { late, ..Plant::new(fixed, all) };
                    let course = plant.run(&mut budget, &mut s, 300);
                    let time = plant.true_time(&s);
                    let about = format!("{fixed} {all} from h {h}: {} after {time}", s.h);
                    assert!((time / 0.016 - 1.0).abs() < 0.05, "{about}");
                    assert!(turns(&course) <= 2, "{about}: {} turns", turns(&course));
                    // And stays.
                    assert!(turns(&plant.run(&mut budget, &mut s, 300)) <= 1, "{about}");
                }
            }
        }
    }

    #[test]
    fn noise_and_spikes_move_little() {
        let (mut budget, mut s) = (FrameBudget::new(0.016), start(0.5));
        let mut plant = Plant { noise: 0.1, ..Plant::new(0.002, 0.06) };
        plant.run(&mut budget, &mut s, 300);
        let course = plant.run(&mut budget, &mut s, 600);
        let low = course.iter().copied().fold(1.0, f32::min);
        let high = course.iter().copied().fold(0.0, f32::max);
        assert!(high - low < 0.03, "{low} to {high}");
        let time = plant.true_time(&s);
        assert!((time / 0.016 - 1.0).abs() < 0.05, "{time}");
        let (before, mut spiked) = (s.h, s);
        for i in 0..100 {
            budget.frame(&mut spiked, if i % 7 < 3 { 1.0 } else { 0.016 });
        }
        assert!((spiked.h - before).abs() < 0.01, "{before} {}", spiked.h);
    }

    #[test]
    fn a_new_scene_is_followed() {
        let (mut budget, mut s) = (FrameBudget::new(0.016), start(0.5));
        for (fixed, all, far) in [(0.002, 0.03, 200.0), (0.004, 0.1, 400.0), (0.001, 0.02, 100.0)] {
            let mut plant = Plant { far, ..Plant::new(fixed, all) };
            let course = plant.run(&mut budget, &mut s, 300);
            let time = plant.true_time(&s);
            assert!((time / 0.016 - 1.0).abs() < 0.05, "{all}: {time} at {}", s.h);
            assert!(turns(&course) <= 3, "{}", turns(&course));
        }
    }

    #[test]
    fn a_target_out_of_reach_leaves_no_memory() {
        let (mut budget, mut s) = (FrameBudget::new(0.016), start(0.5));
        Plant::new(0.02, 0.01).run(&mut budget, &mut s, 2000);
        assert_eq!(s.h, 0.9);
        // Once it can be met, h moves as soon as the median does.
        let mut light = Plant { late: 0, ..Plant::new(0.001, 0.01) };
        light.run(&mut budget, &mut s, 8);
        assert!(s.h < 0.9, "{}", s.h);
        light.run(&mut budget, &mut s, 300);
        assert_eq!(s.h, 0.0);
        assert_eq!(light.true_time(&s), 0.011);
    }

    #[test]
    fn d0_gives_way_after_h_and_comes_back_before_it() {
        let near = |s: &Simplification| match s.reduction {
            Reduction::Distance { d0 } => d0,
            Reduction::ProjectedArea { .. } => panic!(),
        };
        let (mut budget, mut s) = (FrameBudget::new(0.016), start(0.5));
        budget.d0 = Some((5.0, 30.0));
        let mut heavy = Plant { far: 60.0, ..Plant::new(0.001, 0.1) };
        heavy.run(&mut budget, &mut s, 600);
        let time = heavy.true_time(&s);
        assert!((time / 0.016 - 1.0).abs() < 0.05, "{time} {s:?}");
        assert!(s.h == 0.9 && near(&s) < 29.0, "{s:?}");
        let mut light = Plant { far: 60.0, ..Plant::new(0.001, 0.01) };
        while near(&s) < 30.0 {
            light.run(&mut budget, &mut s, 1);
            assert_eq!(s.h, 0.9);
        }
        light.run(&mut budget, &mut s, 300);
        assert_eq!(s.h, 0.0);
    }

    #[test]
    fn poison_is_not_counted() {
        let (mut budget, mut s) = (FrameBudget::new(0.016), start(0.5));
        for time in [f32::NAN, f32::INFINITY, 0.0, -1.0] {
            budget.frame(&mut s, time);
        }
        assert_eq!((s, &budget), (start(0.5), &FrameBudget::new(0.016)));
        let mut never = FrameBudget::new(f32::NAN);
        never.frame(&mut s, 0.01);
        assert_eq!(s, start(0.5));
    }
}
