//! Whether the estimate that `solve` prints is the error.

use super::{Context, Study, StudyError, prose};
use crate::evidence::number::{brief, rounded_down, rounded_up};
use crate::evidence::{Axis, Check, Evidence, Figure, Mark, Panel, Series, Table};
use crate::experiment::estimates::{Adaptive, AdaptiveEstimates, Estimated, Estimates};
use crate::measure::norm::Extremes;
use crate::row;

pub(super) const STUDY: Study = Study {
    id: "estimates",
    title: "Estimates of the error",
    question: "Is the estimate that `solve` prints beside a solution its error at the end of a run?",
    source: "`verify solve`",
    run,
};

/// The factor between estimate and error where the order p ≥ 1 has settled. With a local order of p − ½ to p + ½ over the halving
/// the ratio is between (1 − √2/2^p)/(1 − 1/2^p) ≥ 0.58 and (1 − 1/(√2 2^p))/(1 − 1/2^p) ≤ 1.3; the error's own floor, a tenth, comes on top. It is the
/// factor, too, that an order has to be off for the estimate to be called coarse.
const SETTLED: f64 = 2.0;

/// What the estimate of an adaptive method may fall short by: with a tenth of the tolerance its error may be all but as large. There is
/// no bound on the other side, since an error passes through zero where an estimate need not.
const ADAPTIVE: f64 = 10.0;

/// What an estimate is wrong by, in either direction; NaN for none.
fn factor(ratio: f64) -> f64 {
    if ratio < 1.0 { ratio.recip() } else { ratio }
}

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let found = context.get(Estimates)?;
    let adaptive = context.get(AdaptiveEstimates)?;
    let of = |settled: bool| found.iter().filter(move |run| run.is_settled == settled);
    Ok(Evidence {
        checks: problems(&found)
            .into_iter()
            .map(|problem| check(problem, &found))
            .chain([flagged(&found), tolerances(&adaptive)])
            .collect(),
        figures: vec![figure(&found, &adaptive)],
        tables: vec![table(&found), adaptive_table(&adaptive)],
        notes: notes(&of(true).collect::<Vec<_>>(), &of(false).collect::<Vec<_>>(), &adaptive)?,
        ..Evidence::default()
    })
}

fn problems(found: &[Estimated]) -> Vec<&str> {
    let mut problems: Vec<&str> = found.iter().map(|run| run.problem.as_str()).collect();
    problems.dedup();
    problems
}

fn check(problem: &str, found: &[Estimated]) -> Check {
    let runs = || found.iter().filter(|run| run.is_settled && run.problem == problem);
    let worst = runs().map(|run| factor(run.ratio())).largest();
    let named = runs().find(|run| factor(run.ratio()) == worst).map_or("none", |run| run.method.as_str());
    Check::at_most(
        problem,
        format!("On {problem} the estimate is the error where the order has settled: largest factor between the two"),
        worst,
        SETTLED,
        format!("{} methods, each at the coarsest step of its fit; farthest is {named}", runs().count()),
    )
}

/// Where runs with twice and half of the step show the order, the estimate is right at any step, and where it is not `solve` says so.
fn flagged(found: &[Estimated]) -> Check {
    let trusted = || found.iter().filter(|run| !run.is_flagged());
    Check::at_most(
        "flagged",
        "An estimate that `solve` does not call coarse is the error, at coarse steps too: largest factor between the two",
        trusted().map(|run| factor(run.ratio())).largest(),
        SETTLED,
        format!(
            "{} of {} runs; where errors go by one power of the step that is not far below the order, the estimate is within the factor",
            trusted().count(),
            found.len()
        ),
    )
}

fn tolerances(adaptive: &[Adaptive]) -> Check {
    Check::at_most(
        "radau-adaptive",
        "With tolerances the estimate does not fall far short of the error: largest ratio of error to estimate",
        adaptive.iter().filter_map(|run| run.ratio()).map(f64::recip).largest(),
        ADAPTIVE,
        format!("{} runs that have an estimate", adaptive.iter().filter_map(Adaptive::ratio).count()),
    )
}

