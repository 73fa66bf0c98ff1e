//! Newton's method for closures of a nonlinear f, on dense matrices.

use super::System;
use super::newton::FullNewton;
use crate::closure::{Linear, LinearClosure};
use crate::discrete::{Interval, MomentumWeights};
use crate::error::SolveError;
use crate::linalg::{Jacobian, Structure};
use crate::mass::Mass;
use crate::newton::{self, LimitAtZero, Newton, Work, are_unlike};
use crate::vector_field::VectorField;

/// Newton's method for v₁ on (α + β) h (r₀ + r₁) + α h J₀ᵀM⁻¹ h r₀ − β h J₁ᵀM⁻¹ h r₁ = 0, 2h times the closure.
///
/// Its derivative is (α + β) (2M − h J₁) + α h J₀ᵀ − β h J₁ᵀ + β h J₁ᵀM⁻¹ h J₁ − β h Σ_i (M⁻¹ h r₁)_i ∂²f_i.
#[derive(Debug)]
pub(super) struct DenseStep {
    newton: Newton,
    /// The equations in which no J is squared; none before the first step that needs them.
    augmented: Option<Box<FullNewton>>,
    of_augmented: Work,
    scratch: Scratch,
}

#[derive(Debug)]
struct Scratch {
    /// J at the start and at the end of the step.
    start: Jacobian,
    end: Jacobian,
    f0: Vec<f64>,
    f1: Vec<f64>,
    /// M⁻¹ h r₀ and M⁻¹ h r₁.
    d0: Vec<f64>,
    d1: Vec<f64>,
    column: Vec<f64>,
    momentum: Vec<f64>,
}

struct Equation<'a, F> {
    system: System<'a, F>,
    closure: &'a Linear,
    t: f64,
    /// The whole step, with the closure's weights and the factor of its row.
    h: f64,
    weights: MomentumWeights,
    row: f64,
    v0: &'a [f64],
    s: &'a mut Scratch,
}

impl DenseStep {
    pub(super) fn new(dim: usize) -> Self {
        let zeros = vec![0.0; dim];
        Self {
            newton: Newton::new(dim),
            augmented: None,
            of_augmented: Work::default(),
            scratch: Scratch {
                start: Jacobian::zeros(dim),
                end: Jacobian::zeros(dim),
                f0: zeros.clone(),
                f1: zeros.clone(),
                d0: zeros.clone(),
                d1: zeros.clone(),
                column: zeros.clone(),
                momentum: zeros,
            },
        }
    }

