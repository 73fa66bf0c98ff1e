//! Linear stability: R(z) of a Runge–Kutta method on v̇ = λ v, z = hλ, and what follows from it (\[HW96\] IV.3).

use nalgebra::Complex;

use super::polynomial::{Polynomial, Sign};
use super::real::{Real, dot};
use super::tableau::Numbers;
use crate::measure::norm::Extremes;

/// How far stability reaches along an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reach {
    /// |R| ≤ 1 on all of it.
    Everything,
    /// Up to this |z|; 0 where |R| > 1 from the start.
    UpTo {
        /// The end of the interval.
        end: f64,
        /// A point beyond it where |R| > 1.
        witness: f64,
    },
}

/// The stability function R = N/D.
#[derive(Debug, Clone)]
pub struct StabilityFunction {
    /// N(z) = det(I − z A + z 1 bᵀ).
    pub numerator: Polynomial,
    /// D(z) = det(I − z A).
    pub denominator: Polynomial,
}

/// det(I − z A), by Faddeev and LeVerrier.
fn determinant(a: &[Vec<Real>]) -> Polynomial {
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
    Polynomial::new(coefficients)
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
        Self { numerator: determinant(&shifted), denominator: determinant(&numbers.a) }
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
        Self { numerator: Polynomial::new(numerator), denominator: Polynomial::new(denominator) }
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

    /// Poles of R: roots of D that are no roots of N.
    pub fn poles(&self) -> Vec<Complex<f64>> {
        // A common root cancels; a double root is known to half of the digits.
        let cancels = |z: &Complex<f64>| {
            let size: f64 = self.numerator.doubles().iter().rev().fold(0.0, |sum, c| sum * z.norm() + c.abs());
            self.numerator.at_complex(*z).norm() <= 1e-7 * size
        };
        self.denominator.roots().into_iter().filter(|z| !cancels(z)).collect()
    }

    /// |D|² − |N|² at z = i√x.
    fn margin(&self) -> Polynomial {
        self.denominator.modulus_on_imaginary_axis().minus(&self.numerator.modulus_on_imaginary_axis())
    }

    /// How far |R(iy)| ≤ 1.
    pub fn imaginary_reach(&self) -> Reach {
        match self.margin().sign() {
            Sign::NonNegative => Reach::Everything,
            Sign::NegativeFrom { from, at } => Reach::UpTo { end: from.sqrt(), witness: at.sqrt() },
        }
    }

    /// How far |R(−x)| ≤ 1.
    pub fn real_reach(&self) -> Reach {
        let (n, d) = (self.numerator.mirrored(), self.denominator.mirrored());
        match d.times(&d).minus(&n.times(&n)).sign() {
            Sign::NonNegative => Reach::Everything,
            Sign::NegativeFrom { from, at } => Reach::UpTo { end: from, witness: at },
        }
    }

    /// |R| ≤ 1 in the left half-plane, or a point there where it is not: bounded on the imaginary axis, no pole to the left of
    /// it, and bounded at infinity, by the maximum principle.
    ///
    /// # Errors
    /// A point in the closed left half-plane with |R| > 1.
    pub fn is_a_stable(&self) -> Result<(), Complex<f64>> {
        if let Some(pole) = self.poles().into_iter().find(|z| z.re <= 0.0) {
            return Err(pole);
        }
        match self.imaginary_reach() {
            Reach::Everything => Ok(()),
            Reach::UpTo { witness, .. } => Err(Complex::new(0.0, witness)),
        }
    }

    /// Largest α in degrees with |R| ≤ 1 in the sector |arg(−z)| ≤ α, to a hundredth; `None` where not even the negative
    /// axis is in it.
    pub fn alpha(&self) -> Option<f64> {
        if self.is_a_stable().is_ok() {
            return Some(90.0);
        }
        if self.poles().iter().any(|z| z.re < 0.0 && z.im == 0.0) || self.real_reach() != Reach::Everything {
            return None;
        }
        let worst = |degrees: f64| {
            let direction = Complex::from_polar(1.0, std::f64::consts::PI - degrees.to_radians());
            (-160..=240).map(|k| self.at(direction * 10_f64.powf(f64::from(k) / 40.0)).norm()).largest()
        };
        // Roundoff of R where it is 1 is far below this, and |R| − 1 beyond the angle soon above.
        let is_stable = |degrees: f64| worst(degrees) <= 1.0 + 1e-12;
        let first = (1..=180).map(|k| 0.5 * f64::from(k)).find(|degrees| !is_stable(*degrees)).unwrap_or(90.0);
        let (mut low, mut high) = (first - 0.5, first);
        while high - low > 0.002 {
            let middle = 0.5 * (low + high);
            if is_stable(middle) { low = middle } else { high = middle }
        }
        Some(low)
    }

    /// Coefficients of log R(z) − z for z, z², …, zⁿ.
    fn log_defect(&self, n: usize) -> Vec<Real> {
        let get = |p: &Polynomial, k: usize| p.coefficients().get(k).cloned().unwrap_or_else(Real::zero);
        // R = N/D, and (log R)′ R = R′, coefficient by coefficient; D(0) = N(0) = 1.
        let (mut r, mut l) = (vec![Real::one()], vec![Real::zero()]);
        for k in 1..=n {
            let known: Real = (1..=k).map(|j| &get(&self.denominator, j) * &r[k - j]).sum();
            r.push(&get(&self.numerator, k) - &known);
            let earlier: Real = (1..k).map(|j| &(&Real::from(j as i64) * &l[j]) * &r[k - j]).sum();
            l.push(&r[k] - &(&earlier / &Real::from(k as i64)));
        }
        l[1] = &l[1] - &Real::one();
        l.split_off(1)
    }

    /// Orders on v̇ = λ v: of the solution, and on oscillations of phase (dispersion) and amplitude (dissipation), with the
    /// constants of their leading errors.
    pub fn linear_orders(&self) -> LinearOrders {
        let defect =
            self.log_defect(2 * self.denominator.coefficients().len().max(self.numerator.coefficients().len()) + 4);
        let first = |parity: Option<usize>| {
            let mut terms = defect.iter().enumerate().map(|(k, c)| (k + 1, c));
            terms
                .find(|(k, c)| parity.is_none_or(|odd| k % 2 == odd) && !c.may_be_zero())
                .map(|(k, c)| (k as u32 - 1, c.to_f64()))
        };
        // A term that vanishes is within a few roundings of the coefficients; one that may be zero and may be large says nothing.
        let coefficients = self.numerator.coefficients().iter().chain(self.denominator.coefficients());
        let vanishing = 4.0 * coefficients.map(Real::radius).largest();
        // On z = iy the term l z^k is l iᵏ yᵏ: of the phase for odd k, of the logarithm of the amplitude for even k.
        let on_axis = |parity: usize| {
            let mut terms = defect.iter().enumerate().filter(|(k, _)| (k + 1) % 2 == parity);
            let leading = terms.find(|(_, l)| !l.may_be_zero() || l.to_f64().abs() > vanishing);
            match leading {
                None => Leading::None,
                Some((order, l)) if l.may_be_zero() => Leading::Undetermined { order: order as u32 },
                Some((order, l)) => {
                    let sign = if order.div_ceil(2) % 2 == 0 { 1.0 } else { -1.0 };
                    Leading::Term { order: order as u32, constant: sign * l.to_f64() }
                }
            }
        };
        LinearOrders { solution: first(None), dispersion: on_axis(1), dissipation: on_axis(0) }
    }

    /// Whether |R| > 1 at z certainly, which is what a counterexample has to show.
    pub fn exceeds_one_at(&self, y: f64) -> bool {
        self.margin().at(&Real::double(y * y)).is_negative()
    }
}

