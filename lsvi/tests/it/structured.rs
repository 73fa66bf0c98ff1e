//! Systems with dense, banded and sparse Jacobians: the same steps in every structure and formulation.

use crate::fields::{As, Burgers, By, Line, Plane, Walls, with_structure};
use crate::systems::field_of;
use approx::assert_abs_diff_eq;
use lsvi::adaptive::{Options, Radau, Tolerances};
use lsvi::classic::{Bdf2, CoupledRungeKutta, RungeKutta, Tableau};
use lsvi::closure::Linear;
use lsvi::discrete::{Galerkin, Midpoint, Trapezoidal};
use lsvi::quadrature::Quadrature;
use lsvi::solver::Iterative;
use lsvi::{
    AutoField, Factored, InputError, Integrator, Jacobian, Lagrangian, LeastSquares, Mass, NodeError, OneStep,
    SettingError, SolveError, State, StepError, Structure, SystemError, Trajectory, Variational, VectorField, Window,
    least_squares, method_i,
};

fn wave(n: usize) -> Vec<f64> {
    (0..n).map(|i| (0.3 * i as f64).sin() + 0.2 * (1.7 * i as f64).cos()).collect()
}

fn end(method: impl Integrator, v: Vec<f64>, h: f64, t_end: f64) -> Vec<f64> {
    Trajectory::new(method, State::new(0.0, v), h, t_end).expect("usable").observe(|_| {}).expect("solvable").q
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).max_by(f64::total_cmp).expect("entries")
}

/// The positions of a band as a sparsity pattern.
fn sparse_band(n: usize, lower: usize, upper: usize) -> Structure {
    let band = (0..n).flat_map(|i| (i.saturating_sub(lower)..(i + upper + 1).min(n)).map(move |j| (i, j)));
    Structure::sparse(n, band).expect("inside")
}

/// Two runs of m steps whose linear systems have condition number κ differ by at most m κ n ε times their size.
fn assert_same(a: &[f64], b: &[f64], steps: f64, condition: f64, what: &str) {
    let bound = steps * condition * a.len() as f64 * f64::EPSILON;
    assert!(distance(a, b) <= bound, "{what}: {:e} > {bound:e}", distance(a, b));
}

#[test]
fn baseline_methods_are_the_same_in_every_structure() {
    let n = 30;
    let field = Line::new(n, 3.0, Walls::Dirichlet);
    let structures = [Structure::Dense, Structure::Banded { lower: 1, upper: 1 }, sparse_band(n, 1, 1)];
    let h = 0.1;
    // κ(I − h A) ≤ 1 + 4h/dx².
    let condition = 1.0 + 4.0 * h * 31.0 * 31.0;
    for tableau in [Tableau::implicit_euler(), Tableau::trapezoidal(), Tableau::implicit_midpoint(), Tableau::sdirk2()]
    {
        let [dense, banded, sparse] = structures.clone().map(|s| {
            end(RungeKutta::new(with_structure(s, &field), tableau.clone()).expect("usable"), wave(n), h, 1.0)
        });
        assert_same(&dense, &banded, 10.0, condition, "banded");
        assert_same(&dense, &sparse, 10.0, condition, "sparse");
    }
    let [dense, banded, sparse] =
        structures.map(|s| end(Bdf2::new(with_structure(s, &field)).expect("usable"), wave(n), h, 1.0));
    assert_same(&dense, &banded, 10.0, condition, "banded");
    assert_same(&dense, &sparse, 10.0, condition, "sparse");
}

#[test]
fn method_i_is_the_same_in_every_structure_and_formulation() {
    let n = 30;
    for (peclet, walls) in [(0.0, Walls::Dirichlet), (0.0, Walls::Neumann), (20.0, Walls::Dirichlet)] {
        let field = Line::new(n, peclet, walls);
        let h = 0.01;
        // κ(I + BᵀB) ≤ 1 + ‖B‖², ‖B‖ ≤ 1 + h (4/dx² + peclet/dx).
        let condition = (1.0 + h * (4.0 * 31.0 * 31.0 + peclet * 31.0_f64)).powi(2);
        let dense = end(method_i(with_structure(Structure::Dense, &field)).expect("usable"), wave(n), h, 0.1);
        assert_same(&dense, &end(method_i(&field).expect("usable"), wave(n), h, 0.1), 10.0, condition, "banded");
        let sparse = method_i(with_structure(sparse_band(n, 1, 1), &field)).expect("usable");
        assert_same(&dense, &end(sparse, wave(n), h, 0.1), 10.0, condition, "sparse");
        for by in By::ALL {
            let method = by.method_i(&field).expect("fits");
            assert_same(&dense, &end(method, wave(n), h, 0.1), 10.0, condition, &format!("{by:?}"));
        }
    }
}

/// v̇_i = −v_i + 2 v_{i−1} + 1, or with v_{i+1}: entries on one side of the diagonal alone.
#[derive(Clone)]
struct Cascade {
    structure: Structure,
    is_lower: bool,
    /// What it says of itself: that it is linear, and that it does not depend on time.
    declared: [bool; 2],
}

impl Cascade {
    fn other(&self, i: usize) -> Option<usize> {
        if self.is_lower { i.checked_sub(1) } else { Some(i + 1).filter(|j| *j < 6) }
    }
}

impl VectorField for Cascade {
    fn dim(&self) -> usize {
        6
    }
    fn structure(&self) -> Structure {
        self.structure.clone()
    }
    fn is_linear(&self) -> bool {
        self.declared[0]
    }
    fn is_autonomous(&self) -> bool {
        self.declared[1]
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        (0..6).for_each(|i| dv[i] = 1.0 - v[i] + self.other(i).map_or(0.0, |j| 2.0 * v[j]));
    }
    fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
        for i in 0..6 {
            out.add(i, i, -scale);
            self.other(i).into_iter().for_each(|j| out.add(i, j, 2.0 * scale));
        }
    }
}

