//! Closures: the condition on the discrete momenta that makes one step a solvable system.

mod fitted;
mod homogeneous;
mod linear;
mod position_momentum;

pub use linear::Linear;
pub use position_momentum::PositionMomentum;

use nalgebra::DMatrix;

use crate::discrete::MomentumWeights;

/// A condition F(p₀, p₁) = 0 on the momenta at the two ends of a step: n equations for q₁, which may read the step size h and
/// the momentum p that the state carries.
///
/// A [`LinearClosure`] is one, and need not say more: its combination of momenta is formed before rounding can cancel what the
/// two have in common. Any other F is given p₀ and p₁ as they are.
///
/// For h → 0 a step solves F(p, p) = 0, which determines no branch where F is not linear: it may have several roots, or a
/// singular derivative. The step then takes the root to which Newton's iteration contracts from the momentum that the state
/// carries, in pieces of h if need be, and follows it back to h → 0, which costs a few solutions more: a root from which no branch without a fold
/// leads to the start of the step is refused.
///
/// ```
/// use lsvi::closure::Closure;
/// use lsvi::nalgebra::DMatrix;
/// /// p₁ = p₀³, component by component.
/// struct Cube;
/// impl Closure for Cube {
///     fn residual(&self, _h: f64, _p: &[f64], p0: &[f64], p1: &[f64], out: &mut [f64]) {
///         (0..out.len()).for_each(|i| out[i] = p1[i] - p0[i].powi(3));
///     }
///     fn derivative(&self, _h: f64, _p: &[f64], p0: &[f64], _p1: &[f64], in_p0: &mut DMatrix<f64>, in_p1: &mut DMatrix<f64>) {
///         in_p0.set_diagonal(&lsvi::nalgebra::DVector::from_iterator(p0.len(), p0.iter().map(|p| -3.0 * p * p)));
///         in_p1.fill_with_identity();
///     }
/// }
/// ```
pub trait Closure {
    /// The same as a linear closure, if it is one.
    fn linear(&self) -> Option<&dyn LinearClosure> {
        None
    }

    /// Writes F.
    fn residual(&self, h: f64, p: &[f64], p0: &[f64], p1: &[f64], out: &mut [f64]);

    /// Adds ∂F/∂p₀ and ∂F/∂p₁ to the zero matrices `in_p0` and `in_p1`, n × n.
    fn derivative(&self, h: f64, p: &[f64], p0: &[f64], p1: &[f64], in_p0: &mut DMatrix<f64>, in_p1: &mut DMatrix<f64>);
}

impl<C: LinearClosure> Closure for C {
    fn linear(&self) -> Option<&dyn LinearClosure> {
        Some(self)
    }

    fn residual(&self, h: f64, p: &[f64], p0: &[f64], p1: &[f64], out: &mut [f64]) {
        let (w, carried) = (self.weights(h), self.carried());
        for (((o, p), p0), p1) in out.iter_mut().zip(p).zip(p0).zip(p1) {
            *o = w.alpha * p0 + w.beta * p1 - carried * p;
        }
    }

    fn derivative(
        &self,
        h: f64,
        p: &[f64],
        _p0: &[f64],
        _p1: &[f64],
        in_p0: &mut DMatrix<f64>,
        in_p1: &mut DMatrix<f64>,
    ) {
        let w = self.weights(h);
        for i in 0..p.len() {
            in_p0[(i, i)] += w.alpha;
            in_p1[(i, i)] += w.beta;
        }
    }
}

/// The condition α p₀ + β p₁ = σ p on the momenta at the two ends of a step.
pub trait LinearClosure {
    /// The weights (α, β) at step size `h`, and for `h` = 0 their limit, by which branches of solutions are told.
    fn weights(&self, h: f64) -> MomentumWeights;

    /// σ, the weight of the momentum p that the state carries; 0 for closures that need no history.
    fn carried(&self) -> f64 {
        0.0
    }
}
