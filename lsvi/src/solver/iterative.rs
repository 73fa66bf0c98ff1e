//! Iterative solution of the linear systems of a step, with a preconditioner of the user's.

use std::fmt;

use super::krylov::{ConjugateGradients, Gmres, LeastSquaresSystem, Lsmr, System, axpy, dot};
use super::{Product, StepSolver};
use crate::error::{InputError, SettingError, SolveError};
use crate::linalg::Structure;
use crate::mass::{Mass, MassInverse};
use crate::operator::{Operator, Preconditioner, StepOperator};

/// On dissipative systems with P = B conjugate gradients gain a factor (√2 − 1)² per iteration, to rounding in 20; others, and
/// preconditioners further off, may need more.
const ITERATIONS: u32 = 500;
/// A preconditioner is renewed once it needs this many iterations and twice as many as at first.
const MANY: u32 = 12;

/// Krylov iterations with a [`Preconditioner`] P ≈ B: for matrix-free fields, and for sparse ones whose factors are dear.
///
/// The normal equations (M + BᵀM⁻¹B) x = b of Method I are solved by conjugate gradients preconditioned with PᵀM⁻¹P, or by LSMR,
/// which does not square the condition number; implicit stages, and closures with α ≠ 0, by GMRES. P is kept from step to step
/// until it has become slow.
///
/// The linear systems are solved in the norm of the preconditioner. A step is accepted if each equation by itself leaves its unknown no
/// error above the [tolerance](Self::with_tolerance); of a matrix-free field nothing but increments tells, and what P weighs little may be left unsolved.
///
/// There is no determinant here: that a root lies on the branch of the present state rests on the contraction of Newton's
/// iteration, or on the descent of Gauss–Newton's, alone.
pub struct Iterative<P> {
    preconditioner: P,
    normal: Normal,
    tolerance: f64,
    /// The s of the preconditioner, whether it was set up for the present B, and its first and its last number of iterations.
    prepared: Option<f64>,
    is_fresh: bool,
    first: Option<u32>,
    last: u32,
    work: Option<Work>,
}

/// How normal equations are solved.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Normal {
    ConjugateGradients,
    Lsmr,
}

#[derive(Debug)]
struct Work {
    cg: ConjugateGradients,
    /// Allocated when they are asked for.
    gmres: Option<Gmres>,
    lsmr: Option<Lsmr>,
    u: Vec<f64>,
    w: Vec<f64>,
    a: Vec<f64>,
    b: Vec<f64>,
}

impl<P: Preconditioner> Iterative<P> {
    /// Conjugate gradients on the normal equations, GMRES elsewhere, to a relative error of about 1e-10.
    pub fn new(preconditioner: P) -> Self {
        Self {
            preconditioner,
            normal: Normal::ConjugateGradients,
            tolerance: 1e-10,
            prepared: None,
            is_fresh: false,
            first: None,
            last: 0,
            work: None,
        }
    }

    /// LSMR on the normal equations, GMRES elsewhere.
    pub fn lsmr(preconditioner: P) -> Self {
        Self { normal: Normal::Lsmr, ..Self::new(preconditioner) }
    }

    /// The relative error to which steps are solved: of linear systems in their own norms, of Newton's increments relative to
    /// the largest component of the state. Inner iterations are stopped earlier where the outer ones gain nothing by more.
    ///
    /// # Errors
    /// [`SettingError::SolverTolerance`] unless it is in (0, 1).
    pub fn with_tolerance(self, tolerance: f64) -> Result<Self, InputError> {
        if !(tolerance > 0.0 && tolerance < 1.0) {
            return Err(InputError::Setting(SettingError::SolverTolerance(tolerance)));
        }
        Ok(Self { tolerance, ..self })
    }

    /// As [`new`](Self::new), to rounding error.
    pub(crate) fn to_rounding(preconditioner: P) -> Self {
        Self { tolerance: 1e-15, ..Self::new(preconditioner) }
    }

    /// The preconditioner.
    pub fn preconditioner(&self) -> &P {
        &self.preconditioner
    }
}

impl<P> fmt::Debug for Iterative<P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { normal, tolerance, .. } = self;
        f.debug_struct("Iterative").field("normal", normal).field("tolerance", tolerance).finish_non_exhaustive()
    }
}

