use super::*;
use crate::measure::norm::distance;
use crate::measure::order::{Expectation, Sample, Verdict, fit};

const STARTED: Flow = Flow { nu: 1.0, gamma: 2.0, wall: 0.0, omega: 0.0 };
const IMPULSIVE: Flow = Flow { nu: 1.0, gamma: 0.0, wall: 1.0, omega: 0.0 };
const PULSATING: Flow = Flow { nu: 0.5, gamma: 2.0, wall: 0.0, omega: 4.0 };
const OSCILLATING: Flow = Flow { nu: 0.5, gamma: 0.0, wall: 1.0, omega: 4.0 };
const FLOWS: [Flow; 4] = [STARTED, IMPULSIVE, PULSATING, OSCILLATING];

/// The error in space: that of the exact solution of the semi-discrete system.
fn error(scheme: Scheme, cells: usize, flow: Flow, t: f64) -> f64 {
    let channel = Channel::with(scheme, cells, flow);
    let state = channel.modes().expect("few cells").solution(t);
    distance(&channel.observe(t, &state), &channel.exact(t).expect("known"))
}

/// The order in the length of a cell is 2.
fn order(scheme: Scheme, flow: Flow, cells: [usize; 5], band: f64) {
    let t = 0.25;
    let samples: Vec<Sample> = cells
        .into_iter()
        .map(|n| Sample::new(2.0 / n as f64, error(scheme, n, flow, t), 1e-14 * (n * n) as f64))
        .collect();
    let fit = fit(&samples, &Expectation::new(2.0, band));
    assert_eq!(fit.verdict, Verdict::Pass, "{scheme:?}, {flow:?}: {}", fit.reason);
}

#[test]
fn differences_and_volumes_are_of_second_order() {
    for flow in FLOWS {
        order(Scheme::Differences, flow, [16, 23, 32, 45, 64], 0.05);
        // The centre of the outermost volume moves with the grid, and its share of the error fades.
        order(Scheme::Volumes, flow, [32, 45, 64, 90, 128], 0.1);
    }
}

/// Of fourth order, with the constant that theory gives: what is left beside the leading term is at most of the size of the next one.
#[test]
fn hermite_elements_have_the_error_of_fourth_order_that_theory_gives() {
    for flow in FLOWS {
        for cells in [16, 32, 64] {
            let remainder = hermite::of_flow(flow, cells, 0.25);
            assert!(remainder.ratio() <= 1.0, "{flow:?}, {cells} cells: {remainder:?}");
            // It says something: the next term is small beside the error.
            let error = error(Scheme::Hermite, cells, flow, 0.25);
            assert!(remainder.next <= 0.3 * error, "{flow:?}, {cells} cells: {remainder:?} of {error:e}");
        }
    }
}

#[test]
fn sixteen_modes_give_six_digits() {
    for flow in FLOWS {
        for t in [0.1, 0.3, 1.0, 2.0] {
            let error = error(Scheme::Legendre, 16, flow, t);
            assert!(error <= 1e-6, "{flow:?} at {t}: {error:e}");
        }
    }
}

/// The residual of linear elements in the strong form has no diffusion: the flow accelerates for ever.
#[test]
fn strong_linear_elements_do_not_diffuse() {
    let channel = Channel::with(Scheme::StrongLinear, 16, STARTED);
    let mut any = false;
    channel.space.stiffness.for_each(|_, _, k| any |= k != 0.0);
    assert!(!any, "K = 0");
    let centre = |t: f64| channel.observe(t, &channel.modes().expect("few cells").solution(t))[7];
    // ∫ φ (u_t − γ) = 0 away from the walls, each of which is felt n points away like (2 − √3)ⁿ.
    let walls = 2.0 * (2.0 - 3_f64.sqrt()).powi(8);
    assert!((centre(10.0) - 20.0 * (1.0 - walls)).abs() < 0.01 * walls, "{}", centre(10.0));
    assert!(error(Scheme::StrongLinear, 64, STARTED, 10.0) > 18.0, "no refinement helps");
}

