//! The kinds `partitioned-runge-kutta` and `nystrom`: methods with coefficients of their own for q and for p = q̇ in
//! q̇ = f(q, p), ṗ = g(q, p) (\[HLW06\] II.2, III.2, VI.4; \[HNW93\] II.14).

use std::sync::Arc;

use lsvi::{Integrator, VectorField};
use nalgebra::{DMatrix, Matrix2, Vector2};

use super::analysis::{Analysis, Trial};
use super::claim::Property;
use super::conditions::{Part, Weights, conditions_of, order_of};
use super::exhibits::{coefficient_row, table};
use super::facts::{Facts, order as order_fact};
use super::mirror::has_mirror;
use super::problem::{Forced, NonAutonomous, window};
use super::real::Real;
use super::runge_kutta::{in_time, order as order_finding, order_in_time, own_times, rows, wrong_rows};
use super::stepping::{Halves, Stepper};
use super::tableau::{Coefficient, row_sums};
use super::theory::WeightsTheory;
use super::tree::{Forest, Rule};
use super::verdict::{Finding, Verdict};
use evidence::{Outcome, Table};
use experiments::kinds::{Principle, Stability, Symplecticity};
use experiments::measure::decimal::counted;
use experiments::measure::search::{minimum, root};
use experiments::method::Traits;

/// Largest hω for which oscillations are looked at.
const FARTHEST: f64 = 60.0;

/// What f and g depend on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coupling {
    /// Everything.
    General,
    /// q̇ = f(p), ṗ = g(q).
    Separable,
    /// q̇ = p, ṗ = g(q): Nyström's methods.
    SecondOrder,
}

/// The coefficients as a file states them: of q first, then of p. Those of a Nyström method are ā and b̄ for q, and b for p;
/// its second matrix is I.
#[derive(Debug, Clone)]
pub struct Parts {
    /// What they are for.
    pub coupling: Coupling,
    /// s rows of s, twice.
    pub a: [Vec<Vec<Coefficient>>; 2],
    /// s weights, twice.
    pub b: [Vec<Coefficient>; 2],
    /// s abscissae, where they are given.
    pub c: Option<Vec<Coefficient>>,
}

/// Names of the coefficients: matrices, weights.
type Names = ([&'static str; 2], [&'static str; 2]);

impl Parts {
    /// The part in which time is one more component, whose rows add up to c: that of p where fewer of its rows do not than of those of
    /// q, of which a single one is a misprint.
    pub(super) fn timed(&self) -> usize {
        let wrong = |part: usize| {
            let sums = self.a[part].iter().map(|row| row.iter().map(|x| &x.real).sum::<Real>());
            self.c.iter().flatten().zip(sums).filter(|(c, sum)| !(&c.real - sum).may_be_zero()).count()
        };
        usize::from(wrong(0) > 1 && wrong(1) < wrong(0))
    }

    fn names(&self) -> Names {
        match self.coupling {
            Coupling::SecondOrder => (["ā", ""], ["b̄", "b"]),
            _ => (["a", "â"], ["b", "b̂"]),
        }
    }

    /// The coefficients as texts.
    pub(super) fn table(&self) -> Table {
        let ([a, a_hat], weights) = self.names();
        let mut rows = Vec::new();
        for (name, matrix) in [(a, &self.a[0]), (a_hat, &self.a[1])].iter().filter(|(name, _)| !name.is_empty()) {
            rows.extend(matrix.iter().enumerate().map(|(i, row)| coefficient_row(&format!("{name}_{}", i + 1), row)));
        }
        rows.extend(weights.iter().zip(&self.b).map(|(name, b)| coefficient_row(name, b)));
        rows.extend(self.c.iter().map(|c| coefficient_row("c", c)));
        let columns: Vec<String> =
            std::iter::once(String::new()).chain((1..=self.b[0].len()).map(|j| j.to_string())).collect();
        let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
        table("coefficients", "The coefficients as the file has them.", &columns, rows)
    }
}

/// All that follows from them.
#[derive(Debug, Clone)]
pub(super) struct PartsTheory {
    coupling: Coupling,
    a: [Vec<Vec<Real>>; 2],
    b: [Vec<Real>; 2],
    c: Vec<Real>,
    /// c_i − Σ_j a_ij, or the same of â, where a partitioned method states c.
    row_defects: Option<Vec<Real>>,
    /// [`Parts::timed`].
    timed: usize,
    /// Conditions on the systems that the file names.
    weights: WeightsTheory,
    /// Order on separable systems, where the file names all.
    separable: Option<u32>,
    /// Order where q̇ is linear in p besides, where the file does not say so.
    linear: Option<u32>,
    /// Order on the same systems with time in them, with c as given.
    order_in_time: u32,
    /// The condition that is farthest from holding.
    symplectic_defect: Option<(String, f64)>,
    symmetric: bool,
    explicit: bool,
    /// How far steps on q̇ = ωp, ṗ = −ωq stay bounded; nothing where they shrink or grow areas.
    oscillation: Option<Bounded>,
}

/// How far steps on q̇ = ωp, ṗ = −ωq stay bounded.
#[derive(Debug, Clone, Copy)]
enum Bounded {
    /// As far as is looked at.
    Everywhere,
    /// Up to this hω, and not at the witness.
    UpTo { end: f64, witness: f64 },
}

