//! Integrators of Lagrangian mechanics against closed forms, exact derivatives, each other and their order.

use crate::separable::{Separable, Swaying};
use crate::systems::{AnyLagrangian, lagrangian_of};
use crate::systems::{ChargedParticle, Damping, Degenerate, DoublePendulum, Driven, Oscillator, Pendulum};
use approx::assert_abs_diff_eq;
use lsvi::discrete::{
    BrokenLine, DiscreteLagrangian, DiscreteLegendre, Galerkin, Interval, KongYangCircle, Midpoint, MomentumWeights,
    PathFitted, Trapezoidal,
};
use lsvi::quadrature::{NodeFamily, Quadrature};
use lsvi::{
    AutoForce, EulerLagrange, Forced, InputError, Integrator, Jacobian, Lagrangian, LagrangianFn, MotionWeights,
    NodeError, OneStep, Scalar, SolveError, State, StepError, SystemError, Trajectory, TwoStep, position_momentum,
};
use nalgebra::{DMatrix, DVector};

const EPS: f64 = f64::EPSILON;

/// The derivative of `f` at `x` by central differences of step e: error e²/6 f‴ + ε f/e.
pub(crate) fn differences(f: &mut dyn FnMut(&[f64]) -> Vec<f64>, x: &[f64], e: f64) -> DMatrix<f64> {
    let columns: Vec<DVector<f64>> = (0..x.len())
        .map(|j| {
            let mut at = |shift: f64| {
                let mut x = x.to_vec();
                x[j] += shift;
                DVector::from_vec(f(&x))
            };
            (at(e) - at(-e)) / (2.0 * e)
        })
        .collect();
    DMatrix::from_columns(&columns)
}

fn assert_close(a: &DMatrix<f64>, b: &DMatrix<f64>, tolerance: f64, what: &str) {
    let scale = b.amax().max(1.0);
    assert!((a - b).amax() <= tolerance * scale, "{what}: {a} is not {b}");
}

pub(crate) type Named<'a> = (String, Box<dyn DiscreteLegendre + 'a>);

/// Every discretisation in this crate of one Lagrangian.
pub(crate) fn discretisations<L: EulerLagrange>(l: &L) -> Vec<Named<'_>> {
    let mut all: Vec<Named<'_>> =
        vec![("trapezoidal".into(), Box::new(Trapezoidal::new(l))), ("midpoint".into(), Box::new(Midpoint::new(l)))];
    for m in 2..=4 {
        let nodes = NodeFamily::Equispaced.interior(m).expect("m ≥ 2");
        all.push((format!("path-fitted({m})"), Box::new(PathFitted::new(l, &nodes).expect("nodes"))));
        all.push((format!("path-fitted-bernstein({m})"), Box::new(PathFitted::bernstein(l, &nodes).expect("nodes"))));
    }
    for s in 1..=4 {
        all.push((format!("galerkin-gauss({s})"), Box::new(Galerkin::gauss(l, s).expect("s ≥ 1"))));
        all.push((format!("galerkin-lobatto({s})"), Box::new(Galerkin::lobatto(l, s).expect("s ≥ 1"))));
        let radau = Quadrature::radau(s + 1).expect("n ≥ 1");
        all.push((format!("galerkin-radau({s})"), Box::new(Galerkin::new(l, s, &radau).expect("s ≥ 1"))));
    }
    if l.is_separable() {
        let lines = [
            ("broken line of three pieces", BrokenLine::new(l, &[0.7, -0.4, 0.7], &[0.2, 0.5, 0.1, 0.2])),
            ("Blanes and Moan", BrokenLine::blanes_moan(l)),
        ];
        all.extend(lines.map(|(name, line)| (name.into(), Box::new(line.expect("separable")) as Box<_>)));
    }
    all
}

