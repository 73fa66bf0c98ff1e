//! What the counters of work count, against calls that are counted themselves; and that nothing is kept which does not fit.

use crate::fields::{Line, Unscaled, Walls, with_structure};
use crate::separable;
use crate::systems::HenonHeiles;
use lsvi::classic::{Bdf2, RungeKutta, Tableau};
use lsvi::closure::Linear;
use lsvi::discrete::{DiscreteLegendre, Galerkin, Interval, MomentumWeights, Trapezoidal};
use lsvi::solver::{Augmented, Iterative, StepSolver};
use lsvi::{
    AutoLagrangian, Factored, HessianWeights, InputError, Integrator, Jacobian, Lagrangian, LagrangianFn, LeastSquares,
    LeastSquaresStep, Mass, OneStep, Preconditioner, Scalar, SolveError, State, StepOperator, Structure, Trajectory,
    VectorField, Window, field, position_momentum,
};
use std::cell::{Cell, RefCell};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

struct Separable(bool);

impl LagrangianFn for Separable {
    fn dim(&self) -> usize {
        2
    }
    fn is_separable(&self) -> bool {
        self.0
    }
    fn lagrangian<T: Scalar>(&self, t: T, q: &[T], v: &[T]) -> T {
        HenonHeiles.lagrangian(t, q, v)
    }
}

/// A Lagrangian that counts its forces, gradients and second derivatives.
struct Counting<L> {
    l: L,
    forces: Cell<u64>,
    gradients: Cell<u64>,
    hessians: Cell<u64>,
}

impl<L> Counting<L> {
    fn new(l: L) -> Self {
        Self { l, forces: Cell::default(), gradients: Cell::default(), hessians: Cell::default() }
    }
}

impl<L: Lagrangian> Lagrangian for Counting<L> {
    fn dim(&self) -> usize {
        self.l.dim()
    }
    fn is_separable(&self) -> bool {
        self.l.is_separable()
    }
    fn value(&self, t: f64, q: &[f64], v: &[f64]) -> f64 {
        self.l.value(t, q, v)
    }
    fn gradient(&self, t: f64, q: &[f64], v: &[f64], dl_dq: &mut [f64], dl_dv: &mut [f64]) {
        self.gradients.set(self.gradients.get() + 1);
        self.l.gradient(t, q, v, dl_dq, dl_dv);
    }
    fn gradient_q(&self, t: f64, q: &[f64], v: &[f64], dl_dq: &mut [f64], work: &mut [f64]) {
        self.forces.set(self.forces.get() + 1);
        self.l.gradient_q(t, q, v, dl_dq, work);
    }
    fn add_hessian(&self, t: f64, q: &[f64], v: &[f64], c: HessianWeights, out: &mut Jacobian) {
        self.hessians.set(self.hessians.get() + 1);
        self.l.add_hessian(t, q, v, c, out);
    }
}

#[test]
fn steps_of_a_separable_lagrangian_count_every_evaluation_of_its_forces() {
    let l = Counting::new(AutoLagrangian::new(Separable(true)));
    for nodes in [1, 2, 4] {
        l.forces.set(0);
        let mut method = position_momentum(Galerkin::gauss(&l, nodes).expect("s ≥ 1"));
        let (mut q, mut p) = ([0.1, 0.2], [0.3, -0.1]);
        (0..50).for_each(|k| method.step(f64::from(k) * 0.05, 0.05, &mut q, &mut p).expect("bounded"));
        // At q₀ the forces of the first and the last node tell those of the others, as they do not depend on time.
        let (work, spared) = (method.work(), nodes.saturating_sub(2) as u64);
        assert_eq!(l.forces.get(), nodes as u64 * work.residuals - spared * work.steps, "{nodes} nodes");
    }
}

/// A step is an evaluation for its start and one for each iteration: fewer than 2.5 a step, on one and a half orbits of eccentricity 0.6, are one
/// iteration in more than half of the steps.
#[test]
fn most_steps_of_one_or_two_nodes_take_one_iteration() {
    for nodes in [1, 2] {
        let mut method =
            position_momentum(Galerkin::gauss(AutoLagrangian::new(separable::Kepler), nodes).expect("s ≥ 1"));
        let (mut q, mut p) = ([0.4, 0.0], [0.0, 2.0]);
        (0..1000).for_each(|k| method.step(f64::from(k) * 0.01, 0.01, &mut q, &mut p).expect("solvable"));
        assert!(method.work().residuals < 2500, "{nodes}: {:?}", method.work());
    }
}

