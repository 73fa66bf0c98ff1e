//! The least-squares Lagrangian of a first-order system, Eq. (15).

use std::cell::RefCell;

use nalgebra::{Cholesky, DMatrix};

use super::{HessianWeights, Lagrangian};
use crate::error::InputError;
use crate::linalg::Jacobian;
use crate::vector_field::VectorField;

/// L(t, v, v̇) = ½ (v̇ − f)ᵀ W (v̇ − f), Eq. (15); W = I unless a metric is given.
///
/// Its action is least, and zero, on the solutions of v̇ = f(t, v), where the conjugate momentum p = W (v̇ − f) vanishes.
/// Another metric is another method: W is part of the statement of the problem.
#[derive(Debug)]
pub struct LeastSquares<F> {
    field: F,
    metric: Option<DMatrix<f64>>,
    scratch: RefCell<Scratch>,
}

#[derive(Debug)]
struct Scratch {
    residual: Vec<f64>,
    weighted_residual: Vec<f64>,
    jacobian: Jacobian,
    weighted: DMatrix<f64>,
}

impl<F: VectorField> LeastSquares<F> {
    /// The Euclidean residual norm, W = I.
    pub fn new(field: F) -> Self {
        let n = field.dim();
        let scratch = Scratch {
            residual: vec![0.0; n],
            weighted_residual: vec![0.0; n],
            jacobian: Jacobian::zeros(n),
            weighted: DMatrix::zeros(n, n),
        };
        Self { field, metric: None, scratch: RefCell::new(scratch) }
    }

    /// Measures the residual in the metric `w`, an n × n symmetric positive definite matrix.
    ///
    /// # Errors
    /// [`InputError::Dimension`] or [`InputError::Metric`] if `w` is not such a matrix.
    pub fn with_metric(self, w: DMatrix<f64>) -> Result<Self, InputError> {
        let n = self.field.dim();
        if let Some(&found) = [w.nrows(), w.ncols()].iter().find(|&&m| m != n) {
            return Err(InputError::Dimension { what: "metric", expected: n, found });
        }
        for j in 0..n {
            for i in 0..=j {
                let (a, b) = (w[(i, j)], w[(j, i)]);
                // Symmetric to rounding: a product such as M⁻¹ need not be so to the last bit.
                let tolerance = 8.0 * f64::EPSILON * (w[(i, i)].abs() + w[(j, j)].abs());
                if !a.is_finite() || !b.is_finite() || (a - b).abs() > tolerance {
                    return Err(InputError::Metric(format!("entries ({i}, {j}) are {a} and {b}")));
                }
            }
        }
        if Cholesky::new(w.clone()).is_none() {
            return Err(InputError::Metric("it has no Cholesky factor".into()));
        }
        Ok(Self { metric: Some(w), ..self })
    }

    /// The field f.
    pub fn field(&self) -> &F {
        &self.field
    }
}

impl Scratch {
    /// Writes W (v̇ − f(t, v)) into `out`.
    fn momentum<F: VectorField>(
        &mut self,
        of: (&F, &Option<DMatrix<f64>>),
        t: f64,
        v: &[f64],
        rate: &[f64],
        out: &mut [f64],
    ) {
        let (field, metric) = of;
        field.rhs(t, v, &mut self.residual);
        for (r, d) in self.residual.iter_mut().zip(rate) {
            *r = d - *r;
        }
        match metric {
            None => out.copy_from_slice(&self.residual),
            Some(w) => {
                out.fill(0.0);
                for (column, r) in w.column_iter().zip(&self.residual) {
                    for (o, x) in out.iter_mut().zip(column.iter()) {
                        *o += x * r;
                    }
                }
            }
        }
    }

    fn set_jacobian<F: VectorField>(&mut self, field: &F, t: f64, v: &[f64]) {
        self.jacobian.clear();
        field.add_jacobian(t, v, 1.0, &mut self.jacobian);
    }
}

impl<F: VectorField> Lagrangian for LeastSquares<F> {
    fn dim(&self) -> usize {
        self.field.dim()
    }

    fn value(&self, t: f64, v: &[f64], rate: &[f64]) -> f64 {
        let mut p = vec![0.0; self.dim()];
        let scratch = &mut *self.scratch.borrow_mut();
        scratch.momentum((&self.field, &self.metric), t, v, rate, &mut p);
        0.5 * p.iter().zip(&scratch.residual).map(|(p, r)| p * r).sum::<f64>()
    }

    /// ∂L/∂v = −Jᵀ W r and ∂L/∂v̇ = W r.
    fn gradient(&self, t: f64, v: &[f64], rate: &[f64], dl_dq: &mut [f64], dl_dv: &mut [f64]) {
        let scratch = &mut *self.scratch.borrow_mut();
        scratch.momentum((&self.field, &self.metric), t, v, rate, dl_dv);
        scratch.set_jacobian(&self.field, t, v);
        for (out, column) in dl_dq.iter_mut().zip(scratch.jacobian.as_dense().column_iter()) {
            *out = -column.iter().zip(dl_dv.iter()).map(|(j, p)| j * p).sum::<f64>();
        }
    }

    /// L_vv = JᵀWJ − Σ (Wr)_i ∂²f_i, L_vv̇ = −JᵀW, L_v̇v = −WJ, L_v̇v̇ = W.
    fn add_hessian(&self, t: f64, v: &[f64], rate: &[f64], c: HessianWeights, out: &mut Jacobian) {
        let n = self.dim();
        let scratch = &mut *self.scratch.borrow_mut();
        scratch.set_jacobian(&self.field, t, v);
        let j = scratch.jacobian.as_dense();
        let wj = match &self.metric {
            None => j,
            Some(w) => {
                scratch.weighted.gemm(1.0, w, j, 0.0);
                &scratch.weighted
            }
        };
        let h = out.as_dense_mut();
        match &self.metric {
            Some(w) if c.vv != 0.0 => h.zip_apply(w, |o, w| *o += c.vv * w),
            None if c.vv != 0.0 => (0..n).for_each(|i| h[(i, i)] += c.vv),
            _ => {}
        }
        for a in 0..n {
            for b in 0..n {
                h[(a, b)] -= c.vq * wj[(a, b)] + c.qv * wj[(b, a)];
            }
        }
        if c.qq != 0.0 {
            h.gemm_tr(c.qq, j, wj, 1.0);
            let mut p = std::mem::take(&mut scratch.weighted_residual);
            scratch.momentum((&self.field, &self.metric), t, v, rate, &mut p);
            self.field.add_curvature(t, v, &p, -c.qq, out);
            scratch.weighted_residual = p;
        }
    }
}
