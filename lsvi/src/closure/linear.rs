//! The linear family of closures, Eqs. (26), (27).

use std::fmt;

use super::LinearClosure;
use crate::discrete::MomentumWeights;
use crate::error::{ClosureError, InputError};

/// α p₀ + β p₁ = 0, with α and β constant or functions of the step size.
///
/// Explicit-momentum is (1, 0), Method I (0, 1), Method II (−1, 1). On v̇ = −v one step multiplies by
/// (α + β − αh + ½αh²)/(α + β + βh + ½βh²), Eq. (27).
pub struct Linear(Weights);

enum Weights {
    Constant(MomentumWeights),
    OfStep(Box<dyn Fn(f64) -> (f64, f64) + Send + Sync>),
}

impl Linear {
    /// p₀ = 0, Eq. (21).
    pub const EXPLICIT_MOMENTUM: Self = Self(Weights::Constant(MomentumWeights::START));
    /// p₁ = 0, Eq. (22).
    pub const METHOD_I: Self = Self(Weights::Constant(MomentumWeights::END));
    /// p₁ = p₀, Eq. (25). On the least-squares Lagrangian of a field whose f_v is singular it determines no step;
    /// [`LeastSquaresStep`](crate::LeastSquaresStep) refuses such steps where f_v is assembled, and [`Variational`](crate::Variational) where the
    /// derivatives of the momenta tell.
    pub const METHOD_II: Self = Self(Weights::Constant(MomentumWeights { alpha: -1.0, beta: 1.0 }));

    /// Constant coefficients.
    ///
    /// # Errors
    /// [`ClosureError::Closure`] unless both are finite and not both zero.
    pub fn new(alpha: f64, beta: f64) -> Result<Self, InputError> {
        if !are_usable(alpha, beta) {
            return Err(InputError::Closure(ClosureError::Closure { alpha, beta }));
        }
        Ok(Self(Weights::Constant(MomentumWeights { alpha, beta })))
    }

    /// Coefficients (α(h), β(h)), for h = 0 their limit. Where they are both zero or not finite the step fails as singular or
    /// not finite.
    ///
    /// # Errors
    /// [`ClosureError::Limit`] unless both are finite for h = 0 and not both zero.
    pub fn of_step(weights: impl Fn(f64) -> (f64, f64) + Send + Sync + 'static) -> Result<Self, InputError> {
        let (alpha, beta) = weights(0.0);
        if !are_usable(alpha, beta) {
            return Err(InputError::Closure(ClosureError::Limit { alpha, beta }));
        }
        Ok(Self(Weights::OfStep(Box::new(weights))))
    }
}

/// Whether α p₀ + β p₁ = 0 is a condition.
fn are_usable(alpha: f64, beta: f64) -> bool {
    alpha.is_finite() && beta.is_finite() && (alpha != 0.0 || beta != 0.0)
}

impl Linear {
    /// Whether this is p₁ = 0.
    #[inline]
    pub(crate) fn is_end_alone(&self) -> bool {
        matches!(&self.0, Weights::Constant(w) if w.alpha == 0.0)
    }

    /// Whether α + β does not vanish for h → 0, so that the derivative of the closure tends to a multiple of M.
    #[inline]
    pub(crate) fn has_limit(&self) -> bool {
        !self.weights(0.0).cancel()
    }
}

impl fmt::Debug for Linear {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Weights::Constant(w) => f.debug_tuple("Linear").field(&w.alpha).field(&w.beta).finish(),
            Weights::OfStep(_) => f.write_str("Linear(functions of h)"),
        }
    }
}

impl LinearClosure for Linear {
    #[inline]
    fn weights(&self, h: f64) -> MomentumWeights {
        match &self.0 {
            Weights::Constant(w) => *w,
            Weights::OfStep(f) => {
                let (alpha, beta) = f(h);
                MomentumWeights { alpha, beta }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_without_a_limit_are_refused() {
        let quotient = Linear::of_step(|h| (-(-h).exp_m1() / h, 1.0)).expect_err("0/0 at h = 0");
        assert!(matches!(quotient, InputError::Closure(ClosureError::Limit { alpha, beta: 1.0 }) if alpha.is_nan()));
        let nothing = Linear::of_step(|h| (-h, h)).expect_err("no condition at h = 0");
        assert_eq!(nothing, InputError::Closure(ClosureError::Limit { alpha: 0.0, beta: 0.0 }));
        assert!(Linear::of_step(|h| (-(-h).exp(), 1.0)).is_ok());
        assert!(Linear::of_step(|h| (1.0, h.recip())).is_err());
        assert!(Linear::new(1.0, f64::INFINITY).is_err() && Linear::new(f64::NAN, 1.0).is_err());
    }

    #[test]
    fn the_residual_of_a_linear_closure_takes_the_carried_momentum_away() {
        use crate::closure::{Closure, PositionMomentum};
        let residual = |closure: &dyn Closure| {
            let mut out = [0.0];
            closure.residual(0.1, &[3.0], &[5.0], &[7.0], &mut out);
            out[0]
        };
        assert_eq!(residual(&PositionMomentum), 2.0);
        assert_eq!(residual(&Linear::new(2.0, -1.0).expect("finite")), 3.0);
    }
}
