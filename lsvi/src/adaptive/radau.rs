//! Radau IIA of order 5 with adaptive steps ([HW96] IV.8).

use super::coefficients::Coefficients;
use super::controller::{Controller, Tolerances, weighted_norm};
use crate::error::{InputError, SolveError, StepError, check_vector};
use crate::integrator::{Grid, Integrator, State};
use crate::linalg::{FactorError, Jacobian, Lu, Structure};
use crate::mass::Mass;
use crate::newton::Work;
use crate::vector_field::VectorField;

/// Newton iterations of a step.
const ITERATIONS: u32 = 7;
/// Rate of convergence up to which the Jacobian is kept for the next step.
const KEEP_JACOBIAN: f64 = 1e-3;
/// Growth of the step size up to which it is not changed, and the factors are kept.
const KEEP_FACTORS: std::ops::RangeInclusive<f64> = 1.0..=1.2;

/// The three-stage Radau IIA method on M v̇ = f(t, v), with steps chosen to hold the local error: order 5, L-stable, the
/// collocation method that every closure gives with three Radau nodes on paths of degree 3.
///
/// The stages are decoupled into a real system of order n and a complex one, solved as a real system of order 2n in the
/// structure of the Jacobian. Jacobians and factors are kept while Newton's iteration converges well. The error estimate
/// is of order 3; the singular M of algebraic equations of index 1 is allowed.
///
/// [`Integrator::advance`] takes one accepted step, never longer than the grid's h and never past its end or a
/// [stop time](Self::stop_at). Between its ends [`interpolate`](Self::interpolate) gives the solution.
///
/// ```
/// # use lsvi::{AutoDiff, Rhs, Scalar, State, Trajectory, adaptive::{Radau, Tolerances}};
/// struct Fast;
/// impl Rhs for Fast {
///     fn dim(&self) -> usize { 1 }
///     fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) { dv[0] = (v[0] - t.cos()) * -1e6; }
/// }
/// let method = Radau::new(AutoDiff::new(Fast), Tolerances::new(1e-6, 1e-9)?)?;
/// let end = Trajectory::new(method, State::new(0.0, vec![0.0]), 10.0, 10.0)?.observe(|_| {})?;
/// assert!((end.q[0] - 10_f64.cos()).abs() < 1e-5);
/// # Ok::<(), lsvi::StepError>(())
/// ```
#[derive(Debug)]
pub struct Radau<F> {
    field: F,
    mass: Mass,
    coefficients: Coefficients,
    tolerances: Tolerances,
    controller: Controller,
    /// Sorted times that no step passes.
    stops: Vec<f64>,
    /// What the next step is to be, unless the grid or a stop time makes it shorter.
    next_h: Option<f64>,
    history: Option<History>,
    system: StageSystem,
    stages: Stages,
    work: Work,
    rejected: u64,
}

/// The last accepted step: its stages are in [`Stages::accepted`].
#[derive(Debug, Clone, Copy)]
struct History {
    /// Start.
    t: f64,
    h: f64,
    /// The end, as the state was given it.
    end: f64,
}

#[derive(Debug)]
struct Stages {
    /// Zᵢ = Yᵢ − v.
    z: [Vec<f64>; 3],
    /// T⁻¹ Z.
    w: [Vec<f64>; 3],
    f: [Vec<f64>; 3],
    /// Z of the last accepted step.
    accepted: [Vec<f64>; 3],
    /// v at the start and at the end of that step.
    from: Vec<f64>,
    to: Vec<f64>,
    f0: Vec<f64>,
    scale: Vec<f64>,
    combined: Vec<f64>,
    stage: Vec<f64>,
    single: Vec<f64>,
    double: Vec<f64>,
}

/// The matrices γ M/h − J and [[α M/h − J, β M/h], [−β M/h, α M/h − J]], the latter with interleaved unknowns so that a
/// narrow band stays narrow.
#[derive(Debug)]
struct StageSystem {
    jacobian: Jacobian,
    single: Jacobian,
    double: Jacobian,
    single_lu: Lu,
    double_lu: Lu,
    /// Whether the Jacobian is that of the present state.
    is_current: bool,
    /// Whether a Jacobian is there at all.
    has_jacobian: bool,
    /// Step size that the factors belong to.
    factored: Option<f64>,
    /// Convergence factor θ/(1 − θ) of the last iteration with these factors.
    contraction: f64,
}

