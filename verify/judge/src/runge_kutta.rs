//! The kind `runge-kutta`: what is claimed of a tableau, described and run.

use std::sync::Arc;

use lsvi::classic::{CoupledRungeKutta, RungeKutta, Tableau as LowerTriangular};
use lsvi::{InputError, Integrator, VectorField};

use super::analysis::{Analysis, Trial};
use super::claim::Property;
use super::facts::{Facts, beside_one, beyond_one, length, order as order_fact, reach, told, visible};
use super::linear::{Reach, SeriesOrder, Unstable};
use super::polynomial::EXACT;
use super::problem::{Autonomous, Linear, NonAutonomous, window};
use super::real::Real;
use super::structure::{Indefinite, Simplifying, algebraic_matrix, is_symmetric, symplectic_defect};
use super::tableau::{Numbers, Shape};
use super::theory::{Theory, WeightsTheory};
use super::verdict::{Finding, Kind, Verdict};
use evidence::{Check, Figure, Outcome, Table};
use experiments::kinds::{Principle, Stability, Symplecticity};
use experiments::measure::decimal::counted;
use experiments::measure::norm::larger;
use experiments::method::Traits;

/// What angles in degrees are found to.
const ANGLE: f64 = 0.002;

impl Analysis for Theory {
    fn kind(&self) -> &'static str {
        "runge-kutta"
    }

    fn headline(&self) -> String {
        let shape = match self.shape {
            Shape::Explicit => "explicit",
            Shape::DiagonallyImplicit => "diagonally implicit",
            Shape::FullyImplicit => "fully implicit",
        };
        format!("Runge–Kutta, {shape}, {}", counted(self.numbers.stages(), "stage"))
    }

    fn order(&self) -> u32 {
        self.order_found()
    }

    fn order_in_time(&self) -> u32 {
        if self.order_in_time < self.main.order { self.order_in_time } else { self.order_found() }
    }

    fn wrong_rows(&self) -> Vec<usize> {
        wrong_rows(self.row_defects.as_deref())
    }

    fn keeps_in_time(&self, claimed: u32, claimed_embedded: Option<u32>) -> bool {
        self.order_in_time >= claimed && self.embedded_keeps_in_time(claimed_embedded)
    }

    fn own_times(&self) -> Option<Verdict> {
        let stages = format!(", and the stage order is {}", self.simplifying.stage_order());
        own_times(&self.numbers.c, self.row_defects.as_deref()?, [self.order_in_time, self.main.order], &stages)
    }

    fn facts(&self) -> Facts {
        self.described()
    }

    fn find(&self, property: Property) -> Option<Finding> {
        find(property, self)
    }

    fn consistency(&self) -> Vec<Verdict> {
        let orders = [self.order_in_time, self.main.order];
        self.row_defects.iter().map(|defects| rows(&self.numbers.c, defects, "a", orders)).collect()
    }

    fn traits(&self) -> Traits {
        let infinity = self.stability.at_infinity().abs();
        let stability = match self.alpha {
            Some(alpha) if alpha > 0.0 && infinity < 0.95 => Stability::Damping,
            Some(alpha) if alpha > 0.0 => Stability::Neutral,
            _ if matches!(self.negative, Reach::UpTo { end: 0.0, .. }) => Stability::Unstable,
            _ => Stability::Conditional,
        };
        let stiff_order = self.stiff_order();
        Traits {
            stiff_order: stiff_order.map(|(order, _)| order),
            divides_by_rate: stiff_order.is_none_or(|(_, divides)| divides),
            symplectic: if self.symplectic_defect.is_none() { Symplecticity::Always } else { Symplecticity::Never },
            is_reversible: self.symmetric,
            ..Traits::new(self.order_in_time, Principle::Equation, stability)
        }
    }

    /// A step finds the slope of a stage with a diagonal entry from its value, of which a rounding ε |q| is one of ε |q|/(h a_ii) in
    /// the slope, and b_i/a_ii times itself in the step. All stages of a fully implicit one are solved for together.
    fn momentum_roundoff(&self, steps: f64) -> f64 {
        let of = |(i, b): (usize, &Real)| {
            let a = &self.numbers.a[i][i];
            if a.is_zero() { 0.0 } else { (b.to_f64() / a.to_f64()).abs() }
        };
        match self.shape {
            Shape::FullyImplicit => 0.0,
            _ => steps * self.numbers.b.iter().enumerate().map(of).sum::<f64>(),
        }
    }

    fn rounding_of_coefficients(&self, _size: f64, length: f64, _steps: f64) -> f64 {
        self.main.resolution() * length
    }

    fn moved(&self, by: f64) -> Vec<(f64, Arc<dyn Analysis>)> {
        let mut out: Vec<(f64, Arc<dyn Analysis>)> = Vec::new();
        let mut with = |radius: f64, change: &dyn Fn(&mut Numbers)| {
            let mut moved = self.clone();
            change(&mut moved.numbers);
            out.push((radius, Arc::new(moved)));
        };
        let by = Real::double(by);
        for (i, b) in self.numbers.b.iter().enumerate().filter(|(_, b)| b.is_rough()) {
            with(b.radius(), &|numbers| numbers.b[i] = b + &by);
        }
        for (i, row) in self.numbers.a.iter().enumerate() {
            for (j, a) in row.iter().enumerate().filter(|(_, a)| a.is_rough()) {
                with(a.radius(), &|numbers| numbers.a[i][j] = a + &by);
            }
        }
        out
    }

    fn unknowns(&self) -> usize {
        if self.shape == Shape::FullyImplicit { self.numbers.stages() } else { 0 }
    }

    fn on_field<'a>(&self, field: Box<dyn VectorField + 'a>) -> Result<Box<dyn Integrator + 'a>, String> {
        let refused = |error: InputError| error.to_string();
        let (a, b, c) = self.numbers.doubles();
        // Weights that do not sum to 1 are what a file may be wrong in, and what a run has to show.
        if self.shape == Shape::FullyImplicit {
            return Ok(Box::new(CoupledRungeKutta::inconsistent(field, &a, &b, &c).map_err(refused)?));
        }
        let tableau = LowerTriangular::inconsistent(&a, &b, &c).map_err(refused)?;
        Ok(Box::new(RungeKutta::new(field, tableau).map_err(refused)?))
    }

    /// A linear, a nonlinear, a non-autonomous and a stiff problem.
    fn trials(&self) -> Vec<Trial> {
        let main = self.main.order;
        let linear = self.linear.solution.first().map_or(main, |(order, _)| order);
        let rows = if self.wrong_rows().is_empty() { "the order conditions" } else { "the conditions with c as given" };
        let in_time = self.order_in_time;
        vec![
            Trial::of(("linear", "v̇ = Av"), Linear::damped, window(linear), linear, "the series of R(z)"),
            Trial::of(("nonlinear", "v̇ = f(v)"), Autonomous, window(main), main, "the order conditions"),
            Trial::of(("non-autonomous", "v̇ = f(t, v)"), NonAutonomous, window(in_time), in_time, rows),
            self.stiff(),
        ]
    }

    fn has_structure(&self) -> bool {
        true
    }

    fn tables(&self) -> Vec<Table> {
        let embedded = self.embedded.as_ref().map(|embedded| ("b̂", embedded));
        vec![WeightsTheory::table([("b", &self.main)].into_iter().chain(embedded))]
    }

    fn figures(&self) -> Vec<Figure> {
        let reach = |reach: Reach| match reach {
            Reach::UpTo { end, .. } | Reach::Open { to: end } => end,
            Reach::Everything => 0.0,
        };
        let size = 1.3 * reach(self.negative).max(reach(self.imaginary));
        vec![super::exhibits::region(size, |z| self.stability.at(z).norm())]
    }

    fn as_runge_kutta(&self) -> Option<&Theory> {
        Some(self)
    }
}

