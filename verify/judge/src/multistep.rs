//! The kind `multistep`: Σ ρ_j v_{n+j} = h Σ σ_j f_{n+j} (\[HNW93\] III, \[HW96\] V).

use std::f64::consts::PI;
use std::sync::Arc;

use lsvi::{Integrator, VectorField};
use nalgebra::{Complex, DMatrix, Schur};

use super::analysis::{Analysis, Trial};
use super::claim::Property;
use super::exhibits::{coefficient_row, region, table};
use super::facts::{Facts, length, short, told, visible};
use super::polynomial::{EXACT, ITERATIONS, Polynomial, Sign, VANISHES, first_negative, is_left_open, simultaneous};
use super::problem::{Autonomous, Forced, Linear, NonAutonomous};
use super::real::Real;
use super::stepping;
use super::tableau::{Coefficient, Tableau};
use super::theory::Theory;
use super::verdict::{Finding, Kind, Verdict};
use evidence::{Cell, Check, Figure, Outcome, Table};
use experiments::kinds::{Principle, Stability};
use experiments::measure::decimal::counted;
use experiments::measure::norm::{Extremes, larger};
use experiments::method::Traits;
use experiments::problem::Window;

/// Coefficients as a file states them, the oldest step first.
#[derive(Debug, Clone)]
pub struct Multistep {
    /// Of the values.
    pub rho: Vec<Coefficient>,
    /// Of the slopes.
    pub sigma: Vec<Coefficient>,
    /// What makes the first values.
    pub start: Tableau,
    /// Its name.
    pub start_name: String,
}

impl Multistep {
    /// The order of the formula with its coefficients in reverse, where it converges so. Of a consistent formula the reverse is
    /// inconsistent: ρ'(1) changes its sign, and σ(1) does not.
    pub(super) fn order_reversed(&self) -> Option<u32> {
        let reversed = |list: &[Coefficient]| list.iter().rev().map(|x| x.real.clone()).collect::<Vec<_>>();
        let (rho, sigma) = (reversed(&self.rho), reversed(&self.sigma));
        let order = order_of(&residuals(&rho, &sigma), most(&rho, &sigma));
        (order > 0 && !is_unstable(&rho)).then_some(order)
    }

    pub(super) fn table(&self) -> Table {
        let columns: Vec<String> =
            std::iter::once(String::new()).chain((0..self.rho.len()).map(|j| format!("n + {j}"))).collect();
        let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
        let rows = vec![coefficient_row("ρ", &self.rho), coefficient_row("σ", &self.sigma)];
        table("coefficients", "The coefficients as the file has them.", &columns, rows)
    }
}

/// Largest order for which constants are made.
const MOST: u32 = 20;

/// What roots that are found to half the digits may be off by, where no exact division tells.
const RIM: f64 = 1e-7;

/// What is left of a polynomial, relative to its coefficients, at a double root that is found to half the digits.
const DOUBLE: f64 = 1e-6;

/// What angles in degrees are found to.
const ANGLE: f64 = 1e-4;

/// Whether the roots of ρ are in the closed unit disc, those on its rim simple.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Roots {
    Stable,
    /// A root outside.
    Outside(Complex<f64>),
    /// A double one on the rim.
    Double(Complex<f64>),
    /// A root that cannot be told from the rim.
    Undecided(Complex<f64>),
}

impl Roots {
    /// Exact for roots ±1, which are divided out, and for others on the rim where the coefficients are exact.
    fn of(polynomial: &Polynomial) -> Self {
        let mut rest = polynomial.clone();
        for at in [1_i64, -1] {
            for found in 0.. {
                if !rest.at(&Real::from(at)).may_be_zero() || rest.degree().is_none_or(|n| n == 0) {
                    break;
                }
                if found == 1 {
                    return Self::Double(Complex::new(at as f64, 0.0));
                }
                rest = rest.without_root(&Real::from(at));
            }
        }
        let on_rim = |p: &Polynomial| {
            let mut roots = p.roots();
            roots.retain(|z| (z.norm() - 1.0).abs() <= RIM);
            roots
        };
        // The sum 1 + RIM is rounded, and what lies beside it is to be outside or on the rim.
        if let Some(z) = rest.roots().into_iter().find(|z| z.norm() - 1.0 > RIM) {
            return Self::Outside(z);
        }
        let rim = on_rim(&rest);
        let Some(first) = rim.first() else { return Self::Stable };
        if rest.radius() > EXACT {
            return Self::Undecided(*first);
        }
        if let Some(z) = on_rim(&rest.repeated().reciprocal_part()).first() {
            return Self::Double(*z);
        }
        // A simple root with no other near it that has 1/z beside it is 1/z̄, and so on the rim.
        let simple = rest.squarefree();
        let (all, certain) = (on_rim(&simple), on_rim(&simple.reciprocal_part()));
        if all.len() == certain.len() { Self::Stable } else { Self::Undecided(*first) }
    }
}

