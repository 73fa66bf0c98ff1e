//! What `advise` recommends, beside the cheapest of all methods.

use std::sync::Arc;

use super::parts::scope;
use super::{Context, Study, StudyError, prose};
use crate::advise::study::{Advised, Found, Told, is_quick};
use crate::advise::{CLEAR, CONFIRMED, Refusal};
use crate::evidence::number::digits;
use crate::evidence::{Axis, Check, Evidence, Figure, Mark, Outcome, Panel, Series, Table};
use crate::measure::norm::Extremes;
use crate::problem;
use crate::row;

pub(super) const STUDY: Study = Study {
    id: "advice",
    title: "What is advised",
    question: "Is the method that `advise` recommends about the cheapest, and as accurate as it is told to be?",
    source: "`verify advise`, on all problems but the two-dimensional flows",
    run,
};

/// The accuracies that are asked for; of what takes long the first.
const ACCURACIES: [f64; 3] = [1e-3, 1e-5, 1e-7];

/// How many times the work of the cheapest is about the cheapest.
const ABOUT: f64 = 2.0;

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let (mut settings, mut slow) = (Vec::new(), Vec::new());
    for spec in problem::paired() {
        let count = if is_quick(spec.name)? { ACCURACIES.len() } else { 1 };
        slow.extend((count == 1).then(|| format!("`{}`", spec.name)));
        settings.extend(ACCURACIES[..count].iter().map(|accuracy| Advised { problem: spec.name, accuracy: *accuracy }));
    }
    let found = context.get_each(settings.clone())?;
    let all: Vec<(Advised, Arc<Found>)> = settings.into_iter().zip(found).collect();
    let mut notes = notes(&all, &slow)?;
    notes.push(scope(all.iter().map(|(setting, _)| setting.problem)));
    Ok(Evidence {
        checks: all.iter().flat_map(|(setting, found)| checks(setting, found)).collect(),
        figures: vec![figure(&all)],
        tables: vec![table(&all)],
        notes,
        ..Evidence::default()
    })
}

/// What the cases come to, beside the problems at which one accuracy is asked for.
fn notes(all: &[(Advised, Arc<Found>)], slow: &[String]) -> Result<Vec<String>, StudyError> {
    let ratios = all.iter().filter_map(|(_, found)| ratio(found));
    let errors = all.iter().flat_map(|(_, found)| found.told.iter().map(|told| within(told, found.target)));
    let without = || all.iter().filter(|(_, found)| found.refusal.is_some());
    let ties = without().filter(|(_, found)| matches!(found.refusal, Some(Refusal::Tie { .. })));
    let beaten = || all.iter().filter(|(_, found)| is_beaten(found));
    let values = [
        ("cases", all.len().to_string()),
        ("without", without().count().to_string()),
        ("ties", ties.count().to_string()),
        ("beaten", beaten().count().to_string()),
        ("longer", beaten().filter(|(_, found)| has_longer(found)).count().to_string()),
        ("most", digits(ratios.largest(), 3)),
        ("error", digits(errors.largest(), 3)),
        ("slow", slow.join(", ")),
        ("coarse", format!("{:e}", ACCURACIES[0])),
    ];
    prose::fill(include_str!("advice.md"), &values)
}

/// The work of what is told, of a tie the dearer, over that of the cheapest; none where nothing is told.
fn ratio(found: &Found) -> Option<f64> {
    let least = found.cheapest.as_ref().map_or(f64::NAN, |(_, work)| *work);
    (!found.told.is_empty()).then(|| found.told.iter().map(|told| told.work / least).largest())
}

/// Whether the cheapest is of a method that is told.
fn has_longer(found: &Found) -> bool {
    found.cheapest.as_ref().is_some_and(|(method, _)| found.told.iter().any(|told| told.method == *method))
}

/// Whether a run that is not told is cheaper than all that are.
fn is_beaten(found: &Found) -> bool {
    let least = found.told.iter().map(|told| told.work).smallest();
    found.cheapest.as_ref().is_some_and(|(_, work)| *work < least)
}

/// The error of a run, as large as it may be, over what was asked for.
fn within(told: &Told, target: f64) -> f64 {
    (told.remade.size + told.remade.bound) / target
}

