//! Runge–Kutta methods with lower triangular tableaux: explicit, diagonally implicit, and mixtures.

use super::coupled::check_sizes;
use super::stage::{InexactStage, StageSolver, Stages};
use super::start::Start;
use crate::error::{InputError, NodeError, SolveError, StepError, check_step_from, check_vector};
use crate::integrator::{Grid, Integrator, OneStep, State, advance_one_step, shorter_step};
use crate::linalg::Jacobian;
use crate::mass::{Mass, MassInverse, rate};
use crate::newton::{LimitAtZero, System, Work};
use crate::quadrature::check_sum;
use crate::solver::{StepSolver, check_assembled};
use crate::vector_field::{VectorField, check_system};

/// A lower triangular Butcher tableau; a zero on the diagonal makes a stage explicit.
#[derive(Debug, Clone, PartialEq)]
pub struct Tableau {
    /// Rows of A up to the diagonal: row i has i + 1 entries.
    a: Vec<Vec<f64>>,
    b: Vec<f64>,
    c: Vec<f64>,
}

impl Tableau {
    fn new(a: Vec<Vec<f64>>, b: Vec<f64>) -> Self {
        let c = a.iter().map(|row| row.iter().sum()).collect();
        Self { a, b, c }
    }

    /// The tableau of s rows of s entries in `a`, weights `b` and abscissae `c`, which need not be the sums of the rows.
    ///
    /// # Errors
    /// [`InputError`] for sizes that do not fit, numbers that are not finite, a b that does not sum to 1
    /// ([`NodeError::WeightSum`]), and entries above the diagonal, for which there is
    /// [`CoupledRungeKutta`](super::CoupledRungeKutta).
    pub fn lower_triangular(a: &[Vec<f64>], b: &[f64], c: &[f64]) -> Result<Self, InputError> {
        check_sizes(a, b, c)?;
        check_sum(b)?;
        Self::inconsistent(a, b, c)
    }

    /// As [`lower_triangular`](Self::lower_triangular), but b may sum to anything: to see what a slip in it does.
    ///
    /// # Errors
    /// As for [`lower_triangular`](Self::lower_triangular) otherwise.
    pub fn inconsistent(a: &[Vec<f64>], b: &[f64], c: &[f64]) -> Result<Self, InputError> {
        check_sizes(a, b, c)?;
        for (row, entries) in a.iter().enumerate() {
            if let Some(k) = entries[row + 1..].iter().position(|x| *x != 0.0) {
                return Err(InputError::Nodes(NodeError::AboveDiagonal { row, column: row + 1 + k }));
            }
        }
        let rows = a.iter().enumerate().map(|(i, row)| row[..=i].to_vec());
        Ok(Self { a: rows.collect(), b: b.to_vec(), c: c.to_vec() })
    }

    /// Implicit Euler, order 1, L-stable.
    pub fn implicit_euler() -> Self {
        Self::new(vec![vec![1.0]], vec![1.0])
    }

    /// The implicit midpoint rule, order 2, A-stable, the one-stage Gauss method.
    pub fn implicit_midpoint() -> Self {
        Self::new(vec![vec![0.5]], vec![1.0])
    }

    /// The trapezoidal rule, order 2, A-stable, the two-stage Lobatto IIIA method.
    pub fn trapezoidal() -> Self {
        Self::new(vec![vec![0.0], vec![0.5, 0.5]], vec![0.5, 0.5])
    }

    /// Alexander's two-stage SDIRK method with γ = 1 − √2/2, order 2, L-stable (\[HW96\] IV.6).
    pub fn sdirk2() -> Self {
        let gamma = 1.0 - 0.5 * std::f64::consts::SQRT_2;
        Self::new(vec![vec![gamma], vec![1.0 - gamma, gamma]], vec![1.0 - gamma, gamma])
    }

    /// TR-BDF2: the trapezoidal rule to (2 − √2) h, then second-order backward differentiation, order 2, L-stable
    /// (\[HW96\] IV.6). Both implicit stages have the same diagonal entry.
    pub fn tr_bdf2() -> Self {
        let diagonal = 1.0 - 0.5 * std::f64::consts::SQRT_2;
        let weight = 0.25 * std::f64::consts::SQRT_2;
        let last = vec![weight, weight, diagonal];
        Self::new(vec![vec![0.0], vec![diagonal, diagonal], last.clone()], last)
    }

    /// The classical explicit Runge–Kutta method, order 4.
    pub fn rk4() -> Self {
        let a = vec![vec![0.0], vec![0.5, 0.0], vec![0.0, 0.5, 0.0], vec![0.0, 0.0, 1.0, 0.0]];
        Self::new(a, vec![1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0])
    }

    fn is_implicit(&self) -> bool {
        self.a.iter().any(|row| row.last() != Some(&0.0))
    }

    /// Whether values are found from slopes.
    fn needs_inverse(&self) -> bool {
        self.a.iter().skip(1).any(|row| row.last() == Some(&0.0)) || !self.is_stiffly_accurate()
    }

