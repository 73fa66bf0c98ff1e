//! What steps cost and where they lead, as a golden: counts of work tell a slower iteration, digits a wrong coefficient.
//!
//! Refresh it with `INSTA_UPDATE=always cargo test -p lsvi --test it work`, and read the difference.

use std::fmt::Write;

use crate::fields::{As, Autonomous, Burgers, By, Line, Products, Unscaled, Walls};
use crate::systems::{ChargedParticle, Damping, Driven, Falling, HenonHeiles, Pendulum, Sphere};
use lsvi::adaptive::{Options, Radau, Tolerances};
use lsvi::classic::{Bdf2, CoupledRungeKutta, RungeKutta, Tableau};
use lsvi::closure::Linear;
use lsvi::discrete::{BrokenLine, Galerkin, Midpoint, PathFitted, Trapezoidal};
use lsvi::quadrature::NodeFamily;
use lsvi::solver::Iterative;
use lsvi::{
    AutoConstraint, AutoField, AutoForce, AutoLagrangian, Constrained, EulerLagrange, FieldFn, Forced, Integrator,
    LagrangianFn, LeastSquares, LeastSquaresStep, Mass, Scalar, State, Structure, Trajectory, Variational, VectorField,
    Window, field, least_squares, method_i, method_ii, position_momentum,
};

/// Burgers' equation with a source that travels and a viscosity that breathes.
#[derive(Clone, Copy)]
struct Travelling(Burgers);

impl FieldFn for Travelling {
    fn dim(&self) -> usize {
        self.0.cells
    }
    fn structure(&self) -> Structure {
        FieldFn::structure(&self.0)
    }
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
        Burgers { viscosity: self.0.viscosity * (1.0 + 0.5 * (5.0 * t).sin()), ..self.0 }.rhs(t, v, dv);
        dv.iter_mut().enumerate().for_each(|(i, dv)| *dv += (0.7 * i as f64 - 3.0 * t).cos());
    }
}

/// A separable Lagrangian whose potential changes with time.
struct Tides;

impl LagrangianFn for Tides {
    fn dim(&self) -> usize {
        2
    }
    fn is_separable(&self) -> bool {
        true
    }
    fn lagrangian<T: Scalar>(&self, t: T, q: &[T], v: &[T]) -> T {
        let well = q[0] * q[0] + q[0] * q[1] * 0.5 + (q[1] * 2.0).cos();
        v[0] * v[0] * 0.5 + v[1] * v[1] * 1.5 + v[0] * v[1] * 0.2 - well * ((t * 3.0).sin() * 0.4 + 1.0)
    }
}

/// In one line what ten steps from t = 1 take, and where they end, to eight decimals.
fn line(table: &mut String, name: &str, h: f64, start: &State, method: impl Integrator) {
    let start = State { t: 1.0, ..start.clone() };
    let mut run = Trajectory::new(method, start, h, 1.0 + 10.0 * h).expect("usable");
    let stopped = loop {
        match run.step() {
            Ok(Some(_)) => {}
            Ok(None) => break None,
            Err(error) => break Some(error),
        }
    };
    let (work, state) = (run.work(), run.state());
    let digits: Vec<String> =
        state.q.iter().chain(&state.p).take(4).map(|x| format!("{:.8}", (x * 1e8).round() / 1e8 + 0.0)).collect();
    let digits = digits.join(" ");
    // What a failure costs goes by the rounding of the last attempts.
    let counts = match stopped {
        None => format!(
            "steps {} residuals {} matrices {} inner {}",
            work.steps, work.residuals, work.factorizations, work.inner
        ),
        Some(_) => format!("stops at {:.6}", state.t),
    };
    writeln!(table, "{name:32} h {h:<5} {digits} | {counts}").expect("a string");
}

/// A table without the counts, which go by rounding where factors are another library's.
fn without_counts(table: &str) -> String {
    table.lines().map(|line| line.split(" | ").next().unwrap_or_default().to_string() + "\n").collect()
}

