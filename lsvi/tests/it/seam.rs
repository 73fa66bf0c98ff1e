//! Fields by products with their derivatives.

use crate::fields::{Burgers, By, Line, Products, Unscaled, Walls, with_structure};
use approx::assert_abs_diff_eq;
use lsvi::classic::{Bdf2, RungeKutta, Tableau};
use lsvi::closure::Linear;
use lsvi::discrete::Trapezoidal;
use lsvi::solver::{Augmented, Iterative};
use lsvi::{
    AutoConstraint, AutoField, AutoForce, AutoLagrangian, ConstraintFn, Factored, FieldFn, ForceFn, Forced, Grid,
    InputError, Integrator, Jacobian, LagrangianFn, LeastSquares, LeastSquaresStep, Mass, MassOperator, OneStep,
    Preconditioner, Scalar, SolveError, State, StepError, StepOperator, Structure, SystemError, Trajectory,
    VectorField, Window, Work, field, least_squares, method_i, method_ii,
};
use nalgebra::{DMatrix, DVector};

fn wave(n: usize, k: f64) -> Vec<f64> {
    (0..n).map(|i| (k * i as f64).sin() + 0.2 * (1.7 * i as f64).cos()).collect()
}

fn burgers(n: usize) -> AutoField<Burgers> {
    AutoField::new(Burgers { cells: n, viscosity: 0.05 })
}

#[test]
fn products_follow_from_the_assembled_matrices() {
    let (n, field) = (12, burgers(12));
    let (v, w, x) = (wave(n, 0.3), wave(n, 0.7), wave(n, 1.1));
    let mut jacobian = Jacobian::zeros(n);
    field.add_jacobian(0.0, &v, 1.0, &mut jacobian);
    let mut curvature = Jacobian::zeros(n);
    field.add_curvature(0.0, &v, &w, 1.0, &mut curvature);
    let (jacobian, curvature) = (jacobian.to_dense(), curvature.to_dense());
    let column = |x: &[f64]| nalgebra::DVector::from_column_slice(x);
    let mut out = vec![0.0; n];
    // A dozen roundings of terms below the largest entry.
    let bound = 16.0 * f64::EPSILON * jacobian.amax();
    field.apply_jacobian(0.0, &v, &x, &mut out);
    assert_abs_diff_eq!(column(&out), &jacobian * column(&x), epsilon = bound);
    field.apply_transpose(0.0, &v, &w, &mut out);
    assert_abs_diff_eq!(column(&out), jacobian.tr_mul(&column(&w)), epsilon = bound);
    field.apply_curvature(0.0, &v, &w, &x, &mut out);
    assert_abs_diff_eq!(column(&out), &curvature * column(&x), epsilon = bound);
    // f is quadratic, so that differences of products cost rounding only, ε/∛ε of the products.
    let products = Products::new(&field);
    products.apply_curvature(0.0, &v, &w, &x, &mut out);
    let bound = 16.0 * f64::EPSILON.powf(2.0 / 3.0) * jacobian.amax();
    assert_abs_diff_eq!(column(&out), &curvature * column(&x), epsilon = bound);
    let mut columns = Jacobian::zeros(n);
    products.add_jacobian(0.0, &v, 1.0, &mut columns);
    assert_abs_diff_eq!(columns.to_dense(), jacobian, epsilon = 16.0 * f64::EPSILON * 625.0);
    assert_eq!(products.applied.get(), n);
}

#[derive(Debug)]
struct Doubled(usize);

impl MassOperator for Doubled {
    fn dim(&self) -> usize {
        self.0
    }
    fn apply(&self, x: &[f64], out: &mut [f64]) {
        out.iter_mut().zip(x).for_each(|(o, x)| *o = 2.0 * x);
    }
    fn solve(&self, b: &mut [f64]) {
        b.iter_mut().for_each(|b| *b *= 0.5);
    }
}

/// v̇ = −v in a mass that is an operator.
struct Massive;

impl VectorField for Massive {
    fn dim(&self) -> usize {
        3
    }
    fn mass(&self) -> Mass {
        Mass::operator(Doubled(3))
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv.iter_mut().zip(v).for_each(|(d, v)| *d = -2.0 * v);
    }
    fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
        (0..3).for_each(|i| out.add(i, i, -2.0 * scale));
    }
    fn add_curvature(&self, _t: f64, _v: &[f64], _w: &[f64], _scale: f64, _out: &mut Jacobian) {}
}

