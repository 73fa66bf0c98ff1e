//! Whether the derivatives that a field states are those of its f.

use std::fmt;

use thiserror::Error;

use crate::error::{InputError, check_time, check_vector};
use crate::linalg::{Jacobian, Structure, larger, max_norm};
use crate::vector_field::{VectorField, check_system};

/// Unknowns up to which every entry is looked at; of more, products along a few directions.
const FEW: usize = 32;
/// Directions that stand for all of them.
const DIRECTIONS: u64 = 8;
/// Central differences, each with half the distance of the one before.
const LEVELS: usize = 16;
/// First distance, relative to the state: the differences of a smooth f settle from there on.
const FIRST: f64 = 0.1;
/// What stated and found may differ by, relative to the larger: far above rounding, and below what a wrong term makes.
const RELATIVE: f64 = 1e-6;
/// What a difference may be wrong by, in terms of the change in its extrapolation.
const SAFETY: f64 = 10.0;
/// What entries are multiplied by: other than one, so that a scale that is not heeded shows, and exact.
const SCALE: f64 = -2.0;
/// Uncertainty, relative to the size, beyond which a difference tells nothing.
const TELLS: f64 = 1e-3;

/// A derivative of f that a field states.
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
}

impl fmt::Display for Derivative {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Rate => "f of linearize",
            Self::Jacobian => "the Jacobian",
            Self::Assembled => "the assembled Jacobian",
            Self::Transpose => "the transposed product",
            Self::Curvature => "the curvature",
        })
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
/// extrapolation is uncertain by; products, to 1e-10. One state does not show all mistakes: check several, where no term vanishes.
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
    check_system(&field)?;
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

/// A direction, and which axis it is.
struct Direction {
    x: Vec<f64>,
    axis: Option<usize>,
    /// First distance of differences.
    first: f64,
}

/// The axes of a small space, or a few directions in a large one.
fn directions(v: &[f64]) -> Vec<Direction> {
    let n = v.len();
    let largest = max_norm(v);
    let size = if largest > 0.0 { largest } else { 1.0 };
    if n > FEW {
        return (1..=DIRECTIONS)
            .map(|seed| Direction { x: pseudo_random(n, seed), axis: None, first: FIRST * size })
            .collect();
    }
    let axis = |j: usize| {
        let mut x = vec![0.0; n];
        x[j] = 1.0;
        Direction { x, axis: Some(j), first: FIRST * v[j].abs().max(1e-3 * size) }
    };
    (0..n).map(axis).collect()
}

/// Numbers between ½ and 1 with either sign, the same for the same seed.
fn pseudo_random(n: usize, seed: u64) -> Vec<f64> {
    let mut state = 0x9e37_79b9_7f4a_7c15 ^ seed.wrapping_mul(0xd134_2543_de82_ef95);
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let size = 0.5 + 0.5 * ((state >> 12) as f64 / (1_u64 << 52) as f64);
        if state >> 11 & 1 == 0 { size } else { -size }
    };
    (0..n).map(|_| next()).collect()
}

/// The field at a state.
struct Check<'a, F: ?Sized> {
    field: &'a F,
    t: f64,
    v: &'a [f64],
    /// f(t, v).
    f: Vec<f64>,
}

impl<F: VectorField + ?Sized> Check<'_, F> {
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
        let slopes = self.slopes(x, |v, out| field.rhs(t, v, out))?;
        compare(Derivative::Jacobian, x.axis, &product, &slopes)?;
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
            let mut curvature = Jacobian::with_structure(v.len(), &field.structure().gram(v.len()));
            field.add_curvature(t, v, w, SCALE, &mut curvature);
            curvature.mul_add(SCALE.recip(), &x.x, &mut by_entries);
            finite("the curvature", &by_entries)?;
            // One of the two may come from single differences, whose digits f decides; a scale that is not heeded shows all the same.
            let size = larger(max_norm(&by_entries), max_norm(&product));
            agree(Derivative::Curvature, x.axis, (&by_entries, &product), 0.1 * size)?;
        }
        let slopes = self.slopes(x, |v, out| field.apply_transpose(t, v, w, out))?;
        compare(Derivative::Curvature, x.axis, &product, &slopes)
    }

    /// The derivative of `function` along x in each row.
    fn slopes(
        &self,
        x: &Direction,
        mut function: impl FnMut(&[f64], &mut [f64]),
    ) -> Result<Vec<Slope>, DerivativeError> {
        let n = self.v.len();
        let mut at = |distance: f64| {
            let moved: Vec<f64> = self.v.iter().zip(&x.x).map(|(v, x)| v + distance * x).collect();
            let mut value = vec![0.0; n];
            function(&moved, &mut value);
            value
        };
        finite("f, or a derivative of it,", &at(0.0))?;
        let level = |k| {
            let distance = x.first * 0.5_f64.powi(k);
            let values = [at(distance), at(-distance)];
            // Rows may be sums over all unknowns, as transforms are, of which each term rounds by the size of the largest.
            let size = larger(max_norm(&values[0]), max_norm(&values[1]));
            (distance, values, size)
        };
        let levels: Vec<_> = (0..LEVELS as i32).map(level).collect();
        let row = |i: usize| levels.iter().map(move |(d, [above, below], size)| (*d, [above[i], below[i]], *size));
        Ok((0..n).map(|i| Slope::extrapolated(row(i))).collect())
    }
}