/// How Newton's iteration ended.
enum Iteration {
    /// With this rate after so many iterations.
    Converged {
        rate: f64,
        iterations: u32,
    },
    Failed,
}

fn vectors(n: usize) -> [Vec<f64>; 3] {
    std::array::from_fn(|_| vec![0.0; n])
}

/// The structure of 2 × 2 blocks in place of entries.
fn doubled(structure: &Structure, n: usize) -> Result<Structure, InputError> {
    Ok(match structure {
        Structure::Dense | Structure::MatrixFree => structure.clone(),
        Structure::Banded { lower, upper } => {
            let twice = |width: usize| width.saturating_mul(2).saturating_add(1);
            Structure::Banded { lower: twice(*lower), upper: twice(*upper) }
        }
        Structure::Sparse(_) => {
            let entries = (0..n).flat_map(|j| structure.rows(n, j).map(move |i| (i, j)));
            // Only M couples the two parts, and M may have any entry of the structure.
            let block = |(i, j)| [0, 1].into_iter().flat_map(move |a| [0, 1].map(|b| (2 * i + a, 2 * j + b)));
            Structure::sparse(2 * n, entries.flat_map(block))?
        }
    })
}

impl StageSystem {
    fn new(n: usize, structure: &Structure) -> Result<Self, InputError> {
        let single = Jacobian::with_structure(n, structure);
        let double = Jacobian::with_structure(2 * n, &doubled(structure, n)?);
        Ok(Self {
            jacobian: single.clone(),
            single_lu: Lu::of(&single),
            double_lu: Lu::of(&double),
            single,
            double,
            is_current: false,
            has_jacobian: false,
            factored: None,
            contraction: 1.0,
        })
    }

    fn factor(&mut self, c: &Coefficients, mass: &Mass, h: f64) -> Result<(), FactorError> {
        self.factored = None;
        self.jacobian.check_structure()?;
        let (single, double) = (&mut self.single, &mut self.double);
        single.clear();
        double.clear();
        self.jacobian.for_each(|i, j, x| {
            single.add(i, j, -x);
            double.add(2 * i, 2 * j, -x);
            double.add(2 * i + 1, 2 * j + 1, -x);
        });
        mass.for_each(single.dim(), |i, j, m| {
            single.add(i, j, c.gamma / h * m);
            double.add(2 * i, 2 * j, c.alpha / h * m);
            double.add(2 * i, 2 * j + 1, c.beta / h * m);
            double.add(2 * i + 1, 2 * j, -c.beta / h * m);
            double.add(2 * i + 1, 2 * j + 1, c.alpha / h * m);
        });
        self.single_lu.factor(single)?;
        self.double_lu.factor(double)?;
        self.factored = Some(h);
        self.contraction = 1.0;
        Ok(())
    }
}

impl<F: VectorField> Radau<F> {
    /// The method on `field` with the given tolerances.
    ///
    /// # Errors
    /// [`InputError`] if the mass matrix of the field does not fit it.
    pub fn new(field: F, tolerances: Tolerances) -> Result<Self, InputError> {
        let n = field.dim();
        let mass = field.mass();
        mass.check(n)?;
        let stages = Stages {
            z: vectors(n),
            w: vectors(n),
            f: vectors(n),
            accepted: vectors(n),
            from: vec![0.0; n],
            to: vec![0.0; n],
            f0: vec![0.0; n],
            scale: vec![0.0; n],
            combined: vec![0.0; n],
            stage: vec![0.0; n],
            single: vec![0.0; n],
            double: vec![0.0; 2 * n],
        };
        Ok(Self {
            system: StageSystem::new(n, &field.structure())?,
            coefficients: Coefficients::new()?,
            controller: Controller::default(),
            stops: Vec::new(),
            next_h: None,
            history: None,
            work: Work::default(),
            rejected: 0,
            tolerances,
            stages,
            mass,
            field,
        })
    }

