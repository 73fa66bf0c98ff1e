//! Numbers of the sentences about flows are recomputed from the tables that stand beside them.

use libtest_mimic::Failed;
use lsvi::{SolveError, StepError};
use verify::chapter;
use verify::evidence::number::{about, between, brief, rounded_up, short};
use verify::evidence::{Cell, Evidence, Outcome, Table};
use verify::measure::norm::{Extremes, max_norm};
use verify::run::{RunError, run};
use verify::{method, problem};

use super::CONTEXT;
use super::answers::{consists, table};

const OURS: [&str; 2] = ["method-i", "velocity"];
const FLOWS: [&str; 2] = ["shear-layer", "turbulence-2d"];

pub(super) fn rest_on_their_tables() -> Result<(), Failed> {
    let study = chapter::ALL.iter().find(|study| study.id == "flows").expect("a chapter");
    let evidence = &(study.run)(&CONTEXT).map_err(|error| error.to_string())?;
    all([
        summary(evidence),
        identities(evidence),
        orders(evidence),
        space_time(evidence),
        swings(evidence),
        step_costs(evidence),
        captions(evidence),
        steady(evidence),
        work(evidence),
        periodic(evidence),
        conservation(evidence),
        lid(evidence),
        disturbances(evidence),
        approach(evidence),
        too_long(evidence),
        cvode(evidence),
    ])
}

/// What fails of several, together.
fn all(found: impl IntoIterator<Item = Result<(), Failed>>) -> Result<(), Failed> {
    let failures: Vec<String> =
        found.into_iter().filter_map(|found| Some(found.err()?.message()?.to_owned())).collect();
    if failures.is_empty() { Ok(()) } else { Err(failures.join("\n\n").into()) }
}

/// The paragraph that begins like that.
fn paragraph(evidence: &Evidence, beginning: &str) -> Result<String, Failed> {
    let sections = evidence.sections.iter().flat_map(|section| section.paragraphs.iter().map(|(_, text)| text));
    let found = evidence.notes.iter().chain(sections).find(|text| text.starts_with(beginning));
    found.cloned().ok_or_else(|| format!("no paragraph begins “{beginning}”").into())
}

/// A cell of the only row that has these values in these columns; not a number where it has none.
fn value(table: &Table, known: &[(&str, Cell)], column: &str) -> f64 {
    let place = |name: &str| table.column(name).expect("a column");
    let is_it = |row: &&Vec<Cell>| known.iter().all(|(name, cell)| row[place(name)] == *cell);
    let rows: Vec<_> = table.rows.iter().filter(is_it).collect();
    assert_eq!(rows.len(), 1, "{known:?}");
    rows[0][place(column)].number().unwrap_or(f64::NAN)
}

fn text(text: &str) -> Cell {
    Cell::Text(text.into())
}

/// Errors against evaluations, line by line through their logarithms.
fn at(runs: &[(f64, f64)], work: f64) -> f64 {
    let pair = runs.windows(2).find(|pair| pair[0].0 <= work && work <= pair[1].0).expect("between two runs");
    let part = (work / pair[0].0).ln() / (pair[1].0 / pair[0].0).ln();
    pair[0].1.powf(1.0 - part) * pair[1].1.powf(part)
}

const MANUFACTURED: &str = "cavity-manufactured";
const STARTED: &str = "cavity";

/// Two columns of the runs of a method in a cavity that have an error, the longest steps first.
fn runs(evidence: &Evidence, flow: &str, method: &str, columns: [&str; 2]) -> Vec<(f64, f64)> {
    let data = table(evidence, "flow-precision");
    let place = |name: &str| data.column(name).expect("a column");
    let of = data.rows.iter().filter(|row| row[place("flow")] == text(flow) && row[place("method")] == text(method));
    let number = |row: &[Cell], name: &str| row[place(name)].number();
    of.filter_map(|row| number(row, "error").and(Some((number(row, columns[0])?, number(row, columns[1])?)))).collect()
}

/// The error of Method I with 16 steps.
fn asked(evidence: &Evidence, flow: &str) -> f64 {
    runs(evidence, flow, "method-i", ["h", "error"])[2].1
}

/// The least and the most CPU seconds for that error; those of the longest steps that hold where these are more accurate, and not a number
/// where none holds.
fn seconds(evidence: &Evidence, flow: &str, method: &str) -> [f64; 2] {
    ["least_seconds", "most_seconds"].map(|column| {
        let mut known = runs(evidence, flow, method, ["error", column]);
        known.reverse();
        match known.last() {
            None => f64::NAN,
            Some((error, seconds)) if *error <= asked(evidence, flow) => *seconds,
            Some(_) => at(&known, asked(evidence, flow)),
        }
    })
}

/// What was timed once has one digit, and two where it was repeated.
fn told([least, most]: [f64; 2]) -> String {
    if least == most { about(least, most) } else { between(least, most) }
}

/// One over another, with two digits if both were repeated.
fn over([least, most]: [f64; 2], other: [f64; 2]) -> String {
    let is_repeated = least != most && other[0] != other[1];
    let in_words = if is_repeated { between } else { about };
    in_words(least / other[1], most / other[0])
}

/// The error of the longest steps that hold, if it is below that which is asked for.
fn held(evidence: &Evidence, flow: &str, method: &str) -> Option<f64> {
    let (_, error) = *runs(evidence, flow, method, ["h", "error"]).first()?;
    (error < asked(evidence, flow)).then_some(error)
}

/// A number of the table of costs.
fn cost(evidence: &Evidence, flow: &str, method: &str, column: &str) -> f64 {
    value(table(evidence, "flow-cost-per-error"), &[("flow", text(flow)), ("method", text(method))], column)
}

/// Root mean square and largest of the velocities at the end, from another run.
fn size_and_speed() -> Result<[f64; 2], Failed> {
    let problem = problem::build_setting("cavity-manufactured re=1000 cells=16").map_err(|error| error.to_string())?;
    let rk4 = method::parse("rk4").map_err(|error| error.to_string())?;
    let run = run(&*problem, &*rk4, 1.0 / 256.0, 1.0, |_| {}).map_err(|error| error.to_string())?;
    let velocities = problem.observe(1.0, &run.end.q);
    let squares: f64 = velocities.iter().map(|u| u * u).sum();
    Ok([(squares / velocities.len() as f64).sqrt(), max_norm(&velocities)])
}

