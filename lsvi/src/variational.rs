//! The variational integrator: a discrete Legendre transform stepped by a closure.

mod by_residuals;
mod open;

use nalgebra::DMatrix;

use by_residuals::ByResiduals;
use open::Condition;

use crate::closure::{Closure, LinearClosure, PositionMomentum};
use crate::discrete::{DiscreteLegendre, Interval, MomentumWeights};
use crate::error::{InputError, SolveError, StepError, check_length, check_step_from, check_unknowns, check_vector};
use crate::integrator::{Grid, Integrator, OneStep, State, advance_one_step, shorter_step};
use crate::linalg::{Jacobian, Lu, Structure};
use crate::newton::{LimitAtZero, Newton, System, Work};

/// One step solves the stationarity conditions and the closure together for the interior values and q₁, then sets
/// p₁ = D₂L_d, Eqs. (6), (8).
///
/// A closure whose α + β vanishes as h → 0, as that of Method II, may leave a step open, where its condition is singular as h → 0: the step is
/// [`SolveError::Singular`] then.
#[derive(Debug)]
pub struct Variational<D, C> {
    discrete: D,
    closure: C,
    /// None before the first step that needs it: explicit ones need no matrix.
    newton: Option<Newton>,
    /// Steps taken, and the evaluations of those without Newton's iteration.
    taken: Work,
    unknowns: Vec<f64>,
    impulse: Vec<f64>,
    momenta: Option<Box<Momenta>>,
    /// None before the first step that needs it.
    by_residuals: Option<Box<ByResiduals>>,
    /// None before the first step that needs it, of closures whose α + β vanishes as h → 0.
    condition: Option<Box<Condition>>,
}

/// Work space for the two momenta of closures that are not linear, and their derivatives.
#[derive(Debug)]
pub(crate) struct Momenta {
    p0: Vec<f64>,
    p1: Vec<f64>,
    /// The derivatives of the equations with p₀, and with p₁, in the place of the closure.
    start: Jacobian,
    end: Jacobian,
    in_p0: DMatrix<f64>,
    in_p1: DMatrix<f64>,
}

impl Momenta {
    fn new(discrete: &impl DiscreteLegendre, unknowns: usize) -> Self {
        let n = discrete.dim();
        let matrix = || Jacobian::with_structure(unknowns, &discrete.structure());
        Self {
            p0: vec![0.0; n],
            p1: vec![0.0; n],
            start: matrix(),
            end: matrix(),
            in_p0: DMatrix::zeros(n, n),
            in_p1: DMatrix::zeros(n, n),
        }
    }
}

impl<D: DiscreteLegendre, C: Closure> Variational<D, C> {
    /// Closes `discrete` by `closure`.
    pub fn new(discrete: D, closure: C) -> Self {
        let unknowns = discrete.interior() + discrete.dim();
        let is_linear = closure.linear().is_some();
        Self {
            closure,
            newton: None,
            taken: Work::default(),
            unknowns: vec![0.0; unknowns],
            impulse: vec![0.0; discrete.dim()],
            momenta: (!is_linear).then(|| Box::new(Momenta::new(&discrete, unknowns))),
            by_residuals: None,
            condition: None,
            discrete,
        }
    }

    /// The discrete Legendre transform.
    pub fn discrete_mut(&mut self) -> &mut D {
        &mut self.discrete
    }

    /// The unknowns of the last step: the interior values of its path, then q₁.
    pub fn unknowns(&self) -> &[f64] {
        &self.unknowns
    }
}

/// The position–momentum form of a discrete Legendre transform, Eq. (8).
pub fn position_momentum<D: DiscreteLegendre>(discrete: D) -> Variational<D, PositionMomentum> {
    Variational::new(discrete, PositionMomentum)
}

/// The equations of one step for a given (t, q₀, p₀).
pub(crate) struct StepEquations<'a> {
    pub(crate) discrete: &'a mut dyn DiscreteLegendre,
    pub(crate) closure: &'a dyn Closure,
    pub(crate) t: f64,
    pub(crate) q0: &'a [f64],
    pub(crate) p0: &'a [f64],
    /// For closures that are not linear.
    pub(crate) momenta: Option<&'a mut Momenta>,
}

