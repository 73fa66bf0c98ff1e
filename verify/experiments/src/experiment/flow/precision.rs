//! Error in time of two cavities, against step size and work.

use super::{Cost, Seconds, cavity_by, lid, log_log, repeated, rms};
use crate::experiment::{Context, Experiment, StudyError};
use crate::measure::norm::max_norm;

/// A cavity whose solution is smooth from the start, or one that is not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flow {
    /// The manufactured solution, at a Reynolds number at which convection matters.
    Manufactured,
    /// Fluid at rest whose lid starts at once.
    Started,
}

impl Flow {
    /// The Reynolds number.
    pub fn re(self) -> f64 {
        match self {
            Self::Manufactured => 1000.0,
            Self::Started => lid::RE,
        }
    }

    /// The end of the runs.
    pub fn end(self) -> f64 {
        match self {
            Self::Manufactured => 1.0,
            Self::Started => 2.0,
        }
    }

    /// The velocities at the end of so many steps.
    fn by(self, method: &str, cells: usize, steps: u32) -> Result<(Vec<f64>, Cost), StudyError> {
        let h = self.end() / f64::from(steps);
        cavity_by(method, self == Self::Manufactured, (self.re(), cells), (h, steps))
    }
}

/// Runs of a method with several step sizes.
#[derive(Debug)]
pub struct FlowPrecision {
    /// Name of the flow.
    pub flow: Flow,
    /// The method, or [`PROJECTION`](super::PROJECTION).
    pub method: &'static str,
    /// Cells along a side.
    pub cells: usize,
}

impl FlowPrecision {
    /// Steps to the end.
    pub const STEPS: [u32; 5] = [4, 8, 16, 32, 64];

    /// Why there are no runs: the factors of Method II are those of twice the unknowns, with the curvature of f.
    fn is_left_out(&self) -> Option<String> {
        const MOST: usize = 32;
        let is_dear = self.method == "method-ii" && self.cells > MOST;
        is_dear.then(|| format!("left out: its factors take minutes on more than {MOST} cells a side"))
    }
}

/// A run.
#[derive(Debug)]
pub struct Point {
    /// Step size.
    pub h: f64,
    /// Root mean square of the difference from RK4 with small steps on the same grid; nothing where a step failed, where it is
    /// above that of the flow itself, and with steps longer than one of those.
    pub error: Option<f64>,
    /// Why it broke off.
    pub failure: Option<String>,
    /// What the run cost.
    pub cost: Cost,
    /// Of the run, repeated.
    pub seconds: Seconds,
}

/// Runs, the longest steps first, and the flow that they are to follow.
#[derive(Debug)]
pub struct Found {
    /// A point for each step size.
    pub points: Vec<Point>,
    /// Root mean square of the velocities at the end.
    pub size: f64,
    /// The largest of them.
    pub speed: f64,
    /// No less than the error of what the runs are held against.
    pub reference_error: f64,
}

impl Found {
    /// Log-log between the runs about it, the error with so many linear systems; `None` beyond them.
    pub fn error_with(&self, solves: f64) -> Option<f64> {
        let known: Vec<(f64, f64)> =
            self.points.iter().filter_map(|p| Some((p.cost.solves as f64, p.error?))).collect();
        log_log(&known, solves)
    }

    /// Seconds of CPU time for an error, log-log between the runs about it; those of the longest steps that hold where these are
    /// more accurate, and `None` where no run is as accurate.
    pub fn seconds_for(&self, error: f64) -> Option<Seconds> {
        let of = |end: fn(&Seconds) -> f64| {
            let known: Vec<(f64, f64)> =
                self.points.iter().rev().filter_map(|p| Some((p.error?, end(&p.seconds)))).collect();
            match known.last() {
                Some((largest, seconds)) if *largest <= error => Some(*seconds),
                _ => log_log(&known, error),
            }
        };
        Some(Seconds { least: of(|s| s.least)?, most: of(|s| s.most)? })
    }
}

/// Takes the errors of runs that lost the flow, and of those with longer steps, which come before them.
fn without_lost(points: &mut [Point], size: f64) {
    let lost = points.iter().rposition(|p| p.error.is_none_or(|error| error.is_nan() || error >= size));
    let kept = lost.map_or(0, |last| last + 1);
    points[..kept].iter_mut().for_each(|p| p.error = None);
}

/// The reference: RK4 with a fourth of the finest step, which is stable on these grids, and a third of what twice that step differs
/// by, no less than its error whatever a jump leaves of the order.
#[derive(Debug)]
struct Truth {
    flow: Flow,
    cells: usize,
}

impl Experiment for Truth {
    const ID: &'static str = "flow-precision-truth";
    type Found = (Vec<f64>, f64);

    fn measure(&self, _: &Context) -> Result<Self::Found, StudyError> {
        let [.., finest] = FlowPrecision::STEPS;
        let by = |steps| self.flow.by("rk4", self.cells, steps);
        let ((coarse, _), (fine, _)) = (by(2 * finest)?, by(4 * finest)?);
        let error = rms(&coarse, &fine) / 3.0;
        Ok((fine, error))
    }
}

