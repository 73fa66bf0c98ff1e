//! Newton's method for closures of a nonlinear f, on assembled matrices.

use super::System;
use crate::closure::{Linear, LinearClosure};
use crate::discrete::Interval;
use crate::error::SolveError;
use crate::linalg::{Jacobian, Structure};
use crate::mass::Mass;
use crate::newton::{self, LimitAtZero, Newton, Work};
use crate::solver::{first, second, structure_of};

/// Newton's method on y = −M⁻¹(M v₁ − h f₁) and v₁, the branch that starts from (−v₀, v₀) at h = 0 followed in h.
///
/// With z = y + v₀ = −M⁻¹ h r₁ and d = M⁻¹ h r₀ the closure α p₀ + β p₁ = 0 is
/// (α + β) (M z − h r₀) − α h J₀ᵀ d − β h J₁ᵀ z = 0, and the other equation M (y + v₁) − h f₁ = 0.
#[derive(Debug)]
pub(super) struct FullNewton {
    newton: Newton,
    unknowns: Vec<f64>,
    residual: Vec<f64>,
    scratch: Scratch,
    /// Whether the last step was found.
    pub(super) is_in_use: bool,
}

#[derive(Debug)]
struct Scratch {
    /// J at the start and at the end of the step.
    start: Jacobian,
    end: Jacobian,
    /// Σ_i z_i ∂²f_i.
    curvature: Jacobian,
    f0: Vec<f64>,
    /// M⁻¹ f₀.
    rate: Vec<f64>,
    v1: Vec<f64>,
    z: Vec<f64>,
    /// y + v₁.
    sum: Vec<f64>,
    d: Vec<f64>,
    transposed: Vec<f64>,
    plain: Vec<f64>,
}

struct Equation<'a> {
    system: System<'a>,
    closure: &'a Linear,
    t: f64,
    v0: &'a [f64],
    s: &'a mut Scratch,
}

impl FullNewton {
    pub(super) fn new(dim: usize, [structure, curvature]: [&Structure; 2], mass: &Mass) -> Self {
        let zeros = vec![0.0; dim];
        Self {
            newton: Newton::with_structure(2 * dim, &structure_of(dim, structure, mass, Some(curvature))),
            unknowns: vec![0.0; 2 * dim],
            residual: vec![0.0; 2 * dim],
            is_in_use: false,
            scratch: Scratch {
                start: Jacobian::with_structure(dim, structure),
                end: Jacobian::with_structure(dim, structure),
                curvature: Jacobian::with_structure(dim, curvature),
                f0: zeros.clone(),
                rate: zeros.clone(),
                v1: zeros.clone(),
                z: zeros.clone(),
                sum: zeros.clone(),
                d: zeros.clone(),
                transposed: zeros.clone(),
                plain: zeros,
            },
        }
    }

    pub(super) fn solve(
        &mut self,
        (system, closure): (System<'_>, &Linear),
        at: Interval,
        v0: &[f64],
        v1: &mut [f64],
        work: &mut Work,
    ) -> Result<(), SolveError> {
        let s = &mut self.scratch;
        system.field.rhs(at.start, v0, &mut s.f0);
        if closure.weights(at.h).alpha != 0.0 {
            s.rate.copy_from_slice(&s.f0);
            system.mass_inverse.solve(&mut s.rate);
            s.start.clear();
            system.field.add_jacobian(at.start, v0, 1.0, &mut s.start);
        }
        for (pair, v) in self.unknowns.chunks_exact_mut(2).zip(v0) {
            pair.copy_from_slice(&[-v, *v]);
        }
        let mut equation = Equation { system, closure, t: at.start, v0, s };
        let solved = self.newton.solve(&mut equation, at.h, &mut self.unknowns);
        self.is_in_use = solved.is_ok();
        *work = Work { steps: work.steps, ..self.newton.work };
        for (v, pair) in v1.iter_mut().zip(self.unknowns.chunks_exact(2)) {
            *v = pair[1];
        }
        solved
    }

    /// f₀ and, where there is one, the matrix J₀.
    pub(super) fn start(&self) -> (&[f64], Option<&Jacobian>) {
        (&self.scratch.f0, Some(&self.scratch.start))
    }

    /// Writes p₁ at the solution: the equation of p₁ = 0 is −2h p₁ = 0.
    pub(super) fn momentum(&mut self, system: System<'_>, at: Interval, v0: &[f64], p: &mut [f64]) {
        let Self { unknowns, residual, scratch: s, .. } = self;
        let mut equation = Equation { system, closure: &Linear::METHOD_I, t: at.start, v0, s };
        newton::System::residual(&mut equation, at.h, unknowns, residual);
        for (p, pair) in p.iter_mut().zip(residual.chunks_exact(2)) {
            *p = -pair[0] / (2.0 * at.h);
        }
    }
}

impl Equation<'_> {
    /// What the closure's equation, of order h where α + β → 0, is multiplied by.
    fn row(&self, h: f64) -> f64 {
        if self.closure.has_limit() { 1.0 } else { h.recip() }
    }
}

