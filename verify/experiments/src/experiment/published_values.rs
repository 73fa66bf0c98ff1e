//! The published end values of stiff problems, and what the adaptive method gives.

use lsvi::adaptive::Tolerances;
use rayon::prelude::*;

use super::{Context, Experiment, StudyError};
use crate::measure::norm::Extremes;
use crate::method;
use crate::problem::{self, Published};
use crate::run::run;

/// All of them.
#[derive(Debug)]
pub struct PublishedValues;

/// One published solution. Digits are those of the component with the fewest.
#[derive(Debug)]
pub struct Solution {
    /// The problem.
    pub problem: String,
    /// Its time.
    pub t: f64,
    /// Where it is published.
    pub source: String,
    /// Number of components.
    pub components: usize,
    /// Digits printed.
    pub printed: usize,
    /// Digits that stand.
    pub stand: f64,
    /// Digits that `radau-adaptive` finds.
    pub found: f64,
    /// Its steps.
    pub steps: u64,
}

impl PublishedValues {
    /// Relative tolerance of the runs; the absolute one is this of the smallest end value, so that every component counts.
    pub const TOLERANCE: f64 = 1e-9;
}

impl Experiment for PublishedValues {
    const ID: &'static str = "published-values";
    type Found = Vec<Solution>;

    fn measure(&self, context: &Context) -> Result<Vec<Solution>, StudyError> {
        let values = problem::published()?;
        // One run for each solution; a problem may have been published twice.
        let groups: Vec<&[Published]> = values.chunk_by(|a, b| a.source == b.source).collect();
        context.announce(groups.len());
        groups.par_iter().map(|values| solution(values).inspect(|_| context.tick())).collect()
    }
}

fn solution(values: &[Published]) -> Result<Solution, StudyError> {
    let first = &values[0];
    let problem = problem::build_setting(&first.problem)?;
    let truth = problem.tabulated(first.t).ok_or("the solution is tabulated")?;
    let smallest = truth.iter().map(|x| x.abs()).smallest();
    let tolerances = Tolerances::new(PublishedValues::TOLERANCE, PublishedValues::TOLERANCE * smallest)?;
    let method = method::parse("radau-adaptive")?.with_tolerances(tolerances).ok_or("it is adaptive")?;
    let run = run(&*problem, &*method, first.t, first.t, |_| {})?;
    let digits = run.end.q.iter().zip(&truth).map(|(found, truth)| -((found - truth) / truth).abs().log10());
    Ok(Solution {
        problem: first.problem.clone(),
        t: first.t,
        source: first.source.clone(),
        components: values.len(),
        printed: values.iter().map(Published::printed_digits).min().unwrap_or(0),
        stand: values.iter().map(|v| v.confirmed_digits().unwrap_or(f64::NAN)).smallest(),
        found: digits.smallest(),
        steps: run.work.steps,
    })
}
