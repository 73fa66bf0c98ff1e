//! Convergence data from anywhere: the values of a quantity on several grids, its order, limit and uncertainty, and a verdict
//! of three values.
//!
//! Values are taken to be φ(h) = φ₀ + C hᵖ(1 + o(1)). What can be said depends on what is given:
//!
//! - Three grids determine p, C and φ₀, and nothing is left to test them with. They **pass** where an order is expected and
//!   found; another order than the expected one is *inconclusive*, since the grids may be too coarse.
//! - From four grids on, the orders of successive triplets must agree, with each other and with the order that their drift
//!   leads to. Settled at the expected order they **pass**, settled at another one they **fail**. Orders that move away from
//!   the expected one, by more than digits explain and so fast that the next refinement would leave the band, are
//!   *inconclusive*.
//! - Differences that grow, on the two finest triplets and by more than the digits allow, refute convergence where they grow
//!   by a law, or beyond the values themselves: they **fail**. Noise of any size grows on two triplets now and then, and does
//!   so by no law.
//! - With the exact value known the errors themselves are fitted, by the rules of [`order`](super::order).
//!
//! Where no order is expected there is none to pass or fail: one that has settled is **measured**.
//!
//! A difference counts where it is [`FLOOR_MARGIN`] times the resolution of the values, the half unit of the last digit that
//! was given, or of the noise that the finest grids show. The finest grids, where they differ by less or by rounding, are left
//! out. Two grids, equal spacings, missing
//! values, differences that vanish or alternate in sign decide nothing.

pub mod data;
pub mod least_squares;
mod noise;
pub mod three_grids;

use std::fmt;

use serde::Serialize;

use super::decimal::{decimals, significant, trimmed};
use super::norm::max_norm;
use super::order::{Expectation, FLOOR_MARGIN, Line, Measured, OrderFit, Reason, Sample, Verdict, fit, fit_freely};
use least_squares::LeastSquares;
use three_grids::{SAFETY, Triplet, TripletError};

/// Half-width of the band around an expected order, unless another one is asked for: orders come in halves where solutions are
/// not smooth, and a quarter tells neighbouring halves apart.
pub const BAND: f64 = 0.25;

/// The order of most schemes in space.
const SECOND: f64 = 2.0;

/// Highest order that is believed without being expected: methods in use have 8 at most, extrapolation seldom more than 10.
const HIGHEST: f64 = 10.0;

/// A value on a grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Spacing of the grid or size of the time step, > 0; only ratios matter.
    pub h: f64,
    /// Value of the quantity; `None` where it is missing or not a number.
    pub value: Option<f64>,
}

/// A quantity on several grids, in any sequence.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// Its name.
    pub name: String,
    /// The grids.
    pub grids: Vec<Grid>,
    /// Half a unit of the last digit of its values; 0 for values of full precision.
    pub resolution: f64,
}

/// What is asked of a quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Question {
    /// The order that it should have.
    pub expected: Option<f64>,
    /// Largest distance from the expected order; settled orders spread by half of it at most.
    pub band: f64,
    /// Its exact value.
    pub exact: Option<f64>,
}

impl Default for Question {
    fn default() -> Self {
        Self { expected: None, band: BAND, exact: None }
    }
}

/// How a quantity behaves under refinement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Convergence {
    /// Differences shrink and keep their sign.
    Monotonic,
    /// Differences shrink and alternate in sign.
    Oscillatory,
    /// Differences keep their sign and do not shrink.
    Divergent,
    /// Differences alternate in sign and do not shrink.
    OscillatoryDivergent,
    /// A difference is no larger than what the digits of the values resolve.
    Unresolved,
    /// The data do not tell: fewer than three usable grids.
    Unknown,
}

impl fmt::Display for Convergence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Monotonic => "monotonic",
            Self::Oscillatory => "oscillatory",
            Self::Divergent => "divergent",
            Self::OscillatoryDivergent => "oscillatory and divergent",
            Self::Unresolved => "unresolved",
            Self::Unknown => "unknown",
        })
    }
}

