//! Implicit methods on differential equations with algebraic ones.

use crate::systems::field_of;
use lsvi::adaptive::{Radau, Tolerances};
use lsvi::classic::{Bdf2, CoupledRungeKutta, RungeKutta, Tableau};
use lsvi::{
    FieldFn, InputError, Integrator, Jacobian, Mass, OneStep, Scalar, State, StepError, Structure, SystemError,
    Trajectory, VectorField,
};

/// v̇₀ = −v₀, 0 = v₁ − v₀²: what rounding leaves of the second equation at a start is no direction.
struct OnParabola;

impl FieldFn for OnParabola {
    fn dim(&self) -> usize {
        2
    }
    fn mass(&self) -> Mass {
        Mass::Diagonal(vec![1.0, 0.0])
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = -v[0];
        dv[1] = v[1] - v[0] * v[0];
    }
}

#[test]
fn an_algebraic_equation_that_holds_to_rounding_stops_no_implicit_method() {
    let field = field_of(OnParabola);
    let r = 3_f64.sqrt() / 6.0;
    let gauss = [vec![0.25, 0.25 - r], vec![0.25 + r, 0.25]];
    for h in [0.1, 0.05, 0.01] {
        let methods: [(&str, Box<dyn Integrator + '_>, f64); 5] = [
            ("implicit Euler", Box::new(RungeKutta::new(&field, Tableau::implicit_euler()).expect("fits")), 0.2 * h),
            ("SDIRK2", Box::new(RungeKutta::new(&field, Tableau::sdirk2()).expect("fits")), h * h),
            ("TR-BDF2", Box::new(RungeKutta::new(&field, Tableau::tr_bdf2()).expect("fits")), h * h),
            ("BDF2", Box::new(Bdf2::new(&field).expect("fits")), h * h),
            (
                "Gauss",
                Box::new(CoupledRungeKutta::new(&field, &gauss, &[0.5, 0.5], &[0.5 - r, 0.5 + r]).expect("fits")),
                h * h,
            ),
        ];
        for (name, method, allowed) in methods {
            let run = Trajectory::new(method, State::new(0.0, vec![1.0, 1.0]), h, 1.0).expect("fits");
            let end = run.observe(|_| {}).unwrap_or_else(|error| panic!("{name}, h = {h}: {error}")).q;
            let error = (end[0] - (-1_f64).exp()).abs();
            assert!(error <= allowed, "{name}, h = {h}: {error}");
            assert!(name == "Gauss" || (end[1] - end[0] * end[0]).abs() <= 1e-14, "{name}, h = {h}: {end:?}");
        }
    }
}

/// 0 = v₁ − v₀ − t in turn with v̇₀ = −v₁.
struct OnLine;

impl FieldFn for OnLine {
    fn dim(&self) -> usize {
        2
    }
    fn mass(&self) -> Mass {
        Mass::Diagonal(vec![1.0, 0.0])
    }
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = -v[1];
        dv[1] = v[1] - v[0] - t;
    }
}

