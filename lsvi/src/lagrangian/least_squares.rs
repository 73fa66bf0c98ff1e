//! The least-squares Lagrangian of a first-order system, Eq. (15).

use nalgebra::{Cholesky, DMatrix};

use super::{HessianWeights, Lagrangian};
use crate::error::InputError;
use crate::linalg::{Jacobian, Structure};
use crate::mass::Mass;
use crate::pool::Pool;
use crate::vector_field::VectorField;

/// L(t, v, v̇) = ½ rᵀ W r of the residual r = M v̇ − f, Eq. (15); W = M⁻¹ unless a metric is given.
///
/// Its action is least, and zero, on the solutions of M v̇ = f(t, v), where the conjugate momentum p = M W r vanishes.
/// Another metric is another method: W is part of the statement of the problem. The natural metric M⁻¹ does not depend
/// on how the equations are multiplied by M: with it L = ½ (v̇ − M⁻¹f)ᵀ M (v̇ − M⁻¹f).
#[derive(Debug)]
pub struct LeastSquares<F> {
    field: F,
    weights: Weights,
    scratch: Pool<Scratch>,
}

/// W, W M and M W M; `None` for the identity.
#[derive(Debug)]
struct Weights {
    mass: Mass,
    w: Option<DMatrix<f64>>,
    wm: Option<DMatrix<f64>>,
    mwm: Option<DMatrix<f64>>,
}

#[derive(Debug)]
struct Scratch {
    residual: Vec<f64>,
    /// W r.
    weighted: Vec<f64>,
    jacobian: Jacobian,
    /// W J.
    wj: DMatrix<f64>,
    /// M W J.
    mwj: DMatrix<f64>,
}

/// A symmetric positive definite M as a dense matrix.
fn dense(mass: &Mass, n: usize) -> Result<DMatrix<f64>, InputError> {
    mass.check_metric(n)?;
    let mut m = Jacobian::zeros(n);
    mass.add_to(1.0, &mut m);
    m.check_structure().map_err(|_| InputError::NotAssembled)?;
    Ok(m.to_dense())
}

impl<F: VectorField> LeastSquares<F> {
    /// The residual in its natural norm, W = M⁻¹.
    ///
    /// # Errors
    /// [`InputError::Metric`] or another if M is not symmetric positive definite; [`InputError::NotAssembled`] if the field is
    /// matrix-free or M an operator.
    pub fn new(field: F) -> Result<Self, InputError> {
        let n = field.dim();
        if field.structure() == Structure::MatrixFree {
            return Err(InputError::NotAssembled);
        }
        let scratch = move || Scratch {
            residual: vec![0.0; n],
            weighted: vec![0.0; n],
            jacobian: Jacobian::zeros(n),
            wj: DMatrix::zeros(n, n),
            mwj: DMatrix::zeros(n, n),
        };
        let weights = match field.mass() {
            Mass::Identity => Weights { mass: Mass::Identity, w: None, wm: None, mwm: None },
            mass => {
                let m = dense(&mass, n)?;
                let w =
                    Cholesky::new(m.clone()).ok_or_else(|| InputError::Metric("it has no Cholesky factor".into()))?;
                Weights { mass, w: Some(w.inverse()), wm: None, mwm: Some(m) }
            }
        };
        Ok(Self { field, weights, scratch: Pool::new(scratch) })
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
        Jacobian::from(w.clone()).check_metric()?;
        let weights = match self.field.mass() {
            Mass::Identity => Weights { mass: Mass::Identity, wm: Some(w.clone()), mwm: Some(w.clone()), w: Some(w) },
            mass => {
                let m = dense(&mass, n)?;
                let wm = &w * &m;
                Weights { mass, mwm: Some(m.tr_mul(&wm)), wm: Some(wm), w: Some(w) }
            }
        };
        Ok(Self { weights, ..self })
    }

    /// The field f.
    pub fn field(&self) -> &F {
        &self.field
    }
}

