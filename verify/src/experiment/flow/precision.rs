//! Error in time of the manufactured cavity, against step size and work.

use super::{Cost, cavity_by, log_log, rms};
use crate::experiment::{Context, Experiment, StudyError};
use crate::measure::norm::max_norm;

/// Runs of a method with several step sizes.
#[derive(Debug)]
pub(crate) struct FlowPrecision {
    /// The method, or [`PROJECTION`](super::PROJECTION).
    pub(crate) method: &'static str,
    /// Cells along a side.
    pub(crate) cells: usize,
}

impl FlowPrecision {
    /// The Reynolds number: convection matters.
    pub(crate) const RE: f64 = 1000.0;
    /// Steps to t = 1.
    pub(crate) const STEPS: [u32; 5] = [4, 8, 16, 32, 64];
}

/// A run.
#[derive(Debug)]
pub(crate) struct Point {
    pub(crate) h: f64,
    /// Root mean square of the difference from RK4 with small steps on the same grid; nothing where a step failed, where it is
    /// above that of the flow itself, and with steps longer than one of those.
    pub(crate) error: Option<f64>,
    pub(crate) cost: Cost,
}

/// Runs, the longest steps first, and the flow that they are to follow.
#[derive(Debug)]
pub(crate) struct Found {
    pub(crate) points: Vec<Point>,
    /// Root mean square of the velocities at the end.
    pub(crate) size: f64,
    /// The largest of them.
    pub(crate) speed: f64,
}

impl Found {
    /// Log-log between the runs about it, the error with so many linear systems; `None` beyond them.
    pub(crate) fn error_with(&self, solves: f64) -> Option<f64> {
        let known: Vec<(f64, f64)> =
            self.points.iter().filter_map(|p| Some((p.cost.solves as f64, p.error?))).collect();
        log_log(&known, solves)
    }
}

/// Takes the errors of runs that lost the flow, and of those with longer steps, which come before them.
fn without_lost(points: &mut [Point], size: f64) {
    let lost = points.iter().rposition(|p| p.error.is_none_or(|error| error.is_nan() || error >= size));
    let kept = lost.map_or(0, |last| last + 1);
    points[..kept].iter_mut().for_each(|p| p.error = None);
}

/// The reference: RK4 with a fourth of the finest step, which is stable on these grids.
#[derive(Debug)]
struct Truth {
    cells: usize,
}

impl Experiment for Truth {
    const ID: &'static str = "flow-precision-truth";
    type Found = Vec<f64>;

    fn measure(&self, _: &Context) -> Result<Vec<f64>, StudyError> {
        let [.., finest] = FlowPrecision::STEPS;
        let steps = 4 * finest;
        Ok(cavity_by("rk4", true, (FlowPrecision::RE, self.cells), (1.0 / f64::from(steps), steps))?.0)
    }
}

impl Experiment for FlowPrecision {
    const ID: &'static str = "flow-precision";
    type Found = Found;

    fn measure(&self, context: &Context) -> Result<Found, StudyError> {
        context.announce(1);
        let truth = context.get(Truth { cells: self.cells })?;
        let points = Self::STEPS.iter().map(|steps| {
            let h = 1.0 / f64::from(*steps);
            match cavity_by(self.method, true, (Self::RE, self.cells), (h, *steps)) {
                Ok((end, cost)) => Point { h, error: Some(rms(&end, &truth)), cost },
                Err(_) => Point { h, error: None, cost: Cost::default() },
            }
        });
        let mut points: Vec<Point> = points.collect();
        let size = rms(&truth, &vec![0.0; truth.len()]);
        without_lost(&mut points, size);
        context.tick();
        Ok(Found { points, size, speed: max_norm(&truth) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(runs: &[(u64, f64)]) -> Vec<Point> {
        let point = |(solves, error): &(u64, f64)| Point {
            h: 1.0,
            error: Some(*error),
            cost: Cost { solves: *solves, ..Cost::default() },
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

    #[test]
    fn errors_at_equal_work_lie_on_a_power_law_and_not_beyond_the_runs() {
        let found = Found { points: points(&[(10, 1e-2), (20, 2.5e-3), (40, 6.25e-4)]), size: 1.0, speed: 1.0 };
        approx::assert_relative_eq!(found.error_with(30.0).expect("between"), 1.0 / 900.0, max_relative = 1e-12);
        assert_eq!(found.error_with(41.0), None);
    }

    #[test]
    fn the_size_of_a_flow_is_a_root_mean_square_and_its_speed_a_maximum() {
        let context = Context::quick();
        let found = FlowPrecision { method: "implicit-euler", cells: 4 }.measure(&context).expect("it runs");
        let truth = context.get(Truth { cells: 4 }).expect("it runs");
        let squares: f64 = truth.iter().map(|u| u * u).sum();
        approx::assert_relative_eq!(found.size.powi(2) * truth.len() as f64, squares, max_relative = 1e-12);
        assert!(truth.iter().all(|u| u.abs() <= found.speed) && truth.iter().any(|u| u.abs() == found.speed));
    }
}
