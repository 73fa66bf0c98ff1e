//! Linear stability: R(z) of a Runge–Kutta method on v̇ = λ v, z = hλ, and what follows from it (\[HW96\] IV.3).

use nalgebra::Complex;

use super::polynomial::{EXACT, Polynomial, Sign, first_negative};
use super::real::{Real, dot};
use super::tableau::Numbers;
use experiments::measure::norm::{Extremes, larger};

/// How far stability reaches along an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reach {
    /// |R| ≤ 1 on all of it.
    Everything,
    /// Up to this |z|; 0 where |R| > 1 from the start.
    UpTo {
        /// The end of the interval.
        end: f64,
        /// How far off it may be for the digits that the coefficients have.
        open: f64,
        /// A point beyond it where |R| > 1.
        witness: f64,
    },
    /// Up to this |z| at least; of what is beyond, the digits do not tell.
    Open {
        /// The end of what is certain.
        to: f64,
    },
}

impl Reach {
    fn of(sign: Sign) -> Self {
        match sign {
            Sign::NonNegative => Self::Everything,
            Sign::NegativeFrom { from, open, at } => Self::UpTo { end: from, open, witness: at },
            Sign::Open { to } => Self::Open { to },
        }
    }

    /// Of |z| where it is one of |z|².
    fn rooted(self) -> Self {
        match self {
            Self::Everything => Self::Everything,
            Self::UpTo { end, open, witness } => {
                let (of_square, end) = (open, end.sqrt());
                // √(e² + x) − e without its cancellation.
                let open = of_square / ((end * end + of_square).sqrt() + end);
                Self::UpTo { end, open, witness: witness.sqrt() }
            }
            Self::Open { to } => Self::Open { to: to.sqrt() },
        }
    }
}

/// Why a method is not A-stable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unstable {
    /// A point in the closed left half-plane with |R| > 1, or a pole.
    At(Complex<f64>),
    /// The digits do not tell whether it is.
    Open,
}

/// The stability function R = N/D.
#[derive(Debug, Clone)]
pub struct StabilityFunction {
    /// N(z) = det(I − z A + z 1 bᵀ).
    pub numerator: Polynomial,
    /// D(z) = det(I − z A).
    pub denominator: Polynomial,
    /// How far the coefficients of N and of D beyond their last ones may be from zero, for which they are taken: of 1, z, z², ….
    dropped: Vec<f64>,
}

/// The coefficients of det(I − z A), by Faddeev and LeVerrier.
fn determinant(a: &[Vec<Real>]) -> Vec<Real> {
    let s = a.len();
    let mut m = vec![vec![Real::zero(); s]; s];
    let mut coefficients = vec![Real::one()];
    for k in 1..=s {
        // M ← A M + c I, then c ← −tr(A M)/k.
        let mut next: Vec<Vec<Real>> = product(a, &m);
        for (i, row) in next.iter_mut().enumerate() {
            row[i] = &row[i] + &coefficients[k - 1];
        }
        m = next;
        let trace: Real = (0..s).map(|i| dot(&a[i], &m.iter().map(|row| row[i].clone()).collect::<Vec<_>>())).sum();
        coefficients.push(&-&trace / &Real::from(k as i64));
    }
    coefficients
}

fn product(a: &[Vec<Real>], b: &[Vec<Real>]) -> Vec<Vec<Real>> {
    let columns: Vec<Vec<Real>> = (0..b.len()).map(|j| b.iter().map(|row| row[j].clone()).collect()).collect();
    a.iter().map(|row| columns.iter().map(|column| dot(row, column)).collect()).collect()
}

impl StabilityFunction {
    /// R of the method (A, `b`).
    pub fn new(numbers: &Numbers, b: &[Real]) -> Self {
        if numbers.a.iter().enumerate().all(|(i, row)| row[i + 1..].iter().all(Real::is_zero)) {
            return Self::of_triangular(numbers, b);
        }
        let shifted: Vec<Vec<Real>> =
            numbers.a.iter().map(|row| row.iter().zip(b).map(|(a, b)| a - b).collect()).collect();
        Self::of(determinant(&shifted), determinant(&numbers.a))
    }

    /// R where A is lower triangular: D is the product of its diagonal, and N that of D with the series 1 + Σ bᵀAᵏ⁻¹1 zᵏ. The
    /// determinants would widen what printed digits leave open by cancellation, until terms vanish in it.
    fn of_triangular(Numbers { a, .. }: &Numbers, b: &[Real]) -> Self {
        let mut denominator = vec![Real::one()];
        for (i, row) in a.iter().enumerate().filter(|(i, row)| !row[*i].is_zero()) {
            denominator.push(Real::zero());
            for k in (1..denominator.len()).rev() {
                denominator[k] = &denominator[k] - &(&row[i] * &denominator[k - 1]);
            }
        }
        let (mut series, mut power) = (vec![Real::one()], vec![Real::one(); b.len()]);
        for _ in b {
            series.push(dot(b, &power));
            power = a.iter().map(|row| dot(row, &power)).collect();
        }
        let term = |k: usize| (0..denominator.len().min(k + 1)).map(|j| &denominator[j] * &series[k - j]).sum();
        let numerator = (0..series.len()).map(term).collect();
        Self::of(numerator, denominator)
    }

