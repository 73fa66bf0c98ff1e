//! Van der Pol's oscillator with μ = 1000.

use super::{Problem, System, TruthError};

/// ẋ = y, ẏ = μ (1 − x²) y − x.
#[derive(Debug)]
pub(crate) struct VanDerPol;

const MU: f64 = 1000.0;

impl System<2> for VanDerPol {
    fn rhs(&self, _t: f64, v: &[f64; 2], dv: &mut [f64; 2]) {
        *dv = [v[1], MU * (1.0 - v[0] * v[0]) * v[1] - v[0]];
    }

    fn jacobian(&self, _t: f64, v: &[f64; 2], mut add: impl FnMut(usize, usize, f64)) {
        add(0, 1, 1.0);
        add(1, 0, -2.0 * MU * v[0] * v[1] - 1.0);
        add(1, 1, MU * (1.0 - v[0] * v[0]));
    }
}

impl VanDerPol {
    /// To t = 2000, past two jumps of the cycle.
    ///
    /// # Errors
    /// [`TruthError`] if its solution is not tabulated.
    pub(crate) fn problem() -> Result<Problem<2, Self>, TruthError> {
        Problem::known(Self, "van-der-pol mu=1000", 2000.0)
    }
}