/// Every kind of step of a field, by name.
fn of_field(table: &mut String, h: f64, v: &[f64], f: &dyn VectorField) {
    let start = State::new(1.0, v.to_vec());
    let mut line = |name: &str, method: &mut dyn Integrator| self::line(table, name, h, &start, method);
    line("method-i", &mut method_i(f).expect("usable"));
    line("method-ii", &mut method_ii(f).expect("usable"));
    line("closure 0.3, 0.7", &mut least_squares(f, Linear::new(0.3, 0.7).expect("finite")).expect("usable"));
    line("closure -0.8, 1", &mut least_squares(f, Linear::new(-0.8, 1.0).expect("finite")).expect("usable"));
    line("fitted 1", &mut least_squares(f, Linear::fitted(1.0).expect("finite")).expect("usable"));
    for by in By::ALL {
        if let Ok(mut method) = RungeKutta::with_solver(f, Tableau::sdirk2(), by.solver()) {
            line(&format!("sdirk2 by {by:?}"), &mut method);
        }
        if let Ok(mut method) = by.method_i(f) {
            line(&format!("method-i by {by:?}"), &mut method);
        }
        if let Ok(mut method) = LeastSquaresStep::with_solver(f, Linear::METHOD_II, by.solver()) {
            line(&format!("method-ii by {by:?}"), &mut method);
        }
    }
    let l = || LeastSquares::new(f).expect("usable");
    line("trapezoidal, ends", &mut Variational::new(Trapezoidal::new(l()), Linear::METHOD_I));
    line("midpoint, momenta", &mut Variational::new(Midpoint::new(l()), Linear::METHOD_II));
    line("galerkin 2", &mut Variational::new(Galerkin::gauss(l(), 2).expect("s >= 1"), Linear::METHOD_I));
    line("window of 3", &mut Window::new(Trapezoidal::new(l()), 3).expect("a length"));
    let tableaus = [
        ("implicit-euler", Tableau::implicit_euler()),
        ("trapezoidal rule", Tableau::trapezoidal()),
        ("sdirk2", Tableau::sdirk2()),
        ("tr-bdf2", Tableau::tr_bdf2()),
        ("rk4", Tableau::rk4()),
    ];
    for (name, tableau) in tableaus {
        line(name, &mut RungeKutta::new(f, tableau).expect("usable"));
    }
    line("bdf2", &mut Bdf2::new(f).expect("usable"));
    let r = 3_f64.sqrt() / 6.0;
    let a = [vec![0.25, 0.25 - r], vec![0.25 + r, 0.25]];
    line("gauss 2", &mut CoupledRungeKutta::new(f, &a, &[0.5, 0.5], &[0.5 - r, 0.5 + r]).expect("usable"));
    for tolerance in [1e-3, 1e-6, 1e-10] {
        let tolerances = || Tolerances::new(tolerance, tolerance).expect("in (0, 1)");
        line(&format!("radau {tolerance:e}"), &mut Radau::new(f, tolerances()).expect("usable"));
        let fixed = Options::new(tolerances()).stages(3, 3).expect("odd");
        line(&format!("radau of 3 stages {tolerance:e}"), &mut Radau::new(f, fixed).expect("usable"));
    }
}

/// Every kind of step of a field that is known by its products.
fn of_products(table: &mut String, h: f64, v: &[f64], f: &dyn VectorField) {
    let start = State::new(1.0, v.to_vec());
    let mut line = |name: &str, method: &mut dyn Integrator| self::line(table, name, h, &start, method);
    let solver = || Iterative::new(Unscaled);
    line("method-i", &mut LeastSquaresStep::with_solver(f, Linear::METHOD_I, solver()).expect("usable"));
    line("method-ii", &mut LeastSquaresStep::with_solver(f, Linear::METHOD_II, solver()).expect("usable"));
    line("sdirk2", &mut RungeKutta::with_solver(f, Tableau::sdirk2(), solver()).expect("usable"));
    line("bdf2", &mut Bdf2::with_solver(f, solver).expect("usable"));
}

/// Every kind of step of a motion.
fn of_motion(table: &mut String, h: f64, start: &State, l: &dyn EulerLagrange) {
    let mut line = |name: &str, method: &mut dyn Integrator| self::line(table, name, h, start, method);
    line("trapezoidal", &mut position_momentum(Trapezoidal::new(l)));
    line("midpoint", &mut position_momentum(Midpoint::new(l)));
    for s in 1..=4 {
        line(&format!("galerkin-gauss {s}"), &mut position_momentum(Galerkin::gauss(l, s).expect("s >= 1")));
    }
    line("galerkin-lobatto 3", &mut position_momentum(Galerkin::lobatto(l, 3).expect("s >= 1")));
    for m in [2, 4] {
        let discrete = PathFitted::on(l, NodeFamily::Equispaced, m).expect("m >= 2");
        line(&format!("path-fitted {m}"), &mut position_momentum(discrete));
    }
    line("window of 4", &mut Window::new(Trapezoidal::new(l), 4).expect("a length"));
    if let Ok(discrete) = BrokenLine::blanes_moan(l) {
        line("blanes-moan", &mut position_momentum(discrete));
    }
}