fn work(evidence: &Evidence) -> Result<(), Failed> {
    for flow in [MANUFACTURED, STARTED] {
        let last = |method: &str| runs(evidence, flow, method, ["h", "error"]).last().map_or(f64::NAN, |run| run.1);
        for method in ["method-i", "method-ii", "trapezoidal", "tr-bdf2", "bdf2", "rk4", "pressure-correction"] {
            let found = ["error", "over_method_i", "least_for_equal_error", "most_for_equal_error"]
                .map(|column| cost(evidence, flow, method, column));
            let [least, most] = seconds(evidence, flow, method);
            let expected = [last(method), last(method) / last("method-i"), least, most];
            // Neither is a number where no run arrives.
            let is_it = |(a, b): (f64, f64)| (a / b - 1.0).abs() <= 1e-12 || a.is_nan() && b.is_nan();
            if !found.into_iter().zip(expected).all(is_it) {
                return Err(format!("{flow}, {method}: {found:?} instead of {expected:?}").into());
            }
        }
    }
    let of = |method: &str, column: &str| cost(evidence, MANUFACTURED, method, column);
    let error = |method: &str| short(of(method, "error"));
    let systems = ["method-i", "trapezoidal", "tr-bdf2"].map(|method| of(method, "solves"));
    let equal = systems.into_iter().smallest();
    let fewest = ["Method I", "the trapezoidal rule", "TR-BDF2"].into_iter().zip(systems).find(|(_, n)| *n == equal);
    let (fewest, _) = fewest.ok_or("no such run")?;
    let with = |method: &str| at(&runs(evidence, MANUFACTURED, method, ["solves", "error"]), equal);
    let over = |method: &str| brief(with("method-i") / with(method));
    let (longest, large) = runs(evidence, MANUFACTURED, "pressure-correction", ["h", "error"])[0];
    let [size, speed] = size_and_speed()?;
    let words = consists(
        &paragraph(evidence, "In the manufactured cavity at Re = 1000")?,
        &[
            "at Re = 1000 on 16 cells a side, with 64 steps to the end".into(),
            format!("is {} for Method I in {} linear systems", error("method-i"), of("method-i", "solves")),
            format!("{} for TR-BDF2 in {}", error("tr-bdf2"), of("tr-bdf2", "solves")),
            format!(
                "for pressure correction {} in {} separable ones",
                error("pressure-correction"),
                of("pressure-correction", "solves")
            ),
            format!(
                "With as many linear systems as the finest run of {fewest} takes, {}, and errors read log-log between the other runs, the error \
                 of Method I is {} times that of TR-BDF2 and {} times that of the trapezoidal rule.",
                short(equal),
                over("tr-bdf2"),
                over("trapezoidal")
            ),
            format!("below the size of the flow, {}, with steps up to h = {}", brief(size), short(longest)),
            format!(
                "a Courant number of {}; there the error is {} times",
                brief(16.0 * longest * speed),
                brief(large / size)
            ),
        ],
    );
    let times = |flow: &str| {
        let [own, second, rule, tr_bdf2, bdf2, rk4, projection] =
            ["method-i", "method-ii", "trapezoidal", "tr-bdf2", "bdf2", "rk4", "pressure-correction"].map(|method| {
                match (seconds(evidence, flow, method), held(evidence, flow, method)) {
                    ([least, _], _) if least.is_nan() => "has no run".into(),
                    (seconds, None) => format!("{} s", told(seconds)),
                    (seconds, Some(error)) => {
                        let steps = format!("with its longest steps that hold, whose error is {}", brief(error));
                        format!("{} s ({steps})", told(seconds))
                    }
                }
            });
        format!(
            "Method I {own}, Method II {second}, the trapezoidal rule {rule}, TR-BDF2 {tr_bdf2}, BDF2 {bdf2}, RK4 {rk4} and pressure \
             correction {projection}."
        )
    };
    let times = consists(
        &paragraph(evidence, "In CPU time a system counts")?,
        &[
            format!(
                "CPU time for an error of {}, that of Method I with 16 steps",
                short(asked(evidence, MANUFACTURED))
            ),
            times(MANUFACTURED),
            "at Re = 100 on 20 cells a side up to t = 2".into(),
            format!("For an error of {} after", short(asked(evidence, STARTED))),
            times(STARTED),
        ],
    );
    all([words, times])
}

fn periodic(evidence: &Evidence) -> Result<(), Failed> {
    let data = table(evidence, "flow-periodic");
    let of = |flow: &str, [method, metric]: [&str; 2], h: f64, column: &str| {
        let known = [
            ("flow", text(flow)),
            ("t", Cell::Number(1.0)),
            ("points", Cell::from(32_usize)),
            ("method", text(method)),
            ("metric", text(metric)),
            ("h", Cell::Number(h)),
        ];
        value(data, &known, column)
    };
    let steps = [0.05, 0.025, 0.0125];
    let finest = |flow: &str, case: [&str; 2], column: &str| of(flow, case, steps[2], column);
    let over = |flow: &str, a: [&str; 2], b: [&str; 2]| finest(flow, a, "error") / finest(flow, b, "error");
    let [rule, euler, trapezoidal] = ["tr-bdf2", "implicit-euler", "trapezoidal"].map(|method| [method, "velocity"]);
    let [shear, turbulence] = FLOWS;
    let ratios = FLOWS.map(|flow| over(flow, OURS, rule));
    let word = match ratios.map(|ratio| ratio > 1.0) {
        [true, true] => "loses to",
        [false, false] => "beats",
        _ => "is now ahead of and now behind",
    };
    let errors = consists(
        &paragraph(evidence, "On smooth periodic flows")?,
        &[
            format!("on 32² points at Re = 200 up to t = 1, Method I {word} TR-BDF2: at h = 0.0125 its error"),
            format!("is {} times as large on shear layers", short(ratios[0])),
            format!("and {} times on decaying turbulence", short(ratios[1])),
            format!("There it is {} times that of the trapezoidal rule", short(over(turbulence, OURS, trapezoidal))),
            format!("implicit Euler has {} times its error", short(over(turbulence, euler, OURS))),
        ],
    );
    let runs =
        |flow: &str, case: [&str; 2]| steps.map(|h| (of(flow, case, h, "evaluations"), of(flow, case, h, "error")));
    let equal_work = |flow: &str| {
        let [own, other] = [OURS, rule].map(|case| runs(flow, case));
        let work = own[2].0.min(other[2].0);
        brief(at(&own, work) / at(&other, work))
    };
    let own = runs(shear, OURS)[2];
    let explicit = runs(shear, ["rk4", "velocity"]);
    let cheapest = explicit.into_iter().find(|run| run.1 < own.1).ok_or("RK4 is nowhere ahead")?;
    let stops: Result<Vec<String>, Failed> = [0.1, 0.01, 0.001]
        .map(|h| {
            let flow = problem::build_setting("shear-layer cells=32").map_err(|error| error.to_string())?;
            let method = method::parse("method-ii").map_err(|error| error.to_string())?;
            match run(&*flow, &*method, h, h, |_| {}) {
                Err(RunError::Step(StepError::Solve { source: SolveError::Linear { residual, .. }, .. })) => {
                    Ok(brief(residual))
                }
                other => Err(format!("not stopped by the linear solver: {other:?}").into()),
            }
        })
        .into_iter()
        .collect();
    for name in ["ls-galerkin(2,radau,2)", "fitted(4)", "window(4)", "radau-adaptive"] {
        let flow = problem::build_setting("taylor-green cells=8").map_err(|error| error.to_string())?;
        if method::parse(name).map_err(|error| error.to_string())?.build(&*flow).is_ok() {
            return Err(format!("{name} has a matrix").into());
        }
    }
    let evaluations = consists(
        &paragraph(evidence, "On 32² points at equal numbers of evaluations")?,
        &[
            "On 32² points".into(),
            format!("is {} times that of TR-BDF2 on the shear layers", equal_work(shear)),
            format!("and {} times on turbulence", equal_work(turbulence)),
            format!("a run of {} evaluations has an error of {}, where", cheapest.0, brief(cheapest.1)),
            format!("takes {} for {}.", own.0, brief(own.1)),
            format!(
                "with steps of 0.1, 0.01, 0.001 its linear solver stops at a relative residual of {},",
                stops?.join(", ")
            ),
            "on the shear layers of 32² points:".into(),
        ],
    );
    let other = ["method-i", "vorticity"];
    let enstrophies = |flow: &str| {
        let changes = [OURS, other].map(|case| {
            let signs = steps.map(|h| of(flow, case, h, "enstrophy") > 0.0);
            signs != [signs[0]; 3]
        });
        let place = match changes {
            [false, false] => {
                let [own, other] = [OURS, other].map(|case| brief(finest(flow, case, "enstrophy")));
                return format!("its error is {other} instead of {own}");
            }
            [true, false] => "in the velocity metric",
            [false, true] => "in that of the vorticity",
            [true, true] => "in both metrics",
        };
        format!("the two cannot be compared, as with h the error passes zero {place}")
    };
    let metric = consists(
        &paragraph(evidence, "The metric is part of the method.")?,
        &[
            format!(
                "makes the error at h = 0.0125 {} times that of the velocity metric",
                short(over(shear, other, OURS))
            ),
            format!("on the shear layers and {} times on turbulence.", short(over(turbulence, other, OURS))),
            format!("As for the enstrophy, on the shear layers {}, and on", enstrophies(shear)),
            format!("turbulence {}.", enstrophies(turbulence)),
        ],
    );
    let [[e0, z0], [e1, z1]] =
        FLOWS.map(|flow| ["energy_balance", "enstrophy_balance"].map(|of| short(finest(flow, OURS, of).abs())));
    let balance = consists(
        &paragraph(evidence, "Convection neither makes nor takes")?,
        &[
            format!(
                "of h = 0.0125 Method I leaves {e0} of the energy of the shear layers unaccounted for, and {z0} of"
            ),
            format!("of turbulence {e1} and {z1}."),
        ],
    );
    all([errors, evaluations, metric, balance])
}