/// The trapezoidal rule would turn the sign of what the start violates in each step, and Gauss's too.
#[test]
fn a_method_that_carries_a_violation_on_refuses_the_start() {
    let field = field_of(OnLine);
    let half = [vec![0.5]];
    let r = 3_f64.sqrt() / 6.0;
    let gauss = [vec![0.25, 0.25 - r], vec![0.25 + r, 0.25]];
    let methods = || -> [(&str, Box<dyn Integrator + '_>, bool); 7] {
        let tableau = |tableau| Box::new(RungeKutta::new(&field, tableau).expect("fits"));
        let coupled =
            |a: &[Vec<f64>], b: &[f64], c: &[f64]| Box::new(CoupledRungeKutta::new(&field, a, b, c).expect("fits"));
        [
            ("trapezoidal", tableau(Tableau::trapezoidal()), true),
            ("TR-BDF2", tableau(Tableau::tr_bdf2()), true),
            ("midpoint", coupled(&half, &[1.0], &[0.5]), true),
            ("Gauss", coupled(&gauss, &[0.5, 0.5], &[0.5 - r, 0.5 + r]), true),
            // These end on the equation wherever they start.
            ("implicit Euler", tableau(Tableau::implicit_euler()), false),
            ("SDIRK2", tableau(Tableau::sdirk2()), false),
            ("BDF2", Box::new(Bdf2::new(&field).expect("fits")), false),
        ]
    };
    let step = |method: Box<dyn Integrator + '_>, t: f64, v: Vec<f64>| -> Result<Vec<f64>, StepError> {
        let mut run = Trajectory::new(method, State::new(t, v), 0.1, t + 1.0).expect("fits");
        while run.step()?.is_some() {}
        Ok(run.state().q.clone())
    };
    let cases = [
        (0.0, 0.0, false),
        (0.0, 1e-12, false),
        (0.0, 5e-8, true),
        (0.0, 1e-3, true),
        (0.5, 0.1, true),
        (1e6, 0.0, false),
        (1e6, 1.0, true),
    ];
    for (t, off, is_wrong) in cases {
        for (name, method, carries) in methods() {
            let case = format!("{name}, t = {t}, off by {off}");
            let found = step(method, t, vec![-0.5, t - 0.5 + off]);
            if is_wrong && carries {
                let Err(StepError::Input(InputError::System(SystemError::InconsistentStart {
                    row: 1,
                    value,
                    allowed,
                }))) = found
                else {
                    panic!("{case}: {found:?}")
                };
                assert!((value - off).abs() <= 1e-9 && allowed < off, "{case}: {value}, {allowed}");
            } else {
                let v = found.unwrap_or_else(|error| panic!("{case}: {error}"));
                let residual = (v[1] - v[0] - (t + 1.0)).abs();
                assert!(residual <= 2e-12 + 1e-15 * t, "{case}: {residual}");
            }
        }
    }
    // A run goes on from where it was, however its step changes, and starts anew elsewhere.
    let mut method = RungeKutta::new(&field, Tableau::trapezoidal()).expect("fits");
    let mut v = [1.0, 1.0];
    method.step(0.0, 0.1, &mut v, &mut []).expect("on the line");
    method.step(0.1, 0.05, &mut v, &mut []).expect("on the line");
    v[1] += 1e-3;
    assert!(method.step(0.15, 0.05, &mut v, &mut []).is_err());
    // A long step allows for more than a short one that goes on from it, which asks no more.
    let mut v = [101.0, 1.0 + 1e-6];
    method.step(-100.0, 100.0, &mut v, &mut []).expect("within what so long a step explains");
    let mut start_anew = v;
    method.step(0.0, 1e-3, &mut v, &mut []).expect("no start");
    let mut another = RungeKutta::new(&field, Tableau::trapezoidal()).expect("fits");
    assert!(another.step(0.0, 1e-3, &mut start_anew, &mut []).is_err(), "{start_anew:?}");
}

/// m v̇ = (3 v₁, v₀ − v₁), which says that its Jacobian is diagonal where that is asked.
struct Weighted {
    structure: Structure,
    mass: Mass,
}

impl FieldFn for Weighted {
    fn dim(&self) -> usize {
        2
    }
    fn structure(&self) -> Structure {
        self.structure.clone()
    }
    fn mass(&self) -> Mass {
        self.mass.clone()
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[1] * 3.0;
        dv[1] = v[0] - v[1];
    }
}

#[test]
fn rates_are_known_where_the_mass_is_not_zero() {
    let field = field_of(Weighted { structure: Structure::Dense, mass: Mass::Diagonal(vec![2.0, 0.0]) });
    let mut method = RungeKutta::new(field, Tableau::implicit_euler()).expect("usable");
    let mut rate = [0.0; 2];
    method.rate(&State::new(0.0, vec![0.5, 0.5]), &mut rate).expect("finite");
    assert!(rate[0] == 0.75 && rate[1].is_nan(), "{rate:?}");
}

#[test]
fn the_adaptive_method_refuses_a_mass_that_reaches_beyond_the_structure_of_the_field() {
    let mut mass = Jacobian::zeros(2);
    [(0, 0, 2.0), (1, 1, 2.0), (1, 0, 1.0)].iter().for_each(|&(i, j, m)| mass.add(i, j, m));
    let field = Weighted { structure: Structure::Banded { lower: 0, upper: 0 }, mass: Mass::Matrix(mass) };
    let tolerances = Tolerances::new(1e-6, 1e-6).expect("usable");
    let error = Radau::new(field_of(field), tolerances).map(|_| ()).expect_err("no room for M");
    assert_eq!(error, InputError::System(SystemError::OutsideStructure { row: 1, column: 0 }));
}