/// 600 steps have looks in steps 1, 3, 7, …, 511. The first one takes second derivatives as well, those that are M and two at each of three places.
#[test]
fn looks_at_what_a_separable_lagrangian_declares_take_two_gradients_each() {
    let l = Counting::new(AutoLagrangian::new(separable::Separable(separable::Swaying)));
    let mut method = position_momentum(Trapezoidal::new(&l));
    let (mut q, mut p) = ([0.1, 0.2], [0.3, -0.7]);
    (0..600).for_each(|k| method.step(f64::from(k) * 0.05, 0.05, &mut q, &mut p).expect("explicit"));
    assert_eq!((l.gradients.get(), l.hessians.get()), (2 * 9, 1 + 2 * 3));
}

#[test]
fn the_first_steps_of_another_size_cost_what_they_cost_a_new_method() {
    for (is_separable, h) in [(true, 1e-3), (true, 0.105), (false, 1e-3), (false, 0.105)] {
        let l = AutoLagrangian::new(Separable(is_separable));
        let make = || position_momentum(Galerkin::gauss(&l, 2).expect("s ≥ 1"));
        let (mut used, mut fresh) = (make(), make());
        let (mut q, mut p) = ([0.1, 0.2], [0.3, -0.1]);
        (0..20).for_each(|k| used.step(f64::from(k) * 0.1, 0.1, &mut q, &mut p).expect("bounded"));
        let (mut r, mut s) = (q, p);
        for k in 0..3 {
            let (t, before) = (2.0 + f64::from(k) * h, [used.work().residuals, fresh.work().residuals]);
            used.step(t, h, &mut q, &mut p).expect("bounded");
            fresh.step(t, h, &mut r, &mut s).expect("bounded");
            let cost = [used.work().residuals - before[0], fresh.work().residuals - before[1]];
            assert_eq!(cost[0], cost[1], "step {k} of {h}, separable: {is_separable}");
        }
    }
}

/// Newton's first increment solves a linear stage, and its second one tells so; one residual more shows the tangent of the branch, and
/// another that the stage is linear along it, where that is much longer than the step.
#[test]
fn the_stages_of_a_linear_field_take_two_increments_however_fast_its_rate_changes() {
    for (tableau, stages) in [(Tableau::implicit_euler(), 1), (Tableau::implicit_midpoint(), 1), (Tableau::sdirk2(), 2)]
    {
        let fading = field!(1, |t, v, dv| dv[0] = v[0] * -(1.0 + 100.0 * t));
        let mut method = RungeKutta::new(fading, tableau.clone()).expect("usable");
        method.step(0.0, 1.0, &mut [1.0], &mut []).expect("linear");
        let work = method.work();
        assert_eq!(work.factorizations, 2 * stages, "{tableau:?}");
        assert!((2 * stages + 1..=4 * stages).contains(&work.residuals), "{tableau:?}: {work:?}");
    }
}

type Coefficient = fn(f64, f64) -> f64;

/// v̇ = A v + g with A = [[−1, 2], [−3, −c(t, v₂)]], which may say that it is linear.
struct Promise {
    is_given: bool,
    c: Coefficient,
}

impl VectorField for Promise {
    fn dim(&self) -> usize {
        2
    }
    fn is_linear(&self) -> bool {
        self.is_given
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        dv[0] = 2.0 * v[1] - v[0] + t.cos();
        dv[1] = -3.0 * v[0] - (self.c)(t, v[1]) * v[1];
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        [(0, 0, -1.0), (0, 1, 2.0), (1, 0, -3.0)].into_iter().for_each(|(i, j, x)| out.add(i, j, scale * x));
        // By differences: c v₂ is quadratic in v₂ at most.
        let product = |x: f64| (self.c)(t, x) * x;
        out.add(1, 1, -scale * 0.5 * (product(v[1] + 1.0) - product(v[1] - 1.0)));
    }
}

