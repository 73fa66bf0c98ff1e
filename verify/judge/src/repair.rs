//! Misprints: which single coefficient, changed, makes all the conditions hold.

use std::collections::BTreeSet;

use dashu_int::IBig;
use dashu_ratio::RBig;
use rayon::prelude::*;

use super::conditions::Weights;
use super::polynomial::Polynomial;
use super::real::Real;
use super::tableau::{Coefficient, Numbers, Place, Shape, Tableau, row_sums};
use super::tree::{Forest, Rule};

/// Largest denominator of a rational number that is proposed as such.
const SIMPLE: u64 = 1_000_000_000_000;

/// What a repaired tableau must satisfy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Target {
    /// The order of the method.
    pub order: u32,
    /// The order of the embedded method, where there is one to be judged.
    pub embedded: Option<u32>,
}

/// One number to be changed.
#[derive(Debug, Clone)]
pub struct Repair {
    /// Which coefficient it is.
    pub place: Place,
    /// Where else it stands, and has to be changed too.
    pub also: Vec<Place>,
    /// The c_i that have to follow, so that their row sums stay right.
    pub follows: Vec<Place>,
    /// Whether the method is explicit as it stands, or diagonally implicit, and would not be.
    pub makes_implicit: bool,
    /// The text that stands there.
    pub was: String,
    /// What should stand there: a rational number, one with a square root, or digits.
    pub text: String,
    /// The value, with what it is uncertain by.
    pub value: Real,
    /// How many conditions, row sums among them, fail as the file stands and hold with the change.
    pub mends: usize,
}

/// A forest of the order of a target.
#[derive(Debug)]
struct Search<'a> {
    tableau: &'a Tableau,
    numbers: Numbers,
    target: Target,
    forest: Forest,
    /// Failing conditions: of b, and of b̂.
    failing: [Vec<usize>; 2],
    rows: Vec<usize>,
}

/// Every change of a single coefficient that reaches `target`, the one nearest to the printed text first.
pub fn repairs(tableau: &Tableau, target: Target) -> Vec<Repair> {
    let numbers = tableau.numbers();
    let forest = Forest::new(Rule::Autonomous, target.order.max(target.embedded.unwrap_or(0)));
    let mut search = Search { tableau, numbers, target, forest, failing: [Vec::new(), Vec::new()], rows: Vec::new() };
    search.failing = search.failures(&search.numbers);
    search.rows = failing_rows(&search.numbers);
    let mut found: Vec<Repair> =
        search.candidates().into_par_iter().filter_map(|(place, x)| search.verify(place, &x)).collect();
    // Where A and b satisfy every condition, what disagrees with them is c.
    let a_is_right = search.failing.iter().all(Vec::is_empty);
    found.sort_by_key(|repair| {
        let distance = strsim::damerau_levenshtein(&repair.was, &repair.text);
        let spoils = a_is_right && !matches!(repair.place, Place::C(_));
        (!repair.follows.is_empty(), repair.makes_implicit, spoils, distance, repair.place)
    });
    found.dedup_by_key(|repair| (repair.place, repair.text.clone()));
    found
}

fn failing_rows(numbers: &Numbers) -> Vec<usize> {
    let defects = numbers.row_defects();
    defects.iter().enumerate().filter(|(_, defect)| !defect.may_be_zero()).map(|(i, _)| i).collect()
}

