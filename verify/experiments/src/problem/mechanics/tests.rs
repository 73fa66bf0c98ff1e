use super::super::{ALL, Problem, build};
use crate::kinds::System;
use crate::measure::norm::max_norm;
use lsvi::Jacobian;
use proptest::prelude::*;

/// The mechanical problems.
fn mechanical() -> impl Iterator<Item = (&'static str, Box<dyn Problem>)> {
    let all = ALL.iter().map(|spec| (spec.name, build(spec.name, &[]).expect("defaults are valid")));
    all.filter(|(_, problem)| problem.mechanics().is_some())
}

/// A problem whose summary states a Lagrangian has it.
#[test]
fn all_mechanical_problems_say_so() {
    for spec in ALL.iter().filter(|spec| spec.summary.starts_with("L = ")) {
        assert!(mechanical().any(|(name, _)| name == spec.name), "{}", spec.name);
    }
    for (name, problem) in mechanical() {
        assert_eq!(problem.components().len(), problem.initial().len(), "{name}");
        let forced = problem.mechanics().is_some_and(|mechanics| mechanics.system == System::Forced);
        assert_eq!(problem.invariants().is_empty(), forced, "{name}");
    }
}

/// Legendre: p = ∂L/∂v at v = q̇. Lagrange, forces included: E(q, v, a) + Σ λ ∇f = 0 at a = dq̇/dt along the flow, with f̈ = 0.
#[test]
fn canonical_equations_are_those_of_the_lagrangian() {
    let most = mechanical().map(|(_, problem)| problem.ode().dim()).max().unwrap_or(0);
    proptest!(ProptestConfig::with_cases(64), |(seed in prop::collection::vec(-2.0..2.0, most))| {
        for (name, problem) in mechanical() {
            let (system, ode) = (problem.mechanics().expect("mechanical"), problem.ode());
            let n = system.lagrangian.dim();
            prop_assert_eq!(2 * n, ode.dim());
            let state = &seed[..2 * n];
            let (q, p) = state.split_at(n);
            let mut rate = vec![0.0; 2 * n];
            ode.rhs(0.0, state, &mut rate);
            let mut jacobian = Jacobian::zeros(2 * n);
            ode.jacobian(0.0, state, &mut |i, j, x| jacobian.add(i, j, x));
            let row = |i: usize| (0..2 * n).map(|j| jacobian.get(i, j) * rate[j]).collect::<Vec<_>>();
            let a: Vec<f64> = (0..n).map(|i| row(i).iter().sum()).collect();
            let v = &rate[..n];
            let (mut dl_dq, mut dl_dv) = (vec![0.0; n], vec![0.0; n]);
            system.lagrangian.gradient(0.0, q, v, &mut dl_dq, &mut dl_dv);
            let mut balance = vec![0.0; n];
            system.lagrangian.residual(0.0, q, v, &a, &mut balance);
            // Some fifty operations on numbers no larger than the terms of dq̇/dt, ∂L/∂q and the momenta.
            let terms = (0..n).flat_map(row).chain(dl_dq.iter().copied()).chain(p.iter().copied());
            let scale = 64.0 * f64::EPSILON * (1.0 + terms.map(f64::abs).sum::<f64>());
            if let Some(constraint) = &system.constraint {
                prop_assert_eq!(constraint.count(), 1);
                let mut gradient = nalgebra::DMatrix::zeros(1, n);
                constraint.jacobian(q, &mut gradient);
                let dot = |x: &[f64]| gradient.iter().zip(x).map(|(g, x)| g * x).sum::<f64>();
                let mut curvature = Jacobian::zeros(n);
                constraint.add_curvature(q, &[1.0], 1.0, &mut curvature);
                let bend: f64 = (0..n * n).map(|k| v[k / n] * v[k % n] * curvature.get(k / n, k % n)).sum();
                let scale = scale * gradient.amax();
                prop_assert!((bend + dot(&a)).abs() <= scale, "{name}: f̈ = {:e}", bend + dot(&a));
                let multiplier = dot(&balance) / gradient.norm_squared();
                balance.iter_mut().zip(gradient.iter()).for_each(|(b, g)| *b -= multiplier * g);
            }
            for i in 0..n {
                prop_assert!((p[i] - dl_dv[i]).abs() <= scale, "{name}: p = {}, L_v = {}", p[i], dl_dv[i]);
                prop_assert!(balance[i].abs() <= scale, "{name}: E[{i}] = {:e} > {scale:e}", balance[i]);
            }
        }
    });
}

