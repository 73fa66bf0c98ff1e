//! Integrators of mechanics with holonomic constraints.

mod tangent;

use std::cell::RefCell;
use std::ops::RangeInclusive;

use nalgebra::DMatrix;

use crate::constraint::Constraint;
use crate::discrete::{Constrainable, Interval, MomentumWeights};
use crate::error::{
    ConstraintError, InputError, SolveError, StepError, SystemError, check_step_from, check_time, check_unknowns,
    check_vector,
};
use crate::integrator::{Grid, Integrator, OneStep, State, advance_one_step, shorter_step};
use crate::lagrangian::{HessianWeights, Lagrangian};
use crate::linalg::{Entrywise, Jacobian, add_block};
use crate::newton::{LimitAtZero, Newton, System, Work};

/// Roundings of q that a state on the constraint may be off by.
const ROUNDINGS: f64 = 1e3;

/// The position–momentum form of a discretisation on the constraint f(q) = 0, by multipliers at the nodes.
///
/// With G = ∂f/∂q, one step from (q₀, p₀) finds the path, its end q₁ and the multipliers of
///
/// - stationarity at each interior node of the discretisation with an impulse Gᵀλ there, and f = 0 at the node,
/// - −D₁L_d = p₀ − G(q₀)ᵀΛ and f(q₁) = 0,
///
/// and then removes from p₁ = D₂L_d the part Gᵀμ whose velocity would leave the constraint: G ∂H/∂p = 0 at (q₁, p₁).
/// For [`Trapezoidal`](crate::discrete::Trapezoidal) that is the RATTLE method, for
/// [`Galerkin`](crate::discrete::Galerkin) its generalisation of order 2s; both are symplectic on the constraint.
/// [`PathFitted`](crate::discrete::PathFitted) keeps the order that it has without constraints.
#[derive(Debug)]
pub struct Constrained<D, K> {
    discrete: D,
    constraint: Scaled<K>,
    newton: Newton,
    unknowns: Vec<f64>,
    projector: Projector,
    scratch: Scratch,
}

/// The constraints times a power of two each.
///
/// A multiplier is of the size of a displacement if its row of G is of that of M = ∂²L/∂v²: then unknowns and equations have one size each,
/// whatever the units of f and of L.
#[derive(Debug)]
struct Scaled<K> {
    constraint: K,
    /// 1 before the first step.
    scales: Vec<f64>,
    is_set: bool,
    /// Multipliers of the constraints themselves.
    multipliers: RefCell<Vec<f64>>,
}

impl<K: Constraint> Scaled<K> {
    fn new(constraint: K) -> Self {
        let m = constraint.count();
        Self { constraint, scales: vec![1.0; m], is_set: false, multipliers: RefCell::new(vec![0.0; m]) }
    }
}

impl<K: Constraint> Constraint for Scaled<K> {
    fn dim(&self) -> usize {
        self.constraint.dim()
    }

    fn count(&self) -> usize {
        self.constraint.count()
    }

    fn value(&self, q: &[f64], out: &mut [f64]) {
        self.constraint.value(q, out);
        out.iter_mut().zip(&self.scales).for_each(|(f, s)| *f *= s);
    }

    fn jacobian(&self, q: &[f64], out: &mut DMatrix<f64>) {
        self.constraint.jacobian(q, out);
        out.row_iter_mut().zip(&self.scales).for_each(|(mut row, s)| row *= *s);
    }

    fn add_curvature(&self, q: &[f64], multipliers: &[f64], scale: f64, out: &mut Jacobian) {
        let mut own = self.multipliers.borrow_mut();
        own.iter_mut().zip(multipliers.iter().zip(&self.scales)).for_each(|(own, (l, s))| *own = l * s);
        self.constraint.add_curvature(q, &own, scale, out);
    }
}

/// A momentum, to be projected on the hidden constraint, and its velocity.
#[derive(Debug)]
struct Projector {
    newton: Newton,
    p: Vec<f64>,
    /// (v, μ) of [`Projection`].
    velocity: Vec<f64>,
}

