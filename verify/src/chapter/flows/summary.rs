//! The chapter in a paragraph.

use super::work::{METHODS, Runs};
use super::{
    Context, LARGE, Scale, StudyError, approach, balance, brief, cavity, contest, cvode, prose, short, times, too_long,
};
use crate::evidence::number::rounded_up;
use crate::evidence::{Check, Outcome};
use crate::experiment::flow::lid::{STEPS, StartedLid, TIMES};
use crate::experiment::flow::precision::Flow;
use crate::experiment::flow::spurious::{Refused, RestingState, Spurious};
use crate::experiment::flow::{PROJECTION, Seconds};

/// Of what was found at a scale, with its checks.
pub(super) fn told(context: &Context, checks: &[Check], scale: &Scale) -> Result<Vec<String>, StudyError> {
    let orders: Vec<&Check> = checks.iter().filter(|check| check.id.starts_with("order/")).collect();
    let [(re, _, grids), ..] = scale.steady else { return Err("no steady cavity".into()) };
    let marchi = checks.iter().find(|check| check.id == cavity::against_marchi(*re)).and_then(|check| check.measured);
    let smooth = Runs::new(context, Flow::Manufactured, scale.precision)?;
    let started = Runs::new(context, Flow::Started, scale.lid)?;
    let seconds = |runs: &Runs, own, other| {
        let [own, other] = [runs.seconds(own)?, runs.seconds(other)?].map(|seconds| seconds.unwrap_or(Seconds::NONE));
        Ok::<_, StudyError>(times(own, other))
    };
    let [shear, turbulence] = balance::over_tr_bdf2(context, scale)?;
    let in_cavity = smooth.over("tr-bdf2")?;
    let lid = context.get(StartedLid { cells: scale.lid })?;
    let ([large, _], [first, last]) = (STEPS, TIMES);
    let over = |method: &str, t: f64| {
        let error = |method: &str| lid.cases.iter().find(|case| (case.h, case.t, case.method) == (large, t, method));
        let [own, other] = [error("method-i"), error(method)].map(|case| case.map_or(f64::NAN, |case| case.error));
        brief(own / other)
    };
    const H: f64 = 100.0;
    let solves = |method| {
        let found = context.get(approach::from_rest(method, scale.approach, H))?;
        let solves = if found.is_steady() { found.solves.to_string() } else { "more than it was given".into() };
        Ok::<_, StudyError>(solves)
    };
    let rk4_held = |runs: &Runs| {
        let held = |error| format!(", whose error is {} in the longest steps in which it is stable", brief(error));
        Ok::<_, StudyError>(runs.held("rk4")?.map_or_else(String::new, held))
    };
    let too_long = || scale.too_long.last().map(too_long::steps).ok_or("no step is too long");
    let mut in_time = Vec::new();
    for method in METHODS.into_iter().filter(|method| *method != "method-i") {
        let over = started.at_the_time_of_the_longest_steps(method)?;
        in_time.push(over.map_or_else(
            || format!("unknown for `{method}`, which has no run as cheap"),
            |over| format!("{} for `{method}`", brief(over)),
        ));
    }
    let (last_in_time, in_time) = in_time.split_last().ok_or("no other method")?;
    let values = [
        ("passed", orders.iter().filter(|check| check.outcome == Outcome::Pass).count().to_string()),
        ("orders", orders.len().to_string()),
        ("cells", grids.last().ok_or("no grid")?.to_string()),
        ("marchi", marchi.map_or("an unknown distance".into(), |most| short(rounded_up(most, 4)))),
        ("re", short(*re)),
        ("tr_bdf2", contest(&[in_cavity, shear, turbulence])),
        ("smooth", brief(in_cavity)),
        ("shear", brief(shear)),
        ("turbulence", brief(turbulence)),
        ("tr_bdf2_seconds", seconds(&smooth, "method-i", "tr-bdf2")?),
        ("projection_seconds", seconds(&smooth, "method-i", PROJECTION)?),
        ("smooth_re", short(Flow::Manufactured.re())),
        ("smooth_cells", scale.precision.to_string()),
        ("rk4_seconds", seconds(&smooth, "method-i", "rk4")?),
        ("rk4_held", rk4_held(&smooth)?),
        ("lid_re", short(Flow::Started.re())),
        ("lid_cells", scale.lid.to_string()),
        ("lid_seconds", seconds(&started, "method-i", "tr-bdf2")?),
        ("lid_rule_seconds", seconds(&started, "method-i", "trapezoidal")?),
        ("lid_rk4_seconds", seconds(&started, "method-i", "rk4")?),
        ("lid_rk4_held", rk4_held(&started)?),
        ("lid_projection_seconds", seconds(&started, "method-i", PROJECTION)?),
        ("rule_seconds", seconds(&smooth, "method-i", "trapezoidal")?),
        ("cvode", cvode::in_cpu_time(context, scale)?),
        ("in_time", format!("{} and {last_in_time}", in_time.join(", "))),
        ("method_ii_seconds", seconds(&started, "method-ii", "trapezoidal")?),
        ("large", short(large)),
        ("last", short(last)),
        ("lid_first", over("tr-bdf2", first)),
        ("lid_projection", over(PROJECTION, first)),
        ("lid_last", over("tr-bdf2", last)),
        ("lid_projection_last", over(PROJECTION, last)),
        ("h", short(H)),
        ("approach_re", short(approach::from_rest("", 0, H).re)),
        ("approach_cells", scale.approach.to_string()),
        ("own_solves", solves("method-i")?),
        ("tr_bdf2_solves", solves("tr-bdf2")?),
        ("bdf2_solves", solves("bdf2")?),
        ("euler_solves", solves("implicit-euler")?),
        ("stalls", stalls(&too_long()?, &*context.get(too_long()?)?)),
        ("rests", rests(context.get(RestingState(too_long()?))?.as_ref().as_ref().map(|root| root.residual))),
    ];
    prose::fill(include_str!("summary.md"), &values)
}

