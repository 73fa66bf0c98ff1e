//! Figures 1 and 2.

use super::{METHODS, PAPERS, Plan, Sweep, prose};
use crate::chapter::{Context, Study, StudyError};
use crate::evidence::number::short;
use crate::evidence::{Check, Evidence, Figure};
use crate::experiment::errors::{Ahead, roundoff};
use crate::experiment::maps::linear_drag;
use crate::measure::norm::max_norm;
use crate::measure::search::try_root;

pub(in crate::chapter) const STUDY: Study = Study {
    id: "linear-drag",
    title: "Linear drag: Figures 1 and 2",
    question: "Which method has the smallest error on v̇ = −v, and from which step size on?",
    source: "[S24] Section 3, Figures 1 and 2",
    run,
};

const PROBLEM: &str = "linear-drag";

pub(crate) const PLAN: Plan = Plan { cases: &[(PROBLEM, &METHODS)], steps: [2.5, 2.0, 1.5, 1.0, 0.1, 0.01], figure: 1 };

/// The steps of the figure at which both methods are ahead.
const LARGE: [f64; 2] = [2.0, 2.5];
/// The step at which the paper puts the change.
const PAPERS_CHANGE: f64 = 1.5;
/// The step at which p_n = 0 has the growth factor 1 − h + h²/2 = 1.
const STILL: f64 = 2.0;

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let sweep = Sweep::run(&PLAN, context)?;
    let mut checks = vec![sweep.follows_the_closed_forms(), sweep.errors_decay(context)?];
    checks.extend(large_steps(&sweep));
    let overtakes = [overtakes_rk4(context, "method-i")?, overtakes_rk4(context, "method-ii")?];
    checks.extend(overtakes.iter().map(Overtakes::check));
    checks.extend(small_steps(&sweep));
    checks.extend([explicit_momentum_stands_still(&sweep), explicit_momentum_grows(&sweep)]);
    let curves = METHODS.map(|method| (PROBLEM, method));
    let figures = vec![
        sweep.series_figure(
            "figure-1".into(),
            "Errors on v̇ = −v, v(0) = 1, against exp(−t), in the panels of the paper's Figure 1. Method II, the trapezoidal \
             rule and the implicit midpoint rule are one method here, and their curves lie on each other."
                .into(),
            PROBLEM,
            &METHODS,
        ),
        Figure::new(
            "figure-2",
            "Largest error up to t = 10 against 1/h: the paper's Figure 2, with three methods more.",
            "figure-2",
            [sweep.maxima_panel("", &curves)],
        ),
    ];
    Ok(Evidence {
        checks,
        tables: vec![
            sweep.maxima_table("Largest error on v̇ = −v at the grid points up to t = 10."),
            sweep.series_table(),
        ],
        figures,
        notes: prose::fill(include_str!("linear_drag.md"), &values(&sweep, overtakes))?,
        ..Evidence::default()
    })
}

/// "For sufficiently large time increments (h ≳ 1.5), Methods I and II outperform both implicit Euler and RK4."
fn large_steps(sweep: &Sweep) -> Vec<Check> {
    let ratios = |better: [&'static str; 2], worse: [&'static str; 2], h: f64| {
        max_norm(&better.map(|a| max_norm(&worse.map(|b| sweep.ratio(PROBLEM, (a, b), h)))))
    };
    let ours = ["method-i", "method-ii"];
    let ahead = |h: f64| {
        Check::at_most(
            format!("large-steps-{h}"),
            format!("at h = {h} Methods I and II have smaller errors than implicit Euler and RK4"),
            ratios(ours, ["implicit-euler", "rk4"], h),
            1.0,
            "Largest error of the worse of the two over that of the better of the others.",
        )
    };
    let behind = Check::at_most(
        "large-steps-1.5",
        "at h = 1.5 RK4 has a smaller error than Methods I and II",
        max_norm(&ours.map(|method| sweep.ratio(PROBLEM, ("rk4", method), PAPERS_CHANGE))),
        1.0,
        "RK4's largest error over that of the better of the two: the paper puts the change at about this step size.",
    );
    vec![ahead(LARGE[1]), ahead(LARGE[0]), behind]
}

/// Where the largest errors of a method and of RK4 are equal: of the live runs, and of the first step of the closed forms, whose
/// error is the largest of a run at steps of this size.
struct Overtakes {
    method: &'static str,
    live: f64,
    closed: f64,
}

fn overtakes_rk4(context: &Context, method: &'static str) -> Result<Overtakes, StudyError> {
    let none = || format!("{method} does not overtake RK4");
    let (low, high) = (1.0, 2.4);
    let ahead = Ahead { problem: PROBLEM, method, rival: "rk4", times: 1.0, between: [low, high] };
    let error = |method: &str, h: f64| linear_drag(method, h, 1.0).map(|v| (v - (-h).exp()).abs()).ok_or_else(none);
    let closed = try_root([low, high], |h| Ok::<_, String>(error(method, h)? - error("rk4", h)?))?;
    let live = context.get(ahead)?.first().map(|interval| interval[0]);
    Ok(Overtakes { method, live: live.ok_or_else(none)?, closed: closed.ok_or_else(none)? })
}

impl Overtakes {
    fn check(&self) -> Check {
        let Self { method, live, closed } = self;
        // Roundings of the errors over the slope of their difference, which is above 0.05 here, and the digits of the search.
        let allowed = roundoff(*closed, 1.0) / 0.05 + 2e-12 * closed;
        Check::within(
            format!("overtakes-rk4-{method}"),
            format!("{method} overtakes RK4 at the step size h = {} at which the closed forms do", short(*closed)),
            *live,
            [closed - allowed, closed + allowed],
            "Step size at which the largest errors of live runs are equal, by bisection; the paper has h ≈ 1.5 for both methods.",
        )
    }
}