fn notes(settled: &[&Estimated], coarse: &[&Estimated], adaptive: &[Adaptive]) -> Result<Vec<String>, StudyError> {
    let within = |runs: &[&Estimated]| runs.iter().filter(|run| factor(run.ratio()) <= SETTLED).count().to_string();
    let ratios = || settled.iter().map(|run| run.ratio());
    let adapted = || adaptive.iter().filter_map(Adaptive::ratio);
    let far = || coarse.iter().map(|run| run.ratio()).filter(|ratio| ratio.is_nan() || factor(*ratio) > SETTLED);
    let smallest = coarse.iter().min_by(|a, b| a.ratio().total_cmp(&b.ratio())).ok_or("no run at a coarse step")?;
    let least = |ratio| brief(rounded_down(ratio, 2));
    let most = |ratio| brief(rounded_up(ratio, 2));
    prose::fill(
        include_str!("estimates.md"),
        &[
            ("settled", within(settled)),
            ("settled_all", settled.len().to_string()),
            ("least", least(ratios().smallest())),
            ("most", most(ratios().largest())),
            ("coarse", within(coarse)),
            ("coarse_all", coarse.len().to_string()),
            ("flagged", coarse.iter().filter(|run| run.is_flagged()).count().to_string()),
            ("flagged_settled", settled.iter().filter(|run| run.is_flagged()).count().to_string()),
            ("far", far().count().to_string()),
            ("far_least", least(far().smallest())),
            ("far_most", most(far().largest())),
            ("smallest", format!("`{}` on `{}`", smallest.method, smallest.problem)),
            ("adaptive_least", least(adapted().smallest())),
            ("adaptive_most", most(adapted().largest())),
            ("adaptive_all", adapted().count().to_string()),
            ("same", adaptive.iter().filter(|run| run.estimate.is_none()).count().to_string()),
        ],
    )
}

fn figure(found: &[Estimated], adaptive: &[Adaptive]) -> Figure {
    let of = |settled: bool| {
        let runs = found.iter().filter(move |run| run.is_settled == settled && run.estimate.is_some());
        runs.map(|run| (run.error, run.ratio())).filter(|(error, _)| *error < 10.0).collect::<Vec<_>>()
    };
    let adapted = adaptive.iter().filter_map(|run| Some((run.error, run.ratio()?))).collect::<Vec<_>>();
    let all = [of(true), of(false), adapted.clone()].concat();
    let [least, most] = [all.iter().map(|point| point.0).smallest(), all.iter().map(|point| point.0).largest()];
    let across = |ratio| vec![(least, ratio), (most, ratio)];
    let series = vec![
        Series::new("coarsest step in which the order has settled", of(true), Mark::Markers),
        Series::new("coarsest step of all, if it has not there", of(false), Mark::Markers),
        Series::new("radau-adaptive", adapted, Mark::Markers),
        Series::new("twice the error", across(SETTLED), Mark::Guide),
        Series::new("half of the error", across(SETTLED.recip()), Mark::Guide),
    ];
    let caption = "Estimate over error at the end of each run, all pairs of method and problem with an order that finer steps confirm. Between the horizontal lines they are within a factor of two \
                   of each other. Errors above 10 are left out.";
    Figure::new(
        "estimates",
        caption,
        "estimates",
        [Panel::new(Axis::log("error"), Axis::log("estimate / error"), series)],
    )
}

fn table(found: &[Estimated]) -> Table {
    let rows = found.iter().map(|run| {
        let settled = if run.is_settled { "settled" } else { "not settled" };
        let flag = if run.is_flagged() { "coarse" } else { "" };
        let observed = run.settling.and_then(|settling| settling.observed);
        row![&run.problem, &run.method, run.h, run.error, run.estimate, run.ratio(), settled, observed, flag]
    });
    let columns = ["problem", "method", "h", "error", "estimate", "ratio", "order", "observed", "flag"];
    Table::data("estimates", "Error and estimate at the end of each run.", columns, rows.collect())
}

