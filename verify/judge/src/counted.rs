//! A problem that counts how often its equations are evaluated, whoever steps them: f, or where a method takes them the first
//! derivatives of the Lagrangian, which are the forces.

use std::sync::atomic::{AtomicU64, Ordering};

use lsvi::{EulerLagrange, HessianWeights, Jacobian, Lagrangian, Mass, MotionWeights, Structure, VectorField};

use experiments::problem::{Facts, Mechanics, Problem};
use experiments::reference::Ode;

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
    use experiments::problem;

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

    /// v̇ = M⁻¹v and L = 0, with nothing said of them that is said of any.
    struct Known(bool);

    fn lower() -> Structure {
        Structure::Banded { lower: 1, upper: 0 }
    }

    impl VectorField for Known {
        fn dim(&self) -> usize {
            2
        }
        fn structure(&self) -> Structure {
            lower()
        }
        fn mass(&self) -> Mass {
            Mass::Diagonal(vec![2.0, 3.0])
        }
        fn is_linear(&self) -> bool {
            self.0
        }
        fn is_autonomous(&self) -> bool {
            self.0
        }
        fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
            dv.copy_from_slice(v);
        }
        fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
            (0..2).for_each(|k| out.add(k, k, scale));
        }
    }

    impl Lagrangian for Known {
        fn dim(&self) -> usize {
            2
        }
        fn structure(&self) -> Structure {
            lower()
        }
        fn value(&self, _t: f64, _q: &[f64], _v: &[f64]) -> f64 {
            0.0
        }
        fn gradient(&self, _t: f64, _q: &[f64], _v: &[f64], dl_dq: &mut [f64], dl_dv: &mut [f64]) {
            dl_dq.fill(0.0);
            dl_dv.fill(0.0);
        }
        fn add_hessian(&self, _t: f64, _q: &[f64], _v: &[f64], _c: HessianWeights, _out: &mut Jacobian) {}
    }

    #[test]
    fn what_is_said_of_a_field_is_said_of_a_counted_one() {
        for yes in [true, false] {
            let (inner, count) = (Known(yes), AtomicU64::new(0));
            let field = Counting { inner, count: &count };
            assert_eq!((VectorField::dim(&field), VectorField::structure(&field)), (2, lower()));
            assert!(matches!(field.mass(), Mass::Diagonal(entries) if entries == [2.0, 3.0]));
            assert_eq!((field.is_linear(), field.is_autonomous()), (yes, yes));
            assert_eq!((Lagrangian::dim(&field), Lagrangian::structure(&field)), (2, lower()));
        }
    }

    /// Of a motion that is no solution, so that nothing vanishes.
    #[test]
    fn derivatives_of_a_counted_problem_are_those_of_the_problem() {
        for (name, is_separable) in [("henon-heiles", true), ("double-pendulum", false)] {
            let problem = problem::build(name, &[]).expect("registered");
            let counted = Counted::new(&*problem);
            let state = [0.3, -0.2, 0.5, 0.4];
            let curvature = |problem: &dyn Problem| {
                let field = problem.field();
                let mut out = Jacobian::with_structure(4, &field.structure());
                field.add_curvature(0.0, &state, &[1.0, 2.0, 3.0, 4.0], 1.0, &mut out);
                out
            };
            assert_eq!(curvature(&counted), curvature(&*problem), "{name}");
            assert_ne!(curvature(&counted), Jacobian::with_structure(4, &problem.field().structure()), "{name}");
            let of_lagrangian = |problem: &dyn Problem| {
                let lagrangian = problem.mechanics().expect("it is mechanical").lagrangian;
                assert_eq!(lagrangian.is_separable(), is_separable, "{name}");
                let (q, v) = state.split_at(2);
                let none = || Jacobian::with_structure(2, &lagrangian.structure());
                let mut blocks = [none(), none(), none(), none()];
                lagrangian.add_blocks(0.0, q, v, blocks.each_mut());
                let (mut residual, mut derivative) = (vec![0.0; 2], none());
                lagrangian.residual(0.0, q, v, &[0.7, 0.6], &mut residual);
                let weights = MotionWeights { q: 1.0, v: 2.0, a: 3.0 };
                lagrangian.add_residual_derivative(0.0, q, v, &[0.7, 0.6], weights, &mut derivative);
                assert!(derivative != none() && blocks[0] != none() && residual[0] != 0.0, "{name}");
                (blocks, residual, derivative)
            };
            assert_eq!(of_lagrangian(&counted), of_lagrangian(&*problem), "{name}");
        }
    }
}