/// Largest of a column; of its numbers, where it has them.
fn largest(table: &Table, column: &str) -> f64 {
    let place = table.column(column).expect("a column");
    table.rows.iter().filter_map(|row| row[place].number()).largest()
}

fn identities(evidence: &Evidence) -> Result<(), Failed> {
    let data = table(evidence, "flow-identities");
    let [adjoint, jacobian, work] =
        ["adjoint", "jacobian", "work"].map(|column| short(rounded_up(largest(data, column), 4)));
    consists(
        &paragraph(evidence, "Between walls the unknowns are values")?,
        &[
            format!("Jᵀ is the adjoint of J within {adjoint}, J the derivative of f within {jacobian}, and"),
            format!("convection does no work within {work}, relative"),
        ],
    )
}

fn orders(evidence: &Evidence) -> Result<(), Failed> {
    const CAVITY: &str = "cavity-manufactured cells=6";
    let data = table(evidence, "flow-orders");
    let of = |method: &str, column: &str| value(data, &[("flow", text(CAVITY)), ("method", text(method))], column);
    // Of the table, those within a twentieth of an order that the name of the method tells.
    let place = |name: &str| data.column(name).expect("a column");
    let kept = data.rows.iter().filter(|row| {
        let nominal = match row[place("method")].to_string().as_str() {
            "implicit-euler" => 1.0,
            "ls-galerkin(2,radau,2)" => 3.0,
            "rk4" => 4.0,
            _ => 2.0,
        };
        row[place("order")].number().is_some_and(|order| (order - nominal).abs() <= 0.05)
    });
    for row in &data.rows {
        let [second, third, order] =
            ["h_1_256", "h_1_512", "order"].map(|c| row[place(c)].number().unwrap_or(f64::NAN));
        if ((second / third).log2() - order).abs().partial_cmp(&1e-12) != Some(std::cmp::Ordering::Less) {
            return Err(format!("not the order of its row: {row:?}").into());
        }
    }
    // From runs of their own.
    let known = |error: &dyn std::fmt::Display| Failed::from(error.to_string());
    let problem = problem::build_setting(CAVITY).map_err(|error| known(&error))?;
    for name in ["method-i", "tr-bdf2"] {
        let method = method::parse(name).map_err(|error| known(&error))?;
        let end = |steps: f64| {
            let run = run(&*problem, &*method, 0.25 / steps, 0.25, |_| {}).map_err(|error| known(&error))?;
            Ok::<_, Failed>((problem.observe(0.25, &run.end.q), run.work.factorizations as f64))
        };
        let ((coarse, _), (fine, solves)) = (end(128.0)?, end(256.0)?);
        let squares: f64 = coarse.iter().zip(&fine).map(|(a, b)| (a - b).powi(2)).sum();
        let difference = (squares / fine.len() as f64).sqrt();
        if (difference / of(name, "h_1_512") - 1.0).abs() > 1e-12 || solves != of(name, "solves") {
            return Err(format!("{name}: {difference} in {solves} systems").into());
        }
    }
    let galerkin = "ls-galerkin(2,radau,2)";
    let difference = |method: &str| short(of(method, "h_1_512"));
    consists(
        &paragraph(evidence, "Of 38 runs")?,
        &[
            "Of 38 runs of a method".into(),
            format!("each on a fixed grid, {} have the order", kept.count()),
            "cavity of 6 cells a side the runs with 128 and 256 steps differ by".into(),
            format!("{} for Method I, {} for Method II,", difference("method-i"), difference("method-ii")),
            format!(
                "{} for the least-squares Galerkin integrator of third order, {} for TR-BDF2 and {} for pressure",
                difference(galerkin),
                difference("tr-bdf2"),
                difference("pressure-correction")
            ),
            format!(
                "With 256 steps Method I solves {} linear systems, TR-BDF2 {}, and pressure correction {} that",
                of("method-i", "solves"),
                of("tr-bdf2", "solves"),
                of("pressure-correction", "solves")
            ),
        ],
    )
}

