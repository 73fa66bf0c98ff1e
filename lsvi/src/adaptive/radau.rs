//! Radau IIA of order 5, 9 and 13 with adaptive steps ([HW96] IV.8).

use super::coefficients::{Coefficients, five, seven, three};
use super::controller::Controller;
use super::history::{History, Last};
use super::options::Options;
use super::stages::{Equations, Iteration, StageSystem, Stages, iterations};
use super::tolerances::{root_mean, squared};
use crate::error::{InputError, SolveError, StepError, SystemError, check_time, check_vector};
use crate::integrator::{Grid, Integrator, State};
use crate::linalg::{FactorError, Jacobian};
use crate::mass::{Mass, rate};
use crate::newton::Work;
use crate::vector_field::{VectorField, check_system};

/// Rate of convergence up to which the Jacobian is kept for the next step.
const KEEP_JACOBIAN: f64 = 1e-3;
/// Rate of convergence that the next step may have, as far as this one foretells it, with three stages; with more the order falls.
const BEARABLE: f64 = 0.5;
/// Growth of the step size up to which it is not changed, and the factors are kept.
const KEEP_FACTORS: std::ops::RangeInclusive<f64> = 1.0..=1.2;
/// The order rises where Newton's iteration contracts by this and the step size settles, and falls where it contracts by
/// no more than that ([HW99]).
const RISE: f64 = 2e-3;
const FALL: f64 = 0.8;
const SETTLED: std::ops::RangeInclusive<f64> = 0.8..=1.2;
/// Steps after a fall of the order before it may rise again.
const PATIENCE: u32 = 10;

/// The Radau IIA methods with three, five and seven stages on M v̇ = f(t, v), with steps and an order chosen to hold the local
/// error: order 5, 9 and 13, L-stable, the collocation methods that every closure that determines the step gives with s Radau
/// nodes on paths of degree s.
///
/// The stages are decoupled into a real system of order n and (s − 1)/2 complex ones, in the structure of the Jacobian.
/// Jacobians and factors are kept while Newton's iteration converges well, and the order rises with its contraction. The
/// error estimate is of order s.
///
/// # Algebraic equations
/// The singular M of algebraic equations of index 1 is allowed. A start must satisfy them: where a row of M is zero, a start
/// that does not to within the tolerances is refused, [`SystemError::InconsistentStart`]. Where M is singular without such a
/// row, as in M = (1 1; 1 1), a start is not checked. If f is linear, the first step ends on the algebraic equations although its start is off them,
/// and its dense output joins the two; if f is not, no step size may be found.
///
/// [`Integrator::advance`] takes one accepted step, never longer than the grid's h and never past its end or a
/// [stop time](Self::stop_at). Between its ends [`interpolate`](Self::interpolate) gives the solution.
///
/// ```
/// # use lsvi::{AutoField, FieldFn, Scalar, State, Trajectory, adaptive::{Radau, Tolerances}};
/// struct Fast;
/// impl FieldFn for Fast {
///     fn dim(&self) -> usize { 1 }
///     fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) { dv[0] = (v[0] - t.cos()) * -1e6; }
/// }
/// let method = Radau::new(AutoField::new(Fast), Tolerances::new(1e-6, 1e-9)?)?;
/// let end = Trajectory::new(method, State::new(0.0, vec![0.0]), 10.0, 10.0)?.observe(|_| {})?;
/// assert!((end.q[0] - 10_f64.cos()).abs() < 1e-5);
/// # Ok::<(), lsvi::StepError>(())
/// ```
#[derive(Debug)]
pub struct Radau<F> {
    field: F,
    mass: Mass,
    /// The equations in which no v̇ occurs.
    algebraic: Vec<usize>,
    options: Options,
    controller: Controller,
    /// Sorted times that no step passes.
    stops: Vec<f64>,
    /// What the next step is to be, unless the grid or a stop time makes it shorter.
    next_h: Option<f64>,
    order: Order,
    history: History,
    system: StageSystem,
    stages: Stages,
    work: Work,
    rejected: u64,
    /// The run that the last step belongs to, unless an error ended it.
    run: Option<Grid>,
    /// Steps tried in it.
    tried: u64,
}

/// The number of stages, and how long it has been allowed to rise no more.
#[derive(Debug)]
struct Order {
    s: usize,
    wait: u32,
}

/// Runs `$body` with `$c` the coefficients of `$s` stages. They were computed when the method was built.
macro_rules! with_coefficients {
    ($s:expr, $c:ident => $body:expr) => {
        match $s {
            5 => five().map(|$c| $body),
            7 => seven().map(|$c| $body),
            _ => three().map(|$c| $body),
        }
    };
}

