//! The closures on scalar problems whose steps are known in closed form.

use crate::fields::{Autonomous, By, Line, Unscaled, Walls, with_structure};
use crate::systems::field_of;
use approx::assert_abs_diff_eq;
use lsvi::classic::{Bdf2, RungeKutta, Tableau};
use lsvi::closure::Linear;
use lsvi::discrete::{DiscreteLagrangian, Interval, Midpoint, MomentumWeights, Trapezoidal};
use lsvi::solver::Iterative;
use lsvi::{
    ClosureError, FieldFn, InputError, LeastSquares, LeastSquaresStep, OneStep, Scalar, SolveError, State, StepError,
    Structure, SystemError, TimeError, Trajectory, Variational, least_squares, method_i, method_ii, position_momentum,
};

struct Drag;
impl FieldFn for Drag {
    fn dim(&self) -> usize {
        1
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = -v[0];
    }
}

struct QuadraticDrag;
impl FieldFn for QuadraticDrag {
    fn dim(&self) -> usize {
        1
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = -v[0] * v[0];
    }
}

struct Forcing;
impl FieldFn for Forcing {
    fn dim(&self) -> usize {
        1
    }
    fn rhs<T: Scalar>(&self, t: f64, _v: &[T], dv: &mut [T]) {
        dv[0] = T::from(t.cos());
    }
}

fn one_step(method: &mut impl OneStep, h: f64, v: f64, p: f64) -> Result<(f64, f64), StepError> {
    let (mut q, mut p) = ([v], [p]);
    method.step(0.0, h, &mut q, &mut p)?;
    Ok((q[0], p[0]))
}

#[test]
fn conventional_closure_grows_as_predicted() {
    // On v̇ = −v the map (v, p) → (v, p) has trace 2 + h² and determinant 1: eigenvalues e^{±2 asinh(h/2)}.
    let h = 0.1_f64;
    let mut method = position_momentum(Trapezoidal::new(LeastSquares::new(field_of(Drag)).expect("usable")));
    let a = one_step(&mut method, h, 1.0, 0.0).expect("linear");
    let b = one_step(&mut method, h, 0.0, 1.0).expect("linear");
    assert_abs_diff_eq!(a.0 + b.1, 2.0 + h * h, epsilon = 1e-13);
    assert_abs_diff_eq!(a.0 * b.1 - a.1 * b.0, 1.0, epsilon = 1e-13);
    let growth = (2.0 * (0.5 * h).asinh()).exp();
    assert_abs_diff_eq!(growth + 1.0 / growth, a.0 + b.1, epsilon = 1e-13);
}

/// X = h v₁ against W = h v₀ on the cubic of Method I, whose right root is the largest.
#[test]
fn method_i_keeps_to_the_right_root_of_quadratic_drag() {
    let mut method = method_i(field_of(QuadraticDrag)).expect("usable");
    for w in [0.1, 0.5, 1.0, 1.37, 1.9, 2.1, 2.17] {
        let (x, _) = one_step(&mut method, w, 1.0, 0.0).expect("before the fold");
        let x = w * x;
        let cubic = |x: f64| 2.0 * x.powi(3) + 3.0 * x * x + (2.0 - 2.0 * w) * x + w * w - 2.0 * w;
        assert_abs_diff_eq!(cubic(x), 0.0, epsilon = 1e-12);
        // Beyond the larger critical point of the cubic there is one root, the largest.
        let discriminant = 9.0 - 6.0 * (2.0 - 2.0 * w);
        let critical = if discriminant > 0.0 { (-3.0 + discriminant.sqrt()) / 6.0 } else { f64::NEG_INFINITY };
        assert!(x > critical, "W = {w}: X = {x} is not the largest root");
    }
    for w in [2.2, 3.0, 10.0, 1e3] {
        let result = one_step(&mut method, w, 1.0, 0.0);
        let Err(StepError::Solve { source: SolveError::BranchLost { reached }, .. }) = result else {
            panic!("W = {w}: {result:?}");
        };
        // At the fold the largest critical point of the cubic is a root: W = 1 + 3X + 3X² there.
        let x = (-3.0 + (12.0 * reached - 3.0).sqrt()) / 6.0;
        let value = 2.0 * x.powi(3) + 3.0 * x * x + (2.0 - 2.0 * reached) * x + reached * reached - 2.0 * reached;
        assert_abs_diff_eq!(value, 0.0, epsilon = 1e-8);
    }
}