#[derive(Debug)]
struct Scratch {
    /// G at q₀, and at the place in hand.
    at_start: DMatrix<f64>,
    gradient: DMatrix<f64>,
    position: Vec<f64>,
    reaction: Vec<f64>,
    dl_dq: Vec<f64>,
    block: Jacobian,
    path: Jacobian,
}

impl<D: Constrainable, K: Constraint> Constrained<D, K> {
    /// Holds the motions of `discrete` on `constraint`.
    ///
    /// # Errors
    /// [`SystemError::Dimension`] if the two differ in their degrees of freedom, [`ConstraintError::RedundantConstraints`] if there
    /// are more constraints than those.
    pub fn new(discrete: D, constraint: K) -> Result<Self, InputError> {
        let (n, m) = (discrete.dim(), constraint.count());
        check_unknowns(n)?;
        if constraint.dim() != n {
            return Err(InputError::System(SystemError::Dimension {
                what: "constraint",
                expected: n,
                found: constraint.dim(),
            }));
        }
        if m > n {
            return Err(InputError::Constraint(ConstraintError::RedundantConstraints { count: m, rank: n }));
        }
        let path = discrete.interior() + n;
        let unknowns = path + path / n * m;
        let scratch = Scratch {
            at_start: DMatrix::zeros(m, n),
            gradient: DMatrix::zeros(m, n),
            position: vec![0.0; n],
            reaction: vec![0.0; n],
            dl_dq: vec![0.0; n],
            block: Jacobian::zeros(n),
            path: Jacobian::zeros(path),
        };
        Ok(Self {
            discrete,
            constraint: Scaled::new(constraint),
            newton: Newton::new(unknowns),
            unknowns: vec![0.0; unknowns],
            projector: Projector { newton: Newton::new(n + m), p: vec![0.0; n], velocity: vec![0.0; n + m] },
            scratch,
        })
    }

    /// The discretisation.
    pub fn discrete_mut(&mut self) -> &mut D {
        &mut self.discrete
    }

    /// Replaces `p` by its projection on the hidden constraint, the momentum of a velocity with G v = 0.
    ///
    /// # Errors
    /// [`StepError`] if the vectors are unusable, the constraints redundant at `q`, or ∂²L/∂v² singular along them.
    pub fn project(&mut self, t: f64, q: &[f64], p: &mut [f64]) -> Result<(), StepError> {
        let n = self.discrete.dim();
        check_time(t)?;
        check_vector("q", q, n)?;
        check_vector("p", p, n)?;
        self.projector.start(p);
        self.set_scales(t, q);
        let lagrangian = self.discrete.mechanics();
        self.projector.project(lagrangian, &self.constraint, &mut self.scratch, (t, 0.0), q)?;
        p.copy_from_slice(&self.projector.p);
        Ok(())
    }

    /// Fits the size of each row of G to that of M, once.
    fn set_scales(&mut self, t: f64, q: &[f64]) {
        if std::mem::replace(&mut self.constraint.is_set, true) {
            return;
        }
        let Scratch { gradient, block, position, .. } = &mut self.scratch;
        self.constraint.jacobian(q, gradient);
        block.clear();
        position.fill(0.0);
        let mass = HessianWeights { vv: 1.0, ..Default::default() };
        self.discrete.mechanics().add_hessian(t, q, position, mass, block);
        let mut largest = 0.0_f64;
        block.for_each(|_, _, m| largest = largest.max(m.abs()));
        for (scale, row) in self.constraint.scales.iter_mut().zip(gradient.row_iter()) {
            let fitted = (largest / row.amax()).log2().round().exp2();
            *scale = if fitted.is_normal() { fitted } else { 1.0 };
        }
    }

    /// The distance within which the k-th constraint is like its tangent, |∇f| / |∇²f|.
    fn radius(&mut self, k: usize, q: &[f64]) -> f64 {
        let Scratch { gradient, block, .. } = &mut self.scratch;
        let unit: Vec<f64> = (0..self.constraint.count()).map(|i| if i == k { 1.0 } else { 0.0 }).collect();
        block.clear();
        self.constraint.add_curvature(q, &unit, 1.0, block);
        let mut square = 0.0;
        block.for_each(|_, _, x| square += x * x);
        gradient.row(k).norm() / square.sqrt()
    }