impl<F: VectorField> Radau<F> {
    /// The method on `field` with the given [`Tolerances`](super::Tolerances) or [`Options`].
    ///
    /// # Errors
    /// [`InputError`] if the mass matrix of the field does not fit it or its structure, or the number of absolute
    /// tolerances is not that of its components.
    pub fn new(field: F, options: impl Into<Options>) -> Result<Self, InputError> {
        let mut options = options.into();
        let n = field.dim();
        options.tolerances = options.tolerances.expanded(n)?;
        let mass = field.mass();
        check_system(&field)?;
        let jacobian = Jacobian::with_structure(n, &field.structure());
        mass.check_within(&jacobian)?;
        for s in [3, 5, 7] {
            with_coefficients!(s, c => debug_assert_eq!(c.nodes.len(), s))?;
        }
        let most = options.most;
        Ok(Self {
            system: StageSystem::new(jacobian, most),
            stages: Stages::new(n, most),
            history: History::new(n, most),
            controller: Controller::new(options.safety),
            stops: Vec::new(),
            next_h: None,
            order: Order { s: options.fewest, wait: 0 },
            work: Work::default(),
            rejected: 0,
            run: None,
            tried: 0,
            options,
            algebraic: mass.zero_rows(n),
            mass,
            field,
        })
    }

    /// Ends a step at each of `times`, in place of those given before. Where f jumps in time there, it may have its new value at that time or
    /// its old one: the step that ends there, or at the end of the run, evaluates f just before.
    ///
    /// ```
    /// # use lsvi::{State, Trajectory, adaptive::{Radau, Tolerances}, field};
    /// // v̇ = 1 − v from t = 1 on.
    /// let switched = field!(1, |t, v, dv| dv[0] = -v[0] + if t >= 1.0 { 1.0 } else { 0.0 });
    /// let mut method = Radau::new(switched, Tolerances::new(1e-10, 1e-10)?)?;
    /// method.stop_at(&[1.0])?;
    /// let end = Trajectory::new(method, State::new(0.0, vec![0.0]), 2.0, 2.0)?.observe(|_| {})?;
    /// assert!((end.q[0] - (1.0 - (-1_f64).exp())).abs() < 1e-9);
    /// # Ok::<(), lsvi::StepError>(())
    /// ```
    ///
    /// # Errors
    /// [`SystemError::NonFinite`] for a time that is not finite.
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

    /// The number of stages of the next step.
    pub fn stages(&self) -> usize {
        self.order.s
    }

    /// Writes the solution at a time within the last step by its collocation polynomial, with an error of order
    /// s + 1 ≥ 4 in h between the nodes.
    ///
    /// # Errors
    /// [`TimeError::NoStep`](crate::TimeError::NoStep) before the first step, [`TimeError::Outside`](crate::TimeError::Outside) if the last one does not contain `t`,
    /// [`SystemError::Dimension`] if `out` has the wrong length.
    pub fn interpolate(&self, t: f64, out: &mut [f64]) -> Result<(), InputError> {
        if out.len() != self.history.to.len() {
            return Err(InputError::System(SystemError::Dimension {
                what: "out",
                expected: self.history.to.len(),
                found: out.len(),
            }));
        }
        let last = self.history.at(t)?;
        if t == last.end {
            out.copy_from_slice(&self.history.to);
            return Ok(());
        }
        let part = (t - last.t) / last.h;
        with_coefficients!(last.s, c => self.history.value(c, part, out))
    }

    /// Takes the state as a new start unless it is where the last step ended, and another grid, or the same after an error, as another run.
    fn resume(&mut self, state: &State, grid: &Grid) {
        if self.run.take() != Some(*grid) {
            self.tried = 0;
        }
        let continues = self.history.last.is_some_and(|last| last.end == state.t) && self.history.to == state.q;
        if !continues {
            self.history.last = None;
            self.next_h = None;
            self.tried = 0;
            self.order = Order { s: self.options.fewest, wait: 0 };
            self.controller.restart();
            self.system.leave(false);
        }
    }

