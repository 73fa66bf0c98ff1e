//! Polynomials with real coefficients, and where they are negative.

use std::f64::consts::PI;

use nalgebra::{Complex, DMatrix, Schur};

use super::real::Real;
use experiments::measure::norm::{Extremes, larger};
use experiments::measure::search::root;

/// Most iterations for a root; a handful is usual.
pub(super) const ITERATIONS: usize = 100;

/// Coefficients of 1, x, x², …; none that may be zero at the end.
#[derive(Debug, Clone, PartialEq)]
pub struct Polynomial(Vec<Real>);

/// Where a product of polynomials on x > 0 is first negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Sign {
    /// Nowhere.
    NonNegative,
    /// From `from` on, where it is zero or x = 0.
    NegativeFrom {
        /// The end of what is not negative.
        from: f64,
        /// How far off this end may be for the digits that the coefficients have.
        open: f64,
        /// A point where it is negative, whatever they are.
        at: f64,
    },
    /// Not up to `to`; of what is beyond, the digits do not tell.
    Open {
        /// The end of what is certain.
        to: f64,
    },
}

/// An interval as narrow as that, relative to where it is, in which a sign may have changed and need not: a double root that
/// the digits split.
const TOUCH: f64 = 1e-3;

/// What vanishes to the digits given is taken for zero if they are at least so many.
pub(super) const VANISHES: f64 = 1e-3;

/// Coefficients that are known so well are exact: what cannot be told from zero then is zero.
pub(super) const EXACT: f64 = 1e-40;

/// Digits that Euclid's divisions have to leave of exact coefficients.
const LEFT: f64 = 1e-20;

impl Polynomial {
    pub(super) fn new(mut coefficients: Vec<Real>) -> Self {
        while coefficients.last().is_some_and(Real::may_be_zero) {
            coefficients.pop();
        }
        Self(coefficients)
    }

    /// The coefficients of 1, x, x², ….
    pub fn coefficients(&self) -> &[Real] {
        &self.0
    }

    /// The degree; `None` for the zero polynomial.
    pub fn degree(&self) -> Option<usize> {
        self.0.len().checked_sub(1)
    }

    pub(super) fn doubles(&self) -> Vec<f64> {
        self.0.iter().map(Real::to_f64).collect()
    }

    pub(super) fn at(&self, x: &Real) -> Real {
        self.0.iter().rev().fold(Real::zero(), |sum, c| &(&sum * x) + c)
    }

    /// The value at a complex point.
    pub fn at_complex(&self, z: Complex<f64>) -> Complex<f64> {
        self.0.iter().rev().fold(Complex::new(0.0, 0.0), |sum, c| sum * z + c.to_f64())
    }

    pub(super) fn minus(&self, other: &Self) -> Self {
        Self::new(self.difference(other).0)
    }

    /// The same with all coefficients, those that may be zero too: how far these may be from it.
    pub(super) fn difference(&self, other: &Self) -> Self {
        let n = self.0.len().max(other.0.len());
        let get = |p: &Self, k: usize| p.0.get(k).cloned().unwrap_or_else(Real::zero);
        Self((0..n).map(|k| &get(self, k) - &get(other, k)).collect())
    }

    pub(super) fn plus(&self, other: &Self) -> Self {
        self.minus(&Self(other.0.iter().map(|c| -c).collect()))
    }

    pub(super) fn times(&self, other: &Self) -> Self {
        let mut out = vec![Real::zero(); (self.0.len() + other.0.len()).saturating_sub(1)];
        for (i, a) in self.0.iter().enumerate() {
            for (j, b) in other.0.iter().enumerate() {
                out[i + j] = &out[i + j] + &(a * b);
            }
        }
        Self::new(out)
    }

    /// p/(x − r), where r is a root.
    pub(super) fn without_root(&self, root: &Real) -> Self {
        let mut quotient: Vec<Real> = Vec::new();
        for c in self.0.iter().skip(1).rev() {
            let carried = quotient.last().map_or_else(Real::zero, |last| last * root);
            quotient.push(c + &carried);
        }
        quotient.reverse();
        Self(quotient)
    }

    /// p(−x).
    pub(super) fn mirrored(&self) -> Self {
        Self(self.0.iter().enumerate().map(|(k, c)| if k % 2 == 0 { c.clone() } else { -c }).collect())
    }

    /// |p(i√x)|² as a polynomial in x.
    pub(super) fn modulus_on_imaginary_axis(&self) -> Self {
        let part = |odd: usize| {
            let terms = self.0.iter().skip(odd).step_by(2).enumerate();
            Self::new(terms.map(|(k, c)| if k % 2 == 0 { c.clone() } else { -c }).collect())
        };
        let (even, odd) = (part(0), part(1));
        let shifted = Self::new([vec![Real::zero()], odd.times(&odd).0].concat());
        even.times(&even).plus(&shifted)
    }

