//! A Butcher tableau as it is written, and as numbers.

use dashu_ratio::RBig;

use super::real::Real;

/// A coefficient: its text, its value, and where it stands.
#[derive(Debug, Clone)]
pub struct Coefficient {
    /// As it is written.
    pub text: String,
    /// Its value, exact where it is rational and not a rounded decimal.
    pub exact: Option<RBig>,
    /// Its value to 57 digits, or to the digits printed.
    pub real: Real,
}

/// Which coefficient of a method; indices count from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Place {
    /// a_ij.
    A(usize, usize),
    /// b_i.
    B(usize),
    /// c_i.
    C(usize),
    /// b̂_i.
    Hat(usize),
    /// The entry of a list of another kind of method: `rho[3]`.
    In(&'static str, usize),
    /// The entry of a matrix of another kind of method: `a_hat[2,1]`.
    Of(&'static str, usize, usize),
}

impl Place {
    /// The list in which it stands, or the matrix and the row.
    pub(super) fn block(self) -> (&'static str, Option<usize>) {
        match self {
            Self::A(i, _) => ("a", Some(i)),
            Self::B(_) => ("b", None),
            Self::C(_) => ("c", None),
            Self::Hat(_) => ("b_hat", None),
            Self::In(list, _) => (list, None),
            Self::Of(matrix, i, _) => (matrix, Some(i)),
        }
    }

    /// Its index in that list or row.
    pub(super) fn column(self) -> usize {
        match self {
            Self::A(_, j) | Self::Of(_, _, j) => j,
            Self::B(i) | Self::C(i) | Self::Hat(i) | Self::In(_, i) => i,
        }
    }
}

impl std::fmt::Display for Place {
    /// As it is printed, counted from 1.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::A(i, j) => write!(f, "a[{},{}]", i + 1, j + 1),
            Self::B(i) => write!(f, "b[{}]", i + 1),
            Self::C(i) => write!(f, "c[{}]", i + 1),
            Self::Hat(i) => write!(f, "b_hat[{}]", i + 1),
            Self::In(list, i) => write!(f, "{list}[{}]", i + 1),
            Self::Of(matrix, i, j) => write!(f, "{matrix}[{},{}]", i + 1, j + 1),
        }
    }
}

/// A Runge–Kutta method of s stages as a file states it.
#[derive(Debug, Clone)]
pub struct Tableau {
    /// s rows of s coefficients.
    pub a: Vec<Vec<Coefficient>>,
    /// s weights.
    pub b: Vec<Coefficient>,
    /// s abscissae, where they are given; the sums of the rows of A otherwise.
    pub c: Option<Vec<Coefficient>>,
    /// s weights of the embedded method, where there is one.
    pub b_hat: Option<Vec<Coefficient>>,
    /// Square roots of whole numbers that its texts contain.
    pub(super) radicands: Vec<i64>,
}

/// The shape of A, which decides what a step solves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Shape {
    /// Zero on and above the diagonal.
    Explicit,
    /// Zero above the diagonal.
    DiagonallyImplicit,
    /// Anything else: the stages are solved for together.
    FullyImplicit,
}

/// The numbers of a tableau.
#[derive(Debug, Clone, PartialEq)]
pub struct Numbers {
    /// A, by rows.
    pub a: Vec<Vec<Real>>,
    /// b.
    pub b: Vec<Real>,
    /// c as given, or the row sums.
    pub c: Vec<Real>,
    /// b̂.
    pub b_hat: Option<Vec<Real>>,
}

impl Tableau {
    /// Number of stages s.
    pub fn stages(&self) -> usize {
        self.b.len()
    }

    /// The same with decimals that were cut off after their last digit, in place of rounded.
    pub(super) fn of_truncated(&self) -> Self {
        self.of_decimals(|x| Some(x.of_truncated())).unwrap_or_else(|| self.clone())
    }

    /// The same with doubles in place of decimals, if all of these are printed from such.
    pub(super) fn of_doubles(&self) -> Option<Self> {
        self.of_decimals(Real::of_double)
    }

