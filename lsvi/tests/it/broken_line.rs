//! Broken lines: their explicit steps against the discrete Lagrangian that they come from.

use crate::mechanics::{differences, symplecticity_defect};
use crate::separable::{Chain, Separable, Swaying};
use crate::systems::HenonHeiles;
use crate::systems::{AnyLagrangian, lagrangian_of};
use lsvi::discrete::{
    BrokenLine, DiscreteLagrangian, DiscreteLegendre, Galerkin, Interval, MomentumWeights, Trapezoidal,
};
use lsvi::{InputError, Integrator, Jacobian, NodeError, OneStep, SystemError, position_momentum};

const EPS: f64 = f64::EPSILON;

/// Three pieces, one of them backward, and no symmetry.
const DURATIONS: [f64; 3] = [0.7, -0.4, 0.7];
const KICKS: [f64; 4] = [0.2, 0.5, 0.1, 0.2];

fn swaying() -> AnyLagrangian<'static> {
    lagrangian_of(Separable(Swaying))
}

/// Of two unknowns, whose number is compiled, and of six.
#[test]
fn explicit_steps_solve_the_equations_of_the_line() {
    let states: [[&[f64]; 2]; 2] =
        [[&[0.7, -0.4], &[0.2, 0.5]], [&[0.1, 0.2, -0.1, 0.0, 0.3, 0.2], &[0.3, -0.1, 0.0, 0.2, -0.2, 0.1]]];
    for (l, [q0, p0]) in [swaying(), lagrangian_of(Separable(Chain))].into_iter().zip(states) {
        let lines = [BrokenLine::new(&l, &DURATIONS, &KICKS), BrokenLine::blanes_moan(&l)];
        for line in lines.map(|line| line.expect("weights")) {
            let mut method = position_momentum(line);
            let (at, n) = (Interval { start: 0.3, h: 0.2 }, q0.len());
            let (mut q, mut p) = (q0.to_vec(), p0.to_vec());
            method.step(at.start, at.h, &mut q, &mut p).expect("explicit");
            let x = method.unknowns().to_vec();
            assert_eq!(x[x.len() - n..], q);
            let mut equations = vec![0.0; x.len()];
            method.discrete_mut().equations(at, q0, &x, MomentumWeights::START, &mut equations);
            // A knot is known to a rounding, and M d_i to 1/(a_i h) of it.
            let allowed = 64.0 * EPS / (0.1 * at.h);
            let expected = |i: usize| if i + n < x.len() { 0.0 } else { p0[i + n - x.len()] };
            assert!(equations.iter().enumerate().all(|(i, e)| (e - expected(i)).abs() <= allowed), "{equations:?}");
            let mut end = vec![0.0; n];
            method.discrete_mut().momentum(at, q0, &x, MomentumWeights::END, &mut end);
            assert!((0..n).all(|i| (end[i] - p[i]).abs() <= allowed), "{end:?}, not {p:?}");
        }
    }
}

/// The equations by differences of the action, and their derivatives by differences of theirs, away from a solution.
#[test]
fn equations_are_the_derivatives_of_the_action() {
    let l = swaying();
    let mut line = BrokenLine::new(&l, &DURATIONS, &KICKS).expect("weights");
    let (at, q0, x) = (Interval { start: 0.3, h: 0.4 }, [0.7, -0.4], [0.8, -0.3, 0.65, -0.5, 0.9, -0.2]);
    let in_x = differences(&mut |x| vec![line.action(at, &q0, x)], &x, 1e-5);
    let in_q0 = differences(&mut |q0| vec![line.action(at, q0, &x)], &q0, 1e-5);
    let w = MomentumWeights { alpha: 0.7, beta: -1.3 };
    let mut found = [0.0; 6];
    line.equations(at, &q0, &x, w, &mut found);
    for i in 0..2 {
        let ends = -w.alpha * in_q0[i] + w.beta * in_x[4 + i];
        // 1e-10 of third derivatives, and 1e5 roundings, of numbers up to 10.
        assert!((found[i] - in_x[i]).abs() < 1e-8 && (found[2 + i] - in_x[2 + i]).abs() < 1e-8, "{found:?}, {in_x}");
        assert!((found[4 + i] - ends).abs() < 1e-8, "{found:?}, {ends}");
    }
    let mut equations = |q0: &[f64], x: &[f64]| {
        line.equations(at, q0, x, w, &mut found);
        found.to_vec()
    };
    let in_x = differences(&mut |x| equations(&q0, x), &x, 1e-5);
    let in_q0 = differences(&mut |q0| equations(q0, &x), &q0, 1e-5);
    let (mut exact, mut at_start) = (Jacobian::zeros(6), Jacobian::zeros(6));
    line.add_derivative(at, &q0, &x, w, &mut exact);
    line.add_start_derivative(at, &q0, &x, w, &mut at_start);
    assert!((exact.to_dense() - in_x).amax() < 1e-7);
    assert!((at_start.to_dense().columns(0, 2) - in_q0).amax() < 1e-7);
}

