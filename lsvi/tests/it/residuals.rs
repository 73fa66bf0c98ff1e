//! The equations of least squares by way of the residuals: those of the momenta, and their derivatives.

use crate::fields::Burgers;
use crate::systems::HenonHeiles;
use lsvi::discrete::{DiscreteLegendre, Galerkin, Interval, Midpoint, MomentumWeights, Trapezoidal};
use lsvi::nalgebra::DMatrix;
use lsvi::quadrature::Quadrature;
use lsvi::{AutoField, AutoLagrangian, Jacobian, Lagrangian, LeastSquares, Mass, VectorField, field};

const AT: Interval = Interval { start: 0.3, h: 0.7 };
const Q0: [f64; 2] = [0.4, -0.3];

/// Nothing in it is linear, and it depends on time.
fn curved() -> impl VectorField {
    field!(2, |t, v, dv| {
        dv[0] = v[1].sin() * v[0] + T::from(t);
        dv[1] = v[0] * v[0] * v[1] - v[0].exp();
    })
}

/// The same with an M that is not diagonal.
struct Massive<F>(F);

impl<F: VectorField> VectorField for Massive<F> {
    fn dim(&self) -> usize {
        self.0.dim()
    }
    fn mass(&self) -> Mass {
        let m = DMatrix::from_row_slice(2, 2, &[2.0, 0.5, 0.5, 1.0]);
        Mass::Matrix(Jacobian::try_from(m).expect("square"))
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.0.rhs(t, v, dv);
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        self.0.add_jacobian(t, v, scale, out);
    }
    fn add_curvature(&self, t: f64, v: &[f64], y: &[f64], scale: f64, out: &mut Jacobian) {
        self.0.add_curvature(t, v, y, scale, out);
    }
}

fn discretisations<L: Lagrangian>(lagrangian: impl Fn() -> L) -> Vec<(usize, Galerkin<L>)> {
    let rules = [
        (1, Quadrature::gauss(1)),
        (2, Quadrature::radau(2)),
        (2, Quadrature::lobatto(2)),
        (3, Quadrature::gauss(3)),
        (3, Quadrature::radau(3)),
    ];
    rules.map(|(s, rule)| (s, Galerkin::new(lagrangian(), s, &rule.expect("nodes")).expect("enough nodes"))).into()
}

fn metric() -> DMatrix<f64> {
    DMatrix::from_row_slice(2, 2, &[3.0, -1.0, -1.0, 2.0])
}

fn check<L: Lagrangian>(lagrangian: impl Fn() -> L) {
    for (degree, mut discrete) in discretisations(lagrangian) {
        for w in [MomentumWeights { alpha: 0.0, beta: 1.0 }, MomentumWeights { alpha: -0.5, beta: 1.25 }] {
            let (unknowns, all) = (2 * degree, 2 * degree + discrete.residuals());
            assert!(all > unknowns, "a dense least-squares Lagrangian has residuals");
            let mut xz = vec![0.0; all];
            (0..unknowns).for_each(|i| xz[i] = Q0[i % 2] + 0.2 * (1.3 * i as f64).cos());
            let mut out = vec![0.0; all];
            discrete.residual_equations(AT, &Q0, &xz, w, &mut out);
            xz[unknowns..].copy_from_slice(&out[unknowns..]);
            discrete.residual_equations(AT, &Q0, &xz, w, &mut out);
            let mut expected = vec![0.0; unknowns];
            discrete.equations(AT, &Q0, &xz[..unknowns], w, &mut expected);
            let size = expected.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
            for (found, expected) in out.iter().zip(expected.iter().map(|x| AT.h * x).chain(std::iter::repeat(0.0))) {
                assert!(
                    (found - expected).abs() <= 64.0 * f64::EPSILON * size,
                    "{degree}, {w:?}: {found} for {expected}"
                );
            }
            differentiate(&mut discrete, &xz, w);
        }
    }
}

/// Central differences of step e are off by e² of third derivatives and ε/e, 1e-10 of the largest entry each.
fn differentiate(discrete: &mut impl DiscreteLegendre, xz: &[f64], w: MomentumWeights) {
    const E: f64 = 1e-5;
    let all = xz.len();
    // z that are not those of x show a term that vanishes with them.
    let xz: Vec<f64> = xz.iter().enumerate().map(|(i, x)| x + 0.1 * (i as f64).sin()).collect();
    let mut exact = Jacobian::zeros(all);
    discrete.add_residual_derivative(AT, &Q0, &xz, w, &mut exact);
    let largest = exact.to_dense().amax();
    for j in 0..all {
        let [plus, minus] = [E, -E].map(|e| {
            let (mut moved, mut out) = (xz.clone(), vec![0.0; all]);
            moved[j] += e;
            discrete.residual_equations(AT, &Q0, &moved, w, &mut out);
            out
        });
        for i in 0..all {
            let difference = (plus[i] - minus[i]) / (2.0 * E);
            assert!(
                (exact.get(i, j) - difference).abs() <= 1e-8 * largest,
                "({i}, {j}), {w:?}: {}, {difference}",
                exact.get(i, j)
            );
        }
    }
}

#[test]
fn equations_by_residuals_are_those_of_the_momenta_and_have_their_derivatives() {
    check(|| LeastSquares::new(curved()).expect("dense"));
    check(|| LeastSquares::new(Massive(curved())).expect("positive definite"));
    check(|| LeastSquares::new(curved()).and_then(|l| l.with_metric(metric())).expect("positive definite"));
    check(|| LeastSquares::new(Massive(curved())).and_then(|l| l.with_metric(metric())).expect("positive definite"));
}

/// Paths on more nodes than their degree, of other structures or of Lagrangians of motion, and discretisations without paths.
#[test]
fn equations_without_a_residual_form_have_no_residuals() {
    let l = || LeastSquares::new(curved()).expect("dense");
    let more = Galerkin::new(l(), 2, &Quadrature::gauss(3).expect("nodes")).expect("enough nodes");
    let burgers = AutoField::new(Burgers { cells: 5, viscosity: 0.1 });
    let banded = Galerkin::gauss(LeastSquares::new(burgers).expect("banded"), 2).expect("s >= 1");
    let motion = Galerkin::gauss(AutoLagrangian::new(HenonHeiles), 2).expect("s >= 1");
    let without: [&mut dyn DiscreteLegendre; 5] =
        [&mut Trapezoidal::new(l()), &mut Midpoint::new(l()), &mut { more }, &mut { banded }, &mut { motion }];
    for discrete in without {
        let q0 = [0.4, -0.3, 0.1, 0.2, -0.1];
        let n = discrete.dim();
        assert_eq!((discrete.residuals(), discrete.has_unlike_units(AT, &q0[..n])), (0, false));
    }
}

/// A spring of stiffness k turns √k times as fast in its velocity as in its position.
#[test]
fn units_of_a_spring_are_unlike_where_it_is_stiff() {
    fn unlike(spring: impl VectorField) -> bool {
        let mut discrete = Galerkin::gauss(LeastSquares::new(spring).expect("dense"), 2).expect("s >= 1");
        discrete.has_unlike_units(AT, &Q0)
    }
    assert!(!unlike(field!(2, |_t, v, dv| (dv[0], dv[1]) = (v[1], -v[0]))));
    assert!(unlike(field!(2, |_t, v, dv| (dv[0], dv[1]) = (v[1], v[0] * -1e6))));
}