#[test]
fn method_ii_loses_its_root_beyond_w_1_and_has_no_equation_without_f_v() {
    let mut method = method_ii(field_of(QuadraticDrag)).expect("usable");
    let (x, _) = one_step(&mut method, 0.9, 1.0, 0.0).expect("W < 1");
    // X²(1 + X) = W²(1 − W).
    let x = 0.9 * x;
    assert_abs_diff_eq!(x * x * (1.0 + x), 0.81 * 0.1, epsilon = 1e-14);
    for w in [1.01, 2.0] {
        let result = one_step(&mut method, w, 1.0, 0.0);
        assert!(
            matches!(result, Err(StepError::Solve { source: SolveError::BranchLost { .. }, .. })),
            "W = {w}: {result:?}"
        );
    }
    let result = one_step(&mut method_ii(field_of(Forcing)).expect("usable"), 0.1, 0.0, 0.0);
    assert!(matches!(result, Err(StepError::Solve { source: SolveError::Singular, .. })), "{result:?}");
}

#[test]
fn midpoint_lagrangian_with_method_i_closure_is_the_implicit_midpoint_rule() {
    let discrete = Midpoint::new(LeastSquares::new(field_of(QuadraticDrag)).expect("usable"));
    let mut variational = Variational::new(discrete, Linear::METHOD_I);
    let mut rule = RungeKutta::new(field_of(QuadraticDrag), Tableau::implicit_midpoint()).expect("usable");
    for h in [0.01, 0.3, 1.0] {
        let a = one_step(&mut variational, h, 1.0, 0.0).expect("solvable").0;
        let b = one_step(&mut rule, h, 1.0, 0.0).expect("solvable").0;
        assert_abs_diff_eq!(a, b, epsilon = 8.0 * f64::EPSILON);
    }
}

/// −D₁L_d and D₂L_d by central differences of the action.
#[test]
fn momenta_are_the_derivatives_of_the_action() {
    fn check(mut discrete: impl DiscreteLagrangian) {
        let at = Interval { start: 0.3, h: 0.4 };
        let (q0, q1, e) = (0.7, 0.5, 1e-5);
        let mut p = [0.0];
        // Central differences: error e² L‴/6 + ε L/e, both below 1e-9 here.
        discrete.momentum(at, &[q0], &[q1], MomentumWeights::START, &mut p);
        let d1 = (discrete.action(at, &[q0 + e], &[q1]) - discrete.action(at, &[q0 - e], &[q1])) / (2.0 * e);
        assert_abs_diff_eq!(p[0], -d1, epsilon = 1e-9);
        discrete.momentum(at, &[q0], &[q1], MomentumWeights::END, &mut p);
        let d2 = (discrete.action(at, &[q0], &[q1 + e]) - discrete.action(at, &[q0], &[q1 - e])) / (2.0 * e);
        assert_abs_diff_eq!(p[0], d2, epsilon = 1e-9);
    }
    check(Trapezoidal::new(LeastSquares::new(field_of(QuadraticDrag)).expect("usable")));
    check(Midpoint::new(LeastSquares::new(field_of(QuadraticDrag)).expect("usable")));
}

#[test]
fn bdf2_starts_itself_and_shortens_its_last_step() {
    let error = |h: f64| {
        let trajectory =
            Trajectory::new(Bdf2::new(field_of(Drag)).expect("usable"), State::new(0.0, vec![1.0]), h, 1.05)
                .expect("valid input");
        let end = trajectory.observe(|_| {}).expect("solvable");
        assert_eq!(end.t, 1.05);
        (end.q[0] - (-1.05_f64).exp()).abs()
    };
    let ratio = error(0.02) / error(0.01);
    assert!((3.7..4.3).contains(&ratio), "second order halves h to a quarter of the error, not 1/{ratio}");
}