#[test]
fn constructors_refuse_what_has_no_matrix() {
    let products = Products::new(burgers(6));
    let refused = [
        RungeKutta::new(&products, Tableau::implicit_euler()).err(),
        RungeKutta::new(&Massive, Tableau::implicit_euler()).err(),
        Bdf2::new(&products).err(),
        method_i(&products).err(),
        method_i(&Massive).err(),
        LeastSquares::new(&products).err(),
        LeastSquares::new(&Massive).err(),
        LeastSquaresStep::with_solver(&products, Linear::METHOD_I, Augmented::new()).err(),
    ];
    for (i, error) in refused.into_iter().enumerate() {
        assert_eq!(error, Some(InputError::System(SystemError::NotAssembled)), "{i}");
    }
    let mut window = Window::new(
        Trapezoidal::new(LeastSquares::new(with_structure(Structure::Dense, &products)).expect("dense")),
        2,
    )
    .expect("not empty");
    let mut state = State::new(0.0, wave(6, 0.3));
    window.advance(&mut state, &Grid::new(0.0, 0.1, 1.0).expect("a grid")).expect("its columns are its matrix");
    // An explicit method needs the inverse of M only.
    let mut v = [1.0; 3];
    RungeKutta::new(&Massive, Tableau::rk4()).expect("explicit").step(0.0, 0.1, &mut v, &mut []).expect("explicit");
    assert_abs_diff_eq!(v[0], (-0.1_f64).exp(), epsilon = 0.1_f64.powi(5) / 120.0);
}

/// A preconditioner of the user's: M − s ν d²/dx² by elimination in a band, without the convection.
struct Diffusion {
    viscosity: f64,
    b: Option<Band>,
    prepared: usize,
}

/// The elimination of a symmetric tridiagonal matrix with constant entries.
struct Band {
    off: f64,
    pivots: Vec<f64>,
}

impl Diffusion {
    fn new(viscosity: f64) -> Self {
        Self { viscosity, b: None, prepared: 0 }
    }
}

impl Preconditioner for Diffusion {
    fn prepare(&mut self, b: &StepOperator<'_>) -> Result<(), SolveError> {
        self.prepared += 1;
        let n = b.dim();
        let off = -b.s() * self.viscosity * ((n + 1) * (n + 1)) as f64;
        let mut pivots = vec![1.0 - 2.0 * off; n];
        (1..n).for_each(|i| pivots[i] -= off * off / pivots[i - 1]);
        self.b = Some(Band { off, pivots });
        Ok(())
    }

    fn solve(&mut self, x: &mut [f64]) {
        let Some(Band { off, pivots }) = &self.b else { return };
        (1..x.len()).for_each(|i| x[i] -= off / pivots[i - 1] * x[i - 1]);
        for i in (0..x.len()).rev() {
            let known = if i + 1 < x.len() { off * x[i + 1] } else { 0.0 };
            x[i] = (x[i] - known) / pivots[i];
        }
    }

    fn solve_transpose(&mut self, x: &mut [f64]) {
        self.solve(x);
    }
}

const VISCOSITY: f64 = 0.05;

/// The end of ten steps and the work of them.
fn run(mut method: impl OneStep, v: &[f64], h: f64) -> (Vec<f64>, Work) {
    let (mut q, mut p) = (v.to_vec(), vec![0.0; v.len()]);
    (0..10).for_each(|k| method.step(f64::from(k) * h, h, &mut q, &mut p).expect("solvable"));
    (q, method.work())
}

fn sine(n: usize) -> Vec<f64> {
    (1..=n).map(|i| (std::f64::consts::PI * i as f64 / (n + 1) as f64).sin()).collect()
}

fn assert_close(a: &[f64], b: &[f64], bound: f64, what: &str) {
    let distance = a.iter().zip(b).map(|(a, b)| (a - b).abs()).max_by(f64::total_cmp).expect("entries");
    assert!(distance <= bound, "{what}: {distance:e} > {bound:e}");
}

