//! Method I with the residual measured in another metric.

use lsvi::closure::Linear;
use lsvi::discrete::Trapezoidal;
use lsvi::{Jacobian, LeastSquares, OneStep, Variational, VectorField};
use nalgebra::{DMatrix, Matrix2, Vector2};

use super::{Context, Experiment, StudyError};
use crate::problem;

/// A run of Method I in the metric W of the residual, in the plane.
#[derive(Debug)]
pub struct InMetric {
    /// What is integrated.
    pub field: Field,
    /// W.
    pub metric: Matrix2<f64>,
    /// The initial state.
    pub start: Vector2<f64>,
    /// The step size.
    pub h: f64,
    /// The number of steps.
    pub steps: usize,
}

/// A field in the plane.
#[derive(Debug, Clone, Copy)]
pub enum Field {
    /// v̇ = A v.
    Linear(Matrix2<f64>),
    /// A problem.
    Of(&'static str),
}

impl Experiment for InMetric {
    const ID: &'static str = "in-metric";
    /// The state at the end.
    type Found = Vector2<f64>;

    fn measure(&self, _: &Context) -> Result<Vector2<f64>, StudyError> {
        match self.field {
            Field::Linear(a) => self.solve(LinearField(a)),
            Field::Of(name) => self.solve(problem::build_setting(name)?.field()),
        }
    }
}

impl InMetric {
    fn solve(&self, field: impl VectorField) -> Result<Vector2<f64>, StudyError> {
        let metric = DMatrix::from_column_slice(2, 2, self.metric.as_slice());
        let lagrangian = LeastSquares::new(field)?.with_metric(metric)?;
        let mut method = Variational::new(Trapezoidal::new(lagrangian), Linear::METHOD_I);
        let (mut q, mut p): ([f64; 2], _) = (self.start.into(), [0.0; 2]);
        for n in 0..self.steps {
            method.step(n as f64 * self.h, self.h, &mut q, &mut p)?;
        }
        Ok(q.into())
    }
}

/// v̇ = A v.
struct LinearField(Matrix2<f64>);

impl VectorField for LinearField {
    fn dim(&self) -> usize {
        2
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv.copy_from_slice((self.0 * Vector2::new(v[0], v[1])).as_slice());
    }
    fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            out.add(i, j, scale * self.0[(i, j)]);
        }
    }
    fn add_curvature(&self, _t: f64, _v: &[f64], _w: &[f64], _scale: f64, _out: &mut Jacobian) {}
}