/// A derivative from differences.
struct Slope {
    value: f64,
    uncertainty: f64,
    /// What rounding leaves of the difference over the largest distance.
    rounding: f64,
}

impl Slope {
    /// From values of a function above and below, over distances that halve, with the size by which they round: of all differences
    /// extrapolated in δ² the one that changed least. The largest distances may reach beyond a pole.
    fn extrapolated(levels: impl Iterator<Item = (f64, [f64; 2], f64)>) -> Self {
        // Where the function ends, as a root does, larger distances say nothing.
        let levels = levels.skip_while(|(_, [above, below], _)| !(above - below).is_finite());
        let mut best = Self { value: f64::NAN, uncertainty: f64::INFINITY, rounding: 0.0 };
        let mut row: Vec<f64> = Vec::new();
        for (k, (distance, [above, below], size)) in levels.enumerate() {
            let rounding = 4.0 * f64::EPSILON * size / distance;
            let mut next = vec![(above - below) / (2.0 * distance)];
            for (m, before) in row.iter().enumerate() {
                let (factor, last) = (4_f64.powi(m as i32 + 1), next[m]);
                let value = last + (last - before) / (factor - 1.0);
                let change = larger((value - last).abs(), (value - before).abs());
                if change + rounding <= best.uncertainty {
                    best = Self { value, uncertainty: change + rounding, ..best };
                }
                next.push(value);
            }
            if k == 0 {
                best.rounding = rounding;
            }
            row = next;
        }
        best
    }
}

/// What `write` writes over zeros, and over ones as well.
fn written(what: &'static str, n: usize, mut write: impl FnMut(&mut [f64])) -> Result<Vec<f64>, DerivativeError> {
    let (mut over_zeros, mut over_ones) = (vec![0.0; n], vec![1.0; n]);
    write(&mut over_zeros);
    write(&mut over_ones);
    // Two evaluations may differ by rounding, as sums of several threads do.
    let is_kept = |(a, b): (&f64, &f64)| (b - a).abs() > 1e-6 * (1.0 + a.abs());
    match over_zeros.iter().zip(&over_ones).position(is_kept) {
        Some(row) => Err(DerivativeError::NotWritten { what, row }),
        None => Ok(over_zeros),
    }
}

fn finite(what: &'static str, values: &[f64]) -> Result<(), DerivativeError> {
    match values.iter().position(|x| !x.is_finite()) {
        Some(row) => Err(DerivativeError::NonFinite { what, row }),
        None => Ok(()),
    }
}

/// Two vectors that differ by no more than `within`.
fn agree(
    of: Derivative,
    column: Option<usize>,
    (stated, found): (&[f64], &[f64]),
    within: f64,
) -> Result<(), DerivativeError> {
    for (row, (stated, found)) in stated.iter().zip(found).enumerate() {
        if (stated - found).abs() > within {
            let place = Place { row: Some(row), column };
            return Err(DerivativeError::Differs { of, place, stated: *stated, found: *found, within });
        }
    }
    Ok(())
}

/// What is stated beside what was found by differences.
fn compare(of: Derivative, column: Option<usize>, stated: &[f64], found: &[Slope]) -> Result<(), DerivativeError> {
    let largest = found.iter().fold(max_norm(stated), |largest, slope| larger(largest, slope.value));
    for (row, (stated, slope)) in stated.iter().zip(found).enumerate() {
        let (place, size) = (Place { row: Some(row), column }, stated.abs().max(slope.value.abs()));
        let (found, within) = (slope.value, SAFETY * slope.uncertainty + RELATIVE * size);
        // A small entry beside large ones has what their sums round by.
        if slope.uncertainty > TELLS * size + SAFETY * slope.rounding + 1e-10 * largest {
            return Err(DerivativeError::Unresolved { of, place, found, within });
        }
        if (stated - found).abs() > within {
            return Err(DerivativeError::Differs { of, place, stated: *stated, found, within });
        }
    }
    Ok(())
}
