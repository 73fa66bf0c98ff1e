//! Mass matrices M of systems M v̇ = f(t, v).

use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use crate::error::{InputError, SystemError, check_length, check_vector};
use crate::integrator::State;
use crate::linalg::{Cholesky, Entry, FactorError, Jacobian, Lu};
use crate::operator::check_product;
use crate::pool::Pool;
use crate::vector_field::VectorField;

/// The constant matrix M of a system M v̇ = f(t, v).
///
/// Implicit methods take a singular M, which makes some equations algebraic, of index 1. Of index 2, as of velocities that are constrained,
/// some find no solution, and the tolerances of [`Radau`](crate::adaptive::Radau) may call for steps of no size. Explicit stages need its inverse, and
/// least-squares methods need it symmetric positive definite, because they measure the residual M v̇ − f in M⁻¹.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub enum Mass {
    /// M = I.
    #[default]
    Identity,
    /// A diagonal M of length n.
    Diagonal(Vec<f64>),
    /// Any M of order n, its entries within the [`structure`](crate::VectorField::structure) of the field.
    Matrix(Jacobian),
    /// M by what it does to vectors, made by [`Mass::operator`]: for the iterative solution of steps.
    Operator(SharedMass),
}

/// A symmetric positive definite M that is known by its products and its own solver, as a discrete Laplacian CᵀC.
pub trait MassOperator: fmt::Debug + Send + Sync {
    /// Order n.
    fn dim(&self) -> usize;

    /// Writes M x.
    fn apply(&self, x: &[f64], out: &mut [f64]);

    /// Overwrites `b` with M⁻¹ b.
    fn solve(&self, b: &mut [f64]);
}

/// A [`MassOperator`] with the work space of its products.
#[derive(Debug, Clone)]
pub struct SharedMass {
    operator: Arc<dyn MassOperator>,
    /// An argument and a product.
    scratch: Arc<Pool<[Vec<f64>; 2]>>,
}

impl SharedMass {
    /// Adds `scale` M d to `out`, d_i = `argument`(i).
    fn add_product(&self, scale: f64, argument: impl Fn(usize) -> f64, out: &mut [f64]) {
        self.scratch.with(|[x, product]| {
            x.iter_mut().enumerate().for_each(|(i, x)| *x = argument(i));
            self.operator.apply(x, product);
            out.iter_mut().zip(product).for_each(|(o, p)| *o += scale * *p);
        });
    }
}

impl Mass {
    /// M by its products and its own solver. Its field is then matrix-free, whatever structure it declares, and should
    /// [give its products](crate::VectorField::apply_jacobian).
    pub fn operator(operator: impl MassOperator + 'static) -> Self {
        let n = operator.dim();
        let scratch = Arc::new(Pool::new(move || [vec![0.0; n], vec![0.0; n]]));
        Self::Operator(SharedMass { operator: Arc::new(operator), scratch })
    }

    /// Writes M x.
    ///
    /// # Errors
    /// [`SystemError::Dimension`] unless x and out have the order of M, which the identity takes from x.
    pub fn apply(&self, x: &[f64], out: &mut [f64]) -> Result<(), InputError> {
        let order = match self {
            Self::Identity => x.len(),
            Self::Diagonal(m) => m.len(),
            Self::Matrix(m) => m.dim(),
            Self::Operator(m) => m.operator.dim(),
        };
        check_product(order, x, out)?;
        self.multiply(x, out);
        Ok(())
    }

    /// [`apply`](Self::apply) to vectors that fit.
    pub(crate) fn multiply(&self, x: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        self.mul_add(1.0, x, out);
    }

