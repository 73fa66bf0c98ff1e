//! Figures 6 and 7.

use super::{HORIZON, METHODS, PAPERS, Plan, Sweep, prose};
use crate::chapter::{Context, Study, StudyError};
use crate::evidence::number::short;
use crate::evidence::{Check, Evidence, Figure, Requirement, Table};
use crate::experiment::errors::Ahead;
use crate::experiment::floors::{A_QUARTER, AVERAGED_RATE, Floors, Found, GALERKIN_RATE, GAMMA};
use crate::kinds::{Principle, Stability};
use crate::measure::norm::max_norm;
use crate::method;
use crate::problem::poiseuille_series::SLOWEST_DECAY_RATE;
use crate::row;

pub(in crate::chapter) const STUDY: Study = Study {
    id: "poiseuille-ansatz",
    title: "Poiseuille flow: Figures 6 and 7",
    question: "Is Method I better than the others on the start-up flow, and if so, why?",
    source: "[S24] Section 5, Figures 6 and 7",
    run,
};

/// The paper's pairing: its methods on the Lagrangian, the others on the domain-averaged equation.
const AVERAGED: &str = "poiseuille-ansatz";
/// The others on the Galerkin equation.
const GALERKIN: &str = "poiseuille-galerkin";

const YARDSTICKS: [&str; 4] = ["implicit-euler", "rk4", "trapezoidal", "implicit-midpoint"];

pub(crate) const PLAN: Plan = Plan {
    cases: &[(AVERAGED, &METHODS), (GALERKIN, &YARDSTICKS)],
    steps: [0.5, 0.1, 0.01, 0.001, 0.0001, 0.000_01],
    figure: 6,
};

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let sweep = Sweep::run(&PLAN, context)?;
    let floors = context.get(Floors)?;
    let mut checks = vec![sweep.follows_the_closed_forms(), sweep.errors_decay(context)?];
    checks.extend(papers_pairing(&sweep));
    checks.extend(same_equation(&sweep));
    checks.extend(at_the_floor(&sweep, &floors));
    checks.extend(floors_checks(&floors));
    checks.push(closer_to_the_floor(&sweep, &floors));
    Ok(Evidence {
        checks,
        tables: vec![
            sweep.maxima_table(
                "Largest |v − u(0, t)| up to t = 10: `poiseuille-ansatz` as the paper pairs methods and equations, \
                 `poiseuille-galerkin` with the yardsticks on the equation that Method I approximates.",
            ),
            floors_table(&floors),
            sweep.series_table(),
        ],
        figures: figures(&sweep),
        notes: prose::fill(include_str!("poiseuille.md"), &values(&sweep, &floors, implicit_euler_leads(context)?))?,
        ..Evidence::default()
    })
}

fn figures(sweep: &Sweep) -> Vec<Figure> {
    let averaged = METHODS.map(|method| (AVERAGED, method));
    let closures = [(AVERAGED, "method-i"), (AVERAGED, "method-ii")];
    let galerkin: Vec<_> = closures.into_iter().chain(YARDSTICKS.map(|method| (GALERKIN, method))).collect();
    vec![
        sweep.series_figure(
            "figure-6".into(),
            "Errors of the centre velocity in the panels of the paper's Figure 6: Methods I, II and p_n = 0 on the Lagrangian \
             (37), the others on the averaged equation (41). For small h the curves of each equation lie on each other."
                .into(),
            AVERAGED,
            &METHODS,
        ),
        sweep.series_figure(
            "figure-6-galerkin".into(),
            "The same yardsticks on the Galerkin equation.".into(),
            GALERKIN,
            &YARDSTICKS,
        ),
        Figure::new(
            "figure-7",
            "Largest error up to t = 10 against 1/h. (a) The paper's Figure 7: Method I ends at a lower floor than all \
             methods on the averaged equation, Method II among them. (b) With the yardsticks on the Galerkin \
             equation all but Method II end at the same floor.",
            "figure-7",
            [
                sweep.maxima_panel("(a) yardsticks on the averaged equation", &averaged),
                sweep.maxima_panel("(b) yardsticks on the Galerkin equation", &galerkin),
            ],
        )
        .in_columns(2),
    ]
}

