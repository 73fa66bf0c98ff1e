//! Wrong derivatives of Lagrangians, forces and constraints are named, and right ones pass.

use lsvi::nalgebra::DMatrix;
use lsvi::{
    AutoConstraint, AutoField, AutoForce, AutoLagrangian, Constraint, ConstraintFn, Derivative, DerivativeError,
    EulerLagrange, FieldFn, Force, ForceFn, Forced, HessianWeights, Jacobian, Lagrangian, LagrangianFn, LeastSquares,
    Mass, MotionWeights, Scalar, Structure, Variable, VectorField, check_constraint, check_force, check_lagrangian,
    check_motion,
};

use Variable::{A, Q, V};

/// A mass that depends on position and time, a magnetic term and a coupled potential, so that no block is zero or symmetric.
struct Coupled(usize);

impl LagrangianFn for Coupled {
    fn dim(&self) -> usize {
        self.0
    }
    fn lagrangian<T: Scalar>(&self, t: T, q: &[T], v: &[T]) -> T {
        (0..self.0).fold(T::from(0.0), |sum, i| {
            let next = (i + 1) % self.0;
            sum + v[i] * v[i] * (q[next].cos() + t.sin() + 3.0) * 0.5 + q[i] * q[i] * v[next] - (q[i] * q[next]).sin()
        })
    }
}

struct Drag(usize);

impl ForceFn for Drag {
    fn dim(&self) -> usize {
        self.0
    }
    fn force<T: Scalar>(&self, t: f64, q: &[T], v: &[T], out: &mut [T]) {
        for i in 0..self.0 {
            out[i] = -v[i] * v[(i + 1) % self.0] * q[i] + t;
        }
    }
}

struct Ellipsoid(usize);

impl ConstraintFn for Ellipsoid {
    fn dim(&self) -> usize {
        self.0
    }
    fn count(&self) -> usize {
        2
    }
    fn constraint<T: Scalar>(&self, q: &[T], out: &mut [T]) {
        out[0] = q.iter().enumerate().map(|(i, &x)| x * x * (1.0 + i as f64)).sum::<T>() - 1.0;
        out[1] = q[0] * q[1] - q[self.0 - 1];
    }
}

/// Adds to whatever is multiplied by a weight, or to values, in one place.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Flaw {
    None,
    PositionGradient,
    VelocityGradient,
    /// Of `gradient_q` alone.
    Alone,
    /// A gradient that is added to what is there.
    Added,
    Block(Derivative),
    /// The block of this place in `add_blocks`, and there alone.
    OnItsOwn(usize),
    /// The weights of two blocks exchanged.
    Weights,
    Expression,
    Outside,
    NaN,
}

struct Flawed<M>(M, Flaw);

impl<M> Flawed<M> {
    fn add(&self, of: Derivative, weight: f64, out: &mut Jacobian) {
        if self.1 == Flaw::Block(of) {
            out.add(1, 0, 0.01 * weight);
        }
    }
}

