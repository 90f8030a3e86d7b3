//! Wind whose displacement is known in closed form.
//!
//! A steady horizontal wind with gusts, each a wave that travels over the land with the wind. A gust
//! repeats a whole number of times in [`Wind::PERIOD`], so that the whole wind does, and a clock of
//! any size is reduced to it without loss before single precision sees it.

use crate::rng::Rng;
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// One wave of gusts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gust {
    /// Amplitude of the velocity along X and Z, metres per second.
    pub amplitude: Vec2,
    /// Waves in [`Wind::PERIOD`], at least 1.
    pub cycles: u32,
    /// Phase at time 0 at the origin, in turns.
    pub phase: f32,
}

/// A horizontal wind: steady part and gusts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wind {
    /// Steady velocity along X and Z, metres per second.
    pub mean: Vec2,
    /// The gusts.
    pub gusts: [Gust; 4],
    /// Unit direction in which gusts travel.
    pub travel: Vec2,
    /// Seconds by which gusts come later for each metre along `travel`.
    pub slowness: f32,
}

impl Default for Wind {
    fn default() -> Self {
        Self::calm()
    }
}

impl Wind {
    /// Time after which the wind repeats, seconds.
    pub const PERIOD: f64 = 1024.0;

    /// No wind.
    pub fn calm() -> Self {
        Self::new(0.0, 0.0, 0.0, 0)
    }

    /// Wind of `speed` metres per second (safe: 0 to 15) that blows towards `heading`, radians from
    /// +X towards +Z. `gustiness` is the largest gust over the speed: 0 is steady, 0.5 usual, 1 lets
    /// it drop to a calm now and then.
    pub fn new(speed: f32, heading: f32, gustiness: f32, seed: u32) -> Self {
        // Periods of about 28, 15, 7.6 and 3.9 s: primes, so that they do not beat in unison.
        const CYCLES: [u32; 4] = [37, 67, 137, 263];
        const SHARE: [f32; 4] = [0.4, 0.3, 0.2, 0.1];
        let mut rng = Rng::new(seed).stream(0x77);
        let travel = Vec2::from_angle(heading);
        let gusts = std::array::from_fn(|i| {
            let size = speed * gustiness * SHARE[i];
            let aside = rng.range(-0.5, 0.5);
            Gust {
                amplitude: (travel + travel.perp() * aside) * (size / 1.0f32.hypot(aside)),
                cycles: CYCLES[i],
                phase: rng.unit(),
            }
        });
        // Gusts ride on the wind aloft, which is faster than that among the trees.
        Self { mean: travel * speed, gusts, travel, slowness: 1.0 / (1.5 * speed + 3.0) }
    }

    /// Upper bound of the wind's speed, metres per second.
    pub fn fastest(&self) -> f32 {
        self.mean.length() + self.gusts.iter().map(|g| g.amplitude.length()).sum::<f32>()
    }

    /// Phase of a gust at a place, `time` within the period, in `[0, 1)` turns.
    fn phase(&self, gust: &Gust, place: Vec3, time: f32) -> f32 {
        let late = self.travel.dot(Vec2::new(place.x, place.z)) * self.slowness;
        let turns = gust.cycles as f32 * ((time - late) * (1.0 / Self::PERIOD as f32)) + gust.phase;
        turns - turns.floor()
    }

    /// `time` within the period, for [`Wind::velocity`] and a GPU: to 0.06 ms, however large `time` is.
    pub fn reduced(time: f64) -> f32 {
        time.rem_euclid(Self::PERIOD) as f32
    }

    /// Velocity of the wind at a place and time (seconds), metres per second; Y is 0.
    pub fn velocity(&self, place: Vec3, time: f64) -> Vec3 {
        let time = Self::reduced(time);
        let v = self
            .gusts
            .iter()
            .fold(self.mean, |v, g| v + g.amplitude * (TAU * self.phase(g, place, time)).sin());
        Vec3::new(v.x, 0.0, v.y)
    }

