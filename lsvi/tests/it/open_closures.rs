//! Closures fitted to a rate, and windows of steps found together.

use crate::systems::{AnyField, field_of};
use approx::{assert_abs_diff_eq, assert_relative_eq};
use lsvi::closure::{Closure, Linear};
use lsvi::discrete::{DiscreteLagrangian, DiscreteLegendre, Galerkin, Interval, MomentumWeights, Trapezoidal};
use lsvi::{
    FieldFn, Integrator, LeastSquares, OneStep, Scalar, SolveError, State, StepError, Trajectory, Variational, Window,
    least_squares, method_i,
};
use nalgebra::DMatrix;

struct Decay {
    rate: f64,
}

impl FieldFn for Decay {
    fn dim(&self) -> usize {
        1
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[0] * -self.rate;
    }
}

/// Nonlinear, coupled and forced, with a Jacobian that is not symmetric.
struct Coupled;

impl FieldFn for Coupled {
    fn dim(&self) -> usize {
        2
    }
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[1] - v[0].powi(3);
        dv[1] = -v[0].sin() - v[1] * 0.5 + t.cos();
    }
}

fn discrete<'a>(field: impl FieldFn + 'a) -> Trapezoidal<LeastSquares<AnyField<'a>>> {
    Trapezoidal::new(LeastSquares::new(field_of(field)).expect("usable"))
}

/// All states of a run from `start`, the first included.
fn states(method: impl Integrator, start: &[f64], h: f64, t_end: f64) -> Vec<State> {
    let mut all = Vec::new();
    let trajectory = Trajectory::new(method, State::new(0.0, start.to_vec()), h, t_end).expect("valid input");
    trajectory.observe(|state| all.push(state.clone())).expect("solvable");
    all
}

#[test]
fn the_fitted_closure_is_exact_for_its_rate() {
    for (rate, h) in [(1.0_f64, 1e-3), (3.0, 0.2), (1.0, 2.0), (50.0, 0.4), (1e3, 1.0)] {
        let closure = Linear::fitted(rate).expect("positive");
        let end = states(least_squares(field_of(Decay { rate }), closure).expect("usable"), &[1.0], h, h);
        // θ − 1 is z/2 to within a rounding of 1: ε/z in z, so ε of the step.
        assert_abs_diff_eq!(end[1].q[0], (-rate * h).exp(), epsilon = 8.0 * f64::EPSILON);
    }
}

#[test]
fn a_window_of_one_step_is_method_i() {
    let window = Window::new(discrete(Coupled), 1).expect("a length");
    let (a, b) = (
        states(window, &[1.0, -0.5], 0.3, 2.0),
        states(method_i(field_of(Coupled)).expect("usable"), &[1.0, -0.5], 0.3, 2.0),
    );
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(&b) {
        assert_eq!(a.t, b.t);
        // Both stop within a few roundings of the root; so do the seven steps before.
        (0..2).for_each(|i| assert_abs_diff_eq!(a.q[i], b.q[i], epsilon = 32.0 * f64::EPSILON));
    }
}

/// Largest violation of the conditions of a window from state `first` to state `last` of a trajectory.
fn defect(discrete: &mut impl DiscreteLegendre, states: &[State], (first, last): (usize, usize)) -> f64 {
    let (mut end, mut start) = ([0.0; 2], [0.0; 2]);
    let mut largest = 0.0_f64;
    for i in first + 1..=last {
        let at = |i: usize| Interval { start: states[i].t, h: states[i + 1].t - states[i].t };
        discrete.momentum(at(i - 1), &states[i - 1].q, &states[i].q, MomentumWeights::END, &mut end);
        start.fill(0.0);
        if i < last {
            discrete.momentum(at(i), &states[i].q, &states[i + 1].q, MomentumWeights::START, &mut start);
        }
        (0..2).for_each(|k| largest = largest.max((end[k] - start[k]).abs()));
        // The momentum that the state carries is the one at the end of its step.
        (0..2).for_each(|k| assert_abs_diff_eq!(states[i].p[k], end[k], epsilon = 1e-13));
    }
    largest
}