impl<M: Lagrangian> Lagrangian for Flawed<M> {
    fn dim(&self) -> usize {
        self.0.dim()
    }
    fn structure(&self) -> Structure {
        if self.1 == Flaw::Outside { Structure::Banded { lower: 0, upper: 0 } } else { self.0.structure() }
    }
    fn value(&self, t: f64, q: &[f64], v: &[f64]) -> f64 {
        if self.1 == Flaw::NaN { f64::NAN } else { self.0.value(t, q, v) }
    }
    fn gradient(&self, t: f64, q: &[f64], v: &[f64], dl_dq: &mut [f64], dl_dv: &mut [f64]) {
        let before = dl_dq[0];
        self.0.gradient(t, q, v, dl_dq, dl_dv);
        match self.1 {
            Flaw::PositionGradient => dl_dq[1] *= 1.001,
            Flaw::VelocityGradient => dl_dv[1] *= 1.001,
            Flaw::Added => dl_dq[0] += before,
            _ => {}
        }
    }
    fn gradient_q(&self, t: f64, q: &[f64], v: &[f64], dl_dq: &mut [f64], work: &mut [f64]) {
        self.0.gradient_q(t, q, v, dl_dq, work);
        if self.1 == Flaw::Alone {
            dl_dq[1] *= 1.001;
        }
    }
    fn add_hessian(&self, t: f64, q: &[f64], v: &[f64], c: HessianWeights, out: &mut Jacobian) {
        let HessianWeights { qq, qv, vq, vv } = c;
        let c = if self.1 == Flaw::Weights { HessianWeights { qv: vq, vq: qv, ..c } } else { c };
        self.0.add_hessian(t, q, v, c, out);
        self.add(Derivative::Hessian(Q, Q), qq, out);
        self.add(Derivative::Hessian(Q, V), qv, out);
        self.add(Derivative::Hessian(V, Q), vq, out);
        self.add(Derivative::Hessian(V, V), vv, out);
        // Where several blocks are added at once, and only there.
        if self.1 == Flaw::Block(Derivative::Blocks) && qq != 0.0 && vv != 0.0 {
            out.add(1, 0, 0.01);
        }
    }
    fn add_blocks(&self, t: f64, q: &[f64], v: &[f64], [qq, qv, vq, vv]: [&mut Jacobian; 4]) {
        let mut blocks = [qq, qv, vq, vv];
        self.0.add_blocks(t, q, v, blocks.each_mut().map(|block| &mut **block));
        if let Flaw::OnItsOwn(k) = self.1 {
            blocks[k].add(1, 0, 0.01);
        }
    }
}

impl<M: EulerLagrange> EulerLagrange for Flawed<M> {
    fn residual(&self, t: f64, q: &[f64], v: &[f64], a: &[f64], out: &mut [f64]) {
        self.0.residual(t, q, v, a, out);
        if self.1 == Flaw::Expression {
            out[1] *= 1.001;
        }
    }
    fn add_residual_derivative(&self, t: f64, q: &[f64], v: &[f64], a: &[f64], c: MotionWeights, out: &mut Jacobian) {
        self.0.add_residual_derivative(t, q, v, a, c, out);
        self.add(Derivative::MotionIn(Q), c.q, out);
        self.add(Derivative::MotionIn(V), c.v, out);
        self.add(Derivative::MotionIn(A), c.a, out);
    }
}

impl<M: Force> Force for Flawed<M> {
    fn dim(&self) -> usize {
        self.0.dim()
    }
    fn force(&self, t: f64, q: &[f64], v: &[f64], out: &mut [f64]) {
        self.0.force(t, q, v, out);
    }
    fn add_derivative(&self, t: f64, q: &[f64], v: &[f64], in_q: f64, in_v: f64, out: &mut Jacobian) {
        self.0.add_derivative(t, q, v, in_q, in_v, out);
        self.add(Derivative::Force(Q), in_q, out);
        self.add(Derivative::Force(V), in_v, out);
    }
}

impl<M: Constraint> Constraint for Flawed<M> {
    fn dim(&self) -> usize {
        self.0.dim()
    }
    fn count(&self) -> usize {
        self.0.count()
    }
    fn value(&self, q: &[f64], out: &mut [f64]) {
        self.0.value(q, out);
    }
    fn jacobian(&self, q: &[f64], out: &mut DMatrix<f64>) {
        self.0.jacobian(q, out);
        if self.1 == Flaw::Block(Derivative::Constraint) {
            out[(1, 0)] += 0.01;
        }
    }
    fn add_curvature(&self, q: &[f64], multipliers: &[f64], scale: f64, out: &mut Jacobian) {
        self.0.add_curvature(q, multipliers, scale, out);
        self.add(Derivative::Reaction, scale, out);
    }
}

/// What a flawed derivative is told by.
type Checker<'a> = dyn Fn(Flaw) -> Result<(), DerivativeError> + 'a;

fn values(n: usize, shift: f64) -> Vec<f64> {
    (0..n).map(|i| 0.3 + (i as f64 + shift).sin()).collect()
}

