//! Every number of the answers is recomputed from the tables that stand beside them.

use libtest_mimic::Failed;
use nalgebra::Complex;
use verify::chapter;
use verify::evidence::number::{between, brief, digits, rounded_down, rounded_up};
use verify::evidence::{Cell, Evidence, Outcome, Table};
use verify::experiment::course::Course;
use verify::experiment::end_errors::{EndErrors, Truth};
use verify::experiment::kepler_period::KeplerPeriod;
use verify::experiment::symplectic_defect::Defects;
use verify::measure::amplification::Amplification;
use verify::measure::norm::{Extremes, larger};
use verify::{method, problem, reference};

use super::CONTEXT;
use super::curves::points;

const RADAU: &str = "ls-galerkin(2,radau,2)";
const GAUSS: &str = "ls-galerkin(2,gauss,2)";
/// What the pictures on channels compare.
const CHANNEL: [&str; 5] = ["method-i", "trapezoidal", "tr-bdf2", "sdirk2", RADAU];
const FITTED: [&str; 3] = ["path-fitted(4)", "path-fitted(4,gauss)", "galerkin-gauss(3)"];

/// The texts of the answer `id`: the caption of its picture, then its paragraphs, in one.
fn told(evidence: &Evidence, id: &str) -> String {
    let section = evidence.sections.iter().find(|section| section.id == id).expect("an answer");
    let captions = evidence.figures.iter().filter(|figure| section.figures.contains(&figure.id));
    let paragraphs = section.paragraphs.iter().map(|(label, text)| format!("{label}: {text}"));
    captions.map(|figure| figure.caption.clone()).chain(paragraphs).collect::<Vec<_>>().join("\n")
}

/// That a text has each of these parts, and no number beside them. Names in backticks and numbers of equations, as in (16), may
/// have digits.
pub(super) fn consists(text: &str, parts: &[String]) -> Result<(), Failed> {
    let mut rest = text.to_owned();
    for part in parts {
        if !rest.contains(part.as_str()) {
            return Err(format!("it does not say “{part}”:\n{text}").into());
        }
        rest = rest.replacen(part.as_str(), " ", 1);
    }
    let plain: String = rest.split('`').step_by(2).collect::<Vec<_>>().join(" ");
    let begins_with_digit =
        |word: &&str| word.trim_start_matches(|c: char| !c.is_alphanumeric()).starts_with(|c: char| c.is_ascii_digit());
    let is_equation = |word: &str| {
        let digits =
            word.strip_prefix('(').and_then(|rest| rest.trim_end_matches(['.', ',', ';', ':']).strip_suffix(')'));
        digits.is_some_and(|digits| digits.len() <= 2 && digits.chars().all(|c| c.is_ascii_digit()))
    };
    match plain.split_whitespace().find(|word| begins_with_digit(word) && !is_equation(word)) {
        Some(number) => Err(format!("nothing is known of the number {number} in:\n{text}").into()),
        None => Ok(()),
    }
}

pub(super) fn table<'a>(evidence: &'a Evidence, id: &str) -> &'a Table {
    evidence.tables.iter().find(|table| table.id == id).expect("a table")
}

/// The name with the smallest number.
fn least<'a>(names: &[&'a str], of: impl Fn(&str) -> f64) -> &'a str {
    names.iter().copied().min_by(|a, b| of(a).total_cmp(&of(b))).expect("one at least")
}

fn extremes(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let values: Vec<f64> = values.collect();
    [values.iter().copied().smallest(), values.iter().copied().largest()]
}