fn space_time(evidence: &Evidence) -> Result<(), Failed> {
    let data = table(evidence, "flow-space-time");
    let of =
        |flow: &str, method: &str, column: &str| value(data, &[("flow", text(flow)), ("method", text(method))], column);
    let orders = |flow: &str| {
        let [middle, fine] = ["middle", "fine"].map(|column| of(flow, "implicit-euler", column));
        (middle / fine).log2()
    };
    let over = |flow: &str| short(of(flow, "method-i", "fine") / of(flow, "tr-bdf2", "fine"));
    let last = orders("kovasznay");
    // Of errors over Δx², which change by at most 1/√2 of what they changed before.
    let over_square = |column: &str, n: f64| n * n * of("kovasznay", "implicit-euler", column);
    let (a, b, c) = (over_square("coarse", 12.0), over_square("middle", 24.0), over_square("fine", 48.0));
    let changes = [(b - a).abs() * 0.5_f64.sqrt(), (c - b).abs()];
    let verdict = match changes[1] <= changes[0] && changes[0] <= 0.25 * c {
        true => "which would pass for second order",
        false => "which would not pass for second order",
    };
    let euler = of("kovasznay", "implicit-euler", "fine") / of("kovasznay", "method-i", "fine");
    consists(
        &paragraph(evidence, "In h and Δx together")?,
        &[
            "on 12, 24 and 48 cells across".into(),
            format!("an order of {} too, {verdict}, with {} times Method I's error;", short(last), short(euler)),
            format!("on the manufactured cavity it has {} and", short(orders("cavity-manufactured"))),
            format!("the channel {}.", short(orders("channel-2d"))),
            format!(
                "Method I's are {} times TR-BDF2's in the manufactured cavity, {} times on Kovasznay's flow and {} times in the channel;",
                over("cavity-manufactured"),
                over("kovasznay"),
                over("channel-2d")
            ),
        ],
    )
}

/// Next to the lid the velocity by the trapezoidal and the midpoint rule is far above the reference, then below.
fn swings(evidence: &Evidence) -> Result<(), Failed> {
    let data = table(evidence, "flow-lid-profiles");
    let at = |method: &str, t: f64| value(data, &[("t", t.into()), ("method", text(method)), ("y", 0.975.into())], "u");
    for method in ["trapezoidal", "implicit-midpoint"] {
        let [first, later] = [0.5, 2.0].map(|t| at(method, t) - at("reference", t));
        if !(first > 0.2 && later < -0.03) {
            return Err(format!("{method}: {first}, then {later}").into());
        }
    }
    Ok(())
}

fn step_costs(evidence: &Evidence) -> Result<(), Failed> {
    let data = table(evidence, "flow-costs");
    // The step sizes of a flow tell its two series apart, of which one has a row of the other.
    let of = |flow: &str, cells: usize, h: f64, column: &str| {
        let place = |name: &str| data.column(name).expect("a column");
        let known = [text(flow), Cell::from(cells), Cell::Number(h)];
        let row = data.rows.iter().rfind(|row| ["flow", "cells", "h"].map(|name| row[place(name)].clone()) == known);
        row.map_or(f64::NAN, |row| row[place(column)].number().unwrap_or(f64::NAN))
    };
    let cavity = |cells: usize, column: &str| of("cavity re=1000", cells, 0.05, column);
    let each = |flow: &str, cells: usize, h: f64| 1e6 * of(flow, cells, h, "next") / (cells * cells) as f64;
    let [first, last] = [16, 64].map(|cells| each("cavity re=1000", cells, 0.05));
    let turbulence = "turbulence-2d re=1000";
    let inner = |cells| of(turbulence, cells, 0.01, "inner");
    let told = |value: f64| about(value, value);
    all([
        consists(
            &paragraph(evidence, "Between walls a cell costs more")?,
            &[
                format!("takes {} microseconds a cell on 16² cells and {} on 64².", told(first), told(last)),
                format!(
                    "factors that have {} and {} entries an unknown, {} times as many, in {} times as many iterations",
                    short(cavity(16, "fill")),
                    short(cavity(64, "fill")),
                    brief(cavity(64, "fill") / cavity(16, "fill")),
                    brief(cavity(64, "inner") / cavity(16, "inner"))
                ),
            ],
        ),
        consists(
            &paragraph(evidence, "On the periodic square nothing is factored.")?,
            &[
                "From the coarsest grid to 64² points".into(),
                format!(
                    "a step takes {} microseconds a point with one h, in {} to {} iterations of conjugate gradients, and {} with",
                    about(each(turbulence, 32, 0.01), each(turbulence, 64, 0.01)),
                    brief(inner(32)),
                    brief(inner(64)),
                    about(each(turbulence, 32, 0.02), each(turbulence, 64, 0.01))
                ),
            ],
        ),
    ])
}

/// Numbers in what is said under figures and tables, as the chapter sets them, and none beside them.
fn captions(evidence: &Evidence) -> Result<(), Failed> {
    let asked = |flow| short(asked(evidence, flow));
    let [size, _] = size_and_speed()?;
    let known: [(&str, &[String]); 15] = [
        ("flow-orders", &["t = 0.25, on".into(), "h = 1/1024".into(), galerkin_factors()?]),
        ("flow-space-time", &["t = 1 against".into(), "on 12, 24 and 48 cells across".into(), "h = 1/N".into()]),
        ("flow-convergence", &["t = 1 against".into(), "on 12, 24 and 48 cells across".into(), "h = 1/N".into()]),
        ("flow-cvode", &["of 16 cells a side, Re = 100, at t = 1, by".into()]),
        (
            "flow-cost-per-error",
            &[
                "of 64 steps: the manufactured cavity at Re = 1000 on 16 cells a side, t = 1, which".into(),
                "Re = 100 on 20 cells, t = 2. The".into(),
                format!("one of {} and of {}, which", asked(MANUFACTURED), asked(STARTED)),
                "has with 16 steps".into(),
            ],
        ),
        (
            "flow-precision",
            &[
                "with 4 to 64 steps".into(),
                format!("above that of the flow itself, {} and", brief(size)),
                started_size()?,
            ],
        ),
        ("flow-periodic", &["Re = 200".into(), "Ė = −2νZ and Ż = −2νP are".into()]),
        ("flow-periodic drawn", &["Re = 200".into()]),
        ("flow-periodic-work", &["Re = 200".into()]),
        ("flow-vorticity", &["Re = 200".into(), "which at t = 1 have".into()]),
        ("flow-conservation", &["ten steps of h = 0.1".into()]),
        ("flow-lid", &["of 20 cells a side, Re = 100, lid".into(), "RK4 with h = 1/128".into()]),
        ("flow-lid-profiles", &["steps of h = 0.5 from".into(), "next to the lid, at y = 1.".into()]),
        ("flow-start-up", &["Re = 100, by Method I with h = 0.25:".into()]),
        ("flow-disturbances", &["of 8 cells a side at Re = 100".into()]),
    ];
    let others: [(&str, &[String]); 5] = [
        ("flow-identities", &["vᵀf = 0 without".into()]),
        ("flow-steady-streamlines", &["where ψ > 0, in".into()]),
        ("flow-too-long drawn", &[]),
        (
            "flow-approach",
            &["of 12 cells a side, Re = 100, from rest until |f| ≤ 1e-8 in".into(), "up to 100 of".into()],
        ),
        ("flow-too-long", &["Re = 1000, by".into(), "below 1e-8;".into()]),
    ];
    let expected = |name: &str| known.iter().chain(&others).find(|(of, _)| *of == name).map(|(_, parts)| *parts);
    let tables = evidence.tables.iter().map(|table| (&table.caption, expected(&table.id)));
    // A figure has the caption of the table of its name, unless it is listed by itself.
    let drawn = |id: &str| expected(&format!("{id} drawn")).or_else(|| expected(id));
    let figures = evidence.figures.iter().map(|figure| (&figure.caption, drawn(&figure.id)));
    all(tables.chain(figures).map(|(caption, parts)| consists(caption, parts.unwrap_or(&[]))))
}