#[test]
fn windows_keep_the_discrete_euler_lagrange_equations_inside_and_end_without_momentum() {
    // 2.0 = 6 · 0.3 + 0.2: windows of four steps, then of two and the short one.
    let all = states(Window::new(discrete(Coupled), 4).expect("a length"), &[1.0, -0.5], 0.3, 2.0);
    assert_eq!(all.len(), 8);
    // Momenta cancel like ε|q|/h, in two dozen operations.
    let roundoff = 32.0 * f64::EPSILON / 0.2;
    for window in [(0, 4), (4, 7)] {
        assert!(defect(&mut discrete(Coupled), &all, window) < roundoff);
    }
    // They do not hold where two windows meet: the momentum starts anew.
    assert!(defect(&mut discrete(Coupled), &all, (0, 7)) > 1e-5);
    let whole = states(Window::new(discrete(Coupled), 7).expect("a length"), &[1.0, -0.5], 0.3, 2.0);
    assert!(defect(&mut discrete(Coupled), &whole, (0, 7)) < roundoff);
    // A window longer than the interval is the interval.
    let longer = states(Window::new(discrete(Coupled), 12).expect("a length"), &[1.0, -0.5], 0.3, 2.0);
    for (a, b) in whole.iter().zip(&longer) {
        (0..2).for_each(|i| assert_abs_diff_eq!(a.q[i], b.q[i], epsilon = 32.0 * f64::EPSILON));
    }
}

#[test]
fn the_whole_interval_has_the_least_action() {
    let mut discrete_lagrangian = discrete(Coupled);
    let mut action = |states: &[State]| -> f64 {
        let steps = states.windows(2);
        steps
            .map(|s| discrete_lagrangian.action(Interval { start: s[0].t, h: s[1].t - s[0].t }, &s[0].q, &s[1].q))
            .sum()
    };
    let whole = states(Window::new(discrete(Coupled), 20).expect("a length"), &[1.0, -0.5], 0.1, 2.0);
    let least = action(&whole);
    for (i, k, change) in [(1, 0, 1e-4), (7, 1, -1e-4), (13, 0, -1e-4), (20, 1, 1e-4)] {
        let mut other = whole.clone();
        other[i].q[k] += change;
        // The second variation is ½ (2/h) change² to leading order, and at most a tenth of it is lost to the coupling.
        assert_relative_eq!(
            action(&other) - least,
            change * change / if i == 20 { 0.2 } else { 0.1 },
            max_relative = 0.2
        );
    }
    let closure_i = states(method_i(field_of(Coupled)).expect("usable"), &[1.0, -0.5], 0.1, 2.0);
    // Nearly all of the action is what a straight path leaves of v̇ = f, whatever its ends.
    assert!(action(&closure_i) > (1.0 + 1e-4) * least);
}

/// On v̇ = −v the relative error of a window is K h³ [1/24 + (1 − e^{−2Kh})/(16Kh)] to leading order in h.
#[test]
fn the_mean_local_error_falls_from_method_i_s_to_a_quarter_of_it() {
    for (steps, span) in [(1, 0.002), (4, 0.02), (200, 1.0_f64), (400, 4.0)] {
        let h = span / f64::from(steps);
        let window = Window::new(discrete(Decay { rate: 1.0 }), steps as usize).expect("a length");
        let end = states(window, &[1.0], h, span);
        let mean = (end[steps as usize].q[0] * span.exp() - 1.0) / f64::from(steps) / h.powi(3);
        let law = 1.0 / 24.0 - (-2.0 * span).exp_m1() / (16.0 * span);
        // The next term is smaller by a factor of order h.
        assert_relative_eq!(mean, law, max_relative = 2.0 * h);
    }
}

/// Windows of any discrete Lagrangian, here with interior unknowns: two steps of degree 2 against one stationary path.
#[test]
fn windows_eliminate_interior_values_too() {
    let lobatto = || Galerkin::lobatto(LeastSquares::new(field_of(Coupled)).expect("usable"), 2).expect("a degree");
    let error = |h: f64| {
        let at =
            |h: f64| states(Window::new(lobatto(), 3).expect("a length"), &[1.0, -0.5], h, 1.2).pop().expect("some").q;
        let (coarse, fine) = (at(h), at(0.5 * h));
        (coarse[0] - fine[0]).abs().max((coarse[1] - fine[1]).abs())
    };
    let ratio = error(0.0125) / error(0.00625);
    assert!((14.0..17.0).contains(&ratio), "fourth order halves h to a sixteenth of the error, not 1/{ratio}");
}