/// Whether ρ with these coefficients has a root outside the unit disc, or a double one on its rim.
fn is_unstable(rho: &[Real]) -> bool {
    matches!(Roots::of(&Polynomial::new(rho.to_vec())), Roots::Outside(_) | Roots::Double(_))
}

/// Why a formula is not called A-stable.
#[derive(Debug, Clone, PartialEq)]
enum NotAStable {
    /// A θ at which Re ρ/σ(e^{iθ}) < 0, or a root of σ outside the unit disc.
    Because(String),
    /// The digits do not tell.
    Open,
}

/// All that follows from the coefficients.
#[derive(Debug)]
pub(super) struct MultistepTheory {
    rho: Polynomial,
    sigma: Polynomial,
    doubles: [Vec<f64>; 2],
    /// Σ_j j^q ρ_j − q Σ_j j^{q−1} σ_j over q!: 0 up to the order. Few digits may leave so much of a small σ(1) open that a quotient
    /// by it would not tell.
    residuals: Vec<Real>,
    /// The same over σ(1).
    constants: Vec<Real>,
    order: u32,
    /// The order that no formula of so many steps exceeds.
    most: u32,
    zero: Roots,
    start: Arc<Theory>,
    start_name: String,
    /// How far the digits leave Re ρ(ζ) σ̄(ζ) open on the unit circle where it is A-stable, or why it is not.
    a_stable: Result<f64, NotAStable>,
    alpha: Option<f64>,
    /// The intervals of −hλ > 0 that are stable.
    negative: Vec<[f64; 2]>,
    /// Largest root of σ: the growth for hλ → ∞.
    infinity: f64,
}

impl MultistepTheory {
    pub(super) fn new(method: &Multistep) -> Self {
        let reals = |list: &[Coefficient]| list.iter().map(|x| x.real.clone()).collect::<Vec<_>>();
        let (r, s) = (reals(&method.rho), reals(&method.sigma));
        let (residuals, most) = (residuals(&r, &s), most(&r, &s));
        let doubles = [&r, &s].map(|list| list.iter().map(Real::to_f64).collect::<Vec<_>>());
        let mut theory = Self {
            order: order_of(&residuals, most),
            most,
            constants: over_slopes(&residuals, &s),
            residuals,
            rho: Polynomial::new(r.clone()),
            sigma: Polynomial::new(s.clone()),
            doubles,
            zero: Roots::Stable,
            start: Arc::new(Theory::new(&method.start, None, None)),
            start_name: method.start_name.clone(),
            a_stable: Ok(0.0),
            alpha: None,
            negative: Vec::new(),
            infinity: 0.0,
        };
        theory.zero = Roots::of(&theory.rho);
        let explicit = theory.sigma.degree() != theory.rho.degree();
        theory.infinity =
            if explicit { f64::INFINITY } else { theory.sigma.roots().iter().map(|z| z.norm()).largest().max(0.0) };
        theory.a_stable = theory.a_stable(&r, &s);
        theory.negative = theory.negative(&r, &s);
        theory.alpha = theory.alpha();
        theory
    }

    /// Whether ρ has roots on the unit circle beside 1, on which errors do not die out for h → 0 (\[HNW93\] III.9).
    fn is_weakly_stable(&self) -> bool {
        let roots = self.rho.roots();
        let other = |z: &&Complex<f64>| (z.norm() - 1.0).abs() <= RIM && (*z - 1.0).norm() > RIM;
        self.zero == Roots::Stable && roots.iter().any(|z| other(&z))
    }

    fn steps(&self) -> usize {
        self.doubles[0].len() - 1
    }

    /// Whether the digits leave more constants open than can vanish.
    fn is_order_open(&self) -> bool {
        vanishing(&self.residuals) > self.most as usize + 1
    }