#[test]
fn matrix_free_steps_are_those_with_factors() {
    let (n, h) = (40, 0.02);
    let (field, v) = (burgers(n), sine(n));
    let products = Products::new(&field);
    type Make = fn(Diffusion) -> Iterative<Diffusion>;
    let solvers: [(&str, Make); 2] = [("conjugate gradients", Iterative::new), ("LSMR", Iterative::lsmr)];
    for (name, make) in solvers {
        let solver = || make(Diffusion::new(VISCOSITY)).with_tolerance(1e-12).expect("in (0, 1)");
        for (alpha, beta) in [(0.0, 1.0), (-0.5, 1.0), (0.3, 1.0), (1.0, 0.0)] {
            let closure = || Linear::new(alpha, beta).expect("not both zero");
            // The explicit-momentum closure is unstable for h |λ| > 2: one short step of it.
            let h = if beta == 0.0 { 1e-4 } else { h };
            let (expected, _) = run(least_squares(&field, closure()).expect("banded"), &v, h);
            let method = LeastSquaresStep::with_solver(&products, closure(), solver()).expect("matrix-free");
            let (found, work) = run(method, &v, h);
            // Ten steps to 1e-12 each, of a dissipative system.
            assert_close(&found, &expected, 1e-10, &format!("{name}, ({alpha}, {beta})"));
            assert!(work.inner > 0);
        }
        for tableau in [Tableau::implicit_euler(), Tableau::trapezoidal(), Tableau::tr_bdf2()] {
            let (expected, _) = run(RungeKutta::new(&field, tableau.clone()).expect("banded"), &v, h);
            let method = RungeKutta::with_solver(&products, tableau, solver()).expect("matrix-free");
            assert_close(&run(method, &v, h).0, &expected, 1e-10, name);
        }
        let end = |method| {
            let trajectory = Trajectory::new(method, State::new(0.0, v.clone()), h, 0.2).expect("usable");
            trajectory.observe(|_| {}).expect("solvable").q
        };
        let expected = end(Bdf2::new(&products.field).expect("banded"));
        let inexact = Bdf2::with_solver(&products, solver).expect("matrix-free");
        let trajectory = Trajectory::new(inexact, State::new(0.0, v.clone()), h, 0.2).expect("usable");
        assert_close(&trajectory.observe(|_| {}).expect("solvable").q, &expected, 1e-10, "BDF2");
    }
}

/// Neighbours that are coupled by products, more and less with time.
#[derive(Clone, Copy)]
struct Turning;

impl FieldFn for Turning {
    fn dim(&self) -> usize {
        4
    }
    fn structure(&self) -> Structure {
        Structure::Banded { lower: 1, upper: 1 }
    }
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
        for i in 0..4 {
            let left = if i > 0 { v[i - 1] } else { T::from(1.0) };
            let right = if i < 3 { v[i + 1] } else { T::from(0.5) };
            dv[i] = (left * 0.5 - right) * v[i] * (3.0 * t + i as f64).sin() - v[i] * 2.0;
        }
    }
}

/// f and its derivatives are those of the same times, whoever solves with them.
#[test]
fn steps_where_couplings_change_with_time_are_the_same_by_factors_iterations_and_products() {
    let field = AutoField::new(Turning);
    let products = Products::new(&field);
    for (alpha, beta) in [(0.0, 1.0), (-1.0, 1.0), (0.3, 1.0), (1.0, 0.0)] {
        let closure = || Linear::new(alpha, beta).expect("not both zero");
        let step = |method: &mut dyn OneStep| {
            let (mut v, mut p) = (vec![0.8, -0.5, 0.6, 0.3], vec![0.0; 4]);
            method.step(0.4, 0.2, &mut v, &mut p).expect("solvable");
            (v, p)
        };
        let (v, p) = step(&mut least_squares(with_structure(Structure::Dense, &field), closure()).expect("dense"));
        let by_products = Iterative::new(Unscaled).with_tolerance(1e-15).expect("in (0, 1)");
        let mut methods: Vec<(String, Box<dyn OneStep + '_>)> = vec![
            ("in a band".into(), Box::new(least_squares(&field, closure()).expect("banded"))),
            (
                "products".into(),
                Box::new(LeastSquaresStep::with_solver(&products, closure(), by_products).expect("fits")),
            ),
        ];
        for by in By::ALL {
            if let Ok(method) = LeastSquaresStep::with_solver(&field, closure(), by.solver()) {
                methods.push((format!("{by:?}"), Box::new(method)));
            }
        }
        for (name, method) in &mut methods {
            let (w, q) = step(&mut **method);
            // |v| < 1, to the tolerance of Newton's method, and p is a difference of v over h.
            assert_close(&w, &v, 1e-13, &format!("{name}, ({alpha}, {beta})"));
            assert_close(&q, &p, 1e-13, &format!("p, {name}, ({alpha}, {beta})"));
        }
    }
}