/// What the text says in numbers.
fn values(sweep: &Sweep, [one, two]: [Overtakes; 2]) -> Vec<(&'static str, String)> {
    let gain = |method, h| short(sweep.ratio(PROBLEM, ("implicit-euler", method), h));
    let [large_a, large_b] = LARGE;
    let finest = sweep.steps().last().unwrap_or(f64::NAN);
    vec![
        ("large_a", large_a.to_string()),
        ("large_b", large_b.to_string()),
        ("paper", PAPERS_CHANGE.to_string()),
        ("overtakes_i", short(one.live)),
        ("overtakes_ii", short(two.live)),
        ("one", 1.0.to_string()),
        ("gain_i", gain("method-i", 1.0)),
        ("gain_ii", gain("method-ii", 1.0)),
        ("against_trapezoidal", short(sweep.ratio(PROBLEM, ("method-i", "trapezoidal"), finest))),
        ("finest", finest.to_string()),
        ("still", STILL.to_string()),
    ]
}

/// "For smaller time increments (h ≲ 1.5) …": better than implicit Euler, worse than RK4; how much better, and than the
/// trapezoidal rule.
fn small_steps(sweep: &Sweep) -> Vec<Check> {
    let small = || sweep.steps().filter(|h| *h <= 1.5);
    let largest = |ratio: &dyn Fn(f64) -> f64| max_norm(&small().map(ratio).collect::<Vec<_>>());
    let mut checks = Vec::new();
    for method in ["method-i", "method-ii"] {
        checks.push(Check::at_most(
            format!("beats-implicit-euler-{method}"),
            format!("for h ≤ 1.5 {method} has a smaller error than implicit Euler"),
            largest(&|h| sweep.ratio(PROBLEM, (method, "implicit-euler"), h)),
            1.0,
            "Largest ratio of the largest errors.",
        ));
        checks.push(Check::at_most(
            format!("behind-rk4-{method}"),
            format!("for h ≤ 1.5 RK4 has a smaller error than {method}"),
            largest(&|h| sweep.ratio(PROBLEM, ("rk4", method), h)),
            1.0,
            "Largest ratio of the largest errors.",
        ));
    }
    // Largest errors: ½h/e of implicit Euler, h²/6e and h²/12e of Methods I and II and the trapezoidal rule, all up to a
    // factor 1 + O(h).
    for (id, pair, constant, power) in [
        ("gain-method-i", ("implicit-euler", "method-i"), 3.0, 1),
        ("gain-method-ii", ("implicit-euler", "method-ii"), 6.0, 1),
        ("against-trapezoidal", ("method-i", "trapezoidal"), 2.0, 0),
    ] {
        for h in small().filter(|h| *h <= 0.1) {
            let expected = constant / h.powi(power);
            let slack = 2.0 * h;
            checks.push(Check::within(
                format!("{id}-{h}"),
                format!("at h = {h} the error of {} is {expected:.0} times that of {}", pair.0, pair.1),
                sweep.ratio(PROBLEM, pair, h),
                [expected * (1.0 - slack), expected * (1.0 + slack)],
                "From the leading error terms, within a relative 2h.",
            ));
        }
    }
    checks.push(Check::at_most(
        "no-orders-of-magnitude",
        "at h = 1 neither beats implicit Euler by as much as one order of magnitude",
        max_norm(&["method-i", "method-ii"].map(|m| sweep.ratio(PROBLEM, ("implicit-euler", m), 1.0))),
        10.0,
        "The paper has several orders of magnitude for h ≲ 1.5; they need far smaller steps.",
    ));
    checks
}

fn explicit_momentum_stands_still(sweep: &Sweep) -> Check {
    let left = 1.0 - (-super::HORIZON).exp();
    Check::within(
        "explicit-momentum-stands-still",
        format!("p_n = 0 never moves at h = {STILL}"),
        sweep.error(PROBLEM, "explicit-momentum", STILL),
        [left - roundoff(STILL, left), left + roundoff(STILL, left)],
        "Largest error: 1 − exp(−t) at t = 10.",
    )
}

fn explicit_momentum_grows(sweep: &Sweep) -> Check {
    let h = 2.5;
    let errors = PAPERS.map(|method| sweep.error(PROBLEM, method, h));
    Check::at_least(
        "explicit-momentum-grows",
        "p_n = 0 is unstable at h = 2.5: its largest error exceeds that of all four others",
        sweep.error(PROBLEM, "explicit-momentum", h) / max_norm(&errors),
        1.0,
        "|1 − h + h²/2| > 1 for h > 2.",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chapter::figures::tests::sweep;
    use crate::evidence::Outcome;

    #[test]
    fn ratios_of_errors_are_those_of_the_leading_terms_within_twice_the_step() {
        let passes = |off: f64| {
            let sweep = sweep(&PLAN, |method, h| {
                let error = match method {
                    "method-i" => h * h / 6.0,
                    "method-ii" => h * h / 12.0,
                    "implicit-euler" => 0.5 * h * (1.0 + off * h),
                    "trapezoidal" => h * h / 12.0 / (1.0 + off * h),
                    _ => h.powi(4),
                };
                (error, None)
            });
            let checks = small_steps(&sweep);
            let of =
                |id: &str| ["gain-method-i", "gain-method-ii", "against-"].iter().any(|start| id.starts_with(start));
            let outcomes = checks.into_iter().filter(|check| of(&check.id)).map(|check| check.outcome);
            outcomes.map(|outcome| outcome == Outcome::Pass).collect::<Vec<_>>()
        };
        assert_eq!([1.9, -1.9].map(passes), [[true; 6], [true; 6]]);
        assert_eq!([2.1, -2.1].map(passes), [[false; 6], [false; 6]]);
    }
}
