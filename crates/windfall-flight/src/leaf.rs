//! A leaf in air: a thin elliptic plate with six degrees of freedom.
//!
//! Quasi-steady: forces depend on the momentary motion alone. The plate is cut into panels; each
//! feels a normal force that depends on its own speed and angle of attack, so that the damping of any
//! rotation, the lift of a spinning wing and the effect of curl need no terms of their own. To these
//! come the added mass and added inertia of an elliptic disc with their couplings (Kirchhoff; for a
//! disc `8 ρ R³ / 3` and `16 ρ R⁵ / 45`), the lift of a turning plate (rotational lift, as in
//! [`super::card`]), and gravity at a centre of mass that may lie off the centre of area.
//!
//! Coefficients depend on the angle of attack: normal force after a saturating fit to flat plates of
//! low aspect ratio, and a centre of pressure that moves from the leading edge to the middle as the
//! plate turns broadside (in the manner of Li, Goodwill, Wang & Ristroph, J. Fluid Mech. 937, 2022).
//!
//! Leaf frame: +Y upper side, +Z petiole to tip, X width, origin at the centre of area.

use crate::analysis::fall_path;
use glam::{DMat3, DQuat, DVec3};
use windfall_core::InputError;
use windfall_core::path::FallPath;
use windfall_core::rng::Rng;

/// Density of air, kg/m³.
pub const AIR: f64 = 1.2;
/// Acceleration of gravity, m/s².
pub const GRAVITY: f64 = 9.81;
/// Time step of the integration, seconds.
pub const STEP: f64 = 0.002;

/// How air acts on a plate; all dimensionless.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Air {
    /// Normal force coefficient broadside on.
    pub broadside: f64,
    /// How much steeper than `broadside * sin(angle)` the normal force begins at small angles.
    pub slope: f64,
    /// Friction coefficient along the plate.
    pub friction: f64,
    /// Shift of the centre of pressure towards the leading edge at small angles, in half chords.
    pub leading: f64,
    /// Rotational lift coefficient (2-D theory: π; a disc's is less).
    pub circulation: f64,
    /// Damping of rotation beyond what the panels feel: torque coefficient of `ω|ω|`.
    pub damping: f64,
    /// Share of the potential-flow moment that turns a plate broadside (Munk), 0..=1: separation
    /// takes some of it.
    pub munk: f64,
    /// Share of a panel's speed by the plate's rolling and pitching that its pressure feels, 0..=1:
    /// the flow past a plate that turns over does not follow it at once.
    pub local: f64,
}

impl Air {
    /// Found by holding falling paper discs against measurements ([`super::measure`]).
    pub const STANDARD: Self = Self {
        broadside: 3.0,
        slope: 2.79,
        friction: 0.272,
        leading: 0.539,
        circulation: 0.864,
        damping: 0.104,
        munk: 0.224,
        local: 0.485,
    };

    /// A broad leaf with lobes, curl and a petiole: the air about it resists turning over more than
    /// that about a stiff disc, and it flutters where [`Air::STANDARD`] tumbles.
    pub const FLUTTERING: Self = Self { munk: 0.6, damping: 0.5, ..Self::STANDARD };

    /// A slender wing in attached flow, as a samara's: less drag, the full moments of potential flow.
    pub const WING: Self = Self {
        broadside: 1.6,
        slope: 1.0,
        friction: 0.08,
        leading: 0.4,
        circulation: 1.6,
        damping: 0.2,
        munk: 1.0,
        local: 1.0,
    };
}

/// A leaf, as far as its flight is concerned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeafBody {
    /// Mass per area, kg/m². Leaves: 0.05 to 0.09 dry.
    pub areal_density: f64,
    /// Half of the length (Z), metres.
    pub half_length: f64,
    /// Half of the width (X), metres.
    pub half_width: f64,
    /// Centre of mass from the centre of area, metres: petioles and nuts shift it along -Z.
    pub offset: DVec3,
    /// Slope of the surface at the edge, against the middle: above 0 the leaf is a cup.
    pub cup: f64,
    /// Opposite slopes of the surface towards X at tip and petiole: the leaf is a propeller.
    pub twist: f64,
    /// How air acts on it.
    pub air: Air,
}