    /// Refuses a start that violates an algebraic equation, by f(t, v).
    fn check_start(&mut self, t: f64, h: f64, v: &[f64]) -> Result<(), StepError> {
        if self.history.last.is_some() || self.algebraic.is_empty() {
            return Ok(());
        }
        let Stages { f0, single: allowed, .. } = &mut self.stages;
        let known = self.system.tolerated_change((&self.field, &self.options.tolerances), (t, v), allowed);
        known.map_err(|error| StepError::Solve { t, h, source: error.into() })?;
        match self.algebraic.iter().find(|&&row| f0[row].abs() > allowed[row]) {
            Some(&row) => {
                let (value, allowed) = (f0[row], allowed[row]);
                Err(InputError::System(SystemError::InconsistentStart { row, value, allowed }).into())
            }
            None => Ok(()),
        }
    }

    /// A first step that changes v by a hundredth or by what is tolerated; where v stands still a thousandth of the span. Where M is 1 and f grows
    /// along it by more than it is, or else changes by more than that beyond what its derivative tells, no factors of the start
    /// would lead to its end: the power s + 1 of the step is cut to what changes v so by a hundredth of what is tolerated,
    /// like that of [HNW93] II.4 but whatever the unit of time. One that is too long is rejected once or twice, one that is too
    /// short grows for long.
    fn first_step(&mut self, t: f64, v: &[f64], span: f64) -> f64 {
        let Self { field, mass, system, stages: Stages { f0, stage, slope, .. }, options, work, .. } = self;
        let tolerances = &options.tolerances;
        let norm = |x: &[f64]| {
            // A component that starts at zero with no atol says nothing.
            let terms = x.iter().zip(v).enumerate().filter(|(k, (_, v))| !tolerances.knows_no_size(*k, v.abs()));
            let sum = terms.map(|(k, (x, v))| squared(*x, tolerances.of(k, v.abs()).recip())).sum();
            root_mean(sum, v.len())
        };
        let (size, rate) = (norm(v), norm(f0));
        if rate <= 0.0 {
            return 1e-3 * span;
        }
        let shortest = 2.0 * resolved(t);
        let h = ((0.01 * size).max(1.0) / rate).min(span);
        if !matches!(mass, Mass::Identity) || h <= shortest {
            return h.max(shortest);
        }
        stage.iter_mut().zip(v).zip(&*f0).for_each(|((y, v), f)| *y = v + h * f);
        field.rhs(t + h, stage, slope);
        work.residuals += 1;
        slope.iter_mut().zip(&*f0).for_each(|(x, f)| *x -= f);
        let growth = slope.iter().zip(&*f0).zip(v).enumerate().map(|(k, ((x, f), v))| {
            let of = tolerances.of(k, v.abs());
            if tolerances.knows_no_size(k, v.abs()) { 0.0 } else { (x / of) * (f / of) }
        });
        if growth.sum::<f64>() <= 0.0 {
            system.subtract_change(&*field, (t, v), (h, f0), slope);
        }
        let change = norm(slope);
        // Beyond the domain of f nothing is known.
        if change > rate && change.is_finite() {
            h.min(h * (0.01 / (h * change)).powf(1.0 / (self.order.s + 1) as f64)).max(shortest)
        } else {
            h
        }
    }

    /// The stop time that comes next.
    fn next_stop(&self, t: f64) -> Option<f64> {
        let resolved = t + 8.0 * f64::EPSILON * t.abs();
        self.stops.get(self.stops.partition_point(|stop| *stop <= resolved)).copied()
    }

    /// Solves for the stages of a step, which is `part` of what the tolerances allow and in which f is not evaluated after `latest`, and the error of the step in units of what it is held to.
    fn attempt<const S: usize>(
        &mut self,
        c: &'static Coefficients<S>,
        at @ (_, h, v): (f64, f64, &[f64]),
        (latest, part): (f64, f64),
    ) -> Result<Attempt, FactorError> {
        let Self { field, mass, system, stages, history, options, work, .. } = self;
        let equations = Equations { field: &*field, mass, tolerances: &options.tolerances, latest, part };
        match system.prepare(c, (&*field, mass), at, work) {
            Err(FactorError::Singular) => return Ok(Attempt::Failed { factor: 0.5, was_finite: true }),
            other => other?,
        }
        let z = &mut stages.z[..S * v.len()];
        match history.last {
            None => z.fill(0.0),
            Some(Last { s: 5, h: before, .. }) => extrapolate(history, five(), &c.nodes, h / before, z),
            Some(Last { s: 7, h: before, .. }) => extrapolate(history, seven(), &c.nodes, h / before, z),
            Some(Last { h: before, .. }) => extrapolate(history, three(), &c.nodes, h / before, z),
        }
        match stages.iterate(c, &equations, system, at, work) {
            Iteration::Slow { factor } => Ok(Attempt::Failed { factor, was_finite: true }),
            Iteration::NonFinite => Ok(Attempt::Failed { factor: 0.5, was_finite: false }),
            Iteration::Converged { rate, iterations } => {
                let is_cautious = self.controller.is_cautious();
                let error = stages.estimate(c, &equations, system, at, is_cautious, work);
                Ok(Attempt::Solved { rate, iterations, error })
            }
        }
    }