impl Experiment for FlowPrecision {
    const ID: &'static str = "flow-precision";
    type Found = Found;

    fn measure(&self, context: &Context) -> Result<Found, StudyError> {
        context.announce(1);
        let Self { flow, method, cells } = *self;
        let reference = context.get(Truth { flow, cells })?;
        let (truth, reference_error) = &*reference;
        let points = Self::STEPS.iter().map(|steps| {
            let h = flow.end() / f64::from(*steps);
            let run = || match self.is_left_out() {
                Some(reason) => Err(reason.into()),
                None => flow.by(method, cells, *steps).map(|(end, cost)| ((end, cost), cost.seconds)),
            };
            match repeated(run) {
                Ok(((end, cost), seconds)) => Point { h, error: Some(rms(&end, truth)), failure: None, cost, seconds },
                Err(error) => {
                    let (failure, seconds) = (Some(error.to_string()), Seconds::NONE);
                    Point { h, error: None, failure, cost: Cost::default(), seconds }
                }
            }
        });
        let mut points: Vec<Point> = points.collect();
        let size = rms(truth, &vec![0.0; truth.len()]);
        without_lost(&mut points, size);
        context.tick();
        Ok(Found { points, size, speed: max_norm(truth), reference_error: *reference_error })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(runs: &[(u64, f64)]) -> Vec<Point> {
        let point = |(solves, error): &(u64, f64)| Point {
            h: 1.0,
            error: Some(*error),
            failure: None,
            cost: Cost { solves: *solves, ..Cost::default() },
            seconds: Seconds::NONE,
        };
        runs.iter().map(point).collect()
    }

    #[test]
    fn a_run_that_lost_the_flow_has_no_error_nor_have_longer_steps() {
        for lost in [2.0, f64::INFINITY, f64::NAN] {
            let mut runs = points(&[(1, 0.5), (2, lost), (4, 0.1)]);
            without_lost(&mut runs, 1.0);
            assert_eq!(runs.iter().map(|p| p.error).collect::<Vec<_>>(), [None, None, Some(0.1)]);
        }
    }

    fn of(points: Vec<Point>) -> Found {
        Found { points, size: 1.0, speed: 1.0, reference_error: 0.0 }
    }

    #[test]
    fn the_time_for_an_error_lies_between_runs_or_is_that_of_the_longest_steps_that_hold() {
        let mut runs = points(&[(1, 0.1), (2, 4e-2), (4, 1e-2)]);
        for (run, seconds) in runs.iter_mut().zip([7.0, 1.0, 2.0]) {
            run.seconds = Seconds { least: seconds, most: 2.0 * seconds };
        }
        runs[0].error = None;
        let found = of(runs);
        let Seconds { least, most } = found.seconds_for(2e-2).expect("between");
        approx::assert_relative_eq!(least, 2.0_f64.sqrt(), max_relative = 1e-12);
        approx::assert_relative_eq!(most, 8.0_f64.sqrt(), max_relative = 1e-12);
        let held = Some(Seconds { least: 1.0, most: 2.0 });
        assert_eq!([0.1, 4e-2, 9e-3].map(|error| found.seconds_for(error)), [held, held, None]);
    }

    #[test]
    fn errors_at_equal_work_lie_on_a_power_law_and_not_beyond_the_runs() {
        let found = of(points(&[(10, 1e-2), (20, 2.5e-3), (40, 6.25e-4)]));
        approx::assert_relative_eq!(found.error_with(30.0).expect("between"), 1.0 / 900.0, max_relative = 1e-12);
        assert_eq!(found.error_with(41.0), None);
    }

    #[test]
    fn the_size_of_a_flow_is_a_root_mean_square_and_its_speed_a_maximum() {
        let context = Context::quick();
        let flow = Flow::Manufactured;
        let found = FlowPrecision { flow, method: "implicit-euler", cells: 4 }.measure(&context).expect("it runs");
        let reference = context.get(Truth { flow, cells: 4 }).expect("it runs");
        let (truth, _) = &*reference;
        let squares: f64 = truth.iter().map(|u| u * u).sum();
        approx::assert_relative_eq!(found.size.powi(2) * truth.len() as f64, squares, max_relative = 1e-12);
        assert!(truth.iter().all(|u| u.abs() <= found.speed) && truth.iter().any(|u| u.abs() == found.speed));
    }

    #[test]
    fn the_error_of_the_reference_is_a_third_of_what_halving_its_steps_changes() {
        let (flow, cells, [.., finest]) = (Flow::Manufactured, 4, FlowPrecision::STEPS);
        let (truth, error) = Truth { flow, cells }.measure(&Context::quick()).expect("it runs");
        let (finer, _) = flow.by("rk4", cells, 8 * finest).expect("it runs");
        // Errors in proportion to h⁴, e of the reference: 15 e / 3 over 15 e / 16, up to terms of the next order.
        approx::assert_relative_eq!(error / rms(&truth, &finer), 16.0 / 3.0, max_relative = 0.1);
    }
}