impl Search<'_> {
    fn failures(&self, numbers: &Numbers) -> [Vec<usize>; 2] {
        let mut weights = Weights::new(&self.forest, numbers);
        let mut failing = |b: Option<&[Real]>, order: u32| {
            let Some(b) = b else { return Vec::new() };
            let trees = (1..=order).flat_map(|n| self.forest.of_order(n));
            trees.filter(|&k| !weights.residual(k, b).may_be_zero()).collect()
        };
        let main = failing(Some(&numbers.b), self.target.order);
        [main, failing(numbers.b_hat.as_deref(), self.target.embedded.unwrap_or(0))]
    }

    /// Whether nothing fails, which the first condition that does decides.
    fn holds(&self, numbers: &Numbers) -> bool {
        let mut weights = Weights::new(&self.forest, numbers);
        let mut hold = |b: Option<&[Real]>, order: u32| {
            let trees = |b| (1..=order).flat_map(|n| self.forest.of_order(n)).map(move |k| (k, b));
            b.into_iter().flat_map(trees).all(|(k, b)| weights.residual(k, b).may_be_zero())
        };
        hold(Some(&numbers.b), self.target.order) && hold(numbers.b_hat.as_deref(), self.target.embedded.unwrap_or(0))
    }

    /// Places with the values that one condition asks for.
    fn candidates(&self) -> Vec<(Place, Real)> {
        let s = self.numbers.stages();
        let mut found = Vec::new();
        match self.rows.as_slice() {
            // One sum is wrong: either c_i, or one of the entries that it sums.
            [i] => {
                let defect = &self.numbers.row_defects()[*i];
                found.push((Place::C(*i), &self.numbers.c[*i] - defect));
                let columns = match self.tableau.shape() {
                    Shape::Explicit => self.columns(*i),
                    // A lost entry above the diagonal makes coupled stages look diagonally implicit.
                    Shape::DiagonallyImplicit | Shape::FullyImplicit => 0..s,
                };
                found.extend(columns.map(|j| (Place::A(*i, j), &self.numbers.a[*i][j] + defect)));
            }
            [] => {
                let of_stage = |i: usize| {
                    let row = self.columns(i).map(move |j| Place::A(i, j));
                    [Place::B(i), Place::Hat(i)].into_iter().chain(row)
                };
                let places: Vec<Place> = (0..s).flat_map(of_stage).collect();
                let solved = |place: Place| self.solve(place).into_iter().map(move |x| (place, x));
                found.par_extend(places.into_par_iter().flat_map_iter(solved));
            }
            _ => {}
        }
        found
    }

    /// The columns of row `i` that may have been misprinted: a lost diagonal entry makes an implicit method look explicit.
    fn columns(&self, i: usize) -> std::ops::Range<usize> {
        match self.tableau.shape() {
            Shape::Explicit | Shape::DiagonallyImplicit => 0..i + 1,
            Shape::FullyImplicit => 0..self.numbers.stages(),
        }
    }

    /// The values at `place` that satisfy the first failing condition which depends on it. A condition of n vertices is a
    /// polynomial of degree below n in any one coefficient.
    fn solve(&self, place: Place) -> Vec<Real> {
        let hat = matches!(place, Place::Hat(_));
        let order = |k: usize| self.forest.trees()[k].order;
        let [main, embedded] = &self.failing;
        let trees = if hat { embedded } else { main };
        // Where the method itself is right, a wrong entry of A shows in the embedded one.
        let (trees, of_hat) =
            if trees.is_empty() && matches!(place, Place::A(..)) { (embedded, true) } else { (trees, hat) };
        for &k in trees {
            let degree = if matches!(place, Place::A(..)) { order(k) as i64 - 1 } else { 1 };
            let value = |x: &Real| {
                let changed = self.changed(place, x);
                let b = if of_hat { changed.b_hat.clone().unwrap_or_default() } else { changed.b.clone() };
                Weights::new(&self.forest, &changed).residual(k, &b)
            };
            let samples: Vec<Real> = (0..=degree).map(|n| value(&Real::from(n))).collect();
            let polynomial = interpolate(&samples);
            if polynomial.degree().is_none_or(|n| n == 0) {
                continue;
            }
            let real = polynomial.roots().into_iter().filter(|z| z.im.abs() <= 1e-6 * (1.0 + z.re.abs())).map(|z| z.re);
            return real.filter_map(|x| polish(&polynomial, x)).collect();
        }
        Vec::new()
    }

    /// The numbers with `x` at `place`, and with c_i following an entry of row i where its sum is right as it stands.
    fn changed(&self, place: Place, x: &Real) -> Numbers {
        let mut numbers = self.numbers.clone();
        if let Some(slot) = numbers.at_mut(place) {
            *slot = x.clone();
        }
        if let Place::A(i, _) = place
            && self.rows.is_empty()
        {
            numbers.c[i] = row_sums(&numbers.a[i..=i]).swap_remove(0);
        }
        numbers
    }

    /// The repair, if all conditions hold with it.
    fn verify(&self, place: Place, x: &Real) -> Option<Repair> {
        let old = self.tableau.coefficient(place)?;
        if is_printed(x, old) {
            return None;
        }
        let holds = |value: &Real| {
            let changed = self.changed(place, value);
            failing_rows(&changed).is_empty() && self.holds(&changed)
        };
        let (text, value) = fitting(x, old, &self.tableau.radicands, holds)?;
        let follows = match place {
            Place::A(i, _) if self.rows.is_empty() && self.tableau.c.is_some() => vec![Place::C(i)],
            _ => Vec::new(),
        };
        let mends = self.failing.iter().map(Vec::len).sum::<usize>() + self.rows.len();
        let makes_implicit = match (place, self.tableau.shape()) {
            (Place::A(i, j), Shape::Explicit) => j >= i,
            (Place::A(i, j), Shape::DiagonallyImplicit) => j > i,
            _ => false,
        };
        Some(Repair { place, also: Vec::new(), follows, makes_implicit, was: old.text.clone(), text, value, mends })
    }
}

