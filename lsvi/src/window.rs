//! The window closure: the trajectory of least action over several steps at once.

use std::ops::Range;

use crate::closure::Linear;
use crate::discrete::{DiscreteLegendre, Interval, MomentumWeights};
use crate::error::{InputError, SettingError, StepError, check_step_from, check_unknowns, check_vector};
use crate::integrator::{Grid, GridStep, Integrator, State};
use crate::linalg::{Jacobian, Structure, add_block};
use crate::newton::{LimitAtZero, Newton, System, Work};
use crate::variational::{StepEquations, repeat};

/// K steps found together: the action Σ L_d is stationary in q₁, …, q_K, and in the interior values of every step.
///
/// These are the discrete Euler–Lagrange equations D₂L_d(q_{i−1}, q_i) + D₁L_d(q_i, q_{i+1}) = 0 between the steps and
/// p_K = 0 at the end. K = 1 is Method I; a K that spans the whole interval keeps the discrete Euler–Lagrange equations
/// throughout, as of the closures of a least-squares Lagrangian the position–momentum form alone does besides. The rows of a window are handed out one by one,
/// with their momenta; the last window of a grid is as short as it must be. The equations are block tridiagonal, and the
/// cost is proportional to K.
#[derive(Debug)]
pub struct Window<D> {
    discrete: D,
    newton: Newton,
    /// The first guess, one step after another.
    march: Newton,
    /// The unknowns of K steps, each its interior values, then its end.
    unknowns: Vec<f64>,
    /// The steps of the present window.
    steps: Vec<GridStep>,
    /// How many of them have been handed out.
    handed_out: usize,
    scratch: Scratch,
    /// Steps handed out, and what the windows cost; an evaluation of a window is one of each of its steps.
    work: Work,
}

/// The momentum at the start of a step, and derivatives of one step.
#[derive(Debug)]
struct Scratch {
    momentum: Vec<f64>,
    block: Jacobian,
    in_start: Jacobian,
}

/// Entries of the largest matrix that a window is given.
const LARGEST: usize = 1 << 31;

impl<D: DiscreteLegendre> Window<D> {
    /// Windows of `length` steps of `discrete`.
    ///
    /// # Errors
    /// [`SettingError::Setting`] if the length is 0, or the matrix of a window too large for memory.
    pub fn new(discrete: D, length: usize) -> Result<Self, InputError> {
        if length == 0 {
            let (what, value) = ("steps in a window", 0.0);
            return Err(InputError::Setting(SettingError::Setting { what, value, range: "at least 1" }));
        }
        let n = discrete.dim();
        check_unknowns(n)?;
        let m = discrete.interior() + n;
        // Blocks of m rows that reach two blocks to either side.
        if length.checked_mul(5 * m * m).is_none_or(|entries| entries > LARGEST) {
            let (what, value) = ("steps in a window", length as f64);
            return Err(InputError::Setting(SettingError::Setting { what, value, range: "few enough for memory" }));
        }
        let of_step = discrete.structure();
        let structure = window_structure(&of_step, n, m, length);
        Ok(Self {
            discrete,
            newton: Newton::with_structure(length * m, &structure),
            march: Newton::with_structure(m, &of_step),
            unknowns: vec![0.0; length * m],
            steps: Vec::with_capacity(length),
            handed_out: 0,
            scratch: Scratch {
                momentum: vec![0.0; n],
                block: Jacobian::with_structure(m, &of_step),
                in_start: Jacobian::with_structure(m, &of_step),
            },
            work: Work::default(),
        })
    }

    /// Largest number of steps in a window.
    fn length(&self) -> usize {
        self.unknowns.len() / self.scratch.block.dim()
    }

    /// The step to be handed out next, if `state` is the one that was handed out last and the grid is still the same.
    fn pending(&self, state: &State, grid: &Grid) -> Option<GridStep> {
        let m = self.scratch.block.dim();
        let last = self.handed_out.checked_sub(1)?;
        let end = &self.unknowns[last * m + m - state.q.len()..(last + 1) * m];
        let next = self.steps.get(self.handed_out).copied()?;
        let is_continued = self.steps[last].end == state.t && end == state.q && grid.next(state.t) == Some(next);
        is_continued.then_some(next)
    }