/// What the data say of a quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Judgement {
    /// Its behaviour on the three finest grids.
    pub convergence: Convergence,
    /// The order: of the fit to the errors where the exact value is known, else of the least-squares fit from four grids
    /// on, else of the three grids; `None` where no power law holds.
    pub order: Option<f64>,
    /// How far the order is uncertain: by the digits of the values, and by the scatter and the drift of a fit.
    pub uncertainty: Option<f64>,
    /// The limit for h → 0, from where the order is from.
    pub extrapolated: Option<f64>,
    /// Grid convergence index of the finest grid as a part of its value, 1.25 |e_a|/(r^p − 1), with the order of the three
    /// finest grids.
    pub gci: Option<f64>,
    /// Triplets of neighbouring grids, coarse to fine.
    pub triplets: Vec<Result<Triplet, TripletError>>,
    /// Orders of the errors of neighbouring grids, coarse to fine, where the exact value is known.
    pub pairs: Vec<f64>,
    /// The fit of Eça and Hoekstra to the grids that the order is from, or to all where they have none, from four on; `None` where
    /// the finest three diverge by a law or are not resolved.
    pub least_squares: Option<LeastSquares>,
    /// Number of grids, from the finest that is used, that the order and the fit are from.
    pub used: usize,
    /// The decision.
    pub verdict: Verdict,
    /// The decision in words.
    pub reason: String,
    /// What else is to be known.
    pub notes: Vec<String>,
}

/// Roundings that a run of thousands of steps, or of iterations, leaves in a value.
const ROUNDINGS: f64 = 1000.0;

/// The first of the points, fine to coarse, that differs from the next by more than digits and rounding; 0 unless three are
/// left, and where what is left has a law by which the difference should be larger: values that stand still have not
/// converged.
fn first_above_floor(points: &[(f64, f64)], resolution: f64) -> usize {
    let least = |value: f64| least_difference(resolution, value).max(ROUNDINGS * f64::EPSILON * value.abs());
    let first = points.windows(2).take_while(|pair| (pair[0].1 - pair[1].1).abs() <= least(pair[1].1)).count();
    let [h1, h2, h3] = match points.get(first..) {
        Some([one, two, three, ..]) if first > 0 => [*one, *two, *three],
        _ => return 0,
    };
    let power = |point: (f64, f64), p: f64| point.0.powf(p);
    match Triplet::new([h1, h2, h3], resolution) {
        Ok(Triplet { order: p, oscillates: false, .. }) => {
            let finer = points[first - 1];
            let next = (h2.1 - h1.1) * (power(h1, p) - power(finer, p)) / (power(h2, p) - power(h1, p));
            if next.abs() <= 2.0 * least(h1.1) { first } else { 0 }
        }
        _ => 0,
    }
}

/// `; left out at the floor of digits and rounding: h = 0.1`, where `why` is the floor.
fn left_out(why: &str, spacings: impl Iterator<Item = f64>) -> String {
    let spacings: Vec<String> = spacings.map(spacing).collect();
    if spacings.is_empty() {
        return String::new();
    }
    format!("; left out {why}: h = {}", spacings.join(", "))
}

/// Why the finest grids are left out.
const FLOORED: &str = "at the floor of digits and rounding";
/// Why the coarsest are.
const TOO_COARSE: &str = "as too coarse, with orders that do not agree with those of the finer grids";

