//! The chapter in a paragraph.

use super::work::Runs;
use super::{Context, Scale, StudyError, approach, balance, brief, cavity, contest, measured, prose, short};
use crate::evidence::{Check, Outcome};
use crate::experiment::flow::lid::{STEPS, StartedLid, TIMES};
use crate::experiment::flow::precision::Flow;
use crate::experiment::flow::{PROJECTION, Seconds};

/// Of what was found at a scale, with its checks.
pub(super) fn told(context: &Context, checks: &[Check], scale: &Scale) -> Result<Vec<String>, StudyError> {
    let orders: Vec<&Check> = checks.iter().filter(|check| check.id.starts_with("order/")).collect();
    let [(re, cells, _), ..] = scale.steady else { return Err("no steady cavity".into()) };
    let ghia = checks.iter().find(|check| check.id == cavity::against_ghia(*re)).and_then(|check| check.measured);
    let smooth = Runs::new(context, Flow::Manufactured, scale.precision)?;
    let started = Runs::new(context, Flow::Started, scale.lid)?;
    let seconds = |runs: &Runs, own, other| {
        let [own, other] = [runs.seconds(own)?, runs.seconds(other)?].map(|seconds| seconds.unwrap_or(Seconds::NONE));
        Ok::<_, StudyError>(measured(own.over(other)))
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
    let spurious = || scale.spurious.last().map(|h| approach::too_long(*h)).ok_or("no step is too long");
    let values = [
        ("passed", orders.iter().filter(|check| check.outcome == Outcome::Pass).count().to_string()),
        ("orders", orders.len().to_string()),
        ("cells", cells.to_string()),
        ("ghia", ghia.map_or("an unknown distance".into(), short)),
        ("re", short(*re)),
        ("tr_bdf2", contest(&[in_cavity, shear, turbulence])),
        ("smooth", brief(in_cavity)),
        ("shear", brief(shear)),
        ("turbulence", brief(turbulence)),
        ("tr_bdf2_seconds", seconds(&smooth, "method-i", "tr-bdf2")?),
        ("projection_seconds", seconds(&smooth, "method-i", PROJECTION)?),
        ("rk4_seconds", seconds(&smooth, "method-i", "rk4")?),
        ("lid_seconds", seconds(&started, "method-i", "tr-bdf2")?),
        ("method_ii_seconds", seconds(&started, "method-ii", "trapezoidal")?),
        ("large", short(large)),
        ("last", short(last)),
        ("lid_first", over("tr-bdf2", first)),
        ("lid_projection", over(PROJECTION, first)),
        ("lid_last", over("tr-bdf2", last)),
        ("lid_projection_last", over(PROJECTION, last)),
        ("h", short(H)),
        ("own_solves", solves("method-i")?),
        ("tr_bdf2_solves", solves("tr-bdf2")?),
        ("bdf2_solves", solves("bdf2")?),
        ("euler_solves", solves("implicit-euler")?),
        ("spurious_re", short(spurious()?.re)),
        ("spurious_cells", spurious()?.cells.to_string()),
        ("spurious_h", short(spurious()?.h)),
        ("rest", short(context.get(spurious()?)?.residual)),
    ];
    prose::fill(include_str!("summary.md"), &values)
}