#[test]
fn every_line_is_symplectic() {
    let (heiles, swaying) = (lagrangian_of(Separable(HenonHeiles)), swaying());
    let (q, p) = ([0.1, -0.2], [0.4, 0.3]);
    let defects = [
        symplecticity_defect(BrokenLine::new(&heiles, &DURATIONS, &KICKS).expect("weights"), 0.2, &q, &p),
        symplecticity_defect(BrokenLine::new(&swaying, &DURATIONS, &KICKS).expect("weights"), 0.2, &q, &p),
        symplecticity_defect(BrokenLine::blanes_moan(&heiles).expect("separable"), 0.2, &q, &p),
        symplecticity_defect(BrokenLine::blanes_moan(&swaying).expect("separable"), 0.2, &q, &p),
    ];
    // Roundings of M/(a_i h), a hundred times its entries, both ways.
    assert!(defects.iter().all(|defect| *defect < 1e4 * EPS), "{defects:?}");
}

/// The end at t = 1 of so many steps.
fn end(line: BrokenLine<AnyLagrangian>, steps: u32) -> [f64; 4] {
    let mut method = position_momentum(line);
    let h = f64::from(steps).recip();
    let (mut q, mut p) = ([0.7, -0.4], [0.2, 0.5]);
    (0..steps).for_each(|k| method.step(f64::from(k) * h, h, &mut q, &mut p).expect("explicit"));
    [q[0], q[1], p[0], p[1]]
}

/// That of fifty steps of a method of order 10.
fn accurate_end() -> [f64; 4] {
    let mut method = position_momentum(Galerkin::gauss(swaying(), 5).expect("s ≥ 1"));
    let (mut q, mut p) = ([0.7, -0.4], [0.2, 0.5]);
    (0..50).for_each(|k| method.step(f64::from(k) * 0.02, 0.02, &mut q, &mut p).expect("bounded"));
    [q[0], q[1], p[0], p[1]]
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum()
}

/// Where a coefficient is off, the error stops to decrease like h⁶ at that size.
#[test]
fn the_coefficients_of_blanes_and_moan_hold_to_the_digits_that_are_printed() {
    let exact = accurate_end();
    let error = |steps: u32| distance(&end(BrokenLine::blanes_moan(swaying()).expect("separable"), steps), &exact);
    let [coarse, fine] = [4, 32].map(error);
    // A rounding of each of the four numbers, in either solution.
    assert!(fine < 1.5 * coarse / 8.0_f64.powi(6) + 8.0 * EPS, "{fine:e} after {coarse:e}");
}

/// Order 6 with a mass that is not diagonal and a potential that depends on time; of three pieces without symmetry order 1.
#[test]
fn the_order_is_that_of_the_weights() {
    let exact = accurate_end();
    let order = |line: &dyn Fn() -> BrokenLine<AnyLagrangian<'static>>, steps: u32| {
        let [coarse, fine] = [steps, 2 * steps].map(|steps| distance(&end(line(), steps), &exact));
        (coarse / fine).log2()
    };
    let sixth = order(&|| BrokenLine::blanes_moan(swaying()).expect("separable"), 4);
    let first = order(&|| BrokenLine::new(swaying(), &DURATIONS, &KICKS).expect("weights"), 64);
    assert!((sixth - 6.0).abs() < 0.3, "{sixth}");
    assert!((first - 1.0).abs() < 0.1, "{first}");
}

