//! Steps of the kinds that lsvi has no integrator for: stages with weights of their own for q and p, and multistep methods.

use std::sync::Arc;

use lsvi::{
    Grid, InputError, Integrator, Jacobian, Mass, SolveError, State, StepError, SystemError, VectorField, Work,
};
use nalgebra::{DMatrix, DVector};

use super::parts::Coupling;
use crate::measure::norm::max_norm;

/// The coefficients of a method with two parts.
#[derive(Debug)]
pub(super) struct Halves {
    pub coupling: Coupling,
    pub a: [Vec<Vec<f64>>; 2],
    pub b: [Vec<f64>; 2],
    pub c: Vec<f64>,
}

/// Equations Y_i = x_i + Σ_j W_ij f(t_j, Y_j) with matrices W_ij of order n, for stages that are solved for together by Newton's
/// method, started at x_i.
struct Stages<'a> {
    field: &'a dyn VectorField,
    times: Vec<f64>,
    /// The x_i, one after the other.
    start: DVector<f64>,
    weight: &'a dyn Fn(usize, usize) -> Block,
}

/// A matrix made of multiples of I, of order n/2: what of the slopes of q and p goes into q and p.
#[derive(Debug, Clone, Copy, Default)]
struct Block {
    qq: f64,
    qp: f64,
    pp: f64,
}

impl Block {
    fn same(x: f64) -> Self {
        Self { qq: x, qp: 0.0, pp: x }
    }

    fn is_zero(self) -> bool {
        [self.qq, self.qp, self.pp] == [0.0; 3]
    }

    /// Adds the product with `slope` to `out`.
    fn add(self, slope: &[f64], out: &mut [f64]) {
        let m = slope.len() / 2;
        if self.qp == 0.0 && self.qq == self.pp {
            return out.iter_mut().zip(slope).for_each(|(o, k)| *o += self.qq * k);
        }
        for i in 0..m {
            out[i] += self.qq * slope[i] + self.qp * slope[m + i];
            out[m + i] += self.pp * slope[m + i];
        }
    }
}

/// Most iterations; from the start of a step Newton's method takes a handful.
const ITERATIONS: u32 = 50;

impl Stages<'_> {
    /// The slopes f(t_j, Y_j) at the solution.
    fn slopes(&self, work: &mut Work) -> Result<Vec<Vec<f64>>, SolveError> {
        let (n, s) = (self.field.dim(), self.times.len());
        if (0..s).all(|i| (i..s).all(|j| (self.weight)(i, j).is_zero())) {
            return self.one_by_one(work);
        }
        let mut y = self.start.clone();
        let mut last = f64::INFINITY;
        let mut jacobian = Jacobian::with_structure(n, &self.field.structure());
        for iterations in 1..=ITERATIONS {
            let slopes = self.at(&y, work);
            if slopes.iter().flatten().any(|x| !x.is_finite()) {
                return Err(SolveError::NonFinite);
            }
            let mut residual = &y - &self.start;
            let mut matrix = DMatrix::identity(s * n, s * n);
            for (j, slope) in slopes.iter().enumerate() {
                jacobian.clear();
                let stage = &y.as_slice()[j * n..(j + 1) * n];
                self.field.add_jacobian(self.times[j], stage, 1.0, &mut jacobian);
                let derivative = jacobian.to_dense();
                for i in 0..s {
                    let weight = (self.weight)(i, j);
                    let negative = Block { qq: -weight.qq, qp: -weight.qp, pp: -weight.pp };
                    negative.add(slope, &mut residual.as_mut_slice()[i * n..(i + 1) * n]);
                    for (k, column) in derivative.column_iter().enumerate() {
                        let mut out = vec![0.0; n];
                        negative.add(column.as_slice(), &mut out);
                        let at = (i * n, j * n + k);
                        out.iter().enumerate().for_each(|(l, x)| matrix[(at.0 + l, at.1)] += x);
                    }
                }
            }
            work.factorizations += 1;
            let increment = matrix.lu().solve(&residual).ok_or(SolveError::Singular)?;
            y -= &increment;
            let size = max_norm(increment.as_slice());
            if size.is_nan() {
                return Err(SolveError::Diverged { iterations, increment: size });
            }
            // Increments shrink until they are roundoff.
            if size <= 4.0 * f64::EPSILON * max_norm(y.as_slice()) || (size >= last && size < 1e-10) {
                return Ok(self.at(&y, work));
            }
            if size >= 2.0 * last && iterations > 4 {
                return Err(SolveError::Diverged { iterations, increment: size });
            }
            last = size;
        }
        Err(SolveError::Diverged { iterations: ITERATIONS, increment: last })
    }

    /// The same where no stage depends on itself or a later one.
    fn one_by_one(&self, work: &mut Work) -> Result<Vec<Vec<f64>>, SolveError> {
        let n = self.field.dim();
        let mut slopes: Vec<Vec<f64>> = Vec::with_capacity(self.times.len());
        for (i, t) in self.times.iter().enumerate() {
            let mut y = self.start.as_slice()[i * n..(i + 1) * n].to_vec();
            slopes.iter().enumerate().for_each(|(j, slope)| (self.weight)(i, j).add(slope, &mut y));
            let mut slope = vec![0.0; n];
            self.field.rhs(*t, &y, &mut slope);
            work.residuals += 1;
            if slope.iter().any(|x| !x.is_finite()) {
                return Err(SolveError::NonFinite);
            }
            slopes.push(slope);
        }
        Ok(slopes)
    }

    fn at(&self, y: &DVector<f64>, work: &mut Work) -> Vec<Vec<f64>> {
        let n = self.field.dim();
        work.residuals += 1;
        let slope = |(t, y): (&f64, &[f64])| {
            let mut out = vec![0.0; n];
            self.field.rhs(*t, y, &mut out);
            out
        };
        self.times.iter().zip(y.as_slice().chunks(n)).map(slope).collect()
    }
}