/// How often the Galerkin integrator factors a matrix, from another run.
fn galerkin_factors() -> Result<String, Failed> {
    let problem = problem::build_setting("cavity-manufactured cells=6").map_err(|error| error.to_string())?;
    let method = method::parse("ls-galerkin(2,radau,2)").map_err(|error| error.to_string())?;
    let run = run(&*problem, &*method, 1.0 / 1024.0, 0.25, |_| {}).map_err(|error| error.to_string())?;
    Ok(format!("it made {} of them", run.work.factorizations))
}

/// Root mean square of the velocities after the start of the lid, from another run.
fn started_size() -> Result<String, Failed> {
    let problem = problem::build_setting("cavity re=100 cells=20").map_err(|error| error.to_string())?;
    let rk4 = method::parse("rk4").map_err(|error| error.to_string())?;
    let run = run(&*problem, &*rk4, 1.0 / 128.0, 2.0, |_| {}).map_err(|error| error.to_string())?;
    let velocities = problem.observe(2.0, &run.end.q);
    let squares: f64 = velocities.iter().map(|u| u * u).sum();
    Ok(format!("{}, the run has", brief((squares / velocities.len() as f64).sqrt())))
}

fn conservation(evidence: &Evidence) -> Result<(), Failed> {
    let data = table(evidence, "flow-conservation");
    let energy = |method: &str, metric: &str| {
        short(value(data, &[("method", text(method)), ("metric", text(metric))], "energy"))
    };
    consists(
        &paragraph(evidence, "Without viscosity the energy")?,
        &[
            "on 32² points would stay as it is. Up to t = 1, steps of h = 0.1 change it".into(),
            format!("by {} with Method I", energy("method-i", "velocity")),
            format!("{} in the vorticity metric", energy("method-i", "vorticity")),
            format!("{} with the trapezoidal rule", energy("trapezoidal", "velocity")),
            format!("{} with TR-BDF2", energy("tr-bdf2", "velocity")),
            format!("{} with implicit Euler", energy("implicit-euler", "velocity")),
            format!("changes it by {}, what", energy("implicit-midpoint", "velocity")),
        ],
    )
}

fn lid(evidence: &Evidence) -> Result<(), Failed> {
    let data = table(evidence, "flow-lid");
    let error = |h: f64, t: f64, method: &str| {
        value(data, &[("h", Cell::Number(h)), ("t", Cell::Number(t)), ("method", text(method))], "error")
    };
    let own = |h, t| short(error(h, t, "method-i"));
    let ratio = |method, h, t| brief(error(h, t, method) / error(h, t, "method-i"));
    let (method, step) = (data.column("method").expect("a column"), data.column("h").expect("a column"));
    let time = data.column("t").expect("a column");
    let first = data.rows.iter().filter(|row| row[step] == Cell::Number(0.5) && row[time] == Cell::Number(0.5));
    let is_best = first
        .map(|row| row[method].to_string())
        .all(|name| name == "method-i" || error(0.5, 0.5, &name) > error(0.5, 0.5, "method-i"));
    let large = consists(
        &paragraph(evidence, "A lid that starts at once")?,
        &[
            "of 20 cells a side at Re = 100, after one step of h = 0.5".into(),
            format!(
                "Method I is {}, {}; TR-BDF2 has {} times that, implicit Euler {} times and",
                own(0.5, 0.5),
                if is_best { "the smallest of all" } else { "not the smallest" },
                ratio("tr-bdf2", 0.5, 0.5),
                ratio("implicit-euler", 0.5, 0.5)
            ),
            format!("which rings, {} times", ratio("trapezoidal", 0.5, 0.5)),
            format!(
                "At t = 2 Method I has {}, the trapezoidal rule {} times that, implicit Euler {} times, and TR-BDF2 {} times.",
                own(0.5, 2.0),
                ratio("trapezoidal", 0.5, 2.0),
                ratio("implicit-euler", 0.5, 2.0),
                ratio("tr-bdf2", 0.5, 2.0)
            ),
        ],
    );
    let cases = [(0.5, 0.5), (0.25, 0.5), (0.5, 2.0), (0.25, 2.0)];
    let ahead = cases.map(|(h, t)| error(h, t, "method-i") < error(h, t, "pressure-correction"));
    let word = match ahead.iter().filter(|ahead| **ahead).count() {
        4 => "beats",
        0 => "loses to",
        _ => "is now ahead of and now behind",
    };
    let later = format!(
        "at t = 2 Method I has {}, TR-BDF2 {} times that and the trapezoidal rule {} times",
        own(0.25, 2.0),
        ratio("tr-bdf2", 0.25, 2.0),
        ratio("trapezoidal", 0.25, 2.0)
    );
    let early = format!(
        "With h = 0.25 Method I has {} at t = 0.5, TR-BDF2 {} times that and the trapezoidal rule {} times",
        own(0.25, 0.5),
        ratio("tr-bdf2", 0.25, 0.5),
        ratio("trapezoidal", 0.25, 0.5)
    );
    let small = consists(
        &paragraph(evidence, "With h = 0.25 Method I has")?,
        &[
            early,
            later,
            format!("Method I {word} pressure correction"),
            "Courant numbers of 10 and 5, h over Δx".into(),
        ],
    );
    all([large, small])
}