/// Method II is α + β = 0: its equation is J₀ᵀr₀ + J₁ᵀr₁ = 0, h|λ| times as well conditioned for slow modes.
#[test]
fn method_ii_is_the_same_in_every_structure_and_matrix_free() {
    let n = 30;
    let line = Line::new(n, 5.0, Walls::Dirichlet);
    let h = 0.01;
    let (expected, _) = run(RungeKutta::new(&line, Tableau::trapezoidal()).expect("banded"), &wave(n, 0.3), h);
    let band = (0..n).flat_map(|i| [(i, i), (i, (i + 1).min(n - 1)), (i, i.saturating_sub(1))]);
    let structures = [Structure::Dense, line.structure(), Structure::sparse(n, band).expect("inside")];
    // κ(JᵀB) ≤ κ(J) (1 + h |λ|): |λ| from 10 to 4·31².
    let bound = 10.0 * n as f64 * f64::EPSILON * 400.0 * (1.0 + h * 4000.0);
    for structure in structures {
        let what = format!("{structure:?}");
        let (found, _) = run(method_ii(with_structure(structure, &line)).expect("assembled"), &wave(n, 0.3), h);
        assert_close(&found, &expected, bound, &what);
    }
    let solver = Iterative::new(Diffusion::new(1.0)).with_tolerance(1e-12).expect("in (0, 1)");
    let products = Products::new(&line);
    let method = LeastSquaresStep::with_solver(&products, Linear::METHOD_II, solver).expect("matrix-free");
    // The residual is solved to 1e-12; its derivative is as small as 2h|λ_min| ≈ 0.2.
    assert_close(&run(method, &wave(n, 0.3), h).0, &expected, 1e-9, "matrix-free");
}

/// The momentum that a structured step leaves is that of the discrete Lagrangian.
#[test]
fn momenta_do_not_depend_on_the_structure() {
    let (n, h) = (12, 0.02);
    let (field, v) = (burgers(n), sine(n));
    let products = Products::new(&field);
    let closure = || Linear::new(-0.5, 1.0).expect("not both zero");
    let solver = Iterative::new(Diffusion::new(VISCOSITY)).with_tolerance(1e-13).expect("in (0, 1)");
    let mut methods: [Box<dyn OneStep>; 3] = [
        Box::new(least_squares(with_structure(Structure::Dense, &field), closure()).expect("dense")),
        Box::new(least_squares(&field, closure()).expect("banded")),
        Box::new(LeastSquaresStep::with_solver(&products, closure(), solver).expect("matrix-free")),
    ];
    let momenta = methods.each_mut().map(|method| {
        let mut p = vec![0.0; n];
        method.step(0.0, h, &mut v.clone(), &mut p).expect("solvable");
        p
    });
    let size = momenta[0].iter().fold(0.0, |m: f64, p| m.max(p.abs()));
    assert!(size > 1e-3, "{size:e}");
    // p = M (v₁ − v₀)/h − f is a difference of terms of size 10.
    assert_close(&momenta[1], &momenta[0], 1e-11, "banded");
    assert_close(&momenta[2], &momenta[0], 1e-9, "matrix-free");
}

/// Preconditioned by all of B the spectrum is in (1, 2]; without the convection the count still does not grow with n.
#[test]
fn inner_iterations_do_not_grow_with_the_number_of_unknowns() {
    let counts = [50, 100, 200, 400].map(|n| {
        let field = AutoField::new(Burgers { cells: n, viscosity: VISCOSITY });
        let products = Products::new(&field);
        let solver = Iterative::new(Diffusion::new(VISCOSITY)).with_tolerance(1e-8).expect("in (0, 1)");
        let method = LeastSquaresStep::with_solver(&products, Linear::METHOD_I, solver).expect("matrix-free");
        run(method, &sine(n), 0.02).1.inner
    });
    assert!(counts[3] <= counts[0] + counts[0] / 4, "{counts:?}");
}

#[test]
fn a_mass_that_is_an_operator_is_one() {
    let (n, h) = (3, 0.3);
    // 2 v̇ = −2v: Method I multiplies by 1/(1 + h + h²/2).
    let solver = Iterative::new(Unscaled);
    let mut method = LeastSquaresStep::with_solver(Massive, Linear::METHOD_I, solver).expect("positive definite");
    let (mut v, mut p) = (vec![1.0; n], vec![0.0; n]);
    method.step(0.0, h, &mut v, &mut p).expect("solvable");
    v.iter().for_each(|v| assert_abs_diff_eq!(*v, 1.0 / (1.0 + h + 0.5 * h * h), epsilon = 1e-9));
}

/// P⁻¹ = diag 10^(±(i mod so many)): in its norm a residual is small where many of the unknowns have hardly moved.
struct Powers {
    turn: i32,
    sign: i32,
}

impl Preconditioner for Powers {
    fn prepare(&mut self, _b: &StepOperator<'_>) -> Result<(), SolveError> {
        Ok(())
    }
    fn solve(&mut self, x: &mut [f64]) {
        x.iter_mut().zip((0..self.turn).cycle()).for_each(|(x, k)| *x *= 10_f64.powi(self.sign * k));
    }
    fn solve_transpose(&mut self, x: &mut [f64]) {
        self.solve(x);
    }
}

/// v̇_i = −λ_i (v_i − cos t) + 0.3 v_{i+1}² − 0.3 λ_i v_{i−1} on a ring, λ_i from 0.06 to 10⁴.
struct Graded(Mass);

