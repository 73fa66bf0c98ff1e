//! Condition estimates.

/// Hager and Higham's estimate of ‖A⁻¹‖₁ for a symmetric matrix of order `work[0].len()`, from a few solves with it.
///
/// A lower bound, in practice within a factor of three. The two work vectors have the order of the matrix.
pub(crate) fn inverse_norm(mut solve: impl FnMut(&mut [f64]), work: &mut [Vec<f64>; 2]) -> f64 {
    let [x, z] = work;
    let n = x.len();
    let norm = |v: &[f64]| v.iter().map(|x| x.abs()).sum::<f64>();
    x.fill(1.0 / n as f64);
    let mut estimate = 0.0;
    for _ in 0..5 {
        solve(x);
        let next = norm(x);
        if next <= estimate {
            break;
        }
        estimate = next;
        for (z, x) in z.iter_mut().zip(x.iter()) {
            *z = x.signum();
        }
        solve(z);
        let Some(largest) = (0..n).max_by(|&i, &j| z[i].abs().total_cmp(&z[j].abs())) else { break };
        x.fill(0.0);
        x[largest] = 1.0;
    }
    // Higham's alternating vector catches cancellation in the above.
    for (i, x) in x.iter_mut().enumerate() {
        let size = 1.0 + i as f64 / (n.max(2) - 1) as f64;
        *x = if i % 2 == 0 { size } else { -size };
    }
    solve(x);
    estimate.max(2.0 * norm(x) / (3.0 * n as f64))
}
