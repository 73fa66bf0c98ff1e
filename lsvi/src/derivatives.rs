//! Whether the derivatives that a field states are those of its f, and those of mechanics those of L, F and the constraints.

mod difference;
mod mechanics;

pub use mechanics::{check_constraint, check_force, check_lagrangian, check_motion};

use std::fmt;

use thiserror::Error;

use difference::{Direction, agree, compare, directions, finite, pseudo_random, slopes, written};

use crate::error::{InputError, check_time, check_vector};
use crate::linalg::{Jacobian, Structure, larger, max_norm};
use crate::vector_field::{VectorField, check_system};

/// What entries are multiplied by: other than one, so that a scale that is not heeded shows, and exact.
const SCALE: f64 = -2.0;

/// What a function of mechanics is differentiated by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variable {
    /// The configuration q.
    Q,
    /// The velocity v.
    V,
    /// The acceleration a.
    A,
}

impl fmt::Display for Variable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Q => "q",
            Self::V => "v",
            Self::A => "a",
        })
    }
}

/// A derivative that a field, a Lagrangian, a force or a constraint states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Derivative {
    /// f itself, as [`VectorField::linearize`] writes it, beside that of [`VectorField::rhs`].
    Rate,
    /// J x, of [`VectorField::apply_jacobian`], or by the entries of [`VectorField::add_jacobian`] where there are any.
    Jacobian,
    /// The entries of [`VectorField::add_jacobian`] and [`VectorField::linearize`] over their scale, beside J x of
    /// [`VectorField::apply_jacobian`].
    Assembled,
    /// Jᵀw, of [`VectorField::apply_transpose`].
    Transpose,
    /// Σ w_i (∂²f_i/∂v²) x, of [`VectorField::apply_curvature`] or [`VectorField::add_curvature`].
    Curvature,
    /// ∂L/∂q and ∂L/∂v of [`Lagrangian::gradient`](crate::Lagrangian::gradient) and
    /// [`Lagrangian::gradient_q`](crate::Lagrangian::gradient_q).
    Gradient(Variable),
    /// Second derivatives of [`Lagrangian::add_hessian`](crate::Lagrangian::add_hessian) and
    /// [`Lagrangian::add_blocks`](crate::Lagrangian::add_blocks): of the gradient in the first variable, by the second.
    Hessian(Variable, Variable),
    /// The Euler–Lagrange expression E of [`EulerLagrange::residual`](crate::EulerLagrange::residual).
    Motion,
    /// Its derivatives, of [`EulerLagrange::add_residual_derivative`](crate::EulerLagrange::add_residual_derivative).
    MotionIn(Variable),
    /// ∂F/∂q and ∂F/∂v of [`Force::add_derivative`](crate::Force::add_derivative).
    Force(Variable),
    /// ∂f/∂q of [`Constraint::jacobian`](crate::Constraint::jacobian).
    Constraint,
    /// Σ_k λ_k ∂²f_k/∂q² of [`Constraint::add_curvature`](crate::Constraint::add_curvature).
    Reaction,
    /// Derivatives added at once, each with its weight, beside the same in turn.
    Blocks,
}

impl fmt::Display for Derivative {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rate => f.write_str("f of linearize"),
            Self::Jacobian => f.write_str("the Jacobian"),
            Self::Assembled => f.write_str("the assembled Jacobian"),
            Self::Transpose => f.write_str("the transposed product"),
            Self::Curvature => f.write_str("the curvature"),
            Self::Gradient(by) => write!(f, "∂L/∂{by}"),
            Self::Hessian(row, column) => write!(f, "∂²L/∂{row}∂{column}"),
            Self::Motion => f.write_str("the Euler–Lagrange expression"),
            Self::MotionIn(by) => write!(f, "∂E/∂{by}"),
            Self::Force(by) => write!(f, "∂F/∂{by}"),
            Self::Constraint => f.write_str("∂f/∂q"),
            Self::Reaction => f.write_str("Σ λ ∂²f/∂q²"),
            Self::Blocks => f.write_str("derivatives added with weights"),
        }
    }
}

/// A row of a product, and the column where the product is with a unit vector.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// The row; none of a sum over all rows.
    pub row: Option<usize>,
    /// The column; none along a direction that is no axis.
    pub column: Option<usize>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let part = |f: &mut fmt::Formatter<'_>, name: &str, at: Option<usize>| match at {
            Some(at) => write!(f, ", {name} {at}"),
            None => Ok(()),
        };
        part(f, "row", self.row)?;
        part(f, "column", self.column)
    }
}

