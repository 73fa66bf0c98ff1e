//! The order of accuracy from errors at several step sizes, with a verdict of three values.
//!
//! An error e(h) = C hᵖ(1 + O(h)) is measured up to a *floor*: the reference's own error bound, the solver tolerance and
//! roundoff. The verdict follows from the data by fixed rules:
//!
//! 1. A run that failed, or whose numbers are no error (NaN, negative), is dropped, and so is every coarser one: a window
//!    of step sizes has no holes.
//! 2. A point with e ≤ [`FLOOR_MARGIN`] × floor is dropped as being at the floor.
//! 3. Of the rest, the window is the longest run of points, counted from the finest, whose local slopes agree to half the
//!    band, each within its own uncertainty from the floor; coarser points are pre-asymptotic. At least [`MIN_POINTS`]
//!    must be left. Where the slopes of such a run come nearer to the expected order with every refinement, and reach the
//!    band within the finest [`MIN_POINTS`] only, these are the window.
//! 4. ln e is fitted against ln h, a point weighing less the more its floor could bend the local slopes.
//! 5. **Pass** or **fail** is |slope − expected| ≤ band, two-sided and signed, so that divergence is never mistaken for
//!    convergence. It is **inconclusive** where rule 3 leaves no window, or where twice the standard error exceeds the
//!    band, or where the slope lies outside it but the local slopes come nearer to the expected order with every
//!    refinement, and at that rate into the band, or where the expected order with terms of higher order
//!    explains the errors as well: what such errors show is a tail that the floor cuts off. Errors that grow at each
//!    of the last refinements, beyond all coarser ones or into overflow, **fail**, window or not. Where they have fallen
//!    to less than they grow from, that is a floor that nobody stated, or the start of an instability: **inconclusive**.

mod remainder;

use std::cmp::Ordering;
use std::fmt;

use serde::Serialize;

use super::decimal::{decimals, uncertain};
use super::norm::{Extremes, larger};
use remainder::explains;

/// Fewest points in a fit: three local slopes to agree, two degrees of freedom for the standard error.
pub const MIN_POINTS: usize = 4;

/// Errors up to this many floors are not used: beyond it a floor moves ln e by less than a tenth.
pub const FLOOR_MARGIN: f64 = 10.0;

/// Refinements, counted from the finest, over which errors must grow to be called diverging.
const DIVERGING: usize = 3;

/// Slopes of no more than this either way: the error stays what it is.
const STALLED: f64 = 0.05;
/// What that means.
const STANDSTILL: &str = "; the error stays what it is under refinement: what converges is the solution of another equation, parameter \
                          or time, or what the errors are measured against is wrong";

/// The error at one step size, or why there is none.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Step size.
    pub h: f64,
    /// The error and its floor, or the reason why the run gave none.
    pub result: Result<Measured, String>,
}

/// An error and what it is uncertain by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Norm of the error, ≥ 0.
    pub error: f64,
    /// Bound on the error's own error: reference bound + solver tolerance + roundoff, ≥ 0.
    pub floor: f64,
}

impl Sample {
    /// An error measured at step size `h`, known to within `floor`.
    #[must_use]
    pub fn new(h: f64, error: f64, floor: f64) -> Self {
        Self { h, result: Ok(Measured { error, floor }) }
    }

    /// A run at step size `h` that failed.
    pub fn failed(h: f64, reason: impl Into<String>) -> Self {
        Self { h, result: Err(reason.into()) }
    }
}

/// Which order is expected, and how closely.
#[derive(Debug, Clone, PartialEq)]
pub struct Expectation {
    /// The order required: the nominal one, or the declared one.
    pub order: f64,
    /// Largest |slope − order| that passes.
    pub band: f64,
    /// Nominal order and reason where another order is declared.
    pub declared: Option<Declared>,
}

