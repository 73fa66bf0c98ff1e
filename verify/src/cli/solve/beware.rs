//! What a run shows that its numbers do not say: where they cannot be right although every step was solved.

use nalgebra::{DMatrix, DVector};
use verify::experiment::{growth, step_error};
use verify::measure::norm::{Extremes, distance, larger, max_norm};
use verify::measure::stability::{eigenvalues, spectral_abscissa};
use verify::method::Method;
use verify::problem::rounding::rounding;
use verify::problem::{Problem, component_names};
use verify::reference::{self, InUnits, Ode};
use verify::run::step_from;

use super::held::Held;
use super::units::unlike;
use crate::cli::layout::{number, plain};

/// Largest system whose derivatives are looked at as a dense matrix.
pub(super) const DENSE: usize = 64;

/// A change below this part of what f moves, or of the solution, is none.
const REST: f64 = 1e-6;

/// Part of the way from a rest at which an error tells that it is no rest of the method's.
const FOLLOWED: f64 = 1e-3;

/// Growth beyond all values so far in a single step that no step resolves.
const LEAP: f64 = 10.0;

/// Rows over which a solution may find its scale, from the first on that is not zero.
const START: usize = 3;

/// A perturbation of which no more than this part is left after a step is damped, if not as fast as it might be.
const DAMPED: f64 = 0.9;

/// Growth in a step, as the logarithm of a factor, half of which a method has to show.
const LEAVES: f64 = 1.0;

/// A component on the wrong side of zero is lost where it comes to this part of its largest value.
const LOST: f64 = 1e-3;

/// Times within a step at which a reference is asked for its state.
const LOOKS: u32 = 16;

/// The tolerance of a reference that tells of the sign of what is lost, in units of its largest value.
const SIGNS: f64 = 1e-8;

/// Times what a step makes of a few roundings of the state below which a component has no sign.
const ROUNDINGS: f64 = 8.0;

/// The smallest tolerance of a reference that rounding leaves room for.
const FINEST: f64 = 1e-13;

/// The tolerance of a reference that tells how far a step should have gone, which has to be well beyond it.
pub(super) const COURSE: f64 = 1e-10;

/// Zeros that references cross as well, after which no more are doubted: the steps of such a run are long and right.
const REFUTED: u32 = 16;

/// A step shorter than this part of the one before is cut.
const WHOLE: f64 = 0.999;

/// Part of the largest value of a component by which a step on the linearised equation is off.
pub(super) const OFF: f64 = 0.1;

/// Times the estimate of the error that the estimate does not explain: across a jump, where errors halve with the step, it is half of the error,
/// and good to half as much again.
pub(super) const BEYOND: f64 = 3.0;

/// A step that moves a component by less than this part of what solutions do lags behind them.
const LAGS: f64 = 0.01;

/// Singular values below this part of the largest are zero but for rounding, of f and in the decomposition.
const NULL: f64 = 1e-13;

/// What a run comes to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row<'a> {
    pub(super) t: f64,
    pub(super) state: &'a [f64],
    /// Of the error, where there is one.
    pub(super) estimate: Option<f64>,
    /// Whether there is no exact solution any more.
    pub(super) has_ended: bool,
}

/// Halvings of a step in which its growth may show.
const HALVINGS: i32 = 40;

/// The first half of h, of that, and so on with which `method` shows half of the growth of perturbations at least, A standing for hA: beside a
/// fast rotation that may be far below the time in which they grow.
pub(super) fn step_that_shows(method: &dyn Method, a: &DMatrix<f64>, h: f64) -> String {
    let exponent = spectral_abscissa(a);
    let shows = |part: &f64| growth(method, &(*part * a)).is_some_and(|factor| factor.ln() >= 0.5 * part * exponent);
    match (1..=HALVINGS).map(|k| 0.5_f64.powi(k)).find(shows) {
        Some(part) => format!("steps of h = {} show the growth", number(part * h)),
        None => "a smaller step may show the growth".into(),
    }
}

/// Follows a run.
#[derive(Debug, Default)]
pub(super) struct Watch {
    first: Vec<f64>,
    /// The end of the first step.
    second: Option<(f64, Vec<f64>)>,
    /// The last state and the two before, each with its time.
    last: (f64, Vec<f64>),
    /// The estimate there.
    estimate: Option<f64>,
    before: (f64, Vec<f64>),
    earlier: (f64, Vec<f64>),
    /// Largest component of all states, the largest value of each, and how far each went from its first value.
    largest: f64,
    sizes: Vec<f64>,
    moved: Vec<f64>,
    /// The first time at which there is no exact solution any more.
    ended: Option<f64>,
    /// Rows since the first that is not zero.
    rows: usize,
    rates: Rates,
    /// Components that are where the equation seems to let none get, since they crossed zero.
    aside: Vec<Option<Crossing>>,
    /// Zeros that a reference crosses as the run does.
    refuted: u32,
    /// The first that has come far there, when it crossed, and where it is.
    crossed: Option<(usize, f64, f64)>,
    /// The first step across which the solution leaves its scale behind, by its end and the size before and after.
    leap: Option<(f64, [f64; 2])>,
    held: Held,
}

/// The step in which a component crosses zero.
#[derive(Debug, Clone)]
struct Crossing {
    start: f64,
    end: f64,
    /// The state at its start.
    from: Vec<f64>,
}

/// The values of f at all rows of a small system, as columns of a matrix.
#[derive(Debug, Default)]
struct Rates {
    unknowns: usize,
    /// Not the columns A themselves but, from a number of them on, n others with the same A Aᵀ.
    columns: Vec<f64>,
}