pub(super) fn rest_on_their_tables() -> Result<(), Failed> {
    let study = chapter::ALL.iter().find(|study| study.id == "answers").expect("the first chapter");
    let evidence = &(study.run)(&CONTEXT).map_err(|error| error.to_string())?;
    let marks: Vec<_> = evidence.sections.iter().map(|section| (section.id.as_str(), section.mark.as_str())).collect();
    let smooth = smooth(evidence)?;
    let expected = [
        ("answer-methods", ""),
        ("answer-parabolic", "no, but for one step across a jump"),
        ("answer-ringing", "no"),
        ("answer-path-fitted", "not as published (equispaced nodes); with Gauss nodes, yes"),
        ("answer-smooth", &smooth),
        ("answer-trust", "as far as the checks go that are told here"),
    ];
    if marks != expected || evidence.checks.iter().any(|check| check.outcome != Outcome::Pass) {
        return Err(format!("{marks:?}").into());
    }
    parabolic(evidence)?;
    ringing(evidence)?;
    path_fitting(evidence)?;
    trust(evidence)?;
    methods(evidence)
}

fn parabolic(evidence: &Evidence) -> Result<(), Failed> {
    let data = table(evidence, "answer-parabolic");
    let [smooth, later, soon] = ["Smooth data, t = 1", "After a jump, t = 0.5", "Immediately after the jump, t = 0.02"];
    let error = |case: &str, method: &str, systems: f64| {
        let points = points(data, case, method, "systems", "error");
        points.iter().find(|point| point.0 == systems).expect("such a run").1
    };
    let own = "method-i";
    let over = |case: &str, method: &str| error(case, method, 32.0) / error(case, own, 32.0);
    let best = |case: &str| least(&CHANNEL, |method| error(case, method, 32.0));
    let first = CHANNEL[1..].iter().map(|method| error(soon, method, 2.0) / error(soon, own, 2.0));
    let [low, high] = extremes(first);
    // As soon as more than one step is taken, another is ahead.
    if least(&CHANNEL, |method| error(soon, method, 2.0)) != own
        || least(&CHANNEL, |method| error(soon, method, 4.0)) == own
    {
        return Err("Method I is not the best for one step, or for two".into());
    }
    // In shorter steps the trapezoidal rule does not ring any more.
    let rule = |case: &str, systems: f64| error(case, "trapezoidal", systems) / error(case, own, systems);
    let falls = rule(later, 4.0) > 1.0 && [later, soon].iter().all(|case| rule(case, 64.0) < 1.0);
    if !falls {
        return Err("the error of the trapezoidal rule does not fall below Method I's in shorter steps".into());
    }
    let (radau, of_radau, of_rule) =
        (best(later), brief(over(smooth, best(later))), brief(over(smooth, "trapezoidal")));
    let of_later = brief(over(later, radau));
    // In as many steps of the same size.
    let factors = |name: &str| -> Result<u64, Failed> {
        let problem = verify::problem::build("channel-womersley", &[("cells".to_owned(), "64".to_owned())]);
        let problem = problem.map_err(|error| error.to_string())?;
        let method = verify::method::parse(name).map_err(|error| error.to_string())?;
        let run = verify::run::run(&*problem, &*method, 1.0 / 16.0, 1.0, |_| {}).map_err(|error| error.to_string())?;
        Ok(run.work.factorizations)
    };
    let [own_factors, radau_factors, kept_factors] = [factors(own)?, factors(radau)?, factors("sdirk2")?];
    let over_own = |case: &str| error(case, "sdirk2", 32.0) / error(case, own, 32.0);
    let [of_smooth, of_jump] = [smooth, later].map(over_own);
    if kept_factors > own_factors || of_smooth >= 1.0 || of_jump >= 1.0 {
        return Err(format!("SDIRK2 factors {kept_factors} matrices and Method I {own_factors}").into());
    }
    consists(
        &told(evidence, "answer-parabolic"),
        &[
            format!("Take `{radau}`, Radau IIA with two stages, for a stiff parabolic problem:"),
            format!(
                "in a channel of 64 cells, for 32 linear systems of the size of the problem, 16 steps of either, its error is {of_radau} of Method I's on smooth data and {of_later} of it well after a jump."
            ),
            format!(
                "right after it, for two linear systems, the other methods have {} times its error",
                between(low, high)
            ),
            format!(
                "in the first of these runs the number of matrices that this library factors is {own_factors} for Method I, {radau_factors} for Radau IIA, which takes new ones in each step, and {kept_factors} for `sdirk2`, whose error is {} of Method I's on smooth data and {} of it well after the jump",
                brief(of_smooth),
                brief(of_jump)
            ),
            "in a channel of 64 cells".into(),
            format!(
                "for 32 systems `{}` is the most accurate, and the trapezoidal rule has {of_rule} of Method I's error",
                best(smooth)
            ),
            "Middle, a wall set in motion at once, followed to t = 0.5. Right, the same at t = 0.02:".into(),
            format!("Take: `{radau}` with fixed steps, `radau-adaptive` with a tolerance, `sdirk2` where f is linear"),
            format!(
                "Short: Radau IIA with two stages (`{radau}`) has {of_radau} of Method I's error on smooth data and {of_later} of it well after a jump, for 32 linear systems in a channel of 64 cells; its order is 3 and Method I's 2."
            ),
        ],
    )?;
    let panels = [smooth, later, soon].map(|case| (case, case, "systems"));
    drawn(evidence, "answer-parabolic", &panels, "error", &CHANNEL)
}