#[test]
fn refuses_unusable_input() {
    let state = State::new(0.0, vec![1.0]);
    let refuse =
        |state: State, h, t_end| Trajectory::new(method_i(field_of(Drag)).expect("usable"), state, h, t_end).err();
    assert_eq!(refuse(state.clone(), 0.0, 1.0), Some(InputError::Time(TimeError::StepSize(0.0))));
    assert_eq!(refuse(state.clone(), -1.0, 1.0), Some(InputError::Time(TimeError::StepSize(-1.0))));
    assert!(matches!(refuse(state.clone(), f64::NAN, 1.0), Some(InputError::Time(TimeError::StepSize(_)))));
    assert_eq!(refuse(state.clone(), 0.1, -1.0), Some(InputError::Time(TimeError::EndTime { t0: 0.0, t_end: -1.0 })));
    assert!(matches!(refuse(state.clone(), 1e-300, 1.0), Some(InputError::Time(TimeError::Unresolvable { .. }))));
    let two = State::new(0.0, vec![1.0, 2.0]);
    assert_eq!(
        refuse(two, 0.1, 1.0),
        Some(InputError::System(SystemError::Dimension { what: "q", expected: 1, found: 2 }))
    );
    let nan = State::new(0.0, vec![f64::NAN]);
    assert!(matches!(
        refuse(nan, 0.1, 1.0),
        Some(InputError::System(SystemError::NonFinite { what: "q", index: 0, .. }))
    ));
    assert!(matches!(Linear::new(0.0, 0.0), Err(InputError::Closure(ClosureError::Closure { .. }))));
    assert!(matches!(Linear::new(f64::NAN, 1.0), Err(InputError::Closure(ClosureError::Closure { .. }))));
}

struct Logistic;
impl FieldFn for Logistic {
    fn dim(&self) -> usize {
        1
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[0] - v[0] * v[0];
    }
}

/// From these starts the derivative of Method I's equation has the wrong sign at v₀, and Newton's iteration contracts to a
/// root near 0, at once and on the right side of a singular derivative. The branch, followed here in 4000 pieces, goes up.
#[test]
fn method_i_keeps_to_the_branch_where_the_start_is_beyond_a_singular_derivative() {
    for (h, v0) in [(4.40625, 0.609375), (3.46875, 0.515625), (4.96875, 0.609375)] {
        let f = |v: f64| v - v * v;
        let equation = |h: f64, v: f64| {
            let d = (v - v0) / h;
            d - f(v0) + (1.0 - h * (1.0 - 2.0 * v)) * (d - f(v))
        };
        let mut branch = v0;
        for piece in 1..=4000 {
            let h = h * f64::from(piece) / 4000.0;
            for _ in 0..6 {
                let slope = (equation(h, branch + 1e-6) - equation(h, branch - 1e-6)) / 2e-6;
                branch -= equation(h, branch) / slope;
            }
        }
        let v1 =
            one_step(&mut method_i(field_of(Logistic)).expect("usable"), h, v0, 0.0).expect("the branch has no fold").0;
        // Newton's iteration with a slope good to 1e-9 leaves next to nothing.
        assert_abs_diff_eq!(v1, branch, epsilon = 1e-12);
        assert!(v1 > 0.9, "{v1}");
    }
}