    /// Refuses a matrix of another order or with entries outside its own structure.
    pub(crate) fn check(&self, dim: usize) -> Result<(), InputError> {
        match self {
            Self::Identity => Ok(()),
            Self::Diagonal(m) => check_vector("mass", m, dim),
            Self::Matrix(m) if m.dim() != dim => {
                Err(InputError::System(SystemError::Dimension { what: "mass", expected: dim, found: m.dim() }))
            }
            Self::Matrix(m) => match m.outside() {
                Some((row, column)) => Err(InputError::System(SystemError::OutsideStructure { row, column })),
                None => m.non_finite().map_or(Ok(()), |(row, column)| {
                    Err(InputError::System(SystemError::NonFiniteEntry { what: "mass matrix", row, column }))
                }),
            },
            Self::Operator(m) if m.operator.dim() != dim => {
                Err(InputError::System(SystemError::Dimension { what: "mass", expected: dim, found: m.operator.dim() }))
            }
            Self::Operator(_) => Ok(()),
        }
    }

    /// Refuses a matrix with an entry where `a`, of the same order, has none, and one without entries.
    pub(crate) fn check_within(&self, a: &Jacobian) -> Result<(), InputError> {
        let mut union = a.clone();
        self.add_to(1.0, &mut union);
        union.check_structure().map_err(|error| match error {
            FactorError::OutsideStructure { row, column } => {
                InputError::System(SystemError::OutsideStructure { row, column })
            }
            _ => InputError::System(SystemError::NotAssembled),
        })
    }

    /// The factors of a matrix that is a metric, of order `dim`; refuses one that is not symmetric positive definite.
    pub(crate) fn metric(&self, dim: usize) -> Result<MassInverse, InputError> {
        self.check(dim)?;
        match self {
            Self::Diagonal(m) => match m.iter().position(|&m| m <= 0.0) {
                Some(i) => Err(InputError::System(SystemError::Metric(format!("entry ({i}, {i}) is {}", m[i])))),
                None => MassInverse::new(self),
            },
            Self::Matrix(m) => Ok(MassInverse::Cholesky(Box::new(m.cholesky()?))),
            // Of an operator its author promises it.
            Self::Identity | Self::Operator(_) => MassInverse::new(self),
        }
    }

    /// The rows of M, of order `dim`, that are zero: their equations are algebraic.
    pub(crate) fn zero_rows(&self, dim: usize) -> Vec<usize> {
        let mut is_zero = vec![!matches!(self, Self::Operator(_)); dim];
        self.for_each(dim, |i, _, m| is_zero[i] &= m == 0.0);
        (0..dim).filter(|&i| is_zero[i]).collect()
    }

    /// Adds `scale` M to `out`.
    pub(crate) fn add_to(&self, scale: f64, out: &mut Jacobian) {
        match self {
            Self::Operator(_) => out.set_missing(),
            Self::Matrix(m) => out.add_scaled(scale, m),
            _ => self.for_each(out.dim(), |i, j, m| out.add(i, j, scale * m)),
        }
    }

    /// Adds `scale` M (x − y) to `out`.
    pub(crate) fn add_difference(&self, scale: f64, x: &[f64], y: &[f64], out: &mut [f64]) {
        match self {
            Self::Identity => {
                for ((o, x), y) in out.iter_mut().zip(x).zip(y) {
                    *o += scale * (x - y);
                }
            }
            Self::Operator(m) => m.add_product(scale, |i| x[i] - y[i], out),
            _ => self.for_each(out.len(), |i, j, m| out[i] += scale * m * (x[j] - y[j])),
        }
    }

    /// Adds `scale` M x to `out`.
    #[inline(always)]
    pub(crate) fn mul_add(&self, scale: f64, x: &[f64], out: &mut [f64]) {
        match self {
            Self::Identity => out.iter_mut().zip(x).for_each(|(o, x)| *o += scale * x),
            _ => self.add_product(scale, x, out),
        }
    }

    /// [`mul_add`](Self::mul_add) of an M that is not the identity; apart, so that loops with that are short.
    fn add_product(&self, scale: f64, x: &[f64], out: &mut [f64]) {
        match self {
            Self::Operator(m) => m.add_product(scale, |i| x[i], out),
            _ => self.for_each(out.len(), |i, j, m| out[i] += scale * m * x[j]),
        }
    }

