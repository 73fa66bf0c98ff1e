//! The momentum equation on the staggered grid: convection that conserves energy, viscosity, and their derivatives.
//!
//! Convection is Harlow and Welch's divergence form with averages: on velocities without divergence its operator is
//! skew-symmetric, so that it does no work, whatever the grid.

use super::staggered::{Face, Space};

/// Accelerations of the `face` by convection and viscosity, from the padded velocities `w`.
pub(super) fn acceleration(space: &Space, nu: f64, w: &[f64], face: &Face) -> f64 {
    let step = space.directions(face.component).step;
    let [p, e, s, n, m, ne, nw, se, sw] = space.neighbours(face).map(|q| w[q]);
    // e, s: ahead and behind; n, m: on either side; ne, nw and se, sw: the velocities across, on either side.
    let ahead = 0.5 * (p + e);
    let behind = 0.5 * (p + s);
    let (left, right) = (0.5 * (ne + nw), 0.5 * (se + sw));
    let convection = (ahead * ahead - behind * behind) / step[0]
        + 0.5 * (left * (p + n) - right * (p + m)) / step[1];
    let viscosity = (e - 2.0 * p + s) / (step[0] * step[0]) + (n - 2.0 * p + m) / (step[1] * step[1]);
    nu * viscosity - convection
}

/// Its derivatives in the nine [`neighbours`](Space::neighbours) of the face.
pub(super) fn derivatives(space: &Space, nu: f64, w: &[f64], face: &Face) -> [f64; 9] {
    let step = space.directions(face.component).step;
    let [p, e, s, n, m, ne, nw, se, sw] = space.neighbours(face).map(|q| w[q]);
    let (ahead, behind) = (0.5 * (p + e), 0.5 * (p + s));
    let (left, right) = (0.5 * (ne + nw), 0.5 * (se + sw));
    let (a, b) = (nu / (step[0] * step[0]), nu / (step[1] * step[1]));
    let (c, d) = (1.0 / step[0], 0.5 / step[1]);
    let (above, below) = (-0.5 * d * (p + n), 0.5 * d * (p + m));
    [
        -2.0 * (a + b) - c * (ahead - behind) - d * (left - right),
        a - c * ahead,
        a + c * behind,
        b - d * left,
        b + d * right,
        above,
        above,
        below,
        below,
    ]
}