/// Invariants and constraints, position and velocity, along the solution of an independent reference.
#[test]
fn motions_keep_their_invariants_and_constraints() {
    let reference = crate::reference::by_name("diffsol-esdirk34").expect("registered");
    for (name, problem) in mechanical() {
        let system = problem.mechanics().expect("mechanical");
        let (start, n) = (problem.initial(), system.lagrangian.dim());
        let sampled = reference.solve(problem.ode(), 0.0, &start, &[0.0, 1.0, 3.0]).expect("smooth");
        for (state, bound) in sampled.states.iter().zip(&sampled.bound) {
            for invariant in problem.invariants() {
                // An error of the state moves an invariant by its gradient, known here to three digits.
                let sensitivity: f64 = (0..2 * n)
                    .map(|i| {
                        let mut near = state.clone();
                        near[i] += 1e-6;
                        (invariant.value(&near) - invariant.value(state)).abs() / 1e-6
                    })
                    .sum();
                let drift = (invariant.value(state) - invariant.value(&start)).abs();
                let allowed = 1.01 * bound * sensitivity + 16.0 * f64::EPSILON;
                assert!(drift <= allowed, "{name}: {} moved by {drift:e} > {allowed:e}", invariant.name);
            }
            let Some(constraint) = &system.constraint else { continue };
            let (mut f, mut gradient, mut rate) = ([0.0], nalgebra::DMatrix::zeros(1, n), vec![0.0; 2 * n]);
            let q = &state[..n];
            constraint.value(q, &mut f);
            constraint.jacobian(q, &mut gradient);
            problem.ode().rhs(0.0, state, &mut rate);
            let hidden: f64 = gradient.iter().zip(&rate).map(|(g, v)| g * v).sum();
            // |∇f| = 2 on the unit sphere; the hidden constraint depends on q and v, both of order 1.
            let allowed = 2.0 * (n as f64) * bound + 16.0 * f64::EPSILON;
            assert!(f[0].abs() <= allowed, "{name}: f = {:e} > {allowed:e}", f[0]);
            assert!(hidden.abs() <= 2.0 * allowed, "{name}: ḟ = {hidden:e} > {:e}", 2.0 * allowed);
        }
    }
}

/// Values of `data/mechanics.csv`, from 40-digit arithmetic.
#[test]
fn exact_motions_are_reproduced() {
    let mut rows = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_reader(include_str!("../../../../data/mechanics.csv").as_bytes());
    let mut count = 0;
    for row in rows.records() {
        let row = row.expect("well-formed");
        let parameter = |name: &str, column: usize| (name.to_owned(), row[column].to_owned());
        let set = match &row[0] {
            "pendulum" => vec![parameter("q0", 1), parameter("p0", 2)],
            _ => vec![parameter("eccentricity", 1)],
        };
        let problem = build(&row[0], &set).expect("valid");
        let t: f64 = row[3].parse().expect("a time");
        let state = problem.exact(t).expect("known");
        let mut rate = vec![0.0; state.len()];
        problem.ode().rhs(t, &state, &mut rate);
        let size = max_norm;
        // Four roundings of the state, and four of the anomaly, which is of the size of the time.
        let allowed = 4.0 * f64::EPSILON * (size(&state) + (1.0 + t) * size(&rate));
        for (x, printed) in state.iter().zip(row[4].split(' ')) {
            let error = (x - printed.parse::<f64>().expect("a number")).abs();
            assert!(error <= allowed, "{row:?}: {error:e} > {allowed:e}");
        }
        count += 1;
    }
    assert_eq!(count, 56);
}