    /// Whether the last stage is the new value.
    fn is_stiffly_accurate(&self) -> bool {
        self.a.last().is_some_and(|row| *row == self.b)
    }
}

/// The Runge–Kutta method of a [`Tableau`] on M v̇ = f(t, v), its implicit stages solved one after the other.
///
/// An implicit stage M (Y_i − v) = h Σ_{j<i} a_ij k_j + h a_ii f(t + c_i h, Y_i) is solved for Y_i, and its slope k_i = M Ẏ_i
/// is taken from the equation, not from f, which would multiply the error of Y_i by h|f_v|.
///
/// A method whose first stage is explicit, such as the trapezoidal rule, carries on what a start violates of algebraic equations: where
/// a row of M is zero, a start that violates its equation by more than changes by √ε explain is refused,
/// [`SystemError::InconsistentStart`](crate::SystemError::InconsistentStart); a field that is matrix-free is not looked at.
#[derive(Debug)]
pub struct RungeKutta<F> {
    field: F,
    mass: Mass,
    /// The rows of M that are zero.
    algebraic: Vec<usize>,
    /// Of methods whose first stage is explicit.
    start: Option<Start>,
    /// For explicit stages, and weights that are not those of the last stage.
    mass_inverse: Option<MassInverse>,
    tableau: Tableau,
    stages: Stages,
    slopes: Vec<Vec<f64>>,
    known: Vec<f64>,
    stage: Vec<f64>,
}

impl<F: VectorField> RungeKutta<F> {
    /// The method with the given tableau, its implicit stages solved with factors of M − a h f_v.
    ///
    /// # Errors
    /// [`InputError`] if M does not fit the field, or is singular where its inverse is needed;
    /// [`SystemError::NotAssembled`](crate::SystemError::NotAssembled) if there are no entries to factor: then give a solver.
    pub fn new(field: F, tableau: Tableau) -> Result<Self, InputError> {
        if tableau.is_implicit() {
            check_assembled(&field.structure(), &field.mass())?;
        }
        let stages = Stages::factored(&field);
        Self::with_stages(field, tableau, stages)
    }

    /// The method with the given tableau, its implicit stages by an inexact Newton method with `solver`.
    ///
    /// # Errors
    /// As for [`new`](Self::new); [`SystemError::NotAssembled`](crate::SystemError::NotAssembled) or [`SystemError::Solver`](crate::SystemError::Solver) if the solver does not fit.
    pub fn with_solver(field: F, tableau: Tableau, solver: impl StepSolver + 'static) -> Result<Self, InputError> {
        let stages = StageSolver::new(&field, solver)?;
        Self::with_stages(field, tableau, Stages::Solved(Box::new(stages)))
    }

    fn with_stages(field: F, tableau: Tableau, stages: Stages) -> Result<Self, InputError> {
        let (n, mass) = (field.dim(), field.mass());
        check_system(&field)?;
        let mass_inverse = tableau.needs_inverse().then(|| MassInverse::new(&mass)).transpose()?;
        let algebraic = mass.zero_rows(n);
        let begins_explicitly = tableau.a.first().is_some_and(|row| *row == [0.0]);
        Ok(Self {
            stages,
            mass_inverse,
            start: if begins_explicitly { Start::new(&field, algebraic.clone()) } else { None },
            algebraic,
            mass,
            slopes: vec![vec![0.0; n]; tableau.b.len()],
            known: vec![0.0; n],
            stage: vec![0.0; n],
            field,
            tableau,
        })
    }

    pub(super) fn algebraic(&self) -> &[usize] {
        &self.algebraic
    }

    pub(super) fn field(&self) -> &F {
        &self.field
    }
}

/// M (Y − v) − s (known/h + a f(t + c s, Y)) = 0 for a step of size s; `known` is h Σ a_ij k_j at the full step h.
struct StageEquation<'a> {
    field: &'a dyn VectorField,
    mass: &'a Mass,
    algebraic: &'a [usize],
    t: f64,
    a: f64,
    c: f64,
    v: &'a [f64],
    known: &'a [f64],
    full: f64,
}

impl System for StageEquation<'_> {
    fn dim(&self) -> usize {
        self.v.len()
    }

    fn residual(&mut self, s: f64, y: &[f64], out: &mut [f64]) {
        self.field.rhs(self.t + self.c * s, y, out);
        let fraction = s / self.full;
        for (o, k) in out.iter_mut().zip(self.known) {
            *o = -fraction * k - s * self.a * *o;
        }
        self.mass.add_difference(1.0, y, self.v, out);
    }

    fn derivative(&mut self, s: f64, y: &[f64], out: &mut Jacobian) {
        self.mass.add_to(1.0, out);
        self.field.add_jacobian(self.t + self.c * s, y, -s * self.a, out);
    }

    fn algebraic(&self) -> &[usize] {
        self.algebraic
    }

    fn limit(&self) -> LimitAtZero {
        LimitAtZero::Kept
    }
}