/// A method on a field whose step is a function of the state alone.
pub(super) struct Stepper<'a> {
    field: Box<dyn VectorField + 'a>,
    halves: Halves,
    work: Work,
}

/// Refuses fields with a mass matrix.
fn check_mass(field: &dyn VectorField) -> Result<(), String> {
    match field.mass() {
        Mass::Identity => Ok(()),
        _ => Err("its equations have a mass matrix, which this kind does not know".into()),
    }
}

impl<'a> Stepper<'a> {
    pub(super) fn halves(halves: Halves, field: Box<dyn VectorField + 'a>) -> Result<Self, String> {
        check_mass(&*field)?;
        if field.dim() % 2 == 1 {
            return Err("its state does not have two halves, q and p".into());
        }
        if halves.coupling == Coupling::SecondOrder && !is_second_order(&*field) {
            return Err("it is not q̇ = p, ṗ = g(q)".into());
        }
        if halves.coupling == Coupling::Separable && !is_separable(&*field) {
            return Err("it is made for q̇ = f(p), ṗ = g(q), and here q̇ depends on q, or ṗ on p".into());
        }
        Ok(Self { field, halves, work: Work::default() })
    }
}

/// Whether neither half depends on itself, as the derivative at a point shows.
fn is_separable(field: &dyn VectorField) -> bool {
    let (m, jacobian) = (field.dim() / 2, derivative(field, &somewhere(field.dim())));
    (0..m).all(|i| (0..m).all(|j| jacobian.get(i, j) == 0.0 && jacobian.get(m + i, m + j) == 0.0))
}

/// A state with no two components alike.
fn somewhere(n: usize) -> Vec<f64> {
    (0..n).map(|i| 0.3 + 0.1 * i as f64).collect()
}

fn derivative(field: &dyn VectorField, point: &[f64]) -> Jacobian {
    let mut jacobian = Jacobian::with_structure(field.dim(), &field.structure());
    field.add_jacobian(0.0, point, 1.0, &mut jacobian);
    jacobian
}

/// Whether the first half of the field is p and the second does not depend on it, as its derivative at a point shows.
fn is_second_order(field: &dyn VectorField) -> bool {
    let n = field.dim();
    let point = somewhere(n);
    let jacobian = derivative(field, &point);
    let m = n / 2;
    let required = |i: usize, j: usize| if j == i + m { 1.0 } else { 0.0 };
    let mut slope = vec![0.0; n];
    field.rhs(0.0, &point, &mut slope);
    (0..m).all(|i| slope[i] == point[i + m] && (0..n).all(|j| jacobian.get(i, j) == required(i, j)))
        && (m..n).all(|i| (m..n).all(|j| jacobian.get(i, j) == 0.0))
}