fn disturbances(evidence: &Evidence) -> Result<(), Failed> {
    let data = table(evidence, "flow-disturbances");
    let of = |method: &str, h: f64, what: &str| value(data, &[("method", text(method)), ("h", Cell::Number(h))], what);
    let factor = |method: &str, h: f64| short(of(method, h, "factor"));
    // The eigenvalue is of the size of the factor.
    for row in &data.rows {
        let [factor, re, im] = ["factor", "real", "imaginary"]
            .map(|name| row[data.column(name).expect("a column")].number().unwrap_or(f64::NAN));
        if (re.hypot(im) - factor).abs().partial_cmp(&(1e-8 * factor)) != Some(std::cmp::Ordering::Less) {
            return Err(format!("{row:?}: an eigenvalue of size {}", re.hypot(im)).into());
        }
    }
    let sign = if of("trapezoidal", 100.0, "real") < 0.0 {
        "with its sign changed, so that it rings"
    } else {
        "with its sign"
    };
    consists(
        &paragraph(evidence, "What a step makes of a disturbance")?,
        &[
            "of 8 cells a side at Re = 100".into(),
            format!(
                "Of that a step of h = 1 keeps {} of the size with the trapezoidal rule and {} with Method I.",
                factor("trapezoidal", 1.0),
                factor("method-i", 1.0)
            ),
            format!(
                "A step of h = 100 keeps {} with the trapezoidal rule, {sign}; {} with Method I, {} with TR-BDF2 and {} with implicit Euler.",
                factor("trapezoidal", 100.0),
                factor("method-i", 100.0),
                factor("tr-bdf2", 100.0),
                factor("implicit-euler", 100.0)
            ),
        ],
    )
}

/// Linear systems from rest to the steady cavity; not a number where it is not reached.
fn to_steady(evidence: &Evidence, method: &str, h: f64, column: &str) -> f64 {
    let data = table(evidence, "flow-approach");
    let of = |column: &str| value(data, &[("method", text(method)), ("h", Cell::Number(h))], column);
    if of("residual") <= 1e-8 { of(column) } else { f64::NAN }
}

fn approach(evidence: &Evidence) -> Result<(), Failed> {
    let told = |method: &str, h: f64| match ["steps", "solves"].map(|column| to_steady(evidence, method, h, column)) {
        [1.0, solves] => format!("takes one step and {solves} linear systems"),
        [steps, solves] if steps.is_finite() => format!("takes {steps} steps and {solves} linear systems"),
        _ => "does not get there in 100 steps".into(),
    };
    let others = ["trapezoidal", "tr-bdf2", "bdf2", "implicit-euler"];
    let fewer = |steps: &[f64]| {
        others.map(|other| {
            steps.iter().all(|h| {
                let [own, other] = ["method-i", other].map(|method| to_steady(evidence, method, *h, "solves"));
                own < other || own.is_finite() && other.is_nan()
            })
        })
    };
    let such = |steps: &[f64], wanted: bool| -> Vec<&str> {
        others.iter().zip(fewer(steps)).filter(|(_, fewer)| *fewer == wanted).map(|(other, _)| *other).collect()
    };
    let list = |methods: Vec<&str>| match methods.split_last() {
        None => "none of them".to_owned(),
        Some((last, [])) => (*last).to_owned(),
        Some((last, first)) => format!("{} and {last}", first.join(", ")),
    };
    let seconds = |method: &str, h: f64| ["least_seconds", "most_seconds"].map(|c| to_steady(evidence, method, h, c));
    let times = |other: &str| over(seconds("method-i", 100.0), seconds(other, 100.0));
    consists(
        &paragraph(evidence, "Where only the steady flow matters")?,
        &[
            "From rest to the steady cavity at Re = 100 on 12 cells a side".into(),
            format!(
                "Method I with h = 10 {}; the trapezoidal rule {}, TR-BDF2 {}, BDF2 {}, implicit Euler {}.",
                told("method-i", 10.0),
                told("trapezoidal", 10.0),
                told("tr-bdf2", 10.0),
                told("bdf2", 10.0),
                told("implicit-euler", 10.0)
            ),
            format!(
                "With h = 100 Method I {}, TR-BDF2 {}, BDF2 {}, and implicit Euler {}.",
                told("method-i", 100.0),
                told("tr-bdf2", 100.0),
                told("bdf2", 100.0),
                told("implicit-euler", 100.0)
            ),
            format!(
                "Method I takes fewer linear systems than {}, and no fewer than {}.",
                list(such(&[10.0, 100.0], true)),
                list(such(&[10.0, 100.0], false))
            ),
            format!(
                "With h = 1 Method I {}, the trapezoidal rule {}, TR-BDF2 {}, BDF2 {}, and implicit Euler {}: there Method I takes fewer linear systems than {}, and no fewer than {}.",
                told("method-i", 1.0),
                told("trapezoidal", 1.0),
                told("tr-bdf2", 1.0),
                told("bdf2", 1.0),
                told("implicit-euler", 1.0),
                list(such(&[1.0], true)),
                list(such(&[1.0], false))
            ),
            format!(
                "its run with h = 100 takes {} times that of TR-BDF2, {} times that of BDF2 and {} times that of implicit Euler.",
                times("tr-bdf2"),
                times("bdf2"),
                times("implicit-euler")
            ),
            "Newton's method on `f = 0`, that is implicit Euler with h = 10⁸:".into(),
            format!("it {}, and Method I with h = 100", told("implicit-euler", 1e8)),
            format!("takes {} times its CPU time.", over(seconds("method-i", 100.0), seconds("implicit-euler", 1e8))),
        ],
    )
}

fn too_long(evidence: &Evidence) -> Result<(), Failed> {
    const CASES: [(usize, f64); 4] = [(16, 1000.0), (24, 1000.0), (32, 100.0), (32, 1000.0)];
    let data = table(evidence, "flow-too-long");
    let of = |method: &str, (cells, h): (usize, f64), column: &str| {
        value(data, &[("method", text(method)), ("cells", cells.into()), ("h", h.into())], column)
    };
    let is_steady = |method: &str, case| of(method, case, "residual") <= 1e-8;
    let list = |wanted: bool| {
        let such = CASES.iter().filter(|case| is_steady("method-i", **case) == wanted);
        such.map(|(cells, h)| format!("h = {h} on {cells}²")).collect::<Vec<_>>().join(", ")
    };
    let missed = ["implicit-euler", "tr-bdf2"].iter().flat_map(|m| CASES.map(|case| is_steady(m, case)));
    let others = match missed.filter(|steady| !steady).count() {
        0 => "all come to a steady flow.".to_owned(),
        missed => format!("come to a steady flow in all but {missed} of their runs."),
    };
    let last = CASES[3];
    let root = of("resting", last, "residual");
    let check = |id: &str| {
        evidence
            .checks
            .iter()
            .find(|check| check.id == id)
            .and_then(|check| check.measured)
            .map_or("unknown".into(), short)
    };
    all([
        consists(
            &paragraph(evidence, "Steps of Method I may be too long")?,
            &[
                format!(
                    "At Re = 1000 it comes from rest to the steady flow with {}, and does not with {}.",
                    list(true),
                    list(false)
                ),
                "With h = 1000 on 32 cells a side".into(),
                format!("ends with |f| = {}, and", short(of("method-i", last, "residual"))),
                format!("is there {} times that at rest", short(of("method-i", last, "gradient"))),
                others,
            ],
        ),
        consists(
            &paragraph(evidence, "Near that end there is a spurious steady state")?,
            &[
                format!("at which |f| = {};", short(root)),
                format!("of the equation is {} of its terms.", check("steady/resting")),
                "rate two over h, 0.002.".into(),
                format!("changes ψ by {} of its distance", check("steady/stays")),
                format!(
                    "max |ψ| = {}, that of the steady flow {}.",
                    short(of("resting", last, "vortex")),
                    short(of("method-i", CASES[2], "vortex"))
                ),
            ],
        ),
    ])
}

