//! The sum of all components of a large system, as the mass in its cells, that an equation conserves and a run does not.

use verify::problem::Problem;
use verify::reference::Ode;

use super::REST;
use super::invariants::{LOOKS, point_beside};
use super::past::Past;
use crate::cli::layout::number;

/// Part of what f moves altogether that is zero but for the rounding of its terms.
const NULL: f64 = 1e-12;

/// What f makes of the sum in all rows.
#[derive(Debug, Clone, Default)]
pub(super) struct Total {
    rate: Vec<f64>,
    /// The largest |Σ f| and Σ |f|.
    sum: f64,
    moved: f64,
}

impl Total {
    pub(super) fn add(&mut self, ode: &dyn Ode, t: f64, state: &[f64]) {
        self.rate.resize(state.len(), 0.0);
        ode.rhs(t, state, &mut self.rate);
        let (sum, moved) = self.rate.iter().fold((0.0, 0.0), |(sum, moved), f| (sum + f, moved + f.abs()));
        // A row at which f has no value tells nothing.
        if moved.is_finite() {
            self.sum = self.sum.max(sum.abs());
            self.moved = self.moved.max(moved);
        }
    }

    /// A sum that f keeps in all rows, at a point beside them, and between them where it depends on time, and that the run has changed by more
    /// than what f is off by.
    pub(super) fn broken(&self, past: &Past, problem: &dyn Problem) -> Option<String> {
        let Past { first, last: (end, last), largest, .. } = past;
        let is_autonomous = problem.ode().is_autonomous() || problem.field().is_autonomous();
        let looks = if is_autonomous { 1 } else { LOOKS };
        let times = (1..=looks).map(|k| end * f64::from(k) / f64::from(looks));
        let beside = point_beside(*largest, first.len());
        let mut seen = self.clone();
        times.for_each(|t| seen.add(problem.ode(), t, &beside));
        let change: f64 = last.iter().zip(first).map(|(b, a)| b - a).sum();
        let is_kept = seen.moved > 0.0 && seen.sum <= NULL * seen.moved;
        (is_kept && change.abs() > REST * largest && change.abs() > 10.0 * NULL * seen.moved * end).then(|| {
            format!(
                "the equation conserves the sum of all components, and the run changed it by {}; a smaller h, or a Runge–Kutta method, which \
                 conserves it, helps",
                number(change)
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::solve::equation::model;

    /// What is said of a run between these states.
    fn told(f: &str, from: [f64; 2], to: [f64; 2]) -> Option<String> {
        let problem = model(&format!("u_i {{ x = 1, y = 0 }} F_i {{ {f} }}"));
        let (past, mut total) = (Past::of(&[(0.0, from), (1.0, to)], None), Total::default());
        [(0.0, from), (1.0, to)].iter().for_each(|(t, state)| total.add(problem.ode(), *t, state));
        total.broken(&past, &problem)
    }

    #[test]
    fn a_total_that_the_equation_keeps_and_the_run_does_not_is_told() {
        let changed = |by: f64| told("-x*y, x*y", [8.0, 1.0], [7.0, 2.0 + by]);
        assert_eq!([changed(0.0), changed(7e-6)], [None, None]);
        let text = changed(0.1).expect("it is broken");
        assert!(text.contains("the sum of all components, and the run changed it by 0.100000"), "{text}");
        // Another sum than that of all.
        assert_eq!(told("-x*y, 2*x*y", [8.0, 1.0], [7.0, 2.0]), None);
        assert_eq!(told("0*x, 0*y", [8.0, 1.0], [7.0, 1.0]), None, "nothing moves");
    }

    /// At rest in both rows, and a pulse or a source between them.
    #[test]
    fn a_total_that_moves_elsewhere_is_not_kept() {
        assert_eq!(told("x*(1 - x), y*(1 - y)", [1.0, 0.0], [1.0, 1.0]), None);
        for f in ["10*heaviside(t - 0.1)*heaviside(0.2 - t)", "6*t*(1 - t)"] {
            assert_eq!(told(&format!("{f} - x, x"), [0.0, 1.0], [1.0, 1.0]), None, "{f}");
        }
    }

    /// Of 7·10⁷ that moves at the point beside, a part 10⁻¹² may be roundings: 7·10⁻⁴ in a unit of time, ten times over.
    #[test]
    fn a_total_changed_by_what_f_may_be_off_by_is_not_broken() {
        let changed = |by: f64| told("-1e9*x + 1e9*y, 1e9*x - 1e9*y", [1.0, 1.0], [1.0, 1.0 + by]).is_some();
        assert_eq!([1e-4, 1e-2].map(changed), [false, true]);
    }
}