    /// All roots in double precision.
    pub fn roots(&self) -> Vec<Complex<f64>> {
        let Some(degree) = self.degree() else { return Vec::new() };
        let c = self.doubles();
        // In a variable in which the largest root is of size 1 the companion matrix is balanced, however small the first coefficient is, as what
        // rounding leaves of a zero.
        let lowest = c.iter().position(|x| *x != 0.0).unwrap_or(0);
        let n = degree - lowest;
        let mut roots = vec![Complex::new(0.0, 0.0); lowest];
        if n == 0 {
            return roots;
        }
        let scale = size_of_roots(&c[lowest..]);
        let mut companion = DMatrix::zeros(n, n);
        for k in 0..n {
            companion[(k, n - 1)] = -c[lowest + k] / c[degree] * scale.powi(k as i32 - n as i32);
            if k > 0 {
                companion[(k, k - 1)] = 1.0;
            }
        }
        if companion.iter().all(|x| x.is_finite()) {
            let schur = Schur::try_new(companion, f64::EPSILON, ITERATIONS * n);
            let found = schur.map(|schur| schur.complex_eigenvalues().iter().map(|z| z * scale).collect::<Vec<_>>());
            let rest: Vec<Complex<f64>> = c[lowest..].iter().map(|c| Complex::new(*c, 0.0)).collect();
            roots.extend(found.unwrap_or_else(|| simultaneous(&rest)));
        }
        roots
    }

    /// p′.
    pub(super) fn derivative(&self) -> Self {
        Self::new(self.0.iter().enumerate().skip(1).map(|(k, c)| c * &Real::from(k as i64)).collect())
    }

    /// xⁿ p(1/x), which has the roots 1/r.
    fn reversed(&self) -> Self {
        Self::new(self.0.iter().rev().cloned().collect())
    }

    /// Quotient and remainder; the divisor is not zero.
    fn divided_by(&self, divisor: &Self) -> (Self, Self) {
        let (mut rest, n) = (self.0.clone(), divisor.0.len());
        let mut quotient = vec![Real::zero(); (rest.len() + 1).saturating_sub(n)];
        let Some(leading) = divisor.0.last() else { return (Self(Vec::new()), self.clone()) };
        for k in (0..quotient.len()).rev() {
            let factor = &rest[k + n - 1] / leading;
            for (x, d) in rest[k..].iter_mut().zip(&divisor.0) {
                *x = &*x - &(&factor * d);
            }
            quotient[k] = factor;
        }
        rest.truncate(n - 1);
        (Self::new(quotient), Self::new(rest))
    }

    /// The greatest common divisor, by Euclid; what cannot be told from zero is zero.
    fn common_divisor(&self, other: &Self) -> Self {
        let (mut a, mut b) = (self.clone(), other.clone());
        while b.degree().is_some() {
            (a, b) = (b.clone(), a.divided_by(&b).1);
        }
        a
    }

    /// Each root once.
    pub(super) fn squarefree(&self) -> Self {
        self.divided_by(&self.repeated()).0
    }

    /// The roots that are there more than once, each one time less.
    pub(super) fn repeated(&self) -> Self {
        self.common_divisor(&self.derivative())
    }

    /// The part of which the roots come in pairs z, 1/z: those on the unit circle are among them.
    pub(super) fn reciprocal_part(&self) -> Self {
        self.common_divisor(&self.reversed())
    }

    /// p without the roots that it shares with another; nothing where the digits given do not tell which these are.
    pub(super) fn without_roots_of(&self, other: &Self) -> Option<Self> {
        if larger(self.radius(), other.radius()) > EXACT {
            return None;
        }
        let rest = self.divided_by(&self.common_divisor(other)).0;
        let size = rest.0.iter().map(|c| c.to_f64().abs()).fold(0.0, larger);
        (rest.radius() <= LEFT * size).then_some(rest)
    }

    /// How far digits that are given leave those coefficients open that may be zero, where there are such.
    pub(super) fn left_open(&self) -> Option<f64> {
        let open = self.0.iter().filter(|c| c.may_be_zero()).map(Real::radius).fold(0.0, larger);
        (open > EXACT).then_some(open)
    }

    /// The widest of the coefficients.
    pub(super) fn radius(&self) -> f64 {
        self.0.iter().map(Real::radius).fold(0.0, larger)
    }

    /// The same with exact coefficients, those zero that cannot be told from it at either end: the first ones vanish with the
    /// order of a method.
    fn centre(&self) -> Self {
        let certain = |c: &Real| !c.may_be_zero();
        let first = self.0.iter().position(certain).unwrap_or(self.0.len());
        let last = self.0.iter().rposition(certain).map_or(0, |k| k + 1);
        let inner = |(k, c): (usize, &Real)| if k < first { Real::zero() } else { c.centre() };
        Self(self.0.iter().enumerate().take(last).map(inner).collect())
    }

    /// Where on x > 0 it changes its sign, with exact coefficients in the place of those that the digits leave open.
    pub(super) fn certain_changes(&self) -> Vec<f64> {
        self.centre().changes()
    }

    /// The sign at x > 0 of exact coefficients: 1, −1, or 0 where even 57 digits do not tell it. Most often doubles do.
    fn sign_at(&self, doubles: &[f64], x: f64) -> i32 {
        let (value, size) = doubles.iter().rev().fold((0.0, 0.0), |(v, s), c| (v * x + c, s * x + c.abs()));
        let rounding = 4.0 * f64::EPSILON * doubles.len() as f64 * size;
        if f64::abs(value) > rounding {
            return if value > 0.0 { 1 } else { -1 };
        }
        let value = self.at(&Real::double(x));
        i32::from(value.is_positive()) - i32::from(value.is_negative())
    }

