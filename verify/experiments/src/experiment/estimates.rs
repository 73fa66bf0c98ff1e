//! The error that is estimated from a finer run beside the one that is known.

use rayon::prelude::*;

use super::orders::Orders;
use super::{Context, Experiment, StudyError};
use crate::estimate::{Estimator, Settling};
use crate::measure::norm::{distance, max_norm};
use crate::measure::order::Verdict;
use crate::run::run;
use crate::theory::order_plan;
use crate::{method, problem};

/// Every method on every problem on which its order is confirmed.
#[derive(Debug)]
pub struct Estimates;

/// One run.
#[derive(Debug)]
pub struct Estimated {
    /// Name of the problem.
    pub problem: String,
    /// Name of the method.
    pub method: String,
    /// Step size.
    pub h: f64,
    /// At the horizon of the order.
    pub error: f64,
    /// `None` where the finer run fails.
    pub estimate: Option<f64>,
    /// Whether the order has settled at this step, as the fit of all steps tells.
    pub is_settled: bool,
    /// What runs with twice and half of the step tell of that, as `solve` does.
    pub settling: Option<Settling>,
}

impl Estimated {
    /// The estimate over the error; NaN without an estimate.
    pub fn ratio(&self) -> f64 {
        self.estimate.map_or(f64::NAN, |estimate| estimate / self.error)
    }

    /// Whether `solve` says that the estimate is coarse.
    #[must_use]
    pub fn is_flagged(&self) -> bool {
        self.settling.is_some_and(|settling| !settling.is_settled())
    }
}

impl Experiment for Estimates {
    const ID: &'static str = "estimates";
    /// For each pair the coarsest step at which its order has settled, and the coarsest at which it has an error.
    type Found = Vec<Estimated>;

    fn measure(&self, context: &Context) -> Result<Self::Found, StudyError> {
        let orders = context.get(Orders)?;
        let mut runs = Vec::new();
        for pair in orders.iter() {
            let Ok(fit) = &pair.fit else { continue };
            let Some(settled) = fit.kept.first().filter(|_| fit.verdict == Verdict::Pass) else { continue };
            let points = fit.points();
            let coarsest = points.iter().map(|(sample, _)| *sample).find(|sample| sample.result.is_ok());
            for (sample, is_settled) in [(Some(settled), true), (coarsest.filter(|s| s.h > settled.h), false)] {
                let Some(sample) = sample else { continue };
                let Ok(measured) = &sample.result else { continue };
                runs.push((pair.problem.as_str(), pair.method.as_str(), sample.h, measured.error, is_settled));
            }
        }
        context.announce(runs.len());
        let one = |(name, by, h, error, is_settled): (&str, &str, f64, f64, bool)| {
            let (problem, method) = (problem::small(name)?, method::parse(by)?);
            let horizon = order_plan(&*problem, &*method).horizon;
            let end = run(&*problem, &*method, h, horizon, |_| {})?.end;
            let mut estimator = Estimator::new(&*problem, &*method, h, horizon)?;
            let difference = estimator.at(end.t).map(|finer| distance(&end.q, finer));
            let estimate = difference.and_then(|difference| estimator.error(difference, max_norm(&end.q)));
            let settling = estimator.settling(&*problem, &*method, &end);
            context.tick();
            Ok(Estimated { problem: name.into(), method: by.into(), h, error, estimate, is_settled, settling })
        };
        runs.into_par_iter().map(one).collect()
    }
}

/// Runs of `radau-adaptive` on a problem with a known solution.
#[derive(Debug)]
pub struct AdaptiveEstimates;

/// One run to its horizon.
#[derive(Debug)]
pub struct Adaptive {
    /// Name of the problem.
    pub problem: &'static str,
    /// Tolerance that is asked for.
    pub tolerance: f64,
    /// Error that is found.
    pub error: f64,
    /// `None` where both tolerances lead to the same steps.
    pub estimate: Option<f64>,
}

impl Adaptive {
    /// The estimate over the error, if there is one.
    pub fn ratio(&self) -> Option<f64> {
        Some(self.estimate? / self.error)
    }
}

impl Experiment for AdaptiveEstimates {
    const ID: &'static str = "adaptive-estimates";
    type Found = Vec<Adaptive>;

    fn measure(&self, context: &Context) -> Result<Self::Found, StudyError> {
        const PROBLEMS: [&str; 6] =
            ["logistic", "damped-pendulum", "van-der-pol", "prothero-robinson", "robertson", "hires"];
        let runs = PROBLEMS.iter().flat_map(|problem| [1e-3, 1e-5, 1e-7].map(|tolerance| (*problem, tolerance)));
        let runs: Vec<_> = runs.collect();
        context.announce(runs.len());
        let one = |(name, tolerance): (&'static str, f64)| {
            let found = adaptive(name, tolerance)?;
            context.tick();
            Ok(found)
        };
        runs.into_par_iter().map(one).collect()
    }
}

fn adaptive(name: &'static str, tolerance: f64) -> Result<Adaptive, StudyError> {
    let problem = problem::build(name, &[])?;
    let horizon = problem.horizon();
    let tolerances = lsvi::adaptive::Tolerances::new(tolerance, 1e-3 * tolerance)?;
    let method = method::parse("radau-adaptive")?;
    let method = method.with_tolerances(tolerances).ok_or("it is adaptive")?;
    let end = run(&*problem, &*method, horizon, horizon, |_| {})?.end;
    let exact = problem.exact(horizon).or_else(|| problem.tabulated(horizon)).ok_or("the solution is known")?;
    let mut estimator = Estimator::new(&*problem, &*method, horizon, horizon)?;
    let difference = estimator.at(end.t).map_or(f64::NAN, |finer| distance(&end.q, finer));
    Ok(Adaptive {
        problem: name,
        tolerance,
        error: distance(&end.q, &exact),
        estimate: estimator.error(difference, max_norm(&end.q)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nine tenths of the error go with a tenth of the tolerances.
    #[test]
    fn the_estimate_of_an_adaptive_run_is_its_difference_from_one_with_a_tenth_of_the_tolerances() {
        let problem = problem::build("logistic", &[]).expect("known");
        let horizon = problem.horizon();
        let ends = [1e-5, 1e-6].map(|tolerance| {
            let tolerances = lsvi::adaptive::Tolerances::new(tolerance, 1e-3 * tolerance).expect("positive");
            let method = method::parse("radau-adaptive").expect("known").with_tolerances(tolerances).expect("adaptive");
            run(&*problem, &*method, horizon, horizon, |_| {}).expect("smooth").end.q
        });
        let found = adaptive("logistic", 1e-5).expect("smooth");
        let estimate = found.estimate.expect("other steps");
        approx::assert_relative_eq!(estimate, distance(&ends[0], &ends[1]) / 0.9, max_relative = 1e-6);
        let exact = problem.exact(horizon).expect("known");
        assert_eq!(found.error, distance(&ends[0], &exact));
    }
}
