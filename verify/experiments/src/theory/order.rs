//! How an order is measured, and what it should be.

use std::f64::consts::SQRT_2;

use super::breakdown::free_residual;
use crate::kinds::{Principle, Stability, System};
use crate::measure::norm::{distance, max_norm};
use crate::measure::order::{Declared, Expectation, ladder};
use crate::method::{Method, Traits};
use crate::problem::{Facts, Problem, Stiffness, Window};

/// Half-width of the band around an expected order up to 4: a tenth of an order tells neighbouring orders apart by far.
/// Above, steps lie closer together, so that the same deviations of errors from a power law make slopes p/4 times as wrong.
const ORDER_BAND: f64 = 0.1;

/// Step sizes in an order study.
const LADDER: usize = 13;

/// How the order of a method on a problem is measured, and what it should be.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderPlan {
    /// The order and its band.
    pub expectation: Expectation,
    /// End of the integration.
    pub horizon: f64,
    /// The step sizes, coarse to fine.
    pub steps: Vec<f64>,
    /// Why these steps cannot tell the order, where that is known: they are tried all the same, and must not.
    pub untold: Option<&'static str>,
    /// Why these steps may end at roundoff before the order settles; what they then show is no verdict.
    pub unsettled: Option<&'static str>,
}

impl OrderPlan {
    /// The order p in `window`, with steps finer by factors √2; for p > 4 by 4^{1/p}, a quarter of the error at a time,
    /// because a high order is soon at roundoff.
    fn new(order: u32, Window { horizon, coarsest }: Window) -> Self {
        let order = f64::from(order);
        let steps = ladder(horizon, coarsest, SQRT_2.min(4_f64.powf(order.recip())), LADDER);
        let band = ORDER_BAND.max(order / 40.0);
        Self { expectation: Expectation::new(order, band), horizon, steps, untold: None, unsettled: None }
    }

    /// In a window for second order: the error terms of higher ones settle later.
    fn settled(order: u32, window: Window) -> Self {
        let coarsest = if order > 2 { 0.5 * window.coarsest } else { window.coarsest };
        Self::new(order, Window { coarsest, ..window })
    }

    /// The same steps, which cannot tell the order for a reason.
    fn untold(self, reason: &'static str) -> Self {
        Self { untold: Some(reason), ..self }
    }

    /// Expects `order` instead, for a reason.
    #[must_use]
    pub fn declared(self, order: f64, reason: &str) -> Self {
        Self { expectation: self.expectation.declared(order, reason), ..self }
    }
}

/// How the order of `method` on `problem` is to be measured.
pub fn order_plan(problem: &dyn Problem, method: &dyn Method) -> OrderPlan {
    let (facts, traits) = (problem.facts(), method.traits());
    let gained = |order: u32, reason: &str| {
        let plan = plan(problem, method, &facts, &Traits { order, ..traits.clone() });
        let declared = Some(Declared { nominal: f64::from(traits.order), reason: reason.into() });
        OrderPlan { expectation: Expectation { declared, ..plan.expectation }, ..plan }
    };
    // Where a remainder limits the order, nothing is gained.
    let is_limited = problem.limit(method.principle()).order.is_some();
    if let Some(order) = traits.symmetric_order.filter(|order| *order != traits.order && !is_limited)
        && is_symmetric(problem)
    {
        return gained(order, "least squares of v̇ − λv, integrated without error, gain order where λ is real");
    }
    if let Some(order) = traits.square_order.filter(|_| !is_limited)
        && is_square(problem)
    {
        return gained(order, "collocation at two Gauss nodes or more gains two orders on v̇ = −cv²");
    }
    if let Some((rate, order)) = traits.fitted
        && is_decay(problem, rate)
    {
        return gained(order, "the closure is fitted to this rate of decay");
    }
    plan(problem, method, &facts, &traits)
}

