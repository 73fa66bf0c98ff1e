//! Derivatives of small systems, one direction after the other, with all numbers on the stack.
//!
//! The sweeps do not depend on each other, so that their divisions and roots overlap: faster than one sweep with all directions.

use num_dual::Dual64;

/// The derivatives of `f` along each of its variables, at `x`.
#[inline]
pub(super) fn each<const N: usize, R: Copy>(x: &[f64], f: impl Fn(&[Dual64; N]) -> R) -> [R; N] {
    let x: [Dual64; N] = std::array::from_fn(|i| Dual64::from(x[i]));
    std::array::from_fn(|j| {
        let mut x = x;
        x[j].eps = 1.0;
        f(&x)
    })
}
