//! A problem that counts how often its equations are evaluated, whoever steps them: f, or where a method takes them the first
//! derivatives of the Lagrangian, which are the forces.

use std::sync::atomic::{AtomicU64, Ordering};

use lsvi::{EulerLagrange, HessianWeights, Jacobian, Lagrangian, Mass, MotionWeights, Structure, VectorField};

use crate::problem::{Facts, Mechanics, Problem};
use crate::reference::Ode;

/// The problem and its count.
#[derive(Debug)]
pub(super) struct Counted<'a> {
    problem: &'a dyn Problem,
    count: AtomicU64,
}

impl<'a> Counted<'a> {
    pub(super) fn new(problem: &'a dyn Problem) -> Self {
        Self { problem, count: AtomicU64::new(0) }
    }

    /// Evaluations until now.
    pub(super) fn count(&self) -> u64 {
        self.count.load(Ordering::Relaxed)
    }
}

/// Equations beside the count.
struct Counting<'a, T> {
    inner: T,
    count: &'a AtomicU64,
}

impl<T> Counting<'_, T> {
    fn one(&self) {
        self.count.fetch_add(1, Ordering::Relaxed);
    }
}

impl Problem for Counted<'_> {
    fn components(&self) -> &'static [&'static str] {
        self.problem.components()
    }
    fn initial(&self) -> Vec<f64> {
        self.problem.initial()
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(Counting { inner: self.problem.field(), count: &self.count })
    }
    fn mechanics(&self) -> Option<Mechanics<'_>> {
        let Mechanics { system, lagrangian, constraint } = self.problem.mechanics()?;
        let lagrangian = Box::new(Counting { inner: lagrangian, count: &self.count });
        Some(Mechanics { system, lagrangian, constraint })
    }
    fn ode(&self) -> &dyn Ode {
        self.problem.ode()
    }
    fn facts(&self) -> Facts {
        self.problem.facts()
    }
}

impl<F: VectorField> VectorField for Counting<'_, F> {
    fn dim(&self) -> usize {
        self.inner.dim()
    }
    fn structure(&self) -> Structure {
        self.inner.structure()
    }
    fn mass(&self) -> Mass {
        self.inner.mass()
    }
    fn is_linear(&self) -> bool {
        self.inner.is_linear()
    }
    fn is_autonomous(&self) -> bool {
        self.inner.is_autonomous()
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.one();
        self.inner.rhs(t, v, dv);
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        self.inner.add_jacobian(t, v, scale, out);
    }
    fn linearize(&self, t: f64, v: &[f64], dv: &mut [f64], scale: f64, out: &mut Jacobian) {
        self.one();
        self.inner.linearize(t, v, dv, scale, out);
    }
    fn add_curvature(&self, t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        self.inner.add_curvature(t, v, w, scale, out);
    }
}

impl<L: Lagrangian> Lagrangian for Counting<'_, L> {
    fn dim(&self) -> usize {
        self.inner.dim()
    }
    fn structure(&self) -> Structure {
        self.inner.structure()
    }
    fn is_separable(&self) -> bool {
        self.inner.is_separable()
    }
    fn value(&self, t: f64, q: &[f64], v: &[f64]) -> f64 {
        self.inner.value(t, q, v)
    }
    fn gradient(&self, t: f64, q: &[f64], v: &[f64], dl_dq: &mut [f64], dl_dv: &mut [f64]) {
        self.one();
        self.inner.gradient(t, q, v, dl_dq, dl_dv);
    }
    fn gradient_q(&self, t: f64, q: &[f64], v: &[f64], dl_dq: &mut [f64], work: &mut [f64]) {
        self.one();
        self.inner.gradient_q(t, q, v, dl_dq, work);
    }
    fn add_hessian(&self, t: f64, q: &[f64], v: &[f64], c: HessianWeights, out: &mut Jacobian) {
        self.inner.add_hessian(t, q, v, c, out);
    }
    fn add_blocks(&self, t: f64, q: &[f64], v: &[f64], blocks: [&mut Jacobian; 4]) {
        self.inner.add_blocks(t, q, v, blocks);
    }
}

impl<L: EulerLagrange> EulerLagrange for Counting<'_, L> {
    fn residual(&self, t: f64, q: &[f64], v: &[f64], a: &[f64], out: &mut [f64]) {
        self.inner.residual(t, q, v, a, out);
    }
    fn add_residual_derivative(&self, t: f64, q: &[f64], v: &[f64], a: &[f64], c: MotionWeights, out: &mut Jacobian) {
        self.inner.add_residual_derivative(t, q, v, a, c, out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem;

    /// f by itself, f with its Jacobian, and the gradients of L are evaluations each; what comes of them is none.
    #[test]
    fn every_evaluation_of_the_equations_counts_once() {
        let problem = problem::build("henon-heiles", &[]).expect("registered");
        let (counted, state) = (Counted::new(&*problem), problem.initial());
        let field = counted.field();
        let (mut out, mut jacobian) =
            (vec![0.0; field.dim()], Jacobian::with_structure(field.dim(), &field.structure()));
        field.rhs(0.0, &state, &mut out);
        assert_eq!(counted.count(), 1);
        field.linearize(0.0, &state, &mut out, 1.0, &mut jacobian);
        assert_eq!(counted.count(), 2);
        field.add_jacobian(0.0, &state, 1.0, &mut jacobian);
        field.add_curvature(0.0, &state, &out, 1.0, &mut jacobian);
        assert_eq!(counted.count(), 2);
        let lagrangian = counted.mechanics().expect("it is mechanical").lagrangian;
        let (q, v) = state.split_at(lagrangian.dim());
        let (mut forces, mut momenta) = (q.to_vec(), v.to_vec());
        lagrangian.gradient(0.0, q, v, &mut forces, &mut momenta);
        lagrangian.gradient_q(0.0, q, v, &mut forces, &mut momenta);
        assert_eq!(counted.count(), 4);
    }
}