impl Integrator for Stepper<'_> {
    fn dim(&self) -> usize {
        self.field.dim()
    }

    fn advance(&mut self, state: &mut State, grid: &Grid) -> Result<(), StepError> {
        let Some(step) = grid.next(state.t) else { return Ok(()) };
        let (t, h, Halves { coupling, a, b, c }) = (state.t, step.h, &self.halves);
        let (n, s, second_order) = (self.field.dim(), c.len(), *coupling == Coupling::SecondOrder);
        let m = n / 2;
        // In q̈ = g(q) the slopes of p go into q with h².
        let block = |q: f64, p: f64| match second_order {
            true => Block { qq: 0.0, qp: h * h * q, pp: h * p },
            false => Block { qq: h * q, qp: 0.0, pp: h * p },
        };
        let weight = |i: usize, j: usize| match second_order {
            true => block(a[0][i][j], 0.0),
            false => block(a[0][i][j], a[1][i][j]),
        };
        let moved = |by: f64| {
            let mut y = state.q.clone();
            (0..if second_order { m } else { 0 }).for_each(|k| y[k] += by * h * state.q[m + k]);
            y
        };
        let start: Vec<f64> = (0..s).flat_map(|i| moved(c[i])).collect();
        let times = c.iter().map(|c| t + c * h).collect();
        let stages = Stages { field: &*self.field, times, start: start.into(), weight: &weight };
        let slopes = stages.slopes(&mut self.work).map_err(|source| StepError::Solve { t, h, source })?;
        let mut end = moved(1.0);
        for (j, slope) in slopes.iter().enumerate() {
            block(b[0][j], b[1][j]).add(slope, &mut end);
        }
        state.q = end;
        state.t = step.end;
        self.work.steps += 1;
        Ok(())
    }

    fn work(&self) -> Work {
        self.work
    }
}

/// Σ_j ρ_j v_{n+j} = h Σ_j σ_j f(t_{n+j}, v_{n+j}), started by a one-step method.
pub(super) struct Multistep<'a> {
    rho: Vec<f64>,
    sigma: Vec<f64>,
    field: Arc<dyn VectorField + 'a>,
    start: Box<dyn Integrator + 'a>,
    /// Times, states and slopes of steps of one size, the oldest first.
    history: Vec<(f64, Vec<f64>, Vec<f64>)>,
    h: f64,
    work: Work,
}

impl<'a> Multistep<'a> {
    pub(super) fn new(
        rho: Vec<f64>,
        sigma: Vec<f64>,
        field: Arc<dyn VectorField + 'a>,
        start: Box<dyn Integrator + 'a>,
    ) -> Result<Self, String> {
        check_mass(&*field)?;
        Ok(Self { rho, sigma, field, start, history: Vec::new(), h: 0.0, work: Work::default() })
    }

    /// Keeps the state at (t, v), and forgets what is not needed any more.
    fn remember(&mut self, t: f64, v: &[f64]) {
        let mut slope = vec![0.0; v.len()];
        self.field.rhs(t, v, &mut slope);
        self.work.residuals += 1;
        self.history.push((t, v.to_vec(), slope));
        let steps = self.rho.len() - 1;
        let extra = self.history.len().saturating_sub(steps);
        self.history.drain(..extra);
    }
}

impl Integrator for Multistep<'_> {
    fn dim(&self) -> usize {
        self.field.dim()
    }

    /// Takes steps of one size; after a change of it, as at a clipped end, the starting method does.
    fn advance(&mut self, state: &mut State, grid: &Grid) -> Result<(), StepError> {
        let Some(step) = grid.next(state.t) else { return Ok(()) };
        let (t, h, k) = (state.t, step.h, self.rho.len() - 1);
        let continues = self.history.last().is_some_and(|(last, v, _)| *last == t && *v == state.q)
            && (h - self.h).abs() <= 1e-9 * h;
        if !continues {
            self.history.clear();
            self.remember(t, &state.q);
            self.h = h;
        }
        if self.history.len() < k {
            self.start.advance(state, grid)?;
        } else {
            let lead = self.rho[k];
            let mut known = vec![0.0; state.q.len()];
            for (j, (_, v, slope)) in self.history.iter().enumerate() {
                for (x, (v, slope)) in known.iter_mut().zip(v.iter().zip(slope)) {
                    *x += (h * self.sigma[j] * slope - self.rho[j] * v) / lead;
                }
            }
            let implicit = h * self.sigma[k] / lead;
            if implicit != 0.0 {
                let weight = |_: usize, _: usize| Block::same(implicit);
                let start = known.clone().into();
                let stages = Stages { field: &*self.field, times: vec![step.end], start, weight: &weight };
                let slopes = stages.slopes(&mut self.work).map_err(|source| StepError::Solve { t, h, source })?;
                Block::same(implicit).add(&slopes[0], &mut known);
            }
            if let Some(index) = known.iter().position(|x| !x.is_finite()) {
                return Err(InputError::System(SystemError::NonFinite { what: "v", index, value: known[index] }).into());
            }
            state.q = known;
            state.t = step.end;
        }
        let (t, v) = (state.t, state.q.clone());
        self.remember(t, &v);
        self.work.steps += 1;
        Ok(())
    }

    fn work(&self) -> Work {
        let first = self.start.work();
        Work { steps: self.work.steps, ..self.work + first }
    }
}