/// What the end of an interval is found to: where |tr| = 2 + 10⁻¹⁰, which is off by its root where |tr| only grazes 2.
const FOUND: f64 = 1e-5;

impl PartsTheory {
    pub(super) fn new(parts: &Parts, claimed: Option<u32>) -> Self {
        let reals = |list: &Vec<Coefficient>| list.iter().map(|x| x.real.clone()).collect::<Vec<_>>();
        let a = parts.a.each_ref().map(|rows| rows.iter().map(reals).collect::<Vec<_>>());
        let b = parts.b.each_ref().map(reals);
        let c = parts.c.as_ref().map_or_else(|| row_sums(&a[0]), reals);
        let at_least = claimed.unwrap_or(0) + 1;
        let leaves = parts.leaves([&a[0], &a[1]], &c);
        let part = |k: usize| Part { a: &a[k], leaf: leaves[k].clone() };
        let conditions =
            |forest: &Forest| conditions_of(Weights::of_parts(forest, [part(0), part(1)], &c), [&b[0], &b[1]]);
        // The quadrature of either half bounds the order.
        let search = |rule: Rule, at_least| WeightsTheory::search(rule, (at_least, 2 * b[0].len() as u32), conditions);
        let rule = parts.rule();
        let has_rows = parts.c.is_some() && parts.coupling != Coupling::SecondOrder;
        let defects = |part: usize| {
            let defects = c.iter().zip(row_sums(&a[part])).map(|(c, sum)| c - &sum);
            has_rows.then(|| defects.collect::<Vec<_>>())
        };
        let spelled = [0, 1].map(|part| !wrong_rows(defects(part).as_deref()).is_empty());
        let weights = WeightsTheory { spelled, ..search(rule, at_least) };
        let separable = (rule == Rule::Partitioned).then(|| search(Rule::Separable, weights.order + 1).order);
        let least = weights.order.max(separable.unwrap_or(0));
        // Its trees leave out that the weights of q add up to 1, as those of order 1 have it.
        let is_another = rule != Rule::SecondOrder && weights.order > 0;
        let linear = is_another.then(|| search(Rule::SecondOrder, least + 1).order);
        let row_defects = defects(parts.timed());
        let order_in_time = match wrong_rows(row_defects.as_deref()).as_slice() {
            // Time is one more component of a part.
            [] => weights.order,
            _ => order_of(&conditions(&Forest::with_time(rule, weights.order.max(1)))).min(weights.order),
        };
        let mut theory = Self {
            coupling: parts.coupling,
            row_defects,
            timed: parts.timed(),
            a,
            b,
            c,
            weights,
            separable,
            linear,
            order_in_time,
            symplectic_defect: None,
            symmetric: false,
            explicit: false,
            oscillation: None,
        };
        theory.symplectic_defect = theory.symplectic_defect();
        theory.symmetric = theory.is_symmetric();
        theory.explicit = theory.is_explicit();
        theory.oscillation = theory.oscillation();
        theory
    }

    fn stages(&self) -> usize {
        self.c.len()
    }

    /// b_i â_ij + b̂_j a_ji = b_i b̂_j, and b = b̂ unless systems are separable (\[HLW06\] VI.4.6); of a Nyström method
    /// b̄_i = b_i (1 − c_i) and b_i (b̄_j − ā_ij) = b_j (b̄_i − ā_ji) (IV.2.5).
    fn symplectic_defect(&self) -> Option<(String, f64)> {
        let ([a, a_hat], [b, b_hat], s) = (&self.a, &self.b, self.stages());
        let mut all = Vec::new();
        for i in 0..s {
            match self.coupling {
                Coupling::SecondOrder => {
                    let required = &b_hat[i] * &(&Real::one() - &self.c[i]);
                    all.push((format!("b̄_i − b_i (1 − c_i) at i = {}", i + 1), &b[i] - &required));
                }
                Coupling::General => all.push((format!("b_i − b̂_i at i = {}", i + 1), &b[i] - &b_hat[i])),
                Coupling::Separable => {}
            }
            for j in 0..s {
                let place = format!("at i = {}, j = {}", i + 1, j + 1);
                let (text, defect) = if self.coupling == Coupling::SecondOrder {
                    let half = |i: usize, j: usize| &b_hat[i] * &(&b[j] - &a[i][j]);
                    ("b_i (b̄_j − ā_ij) − b_j (b̄_i − ā_ji)", &half(i, j) - &half(j, i))
                } else {
                    let sum = &(&b[i] * &a_hat[i][j]) + &(&b_hat[j] * &a[j][i]);
                    ("b_i â_ij + b̂_j a_ji − b_i b̂_j", &sum - &(&b[i] * &b_hat[j]))
                };
                all.push((format!("{text} {place}"), defect));
            }
        }
        let certain = all.into_iter().filter(|(_, x)| !x.may_be_zero()).map(|(text, x)| (text, x.to_f64()));
        certain.max_by(|x, y| x.1.abs().total_cmp(&y.1.abs()))
    }