/// A derivative that is not that of f, or what leaves it open.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DerivativeError {
    /// The state is none of the field, or the field is none.
    #[error(transparent)]
    Input(#[from] InputError),
    /// f or one of its derivatives is not finite at the state.
    #[error("{what} is not finite at the state, row {row}")]
    NonFinite {
        /// What.
        what: &'static str,
        /// Its row.
        row: usize,
    },
    /// A function adds to what it is given to write to, or leaves of it what was there.
    #[error("{what} is not written but depends on what was there before, row {row}")]
    NotWritten {
        /// What.
        what: &'static str,
        /// Its row.
        row: usize,
    },
    /// An entry where the declared structure has none.
    #[error("entry ({row}, {column}) of the Jacobian lies outside the declared structure")]
    Outside {
        /// Row of the entry.
        row: usize,
        /// Column of the entry.
        column: usize,
    },
    /// The derivative is another one.
    #[error("{of}{place}: stated is {stated}, and it should be {found:.8} within {within:.1e}")]
    Differs {
        /// Which derivative.
        of: Derivative,
        /// Where.
        place: Place,
        /// What the field states.
        stated: f64,
        /// What f, or J, makes of it.
        found: f64,
        /// What that is uncertain by.
        within: f64,
    },
    /// The differences do not settle, so that nothing is known: f may have a kink or a jump at the state, or be noise.
    #[error(
        "{of}{place}: differences give {found:.4e} within {within:.1e}, which tells nothing: f may not be smooth there"
    )]
    Unresolved {
        /// Which derivative.
        of: Derivative,
        /// Where.
        place: Place,
        /// What the differences tend to.
        found: f64,
        /// What that is uncertain by.
        within: f64,
    },
}

/// Checks the derivatives that `field` states at (`t`, `v`): that functions write what they are asked for, and f is the same with a
/// Jacobian and without, that J x is the derivative of f along x, that ⟨Jᵀw, x⟩ = ⟨w, J x⟩, that entries, times
/// their scale, and products agree, and that the curvature is the derivative of Jᵀw along x.
///
/// Up to 32 unknowns every entry is looked at; of more, products along eight directions. Derivatives are central differences,
/// (f(v + δx) − f(v − δx))/2δ, extrapolated to δ = 0 (Ridders), and have to agree to 1e-6 of the larger of the two or to what the
/// extrapolation is uncertain by; products, to 1e-10. A curvature may be off by what one from differences of J is, ten times √ε |Jᵀw|
/// over a thousandth of |v|. One state does not show all mistakes: check several, where no term vanishes, and where f
/// does not turn within a millionth of the state, which a difference takes for noise or for a slope.
///
/// ```
/// use lsvi::{Derivative, DerivativeError, Jacobian, VectorField, check_derivatives};
///
/// /// θ̇ = ω, ω̇ = −sin θ, with the sign of the sine's derivative forgotten.
/// struct Pendulum;
///
/// impl VectorField for Pendulum {
///     fn dim(&self) -> usize {
///         2
///     }
///     fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
///         dv[0] = v[1];
///         dv[1] = -v[0].sin();
///     }
///     fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
///         out.add(0, 1, scale);
///         out.add(1, 0, scale * v[0].cos());
///     }
/// }
///
/// let error = check_derivatives(&Pendulum, 0.0, &[1.0, 0.5]).expect_err("a wrong sign");
/// assert!(matches!(error, DerivativeError::Differs { of: Derivative::Jacobian, .. }));
/// assert!(error.to_string().starts_with("the Jacobian, row 1, column 0: stated is 0.54"));
/// ```
///
/// # Errors
/// [`DerivativeError`] with the first disagreement, or with what leaves the question open.
pub fn check_derivatives<F: VectorField + ?Sized>(field: &F, t: f64, v: &[f64]) -> Result<(), DerivativeError> {
    of_field(&field, t, v)
}

fn of_field(field: &dyn VectorField, t: f64, v: &[f64]) -> Result<(), DerivativeError> {
    check_system(field)?;
    check_time(t)?;
    check_vector("v", v, field.dim())?;
    let f = written("f", v.len(), |out| field.rhs(t, v, out))?;
    let check = Check { field, t, v, f };
    let directions = directions(v);
    let products = directions.iter().map(|x| check.jacobian(x)).collect::<Result<Vec<_>, _>>()?;
    for w in &directions {
        check.transpose(w, directions.iter().zip(&products))?;
    }
    // All components of f have a part in a sum along no axis.
    let w = pseudo_random(v.len(), 0);
    directions.iter().try_for_each(|x| check.curvature(&w, x))
}

/// The field at a state.
struct Check<'a> {
    field: &'a dyn VectorField,
    t: f64,
    v: &'a [f64],
    /// f(t, v).
    f: Vec<f64>,
}

