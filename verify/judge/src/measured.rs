//! Runs of a method that come as a file, against what its coefficients promise.

use rayon::prelude::*;

use super::analysis::{Analysis, Plan, Trial};
use super::method::FileMethod;
use super::verdict::{Kind, Verdict};
use evidence::{Check, Outcome, Requirement, number};
use experiments::experiment::energy_drift::{self as drift, Drift};
use experiments::kinds::Symplecticity;
use experiments::measure::decimal::uncertain;
use experiments::measure::norm::{Extremes, max_norm};
use experiments::measure::order::{self, OrderFit, Sample};
use experiments::method::Traits;
use experiments::order::{Ladder, OrderError, Source, measure_on};
use experiments::problem::{self, Problem};
use experiments::run::{run, step_from};

/// A measured order, or why there is none.
#[derive(Debug)]
pub struct MeasuredOrder {
    /// What kind of problem it is: linear, nonlinear, non-autonomous, stiff.
    pub kind: &'static str,
    /// The problem.
    pub problem: &'static str,
    /// Where theory has its order from, or why it has none.
    pub from: &'static str,
    /// The order that theory gives there, and from which conditions.
    pub expected: Option<(f64, &'static str)>,
    /// The fit.
    pub result: Result<OrderFit, String>,
}

/// Number of steps of a ladder that goes on where that of a plan ends too soon.
const FINER: usize = 18;

impl MeasuredOrder {
    /// Theory and measurement agree, or they do not; nothing where theory has no order and one is measured.
    pub fn verdict(&self) -> Option<Verdict> {
        let (outcome, reason) = match (&self.result, self.expected) {
            (Ok(fit), Some((_, from))) => {
                let outcome = if fit.is_of_digits { Outcome::NotSettled } else { fit.verdict.into() };
                (outcome, format!("{}, from {from}", fit.reason))
            }
            (Ok(_), None) => return None,
            (Err(reason), _) => (Outcome::NotRun, reason.clone()),
        };
        let fit = self.result.as_ref().ok();
        let check = Check {
            id: format!("measured/{}", self.kind),
            statement: format!("On {}, {}, the order measured is that of theory", self.problem, self.kind),
            outcome,
            measured: fit.and_then(|fit| fit.line).map(|line| line.slope),
            required: fit.map(|fit| Requirement::Near(fit.expected.order, fit.expected.band)),
            reason,
        };
        Some(Verdict { kind: Kind::Run, subject: self.kind.into(), check })
    }

