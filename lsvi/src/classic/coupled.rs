//! Runge–Kutta methods whose stages are found together: Gauss, Radau, Lobatto and the like.

use nalgebra::{DMatrix, DVector};

use super::start::Start;
use crate::error::{InputError, SolveError, StepError, SystemError, check_step_from, check_vector};
use crate::integrator::{Grid, Integrator, OneStep, State, advance_one_step, shorter_step};
use crate::linalg::Jacobian;
use crate::mass::{Mass, MassInverse, rate};
use crate::newton::{LimitAtZero, Newton, System, Work};
use crate::quadrature::check_sum;
use crate::solver::check_assembled;
use crate::vector_field::{VectorField, check_system};

/// Smallest ratio of the pivots of A for which its inverse is used.
const REGULAR: f64 = 1e-10;

/// The Runge–Kutta method with any coefficients on M v̇ = f(t, v): M (Y_i − v) = h Σ_j a_ij f(t + c_j h, Y_j) for all
/// stages at once, by Newton's method on a dense matrix of order s n. The c_j need not be the sums of the rows of A.
///
/// Where A is regular the new value is v + Σ d_i (Y_i − v), d = A⁻ᵀ b, which does not multiply the error of a stage by h|f_v|;
/// otherwise v + h Σ b_i M⁻¹ f(t + c_i h, Y_i).
///
/// Where the new value is not the last stage, as in Gauss methods, what a start violates of algebraic equations is carried on, and such a
/// start is refused as by [`RungeKutta`](super::RungeKutta).
///
/// ```
/// use lsvi::classic::CoupledRungeKutta;
/// use lsvi::{AutoField, FieldFn, Scalar, State, Trajectory};
/// # struct Decay;
/// # impl FieldFn for Decay {
/// #     fn dim(&self) -> usize { 1 }
/// #     fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) { dv[0] = -v[0]; }
/// # }
/// let r = 3_f64.sqrt() / 6.0;
/// let a = [vec![0.25, 0.25 - r], vec![0.25 + r, 0.25]];
/// let gauss = CoupledRungeKutta::new(AutoField::new(Decay), &a, &[0.5, 0.5], &[0.5 - r, 0.5 + r])?;
/// let mut run = Trajectory::new(gauss, State::new(0.0, vec![1.0]), 0.1, 1.0)?;
/// while run.step()?.is_some() {}
/// assert!((run.state().q[0] - (-1_f64).exp()).abs() < 1e-7);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct CoupledRungeKutta<F> {
    field: F,
    mass: Mass,
    /// The rows of M that are zero, in every stage.
    algebraic: Vec<usize>,
    /// Of methods whose new value is not the last stage.
    start: Option<Start>,
    /// Needed where A is singular.
    mass_inverse: Option<MassInverse>,
    coefficients: Coefficients,
    newton: Newton,
    stages: Vec<f64>,
    scratch: Scratch,
    next: Vec<f64>,
}

#[derive(Debug)]
struct Coefficients {
    a: Vec<Vec<f64>>,
    b: Vec<f64>,
    c: Vec<f64>,
    /// A⁻ᵀ b, where A is regular.
    d: Option<Vec<f64>>,
}

#[derive(Debug)]
struct Scratch {
    slopes: Vec<f64>,
    block: Jacobian,
}

/// Refuses coefficients that are not s × s, s and s finite numbers.
pub(super) fn check_sizes(a: &[Vec<f64>], b: &[f64], c: &[f64]) -> Result<(), InputError> {
    // What differs from the other two is wrong.
    let stages = if a.len() == c.len() { a.len() } else { b.len() }.max(1);
    check_vector("b", b, stages)?;
    check_vector("c", c, stages)?;
    if a.len() != stages {
        return Err(InputError::System(SystemError::Dimension { what: "A", expected: stages, found: a.len() }));
    }
    a.iter().try_for_each(|row| check_vector("a row of A", row, stages))
}

impl<F: VectorField> CoupledRungeKutta<F> {
    /// The method with s rows of s entries in `a`, weights `b` and abscissae `c`, for `field`.
    ///
    /// # Errors
    /// [`InputError`] for sizes that do not fit, numbers that are not finite, a b that does not sum to 1
    /// ([`NodeError::WeightSum`](crate::NodeError::WeightSum)), a field or a mass that is known by its products
    /// alone, and a singular mass where A is singular too.
    pub fn new(field: F, a: &[Vec<f64>], b: &[f64], c: &[f64]) -> Result<Self, InputError> {
        check_sizes(a, b, c)?;
        check_sum(b)?;
        Self::inconsistent(field, a, b, c)
    }