    /// Whether it is its own adjoint, with the stages in another order σ: b_σ(j) = b_j and a_σ(i)σ(j) + a_ij = b_j for both parts; of a
    /// Nyström method c_σ(i) = 1 − c_i, b_σ(i) = b_i, b̄_σ(i) = b_i − b̄_i and ā_σ(i)σ(j) − ā_ij = (1 − c_i) b_j − b̄_j.
    fn is_symmetric(&self) -> bool {
        let same = |x: &Real, y: &Real| (x - y).may_be_zero();
        let ([b, b_hat], s) = (&self.b, self.stages());
        match self.coupling {
            Coupling::SecondOrder => {
                let a = &self.a[0];
                let left = |i: usize| &Real::one() - &self.c[i];
                let may = |i: usize, m: usize| {
                    same(&self.c[m], &left(i)) && same(&b_hat[m], &b_hat[i]) && same(&b[m], &(&b_hat[i] - &b[i]))
                };
                let fits = |[i, j]: [usize; 2], [m, n]: [usize; 2]| {
                    same(&(&a[m][n] - &a[i][j]), &(&(&left(i) * &b_hat[j]) - &b[j]))
                };
                has_mirror(s, &may, &fits)
            }
            Coupling::General => {
                let may = |i: usize, m: usize| self.b.iter().all(|b| same(&b[m], &b[i]));
                let fits = |[i, j]: [usize; 2], [m, n]: [usize; 2]| {
                    self.a.iter().zip(&self.b).all(|(a, b)| same(&(&a[m][n] + &a[i][j]), &b[j]))
                };
                has_mirror(s, &may, &fits)
            }
            // Stages of q and of p, those that count, have images of their own; the slopes of q are f at stages of p.
            Coupling::Separable => {
                let counts = |&[part, j]: &[usize; 2]| {
                    !self.b[part][j].may_be_zero() || self.a[part].iter().any(|row| !row[j].may_be_zero())
                };
                let stages: Vec<[usize; 2]> =
                    [0, 1].iter().flat_map(|part| (0..s).map(|j| [*part, j])).filter(counts).collect();
                let may = |i: usize, m: usize| {
                    let ([part, j], [other, n]) = (stages[i], stages[m]);
                    part == other && same(&self.b[part][n], &self.b[part][j])
                };
                let fits = |[i, j]: [usize; 2], [m, n]: [usize; 2]| {
                    let ([of, i], [part, j]) = (stages[i], stages[j]);
                    let (a, b) = (&self.a[part], &self.b[part]);
                    of == part || same(&(&a[stages[m][1]][stages[n][1]] + &a[i][j]), &b[j])
                };
                has_mirror(stages.len(), &may, &fits)
            }
        }
    }

    /// Whether on separable systems every stage follows from earlier ones: those of q need those of p with a_ij ≠ 0, and the other
    /// way round.
    fn is_explicit(&self) -> bool {
        let (s, parts) = (self.stages(), if self.coupling == Coupling::SecondOrder { 1 } else { 2 });
        let needs = |k: usize, known: &[bool]| {
            let (part, i) = (k / s, k % s);
            // A Nyström method has no stages of p.
            let other = if parts == 1 { part } else { 1 - part };
            let needed = |j: usize| !self.a[part][i][j].may_be_zero() && !known[other * s + j];
            (0..s).any(needed)
        };
        let mut known = vec![false; parts * s];
        while let Some(k) = (0..parts * s).find(|k| !known[*k] && !needs(*k, &known)) {
            known[k] = true;
        }
        known.into_iter().all(|known| known)
    }

    /// One step on q̇ = νp, ṗ = −νq, of size 1.
    fn rotation(&self, nu: f64) -> Option<Matrix2<f64>> {
        let s = self.stages();
        let double = |part: usize| DMatrix::from_fn(s, s, |i, j| self.a[part][i][j].to_f64());
        let weights = |part: usize| self.b[part].iter().map(Real::to_f64).collect::<Vec<_>>();
        let (a, b, b_hat) = (double(0), weights(0), weights(1));
        let c: Vec<f64> = self.c.iter().map(Real::to_f64).collect();
        let second_order = self.coupling == Coupling::SecondOrder;
        // Q = q + ν A P and P = p − ν Â Q; or Q = q + c ν p − ν² Ā Q.
        let square = if second_order { a.clone() } else { &a * double(1) };
        let lu = (DMatrix::identity(s, s) + square * (nu * nu)).lu();
        let sums = a.column_sum();
        let column = |start: Vector2<f64>| {
            let from = |i: usize| start.x + nu * start.y * if second_order { c[i] } else { sums[i] };
            let q = lu.solve(&DMatrix::from_fn(s, 1, |i, _| from(i)))?;
            let dot = |b: &[f64], x: &DMatrix<f64>| b.iter().zip(x).map(|(b, x)| b * x).sum::<f64>();
            let end_p = start.y - nu * dot(&b_hat, &q);
            let end_q = if second_order {
                start.x + nu * start.y - nu * nu * dot(&b, &q)
            } else {
                let p = DMatrix::from_element(s, 1, start.y) - double(1) * &q * nu;
                start.x + nu * dot(&b, &p)
            };
            Some(Vector2::new(end_q, end_p))
        };
        Some(Matrix2::from_columns(&[column(Vector2::x())?, column(Vector2::y())?]))
    }

