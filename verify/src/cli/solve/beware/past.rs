//! What is kept of a run while it is followed.

use verify::measure::norm::{larger, max_norm};
use verify::reference::Ode;

use super::Row;
use crate::cli::solve::equation::DENSE;

/// A step shorter than this part of the one before is cut.
const WHOLE: f64 = 0.999;

/// A time and the state there.
pub(super) type Place = (f64, Vec<f64>);

/// The ends of a run, its last steps and its scales.
#[derive(Debug, Default)]
pub(in crate::cli::solve) struct Past {
    pub(super) first: Vec<f64>,
    /// The end of the first step.
    pub(super) second: Option<Place>,
    /// The last state and the two before.
    pub(super) last: Place,
    pub(super) before: Place,
    pub(super) earlier: Place,
    /// The estimate of the error of the last state.
    pub(super) estimate: Option<f64>,
    /// Largest component of all states, the largest value of each, and how far each went from its first value.
    pub(super) largest: f64,
    pub(super) sizes: Vec<f64>,
    pub(super) moved: Vec<f64>,
}

impl Past {
    pub(super) fn add(&mut self, row: &Row) {
        let Row { t, state, estimate, .. } = *row;
        self.estimate = estimate;
        if self.first.is_empty() {
            self.first = state.to_vec();
            self.sizes = vec![0.0; state.len()];
            self.moved = self.sizes.clone();
        } else if self.second.is_none() {
            self.second = Some((t, state.to_vec()));
        }
        for (k, (x, first)) in state.iter().zip(&self.first).enumerate() {
            self.sizes[k] = larger(self.sizes[k], x.abs());
            self.moved[k] = larger(self.moved[k], (x - first).abs());
        }
        self.largest = larger(self.largest, max_norm(state));
        std::mem::swap(&mut self.before, &mut self.earlier);
        std::mem::swap(&mut self.last, &mut self.before);
        self.last.0 = t;
        self.last.1.clear();
        self.last.1.extend_from_slice(state);
    }

    /// The first state and the last.
    pub(in crate::cli::solve) fn ends(&self) -> (&[f64], &[f64]) {
        (&self.first, &self.last.1)
    }

    /// Whether there is a step between states of `ode`.
    pub(super) fn has_steps_of(&self, ode: &dyn Ode) -> bool {
        ode.dim() == self.last.1.len() && !self.before.1.is_empty()
    }

    /// Whether its derivatives are looked at as a dense matrix.
    pub(super) fn is_small(&self) -> bool {
        self.first.len() <= DENSE
    }

    /// The ends of the last step, or of the one before where the last is cut.
    pub(super) fn last_step(&self) -> [&Place; 2] {
        let is_cut =
            !self.earlier.1.is_empty() && self.last.0 - self.before.0 < WHOLE * (self.before.0 - self.earlier.0);
        if is_cut { [&self.earlier, &self.before] } else { [&self.before, &self.last] }
    }
}

#[cfg(test)]
impl Past {
    pub(super) fn of<const N: usize>(rows: &[(f64, [f64; N])], estimate: Option<f64>) -> Self {
        let mut past = Self::default();
        rows.iter().for_each(|(t, state)| past.add(&Row { t: *t, state, estimate, has_ended: false }));
        past
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn past(times: &[f64]) -> Past {
        let rows: Vec<_> = times.iter().map(|t| (*t, [*t])).collect();
        Past::of(&rows, None)
    }

    /// Of steps of 1 and of parts of it, and of one step alone.
    #[test]
    fn a_last_step_that_is_cut_is_passed_over() {
        let last_step = |times: &[f64]| past(times).last_step().map(|place| place.0);
        assert_eq!(last_step(&[2.0, 3.0, 3.998]), [2.0, 3.0]);
        assert_eq!(last_step(&[2.0, 3.0, 3.9995]), [3.0, 3.9995]);
        assert_eq!(last_step(&[2.0, 3.0, 5.0]), [3.0, 5.0]);
        assert_eq!(last_step(&[2.0, 2.5]), [2.0, 2.5]);
    }

    #[test]
    fn a_run_has_its_ends_its_steps_and_its_scales() {
        let rows = [(0.0, [3.0, -1.0]), (0.5, [-4.0, -1.5]), (1.0, [2.0, 1.0]), (1.5, [2.5, -1.0])];
        let mut past = Past::of(&rows, Some(0.1));
        assert_eq!(past.ends(), (&[3.0, -1.0][..], &[2.5, -1.0][..]));
        assert_eq!(past.second, Some((0.5, vec![-4.0, -1.5])));
        assert_eq!([&past.earlier, &past.before, &past.last].map(|place| place.0), [0.5, 1.0, 1.5]);
        assert_eq!((past.largest, &past.sizes, &past.moved), (4.0, &vec![4.0, 1.5], &vec![7.0, 2.0]));
        assert_eq!(past.estimate, Some(0.1));
        // A row without an estimate has not that of the one before.
        past.add(&Row { t: 2.0, state: &[2.0, -1.0], estimate: None, has_ended: false });
        assert_eq!(past.estimate, None);
    }

    #[test]
    fn a_dense_matrix_has_64_rows_at_most() {
        let is_small = |n: usize| Past { first: vec![0.0; n], ..Past::default() }.is_small();
        assert_eq!([1, 64, 65].map(is_small), [true, true, false]);
    }

    /// Of two steps between states of one component; an equation of two has other states.
    #[test]
    fn a_step_is_one_between_states_of_the_equation() {
        let build = |name: &str| verify::problem::build(name, &[]).expect("registered");
        let (of_one, of_two) = (build("linear-drag"), build("harmonic-oscillator"));
        let has_steps = |times: &[f64]| [&of_one, &of_two].map(|problem| past(times).has_steps_of(problem.ode()));
        assert_eq!([has_steps(&[0.0]), has_steps(&[0.0, 1.0])], [[false, false], [true, false]]);
    }
}