    /// What was measured where theory has no order.
    pub(super) fn fact(&self) -> Option<(&'static str, String)> {
        let fit = self.result.as_ref().ok().filter(|_| self.expected.is_none())?;
        let told = match (fit.verdict, fit.line) {
            (order::Verdict::Measured, Some(line)) => format!("order {}", uncertain(line.slope, line.stderr)),
            _ => format!("no order ({})", fit.reason),
        };
        Some((self.kind, format!("{told} on {}, where theory has none: {}", self.problem, self.from)))
    }
}

/// The orders of `method` where its theory has them measured.
pub fn orders(method: &FileMethod, theory: &dyn Analysis) -> Vec<MeasuredOrder> {
    let run = |Trial { kind, name, plan }: Trial| {
        let from = plan.as_ref().map_or("", |plan| plan.from);
        let measured = plan.and_then(|Plan { problem, longer, order, .. }| {
            let method = order.map_or_else(|| method.unexpected(), |order| method.expected(order));
            let fit = match order {
                Some(_) => settled(&method, &*problem, &longer),
                None => fit(&method, &*problem, None),
            };
            let fit = fit.map_err(|error| error.to_string())?;
            Ok(match order {
                Some(order) => (true, hidden(theory, order, &fit).unwrap_or_else(|| fit.of_equations_in_general())),
                None => (false, freely(&fit)),
            })
        });
        let expected = measured.as_ref().ok().filter(|(known, _)| *known).map(|(_, fit)| (fit.expected.order, from));
        MeasuredOrder { kind, problem: name, from, expected, result: measured.map(|(_, fit)| fit) }
    };
    theory.trials().into_par_iter().map(run).collect()
}

/// The fit on `problem`, or where that decides nothing the first over a longer time that does.
fn settled(method: &FileMethod, problem: &dyn Problem, longer: &[Box<dyn Problem>]) -> Result<OrderFit, OrderError> {
    let first = refined(method, problem)?;
    if first.verdict != order::Verdict::Inconclusive {
        return Ok(first);
    }
    let later = longer.iter().find_map(|problem| {
        let mut fit = refined(method, &**problem).ok().filter(|fit| fit.verdict != order::Verdict::Inconclusive)?;
        fit.reason += &format!(", up to t = {}", problem.facts().window.horizon);
        Some(fit)
    });
    Ok(later.unwrap_or(first))
}

/// The fit with finer steps where the usual ones end before the slopes settle.
fn refined(method: &FileMethod, problem: &dyn Problem) -> Result<OrderFit, OrderError> {
    let usual = fit(method, problem, None)?;
    if usual.wants_finer() { fit(method, problem, Some(FINER)) } else { Ok(usual) }
}

/// The fit on a ladder of so many steps, or on the usual one.
fn fit(method: &FileMethod, problem: &dyn Problem, points: Option<usize>) -> Result<OrderFit, OrderError> {
    let truth = Source::default_for(problem, method).truth(problem, method);
    measure_on(problem, method, truth, &Ladder { points, ..Ladder::default() })
}

/// The fit where the error term of the order that theory has is too small to show, as after a misprint in the last of many digits: its
/// constant times h^p is less than a tenth of the error at every step, and the errors, of terms of higher order, fall faster.
fn hidden(theory: &dyn Analysis, order: u32, fit: &OrderFit) -> Option<OrderFit> {
    let main = &theory.as_runge_kutta()?.main;
    let constant = main.error_norm.filter(|_| main.order == order && fit.verdict != order::Verdict::Pass)?;
    let is_below = |sample: &Sample| {
        constant * sample.h.powi(order as i32) < 0.1 * sample.result.as_ref().map_or(0.0, |measured| measured.error)
    };
    let falls_faster = fit.line.is_some_and(|line| line.slope > f64::from(order));
    if !falls_faster || !fit.kept.iter().all(is_below) {
        return None;
    }
    let mut fit = fit.clone();
    fit.verdict = order::Verdict::Inconclusive;
    fit.reason +=
        &format!("; the error term of order {order} has the constant {constant:.1e}, and does not show at these steps");
    Some(fit)
}

/// The same errors without an order that they should have.
fn freely(fit: &OrderFit) -> OrderFit {
    let samples: Vec<_> = fit.kept.iter().chain(fit.dropped.iter().map(|(sample, _)| sample)).cloned().collect();
    order::fit_freely(&samples, fit.expected.band)
}

/// Step of the measured defects: large, so that what is no symmetry is far above roundoff.
const STEP: f64 = 0.5;
/// Spacing of the differences that give the derivative of a step; their error is of its fourth power.
const SPACING: f64 = 1e-3;
/// What a defect that vanishes can be measured as: roundoff over the spacing, and the fourth power of the spacing times a
/// fifth derivative of the step, each with two digits to spare.
const VANISHES: f64 = 1e-10;

/// How far a coefficient is moved to see what its rounding does: far above roundoff, and little enough for that to be proportional to it.
const MOVED: f64 = 1e-6;

/// Defects of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Defects {
    /// ‖Mᵀ J M − J‖ of a step's derivative M on Hénon and Heiles' problem.
    pub symplectic: f64,
    /// |Φ_{−h}(Φ_h(y)) − y| there.
    pub symmetric: f64,
    /// How far the rounding of the coefficients leaves each of them open.
    pub(super) open: [f64; 2],
}

/// The defects of one step of `method`.
///
/// # Errors
/// What made a step fail.
pub fn defects(method: &FileMethod) -> Result<Defects, String> {
    let problem = problem::build("henon-heiles", &[]).map_err(|error| error.to_string())?;
    let found = deviations(&*problem, method)?;
    // What half a unit in the last place of each coefficient adds to an entry, of whatever signs these units are.
    let mut changes = found.each_ref().map(|entries| vec![0.0; entries.len()]);
    for (radius, moved) in method.moved(MOVED) {
        for ((sums, before), after) in changes.iter_mut().zip(&found).zip(deviations(&*problem, &moved)?) {
            for ((sum, before), after) in sums.iter_mut().zip(before).zip(after) {
                *sum += radius / MOVED * (after - before).abs();
            }
        }
    }
    let [symplectic, symmetric] = found.each_ref().map(|entries| max_norm(entries));
    Ok(Defects { symplectic, symmetric, open: changes.each_ref().map(|sums| max_norm(sums)) })
}

