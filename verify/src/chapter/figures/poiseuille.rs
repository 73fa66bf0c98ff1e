//! Figures 6 and 7.

use super::{HORIZON, METHODS, PAPERS, Plan, Sweep, prose};
use crate::chapter::{Context, Study, StudyError};
use crate::evidence::number::{brief, rounded_down, rounded_up, short};
use crate::evidence::{Check, Evidence, Figure, Requirement, Table};
use crate::experiment::errors::{Ahead, Run};
use crate::experiment::floors::{A_QUARTER, A_THIRD, AVERAGED_RATE, CLOSE, Floors, Found, GALERKIN_RATE, GAMMA};
use crate::kinds::{Principle, Stability};
use crate::measure::norm::{Extremes, max_norm};
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

const BASELINES: [&str; 4] = ["implicit-euler", "rk4", "trapezoidal", "implicit-midpoint"];

pub(crate) const PLAN: Plan = Plan {
    cases: &[(AVERAGED, &METHODS), (GALERKIN, &BASELINES)],
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
                 `poiseuille-galerkin` with the baseline methods on the equation that Method I approximates.",
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
    let galerkin: Vec<_> = closures.into_iter().chain(BASELINES.map(|method| (GALERKIN, method))).collect();
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
            "The baseline methods on the Galerkin equation.".into(),
            GALERKIN,
            &BASELINES,
        ),
        Figure::new(
            "figure-7",
            "Largest error up to t = 10 against 1/h. (a) The paper's Figure 7: Method I ends at a lower floor than all \
             methods on the averaged equation, Method II among them. (b) With the baseline methods on the Galerkin \
             equation all but Method II end at the same floor.",
            "figure-7",
            [
                sweep.maxima_panel("(a) baseline methods on the averaged equation", &averaged),
                sweep.maxima_panel("(b) baseline methods on the Galerkin equation", &galerkin),
            ],
        )
        .in_columns(2)
        .on_one_scale(),
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
    // How far the errors are from the distances of their equations.
    let small = sweep.runs.iter().filter(|run| run.of.h <= h);
    let off = small.map(|run| {
        let (floor, largest) = (equation(run, floors).floor, run.largest.as_ref());
        largest.map_or(f64::NAN, |largest| (largest.error / floor - 1.0).abs())
    });
    let off = off.largest();
    vec![
        ("ratio_coarse", short(max_norm(&ratios))),
        ("h_coarse", h.to_string()),
        ("from", short(rounded_up(from, 4))),
        ("to", short(rounded_down(to, 4))),
        ("off", brief(rounded_up(100.0 * off, 2))),
        ("limit", short(floors.galerkin / floors.averaged)),
        ("galerkin", short(floors.galerkin)),
        ("averaged", short(floors.averaged)),
        ("profile_galerkin", short(floors.profile.galerkin)),
        ("profile_projection", short(floors.profile.projection)),
        ("profile_best", short(floors.profile.best_at_the_centre)),
        ("profile_exact", short(floors.profile.exact_at_the_centre)),
        ("profile_ratio", short(floors.profile.galerkin / floors.profile.averaged)),
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

/// The comparison that tells the integrator from the equation: baseline methods on the Galerkin equation.
fn same_equation(sweep: &Sweep) -> Vec<Check> {
    let finest = sweep.steps().filter(|h| *h <= 0.01);
    let mut checks = Vec::new();
    for h in finest {
        for method in BASELINES {
            // Both runs are within what their order leaves of the common floor; see `at_the_floor`.
            let (a, b) = (sweep.error(AVERAGED, "method-i", h), sweep.error(GALERKIN, method, h));
            checks.push(Check::at_most(
                format!("same-equation-{method}-{h}"),
                format!("on the Galerkin equation Method I and {method} have the same error at h = {h}, but for their own errors of that equation: difference"),
                (a - b).abs(),
                drift("method-i", GALERKIN_RATE, h) + drift(method, GALERKIN_RATE, h),
                "Difference of the largest errors; the bound is what the two methods add to the distance of the equation.",
            ));
        }
    }
    checks
}

/// Bound on how far a run of `method` strays from the solution of its limiting equation, v̇ = λ(γ/2 − v): the leading error term of its factor
/// R = e^{−λh + c h^k}, |c| h^{k−1} t e^{−λt} ≤ |c| h^{k−1}/(λe), and half of that again.
///
/// R is that of Method I's Galerkin equation, implicit Euler, (1 + z/2)/(1 − z/2) or the exponential's polynomial of degree
/// four; NaN for any other method.
fn drift(method: &str, rate: f64, h: f64) -> f64 {
    let traits = method::parse(method).map(|method| method.traits());
    let (c, k): (f64, i32) = match traits.map(|traits| (traits.principle, traits.order, traits.stability)) {
        Ok((Principle::MomentumZero, ..)) => (0.625, 2),
        Ok((Principle::Equation, 1, _)) => (rate.powi(2) / 2.0, 2),
        Ok((_, 2, Stability::Neutral)) => (rate.powi(3) / 12.0, 3),
        Ok((Principle::Equation, 4, _)) => (rate.powi(5) / 120.0, 5),
        _ => return f64::NAN,
    };
    1.5 * c * h.powi(k - 1) / (rate * std::f64::consts::E)
}

/// Whether a method sets a momentum of the Lagrangian (37) to zero, and so approximates the Galerkin equation.
fn is_galerkin(method: &str) -> bool {
    method::parse(method).is_ok_and(|method| method.principle() == Principle::MomentumZero)
}

/// A reduced equation: its name, the distance of its solution from the flow, its rate.
struct Equation {
    name: &'static str,
    floor: f64,
    rate: f64,
}

/// That which a run steps.
fn equation(run: &Run, floors: &Found) -> Equation {
    match run.of.problem == GALERKIN || is_galerkin(run.of.method) {
        true => Equation { name: "Galerkin", floor: floors.galerkin, rate: GALERKIN_RATE },
        false => Equation { name: "averaged", floor: floors.averaged, rate: AVERAGED_RATE },
    }
}

/// Every run ends at the floor of its equation: the distance of the equation's solution from the flow.
fn at_the_floor(sweep: &Sweep, floors: &Found) -> Vec<Check> {
    let finest = sweep.steps().last().unwrap_or(HORIZON);
    let runs = sweep.runs.iter().filter(|run| run.of.h == finest);
    runs.map(|run| {
        let Equation { name, floor, rate } = equation(run, floors);
        // The largest error over grid points misses the maximum by at most ½h times the slope, which is below 2.
        let slack = drift(run.of.method, rate, finest) + finest + Found::SAMPLING;
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

/// The candidates for v(t), their rates, and their distances at the centre and over the channel.
fn floors_rows(floors: &Found) -> [(&'static str, Option<f64>, Option<f64>, f64); 7] {
    let profile = &floors.profile;
    [
        ("averaged equation (41)", Some(AVERAGED_RATE), Some(floors.averaged), profile.averaged),
        ("Galerkin equation", Some(GALERKIN_RATE), Some(floors.galerkin), profile.galerkin),
        ("slowest rate of the flow", Some(SLOWEST_DECAY_RATE), Some(floors.slowest), profile.slowest),
        ("best constant rate at the centre", Some(floors.best_rate), Some(floors.best), profile.best_at_the_centre),
        ("best constant rate over the channel", Some(profile.best_rate), None, profile.best),
        ("least-squares fit of the profile", None, Some(floors.projection), profile.projection),
        ("centre velocity of the flow", None, Some(0.0), profile.exact_at_the_centre),
    ]
}

fn floors_table(floors: &Found) -> Table {
    let rows = floors_rows(floors).map(|(name, rate, centre, profile)| row![name, rate, centre, profile]);
    let caption = "Largest distance of the ansatz (35) from the flow on (0, 10], for several v(t): at the centre, |v − u(0, t)|, and over the \
                   channel, the root mean square of v(1 − y²) − u(y, t).";
    Table::new("poiseuille-floors", caption, ["v", "rate", "max_error", "max_rms_error"], rows.to_vec())
}

fn floors_checks(floors: &Found) -> [Check; 6] {
    [
        Check::within(
            "floors",
            "the floor of the Galerkin equation is roughly a quarter of that of the averaged one, the quarter of the paper",
            floors.galerkin / floors.averaged,
            A_QUARTER,
            "Ratio of the distances of the two solutions from the flow, nearer to ¼ than to ⅓ and to ⅕; no method takes part in it.",
        ),
        Check::at_most(
            "floor-is-not-least",
            "at the centre the floor is not as close as the ansatz can get: another constant rate more than halves it",
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
        Check::at_most(
            "profile-floor",
            "over the channel no v(t) is closer to the flow than the Galerkin equation's solution by one part in a hundred",
            floors.profile.galerkin / floors.profile.projection,
            CLOSE,
            "Ratio of the largest root mean squares, to that of the least-squares fit at each time.",
        ),
        Check::within(
            "profile-floors",
            "over the channel the floor of the Galerkin equation is roughly a third of that of the averaged one",
            floors.profile.galerkin / floors.profile.averaged,
            A_THIRD,
            "Ratio of the largest root mean squares, nearer to ⅓ than to ¼ and to ½.",
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of the runs of 1 − v, Rⁿ against e^{−λnh}.
    #[test]
    fn how_far_a_method_may_stray_is_half_more_than_it_does() {
        type Factor = fn(f64) -> f64;
        let factors: [(&str, Factor); 4] = [
            ("implicit-euler", |z| 1.0 / (1.0 - z)),
            ("trapezoidal", |z| (1.0 + 0.5 * z) / (1.0 - 0.5 * z)),
            ("implicit-midpoint", |z| (1.0 + 0.5 * z) / (1.0 - 0.5 * z)),
            ("rk4", |z| 1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)))),
        ];
        let h = 0.01;
        for (method, factor) in factors {
            for rate in [AVERAGED_RATE, GALERKIN_RATE] {
                let off = |n: i32| (factor(-rate * h).powi(n) - (-rate * h * f64::from(n)).exp()).abs();
                let part = (0..1000).map(off).largest() / drift(method, rate, h);
                assert!((0.6..0.7).contains(&part), "{method}: {part}");
            }
        }
        assert!(drift("bdf2", GALERKIN_RATE, h).is_nan());
    }
}