impl Check<'_> {
    /// J x, by products and entries, beside the differences of f.
    fn jacobian(&self, x: &Direction) -> Result<Vec<f64>, DerivativeError> {
        let Self { field, t, v, ref f } = *self;
        let n = v.len();
        let product = written("J x", n, |out| field.apply_jacobian(t, v, &x.x, out))?;
        if field.structure() != Structure::MatrixFree {
            let (mut by_entries, mut at_once) = (vec![0.0; n], vec![0.0; n]);
            let mut jacobian = Jacobian::with_structure(n, &field.structure());
            field.add_jacobian(t, v, SCALE, &mut jacobian);
            if let Some((row, column)) = jacobian.outside() {
                return Err(DerivativeError::Outside { row, column });
            }
            jacobian.mul_add(SCALE.recip(), &x.x, &mut by_entries);
            let with_jacobian = written("f of linearize", n, |out| {
                jacobian.clear();
                field.linearize(t, v, out, SCALE, &mut jacobian);
            })?;
            finite("f of linearize", &with_jacobian)?;
            // Where f is near zero its terms are not.
            let mut terms = vec![0.0; n];
            jacobian.for_each(|i, j, a| terms[i] += (a / SCALE * v[j]).abs());
            let size = larger(larger(max_norm(&with_jacobian), max_norm(f)), max_norm(&terms));
            agree(Derivative::Rate, None, (&with_jacobian, f), 1e-10 * size)?;
            jacobian.mul_add(SCALE.recip(), &x.x, &mut at_once);
            finite("J x", &product)?;
            for other in [&by_entries, &at_once] {
                finite("the Jacobian", other)?;
                agree(
                    Derivative::Assembled,
                    x.axis,
                    (other, &product),
                    1e-10 * larger(max_norm(other), max_norm(&product)),
                )?;
            }
        }
        finite("J x", &product)?;
        let found = slopes(v, x, n, |v, out| field.rhs(t, v, out))?;
        compare(Derivative::Jacobian, |row| Place { row: Some(row), column: x.axis }, &product, &found)?;
        Ok(product)
    }

    /// ⟨Jᵀw, x⟩ beside ⟨w, J x⟩.
    fn transpose<'a>(
        &self,
        w: &Direction,
        products: impl Iterator<Item = (&'a Direction, &'a Vec<f64>)>,
    ) -> Result<(), DerivativeError> {
        let write = |out: &mut [f64]| self.field.apply_transpose(self.t, self.v, &w.x, out);
        let transposed = written("the transposed product", self.v.len(), write)?;
        finite("the transposed product", &transposed)?;
        for (x, product) in products {
            let terms = |a: &[f64], b: &[f64]| {
                a.iter().zip(b).map(|(a, b)| a * b).fold((0.0, 0.0), |(sum, size), x| (sum + x, size + x.abs()))
            };
            let ((stated, one), (found, other)) = (terms(&transposed, &x.x), terms(&w.x, product));
            // A product that ought to vanish is what the largest of its rows rounds by.
            let rows = max_norm(&transposed) * max_norm(&x.x) + max_norm(product) * max_norm(&w.x);
            let within = 1e-10 * (one + other) + 64.0 * f64::EPSILON * rows;
            if (stated - found).abs() > within {
                let place = Place { row: w.axis, column: x.axis };
                return Err(DerivativeError::Differs { of: Derivative::Transpose, place, stated, found, within });
            }
        }
        Ok(())
    }

    /// Σ w_i (∂²f_i/∂v²) x beside the differences of Jᵀw.
    fn curvature(&self, w: &[f64], x: &Direction) -> Result<(), DerivativeError> {
        let Self { field, t, v, .. } = *self;
        let product = written("the curvature", v.len(), |out| field.apply_curvature(t, v, w, &x.x, out))?;
        finite("the curvature", &product)?;
        if field.structure() != Structure::MatrixFree {
            let mut by_entries = vec![0.0; v.len()];
            let mut curvature = Jacobian::with_structure(v.len(), &field.curvature_structure());
            field.add_curvature(t, v, w, SCALE, &mut curvature);
            curvature.mul_add(SCALE.recip(), &x.x, &mut by_entries);
            finite("the curvature", &by_entries)?;
            // One of the two may come from single differences, whose digits f decides; a scale that is not heeded shows all the same.
            let size = larger(max_norm(&by_entries), max_norm(&product));
            agree(Derivative::Curvature, x.axis, (&by_entries, &product), 0.1 * size)?;
        }
        // A curvature that is not stated comes from differences of J over √ε of a thousandth of the state, and has what J rounds by.
        let transposed = written("the transposed product", v.len(), |out| field.apply_transpose(t, v, w, out))?;
        let size = if max_norm(v) > 0.0 { max_norm(v) } else { 1.0 };
        let rounding = f64::EPSILON.sqrt() * max_norm(&transposed) * max_norm(&x.x) / (1e-3 * size);
        let found = slopes(v, x, v.len(), |v, out| field.apply_transpose(t, v, w, out))?;
        let found: Vec<_> = found.into_iter().map(|slope| slope.beside(rounding)).collect();
        compare(Derivative::Curvature, |row| Place { row: Some(row), column: x.axis }, &product, &found)
    }
}