    pub(super) fn solve<F: VectorField>(
        &mut self,
        (system, closure): (System<'_, F>, &Linear),
        at: Interval,
        v0: &[f64],
        v1: &mut [f64],
        work: &mut Work,
    ) -> Result<(), SolveError> {
        let (n, s) = (system.field.dim(), &mut self.scratch);
        let (v0, v1) = (&v0[..n], &mut v1[..n]);
        if closure.weights(at.h).alpha == 0.0 {
            system.field.rhs(at.start, v0, &mut s.f0);
        } else {
            s.start.clear();
            system.field.linearize(at.start, v0, &mut s.f0, 1.0, &mut s.start);
            s.start.check_structure()?;
        }
        let is_augmented = self.augmented.as_ref().is_some_and(|augmented| augmented.is_in_use);
        let found = if is_augmented && self.solve_augmented((system, closure), at, v0, v1) {
            Ok(())
        } else {
            let found = self.solve_condensed((system, closure), at, v0, v1);
            match found {
                Err(error) if error.is_lost() && self.solve_augmented((system, closure), at, v0, v1) => Ok(()),
                found => found,
            }
        };
        *work = Work { steps: work.steps, ..self.newton.work + self.of_augmented };
        found
    }

    /// By the closure's own n equations.
    #[inline]
    fn solve_condensed<F: VectorField>(
        &mut self,
        (system, closure): (System<'_, F>, &Linear),
        at: Interval,
        v0: &[f64],
        v1: &mut [f64],
    ) -> Result<(), SolveError> {
        v1.copy_from_slice(v0);
        let mut equation = Equation::new(system, closure, at, v0, &mut self.scratch);
        if !self.newton.solve_with_kept(&mut equation, at.h, v1) {
            self.newton.solve(&mut equation, at.h, v1)?;
            self.newton.keep(&mut equation, at.h, v1);
        }
        // The matrix of the last residual, which kept factors have not met.
        Ok(self.scratch.end.check_structure()?)
    }

    /// By twice as many in which no J is squared, where unlike units may be what hides the branch; false where there is no root either.
    #[cold]
    fn solve_augmented<F: VectorField>(
        &mut self,
        (system, closure): (System<'_, F>, &Linear),
        at: Interval,
        v0: &[f64],
        v1: &mut [f64],
    ) -> bool {
        if !closure.has_limit() {
            return false;
        }
        let System { field, mass, mass_inverse } = system;
        if self.augmented.as_ref().is_none_or(|augmented| !augmented.is_in_use) {
            let end = &mut self.scratch.end;
            end.clear();
            field.add_jacobian(at.start, v0, 1.0, end);
            if !are_unlike(end) {
                return false;
            }
        }
        let augmented =
            self.augmented.get_or_insert_with(|| Box::new(FullNewton::new(v0.len(), [&Structure::Dense; 2], mass)));
        let system = System { field: field as &dyn VectorField, mass, mass_inverse };
        augmented.solve((system, closure), at, v0, v1, &mut self.of_augmented).is_ok()
    }

    /// f₀ and, where there is one, the matrix J₀.
    pub(super) fn start(&self) -> (&[f64], Option<&Jacobian>) {
        (&self.scratch.f0, Some(&self.scratch.start))
    }

    /// Writes p₁ at the solution.
    pub(super) fn momentum<F: VectorField>(
        &mut self,
        system: System<'_, F>,
        at: Interval,
        v0: &[f64],
        v1: &[f64],
        p: &mut [f64],
    ) {
        let closure = &Linear::METHOD_I;
        let mut equation = Equation::new(system, closure, at, v0, &mut self.scratch);
        newton::System::residual(&mut equation, at.h, v1, p);
        p.iter_mut().for_each(|p| *p /= 2.0 * at.h);
    }
}

impl<'a, F: VectorField> Equation<'a, F> {
    #[inline(always)]
    fn new(
        system: System<'a, F>,
        closure: &'a Linear,
        Interval { start: t, h }: Interval,
        v0: &'a [f64],
        s: &'a mut Scratch,
    ) -> Self {
        Self { system, closure, t, h, weights: closure.weights(h), row: row(closure, h), v0, s }
    }

    /// [`newton::System::residual`] of N unknowns in the unit metric, with all numbers on the stack; of a matrix that is not dense
    /// none.
    #[inline(always)]
    fn residual_small<const N: usize>(&mut self, h: f64, x: &[f64], out: &mut [f64]) -> Option<()> {
        let (w, row) = self.weights(h);
        let s = &mut *self.s;
        // Copies, for a number of which a function that is not inlined sees the place is stored and loaded again.
        let (x, v0, f0) = (*x.first_chunk::<N>()?, *self.v0.first_chunk::<N>()?, *s.f0.first_chunk::<N>()?);
        let out = out.first_chunk_mut::<N>()?;
        let mut f1 = [0.0; N];
        s.end.clear_sized::<N>();
        self.system.field.linearize(self.t + h, &x, &mut f1, 1.0, &mut s.end);
        let j1 = s.end.dense()?.as_slice().get(..N * N)?;
        let (mut d0, mut d1, mut at_start) = ([0.0; N], [0.0; N], [0.0; N]);
        for i in 0..N {
            let moved = x[i] - v0[i];
            d0[i] = moved - h * f0[i];
            d1[i] = moved - h * f1[i];
        }
        if w.alpha != 0.0 {
            let j0 = s.start.dense()?.as_slice().get(..N * N)?;
            for j in 0..N {
                for i in 0..N {
                    at_start[j] += j0[j * N + i] * d0[i];
                }
            }
        }
        let common = w.alpha + w.beta;
        for j in 0..N {
            let mut at_end = 0.0;
            for i in 0..N {
                at_end += j1[j * N + i] * d1[i];
            }
            out[j] = row * (common * (d0[j] + d1[j]) + h * (w.alpha * at_start[j] - w.beta * at_end));
        }
        Some(())
    }

    /// The closure's weights at step size `h` and the factor of its row.
    #[inline(always)]
    fn weights(&self, h: f64) -> (MomentumWeights, f64) {
        if h == self.h { (self.weights, self.row) } else { (self.closure.weights(h), row(self.closure, h)) }
    }
}

/// What the closure's equation, of order h where α + β → 0, is multiplied by.
#[inline]
fn row(closure: &Linear, h: f64) -> f64 {
    if closure.has_limit() { 1.0 } else { h.recip() }
}

impl<F: VectorField> newton::System for Equation<'_, F> {
    fn dim(&self) -> usize {
        self.system.field.dim()
    }

    fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
        let (w, row) = self.weights(h);
        let (System { field, mass, mass_inverse }, s) = (&self.system, &mut *self.s);
        let common = w.alpha + w.beta;
        s.end.clear();
        field.linearize(self.t + h, x, &mut s.f1, 1.0, &mut s.end);
        for (((o, d0), d1), (f0, f1)) in out.iter_mut().zip(&mut s.d0).zip(&mut s.d1).zip(s.f0.iter().zip(&s.f1)) {
            *o = -common * h * (f0 + f1);
            *d0 = -h * f0;
            *d1 = -h * f1;
        }
        mass.add_difference(2.0 * common, x, self.v0, out);
        mass.add_difference(1.0, x, self.v0, &mut s.d1);
        mass_inverse.solve(&mut s.d1);
        s.end.mul_transpose_add(-w.beta * h, &s.d1, out);
        if w.alpha != 0.0 {
            mass.add_difference(1.0, x, self.v0, &mut s.d0);
            mass_inverse.solve(&mut s.d0);
            s.start.mul_transpose_add(w.alpha * h, &s.d0, out);
        }
        if row != 1.0 {
            out.iter_mut().for_each(|o| *o *= row);
        }
    }

    #[inline(always)]
    fn residual_sized<const N: usize>(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
        let is_small = N > 0 && matches!(self.system.mass, Mass::Identity);
        if is_small && self.residual_small::<N>(h, x, out).is_some() {
            return;
        }
        match (x.first_chunk::<N>(), out.first_chunk_mut::<N>()) {
            (Some(&from), Some(to)) if N > 0 => {
                // A function that is not inlined sees a copy, so that `x` and `out` stay in registers on the way above.
                let mut copy = *to;
                self.residual(h, &from, &mut copy);
                *to = copy;
            }
            _ => self.residual(h, x, out),
        }
    }

    fn derivative(&mut self, h: f64, x: &[f64], out: &mut Jacobian) {
        let (w, row) = self.weights(h);
        let s = &mut *self.s;
        let (common, beta) = (row * (w.alpha + w.beta), row * w.beta * h);
        self.system.mass.add_to(2.0 * common, out);
        s.end.for_each(|i, j, x| {
            out.add(i, j, -common * h * x);
            out.add(j, i, -beta * x);
        });
        out.inherit_outside(&s.end);
        if w.alpha != 0.0 {
            s.start.for_each(|i, j, x| out.add(j, i, row * w.alpha * h * x));
            out.inherit_outside(&s.start);
        }
        if beta != 0.0 {
            for j in 0..x.len() {
                for (i, column) in s.column.iter_mut().enumerate() {
                    *column = h * s.end.get(i, j);
                }
                self.system.mass_inverse.solve(&mut s.column);
                s.momentum.fill(0.0);
                s.end.mul_transpose_add(beta, &s.column, &mut s.momentum);
                s.momentum.iter().enumerate().for_each(|(i, x)| out.add(i, j, *x));
            }
            self.system.field.add_curvature(self.t + h, x, &s.d1, -beta, out);
        }
    }

    fn is_affine(&self) -> bool {
        self.system.field.is_linear()
    }

    fn limit(&self) -> LimitAtZero {
        if self.closure.has_limit() { LimitAtZero::Kept } else { LimitAtZero::OfEachStep }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AutoField, FieldFn, Scalar};

    /// N coupled unknowns, nothing linear.
    struct Ring<const N: usize>;

    impl<const N: usize> FieldFn for Ring<N> {
        fn dim(&self) -> usize {
            N
        }
        fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
            for i in 0..N {
                dv[i] = (v[i] + t).sin() * (1.0 + i as f64) - v[(i + 1) % N] * v[i];
            }
        }
    }