#[test]
fn linear_method_i_is_the_same_in_every_structure_with_entries_on_one_side() {
    for is_lower in [true, false] {
        let (lower, upper) = (usize::from(is_lower), usize::from(!is_lower));
        let run_as = |declared, structure| {
            let field = Cascade { structure, is_lower, declared };
            end(method_i(field).expect("usable"), (1..7).map(f64::from).collect(), 0.1, 0.5)
        };
        let dense = run_as([false, false], Structure::Dense);
        // ‖B‖ ≤ 1 + 3h.
        for (structure, what) in [
            (Structure::Dense, "all entries"),
            (Structure::Banded { lower, upper }, "its band"),
            (Structure::Banded { lower: 1, upper: 1 }, "a wider band"),
            (sparse_band(6, lower, upper), "its pattern"),
            (sparse_band(6, 1, 1), "a wider pattern"),
        ] {
            // States come to 10 in size.
            for declared in [[true, true], [true, false]] {
                let run = run_as(declared, structure.clone());
                assert_same(&dense, &run, 50.0, 1.3 * 1.3, &format!("{what}, {is_lower}, {declared:?}"));
            }
        }
    }
}

/// Factors serve for steps of their own size alone: one that differs by a little is off by as little.
/// u_tt = u_xx between fixed ends, displacements and velocities in turn: nothing is damped.
struct FixedString {
    points: usize,
    structure: Structure,
}

impl VectorField for FixedString {
    fn dim(&self) -> usize {
        2 * self.points
    }
    fn structure(&self) -> Structure {
        self.structure.clone()
    }
    fn is_linear(&self) -> bool {
        true
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        let stiffness = ((self.points + 1) as f64).powi(2);
        for i in 0..self.points {
            let beside = [i.checked_sub(1), Some(i + 1)].map(|j| j.and_then(|j| v.get(2 * j)).unwrap_or(&0.0));
            dv[2 * i] = v[2 * i + 1];
            dv[2 * i + 1] = stiffness * (beside[0] - 2.0 * v[2 * i] + beside[1]);
        }
    }
    fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
        let stiffness = scale * ((self.points + 1) as f64).powi(2);
        for i in 0..self.points {
            out.add(2 * i, 2 * i + 1, scale);
            out.add(2 * i + 1, 2 * i, -2.0 * stiffness);
            if i > 0 {
                out.add(2 * i + 1, 2 * i - 2, stiffness);
            }
            if i + 1 < self.points {
                out.add(2 * i + 1, 2 * i + 2, stiffness);
            }
        }
    }
}

/// Conjugate gradients with P = B take hundreds of iterations there, or do not come to rounding.
#[test]
fn linear_method_i_steps_waves_in_every_structure() {
    let points = 150;
    let n = 2 * points;
    let of = |structure, h| end(method_i(FixedString { points, structure }).expect("usable"), wave(n), h, 5.0 * h);
    for h in [2e-4, 1e-3, 2e-3, 1e-2] {
        let banded = of(Structure::Banded { lower: 3, upper: 1 }, h);
        // κ(I + BᵀB) ≤ 1 + ‖B‖² with ‖B‖ ≤ 1 + 4h/dx².
        let condition = 1.0 + (1.0 + 4.0 * h * ((points + 1) as f64).powi(2)).powi(2);
        let largest = banded.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
        assert_same(&of(sparse_band(n, 3, 1), h), &banded, 5.0, largest * condition, &format!("h = {h}"));
    }
    // The iterations that were in vain count, and both kinds of factors.
    let mut method = method_i(FixedString { points, structure: sparse_band(n, 3, 1) }).expect("usable");
    for _ in 0..3 {
        method.step(0.0, 2e-3, &mut wave(n), &mut vec![0.0; n]).expect("solvable");
    }
    let work = method.work();
    assert_eq!([work.factorizations, work.inner], [2, 500]);
}

#[test]
fn a_linear_step_of_nearly_the_same_size_is_that_of_a_new_method() {
    for structure in [Structure::Dense, Structure::Banded { lower: 1, upper: 0 }, sparse_band(6, 1, 0)] {
        let method =
            || method_i(Cascade { structure: structure.clone(), is_lower: true, declared: [true; 2] }).expect("usable");
        let step = |method: &mut dyn OneStep, h: f64| {
            let (mut v, mut p) = ((1..7).map(f64::from).collect::<Vec<_>>(), vec![0.0; 6]);
            method.step(0.0, h, &mut v, &mut p).expect("solvable");
            v
        };
        for h in [0.1 * (1.0 + 1e-6), 0.1 * (1.0 + 1e-10), 0.1 * (1.0 + 1e-12)] {
            let mut used = method();
            step(&mut used, 0.1);
            assert_eq!(step(&mut used, h), step(&mut method(), h), "{structure:?}, {h}");
        }
    }
}

/// v̇_i = ½ v_{i−1} − v_i (1 + v_{i+1}), or with v_i in place of v_{i+1}: not all unknowns to which a row leads are multiplied.
#[derive(Clone)]
struct Products {
    structure: Structure,
    curvature: Structure,
    /// How far ahead the factor is.
    ahead: usize,
}

impl VectorField for Products {
    fn dim(&self) -> usize {
        9
    }
    fn structure(&self) -> Structure {
        self.structure.clone()
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        let at = |i: Option<usize>| i.and_then(|i| v.get(i)).copied().unwrap_or(0.0);
        (0..9).for_each(|i| dv[i] = 0.5 * at(i.checked_sub(1)) - v[i] * (1.0 + at(Some(i + self.ahead))));
    }
    fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        for i in 0..9 {
            out.add(i, i, -scale * (1.0 + v.get(i + self.ahead).unwrap_or(&0.0)));
            if i > 0 {
                out.add(i, i - 1, 0.5 * scale);
            }
            if i + self.ahead < 9 {
                out.add(i, i + self.ahead, -scale * v[i]);
            }
        }
    }
    fn curvature_structure(&self) -> Structure {
        self.curvature.clone()
    }
    fn add_curvature(&self, _t: f64, _v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        for (i, w) in w.iter().enumerate().take(9 - self.ahead) {
            out.add(i, i + self.ahead, -scale * w);
            out.add(i + self.ahead, i, -scale * w);
        }
    }
}

