//! Burgers' equation u_t + (u²/2)_x = ν u_xx on 0 < x < 1 in central differences at N inner points: a front that travels.

use super::{Problem, System, TruthError, agreed};
use crate::solver::{AdaptiveRadau, Russell};

/// uᵢ at xᵢ = iΔx, Δx = 1/(N + 1), with the values of the front itself at the ends.
#[derive(Debug)]
pub(crate) struct Burgers;

/// The viscosity ν.
const NU: f64 = 0.1;
/// Speed c of the front, half its jump a, and its place x₀ at t = 0.
const SPEED: f64 = 0.5;
const JUMP: f64 = 0.5;
const PLACE: f64 = 0.25;

/// The tolerance of the reference solutions.
const FINE: f64 = 1e-13;

/// c − a tanh(a (x − x₀ − ct)/2ν), a solution of the equation in continuous space.
fn front(x: f64, t: f64) -> f64 {
    SPEED - JUMP * (0.5 * JUMP * (x - PLACE - SPEED * t) / NU).tanh()
}

/// 1/4Δx and ν/Δx².
const fn weights(n: usize) -> (f64, f64) {
    let n = (n + 1) as f64;
    (0.25 * n, NU * n * n)
}

impl<const N: usize> System<N> for Burgers {
    const BAND: Option<(usize, usize)> = Some((1, 1));

    fn rhs(&self, t: f64, v: &[f64; N], dv: &mut [f64; N]) {
        let (quarter, nu) = weights(N);
        let (mut left, last) = (front(0.0, t), front(1.0, t));
        for i in 0..N {
            let right = if i + 1 < N { v[i + 1] } else { last };
            dv[i] = quarter * (left * left - right * right) + nu * (left - 2.0 * v[i] + right);
            left = v[i];
        }
    }

    fn jacobian(&self, _t: f64, v: &[f64; N], mut add: impl FnMut(usize, usize, f64)) {
        let (quarter, nu) = weights(N);
        for i in 0..N {
            add(i, i, -2.0 * nu);
            if i > 0 {
                add(i, i - 1, nu + 2.0 * quarter * v[i - 1]);
                add(i - 1, i, nu - 2.0 * quarter * v[i]);
            }
        }
    }
}

impl Burgers {
    /// To t = 1. The differences have no closed form: the solution is that of Dormand and Prince's explicit method of order 8,
    /// checked against Radau IIA.
    ///
    /// # Errors
    /// [`TruthError::Disagreement`] if the two differ.
    pub(crate) fn problem<const N: usize>() -> Result<Problem<N, Self>, TruthError> {
        let start = std::array::from_fn(|i| front((i + 1) as f64 / (N + 1) as f64, 0.0));
        let unsolved = Problem { system: Self, start, end: 1.0, truth: [f64::NAN; N] };
        agreed("Burgers", unsolved, [(&Russell::DoPri8, FINE), (&AdaptiveRadau, FINE)])
    }
}
