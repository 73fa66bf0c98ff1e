//! Adaptive Radau IIA on van der Pol's equation, μ = 1000, to t = 2000: the library with all its orders, with order 5 alone, and
//! a loop of order 5 written by hand for two unknowns. Times per run; their ratios are the result.

use std::ops::{Add, Mul};

use divan::{Bencher, black_box};
use lsvi::adaptive::{Options, Radau, Tolerances};
use lsvi::{Jacobian, State, Trajectory, VectorField};

const TOLERANCES: [f64; 4] = [1e-3, 1e-6, 1e-9, 1e-12];
const MU: f64 = 1000.0;
const END: f64 = 2000.0;

fn main() {
    // The counts and the end of each, so that the times compare the same work.
    for tolerance in TOLERANCES {
        for most in [7, 3] {
            let (v, steps) = library(tolerance, most);
            println!("{tolerance:e}: lsvi, s ≤ {most}: {steps} steps to {:.12}", v[0]);
        }
        let (v, steps) = hand_written(tolerance);
        println!("{tolerance:e}: by hand, s = 3: {steps} steps to {:.12}", v[0]);
    }
    divan::main();
}

struct VanDerPol;

impl VectorField for VanDerPol {
    fn dim(&self) -> usize {
        2
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv.copy_from_slice(&rhs([v[0], v[1]]));
    }
    fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        for (i, row) in jacobian([v[0], v[1]]).iter().enumerate() {
            row.iter().enumerate().for_each(|(j, x)| out.add(i, j, scale * x));
        }
    }
    fn add_curvature(&self, _t: f64, _v: &[f64], _w: &[f64], _scale: f64, _out: &mut Jacobian) {}
}

fn rhs(v: [f64; 2]) -> [f64; 2] {
    [v[1], (1.0 - v[0] * v[0]) * v[1] * MU - v[0]]
}

fn jacobian(v: [f64; 2]) -> [[f64; 2]; 2] {
    [[0.0, 1.0], [-2.0 * v[0] * v[1] * MU - 1.0, (1.0 - v[0] * v[0]) * MU]]
}

fn library(tolerance: f64, most: usize) -> (Vec<f64>, u64) {
    let tolerances = Tolerances::new(tolerance, tolerance).expect("positive");
    let options = Options::new(tolerances).stages(3, most).expect("a choice");
    let mut method = Radau::new(VanDerPol, options).expect("usable");
    let start = State::new(0.0, vec![2.0, 0.0]);
    let run = Trajectory::new(&mut method, start, END, END).expect("valid");
    let end = run.observe(|_| {}).expect("solvable");
    (end.q, lsvi::Integrator::work(&method).steps)
}

#[divan::bench(args = TOLERANCES)]
fn lsvi(bencher: Bencher, tolerance: f64) {
    bencher.bench_local(|| library(black_box(tolerance), 7));
}

#[divan::bench(args = TOLERANCES)]
fn lsvi_order_five(bencher: Bencher, tolerance: f64) {
    bencher.bench_local(|| library(black_box(tolerance), 3));
}

#[divan::bench(args = TOLERANCES)]
fn hand_written_order_five(bencher: Bencher, tolerance: f64) {
    bencher.bench_local(|| hand_written(black_box(tolerance)));
}

/// Solves a 2 × 2 system by its adjugate.
fn solve2<T: Copy + Mul<Output = T> + Add<Output = T>>(inverse: &[[T; 2]; 2], b: [T; 2]) -> [T; 2] {
    inverse.map(|row| row[0] * b[0] + row[1] * b[1])
}