#[test]
fn the_stages_of_a_field_that_says_that_it_is_linear_keep_their_factors_while_it_is() {
    for (name, tableau) in [
        ("implicit Euler", Tableau::implicit_euler()),
        ("midpoint", Tableau::implicit_midpoint()),
        ("trapezoidal", Tableau::trapezoidal()),
        ("sdirk2", Tableau::sdirk2()),
        ("tr-bdf2", Tableau::tr_bdf2()),
    ] {
        let cases: [(Coefficient, bool); 4] = [
            (|_, _| 4.0, true),
            // What does not keep its promise is solved as if it had given none.
            (|t, _| if t > 1.0 { 5.0 } else { 4.0 }, false),
            (|t, _| 4.0 + t, false),
            (|_, v| 4.0 + v, false),
        ];
        for (case, (c, is_kept)) in cases.into_iter().enumerate() {
            let run = |is_given| {
                let mut method = RungeKutta::new(Promise { is_given, c }, tableau.clone()).expect("usable");
                let mut v = [1.0, 2.0];
                (0..20).for_each(|k| method.step(0.1 * f64::from(k), 0.1, &mut v, &mut []).expect("solvable"));
                (v, method.work())
            };
            let ((promised, work), (plain, other)) = (run(true), run(false));
            assert!(
                promised.iter().zip(plain).all(|(a, b)| (a - b).abs() < 1e-14),
                "{name} {case}: {promised:?} {plain:?}"
            );
            let is_once = work.factorizations == 1 && work.residuals < other.residuals;
            assert_eq!((work.steps, is_once), (20, is_kept), "{name} {case}: {work:?} {other:?}");
        }
    }
    let start = State::new(0.0, vec![1.0, 2.0]);
    let method = Bdf2::new(Promise { is_given: true, c: |_, _| 4.0 }).expect("usable");
    let mut run = Trajectory::new(method, start, 0.125, 2.0).expect("a grid");
    while run.step().expect("solvable").is_some() {}
    assert_eq!((run.work().steps, run.work().factorizations), (16, 2), "one is of the first step");
}

/// A field that counts its Jacobians.
struct Jacobians<F>(F, Cell<usize>);

impl<F: VectorField> VectorField for Jacobians<F> {
    fn dim(&self) -> usize {
        self.0.dim()
    }
    fn structure(&self) -> Structure {
        self.0.structure()
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.0.rhs(t, v, dv);
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        self.1.set(self.1.get() + 1);
        self.0.add_jacobian(t, v, scale, out);
    }
    fn add_curvature(&self, t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        self.0.add_curvature(t, v, w, scale, out);
    }
}

/// The four blocks of second derivatives have J in common, and ∂²L/∂v̇² has none.
#[test]
fn a_galerkin_method_evaluates_the_jacobian_once_for_each_node() {
    for degree in 1..=3 {
        let field = Jacobians(
            field!(2, |_t, v, dv| {
                dv[0] = v[1] * v[0];
                dv[1] = -v[0];
            }),
            Cell::new(0),
        );
        let l = LeastSquares::new(&field).expect("usable");
        let mut discrete = Galerkin::lobatto(&l, degree).expect("s ≥ 1");
        let mut out = Jacobian::with_structure(2 * degree, &discrete.structure());
        let before = field.1.get();
        let at = Interval { start: 0.0, h: 0.1 };
        let both = MomentumWeights { alpha: 1.0, beta: 1.0 };
        discrete.add_derivative(at, &[1.0, 0.5], &vec![0.7; 2 * degree], both, &mut out);
        assert_eq!(field.1.get() - before, degree + 1, "degree {degree}");
        let c = HessianWeights { vv: 1.0, ..Default::default() };
        l.add_hessian(0.0, &[1.0, 0.5], &[0.0; 2], c, &mut Jacobian::zeros(2));
        assert_eq!(field.1.get() - before, degree + 1, "the mass");
    }
}

/// A preconditioner that counts how often it is set up.
struct Counted(Factored, Arc<AtomicU64>);

impl Preconditioner for Counted {
    fn check(&self, structure: &Structure, mass: &Mass) -> Result<(), InputError> {
        self.0.check(structure, mass)
    }
    fn prepare(&mut self, b: &StepOperator<'_>) -> Result<(), SolveError> {
        self.1.fetch_add(1, Relaxed);
        self.0.prepare(b)
    }
    fn solve(&mut self, x: &mut [f64]) {
        self.0.solve(x);
    }
    fn solve_transpose(&mut self, x: &mut [f64]) {
        self.0.solve_transpose(x);
    }
}

/// Diffusion that is ten thousand times as fast from t = 1 on.
struct Faster(Line);

impl Faster {
    fn rate(t: f64) -> f64 {
        if t < 1.0 { 1.0 } else { 1e4 }
    }
}

impl VectorField for Faster {
    fn dim(&self) -> usize {
        self.0.dim()
    }
    fn structure(&self) -> Structure {
        self.0.structure()
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.0.rhs(t, v, dv);
        dv.iter_mut().for_each(|x| *x *= Self::rate(t));
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        self.0.add_jacobian(t, v, scale * Self::rate(t), out);
    }
    fn add_curvature(&self, _t: f64, _v: &[f64], _w: &[f64], _scale: f64, _out: &mut Jacobian) {}
}

