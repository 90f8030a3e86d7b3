//! How trees move in the wind that carries their leaves.
//!
//! Four motions, the first three as in T. Sousa, "Vegetation Procedural Animation and Shading in Crysis" (GPU Gems
//! 3, chapter 16) and R. Zioma, "GPU-Generated Procedural Wind Animations for Trees" (chapter 6): the
//! tree leans by the wind's pressure, limbs rock, twigs tremble, leaves flutter. All are functions of the place at
//! rest and the time alone, so that a leaf, its twig, its shadow and the leaf when it has just
//! detached are at one place. Gusts arrive with the waves of [`Wind`] and cross the forest with them.

use crate::wind::Wind;
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::TAU;

/// How far a part of a tree has moved from its place `rest`, metres; the tree's foot is at height
/// `foot`. At most about a twentieth of the height over the foot.
pub fn offset(wind: &Wind, rest: Vec3, foot: f32, time: f64) -> Vec3 {
    let high = (rest.y - foot).max(0.0);
    let blowing = wind.velocity(rest, time);
    let blowing = Vec2::new(blowing.x, blowing.z);
    let speed = blowing.length();
    // Pressure goes with the square of the speed, a leaning stem's deflection with its height to
    // the power of 3/2.
    let lean = blowing * (speed * 1.5e-4 * high * high.sqrt()).min(0.03 * high / speed.max(1e-3));
    let free = high / (high + 4.0) * speed.min(8.0);
    let (rock, tremble) = (0.014 * free, 0.0035 * free);
    let swing = |wave: Vec3, rate: f32| {
        let turns = rest.dot(wave) + Wind::reduced(time) * rate;
        (TAU * (turns - turns.floor())).sin()
    };
    // Rates in turns a second, a whole number of them in the wind's period.
    Vec3::new(
        lean.x
            + rock * swing(Vec3::new(0.13, 0.07, 0.11), 0.343_75)
            + tremble * swing(Vec3::new(0.9, 0.7, -0.8), 2.281_25),
        0.6 * rock * swing(Vec3::new(-0.17, 0.05, 0.19), 0.468_75)
            + tremble * swing(Vec3::new(-0.8, 0.9, 0.9), 2.718_75),
        lean.y
            + rock * swing(Vec3::new(0.09, -0.08, 0.15), 0.406_25)
            + tremble * swing(Vec3::new(0.7, -0.9, 0.8), 2.531_25),
    )
}

/// A bound of [`offset`], metres: in wind of at most `speed` m/s, of what is up to `high` metres above the foot.
pub fn farthest(speed: f32, high: f32) -> f32 {
    // Of what rocks and trembles along three axes the root of the sum of squares.
    (speed * speed * 1.5e-4 * high * high.sqrt()).min(0.03 * high) + 0.03 * speed.min(8.0)
}

/// How a leaf that hangs at `rest` has turned about its place: up to about a quarter turn in a storm.
pub fn flutter(wind: &Wind, rest: Vec3, time: f64) -> Quat {
    let blowing = wind.velocity(rest, time);
    let speed = Vec2::new(blowing.x, blowing.z).length().min(8.0);
    let swing = |wave: Vec3, rate: f32| {
        let turns = rest.dot(wave) + Wind::reduced(time) * rate;
        (TAU * (turns - turns.floor())).sin()
    };
    let turned = Vec3::new(
        swing(Vec3::new(2.3, 1.9, -2.9), 3.156_25),
        0.6 * swing(Vec3::new(1.7, -3.1, 2.2), 2.843_75),
        swing(Vec3::new(-2.7, 2.1, 2.5), 3.718_75),
    ) * (0.06 * speed);
    let half = turned * 0.5;
    Quat::from_xyzw(half.x, half.y, half.z, 1.0).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn feet_stand_still_tops_move_most_and_a_calm_is_still() {
        let wind = Wind::new(6.0, 0.4, 0.7, 2);
        let reach = |y: f32| {
            (0..200)
                .map(|i| offset(&wind, Vec3::new(3.0, y, 4.0), 0.0, f64::from(i) * 0.37).length())
                .fold(0.0, f32::max)
        };
        assert_eq!(reach(0.0), 0.0);
        assert_eq!(reach(-1.0), 0.0);
        assert!(reach(4.0) < reach(12.0) && reach(12.0) > 0.05, "{}", reach(12.0));
        assert!(reach(12.0) < 12.0 / 15.0);
        assert_eq!(offset(&Wind::calm(), Vec3::ONE * 9.0, 0.0, 3.0), Vec3::ZERO);
    }

    #[test]
    fn nothing_moves_farther_than_the_farthest_and_much_comes_near() {
        let mut most = 0.0f32;
        for (speed, gustiness) in [(0.5, 0.0), (3.0, 0.5), (6.0, 0.7), (14.0, 1.0)] {
            let wind = Wind::new(speed, 0.4, gustiness, 2);
            for i in 0..4000 {
                let high = 1.0 + (i % 30) as f32;
                let rest = Vec3::new((i % 7) as f32, high, (i % 11) as f32);
                let moved = offset(&wind, rest, 0.0, f64::from(i) * 0.37).length();
                most = most.max(moved / farthest(wind.fastest(), high));
            }
        }
        assert!((0.7..1.0).contains(&most), "{most}");
        assert_eq!(farthest(0.0, 30.0), 0.0);
    }

    #[test]
    fn it_repeats_with_the_wind_and_is_continuous() {
        let wind = Wind::new(8.0, 1.0, 1.0, 5);
        let rest = Vec3::new(-20.0, 11.0, 7.0);
        let at = |t: f64| offset(&wind, rest, 0.5, t);
        for i in 0..400 {
            let t = f64::from(i) * 2.56;
            assert!((at(t) - at(t + Wind::PERIOD)).length() < 1e-3);
            assert!((at(t) - at(t + 1e-3)).length() < 5e-3);
        }
    }
}