fn ringing(evidence: &Evidence) -> Result<(), Failed> {
    let data = table(evidence, "answer-ringing");
    let error = |method: &str, step: f64| {
        let points = points(data, "error", method, "y_or_step", "value");
        points.iter().find(|point| point.0 == step).expect("such a step").1
    };
    let best = |step: f64| least(&CHANNEL, |method| error(method, step));
    let winner = best(10.0);
    let overtaken = (1..=10).rev().take_while(|step| best(f64::from(*step)) == winner).last().expect("the last");
    let next = least(&CHANNEL[1..], |method| error(method, 1.0));
    // From the wall at rest to the one with speed 1 a profile climbs by 1, and again by what it falls on the way.
    let variation = |inside: &[f64]| {
        let (mut fallen, mut last) = (0.0, 0.0);
        for u in inside.iter().copied().chain([1.0]) {
            fallen += if u < last { last - u } else { 0.0 };
            last = u;
        }
        1.0 + 2.0 * fallen
    };
    let mut waves = Vec::new();
    for method in CHANNEL {
        let run = CONTEXT.get(Course { problem: "channel-couette cells=64".into(), method, h: 0.05, t_end: 0.5 })?;
        if run.errors[0].0 != 0.05 || run.errors.len() != 10 || run.state.len() + 1 != 64 {
            return Err("ten steps of 0.05 on 64 cells".into());
        }
        if variation(&run.exact) != 1.0 {
            return Err("the exact profile goes up once".into());
        }
        waves.push(variation(&run.state));
    }
    if CHANNEL.iter().zip(&waves).any(|(method, waves)| (*waves == 1.0) != (*method != "trapezoidal")) {
        return Err(format!("not the trapezoidal rule alone goes up and down: {waves:?}").into());
    }
    // The sign of its error turns from one step to the next.
    let near = |step: u32| points(data, &format!("error after {step} steps"), "trapezoidal", "y_or_step", "value");
    if near(9).iter().zip(near(10)).map(|(a, b)| a.1 * b.1).sum::<f64>() >= 0.0 || best(1.0) != "method-i" {
        return Err("it does not turn its sign, or Method I is not the first after a step".into());
    }
    // From the wall inwards.
    for (step, t_end) in [(9, 0.45), (10, 0.5)] {
        for method in CHANNEL {
            let run = CONTEXT.get(Course { problem: "channel-couette cells=64".into(), method, h: 0.05, t_end })?;
            let errors = run.state.iter().zip(&run.exact).map(|(u, exact)| u - exact).rev();
            let expected = (1..).map(|i| 1.0 - f64::from(i) / 32.0).zip(errors);
            let drawn = points(data, &format!("error after {step} steps"), method, "y_or_step", "value");
            if drawn.is_empty() || !drawn.iter().rev().copied().eq(expected.take(drawn.len())) {
                return Err(format!("the profile of {method} after {step} steps: {drawn:?}").into());
            }
        }
    }
    // Of the second difference with 64 cells between walls that are 2 apart.
    let z = 0.05 * 4.0 * 32.0_f64.powi(2) * (std::f64::consts::PI / 128.0).cos().powi(2);
    // A trapezoidal stage up to γ and a backward difference, and two stages with γ on the diagonal.
    let (gamma, diagonal) = (2.0 - 2.0_f64.sqrt(), 1.0 - 0.5_f64.sqrt());
    let stage = (1.0 - 0.5 * gamma * z) / (1.0 + 0.5 * gamma * z);
    let rest = 2.0 - gamma;
    let tr_bdf2 = (stage - (1.0 - gamma).powi(2)) / (gamma * rest) / (1.0 + (1.0 - gamma) / rest * z);
    let sdirk2 = (1.0 - (1.0 - 2.0 * diagonal) * z) / (1.0 + diagonal * z).powi(2);
    consists(
        &told(evidence, "answer-ringing"),
        &[
            format!(
                "10 steps after a wall was set in motion the trapezoidal rule has {} times the error of Method I.",
                brief(error("trapezoidal", 10.0) / error("method-i", 10.0))
            ),
            "next to the wall on 64 cells after 9 and after 10 steps of h = 0.05, up to t = 0.5 (left, middle)".into(),
            format!(
                "The total variation of its profile from wall to wall is {} times that of the exact one, which rises monotonically; every other profile does too.",
                brief(waves[1])
            ),
            format!(
                "After the first step Method I has the smallest error, and the next method {} times that; from step {overtaken} on `{winner}` has the smallest.",
                brief(error(next, 1.0) / error("method-i", 1.0))
            ),
            format!(
                "Short: After 10 steps the profile of Method I rises monotonically, as the exact one does, and that of the trapezoidal rule up and down, with {} times the exact one's total variation:",
                brief(waves[1])
            ),
            format!(
                "of the shortest wave of this run, hλ = {}, a step of Method I leaves {}, one of TR-BDF2 {}, of SDIRK2 {}, of Radau IIA {} and of the trapezoidal rule {};",
                digits(z, 3),
                brief((1.0 + z + 0.5 * z * z).recip()),
                brief(tr_bdf2),
                brief(sdirk2),
                brief((1.0 - z / 3.0) / (1.0 + 2.0 / 3.0 * z + z * z / 6.0)),
                brief((1.0 - 0.5 * z) / (1.0 + 0.5 * z))
            ),
        ],
    )?;
    let panels = [
        ("Next to the wall, after 9 steps", "error after 9 steps", "y_or_step"),
        ("Next to the wall, after 10 steps", "error after 10 steps", "y_or_step"),
        ("Step by step", "error", "y_or_step"),
    ];
    drawn(evidence, "answer-ringing", &panels, "value", &CHANNEL)
}

