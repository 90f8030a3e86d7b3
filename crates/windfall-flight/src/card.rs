//! The falling card: the two-dimensional model that verifies the code.
//!
//! A. Andersen, U. Pesavento & Z. J. Wang, "Analysis of transitions between fluttering, tumbling and
//! steady descent of falling cards", J. Fluid Mech. 541 (2005) 91-104: their non-dimensional
//! equations in the thin limit. The order of its regimes is the model's; it does not classify leaves.

use std::f64::consts::PI;

/// Coefficients of the card.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Card {
    /// Dimensionless moment of inertia I*.
    pub inertia: f64,
    /// Thickness over width, β; 0 is the thin limit.
    pub thickness: f64,
    /// Translational lift C_T.
    pub lift: f64,
    /// Rotational lift C_R.
    pub rotational: f64,
    /// Drag A.
    pub drag: f64,
    /// Drag B: `A - B` edge on, `A + B` broadside.
    pub anisotropy: f64,
    /// Dissipative torque μ1, of ω.
    pub torque: f64,
    /// Dissipative torque μ2, of ω|ω|.
    pub torque_square: f64,
}

impl Card {
    /// The published coefficients in the thin limit, for a moment of inertia I*.
    pub const fn thin(inertia: f64) -> Self {
        Self {
            inertia,
            thickness: 0.0,
            lift: 1.2,
            rotational: PI,
            drag: 1.4,
            anisotropy: 1.0,
            torque: 0.2,
            torque_square: 0.2,
        }
    }
}

/// Momentary motion: velocities u along the chord and v normal to it, tilt θ, its rate ω, and the
/// place x, y.
pub type State = [f64; 6];

/// The usual start: u = 0, v = 0.01, θ = 0.5, ω = 0.
pub const START: State = [0.0, 0.01, 0.5, 0.0, 0.0, 0.0];

impl Card {
    fn rates(&self, [u, v, theta, omega, _, _]: State) -> State {
        let (i, b2) = (self.inertia, self.thickness * self.thickness);
        let speed = u.hypot(v);
        let (lift, resistance) = if speed > 0.0 {
            let drag = self.drag - self.anisotropy * (u * u - v * v) / (speed * speed);
            (-self.lift * u * v / speed, drag * speed / PI)
        } else {
            (0.0, 0.0)
        };
        let gamma = 2.0 / PI * (lift + self.rotational * omega);
        let torque = (self.torque + self.torque_square * omega.abs()) * omega;
        let (sine, cosine) = theta.sin_cos();
        [
            ((i + 1.0) * omega * v - gamma * v - sine - resistance * u) / (i + b2),
            (-(i + b2) * omega * u + gamma * u - cosine - resistance * v) / (i + 1.0),
            omega,
            (-(1.0 - b2) * u * v - torque)
                / (0.25 * (i * (1.0 + b2) + 0.5 * (1.0 - b2) * (1.0 - b2))),
            u * cosine - v * sine,
            u * sine + v * cosine,
        ]
    }

    /// One step of the classical Runge-Kutta method.
    pub fn step(&self, s: State, dt: f64) -> State {
        let ahead = |k: &State, h: f64| std::array::from_fn(|i| s[i] + k[i] * h);
        let k1 = self.rates(s);
        let k2 = self.rates(ahead(&k1, dt / 2.0));
        let k3 = self.rates(ahead(&k2, dt / 2.0));
        let k4 = self.rates(ahead(&k3, dt));
        std::array::from_fn(|i| s[i] + (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) * dt / 6.0)
    }

    /// Falls from `start` and measures between the times `from` and `to`.
    pub fn fall(&self, start: State, from: f64, to: f64) -> CardFall {
        const DT: f64 = 0.002;
        let mut s = start;
        let mut at_from = s;
        let mut crossings: Vec<(f64, f64)> = Vec::new();
        for n in 0..(to / DT).round() as u64 {
            let t = n as f64 * DT;
            if t <= from {
                at_from = s;
            }
            let next = self.step(s, DT);
            // Upward passes of the tilt through the horizontal: one in a period of flutter.
            let (a, b) = (s[2].sin(), next[2].sin());
            if t >= from && a < 0.0 && b >= 0.0 && s[2].cos() > 0.0 {
                crossings.push((t + DT * a / (a - b), next[3]));
            }
            s = next;
        }
        let span = to - from;
        let turned = s[2] - at_from[2];
        let period = match crossings.as_slice() {
            [first, .., last] => (last.0 - first.0) / (crossings.len() - 1) as f64,
            _ => f64::NAN,
        };
        CardFall {
            vertical: (s[5] - at_from[5]) / span,
            horizontal: (s[4] - at_from[4]) / span,
            spin: turned / span,
            period,
            speed: s[0].hypot(s[1]),
            gaps: crossings.windows(2).map(|w| w[1].0 - w[0].0).collect(),
            end: s,
        }
    }

    /// Where, between two moments of inertia, the fall turns from flutter to tumbling.
    pub fn transition(low: f64, high: f64, tolerance: f64) -> (f64, f64) {
        let (mut low, mut high) = (low, high);
        while high - low > tolerance {
            let middle = 0.5 * (low + high);
            if Self::thin(middle).fall(START, 300.0, 600.0).tumbles() {
                high = middle;
            } else {
                low = middle;
            }
        }
        (low, high)
    }
}

/// What was measured on a falling card.
#[derive(Debug, Clone, PartialEq)]
pub struct CardFall {
    /// Mean vertical velocity.
    pub vertical: f64,
    /// Mean horizontal velocity.
    pub horizontal: f64,
    /// Mean rate of the tilt.
    pub spin: f64,
    /// Mean time between upward passes of the tilt through the horizontal.
    pub period: f64,
    /// Speed at the end.
    pub speed: f64,
    /// Single times between passes.
    pub gaps: Vec<f64>,
    /// The last state.
    pub end: State,
}

impl CardFall {
    /// Whether it turned over and over.
    pub fn tumbles(&self) -> bool {
        self.spin.abs() > 0.05
    }
}