impl InexactStage for StageEquation<'_> {
    fn at(&self, s: f64) -> (&dyn VectorField, &Mass, f64, f64) {
        (self.field, self.mass, self.t + self.c * s, s * self.a)
    }
}

impl<F: VectorField> Integrator for RungeKutta<F> {
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
        self.stages.work()
    }
}

impl<F: VectorField> OneStep for RungeKutta<F> {
    fn step(&mut self, t: f64, h: f64, v: &mut [f64], _p: &mut [f64]) -> Result<(), StepError> {
        check_step_from(t, h)?;
        check_vector("v", v, self.known.len())?;
        if let Some(start) = &mut self.start {
            start.check(&self.field, (t, h), v)?;
        }
        let failed = |source| StepError::Solve { t, h, source };
        let tableau = &self.tableau;
        for (i, row) in tableau.a.iter().enumerate() {
            self.known.fill(0.0);
            let (done, rest) = self.slopes.split_at_mut(i);
            for (a, k) in row.iter().zip(done.iter()).filter(|(a, _)| **a != 0.0) {
                for (sum, k) in self.known.iter_mut().zip(k) {
                    *sum += h * a * k;
                }
            }
            let (a, c, slope) = (row[i], tableau.c[i], &mut rest[0]);
            if a == 0.0 {
                if let Some(inverse) = self.mass_inverse.as_mut().filter(|_| i > 0) {
                    inverse.solve(&mut self.known);
                }
                for ((y, v), k) in self.stage.iter_mut().zip(v.iter()).zip(&self.known) {
                    *y = v + k;
                }
                self.field.rhs(t + c * h, &self.stage, slope);
                self.stages.work_mut().residuals += 1;
                continue;
            }
            self.stage.copy_from_slice(v);
            let (field, mass, known) = (&self.field, &self.mass, &self.known);
            let mut equation = StageEquation { field, mass, algebraic: &self.algebraic, t, a, c, v, known, full: h };
            self.stages.solve(&mut equation, h, &mut self.stage).map_err(failed)?;
            for (s, k) in slope.iter_mut().zip(&self.known) {
                *s = -k;
            }
            self.mass.add_difference(1.0, &self.stage, v, slope);
            slope.iter_mut().for_each(|s| *s /= h * a);
        }
        if !tableau.is_stiffly_accurate() {
            self.known.fill(0.0);
            for (b, k) in tableau.b.iter().zip(&self.slopes) {
                for (sum, k) in self.known.iter_mut().zip(k) {
                    *sum += h * b * k;
                }
            }
            if let Some(inverse) = &mut self.mass_inverse {
                inverse.solve(&mut self.known);
            }
            for ((y, v), k) in self.stage.iter_mut().zip(v.iter()).zip(&self.known) {
                *y = v + k;
            }
        }
        if self.stage.iter().any(|y| !y.is_finite()) {
            return Err(failed(SolveError::NonFinite));
        }
        v.copy_from_slice(&self.stage);
        if let Some(start) = &mut self.start {
            start.end(t + h, v);
        }
        self.stages.work_mut().steps += 1;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Σ b_i Φ_i = 1/γ for every rooted tree up to the order.
    #[test]
    fn tableaus_by_name_meet_the_conditions_of_their_orders() {
        let tableaus = [
            ("implicit Euler", Tableau::implicit_euler(), 1),
            ("implicit midpoint", Tableau::implicit_midpoint(), 2),
            ("trapezoidal", Tableau::trapezoidal(), 2),
            ("SDIRK", Tableau::sdirk2(), 2),
            ("TR-BDF2", Tableau::tr_bdf2(), 2),
            ("rk4", Tableau::rk4(), 4),
        ];
        for (name, Tableau { a, b, c }, order) in tableaus {
            let sum = |weights: &[f64], x: &[f64]| weights.iter().zip(x).map(|(w, x)| w * x).sum::<f64>();
            let grown = |x: &[f64]| a.iter().map(|row| sum(row, x)).collect::<Vec<_>>();
            let times = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).collect::<Vec<_>>();
            let (ones, squares) = (vec![1.0; b.len()], times(&c, &c));
            assert_eq!(c, grown(&ones), "{name}");
            let trees = [
                (1, ones, 1.0),
                (2, c.clone(), 2.0),
                (3, squares.clone(), 3.0),
                (3, grown(&c), 6.0),
                (4, times(&c, &squares), 4.0),
                (4, times(&c, &grown(&c)), 8.0),
                (4, grown(&squares), 12.0),
                (4, grown(&grown(&c)), 24.0),
            ];
            for (_, tree, density) in trees.iter().filter(|(of, ..)| *of <= order) {
                let defect = density * sum(&b, tree) - 1.0;
                assert!(defect.abs() <= 4.0 * f64::EPSILON, "{name}: {defect:e} for the density {density}");
            }
        }
    }
}
