//! The references against exact solutions, against each other, and on requests that cannot be met.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector, DVectorView, DVectorViewMut};
use proptest::prelude::*;
use verify::measure::norm::distance;
use verify::reference::{Ode, Reference, ReferenceError, Sampled, all, by_name};

/// A system from two closures.
struct System<F, J> {
    dim: usize,
    rhs: F,
    jacobian: J,
    band: Option<(usize, usize)>,
}

impl<F, J> Ode for System<F, J>
where
    F: Fn(f64, &[f64], &mut [f64]) + Sync,
    J: Fn(f64, &[f64], &mut dyn FnMut(usize, usize, f64)) + Sync,
{
    fn dim(&self) -> usize {
        self.dim
    }

    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        (self.rhs)(t, v, dv);
    }

    fn jacobian(&self, t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        (self.jacobian)(t, v, add);
    }

    fn bandwidths(&self) -> Option<(usize, usize)> {
        self.band
    }
}

fn system<F, J>(dim: usize, rhs: F, jacobian: J) -> System<F, J>
where
    F: Fn(f64, &[f64], &mut [f64]) + Sync,
    J: Fn(f64, &[f64], &mut dyn FnMut(usize, usize, f64)) + Sync,
{
    System { dim, rhs, jacobian, band: None }
}

/// v' = −v.
fn decay() -> impl Ode {
    system(1, |_, v, dv| dv[0] = -v[0], |_, _, add| add(0, 0, -1.0))
}

/// v' = −λ(v − cos t) − sin t with λ = 1000, solved by cos t.
fn prothero_robinson() -> impl Ode {
    const LAMBDA: f64 = 1000.0;
    system(
        1,
        |t, v, dv| dv[0] = -LAMBDA * (v[0] - t.cos()) - t.sin(),
        |_, _, add| {
            // In two parts: contributions to one entry add up.
            add(0, 0, -0.5 * LAMBDA);
            add(0, 0, -0.5 * LAMBDA);
        },
    )
}

/// θ' = ω, ω' = −sin θ.
fn pendulum() -> impl Ode {
    system(
        2,
        |_, v, dv| {
            dv[0] = v[1];
            dv[1] = -v[0].sin();
        },
        |_, v, add| {
            add(0, 1, 1.0);
            add(1, 0, -v[0].cos());
        },
    )
}

/// x' = y, y' = μ(1 − x²)y − x.
fn van_der_pol(mu: f64) -> impl Ode {
    system(
        2,
        move |_, v, dv| {
            dv[0] = v[1];
            dv[1] = mu * (1.0 - v[0] * v[0]) * v[1] - v[0];
        },
        move |_, v, add| {
            add(0, 1, 1.0);
            add(1, 0, -2.0 * mu * v[0] * v[1] - 1.0);
            add(1, 1, mu * (1.0 - v[0] * v[0]));
        },
    )
}

/// Three stiff lags in a row, v_i' = λ(v_{i−1} − v_i) with v_{−1} = cos t: bandwidths 1 below and 0 above.
fn cascade(band: Option<(usize, usize)>) -> impl Ode {
    const LAMBDA: f64 = 1000.0;
    System {
        band,
        ..system(
            3,
            |t, v, dv| {
                dv[0] = LAMBDA * (t.cos() - v[0]);
                dv[1] = LAMBDA * (v[0] - v[1]);
                dv[2] = LAMBDA * (v[1] - v[2]);
            },
            |_, _, add| {
                for i in 0..3 {
                    add(i, i, -LAMBDA);
                    if i > 0 {
                        add(i, i - 1, LAMBDA);
                    }
                }
            },
        )
    }
}

