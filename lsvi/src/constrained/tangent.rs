//! The derivative of a step under constraints, by implicit differentiation.

use nalgebra::{DMatrix, DVector};

use super::{Constrained, Projector, Scratch, StepEquations, add_transposed};
use crate::constraint::Constraint;
use crate::discrete::{Constrainable, Interval, MomentumWeights};
use crate::error::{SolveError, StepError};
use crate::lagrangian::{HessianWeights, Lagrangian};
use crate::linalg::{Jacobian, Lu, add_block};
use crate::newton::System;

impl<D: Constrainable, K: Constraint> Constrained<D, K> {
    /// Takes a [`step`](crate::OneStep::step) and returns its derivative ∂(q₁, p₁)/∂(q₀, p₀), 2n × 2n, by implicit differentiation.
    ///
    /// The equations of the step make sense off the constraint too; on vectors tangent to f(q) = 0, G ∂H/∂p = 0, whose
    /// images are tangent again, this is the derivative of the map that the method is.
    ///
    /// # Errors
    /// [`StepError`] as for a step, or where the derivative of the step equations is singular at their solution.
    pub fn step_with_tangent(
        &mut self,
        t: f64,
        h: f64,
        q: &mut [f64],
        p: &mut [f64],
    ) -> Result<DMatrix<f64>, StepError> {
        self.solve(t, h, q, p)?;
        let n = q.len();
        let end = self.discrete.interior();
        let failed = |source| StepError::Solve { t, h, source };
        let mut equations = StepEquations {
            discrete: &mut self.discrete,
            constraint: &self.constraint,
            scratch: &mut self.scratch,
            t,
            q0: q,
            p0: p,
            is_predicted: true,
        };
        let solution = equations.solution_tangent(h, &self.unknowns).map_err(failed)?;
        let momentum = equations.end_momentum_tangent(h, &self.unknowns, &solution);
        let (q1, position) = (&self.unknowns[end..end + n], solution.rows(end, n).into_owned());
        self.constraint.jacobian(q1, &mut self.scratch.gradient);
        let (lagrangian, derivatives) = (self.discrete.mechanics(), (&position, &momentum));
        let projected = self.projector.tangent(lagrangian, &self.constraint, &self.scratch, (t + h, q1), derivatives);
        let mut tangent = DMatrix::zeros(2 * n, 2 * n);
        tangent.rows_mut(0, n).copy_from(&position);
        tangent.rows_mut(n, n).copy_from(&projected.map_err(failed)?);
        self.finish(q, p);
        Ok(tangent)
    }
}