/// Logistic growth with large steps: F = v₁ − v₀ − h v₁(1 − v₁) has a root on either side of 0, and Newton's iteration from
/// v₀ contracts to the negative one where 1 − h + 2 h v₀ < 0. The branch from h = 0 is the positive one.
#[test]
fn implicit_steps_keep_to_the_branch_beyond_a_singular_derivative_at_the_start() {
    for (h, v0) in [(5.9375, 0.03125), (3.0, 0.01), (6.0, 0.3), (1.5, 0.1), (100.0, 0.2)] {
        let mut method = RungeKutta::new(field_of(Logistic), Tableau::implicit_euler()).expect("usable");
        let v1 = one_step(&mut method, h, v0, 0.0).expect("the branch has no fold").0;
        let root = (h - 1.0 + ((h - 1.0).powi(2) + 4.0 * h * v0).sqrt()) / (2.0 * h);
        assert_abs_diff_eq!(v1, root, epsilon = 8.0 * f64::EPSILON);
    }
    // The state at rest is unstable, and still a solution.
    let mut method = RungeKutta::new(field_of(Logistic), Tableau::implicit_euler()).expect("usable");
    assert_eq!(one_step(&mut method, 6.0, 0.0, 0.0).expect("a state at rest").0, 0.0);
}

/// A step that decays multiplies by 1/(1 − h + h²/2): below 2.2·10⁻³⁰⁸ numbers lose their digits, and are as good as 0.
/// Quadratic drag beside an unknown that moves at a constant rate.
#[test]
fn an_unknown_is_right_to_roundings_of_the_largest_one() {
    let one = || field_of!(1, |_t, v, dv| dv[0] = -v[0] * v[0]);
    let two = || {
        field_of!(2, |_t, v, dv| {
            dv[0] = -v[0] * v[0];
            dv[1] = T::from(1.0);
        })
    };
    for (h, size) in [0.01, 0.1, 0.5].into_iter().flat_map(|h| [1.0, 1e6, 1e12].map(|size| (h, size))) {
        let (mut alone, mut beside, mut p) = ([1.0], [1.0, size], [0.0; 2]);
        method_i(one()).expect("usable").step(0.0, h, &mut alone, &mut p[..1]).expect("a root");
        method_i(two()).expect("usable").step(0.0, h, &mut beside, &mut p).expect("a root");
        // The last increment is four roundings at most, and leaves less than itself.
        assert_abs_diff_eq!(alone[0], beside[0], epsilon = 4.0 * f64::EPSILON * (1.0 + size));
    }
}

#[test]
fn a_solution_decays_through_all_doubles() {
    let h = 2.4;
    let mut method = method_i(field_of(Logistic)).expect("usable");
    let (mut v, mut p) = ([1e-3], [0.0]);
    for step in 0..2500 {
        method.step(0.0, h, &mut v, &mut p).unwrap_or_else(|error| panic!("step {step} from {v:?}: {error}"));
    }
    assert!(v[0].abs() < 4.0 * f64::MIN_POSITIVE, "{v:?}");
}

#[test]
fn method_ii_takes_no_step_that_stands_still_where_the_solution_does_not() {
    let logistic = |v0: f64, t: f64| 1.0 / (1.0 + (1.0 / v0 - 1.0) * (-t).exp());
    let h = 0.1;
    let (mut solved, mut refused) = (0, 0);
    for a in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 3e-9, 1e-9, 3e-10, 1e-10, 1e-12, 1e-14, 0.0] {
        for (v0, exact) in [0.5 - a, 0.5 + a].map(|v0| (v0, logistic(v0, h))).into_iter().chain([a, -a].map(|v0| {
            // v̇ = cos v: v = arcsin(tanh(t + artanh(sin v₀))).
            (v0, (h + v0.sin().atanh()).tanh().asin())
        })) {
            let is_logistic = v0 > 0.25;
            let mut v = [v0];
            let result = if is_logistic {
                let field = field_of!(1, |_t, v, dv| dv[0] = v[0] * (-v[0] + 1.0));
                method_ii(field).expect("usable").step(0.0, h, &mut v, &mut [0.0])
            } else {
                let field = field_of!(1, |_t, v, dv| dv[0] = v[0].cos());
                method_ii(field).expect("usable").step(0.0, h, &mut v, &mut [0.0])
            };
            match result {
                // One step of order 2.
                Ok(()) => assert!((v[0] - exact).abs() < h.powi(3), "{v0:e}: {} for {exact}", v[0]),
                Err(StepError::Solve { source: SolveError::Singular | SolveError::BranchLost { .. }, .. }) => {
                    refused += 1
                }
                Err(other) => panic!("{v0:e}: {other}"),
            }
            solved += usize::from(v[0] != v0);
        }
    }
    assert!(solved >= 12 && refused >= 20, "{solved} {refused}");
}