/// Whether `x` is what the digits of `old` say already. What `x` itself is uncertain by does not count: in a row sum that is as much as
/// the digits leave, and a misprint of one unit is no more.
pub(super) fn is_printed(x: &Real, old: &Coefficient) -> bool {
    (&x.centre() - &old.real).may_be_zero()
}

/// The first form of `x` with which the conditions hold: beside a rounded decimal one of as many places, uncertain by as much, as a
/// reader of the file takes it; or else as one would print it. A rounded one is uncertain by what the conditions leave open, too.
pub(super) fn fitting(
    x: &Real,
    old: &Coefficient,
    radicands: &[i64],
    hold: impl Fn(&Real) -> bool,
) -> Option<(String, Real)> {
    let as_printed = to_places(x, old).or_else(|| over_denominator(x, old)).filter(|(_, value)| hold(value));
    let (text, value) = as_printed.or_else(|| written(x, radicands, hold))?;
    let open = if value.radius() > 0.0 { x.radius() } else { 0.0 };
    Some((text, value.widened(open)))
}

/// The fraction nearest to `x` with the denominator of `old`, where that is one: 2616/720 beside 1901/720, and not 109/30.
fn over_denominator(x: &Real, old: &Coefficient) -> Option<(String, Real)> {
    let (numerator, denominator) = old.text.split_once('/')?;
    numerator.trim().parse::<i64>().ok()?;
    let q: i64 = denominator.trim().parse().ok().filter(|q| *q > 1)?;
    let p = (x * &Real::from(q)).mid().round().to_int().value();
    let value = RBig::from(p.clone()) / RBig::from(q);
    (!value.is_int()).then(|| (format!("{p}/{q}"), Real::rational(&value)))
}

/// `x` to the places of `old`, where that is a rounded decimal.
fn to_places(x: &Real, old: &Coefficient) -> Option<(String, Real)> {
    let is_decimal = old.text.chars().all(|c| c.is_ascii_digit() || "+-−.".contains(c));
    let places = -(2.0 * old.real.radius()).log10();
    if !is_decimal || !(0.5..45.0).contains(&places) || (places - places.round()).abs() > 1e-6 {
        return None;
    }
    let places = places.round() as usize;
    let unit = (0..places).fold(Real::one(), |unit, _| &unit * &Real::from(10));
    // Where the digits leave several, the one of a simple number: .667 and not .666 beside .167 and .167.
    let x = &simple(x, 0.05).map_or_else(|| x.clone(), |rational| Real::rational(&rational));
    let whole = (x * &unit).mid().round().to_int().value();
    let value = &Real::rational(&RBig::from(whole.clone())) / &unit;
    let (sign, digits) = match whole.to_string() {
        text if text.starts_with('-') => ("-", text[1..].to_owned()),
        text => ("", text),
    };
    let digits = format!("{digits:0>width$}", width = places + 1);
    let (before, after) = digits.split_at(digits.len() - places);
    Some((format!("{sign}{before}.{after}"), value.widened(old.real.radius())))
}

