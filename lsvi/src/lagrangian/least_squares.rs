//! The least-squares Lagrangian of a first-order system, Eq. (15).

use std::fmt;

use nalgebra::{Cholesky, DMatrix};

use super::{HessianWeights, Lagrangian};
use crate::error::{InputError, SystemError};
use crate::linalg::{Jacobian, Rows, Structure, add_block, add_with_transpose, set_product};
use crate::mass::Mass;
use crate::pool::Pool;
use crate::vector_field::{VectorField, check_system};

/// L(t, v, v̇) = ½ rᵀ W r of the residual r = M v̇ − f, Eq. (15); W = M⁻¹ unless a metric is given.
///
/// Its action is least, and zero, on the solutions of M v̇ = f(t, v), where the conjugate momentum p = M W r vanishes.
/// Another metric is another method: W is part of the statement of the problem. With the natural metric M⁻¹
/// it is L = ½ (v̇ − M⁻¹f)ᵀ M (v̇ − M⁻¹f).
///
/// In the natural metric of a diagonal M the second derivatives follow the [structure](VectorField::structure) of the field;
/// of any other metric, whose inverse fills, they are dense.
#[derive(Debug)]
pub struct LeastSquares<F> {
    field: F,
    weights: Weights,
    scratch: Pool<Scratch>,
}

/// The residual r = M v̇ − f(t, v) and its weights W.
#[derive(Clone, Copy)]
pub struct ResidualForm<'a> {
    pub(crate) field: &'a dyn VectorField,
    pub(crate) mass: &'a Mass,
    weights: &'a Weights,
}

impl fmt::Debug for ResidualForm<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ResidualForm").field("mass", self.mass).finish_non_exhaustive()
    }
}

impl ResidualForm<'_> {
    /// Writes W r.
    pub(crate) fn weigh(&self, r: &[f64], out: &mut [f64]) {
        self.weights.weigh(r, out);
    }
}

/// W, W M and M W M; `None` for the identity.
#[derive(Debug)]
struct Weights {
    mass: Mass,
    w: Option<DMatrix<f64>>,
    wm: Option<DMatrix<f64>>,
    mwm: Option<DMatrix<f64>>,
    /// The rows of J, where J and JᵀWJ are not stored as dense matrices: for W = M⁻¹ diagonal.
    rows: Option<Rows>,
}

impl Weights {
    fn diagonal(&self, i: usize) -> f64 {
        match &self.mass {
            Mass::Diagonal(m) => m[i],
            _ => 1.0,
        }
    }

    /// Writes W r.
    fn weigh(&self, r: &[f64], out: &mut [f64]) {
        match &self.rows {
            Some(_) => out.iter_mut().zip(r).enumerate().for_each(|(i, (o, r))| *o = r / self.diagonal(i)),
            None => mul_transpose(self.w.as_ref(), r, out),
        }
    }
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
    mass.metric(n)?;
    let mut m = Jacobian::zeros(n);
    mass.add_to(1.0, &mut m);
    m.check_structure().map_err(|_| InputError::System(SystemError::NotAssembled))?;
    Ok(m.to_dense())
}

impl<F: VectorField> LeastSquares<F> {
    /// The residual in its natural norm, W = M⁻¹.
    ///
    /// # Errors
    /// [`SystemError::Metric`] or another if M is not symmetric positive definite; [`SystemError::NotAssembled`] if the field is
    /// matrix-free or M an operator.
    pub fn new(field: F) -> Result<Self, InputError> {
        let n = field.dim();
        if field.structure() == Structure::MatrixFree {
            return Err(InputError::System(SystemError::NotAssembled));
        }
        check_system(&field)?;
        let (structure, mass) = (field.structure(), field.mass());
        if structure != Structure::Dense && matches!(mass, Mass::Identity | Mass::Diagonal(_)) {
            mass.metric(n)?;
            let rows = Some(Rows::of(&Jacobian::with_structure(n, &structure)));
            let weights = Weights { mass, w: None, wm: None, mwm: None, rows };
            return Ok(Self { field, weights, scratch: Scratch::pool(n, structure) });
        }
        let weights = match mass {
            Mass::Identity => Weights { mass: Mass::Identity, w: None, wm: None, mwm: None, rows: None },
            mass => {
                let m = dense(&mass, n)?;
                let w = Cholesky::new(m.clone())
                    .ok_or_else(|| InputError::System(SystemError::Metric("it has no Cholesky factor".into())))?;
                Weights { mass, w: Some(w.inverse()), wm: None, mwm: Some(m), rows: None }
            }
        };
        Ok(Self { field, weights, scratch: Scratch::pool(n, Structure::Dense) })
    }

