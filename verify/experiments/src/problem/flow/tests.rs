use lsvi::{Jacobian, Mass, SolveError, StepError, VectorField, check_derivatives};
use nalgebra::DVector;

use crate::measure::norm::max_norm;
use crate::method;
use crate::names::NameError;
use crate::problem::{Stiffness, build_setting};
use crate::run::{RunError, run};

use super::cavity::manufactured;
use super::channel::pressure;
use super::confined::{Confined, Given};
use super::kovasznay::kovasznay;
use super::periodic::{Metric, Periodic};
use super::staggered::{Closed, Rectangle};

/// A lid in motion, and a boundary through which the fluid flows where `through` is not zero.
#[derive(Debug)]
struct Boundary {
    lid: f64,
    through: f64,
}

impl Given for Boundary {
    fn stream(&self, [x, y]: [f64; 2], t: f64) -> f64 {
        self.through * ((1.3 * x + t).sin() * y + x * x * y * y)
    }
    fn stream_rate(&self, [x, y]: [f64; 2], t: f64) -> f64 {
        self.through * (1.3 * x + t).cos() * y
    }
    fn velocity(&self, [x, y]: [f64; 2], t: f64) -> [f64; 2] {
        let lid = if y == 1.0 { self.lid } else { 0.0 };
        [lid + self.through * ((1.3 * x + t).sin() + 2.0 * x * x * y), self.through * (x - y)]
    }
}

fn flow(closed: Closed, lid: f64, through: f64) -> Confined {
    let rectangle = Rectangle { origin: [0.0, 0.0], size: [1.5, 1.0], cells: [7, 5], closed };
    Confined::new(rectangle, 0.03, Box::new(Boundary { lid, through }))
}

fn all() -> [Confined; 3] {
    [flow(Closed::Sides, 1.0, 0.0), flow(Closed::Sides, 1.0, 1.0), flow(Closed::Walls, 1.0, 0.0)]
}

/// Numbers in (−1, 1) without pattern.
fn noise(n: usize, seed: u64) -> Vec<f64> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    (0..n).map(|_| next()).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Products with J, its entries, products with Jᵀ, and the curvature, of every discretisation.
#[test]
fn stated_derivatives_are_those_of_the_right_hand_side() {
    for flow in all() {
        let checked = check_derivatives(&flow.field(), 0.3, &noise(flow.space.dim, 1));
        assert!(checked.is_ok(), "{checked:?}");
    }
    for flow in periodic() {
        let checked = check_derivatives(&flow.field(), 0.3, &noise(flow.modes.dim(), 1));
        assert!(checked.is_ok(), "{checked:?}");
    }
}

/// ψᵀf is the work of viscosity alone where no fluid crosses the boundary and nothing moves there.
#[test]
fn convection_does_no_work() {
    for closed in [Closed::Sides, Closed::Walls] {
        let rectangle = Rectangle { origin: [0.0, 0.0], size: [1.5, 1.0], cells: [7, 5], closed };
        let still = || Box::new(Boundary { lid: 0.0, through: 0.0 });
        let flow = Confined::new(rectangle, 0.0, still());
        let v = noise(flow.space.dim, 8);
        let mut f = vec![0.0; flow.space.dim];
        flow.field().rhs(0.0, &v, &mut f);
        let size: f64 = f.iter().zip(&v).map(|(f, v)| (f * v).abs()).sum();
        assert!(size > 1.0 && dot(&v, &f).abs() <= 1e-14 * size, "{} of {size}", dot(&v, &f));

        // Viscosity takes energy: with ν alone, ψᵀf < 0, and the form is symmetric.
        let viscous = Confined::new(rectangle, 1.0, still());
        let (zero, x, y) = (vec![0.0; v.len()], noise(v.len(), 9), noise(v.len(), 10));
        let (mut jx, mut jy) = (f.clone(), f.clone());
        viscous.field().apply_jacobian(0.0, &zero, &x, &mut jx);
        viscous.field().apply_jacobian(0.0, &zero, &y, &mut jy);
        assert!(dot(&x, &jx) < 0.0);
        assert!((dot(&y, &jx) - dot(&x, &jy)).abs() <= 1e-12 * (dot(&x, &jx) * dot(&y, &jy)).sqrt());
    }
}