    /// Ends a step at each of `times`, in place of those given before.
    ///
    /// # Errors
    /// [`InputError::NonFinite`] for a time that is not finite.
    pub fn stop_at(&mut self, times: &[f64]) -> Result<(), InputError> {
        check_vector("stop times", times, times.len())?;
        self.stops = times.to_vec();
        self.stops.sort_by(f64::total_cmp);
        Ok(())
    }

    /// Steps that were rejected, or given up because Newton's iteration did not converge.
    pub fn rejected(&self) -> u64 {
        self.rejected
    }

    /// Writes the solution at a time within the last step, to the order 3 of the collocation polynomial.
    ///
    /// # Errors
    /// [`InputError::Outside`] if no accepted step contains `t`, [`InputError::Dimension`] if `out` has the wrong length.
    pub fn interpolate(&self, t: f64, out: &mut [f64]) -> Result<(), InputError> {
        if out.len() != self.stages.from.len() {
            return Err(InputError::Dimension { what: "out", expected: self.stages.from.len(), found: out.len() });
        }
        let Some(History { t: start, h, end }) = self.history.filter(|last| t >= last.t && t <= last.end) else {
            let (from, to) = self.history.map_or((f64::NAN, f64::NAN), |last| (last.t, last.end));
            return Err(InputError::Outside { t, from, to });
        };
        if t == end {
            out.copy_from_slice(&self.stages.to);
            return Ok(());
        }
        let weights = self.coefficients.weights((t - start) / h);
        out.copy_from_slice(&self.stages.from);
        for (z, w) in self.stages.accepted.iter().zip(&weights[1..]) {
            out.iter_mut().zip(z).for_each(|(o, z)| *o += w * z);
        }
        Ok(())
    }

    /// Takes the state as a new start unless it is where the last step ended.
    fn resume(&mut self, state: &State) {
        let continues = self.history.is_some_and(|last| last.end == state.t) && self.stages.to == state.q;
        if !continues {
            self.history = None;
            self.next_h = None;
            self.controller.restart();
            self.system.has_jacobian = false;
            self.system.factored = None;
        }
        self.system.is_current &= continues && self.system.has_jacobian;
    }

    /// A first step that changes v by about a hundredth, or is tiny where nothing can be said.
    fn first_step(&self, v: &[f64]) -> f64 {
        let Stages { scale, f0, .. } = &self.stages;
        let (size, slope) = (weighted_norm(v, scale), weighted_norm(f0, scale));
        if size > 1e-5 && slope > 1e-5 { 0.01 * size / slope } else { 1e-6 }
    }

    /// The time that the next step may not pass.
    fn barrier(&self, t: f64, grid: &Grid) -> f64 {
        let resolved = t + 8.0 * f64::EPSILON * t.abs().max(grid.t_end().abs());
        let stop = self.stops.iter().copied().find(|stop| *stop > resolved);
        stop.map_or(grid.t_end(), |stop| stop.min(grid.t_end()))
    }

    /// Starts the stages from the collocation polynomial of the last step.
    fn predict(&mut self, h: f64) {
        let Stages { z, w, accepted, .. } = &mut self.stages;
        match self.history {
            None => z.iter_mut().chain(w.iter_mut()).for_each(|x| x.fill(0.0)),
            Some(last) => {
                for (z, c) in z.iter_mut().zip(&self.coefficients.points[1..]) {
                    let weights = self.coefficients.weights(1.0 + c * h / last.h);
                    for (k, z) in z.iter_mut().enumerate() {
                        let end = accepted[2][k];
                        *z = accepted.iter().zip(&weights[1..]).map(|(a, w)| w * a[k]).sum::<f64>() - end;
                    }
                }
                transform(&self.coefficients.t_inverse, z, w);
            }
        }
    }