    fn of_decimals(&self, of: impl Fn(&Real) -> Option<Real>) -> Option<Self> {
        let row = |row: &[Coefficient]| -> Option<Vec<_>> {
            let changed = |x: &Coefficient| Some(Coefficient { real: of(&x.real)?, ..x.clone() });
            row.iter().map(|x| if x.exact.is_some() { Some(x.clone()) } else { changed(x) }).collect()
        };
        let option = |list: &Option<Vec<Coefficient>>| list.as_deref().map_or(Some(None), |list| row(list).map(Some));
        Some(Self {
            a: self.a.iter().map(|entries| row(entries)).collect::<Option<_>>()?,
            b: row(&self.b)?,
            c: option(&self.c)?,
            b_hat: option(&self.b_hat)?,
            radicands: self.radicands.clone(),
        })
    }

    /// The coefficient at `place`, if there is one.
    pub fn coefficient(&self, place: Place) -> Option<&Coefficient> {
        match place {
            Place::A(i, j) => self.a.get(i)?.get(j),
            Place::B(i) => self.b.get(i),
            Place::C(i) => self.c.as_ref()?.get(i),
            Place::Hat(i) => self.b_hat.as_ref()?.get(i),
            Place::In(..) | Place::Of(..) => None,
        }
    }

    /// Its numbers.
    pub fn numbers(&self) -> Numbers {
        let reals = |row: &[Coefficient]| row.iter().map(|x| x.real.clone()).collect::<Vec<_>>();
        let a: Vec<Vec<Real>> = self.a.iter().map(|row| reals(row)).collect();
        let c = self.c.as_deref().map_or_else(|| row_sums(&a), reals);
        Numbers { b: reals(&self.b), b_hat: self.b_hat.as_deref().map(reals), a, c }
    }

    /// The shape of A, by exact zeros.
    pub fn shape(&self) -> Shape {
        let is_zero = |x: &Coefficient| x.exact.as_ref().is_some_and(RBig::is_zero);
        let zero_from =
            |offset: usize| self.a.iter().enumerate().all(|(i, row)| row.iter().skip(i + offset).all(is_zero));
        if zero_from(0) {
            Shape::Explicit
        } else if zero_from(1) {
            Shape::DiagonallyImplicit
        } else {
            Shape::FullyImplicit
        }
    }
}

/// Σ over j of a_ij for each i.
pub(super) fn row_sums(a: &[Vec<Real>]) -> Vec<Real> {
    a.iter().map(|row| row.iter().sum()).collect()
}

impl Numbers {
    /// Number of stages.
    pub fn stages(&self) -> usize {
        self.b.len()
    }

    /// c_i − Σ_j a_ij.
    pub fn row_defects(&self) -> Vec<Real> {
        self.c.iter().zip(row_sums(&self.a)).map(|(c, sum)| c - &sum).collect()
    }

    /// The number at `place`, to be changed.
    pub(super) fn at_mut(&mut self, place: Place) -> Option<&mut Real> {
        match place {
            Place::A(i, j) => self.a.get_mut(i)?.get_mut(j),
            Place::B(i) => self.b.get_mut(i),
            Place::C(i) => self.c.get_mut(i),
            Place::Hat(i) => self.b_hat.as_mut()?.get_mut(i),
            Place::In(..) | Place::Of(..) => None,
        }
    }

    /// The same in double precision: A by rows, b, c.
    pub fn doubles(&self) -> (Vec<Vec<f64>>, Vec<f64>, Vec<f64>) {
        let row = |x: &Vec<Real>| x.iter().map(Real::to_f64).collect::<Vec<_>>();
        (self.a.iter().map(row).collect(), row(&self.b), row(&self.c))
    }
}

impl Coefficient {
    pub(super) fn zero() -> Self {
        Self { text: "0".into(), exact: Some(RBig::ZERO), real: Real::zero() }
    }

    pub(super) fn one() -> Self {
        Self { text: "1".into(), exact: Some(RBig::ONE), real: Real::one() }
    }
}