impl Work {
    fn new(n: usize) -> Self {
        let zeros = vec![0.0; n];
        Self {
            cg: ConjugateGradients::new(n),
            gmres: None,
            lsmr: None,
            u: zeros.clone(),
            w: zeros.clone(),
            a: zeros.clone(),
            b: zeros,
        }
    }
}

impl<P: Preconditioner> Iterative<P> {
    /// Notes how many iterations the preconditioner has come to need.
    fn count(&mut self, iterations: u32) -> u64 {
        self.first.get_or_insert(iterations);
        self.last = iterations;
        u64::from(iterations)
    }
}

/// Writes N⁻¹ x, N = PᵀM⁻¹P.
fn precondition_normal(p: &mut impl Preconditioner, mass: &Mass, work: &mut [f64], x: &[f64], out: &mut [f64]) {
    work.copy_from_slice(x);
    p.solve_transpose(work);
    mass.multiply(work, out);
    p.solve(out);
}

impl<P: Preconditioner + Send> StepSolver for Iterative<P> {
    fn check(&self, structure: &Structure, mass: &Mass) -> Result<(), InputError> {
        self.preconditioner.check(structure, mass)
    }

    fn takes_products(&self) -> bool {
        true
    }

    fn prepare(&mut self, b: &StepOperator<'_>) -> Result<(), SolveError> {
        if self.work.is_none() {
            self.work = Some(Work::new(b.dim()));
        }
        let slow = self.last > MANY && self.first.is_some_and(|first| self.last > 2 * first);
        self.is_fresh = self.prepared != Some(b.s()) || slow;
        if self.is_fresh {
            self.prepared = None;
            self.preconditioner.prepare(b)?;
            (self.prepared, self.first, self.last) = (Some(b.s()), None, 0);
        }
        Ok(())
    }

    fn solve_stage(&mut self, b: &StepOperator<'_>, x: &mut [f64], tolerance: f64) -> Result<u64, SolveError> {
        let tolerance = tolerance.max(self.tolerance);
        let Some(work) = &mut self.work else { return Err(SolveError::NotAssembled) };
        let gmres = work.gmres.get_or_insert_with(|| Gmres::new(x.len()));
        let mut system = Stage { b, preconditioner: &mut self.preconditioner };
        let iterations = gmres.solve(&mut system, tolerance, ITERATIONS, x)?;
        Ok(self.count(iterations))
    }

    fn solve_normal(
        &mut self,
        b: &StepOperator<'_>,
        damping: f64,
        a: Option<&[f64]>,
        x: &mut [f64],
        tolerance: f64,
    ) -> Result<u64, SolveError> {
        let tolerance = tolerance.max(self.tolerance);
        let Some(Work { cg, lsmr, u, w, a: work_a, b: work_b, .. }) = &mut self.work else {
            return Err(SolveError::NotAssembled);
        };
        let mass_inverse = b.mass_inverse().ok_or(SolveError::SingularMass)?;
        let (p, mass) = (&mut self.preconditioner, b.mass());
        let iterations = match self.normal {
            Normal::ConjugateGradients => {
                if let Some(a) = a {
                    w.copy_from_slice(a);
                    mass_inverse.solve(w);
                    b.multiply_transpose(w, u);
                    axpy(1.0, u, x);
                }
                let is_exact = self.is_fresh && p.is_exact();
                let multiply = |direction: &[f64], image: &[f64], out: &mut [f64]| {
                    if is_exact {
                        out.copy_from_slice(image);
                    } else {
                        b.multiply(direction, work_a);
                        mass_inverse.solve(work_a);
                        b.multiply_transpose(work_a, out);
                    }
                    mass.mul_add(1.0 + damping, direction, out);
                };
                cg.solve(multiply, |r, z| precondition_normal(p, mass, work_b, r, z), tolerance, ITERATIONS, x)?
            }
            Normal::Lsmr => {
                // The least-squares problem whose normal equations these are has the right-hand side (M⁻¹ b/(1 + μ), a).
                u.copy_from_slice(x);
                mass_inverse.solve(u);
                u.iter_mut().for_each(|u| *u /= 1.0 + damping);
                match a {
                    Some(a) => w.copy_from_slice(a),
                    None => w.fill(0.0),
                }
                let mut system =
                    Stacked { b, preconditioner: p, mass_inverse, weight: 1.0 + damping, a: work_a, b_work: work_b };
                let norm = system.norm(u, w);
                let lsmr = lsmr.get_or_insert_with(|| Lsmr::new(x.len()));
                lsmr.solve(&mut system, (u, w, norm), tolerance, ITERATIONS, x)?
            }
        };
        Ok(self.count(iterations))
    }