/// By e^{−z}, and by its Padé approximant (1 − z/3)/(1 + 2z/3 + z²/6): what is left of h f₀ is a small part of it, and no rest.
#[test]
fn closures_fitted_to_a_decay_take_it_in_steps_of_any_length() {
    let exact: fn(f64) -> f64 = |z| (-z).exp();
    let pade: fn(f64) -> f64 = |z| (1.0 - z / 3.0) / (1.0 + 2.0 * z / 3.0 + z * z / 6.0);
    for (closure, amplification) in [(Linear::fitted(1.0), exact), (Linear::fitted_pade(1.0), pade)] {
        let closure = closure.expect("positive");
        let field = field_of!(1, |_t, v, dv| dv[0] = -v[0]);
        let mut method = least_squares(field, closure).expect("usable");
        for z in (0..30).map(|k| 10_f64.powi(k)) {
            let mut v = [1.0_f64];
            method.step(0.0, z, &mut v, &mut [0.0]).unwrap_or_else(|error| panic!("{z:e}: {error}"));
            // A few roundings of v₀.
            assert_abs_diff_eq!(v[0], amplification(z), epsilon = 8.0 * f64::EPSILON);
        }
    }
}

/// At ½, where J₀ = 0, a solver that works with products sees no gradient.
#[test]
fn method_ii_by_products_takes_no_step_that_stands_still_where_the_solution_does_not() {
    let field = field_of!(1, |_t, v, dv| dv[0] = v[0] * (-v[0] + 1.0));
    let mut method = LeastSquaresStep::with_solver(field, Linear::METHOD_II, Iterative::new(Unscaled)).expect("fits");
    let mut v = [0.5];
    let found = method.step(0.0, 0.1, &mut v, &mut [0.0]);
    let is_refused = matches!(found, Err(StepError::Solve { source: SolveError::Singular, .. }));
    assert!(is_refused && v == [0.5], "{found:?} at {v:?}");
}

#[test]
fn method_ii_rests_where_the_solution_does() {
    let mut steady = method_ii(field_of!(1, |_t, v, dv| dv[0] = (-v[0] + 1.0 / 3.0) * 1e9)).expect("usable");
    let mut v = [1.0 / 3.0];
    steady.step(0.0, 1.0, &mut v, &mut [0.0]).expect("a steady state, stiff");
    assert_eq!(v, [1.0 / 3.0]);
    // f₀ = 1 and f₁ = −1: the rates of the ends cancel.
    let mut turning = method_ii(field_of!(1, |t, v, dv| dv[0] = -v[0] + (2.0 - 2.0 * t))).expect("usable");
    let mut v = [1.0];
    turning.step(0.0, 1.0, &mut v, &mut [0.0]).expect("a regular step");
    approx::assert_abs_diff_eq!(v[0], 1.0, epsilon = 4.0 * f64::EPSILON);
}

/// Steps of a linear field that does not depend on time are one pass over what is known of their size.
#[test]
fn a_step_of_another_size_or_with_a_momentum_is_what_a_new_method_makes_of_it() {
    let field = || Autonomous(Line::new(9, 0.0, Walls::Dirichlet));
    let start: Vec<f64> = (0..9).map(|i| (0.5 * f64::from(i)).sin()).collect();
    let mut used = method_i(field()).expect("usable");
    let (mut v, mut p) = (start.clone(), vec![0.0; 9]);
    for (k, h) in [0.1, 0.1, 0.1, 0.05, 0.05, 0.1, 0.1].into_iter().enumerate() {
        let (mut w, mut q) = (v.clone(), vec![0.0; 9]);
        p[3] = if k == 2 { 1.0 } else { 0.0 };
        used.step(0.0, h, &mut v, &mut p).expect("linear");
        method_i(field()).expect("usable").step(0.0, h, &mut w, &mut q).expect("linear");
        // Two ways to eliminate: |v| < 1 by 1e-14 and more for a matrix of condition (1 + 4 h/dx²)².
        v.iter().zip(&w).for_each(|(v, w)| assert!((v - w).abs() < 1e-13, "step {k}: {v} {w}"));
        assert_eq!(p, [0.0; 9], "Method I ends with p = 0");
    }
    assert_eq!(lsvi::Integrator::work(&used).steps, 7);
}

