//! What goes on: rates and counts over time.

use std::collections::VecDeque;
use web_time::Instant;
use windfall_scenes::StageCounts;

/// Frames that are kept.
const KEPT: usize = 600;

/// Counts of a moment.
#[derive(Debug, Clone, Copy)]
pub struct Count {
    /// The moment, seconds.
    pub time: f64,
    /// What was there and what was drawn.
    pub counts: StageCounts,
}

/// What is plotted.
#[derive(Debug, Default)]
pub struct Statistics {
    pictures: VecDeque<Instant>,
    /// Milliseconds between pictures.
    pub intervals: VecDeque<f64>,
    /// Counts, by moment of the forest.
    pub counts: VecDeque<Count>,
    /// The longest from one frame of the window to the next while it was loading, seconds.
    pub slowest_loading: f64,
    /// When the window's last frame was, if it is loading.
    pub last_loading: Option<Instant>,
}

impl Statistics {
    /// A picture was drawn.
    pub fn drew(&mut self) {
        let now = Instant::now();
        if let Some(last) = self.pictures.back() {
            let interval = now.duration_since(*last).as_secs_f64() * 1e3;
            // A camera and a clock that stand draw nothing.
            if interval < 5e3 {
                push(&mut self.intervals, interval);
            }
        }
        push(&mut self.pictures, now);
    }

    /// The window has a frame while it is loading.
    pub fn loads(&mut self) {
        let now = Instant::now();
        if let Some(last) = self.last_loading.replace(now) {
            self.slowest_loading = self.slowest_loading.max(now.duration_since(last).as_secs_f64());
        }
    }

    /// Pictures per second, of the last ones.
    pub fn rate(&self) -> f64 {
        let last: Vec<f64> = self.intervals.iter().rev().take(20).copied().collect();
        let sum: f64 = last.iter().sum();
        if sum > 0.0 { last.len() as f64 * 1e3 / sum } else { 0.0 }
    }

    /// Counts of a moment have come. Time that ran back takes back what was counted later.
    pub fn count(&mut self, time: f64, counts: &StageCounts) {
        self.counts.retain(|count| count.time < time);
        push(&mut self.counts, Count { time, counts: *counts });
    }
}

fn push<T>(list: &mut VecDeque<T>, item: T) {
    if list.len() == KEPT {
        list.pop_front();
    }
    list.push_back(item);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_of_rising_moments() {
        let mut statistics = Statistics::default();
        for time in [1.0, 2.0, 3.0, 1.5] {
            statistics.count(time, &StageCounts::default());
        }
        let times: Vec<f64> = statistics.counts.iter().map(|c| c.time).collect();
        assert_eq!(times, [1.0, 1.5]);
        for i in 0..2000 {
            statistics.count(f64::from(i) + 10.0, &StageCounts::default());
        }
        assert_eq!(statistics.counts.len(), KEPT);
    }
}