    /// Refuses a state that is off the constraint by more than half of the digits of a length: of q or, as q may be counted from afar, of
    /// the radius of the constraint, or of the step.
    fn check_consistency(&mut self, t: f64, h: f64, q: &[f64]) -> Result<(), StepError> {
        let lagrangian = self.discrete.mechanics();
        self.projector.project(lagrangian, &self.constraint, &mut self.scratch, (t, h), q)?;
        let scratch = &mut self.scratch;
        let tolerance = f64::EPSILON.sqrt();
        let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let off = scratch.reaction.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        if let Some((index, &value)) = off.filter(|(_, r)| r.abs() > tolerance * norm(&self.projector.p)) {
            return Err(InputError::Constraint(ConstraintError::OffHiddenConstraint { index, value }).into());
        }
        let (length, way) = (norm(q), h * norm(&self.projector.velocity[..q.len()]));
        self.constraint.value(q, &mut scratch.reaction[..self.constraint.count()]);
        for index in 0..self.constraint.count() {
            let scaled = self.scratch.reaction[index];
            let value = scaled / self.constraint.scales[index];
            if !value.is_finite() {
                return Err(
                    InputError::System(SystemError::NonFinite { what: "the constraint f", index, value }).into()
                );
            }
            // |f| / |∇f| is the distance from the constraint.
            let distance = scaled.abs() / self.scratch.gradient.row(index).norm();
            let is_near = distance <= tolerance * way + ROUNDINGS * f64::EPSILON * length;
            if !is_near && distance > tolerance * (length.min(self.radius(index, q)) + way) {
                return Err(InputError::Constraint(ConstraintError::OffConstraint { index, value }).into());
            }
        }
        let scratch = &mut self.scratch;
        scratch.at_start.copy_from(&scratch.gradient);
        Ok(())
    }
}

impl Projector {
    /// Takes up a momentum, without a guess of its velocity.
    fn start(&mut self, p: &[f64]) {
        self.p.copy_from_slice(p);
        self.velocity.fill(0.0);
    }

    /// Finds (v, μ) at `q` and subtracts Gᵀμ, left in `scratch.reaction`, from `p`.
    fn project(
        &mut self,
        lagrangian: &dyn Lagrangian,
        constraint: &dyn Constraint,
        scratch: &mut Scratch,
        (t, h): (f64, f64),
        q: &[f64],
    ) -> Result<(), StepError> {
        let (n, count) = (q.len(), constraint.count());
        constraint.jacobian(q, &mut scratch.gradient);
        let mut projection = Projection { lagrangian, scratch, t, q, p: &self.p };
        let solved = self.newton.attempt(&mut projection, 1.0, &mut self.velocity);
        if let Err(mut source) = solved {
            if source == SolveError::Singular {
                // Of rows that are one but for half of the digits G M⁻¹ Gᵀ is singular, whatever their lengths.
                let mut directions = scratch.gradient.clone();
                directions.row_iter_mut().filter(|row| row.norm() > 0.0).for_each(|mut row| row /= row.norm());
                let rank = directions.rank((n as f64 * f64::EPSILON).sqrt());
                if rank < count {
                    return Err(InputError::Constraint(ConstraintError::RedundantConstraints { count, rank }).into());
                }
                source = SolveError::SingularMass;
            }
            return Err(StepError::Solve { t, h, source });
        }
        set_reaction(&scratch.gradient, &self.velocity[n..], 1.0, &mut scratch.reaction);
        self.p.iter_mut().zip(&scratch.reaction).for_each(|(p, r)| *p -= r);
        Ok(())
    }
}

/// Writes `scale` Gᵀλ.
fn set_reaction(gradient: &DMatrix<f64>, multipliers: &[f64], scale: f64, out: &mut [f64]) {
    for (o, column) in out.iter_mut().zip(gradient.column_iter()) {
        *o = scale * column.iter().zip(multipliers).map(|(g, l)| g * l).sum::<f64>();
    }
}