impl Quantity {
    /// Judges the quantity.
    #[must_use]
    pub fn judge(&self, question: &Question) -> Judgement {
        let mut grids = self.grids.clone();
        grids.sort_by(|a, b| a.h.total_cmp(&b.h));
        if let Some(reason) = unusable(&grids) {
            return Judgement::undecided(Convergence::Unknown, reason);
        }
        let all: Vec<(f64, f64)> = grids.iter().filter_map(|grid| Some((grid.h, grid.value?))).collect();
        let rounding = self.resolution.max(ROUNDINGS * f64::EPSILON * all[0].1.abs());
        let noise = noise::amplitude(&all, self.resolution, question.band);
        let noise = noise.filter(|noise| question.exact.is_none() && *noise > rounding);
        let resolution = noise.unwrap_or(self.resolution);
        let floored = if question.exact.is_none() { first_above_floor(&all, resolution) } else { 0 };
        let (floored, points) = all.split_at(floored);
        let triplets = triplets(points, resolution);
        let Some(finest) = triplets.last() else {
            let mut judgement =
                Judgement::undecided(Convergence::Unknown, "two grids determine no order; a third one does".into());
            if let Some(exact) = question.exact {
                judgement.pairs = pair_orders(points, exact);
                judgement.reason =
                    "two grids have an order against the exact value, and nothing is left to test it with".into();
            }
            return judgement;
        };
        let mut judgement = Judgement {
            convergence: Convergence::of(finest),
            triplets,
            used: points.len(),
            ..Judgement::undecided(Convergence::Unknown, String::new())
        };
        match question.exact {
            Some(exact) => judgement.decide_by_errors(points, exact, self.resolution, question),
            None => {
                judgement.decide_by_differences(points, resolution, question);
                let floor = noise.map_or_else(
                    || FLOORED.into(),
                    |noise| {
                        format!("at a floor of noise of {noise:.0e}, where differences change sign and fall no more")
                    },
                );
                judgement.reason += &left_out(TOO_COARSE, points[judgement.used..].iter().rev().map(|point| point.0));
                judgement.reason += &left_out(&floor, floored.iter().map(|point| point.0));
                judgement.notes.extend(self.may_be_errors(points[0].1, judgement.extrapolated));
            }
        }
        judgement.notes.extend(self.may_be_cells(&grids));
        if points.len() >= 4 && (judgement.convergence == Convergence::Monotonic || judgement.may_scatter(question)) {
            judgement.least_squares = LeastSquares::fit(&points[..judgement.used]).ok();
            judgement.notes.extend(judgement.scatter());
        }
        judgement
    }

    /// A hint for spacings that look as if they were numbers of cells, of three grids or more: whole numbers with which a quantity settles as
    /// they grow.
    fn may_be_cells(&self, grids: &[Grid]) -> Option<String> {
        let is_count = |grid: &Grid| grid.h >= 2.0 && grid.h.fract() == 0.0;
        let changes: Vec<f64> = grids.windows(2).filter_map(|p| Some((p[1].value? - p[0].value?).abs())).collect();
        let settles = changes.windows(2).all(|pair| pair[1] < pair[0]);
        (settles && grids.iter().all(is_count)).then(|| {
            format!(
                "the spacings are whole numbers, and `{}` settles as they grow: numbers of cells are read by `--cells COLUMN \
                 --dimension D`, in place of `--step`",
                self.name
            )
        })
    }

    /// A hint for a column that looks as if it held errors: by its name, or because it tends to nothing.
    fn may_be_errors(&self, finest: f64, limit: Option<f64>) -> Option<String> {
        let is_small = limit.is_some_and(|limit| limit.abs() <= 0.05 * finest.abs());
        (is_small || self.name.to_lowercase().contains("err")).then(|| {
            format!("if the values of `{}` are errors, their limit is known: `--exact 0` fits them as such", self.name)
        })
    }
}

/// Triplets of neighbouring grids, coarse to fine, of `points` from fine to coarse.
fn triplets(points: &[(f64, f64)], resolution: f64) -> Vec<Result<Triplet, TripletError>> {
    points.windows(3).map(|p| Triplet::new([p[0], p[1], p[2]], resolution)).rev().collect()
}

/// Sizes of values of whose differences, eight digits smaller, the squares are normal numbers, with room for sums of them.
const SQUARED: std::ops::Range<f64> = 1e-140..1e140;

/// Why no order can be had of the sorted grids.
fn unusable(grids: &[Grid]) -> Option<String> {
    if let Some(grid) = grids.iter().find(|grid| !grid.value.is_some_and(f64::is_finite)) {
        return Some(format!(
            "the value on the grid of spacing {} is missing or not a number; without its row the others may decide",
            spacing(grid.h)
        ));
    }
    if let Some(grid) = grids.iter().find(|grid| !(grid.h > 0.0 && grid.h.is_finite())) {
        return Some(format!("the spacing {} is not positive", grid.h));
    }
    let size = max_norm(&grids.iter().filter_map(|grid| grid.value).collect::<Vec<_>>());
    if size > 0.0 && !SQUARED.contains(&size) {
        return Some(format!(
            "the squares of values as {size:e} are out of range; in other units the values may decide"
        ));
    }
    let equal = grids.windows(2).find(|pair| pair[1].h / pair[0].h <= 1.0 + 4.0 * f64::EPSILON);
    equal.map(|pair| format!("two grids have the same spacing {}", spacing(pair[0].h))).or_else(|| {
        (grids.len() < 2).then(|| {
            format!(
                "{} no order; three do",
                if grids.is_empty() { "no grids determine" } else { "one grid determines" }
            )
        })
    })
}