#[test]
fn euler_lagrange_expression_is_the_defect_of_motion() {
    let (t, q, v, a) = (0.3, [0.7, -0.4], [0.5, 0.9], [-1.1, 0.2]);
    let l = lagrangian_of(Driven);
    let gradient = |t: f64, q: &[f64], v: &[f64]| {
        let (mut lq, mut lv) = (vec![0.0; 2], vec![0.0; 2]);
        l.gradient(t, q, v, &mut lq, &mut lv);
        (lq, lv)
    };
    // d/dt ∂L/∂v along q(t + e) = q + e v + e² a/2.
    let momentum = |e: f64| {
        let qe: Vec<f64> = (0..2).map(|i| q[i] + e * v[i] + 0.5 * e * e * a[i]).collect();
        let ve: Vec<f64> = (0..2).map(|i| v[i] + e * a[i]).collect();
        gradient(t + e, &qe, &ve).1
    };
    let rate = differences(&mut |e| momentum(e[0]), &[0.0], 1e-5);
    let mut expression = vec![0.0; 2];
    l.residual(t, &q, &v, &a, &mut expression);
    for i in 0..2 {
        // Differences with e = 1e-5: e² + ε/e, times third derivatives of order 10.
        assert_abs_diff_eq!(expression[i], gradient(t, &q, &v).0[i] - rate[i], epsilon = 1e-8);
    }
    let value = |q: &[f64], v: &[f64], a: &[f64]| {
        let mut out = vec![0.0; 2];
        l.residual(t, q, v, a, &mut out);
        out
    };
    let exact = |c: MotionWeights| {
        let mut out = Jacobian::zeros(2);
        l.add_residual_derivative(t, &q, &v, &a, c, &mut out);
        out.to_dense()
    };
    let none = MotionWeights::default();
    let in_q = differences(&mut |q| value(q, &v, &a), &q, 1e-5);
    assert_close(&exact(MotionWeights { q: 1.0, ..none }), &in_q, 1e-8, "E_q");
    let in_v = differences(&mut |v| value(&q, v, &a), &v, 1e-5);
    assert_close(&exact(MotionWeights { v: 1.0, ..none }), &in_v, 1e-8, "E_v");
    let in_a = differences(&mut |a| value(&q, &v, a), &a, 1e-5);
    assert_close(&exact(MotionWeights { a: 1.0, ..none }), &in_a, 1e-8, "E_a");
    let all = 0.5 * in_q - 2.0 * in_v + 3.0 * in_a;
    assert_close(&exact(MotionWeights { q: 0.5, v: -2.0, a: 3.0 }), &all, 1e-8, "combination");
}

#[test]
fn derivatives_of_every_discretisation_are_exact() {
    let driven = lagrangian_of(Driven);
    let damped = Forced::new(lagrangian_of(Driven), AutoForce::new(Damping { dim: 2, rate: 0.7 })).expect("2");
    let mut all = discretisations(&driven);
    all.extend(discretisations(&damped));
    all.push(("kong-yang-circle".into(), Box::new(KongYangCircle::new(2))));
    for (name, mut d) in all {
        let at = Interval { start: 0.3, h: 0.4 };
        let w = MomentumWeights { alpha: 0.7, beta: -1.3 };
        let q0 = [0.7, -0.4];
        let unknowns = d.interior() + d.dim();
        let x: Vec<f64> = (0..unknowns).map(|i| q0[i % 2] + 0.1 * (1.7 * i as f64).sin()).collect();
        let mut out = vec![0.0; unknowns];
        let mut equations = |q0: &[f64], x: &[f64]| {
            d.equations(at, q0, x, w, &mut out);
            out.clone()
        };
        let in_x = differences(&mut |x| equations(&q0, x), &x, 1e-5);
        let in_q0 = differences(&mut |q0| equations(q0, &x), &q0, 1e-5);
        let mut exact = Jacobian::zeros(unknowns);
        d.add_derivative(at, &q0, &x, w, &mut exact);
        // Velocities of these paths are of order 1, their differences at 1e-5 good to 1e-8 of the largest entry.
        assert_close(&exact.to_dense(), &in_x, 1e-8, &name);
        let mut exact = Jacobian::zeros(unknowns);
        d.add_start_derivative(at, &q0, &x, w, &mut exact);
        assert_close(&exact.to_dense().columns(0, 2).into_owned(), &in_q0, 1e-8, &name);
    }
}