    fn of(numerator: Vec<Real>, denominator: Vec<Real>) -> Self {
        let mut dropped = vec![0.0; numerator.len().max(denominator.len())];
        for coefficients in [&numerator, &denominator] {
            let beyond = coefficients.iter().rposition(|c| !c.may_be_zero()).map_or(0, |last| last + 1);
            for (sum, c) in dropped.iter_mut().zip(coefficients).skip(beyond) {
                *sum += c.to_f64().abs() + c.radius();
            }
        }
        Self { numerator: Polynomial::new(numerator), denominator: Polynomial::new(denominator), dropped }
    }

    /// Whether few digits leave it open that |R| > 1 at z, by what they leave of the leading coefficients.
    fn is_left_open_at(&self, z: Complex<f64>) -> bool {
        let open: f64 = self.dropped.iter().rev().fold(0.0, |sum, c| sum * z.norm() + c);
        open > EXACT && self.numerator.at_complex(z).norm() - self.denominator.at_complex(z).norm() <= open
    }

    /// R(z).
    pub fn at(&self, z: Complex<f64>) -> Complex<f64> {
        self.numerator.at_complex(z) / self.denominator.at_complex(z)
    }

    /// R(∞), infinite where R is.
    pub fn at_infinity(&self) -> f64 {
        let (n, d) = (self.numerator.coefficients(), self.denominator.coefficients());
        match (n.last(), d.last()) {
            (Some(_), Some(_)) if n.len() > d.len() => f64::INFINITY,
            (Some(last), Some(divisor)) if n.len() == d.len() => last.to_f64() / divisor.to_f64(),
            _ => 0.0,
        }
    }

    /// Whether |R(∞)| is certainly not 1.
    pub(super) fn is_told_from_one_at_infinity(&self) -> bool {
        let (n, d) = (self.numerator.coefficients(), self.denominator.coefficients());
        let (Some(last), Some(divisor)) = (n.last(), d.last()) else { return true };
        n.len() != d.len() || (!(last - divisor).may_be_zero() && !(last + divisor).may_be_zero())
    }

    /// How far few digits leave |D|² − |N|² open on the imaginary axis, where it is taken for zero in their place.
    pub(super) fn left_open(&self) -> Option<f64> {
        self.margin().left_open()
    }

    /// Poles of R: roots of D that are no roots of N.
    pub fn poles(&self) -> Vec<Complex<f64>> {
        if let Some(rest) = self.denominator.without_roots_of(&self.numerator) {
            return rest.roots();
        }
        // A common root cancels, to the digits given; a double root is known to half of those of a double.
        let cancels = |z: &Complex<f64>| {
            let size: f64 = self.numerator.doubles().iter().rev().fold(0.0, |sum, c| sum * z.norm() + c.abs());
            self.numerator.at_complex(*z).norm() <= 1e-7 * size
        };
        self.denominator.roots().into_iter().filter(|z| !cancels(z)).collect()
    }

    /// |D|² − |N|² at z = i√x.
    fn margin(&self) -> Polynomial {
        self.denominator.modulus_on_imaginary_axis().difference(&self.numerator.modulus_on_imaginary_axis())
    }

    /// How far |R(iy)| ≤ 1.
    pub fn imaginary_reach(&self) -> Reach {
        self.told(Reach::of(first_negative(&[self.margin()])).rooted(), |y| Complex::new(0.0, y))
    }

    /// How far |R(−x)| ≤ 1: D² − N² in factors, which have half its degree each, and none of its double roots twice.
    pub fn real_reach(&self) -> Reach {
        let (n, d) = (self.numerator.mirrored(), self.denominator.mirrored());
        self.told(Reach::of(first_negative(&[d.minus(&n), d.plus(&n)])), |x| Complex::new(-x, 0.0))
    }

    /// The same where the point beyond it that is shown is one.
    fn told(&self, reach: Reach, at: impl Fn(f64) -> Complex<f64>) -> Reach {
        match reach {
            Reach::UpTo { end, open, witness } if self.is_left_open_at(at(witness)) => {
                Reach::Open { to: (end - open).max(0.0) }
            }
            reach => reach,
        }
    }