    fn solve_closure(
        &mut self,
        b: &StepOperator<'_>,
        matrix: Product<'_>,
        x: &mut [f64],
        tolerance: f64,
    ) -> Result<u64, SolveError> {
        let tolerance = tolerance.max(self.tolerance);
        let Some(Work { gmres, a, .. }) = &mut self.work else { return Err(SolveError::NotAssembled) };
        let gmres = gmres.get_or_insert_with(|| Gmres::new(x.len()));
        let mut system = Closure { matrix, mass: b.mass(), preconditioner: &mut self.preconditioner, work: a };
        let iterations = gmres.solve(&mut system, tolerance, ITERATIONS, x)?;
        Ok(self.count(iterations))
    }

    fn tolerance(&self) -> f64 {
        self.tolerance
    }
}

/// B, preconditioned by P.
struct Stage<'a, P> {
    b: &'a StepOperator<'a>,
    preconditioner: &'a mut P,
}

impl<P: Preconditioner> System for Stage<'_, P> {
    fn multiply(&mut self, x: &[f64], out: &mut [f64]) {
        self.b.multiply(x, out);
    }

    fn precondition(&mut self, x: &[f64], out: &mut [f64]) {
        out.copy_from_slice(x);
        self.preconditioner.solve(out);
    }
}

/// The derivative of a closure, preconditioned by PᵀM⁻¹P.
struct Closure<'a, P> {
    matrix: Product<'a>,
    mass: &'a Mass,
    preconditioner: &'a mut P,
    work: &'a mut [f64],
}

impl<P: Preconditioner> System for Closure<'_, P> {
    fn multiply(&mut self, x: &[f64], out: &mut [f64]) {
        (self.matrix)(x, out);
    }

    fn precondition(&mut self, x: &[f64], out: &mut [f64]) {
        precondition_normal(self.preconditioner, self.mass, self.work, x, out);
    }
}

/// x ↦ (x, B x) in the norms of (1 + μ) M and M⁻¹.
struct Stacked<'a, P> {
    b: &'a StepOperator<'a>,
    preconditioner: &'a mut P,
    mass_inverse: &'a MassInverse,
    /// 1 + μ.
    weight: f64,
    a: &'a mut [f64],
    b_work: &'a mut [f64],
}

impl<P: Preconditioner> Stacked<'_, P> {
    fn norm(&mut self, u: &[f64], w: &[f64]) -> f64 {
        self.b.mass().multiply(u, self.a);
        self.b_work.copy_from_slice(w);
        self.mass_inverse.solve(self.b_work);
        (self.weight * dot(u, self.a) + dot(w, self.b_work)).max(0.0).sqrt()
    }
}

impl<P: Preconditioner> LeastSquaresSystem for Stacked<'_, P> {
    fn forward(&mut self, x: &[f64], a: f64, u: &mut [f64], w: &mut [f64]) -> f64 {
        self.b.multiply(x, self.a);
        w.iter_mut().zip(&*self.a).for_each(|(w, b)| *w = b - a * *w);
        u.iter_mut().zip(x).for_each(|(u, x)| *u = x - a * *u);
        self.norm(u, w)
    }

    fn adjoint(&mut self, u: &[f64], w: &[f64], out: &mut [f64]) {
        self.a.copy_from_slice(w);
        self.mass_inverse.solve(self.a);
        self.b.multiply_transpose(self.a, out);
        self.b.mass().mul_add(self.weight, u, out);
    }

    fn precondition(&mut self, x: &[f64], out: &mut [f64]) {
        precondition_normal(self.preconditioner, self.b.mass(), self.a, x, out);
    }
}