    /// The order with what starts it: starting values of order q have errors of order q + 1.
    fn started_order(&self) -> u32 {
        self.order.min(self.start.order_in_time + 1)
    }

    fn what_starts(&self) -> String {
        let (start, left) = (self.start.order_in_time, self.started_order());
        let so = match self.order.saturating_sub(1) {
            needed if left == self.order => format!("and {needed} is enough"),
            needed => format!("where {needed} is needed, so that order {left} is left"),
        };
        format!("{} has order {start}, {so}", self.start_name)
    }

    /// ρ/σ at e^{iθ}: the z = hλ with a root on the unit circle.
    fn locus(&self, theta: f64) -> Complex<f64> {
        let zeta = Complex::from_polar(1.0, theta);
        self.rho.at_complex(zeta) / self.sigma.at_complex(zeta)
    }

    /// The largest |ζ| with ρ(ζ) = z σ(ζ).
    fn growth(&self, z: Complex<f64>) -> f64 {
        let k = self.steps();
        let c: Vec<Complex<f64>> = self.doubles[0].iter().zip(&self.doubles[1]).map(|(r, s)| z * -*s + *r).collect();
        if c[k].norm() <= 1e-14 * c.iter().map(|c| c.norm()).largest() {
            return f64::INFINITY;
        }
        let entry = |i: usize, j: usize| match (i, j) {
            (i, j) if j + 1 == k => -c[i] / c[k],
            (i, j) if i == j + 1 => Complex::new(1.0, 0.0),
            _ => Complex::new(0.0, 0.0),
        };
        let schur = Schur::try_new(DMatrix::from_fn(k, k, entry), f64::EPSILON, ITERATIONS * k);
        match schur.and_then(|schur| schur.eigenvalues()) {
            Some(roots) => roots.iter().map(|z| z.norm()).largest(),
            None => simultaneous(&c).iter().map(|z| z.norm()).largest(),
        }
    }

    /// Re ρ(ζ) σ̄(ζ) ≥ 0 on the unit circle and no root of σ outside: with x = cos θ = (1 − s)/(1 + s) the former is a polynomial in
    /// s ≥ 0.
    fn a_stable(&self, r: &[Real], s: &[Real]) -> Result<f64, NotAStable> {
        if self.infinity > 1.0 + RIM {
            return Err(NotAStable::Because(match self.infinity {
                f64::INFINITY => "it is explicit".into(),
                largest => format!("σ has a root of modulus {largest:.6}: solutions grow for hλ → ∞"),
            }));
        }
        let k = self.steps();
        let pairs = |m: usize| {
            let pair = |j: usize| if m == 0 { &r[j] * &s[j] } else { &(&r[j] * &s[j + m]) + &(&r[j + m] * &s[j]) };
            (0..=k - m).map(pair).sum()
        };
        let terms: Vec<Real> = (0..=k).map(pairs).collect();
        if is_left_open(&terms) {
            return Err(NotAStable::Open);
        }
        let open = Some(terms.iter().map(Real::radius).sum()).filter(|open| *open > EXACT).unwrap_or(0.0);
        match first_negative(&[chebyshev([1, -1], terms)]) {
            // A root of σ so near to the rim may lie outside.
            Sign::NonNegative if matches!(Roots::of(&self.sigma), Roots::Undecided(_)) => Err(NotAStable::Open),
            Sign::NonNegative => self.leaves_at_infinity().map_or(Ok(open), |zeta| {
                let from = complex(zeta);
                Err(NotAStable::Because(format!(
                    "for hλ → −∞ a root leaves the unit disc at {from}, where σ has a root on the rim"
                )))
            }),
            Sign::Open { .. } => Err(NotAStable::Open),
            Sign::NegativeFrom { at, .. } => {
                let z = self.locus(angle(at));
                let place = format!("{:.5} {:+.5}i", z.re, z.im);
                Err(NotAStable::Because(format!("the root locus enters the left half-plane: |ζ| = 1 at hλ = {place}")))
            }
        }
    }