impl Theory {
    /// Prothero and Robinson's problem, where theory has an order for hλ ≫ 1, and where it has none, to see what it is.
    fn stiff(&self) -> Trial {
        if !self.alpha.is_some_and(|alpha| alpha > 0.0) {
            let why = "not the whole negative axis is in the region of stability: hλ must stay of order 1";
            return Trial { kind: "stiff", name: "prothero-robinson", plan: Err(why.into()) };
        }
        match self.stiff_order() {
            Some(_) => Trial::stiff(Some(self.order_in_time), "the defects of the stages"),
            None if self.stability.at_infinity().abs() > 0.95 => Trial::stiff(None, "R(∞) does not damp"),
            None => Trial::stiff(None, "A is singular, or two terms of the error compete"),
        }
    }

    fn described(&self) -> Facts {
        let theory = self;
        let (found, most) = (theory.order_found(), theory.most());
        let follows = match () {
            () if found == most && theory.all_hold() => {
                format!("{found}, the most that {} can have", counted(theory.numbers.stages(), "stage"))
            }
            () if found > theory.main.order => format!("{found} or more, by Butcher's simplifying assumptions"),
            () => order_fact(&theory.main),
        };
        let mut facts = vec![("order", follows)];
        if let Some(embedded) = &theory.embedded {
            facts.push(("embedded", order_fact(embedded)));
        }
        facts.extend(in_time([theory.order_in_time, theory.main.order]));
        let simplifying = theory.simplifying;
        facts.push((
            "stage order",
            format!("{}: B({}), C({}), D({})", simplifying.stage_order(), simplifying.b, simplifying.c, simplifying.d),
        ));
        facts.push(("stability", self.stability()));
        facts.push((
            "axes",
            format!("{}; {}", reach(theory.negative, "negative"), reach(theory.imaginary, "imaginary")),
        ));
        facts.push(("oscillations", self.oscillations()));
        facts.push(("structure", self.structure()));
        facts
    }

    fn stability(&self) -> String {
        let theory = self;
        let (infinity, at_infinity) = (theory.stability.at_infinity(), self.at_infinity());
        let class = match theory.alpha {
            Some(_) if theory.is_a_stable() && infinity == 0.0 => "L-stable".into(),
            Some(_) if theory.is_a_stable() => "A-stable".into(),
            _ if theory.is_a_stability_open() => match theory.stability.is_a_stable() {
                Err(Unstable::At(_)) => "not A-stable, and whether in a sector is open for the digits given".into(),
                _ => "whether it is A-stable is open for the digits given".into(),
            },
            Some(alpha) => format!("A(α)-stable with α {}", angle(alpha)),
            None => "conditionally stable".to_owned(),
        };
        let is_algebraic = theory.algebraic.is_ok() && !theory.is_a_stability_open();
        let algebraic = if is_algebraic { ", algebraically stable" } else { "" };
        let is_rounded = theory.is_a_stable() && theory.stability.left_open().is_some();
        let digits = if is_rounded { " to the digits given" } else { "" };
        format!("{class}{algebraic}{digits}; {at_infinity}")
    }

    fn at_infinity(&self) -> String {
        let infinity = self.stability.at_infinity();
        match infinity.is_finite() {
            true if self.stability.is_told_from_one_at_infinity() => format!("R(∞) = {}", beside_one(infinity)),
            true => format!("R(∞) = {}", visible(infinity)),
            false => "R(∞) = ∞".into(),
        }
    }

    fn oscillations(&self) -> String {
        let linear = self.linear;
        let one = |what: &str, found: SeriesOrder| match found {
            SeriesOrder::Leading(order, constant) => format!("{what} of order {order} (constant {constant:+.2e})"),
            SeriesOrder::Vanishing => format!("no {what} at all"),
            SeriesOrder::Open { .. } => format!("{what} of an order that the digits leave open"),
        };
        format!("{}, {}", one("dispersion", linear.dispersion), one("dissipation", linear.dissipation))
    }

    /// What of |R| ≤ 1 on the imaginary axis is so to the digits given alone.
    fn to_the_digits(&self) -> String {
        self.stability.left_open().map_or_else(String::new, |by| {
            format!("; the digits given leave |D|² − |N|² open by up to {by:.0e}, where it is taken for zero")
        })
    }

    /// Where a structure ends that steps on v̇ = f(v) have: c may tell stages apart that are equal there.
    fn without_time(&self, has: fn(&Numbers) -> bool) -> &'static str {
        if has(&self.reduced.numbers) { "" } else { " where f does not depend on t" }
    }

    fn structure(&self) -> String {
        let not = |holds: bool, what: &str, without: fn(&Numbers) -> bool| match holds {
            true => format!("{what}{}", self.without_time(without)),
            false => format!("not {what}"),
        };
        let parts = [
            not(self.symplectic_defect.is_none(), "symplectic", is_symplectic),
            not(self.symmetric, "symmetric", is_symmetric),
            not(self.stiffly_accurate.is_some(), "stiffly accurate", |_| true),
        ];
        parts.join(", ") + &self.autonomous.told()
    }
}

fn is_symplectic(numbers: &Numbers) -> bool {
    symplectic_defect(numbers).is_none()
}

/// The order on v̇ = f(t, v), where that is less than the one without t.
pub(super) fn in_time([in_time, order]: [u32; 2]) -> Option<(&'static str, String)> {
    (in_time < order).then(|| ("in time", format!("{in_time} on v̇ = f(t, v), with c as given")))
}

/// The rows whose sum is not c_i, from c_i − Σ_j a_ij.
pub(super) fn wrong_rows(defects: Option<&[Real]>) -> Vec<usize> {
    let defects = defects.into_iter().flatten().enumerate();
    defects.filter(|(_, defect)| !defect.may_be_zero()).map(|(i, _)| i).collect()
}

/// The same in words; nothing where there are none.
fn wrong_rows_told(c: &[Real], defects: &[Real]) -> Option<String> {
    let words = |i: usize| {
        let defect = &defects[i];
        let sum = &c[i] - defect;
        // As many places as show the difference.
        let places = (3.0 - defect.to_f64().abs().log10().floor()).clamp(10.0, 60.0) as usize;
        // A sum that vanishes has no sign.
        let shown = |x: &Real| if places > 10 { x.decimal(places) } else { format!("{:.10}", x.to_f64() + 0.0) };
        format!("row {} adds up to {}, and c[{}] is {}", i + 1, shown(&sum), i + 1, shown(&c[i]))
    };
    let rows: Vec<String> = wrong_rows(Some(defects)).into_iter().map(words).collect();
    (!rows.is_empty()).then(|| rows.join("; "))
}

/// Whether c is the sum of the rows of a matrix of this name, from c_i − Σ_j a_ij, and what order that leaves with t in f and without.
pub(super) fn rows(c: &[Real], defects: &[Real], name: &str, [in_time, order]: [u32; 2]) -> Verdict {
    let costs = || {
        if in_time < order { format!("; with this c the order on v̇ = f(t, v) is {in_time}") } else { String::new() }
    };
    let wrong = wrong_rows_told(c, defects).map(|wrong| wrong + &costs());
    let check = Check {
        id: "rows".into(),
        statement: "The abscissae are the sums of the rows".into(),
        outcome: wrong.is_none().into(),
        measured: defects.iter().map(|defect| defect.to_f64().abs()).reduce(larger),
        required: None,
        reason: wrong.unwrap_or_else(|| format!("c_i = Σ_j {name}_ij in every row")),
    };
    Verdict { kind: Kind::Consistency, subject: "row sums".into(), check }
}