#[test]
fn the_flux_out_of_every_cell_is_zero() {
    use super::staggered::Component::{U, V};
    for flow in all() {
        let w = flow.velocities(0.3, &noise(flow.space.dim, 11));
        let ([nx, ny], [dx, dy]) = (flow.space.rectangle.cells, flow.space.rectangle.spacing());
        for (i, j) in (0..nx as isize).flat_map(|i| (0..ny as isize).map(move |j| (i, j))) {
            let at = |c, i, j| w[super::staggered::place(flow.space.stride, flow.space.padded, c, i, j)];
            let flux = dy * (at(U, i + 1, j) - at(U, i, j)) + dx * (at(V, i, j + 1) - at(V, i, j));
            assert!(flux.abs() <= 16.0 * f64::EPSILON, "{flux} at ({i}, {j})");
        }
    }
}

#[test]
fn the_mass_matrix_is_the_kinetic_energy() {
    for flow in [flow(Closed::Sides, 1.0, 0.0), flow(Closed::Walls, 1.0, 0.0)] {
        let v = noise(flow.space.dim, 12);
        let Mass::Matrix(mass) = flow.field().mass() else { panic!("not a matrix") };
        let x = DVector::from(v.clone());
        let w = flow.velocities(0.0, &v);
        let energy: f64 = flow.space.faces.iter().map(|face| w[face.at].powi(2)).sum::<f64>() * flow.space.area();
        let form = x.dot(&(mass.to_dense() * &x));
        assert!((form - energy).abs() <= 1e-13 * energy, "{form} {energy}");
    }
}

/// What the references are given too, as quadratic as f.
#[test]
fn the_products_by_hand_are_the_derivative() {
    for text in ["cavity cells=5", "kovasznay cells=5", "channel-2d cells=5 length=4", "taylor-green cells=8"] {
        let problem = build_setting(text).expect("known");
        let (ode, n) = (problem.ode(), problem.initial().len());
        let (v, x) = (noise(n, 17), noise(n, 18));
        let moved = |s: f64| -> DVector<f64> {
            let at: Vec<f64> = v.iter().zip(&x).map(|(v, x)| v + s * x).collect();
            let mut f = vec![0.0; n];
            ode.rhs(0.3, &at, &mut f);
            f.into()
        };
        let mut product = vec![0.0; n];
        ode.product(0.3, &v, &x, &mut product);
        let difference = 0.5 * (moved(1.0) - moved(-1.0));
        let apart = max_norm((DVector::from(product) - &difference).as_slice());
        assert!(difference.amax() > 0.1 && apart <= 1e-11 * difference.amax(), "{text}: {apart}");
    }
}

fn periodic() -> [Periodic; 2] {
    [Metric::Velocity, Metric::Vorticity].map(|metric| Periodic::new(12, 0.03, [0.7, -0.4], metric))
}

/// Σ ω_k ω̇_k and Σ ψ_k ω̇_k vanish without viscosity.
#[test]
fn dealiased_convection_conserves_energy_and_enstrophy() {
    let flow = Periodic::new(12, 0.0, [0.7, -0.4], Metric::Vorticity);
    let v = noise(flow.modes.dim(), 8);
    let mut f = v.clone();
    flow.field().rhs(0.0, &v, &mut f);
    let psi: Vec<f64> = v
        .iter()
        .enumerate()
        .map(|(i, z)| {
            let [k, l] = flow.modes.waves[i / 2];
            z / f64::from(k * k + l * l)
        })
        .collect();
    for w in [v, psi] {
        let size: f64 = f.iter().zip(&w).map(|(f, w)| (f * w).abs()).sum();
        assert!(size > 1.0 && dot(&w, &f).abs() <= 1e-13 * size, "{} of {size}", dot(&w, &f));
    }
}

#[test]
fn a_field_has_the_coefficients_that_make_its_values() {
    let flow = Periodic::new(10, 1.0, [0.0; 2], Metric::Velocity);
    let field = |x: f64, y: f64| (x + 2.0 * y).cos() - 0.3 * (3.0 * x - y).sin() + 0.1 * (2.0 * y).sin();
    let v = flow.project(field);
    let values = flow.vorticity(&v);
    let rows: Vec<f64> = flow.modes.coordinates().collect();
    for (j, y) in rows.iter().enumerate() {
        for (i, x) in rows.iter().enumerate() {
            assert!((values[j * 10 + i] - field(*x, *y)).abs() <= 1e-14);
        }
    }
    // ½ mean ω² of a cos is ¼ of its square.
    let [_, enstrophy] = flow.energy_and_enstrophy(&v);
    assert!((enstrophy - 0.25 * (1.0 + 0.09 + 0.01)).abs() <= 1e-14);
}