    /// Where areas are kept, steps are bounded while |tr| < 2.
    fn oscillation(&self) -> Option<Bounded> {
        // Some digits above the roundoff of a few products.
        const ROUNDOFF: f64 = 1e-10;
        let keeps = |nu: f64| self.rotation(nu).is_some_and(|m| (m.determinant() - 1.0).abs() <= ROUNDOFF);
        if ![0.3, 0.7, 1.1].into_iter().all(keeps) {
            return None;
        }
        let margin = |nu: f64| self.rotation(nu).map_or(f64::NAN, |m| 2.0 + ROUNDOFF - m.trace().abs());
        let points: Vec<f64> = (0..=6000).map(|k| FARTHEST * f64::from(k) / 6000.0).collect();
        let margins: Vec<f64> = points.iter().map(|nu| margin(*nu)).collect();
        for (nu, margins) in points.windows(3).zip(margins.windows(3)) {
            // A gap may be narrower than the points are apart: |tr| is largest in it.
            let is_least = margins[1] <= margins[0] && margins[1] <= margins[2];
            let lowest = if is_least { minimum([nu[0], nu[2]], 1e-7, margin) } else { nu[1] };
            if margin(lowest).is_nan() || margin(lowest) < 0.0 {
                let end = root([nu[0], lowest], margin).unwrap_or(lowest);
                return Some(Bounded::UpTo { end, witness: lowest });
            }
        }
        Some(Bounded::Everywhere)
    }

    /// Whether a stage has itself or a later one in its row.
    fn is_coupled(&self) -> bool {
        let matrices = if self.coupling == Coupling::SecondOrder { &self.a[..1] } else { &self.a[..] };
        let couples = |(i, row): (usize, &Vec<Real>)| !row[i..].iter().all(Real::may_be_zero);
        matrices.iter().any(|a| a.iter().enumerate().any(couples))
    }

    fn weights_name(&self) -> &'static str {
        match self.coupling {
            Coupling::SecondOrder => "b̄ and b",
            _ => "b and b̂",
        }
    }
}