/// A declared order reduction or super-convergence.
#[derive(Debug, Clone, PartialEq)]
pub struct Declared {
    /// The method's nominal order.
    pub nominal: f64,
    /// Why another one is expected here.
    pub reason: String,
}

impl Expectation {
    /// The nominal order, within ± `band`.
    #[must_use]
    pub fn new(order: f64, band: f64) -> Self {
        Self { order, band, declared: None }
    }

    /// Expects `order` in place of the nominal one, because of `reason`.
    #[must_use]
    pub fn declared(self, order: f64, reason: impl Into<String>) -> Self {
        Self { order, declared: Some(Declared { nominal: self.order, reason: reason.into() }), ..self }
    }
}

/// Why a point is not in the fit.
#[derive(Debug, Clone, PartialEq)]
pub enum Reason {
    /// Coarser than the window in which the local slopes agree.
    PreAsymptotic,
    /// Coarser than a run that failed.
    BeforeFailure,
    /// The error is no larger than [`FLOOR_MARGIN`] times its floor.
    AtFloor,
    /// The run failed, or gave something that is no error.
    StepFailed(String),
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::PreAsymptotic => f.write_str("pre-asymptotic"),
            Self::BeforeFailure => f.write_str("coarser than a run that failed"),
            Self::AtFloor => f.write_str("at the floor"),
            Self::StepFailed(why) => f.write_str(why),
        }
    }
}

/// The decision.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The order is the expected one.
    Pass,
    /// There is an order, and none was expected.
    Measured,
    /// The order is another one.
    Fail,
    /// The data do not decide.
    Inconclusive,
}

/// A straight line through (ln h, ln e).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// The observed order.
    pub slope: f64,
    /// Standard error of the slope: scatter about the line, the most that the floors can do, and the rounding
    /// of the logarithms, added in squares.
    pub stderr: f64,
    /// Coefficient of determination (weighted); 1 where all errors are equal and so is the line.
    pub r_squared: f64,
    /// How far the rounding of the logarithms can move the slope.
    rounding: f64,
}

/// The slope between two neighbouring usable points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalSlope {
    /// The coarser step size.
    pub coarse: f64,
    /// The finer step size.
    pub fine: f64,
    /// ln(e_coarse/e_fine) / ln(h_coarse/h_fine).
    pub slope: f64,
    /// How far the floors can move it.
    pub uncertainty: f64,
}

/// Where the errors lead under refinement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Trend {
    /// To a slope that the verdict compares, or nowhere yet.
    Levels,
    /// They have not settled.
    Unsettled,
    /// The local slopes tend to the order that is expected, and the ladder ends too soon.
    Approaches,
    /// They grow.
    Diverges,
}

/// An order measured, and the verdict on it.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderFit {
    /// The fit over `kept`; absent where fewer than [`MIN_POINTS`] points are usable. Where the verdict says that the
    /// local slopes have not settled, it is the fit of the finest [`MIN_POINTS`], for information.
    pub line: Option<Line>,
    /// Slopes between neighbouring usable points, coarse to fine, pre-asymptotic ones included.
    pub local_slopes: Vec<LocalSlope>,
    /// Points in the fit, coarse to fine.
    pub kept: Vec<Sample>,
    /// Points not in the fit, coarse to fine.
    pub dropped: Vec<(Sample, Reason)>,
    /// What was expected.
    pub expected: Expectation,
    /// The decision.
    pub verdict: Verdict,
    /// The decision in words, with its numbers.
    pub reason: String,
    /// Whether it is the digits of rounded coefficients that leave it open.
    pub is_of_digits: bool,
    /// What the slopes do.
    trend: Trend,
}