    /// How far the wind carries a leaf in `elapsed` seconds from `detach_time` on, metres; Y is 0.
    ///
    /// The leaf takes on the wind's velocity with the time constant `response` (seconds; at most 0:
    /// at once): the integral of `(1 - exp(-s / response)) * velocity`, of which every term is
    /// elementary. The gusts are those at `place`, the foot of its tree: the same for all its leaves.
    pub fn displacement(&self, place: Vec3, detach_time: f64, elapsed: f32, response: f32) -> Vec3 {
        let start = Self::reduced(detach_time);
        let lag = response.max(1e-4);
        // Below 1e-26 nothing changes, but numbers so small are slow.
        let fade = (-elapsed / lag).max(-60.0).exp();
        let mut d = self.mean * (elapsed - lag * (1.0 - fade));
        // Waves since the detachment: whole periods carry it nowhere.
        let part = elapsed - Self::PERIOD as f32 * (elapsed / Self::PERIOD as f32).floor();
        for gust in &self.gusts {
            let omega = TAU * gust.cycles as f32 / Self::PERIOD as f32;
            let first = self.phase(gust, place, start);
            let turns = first + gust.cycles as f32 * part * (1.0 / Self::PERIOD as f32);
            let (s0, c0) = (TAU * first).sin_cos();
            let (s1, c1) = (TAU * (turns - turns.floor())).sin_cos();
            let a = 1.0 / lag;
            let plain = (c0 - c1) / omega;
            let lagging =
                ((a * s0 + omega * c0) - fade * (a * s1 + omega * c1)) / (a * a + omega * omega);
            d += gust.amplitude * (plain - lagging);
        }
        Vec3::new(d.x, 0.0, d.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn displacement_is_the_integral_of_the_velocity_taken_on() {
        let wind = Wind::new(4.0, 0.7, 0.8, 3);
        let origin = Vec3::new(20.0, 8.0, -35.0);
        let (t0, lag) = (1e7 + 0.25, 0.4);
        let step = 1e-3;
        let mut sum = Vec3::ZERO;
        for i in 0..20_000 {
            let s = (f64::from(i) + 0.5) * step;
            let taken = 1.0 - (-s / lag).exp();
            sum += wind.velocity(origin, t0 + s) * (taken * step) as f32;
        }
        let closed = wind.displacement(origin, t0, 20.0, lag as f32);
        assert!((sum - closed).length() < 0.01, "{sum} {closed}");
        assert!(closed.length() > 40.0);
    }

    #[test]
    fn a_leaf_leaves_its_twig_at_rest() {
        let wind = Wind::new(8.0, 2.0, 1.0, 1);
        let d = |t| wind.displacement(Vec3::ONE, 12.0, t, 0.4).length();
        assert!(d(0.0) < 1e-4);
        assert!(d(0.01) < 0.01 * 0.3, "{}", d(0.01));
    }

    #[test]
    fn wind_stays_below_its_bound_and_repeats() {
        let wind = Wind::new(5.0, 1.0, 1.0, 9);
        for i in 0..1000 {
            let (place, t) = (Vec3::X * i as f32, f64::from(i) * 1.7);
            let v = wind.velocity(place, t);
            assert!(v.length() <= wind.fastest());
            assert!((v - wind.velocity(place, t + 3.0 * Wind::PERIOD)).length() < 1e-3);
        }
    }

    /// The closed form of [`Wind::displacement`] in double precision throughout.
    fn exact(wind: &Wind, place: Vec3, detach_time: f64, elapsed: f64, lag: f64) -> [f64; 2] {
        use std::f64::consts::TAU;
        let late = f64::from(wind.travel.x * place.x + wind.travel.y * place.z);
        let late = late * f64::from(wind.slowness);
        let fade = (-elapsed / lag).exp();
        let along = |axis: usize| {
            let steady = f64::from(wind.mean[axis]) * (elapsed - lag * (1.0 - fade));
            let gusts = wind.gusts.iter().map(|gust| {
                let omega = TAU * f64::from(gust.cycles) / Wind::PERIOD;
                let first = omega * (detach_time - late).rem_euclid(Wind::PERIOD)
                    + TAU * f64::from(gust.phase);
                let ((s0, c0), (s1, c1)) = (first.sin_cos(), (first + omega * elapsed).sin_cos());
                let a = 1.0 / lag;
                let lagging = (a * s0 + omega * c0) - fade * (a * s1 + omega * c1);
                f64::from(gust.amplitude[axis])
                    * ((c0 - c1) / omega - lagging / (a * a + omega * omega))
            });
            steady + gusts.sum::<f64>()
        };
        [along(0), along(1)]
    }

    #[test]
    fn displacement_is_as_precise_after_ten_days_as_at_once() {
        let wind = Wind::new(6.0, 0.7, 1.0, 3);
        let place = Vec3::new(20.0, 8.0, -35.0);
        for detach_time in [0.0, 10.3, 1000.7, 864_000.3, 864_777.9, 1e9 + 0.1] {
            for elapsed in [0.01, 0.5, 3.0, 20.0, 200.0] {
                let found = wind.displacement(place, detach_time, elapsed, 0.4);
                let [x, z] = exact(&wind, place, detach_time, f64::from(elapsed), 0.4);
                let off = (f64::from(found.x) - x).hypot(f64::from(found.z) - z);
                // Half a millimetre of phase, and single precision of hundreds of metres.
                assert!(
                    off < 5e-4 + 2e-6 * f64::from(found.length()),
                    "{detach_time} {elapsed}: {off}"
                );
            }
        }
    }
}