/// "Method I generally outperforms all three other methods, even for very small values of h. With h ≲ 0.010, the maximum error
/// exhibited by Method I is only roughly one-quarter that of the other three methods."
fn papers_pairing(sweep: &Sweep) -> Vec<Check> {
    let others = || PAPERS.into_iter().filter(|method| *method != "method-i");
    let mut checks = Vec::new();
    for h in sweep.steps() {
        let ratio =
            max_norm(&others().map(|method| sweep.ratio(AVERAGED, ("method-i", method), h)).collect::<Vec<_>>());
        checks.push(Check::at_most(
            format!("method-i-leads-{h}"),
            format!("at h = {h} Method I has a smaller error than implicit Euler and RK4 on the averaged equation, and Method II"),
            ratio,
            1.0,
            "Largest error of Method I over the smallest of the other three.",
        ));
        if h < 0.01 {
            checks.push(Check::within(
                format!("a-quarter-{h}"),
                format!("at h = {h} the largest error of Method I is roughly a quarter of theirs"),
                ratio,
                A_QUARTER,
                "The same ratio; the paper has roughly a quarter for h ≲ 0.01, read as nearer to ¼ than to ⅓ and to ⅕.",
            ));
        }
        if h == 0.01 {
            checks.push(Check::new(
                format!("a-quarter-{h}"),
                format!("at h = {h} the largest error of Method I is nearer to a third of implicit Euler's than to a quarter"),
                ratio,
                Requirement::Above(A_QUARTER[1]),
                "The same ratio; the paper has roughly a quarter for h ≲ 0.01, read as nearer to ¼ than to ⅓ and to ⅕.",
            ));
        }
    }
    checks
}

/// The steps between those of the figure at which implicit Euler, on the averaged equation, is ahead of Method I.
fn implicit_euler_leads(context: &Context) -> Result<[f64; 2], StudyError> {
    let ahead =
        Ahead { problem: AVERAGED, method: "implicit-euler", rival: "method-i", times: 1.0, between: [0.001, 0.5] };
    match context.get(ahead)?[..] {
        [interval] => Ok(interval),
        ref found => Err(format!("implicit Euler is ahead at {found:?}").into()),
    }
}

/// What the text says in numbers.
fn values(sweep: &Sweep, floors: &Found, [from, to]: [f64; 2]) -> Vec<(&'static str, String)> {
    let h = 0.01;
    let others = PAPERS.into_iter().filter(|method| *method != "method-i");
    let ratios: Vec<f64> = others.map(|method| sweep.ratio(AVERAGED, ("method-i", method), h)).collect();
    vec![
        ("ratio_coarse", short(max_norm(&ratios))),
        ("h_coarse", h.to_string()),
        ("from", short(from)),
        ("to", short(to)),
        ("limit", short(floors.galerkin / floors.averaged)),
        ("galerkin", short(floors.galerkin)),
        ("averaged", short(floors.averaged)),
        ("best_rate", short(floors.best_rate)),
        ("best", short(floors.best / floors.galerkin)),
        ("gamma", GAMMA.to_string()),
        ("galerkin_rate", GALERKIN_RATE.to_string()),
        ("averaged_rate", AVERAGED_RATE.to_string()),
    ]
}

/// On the Galerkin equation the others are at the floor before Method I is.
fn closer_to_the_floor(sweep: &Sweep, floors: &Found) -> Check {
    let off = |problem, method| (sweep.error(problem, method, 0.01) - floors.galerkin).abs();
    let second_order = ["rk4", "trapezoidal", "implicit-midpoint"];
    let ratios = second_order.map(|method| off(GALERKIN, method) / off(AVERAGED, "method-i"));
    Check::at_most(
        "closer-to-the-floor",
        "at h = 0.01 RK4, the trapezoidal and the implicit midpoint rule are closer to the floor of the Galerkin equation than Method I",
        max_norm(&ratios),
        1.0,
        "Largest ratio of the distances of the largest errors from the floor.",
    )
}

/// The comparison that tells the integrator from the equation: yardsticks on the Galerkin equation.
fn same_equation(sweep: &Sweep) -> Vec<Check> {
    let finest = sweep.steps().filter(|h| *h <= 0.01);
    let mut checks = Vec::new();
    for h in finest {
        for method in YARDSTICKS {
            // Both runs are within what their order leaves of the common floor; see `at_the_floor`.
            let (a, b) = (sweep.error(AVERAGED, "method-i", h), sweep.error(GALERKIN, method, h));
            let slack = (drift("method-i", h) + drift(method, h)) / b;
            checks.push(Check::within(
                format!("same-equation-{method}-{h}"),
                format!("on the Galerkin equation Method I has no advantage over {method} at h = {h}"),
                a / b,
                [1.0 - slack, 1.0 + slack],
                "Ratio of the largest errors; the width is what the two methods' own errors allow.",
            ));
        }
    }
    checks
}