impl OrderFit {
    /// The verdict where the order expected is the one that a method has on equations in general, a whole number: on a special
    /// one the first terms of the error may vanish, and a slope nearer to that order than to the one below has errors of
    /// the next order in it still. Neither refutes it.
    #[must_use]
    pub fn of_equations_in_general(self) -> Self {
        let Self { verdict: Verdict::Fail, line: Some(Line { slope, .. }), expected, reason, .. } = &self else {
            return self;
        };
        if *slope <= expected.order - 0.5 || self.trend == Trend::Diverges {
            return self;
        }
        let is_floored = self.dropped.iter().any(|(_, reason)| *reason == Reason::AtFloor);
        let why = match *slope > expected.order {
            true if is_floored && *slope < expected.order + 0.5 => {
                "rounding ends the window before errors of higher order vanish"
            }
            true => "on this equation the errors fall faster, as where its first terms cancel, which another one tells",
            false => "it is nearer to that order than to the next below, as where errors of several orders mix",
        };
        let reason = format!("{reason}; {why}");
        Self { verdict: Verdict::Inconclusive, reason, ..self }
    }

    /// The same without a decision, for a reason beside which finer steps do not count.
    #[must_use]
    pub(crate) fn left_open(self, reason: String) -> Self {
        Self { verdict: Verdict::Inconclusive, reason, trend: Trend::Levels, ..self }
    }

    /// Whether finer steps alone would tell: the local slopes tend to the order that is expected.
    pub(crate) fn still_approaches(&self) -> bool {
        self.trend == Trend::Approaches
    }

    /// Whether it is inconclusive and finer steps than those of the ladder may settle the slopes: the finest is no floor yet.
    pub fn wants_finer(&self) -> bool {
        let finest = self.points().last().is_some_and(|(_, reason)| reason.is_none());
        finest && matches!(self.trend, Trend::Approaches | Trend::Unsettled)
    }

    /// All points, coarse to fine, with the reason why one is not in the fit.
    pub fn points(&self) -> Vec<(&Sample, Option<&Reason>)> {
        let dropped = self.dropped.iter().map(|(sample, reason)| (sample, Some(reason)));
        let mut points: Vec<_> = self.kept.iter().map(|sample| (sample, None)).chain(dropped).collect();
        points.sort_by(|a, b| b.0.h.total_cmp(&a.0.h));
        points
    }
}

/// A usable point in logarithms.
#[derive(Debug, Clone, Copy)]
struct LogPoint {
    x: f64,
    y: f64,
    /// Bound on the error of y: the floor, and the rounding of the logarithm.
    u: f64,
}

/// Measures the order of `samples`, in any sequence of step sizes, against `expected`.
#[must_use]
pub fn fit(samples: &[Sample], expected: &Expectation) -> OrderFit {
    let mut samples = samples.to_vec();
    samples.sort_by(|a, b| b.h.total_cmp(&a.h));
    let mut reasons = screen(&samples);
    let usable: Vec<usize> = (0..samples.len()).filter(|&i| reasons[i].is_none()).collect();
    let points: Vec<LogPoint> = usable.iter().filter_map(|&i| log_point(&samples[i])).collect();
    let slopes: Vec<LocalSlope> = usable
        .windows(2)
        .zip(points.windows(2))
        .map(|(i, p)| LocalSlope {
            coarse: samples[i[0]].h,
            fine: samples[i[1]].h,
            slope: (p[0].y - p[1].y) / (p[0].x - p[1].x),
            uncertainty: (p[0].u + p[1].u) / (p[0].x - p[1].x),
        })
        .collect();

    let settle = expected.band / 2.0;
    let mut settled = points.len() - settled_start(&slopes, settle);
    if arrives(&points[points.len() - settled..], &slopes, expected) {
        settled = MIN_POINTS;
    }
    let window = if settled >= MIN_POINTS { settled } else { MIN_POINTS.min(points.len()) };
    let start = points.len() - window;
    for &i in &usable[..start] {
        reasons[i] = Some(Reason::PreAsymptotic);
    }
    let line = (window >= MIN_POINTS).then(|| Line::through(&points[start..], settle));
    let (verdict, trend, reason) = match diverges(&samples, &points, &slopes) {
        Some(Growth::Divergence(how)) => (Verdict::Fail, Trend::Diverges, format!("diverges: {how}")),
        Some(Growth::AfterAFall(how)) => (Verdict::Inconclusive, Trend::Levels, how),
        None if !reasons.is_empty() && reasons.iter().all(|reason| *reason == Some(Reason::AtFloor)) => {
            (Verdict::Inconclusive, Trend::Levels, floored(&samples))
        }
        None => judge(line, &points[points.len() - settled..], points.len(), &slopes, &reasons, expected),
    };

    let (mut kept, mut dropped) = (Vec::new(), Vec::new());
    for (sample, reason) in samples.into_iter().zip(reasons) {
        match reason {
            None => kept.push(sample),
            Some(reason) => dropped.push((sample, reason)),
        }
    }
    let (expected, is_of_digits) = (expected.clone(), false);
    OrderFit { line, local_slopes: slopes, kept, dropped, expected, verdict, reason, is_of_digits, trend }
}