#[test]
fn a_state_that_was_changed_starts_a_new_window() {
    let mut window = Window::new(discrete(Coupled), 4).expect("a length");
    let grid = lsvi::Grid::new(0.0, 0.1, 1.0).expect("a grid");
    let mut state = State::new(0.0, vec![1.0, -0.5]);
    window.advance(&mut state, &grid).expect("solvable");
    let (second, mut changed) = (state.clone(), state.clone());
    changed.q[0] += 0.1;
    window.advance(&mut changed, &grid).expect("solvable");
    let mut fresh = State { q: vec![second.q[0] + 0.1, second.q[1]], ..second };
    Window::new(discrete(Coupled), 4).expect("a length").advance(&mut fresh, &grid).expect("solvable");
    assert_eq!(changed, fresh);
}

#[test]
fn unusable_windows_are_refused_and_lost_branches_named() {
    struct QuadraticDrag;
    impl FieldFn for QuadraticDrag {
        fn dim(&self) -> usize {
            1
        }
        fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
            dv[0] = -v[0] * v[0];
        }
    }
    assert!(Window::new(discrete(Coupled), 0).is_err());
    let mut trajectory = Trajectory::new(
        Window::new(discrete(QuadraticDrag), 3).expect("a length"),
        State::new(0.0, vec![1.0]),
        5.0,
        15.0,
    )
    .expect("valid input");
    let result = trajectory.step().map(|_| ());
    assert!(matches!(result, Err(StepError::Solve { source: SolveError::BranchLost { .. }, .. })), "{result:?}");
    assert_eq!(trajectory.state(), &State::new(0.0, vec![1.0]));
}

/// F(p₀, p₁) = (1 + |p₀|²) p₁ − θ p₀, whose components are coupled; θ = 0 is Method I.
struct Rational(f64);

impl Closure for Rational {
    fn residual(&self, _h: f64, _p: &[f64], p0: &[f64], p1: &[f64], out: &mut [f64]) {
        let size = 1.0 + p0.iter().map(|p| p * p).sum::<f64>();
        (0..out.len()).for_each(|i| out[i] = size * p1[i] - self.0 * p0[i]);
    }
    fn derivative(
        &self,
        _h: f64,
        _p: &[f64],
        p0: &[f64],
        p1: &[f64],
        in_p0: &mut DMatrix<f64>,
        in_p1: &mut DMatrix<f64>,
    ) {
        let size = 1.0 + p0.iter().map(|p| p * p).sum::<f64>();
        for i in 0..p0.len() {
            in_p1[(i, i)] += size;
            in_p0[(i, i)] -= self.0;
            (0..p0.len()).for_each(|j| in_p0[(i, j)] += 2.0 * p1[i] * p0[j]);
        }
    }
}

/// A linear closure that does not say so.
struct Disguised(Linear);

impl Closure for Disguised {
    fn residual(&self, h: f64, p: &[f64], p0: &[f64], p1: &[f64], out: &mut [f64]) {
        self.0.residual(h, p, p0, p1, out);
    }
    fn derivative(
        &self,
        h: f64,
        p: &[f64],
        p0: &[f64],
        p1: &[f64],
        in_p0: &mut DMatrix<f64>,
        in_p1: &mut DMatrix<f64>,
    ) {
        self.0.derivative(h, p, p0, p1, in_p0, in_p1);
    }
}

