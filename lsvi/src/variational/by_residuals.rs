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
