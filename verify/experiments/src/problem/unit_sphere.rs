//! The constraint |q|² = 1.

use lsvi::{ConstraintFn, Scalar};

/// f(q) = |q|² − 1 in n dimensions; its multiplier λ enters the equations of motion as q̈ = … − 2λq ([KY21] 3.3).
#[derive(Debug, Clone, Copy)]
pub(super) struct UnitSphere {
    pub(super) dim: usize,
}

impl ConstraintFn for UnitSphere {
    fn dim(&self) -> usize {
        self.dim
    }
    fn count(&self) -> usize {
        1
    }
    fn constraint<T: Scalar>(&self, q: &[T], out: &mut [T]) {
        out[0] = q.iter().map(|&x| x * x).sum::<T>() - 1.0;
    }
}