impl StepEquations<'_> {
    /// The derivatives of a solution in (q₀, p₀).
    fn solution_tangent(&mut self, h: f64, y: &[f64]) -> Result<DMatrix<f64>, SolveError> {
        let (n, (degree, unknowns)) = (self.q0.len(), self.path());
        let end = unknowns - n;
        let at = Interval { start: self.t, h };
        let mut of_path = Jacobian::zeros(unknowns);
        self.discrete.add_start_derivative(at, self.q0, &y[..unknowns], MomentumWeights::START, &mut of_path);
        let (mut in_unknowns, mut in_start) = (Jacobian::zeros(y.len()), DMatrix::zeros(y.len(), n));
        self.derivative(h, y, &mut in_unknowns);
        in_start.rows_mut(0, unknowns).copy_from(&of_path.to_dense().columns(0, n));
        (1..degree).for_each(|node| self.add_reaction(node, h, y, 0..=0, &mut in_start));
        // The reaction at q₀.
        let (own, block) = (unknowns + (degree - 1) * self.constraint.count(), &mut self.scratch.block);
        block.clear();
        self.constraint.add_curvature(self.q0, &y[own..], h.recip(), block);
        add_block(&mut in_start, (end, 0), 1.0, block);
        let mut tangent = DMatrix::zeros(y.len(), 2 * n);
        tangent.columns_mut(0, n).copy_from(&-in_start);
        (0..n).for_each(|i| tangent[(end + i, n + i)] = 1.0);
        let mut lu = Lu::of(&in_unknowns);
        lu.factor(&in_unknowns)?;
        tangent.column_iter_mut().for_each(|mut column| lu.solve(column.as_mut_slice()));
        Ok(tangent)
    }

    /// The derivatives of [`end_momentum`](Self::end_momentum) in (q₀, p₀) from those of the solution.
    fn end_momentum_tangent(&mut self, h: f64, y: &[f64], solution: &DMatrix<f64>) -> DMatrix<f64> {
        let (n, m, (degree, unknowns)) = (self.q0.len(), self.constraint.count(), self.path());
        let (x, multipliers) = y.split_at(unknowns);
        let (end, at) = (unknowns - n, Interval { start: self.t, h });
        let (mut in_unknowns, mut in_start) = (Jacobian::zeros(unknowns), Jacobian::zeros(unknowns));
        self.discrete.add_derivative(at, self.q0, x, MomentumWeights::END, &mut in_unknowns);
        self.discrete.add_start_derivative(at, self.q0, x, MomentumWeights::END, &mut in_start);
        let mut tangent = in_unknowns.to_dense().rows(end, n) * solution.rows(0, unknowns);
        let mut in_q0 = tangent.columns_mut(0, n);
        in_q0 += in_start.to_dense().view((end, 0), (n, n));
        for node in 1..degree {
            self.place(node, x);
            let (own, weight) = ((node - 1) * m, self.discrete.reaction_weight(node, MomentumWeights::END) / h);
            let mut position = DMatrix::zeros(n, 2 * n);
            (0..n).for_each(|i| position[(i, i)] = self.discrete.position_weight(node, 0));
            for j in 1..=degree {
                position += self.discrete.position_weight(node, j) * solution.rows((j - 1) * n, n);
            }
            let Scratch { gradient, position: place, block, .. } = &mut *self.scratch;
            block.clear();
            self.constraint.add_curvature(place, &multipliers[own..own + m], weight, block);
            tangent += block.to_dense() * position + weight * gradient.transpose() * solution.rows(unknowns + own, m);
        }
        tangent
    }
}