/// Adds `scale` Gᵀ to the entries of `out` from (row, column) on.
fn add_transposed(out: &mut impl Entrywise, (row, column): (usize, usize), scale: f64, gradient: &DMatrix<f64>) {
    gradient.visit(|k, i, g| out.add_entry(row + i, column + k, scale * g));
}

/// L_v(v) + Gᵀμ = p and G v = 0 for (v, μ).
struct Projection<'a> {
    lagrangian: &'a dyn Lagrangian,
    scratch: &'a mut Scratch,
    t: f64,
    q: &'a [f64],
    p: &'a [f64],
}

impl System for Projection<'_> {
    fn dim(&self) -> usize {
        let (m, n) = self.scratch.gradient.shape();
        m + n
    }

    fn residual(&mut self, _: f64, x: &[f64], out: &mut [f64]) {
        let Scratch { gradient, reaction, dl_dq, .. } = &mut *self.scratch;
        let (v, multipliers) = x.split_at(self.q.len());
        let (momentum, hidden) = out.split_at_mut(v.len());
        self.lagrangian.gradient(self.t, self.q, v, dl_dq, momentum);
        set_reaction(gradient, multipliers, 1.0, reaction);
        for ((o, r), p) in momentum.iter_mut().zip(reaction).zip(self.p) {
            *o += *r - p;
        }
        for (o, row) in hidden.iter_mut().zip(gradient.row_iter()) {
            *o = row.iter().zip(v).map(|(g, v)| g * v).sum();
        }
    }

    fn derivative(&mut self, _: f64, x: &[f64], out: &mut Jacobian) {
        let Scratch { gradient, block, .. } = &mut *self.scratch;
        let n = self.q.len();
        block.clear();
        let mass = HessianWeights { vv: 1.0, ..Default::default() };
        self.lagrangian.add_hessian(self.t, self.q, &x[..n], mass, block);
        add_block(out, (0, 0), 1.0, block);
        add_transposed(out, (0, n), 1.0, gradient);
        add_block(out, (n, 0), 1.0, gradient);
    }
}

/// The equations of one step in (interior values, q₁, multipliers at the interior nodes, Λ).
///
/// A reaction is the impulse Gᵀλ/h: then λ is of the size of a displacement, and so is its rounding. With f/h for f the derivative tends to a
/// matrix over h, [[M, Gᵀ], [G, 0]] of a single node.
struct StepEquations<'a> {
    discrete: &'a mut dyn Constrainable,
    constraint: &'a dyn Constraint,
    scratch: &'a mut Scratch,
    t: f64,
    q0: &'a [f64],
    p0: &'a [f64],
    /// Whether the first guess is one by the velocity that belongs to p₀, which is the tangent of the branch at h = 0.
    is_predicted: bool,
}