/// The state after a step, or why there is none.
fn by_closure(field: &dyn VectorField, closure: Linear) -> Result<Vec<f64>, StepError> {
    let mut method = least_squares(field, closure).expect("usable");
    let (mut v, mut p) = ((0..9).map(|i| 1.0 + 0.1 * f64::from(i)).collect::<Vec<_>>(), vec![0.0; 9]);
    method.step(0.0, 0.1, &mut v, &mut p).map(|()| v)
}

#[test]
fn a_narrow_structure_of_the_curvature_changes_no_step() {
    let band = |lower, upper| Structure::Banded { lower, upper };
    let closures: [fn() -> Linear; 2] = [|| Linear::METHOD_II, || Linear::new(-0.5, 1.0).expect("a closure")];
    for (ahead, structure, curvature) in [
        (1, band(1, 1), band(1, 1)),
        (1, sparse_band(9, 1, 1), sparse_band(9, 1, 1)),
        (0, band(1, 0), band(0, 0)),
        (0, sparse_band(9, 1, 0), sparse_band(9, 0, 0)),
    ] {
        let narrow = Products { structure: structure.clone(), curvature: curvature.clone(), ahead };
        let wide = with_structure(structure.clone(), &narrow);
        assert_ne!(wide.curvature_structure(), curvature, "the default is wider");
        for closure in closures {
            let [wide, narrow] = [&wide as &dyn VectorField, &narrow].map(|field| by_closure(field, closure()));
            // ‖B‖ ≤ 1 + 5h, states below 2.
            let what = format!("{structure:?}, {:?}", closure());
            assert_same(&wide.expect("solvable"), &narrow.expect("solvable"), 2.0, 1.5 * 1.5, &what);
        }
    }
}