fn adaptive_table(adaptive: &[Adaptive]) -> Table {
    let rows = adaptive.iter().map(|run| row![run.problem, run.tolerance, run.error, run.estimate, run.ratio()]);
    let caption = "Error of `radau-adaptive` at the end of a run with this relative tolerance, and the estimate.";
    Table::new("adaptive-estimates", caption, ["problem", "tolerance", "error", "estimate", "ratio"], rows.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::Settling;
    use crate::evidence::Outcome;

    fn estimated(error: f64, estimate: Option<f64>, is_settled: bool) -> Estimated {
        Estimated { problem: "p".into(), method: "m".into(), h: 0.1, error, estimate, is_settled, settling: None }
    }

    #[test]
    fn a_coarse_estimate_is_off_by_more_than_two_with_its_flag_alone() {
        let with = |estimate, observed| {
            let settling = Some(Settling { observed, order: 2.0 });
            Estimated { settling, ..estimated(1.0, estimate, false) }
        };
        let outcome = |run| flagged(&[estimated(1.0, Some(1.0), true), run]).outcome;
        let passes =
            [with(Some(9.0), Some(0.6)), with(Some(9.0), None), with(None, Some(3.3)), with(Some(1.9), Some(2.0))];
        assert_eq!(passes.map(outcome), [Outcome::Pass; 4]);
        let fails = [with(Some(9.0), Some(2.0)), with(None, Some(2.4)), estimated(1.0, Some(0.4), false)];
        assert_eq!(fails.map(outcome), [Outcome::Fail; 3]);
        assert_eq!(flagged(&[with(Some(1.0), None)]).outcome, Outcome::Fail);
    }

    #[test]
    fn an_estimate_is_judged_in_either_direction_and_none_never_passes() {
        let outcome =
            |estimate| check("p", &[estimated(1.0, estimate, true), estimated(1.0, Some(9.0), false)]).outcome;
        assert_eq!([0.6, 1.0, 1.9].map(|estimate| outcome(Some(estimate))), [Outcome::Pass; 3]);
        assert_eq!([Some(0.3), Some(3.0), None].map(outcome), [Outcome::Fail; 3]);
        assert_eq!(check("p", &[]).outcome, Outcome::Fail);

        let adaptive =
            |estimate| tolerances(&[Adaptive { problem: "p", tolerance: 1e-3, error: 1.0, estimate }]).outcome;
        assert_eq!([Some(0.2), Some(50.0)].map(adaptive), [Outcome::Pass; 2]);
        assert_eq!([Some(0.01), None].map(adaptive), [Outcome::Fail; 2]);
        // One that falls short is enough.
        let run = |estimate| Adaptive { problem: "p", tolerance: 1e-3, error: 1.0, estimate: Some(estimate) };
        assert_eq!(tolerances(&[run(1.0), run(0.01), run(1.0)]).outcome, Outcome::Fail);
    }

    #[test]
    fn the_words_count_what_is_within_a_factor_of_two() {
        let mut settled = [estimated(1.0, Some(0.936), true), estimated(1.0, Some(1.21), true)];
        settled[0].settling = Some(Settling { observed: Some(0.6), order: 2.0 });
        let mut coarse = [1.0, 0.2, 8.0].map(|estimate| estimated(1.0, Some(estimate), false));
        for (run, method) in coarse.iter_mut().zip(["exact", "short", "long"]) {
            run.method = method.into();
        }
        let adaptive = [Some(0.5), Some(2.530), None].map(|estimate| Adaptive {
            problem: "p",
            tolerance: 1e-3,
            error: 1.0,
            estimate,
        });
        let notes = notes(&settled.iter().collect::<Vec<_>>(), &coarse.iter().collect::<Vec<_>>(), &adaptive);
        let text = notes.expect("complete").join(" ");
        let between = |low: f64, high: f64| format!("between {} and {} of", brief(low), brief(high));
        for words in [
            format!("2 of 2 estimates lie within a factor of two of the error, {} it", between(0.93, 1.3)),
            format!(
                "1 of 3 estimates lie within a factor of two of the error, and the other 2 {} it",
                between(0.2, 8.0)
            ),
            format!("lies {} the error over 2 runs", between(0.5, 2.6)),
            "there is no estimate: 1.".into(),
            "It calls 0 of these coarse".into(),
            "and 1 of those where the order has settled".into(),
            // The smallest ratio, not the farthest: 8 is farther from one.
            "`short` on `p`".into(),
        ] {
            assert!(text.contains(&words), "{words}\n{text}");
        }
    }
}