/// Six digits of a spacing, which may be computed.
fn spacing(h: f64) -> String {
    trimmed(h, 6)
}

/// ln(e₂/e₁)/ln(h₂/h₁) of neighbouring grids, coarse to fine.
fn pair_orders(points: &[(f64, f64)], exact: f64) -> Vec<f64> {
    let slope = |p: &[(f64, f64)]| ((p[1].1 - exact).abs() / (p[0].1 - exact).abs()).ln() / (p[1].0 / p[0].0).ln();
    points.windows(2).rev().map(slope).collect()
}

impl Convergence {
    fn of(finest: &Result<Triplet, TripletError>) -> Self {
        match finest {
            Ok(triplet) if triplet.oscillates => Self::Oscillatory,
            Ok(_) => Self::Monotonic,
            Err(TripletError::Diverging { certain: false, .. }) => Self::Unresolved,
            Err(TripletError::Diverging { oscillates: true, .. }) => Self::OscillatoryDivergent,
            Err(TripletError::Diverging { oscillates: false, .. }) => Self::Divergent,
            Err(TripletError::Unresolved { .. }) => Self::Unresolved,
            Err(TripletError::NoOrder { oscillates: true, .. } | TripletError::SeveralOrders { .. }) => {
                Self::Oscillatory
            }
            Err(TripletError::NoOrder { .. }) => Self::Monotonic,
        }
    }
}

impl Judgement {
    fn undecided(convergence: Convergence, reason: String) -> Self {
        Self {
            convergence,
            order: None,
            uncertainty: None,
            extrapolated: None,
            gci: None,
            triplets: Vec::new(),
            pairs: Vec::new(),
            least_squares: None,
            used: 0,
            verdict: Verdict::Inconclusive,
            reason,
            notes: Vec::new(),
        }
    }

    /// A hint where the order is D times the one that is expected, or 2 D where none is: cells a side, in `column`, are none of a
    /// grid of D dimensions.
    #[must_use]
    pub fn may_be_per_side(&self, column: &str, dimension: u32, question: &Question) -> Option<String> {
        let (order, times) = (self.order?, f64::from(dimension));
        let formal = question.expected.unwrap_or(SECOND);
        let is_multiple = dimension > 1 && (order / times - formal).abs() <= question.band;
        (is_multiple && (order - formal).abs() > question.band).then(|| {
            format!(
                "the order found is {dimension} times {formal}: if `{column}` counts the cells along a side and not all of them, \
                 `--dimension 1` has the spacing"
            )
        })
    }

    /// Whether what the finest grids do may be scatter about a limit, which a fit to all grids finds.
    fn may_scatter(&self, question: &Question) -> bool {
        let changes = matches!(
            self.convergence,
            Convergence::Oscillatory | Convergence::OscillatoryDivergent | Convergence::Divergent
        );
        changes && self.verdict == Verdict::Inconclusive && question.exact.is_none()
    }

    /// How far values without an order scatter about the fit to them.
    fn scatter(&self) -> Option<String> {
        let fit = self.least_squares.filter(|_| self.convergence != Convergence::Monotonic)?;
        let [deviation, change] = [fit.deviation, fit.change].map(|x| significant(x, 2));
        Some(format!(
            "the values scatter about the least-squares fit with a standard deviation of {deviation}, where they change by {change} from \
             grid to grid: its uncertainty covers that, and the grids are taken to show nothing else"
        ))
    }

    /// Lets the values decide nothing, for a `reason` that lies outside of them.
    pub fn leave_open(&mut self, reason: &str) {
        self.set(Verdict::Inconclusive, reason);
    }

    fn set(&mut self, verdict: Verdict, reason: impl Into<String>) {
        self.verdict = verdict;
        self.reason = reason.into();
    }