/// What is kept of a step of a linear field is kept for its size alone, however close another one is.
#[test]
fn a_linear_step_of_nearly_the_size_of_the_last_is_that_of_a_new_method() {
    let line = |peclet| Line::new(9, peclet, Walls::Dirichlet);
    type Made<'a> = &'a dyn Fn() -> Box<dyn OneStep>;
    let methods: [(&str, Made); 3] = [
        ("by augmented factors", &|| {
            Box::new(By::Augmented.method_i(with_structure(Structure::Dense, line(3.0))).expect("fits"))
        }),
        ("by twisted factors", &|| Box::new(method_i(line(3.0)).expect("usable"))),
        ("in one pass", &|| Box::new(method_i(Autonomous(line(0.0))).expect("usable"))),
    ];
    for (name, method) in methods {
        let mut used = method();
        let (mut v, mut p): (Vec<f64>, _) = ((0..9).map(|i| (0.5 * f64::from(i)).sin()).collect(), [0.0; 9]);
        for h in [0.1, 0.1 * (1.0 + 1e-4), 0.1, 0.1 * (1.0 + 1e-9), 0.1] {
            let (mut w, mut q) = (v.clone(), [0.0; 9]);
            used.step(0.3, h, &mut v, &mut p).expect("linear");
            method().step(0.3, h, &mut w, &mut q).expect("linear");
            assert_eq!(v, w, "{name}, h = {h}");
        }
    }
}

/// Unknowns on a ring with damping, products and a force that depends on time.
struct Ring(usize);
impl FieldFn for Ring {
    fn dim(&self) -> usize {
        self.0
    }
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
        for i in 0..self.0 {
            dv[i] =
                v[(i + 1) % self.0] * v[i] - v[i] * (1.0 + i as f64) + v[(i + 2) % self.0] * 0.3 + (t + i as f64).cos();
        }
    }
}

/// Dense equations of few unknowns are added up on the stack, in sizes of their own.
#[test]
fn a_step_is_that_of_the_trapezoidal_lagrangian_for_every_number_of_unknowns() {
    // What Method I starts with is its own end, and others take what they are given.
    let closures = [(1.0, 0.0, 0.0), (-1.0, 1.0, 0.02), (2.0, 1.0, 0.02)];
    for (n, (alpha, beta, p0)) in (1..=7).flat_map(|n| closures.map(|closure| (n, closure))) {
        let closure = || Linear::new(alpha, beta).expect("usable");
        let v0: Vec<f64> = (0..n).map(|i| 0.4 + 0.1 * (i as f64).sin()).collect();
        let step = |method: &mut dyn OneStep| -> (Vec<f64>, Vec<f64>) {
            let (mut v, mut p) = (v0.clone(), vec![p0; n]);
            method.step(0.3, 0.1, &mut v, &mut p).expect("a short step");
            (v, p)
        };
        let lagrangian = LeastSquares::new(field_of(Ring(n))).expect("usable");
        let (v, p) = step(&mut LeastSquaresStep::new(field_of(Ring(n)), closure()).expect("usable"));
        let (w, q) = step(&mut Variational::new(Trapezoidal::new(lagrangian), closure()));
        for (a, b) in v.iter().zip(&w).chain(p.iter().zip(&q)) {
            // |v| < 1, to the tolerance of Newton's method, and p is a difference of v over h.
            assert!((a - b).abs() <= 1e-13, "{n} unknowns, {:?}: {v:?} {w:?}, {p:?} {q:?}", (alpha, beta));
        }
    }
}

