//! CVODE on the same semi-discrete cavity, stated by hand.

use super::{Cost, Seconds, cavity, named, observed, repeated, timed};
use crate::experiment::{Context, Experiment, StudyError};
use crate::measure::norm::distance;
use crate::reference::{self, Work, bound};

/// Method I with three step sizes and CVODE.
#[derive(Debug)]
pub struct AgainstCvode {
    /// Cells along a side.
    pub cells: usize,
}

impl AgainstCvode {
    /// The Reynolds number.
    pub const RE: f64 = 100.0;
    /// The end of the runs.
    pub const END: f64 = 1.0;
    /// Numbers of steps.
    pub(crate) const STEPS: [u32; 3] = [32, 64, 128];
    /// What CVODE is asked for in the finer of its solves.
    pub const TOLERANCE: f64 = bound::FINE;
    /// Powers of ten that it is asked for besides, in quarters: among their errors is one like Method I's.
    const LOOSE: std::ops::RangeInclusive<i32> = -32..=-16;
}

/// A run of CVODE.
#[derive(Debug)]
pub struct Loose {
    /// Tolerance that is asked for.
    pub tolerance: f64,
    /// Work of the run.
    pub work: Work,
    /// Seconds that it took.
    pub seconds: Seconds,
    /// Largest difference of a velocity from its own finest solve.
    pub difference: f64,
}

/// A run of Method I.
#[derive(Debug)]
pub struct Row {
    /// Number of steps.
    pub steps: u32,
    /// What the run cost.
    pub cost: Cost,
    /// Seconds that it took.
    pub seconds: Seconds,
    /// Largest difference of a velocity from CVODE's.
    pub difference: f64,
    /// What the run with twice the step makes it expect of its own error: a third of the difference.
    pub predicted: f64,
}

/// Both.
#[derive(Debug)]
pub struct Found {
    /// A row for each run.
    pub rows: Vec<Row>,
    /// The peer at looser tolerances.
    pub loose: Vec<Loose>,
    /// CVODE's work on the finer of its two solves.
    pub cvode: Work,
    /// The CPU time that one such solve takes.
    pub cvode_seconds: Seconds,
    /// CVODE's bound on its own velocities.
    pub bound: f64,
}

impl Found {
    /// The solve by CVODE whose error is the largest that is not above `error`, where there is one.
    pub fn as_accurate(&self, error: f64) -> Option<&Loose> {
        let enough = self.loose.iter().filter(|run| run.difference <= error);
        enough.max_by(|a, b| a.difference.total_cmp(&b.difference))
    }
}

impl Experiment for AgainstCvode {
    const ID: &'static str = "cavity-against-cvode";
    type Found = Result<Found, String>;

    /// `Err` says why CVODE is not here.
    fn measure(&self, context: &Context) -> Result<Self::Found, StudyError> {
        context.announce(1);
        let problem = cavity(Self::RE, self.cells)?;
        let Some(cvode) = reference::by_name("cvode-bdf") else { return Err("no reference of that name".into()) };
        let (ode, start) = (problem.ode(), problem.initial());
        let found = match cvode.solve(ode, 0.0, &start, &[Self::END]) {
            Ok(found) => found,
            Err(error) => return Ok(Err(error.to_string())),
        };
        let solve = |tolerance: f64| {
            repeated(|| {
                let (run, seconds) = timed(|| cvode.run(ode, 0.0, &start, &[Self::END], tolerance));
                Ok((run?, seconds))
            })
        };
        let (_, cvode_seconds) = solve(Self::TOLERANCE)?;
        let truth = problem.observe(Self::END, &found.states[0]);
        let mut loose = Vec::new();
        for quarters in Self::LOOSE.rev() {
            let tolerance = 10.0_f64.powf(0.25 * f64::from(quarters));
            let (run, seconds) = solve(tolerance)?;
            let end = problem.observe(Self::END, &run.states[0]);
            loose.push(Loose { tolerance, work: run.work, seconds, difference: distance(&end, &truth) });
        }
        let (mut rows, mut last) = (Vec::new(), None::<Vec<f64>>);
        for steps in Self::STEPS {
            let method = named("method-i")?;
            let run = || {
                let (end, cost) = observed(&*problem, &*method, Self::END / f64::from(steps), Self::END)?;
                Ok(((end, cost), cost.seconds))
            };
            let ((end, cost), seconds) = repeated(run)?;
            rows.push(Row {
                steps,
                cost,
                seconds,
                difference: distance(&end, &truth),
                predicted: last.map_or(f64::NAN, |last| distance(&last, &end) / 3.0),
            });
            last = Some(end);
        }
        context.tick();
        Ok(Ok(Found {
            rows,
            loose,
            cvode: found.work,
            cvode_seconds,
            // Differences of ψ, each wrong by the bound, over Δx.
            bound: 2.0 * self.cells as f64 * found.bound[0],
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn predictions_bounds_and_loose_solves_are_what_they_are_called() {
        let cells = 4;
        let found = AgainstCvode { cells }.measure(&Context::quick()).expect("it runs");
        let Ok(found) = found else { return };
        let problem = cavity(AgainstCvode::RE, cells).expect("known");
        let end = |steps: u32| {
            let h = AgainstCvode::END / f64::from(steps);
            observed(&*problem, &*named("method-i").expect("known"), h, AgainstCvode::END).expect("it runs").0
        };
        let [first, ..] = &found.rows[..] else { panic!("no rows") };
        assert!(first.predicted.is_nan());
        for row in &found.rows[1..] {
            let halved = distance(&end(row.steps / 2), &end(row.steps));
            approx::assert_relative_eq!(3.0 * row.predicted, halved, max_relative = 1e-12);
        }
        // A velocity is a difference of two stream functions over Δx = 1/4.
        let cvode = reference::by_name("cvode-bdf").expect("known");
        let solved = cvode.solve(problem.ode(), 0.0, &problem.initial(), &[AgainstCvode::END]).expect("it is here");
        approx::assert_relative_eq!(found.bound, 8.0 * solved.bound[0], max_relative = 1e-12);
        // Each asks for more than the one before, and a decade of tolerance shows in the error.
        let [first, .., last] = &found.loose[..] else { panic!("no looser solves") };
        approx::assert_relative_eq!(first.tolerance, 1e-4, max_relative = 1e-12);
        approx::assert_relative_eq!(last.tolerance, 1e-8, max_relative = 1e-12);
        for runs in found.loose.windows(5) {
            approx::assert_relative_eq!(runs[0].tolerance, 10.0 * runs[4].tolerance, max_relative = 1e-12);
            assert!(runs[4].difference < runs[0].difference && runs[0].difference > found.bound, "{runs:?}");
        }
        // The nearest error from below, not the first.
        let [.., finest] = &found.rows[..] else { panic!("no rows") };
        let chosen = found.as_accurate(finest.difference).expect("one is as accurate");
        let lies_between = |run: &Loose| run.difference > chosen.difference && run.difference <= finest.difference;
        assert!(chosen.difference <= finest.difference && !found.loose.iter().any(lies_between), "{chosen:?}");
        assert!(found.as_accurate(0.0).is_none());
    }
}