#[test]
fn a_structure_too_narrow_for_the_curvature_is_refused() {
    for (structure, curvature) in [
        (Structure::Banded { lower: 1, upper: 1 }, Structure::Banded { lower: 0, upper: 0 }),
        (sparse_band(9, 1, 1), sparse_band(9, 0, 0)),
    ] {
        match by_closure(&Products { structure, curvature, ahead: 1 }, Linear::METHOD_II) {
            Err(StepError::Solve { source: SolveError::OutsideStructure { row: 0, column: 1 }, .. }) => {}
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn nonlinear_method_i_is_the_same_in_every_structure_and_iteration() {
    let (n, h) = (24, 0.02);
    let field = field_of(Burgers { cells: n, viscosity: 0.05 });
    let v: Vec<f64> = (1..=n).map(|i| (std::f64::consts::PI * i as f64 / 25.0).sin()).collect();
    let dense = end(method_i(with_structure(Structure::Dense, &field)).expect("usable"), v.clone(), h, 0.2);
    // ‖B‖ ≤ 1 + h (4 ν/dx² + 1/dx).
    let condition = (1.0 + h * (4.0 * 0.05 * 625.0 + 25.0_f64)).powi(2);
    assert_same(&dense, &end(method_i(&field).expect("usable"), v.clone(), h, 0.2), 10.0, condition, "banded");
    let sparse = method_i(with_structure(sparse_band(n, 1, 1), &field)).expect("usable");
    assert_same(&dense, &end(sparse, v.clone(), h, 0.2), 10.0, condition, "sparse");
    for by in By::ALL {
        let method = by.method_i(&field).expect("fits");
        assert_same(&dense, &end(method, v.clone(), h, 0.2), 10.0, condition, &format!("{by:?}"));
    }
}

/// On the eigenvectors of the five-point Laplacian a step of Method I multiplies by 1/(1 − z + z²/2).
#[test]
fn plane_modes_decay_as_the_linear_theory_says() {
    let side = 12;
    let field = Plane { side };
    let mode = |k: usize, i: usize| (std::f64::consts::PI * (k * (i + 1)) as f64 / (side + 1) as f64).sin();
    let eigenvalue = |k: usize| {
        let s = (0.5 * std::f64::consts::PI * k as f64 / (side + 1) as f64).sin() * 2.0 * (side + 1) as f64;
        -s * s
    };
    let h = 0.02;
    for (k, l) in [(1, 1), (3, 2), (12, 12)] {
        let v: Vec<f64> = (0..side * side).map(|p| mode(k, p % side) * mode(l, p / side)).collect();
        let z = h * (eigenvalue(k) + eigenvalue(l));
        let factor = 1.0 / (1.0 - z + 0.5 * z * z);
        let methods = [
            method_i(&field).expect("usable"),
            By::Augmented.method_i(&field).expect("fits"),
            By::ConjugateGradients.method_i(&field).expect("fits"),
        ];
        for mut method in methods {
            let (mut q, mut p) = (v.clone(), vec![0.0; v.len()]);
            method.step(0.0, h, &mut q, &mut p).expect("solvable");
            // The condition number of I + BᵀB is below (1 + 8 h (side + 1)²)².
            let bound = 144.0 * f64::EPSILON * (1.0 + 8.0 * h * 169.0_f64).powi(2);
            q.iter().zip(&v).for_each(|(q, v)| assert_abs_diff_eq!(*q, factor * v, epsilon = bound));
        }
    }
}

/// With M given, M v̇ = f in the natural metric is v̇ = M⁻¹f in the metric M, which a change of variables v = M^(−½) w makes
/// Euclidean: for diagonal M the method on w is Method I of w' = M^(−½) f(M^(−½) w).
#[test]
fn the_natural_metric_does_not_depend_on_the_variables() {
    let n = 20;
    let weights: Vec<f64> = (0..n).map(|i| 1.0 + 0.5 * (i as f64).sin()).collect();
    let plain = Line::new(n, 5.0, Walls::Dirichlet);
    let massive = plain.clone().with_mass(Mass::Diagonal(weights.clone()));
    let scaled = plain.scaled(&weights.iter().map(|m| m.sqrt().recip()).collect::<Vec<_>>());
    let (h, steps) = (0.01, 10.0);
    let condition = 3.0 * (2.0 + h * (4.0 * 441.0 + 100.0_f64)).powi(2);
    let w: Vec<f64> = wave(n).iter().zip(&weights).map(|(v, m)| v * m.sqrt()).collect();
    let mut expected = end(method_i(&scaled).expect("usable"), w, h, 0.1);
    expected.iter_mut().zip(&weights).for_each(|(w, m)| *w /= m.sqrt());
    for by in By::ALL {
        let method = by.method_i(&massive).expect("fits");
        assert_same(&expected, &end(method, wave(n), h, 0.1), steps, condition, &format!("{by:?}"));
    }
    // The same through the Lagrangian, for M as a matrix, and where the metric is given instead.
    let mut matrix = Jacobian::with_structure(n, &Structure::Banded { lower: 0, upper: 0 });
    weights.iter().enumerate().for_each(|(i, &m)| matrix.add(i, i, m));
    let massive = plain.with_mass(Mass::Matrix(matrix));
    assert_same(&expected, &end(method_i(&massive).expect("usable"), wave(n), h, 0.1), steps, condition, "matrix");
    let dense = with_structure(Structure::Dense, &massive);
    assert_same(&expected, &end(method_i(&dense).expect("usable"), wave(n), h, 0.1), steps, condition, "dense");
    let inverse = nalgebra::DMatrix::from_fn(n, n, |i, j| if i == j { 1.0 / weights[i] } else { 0.0 });
    let given = LeastSquares::new(&dense).expect("usable").with_metric(inverse).expect("definite");
    let method = lsvi::Variational::new(lsvi::discrete::Trapezoidal::new(given), Linear::METHOD_I);
    assert_same(&expected, &end(method, wave(n), h, 0.1), steps, condition, "given metric");
}

/// 2h p₁ = h r₀ + B₁ᵀM⁻¹h r₁, with the inverse of a matrix.
#[test]
fn momenta_weigh_residuals_with_the_inverse_of_the_mass_matrix() {
    let (n, h) = (8, 0.01);
    let mut mass = Jacobian::with_structure(n, &Structure::Banded { lower: 1, upper: 1 });
    for i in 0..n {
        mass.add(i, i, 2.0 + 0.1 * i as f64);
        if i > 0 {
            mass.add(i, i - 1, 0.5);
            mass.add(i - 1, i, 0.5);
        }
    }
    let field = Line::new(n, 3.0, Walls::Dirichlet).with_mass(Mass::Matrix(mass));
    let closure = || Linear::new(0.3, 0.7).expect("not both zero");
    let lagrangian = LeastSquares::new(&field).expect("positive definite");
    let mut through_action = Variational::new(Trapezoidal::new(lagrangian), closure());
    let [mut v, mut expected] = [wave(n), vec![0.0; n]];
    through_action.step(0.0, h, &mut v, &mut expected).expect("solvable");
    // κ of the normal equations, and residuals as large as f.
    let f = 4.0 * ((n + 1) as f64).powi(2);
    let bound = 64.0 * f64::EPSILON * f * (1.0 + h * f).powi(2);
    assert!(expected.iter().any(|p| p.abs() > 1e-3), "{expected:?}");
    for structure in [Structure::Dense, Structure::Banded { lower: 1, upper: 1 }, sparse_band(n, 1, 1)] {
        let (mut v, mut p) = (wave(n), vec![0.0; n]);
        let mut direct = least_squares(with_structure(structure, &field), closure()).expect("usable");
        direct.step(0.0, h, &mut v, &mut p).expect("solvable");
        assert!(distance(&p, &expected) <= bound, "{p:?} {expected:?}");
    }
}

/// A tridiagonal mass matrix, as of linear elements, gives the baseline methods the solution of v̇ = M⁻¹f.
#[test]
fn baseline_methods_solve_with_the_mass_matrix() {
    let n = 16;
    let mut mass = Jacobian::with_structure(n, &Structure::Banded { lower: 1, upper: 1 });
    for i in 0..n {
        mass.add(i, i, 2.0 / 3.0);
        if i > 0 {
            mass.add(i, i - 1, 1.0 / 6.0);
            mass.add(i - 1, i, 1.0 / 6.0);
        }
    }
    let field = Line::new(n, 0.0, Walls::Dirichlet).without_source().with_mass(Mass::Matrix(mass));
    // The discrete sine of wave number 1: f = −μ v and M v = m v.
    let angle = std::f64::consts::PI / 17.0;
    let v: Vec<f64> = (1..=n).map(|i| (angle * i as f64).sin()).collect();
    let rate = -(2.0 * 17.0 * (0.5 * angle).sin()).powi(2) / (2.0 / 3.0 + angle.cos() / 3.0);
    let (a, b) = ([vec![0.0, 0.0], vec![0.5, 0.5]], [0.5, 0.5]);
    let together = CoupledRungeKutta::new(&field, &a, &b, &[0.0, 1.0]).expect("sizes that fit");
    let together = end(together, v.clone(), 5e-4, 0.1);
    let one_by_one = end(RungeKutta::new(&field, Tableau::trapezoidal()).expect("valid"), v.clone(), 5e-4, 0.1);
    assert_same(&together, &one_by_one, 200.0, 2.0, "the trapezoidal rule, its stages together");
    // RK4 is stable: h |λ_max| ≤ 5e-4 · 12 · 17² < 2.78.
    let (h, t_end) = (5e-4, 0.1);
    let z = h * rate;
    let growths = [
        (Tableau::implicit_euler(), 1.0 / (1.0 - z)),
        (Tableau::trapezoidal(), (1.0 + 0.5 * z) / (1.0 - 0.5 * z)),
        (Tableau::implicit_midpoint(), (1.0 + 0.5 * z) / (1.0 - 0.5 * z)),
        (Tableau::rk4(), 1.0 + z + z * z / 2.0 + z.powi(3) / 6.0 + z.powi(4) / 24.0),
    ];
    for (tableau, growth) in growths {
        let result = end(RungeKutta::new(&field, tableau).expect("usable"), v.clone(), h, t_end);
        // 200 steps, each with the rounding errors of h M⁻¹A of size h |λ_max| < 2.
        let bound = 200.0 * 16.0 * 2.0 * f64::EPSILON;
        result.iter().zip(&v).for_each(|(r, v)| assert_abs_diff_eq!(*r, growth.powi(200) * v, epsilon = bound));
    }
}

/// M v̇ = f with an M that is not symmetric is v̇ = M⁻¹f, and every implicit method takes the same steps on either.
#[test]
fn a_mass_that_is_not_symmetric_is_that_of_the_same_system() {
    const M: [[f64; 3]; 3] = [[2.0, 1.0, 0.0], [0.0, 1.0, -0.5], [0.25, 0.0, 1.0]];
    /// f = M A v, or A v without M, with A v = (v₁ − v₀, −v₀ − v₁ + v₂, −3 v₂ + cos t).
    struct Skewed {
        structure: Structure,
        has_mass: bool,
    }
    impl Skewed {
        fn image(&self, a: [f64; 3]) -> [f64; 3] {
            if self.has_mass { M.map(|row| row.iter().zip(a).map(|(m, a)| m * a).sum()) } else { a }
        }
    }
    impl VectorField for Skewed {
        fn dim(&self) -> usize {
            3
        }
        fn structure(&self) -> Structure {
            self.structure.clone()
        }
        fn mass(&self) -> Mass {
            let mut mass = Jacobian::with_structure(3, &self.structure);
            (0..9).for_each(|k| mass.add(k / 3, k % 3, M[k / 3][k % 3]));
            if self.has_mass { Mass::Matrix(mass) } else { Mass::Identity }
        }
        fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
            dv.copy_from_slice(&self.image([v[1] - v[0], v[2] - v[0] - v[1], t.cos() - 3.0 * v[2]]));
        }
        fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
            for (j, column) in [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, -3.0]].into_iter().enumerate() {
                self.image(column).into_iter().enumerate().for_each(|(i, x)| out.add(i, j, scale * x));
            }
        }
    }
    let full = || Structure::sparse(3, (0..9).map(|k| (k / 3, k % 3))).expect("inside");
    let band = Structure::Banded { lower: 2, upper: 2 };
    for structure in [Structure::Dense, band, full()] {
        let field = |has_mass| Skewed { structure: structure.clone(), has_mass };
        let runge_kutta = |tableau: fn() -> Tableau| {
            let method = |has_mass| RungeKutta::new(field(has_mass), tableau()).expect("usable");
            [true, false].map(|has_mass| end(method(has_mass), vec![1.0, -0.5, 2.0], 0.1, 1.0))
        };
        let tableaux: [fn() -> Tableau; 5] = [
            Tableau::implicit_euler,
            Tableau::trapezoidal,
            Tableau::implicit_midpoint,
            Tableau::sdirk2,
            Tableau::tr_bdf2,
        ];
        for [with, without] in tableaux.map(runge_kutta) {
            assert_same(&with, &without, 10.0, 10.0, "Runge–Kutta");
        }
        let bdf2 = |has_mass| end(Bdf2::new(field(has_mass)).expect("usable"), vec![1.0, -0.5, 2.0], 0.1, 1.0);
        assert_same(&bdf2(true), &bdf2(false), 10.0, 10.0, "BDF2");
        // On a linear f simplified Newton iterations end at once, if their factors are those of M.
        let adaptive = |has_mass| {
            let options = Options::new(Tolerances::new(1e-8, 1e-8).expect("positive")).h0(0.01).expect("positive");
            let mut method = Radau::new(field(has_mass), options).expect("usable");
            let found = end(&mut method, vec![1.0, -0.5, 2.0], 1.0, 1.0);
            (found, method.work().steps, method.work().residuals)
        };
        let [(with, steps, residuals), (without, other_steps, other_residuals)] = [true, false].map(adaptive);
        // The estimate of a first step is that of M⁻¹f too, so that no step is another one.
        assert_eq!((steps, residuals), (other_steps, other_residuals));
        assert_same(&with, &without, 10.0, 100.0, "Radau");
    }
}