/// R in x_{k+1} = R x_k − x_{k−1} and the determinant of the one-step map (q, p) on the oscillator.
fn recurrence(method: &mut dyn OneStep, tau: f64) -> (f64, f64) {
    let mut column = |q: f64, p: f64| {
        let (mut q, mut p) = ([q], [p]);
        method.step(0.0, tau, &mut q, &mut p).expect("linear");
        (q[0], p[0])
    };
    let (a, b) = (column(1.0, 0.0), column(0.0, 1.0));
    (a.0 + b.1, a.0 * b.1 - a.1 * b.0)
}

#[test]
fn oscillator_recurrences_are_those_of_the_paper() {
    let l = lagrangian_of(Oscillator);
    let fitted = |m, family| Box::new(position_momentum(PathFitted::on(&l, family, m).expect("m ≥ 2")));
    type Closed = fn(f64) -> f64;
    // s = τ²; where the recurrence is stable, |R| < 2.
    let cases: [(Box<dyn OneStep>, Closed); 8] = [
        (fitted(2, NodeFamily::Equispaced), |s| (16.0 - 6.0 * s) / (8.0 + s)),
        (Box::new(position_momentum(Midpoint::new(&l))), |s| (8.0 - 2.0 * s) / (4.0 + s)),
        (fitted(3, NodeFamily::Equispaced), |s| (22.0 * s * s - 468.0 * s + 972.0) / (2.0 * s * s + 9.0 * s + 486.0)),
        (fitted(4, NodeFamily::Equispaced), |s| {
            (-150.0 * s.powi(3) + 9616.0 * s * s - 142848.0 * s + 294912.0)
                / (9.0 * s.powi(3) - 184.0 * s * s + 2304.0 * s + 147456.0)
        }),
        (fitted(3, NodeFamily::Gauss), |s| (14.0 * s * s - 384.0 * s + 864.0) / (s * s + 24.0 * s + 432.0)),
        (fitted(4, NodeFamily::Gauss), |s| {
            (-26.0 * s.powi(3) + 2736.0 * s * s - 53280.0 * s + 115200.0)
                / (s.powi(3) + 48.0 * s * s + 2160.0 * s + 57600.0)
        }),
        (Box::new(position_momentum(Trapezoidal::new(&l))), |s| 2.0 - s),
        (Box::new(position_momentum(Galerkin::gauss(&l, 1).expect("s ≥ 1"))), |s| (8.0 - 2.0 * s) / (4.0 + s)),
    ];
    for (mut method, closed) in cases {
        for tau in (1..=40).map(|i| 0.1 * f64::from(i)) {
            let (trace, determinant) = recurrence(&mut *method, tau);
            let exact = closed(tau * tau);
            // The step equations lose up to m⁴/τ² of differentiation twice, with m ≤ 4 and τ ≥ 0.1, times a few ε.
            let epsilon = 4.0 * EPS * (1.0 + 256.0 / (tau * tau)) * (1.0 + exact.abs());
            assert_abs_diff_eq!(trace, exact, epsilon = epsilon);
            assert_abs_diff_eq!(determinant, 1.0, epsilon = epsilon * (1.0 + exact.abs()));
        }
    }
}

#[test]
fn bernstein_and_lagrange_paths_are_one_method() {
    for m in 2..=5 {
        let nodes = NodeFamily::Equispaced.interior(m).expect("m ≥ 2");
        let l = lagrangian_of(DoublePendulum);
        let mut lagrange = position_momentum(PathFitted::new(&l, &nodes).expect("nodes"));
        let mut bernstein = position_momentum(PathFitted::bernstein(&l, &nodes).expect("nodes"));
        let (mut a, mut b) = (([1.0, 2.0], [0.3, -0.2]), ([1.0, 2.0], [0.3, -0.2]));
        for k in 0..5 {
            lagrange.step(0.1 * f64::from(k), 0.1, &mut a.0, &mut a.1).expect("short step");
            bernstein.step(0.1 * f64::from(k), 0.1, &mut b.0, &mut b.1).expect("short step");
        }
        for i in 0..2 {
            // Rounding of x, ε, is magnified by m²/h in a velocity; a few steps add up.
            assert_abs_diff_eq!(a.0[i], b.0[i], epsilon = 1e3 * EPS);
            assert_abs_diff_eq!(a.1[i], b.1[i], epsilon = 5e3 * EPS);
        }
    }
}