/// How steps too long for their grid end.
fn stalls(Spurious { re, cells, h }: &Spurious, found: &Refused) -> String {
    let rest = short(found.residual);
    let setting = format!("with h = {h}, too long for the cavity at Re = {re} on {cells}² cells");
    match found.gradient {
        Some(_) => format!(
            "In a step {setting}, the iteration of Method I stalls at |f| = {rest}, and the library refuses that."
        ),
        None if found.message.is_empty() => format!("Steps {setting}, lead to a steady flow all the same."),
        None => format!("Steps {setting}, end at |f| = {rest}, and the library refuses that."),
    }
}

/// What is found next to that end.
fn rests(residual: Option<f64>) -> String {
    match residual {
        Some(rate) => format!("a spurious steady state with |f| = {}, which the library refuses as such", short(rate)),
        None => "no spurious steady state".into(),
    }
}

/// What only the chapter on fine grids has.
pub(super) fn finer() -> Result<Vec<String>, StudyError> {
    let ([(low, ..), beyond @ ..], [_, periodic, proportional]) = (LARGE.steady, LARGE.costs) else {
        return Err("no finer grids".into());
    };
    let list = |reynolds: Vec<f64>| reynolds.into_iter().map(short).collect::<Vec<_>>().join(" and ");
    let all: Vec<f64> = beyond.iter().map(|(re, ..)| *re).collect();
    let [marchi, botella, ghia] = cavity::of_each_table(&all)?;
    let cells = beyond.iter().map(|(_, cells, _)| *cells).max().ok_or("no finer grid")?;
    let values = [
        ("low", short(*low)),
        ("marchi", list(marchi)),
        ("botella", list(botella)),
        ("ghia", list(ghia)),
        ("cells", cells.to_string()),
        ("points", periodic.iter().chain(proportional).max().ok_or("no finer grid")?.to_string()),
    ];
    prose::fill(include_str!("finer.md"), &values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_too_long_for_their_grid_stall_or_rest_or_lead_to_a_steady_flow() {
        let told = |gradient: Option<f64>, message: &str| {
            stalls(
                &too_long::steps(&(32, 1e3)),
                &Refused { residual: 0.25, psi: None, gradient, message: message.into() },
            )
        };
        let setting = "with h = 1000, too long for the cavity at Re = 1000 on 32² cells";
        let refused = "at |f| = 0.25, and the library refuses that.";
        assert_eq!(
            told(Some(1e-8), "refused"),
            format!("In a step {setting}, the iteration of Method I stalls {refused}")
        );
        assert_eq!(told(None, "refused"), format!("Steps {setting}, end {refused}"));
        assert_eq!(told(None, ""), format!("Steps {setting}, lead to a steady flow all the same."));
    }

    #[test]
    fn a_spurious_state_is_told_where_one_is_found() {
        assert_eq!(rests(Some(0.25)), "a spurious steady state with |f| = 0.25, which the library refuses as such");
        assert_eq!(rests(None), "no spurious steady state");
    }
}