impl FieldFn for Graded {
    fn dim(&self) -> usize {
        20
    }
    fn mass(&self) -> Mass {
        self.0.clone()
    }
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
        let n = v.len();
        for (i, dv) in dv.iter_mut().enumerate() {
            let rate = 1e4 * ((i + 1) as f64 / n as f64).powi(4);
            *dv = -(v[i] - t.cos()) * rate + v[(i + 1) % n] * v[(i + 1) % n] * 0.3 - v[(i + n - 1) % n] * (0.3 * rate);
        }
    }
}

/// The increments of a system that a preconditioner has solved in part are no errors.
#[test]
fn steps_are_solved_whatever_the_preconditioner_weighs() {
    for make in [Iterative::new, Iterative::lsmr] {
        for mass in [Mass::Identity, Mass::Diagonal(vec![2.0; 20])] {
            let field = || AutoField::new(Graded(mass.clone()));
            let mut by_products =
                LeastSquaresStep::with_solver(field(), Linear::METHOD_I, make(Powers { turn: 5, sign: 1 }))
                    .expect("usable");
            let mut by_factors = method_i(field()).expect("usable");
            let (mut v, h) = (vec![1.0; 20], 0.05);
            for k in 0..10 {
                let (t, mut exact) = (h * f64::from(k), v.clone());
                by_factors.step(t, h, &mut exact, &mut [0.0; 20]).expect("solvable");
                by_products.step(t, h, &mut v, &mut [0.0; 20]).expect("solvable");
                // Each equation leaves of its own unknown 10⁻¹⁰ of the largest, the tolerance of an iterative solver: with the others up to
                // |H⁻¹ diag H| times as much, 12.2 at most of 200 random states in this range.
                assert!(exact.iter().all(|v| v.abs() <= 1.5), "t = {t}: {exact:?}");
                v.iter().zip(&exact).for_each(|(a, b)| assert_abs_diff_eq!(*a, *b, epsilon = 12.2 * 1.5e-10));
            }
        }
    }
}

/// v̇_i = −λ_i (v_i − cos t + c v_{i−1}) in a ring, rates λ from 1 to 10⁴.
struct Ring {
    cells: usize,
    coupling: f64,
}

impl Ring {
    fn rate(&self, i: usize) -> f64 {
        1e4 * ((i + 1) as f64 / self.cells as f64).powi(4)
    }

    fn jacobian(&self) -> DMatrix<f64> {
        let before = |i: usize| (i + self.cells - 1) % self.cells;
        DMatrix::from_fn(self.cells, self.cells, |i, j| {
            let part = if i == j { 1.0 } else { 0.0 } + if j == before(i) { self.coupling } else { 0.0 };
            -self.rate(i) * part
        })
    }
}

impl FieldFn for Ring {
    fn dim(&self) -> usize {
        self.cells
    }
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
        for (i, dv) in dv.iter_mut().enumerate() {
            *dv = (v[i] - t.cos() + v[(i + self.cells - 1) % self.cells] * self.coupling) * -self.rate(i);
        }
    }
}

/// Newton's iteration with iteratively solved systems is held to the equations of each unknown, in stages and in closures with α ≠ 0.
#[test]
fn inexact_newton_steps_are_solved_whatever_the_preconditioner_weighs() {
    let closure = || Linear::new(-0.5, 1.0).expect("weights");
    let norm = |a: &DMatrix<f64>| a.row_iter().map(|row| row.lp_norm(1)).max_by(f64::total_cmp).expect("rows");
    for (cells, turn, sign, h) in [3, 8, 20]
        .into_iter()
        .flat_map(|n| (1..=7).flat_map(move |k| [-1, 1].map(|s| (n, k, s))))
        .flat_map(|(n, k, s)| [0.003, 0.03, 0.3].map(|h| (n, k, s, h)))
    {
        let ring = || Ring { cells, coupling: 0.3 };
        let field = || AutoField::new(ring());
        let solver = || Iterative::new(Powers { turn, sign });
        let one = DMatrix::identity(cells, cells);
        let b = &one - h * ring().jacobian();
        // What equations that are off by their own scale times a number leave of unknowns, relative to it.
        let stage = {
            let scale = DMatrix::from_diagonal(&DVector::from_fn(cells, |i, _| b.row(i).amax()));
            norm(&(b.clone().try_inverse().expect("regular") * scale))
        };
        let closed = {
            let d = 0.5 * (&one + &b) + 0.5 * (&b - &one).transpose() + (&b - &one).transpose() * &b;
            let scale =
                DVector::from_fn(cells, |i, _| 0.5 * (1.0 + b[(i, i)].abs()) + 1.0 + b.column(i).norm_squared());
            norm(&(d.try_inverse().expect("regular") * DMatrix::from_diagonal(&scale)))
        };
        let pairs: [[Box<dyn OneStep>; 2]; 2] = [
            [
                Box::new(RungeKutta::with_solver(field(), Tableau::implicit_euler(), solver()).expect("usable")),
                Box::new(RungeKutta::new(field(), Tableau::implicit_euler()).expect("usable")),
            ],
            [
                Box::new(LeastSquaresStep::with_solver(field(), closure(), solver()).expect("usable")),
                Box::new(least_squares(field(), closure()).expect("usable")),
            ],
        ];
        for (condition, [mut by_products, mut by_factors]) in [stage, closed].into_iter().zip(pairs) {
            let start: Vec<f64> = (0..cells).map(|i| [1.0, 0.4, 1.7][i % 3]).collect();
            let (mut exact, mut v, mut p) = (start.clone(), start.clone(), vec![0.0; cells]);
            by_factors.step(0.0, h, &mut exact, &mut p).expect("regular");
            p.fill(0.0);
            let solved = by_products.step(0.0, h, &mut v, &mut p);
            let said = format!("condition {condition}, n = {cells}, {turn} powers of {sign}, h = {h}: {solved:?}");
            assert!(solved.is_ok(), "{said}");
            let largest = exact.iter().chain(&start).fold(0.0, |most: f64, v| most.max(v.abs()));
            // The tolerance of an iterative solver.
            let bound = condition * 1e-10 * largest;
            assert!(
                v.iter().zip(&exact).all(|(a, b)| (a - b).abs() <= bound),
                "{said}: {v:?} for {exact:?}, {bound:e}"
            );
        }
    }
}

