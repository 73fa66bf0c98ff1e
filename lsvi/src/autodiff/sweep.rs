//! Derivatives of small systems, one direction after the other, with all numbers on the stack.
//!
//! The sweeps do not depend on each other, so that their divisions and roots overlap: faster than one sweep with all directions.

use num_dual::Dual64;

/// Calls `f` with each variable j in turn made the one to differentiate by, at `x`.
#[inline(always)]
pub(super) fn each<const N: usize>(x: &[f64], mut f: impl FnMut(usize, &[Dual64; N])) {
    let mut x: [Dual64; N] = std::array::from_fn(|i| Dual64::from(x[i]));
    for j in 0..N {
        x[j].eps = 1.0;
        f(j, &x);
        x[j].eps = 0.0;
    }
}