    /// |R| ≤ 1 in the left half-plane, or a point there where it is not: bounded on the imaginary axis, no pole to the left of
    /// it, and bounded at infinity, by the maximum principle.
    ///
    /// # Errors
    /// A point in the closed left half-plane with |R| > 1, or that there may be one.
    pub fn is_a_stable(&self) -> Result<(), Unstable> {
        if let Some(pole) = self.poles().into_iter().find(|z| z.re <= 0.0) {
            return Err(Unstable::At(pole));
        }
        match self.imaginary_reach() {
            Reach::Everything => Ok(()),
            Reach::UpTo { witness, .. } => Err(Unstable::At(Complex::new(0.0, witness))),
            Reach::Open { .. } => match self.real_reach() {
                Reach::UpTo { witness, .. } => Err(Unstable::At(Complex::new(-witness, 0.0))),
                _ => Err(Unstable::Open),
            },
        }
    }

    /// Largest α in degrees with |R| ≤ 1 in the sector |arg(−z)| ≤ α, to a hundredth; `None` where not even the negative
    /// axis is in it.
    pub fn alpha(&self) -> Option<f64> {
        if self.is_a_stable().is_ok() {
            return Some(90.0);
        }
        // Beside a pole |R| is large.
        if self.real_reach() != Reach::Everything {
            return None;
        }
        let worst = |degrees: f64| {
            let direction = -Complex::from_polar(1.0, degrees.to_radians());
            (-160..=240).map(|k| self.at(direction * 10_f64.powf(f64::from(k) / 40.0)).norm()).largest()
        };
        // Roundoff of R where it is 1 is far below this. Between two of these points |R| may exceed 1 still.
        let poles: Vec<Complex<f64>> = self.poles().into_iter().filter(|z| z.re <= 0.0).collect();
        let is_stable = |degrees: f64| {
            poles.iter().all(|z| z.im.abs().atan2(-z.re).to_degrees() > degrees)
                && worst(degrees) <= 1.0 + 1e-12
                && !matches!(first_negative(&[self.margin_on_ray(degrees)]), Sign::NegativeFrom { .. })
        };
        // What holds on both rays of a sector without poles holds in all of it, by the maximum principle.
        let (mut low, mut high) = (0.0, 90.0);
        while high - low > 0.002 {
            let middle = 0.5 * (low + high);
            if is_stable(middle) { low = middle } else { high = middle }
        }
        Some(low)
    }

    /// |D|² − |N|² at z = −r e^{iφ}, a polynomial in r, for φ in degrees: |Σ p_k zᵏ|² = Σ p_j p_k (−r)^{j+k} cos (j − k)φ.
    fn margin_on_ray(&self, degrees: f64) -> Polynomial {
        let most = self.numerator.coefficients().len().max(self.denominator.coefficients().len());
        let mut cosines = vec![Real::one(), Real::double(degrees.to_radians().cos())];
        while cosines.len() < most {
            let m = cosines.len();
            cosines.push(&(&(&Real::from(2) * &cosines[1]) * &cosines[m - 1]) - &cosines[m - 2]);
        }
        let square = |p: &Polynomial| {
            let p = p.mirrored();
            let c = p.coefficients();
            let mut out = vec![Real::zero(); (2 * c.len()).saturating_sub(1)];
            for (j, a) in c.iter().enumerate() {
                for (k, b) in c.iter().enumerate() {
                    out[j + k] = &out[j + k] + &(&(a * b) * &cosines[j.abs_diff(k)]);
                }
            }
            Polynomial::new(out)
        };
        square(&self.denominator).minus(&square(&self.numerator))
    }

    /// Orders on v̇ = λ v of the method (A, `b`) that R belongs to: of the solution, and on oscillations of phase (dispersion) and amplitude
    /// (dissipation).
    pub fn linear_orders(&self, numbers: &Numbers, b: &[Real]) -> LinearOrders {
        let terms = 2 * self.denominator.coefficients().len().max(self.numerator.coefficients().len()) + 4;
        let defect = log_defect(numbers, b, terms);
        let of = |parity: Option<usize>| {
            let terms = defect.iter().enumerate().map(|(k, c)| (k + 1, c));
            SeriesOrder::of(terms.filter(|(k, _)| parity.is_none_or(|odd| k % 2 == odd)))
        };
        LinearOrders { solution: of(None), dispersion: of(Some(1)).on_axis(), dissipation: of(Some(0)).on_axis() }
    }
}