impl Rates {
    fn add(&mut self, ode: &dyn Ode, t: f64, state: &[f64]) {
        self.unknowns = state.len();
        let (n, kept) = (state.len(), self.columns.len());
        self.columns.resize(kept + n, 0.0);
        ode.rhs(t, state, &mut self.columns[kept..]);
        if self.columns[kept..].iter().any(|x| !x.is_finite()) {
            self.columns.truncate(kept);
        }
        // Aᵀ = QR, A Aᵀ = Rᵀ R.
        if self.columns.len() >= 4 * n * n {
            let r = self.matrix().transpose().qr().r();
            self.columns = r.transpose().as_slice().to_vec();
        }
    }

    fn matrix(&self) -> DMatrix<f64> {
        DMatrix::from_column_slice(self.unknowns, self.columns.len() / self.unknowns.max(1), &self.columns)
    }
}

impl Crossing {
    /// Whether the solution from the start of the step comes to the other side of zero as well, by more than `far`.
    fn is_of_solution(&self, ode: &dyn Ode, k: usize, far: f64, sizes: &[f64]) -> bool {
        let units: Vec<f64> = sizes.iter().map(|size| if size.is_normal() { *size } else { 1.0 }).collect();
        let ode = InUnits::new(ode, &units);
        let times: Vec<f64> =
            (1..=LOOKS).map(|i| self.start + f64::from(i) / f64::from(LOOKS) * (self.end - self.start)).collect();
        let states = solution(&ode, (self.start, &ode.in_units(&self.from)), &times, SIGNS);
        states.is_some_and(|states| states.iter().any(|state| -ode.states(state)[k] * self.from[k].signum() > far))
    }
}

impl Watch {
    /// A row of a run of `method` on `problem`.
    pub(super) fn add(&mut self, problem: &dyn Problem, method: &dyn Method, row: Row) {
        let Row { t, state, has_ended, estimate } = row;
        self.estimate = estimate;
        if self.first.is_empty() {
            self.first = state.to_vec();
            self.sizes = vec![0.0; state.len()];
            self.moved = self.sizes.clone();
        }
        if self.second.is_none() && !self.last.1.is_empty() {
            self.second = Some((t, state.to_vec()));
        }
        let starts = self.first.iter().zip(state);
        self.moved.iter_mut().zip(starts).for_each(|(moved, (a, b))| *moved = larger(*moved, (b - a).abs()));
        self.sizes.iter_mut().zip(state).for_each(|(size, x)| *size = larger(*size, x.abs()));
        if (2..=DENSE).contains(&state.len()) && problem.ode().dim() == state.len() {
            self.rates.add(problem.ode(), t, state);
            self.cross(problem.ode(), t, state);
        }
        if self.last.1.len() == state.len() && problem.ode().dim() == state.len() {
            self.held.add(problem, method, self.last.0, &row, self.largest);
        }
        std::mem::swap(&mut self.before, &mut self.earlier);
        std::mem::swap(&mut self.last, &mut self.before);
        self.last.0 = t;
        self.last.1.clear();
        self.last.1.extend_from_slice(state);
        let size = max_norm(state);
        self.rows += usize::from(self.largest > 0.0 || size > 0.0);
        // What starts at zero has no scale before it has grown to one, as the tail of a pulse has none.
        let has_scale = max_norm(&self.first).max(size) > f64::EPSILON;
        let leaps = self.rows > START && size > LEAP * self.largest && self.leap.is_none() && has_scale;
        if leaps && may_grow(problem, (t, state), t - self.before.0) {
            self.leap = Some((t, [self.largest, size]));
        }
        self.largest = larger(self.largest, size);
        if has_ended && self.ended.is_none() {
            self.ended = Some(t);
        }
    }

    /// Follows the components that cross zero in a step all the way of which f, where they are zero, points back. The way is taken for
    /// straight, as that of a long step of high order is not: a reference tells whether the solution crosses zero there.
    fn cross(&mut self, ode: &dyn Ode, t: f64, state: &[f64]) {
        let (start, before) = (self.last.0, &self.last.1);
        self.aside.resize(state.len(), None);
        for (k, since) in self.aside.iter_mut().enumerate().take(before.len()) {
            let crosses = before[k] * state[k] < 0.0;
            if crosses || since.is_some() {
                let side = if crosses { before[k].signum() } else { -state[k].signum() };
                // f_k in a part of the step, where the component is zero and where it is what it is.
                let rates = |part: f64| {
                    let mut v: Vec<f64> = before.iter().zip(state).map(|(a, b)| a + part * (b - a)).collect();
                    let mut f = [vec![0.0; v.len()], vec![0.0; v.len()]];
                    let t = start + part * (t - start);
                    ode.rhs(t, &v, &mut f[1]);
                    v[k] = 0.0;
                    ode.rhs(t, &v, &mut f[0]);
                    f.map(|f| f[k])
                };
                let rates = [0.0, 0.25, 0.5, 0.75, 1.0].map(rates);
                // A step that f follows nowhere has turned on the way.
                let is_followed = rates.iter().any(|[_, f]| f * (state[k] - before[k]) > 0.0);
                let lets_none = is_followed && rates.iter().all(|[f, _]| side * f >= 0.0);
                // A second crossing brings it back, and a moment later the equation may let it pass.
                let crossing = || Crossing { start, end: t, from: before.clone() };
                *since = match (crosses, since.take()) {
                    (true, None) => lets_none.then(crossing),
                    (true, Some(_)) => None,
                    (false, since) => since.filter(|_| lets_none),
                };
            }
            let far = LOST * self.sizes[k];
            if self.crossed.is_some() || self.refuted >= REFUTED || state[k].abs() <= far {
                continue;
            }
            let Some(crossing) = since else { continue };
            // All that there is of it may be roundings, as of what vanishes by symmetry.
            let rounded = rounding(|v, f| ode.rhs(t, v, f), state, state.len())[k];
            if state[k].abs() <= ROUNDINGS * (t - start) * rounded {
                continue;
            }
            if crossing.is_of_solution(ode, k, far, &self.sizes) {
                self.refuted += 1;
                *since = None;
            } else {
                self.crossed = Some((k, crossing.end, state[k]));
            }
        }
    }