/// What abscissae cost that are not the sums of the rows and lower no order that is claimed: the order with t in f beside that without,
/// and what `more` there is to say.
pub(super) fn own_times(c: &[Real], defects: &[Real], [in_time, order]: [u32; 2], more: &str) -> Option<Verdict> {
    let rows = wrong_rows_told(c, defects)?;
    let without = if in_time < order { format!(" where without t it is {order}") } else { " too".into() };
    let check = Check {
        id: "times".into(),
        statement:
            "Abscissae that are not the sums of the rows leave the order that is claimed where f depends on time".into(),
        outcome: Outcome::Pass,
        measured: Some(f64::from(in_time)),
        required: None,
        reason: format!("{rows}; on v̇ = f(t, v) the order is {in_time}{without}{more}"),
    };
    Some(Verdict { kind: Kind::Consistency, subject: "abscissae".into(), check })
}

/// An order that a method has with t in f, and a higher one without.
pub(super) fn order_in_time(p: u32, theory: &dyn Analysis) -> Option<Finding> {
    let order = theory.order();
    (p == theory.order_in_time() && p < order).then(|| {
        let why = format!("with this c the order on v̇ = f(t, v) is {p}, and without t it is {order}");
        Finding::new(true, why).measured(p)
    })
}

fn find(property: Property, theory: &Theory) -> Option<Finding> {
    Some(match property {
        Property::Order(p) => match order_in_time(p, theory).or_else(|| butcher(p, theory)) {
            Some(finding) => finding,
            None => order(p, &theory.main, "b"),
        },
        Property::EmbeddedOrder(p) => match &theory.embedded {
            Some(embedded) => order(p, embedded, "b̂"),
            // The reader refuses such a claim.
            None => return None,
        },
        Property::StageOrder(q) => {
            let found = theory.simplifying.stage_order();
            let why = format!(
                "B({}) and C({}) hold, so that the stage order is {found}",
                theory.simplifying.b, theory.simplifying.c
            );
            Finding::new(found == q, why).measured(found)
        }
        Property::Explicit => shape(theory, Shape::Explicit),
        Property::DiagonallyImplicit => shape(theory, Shape::DiagonallyImplicit),
        Property::AStable => a_stable(theory),
        Property::AlphaStable(angle) => match theory.alpha {
            _ if theory.is_a_stability_open() => {
                Finding::open("the digits given do not tell whether |R| ≤ 1 on the axes")
            }
            // A right angle is A-stability.
            Some(_) if angle.value >= 90.0 => a_stable(theory),
            Some(alpha) => {
                let why = match theory.is_a_stable() {
                    true => "|R| ≤ 1 in the left half-plane".to_owned(),
                    false => format!("|R| ≤ 1 in the sector |arg(−z)| ≤ α, α {}", self::angle(alpha)),
                };
                let (outcome, words) = angle.is_reached(alpha, ANGLE);
                let outcome = if alpha > 0.0 { outcome } else { Outcome::Fail };
                Finding { outcome, measured: Some(alpha), why: why + &words }
            }
            None => Finding::new(false, "not even the whole negative axis is in the region of stability"),
        },
        Property::LStable => {
            let infinity = theory.stability.at_infinity();
            match a_stable(theory) {
                finding if finding.outcome != Outcome::Pass => finding,
                _ if infinity == 0.0 => {
                    let digits = theory.to_the_digits();
                    Finding::new(true, format!("A-stable, and deg N < deg D, so that R(∞) = 0{digits}"))
                }
                _ => Finding::new(false, format!("A-stable, but {}", theory.at_infinity())).measured(infinity),
            }
        }
        Property::AlgebraicallyStable => match &theory.algebraic {
            Ok(()) if theory.is_a_stability_open() => {
                Finding::open("it would be A-stable, and whether it is, is open for the digits given")
            }
            Ok(()) => {
                let of = theory.reduced.told();
                let open = algebraic_matrix(&theory.reduced.numbers).into_iter().flatten().filter(Real::may_be_zero);
                let open = open.map(|x| x.radius()).fold(0.0, larger);
                let digits = match open > EXACT {
                    true => format!("; the digits given leave its entries open by up to {open:.0e}, taken for zero"),
                    false => String::new(),
                };
                Finding::new(true, format!("b ≥ 0, and B A + Aᵀ B − b bᵀ is positive semidefinite{of}{digits}"))
            }
            Err(Indefinite::Weight(i, b)) => {
                Finding::new(false, format!("b[{}] = {b:.6} is negative", i + 1)).measured(*b)
            }
            Err(Indefinite::Pivot(i, x)) => {
                let why = format!("B A + Aᵀ B − b bᵀ is indefinite: elimination meets {x:.4e} at stage {}", i + 1);
                Finding::new(false, why).measured(*x)
            }
            Err(Indefinite::Undecided) => {
                Finding::open("the digits given do not tell whether B A + Aᵀ B − b bᵀ is semidefinite")
            }
        },
        Property::StifflyAccurate => {
            let text = match theory.stiffly_accurate {
                Some(row) if row + 1 == theory.numbers.stages() => "the last row of A is b".into(),
                Some(row) => format!("row {} of A is b, the last one with the stages in another sequence", row + 1),
                None => "no row of A is b".to_owned(),
            };
            Finding::new(theory.stiffly_accurate.is_some(), text)
        }
        Property::Symplectic => match theory.symplectic_defect {
            None => {
                let (without, of) = (theory.without_time(is_symplectic), theory.autonomous.told());
                Finding::new(true, format!("b_i a_ij + b_j a_ji = b_i b_j for all i, j{without}{of}"))
            }
            Some((i, j, x)) => {
                let of = theory.autonomous.told();
                let why = format!("b_i a_ij + b_j a_ji − b_i b_j = {x:.4e} at i = {}, j = {}{of}", i + 1, j + 1);
                Finding::new(false, why).measured(x)
            }
        },
        Property::Symmetric => {
            let (text, without) = if theory.symmetric {
                ("a_σ(i)σ(j) + a_ij = b_j with the stages reversed", theory.without_time(is_symmetric))
            } else {
                ("a_σ(i)σ(j) + a_ij = b_j fails with the stages reversed", "")
            };
            Finding::new(theory.symmetric, format!("{text}{without}{}", theory.autonomous.told()))
        }
        Property::DispersionOrder(p) => series_order(p, theory.linear.dispersion, "phase"),
        Property::DissipationOrder(p) => series_order(p, theory.linear.dissipation, "amplitude"),
        Property::ImaginaryInterval(y) => match theory.imaginary {
            Reach::Everything => Finding::new(true, "|R(iy)| ≤ 1 for all y"),
            Reach::UpTo { end, open, witness } => {
                let size = theory.stability.at(nalgebra::Complex::new(0.0, witness)).norm();
                let (outcome, words) = y.is_reached(end, open);
                let end_told = if open < 1e-6 { format!("{end:.6}") } else { length(end, open) };
                let why = format!("|R(iy)| ≤ 1 up to |y| = {end_told}; |R({witness:.4}i)| = {size:.8}{words}");
                Finding { outcome, measured: Some(end), why }
            }
            Reach::Open { to } => match y.is_reached(to, 0.0) {
                (Outcome::Pass, words) => {
                    Finding::new(true, format!("|R(iy)| ≤ 1 up to |y| = {to:.6} at least{words}"))
                }
                _ => Finding::open(format!("the digits given do not tell whether |R(iy)| ≤ 1 beyond |y| = {to:.2}")),
            },
        },
        Property::ZeroStable => return None,
    })
}