#[test]
fn galerkin_of_degree_1_is_midpoint_and_trapezoidal() {
    let l = lagrangian_of(Driven);
    let pairs: [(Box<dyn OneStep>, Box<dyn OneStep>); 2] = [
        (
            Box::new(position_momentum(Galerkin::gauss(&l, 1).expect("s = 1"))),
            Box::new(position_momentum(Midpoint::new(&l))),
        ),
        (
            Box::new(position_momentum(Galerkin::lobatto(&l, 1).expect("s = 1"))),
            Box::new(position_momentum(Trapezoidal::new(&l))),
        ),
    ];
    for (mut one, mut other) in pairs {
        let (mut a, mut b) = (([0.7, -0.4], [0.2, 0.5]), ([0.7, -0.4], [0.2, 0.5]));
        one.step(0.2, 0.1, &mut a.0, &mut a.1).expect("short step");
        other.step(0.2, 0.1, &mut b.0, &mut b.1).expect("short step");
        for i in 0..2 {
            assert_abs_diff_eq!(a.0[i], b.0[i], epsilon = 16.0 * EPS);
            assert_abs_diff_eq!(a.1[i], b.1[i], epsilon = 64.0 * EPS);
        }
    }
}

/// The momenta −D₁L_d and D₂L_d of a step by differences of its action with the path fixed to be stationary, of Lagrangians that depend on
/// time.
#[test]
fn momenta_are_the_derivatives_of_every_action() {
    let (l, separable) = (lagrangian_of(Driven), lagrangian_of(Separable(Swaying)));
    let line = BrokenLine::new(&separable, &[0.7, -0.4, 0.7], &[0.2, 0.5, 0.1, 0.2]).expect("separable");
    let mut all: Vec<Box<dyn DiscreteLagrangian + '_>> =
        vec![Box::new(Trapezoidal::new(&l)), Box::new(Midpoint::new(&l)), Box::new(line)];
    for quadrature in [Quadrature::gauss(3), Quadrature::lobatto(4), Quadrature::radau(3), Quadrature::gauss(4)] {
        all.push(Box::new(Galerkin::new(&l, 3, &quadrature.expect("nodes")).expect("s = 3")));
    }
    for (k, discrete) in all.into_iter().enumerate() {
        let mut method = position_momentum(discrete);
        let at = Interval { start: 0.3, h: 0.2 };
        let (q0, p0) = ([0.7, -0.4], [0.2, 0.5]);
        let (mut q1, mut p1) = (q0, p0);
        let x = {
            method.step(at.start, at.h, &mut q1, &mut p1).expect("short step");
            method.unknowns().to_vec()
        };
        // Where the interior is stationary, moving q₁ alone has the effect of D₂L_d.
        let d = method.discrete_mut();
        let mut action = |q0: &[f64], x: &[f64]| vec![d.action(at, q0, x)];
        let in_x = differences(&mut |x| action(&q0, x), &x, 1e-5);
        let in_q0 = differences(&mut |q0| action(q0, &x), &q0, 1e-5);
        let found = [-in_q0, in_x].map(|row| row.iter().copied().collect::<Vec<_>>()).concat();
        let expected = [&p0[..], &vec![0.0; x.len() - 2], &p1].concat();
        // e²/6 times third derivatives of h L, h (5/h)³ L_vvv where φ′ ≤ 5, and ε/e.
        let is_near = found.iter().zip(&expected).all(|(a, b)| (a - b).abs() <= 1e-7);
        assert!(is_near, "{k}: {found:?} for {expected:?}");
    }
}