/// RADAU5 for two unknowns: everything on the stack, tolerances and controller as the library has them.
fn hand_written(tolerance: f64) -> ([f64; 2], u64) {
    use nalgebra::Complex;
    let (p, q) = (9.0_f64.cbrt(), 3.0_f64.cbrt());
    let gamma = 3.0 + p - q;
    let pair = Complex::new(3.0 - 0.5 * (p - q), -0.5 * 3.0_f64.sqrt() * (p + q));
    let root = 6.0_f64.sqrt();
    let c = [(4.0 - root) / 10.0, (4.0 + root) / 10.0, 1.0];
    let a = nalgebra::Matrix3::new(
        (88.0 - 7.0 * root) / 360.0,
        (296.0 - 169.0 * root) / 1800.0,
        (-2.0 + 3.0 * root) / 225.0,
        (296.0 + 169.0 * root) / 1800.0,
        (88.0 + 7.0 * root) / 360.0,
        (-2.0 - 3.0 * root) / 225.0,
        (16.0 - root) / 36.0,
        (16.0 + root) / 36.0,
        1.0 / 9.0,
    );
    let inverse_a = a.try_inverse().expect("regular");
    let eigenvector = |l: Complex<f64>| {
        let m = inverse_a.map(Complex::from);
        let (x, y) = (m[(0, 0)] - l, m[(1, 1)] - l);
        let d = x * y - m[(0, 1)] * m[(1, 0)];
        [(m[(0, 1)] * m[(1, 2)] - m[(0, 2)] * y) / d, (m[(1, 0)] * m[(0, 2)] - m[(1, 2)] * x) / d, Complex::from(1.0)]
    };
    let (real, complex) = (eigenvector(gamma.into()), eigenvector(pair.conj()));
    let t = nalgebra::Matrix3::from_fn(|i, j| [real[i].re, complex[i].re, complex[i].im][j]);
    let t_inverse = t.try_inverse().expect("regular");
    let e = [-(13.0 + 7.0 * root) / 3.0, (7.0 * root - 13.0) / 3.0, -1.0 / 3.0];
    let weights = |x: f64| {
        let points = [0.0, c[0], c[1], c[2]];
        [1, 2, 3]
            .map(|j| (0..4).filter(|k| *k != j).map(|k| (x - points[k]) / (points[j] - points[k])).product::<f64>())
    };
    let (mut v, mut now, mut steps) = ([2.0, 0.0], 0.0, 0);
    let f = rhs(v);
    let mut h = 0.01 * (v[0] / tolerance) / ((f[0] / tolerance).hypot(f[1] / tolerance)).max(1.0);
    let mut old: Option<([[f64; 2]; 3], f64)> = None;
    let (mut accepted, mut rejected): (Option<(f64, f64)>, bool) = (None, false);
    let (mut j, mut has_j, mut current) = ([[0.0; 2]; 2], false, false);
    let (mut single, mut double, mut factored) = ([[0.0; 2]; 2], [[Complex::from(0.0); 2]; 2], f64::NAN);
    let mut kept = 1.0_f64;
    while now < END * (1.0 - 1e-15) {
        let f0 = rhs(v);
        loop {
            let left = END - now;
            let size = if left <= h {
                left
            } else if left < 2.0 * h {
                0.5 * left
            } else {
                h
            };
            if !has_j {
                (j, has_j, current, factored) = (jacobian(v), true, true, f64::NAN);
            }
            if factored != size {
                let (g, s) = (gamma / size, pair / size);
                let d = (g - j[0][0]) * (g - j[1][1]) - j[0][1] * j[1][0];
                single = [[(g - j[1][1]) / d, j[0][1] / d], [j[1][0] / d, (g - j[0][0]) / d]];
                let d = ((s - j[0][0]) * (s - j[1][1]) - j[0][1] * j[1][0]).inv();
                double = [[(s - j[1][1]) * d, d * j[0][1]], [d * j[1][0], (s - j[0][0]) * d]];
                (factored, kept) = (size, 1.0);
            }
            let mut z = [[0.0; 2]; 3];
            if let Some((last, before)) = old {
                for (z, c) in z.iter_mut().zip(c) {
                    let w = weights(1.0 + c * size / before);
                    *z = [0, 1].map(|k| w[0] * last[0][k] + w[1] * last[1][k] + (w[2] - 1.0) * last[2][k]);
                }
            }
            let (mut contraction, mut before, mut rate) = (kept.max(f64::EPSILON).powf(0.8), f64::INFINITY, 0.0_f64);
            let mut converged = None;
            for iteration in 1..=7 {
                let mut r = z.map(|z| rhs([v[0] + z[0], v[1] + z[1]]));
                for i in 0..3 {
                    for k in 0..2 {
                        r[i][k] -= (0..3).map(|l| inverse_a[(i, l)] * z[l][k]).sum::<f64>() / size;
                    }
                }
                let w: [[f64; 2]; 3] =
                    [0, 1, 2].map(|i| [0, 1].map(|k| (0..3).map(|l| t_inverse[(i, l)] * r[l][k]).sum()));
                let x = solve2(&single, w[0]);
                let y = solve2(&double, [Complex::new(w[1][0], w[2][0]), Complex::new(w[1][1], w[2][1])]);
                let mut sum = 0.0;
                for k in 0..2 {
                    let d: [f64; 3] = [0, 1, 2].map(|i| t[(i, 0)] * x[k] + t[(i, 1)] * y[k].re + t[(i, 2)] * y[k].im);
                    let mut largest = v[k].abs();
                    for i in 0..3 {
                        z[i][k] += d[i];
                        largest = largest.max((v[k] + z[i][k]).abs());
                    }
                    let tolerated = tolerance * (1.0 + largest);
                    sum += d.iter().map(|d| (d / tolerated).powi(2)).sum::<f64>();
                }
                let norm = (sum / 6.0).sqrt();
                if !norm.is_finite() {
                    break;
                }
                if before.is_finite() {
                    rate = if rate == 0.0 { norm / before } else { (norm / before * rate).sqrt() };
                    if rate >= 0.99 || (iteration < 7 && rate / (1.0 - rate) * norm * rate.powi(6 - iteration) > 0.03) {
                        break;
                    }
                    contraction = rate / (1.0 - rate);
                }
                before = norm.max(f64::MIN_POSITIVE);
                if contraction * norm <= 0.03 {
                    kept = contraction;
                    converged = Some(iteration);
                    break;
                }
            }
            let Some(iterations) = converged else {
                rejected = true;
                if current {
                    h = 0.5 * size
                } else {
                    has_j = false
                }
                continue;
            };
            let slope = [0, 1].map(|k| (0..3).map(|i| e[i] * z[i][k]).sum::<f64>() / size);
            let norm = |x: [f64; 2]| {
                let terms = [0, 1].map(|k: usize| {
                    let largest = v[k].abs().max((v[k] + z[2][k]).abs());
                    let tolerated = tolerance * (1.0 + largest);
                    (x[k] / (tolerated * (0.1 * (largest / tolerated).cbrt()).max(1.0))).powi(2)
                });
                (0.5 * (terms[0] + terms[1])).sqrt().max(1e-10)
            };
            let first = solve2(&single, [f0[0] + slope[0], f0[1] + slope[1]]);
            let mut error = norm(first);
            if error >= 1.0 && (rejected || accepted.is_none()) {
                let f = rhs([v[0] + first[0], v[1] + first[1]]);
                error = norm(solve2(&single, [f[0] + slope[0], f[1] + slope[1]]));
            }
            let quotient = (error.sqrt().sqrt() / (0.9 * 15.0 / f64::from(14 + iterations))).clamp(0.125, 8.0);
            if error >= 1.0 {
                rejected = true;
                h = if accepted.is_none() { 0.1 * size } else { size / quotient };
                continue;
            }
            let mut next = size / quotient;
            if let Some((before, last)) = accepted {
                let foreseen = before / size * (error * error / last).sqrt().sqrt() / 0.9;
                next = next.min(size / foreseen.clamp(0.125, 8.0));
            }
            accepted = Some((size, error.max(1e-2)));
            if std::mem::take(&mut rejected) {
                next = next.min(size);
            }
            let keeps = rate <= 1e-3;
            h = if keeps && (1.0..=1.2).contains(&(next / size)) {
                size
            } else {
                next.max(if size < h { h } else { 0.0 })
            };
            (has_j, current) = (keeps, false);
            v = [v[0] + z[2][0], v[1] + z[2][1]];
            now += size;
            old = Some((z, size));
            steps += 1;
            break;
        }
    }
    (v, steps)
}