    /// The ends of the last step, or of the one before where the last is cut.
    fn last_step(&self) -> [&(f64, Vec<f64>); 2] {
        let is_cut =
            !self.earlier.1.is_empty() && self.last.0 - self.before.0 < WHOLE * (self.before.0 - self.earlier.0);
        if is_cut { [&self.earlier, &self.before] } else { [&self.before, &self.last] }
    }

    /// That a component crosses zero where the equation lets none.
    fn wrong_sign(&self, problem: &dyn Problem) -> Option<String> {
        let (k, t, value) = self.crossed?;
        let name = &component_names(problem)[k];
        Some(format!(
            "in the step to t = {} {name} changes its sign, to {}, and the solution does not there: where {name} is 0 on the way, f is 0 or points back; \
             smaller steps, or tolerances below its size, tell",
            plain(t),
            number(value)
        ))
    }

    /// The first state and the last.
    pub(super) fn ends(&self) -> (&[f64], &[f64]) {
        (&self.first, &self.last.1)
    }

    /// A step in which the solution leaves all that was before behind, as beside a pole.
    pub(super) fn leap(&self) -> Option<String> {
        let (t, [before, after]) = self.leap?;
        Some(format!(
            "in the step to t = {} the solution grows from {} to {}: such a step resolves nothing, and the solution may end \
             before; a smaller `--h` tells",
            plain(t),
            number(before),
            number(after)
        ))
    }

    /// A solution no component of which comes to the absolute tolerance that it is held to, one for all or one for each.
    pub(super) fn below(&self, atol: &[f64]) -> Option<String> {
        let largest = |k: usize| atol.get(k).or(atol.first()).copied().unwrap_or(0.0);
        let is_below = self.sizes.iter().enumerate().all(|(k, size)| *size < largest(k));
        (self.largest > 0.0 && is_below).then(|| {
            format!(
                "no component comes to the absolute tolerance, {}, and the largest is {}: no digit of the solution is held to anything; a \
                 smaller `--atol`, or other units, tell",
                number(atol.iter().copied().largest()),
                number(self.largest)
            )
        })
    }

    /// What is to be said of the run on `problem`, and that it breaks a linear invariant, as right digits may.
    pub(super) fn warnings(&self, problem: &dyn Problem, method: &dyn Method) -> (Vec<String>, Option<String>) {
        let ended = self.ended.map(|t| {
            format!("the exact solution ends before t = {}; the rows from there on approximate nothing", plain(t))
        });
        let ode = problem.ode();
        let is_state = ode.dim() == self.last.1.len() && ode.dim() == self.first.len();
        if !is_state || self.before.1.is_empty() {
            return (ended.into_iter().collect(), None);
        }
        let stuck = self
            .at_rest(problem, method)
            .or_else(|| self.stuck(problem, method))
            .or_else(|| self.stays(problem, method))
            .or_else(|| self.held.told(method, self.largest))
            .or_else(|| self.lags(problem, method));
        let broken = self.broken_invariants(problem, stuck.is_some());
        (ended.into_iter().chain(self.wrong_sign(problem)).chain(stuck).collect(), broken)
    }

    /// What each component of f is at least all through the last step, with its sign, and 0 where that changes: what turns within a step, or is
    /// back where it was at the end of each, is moved by no constant rate.
    fn constant_rates(&self, ode: &dyn Ode) -> Vec<f64> {
        let [(start, _), (end, v)] = self.last_step();
        let rates = [0.0, 0.382, 1.0].map(|part| {
            let mut f = vec![0.0; v.len()];
            ode.rhs(start + part * (end - start), v, &mut f);
            f
        });
        let of = |k: usize| rates.each_ref().map(|f| f[k]);
        let least = |of: [f64; 3]| match of.iter().all(|f| f.signum() == of[0].signum()) {
            true => of.iter().map(|f| f.abs()).smallest().copysign(of[0]),
            false => 0.0,
        };
        (0..v.len()).map(|k| least(of(k))).collect()
    }

    /// A component that stays at its start, where f moves it: a least-squares method holds one by which f does not change, and one with
    /// |R(∞)| = 1 what is fast beside its steps.
    fn stuck(&self, problem: &dyn Problem, method: &dyn Method) -> Option<String> {
        let [(t_before, _), (t, v)] = self.last_step();
        if v.len() > DENSE {
            return None;
        }
        let (h, rates) = (t - t_before, self.constant_rates(problem.ode()));
        let jacobian = jacobian(problem, *t, v);
        (0..v.len()).find_map(|k| {
            let rate = rates[k].abs();
            // A fast component is at rest nearby, and f is large there all the same.
            let way = (h * rate).min(rate / jacobian[(k, k)].abs());
            (way.is_finite() && way > REST * self.largest && self.moved[k] <= REST * way).then(|| {
                let short = jacobian.norm().recip().min(0.5 * h);
                let remedy = match moves(problem, method, (v, k), short) {
                    true => format!("a step below {} moves it", number(short)),
                    false => "no smaller step helps".into(),
                };
                format!(
                    "{} stays at {} all the way, where f moves it at a rate of {}: the method holds it, not the equation, and {remedy}",
                    component_names(problem)[k],
                    number(v[k]),
                    number(rates[k])
                )
            })
        })
    }

