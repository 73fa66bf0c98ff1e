//! Numbers of the sentences about the figures of the paper are recomputed from the tables that stand beside them.

use libtest_mimic::Failed;
use lsvi::State;
use verify::chapter;
use verify::evidence::number::{brief, rounded_down, rounded_up, short};
use verify::evidence::{Cell, Evidence, Table};
use verify::measure::norm::Extremes;
use verify::method::{self, Method};
use verify::problem::{self, poiseuille_series};
use verify::run::run;

use super::CONTEXT;
use super::answers::{consists, table};

pub(super) fn rest_on_their_tables() -> Result<(), Failed> {
    linear_drag(&found("linear-drag")?)?;
    quadratic_drag(&found("quadratic-drag")?)?;
    poiseuille(&found("poiseuille-ansatz")?)
}

fn found(id: &str) -> Result<Evidence, Failed> {
    let study = chapter::ALL.iter().find(|study| study.id == id).ok_or("a chapter")?;
    Ok((study.run)(&CONTEXT).map_err(|error| error.to_string())?)
}

/// The largest error of a run.
fn error(table: &Table, problem: &str, method: &str, h: f64) -> f64 {
    let known = [Cell::from(problem), Cell::from(h), Cell::from(method)];
    let row = table.rows.iter().find(|row| row[..3] == known);
    row.and_then(|row| row[3].number()).unwrap_or(f64::NAN)
}

/// The step sizes, coarse to fine.
fn steps(table: &Table) -> Vec<f64> {
    let mut steps: Vec<f64> = table.rows.iter().filter_map(|row| row[1].number()).collect();
    steps.dedup();
    steps
}

/// The errors over time are drawn in panels (a), (b), … of one step size each.
fn panels(evidence: &Evidence, id: &str, steps: &[f64]) -> Result<(), Failed> {
    let figure = evidence.figures.iter().find(|figure| figure.id == id).ok_or("no figure")?;
    let titles: Vec<_> = figure.panels.iter().map(|panel| panel.title.clone()).collect();
    let expected: Vec<_> = "abcdef".chars().zip(steps).map(|(letter, h)| format!("({letter}) h = {h}")).collect();
    if titles != expected {
        return Err(format!("`{id}` has {titles:?}").into());
    }
    let data = table(evidence, &figure.data);
    for (panel, h) in figure.panels.iter().zip(steps) {
        for series in &panel.series {
            let rows = data.rows.iter().filter(|row| row[1] == Cell::from(*h) && row[2] == Cell::from(&series.label));
            let points: Vec<_> = rows.filter_map(|row| row[3].number().zip(row[4].number())).collect();
            if series.points.iter().any(|point| !points.contains(point)) {
                return Err(format!("“{}” of `{id}` is not that of h = {h}", series.label).into());
            }
        }
    }
    Ok(())
}

fn linear_drag(evidence: &Evidence) -> Result<(), Failed> {
    const STEPS: [f64; 6] = [2.5, 2.0, 1.5, 1.0, 0.1, 0.01];
    let data = table(evidence, "figure-2");
    if steps(data) != STEPS {
        return Err(format!("{:?}", steps(data)).into());
    }
    panels(evidence, "figure-1", &STEPS)?;
    let ratio = |a: &str, b: &str, h: f64| error(data, "linear-drag", a, h) / error(data, "linear-drag", b, h);
    let gain = |method: &str| short(ratio("implicit-euler", method, 1.0));
    let ours = ["method-i", "method-ii"];
    let is_ahead =
        |h: f64| ours.iter().all(|own| ["implicit-euler", "rk4"].iter().all(|other| ratio(own, other, h) < 1.0));
    let is_behind = |h: f64| ours.iter().all(|own| ratio("rk4", own, h) < 1.0);
    if ![2.0, 2.5].into_iter().all(is_ahead) || !is_behind(1.5) {
        return Err("not ahead where the text has it".into());
    }
    // Where the errors of the first step are equal: |R(h) − e^{−h}| of either method and of RK4.
    let of_rk4 = |h: f64| 1.0 - h + h * h / 2.0 - h.powi(3) / 6.0 + h.powi(4) / 24.0 - (-h).exp();
    let of_first = |h: f64| 2.0 / (2.0 + 2.0 * h + h * h) - (-h).exp();
    let of_second = |h: f64| (1.0 - h / 2.0) / (1.0 + h / 2.0) - (-h).exp();
    if [2.6, 3.0, 10.0, 100.0].iter().any(|h| of_second(*h).abs() <= (1.0 / (1.0 + h) - (-h).exp()).abs()) {
        return Err("Method II is not behind implicit Euler".into());
    }
    let equal = |own: &dyn Fn(f64) -> f64| short(bisected([1.0, 2.4], |h| own(h).abs() > of_rk4(h).abs()));
    consists(
        &evidence.notes.join("\n"),
        &[
            "at h = 2 and 2.5 both its methods beat implicit Euler and RK4; at larger ones Method II falls behind implicit Euler (S24-d-2). At \
             h = 1.5 RK4 is still ahead of both."
                .into(),
            format!("Method I overtakes it at h = {}, Method II at h = {}.", equal(&of_first), equal(&of_second)),
            format!("At h = 1 it is {} for Method I and {} for Method II.", gain("method-i"), gain("method-ii")),
            format!("Method I has {} times its error at h = 0.01.", short(ratio("method-i", "trapezoidal", 0.01))),
            "It stands still at h = 2 and".into(),
        ],
    )
}