#[test]
fn derivatives_that_are_right_pass() {
    for n in [2, 3, 33] {
        for (t, scale) in [(0.7, 1.0), (0.0, 0.01)] {
            let (q, v): (Vec<f64>, Vec<f64>) =
                values(n, 0.0).iter().zip(values(n, 1.0)).map(|(q, v)| (q * scale, v * scale)).unzip();
            check_motion(&Flawed(AutoLagrangian::new(Coupled(n)), Flaw::None), t, &q, &v).expect("automatic");
            check_force(&Flawed(AutoForce::new(Drag(n)), Flaw::None), t, &q, &v).expect("automatic");
            check_constraint(&Flawed(AutoConstraint::new(Ellipsoid(n)), Flaw::None), &q).expect("automatic");
        }
    }
    // At rest, where gradients vanish.
    check_motion(&AutoLagrangian::new(Coupled(2)), 0.0, &[0.0; 2], &[0.0; 2]).expect("automatic");
}

/// v̇_i = −v_i² + v_{i+1} − 2 v_i + v_{i−1} v_{i+1}.
struct Chain(usize, Structure);

impl FieldFn for Chain {
    fn dim(&self) -> usize {
        self.0
    }
    fn structure(&self) -> Structure {
        self.1.clone()
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        let at = |i: usize| v.get(i).copied().unwrap_or(T::from(0.0));
        for i in 0..v.len() {
            dv[i] = at(i.wrapping_sub(1)) * at(i + 1) + at(i + 1) - (v[i] + 2.0) * v[i];
        }
    }
}

/// With a mass for each component.
struct Massive(AutoField<Chain>, Vec<f64>);

impl VectorField for Massive {
    fn dim(&self) -> usize {
        self.0.dim()
    }
    fn structure(&self) -> Structure {
        self.0.structure()
    }
    fn mass(&self) -> Mass {
        Mass::Diagonal(self.1.clone())
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.0.rhs(t, v, dv);
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        self.0.add_jacobian(t, v, scale, out);
    }
    fn add_curvature(&self, t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        self.0.add_curvature(t, v, w, scale, out);
    }
}

/// A force belongs to the blocks of ∂L/∂q, whose derivatives it makes no symmetric matrix.
#[test]
fn the_blocks_of_a_forced_lagrangian_are_what_is_added_to_one_matrix() {
    let forced = Forced::new(AutoLagrangian::new(Coupled(3)), AutoForce::new(Drag(3))).expect("of one size");
    let (q, v) = (values(3, 0.0), values(3, 1.0));
    let mut blocks: [Jacobian; 4] = std::array::from_fn(|_| Jacobian::zeros(3));
    forced.add_blocks(0.7, &q, &v, blocks.each_mut());
    for (k, block) in blocks.iter().enumerate() {
        let weight = |i: usize| if i == k { 1.0 } else { 0.0 };
        let mut alone = Jacobian::zeros(3);
        let c = HessianWeights { qq: weight(0), qv: weight(1), vq: weight(2), vv: weight(3) };
        forced.add_hessian(0.7, &q, &v, c, &mut alone);
        assert!(alone.to_dense().amax() > 0.1);
        approx::assert_relative_eq!(block.to_dense(), alone.to_dense(), epsilon = 1e-14);
    }
}

#[test]
fn the_second_derivatives_of_least_squares_are_right_in_every_structure_and_metric() {
    for n in [1, 2, 6] {
        let (v, rate) = (values(n, 0.0), values(n, 1.0));
        let sparse = Structure::sparse(n, (1..n).flat_map(|i| [(i - 1, i), (i, i - 1)])).expect("inside");
        for structure in [Structure::Dense, Structure::Banded { lower: 1, upper: 1 }, sparse] {
            let field = || AutoField::new(Chain(n, structure.clone()));
            let masses: Vec<f64> = (0..n).map(|i| 1.0 + i as f64).collect();
            let weighed = Massive(field(), masses);
            check_lagrangian(&LeastSquares::new(field()).expect("usable"), 0.5, &v, &rate).expect("exact");
            check_lagrangian(&LeastSquares::new(weighed).expect("usable"), 0.5, &v, &rate).expect("exact");
            let metric = DMatrix::from_fn(n, n, |i, j| if i == j { 3.0 } else { 0.1 });
            let measured = LeastSquares::new(field()).and_then(|l| l.with_metric(metric)).expect("a metric");
            check_lagrangian(&measured, 0.5, &v, &rate).expect("exact");
        }
    }
}

