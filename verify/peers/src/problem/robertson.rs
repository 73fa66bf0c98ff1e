//! Robertson's reaction ([HW96] Eq. (IV.1.4)).

use super::{Problem, System, TruthError};

/// Three reactions at the rates 0.04, 10⁴ and 3·10⁷, from (1, 0, 0).
#[derive(Debug)]
pub(crate) struct Robertson;

impl System<3> for Robertson {
    fn rhs(&self, _t: f64, v: &[f64; 3], dv: &mut [f64; 3]) {
        let (decay, back, pair) = (0.04 * v[0], 1e4 * v[1] * v[2], 3e7 * v[1] * v[1]);
        *dv = [back - decay, decay - back - pair, pair];
    }

    fn jacobian(&self, _t: f64, v: &[f64; 3], mut add: impl FnMut(usize, usize, f64)) {
        let (by_second, by_third, pair) = (1e4 * v[2], 1e4 * v[1], 6e7 * v[1]);
        add(0, 0, -0.04);
        add(0, 1, by_second);
        add(0, 2, by_third);
        add(1, 0, 0.04);
        add(1, 1, -by_second - pair);
        add(1, 2, -by_third);
        add(2, 1, pair);
    }
}

impl Robertson {
    /// To t = 40, where a third has reacted. At the end of 10¹¹ of the test sets all has, whatever the error on the way.
    ///
    /// # Errors
    /// [`TruthError`] if its solution is not tabulated.
    pub(crate) fn problem() -> Result<Problem<3, Self>, TruthError> {
        Problem::known(Self, "robertson", 40.0)
    }
}