fn cvode(evidence: &Evidence) -> Result<(), Failed> {
    let data = table(evidence, "flow-cvode");
    let own = |steps: f64, column: &str| {
        value(data, &[("method", text("method-i")), ("h", Cell::Number(1.0 / steps))], column)
    };
    let reference =
        |column: &str| value(data, &[("method", text("cvode-bdf")), ("tolerance", Cell::Number(1e-12))], column);
    let [coarse, middle, fine] = [32.0, 64.0, 128.0].map(|steps| own(steps, "difference"));
    let excess = fine - own(128.0, "own_bound") - reference("own_bound");
    // b h³ by elimination of a h² from a (4h)² + b (4h)³ and a (2h)² + b (2h)³; what (e(2h) − e(h))/3 has of it is 7/3.
    let share = fine / (own(128.0, "own_bound") + reference("own_bound"));
    let verdict = match evidence.checks.iter().find(|check| check.id == "cvode").map(|check| check.outcome) {
        Some(Outcome::Pass) if excess > 0.0 => "passes by its allowance alone",
        Some(Outcome::Pass) => "passes and would without an allowance",
        _ => "fails",
    };
    let third = (coarse - 4.0 * middle) / (64.0 - 4.0 * 8.0);
    let place = |name: &str| data.column(name).expect("a column");
    let mut loose: Vec<&Vec<Cell>> = data.rows.iter().filter(|row| row[place("method")] == text("cvode-bdf")).collect();
    loose.retain(|row| row[place("difference")].number().is_some_and(|difference| difference <= fine));
    loose.sort_by(|a, b| {
        a[place("difference")].number().partial_cmp(&b[place("difference")].number()).expect("numbers")
    });
    let row = loose.last().ok_or("no loose solve is as good")?;
    let number = |name: &str| row[place(name)].number().unwrap_or(f64::NAN);
    let seconds = |of: &dyn Fn(&str) -> f64| ["least_seconds", "most_seconds"].map(of);
    let [cvode, best, ours] = [seconds(&number), seconds(&reference), seconds(&|column| own(128.0, column))];
    consists(
        &paragraph(evidence, "CVODE, with GMRES")?,
        &[
            format!("of 16 cells a side at Re = 100, differs at t = 1 from Method I with h = {}", short(1.0 / 128.0)),
            format!(
                "by {}. The error that Method I expects of itself, a third of what halving its steps changes, is {}, and the bound of \
                 CVODE is {}; the difference is {} times their sum, {} {} it.",
                short(fine),
                short(own(128.0, "own_bound")),
                short(reference("own_bound")),
                short(share),
                brief(excess.abs()),
                if excess > 0.0 { "above" } else { "below" }
            ),
            format!("The check of this {verdict}: it allows 1.25 times the sum, a quarter for"),
            format!(
                "the differences from CVODE fall by {} and {}, which shows a part of third order;",
                short(coarse / middle),
                short(middle / fine)
            ),
            format!("expects of itself leaves {} of it out.", brief(third - 7.0 / 3.0 * third)),
            format!(
                "Asked for a tolerance of 10⁻¹² CVODE takes {} steps, {} evaluations of f, {} products with the Jacobian and {} s",
                reference("steps"),
                reference("rhs"),
                reference("products"),
                told(best)
            ),
            format!("is {} times the bound of CVODE's", brief(own(128.0, "own_bound") / reference("own_bound"))),
            format!(
                "{} linear systems, {} products with B and Bᵀ and {} s.",
                own(128.0, "systems"),
                own(128.0, "products"),
                told(ours)
            ),
            format!(
                "a quarter of a decade apart, {} gives CVODE the error that is nearest to that of Method I from below, {} of it; with",
                brief(number("tolerance")),
                brief(number("difference") / fine)
            ),
            format!(
                "it takes {} steps, {} evaluations, {} products and {} s, and Method I {} times the CPU time.",
                number("steps"),
                number("rhs"),
                number("products"),
                told(cvode),
                over(ours, cvode)
            ),
        ],
    )
}

/// The largest difference of two columns of the steady velocities at Re = 100, where a source has any.
fn in_steady_cavity(evidence: &Evidence, source: &str, [a, b]: [&str; 2]) -> String {
    let profiles = table(evidence, "cavity-profiles");
    let place = |name: &str| profiles.column(name).expect("a column");
    let number = |row: &[Cell], name: &str| row[place(name)].number().unwrap_or(f64::NAN);
    let of = profiles.rows.iter().filter(|row| row[place("source")] == text(source) && number(row, "re") == 100.0);
    short(rounded_up(of.map(|row| (number(row, a) - number(row, b)).abs()).largest(), 4))
}

fn steady(evidence: &Evidence) -> Result<(), Failed> {
    let ghia = |columns| in_steady_cavity(evidence, "Ghia 1982", columns);
    let beside = consists(
        &paragraph(evidence, "On 64 cells a side the steady cavity")?,
        &[
            "On 64 cells a side".into(),
            format!("within {} of the velocities of Ghia et al. at Re = 100", ghia(["velocity", "published"])),
            format!("The error of the grid is {} at most,", ghia(["velocity", "extrapolated"])),
            format!("that of the table up to {},", ghia(["extrapolated", "published"])),
        ],
    );
    let marchi = in_steady_cavity(evidence, "Marchi 2009", ["extrapolated", "published"]);
    let held = evidence.checks.iter().find(|check| check.id == "steady/100/Marchi 2009").expect("a check");
    let allowed = held.required.and_then(|required| required.bounds().next());
    let allowed = short(allowed.unwrap_or(f64::NAN));
    let extrapolated = consists(
        &paragraph(evidence, "Extrapolated from 32 and 64 cells")?,
        &[
            "Extrapolated from 32 and 64 cells".into(),
            format!("lies within {marchi} of what Marchi et al. print at Re = 100;"),
            format!("up to {allowed} may be left of its error."),
        ],
    );
    all([beside, extrapolated])
}