/// The entries of Mᵀ J M − J for a step's derivative M, and Φ_{−h}(Φ_h(y)) − y, which is y with its momenta reversed.
fn deviations(problem: &dyn Problem, method: &FileMethod) -> Result<[Vec<f64>; 2], String> {
    let y = problem.initial();
    let forward = |y: &[f64]| step_from(problem, y.to_vec(), method, STEP).map_err(|error| error.to_string());
    let n = y.len();
    // The motion is reversible: with the momenta reversed, a step is one of −h.
    let reversed = |mut y: Vec<f64>| {
        y[n / 2..].iter_mut().for_each(|p| *p = -*p);
        y
    };
    let back = reversed(forward(&reversed(forward(&y)?))?);
    let symmetric = back.iter().zip(&y).map(|(back, y)| back - y).collect();
    let mut columns = Vec::new();
    for j in 0..n {
        let at = |k: f64| {
            let mut shifted = y.clone();
            shifted[j] += k * SPACING;
            forward(&shifted)
        };
        let [far_left, left, right, far_right] = [at(-2.0)?, at(-1.0)?, at(1.0)?, at(2.0)?];
        let entry = |i: usize| (8.0 * (right[i] - left[i]) - (far_right[i] - far_left[i])) / (12.0 * SPACING);
        columns.push((0..n).map(entry).collect::<Vec<f64>>());
    }
    // ω(x, y) = Σ x_k y_{k+m} − x_{k+m} y_k, coordinates before momenta.
    let m = n / 2;
    let omega = |x: &[f64], y: &[f64]| (0..m).map(|k| x[k] * y[k + m] - x[k + m] * y[k]).sum::<f64>();
    let mut symplectic = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let required = if j == i + m {
                1.0
            } else if i == j + m {
                -1.0
            } else {
                0.0
            };
            symplectic.push(omega(&columns[i], &columns[j]) - required);
        }
    }
    Ok([symplectic, symmetric])
}

impl Defects {
    /// What the conditions on the coefficients say, held to the measured defects.
    pub fn verdicts(&self, traits: &Traits) -> [Verdict; 2] {
        let verdict = |name: &str, what: &str, by_condition: bool, defect: f64, open: f64| {
            let most = number::rounded_up(VANISHES + open, 2);
            let (says, required) = match by_condition {
                true => ("vanishes, as the coefficients say", Requirement::AtMost(VANISHES)),
                false => ("does not vanish, as the coefficients say", Requirement::Above(most)),
            };
            // A defect of high order can be small without vanishing; one that should vanish cannot be large, but for what the rounding of
            // the coefficients makes of it.
            let outcome = match by_condition {
                _ if open.is_nan() => Outcome::Inconclusive,
                true if defect <= VANISHES => Outcome::Pass,
                false if defect <= VANISHES => Outcome::Inconclusive,
                _ if defect <= most => Outcome::NotSettled,
                false if defect > most => Outcome::Pass,
                _ => Outcome::Fail,
            };
            let told = match outcome {
                Outcome::Pass => format!(", {required}"),
                Outcome::NotSettled => format!(", and the rounding of the coefficients leaves {open:.1e} of it open"),
                Outcome::Fail if open > VANISHES => {
                    format!(", which is to be {required}, and the rounding of the coefficients makes {open:.1e} of it")
                }
                _ => format!(", which is to be {required}"),
            };
            let check = Check {
                id: format!("measured/{name}"),
                statement: format!("The defect of {what} of a step {says}"),
                outcome,
                measured: Some(defect),
                required: Some(required),
                reason: format!("a step of h = {STEP} on `henon-heiles` has the defect {defect:.1e}{told}"),
            };
            let subject = if by_condition { name.into() } else { format!("not {name}") };
            Verdict { kind: Kind::Run, subject, check }
        };
        let [of_symplectic, of_symmetric] = self.open;
        let is_symplectic = traits.symplectic != Symplecticity::Never;
        [
            verdict("symplectic", "symplecticity", is_symplectic, self.symplectic, of_symplectic),
            verdict("symmetric", "symmetry", traits.is_reversible, self.symmetric, of_symmetric),
        ]
    }
}

/// Long runs: on a quasi-periodic orbit that a reversal of time maps to itself.
const LONG: (&str, f64, u64) = ("henon-heiles", 0.25, 4000);

/// Times as many steps of a run that is to confirm a drift.
const LONGER: u64 = 4;

/// States of a long run from which a step is looked at.
const STATES: u64 = 16;

/// The energy in a long run.
#[derive(Debug)]
pub(super) struct Energy {
    drift: Drift,
    /// How far the rounding of the coefficients leaves the drift open.
    open: f64,
}