fn checks(setting: &Advised, found: &Found) -> Vec<Check> {
    let Advised { problem, accuracy } = setting;
    let id = |what: &str| format!("{what}/{problem}/{accuracy:e}");
    let case = format!("on {problem} for errors of {accuracy:e}");
    let mut checks = Vec::new();
    checks.extend(ratio(found).map(|ratio| {
        let statement = format!("What is advised {case} takes at most twice the work of the cheapest of all methods");
        let reason = "evaluations of f, of a tie those of the dearer; the cheapest counts whether or not its errors follow its order";
        Check::at_most(id("work"), statement, ratio, ABOUT, reason)
    }));
    checks.extend(found.told.iter().map(|told| {
        let Told { method, remade, .. } = told;
        let id = format!("{}/{method}", id("error"));
        let statement = format!("{method} as it is advised {case} is as accurate, against {}", remade.truth);
        let reason = "the error and its bound, in parts of what was asked for; what trials are measured by is known to a tenth of that";
        Check::at_most(id, statement, within(told, found.target), 1.0 + CONFIRMED, reason)
    }));
    checks.extend(found.refusal.as_ref().map(|refusal| {
        let statement = format!("There is a reason for no advice {case}: {refusal}");
        match (refusal, &found.told[..]) {
            (Refusal::Tie { .. }, [first, second]) => {
                let reason = "the work of the one over that of the other";
                Check::at_most(id("none"), statement, second.work / first.work, CLEAR, reason)
            }
            (Refusal::OutOfReach { .. } | Refusal::NotSmooth { .. }, _) => {
                let reason = "runs of all methods that suit which reach the accuracy with errors of their order";
                Check::at_most(id("none"), statement, found.predictable as f64, 0.0, reason)
            }
            _ => Check::undecided(id("none"), statement, Outcome::Inconclusive, "nothing else tells whether it is so"),
        }
    }));
    checks
}

fn figure(all: &[(Advised, Arc<Found>)]) -> Figure {
    let of = |accuracy: f64| {
        let asked = all.iter().filter(|(setting, _)| setting.accuracy == accuracy);
        asked.filter_map(|(_, found)| Some((found.cheapest.as_ref()?.1, ratio(found)?))).collect::<Vec<_>>()
    };
    let works: Vec<f64> = ACCURACIES.iter().flat_map(|accuracy| of(*accuracy)).map(|(work, _)| work).collect();
    let [least, most] = [works.iter().copied().smallest(), works.into_iter().largest()];
    let points = ACCURACIES.map(|accuracy| Series::new(format!("error of {accuracy:e}"), of(accuracy), Mark::Markers));
    let bound = Series::new("twice the cheapest", vec![(least, ABOUT), (most, ABOUT)], Mark::Guide);
    let caption = "The work of what is advised over that of the cheapest method, a point for each problem and accuracy; of a tie that of the dearer.";
    let axes = (Axis::log("work of the cheapest, in evaluations of f"), Axis::linear("ratio of work"));
    Figure::new(
        "advice",
        caption,
        "advice",
        [Panel::new(axes.0, axes.1, points.into_iter().chain([bound]).collect::<Vec<_>>())],
    )
}