    /// The verdict from the errors against a known value.
    fn decide_by_errors(&mut self, points: &[(f64, f64)], exact: f64, resolution: f64, question: &Question) {
        self.pairs = pair_orders(points, exact);
        self.extrapolated = Some(exact);
        let rounding = ROUNDINGS / FLOOR_MARGIN * f64::EPSILON * exact.abs();
        let sample = |&(h, value): &(f64, f64)| Sample {
            h,
            result: Ok(Measured { error: (value - exact).abs(), floor: resolution + rounding }),
        };
        let samples: Vec<_> = points.iter().map(sample).collect();
        let fit = match question.expected {
            Some(order) => fit(&samples, &Expectation::new(order, question.band)),
            None => fit_freely(&samples, question.band),
        };
        if let Some(Line { slope, stderr, .. }) = fit.line {
            (self.order, self.uncertainty) = (Some(slope), Some(stderr));
        }
        let all = |holds: &dyn Fn(f64) -> bool| points.iter().all(|(_, value)| holds((value - exact).abs()));
        let reason = if all(&|error| error == 0.0) {
            "every value is the exact one, to its last digit: there is no error to have an order".into()
        } else if all(&|error| error <= FLOOR_MARGIN * (resolution + rounding)) {
            format!(
                "no error is above {:.1e}, ten times what digits and rounding resolve: they are converged to there, which is \
                 not exactness, and have no order",
                FLOOR_MARGIN * (resolution + rounding)
            )
        } else {
            let OrderFit { reason, dropped, .. } = &fit;
            let of = |reason: Reason| dropped.iter().filter(move |(_, why)| *why == reason).map(|(sample, _)| sample.h);
            let coarse = left_out(TOO_COARSE, of(Reason::PreAsymptotic));
            format!("{reason}{coarse}{}{}", left_out(FLOORED, of(Reason::AtFloor)), self.another_limit(points, exact))
        };
        let slopes: Vec<(f64, f64)> = fit.local_slopes.iter().map(|local| (local.slope, local.uncertainty)).collect();
        match drifts_away(&slopes, question).filter(|_| fit.verdict == Verdict::Pass) {
            Some(why) => self.set(Verdict::Inconclusive, format!("{reason}; {why}")),
            None => self.set(fit.verdict, reason),
        }
    }

    /// What is to be said where the values tend to something else than `exact`: the error stays what it is.
    fn another_limit(&self, points: &[(f64, f64)], exact: f64) -> String {
        let Some(Ok(Triplet { limit, oscillates: false, .. })) = self.triplets.last() else { return String::new() };
        let (left, finest) = ((limit - exact).abs(), (points[0].1 - exact).abs());
        // As much of the error is left for h → 0 as disappears.
        if left <= 0.5 * finest {
            return String::new();
        }
        let [limit, exact] = [*limit, exact].map(|x| significant(x, 8));
        format!(
            "; the values tend to {limit} and not to {exact}: the exact value may be wrong, or that of another equation or parameter"
        )
    }