fn path_fitting(evidence: &Evidence) -> Result<(), Failed> {
    let data = table(evidence, "answer-path-fitted");
    let energy = |method: &str| points(data, "mean energy error over time", method, "evaluations_or_t", "error");
    let errors = |method: &str| points(data, "error over evaluations", method, "evaluations_or_t", "error");
    let mut error = Vec::new();
    let mut defect = Vec::new();
    for method in FITTED {
        let run = CONTEXT.get(KeplerPeriod { method: method.into(), steps: 256 })?;
        if !errors(method).contains(&(run.work.residuals as f64, run.error)) {
            return Err(format!("the run of {method} with 256 steps is not drawn").into());
        }
        error.push(run.error);
        defect.push(brief(CONTEXT.get(Defects { problem: "double-pendulum", method: method.into() })?.at(0.2)));
    }
    let change = |method: &str| {
        let means = || energy(method).into_iter().map(|(_, mean)| mean);
        means().largest() - means().smallest()
    };
    // Windows of equal length, and steps of 0.5, as the title of the picture says.
    let first = &energy(FITTED[0])[..2];
    let steps = (first[1].0 - first[0].0) * energy(FITTED[0]).len() as f64 / 0.5;
    let (gauss, galerkin) = (brief(error[0] / error[1]), brief(error[2] / error[1]));
    // The least-squares slope over equally spaced middles: Σ (k − k̄) ē over Σ (k − k̄)², a window.
    let courses = energy(FITTED[0]);
    let places = || (0..courses.len()).map(|k| k as f64 - 0.5 * (courses.len() - 1) as f64);
    let slope =
        places().zip(&courses).map(|(k, (_, mean))| k * mean).sum::<f64>() / places().map(|k| k * k).sum::<f64>();
    let equispaced = brief((slope * courses.len() as f64).abs());
    let kept = brief(rounded_up(change(FITTED[1]).max(change(FITTED[2])), 2));
    consists(
        &told(evidence, "answer-path-fitted"),
        &[
            format!(
                "with 256 steps in a period of Kepler's problem `path-fitted(4)` has {gauss} times the error of `path-fitted(4,gauss)` for as many evaluations"
            ),
            format!("`galerkin-gauss(3)` has {galerkin} times the error of `path-fitted(4,gauss)`."),
            format!(
                "over {steps} steps it drifts by {equispaced} on equispaced nodes, the slope of a fitted line times the time, and changes by {kept} at most on Gauss nodes and with the Galerkin integrator."
            ),
            format!(
                "of one step of 0.2 is {} on equispaced nodes, {} on Gauss nodes, and for the Galerkin integrator {}, which is rounding.",
                defect[0], defect[1], defect[2]
            ),
            format!(
                "Short: On Kepler's problem three equispaced points (`path-fitted(4)`) make {gauss} times the error of three Gauss nodes (`path-fitted(4,gauss)`) for as many evaluations, at 256 steps: their order is 4 and that of Gauss nodes 6."
            ),
        ],
    )?;
    let panels = [
        ("Kepler's problem, eccentricity 0.6", "error over evaluations", "evaluations_or_t"),
        ("Rotating pendulum, h = 0.5", "mean energy error over time", "evaluations_or_t"),
    ];
    drawn(evidence, "answer-path-fitted", &panels, "error", &FITTED)
}