/// Bound on how far a run of `method` strays from the solution of its limiting equation: the leading error term of its factor
/// R = e^{−λh + c h^k}, |c| h^{k−1} t e^{−λt} ≤ |c| h^{k−1}/(λe), and half of that again.
///
/// R is that of Method I's Galerkin equation, implicit Euler, (1 + z/2)/(1 − z/2) or the exponential's polynomial of degree
/// four; NaN for any other method.
fn drift(method: &str, h: f64) -> f64 {
    let traits = method::parse(method).map(|method| method.traits());
    let (c, rate, k): (f64, f64, i32) = match traits.map(|traits| (traits.principle, traits.order, traits.stability)) {
        Ok((Principle::MomentumZero, ..)) => (0.625, GALERKIN_RATE, 2),
        Ok((Principle::Equation, 1, _)) => (AVERAGED_RATE.powi(2) / 2.0, AVERAGED_RATE, 2),
        Ok((_, 2, Stability::Neutral)) => (AVERAGED_RATE.powi(3) / 12.0, AVERAGED_RATE, 3),
        Ok((Principle::Equation, 4, _)) => (AVERAGED_RATE.powi(5) / 120.0, AVERAGED_RATE, 5),
        _ => return f64::NAN,
    };
    1.5 * c * h.powi(k - 1) / (rate * std::f64::consts::E)
}

/// Whether a method sets a momentum of the Lagrangian (37) to zero, and so approximates the Galerkin equation.
fn is_galerkin(method: &str) -> bool {
    method::parse(method).is_ok_and(|method| method.principle() == Principle::MomentumZero)
}

/// Every run ends at the floor of its equation: the distance of the equation's solution from the flow.
fn at_the_floor(sweep: &Sweep, floors: &Found) -> Vec<Check> {
    let finest = sweep.steps().last().unwrap_or(HORIZON);
    let runs = sweep.runs.iter().filter(|run| run.of.h == finest);
    runs.map(|run| {
        let galerkin = run.of.problem == GALERKIN || is_galerkin(run.of.method);
        let (name, floor) = if galerkin { ("Galerkin", floors.galerkin) } else { ("averaged", floors.averaged) };
        // The largest error over grid points misses the maximum by at most ½h times the slope, which is below 2.
        let slack = drift(run.of.method, finest) + finest + Found::SAMPLING;
        let error = run.largest.as_ref().map_or(f64::NAN, |largest| largest.error);
        Check::within(
            format!("floor-{}-{}", run.of.problem, run.of.method),
            format!("{} ends at the floor of the {name} equation", run.of.method),
            error,
            [floor - slack, floor + slack],
            format!("Largest error at h = {finest}; the width is the method's own error and the grid's."),
        )
    })
    .collect()
}

/// The candidates for v(t), their distances and their rates.
fn floors_rows(floors: &Found) -> [(&'static str, f64, Option<f64>); 5] {
    [
        ("averaged equation (41)", floors.averaged, Some(AVERAGED_RATE)),
        ("Galerkin equation", floors.galerkin, Some(GALERKIN_RATE)),
        ("slowest rate of the flow", floors.slowest, Some(SLOWEST_DECAY_RATE)),
        ("best constant rate", floors.best, Some(floors.best_rate)),
        ("least-squares fit of the profile", floors.projection, None),
    ]
}

fn floors_table(floors: &Found) -> Table {
    let rows = floors_rows(floors).map(|(name, floor, rate)| row![name, rate, floor]);
    let caption = "Largest distance of v(t) from the centre velocity of the flow, for several v(t) in the ansatz (35).";
    Table::new("poiseuille-floors", caption, ["v", "rate", "max_error"], rows.to_vec())
}

fn floors_checks(floors: &Found) -> [Check; 4] {
    [
        Check::within(
            "floors",
            "the floor of the Galerkin equation is 0.28 times that of the averaged one: the quarter of the paper",
            floors.galerkin / floors.averaged,
            [0.275, 0.285],
            "Ratio of the distances of the two solutions from the flow; no method takes part in it.",
        ),
        Check::at_most(
            "floor-is-not-least",
            "the floor is not as close as the ansatz can get: another constant rate more than halves it",
            floors.best / floors.galerkin,
            0.5,
            format!("v = 1 − e^{{−ct}} with the best c = {:.4} over that with the Galerkin 5/2.", floors.best_rate),
        ),
        Check::at_most(
            "profile-fit",
            "the parabola fitted to the profile of the flow by least squares is also closer at the centre",
            floors.projection / floors.galerkin,
            1.0,
            "Ratio of the largest errors at the centre.",
        ),
        Check::at_most(
            "slowest-rate",
            "so is the relaxation with the slowest rate of the flow, π²/4",
            floors.slowest / floors.galerkin,
            1.0,
            "Ratio of the largest errors at the centre.",
        ),
    ]
}