    /// Simplified Newton iteration for the stages.
    fn iterate(&mut self, t: f64, h: f64, v: &[f64]) -> Iteration {
        self.predict(h);
        let c = &self.coefficients;
        let Stages { z, w, f, combined, stage, single, double, scale, .. } = &mut self.stages;
        let held = self.tolerances.for_estimate().rtol();
        // Well below the error of the step, and above roundoff.
        let goal = (10.0 * f64::EPSILON / held).max(held.sqrt().min(0.03));
        let mut contraction = self.system.contraction.max(f64::EPSILON).powf(0.8);
        let (mut last, mut rate) = (f64::INFINITY, 0.0_f64);
        for iterations in 1..=ITERATIONS {
            for ((z, f), c) in z.iter().zip(f.iter_mut()).zip(&c.points[1..]) {
                for ((y, v), z) in stage.iter_mut().zip(v).zip(z) {
                    *y = v + z;
                }
                self.field.rhs(t + c * h, stage, f);
            }
            self.work.residuals += 1;
            // (T⁻¹ F) − Λ M W/h, the first row and the other two.
            let rows = [[c.gamma, 0.0, 0.0], [0.0, c.alpha, c.beta], [0.0, -c.beta, c.alpha]];
            for (i, row) in rows.iter().enumerate() {
                for (k, x) in combined.iter_mut().enumerate() {
                    *x = row.iter().zip(w.iter()).map(|(r, w)| r * w[k]).sum();
                }
                for (k, r) in stage.iter_mut().enumerate() {
                    *r = (0..3).map(|j| c.t_inverse[(i, j)] * f[j][k]).sum();
                }
                self.mass.mul_add(-h.recip(), combined, stage);
                match i {
                    0 => single.copy_from_slice(stage),
                    _ => stage.iter().enumerate().for_each(|(k, r)| double[2 * k + i - 1] = *r),
                }
            }
            self.system.single_lu.solve(single);
            self.system.double_lu.solve(double);
            let mut sum = 0.0;
            for (k, scale) in scale.iter().enumerate() {
                for (w, d) in w.iter_mut().zip([single[k], double[2 * k], double[2 * k + 1]]) {
                    w[k] += d;
                    sum += (d / scale).powi(2);
                }
            }
            let size = (sum / (3.0 * scale.len() as f64)).sqrt();
            if !size.is_finite() {
                return Iteration::Failed;
            }
            transform(&c.t, w, z);
            if last.is_finite() {
                let ratio = size / last;
                rate = if rate == 0.0 { ratio } else { (ratio * rate).sqrt() };
                let left = (ITERATIONS - iterations) as i32;
                if rate >= 0.99 || rate.powi(left) / (1.0 - rate) * size > goal {
                    return Iteration::Failed;
                }
                contraction = rate / (1.0 - rate);
            }
            last = size.max(f64::MIN_POSITIVE);
            if contraction * size <= goal {
                self.system.contraction = contraction;
                return Iteration::Converged { rate, iterations };
            }
        }
        Iteration::Failed
    }

    /// The embedded estimate in units of the tolerance.
    fn estimate(&mut self, t: f64, h: f64, v: &[f64]) -> f64 {
        let Stages { z, f0, combined, stage, single, scale, .. } = &mut self.stages;
        for (k, x) in combined.iter_mut().enumerate() {
            *x = self.coefficients.estimate.iter().zip(z.iter()).map(|(e, z)| e * z[k]).sum();
        }
        single.copy_from_slice(f0);
        self.mass.mul_add(h.recip(), combined, single);
        self.system.single_lu.solve(single);
        let first = weighted_norm(single, scale);
        if first < 1.0 || !self.controller.is_cautious() {
            return first.max(1e-10);
        }
        // The filtered estimate is right for hλ ≫ 1 too, where the first is far too large.
        for ((y, v), e) in stage.iter_mut().zip(v).zip(single.iter()) {
            *y = v + e;
        }
        self.field.rhs(t, stage, single);
        self.work.residuals += 1;
        self.mass.mul_add(h.recip(), combined, single);
        self.system.single_lu.solve(single);
        weighted_norm(single, scale).max(1e-10)
    }

    /// Builds the Jacobian and the factors that a step of size `h` lacks.
    fn prepare(&mut self, t: f64, h: f64, v: &[f64]) -> Result<(), FactorError> {
        if !self.system.has_jacobian {
            self.system.jacobian.clear();
            self.field.add_jacobian(t, v, 1.0, &mut self.system.jacobian);
            (self.system.has_jacobian, self.system.is_current, self.system.factored) = (true, true, None);
        }
        if self.system.factored == Some(h) {
            return Ok(());
        }
        self.work.factorizations += 1;
        self.system.factor(&self.coefficients, &self.mass, h)
    }

