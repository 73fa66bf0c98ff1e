//! Newton's method for closures of any f by products, for iterative solvers.

use super::System;
use crate::closure::{Linear, LinearClosure};
use crate::discrete::Interval;
use crate::error::SolveError;
use crate::inexact::{InexactNewton, InexactSystem};
use crate::linalg::{Jacobian, Structure};
use crate::newton::Work;
use crate::operator::{Operator, StepOperator};
use crate::solver::StepSolver;
use crate::vector_field::VectorField;

/// Newton's method for v₁ on (α + β) h (r₀ + r₁) + α h J₀ᵀM⁻¹ h r₀ − β h J₁ᵀM⁻¹ h r₁ = 0, 2h times the closure.
///
/// Its derivative (α + β)(M + B) + α h J₀ᵀ − β h J₁ᵀM⁻¹B − β h Σ_i (M⁻¹ h r₁)_i ∂²f_i is known by products only.
#[derive(Debug)]
pub(super) struct ClosedStep {
    newton: InexactNewton,
    solver: Box<dyn StepSolver>,
    matrices: Option<Matrices>,
    work: Scratch,
    left: Vec<f64>,
}

/// What there is to multiply with of a field that assembles its derivatives.
#[derive(Debug)]
struct Matrices {
    start: Jacobian,
    end: Jacobian,
    b: Jacobian,
    curvature: Jacobian,
}

#[derive(Debug)]
struct Scratch {
    f0: Vec<f64>,
    /// M⁻¹ h r₀ and M⁻¹ h r₁.
    d0: Vec<f64>,
    d1: Vec<f64>,
    product: Vec<f64>,
    image: Vec<f64>,
}

struct Equation<'a> {
    system: System<'a>,
    closure: &'a Linear,
    t: f64,
    v0: &'a [f64],
    solver: &'a mut dyn StepSolver,
    matrices: &'a mut Option<Matrices>,
    s: &'a mut Scratch,
    left: &'a mut [f64],
}

impl ClosedStep {
    pub(super) fn new(dim: usize, [structure, curvature]: [&Structure; 2], solver: Box<dyn StepSolver>) -> Self {
        let matrix = || Jacobian::with_structure(dim, structure);
        let zeros = vec![0.0; dim];
        Self {
            newton: InexactNewton::new(dim),
            solver,
            matrices: (*structure != Structure::MatrixFree).then(|| Matrices {
                start: matrix(),
                end: matrix(),
                b: matrix(),
                curvature: Jacobian::with_structure(dim, curvature),
            }),
            work: Scratch {
                f0: zeros.clone(),
                d0: zeros.clone(),
                d1: zeros.clone(),
                product: zeros.clone(),
                image: zeros.clone(),
            },
            left: zeros,
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
        system.field.rhs(at.start, v0, &mut self.work.f0);
        if let Some(m) = &mut self.matrices {
            m.start.clear();
            system.field.add_jacobian(at.start, v0, 1.0, &mut m.start);
            m.start.check_structure()?;
        }
        v1.copy_from_slice(v0);
        let mut equation = Equation {
            system,
            closure,
            t: at.start,
            v0,
            solver: &mut *self.solver,
            matrices: &mut self.matrices,
            s: &mut self.work,
            left: &mut self.left,
        };
        let solved = self.newton.solve(&mut equation, at.h, v1);
        *work = Work { steps: work.steps, ..self.newton.work };
        solved
    }

    /// f₀ and, where there is one, the matrix J₀.
    pub(super) fn start(&self) -> (&[f64], Option<&Jacobian>) {
        (&self.work.f0, self.matrices.as_ref().map(|m| &m.start))
    }

    /// Writes p₁ at the solution.
    pub(super) fn momentum(&mut self, system: System<'_>, at: Interval, v0: &[f64], v1: &[f64], p: &mut [f64]) {
        let Self { solver, matrices, work: s, left, .. } = self;
        let closure = &Linear::METHOD_I;
        let mut equation = Equation { system, closure, t: at.start, v0, solver: &mut **solver, matrices, s, left };
        equation.residual(at.h, v1, p);
        p.iter_mut().for_each(|p| *p /= 2.0 * at.h);
    }
}

/// Writes Jᵀ w by the matrix, if there is one.
fn transpose(field: &dyn VectorField, matrix: Option<&Jacobian>, (t, v): (f64, &[f64]), w: &[f64], out: &mut [f64]) {
    match matrix {
        Some(matrix) => matrix.multiply_transpose(w, out),
        None => field.apply_transpose(t, v, w, out),
    }
}

/// The derivative of the equation at v₁ = x, where its residual was taken last.
#[derive(Clone, Copy)]
struct Linearised<'a> {
    system: System<'a>,
    closure: &'a Linear,
    t: f64,
    v0: &'a [f64],
    h: f64,
    x: &'a [f64],
}