    /// Finds the trajectory of a new window; it has no steps if that fails.
    fn find(&mut self, first: GridStep, state: &State, grid: &Grid) -> Result<(), StepError> {
        self.steps.clear();
        self.handed_out = 0;
        check_step_from(state.t, first.h)?;
        check_vector("q", &state.q, self.discrete.dim())?;
        check_vector("p", &state.p, self.discrete.dim())?;
        let mut next = Some(first);
        while let Some(step) = next.filter(|_| self.steps.len() < self.length()) {
            self.steps.push(step);
            next = grid.next(step.end);
        }
        self.guess(state);
        let (discrete, scratch) = (&mut self.discrete, &mut self.scratch);
        let mut equations = WindowEquations {
            discrete,
            scratch,
            t: state.t,
            q0: &state.q,
            steps: &self.steps,
            unknowns: self.unknowns.len(),
        };
        let before = self.newton.work;
        let solved = self.newton.solve(&mut equations, first.h, &mut self.unknowns);
        let count = self.steps.len() as u64;
        self.work.residuals += count * (self.newton.work.residuals - before.residuals);
        self.work.factorizations += count * (self.newton.work.factorizations - before.factorizations);
        solved.map_err(|source| {
            self.steps.clear();
            StepError::Solve { t: state.t, h: first.h, source }
        })
    }

    /// Sets the unknowns to steps of Method I, from which the window differs by its order; where they end, to a standstill.
    fn guess(&mut self, state: &State) {
        let n = state.q.len();
        repeat(&state.q, &mut self.unknowns);
        let (mut t, mut reached) = (state.t, state.q.as_slice());
        for (step, x) in self.steps.iter().zip(self.unknowns.chunks_exact_mut(self.scratch.block.dim())) {
            repeat(reached, x);
            let (discrete, closure) = (&mut self.discrete, &Linear::METHOD_I);
            let mut equations = StepEquations { discrete, closure, t, q0: reached, p0: &[], momenta: None };
            if self.march.solve(&mut equations, step.h, x).is_err() {
                repeat(reached, x);
                break;
            }
            (t, reached) = (step.end, &x[x.len() - n..]);
        }
    }
}

/// The equations of one window from q₀ at time t, steps shorter than the first in proportion.
struct WindowEquations<'a, D> {
    discrete: &'a mut D,
    scratch: &'a mut Scratch,
    t: f64,
    q0: &'a [f64],
    steps: &'a [GridStep],
    /// Number of unknowns of a window of full length.
    unknowns: usize,
}

impl<D: DiscreteLegendre> WindowEquations<'_, D> {
    /// Step i of a window whose first step has size `h`.
    fn interval(&self, h: f64, i: usize) -> Interval {
        let scale = h / self.steps[0].h;
        let start = if i == 0 { self.t } else { self.steps[i - 1].end };
        Interval { start: self.t + scale * (start - self.t), h: scale * self.steps[i].h }
    }

    /// The configuration at the start of step i, and the unknowns of that step.
    fn step<'x>(&self, x: &'x [f64], i: usize) -> (&'x [f64], &'x [f64])
    where
        Self: 'x,
    {
        let (m, n) = (self.scratch.block.dim(), self.q0.len());
        let start = if i == 0 { self.q0 } else { &x[i * m - n..i * m] };
        (start, &x[i * m..(i + 1) * m])
    }

    /// The unknowns beyond a window shorter than it may be, which are held at q₀.
    fn unused(&self) -> Range<usize> {
        self.steps.len() * self.scratch.block.dim()..self.unknowns
    }
}