/// Of a field that declares to be linear as of one that does not.
#[test]
fn linear_steps_are_solved_whatever_the_preconditioner_weighs() {
    struct Declared(Ring);
    impl VectorField for Declared {
        fn dim(&self) -> usize {
            self.0.cells
        }
        fn is_linear(&self) -> bool {
            true
        }
        fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
            self.0.rhs(t, v, dv);
        }
        fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
            let a = self.0.jacobian();
            (0..self.0.cells).for_each(|j| (0..self.0.cells).for_each(|i| out.add(i, j, scale * a[(i, j)])));
        }
    }
    let norm = |a: &DMatrix<f64>| a.row_iter().map(|row| row.lp_norm(1)).max_by(f64::total_cmp).expect("rows");
    for (cells, turn, sign) in
        [3, 8, 20].into_iter().flat_map(|n| [4, 7].into_iter().flat_map(move |k| [-1, 1].map(|s| (n, k, s))))
    {
        for make in [Iterative::new, Iterative::lsmr] {
            let (field, h) = (|| Declared(Ring { cells, coupling: 0.3 }), 0.03);
            let b = DMatrix::identity(cells, cells) - h * field().0.jacobian();
            let matrix = DMatrix::identity(cells, cells) + b.tr_mul(&b);
            let scale = DMatrix::from_diagonal(&matrix.diagonal());
            let condition = norm(&(matrix.try_inverse().expect("definite") * scale));
            let mut by_products =
                LeastSquaresStep::with_solver(field(), Linear::METHOD_I, make(Powers { turn, sign })).expect("usable");
            let mut by_factors = method_i(field()).expect("usable");
            let (mut exact, mut v) = (vec![1.0; cells], vec![1.0; cells]);
            by_factors.step(0.0, h, &mut exact, &mut vec![0.0; cells]).expect("regular");
            by_products.step(0.0, h, &mut v, &mut vec![0.0; cells]).expect("definite");
            // The tolerance of an iterative solver beside the largest component, 1 or less.
            let bound = 1e-10 * condition * 1.01;
            assert!(
                v.iter().zip(&exact).all(|(a, b)| (a - b).abs() <= bound),
                "{cells}, {turn}, {sign}: {v:?} {exact:?}"
            );
        }
    }
}

/// Without a preconditioner, κ(I + BᵀB) ≈ (1 + 4 h ν n²)²: too many iterations, and a typed error.
#[test]
fn iterations_that_do_not_converge_say_so() {
    let n = 2000;
    let field = Products::new(AutoField::new(Burgers { cells: n, viscosity: 1.0 }));
    for solver in [Iterative::new(Unscaled), Iterative::lsmr(Unscaled)] {
        let mut method = LeastSquaresStep::with_solver(&field, Linear::METHOD_I, solver).expect("matrix-free");
        let (start, mut v) = (sine(n).iter().map(|x| x + 0.1 * (700.0 * x).sin()).collect::<Vec<_>>(), vec![]);
        v.clone_from(&start);
        let result = method.step(0.0, 10.0, &mut v, &mut vec![0.0; n]);
        let Err(StepError::Solve { source: SolveError::Linear { iterations, .. }, .. }) = result else {
            panic!("{result:?}")
        };
        assert!(iterations >= 100);
        assert_eq!(v, start);
    }
}