/// v̇₀ = −v₀, 0 = v₁ − v₀, 0 = v₂ − 2 v₀.
struct TwoAlgebraic;

impl FieldFn for TwoAlgebraic {
    fn dim(&self) -> usize {
        3
    }
    fn mass(&self) -> Mass {
        Mass::Diagonal(vec![1.0, 0.0, 0.0])
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = -v[0];
        dv[1] = v[1] - v[0];
        dv[2] = v[2] - v[0] * 2.0;
    }
}

#[test]
fn a_start_that_violates_the_second_of_two_algebraic_equations_is_refused_by_its_row() {
    let field = field_of(TwoAlgebraic);
    let tolerances = Tolerances::new(1e-6, 1e-6).expect("positive");
    let methods: [Box<dyn Integrator + '_>; 2] = [
        Box::new(Radau::new(&field, tolerances).expect("fits")),
        Box::new(RungeKutta::new(&field, Tableau::trapezoidal()).expect("fits")),
    ];
    for mut method in methods {
        let mut run = |start: [f64; 3]| {
            let run = Trajectory::new(&mut method, State::new(0.0, start.to_vec()), 0.1, 0.2);
            run.map(|run| run.observe(|_| {}))
        };
        assert!(run([1.0, 1.0, 2.0]).expect("valid").is_ok());
        let error = run([1.0, 1.0, 2.5]).expect("valid").expect_err("off");
        let StepError::Input(InputError::System(SystemError::InconsistentStart { row, value, .. })) = error else {
            panic!("{error}")
        };
        assert_eq!((row, value), (2, 0.5));
    }
}

/// Of implicit Euler on a parabola: the differential component is a cubic between steps, the algebraic one, without a rate, linear.
#[test]
fn a_component_without_a_rate_costs_the_others_no_order_between_steps() {
    let method = RungeKutta::new(field_of(OnParabola), Tableau::implicit_euler()).expect("fits");
    let mut run = Trajectory::new(method, State::new(0.0, vec![1.0, 1.0]), 0.5, 0.5).expect("fits");
    let end = run.step().expect("solvable").expect("a step").q.clone();
    let mut middle = [0.0; 2];
    run.interpolate(0.25, &mut middle).expect("within");
    // (q₀ + q₁)/2 + h (q̇₀ − q̇₁)/8 with q̇ = −q.
    let expected = [0.5 * (1.0 + end[0]) + 0.5 * (end[0] - 1.0) / 8.0, 0.5 * (1.0 + end[1])];
    middle.iter().zip(&expected).for_each(|(a, b)| approx::assert_abs_diff_eq!(*a, *b, epsilon = 1e-15));
}

/// v̇₁ + v̇₂ = −v₁, 0 = v₂ − 1: a row of M is zero, and no column is.
#[test]
fn an_algebraic_equation_is_a_row_of_the_mass_matrix() {
    struct Row;
    impl VectorField for Row {
        fn dim(&self) -> usize {
            2
        }
        fn mass(&self) -> Mass {
            let mut m = Jacobian::zeros(2);
            (0..2).for_each(|j| m.add(0, j, 1.0));
            Mass::Matrix(m)
        }
        fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
            (dv[0], dv[1]) = (-v[0], v[1] - 1.0);
        }
        fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
            out.add(0, 0, -scale);
            out.add(1, 1, scale);
        }
        fn add_curvature(&self, _t: f64, _v: &[f64], _w: &[f64], _scale: f64, _out: &mut Jacobian) {}
    }
    let step = |start: f64| {
        let method = Radau::new(Row, Tolerances::new(1e-6, 1e-6).expect("positive")).expect("valid");
        let mut run = Trajectory::new(method, State::new(0.0, vec![1.0, start]), 1.0, 1.0).expect("valid");
        run.step().map(|_| ())
    };
    assert!(step(1.0).is_ok());
    let refused = step(3.0);
    let is_named =
        matches!(&refused, Err(StepError::Input(InputError::System(SystemError::InconsistentStart { row: 1, .. }))));
    assert!(is_named, "{refused:?}");
}