impl System for StepEquations<'_> {
    fn dim(&self) -> usize {
        self.discrete.interior() + self.discrete.dim()
    }

    fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
        let (at, interior) = (Interval { start: self.t, h }, self.discrete.interior());
        if let Some(closure) = self.closure.linear() {
            self.discrete.equations(at, self.q0, x, closure.weights(h), out);
            let carried = closure.carried();
            return out[interior..].iter_mut().zip(self.p0).for_each(|(o, p)| *o -= carried * p);
        }
        let Some(m) = self.momenta.as_deref_mut() else { return out.fill(f64::NAN) };
        self.discrete.equations(at, self.q0, x, MomentumWeights::START, out);
        m.p0.copy_from_slice(&out[interior..]);
        self.discrete.momentum(at, self.q0, x, MomentumWeights::END, &mut m.p1);
        self.closure.residual(h, self.p0, &m.p0, &m.p1, &mut out[interior..]);
    }

    fn derivative(&mut self, h: f64, x: &[f64], out: &mut Jacobian) {
        let (at, interior) = (Interval { start: self.t, h }, self.discrete.interior());
        if let Some(closure) = self.closure.linear() {
            return self.discrete.add_derivative(at, self.q0, x, closure.weights(h), out);
        }
        let Some(Momenta { p0, p1, start, end, in_p0, in_p1 }) = self.momenta.as_deref_mut() else { return };
        in_p0.fill(0.0);
        in_p1.fill(0.0);
        self.closure.derivative(h, self.p0, p0, p1, in_p0, in_p1);
        start.clear();
        self.discrete.add_derivative(at, self.q0, x, MomentumWeights::START, start);
        start.for_each(|i, j, x| {
            if i < interior {
                out.add(i, j, x);
            }
        });
        end.clear();
        self.discrete.add_derivative(at, self.q0, x, MomentumWeights::END, end);
        for (matrix, in_momentum) in [(&*start, &*in_p0), (&*end, &*in_p1)] {
            matrix.for_each(|k, j, x| {
                if k >= interior {
                    let column = in_momentum.column(k - interior);
                    column.iter().enumerate().for_each(|(i, f)| out.add(interior + i, j, f * x));
                }
            });
            out.inherit_outside(matrix);
        }
    }

    fn origin(&self, x: &mut [f64]) {
        repeat(self.q0, x);
    }

    /// The derivative tends to (α + β) L_vv/h, unless α + β → 0.
    fn limit(&self) -> LimitAtZero {
        let Some(closure) = self.closure.linear() else { return LimitAtZero::Unknown };
        if closure.weights(0.0).cancel() { LimitAtZero::OfEachStep } else { LimitAtZero::Kept }
    }

    /// From the velocity that belongs to the momentum.
    fn guesses_along_tangent(&self) -> bool {
        self.closure.linear().is_some_and(|closure| closure.carried() != 0.0)
    }

    fn scale(&self, h: f64) -> f64 {
        if self.limit() == LimitAtZero::OfEachStep { 1.0 } else { h.recip() }
    }
}

/// A step so long that q is no more than a rounding beside it, in any unit of time.
const FAR: f64 = (1_u128 << 100) as f64 * (1_u128 << 100) as f64;

/// Writes the velocity that belongs to the momentum, by way of the first guess of a long step, which is q + h v; of a shorter one where that is no
/// number.
pub(crate) fn velocity(
    discrete: &mut dyn DiscreteLegendre,
    state: &State,
    x: &mut [f64],
    out: &mut [f64],
) -> Result<(), StepError> {
    let n = discrete.dim();
    check_vector("q", &state.q, n)?;
    check_vector("p", &state.p, n)?;
    check_length("out", out.len(), n)?;
    let failed = |source| StepError::Solve { t: state.t, h: 0.0, source };
    for h in [FAR, 1.0] {
        discrete.predict(Interval { start: state.t, h }, &state.q, &state.p, x).map_err(failed)?;
        let end = &x[x.len() - n..];
        out.iter_mut().zip(end).zip(&state.q).for_each(|((v, x), q)| *v = (x - q) / h);
        if out.iter().all(|v| v.is_finite()) {
            break;
        }
    }
    Ok(())
}

/// Writes copies of `q` into all of `x`.
pub(crate) fn repeat(q: &[f64], x: &mut [f64]) {
    x.chunks_exact_mut(q.len()).for_each(|values| values.copy_from_slice(q));
}

impl<D: DiscreteLegendre, C: Closure> Integrator for Variational<D, C> {
    fn dim(&self) -> usize {
        self.discrete.dim()
    }

    fn advance(&mut self, state: &mut State, grid: &Grid) -> Result<(), StepError> {
        advance_one_step(self, state, grid)
    }

    /// The velocity that belongs to the momentum.
    fn rate(&mut self, state: &State, out: &mut [f64]) -> Result<(), StepError> {
        velocity(&mut self.discrete, state, &mut self.unknowns.clone(), out)
    }

    fn shorter_step(&mut self, from: &State, t: f64, to: &mut State) -> Option<Result<(), StepError>> {
        shorter_step(self, from, t, to)
    }