    /// A root of σ on the unit circle that a root of ρ − zσ comes to from outside for z → −∞. That is ζ + ρ/(zσ') to first order, so that it
    /// comes from inside where ρ(ζ)/(ζσ'(ζ)) > 0; of a double root of σ the roots about it go all ways.
    fn leaves_at_infinity(&self) -> Option<Complex<f64>> {
        let size = |p: &Polynomial| p.doubles().iter().map(|c| c.abs()).sum::<f64>();
        let slope = self.sigma.derivative();
        self.sigma.roots().into_iter().filter(|zeta| (zeta.norm() - 1.0).abs() <= RIM).find(|zeta| {
            let (value, slope_there) = (self.rho.at_complex(*zeta), *zeta * slope.at_complex(*zeta));
            // A root of ρ as well is one for all z, to which σ adds nothing.
            let is_common = value.norm() <= DOUBLE * size(&self.rho);
            let is_double = slope_there.norm() <= DOUBLE * size(&slope);
            !is_common && (is_double || (value / slope_there).re < 0.0)
        })
    }

    /// The negative axis is in the region, and no part of the root locus in the sector about it.
    fn alpha(&self) -> Option<f64> {
        let is_bounded = self.negative == [[0.0, f64::INFINITY]];
        if self.zero != Roots::Stable || self.infinity > 1.0 + RIM || !is_bounded {
            return None;
        }
        if self.a_stable.is_ok() {
            return Some(90.0);
        }
        let angle = |theta: f64| {
            let z = self.locus(theta);
            // At θ → 0 the locus is the imaginary axis to roundoff.
            if z.re < -1e-9 { z.im.abs().atan2(-z.re) } else { 0.5 * PI }
        };
        let width = PI / 4000.0;
        let coarse = (1..4000).map(|k| f64::from(k) * width).min_by(|x, y| angle(*x).total_cmp(&angle(*y)))?;
        let theta = experiments::measure::search::minimum([coarse - width, coarse + width], 0.0, angle);
        Some(angle(theta).min(angle(coarse)).to_degrees()).filter(|alpha| *alpha > 0.0)
    }

    /// The stable intervals of the negative axis. They end where a root ζ is on the unit circle: for ζ = 1, which is at 0 where ρ(1) = 0, for ζ = −1, and where
    /// Im ρ(ζ) σ̄(ζ) changes its sign, which over sin θ is a polynomial in cos θ.
    fn negative(&self, r: &[Real], s: &[Real]) -> Vec<[f64; 2]> {
        let k = self.steps();
        let pairs = |m: usize| (0..=k - m).map(|j| &(&r[j + m] * &s[j]) - &(&r[j] * &s[j + m])).sum();
        let angles = chebyshev([2, -2], (1..=k).map(pairs).collect()).certain_changes().into_iter().map(angle);
        let mut ends: Vec<f64> = angles.chain([0.0, PI]).map(|theta| -self.locus(theta).re).collect();
        // Nearer to 0 than that, growth is not told from 1: the end is 0 itself, but for rounding.
        // As far away, it is infinity, at a root of σ.
        ends.retain(|x| *x > BOUNDED && *x < BOUNDED.recip());
        ends.sort_by(f64::total_cmp);
        let mut found: Vec<[f64; 2]> = Vec::new();
        let mut left = 0.0;
        for right in ends.into_iter().chain([f64::INFINITY]) {
            let inner = match (left, right) {
                (0.0, f64::INFINITY) => 1.0,
                (_, f64::INFINITY) => 2.0 * left,
                _ => 0.5 * (left + right),
            };
            if self.growth(Complex::new(-inner, 0.0)) <= 1.0 + BOUNDED {
                match found.last_mut() {
                    Some(before) if before[1] >= left => before[1] = right,
                    _ => found.push([left, right]),
                }
            }
            left = right;
        }
        found
    }
}

/// What a modulus of 1 may be off by in double precision.
const BOUNDED: f64 = 1e-9;

/// θ where cos θ = (1 − s)/(1 + s).
fn angle(s: f64) -> f64 {
    2.0 * s.sqrt().atan()
}

/// (1 + s)ⁿ Σ c_m p_m(x) at x = (1 − s)/(1 + s), for n + 1 terms and p_0 = 1, p_m = 2x p_{m−1} − p_{m−2}, from (1 + s) p_1: cos mθ where
/// this is x, and sin (m + 1)θ / sin θ where it is 2x.
fn chebyshev(first: [i64; 2], terms: Vec<Real>) -> Polynomial {
    let p = |c: &[i64]| Polynomial::new(c.iter().map(|c| Real::from(*c)).collect());
    let (twice, square, one) = (p(&[2, -2]), p(&[1, 2, 1]), p(&[1, 1]));
    let mut basis = vec![p(&[1]), p(&first)];
    while basis.len() < terms.len() {
        let m = basis.len();
        basis.push(twice.times(&basis[m - 1]).minus(&square.times(&basis[m - 2])));
    }
    let n = terms.len();
    let scaled = |(m, c): (usize, Real)| (m + 1..n).fold(Polynomial::new(vec![c]), |power, _| power.times(&one));
    let products = terms.into_iter().enumerate().map(scaled).zip(&basis);
    products.fold(Polynomial::new(Vec::new()), |sum, (power, base)| sum.plus(&base.times(&power)))
}

