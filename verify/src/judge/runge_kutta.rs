//! The kind `runge-kutta`: what is claimed of a tableau, described and run.

use lsvi::classic::{CoupledRungeKutta, RungeKutta, Tableau as LowerTriangular};
use lsvi::{InputError, Integrator, VectorField};

use super::analysis::{Analysis, Trial};
use super::claim::Property;
use super::facts::{Facts, length, order as order_fact, reach, short, told};
use super::linear::{Reach, SeriesOrder, Unstable};
use super::problem::{Autonomous, Linear, NonAutonomous, window};
use super::real::Real;
use super::structure::{Indefinite, Simplifying};
use super::tableau::Shape;
use super::theory::{Theory, WeightsTheory};
use super::verdict::{Finding, Kind, Verdict};
use crate::evidence::{Check, Figure, Outcome, Table};
use crate::kinds::{Principle, Stability, Symplecticity};
use crate::measure::decimal::counted;
use crate::measure::norm::larger;
use crate::method::Traits;

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

    fn lowered(&self) -> Option<String> {
        let in_time = self.order_in_time;
        (in_time < self.order_found()).then(|| format!("with its c the order on v̇ = f(t, v) is {in_time}"))
    }

    fn facts(&self) -> Facts {
        self.described()
    }

    fn find(&self, property: Property) -> Option<Finding> {
        find(property, self)
    }

    fn consistency(&self) -> Vec<Verdict> {
        self.row_defects.iter().map(|defects| rows(&self.numbers.c, defects)).collect()
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
            symplectic: match self.symplectic_defect {
                None => Symplecticity::Always,
                Some(_) => Symplecticity::Never,
            },
            is_reversible: self.symmetric,
            ..Traits::new(self.order_in_time, Principle::Equation, stability)
        }
    }

    fn rounding_of_coefficients(&self, _size: f64, length: f64, _steps: f64) -> f64 {
        self.main.resolution() * length
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
            Trial::of("linear", "v̇ = Av", Linear::damped(window(linear)), linear, "the series of R(z)"),
            Trial::of("nonlinear", "v̇ = f(v)", Autonomous(window(main)), main, "the order conditions"),
            Trial::of("non-autonomous", "v̇ = f(t, v)", NonAutonomous(window(in_time)), in_time, rows),
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
        vec![super::evidence::region(size, |z| self.stability.at(z).norm())]
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
        if theory.order_in_time < theory.main.order {
            let text = format!("{} on v̇ = f(t, v), with c as given", theory.order_in_time);
            facts.push(("in time", text));
        }
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
        let infinity = theory.stability.at_infinity();
        let at_infinity =
            if infinity.is_finite() { format!("R(∞) = {}", short(infinity)) } else { "R(∞) = ∞".into() };
        let class = match theory.alpha {
            Some(_) if theory.is_a_stable() && infinity == 0.0 => "L-stable".into(),
            Some(_) if theory.is_a_stable() => "A-stable".into(),
            _ if theory.is_a_stability_open() => "whether it is A-stable is open for the digits given".into(),
            Some(alpha) => format!("A(α)-stable with α {}", angle(alpha)),
            None => "conditionally stable".to_owned(),
        };
        let algebraic = if theory.algebraic.is_ok() { ", algebraically stable" } else { "" };
        format!("{class}{algebraic}; {at_infinity}")
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

    /// On which coefficients conditions of structure are looked at, where these are not all.
    fn of_reduced(&self) -> String {
        self.reduced.why.as_ref().map_or_else(String::new, |why| {
            let stages = counted(self.reduced.numbers.stages(), "stage");
            format!("; {why}: judged on the {stages} of the reduced method")
        })
    }

    fn structure(&self) -> String {
        let not = |holds: bool, what: &str| if holds { what.to_owned() } else { format!("not {what}") };
        let parts = [
            not(self.symplectic_defect.is_none(), "symplectic"),
            not(self.symmetric, "symmetric"),
            not(self.stiffly_accurate.is_some(), "stiffly accurate"),
        ];
        parts.join(", ") + &self.of_reduced()
    }
}