/// Writes Aᵀ x into `out`, A = I if it is not given.
fn mul_transpose(a: Option<&DMatrix<f64>>, x: &[f64], out: &mut [f64]) {
    match a {
        None => out.copy_from_slice(x),
        Some(a) => {
            for (o, column) in out.iter_mut().zip(a.column_iter()) {
                *o = column.iter().zip(x).map(|(a, x)| a * x).sum();
            }
        }
    }
}

impl Scratch {
    /// Sets r = M v̇ − f(t, v).
    fn set_residual<F: VectorField>(&mut self, field: &F, mass: &Mass, t: f64, v: &[f64], rate: &[f64]) {
        field.rhs(t, v, &mut self.residual);
        self.residual.iter_mut().for_each(|r| *r = -*r);
        mass.mul_add(1.0, rate, &mut self.residual);
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
        self.scratch.with(|s| {
            s.set_residual(&self.field, &self.weights.mass, t, v, rate);
            mul_transpose(self.weights.w.as_ref(), &s.residual, &mut s.weighted);
            0.5 * s.weighted.iter().zip(&s.residual).map(|(w, r)| w * r).sum::<f64>()
        })
    }

    /// ∂L/∂v = −Jᵀ W r and ∂L/∂v̇ = M W r.
    fn gradient(&self, t: f64, v: &[f64], rate: &[f64], dl_dq: &mut [f64], dl_dv: &mut [f64]) {
        self.scratch.with(|s| {
            s.set_residual(&self.field, &self.weights.mass, t, v, rate);
            mul_transpose(self.weights.w.as_ref(), &s.residual, &mut s.weighted);
            mul_transpose(self.weights.wm.as_ref(), &s.residual, dl_dv);
            s.set_jacobian(&self.field, t, v);
            mul_transpose(Some(s.jacobian.as_dense()), &s.weighted, dl_dq);
            dl_dq.iter_mut().for_each(|x| *x = -*x);
        });
    }

    /// L_vv = JᵀWJ − Σ (Wr)_i ∂²f_i, L_vv̇ = −JᵀWM, L_v̇v = −MWJ, L_v̇v̇ = MWM.
    fn add_hessian(&self, t: f64, v: &[f64], rate: &[f64], c: HessianWeights, out: &mut Jacobian) {
        self.scratch.with(|s| self.add_hessian_with(s, (t, v, rate), c, out));
    }
}

impl<F: VectorField> LeastSquares<F> {
    fn add_hessian_with(
        &self,
        s: &mut Scratch,
        (t, v, rate): (f64, &[f64], &[f64]),
        c: HessianWeights,
        out: &mut Jacobian,
    ) {
        let n = self.dim();
        s.set_jacobian(&self.field, t, v);
        let j = s.jacobian.as_dense();
        let mwj = match &self.weights.wm {
            None => j,
            Some(wm) => {
                s.mwj.gemm_tr(1.0, wm, j, 0.0);
                &s.mwj
            }
        };
        let h = out.as_dense_mut();
        match &self.weights.mwm {
            Some(mwm) if c.vv != 0.0 => h.zip_apply(mwm, |o, x| *o += c.vv * x),
            None if c.vv != 0.0 => (0..n).for_each(|i| h[(i, i)] += c.vv),
            _ => {}
        }
        for a in 0..n {
            for b in 0..n {
                h[(a, b)] -= c.vq * mwj[(a, b)] + c.qv * mwj[(b, a)];
            }
        }
        if c.qq != 0.0 {
            let wj = match &self.weights.w {
                None => j,
                Some(w) => {
                    s.wj.gemm(1.0, w, j, 0.0);
                    &s.wj
                }
            };
            h.gemm_tr(c.qq, j, wj, 1.0);
            s.set_residual(&self.field, &self.weights.mass, t, v, rate);
            mul_transpose(self.weights.w.as_ref(), &s.residual, &mut s.weighted);
            self.field.add_curvature(t, v, &s.weighted, -c.qq, out);
        }
    }
}