fn quadratic_drag(evidence: &Evidence) -> Result<(), Failed> {
    let data = table(evidence, "figure-4");
    let steps = steps(data);
    let (coarsest, finest) = (steps[0], steps[steps.len() - 1]);
    panels(evidence, "figure-3", &steps)?;
    let over =
        |method: &str, h: f64| error(data, "quadratic-drag", "method-i", h) / error(data, "quadratic-drag", method, h);
    let rivals = ["implicit-euler", "rk4", "trapezoidal", "implicit-midpoint", "explicit-momentum"];
    if !rivals.iter().all(|rival| over(rival, coarsest) < 1.0) || steps[1..].iter().any(|h| over("rk4", *h) <= 1.0) {
        return Err("Method I is not the best at the largest step alone".into());
    }
    let against = |method: &str| short(over("trapezoidal", finest) / over(method, finest));
    // The momentum at the end of a step from h v₀ = h: zero with Method I, that at its beginning with Method II.
    let method_i = |h: f64, x: f64| {
        [2.0 * x.powi(3) + 3.0 * x * x + 2.0 * (1.0 - h) * x + h * h - 2.0 * h, 6.0 * x * x + 6.0 * x + 2.0 * (1.0 - h)]
    };
    let method_ii = |h: f64, x: f64| [x * x * (1.0 + x) - h * h * (1.0 - h), 2.0 * x + 3.0 * x * x];
    let (first, second) = (falls_behind([1.0, 2.2], method_i), falls_behind([0.3, 0.99], method_ii));
    consists(
        &evidence.notes.join("\n"),
        &[
            format!("at all but the largest, h = {coarsest}, where Method I"),
            format!("Method II is ahead of implicit Euler up to h = {second},"),
            format!("Method I is ahead up to h = {first},"),
            format!(
                "At h = {finest} the errors are {}, {} and {} times that of the trapezoidal rule",
                against("method-i"),
                against("method-ii"),
                against("implicit-midpoint")
            ),
            format!("and h = {coarsest} is exactly where"),
        ],
    )
}

/// The step size in an interval beyond which the first step from 1 on v̇ = −v² is further below the solution than implicit Euler's is above
/// it. A step of the method solves p(X) = 0, X = h v₁, where p is convex: Newton's method descends to the root from the solution.
fn falls_behind(between: [f64; 2], p_and_slope: fn(h: f64, x: f64) -> [f64; 2]) -> String {
    let end = bisected(between, |h| {
        let (exact, euler) = (1.0 / (1.0 + h), ((1.0 + 4.0 * h).sqrt() - 1.0) / (2.0 * h));
        let x = (0..60).fold(h * exact, |x, _| {
            let [p, slope] = p_and_slope(h, x);
            x - p / slope
        });
        exact - x / h < euler - exact
    });
    short(rounded_down(end, 4))
}

/// Up to where something holds.
fn bisected([mut low, mut high]: [f64; 2], holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if holds(middle) { low = middle } else { high = middle }
    }
    low
}

/// The ends of the steps at which implicit Euler on the averaged equation errs less than Method I, from runs of their own.
fn where_implicit_euler_leads() -> Result<[String; 2], Failed> {
    let failed = |error: &dyn std::fmt::Display| Failed::from(error.to_string());
    let problem = problem::build_setting("poiseuille-ansatz").map_err(|error| failed(&error))?;
    let methods = ["implicit-euler", "method-i"].map(method::parse);
    let [euler, first] = methods.map(|method| method.map_err(|error| failed(&error)));
    let (euler, first) = (euler?, first?);
    let leads = |h: f64| {
        let of = |method: &dyn Method| {
            let mut errors = Vec::new();
            let observe = |state: &State| {
                errors.push(problem.exact(state.t).map_or(f64::NAN, |exact| (state.q[0] - exact[0]).abs()));
            };
            // The largest errors are those of the start.
            run(&*problem, method, h, 4.0 * h.max(0.5), observe).map_or(f64::NAN, |_| errors.into_iter().largest())
        };
        of(&*euler) < of(&*first)
    };
    let [from, to] = [bisected([0.01, 0.2], |h| !leads(h)), bisected([0.2, 0.5], leads)];
    Ok([rounded_up(from, 4), rounded_down(to, 4)].map(short))
}