impl<D: DiscreteLegendre> System for WindowEquations<'_, D> {
    fn dim(&self) -> usize {
        self.unknowns
    }

    /// For each step its conditions of stationarity, then p at its end less p at the start of the next.
    fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
        let (m, n) = (self.scratch.block.dim(), self.q0.len());
        for i in 0..self.steps.len() {
            let at = self.interval(h, i);
            let (start, unknowns) = self.step(x, i);
            self.discrete.equations(at, start, unknowns, MomentumWeights::END, &mut out[i * m..(i + 1) * m]);
            if i > 0 {
                self.discrete.momentum(at, start, unknowns, MomentumWeights::START, &mut self.scratch.momentum);
                out[i * m - n..i * m].iter_mut().zip(&self.scratch.momentum).for_each(|(o, p)| *o -= p);
            }
        }
        for i in self.unused() {
            out[i] = x[i] - self.q0[i % n];
        }
    }

    fn derivative(&mut self, h: f64, x: &[f64], out: &mut Jacobian) {
        let (m, n) = (self.scratch.block.dim(), self.q0.len());
        for i in 0..self.steps.len() {
            let at = self.interval(h, i);
            let (start, unknowns) = self.step(x, i);
            let Scratch { block, in_start, .. } = &mut *self.scratch;
            block.clear();
            self.discrete.add_derivative(at, start, unknowns, MomentumWeights::END, block);
            add_block(out, (i * m, i * m), 1.0, block);
            if i > 0 {
                in_start.clear();
                self.discrete.add_start_derivative(at, start, unknowns, MomentumWeights::END, in_start);
                add_start(out, (i * m, i * m - n), 1.0, in_start, (0, n));
                out.inherit_outside(in_start);
                in_start.clear();
                self.discrete.add_start_derivative(at, start, unknowns, MomentumWeights::START, in_start);
                add_start(out, (i * m - n, i * m - n), -1.0, in_start, (m - n, n));
                block.clear();
                self.discrete.add_derivative(at, start, unknowns, MomentumWeights::START, block);
                add_start(out, (i * m - n, i * m), -1.0, block, (m - n, m));
            }
        }
        for i in self.unused() {
            out.add(i, i, 1.0);
        }
    }

    fn origin(&self, x: &mut [f64]) {
        repeat(self.q0, x);
    }

    fn limit(&self) -> LimitAtZero {
        LimitAtZero::Kept
    }

    fn scale(&self, h: f64) -> f64 {
        h.recip()
    }
}

/// Adds `scale` times the rows of `block` from `first` on, up to column `columns`, to the entries of `out` from (row, column)
/// on.
fn add_start(
    out: &mut Jacobian,
    (row, column): (usize, usize),
    scale: f64,
    block: &Jacobian,
    (first, columns): (usize, usize),
) {
    block.for_each(|i, j, x| {
        if i >= first && j < columns {
            out.add(row + i - first, column + j, scale * x);
        }
    });
}

/// Where the equations of a window of steps with n degrees of freedom and m unknowns have entries: a step is coupled to the
/// ends of the steps beside it.
fn window_structure(of_step: &Structure, n: usize, m: usize, length: usize) -> Structure {
    if let Structure::Dense | Structure::MatrixFree = of_step {
        let width = (m + n).min(length * m).saturating_sub(1);
        return Structure::Banded { lower: width, upper: width };
    }
    let entries: Vec<_> = (0..m).flat_map(|j| of_step.rows(m, j).map(move |i| (i, j))).collect();
    let positions = (0..length).flat_map(|k| {
        let (at, before) = (k * m, (k * m).wrapping_sub(n));
        entries.iter().flat_map(move |&(i, j)| {
            let own = Some((at + i, at + j));
            let in_start = (k > 0 && j < n).then(|| (at + i, before.wrapping_add(j)));
            let end = (k > 0 && i >= m - n).then(|| before.wrapping_add(i - (m - n)));
            let start_momentum = end.map(|row| (row, at + j));
            let start_in_start = end.filter(|_| j < n).map(|row| (row, before.wrapping_add(j)));
            [own, in_start, start_momentum, start_in_start].into_iter().flatten()
        })
    });
    Structure::sparse(length * m, positions).expect("all positions are below the order")
}

impl<D: DiscreteLegendre> Integrator for Window<D> {
    fn dim(&self) -> usize {
        self.discrete.dim()
    }

    fn advance(&mut self, state: &mut State, grid: &Grid) -> Result<(), StepError> {
        let step = match self.pending(state, grid) {
            Some(step) => step,
            None => {
                let Some(first) = grid.next(state.t) else { return Ok(()) };
                self.find(first, state, grid)?;
                first
            }
        };
        let m = self.scratch.block.dim();
        let unknowns = &self.unknowns[self.handed_out * m..(self.handed_out + 1) * m];
        let at = Interval { start: state.t, h: step.h };
        self.discrete.momentum(at, &state.q, unknowns, MomentumWeights::END, &mut state.p);
        state.q.copy_from_slice(&unknowns[m - self.discrete.dim()..]);
        state.t = step.end;
        self.handed_out += 1;
        self.work.steps += 1;
        Ok(())
    }

    /// The velocity that belongs to the momentum.
    fn rate(&mut self, state: &State, out: &mut [f64]) -> Result<(), StepError> {
        let unknowns = self.scratch.block.dim();
        crate::variational::velocity(&mut self.discrete, state, &mut vec![0.0; unknowns], out)
    }

    fn work(&self) -> Work {
        Work { steps: self.work.steps, ..self.work + self.march.work }
    }
}