/// The angle of a method that is not A-stable.
fn angle(alpha: f64) -> String {
    if alpha > 89.99 { "just below 90°".into() } else { format!("= {alpha:.2}°") }
}

fn shape(theory: &Theory, claimed: Shape) -> Finding {
    let text = match theory.shape {
        Shape::Explicit => "A is zero on and above its diagonal",
        Shape::DiagonallyImplicit => "A is zero above its diagonal and not on it",
        Shape::FullyImplicit => "A has entries above its diagonal",
    };
    Finding::new(theory.shape == claimed, text)
}

fn a_stable(theory: &Theory) -> Finding {
    match theory.stability.is_a_stable() {
        Ok(()) => {
            let digits = theory.to_the_digits();
            Finding::new(true, format!("no pole in the left half-plane, and |R(iy)| ≤ 1 for all y{digits}"))
        }
        Err(Unstable::Open) => Finding::open("the digits given do not tell whether |R(iy)| ≤ 1 for all y"),
        Err(Unstable::At(z)) => {
            let size = theory.stability.at(z).norm();
            let place = if z.re == 0.0 { format!("{:.6}i", z.im) } else { format!("{:.6} {:+.6}i", z.re, z.im) };
            let why = if size < 1e6 {
                format!("|R| {} at z = {place}", beyond_one(size))
            } else {
                format!("R has a pole at z = {place}")
            };
            Finding::new(false, why).measured(size)
        }
    }
}

fn series_order(p: u32, found: SeriesOrder, what: &str) -> Finding {
    match found {
        SeriesOrder::Leading(order, constant) => {
            let why = format!("the leading error of the {what} is {constant:+.4e} (hω)^{}", order + 1);
            Finding::new(order == p, why).measured(order)
        }
        SeriesOrder::Vanishing => {
            Finding::new(false, format!("there is no error of the {what} at all, to any order looked at"))
        }
        SeriesOrder::Open { at_most: Some((order, constant)), .. } if order < p => {
            let why = format!("the error of the {what} has a term {constant:+.4e} (hω)^{}", order + 1);
            Finding::new(false, why).measured(order)
        }
        SeriesOrder::Open { by, .. } => Finding::open(format!(
            "too few digits: they leave the terms of the error of the {what} open by up to {by:.0e}"
        )),
    }
}

/// What the simplifying assumptions say of an order at which the conditions end that are made up: B(p), C(η) and D(ζ) imply order p
/// for p ≤ η + ζ + 1 and p ≤ 2η + 2 (Butcher; \[HNW93\] II.7), and B(p) is necessary. s stages have order 2s at most.
fn butcher(p: u32, theory: &Theory) -> Option<Finding> {
    let (order, Simplifying { b, c, d }) = (theory.order_found(), theory.simplifying);
    let is_all = order == b || order == theory.most();
    let is_beyond = p > theory.main.forest.rule().most() || order > p;
    let decides = theory.all_hold() && is_beyond && (p <= order || is_all);
    decides.then(|| {
        let necessary = match () {
            () if order == theory.most() => {
                format!("; {} have no higher one", counted(theory.numbers.stages(), "stage"))
            }
            () if order == b => format!("; B({}) fails, which is necessary for more", b + 1),
            () => String::new(),
        };
        let why = format!("B({b}), C({c}) and D({d}) hold, from which order {order} follows{necessary}");
        Finding::new(p == order, why).measured(order)
    })
}

pub(super) fn order(p: u32, weights: &WeightsTheory, name: &str) -> Finding {
    let most = weights.forest.rule().most();
    if p > most {
        let why = format!("conditions are made up to order {most}; they hold up to order {}", weights.order);
        let outcome = if weights.order < most { Outcome::Fail } else { Outcome::Inconclusive };
        return Finding { outcome, measured: None, why };
    }
    let number = weights.conditions.iter().filter(|c| c.order <= p).count();
    let why = match weights.failing(p).next() {
        Some(first) => {
            let failing = weights.failing(p).count();
            format!(
                "{failing} of {number} conditions on {name} fail, the first at order {}: {} is off by {}",
                first.order,
                weights.formula(first.tree, name),
                told(&first.residual, 3)
            )
        }
        None if weights.order > p => match weights.left_open(p + 1) {
            Some(open) => {
                return Finding::open(format!(
                    "all {number} conditions hold, and the digits given leave those of order {} open by up to {open:.0e}",
                    p + 1
                ));
            }
            None => format!("all {number} conditions hold, and those up to order {} too", weights.order),
        },
        None => {
            let then = weights.beyond().map_or_else(String::new, |c| {
                format!("; of order {}, {} is off by {}", c.order, weights.formula(c.tree, name), told(&c.residual, 3))
            });
            let conditions =
                if number == 1 { "the condition holds".into() } else { format!("all {number} conditions hold") };
            format!("{conditions} to within {:.0e}{then}", weights.resolution())
        }
    };
    Finding::new(weights.order == p, why).measured(weights.order)
}

#[cfg(test)]
mod tests {
    use super::super::claim::Claim;
    use super::super::file::{Body, MethodFile, Shipped};
    use super::super::tree::MAX_ORDER;
    use super::*;

    fn of_file(file: &MethodFile) -> Theory {
        let Body::RungeKutta(tableau) = &file.body else { panic!("{}", file.name) };
        Theory::new(tableau, file.order(), None)
    }

    fn shipped(name: &str) -> Theory {
        of_file(&Shipped::by_name(name).expect("there").read().expect("well-formed"))
    }

    fn written(text: &str) -> Theory {
        of_file(&MethodFile::parse("m.toml", "m", text).expect("well-formed"))
    }

    /// R(−x) = −1 at x₀ and greater elsewhere: R leaves the disc beside x₀ at once, as −1 + ½R″(iy)². Two stages of diagonal γ
    /// and b₂a₂₁ = ⅛ have D + N = 2 + (4γ − 1)x + (2γ² − γ + ⅛)x², (x − 8)²/32 for γ = ⅛ and (x − 20)²/200 for γ = ⅕. R(∞) is
    /// 1 − 1/γ + 1/8γ²: 1 and −⅞.
    fn touching(gamma: &str) -> Theory {
        written(&format!("a = [['{gamma}'], ['1/4', '{gamma}']]\nb = ['1/2', '1/2']"))
    }

    /// The midpoint rule, of which a digit leaves open whether |R(iy)| is 1.
    fn rough_midpoint() -> Theory {
        written("digits = 1\na = [['0.5']]\nb = ['1']")
    }

    /// Heun's method with weights of one digit is told to have an order above 1, and 2 only to within the 0.05 that the second of them is
    /// known to.
    #[test]
    fn the_order_that_few_digits_leave_open_is_the_next() {
        let theory = written("digits = 1\norder = 1\na = [[], [1]]\nb = ['0.5', '0.5']");
        let found = order(1, &theory.main, "b");
        assert!(found.outcome == Outcome::Inconclusive, "{found:?}");
        assert!(found.why.ends_with("the digits given leave those of order 2 open by up to 5e-2"), "{}", found.why);
    }

    /// RK4 with a wrong c₂.
    fn wrong_in_time() -> Theory {
        written(
            "order = 4\nc = [0, '1/3', '1/2', 1]\na = [[], ['1/2'], [0, '1/2'], [0, 0, 1]]\nb = ['1/6', '1/3', '1/3', '1/6']",
        )
    }