/// The drift of the energy of `method`.
///
/// # Errors
/// Why the run failed.
pub(super) fn energy(method: &FileMethod) -> Result<Energy, String> {
    let (name, h, steps) = LONG;
    let problem = problem::build(name, &[]).map_err(|error| error.to_string())?;
    let breaks_off =
        |error: String| format!("the run of h = {h} on {name} breaks off, so that its drift is not told: {error}");
    let of = |steps: u64| Drift::of((name, &*problem), method, h, steps).map_err(|error| breaks_off(error.to_string()));
    let mut drift = of(steps)?;
    // The means of an oscillation may lie on a line once; a drift is there in a longer run as well.
    if drift.kind != drift::Kind::Dissipative && drift.drift > drift.resolved() {
        drift = of(LONGER * steps)?;
    }
    let open = open_drift(&*problem, method, h, drift.steps).map_err(breaks_off)?;
    Ok(Energy { drift, open })
}

/// How far the energy may drift in `steps` steps by the rounding of the coefficients: in each of them by what half a unit in the last place of
/// each coefficient does to it at most, of whatever signs these units are.
fn open_drift(problem: &dyn Problem, method: &FileMethod, h: f64, steps: u64) -> Result<f64, String> {
    let moved = method.moved(MOVED);
    let Some(energy) = problem.invariants().into_iter().find(|i| i.name == "energy").filter(|_| !moved.is_empty())
    else {
        return Ok(0.0);
    };
    let (mut states, mut n) = (Vec::new(), 0_u64);
    run(problem, method, h, h * steps as f64, |state| {
        if n.is_multiple_of(steps / STATES) {
            states.push(state.q.clone());
        }
        n += 1;
    })
    .map_err(|error| error.to_string())?;
    let after = |method: &FileMethod, state: &Vec<f64>| {
        let end = step_from(problem, state.clone(), method, h).map_err(|error| error.to_string())?;
        Ok::<f64, String>(energy.value(&end))
    };
    let in_a_step = |state: &Vec<f64>| {
        let right = after(method, state)?;
        let by = |(radius, moved): &(f64, FileMethod)| Ok(radius / MOVED * (after(moved, state)? - right).abs());
        moved.iter().map(by).sum::<Result<f64, String>>()
    };
    let largest = states.par_iter().map(in_a_step).collect::<Result<Vec<f64>, String>>()?.into_iter().largest();
    Ok(steps as f64 * largest)
}

/// What is symplectic or symmetric does not drift there, and what is neither has to.
pub(super) fn energy_verdict(found: Result<Result<Energy, String>, String>) -> Verdict {
    let (name, h, _) = LONG;
    let check = match found {
        Ok(Ok(Energy { drift, open })) => {
            let keeps = drift.kind != drift::Kind::Dissipative;
            let steps = drift.steps;
            let statement = match keeps {
                true => format!("The energy does not drift on {name}: it is symplectic or symmetric"),
                false => format!("The energy drifts on {name}: it is neither symplectic nor symmetric"),
            };
            let one_way = drift.one_way().filter(|_| !keeps);
            let (moved, least) = one_way.map_or((drift.drift, drift.resolved()), |moved| (moved, drift.rounding));
            let is_resolved = moved > least;
            let is_of_digits = is_resolved && moved <= least + open;
            let outcome = match (keeps, is_resolved) {
                _ if [moved, least, open].iter().any(|x| x.is_nan()) => Outcome::Inconclusive,
                _ if is_of_digits => Outcome::NotSettled,
                (true, resolved) => (!resolved).into(),
                (false, true) => Outcome::Pass,
                // A slow drift hides in the oscillation, where it is not absent.
                (false, false) => Outcome::NotSettled,
            };
            let measured = moved;
            let required = if keeps { Requirement::AtMost(least) } else { Requirement::Above(least + open) };
            let [moved, least, largest] = [moved, least, drift.largest()].map(|x| format!("{x:.1e}"));
            let told = match outcome {
                Outcome::Inconclusive => "how far it drifts is not told".to_owned(),
                _ if is_of_digits => {
                    format!("it drifts by {moved}, and the rounding of the coefficients leaves {open:.1e} of that open")
                }
                _ if one_way.is_some() => format!("it goes one way in all parts of the run, by {moved}"),
                _ if is_resolved => {
                    format!("it drifts by {moved}, more than the {least} that can be told from its oscillation")
                }
                _ if keeps => format!("no drift is seen; one of {least} would be"),
                _ => format!("a drift, which there should be, is too slow to be seen: one of {least} would be"),
            };
            let reason = format!("{told}; in {steps} steps of h = {h} on {name} its error is {largest} at most");
            let (measured, required) = (Some(measured), Some(required));
            Check { id: "measured/energy".into(), statement, outcome, measured, required, reason }
        }
        Ok(Err(reason)) | Err(reason) => Check {
            id: "measured/energy".into(),
            statement: format!("The energy of a long run on {name} is looked at"),
            outcome: Outcome::NotRun,
            measured: None,
            required: None,
            reason,
        },
    };
    Verdict { kind: Kind::Run, subject: "energy".into(), check }
}

