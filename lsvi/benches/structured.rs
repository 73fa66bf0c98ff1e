//! Cost of a step per unknown of the 1-D heat equation: Method I in each formulation, implicit Euler, a hand-written kernel.
//!
//! Rates are unknowns per second; their ratios are the result. `reused` steps keep their factors (a linear field at constant
//! h), `factored` ones change h every time. Implicit Euler is Newton's method, which factors twice per step.

use std::hint::black_box;

use divan::Bencher;
use divan::counter::ItemsCount;
use lsvi::classic::{RungeKutta, Tableau};
use lsvi::closure::Linear;
use lsvi::solver::{Augmented, Iterative, StepSolver, Twisted};
use lsvi::{Factored, Jacobian, LeastSquaresStep, OneStep, Structure, VectorField};

const CELLS: [usize; 4] = [64, 256, 1024, 4096];

fn main() {
    divan::main();
}

/// v_t = v_xx on n cells of (0, 1), zero at the walls; `linear` is whether it says so.
struct Heat {
    cells: usize,
    linear: bool,
}

impl Heat {
    fn weight(&self) -> f64 {
        ((self.cells + 1) * (self.cells + 1)) as f64
    }

    /// h with h|λ_max| = 1000.
    fn step_size(&self) -> f64 {
        250.0 / self.weight()
    }
}

impl VectorField for Heat {
    fn dim(&self) -> usize {
        self.cells
    }
    fn structure(&self) -> Structure {
        Structure::Banded { lower: 1, upper: 1 }
    }
    fn is_linear(&self) -> bool {
        self.linear
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        let (n, weight) = (v.len(), self.weight());
        dv[0] = weight * (v[1] - 2.0 * v[0]);
        for (dv, v) in dv[1..n - 1].iter_mut().zip(v.windows(3)) {
            *dv = weight * (v[0] - 2.0 * v[1] + v[2]);
        }
        dv[n - 1] = weight * (v[n - 2] - 2.0 * v[n - 1]);
    }
    fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        let weight = scale * self.weight();
        for i in 0..v.len() {
            out.add(i, i, -2.0 * weight);
            if i > 0 {
                out.add(i, i - 1, weight);
                out.add(i - 1, i, weight);
            }
        }
    }
    fn add_curvature(&self, _t: f64, _v: &[f64], _w: &[f64], _scale: f64, _out: &mut Jacobian) {}
}

fn start(n: usize) -> Vec<f64> {
    (1..=n).map(|i| (std::f64::consts::PI * i as f64 / (n + 1) as f64).sin()).collect()
}

fn bench(bencher: Bencher, mut method: impl OneStep, h: impl Fn(u32) -> f64) {
    let n = method.dim();
    let v = start(n);
    let (mut q, mut p) = (v.clone(), vec![0.0; n]);
    let mut count = 0_u32;
    bencher.counter(ItemsCount::new(n)).bench_local(|| {
        q.copy_from_slice(&v);
        count = count.wrapping_add(1);
        method.step(0.0, h(count), black_box(&mut q), &mut p).expect("solvable");
    });
}

fn solver(bencher: Bencher, cells: usize, solver: impl StepSolver + 'static, vary: f64) {
    let field = Heat { cells, linear: true };
    let h = field.step_size();
    let method = LeastSquaresStep::with_solver(field, Linear::METHOD_I, solver).expect("fits");
    bench(bencher, method, |count| h * (1.0 + vary * f64::from(count % 2)));
}

#[divan::bench(args = CELLS)]
fn augmented_reused(bencher: Bencher, cells: usize) {
    solver(bencher, cells, Augmented::new(), 0.0);
}

#[divan::bench(args = CELLS)]
fn augmented_factored(bencher: Bencher, cells: usize) {
    solver(bencher, cells, Augmented::new(), 0.01);
}

#[divan::bench(args = CELLS)]
fn twisted_reused(bencher: Bencher, cells: usize) {
    solver(bencher, cells, Twisted::new(), 0.0);
}

#[divan::bench(args = CELLS)]
fn twisted_factored(bencher: Bencher, cells: usize) {
    solver(bencher, cells, Twisted::new(), 0.01);
}

#[divan::bench(args = CELLS)]
fn conjugate_gradients_reused(bencher: Bencher, cells: usize) {
    let iterative = Iterative::new(Factored::default()).with_tolerance(1e-6).expect("in (0, 1)");
    solver(bencher, cells, iterative, 0.0);
}

#[divan::bench(args = CELLS)]
fn newton(bencher: Bencher, cells: usize) {
    let field = Heat { cells, linear: false };
    let h = field.step_size();
    bench(bencher, lsvi::method_i(field).expect("usable"), |_| h);
}

#[divan::bench(args = CELLS)]
fn implicit_euler(bencher: Bencher, cells: usize) {
    let field = Heat { cells, linear: false };
    let h = field.step_size();
    bench(bencher, RungeKutta::new(field, Tableau::implicit_euler()).expect("usable"), |_| h);
}

/// Thomas's algorithm for (I − h A) v₁ = v₀ with constant coefficients: the least that an implicit step can cost.
#[divan::bench(args = CELLS)]
fn hand_written_tridiagonal(bencher: Bencher, n: usize) {
    let field = Heat { cells: n, linear: true };
    let off = -field.step_size() * field.weight();
    let v = start(n);
    let (mut x, mut upper) = (v.clone(), vec![0.0; n]);
    bencher.counter(ItemsCount::new(n)).bench_local(|| {
        x.copy_from_slice(&v);
        let mut pivot = 1.0 - 2.0 * off;
        x[0] /= pivot;
        for i in 1..n {
            upper[i - 1] = off / pivot;
            pivot = 1.0 - 2.0 * off - off * upper[i - 1];
            x[i] = (x[i] - off * x[i - 1]) / pivot;
        }
        for i in (0..n - 1).rev() {
            x[i] -= upper[i] * x[i + 1];
        }
        black_box(&mut x);
    });
}