/// Its word or two.
fn smooth(evidence: &Evidence) -> Result<String, Failed> {
    let data = table(evidence, "answer-smooth-errors");
    let over = |own: &str, method: &str| {
        let [own, other] = [own, method].map(|name| data.column(name).expect("a column"));
        extremes(
            data.rows.iter().map(|row| row[own].number().zip(row[other].number()).map_or(f64::NAN, |(a, b)| a / b)),
        )
    };
    if data.rows.len() != 4 || data.rows.iter().any(|row| row[1] != Cell::Number(0.05)) {
        return Err("four problems, steps of 0.05".into());
    }
    // On v̇ = −v² from 1 a step of the trapezoidal rule solves a quadratic: the largest error over the grid, not that at its end.
    let (mut v, h) = (1.0_f64, 0.05);
    let errors = (1..=40).map(|n| {
        let known = v - 0.5 * h * v * v;
        v = ((1.0 + 2.0 * h * known).sqrt() - 1.0) / h;
        (v - (1.0 + h * f64::from(n)).recip()).abs()
    });
    let (largest, column) = (errors.largest(), data.column("trapezoidal").expect("a column"));
    let row = data.rows.iter().find(|row| row[0].to_string() == "quadratic-drag").expect("a row");
    if !row[column].number().is_some_and(|error| (error / largest - 1.0).abs() < 1e-9) {
        return Err(format!("{row:?} where the trapezoidal rule has {largest}").into());
    }
    let ratios = |method: &str| over("method-i", method);
    let [[m0, m1], [t0, t1]] = ["implicit-midpoint", "trapezoidal"]
        .map(ratios)
        .map(|[least, most]| [rounded_down(least, 2), rounded_up(most, 2)].map(brief));
    let or_more = |least: f64| brief(rounded_down(least, 2));
    let [gauss, work] = ["method-i", "method_i_for_equal_work"].map(|own| or_more(over(own, GAUSS)[0]));
    consists(
        &told(evidence, "answer-smooth"),
        &[
            format!(
                "on four smooth nonlinear problems, followed to t = 2, the largest error of Method I is {gauss} times its, or more, with equal steps of 0.05, and {work} times, or more, for as many evaluations of f."
            ),
            format!(
                "With equal steps it makes {m0} to {m1} times the error of the implicit midpoint rule and {t0} to {t1} times that of the trapezoidal rule, which are of second order"
            ),
            format!(
                "Short: With equal steps of 0.05 on four smooth problems Method I (order 2) makes {t0} to {t1} times the error of the trapezoidal rule (order 2) and {gauss} times that of Gauss collocation with two nodes (`{GAUSS}`, order 4), or more."
            ),
        ],
    )?;
    Ok(format!("with steps of 0.05 a factor of up to {t1}, or of {gauss} and more"))
}