#[cfg(test)]
mod tests {
    use super::*;
    use experiments::experiment::energy_drift::Window;
    use experiments::kinds::{Principle, Stability};
    use experiments::measure::norm::{Extremes, distance};
    use experiments::order::{Truth, measure};

    /// A defect four digits above what can be measured as zero is one, whatever the coefficients say.
    #[test]
    fn defects_are_held_to_what_the_coefficients_say() {
        let plain = Traits::new(2, Principle::Equation, Stability::Neutral);
        let keeps = Traits { symplectic: Symplecticity::Always, is_reversible: true, ..plain.clone() };
        let outcomes = |defect: f64, traits: &Traits| {
            let defects = Defects { symplectic: defect, symmetric: defect, open: [0.0; 2] };
            defects.verdicts(traits).map(|verdict| verdict.check.outcome)
        };
        for (defect, kept, not) in [
            (1e-13, Outcome::Pass, Outcome::Inconclusive),
            (1e-8, Outcome::Fail, Outcome::Pass),
            (f64::NAN, Outcome::Fail, Outcome::Fail),
        ] {
            assert_eq!((outcomes(defect, &keeps), outcomes(defect, &plain)), ([kept; 2], [not; 2]), "{defect:e}");
        }
    }

    /// To two digits, above what is left open.
    #[test]
    fn what_is_required_of_a_defect_beyond_rounding_reads_as_a_bound() {
        let plain = Traits::new(2, Principle::Equation, Stability::Neutral);
        for (rounding, text) in
            [(0.0, "> 10⁻¹⁰"), (1e-24, "> 10⁻¹⁰"), (1e-15, "> 1.1×10⁻¹⁰"), (6.408e-10, "> 7.5×10⁻¹⁰")]
        {
            let defects = Defects { symplectic: 1e-3, symmetric: 1e-3, open: [rounding; 2] };
            for verdict in defects.verdicts(&plain) {
                let required = verdict.check.required.expect("a bound");
                assert!(
                    required.to_string() == text
                        && required.bounds().all(|x| x >= (VANISHES + rounding) * (1.0 - 1e-9)),
                    "{required}"
                );
                assert!(verdict.check.reason.ends_with(text), "{}", verdict.check.reason);
            }
        }
    }

    /// What the rounding of the coefficients may have made is neither none nor one of the method; what is not known of it decides nothing.
    #[test]
    fn defects_and_drifts_within_what_rounding_leaves_open_are_not_settled() {
        let plain = Traits::new(2, Principle::Equation, Stability::Neutral);
        let keeps = Traits { symplectic: Symplecticity::Always, is_reversible: true, ..plain.clone() };
        let (pass, fail, open, unsettled) = (Outcome::Pass, Outcome::Fail, Outcome::Inconclusive, Outcome::NotSettled);
        for (defect, rounding, kept, not) in [
            (1e-13, 1e-7, pass, open),
            (1e-8, 1e-7, unsettled, unsettled),
            (1e-6, 1e-7, fail, pass),
            // Within a bound that is rounded up to 7.5·10⁻¹⁰.
            (7.45e-10, 6.408e-10, unsettled, unsettled),
            (1e-8, f64::NAN, open, open),
            (f64::NAN, 1e-7, fail, fail),
        ] {
            let outcomes = |traits: &Traits| {
                let defects = Defects { symplectic: defect, symmetric: defect, open: [rounding; 2] };
                defects.verdicts(traits).map(|verdict| verdict.check.outcome)
            };
            assert_eq!((outcomes(&keeps), outcomes(&plain)), ([kept; 2], [not; 2]), "{defect:e} {rounding:e}");
        }
        // Each by what is left open of its own.
        for (rounding, expected) in [([1e-7, 0.0], [unsettled, fail]), ([0.0, 1e-7], [fail, unsettled])] {
            let defects = Defects { symplectic: 1e-8, symmetric: 1e-8, open: rounding };
            assert_eq!(defects.verdicts(&keeps).map(|verdict| verdict.check.outcome), expected, "{rounding:?}");
        }
        use drift::Kind::{Dissipative, Symplectic};
        for (drift, rounding, kept, not) in [
            (1e-6, 1e-3, pass, unsettled),
            (5e-4, 1e-3, unsettled, unsettled),
            (1e-2, 1e-3, fail, pass),
            (1e-2, f64::NAN, open, open),
        ] {
            let outcome = |kind: drift::Kind| {
                let windows = vec![Window { t: 1.0, mean: 0.0, largest: 1e-3 }];
                let (problem, method, steps) = ("henon-heiles", String::new(), 400);
                let (stderr, momentum) = (1e-6, None);
                let found = Drift { problem, method, kind, steps, windows, drift, stderr, rounding: 0.0, momentum };
                let check = energy_verdict(Ok(Ok(Energy { drift: found, open: rounding }))).check;
                let of_digits = "and the rounding of the coefficients leaves 1.0e-3 of that open";
                assert_eq!(check.reason.contains(of_digits), drift == 5e-4, "{}", check.reason);
                let is_met = check.required.expect("it is looked at").is_met_by(drift);
                assert!(is_met || check.outcome != Outcome::Pass, "{kind:?}, {drift:e}: {check:?}");
                assert!(!is_met || kind == Symplectic || check.outcome != Outcome::NotSettled, "{drift:e}: {check:?}");
                check.outcome
            };
            assert_eq!((outcome(Symplectic), outcome(Dissipative)), (kept, not), "{drift:e} {rounding:e}");
        }
    }