    /// As [`new`](Self::new), but b may sum to anything: to see what a slip in it does.
    ///
    /// # Errors
    /// As for [`new`](Self::new) otherwise.
    pub fn inconsistent(field: F, a: &[Vec<f64>], b: &[f64], c: &[f64]) -> Result<Self, InputError> {
        check_sizes(a, b, c)?;
        let (n, s) = (field.dim(), b.len());
        let mass = field.mass();
        check_system(&field)?;
        check_assembled(&field.structure(), &mass)?;
        let lu = DMatrix::from_fn(s, s, |i, j| a[j][i]).full_piv_lu();
        let pivots = lu.u().diagonal().map(f64::abs);
        let d = (pivots.min() > REGULAR * pivots.max()).then(|| lu.solve(&DVector::from_column_slice(b)));
        let d = d.flatten().map(|d| d.as_slice().to_vec());
        let mass_inverse = d.is_none().then(|| MassInverse::new(&mass)).transpose()?;
        let is_stiffly_accurate = a.last().is_some_and(|row| row == b);
        Ok(Self {
            newton: Newton::new(s * n),
            start: if is_stiffly_accurate { None } else { Start::new(&field, mass.zero_rows(n)) },
            mass_inverse,
            algebraic: (0..s).flat_map(|j| mass.zero_rows(n).into_iter().map(move |row| j * n + row)).collect(),
            mass,
            coefficients: Coefficients { a: a.to_vec(), b: b.to_vec(), c: c.to_vec(), d },
            stages: vec![0.0; s * n],
            scratch: Scratch { slopes: vec![0.0; s * n], block: Jacobian::with_structure(n, &field.structure()) },
            next: vec![0.0; n],
            field,
        })
    }
}

/// M (Y_i − v) − h Σ_j a_ij f(t + c_j h, Y_j) = 0.
struct StageEquations<'a> {
    field: &'a dyn VectorField,
    mass: &'a Mass,
    algebraic: &'a [usize],
    coefficients: &'a Coefficients,
    scratch: &'a mut Scratch,
    t: f64,
    v: &'a [f64],
}

impl System for StageEquations<'_> {
    fn dim(&self) -> usize {
        self.v.len() * self.coefficients.b.len()
    }

    fn residual(&mut self, h: f64, y: &[f64], out: &mut [f64]) {
        let n = self.v.len();
        let slopes = &mut self.scratch.slopes;
        for ((y, slope), c) in y.chunks(n).zip(slopes.chunks_mut(n)).zip(&self.coefficients.c) {
            self.field.rhs(self.t + c * h, y, slope);
        }
        out.fill(0.0);
        for ((out, row), y) in out.chunks_mut(n).zip(&self.coefficients.a).zip(y.chunks(n)) {
            for (a, slope) in row.iter().zip(slopes.chunks(n)).filter(|(a, _)| **a != 0.0) {
                out.iter_mut().zip(slope).for_each(|(o, k)| *o -= h * a * k);
            }
            self.mass.add_difference(1.0, y, self.v, out);
        }
    }

    fn derivative(&mut self, h: f64, y: &[f64], out: &mut Jacobian) {
        let n = self.v.len();
        let block = &mut self.scratch.block;
        for (j, y) in y.chunks(n).enumerate() {
            block.clear();
            self.field.add_jacobian(self.t + self.coefficients.c[j] * h, y, 1.0, block);
            for (i, row) in self.coefficients.a.iter().enumerate().filter(|(_, row)| row[j] != 0.0) {
                block.for_each(|k, l, x| out.add(i * n + k, j * n + l, -h * row[j] * x));
            }
            out.inherit_outside(block);
            self.mass.for_each(n, |k, l, x| out.add(j * n + k, j * n + l, x));
        }
    }

    fn origin(&self, x: &mut [f64]) {
        x.chunks_mut(self.v.len().max(1)).for_each(|y| y.copy_from_slice(self.v));
    }

    fn algebraic(&self) -> &[usize] {
        self.algebraic
    }

    fn limit(&self) -> LimitAtZero {
        LimitAtZero::Kept
    }
}