impl Analysis for PartsTheory {
    fn kind(&self) -> &'static str {
        match self.coupling {
            Coupling::SecondOrder => "nystrom",
            _ => "partitioned-runge-kutta",
        }
    }

    fn headline(&self) -> String {
        let name = match self.coupling {
            Coupling::General => "partitioned Runge–Kutta",
            Coupling::Separable => "partitioned Runge–Kutta for separable systems",
            Coupling::SecondOrder => "Nyström, for q̈ = g(q)",
        };
        let shape = match (self.explicit, self.coupling) {
            (true, Coupling::SecondOrder) => "explicit",
            (true, _) => "explicit on separable systems",
            (false, _) => "implicit",
        };
        format!("{name}, {shape}, {}", counted(self.stages(), "stage"))
    }

    fn order(&self) -> u32 {
        self.weights.order
    }

    fn order_where_separable(&self) -> Option<u32> {
        self.separable
    }

    fn order_where_linear(&self) -> Option<u32> {
        self.linear
    }

    fn order_in_time(&self) -> u32 {
        self.order_in_time
    }

    fn wrong_rows(&self) -> Vec<usize> {
        wrong_rows(self.row_defects.as_deref())
    }

    fn own_times(&self) -> Option<Verdict> {
        own_times(&self.c, self.row_defects.as_deref()?, [self.order_in_time, self.weights.order], "")
    }

    fn facts(&self) -> Facts {
        let mut facts = vec![("order", order_fact(&self.weights))];
        facts.extend(self.separable.map(|order| ("separable", format!("order {order} on q̇ = f(p), ṗ = g(q)"))));
        let beyond = self.linear.filter(|order| *order > self.separable.unwrap_or(self.weights.order));
        facts.extend(beyond.map(|order| ("linear", format!("order {order} on q̇ = M⁻¹p, ṗ = g(q)"))));
        facts.extend(in_time([self.order_in_time, self.weights.order]));
        let oscillations = match self.oscillation {
            None => "areas are not kept on q̇ = ωp, ṗ = −ωq".into(),
            Some(Bounded::Everywhere) => format!("bounded on q̇ = ωp, ṗ = −ωq to hω = {FARTHEST} at least"),
            Some(Bounded::UpTo { end, .. }) => format!("bounded on q̇ = ωp, ṗ = −ωq up to hω = {end:.4}"),
        };
        facts.push(("oscillations", oscillations));
        let not = |holds: bool, what: &str| if holds { what.to_owned() } else { format!("not {what}") };
        let structure = [not(self.symplectic_defect.is_none(), "symplectic"), not(self.symmetric, "symmetric")];
        facts.push(("structure", structure.join(", ")));
        facts
    }

    fn find(&self, property: Property) -> Option<Finding> {
        Some(match property {
            Property::Order(p) => {
                order_in_time(p, self).unwrap_or_else(|| order_finding(p, &self.weights, self.weights_name()))
            }
            Property::Explicit => {
                let text = if self.explicit {
                    "every stage follows from earlier ones"
                } else {
                    "some stages have to be solved for"
                };
                Finding::new(self.explicit, text)
            }
            Property::Symplectic => match &self.symplectic_defect {
                None => Finding::new(true, "the conditions on the products of the coefficients hold for all i, j"),
                Some((place, x)) => Finding::new(false, format!("{place} is {x:.4e}")).measured(*x),
            },
            Property::Symmetric => {
                let text = if self.symmetric {
                    "its own adjoint, with its stages in another order"
                } else {
                    "not its own adjoint, in whatever order its stages are"
                };
                Finding::new(self.symmetric, text)
            }
            Property::ImaginaryInterval(y) => match self.oscillation {
                None => Finding::new(false, "areas are not kept on q̇ = ωp, ṗ = −ωq"),
                Some(Bounded::Everywhere) => {
                    let why = format!(
                        "|tr| ≤ 2 of a step on q̇ = ωp, ṗ = −ωq to hω = {FARTHEST} at least, no farther looked at"
                    );
                    let outcome = if y.value <= FARTHEST { Outcome::Pass } else { Outcome::Inconclusive };
                    Finding { outcome, measured: None, why }
                }
                Some(Bounded::UpTo { end, witness }) => {
                    let (outcome, words) = y.is_reached(end, FOUND);
                    let why = format!(
                        "|tr| ≤ 2 of a step on q̇ = ωp, ṗ = −ωq up to hω = {end:.6}, and not at {witness:.2}{words}"
                    );
                    Finding { outcome, measured: Some(end), why }
                }
            },
            _ => return None,
        })
    }

    fn consistency(&self) -> Vec<Verdict> {
        let orders = [self.order_in_time, self.weights.order];
        self.row_defects.iter().map(|defects| rows(&self.c, defects, ["a", "â"][self.timed], orders)).collect()
    }

    fn traits(&self) -> Traits {
        let symplectic = match (&self.symplectic_defect, self.coupling) {
            (Some(_), _) => Symplecticity::Never,
            (None, Coupling::General) => Symplecticity::Always,
            (None, _) => Symplecticity::ConstantMass,
        };
        let stability = if self.explicit { Stability::Conditional } else { Stability::Neutral };
        let traits = Traits::new(self.order_in_time, Principle::Equation, stability);
        Traits { stiff_order: None, symplectic, is_reversible: self.symmetric, ..traits }
    }

    fn rounding_of_coefficients(&self, _size: f64, length: f64, _steps: f64) -> f64 {
        self.weights.resolution() * length
    }

    fn moved(&self, by: f64) -> Vec<(f64, Arc<dyn Analysis>)> {
        let mut out: Vec<(f64, Arc<dyn Analysis>)> = Vec::new();
        let mut with = |radius: f64, change: &dyn Fn(&mut Self)| {
            let mut moved = self.clone();
            change(&mut moved);
            out.push((radius, Arc::new(moved)));
        };
        let by = Real::double(by);
        for part in 0..2 {
            for (i, b) in self.b[part].iter().enumerate().filter(|(_, b)| b.is_rough()) {
                with(b.radius(), &|theory| theory.b[part][i] = b + &by);
            }
            for (i, row) in self.a[part].iter().enumerate() {
                for (j, a) in row.iter().enumerate().filter(|(_, a)| a.is_rough()) {
                    with(a.radius(), &|theory| theory.a[part][i][j] = a + &by);
                }
            }
        }
        // The stages of a Nyström method start from q + c_i h p; those of others have c in their times alone.
        let is_start = |c: &Real| self.coupling == Coupling::SecondOrder && c.is_rough();
        for (i, c) in self.c.iter().enumerate().filter(|(_, c)| is_start(c)) {
            with(c.radius(), &|theory| theory.c[i] = c + &by);
        }
        out
    }

    fn unknowns(&self) -> usize {
        if self.is_coupled() { self.stages() } else { 0 }
    }

    fn dearer(&self) -> Option<&'static str> {
        (self.explicit && self.is_coupled()).then_some(
            "its stages were solved for together, as q̇ = f(q, p), ṗ = g(q, p) takes; on separable systems each follows from \
             earlier ones, and steps cost less",
        )
    }

    fn on_field<'a>(&self, field: Box<dyn VectorField + 'a>) -> Result<Box<dyn Integrator + 'a>, String> {
        let double = |list: &[Real]| list.iter().map(Real::to_f64).collect::<Vec<_>>();
        let halves = Halves {
            coupling: self.coupling,
            a: self.a.each_ref().map(|a| a.iter().map(|row| double(row)).collect()),
            b: self.b.each_ref().map(|b| double(b)),
            c: double(&self.c),
        };
        Ok(Box::new(Stepper::halves(halves, field)?))
    }

    fn trials(&self) -> Vec<Trial> {
        let (order, from) = (self.weights.order, "the conditions of the coloured trees");
        let not_separable = match self.coupling {
            Coupling::General => Trial::on("not separable", "double-pendulum", &[], order, from),
            _ => Trial { kind: "not separable", name: "double-pendulum", plan: Err("it is not made for that".into()) },
        };
        let mut trials = vec![
            Trial::on("separable", "pendulum", &[], self.separable.unwrap_or(order), from),
            Trial::on("oscillating", "henon-heiles", &[], self.separable.unwrap_or(order), from),
            not_separable,
        ];
        let (in_time, window) = (self.order_in_time, window(self.order_in_time));
        let rows = if self.wrong_rows().is_empty() { from } else { "the conditions with c as given" };
        match self.coupling {
            Coupling::General => {
                let name = ("non-autonomous", "q̇ = f(t, q, p), ṗ = g(t, q, p)");
                trials.push(Trial::of(name, NonAutonomous, window, in_time, rows));
            }
            // Where c are the times of p, they are those of q̇ = f(t, p).
            Coupling::Separable if self.timed == 0 => {
                trials.push(Trial::of(Forced::NAME, Forced, window, in_time, rows));
            }
            _ => {}
        }
        trials
    }

    fn has_structure(&self) -> bool {
        true
    }

    fn tables(&self) -> Vec<Table> {
        vec![WeightsTheory::table([("", &self.weights)].into_iter())]
    }
}