/// Measures the order of `samples` where none is expected: nothing can pass. The slopes have settled if they agree to half of
/// `band`, and a drift that is left in them, twice, to `band`.
#[must_use]
pub fn fit_freely(samples: &[Sample], band: f64) -> OrderFit {
    let own = |order: f64| fit(samples, &Expectation::new(order, band));
    let first = own(0.0);
    let Some(line) = first.line else { return first };
    let found = own(line.slope);
    if found.verdict != Verdict::Pass {
        return found;
    }
    let steps = found.kept.len();
    let window = &found.local_slopes[found.local_slopes.len() + 1 - steps..];
    let line = Line { stderr: larger(line.stderr, drifted(window, line.slope)), ..line };
    let order = uncertain(line.slope, line.stderr);
    if 2.0 * line.stderr > band {
        let reason =
            format!("order {order}: the local slopes drift, {}, by more than a band of {band} leaves", join(window));
        return OrderFit { line: Some(line), verdict: Verdict::Inconclusive, trend: Trend::Unsettled, reason, ..found };
    }
    let stalls = if line.slope.abs() <= STALLED { STANDSTILL } else { "" };
    let reason = format!("order {order}, settled on {steps} steps; no order was expected{stalls}");
    OrderFit { line: Some(line), verdict: Verdict::Measured, reason, ..found }
}

/// How far `slope` is from where local slopes go that rise or fall with every step, as those of e = C hᵖ(1 + a h) do, for small a h alone in proportion to
/// h: what is left beyond the finest may be half as much again. 0 of others.
fn drifted(slopes: &[LocalSlope], slope: f64) -> f64 {
    let [coarsest, .., finest] = slopes else { return 0.0 };
    let moves =
        |sign: f64| slopes.windows(2).all(|s| sign * (s[1].slope - s[0].slope) > s[0].uncertainty + s[1].uncertainty);
    if !moves(1.0) && !moves(-1.0) {
        return 0.0;
    }
    let still = (finest.slope - coarsest.slope) / (coarsest.fine / finest.fine - 1.0);
    (finest.slope + 1.5 * still - slope).abs()
}

/// Step sizes for an order study over `horizon`, coarse to fine: h_k ≈ `coarsest`·`ratio`^{−k}, each dividing the horizon,
/// so that no run ends in a shortened step, and strictly decreasing. Empty unless both lengths are positive and finite.
#[must_use]
pub fn ladder(horizon: f64, coarsest: f64, ratio: f64, count: usize) -> Vec<f64> {
    if ![horizon, coarsest, horizon / coarsest].iter().all(|x| *x > 0.0 && x.is_finite()) {
        return Vec::new();
    }
    let mut steps = 0.0;
    (0..count)
        .map(|k| {
            let nearest = (horizon / coarsest * ratio.powf(k as f64)).round();
            steps = nearest.max(steps + 1.0);
            horizon / steps
        })
        .collect()
}