/// The plan for a method with these traits.
fn plan(problem: &dyn Problem, method: &dyn Method, facts: &Facts, traits: &Traits) -> OrderPlan {
    if let Some(singular) = free_residual(problem, method) {
        return match singular.before {
            Some(window) => OrderPlan::settled(traits.order, window),
            None => OrderPlan::settled(traits.order, facts.window).untold(singular.reason),
        };
    }
    let plan = match facts.stiffness {
        Stiffness::None => regular(facts, traits),
        Stiffness::Transient(rate) => transient(facts.window, rate, traits),
        Stiffness::Forced(rate) => forced(rate, traits),
    };
    let circular = problem.mechanics().is_some_and(|mechanics| mechanics.system == System::Circular);
    if circular && traits.has_even_defect {
        let order = f64::from(traits.order + 2);
        return plan.declared(
            order,
            "the leading defect is along an even derivative of q, radial, and goes into the multiplier",
        );
    }
    plan
}

/// Whether the equation is v̇ = cv² of one unknown, by its values at two times and three places.
fn is_square(problem: &dyn Problem) -> bool {
    let ode = problem.ode();
    let rhs = |t: f64, v: f64| {
        let mut out = [f64::NAN];
        ode.rhs(t, &[v], &mut out);
        out[0]
    };
    ode.dim() == 1 && problem.initial().len() == 1 && {
        let c = rhs(0.0, 1.0);
        let is_it = |(t, v): (f64, f64)| (rhs(t, v) - c * v * v).abs() <= 8.0 * f64::EPSILON * (c * v * v).abs();
        c != 0.0 && [(0.0, 0.5), (1.0, 2.0), (1.0, -1.5)].into_iter().all(is_it)
    }
}

/// Whether the equation is v̇ = −λv + b.
fn is_decay(problem: &dyn Problem, rate: f64) -> bool {
    let (ode, v) = (problem.ode(), problem.initial());
    let mut slope = [f64::NAN];
    if ode.dim() == 1 && v.len() == 1 {
        ode.product(0.0, &v, &[1.0], &mut slope);
    }
    // A rate of a few roundings beside it is another one, whose error term is below all others.
    (slope[0] + rate).abs() <= 4.0 * f64::EPSILON * rate.abs() && is_symmetric(problem)
}

/// Whether the equation is v̇ = A v + b with a symmetric A, by its values at two times and places.
pub(super) fn is_symmetric(problem: &dyn Problem) -> bool {
    let (ode, v) = (problem.ode(), problem.initial());
    let n = ode.dim();
    if v.len() != n {
        return false;
    }
    let direction = |phase: f64| (0..n).map(|i| (phase + i as f64).sin()).collect::<Vec<_>>();
    let (x, y) = (direction(1.0), direction(2.0));
    let there: Vec<f64> = v.iter().zip(&x).map(|(v, x)| v + x).collect();
    let product = |t: f64, v: &[f64], x: &[f64]| {
        let mut out = vec![0.0; n];
        ode.product(t, v, x, &mut out);
        out
    };
    let rhs = |t: f64, v: &[f64]| {
        let mut out = vec![0.0; n];
        ode.rhs(t, v, &mut out);
        out
    };
    let (a_x, a_y, here) = (product(0.0, &v, &x), product(0.0, &v, &y), rhs(0.0, &v));
    let step: Vec<f64> = rhs(1.0, &there).iter().zip(&here).map(|(there, here)| there - here).collect();
    let size = max_norm(&a_x) + max_norm(&a_y) + max_norm(&here) + max_norm(&step);
    // Some n roundings of sums of as many terms.
    let within = 64.0 * f64::EPSILON * n as f64 * size;
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    distance(&product(1.0, &there, &x), &a_x) <= within
        && distance(&step, &a_x) <= within
        && distance(&rhs(1.0, &v), &here) <= within
        && (dot(&x, &a_y) - dot(&y, &a_x)).abs() <= within * n as f64
}