#[test]
fn a_closure_may_be_nonlinear() {
    let field = field_of!(2; |t, v, dv| {
        dv[0] = v[1] - v[0] * v[0] * v[0];
        dv[1] = -v[0] - v[1] * v[0] * v[0] + t;
    });
    let lagrangian = || LeastSquares::new(&field).expect("dense");
    let path = || Galerkin::lobatto(lagrangian(), 2).expect("s ≥ 1");
    let step = |method: &mut dyn OneStep, h: f64| {
        let (mut q, mut p) = ([1.0, -0.5], [0.1, 0.2]);
        method.step(0.0, h, &mut q, &mut p).expect("solvable");
        (q, p)
    };
    // A linear closure gives the same step by either way.
    for (alpha, beta) in [(0.0, 1.0), (-0.5, 1.0), (1.0, 0.0)] {
        let closure = || Linear::new(alpha, beta).expect("not both zero");
        let (q, p) = step(&mut Variational::new(path(), closure()), 0.1);
        let (other_q, other_p) = step(&mut Variational::new(path(), Disguised(closure())), 0.1);
        (0..2).for_each(|i| approx::assert_abs_diff_eq!(q[i], other_q[i], epsilon = 1e-14));
        (0..2).for_each(|i| approx::assert_abs_diff_eq!(p[i], other_p[i], epsilon = 1e-13));
    }
    // The momenta of a step satisfy a nonlinear one, to the roundings of differences of positions over h.
    let theta = 0.7;
    let (mut method, mut discrete) =
        (Variational::new(Trapezoidal::new(lagrangian()), Rational(theta)), Trapezoidal::new(lagrangian()));
    for h in [1e-6, 1e-3, 0.3] {
        let (q1, p1) = step(&mut method, h);
        let mut p0 = [0.0; 2];
        discrete.momentum(Interval { start: 0.0, h }, &[1.0, -0.5], &q1, MomentumWeights::START, &mut p0);
        let size = 1.0 + p0.iter().map(|p| p * p).sum::<f64>();
        assert!(h < 0.3 || size > 1.0001, "{size}");
        let epsilon = 32.0 * f64::EPSILON * (1.0 + h.recip());
        (0..2).for_each(|i| approx::assert_abs_diff_eq!(size * p1[i], theta * p0[i], epsilon = epsilon));
        // Of the roots of F(p, p) = 0 it is the one near the momentum of the state: p = 0.
        (0..2).for_each(|i| assert!(p1[i].abs() < 4.0 * h, "{p1:?} for h = {h}"));
    }
}

/// A p₀ + B p₁ = C p with matrices that are not symmetric.
struct Mixed([[[f64; 2]; 2]; 3]);

impl Closure for Mixed {
    fn residual(&self, _h: f64, p: &[f64], p0: &[f64], p1: &[f64], out: &mut [f64]) {
        let [a, b, c] = self.0;
        for i in 0..2 {
            out[i] = (0..2).map(|j| a[i][j] * p0[j] + b[i][j] * p1[j] - c[i][j] * p[j]).sum();
        }
    }
    fn derivative(
        &self,
        _h: f64,
        _p: &[f64],
        _p0: &[f64],
        _p1: &[f64],
        in_p0: &mut DMatrix<f64>,
        in_p1: &mut DMatrix<f64>,
    ) {
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            in_p0[(i, j)] += self.0[0][i][j];
            in_p1[(i, j)] += self.0[1][i][j];
        }
    }
}

/// On a linear field the equations of a step are affine, and Newton's method finds their root at once with the derivatives of the closure in
/// their places.
#[test]
fn a_closure_that_couples_components_has_its_own_derivative() {
    let field = field_of!(2; |_t, v, dv| {
        dv[0] = v[1] - v[0];
        dv[1] = -v[0] * 2.0 - v[1];
    });
    let path = || Galerkin::lobatto(LeastSquares::new(&field).expect("dense"), 2).expect("s ≥ 1");
    let (one, other, none) = ([[1.0, 3.0], [-0.5, 1.0]], [[2.0, -1.0], [0.25, 1.0]], [[0.0; 2]; 2]);
    let step = |method: &mut dyn OneStep| {
        let (mut q, mut p) = ([1.0, -0.5], [0.1, 0.2]);
        method.step(0.0, 0.1, &mut q, &mut p).expect("solvable");
        (q, method.work().residuals)
    };
    // Those of one matrix are linear closures.
    for (closure, (alpha, beta)) in [([none, other, none], (0.0, 1.0)), ([one, none, none], (1.0, 0.0))] {
        let (expected, _) = step(&mut Variational::new(path(), Linear::new(alpha, beta).expect("not both zero")));
        let (found, residuals) = step(&mut Variational::new(path(), Mixed(closure)));
        (0..2).for_each(|i| approx::assert_abs_diff_eq!(found[i], expected[i], epsilon = 1e-13));
        let diagonal = |matrix: [[f64; 2]; 2]| [[matrix[0][0], 0.0], [0.0, matrix[1][1]]];
        let (_, least) = step(&mut Variational::new(path(), Mixed(closure.map(diagonal))));
        assert!(residuals <= least, "{residuals} evaluations, and {least} where the components are apart");
    }
}