#[test]
fn a_preconditioner_that_has_become_slow_is_renewed_at_the_same_step_size() {
    let (n, h, prepared) = (30, 1e-3, Arc::new(AtomicU64::new(0)));
    let solver = Iterative::new(Counted(Factored::default(), prepared.clone()));
    let field = Faster(Line::new(n, 0.0, Walls::Dirichlet));
    let mut method = RungeKutta::with_solver(field, Tableau::implicit_euler(), solver).expect("usable");
    let mut v: Vec<f64> = (0..n).map(|i| (i as f64 + 1.0).sin()).collect();
    let mut run = |t: f64| {
        let before = method.work().inner;
        for _ in 0..5 {
            method.step(t, h, &mut v, &mut []).expect("linear");
        }
        (prepared.load(Relaxed), method.work().inner - before)
    };
    let (first, few) = run(0.0);
    let (second, many) = run(2.0);
    let (third, again) = run(2.0);
    assert_eq!((first, second, third), (1, 2, 2));
    assert!(many > few && again <= few, "{few}, {many} and {again} iterations");
}

/// A solver that counts the matrices it takes up and the systems it solves.
#[derive(Debug)]
struct Tally(Augmented, Arc<[AtomicU64; 2]>);

impl StepSolver for Tally {
    fn check(&self, structure: &Structure, mass: &Mass) -> Result<(), InputError> {
        self.0.check(structure, mass)
    }
    fn prepare(&mut self, b: &StepOperator<'_>) -> Result<(), SolveError> {
        self.1[0].fetch_add(1, Relaxed);
        self.0.prepare(b)
    }
    fn solve_stage(&mut self, b: &StepOperator<'_>, x: &mut [f64], tolerance: f64) -> Result<u64, SolveError> {
        self.0.solve_stage(b, x, tolerance)
    }
    fn solve_normal(
        &mut self,
        b: &StepOperator<'_>,
        damping: f64,
        a: Option<&[f64]>,
        x: &mut [f64],
        tolerance: f64,
    ) -> Result<u64, SolveError> {
        self.1[1].fetch_add(1, Relaxed);
        self.0.solve_normal(b, damping, a, x, tolerance)
    }
}

#[test]
fn a_system_solved_again_with_more_damping_is_a_factorization_more() {
    let counts = Arc::new([AtomicU64::new(0), AtomicU64::new(0)]);
    let solver = Tally(Augmented::new(), counts.clone());
    // Far from the bend of f, whose linearisation there leads beyond it.
    let bend = with_structure(
        Structure::Banded { lower: 0, upper: 0 },
        field!(1, |_t, v, dv| dv[0] = v[0] * -7.5 / (v[0] * v[0] * 25.0 + 1.0).sqrt()),
    );
    let mut method = LeastSquaresStep::with_solver(bend, Linear::METHOD_I, solver).expect("fits");
    method.step(0.0, 10.0, &mut [3.0], &mut [0.0]).expect("convergent");
    let [taken_up, solved] = [0, 1].map(|i| counts[i].load(Relaxed));
    assert!(solved > taken_up, "{solved} systems of {taken_up} matrices: nothing was damped");
    assert_eq!(method.work().factorizations, solved);
}

/// A discretisation that counts the equations it is asked for, and how often for their derivatives.
struct Asked<D>(D, Arc<[AtomicU64; 2]>);

impl<D: DiscreteLegendre> DiscreteLegendre for Asked<D> {
    fn dim(&self) -> usize {
        self.0.dim()
    }
    fn interior(&self) -> usize {
        self.0.interior()
    }
    fn structure(&self) -> Structure {
        self.0.structure()
    }
    fn predict(&mut self, at: Interval, q0: &[f64], p0: &[f64], x: &mut [f64]) -> Result<(), SolveError> {
        self.0.predict(at, q0, p0, x)
    }
    fn momentum(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, out: &mut [f64]) {
        self.0.momentum(at, q0, x, w, out);
    }
    fn equations(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, out: &mut [f64]) {
        self.1[0].fetch_add(1, Relaxed);
        self.0.equations(at, q0, x, w, out);
    }
    fn add_derivative(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, out: &mut Jacobian) {
        // Of a momentum at the start it is part of the derivatives of the step before.
        self.1[1].fetch_add(u64::from(w.beta != 0.0), Relaxed);
        self.0.add_derivative(at, q0, x, w, out);
    }
    fn add_start_derivative(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, out: &mut Jacobian) {
        self.0.add_start_derivative(at, q0, x, w, out);
    }
}