#[cfg(test)]
mod tests {
    use super::super::file::{Body, MethodFile, Shipped};
    use super::super::{Effort, Judgement};
    use super::*;
    use experiments::measure::norm::distance;
    use experiments::problem;
    use lsvi::{Grid, State};

    #[test]
    fn a_method_is_symmetric_and_explicit_whatever_the_order_of_its_stages() {
        let outcomes = |text: &str| {
            let file = MethodFile::parse("m.toml", "m", text).expect("a method");
            let theory = file.body.analyse(None, None);
            [Property::Symmetric, Property::Explicit].map(|property| theory.find(property).expect("looked at").outcome)
        };
        let (pass, fail) = (Outcome::Pass, Outcome::Fail);
        // Each of two stages at ½ is its own image.
        let nystrom = |last: &str| {
            format!(
                "kind = 'nystrom'\na = [[0, 0], ['{last}', 0]]\nb_bar = ['1/4', '1/4']\nb = ['1/2', '1/2']\nc = ['1/2', '1/2']\n"
            )
        };
        assert_eq!(outcomes(&nystrom("1/100")), [pass, pass]);
        let permuted = "kind = 'nystrom'\na = [[0, '1/100'], [0, 0]]\nb_bar = ['1/4', '1/4']\nb = ['1/2', '1/2']\nc = ['1/2', '1/2']\n";
        assert_eq!(outcomes(permuted), [pass, pass]);
        assert_eq!(outcomes(&nystrom("1/100").replace("['1/4', '1/4']", "['1/4', '1/8']")), [fail, pass]);
        // Störmer and Verlet's, its two stages in both orders.
        let verlet = "kind = 'partitioned-runge-kutta'\na = [[0, 0], ['1/2', '1/2']]\na_hat = [['1/2', 0], ['1/2', 0]]\nb = ['1/2', '1/2']\nb_hat = ['1/2', '1/2']\n";
        let turned = "kind = 'partitioned-runge-kutta'\na = [['1/2', '1/2'], [0, 0]]\na_hat = [[0, '1/2'], [0, '1/2']]\nb = ['1/2', '1/2']\nb_hat = ['1/2', '1/2']\n";
        assert_eq!((outcomes(verlet)[0], outcomes(turned)[0]), (pass, pass));
        let separable = |text: &str| {
            outcomes(&text.replace("'partitioned-runge-kutta'\n", "'partitioned-runge-kutta'\nsystems = 'separable'\n"))
        };
        assert_eq!((separable(verlet), separable(turned)), ([pass, pass], [pass, pass]));
    }

    /// The trapezoidal rule for q and for p, with a wrong entry: it is that of a, however right the rows of â are, and that of â beside those of a.
    #[test]
    fn a_single_row_of_a_that_does_not_add_up_is_no_sign_of_a_time_in_p() {
        let (right, wrong) = ("[[0, 0], ['1/2', '1/2']]", "[[0, 0], ['1/2', '1/3']]");
        let rows = |a: &str, hat: &str| {
            let text = format!(
                "kind = 'partitioned-runge-kutta'\norder = 2\nc = [0, 1]\na = {a}\nb = ['1/2', '1/2']\n\
                 a_hat = {hat}\nb_hat = ['1/2', '1/2']\n"
            );
            let file = MethodFile::parse("m.toml", "m", &text).expect("well-formed");
            let judgement = Judgement::new(file, Effort::Theory);
            let rows = judgement.verdicts.iter().find(|verdict| verdict.subject == "row sums").expect("c is stated");
            (rows.check.outcome, rows.check.reason.clone())
        };
        let told = "row 2 adds up to 0.8333333333, and c[2] is 1.0000000000".to_owned();
        assert_eq!(rows(wrong, right), (Outcome::Fail, told));
        assert_eq!(rows(right, wrong), (Outcome::Pass, "c_i = Σ_j a_ij in every row".to_owned()));
    }

    /// Stages that follow one from another where q̇ = f(p), ṗ = g(q) are solved for together; those of Nyström's method are not.
    #[test]
    fn what_steps_cost_beyond_need_is_told() {
        for (name, unknowns, is_dearer) in
            [("stormer-verlet", 2, true), ("ruth3", 3, true), ("lobatto-iiia-iiib3", 3, false), ("nystrom4", 0, false)]
        {
            let file = Shipped::by_name(name).expect("there").read().expect("well-formed");
            let theory = file.body.analyse(None, None);
            assert_eq!((theory.unknowns(), theory.dearer().is_some()), (unknowns, is_dearer), "{name}");
        }
        for name in ["adams-bashforth4", "gauss3"] {
            let file = Shipped::by_name(name).expect("there").read().expect("well-formed");
            assert_eq!(file.body.analyse(None, None).dearer(), None, "{name}");
        }
    }