/// The distances over the channel by the midpoint rule, whose error is of second order in 1/200.
fn profiles_by_midpoints(profile: &dyn Fn(&str) -> f64) -> Result<(), Failed> {
    let exact = |y: f64, t: f64| poiseuille_series::velocity(2.0, y, t).unwrap_or(f64::NAN);
    let heights: Vec<f64> = (0..200).map(|k| (f64::from(k) + 0.5) / 200.0).collect();
    let mean = |f: &dyn Fn(f64) -> f64| heights.iter().map(|y| f(*y)).sum::<f64>() / 200.0;
    let distances: Vec<[f64; 4]> = (1..=400)
        .map(|k| {
            let t = 2.0 * (f64::from(k) / 400.0).powi(2);
            let fitted = mean(&|y| exact(y, t) * (1.0 - y * y)) / mean(&|y| (1.0 - y * y).powi(2));
            [1.0 - (-2.5 * t).exp(), 1.0 - (-3.0 * t).exp(), fitted, exact(0.0, t)]
                .map(|v| mean(&|y| (v * (1.0 - y * y) - exact(y, t)).powi(2)).sqrt())
        })
        .collect();
    let names = [
        "Galerkin equation",
        "averaged equation (41)",
        "least-squares fit of the profile",
        "centre velocity of the flow",
    ];
    for (place, name) in names.into_iter().enumerate() {
        let found = distances.iter().map(|row| row[place]).largest();
        let off = (profile(name) / found - 1.0).abs();
        if off.is_nan() || off >= 1e-3 {
            return Err(format!("{name}: {} and {found}", profile(name)).into());
        }
    }
    // Where a run to t = 2 has its largest distance, one to t = 10 has.
    if distances.last().is_some_and(|row| row.iter().all(|d| *d < 0.01)) {
        Ok(())
    } else {
        Err("the distances do not decay".into())
    }
}

fn poiseuille(evidence: &Evidence) -> Result<(), Failed> {
    let (data, floors) = (table(evidence, "figure-7"), table(evidence, "poiseuille-floors"));
    panels(evidence, "figure-6", &steps(data))?;
    panels(evidence, "figure-6-galerkin", &steps(data))?;
    let floor = |name: &str, column: usize| {
        let row = floors.rows.iter().find(|row| row[0] == Cell::from(name));
        row.and_then(|row| row[column].number()).unwrap_or(f64::NAN)
    };
    let [averaged, galerkin, best] =
        ["averaged equation (41)", "Galerkin equation", "best constant rate at the centre"].map(|name| floor(name, 2));
    let profile = |name: &str| floor(name, 3);
    profiles_by_midpoints(&profile)?;
    let of = |method: &str| error(data, "poiseuille-ansatz", method, 0.01);
    let others = ["method-ii", "implicit-euler", "rk4"].map(of).into_iter().smallest();
    let ratios = steps(data).into_iter().filter(|h| *h <= 0.1).map(|h| {
        let of = |method: &str| error(data, "poiseuille-ansatz", method, h);
        of("method-i") / ["method-ii", "implicit-euler", "rk4"].map(of).into_iter().smallest()
    });
    if !ratios.collect::<Vec<_>>().is_sorted_by(|coarse, fine| fine < coarse) {
        return Err("the ratio does not fall".into());
    }
    let [from, to] = where_implicit_euler_leads()?;
    // Of the methods on the ansatz, Method I and the closure pₙ = 0 solve the Galerkin equation.
    let off = data.rows.iter().filter(|row| row[1].number().is_some_and(|h| h <= 0.01)).map(|row| {
        let is_averaged = row[0] == Cell::from("poiseuille-ansatz")
            && ["method-i", "explicit-momentum"].iter().all(|method| row[2] != Cell::from(*method));
        row[3].number().map_or(f64::NAN, |error| (error / if is_averaged { averaged } else { galerkin } - 1.0).abs())
    });
    let off = brief(rounded_up(100.0 * off.largest(), 2));
    let [of_galerkin, of_averaged] = [galerkin, averaged].map(short);
    consists(
        &evidence.notes.join("\n"),
        &[
            format!("from h = {from} to {to}, implicit Euler has a smaller one."),
            format!(
                "Method I's error over the smallest of the other three is {} at h = 0.01, and tends to {} as h falls.",
                short(of("method-i") / others),
                short(galerkin / averaged)
            ),
            format!("whose solution is {of_galerkin} away from the flow at its farthest."),
            format!("averaged equation, whose solution is {of_averaged} away."),
            format!("For h up to 0.01 every error is that distance of its equation to within {off} %"),
            "At the centre, which the paper's Figure 7 shows,".into(),
            format!("reach the same {of_galerkin}, and"),
            format!(
                "the best rate, {}, has {} of that floor's error",
                short(floor("best constant rate at the centre", 1)),
                short(best / galerkin)
            ),
            format!(
                "error is {} at most, that of the parabola fitted to the flow at each time {}",
                short(profile("Galerkin equation")),
                short(profile("least-squares fit of the profile"))
            ),
            format!(
                "the rate that is best at the centre has {}, the exact velocity there {}.",
                short(profile("best constant rate at the centre")),
                short(profile("centre velocity of the flow"))
            ),
            format!(
                "solution's error is {} of the averaged one's.",
                short(profile("Galerkin equation") / profile("averaged equation (41)"))
            ),
            format!(
                "by the pressure gradient 2, the ansatz by {} or {}.",
                floor("Galerkin equation", 1),
                floor("averaged equation (41)", 1)
            ),
        ],
    )
}