#[test]
fn fields_are_shared_between_threads() {
    fn is_sync<T: Sync + Send>(_: &T) {}
    is_sync(&burgers(3));
    is_sync(&LeastSquares::new(burgers(3)).expect("dense"));
    is_sync(&AutoLagrangian::new(Free));
    is_sync(&Forced::new(AutoLagrangian::new(Free), AutoForce::new(Free)).expect("one"));
    is_sync(&AutoConstraint::new(Free));
    is_sync(&Mass::operator(Doubled(2)));
    // An integrator works for one thread at a time, and may move between them.
    fn is_send<T: Send>(_: &T) {}
    is_send(&method_i(burgers(3)).expect("banded"));
}

struct Free;

impl LagrangianFn for Free {
    fn dim(&self) -> usize {
        1
    }
    fn lagrangian<T: Scalar>(&self, _t: T, _q: &[T], v: &[T]) -> T {
        v[0] * v[0]
    }
}

impl ForceFn for Free {
    fn dim(&self) -> usize {
        1
    }
    fn force<T: Scalar>(&self, _t: f64, _q: &[T], v: &[T], out: &mut [T]) {
        out[0] = -v[0];
    }
}

impl ConstraintFn for Free {
    fn dim(&self) -> usize {
        1
    }
    fn count(&self) -> usize {
        1
    }
    fn constraint<T: Scalar>(&self, q: &[T], out: &mut [T]) {
        out[0] = q[0];
    }
}

/// A field of two unknowns with the mass of three.
struct Misfit(Mass);

impl VectorField for Misfit {
    fn dim(&self) -> usize {
        2
    }
    fn mass(&self) -> Mass {
        self.0.clone()
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv.copy_from_slice(v);
    }
    fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        (0..v.len()).for_each(|i| out.add(i, i, scale));
    }
}

/// 2v̇ = −2v with a mass that is known by products is v̇ = −v.
#[test]
fn bdf2_solves_with_a_mass_that_is_an_operator() {
    let decay = field!(3, |_t, v, dv| (0..3).for_each(|i| dv[i] = -v[i]));
    let end = |method| {
        let trajectory = Trajectory::new(method, State::new(0.0, vec![1.0, 0.5, -2.0]), 0.1, 1.0).expect("usable");
        trajectory.observe(|_| {}).expect("solvable").q
    };
    let expected = end(Bdf2::new(decay).expect("dense"));
    let method = Bdf2::with_solver(Massive, || Iterative::new(Unscaled)).expect("products are enough");
    let trajectory = Trajectory::new(method, State::new(0.0, vec![1.0, 0.5, -2.0]), 0.1, 1.0).expect("usable");
    assert_close(&trajectory.observe(|_| {}).expect("solvable").q, &expected, 1e-9, "BDF2");
}

#[test]
fn what_is_of_another_order_is_no_mass() {
    for mass in [Mass::operator(Doubled(3)), Mass::Diagonal(vec![2.0; 3]), Mass::Matrix(Jacobian::zeros(3))] {
        let error = RungeKutta::new(Misfit(mass), Tableau::rk4()).map(|_| ());
        let is_refused = matches!(error, Err(InputError::System(SystemError::Dimension { expected: 2, found: 3, .. })));
        assert!(is_refused, "{error:?}");
    }
}

/// A preconditioner that holds the transposed products of what it is set up for to its matrix.
struct Checked;

impl Preconditioner for Checked {
    fn check(&self, structure: &Structure, _mass: &Mass) -> Result<(), InputError> {
        if *structure == Structure::Dense {
            Err(InputError::System(SystemError::Solver("a band is wanted")))
        } else {
            Ok(())
        }
    }
    fn prepare(&mut self, b: &StepOperator<'_>) -> Result<(), SolveError> {
        let n = b.dim();
        let (x, matrix) = (wave(n, 0.4), b.assembled().expect("a matrix"));
        let (mut once, mut transposed) = (vec![0.0; n], vec![0.0; n]);
        b.apply(&x, &mut once).expect("of n components");
        b.apply_transpose(&x, &mut transposed).expect("of n components");
        for i in 0..n {
            let [row, column] =
                [(0..n).map(|j| matrix.get(i, j) * x[j]).sum::<f64>(), (0..n).map(|j| matrix.get(j, i) * x[j]).sum()];
            assert_abs_diff_eq!(once[i], row, epsilon = 1e-13);
            assert_abs_diff_eq!(transposed[i], column, epsilon = 1e-13);
        }
        assert!(b.apply_transpose(&x[1..], &mut transposed).is_err());
        Ok(())
    }
    fn solve(&mut self, _x: &mut [f64]) {}
    fn solve_transpose(&mut self, _x: &mut [f64]) {}
}