/// Coefficients of log R(z) − z for z, z², …, zⁿ, from R = 1 + Σ bᵀAᵏ⁻¹1 zᵏ. Each is uncertain by what its derivatives with respect to the
/// coefficients make of what these are uncertain by: arithmetic on balls forgets that the same coefficients stand in all terms, and
/// leaves of four digits nothing at z⁵.
fn log_defect(numbers: &Numbers, b: &[Real], n: usize) -> Vec<Real> {
    let s = b.len();
    let centres = |list: &[Real]| list.iter().map(Real::centre).collect::<Vec<_>>();
    let (a, weights): (Vec<Vec<Real>>, _) = (numbers.a.iter().map(|row| centres(row)).collect(), centres(b));
    // v_m = Aᵐ 1 and u_m = bᵀAᵐ.
    let mut right = vec![vec![Real::one(); s]];
    for m in 1..n {
        right.push(a.iter().map(|row| dot(row, &right[m - 1])).collect());
    }
    let mut r = vec![Real::one()];
    r.extend(right.iter().map(|v| dot(&weights, v)));
    // (log R)′ R = R′, coefficient by coefficient.
    let mut l = vec![Real::zero()];
    for k in 1..=n {
        let earlier: Real = (1..k).map(|j| &(&Real::from(j as i64) * &l[j]) * &r[k - j]).sum();
        l.push(&r[k] - &(&earlier / &Real::from(k as i64)));
    }
    l[1] = &l[1] - &Real::one();
    let open = open(numbers, b, &right, &r);
    l.split_off(1).into_iter().zip(open).map(|(l, open)| l.widened(open)).collect()
}

/// What the coefficients of log R for z, z², … are uncertain by: Σ |∂l_k/∂x| times what x is, over all coefficients x.
fn open(numbers: &Numbers, b: &[Real], right: &[Vec<Real>], r: &[Real]) -> Vec<f64> {
    // Terms of higher order are smaller by as many digits as there are; they are few where there are two.
    const HIGHER_ORDER: f64 = 1.1;
    let (s, n) = (b.len(), right.len());
    let doubles = |list: &[Real]| list.iter().map(Real::to_f64).collect::<Vec<_>>();
    let (right, r): (Vec<Vec<f64>>, _) = (right.iter().map(|v| doubles(v)).collect(), doubles(r));
    let a: Vec<Vec<f64>> = numbers.a.iter().map(|row| doubles(row)).collect();
    let mut left = vec![doubles(b)];
    for m in 1..n {
        left.push((0..s).map(|j| (0..s).map(|i| left[m - 1][i] * a[i][j]).sum()).collect());
    }
    // 1/R, for ∂ log R = ∂R/R.
    let mut inverse = vec![1.0];
    for k in 1..=n {
        inverse.push(-(1..=k).map(|j| r[j] * inverse[k - j]).sum::<f64>());
    }
    let mut open = vec![0.0; n];
    let mut add = |radius: f64, slope: &dyn Fn(usize) -> f64| {
        if radius == 0.0 {
            return;
        }
        let slopes: Vec<f64> = (1..=n).map(slope).collect();
        for k in 1..=n {
            let of_log: f64 = (1..=k).map(|j| slopes[j - 1] * inverse[k - j]).sum();
            open[k - 1] += HIGHER_ORDER * radius * of_log.abs();
        }
    };
    for (i, row) in numbers.a.iter().enumerate() {
        add(b[i].radius(), &|k| right[k - 1][i]);
        for (j, entry) in row.iter().enumerate() {
            add(entry.radius(), &|k| (0..k - 1).map(|m| left[m][i] * right[k - 2 - m][j]).sum());
        }
    }
    open
}

/// What the terms of an error in powers of z say of its order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SeriesOrder {
    /// The order, and the constant of the leading error.
    Leading(u32, f64),
    /// The error vanishes to all orders looked at, as that of the amplitude does for symmetric methods.
    Vanishing,
    /// The digits of the coefficients leave the order open.
    Open {
        /// How large a term may be that cannot be told from zero.
        by: f64,
        /// Order and constant of the first term that can.
        at_most: Option<(u32, f64)>,
    },
}

impl SeriesOrder {
    /// From the terms, each with its power of z.
    fn of<'a>(terms: impl Iterator<Item = (usize, &'a Real)>) -> Self {
        // Leading constants are larger, down to those of the methods of high order.
        const NOTHING: f64 = 1e-9;
        // Beside so much of the leading term, one of lower order would not be overlooked.
        const BESIDE: f64 = 0.1;
        let mut by = 0.0;
        for (k, x) in terms {
            if x.may_be_zero() {
                by = larger(by, x.radius());
                continue;
            }
            let leading = (k as u32 - 1, x.to_f64());
            if by <= BESIDE * leading.1.abs() {
                return Self::Leading(leading.0, leading.1);
            }
            return Self::Open { by, at_most: Some(leading) };
        }
        if by <= NOTHING { Self::Vanishing } else { Self::Open { by, at_most: None } }
    }

    /// The first term that is certainly there.
    pub fn first(self) -> Option<(u32, f64)> {
        match self {
            Self::Leading(order, constant) => Some((order, constant)),
            Self::Vanishing => None,
            Self::Open { at_most, .. } => at_most,
        }
    }

    /// On z = iy the term l zᵏ is l iᵏ yᵏ: of the phase for odd k, of the logarithm of the amplitude for even k.
    fn on_axis(self) -> Self {
        let turned = |(order, l): (u32, f64)| (order, if order.div_ceil(2) % 2 == 0 { l } else { -l });
        match self {
            Self::Leading(order, l) => Self::Leading(order, turned((order, l)).1),
            Self::Vanishing => self,
            Self::Open { by, at_most } => Self::Open { by, at_most: at_most.map(turned) },
        }
    }
}