#[test]
fn steps_of_first_order_systems() {
    let mut table = String::new();
    let scalar = field!(1, |t, v, dv| dv[0] = v[0] * -(2.0 + t.sin()) - v[0] * v[0] * 0.25 + (3.0 * t).cos());
    let relay = field!(2, |t, v, dv| {
        dv[0] = v[1] * (1.0 + 0.5 * t.sin());
        dv[1] = (T::from(1.0) - v[0] * v[0]) * v[1] * 5.0 - v[0] + (2.0 * t).cos();
    });
    let chain = Travelling(Burgers { cells: 9, viscosity: 0.05 });
    let wave: Vec<f64> = (0..9).map(|i| (0.5 * f64::from(i)).sin()).collect();
    for h in [0.01, 0.1, 0.4] {
        writeln!(table, "# one unknown").expect("a string");
        of_field(&mut table, h, &[0.8], &scalar);
        writeln!(table, "# a relaxation oscillator").expect("a string");
        of_field(&mut table, h, &[1.5, 0.3], &relay);
        writeln!(table, "# Burgers' equation, banded").expect("a string");
        of_field(&mut table, h, &wave, &AutoField::new(chain));
        writeln!(table, "# Burgers' equation, dense").expect("a string");
        let mut dense = String::new();
        of_field(&mut dense, h, &wave, &AutoField::new(As(Structure::Dense, chain)));
        table += &without_counts(&dense);
        writeln!(table, "# Burgers' equation, by products").expect("a string");
        of_products(&mut table, h, &wave, &Products::new(AutoField::new(chain)));
    }
    let line = || Line::new(9, 5.0, Walls::Dirichlet);
    let weights = || Mass::Diagonal((0..9).map(|i| 1.0 + 0.1 * f64::from(i)).collect());
    for h in [0.01, 0.1] {
        writeln!(table, "# a linear equation").expect("a string");
        of_field(&mut table, h, &wave, &line());
        writeln!(table, "# a linear equation with weights").expect("a string");
        of_field(&mut table, h, &wave, &line().with_mass(weights()));
        writeln!(table, "# a linear equation without time").expect("a string");
        of_field(&mut table, h, &wave, &Autonomous(line()));
        writeln!(table, "# a symmetric one with weights").expect("a string");
        let symmetric = Line::new(9, 0.0, Walls::Dirichlet).with_mass(weights());
        of_field(&mut table, h, &wave, &Autonomous(symmetric));
        writeln!(table, "# a linear equation by products").expect("a string");
        of_products(&mut table, h, &wave, &Products::new(line()));
    }
    insta::assert_snapshot!(table);
}

#[test]
fn steps_of_motions() {
    let mut table = String::new();
    let plane = State::new(1.0, vec![0.1, 0.3]).with_momentum(vec![0.4, -0.2]);
    for h in [0.01, 0.1, 0.5] {
        writeln!(table, "# a pendulum").expect("a string");
        let pendulum = State::new(1.0, vec![2.0]).with_momentum(vec![0.5]);
        of_motion(&mut table, h, &pendulum, &AutoLagrangian::new(Pendulum));
        writeln!(table, "# Henon and Heiles's potential").expect("a string");
        of_motion(&mut table, h, &plane, &AutoLagrangian::new(HenonHeiles));
        writeln!(table, "# a separable potential that changes with time").expect("a string");
        of_motion(&mut table, h, &plane, &AutoLagrangian::new(Tides));
        writeln!(table, "# a charged particle").expect("a string");
        of_motion(&mut table, h, &plane, &AutoLagrangian::new(ChargedParticle));
        writeln!(table, "# a Lagrangian that depends on everything").expect("a string");
        of_motion(&mut table, h, &plane, &AutoLagrangian::new(Driven));
        writeln!(table, "# a pendulum with friction").expect("a string");
        let damping = AutoForce::new(Damping { dim: 1, rate: 0.3 });
        let l = Forced::new(AutoLagrangian::new(Pendulum), damping).expect("of one dimension");
        line(&mut table, "trapezoidal", h, &pendulum, position_momentum(Trapezoidal::new(&l)));
        line(&mut table, "midpoint", h, &pendulum, position_momentum(Midpoint::new(&l)));
        let gauss = Galerkin::gauss(&l, 2).expect("s >= 1");
        line(&mut table, "galerkin-gauss 2", h, &pendulum, position_momentum(gauss));
        writeln!(table, "# a spherical pendulum").expect("a string");
        let l = AutoLagrangian::new(Falling { dim: 3 });
        let sphere = || AutoConstraint::new(Sphere { dim: 3 });
        let swing = State::new(1.0, vec![0.6, 0.0, -0.8]).with_momentum(vec![0.4, 0.7, 0.3]);
        let gauss = Constrained::new(Galerkin::gauss(&l, 2).expect("s >= 1"), sphere()).expect("dimensions fit");
        line(&mut table, "galerkin-gauss 2", h, &swing, gauss);
        let rattle = Constrained::new(Trapezoidal::new(&l), sphere()).expect("dimensions fit");
        line(&mut table, "trapezoidal", h, &swing, rattle);
    }
    insta::assert_snapshot!(table);
}