#[test]
fn a_window_counts_the_equations_and_the_factors_of_each_of_its_steps() {
    let drag = field!(1, |_t, v, dv| dv[0] = -v[0] - v[0] * v[0] * 0.1);
    for length in [1, 4, 10_u32] {
        let asked = Arc::new([AtomicU64::new(0), AtomicU64::new(0)]);
        let discrete = Asked(Trapezoidal::new(LeastSquares::new(&drag).expect("usable")), asked.clone());
        let window = Window::new(discrete, length as usize).expect("a length");
        let h = 0.005;
        let mut run =
            Trajectory::new(window, State::new(0.0, vec![1.0]), h, 2.0 * f64::from(length) * h).expect("valid");
        let mut steps = || {
            for _ in 0..length {
                run.step().expect("solvable");
            }
            let [equations, derivatives] = [0, 1].map(|i| asked[i].load(Relaxed));
            [(equations, run.work().residuals), (derivatives, run.work().factorizations)]
        };
        // The first window asks for the limits for h → 0 besides.
        let (before, after) = (steps(), steps());
        for (before, after) in before.into_iter().zip(after) {
            assert_eq!(after.0 - before.0, after.1 - before.1, "windows of {length}");
            assert!(after.1 > before.1, "windows of {length}");
        }
    }
}

/// A preconditioner that notes the time, the length and the state for which it is set up.
struct Noting(Factored, Arc<std::sync::Mutex<Vec<(f64, f64, f64)>>>);

impl Preconditioner for Noting {
    fn prepare(&mut self, b: &StepOperator<'_>) -> Result<(), SolveError> {
        self.1.lock().expect("one thread").push((b.t(), b.s(), b.v()[0]));
        self.0.prepare(b)
    }
    fn solve(&mut self, x: &mut [f64]) {
        self.0.solve(x);
    }
    fn solve_transpose(&mut self, x: &mut [f64]) {
        self.0.solve_transpose(x);
    }
}

#[test]
fn systems_are_linearised_at_the_time_of_their_stage() {
    let notes = Arc::new(std::sync::Mutex::new(Vec::new()));
    // In a box, as a choice among several is.
    let solver =
        || Iterative::new(Box::new(Noting(Factored::default(), notes.clone())) as Box<dyn Preconditioner + Send>);
    let field =
        || with_structure(Structure::Banded { lower: 0, upper: 0 }, field!(1, |t, v, dv| dv[0] = v[0] * v[0] * -t));
    let implicit = |tableau| RungeKutta::with_solver(field(), tableau, solver()).expect("usable");
    let first = |method: &mut dyn OneStep| {
        method.step(2.0, 0.5, &mut [1.0], &mut [0.0]).expect("solvable");
        let (t, s, v) = std::mem::take(&mut *notes.lock().expect("one thread"))[0];
        assert!(v > 0.1 && v <= 1.0, "{v}");
        (t, s)
    };
    assert_eq!(first(&mut implicit(Tableau::implicit_euler())), (2.5, 0.5));
    assert_eq!(first(&mut implicit(Tableau::implicit_midpoint())), (2.25, 0.25));
    assert_eq!(first(&mut implicit(Tableau::trapezoidal())), (2.5, 0.25));
    for closure in [Linear::METHOD_I, Linear::METHOD_II] {
        let mut method = LeastSquaresStep::with_solver(field(), closure, solver()).expect("usable");
        assert_eq!(first(&mut method), (2.5, 0.5));
    }
    let mut run = lsvi::classic::Bdf2::with_solver(field(), solver)
        .map(|method| Trajectory::new(method, State::new(2.0, vec![1.0]), 0.5, 3.0).expect("valid"));
    let run = run.as_mut().expect("usable");
    while run.step().expect("solvable").is_some() {}
    assert_eq!(notes.lock().expect("one thread").last().map(|(t, ..)| *t), Some(3.0));
}

/// A field that notes the time and the state of each derivative that it is asked for.
struct Noted<F>(Structure, F, RefCell<Vec<(f64, f64)>>);

impl<F> Noted<F> {
    fn note(&self, t: f64, v: &[f64]) -> &F {
        self.2.borrow_mut().push((t, v[0]));
        &self.1
    }
}