/// The second derivatives of a least-squares Lagrangian in the natural metric of a diagonal M have the structure of JᵀJ, and all
/// discretisations follow it: their steps are those of dense matrices.
#[test]
fn discretisations_follow_the_structure_of_the_field() {
    let (n, h) = (14, 0.02);
    let field = field_of(Burgers { cells: n, viscosity: 0.05 });
    let weights = Mass::Diagonal((0..n).map(|i| 1.0 + 0.5 * (i as f64).sin()).collect());
    let v: Vec<f64> = (1..=n).map(|i| (std::f64::consts::PI * i as f64 / 15.0).sin()).collect();
    let structures = [Structure::Dense, Structure::Banded { lower: 1, upper: 1 }, sparse_band(n, 1, 1)];
    for mass in [Mass::Identity, weights] {
        let results = structures.clone().map(|structure| {
            let lagrangian = || {
                LeastSquares::new(Massive(mass.clone(), with_structure(structure.clone(), &field))).expect("positive")
            };
            let kept = lagrangian().structure() != Structure::Dense;
            assert_eq!(kept, structure != Structure::Dense);
            let end = |method: &mut dyn Integrator| end(method, v.clone(), h, 0.2);
            let lobatto = Galerkin::lobatto(lagrangian(), 2).expect("s ≥ 1");
            let radau = Galerkin::new(lagrangian(), 2, &Quadrature::radau(2).expect("r ≥ 1")).expect("s ≤ r");
            [
                end(&mut Variational::new(lobatto, Linear::METHOD_I)),
                end(&mut Variational::new(radau, Linear::METHOD_I)),
                end(&mut Variational::new(Midpoint::new(lagrangian()), Linear::METHOD_I)),
                end(&mut Window::new(Trapezoidal::new(lagrangian()), 4).expect("not empty")),
                end(&mut Window::new(Galerkin::lobatto(lagrangian(), 2).expect("s ≥ 1"), 3).expect("not empty")),
            ]
        });
        let [dense, banded, sparse] = results;
        // ‖B‖ ≤ 1 + h (4 ν/dx² + 1/dx), over masses ≥ ½, squared in the normal equations.
        let condition = 2.0 * (1.0 + 2.0 * h * (4.0 * 0.05 * 225.0 + 15.0_f64)).powi(2);
        for (k, ((dense, banded), sparse)) in dense.iter().zip(&banded).zip(&sparse).enumerate() {
            assert_same(dense, banded, 10.0, condition, &format!("banded, {k}"));
            assert_same(dense, sparse, 10.0, condition, &format!("sparse, {k}"));
        }
    }
}