    fn work(&self) -> Work {
        let works = self.newton.iter().map(|newton| newton.work).chain(self.by_residuals.iter().map(|by| by.work()));
        let factorizations = self.condition.as_ref().map_or(0, |condition| condition.factorizations());
        works.fold(Work { factorizations, ..self.taken }, |sum, work| sum + work)
    }
}

impl<D: DiscreteLegendre, C: Closure> OneStep for Variational<D, C> {
    fn step(&mut self, t: f64, h: f64, q: &mut [f64], p: &mut [f64]) -> Result<(), StepError> {
        if self.is_position_momentum(h) && self.step_separably(Interval { start: t, h }, q, p)? {
            return Ok(());
        }
        self.solve(t, h, q, p)?;
        self.finish(Interval { start: t, h }, q, p);
        Ok(())
    }
}

impl<D: DiscreteLegendre, C: LinearClosure> Variational<D, C> {
    /// Takes a [`step`](OneStep::step) and returns its derivative ∂(q₁, p₁)/∂(q₀, p₀), 2n × 2n, by implicit differentiation.
    ///
    /// # Errors
    /// [`StepError`] as for a step, or where the derivative of the step equations is singular at their solution.
    pub fn step_with_tangent(
        &mut self,
        t: f64,
        h: f64,
        q: &mut [f64],
        p: &mut [f64],
    ) -> Result<DMatrix<f64>, StepError> {
        self.solve(t, h, q, p)?;
        let (at, n, unknowns) = (Interval { start: t, h }, q.len(), self.unknowns.len());
        let interior = unknowns - n;
        let equations = self.closure.weights(h);
        let structure = self.discrete.structure();
        let mut in_unknowns = Jacobian::with_structure(unknowns, &structure);
        self.discrete.add_derivative(at, q, &self.unknowns, equations, &mut in_unknowns);
        // The derivatives of x in (q₀, p₀): those of −(stationarity, α p₀ + β p₁ − σ p), then solved for x.
        let mut x = DMatrix::zeros(unknowns, 2 * n);
        let mut in_start = Jacobian::with_structure(unknowns, &structure);
        self.discrete.add_start_derivative(at, q, &self.unknowns, equations, &mut in_start);
        x.columns_mut(0, n).copy_from(&-in_start.to_dense().columns(0, n));
        (0..n).for_each(|i| x[(interior + i, n + i)] = self.closure.carried());
        let mut lu = Lu::of(&in_unknowns);
        lu.factor(&in_unknowns).map_err(|error| StepError::Solve { t, h, source: error.into() })?;
        for mut column in x.column_iter_mut() {
            lu.solve(column.as_mut_slice());
        }
        in_unknowns.clear();
        self.discrete.add_derivative(at, q, &self.unknowns, MomentumWeights::END, &mut in_unknowns);
        in_start.clear();
        self.discrete.add_start_derivative(at, q, &self.unknowns, MomentumWeights::END, &mut in_start);
        let mut tangent = DMatrix::zeros(2 * n, 2 * n);
        tangent.rows_mut(0, n).copy_from(&x.rows(interior, n));
        tangent.rows_mut(n, n).copy_from(&(in_unknowns.to_dense().rows(interior, n) * &x));
        let mut momentum_in_q0 = tangent.view_mut((n, 0), (n, n));
        momentum_in_q0 += in_start.to_dense().view((interior, 0), (n, n));
        self.finish(at, q, p);
        Ok(tangent)
    }
}

impl<D: DiscreteLegendre, C: Closure> Variational<D, C> {
    /// Whether the closure is that p₀ is the momentum that the state carries.
    fn is_position_momentum(&self, h: f64) -> bool {
        self.closure.linear().is_some_and(|c| c.carried() == 1.0 && c.weights(h) == MomentumWeights::START)
    }

    /// Refuses what cannot be a step.
    #[inline]
    fn check(&self, at: Interval, q: &[f64], p: &[f64]) -> Result<(), InputError> {
        let n = self.discrete.dim();
        check_unknowns(n)?;
        check_step_from(at.start, at.h)?;
        check_vector("q", q, n)?;
        check_vector("p", p, n)
    }

    fn step_separably(&mut self, at: Interval, q: &mut [f64], p: &mut [f64]) -> Result<bool, StepError> {
        self.check(at, q, p)?;
        let failed = |source| StepError::Solve { t: at.start, h: at.h, source };
        let evaluations = self.discrete.separable_step(at, q, p, &mut self.unknowns).map_err(failed)?;
        if let Some(evaluations) = evaluations {
            self.taken.steps += 1;
            self.taken.residuals += evaluations;
        }
        Ok(evaluations.is_some())
    }