/// The matrices are the integrals ∫ φ_i φ_j, ∫ φ_i′ φ_j′, ∫ φ_i, and those with the wall function ψ.
#[test]
fn the_matrices_are_integrals_of_the_basis() {
    for (scheme, cells) in [(Scheme::Hermite, 3), (Scheme::Legendre, 6), (Scheme::StrongLinear, 4)] {
        let space = Space::new(scheme, cells);
        let n = space.mass.dim();
        let rule = lsvi::quadrature::Quadrature::gauss(12).expect("twelve nodes");
        let at = |y: f64| {
            let shapes = space.shapes(y);
            let mut all = vec![0.0; n + 1];
            shapes.basis.into_iter().for_each(|(i, phi)| all[i] += phi);
            all[n] = shapes.wall;
            all
        };
        let (mut products, mut slopes, mut integral) = (vec![0.0; n * (n + 1)], vec![0.0; n * (n + 1)], vec![0.0; n]);
        for cell in 0..cells {
            for (x, weight) in rule.nodes().iter().zip(rule.weights()) {
                let y = 2.0 * (cell as f64 + x) / cells as f64 - 1.0;
                let (w, e) = (weight * 2.0 / cells as f64, 1e-4);
                let (value, above, below) = (at(y), at(y + e), at(y - e));
                for i in 0..n {
                    integral[i] += w * value[i];
                    for j in 0..=n {
                        let slope = |k: usize| (above[k] - below[k]) / (2.0 * e);
                        products[i * (n + 1) + j] += w * value[i] * value[j];
                        slopes[i * (n + 1) + j] += w * slope(i) * slope(j);
                    }
                }
            }
        }
        let dense = |band: &band::Band| {
            let mut dense = vec![0.0; n * n];
            band.for_each(|i, j, x| dense[i * n + j] = x);
            dense
        };
        let (mass, stiffness) = (dense(&space.mass), dense(&space.stiffness));
        for i in 0..n {
            let close = |a: f64, b: f64, tolerance: f64, what: &str| {
                assert!((a - b).abs() <= tolerance, "{scheme:?} {what}, row {i}: {a} and {b}");
            };
            close(integral[i], space.source[i], 1e-13, "b");
            close(products[i * (n + 1) + n], space.wall_mass[i], 1e-13, "m");
            for j in 0..n {
                close(products[i * (n + 1) + j], mass[i * n + j], 1e-13, "M");
                // Slopes by differences: e² of third derivatives, up to 6³ N⁵ for the Legendre basis of degree 7.
                if scheme != Scheme::StrongLinear {
                    close(slopes[i * (n + 1) + j], stiffness[i * n + j], 1e-4, "K");
                }
            }
            if scheme != Scheme::StrongLinear {
                close(slopes[i * (n + 1) + n], space.wall_stiffness[i], 1e-4, "k");
            }
        }
    }
}

/// Hand-written systems of every scheme agree with their solution by modes, for the references to agree with.
#[test]
fn modes_solve_the_systems_of_all_schemes() {
    for scheme in [Scheme::Differences, Scheme::Volumes, Scheme::Hermite, Scheme::Legendre, Scheme::StrongLinear] {
        for flow in FLOWS {
            let channel = Channel::with(scheme, 5, flow);
            let modes = channel.modes().expect("few cells");
            let start = distance(&modes.solution(0.0), &channel.initial());
            assert!(start <= 1e-14, "{scheme:?} {flow:?}: {start:e}");
            let (t, e) = (0.4, 1e-4);
            let at = |k: f64| modes.solution(t + k * e);
            let (ends, middle) = ([at(-2.0), at(-1.0), at(1.0), at(2.0)], at(0.0));
            let mut f = vec![0.0; middle.len()];
            Ode::rhs(&channel, t, &middle, &mut f);
            for i in 0..f.len() {
                let rate = (ends[0][i] - 8.0 * ends[1][i] + 8.0 * ends[2][i] - ends[3][i]) / (12.0 * e);
                // Roundoff ε/e, and that of f, whose rates go up to a few thousands.
                assert!((rate - f[i]).abs() < 1e-10, "{scheme:?} {flow:?}: {rate} and {}", f[i]);
            }
        }
    }
}

