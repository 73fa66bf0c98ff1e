//! Start-up Poiseuille flow with one shape function.

use crate::claim::measure::{at_least, at_most, common, is_within, range, sizes, text};
use crate::claim::{Case, Claim, Finding, Quantifier};
use crate::evidence::{Axis, Figure, Mark, Panel, Table};
use crate::experiment::errors::Errors;
use crate::experiment::floors::{self, A_QUARTER, CLOSE, Floors};
use crate::experiment::one_step::OneStep;
use crate::experiment::{Context, StudyError};
use crate::measure::norm::{Extremes, larger};
use crate::measure::refinement::three_grids::Triplet;
use crate::row;

use super::{BASELINES, BOTH, ahead};

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "S24-i",
        source: "[S24] Section 5, Eqs. (38), (39)",
        statement: "As h → ∞ one step of Method I gives the steady velocity γ/2 of the channel, whatever the start.",
        quantifier: Quantifier::Universal,
        criterion: "|v₁ − γ/2| of one live step of h = 10⁴ is below 10⁻⁷ for γ = 2 and v₀ from −1 to 10, and for γ = 0.5.",
        decide: steady_limit,
    },
    Claim {
        id: "S24-q",
        source: "[S24] Section 5, after Eq. (38)",
        statement: "The scheme (38) of Method I for Poiseuille flow is unconditionally stable.",
        quantifier: Quantifier::Universal,
        criterion: "One live step from v₀ = 0 and 10 multiplies the distance from γ/2, γ = 2, by less than 1 at every h tested from 0.001 to 10⁴.",
        decide: stable_flow,
    },
    Claim {
        id: "S24-j",
        source: "[S24] Abstract, Sections 5 and 6, Figures 6 and 7",
        statement: "On Poiseuille flow Method I generally has smaller errors than Method II, than implicit Euler and than RK4, even at very small h.",
        quantifier: Quantifier::Comparison,
        criterion: "Its largest error on (0, 10] of the velocity at the centre, which Figures 6 and 7 show for the profile of the abstract, is smaller than that of the three as the paper runs them, on the \
                    domain-averaged equation, and than that of implicit Euler and RK4 on the Galerkin equation, the \
                    one to which Method I itself converges; h from 0.5 to 0.00001, the steps of Figure 6 and 0.2.",
        decide: against_all,
    },
    Claim {
        id: "S24-k",
        source: "[S24] Section 5, Figure 7",
        statement: "For h ≲ 0.01 the largest error of Method I on Poiseuille flow is about a quarter of that of the other three.",
        quantifier: Quantifier::General,
        criterion: "The ratio of the largest errors on (0, 10], the three run as in the paper, is nearer to a quarter than to a \
                    third and a fifth, for h = 0.01, 0.001, 0.0001 and 0.00001: h ≲ 0.01 is read as h ≤ 0.01.",
        decide: a_quarter,
    },
    Claim {
        id: "S24-l-1",
        source: "[S24] Section 5, Figure 7",
        statement: "On Poiseuille flow the errors do not converge to zero as h → 0.",
        quantifier: Quantifier::Universal,
        criterion: "The limit of Method I's largest error, by Richardson extrapolation, is above zero by more than its grid \
                    convergence index, and is the distance of the Galerkin equation's solution from the flow to within it. At h = 0.0001 the largest errors of \
                    the other three are above half the distance of the averaged equation's solution.",
        decide: floor,
    },
    Claim {
        id: "S24-l-2",
        source: "[S24] Section 5, caption of Figure 7",
        statement: "The numerical solution comes as close to the exact one as the shape function allows.",
        quantifier: Quantifier::Universal,
        criterion: "The limits of the largest errors of Methods I and II are within 1 % of the smallest: at the centre, of that which a relaxation \
                    v̇ = μ(γ/2 − v) of the same shape function reaches at any rate μ; over the channel, in the root mean square, of that which any v(t) does.",
        decide: as_close_as_possible,
    },
];

const STEPS: [f64; 7] = [0.5, 0.2, 0.1, 0.01, 0.001, 1e-4, 1e-5];
/// The steps that are scanned for where the claim on all four holds.
const SCANNED: [f64; 2] = [0.001, 0.5];
const SECOND_ORDER: &str = "trapezoidal";

/// Where Methods I and II step the Lagrangian (37), and the others the domain-averaged equation (41), as the paper pairs them.
const AVERAGED: &str = "poiseuille-ansatz";
/// Where the others step the Galerkin equation.
const GALERKIN: &str = "poiseuille-galerkin";

fn error(context: &Context, method: &'static str, problem: &'static str, h: f64) -> Result<f64, StudyError> {
    Ok(Errors::of(problem, method, h).largest(context)?)
}