    /// Finds the unknowns of the step. Where the closure leaves it open, those that meet it are no better than others, and it is refused.
    fn solve(&mut self, t: f64, h: f64, q: &[f64], p: &[f64]) -> Result<(), StepError> {
        let at = Interval { start: t, h };
        self.check(at, q, p)?;
        let found = self.find_unknowns(at, q, p);
        let may_be_open = found.as_ref().err().is_none_or(SolveError::is_lost);
        let found = if may_be_open && self.is_open(at, q) { Err(SolveError::Singular) } else { found };
        found.map_err(|source| StepError::Solve { t, h, source })
    }

    fn find_unknowns(&mut self, at: Interval, q: &[f64], p: &[f64]) -> Result<(), SolveError> {
        if self.by_residuals.as_ref().is_some_and(|by| by.is_in_use) && self.solve_by_residuals(at, q, p) {
            return Ok(());
        }
        let found = self.solve_by_momenta(at, q, p);
        let is_lost = found.as_ref().is_err_and(SolveError::is_lost);
        if is_lost && self.solve_by_residuals(at, q, p) { Ok(()) } else { found }
    }

    /// Whether the closure leaves a step open.
    fn is_open(&mut self, at: Interval, q: &[f64]) -> bool {
        let Some(closure) = self.closure.linear().filter(|closure| closure.weights(0.0).cancel()) else { return false };
        let (discrete, unknowns) = (&mut self.discrete, self.unknowns.len());
        let condition = self.condition.get_or_insert_with(|| Box::new(Condition::new(discrete, unknowns)));
        condition.is_open(discrete, closure.weights(at.h), at, q)
    }

    /// Finds the unknowns by the equations of the momenta.
    fn solve_by_momenta(&mut self, at: Interval, q: &[f64], p: &[f64]) -> Result<(), SolveError> {
        let Interval { start: t, h } = at;
        let newton = self.newton.get_or_insert_with(|| {
            // A closure that is not linear may couple all components.
            let is_linear = self.closure.linear().is_some();
            let structure = if is_linear { self.discrete.structure() } else { Structure::Dense };
            Newton::with_structure(self.unknowns.len(), &structure)
        });
        let mut equations = StepEquations {
            discrete: &mut self.discrete,
            closure: &self.closure,
            t,
            q0: q,
            p0: p,
            momenta: self.momenta.as_deref_mut(),
        };
        repeat(q, &mut self.unknowns);
        if newton.solve_with_kept(&mut equations, h, &mut self.unknowns) {
            return Ok(());
        }
        // F(p, p) = 0, which a nonlinear closure amounts to for h → 0, may have several roots: the one near the state's p counts.
        if self.closure.linear().is_none_or(|closure| closure.carried() != 0.0) {
            equations.discrete.predict(at, q, p, &mut self.unknowns)?;
        }
        if self.closure.linear().is_none() {
            return newton.solve_traced(&mut equations, h, &mut self.unknowns);
        }
        newton.solve(&mut equations, h, &mut self.unknowns)?;
        newton.keep(&mut equations, h, &self.unknowns);
        Ok(())
    }

    /// Finds the unknowns by those of the residuals, if there are such and unlike units may be what hides the branch.
    #[cold]
    fn solve_by_residuals(&mut self, at: Interval, q: &[f64], p: &[f64]) -> bool {
        let Some(closure) = self.closure.linear() else { return false };
        if self.by_residuals.is_none() {
            self.by_residuals = ByResiduals::new(&self.discrete, closure).map(Box::new);
        }
        let Some(by_residuals) = &mut self.by_residuals else { return false };
        if !by_residuals.is_in_use && !self.discrete.has_unlike_units(at, q) {
            return false;
        }
        repeat(q, &mut self.unknowns);
        by_residuals.solve(&mut self.discrete, closure, at, (q, p), &mut self.unknowns).is_ok()
    }

    /// Replaces (q₀, p₀) by (q₁, p₁).
    fn finish(&mut self, at: Interval, q: &mut [f64], p: &mut [f64]) {
        let has_impulse =
            self.is_position_momentum(at.h) && self.discrete.impulse(at, q, &self.unknowns, &mut self.impulse);
        if has_impulse {
            p.iter_mut().zip(&self.impulse).for_each(|(p, impulse)| *p += impulse);
        } else {
            self.discrete.momentum(at, q, &self.unknowns, MomentumWeights::END, p);
        }
        q.copy_from_slice(&self.unknowns[self.discrete.interior()..]);
        self.taken.steps += 1;
    }
}