/// Rules 1 and 2: why each of the sorted samples cannot be used, if so.
fn screen(samples: &[Sample]) -> Vec<Option<Reason>> {
    let mut reasons: Vec<Option<Reason>> = Vec::with_capacity(samples.len());
    for (i, sample) in samples.iter().enumerate() {
        let fault = match &sample.result {
            Err(reason) => Some(reason.clone()),
            Ok(_) if !(sample.h > 0.0 && sample.h.is_finite()) => Some(format!("the step size is {}", sample.h)),
            Ok(_) if i > 0 && samples[i - 1].h == sample.h => Some(format!("the step size {} is repeated", sample.h)),
            Ok(m) if !(m.error >= 0.0 && m.error.is_finite()) => Some(format!("the error is {}", m.error)),
            Ok(m) if !(m.floor >= 0.0 && m.floor.is_finite()) => Some(format!("the floor is {}", m.floor)),
            Ok(m) => {
                reasons.push((m.error <= FLOOR_MARGIN * m.floor).then_some(Reason::AtFloor));
                continue;
            }
        };
        for coarser in reasons.iter_mut().filter(|r| r.is_none()) {
            *coarser = Some(Reason::BeforeFailure);
        }
        reasons.push(fault.map(Reason::StepFailed));
    }
    reasons
}

fn log_point(sample: &Sample) -> Option<LogPoint> {
    let m = sample.result.as_ref().ok()?;
    let (x, y) = (sample.h.ln(), m.error.ln());
    Some(LogPoint { x, y, u: m.floor / m.error + rounding(x, y) })
}

/// Rounding of a point's logarithms, ½ ulp in the function and ½ in its argument.
fn rounding(x: f64, y: f64) -> f64 {
    f64::EPSILON * (1.0 + x.abs() + y.abs())
}

/// Rule 3: index of the first of the longest run of slopes, up to the finest, that agree to within `settle`.
fn settled_start(slopes: &[LocalSlope], settle: f64) -> usize {
    let (mut highest_low, mut lowest_high) = (f64::NEG_INFINITY, f64::INFINITY);
    for (i, s) in slopes.iter().enumerate().rev() {
        highest_low = highest_low.max(s.slope - s.uncertainty);
        lowest_high = lowest_high.min(s.slope + s.uncertainty);
        if highest_low - lowest_high > settle {
            return i + 1;
        }
    }
    0
}

/// Whether local slopes come into the band of what is expected at the fine end of a window whose mean slope is outside of it.
fn arrives(window: &[LogPoint], slopes: &[LocalSlope], expected: &Expectation) -> bool {
    let Expectation { order, band, .. } = *expected;
    if window.len() <= MIN_POINTS || !may_reach(&slopes[slopes.len() + 1 - window.len()..], order, band) {
        return false;
    }
    let is_in = |points: &[LogPoint]| {
        let line = Line::through(points, band / 2.0);
        (line.slope - order).abs() <= band && 2.0 * line.stderr <= band
    };
    !is_in(window) && is_in(&window[window.len() - MIN_POINTS..])
}

/// 1/(1 + (u/s)²), where s moves the mean local slope by `settle`.
fn weights(points: &[LogPoint], settle: f64) -> impl Fn(&LogPoint) -> f64 + use<> {
    let s = settle * (points[0].x - points[points.len() - 1].x) / (points.len() as f64 - 1.0);
    move |p| 1.0 / (1.0 + (p.u / s).powi(2))
}