/// M v̇ = f of the methods is v̇ = f of the references, for every scheme.
#[test]
fn the_field_and_the_reference_state_one_system() {
    for scheme in [Scheme::Volumes, Scheme::Hermite, Scheme::Legendre, Scheme::StrongLinear] {
        let channel = Channel::with(scheme, 6, OSCILLATING);
        let (field, n) = (channel.field(), Ode::dim(&channel));
        let v: Vec<f64> = (0..n).map(|i| (1.0 + 3.0 * i as f64).sin()).collect();
        let (mut force, mut rate, mut product) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        field.rhs(0.7, &v, &mut force);
        Ode::rhs(&channel, 0.7, &v, &mut rate);
        let mass = match field.mass() {
            Mass::Matrix(m) => m.to_dense(),
            Mass::Diagonal(m) => nalgebra::DMatrix::from_diagonal(&m.into()),
            _ => unreachable!("every cell has a length"),
        };
        let mut jacobian = Jacobian::with_structure(n, &field.structure());
        field.add_jacobian(0.7, &v, 1.0, &mut jacobian);
        let mut by_hand = nalgebra::DMatrix::zeros(n, n);
        channel.jacobian(0.7, &v, &mut |i, j, x| by_hand[(i, j)] += x);
        let by_hand = &mass * by_hand;
        for i in 0..n {
            product[i] = (0..n).map(|j| mass[(i, j)] * rate[j]).sum::<f64>();
            // A few dozen roundings of terms up to ν K v, of order 10.
            assert!((product[i] - force[i]).abs() < 1e-13, "{scheme:?}: {} and {}", product[i], force[i]);
            for j in 0..n {
                assert!((by_hand[(i, j)] - jacobian.get(i, j)).abs() < 1e-13, "{scheme:?} ({i}, {j})");
            }
        }
    }
}

/// Method I with a mass matrix is of second order at a fixed time, on compatible and on impulsive data.
#[test]
fn method_i_is_of_second_order_with_every_scheme() {
    let method = crate::method::parse("method-i").expect("registered");
    for scheme in [Scheme::Volumes, Scheme::Hermite, Scheme::Legendre] {
        for flow in [IMPULSIVE, OSCILLATING] {
            let channel = Channel::with(scheme, 6, flow);
            let fit = crate::order::measure(&channel, &*method, crate::order::Truth::Exact).expect("exact");
            assert_eq!(fit.verdict, Verdict::Pass, "{scheme:?}, {flow:?}: {}", fit.reason);
        }
    }
}

/// Both statements share the matrices; here they are the three-point formula, written without them.
#[test]
fn differences_are_the_three_point_formula() {
    let (cells, t) = (7, 0.3);
    for flow in FLOWS {
        let channel = Channel::with(Scheme::Differences, cells, flow);
        let v: Vec<f64> = (1..cells).map(|i| (2.0 * i as f64).sin()).collect();
        let mut rate = vec![0.0; v.len()];
        Ode::rhs(&channel, t, &v, &mut rate);
        let phase = (flow.omega * t).cos();
        let u: Vec<f64> = [0.0].into_iter().chain(v.iter().copied()).chain([flow.wall * phase]).collect();
        let square = (2.0 / cells as f64).powi(2);
        for i in 1..cells {
            let expected = flow.gamma * phase + flow.nu * (u[i - 1] - 2.0 * u[i] + u[i + 1]) / square;
            // A few roundings of terms up to 4 ν/Δy² = 50.
            assert!((rate[i - 1] - expected).abs() <= 1e3 * f64::EPSILON, "{flow:?}: {} and {expected}", rate[i - 1]);
        }
    }
}