    /// The verdict from the differences between grids, fine to coarse.
    fn decide_by_differences(&mut self, points: &[(f64, f64)], resolution: f64, question: &Question) {
        let count = self.triplets.len();
        let triplet = match self.triplets.last() {
            Some(Ok(triplet)) => *triplet,
            Some(Err(error)) => {
                let grows =
                    |t: &Result<Triplet, TripletError>| matches!(t, Err(TripletError::Diverging { certain: true, .. }));
                // As with a wrong order, three grids may be too coarse; four with growing differences are not converging.
                let growing = self.triplets.iter().rev().take_while(|triplet| grows(triplet)).count();
                let diverges = growing > 1 && noise::grow_by_a_law(&points[..growing + 2], question.band / 2.0);
                let verdict = if diverges { Verdict::Fail } else { Verdict::Inconclusive };
                // One grid that leaves a sequence which settles is more likely wrong than all the others.
                let before = self.triplets.iter().rev().nth(1).and_then(|triplet| triplet.ok()?.power_order());
                let reason = match (error, before) {
                    (TripletError::Diverging { .. }, Some(order)) => format!(
                        "{error}; without the finest grid they converge, with order {}: noise or a standstill on that grid, as of an \
                         iteration that ends too early, looks the same",
                        decimals(order, 2)
                    ),
                    (TripletError::Diverging { certain: true, .. }, None) if count > 1 && !diverges => {
                        format!(
                            "{error}, but by no law: noise on the values, an iteration that ends too early, or two terms of an error that nearly \
                             cancel on these grids, look the same"
                        )
                    }
                    _ => error.to_string(),
                };
                return self.set(verdict, reason);
            }
            None => return,
        };
        if triplet.oscillates {
            return self.set(
                Verdict::Inconclusive,
                "the differences alternate in sign, which no order explains: noise on the values does so, and grids outside of the \
                 asymptotic range",
            );
        }
        let most = question.expected.map_or(HIGHEST, |p| HIGHEST.max(p + question.band));
        if triplet.order > most {
            let order = decimals(triplet.order, 1);
            let reason = format!(
                "the differences of the finest grids shrink as those of an order {order} would: above {most} it is taken for \
                 grids outside of the asymptotic range"
            );
            return self.set(Verdict::Inconclusive, reason);
        }
        self.gci = Some(triplet.gci);
        let towards = towards(&self.triplets, points);
        let settled = settled(&self.triplets, towards, question.band / 2.0);
        if count == 1 {
            (self.order, self.uncertainty) = (Some(triplet.order), Some(triplet.uncertainty));
            self.extrapolated = Some(triplet.limit);
        } else if settled < 2 {
            return self.set(
                Verdict::Inconclusive,
                format!(
                    "the orders of successive triplets, and the one that they drift to, {}, differ by more than {}: they \
                     have not settled",
                    decimals(towards, 3),
                    question.band / 2.0
                ),
            );
        } else {
            let used = settled + 2;
            let Some(power) = LeastSquares::fit(&points[..used]).ok().and_then(|fit| fit.power) else {
                return self.set(Verdict::Inconclusive, "no power law fits the values");
            };
            self.order = Some(power.order);
            // Orders that drift are uncertain by how far the fit is from where they go, with the safety factor of the grid
            // convergence index for that extrapolation, and orders that scatter by half of their spread.
            let orders = self.triplets.iter().rev().take(settled).flatten().map(|triplet| triplet.order);
            let (low, high) = orders.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
            let drift = (SAFETY * (power.order - towards).abs()).max(0.5 * (high - low));
            self.uncertainty = Some(
                power.stderr.max(drift).hypot(power.sensitivity * (resolution + f64::EPSILON * points[0].1.abs())),
            );
            self.extrapolated = Some(power.limit);
            self.used = used;
        }
        let (verdict, reason) = self.compare(count, settled, question);
        let orders: Vec<_> =
            self.triplets.iter().flatten().map(|triplet| (triplet.order, triplet.uncertainty)).collect();
        match drifts_away(&orders, question).filter(|_| count > 1 && verdict == Verdict::Pass) {
            Some(why) => self.set(Verdict::Inconclusive, format!("{reason}; {why}")),
            None => self.set(verdict, reason),
        }
    }

    /// The order found on so many triplets, of which the finest have settled, beside the expected one.
    fn compare(&self, count: usize, settled: usize, question: &Question) -> (Verdict, String) {
        let (order, own) = (self.order.unwrap_or(f64::NAN), self.uncertainty.unwrap_or(f64::NAN));
        let Question { expected, band, .. } = *question;
        let found = format!("order {} ± {}", decimals(order, 3), significant(own, 2));
        let grids = settled + 2;
        if own.is_nan() || own > band {
            let reason =
                format!("{found}, more than the band of {band}: more digits, or grids further apart, would tell");
            return (Verdict::Inconclusive, reason);
        }
        match (expected, (order - expected.unwrap_or(order)).abs()) {
            (None, _) if count == 1 => (
                Verdict::Inconclusive,
                format!("{found}; three grids do not tell whether it has settled: a fourth does, or an expected order"),
            ),
            (None, _) => (Verdict::Measured, format!("{found}, settled on {grids} grids; no order was expected")),
            (Some(p), distance) if count == 1 && distance <= band => (
                Verdict::Pass,
                format!("{found} on three grids, expected {p} ± {band}; nothing is left to test it with"),
            ),
            (Some(p), _) if count == 1 => (
                Verdict::Inconclusive,
                format!(
                    "{found}, expected {p} ± {band}: three grids do not tell a wrong order from grids that are too coarse"
                ),
            ),
            (Some(p), distance) => {
                let verdict = match distance {
                    distance if distance <= band => Verdict::Pass,
                    distance if distance - own > band => Verdict::Fail,
                    _ => Verdict::Inconclusive,
                };
                (verdict, format!("{found}, settled on {grids} grids, expected {p} ± {band}"))
            }
        }
    }
}