/// The simplest rational number in an interval, where it says something: of those with denominators up to d about 2 r d² lie within ± r by chance,
/// and d has to be so small that these are twice `chance` at most.
fn simple(x: &Real, chance: f64) -> Option<RBig> {
    let largest_radius = 1e-4 / (SIMPLE as f64).powi(2);
    let limit = if x.radius() < largest_radius { SIMPLE as f64 } else { (chance / x.radius()).sqrt() };
    x.simplest().filter(|rational| RBig::from(rational.denominator().clone()).to_f64().value() <= limit)
}

/// A number as one would print it, if the conditions hold with it: rational, with a square root that the file has elsewhere, or its digits.
fn written(x: &Real, radicands: &[i64], hold: impl Fn(&Real) -> bool) -> Option<(String, Real)> {
    if let Some(rational) = simple(x, 0.01) {
        let value = Real::rational(&rational);
        return hold(&value).then(|| (rational.to_string(), value));
    }
    if x.radius() < 1e-45 {
        let relation = radicands.iter().find_map(|&d| quadratic(x, d));
        if let Some(found) = relation {
            return Some(found).filter(|(_, value)| hold(value));
        }
    }
    hold(x).then(|| {
        // To the digits that the uncertainty leaves, one more than are certain.
        let size = x.to_f64().abs().max(f64::MIN_POSITIVE);
        let digits = (size / x.radius().max(1e-40 * size)).log10().ceil().clamp(1.0, 40.0) as usize;
        (x.decimal(digits), x.clone())
    })
}

/// The polynomial through (0, y₀), (1, y₁), …, by Newton's divided differences.
pub(super) fn interpolate(samples: &[Real]) -> Polynomial {
    let n = samples.len();
    let mut differences = samples.to_vec();
    for level in 1..n {
        for k in (level..n).rev() {
            let step = &differences[k] - &differences[k - 1];
            differences[k] = &step / &Real::from(level as i64);
        }
    }
    let mut polynomial = Polynomial::new(Vec::new());
    for (k, difference) in differences.iter().enumerate().rev() {
        let factor = Polynomial::new(vec![Real::from(-(k as i64)), Real::one()]);
        polynomial = polynomial.times(&factor).plus(&Polynomial::new(vec![difference.clone()]));
    }
    polynomial
}

/// A simple root near `start` to 57 digits, by Newton's method, uncertain by what the polynomial is.
pub(super) fn polish(polynomial: &Polynomial, start: f64) -> Option<Real> {
    let slopes: Vec<Real> =
        polynomial.coefficients().iter().enumerate().skip(1).map(|(k, c)| c * &Real::from(k as i64)).collect();
    let slope = Polynomial::new(slopes);
    let mut x = Real::double(start);
    for _ in 0..8 {
        let s = slope.at(&x);
        if s.may_be_zero() {
            return None;
        }
        x = (&x - &(&polynomial.at(&x) / &s)).centre();
    }
    let (value, s) = (polynomial.at(&x), slope.at(&x));
    let error = (value.to_f64().abs() + value.radius()) / s.to_f64().abs();
    // Three digits leave a thousandth open, and what the conditions make of it decides; more than a tenth is no digit at all.
    (error < 0.1).then(|| x.widened(error))
}