    /// Two steps, the last ones, that hardly move a component where solutions do, as near a state of rest of the method alone.
    fn lags(&self, problem: &dyn Problem, method: &dyn Method) -> Option<String> {
        let (ode, n) = (problem.ode(), self.first.len());
        let rows = [&self.earlier, &self.before, &self.last];
        if n > DENSE || rows.iter().any(|(_, v)| v.len() != n) {
            return None;
        }
        let moves = rows.array_windows().map(|[(start, from), (end, to)]: &[&(f64, Vec<f64>); 2]| {
            let states = solution(ode, (*start, from), &[*end], COURSE)?;
            let difference = |to: &[f64]| to.iter().zip(from).map(|(b, a)| b - a).collect::<Vec<_>>();
            Some([difference(to), difference(states.first()?)])
        });
        let [first, last]: [[Vec<f64>; 2]; 2] = moves.collect::<Option<Vec<_>>>()?.try_into().ok()?;
        let is_behind = |[run, exact]: &[Vec<f64>; 2], k: usize| {
            exact[k].abs() > (LOST * self.sizes[k]).max(COURSE / LOST) && run[k].abs() < LAGS * exact[k].abs()
        };
        let k = (0..n).find(|k| is_behind(&first, *k) && is_behind(&last, *k))?;
        let (t, v) = &self.before;
        let remedy = unlike(problem, method, (*t, v), self.last.0 - t, k);
        Some(format!(
            "the last step, from t = {}, moves {} by {}, and the solution from there by {}: the method hardly moves it, and the equation does; {}",
            plain(self.before.0),
            component_names(problem)[k],
            number(last[0][k]),
            number(last[1][k]),
            remedy.unwrap_or_else(|| "a smaller `--h`, or another method, tells".into())
        ))
    }

    /// States that solutions of the equation leave within a step, and the run does not.
    fn stays(&self, problem: &dyn Problem, method: &dyn Method) -> Option<String> {
        let [(t_before, before), (t, v)] = self.last_step();
        let h = t - t_before;
        if v.len() > DENSE {
            return None;
        }
        let a = jacobian(problem, *t, v);
        let exponent = h * spectral_abscissa(&a);
        // What goes beyond all that was before leaves, if not as fast.
        let stays = max_norm(&self.last.1) <= 2.0 * max_norm(before);
        let factor = (stays && exponent > LEAVES).then(|| growth(method, &(h * &a))).flatten()?;
        (factor.ln() < 0.5 * exponent).then(|| {
            format!(
                "at the end perturbations grow like e^({} t), and a step of h = {} multiplies them by {} alone: it stays where solutions of the \
                 equation do not; {}",
                number(exponent / h),
                plain(h),
                number(factor),
                step_that_shows(method, &(h * &a), h)
            )
        })
    }

    /// A method that amplifies what the equation damps, as it does at the end of the run.
    pub(super) fn amplified(&self, problem: &dyn Problem, method: &dyn Method) -> Option<String> {
        let (ode, [(t_before, before), (t, v)]) = (problem.ode(), self.last_step());
        let h = t - t_before;
        if ode.dim() != v.len() || v.len() > DENSE || before.is_empty() {
            return None;
        }
        let a = jacobian(problem, *t, v);
        let is_stable = spectral_abscissa(&a) < -REST * a.amax();
        let factor = is_stable.then(|| growth(method, &(h * &a))).flatten()?;
        // The same with perturbations that do not feed one another.
        let apart = growth(method, &(h * normal_with_eigenvalues_of(&a)))?;
        // What is damped fast in any case is no news.
        let hardly_damps = factor > DAMPED && factor.ln() > 0.5 * apart.ln();
        (factor > 1.0 + REST || hardly_damps).then(|| {
            format!(
                "at the end every mode of the equation decays, and steps of h = {} multiply a perturbation by {} each in the long run, where its \
                 eigenvalues alone would make that {}: errors {} in the long run, and the estimate may not know; another method, or a smaller h, \
                 tells",
                plain(h),
                number(factor),
                number(apart),
                if factor > 1.0 + REST { "grow" } else { "decay no faster" }
            )
        })
    }