/// What is to be said where the last two orders, each with its uncertainty, go away from the expected one and out of its band.
fn drifts_away(orders: &[(f64, f64)], question: &Question) -> Option<String> {
    let (&[.., (coarse, one), (fine, other)], Some(expected)) = (orders, question.expected) else { return None };
    let step = fine - coarse;
    let leaves = (fine + step - expected).abs() > question.band && (fine - expected).abs() > (coarse - expected).abs();
    (leaves && step.abs() > one + other).then(|| {
        let [coarse, fine] = [coarse, fine].map(|order| decimals(order, 3));
        format!(
            "but with refinement the orders go from {coarse} to {fine}, away from {expected}: a finer grid would tell"
        )
    })
}

/// Where the orders of the triplets, coarse to fine, go for h → 0.
///
/// With φ = φ₀ + C hᵖ(1 + D h^q + …) the orders p_k of triplets drift as p_k − p ~ h_k^q. Under refinement by ρ their differences
/// thus have the ratio r = ρ^−q, and Δ r/(1 − r) of the last difference Δ is still to come. Three triplets tell r; orders come
/// in halves, so that q ≥ ½ bounds it. Two do not, and the next term of a power series, q = 1, is assumed. Differences that
/// alternate are scatter, which leads nowhere. Digits play no part: they may widen what is left open, never narrow it.
/// From one triplet to the next the mean spacing of its three grids shrinks by ρ = (h₄/h₁)^⅓.
fn towards(triplets: &[Result<Triplet, TripletError>], points: &[(f64, f64)]) -> f64 {
    let orders = || triplets.iter().rev().map_while(|triplet| triplet.ok()?.power_order());
    let finest: Vec<f64> = orders().take(3).collect();
    let refinement = points.get(3).map_or(2.0, |point| (point.0 / points[0].0).cbrt());
    let growth = |r: f64| r / (1.0 - r);
    match finest[..] {
        [one, two, three] => {
            let (last, before) = (one - two, two - three);
            let ratio = if last * before > 0.0 { (last / before).min(refinement.powf(-0.5)) } else { 0.0 };
            one + last * growth(ratio)
        }
        [one, two] => one + (one - two) * growth(1.0 / refinement),
        _ => finest.first().copied().unwrap_or(f64::NAN),
    }
}

/// Length of the longest run of triplets, counted from the finest, that converge monotonically with orders that agree to within
/// `spread`, the finest of them with the order that they go `towards`, too.
fn settled(triplets: &[Result<Triplet, TripletError>], towards: f64, spread: f64) -> usize {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let agrees = |triplet: &&Result<Triplet, TripletError>| {
        let Ok(Triplet { order, oscillates: false, .. }) = triplet else { return false };
        if low > high && (order - towards).abs() > spread {
            return false;
        }
        (low, high) = (low.min(*order), high.max(*order));
        high - low <= spread
    };
    triplets.iter().rev().take_while(agrees).count()
}

/// The verdict on several quantities: all must settle.
#[must_use]
pub fn overall<'a>(judgements: impl IntoIterator<Item = &'a Judgement>) -> Verdict {
    let verdicts: Vec<Verdict> = judgements.into_iter().map(|judgement| judgement.verdict).collect();
    if verdicts.contains(&Verdict::Fail) {
        Verdict::Fail
    } else if verdicts.is_empty() || verdicts.contains(&Verdict::Inconclusive) {
        Verdict::Inconclusive
    } else if verdicts.contains(&Verdict::Measured) {
        Verdict::Measured
    } else {
        Verdict::Pass
    }
}

/// Least difference that values of `resolution` and size `value` resolve.
pub(crate) fn least_difference(resolution: f64, value: f64) -> f64 {
    FLOOR_MARGIN * (resolution + f64::EPSILON * value.abs())
}

#[cfg(test)]
mod tests;
