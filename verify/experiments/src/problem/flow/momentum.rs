//! The momentum equation on the staggered grid: convection that conserves energy, viscosity, and their derivatives.
//!
//! Convection is Harlow and Welch's divergence form with averages: on velocities without divergence its operator is
//! skew-symmetric, so that it does no work, whatever the grid.

/// The acceleration of a face by convection and viscosity, from the nine velocities round it: its own; ahead and behind; on
/// either side; and the pairs that cross on either side.
///
/// `step` holds the spacings along the face's own direction and across it.
pub(crate) fn acceleration(step: [f64; 2], nu: f64, around: [f64; 9]) -> f64 {
    let [p, e, s, n, m, ne, nw, se, sw] = around;
    let (ahead, behind) = (0.5 * (p + e), 0.5 * (p + s));
    let (left, right) = (0.5 * (ne + nw), 0.5 * (se + sw));
    let convection = (ahead * ahead - behind * behind) / step[0] + 0.5 * (left * (p + n) - right * (p + m)) / step[1];
    let viscosity = (e - 2.0 * p + s) / (step[0] * step[0]) + (n - 2.0 * p + m) / (step[1] * step[1]);
    nu * viscosity - convection
}

/// Its derivatives in the nine velocities, which are linear in them: with ν = 0, at a unit vector, second derivatives.
pub(super) fn derivatives(step: [f64; 2], nu: f64, around: [f64; 9]) -> [f64; 9] {
    let [p, e, s, n, m, ne, nw, se, sw] = around;
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