/// Whether c is the sum of the rows of A, from c_i − Σ_j a_ij.
pub(super) fn rows(c: &[Real], defects: &[Real]) -> Verdict {
    let wrong: Vec<(usize, &Real)> = defects.iter().enumerate().filter(|(_, defect)| !defect.may_be_zero()).collect();
    let words = |(i, defect): &(usize, &Real)| {
        let sum = &c[*i] - *defect;
        // As many places as show the difference.
        let places = (3.0 - defect.to_f64().abs().log10().floor()).clamp(10.0, 60.0) as usize;
        let shown = |x: &Real| if places > 10 { x.decimal(places) } else { format!("{:.10}", x.to_f64()) };
        format!("row {} adds up to {}, and c[{}] is {}", i + 1, shown(&sum), i + 1, shown(&c[*i]))
    };
    let reason = match wrong.as_slice() {
        [] => "c_i = Σ_j a_ij in every row".to_owned(),
        rows => rows.iter().map(words).collect::<Vec<_>>().join("; "),
    };
    let check = Check {
        id: "rows".into(),
        statement: "The abscissae are the sums of the rows".into(),
        outcome: wrong.is_empty().into(),
        measured: defects.iter().map(|defect| defect.to_f64().abs()).reduce(larger),
        required: None,
        reason,
    };
    Verdict { kind: Kind::Consistency, subject: "row sums".into(), check }
}

fn find(property: Property, theory: &Theory) -> Option<Finding> {
    Some(match property {
        Property::Order(p) => match butcher(p, theory) {
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
                _ if infinity == 0.0 => Finding::new(true, "A-stable, and deg N < deg D, so that R(∞) = 0"),
                _ => Finding::new(false, format!("A-stable, but R(∞) = {infinity:.6}")).measured(infinity),
            }
        }
        Property::AlgebraicallyStable => match &theory.algebraic {
            Ok(()) => {
                let of = theory.of_reduced();
                Finding::new(true, format!("b ≥ 0, and B A + Aᵀ B − b bᵀ is positive semidefinite{of}"))
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
            None => Finding::new(true, format!("b_i a_ij + b_j a_ji = b_i b_j for all i, j{}", theory.of_reduced())),
            Some((i, j, x)) => {
                let of = theory.of_reduced();
                let why = format!("b_i a_ij + b_j a_ji − b_i b_j = {x:.4e} at i = {}, j = {}{of}", i + 1, j + 1);
                Finding::new(false, why).measured(x)
            }
        },
        Property::Symmetric => {
            let text = if theory.symmetric {
                "a_σ(i)σ(j) + a_ij = b_j with the stages reversed"
            } else {
                "a_σ(i)σ(j) + a_ij = b_j fails with the stages reversed"
            };
            Finding::new(theory.symmetric, format!("{text}{}", theory.of_reduced()))
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
        Ok(()) => Finding::new(true, "no pole in the left half-plane, and |R(iy)| ≤ 1 for all y"),
        Err(Unstable::Open) => Finding::open("the digits given do not tell whether |R(iy)| ≤ 1 for all y"),
        Err(Unstable::At(z)) => {
            let size = theory.stability.at(z).norm();
            let place = if z.re == 0.0 { format!("{:.6}i", z.im) } else { format!("{:.6} {:+.6}i", z.re, z.im) };
            let why = if size < 1e6 {
                format!("|R| = {size:.8} at z = {place}")
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
        None if weights.order > p => {
            format!("all {number} conditions hold, and those up to order {} too", weights.order)
        }
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
    #[test]
    fn an_angle_is_just_below_a_right_one_where_two_digits_would_say_that_it_is_one() {
        assert_eq!([86.0324, 89.98, 89.996].map(super::angle), ["= 86.03°", "= 89.98°", "just below 90°"]);
    }
}
