//! Flow between two plates, u_t = 2 + u_yy from rest, in central differences at N inner points.

use std::f64::consts::PI;

use super::{Problem, System};

/// uᵢ at yᵢ = −1 + iΔy, Δy = 2/(N + 1), with u = 0 at the walls.
#[derive(Debug)]
pub(crate) struct Channel;

/// The pressure gradient.
const DRIVE: f64 = 2.0;

/// 1/Δy².
const fn weight(n: usize) -> f64 {
    let half = (n + 1) as f64 / 2.0;
    half * half
}

impl<const N: usize> System<N> for Channel {
    const BAND: Option<(usize, usize)> = Some((1, 1));
    const IS_LINEAR: bool = true;

    fn rhs(&self, _t: f64, v: &[f64; N], dv: &mut [f64; N]) {
        let weight = weight(N);
        let mut left = 0.0;
        for i in 0..N {
            let right = if i + 1 < N { v[i + 1] } else { 0.0 };
            dv[i] = DRIVE + weight * (left - 2.0 * v[i] + right);
            left = v[i];
        }
    }

    fn jacobian(&self, _t: f64, _v: &[f64; N], mut add: impl FnMut(usize, usize, f64)) {
        let weight = weight(N);
        for i in 0..N {
            add(i, i, -2.0 * weight);
            if i > 0 {
                add(i, i - 1, weight);
                add(i - 1, i, weight);
            }
        }
    }
}

impl Channel {
    /// To t = 1. In the eigenvectors sin(kπ(i + 1)/(N + 1)) of the differences, of the rates λ_k = (4/Δy²) sin²(kπ/2(N + 1)), the
    /// solution is b_k (1 − e^{−λ_k t})/λ_k with the coefficients b_k of the drive.
    pub(crate) fn problem<const N: usize>() -> Problem<N, Self> {
        let end = 1.0;
        let angle = |k: usize, i: usize| (k * (i + 1)) as f64 * PI / (N + 1) as f64;
        let mut truth = [0.0; N];
        for k in 1..=N {
            let rate = 4.0 * weight(N) * (0.5 * angle(k, 0)).sin().powi(2);
            let drive = 2.0 * DRIVE / (N + 1) as f64 * (0..N).map(|i| angle(k, i).sin()).sum::<f64>();
            let amplitude = drive * -(-rate * end).exp_m1() / rate;
            truth.iter_mut().enumerate().for_each(|(i, u)| *u += amplitude * angle(k, i).sin());
        }
        Problem { system: Self, start: [0.0; N], end, truth }
    }
}