/// Orders on v̇ = λ v, each with the constant of its leading error: of log R(z) − z at zᵖ⁺¹, and on z = iy, at yᵖ⁺¹, of arg R(iy) − y
/// and of |R(iy)| − 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearOrders {
    /// Of the solution.
    pub solution: SeriesOrder,
    /// Of the phase on oscillations.
    pub dispersion: SeriesOrder,
    /// Of the amplitude on oscillations.
    pub dissipation: SeriesOrder,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::{Body, Shipped};
    use crate::tableau::Place;

    /// Phase and amplitude of R on the imaginary axis, where the leading errors are near 1e-8.
    #[test]
    fn the_constants_of_phase_and_amplitude_are_those_of_the_stability_function() {
        let mut checked = 0;
        for name in [
            "rk4",
            "heun2",
            "kutta-38",
            "sdirk2",
            "tr-bdf2",
            "radau-iia2",
            "radau-iia3",
            "gauss1",
            "gauss2",
            "gauss3",
            "ssp-rk3",
            "implicit-euler",
            "lobatto-iiic3",
            "crouzeix3",
            "dormand-prince",
            "bogacki-shampine",
            "cash-karp",
        ] {
            let file = Shipped::by_name(name).expect("there").read().expect("well-formed");
            let Body::RungeKutta(tableau) = &file.body else { panic!("{name}") };
            let numbers = tableau.numbers();
            let r = StabilityFunction::new(&numbers, &numbers.b);
            let orders = r.linear_orders(&numbers, &numbers.b);
            let at = |y: f64| r.at(Complex::new(0.0, y));
            let phase = |y: f64| at(y).arg() - y;
            let amplitude = |y: f64| at(y).norm() - 1.0;
            let errors: [&dyn Fn(f64) -> f64; 2] = [&phase, &amplitude];
            for (found, error) in [orders.dispersion, orders.dissipation].into_iter().zip(errors) {
                let SeriesOrder::Leading(order, constant) = found else { continue };
                let y = (1e-8 / constant.abs()).powf(1.0 / f64::from(order + 1));
                let leading = constant * y.powi(order as i32 + 1);
                assert!((error(y) / leading - 1.0).abs() < 0.1, "{name}, order {order}: {} and {leading}", error(y));
                checked += 1;
            }
        }
        assert!(checked > 25, "{checked}");
    }

    /// Alexander's method of order 3 to a few digits. By hand, its error of the phase is −0.0154 y⁵: four digits tell it from zero, three leave
    /// too much of y³, and none of them makes it vanish. To ten digits, Gauss' method of two stages keeps the amplitude.
    #[test]
    fn an_order_is_told_where_the_digits_determine_it() {
        let orders = |text: &str| {
            let file = crate::file::MethodFile::parse("m.toml", "m", text).expect("well-formed");
            let Body::RungeKutta(tableau) = &file.body else { panic!("{text}") };
            let numbers = tableau.numbers();
            StabilityFunction::new(&numbers, &numbers.b).linear_orders(&numbers, &numbers.b)
        };
        let alexander = |digits: u32, [gamma, a21, b1, b2]: [&str; 4]| {
            orders(&format!(
                "digits = {digits}\na = [['{gamma}'], ['{a21}', '{gamma}'], ['{b1}', '{b2}', '{gamma}']]\nb = ['{b1}', '{b2}', '{gamma}']"
            ))
        };
        let SeriesOrder::Leading(4, constant) = alexander(4, ["0.4359", "0.2821", "1.2085", "-0.6444"]).dispersion
        else {
            panic!("four digits tell the order")
        };
        assert!((constant + 0.0154).abs() < 3e-4, "{constant}");
        let few = alexander(2, ["0.44", "0.28", "1.21", "-0.64"]);
        assert!(matches!(few.dispersion, SeriesOrder::Open { .. }), "{few:?}");
        let gauss = |small: &str, large: &str| {
            orders(&format!(
                "digits = {}\na = [['1/4', '{small}'], ['{large}', '1/4']]\nb = ['1/2', '1/2']",
                large.len() - 2
            ))
        };
        let ten = gauss("-0.0386751346", "0.5386751346");
        assert!(matches!(ten.dispersion, SeriesOrder::Leading(4, _)), "{ten:?}");
        assert_eq!(ten.dissipation, SeriesOrder::Vanishing);
        let four = gauss("-0.0387", "0.5387").dissipation;
        assert!(matches!(four, SeriesOrder::Open { .. }), "{four:?}");
    }

    /// Two ways to R of the same method, coefficient by coefficient, and R of the implicit midpoint rule.
    #[test]
    fn the_product_of_the_diagonal_and_the_series_are_the_determinants() {
        for name in ["rk4", "heun2", "sdirk2", "tr-bdf2", "dormand-prince"] {
            let file = Shipped::by_name(name).expect("there").read().expect("well-formed");
            let Body::RungeKutta(tableau) = &file.body else { panic!("{name}") };
            let numbers = tableau.numbers();
            let found = StabilityFunction::of_triangular(&numbers, &numbers.b);
            let shifted: Vec<Vec<Real>> =
                numbers.a.iter().map(|row| row.iter().zip(&numbers.b).map(|(a, b)| a - b).collect()).collect();
            for (one, other) in
                [(&found.denominator, determinant(&numbers.a)), (&found.numerator, determinant(&shifted))]
            {
                let other = Polynomial::new(other);
                let at = |p: &Polynomial, k: usize| p.coefficients().get(k).cloned().unwrap_or_else(Real::zero);
                for k in 0..=numbers.stages() {
                    let (one, other) = (at(one, k), at(&other, k));
                    assert!((&one - &other).may_be_zero(), "{name}, z^{k}: {} and {}", one.to_f64(), other.to_f64());
                }
            }
        }
        let half = || &Real::one() / &Real::from(2);
        let midpoint = Numbers { a: vec![vec![half()]], b: vec![Real::one()], c: vec![half()], b_hat: None };
        let found = StabilityFunction::new(&midpoint, &midpoint.b);
        assert_eq!((found.numerator.doubles(), found.denominator.doubles()), (vec![1.0, 0.5], vec![1.0, -0.5]));
    }

    /// R(z s) is unstable where R is, 1/s as far out: the (0, 3) Padé approximation 1/(1 − z + z²/2 − z³/6), A(88.23)-stable.
    #[test]
    fn the_angle_of_stability_does_not_depend_on_how_far_out_it_is_lost() {
        let alpha = |scale: f64| {
            let coefficients = [1.0, -1.0, 0.5, -1.0 / 6.0].iter().enumerate();
            let scaled = coefficients.map(|(k, c)| Real::double(c * scale.powi(k as i32))).collect();
            StabilityFunction::of(vec![Real::one()], scaled).alpha().expect("stable on the negative axis")
        };
        for scale in [1.0, 1e-3, 1e2, 1e-10] {
            assert!((alpha(scale) - 88.23).abs() < 0.01, "{scale}: {}", alpha(scale));
        }
    }

    /// To within a hundredth of each coefficient, |D|² is uncertain by more than by what it falls short of |N|² near 88.23°.
    #[test]
    fn an_angle_that_few_digits_leave_open_is_that_of_the_digits_as_they_stand() {
        for scale in [3.0, 3e-5] {
            let coefficients = [1.0, -1.0, 0.5, -1.0 / 6.0].iter().enumerate().map(|(k, c)| {
                let c = c * f64::powi(scale, k as i32);
                Real::double(c).widened(if k > 0 { 0.01 * c.abs() } else { 0.0 })
            });
            let found = StabilityFunction::of(vec![Real::one()], coefficients.collect()).alpha();
            assert!(found.is_some_and(|alpha| (alpha - 88.23).abs() < 0.1), "{scale}: {found:?}");
        }
    }

    /// |1 − x + x²/2| ≤ 1 up to 2, beyond which a third power that may be there would keep it so.
    #[test]
    fn an_end_that_a_lost_term_may_move_is_what_is_certain() {
        for third in [1.0, 0.1] {
            let half = &Real::one() / &Real::from(2);
            let terms = vec![Real::one(), Real::one(), half, Real::zero().widened(third)];
            let Reach::Open { to } = StabilityFunction::of(terms, vec![Real::one()]).real_reach() else {
                panic!("left open")
            };
            assert!((to - 2.0).abs() < 1e-9, "{to}");
        }
    }

    /// The same up to 2 where ½ is known to 0.01, so that the end is 1/0.51 at least, and with a third power of a hundredth: beyond the
    /// end it may still be 0.05 less at 2.05, and not 1.5 at 3.
    #[test]
    fn an_end_that_digits_leave_open_is_the_least_that_it_may_be() {
        let half = &Real::one() / &Real::from(2);
        let of = |half: Real, third: f64| {
            let terms = vec![Real::one(), Real::one(), half, Real::zero().widened(third)];
            StabilityFunction::of(terms, vec![Real::one()])
        };
        let Reach::Open { to } = of(half.clone().widened(0.01), 1.0).real_reach() else { panic!("left open") };
        assert!(to > 1.9 && to <= 1.0 / 0.51 + 1e-9, "{to}");
        let found = of(half, 0.01);
        assert_eq!([-2.05, -3.0].map(|x| found.is_left_open_at(Complex::new(x, 0.0))), [true, false]);
    }

    /// R = 1 + 3z/2 + 5z²/4 + z³/2 + z⁴/4 has |R(iy)|² = 1 − x(x − 1)²(4 − x)/16 with x = y², so that digits leave open whether it is more than 1
    /// at y = 1. On the negative axis R(−2) = 3 is.
    #[test]
    fn where_digits_leave_the_imaginary_axis_open_the_negative_one_may_refute() {
        let quarters = [4, 6, 5, 2, 1].map(|n| (&Real::from(n) / &Real::from(4)).widened(1e-3));
        let found = StabilityFunction::of(quarters.to_vec(), vec![Real::one()]);
        assert!(matches!(found.imaginary_reach(), Reach::Open { to } if to <= 1.0), "{:?}", found.imaginary_reach());
        let Err(Unstable::At(z)) = found.is_a_stable() else { panic!("{:?}", found.is_a_stable()) };
        assert!(z.im == 0.0 && z.re < -1.0 && found.at(z).norm() > 1.0, "{z}");
    }

    /// 1/(1 + z) has its pole at −1, and 1/(1 − z) at 1.
    #[test]
    fn beside_a_pole_on_the_negative_axis_there_is_no_sector() {
        let of = |c: i64| StabilityFunction::of(vec![Real::one()], vec![Real::one(), Real::from(c)]);
        assert_eq!([of(1).alpha(), of(-1).alpha()], [None, Some(90.0)]);
    }

    /// Of the series up to z⁴/24 it is −z⁵/120.
    #[test]
    fn the_first_term_of_a_series_is_the_leading_one_or_the_one_that_is_left() {
        let file = Shipped::by_name("rk4").expect("there").read().expect("well-formed");
        let Body::RungeKutta(tableau) = &file.body else { panic!("rk4") };
        let numbers = tableau.numbers();
        let orders = StabilityFunction::new(&numbers, &numbers.b).linear_orders(&numbers, &numbers.b);
        let (order, constant) = orders.solution.first().expect("an error");
        assert!(order == 4 && (constant + 1.0 / 120.0).abs() < 1e-15, "{order}: {constant}");
        assert_eq!(SeriesOrder::Vanishing.first(), None);
        assert_eq!(SeriesOrder::Open { by: 1.0, at_most: Some((2, 0.5)) }.first(), Some((2, 0.5)));
    }

    /// Nothing above 1 in the sector, however finely it is looked at, and something just outside of it.
    #[test]
    fn the_sector_of_stability_ends_where_the_stability_function_leaves_the_unit_disc() {
        for degree in [3, 4, 5] {
            let mut factorial = Real::one();
            let mut coefficients = vec![Real::one()];
            for k in 1..=degree {
                factorial = &factorial * &Real::from(-k);
                coefficients.push(&Real::one() / &factorial);
            }
            let pade = StabilityFunction::of(vec![Real::one()], coefficients);
            let alpha = pade.alpha().expect("stable on the negative axis");
            let largest = |degrees: f64| {
                let direction = Complex::from_polar(1.0, std::f64::consts::PI - degrees.to_radians());
                (0..40_000).map(|k| pade.at(direction * (0.01 * 1.000_3_f64.powi(k))).norm()).largest()
            };
            let (inside, outside) = (largest(alpha), largest(alpha + 0.004));
            assert!(inside <= 1.0 + 1e-12 && outside > 1.0, "{degree}: {alpha}, {inside:e}, {outside:e}");
        }
    }

    /// Of N = 1 + z/(1 + δ) and D = 1 + z, which eight decimals make.
    #[test]
    fn a_pole_is_cancelled_by_the_same_root_alone() {
        let poles = |apart: f64| {
            let line = |slope: f64| vec![Real::one(), Real::double(slope).widened(0.5e-8)];
            StabilityFunction::of(line(1.0 / (1.0 + apart)), line(1.0)).poles()
        };
        assert_eq!([0.0, 1e-9].map(|apart| poles(apart).len()), [0, 0]);
        for apart in [1e-6, 1e-3, 1e-2] {
            let [pole] = poles(apart)[..] else { panic!("{apart}") };
            assert!((pole + 1.0).norm() < 1e-12, "{pole}");
        }
    }

    /// |z|² of 9, and 7 more: √16 − 3 = 1.
    #[test]
    fn a_reach_of_squares_is_that_of_their_roots() {
        let square = Reach::UpTo { end: 9.0, open: 7.0, witness: 16.0 };
        assert_eq!(square.rooted(), Reach::UpTo { end: 3.0, open: 1.0, witness: 4.0 });
        assert_eq!(Reach::Open { to: 9.0 }.rooted(), Reach::Open { to: 3.0 });
        assert_eq!(Reach::Everything.rooted(), Reach::Everything);
    }

    /// (1 + az)/(1 + bz) → a/b.
    #[test]
    fn one_at_infinity_is_told_by_leading_coefficients_of_one_size() {
        let is_told = |numerator: &[i64], denominator: &[i64]| {
            let [n, d] = [numerator, denominator].map(|list| list.iter().map(|c| Real::from(*c)).collect::<Vec<_>>());
            StabilityFunction::of(n, d).is_told_from_one_at_infinity()
        };
        assert_eq!(
            [[1, 1], [1, -1], [1, 2], [2, -3]].map(|[a, b]| is_told(&[1, a], &[1, b])),
            [false, false, true, true]
        );
        assert!(is_told(&[1], &[1, 1]) && is_told(&[1, 1], &[1]));
    }

    /// N = f(1 + z/s(1 + δ)) and D = 1 + z/s to twelve digits.
    #[test]
    fn whether_a_pole_is_cancelled_does_not_depend_on_the_units() {
        for (factor, size) in [(1.0, 1.0), (1e3, 1.0), (1.0, 1e3)] {
            let poles = |apart: f64| {
                let line = |factor: f64, slope: f64| {
                    vec![Real::double(factor), Real::double(factor * slope).widened(1e-12 * factor * slope)]
                };
                let numerator = line(factor, 1.0 / (size * (1.0 + apart)));
                StabilityFunction::of(numerator, line(1.0, 1.0 / size)).poles().len()
            };
            assert_eq!([1e-9, 1e-5].map(poles), [0, 1], "{factor:e}, {size:e}");
        }
    }

    /// To first order, and a tenth for what is of higher order.
    #[test]
    fn terms_are_open_by_as_much_as_a_coefficient_moves_them() {
        const BY: f64 = 1e-8;
        let tenths = |list: [i64; 3]| list.map(|n| &Real::from(n) / &Real::from(10)).to_vec();
        let numbers = Numbers {
            a: [[3, -1, 2], [4, 2, -2], [5, 1, 3]].map(tenths).to_vec(),
            b: tenths([5, 2, 4]),
            c: tenths([4, 4, 9]),
            b_hat: None,
        };
        let with = |place: Place, change: &dyn Fn(&Real) -> Real| {
            let mut numbers = numbers.clone();
            let slot = numbers.at_mut(place).expect("there");
            *slot = change(slot);
            log_defect(&numbers, &numbers.b, 6)
        };
        let entries = (0..9).map(|k| Place::A(k / 3, k % 3));
        for place in entries.chain((0..3).map(Place::B)) {
            let still = with(place, &Real::clone);
            let moved = with(place, &|x| x + &Real::double(BY));
            let open = with(place, &|x| x.widened(BY));
            for (k, ((still, moved), open)) in still.iter().zip(&moved).zip(&open).enumerate() {
                let (apart, radius) = ((moved - still).to_f64().abs(), open.radius());
                assert!(
                    radius >= apart && radius <= 1.2 * apart + 1e-14,
                    "{place}, z^{}: {apart:e}, {radius:e}",
                    k + 1
                );
            }
        }
    }

    /// R of Gauss' method of seven stages, from X with ½ and three diagonals (\[HW96\] IV.5): with T e₁ = (1, …, 1) it is that of A = T X T⁻¹
    /// and b = e₁.
    #[test]
    fn orders_are_looked_for_as_far_as_a_method_of_so_many_stages_may_have_them() {
        const STAGES: usize = 7;
        let ratio = |n: i64, d: i64| &Real::from(n) / &Real::from(d);
        let x = |i: usize, j: usize| match (i, j) {
            (0, 0) => ratio(1, 2),
            (i, j) if j == i + 1 => Real::from(-1),
            (i, j) if i == j + 1 => ratio(1, 4 * (4 * (i * i) as i64 - 1)),
            _ => Real::zero(),
        };
        // T adds the first row to all others, and T⁻¹ subtracts all other columns from the first.
        let columns = |i: usize| {
            let rest: Real = (1..STAGES).map(|j| x(i, j)).sum();
            std::iter::once(&x(i, 0) - &rest)
                .chain((1..STAGES).map(|j| x(i, j)).collect::<Vec<_>>())
                .collect::<Vec<_>>()
        };
        let first = columns(0);
        let row = |i: usize| match i {
            0 => first.clone(),
            i => columns(i).iter().zip(&first).map(|(entry, above)| entry + above).collect(),
        };
        let a: Vec<Vec<Real>> = (0..STAGES).map(row).collect();
        let b: Vec<Real> = (0..STAGES).map(|i| Real::from(i64::from(i == 0))).collect();
        let numbers = Numbers { c: crate::tableau::row_sums(&a), a, b, b_hat: None };
        let orders = StabilityFunction::new(&numbers, &numbers.b).linear_orders(&numbers, &numbers.b);
        assert!(matches!(orders.solution, SeriesOrder::Leading(14, _)), "{orders:?}");
        assert_eq!(orders.dissipation, SeriesOrder::Vanishing);
    }
}