impl Line {
    /// Rule 4, weighted.
    fn through(points: &[LogPoint], settle: f64) -> Self {
        let n = points.len() as f64;
        let weight = weights(points, settle);
        let total: f64 = points.iter().map(&weight).sum();
        let mean = |f: fn(&LogPoint) -> f64| points.iter().map(|p| weight(p) * f(p)).sum::<f64>() / total;
        let (x, y) = (mean(|p| p.x), mean(|p| p.y));
        let sum = |f: &dyn Fn(&LogPoint) -> f64| points.iter().map(|p| weight(p) * f(p)).sum::<f64>();
        let sxx = sum(&|p| (p.x - x).powi(2));
        let syy = sum(&|p| (p.y - y).powi(2));
        let slope = sum(&|p| (p.x - x) * (p.y - y)) / sxx;
        let residual = sum(&|p| (p.y - y - slope * (p.x - x)).powi(2));
        let scatter = residual / (n - 2.0) / sxx;
        let floors = sum(&|p| (p.x - x).abs() * p.u) / sxx;
        let rounding = sum(&|p| (p.x - x).abs() * rounding(p.x, p.y)) / sxx;
        let r_squared = if syy > 0.0 { 1.0 - residual / syy } else { 1.0 };
        let stderr = (scatter + floors * floors + rounding * rounding).sqrt();
        Self { slope, stderr, r_squared, rounding }
    }
}

/// How errors grow under refinement.
enum Growth {
    /// Beyond all coarser ones.
    Divergence(String),
    /// From what they had fallen to.
    AfterAFall(String),
}

/// How the errors grow under refinement, if they do: at each of the last intervals, or into overflow.
fn diverges(samples: &[Sample], points: &[LogPoint], slopes: &[LocalSlope]) -> Option<Growth> {
    let last = &slopes[slopes.len().saturating_sub(DIVERGING)..];
    if last.len() >= 2 && last.iter().all(|s| s.slope + s.uncertainty < -STALLED) {
        let (finest, coarser) = points.split_last()?;
        if coarser.iter().all(|p| p.y < finest.y) {
            return Some(Growth::Divergence(format!(
                "the error grows at the last refinements, local slopes {}",
                join(last)
            )));
        }
        let least = points.iter().map(|p| p.y).smallest().exp();
        return Some(Growth::AfterAFall(format!(
            "the error falls to {least:.1e} and grows from there, local slopes {} at the last refinements: rounding, or a \
             tolerance, looks the same as a method that becomes unstable",
            join(last)
        )));
    }
    let error = |s: &Sample| s.result.as_ref().map_or(f64::NAN, |m| m.error);
    let first_finite = samples.iter().position(|s| error(s).is_finite())?;
    let overflow = samples[first_finite..].iter().find(|s| error(s) == f64::INFINITY)?;
    Some(Growth::Divergence(format!("the error overflows at h = {}, with coarser steps finite", overflow.h)))
}

