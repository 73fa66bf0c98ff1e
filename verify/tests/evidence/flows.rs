//! Numbers of the sentences about flows are recomputed from the tables that stand beside them.

use libtest_mimic::Failed;
use verify::chapter;
use verify::evidence::number::{brief, short};
use verify::evidence::{Cell, Evidence, Table};

use super::CONTEXT;
use super::answers::{consists, table};

const OURS: [&str; 2] = ["method-i", "velocity"];
const FLOWS: [&str; 2] = ["shear-layer", "turbulence-2d"];

pub(super) fn rest_on_their_tables() -> Result<(), Failed> {
    let study = chapter::ALL.iter().find(|study| study.id == "flows").expect("a chapter");
    let evidence = &(study.run)(&CONTEXT).map_err(|error| error.to_string())?;
    periodic(evidence)?;
    conservation(evidence)?;
    lid(evidence)?;
    disturbances(evidence)
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
    consists(
        &paragraph(evidence, "On smooth periodic flows")?,
        &[
            format!("on 32² points at Re = 200 up to t = 1, Method I {word} TR-BDF2: at h = 0.0125 its error"),
            format!("is {} times as large on shear layers", short(ratios[0])),
            format!("and {} times on decaying turbulence", short(ratios[1])),
            format!("There it is {} times that of the trapezoidal rule", short(over(turbulence, OURS, trapezoidal))),
            format!("implicit Euler has {} times its error", short(over(turbulence, euler, OURS))),
        ],
    )?;
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
    consists(
        &paragraph(evidence, "On 32² points at equal numbers of evaluations")?,
        &[
            "On 32² points".into(),
            format!("is {} times that of TR-BDF2 on the shear layers", equal_work(shear)),
            format!("and {} times on turbulence", equal_work(turbulence)),
            format!("a run of {} evaluations has an error of {}, where", cheapest.0, brief(cheapest.1)),
            format!("takes {} for {}.", own.0, brief(own.1)),
        ],
    )?;
    let other = ["method-i", "vorticity"];
    let enstrophy = |flow: &str, case: [&str; 2]| brief(finest(flow, case, "enstrophy"));
    let sign = |case: [&str; 2]| {
        let signs = steps.map(|h| of(turbulence, case, h, "enstrophy") > 0.0);
        if signs[0] == signs[1] && signs[1] == signs[2] { "keeps its sign" } else { "changes sign" }
    };
    consists(
        &paragraph(evidence, "The metric is part of the method.")?,
        &[
            format!(
                "makes the error at h = 0.0125 {} times that of the velocity metric",
                short(over(shear, other, OURS))
            ),
            format!("on the shear layers and {} times on turbulence.", short(over(turbulence, other, OURS))),
            format!("{} instead of {} on the shear layers", enstrophy(shear, other), enstrophy(shear, OURS)),
            format!(
                "{} instead of {} on turbulence, where with h it {} in the velocity metric and {} in that of the vorticity.",
                enstrophy(turbulence, other),
                enstrophy(turbulence, OURS),
                sign(OURS),
                sign(other)
            ),
        ],
    )?;
    let [[e0, z0], [e1, z1]] =
        FLOWS.map(|flow| ["energy_balance", "enstrophy_balance"].map(|of| short(finest(flow, OURS, of).abs())));
    consists(
        &paragraph(evidence, "Convection neither makes nor takes")?,
        &[
            format!(
                "of h = 0.0125 Method I leaves {e0} of the energy of the shear layers unaccounted for, and {z0} of"
            ),
            format!("of turbulence {e1} and {z1}."),
        ],
    )
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
    consists(
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
    )?;
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
    consists(
        &paragraph(evidence, "With h = 0.25 Method I has")?,
        &[
            early,
            later,
            format!("Method I {word} pressure correction"),
            "Courant numbers of 10 and 5, h over Δx".into(),
        ],
    )
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
                "keeps, with h = 1, {} of its size in a step of the trapezoidal rule and {} in one of Method I.",
                factor("trapezoidal", 1.0),
                factor("method-i", 1.0)
            ),
            format!(
                "With h = 100 the trapezoidal rule keeps {}, {sign}; Method I keeps {}, TR-BDF2 {} and implicit Euler {}.",
                factor("trapezoidal", 100.0),
                factor("method-i", 100.0),
                factor("tr-bdf2", 100.0),
                factor("implicit-euler", 100.0)
            ),
        ],
    )
}