fn summary(evidence: &Evidence) -> Result<(), Failed> {
    let orders: Vec<_> = evidence.checks.iter().filter(|check| check.id.starts_with("order/")).collect();
    let passed = orders.iter().filter(|check| check.outcome == Outcome::Pass).count();
    let in_cavity = 1.0 / cost(evidence, MANUFACTURED, "tr-bdf2", "over_method_i");
    let periodic = FLOWS.map(|flow| {
        let known = |method: &str| {
            let of =
                [("flow", text(flow)), ("method", text(method)), ("metric", text("velocity")), ("h", 0.0125.into())];
            value(table(evidence, "flow-periodic"), &of, "error")
        };
        known("method-i") / known("tr-bdf2")
    });
    let word = match [in_cavity, periodic[0], periodic[1]].map(|ratio| ratio > 1.0) {
        [true, true, true] => "loses to",
        [false, false, false] => "beats",
        _ => "is now ahead of and now behind",
    };
    let times = |flow: &str, own: &str, other: &str| over(seconds(evidence, flow, own), seconds(evidence, flow, other));
    let lid = |t: f64, other: &str| {
        let error = |method: &str| {
            let known = [("h", 0.5.into()), ("t", t.into()), ("method", text(method))];
            value(table(evidence, "flow-lid"), &known, "error")
        };
        brief(error("method-i") / error(other))
    };
    let projection = "pressure-correction";
    let solves = |method: &str| to_steady(evidence, method, 100.0, "solves");
    let ends = |method: &str| {
        let case = [("method", text(method)), ("cells", 32_usize.into()), ("h", 1000.0.into())];
        short(value(table(evidence, "flow-too-long"), &case, "residual"))
    };
    // Of runs that take no more CPU time than Method I with its longest steps, in one of three measurements.
    let at_equal_time = || {
        let data = table(evidence, "flow-precision");
        let place = |name: &str| data.column(name).expect("a column");
        let runs = |of: &str| -> Vec<[f64; 4]> {
            let such = |row: &&Vec<Cell>| row[place("flow")] == text(STARTED) && row[place("method")] == text(of);
            let number = |row: &Vec<Cell>, column: &str| row[place(column)].number().unwrap_or(f64::NAN);
            let runs = data.rows.iter().filter(such);
            runs.map(|row| ["h", "error", "least_seconds", "most_seconds"].map(|column| number(row, column))).collect()
        };
        let longest = |a: &[f64; 4], b: &[f64; 4]| if a[0] > b[0] { *a } else { *b };
        let [_, error, _, seconds] = runs("method-i").into_iter().reduce(|a, b| longest(&a, &b)).expect("runs");
        // All methods but Method I in the order of the table.
        let mut others: Vec<String> = Vec::new();
        for row in &data.rows {
            let other = row[place("method")].to_string();
            if other != "method-i" && !others.contains(&other) {
                others.push(other);
            }
        }
        let parts = others.iter().map(|method| {
            let errors = runs(method).into_iter().filter(|run| run[2] <= seconds).map(|run| run[1]);
            match errors.filter(|error| !error.is_nan()).min_by(f64::total_cmp) {
                Some(best) => format!("{} for `{method}`", brief(best / error)),
                None => format!("unknown for `{method}`, which has no run as cheap"),
            }
        });
        let parts: Vec<String> = parts.collect();
        let (last, first) = parts.split_last().expect("methods");
        format!("{} and {last}", first.join(", "))
    };
    let cvode = paragraph(evidence, "CVODE, with GMRES")?;
    let cvode = cvode
        .split("and Method I ")
        .last()
        .and_then(|rest| rest.split(" the CPU time").next())
        .unwrap_or("")
        .to_owned();
    let rk4_held = |flow: &str| {
        let told = |error| format!(", whose error is {} in the longest steps in which it is stable", brief(error));
        held(evidence, flow, "rk4").map_or_else(String::new, told)
    };
    let told = consists(
        &evidence.notes[0],
        &[
            format!("{passed} of {} measured orders in time", orders.len()),
            format!(
                "extrapolated from grids of up to 64² cells, lies within {} of Marchi et al. at Re = 100.",
                in_steady_cavity(evidence, "Marchi 2009", ["extrapolated", "published"])
            ),
            format!("On smooth flows Method I {word} TR-BDF2"),
            format!(
                "its error in time is {} times as large in the manufactured cavity at Re = 1000 on 16² cells, ",
                brief(in_cavity)
            ),
            format!(
                "{} times on shear layers and {} times on decaying turbulence.",
                brief(periodic[0]),
                brief(periodic[1])
            ),
            format!("it takes {} times the CPU time of TR-BDF2", times(MANUFACTURED, "method-i", "tr-bdf2")),
            format!("{} times that of the trapezoidal rule, ", times(MANUFACTURED, "method-i", "trapezoidal")),
            format!("{} times that of pressure correction, a projection", times(MANUFACTURED, "method-i", projection)),
            format!(
                "and {} times that of RK4{}. After",
                times(MANUFACTURED, "method-i", "rk4"),
                rk4_held(MANUFACTURED)
            ),
            format!(
                "the start of a lid at Re = 100 on 20² cells it takes {} times the CPU time of TR-BDF2",
                times(STARTED, "method-i", "tr-bdf2")
            ),
            format!(
                "{} times that of the trapezoidal rule, {} times that of pressure correction and {} times that of RK4{}.",
                times(STARTED, "method-i", "trapezoidal"),
                times(STARTED, "method-i", projection),
                times(STARTED, "method-i", "rk4"),
                rk4_held(STARTED)
            ),
            format!(
                "in each iteration, takes there {} times the CPU time of the trapezoidal rule.",
                times(STARTED, "method-ii", "trapezoidal")
            ),
            format!("In the cavity of 16² cells at Re = 100 Method I takes {cvode} the CPU time of CVODE"),
        ],
    );
    let large = consists(
        &evidence.notes[1],
        &[
            format!("one of h = 0.5 at the start of the lid leaves it {} times the error", lid(0.5, "tr-bdf2")),
            format!("and {} times that of pressure correction; at t = 2 it has", lid(0.5, projection)),
            format!("{} times and {} times theirs.", lid(2.0, "tr-bdf2"), lid(2.0, projection)),
            format!(
                "Among the runs of another method that take no more of it, as far as repeated measurements tell, the best has at t = 2 the following \
                 part of Method I's error: {}.",
                at_equal_time()
            ),
            format!(
                "From rest to the steady cavity at Re = 100 on 12² cells with h = 100 Method I takes {} linear systems, TR-BDF2 {}, BDF2 {} and implicit Euler {}; those of Method I cost two solves with LU factors per iteration, the others one.",
                solves("method-i"),
                solves("tr-bdf2"),
                solves("bdf2"),
                solves("implicit-euler")
            ),
            format!(
                "In a step with h = 1000, too long for the cavity at Re = 1000 on 32² cells, the iteration of Method I stalls at |f| = {}",
                ends("method-i")
            ),
            format!("a spurious steady state with |f| = {}, which", ends("resting")),
        ],
    );
    let finer = consists(
        &evidence.notes[2],
        &[
            "beyond Re = 100: with Richardson extrapolation against Marchi et al. at Re = 400 and".into(),
            "Botella and Peyret at Re = 1000, and beside Ghia et al. at Re = 400 and 1000 on 128² cells; and".into(),
            "up to 512² points.".into(),
        ],
    );
    all([told, large, finer])
}
