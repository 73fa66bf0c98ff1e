//! A run that stays, for some time on the way, where solutions of the equation do not.

use nalgebra::DMatrix;
use verify::experiment::growth;
use verify::measure::norm::{Extremes, max_norm};
use verify::measure::stability::spectral_abscissa;
use verify::method::Method;
use verify::problem::Problem;

use super::beware::{LEAVES, jacobian};
use crate::cli::layout::{number, plain};

/// Largest system that is looked at in every step.
const SMALL: usize = 16;

/// A step in which no component changes by more than this part of its largest value stays where it is.
const NEAR: f64 = 0.1;

/// Steps that make a stay; a single one may be the step in which the solution leaves.
const STAY: u32 = 2;

/// Follows the latest stay: consecutive steps in which perturbations grow and the method does not show it.
#[derive(Debug, Default)]
pub(super) struct Held {
    from: f64,
    steps: u32,
    /// Logarithms of the factor by which the equation and the method multiply perturbations.
    growth: [f64; 2],
    told: Option<String>,
}

impl Held {
    /// A step of `method`, whose ends are `before` and `after`, where components have come to `sizes`.
    pub(super) fn add(
        &mut self,
        problem: &dyn Problem,
        method: &dyn Method,
        [before, after]: [(f64, &[f64]); 2],
        sizes: &[f64],
    ) {
        if self.told.is_some() {
            return;
        }
        let Some(growth) = unshown_growth(problem, method, [before, after], sizes) else {
            *self = Self::default();
            return;
        };
        if self.steps == 0 {
            self.from = before.0;
        }
        self.steps += 1;
        (0..2).for_each(|i| self.growth[i] += growth[i]);
        // Then a rounding is enough to leave.
        if self.steps >= STAY && self.growth[0] > -f64::EPSILON.ln() {
            self.told = Some(format!(
                "from t = {} to {} perturbations grow by a factor of e^{}, enough for a rounding to leave, and the steps of h = {} multiply them \
                 by {} alone: it stays where solutions of the equation do not; a step well below {} shows the growth",
                plain(self.from),
                plain(after.0),
                number(self.growth[0]),
                plain(after.0 - before.0),
                number(self.growth[1].exp()),
                number((after.0 - before.0) / growth[0])
            ));
        }
    }

    /// What is to be said of it.
    pub(super) fn told(&self) -> Option<String> {
        self.told.clone()
    }
}

/// The logarithms of the factors by which the equation and the method multiply perturbations in a step that stays where it is; none if
/// they do not grow, or the method shows half of the growth.
fn unshown_growth(
    problem: &dyn Problem,
    method: &dyn Method,
    [(t_before, before), (t, v)]: [(f64, &[f64]); 2],
    sizes: &[f64],
) -> Option<[f64; 2]> {
    let h = t - t_before;
    let is_near = before.iter().zip(v).zip(sizes).all(|((a, b), size)| (b - a).abs() <= NEAR * size);
    if v.len() > SMALL || method.traits().is_adaptive || !is_near {
        return None;
    }
    let a = h * jacobian(problem, t, v);
    // Gershgorin's bound, which costs less than eigenvalues.
    let grows = abscissa_bound(&a) > LEAVES && a.iter().all(|x| x.is_finite());
    let exponent = grows.then(|| spectral_abscissa(&a)).filter(|exponent| *exponent > LEAVES)?;
    let factor = growth(method, &a)?.ln();
    let mut f = vec![0.0; v.len()];
    problem.ode().rhs(t, v, &mut f);
    // A solution at rest may stay.
    (factor < 0.5 * exponent && max_norm(&f) > 0.0).then_some([exponent, factor])
}

/// A bound of the real parts of the eigenvalues.
fn abscissa_bound(a: &DMatrix<f64>) -> f64 {
    let bound = |i: usize| a[(i, i)] + a.row(i).iter().map(|x| x.abs()).sum::<f64>() - a[(i, i)].abs();
    (0..a.nrows()).map(bound).largest()
}