fn steady_limit(context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, h) = (Vec::new(), 1e4);
    let starts: [(f64, f64, &str); 8] = [
        (1.0, -1.0, "poiseuille-ansatz v0=-1"),
        (1.0, 0.0, "poiseuille-ansatz v0=0"),
        (1.0, 0.5, "poiseuille-ansatz v0=0.5"),
        (1.0, 10.0, "poiseuille-ansatz v0=10"),
        (0.25, -1.0, "poiseuille-ansatz gamma=0.5 v0=-1"),
        (0.25, 0.0, "poiseuille-ansatz gamma=0.5 v0=0"),
        (0.25, 0.5, "poiseuille-ansatz gamma=0.5 v0=0.5"),
        (0.25, 10.0, "poiseuille-ansatz gamma=0.5 v0=10"),
    ];
    for (steady, start, problem) in starts {
        let v = OneStep { problem, method: BOTH[0].into(), h }.or_infinity(context)?;
        // Below 1/(15/4 h²) of the excess by 2/(3h) of itself; both values are rounded.
        let left = (start - steady).abs() / (3.75 * h * h) + f64::EPSILON * larger(steady, v.abs());
        cases.push(Case::below(format!("|v₁ − γ/2|, γ/2 = {steady}, {problem}"), (v - steady).abs(), left));
    }
    let worst = cases.iter().map(|case| case.measured).largest();
    let evidence = format!("One step of h = 10⁴ comes within {} of γ/2 from every start.", at_most(worst));
    let finding = Finding::on(cases, evidence).beside("largest distance from γ/2, h = 10⁴", "→ 0", worst);
    Ok(finding.because("The excess is divided by 1 + (5/2)h + (15/4)h², Eq. (38)."))
}

fn stable_flow(context: &Context) -> Result<Finding, StudyError> {
    let mut cases = Vec::new();
    for (start, problem) in [(0.0, "poiseuille-ansatz v0=0"), (10.0, "poiseuille-ansatz v0=10")] {
        for h in [1e-3, 0.01, 0.1, 0.5, 1.0, 2.5, 10.0, 100.0, 1e4] {
            let v = OneStep { problem, method: BOTH[0].into(), h }.or_infinity(context)?;
            let left = ((v - 1.0) / (start - 1.0)).abs();
            cases.push(Case::below(
                format!("part of the distance that is left after a step, h = {h}, {problem}"),
                left,
                1.0,
            ));
        }
    }
    let evidence = format!(
        "A step leaves {} of the distance.",
        range(cases.iter().map(|case| case.measured).smallest(), cases.iter().map(|case| case.measured).largest())
    );
    Ok(Finding::on(cases, evidence)
        .because("The factor is 1/(1 + (5/2)h + (15/4)h²), below 1 for every h > 0. The limit h → ∞, from which the source infers it, would not be enough."))
}