/// ‖DΦᵀ Ω DΦ − Ω‖ of one step.
pub(crate) fn symplecticity_defect<D: DiscreteLegendre>(discrete: D, h: f64, q: &[f64], p: &[f64]) -> f64 {
    let mut method = position_momentum(discrete);
    let n = q.len();
    let tangent = method.step_with_tangent(0.0, h, &mut q.to_vec(), &mut p.to_vec()).expect("short step");
    let mut omega = DMatrix::zeros(2 * n, 2 * n);
    for i in 0..n {
        omega[(i, n + i)] = 1.0;
        omega[(n + i, i)] = -1.0;
    }
    (tangent.transpose() * &omega * &tangent - &omega).amax()
}

#[test]
fn tangents_are_the_derivatives_of_steps() {
    let l = lagrangian_of(ChargedParticle);
    for (name, discrete) in discretisations(&l) {
        let mut method = position_momentum(discrete);
        let state = [0.6, -0.3, 0.4, 0.8];
        let mut step = |s: &[f64]| {
            let (mut q, mut p) = (s[..2].to_vec(), s[2..].to_vec());
            method.step(0.0, 0.3, &mut q, &mut p).expect("short step");
            [q, p].concat()
        };
        let expected = differences(&mut step, &state, 1e-5);
        let (mut q, mut p) = (state[..2].to_vec(), state[2..].to_vec());
        let tangent = method.step_with_tangent(0.0, 0.3, &mut q, &mut p).expect("short step");
        assert_close(&tangent, &expected, 1e-8, &name);
    }
}

/// Rounding of a tangent: differentiation m²/h ≤ 200 against entries of order 1, both ways.
const SYMPLECTIC: f64 = 1e4 * EPS;

#[test]
fn galerkin_is_symplectic_for_every_lagrangian() {
    let (particle, double) = (lagrangian_of(ChargedParticle), lagrangian_of(DoublePendulum));
    for s in 1..=4 {
        for h in [0.1, 0.2] {
            let (q, p) = ([0.6, -0.3], [0.4, 0.8]);
            for defect in [
                symplecticity_defect(Galerkin::gauss(&particle, s).expect("s ≥ 1"), h, &q, &p),
                symplecticity_defect(Galerkin::lobatto(&particle, s).expect("s ≥ 1"), h, &q, &p),
                symplecticity_defect(Galerkin::gauss(&double, s).expect("s ≥ 1"), h, &q, &p),
                symplecticity_defect(Galerkin::lobatto(&double, s).expect("s ≥ 1"), h, &q, &p),
            ] {
                assert!(defect < SYMPLECTIC, "s = {s}, h = {h}: {defect:e}");
            }
        }
    }
}

#[test]
fn path_fitting_is_symplectic_for_separable_lagrangians_on_gauss_nodes_only() {
    let l = lagrangian_of(crate::systems::HenonHeiles);
    let (q, p) = ([0.1, -0.2], [0.4, 0.3]);
    for m in 2..=5 {
        let defect = symplecticity_defect(PathFitted::on(&l, NodeFamily::Gauss, m).expect("m ≥ 2"), 0.2, &q, &p);
        assert!(defect < SYMPLECTIC, "m = {m}: {defect:e}");
    }
    // Others have a defect of the size of their local error, here far above rounding.
    for family in [NodeFamily::Equispaced, NodeFamily::Lobatto, NodeFamily::Chebyshev] {
        for m in 3..=4 {
            let defect = symplecticity_defect(PathFitted::on(&l, family, m).expect("m ≥ 2"), 0.4, &q, &p);
            assert!(defect > 100.0 * SYMPLECTIC, "{family:?}, m = {m}: {defect:e}");
        }
    }
}

/// ½|v|² + B (q₁v₂ − q₂v₁)/2 − k|q|²/2 with B = 1.3.
struct UniformField {
    stiffness: f64,
}

impl LagrangianFn for UniformField {
    fn dim(&self) -> usize {
        2
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        (v[0] * v[0] + v[1] * v[1] + (q[0] * v[1] - q[1] * v[0]) * 1.3 - (q[0] * q[0] + q[1] * q[1]) * self.stiffness)
            * 0.5
    }
}