/// Reactions v_a → v_c or v_a + v_b → v_c + v_b with rates from 0.01 to 100, in which the sum of all v is conserved, so that f_v is singular
/// everywhere; entries are sums of terms, with roundings of their own.
struct Reactions {
    dim: usize,
    seed: u64,
}

/// Numbers from 0 to 1, by Knuth's multiplier.
fn numbers(mut seed: u64) -> impl FnMut() -> f64 {
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 * 2.0_f64.powi(-53)
    }
}

impl FieldFn for Reactions {
    fn dim(&self) -> usize {
        self.dim
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        let mut number = numbers(self.seed);
        dv.fill(T::from(0.0));
        for _ in 0..2 * self.dim {
            let [a, b, c] = [(); 3].map(|()| (number() * self.dim as f64) as usize);
            let (rate, is_of_two) = (10.0_f64.powf(4.0 * number() - 2.0), number() < 0.6);
            let flow = if is_of_two { v[a] * v[b] * rate } else { v[a] * rate };
            dv[a] -= flow;
            dv[c] += flow;
        }
    }
}

#[test]
fn method_ii_takes_no_step_where_a_sum_is_conserved() {
    let mut refused = 0;
    for seed in 1..400 {
        let dim = 2 + (seed % 4) as usize;
        let mut number = numbers(seed);
        let v0: Vec<f64> = (0..dim).map(|i| if seed % 3 == 0 && i > 0 { 0.0 } else { 0.2 + number() }).collect();
        let mut method = method_ii(field_of(Reactions { dim, seed: 7919 * seed })).expect("usable");
        let mut v = v0.clone();
        match method.step(0.0, 1e-3, &mut v, &mut vec![0.0; dim]) {
            Ok(()) => assert!(v.iter().zip(&v0).all(|(a, b)| (a - b).abs() < 1e-8), "{seed}: {v0:?} to {v:?}"),
            Err(StepError::Solve { source: SolveError::Singular, .. }) => refused += 1,
            // Roundings of terms that cancel make J regular.
            Err(StepError::Solve { source: SolveError::BranchLost { .. }, .. }) => {}
            Err(other) => panic!("{seed}: {other}"),
        }
    }
    assert!(refused > 300, "{refused}");
}

/// Neither a large component that hardly moves nor a short step makes a rest of a reaction.
#[test]
fn what_conserves_a_sum_is_refused_beside_a_large_component_and_in_short_steps() {
    for (idle, h) in [(1e5, 1e-3), (300.0, 1e-5), (1.0, 1e-7), (1.0, 1e-9)] {
        let field = field_of!(4, |_t, v, dv| {
            let (forth, back) = (v[0] * 0.04, v[1] * v[2] * 1e4);
            let on = v[1] * v[1] * 3e7;
            dv[0] = back - forth;
            dv[1] = forth - back - on;
            dv[2] = on;
            dv[3] = v[3] * -1e-9;
        });
        let mut v = [1.0, 1e-5, 0.1, idle];
        let found = method_ii(field).expect("usable").step(0.0, h, &mut v, &mut [0.0; 4]);
        let is_refused = matches!(found, Err(StepError::Solve { source: SolveError::Singular, .. }));
        assert!(is_refused, "{idle}, {h}: {found:?} at {v:?}");
    }
}

/// Components and rates in unlike units are no singular matrix.
#[test]
fn method_ii_steps_where_units_are_unlike() {
    let field = field_of!(2, |_t, v, dv| {
        dv[0] = v[0] * v[0] * -1e-9 + v[1] * 1e-12;
        dv[1] = v[1] * v[1] * -1e3;
    });
    let mut v = [1e8, 1e-3];
    method_ii(field).expect("usable").step(0.0, 0.1, &mut v, &mut [0.0; 2]).expect("regular");
    // v₀/(1 + c t v₀), but for what v₁ adds.
    let exact = [1e8 / (1.0 + 1e-9 * 0.1 * 1e8), 1e-3 / (1.0 + 1e3 * 0.1 * 1e-3)];
    assert!(v.iter().zip(exact).all(|(v, exact)| (v / exact - 1.0).abs() < 1e-3), "{v:?}");
}