    /// A step of h = 1 of Nyström's method with one stage from q = 0, p = 1 on q̈ = −q is q = 1 − b̄ c, p = 1 − b c; a is 0 and exact.
    #[test]
    fn each_rough_number_is_moved_by_itself() {
        const BY: f64 = 1e-3;
        let (b_bar, b, c) = (0.412, 0.937, 0.583);
        let nystrom =
            format!("kind = 'nystrom'\na = [[0]]\nb_bar = ['{b_bar}']\nb = ['{b}']\nc = ['{c}']\ndigits = 3\n");
        let theory = |text: &str| MethodFile::parse("m.toml", "m", text).expect("well-formed").body.analyse(None, None);
        let oscillator = problem::build_setting("harmonic-oscillator omega=1").expect("registered");
        let found: Vec<Vec<f64>> = theory(&nystrom)
            .moved(BY)
            .into_iter()
            .map(|(radius, moved)| {
                assert!((0.4e-3..0.6e-3).contains(&radius), "half a unit of three digits: {radius}");
                let mut steps = moved.on_field(oscillator.field()).expect("it applies");
                let mut state = State::new(0.0, vec![0.0, 1.0]);
                steps.advance(&mut state, &Grid::new(0.0, 1.0, 1.0).expect("a grid")).expect("explicit");
                state.q
            })
            .collect();
        let step = |b_bar: f64, b: f64, c: f64| [1.0 - b_bar * c, 1.0 - b * c];
        let expected = [step(b_bar + BY, b, c), step(b_bar, b + BY, c), step(b_bar, b, c + BY)];
        assert_eq!(found.len(), 3);
        for (found, expected) in found.iter().zip(&expected) {
            assert!(distance(found, expected) < 1e-12, "{found:?} where {expected:?} is expected");
        }
        // On q̇ = p, ṗ = −q their rows alone count, and no c; each of two matrices of one entry, and of two weights.
        let pair = "kind = 'partitioned-runge-kutta'\nsystems = 'separable'\nc = ['0.412']\na = [['0.412']]\nb = ['0.937']\n\
                    a_hat = [['0.583']]\nb_hat = ['0.871']\ndigits = 3\n";
        assert_eq!(theory(pair).moved(BY).len(), 4);
    }

    /// Σ b_i c_i is 11/24 where b_i adds up to 1: the order is 2 without t, and 1 with it.
    #[test]
    fn a_pair_is_taken_to_have_its_order_in_time() {
        let text = "kind = 'partitioned-runge-kutta'\norder = 1\nc = ['1/4', '2/3']\n\
                    a = [[0, 0], ['1/2', '1/2']]\nb = ['1/2', '1/2']\n\
                    a_hat = [['1/2', 0], ['1/2', 0]]\nb_hat = ['1/2', '1/2']\n";
        let theory = MethodFile::parse("m.toml", "m", text).expect("well-formed").body.analyse(Some(1), None);
        assert_eq!((theory.order(), theory.order_in_time(), theory.traits().order), (2, 1, 1));
        let told = ("in time", "1 on v̇ = f(t, v), with c as given".to_owned());
        assert!(theory.facts().contains(&told), "{:?}", theory.facts());
        let times = theory.own_times().expect("c is not the sums").check.reason;
        assert!(times.ends_with("; on v̇ = f(t, v) the order is 1 where without t it is 2"), "{times}");
    }

    /// The trapezoidal rule for q and for p: forces at times c are run where c are the sums of the rows of a, by which q moves.
    #[test]
    fn forces_in_time_are_run_where_they_have_the_times_of_q() {
        let (a, hat) = ("[[0, 0], ['1/2', '1/2']]", "[['1/2', 0], ['1/2', 0]]");
        for (first, second, is_run) in [(a, hat, true), (hat, a, false)] {
            let text = format!(
                "kind = 'partitioned-runge-kutta'\nsystems = 'separable'\nc = [0, 1]\na = {first}\nb = ['1/2', '1/2']\n\
                 a_hat = {second}\nb_hat = ['1/2', '1/2']\n"
            );
            let theory = MethodFile::parse("m.toml", "m", &text).expect("well-formed").body.analyse(None, None);
            assert_eq!(theory.trials().iter().any(|trial| trial.kind == "non-autonomous"), is_run, "{text}");
        }
    }

    /// b ≠ b̂, and â_ij = b̂_j (1 − a_ji/b_i), so that b_i â_ij + b̂_j a_ji = b_i b̂_j: enough where H = T(p) + U(q), and only there.
    #[test]
    fn weights_that_differ_are_symplectic_on_separable_systems_alone() {
        let symplectic = |systems: &str| {
            let text = format!(
                "kind = 'partitioned-runge-kutta'\nsystems = '{systems}'\nclaims = ['symplectic']\n\
                 a = [['1/4', '1/4'], ['1/4', '1/4']]\nb = ['1/2', '1/2']\n\
                 a_hat = [['1/8', '3/8'], ['1/8', '3/8']]\nb_hat = ['1/4', '3/4']\n"
            );
            let judgement =
                Judgement::new(MethodFile::parse("m.toml", "m", &text).expect("well-formed"), Effort::Theory);
            let verdict = judgement.verdicts.iter().find(|verdict| verdict.subject == "symplectic").expect("claimed");
            verdict.check.outcome
        };
        assert_eq!((symplectic("separable"), symplectic("all")), (Outcome::Pass, Outcome::Fail));
    }

    const VERLET: &str = "kind = 'partitioned-runge-kutta'\na = [[0, 0], ['1/2', '1/2']]\na_hat = [['1/2', 0], ['1/2', 0]]\n\
                          b = ['1/2', '1/2']\nb_hat = ['1/2', '1/2']\n";

    fn parts(text: &str) -> Parts {
        let file = MethodFile::parse("m.toml", "m", text).expect("well-formed");
        let Body::Parts(parts) = file.body else { panic!("{text}") };
        parts
    }

    fn theory(text: &str) -> PartsTheory {
        PartsTheory::new(&parts(text), None)
    }