#[test]
fn one_piece_with_two_halves_of_a_kick_is_the_trapezoidal_rule() {
    let l = lagrangian_of(Separable(HenonHeiles));
    let mut line = position_momentum(BrokenLine::new(&l, &[1.0], &[0.5, 0.5]).expect("weights"));
    let mut verlet = position_momentum(Trapezoidal::new(&l));
    let mut states = [([0.1, 0.2], [0.3, -0.1]); 2];
    for k in 0..100 {
        let [(q, p), (r, s)] = &mut states;
        line.step(f64::from(k) * 0.1, 0.1, q, p).expect("explicit");
        verlet.step(f64::from(k) * 0.1, 0.1, r, s).expect("explicit");
    }
    assert_eq!(states[0], states[1]);
    assert_eq!(line.work(), verlet.work());
}

#[test]
fn a_step_counts_a_force_for_each_piece() {
    let mut method = position_momentum(BrokenLine::blanes_moan(swaying()).expect("separable"));
    let (mut q, mut p) = ([0.7, -0.4], [0.2, 0.5]);
    (0..10).for_each(|k| method.step(f64::from(k) * 0.1, 0.1, &mut q, &mut p).expect("explicit"));
    let work = method.work();
    assert_eq!((work.steps, work.residuals, work.factorizations), (10, 110, 0));
}

/// The force that a step leaves to the next one is none of another state, another time, or a step that failed.
#[test]
fn a_step_elsewhere_or_after_a_failure_is_that_of_a_new_method() {
    let l = swaying();
    let new = || position_momentum(BrokenLine::blanes_moan(&l).expect("separable"));
    for (fails, start) in [(true, 0.1), (false, 5.0)] {
        let mut method = new();
        let (mut q, mut p) = ([0.7, -0.4], [0.2, 0.5]);
        method.step(0.0, 0.1, &mut q, &mut p).expect("bounded");
        if fails {
            assert!(method.step(0.1, 1e200, &mut q, &mut p).is_err());
        }
        let (mut r, mut s) = (q, p);
        method.step(start, 0.1, &mut q, &mut p).expect("bounded");
        new().step(start, 0.1, &mut r, &mut s).expect("bounded");
        assert_eq!((q, p), (r, s), "from {start}");
    }
}

#[test]
fn weights_that_make_no_line_are_refused() {
    let l = swaying();
    let refused =
        |durations: &[f64], kicks: &[f64]| BrokenLine::new(&l, durations, kicks).map(|_| ()).expect_err("no line");
    assert_eq!(
        BrokenLine::blanes_moan(lagrangian_of(Swaying)).map(|_| ()).expect_err("it does not say so"),
        InputError::System(SystemError::NotSeparable)
    );
    assert!(matches!(refused(&[], &[1.0]), InputError::Nodes(NodeError::TooFew { found: 0, .. })));
    assert!(matches!(
        refused(&[0.5, 0.0, 0.5], &[0.25; 4]),
        InputError::Nodes(NodeError::CoincidentNodes { first: 1, second: 2, value: 0.5 })
    ));
    assert!(matches!(refused(&[0.5, 0.4], &[0.25, 0.5, 0.25]), InputError::Nodes(NodeError::WeightSum { .. })));
    assert!(matches!(refused(&[0.5, 0.5], &[0.25, 0.5, 0.5]), InputError::Nodes(NodeError::WeightSum { .. })));
    assert!(matches!(
        refused(&[1.0], &[1.0]),
        InputError::System(SystemError::Dimension { what: "kicks", expected: 2, found: 1 })
    ));
    assert!(matches!(
        refused(&[f64::NAN], &[0.5, 0.5]),
        InputError::System(SystemError::NonFinite { what: "durations", index: 0, .. })
    ));
    assert!(matches!(
        refused(&[1.0], &[0.5, f64::INFINITY]),
        InputError::System(SystemError::NonFinite { what: "kicks", index: 1, .. })
    ));
}