    /// Where on x > 0 exact coefficients make it change its sign, ascending. Between the roots of its derivative it is monotone, so
    /// that each change is found by bisection; a double root is none.
    fn changes(&self) -> Vec<f64> {
        let lowest = self.0.iter().position(|c| !c.is_zero()).unwrap_or(self.0.len());
        let stripped = Self(self.0[lowest..].to_vec());
        let doubles = stripped.doubles();
        let signs: Vec<bool> = stripped.0.iter().filter(|c| !c.is_zero()).map(Real::is_positive).collect();
        // Descartes: no more changes than there are among the coefficients.
        if signs.windows(2).all(|pair| pair[0] == pair[1]) {
            return Vec::new();
        }
        let of = |positive: bool| if positive { 1 } else { -1 };
        let mut before = (0.0, of(signs[0]));
        let inner = stripped.derivative().changes().into_iter().map(|x| (x, stripped.sign_at(&doubles, x)));
        let last = (bound(&doubles), of(signs[signs.len() - 1]));
        let mut found = Vec::new();
        for here in inner.chain([last]).filter(|(_, sign)| *sign != 0) {
            if here.1 != before.1 {
                let sign = |x: f64| if x == 0.0 { before.1 } else { stripped.sign_at(&doubles, x) };
                found.extend(root([before.0, here.0], |x| f64::from(sign(x))));
            }
            before = here;
        }
        found
    }
}

/// More than any root (Fujiwara), by some roundings.
fn bound(c: &[f64]) -> f64 {
    let n = c.len() - 1;
    let of = |k: usize| ((c[n - k] / c[n]).abs() * if k == n { 0.5 } else { 1.0 }).powf(1.0 / k as f64);
    2.001 * (1..=n).map(of).largest()
}

/// No more than the largest root, and all of it where roots have one size: with n roots of r at most |c_{n−k}/c_n| ≤ (n over k) rᵏ.
fn size_of_roots(c: &[f64]) -> f64 {
    let n = c.len() - 1;
    let mut ways = 1.0;
    let of = |k: usize| {
        ways *= (n - k + 1) as f64 / k as f64;
        ((c[n - k] / c[n]).abs() / ways).powf(1.0 / k as f64)
    };
    (1..=n).map(of).largest()
}

/// Where on x > 0 the product of `factors` is first negative. A double root, where it only touches zero, does not end what is not
/// negative. Signs are those of the centres of the coefficients where the digits that they have leave one sign alone.
pub(super) fn first_negative(factors: &[Polynomial]) -> Sign {
    let centres: Vec<Polynomial> = factors.iter().map(Polynomial::centre).collect();
    if factors.iter().any(|factor| is_left_open(&factor.0)) {
        return Sign::Open { to: 0.0 };
    }
    if centres.iter().any(|centre| centre.0.is_empty()) {
        return Sign::NonNegative;
    }
    let product = |sign: &dyn Fn(usize) -> i32| (0..factors.len()).map(sign).product::<i32>();
    let doubles: Vec<Vec<f64>> = centres.iter().map(Polynomial::doubles).collect();
    let probable = |x: f64| product(&|k| centres[k].sign_at(&doubles[k], x));
    let certain = |x: f64| {
        product(&|k| {
            let value = factors[k].at(&Real::double(x));
            i32::from(value.is_positive()) - i32::from(value.is_negative())
        })
    };
    let mut changes: Vec<f64> = centres.iter().flat_map(Polynomial::changes).collect();
    changes.sort_by(f64::total_cmp);
    let mut dips: Vec<f64> = centres.iter().flat_map(|centre| centre.derivative().changes()).collect();
    dips.sort_by(f64::total_cmp);
    let ends = changes.iter().copied().chain([f64::INFINITY]);
    for (left, right) in [0.0].into_iter().chain(changes.iter().copied()).zip(ends) {
        let probes = (0..=PROBES).map(|k| between(left, right, k));
        let decided = probes.map(|x| (x, probable(x))).find(|(x, sign)| *sign != 0 && certain(*x) == *sign);
        let Some((at, sign)) = decided else {
            // Zeros of two factors at one place, or a double one.
            if right <= left * (1.0 + TOUCH) {
                continue;
            }
            return Sign::Open { to: left - gap(|open| left > open && certain(left - open) > 0, left) };
        };
        if sign > 0 {
            // Between two points where it is positive for certain it may be negative, if the digits leave its least value open.
            let split = |x: f64| certain(x * (1.0 - TOUCH)) <= 0 || certain(x * (1.0 + TOUCH)) <= 0;
            let inner = dips.iter().copied().filter(|x| left < x * (1.0 - TOUCH) && x * (1.0 + TOUCH) < right);
            match inner.into_iter().find(|x| certain(*x) <= 0 && split(*x)) {
                Some(x) => return Sign::Open { to: x - gap(|open| certain(x - open) > 0, x) },
                None => continue,
            }
        }
        if left == 0.0 {
            // What is certain begins there.
            let first = (1..=PROBES).map(|k| at * 0.5_f64.powi(k)).take_while(|x| certain(*x) < 0).last();
            return Sign::NegativeFrom { from: 0.0, open: first.unwrap_or(at), at };
        }
        let below = gap(|open| certain(left - open) > 0, left);
        let beyond = gap(|open| certain(left + open) < 0, left).min(at - left);
        return Sign::NegativeFrom { from: left, open: larger(below, beyond), at };
    }
    Sign::NonNegative
}

/// Whether no coefficient is told from zero, by fewer digits than are taken to say so.
pub(super) fn is_left_open(coefficients: &[Real]) -> bool {
    coefficients.iter().all(Real::may_be_zero) && coefficients.iter().map(Real::radius).fold(0.0, larger) > VANISHES
}