    #[test]
    fn times_are_those_of_p_where_more_of_its_rows_add_up_to_them() {
        let (right, wrong) =
            ("[['1/4', 0, 0], ['1/4', '1/4', 0], ['1/4', '1/4', '1/4']]", "[[0, 0, 0], [0, 0, 0], [0, 0, 0]]");
        let timed = |a: &str, hat: &str| {
            let b = "['1/3', '1/3', '1/3']";
            let text = format!(
                "kind = 'partitioned-runge-kutta'\nc = ['1/4', '1/2', '3/4']\na = {a}\nb = {b}\na_hat = {hat}\nb_hat = {b}\n"
            );
            parts(&text).timed()
        };
        assert_eq!((timed(right, wrong), timed(wrong, right)), (0, 1));
        assert_eq!((timed(right, right), timed(wrong, wrong)), (0, 0));
    }

    /// Its adjoint has the same stages, each with the index after its own, and so with the weight of another.
    #[test]
    fn a_method_with_the_stages_of_its_adjoint_and_other_weights_is_not_symmetric() {
        let nystrom = "kind = 'nystrom'\nc = ['1/2', '1/2', '1/2']\nb_bar = ['1/6', '1/3', 0]\nb = ['1/2', '1/3', '1/6']\n\
                       a = [['1/6', '1/2', 0], ['1/12', '1/4', '1/3'], ['5/12', '1/6', '1/12']]\n";
        let pair = "kind = 'partitioned-runge-kutta'\nsystems = 'separable'\n\
                    a = [['1/6', '1/3', 0], [0, 0, 0], [0, 0, 0]]\nb = ['1/2', '1/3', '1/6']\n\
                    a_hat = [['1/2', 0, 0], ['1/2', 0, 0], ['1/2', 0, 0]]\nb_hat = [1, 0, 0]\n";
        for text in [nystrom, pair] {
            assert!(!theory(text).symmetric, "{text}");
        }
    }

    /// p − νq/2, then q by it, then p by the q that it leads to.
    #[test]
    fn a_step_of_stormer_and_verlet_on_an_oscillator_is_a_kick_a_drift_and_a_kick() {
        for nu in [0.5, 1.0, 3.0] {
            let half = 1.0 - 0.5 * nu * nu;
            let expected = Matrix2::new(half, nu, -nu * (1.0 - 0.25 * nu * nu), half);
            let found = theory(VERLET).rotation(nu).expect("explicit");
            assert!((found - expected).norm() < 1e-13, "{nu}: {found}");
        }
    }

    #[test]
    fn oscillations_are_shown_not_to_stay_bounded_beside_the_end_of_those_that_do() {
        let Some(Bounded::UpTo { end, witness }) = theory(VERLET).oscillation else { panic!("up to 2") };
        assert!((end - 2.0).abs() < FOUND && witness > end && witness < end + 0.02, "{end}, {witness}");
    }

    #[test]
    fn conditions_are_told_of_the_weights_that_a_file_has() {
        let nystrom =
            "kind = 'nystrom'\na = [[0, 0], ['1/2', 0]]\nb_bar = ['1/2', 0]\nb = ['1/2', '1/2']\nc = [0, 1]\n";
        for (text, names, formulas) in
            [(nystrom, "b̄ and b", ["Σ b_i = 1", "Σ b̄_i = 1/2"]), (VERLET, "b and b̂", ["Σ b_i = 1", "Σ b̂_i = 1"])]
        {
            let theory = theory(text);
            let why = theory.find(Property::Order(3)).expect("looked at").why;
            assert!(why.contains(&format!(" conditions on {names} fail")), "{why}");
            let conditions = &theory.weights.conditions;
            let found: Vec<String> = conditions.iter().map(|c| theory.weights.formula(c.tree, "none")).collect();
            for formula in formulas {
                assert!(found.iter().any(|found| found == formula), "{formula} is not among {found:?}");
            }
        }
    }

    /// Symplectic Euler is no palindrome.
    #[test]
    fn what_is_known_of_a_pair_follows_from_its_coefficients() {
        let euler = "kind = 'partitioned-runge-kutta'\na = [[0]]\na_hat = [[1]]\nb = [1]\nb_hat = [1]\n";
        for (text, is_reversible) in [(VERLET, true), (euler, false)] {
            let traits = theory(text).traits();
            assert_eq!((traits.is_reversible, traits.stiff_order), (is_reversible, None), "{text}");
        }
    }

    #[test]
    fn rounded_coefficients_of_a_pair_move_the_end_along_the_path() {
        let theory = theory(&VERLET.replace("'1/2'", "'0.500'").replace("kind", "digits = 3\nkind"));
        let open = theory.weights.resolution();
        assert!(open > 1e-4 && open < 1e-2, "{open:e}");
        for length in [0.5, 3.0] {
            assert_eq!(theory.rounding_of_coefficients(7.0, length, 100.0), open * length);
        }
    }

    #[test]
    fn systems_that_are_not_separable_are_run_where_a_pair_is_made_for_them() {
        let separable = VERLET.replace("\na =", "\nsystems = 'separable'\na =");
        for (text, is_run) in [(VERLET, true), (&separable, false)] {
            let trials = theory(text).trials();
            let trial = trials.iter().find(|trial| trial.kind == "not separable").expect("told of");
            assert_eq!(trial.plan.is_ok(), is_run, "{text}");
        }
    }
}