    /// A first or a last step of which the linearised equation tells that it is off by far more than the estimate: runs with h and h/2
    /// keep what the equation damps, or damp what it keeps, alike.
    pub(super) fn off(&self, problem: &dyn Problem, method: &dyn Method, h: f64, estimate: f64) -> Option<String> {
        let (ode, n) = (problem.ode(), self.first.len());
        if ode.dim() != n || self.last.1.len() != n || n > DENSE || self.before.1.is_empty() {
            return None;
        }
        let start = (0.0, self.first.clone());
        let steps = [[&start, self.second.as_ref()?], [&self.before, &self.last]];
        [(0.0, &self.first, steps[0]), (self.last.0, &self.last.1, steps[1])].into_iter().find_map(|(t, v, step)| {
            let a = h * jacobian(problem, t, v);
            let mut f = DVector::zeros(n);
            ode.rhs(t, v, f.as_mut_slice());
            // How far growth goes is not for the linearised equation to say.
            let is_usable = a.iter().chain(&f).all(|x| x.is_finite()) && spectral_abscissa(&a) <= LEAVES;
            let error = is_usable.then(|| step_error(method, &a, &(h * f))).flatten()?;
            let far = |k: usize| (OFF * self.sizes[k]).max(BEYOND * estimate);
            let is_off = |k: &usize| error[*k].abs() > far(*k) && is_step_off(ode, step, (*k, far(*k)));
            let k = (0..n).filter(is_off).max_by(|i, j| error[*i].abs().total_cmp(&error[*j].abs()))?;
            Some(format!(
                "of the equation linearised at t = {} a step of h = {} is off by {} in {}, of which the largest value is {}: it \
                 damps what the equation keeps, or keeps what it damps, with half of h as well, and the estimate does not know; \
                 another method, or a step below {}, tells",
                plain(t),
                plain(h),
                number(error[k].abs()),
                component_names(problem)[k],
                number(self.sizes[k]),
                number(h / a.norm())
            ))
        })
    }

    /// A state of rest that is none of the equation, or one that the equation leaves.
    fn at_rest(&self, problem: &dyn Problem, method: &dyn Method) -> Option<String> {
        let (ode, [(t_before, before), (t, v)]) = (problem.ode(), self.last_step());
        let (h, moved) = (t - t_before, distance(v, before));
        // The references' f, which may be dear, is asked where the run rests alone. What leaves in a last step that is cut does not.
        if larger(moved, distance(v, &self.last.1)) > REST * self.largest {
            return None;
        }
        let mut f = vec![0.0; v.len()];
        ode.rhs(*t, v, &mut f);
        let (size, drift) = (max_norm(v), h * max_norm(&f));
        let least = max_norm(&self.constant_rates(ode));
        // What is no normal number moves nothing that is one.
        if h * least > (REST * size).max(f64::MIN_POSITIVE) && moved <= REST * h * least {
            return Some(format!(
                "the run rests where f is not zero: it moved by {} in the last step of h = {}, |f| = {}; that is a steady \
                 state of the method, not of the equation",
                number(moved),
                plain(h),
                number(least)
            ));
        }
        let came = self.first.iter().zip(v).any(|(a, b)| (a - b).abs() > REST * self.largest);
        if drift > REST * self.largest || v.len() > DENSE {
            return None;
        }
        let a = jacobian(problem, *t, v);
        let rate = spectral_abscissa(&a);
        if !came {
            // A distance from the rest of |f|/rate or of a rounding, by the end; in logarithms, as it may be beyond all numbers.
            let distance = (max_norm(&f) / rate).max(f64::EPSILON * size);
            let leaves = max_norm(&f) > 0.0 && rate * t + distance.ln() > (REST * self.largest).ln();
            return (rate > 0.0 && leaves).then(|| {
                format!(
                    "the run stays where it starts, beside a state of rest that is unstable: perturbations grow like e^({} t) there, and what \
                     f is there, {}, or a rounding is enough to leave it before the end; tolerances below it, and steps below {}, tell",
                    number(rate),
                    number(max_norm(&f)),
                    number(rate.recip())
                )
            });
        }
        // A solution that comes down to where it grows again is followed there.
        let away = max_norm(&f) / rate;
        if away > 0.0 && self.estimate.is_some_and(|estimate| estimate <= FOLLOWED * away) {
            return None;
        }
        // A method that lets perturbations grow rests only where there are none, as the solution does.
        let damps = || growth(method, &(h * &a)).map_or(drift == 0.0 || moved < 0.5 * drift, |factor| factor <= 1.0);
        (h * rate > REST && damps()).then(|| {
            format!(
                "the run came to rest where the equation is unstable: perturbations grow like e^({} t) there, and the method \
                 with h = {} damps them; {}",
                number(rate),
                plain(h),
                step_that_shows(method, &(h * &a), h)
            )
        })
    }