#[test]
fn path_fitting_is_symplectic_in_a_uniform_magnetic_field_without_a_potential() {
    for (stiffness, is_symplectic) in [(0.0, true), (1.0, false)] {
        let l = lagrangian_of(UniformField { stiffness });
        for m in 2..=3 {
            let path = PathFitted::on(&l, NodeFamily::Gauss, m).expect("m ≥ 2");
            let defect = symplecticity_defect(path, 0.4, &[0.6, -0.3], &[0.4, 0.8]);
            assert_eq!(defect < SYMPLECTIC, is_symplectic, "m = {m}: {defect:e}");
        }
    }
}

#[test]
fn path_fitting_is_not_symplectic_in_a_magnetic_field_that_is_not_uniform() {
    let l = lagrangian_of(ChargedParticle);
    let (q, p) = ([0.6, -0.3], [0.4, 0.8]);
    for (m, exponent) in [(2, 3.0), (3, 5.0), (4, 7.0)] {
        let defect = |h| symplecticity_defect(PathFitted::on(&l, NodeFamily::Gauss, m).expect("m ≥ 2"), h, &q, &p);
        let slope = (defect(0.4) / defect(0.2)).log2();
        assert!((slope - exponent).abs() < 0.3, "m = {m}: the defect falls like h^{slope:.2}");
    }
}

/// Order between steps h and h/2 at t = 2 from 2 rad at rest, against a Galerkin solution of order 16.
fn order<D: DiscreteLegendre>(mut discrete: impl FnMut() -> D, h: f64, initial: &State, truth: &[f64]) -> f64 {
    let mut error = |h: f64| {
        let trajectory = Trajectory::new(position_momentum(discrete()), initial.clone(), h, 2.0).expect("valid");
        let end = trajectory.observe(|_| {}).expect("solvable");
        let difference = end.q.iter().chain(&end.p).zip(truth).map(|(a, b)| (a - b).abs());
        difference.max_by(f64::total_cmp).expect("entries")
    };
    (error(h) / error(0.5 * h)).log2()
}

fn truth(l: &AnyLagrangian, initial: &State) -> Vec<f64> {
    let method = position_momentum(Galerkin::gauss(l, 8).expect("s ≥ 1"));
    let end = Trajectory::new(method, initial.clone(), 0.1, 2.0).expect("valid").observe(|_| {}).expect("solvable");
    [end.q, end.p].concat()
}