    /// What rounding makes of a defect is said where it is more than what can be measured as zero, and of a defect within it first of all.
    #[test]
    fn what_rounding_makes_of_a_defect_is_told_where_it_matters() {
        let plain = Traits::new(2, Principle::Equation, Stability::Neutral);
        let keeps = Traits { symplectic: Symplecticity::Always, is_reversible: true, ..plain };
        for (defect, open, told) in [
            (1e-13, 1e-7, "1.0e-13, ≤ 10⁻¹⁰"),
            (1e-8, 1e-7, "1.0e-8, and the rounding of the coefficients leaves 1.0e-7 of it open"),
            (1e-6, 1e-7, "1.0e-6, which is to be ≤ 10⁻¹⁰, and the rounding of the coefficients makes 1.0e-7 of it"),
            (1e-6, 1e-11, "1.0e-6, which is to be ≤ 10⁻¹⁰"),
        ] {
            let defects = Defects { symplectic: defect, symmetric: defect, open: [open; 2] };
            for Verdict { check, .. } in defects.verdicts(&keeps) {
                assert!(check.reason.ends_with(told), "{}", check.reason);
            }
        }
    }

    /// Half a unit of the last of seven places times the derivative of the energy behind a step, by differences of its own: where that is
    /// largest along the run, which is not at its start.
    #[test]
    fn a_drift_is_left_open_by_the_step_of_the_run_that_rounding_changes_most() {
        let of = |text: &str| {
            let text = format!("a = [['{text}']]\nb = [1]\n");
            FileMethod::of(&crate::file::MethodFile::parse("m.toml", "m", &text).expect("a method"))
        };
        let problem = problem::build("henon-heiles", &[]).expect("known");
        let energy = problem.invariants().into_iter().find(|i| i.name == "energy").expect("there is one");
        let (h, steps, method) = (0.25, 32, of("0.5000004"));
        let step = |method: &FileMethod, q: &[f64]| step_from(&*problem, q.to_vec(), method, h).expect("it steps");
        let path = std::iter::successors(Some(problem.initial()), |q| Some(step(&method, q)));
        let slope = |q: &Vec<f64>| {
            let [left, right] = ["0.4995004", "0.5005004"].map(|a| energy.value(&step(&of(a), q)));
            ((right - left) / 1e-3).abs()
        };
        let slopes: Vec<f64> = path.take(steps + 1).step_by(2).map(|q| slope(&q)).collect();
        let largest = slopes.iter().copied().largest();
        assert!(largest > 1.1 * slopes[0], "{slopes:?}");
        let expected = steps as f64 * 0.5e-7 * largest;
        let found = open_drift(&*problem, &method, h, steps as u64).expect("it runs");
        // Its own difference is over 10⁻⁶, and that here over 10⁻³, each off by as much of the slope or its square.
        assert!((found / expected - 1.0).abs() < 1e-4, "{found:e} {expected:e}");
    }

    /// The implicit midpoint rule with an a of four units too many in the last of seven and of eight places, of which half a one is left open.
    #[test]
    fn what_rounding_leaves_open_is_in_proportion_to_it_and_bounds_what_it_does() {
        let of = |text: &str| {
            let text = format!("a = [['{text}']]\nb = [1]\n");
            let file = crate::file::MethodFile::parse("m.toml", "m", &text).expect("a method");
            let method = FileMethod::of(&file);
            (defects(&method).expect("it steps"), energy(&method).expect("it runs"))
        };
        let ((six, drift_of_six), (seven, drift_of_seven)) = (of("0.5000004"), of("0.50000004"));
        for (coarse, fine) in
            [(six.open[0], seven.open[0]), (six.open[1], seven.open[1]), (drift_of_six.open, drift_of_seven.open)]
        {
            assert!(fine > 0.0 && (coarse / fine - 10.0).abs() < 1e-2, "{coarse:e} {fine:e}");
        }
        // Eight times what is left open.
        assert!(six.symplectic > six.open[0] && six.symplectic < 9.0 * six.open[0], "{six:?}");
        let (exact, of_exact) = of("1/2");
        assert_eq!((exact.open, of_exact.open), ([0.0; 2], 0.0));
    }