    /// Makes the stages of a step the last accepted ones and chooses what to keep for the next.
    fn accept(&mut self, state: &mut State, h: f64, end: f64, proposed: f64, rate: f64) {
        let (history, s) = (&mut self.history, self.order.s);
        std::mem::swap(&mut history.z, &mut self.stages.z);
        history.from.copy_from_slice(&state.q);
        state.q.iter_mut().zip(history.z.chunks_exact(s)).for_each(|(v, z)| *v += z[s - 1]);
        history.to.copy_from_slice(&state.q);
        history.last = Some(Last { t: state.t, h, end, s });
        state.t = end;
        self.work.steps += 1;
        // The rate goes like h times the change of the Jacobian within the step, hence like h².
        let bearable = if s == 3 { h * (BEARABLE / rate).sqrt() } else { f64::INFINITY };
        let proposed = proposed.min(bearable);
        let keeps_jacobian = rate <= KEEP_JACOBIAN;
        let keeps_step = keeps_jacobian && KEEP_FACTORS.contains(&(proposed / h));
        self.next_h = Some(if keeps_step { h } else { proposed });
        self.system.leave(keeps_jacobian);
        self.order.wait = self.order.wait.saturating_sub(1);
        if rate >= FALL {
            self.lower_order();
        } else if rate <= RISE && self.order.wait == 0 && SETTLED.contains(&(proposed / h)) && s < self.options.most {
            self.order.s += 2;
            self.controller.forget();
        }
    }

    /// Newton's iteration does not bear the order.
    fn lower_order(&mut self) {
        if self.order.s > self.options.fewest {
            self.order.s -= 2;
            self.controller.forget();
        }
        self.order.wait = PATIENCE;
    }
}

/// What became of a step.
enum Attempt {
    Failed { factor: f64, was_finite: bool },
    Solved { rate: f64, iterations: u32, error: f64 },
}

/// What times near `t` are told apart by.
fn resolved(t: f64) -> f64 {
    (8.0 * f64::EPSILON * t.abs()).max(f64::MIN_POSITIVE)
}

/// The step to try after one of size `h` that asks for `proposed`: first the shortest that is allowed.
fn shorter(h: f64, proposed: f64, shortest: f64) -> f64 {
    if h > shortest { proposed.max(shortest) } else { proposed }
}

fn extrapolate<const S: usize, const N: usize>(
    history: &History,
    last: Result<&'static Coefficients<S>, InputError>,
    nodes: &[f64; N],
    ratio: f64,
    z: &mut [f64],
) {
    match last {
        Ok(c) => history.extrapolate(c, nodes, ratio, z),
        Err(_) => z.fill(0.0),
    }
}

impl<F: VectorField> Integrator for Radau<F> {
    fn dim(&self) -> usize {
        self.field.dim()
    }