/// x = (m + n √d)/k in small whole numbers, by reduction of the lattice of (k, m, n, 10⁴⁰ (k x − m − n √d)).
fn quadratic(x: &Real, d: i64) -> Option<(String, Real)> {
    let root = Real::rounded(Real::from(d).mid().sqrt(), 0.0);
    let large = (0..40).fold(Real::one(), |p, _| &p * &Real::from(10));
    let scaled = |x: &Real| (x * &large).mid().to_int().value();
    let unit = |k: usize, last: IBig| {
        let mut v = vec![IBig::ZERO; 4];
        v[k] = IBig::ONE;
        v[3] = last;
        v
    };
    let basis = [unit(0, scaled(x)), unit(1, -scaled(&Real::one())), unit(2, -scaled(&root))];
    let shortest = reduce(basis)?;
    let whole = |k: usize| i64::try_from(shortest[k].clone()).ok().filter(|n| n.abs() < 1_000_000);
    let (k, m, n) = (whole(0)?, whole(1)?, whole(2)?);
    if k == 0 || n == 0 {
        return None;
    }
    let ratio = |n: i64| RBig::from_parts_signed(n.into(), k.into());
    let (rational, surd) = (ratio(m), ratio(n));
    let value = &Real::rational(&rational) + &(&Real::rational(&surd) * &root);
    if (&value - x).to_f64().abs() > 1e-38 {
        return None;
    }
    let sign = if surd < RBig::ZERO { "-" } else { "+" };
    let size = if surd < RBig::ZERO { -surd } else { surd };
    let (top, bottom) = (size.numerator().to_string(), size.denominator().to_string());
    let mut term = if top == "1" { format!("sqrt({d})") } else { format!("{top}*sqrt({d})") };
    if bottom != "1" {
        term += &format!("/{bottom}");
    }
    let text = match (rational == RBig::ZERO, sign) {
        (true, "+") => term,
        (true, _) => format!("-{term}"),
        (false, sign) => format!("{rational} {sign} {term}"),
    };
    Some((text, value))
}

/// A short vector of a lattice of three, by pairwise reduction until nothing gets shorter.
fn reduce(mut basis: [Vec<IBig>; 3]) -> Option<Vec<IBig>> {
    let inner = |a: &[IBig], b: &[IBig]| a.iter().zip(b).map(|(a, b)| a * b).sum::<IBig>();
    let mut seen = BTreeSet::new();
    for _ in 0..2000 {
        basis.sort_by_key(|v| inner(v, v));
        if !seen.insert(basis.clone()) {
            break;
        }
        for (i, j) in [(1, 0), (2, 0), (2, 1)] {
            let norm = inner(&basis[j], &basis[j]);
            if norm == IBig::ZERO {
                return None;
            }
            // The nearest whole number to ⟨v_i, v_j⟩/⟨v_j, v_j⟩.
            let twice: IBig = inner(&basis[i], &basis[j]) * 2 + &norm;
            let quotient = floor_div(&twice, &(norm * 2));
            let shift = basis[j].clone();
            basis[i].iter_mut().zip(&shift).for_each(|(x, y)| *x -= &quotient * y);
        }
    }
    let [first, ..] = basis;
    Some(first)
}

/// ⌊a/b⌋ for b > 0.
fn floor_div(a: &IBig, b: &IBig) -> IBig {
    let quotient = a / b;
    if &quotient * b > *a { quotient - IBig::ONE } else { quotient }
}

#[cfg(test)]
mod tests {
    use super::super::file::{Body, MethodFile};
    use super::*;

    /// b₁ + b₂ = 1 is mended by either: ⅔ for ½ changes two characters, ½ for ⅓ one.
    #[test]
    fn the_repair_nearest_to_the_printed_text_comes_first() {
        let changes = |b: &str| {
            let text = format!("order = 1\na = [['1/2']]\nb = [{b}]\n");
            let file = MethodFile::parse("m.toml", "m", &text).expect("well-formed");
            let Body::RungeKutta(tableau) = &file.body else { panic!("{text}") };
            let found = repairs(tableau, Target { order: 1, embedded: None });
            found.into_iter().map(|repair| (repair.place, repair.text)).collect::<Vec<_>>()
        };
        let [near, far] = [(Place::B(1), "1/2".to_owned()), (Place::B(0), "2/3".to_owned())];
        assert_eq!(changes("'1/2', '1/3'"), [near, far]);
        let [near, far] = [(Place::B(0), "1/2".to_owned()), (Place::B(1), "2/3".to_owned())];
        assert_eq!(changes("'1/3', '1/2'"), [near, far]);
        let either = [0, 1].map(|i| (Place::B(i), "2/3".to_owned()));
        assert_eq!(changes("'1/3', '1/3'"), either);
    }