#[test]
fn a_wrong_derivative_is_named() {
    let (q, v) = (values(3, 0.0), values(3, 1.0));
    let motion = |flaw| check_motion(&Flawed(AutoLagrangian::new(Coupled(3)), flaw), 0.7, &q, &v);
    let force = |flaw| check_force(&Flawed(AutoForce::new(Drag(3)), flaw), 0.7, &q, &v);
    let constraint = |flaw| check_constraint(&Flawed(AutoConstraint::new(Ellipsoid(3)), flaw), &q);
    for (flaw, expected) in [
        (Flaw::PositionGradient, Derivative::Gradient(Q)),
        (Flaw::VelocityGradient, Derivative::Gradient(V)),
        (Flaw::Alone, Derivative::Gradient(Q)),
        (Flaw::Weights, Derivative::Hessian(Q, V)),
        (Flaw::Expression, Derivative::Motion),
    ] {
        let error = motion(flaw).expect_err("flawed");
        assert!(matches!(error, DerivativeError::Differs { of, .. } if of == expected), "{flaw:?}: {error}");
    }
    for (k, (row, column)) in [(Q, Q), (Q, V), (V, Q), (V, V)].into_iter().enumerate() {
        let error = motion(Flaw::OnItsOwn(k)).expect_err("flawed");
        let expected = Derivative::Hessian(row, column);
        assert!(matches!(error, DerivativeError::Differs { of, .. } if of == expected), "{k}: {error}");
    }
    let blocks: [(Derivative, &Checker<'_>); 12] = [
        (Derivative::Hessian(Q, Q), &motion),
        (Derivative::Hessian(Q, V), &motion),
        (Derivative::Hessian(V, Q), &motion),
        (Derivative::Hessian(V, V), &motion),
        (Derivative::Blocks, &motion),
        (Derivative::MotionIn(Q), &motion),
        (Derivative::MotionIn(V), &motion),
        (Derivative::MotionIn(A), &motion),
        (Derivative::Force(Q), &force),
        (Derivative::Force(V), &force),
        (Derivative::Constraint, &constraint),
        (Derivative::Reaction, &constraint),
    ];
    for (of, check) in blocks {
        let error = check(Flaw::Block(of)).expect_err("flawed");
        let DerivativeError::Differs { of: found, place, stated, found: right, .. } = &error else {
            panic!("{of:?}: {error}")
        };
        assert_eq!(*found, of, "{error}");
        if of == Derivative::Blocks {
            continue;
        }
        assert_eq!((place.row, place.column), (Some(1), Some(0)), "{error}");
        assert!((stated - right - 0.01).abs() < 1e-6, "{error}");
    }
    assert!(matches!(motion(Flaw::Added), Err(DerivativeError::NotWritten { row: 0, .. })));
    assert!(matches!(motion(Flaw::Outside), Err(DerivativeError::Outside { .. })));
    assert!(matches!(motion(Flaw::NaN), Err(DerivativeError::NonFinite { what: "L", .. })));
}

#[test]
fn vectors_of_another_length_are_refused() {
    let l = AutoLagrangian::new(Coupled(2));
    assert!(matches!(check_motion(&l, 0.0, &[1.0; 3], &[1.0; 2]), Err(DerivativeError::Input(_))));
    assert!(matches!(check_lagrangian(&l, 0.0, &[1.0; 2], &[1.0]), Err(DerivativeError::Input(_))));
    assert!(matches!(
        check_force(&AutoForce::new(Drag(2)), f64::NAN, &[1.0; 2], &[1.0; 2]),
        Err(DerivativeError::Input(_))
    ));
    assert!(matches!(check_constraint(&AutoConstraint::new(Ellipsoid(2)), &[]), Err(DerivativeError::Input(_))));
}

/// L = size (½ v₀² + ½ v₁² + v₀ q₁ − ½ q₀² − ½ q₁²), of which one statement is wrong by a part of itself.
struct Sized {
    size: f64,
    wrong: Derivative,
    part: f64,
}

impl Lagrangian for Sized {
    fn dim(&self) -> usize {
        2
    }
    fn value(&self, _t: f64, q: &[f64], v: &[f64]) -> f64 {
        self.size * ((v[0] * v[0] + v[1] * v[1] - q[0] * q[0] - q[1] * q[1]) / 2.0 + v[0] * q[1])
    }
    fn gradient(&self, _t: f64, q: &[f64], v: &[f64], dl_dq: &mut [f64], dl_dv: &mut [f64]) {
        dl_dq.copy_from_slice(&[-self.size * q[0], self.size * (v[0] - q[1])]);
        dl_dv.copy_from_slice(&[self.size * (v[0] + q[1]), self.size * v[1]]);
    }
    /// ∂L/∂q alone.
    fn gradient_q(&self, t: f64, q: &[f64], v: &[f64], dl_dq: &mut [f64], work: &mut [f64]) {
        self.gradient(t, q, v, dl_dq, work);
        if self.wrong == Derivative::Gradient(Q) {
            dl_dq[1] *= 1.0 + self.part;
        }
    }
    fn add_hessian(&self, _t: f64, _q: &[f64], _v: &[f64], c: HessianWeights, out: &mut Jacobian) {
        // Where the mixed blocks are added at once, and only there.
        let is_wrong = self.wrong == Derivative::Blocks && c.qv != 0.0 && c.vq != 0.0;
        let part = if is_wrong { 1.0 + self.part } else { 1.0 };
        (0..2).for_each(|i| out.add(i, i, self.size * (c.vv - c.qq)));
        out.add(1, 0, self.size * c.qv * part);
        out.add(0, 1, self.size * c.vq);
    }
}

#[test]
fn statements_of_mechanics_agree_in_nine_digits_whatever_their_size() {
    for wrong in [Derivative::Gradient(Q), Derivative::Blocks] {
        for size in [1e-8, 1.0, 1e8] {
            let check = |part| check_lagrangian(&Sized { size, wrong, part }, 0.0, &[0.3, 0.2], &[0.7, 0.5]);
            let error = check(1e-9).expect_err("wrong in the ninth digit");
            assert!(
                matches!(error, DerivativeError::Differs { of, .. } if of == wrong),
                "{wrong} of size {size:e}: {error}"
            );
            check(1e-11).expect("within rounding of long sums");
        }
    }
}

/// ½ m v² − ½ k q², m = k = 1, with an Euler–Lagrange expression −k q − m a that has others.
struct Spring {
    k: f64,
    m: f64,
}

impl Lagrangian for Spring {
    fn dim(&self) -> usize {
        1
    }
    fn value(&self, _t: f64, q: &[f64], v: &[f64]) -> f64 {
        (v[0] * v[0] - q[0] * q[0]) / 2.0
    }
    fn gradient(&self, _t: f64, q: &[f64], v: &[f64], dl_dq: &mut [f64], dl_dv: &mut [f64]) {
        (dl_dq[0], dl_dv[0]) = (-q[0], v[0]);
    }
    fn add_hessian(&self, _t: f64, _q: &[f64], _v: &[f64], c: HessianWeights, out: &mut Jacobian) {
        out.add(0, 0, c.vv - c.qq);
    }
}

impl EulerLagrange for Spring {
    fn residual(&self, _t: f64, q: &[f64], _v: &[f64], a: &[f64], out: &mut [f64]) {
        out[0] = -self.k * q[0] - self.m * a[0];
    }
    fn add_residual_derivative(
        &self,
        _t: f64,
        _q: &[f64],
        _v: &[f64],
        _a: &[f64],
        c: MotionWeights,
        out: &mut Jacobian,
    ) {
        out.add(0, 0, -self.k * c.q - self.m * c.a);
    }
}

/// Accelerations are of the size of the state, so that neither inertia nor the force is lost beside the other.
#[test]
fn a_wrong_expression_of_motion_is_named_at_every_size_and_at_rest() {
    for size in [0.0, 1e-8, 1.0, 1e8] {
        let check = |k, m| check_motion(&Spring { k, m }, 0.0, &[size], &[0.5 * size]);
        check(1.0, 1.0).unwrap_or_else(|error| panic!("{size:e}: {error}"));
        for (k, m) in [(1.0, 1.001), (1.001, 1.0)] {
            if size == 0.0 && k != 1.0 {
                continue; // No force acts at rest.
            }
            let error = check(k, m).expect_err("another motion");
            assert!(
                matches!(error, DerivativeError::Differs { of: Derivative::Motion, .. }),
                "size {size:e}, k = {k}, m = {m}: {error}"
            );
        }
    }
}