fn trust(evidence: &Evidence) -> Result<(), Failed> {
    let data = table(evidence, "answer-trust-controls");
    let wanted: Vec<String> = data.rows.iter().map(|row| row[2].to_string()).collect();
    let refused = data.rows.iter().filter(|row| row[1].to_string() != "pass").count();
    let planted = wanted.iter().filter(|wanted| ["fail", "not pass"].contains(&wanted.as_str())).count();
    if refused != planted {
        return Err("what is wrong is not what is refused".into());
    }
    let (problems, methods, references) = (problem::ALL.len(), method::ALL.len(), reference::all().len());
    consists(
        &told(evidence, "answer-trust"),
        &[
            format!("on {problems} problems with {methods} families of methods."),
            format!("Besides exact solutions {references} solvers of two libraries"),
            format!(
                "are applied to {} inputs each time, {planted} of them wrong on purpose, and reject every wrong one;",
                wanted.len()
            ),
            format!("{references} solvers of two other libraries"),
        ],
    )
}

/// Method, order, and what becomes of what decays fast, as the textbooks have it.
const TEXTBOOK: [(&str, &str, &str); 15] = [
    ("method-i", "2", "damped to zero"),
    ("method-ii", "2", "not damped to zero"),
    ("linear(-0.5,1)", "2", "not damped to zero"),
    ("conventional", "2", "grows"),
    ("trapezoidal", "2", "not damped to zero"),
    ("tr-bdf2", "2", "damped to zero"),
    ("sdirk2", "2", "damped to zero"),
    (RADAU, "3", "damped to zero"),
    ("radau-adaptive", "5 to 13", "damped to zero"),
    (GAUSS, "4", "not damped to zero"),
    (FITTED[0], "4", ""),
    (FITTED[1], "6", ""),
    (FITTED[2], "6", ""),
    ("stormer-verlet", "2", ""),
    ("blanes-moan", "6", ""),
];