impl<F: VectorField> VectorField for Noted<F> {
    fn dim(&self) -> usize {
        self.1.dim()
    }
    fn structure(&self) -> Structure {
        self.0.clone()
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.1.rhs(t, v, dv);
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        self.note(t, v).add_jacobian(t, v, scale, out);
    }
    fn add_curvature(&self, t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        self.note(t, v).add_curvature(t, v, w, scale, out);
    }
    fn apply_jacobian(&self, t: f64, v: &[f64], x: &[f64], out: &mut [f64]) {
        self.note(t, v).apply_jacobian(t, v, x, out);
    }
    fn apply_transpose(&self, t: f64, v: &[f64], w: &[f64], out: &mut [f64]) {
        self.note(t, v).apply_transpose(t, v, w, out);
    }
    fn apply_curvature(&self, t: f64, v: &[f64], w: &[f64], x: &[f64], out: &mut [f64]) {
        self.note(t, v).apply_curvature(t, v, w, x, out);
    }
}

/// At the start of a step there is no other state than its own, and at the end that is a first guess; a branch is looked at on the way
/// there, and not beyond.
#[test]
fn derivatives_are_taken_at_the_time_of_their_state() {
    let (band, start, end) = (Structure::Banded { lower: 0, upper: 0 }, 2.0, 2.5);
    for (alpha, beta) in [(0.0, 1.0), (-1.0, 1.0), (0.3, 1.0), (1.0, 0.0)] {
        for structure in [Structure::Dense, band.clone(), Structure::MatrixFree] {
            for is_iterative in [false, true] {
                let field =
                    Noted(structure.clone(), field!(1, |t, v, dv| dv[0] = v[0] * v[0] * -t), RefCell::default());
                let closure = Linear::new(alpha, beta).expect("not both zero");
                let Ok(mut method) = (if is_iterative {
                    LeastSquaresStep::with_solver(&field, closure, Iterative::new(Unscaled))
                } else {
                    LeastSquaresStep::new(&field, closure)
                }) else {
                    continue;
                };
                method.step(start, end - start, &mut [1.0], &mut [0.0]).expect("solvable");
                let notes = field.2.borrow();
                assert!(notes.iter().any(|(t, _)| *t == end));
                let is_of_its_time = |(t, v): &(f64, f64)| *t > start && *t <= end || *t == start && *v == 1.0;
                assert!(notes.iter().all(is_of_its_time), "{structure:?}, ({alpha}, {beta}): {notes:?}");
                // Where increments do not contract an iterative solver is asked again for more.
                let mut later = notes.iter().skip_while(|(_, v)| *v == 1.0);
                let is_once = is_iterative || later.all(|note| *note != (end, 1.0));
                assert!(is_once, "{structure:?}, ({alpha}, {beta}): {notes:?}");
            }
        }
    }
}

#[test]
fn every_step_of_every_method_is_counted() {
    let l = AutoLagrangian::new(Separable(true));
    let start = State::new(0.0, vec![0.1, 0.2]).with_momentum(vec![0.3, -0.1]);
    let steps = |method: Box<dyn Integrator + '_>, start: State| {
        let mut run = Trajectory::new(method, start, 0.125, 1.0).expect("valid");
        let mut taken = 0;
        while run.step().expect("solvable").is_some() {
            taken += 1;
            assert_eq!(run.work().steps, taken);
        }
        taken
    };
    assert_eq!(steps(Box::new(position_momentum(Trapezoidal::new(&l))), start.clone()), 8);
    assert_eq!(steps(Box::new(Window::new(Trapezoidal::new(&l), 3).expect("a length")), start), 8);
    let field = || field!(1, |t, v, dv| dv[0] = -v[0] * v[0] - t);
    let one = State::new(0.0, vec![1.0]);
    let a = [vec![0.5]];
    let methods: [Box<dyn Integrator>; 5] = [
        Box::new(lsvi::method_i(field()).expect("usable")),
        Box::new(RungeKutta::new(field(), Tableau::sdirk2()).expect("usable")),
        Box::new(lsvi::classic::CoupledRungeKutta::new(field(), &a, &[1.0], &[0.5]).expect("usable")),
        Box::new(lsvi::classic::Bdf2::new(field()).expect("usable")),
        Box::new(
            Trajectory::new(lsvi::method_ii(field()).expect("usable"), one.clone(), 1.0, 1.0)
                .expect("valid")
                .into_parts()
                .0,
        ),
    ];
    for method in methods {
        assert_eq!(steps(method, one.clone()), 8);
    }
}
