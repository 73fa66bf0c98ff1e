//! The flow on the periodic square once more, for the references: the convolution sum over pairs of modes.
//!
//! ω̇_k = −(ν|k|² + iU·k) ω_k − Σ_{p+q=k} (p_x q_y − p_y q_x)/|p|² ω_p ω_q, with the coefficients of both signs written out.

use nalgebra::Complex;

use super::fourier::{Wave, add, complex};

/// The largest wave number of `points` grid points, K < n/3.
fn largest(points: usize) -> i32 {
    (points as i32 - 1) / 3
}

/// The wave numbers that carry the unknowns.
fn waves(points: usize) -> Vec<Wave> {
    let most = largest(points);
    let all = (0..=most).flat_map(|k| (-most..=most).map(move |l| [k, l]));
    all.filter(|[k, l]| *k > 0 || *l > 0).collect()
}

/// The place of a wave number among [`waves`].
fn place(points: usize, [k, l]: Wave) -> Option<usize> {
    let most = largest(points);
    let inside = k.abs() <= most && l.abs() <= most && (k > 0 || k == 0 && l > 0);
    inside.then(|| (k * (2 * most + 1) + l - 1) as usize)
}

/// Of u_p·∇ω_q: u_p = (ip_y, −ip_x) ω_p/|p|² and ∇ω_q = iq ω_q, so that the product is (p_x q_y − p_y q_x) ω_p ω_q/|p|².
fn weight(p: Wave, q: Wave) -> f64 {
    f64::from(p[0] * q[1] - p[1] * q[0]) / f64::from(p[0] * p[0] + p[1] * p[1])
}

/// All coefficients, of both signs.
fn spectrum(points: usize, v: &[f64]) -> Vec<(Wave, Complex<f64>)> {
    let half = waves(points);
    let plus = half.iter().enumerate().map(|(m, wave)| (*wave, complex(v, m)));
    let minus = half.iter().enumerate().map(|(m, [k, l])| ([-k, -l], complex(v, m).conj()));
    plus.chain(minus).collect()
}

/// The bilinear form Σ_{p+q=k} weight(p, q) a_p b_q at every k.
fn convolve(points: usize, a: &[f64], b: &[f64], out: &mut [f64]) {
    let (a, b) = (spectrum(points, a), spectrum(points, b));
    for (p, x) in &a {
        for (q, y) in &b {
            let k = [p[0] + q[0], p[1] + q[1]];
            if let Some(m) = place(points, k) {
                add(out, m, x * y * weight(*p, *q));
            }
        }
    }
}

fn decay(nu: f64, mean: [f64; 2], points: usize, v: &[f64], out: &mut [f64]) {
    for (m, [k, l]) in waves(points).into_iter().map(|wave| wave.map(f64::from)).enumerate() {
        add(out, m, complex(v, m) * Complex::new(-nu * (k * k + l * l), -mean[0] * k - mean[1] * l));
    }
}

/// ω̇.
pub(super) fn rhs(nu: f64, mean: [f64; 2], points: usize, v: &[f64], out: &mut [f64]) {
    out.fill(0.0);
    convolve(points, v, v, out);
    out.iter_mut().for_each(|x| *x = -*x);
    decay(nu, mean, points, v, out);
}

/// Its derivatives, by the bilinear form on unit vectors.
pub(super) fn jacobian(nu: f64, mean: [f64; 2], points: usize, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
    let n = v.len();
    let (mut unit, mut column, mut linear) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    for j in 0..n {
        unit[j] = 1.0;
        column.fill(0.0);
        linear.fill(0.0);
        convolve(points, v, &unit, &mut column);
        convolve(points, &unit, v, &mut column);
        decay(nu, mean, points, &unit, &mut linear);
        for (i, (c, d)) in column.iter().zip(&linear).enumerate() {
            add(i, j, d - c);
        }
        unit[j] = 0.0;
    }
}
