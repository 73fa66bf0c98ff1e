//! Steps by way of [`DiscreteLegendre::residual_equations`], where those of the momenta lead nowhere.

use crate::closure::LinearClosure;
use crate::discrete::{DiscreteLegendre, Interval};
use crate::error::SolveError;
use crate::linalg::{Jacobian, Structure};
use crate::newton::{LimitAtZero, Newton, System, Work};

#[derive(Debug)]
pub(super) struct ByResiduals {
    newton: Newton,
    /// x, and z after it.
    unknowns: Vec<f64>,
    /// Whether the last step was found so.
    pub(super) is_in_use: bool,
}

impl ByResiduals {
    /// `None` where there is no such form, or nothing to tell its branch by.
    pub(super) fn new(discrete: &dyn DiscreteLegendre, closure: &dyn LinearClosure) -> Option<Self> {
        let residuals = discrete.residuals();
        let is_told = !closure.weights(0.0).cancel() && discrete.structure() == Structure::Dense;
        let unknowns = discrete.interior() + discrete.dim() + residuals;
        (is_told && residuals > 0).then(|| Self {
            newton: Newton::new(unknowns),
            unknowns: vec![0.0; unknowns],
            is_in_use: false,
        })
    }

    pub(super) fn work(&self) -> Work {
        self.newton.work
    }

    /// Replaces `x`, a first guess, by the unknowns of the step from (t, q₀, p₀).
    pub(super) fn solve(
        &mut self,
        discrete: &mut dyn DiscreteLegendre,
        closure: &dyn LinearClosure,
        at: Interval,
        (q0, p0): (&[f64], &[f64]),
        x: &mut [f64],
    ) -> Result<(), SolveError> {
        let (start, z) = self.unknowns.split_at_mut(x.len());
        start.copy_from_slice(x);
        z.fill(0.0);
        let mut equations = Equations { discrete, closure, t: at.start, q0, p0 };
        let found = self.newton.solve(&mut equations, at.h, &mut self.unknowns);
        self.is_in_use = found.is_ok();
        if found.is_ok() {
            x.copy_from_slice(&self.unknowns[..x.len()]);
        }
        found
    }
}

struct Equations<'a> {
    discrete: &'a mut dyn DiscreteLegendre,
    closure: &'a dyn LinearClosure,
    t: f64,
    q0: &'a [f64],
    p0: &'a [f64],
}

impl System for Equations<'_> {
    fn dim(&self) -> usize {
        self.discrete.interior() + self.discrete.dim() + self.discrete.residuals()
    }

    fn residual(&mut self, h: f64, xz: &[f64], out: &mut [f64]) {
        let at = Interval { start: self.t, h };
        self.discrete.residual_equations(at, self.q0, xz, self.closure.weights(h), out);
        let (interior, carried) = (self.discrete.interior(), h * self.closure.carried());
        out[interior..].iter_mut().zip(self.p0).for_each(|(o, p)| *o -= carried * p);
    }

    fn derivative(&mut self, h: f64, xz: &[f64], out: &mut Jacobian) {
        let at = Interval { start: self.t, h };
        self.discrete.add_residual_derivative(at, self.q0, xz, self.closure.weights(h), out);
    }

    fn origin(&self, xz: &mut [f64]) {
        let (x, z) = xz.split_at_mut(self.discrete.interior() + self.q0.len());
        super::repeat(self.q0, x);
        z.fill(0.0);
    }

    fn limit(&self) -> LimitAtZero {
        LimitAtZero::Kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closure::{Linear, PositionMomentum};
    use crate::discrete::Galerkin;
    use crate::quadrature::Quadrature;
    use crate::{Lagrangian, LeastSquares, OneStep, Variational};

    const AT: Interval = Interval { start: 0.3, h: 0.1 };
    const Q0: [f64; 2] = [0.4, -0.3];

    /// On one node, on two and on three.
    fn paths() -> [Galerkin<impl Lagrangian>; 3] {
        let field = || {
            crate::field!(2, |t, v, dv| {
                dv[0] = v[1].sin() * v[0] + T::from(t);
                dv[1] = v[0] * v[0] * v[1] - v[0].exp();
            })
        };
        [Quadrature::gauss(1), Quadrature::radau(2), Quadrature::gauss(3)].map(|rule| {
            let (rule, lagrangian) = (rule.expect("nodes"), LeastSquares::new(field()).expect("dense"));
            Galerkin::new(lagrangian, rule.nodes().len(), &rule).expect("as many nodes as the degree")
        })
    }

    /// Where nothing is stiff both converge, to a few roundings.
    fn compare<C: LinearClosure>(closure: impl Fn() -> C) {
        for mut discrete in paths() {
            let (mut q, mut p) = (Q0, [0.02, -0.01]);
            let mut x = Q0.repeat(discrete.interior() / 2 + 1);
            let mut by = ByResiduals::new(&discrete, &closure()).expect("residuals");
            by.solve(&mut discrete, &closure(), AT, (&q, &p), &mut x).expect("mild");
            let mut method = Variational::new(discrete, closure());
            method.step(AT.start, AT.h, &mut q, &mut p).expect("mild");
            let is_same = method.unknowns().iter().zip(&x).all(|(a, b)| (a - b).abs() <= 1e-13);
            assert!(is_same, "{x:?}, {:?}", method.unknowns());
        }
    }

    #[test]
    fn steps_by_residuals_are_those_by_momenta() {
        compare(|| Linear::METHOD_I);
        compare(|| Linear::new(0.3, 0.7).expect("finite"));
        compare(|| PositionMomentum);
    }

    #[test]
    fn the_branch_starts_without_residuals_at_the_present_state() {
        for mut discrete in paths() {
            let (path, residuals) = (discrete.interior() + 2, discrete.residuals());
            assert_eq!(path, residuals, "as many nodes as the degree");
            let closure = Linear::METHOD_I;
            let equations = Equations { discrete: &mut discrete, closure: &closure, t: 0.0, q0: &Q0, p0: &[0.0; 2] };
            let mut xz = vec![f64::NAN; path + residuals];
            equations.origin(&mut xz);
            assert_eq!(xz, [Q0.repeat(path / 2), vec![0.0; residuals]].concat());
            assert_eq!(equations.dim(), xz.len());
        }
    }
}