impl newton::System for Equation<'_> {
    fn dim(&self) -> usize {
        2 * self.v0.len()
    }

    fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
        let row = self.row(h);
        let (mass, w, s) = (self.system.mass, self.closure.weights(h), &mut *self.s);
        let common = w.alpha + w.beta;
        for (i, pair) in x.chunks_exact(2).enumerate() {
            s.v1[i] = pair[1];
            s.z[i] = pair[0] + self.v0[i];
            s.sum[i] = pair[0] + pair[1];
            s.transposed[i] = common * h * s.f0[i];
        }
        s.end.clear();
        self.system.field.add_jacobian(self.t + h, &s.v1, 1.0, &mut s.end);
        s.end.mul_transpose_add(-w.beta * h, &s.z, &mut s.transposed);
        if common != 0.0 {
            mass.mul_add(common, &s.z, &mut s.transposed);
            mass.add_difference(-common, &s.v1, self.v0, &mut s.transposed);
        }
        if w.alpha != 0.0 {
            for (i, d) in s.d.iter_mut().enumerate() {
                *d = s.v1[i] - self.v0[i] - h * s.rate[i];
            }
            s.start.mul_transpose_add(-w.alpha * h, &s.d, &mut s.transposed);
        }
        self.system.field.rhs(self.t + h, &s.v1, &mut s.plain);
        s.plain.iter_mut().for_each(|x| *x *= -h);
        mass.mul_add(1.0, &s.sum, &mut s.plain);
        for ((pair, a), b) in out.chunks_exact_mut(2).zip(&s.transposed).zip(&s.plain) {
            pair.copy_from_slice(&[*a * row, *b]);
        }
    }

    fn derivative(&mut self, h: f64, _x: &[f64], out: &mut Jacobian) {
        let row = self.row(h);
        let (w, s) = (self.closure.weights(h), &mut *self.s);
        let common = w.alpha + w.beta;
        self.system.mass.for_each(self.v0.len(), |i, j, m| {
            out.add(second(i), first(j), m);
            out.add(second(i), second(j), m);
            out.add(first(i), first(j), row * common * m);
            out.add(first(i), second(j), -row * common * m);
        });
        s.end.for_each(|i, j, x| {
            out.add(second(i), second(j), -h * x);
            out.add(first(j), first(i), -row * w.beta * h * x);
        });
        out.inherit_outside(&s.end);
        if w.alpha != 0.0 {
            s.start.for_each(|i, j, x| out.add(first(j), second(i), -row * w.alpha * h * x));
            out.inherit_outside(&s.start);
        }
        s.curvature.clear();
        self.system.field.add_curvature(self.t + h, &s.v1, &s.z, -w.beta * h, &mut s.curvature);
        s.curvature.for_each(|j, k, x| out.add(first(j), second(k), row * x));
        out.inherit_outside(&s.curvature);
    }

    fn limit(&self) -> LimitAtZero {
        if self.closure.has_limit() { LimitAtZero::Kept } else { LimitAtZero::OfEachStep }
    }
}
