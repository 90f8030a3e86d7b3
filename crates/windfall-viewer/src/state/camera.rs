//! The camera's ways: around a place, on foot, through the air, or along a recorded path.

use glam::{DVec2, DVec3};
use windfall_scenes::CameraKey;

/// How the camera moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
    /// Around its target.
    #[default]
    Orbit,
    /// On the ground, at the height of eyes.
    Walk,
    /// Freely.
    Fly,
    /// Along the scene's path.
    Path,
}

impl Mode {
    /// Each of them.
    pub const ALL: [Self; 4] = [Self::Orbit, Self::Walk, Self::Fly, Self::Path];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Orbit => "orbit",
            Self::Walk => "walk",
            Self::Fly => "fly",
            Self::Path => "path",
        }
    }
}

/// Speed on foot, metres per second; in the air it is [`FLYING`] times that.
const WALKING: f64 = 2.5;
const FLYING: f64 = 3.0;
/// What Shift multiplies speeds by.
const HURRY: f64 = 4.0;
/// Nearest that the camera comes to the ground, metres.
const CLEARANCE: f64 = 0.15;
/// Farthest from straight up and down that it looks, radians.
const STEEPEST: f64 = 1.55;

/// What hands do in a frame.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Hands {
    /// Turns, radians: right, down.
    pub turn: DVec2,
    /// Shifts, parts of the picture's height: right, down.
    pub shift: DVec2,
    /// Factor on the distance; 0 is none, above 0 nearer.
    pub zoom: f64,
    /// Steps, `-1..=1`: right, up, ahead.
    pub step: DVec3,
    /// Whether to hurry.
    pub fast: bool,
    /// Seconds since the last frame.
    pub elapsed: f64,
}

/// A camera that hands move.
#[derive(Debug, Clone, PartialEq)]
pub struct Rig {
    /// How it moves.
    pub mode: Mode,
    /// Where it is, metres.
    pub eye: DVec3,
    /// Direction from above, radians: 0 along -Z, a quarter turn along +X.
    pub yaw: f64,
    /// Over the horizon, radians.
    pub pitch: f64,
    /// Distance of what it goes around, metres.
    pub distance: f64,
    /// Vertical field of view, degrees.
    pub fov: f32,
    /// Height over the ground on foot, metres.
    pub eye_height: f64,
}

impl Rig {
    /// A camera that stands at `eye` and looks at `target`.
    pub fn new(eye: DVec3, target: DVec3, fov: f32) -> Self {
        let mut rig = Self {
            mode: Mode::default(),
            eye,
            yaw: 0.0,
            pitch: 0.0,
            distance: 1.0,
            fov,
            eye_height: 1.7,
        };
        rig.look_at(eye, target);
        rig
    }

    /// The camera of a key; `ground` is the height at x and z.
    pub fn of_key(key: &CameraKey, ground: impl Fn(f64, f64) -> f64) -> Self {
        let above = |(x, y, z)| DVec3::new(x, y + ground(x, z), z);
        Self::new(above(key.eye), above(key.target), key.fov)
    }

    /// As a key of a scene's camera.
    pub fn key(&self, time: f64, ground: impl Fn(f64, f64) -> f64) -> CameraKey {
        let below = |at: DVec3| (at.x, at.y - ground(at.x, at.z), at.z);
        CameraKey { time, eye: below(self.eye), target: below(self.target()), fov: self.fov }
    }

    /// Stands at `eye` and looks at `target`.
    pub fn look_at(&mut self, eye: DVec3, target: DVec3) {
        let to = target - eye;
        self.eye = eye;
        self.distance = to.length().max(1e-3);
        self.yaw = to.x.atan2(-to.z);
        self.pitch = (to.y / self.distance).clamp(-1.0, 1.0).asin();
    }

    /// Unit vector along which it looks.
    pub fn forward(&self) -> DVec3 {
        let (sin, cos) = self.yaw.sin_cos();
        let (up, level) = self.pitch.sin_cos();
        DVec3::new(sin * level, up, -cos * level)
    }

    /// What it looks at.
    pub fn target(&self) -> DVec3 {
        self.eye + self.forward() * self.distance
    }

    /// Sees a sphere in full, from the direction that it looks in.
    pub fn frame(&mut self, middle: DVec3, radius: f64, aspect: f64) {
        let half = f64::from(self.fov).to_radians() / 2.0;
        let half = half.min((half.tan() * aspect).atan());
        let away = radius.max(0.1) / half.sin();
        self.look_at(middle - self.forward() * away, middle);
    }

