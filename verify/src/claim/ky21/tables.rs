//! Tables 1 and 2: the oscillator from x₀ = ẋ₀ = 1 with τ = 0.1.

use std::sync::Arc;

use crate::claim::measure::{range, text};
use crate::claim::{Case, Claim, Finding, Quantifier};
use crate::evidence::{Cell, Table, number};
use crate::experiment::motion::Motion;
use crate::experiment::oscillator::{Sequence, TwoStepRun};
use crate::experiment::{Context, StudyError};
use crate::measure::norm::Extremes;
use crate::row;
use crate::theory::oscillator::PRINTED;

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "KY21-b-1",
        source: "[KY21] Table 1",
        statement: "At the five times of Table 1, on the oscillator with τ = 0.1, (16) has smaller solution errors than (17).",
        quantifier: Quantifier::General,
        criterion: "|x − x(t)| of the live schemes at t = 10, 20, 30, 40 and 50, started from x₁ = 1.0948, which the printed digits \
                    come from though the paper does not state it, and from the exact one.",
        decide: solutions,
    },
    Claim {
        id: "KY21-b-2",
        source: "[KY21] Table 1",
        statement: "At the five times of Table 1, on the oscillator with τ = 0.1, (16) has smaller energy errors than (17).",
        quantifier: Quantifier::General,
        criterion: "|E − 1| of the live schemes at t = 10, 20, 30, 40 and 50, started from x₁ = 1.0948 and from the exact one, with the \
                    velocities that the printed digits come from: the momentum for (16), a forward difference for (17).",
        decide: energies,
    },
    Claim {
        id: "KY21-c-1",
        source: "[KY21] Table 2",
        statement: "At the five times of Table 2, on the oscillator with τ = 0.1, (18) and (19) have smaller errors than (16).",
        quantifier: Quantifier::Comparison,
        criterion: "|x − x(t)| of the live schemes at the five times from x₁ = 1.0948, which the printed digits come from \
                    though the paper does not state it.",
        decide: nodes,
    },
];

/// The step of both.
pub(crate) const TAU: f64 = 0.1;
const TIMES: [usize; 5] = [10, 20, 30, 40, 50];
const STEPS: u32 = 500;
/// x₁ from which the printed digits come, the exact value rounded to four decimals: the paper does not state it.
const PRINTED_START: f64 = 1.0948;

/// Table 1: (16) solution, energy, (17) solution, energy, each at the five times.
const TABLE_1: [[f64; 5]; 4] = [
    [0.0007, 0.0019, 0.0069, 0.0116, 0.0128],
    [0.0001, 0.0000, 0.0006, 0.0011, 0.0008],
    [0.0023, 0.0086, 0.0286, 0.0472, 0.0518],
    [0.0186, 0.0339, 0.0463, 0.0116, 0.0128],
];
/// Table 2: (16) to (19).
pub(super) const TABLE_2: [[f64; 5]; 4] = [
    [7.1987e-4, 1.9163e-3, 6.9258e-3, 1.1606e-2, 1.2754e-2],
    [2.3042e-3, 8.5537e-3, 2.8618e-2, 4.7230e-2, 5.1768e-2],
    [1.3519e-4, 1.8646e-3, 5.2588e-3, 8.2132e-3, 8.6299e-3],
    [2.0468e-4, 3.4417e-4, 3.7354e-4, 2.8310e-4, 1.0158e-4],
];

fn exact(t: f64) -> f64 {
    t.cos() + t.sin()
}

/// The live two-step form of one of (16) to (19) over 500 steps.
struct Scheme(Arc<Sequence>);

impl Scheme {
    fn run(context: &Context, scheme: usize, first: f64) -> Result<Self, StudyError> {
        Ok(Self(context.get(TwoStepRun { method: PRINTED[scheme].method, tau: TAU, first, steps: STEPS })?))
    }

    fn solution_error(&self, t: usize) -> f64 {
        (self.0.x[10 * t] - exact(t as f64)).abs()
    }

    /// |E − 1| with the momentum or the forward difference for the velocity.
    fn energy_error(&self, t: usize, by_momentum: bool) -> f64 {
        let (Sequence { x, p }, k) = (&*self.0, 10 * t);
        let v = if by_momentum { p[k] } else { (x[k + 1] - x[k]) / TAU };
        (0.5 * (v * v + x[k] * x[k]) - 1.0).abs()
    }
}

/// At how many of the `STEPS` − 1 times after the start, x₀ and x₁, which is the same for both, the error of a scheme is not the smaller one.
fn behind(scheme: &Scheme, other: &Scheme) -> String {
    let error = |scheme: &Scheme, k: u32| (scheme.0.x[k as usize] - exact(TAU * f64::from(k))).abs();
    let behind = (2..=STEPS).filter(|k| error(scheme, *k) >= error(other, *k)).count();
    format!("{behind} of the {} times", STEPS - 1)
}

