//! Figures 1 and 2.

use super::{METHODS, PAPERS, Plan, Sweep, maps};
use crate::chapter::{Context, Study, StudyError};
use crate::evidence::{Check, Evidence, Figure};
use crate::measure::norm::max_norm;
use crate::measure::search::root;

pub(in crate::chapter) const STUDY: Study = Study {
    id: "linear-drag",
    title: "Linear drag: Figures 1 and 2",
    question: "Which method has the smallest error on v̇ = −v, and from which step size on?",
    source: "[S24] Section 3, Figures 1 and 2",
    run,
};

const PROBLEM: &str = "linear-drag";

pub(super) const PLAN: Plan =
    Plan { cases: &[(PROBLEM, &METHODS)], steps: [2.5, 2.0, 1.5, 1.0, 0.1, 0.01], figure: 1, map: maps::linear_drag };

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let sweep = Sweep::run(&PLAN, context)?;
    let mut checks = vec![sweep.follows_the_closed_forms(), sweep.errors_decay()];
    checks.extend(large_steps(&sweep));
    checks.extend(["method-i", "method-ii"].map(overtakes_rk4));
    checks.extend(small_steps(&sweep));
    checks.push(explicit_momentum_grows(&sweep));
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
        Figure {
            id: "figure-2".into(),
            caption: "Largest error up to t = 10 against 1/h: the paper's Figure 2, with three methods more.".into(),
            data: "figure-2".into(),
            panels: vec![sweep.maxima_panel("", &curves)],
            columns: 1,
        },
    ];
    Ok(Evidence {
        checks,
        tables: vec![sweep.maxima_table("Largest error on v̇ = −v at the grid points up to t = 10."), sweep.series_table()],
        figures,
        notes: vec![
            "The paper's reading is nearly right at large steps: at h = 2 and 2.5 both its methods beat implicit Euler and \
             RK4. At h = 1.5 RK4 is still ahead of both; Method I passes it just above, Method II later."
                .into(),
            "Below, both are better than implicit Euler, but by orders of magnitude only because they are of second order: by \
             a factor of 3/h and 6/h. At h = 1 that is four. Held against methods of their own order the advantage is gone: \
             Method II is the trapezoidal rule, and Method I has twice its error."
                .into(),
            "The third closure, p_n = 0, is an explicit method: it grows for h > 2 and stands still at h = 2.".into(),
        ],
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
        max_norm(&ours.map(|method| sweep.ratio(PROBLEM, ("rk4", method), 1.5))),
        1.0,
        "RK4's largest error over that of the better of the two: the paper puts the change at about this step size.",
    );
    vec![ahead(2.5), ahead(2.0), behind]
}

/// Where a method's error after the first step, the largest for steps of this size, falls below RK4's.
fn overtakes_rk4(method: &'static str) -> Check {
    let error = |method: &str, h: f64| maps::linear_drag(PROBLEM, method, h, 1.0).map(|v| (v - (-h).exp()).abs());
    let ahead = |h: f64| Some(error("rk4", h)? - error(method, h)?);
    let h = root([1.0, 2.5], |h| ahead(h).unwrap_or(f64::NAN)).unwrap_or(f64::NAN);
    let (width, reading) = if method == "method-i" {
        ([1.45, 1.55], "as the paper has it, h ≈ 1.5")
    } else {
        ([1.55, 2.0], "later than the paper's h ≈ 1.5")
    };
    Check::within(
        format!("overtakes-rk4-{method}"),
        format!("{method} overtakes RK4 {reading}"),
        h,
        width,
        "Step size at which the errors of the first step are equal, by bisection; to one decimal 1.5 for the first.",
    )
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
        "The paper has several orders of magnitude for h ≲ 1.5; they need h ≲ 0.01.",
    ));
    checks
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