    /// Radau IIA, its stages in reverse.
    const REVERSED_RADAU: &str = "c = [1, '1/3']\na = [['1/4', '3/4'], ['-1/12', '5/12']]\nb = ['1/4', '3/4']";
    /// SDIRK2 after a stage that nothing depends on.
    const SINGULAR: &str =
        "a = [[0], [0, '1 - sqrt(2)/2'], [0, 'sqrt(2)/2', '1 - sqrt(2)/2']]\nb = [0, 'sqrt(2)/2', '1 - sqrt(2)/2']";

    #[test]
    fn an_angle_is_just_below_a_right_one_where_two_digits_would_say_that_it_is_one() {
        assert_eq!(
            [86.0324, 89.98, 89.99, 89.996].map(super::angle),
            ["= 86.03°", "= 89.98°", "= 89.99°", "just below 90°"]
        );
    }

    /// Orders for hλ ≫ 1 from \[HW96\] IV.15: of Radau IA hˢ, of Radau IIA hˢ⁺¹/(hλ), of Gauss none that holds for all steps.
    #[test]
    fn what_is_known_of_a_method_follows_from_its_coefficients() {
        for (name, order, stiff_order, divides, stability, symplectic, reversible, unknowns) in [
            ("rk4", 4, None, true, Stability::Conditional, false, false, 0),
            ("implicit-euler", 1, Some(1), true, Stability::Damping, false, false, 0),
            ("gauss1", 2, None, true, Stability::Neutral, true, true, 0),
            ("gauss2", 4, None, true, Stability::Neutral, true, true, 2),
            ("radau-ia2", 3, Some(2), false, Stability::Damping, false, false, 2),
            ("radau-iia2", 3, Some(2), true, Stability::Damping, false, false, 2),
        ] {
            let theory = shipped(name);
            let known = Traits {
                stiff_order,
                divides_by_rate: divides,
                symplectic: if symplectic { Symplecticity::Always } else { Symplecticity::Never },
                is_reversible: reversible,
                ..Traits::new(order, Principle::Equation, stability)
            };
            assert_eq!((theory.traits(), theory.unknowns()), (known, unknowns), "{name}");
            assert!(theory.has_structure() && theory.as_runge_kutta().is_some() && theory.lowered().is_none());
        }
        // R(z) = 1 − z from a step backwards.
        assert_eq!(written("a = [[]]\nb = [-1]").traits().stability, Stability::Unstable);
        for gamma in ["1/5", "1/8"] {
            let theory = touching(gamma);
            assert_eq!((theory.negative, theory.alpha), (Reach::Everything, Some(0.0)), "{gamma}");
            assert_eq!(theory.traits().stability, Stability::Conditional, "{gamma}");
        }
        let wrong = wrong_in_time();
        assert_eq!(wrong.lowered().as_deref(), Some("with its c the order on v̇ = f(t, v) is 1"));
        assert_eq!((Analysis::order(&wrong), wrong.traits().order), (4, 1));
        // b alone is rounded, and Σ b − 1 known to half a unit of the second place.
        let rounded = written("digits = 2\na = [[]]\nb = ['1.00']");
        assert!((rounded.rounding_of_coefficients(2.0, 6.0, 8.0) - 0.03).abs() < 1e-12);
    }

    #[test]
    fn a_method_is_headed_by_its_shape_and_run_where_its_coefficients_say() {
        for (name, text) in [
            ("rk4", "Runge–Kutta, explicit, 4 stages"),
            ("implicit-euler", "Runge–Kutta, diagonally implicit, 1 stage"),
            ("gauss2", "Runge–Kutta, fully implicit, 2 stages"),
        ] {
            assert_eq!(shipped(name).headline(), text);
        }
        let planned = |theory: &Theory| {
            let plan = |trial: Trial| match trial.plan {
                Ok(plan) => (trial.kind, plan.order, plan.from.to_owned()),
                Err(why) => (trial.kind, None, why),
            };
            theory.trials().into_iter().map(plan).collect::<Vec<_>>()
        };
        let (series, conditions) = ("the series of R(z)", "the order conditions");
        let conditional = "not the whole negative axis is in the region of stability: hλ must stay of order 1";
        for (theory, [linear, main, in_time, stiff], [rows, why]) in [
            (shipped("rk4"), [Some(4), Some(4), Some(4), None], [conditions, conditional]),
            (wrong_in_time(), [Some(4), Some(4), Some(1), None], ["the conditions with c as given", conditional]),
            (shipped("gauss2"), [Some(4), Some(4), Some(4), None], [conditions, "R(∞) does not damp"]),
            (shipped("radau-iia2"), [Some(3), Some(3), Some(3), Some(3)], [conditions, "the defects of the stages"]),
            (
                written(SINGULAR),
                [Some(2), Some(2), Some(2), None],
                [conditions, "A is singular, or two terms of the error compete"],
            ),
            // bᵀc is 13/40.
            (touching("1/5"), [Some(1), Some(1), Some(1), None], [conditions, conditional]),
        ] {
            let known = [
                ("linear", linear, series),
                ("nonlinear", main, conditions),
                ("non-autonomous", in_time, rows),
                ("stiff", stiff, why),
            ];
            assert_eq!(planned(&theory), known.map(|(kind, order, from)| (kind, order, from.to_owned())));
        }
        let pair = shipped("dormand-prince");
        let rows = pair.main.conditions.len() + pair.embedded.as_ref().expect("a pair").conditions.len();
        assert_eq!(pair.tables()[0].rows.len(), rows);
        // Its interval on the negative axis is 3.3066, and that on the imaginary one shorter.
        let x = |theory: &Theory| theory.figures()[0].panels[0].field.as_ref().expect("a map").x[0];
        assert!((x(&pair) + 1.3 * 3.3066).abs() < 1e-3, "{}", x(&pair));
        let open = Theory { negative: Reach::Open { to: 5.0 }, imaginary: Reach::Everything, ..pair };
        assert_eq!(x(&open), -6.5);
    }

    /// R is 1/(1 − z) of the implicit Euler rule, and (1 + z/2)/(1 − z/2) of the midpoint rule, of which the phase
    /// is 2 atan(y/2) = y − y³/12 + ….
    #[test]
    fn what_is_said_of_a_method_is_what_it_has() {
        let told = |theory: &Theory, label: &str| {
            theory.facts().into_iter().find(|(name, _)| *name == label).map(|(_, text)| text)
        };
        for (theory, label, text) in [
            (shipped("implicit-euler"), "stability", Some("L-stable, algebraically stable; R(∞) = 0")),
            (shipped("gauss1"), "stability", Some("A-stable, algebraically stable; R(∞) = -1")),
            (shipped("rk4"), "stability", Some("conditionally stable; R(∞) = ∞")),
            (touching("1/5"), "stability", Some("A(α)-stable with α = 0.00°; R(∞) = -0.875")),
            // An algebraically stable method is A-stable.
            (
                written("digits = 1\na = [['0.5']]\nb = ['1']"),
                "stability",
                Some("whether it is A-stable is open for the digits given; R(∞) = -1"),
            ),
            (shipped("rk4"), "in time", None),
            (wrong_in_time(), "in time", Some("1 on v̇ = f(t, v), with c as given")),
            (shipped("rk4"), "embedded", None),
            (shipped("radau-iia2"), "stage order", Some("2: B(3), C(2), D(1)")),
            (shipped("gauss1"), "axes", Some("all of the negative axis; all of the imaginary axis")),
            (
                shipped("gauss1"),
                "oscillations",
                Some("dispersion of order 2 (constant -8.33e-2), no dissipation at all"),
            ),
            (shipped("gauss1"), "structure", Some("symplectic, symmetric, not stiffly accurate")),
            (shipped("implicit-euler"), "structure", Some("not symplectic, not symmetric, stiffly accurate")),
        ] {
            assert_eq!(told(&theory, label).as_deref(), text, "{label}");
        }
        let rough = told(&rough_midpoint(), "stability").expect("always");
        assert!(rough.starts_with("whether it is A-stable is open for the digits given"), "{rough}");
        let order = |theory: &Theory| told(theory, "order").expect("always");
        assert!(order(&shipped("rk4")).starts_with("4; first failing tree"));
        let mut high = shipped("gauss1");
        high.main.order = MAX_ORDER;
        high.numbers.b = vec![Real::zero(); 5];
        assert_eq!(order(&high), "10, the most that 5 stages can have");
        high.numbers.b = vec![Real::zero(); 6];
        assert!(!order(&high).contains("assumptions"), "{}", order(&high));
        high.simplifying = Simplifying { b: 11, c: 5, d: 5 };
        assert_eq!(order(&high), "11 or more, by Butcher's simplifying assumptions");
        // What is true of a stage that no weight depends on is not looked at.
        assert!(
            told(&written(SINGULAR), "structure")
                .expect("always")
                .ends_with(": judged on the 2 stages of the reduced method")
        );
    }