impl Linearised<'_> {
    /// B.
    fn operator<'b>(&'b self, matrices: Option<&'b Matrices>) -> StepOperator<'b> {
        self.system.operator((self.t + self.h, self.x), self.h, matrices.map(|m| &m.b))
    }

    /// Writes the product of the derivative with `y`.
    fn multiply(&self, matrices: Option<&Matrices>, s: &mut Scratch, y: &[f64], out: &mut [f64]) {
        let Self { system: System { field, mass, mass_inverse }, closure, t, v0, h, x } = *self;
        let w = closure.weights(h);
        let common = w.alpha + w.beta;
        self.operator(matrices).multiply(y, &mut s.image);
        for (o, i) in out.iter_mut().zip(&s.image) {
            *o = common * i;
        }
        mass.mul_add(common, y, out);
        if w.alpha != 0.0 {
            transpose(field, matrices.map(|m| &m.start), (t, v0), y, &mut s.product);
            out.iter_mut().zip(&s.product).for_each(|(o, p)| *o += w.alpha * h * p);
        }
        if w.beta != 0.0 {
            mass_inverse.solve(&mut s.image);
            transpose(field, matrices.map(|m| &m.end), (t + h, x), &s.image, &mut s.product);
            out.iter_mut().zip(&s.product).for_each(|(o, p)| *o -= w.beta * h * p);
            match matrices {
                Some(m) => m.curvature.multiply(y, &mut s.product),
                None => field.apply_curvature(t + h, x, &s.d1, y, &mut s.product),
            }
            out.iter_mut().zip(&s.product).for_each(|(o, p)| *o -= w.beta * h * p);
        }
    }
}