fn methods(evidence: &Evidence) -> Result<(), Failed> {
    let data = table(evidence, "methods");
    let rows = TEXTBOOK.map(|(name, order, decay)| (format!("`{name}`"), order.to_owned(), decay.to_owned()));
    let shown: Vec<_> = data.rows.iter().map(|row| [0, 2, 3].map(|i| row[i].to_string())).collect();
    if shown != rows.clone().map(|(name, order, decay)| [name, order, decay]) {
        return Err(format!("{shown:?} where {rows:?} is known").into());
    }
    let end = |problem: &str, method: &str, h: f64, t_end: f64| {
        let [problem, method] = [problem, method].map(str::to_owned);
        CONTEXT.get(EndErrors { problem, method, h, pieces: 1, t_end, truth: Truth::Equations }).map(|found| found.end)
    };
    let smooth = table(evidence, "answer-smooth-errors");
    let rule = smooth.column("trapezoidal").expect("a column");
    let mut family = Vec::new();
    for row in &smooth.rows {
        let run = Course { problem: row[0].to_string(), method: "linear(-0.5,1)", h: 0.05, t_end: 2.0 };
        let errors = CONTEXT.get(run)?.errors.iter().map(|(_, error)| *error).largest();
        family.push(errors / row[rule].number().unwrap_or(f64::NAN));
    }
    let [low, high] = extremes(family.into_iter());
    let course = |method: &str| points(table(evidence, "answer-ringing"), "error", method, "y_or_step", "value")[9].1;
    let parts = [
        (
            "method-ii",
            vec![
                format!(
                    "On linear problems with an invertible matrix its step is the trapezoidal rule's, and rings: {} times Method I's error after a jump, in steps as long as in the answer on ringing.",
                    brief(course("trapezoidal") / course("method-i"))
                ),
                // The quadratic for v₁ has no real root for hv₀ > 1.
                "where hv₀ exceeds 1.0.".into(),
            ],
        ),
        (
            "linear(-0.5,1)",
            vec![
                format!(
                    "Where one λ is known, the best constants for hλ ≤ 3 have {} of the largest error that a step of Method I makes.",
                    brief(best_constant())
                ),
                format!(
                    "On four smooth problems this one makes {} times the trapezoidal rule's error.",
                    between(low, high)
                ),
            ],
        ),
        (
            "conventional",
            vec![format!(
                "with h = 0.1 the error at t = 10 is {}.",
                brief(end("linear-drag", "conventional", 0.1, 10.0)?)
            )],
        ),
    ];
    // From which number of systems on Radau IIA has the smaller error in all pictures.
    let channel = table(evidence, "answer-parabolic");
    let leads_from = |method: &'static str| {
        let errors = |method: &'static str| {
            let rows = channel.rows.iter().filter(move |row| row[1].to_string() == method);
            rows.filter_map(|row| row[3].number().zip(row[4].number()))
        };
        let pairs = errors(RADAU).zip(errors(method));
        let behind = pairs.filter(|(own, other)| own.1 >= other.1).map(|(own, _)| own.0).fold(0.0, larger);
        f64::max(2.0, 2.0 * behind)
    };
    let leads =
        |method| vec![format!("more accurate for the same work, from {} linear systems on.", leads_from(method))];
    let parts =
        parts.into_iter().chain(["tr-bdf2", "sdirk2"].map(|method| (method, leads(method)))).collect::<Vec<_>>();
    for row in &data.rows {
        let name = row[0].to_string();
        let known = parts.iter().find(|(method, _)| name == format!("`{method}`")).map(|(_, known)| known.as_slice());
        consists(&format!("{}. {}", row[1], row[4]), known.unwrap_or_default())?;
    }
    Ok(())
}

/// The least, over all constant closures −θp₀ + p₁ = 0, of the largest error of a step on v̇ = −v with h up to 3, over that of
/// Method I, θ = 0: from the closed form of the step.
fn best_constant() -> f64 {
    let worst = |theta: f64| {
        let closure = Amplification { alpha: -theta, beta: 1.0 };
        let error = |k: u32| {
            let h = 3.0 * f64::from(k) / 300.0;
            (closure.factor(Complex::from(-h)).re - (-h).exp()).abs()
        };
        (1..=300).map(error).largest()
    };
    (0..=1000).map(|k| worst(f64::from(k) / 1000.0)).smallest() / worst(0.0)
}

/// That each panel, by its title, draws for each method in its order all rows of its group.
fn drawn(
    evidence: &Evidence,
    id: &str,
    panels: &[(&str, &str, &str)],
    y: &str,
    methods: &[&str],
) -> Result<(), Failed> {
    let figure = evidence.figures.iter().find(|figure| figure.id == id).expect("a figure");
    let titles: Vec<_> = figure.panels.iter().map(|panel| panel.title.as_str()).collect();
    let known: Vec<_> = panels.iter().map(|panel| panel.0).collect();
    if titles != known {
        return Err(format!("{titles:?}").into());
    }
    for (panel, (title, group, x)) in figure.panels.iter().zip(panels) {
        let labels: Vec<_> = panel.series.iter().map(|series| series.label.as_str()).collect();
        if labels != methods {
            return Err(format!("{title}: {labels:?}").into());
        }
        for series in &panel.series {
            let rows = points(table(evidence, &figure.data), group, &series.label, x, y);
            if rows.is_empty() || rows != series.points {
                return Err(format!("{title}: `{}` is not drawn from its rows", series.label).into());
            }
        }
    }
    Ok(())
}