    /// Makes the stages of a step the last accepted ones and chooses what to keep for the next.
    fn accept(&mut self, state: &mut State, h: f64, end: f64, proposed: f64, rate: f64) {
        let Stages { z, accepted, from, to, .. } = &mut self.stages;
        for (kept, z) in accepted.iter_mut().zip(z.iter()) {
            kept.copy_from_slice(z);
        }
        from.copy_from_slice(&state.q);
        state.q.iter_mut().zip(&z[2]).for_each(|(v, z)| *v += z);
        to.copy_from_slice(&state.q);
        self.history = Some(History { t: state.t, h, end });
        state.t = end;
        self.work.steps += 1;
        let keeps_jacobian = rate <= KEEP_JACOBIAN;
        let keeps_step = keeps_jacobian && KEEP_FACTORS.contains(&(proposed / h));
        self.next_h = Some(if keeps_step { h } else { proposed });
        self.system.has_jacobian = keeps_jacobian;
        self.system.is_current = false;
    }
}

/// Writes the combinations out_i = Σ a_ij x_j.
fn transform(a: &nalgebra::Matrix3<f64>, x: &[Vec<f64>; 3], out: &mut [Vec<f64>; 3]) {
    for (i, out) in out.iter_mut().enumerate() {
        for (k, o) in out.iter_mut().enumerate() {
            *o = (0..3).map(|j| a[(i, j)] * x[j][k]).sum();
        }
    }
}

impl<F: VectorField> Integrator for Radau<F> {
    fn dim(&self) -> usize {
        self.field.dim()
    }

    /// One accepted step of at most the grid's h.
    fn advance(&mut self, state: &mut State, grid: &Grid) -> Result<(), StepError> {
        if grid.next(state.t).is_none() {
            return Ok(());
        }
        check_vector("q", &state.q, self.field.dim())?;
        self.resume(state);
        let t = state.t;
        self.tolerances.for_estimate().scale(&state.q, &mut self.stages.scale);
        self.field.rhs(t, &state.q, &mut self.stages.f0);
        self.work.residuals += 1;
        let span = self.barrier(t, grid) - t;
        let failed = |h: f64, source: SolveError| StepError::Solve { t, h, source };
        if self.stages.f0.iter().any(|f| !f.is_finite()) {
            return Err(failed(span, SolveError::NonFinite));
        }
        let mut wanted = self.next_h.unwrap_or_else(|| self.first_step(&state.q)).min(grid.h());
        loop {
            // The last two steps before a stop are made equal, so that none is a sliver.
            let (h, stops) = match span / wanted {
                steps if steps <= 1.0 + 1e-9 => (span, true),
                steps if steps < 2.0 => (0.5 * span, false),
                _ => (wanted, false),
            };
            if h <= 8.0 * f64::EPSILON * t.abs() || h < f64::MIN_POSITIVE {
                return Err(StepError::StepUnderflow { t, h });
            }
            let iteration = match self.prepare(t, h, &state.q) {
                Ok(()) => self.iterate(t, h, &state.q),
                Err(FactorError::Singular) => Iteration::Failed,
                Err(error) => return Err(failed(h, error.into())),
            };
            let Iteration::Converged { rate, iterations } = iteration else {
                self.rejected += 1;
                self.controller.failed();
                // An old Jacobian may be the reason; a present one leaves the step size.
                if self.system.is_current {
                    wanted = 0.5 * h;
                } else {
                    self.system.has_jacobian = false;
                }
                continue;
            };
            let error = self.estimate(t, h, &state.q);
            if error.is_nan() {
                return Err(failed(h, SolveError::NonFinite));
            }
            let effort = f64::from(iterations - 1) / f64::from(ITERATIONS);
            let proposed = self.controller.next(h, error, effort);
            if error < 1.0 {
                let end = if stops { self.barrier(t, grid) } else { t + h };
                // A step cut short by a stop does not shorten the ones after it.
                let proposed = if h < wanted { proposed.max(wanted) } else { proposed };
                self.accept(state, h, end, proposed, rate);
                return Ok(());
            }
            self.rejected += 1;
            wanted = proposed;
        }
    }

    fn work(&self) -> Work {
        self.work
    }
}