fn table(all: &[(Advised, Arc<Found>)]) -> Table {
    let mut rows = Vec::new();
    for (Advised { problem, accuracy }, found) in all {
        let why = found.refusal.as_ref().map(ToString::to_string).unwrap_or_default();
        let (cheapest, least) =
            found.cheapest.as_ref().map_or(("", None), |(method, work)| (method.as_str(), Some(*work)));
        if found.told.is_empty() {
            rows.push(row![*problem, *accuracy, "", None, None, None, None, "", cheapest, least, None, why]);
            continue;
        }
        for told in &found.told {
            let Told { method, steps, work, error, remade } = told;
            let ratio = least.map(|least| work / least);
            let (size, truth) = (remade.size, remade.truth);
            rows.push(row![
                *problem, *accuracy, method, *steps, *work, *error, size, truth, cheapest, least, ratio, &why
            ]);
        }
    }
    let caption = "What is advised for an error relative to the largest component: its steps, its work in evaluations of f, the error that is told \
                   and that of the same run made anew, both absolute, and against what; the cheapest of all methods that suit, its work, and the ratio of the \
                   two; and why no method is recommended, in which case both of a tie are shown.";
    let columns = [
        "problem",
        "accuracy",
        "advised",
        "steps",
        "work",
        "error",
        "remade",
        "truth",
        "cheapest",
        "least_work",
        "ratio",
        "why_none",
    ];
    Table::new("advice", caption, columns, rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::advise::study::Error;

    fn told(method: &str, work: f64, size: f64) -> Told {
        let remade = Error { truth: "exact", size, bound: 0.0 };
        Told { method: method.into(), steps: 4, work, error: size, remade }
    }

    fn outcomes(told: Vec<Told>, refusal: Option<Refusal>, least: f64, predictable: usize) -> Vec<(String, Outcome)> {
        let cheapest = Some(("heun2".into(), least));
        let found = Found { told, refusal, target: 1e-3, cheapest, predictable };
        let setting = Advised { problem: "logistic", accuracy: 1e-3 };
        let kind = |check: Check| (check.id.split('/').next().unwrap_or_default().to_owned(), check.outcome);
        checks(&setting, &found).into_iter().map(kind).collect()
    }

    #[test]
    fn work_and_error_of_what_is_advised_are_held_to_the_cheapest_and_to_what_was_asked_for() {
        let of = |work: f64, size: f64| {
            outcomes(vec![told("rk4", work, size)], None, 10.0, 1)
                .into_iter()
                .map(|(_, outcome)| outcome)
                .collect::<Vec<_>>()
        };
        let (pass, fail) = (Outcome::Pass, Outcome::Fail);
        assert_eq!(of(20.0, 1e-3), [pass, pass]);
        assert_eq!(of(20.1, 1.2e-3), [fail, fail]);
        assert_eq!(of(f64::NAN, f64::NAN), [fail, fail]);
    }

    /// Of a tie one is the cheapest itself.
    #[test]
    fn what_is_told_is_beaten_by_what_is_cheaper_than_all_of_it() {
        let is_beaten_by = |least: f64| {
            let told = vec![told("rk4", 10.0, 1e-4), told("heun2", 10.5, 1e-4)];
            let cheapest = Some(("method".into(), least));
            is_beaten(&Found { told, refusal: None, target: 1e-3, cheapest, predictable: 2 })
        };
        assert_eq!([9.0, 10.0].map(is_beaten_by), [true, false]);
        let has_longer = |method: &str| {
            let (told, cheapest) = (vec![told("rk4", 10.0, 1e-4)], Some((method.into(), 9.0)));
            has_longer(&Found { told, refusal: None, target: 1e-3, cheapest, predictable: 2 })
        };
        assert_eq!(["rk4", "heun2"].map(has_longer), [true, false]);
    }

    #[test]
    fn the_text_tells_the_largest_work_and_the_largest_error() {
        let case = |work: f64, size: f64| {
            let (told, cheapest) = (vec![told("rk4", work, size)], Some(("heun2".into(), 10.0)));
            let found = Found { told, refusal: None, target: 1e-3, cheapest, predictable: 1 };
            (Advised { problem: "logistic", accuracy: 1e-3 }, Arc::new(found))
        };
        let text = notes(&[case(15.0, 2e-4), case(10.0, 3e-4)], &["`robertson`".into()]).expect("filled").join(" ");
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.contains("takes 1.5 times the work") && text.contains("comes to 0.3 times what"), "{text}");
        assert!(text.contains("Of 2 cases") && text.contains("is found in 1,"), "{text}");
    }

    #[test]
    fn every_reason_for_no_advice_is_put_to_the_test_or_left_open() {
        let none = |told: Vec<Told>, refusal: Refusal, predictable: usize| {
            outcomes(told, Some(refusal), 10.0, predictable).pop().expect("a reason")
        };
        let tie = |work: f64| {
            let told = vec![told("rk4", 10.0, 1e-4), told("heun2", work, 1e-4)];
            none(told, Refusal::Tie { first: "rk4".into(), second: "heun2".into() }, 2).1
        };
        assert_eq!([10.9, 11.1].map(tie), [Outcome::Pass, Outcome::Fail]);
        let reach =
            |predictable: usize| none(Vec::new(), Refusal::OutOfReach { accuracy: 1e-3, most: 4 }, predictable).1;
        assert_eq!([0, 1].map(reach), [Outcome::Pass, Outcome::Fail]);
        let smooth = Refusal::NotSmooth { method: "rk4".into(), found: 1.0, nominal: 4 };
        assert_eq!(none(Vec::new(), smooth, 1).1, Outcome::Fail);
        let parting = Refusal::Parting { difference: 1.0, target: 1e-3 };
        assert_eq!(none(Vec::new(), parting, 0), ("none".into(), Outcome::Inconclusive));
    }
}