impl StepEquations<'_> {
    /// Degree of the path and length of its unknowns.
    fn path(&self) -> (usize, usize) {
        let unknowns = self.discrete.interior() + self.q0.len();
        (unknowns / self.q0.len(), unknowns)
    }

    /// Sets `position` and `gradient` to those of an interior node.
    fn place(&mut self, node: usize, x: &[f64]) {
        let position = &mut self.scratch.position;
        position.copy_from_slice(self.q0);
        for (j, values) in x.chunks_exact(self.q0.len()).enumerate() {
            let weight = self.discrete.position_weight(node, j + 1);
            for ((o, x), q) in position.iter_mut().zip(values).zip(self.q0) {
                *o += weight * (x - q);
            }
        }
        self.constraint.jacobian(position, &mut self.scratch.gradient);
    }

    /// Adds the derivatives of the reaction at an interior node and of the constraints there in the given control values.
    fn add_reaction(
        &mut self,
        node: usize,
        h: f64,
        y: &[f64],
        columns: RangeInclusive<usize>,
        out: &mut impl Entrywise,
    ) {
        let (n, m, unknowns) = (self.q0.len(), self.constraint.count(), self.path().1);
        let (x, multipliers) = y.split_at(unknowns);
        self.place(node, x);
        let Scratch { gradient, position, block, .. } = &mut *self.scratch;
        let weight = self.discrete.reaction_weight(node, MomentumWeights::START);
        block.clear();
        self.constraint.add_curvature(position, &multipliers[(node - 1) * m..node * m], h.recip(), block);
        for (column, j) in columns.enumerate() {
            let (inside, column) = (self.discrete.position_weight(node, j), column * n);
            add_block(out, ((node - 1) * n, column), inside, block);
            add_block(out, (unknowns - n, column), weight * inside, block);
            add_block(out, (unknowns + (node - 1) * m, column), inside / h, gradient);
        }
    }

    /// Writes p₁ = D₂L_d of a solution.
    fn end_momentum(&mut self, h: f64, y: &[f64], out: &mut [f64]) {
        let (m, (degree, unknowns)) = (self.constraint.count(), self.path());
        let (x, multipliers) = y.split_at(unknowns);
        self.discrete.momentum(Interval { start: self.t, h }, self.q0, x, MomentumWeights::END, out);
        for node in 1..degree {
            let weight = self.discrete.reaction_weight(node, MomentumWeights::END);
            self.place(node, x);
            let Scratch { gradient, reaction, .. } = &mut *self.scratch;
            set_reaction(gradient, &multipliers[(node - 1) * m..node * m], weight / h, reaction);
            out.iter_mut().zip(reaction).for_each(|(o, r)| *o += *r);
        }
    }
}

impl System for StepEquations<'_> {
    fn dim(&self) -> usize {
        let (degree, unknowns) = self.path();
        unknowns + degree * self.constraint.count()
    }

    fn residual(&mut self, h: f64, y: &[f64], out: &mut [f64]) {
        let (n, m, (degree, unknowns)) = (self.q0.len(), self.constraint.count(), self.path());
        let (x, multipliers) = y.split_at(unknowns);
        let (equations, constraints) = out.split_at_mut(unknowns);
        let at = Interval { start: self.t, h };
        self.discrete.equations(at, self.q0, x, MomentumWeights::START, equations);
        let (stationarity, momentum) = equations.split_at_mut(unknowns - n);
        momentum.iter_mut().zip(self.p0).for_each(|(o, p)| *o -= p);
        for node in 1..degree {
            let own = (node - 1) * m..node * m;
            self.place(node, x);
            let Scratch { gradient, position, reaction, .. } = &mut *self.scratch;
            self.constraint.value(position, &mut constraints[own.clone()]);
            set_reaction(gradient, &multipliers[own], h.recip(), reaction);
            let weight = self.discrete.reaction_weight(node, MomentumWeights::START);
            for (i, r) in reaction.iter().enumerate() {
                stationarity[(node - 1) * n + i] += r;
                momentum[i] += weight * r;
            }
        }
        let own = (degree - 1) * m..;
        self.constraint.value(&x[unknowns - n..], &mut constraints[own.clone()]);
        constraints.iter_mut().for_each(|f| *f /= h);
        set_reaction(&self.scratch.at_start, &multipliers[own], h.recip(), &mut self.scratch.reaction);
        momentum.iter_mut().zip(&self.scratch.reaction).for_each(|(o, r)| *o += r);
    }

    fn derivative(&mut self, h: f64, y: &[f64], out: &mut Jacobian) {
        let (n, m, (degree, unknowns)) = (self.q0.len(), self.constraint.count(), self.path());
        let x = &y[..unknowns];
        self.scratch.path.clear();
        let at = Interval { start: self.t, h };
        self.discrete.add_derivative(at, self.q0, x, MomentumWeights::START, &mut self.scratch.path);
        add_block(out, (0, 0), 1.0, &self.scratch.path);
        let end = unknowns - n;
        for node in 1..degree {
            self.add_reaction(node, h, y, 1..=degree, out);
            let own = unknowns + (node - 1) * m;
            let weight = self.discrete.reaction_weight(node, MomentumWeights::START);
            add_transposed(out, ((node - 1) * n, own), h.recip(), &self.scratch.gradient);
            add_transposed(out, (end, own), weight / h, &self.scratch.gradient);
        }
        let own = unknowns + (degree - 1) * m;
        add_transposed(out, (end, own), h.recip(), &self.scratch.at_start);
        self.constraint.jacobian(&x[end..], &mut self.scratch.gradient);
        add_block(out, (own, end), h.recip(), &self.scratch.gradient);
    }

    fn origin(&self, y: &mut [f64]) {
        let (x, multipliers) = y.split_at_mut(self.path().1);
        x.chunks_exact_mut(self.q0.len()).for_each(|values| values.copy_from_slice(self.q0));
        multipliers.fill(0.0);
    }

    fn limit(&self) -> LimitAtZero {
        if self.is_predicted { LimitAtZero::Kept } else { LimitAtZero::Unknown }
    }

    /// By its first guess, which is asked for where the limit is kept alone.
    fn guesses_along_tangent(&self) -> bool {
        true
    }

    fn scale(&self, h: f64) -> f64 {
        h.recip()
    }
}