/// Rule 5, for errors that do not diverge.
fn judge(
    line: Option<Line>,
    settled: &[LogPoint],
    usable: usize,
    slopes: &[LocalSlope],
    reasons: &[Option<Reason>],
    expected: &Expectation,
) -> (Verdict, Trend, String) {
    let Expectation { order, band, .. } = *expected;
    if !(order.is_finite() && band > 0.0 && band.is_finite()) {
        return (Verdict::Inconclusive, Trend::Levels, format!("no order can be expected to be {order} ± {band}"));
    }
    let Some(line) = line else {
        return (Verdict::Inconclusive, Trend::Levels, too_few(usable, reasons));
    };
    if settled.len() < MIN_POINTS {
        let list = join(&slopes[slopes.len() - (MIN_POINTS - 1)..]);
        let text = format!("the local slopes have not settled to within {}: {list} at the fine end", band / 2.0);
        return (Verdict::Inconclusive, Trend::Unsettled, text);
    }
    let Line { slope, stderr, .. } = line;
    let measured = format!("order {}", uncertain(slope, stderr));
    if 2.0 * stderr > band {
        let text = format!("{measured}: twice the standard error exceeds the band of {band}");
        return (Verdict::Inconclusive, Trend::Levels, text);
    }
    let declared = expected.declared.as_ref().map_or(String::new(), |d| match order.total_cmp(&d.nominal) {
        Ordering::Less => format!(" (declared reduction from {}: {})", d.nominal, d.reason),
        Ordering::Equal => format!(" ({})", d.reason),
        Ordering::Greater => format!(" (declared super-convergence from {}: {})", d.nominal, d.reason),
    });
    let kept = &slopes[slopes.len() + 1 - settled.len()..];
    // A slope on the edge of the band is in it, so the comparison allows for rounding.
    if (slope - order).abs() <= band + line.rounding {
        (Verdict::Pass, Trend::Levels, format!("{measured} is {order} ± {band}{declared}"))
    } else if may_reach(kept, order, band) {
        let text = format!("{measured}, and the local slopes still approach {order} {}: {}", end(reasons), join(kept));
        (Verdict::Inconclusive, Trend::Approaches, text)
    } else if (slope - order).abs() < 1.0 && explains(order, settled, band / 2.0) {
        // A remainder a h as large as the leading term itself moves a slope by a half: one that is off by an order leads.
        let text = format!(
            "{measured}, but {order} with terms of higher order explains the errors no worse, local slopes {}: the ladder \
             ends before an order settles, {}",
            join(kept),
            end(reasons)
        );
        (Verdict::Inconclusive, Trend::Approaches, text)
    } else {
        let stalls = if kept.iter().all(|s| s.slope.abs() <= STALLED) { STANDSTILL } else { "" };
        (Verdict::Fail, Trend::Levels, format!("{measured} is not {order} ± {band}{declared}{stalls}"))
    }
}

/// Where a ladder ends.
fn end(reasons: &[Option<Reason>]) -> &'static str {
    match reasons.last() {
        Some(Some(Reason::AtFloor)) => "where errors reach their floor",
        _ => "where the steps end",
    }
}

/// Whether local slopes come nearer to `order` with every step, and finer steps might bring them to within `band`.
///
/// Where e = C hᵖ(1 + a h), what a local slope lacks is in proportion to h. If it was d for steps r times as long as the finest,
/// and is d' there, then p is (d − d')/(r − 1) nearer than the finest slope. Over the whole window noise of a single slope
/// counts least, and terms of higher order vanish sooner.
fn may_reach(slopes: &[LocalSlope], order: f64, band: f64) -> bool {
    let distance = |s: &LocalSlope| (s.slope - order).abs();
    let approach = slopes.windows(2).all(|s| distance(&s[1]) < distance(&s[0]));
    let [coarsest, .., finest] = slopes else { return false };
    let still = (distance(coarsest) - distance(finest)) / (coarsest.fine / finest.fine - 1.0);
    approach && distance(finest) - still <= band
}

/// What errors say that are all at their floors.
fn floored(samples: &[Sample]) -> String {
    let floors = samples.iter().filter_map(|sample| Some(sample.result.as_ref().ok()?.floor));
    let largest = floors.fold(0.0, larger);
    format!(
        "every error is at its floor: the method is exact here, or as good as that, to {largest:.1e}, below which nothing is measured"
    )
}

fn too_few(usable: usize, reasons: &[Option<Reason>]) -> String {
    let at_floor = reasons.iter().flatten().filter(|r| matches!(r, Reason::AtFloor)).count();
    let mut text = format!("{usable} usable of {} points, at least {MIN_POINTS} are needed", reasons.len());
    if at_floor > 0 {
        text += &format!("; {at_floor} at the floor");
    }
    let failed: Vec<&String> = reasons
        .iter()
        .flatten()
        .filter_map(|r| if let Reason::StepFailed(why) = r { Some(why) } else { None })
        .collect();
    if let Some(finest) = failed.last() {
        text += &format!("; {} failed, the finest because: {finest}", failed.len());
    }
    text
}

fn join(slopes: &[LocalSlope]) -> String {
    slopes.iter().map(|s| decimals(s.slope, 2)).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests;
