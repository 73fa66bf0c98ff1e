//! The recipes of ARCHITECTURE.md for the library, followed: a discretisation and a closure of one's own, each in one place.

use lsvi::closure::{Closure, Linear, LinearClosure, PositionMomentum};
use lsvi::discrete::{DiscreteLegendre, Interval, MomentumWeights, Trapezoidal};
use lsvi::{
    AutoField, FieldFn, HessianWeights, Jacobian, Lagrangian, LeastSquares, OneStep, Scalar, SolveError, Variational,
};

/// v̇ = −v².
struct Drag;

impl FieldFn for Drag {
    fn dim(&self) -> usize {
        1
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = -v[0] * v[0];
    }
}

fn drag() -> LeastSquares<AutoField<Drag>> {
    LeastSquares::new(AutoField::new(Drag)).expect("its metric is the identity")
}

/// L_d = h L(t₀ + h, q₁, (q₁ − q₀)/h): the rectangle rule at the end of the step, with p₁ = L_v + h L_q and p₀ = L_v.
struct AtTheEnd<L>(L);

impl<L: Lagrangian> AtTheEnd<L> {
    fn velocity(at: Interval, q0: &[f64], q1: &[f64]) -> Vec<f64> {
        q0.iter().zip(q1).map(|(a, b)| (b - a) / at.h).collect()
    }
}

impl<L: Lagrangian> DiscreteLegendre for AtTheEnd<L> {
    fn dim(&self) -> usize {
        self.0.dim()
    }
    fn predict(&mut self, _: Interval, q0: &[f64], _: &[f64], x: &mut [f64]) -> Result<(), SolveError> {
        x.copy_from_slice(q0);
        Ok(())
    }
    fn momentum(&mut self, at: Interval, q0: &[f64], q1: &[f64], w: MomentumWeights, out: &mut [f64]) {
        let mut dl_dq = vec![0.0; q0.len()];
        self.0.gradient(at.start + at.h, q1, &Self::velocity(at, q0, q1), &mut dl_dq, out);
        out.iter_mut().zip(dl_dq).for_each(|(p, force)| *p = (w.alpha + w.beta) * *p + w.beta * at.h * force);
    }
    fn add_derivative(&mut self, at: Interval, q0: &[f64], q1: &[f64], w: MomentumWeights, out: &mut Jacobian) {
        let (sum, h) = (w.alpha + w.beta, at.h);
        let c = HessianWeights { qq: w.beta * h, qv: w.beta, vq: sum, vv: sum / h };
        self.0.add_hessian(at.start + h, q1, &Self::velocity(at, q0, q1), c, out);
    }
    fn add_start_derivative(&mut self, at: Interval, q0: &[f64], q1: &[f64], w: MomentumWeights, out: &mut Jacobian) {
        let c = HessianWeights { qv: -w.beta, vv: -(w.alpha + w.beta) / at.h, ..HessianWeights::default() };
        self.0.add_hessian(at.start + at.h, q1, &Self::velocity(at, q0, q1), c, out);
    }
}

/// p₁ = −p₀/10.
struct Tenth;

impl LinearClosure for Tenth {
    fn weights(&self, _h: f64) -> MomentumWeights {
        MomentumWeights { alpha: 0.1, beta: 1.0 }
    }
}

fn end<D: DiscreteLegendre, C: Closure>(discrete: D, closure: C, steps: u32) -> f64 {
    let mut method = Variational::new(discrete, closure);
    let h = f64::from(steps).recip();
    let (mut q, mut p) = ([1.0], [0.0]);
    for n in 0..steps {
        method.step(f64::from(n) * h, h, &mut q, &mut p).expect("a step");
    }
    q[0]
}

/// The order from the errors of 64 and 128 steps to t = 1, where v = ½.
fn order(end: impl Fn(u32) -> f64) -> f64 {
    let [coarse, fine] = [64, 128].map(|steps| (end(steps) - 0.5).abs());
    (coarse / fine).log2()
}

#[test]
fn a_discretisation_is_one_implementation_and_works_with_every_closure() {
    // With one node the residual vanishes there, whatever the closure: implicit Euler, v₁ = (√(1 + 4h) − 1)/2h.
    let implicit_euler = 0.5 * (5_f64.sqrt() - 1.0);
    let one_step = [
        end(AtTheEnd(drag()), Linear::METHOD_I, 1),
        end(AtTheEnd(drag()), Linear::new(0.5, 0.5).expect("weights"), 1),
        end(AtTheEnd(drag()), PositionMomentum, 1),
    ];
    for v in one_step {
        assert!((v - implicit_euler).abs() < 8.0 * f64::EPSILON, "{v}");
    }
    let order = order(|steps| end(AtTheEnd(drag()), Linear::METHOD_I, steps));
    assert!((order - 1.0).abs() < 0.1, "{order}");
}

#[test]
fn a_closure_is_one_implementation_and_works_with_every_discretisation() {
    let same = Linear::new(0.1, 1.0).expect("weights");
    assert_eq!(end(Trapezoidal::new(drag()), Tenth, 8), end(Trapezoidal::new(drag()), same, 8));
    let order = order(|steps| end(Trapezoidal::new(drag()), Tenth, steps));
    assert!((order - 2.0).abs() < 0.1, "{order}");
    assert!((end(AtTheEnd(drag()), Tenth, 128) - 0.5).abs() < 0.01);
}