    /// b·c is 0.51 for ½, of weights that may add up to 1 and are off by 0.01: ½ for the last of them mends it, and so do entries of A,
    /// with which c has to follow.
    #[test]
    fn a_repair_that_no_other_coefficient_has_to_follow_comes_first() {
        let text =
            "digits = 2\na = [[], [0], [0, 0], [0, 0, 1]]\nb = ['0.17', '0.17', '0.16', '0.51']\nc = [0, 0, 0, 1]\n";
        let file = MethodFile::parse("m.toml", "m", text).expect("well-formed");
        let Body::RungeKutta(tableau) = &file.body else { panic!("{text}") };
        let found = repairs(tableau, Target { order: 2, embedded: None });
        let (first, others) = found.split_first().expect("there are some");
        assert_eq!((first.place, first.text.as_str(), first.follows.len()), (Place::B(3), "0.50", 0));
        assert!(!others.is_empty() && others.iter().all(|repair| repair.follows.len() == 1), "{others:?}");
    }

    /// A row of sum ¼ beside c = ½, and one of sum ½ beside ¾: only a₁₂ is above the diagonal.
    #[test]
    fn an_entry_above_the_diagonal_makes_a_diagonally_implicit_method_implicit() {
        for (c, expected) in [
            ("'1/2', '1/2'", vec![(Place::C(0), false), (Place::A(0, 0), false), (Place::A(0, 1), true)]),
            ("'1/4', '3/4'", vec![(Place::C(1), false), (Place::A(1, 0), false), (Place::A(1, 1), false)]),
        ] {
            let text = format!("a = [['1/4', '0'], ['1/4', '1/4']]\nb = ['1/2', '1/2']\nc = [{c}]\n");
            let file = MethodFile::parse("m.toml", "m", &text).expect("well-formed");
            let Body::RungeKutta(tableau) = &file.body else { panic!("{text}") };
            let found = repairs(tableau, Target { order: 1, embedded: None });
            let mut found: Vec<_> = found.iter().map(|repair| (repair.place, repair.makes_implicit)).collect();
            found.sort_by_key(|(place, _)| expected.iter().position(|(other, _)| other == place));
            assert_eq!(found, expected, "{c}");
        }
    }

    fn ratio(n: i64, d: i64) -> Real {
        &Real::from(n) / &Real::from(d)
    }

    #[test]
    fn a_value_is_rounded_to_the_places_that_are_printed() {
        let beside = |text: &str, radius: f64, x: &Real| {
            let real = Real::double(text.parse().expect("a decimal")).widened(radius);
            let old = Coefficient { text: text.to_owned(), real, exact: None };
            to_places(x, &old).map(|(text, _)| text)
        };
        assert_eq!(beside("-0.267", 5e-4, &ratio(-1, 6)).as_deref(), Some("-0.167"));
        assert_eq!(beside("0.267", 5e-4, &ratio(1, 6)).as_deref(), Some("0.167"));
        assert_eq!(beside("12.445", 5e-4, &ratio(12_345, 1000)).as_deref(), Some("12.345"));
        // Half a unit of no place, and of none that is rounded.
        assert_eq!([3e-4, 0.0].map(|radius| beside("0.267", radius, &ratio(1, 6))), [None, None]);
        let sum = Coefficient { text: "0.333 + 1".into(), real: Real::double(1.333).widened(5e-4), exact: None };
        assert_eq!(to_places(&ratio(3, 2), &sum), None);
    }

    /// √2 to 10⁻⁶ has seven digits, and √3/1000 to 57 of them 40.
    #[test]
    fn an_irrational_value_has_the_digits_that_are_certain() {
        let root = |n: i64| Real::rounded(Real::from(n).mid().sqrt(), 0.0);
        let text = |x: &Real| written(x, &[], |_| true).map(|(text, _)| text);
        assert_eq!(text(&root(2).widened(1e-6)).as_deref(), Some("1.414214"));
        let small = &root(3) / &Real::from(1000);
        assert_eq!(text(&small).as_deref(), Some("0.001732050807568877293527446341505872366943"));
    }

