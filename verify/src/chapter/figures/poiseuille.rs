//! Figures 6 and 7.

use lsvi::quadrature::Quadrature;

use super::{HORIZON, METHODS, PAPERS, Plan, Sweep, maps};
use crate::chapter::{Context, Study, StudyError};
use crate::evidence::{Cell, Check, Evidence, Figure, Table};
use crate::kinds::{Principle, Stability};
use crate::measure::norm::max_norm;
use crate::measure::search::minimum;
use crate::method;
use crate::problem::poiseuille_series::{SLOWEST_DECAY_RATE, velocity};

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

pub(super) const PLAN: Plan = Plan {
    cases: &[(AVERAGED, &METHODS), (GALERKIN, &YARDSTICKS)],
    steps: [0.5, 0.1, 0.01, 0.001, 0.0001, 0.000_01],
    figure: 6,
    map: maps::poiseuille,
};

const GAMMA: f64 = 2.0;
const GALERKIN_RATE: f64 = 2.5;
const AVERAGED_RATE: f64 = 3.0;

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let sweep = Sweep::run(&PLAN, context)?;
    let floors = Floors::compute()?;
    let mut checks = vec![sweep.follows_the_closed_forms(), sweep.errors_decay()];
    checks.extend(papers_pairing(&sweep));
    checks.extend(same_equation(&sweep));
    checks.extend(at_the_floor(&sweep, &floors));
    checks.extend(floors.checks());
    Ok(Evidence {
        checks,
        tables: vec![
            sweep.maxima_table(
                "Largest |v − u(0, t)| up to t = 10: `poiseuille-ansatz` as the paper pairs methods and equations, \
                 `poiseuille-galerkin` with the yardsticks on the equation that Method I approximates.",
            ),
            floors.table(),
            sweep.series_table(),
        ],
        figures: figures(&sweep),
        notes: vec![
            "As the paper pairs them, Method I has the smallest error of its four methods at every step size. The ratio is 0.31 \
             at h = 0.01 and tends to 0.2825."
                .into(),
            "But the pairing compares two equations, not four methods. Methods I and p_n = 0 approximate the Galerkin equation, \
             whose solution comes within 0.0242 of the flow; Method II, and implicit Euler and RK4 as the paper sets them up, \
             approximate the averaged equation, which comes within 0.0857. For h ≲ 0.01 every error is the distance of its \
             equation, whatever the method. On the Galerkin equation implicit Euler, RK4, the trapezoidal and the implicit \
             midpoint rule reach the same 0.0242, and all but implicit Euler reach it faster than Method I, which is of first \
             order here because the Lagrangian (37) keeps a remainder."
                .into(),
            "Nor is that floor as close as the ansatz can get, as the paper's Figure 7 has it: v(t) = u(0, t) would have no error \
             at the centre at all. Among v = 1 − e^{−ct} the best rate, 2.337, has less than half the error. Both \
             reduced equations start too fast: the centre of the flow accelerates by γ = 2, the ansatz by 5/2 or 3."
                .into(),
        ],
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
        Figure {
            id: "figure-7".into(),
            caption: "Largest error up to t = 10 against 1/h. (a) The paper's Figure 7: Method I ends at a lower floor than all \
                      methods on the averaged equation, Method II among them. (b) With the yardsticks on the Galerkin \
                      equation all but Method II end at the same floor."
                .into(),
            data: "figure-7".into(),
            panels: vec![
                sweep.maxima_panel("(a) yardsticks on the averaged equation", &averaged),
                sweep.maxima_panel("(b) yardsticks on the Galerkin equation", &galerkin),
            ],
            columns: 2,
        },
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
        let reading = match h {
            0.01 => Some(("less than a third, not quite a quarter", [0.29, 0.34])),
            h if h < 0.01 => Some(("roughly a quarter", [0.2, 0.3])),
            _ => None,
        };
        if let Some((words, width)) = reading {
            checks.push(Check::within(
                format!("a-quarter-{h}"),
                format!("at h = {h} the largest error of Method I is {words} of theirs"),
                ratio,
                width,
                "The same ratio; the paper has roughly a quarter for h ≲ 0.01, read as 0.25 ± 0.05.",
            ));
        }
    }
    checks
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
fn at_the_floor(sweep: &Sweep, floors: &Floors) -> Vec<Check> {
    let finest = sweep.steps().last().unwrap_or(HORIZON);
    let runs = sweep.runs.iter().filter(|run| run.h == finest);
    runs.map(|run| {
        let galerkin = run.problem == GALERKIN || is_galerkin(run.method);
        let (name, floor) = if galerkin { ("Galerkin", floors.galerkin) } else { ("averaged", floors.averaged) };
        // The largest error over grid points misses the maximum by at most ½h times the slope, which is below 2.
        let slack = drift(run.method, finest) + finest + Floors::SAMPLING;
        let error = run.largest.as_ref().map_or(f64::NAN, |largest| largest.error);
        Check::within(
            format!("floor-{}-{}", run.problem, run.method),
            format!("{} ends at the floor of the {name} equation", run.method),
            error,
            [floor - slack, floor + slack],
            format!("Largest error at h = {finest}; the width is the method's own error and the grid's."),
        )
    })
    .collect()
}

/// Distances max_t |v(t) − u(0, t)| that no time step can reduce.
struct Floors {
    galerkin: f64,
    averaged: f64,
    slowest: f64,
    best: f64,
    best_rate: f64,
    projection: f64,
}

impl Floors {
    /// The maximum over 20000 points misses at most ⅛ v″ δt² with δt < 1.5e-4 where the maxima lie, and v″ < 10.
    const SAMPLING: f64 = 1e-7;

    fn compute() -> Result<Self, StudyError> {
        let flow = sampled(20_000, |t| Ok(velocity(GAMMA, 0.0, t)?))?;
        let of_rate = |rate: f64| max_norm(&flow.iter().map(|(t, u)| -(-rate * t).exp_m1() - u).collect::<Vec<_>>());
        // The distance as a function of the rate has one minimum between the two: too slow early, too fast late.
        let best_rate = minimum([1.5, AVERAGED_RATE], 0.0, of_rate);
        let rule = Quadrature::gauss(40)?;
        let projected = sampled(1000, |t| {
            // v = (15/8) ∫₀¹ u (1 − y²) dy makes ∫(u − v(1 − y²))² dy least.
            let mut v = 0.0;
            for (y, b) in rule.nodes().iter().zip(rule.weights()) {
                v += 1.875 * b * velocity(GAMMA, *y, t)? * (1.0 - y * y);
            }
            Ok((v - velocity(GAMMA, 0.0, t)?).abs())
        })?;
        Ok(Self {
            galerkin: of_rate(GALERKIN_RATE),
            averaged: of_rate(AVERAGED_RATE),
            slowest: of_rate(SLOWEST_DECAY_RATE),
            best: of_rate(best_rate),
            best_rate,
            projection: max_norm(&projected.into_iter().map(|(_, d)| d).collect::<Vec<_>>()),
        })
    }

    fn rows(&self) -> [(&'static str, f64, Option<f64>); 5] {
        [
            ("averaged equation (41)", self.averaged, Some(AVERAGED_RATE)),
            ("Galerkin equation", self.galerkin, Some(GALERKIN_RATE)),
            ("slowest rate of the flow", self.slowest, Some(SLOWEST_DECAY_RATE)),
            ("best constant rate", self.best, Some(self.best_rate)),
            ("least-squares fit of the profile", self.projection, None),
        ]
    }

    fn table(&self) -> Table {
        let rows = self.rows().map(|(name, floor, rate)| {
            vec![Cell::Text(name.into()), rate.map_or(Cell::Empty, Cell::Number), Cell::Number(floor)]
        });
        Table {
            id: "poiseuille-floors".into(),
            caption:
                "Largest distance of v(t) from the centre velocity of the flow, for several v(t) in the ansatz (35)."
                    .into(),
            columns: ["v", "rate", "max_error"].map(Into::into).to_vec(),
            rows: rows.to_vec(),
            shown: true,
        }
    }

    fn checks(&self) -> [Check; 4] {
        [
            Check::within(
                "floors",
                "the floor of the Galerkin equation is 0.28 times that of the averaged one: the quarter of the paper",
                self.galerkin / self.averaged,
                [0.275, 0.285],
                "Ratio of the distances of the two solutions from the flow; no method takes part in it.",
            ),
            Check::at_most(
                "floor-is-not-least",
                "the floor is not as close as the ansatz can get: another constant rate more than halves it",
                self.best / self.galerkin,
                0.5,
                format!("v = 1 − e^{{−ct}} with the best c = {:.4} over that with the Galerkin 5/2.", self.best_rate),
            ),
            Check::at_most(
                "profile-fit",
                "the parabola fitted to the profile of the flow by least squares is also closer at the centre",
                self.projection / self.galerkin,
                1.0,
                "Ratio of the largest errors at the centre.",
            ),
            Check::at_most(
                "slowest-rate",
                "so is the relaxation with the slowest rate of the flow, π²/4",
                self.slowest / self.galerkin,
                1.0,
                "Ratio of the largest errors at the centre.",
            ),
        ]
    }
}

/// A function of time at points of (0, 10] that crowd towards 0.
fn sampled(count: u32, f: impl Fn(f64) -> Result<f64, StudyError>) -> Result<Vec<(f64, f64)>, StudyError> {
    let at = |k: u32| {
        let t = HORIZON * (f64::from(k) / f64::from(count)).powi(2);
        Ok((t, f(t)?))
    };
    (1..=count).map(at).collect()
}