/// A field with another mass.
struct Massive<F>(Mass, F);

impl<F: VectorField> VectorField for Massive<F> {
    fn dim(&self) -> usize {
        self.1.dim()
    }
    fn structure(&self) -> Structure {
        self.1.structure()
    }
    fn mass(&self) -> Mass {
        self.0.clone()
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.1.rhs(t, v, dv);
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        self.1.add_jacobian(t, v, scale, out);
    }
    fn add_curvature(&self, t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        self.1.add_curvature(t, v, w, scale, out);
    }
}

#[test]
fn an_entry_outside_the_declared_structure_is_refused() {
    let n = 10;
    let v = wave(n);
    let narrow = Structure::Banded { lower: 1, upper: 0 };
    let expect = |result: Result<(), StepError>| {
        let Err(StepError::Solve { source: SolveError::OutsideStructure { row, column }, .. }) = result else {
            panic!("{result:?}");
        };
        assert_eq!(column, row + 1);
    };
    fn step(mut method: impl OneStep, v: &[f64]) -> Result<(), StepError> {
        method.step(0.0, 0.1, &mut v.to_vec(), &mut vec![0.0; v.len()])
    }
    let linear = with_structure(narrow.clone(), Line::new(n, 1.0, Walls::Dirichlet));
    let automatic = field_of(As(narrow, Burgers { cells: n, viscosity: 0.1 }));
    expect(step(RungeKutta::new(&linear, Tableau::implicit_euler()).expect("usable"), &v));
    expect(step(RungeKutta::new(&automatic, Tableau::implicit_euler()).expect("usable"), &v));
    expect(step(method_i(&linear).expect("usable"), &v));
    expect(step(method_i(&automatic).expect("usable"), &v));
    for by in By::ALL {
        expect(step(by.method_i(&linear).expect("fits"), &v));
        expect(step(by.method_i(&automatic).expect("fits"), &v));
    }
}

#[test]
fn unusable_solvers_and_masses_are_refused_at_once() {
    let line = || Line::new(5, 0.0, Walls::Dirichlet);
    let refused = |field: &dyn VectorField, by: By| by.method_i(field).err();
    let dense = with_structure(Structure::Dense, line());
    assert!(matches!(refused(&dense, By::Twisted), Some(InputError::System(SystemError::Solver(_)))));
    for tolerance in [0.0, -1.0, 1.0, f64::NAN] {
        let solver = Iterative::new(Factored::default()).with_tolerance(tolerance);
        assert!(matches!(solver.err(), Some(InputError::Setting(SettingError::SolverTolerance(_)))));
    }
    let matrix = |entries: &[(usize, usize, f64)]| {
        let mut m = Jacobian::with_structure(5, &Structure::Banded { lower: 1, upper: 1 });
        (0..5).for_each(|i| m.add(i, i, 1.0));
        entries.iter().for_each(|&(i, j, x)| m.add(i, j, x));
        Mass::Matrix(m)
    };
    let masses = [
        (Mass::Diagonal(vec![1.0; 4]), "length"),
        (Mass::Diagonal(vec![1.0, 1.0, 0.0, 1.0, 1.0]), "definite"),
        (matrix(&[(0, 1, 0.5)]), "symmetric"),
        (matrix(&[(0, 1, 1.5), (1, 0, 1.5)]), "definite"),
        (matrix(&[(0, 4, 0.1)]), "outside"),
    ];
    for (mass, what) in masses {
        let field = line().with_mass(mass);
        assert!(refused(&field, By::Augmented).is_some(), "{what}");
        assert!(method_i(&field).is_err(), "{what}");
        let dense = with_structure(Structure::Dense, &field);
        assert!(method_i(&dense).is_err(), "{what}");
        assert!(LeastSquares::new(&dense).is_err(), "{what}");
    }
    assert!(Structure::sparse(3, [(0, 3)]).is_err());
}

/// A singular M makes an equation algebraic; explicit stages have no use for it.
#[test]
fn a_singular_mass_is_for_implicit_methods() {
    let field = Line::new(3, 0.0, Walls::Dirichlet).without_source().with_mass(Mass::Diagonal(vec![1.0, 0.0, 1.0]));
    let mut v = vec![1.0, 0.0, 1.0];
    RungeKutta::new(&field, Tableau::implicit_euler())
        .expect("usable")
        .step(0.0, 0.1, &mut v, &mut [])
        .expect("solvable");
    assert_abs_diff_eq!(2.0 * v[1], v[0] + v[2], epsilon = 1e-14);
    for tableau in [Tableau::rk4(), Tableau::trapezoidal()] {
        let explicit = tableau == Tableau::rk4();
        assert_eq!(
            RungeKutta::new(&field, tableau).err(),
            explicit.then_some(InputError::System(SystemError::SingularMass))
        );
    }
}