    /// Measures the residual in the metric `w`, an n × n symmetric positive definite matrix.
    ///
    /// # Errors
    /// [`SystemError::Dimension`] or [`SystemError::Metric`] if `w` is not such a matrix.
    pub fn with_metric(self, w: DMatrix<f64>) -> Result<Self, InputError> {
        let n = self.field.dim();
        if let Some(&found) = [w.nrows(), w.ncols()].iter().find(|&&m| m != n) {
            return Err(InputError::System(SystemError::Dimension { what: "metric", expected: n, found }));
        }
        Jacobian::try_from(w.clone())?.cholesky()?;
        let weights = match self.field.mass() {
            Mass::Identity => {
                Weights { mass: Mass::Identity, wm: Some(w.clone()), mwm: Some(w.clone()), w: Some(w), rows: None }
            }
            mass => {
                let m = dense(&mass, n)?;
                let wm = &w * &m;
                Weights { mass, mwm: Some(m.tr_mul(&wm)), wm: Some(wm), w: Some(w), rows: None }
            }
        };
        Ok(Self { weights, scratch: Scratch::pool(n, Structure::Dense), ..self })
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
            for (o, column) in out.iter_mut().zip(a.as_slice().chunks_exact(x.len().max(1))) {
                *o = column.iter().zip(x).map(|(a, x)| a * x).sum();
            }
        }
    }
}

impl Scratch {
    fn pool(n: usize, structure: Structure) -> Pool<Self> {
        let dense = if structure == Structure::Dense { n } else { 0 };
        Pool::new(move || Self {
            residual: vec![0.0; n],
            weighted: vec![0.0; n],
            jacobian: Jacobian::with_structure(n, &structure),
            wj: DMatrix::zeros(dense, dense),
            mwj: DMatrix::zeros(dense, dense),
        })
    }

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

    fn structure(&self) -> Structure {
        match &self.weights.rows {
            Some(_) => self.field.structure().gram(self.dim()),
            None => Structure::Dense,
        }
    }

