//! Newton's method for a nonlinear f in the augmented formulation.

use super::System;
use super::augmented::{add_b, first, second, structure_of};
use crate::discrete::Interval;
use crate::error::SolveError;
use crate::linalg::{Jacobian, Structure};
use crate::mass::Mass;
use crate::newton::{self, Newton, Work};
use crate::vector_field::VectorField;

/// Newton's method on y = −M⁻¹(M v₁ − h f₁) and v₁, the branch that starts from (−v₀, v₀) at h = 0 followed in h:
/// B₁ᵀ (y + v₀) − M (v₁ − v₀) + h f₀ = 0 and M (y + v₁) − h f₁ = 0.
#[derive(Debug)]
pub(super) struct FullNewton {
    newton: Newton,
    unknowns: Vec<f64>,
    scratch: Scratch,
}

#[derive(Debug)]
struct Scratch {
    /// B₁ = M − h f_v(t₁, v₁).
    b: Jacobian,
    /// −h Σ_i (y + v₀)_i ∂²f_i.
    curvature: Jacobian,
    f0: Vec<f64>,
    v1: Vec<f64>,
    /// y + v₀.
    shifted: Vec<f64>,
    /// y + v₁.
    sum: Vec<f64>,
    transposed: Vec<f64>,
    plain: Vec<f64>,
}

struct Equation<'a, F> {
    system: System<'a, F>,
    t: f64,
    v0: &'a [f64],
    s: &'a mut Scratch,
}

impl FullNewton {
    pub(super) fn new(dim: usize, structure: &Structure, mass: &Mass) -> Self {
        let gram = structure.gram(dim);
        let zeros = vec![0.0; dim];
        Self {
            newton: Newton::with_structure(2 * dim, &structure_of(dim, structure, mass, Some(&gram))),
            unknowns: vec![0.0; 2 * dim],
            scratch: Scratch {
                b: Jacobian::with_structure(dim, structure),
                curvature: Jacobian::with_structure(dim, &gram),
                f0: zeros.clone(),
                v1: zeros.clone(),
                shifted: zeros.clone(),
                sum: zeros.clone(),
                transposed: zeros.clone(),
                plain: zeros,
            },
        }
    }

    pub(super) fn solve<F: VectorField>(
        &mut self,
        system: System<'_, F>,
        at: Interval,
        v0: &[f64],
        v1: &mut [f64],
        work: &mut Work,
    ) -> Result<(), SolveError> {
        system.field.rhs(at.t, v0, &mut self.scratch.f0);
        for (pair, v) in self.unknowns.chunks_exact_mut(2).zip(v0) {
            pair.copy_from_slice(&[-v, *v]);
        }
        let mut equation = Equation { system, t: at.t, v0, s: &mut self.scratch };
        let solved = self.newton.solve(&mut equation, at.h, &mut self.unknowns);
        *work = Work { steps: work.steps, ..self.newton.work };
        for (v, pair) in v1.iter_mut().zip(self.unknowns.chunks_exact(2)) {
            *v = pair[1];
        }
        solved
    }
}

impl<F: VectorField> newton::System for Equation<'_, F> {
    fn dim(&self) -> usize {
        2 * self.v0.len()
    }

    fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
        let (mass, s) = (self.system.mass, &mut *self.s);
        for (i, pair) in x.chunks_exact(2).enumerate() {
            s.v1[i] = pair[1];
            s.shifted[i] = pair[0] + self.v0[i];
            s.sum[i] = pair[0] + pair[1];
            s.transposed[i] = h * s.f0[i];
        }
        self.system.set_b(self.t + h, h, &s.v1, &mut s.b);
        s.b.mul_transpose_add(1.0, &s.shifted, &mut s.transposed);
        mass.add_difference(-1.0, &s.v1, self.v0, &mut s.transposed);
        self.system.field.rhs(self.t + h, &s.v1, &mut s.plain);
        s.plain.iter_mut().for_each(|x| *x *= -h);
        mass.mul_add(1.0, &s.sum, &mut s.plain);
        for ((pair, a), b) in out.chunks_exact_mut(2).zip(&s.transposed).zip(&s.plain) {
            pair.copy_from_slice(&[*a, *b]);
        }
    }

    fn derivative(&mut self, h: f64, _x: &[f64], out: &mut Jacobian) {
        let s = &mut *self.s;
        add_b(&s.b, out);
        out.inherit_outside(&s.b);
        self.system.mass.for_each(self.v0.len(), |i, j, m| {
            out.add(second(i), first(j), m);
            out.add(first(i), second(j), -m);
        });
        s.curvature.clear();
        self.system.field.add_curvature(self.t + h, &s.v1, &s.shifted, -h, &mut s.curvature);
        s.curvature.for_each(|j, k, x| out.add(first(j), second(k), x));
        out.inherit_outside(&s.curvature);
    }

    fn keeps_orientation(&self) -> bool {
        true
    }
}