impl InexactSystem for Equation<'_> {
    fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
        let (System { field, mass, mass_inverse }, w, s) = (&self.system, self.closure.weights(h), &mut *self.s);
        let common = w.alpha + w.beta;
        if let Some(m) = &mut *self.matrices {
            m.end.clear();
            field.add_jacobian(self.t + h, x, 1.0, &mut m.end);
        }
        field.rhs(self.t + h, x, &mut s.d1);
        for (((o, d0), d1), f0) in out.iter_mut().zip(&mut s.d0).zip(&mut s.d1).zip(&s.f0) {
            *o = -common * h * (f0 + *d1);
            *d0 = -h * f0;
            *d1 *= -h;
        }
        mass.add_difference(2.0 * common, x, self.v0, out);
        for d in [&mut s.d0, &mut s.d1] {
            mass.add_difference(1.0, x, self.v0, d);
            mass_inverse.solve(d);
        }
        let start = self.matrices.as_ref().map(|m| &m.start);
        transpose(*field, start, (self.t, self.v0), &s.d0, &mut s.product);
        out.iter_mut().zip(&s.product).for_each(|(o, p)| *o += w.alpha * h * p);
        let end = self.matrices.as_ref().map(|m| &m.end);
        transpose(*field, end, (self.t + h, x), &s.d1, &mut s.product);
        out.iter_mut().zip(&s.product).for_each(|(o, p)| *o -= w.beta * h * p);
    }

    fn solve(&mut self, h: f64, x: &[f64], residual: &mut [f64], tolerance: f64) -> Result<u64, SolveError> {
        let System { field, mass, .. } = &self.system;
        if let Some(Matrices { end, b, curvature, .. }) = &mut *self.matrices {
            end.check_structure()?;
            b.clear();
            mass.add_to(1.0, b);
            end.for_each(|i, j, x| b.add(i, j, -h * x));
            b.check_structure()?;
            curvature.clear();
            field.add_curvature(self.t + h, x, &self.s.d1, 1.0, curvature);
            curvature.check_structure()?;
        }
        let at = Linearised { system: self.system, closure: self.closure, t: self.t, v0: self.v0, h, x };
        let (matrices, s) = (self.matrices.as_ref(), &mut *self.s);
        let b = at.operator(matrices);
        self.solver.prepare(&b)?;
        let mut derivative = |y: &[f64], out: &mut [f64]| at.multiply(matrices, s, y, out);
        self.solver.solve_closure(&b, &mut derivative, residual, tolerance)
    }

    /// By the diagonal of |α| (M + B) + |β| (M + BᵀM⁻¹B), from which the derivative differs by terms of lower order in h f_v.
    fn is_solved_to(&mut self, error: f64, (h, x): (f64, &[f64]), y: &[f64], residual: &[f64]) -> bool {
        let Some(matrices) = &*self.matrices else { return true };
        let (w, s, left) = (self.closure.weights(h), &mut *self.s, &mut *self.left);
        let at = Linearised { system: self.system, closure: self.closure, t: self.t, v0: self.v0, h, x };
        at.multiply(Some(matrices), s, y, left);
        left.iter_mut().zip(residual).for_each(|(left, f)| *left -= f);
        self.system.diagonals(&matrices.b, &mut s.image, &mut s.product);
        s.product.iter_mut().zip(&s.image).for_each(|(d, m)| *d = w.beta.abs() * *d + w.alpha.abs() * m);
        matrices.b.for_each(|i, j, x| {
            if i == j {
                s.product[i] += w.alpha.abs() * x.abs()
            }
        });
        left.iter().zip(&s.product).all(|(left, diagonal)| left.abs() <= diagonal * error)
    }

    fn tolerance(&self) -> f64 {
        self.solver.tolerance()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mass::Mass;
    use crate::operator::Factored;
    use crate::solver::Iterative;

    /// With h = ½, M = diag(2, ½) and B = (−3.5 −0.5; −1 3) the diagonal of M + BᵀM⁻¹B is (10.125, 18.625), so that of ½ (M + |B|) + 2 (M + BᵀM⁻¹B)
    /// is (23, 39).
    #[test]
    fn each_equation_is_held_to_the_diagonal_of_what_the_derivative_is_like() {
        let field = crate::field!(2, |_t, v, dv| {
            dv[0] = v[0] * 11.0 + v[1];
            dv[1] = v[0] * 2.0 - v[1] * 5.0;
        });
        let (mass, h, x) = (Mass::Diagonal(vec![2.0, 0.5]), 0.5, [0.0; 2]);
        let mass_inverse = mass.metric(2).expect("positive");
        let system = System { field: &field as &dyn VectorField, mass: &mass, mass_inverse: &mass_inverse };
        let closure = Linear::new(-0.5, 2.0).expect("finite");
        let solver = Box::new(Iterative::new(Factored::default()));
        let mut step = ClosedStep::new(2, [&Structure::Dense, &Structure::Dense], solver);
        let ClosedStep { solver, matrices, work: s, left, .. } = &mut step;
        system.set_b(h, h, &x, &mut matrices.as_mut().expect("assembled").b);
        let (closure, v0) = (&closure, &x[..]);
        let mut equation = Equation { system, closure, t: 0.0, v0, solver: &mut **solver, matrices, s, left };
        // The solution 0 leaves all of a residual.
        let error = 1.0 / 1024.0;
        let mut is_solved = |residual: [f64; 2]| equation.is_solved_to(error, (h, &x), &[0.0; 2], &residual);
        for (residual, off) in [([23.0, -39.0], 0), ([23.0, 39.0], 1), ([-23.0, 0.0], 0), ([0.0, -39.0], 1)] {
            let mut residual = residual.map(|r| r * error);
            assert!(is_solved(residual), "{residual:?}");
            residual[off] *= 1.0 + 1e-12;
            assert!(!is_solved(residual), "{residual:?}");
        }
    }
}