#[test]
fn a_reynolds_number_that_is_not_positive_is_refused() {
    for flow in super::NAMES {
        for re in ["0", "-10", "nan", "inf"] {
            match build_setting(&format!("{flow} re={re}")) {
                Err(NameError::Value { parameter, .. }) => assert_eq!(parameter, "re", "{flow}"),
                other => panic!("{flow} re={re}: {other:?}"),
            }
        }
    }
}

#[test]
fn an_odd_number_of_grid_points_is_refused_where_the_fourier_method_needs_an_even_one() {
    for flow in ["taylor-green", "shear-layer", "turbulence-2d"] {
        match build_setting(&format!("{flow} cells=33")) {
            Err(NameError::Value { parameter, value, reason }) => {
                assert_eq!((parameter.as_str(), value.as_str()), ("cells", "33"));
                assert!(reason.contains("even"), "{reason}");
            }
            other => panic!("{flow}: {other:?}"),
        }
    }
    assert!(build_setting("cavity cells=33").is_ok());
}

#[test]
fn grids_without_an_interior_and_beyond_memory_are_refused() {
    for (flow, cells) in
        [("cavity", "1"), ("cavity", "513"), ("kovasznay", "0"), ("taylor-green", "4"), ("channel-2d", "x")]
    {
        let refused = build_setting(&format!("{flow} cells={cells}"));
        assert!(matches!(&refused, Err(NameError::Value { parameter, .. }) if parameter == "cells"), "{refused:?}");
    }
}

#[test]
fn a_step_too_long_for_gauss_and_newton_says_where_it_came_to_rest() {
    let problem = build_setting("cavity re=10000 cells=8").expect("known");
    let method = method::parse("method-i").expect("known");
    let error = run(&*problem, &*method, 1e3, 1e3, |_| {}).expect_err("it stalls");
    let RunError::Step(StepError::Solve { source: SolveError::Stalled { gradient, rate, v, .. }, .. }) = &error else {
        panic!("{error}")
    };
    assert!(*gradient < 1e-3 && *rate > 1e-6 && v.len() == 49 && max_norm(v) > 0.0, "{error}");
    let text = error.to_string();
    assert!(["h = 1000", "|g| = ", "|f| = "].iter().all(|part| text.contains(part)), "{text}");
    run(&*problem, &*method, 1.0, 1.0, |_| {}).expect("a shorter step is taken");
}

/// What is left of f there is rounding, and so is every increment.
#[test]
fn a_steady_flow_stays_under_further_steps() {
    let problem = build_setting("cavity cells=8").expect("known");
    let method = method::parse("method-i").expect("known");
    let end = run(&*problem, &*method, 20.0, 800.0, |_| {}).expect("steps at rest succeed").end;
    let mut f = end.q.clone();
    problem.field().rhs(end.t, &end.q, &mut f);
    assert!(max_norm(&end.q) > 0.01 && max_norm(&f) <= 1e-14, "{}", max_norm(&f));
}

/// With four cells there is one unknown ψ: u = ±2ψ and v = ∓2ψ on the four faces, whose second differences are −48ψ each, and
/// on the upper two the lid adds 2/Δy² = 8. Convection does no work, so that with one unknown there is none of it.
#[test]
fn the_smallest_cavity_is_what_it_is_by_pencil() {
    for re in [1.0, 400.0] {
        let problem = build_setting(&format!("cavity cells=2 re={re}")).expect("known");
        for psi in [0.0, -0.1, 3.0] {
            let mut f = [0.0];
            problem.field().rhs(0.0, &[psi], &mut f);
            let expected = -(4.0 + 96.0 * psi) / re;
            assert!((f[0] - expected).abs() <= 1e-13 * (1.0 + psi.abs()), "Re = {re}, ψ = {psi}: {} {expected}", f[0]);
        }
    }
}

/// Where nothing moves, −ν|k|² M is all there is of the Jacobian, and M = 1/|k|² in the velocity metric and 1 in the other.
#[test]
fn the_viscosity_of_periodic_flows_is_the_inverse_of_the_reynolds_number() {
    let waves = Periodic::new(8, 1.0, [0.0; 2], Metric::Velocity).modes.waves;
    for flow in ["taylor-green mean=0", "shear-layer", "turbulence-2d"] {
        for metric in ["velocity", "vorticity"] {
            let problem = build_setting(&format!("{flow} cells=8 re=40 metric={metric}")).expect("known");
            let field = problem.field();
            let x = noise(field.dim(), 16);
            let mut jx = vec![0.0; x.len()];
            field.apply_jacobian(0.0, &vec![0.0; x.len()], &x, &mut jx);
            for (i, (x, j)) in x.iter().zip(&jx).enumerate() {
                let [k, l] = waves[i / 2];
                let weight = if metric == "velocity" { 1.0 } else { f64::from(k * k + l * l) };
                assert!((j + weight * x / 40.0).abs() <= 1e-14, "{flow} {metric}: {j} {x}");
            }
        }
    }
}