/// The starts with their names.
fn starts() -> [(&'static str, f64); 2] {
    [("printed", PRINTED_START), ("exact", exact(TAU))]
}

fn solutions(context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, mut ratios) = (Vec::new(), Vec::new());
    let (mut rows, mut unreproduced) = (Vec::new(), Vec::new());
    for (start, first) in starts() {
        let schemes = [Scheme::run(context, 0, first)?, Scheme::run(context, 1, first)?];
        for (column, t) in TIMES.into_iter().enumerate() {
            let [own, theirs] = [schemes[0].solution_error(t), schemes[1].solution_error(t)];
            cases.push(Case::below(format!("error of (16) at t = {t}, start {start}, against (17)"), own, theirs));
            ratios.push(theirs / own);
            for (i, scheme) in schemes.iter().enumerate() {
                let values = [("solution", scheme.solution_error(t)), ("energy", scheme.energy_error(t, i == 0))];
                for (j, (quantity, value)) in values.into_iter().enumerate() {
                    let printed = TABLE_1[2 * i + j][column];
                    rows.push(row(t, PRINTED[i].equation(), start, quantity, value, printed));
                    if start == "printed" && !reproduced("ky21-table-1", value, printed) {
                        unreproduced.push(format!("{quantity} of {} at t = {t}", PRINTED[i].equation()));
                    }
                }
            }
        }
    }
    let printed = |i: usize, column: usize| format!("{:.4}", TABLE_1[2 * i][column]);
    let evidence = format!(
        "The errors of (17) are {} times those of (16).{}",
        range(ratios.iter().copied().smallest(), ratios.iter().copied().largest()),
        note(&unreproduced, 20)
    );
    let schemes = [Scheme::run(context, 0, PRINTED_START)?, Scheme::run(context, 1, PRINTED_START)?];
    let mut finding = Finding::on(cases, evidence);
    for (i, scheme) in schemes.iter().enumerate() {
        for column in [0, TIMES.len() - 1] {
            let t = TIMES[column];
            finding = finding.beside(
                format!("{}, t = {t}", PRINTED[i].equation()),
                printed(i, column),
                scheme.solution_error(t),
            );
        }
    }
    Ok(finding
        .because(format!(
            "The phase of a step is off by −τ³/48 and −τ³/12; the start x₁ = 1.0948 adds an error of its own to both. Errors pass zero in between: \
             from that start (16) has no smaller one than (17) at {} up to t = 50.",
            behind(&schemes[0], &schemes[1])
        ))
        .with_table(reproduction("ky21-table-1", "Table 1 of [KY21]: errors, computed and printed.", rows)))
}

/// A live run from x₀ = p₀ = 1.
fn live_run(method: &str) -> Motion {
    Motion { problem: "harmonic-oscillator", method: method.into(), h: TAU, t_end: 50.0 }
}

fn energies(context: &Context) -> Result<Finding, StudyError> {
    let schemes = [Scheme::run(context, 0, PRINTED_START)?, Scheme::run(context, 1, PRINTED_START)?];
    let live = |method: &str| -> Result<Vec<f64>, StudyError> {
        let run = context.get(live_run(method))?;
        let energy = |k: usize| run.states.get(k).map(|(_, y)| (0.5 * (y[0] * y[0] + y[1] * y[1]) - 1.0).abs());
        TIMES.iter().map(|t| energy(10 * t).ok_or_else(|| "the run broke off".into())).collect()
    };
    let momenta = [live(PRINTED[0].method)?, live(PRINTED[1].method)?];
    let mut cases = Vec::new();
    for (start, first) in starts() {
        let [own, theirs] = [Scheme::run(context, 0, first)?, Scheme::run(context, 1, first)?];
        cases.extend(TIMES.map(|t| {
            let what = format!("energy error of (16) at t = {t}, start {start}, against (17)");
            Case::below(what, own.energy_error(t, true), theirs.energy_error(t, false))
        }));
    }
    let of = |scheme: usize, by_momentum: bool| TIMES.map(|t| schemes[scheme].energy_error(t, by_momentum));
    let ahead = |own: &[f64], theirs: &[f64]| own.iter().zip(theirs).filter(|(own, theirs)| own < theirs).count();
    let worst = |values: &[f64]| text(values.iter().copied().largest());
    let evidence = format!(
        "From x₁ = 1.0948 the largest errors of (16) and (17) are {} and {}.{}",
        worst(&of(0, true)),
        worst(&of(1, false)),
        copied()
    );
    let largest = |row: usize| format!("{:.4}", TABLE_1[row].into_iter().largest());
    Ok(Finding::on(cases, evidence)
        .beside("largest energy error, (16)", largest(1), of(0, true).into_iter().largest())
        .beside("largest energy error, (17)", largest(3), of(1, false).into_iter().largest())
        .because(format!(
            "The table computes the two energies from different velocities, which decide which scheme is ahead in it. A forward difference is half a step late, \
             an error of first order in τ that has nothing to do with the scheme. With forward differences for both, (16) has the smaller error at \
             {} of the {} times; with the momenta of both from x₀ = p₀ = 1, at {}: with its own momentum the midpoint rule conserves every \
             quadratic invariant, the energy of the oscillator among them, to rounding; (16) does not.",
            ahead(&of(0, false), &of(1, false)),
            TIMES.len(),
            ahead(&momenta[0], &momenta[1])
        )))
}

