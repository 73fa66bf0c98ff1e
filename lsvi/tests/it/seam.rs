//! Fields by products with their derivatives.

use std::cell::Cell;

use crate::fields::Burgers;
use approx::assert_abs_diff_eq;
use lsvi::classic::{RungeKutta, Tableau};
use lsvi::{
    AutoDiff, Jacobian, Mass, MassOperator, OneStep, SolveError, StepError, Structure, VectorField, add_columns,
    method_i,
};

fn wave(n: usize, k: f64) -> Vec<f64> {
    (0..n).map(|i| (k * i as f64).sin() + 0.2 * (1.7 * i as f64).cos()).collect()
}

/// A field that forgets its matrix and keeps the products.
struct Products<F> {
    field: F,
    applied: Cell<usize>,
}

impl<F: VectorField> VectorField for Products<F> {
    fn dim(&self) -> usize {
        self.field.dim()
    }
    fn structure(&self) -> Structure {
        Structure::MatrixFree
    }
    fn mass(&self) -> Mass {
        self.field.mass()
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.field.rhs(t, v, dv);
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        add_columns(self, t, v, scale, out);
    }
    fn add_curvature(&self, _t: f64, _v: &[f64], _w: &[f64], _scale: f64, _out: &mut Jacobian) {}
    fn apply_jacobian(&self, t: f64, v: &[f64], x: &[f64], out: &mut [f64]) {
        self.applied.set(self.applied.get() + 1);
        self.field.apply_jacobian(t, v, x, out);
    }
    fn apply_transpose(&self, t: f64, v: &[f64], w: &[f64], out: &mut [f64]) {
        self.field.apply_transpose(t, v, w, out);
    }
}

fn burgers(n: usize) -> AutoDiff<Burgers> {
    AutoDiff::new(Burgers { cells: n, viscosity: 0.05 })
}

#[test]
fn products_follow_from_the_assembled_matrices() {
    let (n, field) = (12, burgers(12));
    let (v, w, x) = (wave(n, 0.3), wave(n, 0.7), wave(n, 1.1));
    let mut jacobian = Jacobian::zeros(n);
    field.add_jacobian(0.0, &v, 1.0, &mut jacobian);
    let mut curvature = Jacobian::zeros(n);
    field.add_curvature(0.0, &v, &w, 1.0, &mut curvature);
    let (jacobian, curvature) = (jacobian.to_dense(), curvature.to_dense());
    let column = |x: &[f64]| nalgebra::DVector::from_column_slice(x);
    let mut out = vec![0.0; n];
    // A dozen roundings of terms below the largest entry.
    let bound = 16.0 * f64::EPSILON * jacobian.amax();
    field.apply_jacobian(0.0, &v, &x, &mut out);
    assert_abs_diff_eq!(column(&out), &jacobian * column(&x), epsilon = bound);
    field.apply_transpose(0.0, &v, &w, &mut out);
    assert_abs_diff_eq!(column(&out), jacobian.tr_mul(&column(&w)), epsilon = bound);
    field.apply_curvature(0.0, &v, &w, &x, &mut out);
    assert_abs_diff_eq!(column(&out), &curvature * column(&x), epsilon = bound);
    // f is quadratic, so that differences of products cost rounding only, ε/∛ε of the products.
    let products = Products { field: &field, applied: Cell::new(0) };
    products.apply_curvature(0.0, &v, &w, &x, &mut out);
    let bound = 16.0 * f64::EPSILON.powf(2.0 / 3.0) * jacobian.amax();
    assert_abs_diff_eq!(column(&out), &curvature * column(&x), epsilon = bound);
    let mut columns = Jacobian::zeros(n);
    products.add_jacobian(0.0, &v, 1.0, &mut columns);
    assert_abs_diff_eq!(columns.to_dense(), jacobian, epsilon = 16.0 * f64::EPSILON * 625.0);
    assert_eq!(products.applied.get(), n);
}

#[derive(Debug)]
struct Doubled(usize);

impl MassOperator for Doubled {
    fn dim(&self) -> usize {
        self.0
    }
    fn apply(&self, x: &[f64], out: &mut [f64]) {
        out.iter_mut().zip(x).for_each(|(o, x)| *o = 2.0 * x);
    }
    fn solve(&self, b: &mut [f64]) {
        b.iter_mut().for_each(|b| *b *= 0.5);
    }
}

/// v̇ = −v in a mass that is an operator.
struct Massive;

impl VectorField for Massive {
    fn dim(&self) -> usize {
        3
    }
    fn mass(&self) -> Mass {
        Mass::operator(Doubled(3))
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv.iter_mut().zip(v).for_each(|(d, v)| *d = -2.0 * v);
    }
    fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
        (0..3).for_each(|i| out.add(i, i, -2.0 * scale));
    }
    fn add_curvature(&self, _t: f64, _v: &[f64], _w: &[f64], _scale: f64, _out: &mut Jacobian) {}
}

#[test]
fn factorisations_refuse_what_has_no_matrix() {
    fn step(mut method: impl OneStep) -> Option<SolveError> {
        let n = method.dim();
        match method.step(0.0, 0.1, &mut wave(n, 0.3), &mut vec![0.0; n]) {
            Err(StepError::Solve { source, .. }) => Some(source),
            _ => None,
        }
    }
    let products = Products { field: burgers(6), applied: Cell::new(0) };
    assert_eq!(step(RungeKutta::new(&products, Tableau::implicit_euler())), Some(SolveError::NotAssembled));
    assert_eq!(step(RungeKutta::new(&Massive, Tableau::implicit_euler())), Some(SolveError::NotAssembled));
    assert_eq!(step(method_i(&products)), Some(SolveError::NotAssembled));
    // An explicit method needs the inverse of M only.
    let mut v = [1.0; 3];
    RungeKutta::new(&Massive, Tableau::rk4()).step(0.0, 0.1, &mut v, &mut []).expect("explicit");
    assert_abs_diff_eq!(v[0], (-0.1_f64).exp(), epsilon = 0.1_f64.powi(5) / 120.0);
}