    /// Where a drift is not resolved, what should have none passes, and of what should have one nothing is told.
    #[test]
    fn a_drift_that_does_not_show_confirms_none() {
        let told = |kind: drift::Kind, drift: f64| {
            let windows = vec![Window { t: 1.0, mean: 0.0, largest: 1e-3 }];
            let (stderr, rounding, momentum) = (1e-6, 0.0, None);
            let (problem, method, steps) = ("henon-heiles", String::new(), 400);
            let found = Drift { problem, method, kind, steps, windows, drift, stderr, rounding, momentum };
            let check = energy_verdict(Ok(Ok(Energy { drift: found, open: 0.0 }))).check;
            (check.outcome, check.reason)
        };
        use drift::Kind::{Dissipative, Symplectic};
        let (none, slow, untold) =
            ("no drift is seen", "a drift, which there should be,", "how far it drifts is not told");
        for (drift, kept, not) in [
            (1e-6, (Outcome::Pass, none), (Outcome::NotSettled, slow)),
            (1e-2, (Outcome::Fail, "it drifts by 1.0e-2"), (Outcome::Pass, "it drifts by 1.0e-2")),
            (f64::NAN, (Outcome::Inconclusive, untold), (Outcome::Inconclusive, untold)),
        ] {
            for (kind, (outcome, begins)) in [(Symplectic, kept), (Dissipative, not)] {
                let (found, reason) = told(kind, drift);
                assert!(found == outcome && reason.starts_with(begins), "{drift:e}: {found:?}, {reason}");
            }
        }
    }

    /// Nyström's scheme that is symplectic, with means that once lie on a line, and implicit Euler's, which are on none.
    #[test]
    fn an_oscillation_is_no_drift_and_a_fast_decay_is_one() {
        let of = |text: &str| {
            let file = crate::file::MethodFile::parse("m.toml", "m", text).expect("a method");
            energy_verdict(Ok(energy(&FileMethod::of(&file)))).check
        };
        let nystrom = of("kind = 'nystrom'\na = [['1/100']]\nb_bar = ['7/12']\nb = ['1']\nc = ['5/12']\n");
        assert!(nystrom.outcome == Outcome::Pass && nystrom.reason.starts_with("no drift"), "{nystrom:?}");
        assert!(nystrom.reason.contains("in 16000 steps"), "it is in a longer run: {nystrom:?}");
        let euler = of("a = [['1']]\nb = ['1']\n");
        assert!(euler.outcome == Outcome::Pass && euler.reason.starts_with("it goes one way in all"), "{euler:?}");
    }

    /// What is required of a drift is what decides: none that is resolved of what keeps energy, and one of what does not.
    #[test]
    fn a_drift_passes_where_it_meets_what_is_required_of_it() {
        use drift::Kind::{Dissipative, Symplectic};
        for (kind, drift) in
            [Symplectic, Dissipative].into_iter().flat_map(|kind| [1e-6, 3e-5, 1e-2].map(|drift| (kind, drift)))
        {
            let windows = vec![Window { t: 1.0, mean: 0.0, largest: 1e-3 }];
            let (stderr, rounding, momentum) = (1e-6, 0.0, None);
            let (problem, method, steps) = ("henon-heiles", String::new(), 400);
            let found = Drift { problem, method, kind, steps, windows, drift, stderr, rounding, momentum };
            let Check { outcome, measured, required, reason, .. } =
                energy_verdict(Ok(Ok(Energy { drift: found, open: 0.0 }))).check;
            assert!(reason.ends_with("its error is 1.0e-3 at most"), "{reason}");
            let required = required.expect("it is looked at");
            assert_eq!(measured, Some(drift));
            assert_eq!(required.is_met_by(drift), outcome == Outcome::Pass, "{kind:?}, {drift:e}: {required}");
        }
    }