/// The cells of the energy errors of (17) in Table 1 that repeat the solution errors of (16), digit for digit.
fn copied() -> String {
    let [solution, .., energy] = TABLE_1;
    let repeated = TIMES.iter().zip(solution.iter().zip(&energy)).filter(|(_, (one, other))| one == other);
    let times: Vec<String> = repeated.map(|(t, _)| format!("{t}")).collect();
    if times.is_empty() {
        return String::new();
    }
    format!(
        " At t = {} the table prints for the energy errors of (17) the digits of the solution errors of (16), which its runs do \
         not give: apparently a slip in copying.",
        times.join(" and ")
    )
}

fn nodes(context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, mut rows, mut unreproduced) = (Vec::new(), Vec::new(), Vec::new());
    let (mut orderly, mut at_10, mut behind_16) = (true, [0.0; 4], [String::new(), String::new()]);
    for (start, first) in starts() {
        let schemes = (0..4).map(|scheme| Scheme::run(context, scheme, first)).collect::<Result<Vec<_>, _>>()?;
        if start == "printed" {
            behind_16 = [2, 3].map(|scheme: usize| behind(&schemes[scheme], &schemes[0]));
        }
        for (column, t) in TIMES.into_iter().enumerate() {
            let error = |scheme: usize| schemes[scheme].solution_error(t);
            if start == "printed" {
                let against = |name: &str, scheme| {
                    Case::below(format!("error of {name} at t = {t}, against (16)"), error(scheme), error(0))
                };
                cases.extend([against("(18)", 2), against("(19)", 3)].map(|case| case.against("(16)")));
            } else {
                orderly &= error(2) < error(0) && error(3) < error(2);
            }
            for (scheme, printed) in TABLE_2.iter().enumerate() {
                let (value, printed) = (error(scheme), printed[column]);
                rows.push(row(t, PRINTED[scheme].equation(), start, "solution", value, printed));
                if start == "printed" && column == 0 {
                    at_10[scheme] = value;
                }
                if start == "printed" && !reproduced("ky21-table-2", value, printed) {
                    unreproduced.push(format!("{} at t = {t}", PRINTED[scheme].equation()));
                }
            }
        }
    }
    let run = context.get(live_run(PRINTED[3].method))?;
    let local = run.states.get(1).map_or(f64::NAN, |(t, q)| (q[0] - exact(*t)).abs());
    let evidence = format!(
        "From the x₁ of the printed digits the errors at t = 10 are {} (16), {} (18) and {} (19).{}",
        text(at_10[0]),
        text(at_10[2]),
        text(at_10[3]),
        note(&unreproduced, 20)
    );
    let mut finding = Finding::on(cases, evidence);
    for (scheme, here) in at_10.into_iter().enumerate() {
        finding = finding.beside(
            format!("{}, t = 10", PRINTED[scheme].equation()),
            number::digits(TABLE_2[scheme][0], 5),
            here,
        );
    }
    let from_exact = if orderly {
        "falling in this order at every time of the table"
    } else {
        "not falling in this order at every time of the table"
    };
    Ok(finding
        .because(format!(
            "That (19) errs less than (18) is not claimed, and at t = 10 it does not: the start x₁ = 1.0948 is off by {}, more than the \
             error of x after one step in position–momentum form, {}, and the column of (19) shows the rounding of x₁. From the exact x₁ the errors of (16), (18) and (19) are {from_exact}. (18) is of second order like (16), with a smaller \
             constant; see KY21-c-2. Errors pass zero in between: from x₁ = 1.0948 (18) has no smaller one than (16) at {}, and (19) at {}, up to t = 50.",
            text((PRINTED_START - exact(TAU)).abs()),
            text(local),
            behind_16[0],
            behind_16[1]
        ))
        .with_table(reproduction("ky21-table-2", "Table 2 of [KY21]: errors of the solution, computed and printed.", rows)))
}

fn row(t: usize, scheme: &str, start: &str, quantity: &str, value: f64, printed: f64) -> Vec<Cell> {
    row![t, scheme, start, quantity, value, (start == "printed").then_some(printed)]
}

fn reproduction(id: &str, caption: &str, rows: Vec<Vec<Cell>>) -> Table {
    Table::new(id, caption, ["t", "scheme", "start", "quantity", "value", "printed"], rows)
}

/// Which printed cells are not reproduced.
fn note(unreproduced: &[String], of: usize) -> String {
    match unreproduced {
        [] => format!(" All {of} printed numbers are reproduced."),
        cells => format!(" Of the {of} printed numbers {} are not reproduced: {}.", cells.len(), cells.join(", ")),
    }
}

/// Whether a number rounds to the one printed.
pub(crate) fn reproduced(table: &str, value: f64, printed: f64) -> bool {
    (value - printed).abs() <= half_unit(table, printed)
}

/// Half a unit of the last printed place: four decimals in Table 1, five digits in Table 2.
pub(crate) fn half_unit(table: &str, printed: f64) -> f64 {
    if table == "ky21-table-1" { 0.5e-4 } else { 0.5 * 10_f64.powf(printed.log10().floor() - 4.0) * (1.0 + 1e-9) }
}
