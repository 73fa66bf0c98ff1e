//! The integrators on the harmonic oscillator: recurrences in closed form, and intervals of stability.

use super::{Context, Study, StudyError, prose};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Series, Table};
use crate::experiment::motion::Motion;
use crate::experiment::oscillator::{Stable, StepMap, TwoStepRun};
use crate::kinds::{Stability, Symplecticity};
use crate::measure::norm::{Extremes, larger, max_norm};
use crate::method::{self, Method};
use crate::row;
use crate::theory::oscillator::{PRINTED, RECURRENCES, Recurrence};

pub(super) const STUDY: Study = Study {
    id: "oscillator",
    title: "The harmonic oscillator: recurrences and stability",
    question: "Are the recurrences of the paper those of the general machinery, and up to which step is each method stable?",
    source: "[KY21] (16)–(19)",
    run,
};

/// Step sizes at which live runs are held against the recurrences, as far as they are stable there.
const TAUS: [f64; 8] = [0.05, 0.1, 0.3, 0.7, 1.0, 1.5, 2.0, 2.5];

const STEPS: u32 = 200;

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let all = method::integrators();
    let mut evidence = Evidence { notes: prose::fill(include_str!("oscillator.md"), &[])?, ..Evidence::default() };
    recurrences(&mut evidence, context)?;
    stability(&mut evidence, context, &all)?;
    motion(&mut evidence, context)?;
    traces(&mut evidence, context, &all)?;
    Ok(evidence)
}

/// Every step of live two-step runs is that of the recurrence.
fn recurrences(evidence: &mut Evidence, context: &Context) -> Result<(), StudyError> {
    let mut rows = Vec::new();
    for known in RECURRENCES {
        let Recurrence { method, source, .. } = *known;
        let mut worst = Vec::new();
        for tau in TAUS.into_iter().filter(|tau| known.trace(*tau).abs() < 2.0) {
            let run = TwoStepRun { method, tau, first: tau.cos() + tau.sin(), steps: STEPS };
            let live = context.get(run)?;
            let defects = live.x.windows(3).map(|x| (x[2] - known.trace(tau) * x[1] + x[0]).abs());
            let (defect, bound) = (defects.largest(), run.rounding(max_norm(&live.x[2..]))?);
            worst.push(defect / bound);
            rows.push(row![method, source, tau, defect, bound]);
        }
        evidence.checks.push(Check::at_most(
            format!("recurrence/{method}"),
            format!(
                "Every step of {STEPS} of the two-step form of {method} is the recurrence {source}, for all stable τ"
            ),
            worst.into_iter().largest(),
            1.0,
            "defect over its rounding: ε |x| times the sum of squares of the coefficients in the momentum",
        ));
    }
    evidence.tables.push(Table::new(
        "oscillator-recurrences",
        format!("Largest |xₖ₊₁ − R(τ) xₖ + xₖ₋₁| of {STEPS} live steps of the two-step form, and its rounding."),
        ["method", "recurrence", "tau", "defect", "bound"],
        rows,
    ));
    Ok(())
}