    /// Linear combinations of the components that the equation conserves and the run does not.
    fn broken_invariants(&self, problem: &dyn Problem, is_stuck: bool) -> Option<String> {
        let n = self.first.len();
        if !(2..=DENSE).contains(&n) {
            return None;
        }
        // wᵀ f vanishes for all v where wᵀ ∂f/∂v does, here at states of the run and a point beside it, and wᵀ f does at each row, as f may
        // act between the ends alone. In units of the solution f is as large as ∂f/∂v, and so are its roundings.
        let beside: Vec<f64> = (0..n).map(|i| self.largest * (1.0 + 0.5 * ((i + 1) as f64).sin())).collect();
        let rates = self.rates.matrix() / self.largest;
        let mut all = DMatrix::zeros(n, 3 * n + rates.ncols());
        for (k, (t, v)) in
            [(0.0, &self.first), (self.last.0, &self.last.1), (self.last.0, &beside)].into_iter().enumerate()
        {
            all.columns_mut(k * n, n).copy_from(&jacobian(problem, t, v));
        }
        all.columns_mut(3 * n, rates.ncols()).copy_from(&rates);
        if all.iter().any(|x| !x.is_finite()) {
            return None;
        }
        let svd = all.svd(true, false);
        let (vectors, values) = (svd.u?, svd.singular_values);
        let names = component_names(problem);
        let mut at_end = vec![0.0; n];
        problem.ode().rhs(self.last.0, &self.last.1, &mut at_end);
        (0..values.len()).filter(|k| values[*k] <= NULL * values.max()).find_map(|k| {
            let w = vectors.column(k);
            let change: f64 = w.iter().zip(self.last.1.iter().zip(&self.first)).map(|(w, (b, a))| w * (b - a)).sum();
            let scale = w.amax();
            // Beside rates of another size altogether a small one looks like none.
            let kept = w.map(|w| if w.abs() > REST * scale { w } else { 0.0 });
            let terms = kept.iter().zip(rates.row_iter()).map(|(w, f)| (w * f.norm()).powi(2)).sum::<f64>().sqrt();
            let cancels = rates.tr_mul(&kept).norm() <= REST * terms;
            // Beside entries of ∂f/∂v of another size altogether, of which f makes nothing, a small one looks like none, too.
            let (sum, size) = kept.iter().zip(&at_end).fold((0.0, 0.0), |(sum, size), (w, f)| (sum + w * f, size + (w * f).abs()));
            let cancels = cancels && f64::abs(sum) <= 0.5 * size;
            (cancels && change.abs() > REST * self.largest).then(|| {
                let terms = w.iter().zip(&names).filter(|(w, _)| w.abs() > REST * scale);
                let pivot = w[w.iamax()];
                let sum = terms.map(|(w, name)| format!("{:+.4} {name}", w / pivot)).collect::<Vec<_>>().join(" ");
                format!(
                    "the equation conserves {sum}, and the run changed it by {}; {}a Runge–Kutta method, which conserves it, helps",
                    number(change / pivot),
                    if is_stuck { "" } else { "a smaller h, or " }
                )
            })
        })
    }
}

/// A normal matrix with the eigenvalues of `a`: blocks of order 1 and 2 on the diagonal.
fn normal_with_eigenvalues_of(a: &DMatrix<f64>) -> DMatrix<f64> {
    let mut normal = DMatrix::zeros(a.nrows(), a.nrows());
    let mut place = 0;
    for value in eigenvalues(a).into_iter().filter(|value| value.im >= 0.0) {
        let is_pair = value.im > 0.0 && place + 1 < a.nrows();
        normal[(place, place)] = value.re;
        if is_pair {
            normal[(place + 1, place + 1)] = value.re;
            (normal[(place, place + 1)], normal[(place + 1, place)]) = (-value.im, value.im);
        }
        place += if is_pair { 2 } else { 1 };
        if place == a.nrows() {
            break;
        }
    }
    normal
}

/// Whether a step of `h` from `v` moves component `k` half as far as f does, or more.
fn moves(problem: &dyn Problem, method: &dyn Method, (v, k): (&[f64], usize), h: f64) -> bool {
    let mut f = vec![0.0; v.len()];
    problem.ode().rhs(0.0, v, &mut f);
    step_from(problem, v.to_vec(), method, h).is_ok_and(|end| (end[k] - v[k]).abs() >= 0.5 * h * f[k].abs())
}

/// Whether a step of a run leads to a component `k` that is off by more than `far`, as a reference tells that gets so far.
fn is_step_off(ode: &dyn Ode, [start, end]: [&(f64, Vec<f64>); 2], (k, far): (usize, f64)) -> bool {
    let tolerance = (0.01 * far).clamp(FINEST, COURSE);
    let states = solution(ode, (start.0, &start.1), &[end.0], tolerance);
    states.is_none_or(|states| states.iter().any(|state| (state[k] - end.1[k]).abs() > far))
}

/// The solution from a state at a time, as a reference has it at these times; none where it fails.
pub(super) fn solution(
    ode: &dyn Ode,
    (start, from): (f64, &[f64]),
    times: &[f64],
    tolerance: f64,
) -> Option<Vec<Vec<f64>>> {
    Some(reference::by_name("diffsol-bdf")?.run(ode, start, from, times, tolerance).ok()?.states)
}

/// Whether perturbations may leap in a step, for all that a bound tells: what the equation lets grow by less grows by forcing, however fast.
fn may_grow(problem: &dyn Problem, (t, v): (f64, &[f64]), h: f64) -> bool {
    let is_dense = problem.ode().dim() == v.len() && v.len() <= DENSE;
    let is_forced = is_dense && h * abscissa_bound(&jacobian(problem, t, v)) <= LEAP.ln();
    !is_forced
}

/// Gershgorin's bound of the real parts of the eigenvalues, which costs less than these.
pub(super) fn abscissa_bound(a: &DMatrix<f64>) -> f64 {
    let off_diagonal = |i: usize| a.row(i).iter().map(|x| x.abs()).sum::<f64>() - a[(i, i)].abs();
    (0..a.nrows()).map(|i| a[(i, i)] + off_diagonal(i)).largest()
}

/// ∂f/∂v as a dense matrix.
pub(super) fn jacobian(problem: &dyn Problem, t: f64, v: &[f64]) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(v.len(), v.len());
    problem.ode().jacobian(t, v, &mut |i, j, x| matrix[(i, j)] += x);
    matrix
}

#[cfg(test)]
mod tests {
    use super::*;
    use verify::{method, problem};

    /// Implicit Euler damps 0.1 ± 10i where |1 − hλ| > 1, and has half of the growth where h < 0.001.
    #[test]
    fn the_step_that_shows_growth_beside_a_fast_rotation_is_short() {
        let a = DMatrix::from_row_slice(2, 2, &[0.1, -10.0, 10.0, 0.1]);
        let told = |name: &str, h: f64| step_that_shows(&*method::parse(name).expect("known"), &(h * &a), h);
        assert_eq!(told("implicit-euler", 0.05), format!("steps of h = {} show the growth", number(0.05 / 64.0)));
    }