/// `−1`, or `0 + 1i` to five places.
fn complex(z: Complex<f64>) -> String {
    if z.im == 0.0 { short(z.re) } else { format!("{} {:+.5}i", short(z.re), z.im) }
}

/// The order of k steps that no formula exceeds, with the new slope or without (\[HNW93\] III.3).
fn most(r: &[Real], s: &[Real]) -> u32 {
    let (k, is_explicit) = (r.len() as u32 - 1, s.last().is_none_or(Real::may_be_zero));
    (2 * k).saturating_sub(u32::from(is_explicit)).min(MOST)
}

/// The largest p up to which all residuals may vanish, and no more than `most`.
fn order_of(residuals: &[Real], most: u32) -> u32 {
    (vanishing(residuals).saturating_sub(1) as u32).min(most)
}

/// How many residuals may vanish before the first that does not.
fn vanishing(residuals: &[Real]) -> usize {
    residuals.iter().take_while(|c| c.may_be_zero()).count()
}

/// Residuals over σ(1), where that is not zero.
fn over_slopes(residuals: &[Real], s: &[Real]) -> Vec<Real> {
    let total: Real = s.iter().sum();
    residuals.iter().map(|c| if total.may_be_zero() { c.clone() } else { c / &total }).collect()
}

fn residuals(r: &[Real], s: &[Real]) -> Vec<Real> {
    let power = |j: usize, q: u32| (0..q).fold(Real::one(), |p, _| &p * &Real::from(j as i64));
    let mut factorial = Real::one();
    let mut out = Vec::new();
    for q in 0..=MOST {
        if q > 0 {
            factorial = &factorial * &Real::from(i64::from(q));
        }
        let values: Real = r.iter().enumerate().map(|(j, r)| r * &power(j, q)).sum();
        let slopes: Real = match q {
            0 => Real::zero(),
            q => s.iter().enumerate().map(|(j, s)| s * &(&power(j, q - 1) * &Real::from(i64::from(q)))).sum(),
        };
        out.push(&(&values - &slopes) / &factorial);
    }
    out
}