    /// 0.1, of which ten places show what is to be seen, and 2·10⁻¹², which takes fifteen.
    #[test]
    fn a_row_that_does_not_add_up_is_shown_to_as_many_places_as_tell_it() {
        let verdict = |c: &[f64], defects: &[f64]| {
            let reals = |x: &[f64]| x.iter().map(|x| Real::double(*x)).collect::<Vec<_>>();
            rows(&reals(c), &reals(defects), "a", [4, 4]).check
        };
        let right = verdict(&[0.5, 1.0], &[0.0, 0.0]);
        assert_eq!(
            (right.outcome, right.measured, &*right.reason),
            (Outcome::Pass, Some(0.0), "c_i = Σ_j a_ij in every row")
        );
        let wrong = verdict(&[0.5, 0.75, 0.5], &[0.0, 0.25, -0.125]);
        assert_eq!((wrong.outcome, wrong.measured), (Outcome::Fail, Some(0.25)));
        assert_eq!(
            wrong.reason,
            "row 2 adds up to 0.5000000000, and c[2] is 0.7500000000; row 3 adds up to 0.6250000000, and c[3] is 0.5000000000"
        );
        let close = verdict(&[0.5], &[2e-12]);
        assert_eq!(close.reason, "row 1 adds up to 0.499999999998, and c[1] is 0.5");
    }

    /// The weights (½, ½) have order 2 with stages that are those of the implicit midpoint rule, and with c = (0, 1); (0, 1) only where f does
    /// not depend on t.
    #[test]
    fn embedded_weights_keep_the_order_claimed_or_the_one_that_they_have_without_time() {
        let stages = "c = [0, 1]\na = [['1/2', 0], ['1/2', 0]]\nb = ['1/2', '1/2']\n";
        let keeps = |more: &str, embedded| written(&format!("{stages}{more}")).keeps_in_time(2, embedded);
        assert_eq!([keeps("", None), keeps("b_hat = [0, 1]", None)], [true, false]);
        assert_eq!([keeps("b_hat = [0, 1]", Some(1)), keeps("b_hat = [0, 1]", Some(2))], [true, false]);
    }

    /// Two steps of γ = ½ and b = ¾ and ¼ in ten: Σ |b|/γ each. An explicit stage has its slope at once, and coupled ones are solved for together.
    #[test]
    fn slopes_that_follow_from_values_add_their_roundings_in_each_step() {
        let diagonal = written("a = [['1/2', 0], ['1/2', '1/2']]\nb = ['3/4', '1/4']");
        assert_eq!([1.0, 10.0].map(|steps| diagonal.momentum_roundoff(steps)), [2.0, 20.0]);
        assert_eq!(["rk4", "gauss2"].map(|name| shipped(name).momentum_roundoff(10.0)), [0.0; 2]);
    }

    /// With c = (¼, 1) Σ b c is ⅝: order 1 in time, where without it is 2.
    #[test]
    fn what_own_times_leave_is_the_order_in_time() {
        let theory = written("order = 1\nc = ['1/4', 1]\na = [['1/2', 0], ['1/2', 0]]\nb = ['1/2', '1/2']");
        assert_eq!((theory.main.order, theory.keeps_in_time(1, None), theory.keeps_in_time(2, None)), (2, true, false));
        let check = theory.own_times().expect("c is not the sums").check;
        assert_eq!(check.measured, Some(1.0));
        let told = "on v̇ = f(t, v) the order is 1 where without t it is 2, and the stage order is 0";
        assert!(check.reason.ends_with(told), "{}", check.reason);
        assert!(
            check.reason.starts_with("row 1 adds up to 0.5000000000, and c[1] is 0.2500000000"),
            "{}",
            check.reason
        );
    }

    /// The implicit midpoint rule in two stages of which the other c makes others, and three steps of it, of ¼, ½ and ¼, which are their own
    /// reverse but in the sequence of a c whose first two are exchanged.
    #[test]
    fn structure_is_told_without_time_and_where_it_ends_with_time() {
        let midpoint = "a = [['1/2', 0], ['1/2', 0]]\nb = ['1/2', '1/2']";
        let steps = "a = [['1/8', 0, 0], ['1/4', '1/4', 0], ['1/4', '1/2', '1/8']]\nb = ['1/4', '1/2', '1/4']";
        for (stages, c, with_time) in [
            (midpoint, "['1/2', '1/2']", (true, true)),
            (midpoint, "[0, 1]", (false, true)),
            (midpoint, "[0, '1/2']", (false, false)),
            (steps, "['1/8', '1/2', '7/8']", (true, true)),
            (steps, "['1/2', '1/8', '7/8']", (true, false)),
        ] {
            let theory = written(&format!("c = {c}\n{stages}"));
            assert_eq!((theory.symplectic_defect.is_none(), theory.symmetric), (true, true), "{c}");
            let with_time = [(Property::Symplectic, with_time.0), (Property::Symmetric, with_time.1)];
            for (property, holds) in with_time {
                let finding = theory.find(property).expect("looked at");
                let ends = finding.why.contains(" where f does not depend on t");
                assert_eq!((finding.outcome, ends), (Outcome::Pass, !holds), "{c}: {}", finding.why);
            }
        }
    }

