//! The moment that is shown.

/// Largest step of one frame, seconds of the wall: a frame that hung does not make time jump.
const LARGEST_STEP: f64 = 0.25;

/// A clock that runs, stands, and goes anywhere.
#[derive(Debug, Clone, PartialEq)]
pub struct Clock {
    /// The moment, seconds.
    pub time: f64,
    /// Whether it runs.
    pub playing: bool,
    /// Seconds of the forest in a second of the wall; below 0 it runs backwards.
    pub speed: f64,
    /// The end of the scrubber, seconds; it begins at 0.
    pub end: f64,
    /// Steps of a second.
    pub fps: f64,
}

impl Clock {
    /// Stands at a moment of a film of `frames` at `fps`, or of five minutes where that is longer.
    pub fn new(time: f64, frames: u32, fps: f32) -> Self {
        let fps = f64::from(fps);
        Self { time, playing: false, speed: 1.0, end: (f64::from(frames) / fps).max(300.0), fps }
    }

    /// Goes on by `elapsed` seconds of the wall. It stops where it reaches 0 backwards.
    pub fn advance(&mut self, elapsed: f64) {
        if !self.playing {
            return;
        }
        self.time += elapsed.clamp(0.0, LARGEST_STEP) * self.speed;
        if self.time <= 0.0 && self.speed < 0.0 {
            (self.time, self.playing) = (0.0, false);
        }
        self.end = self.end.max(self.time);
    }

    /// Stands still, `frames` on or back.
    pub fn step(&mut self, frames: f64) {
        self.playing = false;
        self.time = (((self.time * self.fps).round() + frames) / self.fps).max(0.0);
    }

    /// Goes to a moment.
    pub fn seek(&mut self, time: f64) {
        if time.is_finite() {
            self.time = time.clamp(0.0, 1e7);
            self.end = self.end.max(self.time);
        }
    }
}

/// A moment for people: `1:05.20`.
pub fn text(time: f64) -> String {
    let minutes = (time / 60.0).floor();
    format!("{minutes:.0}:{:05.2}", time - minutes * 60.0)
}

/// The moment that a person wrote: `1:05.2`, or seconds.
pub fn read(text: &str) -> Option<f64> {
    let text = text.trim();
    let (minutes, seconds) = text.rsplit_once(':').unwrap_or(("0", text));
    Some(minutes.parse::<f64>().ok()? * 60.0 + seconds.parse::<f64>().ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_runs_both_ways_and_steps_to_whole_frames() {
        let mut clock = Clock::new(1.0, 30, 10.0);
        clock.advance(0.1);
        assert_eq!(clock.time, 1.0);
        (clock.playing, clock.speed) = (true, 2.0);
        clock.advance(0.1);
        assert!((clock.time - 1.2).abs() < 1e-12);
        clock.speed = -100.0;
        clock.advance(9.0);
        assert_eq!((clock.time, clock.playing), (0.0, false));
        clock.seek(0.234);
        clock.step(1.0);
        assert!((clock.time - 0.3).abs() < 1e-12);
        clock.step(-9.0);
        assert_eq!(clock.time, 0.0);
        clock.seek(f64::NAN);
        assert_eq!(clock.time, 0.0);
        clock.seek(900.0);
        assert_eq!(clock.end, 900.0);
        assert_eq!(text(65.2), "1:05.20");
        assert_eq!((read("1:05.2"), read(" 7 "), read("x:1")), (Some(65.2), Some(7.0), None));
    }
}