    /// Moves as hands do; `ground` is the height at x and z.
    pub fn update(&mut self, hands: &Hands, ground: impl Fn(f64, f64) -> f64) {
        let speed = WALKING * if hands.fast { HURRY } else { 1.0 } * hands.elapsed.min(0.25);
        match self.mode {
            Mode::Path => {}
            Mode::Orbit => {
                let target = self.target();
                self.turn(DVec2::new(hands.turn.x, hands.turn.y));
                let view = 2.0 * self.distance * (f64::from(self.fov).to_radians() / 2.0).tan();
                let (right, up) = self.sides();
                let moved = (up * hands.shift.y - right * hands.shift.x) * view;
                let (sin, cos) = self.yaw.sin_cos();
                let ahead = DVec3::new(sin, 0.0, -cos);
                let steps = right * hands.step.x + DVec3::Y * hands.step.y + ahead * hands.step.z;
                self.distance = (self.distance * (-hands.zoom).exp()).clamp(0.05, 5000.0);
                let target = target + moved + steps * speed * FLYING;
                self.eye = target - self.forward() * self.distance;
                let floor = ground(self.eye.x, self.eye.z) + CLEARANCE;
                if self.eye.y < floor {
                    self.look_at(DVec3::new(self.eye.x, floor, self.eye.z), target);
                }
            }
            Mode::Walk | Mode::Fly => {
                self.turn(hands.turn);
                let flying = self.mode == Mode::Fly;
                let (sin, cos) = self.yaw.sin_cos();
                let ahead = if flying { self.forward() } else { DVec3::new(sin, 0.0, -cos) };
                let right = DVec3::new(cos, 0.0, sin);
                let along = hands.step.z + hands.zoom * 4.0;
                let mut moved = right * hands.step.x + ahead * along;
                if flying {
                    moved = (moved + DVec3::Y * hands.step.y) * FLYING;
                } else {
                    let height = self.eye_height + hands.step.y * speed;
                    self.eye_height = height.clamp(0.2, 30.0);
                }
                self.eye += moved * speed;
                let floor = ground(self.eye.x, self.eye.z);
                if !flying {
                    self.eye.y = floor + self.eye_height;
                }
                self.eye.y = self.eye.y.max(floor + CLEARANCE);
            }
        }
    }

    fn turn(&mut self, by: DVec2) {
        self.yaw = (self.yaw + by.x).rem_euclid(std::f64::consts::TAU);
        self.pitch = (self.pitch - by.y).clamp(-STEEPEST, STEEPEST);
    }

    /// Right and up in the picture.
    fn sides(&self) -> (DVec3, DVec3) {
        let (sin, cos) = self.yaw.sin_cos();
        let right = DVec3::new(cos, 0.0, sin);
        (right, right.cross(self.forward()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(_: f64, _: f64) -> f64 {
        0.0
    }

    #[test]
    fn a_key_comes_back_on_hills() {
        let hills = |x: f64, z: f64| 0.1 * x - 0.05 * z;
        let key =
            CameraKey { time: 2.0, eye: (3.0, 1.7, 20.0), target: (-2.0, 6.0, 1.0), fov: 40.0 };
        let back = Rig::of_key(&key, hills).key(2.0, hills);
        for (a, b) in [(back.eye, key.eye), (back.target, key.target)] {
            assert!(DVec3::from(a).distance(DVec3::from(b)) < 1e-9, "{a:?} {b:?}");
        }
    }

    #[test]
    fn orbits_keep_their_target_and_stay_above_ground() {
        let target = DVec3::new(1.0, 5.0, 0.0);
        let mut rig = Rig::new(DVec3::new(0.0, 2.0, 20.0), target, 50.0);
        let distance = rig.distance;
        rig.update(&Hands { turn: DVec2::new(0.7, 0.1), ..Hands::default() }, level);
        assert!(rig.target().distance(target) < 1e-9);
        assert!((rig.distance - distance).abs() < 1e-9);
        rig.update(&Hands { turn: DVec2::new(0.0, -3.0), ..Hands::default() }, level);
        assert!(rig.eye.y >= CLEARANCE - 1e-9 && rig.target().distance(target) < 1e-9);
        let near = rig.distance;
        rig.update(&Hands { zoom: 0.5, ..Hands::default() }, level);
        assert!(rig.distance < near);
    }

    #[test]
    fn feet_stay_on_the_ground() {
        let slope = |x: f64, _: f64| x * 0.5;
        let mut rig = Rig::new(DVec3::new(0.0, 9.0, 0.0), DVec3::new(10.0, 9.0, 0.0), 50.0);
        rig.mode = Mode::Walk;
        let ahead = Hands { step: DVec3::Z, elapsed: 0.1, ..Hands::default() };
        rig.update(&ahead, slope);
        assert!((rig.eye.x - 0.25).abs() < 1e-9, "{}", rig.eye);
        assert!((rig.eye.y - (0.125 + 1.7)).abs() < 1e-9, "{}", rig.eye);
        rig.update(&Hands { fast: true, ..ahead }, slope);
        assert!((rig.eye.x - 1.25).abs() < 1e-9);
        rig.mode = Mode::Fly;
        rig.update(&Hands { step: DVec3::Y, elapsed: 0.1, ..Hands::default() }, slope);
        assert!(rig.eye.y > 0.625 + 1.7);
    }

    #[test]
    fn a_framed_sphere_is_seen_in_full() {
        let mut rig = Rig::new(DVec3::new(0.0, 2.0, 20.0), DVec3::ZERO, 60.0);
        rig.frame(DVec3::new(5.0, 3.0, 0.0), 4.0, 2.0);
        assert!((rig.distance - 8.0).abs() < 1e-9, "{}", rig.distance);
        assert!(rig.target().distance(DVec3::new(5.0, 3.0, 0.0)) < 1e-9);
    }
}
