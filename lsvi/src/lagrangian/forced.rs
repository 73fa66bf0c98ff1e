//! Non-conservative forces by the discrete Lagrange–d'Alembert principle ([MW01]).

use super::{EulerLagrange, HessianWeights, Lagrangian, MotionWeights};
use crate::error::{InputError, SystemError};
use crate::linalg::{Jacobian, Structure};
use crate::pool::Pool;

/// A generalized force F(t, q, v) with its exact derivatives, in n degrees of freedom.
pub trait Force {
    /// Degrees of freedom n.
    fn dim(&self) -> usize;

    /// Where the derivatives ∂F/∂q and ∂F/∂v may have entries.
    fn structure(&self) -> Structure {
        Structure::Dense
    }

    /// Writes F(t, q, v).
    fn force(&self, t: f64, q: &[f64], v: &[f64], out: &mut [f64]);

    /// Adds `in_q` ∂F/∂q + `in_v` ∂F/∂v to `out`.
    fn add_derivative(&self, t: f64, q: &[f64], v: &[f64], in_q: f64, in_v: f64, out: &mut Jacobian);
}

/// A Lagrangian whose ∂L/∂q carries the force F besides.
///
/// The Lagrange–d'Alembert principle δ∫L dt + ∫F·δq dt = 0 puts F wherever the variation of the action has ∂L/∂q. So every
/// discretisation of this pair has the discrete forces that its own quadrature gives, F⁻ in p₀ and F⁺ in p₁; the midpoint
/// rule for instance h/2 F in each.
/// The [`value`](Lagrangian::value), and with it the action, is that of L alone.
#[derive(Debug)]
pub struct Forced<L, F> {
    lagrangian: L,
    force: F,
    scratch: Pool<Vec<f64>>,
}

impl<L: Lagrangian, F: Force> Forced<L, F> {
    /// Applies `force` to the motions of `lagrangian`.
    ///
    /// # Errors
    /// [`SystemError::Dimension`] if the two differ in their degrees of freedom.
    pub fn new(lagrangian: L, force: F) -> Result<Self, InputError> {
        let (expected, found) = (lagrangian.dim(), force.dim());
        if found != expected {
            return Err(InputError::System(SystemError::Dimension { what: "force", expected, found }));
        }
        Ok(Self { lagrangian, force, scratch: Pool::new(move || vec![0.0; expected]) })
    }

    fn add_force(&self, t: f64, q: &[f64], v: &[f64], out: &mut [f64]) {
        self.scratch.with(|f| {
            self.force.force(t, q, v, f);
            out.iter_mut().zip(f).for_each(|(o, f)| *o += *f);
        });
    }

    fn add_force_derivative(&self, t: f64, q: &[f64], v: &[f64], in_q: f64, in_v: f64, out: &mut Jacobian) {
        if in_q != 0.0 || in_v != 0.0 {
            self.force.add_derivative(t, q, v, in_q, in_v, out);
        }
    }
}

impl<L: Lagrangian, F: Force> Lagrangian for Forced<L, F> {
    fn dim(&self) -> usize {
        self.lagrangian.dim()
    }

    /// That of both, where they are the same or two bands; dense otherwise.
    fn structure(&self) -> Structure {
        match (self.lagrangian.structure(), self.force.structure()) {
            (Structure::Banded { lower, upper }, Structure::Banded { lower: below, upper: above }) => {
                Structure::Banded { lower: lower.max(below), upper: upper.max(above) }
            }
            (one, other) if one == other => one,
            _ => Structure::Dense,
        }
    }

    fn value(&self, t: f64, q: &[f64], v: &[f64]) -> f64 {
        self.lagrangian.value(t, q, v)
    }

    fn gradient(&self, t: f64, q: &[f64], v: &[f64], dl_dq: &mut [f64], dl_dv: &mut [f64]) {
        self.lagrangian.gradient(t, q, v, dl_dq, dl_dv);
        self.add_force(t, q, v, dl_dq);
    }

    fn add_hessian(&self, t: f64, q: &[f64], v: &[f64], c: HessianWeights, out: &mut Jacobian) {
        self.lagrangian.add_hessian(t, q, v, c, out);
        self.add_force_derivative(t, q, v, c.qq, c.qv, out);
    }

    fn add_blocks(&self, t: f64, q: &[f64], v: &[f64], blocks: [&mut Jacobian; 4]) {
        let [qq, qv, vq, vv] = blocks;
        self.lagrangian.add_blocks(t, q, v, [&mut *qq, &mut *qv, vq, vv]);
        self.add_force_derivative(t, q, v, 1.0, 0.0, qq);
        self.add_force_derivative(t, q, v, 0.0, 1.0, qv);
    }
}

impl<L: EulerLagrange, F: Force> EulerLagrange for Forced<L, F> {
    fn residual(&self, t: f64, q: &[f64], v: &[f64], a: &[f64], out: &mut [f64]) {
        self.lagrangian.residual(t, q, v, a, out);
        self.add_force(t, q, v, out);
    }

    fn add_residual_derivative(&self, t: f64, q: &[f64], v: &[f64], a: &[f64], c: MotionWeights, out: &mut Jacobian) {
        self.lagrangian.add_residual_derivative(t, q, v, a, c, out);
        self.add_force_derivative(t, q, v, c.q, c.v, out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Pattern;

    /// No motion and no force, with derivatives of this structure.
    struct Nothing(Structure);

    impl Lagrangian for Nothing {
        fn dim(&self) -> usize {
            3
        }
        fn structure(&self) -> Structure {
            self.0.clone()
        }
        fn value(&self, _: f64, _: &[f64], _: &[f64]) -> f64 {
            0.0
        }
        fn gradient(&self, _: f64, _: &[f64], _: &[f64], _: &mut [f64], _: &mut [f64]) {}
        fn add_hessian(&self, _: f64, _: &[f64], _: &[f64], _: HessianWeights, _: &mut Jacobian) {}
    }

    impl Force for Nothing {
        fn dim(&self) -> usize {
            3
        }
        fn structure(&self) -> Structure {
            self.0.clone()
        }
        fn force(&self, _: f64, _: &[f64], _: &[f64], _: &mut [f64]) {}
        fn add_derivative(&self, _: f64, _: &[f64], _: &[f64], _: f64, _: f64, _: &mut Jacobian) {}
    }

    #[test]
    fn the_structure_is_that_of_both_where_one_holds_both() {
        let band = |lower, upper| Structure::Banded { lower, upper };
        let sparse = |entries: &[(usize, usize)]| {
            Structure::Sparse(Pattern::new(3, entries.iter().copied()).expect("inside").into())
        };
        let (one, other) = (sparse(&[(0, 0), (2, 1)]), sparse(&[(0, 0), (1, 2)]));
        for (motion, force, both) in [
            (band(2, 0), band(1, 3), band(2, 3)),
            (band(0, 1), band(2, 0), band(2, 1)),
            (one.clone(), one.clone(), one.clone()),
            (one.clone(), other, Structure::Dense),
            (one, band(1, 1), Structure::Dense),
            (band(1, 1), Structure::Dense, Structure::Dense),
            (Structure::Dense, Structure::Dense, Structure::Dense),
        ] {
            let forced = Forced::new(Nothing(motion.clone()), Nothing(force.clone())).expect("of one dimension");
            assert_eq!(Lagrangian::structure(&forced), both, "{motion:?} and {force:?}");
        }
    }
}