    /// Of cos t in a step of a period, and in one that ends before it comes to zero.
    #[test]
    fn a_solution_that_crosses_zero_within_a_step_crosses_it() {
        let oscillator = problem::build("harmonic-oscillator", &[]).expect("registered");
        let crosses = |end: f64| {
            let crossing = Crossing { start: 0.0, end, from: vec![1.0, 0.0] };
            crossing.is_of_solution(oscillator.ode(), 0, 1e-3, &[1.0; 2])
        };
        assert_eq!([std::f64::consts::TAU, 1.5].map(crosses), [true, false]);
    }

    /// By 50 in units of 100, in half a period.
    #[test]
    fn a_solution_is_followed_beyond_zero_in_its_own_units() {
        let oscillator = problem::build("harmonic-oscillator", &[]).expect("registered");
        let crossing = Crossing { start: 0.0, end: std::f64::consts::PI, from: vec![50.0, 0.0] };
        let crosses = |far: f64| crossing.is_of_solution(oscillator.ode(), 0, far, &[100.0; 2]);
        assert_eq!([0.1, 49.0, 51.0].map(crosses), [true, true, false]);
    }

    /// From 10⁻¹³ to −10⁻¹³, where y decays to 10⁻¹⁴ in no time: f is roundings of 1 and of 10, which move it by less than that in a short step, and by more in
    /// a long one.
    #[test]
    fn a_component_has_a_sign_beyond_the_roundings_of_a_step() {
        let decaying = model("u_i { x = 1, y = 0 } F_i { 0*x, x - 1e14*y }");
        let is_crossed = |h: f64| {
            let (last, sizes) = ((0.0, vec![1.0, 1e-13]), vec![1.0, 1e-13]);
            let mut watch = Watch { last, sizes, ..Watch::default() };
            watch.cross(decaying.ode(), h, &[1.0, -1e-13]);
            watch.crossed.is_some()
        };
        assert_eq!([0.01, 10.0].map(is_crossed), [true, false]);
    }

    /// A solution of 10⁻¹⁰ is followed by a reference that resolves it.
    #[test]
    fn a_step_in_small_units_is_off_by_what_is_large_there() {
        let oscillator = problem::build("harmonic-oscillator", &[]).expect("registered");
        let is_off = |off: f64| {
            let end = (6.0, vec![1e-10 * (6.0_f64.cos() + off), -1e-10 * 6.0_f64.sin()]);
            is_step_off(oscillator.ode(), [&(0.0, vec![1e-10, 0.0]), &end], (0, 1e-11))
        };
        assert_eq!([0.0, 0.2].map(is_off), [false, true]);
    }

    fn model(text: &str) -> problem::model::Model {
        let file = tempfile::NamedTempFile::with_suffix(".ds").expect("a file");
        std::fs::write(file.path(), text).expect("writable");
        problem::model::Model::load(file.path(), &[], None).expect("a model")
    }

    /// Rows of a run of ẋ = λx, the last of which has an estimate.
    fn watch(rows: &[(f64, f64)], estimate: Option<f64>) -> Watch {
        let first = rows[0].1;
        let row = |k: usize| rows.len().checked_sub(k).map_or_else(Default::default, |k| (rows[k].0, vec![rows[k].1]));
        let most = |of: &dyn Fn(f64) -> f64| rows.iter().map(|(_, x)| of(*x)).largest();
        let largest = most(&f64::abs);
        Watch {
            first: vec![first],
            earlier: row(3),
            before: row(2),
            last: row(1),
            estimate,
            largest,
            sizes: vec![largest],
            moved: vec![most(&|x| (x - first).abs())],
            ..Watch::default()
        }
    }

    fn growing(rate: f64) -> Box<dyn Problem> {
        problem::build("linear-drag", &[("lambda".into(), (-rate).to_string())]).expect("registered")
    }

    /// Of ẋ = 10x no step of 0.01 leaps, and one of 1 may; that of the last row counts, wherever the run is by then.
    #[test]
    fn what_grows_by_twenty_in_a_short_step_is_forced() {
        let method = method::parse("rk4").expect("known");
        let leaps = |h: f64| {
            let mut watch = Watch::default();
            for (k, x) in [1.0, 1.0, 1.0, 1.0, 20.0].into_iter().enumerate() {
                let row = Row { t: 10.0 + h * k as f64, state: &[x], estimate: None, has_ended: false };
                watch.add(&*growing(10.0), &*method, row);
            }
            watch.leap().is_some()
        };
        assert_eq!([0.01, 1.0].map(leaps), [false, true]);
    }

    /// However little that is in the units of the equation.
    #[test]
    fn what_moves_with_its_rate_is_not_held() {
        let method = method::parse("implicit-euler").expect("known");
        for size in [1e-7, 1.0, 1e7] {
            let stuck = |values: [f64; 3]| {
                let rows = [0.0, 0.1, 0.2].into_iter().zip(values.map(|x| size * x)).collect::<Vec<_>>();
                watch(&rows, None).stuck(&*growing(-1.0), &*method).is_some()
            };
            assert_eq!([stuck([1.0, 0.9, 0.8]), stuck([1.0; 3])], [false, true], "{size}");
        }
    }