/// Heat on (0, 1) with cold ends, carried along at speed 10, by second differences on n inner points:
/// v_i' = (v_{i−1} − 2v_i + v_{i+1})/Δ² − 10(v_i − v_{i−1})/Δ. The bandwidths are 1 and 1.
fn heat(n: usize, band: Option<(usize, usize)>) -> impl Ode {
    let spacing = 1.0 / (n + 1) as f64;
    let diffusion = spacing.powi(-2);
    let below = diffusion + 10.0 / spacing;
    let diagonal = -2.0 * diffusion - 10.0 / spacing;
    System {
        dim: n,
        rhs: move |_, v: &[f64], dv: &mut [f64]| {
            for i in 0..n {
                let west = if i > 0 { v[i - 1] } else { 0.0 };
                let east = if i + 1 < n { v[i + 1] } else { 0.0 };
                dv[i] = below * west + diagonal * v[i] + diffusion * east;
            }
        },
        jacobian: move |_, _: &[f64], add: &mut dyn FnMut(usize, usize, f64)| {
            for i in 0..n {
                add(i, i, diagonal);
                if i > 0 {
                    add(i, i - 1, below);
                }
                if i + 1 < n {
                    add(i, i + 1, diffusion);
                }
            }
        },
        band,
    }
}

fn reference(name: &str) -> &'static dyn Reference {
    by_name(name).unwrap_or_else(|| panic!("no reference `{name}`"))
}

/// The references that are compiled in.
fn available() -> impl Iterator<Item = &'static dyn Reference> {
    all().into_iter().filter(|r| r.library().is_some())
}

fn solve(r: &dyn Reference, ode: &dyn Ode, v0: &[f64], times: &[f64]) -> Sampled {
    r.solve(ode, 0.0, v0, times).unwrap_or_else(|e| panic!("{}: {e}", r.name()))
}

/// `n` times, evenly spaced up to `end`.
fn times(n: usize, end: f64) -> Vec<f64> {
    (1..=n).map(|k| end * k as f64 / n as f64).collect()
}

/// Fails unless the error is within the bound at every sample and the bound is of use, less than `useful`.
fn assert_bounded(r: &dyn Reference, s: &Sampled, exact: impl Fn(f64) -> Vec<f64>, useful: f64) {
    for ((t, v), bound) in s.times.iter().zip(&s.states).zip(&s.bound) {
        let error = distance(v, &exact(*t));
        assert!(error <= *bound, "{} at t = {t}: error {error:e}, bound {bound:e}", r.name());
        assert!(*bound < useful, "{} at t = {t}: a bound of {bound:e} is of no use", r.name());
    }
}

#[test]
fn linear_decay_is_within_every_bound() {
    // Sparse and dense samples: the bound must not depend on how the solve is sampled.
    for n in [1, 10, 500] {
        for r in available() {
            let s = solve(r, &decay(), &[1.0], &times(n, 10.0));
            assert_bounded(r, &s, |t| vec![(-t).exp()], 1e-7);
            assert!(s.work.steps > 0 && s.work.rhs > s.work.steps, "{} reports its work: {:?}", r.name(), s.work);
        }
    }
}

/// Nothing is said of the unit of time: rates of 10¹⁸ of a fast process, and of 10⁻¹⁸ of a slow one.
#[test]
fn time_may_be_in_any_unit() {
    for rate in [1e18, 1e-18] {
        let decay = system(1, |_, v, dv| dv[0] = -rate * v[0], |_, _, add| add(0, 0, -rate));
        for r in available() {
            let s = solve(r, &decay, &[1.0], &times(10, 10.0 / rate));
            assert_bounded(r, &s, |t| vec![(-rate * t).exp()], 1e-7);
        }
    }
}

#[test]
fn stiff_prothero_robinson_is_within_the_bounds_of_stiff_solvers() {
    for r in available().filter(|r| r.stiff_ok()) {
        let s = solve(r, &prothero_robinson(), &[1.0], &times(10, 10.0));
        assert_bounded(r, &s, |t| vec![t.cos()], 1e-8);
    }
}

