//! Solvers against problems with a closed form.

use crate::problem::{Channel, Pendulum, Problem, System};
use crate::solver::{
    AdaptiveRadau, ByReference, Dense, DifferentialEquations, Fixed, MethodI, OdeSolvers, RadauByHand, Russell, Solver,
    Tridiagonal,
};

/// Errors of a solver at some of its settings; infinite where it fails.
fn errors<const N: usize, S: System<N>>(
    solver: &dyn Solver<Problem<N, S>>,
    problem: &Problem<N, S>,
    settings: &[f64],
) -> Vec<f64> {
    let error = |setting: &f64| solver.run(problem, *setting).map_or(f64::INFINITY, |state| problem.error(&state));
    settings.iter().map(error).collect()
}

/// What a solution is known to: below it errors are rounding.
const KNOWN: f64 = 1e-11;

/// Errors that fall by ten at least from each to the next, until they are rounding.
fn falls(name: &str, errors: &[f64]) {
    let fall = |pair: &[f64]| 10.0 * pair[1] <= pair[0] || pair[1] <= KNOWN;
    assert!(errors[0] < 1.0 && errors.windows(2).all(fall), "{name}: {errors:?}");
}

const TOLERANCES: [f64; 3] = [1e-4, 1e-7, 1e-10];

#[test]
fn the_error_of_each_solver_falls_with_the_tolerance() {
    let problem = Pendulum::problem().expect("it is known");
    let mut solvers: Vec<Box<dyn Solver<Problem<2, Pendulum>>>> = vec![
        Box::new(AdaptiveRadau),
        Box::new(OdeSolvers::Dopri5),
        Box::new(OdeSolvers::Dop853),
        Box::new(DifferentialEquations::Dop853),
        Box::new(DifferentialEquations::Radau5),
        Box::new(Russell::DoPri8),
        Box::new(Russell::Radau5),
        Box::new(RadauByHand::<Dense<2>>::NEW),
    ];
    solvers.extend(ByReference::all(false).map(|solver| Box::new(solver) as _));
    for solver in solvers {
        falls(&solver.name(), &errors(&*solver, &problem, &TOLERANCES));
    }
    for solver in Fixed::all() {
        falls(&Solver::<Problem<2, Pendulum>>::name(&solver), &errors(&solver, &problem, &[200.0, 800.0]));
    }
}

/// On a band, with few unknowns: a solver whose Jacobian were not that of f would not converge. The solution is at rest nearly, so that
/// an error may be small with a large tolerance, and two that are far apart are compared.
#[test]
fn the_error_of_implicit_solvers_falls_with_the_tolerance_on_a_band() {
    let problem = Channel::problem::<20>();
    let mut solvers: Vec<Box<dyn Solver<Problem<20, Channel>>>> = vec![
        Box::new(AdaptiveRadau),
        Box::new(DifferentialEquations::Radau5),
        Box::new(Russell::Radau5),
        Box::new(RadauByHand::<Tridiagonal<20>>::NEW),
        Box::new(RadauByHand::<Dense<20>>::NEW),
    ];
    solvers.extend(ByReference::all(true).map(|solver| Box::new(solver) as _));
    for solver in solvers {
        falls(&solver.name(), &errors(&*solver, &problem, &[1e-4, 1e-10]));
    }
    falls("Method I", &errors(&MethodI, &problem, &[10.0, 100.0, 1000.0]));
}

/// Too few steps for the explicit methods: no state, and not a wrong one.
#[test]
fn a_solver_that_does_not_finish_has_no_state() {
    let problem = Problem { end: 1e9, ..Pendulum::problem().expect("it is known") };
    for solver in [OdeSolvers::Dopri5, OdeSolvers::Dop853] {
        assert_eq!(solver.run(&problem, 1e-3), None, "{solver:?}");
    }
    assert_eq!(DifferentialEquations::Dop853.run(&problem, 1e-3), None);
    assert_eq!(Russell::DoPri8.run(&problem, 1e-3), None);
}

#[test]
fn what_is_not_a_number_is_an_infinite_error() {
    let problem = Pendulum::problem().expect("it is known");
    assert_eq!(problem.error(&[f64::NAN, 0.0]), f64::INFINITY);
    assert_eq!(problem.error(&problem.truth), 0.0);
}