    /// One accepted step of at most the grid's h.
    fn advance(&mut self, state: &mut State, grid: &Grid) -> Result<(), StepError> {
        check_time(state.t)?;
        if grid.next(state.t).is_none() {
            return Ok(());
        }
        check_vector("q", &state.q, self.field.dim())?;
        self.resume(state, grid);
        let t = state.t;
        self.field.rhs(t, &state.q, &mut self.stages.f0);
        self.work.residuals += 1;
        let barrier = self.next_stop(t).map_or(grid.t_end(), |stop| stop.min(grid.t_end()));
        let span = barrier - t;
        let failed = |h: f64, source: SolveError| StepError::Solve { t, h, source };
        if self.stages.f0.iter().any(|f| !f.is_finite()) {
            return Err(failed(0.0, SolveError::NonFinite));
        }
        self.check_start(t, span, &state.q)?;
        let longest = self.options.h_max.min(grid.h());
        let shortest = self.options.h_min.min(longest);
        // A first step of the user's may be shorter than times resolve.
        let first = self.next_h.or(self.options.h0.map(|h| h.max(2.0 * resolved(t))));
        let first = first.unwrap_or_else(|| self.first_step(t, &state.q, span));
        let mut wanted = first.max(shortest).min(longest);
        let mut is_finite = true;
        loop {
            // The last two steps before a stop are made equal, so that none is a sliver.
            let (h, stops) = match span / wanted {
                steps if steps <= 1.0 + 1e-9 => (span, true),
                steps if steps < 2.0 && 0.5 * span >= shortest => (0.5 * span, false),
                _ => (wanted, false),
            };
            let is_cut = h < wanted;
            // A step is as long as times tell, or their rounding would add up, as far from t = 0 as that is.
            let end = t + h;
            let h = if stops { span } else { end - t };
            let is_below = wanted < shortest && h < span;
            if h <= resolved(t) || is_below {
                return Err(match is_finite {
                    false => failed(h, SolveError::NonFinite),
                    true if is_below => StepError::BelowShortest { t, h, h_min: self.options.h_min },
                    true => StepError::StepUnderflow { t, h },
                });
            }
            if self.tried >= self.options.max_steps {
                return Err(StepError::TooManySteps { t, limit: self.options.max_steps });
            }
            self.tried += 1;
            let at = (t, h, state.q.as_slice());
            // Beyond a stop, or the end, f may be another one.
            let latest = if stops { barrier.next_down() } else { f64::INFINITY };
            let part = if wanted < longest { 1.0 } else { self.controller.part(self.order.s) };
            let attempt = with_coefficients!(self.order.s, c => self.attempt(c, at, (latest, part)))?;
            let (rate, iterations_taken, error) = match attempt.map_err(|error| failed(h, error.into()))? {
                Attempt::Solved { rate, iterations, error } => (rate, iterations, error),
                Attempt::Failed { factor, was_finite } => {
                    self.rejected += 1;
                    is_finite = was_finite;
                    self.controller.failed();
                    // An old Jacobian may be the reason; a present one leaves the order and the step size.
                    if self.system.is_current {
                        wanted = shorter(h, factor * h, shortest);
                        self.lower_order();
                    } else {
                        self.system.leave(false);
                    }
                    continue;
                }
            };
            if error.is_nan() {
                return Err(failed(h, SolveError::NonFinite));
            }
            let s = self.order.s;
            let proposed = self.controller.next(h, error, s, iterations_taken, iterations(s));
            if error < 1.0 {
                let end = if stops { barrier } else { end };
                // A step cut short by a stop does not shorten the ones after it.
                let proposed = if is_cut { proposed.max(wanted) } else { proposed };
                self.accept(state, h, end, proposed, rate);
                self.run = Some(*grid);
                return Ok(());
            }
            self.rejected += 1;
            is_finite = true;
            wanted = shorter(h, proposed, shortest);
        }
    }

    fn rate(&mut self, state: &State, out: &mut [f64]) -> Result<(), StepError> {
        Ok(rate(&self.field, &self.mass, state, out)?)
    }

    fn path(&self, t: f64, out: &mut [f64]) -> Option<Result<(), InputError>> {
        Some(self.interpolate(t, out))
    }

    fn work(&self) -> Work {
        self.work
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adaptive::Tolerances;

    /// A rate of 0.08 goes like h², so that 2½ times the step has one of ½; with five stages the order bears it. What is no longer than
    /// 1.2 times a step whose iteration has the rate 10⁻³ keeps its factors.
    #[test]
    fn the_next_step_is_one_that_the_iteration_bears_or_that_keeps_the_factors() {
        for (s, proposed, rate, next) in [
            (3, 4.0, 0.08, 2.5),
            (3, 2.0, 0.08, 2.0),
            (3, 4.0, 0.5, 1.0),
            (5, 4.0, 0.08, 4.0),
            (3, 1.2, 1e-3, 1.0),
            (3, 1.2, 2e-3, 1.2),
            (3, 1.3, 1e-3, 1.3),
            (3, 0.9, 1e-3, 0.9),
        ] {
            let tolerances = Tolerances::new(1e-6, 1e-6).expect("positive");
            let options = Options::new(tolerances).stages(s, 7).expect("a choice");
            let mut method = Radau::new(crate::field!(1, |_t, v, dv| dv[0] = -v[0]), options).expect("valid");
            let mut state = State::new(0.0, vec![1.0]);
            method.accept(&mut state, 1.0, 1.0, proposed, rate);
            let found = method.next_h.expect("a step was accepted");
            // Roundings of a quotient and a root.
            assert!((found - next).abs() <= 1e-14 * next, "{s} stages, {proposed}, {rate}: {found} for {next}");
        }
    }
}