/// The intervals of stability.
fn stability(evidence: &mut Evidence, context: &Context, all: &[Box<dyn Method>]) -> Result<(), StudyError> {
    let found = context.get_each(all.iter().map(|method| Stable { method: method.name() }).collect())?;
    let mut rows = Vec::new();
    for (method, intervals) in all.iter().map(|method| method.name()).zip(found) {
        evidence.checks.extend(Recurrence::of(&method).map(|known| boundaries(known, &intervals)));
        rows.extend(intervals.iter().enumerate().map(|(i, (from, to))| {
            let end = if *to < Stable::LARGEST { Cell::Number(*to) } else { Cell::Empty };
            row![&method, i + 1, *from, end]
        }));
    }
    let caption = format!(
        "Intervals of τ = ωh in which the integrators are stable on the oscillator, |R(τ)| ≤ 2, up to τ = {}; an interval \
         without an end goes on beyond.",
        Stable::LARGEST
    );
    let columns = ["method", "interval", "from", "to"];
    evidence.tables.push(Table::new("oscillator-stability", caption, columns, rows));
    let mut excess = Vec::new();
    for method in all.iter().filter(|method| method.stability() == Stability::Neutral) {
        for tau in [0.1, 1.0, 3.0, 10.0, 1e2, 1e3] {
            excess.push(context.get(StepMap { method: method.name(), tau })?.trace.abs() - 2.0);
        }
    }
    evidence.checks.push(Check::at_most(
        "stability/unconditional",
        "The midpoint rule and the Galerkin integrators on Gauss nodes are stable for every τ, up to 1000",
        larger(0.0, excess.into_iter().largest()),
        64.0 * f64::EPSILON,
        "|R| − 2: they are Gauss collocation, with R = 2 cos θ; the trace has some sixty roundings",
    ));
    Ok(())
}

/// The ends of the intervals are those of |R| ≤ 2 of the closed form.
fn boundaries(known: &Recurrence, intervals: &[(f64, f64)]) -> Check {
    let Recurrence { method, source, .. } = known;
    let is_inside = |tau: f64| intervals.iter().any(|(from, to)| (*from..=*to).contains(&tau));
    // Away from the boundaries the two agree on every τ; at them R itself says how far.
    let wrong = (1..=6000).map(|i| f64::from(i) * 0.002 - 1e-3).filter(|tau| {
        let excess = known.trace(*tau).abs() - 2.0;
        excess.abs() > 1e-9 && is_inside(*tau) != (excess < 0.0)
    });
    Check::at_most(
        format!("stability/{method}"),
        format!("The intervals of stability of {method} are those in which {source} has |R| ≤ 2, at 6000 values of τ"),
        wrong.count() as f64,
        0.0,
        "number of τ at which the two disagree",
    )
}

/// Solution and energies as in Figs 1 and 2 of [KY21]: τ = 0.1 from x₀ = ẋ₀ = 1.
fn motion(evidence: &mut Evidence, context: &Context) -> Result<(), StudyError> {
    const TAU: f64 = 0.1;
    let mut rows = Vec::new();
    for known in PRINTED {
        let run = Motion { problem: "harmonic-oscillator", method: known.method.into(), h: TAU, t_end: 50.0 };
        let energy = |q: &[f64]| 0.5 * (q[0] * q[0] + q[1] * q[1]);
        let run = context.get(run)?;
        rows.extend(run.states.iter().map(|(t, q)| row![known.equation(), *t, q[0], q[1], energy(q) - 1.0]));
    }
    let caption = "Solutions of (16)–(19) on the oscillator, and their energies less the exact one.";
    let table = Table::data("oscillator-motion", caption, ["scheme", "t", "x", "p", "energy_error"], rows);
    let energies = table.curves("scheme", "t", "energy_error", Mark::Line);
    let mut solution = table.curves("scheme", "t", "x", Mark::Line).swap_remove(0);
    solution.points.retain(|(t, _)| *t <= 20.0);
    let exact = solution.points.iter().map(|(t, _)| (*t, t.cos() + t.sin())).collect();
    let solutions = vec![solution, Series::new("exact", exact, Mark::Guide)];
    let panel = |title: &str, y: &str, series| Panel::new(Axis::linear("t"), Axis::linear(y), series).titled(title);
    let caption = format!(
        "The oscillator with τ = {TAU} from x₀ = ẋ₀ = 1: the solution of (16) and the error of the energy, with the momenta \
         of the schemes for the velocity (Figs 1 and 2 of [KY21]). It stays bounded; (17) has none but rounding."
    );
    let panels = [panel("Solution", "x", solutions), panel("Energy", "E − 1", energies)];
    evidence.figures.push(Figure::new("oscillator-motion", caption, "oscillator-motion", panels).in_columns(2));
    evidence.tables.push(table);
    Ok(())
}