impl Analysis for MultistepTheory {
    fn kind(&self) -> &'static str {
        "multistep"
    }

    fn headline(&self) -> String {
        let shape = if self.infinity == f64::INFINITY { "explicit" } else { "implicit" };
        let steps = counted(self.steps(), "step");
        format!("linear multistep, {shape}, {steps}, started by {}", self.start_name)
    }

    fn order(&self) -> u32 {
        self.order
    }

    fn lowered(&self) -> Option<String> {
        (self.started_order() < self.order).then(|| format!("its start {}", self.what_starts()))
    }

    fn facts(&self) -> Facts {
        let constant = self.constants.get(self.order as usize + 1).map_or_else(|| "0".into(), |c| told(c, 4));
        let order = match vanishing(&self.residuals) {
            0 => format!("0, C_0 = {} does not vanish", told(&self.constants[0], 4)),
            _ if self.is_order_open() => format!("open for the digits given, {} at most", self.order),
            _ => format!("{}, error constant {constant}", self.order),
        };
        let zero = match self.zero {
            Roots::Stable => "the root condition holds".into(),
            Roots::Outside(z) => format!("ρ has the root {:.5} {:+.5}i, |ζ| = {:.5}", z.re, z.im, z.norm()),
            Roots::Double(z) => format!("ρ has {} as a double root", complex(z)),
            Roots::Undecided(z) => format!("whether |ζ| = 1 at the root {:.5} {:+.5}i is open", z.re, z.im),
        };
        let stability = match self.alpha {
            _ if self.a_stable == Err(NotAStable::Open) => "whether it is A-stable is open for the digits given".into(),
            Some(90.0) if self.a_stable.as_ref().is_ok_and(|open| *open > 0.0) => "A-stable to the digits given".into(),
            Some(90.0) => "A-stable".into(),
            Some(alpha) => format!("A(α)-stable with α = {alpha:.2}°"),
            None => self.negative_axis(),
        };
        let infinity = match self.infinity {
            f64::INFINITY => "grows without bound for hλ → ∞".into(),
            x => format!("|ζ| = {} for hλ → ∞", visible(x)),
        };
        vec![("order", order), ("zero", zero), ("stability", format!("{stability}; {infinity}"))]
    }

    fn find(&self, property: Property) -> Option<Finding> {
        Some(match property {
            Property::Order(p) if self.is_order_open() => {
                let (steps, most) = (counted(self.steps(), "step"), self.most);
                let why = format!(
                    "the digits given leave C_0 to C_{} open, and no order of {steps} is above {most}",
                    most + 1
                );
                if p > most { Finding::new(false, why) } else { Finding::open(why) }
            }
            Property::Order(p) if p < self.order && self.constants[p as usize + 1].radius() > VANISHES => {
                let radius = self.constants[p as usize + 1].radius();
                Finding::open(format!(
                    "C_0 to C_{p} vanish, and the digits given leave C_{} open by {radius:.0e}",
                    p + 1
                ))
            }
            Property::Order(p) => {
                let first = self.order + 1;
                let radius = || self.constants[..first as usize].iter().map(Real::radius).largest();
                let why = match self.constants.get(first as usize) {
                    Some(c) if vanishing(&self.residuals) == 0 => {
                        format!("C_0 = {} does not vanish, and C_1 is {}", told(&self.constants[0], 4), told(c, 4))
                    }
                    Some(c) if self.order == 0 => {
                        format!("C_0 vanishes to within {:.0e}, C_1 = {}", radius(), told(c, 4))
                    }
                    Some(c) => {
                        let and = if self.order == 1 { "and" } else { "to" };
                        let constants = format!("C_0 {and} C_{}", self.order);
                        format!("{constants} vanish to within {:.0e}, C_{first} = {}", radius(), told(c, 4))
                    }
                    None => format!("all constants looked at vanish, to C_{MOST}"),
                };
                Finding::new(p == self.order, why).measured(self.order)
            }
            Property::ZeroStable => match self.zero {
                Roots::Stable => Finding::new(true, "the roots of ρ are in the unit disc, those on its rim simple"),
                Roots::Double(z) => {
                    Finding::new(false, format!("ρ has {} as a double root", complex(z))).measured(z.norm())
                }
                Roots::Outside(z) => {
                    let why = format!("ρ has the root {:.6} {:+.6}i of modulus {:.6}", z.re, z.im, z.norm());
                    Finding::new(false, why).measured(z.norm())
                }
                Roots::Undecided(z) => Finding {
                    outcome: Outcome::Inconclusive,
                    measured: Some(z.norm()),
                    why: "a root of ρ cannot be told from the unit circle".into(),
                },
            },
            Property::Explicit => {
                let explicit = self.infinity == f64::INFINITY;
                Finding::new(explicit, if explicit { "σ has no slope of the new step" } else { "σ has the new slope" })
            }
            Property::AStable => self.a_stable_finding(),
            Property::AlphaStable(angle) => match self.alpha {
                // A right angle is A-stability.
                Some(_) if angle.value >= 90.0 => self.a_stable_finding(),
                Some(_) if larger(self.rho.radius(), self.sigma.radius()) > VANISHES => {
                    Finding::open("the digits given do not tell how wide the sector is")
                }
                Some(alpha) => {
                    let (outcome, words) = angle.is_reached(alpha, ANGLE);
                    let why = format!("the root locus leaves the sector |arg(−hλ)| < {alpha:.3}° free{words}");
                    Finding { outcome, measured: Some(alpha), why }
                }
                None => Finding::new(false, "not even the negative axis is in the region of stability"),
            },
            Property::LStable => match self.a_stable_finding() {
                finding if finding.outcome != Outcome::Pass => finding,
                _ if self.infinity == 0.0 => Finding::new(true, "A-stable, and σ has no root but 0"),
                _ => Finding::new(false, format!("σ has a root of modulus {}", visible(self.infinity)))
                    .measured(self.infinity),
            },
            Property::Symmetric => {
                // ρ_j = −ρ_{k−j} and σ_j = σ_{k−j}: the formula is the same backwards in time.
                let k = self.steps();
                let at = |p: &Polynomial, j: usize| p.coefficients().get(j).cloned().unwrap_or_else(Real::zero);
                let odd = |j: usize| (&at(&self.rho, j) + &at(&self.rho, k - j)).may_be_zero();
                let even = |j: usize| (&at(&self.sigma, j) - &at(&self.sigma, k - j)).may_be_zero();
                let why = match ((0..=k).find(|j| !odd(*j)), (0..=k).find(|j| !even(*j))) {
                    (None, None) => "ρ_j = −ρ_{k−j} and σ_j = σ_{k−j} for all j".to_owned(),
                    (Some(j), _) => format!("ρ_{j} is not −ρ_{}", k - j),
                    (_, Some(j)) => format!("σ_{j} is not σ_{}", k - j),
                };
                Finding::new((0..=k).all(|j| odd(j) && even(j)), why)
            }
            _ => return None,
        })
    }

    /// A method that is not zero-stable does not converge, whatever its order; and one that is may be started badly.
    fn consistency(&self) -> Vec<Verdict> {
        let verdict = |subject: &str, statement: &str, finding: Finding| {
            let check = Check {
                id: subject.replace(' ', "-"),
                statement: statement.into(),
                outcome: finding.outcome,
                measured: finding.measured,
                required: None,
                reason: finding.why,
            };
            Verdict { kind: Kind::Consistency, subject: subject.into(), check }
        };
        let mut out = Vec::new();
        out.extend(self.find(Property::ZeroStable).map(|finding| {
            // Dahlquist: convergent if and only if zero-stable and consistent.
            let and = if finding.outcome == Outcome::Pass { "but" } else { "and" };
            let inconsistent = format!("{}, {and} it is not consistent: its order is 0", finding.why);
            let finding = if self.order == 0 { Finding::new(false, inconsistent) } else { finding };
            verdict("convergence", "It is zero-stable and consistent, without which it does not converge", finding)
        }));
        let keeps = Finding::new(self.started_order() == self.order, self.what_starts());
        out.push(verdict("start", "The starting procedure keeps the order", keeps));
        out
    }

    fn traits(&self) -> Traits {
        let stability = match self.alpha {
            _ if self.zero != Roots::Stable => Stability::Unstable,
            Some(_) if self.infinity < 0.95 => Stability::Damping,
            Some(_) => Stability::Neutral,
            None => Stability::Conditional,
        };
        let stiff_order = (stability == Stability::Damping).then(|| self.started_order());
        Traits { stiff_order, ..Traits::new(self.started_order(), Principle::Equation, stability) }
    }

    /// Weights of ρ that do not add up to zero change values in every step.
    fn rounding_of_coefficients(&self, size: f64, length: f64, steps: f64) -> f64 {
        let [values, slopes @ ..] = &self.constants[..=self.order as usize] else { return 0.0 };
        values.radius() * size * steps + slopes.iter().map(Real::radius).largest().max(0.0) * length
    }

    fn unknowns(&self) -> usize {
        3
    }

    fn on_field<'a>(&self, field: Box<dyn VectorField + 'a>) -> Result<Box<dyn Integrator + 'a>, String> {
        let [rho, sigma] = self.doubles.clone();
        let field: Arc<dyn VectorField + 'a> = Arc::from(field);
        let start = self.start.on_field(Box::new(Arc::clone(&field)))?;
        Ok(Box::new(stepping::Multistep::new(rho, sigma, field, start)?))
    }

    fn trials(&self) -> Vec<Trial> {
        let k = self.steps() as f64;
        let (order, from) = (self.started_order(), "the constants C_q and the start");
        if let Some(why) = self.obstacle() {
            let plan = Err(format!("{why}: there is no order to measure"));
            return vec![Trial { kind: "nonlinear", name: "v̇ = f(v)", plan }];
        }
        // All the steps of a formula, k h, are short beside the solution.
        let window = Window { horizon: 2.0, coarsest: 0.25_f64.min(0.4 / k) };
        let none = |reason: &str| Trial { kind: "stiff", name: "prothero-robinson", plan: Err(reason.into()) };
        let stiff = match self.alpha {
            Some(_) if self.infinity < 0.95 && self.order <= 2 => Trial::stiff(Some(order), from),
            Some(_) if self.infinity < 0.95 => none("the errors, divided by λ, are at roundoff before they settle"),
            Some(_) => Trial::stiff(None, "nothing damps for hλ → ∞"),
            None => none("not the whole negative axis is in the region of stability: hλ must stay of order 1"),
        };
        // Where ρ has other roots on the rim, their components of the error grow while a solution decays: on oscillations they do not.
        let is_weak = self.is_weakly_stable();
        let nonlinear = match is_weak || self.order > 4 {
            true => Trial::on("nonlinear", "pendulum", &[], order, from),
            false => Trial::of(("nonlinear", "v̇ = f(v)"), Autonomous, window, order, from),
        };
        let in_time = if self.order > 4 {
            let why = "its solution has a pole a time of 1 away: before the order settles, errors are at roundoff";
            Trial { kind: "non-autonomous", name: "v̇ = f(t, v)", plan: Err(why.into()) }
        } else if is_weak {
            Trial::of(Forced::NAME, Forced, window, order, from)
        } else {
            Trial::of(("non-autonomous", "v̇ = f(t, v)"), NonAutonomous, window, order, from)
        };
        let linear = if is_weak { Linear::undamped } else { Linear::damped };
        vec![Trial::of(("linear", "v̇ = Av"), linear, window, order, from), nonlinear, in_time, stiff]
    }

    fn has_structure(&self) -> bool {
        false
    }

    fn obstacle(&self) -> Option<String> {
        match self.zero {
            Roots::Stable => None,
            Roots::Outside(_) | Roots::Double(_) => Some("it is not zero-stable".into()),
            Roots::Undecided(_) => Some("whether it is zero-stable is open".into()),
        }
    }

    fn tables(&self) -> Vec<Table> {
        let row = |(q, c): (usize, &Real)| {
            let holds = if self.residuals[q].may_be_zero() { "vanishes" } else { "does not vanish" };
            let numbers = [c.to_f64(), c.radius()].map(Cell::Number);
            [Cell::Integer(q as i64)].into_iter().chain(numbers).chain([Cell::Text(holds.into())]).collect()
        };
        let rows = self.constants.iter().take(self.order as usize + 3).enumerate().map(row).collect();
        let caption = "C_q = [Σ j^q ρ_j − q Σ j^{q−1} σ_j]/(q! σ(1)), which vanish up to the order.";
        vec![table("constants", caption, &["q", "C_q", "uncertainty", "verdict"], rows)]
    }

    fn figures(&self) -> Vec<Figure> {
        let size = (1..200).map(|k| self.locus(PI * f64::from(k) / 200.0).norm()).filter(|x| x.is_finite()).largest();
        vec![region(1.3 * size, |z| self.growth(z))]
    }
}