/// Orders on v̇ = λ v, each with the constant of its leading error: of log R(z) − z at zᵖ⁺¹, and on z = iy, at yᵖ⁺¹, of arg R(iy) − y
/// and of |R(iy)| − 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearOrders {
    /// Of the solution.
    pub solution: Option<(u32, f64)>,
    /// Of the phase on oscillations.
    pub dispersion: Leading,
    /// Of the amplitude on oscillations.
    pub dissipation: Leading,
}

/// The leading term of an error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Leading {
    /// A term that is not zero.
    Term {
        /// The order.
        order: u32,
        /// The constant.
        constant: f64,
    },
    /// The term of this order may be zero and may be large, to the digits that the coefficients are given to.
    Undetermined {
        /// The order.
        order: u32,
    },
    /// The error vanishes to all orders looked at, as that of the amplitude does for symmetric methods.
    None,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::file::{Body, Shipped};

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
            let orders = r.linear_orders();
            let at = |y: f64| r.at(Complex::new(0.0, y));
            let phase = |y: f64| at(y).arg() - y;
            let amplitude = |y: f64| at(y).norm() - 1.0;
            let errors: [&dyn Fn(f64) -> f64; 2] = [&phase, &amplitude];
            for (found, error) in [orders.dispersion, orders.dissipation].into_iter().zip(errors) {
                let Leading::Term { order, constant } = found else { continue };
                let y = (1e-8 / constant.abs()).powf(1.0 / f64::from(order + 1));
                let leading = constant * y.powi(order as i32 + 1);
                assert!((error(y) / leading - 1.0).abs() < 0.1, "{name}, order {order}: {} and {leading}", error(y));
                checked += 1;
            }
        }
        assert!(checked > 25, "{checked}");
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
            let (numerator, denominator) = (Polynomial::new(vec![Real::one()]), Polynomial::new(scaled));
            StabilityFunction { numerator, denominator }.alpha().expect("stable on the negative axis")
        };
        for scale in [1.0, 1e-3, 1e2] {
            assert!((alpha(scale) - 88.23).abs() < 0.01, "{scale}: {}", alpha(scale));
        }
    }
}