fn against_all(context: &Context) -> Result<Finding, StudyError> {
    let mut cases = Vec::new();
    let mut rows = Vec::new();
    let mut curve = |method: &'static str, problem: &'static str, label: &str| -> Result<Vec<f64>, StudyError> {
        let errors = STEPS.iter().map(|h| error(context, method, problem, *h)).collect::<Result<Vec<_>, _>>()?;
        let equation = if label == "own" { method.into() } else { format!("{method}, {label}") };
        rows.extend(STEPS.iter().zip(&errors).map(|(h, e)| row![&equation, *h, *e]));
        Ok(errors)
    };
    let own = curve(BOTH[0], AVERAGED, "own")?;
    let rivals = [
        ("method-ii as in the paper", curve(BOTH[1], AVERAGED, "own")?),
        ("implicit-euler, averaged", curve(BASELINES[0], AVERAGED, "averaged")?),
        ("rk4, averaged", curve(BASELINES[1], AVERAGED, "averaged")?),
        ("implicit-euler, Galerkin", curve(BASELINES[0], GALERKIN, "Galerkin")?),
        ("rk4, Galerkin", curve(BASELINES[1], GALERKIN, "Galerkin")?),
    ];
    curve(SECOND_ORDER, AVERAGED, "averaged")?;
    let second_order = curve(SECOND_ORDER, GALERKIN, "Galerkin")?;
    let scanned = |problem, rival| ahead(context, problem, [BOTH[0], rival], 1.0, SCANNED);
    let mut as_the_paper_runs_them = scanned(AVERAGED, BOTH[1])?;
    for rival in BASELINES {
        as_the_paper_runs_them = common(&as_the_paper_runs_them, &scanned(AVERAGED, rival)?);
    }
    // The Lagrangian of Method I is the same in both settings.
    let [implicit, explicit] = BASELINES.map(|rival| scanned(GALERKIN, rival));
    for (place, &(rival, ref errors)) in rivals.iter().enumerate() {
        for ((h, mine), theirs) in STEPS.iter().zip(&own).zip(errors) {
            let case = Case::below(format!("largest error, h = {h}, against {rival}"), *mine, *theirs);
            let is_ahead = *h < SCANNED[0] || is_within(&as_the_paper_runs_them, *h);
            cases.push(case.under(place <= BASELINES.len() && is_ahead).against(rival));
        }
    }
    let at = |rival: usize, step: usize| text(rivals[rival].1[step]);
    let evidence = format!(
        "At h = 0.001 the largest errors are {} (Method I), {} (Method II), {} and {} (implicit Euler and RK4 on the averaged \
         equation), but {} and {} (the same two on the Galerkin equation).",
        text(own[4]),
        at(0, 4),
        at(1, 4),
        at(2, 4),
        at(3, 4),
        at(4, 4)
    );
    let caption = "Largest error on (0, 10] of the centre velocity, γ = 2, by integrator and reduced equation.";
    let data = Table::data("claims-poiseuille", caption, ["equation", "h", "max_error"], rows);
    let caption = "Largest error on (0, 10] of the centre velocity. Every integrator ends on one of two levels, that of the \
                   equation it steps: the projection earns the advantage, not the time integrator.";
    let curves = data.curves("equation", "h", "max_error", Mark::LineMarkers);
    let panel = Panel::new(Axis::log("step size h"), Axis::log("largest error"), curves);
    let figure = Figure::new("claims-poiseuille", caption, "claims-poiseuille", [panel]);
    Ok(Finding::on(cases, evidence)
        .holds_where(format!(
            "Against Method II, and against implicit Euler and RK4 on the averaged equation (41), at {} (scanned from 0.001 to 0.5; tested to 0.00001). This is how Section \
             5 runs them; the abstract and Section 6 do not say so. On the Galerkin equation, v̇ = (5/4)(γ − 2v), it is ahead of implicit Euler \
             at {}, and of RK4 at {}.",
            sizes("h", &as_the_paper_runs_them, SCANNED),
            sizes("h", &implicit?, SCANNED),
            sizes("h", &explicit?, SCANNED)
        ))
        .because(format!(
            "Methods I and II do not solve the same equation: p → 0 is the Galerkin projection of the flow, ṗ → 0 the \
             domain average, whose rate 3 is further from the true π²/4 than 5/2 is. Where implicit Euler is ahead on the averaged equation, its step decays \
             too slowly by as much as the equation does too fast. On the Galerkin equation the \
             trapezoidal rule has the error {} at h = 0.001, and at h = 0.1 {} where Method I, of first order here, has {}.",
            text(second_order[4]),
            text(second_order[2]),
            text(own[2])
        ))
        .with_figure(figure, data))
}

fn a_quarter(context: &Context) -> Result<Finding, StudyError> {
    const BETWEEN: [f64; 2] = [0.001, 0.1];
    const RIVALS: [&str; 3] = [BOTH[1], BASELINES[0], BASELINES[1]];
    let [least, most] = [A_QUARTER[1].recip(), A_QUARTER[0].recip()];
    // Where the rival's error is a quarter: below the most, and not below the least.
    let start = |rival: &'static str| -> Result<f64, StudyError> {
        let scan = |times| ahead(context, AVERAGED, [rival, BOTH[0]], times, BETWEEN);
        match (&scan(least)?[..], &scan(most)?[..]) {
            ([[from, to]], [all]) if *to == BETWEEN[1] && *all == BETWEEN => Ok(*from),
            found => Err(format!("against {rival} it is no quarter from a step down, but {found:?}").into()),
        }
    };
    let mut starts = Vec::new();
    for rival in RIVALS {
        starts.push(start(rival)?);
    }
    let mut cases = Vec::new();
    for h in [0.01, 0.001, 1e-4, 1e-5] {
        let own = error(context, BOTH[0], AVERAGED, h)?;
        for (rival, start) in RIVALS.into_iter().zip(&starts) {
            let ratio = error(context, rival, AVERAGED, h)? / own;
            let what = format!(
                "error of {rival} over that of method-i (a quarter: nearer to it than to a third and a fifth), h = {h}"
            );
            cases.push(Case::between(what, ratio, least, most).under(h < *start));
        }
    }
    let floors = context.get(Floors)?;
    let limit = floors.averaged / floors.galerkin;
    let ratios = || cases.iter().map(|case| case.measured);
    let evidence = format!(
        "The errors of the others are {} times Method I's; as h → 0 all tend to {} times.",
        range(ratios().smallest(), ratios().largest()),
        text(limit)
    );
    let finding = Finding::on(cases, evidence)
        .beside("Method I's error over the others', h → 0", "≈ 1/4", limit.recip())
        .beside("from h down, against implicit Euler", "≲ 0.01", starts[1]);
    let down = |place: usize| sizes("h", &[[BETWEEN[0], starts[place]]], BETWEEN);
    let finding = finding.holds_where(format!(
        "Against Method II at {}, against implicit Euler at {}, against RK4 at {} (scanned from 0.1 to 0.001, tested to 0.00001).",
        down(0),
        down(1),
        down(2)
    ));
    Ok(finding.because(
        "At these steps the errors are those of the two reduced equations. The quarter is the ratio of their distances from \
         the flow and says nothing of time integration.",
    ))
}