/// Momentary motion of a leaf.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flight {
    /// Centre of area in the world, metres.
    pub position: DVec3,
    /// Rotation from the leaf's frame into the world's.
    pub orientation: DQuat,
    /// Velocity of the centre of mass in the leaf's frame, metres per second.
    pub velocity: DVec3,
    /// Angular velocity in the leaf's frame, radians per second.
    pub spin: DVec3,
}

/// Rates of change of a [`Flight`].
#[derive(Clone, Copy)]
struct Rates {
    position: DVec3,
    turn: DVec3,
    velocity: DVec3,
    spin: DVec3,
}

const PANELS: usize = 13;

/// A body made ready for integration.
pub struct Plate {
    body: LeafBody,
    mass: f64,
    inertia: DVec3,
    added_mass: f64,
    added_inertia: DVec3,
    rotational: f64,
    panel_area: f64,
    centers: [DVec3; PANELS],
    normals: [DVec3; PANELS],
}

impl LeafBody {
    /// A flat disc of the given diameter in metres and mass per area in kg/m².
    pub fn disc(diameter: f64, areal_density: f64) -> Self {
        Self {
            areal_density,
            half_length: diameter / 2.0,
            half_width: diameter / 2.0,
            offset: DVec3::ZERO,
            cup: 0.0,
            twist: 0.0,
            air: Air::STANDARD,
        }
    }

    /// Makes the body ready for integration.
    pub fn plate(&self) -> Plate {
        let (a, b) = (self.half_length, self.half_width);
        let area = std::f64::consts::PI * a * b;
        let mass = self.areal_density * area;
        // Sum over panels of x² and z² is that of the ellipse: middle, inner and outer ring.
        let mut centers = [DVec3::ZERO; PANELS];
        for (i, center) in centers.iter_mut().enumerate().skip(1) {
            let ring = (i - 1) / 6;
            let angle = (i as f64 + 0.5 * ring as f64) * std::f64::consts::TAU / 6.0;
            let radius = [0.42, 0.947 * 0.5f64.sqrt() * 1.2][ring];
            *center = DVec3::new(angle.sin() * b, 0.0, angle.cos() * a) * radius;
        }
        let second: f64 = centers.iter().map(|c| (c.z / a).powi(2)).sum::<f64>() / PANELS as f64;
        let correct = (0.25 / second).sqrt();
        for c in &mut centers {
            *c *= correct;
        }
        let normals = centers.map(|c| {
            let (x, z) = (c.x / b, c.z / a);
            DVec3::new(-self.cup * x + self.twist * z, 1.0, -self.cup * z).normalize()
        });
        let (ix, iz) = (mass * a * a / 4.0, mass * b * b / 4.0);
        let (o, m) = (self.offset, mass);
        let inertia = DVec3::new(
            ix + m * (o.z * o.z) * 0.5,
            ix + iz + m * (o.z * o.z + o.x * o.x) * 0.5,
            iz + m * (o.x * o.x) * 0.5,
        );
        let mean = (a * b).sqrt();
        Plate {
            body: *self,
            mass,
            inertia,
            added_mass: 8.0 / 3.0 * AIR * mean.powi(3) * (b / a).sqrt().min(1.0),
            added_inertia: DVec3::new(a.powi(4) * b, 0.0, b.powi(4) * a) * (16.0 / 45.0 * AIR),
            rotational: 0.5 * self.air.circulation * AIR * 16.0 / 3.0 * a * b * mean,
            panel_area: area / PANELS as f64,
            centers,
            normals,
        }
    }
}

