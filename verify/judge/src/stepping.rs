//! Steps of the kinds that lsvi has no integrator for: stages with weights of their own for q and p, and multistep methods.

use std::sync::Arc;

use lsvi::{
    Grid, InputError, Integrator, Jacobian, Mass, SolveError, State, StepError, SystemError, VectorField, Work,
};
use nalgebra::{DMatrix, DVector};

use super::parts::Coupling;
use experiments::measure::norm::max_norm;

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

#[cfg(test)]
#[expect(clippy::arc_with_non_send_sync, reason = "rates that count their calls, on one thread")]
mod tests {
    use std::cell::RefCell;

    use super::*;

    type Rates = Box<dyn Fn(f64, &[f64], &mut [f64])>;
    type Derivatives = Box<dyn Fn(f64, &[f64]) -> Vec<(usize, usize, f64)>>;

    /// A field with the derivatives that a test gives it, true or not.
    struct Given {
        n: usize,
        rates: Rates,
        derivatives: Derivatives,
        mass: Mass,
    }

    impl VectorField for Given {
        fn dim(&self) -> usize {
            self.n
        }
        fn mass(&self) -> Mass {
            self.mass.clone()
        }
        fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
            assert_eq!([v.len(), dv.len()], [self.n; 2]);
            (self.rates)(t, v, dv);
        }
        fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
            assert_eq!(v.len(), self.n);
            (self.derivatives)(t, v).into_iter().for_each(|(i, j, x)| out.add(i, j, scale * x));
        }
    }

    fn given<const N: usize>(
        rates: impl Fn(f64, &[f64]) -> [f64; N] + 'static,
        derivatives: impl Fn(f64, &[f64]) -> Vec<(usize, usize, f64)> + 'static,
    ) -> Given {
        let rates = Box::new(move |t: f64, v: &[f64], out: &mut [f64]| out.copy_from_slice(&rates(t, v)));
        Given { n: N, rates, derivatives: Box::new(derivatives), mass: Mass::Identity }
    }

    /// v̇ = A v.
    fn linear<const N: usize>(a: [[f64; N]; N]) -> Given {
        let product = move |_: f64, v: &[f64]| a.map(|row| row.iter().zip(v).map(|(a, v)| a * v).sum());
        let entries = move |_: f64, _: &[f64]| (0..N * N).map(|k| (k / N, k % N, a[k / N][k % N])).collect();
        given(product, entries)
    }

    /// Rows (qq, qp; 0, pp) times (1, 2 | 3, 4); a multiple of I also where the number of components is odd.
    #[test]
    fn a_block_adds_its_multiples_of_both_halves_to_those() {
        let slope = [1.0, 2.0, 3.0, 4.0];
        for (block, added) in [
            (Block::same(2.0), [2.0, 4.0, 6.0, 8.0]),
            (Block { qq: 2.0, qp: 0.0, pp: 3.0 }, [2.0, 4.0, 9.0, 12.0]),
            (Block { qq: 2.0, qp: 5.0, pp: 2.0 }, [17.0, 24.0, 6.0, 8.0]),
            (Block { qq: 2.0, qp: 5.0, pp: 3.0 }, [17.0, 24.0, 9.0, 12.0]),
        ] {
            let mut out = [10.0, 20.0, 30.0, 40.0];
            block.add(&slope, &mut out);
            assert_eq!(out, [10.0 + added[0], 20.0 + added[1], 30.0 + added[2], 40.0 + added[3]], "{block:?}");
            assert!(!block.is_zero());
        }
        let mut odd = [10.0, 20.0, 30.0];
        Block::same(2.0).add(&slope[..3], &mut odd);
        assert_eq!(odd, [12.0, 24.0, 36.0]);
        assert!(Block::default().is_zero());
        for k in 0..3 {
            let [qq, qp, pp] = [0, 1, 2].map(|i| f64::from(u8::from(i == k)));
            assert!(!Block { qq, qp, pp }.is_zero(), "{k}");
        }
    }

    /// Two stages of two components, every one of which acts on every other: the slopes are those at the stages that they make, and
    /// Newton's method needs one iteration on a linear field, and another to see that.
    #[test]
    fn stages_that_depend_on_each_other_satisfy_their_equations_after_one_iteration_on_a_linear_field() {
        let a = |t: f64| [[t, -2.0], [3.0, 0.5 * t]];
        let rates = move |t: f64, v: &[f64]| a(t).map(|row| row[0] * v[0] + row[1] * v[1] + t);
        let entries = move |t: f64, _: &[f64]| (0..4).map(|k| (k / 2, k % 2, a(t)[k / 2][k % 2])).collect();
        let field = given(rates, entries);
        let weight = |i: usize, j: usize| {
            let [qq, qp, pp] =
                [[[0.1, 0.02, 0.07], [-0.2, 0.03, 0.05]], [[0.3, -0.04, 0.06], [0.15, 0.01, -0.25]]][i][j];
            Block { qq, qp, pp }
        };
        let (times, start) = (vec![1.0, 1.5], vec![1.0, 2.0, 3.0, 5.0]);
        let stages = Stages { field: &field, times: times.clone(), start: start.clone().into(), weight: &weight };
        let mut work = Work::default();
        let slopes = stages.slopes(&mut work).expect("a solution");
        for (i, t) in times.into_iter().enumerate() {
            let mut y = start[2 * i..2 * i + 2].to_vec();
            (0..2).for_each(|j| weight(i, j).add(&slopes[j], &mut y));
            let mut slope = [0.0; 2];
            field.rhs(t, &y, &mut slope);
            for (found, slope) in slopes[i].iter().zip(slope) {
                approx::assert_abs_diff_eq!(*found, slope, epsilon = 1e-13);
            }
        }
        assert!((1..=3).contains(&work.factorizations), "{work:?}");
        assert_eq!((work.residuals, work.steps), (work.factorizations + 1, 0));
    }

    /// The stage Y = f(Y) with f(Y) = Y − δ_k in its k-th evaluation and a derivative of 0 has these increments δ_k, in exact
    /// arithmetic, and Y = −Σ δ_k. Beyond those listed they are 0.
    #[test]
    fn increments_end_at_roundoff_or_where_they_no_longer_shrink_and_are_refused_where_they_grow() {
        let eps = f64::EPSILON;
        let tiny = 0.5_f64.powi(40);
        let diverged = |iterations, increment| Err(SolveError::Diverged { iterations, increment });
        let back_and_forth: Vec<f64> = (0..60).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
        for (increments, expected) in [
            // The first is 0, as is Y.
            (vec![], Ok((1, 0.0))),
            (vec![1.0], Ok((2, -1.0))),
            // 4 ε |Y| is enough, and 6 ε is not.
            (vec![-1.0 - 4.0 * eps, 4.0 * eps, 0.0], Ok((2, 1.0))),
            (vec![-1.0 - 6.0 * eps, 6.0 * eps, 0.0], Ok((3, 1.0))),
            // Small ones that shrink go on, and end where they do not; large ones go on.
            (vec![-1.0, -tiny, -0.5 * tiny, -0.5 * tiny], Ok((4, 1.0 + 2.0 * tiny))),
            (vec![1.0, -1.0, 0.0], Ok((3, 0.0))),
            (vec![1e-10, -1e-10, 0.0], Ok((3, 0.0))),
            // To twice the last one after the fourth: then it diverges, and before it may.
            (vec![1.0, 2.0, 4.0, 8.0], Ok((5, -15.0))),
            (vec![1.0, 2.0, 4.0, 8.0, 16.0], diverged(5, 16.0)),
            (vec![1.0, 1.0, 1.0, 8.0, 12.0], Ok((6, -23.0))),
            (vec![1.0, 0.5, 0.25, 0.125, 0.0625], Ok((6, -1.9375))),
            (back_and_forth, diverged(50, 1.0)),
        ] {
            let shown = format!("{increments:?}");
            let rest = RefCell::new(increments.into_iter());
            let rates = move |_: f64, v: &[f64]| [v[0] - rest.borrow_mut().next().unwrap_or(0.0)];
            let field = given(rates, |_, _| Vec::new());
            let weight = |_: usize, _: usize| Block::same(1.0);
            let stages = Stages { field: &field, times: vec![0.0], start: vec![0.0].into(), weight: &weight };
            let mut work = Work::default();
            // f(Y) = Y in the evaluation after the last increment.
            let found = stages.slopes(&mut work).map(|slopes| (work.factorizations, slopes[0][0]));
            assert_eq!(found, expected, "{shown}");
            assert_eq!(work.residuals, work.factorizations + u64::from(found.is_ok()), "{shown}");
        }
    }

    #[test]
    fn stages_without_a_finite_or_a_determined_solution_are_refused() {
        let refused = |slope: f64, derivative: f64, implicit: f64| {
            let field = given(move |_, _| [slope], move |_, _| vec![(0, 0, derivative)]);
            let weight = |_: usize, _: usize| Block::same(implicit);
            let stages = Stages { field: &field, times: vec![0.0], start: vec![1.0].into(), weight: &weight };
            stages.slopes(&mut Work::default())
        };
        assert_eq!(refused(f64::INFINITY, 0.0, 1.0), Err(SolveError::NonFinite));
        assert_eq!(refused(f64::INFINITY, 0.0, 0.0), Err(SolveError::NonFinite));
        // 1 − w f′ = 0.
        assert_eq!(refused(3.0, 0.5, 2.0), Err(SolveError::Singular));
        let Err(SolveError::Diverged { iterations: 1, increment }) = refused(3.0, f64::NAN, 1.0) else { panic!() };
        assert!(increment.is_nan());
        assert_eq!(refused(3.0, 0.0, 0.0), Ok(vec![vec![3.0]]));
    }

    fn halves(coupling: Coupling, [second, second_hat]: [f64; 2], b: [[f64; 2]; 2]) -> Halves {
        let a = [second, second_hat].map(|a| vec![vec![0.0, 0.0], vec![a, 0.0]]);
        Halves { coupling, a, b: b.map(|b| b.to_vec()), c: vec![0.25, 0.5] }
    }

    /// q̇ = (t p₀, p₁ + q₀), ṗ = (t − q₁, p₀) from t = 1, h = 1/2. By hand: k₁ = (27/8, 6, −7/8, 3) at t = 9/8;
    /// Y₂ = (59/32, 7/2, 41/16, 13/2) and k₂ = (205/64, 267/32, −9/4, 41/16) at t = 5/4.
    #[test]
    fn a_partitioned_step_weighs_the_slopes_of_q_and_p_apart_at_times_of_their_own() {
        let rates = |t: f64, v: &[f64]| [t * v[2], v[3] + v[0], t - v[1], v[2]];
        let b = [[0.25, 0.75], [0.75, 0.25]];
        let field = Box::new(given(rates, |_, _| Vec::new()));
        let mut stepper = Stepper::halves(halves(Coupling::General, [0.5, 1.0], b), field).expect("general");
        let mut state = State::new(1.0, vec![1.0, 2.0, 3.0, 5.0]);
        let grid = Grid::new(1.0, 0.5, 1.5).expect("a grid");
        stepper.advance(&mut state, &grid).expect("a step");
        let end = State::new(1.5, vec![1343.0 / 512.0, 1505.0 / 256.0, 153.0 / 64.0, 825.0 / 128.0]);
        assert_eq!((stepper.dim(), &state), (4, &end));
        let once = Work { steps: 1, residuals: 2, ..Work::default() };
        assert_eq!(stepper.work(), once);
        // There is no step beyond the end.
        stepper.advance(&mut state, &grid).expect("nothing");
        assert_eq!((state, stepper.work()), (end, once));
    }

    /// q̈ = (t q₁, q₀) from t = 1, h = 1/2. By hand: Y₁ = q + h p/4 = (11/8, 21/8), g₁ = (189/64, 11/8) at t = 9/8;
    /// Y₂ = q + h p/2 + h² g₁/2 = (1085/512, 219/64), g₂ = (1095/256, 1085/512) at t = 5/4;
    /// q + h p + h² (g₁/4 + g₂/2), p + h (3 g₁/4 + g₂/4).
    #[test]
    fn a_nystrom_step_moves_q_by_p_and_by_the_square_of_its_size() {
        let rates = |t: f64, v: &[f64]| [v[2], v[3], t * v[1], v[0]];
        let entries = |t: f64, _: &[f64]| vec![(0, 2, 1.0), (1, 3, 1.0), (2, 1, t), (3, 0, 1.0)];
        // The second matrix is not looked at.
        let method = halves(Coupling::SecondOrder, [0.5, 7.0], [[0.25, 0.5], [0.75, 0.25]]);
        let mut stepper = Stepper::halves(method, Box::new(given(rates, entries))).expect("of second order");
        let mut state = State::new(1.0, vec![1.0, 2.0, 3.0, 5.0]);
        stepper.advance(&mut state, &Grid::new(1.0, 0.5, 2.0).expect("a grid")).expect("a step");
        let end = [6593.0 / 2048.0, 19869.0 / 4096.0, 9507.0 / 2048.0, 23677.0 / 4096.0];
        assert_eq!(state, State::new(1.5, end.to_vec()));
    }

    #[test]
    fn a_step_without_a_solution_leaves_the_state_and_says_where_it_began() {
        let field = given(|_, _| [1.0, f64::INFINITY], |_, _| Vec::new());
        let method = halves(Coupling::General, [0.5, 1.0], [[0.5; 2]; 2]);
        let mut stepper = Stepper::halves(method, Box::new(field)).expect("general");
        let before = State::new(1.0, vec![1.0, 2.0]);
        let mut state = before.clone();
        let error = stepper.advance(&mut state, &Grid::new(0.0, 0.5, 2.0).expect("a grid"));
        assert_eq!(error, Err(StepError::Solve { t: 1.0, h: 0.5, source: SolveError::NonFinite }));
        assert_eq!((state, stepper.work().steps), (before, 0));
    }

    /// q̇ = p, ṗ = −q with one entry of its matrix changed: a change in the rows of q̇ is not of second order, one on the diagonal
    /// blocks neither, and those are not separable.
    #[test]
    fn a_method_of_some_coupling_is_refused_where_one_derivative_is_against_it() {
        let accepts = |coupling: Coupling, field: Given| {
            Stepper::halves(halves(coupling, [0.5; 2], [[0.5; 2]; 2]), Box::new(field)).is_ok()
        };
        let base = [[0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0], [-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0]];
        for (i, j) in (0..16).map(|k| (k / 4, k % 4)) {
            let changed = || {
                let mut a = base;
                a[i][j] += 0.5;
                linear(a)
            };
            let is_couplings = (i < 2) != (j < 2);
            assert!(accepts(Coupling::General, changed()));
            assert_eq!(accepts(Coupling::Separable, changed()), is_couplings, "{i}, {j}");
            assert_eq!(accepts(Coupling::SecondOrder, changed()), is_couplings && i >= 2, "{i}, {j}");
        }
        assert!(accepts(Coupling::SecondOrder, linear(base)));
        // q̇ = p + 1 has the derivatives of q̇ = p.
        let moved = given(|_, v| [v[1] + 1.0, -v[0]], |_, _| vec![(0, 1, 1.0), (1, 0, -1.0)]);
        assert!(!accepts(Coupling::SecondOrder, moved));
    }

    #[test]
    fn fields_without_halves_or_with_a_mass_matrix_are_refused() {
        let method = || halves(Coupling::General, [0.5; 2], [[0.5; 2]; 2]);
        let odd = linear([[0.0; 3]; 3]);
        assert_eq!(
            Stepper::halves(method(), Box::new(odd)).err().as_deref(),
            Some("its state does not have two halves, q and p")
        );
        let heavy = || Given { mass: Mass::Diagonal(vec![1.0; 2]), ..linear([[0.0; 2]; 2]) };
        assert!(Stepper::halves(method(), Box::new(heavy())).is_err_and(|why| why.contains("mass matrix")));
        let started = Multistep::new(vec![-1.0, 1.0], vec![1.0, 0.0], Arc::new(heavy()), Box::new(Shift(0)));
        assert!(started.is_err_and(|why| why.contains("mass matrix")));
    }

    /// A derivative that vanishes at 0, or where two components are alike, is looked at elsewhere, and where logarithms have values.
    #[test]
    fn the_state_at_which_derivatives_are_looked_at_has_positive_components_no_two_alike() {
        let point = somewhere(7);
        assert!(point.len() == 7 && point.iter().all(|x| 0.0 < *x && *x < 1.0), "{point:?}");
        assert!(point.windows(2).all(|pair| pair[0] < pair[1]), "{point:?}");
    }

    /// Starts by v + h, and counts its steps in hundreds of evaluations.
    struct Shift(u64);

    impl Integrator for Shift {
        fn dim(&self) -> usize {
            1
        }
        fn advance(&mut self, state: &mut State, grid: &Grid) -> Result<(), StepError> {
            let step = grid.next(state.t).expect("a step");
            state.q.iter_mut().for_each(|v| *v += step.h);
            state.t = step.end;
            self.0 += 1;
            Ok(())
        }
        fn work(&self) -> Work {
            Work { steps: 1000 * self.0, residuals: 100 * self.0, ..Work::default() }
        }
    }

    fn multistep(rho: &[f64], sigma: &[f64], field: Given) -> Multistep<'static> {
        Multistep::new(rho.to_vec(), sigma.to_vec(), Arc::new(field), Box::new(Shift(0))).expect("no mass matrix")
    }

    /// 2 v₂ = 3/2 v₁ + 1/2 v₀ + h (f₀/2 + f₁/4 + f₂) on v̇ = (t, v₀, −v₁) from (1, 2, 4) at t = 1, h = 1/2. By hand:
    /// v₁ = (3/2, 5/2, 9/2) from the start; what is known of v₂ is (51, 83, 127)/32, to which f(2, v₂)/4 comes, one component
    /// after the other: 67/32; 83/32 + 67/128 = 399/128; 127/32 − 399/512 = 1633/512.
    #[test]
    fn an_implicit_formula_weighs_the_values_and_slopes_of_its_steps_and_solves_for_the_last() {
        let rates = |t: f64, v: &[f64]| [t, v[0], -v[1]];
        let field = given(rates, |_, _| vec![(1, 0, 1.0), (2, 1, -1.0)]);
        let mut method = multistep(&[-0.5, -1.5, 2.0], &[0.5, 0.25, 1.0], field);
        let mut state = State::new(1.0, vec![1.0, 2.0, 4.0]);
        let grid = Grid::new(1.0, 0.5, 2.0).expect("a grid");
        method.advance(&mut state, &grid).expect("the start");
        assert_eq!(state, State::new(1.5, vec![1.5, 2.5, 4.5]));
        method.advance(&mut state, &grid).expect("a step");
        let end = State::new(2.0, vec![67.0 / 32.0, 399.0 / 128.0, 1633.0 / 512.0]);
        assert_eq!((method.dim(), &state), (3, &end));
        // f at three points, and in two iterations and after them; the steps of the start are not counted twice.
        let work = Work { steps: 2, residuals: 100 + 3 + 3, factorizations: 2, ..Work::default() };
        assert_eq!(method.work(), work);
        method.advance(&mut state, &grid).expect("nothing");
        assert_eq!((state, method.work()), (end, work));
    }

    /// v_{n+1} = v_n + h (3 f_n − f_{n−1})/2 on v̇ = (t, v₀) from (1, 1) at t = 1, h = 1/2. By hand: v₁ = 3/2 from the start,
    /// v₂ = 3/2 + (9/4 − 1/2)/2 = 19/8 in both, v₃ = 19/8 + (3 − 3/4)/2 and 19/8 + (57/16 − 3/4)/2.
    #[test]
    fn an_explicit_formula_goes_on_with_its_last_steps_and_solves_nothing() {
        let field = given(|t, v| [t, v[0]], |_, _| panic!("no derivative is needed"));
        let mut method = multistep(&[0.0, -1.0, 1.0], &[-0.5, 1.5, 0.0], field);
        let mut state = State::new(1.0, vec![1.0, 1.0]);
        let grid = Grid::new(1.0, 0.5, 2.5).expect("a grid");
        for expected in [[1.5, 1.5], [19.0 / 8.0, 19.0 / 8.0], [7.0 / 2.0, 121.0 / 32.0]] {
            method.advance(&mut state, &grid).expect("a step");
            assert_eq!(state.q, expected);
        }
        assert_eq!(state.t, 2.5);
        assert_eq!(method.work(), Work { steps: 3, residuals: 100 + 4, ..Work::default() });
    }

    /// Steps may differ by 10⁻⁹ of their size, which is 2⁻¹⁰ here.
    #[test]
    fn a_formula_is_started_anew_where_its_last_step_does_not_lead_to_the_present_one() {
        let h = 0.5_f64.powi(10);
        let starts = |size: f64, change: &dyn Fn(&mut State)| {
            let mut method = multistep(&[0.0, -1.0, 1.0], &[-0.5, 1.5, 0.0], given(|_, _| [1.0], |_, _| Vec::new()));
            let mut state = State::new(0.0, vec![1.0]);
            method.advance(&mut state, &Grid::new(0.0, h, 1.0).expect("a grid")).expect("the start");
            change(&mut state);
            let grid = Grid::new(state.t, size, 1.0).expect("a grid");
            (0..2).for_each(|_| method.advance(&mut state, &grid).expect("a step"));
            method.start.work().residuals / 100
        };
        for (size, count) in [
            (h, 1),
            (h * (1.0 + 0.5_f64.powi(32)), 1),
            (h * (1.0 - 0.5_f64.powi(32)), 1),
            (h * (1.0 + 0.5_f64.powi(20)), 2),
            (h * (1.0 - 0.5_f64.powi(20)), 2),
            (2.0 * h, 2),
        ] {
            assert_eq!(starts(size, &|_| ()), count, "{size:e}");
        }
        assert_eq!(starts(h, &|state| state.q[0] += 1.0), 2);
        assert_eq!(starts(h, &|state| state.t += h), 2);
    }

    /// v₁ = v₀ + h f₁ on v̇ = 2t − v: (v₀ + 2 h t₁)/(1 + h).
    #[test]
    fn a_formula_of_one_step_needs_no_start() {
        let field = given(|t, v| [2.0 * t - v[0]], |_, _| vec![(0, 0, -1.0)]);
        let mut method = multistep(&[-1.0, 1.0], &[0.0, 1.0], field);
        let mut state = State::new(1.0, vec![3.0]);
        method.advance(&mut state, &Grid::new(1.0, 1.0, 3.0).expect("a grid")).expect("a step");
        assert_eq!(state, State::new(2.0, vec![3.5]));
        assert_eq!(method.start.work(), Work::default());
    }

    #[test]
    fn a_formula_that_overflows_or_finds_no_solution_leaves_the_state() {
        let grid = Grid::new(1.0, 0.5, 2.0).expect("a grid");
        let before = State::new(1.0, vec![1.0, f64::MAX]);
        let attempt = |sigma: [f64; 2], slope: f64| {
            let field = given(move |_, v| [v[0], slope * v[1]], |_, _| Vec::new());
            let mut state = before.clone();
            let error = multistep(&[-1.0, 1.0], &sigma, field).advance(&mut state, &grid);
            assert_eq!(state, before);
            error
        };
        let overflow = SystemError::NonFinite { what: "v", index: 1, value: f64::INFINITY };
        assert_eq!(attempt([4.0, 0.0], 1.0), Err(InputError::System(overflow).into()));
        let unsolved = StepError::Solve { t: 1.0, h: 0.5, source: SolveError::NonFinite };
        assert_eq!(attempt([0.0, 1.0], 2.0), Err(unsolved));
    }
}