    /// Shows every entry (i, j, m) of M, of order `dim`, to `visit`; of an operator none is known.
    #[inline]
    pub(crate) fn for_each(&self, dim: usize, mut visit: impl FnMut(usize, usize, f64)) {
        match self {
            Self::Identity => (0..dim).for_each(|i| visit(i, i, 1.0)),
            Self::Diagonal(m) => m.iter().enumerate().for_each(|(i, &m)| visit(i, i, m)),
            Self::Matrix(m) => m.for_each(visit),
            Self::Operator(_) => {}
        }
    }

    /// Adds `scale` M, of order `dim`, to a matrix that was assigned.
    pub(crate) fn shift<T: Entry>(&self, dim: usize, scale: T, lu: &mut Lu<T>) {
        match self {
            Self::Identity => lu.shift(dim, scale),
            _ => self.for_each(dim, |i, j, m| lu.add(i, j, scale * T::from(m))),
        }
    }
}

/// Writes v̇ = M⁻¹ f(t, v), NaN for components that a singular M leaves without a rate. It allocates where M is not the
/// identity.
pub(crate) fn rate(field: &dyn VectorField, mass: &Mass, state: &State, out: &mut [f64]) -> Result<(), InputError> {
    check_vector("v", &state.q, field.dim())?;
    check_length("out", out.len(), field.dim())?;
    field.rhs(state.t, &state.q, out);
    check_vector("f(t, v)", out, field.dim())?;
    match (MassInverse::new(mass), mass) {
        (Ok(inverse), _) => inverse.solve(out),
        (Err(_), Mass::Diagonal(m)) => {
            out.iter_mut().zip(m).for_each(|(f, m)| *f = if *m == 0.0 { f64::NAN } else { *f / m });
        }
        (Err(_), _) => out.fill(f64::NAN),
    }
    Ok(())
}

/// The factors of a mass matrix.
#[derive(Debug)]
pub(crate) enum MassInverse {
    Identity,
    Reciprocals(Vec<f64>),
    /// Of a metric.
    Cholesky(Box<Cholesky>),
    /// Of any other matrix, with the work space of the factors.
    Factors(Box<Mutex<Lu>>),
    Operator(SharedMass),
}

impl MassInverse {
    pub(crate) fn new(mass: &Mass) -> Result<Self, InputError> {
        Ok(match mass {
            Mass::Identity => Self::Identity,
            Mass::Diagonal(m) if m.contains(&0.0) => return Err(InputError::System(SystemError::SingularMass)),
            Mass::Diagonal(m) => Self::Reciprocals(m.iter().map(|m| m.recip()).collect()),
            Mass::Matrix(m) => {
                let mut lu = Lu::of(m);
                lu.factor(m).map_err(|_| InputError::System(SystemError::SingularMass))?;
                Self::Factors(Box::new(Mutex::new(lu)))
            }
            Mass::Operator(m) => Self::Operator(m.clone()),
        })
    }

    /// Overwrites `b` with M⁻¹ b.
    #[inline(always)]
    pub(crate) fn solve(&self, b: &mut [f64]) {
        match self {
            Self::Identity => {}
            Self::Reciprocals(m) => b.iter_mut().zip(m).for_each(|(b, m)| *b *= *m),
            _ => self.solve_coupled(b),
        }
    }

    /// M⁻¹ b, in `out` unless it is b itself.
    #[inline(always)]
    pub(crate) fn of<'a>(&self, b: &'a [f64], out: &'a mut [f64]) -> &'a [f64] {
        if matches!(self, Self::Identity) {
            return b;
        }
        out.copy_from_slice(b);
        self.solve(out);
        out
    }

    fn solve_coupled(&self, b: &mut [f64]) {
        match self {
            Self::Identity | Self::Reciprocals(_) => {}
            Self::Cholesky(factors) => factors.solve(b),
            Self::Factors(lu) => lu.lock().unwrap_or_else(PoisonError::into_inner).solve(b),
            Self::Operator(m) => m.operator.solve(b),
        }
    }
}