impl Plate {
    /// Rates of change in air that moves with `wind` (world, metres per second).
    fn rates(&self, s: &Flight, wind: DVec3) -> Rates {
        let body = &self.body;
        let into_leaf = s.orientation.conjugate();
        let air = into_leaf * wind;
        // Velocity of the centre of area through the air.
        let center = s.velocity - s.spin.cross(body.offset) - air;
        let (mut force, mut torque) = (DVec3::ZERO, DVec3::ZERO);
        let along = DVec3::new(center.x, 0.0, center.z);
        let flow = center.length();
        // Shift of pressure towards the leading edge: panels ahead of the middle bear more. The mean
        // of (x/R)² over them is a quarter, hence the 4.
        let lead = if flow > 1e-9 {
            let v = along / flow;
            DVec3::new(v.x / body.half_width, 0.0, v.z / body.half_length)
                * (4.0 * body.air.leading * (along.length() / flow))
        } else {
            DVec3::ZERO
        };
        let felt = s.spin * DVec3::new(body.air.local, 1.0, body.air.local);
        for (r, n) in self.centers.iter().zip(&self.normals) {
            let v = center + felt.cross(*r);
            let speed = v.length();
            if speed < 1e-9 {
                continue;
            }
            let normal = v.dot(*n);
            let sine = (normal / speed).abs();
            let k = body.air.slope;
            let coefficient = body.air.broadside * (1.0 + k) / (1.0 + k * sine);
            let share = (1.0 + lead.dot(*r)).max(0.0);
            let q = 0.5 * AIR * speed * self.panel_area;
            let f = *n * (-q * coefficient * normal * share)
                - (v - *n * normal) * (q * body.air.friction);
            force += f;
            torque += (*r - body.offset).cross(f);
        }
        let in_plane = DVec3::new(s.spin.x, 0.0, s.spin.z);
        let lift = in_plane.cross(center) * self.rotational;
        force += lift;
        torque -= body.offset.cross(lift);
        let size = DVec3::new(body.half_length, 0.0, body.half_width);
        let drag = 0.5 * AIR * body.air.damping * self.panel_area * PANELS as f64;
        torque -= in_plane * in_plane.abs() * size * size * size * drag;

        let added = DVec3::new(0.0, self.added_mass, 0.0);
        let momentum = s.velocity * self.mass + added * center;
        force += into_leaf * DVec3::new(0.0, -GRAVITY * self.mass, 0.0);
        let velocity = (force - s.spin.cross(momentum)) / (DVec3::splat(self.mass) + added);
        let inertia = self.inertia + self.added_inertia;
        torque -= s.spin.cross(inertia * s.spin) + center.cross(added * center) * body.air.munk;
        Rates {
            position: s.orientation * (s.velocity - s.spin.cross(body.offset)),
            turn: s.spin,
            velocity,
            spin: torque / inertia,
        }
    }

    /// One step of the classical Runge-Kutta method, `dt` seconds, at most [`STEP`].
    pub fn step(&self, s: &Flight, wind: DVec3, dt: f64) -> Flight {
        let k1 = self.rates(s, wind);
        let k2 = self.rates(&s.after(&k1, dt / 2.0), wind);
        let k3 = self.rates(&s.after(&k2, dt / 2.0), wind);
        let k4 = self.rates(&s.after(&k3, dt), wind);
        let mix = |f: fn(&Rates) -> DVec3| (f(&k1) + 2.0 * (f(&k2) + f(&k3)) + f(&k4)) / 6.0;
        let k = Rates {
            position: mix(|k| k.position),
            turn: mix(|k| k.turn),
            velocity: mix(|k| k.velocity),
            spin: mix(|k| k.spin),
        };
        s.after(&k, dt)
    }

    /// Flies for `seconds` and returns `rate` states a second, the first being `start`.
    pub fn fly(&self, start: Flight, wind: DVec3, seconds: f64, rate: f64) -> Vec<Flight> {
        let count = (seconds * rate).round() as usize + 1;
        let steps = (1.0 / (rate * STEP)).ceil().max(1.0);
        let dt = 1.0 / (rate * steps);
        let mut state = start;
        let mut out = Vec::with_capacity(count);
        out.push(state);
        for _ in 1..count {
            for _ in 0..steps as usize {
                state = self.step(&state, wind, dt);
            }
            out.push(state);
        }
        out
    }
}

impl Flight {
    /// Let go at rest in any orientation, turning a little (3 rad/s about each axis, rms).
    pub fn released(rng: &mut Rng) -> Self {
        let [x, y, z, w] = std::array::from_fn(|_| f64::from(rng.normal()));
        let q = DQuat::from_xyzw(x, y, z, w);
        let orientation = if q.length() > 1e-3 { q * (1.0 / q.length()) } else { DQuat::IDENTITY };
        let spin = DVec3::from_array(std::array::from_fn(|_| 3.0 * f64::from(rng.normal())));
        Self { position: DVec3::ZERO, orientation, velocity: DVec3::ZERO, spin }
    }