    /// Of Merson's method to t = 2 the slopes do not settle, however often it is asked, and to t = 4 they do.
    #[test]
    fn an_order_that_settles_over_a_longer_time_is_told_with_that_time() {
        let text = "order = 4\nc = [0, '1/3', '1/3', '1/2', 1]\nb = ['1/6', 0, 0, '2/3', '1/6']\n\
                    a = [[], ['1/3'], ['1/6', '1/6'], ['1/8', 0, '3/8'], ['1/2', 0, '-3/2', 2]]\n";
        let file = crate::file::MethodFile::parse("m.toml", "m", text).expect("a method");
        let (theory, method) = (file.body.analyse(Some(4), None), FileMethod::of(&file).expected(4));
        let plan = || {
            let trial = theory.trials().into_iter().find(|trial| trial.kind == "nonlinear").expect("it has one");
            trial.plan.expect("a problem of the judge")
        };
        let Plan { problem, longer, .. } = plan();
        let short = settled(&method, &*problem, &[plan().problem]).expect("it runs");
        assert_eq!(short.verdict, order::Verdict::Inconclusive, "{}", short.reason);
        let mut over = vec![plan().problem];
        over.extend(longer);
        let fit = settled(&method, &*problem, &over).expect("it runs");
        assert_eq!(fit.verdict, order::Verdict::Pass, "{}", fit.reason);
        assert!(fit.reason.ends_with(", up to t = 4"), "{}", fit.reason);
    }

    /// Explicit Euler leaves Σ b c − ½ = −½ of its condition of order 2: a term ½ h of the error, which is a tenth of an error of 5 h.
    #[test]
    fn an_error_term_is_hidden_where_it_is_less_than_a_tenth_of_every_error() {
        let text = "order = 1\nc = [0]\na = []\nb = [1]\n";
        let method = crate::file::MethodFile::parse("euler.toml", "euler", text).expect("a method");
        let theory = method.body.analyse(None, None);
        let finest = 0.1 / 128.0;
        let of = |times: f64, order: f64, expected: f64| {
            let error = |h: f64| times * 5.0 * finest * (h / finest).powf(order);
            let samples: Vec<_> =
                (0..8).map(|k| finest * f64::from(1 << k)).map(|h| Sample::new(h, error(h), 0.0)).collect();
            let fit = order::fit(&samples, &order::Expectation::new(expected, 0.1));
            assert_eq!(fit.kept.len(), 8, "{}", fit.reason);
            hidden(&*theory, 1, &fit).map(|fit| fit.verdict)
        };
        let open = Some(order::Verdict::Inconclusive);
        assert_eq!([of(1.01, 2.0, 1.0), of(0.99, 2.0, 1.0)], [open, None]);
        // Errors that fall no faster are those of the term, and those that pass need no excuse.
        assert_eq!([of(1e3, 0.5, 1.0), of(1.01, 2.0, 2.0)], [None, None]);
    }

    /// Explicit Euler, its steps by hand.
    #[test]
    fn the_defect_of_symmetry_is_that_of_a_step_and_a_step_back() {
        let text = "order = 1\nc = [0]\na = []\nb = [1]\n";
        let method = crate::file::MethodFile::parse("euler.toml", "euler", text).expect("a method");
        let problem = problem::build("henon-heiles", &[]).expect("known");
        let step = |y: &[f64], h: f64| {
            let mut f = vec![0.0; y.len()];
            problem.ode().rhs(0.0, y, &mut f);
            y.iter().zip(&f).map(|(y, f)| y + h * f).collect::<Vec<f64>>()
        };
        let y = problem.initial();
        let expected = distance(&step(&step(&y, STEP), -STEP), &y);
        let found = defects(&FileMethod::of(&method)).expect("it steps").symmetric;
        assert!(expected > 1e-3 && (found - expected).abs() <= 1e-14, "{found:e} {expected:e}");
    }

    /// Errors of order 6 leave their floor at twice the coarsest step of the plan, and those of order 8 at four times.
    #[test]
    fn a_ladder_at_the_floor_starts_at_twice_the_step_as_often_as_it_takes() {
        let problem = experiments::problem::small("logistic").expect("a problem");
        for (name, times) in [("gauss3", 2.0), ("gauss4", 4.0)] {
            let file = crate::file::Shipped::by_name(name).expect("there").read().expect("well-formed");
            let method = crate::FileMethod::of(&file);
            let planned = experiments::theory::order_plan(&*problem, &method).steps[0];
            let found = measure(&*problem, &method, Truth::Exact).expect("told");
            let coarsest = found.points().iter().map(|(sample, _)| sample.h).largest();
            assert!((coarsest / planned / times - 1.0).abs() < 1e-12, "{name}: {coarsest} for {planned}");
            assert_eq!(found.verdict, order::Verdict::Pass, "{name}: {}", found.reason);
        }
    }
}