    /// Each property that methods have and have not, with what is said of it: from the textbook, or by hand where it is said how.
    #[test]
    fn each_property_is_found_where_it_is_and_refuted_where_it_is_not() {
        let (pass, fail, open) = (Outcome::Pass, Outcome::Fail, Outcome::Inconclusive);
        let (euler, midpoint, rk4) = (shipped("implicit-euler"), shipped("gauss1"), shipped("rk4"));
        let (trapezoid, radau, gauss) = (shipped("lobatto-iiia2"), shipped("radau-iia2"), shipped("gauss2"));
        let (rough, touching) = (rough_midpoint(), touching("1/5"));
        let reversed = written(REVERSED_RADAU);
        let with_imaginary = |imaginary: Reach| Theory { imaginary, ..rk4.clone() };
        let up_to = |open: f64| with_imaginary(Reach::UpTo { end: 2.5, open, witness: 3.0 });
        // R(3i) = 1 − 9/2 + 81/24 + i(3 − 27/6), the modulus of which is (⅛² + 1.5²)^½.
        let beyond = "|R(3.0000i)| = 1.50519932";
        for (theory, claim, outcome, why) in [
            (&rk4, "explicit", pass, "A is zero on and above its diagonal"),
            (&euler, "explicit", fail, "A is zero above its diagonal and not on it"),
            (&euler, "diagonally implicit", pass, "A is zero above its diagonal and not on it"),
            (&rk4, "diagonally implicit", fail, "A is zero on and above its diagonal"),
            (&gauss, "diagonally implicit", fail, "A has entries above its diagonal"),
            (&radau, "stage order 2", pass, "B(3) and C(2) hold, so that the stage order is 2"),
            (&radau, "stage order 1", fail, "B(3) and C(2) hold, so that the stage order is 2"),
            (&midpoint, "a-stable", pass, "no pole in the left half-plane, and |R(iy)| ≤ 1 for all y"),
            (&rough, "a-stable", open, "the digits given do not tell whether |R(iy)| ≤ 1 for all y"),
            (&midpoint, "a(90)-stable", pass, "no pole in the left half-plane, and |R(iy)| ≤ 1 for all y"),
            (&midpoint, "a(89)-stable", pass, "|R| ≤ 1 in the left half-plane"),
            (&rough, "a(89)-stable", open, "the digits given do not tell whether |R| ≤ 1 on the axes"),
            (&touching, "a(0)-stable", fail, "|R| ≤ 1 in the sector |arg(−z)| ≤ α, α = 0.00°"),
            (&rk4, "a(45)-stable", fail, "not even the whole negative axis is in the region of stability"),
            (&euler, "l-stable", pass, "A-stable, and deg N < deg D, so that R(∞) = 0"),
            (&midpoint, "l-stable", fail, "A-stable, but R(∞) = -1"),
            (&rough, "l-stable", open, "the digits given do not tell whether |R(iy)| ≤ 1 for all y"),
            (&euler, "algebraically stable", pass, "b ≥ 0, and B A + Aᵀ B − b bᵀ is positive semidefinite"),
            // m₁₁ = 0 − ¼.
            (
                &trapezoid,
                "algebraically stable",
                fail,
                "B A + Aᵀ B − b bᵀ is indefinite: elimination meets -2.5000e-1 at stage 1",
            ),
            (&radau, "stiffly accurate", pass, "the last row of A is b"),
            (&reversed, "stiffly accurate", pass, "row 1 of A is b, the last one with the stages in another sequence"),
            (&midpoint, "stiffly accurate", fail, "no row of A is b"),
            (&midpoint, "symplectic", pass, "b_i a_ij + b_j a_ji = b_i b_j for all i, j"),
            // m₁₁ = −¼, m₂₂ = ¼ and m₁₂ = 0: of the two the last.
            (&trapezoid, "symplectic", fail, "b_i a_ij + b_j a_ji − b_i b_j = 2.5000e-1 at i = 2, j = 2"),
            (&trapezoid, "symmetric", pass, "a_σ(i)σ(j) + a_ij = b_j with the stages reversed"),
            (&radau, "symmetric", fail, "a_σ(i)σ(j) + a_ij = b_j fails with the stages reversed"),
            (&midpoint, "dispersion order 2", pass, "the leading error of the phase is -8.3333e-2 (hω)^3"),
            (&midpoint, "dispersion order 3", fail, "the leading error of the phase is -8.3333e-2 (hω)^3"),
            // |1/(1 − iy)| = 1 − y²/2 + ….
            (&euler, "dissipation order 1", pass, "the leading error of the amplitude is -5.0000e-1 (hω)^2"),
            (
                &midpoint,
                "dissipation order 2",
                fail,
                "there is no error of the amplitude at all, to any order looked at",
            ),
            (&midpoint, "stable on the imaginary axis to 9", pass, "|R(iy)| ≤ 1 for all y"),
            (
                &up_to(0.0),
                "stable on the imaginary axis to 2.4",
                pass,
                &format!("|R(iy)| ≤ 1 up to |y| = 2.500000; {beyond}"),
            ),
            (
                &up_to(1e-6),
                "stable on the imaginary axis to 2.6",
                fail,
                &format!("|R(iy)| ≤ 1 up to |y| = 2.5000; {beyond}"),
            ),
            (
                &with_imaginary(Reach::Open { to: 2.5 }),
                "stable on the imaginary axis to 2.4",
                pass,
                "|R(iy)| ≤ 1 up to |y| = 2.500000 at least",
            ),
            (
                &with_imaginary(Reach::Open { to: 2.5 }),
                "stable on the imaginary axis to 2.6",
                open,
                "the digits given do not tell whether |R(iy)| ≤ 1 beyond |y| = 2.50",
            ),
            (&rk4, "order 4", pass, "all 8 conditions hold to within"),
            (&rk4, "order 3", fail, "all 4 conditions hold, and those up to order 4 too"),
        ] {
            let property = Claim::parse(claim).expect(claim).property;
            let finding = theory.find(property).expect(claim);
            assert_eq!(finding.outcome, outcome, "{claim}: {}", finding.why);
            assert!(finding.why.starts_with(why), "{claim}: {}", finding.why);
        }
        assert!(rk4.find(Property::ZeroStable).is_none() && rk4.find(Property::EmbeddedOrder(3)).is_none());
        let pair = shipped("bogacki-shampine");
        assert_eq!(pair.find(Property::EmbeddedOrder(2)).expect("a pair").outcome, pass);
        let weight =
            written("a = [[], [1]]\nb = ['3/2', '-1/2']").find(Property::AlgebraicallyStable).expect("looked at");
        assert_eq!((&*weight.why, weight.measured), ("b[2] = -0.500000 is negative", Some(-0.5)));
        let rounded = written("digits = 1\na = [['0.5']]\nb = ['1']").find(Property::AlgebraicallyStable);
        let finding = rounded.expect("looked at");
        assert_eq!(finding.outcome, open, "{}", finding.why);
        let undecided = Theory { algebraic: Err(Indefinite::Undecided), ..midpoint };
        assert_eq!(undecided.find(Property::AlgebraicallyStable).expect("looked at").outcome, open);
    }