/// Path fitting of the lowest degrees and on both sorts of nodes, and of the others what is stable for all τ and what is not.
pub(super) const TOLD: [&str; 8] = [
    "path-fitted(2)",
    "path-fitted(3)",
    "path-fitted(4)",
    "path-fitted(4,gauss)",
    "midpoint-vi",
    "stormer-verlet",
    "galerkin-gauss(2)",
    "galerkin-lobatto(2)",
];

/// R(τ), and determinants of 1.
fn traces(evidence: &mut Evidence, context: &Context, all: &[Box<dyn Method>]) -> Result<(), StudyError> {
    const LAST: f64 = 8.0;
    let taus: Vec<f64> = (1..=200).map(|i| f64::from(i) * 0.04).collect();
    let (mut rows, mut determinants) = (Vec::new(), Vec::new());
    for method in all.iter().map(|method| method.name()) {
        for tau in &taus {
            let map = context.get(StepMap { method: method.clone(), tau: *tau })?;
            determinants.push((map.determinant - 1.0).abs() / map.rounding);
            rows.push(row![&method, *tau, map.trace]);
        }
    }
    evidence.checks.push(Check::at_most(
        "determinant",
        format!("The map of every integrator has determinant 1, for {} values of τ up to {LAST}", taus.len()),
        determinants.into_iter().largest(),
        1.0,
        "deviation over its rounding",
    ));
    let columns = ["method", "tau", "trace"];
    let table = Table::data("oscillator-trace", "R(τ), the trace of the derivative of one step.", columns, rows);
    let curves = table.curves("method", "tau", "trace", Mark::Line);
    // Path-fitted integrators alone have no discrete Lagrangian.
    let is_fitted =
        |curve: &&Series| all.iter().any(|m| m.name() == curve.label && m.traits().symplectic != Symplecticity::Always);
    let (fitted, others): (Vec<&Series>, Vec<&Series>) = curves.iter().partition(is_fitted);
    let panel = |title: &str, series: Vec<&Series>| {
        let mut series: Vec<Series> = series.into_iter().cloned().collect();
        let exact = [0.0].iter().chain(&taus).map(|tau| (*tau, 2.0 * tau.cos())).collect();
        series.push(Series::new("exact: 2 cos τ", exact, Mark::Guide));
        for level in [-2.0, 2.0] {
            series.push(Series::new(format!("R = {level}"), vec![(0.0, level), (LAST, level)], Mark::Guide));
        }
        let (x, y) = (Axis::linear("τ = ωh").between(0.0, LAST), Axis::linear("R(τ)").between(-4.0, 4.0));
        Panel::new(x, y, series).titled(title)
    };
    let panels = [panel("Path fitting", fitted), panel("Classical and Galerkin", others)];
    let caption = "R(τ) of the recurrences; a method is stable where |R| ≤ 2. The exact R is 2 cos τ.";
    let figure = Figure::new("oscillator-trace", caption, table.id.clone(), panels).in_columns(2);
    evidence.figures.push(figure.telling(&TOLD));
    evidence.tables.push(table);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::Outcome;

    /// 2 − τ² of Störmer and Verlet is −2 at τ = 2. The values of τ are 0.002 apart.
    #[test]
    fn an_interval_that_ends_beside_the_boundary_is_noticed() {
        let known = Recurrence::of("stormer-verlet").expect("known");
        let outcome = |ends: &[(f64, f64)]| boundaries(known, ends).outcome;
        assert_eq!(outcome(&[(0.0, 2.0)]), Outcome::Pass);
        for ends in [&[(0.0, 1.995)][..], &[(0.0, 2.005)], &[(0.0, 2.0), (11.0, 11.005)], &[]] {
            assert_eq!(outcome(ends), Outcome::Fail, "{ends:?}");
        }
    }
}