    #[test]
    fn a_number_with_a_square_root_is_recognized_to_all_its_digits() {
        let root = Real::rounded(Real::from(2).mid().sqrt(), 0.0);
        let surd = |m: i64, n: i64| &ratio(m, 3) + &(&ratio(n, 3) * &root);
        let text = |x: &Real| quadratic(x, 2).map(|(text, _)| text);
        for (m, n, expected) in [
            (1, 1, "1/3 + sqrt(2)/3"),
            (1, -1, "1/3 - sqrt(2)/3"),
            (-2, -2, "-2/3 - 2*sqrt(2)/3"),
            (0, 1, "sqrt(2)/3"),
            (0, -1, "-sqrt(2)/3"),
        ] {
            assert_eq!(text(&surd(m, n)).as_deref(), Some(expected));
        }
        // (123 + 456√2)/789.
        let large = &ratio(41, 263) + &(&ratio(152, 263) * &root);
        assert_eq!(text(&large).as_deref(), Some("41/263 + 152*sqrt(2)/263"));
        // A rational number has no root, and that of a square is none.
        assert_eq!(text(&ratio(1, 3)), None);
        assert_eq!(quadratic(&surd(1, 1), 4), None);
        // 3 10¹⁰ in the lattice is less than 10^(40/3), and no whole numbers come nearer.
        assert_eq!(text(&(&surd(1, 1) + &Real::double(1e-30))), None);
    }

    /// Of (10, 0) and (9, 6), (−1, 6) is the shortest: twice the latter is longer than 10 already.
    #[test]
    fn a_lattice_is_reduced_to_its_shortest_vector() {
        let vector = |x: i64, y: i64, z: i64| vec![IBig::from(x), IBig::from(y), IBig::from(z), IBig::ZERO];
        let shortest = reduce([vector(10, 0, 0), vector(9, 6, 0), vector(0, 0, 1000)]).expect("no zero");
        assert!([vector(-1, 6, 0), vector(1, -6, 0)].contains(&shortest), "{shortest:?}");
        for (a, b) in (-7..=7_i64).flat_map(|a| (1..=4_i64).map(move |b| (a, b))) {
            assert_eq!(floor_div(&IBig::from(a), &IBig::from(b)), IBig::from(a.div_euclid(b)), "{a}/{b}");
        }
    }

    fn third() -> Coefficient {
        Coefficient { text: "0.333".into(), real: Real::double(0.333).widened(5e-4), exact: None }
    }

    #[test]
    fn what_is_rounded_to_the_printed_digits_is_printed() {
        let found = [ratio(1, 3), ratio(334, 1000), ratio(1, 2).widened(1.0)].map(|x| is_printed(&x, &third()));
        assert_eq!(found, [true, false, false]);
    }

    /// ½ to five places, for 0.333 and for ⅓.
    #[test]
    fn a_rounded_repair_is_open_by_what_is_printed_and_what_is_found_and_an_exact_one_is_not() {
        let x = ratio(1, 2).widened(1e-5);
        let exact =
            Coefficient { text: "1/3".into(), real: ratio(1, 3), exact: Some(RBig::from_parts(1.into(), 3_u8.into())) };
        for (old, expected, radius) in [(third(), "0.500", 5.1e-4), (exact, "1/2", 0.0)] {
            let is_half = |value: &Real| (value - &ratio(1, 2)).may_be_zero();
            let (text, value) = fitting(&x, &old, &[], is_half).expect("it fits");
            assert_eq!(text, expected);
            assert!((value.radius() - radius).abs() < 1e-12, "{value:?}");
        }
    }

    #[test]
    fn a_root_is_polished_to_all_digits() {
        let square = Polynomial::new(vec![Real::from(-2), Real::zero(), Real::one()]);
        let root = polish(&square, 1.414).expect("a simple root");
        assert!(square.at(&root).may_be_zero() && root.radius() < 1e-50, "{root:?}");
    }
}