    fn compare<const N: usize>(closure: &Linear) {
        let (field, mass, inverse) =
            (AutoField::new(Ring::<N>), Mass::Identity, Mass::Identity.metric(N).expect("fits"));
        let (at, mut step) = (Interval { start: 0.3, h: 0.7 }, DenseStep::new(N));
        let [v0, x] = [0.4, -0.9].map(|phase| std::array::from_fn::<_, N, _>(|i| (1.3 * i as f64 + phase).cos()));
        let s = &mut step.scratch;
        field.linearize(at.start, &v0, &mut s.f0, 1.0, &mut s.start);
        let system = System { field: &field, mass: &mass, mass_inverse: &inverse };
        let mut equation = Equation::new(system, closure, at, &v0, s);
        let (mut small, mut any) = ([0.0; N], [0.0; N]);
        assert!(equation.residual_small::<N>(at.h, &x, &mut small).is_some(), "{N} unknowns have one");
        newton::System::residual(&mut equation, at.h, &x, &mut any);
        // Sums of N products of numbers of a few units, in another order.
        for (small, any) in small.iter().zip(any) {
            assert!((small - any).abs() <= 64.0 * N as f64 * f64::EPSILON, "{N}: {small}, {any}");
        }
    }

    #[test]
    fn the_residual_of_a_few_unknowns_is_that_of_any_number() {
        let rising = Linear::of_step(|h| (h - 1.0, 1.0)).expect("a limit");
        for closure in [Linear::METHOD_I, Linear::METHOD_II, Linear::new(0.3, 0.7).expect("finite"), rising] {
            compare::<1>(&closure);
            compare::<2>(&closure);
            compare::<3>(&closure);
            compare::<4>(&closure);
        }
    }
}