/// Steps up to a hundred times the time in which the front forms: the damped iteration finds the root of Newton's branch.
#[test]
fn gauss_newton_and_newton_agree_on_long_steps() {
    let n = 40;
    let field = field_of(Burgers { cells: n, viscosity: 0.01 });
    let v: Vec<f64> = (1..=n).map(|i| (std::f64::consts::PI * i as f64 / 41.0).sin()).collect();
    for h in [0.1, 1.0, 10.0, 100.0] {
        let (mut expected, mut p) = (v.clone(), vec![0.0; n]);
        method_i(&field).expect("usable").step(0.0, h, &mut expected, &mut p).expect("on the branch");
        for by in By::ALL {
            let mut method = by.method_i(&field).expect("fits");
            let mut q = v.clone();
            method.step(0.0, h, &mut q, &mut p).expect("convergent");
            // Both stop at increments of a few ε; the augmented condition number is below 1 + h (4 ν/dx² + 1/dx).
            assert_same(&q, &expected, 1.0, 1.0 + h * (4.0 * 0.01 * 1681.0 + 41.0), &format!("h = {h}, {by:?}"));
        }
    }
}

/// A lower triangular tableau solved stage by stage, and with its stages together, with a mass matrix and without.
#[test]
fn stages_found_together_are_those_found_one_by_one() {
    let gamma = 1.0 - 0.5 * std::f64::consts::SQRT_2;
    let sdirk = (vec![vec![gamma, 0.0], vec![1.0 - gamma, gamma]], vec![1.0 - gamma, gamma], vec![gamma, 1.0]);
    let lobatto = (vec![vec![0.0, 0.0], vec![0.5, 0.5]], vec![0.5, 0.5], vec![0.0, 1.0]);
    let line = Line::new(12, 0.1, Walls::Dirichlet);
    let burgers = field_of(Burgers { cells: 12, viscosity: 0.1 });
    let fields: [&dyn VectorField; 3] = [&line, &burgers, &with_structure(Structure::Dense, &burgers)];
    for (a, b, c) in [sdirk, lobatto] {
        for field in fields {
            let one_by_one = RungeKutta::new(field, Tableau::lower_triangular(&a, &b, &c).expect("lower triangular"))
                .expect("valid");
            let together = CoupledRungeKutta::new(field, &a, &b, &c).expect("sizes that fit");
            assert_same(
                &end(one_by_one, wave(12), 0.01, 0.1),
                &end(together, wave(12), 0.01, 0.1),
                10.0,
                10.0,
                "stages",
            );
        }
    }
    let error = Tableau::lower_triangular(&[vec![0.0, 1.0], vec![0.0, 0.0]], &[0.5, 0.5], &[0.0, 1.0]);
    assert_eq!(error, Err(InputError::Nodes(NodeError::AboveDiagonal { row: 0, column: 1 })));
    let rows = [vec![0.0, 0.0, 0.5], vec![0.5, 0.0, 0.0], vec![0.0, 0.5, 0.0]];
    let error = Tableau::lower_triangular(&rows, &[0.0, 0.0, 1.0], &[0.5, 0.5, 0.5]).map(|_| ());
    assert_eq!(error, Err(InputError::Nodes(NodeError::AboveDiagonal { row: 0, column: 2 })));
    let error = CoupledRungeKutta::new(&line, &[vec![0.5]], &[0.5, 0.5], &[0.5, 0.5]).map(|_| ());
    assert!(matches!(error, Err(InputError::System(SystemError::Dimension { what: "A", .. }))), "{error:?}");
}

/// Of A, b and c the one whose length differs from that of the other two.
#[test]
fn the_part_of_a_tableau_that_is_too_short_or_too_long_is_named() {
    let square = |stages: usize| vec![vec![0.0; stages]; stages];
    let named = |a: usize, b: usize, c: usize| {
        let error = Tableau::lower_triangular(&square(a), &vec![1.0 / b as f64; b], &vec![0.0; c]);
        error.expect_err("sizes differ").to_string()
    };
    for (sizes, part, expected, found) in [
        ([2, 1, 2], "b", 2, 1),
        ([2, 3, 2], "b", 2, 3),
        ([2, 2, 1], "c", 2, 1),
        ([1, 2, 2], "A", 2, 1),
        ([3, 2, 2], "A", 2, 3),
        ([0, 1, 0], "c", 1, 0),
        ([0, 0, 0], "b", 1, 0),
    ] {
        let [a, b, c] = sizes;
        assert_eq!(named(a, b, c), format!("{part} has length {found}, expected {expected}"), "{sizes:?}");
    }
}

/// v̇ = −v² on three unknowns that do not know of each other.
struct Drag {
    is_linear: bool,
}

impl VectorField for Drag {
    fn dim(&self) -> usize {
        3
    }
    fn structure(&self) -> Structure {
        Structure::Banded { lower: 0, upper: 0 }
    }
    fn is_linear(&self) -> bool {
        self.is_linear
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv.iter_mut().zip(v).for_each(|(dv, v)| *dv = -v * v);
    }
    fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        v.iter().enumerate().for_each(|(i, v)| out.add(i, i, -2.0 * scale * v));
    }
}

#[test]
fn a_field_that_is_not_linear_as_it_says_is_refused() {
    for start in [1.0, 0.0] {
        let step = method_i(Drag { is_linear: true }).expect("valid").step(0.0, 0.1, &mut [start; 3], &mut [0.0; 3]);
        let Err(StepError::Solve { source: SolveError::NotLinear { row: 0, difference }, .. }) = step else {
            panic!("{step:?}")
        };
        assert_eq!(difference, -1.0);
    }
    method_i(Line::new(30, 3.0, Walls::Neumann))
        .expect("valid")
        .step(0.0, 10.0, &mut wave(30), &mut [0.0; 30])
        .expect("linear");
}

