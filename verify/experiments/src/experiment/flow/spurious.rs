//! Where Method I rests although the flow does not.

use faer::Mat;
use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};
use lsvi::nalgebra::{DMatrix, DVector};
use lsvi::steady::{self, Steady, SteadyError};
use lsvi::{Jacobian, Mass, OneStep, SolveError, StepError, VectorField};

use super::cavity;
use super::steady::{STEADY, march, method_i};
use crate::experiment::{Context, Experiment, StudyError};
use crate::measure::norm::{Extremes, distance, max_norm};
use crate::problem::Problem;

/// Method I from rest with steps far too long for a coarse grid.
#[derive(Debug)]
pub struct Spurious {
    /// Reynolds number.
    pub re: f64,
    /// Cells along a side.
    pub cells: usize,
    /// Step size.
    pub h: f64,
}

/// Where it rests.
#[derive(Debug)]
pub struct Refused {
    /// Max norm of f in units of M ψ̇.
    pub residual: f64,
    /// ψ there, where it is known.
    pub psi: Option<Vec<f64>>,
    /// The gradient of the action over that at rest, where the iteration stalls.
    pub gradient: Option<f64>,
    /// What the library says; nothing if it takes it for steady.
    pub message: String,
}

/// The state next to where that ends at which Method I rests.
#[derive(Debug)]
pub struct RestingState(pub Spurious);

/// A root of (2M − hJᵀ)w = 0, Mw = f.
#[derive(Debug)]
pub struct Root {
    /// Stream function.
    pub psi: Vec<f64>,
    /// Max norm of f in units of M ψ̇.
    pub residual: f64,
    /// What is left of the equation, over the sum of the sizes of its terms.
    pub imbalance: f64,
    /// Max norm of what one step of Method I changes of ψ.
    pub change: f64,
    /// What the library says of it; nothing if it takes it for steady.
    pub message: String,
}

impl Experiment for Spurious {
    const ID: &'static str = "spurious-steady-cavity";
    type Found = Refused;

    fn measure(&self, context: &Context) -> Result<Refused, StudyError> {
        context.announce(1);
        let problem = cavity(self.re, self.cells)?;
        let found = match march(&*problem, problem.initial(), self.h) {
            Err(error) => {
                let message = error.to_string();
                let (residual, psi, gradient) = match error {
                    SteadyError::Spurious { residual, v, .. } => (residual, Some(v), None),
                    SteadyError::NotReached { residual, .. } => (residual, None, None),
                    SteadyError::Step(StepError::Solve {
                        source: SolveError::Stalled { rate, gradient, v, .. },
                        ..
                    }) => (rate, Some(v.into_vec()), Some(gradient)),
                    other => return Err(other.into()),
                };
                Refused { residual, psi, gradient, message }
            }
            Ok(Steady { residual, state, .. }) => {
                Refused { residual, psi: Some(state.q), gradient: None, message: String::new() }
            }
        };
        context.tick();
        Ok(found)
    }
}

impl Experiment for RestingState {
    const ID: &'static str = "resting-state-of-method-i";
    type Found = Option<Root>;

    fn measure(&self, context: &Context) -> Result<Option<Root>, StudyError> {
        let Self(Spurious { re, cells, h }) = *self;
        let stalled = context.get(Spurious { re, cells, h })?;
        let problem = cavity(re, cells)?;
        stalled.psi.as_ref().map_or(Ok(None), |psi| root(&*problem, h, psi))
    }
}

/// Newton steps to a root, which converge within five or so from close by.
const ITERATIONS: usize = 20;

/// The resting state of Method I next to `psi`, if Newton's method finds one.
fn root(problem: &dyn Problem, h: f64, psi: &[f64]) -> Result<Option<Root>, StudyError> {
    let field = problem.field();
    let Mass::Matrix(mass) = field.mass() else { return Err("a flow between walls has a mass matrix".into()) };
    let equation = Resting { field: &*field, mass: mass.to_dense(), h };
    let mut v = DVector::from_column_slice(psi);
    let mut w = equation.mass.clone().cholesky().ok_or("M is not definite")?.solve(&equation.f(&v));
    let mut changes = Vec::new();
    // Until rounding is what still changes ψ.
    while changes.last().is_none_or(|change| *change > 1e-12 * v.amax()) {
        if changes.len() == ITERATIONS || !v.amax().is_finite() {
            return Ok(None);
        }
        changes.push(equation.newton(&mut v, &mut w)?);
    }
    let psi = v.as_slice().to_vec();
    let (mut after, mut p) = (psi.clone(), vec![0.0; psi.len()]);
    method_i(problem, &field)?.step(0.0, h, &mut after, &mut p)?;
    let change = distance(&after, &psi);
    let message = steady::check(&field, 0.0, &psi, STEADY).map_or_else(|error| error.to_string(), |_| String::new());
    let residual = max_norm(equation.f(&v).as_slice());
    Ok(Some(Root { residual, imbalance: equation.imbalance(&v, &w), change, message, psi }))
}