    /// Angular velocity in the world's frame, radians per second.
    pub fn world_spin(&self) -> DVec3 {
        self.orientation * self.spin
    }

    /// The leaf's upper side in the world.
    pub fn up(&self) -> DVec3 {
        DMat3::from_quat(self.orientation).y_axis
    }

    fn after(&self, k: &Rates, dt: f64) -> Self {
        // The spin is the leaf's own: its turn is applied on the right.
        let orientation = (self.orientation * DQuat::from_scaled_axis(k.turn * dt)).normalize();
        Self {
            position: self.position + k.position * dt,
            orientation,
            velocity: self.velocity + k.velocity * dt,
            spin: self.spin + k.spin * dt,
        }
    }
}

/// A fall path of `seconds` at `rate` hertz, recorded after the leaf has found its way of falling.
///
/// Several falls are drawn, and one is kept: one whose joints match well, and that comes down and
/// drifts from lap to lap as the draws do on the whole. One path stands for many falls: it must not be
/// the odd one.
///
/// # Errors
///
/// As [`fall_path`]: only for times and rates that leave too few samples, or for bodies that do
/// not fall.
pub fn simulated_path(
    name: &str,
    body: &LeafBody,
    seconds: f64,
    rate: f64,
    seed: u32,
    draws: u32,
) -> Result<FallPath, InputError> {
    let plate = body.plate();
    let mut paths: Vec<FallPath> = Vec::new();
    let mut refused = None;
    for draw in 0..draws.max(1) {
        let mut rng = Rng::new(seed).stream(draw);
        // Two seconds to forget the release.
        let settled = plate.fly(Flight::released(&mut rng), DVec3::ZERO, 2.0, 1.0)[2];
        let flight = plate.fly(settled, DVec3::ZERO, seconds, rate);
        let origin = flight[0].position;
        let positions = flight.iter().map(|s| (s.position - origin).as_vec3()).collect();
        let orientations = flight.iter().map(|s| s.orientation.as_quat()).collect();
        match fall_path(name, rate as f32, positions, orientations) {
            Ok(path) => paths.push(path),
            Err(error) => refused = Some(error),
        }
    }
    let descent = median(paths.iter().map(FallPath::descent));
    let drift = median(paths.iter().map(drift));
    let cost = |path: &FallPath| {
        let joints = &path.analysis().joints;
        let gaps = joints.iter().map(|j| j.raw.velocity + j.raw.orientation).sum::<f32>();
        (gaps + 0.5) / joints.len() as f32
            + 10.0 * (path.descent() / descent - 1.0).abs()
            + (lap_drift(path) / drift.max(1e-3) - 1.0).abs()
    };
    paths.sort_by_cached_key(|p| (cost(p) * 1e6) as u64);
    match (paths.into_iter().next(), refused) {
        (Some(path), _) => Ok(path),
        (None, Some(error)) => Err(error),
        (None, None) => unreachable!("at least one draw was made"),
    }
}

fn median(values: impl Iterator<Item = f32>) -> f32 {
    let mut values: Vec<f32> = values.collect();
    values.sort_by(f32::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// Horizontal distance over the first half of a path, metres: as long as a lap, roughly.
fn drift(path: &FallPath) -> f32 {
    path.positions()[path.positions().len() / 2].with_y(0.0).length()
}

/// How far laps lead away from the start: mean over the joints, in metres for each lap of the square
/// root of four laps, which is how independent pieces add up. Laps that turn lead round in circles.
fn lap_drift(path: &FallPath) -> f32 {
    let joints = &path.analysis().joints;
    let each = joints.iter().map(|j| {
        let p = path.positions();
        let lap = (p[j.from as usize] - p[j.to as usize]).with_y(0.0).length();
        let half = 0.5 * j.turn();
        let sum = if half.abs() < 1e-3 { 4.0 } else { ((4.0 * half).sin() / half.sin()).abs() };
        lap * sum / 2.0
    });
    each.sum::<f32>() / joints.len() as f32
}