impl MultistepTheory {
    fn negative_axis(&self) -> String {
        let interval = |[from, to]: &[f64; 2]| match (*from, *to) {
            (0.0, f64::INFINITY) => "all of the negative axis".to_owned(),
            (0.0, to) => format!("negative axis to {}", length(to, 0.0)),
            (from, f64::INFINITY) => format!("negative axis beyond {}", length(from, 0.0)),
            (from, to) => format!("negative axis from {} to {}", length(from, 0.0), length(to, 0.0)),
        };
        match self.negative.as_slice() {
            [] => "nothing of the negative axis".into(),
            intervals => intervals.iter().map(interval).collect::<Vec<_>>().join(" and "),
        }
    }

    fn a_stable_finding(&self) -> Finding {
        match &self.a_stable {
            _ if matches!(self.zero, Roots::Undecided(_)) => Finding::open("whether it is zero-stable is open"),
            _ if self.zero != Roots::Stable => Finding::new(false, "it is not even zero-stable"),
            Ok(open) => {
                let digits = match *open > 0.0 {
                    true => format!("; the digits given leave Re ρ(ζ) σ̄(ζ) open by up to {open:.0e}"),
                    false => String::new(),
                };
                Finding::new(true, format!("Re ρ(ζ)/σ(ζ) ≥ 0 on the unit circle, and σ has no root outside{digits}"))
            }
            Err(NotAStable::Because(why)) => Finding::new(false, why.clone()),
            Err(NotAStable::Open) => {
                Finding::open("the digits given do not tell whether Re ρ(ζ)/σ(ζ) ≥ 0 on the unit circle")
            }
        }
    }
}

#[cfg(test)]
mod tests;