impl Projector {
    /// The derivative of the projected momentum L_v(q, v) from those of q and of the momentum before, after
    /// [`project`](Self::project) at `q`.
    fn tangent(
        &self,
        lagrangian: &dyn Lagrangian,
        constraint: &impl Constraint,
        scratch: &Scratch,
        (t, q): (f64, &[f64]),
        (dq, dp): (&DMatrix<f64>, &DMatrix<f64>),
    ) -> Result<DMatrix<f64>, SolveError> {
        let (n, m) = (q.len(), constraint.count());
        let (v, multipliers) = self.velocity.split_at(n);
        let hessian = |which: HessianWeights| {
            let mut out = Jacobian::zeros(n);
            lagrangian.add_hessian(t, q, v, which, &mut out);
            out
        };
        let (mass, mixed) = (
            hessian(HessianWeights { vv: 1.0, ..Default::default() }),
            hessian(HessianWeights { vq: 1.0, ..Default::default() }),
        );
        let mut curvature = Jacobian::zeros(n);
        constraint.add_curvature(q, multipliers, 1.0, &mut curvature);
        let mut solution = DMatrix::zeros(n + m, dq.ncols());
        solution.rows_mut(0, n).copy_from(&(dp - (mixed.to_dense() + curvature.to_dense()) * dq));
        for k in 0..m {
            let mut unit = vec![0.0; m];
            unit[k] = 1.0;
            curvature.clear();
            constraint.add_curvature(q, &unit, -1.0, &mut curvature);
            let bend = DVector::from_column_slice(v).transpose() * curvature.to_dense();
            solution.row_mut(n + k).copy_from(&(bend * dq));
        }
        let mut equations = Jacobian::zeros(n + m);
        let out = &mut equations;
        add_block(out, (0, 0), 1.0, &mass);
        add_transposed(out, (0, n), 1.0, &scratch.gradient);
        add_block(out, (n, 0), 1.0, &scratch.gradient);
        let mut lu = Lu::of(&equations);
        lu.factor(&equations)?;
        solution.column_iter_mut().for_each(|mut column| lu.solve(column.as_mut_slice()));
        Ok(mixed.to_dense() * dq + mass.to_dense() * solution.rows(0, n))
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{Body, Curve};
    use super::*;
    use crate::autodiff::{AutoConstraint, AutoLagrangian, ConstraintFn, Scalar};
    use crate::discrete::{Galerkin, PathFitted, Trapezoidal};
    use crate::integrator::{Integrator, OneStep};

    /// The first of the two constraints, which leaves two degrees of freedom.
    struct Surface;
    impl ConstraintFn for Surface {
        fn dim(&self) -> usize {
            3
        }
        fn count(&self) -> usize {
            1
        }
        fn constraint<T: Scalar>(&self, q: &[T], out: &mut [T]) {
            out[0] = q[0] * q[0] + q[1] * q[1] * 2.0 + q[2].sin() - 1.0;
        }
    }

    /// Moves `q` along the rows of G until f(q) = 0.
    fn retract(constraint: &impl Constraint, q: &mut [f64]) {
        let (mut value, mut gradient) =
            (DVector::zeros(constraint.count()), DMatrix::zeros(constraint.count(), q.len()));
        for _ in 0..8 {
            constraint.value(q, value.as_mut_slice());
            constraint.jacobian(q, &mut gradient);
            let multipliers =
                (&gradient * gradient.transpose()).lu().solve(&value).expect("the constraints are independent");
            q.iter_mut().zip((gradient.transpose() * multipliers).iter()).for_each(|(q, d)| *q -= d);
        }
    }

    /// Steps from both sides of a state, near it on the constraint and the hidden one, differ by the tangent.
    fn check(name: &str, discrete: impl Constrainable, constraint: impl ConstraintFn) {
        let mut method = Constrained::new(discrete, AutoConstraint::new(constraint)).expect("dimensions fit");
        let ((t, h, e), mut steps) = ((0.2, 0.3, 2e-5), 0);
        let mut on = |shift: f64, direction: usize| {
            let wave = |i: usize| shift * (1.0 + ((3 * i + 7 * direction) as f64).sin());
            let (mut q, mut p): (Vec<f64>, Vec<f64>) =
                (0..3).map(|i| ([0.5, 0.4, 0.3][i] + wave(i), [0.3, -0.2, 0.5][i] + wave(3 + i))).unzip();
            retract(&method.constraint, &mut q);
            method.project(t, &q, &mut p).expect("independent");
            let start = DVector::from_vec([q.clone(), p.clone()].concat());
            let (mut q1, mut p1) = (q.clone(), p.clone());
            method.step(t, h, &mut q1, &mut p1).expect("short step");
            let end = DVector::from_vec([q1, p1].concat());
            let tangent = method.step_with_tangent(t, h, &mut q, &mut p).expect("short step");
            // Both kinds of step are the same, and count.
            assert_eq!(DVector::from_vec([q, p].concat()), end, "{name}");
            steps += 2;
            assert_eq!(method.work().steps, steps, "{name}");
            (start, end, tangent)
        };
        let tangent = on(0.0, 0).2;
        for direction in 0..4 {
            let (plus, minus) = (on(e, direction), on(-e, direction));
            let (moved, expected) = (&tangent * (&plus.0 - &minus.0) / (2.0 * e), (plus.1 - minus.1) / (2.0 * e));
            // Central differences: e² times third derivatives of order 100, and ε/(e h) of rounding.
            let error = (&moved - &expected).amax();
            assert!(error < 1e-7, "{name}: {error:e} of {expected}");
        }
    }

    #[test]
    fn tangents_are_the_derivatives_of_steps() {
        let l = AutoLagrangian::new(Body);
        check("trapezoidal", Trapezoidal::new(&l), Surface);
        check("galerkin-gauss(3)", Galerkin::gauss(&l, 3).expect("s ≥ 1"), Surface);
        check("galerkin-lobatto(2)", Galerkin::lobatto(&l, 2).expect("s ≥ 1"), Curve);
        // Three nodes inside, of which each has the multipliers of both constraints.
        check("galerkin-lobatto(4)", Galerkin::lobatto(&l, 4).expect("s ≥ 1"), Curve);
        check("path-fitted", PathFitted::new(&l, &[0.3, 0.8]).expect("nodes"), Surface);
        check("path-fitted-bernstein", PathFitted::bernstein(&l, &[0.3, 0.8]).expect("nodes"), Curve);
    }
}