/// Where stability or a slow Newton iteration limits it, the step is h ≲ 3/λ, and there are more than 3000 on t ≤ 10; a
/// variable-order implicit method with the right Jacobian follows the slow solution with far fewer.
#[test]
fn bdf_steps_are_not_limited_by_stiffness() {
    let problems: [(&str, Box<dyn Ode>); 2] =
        [("Prothero–Robinson", Box::new(prothero_robinson())), ("cascade", Box::new(cascade(None)))];
    for (problem, ode) in &problems {
        for r in available().filter(|r| r.name().ends_with("-bdf")) {
            let s = solve(r, &**ode, &vec![1.0; ode.dim()], &[10.0]);
            assert!(s.work.steps < 1500, "{} on {problem} took {} steps", r.name(), s.work.steps);
            assert!(s.work.jacobians > 0 && s.work.factorizations >= s.work.jacobians, "{}: {:?}", r.name(), s.work);
        }
    }
}

#[test]
fn all_agree_on_nonlinear_problems_within_the_sum_of_their_bounds() {
    let problems: [(&str, Box<dyn Ode>, [f64; 2]); 2] =
        [("pendulum", Box::new(pendulum()), [1.0, 0.0]), ("van der Pol", Box::new(van_der_pol(1.0)), [2.0, 0.0])];
    for (problem, ode, v0) in &problems {
        let answers: Vec<_> = available().map(|r| (r.name(), solve(r, &**ode, v0, &times(20, 10.0)))).collect();
        for (i, (a, x)) in answers.iter().enumerate() {
            for (b, y) in &answers[..i] {
                for k in 0..x.times.len() {
                    let (apart, allowed) = (distance(&x.states[k], &y.states[k]), x.bound[k] + y.bound[k]);
                    assert!(
                        apart <= allowed,
                        "{a} and {b} on {problem} at t = {}: {apart:e} apart, {allowed:e} allowed",
                        x.times[k]
                    );
                    assert!(allowed < 1e-5, "{a} and {b} on {problem}: {allowed:e} is of no use");
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// v' = A v with A + Aᵀ negative definite, against exp(tA) v₀ and so against each other: rates from 0.1 to 1000.
    #[test]
    fn random_stable_systems_are_solved_within_every_bound(
        dim in 2_usize..6,
        entries in prop::collection::vec(-1.0..1.0_f64, 36),
        log_rate in -1.0..3.0_f64,
    ) {
        let b = DMatrix::from_fn(dim, dim, |i, j| entries[6 * i + j]);
        // Skew, and symmetric with eigenvalues from −rate to −0.1.
        let a = &b - b.transpose() - (&b * b.transpose()) * (10_f64.powf(log_rate) / b.norm_squared())
            - DMatrix::identity(dim, dim) * 0.1;
        let ode = system(
            dim,
            |_, v, dv| DVectorViewMut::from_slice(dv, dim).gemv(1.0, &a, &DVectorView::from_slice(v, dim), 0.0),
            |_, _, add| (0..dim * dim).for_each(|k| add(k / dim, k % dim, a[(k / dim, k % dim)])),
        );
        let start = DVector::from_element(dim, 1.0);
        for r in available().filter(|r| r.stiff_ok() || log_rate < 1.0) {
            let s = solve(r, &ode, start.as_slice(), &times(4, 2.0));
            assert_bounded(r, &s, |t| ((&a * t).exp() * &start).as_slice().to_vec(), 1e-5);
        }
    }
}

/// Two samples may be thousands of steps apart.
#[test]
fn samples_may_be_far_apart() {
    for r in available().filter(|r| r.name().starts_with("cvode")) {
        let s = solve(r, &van_der_pol(1.0), &[2.0, 0.0], &[50.0]);
        assert!(s.work.steps > 3000, "{}: {} steps", r.name(), s.work.steps);
    }
}

/// The energy of the pendulum is conserved; no reference knows it.
#[test]
fn pendulum_keeps_its_energy() {
    let energy = |v: &[f64]| 0.5 * v[1] * v[1] - v[0].cos();
    for r in available() {
        let s = solve(r, &pendulum(), &[1.0, 0.0], &times(20, 10.0));
        for (v, bound) in s.states.iter().zip(&s.bound) {
            // |∂E/∂θ| + |∂E/∂ω| ≤ 1 + 1 for |ω| ≤ 1.
            assert!((energy(v) - energy(&[1.0, 0.0])).abs() <= 2.0 * bound, "{}", r.name());
        }
    }
}

#[cfg(feature = "cvode")]
#[test]
fn banded_and_dense_matrices_give_the_same_solve() {
    let n = 20;
    let sine: Vec<f64> = (1..=n).map(|i| (PI * i as f64 / (n + 1) as f64).sin()).collect();
    let same = |name: &str, dense: &dyn Ode, banded: &dyn Ode, v0: &[f64], times: &[f64]| {
        let (a, b) = (solve(reference(name), dense, v0, times), solve(reference(name), banded, v0, times));
        let band = banded.bandwidths();
        for k in 0..times.len() {
            let apart = distance(&a.states[k], &b.states[k]);
            assert!(apart <= a.bound[k] + b.bound[k], "{name} {band:?}: {apart:e} apart");
        }
        // The same linear systems up to roundoff, so the same path up to a few retries.
        let (a, b) = (a.work.steps as f64, b.work.steps as f64);
        assert!((a - b).abs() <= 0.05 * a, "{name} {band:?}: {b} steps, {a} with a dense matrix");
    };
    for name in ["cvode-bdf", "cvode-adams"] {
        // As narrow as can be, wider than needed on either side, and wider than the matrix.
        for band in [(1, 1), (2, 1), (1, 3), (n, 1)] {
            same(name, &heat(n, None), &heat(n, Some(band)), &sine, &times(5, 0.1));
        }
        for band in [(1, 0), (2, 0), (1, 1)] {
            same(name, &cascade(None), &cascade(Some(band)), &[1.0; 3], &times(5, 10.0));
        }
    }
}

/// Another system, known by its products.
struct MatrixFree<'a> {
    of: &'a dyn Ode,
    /// What its products are multiplied by.
    factor: f64,
}

impl Ode for MatrixFree<'_> {
    fn dim(&self) -> usize {
        self.of.dim()
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.of.rhs(t, v, dv);
    }
    fn jacobian(&self, _: f64, _: &[f64], _: &mut dyn FnMut(usize, usize, f64)) {
        panic!("the entries are dear");
    }
    fn product(&self, t: f64, v: &[f64], x: &[f64], out: &mut [f64]) {
        self.of.product(t, v, x, out);
        out.iter_mut().for_each(|x| *x *= self.factor);
    }
    fn is_matrix_free(&self) -> bool {
        true
    }
}

#[cfg(feature = "cvode")]
#[test]
fn products_with_the_jacobian_do_what_its_factors_do() {
    let (n, cvode) = (20, reference("cvode-bdf"));
    let sine: Vec<f64> = (1..=n).map(|i| (PI * i as f64 / (n + 1) as f64).sin()).collect();
    let cases: [(&dyn Ode, &[f64], Vec<f64>); 2] =
        [(&heat(n, None), &sine, times(5, 0.1)), (&van_der_pol(5.0), &[2.0, 0.0], times(5, 2.0))];
    for (of, v0, times) in cases {
        let by_factors = solve(cvode, of, v0, &times);
        let by_products = solve(cvode, &MatrixFree { of, factor: 1.0 }, v0, &times);
        for k in 0..times.len() {
            let apart = distance(&by_factors.states[k], &by_products.states[k]);
            assert!(apart <= by_factors.bound[k] + by_products.bound[k], "{apart:e} apart");
        }
        let (a, b) = (by_factors.work, by_products.work);
        assert!(2 * b.products > b.steps && b.jacobians == 0 && a.products == 0, "{a:?} {b:?}");
        assert!((a.steps as f64 - b.steps as f64).abs() <= 0.1 * a.steps as f64, "{a:?} {b:?}");
    }
}

/// v̇ᵢ = −λᵢ (vᵢ − sin t): long steps, in which no two components are alike.
struct Rates;

impl Rates {
    const ALL: [f64; 5] = [1.0, 10.0, 100.0, 1e3, 1e4];
}

impl Ode for Rates {
    fn dim(&self) -> usize {
        Self::ALL.len()
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        for ((dv, v), rate) in dv.iter_mut().zip(v).zip(Self::ALL) {
            *dv = -rate * (v - t.sin());
        }
    }
    fn jacobian(&self, _: f64, _: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        Self::ALL.iter().enumerate().for_each(|(i, rate)| add(i, i, -rate));
    }
}

/// GMRES solves a system with five eigenvalues in five directions, and with fewer it cannot where all differ: CVODE would have to
/// shorten its steps.
#[cfg(feature = "cvode")]
#[test]
fn products_with_the_jacobian_take_a_direction_for_each_rate() {
    let (cvode, times) = (reference("cvode-bdf"), times(5, 10.0));
    let factors = solve(cvode, &Rates, &[1.0; 5], &times).work;
    let products = solve(cvode, &MatrixFree { of: &Rates, factor: 1.0 }, &[1.0; 5], &times).work;
    assert!(
        (factors.steps as f64 - products.steps as f64).abs() <= 0.1 * factors.steps as f64,
        "{factors:?} {products:?}"
    );
    assert!(products.products > 2 * products.steps && products.products <= 5 * products.rhs, "{products:?}");
}

#[cfg(feature = "cvode")]
#[test]
fn a_product_that_is_not_finite_stops_cvode() {
    let (reason, _) = stopped(reference("cvode-bdf"), &MatrixFree { of: &decay(), factor: f64::NAN });
    assert!(reason.contains("of J x is NaN"), "{reason}");
}

#[test]
fn heat_equation_is_the_same_to_all_stiff_solvers() {
    let n = 8;
    let v0: Vec<f64> = (1..=n).map(|i| (PI * i as f64 / (n + 1) as f64).sin()).collect();
    let answers: Vec<_> = available()
        .filter(|r| r.stiff_ok())
        .map(|r| (r.name(), solve(r, &heat(n, Some((1, 1))), &v0, &times(4, 0.1))))
        .collect();
    let (first, x) = &answers[0];
    for (name, y) in &answers[1..] {
        for k in 0..4 {
            let apart = distance(&x.states[k], &y.states[k]);
            assert!(apart <= x.bound[k] + y.bound[k], "{first} and {name}: {apart:e} apart");
        }
    }
}

#[test]
fn samples_may_coincide_with_the_start_and_with_each_other() {
    for r in available() {
        let s = solve(r, &decay(), &[1.0], &[0.0, 0.0, 1.0, 1.0]);
        assert_eq!(s.states[0], [1.0], "{}", r.name());
        assert_eq!(s.states[2], s.states[3], "{}", r.name());
        assert_bounded(r, &s, |t| vec![(-t).exp()], 1e-7);
        assert!(solve(r, &decay(), &[1.0], &[]).states.is_empty());
        assert_eq!(solve(r, &decay(), &[1.0], &[0.0]).states, [[1.0]]);
    }
}

#[test]
fn no_evaluation_beyond_the_last_sample() {
    let guarded = system(
        1,
        |t, v, dv| {
            // A stop time is hit up to a few roundings of t.
            assert!(t <= 1.0 + 8.0 * f64::EPSILON, "f was evaluated at t = {t}");
            dv[0] = -v[0];
        },
        |_, _, add| add(0, 0, -1.0),
    );
    for r in available() {
        solve(r, &guarded, &[1.0], &times(3, 1.0));
    }
}

#[test]
fn malformed_requests_are_refused() {
    let refused = |v0: &[f64], t0: f64, times: &[f64], says: &str| {
        for r in available() {
            match r.solve(&decay(), t0, v0, times) {
                Err(ReferenceError::Input(reason)) => assert!(reason.contains(says), "{}: {reason}", r.name()),
                other => panic!("{}: {other:?}", r.name()),
            }
            let once = r.run(&decay(), t0, v0, times, 1e-6);
            assert!(matches!(once, Err(ReferenceError::Input(_))), "{}: {once:?}", r.name());
        }
    };
    refused(&[1.0, 2.0], 0.0, &[1.0], "2 components, the system 1");
    refused(&[], 0.0, &[1.0], "0 components");
    refused(&[f64::NAN], 0.0, &[1.0], "NaN");
    refused(&[1.0], f64::INFINITY, &[1.0], "inf");
    refused(&[1.0], 0.0, &[1.0, 0.5], "0.5 follows 1");
    refused(&[1.0], 0.0, &[-1.0], "-1 follows 0");
    refused(&[1.0], 0.0, &[f64::NAN], "NaN");
    for r in available() {
        let empty = system(0, |_, _, _| (), |_, _, _| ());
        assert!(matches!(r.solve(&empty, 0.0, &[], &[1.0]), Err(ReferenceError::Input(_))), "{}", r.name());
    }
}

/// The reason and the time at which `r` stopped.
fn stopped(r: &dyn Reference, ode: &dyn Ode) -> (String, f64) {
    match r.solve(ode, 0.0, &[1.0], &[1.0]) {
        Err(ReferenceError::Solver { solver, t, reason }) => {
            assert_eq!(solver, r.name());
            (reason, t)
        }
        other => panic!("{}: {other:?}", r.name()),
    }
}

#[test]
fn a_right_hand_side_that_is_not_finite_stops_every_solver() {
    for value in [f64::NAN, f64::INFINITY] {
        let late = system(1, move |t, v, dv| dv[0] = if t > 0.5 { value } else { -v[0] }, |_, _, add| add(0, 0, -1.0));
        let at_once = system(1, move |_, _, dv| dv[0] = value, |_, _, add| add(0, 0, -1.0));
        for r in available() {
            let (reason, t) = stopped(r, &late);
            assert!(reason.contains("component 0 of f is"), "{}: {reason}", r.name());
            assert!((0.0..=0.6).contains(&t), "{} at t = {t}: {reason}", r.name());
            let (reason, t) = stopped(r, &at_once);
            assert!(reason.contains("component 0 of f is"), "{}: {reason}", r.name());
            assert_eq!(t, 0.0, "{}", r.name());
        }
    }
}

#[test]
fn a_panic_in_the_system_becomes_an_error() {
    let rhs = system(
        1,
        |t, v, dv| {
            assert!(t < 0.5, "half way");
            dv[0] = -v[0];
        },
        |_, _, add| add(0, 0, -1.0),
    );
    let jacobian = system(1, |_, v, dv| dv[0] = -v[0], |_, _, _| panic!("no Jacobian"));
    for r in available() {
        let (reason, _) = stopped(r, &rhs);
        assert!(reason.contains("panicked") && reason.contains("half way"), "{}: {reason}", r.name());
        // An explicit method never asks.
        if r.name() != "diffsol-tsit45" {
            let (reason, _) = stopped(r, &jacobian);
            assert!(reason.contains("panicked") && reason.contains("no Jacobian"), "{}: {reason}", r.name());
        }
    }
}

#[test]
fn a_solution_that_blows_up_stops_every_solver() {
    // v' = v² from 1 is 1/(1 − t); the numerical solution blows up a little earlier or later.
    let blow_up = system(1, |_, v, dv| dv[0] = v[0] * v[0], |_, v, add| add(0, 0, 2.0 * v[0]));
    for r in available() {
        let stopped = r.solve(&blow_up, 0.0, &[1.0], &[2.0]);
        assert!(
            matches!(stopped, Err(ReferenceError::Solver { t, .. }) if t < 1.0 + 1e-6),
            "{}: {stopped:?}",
            r.name()
        );
    }
}

/// CVODE's own words for a failure are in the error, not on standard error.
#[cfg(feature = "cvode")]
#[test]
fn cvode_explains_itself() {
    let next = 1.0 + f64::EPSILON;
    match reference("cvode-bdf").solve(&decay(), 1.0, &[1.0], &[next]) {
        Err(ReferenceError::Solver { t: 1.0, reason, .. }) => {
            assert!(reason.contains("too close to t0") && reason.contains("CVode returned CV_TOO_CLOSE"), "{reason}")
        }
        other => panic!("{other:?}"),
    }
}

#[cfg(feature = "cvode")]
#[test]
fn entries_outside_the_jacobian_or_its_band_are_refused() {
    let outside = system(1, |_, v, dv| dv[0] = -v[0], |_, _, add| add(1, 0, 1.0));
    let off_band =
        System { band: Some((0, 0)), ..system(2, |_, v, dv| dv.copy_from_slice(v), |_, _, add| add(0, 1, 1.0)) };
    for name in ["cvode-bdf", "cvode-adams"] {
        let r = reference(name);
        let (reason, _) = stopped(r, &outside);
        assert!(reason.contains("(1, 0) lies outside"), "{name}: {reason}");
        let refused = r.solve(&off_band, 0.0, &[1.0, 1.0], &[1.0]).map(|s| s.states);
        assert!(refused.as_ref().is_err_and(|e| e.to_string().contains("(0, 1) lies outside")), "{name}: {refused:?}");
    }
}

#[cfg(feature = "cvode")]
#[test]
fn a_jacobian_that_is_not_finite_stops_cvode() {
    let ode = system(1, |_, v, dv| dv[0] = -v[0], |_, _, add| add(0, 0, f64::NAN));
    let (reason, _) = stopped(reference("cvode-bdf"), &ode);
    assert!(reason.contains("entry (0, 0) of the Jacobian is NaN"), "{reason}");
}

#[test]
fn the_registry_names_every_reference_once() {
    let names: Vec<_> = all().iter().map(|r| r.name()).collect();
    assert_eq!(
        names,
        ["cvode-bdf", "cvode-adams", "diffsol-bdf", "diffsol-tr-bdf2", "diffsol-esdirk34", "diffsol-tsit45"]
    );
    for name in names {
        assert_eq!(reference(name).name(), name);
        assert_eq!(reference(name).stiff_ok(), !["cvode-adams", "diffsol-tsit45"].contains(&name));
    }
    assert!(by_name("cvode").is_none());
}

/// Before anything is allocated.
#[test]
fn systems_too_large_for_a_dense_matrix_are_refused() {
    const DIM: usize = 1 << 20;
    let large = system(DIM, |_, v, dv| dv.copy_from_slice(v), |_, _, _| ());
    for r in available() {
        let answer = r.solve(&large, 0.0, &vec![0.0; DIM], &[1.0]);
        assert!(matches!(answer, Err(ReferenceError::Input(reason)) if reason.contains("1048576")), "{}", r.name());
    }
}

/// The library's version is a number, from the library that runs.
#[test]
fn the_libraries_state_their_versions() {
    for r in available() {
        let library = r.library().unwrap_or_default();
        let (name, version) = library.split_once(' ').unwrap_or_default();
        assert!(r.name().starts_with(if name == "SUNDIALS" { "cvode" } else { name }), "{library}");
        let numbers: Vec<_> = version.split('.').map(|n| n.parse::<u32>()).collect();
        assert!(numbers.len() == 3 && numbers.iter().all(Result::is_ok), "{library}");
    }
}

#[cfg(not(feature = "cvode"))]
#[test]
fn cvode_says_that_it_is_not_compiled_in() {
    for name in ["cvode-bdf", "cvode-adams"] {
        let r = reference(name);
        assert!(r.library().is_none());
        assert!(matches!(r.solve(&decay(), 0.0, &[1.0], &[1.0]), Err(ReferenceError::Unavailable(n)) if n == name));
    }
}