#[test]
fn another_step_size_starts_a_new_window() {
    let window = Window::new(discrete(Coupled), 4).expect("a length");
    let mut run = Trajectory::new(window, State::new(0.0, vec![1.0, -0.5]), 0.1, 1.0).expect("valid");
    run.step().expect("solvable");
    let start = run.state().clone();
    run.resume(0.05, 1.0).expect("valid");
    run.step().expect("solvable");
    let mut fresh =
        Trajectory::new(Window::new(discrete(Coupled), 4).expect("a length"), start, 0.05, 1.0).expect("valid");
    fresh.step().expect("solvable");
    assert_eq!((run.state().t, run.state()), (0.1 + 0.05, fresh.state()));
}

/// Robertson's reaction conserves a sum, and from its start only the first component acts: J has the rank 1, and the curvature of f, 3·10⁷, hides it.
struct Robertson;

impl FieldFn for Robertson {
    fn dim(&self) -> usize {
        3
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        let [slow, back, fast] = [v[0] * 0.04, v[1] * v[2] * 1e4, v[1] * v[1] * 3e7];
        dv[0] = back - slow;
        dv[1] = slow - back - fast;
        dv[2] = fast;
    }
}

/// With paths of degree one to three, and in steps of every size, as by [`method_ii`](lsvi::method_ii) itself.
#[test]
fn what_method_ii_leaves_open_is_refused_on_every_path() {
    let by = |nodes: usize, h: f64| {
        let l = LeastSquares::new(field_of(Robertson)).expect("usable");
        let mut method = Variational::new(Galerkin::lobatto(l, nodes).expect("nodes"), Linear::METHOD_II);
        method.step(0.0, h, &mut [1.0, 0.0, 0.0], &mut [0.0; 3])
    };
    for (nodes, h) in [1, 2, 3].into_iter().flat_map(|nodes| [1e-6, 1e-4, 0.01, 1.0].map(|h| (nodes, h))) {
        let step = by(nodes, h);
        assert!(step.is_err(), "{nodes} nodes, h = {h}");
        let is_open = matches!(step, Err(StepError::Solve { source: SolveError::Singular, .. }));
        assert!(nodes > 1 || h > 0.01 || is_open, "{nodes} nodes, h = {h}: {step:?}");
    }
}

/// However slow beside the step, and beside how fast a component.
#[test]
fn what_method_ii_determines_is_found_on_every_path() {
    struct TwoRates(f64);
    impl FieldFn for TwoRates {
        fn dim(&self) -> usize {
            2
        }
        fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
            dv[0] = v[0] * -self.0;
            dv[1] = (v[1] - v[0]) * -1e3;
        }
    }
    for rate in [1e-9, 1e-6, 1.0, 1e6] {
        for nodes in [1, 2, 3] {
            let l = LeastSquares::new(field_of(TwoRates(rate))).expect("usable");
            let mut method = Variational::new(Galerkin::lobatto(l, nodes).expect("nodes"), Linear::METHOD_II);
            let mut v = [1.0, 1.0];
            method.step(0.0, 0.1, &mut v, &mut [0.0; 2]).expect("determined");
            let (found, exact) = (v[0], (-0.1 * rate).exp());
            // What a fast component adds to the error of a slow one is in proportion to its rate too.
            assert!(rate > 1.0 || (found - exact).abs() < 0.01 * rate + 4.0 * f64::EPSILON, "{rate}, {nodes}: {found}");
        }
    }
}