#[test]
fn second_derivatives_from_differences_give_the_same_steps() {
    for h in [0.1, 0.5, 1.0] {
        let mut v = [[1.0, -0.2, 0.5]; 3];
        method_i(field_of(crate::fields::Drag))
            .expect("valid")
            .step(0.0, h, &mut v[0], &mut [0.0; 3])
            .expect("solvable");
        method_i(Drag { is_linear: false }).expect("valid").step(0.0, h, &mut v[1], &mut [0.0; 3]).expect("solvable");
        method_i(with_structure(Structure::Dense, Drag { is_linear: false }))
            .expect("valid")
            .step(0.0, h, &mut v[2], &mut [0.0; 3])
            .expect("solvable");
        // Newton's iteration stops on increments of 4 ε; the equations are well conditioned.
        (1..3).for_each(|i| assert!(distance(&v[0], &v[i]) <= 16.0 * f64::EPSILON, "h = {h}: {v:?}"));
    }
}

/// A v + g with a symmetric band A and constant g, or with g sin t.
struct Still {
    cells: usize,
    width: usize,
    is_autonomous: bool,
    changes: bool,
    mass: Mass,
}

impl Still {
    fn entry(&self, i: usize, j: usize) -> f64 {
        if i == j { -2.0 - self.width as f64 } else { 1.0 / (1.0 + i.abs_diff(j) as f64 + 0.1 * (i + j) as f64) }
    }
    fn band(&self, i: usize) -> std::ops::Range<usize> {
        i.saturating_sub(self.width)..(i + self.width + 1).min(self.cells)
    }
}

impl VectorField for Still {
    fn dim(&self) -> usize {
        self.cells
    }
    fn structure(&self) -> Structure {
        Structure::Banded { lower: self.width, upper: self.width }
    }
    fn mass(&self) -> Mass {
        self.mass.clone()
    }
    fn is_linear(&self) -> bool {
        true
    }
    fn is_autonomous(&self) -> bool {
        self.is_autonomous
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        for (i, dv) in dv.iter_mut().enumerate() {
            let source = if self.changes { t.sin() } else { 1.0 + 0.1 * i as f64 };
            *dv = self.band(i).map(|j| self.entry(i, j) * v[j]).sum::<f64>() + source;
        }
    }
    fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        (0..v.len()).for_each(|i| self.band(i).for_each(|j| out.add(i, j, scale * self.entry(i, j))));
    }
}

#[test]
fn a_step_that_is_one_pass_over_a_band_is_the_same_step() {
    for cells in [1, 2, 3, 4, 5, 8, 31] {
        for width in [0, 1, 2, 3] {
            let mass = Mass::Diagonal((0..cells).map(|i| 1.0 + 0.2 * (i % 3) as f64).collect());
            for mass in [Mass::Identity, mass] {
                let [marched, solved] = [true, false].map(|is_autonomous| {
                    let field = Still { cells, width, is_autonomous, changes: false, mass: mass.clone() };
                    end(method_i(field).expect("usable"), wave(cells), 0.5, 10.0)
                });
                let augmented = By::Augmented
                    .method_i(Still { cells, width, is_autonomous: true, changes: false, mass: mass.clone() })
                    .expect("usable");
                let augmented = end(augmented, wave(cells), 0.5, 10.0);
                // κ(M + BᵀM⁻¹B) ≤ (1 + h‖A‖)², ‖A‖ ≤ 4 + 2 width, times the ratio 1.4² of masses.
                let condition = 2.0 * (1.0 + 0.5 * (4.0 + 2.0 * width as f64)).powi(2);
                assert_same(&marched, &solved, 20.0, condition, &format!("{cells} cells, width {width}"));
                assert_same(&marched, &augmented, 20.0, condition, &format!("{cells} cells, width {width}, augmented"));
            }
        }
    }
}

#[test]
fn a_pass_over_a_band_refuses_what_a_step_refuses() {
    let field = |changes| Still { cells: 9, width: 1, is_autonomous: true, changes, mass: Mass::Identity };
    let step = method_i(field(true)).expect("valid").step(0.0, 0.1, &mut wave(9), &mut [0.0; 9]);
    assert!(matches!(step, Err(StepError::Solve { source: SolveError::NotAutonomous { row: 0, .. }, .. })), "{step:?}");
    let mut method = method_i(field(false)).expect("valid");
    let (mut v, mut p) = (wave(9), [0.0; 9]);
    method.step(0.0, 0.1, &mut v, &mut p).expect("solvable");
    for bad in [f64::NAN, f64::INFINITY, 1e300] {
        let mut spoiled = v.clone();
        spoiled[4] = bad;
        let before = spoiled.clone();
        assert!(method.step(0.1, 0.1, &mut spoiled, &mut p).is_err() || bad == 1e300);
        assert!(bad == 1e300 || spoiled.iter().zip(&before).all(|(a, b)| a.to_bits() == b.to_bits()), "{spoiled:?}");
        let mut q = v.clone();
        assert!(method.step(0.1, 0.1, &mut q, &mut [bad; 9]).is_err() || bad == 1e300);
    }
    // Of several steps one is not looked at again.
    for _ in 0..4 {
        let mut other = [1.0; 9];
        method.step(0.1, 0.1, &mut v, &mut other).expect("solvable");
        assert_eq!(other, [0.0; 9], "the momentum at the end of a step of Method I");
        assert!(method.step(0.1, 0.1, &mut v.clone(), &mut [0.0; 8]).is_err());
        assert!(method.step(0.1, 0.1, &mut v[..8].to_vec(), &mut p).is_err());
    }
}

/// Not what roundings leave of it.
#[test]
fn the_momentum_of_method_i_is_zero() {
    let field = AutoField::new(Burgers { cells: 12, viscosity: 0.05 });
    for structure in [Structure::Dense, Structure::Banded { lower: 1, upper: 1 }, sparse_band(12, 1, 1)] {
        let (mut v, mut p) = (wave(12), vec![1.0; 12]);
        method_i(with_structure(structure, &field)).expect("usable").step(0.0, 0.05, &mut v, &mut p).expect("solvable");
        assert_eq!(p, [0.0; 12]);
    }
}