impl<D: Constrainable, K: Constraint> Integrator for Constrained<D, K> {
    fn dim(&self) -> usize {
        self.discrete.dim()
    }

    fn advance(&mut self, state: &mut State, grid: &Grid) -> Result<(), StepError> {
        advance_one_step(self, state, grid)
    }

    /// The velocity that belongs to the momentum.
    fn rate(&mut self, state: &State, out: &mut [f64]) -> Result<(), StepError> {
        let unknowns = self.discrete.interior() + self.discrete.dim();
        crate::variational::velocity(&mut self.discrete, state, &mut vec![0.0; unknowns], out)
    }

    fn shorter_step(&mut self, from: &State, t: f64, to: &mut State) -> Option<Result<(), StepError>> {
        shorter_step(self, from, t, to)
    }

    fn work(&self) -> Work {
        let (steps, projections) = (self.newton.work, self.projector.newton.work);
        Work { steps: steps.steps, ..steps + projections }
    }
}

impl<D: Constrainable, K: Constraint> OneStep for Constrained<D, K> {
    fn step(&mut self, t: f64, h: f64, q: &mut [f64], p: &mut [f64]) -> Result<(), StepError> {
        self.solve(t, h, q, p)?;
        self.finish(q, p);
        Ok(())
    }
}

impl<D: Constrainable, K: Constraint> Constrained<D, K> {
    /// Finds the unknowns of the step and the momentum that ends it.
    fn solve(&mut self, t: f64, h: f64, q: &[f64], p: &[f64]) -> Result<(), StepError> {
        let n = self.discrete.dim();
        check_step_from(t, h)?;
        check_vector("q", q, n)?;
        check_vector("p", p, n)?;
        self.projector.start(p);
        self.set_scales(t, q);
        self.check_consistency(t, h, q)?;
        let at = Interval { start: t, h };
        let path = self.discrete.interior() + n;
        let mut equations = StepEquations {
            discrete: &mut self.discrete,
            constraint: &self.constraint,
            scratch: &mut self.scratch,
            t,
            q0: q,
            p0: p,
            is_predicted: true,
        };
        equations.origin(&mut self.unknowns);
        // A mass matrix that is singular across the constraint only leaves the configuration itself as a first guess.
        if equations.discrete.predict(at, q, p, &mut self.unknowns[..path]).is_err() {
            equations.is_predicted = false;
            equations.origin(&mut self.unknowns);
        }
        self.newton.solve(&mut equations, h, &mut self.unknowns).map_err(|source| StepError::Solve { t, h, source })?;
        equations.end_momentum(h, &self.unknowns, &mut self.projector.p);
        let q1 = &self.unknowns[path - n..path];
        let lagrangian = self.discrete.mechanics();
        self.projector.project(lagrangian, &self.constraint, &mut self.scratch, (t + h, h), q1)
    }