#[test]
fn orders_on_the_pendulum() {
    let l = lagrangian_of(Pendulum);
    let initial = State::new(0.0, vec![2.0]);
    let truth = truth(&l, &initial);
    let mut wrong = Vec::new();
    let mut check = |name: String, measured: f64, expected: usize| {
        if !(0.0..=0.25).contains(&(measured - expected as f64).abs()) {
            wrong.push(format!("{name}: {measured:.2} instead of {expected}"));
        }
    };
    let families = [NodeFamily::Equispaced, NodeFamily::Gauss, NodeFamily::Lobatto, NodeFamily::Chebyshev];
    for family in families {
        for m in 2..=5 {
            let expected = if family == NodeFamily::Gauss { 2 * (m - 1) } else { 2 * (m / 2) };
            // As short as the rounding of 1e-13 that the steps add up to lets the errors be.
            let h = match expected {
                8 => 1.0 / 3.0,
                6 => 0.25,
                _ => 0.1,
            };
            let measured = order(|| PathFitted::on(&l, family, m).expect("m ≥ 2"), h, &initial, &truth);
            check(format!("{family:?}({m})"), measured, expected);
        }
    }
    for s in 1..=3 {
        let h = if s > 2 { 0.4 } else { 0.1 };
        let gauss = order(|| Galerkin::gauss(&l, s).expect("s ≥ 1"), h, &initial, &truth);
        check(format!("galerkin-gauss({s})"), gauss, 2 * s);
        let lobatto = order(|| Galerkin::lobatto(&l, s).expect("s ≥ 1"), h, &initial, &truth);
        check(format!("galerkin-lobatto({s})"), lobatto, 2 * s);
    }
    check("midpoint".into(), order(|| Midpoint::new(&l), 0.1, &initial, &truth), 2);
    check("stormer-verlet".into(), order(|| Trapezoidal::new(&l), 0.1, &initial, &truth), 2);
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn forced_motions_keep_the_order() {
    let l = Forced::new(lagrangian_of(Pendulum), AutoForce::new(Damping { dim: 1, rate: 0.3 })).expect("1");
    let initial = State::new(0.0, vec![2.0]);
    // L_v = v: the first-order system is q̇ = p, ṗ = −sin q − 0.3 (1 + q²) p, by the classical method with 20000 steps.
    let (mut y, n) = ([2.0, 0.0], 20_000);
    let h = 2.0 / f64::from(n);
    let f = |y: [f64; 2]| [y[1], -y[0].sin() - 0.3 * (1.0 + y[0] * y[0]) * y[1]];
    for _ in 0..n {
        let shifted = |k: [f64; 2], c: f64| [y[0] + c * h * k[0], y[1] + c * h * k[1]];
        let k1 = f(y);
        let k2 = f(shifted(k1, 0.5));
        let k3 = f(shifted(k2, 0.5));
        let k4 = f(shifted(k3, 1.0));
        for i in 0..2 {
            y[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        }
    }
    let check = |name: &str, measured: f64, expected: f64| {
        assert!((measured - expected).abs() < 0.25, "{name}: {measured:.2} instead of {expected}");
    };
    check("midpoint", order(|| Midpoint::new(&l), 0.1, &initial, &y), 2.0);
    check("trapezoidal", order(|| Trapezoidal::new(&l), 0.1, &initial, &y), 2.0);
    check("galerkin-gauss(2)", order(|| Galerkin::gauss(&l, 2).expect("s"), 0.1, &initial, &y), 4.0);
    check("galerkin-lobatto(2)", order(|| Galerkin::lobatto(&l, 2).expect("s"), 0.1, &initial, &y), 4.0);
    let fitted = |family, m| PathFitted::on(&l, family, m).expect("m ≥ 2");
    check("path-fitted(2)", order(|| fitted(NodeFamily::Equispaced, 2), 0.1, &initial, &y), 2.0);
    check("path-fitted(3,gauss)", order(|| fitted(NodeFamily::Gauss, 3), 0.1, &initial, &y), 4.0);
}

/// From x₁ of the one-step form both forms make the same trajectory; from another x₁ they make the recurrence's.
#[test]
fn two_step_form_is_the_one_step_form() {
    let l = lagrangian_of(Driven);
    for (name, discrete) in discretisations(&l) {
        let mut one = position_momentum(discrete);
        let h = 0.1;
        let (q0, mut q, mut p) = ([0.7, -0.4], [0.7, -0.4], [0.2, 0.5]);
        one.step(0.0, h, &mut q, &mut p).expect("short step");
        let index = discretisations(&l).iter().position(|(other, _)| *other == name).expect("the same list");
        let mut two = TwoStep::new(discretisations(&l).swap_remove(index).1);
        let (mut before, mut now) = (q0, q);
        for k in 1..5 {
            let t = h * f64::from(k);
            let mut between = [0.0; 2];
            two.momentum(t - h, h, &before, &now, &mut between).expect("short step");
            for i in 0..2 {
                // Rounding ε of the configurations is 1/h times that, and m² more, in the momentum between them.
                assert_abs_diff_eq!(between[i], p[i], epsilon = 2e3 * EPS);
                assert_abs_diff_eq!(now[i], q[i], epsilon = 1e3 * EPS);
            }
            one.step(t, h, &mut q, &mut p).expect("short step");
            two.step(t, h, &mut before, &mut now).expect("short step");
        }
    }
    let oscillator = lagrangian_of(Oscillator);
    let mut scheme = TwoStep::new(PathFitted::on(&oscillator, NodeFamily::Equispaced, 2).expect("m ≥ 2"));
    let (mut before, mut now) = ([1.0], [1.0948]);
    scheme.step(0.1, 0.1, &mut before, &mut now).expect("linear");
    assert_abs_diff_eq!(now[0], (16.0 - 0.06) / 8.01 * 1.0948 - 1.0, epsilon = 64.0 * EPS);
}

#[test]
fn bad_input_has_typed_errors() {
    let l = lagrangian_of(Pendulum);
    let nodes = |c: &[f64]| PathFitted::new(&l, c).err();
    assert!(matches!(nodes(&[]), Some(InputError::Nodes(NodeError::TooFew { least: 1, .. }))));
    assert!(matches!(nodes(&[0.5, 1.5]), Some(InputError::Nodes(NodeError::NodeRange { .. }))));
    assert!(matches!(nodes(&[0.5, f64::NAN]), Some(InputError::Nodes(NodeError::NodeRange { .. }))));
    assert!(matches!(nodes(&[0.5, 0.5 + 4.0 * EPS]), Some(InputError::Nodes(NodeError::CoincidentNodes { .. }))));
    assert!(matches!(nodes(&[0.5, 0.5]), Some(InputError::Nodes(NodeError::CoincidentNodes { .. }))));
    assert!(matches!(nodes(&[0.0, 0.5]), Some(InputError::Nodes(NodeError::CoincidentNodes { .. }))));
    assert!(matches!(PathFitted::bernstein(&l, &[1.0]), Err(InputError::Nodes(NodeError::CoincidentNodes { .. }))));
    assert!(matches!(PathFitted::on(&l, NodeFamily::Gauss, 1), Err(InputError::Nodes(NodeError::TooFew { .. }))));
    assert!(matches!(Galerkin::gauss(&l, 0), Err(InputError::Nodes(NodeError::TooFew { .. }))));
    let rule = Quadrature::gauss(2).expect("n ≥ 1");
    assert!(matches!(
        Galerkin::new(&l, 3, &rule),
        Err(InputError::Nodes(NodeError::TooFew { least: 3, found: 2, .. }))
    ));
    let two = AutoForce::new(Damping { dim: 2, rate: 1.0 });
    let expected = InputError::System(SystemError::Dimension { what: "force", expected: 1, found: 2 });
    assert_eq!(Forced::new(lagrangian_of(Pendulum), two).err(), Some(expected));
    let degenerate = lagrangian_of(Degenerate);
    for (name, discrete) in discretisations(&degenerate) {
        let (mut q, mut p) = ([0.3, 0.4], [0.1, 0.2]);
        let result = position_momentum(discrete).step(0.0, 0.1, &mut q, &mut p);
        let singular = matches!(result, Err(StepError::Solve { source: SolveError::SingularMass, .. }));
        assert!(singular && q == [0.3, 0.4] && p == [0.1, 0.2], "{name}: {result:?}");
    }
}

#[test]
fn broken_lines_and_the_circle_s_scheme_tell_the_velocity_of_a_momentum() {
    let state = State::new(0.0, vec![0.3, 0.4]).with_momentum(vec![0.5, -0.25]);
    let mut rate = [0.0; 2];
    let l = lagrangian_of(crate::separable::Separable(crate::systems::HenonHeiles));
    let mut line = position_momentum(BrokenLine::blanes_moan(&l).expect("separable"));
    line.rate(&state, &mut rate).expect("unit mass");
    assert_eq!(rate, [0.5, -0.25]);
    rate.fill(0.0);
    position_momentum(KongYangCircle::new(2)).rate(&state, &mut rate).expect("unit mass");
    assert_abs_diff_eq!(rate[0], 0.5, epsilon = 1e-15);
    assert_abs_diff_eq!(rate[1], -0.25, epsilon = 1e-15);
}

#[test]
fn a_forced_motion_has_the_value_of_its_lagrangian() {
    let damping = AutoForce::new(Damping { dim: 1, rate: 0.3 });
    let l = Forced::new(lagrangian_of(Pendulum), damping).expect("of one dimension");
    let value = Lagrangian::value(&l, 0.0, &[2.0], &[0.5]);
    assert_abs_diff_eq!(value, 0.125 + 2.0_f64.cos(), epsilon = 1e-15);
}
