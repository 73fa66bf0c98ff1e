//! Generalized forces from one generic definition.

use num_dual::Dual64;

use super::Scalar;
use crate::lagrangian::Force;
use crate::linalg::Jacobian;
use crate::pool::Pool;

/// A generalized force F(t, q, v), written once for every [`Scalar`].
pub trait ForceFn {
    /// Degrees of freedom n.
    fn dim(&self) -> usize;

    /// Writes F(t, q, v) into `out`; all have length [`dim`](Self::dim).
    fn force<T: Scalar>(&self, t: f64, q: &[T], v: &[T], out: &mut [T]);
}

/// Makes a [`Force`] of a [`ForceFn`]: its derivatives in n evaluations of duals each.
#[derive(Debug)]
pub struct AutoForce<F> {
    function: F,
    scratch: Pool<[Vec<Dual64>; 3]>,
}

impl<F: ForceFn> AutoForce<F> {
    /// Wraps `function`.
    pub fn new(function: F) -> Self {
        let n = function.dim();
        Self { function, scratch: Pool::new(move || std::array::from_fn(|_| vec![Dual64::from(0.0); n])) }
    }
}

impl<F: ForceFn> Force for AutoForce<F> {
    fn dim(&self) -> usize {
        self.function.dim()
    }

    fn force(&self, t: f64, q: &[f64], v: &[f64], out: &mut [f64]) {
        self.function.force(t, q, v, out);
    }

    fn add_derivative(&self, t: f64, q: &[f64], v: &[f64], in_q: f64, in_v: f64, out: &mut Jacobian) {
        self.scratch.with(|[dual_q, dual_v, force]| {
            dual_q.iter_mut().zip(q).for_each(|(dual, &x)| *dual = Dual64::from(x));
            dual_v.iter_mut().zip(v).for_each(|(dual, &x)| *dual = Dual64::from(x));
            for j in 0..q.len() {
                dual_q[j].eps = in_q;
                dual_v[j].eps = in_v;
                self.function.force(t, dual_q, dual_v, force);
                dual_q[j].eps = 0.0;
                dual_v[j].eps = 0.0;
                force.iter().enumerate().for_each(|(i, f)| out.add(i, j, f.eps));
            }
        });
    }
}