    /// The theta method with θ = 1/2 ∓ 10⁻⁷: as fractions or as decimals that are said to be exact it is A-stable or not; to the seven places
    /// printed, which leave its R(∞) open by as much, it is no further than these tell.
    #[test]
    fn a_stability_is_told_of_what_is_meant_and_to_the_digits_of_what_is_rounded() {
        let theta = |digits: &str, [less, more]: [&str; 2]| {
            written(&format!("{digits}a = [[0, 0], ['{less}', '{more}']]\nb = ['{less}', '{more}']"))
        };
        let fractions = ["5000001/10000000", "4999999/10000000"];
        let decimals = ["0.5000001", "0.4999999"];
        let swapped = |[x, y]: [&'static str; 2]| [y, x];
        for (theory, outcome, of_digits, words) in [
            (theta("", fractions), Outcome::Fail, false, "conditionally stable; R(∞) = -1.0000004"),
            (theta("", swapped(fractions)), Outcome::Pass, false, "A-stable; R(∞) = -0.9999996"),
            (theta("digits = 20\n", decimals), Outcome::Fail, false, "conditionally stable; R(∞) = -1.0000004"),
            (theta("", decimals), Outcome::Pass, true, "A-stable to the digits given; R(∞) = -1"),
            (theta("", swapped(decimals)), Outcome::Pass, true, "A-stable to the digits given; R(∞) = -1"),
            // By more than digits leave open.
            (
                theta("", ["0.5000020", "0.4999980"]),
                Outcome::Fail,
                false,
                "not A-stable, and whether in a sector is open for the digits given; R(∞) = -1.000008",
            ),
        ] {
            let finding = a_stable(&theory);
            assert_eq!(finding.outcome, outcome, "{words}: {}", finding.why);
            assert_eq!(finding.why.contains("the digits given leave"), of_digits, "{}", finding.why);
            assert_eq!(theory.stability(), words);
        }
        // R(∞) = 0 to the digits: SDIRK2 in eight places.
        let sdirk = written(
            "a = [['0.29289322'], ['0.70710678', '0.29289322']]\nb = ['0.70710678', '0.29289322']\nclaims = ['L-stable']",
        );
        let finding = sdirk.find(Property::LStable).expect("looked at");
        assert_eq!(finding.outcome, Outcome::Pass);
        assert!(finding.why.contains("the digits given leave"), "{}", finding.why);
    }

    /// R(z) = 1/(1 − z) + 10⁻⁹ z/(1 + z) has a pole at −1, however small its residue.
    #[test]
    fn a_pole_in_the_left_half_plane_is_none_only_where_it_cancels() {
        let pole = |weight: &str| {
            a_stable(&written(&format!("a = [[1, 0], [0, -1]]\nb = ['1 - {weight}', '{weight}']"))).outcome
        };
        assert_eq!(["1/1000", "1/1000000000", "0"].map(pole), [Outcome::Fail, Outcome::Fail, Outcome::Pass]);
    }

    /// D = 1 + z has its zero at −1, N = 1 + 2z has not; 1 + z + z²/2 on the imaginary axis has modulus 1 + y⁴/4 under a root.
    #[test]
    fn a_method_that_is_not_a_stable_is_shown_a_point() {
        let pole = a_stable(&written("a = [[-1]]\nb = [1]"));
        assert_eq!((pole.outcome, &*pole.why), (Outcome::Fail, "R has a pole at z = -1.000000 +0.000000i"));
        let growing = a_stable(&shipped("heun2"));
        let found = growing.why.strip_prefix("|R| = ").and_then(|rest| rest.strip_suffix("i"));
        let (size, y) = found.and_then(|rest| rest.split_once(" at z = ")).expect("on the axis");
        let (size, y) = (size.parse::<f64>().expect("a number"), y.parse::<f64>().expect("a number"));
        assert!(y > 0.0 && (size - (1.0 + y.powi(4) / 4.0).sqrt()).abs() < 1e-7 * size, "{}", growing.why);
        assert!((growing.measured.expect("a size") - size).abs() < 1e-7 * size);
    }

    #[test]
    fn the_order_of_a_series_is_left_open_up_to_its_first_certain_term() {
        let open = |at_most| SeriesOrder::Open { by: 2e-3, at_most };
        let few = "too few digits: they leave the terms of the error of the phase open by up to 2e-3";
        for (p, found, outcome, why) in [
            (4, open(Some((3, 0.5))), Outcome::Fail, "the error of the phase has a term +5.0000e-1 (hω)^4"),
            (3, open(Some((3, 0.5))), Outcome::Inconclusive, few),
            (2, open(Some((3, 0.5))), Outcome::Inconclusive, few),
            (2, open(None), Outcome::Inconclusive, few),
        ] {
            let finding = series_order(p, found, "phase");
            assert_eq!((finding.outcome, &*finding.why), (outcome, why), "{p}: {found:?}");
        }
    }

    /// B(b), C(c) and D(d) imply min(b, c + d + 1, 2c + 2), and s stages have 2s at most; conditions are made up to order 10.
    #[test]
    fn orders_beyond_the_conditions_follow_from_the_simplifying_assumptions() {
        let rk4 = shipped("rk4");
        assert!((1..15).all(|p| butcher(p, &rk4).is_none()));
        let (most, fails) = ("; 6 stages have no higher one", "; B(12) fails, which is necessary for more");
        // All conditions hold that are made up; for each claim the order that is found, where it is.
        for (stages, [b, c, d], order, more, decided) in [
            (6, [12, 6, 6], 12, most, &[9, 10, 11, 12, 13][..]),
            (8, [11, 5, 5], 11, fails, &[9, 10, 11, 12, 13]),
            // B(14) leaves room for more than 11 = 5 + 5 + 1.
            (8, [14, 5, 5], 11, "", &[9, 10, 11]),
            // The conditions themselves say more than C(4), and B(11) fails.
            (8, [10, 4, 4], 10, "; B(11) fails, which is necessary for more", &[9, 11, 12, 13]),
        ] {
            let mut theory = rk4.clone();
            theory.main.order = MAX_ORDER;
            theory.numbers.b = vec![Real::zero(); stages];
            theory.simplifying = Simplifying { b, c, d };
            let why = format!("B({b}), C({c}) and D({d}) hold, from which order {order} follows{more}");
            for p in 9..14 {
                let found = butcher(p, &theory).map(|finding| (finding.outcome, finding.measured, finding.why));
                let known = (Outcome::from(p == order), Some(f64::from(order)), why.clone());
                assert_eq!(found, decided.contains(&p).then_some(known), "B({b}), C({c}), D({d}), {p}");
            }
        }
    }

    /// 1, 1, 2, 4, 9 conditions of the orders 1 to 5.
    #[test]
    fn an_order_is_told_by_how_many_conditions_hold_and_how_many_fail() {
        let (euler, rk4) = (written("a = [[]]\nb = [1]"), shipped("rk4"));
        for (weights, p, outcome, measured, parts) in [
            (&euler.main, 1, Outcome::Pass, Some(1.0), ["the condition holds to within", "; of order 2, "]),
            (&rk4.main, 4, Outcome::Pass, Some(4.0), ["all 8 conditions hold to within", "; of order 5, "]),
            (&rk4.main, 3, Outcome::Fail, Some(4.0), ["all 4 conditions hold, and those up to order 4 too", ""]),
            (
                &rk4.main,
                5,
                Outcome::Fail,
                Some(4.0),
                [" of 17 conditions on b fail, the first at order 5: ", " is off by "],
            ),
            (&rk4.main, 11, Outcome::Fail, None, ["conditions are made up to order 10; they hold up to order 4", ""]),
        ] {
            let finding = order(p, weights, "b");
            assert_eq!((finding.outcome, finding.measured), (outcome, measured), "{p}: {}", finding.why);
            assert!(parts.iter().all(|part| finding.why.contains(part)), "{p}: {}", finding.why);
        }
        assert_ne!(order(10, &rk4.main, "b").measured, None);
        let all = WeightsTheory { order: MAX_ORDER, ..rk4.main };
        assert_eq!(order(11, &all, "b").outcome, Outcome::Inconclusive);
    }

    #[test]
    fn digits_are_told_of_an_algebraic_stability_that_rests_on_them() {
        let why = |text: &str| {
            let file = MethodFile::parse("m.toml", "m", text).expect("well-formed");
            find(Property::AlgebraicallyStable, &of_file(&file)).expect("looked at").why
        };
        let exact = why("a = [['1/4', '1/4 - sqrt(3)/6'], ['1/4 + sqrt(3)/6', '1/4']]\nb = ['1/2', '1/2']\n");
        let rounded = why("a = [['1/4', '-0.0386751346'], ['0.5386751346', '1/4']]\nb = ['1/2', '1/2']\n");
        assert!(
            !exact.contains("digits") && rounded.contains("the digits given leave its entries open"),
            "{exact} {rounded}"
        );
    }
}