    /// In a step of 1 solutions of ẋ = 3x/2 grow by e^{3/2}; rk4 has that, and implicit Euler a factor of 2, by half of this exponent it may lack.
    #[test]
    fn a_method_that_shows_half_of_the_growth_does_not_hold_a_run() {
        let stays = |name: &str| {
            let method = method::parse(name).expect("known");
            watch(&[(0.0, 1.0), (1.0, 1.0)], None).stays(&*growing(1.5), &*method).is_some()
        };
        assert_eq!(["rk4", "implicit-euler"].map(stays), [false, true]);
    }

    /// At 10⁻⁹ from where ẋ = 100x rests, by an error that is known to far less than that, or not; and there.
    #[test]
    fn a_run_that_comes_to_an_unstable_rest_is_told_unless_its_error_is_far_less_than_the_way_from_it() {
        let method = method::parse("implicit-euler").expect("known");
        let told = |rows: &[(f64, f64)], estimate: f64| {
            watch(rows, Some(estimate)).at_rest(&*growing(100.0), &*method).is_some()
        };
        let rows = [(0.8, 1.0), (0.9, 1.1e-9), (1.0, 1e-9)];
        assert_eq!([5e-13, 5e-12].map(|estimate| told(&rows, estimate)), [false, true]);
        assert!(told(&[(0.8, 1.0), (0.9, 0.0), (1.0, 0.0)], 0.0));
        // That it still moves is more than a rest of the method's alone.
        let moving = watch(&[(0.8, 1.0), (0.9, 1e-9 + 1e-13), (1.0, 1e-9)], None).at_rest(&*growing(100.0), &*method);
        assert!(moving.is_some_and(|told| told.starts_with("the run came to rest where the equation is unstable")));
        // Of a method with steps of its own it is the step that tells, which moves it by less than half of h f.
        let adaptive = method::parse("radau-adaptive").expect("known");
        let rests = |before: f64, end: f64| {
            watch(&[(0.8, 1.0), (0.9, before), (1.0, end)], None).at_rest(&*growing(100.0), &*adaptive).is_some()
        };
        assert_eq!([rests(5e-9, 1e-9), rests(7e-9, 1e-9), rests(0.0, 0.0)], [true, false, true]);
        // Where it starts it stays as the solution does.
        assert!(!told(&[(0.8, 0.0), (0.9, 0.0), (1.0, 0.0)], 0.0));
    }

    /// Beside y = 1: where f is zero, where it moves x by next to nothing, and where it moves it.
    #[test]
    fn a_run_that_stays_where_f_is_nothing_is_none_of_the_method_alone() {
        let method = method::parse("implicit-euler").expect("known");
        let told = |f: &str, y: f64| {
            let state = vec![0.0, y];
            let watch = Watch {
                first: state.clone(),
                before: (99.9, state.clone()),
                last: (100.0, state),
                largest: y,
                ..Watch::default()
            };
            watch.at_rest(&model(&format!("u_i {{ x = 0, y = 1 }} F_i {{ {f}, 0*y }}")), &*method).is_some()
        };
        assert_eq!([told("x", 1.0), told("1e-9 + 0*x", 1.0), told("1 + 0*x", 0.0)], [false, false, true]);
    }

    /// ẋ = x from 10⁻¹², beside y = 10⁶: a rounding of that grows to a millionth of it in a time of 22.
    #[test]
    fn a_run_that_stays_where_it_starts_is_told_where_it_has_the_time_to_leave() {
        let method = method::parse("implicit-euler").expect("known");
        let told = |t: f64| {
            let state = vec![1e-12, 1e6];
            let (before, last) = ((t - 0.1, state.clone()), (t, state.clone()));
            let watch = Watch { first: state, before, last, largest: 1e6, ..Watch::default() };
            watch.at_rest(&model("u_i { x = 0, y = 1 } F_i { x, 0*y }"), &*method).is_some()
        };
        assert_eq!([20.0, 25.0].map(told), [false, true]);
    }

    /// It crosses by next to nothing first, where f pushes back, and goes on from there as f beyond has it.
    #[test]
    fn a_component_that_goes_on_beyond_zero_is_followed_from_where_it_crossed() {
        let leaving = model("u_i { x = 1, y = 0 } F_i { 0*x, 1e-12*x + y }");
        let method = method::parse("rk4").expect("known");
        let mut watch = Watch::default();
        for (t, y) in [(0.0, 1e-3), (0.1, -1e-7), (0.2, -1e-4)] {
            watch.add(&leaving, &*method, Row { t, state: &[1.0, y], estimate: None, has_ended: false });
        }
        assert!(matches!(watch.crossed, Some((1, 0.1, -1e-4))), "{:?}", watch.crossed);
    }

    /// Of v̇ = −v a step of 1 takes 0.63.
    #[test]
    fn a_run_lags_that_moves_a_hundredth_of_the_way_or_less() {
        let (problem, method) = (problem::build("linear-drag", &[]), method::parse("implicit-euler"));
        let (problem, method) = (problem.expect("registered"), method.expect("registered"));
        let lags = |part: f64| {
            let after = |v: f64| v * (1.0 - part * (1.0 - (-1.0_f64).exp()));
            let rows = [1.0, after(1.0), after(after(1.0))].map(|v| vec![v]);
            let watch = Watch {
                first: rows[0].clone(),
                sizes: rows[0].clone(),
                earlier: (0.0, rows[0].clone()),
                before: (1.0, rows[1].clone()),
                last: (2.0, rows[2].clone()),
                ..Watch::default()
            };
            watch.lags(&*problem, &*method).is_some()
        };
        assert_eq!([0.9, 1.1].map(|part| lags(part * LAGS)), [true, false]);
    }
}