#[test]
fn a_preconditioner_of_one_s_own_sees_the_matrix_of_the_step_and_refuses_fields_through_a_box() {
    let boxed = || Iterative::new(Box::new(Checked) as Box<dyn Preconditioner + Send>);
    let mut method = RungeKutta::with_solver(burgers(6), Tableau::implicit_euler(), boxed()).expect("a band");
    method.step(0.0, 0.01, &mut wave(6, 0.3), &mut []).expect("solvable");
    let error =
        RungeKutta::with_solver(with_structure(Structure::Dense, burgers(6)), Tableau::implicit_euler(), boxed())
            .map(|_| ());
    assert_eq!(error, Err(InputError::System(SystemError::Solver("a band is wanted"))));
}

/// L = v²/2 − q⁴/4 with its derivatives by hand, without the force alone.
struct ByHand;

impl lsvi::Lagrangian for ByHand {
    fn dim(&self) -> usize {
        1
    }
    fn value(&self, _t: f64, q: &[f64], v: &[f64]) -> f64 {
        0.5 * v[0] * v[0] - 0.25 * q[0].powi(4)
    }
    fn gradient(&self, _t: f64, q: &[f64], v: &[f64], dl_dq: &mut [f64], dl_dv: &mut [f64]) {
        dl_dq[0] = -q[0].powi(3);
        dl_dv[0] = v[0];
    }
    fn add_hessian(&self, _t: f64, q: &[f64], _v: &[f64], c: lsvi::HessianWeights, out: &mut Jacobian) {
        out.add(0, 0, c.vv - 3.0 * c.qq * q[0] * q[0]);
    }
}

#[test]
fn the_force_of_a_lagrangian_is_that_of_its_gradient() {
    let mut force = [0.0];
    lsvi::Lagrangian::gradient_q(&ByHand, 0.0, &[2.0], &[1.0], &mut force, &mut [0.0]);
    assert_eq!(force, [-8.0]);
}

#[test]
fn a_preconditioner_in_a_box_saves_as_many_iterations() {
    let steps = |solver: Box<dyn lsvi::solver::StepSolver>, closure| {
        let mut method = LeastSquaresStep::with_solver(burgers(6), closure, solver).expect("a band");
        let (mut v, mut p) = (wave(6, 0.3), vec![0.0; 6]);
        (0..3).for_each(|k| method.step(f64::from(k) * 0.1, 0.1, &mut v, &mut p).expect("solvable"));
        (v, method.work())
    };
    for closure in [|| Linear::METHOD_I, || Linear::new(0.3, 0.7).expect("finite")] {
        let boxed = Box::new(Factored::default()) as Box<dyn Preconditioner + Send>;
        let own = steps(Box::new(Iterative::new(Factored::default())), closure());
        assert_eq!(steps(Box::new(Iterative::new(boxed)), closure()), own);
    }
}

/// v̇ = −v in two components, of which the caller moves one between two steps.
#[test]
fn a_state_that_was_changed_in_any_component_is_a_new_start() {
    struct Decays;
    impl FieldFn for Decays {
        fn dim(&self) -> usize {
            2
        }
        fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
            dv.iter_mut().zip(v).for_each(|(dv, v)| *dv = -*v);
        }
    }
    let tolerances = lsvi::adaptive::Tolerances::new(1e-6, 1e-6).expect("positive");
    let discrete = Trapezoidal::new(LeastSquares::new(AutoField::new(Decays)).expect("usable"));
    let methods: [(&str, Box<dyn Integrator>); 3] = [
        ("BDF2", Box::new(Bdf2::new(AutoField::new(Decays)).expect("usable"))),
        ("window", Box::new(Window::new(discrete, 8).expect("a length"))),
        ("Radau", Box::new(lsvi::adaptive::Radau::new(AutoField::new(Decays), tolerances).expect("usable"))),
    ];
    let grid = Grid::new(0.0, 0.05, 2.0).expect("valid");
    for (name, mut method) in methods {
        let mut state = State::new(0.0, vec![1.0, 1.0]);
        for _ in 0..3 {
            method.advance(&mut state, &grid).expect("solvable");
        }
        state.q[1] = 5.0;
        let before = state.clone();
        method.advance(&mut state, &grid).expect("solvable");
        let decay = (before.t - state.t).exp();
        for (after, before) in state.q.iter().zip(&before.q) {
            assert_abs_diff_eq!(*after, decay * before, epsilon = 0.01 * before);
        }
        assert!(state.t > before.t, "{name}");
    }
}