fn floor(context: &Context) -> Result<Finding, StudyError> {
    let values = [0.001, 0.002, 0.004].map(|h| error(context, BOTH[0], AVERAGED, h));
    let [fine, medium, coarse] = values;
    let fine = fine?;
    let limit = Triplet::new([(0.001, fine), (0.002, medium?), (0.004, coarse?)], 0.0)?;
    let uncertainty = limit.gci * fine.abs();
    let galerkin = context.get(Floors)?.galerkin;
    let mut cases = vec![
        Case::above("limit of the largest error of Method I", limit.limit, uncertainty),
        Case::below(
            "its difference from the distance of the Galerkin solution",
            (limit.limit - galerkin).abs(),
            uncertainty,
        ),
    ];
    let floors = context.get(Floors)?;
    for rival in [BOTH[1], BASELINES[0], BASELINES[1]] {
        let at_the_finest = error(context, rival, AVERAGED, 1e-4)?;
        cases.push(Case::above(format!("largest error of {rival}, h = 0.0001"), at_the_finest, 0.5 * floors.averaged));
    }
    let evidence = format!(
        "Steps of 0.004, 0.002 and 0.001 extrapolate to {} ± {} with observed order {}; the Galerkin equation's solution is {} \
         from the flow.",
        text(limit.limit),
        text(uncertainty),
        text(limit.order),
        text(galerkin)
    );
    Ok(Finding::on(cases, evidence).because(
        "The limit is the error of the reduced equation, that of Method I's here. The form of the shape function, which the paper names, \
         is a cause: with this one no linear relaxation converges. Which limit is reached is another matter, S24-l-2.",
    ))
}

fn as_close_as_possible(context: &Context) -> Result<Finding, StudyError> {
    let floors = context.get(Floors)?;
    let floors::Found { galerkin, averaged, best, best_rate, projection, ref profile, .. } = *floors;
    let over = |name: &str, centre: f64, of_profile: f64| {
        let what = |place: &str| format!("limit of {name} over the smallest, {place}");
        [
            Case::below(what("at the centre"), centre / best, CLOSE),
            Case::below(what("over the channel"), of_profile / profile.projection, CLOSE),
        ]
    };
    let mut cases = Vec::from(over("Method II, the averaged equation,", averaged, profile.averaged));
    let [at_the_centre, over_the_channel] = over("Method I, the Galerkin equation,", galerkin, profile.galerkin);
    cases.extend([at_the_centre, over_the_channel.under(true)]);
    let mut others = Vec::new();
    for method in BASELINES {
        others.push(text(error(context, method, GALERKIN, 0.001)?));
    }
    let evidence = format!(
        "The limits at the centre are {} (Method I) and {} (Method II); the rate μ = {} reaches {} with the same shape function, and the parabola fitted to the \
         flow by least squares {}. Over the channel they are {} and {}, and the fit has {}.",
        text(galerkin),
        text(averaged),
        text(best_rate),
        text(best),
        text(projection),
        text(profile.galerkin),
        text(profile.averaged),
        text(profile.projection)
    );
    Ok(Finding::on(cases, evidence)
        .holds_where(format!(
            "With Method I over the channel, and that the shape function keeps the errors from converging to zero: with it and a linear relaxation the floor at \
             the centre is {} at least. Which floor is reached there, {} or {}, is set by the projection.",
            at_least(best),
            text(galerkin),
            text(averaged)
        ))
        .because(format!(
            "With v(t) free, the shape function meets the centre velocity exactly; what the methods solve is one equation for v or another, and the \
             errors of these two differ by a factor of {}. No closure is needed for either: with steps of 0.001 implicit Euler and RK4 on the \
             Galerkin equation have {}. With more shape functions the errors \
             converge to zero: the chapter on the orders of a discretised channel.",
            text(averaged / galerkin),
            others.join(" and ")
        )))
}