impl<F: VectorField> Integrator for CoupledRungeKutta<F> {
    fn dim(&self) -> usize {
        self.field.dim()
    }

    fn advance(&mut self, state: &mut State, grid: &Grid) -> Result<(), StepError> {
        advance_one_step(self, state, grid)
    }

    fn rate(&mut self, state: &State, out: &mut [f64]) -> Result<(), StepError> {
        Ok(rate(&self.field, &self.mass, state, out)?)
    }

    fn shorter_step(&mut self, from: &State, t: f64, to: &mut State) -> Option<Result<(), StepError>> {
        shorter_step(self, from, t, to)
    }

    fn work(&self) -> Work {
        self.newton.work
    }
}

impl<F: VectorField> OneStep for CoupledRungeKutta<F> {
    fn step(&mut self, t: f64, h: f64, v: &mut [f64], _p: &mut [f64]) -> Result<(), StepError> {
        check_step_from(t, h)?;
        let n = self.next.len();
        check_vector("v", v, n)?;
        if let Some(start) = &mut self.start {
            start.check(&self.field, (t, h), v)?;
        }
        let failed = |source| StepError::Solve { t, h, source };
        let (field, mass, coefficients, scratch) = (&self.field, &self.mass, &self.coefficients, &mut self.scratch);
        let mut equations = StageEquations { field, mass, algebraic: &self.algebraic, coefficients, scratch, t, v };
        equations.origin(&mut self.stages);
        self.newton.solve(&mut equations, h, &mut self.stages).map_err(failed)?;
        self.next.fill(0.0);
        match &self.coefficients.d {
            Some(d) => {
                for (d, y) in d.iter().zip(self.stages.chunks(n)) {
                    self.next.iter_mut().zip(y).zip(v.iter()).for_each(|((sum, y), v)| *sum += d * (y - v));
                }
            }
            None => {
                for ((b, c), y) in self.coefficients.b.iter().zip(&self.coefficients.c).zip(self.stages.chunks(n)) {
                    let slope = &mut self.scratch.slopes[..n];
                    self.field.rhs(t + c * h, y, slope);
                    self.next.iter_mut().zip(slope).for_each(|(sum, k)| *sum += h * b * *k);
                }
                if let Some(inverse) = &mut self.mass_inverse {
                    inverse.solve(&mut self.next);
                }
            }
        }
        self.next.iter_mut().zip(v.iter()).for_each(|(sum, v)| *sum += v);
        if self.next.iter().any(|y| !y.is_finite()) {
            return Err(failed(SolveError::NonFinite));
        }
        v.copy_from_slice(&self.next);
        if let Some(start) = &mut self.start {
            start.end(t + h, v);
        }
        self.newton.work.steps += 1;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// v̇₀ = −v₀, and 0 = v₀ − v₁ and 0 = v₀ − v₂.
    struct Shadows;

    impl VectorField for Shadows {
        fn dim(&self) -> usize {
            3
        }
        fn mass(&self) -> Mass {
            Mass::Diagonal(vec![1.0, 0.0, 0.0])
        }
        fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
            dv.copy_from_slice(&[-v[0], v[0] - v[1], v[0] - v[2]]);
        }
        fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
            let entries = [(0, 0, -1.0), (1, 0, 1.0), (1, 1, -1.0), (2, 0, 1.0), (2, 2, -1.0)];
            entries.into_iter().for_each(|(i, j, x)| out.add(i, j, scale * x));
        }
    }

    #[test]
    fn equations_of_all_stages_are_algebraic_where_those_of_the_field_are() {
        let a = [vec![5.0 / 12.0, -1.0 / 12.0], vec![0.75, 0.25]];
        let method = CoupledRungeKutta::new(Shadows, &a, &[0.75, 0.25], &[1.0 / 3.0, 1.0]).expect("consistent");
        let CoupledRungeKutta { field, mass, algebraic, coefficients, mut scratch, .. } = method;
        let (field, scratch) = (&field, &mut scratch);
        let equations = StageEquations {
            field,
            mass: &mass,
            algebraic: &algebraic,
            coefficients: &coefficients,
            scratch,
            t: 0.0,
            v: &[1.0; 3],
        };
        assert_eq!(equations.algebraic(), [1, 2, 4, 5]);
    }
}