    fn residual_form(&self) -> Option<ResidualForm<'_>> {
        Some(ResidualForm { field: &self.field, mass: &self.weights.mass, weights: &self.weights })
    }

    fn value(&self, t: f64, v: &[f64], rate: &[f64]) -> f64 {
        self.scratch.with(|s| {
            s.set_residual(&self.field, &self.weights.mass, t, v, rate);
            self.weights.weigh(&s.residual, &mut s.weighted);
            0.5 * s.weighted.iter().zip(&s.residual).map(|(w, r)| w * r).sum::<f64>()
        })
    }

    /// ∂L/∂v = −Jᵀ W r and ∂L/∂v̇ = M W r.
    fn gradient(&self, t: f64, v: &[f64], rate: &[f64], dl_dq: &mut [f64], dl_dv: &mut [f64]) {
        self.scratch.with(|s| {
            s.set_residual(&self.field, &self.weights.mass, t, v, rate);
            self.weights.weigh(&s.residual, &mut s.weighted);
            mul_transpose(self.weights.wm.as_ref(), &s.residual, dl_dv);
            s.set_jacobian(&self.field, t, v);
            match s.jacobian.dense() {
                Some(j) => {
                    mul_transpose(Some(j), &s.weighted, dl_dq);
                    dl_dq.iter_mut().for_each(|x| *x = -*x);
                }
                None => {
                    dl_dq.fill(0.0);
                    s.jacobian.mul_transpose_add(-1.0, &s.weighted, dl_dq);
                }
            }
            if s.jacobian.outside().is_some() {
                // What is missing is told where second derivatives are asked for.
                dl_dq.fill(f64::NAN);
            }
        });
    }

    /// L_vv = JᵀWJ − Σ (Wr)_i ∂²f_i, L_vv̇ = −JᵀWM, L_v̇v = −MWJ, L_v̇v̇ = MWM.
    fn add_hessian(&self, t: f64, v: &[f64], rate: &[f64], c: HessianWeights, out: &mut Jacobian) {
        self.add_mass(c.vv, out);
        if c.qq == 0.0 && c.qv == 0.0 && c.vq == 0.0 {
            return;
        }
        self.scratch.with(|s| {
            s.set_jacobian(&self.field, t, v);
            self.add_products(s, c, out);
            self.add_curvature(s, (t, v, rate), c.qq, out);
        });
    }

    fn add_blocks(&self, t: f64, v: &[f64], rate: &[f64], blocks: [&mut Jacobian; 4]) {
        let [qq, qv, vq, vv] = blocks;
        let none = HessianWeights::default();
        self.add_mass(1.0, vv);
        self.scratch.with(|s| {
            s.set_jacobian(&self.field, t, v);
            self.add_products(s, HessianWeights { qq: 1.0, ..none }, qq);
            self.add_products(s, HessianWeights { qv: 1.0, ..none }, qv);
            self.add_products(s, HessianWeights { vq: 1.0, ..none }, vq);
            self.add_curvature(s, (t, v, rate), 1.0, qq);
        });
    }
}

impl<F: VectorField> LeastSquares<F> {
    /// Adds `scale` L_v̇v̇ = `scale` MWM.
    fn add_mass(&self, scale: f64, out: &mut Jacobian) {
        match &self.weights.mwm {
            _ if scale == 0.0 => {}
            Some(mwm) => add_block(out, (0, 0), scale, mwm),
            // W = M⁻¹.
            None => self.weights.mass.add_to(scale, out),
        }
    }

    /// Adds −`scale` Σ (Wr)_i ∂²f_i.
    fn add_curvature(&self, s: &mut Scratch, (t, v, rate): (f64, &[f64], &[f64]), scale: f64, out: &mut Jacobian) {
        if scale != 0.0 {
            s.set_residual(&self.field, &self.weights.mass, t, v, rate);
            self.weights.weigh(&s.residual, &mut s.weighted);
            self.field.add_curvature(t, v, &s.weighted, -scale, out);
        }
    }

    /// Adds the products of J.
    fn add_products(&self, s: &mut Scratch, c: HessianWeights, out: &mut Jacobian) {
        let Some(rows) = &self.weights.rows else { return self.add_dense_products(s, c, out) };
        let j = &s.jacobian;
        add_with_transpose(-c.vq, -c.qv, j, out);
        if c.qq != 0.0 {
            rows.add_gram(j, |i| c.qq / self.weights.diagonal(i), out);
        }
    }

    /// The products of J as dense matrices.
    fn add_dense_products(&self, s: &mut Scratch, c: HessianWeights, out: &mut Jacobian) {
        let n = self.dim();
        out.inherit_outside(&s.jacobian);
        let j = s.jacobian.dense().expect("dense unless there are rows");
        let mwj = match &self.weights.wm {
            None => j,
            Some(wm) => {
                s.mwj.gemm_tr(1.0, wm, j, 0.0);
                &s.mwj
            }
        };
        if c.vq != 0.0 || c.qv != 0.0 {
            for b in 0..n {
                for a in 0..n {
                    out.add(a, b, -(c.vq * mwj[(a, b)] + c.qv * mwj[(b, a)]));
                }
            }
        }
        if c.qq != 0.0 {
            let wj = match &self.weights.w {
                None => j,
                Some(w) => {
                    set_product(&mut s.wj, w, j);
                    &s.wj
                }
            };
            out.add_product_tr(c.qq, j, wj);
        }
    }
}