/// How many points of an interval are tried.
const PROBES: i32 = 60;

/// The k-th point to be tried between two ends, first one in the middle.
fn between(left: f64, right: f64, k: i32) -> f64 {
    let part = if k % 2 == 0 { f64::from(k / 2) } else { -f64::from(k / 2 + 1) };
    match (left == 0.0, right.is_infinite()) {
        (true, true) => part.exp2(),
        (true, false) => right * 0.5_f64.powi(k + 1),
        (false, true) => left * (1.0 + part.exp2()),
        (false, false) => left * (right / left).powf(0.5 + part / f64::from(PROBES + 2)),
    }
}

/// The least of `end`/2⁵², …, `end`/2 at a distance of which something is certain, else `end`.
fn gap(is_certain: impl Fn(f64) -> bool, end: f64) -> f64 {
    let distances = (1..=52).rev().map(|k| end * 0.5_f64.powi(k));
    distances.into_iter().find(|open| is_certain(*open)).unwrap_or(end)
}

/// All roots of Σ c_k xᵏ, c_n ≠ 0, at once, by the iteration of Ehrlich and Aberth: slower than the eigenvalues of the
/// companion matrix, whose iteration stalls where many roots have one modulus. Where several are 0 they are next to nothing.
pub(super) fn simultaneous(c: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let n = c.len() - 1;
    let size = size_of_roots(&c.iter().map(|c| c.norm()).collect::<Vec<_>>());
    // No symmetry of the roots is one of these angles.
    let start = |k: usize| Complex::from_polar(size, 0.4 + 2.0 * PI * k as f64 / n as f64);
    let mut roots: Vec<Complex<f64>> = (0..n).map(start).collect();
    let zero = Complex::new(0.0, 0.0);
    for _ in 0..ITERATIONS {
        let mut is_settled = true;
        for k in 0..n {
            let z = roots[k];
            let (value, slope, rounding) =
                c.iter().rev().fold((zero, zero, 0.0), |(p, d, r), c| (p * z + c, d * z + p, r * z.norm() + c.norm()));
            if value.norm() <= 2.0 * f64::EPSILON * rounding {
                continue;
            }
            let newton = value / slope;
            let others: Complex<f64> =
                roots.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, other)| (z - other).inv()).sum();
            let step = newton / (Complex::new(1.0, 0.0) - newton * others);
            roots[k] = z - step;
            is_settled &= step.norm() <= 4.0 * f64::EPSILON * z.norm();
        }
        if is_settled {
            break;
        }
    }
    roots
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polynomial(coefficients: &[i64]) -> Polynomial {
        Polynomial::new(coefficients.iter().map(|c| Real::from(*c)).collect())
    }

    fn sign(coefficients: &[i64]) -> Sign {
        first_negative(&[polynomial(coefficients)])
    }

    #[test]
    fn signs_are_found_between_the_roots_and_not_where_a_root_only_touches() {
        assert_eq!(sign(&[1, -2, 1]), Sign::NonNegative);
        let Sign::NegativeFrom { from, open, at } = sign(&[2, -3, 1]) else { panic!("negative between 1 and 2") };
        assert!((from - 1.0).abs() < 1e-15 && open < 1e-15 && at > 1.0 && at < 2.0);
        assert!(matches!(sign(&[0, -1, 1]), Sign::NegativeFrom { from: 0.0, .. }));
        assert!(matches!(sign(&[0, 0, -1]), Sign::NegativeFrom { from: 0.0, .. }));
        assert_eq!(sign(&[]), Sign::NonNegative);
        // (x − 1)²(2 − x): the double root is passed.
        let Sign::NegativeFrom { from, .. } = sign(&[2, -5, 4, -1]) else { panic!("negative beyond 2") };
        assert!((from - 2.0).abs() < 1e-15, "{from}");
    }

    /// (x − 1)(x − 2)⋯(x − 20), Wilkinson's: in doubles its roots are not even real.
    #[test]
    fn changes_of_sign_are_found_where_roots_in_doubles_are_not() {
        let product = |p: Polynomial, n: i64| p.times(&polynomial(&[-n, 1]));
        let wilkinson = (1..=20).fold(polynomial(&[1]), product);
        let changes = wilkinson.changes();
        assert_eq!(changes.len(), 20, "{changes:?}");
        for (n, x) in (1..).zip(changes) {
            assert!((x - f64::from(n)).abs() < 1e-14 * f64::from(n), "{x}");
        }
    }

    /// The bound on roots is the root itself where there is no other.
    #[test]
    fn the_root_of_a_line_is_found() {
        for n in 1..100 {
            let line = Polynomial::new(vec![Real::double(0.1), -&(&Real::one() / &Real::from(n))]);
            let x = 0.1 * n as f64;
            assert!(matches!(line.changes()[..], [y] if (y - x).abs() < 1e-15 * x), "{n}: {:?}", line.changes());
        }
    }

    /// 2 − x with 2 to a tenth, and with a slope that may be zero.
    #[test]
    fn an_end_is_known_to_the_digits_of_the_coefficients() {
        let line = |slope: f64, radius: f64| {
            first_negative(&[Polynomial(vec![Real::from(2).widened(0.1), Real::double(slope).widened(radius)])])
        };
        let Sign::NegativeFrom { from, open, .. } = line(-1.0, 0.0) else { panic!("negative beyond 2.1") };
        assert!((from - 2.0).abs() < 1e-15 && (0.1..=0.2).contains(&open), "{open}");
        assert_eq!(line(-0.1, 0.2), Sign::NonNegative);
    }

    /// Roots of unity, twice: the iteration for eigenvalues does not settle on them.
    #[test]
    fn roots_of_one_modulus_are_found_too() {
        // (x − 1)(x² + 1)².
        let p = polynomial(&[-1, 1, -2, 2, -1, 1]);
        let roots = p.roots();
        assert_eq!(roots.len(), 5);
        for root in roots {
            let near = |z: Complex<f64>| (z - root).norm() < 1e-6;
            assert!(
                near(Complex::new(1.0, 0.0)) || near(Complex::new(0.0, 1.0)) || near(Complex::new(0.0, -1.0)),
                "{root}"
            );
        }
        assert_eq!(p.repeated().degree(), Some(2));
        assert_eq!(p.squarefree().degree(), Some(3));
        assert_eq!(p.reciprocal_part().degree(), Some(5));
        // (x − 2)(x² + 1): the pair on the circle alone.
        assert_eq!(polynomial(&[-2, 1, -2, 1]).reciprocal_part().degree(), Some(2));
        let complex: Vec<Complex<f64>> = [6.0, -5.0, 1.0].map(|c| Complex::new(c, 0.0)).to_vec();
        let mut two = simultaneous(&complex).iter().map(|z| z.re).collect::<Vec<_>>();
        two.sort_by(f64::total_cmp);
        assert!((two[0] - 2.0).abs() < 1e-12 && (two[1] - 3.0).abs() < 1e-12, "{two:?}");
    }

    #[test]
    fn the_modulus_on_the_imaginary_axis_is_that_of_the_value_there() {
        let p = polynomial(&[3, -1, 4, 2, -5]);
        let y = 0.7_f64;
        let value = p.at_complex(Complex::new(0.0, y)).norm_sqr();
        assert!((p.modulus_on_imaginary_axis().at(&Real::double(y * y)).to_f64() - value).abs() < 1e-13);
    }

    /// Ball coefficients, each a centre and a radius, and none left out.
    fn balls(coefficients: &[(f64, f64)]) -> Polynomial {
        Polynomial(coefficients.iter().map(|(c, radius)| Real::double(*c).widened(*radius)).collect())
    }

    /// By hand; doubles are exact here, and radii those of roundings.
    #[test]
    fn sums_products_and_quotients_are_those_of_the_coefficients() {
        let is = |found: &Polynomial, known: &[f64]| {
            assert_eq!(found.doubles(), known);
            assert!(found.radius() < 1e-50, "{found:?}");
        };
        let (p, nothing) = (polynomial(&[1, 2, 3]), polynomial(&[]));
        assert_eq!((p.degree(), polynomial(&[7]).degree(), polynomial(&[0, 0]).degree()), (Some(2), Some(0), None));
        assert_eq!(p.coefficients(), [1, 2, 3].map(Real::from));
        assert_eq!(p.at(&Real::from(2)).to_f64(), 17.0);
        assert_eq!(p.at_complex(Complex::new(0.0, 1.0)), Complex::new(-2.0, 2.0));
        // Degrees drop where leading coefficients cancel, and not in what tells how far apart two are.
        is(&p.minus(&polynomial(&[0, 5, 3])), &[1.0, -3.0]);
        is(&polynomial(&[0, 5]).minus(&p), &[-1.0, 3.0, -3.0]);
        is(&p.minus(&p), &[]);
        is(&p.difference(&p), &[0.0; 3]);
        is(&p.plus(&polynomial(&[4, 0, -3])), &[5.0, 2.0]);
        is(&polynomial(&[1, 2]).times(&polynomial(&[3, 0, 4])), &[3.0, 6.0, 4.0, 8.0]);
        is(&polynomial(&[2]).times(&polynomial(&[3])), &[6.0]);
        is(&p.times(&nothing), &[]);
        // x³ − x² + x − 6 = (x − 2)(x² + x + 3).
        is(&polynomial(&[-6, 1, -1, 1]).without_root(&Real::from(2)), &[3.0, 1.0, 1.0]);
        is(&polynomial(&[1, 2, 3, 4]).mirrored(), &[1.0, -2.0, 3.0, -4.0]);
        is(&polynomial(&[5, 3, 2, 7]).derivative(), &[3.0, 4.0, 21.0]);
        is(&polynomial(&[5]).derivative(), &[]);
        is(&polynomial(&[0, 1, 2]).reversed(), &[2.0, 1.0]);
        // 1 + 2z + 3z² + 4z³ at z = i√x is 1 − 3x + i√x (2 − 4x).
        is(&polynomial(&[1, 2, 3, 4]).modulus_on_imaginary_axis(), &[1.0, -2.0, -7.0, 16.0]);
        // 2x³ + 3x² + x + 5 = (2x + 3)(x² + 1) − x + 2.
        let (circle, line) = (polynomial(&[1, 0, 1]), polynomial(&[5, 2]));
        for (dividend, divisor, quotient, rest) in [
            (&polynomial(&[5, 1, 3, 2]), &circle, &[3.0, 2.0][..], &[2.0, -1.0][..]),
            (&line, &circle, &[], &[5.0, 2.0]),
            (&line, &polynomial(&[2]), &[2.5, 1.0], &[]),
            (&line, &nothing, &[], &[5.0, 2.0]),
        ] {
            let found = dividend.divided_by(divisor);
            is(&found.0, quotient);
            is(&found.1, rest);
        }
        // (x − 1)²(x + 2) and (x − 1)(x − 3).
        let common = polynomial(&[2, -3, 0, 1]).common_divisor(&polynomial(&[3, -4, 1]));
        assert!(common.degree() == Some(1) && common.at(&Real::one()).may_be_zero(), "{common:?}");
    }

    /// What may be zero at either end is, and between them stays what it is.
    #[test]
    fn the_centre_of_a_polynomial_has_zeros_at_its_ends_alone() {
        let p = balls(&[(0.05, 0.1), (2.0, 0.1), (0.05, 0.1), (3.0, 0.3), (0.05, 0.1)]);
        assert_eq!(p.centre().doubles(), [0.0, 2.0, 0.05, 3.0]);
        assert!(p.centre().radius() == 0.0 && (p.radius() - 0.3).abs() < 1e-12);
        assert_eq!(balls(&[(0.05, 0.1); 3]).centre(), polynomial(&[]));
        // x(x − 2) in the centre, and no other zero of 0.05 + 2x within a tenth.
        assert_eq!(balls(&[(0.05, 0.1), (-2.0, 0.0), (1.0, 0.0)]).certain_changes().len(), 1);
        let open = |coefficients: &[(f64, f64)]| is_left_open(&balls(coefficients).0);
        assert!(open(&[(0.0, 2e-3)]) && open(&[(0.0, 0.0), (1e-3, 2e-3)]));
        assert!(!open(&[(0.0, 5e-4)]) && !open(&[(0.0, 1.0), (1.0, 0.5)]) && !open(&[]));
    }

    /// (x − 1)(x + 2)(x − 3) = x³ − 2x² − 5x + 6, with 7x² before it too, and (x − s)(x − 2s) = x² − 3sx + 2s² of sizes s that
    /// leave little room in the range of doubles.
    #[test]
    fn roots_are_found_at_zero_and_at_any_size() {
        for none in [&[][..], &[5]] {
            assert_eq!(polynomial(none).roots(), []);
        }
        assert_eq!(polynomial(&[0, 0, 7]).roots(), [Complex::new(0.0, 0.0); 2]);
        let near = |p: &Polynomial, known: &[f64]| {
            let mut found: Vec<Complex<f64>> = p.roots();
            found.sort_by(|a, b| a.re.total_cmp(&b.re));
            let errors = found.iter().zip(known).map(|(z, x)| (z - Complex::new(*x, 0.0)).norm() / x.abs().max(1e-290));
            assert!(found.len() == known.len() && errors.clone().all(|error| error < 1e-12), "{found:?} for {known:?}");
        };
        near(&polynomial(&[6, -5, -2, 1]), &[-2.0, 1.0, 3.0]);
        near(&polynomial(&[0, 0, 42, -35, -14, 7]), &[-2.0, 0.0, 0.0, 1.0, 3.0]);
        near(&polynomial(&[-3, 2]), &[1.5]);
        // x (x + 0.7)(x − 1)(x − 1.2), and what rounding leaves in place of its zero.
        for rest in [0.0, 1e-57, -1e-30] {
            let c = [rest, 0.84, -0.34, -1.5, 1.0];
            let mut found: Vec<f64> = Polynomial(c.map(Real::double).to_vec()).roots().iter().map(|z| z.re).collect();
            found.sort_by(f64::total_cmp);
            let errors = found.iter().zip([-0.7, 0.0, 1.0, 1.2]).map(|(x, known)| (x - known).abs());
            assert!(errors.clone().all(|error| error < 1e-14), "{found:?}");
            if rest != 0.0 {
                let mut found: Vec<f64> = simultaneous(&c.map(|c| Complex::new(c, 0.0))).iter().map(|z| z.re).collect();
                found.sort_by(f64::total_cmp);
                let errors = found.iter().zip([-0.7, 0.0, 1.0, 1.2]).map(|(x, known)| (x - known).abs());
                assert!(errors.clone().all(|error| error < 1e-14), "{found:?}");
            }
        }
        for (size, factor) in [(1e150, 1e-150), (1e-150, 1e150), (1e100, 1.0), (1e-100, 1.0)] {
            let c = [2.0 * size * size * factor, -3.0 * size * factor, factor];
            near(&Polynomial(c.map(Real::double).to_vec()), &[size, 2.0 * size]);
            let mut found = simultaneous(&c.map(|c| Complex::new(c, 0.0)));
            found.sort_by(|a, b| a.re.total_cmp(&b.re));
            let errors = found.iter().zip([size, 2.0 * size]).map(|(z, x)| (z - x).norm() / x);
            assert!(errors.clone().all(|error| error < 1e-12), "{found:?} for {size:e}");
        }
        // The roots of unity: all of one modulus.
        let c = [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0].map(|c| Complex::new(c, 0.0));
        let found = simultaneous(&c);
        for k in 0..7 {
            let unit = Complex::from_polar(1.0, 2.0 * PI * f64::from(k) / 7.0);
            assert_eq!(found.iter().filter(|z| (*z - unit).norm() < 1e-13).count(), 1, "{found:?}");
        }
    }

    /// All of it where roots are equal, (x − 3)³ and (x + 2)², and 3/2 of 1 and 2.
    #[test]
    fn the_size_of_roots_is_no_more_than_the_largest() {
        for (c, size) in [
            (&[-27.0, 27.0, -9.0, 1.0][..], 3.0),
            (&[4.0, 4.0, 1.0], 2.0),
            (&[2.0, -3.0, 1.0], 1.5),
            (&[-4.0, 0.0, 1.0], 2.0),
            (&[0.0, 4.0, -8.0], 0.25),
        ] {
            assert!((size_of_roots(c) - size).abs() < 1e-12, "{c:?}: {}", size_of_roots(c));
        }
    }

    /// Fujiwara: twice the largest of |c₁/c₂| and |c₀/2c₂|^½, and a little more.
    #[test]
    fn the_bound_on_roots_is_fujiwaras() {
        for (c, twice) in [
            (&[-2.0, 1.0][..], 2.0),
            (&[6.0, -5.0, 1.0], 10.0),
            (&[-16.0, 1.0, 2.0], 4.0),
            (&[-8.0, 0.0, -50.0, 4.0], 25.0),
            (&[1.0, 128.0, 0.0, -2.0], 16.0),
        ] {
            assert!((bound(c) / twice - 1.0005).abs() < 1e-12, "{c:?}: {}", bound(c));
        }
    }

    /// (x − 1)⁷ is (k/2²⁰)⁷ where doubles find some multiple of 10⁻¹⁶ of either sign, and zero at 1.
    #[test]
    fn a_sign_that_doubles_do_not_tell_is_told_by_more_digits() {
        let p = (0..7).fold(polynomial(&[1]), |p, _| p.times(&polynomial(&[-1, 1])));
        let at = |p: &Polynomial, x: f64| p.sign_at(&p.doubles(), x);
        for k in -200_i32..=200 {
            for scale in [0.5_f64.powi(20), 1e-3, 1e2] {
                let x = 1.0 + f64::from(k) * scale;
                if x > 0.0 {
                    assert_eq!(at(&p, x), k.signum(), "{x}");
                }
            }
        }
        assert_eq!(
            (at(&polynomial(&[]), 1.0), at(&polynomial(&[-3]), 2.0), at(&polynomial(&[-3, 1]), 4.0)),
            (0, -1, 1)
        );
    }

    #[test]
    fn signs_change_at_roots_of_odd_multiplicity_and_beyond_zero() {
        for (coefficients, known) in [
            (&[][..], &[][..]),
            (&[5], &[]),
            (&[0, 0, 4], &[]),
            (&[1, 0, 1], &[]),
            (&[2, 3, 1], &[]),
            (&[-4, 0, 1], &[2.0]),
            (&[0, 0, 4, 0, -1], &[2.0]),
            // (x − 1)², (x − 1)³ and (x − 1)²(x − 3).
            (&[1, -2, 1], &[]),
            (&[-1, 3, -3, 1], &[1.0]),
            (&[-3, 7, -5, 1], &[3.0]),
            // −(x − 1)(x − 2)(x − 4), and (x + 1)(x − 2)(x − 3).
            (&[8, -14, 7, -1], &[1.0, 2.0, 4.0]),
            (&[6, 1, -4, 1], &[2.0, 3.0]),
        ] {
            let found = polynomial(coefficients).changes();
            let near = found.iter().zip(known).all(|(x, y): (&f64, &f64)| (x - y).abs() < 1e-14);
            assert!(near && found.len() == known.len(), "{coefficients:?}: {found:?}");
        }
    }

    /// From the middle to either side, in the exponent where an end is at 0 or infinity: part is 0, −1, 1, −2, 2, ….
    #[test]
    fn points_to_be_tried_lie_between_their_ends() {
        let parts = [0.0_f64, -1.0, 1.0, -2.0, 2.0];
        for (k, part) in (0..).zip(parts) {
            assert_eq!(between(0.0, f64::INFINITY, k), part.exp2());
            assert_eq!(between(0.0, 3.0, k), 3.0 / 2_f64.powi(k + 1));
            assert_eq!(between(3.0, f64::INFINITY, k), 3.0 + 3.0 * part.exp2());
            assert!((between(2.0, 8.0, k).log2() - (2.0 + part / 31.0)).abs() < 1e-14);
        }
        for (left, right) in [(0.0, f64::INFINITY), (0.0, 1.0), (1.0, f64::INFINITY), (1.0, 1.001)] {
            let mut points: Vec<f64> = (0..=PROBES).map(|k| between(left, right, k)).collect();
            points.sort_by(f64::total_cmp);
            points.dedup();
            assert!(points.len() == 61 && points[0] > left && points[60] < right, "{left}, {right}: {points:?}");
        }
    }

    #[test]
    fn a_gap_is_the_least_power_of_two_of_its_end_that_is_certain() {
        assert_eq!(gap(|open| open > 0.1, 1.0), 0.125);
        assert_eq!(gap(|open| open > 0.1, 3.0), 0.1875);
        assert_eq!(gap(|_| true, 1.0), f64::EPSILON);
        assert_eq!(gap(|open| open > 0.5, 1.0), 1.0);
    }

    /// Each with c₀ to within a radius E, by hand: `to` or `open` is the first of x/2ᵏ at which what is left is more than E.
    #[test]
    fn what_digits_leave_open_of_a_sign_is_told() {
        let of = |radius: f64, c: &[f64]| {
            let rest = c[1..].iter().map(|c| (*c, 0.0));
            first_negative(&[balls(&[(c[0], radius)].into_iter().chain(rest).collect::<Vec<_>>())])
        };
        let is_open = |found: Sign, end: f64| {
            assert!(matches!(found, Sign::Open { to } if (to - end).abs() < 1e-12), "{found:?} for {end}");
        };
        let is_negative = |found: Sign, known: [f64; 3]| {
            let Sign::NegativeFrom { from, open, at } = found else { panic!("{found:?} for {known:?}") };
            let near = [from, open, at].iter().zip(known).all(|(x, y)| (x - y).abs() < 1e-12);
            assert!(near, "{found:?} for {known:?}");
        };
        // Nothing is known of a constant, and nothing is there of one that vanishes to many digits.
        is_open(of(0.1, &[0.0]), 0.0);
        assert_eq!(of(1e-4, &[0.0]), Sign::NonNegative);
        // (x − 1)(x − 1.5) is −1/16 at least; o(o + ½) > 1/10 for o = ¼ and not for ⅛.
        is_open(of(0.1, &[1.5, -2.5, 1.0]), 0.75);
        // (x − 1)² − 10⁻⁷: two zeros so near, 1 ± 3·10⁻⁴, may be one, whatever there is a thousandth from it.
        assert_eq!(of(1e-6, &[1.0 - 1e-7, -2.0, 1.0]), Sign::NonNegative);
        assert_eq!(of(2e-6, &[1.0 - 1e-7, -2.0, 1.0]), Sign::NonNegative);
        // (x − 1)²: it is more than 10⁻⁹ a thousandth from 1, and o² > 1/10 for o = ½.
        assert_eq!(of(1e-9, &[1.0, -2.0, 1.0]), Sign::NonNegative);
        is_open(of(0.1, &[1.0, -2.0, 1.0]), 0.5);
        // x(x − 1)² and (9/8 − x)(x − 1)²: more than E a thousandth from 1 on one side alone.
        is_open(of(1e-6, &[0.0, 1.0, -2.0, 1.0]), 1.0 - 1.0 / 512.0);
        is_open(of(1.25e-7, &[1.125, -3.25, 3.125, -1.0]), 1.0 - 1.0 / 512.0);
        // o²(1 − o) > 0.06 for o = ½; o²(1 + o) would be for ¼.
        is_open(of(0.06, &[0.0, 1.0, -2.0, 1.0]), 0.5);
        // −x: 2⁻⁶ is more than a hundredth, and ½ less than 0.6.
        is_negative(of(0.0, &[0.0, -1.0]), [0.0, 0.0, 1.0]);
        is_negative(of(0.01, &[0.0, -1.0]), [0.0, 1.0 / 64.0, 1.0]);
        is_negative(of(0.6, &[0.0, -1.0]), [0.0, 1.0, 1.0]);
        // 1 − x³: 1 − (1 − o)³ > 0.35 for o = ¼, (1 + o)³ − 1 for ⅛.
        is_negative(of(0.35, &[1.0, 0.0, 0.0, -1.0]), [1.0, 0.25, 2.0]);
        // −(x − 1)(x − 3)²: o(2 + o)² > 0.8 for o = ¼, o(2 − o)² for ½.
        is_negative(of(0.8, &[9.0, -15.0, 7.0, -1.0]), [1.0, 0.5, 2.0]);
        // (x − 1)(x − 1.4): o(0.4 − o) is more than 0.0385 at the point in the middle, √1.4, and for no power of ½.
        is_negative(of(0.0385, &[1.4, -2.4, 1.0]), [1.0, 1.4_f64.sqrt() - 1.0, 1.4_f64.sqrt()]);
    }

    /// (1 − x)(2 − x) and (1 − x)(1 − x) as products of lines, and a line with a constant.
    #[test]
    fn the_sign_of_a_product_is_that_of_its_factors_together() {
        let of = |factors: &[&[i64]]| first_negative(&factors.iter().map(|c| polynomial(c)).collect::<Vec<_>>());
        let Sign::NegativeFrom { from, at, .. } = of(&[&[2, -1], &[1, -1]]) else { panic!("negative from 1 to 2") };
        assert!((from - 1.0).abs() < 1e-15 && (at - 2_f64.sqrt()).abs() < 1e-15);
        assert_eq!(of(&[&[1, -1], &[1, -1]]), Sign::NonNegative);
        assert_eq!(of(&[]), Sign::NonNegative);
        assert_eq!(of(&[&[], &[-1]]), Sign::NonNegative);
        assert!(matches!(of(&[&[-1], &[1, -1]]), Sign::NegativeFrom { from: 0.0, at: 0.5, .. }));
        assert!(matches!(of(&[&[-1], &[-1, 1], &[3]]), Sign::NegativeFrom { from, .. } if (from - 1.0).abs() < 1e-15));
    }

    /// (x − 1)(x − 2) and x − 1 to no digit fewer than there are, to thirty, and to fifteen that Euclid's division starts from.
    #[test]
    fn roots_are_divided_out_where_all_digits_are_given() {
        let rest = |size: f64, radius: f64| {
            let ball = |c: f64| (c * size, radius);
            balls(&[2.0, -3.0, 1.0].map(ball)).without_roots_of(&balls(&[-1.0, 1.0].map(ball)))
        };
        let found = rest(1.0, 0.0).expect("they are told");
        assert_eq!(found.doubles(), [-2.0, 1.0]);
        assert_eq!((rest(1.0, 1e-30), rest(1e-25, 5e-41)), (None, None));
    }
}
