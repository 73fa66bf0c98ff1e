//! What a solver costs at an error: between two of its runs, by a power law.

/// A run of a solver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point {
    /// Its tolerance or number of steps.
    pub(crate) setting: f64,
    /// Its error at the end.
    pub(crate) error: f64,
    /// Its CPU time in seconds.
    pub(crate) seconds: f64,
}

/// Replaces the error of each run by the larger one of it and of the next finer run, so that an error that is small by chance,
/// where it changes sign, is no merit. The runs are ordered from coarse to fine.
pub(crate) fn guarded(mut points: Vec<Point>) -> Vec<Point> {
    for k in 1..points.len() {
        points[k - 1].error = points[k - 1].error.max(points[k].error);
    }
    points
}

/// The two neighbours on the lower envelope of errors and times between which an error lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bracket {
    /// The cheaper of them, with a larger error; nothing where the cheapest run of all is accurate enough.
    pub(crate) coarse: Option<Point>,
    /// The cheapest run whose error is no larger.
    pub(crate) fine: Point,
}

impl Bracket {
    /// That of the error `target`; nothing where no run is accurate enough.
    pub(crate) fn of(points: &[Point], target: f64) -> Option<Self> {
        let accurate = points.iter().filter(|p| p.error <= target);
        let fine = *accurate.min_by(|a, b| a.seconds.total_cmp(&b.seconds))?;
        let cheaper = points.iter().filter(|p| p.error > target && p.error.is_finite() && p.seconds < fine.seconds);
        let coarse = cheaper.min_by(|a, b| a.error.total_cmp(&b.error)).copied();
        Some(Self { coarse, fine })
    }

    /// The time at the error `target`, linear between the two in the logarithms of both.
    pub(crate) fn seconds(&self, target: f64) -> f64 {
        let Self { coarse: Some(coarse), fine } = self else { return self.fine.seconds };
        // What is exact in all digits still has an error of a rounding.
        let finest = fine.error.max(f64::EPSILON);
        let part = (coarse.error / target).ln() / (coarse.error / finest).ln();
        let cheap = coarse.seconds.min(fine.seconds);
        cheap * (fine.seconds / cheap).powf(part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs with n steps of a method of order p: the error n^{−p}, the time n.
    fn power_law(order: f64) -> Vec<Point> {
        (0..40).map(|k| 1.4_f64.powi(k)).map(|n| Point { setting: n, error: n.powf(-order), seconds: n }).collect()
    }

    #[test]
    fn a_power_law_is_interpolated_exactly() {
        for order in [1.0, 2.0, 5.0] {
            for target in [1e-3, 1e-4, 3e-5] {
                let bracket = Bracket::of(&power_law(order), target).expect("it is reached");
                let expected = target.powf(-1.0 / order);
                assert!((bracket.seconds(target) / expected - 1.0).abs() < 1e-12, "order {order} at {target}");
            }
        }
    }

    #[test]
    fn the_cheapest_run_counts_where_all_are_accurate_enough() {
        let bracket = Bracket::of(&power_law(2.0), 10.0).expect("it is reached");
        assert_eq!((bracket.coarse, bracket.seconds(10.0)), (None, 1.0));
    }

    #[test]
    fn what_is_not_reached_has_no_time() {
        let failed = Point { setting: 1.0, error: f64::INFINITY, seconds: 1e-9 };
        assert_eq!(Bracket::of(&[failed], 1e-3), None);
        assert_eq!(Bracket::of(&power_law(1.0), 1e-30), None);
        assert_eq!(Bracket::of(&[], 1.0), None);
    }

    /// A failed run is not the coarse neighbour either.
    #[test]
    fn failures_do_not_help_to_interpolate() {
        let fine = Point { setting: 2.0, error: 1e-6, seconds: 1.0 };
        let failed = Point { setting: 1.0, error: f64::INFINITY, seconds: 1e-9 };
        let bracket = Bracket::of(&[failed, fine], 1e-3).expect("it is reached");
        assert_eq!(bracket.seconds(1e-3), 1.0);
    }

    #[test]
    fn a_dominated_run_does_not_count() {
        let mut points = power_law(2.0);
        points.push(Point { setting: 0.0, error: 5e-4, seconds: 1e6 });
        assert_eq!(Bracket::of(&points, 1e-3), Bracket::of(&power_law(2.0), 1e-3));
    }

    #[test]
    fn an_error_that_is_small_by_chance_is_no_merit() {
        let point = |error, seconds| Point { setting: seconds, error, seconds };
        let points = guarded(vec![point(1e-2, 1.0), point(1e-9, 2.0), point(1e-4, 3.0), point(1e-5, 4.0)]);
        let errors: Vec<f64> = points.iter().map(|p| p.error).collect();
        assert_eq!(errors, [1e-2, 1e-4, 1e-4, 1e-5]);
    }
}
