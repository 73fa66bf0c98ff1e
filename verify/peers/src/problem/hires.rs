//! Schäfer's model of the high irradiance responses of photomorphogenesis ([HW96] IV.10).

use super::{Problem, System, TruthError};

/// Eight reactants.
#[derive(Debug)]
pub(crate) struct Hires;

/// The entries of the Jacobian that are constant: row, column, rate.
const RATES: [(usize, usize, f64); 19] = [
    (0, 0, -1.71),
    (0, 1, 0.43),
    (0, 2, 8.32),
    (1, 0, 1.71),
    (1, 1, -8.75),
    (2, 2, -10.03),
    (2, 3, 0.43),
    (2, 4, 0.035),
    (3, 1, 8.32),
    (3, 2, 1.71),
    (3, 3, -1.12),
    (4, 4, -1.745),
    (4, 5, 0.43),
    (4, 6, 0.43),
    (5, 3, 0.69),
    (5, 4, 1.71),
    (5, 6, 0.69),
    (6, 6, -FREE),
    (7, 6, FREE),
];

/// What binds y₆ to y₈, and frees them.
const BIND: f64 = 280.0;
const FREE: f64 = 1.81;

impl System<8> for Hires {
    fn rhs(&self, _t: f64, v: &[f64; 8], dv: &mut [f64; 8]) {
        let bind = BIND * v[5] * v[7] - FREE * v[6];
        dv[0] = -1.71 * v[0] + 0.43 * v[1] + 8.32 * v[2] + 0.0007;
        dv[1] = 1.71 * v[0] - 8.75 * v[1];
        dv[2] = -10.03 * v[2] + 0.43 * v[3] + 0.035 * v[4];
        dv[3] = 8.32 * v[1] + 1.71 * v[2] - 1.12 * v[3];
        dv[4] = -1.745 * v[4] + 0.43 * (v[5] + v[6]);
        dv[5] = -BIND * v[5] * v[7] + 0.69 * v[3] + 1.71 * v[4] - 0.43 * v[5] + 0.69 * v[6];
        dv[6] = bind;
        dv[7] = -bind;
    }

    fn jacobian(&self, _t: f64, v: &[f64; 8], mut add: impl FnMut(usize, usize, f64)) {
        let (by_sixth, by_eighth) = (BIND * v[7], BIND * v[5]);
        RATES.into_iter().for_each(|(i, j, rate)| add(i, j, rate));
        add(5, 5, -0.43 - by_sixth);
        add(5, 7, -by_eighth);
        for (row, sign) in [(6, 1.0), (7, -1.0)] {
            add(row, 5, sign * by_sixth);
            add(row, 7, sign * by_eighth);
        }
    }
}

impl Hires {
    /// To t = 321.8122, the end of the test set.
    ///
    /// # Errors
    /// [`TruthError`] if its solution is not tabulated.
    pub(crate) fn problem() -> Result<Problem<8, Self>, TruthError> {
        Problem::known(Self, "hires", 321.8122)
    }
}