/// The nominal order, where the solution sets the scale of time.
fn regular(facts: &Facts, traits: &Traits) -> OrderPlan {
    match traits.principle {
        // Smaller steps are soon at roundoff.
        Principle::Hamilton if traits.order > 4 => {
            OrderPlan::new(traits.order, Window { horizon: facts.high_order_horizon, coarsest: 0.5 })
        }
        Principle::Equation | Principle::Hamilton => OrderPlan::settled(traits.order, facts.window),
        _ => OrderPlan::settled(traits.order, facts.least_squares.unwrap_or(facts.window)),
    }
}

/// The nominal order where transients decay at rates up to `fastest`.
///
/// Orders up to 2 settle at steps that resolve the solution alone, within the limit of stability for methods that have one.
/// Higher ones settle where h resolves the transients, and their errors stand clear of roundoff only while these last: up to
/// a few of their times, at a power of two, where solutions are tabulated.
fn transient(Window { horizon, coarsest }: Window, fastest: f64, traits: &Traits) -> OrderPlan {
    let early = 6.0 / fastest;
    let within = |limit: f64| Window { horizon: horizon.min(early), coarsest: coarsest.min(limit / fastest) };
    let window = match (traits.stability, traits.order) {
        (Stability::Unstable, _) => within(1.0),
        (_, 3..) => Window { horizon: horizon.min(early.log2().floor().exp2()), ..within(1.0) },
        (Stability::Conditional, _) => within(1.5),
        (Stability::Damping | Stability::Neutral, _) => Window { horizon, coarsest },
    };
    let late = traits.order > 2 && traits.settles_late;
    let unsettled = late.then_some("the error term of order p + 1 fades at hλ ≪ 1 only, near roundoff");
    OrderPlan { unsettled, ..OrderPlan::new(traits.order, window) }
}

/// Why the order at hλ ≫ 1 is another one than for h → 0.
fn reduction(traits: &Traits) -> &'static str {
    if traits.divides_by_rate {
        "hλ ≫ 1: the error is the defect of the smooth solution divided by λ, not by 1/h"
    } else {
        "hλ ≫ 1: the defects of the stages, of lower order than the method, reach the end of the step undivided by λ"
    }
}

/// The order on a smooth solution, with time scale 1, to which others are attracted at `rate`.
///
/// Methods with a stiff order are measured where h resolves the solution and not the attraction, h·rate ≫ 1, the others on
/// the time scale 1/rate.
fn forced(rate: f64, traits: &Traits) -> OrderPlan {
    let fast = |horizon: f64| OrderPlan::new(traits.order, Window { horizon: horizon / rate, coarsest: 0.25 / rate });
    let slow = |coarsest: f64, ratio: f64, count: i32| {
        let steps = even_steps(4.0, coarsest, ratio, count);
        OrderPlan { steps, ..OrderPlan::new(traits.order, Window { horizon: 4.0, coarsest }) }
    };
    match (traits.stability, traits.stiff_order.filter(|_| rate >= traits.stiff_from)) {
        (Stability::Unstable, _) => fast(4.0),
        (Stability::Conditional, _) | (_, None) => fast(10.0),
        // Undamped errors alternate in sign, (−1)ⁿ, and a dozen step sizes let them die out at the fine end.
        (Stability::Neutral, Some(order)) if order == traits.order => slow(0.4, SQRT_2, 12),
        // High orders change over from one limit to the other early: they are taken well before h·rate = 30.
        (_, Some(order)) if traits.order > 2 => {
            slow(0.2, SQRT_2.sqrt(), 8).declared(f64::from(order), reduction(traits))
        }
        (_, Some(order)) if order == traits.order => slow(0.4, SQRT_2, 8),
        (_, Some(order)) => slow(0.4, SQRT_2, 8).declared(f64::from(order), reduction(traits)),
    }
}

/// `count` step sizes that divide `horizon` into even numbers of steps: `coarsest` and on, finer by `ratio` each.
fn even_steps(horizon: f64, coarsest: f64, ratio: f64, count: i32) -> Vec<f64> {
    let pairs = 0.5 * horizon / coarsest;
    (0..count).map(|k| horizon / (2.0 * (pairs * ratio.powi(k)).round())).collect()
}