#[test]
fn the_shear_layers_start_as_they_are_described() {
    let n = 64;
    let problem = build_setting(&format!("shear-layer cells={n}")).expect("known");
    let vorticity = problem.observe(0.0, &problem.initial());
    let step = std::f64::consts::TAU / n as f64;
    // u rises by 2 tanh(π/2δ) across each layer, and v_x = 0.05 cos x.
    let lower: f64 = vorticity[..n * n / 2].iter().sum::<f64>() / n as f64 * step;
    assert!((lower + 2.0 * std::f64::consts::PI.tanh()).abs() < 0.01, "{lower}");
    let across: f64 = vorticity.iter().enumerate().map(|(k, w)| w * ((k % n) as f64 * step).cos()).sum();
    assert!((2.0 * across / (n * n) as f64 - 0.05).abs() < 1e-12, "{across}");
}

#[test]
fn turbulence_starts_with_an_energy_of_one_half_and_the_spectrum_that_it_is_named_for() {
    let problem = build_setting("turbulence-2d cells=32 peak=4").expect("known");
    let (v, Mass::Diagonal(mass)) = (problem.initial(), problem.field().mass()) else { panic!("not diagonal") };
    let energy: f64 = mass.iter().zip(&v).map(|(m, v)| 0.5 * m * v * v).sum();
    assert!((energy - 0.5).abs() <= 1e-14, "{energy}");
    let waves = Periodic::new(32, 1.0, [0.0; 2], Metric::Velocity).modes.waves;
    let size = |wave| {
        let m = waves.iter().position(|w| *w == wave).expect("a mode");
        v[2 * m].hypot(v[2 * m + 1])
    };
    // κ³ e^{−κ²} of κ = ½, 1 and 2.
    let ratios = [size([2, 0]) / size([4, 0]), size([0, 8]) / size([4, 0])];
    let expected = [0.125 * 0.75_f64.exp(), 8.0 * (-3.0_f64).exp()];
    assert!(ratios.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{ratios:?} {expected:?}");
}

/// ν (k² + l²) by the products with the Jacobian at rest, mode by mode, with 3 a divisor of the number of points too.
#[test]
fn the_fastest_rate_of_a_periodic_flow_is_that_of_its_finest_mode() {
    for points in [8, 10, 12, 16] {
        let problem = build_setting(&format!("turbulence-2d re=50 cells={points} peak=2")).expect("known");
        let (field, Mass::Diagonal(mass)) = (problem.field(), problem.field().mass()) else { panic!("not diagonal") };
        let rates = (0..mass.len()).map(|i| {
            let (rest, mut x, mut jx) = (vec![0.0; mass.len()], vec![0.0; mass.len()], vec![0.0; mass.len()]);
            x[i] = 1.0;
            field.apply_jacobian(0.0, &rest, &x, &mut jx);
            -jx[i] / mass[i]
        });
        let fastest = max_norm(&rates.collect::<Vec<_>>());
        let Stiffness::Transient(rate) = problem.facts().stiffness else { panic!("not stiff") };
        approx::assert_relative_eq!(rate, fastest, max_relative = 1e-12);
    }
}

/// Of M⁻¹J at rest, where both matrices are symmetric, as nothing flows through a wall. Along x and y the fastest mode of a grid without
/// walls has 4/Δx², and one that vanishes at both ends of N cells cos²(π/2N) of that: with eight cells 0.96, and a fifth is room
/// enough.
#[test]
fn the_fastest_rate_between_walls_is_a_bound_that_is_nearly_reached() {
    for text in ["cavity cells=8", "channel-2d cells=8 length=8"] {
        let problem = build_setting(text).expect("known");
        let (field, Mass::Matrix(mass)) = (problem.field(), problem.field().mass()) else { panic!("not a matrix") };
        let n = field.dim();
        let mut jacobian = Jacobian::with_structure(n, &field.structure());
        field.add_jacobian(0.0, &vec![0.0; n], 1.0, &mut jacobian);
        let lower = mass.to_dense().cholesky().expect("it is positive").l().try_inverse().expect("so is its factor");
        let rates = (&lower * jacobian.to_dense() * lower.transpose()).symmetric_eigenvalues();
        let Stiffness::Transient(rate) = problem.facts().stiffness else { panic!("not stiff") };
        assert!(rates.amax() <= rate && rate <= 1.2 * rates.amax(), "{text}: {rate} for {}", rates.amax());
    }
}

/// The vortices at (x − t, y − t/2), less by e^{−2νt}.
#[test]
fn taylor_and_greens_vortices_are_carried_by_their_mean_flow() {
    use std::f64::consts::TAU;
    let (n, t) = (16, 0.7);
    let problem = build_setting(&format!("taylor-green cells={n} re=10 mean=1")).expect("known");
    let place = |i: usize| TAU * i as f64 / n as f64;
    let exact = problem.exact(t).expect("known");
    for (k, found) in exact.iter().enumerate() {
        let (x, y) = (place(k % n), place(k / n));
        let moved = 2.0 * (x - t).cos() * (y - 0.5 * t).cos() * (-0.2 * t).exp();
        assert!((found - moved).abs() < 1e-12, "{found} {moved} at ({x}, {y})");
    }
}

#[test]
fn the_lid_moves_whatever_the_number_of_cells() {
    for cells in [32, 49, 98] {
        let problem = build_setting(&format!("cavity cells={cells}")).expect("known");
        let mut f = problem.initial();
        problem.field().rhs(0.0, &problem.initial(), &mut f);
        assert!(max_norm(&f) > 1e-3, "{cells} cells: nothing moves");
    }
}

/// Where viscosity and the mean flow outweigh convection, Helmholtz's operator is nearly all of B.
#[test]
fn helmholtz_preconditions_what_is_diagonal_in_a_few_iterations() {
    let method = method::parse("method-i").expect("known");
    for metric in ["velocity", "vorticity"] {
        for mean in [0.0, 20.0] {
            let text = format!("taylor-green cells=16 re=0.1 mean={mean} metric={metric}");
            let problem = build_setting(&text).expect("known");
            let work = run(&*problem, &*method, 0.02, 0.1, |_| {}).expect("it runs").work;
            let each = work.inner as f64 / work.factorizations as f64;
            assert!(work.inner > 0 && each <= 6.0, "{text}: {each} {work:?}");
        }
    }
}

/// The derivative by the central difference of eighth order: of sin 2πx all but (2π/100)⁸/630 = 4e-13.
fn slope(f: impl Fn(f64) -> f64) -> f64 {
    const SPACING: f64 = 0.01;
    let weights = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
    let pairs = weights.into_iter().zip(1..).map(|(w, k)| w * (f(f64::from(k) * SPACING) - f(-f64::from(k) * SPACING)));
    pairs.sum::<f64>() / SPACING
}

/// The rotation of u_t + (u·∇)u − νΔu − f, in which the pressure does not occur, and the size of what cancels in it.
fn rotation_of_the_residual(given: &dyn Given, nu: f64, [x, y]: [f64; 2], t: f64) -> [f64; 2] {
    let u = |x: f64, y: f64, t: f64, of: usize| given.exact([x, y], t).expect("it is known")[of];
    let omega = |x: f64, y: f64, t: f64| slope(|d| u(x + d, y, t, 1)) - slope(|d| u(x, y + d, t, 0));
    let force = |x: f64, y: f64, of: usize| given.force([x, y], t).map_or(0.0, |force| force[of]);
    let gradient = [slope(|d| omega(x + d, y, t)), slope(|d| omega(x, y + d, t))];
    let laplacian = slope(|d| slope(|e| omega(x + d + e, y, t))) + slope(|d| slope(|e| omega(x, y + d + e, t)));
    let terms = [
        slope(|d| omega(x, y, t + d)),
        u(x, y, t, 0) * gradient[0],
        u(x, y, t, 1) * gradient[1],
        -nu * laplacian,
        -slope(|d| force(x + d, y, 1)),
        slope(|d| force(x, y + d, 0)),
    ];
    [terms.iter().sum(), max_norm(&terms)]
}

/// To the accuracy of differences: three of them in one term leave 1e-16/0.01³ of rounding.
#[test]
fn the_exact_flows_with_their_forces_satisfy_the_equations() {
    let flows: [(&str, f64, Box<dyn Given>); 5] = [
        ("kovasznay", 1.0 / 40.0, Box::new(kovasznay(40.0, 0.5))),
        ("kovasznay", 0.25, Box::new(kovasznay(4.0, -1.0))),
        ("cavity-manufactured", 0.1, Box::new(manufactured(0.1))),
        ("cavity-manufactured", 2.0, Box::new(manufactured(2.0))),
        ("channel-2d", 0.7, Box::new(pressure(0.7))),
    ];
    for (name, nu, given) in &flows {
        for (at, t) in [([0.31, 0.42], 0.37), ([0.72, -0.13], 0.37), ([0.15, 0.23], 0.8)] {
            let [sum, size] = rotation_of_the_residual(&**given, *nu, at, t);
            assert!(size > 0.01 && sum.abs() <= 1e-7 * size, "{name}, ν = {nu} at {at:?}, {t}: {sum} of {size}");
        }
    }
}

#[test]
fn the_exact_flows_have_no_divergence_and_are_those_of_their_boundaries() {
    let flows: [Box<dyn Given>; 2] = [Box::new(kovasznay(40.0, 0.5)), Box::new(manufactured(0.1))];
    for given in &flows {
        for ([x, y], t) in [([0.31, 0.42], 0.37), ([0.72, -0.13], 0.8)] {
            let exact = given.exact([x, y], t).expect("it is known");
            let rate = |of: usize, dx: f64, dy: f64| {
                slope(|d| given.exact([x + d * dx, y + d * dy], t).expect("it is known")[of])
            };
            let psi = |dx: f64, dy: f64, dt: f64| slope(|d| given.stream([x + d * dx, y + d * dy], t + d * dt));
            let apart = [
                rate(0, 1.0, 0.0) + rate(1, 0.0, 1.0),
                psi(0.0, 1.0, 0.0) - exact[0],
                psi(1.0, 0.0, 0.0) + exact[1],
                psi(0.0, 0.0, 1.0) - given.stream_rate([x, y], t),
            ];
            assert!(max_norm(&exact) > 0.01 && max_norm(&apart) <= 1e-8, "{given:?}: {apart:?}");
            assert_eq!(given.velocity([x, y], t), exact, "{given:?}");
        }
    }
    // Between the walls of the channel u depends on y alone, so that it has no divergence.
    let given = pressure(0.7);
    assert_eq!(given.exact([0.1, 0.3], 0.5), given.exact([0.9, 0.3], 0.5));
}

/// The layout that the README tells.
#[test]
fn observed_values_run_along_x_first_and_u_comes_before_v() {
    use std::f64::consts::PI;
    let problem = build_setting("cavity-manufactured cells=4").expect("known");
    let exact = problem.exact(0.5).expect("known");
    // ψ = a sin² πx (y³ − y²), u = ψ_y, v = −ψ_x.
    let u = |x: f64, y: f64| (PI * x).sin().powi(2) * (3.0 * y * y - 2.0 * y);
    let v = |x: f64, y: f64| -PI * (2.0 * PI * x).sin() * (y.powi(3) - y * y);
    let mut shape = Vec::new();
    for j in 1..=4 {
        shape.extend((1..=3).map(|i| u(f64::from(i) / 4.0, (f64::from(j) - 0.5) / 4.0)));
    }
    for j in 1..=3 {
        shape.extend((1..=4).map(|i| v((f64::from(i) - 0.5) / 4.0, f64::from(j) / 4.0)));
    }
    let a = exact[0] / shape[0];
    assert!(a.abs() > 0.01 && exact.len() == shape.len());
    assert!(exact.iter().zip(&shape).all(|(exact, shape)| (exact - a * shape).abs() < 1e-12), "{exact:?}");

    let problem = build_setting("taylor-green cells=8").expect("known");
    let at = |k: usize| 2.0 * PI * k as f64 / 8.0;
    let seen = problem.observe(0.0, &problem.initial());
    let vorticity = (0..64).map(|k| 2.0 * at(k % 8).cos() * at(k / 8).cos());
    assert!(seen.iter().zip(vorticity).all(|(seen, exact)| (seen - exact).abs() < 1e-12));
    // Of the two directions the start of the shear layers tells x from y.
    let problem = build_setting("shear-layer cells=16").expect("known");
    let seen = problem.observe(0.0, &problem.initial());
    let along_x = (seen[1] - seen[0]).abs();
    let along_y = (seen[16 * 2] - seen[0]).abs();
    assert!(along_x < 0.01 && along_y > 0.05, "{along_x} {along_y}");
}