/// M w = f(v) and (2M/h − Jᵀ) w = 0.
struct Resting<'a> {
    field: &'a dyn VectorField,
    mass: DMatrix<f64>,
    h: f64,
}

impl Resting<'_> {
    fn f(&self, v: &DVector<f64>) -> DVector<f64> {
        let mut f = DVector::zeros(v.len());
        self.field.rhs(0.0, v.as_slice(), f.as_mut_slice());
        f
    }

    /// What `add` adds to a matrix of the field's structure.
    fn assembled(&self, add: impl FnOnce(&mut Jacobian)) -> DMatrix<f64> {
        let mut matrix = Jacobian::with_structure(self.mass.nrows(), &self.field.structure());
        matrix.clear();
        add(&mut matrix);
        matrix.to_dense()
    }

    fn jacobian(&self, v: &DVector<f64>) -> DMatrix<f64> {
        self.assembled(|out| self.field.add_jacobian(0.0, v.as_slice(), 1.0, out))
    }

    /// A step of Newton's method; the max norm of what it changes of v.
    fn newton(&self, v: &mut DVector<f64>, w: &mut DVector<f64>) -> Result<f64, StudyError> {
        let (n, jacobian) = (v.len(), self.jacobian(v));
        let curvature = self.assembled(|out| self.field.add_curvature(0.0, v.as_slice(), w.as_slice(), 1.0, out));
        let adjoint = &self.mass * (2.0 / self.h) - jacobian.transpose();
        let mut entries = Vec::new();
        for ((row, column), block, sign) in
            [((0, 0), &self.mass, 1.0), ((0, n), &jacobian, -1.0), ((n, 0), &adjoint, 1.0), ((n, n), &curvature, -1.0)]
        {
            for (j, values) in block.column_iter().enumerate() {
                let present = values.iter().enumerate().filter(|(_, x)| **x != 0.0);
                entries.extend(present.map(|(i, x)| Triplet::new(row + i, column + j, sign * x)));
            }
        }
        let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(2 * n, 2 * n, &entries)?;
        let (first, second) = (&self.mass * &*w - self.f(v), adjoint * &*w);
        let residual = Mat::from_fn(2 * n, 1, |i, _| if i < n { first[i] } else { second[i - n] });
        let step = matrix.sp_lu()?.solve(&residual);
        for i in 0..n {
            w[i] -= step[(i, 0)];
            v[i] -= step[(n + i, 0)];
        }
        Ok((n..2 * n).map(|i| step[(i, 0)].abs()).largest())
    }

    fn imbalance(&self, v: &DVector<f64>, w: &DVector<f64>) -> f64 {
        let (mass, transposed) = (&self.mass * (2.0 / self.h), self.jacobian(v).transpose());
        let terms = mass.abs() * w.abs() + transposed.abs() * w.abs();
        ((mass - transposed) * w).amax() / terms.amax()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn method_i_rests_where_the_flow_is_unstable_by_the_rate_two_over_h() {
        let h = 1e3;
        let setting = RestingState(Spurious { re: 5000.0, cells: 8, h });
        let root = setting.measure(&Context::quick()).expect("measured").expect("there is one");
        assert!(root.imbalance <= 64.0 * f64::EPSILON, "{}", root.imbalance);
        assert!(root.residual > 1e-5 && root.message.starts_with("spurious steady state"), "{root:?}");
        let largest = max_norm(&root.psi);
        assert!(root.change <= 1e-3 * largest, "{} of {largest}", root.change);
        // (2M/h − Jᵀ)w = 0 says that M⁻¹J has the eigenvalue 2/h.
        let problem = cavity(5000.0, 8).expect("known");
        let field = problem.field();
        let Mass::Matrix(mass) = field.mass() else { panic!("a mass matrix") };
        let equation = Resting { field: &*field, mass: mass.to_dense(), h };
        let jacobian = equation.jacobian(&DVector::from_vec(root.psi));
        let rates = equation.mass.lu().solve(&jacobian).expect("M is regular").complex_eigenvalues();
        let nearest = rates.iter().map(|rate| (rate - 2.0 / h).norm()).smallest();
        assert!(nearest <= 1e-9, "{nearest}: {rates}");
    }

    #[test]
    fn a_steady_flow_is_no_spurious_state() {
        let root =
            RestingState(Spurious { re: 100.0, cells: 8, h: 100.0 }).measure(&Context::quick()).expect("measured");
        assert!(root.is_none_or(|root| root.message.is_empty()));
    }
}