    /// Replaces (q₀, p₀) by (q₁, p₁).
    fn finish(&mut self, q: &mut [f64], p: &mut [f64]) {
        let end = self.discrete.interior();
        q.copy_from_slice(&self.unknowns[end..end + q.len()]);
        p.copy_from_slice(&self.projector.p);
        self.newton.work.steps += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::autodiff::{AutoConstraint, AutoLagrangian, ConstraintFn, LagrangianFn, Scalar};
    use crate::discrete::{Galerkin, PathFitted};

    /// Nothing in it quadratic, and it depends on time.
    pub(super) struct Body;
    impl LagrangianFn for Body {
        fn dim(&self) -> usize {
            3
        }
        fn lagrangian<T: Scalar>(&self, t: T, q: &[T], v: &[T]) -> T {
            let mass = (q[0] * q[1] + t).sin() + 2.0;
            mass * (v[0] * v[0] + v[1] * v[1]) * 0.5 + (v[2] * v[2] + 1.0).sqrt() + q[2] * v[0] - q[2].cos()
        }
    }

    pub(super) struct Curve;
    impl ConstraintFn for Curve {
        fn dim(&self) -> usize {
            3
        }
        fn count(&self) -> usize {
            2
        }
        fn constraint<T: Scalar>(&self, q: &[T], out: &mut [T]) {
            out[0] = q[0] * q[0] + q[1] * q[1] * 2.0 + q[2].sin() - 1.0;
            out[1] = q[0] * q[1] * q[2] - 0.05;
        }
    }

    /// The largest difference between the derivative of `system` at `y` and central differences, relative to its entries.
    fn defect(system: &mut dyn System, h: f64, y: &[f64]) -> f64 {
        let n = system.dim();
        let mut exact = Jacobian::zeros(n);
        system.derivative(h, y, &mut exact);
        let (e, mut plus, mut minus, mut x) = (1e-5, vec![0.0; n], vec![0.0; n], y.to_vec());
        let mut worst = 0.0_f64;
        for j in 0..n {
            x[j] = y[j] + e;
            system.residual(h, &x, &mut plus);
            x[j] = y[j] - e;
            system.residual(h, &x, &mut minus);
            x[j] = y[j];
            for i in 0..n {
                worst = worst.max((exact.get(i, j) - (plus[i] - minus[i]) / (2.0 * e)).abs());
            }
        }
        worst / exact.to_dense().amax()
    }

    fn check(discrete: impl Constrainable) {
        let mut method = Constrained::new(discrete, AutoConstraint::new(Curve)).expect("dimensions fit");
        let q0 = [0.5, 0.4, 0.3];
        let mut wave = (0..).map(|i| 0.1 * (1.7 * f64::from(i)).sin());
        let y: Vec<f64> =
            method.unknowns.iter().enumerate().map(|(i, _)| q0[i % 3] + wave.next().unwrap_or(0.0)).collect();
        method.constraint.jacobian(&q0, &mut method.scratch.at_start);
        let mut equations = StepEquations {
            discrete: &mut method.discrete,
            constraint: &method.constraint,
            scratch: &mut method.scratch,
            t: 0.2,
            q0: &q0,
            p0: &[0.1, 0.2, 0.3],
            is_predicted: true,
        };
        // Differences of step 1e-5: e² + ε/e relative to third derivatives of the size of the largest entry.
        let step = defect(&mut equations, 0.4, &y);
        assert!(step < 1e-8, "{step:e}");
        let lagrangian = method.discrete.mechanics();
        method.constraint.jacobian(&q0, &mut method.scratch.gradient);
        let mut projection =
            Projection { lagrangian, scratch: &mut method.scratch, t: 0.2, q: &q0, p: &[0.1, 0.2, 0.3] };
        let hidden = defect(&mut projection, 1.0, &y[..5]);
        assert!(hidden < 1e-8, "{hidden:e}");
    }

    #[test]
    fn derivatives_of_the_step_equations_are_exact() {
        let l = AutoLagrangian::new(Body);
        check(Galerkin::gauss(&l, 3).expect("s ≥ 1"));
        check(PathFitted::new(&l, &[0.3, 0.8]).expect("nodes"));
        check(PathFitted::bernstein(&l, &[0.3, 0.8]).expect("nodes"));
    }
}
